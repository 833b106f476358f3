//! Vertex radiosity and picking on a hand-made room.

mod render_room;

use glam::DVec3;
use lumenwalk::display::{DisplayMesh, Shading};
use lumenwalk::geometry::Ray;
use lumenwalk::mesh::{self, MeshSettings, NO_PATCH, PatchMesh, PatchTarget, Side, build};
use lumenwalk::navigation::Camera;
use lumenwalk::render::Picker;
use lumenwalk::scene::{Scene, from_text};
use lumenwalk::solve::{Control, SolveSettings, solve};
use render_room::{Room, WHITE, camera, light};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// World positions and values of the lit corners for a field over patch centres.
fn corner_field(
    mesh: &PatchMesh,
    display: &DisplayMesh,
    field: impl Fn(u32) -> f32,
    shading: Shading,
) -> Vec<(DVec3, u32, f32)> {
    let values: Vec<f32> = (0..mesh.patches.len() as u32).map(field).collect();
    let corners = display.corner_scalars(&values, shading);
    assert_eq!(corners.len(), display.lit_corners);
    display
        .corners
        .iter()
        .zip(corners)
        .map(|(c, value)| (display.origin + c.position.as_dvec3(), c.patch, value))
        .collect()
}

#[test]
fn a_linear_field_is_met_at_every_vertex_of_an_empty_room() {
    let mut room = Room::empty();
    room.cuboid(0, [WHITE; 6], DVec3::ZERO, DVec3::new(4.0, 3.0, 5.0), true);
    let (scene, mesh) = room.finish(0.5);
    let display = DisplayMesh::build(&mesh, &scene, true);
    let linear = |p: DVec3| 20.0 + 2.0 * p.x - 1.5 * p.y + p.z;
    let field = |patch: u32| linear(mesh.patches[patch as usize].centre) as f32;
    for (position, _, value) in corner_field(&mesh, &display, field, Shading::Gouraud) {
        let expected = linear(position);
        assert!((f64::from(value) - expected).abs() < 5e-3, "{value} at {position}, expected {expected}");
    }
    for (_, patch, value) in corner_field(&mesh, &display, field, Shading::Flat) {
        assert_eq!(value, field(patch));
    }
}

#[test]
fn nothing_is_averaged_across_a_crease() {
    let mut room = Room::empty();
    room.cuboid(0, [WHITE; 6], DVec3::ZERO, DVec3::new(4.0, 3.0, 5.0), true);
    let (scene, mesh) = room.finish(0.5);
    let display = DisplayMesh::build(&mesh, &scene, true);
    let by_wall = |patch: u32| 1.0 + mesh.patches[patch as usize].region as f32;
    for (_, patch, value) in corner_field(&mesh, &display, by_wall, Shading::Gouraud) {
        assert!((value - by_wall(patch)).abs() < 1e-5, "{value} and {}", by_wall(patch));
    }
}

#[test]
fn the_floor_under_a_box_does_not_shine_through_around_it() {
    let mut room = Room::empty();
    room.cuboid(0, [WHITE; 6], DVec3::ZERO, DVec3::new(4.0, 3.0, 5.0), true);
    room.cuboid(1, [WHITE; 6], DVec3::new(1.3, 0.0, 1.7), DVec3::new(2.4, 0.8, 2.6), false);
    let (scene, mesh) = room.finish(0.4);
    let display = DisplayMesh::build(&mesh, &scene, true);
    let is_under = |p: DVec3| p.y < 1e-6 && p.x > 1.3 && p.x < 2.4 && p.z > 1.7 && p.z < 2.6;
    let lit = |patch: u32| if is_under(mesh.patches[patch as usize].centre) { 0.0 } else { 1.0 };
    let dark = (0..mesh.patches.len() as u32).filter(|&p| lit(p) == 0.0).count();
    assert!(dark >= 4, "the mesh must have patches under the box: {dark}");
    for (position, patch, value) in corner_field(&mesh, &display, lit, Shading::Gouraud) {
        assert!((value - lit(patch)).abs() < 1e-5, "{value} at {position} beside {}", lit(patch));
    }
}

