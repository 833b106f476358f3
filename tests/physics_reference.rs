//! The closed Cornell box against an independent path tracer.

mod common;

use common::{Model, lines, solved};
use glam::{DVec3, dvec3};
use lumenwalk::display::DisplayMesh;
use lumenwalk::effects::EffectChoices;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, luminance_weighted};
use lumenwalk::solve::Control;
use lumenwalk::study;
use std::f64::consts::PI;
use std::sync::Arc;

/// Rectified, metres; a black front, blocks at the measured places, the lamp flush with the ceiling.
fn cornell() -> Arc<Scene> {
    let (x, y, z) = (0.556, 0.5488, 0.5592);
    let mut m = Model::new();
    m.grey("white", 0.73).grey("front", 0.0);
    m.paint("red", [0.63, 0.065, 0.05], [0.0; 3]).paint("green", [0.14, 0.45, 0.091], [0.0; 3]);
    m.paint("glow", [0.0; 3], [18.4, 15.6, 8.0].map(|radiance| PI * radiance));
    let white = Some("white");
    m.room(DVec3::ZERO, dvec3(x, y, z), [white, None, Some("green"), Some("red"), Some("front"), white]);
    m.object("ceiling");
    common::ceiling_with_lamp(&mut m, "white", [x, y, z], [0.213, 0.343, 0.227, 0.332]);
    let mut prism = |name: &str, top: f64, corners: [[f64; 2]; 4]| {
        let at = |k: usize, y: f64| dvec3(corners[k % 4][0], y, corners[k % 4][1]);
        m.object(name).polygon("white", &[at(0, top), at(1, top), at(2, top), at(3, top)]);
        for k in 0..4 {
            m.polygon("white", &[at(k, 0.0), at(k + 1, 0.0), at(k + 1, top), at(k, top)]);
        }
    };
    prism("short_block", 0.165, [[0.13, 0.065], [0.082, 0.225], [0.24, 0.272], [0.29, 0.114]]);
    prism("tall_block", 0.33, [[0.423, 0.247], [0.265, 0.296], [0.314, 0.456], [0.472, 0.406]]);
    m.scene()
}

/// Points with normals, irradiance per band as path traced, and the area that each stands for.
fn traced() -> Vec<Vec<f64>> {
    let table: Vec<Vec<f64>> = include_str!("data/cornell_closed.csv")
        .lines()
        .filter(|line| !line.starts_with(['#', 'x']))
        .map(|line| line.split(',').map(|field| field.parse().expect("a number")).collect())
        .collect();
    assert!(table.len() > 600);
    table
}

#[test]
fn an_error_of_one_percent_asked_for_is_one_against_the_path_tracer() {
    let (scene, table) = (cornell(), traced());
    let lighting = scene.lighting();
    let mut go_on = |_: study::News<'_>| Control::Continue;
    let (goal, started) = (study::Goal::Error(0.01), std::time::Instant::now());
    let effects = EffectChoices::default();
    let task = study::Task { scene: &scene, lighting: &lighting, goal, effects: &effects, places: &[] };
    let reached = study::reach(&task, started, 4.0, &mut go_on);
    let reached = reached.expect("solved");
    assert!(reached.verdict.met(), "{}", reached.verdict);
    let (mesh, light) = (&reached.solved.mesh, reached.solved.light(&lighting));
    let elements = reached.solved.element_light.as_ref().map(|light| &light.elements);
    let shown = study::shown(mesh, &DisplayMesh::build_on(mesh, &scene, true, elements), &light);
    let (triangles, pieces) = mesh.triangles();
    // What the picture shows at a point of a surface.
    let at = |point: DVec3, normal: DVec3| {
        triangles.iter().enumerate().find_map(|(index, &[a, b, c])| {
            let whole = (b - a).cross(c - a);
            let (area, facing) = (whole.length(), whole.normalize_or_zero());
            let share = |p: DVec3, q: DVec3| (p - point).cross(q - point).dot(facing) / area;
            let weights = [share(b, c), share(c, a), share(a, b)];
            let is_inside = weights.iter().all(|&w| w > -1e-6) && (point - a).dot(facing).abs() < 1e-6;
            let front = mesh.regions[mesh.pieces[pieces[index] as usize].region as usize].frame.normal;
            (is_inside && front.dot(normal).abs() > 0.999).then(|| {
                let side = usize::from(front.dot(normal) < 0.0);
                let (face, weights) = shown.place(2 * index + side, weights).expect("lit");
                shown.faces[face]
                    .iter()
                    .zip(weights)
                    .map(|(h, w)| w * luminance_weighted(h.map(f64::from)))
                    .sum::<f64>()
            })
        })
    };
    let (mut squares, mut sum, mut area) = (0.0, 0.0, 0.0);
    for row in &table {
        let point = dvec3(row[0], row[1], row[2]);
        let shown = at(point, dvec3(row[3], row[4], row[5])).expect("on a surface");
        let traced = luminance_weighted([row[6], row[7], row[8]]);
        squares += row[9] * (shown - traced).powi(2);
        sum += row[9] * traced;
        area += row[9];
    }
    let error = (squares / area).sqrt() / (sum / area);
    println!("{}; against the path tracer {error:.5}", reached.verdict);
    // Which solves are made goes by the seconds of this machine; what was told is some 10 % uncertain, and what
    // was traced by a quarter of a percent.
    assert!(error < 0.012, "{error}");
}

