//! The worker: what a request recomputes, which one wins, and that it obeys.

#[path = "../common/mod.rs"]
mod common;
mod daylight;
mod leisure;
mod watched;

use common::{builtin, room_with_blocks, solved};
use lumenwalk::form_factors::Method;
use lumenwalk::mesh::{PatchTarget, Refinement};
use lumenwalk::scene::SceneSource;
use lumenwalk::session::{MaterialEdit, Session, Snapshot};
use lumenwalk::solve::{Solution, SolveSettings, Stage};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::Duration;
use watched::{Held, Watched, coarse};

/// Rows and sweeps of the last request.
#[track_caller]
fn recomputed(snapshot: &Snapshot) -> (usize, usize) {
    let done = snapshot.last_change.expect("a request was answered");
    (done.rows, done.sweeps)
}

/// Rows computed and passes over the transport made so far, whoever asked for them.
fn work(solution: &Solution) -> (u64, u64) {
    (solution.computer.rows_computed(), solution.transport.as_ref().expect("whole").passes())
}

#[test]
fn a_switched_lamp_recomputes_nothing() {
    let watched = Watched::coarse();
    let snapshot = watched.open_builtin("hemicube");
    let solution = snapshot.solved().expect("it has converged");
    let done = work(&solution);
    let patches = solution.mesh.patches.len() as u64;
    assert!(done.0 >= patches && done.1 >= 2 * solution.sweeps.len() as u64, "the solve counts: {done:?}");
    let mut lighting = solution.scene.lighting();
    let before = solution.light(&lighting);
    lighting.lamps[0].on = !lighting.lamps[0].on;
    let after = solution.light(&lighting);
    assert_ne!(before, after, "the switch shows");
    lighting.lamps[0].on = !lighting.lamps[0].on;
    assert_eq!(before, solution.light(&lighting), "and shows no more once undone");
    let now = watched.session.latest();
    assert_eq!(now.serial, snapshot.serial, "the worker has not stirred");
    assert_eq!(work(&solution), done, "no row, no pass");
    // A point asked about costs one row.
    solution.irradiance_at(&[(solution.mesh.patches[0].centre, solution.mesh.patches[0].normal)], &after);
    assert_eq!(work(&solution), (done.0 + 1, done.1));
}

#[test]
fn a_panic_in_the_worker_is_told_and_the_session_goes_on() {
    // The host's own callback panics in the middle of an answer, once: on the worker's thread, like any
    // error of the solver.
    let (tell, news) = channel();
    let armed = Arc::new(AtomicBool::new(false));
    let trap = Arc::clone(&armed);
    let session = Session::spawn(move || {
        assert!(!trap.swap(false, Ordering::SeqCst), "provoked");
        tell.send(()).unwrap_or(());
    });
    let watched = Watched { session: session.expect("a thread"), news };
    watched.session.set_settings(coarse(300));
    let before = watched.open_builtin("hemicube");
    armed.store(true, Ordering::SeqCst);
    watched.session.set_settings(coarse(350));
    let failed = watched.until("message", |s| s.stage == Stage::Failed);
    let message = failed.error.as_deref().expect("it says so");
    assert!(message.contains("error of its own (provoked)"), "{message}");
    assert!(failed.scene().is_some() && failed.bases().is_some(), "what is on screen stays");
    assert!(Arc::ptr_eq(failed.scene().unwrap(), before.scene().unwrap()));
    // The next wish, whatever it is, brings the scene back; so does opening another.
    watched.session.set_settings(coarse(300));
    let again = watched.until("convergence", |s| s.stage == Stage::Converged && s.serial > failed.serial);
    assert_eq!(again.error, None);
    assert_eq!(again.scene().unwrap().name, "hemicube");
    let other = watched.open_builtin("cornell");
    assert_eq!(other.scene().unwrap().name, "cornell");
}

