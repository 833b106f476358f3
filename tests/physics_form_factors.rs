//! Form factors against closed forms, Monte Carlo values and the identities that they obey.

mod common;

use common::{
    Assembled, METHODS, Model, assembled, builtin, ceiling_with_lamp, close, room_with_blocks, rows, settings,
};
use glam::{DVec3, dvec3};
use lumenwalk::form_factors::{Method, ReceivingPoints, closed_form};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, Sides};
use lumenwalk::solve::{Prepared, SolveSettings, prepare};
use rayon::prelude::*;
use std::sync::Arc;

/// Two polygons named a and b that face each other, one patch each.
fn pair(a: &[DVec3], b: &[DVec3]) -> Arc<Scene> {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    m.object("a").polygon("glow", a).object("b").polygon("paint", b);
    m.one_sided()
}

fn rectangle(at: DVec3, u: DVec3, v: DVec3) -> [DVec3; 4] {
    [at, at + u, at + u + v, at + v]
}

#[test]
fn what_hides_a_lamp_from_the_middle_of_a_patch_alone_does_not_hide_it_from_the_patch() {
    const BLIND: f64 = 0.15;
    let square = |half: f64, z: f64, down: bool| {
        let (u, v) = if down { (DVec3::Y, DVec3::X) } else { (DVec3::X, DVec3::Y) };
        rectangle(dvec3(-half, -half, z), u * 2.0 * half, v * 2.0 * half)
    };
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    m.object("floor").polygon("paint", &square(0.5, 0.0, false));
    m.object("blind").polygon("paint", &square(BLIND, 1.0, true));
    m.object("lamp").polygon("glow", &square(0.05, 2.0, true));
    let made = assembled(&m.one_sided(), &settings(PatchTarget::AsGiven, Method::Lines, 192));
    let of = |z: f64| made.patches().iter().position(|p| (p.centre.z - z).abs() < 1e-9).expect("a patch");

    // Midpoints of the floor and of the lamp, and where the way between them passes the blind.
    let at = |k: i32, n: i32, half: f64| half * (f64::from(2 * k + 1) / f64::from(n) - 1.0);
    let mut sum = 0.0;
    for k in 0..40 * 40 {
        let (x, y) = (at(k % 40, 40, 0.5), at(k / 40, 40, 0.5));
        for q in 0..64 {
            let (s, t) = (at(q % 8, 8, 0.05), at(q / 8, 8, 0.05));
            let blocked = (0.5 * (x + s)).abs() < BLIND && (0.5 * (y + t)).abs() < BLIND;
            let square = (x - s).powi(2) + (y - t).powi(2) + 4.0;
            sum += if blocked { 0.0 } else { 4.0 / (std::f64::consts::PI * square * square) };
        }
    }
    let expected = sum / f64::from(40 * 40 * 64) * 0.01;
    close("from the floor to the lamp", made.transport.get(of(0.0), of(2.0)), expected, 0.1);
}

