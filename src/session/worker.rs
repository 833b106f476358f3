use super::pipeline::{SolveSettings, Stage, Timings};
use crate::effects::EffectPlan;
use crate::mesh::PatchMesh;
use crate::scene::{Scene, SceneSource};
use crate::solver::{LightBases, SweepReport};
use std::sync::Arc;

/// A changed reflectance, by index into the scene's materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialEdit {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// New reflectance per band, 0 to `MAX_REFLECTANCE`; with a texture, its factor.
    pub reflectance: [f64; 3],
}

/// What the worker has published last: immutable and cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Counts the snapshots; grows with each.
    pub serial: u64,
    /// Grows with each new mesh: tells the viewport to upload it.
    pub mesh_serial: u64,
    /// Where the solve stands.
    pub stage: Stage,
    /// Asked to pause; rows and sweeps rest.
    pub paused: bool,
    /// Of the whole solve, 0 to 1.
    pub fraction: f64,
    /// Estimate of the time left, seconds.
    pub seconds_left: Option<f64>,
    /// Rows computed and rows in all.
    pub rows: (usize, usize),
    /// The present scene; stays when opening another fails.
    pub scene: Option<Arc<Scene>>,
    /// Its patches.
    pub mesh: Option<Arc<PatchMesh>>,
    /// What is simulated.
    pub plan: Option<Arc<EffectPlan>>,
    /// The present picture, a luminaire each.
    pub bases: Option<Arc<LightBases>>,
    /// Reflectance of every patch as solved for.
    pub reflectance: Arc<Vec<[f32; 3]>>,
    /// One report a sweep of the present solve.
    pub sweeps: Arc<Vec<SweepReport>>,
    /// Seconds by stage.
    pub timings: Timings,
    /// What the last request recomputed: "plaster 0.8: 0 rows, 3 sweeps, 40 ms".
    pub last_change: String,
    /// Why the last request failed, in one sentence; `None` once a request succeeds.
    pub error: Option<String>,
    /// Settings in force.
    pub settings: SolveSettings,
}

/// A handle to the worker thread. Dropping it stops and joins the thread.
pub struct Session {}

impl Session {
    /// Starts the thread. `on_news` is called from it after each published snapshot.
    pub fn spawn(_on_news: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self {})
    }

    /// The newest snapshot: one short lock and one clone of an `Arc`.
    pub fn latest(&self) -> Arc<Snapshot> {
        Arc::default()
    }

    /// Opens a scene and solves it; replaces whatever runs. The present scene stays if it fails.
    pub fn open(&self, _source: SceneSource) {}

    /// Solves the present scene again with these settings, reusing what they leave unchanged.
    pub fn set_settings(&self, _settings: SolveSettings) {}

    /// Solves again over the stored rows with these reflectances (all edits since opening).
    pub fn set_materials(&self, _edits: Vec<MaterialEdit>) {}

    /// Lets the solve rest where it is.
    pub fn pause(&self) {}

    /// Goes on from there.
    pub fn resume(&self) {}

    /// Ends the solve; the picture so far stays.
    pub fn stop(&self) {}
}
