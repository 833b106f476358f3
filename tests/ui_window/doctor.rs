//! The doctor in the window, on a model with every kind of fault; and windows of hardly any size.

use crate::support::{Counting, click, has_adapter, press, says, solution_of, solved, wait_until, window};
use egui::Key;
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, SnapshotOptions};
use lumenwalk::session::Snapshot;
use lumenwalk::ui::{App, Motion, Quantity, UiState};
use std::sync::{Arc, OnceLock};
use tempfile::TempDir;

/// A room of 5 m x 4 m x 3 m: a hole in the floor, a ceiling turned outwards, a wall twice, T-vertices
/// beside the back wall, and a box through the floor.
const OBJ: &str = "mtllib broken.mtl
v 0 0 0\nv 5 0 0\nv 5 3 0\nv 0 3 0\nv 0 0 4\nv 5 0 4\nv 5 3 4\nv 0 3 4
v 2 2.95 1.5\nv 3 2.95 1.5\nv 3 2.95 2.5\nv 2 2.95 2.5
o lamp\nusemtl glow\nf 9 10 11 12
o floor\nusemtl wood\nv 3.5 0 2.5\nv 3.9 0 2.5\nv 3.9 0 2.9\nv 3.5 0 2.9
f 1 5 16 13\nf 5 6 15 16\nf 6 2 14 15\nf 2 1 13 14
o ceiling\nusemtl plaster\nf 8 7 3 4
o back_wall\nv 0 1.2 0\nv 5 1.2 0\nf 1 2 18 17\nf 17 18 3 4
o left_wall\nf 1 4 8 5\no right_wall\nf 3 2 6 7\no front_wall\nf 5 8 7 6\nf 5 8 7 6
o table\nusemtl red
v 1.2 -0.3 1.4\nv 2.2 -0.3 1.4\nv 2.2 0.7 1.4\nv 1.2 0.7 1.4
v 1.2 -0.3 2.4\nv 2.2 -0.3 2.4\nv 2.2 0.7 2.4\nv 1.2 0.7 2.4
f 22 21 20 19\nf 24 25 26 23\nf 20 24 23 19\nf 22 26 25 21\nf 23 26 22 19\nf 25 24 20 21
";
const MTL: &str =
    "newmtl plaster\nKd 0.8 0.79 0.76\nnewmtl wood\nKd 0.45 0.3 0.18\nnewmtl red\nKd 0.6 0.18 0.15
newmtl glow\nKd 0.8 0.8 0.8\nKe 14 12 9\n";
const SIDECAR: &str =
    "[[view]]\nname = \"Door\"\neye = [4.6, 1.7, 3.7]\ntarget = [1.4, 0.6, 1.2]\nfov = 75.0\n";

fn broken() -> Arc<Snapshot> {
    static BROKEN: OnceLock<(TempDir, Arc<Snapshot>)> = OnceLock::new();
    let solve = || {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, text) in [("broken.obj", OBJ), ("broken.mtl", MTL), ("broken.toml", SIDECAR)] {
            std::fs::write(folder.path().join(name), text).expect("written");
        }
        let solution = solution_of(&folder.path().join("broken.obj"));
        (folder, solution)
    };
    Arc::clone(&BROKEN.get_or_init(solve).1)
}

/// A window on the broken model, examined, with the doctor's panel open.
fn examined(drawn: bool) -> Harness<'static, App> {
    let mut harness = window(&Counting::showing(broken()), drawn);
    wait_until(&mut harness, "the badge", |h| h.query_by_label("3 warnings").is_some());
    harness
}

#[test]
fn the_badge_opens_the_panel_and_a_finding_leads_to_its_place() {
    let mut harness = examined(false);
    click(&mut harness, "3 warnings");
    assert!(harness.state().visit().doctor_open);
    for name in [
        "warning: Duplicate faces (1)",
        "warning: Inconsistent winding (1)",
        "warning: Open edges (1)",
        "note: T-vertices (2)",
        "note: Interpenetrating faces (6)",
    ] {
        assert!(harness.query_by_label_contains(name).is_some(), "{name}");
    }
    let start = harness.state().camera().expect("shown");
    click(&mut harness, "warning: Inconsistent winding (1)");
    harness.run_steps(90);
    let there = harness.state().camera().expect("shown");
    assert!(there.eye.distance(start.eye) > 0.1, "the camera went there");
    assert_eq!(harness.state().motion(), Motion::Fly);
    // It looks at the middle of the ceiling.
    let towards = (glam::dvec3(2.5, 3.0, 2.0) - there.eye).normalize();
    assert!(towards.dot(there.forward) > 0.99, "{there:?}");
    assert!(harness.query_by_label_contains("Place 1: face of ceiling, plaster").is_some());

    click(&mut harness, "warning: Open edges (1)");
    harness.run_steps(90);
    let hole = harness.state().camera().expect("shown");
    click(&mut harness, "Next place");
    harness.run_steps(90);
    let next = harness.state().camera().expect("shown");
    assert!(hole.forward.dot(next.forward) < 1.0 - 1e-9 || hole.eye != next.eye, "another edge");
    let corner = glam::dvec3(3.7, 0.0, 2.7);
    assert!((corner - next.eye).normalize().dot(next.forward) > 0.9, "by the hole: {next:?}");

    press(&mut harness, Key::K);
    assert!(!harness.state().visit().doctor_open);
    assert!(harness.query_by_label("note: T-vertices (2)").is_none());
}

