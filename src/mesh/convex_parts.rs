//! The convex polygons that surfaces occlude and shine as: their parts, neighbours joined where the whole stays
//! convex (Hertel & Mehlhorn 1983), so that a wall of many triangles is a few polygons.

use super::regions::{Outline, Welder};
use crate::geometry::polygon;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::ops::Range;

/// A convex planar part of a region, whatever patches it is cut into.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPart {
    /// The region that it is a part of.
    pub region: u32,
    /// Its corners in [`ConvexParts::corners`], counter-clockwise from the front; three or more.
    pub corners: Range<u32>,
}

/// All convex parts of a scene, ordered by region.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConvexParts {
    /// Positions, metres.
    pub corners: Vec<DVec3>,
    /// The parts.
    pub parts: Vec<ConvexPart>,
}

impl ConvexParts {
    /// Corners of part `index`, metres.
    ///
    /// Panics if there is no such part.
    pub fn polygon(&self, index: usize) -> &[DVec3] {
        let range = &self.parts[index].corners;
        &self.corners[range.start as usize..range.end as usize]
    }

    /// Adds the parts of a region.
    pub(super) fn append(&mut self, region: u32, outline: &Outline) {
        let polygons: Vec<Vec<DVec2>> = outline.parts.iter().map(|part| part.corners.clone()).collect();
        for polygon in joined(polygons) {
            let start = self.corners.len() as u32;
            self.corners.extend(polygon.into_iter().map(|corner| outline.world(corner)));
            self.parts.push(ConvexPart { region, corners: start..self.corners.len() as u32 });
        }
    }
}

/// Joins convex counter-clockwise polygons along whole edges that two of them share.
fn joined(polygons: Vec<Vec<DVec2>>) -> Vec<Vec<DVec2>> {
    /// More than so many parts are left as they are, each: what has so many is no wall.
    const MOST: usize = 20_000;
    if polygons.len() < 2 || polygons.len() > MOST {
        return polygons;
    }
    let extent = polygons
        .iter()
        .flatten()
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &c| (low.min(c), high.max(c)));
    let size = (extent.1 - extent.0).length();
    let mut welder = Welder::new(1e-9 * size);
    let mut loops: Vec<Option<Vec<u32>>> = polygons
        .iter()
        .map(|polygon| Some(polygon.iter().map(|corner| welder.index(corner.extend(0.0))).collect()))
        .collect();
    let points: Vec<DVec2> = welder.points.iter().map(|p| p.truncate()).collect();
    // The polygon on the left of each directed edge.
    let mut left: HashMap<(u32, u32), usize> = HashMap::new();
    for (index, corners) in loops.iter().enumerate() {
        for edge in edges(corners.as_deref().unwrap_or(&[])) {
            left.insert(edge, index);
        }
    }
    // The longest shared edges first: they make the largest polygons.
    let mut shared: Vec<(f64, (u32, u32))> = left
        .keys()
        .filter(|&&(a, b)| a < b && left.contains_key(&(b, a)))
        .map(|&(a, b)| (points[a as usize].distance(points[b as usize]), (a, b)))
        .collect();
    shared.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    for (_, (a, b)) in shared {
        let (Some(&one), Some(&other)) = (left.get(&(a, b)), left.get(&(b, a))) else { continue };
        if one == other {
            continue;
        }
        let (Some(first), Some(second)) = (&loops[one], &loops[other]) else { continue };
        let Some(union) = union(first, second, (a, b), &points) else { continue };
        for edge in edges(second) {
            left.insert(edge, one);
        }
        left.remove(&(a, b));
        left.remove(&(b, a));
        loops[other] = None;
        loops[one] = Some(union);
    }
    loops.into_iter().flatten().map(|corners| without_flat(&corners, &points)).collect()
}

fn edges(corners: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

/// Two polygons that share the edge from `a` to `b` (in the first one's order) as one, where that is convex.
fn union(first: &[u32], second: &[u32], (a, b): (u32, u32), points: &[DVec2]) -> Option<Vec<u32>> {
    let at = first.iter().position(|&c| c == b)?;
    let from = second.iter().position(|&c| c == a)?;
    // The first from b round to a, then the second from behind a to before b.
    let mut all: Vec<u32> = (0..first.len()).map(|k| first[(at + k) % first.len()]).collect();
    all.extend((1..second.len() - 1).map(|k| second[(from + k) % second.len()]));
    let corners: Vec<DVec2> = all.iter().map(|&c| points[c as usize]).collect();
    polygon::is_convex(&corners, 1e-12 * polygon::area_2d(&corners).abs()).then_some(all)
}

/// The corners of a convex polygon without those that lie within its edges.
fn without_flat(corners: &[u32], points: &[DVec2]) -> Vec<DVec2> {
    let at = |k: usize| points[corners[k % corners.len()] as usize];
    let n = corners.len();
    let turns = |&k: &usize| {
        let (before, after) = (at(k) - at(k + n - 1), at(k + 1) - at(k));
        before.perp_dot(after).abs() > 1e-9 * before.length() * after.length()
    };
    let kept: Vec<DVec2> = (0..n).filter(turns).map(at).collect();
    if kept.len() >= 3 { kept } else { (0..n).map(at).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[(f64, f64)]) -> Vec<DVec2> {
        corners.iter().copied().map(DVec2::from).collect()
    }

    #[test]
    fn triangles_of_a_rectangle_become_one_polygon() {
        // Two squares of two triangles each, side by side.
        let parts = vec![
            polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]),
            polygon(&[(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)]),
            polygon(&[(1.0, 0.0), (2.0, 0.0), (2.0, 1.0)]),
            polygon(&[(1.0, 0.0), (2.0, 1.0), (1.0, 1.0)]),
        ];
        let joined = joined(parts);
        assert_eq!(joined.len(), 1);
        assert_eq!(joined[0].len(), 4, "{joined:?}");
        assert!((polygon::area_2d(&joined[0]) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_wall_round_a_window_keeps_its_hole() {
        // Eight triangles round a square hole.
        let (o, i) = (
            [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)],
            [(1.0, 1.0), (3.0, 1.0), (3.0, 3.0), (1.0, 3.0)],
        );
        let parts: Vec<Vec<DVec2>> = (0..4)
            .flat_map(|k| {
                let n = (k + 1) % 4;
                [polygon(&[o[k], o[n], i[n]]), polygon(&[o[k], i[n], i[k]])]
            })
            .collect();
        let joined = joined(parts);
        assert_eq!(joined.len(), 4);
        let area: f64 = joined.iter().map(|p| polygon::area_2d(p)).sum();
        assert!((area - 12.0).abs() < 1e-12, "{area}");
        for part in &joined {
            assert!(polygon::is_convex(part, 1e-12));
        }
    }
}
