//! `lumenwalk solve` from file to files: what it writes is read back and held against physics.

mod cli_support;

use cli_support::Workplace;
use std::f64::consts::PI;

/// Fields of a CSV line by the name of their column.
fn column(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|n| n == name);
    let place = place.unwrap_or_else(|| panic!("no column {name}"));
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

fn json(text: &str, path: &[&str]) -> f64 {
    let mut value: &serde_json::Value = &serde_json::from_str(text).unwrap();
    for key in path {
        value = &value[key];
    }
    value.as_f64().unwrap_or_else(|| panic!("{path:?}: {value}"))
}

/// Point to parallel rectangle with a corner over the point: sides a, b at distance c
/// (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3).
fn corner_factor(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (p, q) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    (x / p * (y / p).atan() + y / q * (x / q).atan()) / (2.0 * PI)
}

#[test]
fn direct_light_at_points_is_that_of_the_closed_form() {
    let place = Workplace::with_room(0.0);
    // Under the middle of the lamp, under its corner, and beside it where it is out of sight.
    place.put("p.csv", "x,y,z,nx,ny,nz\n1000,0,1000,0,1,0\n750,500,750,0,3,0\n1000,1800,1000,0,1,0\n");
    place.succeed(&["solve", "room.obj", "--patches", "400", "--points", "p.csv", "--irradiance", "o.csv"]);
    let out = place.text("o.csv");
    let expected = [4.0 * corner_factor(0.25, 0.25, 1.5), corner_factor(0.5, 0.5, 1.0), 0.0];
    for (band, exitance) in [("irradiance_r", 10.0), ("irradiance_g", 20.0), ("irradiance_b", 30.0)] {
        for (found, factor) in column(&out, band).into_iter().zip(expected) {
            let expected = exitance * factor;
            assert!((found - expected).abs() <= 0.01 * expected + 1e-6, "{band}: {found}, not {expected}");
        }
    }
    let watts = [10.0, 20.0, 30.0].map(|e| e * expected[0]);
    let lux = 179.0 * (0.2126 * watts[0] + 0.7152 * watts[1] + 0.0722 * watts[2]);
    let found = column(&out, "lux")[0];
    assert!((found - lux).abs() < 0.01 * lux, "{found} lx, not {lux}");
    assert_eq!(column(&out, "x"), [1000.0, 750.0, 1000.0]);
    assert_eq!(column(&out, "ny"), [1.0; 3]);
}

#[test]
fn dimming_scales_the_light_and_switching_off_ends_it() {
    let place = Workplace::with_room(0.6);
    place.put("p.csv", "300,0,400,0,1,0\n0,900,1000,1,0,0\n");
    let lux = |lamp: &[&str]| {
        let mut arguments =
            vec!["solve", "room.obj", "--patches", "200", "--points", "p.csv", "--irradiance", "o.csv"];
        arguments.extend(lamp);
        place.succeed(&arguments);
        column(&place.text("o.csv"), "lux")
    };
    let (full, dimmed) = (lux(&[]), lux(&["--dim", "Desk lamp=0.25"]));
    assert!(full.iter().all(|&v| v > 10.0), "{full:?}");
    for (full, dimmed) in full.iter().zip(&dimmed) {
        assert!((dimmed / full - 0.25).abs() < 1e-4, "{dimmed} of {full}");
    }
    assert_eq!(lux(&["--off", "desk lamp"]), [0.0, 0.0]);
    assert_eq!(lux(&["--off", "Desk lamp", "--dim", "Desk lamp=0.5"]), [0.0, 0.0]);
}

