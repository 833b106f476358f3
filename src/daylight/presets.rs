//! Plain skies with the light that they usually give.

use super::cie::CieType;
use super::sun::{SunPosition, eccentricity};

/// A state of the weather with illuminances by the elevation of the sun.
///
/// Illuminances: Gillette, Pierpoint & Treado, "A general illuminance model for daylight availability"
/// (1984), as in the recommended practice of the IES for daylight availability (RP-21).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Weather {
    /// CIE type 12 and a bright sun.
    #[default]
    Clear,
    /// CIE type 7 and a sun through thin cloud.
    Intermediate,
    /// CIE traditional overcast, no sun.
    Overcast,
}

/// Illuminance outside the atmosphere on a surface that faces the sun at its mean distance, lux.
const EXTRATERRESTRIAL: f64 = 127_500.0;

/// Horizontal illuminances in lux at the ends of civil, nautical and astronomical twilight, with the
/// elevation of the sun in degrees (Seidelmann, "Explanatory Supplement to the Astronomical Almanac", 1992).
const TWILIGHT: [(f64, f64); 3] = [(-6.0, 3.4), (-12.0, 0.008), (-18.0, 0.0006)];

impl Weather {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Clear, Self::Intermediate, Self::Overcast];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Intermediate => "intermediate",
            Self::Overcast => "overcast",
        }
    }

    /// The sky of the CIE that stands for it.
    pub fn sky(self) -> CieType {
        match self {
            Self::Clear => CieType::CLEAR,
            Self::Intermediate => CieType::INTERMEDIATE,
            Self::Overcast => CieType::OVERCAST,
        }
    }

    /// The weather to which a type of the CIE belongs: 1 to 5 and 16 overcast, 6 to 10 intermediate, 11 to 15
    /// clear.
    pub fn of(kind: CieType) -> Self {
        match kind.number() {
            6..=10 => Self::Intermediate,
            11..=15 => Self::Clear,
            _ => Self::Overcast,
        }
    }

    /// Usual illuminance in lux of the horizontal from the sky alone. Below the horizon it falls through the
    /// twilight, and is 0 from 18 degrees on.
    pub fn diffuse_horizontal(self, sun: SunPosition) -> f64 {
        let by_day = |elevation: f64| {
            let sine = elevation.to_radians().sin();
            1000.0
                * match self {
                    Self::Clear => 0.8 + 15.5 * sine.sqrt(),
                    Self::Intermediate => 0.3 + 45.0 * sine,
                    Self::Overcast => 0.3 + 21.0 * sine,
                }
        };
        let elevation = sun.elevation();
        if elevation >= 0.0 {
            return by_day(elevation);
        }
        let mut before = (0.0, by_day(0.0));
        for after in TWILIGHT {
            if elevation >= after.0 {
                let share = (elevation - before.0) / (after.0 - before.0);
                // Light falls by about the same factor per degree.
                return before.1 * (after.1 / before.1).powf(share);
            }
            before = after;
        }
        0.0
    }

    /// Usual illuminance in lux of a surface that faces the sun, from the sun alone, on a day of the year; 0
    /// while the sun is down.
    pub fn direct_normal(self, sun: SunPosition, day_of_year: u32) -> f64 {
        let extinction = match self {
            Self::Clear => 0.21,
            Self::Intermediate => 0.80,
            Self::Overcast => return 0.0,
        };
        if !sun.is_up() {
            return 0.0;
        }
        let air = 1.0 / sun.elevation().to_radians().sin();
        EXTRATERRESTRIAL * eccentricity(day_of_year) * (-extinction * air).exp()
    }
}
