//! Whole solutions against closed forms and against the laws that radiosity obeys.

mod common;

use common::{
    Assembled, Model, assembled, builtin, ceiling_with_lamp, close, lines, mean, room_with_blocks, solved,
};
use glam::{DMat3, DVec3, dvec3};
use lumenwalk::form_factors::RowComputer;
use lumenwalk::form_factors::closed_form::point_to_polygon;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, illuminance};
use lumenwalk::solver::{GaussSeidel, PatchLight, System};
use lumenwalk::watch::Cancelled;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

fn cube() -> Model {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, DVec3::ONE, [paint, Some("glow"), paint, paint, paint, paint]);
    m
}

/// Patches that see something; what lies under a box sees nothing, and stays dark.
fn lit(made: &Assembled) -> Vec<usize> {
    (0..made.patches().len()).filter(|&i| made.transport.row_sum(i) > 0.0).collect()
}

#[test]
fn a_white_furnace_is_white() {
    for (name, scene, patches) in [
        ("cube", cube().scene(), PatchTarget::Count(300)),
        ("room with blocks", room_with_blocks(0.5).scene(), PatchTarget::Count(1200)),
        ("hemicube", builtin("hemicube"), PatchTarget::Auto),
    ] {
        let made = assembled(&scene, &lines(patches));
        // Reflectances of the scene itself, a band after the other, and emission 1 - rho.
        for band in 0..3 {
            let own = |i: usize| made.patches()[i].reflectance[band];
            let b = made.radiosity(&made.grey_system(|i| (own(i), 1.0 - own(i))), 1e-7);
            for i in lit(&made) {
                let p = &made.patches()[i];
                assert!(
                    (b[i] - 1.0).abs() < 1e-4,
                    "{name}: B = {} at {} facing {}",
                    b[i],
                    p.centre,
                    p.normal
                );
            }
        }
    }
}

#[test]
fn a_white_furnace_is_white_in_the_gallery() {
    // One-sided things stand upon each other here and lamps hide in coves; still no row loses anything.
    let made = assembled(&builtin("gallery"), &common::settings(PatchTarget::Auto, Default::default(), 96));
    let own = |i: usize| made.patches()[i].reflectance[0];
    let b = made.radiosity(&made.grey_system(|i| (own(i), 1.0 - own(i))), 1e-7);
    for i in lit(&made) {
        let p = &made.patches()[i];
        assert!((b[i] - 1.0).abs() < 1e-4, "B = {} at {} facing {}", b[i], p.centre, p.normal);
    }
}

#[test]
fn uniform_reflectance_multiplies_the_emitted_power() {
    let made = assembled(&room_with_blocks(0.5).scene(), &lines(PatchTarget::Count(800)));
    for rho in [0.5, 0.9, 0.99] {
        let emission = |i: usize| if made.patches()[i].luminaire.is_some() { 20.0 } else { 0.0 };
        let b = made.radiosity(&made.grey_system(|i| (rho, emission(i))), 1e-9);
        let power = |value: &dyn Fn(usize) -> f64| -> f64 {
            lit(&made).iter().map(|&i| made.patches()[i].area * value(i)).sum()
        };
        let expected = power(&emission) / (1.0 - rho);
        close(&format!("total power at rho {rho}"), power(&|i| b[i]), expected, 1e-6);
    }
}

#[test]
fn a_cube_of_six_patches_has_its_published_solution() {
    let made = assembled(&cube().scene(), &lines(PatchTarget::AsGiven));
    assert_eq!(made.patches().len(), 6);
    let emitter = made.of(|o| o == "ceiling")[0];
    let (floor, side) = (made.of(|o| o == "floor")[0], made.of(|o| o == "west")[0]);
    for (rho, expected) in [
        (0.5, [1.090_909_098_107_695, 0.181_745_826_107_788_5, 0.181_836_268_946_129]),
        (0.9, [2.372_881_374_825_758, 1.525_310_551_124_541, 1.525_452_018_512_426]),
    ] {
        let b = made.radiosity(&made.grey_system(|i| (rho, if i == emitter { 1.0 } else { 0.0 })), 1e-9);
        for (patch, expected) in [emitter, floor, side].into_iter().zip(expected) {
            close(&format!("B of patch {patch} at rho {rho}"), b[patch], expected, 2e-5);
        }
    }
}

