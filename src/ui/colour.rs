//! Colours that lamps and materials are edited in: linear R, G, B, sRGB and colour temperature.

use crate::scene::black_body;

/// Lowest colour temperature offered, kelvin: candlelight.
pub(super) const MIN_KELVIN: f64 = 1800.0;
/// Highest colour temperature offered, kelvin: clear northern sky.
pub(super) const MAX_KELVIN: f64 = 12000.0;

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

/// Hue, saturation and value, each 0 to 1, of a linear colour: those of its sRGB codes, as pickers have them.
pub(super) fn hsv_of(linear: [f64; 3]) -> [f32; 3] {
    let (hue, saturation, value) = egui::ecolor::hsv_from_rgb(linear.map(|c| srgb_of_linear(c) as f32));
    [hue, saturation, value]
}

/// The linear colour of this hue, saturation and value, each 0 to 1.
pub(super) fn linear_of_hsv([hue, saturation, value]: [f32; 3]) -> [f64; 3] {
    egui::ecolor::rgb_from_hsv((hue, saturation, value)).map(|c| linear_of_srgb(f64::from(c)))
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
    // Even steps in the reciprocal, to which the eye's discrimination is about even.
    let kelvin = |share: f64| 1.0 / (1.0 / MIN_KELVIN + (1.0 / MAX_KELVIN - 1.0 / MIN_KELVIN) * share);
    let distance = |share: f64| {
        let (_, body) = split(black_body(kelvin(share)));
        (0..3).map(|b| (body[b] - hue[b]).powi(2)).sum::<f64>()
    };
    let steps = (0..=50).map(|k| f64::from(k) / 50.0);
    let best = steps.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    // Between the neighbours of the best step the distance falls and rises once.
    let (mut low, mut high) = ((best - 0.02).max(0.0), (best + 0.02).min(1.0));
    for _ in 0..40 {
        let third = (high - low) / 3.0;
        if distance(low + third) < distance(high - third) { high -= third } else { low += third }
    }
    let found = 0.5 * (low + high);
    (distance(found) < 4e-3).then(|| kelvin(found))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temperatures_are_found_again() {
        for kelvin in [2000.0, 2700.0, 3000.0, 4000.0, 6500.0] {
            let found = nearest_kelvin(black_body(kelvin).map(|c| 37.0 * c)).expect("on the locus");
            assert!((found - kelvin).abs() < 0.5, "{kelvin}: {found}");
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
    fn hue_and_saturation_come_back() {
        for hsv in [[0.0, 1.0, 1.0], [0.33, 0.5, 1.0], [0.6, 0.25, 0.7]] {
            let again = hsv_of(linear_of_hsv(hsv));
            assert!(hsv.iter().zip(again).all(|(a, b)| (a - b).abs() < 1e-4), "{hsv:?} {again:?}");
        }
        assert_eq!(linear_of_hsv([0.0, 1.0, 1.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn srgb_round_trips() {
        for k in 0..=255 {
            let srgb = f64::from(k) / 255.0;
            assert!((srgb_of_linear(linear_of_srgb(srgb)) - srgb).abs() < 1e-6);
        }
    }
}
