//! Draws receivers, asks the witness, and adds up the budget.

use super::interval::{Estimate, Sample, estimate};
use super::map::{ErrorMap, Signs, map};
use super::sobol::{mix, unit};
use super::spread::{DARKEST, Spread, spread};
use super::witness::{Receiver, Shown, Witness};
use super::{AlgebraicError, algebraic_error};
use crate::mesh::PatchMesh;
use crate::scene::{Lighting, luminance_weighted};
use crate::solver::{PatchLight, gathered};
use crate::transport::Transport;
use rayon::prelude::*;
use std::time::Instant;

/// A solved scene under one lighting, as an audit sees it.
#[derive(Clone, Copy, Debug)]
pub struct Answer<'a> {
    /// Its patches.
    pub mesh: &'a PatchMesh,
    /// All form factors.
    pub transport: &'a dyn Transport,
    /// Light of each patch.
    pub light: &'a PatchLight,
    /// Exitance of each patch, W/m² per band: what it glows with in the picture.
    pub exitance: &'a [[f32; 3]],
    /// The lamps as they stand.
    pub lighting: &'a Lighting,
    /// Reflectance of each patch per band.
    pub reflectance: &'a [[f32; 3]],
    /// The irradiance that the picture shows.
    pub shown: &'a Shown,
    /// Whether points lie on the curved surfaces that facets stand for, with their normals, as the picture shows them.
    pub smooth: bool,
    /// What of `shown` is direct light on elements; `None` where patches carry all light.
    pub direct: Option<&'a Shown>,
}

/// How thorough an audit is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditSettings {
    /// It ends once the half width of the total's interval is this part of the total; above zero.
    pub precision: f64,
    /// Whether the error of form factors is to be known as precisely.
    pub parts: bool,
    /// Errors below this (of the mean irradiance) need not be resolved; above zero.
    pub resolve: f64,
    /// It ends after about this many seconds with what it has.
    pub seconds: f64,
    /// Rays are cast until their noise at a point is below this part of the light there, time allowing;
    /// above zero. [`Spread`] is blurred by as much.
    pub local_noise: f64,
    /// Squared noise of the witness at a receiver over the squared error that is found; above zero. It adds no bias.
    pub noise: f64,
    /// Receivers at most; 64 or more.
    pub receivers: usize,
    /// It ends as soon as the total's interval lies on one side of this. Before it says that the error is
    /// smaller it asks 512 receivers at least, time allowing: fewer may have missed the few places that
    /// are worst.
    pub decide: Option<f64>,
    /// Once so many seconds have passed, an error that is larger than `decide` as far as is known is taken to be so: another
    /// solve costs less than certainty. Zero or above.
    pub hurry: f64,
    /// Whether to use all threads of the pool, or the calling one alone.
    pub parallel: bool,
    /// Names the random choices: the same seed draws the same receivers and rays.
    pub seed: u64,
}

impl Default for AuditSettings {
    fn default() -> Self {
        Self {
            precision: 0.1,
            parts: false,
            resolve: 5e-4,
            local_noise: 5e-3,
            noise: 1.0,
            seconds: 10.0,
            receivers: 4096,
            decide: None,
            hurry: f64::INFINITY,
            parallel: true,
            seed: 1,
        }
    }
}

/// How a mean error is passed on by later reflections: as one constant C over the scene, with
/// C = c mean(rho e) / (1 - c mean(rho)), c the mean row sum, means over the area.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Interreflection {
    /// c / (1 - c mean(rho)).
    pub gain: f64,
}

/// The errors of an answer: RMS over the receiving area, relative to the light at each place where that is more than
/// the mean and to the mean elsewhere, so that the inside of a lamp shade does not rule a house.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorBudget {
    /// Direct light: how it is interpolated on its elements. Zero where patches carry it.
    pub direct: Estimate,
    /// Interreflected light: form factors and visibility.
    pub form_factors: Estimate,
    /// Interreflected light, or all where patches carry it: discretisation.
    pub mesh: Estimate,
    /// Sweeps that are missing.
    pub solver: AlgebraicError,
    /// Of the irradiance as shown, the solver's part included: what a point of the picture is off by.
    pub total: Estimate,
    /// Of the mean irradiance of a patch, form factors and mesh together: what a table is off by.
    pub averages: Estimate,
    /// As `total`, but relative to the mean everywhere: squares count bright places beside lamps most.
    pub of_mean: Estimate,
    /// How the error as shown is spread over the area.
    pub spread: Spread,
    /// Mean luminance of irradiance over the receiving area, W/m².
    pub mean_irradiance: f64,
    /// Receivers asked.
    pub receivers: usize,
    /// Rays cast.
    pub rays: u64,
    /// Seconds that the audit took.
    pub seconds: f64,
}