#[test]
fn a_room_of_three_zones_has_its_published_solution() {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.7; 3], [100.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, dvec3(6.0, 3.0, 4.0), [paint, Some("glow"), paint, paint, paint, paint]);
    let made = assembled(&m.scene(), &lines(PatchTarget::Size(0.4)));
    let zones = [
        made.of(|o| o == "ceiling"),
        made.of(|o| ["west", "east", "north", "south"].contains(&o)),
        made.of(|o| o == "floor"),
    ];
    close("from floor to ceiling", made.between(&zones[2], &zones[0]), 0.341_693_913_524_762, 1e-3);
    // 1. Zones of constant radiosity, as published, over the zones' form factors.
    let rho = [0.7, 0.5, 0.2];
    let f: Vec<Vec<f64>> =
        zones.iter().map(|from| zones.iter().map(|to| made.between(from, to)).collect()).collect();
    let mut b = [100.0, 0.0, 0.0];
    for _ in 0..200 {
        for i in 0..3 {
            let arriving: f64 = (0..3).map(|j| f[i][j] * b[j]).sum();
            b[i] = if i == 0 { 100.0 } else { 0.0 } + rho[i] * arriving;
        }
    }
    let published = [112.255_084_44, 21.166_116_42, 10.458_132_48];
    for i in 0..3 {
        close(&format!("zone {i}"), b[i], published[i], 1e-3);
    }
    // 2. The whole solution differs from it only as light varies within a zone.
    let zone_of = |i: usize| zones.iter().position(|z| z.contains(&i)).unwrap();
    let system = made.grey_system(|i| (rho[zone_of(i)], if zone_of(i) == 0 { 100.0 } else { 0.0 }));
    let b = made.radiosity(&system, 1e-7);
    for i in 0..3 {
        close(&format!("mean of zone {i}"), mean(made.patches(), &zones[i], |p| b[p]), published[i], 0.02);
    }
}

#[test]
fn every_point_of_a_sphere_gets_the_same() {
    let mut m = Model::new();
    m.grey("paint", 0.3).paint("glow", [0.8; 3], [1.0; 3]);
    m.sphere([-1.0, 1.0], [16, 24], &|ring| if ring >= 12 { "glow" } else { "paint" });
    let made = assembled(&m.one_sided(), &lines(PatchTarget::AsGiven));
    let all: Vec<usize> = (0..made.patches().len()).collect();
    let (bright, dark): (Vec<usize>, Vec<usize>) =
        all.iter().partition(|&&i| made.patches()[i].luminaire.is_some());
    let b = made.radiosity(
        &made.grey_system(|i| if made.patches()[i].luminaire.is_some() { (0.8, 1.0) } else { (0.3, 0.0) }),
        1e-8,
    );
    // The facets of a zone have not quite its share of the area, and do not see themselves.
    close("share of the zone", made.area(&bright) / made.area(&all), 0.25, 0.01);
    close("B of the emitting zone", mean(made.patches(), &bright, |i| b[i]), 1.347_826, 0.01);
    close("B of the other zone", mean(made.patches(), &dark, |i| b[i]), 0.130_435, 0.01);
    for &i in &dark {
        close(
            &format!("irradiance at {}", made.patches()[i].centre),
            b[i] / 0.3,
            0.434_782_608_695_652,
            0.02,
        );
    }
}

#[test]
fn two_plates_tend_to_the_infinite_ones() {
    let (e, rho) = ([3.0, 1.0], [0.6, 0.8]);
    let mut m = Model::new();
    m.paint("one", [rho[0]; 3], [e[0]; 3]).paint("two", [rho[1]; 3], [e[1]; 3]);
    m.object("one").quad("one", DVec3::ZERO, DVec3::X, DVec3::Y);
    m.object("two").quad("two", DVec3::Z * 0.1, DVec3::Y, DVec3::X);
    let made = assembled(&m.one_sided(), &lines(PatchTarget::AsGiven));
    let b = made.radiosity(&made.grey_system(|i| (rho[i], e[i])), 1e-9);
    let f = 0.826_994_522_397_257;
    let finite = (e[0] + rho[0] * f * e[1]) / (1.0 - rho[0] * rho[1] * f * f);
    close("plates at a tenth of their width", b[0], finite, 1e-3);
    // What passes between the plates to their sides is lost.
    let infinite = (e[0] + rho[0] * e[1]) / (1.0 - rho[0] * rho[1]);
    assert!(b[0] < infinite, "{} leaves less than {infinite}", b[0]);
}

