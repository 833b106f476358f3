//! Scenes built in code, and the parts of a solve one by one.
#![allow(dead_code, reason = "each test program uses a part of this")]

use glam::{DVec3, dvec3};
use lumenwalk::effects::EffectChoices;
use lumenwalk::form_factors::{AssembleReport, FormFactors, Method, Row};
use lumenwalk::mesh::{Patch, PatchTarget};
use lumenwalk::scene::{Lighting, Scene, SceneSource, Sides, from_text, load};
use lumenwalk::session::{
    Control, Prepared, Run, SolveSettings, Solved, Timings, patch_reflectance, prepare, solve, system,
};
use lumenwalk::solver::{GaussSeidel, LightBases, SweepReport, System};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// All methods with the resolutions at which tests compare them.
pub(crate) const METHODS: [(Method, u32); 3] =
    [(Method::Lines, 192), (Method::Hemicube, 256), (Method::Rays, 16384)];

/// Texts of a scene in the making; y is up.
#[derive(Clone, Default)]
pub(crate) struct Model {
    obj: String,
    mtl: String,
    corners: usize,
}

impl Model {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// A paint with this reflectance in all bands.
    pub(crate) fn grey(&mut self, name: &str, rho: f64) -> &mut Self {
        self.paint(name, [rho; 3], [0.0; 3])
    }

    /// A material with reflectances and exitances, W/m² a band.
    pub(crate) fn paint(&mut self, name: &str, rho: [f64; 3], exitance: [f64; 3]) -> &mut Self {
        let [r, g, b] = rho;
        writeln!(self.mtl, "newmtl {name}\nKd {r} {g} {b}").unwrap();
        if exitance.iter().any(|&e| e > 0.0) {
            let [r, g, b] = exitance.map(|e| e / PI);
            writeln!(self.mtl, "Ke {r} {g} {b}").unwrap();
        }
        self
    }

    pub(crate) fn object(&mut self, name: &str) -> &mut Self {
        writeln!(self.obj, "o {name}").unwrap();
        self
    }

    /// A polygon, counter-clockwise from its front.
    pub(crate) fn polygon(&mut self, material: &str, corners: &[DVec3]) -> &mut Self {
        for c in corners {
            writeln!(self.obj, "v {} {} {}", c.x, c.y, c.z).unwrap();
        }
        let indices: Vec<String> = (1..=corners.len()).map(|k| (self.corners + k).to_string()).collect();
        writeln!(self.obj, "usemtl {material}\nf {}", indices.join(" ")).unwrap();
        self.corners += corners.len();
        self
    }

    /// A parallelogram whose front looks along u x v.
    pub(crate) fn quad(&mut self, material: &str, at: DVec3, u: DVec3, v: DVec3) -> &mut Self {
        self.polygon(material, &[at, at + u, at + u + v, at + v])
    }

    /// The inside of a box: objects floor, ceiling, west (low x), east, north (low z), south; one
    /// material each, `None` leaves it open.
    pub(crate) fn room(&mut self, low: DVec3, high: DVec3, materials: [Option<&str>; 6]) -> &mut Self {
        let [x, y, z] = (high - low)
            .to_array()
            .into_iter()
            .zip([DVec3::X, DVec3::Y, DVec3::Z])
            .map(|(length, axis)| axis * length)
            .collect::<Vec<_>>()
            .try_into()
            .unwrap();
        let faces: [(&str, DVec3, DVec3, DVec3); 6] = [
            ("floor", low, z, x),
            ("ceiling", low + y, x, z),
            ("west", low, y, z),
            ("east", low + x, z, y),
            ("north", low, x, y),
            ("south", low + z, y, x),
        ];
        for ((name, at, u, v), material) in faces.into_iter().zip(materials) {
            if let Some(material) = material {
                self.object(name).quad(material, at, u, v);
            }
        }
        self
    }

    /// The outside of a box, six faces.
    pub(crate) fn block(&mut self, name: &str, material: &str, low: DVec3, high: DVec3) -> &mut Self {
        let size = high - low;
        let (x, y, z) = (DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z);
        self.object(name);
        for (at, u, v) in
            [(low, x, z), (low + y, z, x), (low, z, y), (low + x, y, z), (low, y, x), (low + z, x, y)]
        {
            self.quad(material, at, u, v);
        }
        self
    }