#[test]
fn two_single_patches_exchange_what_the_closed_forms_say() {
    const X: DVec3 = DVec3::X;
    const Y: DVec3 = DVec3::Y;
    const Z: DVec3 = DVec3::Z;
    let floor = rectangle(DVec3::ZERO, X, Y);
    let facing = |gap: f64| rectangle(Z * gap, Y, X);
    let pentagon =
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 2.0), (0.0, 1.0)].map(|(x, y)| dvec3(x, y, 0.0));
    let cases: [(&str, &[DVec3], &[DVec3], f64); 7] = [
        ("facing at 1", &floor, &facing(1.0), 0.199_824_895_698_387),
        ("facing at 0.5", &floor, &facing(0.5), 0.415_253_283_577_147),
        ("facing at 0.1", &floor, &facing(0.1), 0.826_994_522_397_257),
        ("perpendicular", &floor, &rectangle(DVec3::ZERO, Y, Z), 0.200_043_776_075_403),
        ("to a taller one", &floor, &rectangle(DVec3::ZERO, Y, 2.0 * Z), 0.232_852_602_795_362),
        (
            "short ones",
            &rectangle(DVec3::ZERO, 0.1 * X, Y),
            &rectangle(DVec3::ZERO, Y, 0.1 * Z),
            0.281_887_806_787_901,
        ),
        ("pentagon", &pentagon, &rectangle(DVec3::ZERO, Y, Z), 0.154_124_32),
    ];
    for (name, a, b, expected) in cases {
        for (method, resolution) in METHODS {
            let made = assembled(&pair(a, b), &settings(PatchTarget::AsGiven, method, resolution));
            assert_eq!(made.patches().len(), 2, "{name}");
            close(&format!("{name} by {}", method.name()), made.transport.get(0, 1), expected, 5e-3);
        }
    }
    // Far apart no closed form steps in, and the centre stands for the patch.
    for (method, resolution) in METHODS {
        let made =
            assembled(&pair(&floor, &facing(10.0)), &settings(PatchTarget::AsGiven, method, resolution));
        let tolerance = if method == Method::Lines { 5e-3 } else { 0.1 };
        close(method.name(), made.transport.get(0, 1), 0.003_162_056_838_757_60, tolerance);
    }
}

/// Unit squares a and b at z = 0 and 1 with a rectangle between them at z = 0.5.
fn blocked(low: [f64; 2], high: [f64; 2]) -> Arc<Scene> {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    m.object("a").quad("glow", DVec3::ZERO, DVec3::X, DVec3::Y);
    m.object("b").quad("paint", DVec3::Z, DVec3::Y, DVec3::X);
    let at = dvec3(low[0], low[1], 0.5);
    m.object("blocker").quad("paint", at, DVec3::X * (high[0] - low[0]), DVec3::Y * (high[1] - low[1]));
    let mut scene = Arc::unwrap_or_clone(m.one_sided());
    scene.materials.iter_mut().filter(|m| m.name == "paint").for_each(|m| m.sides = Sides::Both);
    Arc::new(scene)
}

#[test]
fn occluders_take_their_share() {
    for (name, scene, expected) in [
        ("square in the middle", blocked([0.25, 0.25], [0.75, 0.75]), 0.099_506_294_598_984_8),
        ("half-plane", blocked([0.5, -0.2], [1.2, 1.2]), 0.099_912_447_849_193_1),
    ] {
        for (method, resolution) in METHODS {
            let made = assembled(&scene, &settings(PatchTarget::Size(0.0834), method, resolution));
            let (a, b) = (made.of(|o| o == "a"), made.of(|o| o == "b"));
            // A centre point sees half a lamp or none where a shadow's edge crosses its patch.
            close(&format!("{name} by {}", method.name()), made.between(&a, &b), expected, 0.01);
        }
    }
}

#[test]
fn a_convex_body_in_an_enclosure_sees_the_enclosure_alone() {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, DVec3::splat(3.0), [paint, Some("glow"), paint, paint, paint, paint]);
    m.block("body", "paint", DVec3::splat(1.0), DVec3::splat(2.0));
    let scene = m.scene();
    for (method, resolution) in METHODS {
        let made = assembled(&scene, &settings(PatchTarget::Size(0.34), method, resolution));
        let (inner, outer) = (made.of(|o| o == "body"), made.of(|o| o != "body"));
        close("area of the body", made.area(&inner), 6.0, 1e-12);
        close("from inside out", made.between(&inner, &outer), 1.0, 1e-6);
        close("from outside in", made.between(&outer, &inner), 6.0 / 54.0, 1e-6);
        // The rows of the enclosure as sampled know nothing of those of the body.
        let sampled = rows(&made.prepared);
        let seen: f64 = outer
            .iter()
            .map(|&i| {
                let row = &sampled[i];
                made.patches()[i].area * inner.iter().map(|&j| row.get(j as u32)).sum::<f64>()
            })
            .sum();
        close(&format!("as sampled by {}", method.name()), seen / 54.0, 6.0 / 54.0, 0.01);
    }
}

