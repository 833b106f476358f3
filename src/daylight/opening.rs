//! Light that reaches a point through an opening.

use super::outdoors::Daylight;
use crate::geometry::gauss_legendre;
use glam::DVec3;

/// Points of the rule along either side of a triangle: few where little is asked for.
const POINTS: [usize; 2] = [3, 5];
/// From this tolerance on few points do.
const COARSE: f64 = 1e-6;
/// Longer sides of triangles are halved in any case, as chords of the unit sphere: 60 degrees.
const LONGEST: f64 = 1.0;
/// Triangles are halved at most so often.
const DEEPEST: u32 = 24;
/// Errors add up from many triangles: each is done where its two estimates differ by this share of what is
/// tolerated.
const PART: f64 = 0.03;

impl Daylight {
    /// Illuminance in lux at a point with the unit `normal` from the sky and the ground that it sees within a
    /// polygon, without the sun's disc.
    ///
    /// `corners` are the directions of the polygon's corners from the point, of any length, in order and
    /// either way round; they must lie within less than half a sphere. `passed` is the share of light that
    /// passes from a unit direction, 1 for an open hole. Parts of the polygon behind the surface count for
    /// nothing. 0 for fewer than three corners, or for one without a direction.
    ///
    /// Adaptive cubature on spherical triangles. `tolerance` is the relative error aimed at, 1e-9 to 0.1; what
    /// comes out is mostly nearer to the truth where `passed` is smooth.
    pub fn illuminance_through(
        &self,
        corners: &[DVec3],
        normal: DVec3,
        tolerance: f64,
        passed: impl Fn(DVec3) -> f64,
    ) -> f64 {
        let units: Vec<DVec3> = corners.iter().map(|corner| corner.normalize_or_zero()).collect();
        if units.len() < 3 || units.contains(&DVec3::ZERO) {
            return 0.0;
        }
        let seen = above(&units, normal);
        let sky = above(&seen, DVec3::Z);
        let ground = above(&seen, DVec3::NEG_Z);
        let cubature = Cubature::new(tolerance);
        let of_sky = cubature
            .over(&sky, &|e| self.sky().luminance(e.with_z(e.z.max(0.0))) * normal.dot(e) * passed(e));
        let of_ground = cubature.over(&ground, &|e| normal.dot(e) * passed(e));
        of_sky.abs() + of_ground.abs() * self.ground_luminance()
    }
}

/// The part of a spherical polygon on the side of a plane through its centre to which `normal` points
/// (Sutherland & Hodgman 1974). A polygon that is not convex may come out with two edges along the plane that
/// cancel each other.
fn above(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    let Some(&last) = polygon.last() else { return kept };
    let mut from = last;
    for &to in polygon {
        let (a, b) = (from.dot(normal), to.dot(normal));
        if (a < 0.0) != (b < 0.0) {
            let crossing = (from * b - to * a) * (b - a).signum();
            kept.push(crossing.normalize_or(to));
        }
        if b >= 0.0 {
            kept.push(to);
        }
        from = to;
    }
    kept
}

/// A rule for triangles.
struct Cubature {
    /// Barycentric coordinates of two corners, and weights that add up to 1/2.
    points: Vec<[f64; 3]>,
    tolerance: f64,
}

impl Cubature {
    /// Gauss points of a square, one side of which is drawn together to a corner.
    fn new(tolerance: f64) -> Self {
        let tolerance = if tolerance.is_finite() { tolerance.clamp(1e-9, 0.1) } else { 1e-9 };
        let rule = gauss_legendre(POINTS[usize::from(tolerance < COARSE)]);
        let points = rule
            .iter()
            .flat_map(|&(u, wu)| rule.iter().map(move |&(v, wv)| [u * (1.0 - v), u * v, wu * wv * u]));
        Self { points: points.collect(), tolerance }
    }

    /// The integral over a spherical polygon; its sign is that of the way round.
    fn over(&self, polygon: &[DVec3], value: &impl Fn(DVec3) -> f64) -> f64 {
        let Some((&apex, rest)) = polygon.split_first() else { return 0.0 };
        let fan: Vec<[DVec3; 3]> = rest.windows(2).map(|pair| [apex, pair[0], pair[1]]).collect();
        let firsts: Vec<f64> = fan.iter().map(|triangle| self.once(triangle, value)).collect();
        let whole: f64 = firsts.iter().map(|first| first.abs()).sum();
        let most = PART * self.tolerance * whole;
        fan.iter().zip(firsts).map(|(triangle, first)| self.refined(triangle, first, value, most, 0)).sum()
    }

    /// The integral over a triangle of which `first` is an estimate.
    fn refined(
        &self,
        &[a, b, c]: &[DVec3; 3],
        first: f64,
        value: &impl Fn(DVec3) -> f64,
        most: f64,
        depth: u32,
    ) -> f64 {
        // The longest side is halved, so that triangles do not become needles.
        let (ab, bc, ca) = (a.distance_squared(b), b.distance_squared(c), c.distance_squared(a));
        let (p, q, r) = if ab >= bc && ab >= ca {
            (a, b, c)
        } else if bc >= ca {
            (b, c, a)
        } else {
            (c, a, b)
        };
        let middle = (p + q).normalize_or_zero();
        let halves = [[p, middle, r], [middle, q, r]];
        let [left, right] = halves.map(|half| self.once(&half, value));
        let rough = ab.max(bc).max(ca) > LONGEST * LONGEST;
        if depth >= DEEPEST || middle == DVec3::ZERO || (!rough && (left + right - first).abs() <= most) {
            return left + right;
        }
        self.refined(&halves[0], left, value, most, depth + 1)
            + self.refined(&halves[1], right, value, most, depth + 1)
    }

    /// One use of the rule: a flat triangle with corners on the unit sphere, projected onto it.
    fn once(&self, &[a, b, c]: &[DVec3; 3], value: &impl Fn(DVec3) -> f64) -> f64 {
        let volume = a.dot(b.cross(c));
        if volume == 0.0 {
            return 0.0;
        }
        let sum: f64 = self
            .points
            .iter()
            .map(|&[s, t, weight]| {
                let point = a + s * (b - a) + t * (c - a);
                let distance = point.length();
                weight * value(point / distance) / (distance * distance * distance)
            })
            .sum();
        volume * sum
    }
}
