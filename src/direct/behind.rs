//! Light that arrives through panes of glass: the visible part of an outline divided by the panes before it.

use super::clip::{Polygons, cut_off, edge_planes, split};
use crate::emitters::{Emitter, HalfSpace};
use crate::visibility::Glass;
use glam::DVec3;

/// Working memory: convex polygons as seen from a receiver at the origin, each with the panes before it.
#[derive(Clone, Debug, Default)]
pub(super) struct Behind {
    parts: Vec<Part>,
    next: Vec<Part>,
    corners: Vec<DVec3>,
    planes: Vec<DVec3>,
    inside: Vec<DVec3>,
    rest: Vec<DVec3>,
    cut: Polygons,
}

#[derive(Clone, Debug)]
struct Part {
    corners: Vec<DVec3>,
    panes: Vec<u32>,
}

/// A plane through the origin runs through a corner that is nearer to it than this share of the farthest one's distance.
const ON_PLANE: f64 = 1e-12;
/// Over a part whose cosines on a pane differ by no more than this, its transmittance in the middle stands for all.
const EVEN: f64 = 0.15;
/// Parts are halved so often at most.
const MOST_HALVINGS: u32 = 6;

impl Behind {
    /// Begins with polygons that no pane stands before.
    pub(super) fn start<'a>(&mut self, polygons: impl Iterator<Item = &'a [DVec3]>) {
        self.parts.clear();
        self.parts.extend(polygons.map(|corners| Part { corners: corners.to_vec(), panes: Vec::new() }));
    }

    /// Divides them by these panes of the scene, as seen from `point`; what lies outside of `limit` stands before none.
    pub(super) fn divide(
        &mut self,
        glass: &Glass,
        panes: &[u32],
        point: DVec3,
        (limit, thickness): (HalfSpace, f64),
    ) {
        let reach =
            self.parts.iter().flat_map(|p| &p.corners).map(|c| c.length_squared()).fold(0.0, f64::max);
        let on_plane = ON_PLANE * reach.sqrt();
        for &index in panes {
            let pane = &glass.panes().list[index as usize];
            let height = pane.normal.dot(pane.corners[0] - point);
            // From its front its plane lies below along the normal.
            if height.abs() <= thickness || !pane.dims[usize::from(height > 0.0)] {
                continue;
            }
            self.corners.clear();
            let relative: Vec<DVec3> = pane.corners.iter().map(|corner| *corner - point).collect();
            cut_off(&relative, limit, &mut self.corners);
            if self.corners.len() < 3 {
                continue;
            }
            self.planes.clear();
            edge_planes(&self.corners, height, &mut self.planes);
            self.next.clear();
            for part in self.parts.drain(..) {
                let is_apart = |plane: &DVec3| part.corners.iter().all(|c| plane.dot(*c) <= on_plane);
                if self.planes.iter().any(is_apart) {
                    self.next.push(part);
                    continue;
                }
                self.cut.clear();
                let (mut left, mut other) = (&mut self.inside, &mut self.rest);
                left.clear();
                left.extend_from_slice(&part.corners);
                for &plane in &self.planes {
                    other.clear();
                    split(left, plane, on_plane, other, Some(&mut self.cut));
                    std::mem::swap(&mut left, &mut other);
                    if left.len() < 3 {
                        break;
                    }
                }
                if left.len() < 3 {
                    self.next.push(part);
                    continue;
                }
                let outside = self
                    .cut
                    .iter()
                    .map(|corners| Part { corners: corners.to_vec(), panes: part.panes.clone() });
                self.next.extend(outside);
                let panes = part.panes.iter().copied().chain([index]).collect();
                self.next.push(Part { corners: left.clone(), panes });
            }
            std::mem::swap(&mut self.parts, &mut self.next);
        }
    }

    /// Irradiance from all parts for a receiver with this unit normal, in each band what glass leaves of it.
    pub(super) fn irradiance(&self, glass: &Glass, emitter: &dyn Emitter, normal: DVec3) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for part in &self.parts {
            if part.panes.is_empty() {
                let value = emitter.irradiance(normal, &part.corners);
                sum.iter_mut().for_each(|sum| *sum += value);
            } else {
                let all = Through { glass, panes: &part.panes, emitter, normal };
                all.add(&part.corners, &mut sum);
            }
        }
        sum
    }
}

/// An emitter behind some panes.
struct Through<'a> {
    glass: &'a Glass,
    panes: &'a [u32],
    emitter: &'a dyn Emitter,
    normal: DVec3,
}

impl Through<'_> {
    fn add(&self, corners: &[DVec3], sum: &mut [f64; 3]) {
        let is_even = |corners: &[DVec3]| {
            let normal = |pane: u32| self.glass.panes().list[pane as usize].normal;
            self.panes.iter().all(|&pane| is_even_on(normal(pane), corners))
        };
        each_even_part(corners, &is_even, MOST_HALVINGS, &mut |corners, direction| {
            let value = self.emitter.irradiance(self.normal, corners);
            let mut left = [value; 3];
            for &pane in self.panes {
                let passed = self.glass.passed(&self.glass.panes().list[pane as usize], direction);
                left.iter_mut().zip(passed).for_each(|(left, passed)| *left *= passed);
            }
            sum.iter_mut().zip(left).for_each(|(sum, left)| *sum += left);
        });
    }
}

/// Whether what passes a pane of this unit normal, or what it mirrors, is the same for all of a polygon about.
fn is_even_on(normal: DVec3, corners: &[DVec3]) -> bool {
    let cosines = corners.iter().map(|c| normal.dot(c.normalize_or_zero()));
    let (low, high) =
        cosines.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)));
    high - low <= EVEN
}

/// Divides a polygon as seen from the origin for as long as it differs in its angle on a plane of this unit normal; calls
/// `each` with every part and the unit vector to its middle.
pub(super) fn each_part_even_on(normal: DVec3, corners: &[DVec3], mut each: impl FnMut(&[DVec3], DVec3)) {
    each_even_part(corners, &|corners| is_even_on(normal, corners), MOST_HALVINGS, &mut each);
}

fn each_even_part(
    corners: &[DVec3],
    is_even: &impl Fn(&[DVec3]) -> bool,
    halvings: u32,
    each: &mut impl FnMut(&[DVec3], DVec3),
) {
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    if halvings == 0 || is_even(corners) {
        return each(corners, middle.normalize_or_zero());
    }
    if corners.len() > 3 {
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[if k + 1 == corners.len() { 0 } else { k + 1 }];
            each_even_part(&[middle, a, b], is_even, halvings - 1, each);
        }
        return;
    }
    // Across the edge that is seen under the largest angle.
    let cosine = |k: usize| corners[k].normalize_or_zero().dot(corners[(k + 1) % 3].normalize_or_zero());
    let longest = (0..3).min_by(|&a, &b| cosine(a).total_cmp(&cosine(b))).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    // Halfway by angle, whatever the distances.
    let (p, q) = (a.length(), b.length());
    let half = (a * q + b * p) / (p + q).max(f64::MIN_POSITIVE);
    each_even_part(&[a, half, c], is_even, halvings - 1, each);
    each_even_part(&[half, b, c], is_even, halvings - 1, each);
}
