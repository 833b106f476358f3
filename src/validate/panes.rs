//! Panes: glass by its angle, and diffusing ones between two half spheres.

use super::{Assembled, Case, CaseError, Group, Model, Way};
use crate::mesh::PatchTarget;
use crate::solve::prepare;
use glam::{DVec3, dvec3};
use std::sync::Arc;

const GLASS: &str = "Fresnel's law, all reflections within the pane, over the hemisphere by quadrature";
const HALVED: &str = "form factors of half a sphere: 1/2 to itself, 1/2 to its disc; the disc's: 1";

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (transmittance, expected) in [(0.88, 0.805_554), (0.78, 0.701_070), (0.65, 0.569_399)] {
        let name = format!("even light through a wide pane of glass that passes {transmittance}");
        cases.push(
            Case::new(Group::Panes, name, GLASS, expected, move |way| through_glass(transmittance, way))
                .lines(5e-4)
                .hemicube(8e-3)
                .rays(8e-3)
                .because("at grazing angles, of which cells and rays have few, glass passes nothing"),
        );
    }
    for (place, what, expected) in [
        (0, "lit half", 1.534_090_91),
        (1, "other half", 0.284_090_91),
        (2, "disc towards the lit half", 0.602_272_73),
        (3, "disc towards the other half", 0.852_272_73),
    ] {
        let name = format!("sphere halved by a diffusing disc, rho 0.3, tau 0.5: B of the {what}");
        cases.push(
            Case::new(Group::Panes, name, HALVED, expected, move |way| Ok(halved_sphere(way)?[place]))
                .lines(3e-3)
                .because("facets are chords of the sphere"),
        );
    }
    cases
}

/// What a small floor sees of a ceiling that fills the sky, through a pane that does.
fn through_glass(transmittance: f64, way: Way) -> Result<f64, CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.3).grey("pane", 0.0).paint("glow", [0.0; 3], [1.0; 3]);
    let square = |half: f64, y: f64| (dvec3(-half, y, -half), DVec3::X * 2.0 * half, DVec3::Z * 2.0 * half);
    let (at, x, z) = square(0.1, 0.0);
    m.object("floor").quad("paint", at, z, x);
    let (at, x, z) = square(400.0, 0.4);
    m.object("pane").quad("pane", at, x, z);
    let (at, x, z) = square(400.0, 1.0);
    m.object("sky").quad("glow", at, x, z);
    let sidecar = format!("[[material]]\nname = \"pane\"\ntransmittance = {transmittance}\n");
    let prepared = prepare(Arc::new(m.read(Some(&sidecar))?), &way.settings(PatchTarget::Count(50)))?;
    let patches = &prepared.mesh.patches;
    let is_floor = |patch: &crate::mesh::Patch| patch.luminaire.is_none();
    let Some(floor) = patches.iter().position(is_floor) else { return Ok(f64::NAN) };
    let row = prepared.computer.row(floor as u32, &mut prepared.computer.scratch());
    let entries = row.patches.iter().zip(&row.values);
    let shining = entries.filter(|entry| patches[*entry.0 as usize].luminaire.is_some());
    let sum: f64 = shining.map(|entry| f64::from(*entry.1)).sum();
    // The rim of so wide a ceiling is just above the horizon.
    Ok(sum / (1.0 - 1.0 / (400.0 * 400.0)))
}

/// Mean radiosities of the half that shines, of the other one, and of the disc's sides towards either.
fn halved_sphere(way: Way) -> Result<[f64; 4], CaseError> {
    const AROUND: usize = 32;
    let mut m = Model::new();
    m.grey("other", 0.5).paint("glow", [0.5; 3], [1.0; 3]).grey("disc", 0.3);
    m.sphere([-1.0, 1.0], [16, AROUND], &|ring| if ring >= 8 { "glow" } else { "other" });
    let rim: Vec<DVec3> = (0..AROUND)
        .map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / AROUND as f64;
            dvec3(angle.cos(), angle.sin(), 0.0)
        })
        .collect();
    m.object("disc").polygon("disc", &rim);
    let sidecar = "[[material]]\nname = \"disc\"\ntranslucence = 0.5\n";
    let made = Assembled::new(Arc::new(m.read(Some(sidecar))?), &way.settings(PatchTarget::Count(1500)))?;
    let system = made.system(None);
    let (bases, _) = made.sweep(&system, 1e-7)?;
    let reflectance: Vec<[f32; 3]> = system.reflectance.iter().map(|rho| rho.map(|r| r as f32)).collect();
    let light = bases.mix(&made.prepared.mesh, &made.lighting(), &reflectance);
    let mean = |chosen: &dyn Fn(&crate::mesh::Patch) -> bool| {
        let own: Vec<usize> = (0..made.patches().len()).filter(|&i| chosen(&made.patches()[i])).collect();
        made.mean(&own, |i| f64::from(light.radiosity[i][0]))
    };
    let material =
        |patch: &crate::mesh::Patch| made.prepared.scene.materials[patch.material as usize].name.clone();
    Ok([
        mean(&|patch| material(patch) == "glow"),
        mean(&|patch| material(patch) == "other"),
        mean(&|patch| material(patch) == "disc" && patch.normal.z > 0.0),
        mean(&|patch| material(patch) == "disc" && patch.normal.z < 0.0),
    ])
}
