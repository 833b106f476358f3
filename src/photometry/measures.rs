//! Figures of a distribution: zonal fluxes, light output up and down, beam and field angle, polar curve.

use super::distribution::{Distribution, Pole};

/// Step of the quadrature over C and gamma, and of profiles, for type B, which has no samples along gamma.
const FINE_STEP: f64 = 0.5;

/// Flux of a zone between two gamma angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Lower gamma, degrees.
    pub from: f64,
    /// Upper gamma, degrees.
    pub to: f64,
    /// Lumens.
    pub lumens: f64,
}

/// A vertical plane through the luminaire, of two opposite half-planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MainPlane {
    /// C0 and C180.
    C0C180,
    /// C90 and C270.
    C90C270,
}

impl MainPlane {
    /// Both main planes.
    pub const ALL: [Self; 2] = [Self::C0C180, Self::C90C270];

    /// The C of its first half in degrees, on whose side the angles of profiles are positive.
    pub fn c(self) -> f64 {
        match self {
            Self::C0C180 => 0.0,
            Self::C90C270 => 90.0,
        }
    }
}

/// The angle within which the intensity of a plane stays above a fraction of the plane's maximum.
///
/// Angles are degrees from nadir, positive on the side of the plane's first half (C0 or C90). Around a
/// maximum near the zenith they may pass 180.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Where the intensity falls below the fraction on the negative side.
    pub from: f64,
    /// Where the plane's maximum lies.
    pub peak: f64,
    /// Where the intensity falls below the fraction on the positive side.
    pub to: f64,
}

impl Spread {
    /// The full angle in degrees, 360 where the intensity never falls below the fraction.
    pub fn angle(&self) -> f64 {
        (self.to - self.from).min(360.0)
    }
}

impl Distribution {
    /// Flux in lumens between two gamma angles in degrees. Exact for types C and A; for type B by quadrature
    /// to about 1e-4 of the flux, unless the zone is the whole sphere.
    pub fn flux_between(&self, from: f64, to: f64) -> f64 {
        let (from, to) = (from.clamp(0.0, 180.0), to.clamp(0.0, 180.0));
        if self.pole() == Pole::Nadir || (from <= 0.0 && to >= 180.0) {
            return self.polar_flux(from, to);
        }
        let rows = ((to - from) / FINE_STEP).ceil().max(0.0) as usize;
        let turns = (360.0 / FINE_STEP) as usize;
        let step = if rows == 0 { 0.0 } else { (to - from) / rows as f64 };
        let row = |index: usize| {
            let gamma = from + (index as f64 + 0.5) * step;
            let ring: f64 =
                (0..turns).map(|turn| self.intensity_at((turn as f64 + 0.5) * FINE_STEP, gamma)).sum();
            // The solid angle of a ring is exact; only the intensity within it is sampled.
            let solid = (gamma - 0.5 * step).to_radians().cos() - (gamma + 0.5 * step).to_radians().cos();
            ring * FINE_STEP.to_radians() * solid
        };
        (0..rows).map(row).sum()
    }

    /// Fluxes of the zones of `step` degrees (0.1 to 180) from nadir to zenith; their sum is the flux.
    pub fn zonal_fluxes(&self, step: f64) -> Vec<Zone> {
        let count = (180.0 / step.clamp(0.1, 180.0)).ceil() as usize;
        let edge = |index: usize| (index as f64 * step.clamp(0.1, 180.0)).min(180.0);
        let zone = |index: usize| {
            let (from, to) = (edge(index), edge(index + 1));
            Zone { from, to, lumens: self.flux_between(from, to) }
        };
        (0..count).map(zone).collect()
    }

    /// Flux below the horizontal, lumens.
    pub fn downward_flux(&self) -> f64 {
        self.flux_between(0.0, 90.0)
    }

    /// Flux above the horizontal, lumens.
    pub fn upward_flux(&self) -> f64 {
        self.flux_between(90.0, 180.0)
    }

