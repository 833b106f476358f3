//! Carrying commands out: the one place where the window changes.

use super::app::{App, Asked};
use super::auditor::Ask;
use super::camera_control::{Motion, Pose};
use super::command::{Command, EditKey, SaveKind};
use super::files::{SaveJob, free_name, pictures_folder};
use super::outlook::outlook;
use super::overlay::Notice;
use super::panels::Commands;
use super::picture::shading_of;
use super::state::{DisplaySettings, Edits, Quantity};
use super::units;
use crate::display::{Exposure, white_balance};
use crate::scene::{DaylightChoice, LampState, Lighting, SceneSource, View};
use crate::solve::SolveSettings;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Patches looked into before that one can go back to.
const PICKS_KEPT: usize = 64;

impl App {
    /// Carries out and forgets all of `commands`.
    pub(super) fn execute_all(&mut self, ctx: &egui::Context, commands: &mut Commands) {
        for command in std::mem::take(commands) {
            self.execute(ctx, command);
        }
    }

    fn execute(&mut self, ctx: &egui::Context, command: Command) {
        if let Some(key) = command.edit_key() {
            let discrete = !matches!(
                command,
                Command::SetLamp(..)
                    | Command::SetReflectance(..)
                    | Command::SetDisplay(_)
                    | Command::SetDaylight(_)
            );
            // Whoever switches a lamp knows that one can.
            self.state.hint_done |= matches!(
                command,
                Command::SetLamp(..) | Command::ToggleLamp(_) | Command::AllLamps(_) | Command::SoloLamp(_)
            );
            if let Command::SetDaylight(choice) = &command {
                // Who moves the handle has taken it over.
                self.day_playing = None;
                if let Some(edits) = self.with_daylight(choice.as_deref()) {
                    self.apply(key, edits);
                }
                return;
            }
            let (edits, solo) = self.edited(&command);
            self.apply(key, edits);
            if solo.is_some() || !matches!(command, Command::SetDisplay(_) | Command::SetReflectance(..)) {
                self.solo = solo;
            }
            if discrete {
                self.history.seal();
            }
            return;
        }
        match command {
            Command::Undo => {
                if let Some(edits) = self.history.undo(self.edits.clone()) {
                    self.replace_edits(edits);
                }
            }
            Command::Redo => {
                if let Some(edits) = self.history.redo(self.edits.clone()) {
                    self.replace_edits(edits);
                }
            }
            Command::Open(source) => self.leave_for(source),
            Command::OpenDialog => self.files.open_dialog(),
            Command::Reload => self.reload(),
            Command::Save(SaveKind::Screenshot) if self.viewport.is_none() => {}
            Command::Save(kind) => self.files.save_dialog(kind, &self.suggested_path(kind)),
            Command::QuickSave(kind) => self.save_to(kind, self.suggested_path(kind)),
            Command::StoreComparison => {
                self.picture.store_comparison(&self.edits);
                self.stale.light = true;
            }
            Command::ToggleSplit => self.toggle_split(ctx),
            Command::ToggleTour => self.toggle_tour(),
            Command::GoToView(index) => self.go_to(index),
            Command::StepView(step) => self.step_view(step),
            Command::Home => self.go_to(self.start_view),
            Command::StoreView => self.store_view(ctx),
            Command::RenameView(index, name) => {
                if let Some(view) = self.views.get_mut(index) {
                    view.name = name;
                }
            }
            Command::RemoveView(index) => self.remove_view(index),
            Command::SaveSidecar => self.save_sidecar(),
            Command::SetFrame(unit, up) => {
                if let Some(scene) = &self.scene_shown
                    && let Some(path) = scene.source.path()
                    && (scene.unit, scene.up) != (unit, up)
                {
                    self.files.save_frame(path, unit, up);
                }
            }
            Command::SetMotion(motion) => {
                (self.visit.motion, self.visit.chosen_motion) = (motion, motion);
                self.touring = None;
                if let Some(camera) = &mut self.camera {
                    camera.set_motion(motion);
                    camera.land();
                }
            }
            Command::SetEyeHeight(metres) => {
                self.state.eye_height = metres;
                if let Some(camera) = &mut self.camera {
                    camera.set_eye_height(metres);
                }
            }
            Command::SetFov(degrees) => {
                if let Some(camera) = &mut self.camera {
                    camera.set_fov(degrees);
                }
            }
            Command::Pause(true) => self.worker.pause(),
            Command::Pause(false) => self.worker.resume(),
            Command::Stop => self.worker.stop(),
            Command::Solve(settings) => self.worker.set_settings(settings),
            Command::Accuracy(Ask::Switch(on)) => self.auditor.switch(on),
            Command::Accuracy(Ask::SetGoal(goal)) => self.auditor.goal = goal,
            Command::Accuracy(Ask::Reach) => {
                if let Some(settings) = self.auditor.reach(&self.snapshot.settings) {
                    self.worker.set_settings(settings);
                }
            }
            Command::ToggleDay => self.toggle_day(),
            Command::WeatherDialog => self.files.weather_dialog(),
            Command::SetWeather(path) => self.take_weather(&path),
            Command::AddCeilingLamps => self.look_for_lamps(),
            Command::Doctor(ask) => self.ask_doctor(ask),
            Command::Inspect(patch) => {
                self.look_into(patch);
                self.inspect_fresh = patch.is_some();
                // Whoever looks that closely has read how to walk.
                self.state.hint_done |= patch.is_some();
            }
            Command::PickNext(patch) => self.look_into(Some(patch)),
            Command::PickBack => {
                if let Some(before) = self.past_picks.pop() {
                    self.inspected = Some(before);
                }
            }
            Command::ToggleRow => self.toggle_row(ctx.input(|i| i.pointer.latest_pos())),
            Command::ToggleTable => {
                self.visit.table_open = !self.visit.table_open;
                self.visit.doctor_open &= !self.visit.table_open;
            }
            Command::JumpToPatch(patch) => self.jump_to(patch),
            Command::TogglePanels => {
                let open = self.state.left_open || self.state.right_open;
                (self.state.left_open, self.state.right_open) = (!open, !open);
            }
            Command::ToggleLeft => self.state.left_open = !self.state.left_open,
            Command::ToggleRight => self.state.right_open = !self.state.right_open,
            Command::ToggleHelp => self.help_open = !self.help_open,
            Command::ToggleStatus => self.state.show_status = !self.state.show_status,
            Command::ReloadOnChange(reload) => self.state.reload_on_change = reload,
            Command::RefineAtLeisure(refine) => self.state.refine_at_leisure = refine,
            Command::DismissBanner(key) => {
                self.visit.dismissed.insert(key);
            }
            Command::DismissMessage => {
                self.dismissed = self.notice.take().map(|notice| notice.text);
            }
            Command::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            // Edits have a key and were carried out above.
            Command::SetLamp(..)
            | Command::ToggleLamp(_)
            | Command::AllLamps(_)
            | Command::SoloLamp(_)
            | Command::ResetLamps
            | Command::SetDaylight(_)
            | Command::SetReflectance(..)
            | Command::ResetMaterials
            | Command::SetDisplay(_) => {}
        }
    }

