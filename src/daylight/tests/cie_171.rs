//! The daylight cases of CIE 171:2006 without reflection: 5.9 and 5.10, a roof opening without and with
//! glass, 5.11 and 5.12, a facade opening likewise.
//!
//! A black room of 4 x 4 x 3 m, sun at 60 degrees, without its direct light. Illuminances in per cent of the
//! unobstructed horizontal, by quadrature with another program; they confirm the published ones to 0.1 %
//! (median).

use crate::daylight::{CieType, Daylight, Pattern, SunPosition};
use crate::glazing::{Pane, WINDOW_GLASS};
use glam::DVec3;

/// Points on the wall.
const HEIGHTS: [f64; 6] = [2.75, 2.25, 1.75, 1.25, 0.75, 0.25];
/// Points on floor and ceiling.
const DEPTHS: [f64; 8] = [0.25, 0.75, 1.25, 1.75, 2.25, 2.75, 3.25, 3.75];

/// A horizontal illuminance of 1 from the sky, with the sun at this azimuth, over a ground of reflectance
/// 0.3.
fn under(kind: u8, azimuth: f64) -> Daylight {
    let sun = SunPosition::new(60.0, azimuth).unwrap();
    Daylight::new(Pattern::Cie(CieType::new(kind).unwrap()), sun, 1.0, 0.0, 0.3).unwrap()
}

/// The illuminance at a point through an opening with this unit normal, with or without glass of
/// transmissivity 0.96.
fn through(
    daylight: &Daylight,
    opening: [DVec3; 4],
    across: DVec3,
    glazed: bool,
    point: DVec3,
    normal: DVec3,
) -> f64 {
    let pane = Pane::new(WINDOW_GLASS, [0.96; 3]).unwrap();
    let passed = |e: DVec3| if glazed { pane.transmittance(e.dot(across).abs())[0] } else { 1.0 };
    daylight.illuminance_through(&opening.map(|corner| corner - point), normal, 1e-7, passed)
}

#[track_caller]
fn compare(found: &[f64], wanted: &[f64], what: &str) {
    assert_eq!(found.len(), wanted.len());
    for (index, (found, wanted)) in found.iter().zip(wanted).enumerate() {
        let found = 100.0 * found;
        assert!((found - wanted).abs() < 6e-4, "{what}, point {index}: {found} is not {wanted}");
    }
}

/// Side of the opening, type of the sky, glazed; points A to F on a wall that faces the sun, G to N on the
/// floor.
type RoofRow = (f64, u8, bool, [f64; 6], [f64; 8]);

#[rustfmt::skip]
const ROOF: [RoofRow; 12] = [
    (1.0, 1, false, [0.457, 1.644, 2.336, 2.261, 1.876, 1.465],
        [2.335, 3.110, 3.839, 4.294, 4.294, 3.839, 3.110, 2.335]),
    (1.0, 1, true, [0.152, 1.169, 1.914, 1.930, 1.626, 1.279],
        [2.047, 2.735, 3.381, 3.784, 3.784, 3.381, 2.735, 2.047]),
    (1.0, 12, false, [1.743, 3.757, 4.547, 4.609, 4.240, 3.633],
        [5.723, 6.005, 5.113, 3.968, 2.897, 2.035, 1.402, 0.965]),
    (1.0, 12, true, [0.579, 2.659, 3.723, 3.936, 3.676, 3.172],
        [5.017, 5.279, 4.503, 3.497, 2.553, 1.792, 1.233, 0.846]),
    (1.0, 16, false, [0.564, 1.783, 2.318, 2.198, 1.821, 1.427],
        [2.289, 3.074, 3.823, 4.294, 4.294, 3.823, 3.074, 2.289]),
    (1.0, 16, true, [0.188, 1.265, 1.898, 1.876, 1.578, 1.246],
        [2.007, 2.703, 3.367, 3.784, 3.784, 3.367, 2.703, 2.007]),
    (4.0, 1, false, [35.823, 31.535, 26.791, 22.076, 17.874, 14.360],
        [31.858, 37.277, 41.249, 43.324, 43.324, 41.249, 37.277, 31.858]),
    (4.0, 1, true, [26.900, 25.216, 22.206, 18.694, 15.337, 12.424],
        [27.878, 32.682, 36.205, 38.046, 38.046, 36.205, 32.682, 27.878]),
    (4.0, 12, false, [67.278, 54.425, 44.201, 36.072, 29.522, 24.195],
        [42.283, 43.882, 43.493, 40.915, 35.900, 29.225, 22.574, 16.804]),
    (4.0, 12, true, [47.143, 42.464, 36.335, 30.458, 25.298, 20.916],
        [36.938, 38.412, 38.131, 35.914, 31.536, 25.673, 19.813, 14.719]),
    (4.0, 16, false, [37.355, 32.144, 26.724, 21.745, 17.502, 14.032],
        [31.347, 36.740, 40.682, 42.736, 42.736, 40.682, 36.740, 31.347]),
    (4.0, 16, true, [27.543, 25.494, 22.091, 18.401, 15.015, 12.140],
        [27.433, 32.213, 35.708, 37.531, 37.531, 35.708, 32.213, 27.433]),
];

