//! What the window asks of the solver, and what it says of the answers.

use crate::support::{
    Counting, click, press, read_again, says, solution_of, solved, wait_until, window, write_model,
};
use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::scene::{LengthUnit, SceneSource, View};
use lumenwalk::session::{Recompute, Snapshot};
use lumenwalk::solve::Stage;
use lumenwalk::ui::App;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

fn opened(worker: &Counting) -> Vec<String> {
    worker.requests().into_iter().filter(|request| request.starts_with("open ")).collect()
}

/// Lets frames and real time pass, for what would come from a helper thread.
fn wait_a_while(harness: &mut Harness<'_, App>, time: Duration) {
    let end = std::time::Instant::now() + time;
    while std::time::Instant::now() < end {
        harness.step();
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_choice_is_added_to_the_one_that_is_not_in_force_yet() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    click(&mut harness, "Method and quality");
    harness.run_steps(20);
    click(&mut harness, "Form factors");
    click(&mut harness, "Hemicube");
    // Nothing has been published since.
    click(&mut harness, "Patches");
    click(&mut harness, "about 5,000");
    assert_eq!(worker.requests(), ["settings Hemicube Count(700)", "settings Hemicube Count(5000)"]);
}

#[test]
fn the_key_for_a_rest_does_nothing_while_nothing_runs() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    press(&mut harness, Key::P);
    assert_eq!(worker.requests(), Vec::<String>::new());
    worker.publish(|s| s.stage = Stage::Stopped);
    press(&mut harness, Key::P);
    assert_eq!(worker.requests(), ["resume"]);
}

#[test]
fn a_file_that_takes_frames_to_be_refused_is_said_not_to_be_opened() {
    let worker = Counting::showing(solved());
    let opened = Recompute { scene: true, rows: 700, sweeps: 6, seconds: 1.0, ..Recompute::default() };
    worker.publish(|s| s.last_change = Some(opened));
    let mut harness = window(&worker, false);
    press(&mut harness, Key::F5);
    assert!(says(&harness, "opening room.obj"));
    worker.publish(|s| s.stage = Stage::Loading);
    harness.run_steps(3);
    let refusal = |s: &mut Snapshot| {
        (s.stage, s.error) = (Stage::Converged, Some("room.obj: no faces".to_owned()));
    };
    worker.publish(refusal);
    harness.run_steps(3);
    assert!(says(&harness, "room.obj was not opened") && !says(&harness, "700 rows, 6 sweeps"));
}

#[test]
fn a_scene_that_is_too_large_to_solve_was_opened_all_the_same() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    press(&mut harness, Key::F5);
    read_again(&worker, |_| {});
    worker.publish(|s| s.stage = Stage::Meshing);
    harness.run_steps(3);
    worker.publish(|s| (s.stage, s.error) = (Stage::Failed, Some("too many patches".to_owned())));
    harness.run_steps(3);
    assert!(says(&harness, "too many patches") && says(&harness, "not solved"));
    assert!(!says(&harness, "was not opened"));
}

#[test]
fn an_error_that_was_dismissed_is_told_when_it_comes_again() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    let fails = |s: &mut Snapshot| (s.stage, s.error) = (Stage::Failed, Some("too many patches".to_owned()));
    worker.publish(fails);
    harness.run_steps(3);
    click(&mut harness, "Dismiss");
    assert!(!says(&harness, "too many patches"));
    worker.publish(|s| (s.stage, s.error) = (Stage::Converged, None));
    harness.run_steps(3);
    worker.publish(fails);
    harness.run_steps(3);
    assert!(says(&harness, "too many patches"));
}

/// Bookmarks by these names, each in another place.
fn views(names: &[&str]) -> Vec<View> {
    let view = |(k, name): (usize, &&str)| View {
        name: (*name).to_owned(),
        eye: glam::dvec3(0.5 + 0.5 * k as f64, 1.6, 2.5),
        target: glam::dvec3(2.0, 1.5, 1.0),
        fov_y_deg: 60.0,
    };
    names.iter().enumerate().map(view).collect()
}

#[test]
fn bookmarks_of_another_scene_are_walked_through_from_the_first() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    read_again(&worker, |scene| scene.views = views(&["One", "Two", "Three"]));
    wait_until(&mut harness, "the views", |h| says(h, "Three"));
    for _ in 0..3 {
        press(&mut harness, Key::CloseBracket);
    }
    let next = views(&["East", "South", "West", "North"]);
    let (first, source) = (next[0].eye, SceneSource::Builtin("other".to_owned()));
    read_again(&worker, |scene| (scene.views, scene.source) = (next, source));
    wait_until(&mut harness, "the other scene", |h| says(h, "North"));
    harness.run_steps(30);
    press(&mut harness, Key::End);
    press(&mut harness, Key::CloseBracket);
    harness.run_steps(90);
    let eye = harness.state().camera().expect("shown").eye;
    assert!(eye.distance(first) < 1e-6, "{eye}");
}