#[test]
fn a_reflectance_costs_sweeps_and_no_row() {
    let watched = Watched::coarse();
    let first = watched.open_builtin("cornell");
    assert_eq!(recomputed(&first).0, first.mesh().unwrap().patches.len());
    let scene = first.scene().cloned().unwrap();
    let material = scene.materials.iter().position(|m| m.name == "red").unwrap() as u32;
    let edit = MaterialEdit { material, reflectance: [0.05, 0.1, 0.7] };
    watched.session.set_materials(&scene, vec![edit]);
    let edited = watched.converged(&first);
    let (rows, sweeps) = recomputed(&edited);
    assert_eq!(rows, 0, "{:?}", edited.last_change);
    assert!(sweeps > 0, "{:?}", edited.last_change);
    assert!(Arc::ptr_eq(edited.transport().unwrap(), first.transport().unwrap()));
    assert_eq!(edited.mesh_serial, first.mesh_serial);

    // As good as if the scene had come so.
    let mut other = (*scene).clone();
    other.materials[material as usize].reflectance = edit.reflectance;
    let direct = solved(&Arc::new(other), &coarse(300));
    let lighting = scene.lighting();
    let (a, b) = (edited.solved().unwrap().light(&lighting), direct.light(&lighting));
    let largest = b.irradiance.iter().flatten().copied().fold(0.0, f32::max);
    for (x, y) in a.irradiance.iter().flatten().zip(b.irradiance.iter().flatten()) {
        assert!((x - y).abs() <= 2e-4 * largest, "{x} after the edit, {y} directly");
    }
}

#[test]
fn a_tolerance_costs_no_row_and_a_patch_size_all() {
    let watched = Watched::new();
    // Few patches would be solved at once, to the last digit.
    watched.session.set_settings(coarse(3000));
    let first = watched.open_builtin("cornell");
    let reached = first.sweeps().last().unwrap().error_bound;
    let asked = reached / 10.0;
    watched.session.set_settings(SolveSettings { tolerance: asked, ..coarse(3000) });
    let finer = watched.converged(&first);
    let (rows, sweeps) = recomputed(&finer);
    assert_eq!(rows, 0, "{:?}", finer.last_change);
    assert!(sweeps > 0, "{:?}", finer.last_change);
    let bound = finer.sweeps().last().unwrap().error_bound;
    assert!(bound <= asked, "{bound}, asked for {asked}, before {reached}");
    assert_eq!(finer.settings.tolerance, asked, "the window shows what is in force");

    watched.session.set_settings(coarse(3500));
    let smaller = watched.converged(&finer);
    let patches = smaller.mesh().unwrap().patches.len();
    assert!(patches > first.mesh().unwrap().patches.len());
    assert_eq!(recomputed(&smaller).0, patches, "{:?}", smaller.last_change);

    // Another method computes rows anew over the same patches.
    watched.session.set_settings(SolveSettings {
        method: Method::Rays,
        resolution: Some(64),
        ..coarse(3500)
    });
    let by_rays = watched.converged(&smaller);
    assert_eq!(recomputed(&by_rays).0, patches, "{:?}", by_rays.last_change);
}

