//! The window driven by the names of its controls, its keys and its mouse.

use crate::support::{Counting, click, click_at, place_of_lamp, press, reveal, solved, wait_until, window};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::scene::illuminance;
use lumenwalk::session::Recompute;
use lumenwalk::solve::Stage;
use lumenwalk::solver::LightBases;
use lumenwalk::ui::{App, Motion, Quantity, ShadingMode};
use std::sync::Arc;

/// Area-weighted mean illuminance, lux.
fn mean_lux(harness: &Harness<'_, App>) -> f64 {
    let mesh = solved().mesh().cloned().expect("meshed");
    let light = harness.state().light();
    let lit = mesh.patches.iter().zip(&light.irradiance);
    let sum: f64 = lit.map(|(patch, h)| patch.area * illuminance(h.map(f64::from))).sum();
    sum / mesh.statistics.area
}

fn switches(harness: &Harness<'_, App>) -> Vec<bool> {
    harness.state().lighting().lamps.iter().map(|lamp| lamp.on).collect()
}

#[test]
fn lamps_switch_without_asking_the_solver() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    let both = mean_lux(&harness);
    click(&mut harness, "Ceiling lamp");
    assert_eq!(switches(&harness), [false, true]);
    let floor_alone = mean_lux(&harness);
    click(&mut harness, "All off");
    assert_eq!((switches(&harness), mean_lux(&harness)), (vec![false, false], 0.0));
    click(&mut harness, "All on");
    click(&mut harness, "Floor lamp");
    let ceiling_alone = mean_lux(&harness);
    // Light adds up: the solution is linear in the lamps.
    assert!((floor_alone + ceiling_alone - both).abs() < 1e-4 * both, "{floor_alone} {ceiling_alone} {both}");
    click(&mut harness, "Reset lamps");
    assert!((mean_lux(&harness) - both).abs() < 1e-6 * both);
    assert_eq!(worker.requests(), Vec::<String>::new(), "no solve for a switch");
}

#[test]
fn solo_leaves_one_lamp_and_brings_the_others_back() {
    let mut harness = window(&Counting::showing(solved()), false);
    click(&mut harness, "Solo Floor lamp");
    assert_eq!(switches(&harness), [false, true]);
    click(&mut harness, "Solo Ceiling lamp");
    assert_eq!(switches(&harness), [true, false]);
    click(&mut harness, "Solo Ceiling lamp");
    assert_eq!(switches(&harness), [true, true]);
}

#[test]
fn dimming_is_linear_and_one_step_of_undo() {
    let mut harness = window(&Counting::showing(solved()), false);
    click(&mut harness, "Floor lamp");
    let full = mean_lux(&harness);
    harness.get_by_label("Dim Ceiling lamp").focus();
    harness.run_steps(2);
    for _ in 0..5 {
        press(&mut harness, Key::ArrowLeft);
    }
    let dimmer = harness.state().lighting().lamps[0].dimmer;
    assert!(dimmer < 0.99 && dimmer > 0.2, "{dimmer}");
    assert!((mean_lux(&harness) - dimmer * full).abs() < 1e-3 * full);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert!(harness.state().lighting().lamps[0].dimmer > dimmer);
}

#[test]
fn undo_and_redo_go_through_lamps_and_display() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::Num2);
    press(&mut harness, Key::M);
    assert_eq!(switches(&harness), [true, false]);
    assert!(harness.state().edits().display.wireframe);
    for _ in 0..2 {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        harness.run_steps(3);
    }
    assert_eq!(switches(&harness), [true, true]);
    assert!(!harness.state().edits().display.wireframe);
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    harness.run_steps(3);
    assert_eq!(switches(&harness), [true, false]);
}

#[test]
fn the_display_panel_chooses_what_is_shown() {
    let mut harness = window(&Counting::showing(solved()), false);
    reveal(&mut harness, "Show");
    click(&mut harness, "Show");
    click(&mut harness, "Illuminance");
    assert_eq!(harness.state().edits().display.quantity, Quantity::Illuminance);
    reveal(&mut harness, "Store as A");
    click(&mut harness, "Pin range");
    let range = harness.state().edits().display.range.expect("pinned");
    assert!(range[0] < range[1]);
    press(&mut harness, Key::L);
    assert_eq!(harness.state().edits().display.quantity, Quantity::Picture);
    click(&mut harness, "Flat");
    assert_eq!(harness.state().edits().display.shading, ShadingMode::Flat);
    press(&mut harness, Key::G);
    assert_eq!(harness.state().edits().display.shading, ShadingMode::Smooth);
    click(&mut harness, "Automatic exposure");
    assert!(!harness.state().edits().display.auto_exposure);
}

