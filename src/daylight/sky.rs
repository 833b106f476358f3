//! Skies without their sun: luminance by direction.

use super::cie::CieType;
use super::hemisphere;
use super::perez::PerezSky;
use super::sun::SunPosition;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// The shape of a sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// No light at all.
    Dark,
    /// The same luminance everywhere.
    Uniform,
    /// A sky of the CIE.
    Cie(CieType),
    /// An all-weather sky of Perez.
    Perez(PerezSky),
}

/// The luminance of a sky without the sun in every direction, scaled to a horizontal illuminance.
///
/// Directions: x east, y north, z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    pattern: Pattern,
    /// Unit vector towards the sun, or to the point of the horizon below which it stands.
    to_sun: DVec3,
    sun_zenith: f64,
    /// cd/m² for a relative luminance of 1.
    scale: f64,
    horizontal: f64,
}

impl Sky {
    /// A sky of a pattern under which an unobstructed horizontal surface receives `horizontal` lux. A sun
    /// below the horizon shapes the sky as one at the horizon would. An illuminance that is zero, negative or
    /// not finite makes the sky dark.
    pub fn new(pattern: Pattern, sun: SunPosition, horizontal: f64) -> Self {
        let lifted = sun.not_below_horizon();
        let sun_zenith = FRAC_PI_2 - lifted.elevation().to_radians();
        let sky = Self { pattern, to_sun: lifted.direction(), sun_zenith, scale: 1.0, horizontal };
        let dark = Self { pattern: Pattern::Dark, scale: 0.0, horizontal: 0.0, ..sky };
        if !(horizontal > 0.0 && horizontal.is_finite()) || pattern == Pattern::Dark {
            return dark;
        }
        let relative = match pattern {
            Pattern::Uniform => PI,
            _ => hemisphere::irradiance(DVec3::Z, sky.to_sun, |e| sky.relative(e)),
        };
        // A pattern that is black all over cannot be scaled; no measured sky gives one.
        if !(relative > 0.0 && relative.is_finite()) {
            return Self { pattern: Pattern::Uniform, scale: horizontal / PI, ..sky };
        }
        Self { scale: horizontal / relative, ..sky }
    }

    /// A sky without light.
    pub fn dark() -> Self {
        Self { pattern: Pattern::Dark, to_sun: DVec3::Z, sun_zenith: 0.0, scale: 0.0, horizontal: 0.0 }
    }

    /// Its shape.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// Illuminance in lux of an unobstructed horizontal surface.
    pub fn horizontal(&self) -> f64 {
        self.horizontal
    }

    /// Luminance in cd/m² in the direction `e` of any length; 0 below the horizon.
    pub fn luminance(&self, e: DVec3) -> f64 {
        let length = e.length();
        if !(length > 0.0 && length.is_finite()) || e.z < 0.0 {
            return 0.0;
        }
        self.scale * self.relative(e / length)
    }

    /// Luminance in cd/m² of the zenith.
    pub fn zenith(&self) -> f64 {
        self.luminance(DVec3::Z)
    }

    /// Illuminance in lux of a surface with the unit `normal`, from the sky alone and unobstructed.
    pub fn illuminance(&self, normal: DVec3) -> f64 {
        match self.pattern {
            Pattern::Dark => 0.0,
            Pattern::Uniform => self.horizontal * 0.5 * (1.0 + normal.z),
            _ => hemisphere::irradiance(normal, self.to_sun, |e| self.scale * self.relative(e)),
        }
    }

    /// What it is, in a few words.
    pub fn description(&self) -> String {
        match self.pattern {
            Pattern::Dark => "dark".to_owned(),
            Pattern::Uniform => "uniform sky".to_owned(),
            Pattern::Cie(kind) => kind.to_string(),
            Pattern::Perez(perez) => format!(
                "Perez all-weather sky: clearness {:.3} (class {}), brightness {:.4}",
                perez.clearness, perez.class, perez.brightness
            ),
        }
    }

    fn relative(&self, e: DVec3) -> f64 {
        // The arc between unit vectors from their chord: accurate beside the sun, where acos is not.
        let to_sun = || 2.0 * (0.5 * (e - self.to_sun).length()).min(1.0).asin();
        match self.pattern {
            Pattern::Dark => 0.0,
            Pattern::Uniform => 1.0,
            Pattern::Cie(kind) => kind.relative_luminance(e.z, to_sun(), self.sun_zenith),
            Pattern::Perez(perez) => perez.relative_luminance(e.z, to_sun()),
        }
    }
}
