//! What further sweeps would still change.

use super::Estimate;
use crate::mesh::Translucence;
use crate::scene::luminance_weighted;
use crate::solver::{PatchLight, gathered};
use crate::transport::Transport;

/// The solver's own error, relative to the mean irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AlgebraicError {
    /// Root mean square of what is missing; the upper end holds a geometric tail.
    pub estimate: Estimate,
    /// Guaranteed: largest residual of any band / (1 - max rho_i sum_j F_ij), as irradiance.
    pub bound: f64,
}

/// Gatherings at most.
const MOST: usize = 24;
/// Gathering ends when the tail that is left is this part of the sum.
const TAIL: f64 = 0.05;

/// Estimates the algebraic error of a solution by gathering on from it.
///
/// With dH the change of irradiance that one more gathering brings, the error is the sum over all
/// further ones, dH + F rho dH + (F rho)² dH + ...: summed until the tail, of ratio q between the last
/// two terms, is small, and q / (1 - q) of the last term is added to the interval. The residual of the
/// equation is rho dH, so its bound is that of the solver's reports.
///
/// `counts` tells the patches over which the mean square is taken; `mean` is the mean luminance of
/// irradiance there, W/m². Works on any thread; one pass over the rows a term.
pub fn algebraic_error(
    transport: &dyn Transport,
    light: &PatchLight,
    (reflectance, translucence): (&[[f32; 3]], &Translucence),
    counts: &[bool],
    mean: f64,
) -> AlgebraicError {
    let n = transport.len();
    if n == 0 || light.irradiance.len() != n || light.radiosity.len() != n || mean <= 0.0 {
        return AlgebraicError::default();
    }
    let rho = |i: usize| reflectance.get(i).map_or([0.0; 3], |r| r.map(f64::from));
    let share = |i: usize| translucence.leaving(i, rho(i), |_| [1.0; 3]);
    let mut term: Vec<[f64; 3]> = gathered(transport, (reflectance, translucence), light)
        .iter()
        .zip(&light.irradiance)
        .map(|(after, before)| std::array::from_fn(|b| after[b] - f64::from(before[b])))
        .collect();

    let contraction =
        (0..n).map(|i| transport.row_sum(i) * share(i).into_iter().fold(0.0, f64::max)).fold(0.0, f64::max);
    let largest = term.iter().flatten().map(|d| d.abs()).fold(0.0, f64::max);
    let bound = largest / (1.0 - contraction).max(1e-12) / mean;

    let area: f64 = (0..n).filter(|&i| counts[i]).map(|i| transport.area(i)).sum();
    let rms = |field: &[[f64; 3]]| {
        let sum: f64 = (0..n)
            .filter(|&i| counts[i])
            .map(|i| transport.area(i) * luminance_weighted(field[i]).powi(2))
            .sum();
        (sum / area.max(f64::MIN_POSITIVE)).sqrt() / mean
    };
    let mut sum = term.clone();
    let mut last = rms(&term);
    let mut tail = 0.0;
    for _ in 0..MOST {
        let source: Vec<[f64; 3]> = (0..n).map(|i| translucence.leaving(i, rho(i), |j| term[j])).collect();
        term = transport.gather_bands(&source);
        for (s, d) in sum.iter_mut().zip(&term) {
            (0..3).for_each(|b| s[b] += d[b]);
        }
        let size = rms(&term);
        // The slowest error takes over bit by bit: the ratio rises towards its own.
        let ratio = if last > 0.0 { (size / last).clamp(0.0, contraction.min(0.999)) } else { 0.0 };
        tail = size * ratio / (1.0 - ratio);
        last = size;
        if tail <= TAIL * rms(&sum) {
            break;
        }
    }
    let error = rms(&sum);
    AlgebraicError {
        estimate: Estimate { error, low: (error - tail).max(0.0), high: error + tail },
        bound: bound.max(error),
    }
}