#[test]
fn smooth_normals_join_the_facets_of_a_column() {
    let (scene, mesh) = Room::furnished().finish(0.3);
    let is_column = |patch: u32| mesh.regions[mesh.patches[patch as usize].region as usize].object == 2;
    // Alternating facets: joined vertices take the mean, separate ones do not.
    let field = |patch: u32| (mesh.patches[patch as usize].region % 2) as f32;
    for (smooth, expected) in [(true, true), (false, false)] {
        let display = DisplayMesh::build(&mesh, &scene, smooth);
        let corners = corner_field(&mesh, &display, field, Shading::Gouraud);
        let on_column: Vec<f32> = corners.iter().filter(|c| is_column(c.1)).map(|c| c.2).collect();
        assert!(on_column.len() > 100);
        let joined = on_column.iter().all(|v| (v - 0.5).abs() < 0.05);
        assert_eq!(joined, expected, "smooth: {smooth}, {:?}", &on_column[..8]);
    }
}

#[test]
fn values_are_never_negative_or_nan() {
    let (scene, mesh) = Room::furnished().finish(0.3);
    let display = DisplayMesh::build(&mesh, &scene, true);
    let spiky: Vec<[f32; 3]> = (0..mesh.patches.len())
        .map(|i| match i % 5 {
            0 => [1e4, 0.0, f32::NAN],
            1 => [f32::INFINITY, 1.0, 0.0],
            _ => [0.01, 100.0, 3.0],
        })
        .collect();
    for values in [
        display.vertex_radiosity(&spiky),
        display.corner_radiosity(&spiky, &spiky, Shading::Gouraud),
        display.corner_radiosity(&spiky, &spiky, Shading::Flat),
        display.vertex_radiosity(&[]),
    ] {
        assert!(values.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    }
}

#[test]
fn a_textured_wall_gets_what_a_texel_is_multiplied_with() {
    let (scene, mesh) = Room::furnished().finish(0.5);
    let display = DisplayMesh::build(&mesh, &scene, true);
    let (irradiance, mut radiosity) = light(&mesh);
    let is_picture = |patch: u32| mesh.patches[patch as usize].material == render_room::PICTURE;
    let check = |radiosity: &[[f32; 3]], factor: f32| {
        let values = display.corner_radiosity(radiosity, &irradiance, Shading::Flat);
        let mut count = 0;
        for (corner, value) in display.corners.iter().zip(&values).filter(|(c, _)| is_picture(c.patch)) {
            for band in 0..3 {
                let expected = factor * irradiance[corner.patch as usize][band];
                assert!((value[band] - expected).abs() < 1e-4 * expected, "{} {expected}", value[band]);
            }
            count += 1;
        }
        assert!(count > 50);
    };
    check(&radiosity, 0.8);
    // An edited factor reaches the picture through the radiosity.
    for (patch, b) in radiosity.iter_mut().enumerate() {
        if is_picture(patch as u32) {
            *b = b.map(|x| 0.5 * x);
        }
    }
    check(&radiosity, 0.4);
    assert!(display.batches.iter().any(|b| b.texture == Some(0) && !b.indices.is_empty()));
}

#[test]
fn lit_triangles_face_their_side_and_cover_the_patches() {
    let (scene, mesh) = Room::furnished().finish(0.5);
    let display = DisplayMesh::build(&mesh, &scene, true);
    let mut area = vec![0.0; mesh.patches.len()];
    for batch in &display.batches {
        let range = batch.indices.start as usize..batch.indices.end as usize;
        for triangle in display.indices[range].chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| display.corners[triangle[k] as usize]);
            let normal = 0.5 * (b.position - a.position).cross(c.position - a.position);
            let patch = &mesh.patches[a.patch as usize];
            assert!(a.patch == b.patch && b.patch == c.patch);
            assert!(normal.as_dvec3().dot(patch.normal) >= -1e-9);
            area[a.patch as usize] += f64::from(normal.length());
        }
    }
    for (drawn, patch) in area.iter().zip(&mesh.patches) {
        assert!((drawn - patch.area).abs() < 1e-4 * patch.area, "{drawn} of {}", patch.area);
    }
    // The outsides of the room are kept apart.
    assert!(!display.unlit.is_empty());
    assert!(display.corners[display.lit_corners..].iter().all(|c| c.patch == NO_PATCH));
}

#[test]
fn borders_are_those_of_patches_not_of_triangles() {
    let mut room = Room::empty();
    room.cuboid(0, [WHITE; 6], DVec3::ZERO, DVec3::splat(1.0), true);
    let (scene, mesh) = room.finish(0.25);
    let display = DisplayMesh::build(&mesh, &scene, true);
    // Each wall is a grid of 4 x 4: 2 * 4 * 5 borders on each side, as without a lamp both are kept.
    assert_eq!(display.edges.len(), 2 * 6 * 40);
}

