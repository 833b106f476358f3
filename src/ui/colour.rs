//! Colours that lamps and materials are edited in: linear R, G, B, sRGB and colour temperature.

/// Lowest colour temperature offered, kelvin: candlelight.
pub(super) const MIN_KELVIN: f64 = 1800.0;
/// Highest colour temperature offered, kelvin: clear northern sky.
pub(super) const MAX_KELVIN: f64 = 12000.0;

/// Linear Rec. 709 R, G, B of a black body, with luminance one; negative parts are cut to zero.
///
/// `kelvin` is clamped to 1667..25000, the range of the fit of the Planckian locus by Kim et al.
/// (US patent 7024034, 2002).
pub(super) fn black_body(kelvin: f64) -> [f64; 3] {
    let t = 1e3 / kelvin.clamp(1667.0, 25_000.0);
    let x = if t >= 0.25 {
        -0.266_123_9 * t * t * t - 0.234_358_9 * t * t + 0.877_695_6 * t + 0.179_910
    } else {
        -3.025_846_9 * t * t * t + 2.107_037_9 * t * t + 0.222_634_7 * t + 0.240_390
    };
    let y = if kelvin < 2222.0 {
        -1.106_381_4 * x * x * x - 1.348_110_2 * x * x + 2.185_558_32 * x - 0.202_196_83
    } else if kelvin < 4000.0 {
        -0.954_947_6 * x * x * x - 1.374_185_93 * x * x + 2.091_370_15 * x - 0.167_488_67
    } else {
        3.081_758_0 * x * x * x - 5.873_386_70 * x * x + 3.751_129_97 * x - 0.370_014_83
    };
    // CIE xyY with Y = 1 to linear Rec. 709 (IEC 61966-2-1).
    let (big_x, big_z) = (x / y, (1.0 - x - y) / y);
    [
        3.240_625_5 * big_x - 1.537_208 - 0.498_628_6 * big_z,
        -0.968_930_7 * big_x + 1.875_756_1 + 0.041_517_5 * big_z,
        0.055_710_1 * big_x - 0.204_021_1 + 1.056_995_9 * big_z,
    ]
    .map(|c| c.max(0.0))
}

/// Linear light to sRGB, both 0 to 1 (IEC 61966-2-1).
pub(super) fn srgb_of_linear(linear: f64) -> f64 {
    let c = linear.clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// sRGB to linear light, both 0 to 1 (IEC 61966-2-1).
pub(super) fn linear_of_srgb(srgb: f64) -> f64 {
    let c = srgb.clamp(0.0, 1.0);
    if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// A linear colour as 8-bit sRGB; values above one are cut.
pub(super) fn to_bytes(linear: [f64; 3]) -> [u8; 3] {
    linear.map(|c| (255.0 * srgb_of_linear(c)).round() as u8)
}

/// Splits an exitance or any linear colour into its largest part and the hue below one.
pub(super) fn split(linear: [f64; 3]) -> (f64, [f64; 3]) {
    let peak = linear.into_iter().fold(0.0, f64::max);
    if peak > 0.0 { (peak, linear.map(|c| c / peak)) } else { (0.0, [1.0; 3]) }
}

/// `exitance` recoloured like `hue`, with the luminance it had.
pub(super) fn recoloured(exitance: [f64; 3], hue: [f64; 3]) -> [f64; 3] {
    let (before, after) = (crate::scene::luminance_weighted(exitance), crate::scene::luminance_weighted(hue));
    if after > 0.0 { hue.map(|c| c * before / after) } else { exitance }
}

/// The colour temperature whose black body is nearest in hue, kelvin; `None` where none is near.
pub(super) fn nearest_kelvin(linear: [f64; 3]) -> Option<f64> {
    let (peak, hue) = split(linear);
    if peak <= 0.0 {
        return None;
    }
    let distance = |kelvin: f64| {
        let (_, body) = split(black_body(kelvin));
        (0..3).map(|b| (body[b] - hue[b]).powi(2)).sum::<f64>()
    };
    // Steps of a hundredth in the reciprocal, to which the eye's discrimination is about even.
    let candidates = (0..=200).map(|k| {
        let share = f64::from(k) / 200.0;
        1.0 / (1.0 / MIN_KELVIN + (1.0 / MAX_KELVIN - 1.0 / MIN_KELVIN) * share)
    });
    let best = candidates.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    (distance(best) < 4e-3).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn daylight_is_near_white_and_candles_are_orange() {
        let day = black_body(6500.0);
        assert!(day.iter().all(|c| (c - 1.0).abs() < 0.06), "{day:?}");
        let candle = black_body(1900.0);
        assert!(candle[0] > 2.0 * candle[1] && candle[1] > 4.0 * candle[2], "{candle:?}");
        for kelvin in [1800.0, 2700.0, 4000.0, 6500.0, 10_000.0] {
            let luminance = crate::scene::luminance_weighted(black_body(kelvin));
            assert!((luminance - 1.0).abs() < 0.02, "{kelvin}: {luminance}");
        }
    }

    #[test]
    fn temperatures_are_found_again() {
        for kelvin in [2000.0, 2700.0, 3000.0, 4000.0, 6500.0] {
            let found = nearest_kelvin(black_body(kelvin).map(|c| 37.0 * c)).expect("on the locus");
            assert!((found / kelvin - 1.0).abs() < 0.03, "{kelvin}: {found}");
        }
        assert_eq!(nearest_kelvin([0.0, 1.0, 0.0]), None);
        assert_eq!(nearest_kelvin([0.0; 3]), None);
    }

    #[test]
    fn recolouring_keeps_the_luminance() {
        let new = recoloured([10.0, 20.0, 5.0], black_body(2700.0));
        let (a, b) =
            (crate::scene::luminance_weighted([10.0, 20.0, 5.0]), crate::scene::luminance_weighted(new));
        assert!((a - b).abs() < 1e-9);
    }

    #[test]
    fn srgb_round_trips() {
        for k in 0..=255 {
            let srgb = f64::from(k) / 255.0;
            assert!((srgb_of_linear(linear_of_srgb(srgb)) - srgb).abs() < 1e-6);
        }
    }
}
