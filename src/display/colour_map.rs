use super::tone::srgb_decode;
use std::f64::consts::PI;

/// Entries of a colour table.
const STEPS: usize = 256;

/// A perceptually even colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColourMap {
    /// Dark violet to yellow (van der Walt & Smith 2015), for magnitudes.
    #[default]
    Viridis,
    /// Blue through grey to red (Moreland 2009), for signed values around zero.
    BlueRed,
}

impl ColourMap {
    /// All of them, as a menu lists them.
    pub const ALL: [Self; 2] = [Self::Viridis, Self::BlueRed];

    /// What a menu calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "Viridis",
            Self::BlueRed => "Blue to red",
        }
    }

    /// The sRGB code values 0..1 at `position`, clamped to 0..1; the start of the map for NaN.
    pub fn srgb(self, position: f64) -> [f32; 3] {
        let t = if position.is_finite() { position.clamp(0.0, 1.0) } else { 0.0 };
        let rgb = match self {
            Self::Viridis => viridis(t),
            Self::BlueRed => blue_red(t),
        };
        rgb.map(|x| x.clamp(0.0, 1.0) as f32)
    }

    /// The display-linear colour 0..1 at `position`.
    pub fn linear(self, position: f64) -> [f32; 3] {
        self.srgb(position).map(srgb_decode)
    }

    /// 256 sRGB texels (R, G, B, 255) from position 0 to 1.
    pub fn table(self) -> Vec<[u8; 4]> {
        (0..STEPS)
            .map(|step| {
                let [r, g, b] = self.srgb(step as f64 / (STEPS - 1) as f64);
                [r, g, b, 1.0].map(|x| (x * 255.0).round() as u8)
            })
            .collect()
    }
}

/// The display-linear colour that tells a patch from its neighbours, as `render/shaders/scene.wgsl`
/// draws it where the surface faces the eye.
pub fn patch_colour(patch: u32) -> [f32; 3] {
    // Multiplicative hashing (Knuth 6.4) keeps neighbours apart in hue and in lightness.
    let hash = patch.wrapping_mul(2_654_435_769);
    let hue = (hash >> 16) as f32 / 65536.0;
    let lightness = 0.35 + 0.5 * (hash.wrapping_mul(747_796_405) >> 24) as f32 / 256.0;
    [0.0, 2.0 / 3.0, 1.0 / 3.0].map(|shift| {
        let band = (((hue + shift) % 1.0 * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (lightness * (0.3 + 0.7 * band)).powi(2)
    })
}

/// Sixth-degree fit to the table of matplotlib (Zucker 2019), within 0.02 of it.
fn viridis(t: f64) -> [f64; 3] {
    const FIT: [[f64; 3]; 7] = [
        [0.277_727_327_223_417_7, 0.005_407_344_544_966_578, 0.334_099_805_335_306_1],
        [0.105_093_043_108_577_4, 1.404_613_529_898_575, 1.384_590_162_594_685],
        [-0.330_861_828_725_556_3, 0.214_847_559_468_213, 0.095_095_163_028_236_59],
        [-4.634_230_498_983_486, -5.799_100_973_351_585, -19.332_440_956_279_87],
        [6.228_269_936_347_081, 14.179_933_366_805_09, 56.690_552_600_681_05],
        [4.776_384_997_670_288, -13.745_145_377_746_01, -65.353_032_633_372_34],
        [-5.435_455_855_934_631, 4.645_852_612_178_535, 26.312_435_249_583_2],
    ];
    std::array::from_fn(|band| FIT.iter().rev().fold(0.0, |sum, term| sum * t + term[band]))
}

/// Moreland 2009, *Diverging Color Maps for Scientific Visualization*: straight lines in Msh, the
/// polar form of CIELAB, over a neutral middle of magnitude 88.
fn blue_red(t: f64) -> [f64; 3] {
    const MIDDLE: f64 = 88.0;
    let (magnitude, saturation): (f64, f64) = (80.0, 1.08);
    let hue = if t < 0.5 { -1.1 } else { 0.5 };
    // The hue turns on the way to grey so that the path keeps its evenness (appendix of the paper).
    let spin = saturation * (MIDDLE * MIDDLE - magnitude * magnitude).sqrt() / (magnitude * saturation.sin());
    let grey_hue = if hue > -PI / 3.0 { hue + spin } else { hue - spin };
    let to_grey = 1.0 - (2.0 * t - 1.0).abs();
    let m = magnitude + (MIDDLE - magnitude) * to_grey;
    let s = saturation * (1.0 - to_grey);
    let h = hue + (grey_hue - hue) * to_grey;
    lab_to_srgb([m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin()])
}

/// CIELAB (D65) to sRGB code values, unclamped.
fn lab_to_srgb([l, a, b]: [f64; 3]) -> [f64; 3] {
    let y = (l + 16.0) / 116.0;
    let inverse = |f: f64| if f > 6.0 / 29.0 { f * f * f } else { (f - 4.0 / 29.0) * 108.0 / 841.0 };
    let xyz = [0.9505 * inverse(y + a / 500.0), inverse(y), 1.089 * inverse(y - b / 200.0)];
    let rows = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
    rows.map(|row| {
        let linear: f64 = row.iter().zip(xyz).map(|(m, x)| m * x).sum();
        if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(map: ColourMap, position: f64, expected: [f64; 3], tolerance: f64) {
        let got = map.srgb(position);
        for (x, y) in got.iter().zip(expected) {
            assert!((f64::from(*x) - y).abs() < tolerance, "{map:?} at {position}: {got:?}, {expected:?}");
        }
    }

    #[test]
    fn maps_meet_the_published_tables() {
        near(ColourMap::Viridis, 0.0, [0.267, 0.005, 0.329], 0.02);
        near(ColourMap::Viridis, 0.25, [0.230, 0.322, 0.546], 0.02);
        near(ColourMap::Viridis, 0.5, [0.128, 0.567, 0.551], 0.02);
        near(ColourMap::Viridis, 0.75, [0.369, 0.789, 0.383], 0.02);
        near(ColourMap::Viridis, 1.0, [0.993, 0.906, 0.144], 0.02);
        near(ColourMap::BlueRed, 0.0, [0.230, 0.299, 0.754], 0.01);
        near(ColourMap::BlueRed, 0.5, [0.865, 0.865, 0.865], 0.01);
        near(ColourMap::BlueRed, 1.0, [0.706, 0.016, 0.150], 0.01);
    }

    #[test]
    fn viridis_grows_lighter_all_the_way_and_takes_any_number() {
        let lightness = |t: f64| {
            let [r, g, b] = ColourMap::Viridis.linear(t);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for step in 1..=100 {
            let t = f64::from(step) / 100.0;
            assert!(lightness(t) > lightness(t - 0.01), "at {t}");
        }
        assert_eq!(ColourMap::Viridis.srgb(f64::NAN), ColourMap::Viridis.srgb(0.0));
        assert_eq!(ColourMap::Viridis.srgb(9.0), ColourMap::Viridis.srgb(1.0));
        assert_eq!(ColourMap::BlueRed.table().len(), 256);
    }
}
