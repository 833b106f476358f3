//! A small solved scene and a worker that only counts what it is asked for.

use egui::{Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::direct::Focus;
use lumenwalk::scene::{self, DaylightChoice, PlacedLamp, Scene, SceneSource};
use lumenwalk::session::{MaterialEdit, Snapshot};
use lumenwalk::solve::{self, Control, SolveSettings, Timings};
use lumenwalk::solver::SweepReport;
use lumenwalk::ui::{App, UiState, Worker};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, OnceLock};
use std::time::Duration;

/// A room of 4 m x 3 m x 2.5 m with a ceiling lamp, a lamp on the floor and a grey box.
const OBJ: &str = "mtllib room.mtl
v 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3
v 0 2.5 0\nv 4 2.5 0\nv 4 2.5 3\nv 0 2.5 3
v 1.5 2.49 1\nv 2.5 2.49 1\nv 2.5 2.49 2\nv 1.5 2.49 2
v 3.2 0.01 0.4\nv 3.6 0.01 0.4\nv 3.6 0.01 0.8\nv 3.2 0.01 0.8
o room\nusemtl plaster
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 4 8 7 3
usemtl brick\nf 1 5 8 4
o Ceiling\nusemtl warm\nf 9 10 11 12
o Floor\nusemtl cold\nf 16 15 14 13
";
const MTL: &str = "newmtl plaster\nKd 0.8 0.8 0.8
newmtl brick\nKd 0.6 0.3 0.2
newmtl warm\nKd 0.8 0.8 0.8\nKe 12 8 4
newmtl cold\nKd 0.8 0.8 0.8\nKe 4 6 9
";
const SIDECAR: &str = r#"
[[luminaire]]
name = "Ceiling lamp"
object = "Ceiling"
[[luminaire]]
name = "Floor lamp"
object = "Floor"
[[view]]
name = "Door"
eye = [0.4, 1.6, 2.6]
target = [2.6, 1.9, 1.0]
fov = 70.0
"#;

/// The scene solved once for all tests of a file.
pub(crate) fn solved() -> Arc<Snapshot> {
    static SOLVED: OnceLock<Arc<Snapshot>> = OnceLock::new();
    let solve = || {
        let folder = tempfile::tempdir().expect("a folder");
        solution_of(&write_model(folder.path()))
    };
    Arc::clone(SOLVED.get_or_init(solve))
}

/// The scene with a window to the south, under a clear morning sky, solved once for all tests of a file.
pub(crate) fn solved_by_day() -> Arc<Snapshot> {
    static SOLVED: OnceLock<Arc<Snapshot>> = OnceLock::new();
    let daylight = "[daylight]\nsun = [35, 150]\nsky = \"clear\"\nlux = [60000, 12000]\n";
    Arc::clone(SOLVED.get_or_init(|| under_sky(daylight)))
}

/// The scene with a window of 1.2 x 1 m in its south wall (+z), under the sky of these lines of a sidecar.
pub(crate) fn under_sky(daylight: &str) -> Arc<Snapshot> {
    let folder = tempfile::tempdir().expect("a folder");
    let model = write_model(folder.path());
    let window = "v 1.4 1 3\nv 2.6 1 3\nv 2.6 2 3\nv 1.4 2 3\no Window\nusemtl plaster\n\
                  f 4 17 18 3\nf 3 18 19 7\nf 7 19 20 8\nf 8 20 17 4\n";
    std::fs::write(&model, OBJ.replace("f 4 8 7 3\n", "") + window).expect("written");
    std::fs::write(model.with_extension("toml"), format!("{SIDECAR}{daylight}")).expect("written");
    solution_of(&model)
}

/// Writes the small scene to a folder; where its model is.
pub(crate) fn write_model(folder: &Path) -> PathBuf {
    for (name, text) in [("room.obj", OBJ), ("room.mtl", MTL), ("room.toml", SIDECAR)] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    folder.join("room.obj")
}

/// The snapshot of a finished solve of a model.
pub(crate) fn solution_of(model: &Path) -> Arc<Snapshot> {
    solution(&SceneSource::File(model.to_owned()))
}