/// One receiver that was asked, and how wrong the answer is there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Checked {
    /// The patch.
    pub patch: u32,
    /// How many times its share of the area it stands for, divided by the receivers asked.
    pub weight: f64,
    /// What the picture shows at a point of it less the truth, over the mean irradiance.
    pub shown: f64,
    /// Square of the error of the light there, as [`ErrorBudget::total`] has it, free of the witness' noise on average;
    /// may be negative.
    pub square: f64,
    /// What the picture shows less the truth, over the truth ([`DARKEST`] of the mean at least).
    pub of_light: f64,
    /// What its row gathers less the truth, over the mean irradiance.
    pub form_factors: f64,
    /// As `square`, of what patches and their rows are off by: direct light on elements left out.
    pub square_of_patches: f64,
}

/// What an audit found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// The errors, added up.
    pub budget: ErrorBudget,
    /// Where they were looked for.
    pub receivers: Vec<Checked>,
    /// An estimate of where the picture is wrong, a value a patch.
    pub map: ErrorMap,
    /// The same of what patches and their rows are off by, which smaller patches can mend.
    pub map_of_patches: ErrorMap,
}

/// What one receiver brought: samples of the four errors.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    patch: u32,
    direct: Sample,
    interreflected: Sample,
    form_factors: Sample,
    mesh: Sample,
    total: Sample,
    averages: Sample,
    of_light: f64,
    /// Rays cast.
    rays: u64,
}

/// How well a receiver is to be looked at.
#[derive(Clone, Copy, Debug)]
struct Care {
    /// Squared noise of the witness to aim at for a patch mean and for a point, relative.
    noise: [f64; 2],
    /// Noise to aim at at a point, of the light there.
    local: f64,
    /// Rays along the cosine that one gathering has at least and at most.
    rays: [u32; 2],
}

/// Receivers of the pilot, which finds out how large the errors are.
const PILOT: usize = 48;
/// Rays along the cosine of each gathering in it.
const PILOT_RAYS: u32 = 256;
/// Every receiver is first tried by this many randomisations of so few rays, to choose how many it needs.
const TRIALS: u64 = 4;
const TRIAL_RAYS: u32 = 64;
/// Receivers of one stratified batch.
const BATCH: usize = 64;
/// Rays along the cosine that one gathering takes at most.
const MOST_RAYS: u32 = 1 << 16;
/// To be known as above or below a mark, an error must be known to this relative half width.
const LOOSE: f64 = 0.3;
/// Fewer receivers decide nothing, see [`AuditSettings::decide`].
const DECISIVE: usize = 512;
/// Receivers for which the time should do, where it is short.
const FEWEST: f64 = 160.0;
/// Share of its irradiance by which a patch is taken to be off before anything is known.
const BRIGHT: f64 = 0.1;
/// Once so many receivers have told where the picture is wrong, and at each doubling of them, further ones
/// are drawn by that: so large a share of them, the rest as before.
const INFORMED_FROM: usize = 128;
const INFORMED: f64 = 0.5;

/// An audit ready to run.
#[derive(Debug)]
pub struct Audit<'a> {
    answer: Answer<'a>,
    witness: Witness<'a>,
    /// Luminance of the irradiance that each patch has by its row and by the direct light on it, W/m².
    by_row: Vec<f64>,
    /// Where the picture takes direct light from elsewhere, what of it the rows gather from surfaces.
    passed_on: Option<Vec<f64>>,
    counts: Vec<bool>,
    /// Probability by which each patch is drawn as long as nothing is known; their sum is one.
    chance: Vec<f64>,
    area: f64,
    mean: f64,
    interreflection: Interreflection,
}

