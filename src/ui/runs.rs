//! The solves of this session: what they took, how wrong they were, and how their error fell.

use crate::accuracy::ErrorBudget;
use crate::mesh::Patch;
use crate::scene::{Lighting, SceneSource, luminance_weighted};
use crate::session::Snapshot;
use crate::solve::{SolveSettings, Stage};
use crate::solver::{LightBases, PatchLight};
use std::sync::Arc;

/// Solves that are remembered, those of other scenes included.
const KEPT: usize = 24;
/// Before two sweeps have told, an error is taken to fall by this factor a sweep.
const USUAL_FALL: f64 = 0.3;

/// A finished solve.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finished {
    /// Name of its scene.
    pub(super) scene: String,
    source: SceneSource,
    /// It is of the scene on screen.
    pub(super) is_here: bool,
    /// What it was solved with.
    pub(super) settings: SolveSettings,
    pub(super) patches: usize,
    /// From meshing to the last sweep.
    pub(super) seconds: f64,
    /// Its errors; `None` until they are known.
    pub(super) budget: Option<ErrorBudget>,
    /// Seconds and the error that was left to the solver, a share of the mean irradiance.
    algebraic: Vec<[f64; 2]>,
}

impl Finished {
    /// Seconds and error in all, as it fell. Until the solve has been checked its patches and form
    /// factors add what was `foreseen` of them.
    pub(super) fn curve(&self, foreseen: f64) -> Vec<[f64; 2]> {
        let rest = self.budget.map_or(foreseen, |b| b.total.error);
        let mut curve = together(&self.algebraic, rest);
        curve.push([self.seconds, rest]);
        curve
    }
}

/// The error of the solver and the rest, which does not depend on it.
fn together(algebraic: &[[f64; 2]], rest: f64) -> Vec<[f64; 2]> {
    algebraic.iter().map(|[seconds, error]| [*seconds, error.hypot(rest)]).collect()
}

/// All solves, and the one that runs.
#[derive(Default)]
pub(super) struct Runs {
    /// Oldest first; of the scene on screen the last one is shown.
    pub(super) finished: Vec<Finished>,
    /// Of the solve that runs.
    algebraic: Vec<[f64; 2]>,
    seen: Option<Arc<LightBases>>,
    /// Luminance of irradiance of each patch after the last sweep.
    before: Vec<f32>,
}

impl Runs {
    /// Another scene has come, or the same one again.
    pub(super) fn enter(&mut self, source: Option<&SceneSource>) {
        for run in &mut self.finished {
            run.is_here = Some(&run.source) == source;
        }
        self.begin();
    }

    fn begin(&mut self) {
        self.algebraic.clear();
        self.before.clear();
        self.seen = None;
    }

    /// The solve on screen, once it has ended.
    pub(super) fn last(&self) -> Option<&Finished> {
        self.finished.last().filter(|f| f.is_here)
    }

    /// Seconds and error of the solve that runs, with what form factors and patches are foreseen to
    /// add to it (zero where nobody knows).
    pub(super) fn live(&self, rest: f64) -> Vec<[f64; 2]> {
        together(&self.algebraic, rest)
    }

    /// Follows the solve that runs. `light` is the present picture under the present lamps.
    pub(super) fn trace(&mut self, snapshot: &Snapshot, lighting: &Lighting, light: &PatchLight) {
        let (Some(mesh), Some(bases)) = (snapshot.mesh(), snapshot.bases()) else { return };
        if self.seen.as_ref().is_some_and(|seen| Arc::ptr_eq(seen, bases)) {
            return;
        }
        let elapsed = snapshot.timings.solve();
        if self.algebraic.last().is_some_and(|last| elapsed < last[0]) {
            self.begin();
        }
        self.seen = Some(bases.clone());
        let error = match (snapshot.stage, &snapshot.unshot) {
            (Stage::FirstLight | Stage::Rows, Some(unshot)) => guessed(
                &mesh.patches,
                light,
                &unshot.sum(lighting, mesh.patches.len()),
                snapshot.reflectance().map_or(&[], |r| r.as_slice()),
            ),
            (Stage::Rows, None) => self.not_refined(snapshot.rows),
            (Stage::Sweeping, _) => self.after_sweep(&mesh.patches, light, snapshot),
            _ => None,
        };
        if let Some(error) = error.filter(|e| *e > 0.0 && elapsed > 0.0) {
            self.algebraic.push([elapsed, error]);
        }
    }

    /// Where the light of the solve before is being refined, its error on the share of patches that have
    /// no row yet; `None` where that error is not known.
    fn not_refined(&self, (done, all): (usize, usize)) -> Option<f64> {
        let before = self.last()?.budget?.total.error;
        (all > 0).then(|| before * (1.0 - done as f64 / all as f64).max(0.0).sqrt())
    }

