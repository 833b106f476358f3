//! What the microscope shows of a mesh agrees with its definitions, worked out once more by brute force.

mod common;

use common::{Assembled, Model, assembled, close, lines, rows};
use glam::dvec3;
use lumenwalk::mesh::{NO_PATCH, PatchTarget};
use lumenwalk::solve::{Control, RowStore, Run, Stage, Timings};
use lumenwalk::solver::{LightBases, PatchLight, residual};
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

/// A closed room with a block in it and a lamp.
fn room() -> Model {
    let mut model = Model::new();
    model.grey("dark", 0.3).paint("red", [0.7, 0.2, 0.1], [0.0; 3]).paint("lit", [0.5; 3], [10.0, 8.0, 6.0]);
    let walls = [Some("dark"), Some("lit"), Some("red"), Some("dark"), Some("dark"), Some("dark")];
    model.room(dvec3(0.0, 0.0, 0.0), dvec3(3.0, 2.5, 4.0), walls);
    model.block("block", "red", dvec3(1.0, 0.0, 1.0), dvec3(1.8, 1.0, 2.0));
    model
}

static ROOM: LazyLock<Assembled> =
    LazyLock::new(|| assembled(&room().scene(), &lines(PatchTarget::Count(400))));

#[test]
fn the_quality_of_a_row_is_that_of_its_samples() {
    let made = &*ROOM;
    let sampled = rows(&made.prepared);
    let area = |i: usize| made.patches()[i].area;
    let mut compared = 0;
    for (i, row) in sampled.iter().enumerate() {
        let quality = made.transport.quality(i);
        assert!((f64::from(quality.sampled_sum) - row.sum()).abs() < 1e-6);
        let pairs: Vec<(f64, f64)> = (0..sampled.len())
            .map(|j| {
                let (out, back) = (area(i) * row.get(j as u32), area(j) * sampled[j].get(i as u32));
                ((out - back).abs(), 0.5 * (out + back))
            })
            .collect();
        let gap: f64 = pairs.iter().map(|p| p.0).sum();
        let mean: f64 = pairs.iter().map(|p| p.1).sum();
        let near = |what: &str, value: f32, expected: f64| {
            assert!((f64::from(value) - expected).abs() < 1e-5, "{what} of {i}: {value} and {expected}");
        };
        near("mean", quality.mean_reciprocity, gap / mean);
        let worst = pairs.iter().map(|p| p.0).fold(0.0, f64::max);
        near("worst", quality.worst_reciprocity, worst / area(i));
        if quality.worst_partner == NO_PATCH {
            assert!(worst == 0.0);
            continue;
        }
        let partner = pairs[quality.worst_partner as usize];
        near("partner", quality.worst_pair_gap, partner.0 / partner.1);
        assert!((partner.0 / worst - 1.0).abs() < 1e-9);
        compared += 1;
    }
    assert!(compared > 300, "samples are never quite reciprocal: {compared}");
}

#[test]
fn the_residual_is_what_another_sweep_would_add() {
    let made = &*ROOM;
    let system = made.system(None);
    let reflectance: Vec<[f32; 3]> = system.reflectance.iter().map(|r| r.map(|b| b as f32)).collect();
    let n = made.patches().len();
    // Before any sweep nothing but the lamp shines: r = rho F E.
    let dark = LightBases { patches: n, lamps: system.lamps, bands: system.bands, values: Vec::new() };
    let start = dark.mix(&made.prepared.mesh, &made.lighting(), &reflectance);
    let first = residual(made.transport.as_ref(), (&reflectance, &system.translucence), &start);
    let mut checked = 0;
    for i in (0..n).step_by(7) {
        for band in 0..3 {
            let arriving: f64 =
                (0..n).map(|j| made.transport.get(i, j) * f64::from(start.radiosity[j][band])).sum();
            let expected = system.reflectance[i][band] * arriving;
            assert!((f64::from(first[i][band]) - expected).abs() < 1e-5 * expected.max(1e-3), "{i} {band}");
            checked += usize::from(expected > 0.01);
        }
    }
    assert!(checked > 50, "{checked}");
    // At convergence little is left.
    let size = |r: &[[f32; 3]]| r.iter().flatten().fold(0.0_f32, |m, &x| m.max(x.abs()));
    let (bases, _) = made.sweep(&system, 1e-5);
    let settled: PatchLight = bases.mix(&made.prepared.mesh, &made.lighting(), &reflectance);
    let last = residual(made.transport.as_ref(), (&reflectance, &system.translucence), &settled);
    assert!(size(&first) > 0.5 && size(&last) < 1e-3, "{} then {}", size(&first), size(&last));
}

#[test]
fn what_is_unshot_closes_the_balance_of_a_picture_on_the_way() {
    let made = &*ROOM;
    let system = made.system(None);
    let mesh = &made.prepared.mesh;
    let lighting = made.lighting();
    let reflectance: Vec<[f32; 3]> = system.reflectance.iter().map(|r| r.map(|b| b as f32)).collect();
    let mut seen: Vec<(Stage, PatchLight, Vec<[f32; 3]>)> = Vec::new();
    let cancel = AtomicBool::new(false);
    let mut observer = |progress: lumenwalk::solve::Progress<'_>| {
        if let (Some(picture), Some(unshot)) = (progress.picture(), progress.unshot()) {
            let light = picture.mix(mesh, &lighting, &reflectance);
            seen.push((progress.stage, light, unshot.sum(&lighting, mesh.patches.len())));
        }
        Control::Continue
    };
    Run::new(&mut observer, &cancel, Timings::default())
        .rows(&made.prepared, &system, None, None, &mut RowStore::default())
        .expect("not cancelled");
    assert!(!seen.is_empty(), "the first light is told");
    for (stage, light, unshot) in &seen {
        let power = |values: &[[f32; 3]], band: usize| -> f64 {
            mesh.patches.iter().zip(values).map(|(p, v)| p.area * f64::from(v[band])).sum()
        };
        for band in 0..3 {
            // In a closed room all that leaves arrives: the picture holds what is unshot as if it were spread evenly.
            let (leaves, arrives) = (power(&light.radiosity, band), power(&light.irradiance, band));
            close(&format!("{stage:?}, band {band}"), arrives, leaves, 4e-3);
            assert!(power(unshot, band) > 0.0);
        }
        assert!(unshot.iter().flatten().all(|&b| b >= 0.0));
    }
}
