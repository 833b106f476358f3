use crate::scene::LUMINOUS_EFFICACY;
use std::f64::consts::PI;

/// Luminance in cd/m² that just reaches display white at EV 0 (ISO 100): 78 / (100 * 0.65), the
/// saturation-based speed of ISO 12232 with a lens transmission of 0.65 (Lagarde & de Rousiers 2014).
const SATURATION: f64 = 1.2;

/// Where the geometric mean of what is metered comes to lie, in display-linear units.
pub(crate) const MIDDLE_GREY: f64 = 0.3;

/// Where the brightest tenth of what is metered begins at most, in display-linear units.
const HIGHLIGHTS: f64 = 0.85;

/// How bright the picture is: photographic exposure value at ISO 100. A higher value suits a
/// brighter scene and darkens the picture by a stop; rooms at night lie around 5, offices around 8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposure {
    /// EV at ISO 100; -20 to 30 makes sense.
    pub ev100: f64,
}

impl Default for Exposure {
    fn default() -> Self {
        Self { ev100: 6.0 }
    }
}

impl Exposure {
    /// The exposure under which a surface of this luminance in cd/m² shows at `level`
    /// (display-linear). Both must be above zero.
    pub fn placing(luminance: f64, level: f64) -> Self {
        Self { ev100: (luminance / (SATURATION * level)).log2() }
    }

    /// Brighter by `stops` (darker where negative).
    #[must_use]
    pub fn brighter(self, stops: f64) -> Self {
        Self { ev100: self.ev100 - stops }
    }

    /// What a radiosity in W/m² is multiplied with before the tone map; always finite and positive.
    pub fn factor(self) -> f32 {
        let ev = if self.ev100.is_finite() { self.ev100.clamp(-40.0, 40.0) } else { 6.0 };
        (LUMINOUS_EFFICACY / PI / (SATURATION * ev.exp2())) as f32
    }
}

/// Luminance in cd/m² of a diffuse radiosity in W/m² per band: 179 lm/W, weighted by Rec. 709, over pi.
pub fn luminance(radiosity: [f32; 3]) -> f64 {
    LUMINOUS_EFFICACY / PI * rec709(radiosity.map(f64::from))
}

fn rec709(rgb: [f64; 3]) -> f64 {
    crate::scene::luminance_weighted(rgb)
}

/// Automatic exposure for surfaces of the given luminances in cd/m², each with a weight (the
/// visible area, or the number of rays that met it).
///
/// The geometric mean (Reinhard et al. 2002) of the middle nine tenths lands on middle grey, but
/// no more than a tenth of the weight comes near white. Leave lamps out: they should dazzle.
/// `None` where nothing is lit.
pub fn meter(samples: impl IntoIterator<Item = (f64, f64)>) -> Option<Exposure> {
    let mut lit: Vec<(f64, f64)> = samples
        .into_iter()
        .filter(|&(value, weight)| value > 0.0 && value.is_finite() && weight > 0.0 && weight.is_finite())
        .collect();
    lit.sort_by(|a, b| a.0.total_cmp(&b.0));
    let brightest = lit.last()?.0;
    // Four decades down nothing is told apart any more; unlit neighbour rooms must not count.
    lit.retain(|sample| sample.0 > 1e-4 * brightest);
    let total: f64 = lit.iter().map(|sample| sample.1).sum();
    let (mut passed, mut weight_sum, mut log_sum, mut highlight) = (0.0, 0.0, 0.0, brightest);
    for &(value, weight) in &lit {
        let (from, to) = (passed / total, (passed + weight) / total);
        let inner = (to.min(0.95) - from.max(0.05)).max(0.0);
        weight_sum += inner;
        log_sum += inner * value.ln();
        if from <= 0.9 && to > 0.9 {
            highlight = value;
        }
        passed += weight;
    }
    let mean = if weight_sum > 0.0 { (log_sum / weight_sum).exp() } else { brightest };
    let grey = Exposure::placing(mean, MIDDLE_GREY);
    let white = Exposure::placing(highlight, HIGHLIGHTS);
    let chosen = Exposure { ev100: grey.ev100.max(white.ev100) };
    chosen.ev100.is_finite().then_some(chosen)
}

/// How exposed radiosities of any height are brought into the range of a display.
///
/// The formulae stand a second time in `render/shaders/tone.wgsl`; a test compares the two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ToneMap {
    /// Colours kept up to 0.76, then rolled off towards white (Khronos PBR Neutral, 2024).
    #[default]
    Neutral,
    /// An S-shaped film curve per band (Narkowicz 2015, a fit to ACES).
    Filmic,
    /// Reinhard et al. 2002, equation 4, on luminance; white at [`ToneMap::REINHARD_WHITE`].
    Reinhard,
    /// Cut off at white.
    Linear,
}

impl ToneMap {
    /// All of them, as a menu lists them.
    pub const ALL: [Self; 4] = [Self::Neutral, Self::Filmic, Self::Reinhard, Self::Linear];

    /// The exposed luminance that [`ToneMap::Reinhard`] shows as white.
    pub const REINHARD_WHITE: f32 = 4.0;

