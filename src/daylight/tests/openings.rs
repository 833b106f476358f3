//! Light through openings against closed forms, and skies in bins.

use crate::daylight::{BinValue, CieType, Daylight, Pattern, SkyBins, SunPosition, Weather, direction};
use glam::DVec3;
use std::f64::consts::PI;

/// The relative error of illuminances that are held against closed forms.
const EXACT: f64 = 1e-9;

fn sun(elevation: f64, azimuth: f64) -> SunPosition {
    SunPosition::new(elevation, azimuth).unwrap()
}

fn under(kind: u8, sun: SunPosition, ground: f64) -> Daylight {
    Daylight::new(Pattern::Cie(CieType::new(kind).unwrap()), sun, 1.0, 0.0, ground).unwrap()
}

#[track_caller]
fn near(found: f64, wanted: f64, most: f64, what: &str) {
    assert!((found - wanted).abs() <= most, "{what}: {found} is not {wanted}");
}

/// A window of width and height at a distance, its lower corner straight ahead at the height of a horizontal
/// point: sky component under the uniform and the traditional overcast sky.
const WINDOWS: [([f64; 3], f64, f64); 5] = [
    ([1.0, 1.0, 1.0], 0.055_734_197, 0.045_251_375),
    ([1.0, 1.0, 2.0], 0.013_927_691, 0.009_430_276),
    ([1.0, 1.2, 3.0], 0.006_855_659, 0.004_371_926),
    ([2.0, 1.5, 2.0], 0.039_089_315, 0.029_329_934),
    ([0.6, 1.8, 4.0], 0.003_966_015, 0.002_626_883),
];

/// Uniform and overcast sky component in closed form.
fn closed_form([w, h, d]: [f64; 3]) -> [f64; 2] {
    let near = d.hypot(h);
    let first = 0.5 * ((w / d).atan() - d / near * (w / near).atan());
    let r = (w * w + h * h + d * d).sqrt();
    let second = ((w * h / (d * r)).atan() - w * d * h / (near * near * r)) / 3.0;
    [first / PI, 3.0 * (first + 2.0 * second) / (7.0 * PI)]
}

#[test]
fn windows_agree_with_closed_forms() {
    for (size, uniform, overcast) in WINDOWS {
        let [w, h, d] = size;
        // Towards the south-west, to show that the azimuth does not matter.
        let (ahead, right) = (direction(0.0, 225.0), direction(0.0, 315.0));
        let corner = |x: f64, z: f64| d * ahead + x * right + z * DVec3::Z;
        let window = [corner(0.0, 0.0), corner(w, 0.0), corner(w, h), corner(0.0, h)];
        let reversed: Vec<DVec3> = window.iter().rev().copied().collect();
        for (kind, wanted, exact) in
            [(5, uniform, closed_form(size)[0]), (16, overcast, closed_form(size)[1])]
        {
            let daylight = under(kind, sun(60.0, 10.0), 0.9);
            for corners in [&window[..], &reversed] {
                let found = daylight.illuminance_through(corners, DVec3::Z, EXACT, |_| 1.0);
                near(found, wanted, 6e-10, &format!("{size:?}, type {kind}"));
                near(found, exact, 1e-9 * exact, &format!("{size:?}, type {kind}"));
            }
        }
    }
    // An endless window 1 m high at 1 m: as far as numbers show.
    let (far, up) = (1e6, 1.0);
    let strip = [(0.0, 0.0), (far, 0.0), (far, up), (0.0, up)].map(|(x, z)| DVec3::new(x, 1.0, z));
    for (kind, wanted) in [(5, 0.073_223_305), (16, 0.057_337_147)] {
        let found = under(kind, sun(60.0, 10.0), 0.9).illuminance_through(&strip, DVec3::Z, EXACT, |_| 1.0);
        near(found, wanted, 2e-9, "endless");
    }
}

/// Half of the sky is what a vertical surface sees of it, whichever way it is computed.
#[test]
fn quarters_of_the_sphere_add_up_to_the_whole() {
    for kind in [1, 7, 12, 15] {
        for elevation in [0.0, 20.0, 60.0, 90.0] {
            let daylight = under(kind, sun(elevation, 150.0), 0.3);
            for normal in [DVec3::Z, direction(0.0, 170.0), direction(-40.0, 100.0), direction(30.0, 0.0)] {
                let mut sum = 0.0;
                for octant in 0..8 {
                    let sign = |bit: i32| if octant & bit == 0 { 1.0 } else { -1.0 };
                    let corners = [DVec3::X * sign(1), DVec3::Y * sign(2), DVec3::Z * sign(4)];
                    sum += daylight.illuminance_through(&corners, normal, EXACT, |_| 1.0);
                }
                near(sum, daylight.illuminance(normal), 3e-7, &format!("type {kind}, {elevation}, {normal}"));
            }
        }
    }
}

