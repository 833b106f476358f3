//! The luminous intensity of a luminaire in every direction.

use super::error::InvalidDistribution;
use super::planes::{Closing, Planes};
use glam::DVec3;

/// Tolerance in degrees for rounding errors of directions.
const ROUNDING: f64 = 1e-9;
/// Steps below this many radians are integrated by Simpson's rule, where the closed form suffers from
/// cancellation.
const SHORT_STEP: f64 = 1e-3;

/// Luminous intensity in candela over the sphere, bilinear between the directions of the file.
///
/// Frame of the luminaire: nadir (gamma 0) is -z, C0 is +x, C90 is +y; seen from above, C runs
/// counter-clockwise. A direction e points away from the luminaire: gamma = acos(-e.z), C = atan2(e.y, e.x).
/// Gamma runs from 0 (down) to 180 degrees (up). Beyond the vertical angles of the file the intensity is 0.
///
/// Type B files keep their own poles (at C90 and C270), so that their samples and their flux are exact.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    pole: Pole,
    /// Degrees about the pole, strictly ascending, at most 360 from first to last.
    azimuths: Vec<f64>,
    /// Degrees from the pole, strictly ascending, within 0 to 180.
    polars: Vec<f64>,
    /// Candela, all polar angles of the first azimuth first.
    candelas: Vec<f64>,
}

/// Where the half-planes of a distribution meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pole {
    /// Down: polar angles are gamma, azimuths C (types C and A).
    Nadir,
    /// At C90: azimuths turn from nadir (0) to C0 (90), as the vertical angles of type B do.
    C90,
}

impl Pole {
    /// Azimuth and polar angle of a direction, degrees.
    pub(super) fn angles(self, e: DVec3) -> (f64, f64) {
        let (along, right, ahead) = match self {
            Pole::Nadir => (-e.z, e.y, e.x),
            Pole::C90 => (e.y, e.x, -e.z),
        };
        let polar = right.hypot(ahead).atan2(along);
        (right.atan2(ahead).to_degrees(), polar.to_degrees())
    }

    /// The unit direction of an azimuth and a polar angle in degrees.
    pub(super) fn direction(self, azimuth: f64, polar: f64) -> DVec3 {
        let (sin, cos) = polar.to_radians().sin_cos();
        let (right, ahead) = azimuth.to_radians().sin_cos();
        match self {
            Pole::Nadir => DVec3::new(sin * ahead, sin * right, -cos),
            Pole::C90 => DVec3::new(sin * right, cos, -sin * ahead),
        }
    }
}

/// The unit direction at C and gamma in degrees, in the frame of the luminaire.
pub fn direction(c: f64, gamma: f64) -> DVec3 {
    Pole::Nadir.direction(c, gamma)
}

/// The direction of the greatest intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Candela.
    pub candela: f64,
    /// Degrees, 0 to 360.
    pub c: f64,
    /// Degrees, 0 to 180.
    pub gamma: f64,
}

impl Distribution {
    /// A distribution over C planes and gamma angles in degrees, with candelas of all gammas of the first
    /// plane first. The planes are those of a file of type C: 0 alone (rotational), or 0 to 90, 0 to 180, 90
    /// to 270 (mirrored), or 0 to 360. Gammas ascend within 0 to 180, candelas are finite and not negative.
    pub fn new(c_planes: &[f64], gammas: &[f64], candelas: &[f64]) -> Result<Self, InvalidDistribution> {
        if gammas.is_empty() || c_planes.len().checked_mul(gammas.len()) != Some(candelas.len()) {
            return Err(InvalidDistribution(format!(
                "{} planes of {} angles do not hold {} intensities",
                c_planes.len(),
                gammas.len(),
                candelas.len()
            )));
        }
        let rows = candelas.chunks(gammas.len()).map(<[f64]>::to_vec).collect();
        Self::type_c(Planes { angles: c_planes.to_vec(), rows }, gammas.to_vec()).map(|(made, _)| made)
    }

