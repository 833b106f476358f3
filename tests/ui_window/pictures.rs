//! Pictures of the window, compared with ones that were looked at, and what they must show.

use crate::support::{Counting, click_at, has_adapter, solved, wait_until, window};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, SnapshotOptions};
use lumenwalk::ui::App;

/// Adapters round differently, and a better mesh moves the light a little: an eightieth of the
/// pixels may differ. A control that moves, goes or is clipped changes more.
fn options() -> SnapshotOptions {
    SnapshotOptions::new().threshold(4.0).max_failed_pixels(12_800)
}

/// Mean of the sRGB codes of the view, 0 to 255.
pub(crate) fn brightness(harness: &mut Harness<'_, App>) -> f64 {
    let view = harness.get_by_label("Scene view").rect();
    brightness_in(harness, view)
}

fn brightness_in(harness: &mut Harness<'_, App>, rect: egui::Rect) -> f64 {
    let image = harness.render().expect("rendered");
    let mut sum = 0.0;
    let mut count = 0.0;
    for (x, y, pixel) in image.enumerate_pixels() {
        if rect.contains(egui::pos2(x as f32, y as f32)) {
            sum += pixel.0[..3].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
            count += 1.0;
        }
    }
    sum / count
}

#[test]
fn a_switched_lamp_is_dark_in_the_next_frame() {
    if !has_adapter("a_switched_lamp_is_dark_in_the_next_frame") {
        return;
    }
    let mut harness = window(&Counting::showing(solved()), true);
    let lit = brightness(&mut harness);
    assert!(lit > 40.0, "a lit picture: {lit}");
    harness.key_press(Key::Num1);
    harness.step();
    let dimmer = brightness(&mut harness);
    assert!(dimmer < 0.9 * lit, "{lit} to {dimmer}");
    harness.key_press(Key::Num0);
    harness.step();
    let dark = brightness(&mut harness);
    assert!(dark < 8.0, "all off: {dark}");
}

#[test]
fn a_lamp_that_went_out_is_dark_on_the_side_of_now_alone() {
    if !has_adapter("a_lamp_that_went_out_is_dark_on_the_side_of_now_alone") {
        return;
    }
    let mut harness = window(&Counting::showing(solved()), true);
    harness.key_press(Key::C);
    harness.run_steps(4);
    let view = harness.get_by_label("Scene view").rect();
    let centre = view.center().x;
    let half = |left: f32, right: f32| {
        egui::Rect::from_x_y_ranges(left..=right, view.top() + 60.0..=view.bottom() - 60.0)
    };
    let (left, right) = (half(view.left(), centre - 12.0), half(centre + 12.0, view.right()));
    let before = [left, right].map(|side| brightness_in(&mut harness, side));
    harness.key_press(Key::Num0);
    harness.run_steps(4);
    let after = [left, right].map(|side| brightness_in(&mut harness, side));
    assert!(after[0] > 0.7 * before[0], "A stays: {before:?} to {after:?}");
    assert!(after[1] < 8.0, "now is dark: {before:?} to {after:?}");
    harness.key_press(Key::Num2);
    harness.run_steps(30);
    harness.snapshot_options("window_comparison", &options());
}

#[test]
fn the_window_at_1280_by_800() {
    if !has_adapter("the_window_at_1280_by_800") {
        return;
    }
    let mut harness = window(&Counting::showing(solved()), true);
    harness.run_steps(10);
    harness.snapshot_options("window_picture", &options());
    harness.key_press(Key::L);
    harness.run_steps(4);
    harness.snapshot_options("window_illuminance", &options());
    harness.key_press(Key::L);
    harness.key_press(Key::F1);
    harness.run_steps(30);
    harness.snapshot_options("window_keys", &options());
}

#[test]
fn a_patch_under_the_microscope() {
    if !has_adapter("a_patch_under_the_microscope") {
        return;
    }
    let mut harness = window(&Counting::showing(solved()), true);
    let at = harness.get_by_label("Scene view").rect().center() + egui::vec2(40.0, 60.0);
    click_at(&mut harness, at, Modifiers::COMMAND | Modifiers::CTRL);
    let patch = harness.state().inspected().expect("a patch");
    wait_until(&mut harness, "the hemicube", |h| {
        h.query_by_label(&format!("Hemicube of patch {patch}")).is_some()
    });
    let before = brightness(&mut harness);
    harness.key_press(Key::R);
    harness.run_steps(10);
    assert!((brightness(&mut harness) - before).abs() > 2.0, "the row is on the scene");
    harness.snapshot_options("microscope_row", &options());
    harness.key_press(Key::R);
    harness.key_press(Key::J);
    harness.run_steps(30);
    assert!((brightness(&mut harness) - before).abs() < 6.0, "and gone again");
    harness.snapshot_options("microscope_table", &options());
}
