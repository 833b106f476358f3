//! Faces that are written once per side, and surfaces that lie back to back: each rules its own side. What
//! is right follows from the same rooms as models of their own.

mod common;

use common::{METHODS, close, mean, rows, settings, solved};
use glam::DVec3;
use lumenwalk::mesh::{Patch, PatchTarget};
use lumenwalk::outputs::save_repaired;
use lumenwalk::scene::{FindingKind, Scene, SceneSource, Severity, check, from_text, illuminance, load};
use lumenwalk::solve::{Solution, SolveSettings, prepare};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

const MTL: &str = "newmtl white\nKd 0.7 0.7 0.7\nnewmtl red\nKd 0.8 0.1 0.1\nnewmtl blue\nKd 0.1 0.2 0.6\n\
    newmtl grey\nKd 0.4 0.4 0.4\nnewmtl lamp\nKd 0 0 0\nKe 20 20 20\nnewmtl glow\nKd 0.2 0.2 0.2\nKe 1 2 5\n";

/// A model as it is written, face by face.
#[derive(Clone, Default)]
struct Text {
    obj: String,
    corners: usize,
}

impl Text {
    /// A face with corners of its own.
    fn face(mut self, object: &str, material: &str, corners: &[[f64; 3]]) -> Self {
        let _ = writeln!(self.obj, "o {object}\nusemtl {material}");
        corners.iter().for_each(|[x, y, z]| _ = writeln!(self.obj, "v {x} {y} {z}"));
        let numbers: Vec<String> = (1..=corners.len()).map(|k| (self.corners + k).to_string()).collect();
        let _ = writeln!(self.obj, "f {}", numbers.join(" "));
        self.corners += corners.len();
        self
    }

    /// The walls of a room of 2.4 x 3 m, `height` m high, from `x0` to `x1`, that face into it, but for the one
    /// at `open`.
    fn shell(self, [x0, x1]: [f64; 2], height: f64, open: f64) -> Self {
        let h = height;
        let text = self
            .face("floor", "white", &[[x0, 0., 0.], [x0, 0., 3.], [x1, 0., 3.], [x1, 0., 0.]])
            .face("ceiling", "white", &[[x0, h, 0.], [x1, h, 0.], [x1, h, 3.], [x0, h, 3.]])
            .face("near", "white", &[[x0, 0., 0.], [x1, 0., 0.], [x1, h, 0.], [x0, h, 0.]])
            .face("far", "white", &[[x0, 0., 3.], [x0, h, 3.], [x1, h, 3.], [x1, 0., 3.]]);
        let (end, facing) = if open == x0 { (x1, -1.0) } else { (x0, 1.0) };
        text.face("end", "grey", &wall(end, h, facing))
    }

    /// A lamp of 0.5 m under the ceiling at `height` that shines down.
    fn lamp(self, x: f64, height: f64) -> Self {
        let y = height - 0.05;
        let corners = [[x, y, 1.2], [x + 0.5, y, 1.2], [x + 0.5, y, 1.7], [x, y, 1.7]];
        self.face("lamp", "lamp", &corners)
    }

    fn scene(&self, sidecar: &str) -> Arc<Scene> {
        let obj = format!("mtllib m.mtl\n{}", self.obj);
        Arc::new(from_text("t", &obj, MTL, Some(sidecar)).expect("a scene without faults"))
    }
}

/// A wall at `x` that faces along x, or against it where `facing` is negative.
fn wall(x: f64, height: f64, facing: f64) -> Vec<[f64; 3]> {
    let mut corners = vec![[x, 0., 0.], [x, height, 0.], [x, height, 3.], [x, 0., 3.]];
    if facing < 0.0 {
        corners.reverse();
    }
    corners
}

/// The left room with a partition at x = 2 that faces into it.
fn left(partition: &str) -> Text {
    Text::default().shell([0., 2.], 2.4, 2.).lamp(0.6, 2.4).face("partition", partition, &wall(2., 2.4, -1.))
}

/// The right room with a partition at x = 2 that faces into it.
fn right(partition: &str, height: f64) -> Text {
    let shell = Text::default().shell([2., 4.5], height, 2.);
    shell.lamp(3.4, height).face("partition", partition, &wall(2., height, 1.))
}

fn both_shells(height: f64) -> Text {
    let shells = Text::default().shell([0., 2.], 2.4, 2.).shell([2., 4.5], height, 2.);
    shells.lamp(0.6, 2.4).lamp(3.4, height)
}

