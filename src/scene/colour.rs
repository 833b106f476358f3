//! Colour temperatures to linear colours.

use super::types::luminance_weighted;

/// Linear Rec. 709 colour of a black body at `kelvin` (1000 to 40,000), of luminance 1.
///
/// Planckian locus by Krystek 1985 (*An algorithm to calculate correlated colour temperature*),
/// CIE 1960 u, v to x, y, then to Rec. 709 primaries; what lies outside their gamut is clipped.
/// The chromaticity is within 0.001 of the locus up to 20,000 K and within 0.003 above.
pub fn black_body(kelvin: f64) -> [f64; 3] {
    let t = kelvin;
    let u = (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
        / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t);
    let v = (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
        / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t);
    let scale = 1.0 / (2.0 * u - 8.0 * v + 4.0);
    let (x, y) = (3.0 * u * scale, 2.0 * v * scale);
    normalised(linear_from_xyz([x / y, 1.0, (1.0 - x - y) / y]).map(|c| c.max(0.0))).unwrap_or([1.0; 3])
}

/// `colour` scaled to luminance 1; `None` where it has none.
pub(super) fn normalised(colour: [f64; 3]) -> Option<[f64; 3]> {
    let luminance = luminance_weighted(colour);
    (luminance > 0.0 && luminance.is_finite()).then(|| colour.map(|c| c / luminance))
}

/// IEC 61966-2-1: CIE XYZ to linear Rec. 709 primaries, white D65.
fn linear_from_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_969_942 * x - 1.537_383_178 * y - 0.498_610_760 * z,
        -0.969_243_636 * x + 1.875_967_502 * y + 0.041_555_057 * z,
        0.055_630_080 * x - 0.203_976_959 * y + 1.056_971_514 * z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticity of a linear Rec. 709 colour.
    fn xy([r, g, b]: [f64; 3]) -> (f64, f64) {
        let x = 0.412_390_8 * r + 0.357_584_3 * g + 0.180_480_8 * b;
        let y = 0.212_639_0 * r + 0.715_168_7 * g + 0.072_192_3 * b;
        let z = 0.019_330_8 * r + 0.119_194_8 * g + 0.950_532_2 * b;
        (x / (x + y + z), y / (x + y + z))
    }

    #[test]
    fn the_locus_meets_tabulated_chromaticities() {
        // CIE illuminant A, and the Planckian locus as tabulated by Wyszecki & Stiles.
        for (kelvin, x, y) in [
            (2856.0, 0.4476, 0.4074),
            (4000.0, 0.3805, 0.3768),
            (6500.0, 0.3135, 0.3237),
            (10_000.0, 0.2807, 0.2884),
        ] {
            let (found_x, found_y) = xy(black_body(kelvin));
            assert!(
                (found_x - x).abs() < 1e-3 && (found_y - y).abs() < 1e-3,
                "{kelvin}: {found_x}, {found_y}"
            );
        }
    }

    #[test]
    fn warm_is_red_cold_is_blue_and_the_luminance_is_one() {
        for kelvin in [1000.0, 1900.0, 2700.0, 6500.0, 40_000.0] {
            let colour = black_body(kelvin);
            assert!((luminance_weighted(colour) - 1.0).abs() < 1e-12);
            assert!(colour.iter().all(|c| *c >= 0.0), "{kelvin}: {colour:?}");
            assert_eq!(colour[0] > colour[2], kelvin < 6600.0, "{kelvin}: {colour:?}");
        }
    }
}
