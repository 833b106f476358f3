//! How light passes between patches: sampled rows made into one reciprocal, closed operator.
//!
//! [`FormFactors::assemble`] makes the rows reciprocal, replaces what one centre point gets wrong about
//! close neighbours by closed forms, and closes the power balance.

mod balancing;
mod dense;
mod near;
mod quality;

pub use dense::{AssembleReport, FormFactors};
pub use quality::RowQuality;