    /// Intensities along a main plane for drawing: pairs of degrees from nadir (-180 to 180, positive towards
    /// C0 or C90) and candela, every `step` degrees (0.1 to 90) and at the angles of the file.
    pub fn polar_curve(&self, plane: MainPlane, step: f64) -> Vec<[f64; 2]> {
        let count = (180.0 / step.clamp(0.1, 90.0)).ceil() as usize;
        let mut gammas: Vec<f64> = (0..=count).map(|i| 180.0 * i as f64 / count as f64).collect();
        if self.pole() == Pole::Nadir {
            gammas.extend_from_slice(self.polars());
        }
        gammas.sort_by(f64::total_cmp);
        gammas.dedup();
        let right = gammas.iter().map(|&gamma| [gamma, self.intensity_at(plane.c(), gamma)]);
        let left = gammas.iter().rev().filter(|gamma| **gamma > 0.0);
        left.map(|&gamma| [-gamma, self.intensity_at(plane.c() + 180.0, gamma)]).chain(right).collect()
    }

    /// The beam angle in a main plane: down to half of the plane's maximum; none where the plane is dark.
    pub fn beam(&self, plane: MainPlane) -> Option<Spread> {
        self.spread(plane, 0.5)
    }

    /// The field angle in a main plane: down to a tenth of the plane's maximum; none where the plane is dark.
    pub fn field(&self, plane: MainPlane) -> Option<Spread> {
        self.spread(plane, 0.1)
    }

    /// The angle around the maximum of a main plane within which the intensity stays at or above `fraction`
    /// (0 to 1) of that maximum; none where the plane is dark.
    pub fn spread(&self, plane: MainPlane, fraction: f64) -> Option<Spread> {
        let knots = self.profile(plane);
        let (at, peak) =
            knots.iter().enumerate().max_by(|(i, a), (j, b)| a[1].total_cmp(&b[1]).then(j.cmp(i)))?;
        let least = peak[1] * fraction.clamp(0.0, 1.0);
        if peak[1] <= 0.0 {
            return None;
        }
        let forward = knots.iter().cycle().skip(at).take(knots.len() + 1).copied();
        let backward = knots.iter().rev().cycle().skip(knots.len() - 1 - at).take(knots.len() + 1);
        let to = peak[0] + fall(forward, least);
        let from = peak[0] - fall(backward.map(|&[t, value]| [-t, value]), least);
        Some(Spread { from, peak: peak[0], to })
    }

    /// The intensity around a main plane: knots of a piecewise linear curve over degrees from nadir, from
    /// -180 to 180, with zeros where the angles of the file end.
    fn profile(&self, plane: MainPlane) -> Vec<[f64; 2]> {
        let (c, opposite) = (plane.c(), plane.c() + 180.0);
        let gammas: Vec<f64> = match self.pole() {
            Pole::Nadir => self.polars().to_vec(),
            Pole::C90 => (0..=(180.0 / FINE_STEP) as usize).map(|i| i as f64 * FINE_STEP).collect(),
        };
        let side = |c: f64| {
            let mut knots: Vec<[f64; 2]> = gammas.iter().map(|&g| [g, self.intensity_at(c, g)]).collect();
            if let Some(&first) = gammas.first().filter(|gamma| **gamma > 0.0) {
                knots.insert(0, [first, 0.0]);
            }
            if let Some(&last) = gammas.last().filter(|gamma| **gamma < 180.0) {
                knots.push([last, 0.0]);
            }
            knots
        };
        let left = side(opposite).into_iter().rev().map(|[gamma, value]| [-gamma, value]);
        left.chain(side(c)).collect()
    }
}

/// How far a curve of ascending angles stays at or above `least`, starting at its first knot, in degrees and
/// at most 360; angles wrap around at 360.
fn fall(knots: impl Iterator<Item = [f64; 2]>, least: f64) -> f64 {
    let mut walked = 0.0;
    let mut before: Option<[f64; 2]> = None;
    for [angle, value] in knots {
        if let Some([last, high]) = before {
            let step = (angle - last).rem_euclid(360.0);
            if value < least {
                let share = if high > value { (high - least) / (high - value) } else { 0.0 };
                return walked + step * share.clamp(0.0, 1.0);
            }
            walked += step;
        }
        before = Some([angle, value]);
    }
    360.0
}
