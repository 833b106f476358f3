//! Rooms full of small faces: they take no patches from the walls, so that shadows stay where they fall.

use crate::common::{Model, builtin, lines, solved};
use glam::{DVec3, dvec3};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::solve::{Solution, SolveSettings};

/// A room with a table under its lamp, and bricks in a corner that have more faces than patches are
/// asked for.
fn furnished(bricks: u32) -> Solution {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(5.0, 2.8, 4.0), [all, None, all, all, all, all]);
    m.object("ceiling").ceiling_with_lamp("paint", [5.0, 2.8, 4.0], [2.2, 2.8, 1.7, 2.3]);
    m.block("table", "paint", dvec3(1.8, 0.70, 1.5), dvec3(3.2, 0.74, 2.5));
    for brick in 0..bricks {
        let low = dvec3(0.1 + 0.1 * f64::from(brick % 15), 0.0, 0.1 + 0.1 * f64::from(brick / 15));
        m.block(&format!("brick{brick}"), "paint", low + DVec3::Y * 0.02, low + dvec3(0.05, 0.07, 0.05));
    }
    solved(&m.scene(), &SolveSettings { resolution: Some(48), ..lines(PatchTarget::Count(500)) })
}

/// Irradiance of the floor patch that holds a place, over that of the one in the open at the same height.
fn on_floor(solved: &Solution, x: f64, z: f64) -> f64 {
    let light = solved.light(&solved.scene.lighting());
    let is_floor = |i: &usize| {
        let patch = &solved.mesh.patches[*i];
        patch.normal.y > 0.9 && patch.centre.y.abs() < 1e-6
    };
    let off = |i: &usize| solved.mesh.patches[*i].centre.distance(dvec3(x, 0.0, z));
    let nearest = (0..solved.mesh.patches.len()).filter(is_floor).min_by(|a, b| off(a).total_cmp(&off(b)));
    f64::from(light.irradiance[nearest.expect("a floor")][1])
}

#[test]
fn a_shadow_under_a_table_stays_in_a_room_full_of_small_faces() {
    let (bare, full) = (furnished(0), furnished(220));
    let whole = full.mesh.statistics.whole_sides;
    assert!(whole > 1000, "more small faces than patches are asked for: {whole}");
    for (what, room) in [("bare", &bare), ("full", &full)] {
        let (under, beside) = (on_floor(room, 2.5, 2.0), on_floor(room, 4.2, 2.0));
        assert!(under < 0.4 * beside, "{what}: {under} W/m² under the table, {beside} beside it");
    }
    let change = on_floor(&full, 2.5, 2.0) / on_floor(&bare, 2.5, 2.0);
    assert!((0.7..1.3).contains(&change), "the same shadow as without them: {change}");
}

#[test]
fn scenes_without_small_faces_are_cut_as_ever() {
    // The number asked for is met where no face is smaller than a patch.
    for (name, count) in [("hemicube", 2855), ("cornell", 3061)] {
        let settings = SolveSettings { resolution: Some(4), ..lines(PatchTarget::Count(3000)) };
        let patches = solved(&builtin(name), &settings).mesh.patches.len();
        assert_eq!(patches, count, "{name}");
    }
}
