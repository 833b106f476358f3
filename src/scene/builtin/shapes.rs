//! Shapes of which the embedded scenes are made. All fronts face outwards unless said otherwise.

use super::writer::Model;
use crate::geometry::Frame;
use crate::geometry::polygon::{area_vector, triangulate};
use glam::{DVec2, DVec3, dvec3};
use std::f64::consts::{PI, TAU};

/// Which faces of a block are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Faces(u8);

impl Faces {
    /// Towards -x.
    pub(crate) const LEFT: Self = Self(1);
    /// Towards +x.
    pub(crate) const RIGHT: Self = Self(2);
    /// Towards -y.
    pub(crate) const BOTTOM: Self = Self(4);
    /// Towards +y.
    pub(crate) const TOP: Self = Self(8);
    /// Towards -z.
    pub(crate) const BACK: Self = Self(16);
    /// Towards +z.
    pub(crate) const FRONT: Self = Self(32);
    /// All six.
    pub(crate) const ALL: Self = Self(63);
    /// All but the bottom: a block that stands on something.
    pub(crate) const STANDING: Self = Self::ALL.without(Self::BOTTOM);
    /// The four upright ones: a leg between a floor and a top.
    pub(crate) const UPRIGHT: Self = Self::STANDING.without(Self::TOP);

    /// All but the front and the back: the rim of a slab on a wall.
    pub(crate) const AROUND: Self = Self::ALL.without(Self::FRONT).without(Self::BACK);

