//! Pictures of the sky.

use super::outdoors::Daylight;
use super::sun::{SUN_DIAMETER, direction};
use glam::DVec3;
use rayon::prelude::*;

/// Degrees between samples of a pixel that the sun's disc may touch.
const AT_SUN: f64 = 0.03;
/// Samples across and down such a pixel.
const MOST_AT_SUN: f64 = 256.0;
/// Samples across and down any other pixel, for its edges at horizon and rim.
const ELSEWHERE: u32 = 2;

/// How directions are laid out on a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Projection {
    /// The sky as a disc, as on a plan or a sun-path diagram: north at the top, east on the right, the zenith
    /// in the middle, distances in proportion to the angle from it, the horizon at the rim.
    #[default]
    Fisheye,
    /// All directions: azimuth from north over east, south and west back to north from left to right,
    /// elevation from the zenith at the top to the nadir at the bottom.
    LatitudeLongitude,
}

impl Projection {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Fisheye, Self::LatitudeLongitude];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fisheye => "fisheye",
            Self::LatitudeLongitude => "latlong",
        }
    }

    /// Pixels across and down that suit it.
    pub fn usual_size(self) -> [u32; 2] {
        match self {
            Self::Fisheye => [1024, 1024],
            Self::LatitudeLongitude => [2048, 1024],
        }
    }

    /// The unit vector seen at a place of a picture of `size` pixels, from its upper left corner; none
    /// outside the disc.
    pub fn direction(self, x: f64, y: f64, size: [u32; 2]) -> Option<DVec3> {
        let [width, height] = size.map(f64::from);
        match self {
            Self::Fisheye => {
                let radius = 0.5 * width.min(height);
                let (right, up) = ((x - 0.5 * width) / radius, (0.5 * height - y) / radius);
                let from_zenith = right.hypot(up);
                let azimuth = right.atan2(up).to_degrees();
                (from_zenith <= 1.0).then(|| direction(90.0 * (1.0 - from_zenith), azimuth))
            }
            Self::LatitudeLongitude => Some(direction(90.0 - 180.0 * y / height, 360.0 * x / width)),
        }
    }

    /// Degrees across a pixel at most; only near the poles of a picture of all directions is less in one.
    fn pixel_degrees(self, size: [u32; 2]) -> f64 {
        let [width, height] = size.map(f64::from);
        match self {
            // The rim of the disc is pi/2 times as long as its radius says.
            Self::Fisheye => 180.0 / width.min(height) * std::f64::consts::FRAC_PI_2,
            Self::LatitudeLongitude => (360.0 / width).max(180.0 / height),
        }
    }
}

impl Daylight {
    /// Luminances in cd/m² of a picture of `size` pixels with the sun's disc, rows from the top; 0 outside a
    /// disc.
    pub fn picture(&self, projection: Projection, size: [u32; 2]) -> Vec<f32> {
        let [width, height] = size;
        // Half the diagonal of a pixel, and half the disc.
        let reach = projection.pixel_degrees(size) * std::f64::consts::FRAC_1_SQRT_2 + 0.5 * SUN_DIAMETER;
        let reach_chord = 2.0 * (0.5 * reach.min(180.0).to_radians()).sin();
        let fine = (projection.pixel_degrees(size) / AT_SUN).clamp(8.0, MOST_AT_SUN) as u32;
        let sun = self.sun().direction();
        let pixel = |x: u32, y: u32| {
            let (x, y) = (f64::from(x), f64::from(y));
            let at_sun = self.direct_normal() > 0.0
                && projection
                    .direction(x + 0.5, y + 0.5, size)
                    .is_none_or(|e| (e - sun).length() <= reach_chord);
            let samples = if at_sun { fine } else { ELSEWHERE };
            let step = 1.0 / f64::from(samples);
            let mut sum = 0.0;
            for sample in 0..samples * samples {
                let (u, v) = (f64::from(sample % samples) + 0.5, f64::from(sample / samples) + 0.5);
                let Some(e) = projection.direction(x + u * step, y + v * step, size) else { continue };
                sum += self.luminance(e) + if self.meets_sun(e) { self.sun_luminance() } else { 0.0 };
            }
            (sum * step * step) as f32
        };
        let pixel = &pixel;
        (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| pixel(x, y))).collect()
    }
}
