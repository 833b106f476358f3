//! A scene without lamps: shown at once, said in words, and given lamps by one click.

use crate::pictures::brightness;
use crate::support::{Counting, click, has_adapter, press, wait_until, window};
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{self, Scene};
use lumenwalk::session::Snapshot;
use lumenwalk::solve::{self, Control, SolveSettings, Stage};
use lumenwalk::ui::App;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A room of 4 m x 3 m x 2.5 m.
const OBJ: &str = "mtllib bare.mtl
v 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3
v 0 2.5 0\nv 4 2.5 0\nv 4 2.5 3\nv 0 2.5 3
o room\nusemtl plaster
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 4 8 7 3\nf 1 5 8 4
";
const MTL: &str = "newmtl plaster\nKd 0.8 0.8 0.8\n";

fn settings() -> SolveSettings {
    SolveSettings { patches: PatchTarget::Count(400), ..SolveSettings::default() }
}

fn bare() -> Arc<Scene> {
    Arc::new(scene::from_text("bare", OBJ, MTL, None).expect("a scene"))
}

/// What the worker publishes of a scene without lamps.
fn unlit(scene: &Arc<Scene>) -> Arc<Snapshot> {
    let solved = solve::without_light(Arc::clone(scene), &settings()).expect("meshed");
    Arc::new(Snapshot {
        serial: 1,
        mesh_serial: 1,
        stage: Stage::Unlit,
        read: Some(Arc::clone(scene)),
        solution: Some(Arc::new(solved)),
        settings: settings(),
        ..Snapshot::default()
    })
}

fn says(harness: &Harness<'_, App>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

fn lamps(harness: &Harness<'_, App>) -> usize {
    harness.state().lighting().lamps.len()
}

#[test]
fn one_click_adds_lamps_and_undo_takes_them_back() {
    let scene = bare();
    let worker = Counting::showing(unlit(&scene));
    let mut harness = window(&worker, false);
    assert!(says(&harness, "No lamps: shown in even light") && says(&harness, "Even light: no lamps"));
    assert_eq!(worker.requests(), Vec::<String>::new(), "nothing is solved unasked");

    click(&mut harness, "Add ceiling lamps");
    let asked = worker.clone();
    wait_until(&mut harness, "the lamps", move |_| asked.requests() == ["lamps 1"]);
    harness.run_steps(3);
    assert_eq!(lamps(&harness), 1);
    assert!(says(&harness, "Ceiling lamp added") && !says(&harness, "No lamps: shown in even light"));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(lamps(&harness), 0);
    assert_eq!(worker.requests(), ["lamps 1", "lamps 0"]);
    assert!(says(&harness, "No lamps: shown in even light"));

    // Once more; the lit scene comes, the words go, and it can still be undone.
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    harness.run_steps(3);
    assert_eq!(worker.requests().last().map(String::as_str), Some("lamps 1"));
    let lit = Arc::new(scene.with_placed(harness.state().edits().placed.clone()));
    let never = AtomicBool::new(false);
    let solved = solve::solve(lit, &settings(), &never, &mut |_| Control::Continue).expect("solved");
    worker.publish(|s| {
        (s.mesh_serial, s.stage) = (2, Stage::Converged);
        s.solution = Some(Arc::new(solved));
    });
    wait_until(&mut harness, "the light", |h| !h.state().light().radiosity.is_empty());
    harness.run_steps(3);
    assert!(!says(&harness, "shown in even light") && !says(&harness, "Even light: no lamps"));
    assert_eq!(lamps(&harness), 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert_eq!(worker.requests().last().map(String::as_str), Some("lamps 0"));
}

#[test]
fn a_solve_in_the_dark_is_begun_by_its_button_alone() {
    let worker = Counting::showing(unlit(&bare()));
    let mut harness = window(&worker, false);
    press(&mut harness, Key::P);
    assert_eq!(worker.requests(), Vec::<String>::new());
    assert!(says(&harness, "No light to check"));
    click(&mut harness, "Solve anyway");
    assert_eq!(worker.requests(), ["resume"]);
}

#[test]
fn the_words_can_be_dismissed_and_the_picture_still_says_what_it_is() {
    let worker = Counting::showing(unlit(&bare()));
    let mut harness = window(&worker, false);
    harness.get_by_label_contains("Dismiss: No lamps").click();
    harness.run_steps(3);
    assert!(!says(&harness, "No lamps: shown in even light") && says(&harness, "Even light: no lamps"));
}

#[test]
fn a_scene_without_lamps_is_never_black() {
    if !has_adapter("a_scene_without_lamps_is_never_black") {
        return;
    }
    let mut harness = window(&Counting::showing(unlit(&bare())), true);
    harness.run_steps(8);
    let bright = brightness(&mut harness);
    assert!(bright > 80.0, "{bright}");
    assert!(harness.state().light().radiosity.is_empty(), "a picture, and no light");
}
