//! Potted plants, whose leaves give way to each other and to what stands beside them.

use super::furniture::Random;
use super::palette::{LEAF, POT, SOIL};
use crate::geometry::{Bvh, Ray};
use crate::scene::builtin::writer::Model;
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;

/// A box by two corners, metres, in the plant's own coordinates: no leaf reaches into it.
pub(crate) type Taken = [[f64; 3]; 2];

/// Leaves keep this far from what stands beside them, metres.
const CLEARANCE: f64 = 0.006;
/// Places that are tried for a leaf: as many around, then shorter ones.
const TURNS: usize = 13;
const LENGTHS: usize = 6;

/// A potted plant on y = 0 with bent leaves in all directions; `height` of its crown, metres.
pub(crate) fn plant(m: &mut Model, height: f64, leaves: usize, seed: u32) {
    plant_between(m, height, leaves, seed, &[]);
}

/// A plant as [`plant`] whose leaves keep out of some boxes: walls behind it, furniture beside it.
pub(crate) fn plant_between(m: &mut Model, height: f64, leaves: usize, seed: u32, taken: &[Taken]) {
    let (pot, rim) = (0.26 * height.min(1.2), 0.14 * height.min(1.2));
    m.object("plants").paint(&POT);
    m.lathe(DVec3::ZERO, &[(0.7 * rim, 0.0), (rim, pot)], 10);
    m.paint(&SOIL).disc(dvec3(0.0, pot, 0.0), rim, 10, true);
    m.paint(&LEAF);
    let mut random = Random(seed);
    let mut grown: Vec<[DVec3; 3]> = Vec::new();
    for k in 0..leaves {
        // Lower leaves lean out, later ones stand up.
        let t = k as f64 / leaves as f64;
        let angle = TAU * (k as f64 * 0.381_966 + 0.05 * random.next());
        let lift = (height * (0.45 + 0.5 * t) * (0.9 + 0.2 * random.next()) - pot).max(0.1);
        let leaf = |turn: f64, length: f64| {
            let (sin, cos) = (angle + turn).sin_cos();
            let (out, across) = (dvec3(cos, 0.0, sin), dvec3(-sin, 0.0, cos));
            let reach = height * (0.42 - 0.26 * t) * length;
            // Later leaves grow within the earlier ones.
            let foot = dvec3(0.0, pot, 0.0) + out * (0.45 * rim - 0.35 * rim * t);
            let waist = foot + out * (0.45 * reach) + DVec3::Y * (0.72 * lift);
            let tip = foot + out * reach + DVec3::Y * lift * (0.72 + 0.3 * t);
            let half = across * (0.075 * height * (1.0 - 0.3 * t) * length.sqrt());
            [[foot, waist - half, waist + half], [waist + half, waist - half, tip]]
        };
        let tries = (0..TURNS * LENGTHS).map(|i| {
            let step = (i % TURNS).div_ceil(2) as f64 * if i % 2 == 0 { 1.0 } else { -1.0 };
            leaf(0.09 * step, 1.0 - 0.1 * (i / TURNS) as f64)
        });
        let is_free = |leaf: &[[DVec3; 3]; 2]| {
            !taken.iter().any(|b| leaf.iter().any(|t| reaches_into(t, b))) && !meet(leaf, &grown)
        };
        // Where there is no room the plant has a leaf less.
        if let Some(leaf) = tries.into_iter().find(is_free) {
            grown.extend(leaf);
        }
    }
    grown.iter().for_each(|triangle| m.polygon(triangle));
}

/// Whether a part of a triangle lies in a box, or nearer to it than [`CLEARANCE`]; looked at in points
/// much closer than any such box is wide.
fn reaches_into(&[a, b, c]: &[DVec3; 3], taken: &Taken) -> bool {
    let [low, high] = taken.map(DVec3::from);
    let (low, high) = (low - CLEARANCE, high + CLEARANCE);
    let parts = 24;
    (0..=parts).any(|i| {
        (0..=parts - i).any(|j| {
            let p =
                a + (b - a) * (f64::from(i) / f64::from(parts)) + (c - a) * (f64::from(j) / f64::from(parts));
            p.cmpge(low).all() && p.cmple(high).all()
        })
    })
}

/// Whether the triangles of a leaf cut through any of the others.
fn meet(leaf: &[[DVec3; 3]; 2], others: &[[DVec3; 3]]) -> bool {
    let cut = |edges: &[[DVec3; 3]], faces: &[[DVec3; 3]]| {
        let faces = Bvh::build(faces);
        edges.iter().any(|t| {
            (0..3).any(|k| {
                let ray = Ray { origin: t[k], direction: t[(k + 1) % 3] - t[k] };
                faces.occluded(&ray, 0.0, 1.0)
            })
        })
    };
    cut(leaf, others) || cut(others, leaf)
}
