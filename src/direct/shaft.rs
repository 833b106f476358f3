//! The convex hull of a receiving cell and an emitter: what does not enter it hides nothing of the one from the other
//! (Haines & Wallace 1991, there between boxes).

use super::obstacles::Obstacle;
use crate::geometry::Aabb;
use glam::DVec3;

/// Half-spaces whose common part is the hull, and its corners.
#[derive(Clone, Debug, Default)]
pub(super) struct Shaft {
    receiver: Vec<DVec3>,
    emitter: Vec<DVec3>,
    /// `normal · x >= offset` inside.
    planes: Vec<(DVec3, f64)>,
    edges: Vec<[usize; 2]>,
    bounds: Aabb,
}

/// An emitter of more corners is stood for by the box around them.
const MOST_CORNERS: usize = 12;
/// Edges of a box, its corners numbered by bits.
const BOX_EDGES: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

impl Shaft {
    /// Makes it the shaft between a convex cell and an emitter of which nothing outside of the hull of `emitter`
    /// matters; what enters it is known once it has been [bounded](Self::bound).
    pub(super) fn aim(&mut self, cell: &[DVec3], emitter: &[DVec3]) {
        self.receiver.clear();
        self.receiver.extend_from_slice(cell);
        self.emitter.clear();
        self.edges.clear();
        if emitter.len() > MOST_CORNERS {
            let Aabb { min, max } = Aabb::around(emitter.iter().copied());
            let pick = |bit: usize, k: usize, low: f64, high: f64| if k >> bit & 1 == 0 { low } else { high };
            self.emitter.extend((0..8).map(|k| {
                DVec3::new(pick(0, k, min.x, max.x), pick(1, k, min.y, max.y), pick(2, k, min.z, max.z))
            }));
            self.edges.extend(BOX_EDGES);
        } else {
            self.emitter.extend_from_slice(emitter);
            self.edges.extend((0..emitter.len()).map(|k| [k, (k + 1) % emitter.len()]));
        }
    }

    /// Finds the planes around it, and the horizon of the cell by its unit normal.
    pub(super) fn bound(&mut self, normal: DVec3) {
        self.bounds = Aabb::around(self.receiver.iter().chain(&self.emitter).copied());
        let tolerance = 1e-9 * self.bounds.diagonal();
        self.planes.clear();
        let horizon = self.receiver.iter().map(|c| normal.dot(*c)).fold(f64::INFINITY, f64::min);
        self.planes.push((normal, horizon));
        let n = self.receiver.len();
        for k in 0..n {
            for e in 0..self.emitter.len() {
                self.support([self.receiver[k], self.receiver[(k + 1) % n], self.emitter[e]], tolerance);
            }
        }
        for edge in 0..self.edges.len() {
            let [a, b] = self.edges[edge];
            for k in 0..n {
                self.support([self.emitter[a], self.emitter[b], self.receiver[k]], tolerance);
            }
        }
    }

    /// Adds the plane through three points, where all of the hull lies on one side of it.
    fn support(&mut self, [a, b, c]: [DVec3; 3], tolerance: f64) {
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        if length <= tolerance * tolerance {
            return;
        }
        let normal = normal / length;
        let offset = normal.dot(a);
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for point in self.receiver.iter().chain(&self.emitter) {
            let height = normal.dot(*point) - offset;
            (low, high) = (low.min(height), high.max(height));
            if low < -tolerance && high > tolerance {
                return;
            }
        }
        if low >= -tolerance {
            self.planes.push((normal, offset + low));
        } else {
            self.planes.push((-normal, -offset - high));
        }
    }

    /// Whether a box may enter it.
    pub(super) fn meets(&self, bounds: &Aabb) -> bool {
        if !self.bounds.meets(bounds) {
            return false;
        }
        let (middle, half) = (bounds.centre(), 0.5 * bounds.size());
        self.planes.iter().all(|(normal, offset)| normal.dot(middle) + normal.abs().dot(half) >= *offset)
    }

    /// Whether an obstacle may stand between the two by more than `thickness`, metres.
    pub(super) fn holds(&self, obstacle: &Obstacle<'_>, thickness: f64, anywhere: bool) -> bool {
        let [low, high] = heights(&self.receiver, obstacle);
        let [emitter_low, emitter_high] = heights(&self.emitter, obstacle);
        let is_beside = low.min(emitter_low) >= -thickness || high.max(emitter_high) <= thickness;
        !is_beside
            && (anywhere || !obstacle.is_needless([low, high], thickness))
            && self
                .planes
                .iter()
                .all(|(normal, offset)| obstacle.corners.iter().any(|c| normal.dot(*c) > offset + thickness))
    }

    /// Whether an obstacle [is needless](Obstacle::is_needless) as seen from the cell.
    pub(super) fn needs_not(&self, obstacle: &Obstacle<'_>, thickness: f64) -> bool {
        obstacle.is_needless(heights(&self.receiver, obstacle), thickness)
    }

    /// Whether an obstacle hides all of the emitter from all of the cell: what a convex obstacle hides of a convex
    /// emitter wholly is a convex part of space, so that the corners stand for the rest.
    pub(super) fn is_filled_by(&self, obstacle: &Obstacle<'_>, thickness: f64) -> bool {
        let offset = obstacle.plane.dot(obstacle.corners[0]);
        let height = |p: &DVec3| obstacle.plane.dot(*p) - offset;
        let sign = height(&self.receiver[0]).signum();
        let is_between = self.receiver.iter().all(|p| sign * height(p) > thickness)
            && self.emitter.iter().all(|p| sign * height(p) < -thickness);
        if !is_between {
            return false;
        }
        let n = obstacle.corners.len();
        self.receiver.iter().all(|from| {
            (0..n).all(|k| {
                let (a, b) = (obstacle.corners[k] - *from, obstacle.corners[(k + 1) % n] - *from);
                let inward = sign * a.cross(b);
                // Seen from its front the corners run counter-clockwise.
                self.emitter.iter().all(|to| inward.dot(*to - *from) <= 0.0)
            })
        })
    }
}

/// Least and greatest height of points over the plane of an obstacle, metres.
fn heights(points: &[DVec3], obstacle: &Obstacle<'_>) -> [f64; 2] {
    let offset = obstacle.plane.dot(obstacle.corners[0]);
    points
        .iter()
        .map(|p| obstacle.plane.dot(*p) - offset)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| [low.min(height), high.max(height)])
}
