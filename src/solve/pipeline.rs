//! One solve from a scene to its light, step by step; the worker and the command line share it.

use super::arriving::Arriving;
use super::effect_costs;
use super::error::PipelineError;
use super::solution::Solution;
use super::store::RowStore;
use crate::effects::{self, Effect, EffectChoices, EffectPlan};
use crate::form_factors::{Method, ReceivingPoints, RowComputer, Sampling};
use crate::memory;
use crate::mesh::{self, LightSearch, MeshSettings, Patch, PatchMesh, PatchTarget, Refinement, Survey};
use crate::scene::{DaylightChoice, MAX_REFLECTANCE, Scene, SceneError};
use crate::solver::{GaussSeidel, LightBases, SweepReport, System};
use crate::transport::{DenseTransport, Transport, TransportKind, TreeTransport};
use crate::watch::Watch;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Bytes that meshing and direct light take of any scene, and for each of its triangles. Measured: 440 MB for a
/// kitchen of 150,000.
const BYTES_ANY: f64 = 6e7;
const BYTES_TRIANGLE: f64 = 3e3;

/// Everything besides the scene that a solve depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveSettings {
    /// How finely surfaces are split.
    pub patches: PatchTarget,
    /// Where they are split more finely than elsewhere, besides beside lamps.
    pub refinement: Option<Arc<Refinement>>,
    /// How form factors are computed.
    pub method: Method,
    /// Half-planes, cells along an edge or rays a row; `None` takes the method's default.
    pub resolution: Option<u32>,
    /// At how many points of a patch its row is gathered.
    pub points: ReceivingPoints,
    /// How finely direct light is laid out.
    pub direct: DirectTarget,
    /// What carries the light between patches.
    pub transport: TransportKind,
    /// The solve stops at this relative error bound; above zero.
    pub tolerance: f64,
    /// Effects forced on or off.
    pub effects: EffectChoices,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            patches: PatchTarget::default(),
            refinement: None,
            method: Method::default(),
            resolution: None,
            points: ReceivingPoints::default(),
            direct: DirectTarget::default(),
            transport: TransportKind::default(),
            tolerance: 1e-4,
            effects: EffectChoices::default(),
        }
    }
}

impl SolveSettings {
    /// What rows depend on besides the mesh and the effects.
    pub fn sampling(&self) -> Sampling {
        Sampling { method: self.method, resolution: self.resolution, points: self.points }
    }
}

/// How finely direct light is laid out on elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectTarget {
    /// What it is to be off by at most, as [`crate::direct::ElementSettings::error`] has it; above zero.
    pub error: f64,
    /// Elements at most, besides the triangles of the mesh.
    pub most: usize,
    /// Work at most, as [`crate::direct::ElementSettings::work`] has it.
    pub work: u64,
}

impl DirectTarget {
    /// Whether light that was laid out so is at least as fine as another target asks.
    pub fn serves(&self, other: &Self) -> bool {
        self.error <= other.error && self.most >= other.most && self.work >= other.work
    }
}

impl Default for DirectTarget {
    fn default() -> Self {
        // Some seconds on two cores, where much stands before the lamps.
        Self { error: 0.005, most: 200_000, work: 50_000_000 }
    }
}

/// Where a solve stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Nothing asked for yet.
    #[default]
    Idle,
    /// Reading the model.
    Loading,
    /// Splitting surfaces into patches and deciding effects.
    Meshing,
    /// Rows of the luminaires: direct light everywhere.
    FirstLight,
    /// Direct light in detail.
    Elements,
    /// All other rows, brightest first.
    Rows,
    /// Making the rows reciprocal and closed.
    Balancing,
    /// Gauss-Seidel.
    Sweeping,
    /// Done to the tolerance.
    Converged,
    /// The scene has no lamp, so that there is no light to compute: nothing is solved.
    Unlit,
    /// Ended by the user.
    Stopped,
    /// Ended by an error; the snapshot holds the message.
    Failed,
}

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Reading and checking the model.
    pub load: f64,
    /// Splitting into patches.
    pub mesh: f64,
    /// Of that the survey, which further meshes of the scene need not make again.
    pub survey: f64,
    /// Deciding effects.
    pub plan: f64,
    /// From the start of the rows until direct light was everywhere; where the light of an earlier solve is
    /// refined, until the last row: each patch gathers its own.
    pub first_light: f64,
    /// Direct light on elements.
    pub elements: f64,
    /// All rows, first light included.
    pub rows: f64,
    /// Making rows reciprocal and closed.
    pub balance: f64,
    /// Sweeps.
    pub sweeps: f64,
}

