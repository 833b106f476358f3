//! The all-weather sky and the luminous efficacies of R. Perez and others.

use super::sun::SunPosition;
use std::f64::consts::FRAC_PI_2;

/// Lower ends of the eight classes of clearness (Perez et al. 1990, table 1).
const CLASSES: [f64; 8] = [1.0, 1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2];
/// The model was fitted to skies whose brightness lies within these.
const BRIGHTNESS: [f64; 2] = [0.01, 0.6];
/// The gradation stays finite at the horizon where its exponent is at most this.
const LARGEST_B: f64 = -0.01;

/// x1 to x4 of the coefficients a, b, c, d, e by class (Perez, Seals & Michalsky 1993, table 1).
#[rustfmt::skip]
const COEFFICIENTS: [[[f64; 4]; 5]; 8] = [
    [[1.3525, -0.2576, -0.2690, -1.4366], [-0.7670, 0.0007, 1.2734, -0.1233],
     [2.8000, 0.6004, 1.2375, 1.0000], [1.8734, 0.6297, 0.9738, 0.2809], [0.0356, -0.1246, -0.5718, 0.9938]],
    [[-1.2219, -0.7730, 1.4148, 1.1016], [-0.2054, 0.0367, -3.9128, 0.9156],
     [6.9750, 0.1774, 6.4477, -0.1239], [-1.5798, -0.5081, -1.7812, 0.1080],
     [0.2624, 0.0672, -0.2190, -0.4285]],
    [[-1.1000, -0.2515, 0.8952, 0.0156], [0.2782, -0.1812, -4.5000, 1.1766],
     [24.7219, -13.0812, -37.7000, 34.8438], [-5.0000, 1.5218, 3.9229, -2.6204],
     [-0.0156, 0.1597, 0.4199, -0.5562]],
    [[-0.5484, -0.6654, -0.2672, 0.7117], [0.7234, -0.6219, -5.6812, 2.6297],
     [33.3389, -18.3000, -62.2500, 52.0781], [-3.5000, 0.0016, 1.1477, 0.1062],
     [0.4659, -0.3296, -0.0876, -0.0329]],
    [[-0.6000, -0.3566, -2.5000, 2.3250], [0.2937, 0.0496, -5.6812, 1.8415],
     [21.0000, -4.7656, -21.5906, 7.2492], [-3.5000, -0.1554, 1.4062, 0.3988],
     [0.0032, 0.0766, -0.0656, -0.1294]],
    [[-1.0156, -0.3670, 1.0078, 1.4051], [0.2875, -0.5328, -3.8500, 3.3750],
     [14.0000, -0.9999, -7.1406, 7.5469], [-3.4000, -0.1078, -1.0750, 1.5702],
     [-0.0672, 0.4016, 0.3017, -0.4844]],
    [[-1.0000, 0.0211, 0.5025, -0.5119], [-0.3000, 0.1922, 0.7023, -1.6317],
     [19.0000, -5.0000, 1.2438, -1.9094], [-4.0000, 0.0250, 0.3844, 0.2656],
     [1.0468, -0.3788, -2.4517, 1.4656]],
    [[-1.0500, 0.0289, 0.4260, 0.3590], [-0.3250, 0.1156, 0.7781, 0.0025],
     [31.0625, -14.5000, -46.1148, 55.3750], [-7.2312, 0.4050, 13.3500, 0.6234],
     [1.5000, -0.6426, 1.8564, 0.5636]],
];

/// a, b, c, d of the luminous efficacy of diffuse light by class (Perez et al. 1990, table 4).
const DIFFUSE_EFFICACY: [[f64; 4]; 8] = [
    [97.24, -0.46, 12.00, -8.91],
    [107.22, 1.15, 0.59, -3.95],
    [104.97, 2.96, -5.53, -8.77],
    [102.39, 5.59, -13.95, -13.90],
    [100.71, 5.94, -22.75, -23.74],
    [106.42, 3.83, -36.15, -28.83],
    [141.88, 1.90, -53.24, -14.03],
    [152.23, 0.35, -45.27, -7.98],
];

/// a, b, c, d of the luminous efficacy of direct light by class (Perez et al. 1990, table 4).
const DIRECT_EFFICACY: [[f64; 4]; 8] = [
    [57.20, -4.55, -2.98, 117.12],
    [98.99, -3.46, -1.21, 12.38],
    [109.83, -4.90, -1.71, -8.81],
    [110.34, -5.84, -1.99, -4.56],
    [106.36, -3.97, -1.75, -6.16],
    [107.19, -1.25, -1.51, -26.73],
    [105.75, 0.77, -1.26, -34.44],
    [101.18, 1.58, -1.10, -8.29],
];

/// Precipitable water in cm where nothing is known of it.
pub const USUAL_WATER: f64 = 2.0;

/// The state of the sky in the parameters of Perez, and the shape of its luminance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerezSky {
    /// Clearness epsilon, 1 (overcast) and above.
    pub clearness: f64,
    /// Brightness Delta as measured, 0 and above.
    pub brightness: f64,
    /// Class of clearness, 1 to 8.
    pub class: usize,
    /// a, b of the gradation and c, d, e of the indicatrix.
    pub coefficients: [f64; 5],
    /// Zenith angle of the sun, radians; at most pi/2.
    sun_zenith: f64,
}

