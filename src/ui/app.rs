//! The window as a whole: what it holds, and the order of a frame.

use super::adoption::LeftBehind;
use super::auditor::Auditor;
use super::background::Background;
use super::camera_control::CameraControl;
use super::command::EditKey;
use super::daylight::{Day, DayPlaying};
use super::daylight_factor::{Factors, Of};
use super::doctor::Doctor;
use super::exposure::AutoExposure;
use super::files::Files;
use super::fonts::Unreadable;
use super::frame_clock::FrameClock;
use super::history::History;
use super::lampless::Lampless;
use super::leaving::{Leaving, Work};
use super::microscope::Microscope;
use super::overlay::Notice;
use super::panels::{self, Commands, Model};
use super::path_dialog::{Answer, PathDialog, Purpose};
use super::picture::Picture;
use super::reclaim::Reclaim;
use super::recovery::{Handover, Legacy};
use super::state::{DisplaySettings, Edits, UiState, Visit};
use super::touring::{Plan, Playing};
use super::viewport::Viewport;
use super::worker::Worker;
use super::{input, theme};
use crate::display::FalseColour;
use crate::navigation::Tour;
use crate::scene::{Lighting, Scene, SceneSource, View};
use crate::session::Snapshot;
use std::sync::{Arc, Weak};

/// Where the window keeps its state between starts.
const STORAGE_KEY: &str = "lumenwalk";

/// Patches under a grid of rays over the view, looked for again when the camera moves.
#[derive(Default)]
pub(super) struct Seen {
    pub(super) patches: Vec<u32>,
    pub(super) from: Option<(crate::navigation::Camera, u64)>,
}

/// A scene that was asked for, and what the worker had published then.
pub(super) struct Asked {
    pub(super) name: String,
    pub(super) source: SceneSource,
    pub(super) serial: u64,
    pub(super) known_error: Option<String>,
    pub(super) scene: Weak<Scene>,
}

impl Asked {
    /// Whether the worker has it: every reading makes another scene, and one of before may come in between.
    pub(super) fn has_come(&self, now: &Snapshot) -> bool {
        let is_it = |scene: &Arc<Scene>| {
            Arc::as_ptr(scene) != self.scene.as_ptr() && scene.source.is_same_model(&self.source)
        };
        now.scene().is_some_and(is_it)
    }
}