#[test]
fn a_lamp_in_the_middle_of_a_cube_lights_its_walls_as_cie_171_says() {
    // CIE 171:2006, 5.8, with a lamp of 0.1 m in place of its point source.
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.98; 3], [1.0; 3]);
    m.room(DVec3::ZERO, DVec3::splat(4.0), [Some("paint"); 6]);
    m.block("lamp", "glow", DVec3::splat(1.95), DVec3::splat(2.05));
    let scene = m.scene_with(Some("[[luminaire]]\nobject = \"lamp\"\nname = \"Lamp\"\nlumens = 10000\n"));
    let made = assembled(&scene, &lines(PatchTarget::Size(0.5)));
    let walls = made.of(|o| o != "lamp");
    close("area of the walls", made.area(&walls), 96.0, 1e-9);
    for (rho, expected) in [(0.0, 104.1667), (0.5, 208.3333), (0.8, 520.8333), (0.95, 2083.3333)] {
        let reflectance: Vec<[f64; 3]> =
            made.patches().iter().map(|p| [if p.luminaire.is_some() { 0.98 } else { rho }; 3]).collect();
        let irradiance = made.irradiance(&made.system(Some(&reflectance)), 1e-7);
        let lux = mean(made.patches(), &walls, |i| illuminance(irradiance[i].map(f64::from)));
        close(&format!("mean illuminance at rho {rho}"), lux, expected, 1e-3);
    }
}

#[test]
fn caps_glow_as_their_closed_forms_say() {
    for (degrees, expected) in [(90.0_f64, 5.0 / 3.0), (120.0, 2.5)] {
        let mut m = Model::new();
        m.paint("glow", [0.8; 3], [1.0; 3]);
        m.sphere([degrees.to_radians().cos(), 1.0], [14, 32], &|_| "glow");
        let made = assembled(&m.one_sided(), &lines(PatchTarget::AsGiven));
        let b = made.radiosity(&made.grey_system(|_| (0.8, 1.0)), 1e-8);
        let all: Vec<usize> = (0..b.len()).collect();
        // Facets have less area than the round cap, by some 0.7 %, and so lose more light.
        close(&format!("cap of {degrees} degrees"), mean(made.patches(), &all, |i| b[i]), expected, 0.02);
    }
}

/// Two rooms of 3 m joined by a door of 0.8 x 2 m; the lamp hangs in one.
fn two_rooms() -> Arc<Scene> {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(6.0, 3.0, 3.0), [all, None, all, all, all, all]);
    ceiling_with_lamp(&mut m, "paint", [6.0, 3.0, 3.0], [1.2, 1.8, 1.2, 1.8]);
    m.object("wall");
    for (z, y, dz, dy) in [(0.0, 0.0, 1.1, 3.0), (1.1, 2.0, 0.8, 1.0), (1.9, 0.0, 1.1, 3.0)] {
        m.quad("paint", dvec3(3.0, y, z), DVec3::Z * dz, DVec3::Y * dy);
    }
    m.scene()
}

