//! How wrong the irradiance at free points is.
//!
//! With B the patch radiosities, B_s = E + rho s the radiosity that the picture shows, K the true
//! gathering operator, and h the irradiance H that the line sampler (or hemicube, or rays) finds at a
//! point x from B, the error has three parts, each estimated by itself:
//!
//! * sampling, K B (x) - h: from how much the same gathering differs with its pattern turned, and from
//!   the witness wherever that disagrees by more than its noise;
//! * what it means for x that radiosities are constant over patches: K B_s (x) - K B (x), less what the
//!   mean of B_s over each patch differs from B. The witness looks both up with the same rays, so that
//!   hardly any noise is left in the difference. Below a desk with the sun on the floor it is half of all light:
//!   what of it stands out of its noise is added to the light of the point, and the rest is error;
//! * the patches' own error, K rho e (x) with e that of their mean irradiance: the witness asks at points
//!   of the very patches that x sees, drawn by what they reflect to it, how far it is from one more
//!   gathering of B_s. Reflections do not multiply it: rows are balanced so that all power arrives, and a
//!   mean error of the whole scene cannot build up.

use super::audit::Answer;
use super::sobol::{mix, unit};
use super::witness::{Receiver, Witness};
use crate::form_factors::{RowComputer, RowScratch};
use crate::scene::luminance_weighted;
use glam::DVec3;
use rayon::prelude::*;

/// Irradiance at a free point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointIrradiance {
    /// W/m² per band.
    pub irradiance: [f64; 3],
    /// Estimated error of its Rec. 709 luminance, W/m²: the truth lies within this in nine of ten cases.
    pub error: f64,
}

/// Turned patterns that a point is gathered with; their mean is what is told.
const TURNS: u32 = 4;
/// Rays along the cosine that the witness casts from a point, twice; more where it disagrees.
const RAYS: u32 = 1024;
const MORE_RAYS: u32 = 16 * RAYS;
/// Points on patches where the patches' own error is looked at: so many in all, and for each free point at
/// least so many.
const SENDERS: usize = 4096;
const FEWEST_SENDERS: usize = 2;
/// Rays along the cosine of each of the two gatherings there.
const SENDER_RAYS: u32 = 128;
/// Beyond so many points rays get fewer, so that the check takes no longer than the gathering.
const MANY_POINTS: usize = 512;
const FEWEST_RAYS: u32 = 64;
/// Of the relative errors of patches this share at either end counts no more than the next.
const TAIL: f64 = 0.005;
/// A correction takes away this share of what surfaces reflect at most.
const MOST_TAKEN: f64 = 0.95;
/// Standard deviations that an error may have beyond its estimate.
const WIDE: f64 = 2.0;
/// Points are lifted off their surfaces, radiosities are single precision, and patches have errors in common that the
/// places asked do not tell: no error is told below this share of the light.
const FLOOR: f64 = 2e-3;
/// The witness disagrees if it is off by more than this many of its own.
const DISAGREES: f64 = 3.0;

/// What one point was found to get.
struct Found {
    irradiance: [f64; 3],
    luminance: f64,
    /// Standard error of the mean of the turned gatherings.
    sampling: f64,
    /// The part of the luminance that surfaces reflect, and the same per band.
    reflected: f64,
    by_surfaces: [f64; 3],
    /// What that would be more if patches had the mean of what is shown on them.
    smoothing: f64,
    /// Relative errors of the light at points that it sees.
    senders: Vec<f64>,
}

/// Gathers irradiance at points with unit normals (metres), and estimates the error of each.
///
/// `computer` belongs to `answer.mesh`. What the lamps give each point by themselves is taken from `direct` where it
/// is known, W/m² per band, and gathered otherwise. The same input gives the same numbers
/// whatever the number of threads; `seed` names the random choices.
pub fn irradiance_at(
    answer: Answer<'_>,
    computer: &RowComputer,
    points: &[(DVec3, DVec3)],
    direct: Option<&[[f64; 3]]>,
    seed: u64,
) -> Vec<PointIrradiance> {
    let Answer { mesh, light, .. } = answer;
    let witness = Witness::new(&answer);
    let share = MANY_POINTS as f64 / points.len().max(MANY_POINTS) as f64;
    let fewer = |rays: u32| ((f64::from(rays) * share) as u32).max(FEWEST_RAYS);
    let rays = [fewer(RAYS), fewer(SENDER_RAYS)];
    let smoothing = (0..mesh.patches.len())
        .map(|i| {
            let own = luminance_weighted(light.irradiance[i].map(f64::from));
            if own > 0.0 { witness.shown_mean(i as u32) / own - 1.0 } else { 0.0 }
        })
        .collect();
    let check = Check { answer, computer, direct, witness, rays, smoothing, seed };
    let senders = (SENDERS / points.len().max(1)).max(FEWEST_SENDERS);
    let found: Vec<Found> = points
        .par_iter()
        .enumerate()
        .map_init(|| computer.scratch(), |scratch, (k, place)| check.gather(k, place, senders, scratch))
        .collect();
    let patches = PatchError::of(&found);
    points
        .par_iter()
        .zip(&found)
        .enumerate()
        .map(|(k, (place, found))| check.corrected(k, place, found, &patches))
        .collect()
}