#[test]
fn a_finer_mesh_refines_the_light_that_is_there_and_ends_where_a_fresh_solve_does() {
    let asked = SolveSettings { tolerance: 1e-6, ..coarse(3000) };
    let watched = Watched::new();
    watched.session.set_settings(SolveSettings { tolerance: 1e-6, ..coarse(900) });
    let first = watched.open_builtin("hemicube");
    let flux = |s: &Snapshot| -> f64 {
        let (mesh, bases) = (s.mesh().unwrap(), s.bases().expect("never dark"));
        assert_eq!(bases.patches, mesh.patches.len());
        let stride = bases.values.len() / bases.patches;
        let lit = mesh.patches.iter().zip(bases.values.chunks(stride));
        lit.map(|(p, h)| p.area * f64::from(h.iter().sum::<f32>())).sum()
    };
    let before = flux(&first);
    watched.session.set_settings(asked.clone());
    let mut seen = 0;
    let end = loop {
        watched.news.recv_timeout(Duration::from_secs(300)).expect("news");
        let latest = watched.session.latest();
        if latest.mesh_serial > first.mesh_serial {
            seen += 1;
            assert!((flux(&latest) / before - 1.0).abs() < 0.03, "{:?}: {}", latest.stage, flux(&latest));
        }
        if latest.stage == Stage::Converged && latest.mesh_serial > first.mesh_serial {
            break latest;
        }
    };
    assert!(seen > 3, "{seen}");

    let timings = end.timings;
    assert_eq!(timings.first_light, timings.rows, "each patch gathers its own light with its row");

    let scene = end.scene().cloned().unwrap();
    let fresh = solved(&scene, &asked);
    let refined = end.solved().unwrap();
    assert!(refined.sweeps.len() < fresh.sweeps.len(), "the old light saves sweeps");
    let (a, b) = (&refined.bases.values, &fresh.bases.values);
    let largest = b.iter().copied().fold(0.0, f32::max);
    assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-5 * largest));
}

fn write_room(folder: &Path, rho: f64, shift: f64) -> SceneSource {
    let room = room_with_blocks(rho);
    let (obj, mtl) = room.texts();
    let moved = obj.replace("v 0.7 ", &format!("v {} ", 0.7 + shift));
    std::fs::write(folder.join("room.obj"), format!("mtllib room.mtl\n{moved}")).unwrap();
    std::fs::write(folder.join("room.mtl"), mtl).unwrap();
    SceneSource::File(folder.join("room.obj"))
}

#[test]
fn a_file_read_again_keeps_its_rows_while_its_geometry_stays() {
    let folder = tempfile::tempdir().unwrap();
    let watched = Watched::coarse();
    let nothing = watched.session.latest();
    watched.session.open(write_room(folder.path(), 0.5, 0.0));
    let first = watched.converged(&nothing);
    watched.session.open(write_room(folder.path(), 0.7, 0.0));
    let repainted = watched.converged(&first);
    let (rows, sweeps) = recomputed(&repainted);
    assert_eq!(rows, 0, "{:?}", repainted.last_change);
    assert!(
        sweeps > 0 && repainted.last_change.is_some_and(|done| done.kept_rows),
        "{:?}",
        repainted.last_change
    );
    let mean = |s: &Snapshot| -> f32 { s.bases().unwrap().values.iter().sum() };
    assert!(mean(&repainted) > 1.2 * mean(&first), "the new paint shows");

    watched.session.open(write_room(folder.path(), 0.7, 0.1));
    let moved = watched.converged(&repainted);
    assert_eq!(recomputed(&moved).0, moved.mesh().unwrap().patches.len(), "{:?}", moved.last_change);
}

#[test]
fn a_missing_file_leaves_the_present_scene() {
    let watched = Watched::coarse();
    let first = watched.open_builtin("cornell");
    watched.session.open(SceneSource::File("no/such/file.obj".into()));
    let failed = watched.until("failure", |s| s.error.is_some());
    assert_eq!((failed.stage, failed.fraction), (Stage::Converged, 1.0), "the present scene stands whole");
    assert_eq!(failed.last_change, first.last_change);
    let message = failed.error.clone().expect("a message");
    assert!(message.contains("file.obj") && !message.contains('\n'), "{message}");
    assert!(Arc::ptr_eq(failed.scene().unwrap(), first.scene().unwrap()));
    assert!(Arc::ptr_eq(failed.bases().unwrap(), first.bases().unwrap()));
    // And it can still be worked with.
    watched.repaint(0, [0.2; 3]);
    let edited = watched.converged(&failed);
    assert_eq!(recomputed(&edited).0, 0, "{:?}", edited.last_change);
    assert_eq!(edited.error, None);
}