fn solve(scene: &Arc<Scene>) -> Solution {
    solved(scene, &SolveSettings { patches: PatchTarget::Size(0.3), ..SolveSettings::default() })
}

/// Area, and mean irradiance per band, of the patches of a material on one side of x = 2 that see into the
/// room there.
fn light(solved: &Solution, material: &str, in_left: bool) -> (f64, [f64; 3]) {
    let light = solved.light(&solved.scene.lighting());
    let (mut area, mut flux) = (0.0, [0.0; 3]);
    for (patch, irradiance) in solved.mesh.patches.iter().zip(&light.irradiance) {
        let middle = patch.centre + 1e-3 * patch.normal;
        if solved.scene.materials[patch.material as usize].name == material && (middle.x < 2.0) == in_left {
            area += patch.area;
            (0..3).for_each(|band| flux[band] += patch.area * f64::from(irradiance[band]));
        }
    }
    (area, flux.map(|f| f / area))
}

/// Holds that every material is lit in a room as it is where that room is a model of its own.
fn is_lit_alike(what: &str, whole: &Solution, alone: &Solution, in_left: bool, tolerance: f64) {
    for material in &alone.scene.materials {
        let (area, expected) = light(alone, &material.name, in_left);
        if area == 0.0 {
            continue;
        }
        let (found_area, found) = light(whole, &material.name, in_left);
        let name = &material.name;
        close(&format!("{what}: area of {name}"), found_area, area, 1e-6);
        // What falls on a lamp is gathered in its own coarse row.
        let tolerance = if name == "lamp" { 10.0 * tolerance } else { tolerance };
        for band in 0..3 {
            close(&format!("{what}: {name}, band {band}"), found[band], expected[band], tolerance);
        }
    }
}

/// Two rooms with one partition: its left side red, its right side blue, in all the ways to write that.
fn partitions() -> Vec<(&'static str, Text)> {
    let (to_left, to_right) = (wall(2., 2.4, -1.), wall(2., 2.4, 1.));
    let red_first = |red: &[[f64; 3]], blue: &[[f64; 3]]| {
        both_shells(2.4).face("partition", "red", red).face("partition", "blue", blue)
    };
    let mut shifted = to_right.clone();
    shifted.rotate_left(1);
    let displaced: Vec<[f64; 3]> = to_right.iter().map(|[x, y, z]| [x - 2e-6, *y, *z]).collect();
    let [a, b, c, d] = [to_right[0], to_right[1], to_right[2], to_right[3]];
    let triangles = both_shells(2.4)
        .face("partition", "red", &[to_left[0], to_left[1], to_left[2]])
        .face("partition", "blue", &[a, b, c])
        .face("partition", "red", &[to_left[2], to_left[3], to_left[0]])
        .face("partition", "blue", &[c, d, a]);
    let (m, n) = ([2., 1., 0.], [2., 1., 3.]);
    vec![
        ("red first", red_first(&to_left, &to_right)),
        ("blue first", {
            both_shells(2.4).face("partition", "blue", &to_right).face("partition", "red", &to_left)
        }),
        ("another first corner", red_first(&to_left, &shifted)),
        ("two micrometres apart", red_first(&to_left, &displaced)),
        ("triangles of two diagonals", triangles),
        ("a face against two", {
            red_first(&to_left, &[a, m, n, d]).face("partition", "blue", &[m, b, c, n])
        }),
    ]
}

#[test]
fn each_side_of_a_partition_is_lit_as_in_a_room_of_its_own() {
    let (red_room, blue_room) = (solve(&left("red").scene("")), solve(&right("blue", 2.4).scene("")));
    for (what, text) in partitions() {
        for sides in ["auto", "front"] {
            let materials = ["white", "red", "blue", "grey"];
            let entry = |m: &str| format!("[[material]]\nname = \"{m}\"\nsides = \"{sides}\"\n");
            let sidecar: String = materials.map(entry).concat();
            let whole = solve(&text.scene(&sidecar));
            let what = format!("{what}, sides = {sides}");
            is_lit_alike(&what, &whole, &red_room, true, 3e-3);
            is_lit_alike(&what, &whole, &blue_room, false, 3e-3);
        }
    }
}