    /// What further sweeps will change: the change of the last one, continued as a geometric series.
    fn after_sweep(&mut self, patches: &[Patch], light: &PatchLight, snapshot: &Snapshot) -> Option<f64> {
        let now: Vec<f32> =
            light.irradiance.iter().map(|h| luminance_weighted(h.map(f64::from)) as f32).collect();
        let before = std::mem::replace(&mut self.before, now);
        let fall = match snapshot.sweeps() {
            [.., last, newest] if last.residual > 0.0 => (newest.residual / last.residual).clamp(1e-3, 0.95),
            _ => USUAL_FALL,
        };
        let change = change(patches, &before, &self.before)?;
        Some(change * fall / (1.0 - fall))
    }

    /// Puts a solve that has ended down in the list.
    pub(super) fn note(&mut self, snapshot: &Snapshot) {
        let (Some(mesh), Some(scene)) = (snapshot.mesh(), snapshot.scene()) else { return };
        let mut algebraic = std::mem::take(&mut self.algebraic);
        let seconds = snapshot.timings.solve();
        algebraic.retain(|point| point[0] <= seconds);
        self.begin();
        self.finished.retain(|f| !f.is_here || f.settings != snapshot.settings);
        self.finished.push(Finished {
            scene: scene.name.clone(),
            source: scene.source.clone(),
            is_here: true,
            settings: snapshot.settings.clone(),
            patches: mesh.patches.len(),
            seconds,
            budget: None,
            algebraic,
        });
        let over = self.finished.len().saturating_sub(KEPT);
        self.finished.drain(..over);
    }

    /// The errors of the solve on screen are known.
    pub(super) fn checked(&mut self, budget: ErrorBudget) {
        if let Some(last) = self.finished.last_mut().filter(|f| f.is_here) {
            last.budget = Some(budget);
        }
    }
}

/// What of the picture on the way is a guess, as a share of its mean irradiance: all unshot power, reflected on for ever
/// with the mean reflectance, as if it were spread evenly. The picture holds it.
fn guessed(
    patches: &[Patch],
    light: &PatchLight,
    unshot: &[[f32; 3]],
    reflectance: &[[f32; 3]],
) -> Option<f64> {
    let luminance = |v: &[f32; 3]| luminance_weighted(v.map(f64::from));
    let over_area = |values: &[[f32; 3]]| -> f64 {
        patches.iter().zip(values).map(|(patch, v)| patch.area * luminance(v)).sum()
    };
    let area: f64 = patches.iter().map(|p| p.area).sum();
    let rho = (over_area(reflectance) / area).clamp(0.0, 0.99);
    let guessed = over_area(unshot) / (1.0 - rho);
    let has = over_area(&light.irradiance);
    (has > 0.0).then(|| (guessed / has).min(1.0))
}

/// RMS difference of two fields over the area, relative to the mean of the second.
fn change(patches: &[Patch], before: &[f32], after: &[f32]) -> Option<f64> {
    if before.len() != patches.len() || after.len() != patches.len() {
        return None;
    }
    let (mut squares, mut flux, mut area) = (0.0, 0.0, 0.0);
    for (patch, (b, a)) in patches.iter().zip(before.iter().zip(after)) {
        squares += patch.area * f64::from(a - b).powi(2);
        flux += patch.area * f64::from(*a);
        area += patch.area;
    }
    (flux > 0.0).then(|| (squares / area).sqrt() / (flux / area))
}

