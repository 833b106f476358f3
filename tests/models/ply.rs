//! PLY in text and binary.

use super::{CORNERS, LUMINANCE, PARTS, PLAIN, empty, half_png, hold, read};
use lumenwalk::scene::{self, SceneSource};
use std::f64::consts::PI;
use std::fmt::Write as _;

/// The room in PLY, with a colour for each face and the lamp in a sidecar.
pub(super) fn ply(format: &str) -> Vec<u8> {
    let faces: Vec<([usize; 4], u8)> = PARTS[..3]
        .iter()
        .flat_map(|(_, reflectance, quads)| quads.iter().map(|quad| (*quad, code(*reflectance))))
        .collect();
    let mut head = format!(
        "ply\nformat {format} 1.0\ncomment a room\nelement vertex 8\nproperty float x\nproperty double y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n\
         property uchar blue\nelement edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n",
        faces.len()
    );
    if format == "ascii" {
        for [x, y, z] in &CORNERS[..8] {
            let _ = writeln!(head, "{x} {y} {z}");
        }
        for ([a, b, c, d], grey) in faces {
            let _ = writeln!(head, "4 {a} {b} {c} {d} {grey} {grey} {grey}");
        }
        head += "0 1\n";
        return head.into_bytes();
    }
    let big = format == "binary_big_endian";
    let mut bytes = head.into_bytes();
    let mut number = |little: &[u8]| match big {
        true => bytes.extend(little.iter().rev()),
        false => bytes.extend(little),
    };
    for [x, y, z] in &CORNERS[..8] {
        number(&(*x as f32).to_le_bytes());
        number(&y.to_le_bytes());
        number(&(*z as f32).to_le_bytes());
    }
    for (corners, grey) in faces {
        number(&[4]);
        corners.iter().for_each(|&corner| number(&(corner as i32).to_le_bytes()));
        (0..3).for_each(|_| number(&[grey]));
    }
    number(&0_i32.to_le_bytes());
    number(&1_i32.to_le_bytes());
    bytes
}

/// The sRGB code of a reflectance.
pub(super) fn code(linear: f64) -> u8 {
    (255.0 * (1.055 * linear.powf(1.0 / 2.4) - 0.055)).round() as u8
}

/// The lamp of the room.
pub(super) fn panel() -> String {
    format!(
        "[[lamp]]\nname = \"Panel\"\nposition = [2, 2.45, 1.5]\nsize = [0.6, 0.6]\nlumens = {}\n",
        PI * LUMINANCE * 0.36
    )
}

#[test]
fn one_room_has_one_light_in_every_kind_of_ply() {
    let place = empty();
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        std::fs::write(place.path("room.ply"), ply(format)).unwrap();
        place.put("room.toml", &panel());
        hold(&place, "room.ply", PLAIN, "by the colours of their corners, taken as sRGB (6)");
    }
    let crlf = String::from_utf8(ply("ascii")).unwrap().replace('\n', "\r\n");
    place.put("room.ply", &crlf);
    hold(&place, "room.ply", PLAIN, "");
}

#[test]
fn a_scan_in_ply_has_its_image_its_normals_and_its_strips() {
    let place = empty();
    std::fs::write(place.path("half.png"), half_png()).unwrap();
    let head = "ply\nformat ascii 1.0\ncomment TextureFile half.png\nelement vertex 4\nproperty float x\nproperty float y\n\
        property float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
    let corners = "0 0 0 0 1 0\n0 0 3 0 1 0.1\n4 0 3 0 1 0\n4 0 0 0 1 0\n";
    let face = "element face 1\nproperty list uchar uint vertex_index\nproperty list uchar float texcoord\nend_header\n";
    place.put("scan.ply", &format!("{head}{face}{corners}4 0 1 2 3 8 0 0 0 1 1 1 1 0\n"));
    let scene = read(&place, "scan.ply");
    let surface = &scene.surfaces[0];
    assert!(surface.corners.iter().all(|corner| corner.normal.is_some()));
    let texture = &scene.textures[scene.materials[surface.material as usize].texture.unwrap() as usize];
    for corner in &surface.corners {
        let left = scene.positions[corner.position as usize].x < 1.0;
        let uv = scene.uvs[corner.uv.unwrap() as usize];
        assert_eq!(uv.x < 0.5, left);
        assert_eq!(texture.sample(uv * 0.9 + glam::DVec2::splat(0.05))[0] > 0.5, left);
    }
    let strip = "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    place.put("strip.ply", &format!("{head}{strip}{corners}8 0 1 3 2 -1 0 1 2\n"));
    let scene = read(&place, "strip.ply");
    assert_eq!(scene.surfaces.len(), 3);
    for surface in &scene.surfaces {
        assert!(lumenwalk::geometry::polygon::area_vector(&scene.polygon(surface)).y > 0.0, "all face up");
    }
}