impl<'a> Audit<'a> {
    /// Readies the witness. `None` where no light arrives anywhere: there is nothing to be wrong about.
    pub fn new(answer: Answer<'a>) -> Option<Self> {
        let mesh = answer.mesh;
        let n = mesh.patches.len();
        if answer.transport.len() != n || answer.light.irradiance.len() != n {
            return None;
        }
        let counts: Vec<bool> = mesh.patches.iter().map(|p| p.luminaire.is_none() && !p.buried).collect();
        let lum = |v: [f32; 3]| luminance_weighted(v.map(f64::from));
        let receiving = || (0..n).filter(|&i| counts[i]);
        let area: f64 = receiving().map(|i| mesh.patches[i].area).sum();
        let flux: f64 = receiving().map(|i| mesh.patches[i].area * lum(answer.light.irradiance[i])).sum();
        let mean = flux / area;
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let witness = Witness::new(&answer);

        // Patches are drawn by area, by how much the picture changes on them and by how bright they are: the
        // inside of a lamp's housing may look even and yet be off by most of its light.
        let unrest = |i: usize| {
            let [low, high] = witness.shown_range(i as u32);
            let change = high - low;
            if change.is_finite() { change.max(0.0) } else { 0.0 }
        };
        // What a patch is off by counts against its own light where that is more than the mean.
        let own = |i: usize| lum(answer.light.irradiance[i]).max(0.0);
        let over = |i: usize| (own(i) / mean).max(1.0);
        let typical = receiving().map(|i| mesh.patches[i].area * unrest(i) / over(i)).sum::<f64>() / area;
        let floor = typical + 1e-6 * mean;
        let likely = |i: usize| (unrest(i) + BRIGHT * own(i)) / over(i) + floor;
        let chance: Vec<f64> =
            (0..n).map(|i| if counts[i] { mesh.patches[i].area * likely(i) } else { 0.0 }).collect();
        let whole: f64 = chance.iter().sum();
        let chance: Vec<f64> = chance.iter().map(|c| c / whole).collect();

        let all: f64 = mesh.patches.iter().map(|p| p.area).sum();
        let mean_of =
            |f: &dyn Fn(usize) -> f64| (0..n).map(|i| mesh.patches[i].area * f(i)).sum::<f64>() / all;
        let rho = mean_of(&|i| {
            let rho = answer.reflectance.get(i).map_or([0.0; 3], |r| r.map(f64::from));
            luminance_weighted(mesh.translucence.leaving(i, rho, |_| [1.0; 3]))
        });
        let closed = mean_of(&|i| answer.transport.row_sum(i));
        let gathered = gathered(answer.transport, (answer.reflectance, &mesh.translucence), answer.light);
        let by_row: Vec<f64> = gathered.into_iter().map(luminance_weighted).collect();
        let passed_on =
            answer.light.detail.as_ref().map(|detail| {
                by_row.iter().zip(&detail.given).map(|(all, &given)| all - lum(given)).collect()
            });
        Some(Self {
            answer,
            witness,
            passed_on,
            by_row,
            counts,
            chance,
            area,
            mean,
            interreflection: Interreflection { gain: closed / (1.0 - closed * rho).max(1e-3) },
        })
    }

