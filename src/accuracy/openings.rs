//! Luminaires that shine by their photometry, as the witness samples them: points of the opening, each with its share of
//! the intensity.

use super::sobol::Sobol;
use crate::geometry::polygon;
use crate::scene::PhotometricSource;
use glam::DVec3;

/// What is so far before an opening does not shade it, metres; nor what is within this share of the way.
const FLUSH: f64 = 1e-3;
const FLUSH_SHARE: f64 = 0.25;
/// Of the samples this share goes by power alone, whatever a luminaire would give unhindered.
const BY_POWER: f64 = 0.1;

/// The openings of a scene under one lighting.
#[derive(Clone, Debug, Default)]
pub(super) struct Openings {
    list: Vec<Opening>,
}

#[derive(Clone, Debug)]
struct Opening {
    source: PhotometricSource,
    /// Luminance of the lamp's exitance as it stands, W/m².
    exitance: f64,
    /// Triangles of the surface, their unit normals, and the running sums of their areas, m².
    triangles: Vec<([DVec3; 3], DVec3, f64)>,
    /// Area vectors of the faces of a closed opening, m²; none where it is flat or a point.
    faces: Vec<DVec3>,
}

/// How the samples of one receiver are shared out: a share for each opening, 1 in all.
pub(super) type Shares = Vec<f64>;

impl Openings {
    /// Of `sources` that are lit; `exitance` gives the luminance of a lamp's exitance as it stands, W/m².
    pub(super) fn new(sources: &[PhotometricSource], exitance: impl Fn(u32) -> f64) -> Self {
        let list = sources.iter().map(|source| Opening::new(source, exitance(source.luminaire)));
        Self { list: list.filter(|opening| opening.exitance > 0.0).collect() }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// By what each would give unhindered within `radius` of a point with a unit normal, metres.
    pub(super) fn shares(&self, centre: DVec3, normal: DVec3, radius: f64) -> Shares {
        let powers: Vec<f64> = self.list.iter().map(|o| o.exitance * o.source.area).collect();
        let given: Vec<f64> = self
            .list
            .iter()
            .map(|opening| {
                let way = opening.source.place.centre - centre;
                let reach = radius + opening.source.photometry.opening.longest();
                let distance2 = way.length_squared().max(reach * reach).max(f64::MIN_POSITIVE);
                let slack = reach / distance2.sqrt();
                let cosine = (normal.dot(way) / distance2.sqrt() + slack).max(0.0);
                opening.exitance * opening.source.intensity(-way) * cosine / distance2
            })
            .collect();
        let (all, power) = (given.iter().sum::<f64>(), powers.iter().sum::<f64>());
        let by_power = if all > 0.0 { BY_POWER } else { 1.0 };
        given
            .iter()
            .zip(&powers)
            .map(|(given, own)| {
                by_power * own / power.max(f64::MIN_POSITIVE)
                    + (1.0 - by_power) * given / all.max(f64::MIN_POSITIVE)
            })
            .collect()
    }

    /// Luminance of the irradiance from all of them by about so many `samples`, at least one each. Receivers start
    /// where `start` says for four numbers in 0..1; `passes` tells what share of light, by luminance, gets past
    /// what is not the lamp's own between a point and one that is a way and a distance ahead.
    pub(super) fn gather(
        &self,
        start: impl Fn([f64; 4]) -> (DVec3, DVec3),
        shares: &[f64],
        samples: u32,
        seed: u64,
        passes: impl Fn(u32, DVec3, DVec3, f64) -> f64,
    ) -> f64 {
        let mut sum = 0.0;
        for (k, (opening, share)) in (0_u64..).zip(self.list.iter().zip(shares)) {
            let own = ((f64::from(samples) * share).round() as u32).max(1);
            let sequence = Sobol::new(seed ^ (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
            for i in 0..own {
                let u = sequence.point(i);
                let (origin, normal) = start(u);
                let (target, facing) = opening.point([u[0], u[1]]);
                let way = target - origin;
                let distance = way.length();
                let given = opening.unhindered(way, normal, facing);
                if given > 0.0 {
                    let end = distance - FLUSH.min(FLUSH_SHARE * distance);
                    let passed = passes(opening.source.luminaire, origin, way / distance, end);
                    sum += passed * given / f64::from(own);
                }
            }
        }
        sum
    }
}

impl Opening {
    fn new(source: &PhotometricSource, exitance: f64) -> Self {
        let polygons = source.opening();
        let mut triangles = Vec::new();
        let mut sum = 0.0;
        for face in &polygons {
            for edge in face[1..].windows(2) {
                let corners = [face[0], edge[0], edge[1]];
                let vector = polygon::area_vector(&corners);
                sum += vector.length();
                triangles.push((corners, vector.normalize_or_zero(), sum));
            }
        }
        let is_closed = polygons.len() > 1;
        let faces = polygons.iter().filter(|_| is_closed).map(|face| polygon::area_vector(face)).collect();
        Self { source: source.clone(), exitance, triangles, faces }
    }

    /// A point of the opening for two numbers in 0..1, evenly by area, and the direction that it faces.
    fn point(&self, [r, s]: [f64; 2]) -> (DVec3, DVec3) {
        let whole = self.triangles.last().map_or(0.0, |last| last.2);
        let at = self.triangles.partition_point(|entry| entry.2 <= r * whole);
        let Some(&([a, b, c], normal, end)) = self.triangles.get(at).or(self.triangles.last()) else {
            return (self.source.place.centre, DVec3::ZERO);
        };
        let before = if at > 0 { self.triangles[at - 1].2 } else { 0.0 };
        let r = ((r * whole - before) / (end - before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let root = r.sqrt();
        (a * (1.0 - root) + b * (root * (1.0 - s)) + c * (root * s), normal)
    }

    /// What all of the opening would give if it were all at one place a `way` ahead that faces `facing`.
    fn unhindered(&self, way: DVec3, normal: DVec3, facing: DVec3) -> f64 {
        let distance = way.length();
        let direction = way / distance;
        let cosine = normal.dot(direction);
        if !(cosine > 0.0 && distance > 0.0) {
            return 0.0;
        }
        let sent = self.exitance * self.source.intensity(-direction) * cosine / (distance * distance);
        if self.faces.is_empty() {
            return sent;
        }
        // Evenly bright as seen from anywhere: by the area that is seen.
        let projected = 0.5 * self.faces.iter().map(|face| face.dot(direction).abs()).sum::<f64>();
        let whole = self.triangles.last().map_or(0.0, |last| last.2);
        let seen = (-facing.dot(direction)).max(0.0);
        if projected > 0.0 { sent * whole * seen / projected } else { 0.0 }
    }
}