#[test]
fn irradiance_in_the_cornell_box_is_that_of_a_path_tracer() {
    let table = traced();
    let points: Vec<(DVec3, DVec3)> =
        table.iter().map(|row| (dvec3(row[0], row[1], row[2]), dvec3(row[3], row[4], row[5]))).collect();
    let scene = cornell();
    let solution = solved(&scene, &lines(PatchTarget::Auto));
    let light = solution.light(&scene.lighting());
    let found = solution.irradiance_at(&points, &light);
    let n = table.len() as f64;
    let expected = |row: &[f64]| [row[6], row[7], row[8]];
    let pairs = || found.iter().copied().zip(table.iter().map(|row| expected(row)));
    let mean = pairs().map(|(_, e)| luminance_weighted(e)).sum::<f64>() / n;
    let error = |of: &dyn Fn([f64; 3]) -> f64| {
        let squares: f64 = pairs().map(|(h, e)| (of(h) - of(e)).powi(2)).sum();
        (squares / n).sqrt()
    };
    let rms = error(&luminance_weighted) / mean;
    let bias = pairs().map(|(h, e)| luminance_weighted(h) - luminance_weighted(e)).sum::<f64>() / n / mean;
    println!("{} points: RMS {rms:.5}, bias {bias:.5}", table.len());
    assert!(rms < 0.01, "RMS of luminance over mean {rms}");
    assert!(bias.abs() < 0.003, "bias {bias}");
    for band in 0..3 {
        let mean = pairs().map(|(_, e)| e[band]).sum::<f64>() / n;
        let rms = error(&|h| h[band]) / mean;
        assert!(rms < 0.01, "band {band}: {rms}");
    }
}

#[test]
fn the_estimated_error_of_points_in_the_cornell_box_holds_the_path_traced_one() {
    let table = traced();
    let points: Vec<(DVec3, DVec3)> =
        table.iter().map(|row| (dvec3(row[0], row[1], row[2]), dvec3(row[3], row[4], row[5]))).collect();
    let scene = cornell();
    let lighting = scene.lighting();
    for patches in [PatchTarget::Auto, PatchTarget::Count(400)] {
        let solution = solved(&scene, &lines(patches));
        let found = study::points(&solution, &lighting, &solution.light(&lighting), &points);
        let n = table.len() as f64;
        let truth = |row: &[f64]| luminance_weighted([row[6], row[7], row[8]]);
        let mean = table.iter().map(|row| truth(row)).sum::<f64>() / n;
        // What was traced is off by a quarter of a percent of the mean (RMS) by itself.
        let slack = 2.0 * 0.0025 * mean;
        let off = |k: usize| (luminance_weighted(found[k].irradiance) - truth(&table[k])).abs();
        let covered = (0..table.len()).filter(|&k| off(k) <= found[k].error.hypot(slack)).count() as f64 / n;
        let strictly = (0..table.len()).filter(|&k| off(k) <= found[k].error).count() as f64 / n;
        let rms = |of: &dyn Fn(usize) -> f64| {
            ((0..table.len()).map(|k| of(k).powi(2)).sum::<f64>() / n).sqrt() / mean
        };
        let (actual, estimated) = (rms(&off), rms(&|k| found[k].error));
        println!("{patches:?}: {covered:.3} covered ({strictly:.3} without the reference's own noise)");
        println!("RMS error {actual:.5}, estimated {estimated:.5}");
        assert!(covered >= 0.9, "{covered}");
        assert!(estimated < 4.0 * actual.max(0.0025), "{estimated} for {actual}");
    }
}