#[test]
fn the_difference_to_a_stored_light_can_be_shown() {
    let mut harness = window(&Counting::showing(solved()), false);
    reveal(&mut harness, "Store as A");
    click(&mut harness, "Store as A");
    click(&mut harness, "Ceiling lamp");
    reveal(&mut harness, "Show difference to A");
    click(&mut harness, "Show difference to A");
    assert_eq!(harness.state().edits().display.quantity, Quantity::Difference);
}

/// Where the divider between A and now stands, as a share of the view's width.
fn divider(harness: &Harness<'_, App>) -> Option<f32> {
    let view = harness.get_by_label("Scene view").rect();
    let divider = harness.query_by_label("Divider between A and now")?;
    Some((divider.rect().center().x - view.left()) / view.width())
}

#[test]
fn two_states_stand_side_by_side_with_a_divider_that_moves() {
    let mut harness = window(&Counting::showing(solved()), false);
    assert_eq!(divider(&harness), None);
    reveal(&mut harness, "Store as A");
    click(&mut harness, "Store as A");
    click(&mut harness, "Ceiling lamp");
    reveal(&mut harness, "Show A beside now");
    click(&mut harness, "Show A beside now");
    let before = divider(&harness).expect("a divider");
    assert!((before - 0.5).abs() < 0.02, "{before}");
    let from = harness.get_by_label("Divider between A and now").rect().center();
    let to = from + egui::vec2(120.0, 0.0);
    let button = egui::PointerButton::Primary;
    for (at, event) in [(from, Some(true)), (to, None), (to, Some(false))] {
        harness.hover_at(at);
        if let Some(pressed) = event {
            let modifiers = Modifiers::NONE;
            harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
        }
        harness.run_steps(2);
    }
    let after = divider(&harness).expect("a divider");
    assert!(after > before + 0.1, "{before} to {after}");
    let eye = harness.state().camera().expect("shown");
    harness.get_by_label("Divider between A and now").focus();
    harness.run_steps(2);
    press(&mut harness, Key::ArrowLeft);
    assert!(divider(&harness).expect("a divider") < after, "by the keyboard too");
    assert_eq!(harness.state().camera().expect("shown"), eye, "the camera stays meanwhile");
    press(&mut harness, Key::Escape);
    press(&mut harness, Key::C);
    assert_eq!(divider(&harness), None);
}

#[test]
fn the_first_press_of_c_keeps_the_light_as_it_is() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::C);
    assert!(divider(&harness).is_some() && harness.state().edits().display.split);
    press(&mut harness, Key::L);
    assert!(divider(&harness).is_some(), "illuminance side by side");
    reveal(&mut harness, "Show difference to A");
    click(&mut harness, "Show difference to A");
    assert_eq!(divider(&harness), None, "a difference has no sides");
}

#[test]
fn a_tour_leads_through_the_bookmarks_until_one_moves() {
    let mut harness = window(&Counting::showing(solved()), false);
    assert!(harness.query_by_label("Stop tour").is_none());
    press(&mut harness, Key::T);
    assert!(harness.query_by_label("Stop tour").is_none(), "one bookmark makes no tour");
    let start = harness.state().camera().expect("shown").eye;
    harness.key_down(Key::D);
    harness.run_steps(60);
    harness.key_up(Key::D);
    harness.run_steps(30);
    click(&mut harness, "Store view");
    let end = harness.state().camera().expect("shown").eye;
    let reach = start.distance(end);
    assert!(reach > 0.2);
    click(&mut harness, "Play tour");
    let (mut farthest, mut steps) = (0.0_f64, 0);
    while harness.query_by_label("Stop tour").is_some() && steps < 2000 {
        harness.step();
        steps += 1;
        farthest = farthest.max(harness.state().camera().expect("shown").eye.distance(end));
    }
    assert!((farthest - reach).abs() < 0.02 * reach, "from the first bookmark: {farthest} of {reach}");
    assert!(harness.state().camera().expect("shown").eye.distance(end) < 1e-6, "to the last");
    press(&mut harness, Key::T);
    assert!(harness.query_by_label("Stop tour").is_some());
    harness.key_down(Key::W);
    harness.run_steps(2);
    harness.key_up(Key::W);
    harness.run_steps(2);
    assert!(harness.query_by_label("Stop tour").is_none(), "a step takes over");
}

