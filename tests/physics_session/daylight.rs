//! Another hour over the same scene: what it leaves standing, and that its light is that of a scene read at that hour.

use crate::watched::{Held, Watched};
use lumenwalk::scene::{DaylightChoice, Scene, SceneSource, load};
use lumenwalk::session::Snapshot;
use lumenwalk::solve::{Solution, SolveSettings, Stage};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const OBJ: &str = "mtllib room.mtl\n\
    v 0 0 0\nv 4 0 0\nv 4 5 0\nv 0 5 0\nv 0 0 3\nv 4 0 3\nv 4 5 3\nv 0 5 3\n\
    v 1 0 1\nv 3 0 1\nv 3 0 2.4\nv 1 0 2.4\n\
    v 1 2 0\nv 2 2 0\nv 2 2 1\nv 1 2 1\nv 1 2.05 0\nv 2 2.05 0\nv 2 2.05 1\nv 1 2.05 1\n\
    v -12 -12 -0.2\nv 16 -12 -0.2\nv 16 17 -0.2\nv -12 17 -0.2\n\
    v 1.6 2.6 2.99\nv 2.4 2.6 2.99\nv 2.4 3.4 2.99\nv 1.6 3.4 2.99\n\
    o shell\nusemtl white\nf 1 2 3 4\nf 8 7 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 3 2 6 7\n\
    f 1 2 10 9\nf 2 6 11 10\nf 6 5 12 11\nf 5 1 9 12\n\
    o board\nusemtl grey\nf 13 14 15 16\nf 20 19 18 17\nf 16 15 19 20\n\
    o lawn\nusemtl grey\nf 21 22 23 24\n\
    o lamp\nusemtl glow\nf 28 27 26 25\n";
const MTL: &str =
    "newmtl white\nKd 0.7 0.7 0.7\nnewmtl grey\nKd 0.3 0.3 0.3\nnewmtl glow\nKd 0.8 0.8 0.8\nKe 20 20 20\n";

/// A morning in Berlin.
fn morning() -> DaylightChoice {
    DaylightChoice {
        latitude: Some(52.52),
        longitude: Some(13.41),
        zone: Some(2.0),
        date: Some("2026-06-21".to_owned()),
        time: Some("09:00".to_owned()),
        ..DaylightChoice::default()
    }
}

fn at(time: &str) -> DaylightChoice {
    DaylightChoice { time: Some(time.to_owned()), ..morning() }
}

/// A room with a window to the south, a board, a lamp and a lawn, in a folder of its own.
fn room(folder: &Path, choice: Option<&DaylightChoice>) -> PathBuf {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    let daylight = choice.map_or_else(String::new, |choice| {
        format!("[daylight]\n{}", toml::to_string(choice).expect("plain values"))
    });
    write("room.obj", OBJ);
    write("room.mtl", MTL);
    write("room.toml", &format!("up = \"z\"\n{daylight}"));
    folder.join("room.obj")
}

fn settings() -> SolveSettings {
    SolveSettings { tolerance: 1e-5, ..crate::watched::coarse(900) }
}

fn opened(choice: &DaylightChoice) -> (tempfile::TempDir, Watched, Arc<Snapshot>) {
    let folder = tempfile::tempdir().expect("a folder");
    let watched = Watched::new();
    watched.session.set_settings(settings());
    let before = watched.session.latest();
    watched.session.open(SceneSource::File(room(folder.path(), Some(choice))));
    let first = watched.converged(&before);
    (folder, watched, first)
}

fn read(snapshot: &Snapshot) -> &Arc<Scene> {
    snapshot.read.as_ref().expect("a scene was read")
}

/// Waits until the light of this choice has settled.
#[track_caller]
fn lit(watched: &Watched, choice: &DaylightChoice) -> Arc<Snapshot> {
    let scene = Arc::clone(read(&watched.session.latest()));
    watched.session.set_daylight(&scene, Some(choice.clone()));
    watched.until("the light of that hour", |snapshot| {
        let there = snapshot.scene().and_then(|scene| scene.outdoors.as_ref());
        there.is_some_and(|outdoors| outdoors.choice == *choice) && snapshot.solved().is_some()
    })
}

