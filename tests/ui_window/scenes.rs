//! What belongs to a scene and leaves with it, and what stays with the user.

use crate::files::drop_on;
use crate::support::{Counting, click, press, read_again, reveal, says, solved, wait_until, window};
use eframe::App as _;
use egui::Key;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::form_factors::Method;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{SceneSource, View, illuminance};
use lumenwalk::solve::{self, Control, SolveSettings};
use lumenwalk::ui::{App, DisplaySettings, Motion, Quantity, ShadingMode, UiState, Visit, Worker};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Changes everything about how the scene is looked at.
fn change_all(harness: &mut Harness<'_, App>) {
    click(harness, "In time");
    for key in [Key::L, Key::M, Key::G, Key::F, Key::K, Key::Plus] {
        press(harness, key);
    }
    reveal(harness, "Pin range");
    click(harness, "Pin range");
    let display = harness.state().edits().display;
    assert!(display.wireframe && display.range.is_some() && display.compensation > 0.0);
    assert_eq!((display.quantity, display.shading), (Quantity::Illuminance, ShadingMode::Flat));
    let visit = harness.state().visit();
    assert!(visit.doctor_open && visit.motion == Motion::Fly);
}

/// Brings a scene of another source to the screen.
fn bring_another(harness: &mut Harness<'_, App>, worker: &Counting) {
    read_again(worker, |scene| {
        scene.source = SceneSource::Builtin("other".to_owned());
        scene.views.push(View { name: "Other".to_owned(), ..scene.views[0].clone() });
    });
    wait_until(harness, "the other scene", |h| says(h, "Other"));
}

#[test]
fn another_scene_starts_with_its_lit_picture_and_on_foot() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    change_all(&mut harness);
    bring_another(&mut harness, &worker);
    assert_eq!(harness.state().edits().display, DisplaySettings::default());
    assert_eq!(*harness.state().visit(), Visit::default());
    assert!(harness.query_by_label("Error to reach").is_some(), "and with the usual goal");
}

#[test]
fn a_file_that_is_read_again_is_looked_at_as_before() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    change_all(&mut harness);
    let (display, visit) = (harness.state().edits().display, harness.state().visit().clone());
    read_again(&worker, |scene| scene.views[0].name = "Gate".to_owned());
    wait_until(&mut harness, "the file read again", |h| says(h, "Gate"));
    assert_eq!(harness.state().edits().display, display);
    assert_eq!(*harness.state().visit(), visit);
}

#[test]
fn another_scene_is_solved_with_its_own_settings_and_the_same_file_with_those_it_has() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    let chosen = SolveSettings { method: Method::Rays, ..worker.settings() };
    worker.set_settings(chosen.clone());
    press(&mut harness, Key::F5);
    assert_eq!(worker.settings(), chosen);
    drop_on(&mut harness, &["/models/other.obj"]);
    assert_eq!(worker.settings(), SolveSettings::default());
}

/// Keeps what a window would write to disk.
#[derive(Default)]
struct Kept(HashMap<String, String>);

impl eframe::Storage for Kept {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }
    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }
    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }
    fn flush(&mut self) {}
}

#[test]
fn the_next_start_shows_a_lit_picture_and_keeps_the_users_preferences() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    change_all(&mut harness);
    reveal(&mut harness, "Numbers under the cursor");
    click(&mut harness, "Numbers under the cursor");
    press(&mut harness, Key::Tab);
    let mut kept = Kept::default();
    harness.state_mut().save(&mut kept);
    let stored: UiState = App::stored_state(Some(&kept));
    assert!(!stored.left_open && !stored.right_open && stored.recent.len() == 1);
    let next = Harness::builder()
        .with_size([1280.0, 800.0])
        .build_eframe(|cc| App::new(cc, Box::new(worker), stored));
    let expected = DisplaySettings { readout: false, ..DisplaySettings::default() };
    assert_eq!(next.state().edits().display, expected);
    assert_eq!(*next.state().visit(), Visit::default());
}

#[test]
fn light_a_follows_to_another_mesh_of_its_scene() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    click(&mut harness, "Ceiling lamp");
    reveal(&mut harness, "Store as A");
    click(&mut harness, "Store as A");
    click(&mut harness, "Ceiling lamp");
    let scene = solved().scene().cloned().expect("a scene");
    let settings = SolveSettings { patches: PatchTarget::Count(300), ..SolveSettings::default() };
    let never = AtomicBool::new(false);
    let other = solve::solve(scene, &settings, &never, &mut |_| Control::Continue).expect("solved");
    let patches = other.mesh.patches.len();
    assert_ne!(patches, solved().mesh().expect("meshed").patches.len());
    let (mesh, bases) = (Arc::clone(&other.mesh), Arc::clone(&other.bases));
    worker.publish(|s| {
        (s.solution, s.mesh_serial) = (Some(Arc::new(other)), s.mesh_serial + 1);
    });
    wait_until(&mut harness, "the other mesh", |h| h.state().light().irradiance.len() == patches);
    reveal(&mut harness, "Show difference to A");
    click(&mut harness, "Show difference to A");
    // What A lacks is the ceiling lamp alone.
    let mut lighting = lumenwalk::scene::Lighting::clone(harness.state().lighting());
    lighting.lamps[1].on = false;
    let ceiling = bases.sum(&lighting, mesh.patches.len());
    let shown = harness.state().shown_values();
    assert_eq!(shown.len(), patches);
    for (shown, expected) in shown.iter().zip(&ceiling) {
        let expected = illuminance(expected.map(f64::from));
        assert!((f64::from(*shown) - expected).abs() < 1e-3 * expected.max(1.0), "{shown} {expected}");
    }
}

#[test]
fn light_a_of_a_model_with_other_lamps_is_dropped_with_a_word() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    press(&mut harness, Key::C);
    assert!(harness.state().edits().display.split);
    read_again(&worker, |scene| scene.views[0].name = "Gate".to_owned());
    wait_until(&mut harness, "the file read again", |h| says(h, "Gate"));
    harness.run_steps(3);
    assert!(harness.query_by_label("Divider between A and now").is_some(), "the same lamps: it stays");
    read_again(&worker, |scene| {
        scene.views[0].name = "Hatch".to_owned();
        scene.luminaires[0].name = "Another lamp".to_owned();
    });
    wait_until(&mut harness, "the word", |h| says(h, "Light A was dropped"));
    assert!(!harness.state().edits().display.split);
}

#[test]
fn names_that_no_font_can_draw_are_explained_until_that_is_read() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    // Tests end at a missing glyph elsewhere; the program draws boxes.
    harness.ctx.set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
    assert!(!says(&harness, "No font on this computer"));
    read_again(&worker, |scene| {
        scene.views[0].name = "Gate".to_owned();
        scene.luminaires[0].name = "卧室灯".to_owned();
    });
    wait_until(&mut harness, "the word", |h| says(h, "No font on this computer has Chinese characters"));
    harness.run_steps(2);
    harness.get_by_label_contains("Dismiss: No font").click();
    harness.run_steps(3);
    assert!(!says(&harness, "No font on this computer"));
}