#[test]
fn a_goal_is_an_error_or_a_time_and_waits_for_the_check() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    assert!(harness.query_by_label("Error to reach").is_some());
    click(&mut harness, "In time");
    assert!(harness.query_by_label("Time to solve in").is_some());
    // The light is not checked yet: there is nothing to foresee a solve from.
    click(&mut harness, "Reach it");
    assert!(worker.requests().iter().all(|r| !r.starts_with("settings")), "no solve without a check");
}

#[test]
fn a_goal_is_gone_for_once_the_light_is_checked() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    click(&mut harness, "In time");
    wait_until(&mut harness, "a check", |h| h.query_by_label("Checking the error").is_none());
    click(&mut harness, "Reach it");
    assert_eq!(worker.requests().iter().filter(|r| r.starts_with("settings")).count(), 1);
    assert!(harness.query_by_label("On the way: solving").is_some());
}

#[test]
fn what_a_solve_cost_is_told_by_stage_and_by_effect() {
    let mut harness = window(&Counting::showing(solved()), false);
    click(&mut harness, "What it cost");
    harness.run_steps(20);
    for name in ["Meshing", "Rows", "Balancing", "Sweeping", "Display", "visibility"] {
        assert!(harness.query_all_by_label(name).next().is_some(), "{name}");
    }
}

#[test]
fn pause_resume_and_stop_reach_the_solver() {
    let worker = Counting::showing(solved());
    worker.publish(|s| (s.stage, s.fraction, s.seconds_left) = (Stage::Rows, 0.6, Some(4.0)));
    let mut harness = window(&worker, false);
    assert!(harness.query_by_label("4.0 s left").is_some(), "time left is shown");
    click(&mut harness, "Pause");
    worker.publish(|s| s.paused = true);
    harness.run_steps(2);
    click(&mut harness, "Resume");
    press(&mut harness, Key::P);
    click(&mut harness, "Stop");
    assert_eq!(worker.requests(), ["pause", "resume", "resume", "stop"]);
    // What was stopped can be taken up again.
    worker.publish(|s| (s.stage, s.paused) = (Stage::Stopped, false));
    harness.run_steps(2);
    click(&mut harness, "Solve");
    assert_eq!(worker.requests(), ["pause", "resume", "resume", "stop", "resume"]);
}

#[test]
fn method_and_patches_ask_for_another_solve() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    click(&mut harness, "Method and quality");
    harness.run_steps(20);
    click(&mut harness, "Form factors");
    click(&mut harness, "Hemicube");
    assert_eq!(worker.requests(), ["settings Hemicube Count(700)"]);
}

#[test]
fn a_mesh_that_is_finer_in_places_can_be_made_even_again() {
    let worker = Counting::showing(solved());
    worker.publish(|s| s.settings.refinement = Some(Arc::default()));
    let mut harness = window(&worker, false);
    click(&mut harness, "Method and quality");
    harness.run_steps(20);
    click(&mut harness, "Finer where the picture was wrong");
    assert_eq!(worker.requests(), ["settings Lines Count(700)"]);
    assert!(harness.query_by_label("Finer where the picture was wrong").is_none());
}

#[test]
fn a_reflectance_asks_the_solver_once_per_change_and_showing_it_never() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    assert_eq!(worker.requests(), Vec::<String>::new(), "rounding for show is no edit");
    harness.get_by_role_and_label(Role::Slider, "Reflectance of brick").focus();
    harness.run_steps(2);
    press(&mut harness, Key::ArrowRight);
    assert_eq!(worker.requests(), ["materials 1"]);
    harness.get_by_label("Scene view").click();
    harness.run_steps(2);
    click(&mut harness, "Reset materials");
    assert_eq!(worker.requests(), ["materials 1", "materials 0"]);
}

#[test]
fn clicking_a_lamp_in_the_view_switches_it() {
    let mut harness = window(&Counting::showing(solved()), false);
    let at = place_of_lamp(&harness, 0);
    click_at(&mut harness, at, Modifiers::NONE);
    assert_eq!(switches(&harness), [false, true]);
    click_at(&mut harness, at, Modifiers::NONE);
    assert_eq!(switches(&harness), [true, true]);
}

#[test]
fn ctrl_click_looks_into_a_patch_and_escape_leaves_it() {
    let mut harness = window(&Counting::showing(solved()), false);
    let at = place_of_lamp(&harness, 0);
    click_at(&mut harness, at, Modifiers::COMMAND | Modifiers::CTRL);
    let patch = harness.state().inspected().expect("a patch");
    let mesh = solved().mesh().cloned().expect("meshed");
    assert_eq!(mesh.patches[patch as usize].luminaire, Some(0));
    assert_eq!(switches(&harness), [true, true], "looking does not switch");
    press(&mut harness, Key::Escape);
    assert_eq!(harness.state().inspected(), None);
}

