//! Places, times and the position of the sun.

use crate::daylight::{Compass, Date, LocalTime, Place, SunPosition, angles, direction, eccentricity};
use crate::daylight::{SUN_DIAMETER, sun_solid_angle};
use glam::DVec3;

fn local(date: [i32; 3], hour: f64, minute: f64, second: f64) -> LocalTime {
    let date = Date::new(date[0], date[1] as u32, date[2] as u32).unwrap();
    LocalTime::new(date, hour + minute / 60.0 + second / 3600.0).unwrap()
}

#[test]
fn the_example_of_reda_and_andreas_is_reproduced() {
    let place = Place::new(39.742_476, -105.1786, -7.0).unwrap();
    let sun = SunPosition::refracted(place, local([2003, 10, 17], 12.0, 30.0, 30.0), 1830.14, 820.0, 11.0);
    let sun = sun.unwrap();
    // Their difference of terrestrial and universal time is 67 s and the estimate for that month 64.6 s.
    assert!((90.0 - sun.elevation() - 50.111_62).abs() < 1e-5, "{sun:?}");
    assert!((sun.azimuth() - 194.340_24).abs() < 5e-5, "{sun:?}");
}

/// Elevation and azimuth without refraction, and the elevation with it, by two independent programs.
#[test]
fn suns_over_nine_cities() {
    #[rustfmt::skip]
    let rows = [
        ("Berlin", 52.52, 13.405, [2026, 3, 20], 12.0, 0.0, 1.0, 37.3363, 175.6502, 37.3583),
        ("Berlin", 52.52, 13.405, [2026, 6, 21], 9.0, 0.0, 2.0, 35.2670, 96.9903, 35.2907),
        ("London", 51.5074, -0.1278, [2026, 12, 21], 12.0, 0.0, 0.0, 15.0526, 180.3383, 15.1134),
        ("New York", 40.7128, -74.006, [2026, 9, 22], 15.0, 30.0, -4.0, 35.3497, 232.5295, 35.3734),
        ("Singapore", 1.3521, 103.8198, [2026, 6, 21], 13.0, 0.0, 8.0, 67.8576, 3.9429, 67.8644),
        ("Sydney", -33.8688, 151.2093, [2026, 12, 21], 10.0, 0.0, 11.0, 50.9506, 86.1514, 50.9643),
        ("Reykjavik", 64.1466, -21.9426, [2026, 6, 21], 23.0, 0.0, 0.0, 2.3003, 326.0826, 2.5629),
        ("Quito", -0.1807, -78.4678, [2026, 3, 20], 12.0, 20.0, -5.0, 89.6176, 54.3016, 89.6177),
        ("Tokyo", 35.6762, 139.6503, [2026, 1, 15], 8.0, 0.0, 9.0, 11.2271, 126.5662, 11.3077),
    ];
    for (name, latitude, longitude, date, hour, minute, zone, elevation, azimuth, refracted) in rows {
        let place = Place::new(latitude, longitude, zone).unwrap();
        assert_eq!(place.doubt(), None, "{name}");
        let time = local(date, hour, minute, 0.0);
        let sun = SunPosition::at(place, time).unwrap();
        assert!((sun.elevation() - elevation).abs() < 1e-4, "{name}: {sun:?}");
        // Beside the zenith an azimuth has fewer digits.
        let digits = if elevation > 89.0 { 0.01 } else { 1e-4 };
        assert!((sun.azimuth() - azimuth).abs() < digits, "{name}: {sun:?}");
        let seen = SunPosition::refracted(place, time, 0.0, 1013.25, 12.0).unwrap();
        assert!((seen.elevation() - refracted).abs() < 1e-4, "{name}: {seen:?} for {refracted}");
    }
}

#[test]
fn poles_date_line_and_midnight_are_places_and_times_like_others() {
    for (latitude, longitude, zone) in [(90.0, 0.0, 0.0), (-90.0, 180.0, 12.0), (0.0, -180.0, -12.0)] {
        let place = Place::new(latitude, longitude, zone).unwrap();
        for hours in [0.0, 12.0, 24.0] {
            let time = LocalTime::new(Date::new(2026, 6, 21).unwrap(), hours).unwrap();
            let sun = SunPosition::at(place, time).unwrap();
            assert!(sun.elevation().is_finite() && (0.0..360.0).contains(&sun.azimuth()), "{sun:?}");
            assert!((sun.direction().length() - 1.0).abs() < 1e-12);
        }
    }
    // At the North Pole in June the sun circles at the height of its declination.
    let pole = Place::new(90.0, 0.0, 0.0).unwrap();
    for hours in [1.0, 7.0, 13.0, 19.0] {
        let time = LocalTime::new(Date::new(2026, 6, 21).unwrap(), hours).unwrap();
        assert!((SunPosition::at(pole, time).unwrap().elevation() - 23.43).abs() < 0.02);
    }
    // 24 h of one day are 0 h of the next.
    let place = Place::new(52.0, 13.0, 1.0).unwrap();
    let end = SunPosition::at(place, local([2026, 2, 28], 24.0, 0.0, 0.0)).unwrap();
    let start = SunPosition::at(place, local([2026, 3, 1], 0.0, 0.0, 0.0)).unwrap();
    assert!((end.elevation() - start.elevation()).abs() < 1e-6);
}

