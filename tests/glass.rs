//! Light that passes panes of glass: rows, direct light, the witness, and how models say what is glass.

mod common;

use common::quads::Quads;
use common::settings;
use glam::DVec3;
use lumenwalk::accuracy::AuditSettings;
use lumenwalk::effects::{Effect, EffectChoices};
use lumenwalk::form_factors::Method;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, SceneSource, load};
use lumenwalk::solve::{self, Control, Solution, SolveSettings, prepare};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

impl Quads {
    fn read(&self, sidecar: &str) -> Result<Scene, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("written");
        };
        write("m.obj", &format!("mtllib m.mtl\n{}", self.text));
        write(
            "m.mtl",
            "newmtl grey\nKd .5 .5 .5\nnewmtl black\nKd 0 0 0\nnewmtl lamp\nKd 0 0 0\nKe 10 10 10\n\
             newmtl glass\nKd 0 0 0\nNi 1.52\nillum 6\nTf .88 .88 .88\n\
             newmtl blue\nKd 0 0 0\nNi 1.52\nd .5\nTf .2 .4 1\nnewmtl paint\nKd .3 .3 .3\n",
        );
        write("m.toml", &format!("up = \"z\"\n{sidecar}"));
        load(&SceneSource::File(folder.path().join("m.obj"))).map_err(|error| error.to_string())
    }

    fn scene(&self) -> Arc<Scene> {
        Arc::new(self.read("").expect("a scene"))
    }
}

fn solved(scene: Arc<Scene>, settings: &SolveSettings) -> Solution {
    let never = AtomicBool::new(false);
    solve::solve(scene, settings, &never, &mut |_| Control::Continue).expect("solved")
}

fn usual(patches: usize) -> SolveSettings {
    SolveSettings { patches: PatchTarget::Count(patches), ..SolveSettings::default() }
}

/// Luminances of the irradiances at points that look up.
fn watts(solution: &Solution, points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let light = solution.light(&solution.scene.lighting());
    let up: Vec<(DVec3, DVec3)> = points.iter().map(|&p| (DVec3::from(p), DVec3::Z)).collect();
    solution.irradiance_at(&up, &light)
}

#[test]
fn rows_through_a_wide_pane_sum_to_its_hemispherical_transmittance_by_every_method() {
    // A small floor under two sheets and a ceiling that fills the sky; one sheet passes 0.805554 of even light.
    let wide = [-400.0, -400.0, 400.0, 400.0];
    let small = [-0.1, -0.1, 0.1, 0.1];
    for (panes, passed) in [(1, 0.805_554), (2, f64::NAN)] {
        let mut quads = Quads::default().level("paint", small, 0.0, true).level("lamp", wide, 1.0, false);
        for pane in 0..panes {
            quads = quads.level("glass", wide, 0.3 + 0.3 * f64::from(pane), true);
        }
        let scene = quads.scene();
        // Of two, the mean of the squares: by quadrature over the same formula.
        let passed = if passed.is_nan() { mean_of_squares() } else { passed };
        for (method, resolution) in common::METHODS {
            let prepared = prepare(scene.clone(), &settings(PatchTarget::Count(50), method, resolution))
                .expect("a mesh");
            let floor = prepared.mesh.patches.iter().position(|p| p.luminaire.is_none()).expect("a floor");
            let row = prepared.computer.row(floor as u32, &mut prepared.computer.scratch());
            // The floor sees itself as well, mirrored by the panes.
            let shines = |patch: u32| prepared.mesh.patches[patch as usize].luminaire.is_some();
            let seen = row.patches.iter().zip(&row.values).filter(|entry| shines(*entry.0));
            let sum: f64 = seen.map(|entry| f64::from(*entry.1)).sum();
            let exact = passed * (1.0 - 1.0 / (400.0 * 400.0));
            // At grazing angles, of which rays and cells have few, glass passes nothing.
            let slack = if method == Method::Lines { 5e-4 } else { 8e-3 };
            assert!((sum - exact).abs() < slack, "{panes} panes by {method:?}: {sum} for {exact}");
        }
    }
}