    /// A distribution from the stored planes of type C.
    pub(super) fn type_c(planes: Planes, gammas: Vec<f64>) -> Result<(Self, Closing), InvalidDistribution> {
        ascending(&planes.angles, "horizontal")?;
        let (planes, closing) = planes.closed().map_err(InvalidDistribution)?;
        Ok((Self::from_planes(Pole::Nadir, planes, gammas)?, closing))
    }

    /// A distribution from planes as they are; the circle stays open where they leave it open.
    pub(super) fn from_planes(
        pole: Pole,
        planes: Planes,
        polars: Vec<f64>,
    ) -> Result<Self, InvalidDistribution> {
        ascending(&planes.angles, "horizontal")?;
        ascending(&polars, "vertical")?;
        let (first, last) = ends(&polars);
        if polars.len() < 2 || first < 0.0 || last > 180.0 {
            return Err(InvalidDistribution(format!(
                "the angles from the axis must be two or more within 0 to 180 degrees, but run from {first} \
                to {last}"
            )));
        }
        let (start, end) = ends(&planes.angles);
        if planes.angles.len() < 2 || end - start > 360.0 {
            return Err(InvalidDistribution(format!(
                "the half-planes must be two or more within 360 degrees, but run from {start} to {end}"
            )));
        }
        let candelas: Vec<f64> = planes.rows.into_iter().flatten().collect();
        if candelas.len() != planes.angles.len() * polars.len() {
            return Err(InvalidDistribution("the planes have different numbers of intensities".to_owned()));
        }
        if let Some(wrong) = candelas.iter().find(|value| !value.is_finite() || **value < 0.0) {
            return Err(InvalidDistribution(format!(
                "an intensity is {wrong} cd, but must be finite and not negative"
            )));
        }
        Ok(Self { pole, azimuths: planes.angles, polars, candelas })
    }

    pub(super) fn pole(&self) -> Pole {
        self.pole
    }

    pub(super) fn polars(&self) -> &[f64] {
        &self.polars
    }

    /// Intensity in candela in the direction `e` (any length) that points away from the luminaire, in its
    /// frame; 0 for a direction without length.
    pub fn intensity(&self, e: DVec3) -> f64 {
        if !(e.is_finite() && e.length_squared() > 0.0) {
            return 0.0;
        }
        let (azimuth, polar) = self.pole.angles(e);
        self.at(azimuth, polar)
    }

    /// Intensity in candela at C and gamma in degrees; C may be any angle, gamma beyond 0 to 180 has none.
    pub fn intensity_at(&self, c: f64, gamma: f64) -> f64 {
        if !c.is_finite() || !(-ROUNDING..=180.0 + ROUNDING).contains(&gamma) {
            return 0.0;
        }
        match self.pole {
            Pole::Nadir => self.at(c, gamma),
            Pole::C90 => self.intensity(direction(c, gamma)),
        }
    }

    fn at(&self, azimuth: f64, polar: f64) -> f64 {
        let (first, last) = ends(&self.azimuths);
        let mut turned = first + (azimuth - first).rem_euclid(360.0);
        if turned > last + ROUNDING && turned >= first + 360.0 - ROUNDING {
            turned = first;
        }
        let (Some((i, s)), Some((j, t))) = (bracket(&self.azimuths, turned), bracket(&self.polars, polar))
        else {
            return 0.0;
        };
        let along = |i: usize| mix(self.candela(i, j), self.candela(i, j + 1), t);
        mix(along(i), along(i + 1), s)
    }

    fn candela(&self, azimuth: usize, polar: usize) -> f64 {
        self.candelas.get(azimuth * self.polars.len() + polar).copied().unwrap_or(0.0)
    }

    /// The greatest intensity; the first where several are equal.
    pub fn maximum(&self) -> Peak {
        let mut best = (0, 0, 0.0);
        for i in 0..self.azimuths.len() {
            for j in 0..self.polars.len() {
                if self.candela(i, j) > best.2 {
                    best = (i, j, self.candela(i, j));
                }
            }
        }
        let angle = |angles: &[f64], at: usize| angles.get(at).copied().unwrap_or(0.0);
        let e = self.pole.direction(angle(&self.azimuths, best.0), angle(&self.polars, best.1));
        let (c, gamma) = Pole::Nadir.angles(e);
        // A vertical direction, up to rounding, has no C of its own.
        let c = if e.x.hypot(e.y) < 1e-12 { 0.0 } else { c.rem_euclid(360.0) };
        Peak { candela: best.2, c, gamma }
    }