    /// The edits that a command makes of the present ones, and which lamp then stands alone.
    fn edited(&self, command: &Command) -> (Edits, Option<(usize, Lighting)>) {
        let mut edits = self.edits.clone();
        let mut solo = None;
        let lamps = &mut edits.lighting.lamps;
        match command {
            Command::SetLamp(index, state) => {
                if let Some(lamp) = lamps.get_mut(*index) {
                    *lamp = *state;
                }
            }
            Command::ToggleLamp(index) => {
                if let Some(lamp) = lamps.get_mut(*index) {
                    lamp.on = !lamp.on;
                }
            }
            Command::AllLamps(on) => lamps.iter_mut().for_each(|lamp| lamp.on = *on),
            Command::SoloLamp(index) => match &self.solo {
                Some((alone, before)) if alone == index => edits.lighting.clone_from(before),
                other => {
                    let before = other.as_ref().map_or(&self.edits.lighting, |(_, before)| before).clone();
                    for (k, lamp) in lamps.iter_mut().enumerate() {
                        lamp.on = k == *index;
                    }
                    solo = Some((*index, before));
                }
            },
            Command::ResetLamps => {
                let scene = self.picture.prepared.as_ref().map(|p| &p.scene);
                // One with other lamps is on its way.
                if let Some(scene) = scene.filter(|scene| scene.luminaires.len() == lamps.len()) {
                    edits.lighting = scene.lighting();
                    if let (Some(out), Some(day)) = (&scene.outdoors, &self.day) {
                        let states = edits.lighting.lamps.get_mut(out.sky as usize..=out.sun as usize);
                        states.into_iter().for_each(|states| states.clone_from_slice(&day.outdoors.states()));
                    }
                }
            }
            Command::SetReflectance(index, value) => {
                if let Some(slot) = edits.reflectance.get_mut(*index) {
                    *slot = *value;
                }
            }
            Command::ResetMaterials => edits.reflectance.fill(None),
            Command::SetDisplay(display) => edits.display = *display,
            _ => {}
        }
        (edits, solo)
    }

