//! How the error is spread over the area: what half of it stays below, and where most of it sits.

use super::audit::Checked;
use crate::mesh::PatchMesh;

/// Errors relative to the light at each place, up to which shares of the area are told.
pub const LEVELS: [f64; 3] = [0.01, 0.05, 0.1];

/// Darker places than this part of the mean irradiance are measured against this.
pub const DARKEST: f64 = 0.1;

/// A share or a quantile with the 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ranged {
    /// The estimate.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The part of the scene that holds most of the mean square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dominant {
    /// Index into the scene's objects.
    pub object: u32,
    /// Its share of the mean square of the total error, 0 to 1.
    pub share: f64,
    /// Its share of the receiving area, 0 to 1.
    pub area: f64,
    /// The patch of it that weighs most among those asked.
    pub patch: u32,
}

/// How the error of the picture is spread over the receiving area.
///
/// Here errors are relative to the irradiance at each place itself ([`DARKEST`] of the mean at least),
/// so that a few bright places beside lamps count by their area alone. The witness' noise counts as
/// error: shares are rather too low than too high.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Half of the area is off by less.
    pub median: Ranged,
    /// Shares of the area that are off by less than [`LEVELS`].
    pub within: [Ranged; LEVELS.len()],
    /// Where most of the total error (of the mean) sits; `None` where there is none.
    pub dominant: Option<Dominant>,
}

/// Quantile of the normal distribution for 95 % between both tails.
const Z: f64 = 1.959_963_984_540_054;

/// From the receivers asked. Shares by Hájek's estimator with Wilson's interval at the effective number
/// of receivers (Kish), quantiles by inverting them (Woodruff 1952). `counts` tells the receiving patches.
pub(super) fn spread(receivers: &[Checked], mesh: &PatchMesh, counts: &[bool]) -> Spread {
    let mut sorted: Vec<(f64, f64)> = receivers.iter().map(|r| (r.of_light.abs(), r.weight)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sum: f64 = sorted.iter().map(|s| s.1).sum();
    let squares: f64 = sorted.iter().map(|s| s.1 * s.1).sum();
    if !(sum > 0.0 && squares > 0.0) {
        return Spread::default();
    }
    let effective = sum * sum / squares;
    let below = |level: f64| {
        let inside: f64 = sorted.iter().take_while(|s| s.0 <= level).map(|s| s.1).sum();
        wilson(inside / sum, effective)
    };
    let quantile = |share: f64| {
        let mut passed = 0.0;
        let reaches = |s: &&(f64, f64)| {
            passed += s.1 / sum;
            passed >= share
        };
        sorted.iter().find(reaches).or(sorted.last()).map_or(0.0, |s| s.0)
    };
    let half = wilson(0.5, effective);
    let median = Ranged { value: quantile(0.5), low: quantile(half.low), high: quantile(half.high) };
    Spread { median, within: LEVELS.map(below), dominant: dominant(receivers, mesh, counts) }
}

/// Wilson's (1927) score interval of a share found among `n`.
fn wilson(share: f64, n: f64) -> Ranged {
    let z2 = Z * Z / n;
    let centre = (share + 0.5 * z2) / (1.0 + z2);
    let half = Z / (1.0 + z2) * (share * (1.0 - share) / n + 0.25 * z2 / n).sqrt();
    let ends = [centre - half, centre + half].map(|x| x.clamp(0.0, 1.0));
    Ranged { value: share, low: ends[0].min(share), high: ends[1].max(share) }
}

fn dominant(receivers: &[Checked], mesh: &PatchMesh, counts: &[bool]) -> Option<Dominant> {
    let object = |patch: u32| mesh.regions[mesh.patches[patch as usize].region as usize].object as usize;
    let objects = mesh.regions.iter().map(|r| r.object as usize + 1).max()?;
    let mut held = vec![0.0; objects];
    let mut all = 0.0;
    for r in receivers {
        held[object(r.patch)] += r.weight * r.square;
        all += r.weight * r.square;
    }
    let (largest, &most) = held.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    if !(all > 0.0 && most > 0.0) {
        return None;
    }
    let weight = |r: &&Checked| r.weight * r.square;
    let own = receivers.iter().filter(|r| object(r.patch) == largest);
    let worst = own.max_by(|a, b| weight(a).total_cmp(&weight(b)))?;
    let (mut area, mut receiving) = (0.0, 0.0);
    for (i, patch) in mesh.patches.iter().enumerate().filter(|(i, _)| counts[*i]) {
        receiving += patch.area;
        if object(i as u32) == largest {
            area += patch.area;
        }
    }
    Some(Dominant {
        object: largest as u32,
        share: (most / all).min(1.0),
        area: area / receiving,
        patch: worst.patch,
    })
}

#[cfg(test)]
mod tests {
    use super::super::sobol::unit;
    use super::*;

    #[test]
    fn intervals_of_shares_and_of_the_median_hold_the_truth() {
        // Errors spread evenly over 0..0.2, drawn with the density 0.5 + e / 0.2 and weighted back.
        let runs = 400;
        let (mut share_held, mut median_held) = (0, 0);
        let none = PatchMesh::default();
        for run in 0..runs {
            let receivers: Vec<Checked> = (0..128)
                .map(|k| {
                    let u = unit(1000 * run + k);
                    // The running sum x / 2 + x² / 2 inverted.
                    let x = (0.25 + 2.0 * u).sqrt() - 0.5;
                    let weight = 1.0 / (0.5 + x) / 128.0;
                    Checked { of_light: 0.2 * x, weight, ..Checked::default() }
                })
                .collect();
            let found = spread(&receivers, &none, &[]);
            let held = |r: Ranged, truth: f64| u32::from(r.low <= truth && truth <= r.high);
            share_held += held(found.within[1], 0.25);
            median_held += held(found.median, 0.1);
        }
        for held in [share_held, median_held] {
            assert!((0.90..0.995).contains(&(f64::from(held) / runs as f64)), "{held} of {runs}");
        }
    }

    #[test]
    fn nothing_asked_tells_nothing_and_all_inside_is_not_certain() {
        assert_eq!(spread(&[], &PatchMesh::default(), &[]), Spread::default());
        let exact = vec![Checked { weight: 1.0, ..Checked::default() }; 30];
        let found = spread(&exact, &PatchMesh::default(), &[]);
        assert_eq!((found.within[0].value, found.within[0].high), (1.0, 1.0));
        assert!((0.85..0.95).contains(&found.within[0].low), "{found:?}");
        assert_eq!(found.median.value, 0.0);
    }
}