/// Integral of 2 cos T² over cos for Tn = 0.88 (midpoints).
fn mean_of_squares() -> f64 {
    let pane = lumenwalk::glazing::Pane::from_transmittance(1.52, [0.88; 3]).expect("glass");
    let n = 20_000;
    (0..n)
        .map(|k| (f64::from(k) + 0.5) / f64::from(n))
        .map(|cos| 2.0 * cos * pane.transmittance(cos)[0].powi(2) / f64::from(n))
        .sum()
}

#[test]
fn a_lamp_behind_a_pane_gives_what_quadrature_over_its_points_gives() {
    let quads = Quads::default()
        .level("black", [-2.0, -2.0, 2.0, 2.0], 0.0, true)
        .level("glass", [-0.5, -2.0, 0.3, 2.0], 1.0, true)
        .level("lamp", [-0.5, -0.5, 0.5, 0.5], 2.0, false);
    let solution = solved(quads.scene(), &usual(200));
    let places = [[0.0, 0.0, 0.0], [0.6, 0.2, 0.0], [-1.5, 0.4, 0.0], [1.4, -1.0, 0.0]];
    let pane = lumenwalk::glazing::Pane::from_transmittance(1.52, [0.88; 3]).expect("glass");
    for (place, found) in places.iter().zip(watts(&solution, &places)) {
        let n = 400;
        let mut exact = 0.0;
        for k in 0..n * n {
            let at = |k: i32| -0.5 + (f64::from(k) + 0.5) / f64::from(n);
            let way = DVec3::new(at(k % n), at(k / n), 2.0) - DVec3::from(*place);
            let (r2, cos) = (way.length_squared(), way.z / way.length());
            let crossing = place[0] + 0.5 * way.x;
            let passed = if (-0.5..0.3).contains(&crossing) { pane.transmittance(cos)[0] } else { 1.0 };
            exact += passed * 10.0 * cos * cos / r2 / f64::from(n * n);
        }
        assert!((found[1] / exact - 1.0).abs() < 1.5e-3, "{place:?}: {} for {exact}", found[1]);
    }
}

/// A pane that stands on edge at x = 1, before a floor that reflects nothing: y from -0.5 to 0.5, z from 0.2 to 1.5.
fn before_a_pane() -> Quads {
    Quads::default()
        .level("black", [-2.0, -2.0, 3.0, 2.0], 0.0, true)
        .quad("glass", [[1.0, -0.5, 0.2], [1.0, 0.5, 0.2], [1.0, 0.5, 1.5], [1.0, -0.5, 1.5]])
}

/// Whether a line from a point meets that pane, and the cosine of its angle there.
fn on_pane(from: DVec3, way: DVec3) -> Option<f64> {
    let met = from + way * ((1.0 - from.x) / way.x);
    let is_on = way.x > 0.0 && met.y.abs() < 0.5 && (0.2..1.5).contains(&met.z);
    is_on.then(|| way.x / way.length())
}