    pub(super) fn apply(&mut self, key: EditKey, edits: Edits) {
        if edits != self.edits {
            self.history.record(key, self.edits.clone());
            self.replace_edits(edits);
        }
    }

    /// Puts other edits into force and does what the difference asks for, and no more.
    pub(super) fn replace_edits(&mut self, edits: Edits) {
        let before = std::mem::replace(&mut self.edits, edits);
        let sky = |edits: &Edits| edits.daylight.as_ref().map(DaylightChoice::without_lamps);
        let is_other_sky = sky(&before) != sky(&self.edits);
        if is_other_sky {
            self.follow_day();
            self.send_daylight();
        }
        if before.placed != self.edits.placed {
            self.send_placed();
        } else if before.lighting != self.edits.lighting && !is_other_sky {
            // Whoever asked for one lamp alone says so after this.
            self.solo = None;
            let start = Instant::now();
            self.settle_picture();
            let what = self.describe_lamps(&before.lighting);
            let took = units::duration(start.elapsed().as_secs_f64());
            self.last_change = format!("{what}: 0 rows, 0 sweeps, {took}");
            self.stale.light = true;
            self.stale.exposure = true;
        }
        if before.reflectance != self.edits.reflectance
            && let Some(scene) = &self.scene_shown
        {
            self.worker.set_materials(scene, self.edits.materials());
        }
        if before.display != self.edits.display {
            if self.edits.display.quantity == Quantity::Error && before.display.quantity != Quantity::Error {
                // Whoever asks for the map asks for the check that it is made of.
                self.auditor.ensure_on();
            }
            self.state.preferences = self.edits.display.preferences();
            self.stale.light = true;
            self.stale.exposure |= before.display.split != self.edits.display.split;
        }
    }

    /// Looks into another patch, or into none; the one before can be gone back to.
    pub(super) fn look_into(&mut self, patch: Option<u32>) {
        if patch == self.inspected {
            return;
        }
        match (self.inspected, patch) {
            (Some(before), Some(_)) => {
                if self.past_picks.len() == PICKS_KEPT {
                    self.past_picks.remove(0);
                }
                self.past_picks.push(before);
            }
            (_, None) => {
                self.past_picks.clear();
                self.leave_row();
            }
            (None, Some(_)) => {}
        }
        self.inspected = patch;
    }

    /// Puts the row of the patch looked into onto the scene, or takes it off again. Where none is looked
    /// into, it becomes the one under the cursor.
    fn toggle_row(&mut self, cursor: Option<egui::Pos2>) {
        if self.edits.display.quantity.is_row() {
            self.leave_row();
            return;
        }
        if self.inspected.is_none() {
            let inside = cursor.filter(|&at| self.view_rect.contains(at));
            self.inspected = self.pick_at_position(inside).and_then(|pick| pick.patch);
            self.inspect_fresh = self.inspected.is_some();
        }
        if self.inspected.is_some() {
            self.before_row = Some(self.edits.display);
            let display = self.edits.display.showing(Quantity::RowDensity);
            self.apply(EditKey::Display, Edits { display, ..self.edits.clone() });
            self.history.seal();
        }
    }

    /// Shows again what was shown before a row was.
    pub(super) fn leave_row(&mut self) {
        let before = self.before_row.take();
        let now = self.edits.display;
        if !now.quantity.is_row() {
            return;
        }
        let display = match before {
            Some(DisplaySettings { quantity, range, logarithmic, .. }) => {
                DisplaySettings { quantity, range, logarithmic, ..now }
            }
            None => now.showing(Quantity::Picture),
        };
        self.apply(EditKey::Display, Edits { display, ..self.edits.clone() });
        self.history.seal();
    }

    fn describe_lamps(&self, before: &Lighting) -> String {
        let changed: Vec<usize> = (0..self.edits.lighting.lamps.len())
            .filter(|&k| before.lamps.get(k) != self.edits.lighting.lamps.get(k))
            .collect();
        let name = |k: usize| {
            let scene = self.picture.prepared.as_ref().map(|p| &p.scene);
            scene.and_then(|s| s.luminaires.get(k)).map_or_else(|| format!("lamp {k}"), |l| l.name.clone())
        };
        match changed[..] {
            [k] => {
                let now = self.edits.lighting.lamps[k];
                match before.lamps.get(k) {
                    Some(LampState { on, .. }) if *on != now.on => {
                        format!("{} {}", name(k), if now.on { "on" } else { "off" })
                    }
                    Some(LampState { dimmer, .. }) if *dimmer != now.dimmer => {
                        format!("{} at {:.0} %", name(k), 100.0 * now.dimmer)
                    }
                    _ => format!("{} recoloured", name(k)),
                }
            }
            _ => format!("{} lamps switched", changed.len()),
        }
    }

