//! What the worker and the helper threads have brought since the last frame.

use super::app::{App, Asked};
use super::daylight::lighting_for;
use super::files::FileNews;
use super::microscope::Shown;
use super::overlay::{NOTICE_SECS, Notice};
use super::path_dialog::{PathDialog, Purpose};
use super::state::Quantity;
use super::{change, panels};
use crate::direct::Focus;
use crate::scene::{FrameChoice, Scene, SceneSource};
use crate::session::Snapshot;
use crate::solve::Stage;
use std::path::PathBuf;
use std::sync::Arc;

impl App {
    /// Takes over what the worker and the helper threads have brought.
    pub(super) fn listen(&mut self, ctx: &egui::Context) {
        let before = std::mem::replace(&mut self.snapshot, self.worker.latest());
        let wake = ctx.clone();
        let wake = move |seconds| wake.request_repaint_after_secs(seconds);
        self.follow_day();
        // A scene under another sky is read from the same file, and has as many lamps.
        let is_same_read = match (self.lampless.read(), &self.snapshot.read) {
            (Some(own), Some(read)) => Arc::ptr_eq(own, read),
            _ => false,
        };
        let (edits, day) = (&self.edits, self.day.as_ref());
        let lighting = |scene: &Arc<Scene>| match &self.scene_shown {
            Some(shown) if Arc::ptr_eq(shown, scene) => lighting_for(edits, day, scene),
            Some(_) if is_same_read && edits.lighting.lamps.len() == scene.luminaires.len() => {
                lighting_for(edits, day, scene)
            }
            _ => scene.lighting(),
        };
        let shading = self.edits.display.shading;
        let news = self.picture.follow(&self.snapshot, lighting, shading, &self.reclaim, wake);
        if news.mesh {
            self.adopt_scene();
        }
        self.follow_sky();
        if news.bases {
            self.follow_with_comparison(ctx.input(|i| i.time));
            // Switched while the light was made.
            self.settle_picture();
            self.stale.light = true;
            self.stale.exposure = true;
        }
        self.follow_lampless(ctx);
        self.follow_change(&before);
        self.reclaim.later(before);
        self.tell_title(ctx);
        self.follow_microscope(ctx);
        let time = ctx.input(|i| i.time);
        self.follow_error(time);
        self.look_after_device(ctx, time);
        self.audit(ctx, time);
        self.follow_daylight_factors(ctx);
        // On the way to a goal what is checked is to be what was solved.
        let at_leisure = self.state.refine_at_leisure && !self.auditor.is_reaching();
        self.worker.refine_at_leisure(at_leisure, self.focus());
        if let Some(prepared) = &self.picture.prepared {
            let wake = ctx.clone();
            self.doctor.follow(prepared, move || wake.request_repaint());
        }
        for news in self.files.news() {
            self.file_news(ctx, news, time);
        }
        if let Some(notice) = &self.notice
            && !notice.is_error
        {
            let left = NOTICE_SECS - (time - notice.since);
            if left <= 0.0 {
                self.notice = None;
            } else {
                ctx.request_repaint_after_secs(left as f32);
            }
        }
        self.take_screenshot();
    }

    /// Takes over what the worker says that it recomputed, once: what is switched afterwards is told instead.
    fn follow_change(&mut self, before: &Snapshot) {
        if self.opening.as_ref().is_some_and(|asked| asked.has_come(&self.snapshot)) {
            self.opening = None;
        }
        // After a refusal the solve goes back to where it was, and the worker still tells of that.
        let has_converged = before.stage != Stage::Converged
            && self.snapshot.stage == Stage::Converged
            && self.snapshot.error.is_none();
        if let Some(done) = &self.snapshot.last_change
            && (has_converged || self.snapshot.last_change != before.last_change)
        {
            self.last_change = change::words(done, self.snapshot.scene().map_or("", |scene| &scene.name));
        }
    }