#[test]
fn keys_walk_and_the_walls_hold() {
    let mut harness = window(&Counting::showing(solved()), false);
    let before = harness.state().camera().expect("shown").eye;
    harness.key_down(Key::W);
    harness.run_steps(240);
    harness.key_up(Key::W);
    harness.run_steps(10);
    let after = harness.state().camera().expect("shown").eye;
    assert!(before.distance(after) > 0.5, "{before} to {after}");
    assert!(after.x > 0.2 && after.x < 3.8 && after.z > 0.2 && after.z < 2.8, "inside: {after}");
    assert!((after.y - 1.6).abs() < 0.02, "at eye height: {after}");
    press(&mut harness, Key::F);
    assert_eq!(harness.state().motion(), Motion::Fly);
}

/// Drags with the right mouse button, which orbits.
fn orbit(harness: &mut Harness<'_, App>, by: egui::Vec2) {
    let at = harness.get_by_label("Scene view").rect().center();
    harness.hover_at(at);
    harness.run_steps(2);
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Secondary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    harness.event(button(at, true));
    harness.step();
    for part in [0.5, 1.0] {
        harness.hover_at(at + by * part);
        harness.step();
    }
    harness.event(button(at + by, false));
    harness.run_steps(3);
}

#[test]
fn who_has_orbited_walks_on_and_the_walls_still_hold() {
    let mut harness = window(&Counting::showing(solved()), false);
    let start = harness.state().camera().expect("shown").eye;
    orbit(&mut harness, egui::vec2(60.0, 10.0));
    assert_eq!(harness.state().motion(), Motion::Fly);
    assert!(harness.state().camera().expect("shown").eye.distance(start) > 0.05, "it has orbited");
    harness.key_down(Key::W);
    harness.run_steps(240);
    harness.key_up(Key::W);
    harness.run_steps(10);
    assert_eq!(harness.state().motion(), Motion::Walk);
    let eye = harness.state().camera().expect("shown").eye;
    assert!(eye.x > 0.2 && eye.x < 3.8 && eye.z > 0.2 && eye.z < 2.8, "inside: {eye}");
    // Home brings walking back by itself, and who has chosen to fly goes on flying.
    orbit(&mut harness, egui::vec2(60.0, 10.0));
    press(&mut harness, Key::Home);
    assert_eq!(harness.state().motion(), Motion::Walk);
    press(&mut harness, Key::F);
    orbit(&mut harness, egui::vec2(60.0, 10.0));
    press(&mut harness, Key::Home);
    assert_eq!(harness.state().motion(), Motion::Fly);
}

#[test]
fn without_any_light_the_view_says_why() {
    let mut harness = window(&Counting::showing(solved()), false);
    let told = "All lamps are off  -  0 or a click on a lamp switches them on";
    assert!(harness.query_by_label(told).is_none());
    press(&mut harness, Key::Num0);
    assert!(harness.query_by_label(told).is_some());
    press(&mut harness, Key::Num0);
    assert!(harness.query_by_label(told).is_none());
}

#[test]
fn bookmarks_are_stored_and_gone_back_to() {
    let mut harness = window(&Counting::showing(solved()), false);
    let start = harness.state().camera().expect("shown").eye;
    harness.key_down(Key::D);
    harness.run_steps(60);
    harness.key_up(Key::D);
    harness.run_steps(30);
    click(&mut harness, "Store view");
    let stored = harness.state().camera().expect("shown").eye;
    assert!(start.distance(stored) > 0.2);
    click(&mut harness, "Start view");
    harness.run_steps(60);
    assert!(harness.state().camera().expect("shown").eye.distance(start) < 1e-6);
    click(&mut harness, "View 2");
    harness.run_steps(60);
    assert!(harness.state().camera().expect("shown").eye.distance(stored) < 1e-6);
}

#[test]
fn tab_folds_the_panels_and_f1_shows_the_keys() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::Tab);
    harness.run_steps(30);
    assert!(harness.query_by_label("All off").is_none() && !harness.state().state().left_open);
    press(&mut harness, Key::Tab);
    harness.run_steps(30);
    assert!(harness.query_by_label("All off").is_some());
    press(&mut harness, Key::F1);
    assert!(harness.query_by_label("fold the panels away").is_some());
    press(&mut harness, Key::Escape);
    harness.run_steps(30);
    assert!(harness.query_by_label("fold the panels away").is_none());
}