    /// These without those.
    pub(crate) const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// These and those.
    pub(crate) const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    fn has(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// An opening in a flat panel, in the panel's own coordinates: from u0 to u1 and from v0 to v1.
pub(crate) type Hole = [f64; 4];

impl Model {
    /// A parallelogram with corner `origin` and edges `u`, `v`; its front is towards `u x v`.
    pub(crate) fn quad(&mut self, origin: DVec3, u: DVec3, v: DVec3) {
        self.polygon(&[origin, origin + u, origin + u + v, origin + v]);
    }

    /// A rectangle `width` along the unit vector `u` and `height` along `v` around openings, in
    /// rectangles that do not overlap.
    pub(crate) fn panel(
        &mut self,
        origin: DVec3,
        (u, width): (DVec3, f64),
        (v, height): (DVec3, f64),
        holes: &[Hole],
    ) {
        let strips = around_holes(width, height, holes);
        for strip in &strips {
            let corners: Vec<_> = conforming(strip, &strips).map(|[s, t]| origin + u * s + v * t).collect();
            self.polygon(&corners);
        }
    }

    /// An upright wall from `origin` for `length` along the horizontal unit vector `along`; its
    /// front is towards `along x y`.
    pub(crate) fn wall(&mut self, origin: DVec3, along: DVec3, length: f64, height: f64, holes: &[Hole]) {
        self.panel(origin, (along, length), (DVec3::Y, height), holes);
    }

    /// A block between two corners.
    pub(crate) fn block(&mut self, min: [f64; 3], max: [f64; 3], faces: Faces) {
        let (a, b) = (DVec3::from(min), DVec3::from(max));
        let (dx, dy, dz) = ((b.x - a.x) * DVec3::X, (b.y - a.y) * DVec3::Y, (b.z - a.z) * DVec3::Z);
        if faces.has(Faces::LEFT) {
            self.quad(a, dz, dy);
        }
        if faces.has(Faces::RIGHT) {
            self.quad(b - dy, -dz, dy);
        }
        if faces.has(Faces::BOTTOM) {
            self.quad(a, dx, dz);
        }
        if faces.has(Faces::TOP) {
            self.quad(a + dy + dz, dx, -dz);
        }
        if faces.has(Faces::BACK) {
            self.quad(a + dx, -dx, dy);
        }
        if faces.has(Faces::FRONT) {
            self.quad(a + dz, dx, dy);
        }
    }

    /// A hollow seen from above: four walls and a bottom that face inwards, open at the top.
    pub(crate) fn basin(&mut self, min: [f64; 3], max: [f64; 3], slope: f64) {
        let (a, b) = (DVec3::from(min), DVec3::from(max));
        let rim = rectangle([a.x, a.z], [b.x, b.z], b.y);
        let floor = rectangle([a.x + slope, a.z + slope], [b.x - slope, b.z - slope], a.y);
        for k in 0..4 {
            let next = (k + 1) % 4;
            self.polygon(&[rim[k], rim[next], floor[next], floor[k]]);
        }
        self.polygon(&floor);
    }

    /// A block without a bottom whose upper edges are bevelled: cushions and mattresses.
    pub(crate) fn cushion(&mut self, min: [f64; 3], max: [f64; 3], bevel: f64) {
        let (a, b) = (DVec3::from(min), DVec3::from(max));
        let low = rectangle([a.x, a.z], [b.x, b.z], a.y);
        let mid = rectangle([a.x, a.z], [b.x, b.z], b.y - bevel);
        let top = rectangle([a.x + bevel, a.z + bevel], [b.x - bevel, b.z - bevel], b.y);
        for k in 0..4 {
            let next = (k + 1) % 4;
            self.polygon(&[low[k], low[next], mid[next], mid[k]]);
            self.polygon(&[mid[k], mid[next], top[next], top[k]]);
        }
        self.polygon(&top);
    }

    /// A bar of square section from `a` to `b`, without its ends.
    pub(crate) fn bar(&mut self, a: DVec3, b: DVec3, thickness: f64) {
        let axis = (b - a).normalize();
        let side = axis.cross(if axis.y.abs() > 0.9 { DVec3::X } else { DVec3::Y }).normalize();
        let up = side.cross(axis);
        let ring = [side + up, -side + up, -side - up, side - up].map(|d| d * (0.5 * thickness));
        for k in 0..4 {
            let (p, q) = (ring[k], ring[(k + 1) % 4]);
            self.polygon(&[a + q, a + p, b + p, b + q]);
        }
    }

    /// A bar of square section along a bent line in one plane, mitred at its bends, without its ends;
    /// the first lies in the plane through the line's start at right angles to `ends[0]`, the last
    /// likewise. Returns the corners of the last end as a face that looks out of the bar.
    pub(crate) fn pipe(&mut self, line: &[DVec3], thickness: f64, ends: [DVec3; 2]) -> [DVec3; 4] {
        let along: Vec<DVec3> = line.windows(2).map(|w| (w[1] - w[0]).normalize()).collect();
        let bend = along.windows(2).map(|w| w[0].cross(w[1])).find(|c| c.length() > 1e-6);
        let side = bend.unwrap_or_else(|| along[0].any_orthogonal_vector()).normalize();
        let cut = |k: usize| match k {
            0 => ends[0],
            k if k == along.len() => ends[1],
            k => along[k - 1] + along[k],
        };
        let ring = |k: usize, axis: DVec3| {
            let up = side.cross(axis);
            [side + up, -side + up, -side - up, side - up].map(|corner| {
                let offset = corner * (0.5 * thickness);
                line[k] + offset - axis * (offset.dot(cut(k)) / axis.dot(cut(k)))
            })
        };
        for (k, &axis) in along.iter().enumerate() {
            let (near, far) = (ring(k, axis), ring(k + 1, axis));
            for c in 0..4 {
                let next = (c + 1) % 4;
                self.polygon(&[near[next], near[c], far[c], far[next]]);
            }
        }
        let [a, b, c, d] = ring(along.len(), along[along.len() - 1]);
        [d, c, b, a]
    }

    /// A regular polygon of `sides` corners around `centre`, facing up or down.
    pub(crate) fn disc(&mut self, centre: DVec3, radius: f64, sides: usize, up: bool) {
        let mut corners: Vec<_> = (0..sides).map(|k| centre + radius * spoke(k, sides)).collect();
        if up {
            corners.reverse();
        }
        self.polygon(&corners);
    }

    /// A flat polygon with polygonal holes, as triangles: what things stand on, cut out under them,
    /// so that a closed scene has no hidden surfaces. The front is that of `outline`; the holes lie
    /// inside it, in any order of corners.
    pub(crate) fn pierced(&mut self, outline: &[DVec3], holes: &[Vec<DVec3>]) {
        let normal = area_vector(outline).normalize();
        let frame = Frame::around(normal);
        let flat = |p: &DVec3| frame.local(*p).truncate();
        let outer: Vec<DVec2> = outline.iter().map(flat).collect();
        let inner: Vec<Vec<DVec2>> = holes.iter().map(|h| h.iter().map(flat).collect()).collect();
        let corners: Vec<DVec3> = outline.iter().chain(holes.iter().flatten()).copied().collect();
        for triangle in triangulate(&outer, &inner) {
            let mut triangle = triangle.map(|k| corners[k as usize]);
            if area_vector(&triangle).dot(normal) < 0.0 {
                triangle.swap(1, 2);
            }
            self.polygon(&triangle);
        }
    }

    /// A horizontal square of half edge `half` around `centre` with a round hole, of `sides` corners
    /// (a multiple of eight), for a column that stands on it or carries it; facing up or down.
    pub(crate) fn collar(&mut self, centre: DVec3, half: f64, radius: f64, sides: usize, up: bool) {
        let corner = |k: usize| {
            let angle = TAU * (k as f64 + 0.5) / 4.0;
            centre + half * dvec3(angle.cos().signum(), 0.0, angle.sin().signum())
        };
        let quarter = sides / 4;
        for k in 0..4 {
            // From a corner along the edge to the next one, and back along the hole.
            let first = k * quarter + quarter / 2;
            let mut outline = vec![corner(k), corner((k + 1) % 4)];
            outline.extend((0..=quarter).rev().map(|i| centre + radius * spoke((first + i) % sides, sides)));
            if up {
                outline.reverse();
            }
            self.polygon(&outline);
        }
    }

    /// The surface of revolution about the vertical through `centre` of a profile of (radius,
    /// height) pairs, with smooth normals except where the profile bends by more than 40 degrees.
    /// A profile that runs upwards faces outwards, one that runs downwards inwards.
    pub(crate) fn lathe(&mut self, centre: DVec3, profile: &[(f64, f64)], sides: usize) {
        let flat: Vec<_> = profile
            .windows(2)
            .map(|w| {
                let (dr, dy) = (w[1].0 - w[0].0, w[1].1 - w[0].1);
                let length = dr.hypot(dy);
                (dy / length, -dr / length)
            })
            .collect();
        let smooth = |k: usize, neighbour: Option<&(f64, f64)>| {
            let (own, limit) = (flat[k], 40_f64.to_radians().cos());
            match neighbour {
                Some(n) if own.0 * n.0 + own.1 * n.1 > limit => {
                    let (r, y) = (own.0 + n.0, own.1 + n.1);
                    (r / r.hypot(y), y / r.hypot(y))
                }
                _ => own,
            }
        };
        for k in 0..flat.len() {
            let low = smooth(k, k.checked_sub(1).map(|j| &flat[j]));
            let high = smooth(k, flat.get(k + 1));
            for i in 0..sides {
                let corner = |step: usize, (r, y): (f64, f64), n: (f64, f64)| {
                    let out = spoke((i + step) % sides, sides);
                    (centre + r * out + y * DVec3::Y, n.0 * out + n.1 * DVec3::Y)
                };
                let mut corners = Vec::with_capacity(4);
                if profile[k].0 > 0.0 {
                    corners.push(corner(1, profile[k], low));
                }
                corners.push(corner(0, profile[k], low));
                corners.push(corner(0, profile[k + 1], high));
                if profile[k + 1].0 > 0.0 {
                    corners.push(corner(1, profile[k + 1], high));
                }
                self.smooth_polygon(&corners);
            }
        }
    }

    /// A ball of `rings` bands and `sides` facets around.
    pub(crate) fn ball(&mut self, centre: DVec3, radius: f64, rings: usize, sides: usize) {
        self.lathe(centre, &sphere(radius, rings), sides);
    }
}

/// Profile of a ball of `rings` bands, from its lowest point up, for [`Model::lathe`].
pub(crate) fn sphere(radius: f64, rings: usize) -> Vec<(f64, f64)> {
    let at = |k: usize| {
        let polar = PI * k as f64 / rings as f64;
        let r = if k == 0 || k == rings { 0.0 } else { radius * polar.sin() };
        (r, -radius * polar.cos())
    };
    (0..=rings).map(at).collect()
}

/// Corners of a square of half edge `half` around `centre`, turned by `turn_deg` as
/// [`Model::place`] turns.
pub(crate) fn square(centre: DVec3, half: f64, turn_deg: f64) -> Vec<DVec3> {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let corners = [(-half, half), (half, half), (half, -half), (-half, -half)];
    corners.map(|(x, z)| centre + dvec3(x * cos + z * sin, 0.0, z * cos - x * sin)).to_vec()
}

/// Corners of a regular polygon around `centre` in a horizontal plane, as those of a lathe.
pub(crate) fn circle(centre: DVec3, radius: f64, sides: usize) -> Vec<DVec3> {
    (0..sides).map(|k| centre + radius * spoke(k, sides)).collect()
}

/// Unit vector in the horizontal plane to the k-th of `sides` corners.
fn spoke(k: usize, sides: usize) -> DVec3 {
    let angle = TAU * k as f64 / sides as f64;
    dvec3(angle.cos(), 0.0, angle.sin())
}

/// Corners at height y, counter-clockwise as seen from above.
pub(crate) fn rectangle(min: [f64; 2], max: [f64; 2], y: f64) -> [DVec3; 4] {
    [dvec3(min[0], y, max[1]), dvec3(max[0], y, max[1]), dvec3(max[0], y, min[1]), dvec3(min[0], y, min[1])]
}

/// Corners of a rectangle, and between them those of others that lie on its upright sides: the
/// neighbours then share whole edges.
fn conforming(rectangle: &Hole, others: &[Hole]) -> impl Iterator<Item = [f64; 2]> {
    let [u0, u1, v0, v1] = *rectangle;
    let stops = |u: f64| {
        let beside = others.iter().filter(move |o| [o[0], o[1]].iter().any(|e| (e - u).abs() < 1e-9));
        let mut stops: Vec<f64> =
            beside.flat_map(|o| [o[2], o[3]]).filter(|v| *v > v0 + 1e-9 && *v < v1 - 1e-9).collect();
        stops.sort_by(f64::total_cmp);
        stops.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        stops
    };
    let right = stops(u1).into_iter().map(move |v| [u1, v]);
    let left = stops(u0).into_iter().rev().map(move |v| [u0, v]);
    [[u0, v0], [u1, v0]].into_iter().chain(right).chain([[u1, v1], [u0, v1]]).chain(left)
}

/// The rectangle `width` x `height` less some openings, as rectangles u0, u1, v0, v1.
fn around_holes(width: f64, height: f64, holes: &[Hole]) -> Vec<Hole> {
    let mut cuts: Vec<f64> = holes.iter().flat_map(|h| [h[0], h[1]]).chain([0.0, width]).collect();
    cuts.retain(|&c| (0.0..=width).contains(&c));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let mut out: Vec<Hole> = Vec::new();
    let mut last_gaps: Vec<[f64; 2]> = Vec::new();
    for pair in cuts.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let mut over: Vec<_> = holes.iter().filter(|h| h[0] < middle && middle < h[1]).collect();
        over.sort_by(|a, b| a[2].total_cmp(&b[2]));
        let mut gaps = Vec::new();
        let mut from = 0.0;
        for hole in over {
            if hole[2] > from + 1e-9 {
                gaps.push([from, hole[2]]);
            }
            from = hole[3].max(from);
        }
        if height > from + 1e-9 {
            gaps.push([from, height]);
        }
        if gaps == last_gaps {
            // The same strips as beside: widen those instead of starting new ones.
            let strips = out.len() - gaps.len()..;
            out[strips].iter_mut().for_each(|strip| strip[1] = pair[1]);
        } else {
            out.extend(gaps.iter().map(|g| [pair[0], pair[1], g[0], g[1]]));
            last_gaps = gaps;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panel_area_is_that_of_the_rectangle_less_its_holes() {
        let holes = [[0.5, 1.0, 0.0, 2.0], [1.5, 2.5, 0.9, 2.0], [1.7, 1.9, 2.2, 2.3]];
        let strips = around_holes(3.0, 2.5, &holes);
        let area: f64 = strips.iter().map(|s| (s[1] - s[0]) * (s[3] - s[2])).sum();
        assert!((area - (7.5 - 1.0 - 1.1 - 0.02)).abs() < 1e-12, "area {area}");
        for (i, a) in strips.iter().enumerate() {
            for b in &strips[i + 1..] {
                let overlap =
                    (a[1].min(b[1]) - a[0].max(b[0])).max(0.0) * (a[3].min(b[3]) - a[2].max(b[2])).max(0.0);
                assert!(overlap < 1e-12, "{a:?} overlaps {b:?}");
            }
        }
    }
}
