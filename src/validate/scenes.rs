//! Scenes that several cases and tests share.

use super::Model;
use crate::scene::{Scene, Sides};
use glam::{DMat3, DVec3, dvec3};

/// A unit cube, its inside: walls at reflectance 0.5, the ceiling with an exitance of 1 W/m².
pub fn cube() -> Model {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, DVec3::ONE, [paint, Some("glow"), paint, paint, paint, paint]);
    m
}

/// A room of 4 x 3 x 5 m with a lamp of 0.8 x 0.8 m in its ceiling and two blocks, all grey at `rho`.
pub fn room_with_blocks(rho: f64) -> Model {
    lit_room_with_blocks(rho, 20.0)
}

/// [`room_with_blocks`] with this exitance of its lamp, W/m² a band.
pub fn lit_room_with_blocks(rho: f64, exitance: f64) -> Model {
    let mut m = Model::new();
    m.grey("paint", rho).paint("glow", [rho; 3], [exitance; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [all, None, all, all, all, all]);
    m.ceiling_with_lamp("paint", [4.0, 3.0, 5.0], [1.6, 2.4, 2.1, 2.9]);
    m.block("cupboard", "paint", dvec3(0.7, 0.0, 0.9), dvec3(1.5, 1.8, 1.6));
    m.block("table", "paint", dvec3(2.2, 0.6, 2.5), dvec3(3.4, 0.7, 3.6));
    m
}

/// `rooms` rooms of 3 x 3 x 3 m in a row along x, joined by doors `width` wide and 2 m high in walls
/// without thickness; a lamp of 0.6 x 0.6 m hangs in the first.
pub fn rooms_in_a_row(rooms: usize, width: f64) -> Model {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    let all = Some("paint");
    let length = 3.0 * rooms.max(1) as f64;
    m.room(DVec3::ZERO, dvec3(length, 3.0, 3.0), [all, None, all, all, all, all]);
    m.object("ceiling").ceiling_with_lamp("paint", [length, 3.0, 3.0], [1.2, 1.8, 1.2, 1.8]);
    let side = 0.5 * (3.0 - width);
    for room in 1..rooms {
        m.object(&format!("wall_{room}"));
        for (z, y, dz, dy) in [(0.0, 0.0, side, 3.0), (side, 2.0, width, 1.0), (side + width, 0.0, side, 3.0)]
        {
            m.quad("paint", dvec3(3.0 * room as f64, y, z), DVec3::Z * dz, DVec3::Y * dy);
        }
    }
    m
}

/// A closed room 3 m high over an L of 4 x 5 m less 2 x 3 m: its floor one concave polygon, its lamp
/// 1 x 1 m in the ceiling.
pub fn l_shaped_room(rho: f64) -> Model {
    let l = [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, 5.0), (0.0, 5.0)]
        .map(|(x, z)| dvec3(x, 0.0, z));
    let mut m = Model::new();
    m.grey("paint", rho).paint("glow", [rho; 3], [1.0; 3]);
    let floor: Vec<DVec3> = l.iter().rev().copied().collect();
    m.object("floor").polygon("paint", &floor);
    for k in 0..6 {
        let (a, b) = (l[k], l[(k + 1) % 6]);
        m.object(&format!("wall_{k}")).quad("paint", a, b - a, 3.0 * DVec3::Y);
    }
    m.object("ceiling").ceiling_with_lamp("paint", [2.0, 3.0, 2.0], [0.5, 1.5, 0.5, 1.5]);
    m.quad("paint", dvec3(2.0, 3.0, 0.0), 2.0 * DVec3::X, 2.0 * DVec3::Z);
    m.quad("paint", dvec3(0.0, 3.0, 2.0), 2.0 * DVec3::X, 3.0 * DVec3::Z);
    m
}

/// A room of 4 x 3 x 5 m with a lamp in its ceiling and `boxes` boxes that cut through each other and
/// through the walls, at places that follow from `seed` alone.
pub fn cluttered_room(boxes: usize, seed: u64) -> Model {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [all, None, all, all, all, all]);
    m.object("ceiling").ceiling_with_lamp("paint", [4.0, 3.0, 5.0], [1.6, 2.4, 2.1, 2.9]);
    let mut state = seed;
    let mut next = || {
        // SplitMix64 (Steele et al. 2014).
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    for k in 0..boxes {
        let low = dvec3(4.2 * next() - 0.6, 2.0 * next() - 0.2, 5.2 * next() - 0.6);
        let size = dvec3(0.2 + next(), 0.1 + 0.7 * next(), 0.2 + next());
        m.block(&format!("box_{k}"), "paint", low, low + size);
    }
    m
}

/// The scene turned and scaled by `matrix`, a rotation times a scale, and moved by `shift` metres.
pub fn transformed(scene: &Scene, matrix: DMat3, shift: DVec3) -> Scene {
    let mut moved = scene.clone();
    moved.positions.iter_mut().for_each(|p| *p = matrix * *p + shift);
    let turn = matrix * (1.0 / matrix.determinant().cbrt());
    moved.normals.iter_mut().for_each(|n| *n = turn * *n);
    moved
}

/// The scene with every surface taking part on its front alone but for those of these materials,
/// which take part on both.
pub fn with_two_sided(mut scene: Scene, materials: &[&str]) -> Scene {
    for m in &mut scene.materials {
        m.sides = if materials.contains(&m.name.as_str()) { Sides::Both } else { Sides::Front };
    }
    scene
}