    /// Names the scene in the title of the window.
    fn tell_title(&mut self, ctx: &egui::Context) {
        let title = match &self.scene_shown {
            Some(scene) => format!("{} - Lumenwalk", scene.name),
            None => "Lumenwalk".to_owned(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Asks the microscope for what is looked at.
    fn follow_microscope(&mut self, ctx: &egui::Context) {
        let Some(prepared) = &self.picture.prepared else { return };
        let quantity = self.edits.display.quantity;
        let shown = Shown {
            prepared,
            reflectance: &self.picture.reflectance,
            light: &self.picture.light,
            light_version: self.picture.light_version,
            lighting: &self.edits.lighting,
        };
        let maps = quantity.is_defect() || self.visit.table_open || self.inspected.is_some();
        let news = self.microscope.follow(&self.snapshot, &shown, self.inspected, maps, ctx);
        if news && (quantity.is_defect() || quantity.is_row()) {
            self.stale.light = true;
        }
    }

    /// Who looks at the scene.
    fn focus(&self) -> Option<Focus> {
        let camera = self.camera.as_ref()?;
        let [width, height] = self.view_size_px.map(|pixels| f64::from(pixels.max(1)));
        let across =
            (0.5 * camera.pose().fov_y_deg.to_radians()).tan() * (1.0 + (width / height).powi(2)).sqrt();
        Some(Focus { eye: camera.pose().eye, forward: camera.forward(), half_angle: across.atan() })
    }

    /// Lets the background check follow the light, and solves on where a goal asks for it.
    fn audit(&mut self, ctx: &egui::Context, time: f64) {
        let wake = ctx.clone();
        let wake = move || wake.request_repaint();
        let prepared = self.picture.prepared.as_ref();
        let is_current = prepared.is_some_and(|p| p.mesh_serial == self.snapshot.mesh_serial);
        let light = Some(&self.picture.light).filter(|l| is_current && !l.irradiance.is_empty());
        let known = self.auditor.findings.clone();
        let (next, again) = self.auditor.follow(&self.snapshot, &self.edits.lighting, light, time, wake);
        let same = match (&known, &self.auditor.findings) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.stale.light |= !same && self.edits.display.quantity == Quantity::Error;
        if let Some(settings) = next {
            self.worker.set_settings(settings);
        }
        if let Some(seconds) = again {
            ctx.request_repaint_after_secs(seconds as f32);
        }
    }

    /// Shows a new error of the worker, and takes it away once the worker has got over it.
    fn follow_error(&mut self, time: f64) {
        let shown = self.notice.as_ref().filter(|n| n.is_error).map(|n| n.text.as_str());
        let running = panels::solver::is_running(self.snapshot.stage);
        // The error of an earlier request stays in the snapshot until the next one is answered.
        let is_answered = |asked: &Asked| {
            asked.known_error != self.snapshot.error || self.snapshot.serial > asked.serial && !running
        };
        if self.opening.as_ref().is_some_and(|asked| self.snapshot.error.is_some() && !is_answered(asked)) {
            return;
        }
        match self.snapshot.error.as_deref() {
            Some(error) if shown != Some(error) && self.dismissed.as_deref() != Some(error) => {
                self.notice = Some(Notice { text: error.to_owned(), is_error: true, since: time });
                self.worker_error = Some(error.to_owned());
                if self.scene_shown.is_none() {
                    // Once it is mended, or written to the end, it is read again.
                    self.files.watch(self.asked_for.as_ref(), &[]);
                }
                match self.opening.take() {
                    Some(asked) => self.last_change = format!("{} was not opened", asked.name),
                    None if self.snapshot.stage == Stage::Failed => {
                        "not solved".clone_into(&mut self.last_change);
                    }
                    None => {}
                }
            }
            Some(_) => {}
            None => {
                // Should it come again, it is news.
                self.dismissed = None;
                if self.worker_error.is_some() && shown == self.worker_error.as_deref() {
                    (self.notice, self.worker_error) = (None, None);
                }
            }
        }
    }

    /// Watches the files of the scene that is shown from now on.
    fn watch_files(&mut self) {
        let scene = self.scene_shown.as_deref();
        let others = scene.map_or(&[][..], |scene| &scene.read_from);
        self.files.watch(scene.map(|scene| &scene.source), others);
    }

    fn file_news(&mut self, ctx: &egui::Context, news: FileNews, time: f64) {
        match news {
            FileNews::Opened(path) => self.leave_for(SceneSource::File(path)),
            FileNews::Weather(path) => self.take_weather(&path),
            FileNews::SaveAs(kind, path) => self.save_to(kind, path),
            FileNews::Cancelled => self.has_failed_to_save(),
            FileNews::NoDialog(purpose) => {
                let suggestion = match purpose {
                    Purpose::Save(kind) => self.suggested_path(kind),
                    Purpose::Scene | Purpose::Weather => PathBuf::new(),
                };
                self.path_dialog = Some(PathDialog::new(purpose, suggestion));
            }
            FileNews::Saved(path) => {
                if path.extension().is_some_and(|e| e == "toml") {
                    // What the window wrote itself is no change to load.
                    self.watch_files();
                }
                let text = format!("Saved {}", path.display());
                self.has_saved(ctx, &path);
                self.notice = Some(Notice { text, is_error: false, since: time });
            }
            FileNews::Repaired(path, what) => {
                let text = format!("Saved {}: {what}", path.display());
                self.notice = Some(Notice { text, is_error: false, since: time });
            }
            FileNews::Framed(path) => {
                // One reading is enough.
                self.watch_files();
                // What the sidecar says now is chosen, whatever the command line said.
                if let Some(scene) = &self.scene_shown {
                    self.open(scene.source.clone().framed(FrameChoice::default()));
                }
                let text = format!("Saved {}; the model is read again", path.display());
                self.notice = Some(Notice { text, is_error: false, since: time });
            }
            FileNews::SaveFailed(text) => {
                self.has_failed_to_save();
                self.notice = Some(Notice { text, is_error: true, since: time });
            }
            FileNews::Changed => {
                // The scene asked for is about to replace this one.
                if self.state.reload_on_change && self.opening.is_none() {
                    self.reload();
                }
            }
        }
    }
}
