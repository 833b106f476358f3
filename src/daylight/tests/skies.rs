//! Skies of the CIE and of Perez.

use crate::daylight::{
    CieType, Daylight, Pattern, PerezSky, Phase, SOLAR_CONSTANT, Sky, SunPosition, Weather, direction,
};
use glam::DVec3;
use std::f64::consts::PI;

const SOUTH: DVec3 = DVec3::NEG_Y;
const NORTH: DVec3 = DVec3::Y;
const EAST: DVec3 = DVec3::X;

fn sun(elevation: f64, azimuth: f64) -> SunPosition {
    SunPosition::new(elevation, azimuth).unwrap()
}

#[track_caller]
fn near(found: f64, wanted: f64, most: f64, what: &str) {
    assert!((found - wanted).abs() <= most, "{what}: {found} is not {wanted}");
}

/// Horizontal over zenith luminance; vertical facing south, north, east over horizontal; luminance over that
/// of the zenith at elevation 30, azimuth 180 and 0. Sun in the south, at 60 and at 30 degrees. By
/// quadrature.
#[rustfmt::skip]
const CIE_ROWS: [(u8, [f64; 6], [f64; 6]); 10] = [
    (1, [2.449541, 0.379182, 0.379182, 0.379182, 0.66516, 0.66516],
        [2.449541, 0.379182, 0.379182, 0.379182, 0.66516, 0.66516]),
    (2, [2.086023, 0.419706, 0.265461, 0.323726, 0.66516, 0.36252],
        [2.556579, 0.519053, 0.279286, 0.353237, 1.55825, 0.49181]),
    (4, [2.315419, 0.482277, 0.310984, 0.375835, 0.81785, 0.44574],
        [2.890147, 0.607944, 0.327158, 0.412321, 1.91597, 0.60471]),
    (5, [PI, 0.5, 0.5, 0.5, 1.0, 1.0], [PI, 0.5, 0.5, 0.5, 1.0, 1.0]),
    (7, [2.421225, 0.546774, 0.284058, 0.371282, 1.0, 0.40372],
        [3.673046, 0.793883, 0.325065, 0.432917, 4.62373, 0.74789]),
    (10, [3.170261, 0.674661, 0.372306, 0.472687, 1.57695, 0.63665],
        [5.144911, 0.989142, 0.411804, 0.540012, 7.29139, 1.17939]),
    (12, [3.190573, 0.741940, 0.346104, 0.468690, 1.72615, 0.51891],
        [6.394106, 1.234571, 0.396611, 0.559038, 13.47901, 1.23557]),
    (13, [3.025853, 0.741540, 0.276245, 0.420517, 1.72615, 0.39165],
        [6.995215, 1.355156, 0.301940, 0.518763, 18.25011, 1.02243]),
    (15, [3.015856, 0.842278, 0.246002, 0.438031, 1.86071, 0.29269],
        [8.116024, 1.693664, 0.237490, 0.562870, 22.88244, 0.74614]),
    (16, [2.443461, 0.396177, 0.396177, 0.396177, 0.66667, 0.66667],
         [2.443461, 0.396177, 0.396177, 0.396177, 0.66667, 0.66667]),
];

#[test]
fn skies_of_the_cie_have_their_known_ratios() {
    for (number, at_60, at_30) in CIE_ROWS {
        let kind = CieType::new(number).unwrap();
        for (elevation, [h, vs, vn, ve, south, north]) in [(60.0, at_60), (30.0, at_30)] {
            let what = format!("type {number}, sun at {elevation}");
            let sky = Sky::new(Pattern::Cie(kind), sun(elevation, 180.0), 10_000.0);
            near(10_000.0 / sky.zenith(), h, 6e-7, &what);
            near(sky.illuminance(DVec3::Z) / 10_000.0, 1.0, 1e-12, &what);
            for (normal, ratio) in [(SOUTH, vs), (NORTH, vn), (EAST, ve), (-EAST, ve)] {
                near(sky.illuminance(normal) / 10_000.0, ratio, 6e-7, &format!("{what}, {normal}"));
            }
            for (azimuth, ratio) in [(180.0, south), (0.0, north)] {
                near(sky.luminance(direction(30.0, azimuth)) / sky.zenith(), ratio, 6e-6, &what);
            }
        }
    }
}

