//! Sky, sun and ground together.

use super::cie::CieType;
use super::error::DaylightError;
use super::perez::PerezSky;
use super::presets::Weather;
use super::sky::{Pattern, Sky};
use super::sun::{SUN_DIAMETER, SunPosition, extraterrestrial_normal, sun_solid_angle};
use glam::DVec3;
use std::f64::consts::PI;

/// Lumens per watt of white light by which the program's radiometric bands are converted: a luminance of L
/// cd/m² is a radiance of L/179 W/(m² sr) in every band.
pub const LUMINOUS_EFFICACY: f64 = 179.0;

/// Reflectance of the ground where nothing else is known.
pub const USUAL_GROUND: f64 = 0.2;

/// More light than any sky or sun gives, lux.
const MOST_LUX: f64 = 1e6;

/// All light outdoors: a sky, the sun as a disc of its real size, and a ground of one luminance.
///
/// Directions: x east, y north, z up. The ground fills the half space below the horizon, is a diffuse
/// reflector, and lies in no shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Daylight {
    sky: Sky,
    sun: SunPosition,
    direct_normal: f64,
    ground: f64,
}

/// What a clock and a sky say of the day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The sun is up.
    Day,
    /// The sun is down, at most 18 degrees below the horizon.
    Twilight,
    /// The sun is further down.
    Night,
}

impl Phase {
    /// The phase for an elevation of the sun.
    pub fn of(sun: SunPosition) -> Self {
        match sun.elevation() {
            up if up > 0.0 => Self::Day,
            low if low >= -18.0 => Self::Twilight,
            _ => Self::Night,
        }
    }
}

impl Daylight {
    /// A sky with the sun that shapes it. `direct_normal` is the illuminance in lux that the sun alone gives
    /// a surface facing it, and counts only while the sun is up; `ground` is the reflectance of the ground.
    ///
    /// # Errors
    /// A reflectance outside 0 to 1, or an illuminance that is negative or above a million lux.
    pub fn new(
        pattern: Pattern,
        sun: SunPosition,
        diffuse_horizontal: f64,
        direct_normal: f64,
        ground: f64,
    ) -> Result<Self, DaylightError> {
        if !(0.0..=1.0).contains(&ground) {
            return Err(DaylightError::new(format!(
                "the reflectance of the ground is {ground}, but must lie between 0 and 1"
            )));
        }
        for (what, lux) in [("sky", diffuse_horizontal), ("sun", direct_normal)] {
            if !(0.0..=MOST_LUX).contains(&lux) {
                return Err(DaylightError::new(format!(
                    "the illuminance by the {what} is {lux} lux, but must lie between 0 and a million"
                )));
            }
        }
        let sky = Sky::new(pattern, sun, diffuse_horizontal);
        Ok(Self { sky, sun, direct_normal: if sun.is_up() { direct_normal } else { 0.0 }, ground })
    }

    /// A plain kind of weather with the light that it usually gives.
    ///
    /// # Errors
    /// A reflectance outside 0 to 1.
    pub fn usual(
        weather: Weather,
        sun: SunPosition,
        day_of_year: u32,
        ground: f64,
    ) -> Result<Self, DaylightError> {
        Self::of_type(weather.sky(), sun, day_of_year, ground)
    }

    /// A sky of the CIE with the light that its kind of weather usually gives.
    ///
    /// # Errors
    /// A reflectance outside 0 to 1.
    pub fn of_type(
        kind: CieType,
        sun: SunPosition,
        day_of_year: u32,
        ground: f64,
    ) -> Result<Self, DaylightError> {
        let weather = Weather::of(kind);
        let diffuse = weather.diffuse_horizontal(sun);
        Self::new(Pattern::Cie(kind), sun, diffuse, weather.direct_normal(sun, day_of_year), ground)
    }

