use super::{ConvexBody, Emitter, HalfSpace};
use crate::geometry::{Frame, polygon};
use crate::scene::PhotometricSource;
use glam::DVec3;

/// A luminaire that shines by its photometry: every point of its opening sends the same share of the intensity, so
/// that its radiance is the intensity over the projected area of the opening.
#[derive(Clone, Debug)]
pub struct PhotometricEmitter {
    source: PhotometricSource,
    shape: Shape,
    hull: Vec<DVec3>,
    /// Regions of the lamp's own surfaces, in rising order.
    regions: Vec<u32>,
    /// Nearer to its plane than this nothing sees a flat opening, metres.
    thickness: f64,
    /// What is so far before the opening hides nothing of it, metres: luminaires are set flush with ceilings.
    flush: f64,
}

#[derive(Clone, Debug)]
enum Shape {
    /// Stood for by a square of [`POINT`] that faces whoever looks at it.
    Point,
    /// Seen from both sides of its plane, if it shines to both: unit normal, area in m², whether it shines there.
    Flat { normal: DVec3, area: f64, shines: [bool; 2] },
    /// A closed convex body; the area vectors of its faces, m².
    Body { body: ConvexBody, faces: Vec<DVec3> },
}

/// Edge of what stands for a point, metres.
const POINT: f64 = 2e-7;
/// Luminaires count as flush with what is nearer, as a share of the scene's size, but no more than this, metres.
const FLUSH: f64 = 1e-3;
/// Parts of an opening that look longer than this, as a share of their distance, are divided to be added up.
const LONG: f64 = 0.2;
/// Of what looks shorter than this the middle stands for all of it.
const SHORT: f64 = 0.02;
/// Divisions at most, one after the other.
const MOST_DIVISIONS: u32 = 12;
/// A side that gets less of the flux is dark.
const DARK: f64 = 1e-6;

impl PhotometricEmitter {
    /// A luminaire in a scene of some `size`, metres; the lamp's own surfaces are these `regions` of the mesh, in
    /// rising order.
    pub fn new(source: PhotometricSource, regions: Vec<u32>, thickness: f64, size: f64) -> Self {
        let opening = source.opening();
        let areas: Vec<DVec3> = opening.iter().map(|face| polygon::area_vector(face)).collect();
        let faces: Vec<(Vec<DVec3>, u32)> = opening.iter().map(|face| (face.clone(), 0)).collect();
        let (hull, shape) = match opening.first() {
            None => (vec![source.place.centre], Shape::Point),
            Some(first) => match ConvexBody::new(&faces) {
                Some(body) => (body.hull().to_vec(), Shape::Body { body, faces: areas }),
                // Of long bodies what lies beside them is not told from what lies before them: the largest section
                // stands for them.
                None => {
                    let flat = if opening.len() == 1 { first.clone() } else { section(&source, &opening) };
                    let vector = polygon::area_vector(&flat);
                    let normal = vector.normalize_or(-source.place.frame.normal);
                    let down = source.downward_share;
                    let is_level = normal.dot(source.place.frame.normal) < -0.99;
                    let shines = if is_level { [down > DARK, 1.0 - down > DARK] } else { [true; 2] };
                    (flat, Shape::Flat { normal, area: vector.length(), shines })
                }
            },
        };
        let flush = FLUSH * size.min(1.0);
        Self { source, shape, hull, regions, thickness, flush }
    }

    /// What part of the opening is to be cut off for it to be seen from a distance, metres.
    fn flush_at(&self, distance: f64) -> f64 {
        self.flush.min(0.25 * distance)
    }

    /// Area of the opening as seen along a unit direction, m².
    fn projected(&self, direction: DVec3) -> f64 {
        match &self.shape {
            Shape::Point => POINT * POINT,
            Shape::Flat { normal, area, .. } => area * normal.dot(direction).abs(),
            Shape::Body { faces, .. } => {
                0.5 * faces.iter().map(|face| face.dot(direction).abs()).sum::<f64>()
            }
        }
    }

