//! Where the picture is wrong: an estimate for every patch from what the witness found at some.

use super::audit::Checked;
use crate::mesh::PatchMesh;

/// Signs of error that a patch shows by itself, squared, relative to the mean irradiance: how far the
/// picture changes on it, how far the picture departs from its own value, and its irradiance.
pub(super) type Signs = [f64; 3];

/// The error of the picture on every patch: its root mean square over the patch, relative to the mean
/// irradiance of the scene.
///
/// Only a sample of patches was measured. The map follows what the picture shows (its change within a
/// patch, its departure from the patch' value, its brightness), weighted so as to fit the squares that
/// the witness found; where the witness asked nearby on the same surface, what it found there counts
/// beside that. As a whole it is scaled so that its mean square over the receiving area is that of the
/// total. It tells where to look; the number of a single patch is uncertain by a factor of two or so.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorMap {
    /// A share of the mean irradiance for each patch; NaN for those that shine or lie buried.
    pub error: Vec<f32>,
}

/// What the fit is worth beside receivers nearby, in receivers.
const TRUST: f64 = 1.5;
/// A receiver tells of patches as far away as this, in edges of a patch.
const REACH: f64 = 2.0;
/// Rounds of fitting with weights from the round before, and steps of each.
const ROUNDS: usize = 6;
const STEPS: usize = 200;
/// Factors of the fit's squares that one receiver may tell of, and that all nearby may bring it down to:
/// a square is a product of noisy deviations, and may be negative.
const RATIOS: [f64; 2] = [-1.0, 50.0];
const LEAST_RATIO: f64 = 0.1;

/// The map; `total` is the error that its mean square over the patches that count is to match.
pub(super) fn map(
    mesh: &PatchMesh,
    counts: &[bool],
    signs: &[Signs],
    receivers: &[Checked],
    total: f64,
) -> ErrorMap {
    let patches = &mesh.patches;
    let weights = fit(signs, receivers);
    let fitted = |i: usize| dot(weights, signs[i]).max(f64::MIN_POSITIVE);
    let mut nearby: Vec<Vec<&Checked>> = vec![Vec::new(); 2 * mesh.regions.len()];
    let face = |i: usize| 2 * patches[i].region as usize + patches[i].side as usize;
    for receiver in receivers {
        nearby[face(receiver.patch as usize)].push(receiver);
    }
    let square = |i: usize| {
        let patch = &patches[i];
        let reach2 = REACH * REACH * patch.area;
        let (mut ratio, mut trust) = (TRUST, TRUST);
        for r in &nearby[face(i)] {
            let other = r.patch as usize;
            let far2 = patches[other].centre.distance_squared(patch.centre) / reach2.max(f64::MIN_POSITIVE);
            if far2 < 9.0 {
                let weight = (-far2).exp();
                ratio += weight * (r.square / fitted(other)).clamp(RATIOS[0], RATIOS[1]);
                trust += weight;
            }
        }
        fitted(i) * (ratio / trust).max(LEAST_RATIO)
    };
    let squares: Vec<f64> =
        (0..patches.len()).map(|i| if counts[i] { square(i) } else { f64::NAN }).collect();
    let (mut sum, mut area) = (0.0, 0.0);
    for (patch, s) in patches.iter().zip(&squares).filter(|(_, s)| s.is_finite()) {
        sum += patch.area * s;
        area += patch.area;
    }
    let scale = if sum > 0.0 { total * total * area / sum } else { 0.0 };
    ErrorMap { error: squares.into_iter().map(|s| (s * scale).sqrt() as f32).collect() }
}

fn dot(a: Signs, b: Signs) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Weights of the signs, zero or above, by which their sum is nearest to the squares found: least
/// squares of the relative difference, one sign at a time, with the scatter of each square taken as
/// proportional to the square that the round before expects there.
fn fit(signs: &[Signs], receivers: &[Checked]) -> Signs {
    let mut expected: Vec<f64> = vec![1.0; receivers.len()];
    let mut weights: Signs = Signs::default();
    for round in 0..ROUNDS {
        let mut matrix = [[0.0; 3]; 3];
        let mut right = [0.0; 3];
        for (r, expected) in receivers.iter().zip(&expected) {
            let x = signs[r.patch as usize];
            let w = r.weight / (expected * expected);
            for a in 0..3 {
                right[a] += w * x[a] * r.square;
                for b in 0..3 {
                    matrix[a][b] += w * x[a] * x[b];
                }
            }
        }
        for _ in 0..STEPS {
            for a in 0..3 {
                if matrix[a][a] > 0.0 {
                    let others: f64 = (0..3).filter(|&b| b != a).map(|b| matrix[a][b] * weights[b]).sum();
                    weights[a] = ((right[a] - others) / matrix[a][a]).max(0.0);
                }
            }
        }
        if round + 1 < ROUNDS {
            let of = |r: &Checked| dot(weights, signs[r.patch as usize]);
            let typical = receivers.iter().map(|r| r.weight * of(r)).sum::<f64>()
                / receivers.iter().map(|r| r.weight).sum::<f64>().max(f64::MIN_POSITIVE);
            if typical <= 0.0 {
                break;
            }
            expected = receivers.iter().map(|r| of(r).max(0.02 * typical)).collect();
        }
    }
    // Where noise leaves nothing to fit, the picture's own change is what there is.
    if weights.iter().all(|&w| w <= 0.0) { [1.0, 0.0, 0.0] } else { weights }
}

#[cfg(test)]
mod tests {
    use super::super::sobol::unit;
    use super::*;

    #[test]
    fn the_fit_finds_which_sign_the_squares_follow() {
        let signs: Vec<Signs> =
            (0..200).map(|k| [unit(3 * k), unit(3 * k + 1).powi(4), unit(3 * k + 2)]).collect();
        let receivers: Vec<Checked> = (0..200_u32)
            .map(|k| {
                let truth = 0.3 * signs[k as usize][0] + 2.0 * signs[k as usize][1];
                // A factor of mean one.
                let square = truth * 2.0 * unit(9000 + u64::from(k));
                Checked { patch: k, weight: 1.0 / 200.0, square, ..Checked::default() }
            })
            .collect();
        let weights = fit(&signs, &receivers);
        assert!((weights[0] - 0.3).abs() < 0.15, "{weights:?}");
        assert!((weights[1] - 2.0).abs() < 0.7, "{weights:?}");
        assert!(weights[2] < 0.1, "{weights:?}");
        let nothing = vec![Checked { square: -1.0, weight: 1.0, ..Checked::default() }; 8];
        assert_eq!(fit(&signs, &nothing), [1.0, 0.0, 0.0]);
    }
}
