//! What the window asks of the solver, and what it says of the answers.

use crate::support::{Counting, click, press, solved, window};
use egui::Key;
use lumenwalk::session::Stage;

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