/// The snapshot of a finished solve.
pub(crate) fn solution(source: &SceneSource) -> Arc<Snapshot> {
    let scene = scene::load(source).expect("a scene");
    let settings = SolveSettings { patches: lumenwalk::mesh::PatchTarget::Count(700), ..Default::default() };
    let never = AtomicBool::new(false);
    let mut solution =
        solve::solve(Arc::new(scene), &settings, &never, &mut |_| Control::Continue).expect("solved");
    solution.sweeps = (1..=6).map(sweep).collect();
    // Pictures of the window show no times.
    let timings = Timings::default();
    Arc::new(Snapshot { serial: 1, mesh_serial: 1, timings, ..Snapshot::of(solution) })
}

/// Reports that stay the same whatever the solver learns: pictures of the window show them.
fn sweep(number: u32) -> SweepReport {
    let residual = 0.05 * 0.2_f64.powi(number as i32);
    let (error_bound, seconds) = (4.0 * residual, 0.01 * f64::from(number));
    SweepReport { sweep: number, residual, error_bound, emitted: 84.9, absorbed: 84.8, escaped: 0.1, seconds }
}

/// What a worker was asked for, and what it shows.
#[derive(Default)]
struct Log {
    requests: Vec<String>,
    snapshot: Arc<Snapshot>,
    settings: Option<SolveSettings>,
    leisure: Option<(bool, Option<Focus>)>,
}

/// A worker that solves nothing.
#[derive(Clone, Default)]
pub(crate) struct Counting(Arc<Mutex<Log>>);

impl Counting {
    pub(crate) fn showing(snapshot: Arc<Snapshot>) -> Self {
        Self(Arc::new(Mutex::new(Log { snapshot, ..Log::default() })))
    }

    pub(crate) fn publish(&self, change: impl FnOnce(&mut Snapshot)) {
        let mut log = self.0.lock().expect("no panic while locked");
        let mut snapshot = Snapshot::clone(&log.snapshot);
        snapshot.serial += 1;
        change(&mut snapshot);
        log.snapshot = Arc::new(snapshot);
    }

    pub(crate) fn requests(&self) -> Vec<String> {
        self.0.lock().expect("no panic while locked").requests.clone()
    }

    /// Whether light is to be refined, and for whom.
    pub(crate) fn leisure(&self) -> Option<(bool, Option<Focus>)> {
        self.0.lock().expect("no panic while locked").leisure
    }

    fn note(&self, request: String) {
        self.0.lock().expect("no panic while locked").requests.push(request);
    }
}

impl Worker for Counting {
    fn latest(&self) -> Arc<Snapshot> {
        Arc::clone(&self.0.lock().expect("no panic while locked").snapshot)
    }
    fn open(&self, source: SceneSource) {
        self.note(format!("open {source}"));
    }
    fn open_with(&self, source: SceneSource, settings: SolveSettings) {
        self.note(format!("open {source}"));
        self.0.lock().expect("no panic while locked").settings = Some(settings);
    }
    fn set_settings(&self, settings: SolveSettings) {
        self.note(format!("settings {:?} {:?}", settings.method, settings.patches));
        self.0.lock().expect("no panic while locked").settings = Some(settings);
    }
    fn settings(&self) -> SolveSettings {
        let log = self.0.lock().expect("no panic while locked");
        log.settings.as_ref().unwrap_or(&log.snapshot.settings).clone()
    }
    fn set_materials(&self, _scene: &Arc<Scene>, edits: Vec<MaterialEdit>) {
        self.note(format!("materials {}", edits.len()));
    }
    fn set_lamps(&self, _read: &Arc<Scene>, lamps: Vec<PlacedLamp>) {
        self.note(format!("lamps {}", lamps.len()));
    }
    fn set_daylight(&self, _read: &Arc<Scene>, choice: Option<DaylightChoice>) {
        self.note(format!("daylight {}", choice.and_then(|choice| choice.time).unwrap_or_default()));
    }
    fn pause(&self) {
        self.note("pause".to_owned());
    }
    fn resume(&self) {
        self.note("resume".to_owned());
    }
    fn stop(&self) {
        self.note("stop".to_owned());
    }
    fn refine_at_leisure(&self, on: bool, focus: Option<Focus>) {
        self.0.lock().expect("no panic while locked").leisure = Some((on, focus));
    }
}

