//! The sky over the model: asked for, moved, taken back.

use crate::files::drop_on;
use crate::support::{
    Counting, click, has_adapter, press, says, solution_of, solved, solved_by_day, under_sky, wait_until,
    window, write_model,
};
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::scene::{DaylightChoice, Scene, illuminance};
use lumenwalk::ui::App;
use std::path::Path;

#[test]
fn a_sky_is_added_moved_and_taken_back_and_lamps_go_with_it() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    let lamps = harness.state().lighting().lamps.len();
    click(&mut harness, "Add daylight");
    harness.run_steps(3);
    assert_eq!(worker.requests(), ["daylight 12:00"]);
    assert_eq!(harness.state().lighting().lamps.len(), lamps + 2, "sky and sun are lamps");
    let noon = harness.state().lighting().clone();
    let choice = harness.state().edits().daylight.clone().expect("a sky");
    assert_eq!(choice.time.as_deref(), Some("12:00"));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(harness.state().edits().daylight, None::<DaylightChoice>);
    assert_eq!(harness.state().lighting().lamps.len(), lamps);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.run_steps(3);
    assert_eq!(harness.state().lighting(), &noon);
    assert_eq!(worker.requests(), ["daylight 12:00", "daylight ", "daylight 12:00"]);
    click(&mut harness, "Play the day");
    harness.run_steps(60);
    click(&mut harness, "Stop the day");
    let played = worker.requests().len();
    assert!(played > 5, "{:?}", worker.requests());
    let later = harness.state().edits().daylight.clone().expect("a sky").time;
    assert!(later.is_some() && later.as_deref() != Some("12:00"));
    // All of it is one step.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(harness.state().lighting(), &noon);
    press(&mut harness, Key::Num0);
    assert!(harness.state().lighting().lamps.iter().all(|lamp| !lamp.on), "sky and sun switch as lamps do");
}

/// Shows daylight factors and waits until they are there.
fn show_factors(harness: &mut Harness<'_, App>) {
    click(harness, "Show");
    click(harness, "Daylight factor");
    wait_until(harness, "daylight factors", |harness| !harness.state().shown_values().is_empty());
}

#[test]
fn daylight_factors_are_those_of_the_overcast_sky_whatever_the_sky_and_the_lamps() {
    let snapshot = solved_by_day();
    let worker = Counting::showing(snapshot.clone());
    let mut harness = window(&worker, false);
    show_factors(&mut harness);
    let shown = harness.state().shown_values().to_vec();
    // Of the same model read under the overcast sky, by its illuminances with the sky alone.
    let overcast = under_sky("[daylight]\nsun = [35, 150]\nsky = \"overcast\"\nlux = [0, 8000]\n");
    let solution = overcast.solved().expect("whole");
    let mut lighting = solution.scene.lighting();
    lighting.lamps[..2].iter_mut().for_each(|lamp| lamp.on = false);
    let expected: Vec<f64> =
        solution.light(&lighting).irradiance.iter().map(|h| illuminance(h.map(f64::from)) / 80.0).collect();
    assert_eq!(shown.len(), expected.len());
    let areas: Vec<f64> = solution.mesh.patches.iter().map(|patch| patch.area).collect();
    let sum = |value: &dyn Fn(usize) -> f64| (0..areas.len()).map(|k| areas[k] * value(k)).sum::<f64>();
    let off = sum(&|k| (f64::from(shown[k]) - expected[k]).powi(2)) / sum(&|k| expected[k].powi(2));
    assert!(off.sqrt() < 0.02, "{}", off.sqrt());
    assert!(sum(&|k| expected[k]) / sum(&|_| 1.0) > 0.5, "a room by day");
    // Lamps leave them alone, and nothing is asked of the solver.
    press(&mut harness, Key::Num0);
    harness.run_steps(3);
    assert_eq!(harness.state().shown_values(), shown);
    assert_eq!(worker.requests(), Vec::<String>::new());
    // A place tells its own beside lux.
    let view = harness.get_by_label("Scene view").rect();
    crate::support::click_at(&mut harness, view.center(), Modifiers::COMMAND);
    let patch = harness.state().inspected().expect("looked into") as usize;
    let digits = (2 - shown[patch].log10().floor() as i32).max(0) as usize;
    assert!(says(&harness, "Daylight factor") && says(&harness, &format!("{:.digits$} %", shown[patch])));
}

#[test]
fn daylight_factors_of_a_scene_without_a_sky_wait_for_one() {
    let mut harness = window(&Counting::showing(solved()), false);
    click(&mut harness, "Show");
    click(&mut harness, "Daylight factor");
    harness.run_steps(10);
    assert!(harness.state().shown_values().is_empty());
}

#[test]
fn daylight_factors_in_false_colours() {
    if !has_adapter("daylight_factors_in_false_colours") {
        return;
    }
    let mut harness = window(&Counting::showing(solved_by_day()), true);
    show_factors(&mut harness);
    let view = harness.get_by_label("Scene view").rect();
    harness.hover_at(view.center() + egui::vec2(0.0, 120.0));
    harness.run_steps(30);
    let options = egui_kittest::SnapshotOptions::new().threshold(4.0).max_failed_pixels(12_800);
    harness.snapshot_options("window_daylight_factor", &options);
}

