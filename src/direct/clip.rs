//! The part of a convex outline that convex occluders leave visible, as convex polygons.
//!
//! Everything is relative to the receiver at the origin, so that a polygon stands for the directions of its points
//! and an edge for the plane through it and the origin. Visibility is exact: nothing is sampled.

use crate::emitters::HalfSpace;
use glam::DVec3;

/// Working memory: polygons cut from an outline, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Clipper {
    fragments: Polygons,
    cut: Polygons,
    /// The occluder at hand.
    corners: Vec<DVec3>,
    planes: Vec<DVec3>,
    inside: Vec<DVec3>,
    rest: Vec<DVec3>,
    /// Twice the area of the outline above the horizon, m².
    extent: f64,
    /// Corners nearer to a plane than this lie on it, metres.
    on_plane: f64,
}

/// Polygons in one list of corners.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    corners: Vec<DVec3>,
    /// Where each ends.
    ends: Vec<u32>,
}

impl Polygons {
    pub(super) fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
    }

    fn push(&mut self, corners: &[DVec3]) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len() as u32);
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[DVec3]> {
        let mut start = 0;
        self.ends
            .iter()
            .map(move |&end| &self.corners[std::mem::replace(&mut start, end as usize)..end as usize])
    }

    fn truncate(&mut self, polygons: usize) {
        self.ends.truncate(polygons);
        self.corners.truncate(self.ends.last().map_or(0, |&end| end as usize));
    }
}

/// A plane through the origin runs through a corner that is nearer to it than this share of the farthest one's distance.
const ON_PLANE: f64 = 1e-12;
/// Among more fragments than so many, those of less than this share of the outline's area are left out.
const FEW: usize = 8;
const SLIVER: f64 = 1e-6;

impl Clipper {
    /// Begins with an outline and what of it lies above the horizon of a receiver with this normal.
    pub fn start(&mut self, outline: &[DVec3], normal: DVec3) {
        self.fragments.clear();
        self.inside.clear();
        let reach = outline.iter().map(|c| c.length_squared()).fold(0.0, f64::max);
        self.on_plane = ON_PLANE * reach.sqrt();
        split(outline, normal, self.on_plane, &mut self.inside, None);
        if self.inside.len() >= 3 {
            self.extent = extent(&self.inside);
            self.fragments.push(&self.inside);
        }
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.fragments.ends.is_empty()
    }

    /// How many polygons are left.
    pub fn count(&self) -> usize {
        self.fragments.ends.len()
    }

    /// What is left.
    pub fn fragments(&self) -> impl Iterator<Item = &[DVec3]> {
        self.fragments.iter()
    }

    /// Takes away what a convex flat occluder hides with its part inside of `limit`. Its corners run
    /// counter-clockwise as seen from where its unit normal `plane` points. It counts for nothing where the origin
    /// is nearer to its plane than `thickness`, metres.
    pub fn subtract(&mut self, occluder: &[DVec3], plane: DVec3, limit: HalfSpace, thickness: f64) {
        let height = plane.dot(occluder[0]);
        if height.abs() <= thickness || self.is_empty() {
            return;
        }
        // 1. Cut off what lies beyond the emitter.
        self.corners.clear();
        cut_off(occluder, limit, &mut self.corners);
        if self.corners.len() < 3 {
            return;
        }
        // 2. The planes through its edges, their normals inwards.
        self.planes.clear();
        edge_planes(&self.corners, height, &mut self.planes);
        // 3. What lies outside of one of them is seen.
        self.cut.clear();
        for fragment in self.fragments.iter() {
            let is_apart = |plane: &DVec3| fragment.iter().all(|c| plane.dot(*c) <= self.on_plane);
            if self.planes.iter().any(is_apart) {
                self.cut.push(fragment);
                continue;
            }
            let before = self.cut.ends.len();
            let mut left = &mut self.inside;
            left.clear();
            left.extend_from_slice(fragment);
            let mut other = &mut self.rest;
            for &plane in &self.planes {
                other.clear();
                split(left, plane, self.on_plane, other, Some(&mut self.cut));
                std::mem::swap(&mut left, &mut other);
                if left.len() < 3 {
                    break;
                }
            }
            if left.len() < 3 {
                // It hides nothing of this one, which stays whole.
                self.cut.truncate(before);
                self.cut.push(fragment);
            }
        }
        std::mem::swap(&mut self.fragments, &mut self.cut);
        if self.fragments.ends.len() > FEW {
            self.drop_slivers();
        }
    }

    /// Leaves out fragments too small to count.
    fn drop_slivers(&mut self) {
        self.cut.clear();
        for fragment in self.fragments.iter() {
            if extent(fragment) > SLIVER * self.extent {
                self.cut.push(fragment);
            }
        }
        std::mem::swap(&mut self.fragments, &mut self.cut);
    }
}