    /// The inside of a sphere of unit radius between the heights z0 < z1, in rings of equal area cut
    /// into `around` facets; `material` names one a ring.
    pub(crate) fn sphere(
        &mut self,
        [z0, z1]: [f64; 2],
        [rings, around]: [usize; 2],
        material: &dyn Fn(usize) -> &'static str,
    ) -> &mut Self {
        let at = |ring: usize, k: usize| {
            let z = z0 + (z1 - z0) * ring as f64 / rings as f64;
            let angle = 2.0 * PI * (k % around) as f64 / around as f64;
            let r = (1.0 - z * z).max(0.0).sqrt();
            dvec3(r * angle.cos(), r * angle.sin(), z)
        };
        self.object("sphere");
        for ring in 0..rings {
            for k in 0..around {
                let mut corners = vec![at(ring, k + 1), at(ring, k), at(ring + 1, k), at(ring + 1, k + 1)];
                corners.dedup_by(|a, b| a.distance(*b) < 1e-6);
                if corners[0].distance(corners[corners.len() - 1]) < 1e-6 {
                    corners.pop();
                }
                self.polygon(material(ring), &corners);
            }
        }
        self
    }

    pub(crate) fn texts(&self) -> (&str, &str) {
        (&self.obj, &self.mtl)
    }

    pub(crate) fn scene(&self) -> Arc<Scene> {
        self.scene_with(None)
    }

    pub(crate) fn scene_with(&self, sidecar: Option<&str>) -> Arc<Scene> {
        let obj = format!("mtllib model.mtl\n{}", self.obj);
        Arc::new(from_text("model", &obj, &self.mtl, sidecar).expect("a scene without faults"))
    }

    /// The scene with every surface taking part on its front alone: no search for light.
    pub(crate) fn one_sided(&self) -> Arc<Scene> {
        let mut scene = Arc::unwrap_or_clone(self.scene());
        scene.materials.iter_mut().for_each(|m| m.sides = Sides::Front);
        Arc::new(scene)
    }
}