/// RMS over the area of how far two lights are apart, of the mean of the second and of what is there, alike.
fn difference(one: &Solution, other: &Solution) -> f64 {
    let of = |solution: &Solution| solution.light(&solution.scene.lighting()).irradiance;
    let (a, b) = (of(one), of(other));
    assert_eq!(a.len(), b.len(), "the same patches");
    let areas: Vec<f64> = other.mesh.patches.iter().map(|patch| patch.area).collect();
    let whole: f64 = areas.iter().sum();
    let mean = b.iter().zip(&areas).map(|(h, area)| f64::from(h[1]) * area).sum::<f64>() / whole;
    let square = |((a, b), area): ((&[f32; 3], &[f32; 3]), &f64)| {
        let (a, b) = (f64::from(a[1]), f64::from(b[1]));
        area * (a - b).powi(2) / ((b + 0.1 * mean) * mean)
    };
    (a.iter().zip(&b).zip(&areas).map(square).sum::<f64>() / whole).sqrt()
}

fn fresh(choice: &DaylightChoice) -> Arc<Solution> {
    opened(choice).2.solved().expect("whole")
}

#[test]
fn another_hour_costs_no_row_and_no_mesh_and_has_the_light_of_a_scene_read_at_that_hour() {
    let (_folder, watched, first) = opened(&morning());
    let whole = first.solved().expect("whole");
    let rows = whole.computer.rows_computed();
    for time in ["12:30", "18:10", "09:00"] {
        let then = lit(&watched, &at(time));
        let done = then.last_change.expect("it tells what it did");
        assert!(done.daylight && !done.mesh && !done.scene && done.rows == 0, "{time}: {done:?}");
        let solution = then.solved().expect("whole");
        assert_eq!(
            (then.mesh_serial, solution.computer.rows_computed()),
            (first.mesh_serial, rows),
            "{time}"
        );
        assert!(Arc::ptr_eq(then.transport().unwrap(), first.transport().unwrap()));
        let off = difference(&solution, &fresh(&at(time)));
        println!("{time}: {:.3} % off, {:.0} ms in all", 100.0 * off, 1e3 * done.seconds);
        assert!(off < 0.02, "{time}: {off}");
    }
    // Where it began nothing is lost.
    let again = watched.session.latest().solved().expect("whole");
    let off = difference(&again, &whole);
    assert!(off < 1e-3, "{off}");
}

/// What surfaces that look down have of sky and sun, all of it reflected: a sum over patches.
fn passed_on(solution: &Solution) -> f32 {
    let bases = &solution.bases;
    let columns = bases.lamps * bases.bands;
    let looks_down = |i: &usize| solution.mesh.patches[*i].normal.y < -0.9;
    let daylight = |i: usize| -> f32 {
        // The lamp of the model comes first.
        bases.values[i * columns..(i + 1) * columns].iter().skip(bases.bands).sum()
    };
    (0..bases.patches).filter(looks_down).map(daylight).sum()
}