    /// Total luminous flux in lumens: the exact integral of the interpolated intensity.
    pub fn flux(&self) -> f64 {
        self.polar_flux(0.0, 180.0)
    }

    /// Flux in lumens between two angles from the pole, degrees; exact.
    ///
    /// With I linear between a and b, the mean over the azimuth of I sin integrates to
    /// Ia (cos a - cos b) + m (sin b - sin a - (b - a) cos b), m = (Ib - Ia) / (b - a).
    pub(super) fn polar_flux(&self, from: f64, to: f64) -> f64 {
        // The integral over the azimuth at each polar angle, candela times radian: trapezia are exact.
        let rings: Vec<f64> = (0..self.polars.len())
            .map(|j| {
                let steps = self.azimuths.windows(2).enumerate();
                let sum = |(i, pair): (usize, &[f64])| {
                    (pair[1] - pair[0]) * 0.5 * (self.candela(i, j) + self.candela(i + 1, j))
                };
                steps.map(sum).sum::<f64>().to_radians()
            })
            .collect();
        let zone = |(angles, rings): (&[f64], &[f64])| {
            let (a, b) = (angles[0].max(from), angles[1].min(to));
            if a >= b {
                return 0.0;
            }
            let at = |angle: f64| mix(rings[0], rings[1], (angle - angles[0]) / (angles[1] - angles[0]));
            ring_integral(a.to_radians(), b.to_radians(), at(a), at(b))
        };
        self.polars.windows(2).zip(rings.windows(2)).map(zone).sum()
    }

    /// The same distribution with every intensity times `factor`, which must be finite and not negative, and
    /// not make any intensity infinite; otherwise none.
    pub fn scaled(&self, factor: f64) -> Option<Self> {
        let possible = factor >= 0.0 && (factor * self.maximum().candela).is_finite() && factor.is_finite();
        possible.then(|| Self {
            candelas: self.candelas.iter().map(|candela| candela * factor).collect(),
            ..self.clone()
        })
    }
}

/// The integral of I sin over the polar angle from a to b (radians), I linear from `ia` to `ib`.
fn ring_integral(a: f64, b: f64, ia: f64, ib: f64) -> f64 {
    let step = b - a;
    if step < SHORT_STEP {
        let middle = 0.5 * (a + b);
        return step / 6.0 * (ia * a.sin() + 2.0 * (ia + ib) * middle.sin() + ib * b.sin());
    }
    let slope = (ib - ia) / step;
    ia * (a.cos() - b.cos()) + slope * (b.sin() - a.sin() - step * b.cos())
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a * (1.0 - t) + b * t
}

fn ends(angles: &[f64]) -> (f64, f64) {
    (angles.first().copied().unwrap_or(0.0), angles.last().copied().unwrap_or(0.0))
}

/// The interval of ascending angles that holds `angle`, and how far into it (0 to 1); none outside.
fn bracket(angles: &[f64], angle: f64) -> Option<(usize, f64)> {
    let (first, last) = ends(angles);
    if !(first - ROUNDING..=last + ROUNDING).contains(&angle) {
        return None;
    }
    let index = angles.partition_point(|&a| a <= angle).clamp(1, angles.len().checked_sub(1)?) - 1;
    let (a, b) = (angles.get(index)?, angles.get(index + 1)?);
    Some((index, ((angle - a) / (b - a)).clamp(0.0, 1.0)))
}

fn ascending(angles: &[f64], which: &str) -> Result<(), InvalidDistribution> {
    if angles.iter().any(|angle| !angle.is_finite()) {
        return Err(InvalidDistribution(format!("a {which} angle is not finite")));
    }
    match angles.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(InvalidDistribution(format!(
            "the {which} angles must ascend, but {} follows {}",
            pair[1], pair[0]
        ))),
        None => Ok(()),
    }
}