/// Twice the area of a polygon, m².
fn extent(corners: &[DVec3]) -> f64 {
    let Some((&first, rest)) = corners.split_first() else { return 0.0 };
    rest.windows(2).map(|e| (e[0] - first).cross(e[1] - first)).sum::<DVec3>().length()
}

/// The part of a convex polygon where `plane · x >= 0`; the rest is added to `outside`, where that is asked for.
pub(super) fn split(
    polygon: &[DVec3],
    plane: DVec3,
    on_plane: f64,
    inside: &mut Vec<DVec3>,
    outside: Option<&mut Polygons>,
) {
    let height = |c: DVec3| {
        let height = plane.dot(c);
        if height.abs() <= on_plane { 0.0 } else { height }
    };
    let n = polygon.len();
    let Some(&last) = polygon.last() else { return };
    let (mut p, mut hp) = (last, height(last));
    let (start, mut out) = match outside {
        Some(list) => (list.corners.len(), Some(list)),
        None => (0, None),
    };
    for &q in &polygon[..n] {
        let hq = height(q);
        if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
            let cut = p + (q - p) * (hp / (hp - hq));
            inside.push(cut);
            if let Some(list) = &mut out {
                list.corners.push(cut);
            }
        }
        if hq >= 0.0 {
            inside.push(q);
        }
        if hq <= 0.0
            && let Some(list) = &mut out
        {
            list.corners.push(q);
        }
        (p, hp) = (q, hq);
    }
    if let Some(list) = out {
        let is_polygon =
            list.corners.len() >= start + 3 && list.corners[start..].iter().any(|&c| height(c) < 0.0);
        match is_polygon {
            true => list.ends.push(list.corners.len() as u32),
            false => list.corners.truncate(start),
        }
    }
    if !inside.iter().any(|&c| height(c) > 0.0) {
        inside.clear();
    }
}

/// Adds the unit normals, inwards, of the planes through the origin and the edges of a polygon whose own plane is
/// `height` above the origin along the normal about which its corners run counter-clockwise.
pub(super) fn edge_planes(corners: &[DVec3], height: f64, planes: &mut Vec<DVec3>) {
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[if i + 1 == corners.len() { 0 } else { i + 1 }];
        let normal = if height < 0.0 { b.cross(a) } else { a.cross(b) };
        let length = normal.length();
        if length > 0.0 {
            planes.push(normal / length);
        }
    }
}

