//! The power-balance correction: the small system that the slow errors of Gauss-Seidel obey.
//!
//! Near reflectance 1 the error that sweeps remove last is almost constant over a room. With P the
//! piecewise constant aggregation of patches and A their areas, the correction P e with
//! (Pᵀ A (I - rho F) P) e = Pᵀ A r removes it at once; r is the residual.

use super::System;
use crate::form_factors::FormFactors;
use crate::mesh::PatchMesh;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// At most this many aggregates: a dense system of this size is solved in milliseconds.
const MOST_AGGREGATES: usize = 256;
/// Of these, sides large enough to stand for themselves.
const MOST_SINGLE: usize = 192;
/// Blocks of a side along each of its axes, at most.
const MOST_BLOCKS: f64 = 4.0;

/// Which aggregate each patch belongs to.
#[derive(Clone, Debug, Default)]
pub(super) struct Aggregates {
    pub(super) of_patch: Vec<u32>,
    pub(super) count: usize,
}

impl Aggregates {
    /// Blocks of the sides of regions, since one floor may run through several rooms; in large scenes
    /// whole sides, the smaller of which share one a cell of space.
    pub(super) fn new(mesh: &PatchMesh) -> Self {
        let mut areas: BTreeMap<(u32, u8), f64> = BTreeMap::new();
        for p in &mesh.patches {
            *areas.entry((p.region, p.side as u8)).or_default() += p.area;
        }
        let mut sides: Vec<((u32, u8), f64)> = areas.into_iter().collect();
        let all = sides.len() <= MOST_AGGREGATES;
        sides.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        if !all {
            sides.truncate(MOST_SINGLE);
        }
        let blocks =
            if all { (MOST_AGGREGATES as f64 / sides.len().max(1) as f64).sqrt().floor() } else { 1.0 };
        let blocks = blocks.min(MOST_BLOCKS);
        let single: BTreeSet<(u32, u8)> = sides.iter().map(|s| s.0).collect();
        let cells = ((MOST_AGGREGATES - MOST_SINGLE) as f64).cbrt().floor();
        let bounds = crate::geometry::Aabb::around(mesh.patches.iter().map(|p| p.centre));
        let step = (bounds.size() / cells).max(DVec3::splat(f64::MIN_POSITIVE));
        let mut index_of: BTreeMap<[i64; 5], u32> = BTreeMap::new();
        let of_patch: Vec<u32> = mesh
            .patches
            .iter()
            .map(|p| {
                let key = if single.contains(&(p.region, p.side as u8)) {
                    let region = &mesh.regions[p.region as usize];
                    let local = region.frame.local(p.centre - region.origin).truncate() - region.grid_min;
                    let extent =
                        region.cell_size * DVec2::new(region.cells[0].into(), region.cells[1].into());
                    let block =
                        (local / extent * blocks).floor().clamp(DVec2::ZERO, DVec2::splat(blocks - 1.0));
                    [1, p.region.into(), p.side as i64, block.x as i64, block.y as i64]
                } else {
                    let cell = ((p.centre - bounds.min) / step).floor().min(DVec3::splat(cells - 1.0));
                    [0, 0, cell.x as i64, cell.y as i64, cell.z as i64]
                };
                let next = index_of.len() as u32;
                *index_of.entry(key).or_insert(next)
            })
            .collect();
        Self { of_patch, count: index_of.len() }
    }
}

/// The factorised aggregated systems, one a band.
#[derive(Clone, Debug, Default)]
pub(super) struct PowerBalance {
    factors: Vec<Lu>,
}