#[test]
fn what_cannot_be_is_refused_with_a_reason() {
    let fault = |result: Result<Place, _>, wanted: &str| {
        let said = result.map_err(|error: crate::daylight::DaylightError| error.to_string()).unwrap_err();
        assert!(said.contains(wanted) && !said.ends_with('.'), "{said}");
    };
    fault(Place::new(91.0, 0.0, 0.0), "the latitude is 91, but must lie between -90");
    fault(Place::new(f64::NAN, 0.0, 0.0), "latitude");
    fault(Place::new(0.0, -181.0, 0.0), "the longitude is -181");
    fault(Place::new(0.0, 0.0, 15.0), "the time zone is 15 h");
    let date = |y, m, d| Date::new(y, m, d).map_err(|error| error.to_string());
    assert_eq!(
        date(2026, 2, 30).unwrap_err(),
        "30 February 2026 does not exist: February has 28 days in that year"
    );
    assert!(date(2026, 2, 29).is_err() && date(2028, 2, 29).is_ok() && date(1900, 2, 29).is_err());
    assert!(date(2026, 13, 1).unwrap_err().contains("the month is 13"));
    assert!(date(2026, 0, 1).is_err() && date(2026, 1, 0).is_err() && date(0, 1, 1).is_err());
    assert!(date(1582, 10, 10).unwrap_err().contains("between 1600 and 2999"));
    let day = date(2026, 1, 1).unwrap();
    assert!(LocalTime::new(day, 24.5).is_err() && LocalTime::new(day, f64::NAN).is_err());
    assert!(SunPosition::new(90.1, 0.0).is_err() && SunPosition::new(0.0, f64::INFINITY).is_err());
    let swapped = Place::new(40.7, -74.0, 5.0).unwrap();
    assert!(swapped.doubt().unwrap().contains("east is positive"));
}

#[test]
fn days_are_counted_and_times_are_written_as_people_write_them() {
    assert_eq!(Date::new(2026, 12, 31).unwrap().day_of_year(), 365);
    assert_eq!(Date::new(2028, 12, 31).unwrap().day_of_year(), 366);
    assert_eq!(Date::new(2028, 3, 1).unwrap().day_of_year(), 61);
    let time = LocalTime::new(Date::new(2026, 3, 5).unwrap(), 9.0 + 59.9 / 60.0).unwrap();
    assert_eq!(time.to_string(), "5 March 2026, 10:00");
    // Perihelion early in January, aphelion early in July: 1.67 % of the distance either way.
    assert!((eccentricity(3) - 1.0351).abs() < 3e-4 && (eccentricity(185) - 0.9666).abs() < 3e-4);
}

#[test]
fn directions_and_angles_are_inverse_and_the_disc_has_its_size() {
    for (elevation, azimuth) in [(0.0, 0.0), (30.0, 90.0), (-20.0, 359.0), (60.0, 181.0)] {
        let (e, a) = angles(direction(elevation, azimuth));
        assert!((e - elevation).abs() < 1e-12 && (a - azimuth).abs() < 1e-12);
    }
    assert!((direction(0.0, 90.0) - DVec3::X).length() < 1e-15, "east is x");
    assert!((direction(0.0, 0.0) - DVec3::Y).length() < 1e-15, "north is y");
    assert_eq!(SUN_DIAMETER, 0.533);
    assert!((sun_solid_angle() - 6.797e-5).abs() < 5e-9);
}

#[test]
fn a_compass_turns_the_sky_into_either_kind_of_model() {
    let (east, north, up) = (DVec3::X, DVec3::Y, DVec3::Z);
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} is not {b}");
    let plain = Compass::y_up(0.0);
    near(plain.to_model(north), DVec3::NEG_Z);
    near(plain.to_model(east), DVec3::X);
    near(plain.to_model(up), DVec3::Y);
    // The north of the site lies to the right on the plan.
    let turned = Compass::y_up(90.0);
    near(turned.to_model(north), DVec3::X);
    near(turned.to_model(east), DVec3::Z);
    near(Compass::z_up(0.0).to_model(direction(20.0, 77.0)), direction(20.0, 77.0));
    // North 30 degrees to the right: what stands at azimuth 10 of the sky appears at 40 on the plan.
    near(Compass::z_up(30.0).to_model(direction(20.0, 10.0)), direction(20.0, 40.0));
    for compass in [Compass::y_up(33.0), Compass::z_up(-200.0), Compass::z_up(f64::NAN)] {
        let e = direction(12.0, 345.0);
        near(compass.to_sky(compass.to_model(e)), e);
        let (a, b, c) = (compass.to_model(east), compass.to_model(north), compass.to_model(up));
        near(a.cross(b), c);
    }
}
