//! Outlines of faces: their planes, and whether they touch or cross themselves.

use crate::geometry::{Aabb, Bvh, Frame, polygon};
use glam::{DVec2, DVec3};

/// Position, texture coordinate and normal of a corner, as indices into a file's lists.
pub(super) type Indices = (u32, Option<u32>, Option<u32>);

/// Below this ratio of area to squared size a polygon is a line.
const THINNEST: f64 = 1e-9;
/// In outlines with more corners only edges whose boxes meet are looked at.
const SMALL: usize = 64;
/// Pairs of edges looked at before an outline counts as crossed.
const MOST_PAIRS: usize = 4_000_000;
/// Edges that reach beyond each other by less than this share of the outline's size only touch.
const SHALLOW: f64 = 1e-4;

/// Without corners that stand twice in a row, and without spikes (there and back again).
pub(super) fn without_repetitions(corners: &[Indices]) -> Vec<Indices> {
    let mut kept: Vec<Indices> = Vec::with_capacity(corners.len());
    for &corner in corners {
        match kept[..] {
            [.., last] if last.0 == corner.0 => {}
            [.., before, _] if before.0 == corner.0 => _ = kept.pop(),
            _ => kept.push(corner),
        }
    }
    // The same across the seam between the last corner and the first.
    loop {
        match kept[..] {
            [first, .., last] if first.0 == last.0 => _ = kept.pop(),
            [first, .., before, _] if before.0 == first.0 && kept.len() > 2 => kept.truncate(kept.len() - 2),
            [_, second, .., last] if last.0 == second.0 && kept.len() > 2 => {
                kept.remove(0);
                kept.pop();
            }
            _ => return kept,
        }
    }
}

/// Unit normal and size (largest extent of the bounding box); `None` where there is no area.
pub(super) fn plane(outline: &[DVec3]) -> Option<(DVec3, f64)> {
    let size = extent(outline);
    let area = polygon::area_vector(outline);
    let normal = area.try_normalize()?;
    (area.length() > THINNEST * size * size).then_some((normal, size))
}

fn extent(outline: &[DVec3]) -> f64 {
    Aabb::around(outline.iter().copied()).size().length()
}

/// Normal of the widest triangle between the first corner and two others.
pub(super) fn widest_plane(outline: &[DVec3]) -> Option<DVec3> {
    let far = outline
        .iter()
        .map(|&p| p - outline[0])
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    let across = outline
        .iter()
        .map(|&p| far.cross(p - outline[0]))
        .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
    (across.length() > THINNEST * far.length_squared()).then(|| across.try_normalize()).flatten()
}

pub(super) fn in_plane(frame: &Frame, offset: DVec3) -> DVec2 {
    DVec2::new(offset.dot(frame.tangent), offset.dot(frame.bitangent))
}

/// Whether an outline neither touches nor crosses itself. Edges that reach beyond each other by less than
/// `tolerance`, metres, do not cross: a corner that lies on another edge of its face lies beside it by rounding.
pub(super) fn is_simple(corners: &[Indices], flat: &[DVec2], tolerance: f64) -> bool {
    let n = flat.len();
    if n == 3 || (n == 4 && polygon::is_convex(flat, 0.0)) {
        return true;
    }
    let mut positions: Vec<u32> = corners.iter().map(|c| c.0).collect();
    positions.sort_unstable();
    if positions.windows(2).any(|w| w[0] == w[1]) {
        return false;
    }
    let edge = |i: usize| [flat[i], flat[(i + 1) % n]];
    let bounds = Aabb::around(flat.iter().map(|p| p.extend(0.0)));
    let tolerance = tolerance.min(SHALLOW * bounds.size().length());
    // Edges next to each other share a corner and cannot cross.
    let cross =
        |i: usize, j: usize| j > i + 1 && (i > 0 || j < n - 1) && edges_cross(edge(i), edge(j), tolerance);
    if n <= SMALL {
        return !(0..n).any(|i| (i + 2..n).any(|j| cross(i, j)));
    }
    let flat_triangles: Vec<[DVec3; 3]> =
        (0..n).map(edge).map(|[a, b]| [a, b, b].map(|p| p.extend(0.0))).collect();
    let tree = Bvh::build(&flat_triangles);
    let mut pairs = 0;
    (0..n).all(|i| {
        let mut found = false;
        tree.touching(&Aabb::around(flat_triangles[i]), |j| {
            pairs += 1;
            found = found || cross(i, j as usize);
        });
        !found && pairs <= MOST_PAIRS
    })
}

/// Whether two edges cross, each reaching beyond the other by more than `tolerance` on both sides.
fn edges_cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2], tolerance: f64) -> bool {
    let straddles = |a: DVec2, b: DVec2, c: DVec2, d: DVec2| {
        let along = (b - a).normalize_or_zero();
        let (first, second) = (along.perp_dot(c - a), along.perp_dot(d - a));
        first.min(second) < -tolerance && first.max(second) > tolerance
    };
    straddles(a, b, c, d) && straddles(c, d, a, b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn is_simple_of(flat: &[DVec2]) -> bool {
        let corners: Vec<Indices> = (0..flat.len() as u32).map(|k| (k, None, None)).collect();
        is_simple(&corners, flat, 1e-5)
    }

    fn star(corners: usize, turns: usize) -> Vec<DVec2> {
        let angle = |k: usize| TAU * (k * turns) as f64 / corners as f64;
        (0..corners).map(|k| DVec2::from_angle(angle(k)) * 3.0).collect()
    }

    #[test]
    fn outlines_of_many_corners_are_looked_at_as_those_of_few() {
        for corners in [5, 64, 65, 2001, 20_001] {
            let mut round = star(corners, 1);
            assert!(is_simple_of(&round), "{corners} corners on a circle");
            round.swap(1, corners / 2);
            assert!(!is_simple_of(&round), "two of {corners} corners change places");
        }
        assert!(!is_simple_of(&star(65, 2)), "twice round");
        assert!(!is_simple_of(&star(5, 2)), "a pentagram");
    }

    #[test]
    fn a_corner_that_lies_on_another_edge_by_rounding_is_no_crossing() {
        for off in [-1e-9, 0.0, 1e-9] {
            let outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, off), (0.0, 1.0)].map(DVec2::from);
            assert!(is_simple_of(&outline), "{off}");
        }
        let crossed = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, -0.01), (0.0, 1.0)].map(DVec2::from);
        assert!(!is_simple_of(&crossed));
    }
}
