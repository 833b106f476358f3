use super::failure::Failure;
use super::recompute::{Recompute, same_geometry};
use super::snapshot::Snapshot;
use super::threads;
use super::wanted::{Edits, Wanted};
use crate::form_factors::Row;
use crate::mesh::LightSearch;
use crate::scene::{PlacedLamp, Scene, SceneSource};
use crate::solve::{
    self, Control, ElementLight, Prepared, Progress, Run, Solution, SolveSettings, Stage, Timings,
    patch_reflectance, system,
};
use crate::solver::{LightBases, System};
use crate::transport::Transport;
use crate::watch::Cancelled;
use rayon::ThreadPool;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A changed reflectance, by index into the scene's materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialEdit {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// New reflectance per band, 0 to `MAX_REFLECTANCE`; with a texture, its factor.
    pub reflectance: [f64; 3],
}

struct Shared {
    wanted: Mutex<Wanted>,
    news_for_worker: Condvar,
    /// Set with every request: ends what runs.
    cancel: AtomicBool,
    paused: AtomicBool,
    /// The user ended the solve; cleared by the next request.
    stopped: AtomicBool,
    quit: AtomicBool,
    latest: Mutex<Arc<Snapshot>>,
}

/// Neither lock is held while anything can panic, so a poisoned one still holds a whole value.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A handle to the worker thread. Dropping it stops and joins the thread.
pub struct Session {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Session {
    /// Starts the thread, and threads of its own to compute with. `on_news` is called after each
    /// published snapshot, from one of them.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn spawn(on_news: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            wanted: Mutex::default(),
            news_for_worker: Condvar::new(),
            cancel: AtomicBool::new(false),
            paused: AtomicBool::new(false),
            stopped: AtomicBool::new(false),
            quit: AtomicBool::new(false),
            latest: Mutex::default(),
        });
        let pool = threads::solving().map_err(std::io::Error::other)?;
        let thread = std::thread::Builder::new().name("radiosity worker".to_owned()).spawn({
            let shared = shared.clone();
            move || {
                threads::stand_back();
                let worker = Worker {
                    shared,
                    on_news: &on_news,
                    snapshot: Snapshot::default(),
                    state: State::default(),
                    settled: None,
                    refused: None,
                    pool: &pool,
                };
                worker.run();
            }
        })?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// The newest snapshot: one short lock and one clone of an `Arc`.
    pub fn latest(&self) -> Arc<Snapshot> {
        locked(&self.shared.latest).clone()
    }

    /// Opens a scene and solves it; replaces whatever runs. The present scene stays if it fails.
    pub fn open(&self, source: SceneSource) {
        self.request(|wanted| wanted.open(source));
    }

    /// The same with settings of its own. If it fails, those of the present scene stay in force.
    pub fn open_with(&self, source: SceneSource, settings: SolveSettings) {
        self.request(|wanted| wanted.open_with(source, settings));
    }

    /// Solves the present scene again with these settings, reusing what they leave unchanged.
    pub fn set_settings(&self, settings: SolveSettings) {
        self.request(|wanted| wanted.settings = settings);
    }

    /// The settings asked for last, which may not be in force yet; once some are refused, those in force.
    pub fn settings(&self) -> SolveSettings {
        locked(&self.shared.wanted).settings.clone()
    }

    /// Solves again over the stored rows with these reflectances of `scene`, all that differ from its own.
    /// They hold for as long as that scene is the present one, and for no other.
    pub fn set_materials(&self, scene: &Arc<Scene>, materials: Vec<MaterialEdit>) {
        self.request(|wanted| wanted.edits = Edits::new(scene, materials));
    }

    /// Places these lamps in the scene as it was `read`, instead of those that its file places, and solves it.
    /// They hold for as long as that reading is the present one.
    pub fn set_lamps(&self, read: &Arc<Scene>, lamps: Vec<PlacedLamp>) {
        self.request(|wanted| wanted.lamps = Some((Arc::downgrade(read), lamps)));
    }

    /// Lets the solve rest where it is.
    pub fn pause(&self) {
        self.shared.paused.store(true, Ordering::Release);
        self.wake();
    }

    /// Goes on from there; after [`Self::stop`] it starts again, and in a scene without lamps it starts after all.
    pub fn resume(&self) {
        self.shared.paused.store(false, Ordering::Release);
        if self.latest().stage == Stage::Unlit {
            self.request(|wanted| wanted.unlit = true);
        } else if self.shared.stopped.load(Ordering::Acquire) {
            self.request(|_| {});
        } else {
            self.wake();
        }
    }

    /// Ends the solve, and its rest; the picture so far stays.
    pub fn stop(&self) {
        let _held = locked(&self.shared.wanted);
        self.shared.paused.store(false, Ordering::Release);
        self.shared.stopped.store(true, Ordering::Release);
        self.shared.cancel.store(true, Ordering::Release);
        self.shared.news_for_worker.notify_all();
    }

    fn request(&self, change: impl FnOnce(&mut Wanted)) {
        let mut wanted = locked(&self.shared.wanted);
        change(&mut wanted);
        wanted.generation += 1;
        self.shared.stopped.store(false, Ordering::Release);
        self.shared.cancel.store(true, Ordering::Release);
        self.shared.news_for_worker.notify_all();
    }

    fn wake(&self) {
        let _held = locked(&self.shared.wanted);
        self.shared.news_for_worker.notify_all();
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.quit.store(true, Ordering::Release);
        self.shared.cancel.store(true, Ordering::Release);
        self.wake();
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

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
    /// Rows of a solve that was interrupted, a patch each.
    pub(super) rows: Vec<Option<Row>>,
    pub(super) transport: Option<Arc<dyn Transport>>,
    pub(super) bases: Option<Arc<LightBases>>,
}

