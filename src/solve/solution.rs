//! What a solve comes to, as one value that all who use it share.

use super::pipeline::{Prepared, SolveSettings, Timings, patch_reflectance};
use crate::accuracy::ErrorBudget;
use crate::effects::EffectPlan;
use crate::form_factors::RowComputer;
use crate::mesh::PatchMesh;
use crate::scene::{Lighting, Scene};
use crate::solver::{LightBases, PatchLight, SweepReport};
use crate::transport::{AssembleReport, Transport};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// What was solved, with what settings, and its light; or, while the solve goes on, as far as it has come.
///
/// Large parts are shared: a clone costs next to nothing.
#[derive(Clone, Debug)]
pub struct Solution {
    /// What was solved.
    pub scene: Arc<Scene>,
    /// Its patches.
    pub mesh: Arc<PatchMesh>,
    /// What was simulated.
    pub plan: Arc<EffectPlan>,
    /// Computes rows at free points, and patches' own for a look at one.
    pub computer: Arc<RowComputer>,
    /// How it was solved.
    pub settings: SolveSettings,
    /// How light passes between patches; `None` as long as rows are missing, and where nothing is lit.
    pub transport: Option<Arc<dyn Transport>>,
    /// Irradiance per luminaire; without values as long as there is no picture.
    pub bases: Arc<LightBases>,
    /// Reflectance of every patch as solved for.
    pub reflectance: Arc<Vec<[f32; 3]>>,
    /// One report per sweep.
    pub sweeps: Vec<SweepReport>,
    /// Seconds by stage.
    pub timings: Timings,
    /// The error that an audit estimated, where one was made.
    pub budget: Option<ErrorBudget>,
}

impl Solution {
    /// Of a scene that is about to be solved with its own materials: dark.
    pub fn new(prepared: &Prepared, settings: &SolveSettings) -> Self {
        let patches = prepared.mesh.patches.len();
        let mut solution = Self {
            scene: prepared.scene.clone(),
            mesh: prepared.mesh.clone(),
            plan: prepared.plan.clone(),
            computer: prepared.computer.clone(),
            settings: settings.clone(),
            transport: None,
            bases: Arc::new(LightBases { patches, ..LightBases::default() }),
            reflectance: Arc::default(),
            sweeps: Vec::new(),
            timings: prepared.timings,
            budget: None,
        };
        solution.set_reflectance(&patch_reflectance(&prepared.mesh, &|_| None));
        solution
    }

    /// Takes other reflectances, one per patch and band.
    pub fn set_reflectance(&mut self, reflectance: &[[f64; 3]]) {
        self.reflectance = Arc::new(reflectance.iter().map(|r| r.map(|b| b as f32)).collect());
    }

    /// What sampling and balancing found; all zero without a transport.
    pub fn assembled(&self) -> AssembleReport {
        self.transport.as_ref().map_or_else(AssembleReport::default, |transport| *transport.report())
    }

    /// Light of every patch with the lamps in this state: one sum, no solve.
    pub fn light(&self, lighting: &Lighting) -> PatchLight {
        self.bases.mix(&self.mesh, lighting, &self.reflectance)
    }

    /// Irradiance in W/m² per band at free points with unit normals, gathered from the radiosities of
    /// the patches by the same method as the rows.
    pub fn irradiance_at(&self, points: &[(DVec3, DVec3)], light: &PatchLight) -> Vec<[f64; 3]> {
        points
            .par_iter()
            .map_init(
                || self.computer.scratch(),
                |scratch, &(point, normal)| {
                    let mut sum = [0.0; 3];
                    self.computer.point(point, normal, scratch, |patch, f| {
                        for (s, &b) in sum.iter_mut().zip(&light.radiosity[patch as usize]) {
                            *s += f * f64::from(b);
                        }
                    });
                    sum
                },
            )
            .collect()
    }
}