    /// What a triangle of the visible part gives a receiver at the origin.
    fn of_triangle(&self, normal: DVec3, [a, b, c]: [DVec3; 3], divisions: u32) -> f64 {
        let edges = [(a, b, c), (b, c, a), (c, a, b)];
        let length = |&(p, q, _): &(DVec3, DVec3, DVec3)| p.distance_squared(q);
        let [first, second, third] = edges;
        let longest = [second, third]
            .into_iter()
            .fold(first, |longest, edge| if length(&edge) > length(&longest) { edge } else { longest });
        let nearest = a.length_squared().min(b.length_squared()).min(c.length_squared());
        let ratio = length(&longest) / nearest.max(f64::MIN_POSITIVE);
        if ratio > LONG * LONG && divisions < MOST_DIVISIONS {
            let (p, q, rest) = longest;
            let middle = 0.5 * (p + q);
            return self.of_triangle(normal, [p, middle, rest], divisions + 1)
                + self.of_triangle(normal, [middle, q, rest], divisions + 1);
        }
        let vector = 0.5 * (b - a).cross(c - a);
        let at = |p: DVec3| {
            let distance = p.length();
            let direction = p / distance;
            let projected = self.projected(direction);
            let cosines = normal.dot(direction).max(0.0) * vector.dot(direction).abs();
            if projected > 0.0 && cosines > 0.0 {
                self.source.intensity(-direction) * cosines / (projected * distance * distance)
            } else {
                0.0
            }
        };
        if ratio < SHORT * SHORT {
            return at((a + b + c) / 3.0);
        }
        // Exact for quadratic integrands (Strang & Fix 1973).
        let near = |p: DVec3, q: DVec3, r: DVec3| at((4.0 * p + q + r) / 6.0);
        (near(a, b, c) + near(b, c, a) + near(c, a, b)) / 3.0
    }
}

/// The largest of the level and the two upright sections through the middle of a body, by the box around it.
fn section(source: &PhotometricSource, opening: &[Vec<DVec3>]) -> Vec<DVec3> {
    let (frame, centre) = (&source.place.frame, source.place.centre);
    let half = opening
        .iter()
        .flatten()
        .fold(DVec3::ZERO, |most, corner| most.max(frame.local(*corner - centre).abs()));
    let axes = [frame.tangent * half.x, -frame.bitangent * half.y, frame.normal * half.z];
    let across = |a: usize, b: usize| axes[a].length() * axes[b].length();
    let [a, b] = [[0, 2], [1, 2]]
        .into_iter()
        .fold(
            [0, 1],
            |most, pair| if across(pair[0], pair[1]) > across(most[0], most[1]) { pair } else { most },
        )
        .map(|k| axes[k]);
    [-a - b, a - b, a + b, b - a].map(|corner| centre + corner).to_vec()
}

impl Emitter for PhotometricEmitter {
    fn hull(&self) -> &[DVec3] {
        &self.hull
    }

    fn is_part(&self, region: u32) -> bool {
        self.regions.binary_search(&region).is_ok()
    }

    fn outline(&self, from: DVec3, corners: &mut Vec<DVec3>) -> Option<HalfSpace> {
        corners.clear();
        match &self.shape {
            Shape::Point => {
                let to = self.source.place.centre - from;
                let distance = to.length();
                if distance <= self.thickness {
                    return None;
                }
                let frame = Frame::around(to / distance);
                let (a, b) = (frame.tangent * (0.5 * POINT), frame.bitangent * (0.5 * POINT));
                corners.extend([to - a - b, to - a + b, to + a + b, to + a - b]);
                Some(HalfSpace { normal: -frame.normal, offset: self.flush_at(distance) - distance })
            }
            Shape::Flat { normal, shines, .. } => {
                let height = normal.dot(from - self.hull[0]);
                if height.abs() <= self.thickness || !shines[usize::from(height < 0.0)] {
                    return None;
                }
                corners.extend(self.hull.iter().map(|corner| *corner - from));
                if height < 0.0 {
                    corners.reverse();
                }
                let offset = self.flush_at(height.abs()) - height.abs();
                Some(HalfSpace { normal: *normal * height.signum(), offset })
            }
            Shape::Body { body, .. } => body.outline(from, corners),
        }
    }

