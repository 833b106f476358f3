//! What a solve will cost and how wrong it will be, from solves that were measured.

use super::trial::{Pace, Trial};
use crate::accuracy::ErrorBudget;
use crate::solve::{Prepared, Solution, Timings};

/// How fine a solve is: what its cost and its error depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Patches.
    pub patches: f64,
    /// Half-planes a row.
    pub lines: f64,
}

/// A solve that was made by lines, with its cost and, where it was audited, its errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// How fine it was.
    pub fineness: Fineness,
    /// Seconds by stage.
    pub timings: Timings,
    /// Stored form factors.
    pub entries: f64,
    /// Of the patches those of faces smaller than a patch, which any mesh has besides a number asked for.
    pub whole: f64,
    /// Right-hand sides: bands of each lamp.
    pub columns: f64,
    /// What work costs on this machine.
    pub pace: Pace,
    /// Form factors and visibility, relative.
    pub form_factors: f64,
    /// Patches, relative.
    pub mesh: f64,
    /// Direct light on elements, relative: neither patches nor half-planes mend it.
    pub direct: f64,
    /// In all, as shown, relative.
    pub total: f64,
}

/// Extrapolates cost and error from measured solves of one scene on this machine.
///
/// Rows cost by their lines, with an overhead that is tried out and more where shadows' edges take several
/// points, and a little by how many patches a line
/// crosses. Form factors grow with the square of the patches, as far as lines find them. Balancing them
/// and sweeping costs by their number, as gatherings over one, whose time is measured on the machine; on top
/// of that come close pairs, as many as the scene was seen to have, and the power balance, by the pairs of its
/// parts and the cube of their number once joined. Errors fall by powers: those of
/// form factors with lines and patches, that of the mesh with patches, its power fitted where two
/// audits tell it.
#[derive(Clone, Debug, Default)]
pub struct CostModel {
    measured: Vec<Measured>,
    /// What direct light will be off by, where that is not what it was.
    direct: Option<f64>,
}

/// Power of the patches in the cost of a row.
const ROW_GROWTH: f64 = 0.2;
/// Of the pairs that see each other lines find 1 - exp(-this times lines over the root of the patches):
/// fitted to six meshes of two scenes, within 5 %.
const FOUND: f64 = 1.5;
/// What work costs, as gatherings of all lanes over one form factor: meshing a patch; balancing a form factor; sweeping it,
/// for each column; building the power balance of it where each patch is a part; and factoring that, times the
/// cube of its aggregates. Fitted to 28 solves of the embedded scenes.
const MESH: f64 = 9_500.0;
const BALANCE: f64 = 56.0;
const SWEEPS: f64 = 6.7;
const AGGREGATE: f64 = 80.0;
const FACTORS: f64 = 0.4;
/// Bytes that each takes while they are assembled, rows and blocks included: 20 in the house at 65,536 patches.
const BYTES: f64 = 22.0;
/// Parts of the power balance at most, about, and aggregates that they are joined to.
const PARTS: f64 = 1200.0;
const AGGREGATES: [f64; 2] = [384.0, 512.0];
/// Powers by which errors fall. That of the mesh is of solves whose patches go where the check of the one
/// before found errors: 0.82 and 0.87 in two scenes from the first step to the second; equal patches have 0.6.
const BY_LINES: f64 = 1.1;
const FORM_FACTORS_BY_PATCHES: f64 = 0.35;
const MESH_BY_PATCHES: f64 = 0.75;
/// The power is fitted to solves whose patches differ by this factor.
const APART: f64 = 2.5;
/// More patches than this times those measured are far: on the way there lies a step, apart enough.
const FAR: f64 = 7.0;

/// Of the pairs of patches that see each other the part that the lines of one of them find.
fn found(fineness: Fineness) -> f64 {
    1.0 - (-FOUND * fineness.lines / fineness.patches.sqrt()).exp()
}

