//! The symmetric scaling that gives every row of exchange areas its sum (Sinkhorn & Knopp 1967).
//!
//! With x the logarithms of the scales it is where the convex function
//! 1/2 sum S_ij exp(x_i + x_j) + 1/2 sum e_i exp(2 x_i) - sum t_i x_i is least. The small self exchange e_i
//! makes that point exist for any rows: what none of the patches that a patch sees can take up, because their
//! own rows are full, stays with it.

use super::gradients;
use crate::watch::{Cancelled, Watch};

/// A patch that is to see less than this share of its area is buried (under a box, say) and inactive.
const BURIED: f64 = 1e-6;
/// Self exchange over area, before scaling: rows that need no more keep a hundred-millionth of themselves.
const SELF_EXCHANGE: f64 = 1e-8;
/// Scaling stops at this deviation of row sums over their patch's area.
const BALANCED: f64 = 1e-7;
/// Passes over the matrix, at most. Real models take up to 120, rows that cannot be balanced 200.
const MOST_PASSES: usize = 1000;
const USUAL_PASSES: f64 = 10.0;
/// So many plain steps come first. They are enough for rooms, but two patches across a narrow gap see mostly
/// each other: what one has too much and the other too little falls but by 1 - F a pass.
const PLAIN_STEPS: usize = 16;
/// Plain steps of the logarithms of scales, and what is kept of the step before (the heavy ball of Polyak 1964).
/// The matrix of their linear equations, 1 + F, has eigenvalues between 0, where two patches see but each
/// other, and 2. These are the best for 0.4 to 2, where those of rooms lie: half the passes of plain steps.
const STEP: f64 = 0.955;
const MOMENTUM: f64 = 0.146;
/// Newton's equations are solved until this share of their right side is left, in so many passes at most.
const FORCING: f64 = 0.1;
const MOST_INNER_PASSES: usize = 50;
/// A logarithm changes by this much in a step of Newton, at most.
const LARGEST_STEP: f64 = 1.0;

/// Scales of the rows and columns of a symmetric matrix, and what they achieve.
#[derive(Debug)]
pub(super) struct Scaling {
    /// One per row: S_ij becomes `scales[i] * scales[j] * S_ij`. 0 for what is buried.
    pub(super) scales: Vec<f64>,
    /// Sums of the scaled rows without what they keep to themselves, m².
    pub(super) sums: Vec<f64>,
    /// Passes over the matrix.
    pub(super) passes: usize,
    /// Largest deviation of a row from its target over its area, what it keeps included.
    pub(super) imbalance: f64,
    /// What rows keep to themselves, as a share of all targets.
    pub(super) kept: f64,
}

/// The matrix as its products, and what its rows are to sum to.
pub(super) struct Balancing<'a> {
    /// Row i times a vector.
    product: &'a (dyn Fn(usize, &[f64]) -> f64 + Sync),
    areas: &'a [f64],
    targets: &'a [f64],
    passes: usize,
}

impl<'a> Balancing<'a> {
    /// `product(i, v)` is row i of a symmetric matrix with an empty diagonal and no negative entries times v;
    /// `targets` are the sums of its rows, m², at most `areas`.
    pub(super) fn new(
        product: &'a (dyn Fn(usize, &[f64]) -> f64 + Sync),
        areas: &'a [f64],
        targets: &'a [f64],
    ) -> Self {
        Self { product, areas, targets, passes: 0 }
    }

