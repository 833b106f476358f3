//! Where the picture is wrong: an estimate for every patch from what the witness found at some.

use super::audit::Checked;
use crate::mesh::PatchMesh;

/// Signs of error that a patch shows by itself, squared, relative to its light (the mean at least): how far the
/// picture changes on it, how far the picture departs from its own value, and its irradiance.
pub(super) type Signs = [f64; 3];

/// The error of the picture on every patch: its root mean square over the patch, relative to the light there (the mean
/// at least).
///
/// Only a sample of patches was measured. The map follows what the picture shows (its change within a
/// patch, its departure from the patch' value, its brightness), weighted so as to fit the squares that
/// the witness found; where the witness asked nearby on the same surface, what it found there counts
/// beside that, and so does what it found on the same object: a few patches beside a lamp that hold most of
/// the total must not make all others look as bad. As a whole it is scaled so that its mean square over the
/// receiving area is that of the total. It tells where to look; the number of a single patch is uncertain by a factor of two or so.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorMap {
    /// A share of the light of each patch; NaN for those that shine or lie buried.
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
/// Squares count up to so many times what is expected of them in the fit; what is more belongs to its place.
const OUTLIER: f64 = 8.0;

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
    let mut squares: Vec<f64> =
        (0..patches.len()).map(|i| if counts[i] { square(i) } else { f64::NAN }).collect();
    let object = |i: usize| mesh.regions[patches[i].region as usize].object as usize;
    let factors = by_object(&squares, receivers, &object);
    for (i, square) in squares.iter_mut().enumerate() {
        *square *= factors.get(object(i)).copied().unwrap_or(1.0);
    }
    let (mut sum, mut area) = (0.0, 0.0);
    for (patch, s) in patches.iter().zip(&squares).filter(|(_, s)| s.is_finite()) {
        sum += patch.area * s;
        area += patch.area;
    }
    let scale = if sum > 0.0 { total * total * area / sum } else { 0.0 };
    ErrorMap { error: squares.into_iter().map(|s| (s * scale).sqrt() as f32).collect() }
}

/// What was found on each object over what the map has for the same receivers, drawn to one as if by
/// [`TRUST`] further receivers that found what was expected.
fn by_object(squares: &[f64], receivers: &[Checked], object: &dyn Fn(usize) -> usize) -> Vec<f64> {
    let mut sums: Vec<[f64; 3]> = Vec::new();
    for r in receivers {
        let (i, at) = (r.patch as usize, object(r.patch as usize));
        if sums.len() <= at {
            sums.resize(at + 1, [0.0; 3]);
        }
        if squares[i].is_finite() {
            let [found, had, count] = &mut sums[at];
            *found += r.weight * r.square;
            *had += r.weight * squares[i];
            *count += 1.0;
        }
    }
    let factor = |[found, had, count]: [f64; 3]| {
        let prior = TRUST * had / count;
        ((found + prior) / (had + prior)).max(LEAST_RATIO)
    };
    sums.into_iter().map(|sum| if sum[1] > 0.0 { factor(sum) } else { 1.0 }).collect()
}

fn dot(a: Signs, b: Signs) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Weights of the signs, zero or above, by which their sum is nearest to the squares found: least
/// squares of the relative difference, one sign at a time, with the scatter of each square taken as
/// proportional to the square that the round before expects there, and squares far beyond that cut.
fn fit(signs: &[Signs], receivers: &[Checked]) -> Signs {
    let of = |weights: Signs, r: &Checked| dot(weights, signs[r.patch as usize]);
    // To begin with, all signs weigh alike, and so much that half of the squares are larger.
    let mut ratios: Vec<f64> =
        receivers.iter().map(|r| r.square / of([1.0; 3], r)).filter(|ratio| ratio.is_finite()).collect();
    ratios.sort_by(f64::total_cmp);
    let middle = ratios.get(ratios.len() / 2).copied().unwrap_or(1.0);
    let mut weights: Signs = [if middle > 0.0 { middle } else { 1.0 }; 3];
    for _ in 0..ROUNDS {
        let typical = receivers.iter().map(|r| r.weight * of(weights, r)).sum::<f64>()
            / receivers.iter().map(|r| r.weight).sum::<f64>().max(f64::MIN_POSITIVE);
        if typical <= 0.0 {
            break;
        }
        let mut matrix = [[0.0; 3]; 3];
        let mut right = [0.0; 3];
        for r in receivers {
            let expected = of(weights, r).max(0.02 * typical);
            let x = signs[r.patch as usize];
            let w = r.weight / (expected * expected);
            for a in 0..3 {
                right[a] += w * x[a] * r.square.clamp(-OUTLIER * expected, OUTLIER * expected);
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
    }
    // Where noise leaves nothing to fit, the picture's own change is what there is.
    if weights.iter().all(|&w| w <= 0.0) { [1.0, 0.0, 0.0] } else { weights }
}

#[cfg(test)]
mod tests {
    use super::super::sobol::unit;
    use super::*;

    #[test]
    fn what_is_found_on_an_object_stays_there() {
        let squares = [1.0; 40];
        let receivers: Vec<Checked> = (0..40)
            .map(|k| {
                let square = if k < 10 { 500.0 } else { 1.0 };
                Checked { patch: k, weight: 1.0 / 40.0, square, ..Checked::default() }
            })
            .collect();
        let factors = by_object(&squares, &receivers, &|i| usize::from(i >= 10) + usize::from(i >= 38));
        assert!((400.0..500.0).contains(&factors[0]) && (factors[1] - 1.0).abs() < 1e-12, "{factors:?}");
    }

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
        // A few places that are a thousand times worse than their signs say are their own affair.
        let mut spoilt = receivers.clone();
        spoilt.iter_mut().step_by(50).for_each(|r| r.square *= 1000.0);
        let weights = fit(&signs, &spoilt);
        assert!((0.1..1.0).contains(&weights[0]) && (1.0..5.0).contains(&weights[1]), "{weights:?}");
        let nothing = vec![Checked { square: -1.0, weight: 1.0, ..Checked::default() }; 8];
        assert_eq!(fit(&signs, &nothing), [1.0, 0.0, 0.0]);
    }
}
