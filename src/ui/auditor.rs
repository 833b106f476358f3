//! Finds out in the background how wrong the picture is, and keeps what solves cost.

use super::reaching::Way;
use super::runs::{Finished, Runs};
use crate::accuracy::{AuditSettings, ErrorBudget, Findings};
use crate::display::NO_VALUE;
use crate::form_factors::Method;
use crate::mesh::{PatchMesh, PatchTarget, Refinement};
use crate::scene::{LUMINOUS_EFFICACY, Lighting, Scene};
use crate::session::Snapshot;
use crate::solve::{Solution, SolveSettings, Stage};
use crate::solver::{LightBases, PatchLight};
use crate::study::{self, CostModel, Fineness, Goal, Limits, Measured};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Weak};

/// A light that stands for this long is worth checking, seconds.
const SETTLED_SECS: f64 = 0.6;
/// Audits run on one thread, for no longer than this.
const AUDIT_SECS: f64 = 8.0;
/// What a scene is to reach at first.
pub(super) const GOAL: Goal = Goal::Error(0.01);
/// Points of the predicted curve.
const CURVE: usize = 24;

/// What the panel asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ask {
    /// Check pictures, or leave it.
    Switch(bool),
    /// What the next solve is to reach.
    SetGoal(Goal),
    /// Solve until it is reached.
    Reach,
}

/// What the background has found out about a solve.
struct Checked {
    findings: Findings,
    /// Where the next solve towards a goal is to have smaller patches.
    refinement: Refinement,
    /// What work costs on this machine, where rows are computed by lines and it is not known yet.
    pace: Option<study::Pace>,
}

/// A running audit; it ends when this is dropped.
struct Job {
    /// What is audited.
    bases: Arc<LightBases>,
    lighting: Lighting,
    cancel: Arc<AtomicBool>,
    answer: Receiver<Option<Checked>>,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

/// The audits of the window: at most one at a time, none while a solve runs.
pub(super) struct Auditor {
    /// Whether pictures are checked at all.
    pub(super) on: bool,
    /// What the user wishes for.
    pub(super) goal: Goal,
    /// Of the picture on screen; `None` while it is not known.
    pub(super) budget: Option<ErrorBudget>,
    /// Where it is wrong; `None` while it is not known.
    pub(super) findings: Option<Arc<Findings>>,
    /// The last audit found no light to check.
    pub(super) is_dark: bool,
    /// All solves of this session.
    pub(super) runs: Runs,
    /// Foreseen errors of solves of rising cost: seconds and share.
    pub(super) curve: Vec<[f64; 2]>,
    /// Why the goal was given up, or that it was reached.
    pub(super) verdict: String,
    pub(super) model: CostModel,
    pub(super) limits: Limits,
    /// Where the last check would have patches smaller.
    pub(super) refinement: Option<Arc<Refinement>>,
    scene: Weak<Scene>,
    /// What was audited last, or is being audited.
    seen: Option<(Arc<LightBases>, Lighting)>,
    /// The light as it stands, and since when.
    standing: Option<(Arc<LightBases>, Lighting, f64)>,
    job: Option<Job>,
    /// Whether `model` knows the picture on screen: it learns of solves by lines alone.
    is_taught: bool,
    /// The way to the goal, while it is gone.
    pub(super) way: Option<Way>,
}

impl Default for Auditor {
    fn default() -> Self {
        Self {
            on: true,
            goal: GOAL,
            budget: None,
            findings: None,
            is_dark: false,
            runs: Runs::default(),
            curve: Vec::new(),
            verdict: String::new(),
            model: CostModel::default(),
            limits: Limits { fewest: 1.0, most: study::MOST_PATCHES, gigabytes: study::memory() },
            refinement: None,
            scene: Weak::new(),
            seen: None,
            standing: None,
            job: None,
            is_taught: false,
            way: None,
        }
    }
}

impl Auditor {
    /// Whether a picture is being checked.
    pub(super) fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Whether it is on its way to the goal.
    pub(super) fn is_reaching(&self) -> bool {
        self.way.is_some()
    }

