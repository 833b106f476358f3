//! Models in glTF, GLB and PLY: a room that is the same in every format has the same light.
//!
//! The values are those of a path tracer for a room of 4 x 2.5 x 3 m with a lamp of 0.6 x 0.6 m below its
//! ceiling, in lux at three points of the floor.

#[path = "../cli_support/mod.rs"]
mod cli_support;
mod any_bytes;
mod gltf;
mod gltf_file;
mod ply;

use cli_support::Workplace;
use image::{ImageFormat, Rgb, RgbImage};
use lumenwalk::scene::{self, Scene, SceneSource};
use std::io::Cursor;

/// With a floor of reflectance 0.3.
const PLAIN: [f64; 3] = [146.3, 109.9, 85.5];
/// With a floor that is 0.98 where x is small, and black beyond its middle.
const HALF: [f64; 3] = [156.1, 121.6, 87.5];
/// The other way round.
const OTHER_HALF: [f64; 3] = [156.0, 113.5, 99.6];
/// Radiance of the lamp, W/(m² sr), and what that is in cd/m².
const GLOW: f64 = 10.0;
const LUMINANCE: f64 = 179.0 * GLOW;

const CORNERS: [[f64; 3]; 12] = [
    [0.0, 0.0, 0.0],
    [0.0, 0.0, 3.0],
    [4.0, 0.0, 3.0],
    [4.0, 0.0, 0.0],
    [0.0, 2.5, 0.0],
    [4.0, 2.5, 0.0],
    [4.0, 2.5, 3.0],
    [0.0, 2.5, 3.0],
    [1.7, 2.45, 1.2],
    [2.3, 2.45, 1.2],
    [2.3, 2.45, 1.8],
    [1.7, 2.45, 1.8],
];

/// Name, reflectance, and quads of corners.
const PARTS: [(&str, f64, &[[usize; 4]]); 4] = [
    ("floor", 0.3, &[[0, 1, 2, 3]]),
    ("ceiling", 0.8, &[[4, 5, 6, 7]]),
    ("walls", 0.6, &[[0, 4, 7, 1], [3, 2, 6, 5], [0, 3, 5, 4], [1, 7, 6, 2]]),
    ("panel", 0.0, &[[8, 9, 10, 11]]),
];

fn empty() -> Workplace {
    let place = Workplace::with_room(0.5);
    for name in ["room.obj", "room.mtl", "room.toml"] {
        std::fs::remove_file(place.path(name)).unwrap();
    }
    place.put("points.csv", "2,0,1.5,0,1,0\n1,0,0.75,0,1,0\n3.5,0,2.5,0,1,0\n");
    place
}

fn lux(place: &Workplace, model: &str) -> Vec<f64> {
    place.succeed(&["solve", model, "--patches", "400", "--points", "points.csv", "--irradiance", "lux.csv"]);
    let text = place.text("lux.csv");
    let column = text.lines().next().unwrap().split(',').position(|name| name == "lux").unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect()
}

/// Holds a room against its values, and what is told about it against words; nothing may be doubtful.
fn hold(place: &Workplace, model: &str, expected: [f64; 3], words: &str) {
    let found = lux(place, model);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.02, "{model}, {words}: {found} lx, not {expected}");
    }
    let told = place.succeed(&["check", model]);
    assert!(told.contains(words), "{words}: {told}");
    assert!(!told.lines().any(|line| line.starts_with("warning")), "{told}");
}

fn read(place: &Workplace, model: &str) -> Scene {
    scene::load(&SceneSource::File(place.path(model))).unwrap()
}

/// White where u is small, black beyond the middle.
fn half_png() -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let half = RgbImage::from_fn(64, 2, |x, _| Rgb([if x < 32 { 255 } else { 0 }; 3]));
    half.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}