struct Check<'a> {
    answer: Answer<'a>,
    computer: &'a RowComputer,
    /// What the lamps give by themselves at each point, W/m² per band, where that is known.
    direct: Option<&'a [[f64; 3]]>,
    witness: Witness<'a>,
    /// Along the cosine, from a free point and from a point on a patch.
    rays: [u32; 2],
    /// For each patch the mean of what is shown on it over what it has, less one.
    smoothing: Vec<f64>,
    seed: u64,
}

impl Check<'_> {
    fn key(&self, point: usize, what: u64) -> u64 {
        mix(mix(self.seed ^ mix(point as u64)).wrapping_add(what))
    }

    fn gather(
        &self,
        index: usize,
        &(point, normal): &(DVec3, DVec3),
        senders: usize,
        scratch: &mut RowScratch,
    ) -> Found {
        let lum = |v: [f32; 3]| luminance_weighted(v.map(f64::from));
        let radiosity = &self.answer.light.radiosity;
        // 1. The light, with the pattern turned.
        let mut turned = [[0.0; 3]; TURNS as usize];
        // Running sum of what each patch reflects to the point.
        let mut reflected: Vec<(u32, f64)> = Vec::new();
        let mut smoothing = 0.0;
        let mut by_surfaces = [0.0; 3];
        for (turn, sum) in turned.iter_mut().enumerate() {
            let share = turn as f64 / f64::from(TURNS);
            if let Some(direct) = self.direct {
                *sum = direct[index];
            }
            self.computer.point_turned(point, normal, share, scratch, |patch, f| {
                let b = radiosity[patch as usize];
                let emitted =
                    if self.direct.is_some() { self.answer.exitance[patch as usize] } else { [0.0; 3] };
                (0..3).for_each(|band| sum[band] += f * f64::from(b[band] - emitted[band]));
                let own = f * (lum(b) - lum(self.answer.exitance[patch as usize]));
                if turn == 0 && own > 0.0 {
                    let exitance = self.answer.exitance[patch as usize];
                    (0..3).for_each(|band| by_surfaces[band] += f * f64::from(b[band] - exitance[band]));
                    smoothing += own * self.smoothing[patch as usize];
                    reflected.push((patch, own + reflected.last().map_or(0.0, |last| last.1)));
                }
            });
        }
        let n = f64::from(TURNS);
        let irradiance = std::array::from_fn(|band| turned.iter().map(|h| h[band]).sum::<f64>() / n);
        let luminance = luminance_weighted(irradiance);
        let squares: f64 = turned.iter().map(|h| (luminance_weighted(*h) - luminance).powi(2)).sum();
        let sampling = (squares / (n - 1.0) / n).sqrt();

        // 2. The patches that it sees.
        let all = reflected.last().map_or(0.0, |last| last.1);
        let drawn = if all > 0.0 { senders } else { 0 };
        let senders = (0..drawn)
            .filter_map(|k| {
                let key = self.key(index, 8 * (k as u64 + 1));
                let place = (k as f64 + unit(key)) / drawn as f64 * all;
                let at = reflected.partition_point(|entry| entry.1 <= place).min(reflected.len() - 1);
                self.relative_residual(reflected[at].0, key)
            })
            .collect();
        Found { irradiance, luminance, sampling, reflected: all, by_surfaces, smoothing, senders }
    }

    /// At a random point of a patch: what one more gathering makes of its irradiance less what is shown,
    /// over what the patch has. `None` under something that stands on the patch.
    fn relative_residual(&self, patch: u32, key: u64) -> Option<f64> {
        let own = luminance_weighted(self.answer.light.irradiance[patch as usize].map(f64::from));
        let (point, normal, shown) = self.witness.point_on(patch, unit(mix(key ^ 1)), unit(mix(key ^ 2)));
        let choice = self.witness.lamp_choice(patch);
        let [a, b] = [mix(key ^ 3), mix(key ^ 4)].map(|seed| {
            self.witness.gather(patch, Receiver::Point(point, normal), &choice, self.rays[1], seed).shown
        });
        let is_covered = a == 0.0 && b == 0.0;
        // The shape that the picture gives to the light within a patch averages out, and its mean is not
        // what the patch has.
        let shape = shown / own - 1.0 - self.smoothing[patch as usize];
        (own > 0.0 && !is_covered).then(|| 0.5 * (a + b) / own - 1.0 - shape)
    }

    /// The light of a point with what radiosities that change within patches bring to it, and the error that is left.
    fn corrected(
        &self,
        index: usize,
        &(point, normal): &(DVec3, DVec3),
        found: &Found,
        patches: &PatchError,
    ) -> PointIrradiance {
        let at = self.computer.lifted(point, normal);
        let choice = self.witness.lamp_choice_at(at, normal, 0.0);
        let ask = |rays: u32, what: u64| {
            [what, what + 1]
                .map(|what| self.witness.gather_at(at, normal, &choice, rays, self.key(index, what)))
        };
        // 1. Radiosities that change within patches. With the same rays their noise is that of the change.
        let pair = ask(self.rays[0], 1);
        let changes = pair.map(|g| g.shown - g.constant);
        let shape = 0.5 * (changes[0] + changes[1]) - found.smoothing;
        let shape_noise = 0.5 * (changes[0] - changes[1]).abs();
        // What stands out of its noise is added (James & Stein 1961), but never takes all light away.
        let certain = if shape == 0.0 { 0.0 } else { (1.0 - (shape_noise / shape).powi(2)).max(0.0) };
        let added = (certain * shape).max(-MOST_TAKEN * found.reflected);

        // 2. Sampling, and what it does not know of itself.
        let disagreement = |[a, b]: [f64; 2]| {
            let noise = (0.5 * (a - b).abs()).max(0.25 * (a + b) / f64::from(self.rays[0]).sqrt());
            ((0.5 * (a + b) - found.luminance).abs(), noise)
        };
        let (mut off, mut noise) = disagreement(pair.map(|g| g.constant));
        if off > DISAGREES * noise {
            let again = ask(MORE_RAYS, 3).map(|g| g.constant);
            off = (0.5 * (again[0] + again[1]) - found.luminance).abs();
            noise = (0.5 * (again[0] - again[1]).abs()).max(0.25 * noise);
        }
        let unseen = if off > DISAGREES * noise { off - WIDE * noise } else { 0.0 };

        // 3. All together: what is known with its sign, and the widths of the rest.
        // That of the patches a point sees may be the other way round than in the mean.
        let reflected = (found.reflected + added).max(0.0);
        let known = (shape - added).abs() + (reflected * patches.bias).abs();
        let widths = [
            WIDE * found.sampling,
            WIDE * shape_noise,
            WIDE * reflected * patches.bias_noise,
            WIDE * reflected * patches.spread,
            FLOOR * found.luminance,
        ];
        let error = known + unseen + widths.iter().map(|w| w * w).sum::<f64>().sqrt();
        // In the colour of what surfaces reflect to it.
        let more = if found.reflected > 0.0 { added / found.reflected } else { 0.0 };
        let irradiance = std::array::from_fn(|band| found.irradiance[band] + more * found.by_surfaces[band]);
        PointIrradiance { irradiance, error }
    }
}