    /// Switches audits on or off.
    pub(super) fn switch(&mut self, on: bool) {
        self.on = on;
        self.seen = None;
        if !on {
            self.job = None;
            self.way = None;
        }
    }

    /// Switches audits on, and leaves one that runs alone.
    pub(super) fn ensure_on(&mut self) {
        if !self.on {
            self.switch(true);
        }
    }

    /// Follows the solver, starts an audit once the light stands still, and takes up what one has found.
    /// `light` is that of the picture on screen, if it is the snapshot's. Answers with settings to solve with,
    /// where the goal asks for them. `wake` asks for another frame, from any thread; a number of seconds is how
    /// long until one is needed.
    pub(super) fn follow(
        &mut self,
        snapshot: &Snapshot,
        lighting: &Lighting,
        light: Option<&PatchLight>,
        time: f64,
        wake: impl FnOnce() + Send + 'static,
    ) -> (Option<SolveSettings>, Option<f64>) {
        self.forget_other_scenes(snapshot);
        if let Some(light) = light {
            self.runs.trace(snapshot, lighting, light);
        }
        let standing = (snapshot.stage == Stage::Converged).then_some(()).and(snapshot.bases().cloned());
        let lamps = snapshot.scene().map_or(0, |s| s.luminaires.len());
        // In the dark there is nothing that could be wrong.
        let is_whole = lamps > 0 && snapshot.transport().is_some() && lighting.lamps.len() == lamps;
        let Some(bases) = standing.filter(|_| is_whole) else {
            self.job = None;
            self.standing = None;
            self.seen = None;
            // What was found is of a light that is going, and of patches that may be gone.
            (self.budget, self.findings) = (None, None);
            if matches!(snapshot.stage, Stage::Stopped | Stage::Failed) {
                self.way = None;
            }
            return (None, None);
        };
        let is_other = |job: &Job| !Arc::ptr_eq(&job.bases, &bases) || job.lighting != *lighting;
        if self.job.as_ref().is_some_and(is_other) {
            self.job = None;
        }
        let next = self.take_answer(snapshot);
        let same = |of: &(Arc<LightBases>, Lighting)| Arc::ptr_eq(&of.0, &bases) && of.1 == *lighting;
        if self.seen.as_ref().is_some_and(same) {
            return (next, None);
        }
        let unchanged =
            |(b, l, _): &(Arc<LightBases>, Lighting, f64)| Arc::ptr_eq(b, &bases) && l == lighting;
        if !self.standing.as_ref().is_some_and(unchanged) {
            // A lamp or the solver moved: what was found is of another light.
            let is_solved = self.standing.as_ref().is_none_or(|s| !Arc::ptr_eq(&s.0, &bases));
            if is_solved {
                self.runs.note(snapshot);
            }
            (self.budget, self.findings) = (None, None);
            self.is_dark = false;
            // What the goal had solved is waited for: its time counts.
            let settled = is_solved && self.is_reaching();
            let since = if settled { time - SETTLED_SECS } else { time };
            self.standing = Some((bases.clone(), lighting.clone(), since));
        }
        let since = self.standing.as_ref().map_or(time, |s| s.2);
        if !self.on {
            return (None, None);
        }
        let left = SETTLED_SECS - (time - since);
        if left > 0.0 {
            return (None, Some(left));
        }
        self.seen = Some((bases, lighting.clone()));
        if let Some(solved) = snapshot.solved() {
            self.start(solved, &snapshot.settings, lighting.clone(), wake);
        }
        (None, None)
    }

