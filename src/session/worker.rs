use super::failure::Failure;
use super::handle::{MaterialEdit, Shared, locked};
use super::recompute::{Recompute, same_geometry};
use super::snapshot::Snapshot;
use super::wanted::Wanted;
use crate::mesh::LightSearch;
use crate::scene::{Scene, SceneSource};
use crate::solve::{
    self, Control, ElementLight, Prepared, Progress, RowStore, Run, Solution, SolveSettings, Stage, Timings,
    patch_reflectance, system,
};
use crate::solver::{LightBases, System};
use crate::transport::Transport;
use crate::watch::Cancelled;
use rayon::ThreadPool;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, PoisonError, Weak};
use std::time::{Duration, Instant};

/// What the worker has done so far, and what is in force.
#[derive(Default)]
pub(super) struct State {
    source: Option<SceneSource>,
    /// The last request to open that was answered.
    pub(super) opened: u64,
    pub(super) settings: SolveSettings,
    edits: Vec<MaterialEdit>,
    pub(super) scene: Option<Arc<Scene>>,
    /// The same as it was read.
    pub(super) read: Option<Arc<Scene>>,
    pub(super) prepared: Option<Prepared>,
    /// Whether the light of the lamps has settled with these materials, so that another sky leaves it alone.
    lamps_stand: bool,
    /// The scenes under other skies that this one came from, and itself: an index into one means the same in all.
    pub(super) alike: Vec<Weak<Scene>>,
    /// Rows of a solve that was interrupted.
    pub(super) rows: RowStore,
    pub(super) transport: Option<Arc<dyn Transport>>,
    pub(super) bases: Option<Arc<LightBases>>,
}

pub(super) struct Worker<'a> {
    pub(super) shared: Arc<Shared>,
    on_news: &'a (dyn Fn() + Send + Sync),
    pub(super) snapshot: Snapshot,
    pub(super) state: State,
    /// How the solve of the present scene ended, where it has: converged or stopped.
    pub(super) settled: Option<Stage>,
    /// Why a part of the present request was refused, while the present scene goes on.
    refused: Option<String>,
    /// Apart from the threads that the window draws with: a frame must not queue behind a row.
    pub(super) pool: &'a ThreadPool,
    /// What was refined last at leisure was broken off, and is not begun again before the next request.
    pub(super) broken_off: bool,
}

impl<'a> Worker<'a> {
    pub(super) fn new(
        shared: Arc<Shared>,
        on_news: &'a (dyn Fn() + Send + Sync),
        pool: &'a ThreadPool,
    ) -> Self {
        let (snapshot, state) = (Snapshot::default(), State::default());
        Self { shared, on_news, snapshot, state, settled: None, refused: None, pool, broken_off: false }
    }
}