#[test]
fn a_pane_mirrors_a_lamp_as_quadrature_over_its_points_has_it() {
    let quads = before_a_pane().level("lamp", [-0.5, -0.5, 0.5, 0.5], 2.0, false);
    // A screen over the way from the lamp to the pane, and none.
    let screened = before_a_pane()
        .level("lamp", [-0.5, -0.5, 0.5, 0.5], 2.0, false)
        .quad("black", [[0.7, -2.0, 1.0], [0.7, 2.0, 1.0], [0.7, 2.0, 1.8], [0.7, -2.0, 1.8]])
        .quad("black", [[0.69, -2.0, 1.0], [0.69, -2.0, 1.8], [0.69, 2.0, 1.8], [0.69, 2.0, 1.0]]);
    let places = [[0.5, 0.0, 0.0], [0.8, 0.3, 0.0], [0.0, -0.4, 0.0], [-0.9, 0.2, 0.0]];
    let pane = lumenwalk::glazing::Pane::from_transmittance(1.52, [0.88; 3]).expect("glass");
    for (quads, screen, slack) in [(quads, None, 0.01), (screened, Some(0.7), 0.06)] {
        let solution = solved(quads.scene(), &usual(200));
        for (place, found) in places.iter().zip(watts(&solution, &places)) {
            let (n, from) = (300, DVec3::from(*place));
            let hides = |from: DVec3, way: DVec3, [near, far]: [f64; 2]| {
                let Some(x) = screen else { return false };
                let at = (x - from.x) / way.x;
                at > near && at < far && (1.0..1.8).contains(&(from + way * at).z)
            };
            let (mut straight, mut mirrored) = (0.0, 0.0);
            for k in 0..n * n {
                let at = |k: i32| -0.5 + (f64::from(k) + 0.5) / f64::from(n);
                let lamp = DVec3::new(at(k % n), at(k / n), 2.0);
                let give = |way: DVec3| 10.0 * (way.z / way.length_squared()).powi(2) / f64::from(n * n);
                if !hides(from, lamp - from, [0.0, 1.0]) {
                    straight += give(lamp - from);
                }
                // Its image stands behind the pane.
                let way = DVec3::new(2.0 - lamp.x, lamp.y, lamp.z) - from;
                let Some(cos) = on_pane(from, way) else { continue };
                let met = (1.0 - from.x) / way.x;
                let back = DVec3::new(-way.x, way.y, way.z);
                let turned = from + way * met - back * met;
                if !hides(from, way, [0.0, met]) && !hides(turned, back, [met, 1.0]) {
                    mirrored += pane.reflectance(cos)[0] * give(way);
                }
            }
            let off = found[1] - straight - mirrored;
            println!("{place:?}: {:.5} for {straight:.5} + {mirrored:.5}", found[1]);
            assert!(off.abs() < slack * mirrored + 1e-3 * straight, "{place:?}: {off}, {mirrored} mirrored");
        }
    }
}

#[test]
fn a_pane_mirrors_the_sky_to_those_before_it() {
    let sidecar = "[daylight]\nsun = [60, 0]\nsky = \"uniform\"\nlux = [0, 10000]\nground = 0\n";
    let scene = Arc::new(before_a_pane().read(sidecar).expect("a scene"));
    let solution = solved(scene, &usual(200));
    let places = [[0.9, 0.0, 0.0], [0.6, 0.2, 0.0], [-0.5, 0.0, 0.0], [1.3, 0.1, 0.0]];
    let pane = lumenwalk::glazing::Pane::from_transmittance(1.52, [0.88; 3]).expect("glass");
    let open = 10_000.0 / 179.0;
    for (place, found) in places.iter().zip(watts(&solution, &places)) {
        // Shares of what the open sky gives, by directions of equal share.
        let (mut passed, mut mirrored) = (0.0, 0.0);
        let n = 1000;
        for k in 0..n * n {
            let (r2, turn) =
                ((f64::from(k % n) + 0.5) / f64::from(n), (f64::from(k / n) + 0.5) / f64::from(n));
            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
            let up = DVec3::new(r2.sqrt() * cos, r2.sqrt() * sin, (1.0 - r2).sqrt());
            // Seen from behind as from before.
            let from = DVec3::new(1.0 - (1.0 - place[0]).abs(), place[1], 0.0);
            let glass = on_pane(from, up);
            passed += glass.map_or(1.0, |cos| pane.transmittance(cos)[0]) / f64::from(n * n);
            mirrored += glass.map_or(0.0, |cos| pane.reflectance(cos)[0]) / f64::from(n * n);
        }
        println!("{place:?}: {:.5} for {passed:.5} + {mirrored:.5}", found[1] / open);
        let off = found[1] / open - passed - mirrored;
        assert!(off.abs() < 0.01 * mirrored + 5e-4, "{place:?}: {off}, {mirrored} mirrored");
    }
}

