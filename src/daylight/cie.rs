//! The CIE standard general sky.

use super::error::DaylightError;
use std::f64::consts::FRAC_PI_2;

/// A sky of CIE S 011:2003 (ISO 15469:2004): one of its fifteen types, or number 16, the traditional overcast
/// sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CieType(u8);

/// a, b of the gradation and c, d, e of the indicatrix for types 1 to 15 (CIE S 011, table 1).
const PARAMETERS: [[f64; 5]; 15] = [
    [4.0, -0.70, 0.0, -1.0, 0.0],
    [4.0, -0.70, 2.0, -1.5, 0.15],
    [1.1, -0.80, 0.0, -1.0, 0.0],
    [1.1, -0.80, 2.0, -1.5, 0.15],
    [0.0, -1.00, 0.0, -1.0, 0.0],
    [0.0, -1.00, 2.0, -1.5, 0.15],
    [0.0, -1.00, 5.0, -2.5, 0.30],
    [0.0, -1.00, 10.0, -3.0, 0.45],
    [-1.0, -0.55, 2.0, -1.5, 0.15],
    [-1.0, -0.55, 5.0, -2.5, 0.30],
    [-1.0, -0.55, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 10.0, -3.0, 0.45],
    [-1.0, -0.32, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 16.0, -3.0, 0.30],
    [-1.0, -0.15, 24.0, -2.8, 0.15],
];

/// Descriptions of the types, in the words of the standard, shortened.
const NAMES: [&str; 16] = [
    "overcast, steep gradation, the same in all azimuths",
    "overcast, steep gradation, slightly brighter towards the sun",
    "overcast, moderate gradation, the same in all azimuths",
    "overcast, moderate gradation, slightly brighter towards the sun",
    "uniform",
    "partly cloudy, no gradation, slightly brighter towards the sun",
    "partly cloudy, no gradation, brighter circumsolar region",
    "partly cloudy, no gradation, distinct solar corona",
    "partly cloudy, obscured sun",
    "partly cloudy, brighter circumsolar region",
    "white-blue, distinct solar corona",
    "clear, low turbidity",
    "clear, polluted atmosphere",
    "cloudless and turbid, broad solar corona",
    "white-blue and turbid, broad solar corona",
    "traditional overcast",
];

impl CieType {
    /// The traditional overcast sky (Moon & Spencer 1942).
    pub const OVERCAST: Self = Self(16);
    /// The classic clear sky of the CIE.
    pub const CLEAR: Self = Self(12);
    /// The uniform sky.
    pub const UNIFORM: Self = Self(5);
    /// Partly cloudy with a brighter circumsolar region.
    pub const INTERMEDIATE: Self = Self(7);

    /// The type of a number from 1 to 16.
    ///
    /// # Errors
    /// Any other number.
    pub fn new(number: u8) -> Result<Self, DaylightError> {
        if (1..=16).contains(&number) {
            return Ok(Self(number));
        }
        Err(DaylightError::new(format!(
            "there is no CIE sky of type {number}; the types are 1 to 15, and 16 for the traditional \
             overcast sky"
        )))
    }

    /// 1 to 16.
    pub fn number(self) -> u8 {
        self.0
    }

    /// What the standard calls it, shortened.
    pub fn name(self) -> &'static str {
        NAMES[usize::from(self.0 - 1)]
    }

    /// Whether its luminance depends on where the sun stands.
    pub fn follows_sun(self) -> bool {
        self.parameters().is_some_and(|[_, _, c, _, e]| c != 0.0 || e != 0.0)
    }

    fn parameters(self) -> Option<[f64; 5]> {
        PARAMETERS.get(usize::from(self.0 - 1)).copied()
    }

    /// Luminance over that of the zenith (CIE S 011, equations 1 to 5), in a direction with the sine `sine`
    /// of its elevation (0 to 1), `to_sun` radians from the sun, whose zenith angle is `sun_zenith` radians
    /// (0 to pi/2). Above zero, finite.
    pub fn relative_luminance(self, sine: f64, to_sun: f64, sun_zenith: f64) -> f64 {
        let Some([a, b, c, d, e]) = self.parameters() else {
            // Moon & Spencer 1942.
            return (1.0 + 2.0 * sine) / 3.0;
        };
        // 1 at the horizon itself, where the exponent runs to minus infinity.
        let gradation = |sine: f64| 1.0 + a * (b / sine.max(0.0)).exp();
        let indicatrix = |angle: f64| {
            1.0 + c * ((d * angle).exp() - (d * FRAC_PI_2).exp()) + e * angle.cos() * angle.cos()
        };
        indicatrix(to_sun) * gradation(sine) / (indicatrix(sun_zenith) * gradation(1.0))
    }
}

impl std::fmt::Display for CieType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            16 => write!(f, "CIE traditional overcast sky"),
            number => write!(f, "CIE sky type {number}: {}", self.name()),
        }
    }
}
