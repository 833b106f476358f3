//! Lumenwalk: walk through a building while its light is still being computed.
//!
//! The library solves the diffuse global illumination of a polygonal scene by radiosity
//! (Cohen & Greenberg 1985, *The Hemi-Cube*). Data walks one way through the modules, in the
//! order in which they stand here; a test reads the sources and keeps it so.

pub mod cli;
pub mod display;
pub mod effects;
pub mod export;
pub mod form_factors;
pub mod geometry;
pub mod mesh;
pub mod render;
pub mod scene;
pub mod session;
pub mod solver;
pub mod ui;
