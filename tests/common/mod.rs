//! Scenes built in code, and the parts of a solve one by one.
#![allow(dead_code, reason = "each test program uses a part of this")]

pub(crate) mod quads;

use lumenwalk::effects::EffectChoices;
use lumenwalk::form_factors::{Method, Row};
use lumenwalk::mesh::{Patch, PatchTarget};
use lumenwalk::scene::{Scene, SceneSource, load};
use lumenwalk::solve::{Control, Prepared, Solution, SolveSettings, solve};
use lumenwalk::solver::{GaussSeidel, LightBases, SweepReport, System};
use lumenwalk::validate;
use rayon::prelude::*;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// All methods with the resolutions at which tests compare them.
pub(crate) const METHODS: [(Method, u32); 3] =
    [(Method::Lines, 192), (Method::Hemicube, 256), (Method::Rays, 16384)];

/// [`validate::Model`] whose scenes are without faults.
#[derive(Clone, Default)]
pub(crate) struct Model(validate::Model);

impl Deref for Model {
    type Target = validate::Model;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for Model {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

impl Model {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    pub(crate) fn scene(&self) -> Arc<Scene> {
        self.scene_with(None)
    }

    pub(crate) fn scene_with(&self, sidecar: Option<&str>) -> Arc<Scene> {
        Arc::new(self.read(sidecar).expect("a scene without faults"))
    }

    /// The scene with every surface taking part on its front alone: no search for light.
    pub(crate) fn one_sided(&self) -> Arc<Scene> {
        Arc::new(self.read_one_sided().expect("a scene without faults"))
    }
}

impl From<validate::Model> for Model {
    fn from(model: validate::Model) -> Self {
        Self(model)
    }
}

/// A room of 4 x 3 x 5 m with a lamp of 0.8 x 0.8 m in its ceiling and two blocks, all grey at `rho`.
pub(crate) fn room_with_blocks(rho: f64) -> Model {
    validate::scenes::room_with_blocks(rho).into()
}

/// A ceiling of four rectangles around a lamp of material "glow": x from, x to, z from, z to.
pub(crate) fn ceiling_with_lamp(m: &mut Model, paint: &str, size: [f64; 3], lamp: [f64; 4]) {
    m.ceiling_with_lamp(paint, size, lamp);
}

pub(crate) fn builtin(name: &str) -> Arc<Scene> {
    Arc::new(load(&SceneSource::Builtin(name.to_owned())).expect("an embedded scene"))
}

pub(crate) fn settings(patches: PatchTarget, method: Method, resolution: u32) -> SolveSettings {
    SolveSettings { patches, method, resolution: Some(resolution), ..SolveSettings::default() }
}

/// Lines at their default resolution.
pub(crate) fn lines(patches: PatchTarget) -> SolveSettings {
    SolveSettings { patches, ..SolveSettings::default() }
}

pub(crate) fn with_effects(patches: PatchTarget, effects: EffectChoices) -> SolveSettings {
    SolveSettings { patches, effects, ..SolveSettings::default() }
}

/// A whole solve on this thread and rayon's.
pub(crate) fn solved(scene: &Arc<Scene>, settings: &SolveSettings) -> Solution {
    solve(scene.clone(), settings, &AtomicBool::new(false), &mut |_| Control::Continue)
        .expect("nothing stands against it")
}

/// The same without elements: all light, the lamps' too, is as the rows carry it.
pub(crate) fn solved_by_rows(scene: &Arc<Scene>, settings: &SolveSettings) -> Solution {
    let made = assembled(scene, settings);
    let (bases, sweeps) = made.sweep(&made.system(None), settings.tolerance);
    Solution {
        transport: Some(made.transport.clone()),
        bases: Arc::new(bases),
        sweeps,
        ..Solution::new(&made.prepared, settings)
    }
}

/// The raw rows of every patch.
pub(crate) fn rows(prepared: &Prepared) -> Vec<Row> {
    let computer = &prepared.computer;
    (0..prepared.mesh.patches.len() as u32)
        .into_par_iter()
        .map_init(|| computer.scratch(), |scratch, i| computer.row(i, scratch))
        .collect()
}

/// [`validate::Assembled`] that nothing stands against.
pub(crate) struct Assembled(validate::Assembled);

impl Deref for Assembled {
    type Target = validate::Assembled;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

pub(crate) fn assembled(scene: &Arc<Scene>, settings: &SolveSettings) -> Assembled {
    Assembled(validate::Assembled::new(scene.clone(), settings).expect("form factors"))
}

impl Assembled {
    /// Sweeps from B = E until the bound falls below the tolerance.
    pub(crate) fn sweep(&self, system: &System, tolerance: f64) -> (LightBases, Vec<SweepReport>) {
        self.0.sweep(system, tolerance).expect("not cancelled")
    }

    /// Radiosity of every patch in a system of one column.
    pub(crate) fn radiosity(&self, system: &System, tolerance: f64) -> Vec<f64> {
        assert_eq!(system.columns(), 1);
        self.0.radiosity(system, tolerance).expect("not cancelled")
    }

    /// Irradiance of every patch with the lamps as they come, W/m² a band.
    pub(crate) fn irradiance(&self, system: &System, tolerance: f64) -> Vec<[f32; 3]> {
        self.0.irradiance(system, tolerance).expect("not cancelled")
    }

    /// A solver for this system, started from B = E.
    pub(crate) fn solver(&self, system: &System) -> GaussSeidel {
        GaussSeidel::new(&self.prepared.mesh, self.transport.as_ref(), system, None)
    }
}

/// Area-weighted mean over some patches.
pub(crate) fn mean(patches: &[Patch], chosen: &[usize], value: impl Fn(usize) -> f64) -> f64 {
    let area: f64 = chosen.iter().map(|&i| patches[i].area).sum();
    chosen.iter().map(|&i| patches[i].area * value(i)).sum::<f64>() / area
}

/// Asserts a relative difference.
#[track_caller]
pub(crate) fn close(what: &str, computed: f64, expected: f64, relative: f64) {
    assert!(
        (computed - expected).abs() <= relative * expected.abs(),
        "{what}: computed {computed:.9}, expected {expected:.9}, off by {:.2e}",
        (computed - expected) / expected
    );
}

/// Spearman's rank correlation.
pub(crate) fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let ranks = |x: &[f64]| {
        let mut order: Vec<usize> = (0..x.len()).collect();
        order.sort_by(|&i, &j| x[i].total_cmp(&x[j]));
        let mut ranks = vec![0.0; x.len()];
        order.iter().enumerate().for_each(|(rank, &i)| ranks[i] = rank as f64);
        ranks
    };
    let (a, b) = (ranks(a), ranks(b));
    let middle = (a.len() - 1) as f64 / 2.0;
    let of = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - middle) * (y - middle)).sum::<f64>();
    of(&a, &b) / (of(&a, &a) * of(&b, &b)).sqrt()
}