    /// Opens a scene; the present one stays until the new one is ready, and if it fails.
    pub(super) fn open(&mut self, source: SceneSource) {
        (self.notice, self.dismissed) = (None, None);
        let file = source.path().and_then(|path| path.file_name());
        let name = match &source {
            SceneSource::Builtin(name) => name.clone(),
            _ => file.map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
        };
        self.asked_for = Some(source.clone());
        let asked = source.clone();
        self.last_change = format!("opening {name}");
        let scene = self.snapshot.scene().map(Arc::downgrade).unwrap_or_default();
        let known_error = self.snapshot.error.clone();
        self.opening = Some(Asked { name, source: asked, serial: self.snapshot.serial, known_error, scene });
        match &self.scene_shown {
            // Solver settings belong to a scene as well.
            Some(shown) if !shown.source.is_same_model(&source) => {
                self.worker.open_with(source, SolveSettings::default());
            }
            _ => self.worker.open(source),
        }
    }

    pub(super) fn reload(&mut self) {
        let source = self.picture.prepared.as_ref().map(|p| p.scene.source.clone());
        // Nothing is shown where the one that was asked for could not be read.
        if let Some(source) = source.or_else(|| self.asked_for.clone()) {
            self.open(source);
        }
    }

    /// Side by side and back; the first time the present light becomes A.
    fn toggle_split(&mut self, ctx: &egui::Context) {
        let mut display = self.edits.display;
        if !self.picture.has_comparison() {
            self.picture.store_comparison(&self.edits);
            if !self.picture.has_comparison() {
                return;
            }
            let text = "The light as it is was kept as A: switch lamps and see the difference".to_owned();
            self.notice = Some(Notice { text, is_error: false, since: ctx.input(|i| i.time) });
            display.split = false;
        }
        display.split = !display.split;
        if display.split && !display.quantity.can_split() {
            display = display.showing(Quantity::Picture);
        }
        self.apply(EditKey::Display, Edits { display, ..self.edits.clone() });
        self.history.seal();
    }

    /// Moves again as was chosen, where orbiting or a jump to a patch has lifted the camera off the floor.
    pub(super) fn move_as_chosen(&mut self) {
        if let Some(camera) = &mut self.camera {
            camera.set_motion(self.visit.chosen_motion);
            self.visit.motion = self.visit.chosen_motion;
        }
    }

    fn go_to(&mut self, index: usize) {
        self.touring = None;
        self.move_as_chosen();
        if let (Some(view), Some(camera)) = (self.views.get(index), &mut self.camera) {
            let pose = camera.pose_of(view);
            camera.travel_to(pose);
            self.view_index = Some(index);
        }
    }

    fn step_view(&mut self, step: i32) {
        let count = self.views.len() as i32;
        if count > 0 {
            let now = self.view_index.map_or(if step > 0 { -1 } else { 0 }, |k| k as i32);
            self.go_to((now + step).rem_euclid(count) as usize);
        }
    }

    fn store_view(&mut self, ctx: &egui::Context) {
        let Some(control) = &self.camera else { return };
        let pose = control.pose();
        let target = pose.eye + control.forward();
        let free = |k: &usize| self.views.iter().all(|v| v.name != format!("View {k}"));
        let number = (self.views.len() + 1..).find(free).unwrap_or(1);
        let name = format!("View {number}");
        if !self.state.left_open {
            let text = format!("This view is kept as {name}");
            self.notice = Some(Notice { text, is_error: false, since: ctx.input(|i| i.time) });
        }
        self.views.push(View { name, eye: pose.eye, target, fov_y_deg: pose.fov_y_deg });
        self.view_index = Some(self.views.len() - 1);
    }

    fn remove_view(&mut self, index: usize) {
        if index >= self.views.len() || index == self.start_view {
            return;
        }
        self.touring = None;
        self.views.remove(index);
        // Those after it move up.
        let moved = |k: usize| k - usize::from(k > index);
        self.start_view -= usize::from(self.start_view > index);
        self.view_index = self.view_index.filter(|&k| k != index).map(moved);
    }