/// Asserts that eight sweeps from B = E reach 2e-5 of the largest radiosity, truly and not only by
/// the residual: against the solution swept until its bound, which is guaranteed, is 1e-8.
fn check_eight_sweeps(name: &str, made: &Assembled, system: &System) {
    let (exact, reports) = made.sweep(system, 1e-8);
    let bound = reports.last().unwrap().error_bound;
    assert!(bound <= 1e-8, "{name}: the reference itself is off by {bound}");
    let mut solver = made.solver(system);
    let mut report = solver.report(system);
    for _ in 0..8 {
        report = solver.sweep(made.transport.as_ref(), system, &|| false).expect("not cancelled");
    }
    let bases = solver.bases(system);
    let columns = system.columns();
    for c in 0..columns {
        let b = |values: &[f32], i: usize| {
            system.exitance(i, c) + system.rho(i, c) * f64::from(values[i * columns + c])
        };
        let largest = (0..system.patches()).map(|i| b(&exact.values, i)).fold(0.0, f64::max);
        let error = (0..system.patches())
            .map(|i| (b(&bases.values, i) - b(&exact.values, i)).abs())
            .fold(0.0, f64::max);
        assert!(error <= 2e-5 * largest, "{name}, column {c}: off by {:.1e} after 8 sweeps", error / largest);
        // The guarantee holds; values are kept in single precision.
        let said = report.error_bound + 1e-6;
        assert!(error <= said * largest, "{name}: bound {said:.1e}, error {:.1e}", error / largest);
    }
}

#[test]
fn eight_sweeps_are_enough_everywhere() {
    for (name, patches) in [("hemicube", 900), ("cornell", 900), ("gallery", 600), ("house", 400)] {
        let scene = builtin(name);
        let made = assembled(&scene, &common::settings(PatchTarget::Count(patches), Default::default(), 48));
        check_eight_sweeps(name, &made, &made.system(None));
        let bright = vec![[0.99; 3]; made.patches().len()];
        check_eight_sweeps(&format!("{name} at 0.99"), &made, &made.system(Some(&bright)));
    }
}

#[test]
fn eight_sweeps_are_enough_for_two_rooms_and_a_door() {
    let made = assembled(&two_rooms(), &lines(PatchTarget::Count(1200)));
    for rho in [0.8, 0.95, 0.99] {
        let reflectance = vec![[rho; 3]; made.patches().len()];
        check_eight_sweeps(&format!("rho {rho}"), &made, &made.system(Some(&reflectance)));
    }
}

#[test]
fn what_is_emitted_is_absorbed_or_escapes() {
    let two = two_rooms();
    for (name, scene) in [("cornell", &builtin("cornell")), ("two rooms", &two)] {
        let made = assembled(scene, &lines(PatchTarget::Count(700)));
        let system = made.system(None);
        for tolerance in [1e-4, 1e-8] {
            let (bases, reports) = made.sweep(&system, tolerance);
            let last = reports.last().unwrap();
            // The light itself tells the same.
            let rho: Vec<[f32; 3]> = made.patches().iter().map(|p| p.reflectance.map(|r| r as f32)).collect();
            let power = bases.mix(&made.prepared.mesh, &made.lighting(), &rho).power(
                &made.prepared.mesh,
                &rho,
                &made.lighting(),
            );
            close(&format!("{name}: power emitted"), power.emitted, last.emitted, 1e-6);
            close(&format!("{name}: power absorbed"), power.absorbed, last.absorbed, 1e-6);
            let emitted: f64 = made
                .patches()
                .iter()
                .filter(|p| p.luminaire.is_some())
                .map(|p| p.area * made.lighting().lamps[0].output().iter().sum::<f64>())
                .sum();
            close(&format!("{name}: emitted"), last.emitted, emitted, 1e-9);
            close(&format!("{name}: balance"), last.absorbed + last.escaped, last.emitted, tolerance);
            let escapes = last.escaped / last.emitted;
            let expected = if name == "cornell" { 0.05..0.5 } else { 0.0..1e-6 };
            assert!(expected.contains(&escapes), "{name}: {escapes} of the light escapes");
        }
    }
}

/// A room with two coloured lamps and coloured walls.
fn two_lamps() -> Model {
    let mut m = Model::new();
    m.grey("paint", 0.6).paint("red", [0.6, 0.1, 0.1], [0.0; 3]);
    m.paint("glow", [0.4; 3], [20.0, 18.0, 12.0]).paint("blue_glow", [0.4; 3], [1.0, 2.0, 9.0]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [paint, None, Some("red"), paint, paint, paint]);
    m.object("ceiling");
    ceiling_with_lamp(&mut m, "paint", [4.0, 3.0, 5.0], [1.6, 2.4, 2.1, 2.9]);
    m.block("cupboard", "paint", dvec3(0.7, 0.0, 0.9), dvec3(1.5, 1.8, 1.6));
    m.object("desk_lamp").quad("blue_glow", dvec3(2.5, 1.2, 3.5), DVec3::X * 0.4, DVec3::Z * 0.3);
    m
}