#[test]
fn an_error_is_read_and_the_scene_stays() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    let sentence = "nowhere.obj: there is no such file";
    worker.publish(|s| (s.stage, s.error) = (Stage::Failed, Some(sentence.to_owned())));
    harness.run_steps(3);
    assert!(harness.query_by_label(sentence).is_some());
    assert!(mean_lux(&harness) > 0.0, "the present scene is left alone");
    click(&mut harness, "Dismiss");
    harness.run_steps(3);
    assert!(harness.query_by_label(sentence).is_none(), "and it does not come back");
}

#[test]
fn nothing_is_cut_in_a_small_window() {
    // What a screen of 1280 x 800 leaves at a scale of 1.5.
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    harness.set_size(egui::vec2(853.0, 533.0));
    let sentence = "broken.obj, line 3: the face asks for vertex 9, and 2 of them stand above it; the file \
        is cut off or damaged";
    worker.publish(|s| (s.stage, s.error) = (Stage::Failed, Some(sentence.to_owned())));
    harness.run_steps(4);
    let view = harness.get_by_label("Scene view").rect();
    for name in ["Error", sentence, "Dismiss"] {
        let rect = harness.get_by_label(name).rect();
        assert!(view.contains_rect(rect), "{name} at {rect:?} in a view at {view:?}");
    }
    click(&mut harness, "Dismiss");
    press(&mut harness, Key::F1);
    harness.run_steps(30);
    let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(853.0, 533.0));
    for name in ["walk", "orbit around the point under the cursor", "this list"] {
        let rect = harness.get_by_label(name).rect();
        assert!(screen.contains_rect(rect), "{name} at {rect:?}");
    }
}

#[test]
fn at_rest_nothing_is_drawn_again() {
    let mut harness = window(&Counting::showing(solved()), false);
    harness.run_steps(60);
    let repaint = harness.output().viewport_output.values().map(|v| v.repaint_delay).min();
    assert!(repaint.is_none_or(|delay| delay.as_secs_f64() > 0.5), "{repaint:?}");
}

#[test]
fn what_the_worker_said_once_gives_way_to_what_is_switched() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    worker.publish(|s| {
        s.last_change = Some(Recompute { sweeps: 3, seconds: 0.04, ..Recompute::default() });
        s.stage = Stage::Rows;
    });
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("materials: 0 rows").is_some());
    press(&mut harness, Key::Num1);
    // More light of the same solve comes: it says nothing new.
    worker.publish(|s| {
        let solution = s.solution_mut().expect("solved");
        solution.bases = Arc::new(LightBases::clone(&solution.bases));
    });
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("Ceiling lamp off").is_some());
    assert!(harness.query_by_label_contains("materials: 0 rows").is_none());
}

#[test]
fn an_error_of_before_is_not_told_of_the_file_that_is_being_opened() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    worker.publish(|s| s.error = Some("broken.obj: no faces".to_owned()));
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("broken.obj").is_some());
    harness.key_press(Key::F5);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("broken.obj").is_none(), "another request is on its way");
    worker.publish(|s| s.stage = Stage::Loading);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("broken.obj").is_none());
    // The same file fails in the same way: that is news.
    worker.publish(|s| s.stage = Stage::Converged);
    harness.run_steps(3);
    assert!(harness.query_by_label_contains("broken.obj").is_some());
}

#[test]
fn a_bookmark_is_renamed_and_removed_but_not_the_start_view() {
    let mut harness = window(&Counting::showing(solved()), false);
    click(&mut harness, "Store view");
    let open = |harness: &mut Harness<'_, App>, name: &str| {
        harness.get_by_label(name).click_secondary();
        harness.run_steps(3);
    };
    open(&mut harness, "View 2");
    harness.get_by_label("Name of the bookmark").focus();
    harness.run_steps(2);
    harness.get_by_label("Name of the bookmark").type_text(" by the door");
    harness.run_steps(2);
    click(&mut harness, "Rename");
    assert!(harness.query_by_label("View 2 by the door").is_some());
    open(&mut harness, "Door");
    click(&mut harness, "Remove");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label("Door").is_some(), "the start view stays");
    open(&mut harness, "View 2 by the door");
    click(&mut harness, "Remove");
    assert!(harness.query_by_label("View 2 by the door").is_none());
}

#[test]
fn the_upper_end_of_a_range_is_pinned_by_setting_it() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::L);
    assert_eq!(harness.state().edits().display.range, None);
    reveal(&mut harness, "Patch borders");
    let end = harness.get_by_label("Upper end");
    end.focus();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.get_by_label("Upper end").type_text("750");
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    let range = harness.state().edits().display.range.expect("pinned");
    assert!((range[1] - 750.0).abs() < 1.0, "{range:?}");
}