/// Asserts what holds for any matrix of exchange areas, and that closed rows sum to one.
fn check_identities(name: &str, made: &Assembled, closed: bool) {
    let f = &made.transport;
    let mut unlit = 0.0;
    for i in 0..f.len() {
        for (j, s) in f.row(i) {
            let back = f.row(j as usize);
            let at = back
                .binary_search_by_key(&(i as u32), |entry| entry.0)
                .unwrap_or_else(|_| panic!("{name}: {j} does not see {i}"));
            assert_eq!(s.to_bits(), back[at].1.to_bits(), "{name}: S_{i},{j} is not S_{j},{i}");
            assert!(s >= 0.0 && s.is_finite(), "{name}: S_{i},{j} = {s}");
        }
        assert!(f.own(i) >= 0.0, "{name}");
        let sum = f.row_sum(i);
        assert!(sum <= 1.0 + 1e-12, "{name}: row {i} sends out {sum}");
        // What lies under a box sees nothing that is lit.
        let takes_part = sum > 0.0;
        unlit += if takes_part { 0.0 } else { f.area(i) };
        if closed && takes_part {
            assert!((sum - 1.0).abs() < 1e-6, "{name}: row {i} of a closed room sums to {sum}");
            assert!(f.own(i) < 1e-3 * f.area(i), "{name}: row {i} sees itself: {}", f.own(i) / f.area(i));
        }
    }
    let area: f64 = (0..f.len()).map(|i| f.area(i)).sum();
    assert!(unlit < 0.03 * area, "{name}: {unlit} of {area} m2 see nothing");
}

#[test]
fn rows_are_reciprocal_to_the_last_bit_and_close_closed_rooms() {
    for (method, resolution) in METHODS {
        let resolution = if method == Method::Rays { 1024 } else { resolution / 2 };
        for (name, scene, closed) in [
            ("hemicube", builtin("hemicube"), true),
            ("room", room_with_blocks(0.5).scene(), true),
            ("cornell", builtin("cornell"), false),
        ] {
            let made = assembled(&scene, &settings(PatchTarget::Count(500), method, resolution));
            check_identities(&format!("{name} by {}", method.name()), &made, closed);
        }
    }
}

#[test]
fn rows_as_sampled_sum_to_one_in_a_closed_room() {
    let scene = room_with_blocks(0.5).scene();
    for (method, resolution) in METHODS {
        let prepared =
            prepare(scene.clone(), &settings(PatchTarget::Count(800), method, resolution)).unwrap();
        // The hemicube loses cells whose centre falls on a seam.
        let tolerance = if method == Method::Hemicube { 1e-4 } else { 1e-5 };
        for (row, patch) in rows(&prepared).iter().zip(&prepared.mesh.patches) {
            let sum = row.sum();
            let (at, normal) = (patch.centre, patch.normal);
            let close = patch.buried || (sum - 1.0).abs() < tolerance;
            assert!(close, "{} sums to {sum} at {at} facing {normal}", method.name());
        }
    }
}

#[test]
fn what_leaves_an_open_box_is_its_opening() {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, DVec3::ONE, [Some("glow"), None, paint, paint, paint, paint]);
    let scene = m.one_sided();
    for (method, resolution) in METHODS {
        let made = assembled(&scene, &settings(PatchTarget::Size(0.126), method, resolution));
        check_identities("open box", &made, false);
        let escaping = |chosen: &[usize]| -> f64 {
            chosen.iter().map(|&i| made.patches()[i].area * (1.0 - made.transport.row_sum(i))).sum()
        };
        // The opening of 1 m² sees the box alone: by reciprocity that is what escapes.
        let name = method.name();
        close(name, escaping(&made.of(|_| true)), 1.0, 3e-3);
        close(name, escaping(&made.of(|o| o == "floor")), 0.199_824_895_698_387, 5e-3);
        close(name, escaping(&made.of(|o| o == "west")), 0.200_043_776_075_403, 0.01);
    }
}