#[test]
fn a_file_that_is_refused_interrupts_a_solve_and_forgets_no_edit() {
    let watched = Watched::coarse();
    watched.session.set_settings(coarse(3000));
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    watched.until("rows", |s| s.rows.0 > 20);
    watched.session.open(SceneSource::File("no/such/file.obj".into()));
    let whole = watched.until("convergence", |s| s.stage == Stage::Converged);
    assert!(whole.error.as_deref().is_some_and(|e| e.contains("file.obj")), "{:?}", whole.error);
    assert_eq!(whole.scene().unwrap().name, "hemicube");
    assert_eq!(whole.rows.0, whole.rows.1);

    watched.repaint(0, [0.2; 3]);
    let edited = watched.converged(&whole);
    watched.session.open(SceneSource::File("no/such/file.obj".into()));
    let refused = watched.until("refusal", |s| s.error.is_some());
    assert_eq!(refused.reflectance(), edited.reflectance());
    watched.session.set_settings(SolveSettings { tolerance: 1e-7, ..coarse(3000) });
    let tighter = watched.until("convergence", |s| s.stage == Stage::Converged && s.error.is_none());
    assert_eq!(tighter.reflectance(), edited.reflectance(), "the edit is still in force");
    assert_eq!(tighter.error, None);
}

#[test]
fn the_newest_request_wins() {
    let watched = Watched::new();
    // Much work, never to be finished.
    watched.session.open(SceneSource::Builtin("house".to_owned()));
    watched.until("start", |s| s.stage == Stage::FirstLight);
    for patches in [100, 200, 400] {
        watched.session.set_settings(coarse(patches));
        watched.session.open(SceneSource::Builtin("cornell".to_owned()));
    }
    let last = watched.until("convergence", |s| s.stage == Stage::Converged);
    assert_eq!(last.scene().unwrap().name, "cornell");
    assert_eq!(last.settings, coarse(400));
}

#[test]
fn pause_holds_and_resume_finishes() {
    let watched = Watched::coarse();
    watched.session.pause();
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    let resting = watched.until("rest", |s| s.paused && s.rows.0 > 0);
    assert!(resting.bases().is_some(), "a picture is there");
    assert!(resting.rows.0 < resting.rows.1);
    std::thread::sleep(Duration::from_millis(300));
    let still = watched.session.latest();
    assert_eq!((still.rows, still.stage), (resting.rows, resting.stage), "it goes on although it is paused");
    watched.session.resume();
    let done = watched.until("convergence", |s| s.stage == Stage::Converged);
    assert!(!done.paused && done.error.is_none());
    assert!(done.sweeps().last().unwrap().error_bound <= 1e-4);
}

#[test]
fn an_edit_while_rows_come_keeps_those_that_are_there_and_a_rest_costs_no_time() {
    let watched = Watched::new();
    let asked = SolveSettings { tolerance: 1e-6, ..coarse(3000) };
    watched.session.set_settings(asked.clone());
    let clock = std::time::Instant::now();
    watched.session.pause();
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    let resting = watched.until("rest", |s| s.paused && s.rows.0 > 0);
    let there = resting.rows.0;
    assert!(there < resting.rows.1);
    let rest = Duration::from_millis(1500);
    std::thread::sleep(rest);
    let material = resting.scene().unwrap().materials.iter().position(|m| m.name == "white").unwrap();
    watched.repaint(material as u32, [0.5, 0.4, 0.3]);
    watched.session.resume();
    let end = watched.converged(&resting);
    let (rows, _) = recomputed(&end);
    assert!(rows + there <= resting.rows.1 && rows > 0, "{there} were there, {:?}", end.last_change);
    assert!(end.timings.solve() < (clock.elapsed() - rest).as_secs_f64(), "{:?}", end.timings);

    // As if nothing had come between.
    let watched = Watched::new();
    watched.session.set_settings(asked);
    let before = watched.open_builtin("hemicube");
    watched.repaint(material as u32, [0.5, 0.4, 0.3]);
    let direct = watched.converged(&before);
    let (a, b) = (&end.bases().unwrap().values, &direct.bases().unwrap().values);
    let largest = b.iter().copied().fold(0.0, f32::max);
    assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-5 * largest));
}