/// A window of 1280 x 800 on the solved scene, run until the scene is on screen.
pub(crate) fn window(worker: &Counting, drawn: bool) -> Harness<'static, App> {
    let worker = worker.clone();
    let builder = Harness::builder().with_size([1280.0, 800.0]);
    let builder = if drawn { builder.wgpu() } else { builder };
    let state = UiState { show_status: false, hint_done: true, ..UiState::default() };
    let mut harness = builder.build_eframe(|cc| App::new(cc, Box::new(worker), state));
    for _ in 0..2000 {
        harness.step();
        if harness.state().camera().is_some() {
            break;
        }
        // The mesh is prepared on a thread of its own.
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(harness.state().camera().is_some(), "the scene came to the screen");
    harness.run_steps(4);
    harness
}

/// Whether there is a graphics adapter; says so where a test has to be skipped.
pub(crate) fn has_adapter(test: &str) -> bool {
    match lumenwalk::render::Gpu::headless() {
        Ok(_) => true,
        Err(error) => {
            assert!(std::env::var_os("LUMENWALK_REQUIRE_GPU").is_none(), "{test} needs an adapter: {error}");
            println!("{test}: skipped, no graphics adapter ({error})");
            false
        }
    }
}

/// Clicks the control of this name.
pub(crate) fn click(harness: &mut Harness<'_, App>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

/// Presses and releases a key.
pub(crate) fn press(harness: &mut Harness<'_, App>, key: Key) {
    harness.key_press(key);
    harness.run_steps(3);
}

/// Where a patch appears in the window.
pub(crate) fn place_of(harness: &Harness<'_, App>, patch: u32) -> Pos2 {
    let mesh = solved().mesh().cloned().expect("meshed");
    let rect = harness.get_by_label("Scene view").rect();
    let size = [rect.width() as u32, rect.height() as u32];
    let centre = mesh.patches[patch as usize].centre;
    let at = harness.state().camera().expect("shown").project(centre, size).expect("in front");
    rect.min + egui::vec2(at.x as f32, at.y as f32)
}

/// Where a patch of this luminaire appears in the window.
pub(crate) fn place_of_lamp(harness: &Harness<'_, App>, luminaire: u32) -> Pos2 {
    let mesh = solved().mesh().cloned().expect("meshed");
    let patch = mesh.patches.iter().position(|p| p.luminaire == Some(luminaire)).expect("it shines");
    place_of(harness, patch as u32)
}

/// Moves the mouse there and clicks.
pub(crate) fn click_at(harness: &mut Harness<'_, App>, at: Pos2, modifiers: Modifiers) {
    harness.hover_at(at);
    harness.run_steps(2);
    for pressed in [true, false] {
        let button = egui::PointerButton::Primary;
        let event = egui::Event::PointerButton { pos: at, button, pressed, modifiers };
        harness.event_modifiers(event, modifiers);
        harness.step();
    }
    harness.run_steps(3);
}

/// Lets frames pass until `done` says so: helper threads need a while.
pub(crate) fn wait_until(
    harness: &mut Harness<'_, App>,
    what: &str,
    done: impl Fn(&Harness<'_, App>) -> bool,
) {
    for _ in 0..2000 {
        harness.step();
        if done(harness) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("{what} never came");
}

/// Scrolls a panel until this is in view.
pub(crate) fn reveal(harness: &mut Harness<'_, App>, name: &str) {
    harness.get_by_label(name).scroll_to_me();
    harness.run_steps(20);
}

/// The scene on screen, read again with changes.
pub(crate) fn read_again(worker: &Counting, change: impl FnOnce(&mut Scene)) {
    worker.publish(|s| {
        let solution = s.solution_mut().expect("a scene");
        change(Arc::make_mut(&mut solution.scene));
        s.mesh_serial += 1;
    });
}

/// Whether these words are on screen.
pub(crate) fn says(harness: &Harness<'_, App>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}