    fn irradiance(&self, normal: DVec3, visible: &[DVec3]) -> f64 {
        if visible.len() < 3 {
            return 0.0;
        }
        let fan = visible[1..].windows(2).map(|edge| [visible[0], edge[0], edge[1]]);
        fan.map(|triangle| self.of_triangle(normal, triangle, 0)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::{Distribution, Opening, OpeningShape, Photometry};
    use crate::scene::{Attitude, UpAxis};
    use std::f64::consts::PI;

    /// At 3 m over the origin, z up, without surfaces of its own.
    fn luminaire(gammas: &[f64], candelas: &[f64], opening: Opening) -> PhotometricEmitter {
        let distribution = Distribution::new(&[0.0], gammas, candelas).unwrap();
        let photometry = Photometry::made("test", distribution, opening);
        let frame = Attitude::default().frame(UpAxis::Z);
        let source = PhotometricSource::single(photometry, DVec3::Z * 3.0, frame, 1.0);
        PhotometricEmitter::new(source, Vec::new(), 1e-6, 10.0)
    }

    fn cosine(opening: Opening) -> PhotometricEmitter {
        let gammas: Vec<f64> = (0..=180).map(|k| 0.5 * f64::from(k)).collect();
        let candelas: Vec<f64> = gammas.iter().map(|gamma| gamma.to_radians().cos().max(0.0)).collect();
        luminaire(&gammas, &candelas, opening)
    }

    fn at(emitter: &PhotometricEmitter, point: DVec3, normal: DVec3) -> f64 {
        let mut outline = Vec::new();
        emitter.outline(point, &mut outline).map_or(0.0, |_| emitter.irradiance(normal, &outline))
    }

    fn opening(shape: OpeningShape, [x, y, z]: [f64; 3]) -> Opening {
        Opening { shape, along_c0: x, along_c90: y, height: z }
    }

    #[test]
    fn a_point_gives_intensity_times_cosine_over_squared_distance() {
        let point = cosine(Opening::POINT);
        for (place, normal) in [
            (DVec3::ZERO, DVec3::Z),
            (DVec3::new(1.5, 1.5, 0.0), DVec3::Z),
            (DVec3::new(2.0, 0.0, 1.0), DVec3::NEG_X),
        ] {
            let to = DVec3::Z * 3.0 - place;
            let d2 = to.length_squared();
            let exact = to.z / d2.sqrt() * normal.dot(to) / d2.sqrt() / d2 / PI;
            let found = at(&point, place, normal);
            assert!((found / exact - 1.0).abs() < 1e-4, "{found} for {exact} at {place}");
        }
    }

    #[test]
    fn a_rectangle_of_cosine_intensity_is_a_face_of_lambert() {
        let flat = cosine(opening(OpeningShape::Rectangle, [1.2, 0.4, 0.0]));
        for (place, normal) in [
            (DVec3::ZERO, DVec3::Z),
            (DVec3::new(0.3, 0.1, 2.7), DVec3::Z),
            (DVec3::new(2.0, 0.5, 2.0), DVec3::NEG_X),
            (DVec3::new(0.0, 0.0, 4.0), DVec3::NEG_Z),
        ] {
            let mut outline = Vec::new();
            let exact = match flat.outline(place, &mut outline) {
                // Of one square metre of the lamp's area.
                Some(_) => super::super::lambert(normal, &outline) / (1.2 * 0.4),
                None => 0.0,
            };
            let found = at(&flat, place, normal);
            assert!((found - exact).abs() <= 2e-4 * exact, "{found} for {exact} at {place}");
        }
    }

    #[test]
    fn bodies_of_even_intensity_are_points_from_afar_and_their_flux_leaves_them_whole() {
        for (shape, size) in [
            (OpeningShape::Ellipsoid, [0.3; 3]),
            (OpeningShape::Box, [0.3, 0.2, 0.2]),
            (OpeningShape::VerticalCylinder, [0.2, 0.2, 0.3]),
            (OpeningShape::CylinderAlongC0, [1.5, 0.1, 0.1]),
        ] {
            let even = luminaire(&[0.0, 180.0], &[1.0, 1.0], opening(shape, size));
            // Through a closed sphere of 1 m around it.
            let (mut sum, n) = (0.0, 4000);
            for k in 0..n {
                let z = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(n);
                let (sin, cos) = (f64::from(k) * 2.399_963_229_728_653).sin_cos();
                let out = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
                sum += at(&even, DVec3::Z * 3.0 + out, -out) * 4.0 * PI / f64::from(n);
            }
            assert!((sum - 1.0).abs() < 0.01, "{shape:?}: {sum}");
            let afar = at(&even, DVec3::Z * -47.0, DVec3::Z) * 4.0 * PI * 2500.0;
            // What faces the receiver is nearer than the middle.
            assert!((afar - 1.0).abs() < 5e-3, "{shape:?}: {afar}");
        }
    }
}