#[test]
fn what_leaves_a_cap_is_its_opening() {
    for degrees in [60.0_f64, 90.0, 120.0] {
        let low = degrees.to_radians().cos();
        let mut m = Model::new();
        m.paint("glow", [0.8; 3], [1.0; 3]).sphere([low, 1.0], [10, 24], &|_| "glow");
        let made = assembled(&m.one_sided(), &settings(PatchTarget::AsGiven, Method::Lines, 192));
        check_identities("cap", &made, false);
        let all = made.of(|_| true);
        let sum: f64 = all.iter().map(|&i| made.patches()[i].area * made.transport.row_sum(i)).sum();
        // The opening is a flat polygon of 24 corners that sees the cap alone, whatever its facets.
        let opening = 12.0 * (1.0 - low * low) * (std::f64::consts::TAU / 24.0).sin();
        let area = made.area(&all);
        close(&format!("facets, {degrees} degrees"), sum / area, 1.0 - opening / area, 2e-3);
        // A round cap: (1 - cos t) / 2. The facets have some 1 % less area.
        close(&format!("round, {degrees} degrees"), sum / area, 0.5 * (1.0 - low), 0.015);
    }
}

/// Form factors from a free point to every patch, and the point where the method gathers them.
fn from_point(prepared: &Prepared, point: DVec3, normal: DVec3) -> Vec<f64> {
    let mut row = vec![0.0; prepared.mesh.patches.len()];
    prepared.computer.point(point, normal, &mut prepared.computer.scratch(), |j, f| row[j as usize] = f);
    row
}

#[test]
fn a_point_in_an_empty_room_sees_every_wall_as_lambert_says() {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [paint, Some("glow"), paint, paint, paint, paint]);
    let scene = m.scene();
    let choices = lumenwalk::effects::EffectChoices {
        with: vec![lumenwalk::effects::Effect::Visibility],
        without: vec![],
    };
    for (method, resolution, tolerance) in
        [(Method::Lines, 192, 1e-9), (Method::Hemicube, 256, 3e-3), (Method::Rays, 65536, 3e-3)]
    {
        let chosen = SolveSettings {
            effects: choices.clone(),
            ..settings(PatchTarget::Size(0.5), method, resolution)
        };
        let prepared = prepare(scene.clone(), &chosen).unwrap();
        for (point, normal) in [
            (dvec3(1.3, 0.0, 2.1), DVec3::Y),
            (dvec3(0.4, 1.7, 0.3), dvec3(1.0, 2.0, -1.5).normalize()),
            (dvec3(3.9, 2.8, 4.7), dvec3(-0.3, 0.1, -1.0).normalize()),
        ] {
            let row = from_point(&prepared, point, normal);
            let lifted = prepared.computer.lifted(point, normal);
            for (index, surface) in scene.surfaces.iter().enumerate() {
                let exact = closed_form::point_to_polygon(lifted, normal, &scene.polygon(surface));
                let patches = prepared.mesh.patches.iter().zip(&row);
                let sum: f64 = patches.filter(|(p, _)| p.surface == index as u32).map(|(_, f)| f).sum();
                assert!(
                    (sum - exact).abs() <= tolerance,
                    "{} from {point}: surface {index} {sum:.9}, not {exact:.9}",
                    method.name()
                );
            }
        }
    }
}