#[test]
fn no_row_crosses_a_partition_by_any_method() {
    for (what, text) in partitions() {
        for (method, resolution) in METHODS {
            let prepared =
                prepare(text.scene(""), &settings(PatchTarget::Size(0.4), method, resolution)).unwrap();
            let is_left = |p: usize| {
                let patch = &prepared.mesh.patches[p];
                (patch.centre + 1e-3 * patch.normal).x < 2.0
            };
            for (i, row) in rows(&prepared).iter().enumerate() {
                let stray: f64 = (row.patches.iter().zip(&row.values))
                    .filter(|(j, _)| is_left(**j as usize) != is_left(i))
                    .map(|(_, &f)| f64::from(f))
                    .sum();
                assert!(stray < 1e-6, "{what}, {method:?}: {stray} of row {i} crosses the partition");
                assert!((row.sum() - 1.0).abs() < 1e-5, "{what}, {method:?}: row {i} sums to {}", row.sum());
            }
        }
    }
}

#[test]
fn a_room_beside_a_lower_one_shares_a_part_of_its_wall() {
    let red_room = solve(&left("red").scene(""));
    let blue_room = solve(&right("blue", 1.6).scene(""));
    for red_first in [true, false] {
        let mut faces = [("red", wall(2., 2.4, -1.)), ("blue", wall(2., 1.6, 1.))];
        if !red_first {
            faces.reverse();
        }
        let text = faces
            .iter()
            .fold(both_shells(1.6), |text, (material, corners)| text.face("partition", material, corners));
        let whole = solve(&text.scene(""));
        is_lit_alike("the high room", &whole, &red_room, true, 3e-3);
        is_lit_alike("the low room", &whole, &blue_room, false, 3e-3);
    }
    // And where light reaches the part of the back that is left open.
    let street = Text::default()
        .face("pavement", "grey", &[[2., 0., -3.], [2., 0., 6.], [9., 0., 6.], [9., 0., -3.]])
        .face("moon", "lamp", &[[5., 6., 0.], [6., 6., 0.], [6., 6., 1.], [5., 6., 1.]]);
    let beside = |text: Text| text.face("wall", "red", &wall(2., 2.4, -1.));
    let with_poster = beside(street.clone()).face("poster", "blue", &wall(2., 1.2, 1.));
    let solved = solve(&with_poster.scene(""));
    // A poster of half the wall's height hides as much of its back, and the pavement sees it instead.
    close("red that is seen from the street", light(&solved, "red", false).0, 1.2 * 3.0, 1e-6);
    close("poster", light(&solved, "blue", false).0, 1.2 * 3.0, 1e-6);
    let poster_first = street.clone().face("poster", "blue", &wall(2., 1.2, 1.));
    let poster_first = solve(&beside(poster_first).scene(""));
    let pavement = |s: &Solution| light(s, "grey", false).1;
    // Seen from the street it might as well end above the poster.
    let upper = [[2., 1.2, 0.], [2., 1.2, 3.], [2., 2.4, 3.], [2., 2.4, 0.]];
    let apart = street.face("wall", "red", &upper).face("poster", "blue", &wall(2., 1.2, 1.));
    let apart = solve(&apart.scene(""));
    for band in 0..3 {
        close("pavement", pavement(&solved)[band], pavement(&apart)[band], 3e-3);
        close("pavement", pavement(&poster_first)[band], pavement(&apart)[band], 3e-3);
    }
}

#[test]
fn a_poster_close_before_a_wall_hides_the_street_from_it() {
    let street = Text::default()
        .face("pavement", "grey", &[[2., 0., -3.], [2., 0., 6.], [9., 0., 6.], [9., 0., -3.]])
        .face("moon", "lamp", &[[5., 6., 0.], [6., 6., 0.], [6., 6., 1.], [5., 6., 1.]]);
    // As if the wall began above the poster.
    let upper = [[2., 1.2, 0.], [2., 2.4, 0.], [2., 2.4, 3.], [2., 1.2, 3.]];
    let apart = street.clone().face("wall", "red", &upper).face("poster", "blue", &wall(2., 1.2, 1.));
    let apart = solve(&apart.scene(""));
    for gap in [0.0005, 0.002, 0.01] {
        let before = street.clone().face("wall", "red", &wall(2., 2.4, 1.));
        let before = solve(&before.face("poster", "blue", &wall(2. + gap, 1.2, 1.)).scene(""));
        let (found, expected) = (light(&before, "grey", false).1, light(&apart, "grey", false).1);
        for band in 0..3 {
            close(&format!("pavement, {gap} m"), found[band], expected[band], 0.015);
        }
        // Over the upper edge, at 4.8 m of height for 3.5 m of distance, the moon shines a little into the gap.
        let (light, mesh) = (before.light(&before.scene.lighting()), &before.mesh);
        let behind = |p: &Patch| p.normal.x > 0.9 && p.centre.x < 2.0 + 0.5 * gap && p.centre.y < 1.1;
        let poster = |p: &Patch| p.normal.x > 0.9 && p.centre.x > 2.0 + 0.5 * gap;
        let mean_of = |chosen: &dyn Fn(&Patch) -> bool| {
            let chosen: Vec<usize> = (0..mesh.patches.len()).filter(|&i| chosen(&mesh.patches[i])).collect();
            mean(&mesh.patches, &chosen, |i| f64::from(light.irradiance[i][0]))
        };
        let (front, hidden) = (mean_of(&poster), mean_of(&behind));
        let over_the_edge = gap * 4.8 / 3.5 / 1.2;
        assert!(
            hidden < (0.003 + 1.5 * over_the_edge) * front,
            "{gap} m: {hidden} behind the poster, {front} on it"
        );
    }
}