    fn forget_other_scenes(&mut self, snapshot: &Snapshot) {
        let same = match (snapshot.scene(), self.scene.upgrade()) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, &b),
            (None, None) => true,
            _ => false,
        };
        if !same {
            let (on, goal, mut runs) = (self.on, self.goal, std::mem::take(&mut self.runs));
            runs.enter(snapshot.scene().map(|scene| &scene.source));
            *self = Self { on, goal, runs, ..Self::default() };
            self.scene = snapshot.scene().map_or_else(Weak::new, Arc::downgrade);
        }
    }

    fn start(
        &mut self,
        solved: Arc<Solution>,
        settings: &SolveSettings,
        lighting: Lighting,
        wake: impl FnOnce() + Send + 'static,
    ) {
        let lines = lines_of(settings).filter(|_| self.model.measured().is_empty());
        let cancel = Arc::new(AtomicBool::new(false));
        let (sender, answer) = channel();
        let stop = cancel.clone();
        let of = (solved.bases.clone(), lighting.clone());
        let before = settings.refinement.clone();
        // On the way to a goal no longer and no better than it takes to go on.
        let settings = match &self.way {
            Some(way) => way.run.audit_settings(solved.timings.solve(), way.elapsed()),
            None => {
                let resolve = if let Goal::Error(error) = self.goal { 0.2 * error } else { 1e-3 };
                AuditSettings { seconds: AUDIT_SECS, resolve, ..AuditSettings::default() }
            }
        };
        let settings = AuditSettings { seconds: settings.seconds.max(0.1), parallel: false, ..settings };
        let audit = move || {
            let found = study::audit(&solved, &lighting, &settings, &|| stop.load(Ordering::Relaxed));
            let checked = found.map(|findings| {
                let pace = lines.map(|lines| study::pace(&solved, lines));
                let refinement = study::refined(&solved.mesh, &findings.map_of_patches, before.as_deref());
                Checked { findings, refinement, pace }
            });
            // Nobody listens any more when the light has changed.
            sender.send(checked).ok();
            wake();
        };
        if std::thread::Builder::new().name("audit".to_owned()).spawn(audit).is_ok() {
            let (bases, lighting) = of;
            self.job = Some(Job { bases, lighting, cancel, answer });
        }
    }

    fn take_answer(&mut self, snapshot: &Snapshot) -> Option<SolveSettings> {
        let answer = match self.job.as_ref()?.answer.try_recv() {
            Ok(answer) => answer,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => None,
        };
        self.job = None;
        let is_reaching = self.is_reaching();
        self.is_dark = answer.is_none() && !is_reaching;
        let pace = answer.as_ref().and_then(|a| a.pace);
        let (findings, refinement) = answer.map(|a| (a.findings, a.refinement)).unzip();
        (self.findings, self.refinement) = (findings.map(Arc::new), refinement.map(Arc::new));
        self.budget = self.findings.as_ref().map(|found| found.budget);
        let Some(budget) = self.budget else {
            if is_reaching {
                self.end(format!("{:.1} s, with no light or no time left to check it", self.elapsed()));
            }
            return None;
        };
        self.runs.checked(budget);
        let solved = snapshot.solved()?;
        let settings = &snapshot.settings;
        let known = self.model.measured().last().map(|m| m.pace);
        self.is_taught = lines_of(settings).is_some();
        if let (Some(lines), Some(pace)) = (lines_of(settings), pace.or(known)) {
            if let (PatchTarget::Count(wanted), None) = (settings.patches, &settings.refinement) {
                self.limits.fewest = study::fewest(&solved.mesh, wanted as f64);
            }
            self.model.learn(Measured::of(&solved, lines, pace, Some(&budget)));
            self.draw_curve();
        }
        self.step(&budget, settings, (solved.mesh.patches.len(), solved.timings.solve()))
    }

    fn draw_curve(&mut self) {
        let Some(last) = self.model.measured().last() else { return };
        let now = last.timings.solve();
        let seconds = (0..CURVE).map(|k| now * 10.0_f64.powf(2.0 * k as f64 / (CURVE - 1) as f64));
        let limits = self.limits;
        self.curve = seconds
            .filter_map(|s| Some([s, self.model.error(self.model.best_within(s, limits)?)?]))
            .collect();
    }

    /// Estimated error of every patch, % of the light there (the mean at least), for false colours; `None` while it is
    /// not known.
    pub(super) fn error_percent(&self, mesh: &PatchMesh) -> Option<Vec<f32>> {
        let errors = &self.findings.as_ref()?.map.error;
        let value = |e: &f32| if e.is_nan() { NO_VALUE } else { 100.0 * e };
        (errors.len() == mesh.patches.len()).then(|| errors.iter().map(value).collect())
    }

    /// What rays found at a patch: what the picture shows there less the truth, lx, averaged where they
    /// asked more than once.
    pub(super) fn measured_lux(&self, patch: u32) -> Option<f64> {
        let found = self.findings.as_ref()?;
        let here: Vec<f64> = found.receivers.iter().filter(|r| r.patch == patch).map(|r| r.shown).collect();
        let mean = here.iter().sum::<f64>() / here.len() as f64;
        (!here.is_empty()).then(|| LUMINOUS_EFFICACY * found.budget.mean_irradiance * mean)
    }

    /// What form factors and patches add to the error of the solve that runs, as far as can be foreseen:
    /// from an audit of the same settings, or from the model. Zero where nobody knows.
    pub(super) fn rest_foreseen(&self, snapshot: &Snapshot) -> f64 {
        let same = |f: &&Finished| f.is_here && f.settings == snapshot.settings;
        let audited = self.runs.finished.iter().rev().filter(same).find_map(|f| f.budget);
        let fineness = snapshot
            .mesh()
            .zip(lines_of(&snapshot.settings))
            .map(|(mesh, lines)| Fineness { patches: mesh.patches.len() as f64, lines: f64::from(lines) });
        let known = audited.map(|budget| budget.total.error);
        known.or_else(|| self.model.error(fineness?)).unwrap_or(0.0)
    }

    /// "1 % in about 4 s, 0.3 % in about 21 s": the next round errors below the present one.
    pub(super) fn foresight(&self) -> Option<String> {
        const ROUND: [f64; 12] = [50.0, 30.0, 20.0, 10.0, 5.0, 3.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1];
        let now = self.budget?.total.error;
        let told: Vec<String> = ROUND
            .into_iter()
            .filter(|percent| percent / 100.0 < 0.9 * now)
            .filter_map(|percent| {
                let seconds = self.model.seconds(self.model.cheapest(percent / 100.0, self.limits)?)?;
                Some(format!("{percent} % in about {}", super::units::duration(seconds)))
            })
            .take(2)
            .collect();
        (!told.is_empty()).then(|| told.join(", "))
    }

    /// On what the next seconds are best spent: what takes away most of the error in each.
    pub(super) fn advice(&self) -> Option<&'static str> {
        let budget = self.budget?;
        let (form_factors, mesh) = (budget.form_factors.error, budget.mesh.error);
        let (solver, direct) = (budget.solver.estimate.error, budget.direct.error);
        Some(if solver >= form_factors.max(mesh).max(direct) {
            "further sweeps"
        } else if direct >= form_factors.max(mesh) {
            "finer direct light (wait a moment: a light left alone refines itself)"
        } else if self.model.asks_for_patches().filter(|_| self.is_taught).unwrap_or(mesh >= form_factors) {
            "smaller patches"
        } else {
            "more lines per row"
        })
    }
}

