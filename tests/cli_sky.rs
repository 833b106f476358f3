//! `lumenwalk sky` and `lumenwalk check` of weather files, as a user meets them.

mod cli_support;

use cli_support::Workplace;

const BERLIN: [&str; 8] =
    ["--place", "52.52,13.405", "--zone", "1", "--date", "2026-03-20", "--time", "12:00"];

fn sky(place: &Workplace, more: &[&str]) -> String {
    place.succeed(&[&["sky"], &BERLIN[..], more].concat())
}

/// The figures of a row of the table: sky, sun, ground, in all.
fn row(told: &str, name: &str) -> [f64; 4] {
    let line = told.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}:\n{told}"));
    let fields: Vec<f64> =
        line.split_whitespace().skip(1).map(|field| field.replace(',', "").parse().unwrap()).collect();
    fields.try_into().unwrap_or_else(|_| panic!("{line}"))
}

#[test]
fn a_sky_is_told_by_its_figures() {
    let place = Workplace::with_room(0.5);
    let help = place.succeed(&["sky", "--help"]);
    let options =
        ["--place", "--zone", "--date", "--time", "--type", "--lux", "--perez", "--weather", "--image"];
    for option in options.iter().chain(&["--ground", "--projection", "--size"]) {
        assert!(help.contains(option), "{option} is missing:\n{help}");
    }
    let told = sky(&place, &["--type", "12", "--lux", "0,10000"]);
    assert!(told.contains("elevation 37.34, azimuth 175.65 degrees\n"), "{told}");
    assert!(told.contains("CIE sky type 12"), "{told}");
    assert_eq!(row(&told, "horizontal"), [10_000.0, 0.0, 0.0, 10_000.0]);
    let [south, _, ground, _] = row(&told, "south");
    let [north, ..] = row(&told, "north");
    assert!(south > 2.5 * north && ground == 1000.0, "{told}");
    // 5 and 16 are uniform and overcast: a zenith of E/pi, and of 9/7 of that.
    assert!(sky(&place, &["--type", "uniform", "--lux", "0,10000"]).contains("zenith      3,183 cd/m²"));
    assert!(sky(&place, &["--type", "16", "--lux", "0,10000"]).contains("zenith      4,093 cd/m²"));
    let told = sky(&place, &["--perez", "700,150", "--ground", "0"]);
    assert!(
        told.contains("Perez") && told.contains("direct normal 700 W/m² (9") && told.contains("(14"),
        "{told}"
    );
    let [from_sky, from_sun, from_ground, in_all] = row(&told, "horizontal");
    assert!((from_sky + from_sun - in_all).abs() <= 1.0 && from_ground == 0.0, "{told}");
    let told = sky(&place, &[]);
    assert!(told.contains("note: the illuminances are those that clear weather usually gives"), "{told}");
}

#[test]
fn nights_poles_and_suns_overhead_are_told() {
    let place = Workplace::with_room(0.5);
    let at = |place_zone: [&str; 2], date: &str, time: &str| {
        let [at, zone] = place_zone;
        place.succeed(&["sky", "--place", at, "--zone", zone, "--date", date, "--time", time])
    };
    let night = at(["52.52,13.405", "1"], "2026-12-21", "00:00");
    assert!(night.contains("degrees: night") && night.contains("sky         dark"), "{night}");
    assert_eq!(row(&night, "horizontal"), [0.0; 4]);
    let dusk = at(["52.52,13.405", "1"], "2026-12-21", "16:10");
    assert!(dusk.contains("degrees: twilight") && row(&dusk, "horizontal")[3] > 10.0, "{dusk}");
    let pole = at(["90,0", "0"], "2026-06-21", "12:00");
    assert!(pole.contains("elevation 23.4"), "{pole}");
    let overhead = at(["-0.1807,-78.4678", "-5"], "2026-03-20", "12:20");
    assert!(overhead.contains("elevation 89.62"), "{overhead}");
    for told in [&night, &dusk, &pole, &overhead] {
        assert!(!told.contains("NaN") && !told.contains("inf"), "{told}");
    }
}

#[test]
fn pictures_are_written_in_both_layouts() {
    let place = Workplace::with_room(0.5);
    let told = sky(&place, &["--image", "sky.png", "--size", "80x60"]);
    assert!(told.ends_with("picture     sky.png\n"), "{told}");
    let picture = image::open(place.path("sky.png")).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (80, 60));
    // The sun stands in the south, below the middle of the disc.
    let value = |x, y| picture.get_pixel(x, y).0[0];
    let (sun, north) = (value(41, 47), value(40, 13));
    assert!(sun > 250 && (60..220).contains(&north) && value(0, 0) == 0, "{sun}, {north}");
    sky(&place, &["--image", "sky.exr", "--projection", "latlong", "--size", "64x32"]);
    assert!(std::fs::metadata(place.path("sky.exr")).unwrap().len() > 1000);
    let failed = |more: &[&str]| place.fail(1, &[&["sky"], &BERLIN[..], more].concat());
    assert!(failed(&["--image", "nowhere/sky.png"]).contains("folder does not exist"));
    let refused = place.fail(2, &[&["sky"], &BERLIN[..], &["--image", "sky.tiff"]].concat());
    assert!(refused.contains(".png"), "{refused}");
}