/// The window.
pub struct App {
    pub(super) worker: Box<dyn Worker>,
    pub(super) snapshot: Arc<Snapshot>,
    pub(super) state: UiState,
    pub(super) visit: Visit,
    /// What is in the sidecar of the scene, or on its way there.
    pub(super) saved: Work,
    pub(super) saving: Option<Work>,
    /// The scene is about to be left.
    pub(super) leaving: Option<Leaving>,
    /// The window closes without another question.
    pub(super) may_close: bool,
    unreadable: Unreadable,
    pub(super) edits: Edits,
    pub(super) history: History<EditKey, Edits>,
    pub(super) picture: Picture,
    pub(super) camera: Option<CameraControl>,
    pub(super) views: Vec<View>,
    /// The bookmark to start from.
    pub(super) start_view: usize,
    pub(super) exposure: AutoExposure,
    pub(super) seen: Seen,
    pub(super) scale: Option<FalseColour>,
    pub(super) inspected: Option<u32>,
    /// It was picked just now: its numbers scroll into view.
    pub(super) inspect_fresh: bool,
    /// Patches looked into before, the last one at the end.
    pub(super) past_picks: Vec<u32>,
    pub(super) microscope: Microscope,
    /// The display before the row of a patch was put on the scene.
    pub(super) before_row: Option<DisplaySettings>,
    /// The numbers that false colours show now, one a patch.
    pub(super) shown_values: Vec<f32>,
    /// Gains per band of the picture shown last.
    pub(super) gains: [f32; 3],
    /// The lamp that stands alone, and the lamps before.
    pub(super) solo: Option<(usize, Lighting)>,
    pub(super) notice: Option<Notice>,
    pub(super) last_change: String,
    /// What was asked for and is neither read nor refused yet.
    pub(super) opening: Option<Asked>,
    /// The last one that was asked for, whether it could be read or not.
    pub(super) asked_for: Option<SceneSource>,
    /// What the title bar says.
    pub(super) title: String,
    pub(super) auditor: Auditor,
    pub(super) doctor: Doctor,
    pub(super) files: Files,
    pub(super) path_dialog: Option<PathDialog>,
    pub(super) help_open: bool,
    pub(super) viewport: Option<Viewport>,
    pub(super) view_rect: egui::Rect,
    /// Where the present light begins beside A, as a share of the width of the view.
    pub(super) divider: f32,
    /// The tour that plays.
    pub(super) touring: Option<Playing>,
    /// What the daylight that is asked for comes to.
    pub(super) day: Option<Day>,
    /// The day that plays.
    pub(super) day_playing: Option<DayPlaying>,
    /// Daylight factors of the solve that ended last.
    pub(super) factors: Background<Of, Option<Arc<Factors>>>,
    /// The tour whose ways were found last.
    pub(super) tours: Background<Plan, Option<Tour>>,
    pub(super) clock: FrameClock,
    pub(super) lampless: Lampless,
    pub(super) reclaim: Reclaim,
    /// Where an orbit started: the point under the cursor.
    pub(super) pivot: Option<glam::DVec3>,
    /// The mesh, its light or the display changed since the last upload.
    pub(super) stale: Stale,
    /// A picture was asked for; where it goes.
    pub(super) screenshot: Option<std::path::PathBuf>,
    /// The next frame is to be read back.
    pub(super) screenshot_wanted: bool,
    screenshot_arrived: Arc<std::sync::Mutex<Option<Arc<egui::ColorImage>>>>,
    /// The scene that lamps, materials and views belong to.
    pub(super) scene_shown: Option<Arc<Scene>>,
    /// What was done to lamps and materials that the last reading of the file lacks.
    pub(super) left_behind: Option<LeftBehind>,
    /// The bookmark gone to last.
    pub(super) view_index: Option<usize>,
    /// Pixels of the view across and down.
    pub(super) view_size_px: [u32; 2],
    /// A message that the user took away, so that it does not come back.
    pub(super) dismissed: Option<String>,
    /// The error of the worker that was shown last.
    pub(super) worker_error: Option<String>,
    /// What a window before this one left, until its scene is on screen.
    pub(super) inherited: Option<Handover>,
    /// Where this one leaves its state.
    pub(super) legacy: Option<Legacy>,
    /// Seconds of the window's clock at the last frame.
    pub(super) time: f64,
    frame_secs: f64,
    memory: (f64, Option<u64>),
}

/// What has to go to the graphics card before the next frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stale {
    pub(super) mesh: bool,
    pub(super) light: bool,
    /// The exposure must jump: the light changed.
    pub(super) exposure: bool,
}

impl App {
    /// The same where this scene has been asked for.
    #[must_use]
    pub fn asking_for(mut self, source: SceneSource) -> Self {
        self.asked_for = Some(source);
        self
    }

    /// A window on `worker`, as the user likes it.
    ///
    /// Without a graphics adapter (in tests) everything but the picture works.
    pub fn new(cc: &eframe::CreationContext<'_>, worker: Box<dyn Worker>, state: UiState) -> Self {
        let display = DisplaySettings::preferring(state.preferences);
        theme::apply(&cc.egui_ctx);
        cc.egui_ctx.add_plugin(input::TabKey::default());
        let clock = FrameClock::default();
        let viewport = cc
            .wgpu_render_state
            .clone()
            .map(|gpu| Viewport::new(gpu, &display, clock.drawing(), &cc.egui_ctx));
        Self {
            snapshot: worker.latest(),
            worker,
            edits: Edits { display, ..Edits::default() },
            visit: Visit::default(),
            saved: Work::default(),
            saving: None,
            leaving: None,
            may_close: false,
            unreadable: Unreadable::of(&cc.egui_ctx),
            history: History::default(),
            picture: Picture::new(viewport.as_ref().map(Viewport::uploader)),
            camera: None,
            views: Vec::new(),
            start_view: 0,
            exposure: AutoExposure::default(),
            seen: Seen::default(),
            scale: None,
            inspected: None,
            inspect_fresh: false,
            past_picks: Vec::new(),
            microscope: Microscope::default(),
            before_row: None,
            shown_values: Vec::new(),
            gains: [1.0; 3],
            solo: None,
            notice: None,
            last_change: String::new(),
            opening: None,
            asked_for: None,
            title: String::new(),
            auditor: Auditor::default(),
            doctor: Doctor::default(),
            files: Files::new(cc.egui_ctx.clone()),
            path_dialog: None,
            help_open: false,
            viewport,
            view_rect: egui::Rect::ZERO,
            divider: 0.5,
            day: None,
            day_playing: None,
            factors: Background::default(),
            touring: None,
            tours: Background::default(),
            clock,
            lampless: Lampless::default(),
            reclaim: Reclaim::default(),
            pivot: None,
            stale: Stale::default(),
            screenshot: None,
            screenshot_wanted: false,
            screenshot_arrived: Arc::default(),
            scene_shown: None,
            left_behind: None,
            view_index: None,
            view_size_px: [1, 1],
            dismissed: None,
            worker_error: None,
            inherited: None,
            legacy: None,
            time: 0.0,
            frame_secs: 0.0,
            memory: (f64::NEG_INFINITY, None),
            state,
        }
    }