#[test]
fn picking_sees_through_walls_from_outside_but_walking_does_not() {
    let (_, mesh) = Room::furnished().finish(0.5);
    let picker = Picker::new(&mesh);
    let ray = Ray { origin: DVec3::new(2.0, 1.5, 9.0), direction: DVec3::NEG_Z };
    let seen = picker.pick(&ray).expect("the far wall");
    assert!((seen.distance - 9.0).abs() < 1e-9 && seen.position.z.abs() < 1e-9, "{seen:?}");
    assert_eq!(mesh.patches[seen.patch.expect("lit") as usize].material, render_room::PICTURE);
    assert!(seen.normal.distance(DVec3::Z) < 1e-12);
    let met = picker.nearest(&ray, f64::INFINITY).expect("the near wall");
    assert!((met.distance - 4.0).abs() < 1e-9 && met.patch.is_none());
    assert_eq!(picker.nearest(&ray, 3.9), None);
    let away = Ray { direction: DVec3::Z, ..ray };
    assert_eq!(picker.pick(&away), None);
}

#[test]
fn coincident_walls_back_to_back_hide_nothing() {
    // Two rooms that share a plane, each with a wall of its own there.
    let mut rooms = Room::empty();
    rooms.cuboid(0, [WHITE; 6], DVec3::ZERO, DVec3::splat(2.0), true);
    rooms.cuboid(1, [WHITE; 6], DVec3::new(2.0, 0.0, 0.0), DVec3::new(4.0, 2.0, 2.0), true);
    let (_, mesh) = rooms.finish(0.5);
    let picker = Picker::new(&mesh);
    for (x, towards) in [(1.0, DVec3::X), (3.0, DVec3::NEG_X)] {
        for step in 1..20 {
            let origin = DVec3::new(x, 0.1 * f64::from(step), 0.7);
            let pick = picker.pick(&Ray { origin, direction: towards }).expect("the wall between");
            assert!((pick.distance - 1.0).abs() < 1e-9, "{pick:?}");
        }
    }
}

#[test]
fn a_view_is_metered_by_what_it_sees() {
    let (scene, mesh) = Room::furnished().finish(0.5);
    let picker = Picker::new(&mesh);
    let seen = picker.seen_patches(&camera(&scene), [640, 400], [24, 15]);
    assert_eq!(seen.len(), 24 * 15, "inside a closed room every ray meets something");
    let up = Camera { forward: DVec3::Y, up: DVec3::Z, ..camera(&scene) };
    let ceiling = picker.seen_patches(&up, [64, 64], [8, 8]);
    assert!(ceiling.iter().any(|&p| mesh.patches[p as usize].normal == DVec3::NEG_Y));
    assert!(seen.iter().all(|&p| mesh.patches[p as usize].side == Side::Front));
}

/// A ball of triangles over latitudes and longitudes, radius 0.5, with normals, so high over a floor.
fn ball_of_triangles(height: f64, around: usize, rows: usize) -> Arc<Scene> {
    use std::f64::consts::{PI, TAU};
    use std::fmt::Write as _;
    let mut obj = "mtllib ball.mtl\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\no floor\nf 1 2 3 4\n\
                   v -1 3 1\nv -1 3 -1\nv 1 3 -1\nv 1 3 1\no lamp\nusemtl glow\nf 5 6 7 8\no ball\nusemtl white\n"
        .to_owned();
    for row in 0..=rows {
        for k in 0..around {
            let (polar, turn) = (PI * row as f64 / rows as f64, TAU * k as f64 / around as f64);
            let n = [polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()];
            let [x, y, z] = n;
            writeln!(
                obj,
                "v {:.4} {:.4} {:.4}\nvn {x:.4} {y:.4} {z:.4}",
                0.5 * x,
                height + 0.5 + 0.5 * y,
                0.5 * z
            )
            .unwrap();
        }
    }
    for row in 0..rows {
        for k in 0..around {
            let at = |row: usize, k: usize| {
                let index = row * around + k % around + 1;
                format!("{}//{index}", index + 8)
            };
            let [a, b, c, d] = [at(row, k), at(row, k + 1), at(row + 1, k + 1), at(row + 1, k)];
            if row > 0 {
                writeln!(obj, "f {a} {b} {c}").unwrap();
            }
            if row + 1 < rows {
                writeln!(obj, "f {a} {c} {d}").unwrap();
            }
        }
    }
    Arc::new(
        from_text("ball", &obj, "newmtl glow\nKe 5 5 5\nnewmtl white\nKd 0.7 0.7 0.7\n", None)
            .expect("a scene"),
    )
}

