//! The two scalings that give rows and columns of exchange areas their sums (Sinkhorn & Knopp 1967).
//!
//! Row i of S is what patch i receives, column j what patch j sends; both are to come to the same, t. With r = exp x
//! and, for any r, c such that the columns are met, x is where a convex function is least whose gradient is what the
//! rows have too much (the dual of matching with entropy): plain steps of the two scalings go there along the
//! gradient, and Newton's, with conjugate gradients on the Schur complement of the columns, where those are slow. The small
//! self exchange e makes a solution exist for any rows: what others cannot take up stays.

use crate::transport::gradients;
use crate::watch::{Cancelled, Watch};

/// A patch that is to see less than this share of its area is buried and inactive.
const BURIED: f64 = 1e-6;
/// Self exchange over area, before scaling.
const SELF_EXCHANGE: f64 = 1e-8;
/// Scaling stops at this deviation of row sums over their patch's area: well below what the power balance of bright
/// rooms is to be kept to.
const BALANCED: f64 = 1e-9;
/// Passes over the rows, at most.
const MOST_PASSES: usize = 1000;
const USUAL_PASSES: f64 = 30.0;
/// So many plain steps come first.
const PLAIN_STEPS: usize = 6;
/// Newton's equations are solved until this share of their right side is left, in so many steps at most.
const FORCING: f64 = 0.02;
const MOST_INNER_STEPS: usize = 60;
/// A logarithm changes by this much in a step, at most.
const LARGEST_STEP: f64 = 1.5;

/// Rows of exchange areas, m², without their diagonal.
pub(super) trait Exchange: Sync {
    /// Each row times a value per sender.
    fn forward(&self, senders: &[f64]) -> Vec<f64>;

    /// Each column times a value per receiver.
    fn transposed(&self, receivers: &[f64]) -> Vec<f64>;
}

/// The scales of rows and columns, and what they achieve.
#[derive(Debug, Default)]
pub(super) struct Scalings {
    /// S_ij becomes `receivers[i] * senders[j] * S_ij`; 0 for what is inactive.
    pub(super) receivers: Vec<f64>,
    pub(super) senders: Vec<f64>,
    /// What patches keep to themselves, m².
    pub(super) own: Vec<f64>,
    /// Sums of the scaled rows with that, m².
    pub(super) sums: Vec<f64>,
    /// Passes over the rows.
    pub(super) passes: usize,
    /// Largest deviation of a row from its target over its area; columns are met.
    pub(super) imbalance: f64,
    /// What patches keep to themselves, as a share of all targets.
    pub(super) kept: f64,
}

struct Balancing<'a> {
    exchange: &'a dyn Exchange,
    areas: &'a [f64],
    targets: &'a [f64],
    passes: usize,
}

/// Scales the rows and columns of `exchange` to these sums, m², at most `areas`.
///
/// # Errors
/// The watch ended it.
pub(super) fn scaled(
    exchange: &dyn Exchange,
    areas: &[f64],
    targets: &[f64],
    watch: &mut Watch<'_>,
) -> Result<Scalings, Cancelled> {
    Balancing { exchange, areas, targets, passes: 0 }.solve(watch)
}

