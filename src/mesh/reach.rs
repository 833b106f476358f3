//! Which sides of which regions light can reach: the outside of a closed shell needs no patches.
//!
//! A side is lit if a diffuse path that starts on it comes to a point from which a lamp is seen.
//! Paths run through free space only, so that the inside of a box that stands on a lit floor stays
//! dark although it touches the floor.

use super::regions::Outline;
use super::types::Side;
use crate::geometry::{Bvh, Frame, Ray, polygon};
use crate::scene::{Scene, Sides};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Paths from each side.
const PATHS: u64 = 48;
/// Points on a path, its start included.
const BOUNCES: u64 = 6;
/// This many paths must find light: a single one may have slipped through the seam of two faces.
const ENOUGH: u32 = 2;

/// For every region whether its front and its back take part.
pub(super) fn sides(scene: &Scene, outlines: &[Outline], size: f64) -> Vec<[bool; 2]> {
    let mut triangles = Vec::new();
    let mut normals = Vec::new();
    for outline in outlines {
        for part in &outline.parts {
            for k in 1..part.corners.len() - 1 {
                triangles
                    .push([part.corners[0], part.corners[k], part.corners[k + 1]].map(|c| outline.world(c)));
                normals.push(outline.frame.normal);
            }
        }
    }
    let lamps: Vec<(DVec3, DVec3)> = outlines
        .iter()
        .filter(|o| o.luminaire.is_some())
        .flat_map(|o| {
            let normal = o.frame.normal;
            let backs = if o.emits_back { 2 } else { 1 };
            let points: Vec<DVec3> = sample_points(o, 3).into_iter().map(|p| o.world(p)).collect();
            [normal, -normal]
                .into_iter()
                .take(backs)
                .flat_map(move |n| points.clone().into_iter().map(move |p| (p, n)))
        })
        .collect();
    let search = Search { outlines, bvh: Bvh::build(&triangles), normals, lamps, offset: size * 1e-7 };
    (0..outlines.len())
        .into_par_iter()
        .map(|index| {
            let outline = &outlines[index];
            let emits = outline.luminaire.is_some();
            let lit = |side: Side| match scene.materials[outline.material as usize].sides {
                Sides::Both => true,
                Sides::Front => side == Side::Front,
                // Without a lamp nothing is lit; every front is kept, so that there is something to see.
                Sides::Auto if search.lamps.is_empty() => side == Side::Front,
                Sides::Auto => search.is_lit(index as u64, side),
            };
            [emits || lit(Side::Front), (emits && outline.emits_back) || lit(Side::Back)]
        })
        .collect()
}

struct Search<'a> {
    outlines: &'a [Outline],
    bvh: Bvh,
    /// Front normal of each triangle.
    normals: Vec<DVec3>,
    /// Points on lamps with the direction that they shine to.
    lamps: Vec<(DVec3, DVec3)>,
    offset: f64,
}

impl Search<'_> {
    fn is_lit(&self, region: u64, side: Side) -> bool {
        let outline = &self.outlines[region as usize];
        let starts: Vec<DVec3> = sample_points(outline, 12).into_iter().map(|p| outline.world(p)).collect();
        if starts.is_empty() {
            return false;
        }
        let mut found = 0;
        for path in 0..PATHS {
            let seed = (region * 2 + side as u64) * PATHS + path;
            let start = starts[path as usize % starts.len()];
            if self.path_finds_light(start, outline.frame.normal * side.sign(), seed) {
                found += 1;
                if found == ENOUGH {
                    return true;
                }
            }
        }
        false
    }

    fn path_finds_light(&self, mut point: DVec3, mut normal: DVec3, seed: u64) -> bool {
        for bounce in 0..BOUNCES {
            point += normal * self.offset;
            let key = seed * BOUNCES + bounce;
            let lamp = (unit(key, 0) * self.lamps.len() as f64) as usize;
            let (at, towards) = self.lamps[lamp.min(self.lamps.len() - 1)];
            let at = at + towards * self.offset;
            let to_lamp = at - point;
            if to_lamp.dot(normal) > 0.0
                && to_lamp.dot(towards) < 0.0
                && !self.bvh.occluded(&Ray { origin: point, direction: to_lamp }, 0.0, 1.0)
            {
                return true;
            }
            let direction = Frame::around(normal).world(cosine_from(unit(key, 1), unit(key, 2)));
            let Some(hit) = self.bvh.nearest(&Ray { origin: point, direction }, 0.0, f64::INFINITY) else {
                return false;
            };
            point += direction * hit.distance;
            normal = self.normals[hit.triangle as usize];
            if normal.dot(direction) > 0.0 {
                normal = -normal;
            }
        }
        false
    }
}

/// A number in 0..1 for a key and a dimension (the finaliser of SplitMix64, Steele et al. 2014).
fn unit(key: u64, dimension: u64) -> f64 {
    let mut z = (key * 3 + dimension + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Points inside the outline: in the triangles of its parts, spread by area.
fn sample_points(outline: &Outline, count: usize) -> Vec<DVec2> {
    let mut points = Vec::with_capacity(count);
    let step = outline.area / count as f64;
    let mut due = 0.5 * step;
    let mut sum = 0.0;
    for part in &outline.parts {
        for k in 1..part.corners.len() - 1 {
            let [a, b, c] = [part.corners[0], part.corners[k], part.corners[k + 1]];
            let area = polygon::area_2d(&[a, b, c]);
            while due < sum + area && points.len() < count {
                let n = points.len() as f64;
                // An R2 sequence folded into the triangle.
                let (mut s, mut t) = ((0.5 + 0.754_877_67 * n).fract(), (0.5 + 0.569_840_29 * n).fract());
                if s + t > 1.0 {
                    (s, t) = (1.0 - s, 1.0 - t);
                }
                points.push(a + (b - a) * s + (c - a) * t);
                due += step;
            }
            sum += area;
        }
    }
    points
}

/// The direction with a cosine distribution about +z for two numbers in 0..1.
fn cosine_from(along: f64, around: f64) -> DVec3 {
    let phi = std::f64::consts::TAU * around;
    let radius = along.sqrt();
    DVec3::new(radius * phi.cos(), radius * phi.sin(), (1.0 - along).max(0.0).sqrt())
}

/// The i-th of n directions with a cosine distribution about +z (Fibonacci spiral, turned).
pub(crate) fn cosine_direction(i: u32, n: u32, turn: f64) -> DVec3 {
    cosine_from((f64::from(i) + 0.5) / f64::from(n), (f64::from(i) * 0.618_033_988_749_894_9 + turn).fract())
}
