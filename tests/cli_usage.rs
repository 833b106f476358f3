//! The command line as a user meets it: help, exit codes, and what it says to bad input.

mod cli_support;

use cli_support::Workplace;
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::Stdio;

#[test]
fn help_names_every_command_and_option() {
    let place = Workplace::with_room(0.5);
    let help = place.succeed(&["--help"]);
    for word in ["SCENE", "solve", "scenes", "check", "plan", "sky", "validate", "Exit codes"] {
        assert!(help.contains(word), "{word} is missing:\n{help}");
    }
    let options = [
        "--patch-size",
        "--patches",
        "--method",
        "--resolution",
        "--tolerance",
        "--on",
        "--off",
        "--dim",
        "--view",
        "--eye",
        "--target",
        "--fov",
        "--size",
        "--image",
        "--tour",
        "--fps",
        "--patch-table",
        "--mesh",
        "--points",
        "--irradiance",
        "--report",
        "--threads",
        "--with",
        "--without",
        "--unit",
        "--up",
    ];
    let help = place.succeed(&["solve", "--help"]);
    for option in options {
        assert!(help.contains(option), "{option} is missing:\n{help}");
    }
    assert!(place.succeed(&["scenes", "--help"]).contains("--export"));
    assert!(place.succeed(&["plan", "--help"]).contains("--without"));
    assert!(place.succeed(&["check", "--help"]).contains("FILE"));
    for command in [&["check"][..], &["plan"], &["accuracy"], &[]] {
        let help = place.succeed(&[command, &["--help"]].concat());
        assert!(help.contains("--unit") && help.contains("--up"), "{command:?}:\n{help}");
    }
    assert!(place.succeed(&["--version"]).contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn wrong_usage_ends_with_2() {
    let place = Workplace::with_room(0.5);
    let wrong: &[&[&str]] = &[
        &["solve"],
        &["solve", "room.obj", "--nonsense"],
        &["solve", "room.obj", "--method", "magic"],
        &["solve", "room.obj", "--patch-size", "-1"],
        &["solve", "room.obj", "--patch-size", "1", "--patches", "9"],
        &["solve", "room.obj", "--tolerance", "0"],
        &["solve", "room.obj", "--threads", "0"],
        &["solve", "room.obj", "--dim", "Desk lamp"],
        &["solve", "room.obj", "--dim", "Desk lamp=2"],
        &["solve", "room.obj", "--points", "p.csv"],
        &["solve", "room.obj", "--irradiance", "p.csv"],
        &["solve", "room.obj", "--size", "640x400"],
        &["solve", "room.obj", "--fps", "30"],
        &["solve", "room.obj", "--tour", "t", "--fps", "0"],
        &["solve", "room.obj", "--image", "a.png", "--size", "640"],
        &["solve", "room.obj", "--image", "a.png", "--eye", "1,2,3"],
        &["plan", "room.obj", "--with", "magic"],
        &["validate", "--case", "no such case"],
    ];
    for arguments in wrong {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn validate_prints_cases_in_two_forms() {
    let place = Workplace::with_room(0.5);
    let plain =
        place.succeed(&["validate", "--case", "Parallel 2 x 1", "--case", "1 mm lamp in a 100 m hall"]);
    for words in ["VIEW FACTORS", "Hottel 1931", "0.285875385", "LAMPS", "4 cases by", " 0 failed"] {
        assert!(plain.contains(words), "{words} is missing:\n{plain}");
    }
    let table = place.succeed(&["validate", "--markdown", "--case", "parallel 2 x 1"]);
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with('|')).collect();
    // A header, its line, and one row a way.
    assert_eq!(rows.len(), 7, "{table}");
    assert!(rows.iter().all(|row| row.matches('|').count() == 9), "{table}");
    assert!(rows[2..].iter().all(|row| row.ends_with("| ok |")), "{table}");
    let lines = rows.iter().find(|row| row.contains("| lines |")).unwrap();
    let computed: f64 = lines.split('|').nth(5).unwrap().trim().parse().unwrap();
    assert!((computed - 0.285_875_384_850_715).abs() < 1e-4, "{lines}");
}

#[test]
fn scenes_that_are_not_there_or_broken_are_told_in_one_sentence() {
    let place = Workplace::with_room(0.5);
    place.put("empty.obj", "");
    place.put("broken.obj", "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n");
    for command in ["solve", "check", "plan"] {
        assert!(place.fail(2, &[command, "none.obj"]).contains("none.obj"));
        assert!(place.fail(2, &[command, "builtin:none"]).contains("hemicube"));
        assert!(place.fail(2, &[command, "empty.obj"]).contains("empty"));
        assert!(place.fail(2, &[command, "broken.obj"]).contains("broken.obj"));
        place.fail(2, &[command, "."]);
    }
    assert!(place.fail(2, &["none.obj"]).contains("none.obj"));
    assert!(place.fail(2, &["builtin:none"]).contains("hemicube"));
}

#[test]
fn unknown_names_are_answered_with_near_ones() {
    let place = Workplace::with_room(0.5);
    for option in ["--on", "--off"] {
        let said = place.fail(2, &["solve", "room.obj", option, "Dask lmp"]);
        assert!(said.contains("'Dask lmp'") && said.contains("'Desk lamp'"), "{said}");
    }
    assert!(place.fail(2, &["solve", "room.obj", "--dim", "Dsk=0.5"]).contains("'Desk lamp'"));
    let said = place.fail(2, &["solve", "room.obj", "--image", "a.png", "--view", "Entry"]);
    assert!(said.contains("'Entry'") && said.contains("'Entrance'"), "{said}");
    let said = place.fail(2, &["solve", "room.obj", "--on", "Desk lamp", "--off", "desk lamp"]);
    assert!(said.contains("--on and by --off"), "{said}");
    let said = place.fail(2, &["plan", "room.obj", "--with", "visibility", "--without", "visibility"]);
    assert!(said.contains("visibility"), "{said}");
}

#[test]
fn bad_points_are_named_with_their_line() {
    let place = Workplace::with_room(0.5);
    place.put("bad.csv", "x,y,z,nx,ny,nz\n0,0,0,0,1,0\n0,0,0,0,one,0\n");
    place.put("none.csv", "# nothing here\n");
    let solve = |points| place.fail(2, &["solve", "room.obj", "--points", points, "--irradiance", "o.csv"]);
    assert!(solve("bad.csv").contains("bad.csv:3"));
    assert!(solve("none.csv").contains("no points"));
    assert!(solve("missing.csv").contains("missing.csv"));
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_solve() {
    let place = Workplace::with_room(0.5);
    for option in ["--patch-table", "--mesh", "--report", "--image"] {
        let said = place.fail(1, &["solve", "room.obj", option, "no/such/folder/a.png"]);
        assert!(said.contains("a.png") && said.contains("folder does not exist"), "{said}");
        place.fail(1, &["solve", "room.obj", option, "room.obj/a.png"]);
    }
    std::fs::create_dir(place.path("folder.csv")).unwrap();
    assert!(place.fail(1, &["solve", "room.obj", "--patch-table", "folder.csv"]).contains("folder"));
    assert!(place.fail(2, &["solve", "room.obj", "--image", "a.tiff"]).contains(".png"));
    let said = place.fail(2, &["solve", "room.obj", "--report", "a.x", "--patch-table", "a.x"]);
    assert!(said.contains("two outputs"), "{said}");
}

#[test]
fn what_is_read_is_not_overwritten() {
    let place = Workplace::with_room(0.5);
    std::fs::write(place.path("points.csv"), "x,y,z,nx,ny,nz\n1,1,1,0,1,0\n").unwrap();
    std::fs::write(place.path("other.mtl"), "newmtl a\n").unwrap();
    let before = place.files();
    let outputs = [
        ["--mesh", "room.obj"],
        ["--patch-table", "room.mtl"],
        ["--report", "./room.obj"],
        ["--mesh", "other.mtl"],
        ["--patch-table", "points.csv"],
    ];
    for [option, path] in outputs {
        let arguments =
            ["solve", "room.obj", "--points", "points.csv", "--irradiance", "out.csv", option, path];
        let said = place.fail(2, &arguments);
        assert!(said.contains("is an input; choose another name"), "{option} {path}: {said}");
    }
    let contents = |name: &str| std::fs::read_to_string(place.path(name)).unwrap();
    assert_eq!(place.files(), before);
    assert!(contents("room.obj").contains("\nf ") && contents("other.mtl") == "newmtl a\n");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let place = Workplace::with_room(0.5);
    for arguments in [&["scenes"][..], &["check", "room.obj"], &["plan", "room.obj"], &["--help"]] {
        let mut command = place.command(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut complaint = String::new();
        child.stderr.take().unwrap().read_to_string(&mut complaint).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{arguments:?}: {complaint}");
        // What is computed is followed by its progress.
        let is_told = complaint.is_empty() || arguments[0] == "plan" && !complaint.contains("lumenwalk:");
        assert!(is_told, "{arguments:?}: {complaint}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_a_solve_and_leaves_nothing() {
    use std::os::unix::process::ExitStatusExt as _;
    let place = Workplace::with_room(0.5);
    let before = place.files();
    let mut child = place
        .command(&["solve", "builtin:house", "--patches", "60000", "--image", "a.png", "--report", "a.json"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The first word of progress shows that the solve has begun.
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    lines.read_line(&mut line).unwrap();
    let pid = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().signal(), Some(2), "after {line:?}");
    assert_eq!(place.files(), before);
}

#[test]
fn embedded_scenes_are_listed_and_written_out_without_overwriting_edits() {
    let place = Workplace::with_room(0.5);
    let list = place.succeed(&["scenes"]);
    let names = ["hemicube", "cornell", "house", "house-by-day", "gallery"];
    let told = place.succeed(&["scenes", "--export", "out"]);
    for name in names {
        assert!(list.contains(&format!("builtin:{name} ")), "{list}");
        for end in ["obj", "mtl", "toml"] {
            assert!(told.lines().any(|line| line == format!("out/{name}.{end}")), "{told}");
        }
    }
    assert_eq!(told.lines().count(), 3 * names.len(), "{told}");
    assert!(place.succeed(&["check", "out/hemicube.obj"]).contains("hemicube"));
    place.succeed(&["scenes", "--export", "out"]);
    place.put("out/house.toml", "unit = \"m\"\n");
    let said = place.fail(1, &["scenes", "--export", "out"]);
    assert!(said.contains("house.toml") && said.contains("--force"), "{said}");
    assert_eq!(place.text("out/house.toml"), "unit = \"m\"\n");
    place.succeed(&["scenes", "--export", "out", "--force"]);
    assert!(place.text("out/house.toml").contains("[[view]]"));
}

#[test]
fn a_repaired_copy_is_told_and_the_model_is_refused_as_its_place() {
    let place = Workplace::with_room(0.5);
    let before = place.text("room.obj");
    // A wall twice.
    place.put("room.obj", &format!("{before}o wall_east\nusemtl paint\nf 2 3 7 6\n"));
    let model = place.text("room.obj");
    let told = place.succeed(&["check", "room.obj", "--repair", "copy.obj"]);
    assert!(told.contains("there twice were dropped (1, in 'wall_east 2', line"), "{told}");
    assert!(told.contains("repaired copy: copy.obj"), "{told}");
    assert_eq!((place.text("room.obj"), place.text("copy.toml")), (model.clone(), place.text("room.toml")));
    let again = place.succeed(&["check", "copy.obj", "--repair", "third.obj"]);
    assert!(!again.contains("there twice") && again.contains("nothing had to be mended"), "{again}");
    let said = place.fail(2, &["check", "room.obj", "--repair", "./room.obj"]);
    assert!(said.contains("a file of the model itself"), "{said}");
    let said = place.fail(1, &["check", "room.obj", "--repair", "nowhere/copy.obj"]);
    assert!(said.contains("folder does not exist"), "{said}");
    assert_eq!(place.text("room.obj"), model);
}

#[test]
fn unit_and_axis_are_chosen_on_the_command_line_over_the_sidecar() {
    let place = Workplace::with_room(0.5);
    let told = place.succeed(&["check", "room.obj"]);
    assert!(told.contains("2.000 x 2.000 x 2.000 m, y up"), "{told}");
    let told = place.succeed(&["check", "room.obj", "--unit", "cm", "--up", "z"]);
    assert!(told.contains("20.000 x 20.000 x 20.000 m, z up"), "{told}");
    assert!(place.text("room.toml").starts_with("unit = \"mm\""), "the sidecar stays as it is");
    assert!(place.fail(2, &["check", "builtin:cornell", "--up", "z"]).contains("embedded scenes"));
    for wrong in [["--unit", "ell"], ["--up", "x"]] {
        assert_eq!(place.run(&["check", "room.obj", wrong[0], wrong[1]]).status.code(), Some(2));
    }
}

#[test]
fn a_model_on_its_side_is_noticed_wherever_it_is_read() {
    let place = Workplace::with_room(0.5);
    let turned = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let [x, y, z] = [0, 1, 2].map(|k| rest.split(' ').nth(k).unwrap());
            format!("v {x} -{z} {y}\n")
        }
        None => format!("{line}\n"),
    };
    place.put("side.obj", &place.text("room.obj").lines().map(turned).collect::<String>());
    let stderr = |arguments: &[&str]| String::from_utf8(place.run(arguments).stderr).unwrap();
    let solve = ["solve", "side.obj", "--patches", "50", "--resolution", "8"];
    for command in [&solve[..], &["plan", "side.obj"]] {
        let told = stderr(command);
        for words in ["note: z was taken for up", "--up y", "rooms are 2000 m high", "--unit mm"] {
            assert_eq!(told.matches(words).count(), 1, "{words}: {told}");
        }
    }
    let told = place.run(&["check", "side.obj"]).stdout;
    assert!(String::from_utf8(told).unwrap().contains("z was taken for up"));
    let told = stderr(&[&solve[..], &["--up", "z", "--unit", "mm"]].concat());
    assert!(!told.contains("warning"), "{told}");
}