/// Who asks for less waits less and is not further off.
#[test]
fn errors_are_within_what_is_tolerated() {
    let daylight = under(15, sun(30.0, 180.0), 0.3);
    let opening = [(1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
    let mut last = 0;
    for tolerance in [0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-7] {
        let evaluations = std::cell::Cell::new(0);
        for step in 0..20 {
            let point = DVec3::new(2.0, 0.25 + 0.18 * f64::from(step), 0.0);
            let corners = opening.map(|corner| corner - point);
            let exact = daylight.illuminance_through(&corners, DVec3::Z, EXACT, |_| 1.0);
            let found = daylight.illuminance_through(&corners, DVec3::Z, tolerance, |_| {
                evaluations.set(evaluations.get() + 1);
                1.0
            });
            near(found / exact, 1.0, tolerance, &format!("tolerance {tolerance}, step {step}"));
        }
        assert!(evaluations.get() >= last);
        last = evaluations.get();
    }
}

#[test]
fn what_is_behind_is_not_seen_and_nonsense_is_dark() {
    let daylight = Daylight::usual(Weather::Clear, sun(40.0, 180.0), 100, 0.2).unwrap();
    let window = [DVec3::new(-1.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 1.0)];
    assert_eq!(daylight.illuminance_through(&window, DVec3::NEG_Y, EXACT, |_| 1.0), 0.0);
    assert_eq!(daylight.illuminance_through(&window[..2], DVec3::Y, EXACT, |_| 1.0), 0.0);
    assert_eq!(
        daylight.illuminance_through(&[DVec3::X, DVec3::ZERO, DVec3::Z], DVec3::X, EXACT, |_| 1.0),
        0.0
    );
    assert_eq!(daylight.illuminance_through(&window, DVec3::Y, EXACT, |_| 0.0), 0.0);
    // A window cut by the plane of the surface: only its upper half, and the whole is the sum of its parts.
    let square = |low: f64, high: f64| {
        [(-1.0, low), (1.0, low), (1.0, high), (-1.0, high)].map(|(x, z)| DVec3::new(x, 1.0, z))
    };
    let through = |low, high| daylight.illuminance_through(&square(low, high), DVec3::Z, EXACT, |_| 1.0);
    near(through(-1.0, 1.0) / through(0.0, 1.0), 1.0, 1e-9, "below the horizon is behind");
    near((through(0.0, 0.4) + through(0.4, 1.0)) / through(0.0, 1.0), 1.0, 1e-7, "parts");
    // An L: the square without its upper right quarter.
    let ell = [(-1.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.0, 0.5), (0.0, 1.0), (-1.0, 1.0)];
    let ell = ell.map(|(x, z)| DVec3::new(x, 1.0, z));
    let quarter = [(0.0, 0.5), (1.0, 0.5), (1.0, 1.0), (0.0, 1.0)].map(|(x, z)| DVec3::new(x, 1.0, z));
    for normal in [DVec3::Z, DVec3::Y, direction(-20.0, 60.0)] {
        let of = |corners: &[DVec3]| daylight.illuminance_through(corners, normal, EXACT, |_| 1.0);
        near((of(&ell) + of(&quarter)) / of(&square(0.0, 1.0)), 1.0, 1e-7, "an L and its rest");
    }
}

#[test]
fn bins_cover_the_sky() {
    for (splits, count) in [(1, 145), (2, 577), (3, 1297), (4, 2305)] {
        let bins = SkyBins::reinhart(splits);
        assert_eq!(bins.len(), count);
        let total: f64 = (0..count).map(|bin| bins.solid_angle(bin)).sum();
        near(total, 2.0 * PI, 1e-12, "solid angle");
        assert_eq!(bins.bin_of(DVec3::NEG_Z), count);
        near(bins.solid_angle(count), 2.0 * PI, 1e-12, "ground");
        for bin in 0..=count {
            assert_eq!(bins.bin_of(bins.centre(bin)), bin);
        }
        for bin in 0..count {
            // All four corners, a little inwards.
            let [from, to, start, end] = bins.edges(bin);
            for (t, u) in [(0.01, 0.01), (0.99, 0.01), (0.01, 0.99), (0.99, 0.99)] {
                let e = direction(from + (to - from) * t, start + (end - start) * u);
                assert_eq!(bins.bin_of(e), bin);
            }
        }
    }
    assert_eq!(SkyBins::tregenza(), SkyBins::reinhart(1));
    let tregenza = SkyBins::tregenza();
    assert!((tregenza.centre(0) - direction(6.0, 0.0)).length() < 1e-12, "the first bin is centred on north");
    assert!((tregenza.centre(1) - direction(6.0, 12.0)).length() < 1e-12, "clockwise");
    assert_eq!((tregenza.bin_of(DVec3::ZERO), tregenza.bin_of(DVec3::new(f64::NAN, 0.0, 1.0))), (145, 145));
    assert!(SkyBins::reinhart(1000).len() < 600_000 && SkyBins::reinhart(0).len() == 145);
}

#[test]
fn means_of_bins_keep_the_light_of_the_sky() {
    for (kind, elevation) in [(1, 35.0), (5, 35.0), (12, 35.0), (15, 35.0), (16, 35.0), (15, 86.0)] {
        let daylight = under(kind, sun(elevation, 200.0), 0.25);
        for splits in [1, 2, 4] {
            let bins = SkyBins::reinhart(splits);
            let values = bins.luminances(&daylight, BinValue::Mean);
            near(values[bins.len()], 0.25 / PI, 1e-12, "ground");
            // The integral of the luminance itself, by rings.
            let sum: f64 = (0..bins.len()).map(|bin| values[bin] * bins.solid_angle(bin)).sum();
            let fine = SkyBins::reinhart(16);
            let whole: f64 = fine
                .luminances(&daylight, BinValue::Centre)
                .iter()
                .take(fine.len())
                .enumerate()
                .map(|(bin, value)| value * fine.solid_angle(bin))
                .sum();
            near(sum / whole, 1.0, 2e-4, &format!("type {kind}, {splits}"));
        }
    }
}

/// Root mean square error of the illuminance at `points` in per cent, with a sky in bins.
fn bin_errors(
    daylight: &Daylight,
    opening: &[DVec3; 4],
    points: &[DVec3],
    normal: DVec3,
    splits: usize,
) -> f64 {
    const FINE: usize = 500;
    let bins = SkyBins::reinhart(splits);
    let values = bins.luminances(daylight, BinValue::Centre);
    let mut squares = 0.0;
    let (across, along) = (opening[1] - opening[0], opening[3] - opening[0]);
    let facing = across.cross(along);
    for &point in points {
        let (mut in_bins, mut smooth) = (0.0, 0.0);
        for cell in 0..FINE * FINE {
            let (s, t) = ((cell % FINE) as f64 + 0.5, (cell / FINE) as f64 + 0.5);
            let to = opening[0] + across * (s / FINE as f64) + along * (t / FINE as f64) - point;
            let square = to.length_squared();
            let weight = normal.dot(to).max(0.0) * facing.dot(to).abs() / (square * square);
            if weight > 0.0 && to.z > 0.0 {
                in_bins += weight * values[bins.bin_of(to)];
                smooth += weight * daylight.luminance(to);
            }
        }
        let error = 100.0 * (in_bins / smooth - 1.0);
        squares += error * error;
    }
    (squares / points.len() as f64).sqrt()
}

/// Coarse bins are for light that is reflected, fine ones for direct light: what they cost at points under
/// the two openings of CIE 171.
#[test]
fn errors_of_bins_at_points_in_a_room_are_as_known() {
    let facade = [(1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
    let roof = [(1.5, 1.5), (2.5, 1.5), (2.5, 2.5), (1.5, 2.5)].map(|(x, y)| DVec3::new(x, y, 3.0));
    let floor: Vec<DVec3> = (0..8).map(|k| DVec3::new(2.0, 0.25 + 0.5 * f64::from(k), 0.0)).collect();
    // Type, elevation of the sun; RMS in per cent on the floor by facade and by roof for 145, 577 and 2305
    // bins.
    let rows: [(u8, f64, [f64; 3], [f64; 3]); 3] = [
        (16, 60.0, [0.65, 0.16, 0.04], [0.2, 0.07, 0.01]),
        (12, 30.0, [2.5, 0.45, 0.09], [1.2, 0.4, 0.06]),
        (15, 30.0, [2.7, 0.45, 0.1], [1.6, 0.6, 0.08]),
    ];
    for (kind, elevation, by_facade, by_roof) in rows {
        let daylight = under(kind, sun(elevation, 180.0), 0.3);
        for (index, splits) in [1, 2, 4].into_iter().enumerate() {
            for (opening, wanted) in [(&facade, by_facade[index]), (&roof, by_roof[index])] {
                let rms = bin_errors(&daylight, opening, &floor, DVec3::Z, splits);
                assert!(
                    rms < 1.2 * wanted + 0.03 && rms > 0.4 * wanted,
                    "type {kind}, {splits}: {rms} for {wanted}"
                );
            }
        }
    }
}
