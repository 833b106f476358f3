//! Lumenwalk: walk through a building while its light is still being computed.
//!
//! The library solves the diffuse global illumination of a polygonal scene by radiosity
//! (Cohen & Greenberg 1985, *The Hemi-Cube*). Data walks one way through the modules, in the
//! order in which they stand here; a test reads the sources and keeps it so.

pub mod watch;
pub mod memory;
pub mod geometry;
pub mod encoding;
pub mod photometry;
pub mod glazing;
pub mod daylight;
pub mod scene;
pub mod mesh;
pub mod effects;
pub mod visibility;
pub mod emitters;
pub mod direct;
pub mod form_factors;
pub mod transport;
pub mod solver;
pub mod accuracy;
pub mod solve;
pub mod session;
pub mod validate;
pub mod display;
pub mod navigation;
pub mod render;
pub mod export;
pub mod outputs;
pub mod study;
pub mod ui;
pub mod cli;