impl Timings {
    /// All of a solve, from meshing to the last sweep; reading the model is left out.
    pub fn solve(&self) -> f64 {
        self.mesh + self.plan + self.elements + self.rows + self.balance + self.sweeps
    }
}

/// What an observer of a running solve is told, some ten times a second and at every change of stage.
pub struct Progress<'a> {
    /// Where it stands.
    pub stage: Stage,
    /// Of the whole solve, 0 to 1; while a model is read or cut into patches, of that alone.
    pub fraction: f64,
    /// Estimate of the time left of the same, seconds, once there is one.
    pub seconds_left: Option<f64>,
    /// Rows computed and rows in all.
    pub rows: (usize, usize),
    /// Reports of the sweeps so far.
    pub sweeps: &'a [SweepReport],
    /// Seconds by stage so far.
    pub timings: Timings,
    picture: Option<Pictured<'a>>,
}

/// Where a picture on the way is copied from.
#[derive(Clone, Copy)]
pub(super) enum Pictured<'a> {
    Arriving(&'a Arriving, &'a System),
    Sweeps(&'a GaussSeidel, &'a System),
    Whole(&'a LightBases),
}

impl Progress<'_> {
    /// The picture as it stands, if there is one; copies it.
    pub fn picture(&self) -> Option<LightBases> {
        Some(match self.picture? {
            Pictured::Arriving(arriving, system) => arriving.picture(system),
            Pictured::Sweeps(solver, system) => solver.bases(system),
            Pictured::Whole(light) => light.clone(),
        })
    }

    /// The radiosity that has not been passed on, while rows arrive in a dark scene; copies it.
    pub fn unshot(&self) -> Option<LightBases> {
        match self.picture? {
            Pictured::Arriving(arriving, _) => arriving.unshot(),
            Pictured::Sweeps(..) | Pictured::Whole(_) => None,
        }
    }
}

/// What the observer answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Go on; the solve was made to rest for so long meanwhile, which is none of its time.
    Rested(Duration),
    /// Stop within milliseconds; the solve returns [`PipelineError::Cancelled`].
    Cancel,
}

/// What the solve of a scene rests on: patches, effects and the way to compute rows.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The scene.
    pub scene: Arc<Scene>,
    /// What further meshes of it can rest on.
    pub survey: Arc<Survey>,
    /// Its patches.
    pub mesh: Arc<PatchMesh>,
    /// What is simulated.
    pub plan: Arc<EffectPlan>,
    /// Computes rows.
    pub computer: Arc<RowComputer>,
    /// How finely direct light is to be laid out.
    pub direct: DirectTarget,
    /// What is to carry the light between patches.
    pub transport: TransportKind,
    /// Seconds so far.
    pub timings: Timings,
}

impl Prepared {
    /// The same mesh under another sky, for a scene that has one: its geometry, rows and transport stay.
    ///
    /// # Errors
    /// A sky that cannot be.
    pub fn under(self, sky: &DaylightChoice) -> Result<Self, SceneError> {
        let scene = Arc::new(self.scene.with_daylight(Some(sky))?);
        let outdoors = scene.outdoors.clone().map(Arc::new);
        let mesh = Arc::new(PatchMesh { outdoors, ..PatchMesh::clone(&self.mesh) });
        Ok(Self { scene, mesh, ..self })
    }
}

/// Cuts the scene into patches, decides the effects and readies the rows.
///
/// # Errors
/// The scene cannot be cut into patches as the settings say.
pub fn prepare(scene: Arc<Scene>, settings: &SolveSettings) -> Result<Prepared, PipelineError> {
    Watch::nobody(|watch| prepare_watched(scene, settings, (None, LightSearch::Full), watch))
}