impl Measured {
    /// Of a finished solve by lines, with the pace of the machine and its budget; errors unknown
    /// without one.
    pub fn of(solved: &Solution, lines: u32, pace: Pace, budget: Option<&ErrorBudget>) -> Self {
        let error = |of: &dyn Fn(&ErrorBudget) -> f64| budget.map_or(f64::NAN, of);
        Self {
            fineness: Fineness { patches: solved.mesh.patches.len() as f64, lines: f64::from(lines) },
            timings: solved.timings,
            entries: solved.transport.as_ref().map_or(0, |t| t.entries()) as f64,
            whole: solved.mesh.statistics.whole_sides as f64,
            columns: (solved.bases.lamps * solved.bases.bands) as f64,
            pace,
            form_factors: error(&|b| b.form_factors.error),
            mesh: error(&|b| b.mesh.error),
            direct: error(&|b| b.direct.error),
            total: error(&|b| b.total.error),
        }
    }

    /// The power balance and the sweeps of so many form factors, as gatherings over one.
    fn nominal_sweeps(&self, patches: f64, entries: f64) -> f64 {
        let parts = (PARTS / patches).min(1.0).powi(2);
        let aggregates = (patches / 6.0).clamp(AGGREGATES[0], AGGREGATES[1]).min(patches);
        (AGGREGATE * parts + SWEEPS * self.columns) * entries + FACTORS * aggregates.powi(3)
    }

    /// What a row by so many lines costs in the mean, as lines.
    fn row(&self, lines: f64) -> f64 {
        lines + self.pace.overhead
    }

    fn is_audited(&self) -> bool {
        self.total.is_finite()
    }
}

impl CostModel {
    /// Learns from one more solve; the latest counts.
    pub fn learn(&mut self, measured: Measured) {
        self.measured.push(measured);
    }

    /// The same where direct light is laid out so finely that it is off by this, a share.
    pub fn with_direct(&self, error: f64) -> Self {
        Self { direct: Some(error), ..self.clone() }
    }

    /// All solves so far.
    pub fn measured(&self) -> &[Measured] {
        &self.measured
    }

    /// Seconds that a solve of this fineness takes, loading left out; `None` before the first solve.
    pub fn seconds(&self, wanted: Fineness) -> Option<f64> {
        let base = self.measured.last()?;
        let patches = wanted.patches / base.fineness.patches;
        let lines = base.row(wanted.lines) / base.row(base.fineness.lines);
        let t = &base.timings;
        let further = base.pace.gathering * MESH * (wanted.patches - base.fineness.patches);
        Some(
            // The scene is surveyed once.
            (t.mesh - t.survey + t.plan + further).max(0.0)
                + t.rows * patches.powf(1.0 + ROW_GROWTH) * lines
                + self.rest(wanted.patches, self.entries(wanted)?)?,
        )
    }

    /// The number of patches to ask for, to get a mesh of this fineness: small faces come on top.
    pub fn count(&self, wanted: Fineness) -> usize {
        /// At least this part is asked for: finer meshes leave fewer faces whole.
        const LEAST: f64 = 0.1;
        let whole = self.measured.last().map_or(0.0, |m| m.whole);
        (wanted.patches - whole).max(LEAST * wanted.patches) as usize
    }

    /// Form factors of a solve of this fineness.
    fn entries(&self, wanted: Fineness) -> Option<f64> {
        let base = self.measured.last()?;
        let growth = (wanted.patches / base.fineness.patches).powi(2);
        Some(base.entries * growth * found(wanted) / found(base.fineness))
    }

    /// Seconds of balancing and sweeping so many form factors of so many patches, and of direct light.
    fn rest(&self, patches: f64, entries: f64) -> Option<f64> {
        let base = self.measured.last()?;
        // Finer patches have more close pairs, but smaller ones, which are close to fewer.
        let of_factors = base.timings.balance.min(base.pace.gathering * BALANCE * base.entries);
        let close = base.timings.balance - of_factors;
        let balance = of_factors * entries / base.entries.max(1.0) + close;
        let sweeps = base.nominal_sweeps(patches, entries);
        let of_base = base.nominal_sweeps(base.fineness.patches, base.entries).max(f64::MIN_POSITIVE);
        // Direct light is laid out as finely whatever the patches.
        Some(base.timings.sweeps * sweeps / of_base + balance + base.timings.elements)
    }

