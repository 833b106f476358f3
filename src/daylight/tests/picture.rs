//! Pictures of the sky.

use crate::daylight::{CieType, Daylight, Pattern, Projection, SunPosition, direction};
use glam::DVec3;
use std::f64::consts::PI;

#[track_caller]
fn sees(projection: Projection, at: [f64; 2], size: [u32; 2], wanted: Option<DVec3>) {
    let found = projection.direction(at[0], at[1], size);
    match (found, wanted) {
        (Some(found), Some(wanted)) => assert!((found - wanted).length() < 1e-12, "{found} is not {wanted}"),
        _ => assert_eq!(found.is_some(), wanted.is_some(), "{at:?}"),
    }
}

#[test]
fn directions_are_where_a_plan_and_a_map_have_them() {
    let (fish, size) = (Projection::Fisheye, [200, 100]);
    sees(fish, [100.0, 50.0], size, Some(DVec3::Z));
    sees(fish, [100.0, 0.0], size, Some(direction(0.0, 0.0)));
    sees(fish, [150.0, 50.0], size, Some(direction(0.0, 90.0)));
    sees(fish, [100.0, 75.0], size, Some(direction(45.0, 180.0)));
    sees(fish, [0.0, 50.0], size, None);
    let (map, size) = (Projection::LatitudeLongitude, [360, 180]);
    sees(map, [180.0, 90.0], size, Some(direction(0.0, 180.0)));
    sees(map, [90.0, 60.0], size, Some(direction(30.0, 90.0)));
    sees(map, [270.0, 180.0], size, Some(DVec3::NEG_Z));
}

/// What the pixels of all directions add up to is what a horizontal surface receives, the sun's disc
/// included.
#[test]
fn pixels_add_up_to_the_light_of_the_sky() {
    let clear = Pattern::Cie(CieType::CLEAR);
    for (elevation, size) in [(30.0, [720, 360]), (70.0, [360, 180]), (32.0, [90, 45])] {
        let sun = SunPosition::new(elevation, 200.2).unwrap();
        let daylight = Daylight::new(clear, sun, 10_000.0, 80_000.0, 0.2).unwrap();
        let pixels = daylight.picture(Projection::LatitudeLongitude, size);
        let [width, height] = size.map(|side| side as usize);
        let (mut up, mut down) = (0.0, 0.0);
        for (index, &value) in pixels.iter().enumerate() {
            let zenith = PI * ((index / width) as f64 + 0.5) / height as f64;
            let solid = zenith.sin() * (PI / height as f64) * (2.0 * PI / width as f64);
            up += f64::from(value) * solid * zenith.cos().max(0.0);
            down += f64::from(value) * solid * (-zenith.cos()).max(0.0);
        }
        let wanted = daylight.global_horizontal();
        assert!((up / wanted - 1.0).abs() < 0.02, "{elevation}, {size:?}: {up} for {wanted}");
        assert!((down / (0.2 * wanted) - 1.0).abs() < 0.03, "{elevation}, {size:?}: {down}");
    }
}

#[test]
fn the_sun_is_where_it_stands_and_the_rim_is_dark() {
    let sun = SunPosition::new(45.0, 90.0).unwrap();
    let daylight = Daylight::new(Pattern::Uniform, sun, 1000.0, 80_000.0, 0.2).unwrap();
    let pixels = daylight.picture(Projection::Fisheye, [101, 101]);
    let brightest = (0..pixels.len()).max_by(|&a, &b| pixels[a].total_cmp(&pixels[b])).unwrap();
    assert_eq!((brightest % 101, brightest / 101), (75, 50));
    assert_eq!((pixels[0], pixels[100]), (0.0, 0.0));
    let sky = 1000.0 / PI as f32;
    assert!((pixels[50 * 101 + 50] / sky - 1.0).abs() < 1e-5);
}