#[test]
fn roof_openings() {
    for (side, kind, glazed, wall_wanted, floor_wanted) in ROOF {
        // The wall of the points is the southern one, so that the sun stands in the north.
        let daylight = under(kind, 0.0);
        let (low, high) = (2.0 - 0.5 * side, 2.0 + 0.5 * side);
        let opening =
            [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| DVec3::new(x, y, 3.0));
        let at = |point, normal| through(&daylight, opening, DVec3::Z, glazed, point, normal);
        let what = format!("{side} x {side} m, type {kind}, glazed {glazed}");
        compare(&HEIGHTS.map(|z| at(DVec3::new(2.0, 0.0, z), DVec3::Y)), &wall_wanted, &what);
        compare(&DEPTHS.map(|y| at(DVec3::new(2.0, y, 0.0), DVec3::Z)), &floor_wanted, &what);
    }
}

/// Type of the sky, glazed; points A to F on the wall opposite, G to N on the floor from that wall to the
/// opening.
type FacadeRow = (u8, bool, [f64; 6], [f64; 8]);

#[rustfmt::skip]
const FACADE: [FacadeRow; 6] = [
    (1, false, [0.951, 1.063, 1.250, 1.508, 1.700, 1.856],
        [0.873, 1.308, 2.021, 3.198, 5.072, 7.637, 9.324, 5.089]),
    (1, true, [0.837, 0.936, 1.102, 1.329, 1.497, 1.633],
        [0.767, 1.149, 1.771, 2.791, 4.388, 6.447, 7.193, 2.164]),
    (12, false, [0.951, 1.063, 2.384, 4.931, 5.805, 5.012],
        [1.997, 2.795, 4.059, 6.126, 9.536, 14.557, 16.368, 5.026]),
    (12, true, [0.837, 0.936, 2.101, 4.345, 5.114, 4.411],
        [1.756, 2.455, 3.557, 5.348, 8.249, 12.289, 12.714, 2.166]),
    (16, false, [0.951, 1.063, 1.274, 1.706, 2.059, 2.143],
        [0.945, 1.376, 2.066, 3.188, 4.966, 7.421, 9.112, 5.037]),
    (16, true, [0.837, 0.936, 1.123, 1.503, 1.814, 1.886],
        [0.831, 1.208, 1.811, 2.782, 4.296, 6.266, 7.027, 2.142]),
];

/// Points G' to N' on the ceiling, which only the ground lights, without and with glass.
const CEILING: [[f64; 8]; 2] = [
    [0.380, 0.526, 0.746, 1.077, 1.555, 2.134, 2.398, 1.238],
    [0.334, 0.462, 0.654, 0.941, 1.346, 1.803, 1.852, 0.526],
];

#[test]
fn facade_openings() {
    for (kind, glazed, wall_wanted, floor_wanted) in FACADE {
        // 2 x 1 m in the southern wall, towards the sun.
        let daylight = under(kind, 180.0);
        let opening = [(1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
        let at = |point, normal| through(&daylight, opening, DVec3::Y, glazed, point, normal);
        let what = format!("type {kind}, glazed {glazed}");
        compare(&HEIGHTS.map(|z| at(DVec3::new(2.0, 4.0, z), DVec3::NEG_Y)), &wall_wanted, &what);
        compare(&DEPTHS.map(|y| at(DVec3::new(2.0, 4.0 - y, 0.0), DVec3::Z)), &floor_wanted, &what);
        let ceiling = DEPTHS.map(|y| at(DVec3::new(2.0, 4.0 - y, 3.0), DVec3::NEG_Z));
        compare(&ceiling, &CEILING[usize::from(glazed)], &format!("ceiling, {what}"));
    }
}