/// The relative error of the light that the patches reflect to the points.
struct PatchError {
    /// Its mean over the points, with the standard error of that.
    bias: f64,
    bias_noise: f64,
    /// Standard deviation from point to point, free of the noise of a point's own mean: as large as it may be, since
    /// few that were asked of each point tell little of it.
    spread: f64,
}

impl PatchError {
    fn of(found: &[Found]) -> Self {
        // A single place beside a shadow's edge, off by all of its light, would rule the spread of all points.
        let mut all: Vec<f64> = found.iter().flat_map(|f| f.senders.iter().copied()).collect();
        all.sort_by(f64::total_cmp);
        let beyond = (TAIL * all.len() as f64) as usize;
        let low = all.get(beyond).copied().unwrap_or(0.0);
        let high = all.iter().rev().nth(beyond).copied().unwrap_or(0.0).max(low);
        let own: Vec<(f64, f64)> = found
            .iter()
            .filter(|f| f.senders.len() > 1)
            .map(|f| {
                let n = f.senders.len() as f64;
                let senders = || f.senders.iter().map(|d| d.clamp(low, high));
                let mean = senders().sum::<f64>() / n;
                let squares: f64 = senders().map(|d| (d - mean).powi(2)).sum();
                (mean, squares / (n - 1.0) / n)
            })
            .collect();
        let n = own.len() as f64;
        if own.is_empty() {
            return Self { bias: 0.0, bias_noise: 0.0, spread: 0.0 };
        }
        let mean = own.iter().map(|o| o.0).sum::<f64>() / n;
        let noise = own.iter().map(|o| o.1).sum::<f64>() / n;
        let between = own.iter().map(|o| (o.0 - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        Self {
            bias: mean,
            bias_noise: (between.max(noise) / n).sqrt(),
            // A variance found from n values is off by 2 / n of itself, squared.
            spread: ((between - noise).max(0.0) + WIDE * between * (2.0 / n).sqrt()).sqrt(),
        }
    }
}
