//! Lamps that stand close to what they light: patches beside them are smaller than elsewhere.

use crate::common::{Model, assembled, builtin, close, lines};
use crate::geometry::room;
use crate::laws::{Kind, hold_model};
use glam::{DVec3, dvec3};
use lumenwalk::form_factors::closed_form::point_to_polygon;
use lumenwalk::mesh::{Backs, MeshSettings, NO_PATCH, PatchMesh, PatchTarget, Side, build};
use lumenwalk::scene::Scene;
use std::collections::HashMap;

/// A wall of 4 x 4 m, and a square of 0.1 m that shines on its middle from this distance, or away from it.
fn lamp_before_a_wall(distance: f64, towards: bool, exitance: f64) -> Scene {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [exitance; 3]);
    m.object("wall").quad("paint", DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0);
    let (u, v) = if towards { (DVec3::Y, DVec3::X) } else { (DVec3::X, DVec3::Y) };
    m.object("lamp").quad("glow", dvec3(1.95, 1.95, distance), u * 0.1, v * 0.1);
    m.read_one_sided().expect("a scene without faults")
}

fn meshed(scene: &Scene, target: PatchTarget) -> PatchMesh {
    build(scene, &MeshSettings { target, backs: Backs::None, ..MeshSettings::default() }).expect("meshed")
}

/// Irradiance on the wall for an exitance of one: the form factor of the lamp (Lambert).
fn irradiance(at: DVec3, distance: f64) -> f64 {
    let corner = |x: f64, y: f64| dvec3(1.95 + x, 1.95 + y, distance);
    let lamp = [corner(0.0, 0.0), corner(0.0, 0.1), corner(0.1, 0.1), corner(0.1, 0.0)];
    point_to_polygon(at, DVec3::Z, &lamp)
}

/// Integral over a rectangle of the squared difference to the value in its middle, by 8 x 8 points.
fn squares(low: DVec3, extent: DVec3, distance: f64) -> f64 {
    let middle = irradiance(low + 0.5 * extent, distance);
    let mut sum = 0.0;
    for k in 0..64 {
        let share = dvec3(f64::from(k % 8) + 0.5, f64::from(k / 8) + 0.5, 0.0) / 8.0;
        sum += (irradiance(low + extent * share, distance) - middle).powi(2);
    }
    sum / 64.0 * extent.x * extent.y
}

#[test]
fn a_bright_spot_is_resolved_at_the_same_number_of_patches() {
    let distance = 0.06;
    let mesh = meshed(&lamp_before_a_wall(distance, true, 20.0), PatchTarget::Count(1200));
    let wall: Vec<_> = mesh.patches.iter().filter(|p| p.luminaire.is_none()).collect();
    let count = wall.len() as f64;
    assert!((1000.0..1400.0).contains(&count), "{count} patches");
    let graded: f64 = wall
        .iter()
        .map(|patch| {
            let corners = || mesh.pieces_of(patch).flat_map(|piece| mesh.polygon(piece, Side::Front));
            let (low, high) =
                corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), c| (l.min(c), h.max(c)));
            squares(low, high - low, distance)
        })
        .sum();
    let along = count.sqrt().ceil() as u32;
    let edge = dvec3(4.0, 4.0, 0.0) / f64::from(along);
    let uniform: f64 = (0..along * along)
        .map(|k| squares(edge * dvec3(f64::from(k % along), f64::from(k / along), 0.0), edge, distance))
        .sum();
    let ratio = (graded / uniform).sqrt();
    assert!(ratio < 0.25, "{ratio} of the error of {along} x {along} equal patches");
}

#[test]
fn nothing_is_halved_where_no_light_falls() {
    let plain = (4.0_f64 / 0.2).powi(2) as usize + 1;
    for (name, scene) in [
        ("turned away", lamp_before_a_wall(0.06, false, 20.0)),
        ("without output", lamp_before_a_wall(0.06, true, 0.0)),
        ("far away", lamp_before_a_wall(3.0, true, 20.0)),
    ] {
        let mesh = meshed(&scene, PatchTarget::Size(0.2));
        assert_eq!(mesh.patches.len(), plain, "{name}");
    }
    let near = meshed(&lamp_before_a_wall(0.06, true, 20.0), PatchTarget::Size(0.2)).patches.len();
    assert!(near > plain + 50, "{near} patches");
}

#[test]
fn halving_depends_on_shares_and_not_on_units() {
    let once = meshed(&lamp_before_a_wall(0.06, true, 20.0), PatchTarget::Size(0.2));
    let brighter = meshed(&lamp_before_a_wall(0.06, true, 2e4), PatchTarget::Size(0.2));
    assert_eq!(once.patches.len(), brighter.patches.len());
}

#[test]
fn halved_cells_cover_their_region_and_share_their_corners() {
    let gallery =
        check_halved_cells("gallery", &build(&builtin("gallery"), &MeshSettings::default()).expect("meshed"));
    let wall =
        check_halved_cells("wall", &meshed(&lamp_before_a_wall(0.06, true, 20.0), PatchTarget::Size(0.2)));
    assert!(gallery > 1 && wall == 1, "{gallery} and {wall} regions with halved cells");
}