#[test]
fn points_under_edges_and_corners_get_what_their_neighbours_get() {
    let scene = room_with_blocks(0.5).scene();
    let prepared = prepare(scene, &settings(PatchTarget::Size(0.25), Method::Lines, 192)).unwrap();
    // The borders of lamp, cupboard, table and room, and something between them.
    let xs = [0.31, 0.7, 1.5, 1.6, 2.0, 2.2, 2.4, 3.4];
    let zs = [0.47, 0.9, 1.6, 2.1, 2.5, 2.9, 3.6, 4.4];
    let mut checked = 0;
    for y in [0.0, 0.6, 0.7, 1.8, 2.4] {
        for (x, z) in xs.iter().flat_map(|&x| zs.iter().map(move |&z| (x, z))) {
            let at = dvec3(x, y, z);
            // Not within the bodies.
            let within = |low: DVec3, high: DVec3| at.cmpge(low - 1e-9).all() && at.cmple(high + 1e-9).all();
            if within(dvec3(0.7, 0.0, 0.9), dvec3(1.5, 1.8, 1.6))
                || within(dvec3(2.2, 0.6, 2.5), dvec3(3.4, 0.7, 3.6))
            {
                continue;
            }
            for normal in [DVec3::Y, DVec3::X, -DVec3::Z, dvec3(1.0, 1.0, 0.0).normalize()] {
                if y == 0.0 && normal != DVec3::Y {
                    continue;
                }
                let light = |at: DVec3| -> f64 {
                    let row = from_point(&prepared, at, normal);
                    let patches = prepared.mesh.patches.iter().zip(row);
                    patches.map(|(p, f)| f * if p.luminaire.is_some() { 20.0 } else { 1.0 }).sum()
                };
                let (here, beside) = (light(at), light(at + dvec3(1.1e-6, 0.0, 0.7e-6)));
                close(&format!("at {at} facing {normal}"), here, beside, 1e-3);
                checked += 1;
            }
        }
    }
    assert!(checked > 800, "{checked} points");
}

#[test]
fn outlines_may_be_concave_or_have_holes() {
    // An L-shaped room 3 m high; its floor is one concave polygon, its ceiling has a hole for the lamp.
    let l = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 5.0), (0.0, 5.0)]
        .map(|(x, z)| dvec3(x, 0.0, z));
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let floor: Vec<DVec3> = l.iter().rev().copied().collect();
    m.object("floor").polygon("paint", &floor);
    for k in 0..6 {
        let (a, b) = (l[k], l[(k + 1) % 6]);
        m.object(&format!("wall_{k}")).quad("paint", a, b - a, 3.0 * DVec3::Y);
    }
    m.object("ceiling");
    ceiling_with_lamp(&mut m, "paint", [2.0, 3.0, 2.0], [0.5, 1.5, 0.5, 1.5]);
    m.quad("paint", dvec3(2.0, 3.0, 0.0), 2.0 * DVec3::X, 2.0 * DVec3::Z);
    m.quad("paint", dvec3(0.0, 3.0, 2.0), 2.0 * DVec3::X, 3.0 * DVec3::Z);
    let scene = m.scene();
    for (method, resolution, tolerance) in [(Method::Lines, 192, 2e-4), (Method::Hemicube, 256, 5e-3)] {
        let made = assembled(&scene, &settings(PatchTarget::Size(0.5), method, resolution));
        check_identities("L-shaped room", &made, true);
        let floor = made.of(|o| o == "floor");
        close("area of the floor", made.area(&floor), 14.0, 1e-12);
        // From a point in the inner corner all of the floor below and the ceiling above is seen.
        let point = dvec3(1.3, 1.2, 1.1);
        for (normal, height, hole) in [(DVec3::Y, 3.0, true), (-DVec3::Y, 0.0, false)] {
            let lifted = made.prepared.computer.lifted(point, normal);
            let part = |x0: f64, x1: f64, z0: f64, z1: f64| {
                let at = dvec3(x0, height, z0);
                let corners = rectangle(at, DVec3::X * (x1 - x0), DVec3::Z * (z1 - z0));
                closed_form::point_to_polygon(lifted, normal, &corners)
            };
            let whole = part(0.0, 2.0, 0.0, 5.0) + part(2.0, 4.0, 0.0, 2.0);
            let lamp = part(0.5, 1.5, 0.5, 1.5);
            let row = from_point(&made.prepared, point, normal);
            let sum = |emits: bool| -> f64 {
                let at_height =
                    made.patches().iter().zip(&row).filter(|(p, _)| (p.centre.y - height).abs() < 1e-9);
                at_height.filter(|(p, _)| p.luminaire.is_some() == emits).map(|(_, f)| f).sum()
            };
            let expected = if hole { whole - lamp } else { whole };
            // Hidden behind the inner corner: what the walls at x = 2 and z = 2 stand before.
            let hidden = expected - sum(false);
            let name = method.name();
            assert!(
                (0.0..0.05 * expected).contains(&(hidden + tolerance)),
                "{name}: {hidden} of {expected} is hidden"
            );
            if hole {
                assert!((sum(true) - lamp).abs() < tolerance, "{name}: lamp {} not {lamp}", sum(true));
            }
        }
    }
}