    /// Seconds of a solve that is meshed already, of which some rows were tried; `None` before the first
    /// solve.
    pub fn seconds_of(&self, prepared: &Prepared, trial: &Trial) -> Option<f64> {
        let patches = prepared.mesh.patches.len() as f64;
        let done = prepared.timings.mesh + prepared.timings.plan;
        // Pairs that only one of the two finds are stored for both: of all 1 - (1 - p)² for p.
        let both = 2.0 - found(Fineness { patches, lines: f64::from(trial.lines) });
        Some(done + trial.rows + self.rest(patches, both * trial.entries)?)
    }

    /// Gigabytes that the form factors of a solve of this fineness need while they are assembled; `None`
    /// before the first solve.
    pub fn gigabytes(&self, wanted: Fineness) -> Option<f64> {
        Some(self.entries(wanted)? * BYTES / 1e9)
    }

    /// Error as shown of a solve of this fineness; `None` before the first audit.
    pub fn error(&self, wanted: Fineness) -> Option<f64> {
        let base = self.measured.iter().rev().find(|m| m.is_audited())?;
        let patches = base.fineness.patches / wanted.patches;
        let lines = base.fineness.lines / wanted.lines;
        let form_factors = base.form_factors * patches.powf(FORM_FACTORS_BY_PATCHES) * lines.powf(BY_LINES);
        let mesh = base.mesh * patches.powf(self.mesh_power());
        // The two are not independent: smoothing takes some of the one for the other.
        let together = base.form_factors.hypot(base.mesh).hypot(base.direct);
        let factor = if together > 0.0 { base.total / together } else { 1.0 };
        Some(form_factors.hypot(mesh).hypot(self.direct.unwrap_or(base.direct)) * factor.clamp(0.5, 1.5))
    }

    /// Whether smaller patches take away more of the error a second than more half-planes would; `None`
    /// before the first audit.
    pub fn asks_for_patches(&self) -> Option<bool> {
        const STEP: f64 = 1.5;
        let now = self.measured.last().map(|m| m.fineness)?;
        let gain = |f: Fineness| {
            Some((self.error(now)? - self.error(f)?) / (self.seconds(f)? - self.seconds(now)?).max(1e-9))
        };
        let patches = gain(Fineness { patches: STEP * now.patches, ..now })?;
        Some(patches >= gain(Fineness { lines: STEP * now.lines, ..now })?)
    }

    /// The next solve on the way to `wanted`: itself, or one in between that tells how the error falls
    /// with patches, where that is only assumed and `wanted` is far. As cost grows with the square of the
    /// patches, the step in between costs little, and going past the mark much.
    pub fn towards(&self, wanted: Fineness) -> Fineness {
        let Some(base) = self.measured.last() else { return wanted };
        if self.knows_its_power() || wanted.patches < FAR * base.fineness.patches {
            return wanted;
        }
        Fineness { patches: (base.fineness.patches * wanted.patches).sqrt(), ..wanted }
    }

    /// Whether solves tell how the error falls with patches; else it is assumed.
    pub fn knows_its_power(&self) -> bool {
        self.fitted_power().is_some()
    }

    fn mesh_power(&self) -> f64 {
        self.fitted_power().unwrap_or(MESH_BY_PATCHES)
    }

    /// Fitted to the two audited solves that differ most in patches, within what is plausible.
    fn fitted_power(&self) -> Option<f64> {
        let audited = || self.measured.iter().filter(|m| m.is_audited() && m.mesh > 0.0);
        let order = |a: &&Measured, b: &&Measured| a.fineness.patches.total_cmp(&b.fineness.patches);
        let (coarse, fine) = (audited().min_by(order)?, audited().max_by(order)?);
        let ratio = fine.fineness.patches / coarse.fineness.patches;
        (ratio >= APART).then(|| ((coarse.mesh / fine.mesh).ln() / ratio.ln()).clamp(0.45, 1.5))
    }

