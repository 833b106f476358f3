//! Hard cases: scenes that break solvers, each held to the laws that any scene obeys, by every
//! method, at a usual and at a high quality; and the same laws on random scenes.

#[path = "../common/mod.rs"]
mod common;
mod beside_lamps;
mod furniture;
mod geometry;
mod laws;
mod orientation;
mod random;
mod reflectance;
mod sampling;
