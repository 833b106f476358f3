//! Models far from their origin, and models with something forgotten kilometres away: the light of the
//! room is that of the same room at the origin.

mod common;

use common::{close, lines, solved};
use glam::{DVec3, dvec3};
use lumenwalk::mesh::{self, Backs, MeshSettings, PatchTarget};
use lumenwalk::scene::{
    FindingKind, LengthUnit, Scene, SceneSource, Severity, UpAxis, check, from_text, illuminance, mend,
    sidecar_text,
};
use std::path::Path;
use std::sync::Arc;

const MTL: &str = "newmtl floor\nKd 0.3 0.3 0.3\nnewmtl wall\nKd 0.6 0.6 0.6\nnewmtl ceiling\nKd 0.8 0.8 0.8\n\
    newmtl lamp\nKd 0 0 0\nKe 10 10 10\n";

/// Points of the floor, and their illuminance by a path tracer of another program, lux.
const POINTS: [[f64; 3]; 3] = [[2.0, 0.0, 1.5], [1.0, 0.0, 0.75], [3.5, 0.0, 2.5]];
const TRACED: [f64; 3] = [146.3, 109.9, 85.5];

/// A room of 4 x 2.5 x 3 m with a panel of 0.6 m below its ceiling, at `at`, in units of `unit` metres.
fn room(at: DVec3, unit: f64) -> String {
    let mut text = "mtllib m.mtl\n".to_owned();
    let mut corners = 0;
    let mut quad = |name: &str, material: &str, quad: [[f64; 3]; 4]| {
        text += &format!("o {name}\nusemtl {material}\n");
        for corner in quad {
            let [x, y, z] = ((DVec3::from(corner) + at) / unit).to_array();
            text += &format!("v {x} {y} {z}\n");
        }
        text += &format!("f {} {} {} {}\n", corners + 1, corners + 2, corners + 3, corners + 4);
        corners += 4;
    };
    let (w, h, d) = (4.0, 2.5, 3.0);
    quad("floor", "floor", [[0.0, 0.0, 0.0], [0.0, 0.0, d], [w, 0.0, d], [w, 0.0, 0.0]]);
    quad("ceiling", "ceiling", [[0.0, h, 0.0], [w, h, 0.0], [w, h, d], [0.0, h, d]]);
    quad("wall_x0", "wall", [[0.0, 0.0, 0.0], [0.0, h, 0.0], [0.0, h, d], [0.0, 0.0, d]]);
    quad("wall_x1", "wall", [[w, 0.0, 0.0], [w, 0.0, d], [w, h, d], [w, h, 0.0]]);
    quad("wall_z0", "wall", [[0.0, 0.0, 0.0], [w, 0.0, 0.0], [w, h, 0.0], [0.0, h, 0.0]]);
    quad("wall_z1", "wall", [[0.0, 0.0, d], [0.0, h, d], [w, h, d], [w, 0.0, d]]);
    quad("panel", "lamp", [[1.7, 2.45, 1.2], [2.3, 2.45, 1.2], [2.3, 2.45, 1.8], [1.7, 2.45, 1.8]]);
    text
}

/// Survey coordinates of a place in Europe, metres.
const SURVEYED: DVec3 = dvec3(512_345.25, 0.0, 5_401_234.75);

fn with_marker(text: &str, marker: &str) -> String {
    let first = text.lines().filter(|line| line.starts_with("v ")).count() + 1;
    format!("{text}o origin_marker\nusemtl wall\n{marker}f {first} {} {}\n", first + 1, first + 2)
}

const MARKER: &str = "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\n";

fn read(text: &str, sidecar: &str) -> Arc<Scene> {
    Arc::new(from_text("room", text, MTL, Some(sidecar)).expect("a room"))
}

/// Illuminance at the points of the floor, lux. `at` is where the room stands, in the unit of the file.
fn lux(scene: &Arc<Scene>, at: DVec3, unit: f64) -> Vec<f64> {
    let solved = solved(scene, &lines(PatchTarget::Count(1500)));
    let light = solved.light(&scene.lighting());
    let place = |point: [f64; 3]| (scene.in_scene((DVec3::from(point) + at) / unit), DVec3::Y);
    solved.irradiance_at(&POINTS.map(place), &light).into_iter().map(illuminance).collect()
}

