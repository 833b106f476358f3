//! Which sides of which regions light can reach: the outside of a closed shell needs no patches.

use super::regions::Outline;
use super::types::Side;
use crate::geometry::{Bvh, Frame, Ray, polygon};
use crate::scene::{Scene, Sides};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Rays from each sampled point.
const RAYS: u32 = 64;
/// Points sampled on each side.
const POINTS: usize = 12;

/// For every region whether its front and its back take part.
pub(super) fn sides(scene: &Scene, outlines: &[Outline], size: f64) -> Vec<[bool; 2]> {
    let mut triangles = Vec::new();
    let mut owners = Vec::new();
    for (index, outline) in outlines.iter().enumerate() {
        for part in &outline.parts {
            for k in 1..part.corners.len() - 1 {
                triangles
                    .push([part.corners[0], part.corners[k], part.corners[k + 1]].map(|c| outline.world(c)));
                owners.push(index as u32);
            }
        }
    }
    let search = Search { outlines, bvh: Bvh::build(&triangles), owners, offset: size * 1e-6 };

    let allowed: Vec<[bool; 2]> = outlines
        .iter()
        .map(|o| match scene.materials[o.material as usize].sides {
            Sides::Auto | Sides::Both => [true, true],
            Sides::Front => [true, false],
        })
        .collect();
    let mut reached: Vec<[bool; 2]> =
        outlines.iter().map(|o| [o.luminaire.is_some(), o.luminaire.is_some() && o.emits_back]).collect();
    if !reached.iter().flatten().any(|&r| r) {
        // Without a lamp nothing is lit; every front is kept, so that there is something to see.
        reached.fill([true, false]);
    }

    // Forward from what is newly reached, then backward from what is not, until nothing changes.
    let mut frontier: Vec<(u32, Side)> = listed(&reached, true);
    loop {
        let seen: Vec<Vec<u32>> = frontier.par_iter().map(|&(r, side)| search.seen_from(r, side)).collect();
        let mut hits = vec![[0_u32; 2]; outlines.len()];
        for code in seen.into_iter().flatten() {
            hits[(code / 2) as usize][(code % 2) as usize] += 1;
        }
        let before = reached.clone();
        for (mark, count) in reached.iter_mut().zip(&hits) {
            // A single hit may be a ray that slipped through the seam of two faces.
            mark[0] |= count[0] >= 2;
            mark[1] |= count[1] >= 2;
        }
        let known = reached.clone();
        let backward: Vec<(u32, Side)> = listed(&reached, false)
            .into_par_iter()
            .filter(|&(r, side)| {
                allowed[r as usize][side as usize]
                    && search
                        .seen_from(r, side)
                        .into_iter()
                        .filter(|code| known[(code / 2) as usize][(code % 2) as usize])
                        .count()
                        >= 2
            })
            .collect();
        for (r, side) in backward {
            reached[r as usize][side as usize] = true;
        }
        frontier = (0..outlines.len() as u32)
            .flat_map(|r| [(r, Side::Front), (r, Side::Back)])
            .filter(|&(r, s)| reached[r as usize][s as usize] && !before[r as usize][s as usize])
            .collect();
        if frontier.is_empty() {
            break;
        }
    }
    for ((mark, allowed), outline) in reached.iter_mut().zip(&allowed).zip(outlines) {
        let forced = scene.materials[outline.material as usize].sides != Sides::Auto;
        for side in 0..2 {
            mark[side] = allowed[side] && (mark[side] || forced);
        }
        // A side that emits always takes part.
        mark[0] |= outline.luminaire.is_some();
        mark[1] |= outline.luminaire.is_some() && outline.emits_back;
    }
    reached
}

fn listed(reached: &[[bool; 2]], wanted: bool) -> Vec<(u32, Side)> {
    (0..reached.len() as u32)
        .flat_map(|r| [(r, Side::Front), (r, Side::Back)])
        .filter(|&(r, s)| reached[r as usize][s as usize] == wanted)
        .collect()
}

struct Search<'a> {
    outlines: &'a [Outline],
    bvh: Bvh,
    owners: Vec<u32>,
    offset: f64,
}

impl Search<'_> {
    /// Codes (2 * region + side) of the sides that rays from this side meet first.
    fn seen_from(&self, region: u32, side: Side) -> Vec<u32> {
        let outline = &self.outlines[region as usize];
        let normal = outline.frame.normal * side.sign();
        let frame = Frame::around(normal);
        let mut seen = Vec::new();
        for (k, point) in sample_points(outline).into_iter().enumerate() {
            let origin = outline.world(point) + normal * self.offset;
            for ray in 0..RAYS {
                let direction = frame.world(cosine_direction(ray, RAYS, 0.618_034 * k as f64));
                let ray = Ray { origin, direction };
                if let Some(hit) = self.bvh.nearest(&ray, 0.0, f64::INFINITY) {
                    let owner = self.owners[hit.triangle as usize];
                    let facing = self.outlines[owner as usize].frame.normal.dot(direction) < 0.0;
                    seen.push(2 * owner + u32::from(!facing));
                }
            }
        }
        seen
    }
}

/// Points inside the outline: triangles of its parts, spread by area.
fn sample_points(outline: &Outline) -> Vec<DVec2> {
    let mut points = Vec::with_capacity(POINTS);
    let step = outline.area / POINTS as f64;
    let mut due = 0.5 * step;
    let mut sum = 0.0;
    for part in &outline.parts {
        for k in 1..part.corners.len() - 1 {
            let [a, b, c] = [part.corners[0], part.corners[k], part.corners[k + 1]];
            let area = polygon::area_2d(&[a, b, c]);
            while due < sum + area && points.len() < POINTS {
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

/// The i-th of n directions with a cosine distribution about +z (Fibonacci spiral, turned).
pub(crate) fn cosine_direction(i: u32, n: u32, turn: f64) -> DVec3 {
    let along = (f64::from(i) + 0.5) / f64::from(n);
    let phi = std::f64::consts::TAU * (f64::from(i) * 0.618_033_988_749_894_9 + turn).fract();
    let radius = along.sqrt();
    DVec3::new(radius * phi.cos(), radius * phi.sin(), (1.0 - along).sqrt())
}