/// A weather file with two days of the same hours: the night is dark, and noon brighter in June.
fn write_weather(path: &Path) {
    let mut text = "LOCATION,Quito,-,ECU,Made,840710,-0.15,-78.48,-5.0,2812\n\
                    DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n"
        .to_owned();
    for (month, light) in [(3, 400), (6, 700)] {
        for hour in 1..=24 {
            let lit = if (7..=18).contains(&hour) { light } else { 0 };
            let diffuse = if lit > 0 { 10 * hour } else { 0 };
            text +=
                &format!("1999,{month},21,{hour},60,?,20,9.5,50,72000,0,1415,300,{lit},{lit},{diffuse}\n");
        }
    }
    std::fs::write(path, text).expect("written");
}

#[test]
fn a_weather_file_gives_place_and_sky_of_the_hour_and_is_undone() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    write_weather(&folder.path().join("quito.epw"));
    let worker = Counting::showing(solution_of(&model));
    let mut harness = window(&worker, false);
    let path = folder.path().join("quito.epw");
    drop_on(&mut harness, &[path.to_str().expect("plain")]);
    harness.run_steps(3);
    let choice = harness.state().edits().daylight.clone().expect("a sky");
    let expected = DaylightChoice {
        latitude: Some(-0.15),
        longitude: Some(-78.48),
        zone: Some(-5.0),
        date: Some("2026-06-21".to_owned()),
        time: Some("12:00".to_owned()),
        weather: Some("quito.epw".to_owned()),
        ..DaylightChoice::default()
    };
    assert_eq!(choice.without_lamps(), expected);
    // Its sky is that of the hour from 12 to 13 o'clock, Perez of 700 and 130 W/m²; another hour takes that of its row.
    let scene =
        harness.state().edits().daylight.as_ref().map(|choice| sky_of(&model, choice)).expect("a sky");
    let noon = scene.outdoors.clone().expect("a sky").daylight;
    assert!(noon.sky().description().contains("Perez"), "{}", noon.sky().description());
    assert!(says(&harness, "quito.epw"));
    let later = DaylightChoice { time: Some("15:00".to_owned()), ..choice.clone() };
    let afternoon = sky_of(&model, &later).outdoors.expect("a sky").daylight;
    // 160 over 130 W/m² of diffuse light.
    let ratio = afternoon.sky().horizontal() / noon.sky().horizontal();
    assert!((1.1..1.4).contains(&ratio), "{ratio}");
    // Kept in the sidecar by its name, and taken back in one step.
    let undone = |harness: &mut Harness<'_, App>| {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
    };
    let saved = sky_of(&model, &choice);
    let lighting = saved.lighting();
    lumenwalk::scene::write_sidecar(&model.with_extension("toml"), &saved, &lighting, &[]).expect("written");
    let text = std::fs::read_to_string(model.with_extension("toml")).expect("a sidecar");
    assert!(text.contains("weather = \"quito.epw\""), "{text}");
    undone(&mut harness);
    assert_eq!(harness.state().edits().daylight, None);
    assert_eq!(worker.requests(), ["daylight 12:00", "daylight "]);
}

/// The small scene under this sky.
fn sky_of(model: &Path, choice: &DaylightChoice) -> Scene {
    let source = lumenwalk::scene::SceneSource::File(model.to_owned());
    let scene = lumenwalk::scene::load(&source).expect("a scene");
    scene.with_daylight(Some(choice)).expect("a sky")
}

#[test]
fn a_weather_file_that_cannot_be_used_is_told_in_a_sentence_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    let bad = folder.path().join("bad.epw");
    std::fs::write(&bad, "hello").expect("written");
    let missing = folder.path().join("missing.epw");
    let winter = folder.path().join("march.epw");
    write_weather(&winter);
    let text = std::fs::read_to_string(&winter).expect("written");
    std::fs::write(&winter, text.lines().take(26).collect::<Vec<_>>().join("\n")).expect("written");
    let worker = Counting::showing(solution_of(&model));
    let mut harness = window(&worker, false);
    for (path, told) in [
        (&bad, "this is no EPW file"),
        (&missing, "there is no such file"),
        (&winter, "has no hour from 12 to 13 o'clock on 21 June"),
    ] {
        drop_on(&mut harness, &[path.to_str().expect("plain")]);
        harness.run_steps(3);
        assert!(says(&harness, told), "{told}");
        assert_eq!(harness.state().edits().daylight, None);
        click(&mut harness, "Dismiss");
    }
    assert_eq!(worker.requests(), Vec::<String>::new());
}

#[test]
fn a_weather_file_is_asked_for_by_its_path_where_there_is_no_dialog_and_can_be_left_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    let path = folder.path().join("quito.epw");
    write_weather(&path);
    let mut harness = window(&Counting::showing(solution_of(&model)), false);
    click(&mut harness, "Weather file...");
    wait_until(&mut harness, "the question", |harness| harness.query_by_label("Path of the file").is_some());
    harness.run_steps(3);
    harness.event(egui::Event::Text(path.display().to_string()));
    harness.run_steps(2);
    click(&mut harness, "Open file");
    let weather =
        |harness: &Harness<'_, App>| harness.state().edits().daylight.clone().expect("a sky").weather;
    assert_eq!(weather(&harness).as_deref(), Some("quito.epw"));
    click(&mut harness, "Remove the weather file");
    harness.run_steps(3);
    assert_eq!(weather(&harness), None);
    let place = harness.state().edits().daylight.clone().expect("a sky");
    assert_eq!((place.latitude, place.zone, place.sky.as_deref()), (Some(-0.15), Some(-5.0), Some("clear")));
}