#[test]
fn the_sky_turns_with_the_sun() {
    for azimuth in [0.0, 77.0, 179.99, 269.9, 270.1, 301.0] {
        let sky = Sky::new(Pattern::Cie(CieType::CLEAR), sun(30.0, azimuth), 1.0);
        near(sky.illuminance(direction(0.0, azimuth)), 1.234571, 6e-7, "towards the sun");
        near(sky.illuminance(direction(0.0, azimuth + 180.0)), 0.396611, 6e-7, "away from it");
        near(sky.illuminance(direction(0.0, azimuth + 90.0)), 0.559038, 6e-7, "across");
        near(1.0 / sky.zenith(), 6.394_106, 6e-7, "zenith");
        let first = Sky::new(Pattern::Cie(CieType::CLEAR), sun(30.0, 45.0), 1.0).zenith();
        near(sky.zenith() / first, 1.0, 1e-9, "the zenith is the same whatever the azimuth");
    }
}

/// A surface at any tilt against plain sums over a fine grid.
#[test]
fn tilted_surfaces_agree_with_plain_sums() {
    let normals =
        [direction(45.0, 130.0), direction(5.0, 300.0), direction(-30.0, 200.0), direction(80.0, 0.0)];
    for (kind, elevation) in [(12, 35.0), (15, 88.0), (3, 10.0)] {
        let kind = CieType::new(kind).unwrap();
        let sky = Sky::new(Pattern::Cie(kind), sun(elevation, 200.0), 1.0);
        let (rows, columns) = (600, 1200);
        for normal in normals {
            let mut sum = 0.0;
            for row in 0..rows {
                let height = (f64::from(row) + 0.5) / f64::from(rows);
                for column in 0..columns {
                    let azimuth = 360.0 * (f64::from(column) + 0.5) / f64::from(columns);
                    let e = direction(height.asin().to_degrees(), azimuth);
                    sum += sky.luminance(e) * normal.dot(e).max(0.0);
                }
            }
            sum *= std::f64::consts::TAU / f64::from(rows * columns);
            near(sky.illuminance(normal) / sum, 1.0, 3e-5, &format!("{kind}, {normal}"));
        }
    }
    let down = Sky::new(Pattern::Uniform, sun(10.0, 0.0), 1.0);
    near(down.illuminance(DVec3::NEG_Z), 0.0, 1e-12, "facing down");
}

/// Of every class. Sun, direct normal and diffuse horizontal; clearness, brightness; a to e; luminance over
/// diffuse horizontal at the zenith, 10 degrees above the sun, at elevation 30 across and opposite, at
/// elevation 10 under the sun; vertical towards the sun over horizontal. For 1367 W/m² outside the
/// atmosphere.
type PerezRow = ([f64; 3], [f64; 2], [f64; 5], [f64; 5], f64);

