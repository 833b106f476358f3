//! What is not saved is asked about before the scene is left, and nothing is where nothing was changed.

use crate::files::drop_on;
use crate::support::{
    Counting, click, press, reveal, says, solution, solution_of, wait_until, window, write_model,
};
use egui::{Key, Modifiers, ViewportCommand, ViewportEvent, ViewportId};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::scene::{SceneSource, load};
use lumenwalk::ui::App;
use std::path::PathBuf;

const QUESTION: &str = "Save the changes to room?";

/// A window on a model in a folder of its own.
fn on_disk() -> (tempfile::TempDir, PathBuf, Counting, Harness<'static, App>) {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    let worker = Counting::showing(solution_of(&model));
    let harness = window(&worker, false);
    (folder, model, worker, harness)
}

/// The frame in which the window's frame asks for its end; what the program answers.
fn close(harness: &mut Harness<'_, App>) -> Vec<ViewportCommand> {
    let viewport = harness.input_mut().viewports.entry(ViewportId::ROOT).or_default();
    viewport.events.push(ViewportEvent::Close);
    harness.step();
    let told = answers(harness);
    harness.input_mut().viewports.entry(ViewportId::ROOT).or_default().events.clear();
    harness.run_steps(2);
    told
}

fn answers(harness: &Harness<'_, App>) -> Vec<ViewportCommand> {
    harness.output().viewport_output.values().flat_map(|window| window.commands.clone()).collect()
}

fn opened(worker: &Counting) -> Vec<String> {
    worker.requests().into_iter().filter(|request| request.starts_with("open ")).collect()
}

#[test]
fn nothing_is_asked_where_nothing_was_changed() {
    let (_folder, _, worker, mut harness) = on_disk();
    // Ways of looking are no changes, and what was undone is none either.
    for key in [Key::L, Key::M, Key::F, Key::Num1, Key::Num1] {
        press(&mut harness, key);
    }
    assert!(!close(&mut harness).contains(&ViewportCommand::CancelClose));
    drop_on(&mut harness, &["/models/other.obj"]);
    assert_eq!(opened(&worker), ["open /models/other.obj"]);
    assert!(!says(&harness, QUESTION));
}

#[test]
fn closing_asks_about_lamps_materials_and_bookmarks() {
    let (_folder, _, _, mut harness) = on_disk();
    press(&mut harness, Key::Num1);
    click(&mut harness, "Store view");
    assert!(close(&mut harness).contains(&ViewportCommand::CancelClose));
    assert!(says(&harness, QUESTION) && says(&harness, "Changed: 1 lamp, 1 bookmark."));
    // Keys belong to the question.
    press(&mut harness, Key::Num2);
    assert!(harness.state().lighting().lamps[1].on);
    click(&mut harness, "Cancel");
    assert!(!says(&harness, QUESTION) && !harness.state().lighting().lamps[0].on, "all is as it was");
    assert!(close(&mut harness).contains(&ViewportCommand::CancelClose), "and it is asked about again");
    press(&mut harness, Key::Escape);
    assert!(!says(&harness, QUESTION), "Escape cancels");
    close(&mut harness);
    harness.get_by_label("Don't save").click();
    let mut ended = false;
    for _ in 0..3 {
        harness.step();
        ended |= answers(&harness).contains(&ViewportCommand::Close);
    }
    assert!(ended);
    assert!(!close(&mut harness).contains(&ViewportCommand::CancelClose), "asked once is enough");
}

#[test]
fn what_is_saved_on_the_way_out_is_in_the_sidecar() {
    let (_folder, model, _, mut harness) = on_disk();
    press(&mut harness, Key::Num1);
    reveal(&mut harness, "Colour of brick");
    close(&mut harness);
    harness.get_by_label("Save").click();
    wait_until(&mut harness, "the end", |h| answers(h).contains(&ViewportCommand::Close));
    let sidecar = std::fs::read_to_string(model.with_extension("toml")).expect("there");
    assert!(sidecar.contains("on = false"), "{sidecar}");
}