    /// Finds the scales.
    ///
    /// # Errors
    /// The watch ended it.
    pub(super) fn solve(mut self, watch: &mut Watch<'_>) -> Result<Scaling, Cancelled> {
        let buried = |(&target, &area): (&f64, &f64)| target <= BURIED * area;
        let mut scales: Vec<f64> =
            self.targets.iter().zip(self.areas).map(|row| if buried(row) { 0.0 } else { 1.0 }).collect();
        let mut sums = self.sums(&scales, watch)?;
        for (scale, &sum) in scales.iter_mut().zip(&sums) {
            // What sees nothing but what is buried passes nothing on.
            *scale = if sum > 0.0 { *scale } else { 0.0 };
        }
        let mut steps = vec![0.0; scales.len()];
        loop {
            let missing = self.missing(&scales, &sums);
            let imbalance = missing.iter().zip(self.areas).map(|(m, a)| m.abs() / a).fold(0.0, f64::max);
            if imbalance < BALANCED || self.passes >= MOST_PASSES {
                let of_all = |values: f64| values / self.targets.iter().sum::<f64>().max(f64::MIN_POSITIVE);
                let kept = of_all((0..scales.len()).map(|i| self.kept(i, scales[i])).sum());
                watch.done(1.0)?;
                return Ok(Scaling { scales, sums, passes: self.passes, imbalance, kept });
            }
            if self.passes <= PLAIN_STEPS {
                for (i, step) in steps.iter_mut().enumerate() {
                    let sum = sums[i] + self.kept(i, scales[i]);
                    let ratio = if scales[i] > 0.0 { self.targets[i] / sum } else { 1.0 };
                    *step = STEP * ratio.clamp(0.25, 4.0).ln() + MOMENTUM * *step;
                }
            } else {
                steps = self.newton_step(&scales, &sums, missing, watch)?;
            }
            scales.iter_mut().zip(&steps).for_each(|(scale, step)| *scale *= step.exp());
            sums = self.sums(&scales, watch)?;
        }
    }

    /// What row i keeps to itself with its scale, m².
    fn kept(&self, i: usize, scale: f64) -> f64 {
        SELF_EXCHANGE * self.areas[i] * scale * scale
    }

    /// Targets less sums, m²; nought for what is inactive.
    fn missing(&self, scales: &[f64], sums: &[f64]) -> Vec<f64> {
        let of_row = |i: usize| {
            if scales[i] > 0.0 { self.targets[i] - sums[i] - self.kept(i, scales[i]) } else { 0.0 }
        };
        (0..scales.len()).map(of_row).collect()
    }

    /// The matrix scaled on both sides by `scales`, times ones: one pass.
    fn sums(&mut self, scales: &[f64], watch: &mut Watch<'_>) -> Result<Vec<f64>, Cancelled> {
        self.scaled_product(scales, scales, watch)
    }

    /// Rows scaled by `scales` times a vector that holds the scales of columns: one pass.
    fn scaled_product(
        &mut self,
        scales: &[f64],
        vector: &[f64],
        watch: &mut Watch<'_>,
    ) -> Result<Vec<f64>, Cancelled> {
        // Most scenes need about a quarter of the passes at which this says that half is done.
        let share = self.passes as f64 / (self.passes as f64 + USUAL_PASSES);
        self.passes += 1;
        let product = self.product;
        watch.part(share, share).map(scales, |i, scale| scale * product(i, vector))
    }