impl PowerBalance {
    pub(super) fn new(form_factors: &FormFactors, system: &System, aggregates: &Aggregates) -> Self {
        const CHUNKS: usize = 8;
        let (n, k) = (system.patches(), aggregates.count);
        let size = n.div_ceil(CHUNKS).max(1);
        // Chunks of fixed borders, added in order: the same bits whatever the thread count.
        let partial: Vec<Vec<Vec<f64>>> = (0..n.div_ceil(size))
            .into_par_iter()
            .map(|chunk| {
                let mut sums = vec![vec![0.0; k * k]; system.bands];
                let mut seen = vec![0.0; k];
                for i in chunk * size..((chunk + 1) * size).min(n) {
                    seen.fill(0.0);
                    // What sees nothing keeps B = E, and must not soak up the correction.
                    if !form_factors.sees(i) {
                        continue;
                    }
                    let (columns, values) = form_factors.row(i);
                    for (&j, &s) in columns.iter().zip(values) {
                        seen[aggregates.of_patch[j as usize] as usize] += f64::from(s);
                    }
                    let own = aggregates.of_patch[i] as usize;
                    seen[own] += form_factors.diagonal(i);
                    for (band, sum) in sums.iter_mut().enumerate() {
                        let rho = system.reflectance[i][band];
                        let row = &mut sum[own * k..(own + 1) * k];
                        for (entry, &s) in row.iter_mut().zip(&seen) {
                            *entry -= rho * s;
                        }
                        row[own] += system.areas[i];
                    }
                }
                sums
            })
            .collect();
        let factors = (0..system.bands)
            .map(|band| {
                let mut matrix = vec![0.0; k * k];
                for chunk in &partial {
                    for (sum, part) in matrix.iter_mut().zip(&chunk[band]) {
                        *sum += part;
                    }
                }
                Lu::new(matrix, k)
            })
            .collect();
        Self { factors }
    }

    /// Turns the aggregated residual power of one column, W, into the correction of each aggregate.
    pub(super) fn correct(&self, band: usize, power: &mut [f64]) {
        self.factors[band].solve(power);
    }
}

/// LU factors of a dense matrix with partial pivoting.
#[derive(Clone, Debug)]
struct Lu {
    size: usize,
    values: Vec<f64>,
    pivots: Vec<usize>,
}

impl Lu {
    /// The matrix is diagonally dominant: a pivot vanishes only with its whole row, where an aggregate
    /// sees nothing.
    fn new(mut a: Vec<f64>, n: usize) -> Self {
        let mut pivots = Vec::with_capacity(n);
        for c in 0..n {
            let pivot =
                (c..n).max_by(|&x, &y| a[x * n + c].abs().total_cmp(&a[y * n + c].abs())).unwrap_or(c);
            pivots.push(pivot);
            if pivot != c {
                for k in 0..n {
                    a.swap(c * n + k, pivot * n + k);
                }
            }
            let (upper, lower) = a.split_at_mut((c + 1) * n);
            let top = &upper[c * n..];
            if top[c] == 0.0 {
                continue;
            }
            for row in lower.chunks_exact_mut(n) {
                let factor = row[c] / top[c];
                row[c] = factor;
                if factor != 0.0 {
                    for k in c + 1..n {
                        row[k] -= factor * top[k];
                    }
                }
            }
        }
        Self { size: n, values: a, pivots }
    }

    fn solve(&self, b: &mut [f64]) {
        let n = self.size;
        for (c, &pivot) in self.pivots.iter().enumerate() {
            b.swap(c, pivot);
        }
        for r in 1..n {
            b[r] -= (0..r).map(|k| self.values[r * n + k] * b[k]).sum::<f64>();
        }
        for r in (0..n).rev() {
            let sum: f64 = (r + 1..n).map(|k| self.values[r * n + k] * b[k]).sum();
            let pivot = self.values[r * n + r];
            b[r] = if pivot == 0.0 { 0.0 } else { (b[r] - sum) / pivot };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lu_solves_a_system_that_needs_pivoting() {
        // [[0, 2], [3, 1]] x = (4, 5) has x = (1, 2).
        let mut b = [4.0, 5.0];
        Lu::new(vec![0.0, 2.0, 3.0, 1.0], 2).solve(&mut b);
        assert!((b[0] - 1.0).abs() < 1e-15 && (b[1] - 2.0).abs() < 1e-15);
    }
}