#[test]
fn lamps_are_painted_on_one_side_or_on_both() {
    // The partition itself shines, into the left room alone or with other lamps into both.
    let (to_left, to_right) = (wall(2., 2.4, -1.), wall(2., 2.4, 1.));
    for (red, blue) in [("lamp", "blue"), ("lamp", "glow"), ("lamp", "lamp")] {
        let (left_room, right_room) = (solve(&left(red).scene("")), solve(&right(blue, 2.4).scene("")));
        for is_reversed in [false, true] {
            let mut faces = [(red, &to_left), (blue, &to_right)];
            if is_reversed {
                faces.reverse();
            }
            let text = faces.iter().fold(both_shells(2.4), |text, (material, corners)| {
                text.face("partition", material, corners)
            });
            let whole = solve(&text.scene(""));
            is_lit_alike(&format!("{red} and {blue}"), &whole, &left_room, true, 3e-3);
            is_lit_alike(&format!("{red} and {blue}"), &whole, &right_room, false, 3e-3);
        }
    }
}

/// A panel of 0.5 m in the middle of the left room with a face for each side, the first of which looks down.
fn panel(first: &str, second: &str) -> Text {
    let down = [[0.7, 1.2, 1.2], [1.2, 1.2, 1.2], [1.2, 1.2, 1.7], [0.7, 1.2, 1.7]];
    let mut up = down;
    up.reverse();
    let room = Text::default().shell([0., 2.], 2.4, 2.).face("partition", "white", &wall(2., 2.4, -1.));
    room.face("panel", first, &down).face("panel", second, &up)
}

#[test]
fn the_sidecar_says_which_side_of_a_written_pair_emits() {
    let exitance = |scene: &Scene, up: bool| -> f64 {
        let faces = scene.surfaces.iter().filter(|s| scene.given_objects[s.object as usize] == "panel");
        let faces = faces.filter(|s| {
            let corners = scene.polygon(s);
            ((corners[1] - corners[0]).cross(corners[2] - corners[0]).y > 0.0) == up
        });
        let faces: Vec<_> = faces.collect();
        assert_eq!(faces.len(), 1, "one face looks each way");
        assert!(!faces[0].emits_back, "its back is another face's");
        faces[0]
            .luminaire
            .map_or(0.0, |l| scene.luminaires[l as usize].initial.exitance[0] * faces[0].emission_weight[0])
    };
    let entry =
        |emits: &str| format!("[[luminaire]]\nmaterial = \"lamp\"\nlumens = 1000\nemits = \"{emits}\"\n");
    // 1,000 lm over 0.25 m², or over both sides.
    let all = 1000.0 / 179.0 / 0.25;
    for (second, emits, down, up) in [
        ("grey", "front", all, 0.0),
        ("grey", "back", 0.0, all),
        ("grey", "both", 0.5 * all, 0.5 * all),
        ("lamp", "front", 0.5 * all, 0.5 * all),
        ("lamp", "back", 0.5 * all, 0.5 * all),
        ("lamp", "both", 0.5 * all, 0.5 * all),
    ] {
        for text in [panel("lamp", second), panel(second, "lamp")] {
            let is_swapped = text.obj.rfind("usemtl lamp") > text.obj.rfind(&format!("usemtl {second}"));
            let (down, up) = if is_swapped { (up, down) } else { (down, up) };
            let scene = text.scene(&entry(emits));
            close(&format!("{second}, {emits}, down"), exitance(&scene, false), down, 1e-9);
            close(&format!("{second}, {emits}, up"), exitance(&scene, true), up, 1e-9);
            let lumens: f64 = lumenwalk::scene::lumens(&scene)[0][0];
            close("lumens", lumens, 1000.0, 1e-9);
            let solved = solve(&scene);
            let grey = scene.materials.iter().position(|m| m.name == "grey").expect("grey") as u32;
            let painted: f64 = (solved.mesh.patches.iter())
                .filter(|p| p.material == grey && p.centre.y == 1.2)
                .map(|p| p.area)
                .sum();
            close("grey side", painted, if second == "grey" { 0.25 } else { 0.0 }, 1e-9);
            let written = lumenwalk::scene::sidecar_text(&scene, &scene.lighting(), &[], Some(&entry(emits)));
            assert!(written.is_ok(), "{written:?}");
        }
    }
}