/// As [`prepare`]; with the survey of the scene, where there is one, that is not made again, else it is made
/// by this search.
pub(super) fn prepare_watched(
    scene: Arc<Scene>,
    settings: &SolveSettings,
    (survey, search): (Option<Arc<Survey>>, LightSearch),
    watch: &mut Watch<'_>,
) -> Result<Prepared, PipelineError> {
    let mut timings = Timings::default();
    let clock = Instant::now();
    let triangles = scene.triangle_count();
    memory::check(BYTES_ANY + BYTES_TRIANGLE * triangles as f64)
        .map_err(|shortage| PipelineError::Shortage { triangles, shortage })?;
    let mesh_settings = MeshSettings {
        target: settings.patches,
        backs: effects::backs(&settings.effects),
        textures: !settings.effects.without.contains(&Effect::Textures),
        glass: !settings.effects.without.contains(&Effect::Glass),
        translucency: !settings.effects.without.contains(&Effect::Translucency),
        holes: !settings.effects.without.contains(&Effect::Holes),
        refinement: settings.refinement.clone(),
    };
    let (survey, mut cutting) = match survey.filter(|survey| survey.serves(&mesh_settings)) {
        Some(survey) => (survey, watch.part(0.0, 1.0)),
        None => {
            let survey = Survey::new(&scene, &mesh_settings, search, &mut watch.part(0.0, SURVEYED))?;
            timings.survey = clock.elapsed().as_secs_f64();
            (Arc::new(survey), watch.part(SURVEYED, 1.0))
        }
    };
    let mesh = Arc::new(mesh::build_on(&survey, &scene, &mesh_settings, &mut cutting)?);
    timings.mesh = clock.elapsed().as_secs_f64();

    let clock = Instant::now();
    let plan = Arc::new(effects::plan(&scene, &mesh, &settings.effects));
    timings.plan = clock.elapsed().as_secs_f64();
    let visibility = plan.is_on(Effect::Visibility);
    let sampling = settings.sampling();
    let computer = RowComputer::new_unless(mesh.clone(), sampling, visibility, watch.cancelled())?;
    let computer = Arc::new(computer);
    let SolveSettings { direct, transport, .. } = *settings;
    Ok(Prepared { scene, survey, mesh, plan, computer, direct, transport, timings })
}

/// Reflectance of every patch with some materials changed: `material(index)` gives the new one.
pub fn patch_reflectance(mesh: &PatchMesh, material: &dyn Fn(u32) -> Option<[f64; 3]>) -> Vec<[f64; 3]> {
    let most = |patch: usize, band: usize| {
        MAX_REFLECTANCE - mesh.translucence.at(patch).map_or(0.0, |passing| passing.share[band])
    };
    let of = |(index, p): (usize, &Patch)| match material(p.material) {
        Some(rho) => std::array::from_fn(|b| (rho[b] * p.texture_average[b]).clamp(0.0, most(index, b))),
        None => p.reflectance,
    };
    mesh.patches.iter().enumerate().map(of).collect()
}

/// Runs the parts of a solve and tells an observer how it goes.
pub struct Run<'a> {
    observer: &'a mut dyn FnMut(Progress<'_>) -> Control,
    pub(super) cancel: &'a AtomicBool,
    /// Seconds by stage so far.
    pub timings: Timings,
    last_news: Option<Instant>,
    rested: Duration,
}

/// The seconds of a stage, less those that it rested.
pub(super) struct Clock {
    started: Instant,
    rested: Duration,
}

impl Clock {
    pub(super) fn seconds(&self, run: &Run<'_>) -> f64 {
        self.started.elapsed().saturating_sub(run.rested - self.rested).as_secs_f64()
    }
}

/// Of the time of meshing a survey takes about this share.
const SURVEYED: f64 = 0.9;
/// Sweeps take so much of the time of the rows, about.
pub(super) const SWEEPS: f64 = 0.05;
/// Of the whole solve so much is done once the rows of the lamps are there, elements, all rows, and the balance.
pub(super) const ROWS_OF_LAMPS: f64 = 0.02;
pub(super) const ELEMENTS: f64 = 0.3;
pub(super) const ROWS: f64 = 0.9;
pub(super) const BALANCED: f64 = 0.95;
/// News comes no more often than this.
const NEWS_EVERY: Duration = Duration::from_millis(80);