#[test]
fn every_output_is_written_and_they_agree_with_each_other() {
    let place = Workplace::with_room(0.5);
    let told = place.succeed(&[
        "solve",
        "room.obj",
        "--patch-size",
        "250",
        "--image",
        "a.png",
        "--size",
        "96x64",
        "--patch-table",
        "a.csv",
        "--mesh",
        "a.ply",
        "--report",
        "a.json",
    ]);
    place.succeed(&["solve", "room.obj", "--patch-size", "250", "--image", "a.exr", "--size", "96x64"]);
    for name in ["a.png", "a.csv", "a.ply", "a.json"] {
        assert!(told.contains(&format!("wrote {name}")), "{told}");
    }
    assert!(place.files().iter().all(|name| !name.contains(".tmp")), "{:?}", place.files());

    let picture = image::open(place.path("a.png")).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (96, 64));
    let mean = picture.pixels().map(|p| f64::from(p.0[1])).sum::<f64>() / (96.0 * 64.0);
    assert!(mean > 30.0, "the picture is dark: {mean}");

    let exr = exr::prelude::read_first_rgba_layer_from_file(
        place.path("a.exr"),
        |size, _| vec![[0.0_f32; 3]; size.0 * size.1],
        |pixels, at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.0 + 96 * at.1] = [r, g, b],
    );
    let exr = exr.unwrap();
    let pixels = &exr.layer_data.channel_data.pixels;
    assert!(pixels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
    assert!(pixels.iter().filter(|p| p[2] > p[0]).count() > 96 * 64 / 2, "the lamp is bluish");

    // The table and the report describe one solution: E A and (1 - rho) H A add up to its power.
    let (table, report) = (place.text("a.csv"), place.text("a.json"));
    let areas = column(&table, "area_m2");
    assert_eq!(areas.len() as f64, json(&report, &["mesh", "patches"]));
    // Six walls of 4 m² and a lamp of 0.25 m² with its dark back.
    let area: f64 = areas.iter().sum();
    assert!((24.25 - 1e-9..24.5 + 1e-9).contains(&area), "{area} m²");
    let (mut emitted, mut absorbed) = (0.0, 0.0);
    for band in ["r", "g", "b"] {
        let of = |name: &str| column(&table, &format!("{name}_{band}"));
        let (exitance, irradiance, rho, radiosity) =
            (of("exitance"), of("irradiance"), of("reflectance"), of("radiosity"));
        for i in 0..areas.len() {
            emitted += exitance[i] * areas[i];
            absorbed += (1.0 - rho[i]) * irradiance[i] * areas[i];
            let b = exitance[i] + rho[i] * irradiance[i];
            assert!((radiosity[i] - b).abs() < 1e-5 * (1.0 + b), "patch {i}: {} and {b}", radiosity[i]);
        }
    }
    // 60 W/m² over the three bands from a quarter of a square metre; the room is closed.
    assert!((emitted - 15.0).abs() < 1e-3, "{emitted} W");
    assert!((absorbed / emitted - 1.0).abs() < 0.01, "{absorbed} of {emitted} W");
    for (name, value) in [("emitted", emitted), ("absorbed", absorbed)] {
        for group in ["power", "power_as_switched"] {
            let reported = json(&report, &[group, name]);
            assert!((reported - value).abs() < 2e-3 * value, "{group} {name}: {reported}, not {value}");
        }
    }
    assert!(json(&report, &["error_bound"]) <= 1e-4);
    assert!(json(&report, &["timings", "total"]) >= json(&report, &["timings", "rows"]));

    let ply = std::fs::read(place.path("a.ply")).unwrap();
    assert!(ply.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
}

/// Mean of the sRGB codes of a picture, 0 to 255.
fn brightness(picture: &image::RgbImage) -> f64 {
    let sum: f64 = picture.pixels().flat_map(|p| p.0).map(f64::from).sum();
    sum / f64::from(3 * picture.width() * picture.height())
}

#[test]
fn a_tour_is_written_frame_by_frame_and_does_not_flicker() {
    let place = Workplace::with_room(0.5);
    let said = place.fail(2, &["solve", "room.obj", "--patches", "200", "--tour", "frames"]);
    assert!(said.contains("two bookmarks"), "{said}");
    let second = "[[view]]\nname = \"Back\"\neye = [400, 1000, 400]\ntarget = [1000, 900, 2000]\nfov = 70\n";
    place.put("room.toml", &format!("{}\n{second}", place.text("room.toml")));
    let tour = ["solve", "room.obj", "--patches", "200", "--tour", "frames", "--fps", "5", "--size", "48x32"];
    let told = place.succeed(&tour);
    let mut names: Vec<String> = std::fs::read_dir(place.path("frames"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert!(told.contains(&format!("wrote {} frames", names.len())), "{told}");
    let expected: Vec<String> = (1..=names.len()).map(|k| format!("frame-{k:05}.png")).collect();
    assert_eq!(names, expected);
    assert!(names.len() > 10, "{told}");
    let frames: Vec<image::RgbImage> =
        names.iter().map(|name| image::open(place.path("frames").join(name)).unwrap().to_rgb8()).collect();
    assert!(frames.iter().all(|frame| frame.dimensions() == (48, 32)));
    let levels: Vec<f64> = frames.iter().map(brightness).collect();
    let jump = levels.windows(2).map(|l| (l[1] - l[0]).abs()).fold(0.0, f64::max);
    assert!(levels.iter().all(|&l| l > 40.0) && jump < 12.0, "{levels:?}");
    assert_ne!(frames[0], frames[frames.len() - 1], "the camera went somewhere");
    // A shorter tour into the same folder would seem to go on with frames of this one.
    let shorter = ["solve", "room.obj", "--patches", "200", "--tour", "frames", "--fps", "1"];
    assert!(place.fail(2, &shorter).contains("longer tour"));
}

#[test]
fn pictures_are_adapted_to_the_lamps_and_radiance_is_not() {
    let place = Workplace::with_room(0.5);
    let lamp = |rgb: &str| place.text("room.toml").replace("[10, 20, 30]", rgb);
    place.put("room.toml", &lamp("[30, 20, 8]"));
    place.succeed(&["solve", "room.obj", "--patches", "200", "--image", "a.png", "--size", "48x32"]);
    let picture = image::open(place.path("a.png")).unwrap().to_rgb8();
    let band = |b: usize| {
        let linear = |code: u8| (f64::from(code) / 255.0).powf(2.2);
        picture.pixels().map(|p| linear(p.0[b])).sum::<f64>()
    };
    // Grey walls, inter-reflected: the light has the colour of the lamp, a ratio of 3.75.
    let ratio = band(0) / band(2);
    assert!(ratio > 1.1 && ratio < 2.3, "red over blue: {ratio}");
}

#[test]
fn centres_of_the_table_can_be_gathered_at() {
    let place = Workplace::with_room(0.5);
    place.succeed(&["solve", "room.obj", "--patch-size", "250", "--patch-table", "a.csv"]);
    let table = place.text("a.csv");
    let names = ["centre_x_mm", "centre_y_mm", "centre_z_mm", "normal_x", "normal_y", "normal_z"];
    let columns = names.map(|name| column(&table, name));
    let lines: Vec<String> = (0..columns[0].len())
        .map(|i| columns.iter().map(|c| c[i].to_string()).collect::<Vec<_>>().join(","))
        .collect();
    place.put("p.csv", &lines.join("\n"));
    place.succeed(&[
        "solve",
        "room.obj",
        "--patch-size",
        "250",
        "--points",
        "p.csv",
        "--irradiance",
        "o.csv",
    ]);
    let (patches, points) = (column(&table, "irradiance_g"), column(&place.text("o.csv"), "irradiance_g"));
    let mean = patches.iter().sum::<f64>() / patches.len() as f64;
    let squares: f64 = patches.iter().zip(&points).map(|(a, b)| (a - b) * (a - b)).sum();
    let rms = (squares / patches.len() as f64).sqrt() / mean;
    assert!(rms < 0.03, "gathered at centres, the irradiance differs by {rms} RMS from the patches'");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let place = Workplace::with_room(0.5);
    for (threads, table) in [("1", "one.csv"), ("3", "three.csv")] {
        place.succeed(&[
            "solve",
            "room.obj",
            "--patches",
            "300",
            "--threads",
            threads,
            "--patch-table",
            table,
        ]);
    }
    assert_eq!(place.text("one.csv"), place.text("three.csv"));
}

#[test]
fn without_a_display_a_picture_is_written_instead() {
    let place = Workplace::with_room(0.5);
    let output = place.run(&["room.obj", "--patches", "200"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert_eq!(said.lines().filter(|line| line.contains("no window can be opened")).count(), 1, "{said}");
    let picture = image::open(place.path("lumenwalk-room.png")).unwrap().to_rgb8();
    let bright = picture.pixels().filter(|p| p.0[1] > 40).count();
    assert!(bright > (picture.width() * picture.height() / 4) as usize, "{bright} bright pixels");
}

#[test]
fn the_plan_and_the_check_tell_about_the_scene() {
    let place = Workplace::with_room(0.5);
    let plan = place.succeed(&["plan", "room.obj"]);
    for effect in ["visibility", "colour-bands", "two-sided", "textures", "smooth-surfaces"] {
        assert!(plan.contains(effect), "{plan}");
    }
    // What it costs, by default and by error: each error takes more than the one before.
    let patches = |row: &str| -> f64 {
        let line = plan.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {plan}"));
        let count = line[row.len()..].split_whitespace().next().expect("patches");
        count.replace(',', "").parse().expect("a number")
    };
    let [coarse, middle, fine] = ["--error 10%", "--error 3%", "--error 1%"].map(patches);
    assert!(patches("as asked for") > 0.0 && coarse <= middle && middle < fine, "{plan}");
    let forced = place.succeed(&["plan", "room.obj", "--with", "textures", "--without", "visibility"]);
    assert!(forced.contains("on by choice") && forced.contains("off by choice"), "{forced}");
    let check = place.succeed(&["check", "room.obj"]);
    assert!(check.contains("Desk lamp") && check.contains("paint"), "{check}");
}

/// An output that can be opened and never written: a link to the full device.
#[cfg(target_os = "linux")]
fn put_full(place: &Workplace, name: &str) {
    std::os::unix::fs::symlink("/dev/full", place.path(name)).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_that_fails_does_not_take_the_others_with_it() {
    let place = Workplace::with_room(0.5);
    place.put("p.csv", "300,0,400,0,1,0\n");
    let outputs =
        [("--image", "a.png"), ("--mesh", "a.ply"), ("--patch-table", "a.csv"), ("--irradiance", "o.csv")];
    for (_, full) in outputs {
        put_full(&place, full);
        let mut arguments = vec!["solve", "room.obj", "--patches", "100", "--size", "64x48"];
        arguments.extend(["--points", "p.csv", "--report", "a.json"]);
        arguments.extend(outputs.iter().flat_map(|&(option, name)| [option, name]));
        let output = place.run(&arguments);
        let told = String::from_utf8_lossy(&output.stdout);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{complaint}");
        assert!(complaint.contains(full) && complaint.contains("disk is full"), "{full}: {complaint}");
        assert!(!told.contains(&format!("wrote {full}")), "{told}");
        std::fs::remove_file(place.path(full)).unwrap();
        for name in outputs.iter().map(|o| o.1).filter(|&name| name != full).chain(["a.json"]) {
            assert!(told.contains(&format!("wrote {name}")), "{full} fails, and {name} is lost: {told}");
            std::fs::remove_file(place.path(name)).unwrap();
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn every_output_that_fails_is_told() {
    let place = Workplace::with_room(0.5);
    ["a.png", "a.csv", "a.json"].iter().for_each(|name| put_full(&place, name));
    let output = place.run(&[
        "solve",
        "room.obj",
        "--patches",
        "100",
        "--size",
        "64x48",
        "--image",
        "a.png",
        "--patch-table",
        "a.csv",
        "--report",
        "a.json",
        "--mesh",
        "a.ply",
    ]);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(["a.png", "a.csv", "a.json"].iter().all(|name| complaint.contains(name)), "{complaint}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("wrote a.ply"));
}

#[test]
fn temporary_files_of_killed_runs_are_cleared_and_those_of_others_stay() {
    let place = Workplace::with_room(0.5);
    place.put(".a.csv.lumenwalk-4000000-0.tmp", "half of a table");
    place.put(".old.png.lumenwalk-4000000-3.tmp", "half of a picture");
    place.put(".a.csv.tmp", "of another program");
    place.put(".b.csv.lumenwalk-4000000-1.tmp", "of a run that is still writing");
    let held = std::fs::File::open(place.path(".b.csv.lumenwalk-4000000-1.tmp")).unwrap();
    held.lock().unwrap();
    place.succeed(&["solve", "room.obj", "--patches", "100", "--patch-table", "a.csv"]);
    let hidden: Vec<String> = place.files().into_iter().filter(|name| name.starts_with('.')).collect();
    assert_eq!(hidden, [".a.csv.tmp", ".b.csv.lumenwalk-4000000-1.tmp"]);
}

#[test]
fn points_are_told_with_their_estimated_error() {
    let place = Workplace::with_room(0.6);
    place.put("p.csv", "300,0,400,0,1,0\n0,900,1000,1,0,0\n1000,0,1000,0,1,0\n");
    let told = place.succeed(&[
        "solve",
        "room.obj",
        "--patches",
        "200",
        "--points",
        "p.csv",
        "--irradiance",
        "o.csv",
        "--report",
        "o.json",
    ]);
    let (lux, error) = (column(&place.text("o.csv"), "lux"), column(&place.text("o.csv"), "lux_error"));
    let relative: Vec<f64> = lux.iter().zip(&error).map(|(lux, error)| error / lux).collect();
    assert!(relative.iter().all(|e| (1e-5..0.1).contains(e)), "{relative:?}");
    let line = told.lines().find(|line| line.starts_with("illuminance at 3 points: estimated error median"));
    assert!(line.is_some_and(|line| line.contains("largest") && line.contains("(point ")), "{told}");
    let report = place.text("o.json");
    assert_eq!(json(&report, &["points", "count"]), 3.0);
    let largest = relative.iter().copied().fold(0.0, f64::max);
    assert!((json(&report, &["points", "largest_error_percent"]) / 100.0 - largest).abs() < 1e-6);
}

#[test]
fn a_number_of_patches_that_cannot_be_kept_is_explained() {
    let place = Workplace::with_room(0.5);
    let told = place.succeed(&["plan", "builtin:gallery", "--patches", "100"]);
    assert!(told.contains("100 patches were asked for;"), "{told}");
    assert!(told.contains("sides of small faces need one each"), "{told}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_the_address_space_is_a_refusal_and_no_crash() {
    let place = Workplace::with_room(0.5);
    for kilobytes in [700_000, 1_000_000] {
        let limited = format!("ulimit -v {kilobytes}; exec \"$0\" solve builtin:house --threads 2");
        let program = place.command(&[]).get_program().to_owned();
        let mut shell = std::process::Command::new("sh");
        let output = shell.arg("-c").arg(limited).arg(program).current_dir(place.path(".")).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("patches need about") && said.contains("patches would fit"), "{said}");
    }
    // However little there is: the system's refusal of memory and of threads is told as well.
    for kilobytes in [60_000, 110_000, 200_000, 300_000] {
        for what in ["solve", "check"] {
            let limited = format!("ulimit -v {kilobytes}; exec \"$0\" {what} builtin:house");
            let program = place.command(&[]).get_program().to_owned();
            let output =
                std::process::Command::new("sh").arg("-c").arg(limited).arg(program).output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr);
            let is_done = what == "check" && output.status.code() == Some(0);
            assert!(is_done || output.status.code() == Some(1), "{kilobytes}: {:?} {said}", output.status);
            assert!(is_done || said.contains("ulimit") || said.contains("would fit"), "{kilobytes}: {said}");
        }
    }
}