    /// Runs until precise enough, out of time, or `stop` says so (polled for every receiver); the
    /// budget is that of the receivers asked so far. `None` if they are too few to tell.
    pub fn run(&self, settings: &AuditSettings, stop: &(dyn Fn() -> bool + Sync)) -> Option<Findings> {
        let clock = Instant::now();
        let out_of_time = || stop() || clock.elapsed().as_secs_f64() > settings.seconds;
        let solver = algebraic_error(
            self.answer.transport,
            self.answer.light,
            (self.answer.reflectance, &self.answer.mesh.translucence),
            &self.counts,
            self.mean,
        );
        let mut draw = running_sum(&self.chance);
        let rough = Care { noise: [f64::INFINITY; 2], local: f64::INFINITY, rays: [PILOT_RAYS; 2] };
        let pilot_clock = Instant::now();
        let pilot = self.batch(&draw, PILOT, rough, mix(settings.seed), settings.parallel, &out_of_time);
        let rays_per_second = count_rays(&pilot) as f64 / pilot_clock.elapsed().as_secs_f64().max(1e-6);
        let rays_left = rays_per_second * (settings.seconds - clock.elapsed().as_secs_f64()).max(0.0);
        let care = self.care(&pilot, rays_left, settings);

        let mut found: Vec<Found> = Vec::new();
        let (mut batch, mut informed_at) = (1, INFORMED_FROM);
        let most = settings.receivers.max(BATCH);
        while found.len() < most && !out_of_time() {
            let seed = mix(settings.seed).wrapping_add(batch);
            let count = BATCH.min(most - found.len());
            if found.len() >= informed_at {
                draw = self.informed(&found);
                informed_at *= 2;
            }
            found.extend(self.batch(&draw, count, care, seed, settings.parallel, &out_of_time));
            batch += 1;
            let total = self.estimate(&found, |f| f.total);
            let width = total.relative_half_width();
            // Places that were missed would only make an error larger that is too large already; where it may
            // just be too large, another solve costs less than certainty.
            let is_above = settings.decide.is_some_and(|d| {
                found.len() >= INFORMED_FROM && total.low > d || found.len() >= DECISIVE && total.error > d
            });
            let seems_above = settings.decide.is_some_and(|d| {
                found.len() >= INFORMED_FROM
                    && total.error > d
                    && clock.elapsed().as_secs_f64() > settings.hurry
            });
            let enough = settings.decide.is_none() || is_above || found.len() >= DECISIVE;
            let decided = width < LOOSE && (is_above || settings.decide.is_some_and(|d| total.high < d));
            let factors = || self.estimate(&found, |f| f.form_factors);
            let known =
                |e: Estimate| e.relative_half_width() < settings.precision || e.high < settings.resolve;
            if seems_above || enough && (decided || (known(total) && (!settings.parts || known(factors())))) {
                break;
            }
        }
        let rays = count_rays(&pilot) + count_rays(&found);
        if found.len() < BATCH / 4 {
            // The pilot alone is rough, but as honest.
            found.extend(pilot);
        }
        if found.len() < BATCH / 4 || stop() {
            return None;
        }
        let with_solver = |e: Estimate| Estimate {
            error: e.error.hypot(solver.estimate.error),
            low: e.low.hypot(solver.estimate.low),
            high: e.high.hypot(solver.estimate.high),
        };
        let receivers = checked(&found);
        let budget = ErrorBudget {
            direct: self.estimate(&found, |f| f.direct),
            form_factors: self.estimate(&found, |f| f.form_factors),
            mesh: self.estimate(&found, |f| f.mesh),
            solver,
            total: with_solver(self.estimate(&found, |f| f.total)),
            averages: self.estimate(&found, |f| f.averages),
            of_mean: with_solver(self.estimate(&found, |f| f.total.of_mean())),
            spread: spread(&receivers, self.answer.mesh, &self.counts),
            mean_irradiance: self.mean,
            receivers: found.len(),
            rays,
            seconds: clock.elapsed().as_secs_f64(),
        };
        let signs = self.signs();
        let map_to =
            |receivers: &[Checked], total: f64| map(self.answer.mesh, &self.counts, &signs, receivers, total);
        let map = map_to(&receivers, budget.total.error);
        let of_patches: Vec<Checked> =
            receivers.iter().map(|r| Checked { square: r.square_of_patches, ..*r }).collect();
        let interreflected = self.estimate(&found, |f| f.interreflected);
        let map_of_patches = map_to(&of_patches, interreflected.error);
        Some(Findings { budget, receivers, map, map_of_patches })
    }

    /// Running sum of the probabilities by which patches are drawn once some have told where the picture is
    /// wrong: least variance takes area times error (Neyman 1934). What each receiver stands for heeds the
    /// probability by which it was drawn itself, so that nothing is favoured by this.
    fn informed(&self, found: &[Found]) -> Vec<f64> {
        let map = map(self.answer.mesh, &self.counts, &self.signs(), &checked(found), 1.0);
        let patches = self.answer.mesh.patches.iter();
        let by_error: Vec<f64> = patches
            .zip(&map.error)
            .map(|(p, &e)| if e > 0.0 { p.area * f64::from(e) } else { 0.0 })
            .collect();
        let whole: f64 = by_error.iter().sum();
        if !(whole > 0.0 && whole.is_finite()) {
            return running_sum(&self.chance);
        }
        let mixed =
            self.chance.iter().zip(by_error).map(|(c, e)| (1.0 - INFORMED) * c + INFORMED * e / whole);
        running_sum(&mixed.collect::<Vec<f64>>())
    }

