//! Stages whose work is watched: reading, meshing, balancing.

use super::error::PipelineError;
use super::pipeline::{Clock, Prepared, Run, SolveSettings, Stage, Timings, prepare_watched};
use crate::mesh::{LightSearch, Survey};
use crate::scene::{self, Scene, SceneError, SceneSource};
use crate::watch::Watch;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Times are extrapolated once so much of the work is done.
const ENOUGH: f64 = 0.05;

impl Run<'_> {
    /// Reads a model.
    ///
    /// # Errors
    /// As [`scene::load`]; [`SceneError::Cancelled`] where the run was ended.
    pub fn load(&mut self, source: &SceneSource) -> Result<Scene, SceneError> {
        let clock = self.clock();
        self.tell(Stage::Loading, (0, 0), (0.0, None), &[], None, true).map_err(|_| SceneError::Cancelled)?;
        let read = |watch: &mut Watch<'_>| scene::load_watched(source, watch);
        let scene = self.watched(Stage::Loading, (0, 0), ([0.0, 1.0], 0.0), read)?;
        self.timings.load = clock.seconds(self);
        Ok(scene)
    }

    /// Cuts a scene into patches, decides the effects and readies the rows. With the survey of the scene,
    /// where there is one, that is not made again, else it is made by this search.
    ///
    /// # Errors
    /// The scene cannot be cut into patches as the settings say, or the run was ended.
    pub fn prepare(
        &mut self,
        scene: Arc<Scene>,
        settings: &SolveSettings,
        survey: (Option<Arc<Survey>>, LightSearch),
    ) -> Result<Prepared, PipelineError> {
        self.tell(Stage::Meshing, (0, 0), (0.0, None), &[], None, true)?;
        let cut = |watch: &mut Watch<'_>| prepare_watched(scene, settings, survey, watch);
        let prepared = self.watched(Stage::Meshing, (0, 0), ([0.0, 1.0], 0.0), cut)?;
        let Timings { mesh, survey, plan, .. } = prepared.timings;
        self.timings = Timings { mesh, survey, plan, ..self.timings };
        Ok(prepared)
    }

    /// Does the work of a stage and tells the observer how far it is: from one fraction of the whole to
    /// another. What comes after it takes `rest` seconds, about.
    pub(super) fn watched<T>(
        &mut self,
        stage: Stage,
        rows: (usize, usize),
        ([from, to], rest): ([f64; 2], f64),
        work: impl FnOnce(&mut Watch<'_>) -> T,
    ) -> T {
        let (clock, cancel): (Clock, &AtomicBool) = (self.clock(), self.cancel);
        let ended = AtomicBool::new(false);
        let cancelled = || cancel.load(Ordering::Relaxed) || ended.load(Ordering::Relaxed);
        let mut report = |share: f64| {
            let seconds = clock.seconds(self);
            let left = (share >= ENOUGH).then(|| seconds * (1.0 / share - 1.0) + rest);
            let fraction = from + (to - from) * share;
            if self.tell(stage, rows, (fraction, left), &[], None, false).is_err() {
                ended.store(true, Ordering::Relaxed);
            }
        };
        work(&mut Watch::new(&cancelled, &mut report))
    }
}