#[test]
fn a_request_while_paused_replaces_what_rests() {
    let watched = Watched::coarse();
    watched.session.pause();
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    watched.until("rest", |s| s.paused && s.rows.0 > 0);
    watched.session.open(SceneSource::Builtin("cornell".to_owned()));
    let other = watched.until("the other scene at rest", |s| {
        s.paused && s.rows.0 > 0 && s.scene().is_some_and(|scene| scene.name == "cornell")
    });
    assert_ne!(other.stage, Stage::Converged);
    watched.session.resume();
    watched.until("convergence", |s| s.stage == Stage::Converged);
}

#[test]
fn stop_keeps_the_picture_and_resume_starts_again() {
    let watched = Watched::coarse();
    watched.session.pause();
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    watched.until("rest", |s| s.paused && s.rows.0 > 0);
    watched.session.stop();
    let stopped = watched.until("stop", |s| s.stage == Stage::Stopped);
    assert!(stopped.bases().is_some() && stopped.mesh().is_some() && stopped.error.is_none());
    watched.session.resume();
    watched.until("convergence", |s| s.stage == Stage::Converged);
}

#[test]
fn a_stop_ends_the_rest_and_forgets_no_choice() {
    let watched = Watched::coarse();
    watched.session.pause();
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    watched.until("rest", |s| s.paused && s.rows.0 > 0);
    watched.session.set_settings(coarse(500));
    watched.session.stop();
    let stopped = watched.until("stop", |s| s.stage == Stage::Stopped);
    assert!(!stopped.paused, "the next solve would rest at once");
    assert_eq!(watched.session.settings(), coarse(500));
    watched.session.resume();
    let end = watched.until("convergence", |s| s.stage == Stage::Converged);
    assert_eq!(end.settings, coarse(500));
}

#[test]
fn edits_of_one_scene_touch_no_other() {
    let held = Held::coarse();
    let first = held.watched.open_builtin("hemicube");
    held.hold_at(Stage::Loading, |session| session.open(SceneSource::Builtin("cornell".to_owned())));
    // The window still shows the first.
    for material in 0..3 {
        held.watched.repaint(material, [0.15, 0.25, 0.35]);
    }
    held.go_on();
    let other = held.watched.converged(&first);
    let mesh = other.mesh().unwrap();
    assert_eq!(other.scene().unwrap().name, "cornell");
    let own: Vec<[f32; 3]> = mesh.patches.iter().map(|p| p.reflectance.map(|b| b as f32)).collect();
    assert_eq!(**other.reflectance().unwrap(), own);
}

#[test]
fn a_request_while_rows_are_balanced_computes_none_again() {
    let held = Held::coarse();
    held.hold_at(Stage::Balancing, |session| session.open(SceneSource::Builtin("hemicube".to_owned())));
    held.watched.repaint(0, [0.2; 3]);
    held.go_on();
    let end = held.watched.until("convergence", |s| s.stage == Stage::Converged);
    assert_eq!(recomputed(&end).0, 0, "{:?}", end.last_change);
    assert!(end.reflectance().unwrap().contains(&[0.2; 3]));
    assert!(end.sweeps().last().unwrap().error_bound <= 1e-4);
}

#[test]
fn a_rest_before_rows_are_balanced_costs_no_time() {
    let held = Held::coarse();
    let clock = std::time::Instant::now();
    held.hold_at(Stage::Balancing, |session| session.open(SceneSource::Builtin("hemicube".to_owned())));
    held.watched.session.pause();
    held.go_on();
    held.watched.until("rest", |s| s.paused && s.stage == Stage::Balancing);
    let rest = Duration::from_millis(1500);
    std::thread::sleep(rest);
    held.watched.session.resume();
    let end = held.watched.until("convergence", |s| s.stage == Stage::Converged);
    assert!(end.timings.solve() < (clock.elapsed() - rest).as_secs_f64(), "{:?}", end.timings);
}