/// Half-planes a row, where rows are computed by lines.
fn lines_of(settings: &SolveSettings) -> Option<u32> {
    let lines = || settings.resolution.unwrap_or_else(|| settings.method.default_resolution());
    (settings.method == Method::Lines).then(lines)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::accuracy::Estimate;
    use crate::effects::EffectChoices;
    use crate::solve::{Control, Timings, solve};

    pub(in crate::ui) fn budget(form_factors: f64, mesh: f64) -> ErrorBudget {
        let estimate = |error: f64| Estimate { error, low: 0.9 * error, high: 1.1 * error };
        ErrorBudget {
            form_factors: estimate(form_factors),
            mesh: estimate(mesh),
            total: estimate(form_factors.hypot(mesh)),
            ..ErrorBudget::default()
        }
    }

    pub(in crate::ui) fn auditor(form_factors: f64, mesh: f64) -> Auditor {
        let mut auditor = Auditor { budget: Some(budget(form_factors, mesh)), ..Auditor::default() };
        auditor.model.learn(Measured {
            timings: Timings { rows: 0.3, sweeps: 0.1, ..Timings::default() },
            entries: 3e5,
            ..Measured::example(1000.0, 96.0, [form_factors, mesh])
        });
        auditor
    }

    #[test]
    fn the_sentence_names_round_errors_below_the_present_one_at_rising_cost() {
        let auditor = auditor(0.01, 0.04);
        let told = auditor.foresight().unwrap();
        assert!(told.starts_with("3 % in about ") && told.contains(", 2 % in about "), "{told}");
        assert_eq!(auditor.advice(), Some("smaller patches"));
        assert_eq!(Auditor::default().foresight(), None);
    }

    /// A coarse light that has converged.
    fn converged() -> Snapshot {
        let scene = crate::scene::load(&crate::scene::SceneSource::Builtin("cornell".to_owned())).unwrap();
        let settings = SolveSettings {
            patches: PatchTarget::Count(60),
            resolution: Some(16),
            ..SolveSettings::default()
        };
        let never = AtomicBool::new(false);
        let solved = solve(Arc::new(scene), &settings, &never, &mut |_| Control::Continue).unwrap();
        Snapshot::of(solved)
    }

    /// An auditor on its way to a goal, whose audit of this light has ended.
    fn answered(snapshot: &Snapshot, lighting: &Lighting) -> Auditor {
        let mut auditor = Auditor::default();
        assert_eq!(auditor.follow(snapshot, lighting, None, 0.0, || {}).0, None);
        let bases = snapshot.bases().cloned().unwrap();
        let (sender, answer) = channel();
        let findings = Findings { budget: budget(0.001, 0.002), ..Findings::default() };
        let refinement = Refinement::default();
        sender.send(Some(Checked { findings, refinement, pace: None })).unwrap();
        auditor.seen = Some((bases.clone(), lighting.clone()));
        auditor.way = Some(Way::new(auditor.goal, EffectChoices::default(), auditor.limits));
        auditor.job = Some(Job { bases, lighting: lighting.clone(), cancel: Arc::default(), answer });
        auditor
    }

    #[test]
    fn an_answer_is_of_the_light_that_it_was_asked_of_alone() {
        let snapshot = converged();
        let lighting = snapshot.scene().unwrap().lighting();
        let mut auditor = answered(&snapshot, &lighting);
        auditor.follow(&snapshot, &lighting, None, 1.0, || {});
        assert_eq!(auditor.budget, Some(budget(0.001, 0.002)));
        assert!(auditor.verdict.starts_with("Reached"), "{}", auditor.verdict);

        let mut auditor = answered(&snapshot, &lighting);
        let mut switched = lighting.clone();
        switched.lamps[0].on = false;
        auditor.follow(&snapshot, &switched, None, 0.1, || {});
        assert!(auditor.budget.is_none() && auditor.findings.is_none() && !auditor.is_busy());
        assert!(auditor.is_reaching() && auditor.verdict.is_empty(), "{}", auditor.verdict);
    }

    #[test]
    fn what_was_found_goes_with_the_light_that_it_was_found_in() {
        let mut snapshot = converged();
        let lighting = snapshot.scene().unwrap().lighting();
        let mut auditor = answered(&snapshot, &lighting);
        auditor.follow(&snapshot, &lighting, None, 1.0, || {});
        assert!(auditor.budget.is_some());
        (snapshot.stage, snapshot.mesh_serial) = (Stage::Rows, 2);
        auditor.follow(&snapshot, &lighting, None, 1.1, || {});
        assert!(auditor.budget.is_none() && auditor.findings.is_none());
    }

    #[test]
    fn the_curve_falls_with_time() {
        let mut auditor = auditor(0.01, 0.04);
        auditor.draw_curve();
        assert!(auditor.curve.len() > 10);
        assert!(auditor.curve.windows(2).all(|w| w[0][0] < w[1][0] && w[0][1] >= w[1][1]));
    }
}