#[test]
fn written_sides_are_noted_and_nothing_is_wrong_with_them() {
    for (what, text) in partitions() {
        let scene = text.scene("");
        let notes: Vec<_> = scene.findings.iter().filter(|f| f.message.contains("other side")).collect();
        match what {
            "triangles of two diagonals" | "a face against two" => assert!(notes.is_empty(), "{what}"),
            _ => {
                let is_noted = |f: &&lumenwalk::scene::Finding| {
                    f.kind == FindingKind::Material && f.severity == Severity::Note && f.count == 1
                };
                assert!(notes.len() == 1 && notes.iter().all(is_noted), "{what}: {notes:?}");
            }
        }
        let warned: Vec<_> = check(&scene).into_iter().filter(|f| f.severity > Severity::Note).collect();
        assert!(warned.is_empty(), "{what}: {warned:?}");
    }
    // A room of which every face is written twice is as closed as one of which none is.
    let twice = |obj: &Text| {
        let mut doubled = obj.clone();
        for line in obj.obj.lines().filter_map(|l| l.strip_prefix("f ")) {
            let reversed: Vec<&str> = line.split(' ').rev().collect();
            let _ = writeln!(doubled.obj, "usemtl grey\nf {}", reversed.join(" "));
        }
        doubled
    };
    let mut turned = left("red");
    turned.obj = turned.obj.replace("f 1 2 3 4\n", "f 4 3 2 1\n");
    let kinds = |text: &Text| -> Vec<FindingKind> { check(&text.scene("")).iter().map(|f| f.kind).collect() };
    assert_eq!(kinds(&twice(&left("red"))), kinds(&left("red")));
    assert!(kinds(&turned).contains(&FindingKind::Winding));
    assert!(!kinds(&twice(&turned)).contains(&FindingKind::Winding), "both ways are there");
}

#[test]
fn a_repaired_copy_has_both_sides() {
    // Which way the faces of a material look, and which lamp is theirs.
    let kinds = |scene: &Scene| {
        let mut kinds = BTreeMap::new();
        for surface in &scene.surfaces {
            let corners = scene.polygon(surface);
            let facing = lumenwalk::geometry::polygon::area_vector(&corners);
            let lamp = surface.luminaire.map(|l| scene.luminaires[l as usize].name.clone());
            let key = (scene.materials[surface.material as usize].name.clone(), lamp);
            *kinds.entry(key).or_insert(DVec3::ZERO) += facing;
        }
        kinds
    };
    let lamp = |emits: &str| format!("[[luminaire]]\nmaterial = \"lamp\"\nemits = \"{emits}\"\n");
    let partition = partitions().remove(1).1;
    let texts = [
        (partition, String::new()),
        (panel("lamp", "grey"), lamp("back")),
        (panel("grey", "lamp"), lamp("both")),
    ];
    for (text, sidecar) in texts {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("model.obj"), format!("mtllib model.mtl\n{}", text.obj)).unwrap();
        std::fs::write(path("model.mtl"), MTL).unwrap();
        std::fs::write(path("model.toml"), &sidecar).unwrap();
        let read = |name: &str| load(&SceneSource::File(path(name))).unwrap();
        let before = read("model.obj");
        save_repaired(&path("copy.obj"), &before).unwrap();
        let after = read("copy.obj");
        assert_eq!(after.surfaces.len(), before.surfaces.len());
        let (before, after) = (kinds(&before), kinds(&after));
        assert!(before.keys().eq(after.keys()), "{before:?} and {after:?}");
        for (kind, facing) in &before {
            assert!(facing.abs_diff_eq(after[kind], 1e-9), "{kind:?}: {facing} and {}", after[kind]);
        }
    }
}