#[test]
fn a_room_is_lit_alike_wherever_it_stands_and_whatever_was_forgotten_far_away() {
    let here = lux(&read(&room(DVec3::ZERO, 1.0), ""), DVec3::ZERO, 1.0);
    for (found, traced) in here.iter().zip(TRACED) {
        close("against the path tracer", *found, traced, 0.015);
    }
    let survey = room(SURVEYED, 1.0);
    let chair: String = (0..30)
        .map(|k| {
            let (x, n) = (4000.0 + 0.01 * f64::from(k), 29 + 3 * k);
            format!("v {x} 0 0\nv {x} 1 0\nv {x} 0 1\nf {n} {} {}\n", n + 1, n + 2)
        })
        .collect();
    let cases = [
        ("in survey coordinates", survey.clone(), "", SURVEYED, 1.0),
        ("with a marker at their origin", with_marker(&survey, MARKER), "", SURVEYED, 1.0),
        (
            "with an unused corner there",
            format!("v 0 0 0\n{}", survey.replace("f 1 2", "f 2 3")),
            "",
            SURVEYED,
            1.0,
        ),
        (
            "with a chair 4 km away",
            format!("{}o chair\nusemtl wall\n{chair}", room(DVec3::ZERO, 1.0)),
            "",
            DVec3::ZERO,
            1.0,
        ),
        (
            "in millimetres, with a marker",
            with_marker(&room(SURVEYED, 0.001), MARKER),
            "unit = \"mm\"",
            SURVEYED,
            0.001,
        ),
    ];
    for (what, text, sidecar, at, unit) in cases {
        if what.contains("unused") {
            // Only that a corner without a face moves nothing.
            let scene = read(&format!("{survey}v 0 0 0\n"), sidecar);
            assert!(scene.extent().stray.is_empty() && scene.extent().scale < 6.0);
            continue;
        }
        let scene = read(&text, sidecar);
        for (found, expected) in lux(&scene, at, unit).iter().zip(&here) {
            close(what, *found, *expected, 1e-3);
        }
        let extent = scene.extent();
        assert!((extent.scale - 5.5902).abs() < 1e-3, "{what}: {extent:?}");
        assert!(scene.positions[0].length() < 2000.0, "{what}: {}", scene.positions[0]);
    }
}

#[test]
fn neither_a_far_logo_nor_terrain_uses_up_the_patches_of_the_room() {
    let largest_in_the_room = |more: &str, patches: usize| {
        let scene =
            read(&format!("{}o more\nusemtl wall\n{more}f 29 30 31 32\n", room(DVec3::ZERO, 1.0)), "");
        let settings = MeshSettings {
            target: PatchTarget::Count(patches),
            backs: Backs::All,
            ..MeshSettings::default()
        };
        let mesh = mesh::build(&scene, &settings).expect("patches");
        let own = mesh.patches.iter().filter(|patch| patch.centre.length() < 6.0 && patch.radius < 100.0);
        own.map(|patch| patch.area).fold(0.0, f64::max)
    };
    let quad = |x: f64, y: f64, size: f64| {
        let (far, near, deep) = (x + size, -0.5 * size, 0.5 * size);
        format!("v {x} {y} {near}\nv {x} {y} {deep}\nv {far} {y} {deep}\nv {far} {y} {near}\n")
    };
    let alone = largest_in_the_room(&quad(5.0, 0.0, 0.1), 1500);
    for (what, more) in [("a logo", quad(90_000.0, 0.0, 300.0)), ("terrain", quad(-1000.0, -0.1, 2000.0))] {
        let found = largest_in_the_room(&more, 1500);
        assert!(found < 4.0 * alone, "{what}: patches of {found} m2 where {alone} are usual");
    }
}