fn assert_same(what: &str, a: &PatchLight, b: &PatchLight, tolerance: f32) {
    assert_eq!(a.radiosity.len(), b.radiosity.len(), "{what}");
    for band in 0..3 {
        let largest = a.radiosity.iter().map(|v| v[band]).fold(0.0, f32::max);
        for (i, (x, y)) in a.radiosity.iter().zip(&b.radiosity).enumerate() {
            let difference = (x[band] - y[band]).abs();
            assert!(difference <= tolerance * largest, "{what}: patch {i} has {x:?} and {y:?}");
        }
    }
}

#[test]
fn a_mix_of_lamps_is_a_solve_with_those_lamps() {
    let made = assembled(&two_lamps().scene(), &lines(PatchTarget::Count(700)));
    let system = made.system(None);
    assert_eq!(system.lamps, 2);
    let reflectance: Vec<[f32; 3]> = system.reflectance.iter().map(|r| r.map(|b| b as f32)).collect();
    let (bases, _) = made.sweep(&system, 1e-8);
    let mesh = &made.prepared.mesh;
    let mut lighting = made.lighting();
    lighting.lamps[0].dimmer = 0.3;
    lighting.lamps[1].exitance = [7.0, 1.0, 2.0];
    let mix = bases.mix(mesh, &lighting, &reflectance);
    // One lamp made of both, as they are dimmed and coloured now.
    let direct = System {
        lamps: 1,
        emission: made
            .patches()
            .iter()
            .map(|p| {
                let lamp = p.luminaire? as usize;
                let output = lighting.lamps[lamp].output();
                Some((0, std::array::from_fn(|b| output[b] * p.emission_weight[b])))
            })
            .collect(),
        output: vec![1.0; 3],
        ..system.clone()
    };
    let (values, _) = made.sweep(&direct, 1e-8);
    let irradiance: Vec<[f32; 3]> = values.values.as_chunks::<3>().0.to_vec();
    let radiosity = irradiance
        .iter()
        .enumerate()
        .map(|(i, h)| std::array::from_fn(|b| direct.exitance(i, b) as f32 + reflectance[i][b] * h[b]))
        .collect();
    assert_same("mix and solve", &mix, &PatchLight { irradiance, radiosity, detail: None }, 2e-6);

    // Lamps alone add up, and off is dark.
    let with = |on: [bool; 2]| {
        let mut state = lighting.clone();
        state.lamps.iter_mut().zip(on).for_each(|(lamp, on)| lamp.on = on);
        bases.mix(mesh, &state, &reflectance)
    };
    let sum = |a: &[[f32; 3]], b: &[[f32; 3]]| -> Vec<[f32; 3]> {
        a.iter().zip(b).map(|(x, y)| std::array::from_fn(|k| x[k] + y[k])).collect()
    };
    let (one, two) = (with([true, false]), with([false, true]));
    let both = PatchLight {
        irradiance: sum(&one.irradiance, &two.irradiance),
        radiosity: sum(&one.radiosity, &two.radiosity),
        detail: None,
    };
    assert_same("sum of lamps", &mix, &both, 1e-6);
    assert!(with([false, false]).radiosity.iter().flatten().all(|&b| b == 0.0));
    // More light nowhere darkens.
    for (all, part) in mix.irradiance.iter().zip(&one.irradiance) {
        assert!((0..3).all(|b| all[b] >= part[b]), "{all:?} with a lamp more, {part:?} without");
    }
}