    /// What a menu calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Neutral => "Neutral",
            Self::Filmic => "Filmic",
            Self::Reinhard => "Reinhard",
            Self::Linear => "Linear",
        }
    }

    /// Exposed linear R, G, B of any height to display-linear 0..1. NaN and negative values give 0.
    pub fn apply(self, exposed: [f32; 3]) -> [f32; 3] {
        // The comparison is false for NaN; the cap keeps infinities out of the quotients below.
        let rgb = exposed.map(|x| if x > 0.0 { x.min(1e6) } else { 0.0 });
        let mapped = match self {
            Self::Neutral => neutral(rgb),
            Self::Filmic => rgb.map(filmic),
            Self::Reinhard => reinhard(rgb),
            Self::Linear => rgb,
        };
        mapped.map(|x| x.clamp(0.0, 1.0))
    }
}

fn filmic(exposed: f32) -> f32 {
    let x = 0.6 * exposed;
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

fn reinhard(rgb: [f32; 3]) -> [f32; 3] {
    const WHITE: f32 = ToneMap::REINHARD_WHITE;
    let l = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let scale = (1.0 + l / (WHITE * WHITE)) / (1.0 + l);
    rgb.map(|x| x * scale)
}

fn neutral(rgb: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let smallest = rgb[0].min(rgb[1]).min(rgb[2]);
    let offset = if smallest < 0.08 { smallest - 6.25 * smallest * smallest } else { 0.04 };
    let colour = rgb.map(|x| x - offset);
    let peak = colour[0].max(colour[1]).max(colour[2]);
    if peak < START {
        return colour;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    colour.map(|x| {
        let compressed = x * new_peak / peak;
        compressed + (new_peak - compressed) * g
    })
}

/// Display-linear 0..1 to the sRGB code value 0..1 (IEC 61966-2-1).
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_encode`].
pub fn srgb_decode(code: f32) -> f32 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_values_are_those_of_a_light_meter() {
        // 4000 cd/m² (a sunlit landscape, EV 15) lies a little under saturation over ten.
        let level = 4000.0 / (SATURATION * 15_f64.exp2());
        assert!((0.08..0.13).contains(&level), "{level}");
        let radiosity = [100.0_f32; 3];
        let cd = luminance(radiosity);
        assert!((cd - 17_900.0 / PI).abs() < 1e-3, "{cd}");
        let shown = Exposure::placing(cd, 0.18).factor() * radiosity[1];
        assert!((shown - 0.18).abs() < 1e-5, "{shown}");
        assert!((Exposure { ev100: 7.0 }.factor() * 2.0 - Exposure { ev100: 6.0 }.factor()).abs() < 1e-6);
        assert!(Exposure { ev100: f64::NAN }.factor().is_finite());
    }

    #[test]
    fn an_even_scene_is_metered_to_middle_grey_and_dark_rooms_do_not_count() {
        let even = meter((0..100).map(|_| (50.0, 1.0))).expect("lit");
        assert!((even.ev100 - Exposure::placing(50.0, MIDDLE_GREY).ev100).abs() < 1e-9);
        let with_dark = meter((0..100).map(|i| (if i < 50 { 50.0 } else { 1e-4 }, 1.0))).expect("lit");
        assert!((with_dark.ev100 - even.ev100).abs() < 1e-9);
        assert_eq!(meter([(0.0, 1.0), (f64::NAN, 1.0)]), None);
        assert_eq!(meter([]), None);
    }

    #[test]
    fn bright_parts_hold_the_exposure_back() {
        let samples = (0..100).map(|i| (if i < 80 { 1.0 } else { 100.0 }, 1.0));
        let exposure = meter(samples).expect("lit");
        assert!((exposure.ev100 - Exposure::placing(100.0, HIGHLIGHTS).ev100).abs() < 1e-9);
    }

    #[test]
    fn tone_maps_rise_and_stay_in_range() {
        for map in ToneMap::ALL {
            let mut last = -1.0;
            for step in 0..400 {
                let x = 1e-4 * 1.06_f32.powi(step);
                let y = map.apply([x; 3])[0];
                assert!((0.0..=1.0).contains(&y) && y >= last, "{map:?} at {x}: {y} after {last}");
                last = y;
            }
            assert!(last > 0.95, "{map:?}: {last}");
            assert_eq!(map.apply([f32::NAN, -1.0, 0.0]), [0.0; 3], "{map:?}");
            assert!(map.apply([f32::INFINITY; 3]).iter().all(|x| x.is_finite()), "{map:?}");
        }
    }

    #[test]
    fn known_points_of_the_curves() {
        // Neutral passes base colours through less its Fresnel offset: 0.5 -> 0.46.
        assert!((ToneMap::Neutral.apply([0.5; 3])[0] - 0.46).abs() < 1e-6);
        // Reinhard's white point.
        assert!((ToneMap::Reinhard.apply([4.0; 3])[0] - 1.0).abs() < 1e-6);
        // The film curve at 1 with Narkowicz' pre-exposure of 0.6.
        let expected = 0.6 * (2.51 * 0.6 + 0.03) / (0.6 * (2.43 * 0.6 + 0.59) + 0.14);
        assert!((ToneMap::Filmic.apply([1.0; 3])[0] - expected).abs() < 1e-6);
        assert_eq!(ToneMap::Linear.apply([0.25, 0.5, 7.0]), [0.25, 0.5, 1.0]);
    }

    #[test]
    fn srgb_round_trip_and_its_known_middle() {
        assert!((srgb_encode(0.214_041_14) - 0.5).abs() < 1e-5);
        for code in 0..=255_u8 {
            let there = srgb_encode(srgb_decode(f32::from(code) / 255.0)) * 255.0;
            assert!((there - f32::from(code)).abs() < 1e-3, "{code}: {there}");
        }
    }
}
