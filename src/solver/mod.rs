//! Gauss-Seidel over the stored rows, one basis a luminaire, with a power-balance correction.
//!
//! A [`System`] holds what every basis shares: reflectances and the emission of each luminaire at
//! unit output. While form factors arrive, [`Shooter`] lights it row by row, or [`Refiner`] refines a
//! light that it has already; [`GaussSeidel`] brings it to convergence once all are there.

mod balance;
mod bases;
mod gauss_seidel;
mod refiner;
mod residual;
mod shooter;
mod system;

pub use bases::{Detail, LightBases, PatchLight, Power, direct_bases, patch_emission, photometric_power};
pub use gauss_seidel::{GaussSeidel, columns_read};
pub use refiner::Refiner;
pub use residual::{gathered, residual};
pub use shooter::Shooter;
pub use system::System;

/// What one sweep reports, for the lamps as they come with the scene (all of them at unit white
/// output where none is lit).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepReport {
    /// Counted from 1.
    pub sweep: u32,
    /// Largest residual of any patch and basis relative to the largest radiosity that any patch reflects
    /// in that basis.
    pub residual: f64,
    /// Guaranteed bound on the largest error of any patch, relative in the same way:
    /// residual / (1 - max rho_i sum_j F_ij).
    pub error_bound: f64,
    /// Power emitted, W.
    pub emitted: f64,
    /// Power absorbed by surfaces, W.
    pub absorbed: f64,
    /// Power that leaves through openings, W.
    pub escaped: f64,
    /// Seconds since the sweeps began.
    pub seconds: f64,
}