#[test]
fn a_refused_file_takes_nothing_with_it_that_was_asked_for_beside_it() {
    let held = Held::coarse();
    let first = held.watched.open_builtin("hemicube");
    let by_hemicube = SolveSettings { method: Method::Hemicube, resolution: Some(32), ..coarse(300) };
    held.hold_at(Stage::Meshing, |session| session.set_settings(by_hemicube.clone()));
    held.watched.session.open(SceneSource::File("no/such/file.obj".into()));
    held.watched.repaint(0, [0.2; 3]);
    held.go_on();
    let end = held.watched.until("answer", |s| s.stage == Stage::Converged && s.error.is_some());
    assert!(end.error.as_deref().is_some_and(|e| e.contains("file.obj")), "{:?}", end.error);
    assert_eq!((&end.settings, &held.watched.session.settings()), (&by_hemicube, &by_hemicube));
    assert_eq!(recomputed(&end).0, end.rows.1, "{:?}", end.last_change);
    assert!(!Arc::ptr_eq(end.transport().unwrap(), first.transport().unwrap()));
    assert!(end.reflectance().unwrap().contains(&[0.2; 3]), "the paint too");
}

#[test]
fn refused_settings_are_wanted_no_more() {
    let watched = Watched::coarse();
    let first = watched.open_builtin("hemicube");
    let hopeless =
        SolveSettings { method: Method::Hemicube, patches: PatchTarget::Size(1e-6), ..coarse(300) };
    watched.session.set_settings(hopeless);
    let refused = watched.until("refusal", |s| s.error.is_some() && s.stage == Stage::Converged);
    assert_eq!((&refused.settings, &watched.session.settings()), (&coarse(300), &coarse(300)));
    assert!(Arc::ptr_eq(refused.transport().unwrap(), first.transport().unwrap()));
    // The method can be chosen all the same, and is carried out.
    let by_hemicube = SolveSettings { method: Method::Hemicube, resolution: Some(32), ..coarse(300) };
    watched.session.set_settings(by_hemicube.clone());
    let end = watched.converged(&refused);
    assert_eq!((&end.settings, &end.error), (&by_hemicube, &None));
    assert_eq!(recomputed(&end).0, end.rows.1, "{:?}", end.last_change);
}

#[test]
fn a_refinement_makes_a_new_mesh_and_leaves_with_its_scene() {
    let watched = Watched::coarse();
    let first = watched.open_builtin("hemicube");
    let mesh = first.mesh().unwrap();
    let cut = |index: usize| if index.is_multiple_of(7) { 4.0 } else { 1.0 };
    let parts: Vec<f64> = (0..mesh.patches.len()).map(cut).collect();
    let refinement = Some(Arc::new(Refinement::of(mesh, &parts, None)));
    let size = PatchTarget::Size(mesh.statistics.patch_size);
    watched.session.set_settings(SolveSettings {
        patches: size,
        refinement: refinement.clone(),
        ..coarse(300)
    });
    let finer = watched.converged(&first);
    assert!(finer.rows.1 > first.rows.1 + 50, "{} rows after {}", finer.rows.1, first.rows.1);
    // Read again it is the same scene.
    let again = watched.open_builtin("hemicube");
    assert_eq!((again.rows.1, &again.settings.refinement), (finer.rows.1, &refinement));
    let other = watched.open_builtin("cornell");
    assert_eq!((&other.settings.refinement, &watched.session.settings().refinement), (&None, &None));
}

#[test]
fn a_stop_holds_for_a_request_that_was_not_yet_begun() {
    let watched = Watched::coarse();
    // The worker reads the first while the second and the stop arrive.
    watched.session.open(SceneSource::Builtin("house".to_owned()));
    watched.until("start", |s| s.stage == Stage::Loading);
    watched.session.open(SceneSource::Builtin("cornell".to_owned()));
    watched.session.stop();
    watched.until("stop", |s| s.stage == Stage::Stopped);
    std::thread::sleep(Duration::from_millis(300));
    let latest = watched.session.latest();
    assert_eq!(latest.stage, Stage::Stopped, "it went on by itself: {:?}", latest.rows);
    watched.session.resume();
    let done = watched.until("convergence", |s| s.stage == Stage::Converged);
    assert_eq!(done.scene().unwrap().name, "cornell");
}

