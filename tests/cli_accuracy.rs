//! Goals of `solve` and the command `accuracy`, by the real program.

mod cli_support;

use cli_support::Workplace;
use lumenwalk::study::{Entry, entries, table};
use serde_json::Value;

fn report(place: &Workplace, name: &str) -> Value {
    serde_json::from_str(&place.text(name)).expect("JSON")
}

#[test]
fn an_error_is_reached_and_the_report_holds_the_budget() {
    let place = Workplace::with_room(0.5);
    let told = place.succeed(&["solve", "room.obj", "--error", "12%", "--report", "r.json"]);
    assert!(told.contains("as asked for"), "{told}");
    let report = report(&place, "r.json");
    let accuracy = &report["accuracy"];
    let shown = accuracy["as_shown"]["percent"].as_f64().unwrap();
    assert!(shown > 0.0 && shown <= 12.0, "{accuracy}");
    assert_eq!(accuracy["goal"]["met"], Value::Bool(true));
    for part in ["form_factors", "patches", "solver", "patch_averages"] {
        let [low, error, high] = ["low", "percent", "high"].map(|k| accuracy[part][k].as_f64().unwrap());
        assert!(0.0 <= low && low <= error && error <= high, "{part}: {accuracy}");
    }
    assert!(!accuracy["goal"]["attempts"].as_array().unwrap().is_empty());
    // What it cost, by stage and by effect.
    for stage in ["mesh", "rows", "balance", "sweeps", "display"] {
        assert!(report["timings"][stage].as_f64().unwrap() > 0.0, "{stage}: {}", report["timings"]);
    }
    let is_on = |e: &&Value| e["state"].as_str().unwrap().starts_with("on");
    let effects: Vec<&Value> = report["effects"].as_array().unwrap().iter().filter(is_on).collect();
    assert!(!effects.is_empty());
    for effect in effects {
        assert!(effect["measured_seconds"].as_f64().is_some_and(|s| s >= 0.0), "{effect}");
    }
}

#[test]
fn an_error_asked_for_with_points_alone_is_that_of_the_points() {
    let place = Workplace::with_room(0.5);
    place.put("p.csv", "300,0,400,0,1,0\n0,900,1000,1,0,0\n1000,0,1000,0,1,0\n");
    let points = ["solve", "room.obj", "--points", "p.csv", "--irradiance", "o.csv"];
    let told = place.succeed(&[&points[..], &["--error", "2%", "--report", "p.json"]].concat());
    assert!(told.contains("(RMS) at the 3 points, as asked for"), "{told}");
    place.succeed(&["solve", "room.obj", "--error", "2%", "--report", "all.json"]);
    let patches = |name: &str| report(&place, name)["mesh"]["patches"].as_u64().unwrap();
    assert!(patches("p.json") <= patches("all.json"), "points are gathered anew, and need no more patches");
    assert!(report(&place, "p.json")["points"]["median_error_percent"].as_f64().unwrap() < 2.0);
    // With a picture the picture counts.
    let picture = ["--image", "p.png", "--size", "64x40", "--error", "20%"];
    let told = place.succeed(&[&points[..], &picture].concat());
    assert!(told.contains("as asked for") && !told.contains("at the 3 points,"), "{told}");
}

#[test]
fn a_goal_out_of_reach_is_told_with_how_far_it_got() {
    let place = Workplace::with_room(0.5);
    let told = place.succeed(&["solve", "room.obj", "--budget", "10ms", "--report", "r.json"]);
    assert!(told.contains("more than asked for") || told.contains("not even the coarsest"), "{told}");
    let report = report(&place, "r.json");
    let goal = if report["accuracy"].is_null() { &Value::Null } else { &report["accuracy"]["goal"]["met"] };
    assert_ne!(*goal, Value::Bool(true));
}

#[test]
fn a_time_gives_a_picture_even_where_it_is_short() {
    let place = Workplace::with_room(0.5);
    let arguments = ["solve", "room.obj", "--report", "r.json", "--image", "p.png", "--size", "64x40"];
    for time in ["3s", "10ms"] {
        place.succeed(&[&arguments[..], &["--budget", time]].concat());
        let report = report(&place, "r.json");
        assert!(report["mesh"]["patches"].as_u64().unwrap() > 0);
        let picture = image::open(place.path("p.png")).unwrap().to_rgb8();
        assert!(picture.pixels().any(|p| p.0 != [0; 3]), "{time}: a black picture");
    }
}

#[test]
fn goals_choose_by_themselves_and_are_checked() {
    let place = Workplace::with_room(0.5);
    let solve = |more: &[&str]| place.fail(2, &[&["solve", "room.obj"], more].concat());
    let first = |arguments: &[&str]| {
        let output = place.run(&[&["solve", "room.obj"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(first(&["--error", "1%", "--patches", "100"]).contains("cannot be used with"));
    assert!(first(&["--error", "1%", "--budget", "5s"]).contains("cannot be used with"));
    assert!(first(&["--error", "200%"]).contains("between"));
    assert!(first(&["--budget", "soon"]).contains("5s"));
    assert!(
        solve(&["--error", "5%", "--with", "visibility", "--without", "visibility"]).contains("visibility")
    );
}

#[test]
fn a_sweep_writes_table_and_charts_and_goes_on_where_it_ended() {
    let place = Workplace::with_room(0.4);
    let sweep =
        |time: &str| place.succeed(&["accuracy", "room.obj", "--out", "study", "--max-seconds", time]);
    let told = sweep("3s");
    assert!(told.contains("method") && told.contains("accuracy.svg"), "{told}");
    let first = place.text("study/accuracy.csv");
    assert!(first.lines().count() >= 2, "{first}");
    sweep("3s");
    let second = place.text("study/accuracy.csv");
    for line in first.lines() {
        assert!(second.contains(line), "measured again: {line}");
    }
    assert!(second.len() >= first.len());
    assert!(place.text("study/accuracy.svg").starts_with("<svg"));
    let chart = image::open(place.path("study/accuracy.png")).unwrap();
    assert!(chart.width() > 1000);
    // Another scene in the same folder leaves what is there alone.
    place.put("room.mtl", "newmtl paint\nKd .7 .7 .7\nnewmtl glow\nKd 0 0 0\nKe 1 1 1\n");
    sweep("2s");
    let third = place.text("study/accuracy.csv");
    assert!(first.lines().all(|line| third.contains(line)) && third.len() > second.len(), "{third}");
}

#[test]
fn a_sweep_goes_on_from_a_table_in_any_order() {
    let place = Workplace::with_room(0.4);
    let sweep = |time: &str| {
        let told = place.succeed(&["accuracy", "room.obj", "--out", "study", "--max-seconds", time]);
        (told, table::parse(&place.text("study/accuracy.csv")))
    };
    let (_, begun) = sweep("3s");
    // As if all points but three had been measured, the last ones first.
    let all = entries(begun[0].entry.patches);
    let missing = [all[0], all[9], all[20]];
    let measured = all.iter().rev().filter(|entry| !missing.contains(entry));
    let known: Vec<table::Row> = measured.map(|&entry| table::Row { entry, ..begun[0].clone() }).collect();
    table::write(&place.path("study/accuracy.csv"), &known).unwrap();
    let (told, rows) = sweep("5min");
    assert!(!told.contains("left out"), "{told}");
    assert_eq!(rows[..known.len()], known, "what is known stays as it is");
    let new: Vec<Entry> = rows[known.len()..].iter().map(|row| row.entry).collect();
    assert_eq!(new, missing, "what is missing is measured, once and in its order");
}