/// Checks those regions that nothing stands on; how many of them have halved cells.
fn check_halved_cells(name: &str, mesh: &PatchMesh) -> usize {
    let mut halved = 0;
    for (index, region) in mesh.regions.iter().enumerate() {
        let pieces = &mesh.pieces[region.pieces.start as usize..region.pieces.end as usize];
        let area: f64 = pieces.iter().map(|piece| piece.area).sum();
        assert!((area / region.area - 1.0).abs() < 1e-9, "{name}, region {index}: {area} of {}", region.area);
        if !mesh.contacts[index].is_empty() || pieces.len() < 40 {
            continue;
        }
        let smallest = pieces.iter().map(|piece| piece.area).fold(f64::INFINITY, f64::min);
        let full = region.cell_size.x * region.cell_size.y;
        halved += usize::from(smallest < 0.1 * full);
        // An edge is shared by two pieces, or it lies on the rim.
        let mut open: HashMap<(u32, u32), f64> = HashMap::new();
        for piece in pieces {
            let corners = mesh.corners_of(piece);
            for (k, a) in corners.iter().enumerate() {
                let b = &corners[(k + 1) % corners.len()];
                if open.remove(&(b.vertex, a.vertex)).is_none() {
                    open.insert((a.vertex, b.vertex), a.plane.distance(b.plane));
                }
            }
        }
        let rim: f64 = region.edges.iter().map(|[a, b]| a.distance(*b)).sum();
        let left: f64 = open.values().sum();
        assert!(
            (left / rim - 1.0).abs() < 1e-6,
            "{name}, region {index}: {left} m of edges alone, {rim} m of rim"
        );
    }
    halved
}

#[test]
fn the_number_of_patches_asked_for_holds_with_lamps_close_by() {
    let scene = builtin("gallery");
    for count in [4000, 8000] {
        let settings = MeshSettings { target: PatchTarget::Count(count), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).expect("meshed");
        // Faces no larger than a patch come on top.
        let (made, whole) = (mesh.patches.len(), mesh.statistics.whole_sides);
        let ratio = (made - whole) as f64 / count as f64;
        assert!((0.8..1.25).contains(&ratio), "{made} patches, {whole} of them whole, for {count}");
    }
}

#[test]
fn places_on_halved_meshes_are_found() {
    let scene = lamp_before_a_wall(0.06, true, 20.0);
    let (coarse, fine) = (meshed(&scene, PatchTarget::Size(0.5)), meshed(&scene, PatchTarget::Size(0.15)));
    for (from, to) in [(&fine, &coarse), (&coarse, &fine)] {
        for (patch, place) in from.patches.iter().zip(from.places_on(to).expect("one scene")) {
            assert_ne!(place, NO_PATCH);
            let there = &to.patches[place as usize];
            let apart = patch.centre.distance(there.centre);
            assert!(apart <= there.radius * (1.0 + 1e-9), "{apart} m in a patch of {} m", there.radius);
        }
    }
}

#[test]
fn the_laws_hold_with_a_lamp_a_hand_from_the_wall() {
    let mut m = room();
    m.block("sconce", "glow", dvec3(1.9, 1.4, 0.05), dvec3(2.0, 1.5, 0.15));
    hold_model("a sconce", &m, Kind::Closed);
    let settings = lines(PatchTarget::Size(0.2));
    let made = assembled(&m.scene(), &settings);
    let small = made.patches().iter().filter(|p| p.luminaire.is_none() && p.area < 0.01).count();
    assert!(small > 30, "{small} small patches beside the lamp");
}

#[test]
fn the_neck_of_a_table_lamp_gets_the_light_of_the_shade_around_it() {
    // A shade of one patch above a post, whose side sees half of it. The middle of the shade sees next to nothing
    // but the top of the post.
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [100.0; 3]);
    m.room(DVec3::ZERO, DVec3::splat(3.0), [Some("paint"); 6]);
    m.object("lamp").quad("glow", dvec3(1.37, 1.37, 0.5), DVec3::Y * 0.26, DVec3::X * 0.26);
    m.block("post", "paint", dvec3(1.485, 1.485, 0.1), dvec3(1.515, 1.515, 0.49));
    let made = assembled(&m.scene(), &lines(PatchTarget::Size(0.3)));
    let mesh = &made.prepared.mesh;
    let lamps: Vec<usize> =
        (0..mesh.patches.len()).filter(|&i| mesh.patches[i].luminaire.is_some()).collect();
    assert_eq!(lamps.len(), 1);
    let shade = [(1.37, 1.37), (1.37, 1.63), (1.63, 1.63), (1.63, 1.37)].map(|(x, y)| dvec3(x, y, 0.5));
    let (mut found, mut expected) = (0.0, 0.0);
    for (i, patch) in mesh.patches.iter().enumerate() {
        let on_side =
            (patch.centre - dvec3(1.5, 1.5, patch.centre.z)).length() < 0.03 && patch.normal.z.abs() < 0.1;
        if on_side && patch.centre.z > 0.4 {
            found += made.transport.get(i, lamps[0]);
            expected += point_to_polygon(patch.centre, patch.normal, &shade);
        }
    }
    assert!(expected > 1.0);
    close("form factors of the post to the shade", found, expected, 0.05);
}
