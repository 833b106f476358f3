//! What the worker publishes.

use super::recompute::Recompute;
use crate::effects::EffectPlan;
use crate::form_factors::RowComputer;
use crate::mesh::PatchMesh;
use crate::scene::Scene;
use crate::solve::{ElementLight, Solution, SolveSettings, Stage, Timings};
use crate::solver::{LightBases, SweepReport};
use crate::transport::Transport;
use std::sync::Arc;

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
    /// Of the whole solve, 0 to 1; while a model is read or cut into patches, of that alone.
    pub fraction: f64,
    /// Estimate of the time left of the same, seconds.
    pub seconds_left: Option<f64>,
    /// While light that has settled is made finer: how far that has come, 0 to 1.
    pub refining: Option<f64>,
    /// Rows computed and rows in all.
    pub rows: (usize, usize),
    /// The present scene as far as it is solved; stays when opening another fails.
    pub solution: Option<Arc<Solution>>,
    /// The scene as it was read, without what [`super::Session::set_lamps`] has changed.
    pub read: Option<Arc<Scene>>,
    /// While rows arrive, the radiosity that they have not passed on yet, per luminaire.
    pub unshot: Option<Arc<LightBases>>,
    /// Seconds by stage of the present request.
    pub timings: Timings,
    /// What the last request recomputed.
    pub last_change: Option<Recompute>,
    /// Why the last request failed, in one sentence; `None` once a request succeeds. A scene or settings
    /// that were refused leave the present scene and its stage whole.
    pub error: Option<String>,
    /// Settings in force.
    pub settings: SolveSettings,
}

impl Snapshot {
    /// That of a finished solve.
    pub fn of(solution: Solution) -> Self {
        let patches = solution.mesh.patches.len();
        Self {
            stage: Stage::Converged,
            fraction: 1.0,
            rows: (patches, patches),
            timings: solution.timings,
            settings: solution.settings.clone(),
            solution: Some(Arc::new(solution)),
            ..Self::default()
        }
    }

    /// The finished solve, once it has converged.
    pub fn solved(&self) -> Option<Arc<Solution>> {
        let whole = self.solution.as_ref().filter(|s| s.transport.is_some() && !s.bases.values.is_empty())?;
        (self.stage == Stage::Converged).then(|| whole.clone())
    }

    /// The solution, to be changed; those who hold it keep it as it is.
    pub fn solution_mut(&mut self) -> Option<&mut Solution> {
        self.solution.as_mut().map(Arc::make_mut)
    }

    /// Direct light on elements, where it was computed.
    pub fn element_light(&self) -> Option<&Arc<ElementLight>> {
        self.solution.as_ref()?.element_light.as_ref()
    }

    /// The present scene.
    pub fn scene(&self) -> Option<&Arc<Scene>> {
        self.solution.as_ref().map(|s| &s.scene)
    }

    /// Its patches.
    pub fn mesh(&self) -> Option<&Arc<PatchMesh>> {
        self.solution.as_ref().map(|s| &s.mesh)
    }

    /// What is simulated.
    pub fn plan(&self) -> Option<&Arc<EffectPlan>> {
        self.solution.as_ref().map(|s| &s.plan)
    }

    /// Computes rows, for a look at one.
    pub fn computer(&self) -> Option<&Arc<RowComputer>> {
        self.solution.as_ref().map(|s| &s.computer)
    }

    /// How light passes between patches, once all rows are there.
    pub fn transport(&self) -> Option<&Arc<dyn Transport>> {
        self.solution.as_ref()?.transport.as_ref()
    }

    /// The present picture, per luminaire; `None` as long as there is none.
    pub fn bases(&self) -> Option<&Arc<LightBases>> {
        self.solution.as_ref().map(|s| &s.bases).filter(|bases| !bases.values.is_empty())
    }

    /// Reflectance of every patch as solved for.
    pub fn reflectance(&self) -> Option<&Arc<Vec<[f32; 3]>>> {
        self.solution.as_ref().map(|s| &s.reflectance)
    }

    /// One report per sweep of the present solve.
    pub fn sweeps(&self) -> &[SweepReport] {
        self.solution.as_ref().map_or(&[], |s| &s.sweeps)
    }
}
