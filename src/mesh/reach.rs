//! Which sides of which regions light can reach: the outside of a closed shell needs no patches.
//!
//! A side is lit if a diffuse path that starts on it comes to a point from which a lamp is seen, or a
//! point that a path from a lamp came to: paths from both ends meet where lamps hide in housings.
//! Paths run through free space only, so that the inside of a box that stands on a lit floor stays
//! dark although it touches the floor.

use super::regions::Outline;
use super::types::{Patch, Side};
use crate::geometry::{Bvh, Frame, Ray, polygon};
use crate::scene::{Scene, Sides};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Paths from each side.
const PATHS: u64 = 32;
/// Points on a path, its start included.
const BOUNCES: u64 = 4;
/// Paths from lamps; every point that they come to counts as light for the others.
const LAMP_PATHS: u64 = 1024;
/// This many paths must find light: a single one may have slipped through the seam of two faces.
const ENOUGH: u32 = 2;

/// How light and a side stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// It takes part.
    Lit,
    /// Black by the material's own word; what is lit may see it.
    Black,
    /// No light reaches it, so nothing lit sees it.
    Dark,
}

/// A patch whose centre no light reaches.
pub(super) enum Buried {
    /// Nor any other point of it that was tried.
    Whole,
    /// This point of it is lit.
    LitAt(DVec3),
}