impl<'a> Run<'a> {
    /// `cancel` may be set from any thread; it is polled every few milliseconds.
    pub fn new(
        observer: &'a mut dyn FnMut(Progress<'_>) -> Control,
        cancel: &'a AtomicBool,
        timings: Timings,
    ) -> Self {
        Self { observer, cancel, timings, last_news: None, rested: Duration::ZERO }
    }

    pub(super) fn clock(&self) -> Clock {
        Clock { started: Instant::now(), rested: self.rested }
    }

    pub(super) fn tell(
        &mut self,
        stage: Stage,
        rows: (usize, usize),
        (fraction, seconds_left): (f64, Option<f64>),
        sweeps: &[SweepReport],
        picture: Option<Pictured<'_>>,
        force: bool,
    ) -> Result<(), PipelineError> {
        if self.cancel.load(Ordering::Relaxed) {
            return Err(PipelineError::Cancelled);
        }
        if !force && self.last_news.is_some_and(|t| t.elapsed() < NEWS_EVERY) {
            return Ok(());
        }
        self.last_news = Some(Instant::now());
        let progress =
            Progress { stage, fraction, seconds_left, rows, sweeps, timings: self.timings, picture };
        match (self.observer)(progress) {
            Control::Continue => Ok(()),
            Control::Rested(time) => {
                self.rested += time;
                Ok(())
            }
            Control::Cancel => Err(PipelineError::Cancelled),
        }
    }

    /// Makes the rows closed, and reciprocal where they are for a matrix. They are emptied on the way, to make room; those
    /// that are left when the run is cancelled are whole.
    pub fn assemble(
        &mut self,
        prepared: &Prepared,
        rows: &mut RowStore,
    ) -> Result<Arc<dyn Transport>, PipelineError> {
        let clock = self.clock();
        let n = prepared.mesh.patches.len();
        let sweeps = SWEEPS * self.timings.rows;
        self.tell(Stage::Balancing, (n, n), (ROWS, Some(2.0 * sweeps)), &[], None, true)?;
        let computer = &prepared.computer;
        let assembled = self.watched(Stage::Balancing, (n, n), ([ROWS, BALANCED], sweeps), |watch| {
            if let Some((plan, mut collapsed)) = rows.take_collapsed() {
                let assembled = TreeTransport::assemble(computer, &plan, &mut collapsed, watch);
                rows.put_back_collapsed(collapsed);
                return Ok(Arc::new(assembled?) as Arc<dyn Transport>);
            }
            let mut raw = rows.take_raw();
            let assembled = DenseTransport::assemble(computer, &mut raw, watch);
            rows.put_back_raw(raw);
            Ok(Arc::new(assembled?) as Arc<dyn Transport>)
        });
        if assembled.is_ok() {
            *rows = RowStore::default();
        }
        self.timings.balance = clock.seconds(self);
        assembled
    }

    /// Sweeps from `start` to the tolerance.
    ///
    /// # Errors
    /// The run was ended.
    pub fn sweeps(
        &mut self,
        prepared: &Prepared,
        transport: &dyn Transport,
        system: &System,
        start: Option<&LightBases>,
        tolerance: f64,
    ) -> Result<(LightBases, Vec<SweepReport>), PipelineError> {
        self.sweeps_of(prepared, transport, system, (start, None), tolerance)
    }

    /// As [`Self::sweeps`], of some columns of the system alone where these are named: the others stay as they start.
    ///
    /// # Errors
    /// The run was ended.
    pub fn sweeps_of(
        &mut self,
        prepared: &Prepared,
        transport: &dyn Transport,
        system: &System,
        start: (Option<&LightBases>, Option<&[usize]>),
        tolerance: f64,
    ) -> Result<(LightBases, Vec<SweepReport>), PipelineError> {
        let clock = self.clock();
        let n = prepared.mesh.patches.len();
        let cancel = self.cancel;
        let cancelled = || cancel.load(Ordering::Relaxed);
        let mut solver = GaussSeidel::new_unless(&prepared.mesh, transport, system, start, &cancelled)?;
        let mut reports: Vec<SweepReport> = Vec::new();
        let first = solver.report(system).error_bound;
        while reports.last().is_none_or(|r| r.error_bound > tolerance) && reports.len() < MOST_SWEEPS {
            let report = solver.sweep(transport, system, &cancelled).ok_or(PipelineError::Cancelled)?;
            reports.push(report);
            self.timings.sweeps = clock.seconds(self);
            // The error falls by about the same factor every sweep.
            let ratio = (first / report.error_bound.max(1e-300)).max(1.01).ln();
            let fall = (first / tolerance).max(1.01).ln();
            let share = (ratio / fall).clamp(0.0, 1.0);
            let left = (share > 0.0).then(|| self.timings.sweeps * (1.0 / share - 1.0));
            self.tell(
                Stage::Sweeping,
                (n, n),
                (BALANCED + (1.0 - BALANCED) * share, left),
                &reports,
                Some(Pictured::Sweeps(&solver, system)),
                true,
            )?;
        }
        let bases = solver.bases(system);
        let columns = system.columns().max(1);
        let is_broken = |own: &&[f32]| own.iter().any(|value| !value.is_finite());
        match bases.values.chunks(columns).filter(is_broken).count() {
            0 => Ok((bases, reports)),
            broken => Err(PipelineError::NotFinite(broken)),
        }
    }
}