#[test]
fn another_hour_on_the_way_loses_neither_rows_nor_light() {
    let fresh = fresh(&at("12:30"));
    let (rows, whole) = (fresh.computer.rows_computed(), passed_on(&fresh));
    for stage in [Stage::Rows, Stage::Balancing] {
        let folder = tempfile::tempdir().expect("a folder");
        let held = Held::coarse();
        let model = SceneSource::File(room(folder.path(), Some(&morning())));
        held.hold_at(stage, |session| session.open_with(model, settings()));
        let latest = held.watched.session.latest();
        let scene = Arc::clone(read(&latest));
        // By this the light of the next hour is guessed.
        let light = latest.element_light().expect("direct light");
        assert!(light.arriving.iter().all(|&arriving| arriving > 0.0), "{stage:?}: {:?}", light.arriving);
        held.watched.session.set_daylight(&scene, Some(at("12:30")));
        held.go_on();
        let then = held.watched.until("the light of that hour", |snapshot| {
            let sum = snapshot.solution.as_deref().map_or(0.0, passed_on);
            assert!(sum > 0.6 * whole, "{stage:?}: {sum} of {whole} at {:?}", snapshot.stage);
            let there = snapshot.scene().and_then(|scene| scene.outdoors.as_ref());
            there.is_some_and(|outdoors| outdoors.choice == at("12:30")) && snapshot.solved().is_some()
        });
        let solution = then.solved().expect("whole");
        let computed = solution.computer.rows_computed();
        assert!(computed <= rows, "{stage:?}: {computed} rows for {rows}");
        let off = difference(&solution, &fresh);
        assert!(off < 0.02, "{stage:?}: {off}");
    }
}

#[test]
fn night_falls_and_the_day_comes_back() {
    let (_folder, watched, first) = opened(&at("23:30"));
    let dark = first.solved().expect("whole");
    let outdoors = dark.scene.outdoors.as_ref().expect("a sky");
    let lamps = dark.scene.lighting();
    assert_eq!(lamps.lamps[outdoors.sun as usize].output(), [0.0; 3]);
    let of_lamp = |solution: &Solution| {
        let mut lighting = solution.scene.lighting();
        for lamp in [outdoors.sky, outdoors.sun] {
            lighting.lamps[lamp as usize].on = false;
        }
        solution.light(&lighting).irradiance
    };
    let by_night = of_lamp(&dark);
    // The mesh of a night serves the day.
    let day = lit(&watched, &at("12:30")).solved().expect("whole");
    let off = difference(&day, &fresh(&at("12:30")));
    assert!(off < 0.03, "{off}");
    assert_eq!(of_lamp(&day), by_night, "the light of the lamp is left alone");
    let again = lit(&watched, &at("23:30")).solved().expect("whole");
    assert!(again.light(&again.scene.lighting()).irradiance.iter().flatten().all(|h| h.is_finite()));
    assert!(difference(&again, &dark) < 1e-3);
}

#[test]
fn the_sun_overhead_at_the_pole_and_from_the_north_and_skies_of_every_kind() {
    let (_folder, watched, _) = opened(&morning());
    let base = |sun: [f64; 2]| DaylightChoice { sun: Some(sun), ..DaylightChoice::default() };
    let pole = DaylightChoice { latitude: Some(90.0), longitude: Some(0.0), zone: Some(0.0), ..morning() };
    let turned = DaylightChoice { north: Some(117.0), ..at("15:00") };
    let uniform = DaylightChoice { sky: Some("uniform".to_owned()), ground: Some(0.0), ..at("10:00") };
    let bright = DaylightChoice { ground: Some(1.0), sky: Some("13".to_owned()), ..at("10:00") };
    let sunless = DaylightChoice { lux: Some([0.0, 9_000.0]), sky: Some("16".to_owned()), ..at("10:00") };
    for choice in [base([90.0, 0.0]), base([0.01, 0.0]), pole, turned, uniform, bright, sunless] {
        let solution = lit(&watched, &choice).solved().expect("whole");
        let light = solution.light(&solution.scene.lighting());
        assert!(light.irradiance.iter().flatten().all(|h| h.is_finite() && *h >= 0.0), "{choice:?}");
        let off = difference(&solution, &fresh(&choice));
        println!("{choice:?}: {:.3} %", 100.0 * off);
        assert!(off < 0.03, "{choice:?}: {off}");
    }
}

#[test]
fn what_is_refused_leaves_the_sky_that_stands() {
    let (_folder, watched, first) = opened(&morning());
    let wrong = DaylightChoice { date: Some("2026-02-30".to_owned()), ..morning() };
    watched.session.set_daylight(read(&first), Some(wrong));
    let refused = watched.until("a refusal", |snapshot| snapshot.error.is_some());
    assert!(Arc::ptr_eq(refused.scene().unwrap(), first.scene().unwrap()));
    let next = lit(&watched, &at("10:00"));
    assert_eq!(next.error, None);
}

