use super::CaseError;
use crate::mesh::Patch;
use crate::scene::{Lighting, Scene};
use crate::solve::{
    Control, Prepared, Progress, RowStore, Run, SolveSettings, Timings, patch_reflectance, prepare, system,
};
use crate::solver::{LightBases, SweepReport, System};
use crate::transport::Transport;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A scene made ready with all its form factors, to be asked for what a case compares.
#[derive(Clone, Debug)]
pub struct Assembled {
    /// The scene, its patches and the way to compute rows.
    pub prepared: Prepared,
    /// All form factors.
    pub transport: Arc<dyn Transport>,
}

impl Assembled {
    /// Meshes the scene and computes all form factors on this thread and rayon's.
    ///
    /// # Errors
    /// As the pipeline: a scene without area, or too large for the memory.
    pub fn new(scene: Arc<Scene>, settings: &SolveSettings) -> Result<Self, CaseError> {
        let prepared = prepare(scene, settings)?;
        let system = system(&prepared, &patch_reflectance(&prepared.mesh, &|_| None));
        let transport = run(|run| {
            let mut rows = RowStore::default();
            run.rows(&prepared, &system, None, None, &mut rows)?;
            run.assemble(&prepared, &mut rows)
        })?;
        Ok(Self { prepared, transport })
    }

    /// All patches.
    pub fn patches(&self) -> &[Patch] {
        &self.prepared.mesh.patches
    }

    /// Patches of the objects that `chosen` picks by name, in rising order.
    pub fn of(&self, chosen: impl Fn(&str) -> bool) -> Vec<usize> {
        let objects = &self.prepared.scene.objects;
        let surfaces = &self.prepared.scene.surfaces;
        let picked = |p: &Patch| chosen(&objects[surfaces[p.surface as usize].object as usize]);
        (0..self.patches().len()).filter(|&i| picked(&self.patches()[i])).collect()
    }

    /// Patches that see something: what lies under a box sees nothing, and keeps B = E.
    pub fn seeing(&self) -> Vec<usize> {
        (0..self.patches().len()).filter(|&i| self.transport.row_sum(i) > 0.0).collect()
    }

    /// Form factor from one set of patches to another.
    pub fn between(&self, from: &[usize], to: &[usize]) -> f64 {
        let mut wanted = vec![false; self.patches().len()];
        to.iter().for_each(|&j| wanted[j] = true);
        let exchange: f64 = from
            .iter()
            .map(|&i| {
                let row = self.transport.row(i).into_iter().filter(|(j, _)| wanted[*j as usize]);
                let own = if wanted[i] { self.transport.own(i) } else { 0.0 };
                own + row.map(|(_, s)| s).sum::<f64>()
            })
            .sum();
        exchange / self.area(from)
    }

    /// Share of what leaves these patches that escapes through openings, 0 to 1.
    pub fn escaping(&self, from: &[usize]) -> f64 {
        let kept: f64 = from.iter().map(|&i| self.patches()[i].area * self.transport.row_sum(i)).sum();
        1.0 - kept / self.area(from)
    }

    /// Area of some patches, m².
    pub fn area(&self, patches: &[usize]) -> f64 {
        patches.iter().map(|&i| self.patches()[i].area).sum()
    }

    /// Area-weighted mean of a value over some patches.
    pub fn mean(&self, patches: &[usize], value: impl Fn(usize) -> f64) -> f64 {
        patches.iter().map(|&i| self.patches()[i].area * value(i)).sum::<f64>() / self.area(patches)
    }

    /// The system of the scene as it is, or with these reflectances a patch and band.
    pub fn system(&self, reflectance: Option<&[[f64; 3]]>) -> System {
        let own = patch_reflectance(&self.prepared.mesh, &|_| None);
        system(&self.prepared, reflectance.unwrap_or(&own))
    }

    /// A grey system of one lamp in which every patch has this reflectance and exitance.
    pub fn grey_system(&self, patch: impl Fn(usize) -> (f64, f64)) -> System {
        let n = self.patches().len();
        System {
            translucence: Arc::default(),
            lamps: 1,
            bands: 1,
            reflectance: (0..n).map(|i| [patch(i).0; 3]).collect(),
            emission: (0..n).map(|i| Some((0, [patch(i).1; 3]))).collect(),
            areas: self.patches().iter().map(|p| p.area).collect(),
            output: vec![1.0],
            photometric: Vec::new(),
            outdoors: Vec::new(),
            direct: None,
        }
    }

    /// Sweeps from B = E until the error bound falls below the tolerance.
    ///
    /// # Errors
    /// As the pipeline.
    pub fn sweep(
        &self,
        system: &System,
        tolerance: f64,
    ) -> Result<(LightBases, Vec<SweepReport>), CaseError> {
        Ok(run(|run| run.sweeps(&self.prepared, self.transport.as_ref(), system, None, tolerance))?)
    }

    /// Radiosity of every patch, W/m², in a system of one column ([`Self::grey_system`]).
    ///
    /// # Errors
    /// As the pipeline.
    pub fn radiosity(&self, system: &System, tolerance: f64) -> Result<Vec<f64>, CaseError> {
        let (bases, _) = self.sweep(system, tolerance)?;
        let column = bases.values.iter().step_by(system.columns().max(1)).enumerate();
        Ok(column.map(|(i, &h)| system.exitance(i, 0) + system.rho(i, 0) * f64::from(h)).collect())
    }

    /// Irradiance of every patch with the lamps as they come, W/m² a band.
    ///
    /// # Errors
    /// As the pipeline.
    pub fn irradiance(&self, system: &System, tolerance: f64) -> Result<Vec<[f32; 3]>, CaseError> {
        let (bases, _) = self.sweep(system, tolerance)?;
        Ok(bases.mix(&self.prepared.mesh, &self.lighting(), &[]).irradiance)
    }

    /// The lamps as they come.
    pub fn lighting(&self) -> Lighting {
        self.prepared.scene.lighting()
    }
}

/// A part of the pipeline that nobody watches or cancels.
fn run<T>(
    part: impl FnOnce(&mut Run<'_>) -> Result<T, crate::solve::PipelineError>,
) -> Result<T, crate::solve::PipelineError> {
    let cancel = AtomicBool::new(false);
    let mut observer = |_: Progress<'_>| Control::Continue;
    part(&mut Run::new(&mut observer, &cancel, Timings::default()))
}