struct Worker<'a> {
    shared: Arc<Shared>,
    on_news: &'a (dyn Fn() + Send + Sync),
    snapshot: Snapshot,
    state: State,
    /// How the solve of the present scene ended, where it has: converged or stopped.
    settled: Option<Stage>,
    /// Why a part of the present request was refused, while the present scene goes on.
    refused: Option<String>,
    /// Apart from the threads that the window draws with: a frame must not queue behind a row.
    pool: &'a ThreadPool,
}

impl Worker<'_> {
    fn run(mut self) {
        let mut answered = 0;
        loop {
            let wanted = {
                let mut wanted = locked(&self.shared.wanted);
                while wanted.generation == answered && !self.shared.quit.load(Ordering::Acquire) {
                    wanted = self.shared.news_for_worker.wait(wanted).unwrap_or_else(PoisonError::into_inner);
                }
                // A stop that came after this request, before it was begun, still holds.
                let stopped = self.shared.stopped.load(Ordering::Acquire);
                self.shared.cancel.store(stopped, Ordering::Release);
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
                Err(panic) => {
                    let text = panic
                        .downcast_ref::<String>()
                        .map(String::as_str)
                        .or_else(|| panic.downcast_ref::<&str>().copied())
                        .unwrap_or("no reason given");
                    self.snapshot.error = Some(format!(
                        "the solver stopped by an error of its own ({text}); reopen the scene to go on"
                    ));
                    self.state = State::default();
                    self.settled = None;
                    self.publish(Stage::Failed);
                }
            }
        }
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
        let edits = wanted.edits.of(&prepared.scene).to_vec();
        let stands = !todo.mesh && wanted.settings == self.state.settings && edits == self.state.edits;
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
        self.state.settings = wanted.settings;

        let edit_of =
            |material: u32| edits.iter().rev().find(|e| e.material == material).map(|e| e.reflectance);
        let reflectance = patch_reflectance(&prepared.mesh, &edit_of);
        if let Some(solution) = self.snapshot.solution_mut() {
            solution.set_reflectance(&reflectance);
            solution.settings.clone_from(&self.state.settings);
        }
        let system = system(&prepared, &reflectance);
        self.state.edits = edits;

        if prepared.scene.luminaires.is_empty() && !wanted.unlit {
            todo.unlit = true;
            self.snapshot.rows = (0, prepared.mesh.patches.len());
            (self.snapshot.fraction, self.snapshot.seconds_left) = (1.0, None);
            return Ok(todo);
        }
        if self.state.transport.is_none() {
            todo.rows = prepared.mesh.patches.len() - self.state.rows.iter().flatten().count();
            let standing = self.state.bases.as_deref().cloned();
            // What a request that leaves the geometry alone has interrupted goes on from there.
            let mut known = std::mem::take(&mut self.state.rows);
            let rows = self.with_run(|run| run.rows(&prepared, &system, standing, &mut known));
            self.state.rows = known;
            let (mut rows, start) = rows?;
            self.state.bases = Some(Arc::new(start));
            self.lay_out_elements(&prepared, &system)?;
            let assembled = self.with_run(|run| run.assemble(&prepared, &mut rows));
            // What is left of them, where it was interrupted.
            self.state.rows = rows.into_iter().map(Some).collect();
            let transport = assembled?;
            self.state.transport = Some(transport.clone());
            self.settle_elements(&prepared, &system)?;
            if let Some(solution) = self.snapshot.solution_mut() {
                solution.transport = Some(transport);
            }
            self.snapshot.unshot = None;
        }
        let are_new = self.lay_out_elements(&prepared, &system)?;
        // A recoloured material may call for three bands where one did.
        if are_new || self.element_light().is_some_and(|elements| !elements.serves(&system)) {
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
        if let Some(solution) = self.snapshot.solution_mut() {
            (solution.bases, solution.sweeps, solution.timings) = (bases, sweeps, timings);
            if let Some(plan) = plan {
                solution.plan = Arc::new(plan);
            }
        }
        (self.snapshot.fraction, self.snapshot.seconds_left) = (1.0, None);
        Ok(todo)
    }

    fn element_light(&self) -> Option<&Arc<ElementLight>> {
        self.snapshot.solution.as_ref()?.element_light.as_ref()
    }

    /// Computes direct light on elements, unless that stands already, and shows it. Whether there was something to
    /// compute.
    fn lay_out_elements(&mut self, prepared: &Prepared, system: &System) -> Result<bool, Failure> {
        if self.snapshot.solution.as_ref().is_none_or(|s| s.element_light.is_some()) {
            return Ok(false);
        }
        let elements = self.with_run(|run| run.elements(prepared, system))?;
        if let Some(solution) = self.snapshot.solution_mut() {
            solution.element_light = elements.map(Arc::new);
        }
        Ok(true)
    }

    /// The transport stands that the light of the patches comes from, direct light included.
    fn settle_elements(&mut self, prepared: &Prepared, system: &System) -> Result<(), Failure> {
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
            let scene = match wanted.lamps_of(&read).filter(|_| todo.lamps) {
                Some(lamps) if *lamps != read.placed => Arc::new(read.with_placed(lamps.to_vec())),
                Some(_) => read,
                None => self.state.scene.clone().ok_or(Failure::Cancelled)?,
            };
            self.prepare(scene, wanted, todo, self.snapshot.timings)
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
        let survey = (before.map(|old| old.survey.clone()), LightSearch::Full);
        let prepared = self.with_run(|run| run.prepare(scene.clone(), &wanted.settings, survey))?;
        self.check_cancel()?;
        let same = !todo.method
            && self.state.prepared.as_ref().is_some_and(|old| same_geometry(&old.mesh, &prepared.mesh));
        if same {
            todo.kept_rows = self.state.transport.is_some();
        } else {
            self.state.rows = Vec::new();
            self.state.transport = None;
        }
        // The light of the same scene stays, and is refined on its new patches.
        let light = self.state.scene.as_ref().filter(|old| Arc::ptr_eq(old, &scene)).and_then(|_| {
            self.state.bases.as_ref()?.carried(&self.state.prepared.as_ref()?.mesh, &prepared.mesh)
        });
        self.state.bases = light.map(Arc::new);
        self.state.scene = Some(scene.clone());
        if todo.scene {
            (self.state.read, self.snapshot.read) = (Some(scene.clone()), Some(scene.clone()));
        }
        let Timings { mesh, plan, .. } = prepared.timings;
        self.snapshot.timings = Timings { mesh, plan, ..timings };
        let mut solution = Solution::new(&prepared, &wanted.settings);
        solution.transport.clone_from(&self.state.transport);
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

    /// Runs a part of the pipeline, publishing its progress and resting while paused.
    fn with_run<T, E: Into<Failure>>(
        &mut self,
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
        let mut run = Run::new(&mut observer, &shared.cancel, timings);
        let result = part(&mut run);
        let timings = run.timings;
        self.snapshot.timings = timings;
        result.map_err(E::into)
    }

    /// Waits while the user wants it to rest; how long that was.
    fn rest_while_paused(&mut self, stage: Stage) -> Duration {
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

    fn publish(&mut self, stage: Stage) {
        self.snapshot.stage = stage;
        self.snapshot.paused = self.shared.paused.load(Ordering::Acquire);
        self.snapshot.serial += 1;
        *locked(&self.shared.latest) = Arc::new(self.snapshot.clone());
        (self.on_news)();
    }
}