#[test]
fn what_cannot_be_is_wrong_usage() {
    let place = Workplace::with_room(0.5);
    let wrong: &[(&str, &[&str])] = &[
        ("30 February 2026", &["--place", "1,2", "--zone", "0", "--date", "2026-02-30", "--time", "12:00"]),
        ("latitude is 91", &["--place", "91,2", "--zone", "0", "--date", "2026-02-20", "--time", "12:00"]),
        ("time zone is 99", &["--place", "1,2", "--zone", "99", "--date", "2026-02-20", "--time", "12:00"]),
        ("00:00 to 24:00", &["--place", "1,2", "--zone", "0", "--date", "2026-02-20", "--time", "25:00"]),
        ("--zone", &["--place", "1,2", "--date", "2026-02-20", "--time", "12:00"]),
        ("--place", &["--date", "2026-02-20", "--time", "12:00"]),
        ("none.epw", &["--weather", "none.epw", "--date", "2026-02-20", "--time", "12:00"]),
    ];
    for (words, arguments) in wrong {
        let output = place.run(&[&["sky"], *arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(words) && output.stdout.is_empty(), "{arguments:?}: {said}");
    }
    for more in [
        &["--type", "17"][..],
        &["--type", "blue"],
        &["--perez", "700"],
        &["--perez", "9000,1"],
        &["--perez", "700,150", "--type", "1"],
        &["--lux", "-1,5"],
        &["--ground", "2"],
        &["--projection", "latlong"],
        &["--weather", "a.epw"],
    ] {
        let output = place.run(&[&["sky"], &BERLIN[..], more].concat());
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{more:?}");
    }
}

const WEATHER: &str = "\
LOCATION,Quito,-,ECU,Made,840710,-0.15,-78.48,-5.0,2812
DATA PERIODS,1,1,Data,Sunday,1/1,12/31
1999,3,21,12,60,?,20,9.5,50,72000,0,1415,300,900,700,220
1999,3,21,13,60,?,20,9.5,50,72000,0,1415,300,1000,9999,220
";

#[test]
fn a_weather_file_is_checked_and_gives_the_sky_of_an_hour() {
    let place = Workplace::with_room(0.5);
    place.put("quito.epw", WEATHER);
    let told = place.succeed(&["check", "quito.epw"]);
    assert!(told.contains("Quito, ECU, 2812 m") && told.contains("2 warnings"), "{told}");
    let at = |time| ["sky", "--weather", "quito.epw", "--date", "2026-03-21", "--time", time];
    let told = place.succeed(&at("11:10"));
    assert!(
        told.contains("21 March 2026, 11:30") && told.contains("hour from 11 to 12 o'clock in 1999"),
        "{told}"
    );
    assert!(told.contains("direct normal 700 W/m² ("), "{told}");
    assert!(place.fail(2, &at("12:10")).contains("irradiance of hour 13 on 21 March is missing"));
    assert!(place.fail(2, &at("13:10")).contains("no hour from 13 to 14 o'clock on 21 March"));
    place.put("bad.epw", &WEATHER.replace(",12,60,", ",noon,60,"));
    assert!(place.fail(2, &["check", "bad.epw"]).contains("bad.epw, line 3: the hour is 'noon'"));
    assert!(place.fail(2, &["check", "none.epw"]).contains("none.epw"));
}

/// A room of 4 x 5 x 3 m without its south wall and a closed box, z up, with a sky of these keys or none.
fn put_open_room(place: &Workplace, daylight: &str) {
    place.put(
        "open.obj",
        "mtllib open.mtl\nusemtl grey\nv 0 0 0\nv 4 0 0\nv 4 5 0\nv 0 5 0\nv 0 0 3\nv 4 0 3\nv 4 5 3\nv 0 5 3\n\
         f 1 2 3 4\nf 8 7 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 3 2 6 7\n\
         usemtl glow\nv 1.5 2 2.9\nv 2.5 2 2.9\nv 2.5 3 2.9\nv 1.5 3 2.9\nf 12 11 10 9\n\
         usemtl grey\nv 8 0 0\nv 11 0 0\nv 11 3 0\nv 8 3 0\nv 8 0 3\nv 11 0 3\nv 11 3 3\nv 8 3 3\n\
         f 13 14 15 16\nf 20 19 18 17\nf 16 15 19 20\nf 13 16 20 17\nf 15 14 18 19\nf 13 17 18 14\n",
    );
    place.put("open.mtl", "newmtl grey\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 0 0 0\nKe 5 5 5\n");
    place.put("open.toml", &format!("up = \"z\"\n{daylight}"));
}

/// A column of a table by its name.
fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let at = lines.next().and_then(|header| header.split(',').position(|field| field == name));
    let at = at.unwrap_or_else(|| panic!("no column {name}:\n{table}"));
    lines.map(|line| line.split(',').nth(at).and_then(|field| field.parse().ok()).expect(name)).collect()
}