    /// The bookmark that the camera stands at.
    pub(super) fn view_here(&self) -> Option<usize> {
        let camera = self.camera.as_ref()?;
        let pose = camera.pose();
        let is_here = |view: &View| {
            let there = camera.pose_of(view);
            let turned = (there.yaw - pose.yaw).sin().hypot(there.pitch - pose.pitch);
            let zoomed = (there.fov_y_deg - pose.fov_y_deg).abs() > 0.5;
            there.eye.distance(pose.eye) < 1e-3
                && turned < 1e-3
                && (there.yaw - pose.yaw).cos() > 0.0
                && !zoomed
        };
        self.views.iter().position(is_here)
    }

    /// Glides to where a patch is well seen.
    fn jump_to(&mut self, patch: u32) {
        let Some(prepared) = self.picture.prepared.clone() else { return };
        let Some(target) = prepared.mesh.patches.get(patch as usize) else { return };
        self.look_into(Some(patch));
        self.touring = None;
        let Some(camera) = &self.camera else { return };
        let view = View {
            name: String::new(),
            eye: outlook(&prepared.mesh, &prepared.picker, patch, camera.pose().eye),
            target: target.centre,
            fov_y_deg: camera.pose().fov_y_deg,
        };
        self.fly_to(&view);
    }

    /// Glides to a view wherever it is, and says how one walks again.
    pub(super) fn fly_to(&mut self, view: &View) {
        let Some(camera) = &mut self.camera else { return };
        if camera.motion() == Motion::Walk {
            let text = "Flying, to see this place: a step walks on from here, Home goes back to the start"
                .to_owned();
            self.notice = Some(Notice { text, is_error: false, since: self.time });
        }
        camera.set_motion(Motion::Fly);
        self.visit.motion = Motion::Fly;
        let pose: Pose = camera.pose_of(view);
        camera.travel_to(pose);
    }

    /// The exposure that the picture is drawn with.
    pub(super) fn exposure_in_force(&self) -> Exposure {
        let display = &self.edits.display;
        if display.auto_exposure {
            Exposure { ev100: self.exposure.ev() }.brighter(display.compensation)
        } else {
            Exposure { ev100: display.ev }
        }
    }

    /// Factors per band of what is shown: eyes that have adapted to the lamps.
    pub(super) fn gains(&self) -> [f32; 3] {
        match &self.picture.prepared {
            Some(prepared) if self.edits.display.white_balance => {
                let now = &self.edits.lighting;
                match self.picture.kept().filter(|_| self.split().is_some()) {
                    Some(kept) => white_balance(&prepared.scene, &[now, &kept.lighting]),
                    None => white_balance(&prepared.scene, &[now]),
                }
            }
            _ => [1.0; 3],
        }
    }

    /// Where a file of this kind would go.
    pub(super) fn suggested_path(&self, kind: SaveKind) -> PathBuf {
        let scene = self.picture.prepared.as_ref().map(|p| &p.scene);
        let stem = scene.map_or("lumenwalk", |s| s.name.as_str());
        let folder = match (kind, scene.and_then(|s| s.source.path())) {
            (SaveKind::Screenshot, _) | (_, None) => pictures_folder(),
            (_, Some(path)) => path.parent().map_or_else(pictures_folder, PathBuf::from),
        };
        match kind {
            SaveKind::RepairedCopy => free_name(&folder, &format!("{stem}-repaired"), kind.extension()),
            _ => free_name(&folder, stem, kind.extension()),
        }
    }

    /// Saves on a helper thread; the outcome comes as a message.
    pub(super) fn save_to(&mut self, kind: SaveKind, path: PathBuf) {
        let path = if path.extension().is_none() { path.with_extension(kind.extension()) } else { path };
        if let (SaveKind::RepairedCopy | SaveKind::EditedCopy, Some(scene)) = (kind, &self.scene_shown) {
            match kind {
                SaveKind::RepairedCopy => self.files.save_repaired(path, Arc::clone(scene)),
                _ => self.save_edited(path),
            }
            return;
        }
        let (Some(prepared), Some(camera)) = (self.picture.prepared.clone(), self.camera()) else { return };
        if kind == SaveKind::Screenshot {
            self.screenshot = Some(path);
            self.screenshot_wanted = true;
            return;
        }
        let job = SaveJob {
            prepared,
            light: self.picture.light.clone(),
            reflectance: Arc::clone(&self.picture.reflectance),
            lighting: self.edits.lighting.clone(),
            camera,
            size_px: self.view_size_px,
            shading: shading_of(self.edits.display.shading),
            exposure: self.exposure_in_force(),
            tone_map: self.edits.display.tone_map,
            gains: self.gains(),
        };
        self.files.save(kind, path, job);
    }

    /// Tells the user something that went wrong.
    pub(super) fn complain(&mut self, text: String) {
        self.notice = Some(Notice { text, is_error: true, since: 0.0 });
    }
}