#[expect(clippy::approx_constant, reason = "one of the luminances happens to be near a third of pi")]
#[rustfmt::skip]
const PEREZ_ROWS: [PerezRow; 9] = [
    ([40.0, 700.0, 150.0], [3.75837, 0.17036], [-0.95529, -0.33159, 13.03293, -3.44377, 0.26265],
        [0.18070, 1.04719, 0.20092, 0.17448, 0.94109], 1.01832),
    ([40.0, 200.0, 200.0], [1.59108, 0.22715], [-1.04869, -0.58851, 13.55232, -3.21686, 0.15185],
        [0.18499, 1.07322, 0.20134, 0.16663, 0.82395], 0.97573),
    ([25.0, 50.0, 120.0], [1.16535, 0.20663], [-1.54827, -0.75763, 8.47949, -2.49895, 0.19294],
        [0.12740, 1.18647, 0.25874, 0.22000, 1.66079], 1.22987),
    ([60.0, 900.0, 80.0], [10.78743, 0.06751], [-0.99342, -0.21185, 22.31448, -6.09582, 1.30879],
        [0.26342, 0.95613, 0.20552, 0.16218, 0.53998], 0.76620),
    ([15.0, 20.0, 60.0], [1.09995, 0.16715], [-1.66240, -0.70022, 8.46432, -2.57287, 0.19438],
        [0.08868, 1.75162, 0.27816, 0.25656, 3.00459], 1.46159),
    ([30.0, 5.0, 90.0], [1.02530, 0.13120], [0.85007, -0.61614, 0.45079, -0.38352, -0.03336],
        [0.35504, 0.34658, 0.29814, 0.28023, 0.26307], 0.47037),
    ([50.0, 90.0, 260.0], [1.25561, 0.24796], [-1.05091, -0.76043, 12.27322, -3.41848, 0.10373],
        [0.23984, 0.95320, 0.20474, 0.17162, 0.46523], 0.76814),
    ([45.0, 750.0, 110.0], [5.53235, 0.11361], [-0.97201, -0.21486, 15.04394, -3.91299, 0.60152],
        [0.18676, 1.00331, 0.19225, 0.16745, 0.86509], 1.00131),
    ([35.0, 350.0, 150.0], [2.21476, 0.19080], [-0.99594, -0.44138, 13.49898, -3.29137, 0.03877],
        [0.16504, 1.16662, 0.20483, 0.17454, 1.13202], 1.09080),
];

#[test]
fn all_weather_skies_have_their_known_coefficients_and_luminances() {
    for ([elevation, direct, diffuse], [clearness, brightness], coefficients, luminances, vertical) in
        PEREZ_ROWS
    {
        let what = format!("sun at {elevation}, {direct} and {diffuse} W/m²");
        let sun = sun(elevation, 180.0);
        let perez = PerezSky::new(sun, direct, diffuse, SOLAR_CONSTANT).unwrap();
        near(perez.clearness, clearness, 6e-6, &what);
        near(perez.brightness, brightness, 6e-6, &what);
        for (found, wanted) in perez.coefficients.iter().zip(coefficients) {
            near(*found, wanted, 6e-6, &what);
        }
        let sky = Sky::new(Pattern::Perez(perez), sun, diffuse);
        let directions = [
            DVec3::Z,
            direction(elevation + 10.0, 180.0),
            direction(30.0, 90.0),
            direction(30.0, 0.0),
            direction(10.0, 180.0),
        ];
        for (e, wanted) in directions.into_iter().zip(luminances) {
            near(sky.luminance(e) / diffuse, wanted, 6e-6, &format!("{what}, towards {e}"));
        }
        near(sky.illuminance(SOUTH) / diffuse, vertical, 6e-6, &what);
    }
}

/// Sun, direct normal and diffuse horizontal; lumens per watt of diffuse and direct light under 2 cm of
/// water, for 1367 W/m² outside the atmosphere; classes 1 to 8.
#[rustfmt::skip]
const EFFICACIES: [([f64; 3], [f64; 2]); 8] = [
    ([30.0, 5.0, 90.0], [120.41658, 55.36195]), ([25.0, 50.0, 120.0], [115.99782, 89.20263]),
    ([50.0, 90.0, 260.0], [118.88355, 97.21624]), ([40.0, 200.0, 200.0], [125.20508, 95.63347]),
    ([35.0, 350.0, 150.0], [138.86727, 94.35825]), ([40.0, 700.0, 150.0], [141.86766, 98.62571]),
    ([45.0, 750.0, 110.0], [138.54805, 102.61262]), ([60.0, 900.0, 80.0], [135.23474, 103.63143]),
];