    /// What each patch shows of its error by itself.
    fn signs(&self) -> Vec<Signs> {
        let own = |i: usize| luminance_weighted(self.answer.light.irradiance[i].map(f64::from));
        (0..self.counts.len())
            .map(|i| {
                if !self.counts[i] {
                    return Signs::default();
                }
                let [low, high] = self.witness.shown_range(i as u32);
                let departure = self.witness.shown_mean(i as u32) - own(i);
                [high - low, departure, own(i)].map(|x| {
                    let square = (x / own(i).max(self.mean)).powi(2);
                    if square.is_finite() { square } else { 0.0 }
                })
            })
            .collect()
    }

    fn estimate(&self, found: &[Found], of: impl Fn(&Found) -> Sample) -> Estimate {
        let samples: Vec<Sample> = found.iter().map(of).collect();
        estimate(&samples, self.interreflection.gain)
    }

    /// The witness' noise must not drown the errors, as far as there are `rays_left` for a good number
    /// of receivers.
    fn care(&self, pilot: &[Found], rays_left: f64, settings: &AuditSettings) -> Care {
        let n = pilot.len().max(1) as f64;
        let mean = |of: &dyn Fn(&Found) -> Sample| {
            let squares = pilot.iter().map(of).map(|s| s.weight * s.square / (s.light * s.light));
            squares.sum::<f64>() / n
        };
        let least = settings.resolve * settings.resolve;
        let noise = [mean(&|f| f.form_factors), mean(&|f| f.total)].map(|e| settings.noise * e.max(least));
        // A receiver casts five times as many rays as one gathering has along the cosine.
        let most = (rays_left / (5.0 * FEWEST)).clamp(f64::from(TRIAL_RAYS) + 1.0, f64::from(MOST_RAYS));
        Care { noise, local: settings.local_noise, rays: [TRIAL_RAYS, most as u32] }
    }

    /// Asks one receiver out of each of `count` strata of equal probability; those that there is time
    /// for, in an order that has nothing to do with what they find.
    fn batch(
        &self,
        draw: &[f64],
        count: usize,
        care: Care,
        seed: u64,
        parallel: bool,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Vec<Found> {
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|&k| mix(seed ^ (k as u64 + 1).wrapping_mul(0xA076_1D64_78BD_642F)));
        let one = |stratum: usize| {
            if stop() {
                return None;
            }
            let key = mix(seed).wrapping_add(16 * stratum as u64);
            self.ask(draw, (stratum as f64 + unit(key)) / count as f64, care, key)
        };
        let numbered = |k: usize| Some((k, one(k)?));
        let mut found: Vec<(usize, Found)> = if parallel {
            order.into_par_iter().with_max_len(1).filter_map(numbered).collect()
        } else {
            order.into_iter().filter_map(numbered).collect()
        };
        // Sums are the same however many threads were at work.
        found.sort_by_key(|f| f.0);
        found.into_iter().map(|f| f.1).collect()
    }