/// Two halves of a room with a partition over a parapet: glass with its thickness, or nothing.
fn two_halves(with_glass: bool) -> Quads {
    let quads = Quads::default()
        .room("grey", [4.0, 3.0, 2.5])
        .level("lamp", [0.6, 1.0, 1.2, 2.0], 2.49, false)
        .quad("grey", [[2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [2.0, 3.0, 0.9], [2.0, 0.0, 0.9]])
        .quad("grey", [[1.99, 0.0, 0.0], [1.99, 0.0, 0.9], [1.99, 3.0, 0.9], [1.99, 3.0, 0.0]]);
    if !with_glass {
        return quads;
    }
    quads
        .quad("glass", [[2.0, 0.0, 0.9], [2.0, 3.0, 0.9], [2.0, 3.0, 2.5], [2.0, 0.0, 2.5]])
        .quad("glass", [[1.99, 0.0, 0.9], [1.99, 0.0, 2.5], [1.99, 3.0, 2.5], [1.99, 3.0, 0.9]])
}

/// What raw rows exchange across the partition, m², and the sum of its differences there and back.
fn across(solution: &Solution) -> (f64, f64) {
    let (mesh, computer) = (&solution.mesh, &solution.computer);
    let mut scratch = computer.scratch();
    let rows: Vec<_> =
        (0..mesh.patches.len() as u32).map(|patch| computer.row(patch, &mut scratch)).collect();
    let (mut there, mut gap) = (0.0, 0.0);
    for (i, row) in rows.iter().enumerate() {
        for (&j, &value) in row.patches.iter().zip(&row.values) {
            let (a, b) = (&mesh.patches[i], &mesh.patches[j as usize]);
            if (a.centre.x - 2.0) * (b.centre.x - 2.0) < 0.0 {
                let out = a.area * f64::from(value);
                there += out;
                gap += (out - b.area * rows[j as usize].get(i as u32)).abs();
            }
        }
    }
    (there, gap)
}

#[test]
fn a_room_with_a_glass_partition_agrees_with_the_witness_and_sends_light_both_ways_alike() {
    let [glazed, open] = [true, false].map(|with_glass| solved(two_halves(with_glass).scene(), &usual(1500)));
    assert_eq!(glazed.mesh.panes.list.len(), 2);
    // 1. Raw rows, before they are made reciprocal: glass dims what they exchange, and alike from either side.
    let ((there, gap), (unhindered, usual_gap)) = (across(&glazed), across(&open));
    println!(
        "{there:.3} m² with glass, {unhindered:.3} without; gaps {:.3} {:.3}",
        gap / there,
        usual_gap / unhindered
    );
    assert!((0.72..0.86).contains(&(there / unhindered)), "{there} of {unhindered} m²");
    assert!(gap / there < 1.25 * usual_gap / unhindered, "{gap} of {there}, {usual_gap} of {unhindered}");
    // 2. Power: what is emitted is absorbed, the glass's share included.
    let light = glazed.light(&glazed.scene.lighting());
    assert!(light.irradiance.iter().flatten().all(|e| e.is_finite() && *e >= 0.0));
    // 3. Light on both sides, by rays of their own.
    let audit = AuditSettings::default();
    let findings = lumenwalk::study::audit(&glazed, &glazed.scene.lighting(), &audit, &|| false);
    let total = findings.expect("lit").budget.total;
    println!("{total:?}");
    assert!(total.error < 0.06, "{total:?}");
}

#[test]
fn without_the_effect_glass_is_opaque_and_where_there_is_none_it_costs_nothing() {
    let quads = Quads::default()
        .level("black", [-1.0, -1.0, 1.0, 1.0], 0.0, true)
        .level("glass", [-9.0, -9.0, 9.0, 9.0], 1.0, true)
        .level("lamp", [-0.5, -0.5, 0.5, 0.5], 2.0, false);
    let with = solved(quads.scene(), &usual(100));
    assert!(with.plan.is_on(Effect::Glass) && with.plan.is_on(Effect::Visibility));
    assert!(watts(&with, &[[0.0; 3]])[0][0] > 1.0);
    let effects = EffectChoices { without: vec![Effect::Glass], ..EffectChoices::default() };
    let without = solved(quads.scene(), &SolveSettings { effects, ..usual(100) });
    assert!(!without.plan.is_on(Effect::Glass) && without.mesh.panes.is_empty());
    assert_eq!(watts(&without, &[[0.0; 3]])[0], [0.0; 3]);
    let plain =
        Quads::default().room("grey", [2.0, 2.0, 2.0]).level("lamp", [0.5, 0.5, 1.0, 1.0], 1.9, false);
    let plan = solved(plain.scene(), &usual(100)).plan;
    assert!(!plan.is_on(Effect::Glass));
}

#[test]
fn tinted_glass_colours_what_passes_even_in_a_grey_scene() {
    let quads = Quads::default()
        .level("black", [-1.0, -1.0, 1.0, 1.0], 0.0, true)
        .level("blue", [-9.0, -9.0, 9.0, 9.0], 1.0, true)
        .level("lamp", [-0.05, -0.05, 0.05, 0.05], 2.0, false);
    let solution = solved(quads.scene(), &usual(100));
    assert!(solution.plan.is_on(Effect::ColourBands));
    let [red, green, blue] = watts(&solution, &[[0.0; 3]])[0];
    // Tf times 1 - d.
    let ratio = |a: f64, b: f64, wanted: f64| assert!((a / b / wanted - 1.0).abs() < 2e-3, "{a} / {b}");
    ratio(red, blue, 0.2);
    ratio(green, blue, 0.4);
    let unhindered = 10.0 * 0.01 / 4.0;
    ratio(blue, unhindered, 0.5);
}

#[test]
fn a_sidecar_says_what_is_glass_and_what_cannot_be_is_refused_in_one_sentence() {
    let quads = Quads::default().level("black", [-1.0, -1.0, 1.0, 1.0], 0.0, true).level(
        "paint",
        [-1.0, -1.0, 1.0, 1.0],
        1.0,
        true,
    );
    let glazing = |keys: &str| -> Result<Option<(usize, f64)>, String> {
        let scene = quads.read(&format!("[[material]]\nname = \"paint\"\n{keys}\n"))?;
        let paint = scene.materials.iter().find(|m| m.name == "paint").expect("paint");
        Ok(paint.glazing.as_ref().map(|unit| (unit.panes().len(), unit.transmittance(1.0)[0])))
    };
    let close = |found: Result<Option<(usize, f64)>, String>, panes: usize, passed: f64| {
        let (n, t) = found.expect("read").expect("glass");
        assert!(n == panes && (t - passed).abs() < 1e-6, "{n} panes pass {t}");
    };
    close(glazing("transmittance = 0.7"), 1, 0.7);
    close(glazing("transmittance = [0.6, 0.7, 0.65]\npanes = 2"), 2, 0.6);
    close(glazing("glass = true"), 1, 0.88);
    close(glazing("panes = 2"), 2, 0.88 * 0.88);
    assert_eq!(glazing("sides = \"both\""), Ok(None));
    for (keys, told) in [
        ("transmittance = 0.95", "at most 0.9183"),
        ("transmittance = -1", "none is below 0"),
        ("transmittance = nan", "cannot be such glass"),
        ("transmittance = \"clear\"", "a number from 0 to 1, or three"),
        ("panes = 0", "glass has 1 to 6"),
        ("panes = 7", "glass has 1 to 6"),
        ("glass = false\npanes = 2", "takes no transmittance and no panes"),
    ] {
        let message = glazing(keys).expect_err(keys);
        assert!(message.contains(told) && message.contains("line"), "{keys}: {message}");
    }
    let opaque = Quads::default().level("black", [-1.0, -1.0, 1.0, 1.0], 0.0, true).level(
        "glass",
        [0.0, 0.0, 1.0, 1.0],
        1.0,
        true,
    );
    let read = opaque.read("[[material]]\nname = \"glass\"\nglass = false\n").expect("read");
    assert!(read.materials.iter().all(|m| m.name != "glass" || m.glazing.is_none()));
}