    /// What the last start left behind of the user's preferences.
    pub fn stored_state(storage: Option<&dyn eframe::Storage>) -> UiState {
        storage.and_then(|s| eframe::get_value(s, STORAGE_KEY)).unwrap_or_default()
    }

    /// The lamps as they stand.
    pub fn lighting(&self) -> &Lighting {
        &self.edits.lighting
    }

    /// What the user has changed.
    pub fn edits(&self) -> &Edits {
        &self.edits
    }

    /// What the window remembers.
    pub fn state(&self) -> &UiState {
        &self.state
    }

    /// How the present scene is looked at.
    pub fn visit(&self) -> &Visit {
        &self.visit
    }

    /// The light of the patches as it is shown.
    pub fn light(&self) -> &crate::solver::PatchLight {
        &self.picture.light
    }

    /// The patch looked into.
    pub fn inspected(&self) -> Option<u32> {
        self.inspected
    }

    /// The numbers that false colours show, one a patch; [`crate::display::NO_VALUE`] where there is
    /// none. Empty while the picture is shown.
    pub fn shown_values(&self) -> &[f32] {
        &self.shown_values
    }

    /// Where the camera stands, once a scene is shown.
    pub fn camera(&self) -> Option<crate::navigation::Camera> {
        let control = self.camera.as_ref()?;
        let aspect = f64::from(self.view_size_px[0]) / f64::from(self.view_size_px[1]);
        Some(crate::navigation::Camera {
            eye: control.pose().eye,
            forward: control.forward(),
            up: control.up(),
            fov_y_deg: fitted_fov(control.pose().fov_y_deg, aspect),
        })
    }

    /// Writes the picture that egui has read back, cut to the view.
    pub(super) fn take_screenshot(&mut self) {
        let arrived = self.screenshot_arrived.lock().ok().and_then(|mut slot| slot.take());
        if let Some(image) = arrived
            && let Some(path) = self.screenshot.take()
        {
            let cut = image.region(&self.view_rect, None);
            self.files.save_picture(path, cut);
        }
    }

    /// Asks egui for the pixels of this frame.
    pub(super) fn request_screenshot(&self, ctx: &egui::Context) {
        let (slot, wake) = (Arc::clone(&self.screenshot_arrived), ctx.clone());
        ctx.request_screenshot(move |image| {
            if let Ok(mut slot) = slot.lock() {
                *slot = Some(image);
            }
            wake.request_repaint();
        });
    }