/// The part of a polygon inside a half-space.
pub(super) fn cut_off(polygon: &[DVec3], limit: HalfSpace, kept: &mut Vec<DVec3>) {
    let height = |c: DVec3| limit.normal.dot(c) - limit.offset;
    let Some(&last) = polygon.last() else { return };
    let (mut p, mut hp) = (last, height(last));
    for &q in polygon {
        let hq = height(q);
        if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
            kept.push(p + (q - p) * (hp / (hp - hq)));
        }
        if hq > 0.0 {
            kept.push(q);
        }
        (p, hp) = (q, hq);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emitters::lambert;

    const EVERYTHING: HalfSpace = HalfSpace { normal: DVec3::Z, offset: f64::NEG_INFINITY };

    fn square(half: f64, x: f64, y: f64, z: f64) -> Vec<DVec3> {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(u, v)| DVec3::new(x + u * half, y + v * half, z))
            .to_vec()
    }

    fn seen(clipper: &Clipper) -> f64 {
        clipper.fragments().map(|f| lambert(DVec3::Z, f)).sum()
    }

    #[test]
    fn what_is_hidden_and_what_is_left_make_the_whole() {
        let outline = square(1.0, 0.3, 0.1, 2.0);
        let whole = lambert(DVec3::Z, &outline);
        let mut clipper = Clipper::default();
        // At half the height an occluder hides the part of twice its size.
        let occluder = square(0.25, 0.2, 0.0, 1.0);
        clipper.start(&outline, DVec3::Z);
        clipper.subtract(&occluder, DVec3::NEG_Z, EVERYTHING, 1e-9);
        let hidden = lambert(DVec3::Z, &square(0.5, 0.4, 0.0, 2.0));
        assert!((seen(&clipper) + hidden - whole).abs() < 1e-14, "{} {hidden} {whole}", seen(&clipper));
        // The same again, or the other way round, hides nothing more.
        clipper.subtract(&occluder, DVec3::NEG_Z, EVERYTHING, 1e-9);
        let turned: Vec<DVec3> = occluder.iter().rev().copied().collect();
        clipper.subtract(&turned, DVec3::Z, EVERYTHING, 1e-9);
        assert!((seen(&clipper) + hidden - whole).abs() < 1e-14);
        // One that overlaps it in part.
        clipper.subtract(&square(0.25, 0.45, 0.0, 1.0), DVec3::NEG_Z, EVERYTHING, 1e-9);
        let both = hidden
            + lambert(
                DVec3::Z,
                &[(0.9, -0.5), (1.3, -0.5), (1.3, 0.5), (0.9, 0.5)].map(|(x, y)| DVec3::new(x, y, 2.0)),
            );
        assert!((seen(&clipper) + both - whole).abs() < 1e-14);
        clipper.subtract(&square(5.0, 0.0, 0.0, 1.5), DVec3::NEG_Z, EVERYTHING, 1e-9);
        assert!(clipper.is_empty());
    }

    #[test]
    fn beyond_the_emitter_beside_it_and_below_the_horizon_nothing_hides() {
        let outline = square(1.0, 0.0, 0.0, 2.0);
        let whole = lambert(DVec3::Z, &outline);
        let mut clipper = Clipper::default();
        clipper.start(&outline, DVec3::Z);
        let limit = HalfSpace { normal: DVec3::NEG_Z, offset: -2.0 };
        clipper.subtract(&square(3.0, 0.0, 0.0, 2.5), DVec3::NEG_Z, limit, 1e-9);
        clipper.subtract(&square(0.5, 2.0, 0.0, 1.0), DVec3::NEG_Z, limit, 1e-9);
        clipper.subtract(&square(3.0, 0.0, 0.0, -1.0), DVec3::NEG_Z, limit, 1e-9);
        // Through the origin.
        clipper.subtract(&square(3.0, 0.0, 0.0, 0.0), DVec3::NEG_Z, limit, 1e-9);
        assert_eq!(clipper.count(), 1);
        assert_eq!(seen(&clipper), whole);
        // A wall that reaches from below the horizon to behind the emitter hides half of it.
        let wall =
            [(-9.0, -1.0), (9.0, -1.0), (9.0, 9.0), (-9.0, 9.0)].map(|(y, z)| DVec3::new(0.001 * z, y, z));
        let normal = DVec3::new(1.0, 0.0, -0.001).normalize();
        clipper.subtract(&wall, normal, limit, 1e-12);
        assert!((seen(&clipper) - whole).abs() < 1e-9, "edge on: {}", seen(&clipper));
        // The horizon cuts the outline itself.
        clipper.start(&square(1.0, 0.0, 0.0, 2.0), DVec3::X);
        let upper = [(0.0, -1.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, y)| DVec3::new(x, y, 2.0));
        let sideways: f64 = clipper.fragments().map(|f| lambert(DVec3::X, f)).sum();
        assert!((sideways - lambert(DVec3::X, &upper)).abs() < 1e-14);
        assert!(clipper.fragments().flatten().all(|c| c.x >= -1e-12));
    }

    #[test]
    fn random_occluders_agree_with_rays() {
        let outline = square(1.0, 0.4, -0.2, 3.0);
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut clipper = Clipper::default();
        for _ in 0..40 {
            let triangles: Vec<[DVec3; 3]> = (0..6)
                .map(|_| {
                    std::array::from_fn(|_| {
                        DVec3::new(3.0 * next() - 1.2, 3.0 * next() - 1.5, 0.4 + 2.2 * next())
                    })
                })
                .collect();
            clipper.start(&outline, DVec3::Z);
            for t in &triangles {
                let plane = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
                clipper.subtract(t, plane, HalfSpace { normal: DVec3::NEG_Z, offset: -3.0 }, 1e-9);
            }
            // A grid of rays over the outline.
            let n = 200;
            let mut sum = 0.0;
            for i in 0..n * n {
                let (u, v) = (f64::from(i % n) + 0.5, f64::from(i / n) + 0.5);
                let p = DVec3::new(0.4 - 1.0 + 2.0 * u / f64::from(n), -1.2 + 2.0 * v / f64::from(n), 3.0);
                let is_hidden = triangles.iter().any(|t| {
                    let s = [t[0].cross(t[1]).dot(p), t[1].cross(t[2]).dot(p), t[2].cross(t[0]).dot(p)];
                    s.iter().all(|&x| x > 0.0) || s.iter().all(|&x| x < 0.0)
                });
                if !is_hidden {
                    let r2 = p.length_squared();
                    sum += 3.0 * 3.0 / (r2 * r2) / std::f64::consts::PI * 4.0 / f64::from(n * n);
                }
            }
            assert!(
                (seen(&clipper) - sum).abs() < 3e-3 * lambert(DVec3::Z, &outline),
                "{} {sum}",
                seen(&clipper)
            );
        }
    }
}