#[test]
fn a_dropped_session_ends_its_thread_at_any_stage() {
    for wanted in [Stage::Idle, Stage::Loading, Stage::FirstLight, Stage::Converged] {
        let alive = Arc::new(());
        let (tell, news) = channel();
        let held = alive.clone();
        let session = Session::spawn(move || {
            let _ = &held;
            tell.send(()).unwrap_or(());
        })
        .unwrap();
        let settings = if wanted == Stage::Converged { coarse(100) } else { SolveSettings::default() };
        session.set_settings(settings);
        if wanted != Stage::Idle {
            let name = if wanted == Stage::Converged { "cornell" } else { "house" };
            session.open(SceneSource::Builtin(name.to_owned()));
            while session.latest().stage != wanted {
                news.recv_timeout(Duration::from_secs(300)).expect("news");
                if wanted == Stage::Loading {
                    break;
                }
            }
        }
        drop(session);
        assert_eq!(Arc::strong_count(&alive), 1, "{wanted:?}: the thread still holds what it was given");
    }
}

#[test]
fn the_solution_has_the_same_bits_on_any_number_of_threads() {
    for (method, resolution) in [(Method::Lines, 64), (Method::Hemicube, 32), (Method::Rays, 256)] {
        let settings = SolveSettings { method, resolution: Some(resolution), ..coarse(400) };
        let scene = builtin("hemicube");
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solved(&scene, &settings))
        };
        let one = on(1);
        for threads in [2, 8] {
            let many = on(threads);
            let bits = |values: &[f32]| -> Vec<u32> { values.iter().map(|v| v.to_bits()).collect() };
            let same = bits(&one.bases.values) == bits(&many.bases.values);
            assert!(same, "{} on {threads} threads", method.name());
            let [a, b] = [&one, &many].map(|s| s.transport.as_ref().unwrap());
            for i in 0..a.len() {
                assert_eq!(a.row(i), b.row(i), "{} row {i}", method.name());
            }
        }
    }
}

#[test]
fn another_scene_brings_its_own_settings_and_a_refused_one_leaves_those_in_force() {
    let watched = Watched::coarse();
    let before = watched.open_builtin("hemicube");
    let chosen = SolveSettings { resolution: Some(24), ..coarse(300) };
    watched.session.set_settings(chosen.clone());
    watched.until("the chosen settings", |s| s.stage == Stage::Converged && s.settings == chosen);
    let missing = SceneSource::File("/nowhere/at/all.obj".into());
    watched.session.open_with(missing, coarse(350));
    let refused = watched.until("a refusal", |s| s.error.is_some() && s.stage == Stage::Converged);
    assert_eq!((&refused.settings, &watched.session.settings()), (&chosen, &chosen));
    assert_eq!(refused.mesh_serial, watched.session.latest().mesh_serial, "nothing is solved again");
    assert!(Arc::ptr_eq(refused.scene().unwrap(), before.scene().unwrap()));
    // One that is given up for the present scene leaves them as well.
    watched.session.open_with(SceneSource::Builtin("gallery".to_owned()), coarse(350));
    watched.session.open(SceneSource::Builtin("hemicube".to_owned()));
    assert_eq!(watched.session.settings(), chosen);
    let other = coarse(280);
    watched.session.open_with(SceneSource::Builtin("cornell".to_owned()), other.clone());
    let opened = watched.until("the other scene", |s| {
        s.stage == Stage::Converged && s.scene().is_some_and(|scene| scene.name == "cornell")
    });
    assert_eq!((&opened.settings, &watched.session.settings()), (&other, &other));
}
