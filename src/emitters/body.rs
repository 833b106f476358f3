use super::{Emitter, HalfSpace};
use crate::geometry::{Aabb, Frame, polygon};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// A closed convex body that shines evenly on all of its faces, such as a globe: from anywhere its outline is one
/// convex polygon of the radiance of its faces, however many there are.
#[derive(Clone, Debug)]
pub struct ConvexBody {
    corners: Vec<DVec3>,
    middle: DVec3,
    /// Plane of each face: unit normal outwards, and its offset from the origin.
    faces: Vec<(DVec3, f64)>,
    /// Each edge once: its corners, and the faces on its left and right as seen from outside.
    edges: Vec<([u32; 2], [u32; 2])>,
    /// In rising order.
    regions: Vec<u32>,
}

/// Corners may lie so far outside of a face, of the body's size: rounding of the file.
const FLAT: f64 = 1e-4;
/// A body may be so many times as long as it is wide: what lies beside a longer one is not told from what lies
/// before it by the plane through its middle.
const LONGEST: f64 = 2.5;

impl ConvexBody {
    /// A body of these faces, counter-clockwise as seen from outside, with the region of each. `None` where they
    /// do not close one convex body, or where it is long and thin.
    pub fn new(faces: &[(Vec<DVec3>, u32)]) -> Option<Self> {
        if faces.len() < 4 {
            return None;
        }
        let bounds = Aabb::around(faces.iter().flat_map(|face| face.0.iter().copied()));
        let size = bounds.diagonal();
        if bounds.size().max_element() > LONGEST * bounds.size().min_element() {
            return None;
        }
        let mut index_of: HashMap<[i64; 3], u32> = HashMap::new();
        let mut corners = Vec::new();
        let mut index = |corner: DVec3| {
            let key = ((corner - bounds.min) / (1e-6 * size)).round().to_array().map(|x| x as i64);
            *index_of.entry(key).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            })
        };
        let mut left: HashMap<[u32; 2], u32> = HashMap::new();
        let mut planes = Vec::with_capacity(faces.len());
        for (f, (polygon, _)) in faces.iter().enumerate() {
            let normal = polygon::area_vector(polygon).normalize_or_zero();
            planes.push((normal, normal.dot(polygon[0])));
            let ids: Vec<u32> = polygon.iter().map(|&corner| index(corner)).collect();
            for k in 0..ids.len() {
                let edge = [ids[k], ids[(k + 1) % ids.len()]];
                if edge[0] != edge[1] && left.insert(edge, f as u32).is_some() {
                    return None;
                }
            }
        }
        let mut edges = Vec::with_capacity(left.len() / 2);
        for (&[a, b], &on_left) in &left {
            let &on_right = left.get(&[b, a])?;
            if a < b {
                edges.push(([a, b], [on_left, on_right]));
            }
        }
        edges.sort_unstable();
        let is_inside = |&(normal, offset): &(DVec3, f64)| {
            corners.iter().all(|corner| normal.dot(*corner) <= offset + FLAT * size)
        };
        if !planes.iter().all(is_inside) {
            return None;
        }
        let mut regions: Vec<u32> = faces.iter().map(|face| face.1).collect();
        regions.sort_unstable();
        regions.dedup();
        Some(Self { middle: bounds.centre(), corners, faces: planes, edges, regions })
    }
}

impl ConvexBody {
    /// Fills `outline` with the corners that the edges lead round, relative to a point; whether they make one loop.
    fn follow(&self, next: &mut [(u32, u32)], from: DVec3, outline: &mut Vec<DVec3>) -> bool {
        next.sort_unstable();
        let start = next[0].0;
        let mut at = start;
        while outline.len() < next.len() {
            outline.push(self.corners[at as usize] - from);
            let Some(edge) = next.get(next.partition_point(|&(a, _)| a < at)).filter(|e| e.0 == at) else {
                return false;
            };
            at = edge.1;
            if at == start {
                break;
            }
        }
        at == start && outline.len() == next.len() && outline.len() >= 3
    }

    /// As [`Self::follow`], where rounding has left faces that are seen among some that are not: the convex hull of
    /// all corners as seen from the point (Andrew 1979).
    fn wrap(&self, from: DVec3, outline: &mut Vec<DVec3>) {
        outline.clear();
        let frame = Frame::around((self.middle - from).normalize_or(DVec3::Z));
        let mut seen: Vec<(DVec2, DVec3)> = self
            .corners
            .iter()
            .map(|&corner| corner - from)
            .filter(|corner| frame.normal.dot(*corner) > 0.0)
            .map(|corner| {
                let local = frame.local(corner);
                (local.truncate() / local.z, corner)
            })
            .collect();
        seen.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.0.y.total_cmp(&b.0.y)));
        // Looked at from behind the frame's plane, corners run clockwise.
        for pass in 0..2 {
            let mut chain: Vec<(DVec2, DVec3)> = Vec::new();
            let mut add = |entry: (DVec2, DVec3)| {
                while let [.., a, b] = chain[..]
                    && (b.0 - a.0).perp_dot(entry.0 - b.0) >= 0.0
                {
                    chain.pop();
                }
                chain.push(entry);
            };
            match pass {
                0 => seen.iter().for_each(|&entry| add(entry)),
                _ => seen.iter().rev().for_each(|&entry| add(entry)),
            }
            chain.pop();
            outline.extend(chain.into_iter().map(|entry| entry.1));
        }
    }
}