#[test]
fn materials_hold_at_every_hour_whatever_scene_they_were_told_for() {
    let (_folder, watched, first) = opened(&morning());
    let noon = lit(&watched, &at("12:30"));
    watched.repaint(0, [0.2; 3]);
    let painted = watched.converged(&noon);
    let reflectance = painted.reflectance().expect("told").clone();
    assert_ne!(reflectance, *noon.reflectance().expect("told"));
    let evening = lit(&watched, &at("19:00"));
    assert_eq!(evening.reflectance(), Some(&reflectance));
    // By the scene of an hour that is over.
    let scene = Arc::clone(first.scene().unwrap());
    watched.session.set_materials(&scene, Vec::new());
    let plain = watched.converged(&evening);
    assert_eq!(plain.reflectance(), first.reflectance());
}

#[test]
fn a_sky_comes_over_a_scene_that_had_none_and_goes_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let watched = Watched::new();
    watched.session.set_settings(settings());
    let before = watched.session.latest();
    watched.session.open(SceneSource::File(room(folder.path(), None)));
    let first = watched.converged(&before);
    assert_eq!(first.scene().unwrap().luminaires.len(), 1);
    let day = lit(&watched, &morning()).solved().expect("whole");
    assert_eq!(day.scene.luminaires.len(), 3);
    assert!(difference(&day, &fresh(&morning())) < 0.02);
    watched.session.set_daylight(read(&first), None);
    let gone =
        watched.until("no sky", |s| s.scene().is_some_and(|s| s.outdoors.is_none()) && s.solved().is_some());
    assert_eq!(gone.scene().unwrap().luminaires.len(), 1);
}

#[test]
fn a_handle_that_is_dragged_is_answered_at_every_step_that_the_worker_takes_up() {
    let (_folder, watched, first) = opened(&morning());
    let scene = Arc::clone(read(&first));
    for minute in 0..40 {
        watched.session.set_daylight(&scene, Some(at(&format!("10:{minute:02}"))));
    }
    let last = lit(&watched, &at("10:45"));
    assert_eq!(last.error, None);
    assert!(difference(&last.solved().unwrap(), &fresh(&at("10:45"))) < 0.02);
}

#[test]
fn an_hour_has_the_same_bits_whatever_the_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = load(&SceneSource::File(room(folder.path(), Some(&morning())))).expect("a scene");
    let later = scene.with_daylight(Some(&at("17:00"))).expect("an hour");
    let outcomes = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            use lumenwalk::direct::{DirectLight, ElementSettings, Layout};
            use lumenwalk::mesh::{MeshSettings, PatchTarget, build};
            use lumenwalk::watch::Watch;
            let of = |scene: &Scene| {
                build(scene, &MeshSettings { target: PatchTarget::Count(900), ..MeshSettings::default() })
                    .expect("a mesh")
            };
            let (now, then) = (of(&scene), of(&later));
            let light = DirectLight::new(&now, true);
            let settings = ElementSettings {
                error: 0.005,
                most: 20_000,
                work: 10_000_000,
                exitance: light.emitters().bases.iter().map(|b| f64::from(b.lamp) + 100.0).collect(),
                smooth: true,
                focus: None,
                adapted: true,
            };
            let layout = Watch::nobody(|watch| Layout::build(&now, &light, &settings, watch)).expect("whole");
            let light = light.at_hour_of(&then);
            let lit = Watch::nobody(|watch| layout.lit(&then, &light, &settings, watch)).expect("whole");
            let values: Vec<(u32, u32)> = (0..lit.corners.len() as u32)
                .flat_map(|c| lit.light_at(c).iter().map(|&(basis, value)| (basis, value.to_bits())))
                .collect();
            (lit.elements.len(), values)
        })
    });
    assert!(outcomes[0] == outcomes[1]);
    assert!(outcomes[0].1.len() > 1_000);
}