    /// An inexact step of Newton: (D + M) d = missing with M the scaled matrix and D its row sums, by
    /// conjugate gradients preconditioned with D, which few narrow gaps hardly slow down.
    fn newton_step(
        &mut self,
        scales: &[f64],
        sums: &[f64],
        missing: Vec<f64>,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<f64>, Cancelled> {
        // What is inactive has nothing missing, and so no step.
        let diagonal: Vec<f64> = (0..scales.len())
            .map(|i| if scales[i] > 0.0 { sums[i] + 2.0 * self.kept(i, scales[i]) } else { 1.0 })
            .collect();
        let preconditioned =
            |v: &[f64]| -> Vec<f64> { v.iter().zip(&diagonal).map(|(v, d)| v / d).collect() };
        let image = |direction: &[f64]| {
            let columns: Vec<f64> = direction.iter().zip(scales).map(|(d, s)| d * s).collect();
            let mut image = self.scaled_product(scales, &columns, watch)?;
            image.iter_mut().zip(&diagonal).zip(direction).for_each(|((v, d), x)| *v += d * x);
            Ok(image)
        };
        let mut step = gradients::solved(missing, (FORCING, MOST_INNER_PASSES), preconditioned, image)?;
        step.iter_mut().for_each(|s| *s = s.clamp(-LARGEST_STEP, LARGEST_STEP));
        Ok(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs with their exchange areas, balanced.
    fn balanced(areas: &[f64], pairs: &[(usize, usize, f64)], targets: &[f64]) -> (Scaling, Vec<Vec<f64>>) {
        let n = areas.len();
        let mut matrix = vec![vec![0.0; n]; n];
        for &(i, j, value) in pairs {
            (matrix[i][j], matrix[j][i]) = (value, value);
        }
        let product = |i: usize, v: &[f64]| matrix[i].iter().zip(v).map(|(s, v)| s * v).sum();
        let scaling =
            Watch::nobody(|watch| Balancing::new(&product, areas, targets).solve(watch)).expect("whole");
        let scaled = |i: usize, j: usize| scaling.scales[i] * scaling.scales[j] * matrix[i][j];
        let exchange = (0..n).map(|i| (0..n).map(|j| scaled(i, j)).collect()).collect();
        (scaling, exchange)
    }

    #[test]
    fn narrow_gaps_are_balanced_as_well_as_rooms() {
        // Six walls that see each other, and two plates that see each other by 98 %.
        let mut pairs = vec![(6, 7, 0.98)];
        for i in 0..6 {
            pairs.extend((i + 1..6).map(|j| (i, j, 0.2)));
            pairs.extend([(i, 6, 0.006), (i, 7, 0.001)]);
        }
        let (scaling, exchange) = balanced(&[1.0; 8], &pairs, &[1.0; 8]);
        assert!(scaling.imbalance < 1e-7 && scaling.kept < 1e-7, "{scaling:?}");
        assert!(scaling.passes < 60, "{} passes", scaling.passes);
        for row in &exchange {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 2e-7, "{row:?}");
        }
    }

    #[test]
    fn what_no_partner_can_take_up_stays_where_it_is() {
        // A patch of 2 m² that sees but one of 0.5 m², which sees the room too: at most 0.5 m² of exchange.
        let mut pairs = vec![(6, 7, 0.4), (7, 0, 0.05), (7, 1, 0.02)];
        for i in 0..6 {
            pairs.extend((i + 1..6).map(|j| (i, j, 0.2)));
        }
        let areas = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 0.5];
        let (scaling, exchange) = balanced(&areas, &pairs, &areas);
        assert!(scaling.imbalance < 1e-7 && scaling.passes < 200, "{scaling:?}");
        assert!((exchange[6][7] - 0.5).abs() < 1e-3, "{}", exchange[6][7]);
        assert!((scaling.kept - 1.5 / 8.5).abs() < 1e-3, "{}", scaling.kept);
        for (i, row) in exchange.iter().enumerate().filter(|(i, _)| *i != 6) {
            assert!((row.iter().sum::<f64>() - areas[i]).abs() < 1e-3, "row {i}: {row:?}");
        }
    }

    #[test]
    fn buried_patches_and_those_that_see_nothing_else_are_inactive() {
        let pairs = [(0, 1, 0.4), (0, 2, 0.4), (1, 2, 0.4), (3, 4, 0.9), (0, 3, 0.1)];
        let (scaling, exchange) = balanced(&[1.0; 6], &pairs, &[1.0, 1.0, 1.0, 0.0, 1.0, 1.0]);
        assert_eq!(scaling.scales[3..], [0.0; 3]);
        assert!(scaling.imbalance < 1e-7, "{scaling:?}");
        assert!((exchange[0][1] + exchange[0][2] - 1.0).abs() < 1e-6, "{exchange:?}");
    }
}