impl Emitter for ConvexBody {
    fn hull(&self) -> &[DVec3] {
        &self.corners
    }

    fn is_part(&self, region: u32) -> bool {
        self.regions.binary_search(&region).is_ok()
    }

    fn outline(&self, from: DVec3, corners: &mut Vec<DVec3>) -> Option<HalfSpace> {
        corners.clear();
        let is_near = |face: u32| {
            let (normal, offset) = self.faces[face as usize];
            normal.dot(from) > offset
        };
        // The edges between a face that is seen and one that is not, from corner to corner: as seen, the body lies
        // on the left of each.
        let mut next: Vec<(u32, u32)> = Vec::new();
        for &([a, b], [left, right]) in &self.edges {
            match (is_near(left), is_near(right)) {
                (true, false) => next.push((a, b)),
                (false, true) => next.push((b, a)),
                _ => {}
            }
        }
        if next.is_empty() {
            return None;
        }
        if !self.follow(&mut next, from, corners) {
            self.wrap(from, corners);
        }
        let to = self.middle - from;
        let distance = to.length();
        let normal = -to / distance;
        Some(HalfSpace { normal, offset: -distance })
    }
}

#[cfg(test)]
mod tests {
    use super::super::lambert;
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// A globe of `n` x `n / 2` quadrangles and triangles.
    pub(crate) fn globe(middle: DVec3, radius: f64, n: u32) -> Vec<(Vec<DVec3>, u32)> {
        let at = |i: u32, j: u32| {
            let (phi, theta) = (TAU * f64::from(i % n) / f64::from(n), PI * f64::from(j) / f64::from(n / 2));
            if j == 0 || j == n / 2 {
                return middle + DVec3::Z * if j == 0 { radius } else { -radius };
            }
            middle + radius * DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        let mut faces = Vec::new();
        for j in 0..n / 2 {
            for i in 0..n {
                let mut quad = vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                quad.dedup();
                if quad.first() == quad.last() {
                    quad.pop();
                }
                faces.push((quad, faces.len() as u32));
            }
        }
        faces
    }

    #[test]
    fn a_globe_gives_what_a_sphere_gives() {
        let body = ConvexBody::new(&globe(DVec3::new(0.0, 0.0, 2.0), 0.3, 100)).expect("convex and closed");
        let mut outline = Vec::new();
        for (from, normal) in [
            (DVec3::ZERO, DVec3::Z),
            (DVec3::new(1.0, 0.5, 0.0), DVec3::Z),
            (DVec3::new(0.0, 0.0, 1.5), DVec3::new(0.6, 0.0, 0.8)),
        ] {
            body.outline(from, &mut outline).expect("seen");
            // A sphere above the horizon: sin² of its half angle times the cosine to its middle.
            let to = DVec3::new(0.0, 0.0, 2.0) - from;
            let exact = 0.09 / to.length_squared() * to.normalize().dot(normal);
            let found = lambert(normal, &outline);
            assert!((found / exact - 1.0).abs() < 2e-3, "{found} for {exact}");
            for (k, &a) in outline.iter().enumerate() {
                let b = outline[(k + 1) % outline.len()];
                assert!(b.cross(a).dot(to) > 0.0);
            }
            let mut hull = Vec::new();
            body.wrap(from, &mut hull);
            assert!((lambert(normal, &hull) / found - 1.0).abs() < 1e-3);
            for (k, &a) in hull.iter().enumerate() {
                assert!(hull[(k + 1) % hull.len()].cross(a).dot(to) > 0.0);
            }
        }
        assert!(body.outline(DVec3::new(0.0, 0.0, 2.1), &mut outline).is_none(), "inside");
    }

    #[test]
    fn what_is_open_dented_or_long_is_no_body() {
        let mut faces = globe(DVec3::ZERO, 1.0, 12);
        let whole = faces.clone();
        assert!(ConvexBody::new(&whole).is_some());
        faces.pop();
        assert!(ConvexBody::new(&faces).is_none(), "open");
        let long: Vec<_> = whole
            .iter()
            .map(|(c, r)| (c.iter().map(|p| *p * DVec3::new(4.0, 1.0, 1.0)).collect(), *r))
            .collect();
        assert!(ConvexBody::new(&long).is_none(), "long");
        let dented: Vec<_> = whole
            .iter()
            .map(|(c, r)| (c.iter().map(|p| if p.z > 0.99 { *p * 0.2 } else { *p }).collect(), *r))
            .collect();
        assert!(ConvexBody::new(&dented).is_none(), "dented");
    }
}