    /// An all-weather sky of Perez from irradiances: `direct_normal` and `diffuse_horizontal` in W/m² on a
    /// day of the year, under `water` cm of precipitable water, made lux by the efficacies of Perez et al.
    /// 1990. Without diffuse light the sky is dark.
    ///
    /// # Errors
    /// Irradiances that are negative or exceed what reaches the Earth by far, or a reflectance outside 0 to
    /// 1.
    pub fn of_irradiances(
        direct_normal: f64,
        diffuse_horizontal: f64,
        sun: SunPosition,
        day_of_year: u32,
        water: f64,
        ground: f64,
    ) -> Result<Self, DaylightError> {
        let extraterrestrial = extraterrestrial_normal(day_of_year);
        for (what, watts) in [("direct normal", direct_normal), ("diffuse horizontal", diffuse_horizontal)] {
            if !(0.0..=1500.0).contains(&watts) {
                return Err(DaylightError::new(format!(
                    "the {what} irradiance is {watts} W/m², but must lie between 0 and 1500"
                )));
            }
        }
        let Some(perez) = PerezSky::new(sun, direct_normal, diffuse_horizontal, extraterrestrial) else {
            // A sun without a sky: clear by definition, with the efficacy of the clearest class.
            let clear = PerezSky::new(sun, direct_normal, 1e-3, extraterrestrial);
            let lux = direct_normal * clear.map_or(0.0, |perez| perez.direct_efficacy(water));
            return Self::new(Pattern::Dark, sun, 0.0, lux, ground);
        };
        let (sky, direct) = (perez.diffuse_efficacy(water), perez.direct_efficacy(water));
        Self::new(Pattern::Perez(perez), sun, diffuse_horizontal * sky, direct_normal * direct, ground)
    }

    /// The sky without the sun.
    pub fn sky(&self) -> &Sky {
        &self.sky
    }

    /// Where the sun stands.
    pub fn sun(&self) -> SunPosition {
        self.sun
    }

    /// Illuminance in lux of a surface that faces the sun, from the sun alone.
    pub fn direct_normal(&self) -> f64 {
        self.direct_normal
    }

    /// Luminance in cd/m² of the sun's disc.
    pub fn sun_luminance(&self) -> f64 {
        self.direct_normal / sun_solid_angle()
    }

    /// Illuminance in lux of the unobstructed horizontal from the sun alone.
    pub fn direct_horizontal(&self) -> f64 {
        self.direct_normal * self.sun.direction().z.max(0.0)
    }

    /// Illuminance in lux of the unobstructed horizontal from sky and sun.
    pub fn global_horizontal(&self) -> f64 {
        self.sky.horizontal() + self.direct_horizontal()
    }

    /// Reflectance of the ground.
    pub fn ground_reflectance(&self) -> f64 {
        self.ground
    }

    /// Luminance in cd/m² of the ground: its reflectance times the global illuminance over pi.
    pub fn ground_luminance(&self) -> f64 {
        self.ground * self.global_horizontal() / PI
    }

    /// Luminance in cd/m² of sky or ground in a direction of any length, without the sun's disc.
    pub fn luminance(&self, e: DVec3) -> f64 {
        if e.z < 0.0 { self.ground_luminance() } else { self.sky.luminance(e) }
    }

    /// Radiance in W/(m² sr), the same in every band, of what [`Daylight::luminance`] is the luminance of.
    pub fn radiance(&self, e: DVec3) -> f64 {
        self.luminance(e) / LUMINOUS_EFFICACY
    }

    /// Whether a direction of any length meets the sun's disc.
    pub fn meets_sun(&self, e: DVec3) -> bool {
        let half = (0.5 * SUN_DIAMETER).to_radians();
        // By the chord, since the cosine of so small an angle has few digits.
        let chord = (e.normalize_or_zero() - self.sun.direction()).length();
        self.direct_normal > 0.0 && e.z >= 0.0 && chord <= 2.0 * (0.5 * half).sin()
    }

    /// Illuminance in lux of an unobstructed surface with the unit `normal`, from sky, sun and ground.
    pub fn illuminance(&self, normal: DVec3) -> f64 {
        let sun = self.direct_normal * normal.dot(self.sun.direction()).max(0.0);
        let ground = PI * self.ground_luminance() * 0.5 * (1.0 - normal.z);
        self.sky.illuminance(normal) + sun + ground
    }
}
