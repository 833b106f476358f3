//! Faces that cut through each other, or cover one another in one plane.

use super::survey::{Plane, Survey};
use crate::geometry::{Frame, polygon};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Pairs of neighbouring faces looked at before the search is given up.
const MOST_PAIRS: usize = 20_000_000;
/// Faces between two looks at how many pairs there were.
const CHUNK: usize = 4096;
/// Corners nearer to a plane than this share of the scene's diagonal lie in it.
const IN_PLANE: f64 = 1e-6;
/// The same for faces that are asked whether one covers the other.
const COPLANAR: f64 = 1e-5;
/// Shorter cuts than this share of the diagonal are touches.
const SHORTEST_CUT: f64 = 1e-5;
/// Of the smaller face less than this share covered is a touch.
const LEAST_COVER: f64 = 1e-3;

/// Two faces that cut through each other, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Indices into the scene's surfaces, the lower one first.
    pub faces: [u32; 2],
    /// The segment that both have in common, metres.
    pub segment: [DVec3; 2],
}

/// What was found between pairs of faces.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    pub(super) crossings: Vec<Crossing>,
    /// Faces that face the same way in one plane and cover one another, the lower index first.
    pub(super) overlaps: Vec<[u32; 2]>,
    /// Faces that were looked at, where not all were.
    pub(super) ended_at: Option<usize>,
}

/// Looks at all pairs of faces whose boxes meet.
pub(super) fn search(survey: &Survey<'_>) -> Pairs {
    let (mut pairs, mut looked_at) = (Pairs::default(), 0);
    let count = survey.planes.len();
    for start in (0..count).step_by(CHUNK) {
        if looked_at > MOST_PAIRS {
            pairs.ended_at = Some(start);
            break;
        }
        let found: Vec<(Pairs, usize)> = (start..(start + CHUNK).min(count))
            .into_par_iter()
            .map(|face| partners(survey, face as u32))
            .collect();
        for (found, seen) in found {
            pairs.crossings.extend(found.crossings);
            pairs.overlaps.extend(found.overlaps);
            looked_at += seen;
        }
    }
    pairs
}

/// What a face has in common with those of higher index, and how many were looked at.
fn partners(survey: &Survey<'_>, face: u32) -> (Pairs, usize) {
    let mut near = Vec::new();
    for &[a, b, c] in survey.triangles_of(face) {
        let bounds = crate::geometry::Aabb::around([a, b, c]).grown(COPLANAR * survey.diagonal);
        survey.bvh.touching(&bounds, |triangle| {
            let other = survey.owners[triangle as usize];
            if other > face {
                near.push(other);
            }
        });
    }
    near.sort_unstable();
    near.dedup();
    let mut pairs = Pairs::default();
    for &other in &near {
        if overlap(survey, face, other) {
            pairs.overlaps.push([face, other]);
        } else {
            pairs.crossings.extend(cuts(survey, face, other));
        }
    }
    (pairs, near.len())
}

/// Whether two faces look the same way in one plane and one covers a part of the other.
fn overlap(survey: &Survey<'_>, a: u32, b: u32) -> bool {
    let (plane, other) = (&survey.planes[a as usize], &survey.planes[b as usize]);
    if plane.normal.dot(other.normal) < 0.99 {
        return false;
    }
    let tolerance = COPLANAR * survey.diagonal;
    let lies_in = |plane: &Plane, face: u32| {
        survey.outline(face).iter().all(|&p| plane.height(p).abs() <= tolerance + plane.bend)
    };
    if !lies_in(plane, b) || !lies_in(other, a) {
        return false;
    }
    let frame = Frame::around(plane.normal);
    let flat = |&[p, q, r]: &[DVec3; 3]| {
        [p, q, r].map(|p| p - plane.point).map(|p| DVec2::new(p.dot(frame.tangent), p.dot(frame.bitangent)))
    };
    let own: Vec<[DVec2; 3]> = survey.triangles_of(a).iter().map(flat).collect();
    let needed = LEAST_COVER * plane.area.min(other.area);
    let mut covered = 0.0;
    for triangle in survey.triangles_of(b).iter().map(flat) {
        for mine in &own {
            covered += common_area(mine, &triangle);
            if covered > needed {
                return true;
            }
        }
    }
    false
}

/// Area that two triangles have in common (Sutherland & Hodgman 1974).
fn common_area(a: &[DVec2; 3], b: &[DVec2; 3]) -> f64 {
    let sign = polygon::area_2d(b).signum();
    let (mut shape, mut clipped) = (a.to_vec(), Vec::new());
    for k in 0..3 {
        let along = (b[(k + 1) % 3] - b[k]) * sign;
        let inwards = along.perp();
        polygon::clip_2d(&shape, inwards, -inwards.dot(b[k]), &mut clipped);
        std::mem::swap(&mut shape, &mut clipped);
        if shape.len() < 3 {
            return 0.0;
        }
    }
    polygon::area_2d(&shape).abs()
}

/// The segments along which two faces cut through each other. Faces that only touch do not.
fn cuts(survey: &Survey<'_>, a: u32, b: u32) -> Vec<Crossing> {
    let (plane, other) = (&survey.planes[a as usize], &survey.planes[b as usize]);
    let direction = plane.normal.cross(other.normal);
    if direction.length_squared() < 1e-12 {
        return Vec::new();
    }
    let direction = direction.normalize();
    let tolerance = IN_PLANE * survey.diagonal + plane.bend + other.bend;
    let (own, others) = (survey.outline(a), survey.outline(b));
    let Some(mine) = intervals(own, other, direction, tolerance) else { return Vec::new() };
    let Some(theirs) = intervals(others, plane, direction, tolerance) else { return Vec::new() };
    // A point of both planes, to place the intervals by.
    let origin = {
        let along = other.normal.reject_from_normalized(plane.normal);
        let slope = along.dot(other.normal);
        plane.point - along * (other.height(plane.point) / slope)
    };
    let shortest = SHORTEST_CUT * survey.diagonal;
    let mut found = Vec::new();
    for &[from, to] in &mine {
        for &[start, end] in &theirs {
            let (low, high) = (from.max(start), to.min(end));
            if high - low > shortest {
                let at = |t: f64| origin + direction * (t - origin.dot(direction));
                found.push(Crossing { faces: [a, b], segment: [at(low), at(high)] });
            }
        }
    }
    found
}

/// Where an outline lies on both sides of a plane: the intervals that the plane cuts out of it, as
/// distances along `direction`. `None` where it stays on one side.
fn intervals(outline: &[DVec3], plane: &Plane, direction: DVec3, tolerance: f64) -> Option<Vec<[f64; 2]>> {
    let heights: Vec<f64> = outline.iter().map(|&p| plane.height(p)).collect();
    let above = heights.iter().any(|&h| h > tolerance);
    let below = heights.iter().any(|&h| h < -tolerance);
    if !above || !below {
        return None;
    }
    let n = outline.len();
    let mut places: Vec<f64> = (0..n)
        .filter_map(|k| {
            let (h, next) = (heights[k], heights[(k + 1) % n]);
            let share = h / (h - next);
            ((h > 0.0) != (next > 0.0)).then(|| outline[k].lerp(outline[(k + 1) % n], share).dot(direction))
        })
        .collect();
    places.sort_by(f64::total_cmp);
    Some(places.as_chunks::<2>().0.to_vec())
}
