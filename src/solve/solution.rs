//! What a solve comes to, as one value that all who use it share.

use super::element_light::ElementLight;
use super::pipeline::{Prepared, SolveSettings, Timings, patch_reflectance};
use crate::accuracy::ErrorBudget;
use crate::direct::Scratch;
use crate::effects::EffectPlan;
use crate::form_factors::RowComputer;
use crate::mesh::{PatchMesh, Survey};
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
    /// What its patches rest on.
    pub survey: Arc<Survey>,
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
    /// Direct light in more detail than the patches have it, where it was computed.
    pub element_light: Option<Arc<ElementLight>>,
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
            survey: prepared.survey.clone(),
            mesh: prepared.mesh.clone(),
            plan: prepared.plan.clone(),
            computer: prepared.computer.clone(),
            settings: settings.clone(),
            transport: None,
            bases: Arc::new(LightBases { patches, ..LightBases::default() }),
            element_light: None,
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
        let reflectance: Vec<[f32; 3]> = reflectance.iter().map(|r| r.map(|b| b as f32)).collect();
        // Whoever holds the same ones sees that they are.
        if *self.reflectance != reflectance {
            self.reflectance = Arc::new(reflectance);
        }
    }

    /// What sampling and balancing found; all zero without a transport.
    pub fn assembled(&self) -> AssembleReport {
        self.transport.as_ref().map_or_else(AssembleReport::default, |transport| *transport.report())
    }

    /// Light of every patch with the lamps in this state: one sum, no solve.
    pub fn light(&self, lighting: &Lighting) -> PatchLight {
        let light = self.bases.mix(&self.mesh, lighting, &self.reflectance);
        match &self.element_light {
            Some(elements) => elements.detailed(light, lighting, &self.reflectance),
            None => light,
        }
    }

    /// Irradiance in W/m² per band at free points with unit normals: what the lamps give by themselves exactly, where
    /// that is [known](Self::direct_at); the rest gathered from the radiosities of the patches by the same method as
    /// the rows.
    pub fn irradiance_at(&self, points: &[(DVec3, DVec3)], light: &PatchLight) -> Vec<[f64; 3]> {
        let direct = self.direct_at(points, light);
        // With it the lamps' own exitance, B - rho H, is not gathered again.
        let sent = |patch: usize, band: usize| {
            let b = f64::from(light.radiosity[patch][band]);
            match direct {
                Some(_) if self.mesh.patches[patch].luminaire.is_some() => {
                    let arriving = |j: usize| light.irradiance[j].map(f64::from);
                    self.mesh.translucence.leaving(patch, self.reflectance[patch].map(f64::from), arriving)
                        [band]
                }
                _ => b,
            }
        };
        points
            .par_iter()
            .enumerate()
            .map_init(
                || self.computer.scratch(),
                |scratch, (index, &(point, normal))| {
                    let mut sum = direct.as_ref().map_or([0.0; 3], |direct| direct[index]);
                    self.computer.point(point, normal, scratch, |patch, f| {
                        for (band, s) in sum.iter_mut().enumerate() {
                            *s += f * sent(patch as usize, band);
                        }
                    });
                    sum
                },
            )
            .collect()
    }

    /// What the lamps give by themselves at free points with unit normals, W/m² per band; `None` where the light is
    /// not known in detail.
    pub fn direct_at(&self, points: &[(DVec3, DVec3)], light: &PatchLight) -> Option<Vec<[f64; 3]>> {
        let elements = self.element_light.as_ref()?;
        let outputs = &light.detail.as_ref()?.outputs;
        let at = |scratch: &mut Scratch, &(point, normal): &(DVec3, DVec3)| {
            let mut sum = [0.0; 3];
            let point = self.computer.lifted(point, normal);
            let is_hidden = self.computer.is_hidden_from(point);
            elements.direct.at(point, normal, is_hidden, scratch, |basis, value| {
                for (sum, &output) in sum.iter_mut().zip(&outputs[basis as usize]) {
                    *sum += value * f64::from(output);
                }
            });
            sum
        };
        Some(points.par_iter().map_init(Scratch::default, at).collect())
    }
}