/// More sweeps than any scene was seen to need; the bound that was reached is in the last report.
const MOST_SWEEPS: usize = 200;

impl Run<'_> {
    /// All that is left to do of a scene that is ready, with its own materials: rows, from the light of an
    /// earlier solve where one is `standing` on these patches, balance and sweeps.
    pub fn finish(
        &mut self,
        prepared: &Prepared,
        settings: &SolveSettings,
        standing: Option<LightBases>,
    ) -> Result<Solution, PipelineError> {
        let reflectance = patch_reflectance(&prepared.mesh, &|_| None);
        let system = system(prepared, &reflectance);
        let mut known = RowStore::default();
        let passed_on = self.first_light(prepared, &system, standing.is_some(), &mut known)?;
        let elements = self.elements(prepared, &system, &known)?;
        let begun = passed_on.zip(elements.as_ref()).map(|(light, elements)| elements.with_passed_on(light));
        let standing = standing.or(begun);
        let lit = system.clone().with_direct(elements.as_ref().map(|elements| &elements.given));
        let start = self.rows(prepared, &lit, elements.as_ref(), standing, &mut known)?;
        let transport = self.assemble(prepared, &mut known)?;
        let settle = |elements| self.settle(prepared, elements, transport.as_ref(), &system).map(Arc::new);
        let elements = elements.map(settle).transpose()?;
        let system = system.with_direct(elements.as_ref().map(|elements| &elements.given));
        let (bases, sweeps) =
            self.sweeps(prepared, transport.as_ref(), &system, Some(&start), settings.tolerance)?;
        Ok(Solution {
            element_light: elements,
            transport: Some(transport),
            bases: Arc::new(bases),
            sweeps,
            timings: self.timings,
            ..Solution::new(prepared, settings)
        })
    }
}

/// Meshes, computes all rows and sweeps to the tolerance on the calling thread (and rayon's).
pub fn solve(
    scene: Arc<Scene>,
    settings: &SolveSettings,
    cancel: &AtomicBool,
    observer: &mut dyn FnMut(Progress<'_>) -> Control,
) -> Result<Solution, PipelineError> {
    let mut run = Run::new(observer, cancel, Timings::default());
    let prepared = run.prepare(scene, settings, (None, LightSearch::Full))?;
    let mut solution = run.finish(&prepared, settings, None)?;
    solution.plan = Arc::new(effect_costs::measured(&prepared, solution.bases.lamps, &solution.timings));
    Ok(solution)
}

/// What there is to tell of a scene without lamps: patches and effects, no form factors, and no light.
///
/// # Errors
/// Where the scene cannot be cut into patches.
pub fn without_light(scene: Arc<Scene>, settings: &SolveSettings) -> Result<Solution, PipelineError> {
    let prepared = prepare(scene, settings)?;
    let patches = prepared.mesh.patches.len();
    let bands = system(&prepared, &patch_reflectance(&prepared.mesh, &|_| None)).bands;
    let bases = Arc::new(LightBases { patches, bands, ..LightBases::default() });
    Ok(Solution { bases, ..Solution::new(&prepared, settings) })
}

/// The right-hand sides of a prepared scene with these reflectances.
pub fn system(prepared: &Prepared, reflectance: &[[f64; 3]]) -> System {
    let grey = |rho: &[f64; 3]| rho[0] == rho[1] && rho[1] == rho[2];
    // A grey scene may have been given a coloured material since it was planned.
    let colour = prepared.plan.is_on(Effect::ColourBands) || !reflectance.iter().all(grey);
    let forced_off = prepared
        .plan
        .decisions
        .iter()
        .any(|d| d.effect == Effect::ColourBands && d.state == effects::EffectState::OffByChoice);
    let lighting = prepared.scene.lighting();
    if forced_off {
        let grey: Vec<[f64; 3]> =
            reflectance.iter().map(|&rho| [crate::scene::luminance_weighted(rho); 3]).collect();
        return System::new(&prepared.mesh, &grey, &lighting, false);
    }
    System::new(&prepared.mesh, reflectance, &lighting, colour)
}