/// Finds what light can reach in a scene.
pub(super) struct Search<'a> {
    scene: &'a Scene,
    outlines: &'a [Outline],
    bvh: Bvh,
    /// Front normal of each triangle.
    normals: Vec<DVec3>,
    /// Points on lamps with the direction that they shine to.
    lamps: Vec<(DVec3, DVec3)>,
    /// Points that paths from lamps came to, with the normals of the sides that they met.
    lit: Vec<(DVec3, DVec3)>,
    offset: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(scene: &'a Scene, outlines: &'a [Outline], size: f64) -> Self {
        let mut triangles = Vec::new();
        let mut normals = Vec::new();
        let mut lamps = Vec::new();
        for outline in outlines {
            let normal = outline.frame.normal;
            for part in &outline.parts {
                for k in 1..part.corners.len() - 1 {
                    let triangle = [part.corners[0], part.corners[k], part.corners[k + 1]];
                    triangles.push(triangle.map(|c| outline.world(c)));
                    normals.push(normal);
                }
            }
            if outline.luminaire.is_some() {
                for point in sample_points(outline, 3) {
                    lamps.push((outline.world(point), normal));
                    if outline.emits_back {
                        lamps.push((outline.world(point), -normal));
                    }
                }
            }
        }
        let bvh = Bvh::build(&triangles);
        let mut search = Self { scene, outlines, bvh, normals, lamps, lit: Vec::new(), offset: size * 1e-7 };
        search.lit = search.paths_from_lamps();
        search
    }

    /// The points that diffuse paths from the lamps come to.
    fn paths_from_lamps(&self) -> Vec<(DVec3, DVec3)> {
        if self.lamps.is_empty() {
            return Vec::new();
        }
        let mut points = Vec::new();
        for path in 0..LAMP_PATHS {
            // Every lamp in turn.
            let start = (path as f64 * 0.618_033_988_749_894_9).fract() * self.lamps.len() as f64;
            let (mut point, mut normal) = self.lamps[(start as usize).min(self.lamps.len() - 1)];
            for bounce in 0..BOUNCES {
                let key = (1 << 60) + path * BOUNCES + bounce;
                let Some(next) = self.bounce(point + normal * self.offset, normal, key) else { break };
                (point, normal) = next;
                points.push(next);
            }
        }
        points
    }

    /// Where a diffuse step from a point comes to, and the normal of the side that it meets.
    fn bounce(&self, origin: DVec3, normal: DVec3, key: u64) -> Option<(DVec3, DVec3)> {
        let direction = Frame::around(normal).world(cosine_from(unit(key, 1), unit(key, 2)));
        let hit = self.bvh.nearest(&Ray { origin, direction }, 0.0, f64::INFINITY)?;
        let front = self.normals[hit.triangle as usize];
        let normal = if front.dot(direction) > 0.0 { -front } else { front };
        Some((origin + direction * hit.distance, normal))
    }

    /// For every region how its front and its back stand to light.
    pub(super) fn sides(&self) -> Vec<[Reach; 2]> {
        (0..self.outlines.len())
            .into_par_iter()
            .map(|index| [Side::Front, Side::Back].map(|side| self.side(index, side)))
            .collect()
    }

    fn side(&self, index: usize, side: Side) -> Reach {
        let outline = &self.outlines[index];
        let emits = outline.luminaire.is_some() && (side == Side::Front || outline.emits_back);
        let sides = self.scene.materials[outline.material as usize].sides;
        if emits || sides == Sides::Both || (sides == Sides::Front && side == Side::Front) {
            return Reach::Lit;
        }
        if self.lamps.is_empty() {
            // Nothing is lit; every front is kept, so that there is something to see.
            return if side == Side::Front { Reach::Lit } else { Reach::Black };
        }
        let starts: Vec<DVec3> = sample_points(outline, 12).into_iter().map(|p| outline.world(p)).collect();
        let seed = 2 * index as u64 + side as u64;
        match self.is_lit(&starts, outline.frame.normal * side.sign(), seed, PATHS, ENOUGH) {
            false => Reach::Dark,
            true if sides == Sides::Front => Reach::Black,
            true => Reach::Lit,
        }
    }

    /// For each patch whether its centre lies under something, out of all light, although its side is
    /// lit elsewhere; then a point of it that is lit, if any of `points` is.
    pub(super) fn buried(
        &self,
        patches: &[Patch],
        points: impl Fn(&Patch) -> Vec<DVec3> + Sync,
    ) -> Vec<Option<Buried>> {
        patches
            .par_iter()
            .enumerate()
            .map(|(index, patch)| {
                let by_reach = self.scene.materials[patch.material as usize].sides != Sides::Both;
                let seed = (1 << 40) + 64 * index as u64;
                if !by_reach
                    || patch.luminaire.is_some()
                    || self.lamps.is_empty()
                    || self.is_lit(&[patch.centre], patch.normal, seed, PATHS / 3, 1)
                {
                    return None;
                }
                let lit = (1..)
                    .zip(points(patch).into_iter().take(40))
                    .find(|&(k, point)| self.is_lit(&[point], patch.normal, seed + k, PATHS / 8, 1));
                Some(lit.map_or(Buried::Whole, |(_, point)| Buried::LitAt(point)))
            })
            .collect()
    }

    /// Whether `enough` of `paths` paths from the points in turn find light.
    fn is_lit(&self, starts: &[DVec3], normal: DVec3, seed: u64, paths: u64, enough: u32) -> bool {
        let mut found = 0;
        for path in 0..paths {
            let Some(&start) = starts.get(path as usize % starts.len().max(1)) else { return false };
            if self.path_finds_light(start, normal, seed.wrapping_mul(PATHS) + path) {
                found += 1;
                if found == enough {
                    return true;
                }
            }
        }
        false
    }

    fn path_finds_light(&self, mut point: DVec3, mut normal: DVec3, seed: u64) -> bool {
        for bounce in 0..BOUNCES {
            point += normal * self.offset;
            let key = seed.wrapping_mul(BOUNCES) + bounce;
            // Lamps and what they light take turns.
            let lights = if self.lit.is_empty() || bounce % 2 == 0 { &self.lamps } else { &self.lit };
            let pick = (unit(key, 0) * lights.len() as f64) as usize;
            let (at, towards) = lights[pick.min(lights.len() - 1)];
            let at = at + towards * self.offset;
            let to_light = at - point;
            if to_light.dot(normal) > 0.0
                && to_light.dot(towards) < 0.0
                && !self.bvh.occluded(&Ray { origin: point, direction: to_light }, 0.0, 1.0)
            {
                return true;
            }
            match self.bounce(point, normal, key) {
                Some(next) => (point, normal) = next,
                None => return false,
            }
        }
        false
    }
}

/// A number in 0..1 for a key and a dimension (the finaliser of SplitMix64, Steele et al. 2014).
fn unit(key: u64, dimension: u64) -> f64 {
    let mut z = (key.wrapping_mul(3).wrapping_add(dimension + 1)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
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
                // Off the rim, from which a path could leave a closed body.
                let middle = (a + b + c) / 3.0;
                points.push(middle + (a + (b - a) * s + (c - a) * t - middle) * 0.98);
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