#[test]
fn points_and_work_planes_have_daylight_factors_where_there_is_a_sky() {
    let place = Workplace::with_room(0.5);
    place.put("p.csv", "2,2.5,0.8,0,0,1\n2,-30,5,0,0,1\n");
    let solve = |more: &[&str]| {
        let own = ["solve", "open.obj", "--patches", "500", "--points", "p.csv", "--irradiance", "o.csv"];
        place.succeed(&[&own, more].concat())
    };
    // 1. The same under a clear sky and under the overcast one; outside it is all of the light.
    let mut factors = Vec::new();
    for (sky, told) in [
        (
            "sky = \"clear\"\nlux = [75000, 12000]\nsun = [40, 170]",
            "instead of the scene's own; lamps and sun off",
        ),
        ("sky = \"overcast\"\nlux = [0, 9000]\nsun = [40, 170]", "under the overcast sky of the scene"),
    ] {
        put_open_room(&place, &format!("[daylight]\n{sky}\n"));
        let said = solve(&[]);
        assert!(said.contains(told), "{said}");
        let found = column(&place.text("o.csv"), "daylight_factor");
        let errors = column(&place.text("o.csv"), "daylight_factor_error");
        assert!((found[1] - 100.0).abs() < 0.3, "the open horizontal: {found:?}");
        assert!(errors[0] > 0.0 && errors[0] < 0.1 * found[0], "{found:?} {errors:?}");
        factors.push(found[0]);
    }
    assert!((factors[0] / factors[1] - 1.0).abs() < 0.01, "{factors:?}");
    // 2. With the sky alone they are illuminances over that outside.
    solve(&["--off", "glow"]);
    let (lux, own) = (column(&place.text("o.csv"), "lux"), column(&place.text("o.csv"), "daylight_factor"));
    assert!((lux[0] / 90.0 / own[0] - 1.0).abs() < 2e-3, "{lux:?} {own:?}");
    // 3. Grids.
    let said = solve(&["--work-plane", "0.85", "--work-plane-table", "g.csv", "--report", "r.json"]);
    // 3 x 4 m without the border, p = 0.2 * 5^log10(4) = 0.527 m: 8 points along, 6 across.
    assert!(said.contains("Room 1, 4.00 x 5.00 m: work plane 0.85 m above the floor, 48 points"), "{said}");
    assert!(said.contains("  daylight factor: mean "), "{said}");
    assert!(
        said.contains("1 closed space that no light reaches left out") && !said.contains("Room 2"),
        "{said}"
    );
    let grid = place.text("g.csv");
    let (lux, factors) = (column(&grid, "lux"), column(&grid, "daylight_factor"));
    assert_eq!(lux.len(), 48);
    assert!(column(&grid, "z").iter().all(|z| (z - 0.85).abs() < 1e-9));
    let report: serde_json::Value = serde_json::from_str(&place.text("r.json")).expect("a report");
    let plane = &report["work_planes"][0];
    let number = |path: &str| plane.pointer(path).and_then(serde_json::Value::as_f64).expect("a number");
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((number("/illuminance_lx/mean") / mean(&lux) - 1.0).abs() < 1e-9);
    assert!((number("/uniformity") - least(&lux) / mean(&lux)).abs() < 1e-9);
    assert!((number("/daylight_factor_percent/minimum") - least(&factors)).abs() < 1e-9);
    // 4. Without a sky there are none.
    put_open_room(&place, "");
    let said = solve(&["--work-plane"]);
    assert!(said.contains("work plane 0.80 m") && !said.contains("daylight factor"), "{said}");
    assert!(!place.text("o.csv").contains("daylight_factor"));
    // 5. No room, no plane.
    let complaint = place.fail(2, &["solve", "open.obj", "--work-plane", "3.2"]);
    assert!(complaint.contains("no room was found"), "{complaint}");
}
