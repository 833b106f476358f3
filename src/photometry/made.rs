//! Plausible luminaires for where no photometric file is at hand. All have an integrated flux of 1000 lm.

use super::error::InvalidDistribution;
use super::{Distribution, Opening, OpeningShape, Photometry, direction};

/// A kind of luminaire that the program has a distribution of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MadeKind {
    /// Recessed in a ceiling: a round, glare-free cone of 60 degrees to half of its maximum.
    Downlight,
    /// Hangs in the room: an opal globe that sends more down than up.
    Pendant,
    /// A narrow round beam of 24 degrees.
    Spot,
    /// A small opal globe that shines evenly all around.
    Bulb,
    /// Long, beside a wall: brightest at 35 degrees from the nadir towards C90.
    WallWasher,
}

/// Flux of all of them, lumens.
const FLUX: f64 = 1000.0;
/// Steps of gamma and C, degrees.
const STEP: f64 = 2.5;
const TURN: f64 = 10.0;
/// Steps between the edges of a cone.
const CONE_STEPS: u32 = 24;
/// Half-value half-angles, degrees.
const DOWNLIGHT: f64 = 30.0;
const SPOT: f64 = 12.0;
const WASHER: f64 = 25.0;
/// Where a wall washer is brightest, degrees from the nadir.
const WASHER_PEAK: f64 = 35.0;
/// Where downlights and wall washers begin and end to be cut off by their rims, degrees.
const RIM: [f64; 2] = [60.0, 80.0];

impl MadeKind {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Downlight => "downlight",
            Self::Pendant => "pendant",
            Self::Spot => "spot",
            Self::Bulb => "bulb",
            Self::WallWasher => "wall washer",
        }
    }

    /// Usual extents of the opening along C0 and C90, metres; pendants and bulbs are as high as they are long.
    pub fn usual_size(self) -> [f64; 2] {
        match self {
            Self::Downlight => [0.15, 0.15],
            Self::Pendant => [0.3, 0.3],
            Self::Spot => [0.08, 0.08],
            Self::Bulb => [0.06, 0.06],
            Self::WallWasher => [0.6, 0.1],
        }
    }

    fn opening(self, [along_c0, along_c90]: [f64; 2]) -> Opening {
        let shape = match self {
            Self::Downlight | Self::Spot => OpeningShape::Disc,
            Self::Pendant | Self::Bulb => OpeningShape::Ellipsoid,
            Self::WallWasher => OpeningShape::Rectangle,
        };
        let height = if shape == OpeningShape::Ellipsoid { along_c0 } else { 0.0 };
        Opening { shape, along_c0, along_c90, height }
    }

    /// Relative intensity at C and gamma, degrees.
    fn shape(self, c: f64, gamma: f64) -> f64 {
        // Half at the angle given, as a Gaussian has it.
        let bell = |angle: f64, half: f64| (-(angle / half).powi(2) * std::f64::consts::LN_2).exp();
        let [begin, end] = RIM;
        let rim = ((end - gamma) / (end - begin)).clamp(0.0, 1.0);
        match self {
            Self::Downlight => bell(gamma, DOWNLIGHT) * rim,
            Self::Pendant => 0.65 + 0.35 * gamma.to_radians().cos(),
            Self::Spot => bell(gamma, SPOT) * rim,
            Self::Bulb => 1.0,
            Self::WallWasher => {
                let off = direction(c, gamma).dot(direction(90.0, WASHER_PEAK)).clamp(-1.0, 1.0).acos();
                bell(off.to_degrees(), WASHER) * rim
            }
        }
    }

    /// Photometry of this kind with an opening of these extents along C0 and C90, metres.
    ///
    /// # Errors
    /// None for the kinds that there are: their tables are valid.
    pub fn photometry(self, size: [f64; 2]) -> Result<Photometry, InvalidDistribution> {
        let angles = |last: f64, step: f64| -> Vec<f64> {
            (0..=(last / step).round() as u32).map(|k| f64::from(k) * step).collect()
        };
        let planes = if self == Self::WallWasher { angles(360.0, TURN) } else { vec![0.0] };
        let gammas = angles(if matches!(self, Self::Pendant | Self::Bulb) { 180.0 } else { 90.0 }, STEP);
        let candelas: Vec<f64> =
            planes.iter().flat_map(|&c| gammas.iter().map(move |&gamma| self.shape(c, gamma))).collect();
        self.of(Distribution::new(&planes, &gammas, &candelas)?, size)
    }

    /// A spot that shines fully within the first of these angles of its beam and not outside of the second, degrees from
    /// edge to edge, 0 to 180 and rising; between them as glTF has it (KHR_lights_punctual): with the square of the
    /// share of the cosine.
    ///
    /// # Errors
    /// Angles that do not rise, or are none.
    pub fn cone(angles: [f64; 2], size: [f64; 2]) -> Result<Photometry, InvalidDistribution> {
        let [inner, outer] = angles.map(|angle| 0.5 * angle);
        let [full, none] = [inner, outer].map(|angle| angle.to_radians().cos());
        let mut gammas = if inner > 0.0 { vec![0.0] } else { Vec::new() };
        gammas
            .extend((0..=CONE_STEPS).map(|k| inner + (outer - inner) * f64::from(k) / f64::from(CONE_STEPS)));
        let share = |gamma: f64| ((gamma.to_radians().cos() - none) / (full - none)).clamp(0.0, 1.0);
        let mut candelas: Vec<f64> = gammas.iter().map(|&gamma| share(gamma).powi(2)).collect();
        // The last one is where it ends, whatever rounding says.
        if let Some(last) = candelas.last_mut() {
            *last = 0.0;
        }
        if outer < 90.0 {
            gammas.push(90.0);
            candelas.push(0.0);
        }
        Self::Spot.of(Distribution::new(&[0.0], &gammas, &candelas)?, size)
    }

    fn of(self, distribution: Distribution, size: [f64; 2]) -> Result<Photometry, InvalidDistribution> {
        let scaled = distribution.scaled(FLUX / distribution.flux());
        Ok(Photometry::made(self.name(), scaled.unwrap_or(distribution), self.opening(size)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::MainPlane;

    #[test]
    fn each_kind_has_its_flux_and_the_beam_that_its_name_promises() {
        let made = |kind: MadeKind| kind.photometry(kind.usual_size()).expect("a valid table");
        for kind in
            [MadeKind::Downlight, MadeKind::Pendant, MadeKind::Spot, MadeKind::Bulb, MadeKind::WallWasher]
        {
            assert!((made(kind).flux() - 1000.0).abs() < 1e-6, "{}", kind.name());
        }
        let beam = |kind| made(kind).distribution.beam(MainPlane::C0C180).expect("a beam").angle();
        assert!((beam(MadeKind::Spot) - 24.0).abs() < 0.5, "{}", beam(MadeKind::Spot));
        assert!((beam(MadeKind::Downlight) - 60.0).abs() < 0.5, "{}", beam(MadeKind::Downlight));
        let pendant = made(MadeKind::Pendant).distribution;
        let up = pendant.upward_flux() / pendant.flux();
        assert!((0.3..0.45).contains(&up), "{up} of a pendant's light goes up");
        let peak = made(MadeKind::WallWasher).distribution.maximum();
        assert_eq!((peak.c, peak.gamma), (90.0, 35.0));
    }
}