#[test]
fn a_ball_of_triangles_is_one_smooth_surface() {
    // An odd number of rows: those in the middle have two triangles in one plane.
    let scene = ball_of_triangles(0.5, 16, 9);
    let mesh =
        build(&scene, &MeshSettings { target: PatchTarget::Size(0.1), ..MeshSettings::default() }).unwrap();
    let stretches = mesh::stretches(&mesh);
    let mut corners = 0;
    for piece in mesh.pieces.iter().filter(|p| mesh.regions[p.region as usize].object == 2) {
        for k in piece.corners.clone() {
            let corner = &mesh.corners[k as usize];
            let radial = (mesh.vertices[corner.vertex as usize] - DVec3::Y).normalize();
            assert!(corner.normal.dot(radial) > 0.995, "{} at {radial}", corner.normal);
            let stretch = stretches.get(k as usize).copied().unwrap_or(0);
            assert_eq!(
                stretch, 0,
                "edges that facets share are no lines where something stands, at {radial}"
            );
            corners += 1;
        }
    }
    assert!(corners > 500, "{corners}");
}

#[test]
fn a_ball_a_hair_above_the_floor_is_in_the_light_all_around() {
    // Facets below it see little of any light. Where they are taken for dark, the floor is lit through them.
    let scene = ball_of_triangles(0.02, 40, 20);
    let mesh = build(&scene, &MeshSettings::default()).unwrap();
    let ball = || mesh.regions.iter().filter(|region| region.object == 2);
    let dark = |side: Side| ball().filter(|region| region.dark_as_whole[side as usize]).count();
    assert!(ball().count() > 700);
    assert_eq!([dark(Side::Front), dark(Side::Back)], [0, ball().count()], "lit outside, dark inside");
}

#[test]
fn faces_of_one_plane_keep_their_own_parts_of_an_image() {
    // Colours of corners lie in an image with a tile for each face: every edge between faces is a seam of it.
    let mut text = String::from("mtllib m.mtl\n");
    for k in 0..25 {
        let (x, y) = (f64::from(k % 5), f64::from(k / 5));
        text += &format!("v {x} {y} 0 {} 0.5 {}\n", 0.2 + 0.15 * x, 0.2 + 0.15 * y);
    }
    for k in (0..20).filter(|k| k % 5 < 4) {
        let [a, b, c, d] = [k + 1, k + 2, k + 7, k + 6];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text += "v 1 1 2\nv 2 1 2\nv 2 2 2\nv 1 2 2\nusemtl light\nf 29 28 27 26\n";
    let scene = from_text("wall", &text, "newmtl light\nKd 0 0 0\nKe 9 9 9\n", None).unwrap();
    let settings = SolveSettings { patches: PatchTarget::Count(30), ..SolveSettings::default() };
    let solved =
        solve(Arc::new(scene), &settings, &AtomicBool::new(false), &mut |_| Control::Continue).unwrap();
    let elements = solved.element_light.as_ref().map(|light| &light.elements);
    let display = DisplayMesh::build_on(&solved.mesh, &solved.scene, true, elements);
    let code = |x: f64| ((x + 0.055) / 1.055).powf(2.4);
    let mut looked_at = 0;
    for triangle in display.indices[..display.unlit.start as usize].as_chunks::<3>().0 {
        let corners = triangle.map(|index| display.corners[index as usize]);
        let material = solved.mesh.patches[corners[0].patch as usize].material;
        let Some(texture) = solved.scene.materials[material as usize].texture else { continue };
        let third = |pick: &dyn Fn(usize) -> DVec3| (pick(0) + pick(1) + pick(2)) / 3.0;
        let place = display.origin + third(&|k| corners[k].position.as_dvec3());
        let uv = third(&|k| corners[k].uv.extend(0.0).as_dvec3());
        let found = solved.scene.textures[texture as usize].sample(uv.truncate());
        let wanted = [code(0.2 + 0.15 * place.x), code(0.5), code(0.2 + 0.15 * place.y)];
        // Between corners a face is linear in light and the codes are not.
        let is_close = (0..3).all(|band| (f64::from(found[band]) - wanted[band]).abs() < 0.03);
        assert!(is_close, "{found:?} at {place}, expected {wanted:?}");
        looked_at += 1;
    }
    assert!(looked_at >= 32, "{looked_at} triangles of the wall");
}