#[test]
fn what_is_far_away_is_named_and_makes_no_false_alarm() {
    let scene = read(&with_marker(&room(SURVEYED, 1.0), MARKER), "");
    let found = scene.findings.iter().find(|finding| finding.kind == FindingKind::Stray).expect("the marker");
    for words in ["'origin_marker'", "line 56", "5,425 km"] {
        assert!(found.message.contains(words), "{words}: {}", found.message);
    }
    assert_eq!((found.severity, &found.places.faces[..]), (Severity::Warning, &[7_u32][..]));
    let alarms: Vec<_> =
        check(&scene).into_iter().filter(|finding| finding.severity > Severity::Note).collect();
    assert!(alarms.is_empty(), "{alarms:?}");
}

#[test]
fn views_look_into_the_room_and_leave_in_the_coordinates_of_the_file() {
    let scene = read(&with_marker(&room(SURVEYED, 1.0), MARKER), "");
    for view in &scene.views {
        let eye = scene.in_file(view.eye) - SURVEYED;
        assert!(eye.cmpgt(DVec3::ZERO).all() && eye.cmplt(dvec3(4.0, 2.5, 3.0)).all(), "{eye}");
    }
    let text = sidecar_text(&scene, &scene.lighting(), &[], None).expect("a sidecar");
    assert!(text.contains("512") && text.contains("5401"), "{text}");
    let again = read(&with_marker(&room(SURVEYED, 1.0), MARKER), &text);
    for (view, wanted) in again.views.iter().zip(&scene.views) {
        assert!(view.eye.distance(wanted.eye) < 1e-9 && view.target.distance(wanted.target) < 1e-9);
    }
    assert_eq!(sidecar_text(&again, &again.lighting(), &[], Some(&text)).expect("a sidecar"), text);
}

#[test]
fn a_repaired_copy_stays_where_the_model_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("room.obj");
    let text = with_marker(&room(SURVEYED, 1.0), MARKER);
    std::fs::write(&path, &text).expect("written");
    std::fs::write(folder.path().join("m.mtl"), MTL).expect("written");
    let scene = lumenwalk::scene::load(&SceneSource::File(path)).expect("a room");
    let mended = mend(&scene, Path::new("copy.obj")).expect("a copy");
    let corners = |text: &str| -> Vec<DVec3> {
        let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
        let mut all: Vec<DVec3> = lines
            .map(|rest| {
                let values: Vec<f64> = rest.split(' ').map(|word| word.parse().expect("a number")).collect();
                dvec3(values[0], values[1], values[2])
            })
            .collect();
        all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
        all.dedup();
        all
    };
    let (copied, given) = (corners(&mended.obj), corners(&text));
    assert_eq!(copied.len(), given.len());
    for (copy, given) in copied.iter().zip(&given) {
        // The room to the last digit; the marker to those of its distance.
        let most = if given.x > 1.0 { 0.0 } else { 1e-9 };
        assert!((*copy - *given).abs().max_element() <= most, "{copy}, not {given}");
    }
}

#[test]
fn a_choice_rules_over_the_sidecar_and_is_kept_apart_from_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("room.obj");
    std::fs::write(&path, room(DVec3::ZERO, 0.001)).expect("written");
    std::fs::write(folder.path().join("m.mtl"), MTL).expect("written");
    let sidecar = "unit = \"m\"\nup = \"y\"\n[[view]]\nname = \"A\"\neye = [1000, 1600, 1000]\ntarget = [3000, 1500, 1000]\n";
    std::fs::write(folder.path().join("room.toml"), sidecar).expect("written");
    let choice = lumenwalk::scene::FrameChoice { unit: Some(LengthUnit::Millimetre), up: Some(UpAxis::Z) };
    let source = SceneSource::File(path.clone()).framed(choice);
    let scene = lumenwalk::scene::load(&source).expect("a room");
    assert_eq!((scene.unit, scene.up), (LengthUnit::Millimetre, UpAxis::Z));
    assert!((scene.bounds().size() - dvec3(4.0, 2.5, 3.0)).length() < 1e-12);
    assert_eq!(scene.views[0].eye, dvec3(1.0, 1.6, 1.0), "its views are in the unit that was chosen");
    assert!(source.is_same_model(&SceneSource::File(path)) && scene.source == source);
    assert_eq!(SceneSource::from("builtin:house").framed(choice), SceneSource::from("builtin:house"));
}