#[test]
fn boxes_may_run_through_each_other() {
    let mut m = room_with_blocks(0.5);
    m.block("through", "paint", dvec3(0.3, 0.4, 1.1), dvec3(2.9, 0.9, 1.4));
    let scene = m.scene();
    let prepared = |method, resolution| {
        prepare(scene.clone(), &settings(PatchTarget::Size(0.25), method, resolution)).unwrap()
    };
    let (by_lines, by_rays) = (prepared(Method::Lines, 768), prepared(Method::Rays, 1 << 18));
    for (point, normal) in [
        (dvec3(2.5, 0.0, 0.6), DVec3::Y),
        (dvec3(0.2, 0.0, 2.2), DVec3::Y),
        (dvec3(2.0, 2.0, 1.9), -DVec3::Z),
        (dvec3(0.9, 1.2, 0.2), DVec3::Z),
    ] {
        let (lines, rays) = (from_point(&by_lines, point, normal), from_point(&by_rays, point, normal));
        close("all that is seen", lines.iter().sum(), 1.0, 3e-3);
        let objects = |row: &[f64]| {
            let mut sums = vec![0.0; scene.objects.len()];
            for (p, f) in by_lines.mesh.patches.iter().zip(row) {
                sums[scene.surfaces[p.surface as usize].object as usize] += f;
            }
            sums
        };
        for (object, (l, r)) in scene.objects.iter().zip(objects(&lines).into_iter().zip(objects(&rays))) {
            assert!((l - r).abs() < 1e-3, "{object} from {point}: {l} by lines, {r} by rays");
        }
    }
}

#[test]
fn lines_win_over_the_hemicube_at_the_same_work() {
    // A room with two blocks and a small bright lamp; irradiance gathered by one row a point.
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [100.0; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [all, None, all, all, all, all]);
    ceiling_with_lamp(&mut m, "paint", [4.0, 3.0, 5.0], [1.85, 2.15, 2.3, 2.6]);
    m.block("cupboard", "paint", dvec3(0.7, 0.0, 0.9), dvec3(1.5, 1.8, 1.6));
    m.block("table", "paint", dvec3(2.2, 0.6, 2.5), dvec3(3.4, 0.7, 3.6));
    let scene = m.scene();
    let points: Vec<(DVec3, DVec3)> = (0..48)
        .map(|k| {
            let at = |d: f64| (0.5 + d * f64::from(k)).fract();
            (dvec3(0.1 + 3.8 * at(0.7549), 0.0, 0.1 + 4.8 * at(0.5698)), DVec3::Y)
        })
        // Not under the cupboard.
        .filter(|(p, _)| !((0.7..=1.5).contains(&p.x) && (0.9..=1.6).contains(&p.z)))
        .collect();
    let irradiance = |method, resolution| -> Vec<f64> {
        let prepared = prepare(scene.clone(), &settings(PatchTarget::Size(0.2), method, resolution)).unwrap();
        let emitted = |j: usize| match prepared.mesh.patches[j].normal.y {
            _ if prepared.mesh.patches[j].luminaire.is_some() => 100.0,
            y if y < -0.5 => 2.0,
            y if y > 0.5 => 1.0,
            _ => 0.2,
        };
        points
            .iter()
            .map(|&(x, n)| from_point(&prepared, x, n).iter().enumerate().map(|(j, f)| f * emitted(j)).sum())
            .collect()
    };
    let reference = irradiance(Method::Lines, 4096);
    let error = |of: &[f64]| -> f64 {
        let mean = reference.iter().sum::<f64>() / reference.len() as f64;
        let squares: f64 = of.iter().zip(&reference).map(|(a, b)| (a - b).powi(2)).sum();
        (squares / reference.len() as f64).sqrt() / mean
    };
    let rays = error(&irradiance(Method::Rays, 1 << 18));
    let lines = error(&irradiance(Method::Lines, 192));
    let hemicube = [64, 256].map(|n| error(&irradiance(Method::Hemicube, n)));
    println!(
        "rays 262144 {rays:.1e}, lines 192 {lines:.1e}, hemicube 64 and 256 {:.1e} {:.1e}",
        hemicube[0], hemicube[1]
    );
    assert!(rays < 5e-3, "an independent method confirms the reference: {rays}");
    assert!(lines < 1e-3, "{lines}");
    // A hemicube of 64 cells costs more than three times as much, one of 256 ten times.
    assert!(lines < 0.1 * hemicube[0], "{lines} against {}", hemicube[0]);
    assert!(lines < hemicube[1], "{lines} against {}", hemicube[1]);
    assert!(hemicube[1] < hemicube[0], "{hemicube:?}");
}