#[test]
fn stored_bookmarks_stay_while_the_model_stays_in_its_place() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    click(&mut harness, "Store view");
    assert!(says(&harness, "View 2"));
    read_again(&worker, |scene| scene.views[0].name = "Gate".to_owned());
    wait_until(&mut harness, "the scene", |h| says(h, "Gate"));
    assert!(says(&harness, "View 2"));
    read_again(&worker, |scene| {
        scene.views[0].name = "Hatch".to_owned();
        scene.unit = LengthUnit::Foot;
    });
    wait_until(&mut harness, "the scene in feet", |h| says(h, "Hatch"));
    assert!(!says(&harness, "View 2"), "its place is another one now");
}

/// A window on a model that lies in a folder.
fn on_disk() -> (tempfile::TempDir, PathBuf, Counting) {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    let worker = Counting::showing(solution_of(&model));
    (folder, model, worker)
}

#[test]
fn a_change_of_the_old_file_does_not_call_off_the_new_one() {
    let (_folder, model, worker) = on_disk();
    let mut harness = window(&worker, false);
    let text = std::fs::read_to_string(&model).expect("there");
    std::fs::write(&model, format!("{text}# changed\n")).expect("written");
    wait_until(&mut harness, "the change", |_| opened(&worker).len() == 1);
    // It has been read again, and then another one is asked for.
    read_again(&worker, |_| {});
    harness.run_steps(3);
    let other = PathBuf::from("/models/other.obj");
    harness.input_mut().dropped_files.push(Arc::new(crate::files::Dropped(other)));
    harness.run_steps(2);
    assert_eq!(opened(&worker).len(), 2);
    // Until the watcher that was begun anew has looked once.
    wait_a_while(&mut harness, Duration::from_millis(300));
    std::fs::write(&model, format!("{text}# changed again\n")).expect("written");
    wait_a_while(&mut harness, Duration::from_millis(2500));
    assert_eq!(opened(&worker).last().map(String::as_str), Some("open /models/other.obj"));
    assert_eq!(opened(&worker).len(), 2);
}

#[test]
fn the_unit_in_force_is_not_written_again() {
    let (_folder, model, worker) = on_disk();
    let sidecar = model.with_extension("toml");
    let before = std::fs::read_to_string(&sidecar).expect("there");
    let mut harness = window(&worker, false);
    let choose = |harness: &mut Harness<'_, App>, name: &str| {
        for name in ["File", "Unit and up axis", name] {
            harness.get_by_label_contains(name).click();
            harness.run_steps(5);
        }
    };
    choose(&mut harness, "Y is up");
    wait_a_while(&mut harness, Duration::from_millis(500));
    assert_eq!(std::fs::read_to_string(&sidecar).expect("there"), before);
    assert_eq!(opened(&worker), Vec::<String>::new());
    choose(&mut harness, "Z is up");
    wait_until(&mut harness, "another axis", |_| opened(&worker).len() == 1);
}

#[test]
fn a_model_on_its_side_in_inches_is_upright_and_its_unit_is_set_with_one_click() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    std::fs::remove_file(model.with_extension("toml")).expect("there");
    let text = std::fs::read_to_string(&model).expect("there");
    let turned = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let at: Vec<f64> = rest.split_whitespace().map(|word| word.parse().expect("a number")).collect();
            let [x, y, z] = [at[0], -at[2], at[1]].map(|metres| metres / 0.0254);
            format!("v {x} {y} {z}\n")
        }
        None => format!("{line}\n"),
    };
    std::fs::write(&model, text.lines().map(turned).collect::<String>()).expect("written");
    let worker = Counting::showing(solution_of(&model));
    let mut harness = window(&worker, false);
    harness.run_steps(5);
    let banner = "This model seems to be in inches rather than metres.";
    assert!(harness.query_all_by_label_contains(banner).count() > 0);
    harness.get_by_label_contains("Set inches, z up").click();
    wait_until(&mut harness, "the model is read again", |_| opened(&worker).len() == 1);
    let sidecar = std::fs::read_to_string(model.with_extension("toml")).expect("written");
    assert!(sidecar.contains("unit = \"in\"") && sidecar.contains("up = \"z\""), "{sidecar}");
    assert!(solution_of(&model).scene().is_some_and(|scene| {
        (scene.bounds().size().z - 3.0).abs() < 1.0 && scene.findings.iter().all(|f| f.remedy.is_none())
    }));
}

#[test]
fn light_is_refined_where_one_looks_unless_one_does_not_want_that() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    let (on, focus) = worker.leisure().expect("the window tells");
    let pose = harness.state().camera().expect("a camera").eye;
    assert!(on && focus.is_some_and(|focus| focus.eye.distance(pose) < 1e-9 && focus.half_angle > 0.3));
    click(&mut harness, "Method and quality");
    harness.run_steps(20);
    click(&mut harness, "Refine while idle");
    assert_eq!(worker.leisure().map(|told| told.0), Some(false));
    worker.publish(|snapshot| snapshot.refining = Some(0.4));
    harness.run_steps(3);
    assert!(says(&harness, "refining shadows"), "it is told");
    assert_eq!(worker.requests(), Vec::<String>::new(), "nothing is solved anew");
}