#[test]
fn files_of_old_systems_and_of_several_images_are_read_and_told() {
    let place = empty();
    let text = String::from_utf8(ply("ascii")).unwrap().replace('\n', "\r");
    place.put("old.ply", &text);
    let binary = ply("binary_little_endian");
    let head = binary.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let mut old = binary.clone();
    old[..head].iter_mut().filter(|byte| **byte == b'\n').for_each(|byte| *byte = b'\r');
    std::fs::write(place.path("oldbin.ply"), old).unwrap();
    for file in ["old.ply", "oldbin.ply"] {
        assert_eq!(read(&place, file).surfaces.len(), 6, "{file}");
    }
    std::fs::write(place.path("half.png"), half_png()).unwrap();
    let two = "ply\nformat ascii 1.0\ncomment TextureFile half.png\ncomment TextureFile other.png\nelement vertex 3\n\
        property float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\n\
        end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    place.put("two.ply", two);
    let told = place.succeed(&["check", "two.ply"]);
    assert!(told.contains("only the first is read (1 more)"), "{told}");
}

#[test]
fn colours_of_corners_survive_a_copy_of_an_obj() {
    let place = empty();
    let corners = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3\nf 1 3 4\n";
    place.put("wall.obj", corners);
    std::fs::create_dir(place.path("copy")).unwrap();
    place.succeed(&["check", "wall.obj", "--repair", "copy/wall.obj"]);
    for file in ["wall.obj", "copy/wall.obj"] {
        let scene = read(&place, file);
        for surface in &scene.surfaces {
            let texture = scene.materials[surface.material as usize].texture.unwrap();
            for corner in &surface.corners {
                let place = scene.positions[corner.position as usize];
                let found = scene.textures[texture as usize].sample(scene.uvs[corner.uv.unwrap() as usize]);
                let expected: [f32; 3] = match (place.x > 0.5, place.y > 0.5) {
                    (false, false) => [0.98, 0.0, 0.0],
                    (true, false) => [0.0, 0.98, 0.0],
                    (true, true) => [0.0, 0.0, 0.98],
                    (false, true) => [0.214; 3],
                };
                let is_close = (0..3).all(|band| (found[band] - expected[band]).abs() < 0.01);
                assert!(is_close, "{file}: {found:?} at {place}");
            }
        }
    }
}

#[test]
fn a_report_replaces_no_model_whatever_its_name() {
    let place = empty();
    std::fs::write(place.path("room.html"), ply("ascii")).unwrap();
    place.put("room.toml", &panel());
    let refused = place.run(&["report", "room.html", "--out", "."]);
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(told.contains("would be overwritten and is an input"), "{told}");
    assert!(place.text("room.html").starts_with("ply"));
}

#[test]
fn damaged_ply_is_refused_in_one_sentence() {
    let place = empty();
    let good = String::from_utf8(ply("ascii")).unwrap();
    let points = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n";
    let binary = ply("binary_little_endian");
    for (bytes, words) in [
        (b"ply\n".to_vec(), "room.ply"),
        (good.replace("0 0 3\n", "0 nan 3\n").into_bytes(), "line 18: the PLY file cannot be parsed"),
        (good.replace("4 0 1 2 3", "4 0 1 2 x").into_bytes(), "cannot be parsed"),
        (
            good.replace("4 0 1 2 3", "4 0 1 2 8").into_bytes(),
            "face 0 asks for a vertex that is not among the 8",
        ),
        (good.replace("4 0 1 2 3", "4 0 1 2 -1").into_bytes(), "face 0 asks for a vertex"),
        (good.replace("0 0 3\n", "0 1e300 3\n").into_bytes(), "vertex 1 has no usable x, y and z"),
        (good.as_bytes()[..good.len() / 2].to_vec(), "room.ply"),
        (points.as_bytes().to_vec(), "points and no faces"),
        (binary[..binary.len() - 9].to_vec(), "it is cut off"),
    ] {
        std::fs::write(place.path("room.ply"), bytes).unwrap();
        let error = scene::load(&SceneSource::File(place.path("room.ply"))).unwrap_err().to_string();
        assert!(error.starts_with("room.ply") && error.contains(words), "{words}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
}