/// A room of 4 x 3 x 5 m with a lamp of 0.8 x 0.8 m in its ceiling and two blocks, all grey at `rho`.
pub(crate) fn room_with_blocks(rho: f64) -> Model {
    let mut m = Model::new();
    m.grey("paint", rho).paint("glow", [rho; 3], [20.0; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [all, None, all, all, all, all]);
    ceiling_with_lamp(&mut m, "paint", [4.0, 3.0, 5.0], [1.6, 2.4, 2.1, 2.9]);
    m.block("cupboard", "paint", dvec3(0.7, 0.0, 0.9), dvec3(1.5, 1.8, 1.6));
    m.block("table", "paint", dvec3(2.2, 0.6, 2.5), dvec3(3.4, 0.7, 3.6));
    m
}

/// A ceiling of four rectangles around a lamp of material "glow": x from, x to, z from, z to.
pub(crate) fn ceiling_with_lamp(m: &mut Model, paint: &str, [x, y, z]: [f64; 3], lamp: [f64; 4]) {
    let [x0, x1, z0, z1] = lamp;
    let mut rectangle = |material: &str, [a, b, c, d]: [f64; 4]| {
        m.quad(material, dvec3(a, y, c), DVec3::X * (b - a), DVec3::Z * (d - c));
    };
    for part in [[0.0, x, 0.0, z0], [0.0, x0, z0, z1], [x1, x, z0, z1], [0.0, x, z1, z]] {
        rectangle(paint, part);
    }
    rectangle("glow", lamp);
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
pub(crate) fn solved(scene: &Arc<Scene>, settings: &SolveSettings) -> Solved {
    solve(scene.clone(), settings, &AtomicBool::new(false), &mut |_| Control::Continue)
        .expect("nothing stands against it")
}

/// The raw rows of every patch.
pub(crate) fn rows(prepared: &Prepared) -> Vec<Row> {
    let computer = &prepared.computer;
    (0..prepared.mesh.patches.len() as u32)
        .into_par_iter()
        .map_init(|| computer.scratch(), |scratch, i| computer.row(i, scratch))
        .collect()
}

/// A scene made ready, and all its form factors.
pub(crate) struct Assembled {
    pub(crate) prepared: Prepared,
    pub(crate) form_factors: FormFactors,
    pub(crate) report: AssembleReport,
}

pub(crate) fn assembled(scene: &Arc<Scene>, settings: &SolveSettings) -> Assembled {
    let prepared = prepare(scene.clone(), settings).expect("a mesh");
    let (form_factors, report) =
        FormFactors::assemble(&prepared.computer, rows(&prepared), &|| false).expect("not cancelled");
    Assembled { prepared, form_factors, report }
}

impl Assembled {
    pub(crate) fn patches(&self) -> &[Patch] {
        &self.prepared.mesh.patches
    }

    /// Patches of the objects that `chosen` picks.
    pub(crate) fn of(&self, chosen: impl Fn(&str) -> bool) -> Vec<usize> {
        let objects = &self.prepared.scene.objects;
        let surfaces = &self.prepared.scene.surfaces;
        let picked = |p: &Patch| chosen(&objects[surfaces[p.surface as usize].object as usize]);
        (0..self.patches().len()).filter(|&i| picked(&self.patches()[i])).collect()
    }

    /// Form factor from one set of patches to another.
    pub(crate) fn between(&self, from: &[usize], to: &[usize]) -> f64 {
        let mut wanted = vec![false; self.patches().len()];
        to.iter().for_each(|&j| wanted[j] = true);
        let exchange: f64 = from
            .iter()
            .map(|&i| {
                let (columns, values) = self.form_factors.row(i);
                let row = columns.iter().zip(values).filter(|(j, _)| wanted[**j as usize]);
                row.map(|(_, &s)| f64::from(s)).sum::<f64>()
            })
            .sum();
        exchange / self.area(from)
    }

    pub(crate) fn area(&self, patches: &[usize]) -> f64 {
        patches.iter().map(|&i| self.patches()[i].area).sum()
    }

    /// The system of the scene as it is, or with these reflectances.
    pub(crate) fn system(&self, reflectance: Option<&[[f64; 3]]>) -> System {
        let own = patch_reflectance(&self.prepared.mesh, &|_| None);
        system(&self.prepared, reflectance.unwrap_or(&own))
    }

    /// A grey system of one lamp in which every patch has this reflectance and emission.
    pub(crate) fn grey_system(&self, patch: impl Fn(usize) -> (f64, f64)) -> System {
        let n = self.patches().len();
        System {
            lamps: 1,
            bands: 1,
            reflectance: (0..n).map(|i| [patch(i).0; 3]).collect(),
            emission: (0..n).map(|i| Some((0, [patch(i).1; 3]))).collect(),
            areas: self.patches().iter().map(|p| p.area).collect(),
            output: vec![1.0],
        }
    }

    /// Sweeps from B = E until the bound falls below the tolerance.
    pub(crate) fn sweep(&self, system: &System, tolerance: f64) -> (LightBases, Vec<SweepReport>) {
        let cancel = AtomicBool::new(false);
        let mut observer = |_: lumenwalk::session::Progress<'_>| Control::Continue;
        Run::new(&mut observer, &cancel, Timings::default())
            .sweeps(&self.prepared, &self.form_factors, system, None, tolerance)
            .expect("not cancelled")
    }

    /// Radiosity of every patch in a system of one column.
    pub(crate) fn radiosity(&self, system: &System, tolerance: f64) -> Vec<f64> {
        assert_eq!(system.columns(), 1);
        let (bases, _) = self.sweep(system, tolerance);
        let column = bases.values.iter().enumerate();
        column.map(|(i, &h)| system.exitance(i, 0) + system.rho(i, 0) * f64::from(h)).collect()
    }

    /// Irradiance of every patch with the lamps as they come, W/m² a band.
    pub(crate) fn irradiance(&self, system: &System, tolerance: f64) -> Vec<[f32; 3]> {
        let (bases, _) = self.sweep(system, tolerance);
        bases.mix(&self.prepared.mesh, &self.lighting(), &[]).irradiance
    }

    pub(crate) fn lighting(&self) -> Lighting {
        self.prepared.scene.lighting()
    }

    /// A solver for this system, started from B = E.
    pub(crate) fn solver(&self, system: &System) -> GaussSeidel {
        GaussSeidel::new(&self.prepared.mesh, &self.form_factors, system, None)
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