impl Balancing<'_> {
    fn solve(mut self, watch: &mut Watch<'_>) -> Result<Scalings, Cancelled> {
        let n = self.areas.len();
        // 1. What sees nothing, or nothing but what is inactive, is inactive.
        let mut active: Vec<bool> = (0..n).map(|i| self.targets[i] > BURIED * self.areas[i]).collect();
        loop {
            let ones: Vec<f64> = active.iter().map(|&active| f64::from(u8::from(active))).collect();
            let sums = self.forward(&ones, watch)?;
            let mut changed = false;
            for (active, sum) in active.iter_mut().zip(sums) {
                changed |= *active && sum <= 0.0;
                *active &= sum > 0.0;
            }
            if !changed {
                break;
            }
        }
        let targets: Vec<f64> = (0..n).map(|i| if active[i] { self.targets[i] } else { 0.0 }).collect();
        let own: Vec<f64> = self.areas.iter().map(|area| SELF_EXCHANGE * area).collect();
        let mut r: Vec<f64> = active.iter().map(|&active| f64::from(u8::from(active))).collect();
        let mut steps = 0;
        loop {
            // 2. Columns are met, whatever the rows.
            let columns = self.transposed(&r, watch)?;
            let c: Vec<f64> = (0..n)
                .map(|j| if active[j] { targets[j] / (columns[j] + own[j] * r[j]) } else { 0.0 })
                .collect();
            let rows = self.forward(&c, watch)?;
            let kept: Vec<f64> = (0..n).map(|i| r[i] * own[i] * c[i]).collect();
            let sums: Vec<f64> = (0..n).map(|i| r[i] * rows[i] + kept[i]).collect();
            let missing: Vec<f64> = targets.iter().zip(&sums).map(|(t, s)| t - s).collect();
            let imbalance = missing.iter().zip(self.areas).map(|(m, a)| m.abs() / a).fold(0.0, f64::max);
            if imbalance < BALANCED || self.passes >= MOST_PASSES {
                watch.done(1.0)?;
                let all = targets.iter().sum::<f64>().max(f64::MIN_POSITIVE);
                let passes = self.passes;
                let share = kept.iter().sum::<f64>() / all;
                return Ok(Scalings {
                    receivers: r,
                    senders: c,
                    own: kept,
                    sums,
                    passes,
                    imbalance,
                    kept: share,
                });
            }
            // 3. Rows are brought nearer to theirs.
            let change: Vec<f64> = if steps < PLAIN_STEPS {
                let ratio = |i: usize| if active[i] { targets[i] / sums[i] } else { 1.0 };
                (0..n).map(|i| ratio(i).ln()).collect()
            } else {
                self.newton_step((&r, &c, &sums, &targets), (&own, missing), watch)?
            };
            steps += 1;
            r.iter_mut().zip(&change).for_each(|(r, d)| *r *= d.clamp(-LARGEST_STEP, LARGEST_STEP).exp());
        }
    }

    fn told(&mut self, watch: &mut Watch<'_>) -> Result<(), Cancelled> {
        self.passes += 1;
        watch.done(self.passes as f64 / (self.passes as f64 + USUAL_PASSES))
    }

    fn forward(&mut self, senders: &[f64], watch: &mut Watch<'_>) -> Result<Vec<f64>, Cancelled> {
        self.told(watch)?;
        Ok(self.exchange.forward(senders))
    }

    fn transposed(&mut self, receivers: &[f64], watch: &mut Watch<'_>) -> Result<Vec<f64>, Cancelled> {
        self.told(watch)?;
        Ok(self.exchange.transposed(receivers))
    }

    /// With M the scaled matrix, R and T its row and column sums: (R - M T⁻¹ Mᵀ) d = missing, by conjugate gradients
    /// preconditioned with R.
    fn newton_step(
        &mut self,
        (r, c, sums, targets): (&[f64], &[f64], &[f64], &[f64]),
        (own, missing): (&[f64], Vec<f64>),
        watch: &mut Watch<'_>,
    ) -> Result<Vec<f64>, Cancelled> {
        let n = r.len();
        let preconditioned = |v: &[f64]| -> Vec<f64> {
            v.iter().zip(sums).map(|(v, s)| if *s > 0.0 { v / s } else { 0.0 }).collect()
        };
        let image = |direction: &[f64]| {
            let sent: Vec<f64> = r.iter().zip(direction).map(|(r, d)| r * d).collect();
            let columns = self.transposed(&sent, watch)?;
            let means: Vec<f64> =
                (0..n)
                    .map(|j| {
                        if targets[j] > 0.0 {
                            c[j] * (columns[j] + own[j] * sent[j]) / targets[j]
                        } else {
                            0.0
                        }
                    })
                    .collect();
            let back: Vec<f64> = c.iter().zip(&means).map(|(c, m)| c * m).collect();
            let rows = self.forward(&back, watch)?;
            Ok((0..n).map(|i| sums[i] * direction[i] - r[i] * (rows[i] + own[i] * back[i])).collect())
        };
        gradients::solved(missing, (FORCING, MOST_INNER_STEPS), preconditioned, image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Dense(Vec<Vec<f64>>);

    impl Exchange for Dense {
        fn forward(&self, senders: &[f64]) -> Vec<f64> {
            self.0.iter().map(|row| row.iter().zip(senders).map(|(s, v)| s * v).sum()).collect()
        }

        fn transposed(&self, receivers: &[f64]) -> Vec<f64> {
            (0..self.0.len()).map(|j| self.0.iter().zip(receivers).map(|(row, v)| row[j] * v).sum()).collect()
        }
    }

    fn balanced(matrix: Vec<Vec<f64>>, areas: &[f64], targets: &[f64]) -> (Scalings, Vec<Vec<f64>>) {
        let exchange = Dense(matrix);
        let found = Watch::nobody(|watch| scaled(&exchange, areas, targets, watch)).expect("whole");
        let n = areas.len();
        let scaled = |i: usize, j: usize| {
            let own = if i == j { found.own[i] } else { 0.0 };
            found.receivers[i] * found.senders[j] * exchange.0[i][j] + own
        };
        let matrix = (0..n).map(|i| (0..n).map(|j| scaled(i, j)).collect()).collect();
        (found, matrix)
    }

    /// Numbers between 0 and 1 without a pattern.
    fn number(k: usize) -> f64 {
        (0.618_033_988_75 * (k * k + 3 * k) as f64).fract()
    }

    #[track_caller]
    fn both_are_met(matrix: &[Vec<f64>], targets: &[f64], within: f64) {
        for (i, &target) in targets.iter().enumerate() {
            let row: f64 = matrix[i].iter().sum();
            let column: f64 = matrix.iter().map(|row| row[i]).sum();
            assert!((row - target).abs() < within, "row {i} sums to {row}, not {target}");
            assert!((column - target).abs() < within, "column {i} sums to {column}, not {target}");
        }
    }

    #[test]
    fn rows_and_columns_are_met_where_samples_disagree() {
        let n = 24;
        let matrix = (0..n)
            .map(|i| (0..n).map(|j| if i == j { 0.0 } else { 0.5 + number(31 * i + j) }).collect())
            .collect();
        let areas: Vec<f64> = (0..n).map(|i| 0.5 + number(i)).collect();
        let targets: Vec<f64> =
            areas.iter().enumerate().map(|(i, a)| a * (0.7 + 0.3 * number(i + 5))).collect();
        let (found, scaled) = balanced(matrix, &areas, &targets);
        both_are_met(&scaled, &targets, 1e-8);
        assert!(found.imbalance < 1e-9 && found.kept < 1e-6 && found.passes < 60, "{found:?}");
    }

    #[test]
    fn rooms_that_see_little_of_each_other_are_balanced_soon() {
        // Two rooms and a slit between them through which one sees more of the other than is seen back.
        let n = 16;
        let matrix = (0..n)
            .map(|i| {
                let factor = |j: usize| match (i / 8 == j / 8, i < 8) {
                    _ if i == j => 0.0,
                    (true, _) => (0.5 + number(17 * i + j)) / 8.0,
                    (false, true) => 2e-4,
                    (false, false) => 1e-4,
                };
                (0..n).map(factor).collect()
            })
            .collect();
        let (found, scaled) = balanced(matrix, &[1.0; 16], &[1.0; 16]);
        both_are_met(&scaled, &[1.0; 16], 1e-8);
        assert!(found.passes < 120, "{} passes", found.passes);
    }

    #[test]
    fn what_no_other_can_take_up_stays_and_what_sees_nothing_is_inactive() {
        // Patch 0 of 2 m² sees but patch 1 of 0.5 m²; patch 5 sees nothing.
        let mut matrix = vec![vec![0.0; 6]; 6];
        (matrix[0][1], matrix[1][0]) = (0.4, 0.4);
        for i in 1..5 {
            for j in (1..5).filter(|&j| j != i) {
                matrix[i][j] = 0.3;
            }
        }
        matrix[3][5] = 0.1;
        let areas = [2.0, 0.5, 1.0, 1.0, 1.0, 1.0];
        let (found, scaled) = balanced(matrix, &areas, &areas);
        assert_eq!((found.receivers[5], found.senders[5], found.sums[5]), (0.0, 0.0, 0.0));
        assert!(found.imbalance < 1e-9, "{found:?}");
        both_are_met(&scaled[..5].iter().map(|row| row[..5].to_vec()).collect::<Vec<_>>(), &areas[..5], 1e-7);
        assert!(scaled[0][0] > 1.4, "{}", scaled[0][0]);
    }
}
