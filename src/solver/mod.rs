//! Gauss-Seidel over the stored rows, one basis a luminaire, with a power-balance correction.

mod bases;

pub use bases::{LightBases, PatchLight, patch_emission};

/// What one sweep reports, summed over bands and lamps as they come with the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepReport {
    /// Counted from 1.
    pub sweep: u32,
    /// Largest residual of any patch relative to the largest radiosity.
    pub residual: f64,
    /// Guaranteed bound on the relative error: residual / (1 - max rho_i sum_j F_ij).
    pub error_bound: f64,
    /// Power emitted, W.
    pub emitted: f64,
    /// Power absorbed by surfaces, W.
    pub absorbed: f64,
    /// Power that leaves through openings, W.
    pub escaped: f64,
    /// Seconds since the solve began.
    pub seconds: f64,
}
