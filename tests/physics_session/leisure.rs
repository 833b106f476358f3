//! What the worker does while nothing is asked for.

use crate::watched::Watched;
use lumenwalk::direct::Focus;
use lumenwalk::session::Snapshot;
use lumenwalk::solve::Stage;
use std::sync::Arc;

/// The error asked of direct light, and what is expected of it.
fn fineness(snapshot: &Snapshot) -> [f64; 2] {
    let light = snapshot.element_light().expect("direct light on elements");
    [light.target.error, light.elements.expected_error]
}

/// Looks at the scene from its first view.
fn focus(snapshot: &Snapshot) -> Focus {
    let view = &snapshot.scene().expect("a scene").views[0];
    Focus { eye: view.eye, forward: (view.target - view.eye).normalize(), half_angle: 0.6 }
}

#[test]
fn settled_light_becomes_finer_while_nothing_is_asked_for_and_costs_no_row() {
    let watched = Watched::coarse();
    let first = watched.open_builtin("hemicube");
    let whole = first.solved().expect("whole");
    let rows = whole.computer.rows_computed();
    watched.session.look_from(Some(focus(&first)));
    watched.session.refine_at_leisure(true);
    let finer = watched.until("finer light", |snapshot| {
        assert_eq!(snapshot.stage, Stage::Converged, "what stands stays");
        fineness(snapshot)[0] < fineness(&first)[0]
    });
    let solved = finer.solved().expect("whole");
    assert!(fineness(&finer)[1] < fineness(&first)[1], "{:?}, then {:?}", fineness(&first), fineness(&finer));
    assert!(Arc::ptr_eq(finer.transport().unwrap(), first.transport().unwrap()));
    assert_eq!((solved.computer.rows_computed(), finer.mesh_serial), (rows, first.mesh_serial));
    // It is the same light, and the power of the lamps still arrives.
    let lighting = solved.scene.lighting();
    let [before, after] = [&whole, &solved].map(|solution| solution.light(&lighting));
    let [old, new] = [&before, &after].map(|light| light.power(&solved.mesh, &solved.reflectance, &lighting));
    assert!((new.absorbed / old.absorbed - 1.0).abs() < 1e-3, "{old:?}, then {new:?}");
    watched.session.refine_at_leisure(false);
    watched.until("rest", |snapshot| snapshot.refining.is_none());
}

#[test]
fn a_request_comes_before_what_is_refined_and_a_stop_ends_it_until_the_next_one() {
    let watched = Watched::coarse();
    let first = watched.open_builtin("cornell");
    watched.session.refine_at_leisure(true);
    watched.until("refinement", |snapshot| snapshot.refining.is_some());
    watched.repaint(0, [0.2; 3]);
    let repainted = watched.converged(&first);
    assert_eq!(repainted.last_change.map(|done| done.rows), Some(0));
    watched.until("refinement", |snapshot| snapshot.refining.is_some());
    watched.session.stop();
    let stopped = watched.until("rest", |snapshot| snapshot.refining.is_none());
    assert_eq!(stopped.stage, Stage::Converged, "nothing is out of date");
    let dark = watched.until("rest", |snapshot| snapshot.stage == Stage::Converged);
    watched.repaint(0, [0.3; 3]);
    watched.converged(&dark);
    watched.until("refinement", |snapshot| snapshot.refining.is_some());
}
