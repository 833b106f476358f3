//! Daylight: the sun of a place and time, the luminance of skies, weather files.
//!
//! Angles are in degrees where nothing else is said: elevation above the horizon, azimuth from north
//! clockwise as seen from above (east 90, south 180). Directions of the sky are x east, y north, z up; a
//! [`Compass`] turns them into the axes of a model. Light is photometric: lux and cd/m².
//!
//! Sources: Reda & Andreas, "Solar position algorithm for solar radiation applications" (2004); CIE S 011
//! (2003) = ISO 15469; Perez, Ineichen, Seals, Michalsky & Stewart, "Modeling daylight availability and
//! irradiance components from direct and global irradiance" (1990); Perez, Seals & Michalsky, "All-weather
//! model for sky luminance distribution" (1993); Tregenza, "Subdivision of the sky hemisphere for luminance
//! measurements" (1987); Crawley, Hand & Lawrie, "Improving the weather information available to simulation
//! programs" (1999).

mod bins;
mod cie;
mod compass;
mod day;
mod epw;
mod error;
mod hemisphere;
mod opening;
mod outdoors;
mod perez;
mod picture;
mod place;
mod presets;
mod sky;
mod sun;
mod weather;

#[cfg(test)]
mod tests;

pub use bins::{BinValue, SkyBins};
pub use cie::CieType;
pub use compass::Compass;
pub use day::DayLength;
pub use error::{DaylightError, WeatherError};
pub use outdoors::{Daylight, LUMINOUS_EFFICACY, Phase, USUAL_GROUND};
pub use perez::{PerezSky, USUAL_WATER, water_of_dew_point};
pub use picture::Projection;
pub use place::{Date, LocalTime, MONTHS, Place};
pub use presets::Weather;
pub use sky::{Pattern, Sky};
pub use sun::{
    SOLAR_CONSTANT, SUN_DIAMETER, SunPosition, angles, direction, eccentricity, extraterrestrial_normal,
    sun_solid_angle,
};
pub use weather::{BrightestHour, WeatherFile, WeatherHour, WeatherStation, WeatherSummary};