    fn panels(&mut self, ui: &mut egui::Ui, out: &mut Commands) {
        let (mut left_open, mut right_open) = (self.state.left_open, self.state.right_open);
        let model = self.model();
        let ground = egui::Frame::new().fill(ui.visuals().panel_fill);
        let bar = ground.inner_margin(egui::Margin::symmetric(8, 4));
        egui::Panel::top("menu").frame(bar).show(ui, |ui| panels::menu::show(ui, &model, out));
        if self.state.show_status {
            let bar = ground.inner_margin(egui::Margin::symmetric(8, 2));
            egui::Panel::bottom("status").frame(bar).show(ui, |ui| panels::status::show(ui, &model));
        }
        let side =
            |panel: egui::Panel| panel.resizable(false).exact_size(theme::PANEL_WIDTH).drag_to_open(false);
        side(egui::Panel::left("left")).show_collapsible(ui, &mut left_open, |ui| {
            scroll(ui, "left scroll", |ui| {
                panels::section(ui, "Lights", true, |ui| panels::lights::show(ui, &model, out));
                panels::section(ui, "Daylight", true, |ui| panels::daylight::show(ui, &model, out));
                panels::section(ui, "Views", true, |ui| panels::views::show(ui, &model, out));
                panels::section(ui, "Materials", true, |ui| panels::materials::show(ui, &model, out));
            });
        });
        side(egui::Panel::right("right")).show_collapsible(ui, &mut right_open, |ui| {
            scroll(ui, "right scroll", |ui| {
                // Picking opens the panel at the top: nothing above it can grow and push it away.
                if model.inspected.is_some() {
                    if model.inspect_fresh {
                        ui.scroll_to_cursor(Some(egui::Align::TOP));
                    }
                    panels::section(ui, "Inspect", true, |ui| panels::inspect::show(ui, &model, out));
                }
                panels::section(ui, "Solver", true, |ui| panels::solver::show_or_hint(ui, &model, out));
                panels::section(ui, "Accuracy", true, |ui| panels::accuracy::show(ui, &model, out));
                panels::section(ui, "Display", true, |ui| panels::display::show(ui, &model, out));
                if model.inspected.is_none() {
                    panels::section(ui, "Inspect", true, |ui| panels::inspect::show(ui, &model, out));
                }
            });
        });
        if self.visit.table_open {
            let frame = ground.inner_margin(egui::Margin::symmetric(8, 5));
            let panel = egui::Panel::bottom("patch table").resizable(true).default_size(196.0);
            panel.size_range(110.0..=420.0).frame(frame).show(ui, |ui| panels::table::show(ui, &model, out));
        }
        if self.visit.doctor_open {
            let frame = egui::Frame::new().fill(theme::PANEL).inner_margin(egui::Margin::symmetric(8, 5));
            let panel = egui::Panel::bottom("doctor").resizable(true).default_size(212.0);
            panel.size_range(120.0..=420.0).frame(frame).show(ui, |ui| panels::doctor::show(ui, &model, out));
        }
        if self.help_open {
            panels::help::show(ui, out);
        }
    }

    /// What panels show in this frame.
    pub(super) fn model(&self) -> Model<'_> {
        let prepared = self.picture.prepared.as_deref();
        Model {
            snapshot: &self.snapshot,
            settings: self.worker.settings(),
            scene: prepared.map(|p| &*p.scene),
            mesh: prepared.map(|p| &*p.mesh),
            light: &self.picture.light,
            power: self.picture.power,
            display_seconds: self.picture.display_seconds,
            light_version: self.picture.light_version,
            reflectance: &self.picture.reflectance,
            aspect: prepared.map_or(&[], |p| &p.aspect),
            full_lumens: prepared.map_or(&[], |p| &p.full_lumens),
            edits: &self.edits,
            state: &self.state,
            visit: &self.visit,
            unreadable: &self.unreadable,
            views: &self.views,
            start_view: self.start_view,
            view_here: self.view_here(),
            scale: self.scale,
            ev: self.exposure_in_force().ev100,
            fov_deg: self.camera.as_ref().map_or(60.0, |c| c.pose().fov_y_deg),
            inspected: self.inspected,
            inspect_fresh: self.inspect_fresh,
            can_go_back: !self.past_picks.is_empty(),
            microscope: &self.microscope,
            exposure: self.exposure_in_force(),
            gains: self.gains,
            shown_values: &self.shown_values,
            daylight_factors: self.daylight_factors().map(|factors| factors.of_patches.as_slice()),
            solo: self.solo.as_ref().map(|(lamp, _)| *lamp),
            has_comparison: self.picture.has_comparison(),
            day: self.day.as_ref(),
            is_day_playing: self.day_playing.is_some(),
            tour: self.touring.as_ref().map(Playing::progress),
            can_tour: self.can_tour(),
            longest_secs: self.clock.longest(),
            last_change: &self.last_change,
            auditor: &self.auditor,
            doctor: &self.doctor,
            is_adding_lamps: self.lampless.is_searching(),
            can: [self.history.can_undo(), self.history.can_redo()],
            frame_secs: self.frame_secs,
            memory: self.memory.1,
        }
    }

    fn ask_for_path(&mut self, ui: &egui::Ui) {
        let Some(mut dialog) = self.path_dialog.take() else { return };
        match (dialog.show(ui), dialog.purpose) {
            (Answer::Waiting, _) => self.path_dialog = Some(dialog),
            (Answer::Cancelled, _) => self.has_failed_to_save(),
            (Answer::Path(path), Purpose::Scene) => self.leave_for(SceneSource::File(path)),
            (Answer::Path(path), Purpose::Weather) => self.take_weather(&path),
            (Answer::Path(path), Purpose::Save(kind)) => self.save_to(kind, path),
        }
    }

    fn measure_costs(&mut self, ctx: &egui::Context, frame: &eframe::Frame) {
        if let Some(secs) = frame.info().cpu_usage {
            self.frame_secs += (f64::from(secs) - self.frame_secs) * 0.2;
        }
        let time = ctx.input(|i| i.time);
        self.time = time;
        if time - self.memory.0 > 1.0 {
            self.memory = (time, resident_bytes());
        }
    }
}