    /// Asks the receiver at `place` in 0..1 of the running probability `draw`.
    fn ask(&self, draw: &[f64], place: f64, care: Care, key: u64) -> Option<Found> {
        let all = *draw.last()?;
        let i = draw.partition_point(|&c| c <= place * all).min(draw.len() - 1);
        let own = draw[i] - if i > 0 { draw[i - 1] } else { 0.0 };
        if own <= 0.0 {
            return None;
        }
        let (patch, witness) = (i as u32, &self.witness);
        let weight = self.answer.mesh.patches[i].area / self.area / (own / all);
        let rho = luminance_weighted(self.answer.reflectance[i].map(f64::from));
        let choice = witness.lamp_choice(patch);
        let (r, s) = (unit(key + 1), unit(key + 2));
        let (point, normal, shown) = witness.point_on(patch, r, s);
        let relative = |h: f64| h / self.mean;
        let by_row = self.by_row[i];
        let places = [Receiver::Whole, Receiver::Point(point, normal)];

        // 1. A few rays, to see how many it takes: the variance falls as n^-1.5 across jumps.
        let mut cast = 0;
        let rays: [u32; 2] = std::array::from_fn(|kind| {
            if care.rays[0] == care.rays[1] {
                return care.rays[0];
            }
            let values: Vec<f64> = (0..TRIALS)
                .map(|k| {
                    let seed = mix(key ^ mix(100 + 2 * k + kind as u64));
                    relative(witness.gather(patch, places[kind], &choice, TRIAL_RAYS, seed).shown)
                })
                .collect();
            cast += TRIALS * with_lamps(TRIAL_RAYS);
            let mean = values.iter().sum::<f64>() / TRIALS as f64;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (TRIALS - 1) as f64;
            let local = care.local * mean.max(DARKEST);
            let aim = care.noise[kind] * mean.max(1.0).powi(2);
            let aim = if kind == 1 { aim.min(local * local) } else { aim };
            let factor = (variance / aim).powf(1.0 / 1.5);
            (f64::from(TRIAL_RAYS) * factor).clamp(f64::from(care.rays[0]), f64::from(care.rays[1])) as u32
        });

        // 2. Two independent answers of the patch as a whole and of the point.
        let [whole, there] = [0, 1].map(|kind| {
            cast += 2 * with_lamps(rays[kind]);
            [3, 4].map(|k| {
                let seed = mix(key ^ mix(2 * k + kind as u64));
                witness.gather(patch, places[kind], &choice, rays[kind], seed)
            })
        });
        if shown > 0.0 && there.iter().all(|g| g.shown == 0.0) {
            // Covered by something that stands on the patch: nobody sees this point.
            return None;
        }

        let truth = relative(0.5 * (there[0].shown + there[1].shown));
        let light = truth.max(1.0);
        let sample = |deviations: [f64; 2]| {
            let [a, b] = deviations.map(relative);
            let deviation = 0.5 * (a + b);
            Sample { weight, square: a * b, deviation, reflected: rho * deviation, light }
        };
        let sampled = |k: usize| match &self.passed_on {
            Some(passed_on) => passed_on[i] - (whole[k].constant - whole[k].direct),
            None => by_row - whole[k].constant,
        };
        let direct = witness.direct_on(patch, r, s);
        let of_direct = |k: usize| direct.map_or(0.0, |direct| direct - there[k].direct);
        Some(Found {
            patch,
            direct: sample([0, 1].map(of_direct)),
            interreflected: sample([0, 1].map(|k| shown - there[k].shown - of_direct(k))),
            form_factors: sample([0, 1].map(sampled)),
            mesh: sample([0, 1].map(|k| shown - there[k].shown - of_direct(k) - sampled(k))),
            total: sample([0, 1].map(|k| shown - there[k].shown)),
            averages: sample([0, 1].map(|k| by_row - whole[k].shown)),
            of_light: (relative(shown) - truth) / truth.max(DARKEST),
            rays: cast,
        })
    }
}

/// Sums of the first, of the first two, and so on.
fn running_sum(values: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    values
        .iter()
        .map(|v| {
            sum += v;
            sum
        })
        .collect()
}

fn checked(found: &[Found]) -> Vec<Checked> {
    let count = found.len() as f64;
    let one = |f: &Found| Checked {
        patch: f.patch,
        weight: f.total.weight / count,
        shown: f.total.deviation,
        square: f.total.square / (f.total.light * f.total.light),
        square_of_patches: f.interreflected.square / (f.total.light * f.total.light),
        of_light: f.of_light,
        form_factors: f.form_factors.deviation,
    };
    found.iter().map(one).collect()
}

/// Rays of one gathering, those towards lamps included.
fn with_lamps(rays: u32) -> u64 {
    u64::from(rays) + u64::from(rays / 4).max(16)
}

fn count_rays(found: &[Found]) -> u64 {
    found.iter().map(|f| f.rays).sum()
}