#[test]
fn watts_become_lux_by_the_efficacies_of_perez() {
    for (index, ([elevation, direct, diffuse], [of_sky, of_sun])) in EFFICACIES.into_iter().enumerate() {
        let perez = PerezSky::new(sun(elevation, 180.0), direct, diffuse, SOLAR_CONSTANT).unwrap();
        assert_eq!(perez.class, index + 1);
        near(perez.diffuse_efficacy(2.0), of_sky, 6e-6, "diffuse");
        near(perez.direct_efficacy(2.0), of_sun, 6e-6, "direct");
    }
    let sun = sun(40.0, 180.0);
    // The extraterrestrial irradiance that makes the brightness 0.16459.
    let found = PerezSky::new(sun, 700.0, 150.0, SOLAR_CONSTANT * 0.170_36 / 0.164_59).unwrap();
    near(found.brightness, 0.164_59, 6e-6, "brightness");
    near(found.diffuse_efficacy(2.0), 142.86, 6e-3, "diffuse");
    near(found.direct_efficacy(2.0), 98.78, 6e-3, "direct");
    // More water takes infrared away, and light has more lumens per watt.
    assert!(found.diffuse_efficacy(4.0) > found.diffuse_efficacy(2.0));
    let daylight = Daylight::of_irradiances(700.0, 150.0, sun, 1, 2.0, 0.2).unwrap();
    near(daylight.sky().horizontal() / 150.0, 142.86, 0.1, "lux of the sky");
    near(daylight.direct_normal() / 700.0, 98.78, 0.02, "lux of the sun");
}

#[test]
fn classes_of_clearness_meet_at_their_borders() {
    let sun = sun(45.0, 0.0);
    let mut last = 0;
    for step in 0..2000 {
        let perez = PerezSky::new(sun, f64::from(step), 100.0, SOLAR_CONSTANT).unwrap();
        assert!(perez.class >= last && perez.class <= 8);
        last = perez.class;
    }
    assert_eq!(last, 8);
    assert_eq!(PerezSky::new(sun, 0.0, 100.0, SOLAR_CONSTANT).unwrap().class, 1);
}

/// Everything that a weather file may hold, and more: no sky is ever negative or not a number.
#[test]
fn no_sky_is_negative_or_undefined() {
    for elevation in [-90.0, -18.0, -3.0, -1e-9, 0.0, 1e-9, 0.3, 2.0, 10.0, 33.0, 60.0, 89.9, 90.0] {
        let sun = sun(elevation, 123.0);
        let mut all = Vec::new();
        for number in 1..=16 {
            all.push(Daylight::of_type(CieType::new(number).unwrap(), sun, 172, 0.2).unwrap());
        }
        for direct in [0.0, 1.0, 30.0, 400.0, 1200.0] {
            for diffuse in [0.0, 1e-6, 1.0, 20.0, 150.0, 700.0, 1500.0] {
                all.push(Daylight::of_irradiances(direct, diffuse, sun, 172, 2.0, 0.2).unwrap());
            }
        }
        for daylight in all {
            let what = daylight.sky().description();
            for e in [
                (0.0, 0.0),
                (0.0, 123.0),
                (1e-6, 123.0),
                (2.0, 90.0),
                (45.0, 123.0),
                (89.9999, 1.0),
                (90.0, 0.0),
            ] {
                let luminance = daylight.luminance(direction(e.0, e.1));
                assert!(luminance.is_finite() && luminance >= 0.0, "{what} towards {e:?}: {luminance}");
            }
            let total = daylight.sky().horizontal();
            assert!(total.is_finite() && total >= 0.0, "{what}");
            if total > 0.0 {
                near(daylight.sky().illuminance(DVec3::Z) / total, 1.0, 1e-9, &what);
            }
            for normal in [SOUTH, NORTH, DVec3::NEG_Z, direction(33.0, 211.0)] {
                let lux = daylight.illuminance(normal);
                assert!(lux.is_finite() && lux >= 0.0, "{what}: {lux}");
            }
            assert!(elevation > 0.0 || daylight.direct_normal() == 0.0);
        }
    }
}