impl eframe::App for App {
    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        self.clock.begin_frame(&self.snapshot.stage);
        self.measure_costs(ctx, frame);
        self.listen(ctx);
        self.play_day(ctx, ctx.input(|i| f64::from(i.unstable_dt)));
        self.guard_the_exit(ctx);
        self.clock.rest();
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.clock.resume();
        let mut out = Commands::new();
        if input::take_tab(ui.ctx()) {
            out.push(super::command::Command::TogglePanels);
        }
        if self.leaving.is_none() {
            input::commands(ui.ctx(), &self.model(), self.help_open, &mut out);
        }
        let unreadable = self.unreadable.count();
        self.dropped_files(ui, &mut out);
        self.panels(ui, &mut out);
        self.inspect_fresh = false;
        self.doctor.hovered = None;
        // Before the picture is drawn: a switched lamp is dark in this very frame.
        self.execute_all(ui.ctx(), &mut out);
        let pointer_up = ui.input(|i| !i.pointer.any_down());
        if pointer_up {
            self.history.seal();
        }
        egui::CentralPanel::no_frame().show(ui, |ui| self.show_view(ui, &mut out));
        self.ask_for_path(ui);
        self.ask_before_leaving(ui);
        let any = !out.is_empty() || self.unreadable.count() != unreadable;
        self.execute_all(ui.ctx(), &mut out);
        if any {
            ui.ctx().request_repaint();
        }
        self.clock.rest();
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, STORAGE_KEY, &self.state);
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        // Panels do not fill their ground again: see `theme::leave_ground_to_the_clear`.
        theme::PANEL.to_normalized_gamma_f32()
    }
}

/// Narrowest view, width over height, that a field of view is meant for.
const MEANT_ASPECT: f64 = 1.45;

/// The vertical field of view, degrees, with which a narrower view keeps what a bookmark shows
/// from left to right.
fn fitted_fov(fov_y_deg: f64, aspect: f64) -> f64 {
    let narrow = (MEANT_ASPECT / aspect.max(0.1)).max(1.0);
    let half = (0.5 * fov_y_deg.to_radians()).tan() * narrow;
    (2.0 * half.atan().to_degrees()).min(140.0)
}

fn scroll(ui: &mut egui::Ui, name: &str, contents: impl FnOnce(&mut egui::Ui)) {
    // Says what is behind, painted or cleared: lines fade into it where there is more to scroll to.
    let behind = egui::UiStackInfo { frame: egui::Frame::new().fill(theme::PANEL), ..Default::default() };
    ui.scope_builder(egui::UiBuilder::new().ui_stack_info(behind), |ui| {
        egui::ScrollArea::vertical().id_salt(name).auto_shrink(false).show(ui, |ui| {
            // Room for the scroll bar, so that nothing is clipped and nothing jumps.
            ui.set_max_width(ui.available_width() - 8.0);
            contents(ui);
        });
    });
}

/// Memory that this process holds, bytes; known on Linux.
fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| kb * 1024)
}

#[cfg(test)]
mod tests {
    use super::fitted_fov;

    #[test]
    fn a_narrow_view_keeps_the_width_and_a_wide_one_the_height() {
        assert!((fitted_fov(50.0, 1.6) - 50.0).abs() < 1e-9);
        let width = |fov: f64, aspect: f64| (0.5 * fov.to_radians()).tan() * aspect;
        let narrow = fitted_fov(50.0, 1.0);
        assert!((width(narrow, 1.0) - width(50.0, 1.45)).abs() < 1e-9, "{narrow}");
        assert!(fitted_fov(110.0, 0.2) <= 140.0);
    }
}