impl PerezSky {
    /// The sky over a horizontal that receives `diffuse_horizontal` W/m² from it, while a surface that faces
    /// the sun receives `direct_normal` W/m² from the sun, and would receive `extraterrestrial` W/m² outside
    /// the atmosphere. A sun below the horizon counts as one at the horizon. None without diffuse light, or
    /// for values that are negative or not finite.
    ///
    /// Perez, Seals & Michalsky 1993, with the air mass of Kasten 1966. Brightness is held within 0.01 to
    /// 0.6, and above 0.2 for clearness from 1.065 to 2.8, where the model would give negative luminances; b
    /// is held below zero.
    pub fn new(
        sun: SunPosition,
        direct_normal: f64,
        diffuse_horizontal: f64,
        extraterrestrial: f64,
    ) -> Option<Self> {
        let sound = direct_normal >= 0.0 && direct_normal.is_finite() && diffuse_horizontal.is_finite();
        if !(sound && diffuse_horizontal > 0.0 && extraterrestrial > 0.0) {
            return None;
        }
        let sun_zenith = FRAC_PI_2 - sun.not_below_horizon().elevation().to_radians();
        let cubed = 1.041 * sun_zenith.powi(3);
        let ratio = (diffuse_horizontal + direct_normal) / diffuse_horizontal;
        let clearness = ((ratio + cubed) / (1.0 + cubed)).min(f64::MAX);
        let brightness = diffuse_horizontal * air_mass(sun_zenith) / extraterrestrial;
        let class = CLASSES.iter().rposition(|&from| clearness >= from).unwrap_or(0);
        let coefficients = coefficients(class, clearness, brightness, sun_zenith);
        Some(Self { clearness, brightness, class: class + 1, coefficients, sun_zenith })
    }

    /// Luminance in an arbitrary unit in a direction with the sine `sine` of its elevation (0 to 1), `to_sun`
    /// radians from the sun (Perez et al. 1993, equation 1). Finite, not negative.
    pub fn relative_luminance(&self, sine: f64, to_sun: f64) -> f64 {
        let [a, b, c, d, e] = self.coefficients;
        let gradation = 1.0 + a * (b / sine.max(0.0)).exp();
        let cos = to_sun.cos();
        let indicatrix = 1.0 + c * (d * to_sun).exp() + e * cos * cos;
        gradation.max(0.0) * indicatrix.max(0.0)
    }

    /// Lumens per watt of the light of the sky under `water` cm of precipitable water (Perez et al. 1990,
    /// equation 7). Not negative.
    pub fn diffuse_efficacy(&self, water: f64) -> f64 {
        let [a, b, c, d] = DIFFUSE_EFFICACY[self.class - 1];
        (a + b * water + c * self.sun_zenith.cos() + d * self.held_brightness().ln()).max(0.0)
    }

    /// Lumens per watt of the light of the sun under `water` cm of precipitable water (Perez et al. 1990,
    /// equation 8). Not negative.
    pub fn direct_efficacy(&self, water: f64) -> f64 {
        let [a, b, c, d] = DIRECT_EFFICACY[self.class - 1];
        (a + b * water + c * (5.73 * self.sun_zenith - 5.0).exp() + d * self.held_brightness()).max(0.0)
    }

    /// One sentence without a full stop if the light lies outside what the model was made for.
    pub fn doubt(&self) -> Option<String> {
        (self.brightness > BRIGHTNESS[1]).then(|| {
            format!(
                "the sky is brighter (Delta {:.2}) than any that the Perez model was made for ({}); its \
                 shape is that of the brightest",
                self.brightness, BRIGHTNESS[1]
            )
        })
    }

    fn held_brightness(&self) -> f64 {
        self.brightness.clamp(BRIGHTNESS[0], BRIGHTNESS[1])
    }
}

/// Relative optical air mass (Kasten 1966) at a zenith angle of 0 to pi/2 radians.
fn air_mass(zenith: f64) -> f64 {
    1.0 / (zenith.cos() + 0.15 * (93.885 - zenith.to_degrees()).powf(-1.253))
}

/// a to e for a class counted from 0.
fn coefficients(class: usize, clearness: f64, brightness: f64, zenith: f64) -> [f64; 5] {
    let mut delta = brightness.clamp(BRIGHTNESS[0], BRIGHTNESS[1]);
    if clearness > 1.065 && clearness < 2.8 {
        delta = delta.max(0.2);
    }
    let rows = &COEFFICIENTS[class];
    let plain = |[x1, x2, x3, x4]: [f64; 4]| x1 + x2 * zenith + delta * (x3 + x4 * zenith);
    let mut found = rows.map(plain);
    if class == 0 {
        let [c1, c2, c3, c4] = rows[2];
        found[2] = (delta * (c1 + c2 * zenith)).powf(c3).exp() - c4;
        let [d1, d2, d3, d4] = rows[3];
        found[3] = -(delta * (d1 + d2 * zenith)).exp() + d3 + delta * d4;
    }
    found[1] = found[1].min(LARGEST_B);
    found
}

/// Precipitable water in cm for a dew point in degrees Celsius at the ground (Wright, Perez & Michalsky 1989,
/// equation 2); the usual amount for a dew point that is not finite, and within 0.1 to 8 cm.
pub fn water_of_dew_point(dew_point: f64) -> f64 {
    let water = (0.07 * dew_point - 0.075).exp();
    if dew_point.is_finite() { water.clamp(0.1, 8.0) } else { USUAL_WATER }
}
