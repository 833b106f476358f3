//! The sky over the model: asked for, moved, taken back.

use crate::support::{Counting, click, press, solved, window};
use egui::{Key, Modifiers};
use lumenwalk::scene::DaylightChoice;

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