/// Which run a place of the chart means, both as decimal logarithms of seconds and percent.
pub(super) fn nearest(runs: &Runs, at: [f64; 2]) -> Option<&Finished> {
    let distance = |f: &&Finished| {
        let error = f.budget.map_or(f64::NAN, |b| b.total.error);
        (f.seconds.log10() - at[0]).hypot((100.0 * error).log10() - at[1])
    };
    let known = runs.finished.iter().filter(|f| distance(f).is_finite());
    known.min_by(|a, b| distance(a).total_cmp(&distance(b))).filter(|f| distance(f) < 0.15)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::Estimate;
    use crate::mesh::PatchTarget;
    use crate::solve::{Control, Progress, Solution, Timings, prepare, solve};
    use std::sync::atomic::AtomicBool;

    /// A light without power that is no other one.
    fn lit() -> Arc<LightBases> {
        Arc::new(LightBases { values: vec![0.0], ..LightBases::default() })
    }

    /// Of a scene cut into a few patches.
    fn few_patches(scene: Arc<crate::scene::Scene>) -> Snapshot {
        let settings = SolveSettings { patches: PatchTarget::Count(60), ..SolveSettings::default() };
        let prepared = prepare(scene, &settings).unwrap();
        let solution = Solution { bases: lit(), ..Solution::new(&prepared, &settings) };
        Snapshot { solution: Some(Arc::new(solution)), ..Snapshot::default() }
    }

    /// Follows a real solve, and compares the error told at each step with the true one.
    #[test]
    fn the_error_told_on_the_way_is_about_the_true_one() {
        let source = SceneSource::Builtin("cornell".to_owned());
        let scene = Arc::new(crate::scene::load(&source).unwrap());
        let lighting = scene.lighting();
        // Fewer patches would be solved at once.
        let settings = SolveSettings {
            patches: PatchTarget::Count(1500),
            resolution: Some(48),
            tolerance: 1e-6,
            ..SolveSettings::default()
        };
        let mut steps = Vec::new();
        let mut observer = |progress: Progress<'_>| {
            if let Some(picture) = progress.picture() {
                steps.push((progress.stage, picture, progress.unshot(), progress.sweeps.to_vec()));
            }
            Control::Continue
        };
        let solved = solve(scene.clone(), &settings, &AtomicBool::new(false), &mut observer).unwrap();
        let lit = |bases: &LightBases| bases.mix(&solved.mesh, &lighting, &solved.reflectance);
        let luminances = |light: &PatchLight| -> Vec<f32> {
            light.irradiance.iter().map(|h| luminance_weighted(h.map(f64::from)) as f32).collect()
        };
        let end = luminances(&solved.light(&lighting));

        let mut runs = Runs::default();
        let mut compared = 0;
        for (k, (stage, picture, unshot, sweeps)) in steps.into_iter().enumerate() {
            let light = lit(&picture);
            let truth = change(&solved.mesh.patches, &luminances(&light), &end).unwrap();
            let on_the_way = Solution { bases: Arc::new(picture), sweeps, ..solved.clone() };
            let mut snapshot = Snapshot { stage, unshot: unshot.map(Arc::new), ..Snapshot::of(on_the_way) };
            snapshot.timings = Timings::default();
            snapshot.timings.rows = 0.1 * (k + 1) as f64;
            let known = runs.live(0.0).len();
            runs.trace(&snapshot, &lighting, &light);
            let Some(told) = runs.live(0.0).get(known).map(|p| p[1]) else { continue };
            println!("{stage:?}: told {told:.2e}, true {truth:.2e}");
            if truth > 1e-6 {
                assert!(told / truth < 8.0 && truth / told < 8.0, "{stage:?}: {told} against {truth}");
                compared += 1;
            }
        }
        assert!(compared >= 3, "{compared}");
        let live = runs.live(0.02);
        assert!(live.iter().all(|p| p[1] >= 0.02) && live[live.len() - 1][1] < 0.021);
    }

    #[test]
    fn a_light_that_is_refined_has_the_old_error_where_no_row_has_come() {
        let scene = crate::scene::load(&SceneSource::Builtin("cornell".to_owned())).unwrap();
        let lighting = scene.lighting();
        let mut snapshot = few_patches(Arc::new(scene));
        let mut runs = Runs::default();
        runs.note(&snapshot);
        let old = Estimate { error: 0.04, low: 0.03, high: 0.05 };
        runs.checked(ErrorBudget { total: old, ..ErrorBudget::default() });
        for (done, told) in [(25, 0.04 * 0.75_f64.sqrt()), (75, 0.02)] {
            (snapshot.stage, snapshot.rows) = (Stage::Rows, (done, 100));
            snapshot.solution_mut().unwrap().bases = lit();
            snapshot.timings.rows = 0.01 * done as f64;
            runs.trace(&snapshot, &lighting, &PatchLight::default());
            let live = runs.live(0.0);
            assert!((live[live.len() - 1][1] - told).abs() < 1e-12, "{live:?}");
        }
    }

    #[test]
    fn runs_of_other_scenes_stay_and_are_told_apart() {
        let scene =
            |name: &str| Arc::new(crate::scene::load(&SceneSource::Builtin(name.to_owned())).unwrap());
        let known = ["cornell", "hemicube"].map(|name| few_patches(scene(name)));
        let snapshot = |name: &str, patches: usize| Snapshot {
            settings: SolveSettings { patches: PatchTarget::Count(patches), ..SolveSettings::default() },
            ..known[usize::from(name == "hemicube")].clone()
        };
        let mut runs = Runs::default();
        let here = |runs: &Runs| runs.finished.iter().filter(|f| f.is_here).count();
        runs.note(&snapshot("cornell", 100));
        runs.note(&snapshot("cornell", 200));
        runs.note(&snapshot("cornell", 100));
        assert_eq!((runs.finished.len(), here(&runs)), (2, 2), "the same settings again replace");
        runs.enter(Some(&SceneSource::Builtin("hemicube".to_owned())));
        assert!(here(&runs) == 0 && runs.last().is_none());
        runs.note(&snapshot("hemicube", 100));
        assert_eq!((runs.finished.len(), here(&runs)), (3, 1));
        runs.enter(Some(&SceneSource::Builtin("cornell".to_owned())));
        assert_eq!(here(&runs), 2);
        for k in 0..40 {
            runs.note(&snapshot("cornell", 1000 + k));
        }
        assert_eq!(runs.finished.len(), KEPT);
    }
}