#[test]
fn more_receiving_points_see_more_of_a_shadow() {
    use ReceivingPoints::{Auto, Four, One, Sixteen};
    // Large patches on a floor with shadows, whose edges cross many of them.
    let scene = room_with_blocks(0.5).scene();
    let lamp_light = |method, resolution, points| -> Vec<[f64; 2]> {
        let how = SolveSettings { points, ..settings(PatchTarget::Size(0.4), method, resolution) };
        let prepared = prepare(scene.clone(), &how).unwrap();
        let (mesh, computer) = (&prepared.mesh, &prepared.computer);
        let floor = |i: &u32| {
            let patch = &mesh.patches[*i as usize];
            patch.normal.y > 0.9 && patch.centre.y < 1e-6 && !patch.buried
        };
        let floor: Vec<u32> = (0..mesh.patches.len() as u32).filter(floor).collect();
        floor
            .into_par_iter()
            .map_init(
                || computer.scratch(),
                |scratch, i| {
                    let row = computer.row(i, scratch);
                    let lamps = row.patches.iter().zip(&row.values);
                    let lamps = lamps.filter(|(j, _)| mesh.patches[**j as usize].luminaire.is_some());
                    [mesh.patches[i as usize].area, lamps.map(|(_, &f)| f64::from(f)).sum()]
                },
            )
            .collect()
    };
    let reference = lamp_light(Method::Rays, 1 << 17, Sixteen);
    let mean = |of: &dyn Fn(usize, &[f64; 2]) -> f64| {
        let area: f64 = reference.iter().map(|r| r[0]).sum();
        reference.iter().enumerate().map(|(k, r)| r[0] * of(k, r)).sum::<f64>() / area
    };
    let whole = mean(&|_, r| r[1]);
    let error = |method, resolution, points| {
        let found = lamp_light(method, resolution, points);
        mean(&|k, r| (found[k][1] - r[1]).powi(2)).sqrt() / whole
    };
    let lines = |points| error(Method::Lines, 192, points);
    let (one, auto, four, sixteen) = (lines(One), lines(Auto), lines(Four), lines(Sixteen));
    let aligned = [One, Sixteen].map(|points| error(Method::AlignedHemicube, 128, points));
    println!("{one:.4} {auto:.4} {four:.4} {sixteen:.4}, hemicube {aligned:.4?}");
    assert!(sixteen < 0.01, "an independent method agrees: {sixteen}");
    assert!(one > 0.03, "a centre alone takes a patch as lit or dark: {one}");
    assert!(four < 0.5 * one && sixteen < 0.5 * four, "{one} {four} {sixteen}");
    assert!(auto < 1.01 * one, "the shadows of lamps are left to the elements: {auto} against {one}");
    assert!(aligned[1] < 0.5 * aligned[0], "whatever the method: {aligned:?}");
}
