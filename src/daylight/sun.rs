//! Where the sun stands, and its disc.

use super::error::DaylightError;
use super::place::{LocalTime, Place};
use glam::DVec3;
use solar_positioning::time::JulianDate;
use solar_positioning::{Location, RefractionCorrection, SolarPositions, delta_t};
use std::f64::consts::TAU;

/// Mean apparent diameter of the sun, degrees.
pub const SUN_DIAMETER: f64 = 0.533;

/// Direct normal irradiance outside the atmosphere at the mean distance of the sun, W/m² (the value that
/// Perez et al. 1993 use).
pub const SOLAR_CONSTANT: f64 = 1367.0;

/// Solid angle of the sun's disc, steradian: 2 pi (1 - cos of half of [`SUN_DIAMETER`]), 6.797e-5.
pub fn sun_solid_angle() -> f64 {
    // 1 - cos x = 2 sin²(x/2), without cancellation.
    let half = (0.25 * SUN_DIAMETER).to_radians().sin();
    2.0 * TAU * half * half
}

/// Where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    elevation: f64,
    azimuth: f64,
}

impl SunPosition {
    /// A sun at an elevation (-90 to 90 degrees above the horizon) and an azimuth (degrees from north,
    /// clockwise as seen from above: east 90, south 180).
    ///
    /// # Errors
    /// An elevation out of range, or a value that is not finite.
    pub fn new(elevation: f64, azimuth: f64) -> Result<Self, DaylightError> {
        if !(-90.0..=90.0).contains(&elevation) {
            return Err(DaylightError::new(format!(
                "the elevation of the sun is {elevation}, but must lie between -90 and 90 degrees"
            )));
        }
        if !azimuth.is_finite() {
            return Err(DaylightError::new(format!(
                "the azimuth of the sun is {azimuth}, which is no angle"
            )));
        }
        Ok(Self { elevation, azimuth: azimuth.rem_euclid(360.0) })
    }

    /// The sun of a place and time as geometry has it, without refraction by the air, which lifts it by 0.5
    /// degrees at the horizon and 0.02 at 40 degrees. NREL's solar position algorithm (Reda & Andreas 2004).
    ///
    /// # Errors
    /// None for a valid place and time; what the algorithm refuses is passed on.
    pub fn at(place: Place, time: LocalTime) -> Result<Self, DaylightError> {
        Self::computed(place, time, 0.0, None)
    }

    /// As [`SunPosition::at`], as seen through air of `pressure` in millibars and `temperature` in degrees
    /// Celsius, at `altitude` metres above sea level.
    ///
    /// # Errors
    /// Air that cannot be: a pressure out of 1 to 2000 mbar, a temperature below absolute zero.
    pub fn refracted(
        place: Place,
        time: LocalTime,
        altitude: f64,
        pressure: f64,
        temperature: f64,
    ) -> Result<Self, DaylightError> {
        let air = RefractionCorrection::new(pressure, temperature).map_err(refused)?;
        Self::computed(place, time, altitude, Some(air))
    }

    fn computed(
        place: Place,
        time: LocalTime,
        altitude: f64,
        air: Option<RefractionCorrection>,
    ) -> Result<Self, DaylightError> {
        let date = time.date();
        let delta_t = delta_t::estimate_from_date(date.year(), date.month()).map_err(refused)?;
        let midnight = JulianDate::from_utc(date.year(), date.month(), date.day(), 0, 0, 0.0, delta_t);
        let midnight = midnight.map_err(refused)?.julian_date();
        let utc_hours = time.hours() - place.zone();
        let julian = JulianDate::new(midnight + utc_hours / 24.0, delta_t).map_err(refused)?;
        let location = Location { latitude: place.latitude(), longitude: place.longitude() };
        let found = SolarPositions::new().at_from_julian(julian, location, altitude, air).map_err(refused)?;
        Self::new(found.elevation_angle().clamp(-90.0, 90.0), found.azimuth())
    }

    /// Degrees above the horizon, -90 to 90.
    pub fn elevation(self) -> f64 {
        self.elevation
    }

    /// Degrees from north, clockwise as seen from above, 0 to 360.
    pub fn azimuth(self) -> f64 {
        self.azimuth
    }

    /// Whether its centre stands above the horizon.
    pub fn is_up(self) -> bool {
        self.elevation > 0.0
    }

    /// Unit vector towards the sun: x east, y north, z up.
    pub fn direction(self) -> DVec3 {
        direction(self.elevation, self.azimuth)
    }

    /// The same sun, lifted to the horizon if it stands below.
    pub(super) fn not_below_horizon(self) -> Self {
        Self { elevation: self.elevation.max(0.0), ..self }
    }
}

fn refused(error: solar_positioning::Error) -> DaylightError {
    DaylightError::new(format!("the position of the sun cannot be computed: {error}"))
}

/// The unit vector of an elevation and an azimuth in degrees: x east, y north, z up.
pub fn direction(elevation: f64, azimuth: f64) -> DVec3 {
    let (up, level) = elevation.to_radians().sin_cos();
    let (east, north) = azimuth.to_radians().sin_cos();
    DVec3::new(level * east, level * north, up)
}

/// Elevation and azimuth (0 to 360) in degrees of a direction of any length.
pub fn angles(direction: DVec3) -> (f64, f64) {
    let level = direction.x.hypot(direction.y);
    let azimuth = direction.x.atan2(direction.y).to_degrees();
    // A tiny negative angle rounds to 360, which is 0.
    let azimuth = if azimuth < 0.0 { (azimuth + 360.0) % 360.0 } else { azimuth };
    (direction.z.atan2(level).to_degrees(), azimuth)
}

/// Irradiance outside the atmosphere on a surface that faces the sun, W/m²: the solar constant times the
/// eccentricity of the day (Spencer 1971).
pub fn extraterrestrial_normal(day_of_year: u32) -> f64 {
    SOLAR_CONSTANT * eccentricity(day_of_year)
}

/// (mean distance / distance)² of the sun on a day of the year, 0.966 to 1.035 (Spencer 1971).
pub fn eccentricity(day_of_year: u32) -> f64 {
    let angle = TAU * (f64::from(day_of_year) - 1.0) / 365.0;
    let (sin, cos) = angle.sin_cos();
    let (sin_2, cos_2) = (2.0 * angle).sin_cos();
    1.000_11 + 0.034_221 * cos + 0.001_28 * sin + 0.000_719 * cos_2 + 0.000_077 * sin_2
}