#[test]
fn the_lux_of_a_free_point_are_those_of_a_room_written_once() {
    let point = (DVec3::new(1.0, 0.8, 1.5), DVec3::Y);
    let lux = |scene: &Arc<Scene>| {
        let solved = solve(scene);
        let light = solved.light(&solved.scene.lighting());
        let (mut sum, mut scratch) = ([0.0; 3], solved.computer.scratch());
        solved.computer.point(point.0, point.1, &mut scratch, |patch, f| {
            let b = light.radiosity[patch as usize];
            (0..3).for_each(|band| sum[band] += f * f64::from(b[band]));
        });
        illuminance(sum)
    };
    let once = lux(&left("red").scene(""));
    for (what, text) in partitions() {
        close(what, lux(&text.scene("")), once, 2e-3);
    }
}

/// A room of 4 x 3 x 5 m, a block in it, and a strip of light through the middle of that, which sticks out of both ends.
fn strip_through_a_block() -> Text {
    let quad = |at: [f64; 3], u: [f64; 3], v: [f64; 3]| -> Vec<[f64; 3]> {
        let [at, u, v] = [at, u, v].map(DVec3::from);
        [at, at + u, at + u + v, at + v].map(|corner| corner.to_array()).to_vec()
    };
    let closed = |text: Text, object: &str, material: &str, low: [f64; 3], size: [f64; 3], inward: bool| {
        let [x, y, z] = size;
        let far = std::array::from_fn(|axis| low[axis] + size[axis]);
        let faces = [
            (low, [0., 0., z], [0., y, 0.]),
            (low, [x, 0., 0.], [0., 0., z]),
            (low, [0., y, 0.], [x, 0., 0.]),
            (far, [0., -y, 0.], [0., 0., -z]),
            (far, [0., 0., -z], [-x, 0., 0.]),
            (far, [-x, 0., 0.], [0., -y, 0.]),
        ];
        faces.into_iter().fold(text, |text, (at, u, v)| {
            let (u, v) = if inward { (v, u) } else { (u, v) };
            text.face(object, material, &quad(at, u, v))
        })
    };
    let text = closed(Text::default(), "room", "white", [0.; 3], [4., 3., 5.], true);
    let text = closed(text, "block", "grey", [1.6, 1.2, 1.7], [0.8, 0.5, 1.6], false);
    text.face("strip", "lamp", &quad([1.99, 1.45, 1.5], [0.02, 0., 0.], [0., 0., 2.]))
}

#[test]
fn a_lamp_whose_middle_is_built_in_lights_the_room() {
    let solved = solve(&strip_through_a_block().scene(""));
    let light = solved.light(&solved.scene.lighting());
    let floor = |p: &Patch| p.normal.y > 0.9 && p.centre.y.abs() < 1e-9;
    let lit: Vec<usize> =
        (0..solved.mesh.patches.len()).filter(|&i| floor(&solved.mesh.patches[i])).collect();
    let area: f64 = lit.iter().map(|&i| solved.mesh.patches[i].area).sum();
    assert!((area - 20.0).abs() < 1e-6, "{area} m² of the floor are lit");
    assert!(lit.iter().all(|&i| light.irradiance[i][0] > 0.0));
}

#[test]
fn no_patch_lies_on_both_sides_of_what_cuts_through_its_surface() {
    // The strip runs through two faces of the block, whose ends it cuts, and they cut it.
    let mesh = solve(&strip_through_a_block().scene("")).mesh;
    let strip = |p: &&Patch| p.luminaire.is_some();
    let mut inside = 0.0;
    for patch in mesh.patches.iter().filter(strip) {
        let corners = || mesh.pieces_of(patch).flat_map(|piece| mesh.corners_of(piece));
        let depth = |z: f64| (z - 1.7).min(3.3 - z);
        let depths: Vec<f64> = corners().map(|c| depth(mesh.vertices[c.vertex as usize].z)).collect();
        let (out, in_it) = (depths.iter().any(|&d| d < -1e-6), depths.iter().any(|&d| d > 1e-6));
        assert!(!(out && in_it), "a patch at {} is cut through", patch.centre);
        inside += if in_it { patch.area } else { 0.0 };
    }
    assert!((inside - 0.02 * 1.6).abs() < 1e-6, "{inside} m² of the strip lie in the block");
}