#[test]
fn lighter_walls_darken_nothing() {
    let made = assembled(&room_with_blocks(0.5).scene(), &lines(PatchTarget::Count(700)));
    let solve = |rho: f64| {
        made.radiosity(
            &made.grey_system(|i| {
                let lamp = made.patches()[i].luminaire.is_some();
                let wall = made.patches()[i].normal.x != 0.0;
                (if wall { rho } else { 0.5 }, if lamp { 20.0 } else { 0.0 })
            }),
            1e-8,
        )
    };
    let (darker, lighter) = (solve(0.3), solve(0.6));
    for i in lit(&made) {
        let emits = made.patches()[i].luminaire.is_some();
        let gain = lighter[i] - darker[i];
        assert!(gain > 0.0 || emits, "patch {i} loses {} with lighter walls", -gain);
    }
}

/// The scene moved, turned and scaled, with other names.
fn transformed(scene: &Scene, matrix: DMat3, shift: DVec3) -> Arc<Scene> {
    let mut moved = scene.clone();
    moved.positions.iter_mut().for_each(|p| *p = matrix * *p + shift);
    let turn = matrix * (1.0 / matrix.determinant().cbrt());
    moved.normals.iter_mut().for_each(|n| *n = turn * *n);
    moved.materials.iter_mut().enumerate().for_each(|(k, m)| m.name = format!("other {k}"));
    moved.objects.iter_mut().enumerate().for_each(|(k, o)| *o = format!("thing {k}"));
    moved.name = "elsewhere".to_owned();
    Arc::new(moved)
}

#[test]
fn light_does_not_care_where_a_scene_stands_how_large_it_is_or_what_it_is_called() {
    let scene = two_lamps().scene();
    // No length of the room is a multiple of it, so that rounding does not decide on a patch more.
    let size = 0.43;
    let here = solved(&scene, &lines(PatchTarget::Size(size)));
    let light = here.light(&scene.lighting());
    let turn = DMat3::from_axis_angle(dvec3(1.0, 2.0, -0.5).normalize(), 0.7);
    for (name, matrix, shift, scale) in [
        ("renamed", DMat3::IDENTITY, DVec3::ZERO, 1.0),
        ("moved", DMat3::IDENTITY, dvec3(3e3, -2e3, 1e3), 1.0),
        ("turned", turn, DVec3::ZERO, 1.0),
        ("in millimetres", DMat3::IDENTITY * 1e3, DVec3::ZERO, 1e3),
        ("as a model", DMat3::IDENTITY * 1e-3, DVec3::ZERO, 1e-3),
        ("all at once", turn * 12.0, dvec3(500.0, 20.0, -90.0), 12.0),
    ] {
        let other = transformed(&scene, matrix, shift);
        let there = solved(&other, &lines(PatchTarget::Size(size * scale)));
        // Rows are sampled in the frame of each surface, so that only rounding differs; but a corner
        // that falls on one side of a half-plane or the other moves a row by some 1e-4.
        let tolerance = if name == "renamed" { 0.0 } else { 1e-3 };
        assert_same(name, &light, &there.light(&other.lighting()), tolerance);
    }
}

