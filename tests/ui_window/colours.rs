//! Colours of lamps and materials, chosen in a popup, by mouse and by keyboard.

use crate::support::{Counting, click, click_at, press, reveal, says, solved, window};
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::scene::luminance_weighted;
use lumenwalk::ui::App;

fn exitance(harness: &Harness<'_, App>) -> [f64; 3] {
    harness.state().lighting().lamps[0].exitance
}

/// Clicks a strip at a share of its width.
fn click_strip(harness: &mut Harness<'_, App>, name: &str, share: f32) {
    let rect = harness.get_by_label(name).rect();
    click_at(harness, rect.left_center() + egui::vec2(share * rect.width(), 0.0), Modifiers::NONE);
}

#[test]
fn the_hue_of_a_lamp_is_chosen_while_its_popup_stays_open() {
    let mut harness = window(&Counting::showing(solved()), false);
    let before = exitance(&harness);
    click(&mut harness, "Colour of Ceiling lamp");
    click_strip(&mut harness, "Saturation of Ceiling lamp", 1.0);
    click_strip(&mut harness, "Hue of Ceiling lamp", 1.0 / 3.0);
    let green = exitance(&harness);
    assert!(green[1] > 100.0 * green[0].max(green[2]), "{green:?}");
    let [was, now] = [before, green].map(luminance_weighted);
    assert!((was - now).abs() < 1e-6 * was, "as bright as before: {was} {now}");
    assert!(says(&harness, "120°") && says(&harness, "Not on the scale of white light"));
    // White has no hue, and the strip keeps the one that was chosen.
    click_strip(&mut harness, "Saturation of Ceiling lamp", 0.0);
    let white = exitance(&harness);
    assert!((white[0] - white[1]).abs() < 1e-6 * white[1] && says(&harness, "120°"), "{white:?}");
    click(&mut harness, "As the file has it");
    assert_eq!(exitance(&harness), before);
}

#[test]
fn the_strips_are_reached_and_moved_by_the_keyboard() {
    let mut harness = window(&Counting::showing(solved()), false);
    click(&mut harness, "Colour of Ceiling lamp");
    harness.get_by_label("Saturation of Ceiling lamp").focus();
    harness.run_steps(2);
    let before = exitance(&harness);
    for _ in 0..5 {
        press(&mut harness, Key::ArrowRight);
    }
    let after = exitance(&harness);
    assert!(after[2] / after[0] < 0.95 * before[2] / before[0], "deeper: {before:?} to {after:?}");
    assert!(harness.query_by_label("Hue of Ceiling lamp").is_some(), "the popup is still there");
}

#[test]
fn a_material_is_recoloured_and_as_bright_as_before() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    reveal(&mut harness, "Colour of brick");
    click(&mut harness, "Colour of brick");
    click_strip(&mut harness, "Hue of brick", 2.0 / 3.0);
    let scene = solved().scene().cloned().expect("a scene");
    let brick = scene.materials.iter().position(|m| m.name == "brick").expect("there");
    let new = harness.state().edits().reflectance[brick].expect("edited");
    assert!(new[2] > new[0] && new[2] > new[1], "blue: {new:?}");
    let [was, now] = [scene.materials[brick].reflectance, new].map(luminance_weighted);
    assert!((was - now).abs() < 1e-3, "{was} {now}");
    assert!(worker.requests().iter().all(|request| request == "materials 1"));
    // One band alone, by its number.
    harness.get_by_label("R of brick").focus();
    harness.run_steps(2);
    press(&mut harness, Key::ArrowUp);
    let redder = harness.state().edits().reflectance[brick].expect("edited");
    assert!(redder[0] > new[0] && redder[1..] == new[1..], "{new:?} to {redder:?}");
    click(&mut harness, "As the file has it");
    assert_eq!(harness.state().edits().reflectance[brick], None);
}