#[test]
fn every_place_is_looked_at_from_inside_the_room_and_in_the_picture() {
    let mut harness = examined(false);
    press(&mut harness, Key::K);
    // A row on the scene, which is grey nearly everywhere.
    let at = harness.get_by_label("Scene view").rect().center();
    harness.hover_at(at);
    harness.run_steps(2);
    press(&mut harness, Key::R);
    assert!(harness.state().edits().display.quantity.is_row());
    for name in [
        "warning: Duplicate faces",
        "warning: Inconsistent winding",
        "warning: Open edges",
        "note: T-vertices",
        "note: Interpenetrating faces",
    ] {
        harness.get_by_label_contains(name).click();
        harness.run_steps(90);
        assert_eq!(harness.state().edits().display.quantity, Quantity::Picture);
        for place in 1..=4 {
            let eye = harness.state().camera().expect("shown").eye;
            let inside = eye.cmpgt(glam::DVec3::ZERO).all() && eye.cmplt(glam::dvec3(5.0, 3.0, 4.0)).all();
            assert!(inside, "{name}, place {place}: {eye}");
            if harness.query_by_label("Next place").is_some() {
                click(&mut harness, "Next place");
                harness.run_steps(90);
            }
        }
    }
    assert_eq!(harness.state().motion(), Motion::Fly);
}

#[test]
fn flying_to_a_finding_is_said_and_a_step_walks_on() {
    let mut harness = examined(false);
    press(&mut harness, Key::K);
    click(&mut harness, "warning: Open edges (1)");
    assert!(says(&harness, "Flying, to see this place"));
    harness.run_steps(90);
    harness.get_by_label("Scene view").click();
    harness.key_down(Key::W);
    harness.run_steps(3);
    harness.key_up(Key::W);
    assert_eq!(harness.state().motion(), Motion::Walk);
}

#[test]
fn the_panel_gives_way_to_the_table_and_back() {
    let mut harness = examined(false);
    press(&mut harness, Key::K);
    press(&mut harness, Key::J);
    let state = harness.state().visit();
    assert!(state.table_open && !state.doctor_open);
    press(&mut harness, Key::K);
    let state = harness.state().visit();
    assert!(!state.table_open && state.doctor_open);
}

#[test]
fn a_sound_model_has_no_badge() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::K);
    wait_until(&mut harness, "the examination", |h| h.query_by_label("examining the model...").is_none());
    assert!(harness.query_by_label_contains("warning").is_none());
}

#[test]
fn a_finding_is_seen_in_the_picture() {
    if !has_adapter("a_finding_is_seen_in_the_picture") {
        return;
    }
    let mut harness = examined(true);
    press(&mut harness, Key::K);
    harness.run_steps(20);
    let view = harness.get_by_label("Scene view").rect();
    let before = harness.render().expect("rendered");
    harness.get_by_label("note: Interpenetrating faces (6)").hover();
    harness.run_steps(4);
    let hovered = harness.render().expect("rendered");
    let changed = before
        .enumerate_pixels()
        .filter(|(x, y, pixel)| {
            let inside = view.contains(egui::pos2(*x as f32, *y as f32));
            inside
                && hovered.get_pixel(*x, *y).0[..3]
                    .iter()
                    .zip(&pixel.0[..3])
                    .any(|(a, b)| a.abs_diff(*b) > 24)
        })
        .count();
    assert!(changed > 1500, "the box and the floor light up: {changed} pixels");
    click(&mut harness, "warning: Open edges (1)");
    harness.hover_at(egui::pos2(640.0, 300.0));
    harness.run_steps(90);
    let options = SnapshotOptions::new().threshold(4.0).max_failed_pixels(12_800);
    harness.snapshot_options("doctor_panel", &options);
}

#[test]
fn a_window_of_hardly_any_size_is_survived() {
    for drawn in [false, true] {
        if drawn && !has_adapter("a_window_of_hardly_any_size_is_survived") {
            return;
        }
        let mut harness = window(&Counting::showing(solved()), drawn);
        press(&mut harness, Key::K);
        let camera = harness.state().camera().expect("shown");
        for size in [[300.0, 200.0], [40.0, 30.0], [1.0, 1.0], [2000.0, 1.0], [1.0, 900.0], [1280.0, 800.0]] {
            harness.set_size(egui::Vec2::from(size));
            harness.run_steps(4);
            if drawn {
                harness.render().expect("rendered");
            }
        }
        for scale in [0.5, 2.0, 1.0] {
            harness.set_pixels_per_point(scale);
            harness.run_steps(4);
        }
        let after = harness.state().camera().expect("still shown");
        assert!(after.eye.distance(camera.eye) < 1e-6 && after.fov_y_deg.is_finite(), "{after:?}");
        assert!(harness.query_by_label("Scene view").is_some());
    }
}

#[test]
fn a_lost_graphics_device_closes_the_window_without_a_panic() {
    if !has_adapter("a_lost_graphics_device_closes_the_window_without_a_panic") {
        return;
    }
    let worker = Counting::showing(solved());
    let device = Arc::new(OnceLock::<wgpu::Device>::new());
    let kept = Arc::clone(&device);
    let mut harness = Harness::builder().with_size([900.0, 600.0]).wgpu().build_eframe(move |cc| {
        let state = cc.wgpu_render_state.as_ref().expect("drawn with wgpu");
        kept.set(state.device.clone()).expect("once");
        App::new(cc, Box::new(worker), UiState::default())
    });
    wait_until(&mut harness, "the scene", |h| h.state().camera().is_some());
    let device = device.get().expect("set");
    device.destroy();
    // The loss is told when the device is asked next; a window asks with every frame.
    device.poll(wgpu::PollType::Poll).ok();
    wait_until(&mut harness, "the end", |h| {
        let mut windows = h.output().viewport_output.values();
        windows.any(|window| window.commands.contains(&egui::ViewportCommand::Close))
    });
    // Until it is closed it goes on without a picture.
    press(&mut harness, Key::L);
    assert!(harness.state().camera().is_some());
}