impl Worker<'_> {
    pub(super) fn run(mut self) {
        let mut answered = 0;
        loop {
            let wanted = {
                let mut wanted = locked(&self.shared.wanted);
                while wanted.generation == answered && !self.shared.quit.load(Ordering::Acquire) {
                    if let Some(target) = self.at_leisure() {
                        drop(wanted);
                        self.refine(target);
                        wanted = locked(&self.shared.wanted);
                        continue;
                    }
                    wanted = self.shared.news_for_worker.wait(wanted).unwrap_or_else(PoisonError::into_inner);
                }
                self.broken_off = false;
                // A stop that came after this request, before it was begun, still holds.
                let stopped = self.shared.stopped.load(Ordering::Acquire);
                self.shared.cancel.store(stopped, Ordering::Release);
                self.shared.cancel_direct.store(stopped, Ordering::Release);
                wanted.clone()
            };
            if self.shared.quit.load(Ordering::Acquire) {
                return;
            }
            answered = wanted.generation;
            let (clock, pool) = (Instant::now(), self.pool);
            self.refused = None;
            let outcome = catch_unwind(AssertUnwindSafe(|| pool.install(|| self.answer(&wanted))));
            match outcome {
                Ok(Ok(done)) => {
                    if self.refused.is_none() || done.mesh {
                        self.snapshot.last_change =
                            Some(Recompute { seconds: clock.elapsed().as_secs_f64(), ..done });
                    }
                    self.snapshot.error = self.refused.take();
                    self.settle(if done.unlit { Stage::Unlit } else { Stage::Converged });
                }
                Ok(Err(Failure::Cancelled)) => {
                    if self.shared.stopped.load(Ordering::Acquire) {
                        self.settle(Stage::Stopped);
                    }
                }
                Ok(Err(Failure::Refused(stage))) => self.publish(stage),
                Ok(Err(Failure::Said(message))) => {
                    self.snapshot.error = Some(message);
                    self.publish(Stage::Failed);
                }
                Err(panic) => self.fail(panic.as_ref()),
            }
        }
    }

    /// Says that something panicked, and begins anew.
    pub(super) fn fail(&mut self, panic: &(dyn std::any::Any + Send)) {
        let text = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no reason given");
        self.snapshot.error =
            Some(format!("the solver stopped by an error of its own ({text}); reopen the scene to go on"));
        self.state = State::default();
        self.settled = None;
        self.publish(Stage::Failed);
    }

    /// The solve has ended thus.
    fn settle(&mut self, stage: Stage) {
        self.settled = Some(stage);
        self.publish(stage);
    }

    /// Recomputes what the difference between the state and the wish calls for, and nothing else.
    fn answer(&mut self, wanted: &Wanted) -> Result<Recompute, Failure> {
        self.check_cancel()?;
        let mut wanted = wanted.clone();
        let mut todo = self.renew(&mut wanted)?;
        let prepared = self.state.prepared.clone().ok_or(Failure::Cancelled)?;
        let edits = wanted.edits.of(&self.state.alike).to_vec();
        let stands = !todo.mesh
            && !todo.daylight
            && wanted.settings == self.state.settings
            && edits == self.state.edits;
        if self.refused.is_some()
            && stands
            && let Some(stage) = self.settled
        {
            return Err(Failure::Refused(stage));
        }
        self.settled = None;
        if todo.scene {
            let mut newest = locked(&self.shared.wanted);
            newest.has_come(wanted.opened);
            if wanted.source != self.state.source {
                // It was found in another scene, and its mesh had nothing to do with it.
                wanted.settings.refinement = None;
                newest.settings.refinement = None;
            }
        }
        (self.state.source, self.state.opened) = (wanted.source, wanted.opened);
        self.snapshot.settings.clone_from(&wanted.settings);
        self.state.lamps_stand &= wanted.settings == self.state.settings;
        self.state.settings = wanted.settings;

        let is_same_paint = self.state.edits == edits;
        self.state.lamps_stand &= is_same_paint && !todo.mesh;
        self.state.edits = edits;
        let reflectance = patch_reflectance(&prepared.mesh, &|material| self.reflectance_of(material));
        if let Some(solution) = self.snapshot.solution_mut() {
            solution.set_reflectance(&reflectance);
            solution.settings.clone_from(&self.state.settings);
        }
        let system = system(&prepared, &reflectance);
        if prepared.scene.luminaires.is_empty() && !wanted.unlit {
            todo.unlit = true;
            self.snapshot.rows = (0, prepared.mesh.patches.len());
            (self.snapshot.fraction, self.snapshot.seconds_left) = (1.0, None);
            return Ok(todo);
        }
        if self.state.transport.is_none() {
            todo.rows = prepared.mesh.patches.len() - self.state.rows.known();
            let standing = self.state.bases.as_deref().cloned();
            // What a request that leaves the geometry alone has interrupted goes on from there.
            let mut known = std::mem::take(&mut self.state.rows);
            let passed_on =
                self.with_run(|run| run.first_light(&prepared, &system, standing.is_some(), &mut known));
            self.state.rows = known;
            let passed_on = passed_on?;
            self.lay_out_elements(&prepared, &system)?;
            let begun =
                passed_on.zip(self.element_light()).map(|(light, elements)| elements.with_passed_on(light));
            let standing = standing.or(begun);
            // What another sky that is asked for meanwhile goes on from.
            self.state.bases = standing.clone().map(Arc::new);
            let direct = self.element_light().map(|elements| Arc::clone(&elements.given));
            let lit = system.clone().with_direct(direct.as_ref());
            let mut known = std::mem::take(&mut self.state.rows);
            let elements = self.element_light().cloned();
            let start = self
                .with_run(|run| run.rows(&prepared, &lit, elements.as_deref(), standing, &mut known))
                .inspect(|start| self.state.bases = Some(Arc::new(start.clone())));
            // Rows are used up by it, and another sky does not change them.
            let assembled = start.and_then(|_| {
                self.run_until(|shared| &shared.cancel_direct, |run| run.assemble(&prepared, &mut known))
            });
            // What is left of them, where it was interrupted.
            self.state.rows = known;
            let transport = assembled?;
            self.state.transport = Some(transport.clone());
            if let Some(solution) = self.snapshot.solution_mut() {
                solution.transport = Some(transport);
            }
            self.settle_elements(&prepared, &system)?;
            self.snapshot.unshot = None;
        }
        if todo.daylight && self.state.lamps_stand && self.element_light().is_some_and(|e| e.serves(&system))
        {
            todo.sweeps = self.settle_daylight(&prepared, &system)?;
            (self.snapshot.fraction, self.snapshot.seconds_left) = (1.0, None);
            return Ok(todo);
        }
        let are_new = self.lay_out_elements(&prepared, &system)?;
        // Where another wish has come before the edges of the sun's shadows.
        if self.element_light().is_some_and(|elements| elements.is_glimpsed && elements.serves(&system)) {
            self.find_shadows(&prepared, &system)?;
        }
        // A recoloured material may call for three bands where one did.
        let is_ready = |elements: &Arc<ElementLight>| elements.is_settled && elements.serves(&system);
        if are_new || self.element_light().is_some_and(|elements| !is_ready(elements)) {
            self.settle_elements(&prepared, &system)?;
        }
        let transport = self.state.transport.clone().ok_or(Failure::Cancelled)?;
        if let Some(elements) = self.element_light().map(|elements| ElementLight::clone(elements)) {
            let cancelled = || self.shared.cancel.load(Ordering::Acquire);
            let elements = elements
                .with_reflectance(transport.as_ref(), &system, &cancelled)
                .map_err(|Cancelled| Failure::Cancelled)?;
            if let Some(solution) = self.snapshot.solution_mut() {
                solution.element_light = Some(Arc::new(elements));
            }
        }
        let system = system.with_direct(self.element_light().map(|elements| &elements.given));
        let start = self.state.bases.clone();
        let tolerance = self.state.settings.tolerance;
        let (bases, sweeps) = self.with_run(|run| {
            run.sweeps(&prepared, transport.as_ref(), &system, start.as_deref(), tolerance)
        })?;
        todo.sweeps = sweeps.len();
        let timings = self.snapshot.timings;
        let plan = (todo.rows > 0).then(|| solve::measured(&prepared, system.lamps, &timings));
        let bases = Arc::new(bases);
        self.state.bases = Some(bases.clone());
        self.state.lamps_stand = true;
        if let Some(solution) = self.snapshot.solution_mut() {
            (solution.bases, solution.sweeps, solution.timings) = (bases, sweeps, timings);
            if let Some(plan) = plan {
                solution.plan = Arc::new(plan);
            }
        }
        (self.snapshot.fraction, self.snapshot.seconds_left) = (1.0, None);
        Ok(todo)
    }

    /// The reflectance that the user gave a material.
    pub(super) fn reflectance_of(&self, material: u32) -> Option<[f64; 3]> {
        self.state.edits.iter().rev().find(|edit| edit.material == material).map(|edit| edit.reflectance)
    }

    pub(super) fn element_light(&self) -> Option<&Arc<ElementLight>> {
        self.snapshot.solution.as_ref()?.element_light.as_ref()
    }

    /// Computes direct light on elements, unless that stands already, and shows it. Whether there was something to
    /// compute.
    fn lay_out_elements(&mut self, prepared: &Prepared, system: &System) -> Result<bool, Failure> {
        let target = &prepared.direct;
        if self.snapshot.solution.is_none() || self.element_light().is_some_and(|e| e.target.serves(target)) {
            return Ok(false);
        }
        let known = std::mem::take(&mut self.state.rows);
        let elements = self.with_run(|run| run.elements(prepared, system, &known));
        self.state.rows = known;
        let elements = elements?;
        if let Some(solution) = self.snapshot.solution_mut() {
            solution.element_light = elements.map(Arc::new);
        }
        Ok(true)
    }

    /// The transport stands that the light of the patches comes from, direct light included.
    pub(super) fn settle_elements(&mut self, prepared: &Prepared, system: &System) -> Result<(), Failure> {
        let Some(transport) = self.state.transport.clone() else { return Ok(()) };
        let Some(elements) = self.element_light().map(|elements| ElementLight::clone(elements)) else {
            return Ok(());
        };
        let settled = self.with_run(|run| run.settle(prepared, elements, transport.as_ref(), system))?;
        if let Some(solution) = self.snapshot.solution_mut() {
            solution.element_light = Some(Arc::new(settled));
        }
        Ok(())
    }

    /// Reads and meshes what is wanted, where that is called for. What is refused is struck off the wish, and
    /// what is left of it holds for the present scene.
    fn renew(&mut self, wanted: &mut Wanted) -> Result<Recompute, Failure> {
        let Snapshot { fraction, seconds_left, rows, timings, .. } = self.snapshot;
        loop {
            let mut todo = Recompute::between(&self.state, wanted);
            match self.take_up(wanted, &mut todo) {
                Ok(()) => return Ok(todo),
                Err(Failure::Said(sentence)) if self.state.prepared.is_some() => {
                    // How far that had come is nothing to the present scene.
                    (self.snapshot.fraction, self.snapshot.seconds_left) = (fraction, seconds_left);
                    (self.snapshot.rows, self.snapshot.timings) = (rows, timings);
                    self.give_up(wanted, todo, sentence);
                }
                Err(other) => return Err(other),
            }
        }
    }

    fn take_up(&mut self, wanted: &Wanted, todo: &mut Recompute) -> Result<(), Failure> {
        if todo.scene {
            let source = wanted.source.as_ref().ok_or(Failure::Cancelled)?;
            let scene = Arc::new(self.with_run(|run| run.load(source))?);
            let load = self.snapshot.timings.load;
            self.check_cancel()?;
            self.prepare(scene, wanted, todo, Timings { load, ..Timings::default() })
        } else if todo.mesh {
            let read = self.state.read.clone().ok_or(Failure::Cancelled)?;
            let scene = if todo.lamps || todo.daylight {
                self.other_scene(wanted, &read)?
            } else {
                self.state.scene.clone().ok_or(Failure::Cancelled)?
            };
            self.prepare(scene, wanted, todo, self.snapshot.timings)
        } else if todo.daylight {
            self.take_up_daylight(wanted)
        } else {
            Ok(())
        }
    }

    /// A scene was refused, or else the settings: wants those in force again.
    fn give_up(&mut self, wanted: &mut Wanted, refused: Recompute, sentence: String) {
        let mut newest = locked(&self.shared.wanted);
        if refused.scene {
            self.state.opened = wanted.opened;
            wanted.return_to(self.state.source.clone());
            if newest.opened == wanted.opened {
                newest.return_to(self.state.source.clone());
            }
        } else {
            if let (true, Some(read), Some(scene)) = (refused.lamps, &self.state.read, &self.state.scene) {
                newest.return_to_lamps(wanted, read, scene);
            }
            if let (true, Some(read), Some(scene)) = (refused.daylight, &self.state.read, &self.state.scene) {
                newest.return_to_daylight(wanted, read, scene);
            }
            wanted.settings.clone_from(&self.state.settings);
            if newest.generation == wanted.generation {
                newest.settings.clone_from(&self.state.settings);
            }
        }
        drop(newest);
        self.snapshot.error = Some(sentence.clone());
        self.refused.get_or_insert(sentence);
    }

    /// Meshes a scene; keeps the rows where the geometry turns out the same.
    fn prepare(
        &mut self,
        scene: Arc<Scene>,
        wanted: &Wanted,
        todo: &mut Recompute,
        timings: Timings,
    ) -> Result<(), Failure> {
        let before = self.state.prepared.as_ref().filter(|old| Arc::ptr_eq(&old.scene, &scene));
        let is_same_scene = before.is_some();
        let survey = (before.map(|old| old.survey.clone()), LightSearch::Full);
        let prepared = self.with_run(|run| run.prepare(scene.clone(), &wanted.settings, survey))?;
        self.check_cancel()?;
        let same = !todo.method
            && self.state.prepared.as_ref().is_some_and(|old| same_geometry(&old.mesh, &prepared.mesh));
        if same {
            todo.kept_rows = self.state.transport.is_some();
        } else {
            self.state.rows = RowStore::default();
            self.state.transport = None;
        }
        // The light of the same scene stays, and is refined on its new patches.
        let light = self.state.scene.as_ref().filter(|old| Arc::ptr_eq(old, &scene)).and_then(|_| {
            self.state.bases.as_ref()?.carried(&self.state.prepared.as_ref()?.mesh, &prepared.mesh)
        });
        self.state.bases = light.map(Arc::new);
        self.state.scene = Some(scene.clone());
        if !is_same_scene {
            self.state.alike = vec![Arc::downgrade(&scene)];
        }
        if todo.scene {
            (self.state.read, self.snapshot.read) = (Some(scene.clone()), Some(scene.clone()));
        }
        let Timings { mesh, plan, .. } = prepared.timings;
        self.snapshot.timings = Timings { mesh, plan, ..timings };
        let mut solution = Solution::new(&prepared, &wanted.settings);
        solution.transport.clone_from(&self.state.transport);
        if same && is_same_scene {
            // Where finer ones are asked for, these stay on screen until those are there.
            solution.element_light = self.element_light().cloned();
        }
        if let Some(bases) = &self.state.bases {
            solution.bases.clone_from(bases);
        }
        self.snapshot.solution = Some(Arc::new(solution));
        self.snapshot.mesh_serial += 1;
        self.snapshot.unshot = None;
        self.snapshot.error.clone_from(&self.refused);
        self.snapshot.settings = wanted.settings.clone();
        self.state.prepared = Some(prepared);
        self.publish(Stage::Meshing);
        Ok(())
    }

    fn check_cancel(&self) -> Result<(), Failure> {
        if self.shared.cancel.load(Ordering::Acquire) { Err(Failure::Cancelled) } else { Ok(()) }
    }

    /// Runs a part of the pipeline, publishing its progress and resting while paused. Any request ends it.
    pub(super) fn with_run<T, E: Into<Failure>>(
        &mut self,
        part: impl FnOnce(&mut Run<'_>) -> Result<T, E>,
    ) -> Result<T, Failure> {
        self.run_until(|shared| &shared.cancel, part)
    }

    /// The same until this flag is set.
    fn run_until<T, E: Into<Failure>>(
        &mut self,
        cancel: impl Fn(&Shared) -> &AtomicBool,
        part: impl FnOnce(&mut Run<'_>) -> Result<T, E>,
    ) -> Result<T, Failure> {
        let shared = self.shared.clone();
        let timings = self.snapshot.timings;
        let mut observer = |progress: Progress<'_>| {
            self.snapshot.fraction = progress.fraction;
            self.snapshot.seconds_left = progress.seconds_left;
            self.snapshot.rows = progress.rows;
            self.snapshot.timings = progress.timings;
            let picture = progress.picture();
            if picture.is_some() {
                self.snapshot.unshot = progress.unshot().map(Arc::new);
            }
            if let Some(solution) = self.snapshot.solution_mut() {
                if !progress.sweeps.is_empty() {
                    solution.sweeps = progress.sweeps.to_vec();
                }
                if let Some(picture) = picture {
                    solution.bases = Arc::new(picture);
                }
            }
            self.publish(progress.stage);
            // A scene is read and cut all the same: there is to be something to look at.
            match progress.stage {
                Stage::Loading | Stage::Meshing => Control::Continue,
                stage => Control::Rested(self.rest_while_paused(stage)),
            }
        };
        let mut run = Run::new(&mut observer, cancel(&shared), timings);
        let result = part(&mut run);
        let timings = run.timings;
        self.snapshot.timings = timings;
        result.map_err(E::into)
    }

    /// Waits while the user wants it to rest; how long that was.
    pub(super) fn rest_while_paused(&mut self, stage: Stage) -> Duration {
        if !self.shared.paused.load(Ordering::Acquire) {
            return Duration::ZERO;
        }
        let clock = Instant::now();
        self.publish(stage);
        let shared = self.shared.clone();
        let mut wanted = locked(&shared.wanted);
        while shared.paused.load(Ordering::Acquire) && !shared.cancel.load(Ordering::Acquire) {
            wanted = shared.news_for_worker.wait(wanted).unwrap_or_else(PoisonError::into_inner);
        }
        drop(wanted);
        self.publish(stage);
        clock.elapsed()
    }

    pub(super) fn publish(&mut self, stage: Stage) {
        self.snapshot.stage = stage;
        self.snapshot.paused = self.shared.paused.load(Ordering::Acquire);
        self.snapshot.serial += 1;
        *locked(&self.shared.latest) = Arc::new(self.snapshot.clone());
        (self.on_news)();
    }
}