    /// The cheapest fineness whose error stays below `error`, within `gigabytes` and above the patches
    /// that the scene has at least; `None` before the first audit, or where none does.
    pub fn cheapest(&self, error: f64, limits: Limits) -> Option<Fineness> {
        let fits = |f: &Fineness| self.error(*f).is_some_and(|e| e <= error);
        let cost = |f: &Fineness| self.seconds(*f).unwrap_or(f64::INFINITY);
        self.candidates(limits).into_iter().filter(fits).min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// The most accurate fineness that takes at most `seconds`.
    pub fn best_within(&self, seconds: f64, limits: Limits) -> Option<Fineness> {
        let fits = |f: &Fineness| self.seconds(*f).is_some_and(|s| s <= seconds);
        let error = |f: &Fineness| self.error(*f).unwrap_or(1.0 / (f.patches * f.lines));
        self.candidates(limits).into_iter().filter(fits).min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    fn candidates(&self, limits: Limits) -> Vec<Fineness> {
        let Some(base) = self.measured.last() else { return Vec::new() };
        let steps = -12..=30;
        let counts = steps.map(|k| base.fineness.patches * 2.0_f64.powf(f64::from(k) / 5.0));
        let counts = counts.filter(|n| (limits.fewest..=limits.most).contains(n));
        counts
            .flat_map(|patches| LINES.map(|lines| Fineness { patches, lines: f64::from(lines) }))
            .filter(|&f| self.gigabytes(f).is_some_and(|gb| gb <= limits.gigabytes))
            .collect()
    }
}

/// Half-planes to choose from.
const LINES: [u32; 12] = [24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];

/// What choices keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Patches at least: surfaces are not joined.
    pub fewest: f64,
    /// Patches at most.
    pub most: f64,
    /// Memory for form factors at most, GB.
    pub gigabytes: f64,
}

#[cfg(test)]
impl Measured {
    /// A solve of two seconds with these errors of form factors and patches, for tests.
    pub(crate) fn example(patches: f64, lines: f64, [form_factors, mesh]: [f64; 2]) -> Self {
        Self {
            fineness: Fineness { patches, lines },
            timings: Timings { rows: 1.0, balance: 0.5, sweeps: 0.5, ..Timings::default() },
            entries: 1e6,
            whole: 0.0,
            columns: 3.0,
            pace: Pace { overhead: 24.0, gathering: 1e-9 },
            form_factors,
            mesh,
            direct: 0.0,
            total: form_factors.hypot(mesh),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { fewest: 100.0, most: 1e6, gigabytes: 8.0 };

    #[test]
    fn choices_meet_the_target_and_none_cheaper_does() {
        let mut model = CostModel::default();
        assert!(model.cheapest(0.01, LIMITS).is_none());
        model.learn(Measured::example(1000.0, 64.0, [0.04, 0.05]));
        let found = model.cheapest(0.02, LIMITS).unwrap();
        assert!(model.error(found).unwrap() <= 0.02);
        assert!(found.patches > 1000.0 && found.lines > 64.0, "both errors are too large: {found:?}");
        let seconds = model.seconds(found).unwrap();
        let best = model.best_within(seconds, LIMITS).unwrap();
        assert!(model.error(best).unwrap() <= model.error(found).unwrap());
        assert!(model.best_within(1e-3, LIMITS).is_none());
    }

    #[test]
    fn seconds_grow_with_patches_and_lines_and_are_those_measured_where_nothing_changes() {
        let mut model = CostModel::default();
        let base = Measured::example(1000.0, 64.0, [0.02, 0.05]);
        model.learn(base);
        let at = |patches: f64, lines: f64| model.seconds(Fineness { patches, lines }).unwrap();
        assert!((at(1000.0, 64.0) / base.timings.solve() - 1.0).abs() < 1e-9);
        assert!(at(1000.0, 128.0) > at(1000.0, 64.0) && at(4000.0, 64.0) > 4.0 * at(1000.0, 64.0));
        // Rows with a large overhead gain little from fewer lines.
        let mut slow = CostModel::default();
        slow.learn(Measured { pace: Pace { overhead: 300.0, ..base.pace }, ..base });
        let fewer = Fineness { patches: 1000.0, lines: 24.0 };
        assert!(slow.seconds(fewer).unwrap() > 1.1 * at(1000.0, 24.0));
    }

    #[test]
    fn memory_bounds_the_patches() {
        let mut model = CostModel::default();
        model.learn(Measured::example(1000.0, 64.0, [0.02, 0.5]));
        let tight = Limits { gigabytes: 0.1, ..LIMITS };
        let best = model.best_within(1e9, tight).unwrap();
        assert!(model.gigabytes(best).unwrap() <= 0.1);
        assert!(model.cheapest(0.001, tight).is_none());
    }

    #[test]
    fn memory_grows_with_lines_as_far_as_they_find_more() {
        // Lines find 1 - exp(-1.5 lines / root of patches): 0.92 of the pairs of 800 patches by 48,
        // 0.40 of those of 20 000, and 0.996 of these by 512.
        let at = |patches: f64, lines: f64| Fineness { patches, lines };
        let mut model = CostModel::default();
        model.learn(Measured::example(800.0, 48.0, [0.02, 0.05]));
        let (few, many) = (model.gigabytes(at(20e3, 48.0)), model.gigabytes(at(20e3, 512.0)));
        let of_all = 1e6 * 25.0 * 25.0 * 22e-9;
        assert!((few.unwrap() / (of_all * 0.399 / 0.922) - 1.0).abs() < 0.01, "{few:?}");
        assert!((many.unwrap() / few.unwrap() - 2.49).abs() < 0.02, "{many:?} against {few:?}");
        // What there is room for by few lines has none by many.
        let mut fine = CostModel::default();
        fine.learn(Measured { entries: 1e8, ..Measured::example(20e3, 48.0, [0.05, 1e-3]) });
        let room = Limits { fewest: 20e3, most: 20e3, gigabytes: 3.9 };
        let best = fine.best_within(1e9, room).unwrap();
        assert!(best.lines > 48.0 && best.lines < 512.0, "{best:?}");
        assert!(fine.gigabytes(best).unwrap() <= 3.9 && fine.best_within(1e9, LIMITS).unwrap().lines > 512.0);
    }

    #[test]
    fn small_faces_and_the_survey_of_the_scene_are_paid_for_once() {
        let mut model = CostModel::default();
        let timings = Timings { mesh: 30.0, survey: 28.0, rows: 4.0, ..Timings::default() };
        model.learn(Measured { whole: 5000.0, timings, ..Measured::example(6000.0, 48.0, [0.02, 0.05]) });
        let at = |patches: f64| Fineness { patches, lines: 48.0 };
        assert_eq!(model.count(at(8000.0)), 3000);
        assert_eq!(model.count(at(5100.0)), 510, "some patches are asked for in any case");
        let again = model.seconds(at(6000.0)).unwrap();
        assert!((6.0..10.0).contains(&again), "meshed anew on the survey: {again} s");
    }

    #[test]
    fn the_power_of_the_mesh_is_learnt() {
        let mut model = CostModel::default();
        model.learn(Measured::example(1000.0, 64.0, [0.001, 0.08]));
        model.learn(Measured::example(4000.0, 64.0, [0.001, 0.02]));
        // Mesh error as 1 / n: a quarter of the error at four times the patches.
        let at = model.error(Fineness { patches: 16_000.0, lines: 64.0 }).unwrap();
        let far = Fineness { patches: 64_000.0, lines: 64.0 };
        assert_eq!(model.towards(far), far, "the power is known");
        let mut unsure = CostModel::default();
        unsure.learn(Measured::example(1000.0, 64.0, [0.001, 0.08]));
        assert_eq!(unsure.towards(far).patches, 8000.0);
        let near = Fineness { patches: 5000.0, ..far };
        assert_eq!(unsure.towards(near), near);
        assert!((at / 0.005 - 1.0).abs() < 0.05, "{at}");
    }
}