#[test]
fn preparing_rows_and_sweeps_ends_when_it_is_asked_to() {
    let scene = builtin("hemicube");
    let made = assembled(&scene, &lines(PatchTarget::Count(3000)));
    let system = made.system(None);
    let (mesh, sampling) = (&made.prepared.mesh, lines(PatchTarget::Count(3000)).sampling());
    let rows = |cancelled: &(dyn Fn() -> bool + Sync)| {
        RowComputer::new_unless(mesh.clone(), sampling, true, cancelled).map(|_| ())
    };
    let sweeps = |cancelled: &(dyn Fn() -> bool + Sync)| {
        GaussSeidel::new_unless(mesh, made.transport.as_ref(), &system, (None, None), cancelled).map(|_| ())
    };
    type Work<'a> = &'a dyn Fn(&(dyn Fn() -> bool + Sync)) -> Result<(), Cancelled>;
    let works: [(&str, Work<'_>); 2] = [("rows", &rows), ("sweeps", &sweeps)];
    for (name, work) in works {
        let looks = AtomicUsize::new(0);
        let count = |end: usize| looks.fetch_add(1, Ordering::Relaxed) >= end;
        assert_eq!(work(&|| count(usize::MAX)), Ok(()), "{name}");
        let all = looks.load(Ordering::Relaxed);
        assert!(all > 100, "{name}: {all} looks");
        for end in [0, all / 10, all / 2, all - 1] {
            looks.store(0, Ordering::Relaxed);
            assert_eq!(work(&|| count(end)), Err(Cancelled), "{name} after {end} of {all} looks");
            let further = looks.load(Ordering::Relaxed) - end;
            assert!(
                further <= 64 * rayon::current_num_threads(),
                "{name}: {further} looks after the request"
            );
        }
    }
}

/// A black box on a square of 1 m with a lamp of 10 cm low on one of its sides, its lid in 4 x 4 parts: what these get depends on
/// where on the square the light falls.
#[test]
fn light_leaves_a_patch_from_where_it_falls() {
    const HEIGHT: f64 = 0.8;
    let lamp = |u: f64, v: f64| dvec3(0.001, 0.3 + 0.1 * u, 0.05 + 0.1 * v);
    let mut m = Model::new();
    m.grey("paint", 0.5).grey("black", 0.0).paint("glow", [0.0; 3], [100.0; 3]);
    m.object("square").quad("paint", DVec3::ZERO, DVec3::X, DVec3::Y);
    m.object("lamp").quad("glow", lamp(0.0, 0.0), DVec3::Y * 0.1, DVec3::Z * 0.1);
    for k in 0..16 {
        let at = dvec3(f64::from(k % 4) / 4.0, f64::from(k / 4) / 4.0, HEIGHT);
        m.object(&format!("part {k}")).quad("black", at, DVec3::Y * 0.25, DVec3::X * 0.25);
    }
    // Black walls around, so that nothing escapes.
    let up = DVec3::Z * HEIGHT;
    for (at, u, v) in [
        (DVec3::ZERO, up, DVec3::X),
        (DVec3::ZERO, DVec3::Y, up),
        (DVec3::Y, DVec3::X, up),
        (DVec3::X, up, DVec3::Y),
    ] {
        m.object("wall").quad("black", at, u, v);
    }
    let scene = m.one_sided();
    let found = solved(&scene, &lines(PatchTarget::AsGiven));
    let light = found.light(&scene.lighting());
    let detail = light.detail.as_ref().expect("direct light in detail");
    let transport = found.transport.as_ref().expect("solved");
    let square = found.mesh.patches.iter().position(|p| p.reflectance[0] > 0.0).expect("the square");
    // By sums over 100 x 100 places of the square and 4 x 4 of each part.
    let corners = [lamp(0.0, 0.0), lamp(0.0, 1.0), lamp(1.0, 1.0), lamp(1.0, 0.0)];
    let of = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let from: Vec<(DVec3, f64)> = (0..10_000)
        .map(|k| dvec3(of(k % 100, 100), of(k / 100, 100), 0.0))
        .map(|x| (x, 0.5 * 100.0 * point_to_polygon(x, DVec3::Z, &corners) / 10_000.0))
        .collect();
    let (mut off, mut even, mut sum) = (0.0, 0.0, 0.0);
    for (i, part) in found.mesh.patches.iter().enumerate().filter(|(_, p)| p.normal.z < -0.5) {
        let mut truth = 0.0;
        for k in 0..16 {
            let place = dvec3(of(k % 4, 4) - 0.5, of(k / 4, 4) - 0.5, 0.0) * 0.25;
            let y = part.centre + place;
            for &(x, b) in &from {
                let r2 = (y - x).length_squared();
                let kernel = HEIGHT * HEIGHT / (std::f64::consts::PI * r2 * r2);
                truth += b * kernel / 16.0;
            }
        }
        let evenly = transport.get(i, square) * 0.5 * f64::from(light.irradiance[square][1]);
        off += (f64::from(detail.interreflected[i][1]) - truth).powi(2);
        even += (evenly - truth).powi(2);
        sum += truth * truth;
    }
    let [off, even] = [off, even].map(|square| f64::sqrt(square / sum));
    assert!(off < 0.04 && even > 0.3, "{off}, and {even} if it left evenly");
    // None is lost or made on the way.
    let power = found.sweeps.last().expect("swept");
    close("power", power.absorbed + power.escaped, power.emitted, 1e-6);
}