#[test]
fn a_night_is_dark_and_twilight_falls_without_a_step() {
    for weather in Weather::ALL {
        assert_eq!(weather.diffuse_horizontal(sun(-18.1, 0.0)), 0.0);
        let mut last = f64::INFINITY;
        for step in 0..=1080 {
            let elevation = 90.0 - 0.1 * f64::from(step);
            let lux = weather.diffuse_horizontal(sun(elevation, 0.0));
            assert!(lux <= last && lux > 0.0, "{weather:?} at {elevation}: {lux} after {last}");
            last = lux;
        }
        near(weather.diffuse_horizontal(sun(-6.0, 0.0)), 3.4, 1e-9, "civil twilight");
        let (below, above) =
            (weather.diffuse_horizontal(sun(-1e-6, 0.0)), weather.diffuse_horizontal(sun(0.0, 0.0)));
        near(below / above, 1.0, 1e-3, "at the horizon");
    }
    let night = Daylight::usual(Weather::Clear, sun(-40.0, 10.0), 1, 0.2).unwrap();
    assert_eq!(night.sky().pattern(), Pattern::Dark);
    assert_eq!(
        (night.illuminance(DVec3::Z), night.luminance(DVec3::Z), night.ground_luminance()),
        (0.0, 0.0, 0.0)
    );
    let phases = [10.0, 0.1, -0.1, -17.9, -18.1].map(|elevation| Phase::of(sun(elevation, 0.0)));
    assert_eq!(phases, [Phase::Day, Phase::Day, Phase::Twilight, Phase::Twilight, Phase::Night]);
}

#[test]
fn plain_weather_gives_plausible_light() {
    let noon = sun(60.0, 180.0);
    let clear = Daylight::usual(Weather::Clear, noon, 172, 0.2).unwrap();
    // A summer day: about 100,000 lux in all, a seventh of it from the sky.
    assert!((85_000.0..110_000.0).contains(&clear.global_horizontal()), "{}", clear.global_horizontal());
    assert!((12_000.0..18_000.0).contains(&clear.sky().horizontal()));
    let overcast = Daylight::usual(Weather::Overcast, noon, 172, 0.2).unwrap();
    assert!((15_000.0..22_000.0).contains(&overcast.global_horizontal()));
    assert_eq!(overcast.direct_normal(), 0.0);
    assert_eq!(Weather::ALL.map(|weather| Weather::of(weather.sky())), Weather::ALL);
}

#[test]
fn sun_disc_and_ground_are_where_they_should_be() {
    let low = sun(25.0, 100.0);
    let daylight = Daylight::new(Pattern::Uniform, low, 10_000.0, 50_000.0, 0.3).unwrap();
    let global = 10_000.0 + 50_000.0 * 25_f64.to_radians().sin();
    near(daylight.global_horizontal(), global, 1e-9, "global");
    let ground = 0.3 * global / PI;
    near(daylight.luminance(direction(-1.0, 3.0)), ground, 1e-9, "ground");
    near(daylight.radiance(direction(-1.0, 3.0)), ground / 179.0, 1e-9, "radiance of the ground");
    near(daylight.illuminance(DVec3::NEG_Z), 0.3 * global, 1e-9, "facing down");
    let facing = 5000.0 + 0.15 * global + 50_000.0 * 25_f64.to_radians().cos();
    near(daylight.illuminance(direction(0.0, 100.0)), facing, 1e-6, "vertical towards the sun");
    near(daylight.sun_luminance() * 6.797e-5 / 50_000.0, 1.0, 1e-4, "luminance of the sun");
    assert!(daylight.meets_sun(direction(25.2664, 100.0)) && !daylight.meets_sun(direction(25.2667, 100.0)));
    for (ground, lux) in [(1.2, 1.0), (f64::NAN, 1.0), (0.2, -1.0), (0.2, f64::NAN), (0.2, 1e9)] {
        assert!(Daylight::new(Pattern::Uniform, low, lux, 0.0, ground).is_err());
    }
    assert!(Daylight::of_irradiances(2000.0, 1.0, low, 1, 2.0, 0.2).is_err());
    assert!(CieType::new(0).is_err() && CieType::new(17).is_err());
}