#[test]
fn what_was_saved_before_is_not_asked_about() {
    let (_folder, _, _, mut harness) = on_disk();
    press(&mut harness, Key::Num1);
    for name in ["File", "Save lamps, materials and bookmarks"] {
        harness.get_by_label_contains(name).click();
        harness.run_steps(4);
    }
    wait_until(&mut harness, "the file", |h| says(h, "Saved "));
    assert!(!close(&mut harness).contains(&ViewportCommand::CancelClose));
    press(&mut harness, Key::Num1);
    assert!(close(&mut harness).contains(&ViewportCommand::CancelClose), "what came after it is");
}

#[test]
fn another_scene_waits_for_the_answer() {
    let (_folder, _, worker, mut harness) = on_disk();
    press(&mut harness, Key::Num1);
    drop_on(&mut harness, &["/models/other.obj"]);
    harness.run_steps(2);
    assert!(says(&harness, QUESTION));
    assert_eq!(opened(&worker), Vec::<String>::new());
    click(&mut harness, "Cancel");
    drop_on(&mut harness, &["/models/other.obj"]);
    harness.run_steps(2);
    click(&mut harness, "Don't save");
    assert_eq!(opened(&worker), ["open /models/other.obj"]);
    // The same file again keeps what was done, so there is nothing to ask.
    press(&mut harness, Key::F5);
    assert_eq!(opened(&worker).len(), 2);
}

#[test]
fn a_sidecar_that_cannot_be_written_keeps_the_window_open() {
    let (_folder, model, _, mut harness) = on_disk();
    press(&mut harness, Key::Num1);
    // A folder stands where the file is to go.
    let sidecar = model.with_extension("toml");
    std::fs::remove_file(&sidecar).expect("there");
    std::fs::create_dir(&sidecar).expect("a folder");
    close(&mut harness);
    harness.get_by_label("Save").click();
    // "Error" alone may be that of the accuracy, which is told meanwhile.
    wait_until(&mut harness, "the error", |h| says(h, "Dismiss"));
    assert!(harness.run_ok().is_none_or(|_| true));
    assert!(!answers(&harness).contains(&ViewportCommand::Close));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert!(harness.state().lighting().lamps[0].on, "and it goes on");
}

#[test]
fn the_colour_of_a_lamp_of_an_embedded_scene_is_kept_in_a_copy() {
    let cornell = SceneSource::Builtin("cornell".to_owned());
    let mut harness = window(&Counting::showing(solution(&cornell)), false);
    press(&mut harness, Key::Num1);
    assert!(!close(&mut harness).contains(&ViewportCommand::CancelClose), "a switch is no work");
    click(&mut harness, "Colour of Ceiling lamp");
    click(&mut harness, "Warm");
    press(&mut harness, Key::Escape);
    assert!(close(&mut harness).contains(&ViewportCommand::CancelClose));
    assert!(says(&harness, "The scene is embedded: saving writes a copy of it."));
    click(&mut harness, "Save a copy...");
    wait_until(&mut harness, "a name", |h| says(h, "Path of the file"));
    click(&mut harness, "Cancel");
    close(&mut harness);
    click(&mut harness, "Save a copy...");
    wait_until(&mut harness, "a name", |h| says(h, "Path of the file"));
    let folder = tempfile::tempdir().expect("a folder");
    let copy = folder.path().join("mine.obj");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text(copy.display().to_string()));
    harness.run_steps(2);
    harness.get_by_label("Save file").click();
    wait_until(&mut harness, "the end", |h| answers(h).contains(&ViewportCommand::Close));
    let again = load(&SceneSource::File(copy)).expect("a scene");
    let warm = again.luminaires[0].initial.exitance;
    assert!(warm[0] > 1.5 * warm[2], "{warm:?}");
}
