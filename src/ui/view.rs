//! The picture in the middle: moving, clicking, reading, drawing.

use super::app::App;
use super::camera_control::{Motion, Wish};
use super::command::Command;
use super::exposure::Metered;
use super::overlay::Notice;
use super::panels::Commands;
use super::state::Quantity;
use super::{banners, input, legend, luminaires, marks, outline, overlay, picture, theme};
use crate::display::{NO_VALUE, SkyLight};
use crate::navigation::Camera;
use crate::render::{ColourSource, FrameInput, Pick};
use crate::scene::{Lighting, SceneSource, is_model_file};
use crate::solve::Stage;
use egui::{CursorIcon, PointerButton, Rect, Sense, Vec2};
use glam::DVec2;
use std::borrow::Cow;

/// Rays across and down with which the view is metered.
const METER_GRID: [u32; 2] = [18, 12];
/// Turning by a drag over the height of the view, in fields of view.
const LOOK_SPEED: f64 = 1.25;
/// Turning about a point by a drag over the height of the view, radians.
const ORBIT_SPEED: f64 = 3.0;

impl App {
    /// Shows the view and answers to the mouse.
    pub(super) fn show_view(&mut self, ui: &mut egui::Ui, out: &mut Commands) {
        let (rect, response) =
            ui.allocate_exact_size(ui.available_size().max(Vec2::splat(1.0)), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Canvas, true, "Scene view"));
        self.view_rect = rect;
        // Its edges as egui rounds them, so that pixels of the picture are pixels of the window.
        let [min, max] = [rect.min, rect.max].map(|p| (p.to_vec2() * ui.pixels_per_point()).round());
        self.view_size_px = [max.x - min.x, max.y - min.y].map(|n| n.max(1.0) as u32);
        if response.clicked() || response.drag_started() {
            // Keys go to the scene again.
            ui.ctx().memory_mut(|m| m.focused().into_iter().for_each(|id| m.surrender_focus(id)));
        }
        self.steer(ui, &response);
        self.move_camera(ui);
        self.adapt(ui);
        self.upload();
        if self.stale.light {
            ui.ctx().request_repaint();
        }
        self.draw(ui, rect);
        self.show_divider(ui, rect);
        let pick = self.pick_at(&response);
        self.answer_clicks(ui, &response, pick.as_ref(), out);
        self.overlays(ui, rect, &response, pick.as_ref(), out);
        if std::mem::take(&mut self.screenshot_wanted) {
            self.request_screenshot(ui.ctx());
        }
    }

    /// Drags and the wheel.
    fn steer(&mut self, ui: &egui::Ui, response: &egui::Response) {
        let drag = response.drag_motion();
        let height = f64::from(response.rect.height().max(1.0));
        let (dx, dy) = (f64::from(drag.x) / height, f64::from(drag.y) / height);
        if response.drag_started_by(PointerButton::Secondary)
            || response.drag_started_by(PointerButton::Middle)
        {
            self.pivot = self.pick_at_position(response.interact_pointer_pos()).map(|pick| pick.position);
        }
        let wheel = response.hovered() && ui.input(|i| i.smooth_scroll_delta().y != 0.0);
        if response.clicked() || response.drag_started() || wheel {
            self.touring = None;
        }
        // Whoever moves has read how.
        self.state.hint_done |= response.dragged() || wheel;
        let Some(camera) = &mut self.camera else { return };
        let forward = camera.forward();
        let pose = camera.pose();
        if response.dragged_by(PointerButton::Primary) && drag != Vec2::ZERO {
            let speed = LOOK_SPEED * pose.fov_y_deg.to_radians();
            camera.look(dx * speed, -dy * speed);
        } else if response.dragged_by(PointerButton::Secondary) && drag != Vec2::ZERO {
            let pivot = self.pivot.unwrap_or(pose.eye + forward * 2.0);
            camera.orbit(pivot, dx * ORBIT_SPEED, -dy * ORBIT_SPEED);
        } else if response.dragged_by(PointerButton::Middle) && drag != Vec2::ZERO {
            let depth = self.pivot.map_or(2.0, |pivot| (pivot - pose.eye).dot(forward)).max(0.1);
            let metres = 2.0 * depth * (0.5 * pose.fov_y_deg.to_radians()).tan();
            camera.pan(-dx * metres, dy * metres);
        }
        if response.hovered() {
            let (zoom, scroll) =
                ui.input(|i| (f64::from(i.zoom_delta()), f64::from(i.smooth_scroll_delta().y)));
            if zoom != 1.0 {
                camera.set_fov(pose.fov_y_deg / zoom);
            } else if scroll != 0.0 {
                let obstacles = self.picture.prepared.as_ref().map(|p| &*p.obstacles);
                camera.nudge(scroll / 50.0, obstacles);
            }
        }
        self.visit.motion = camera.motion();
    }

    fn move_camera(&mut self, ui: &egui::Ui) {
        let wish = input::wish(ui.ctx());
        if wish.ahead != 0.0 || wish.right != 0.0 {
            // Who has orbited and takes a step walks on.
            self.move_as_chosen();
        }
        let (dt, since) = ui.input(|i| (f64::from(i.stable_dt), f64::from(i.unstable_dt)));
        if wish.ahead != 0.0 || wish.right != 0.0 || wish.up != 0.0 {
            self.touring = None;
        }
        if self.touring.is_some() {
            ui.ctx().request_repaint();
        }
        if self.play_tour(ui.ctx(), since) {
            return;
        }
        let Some(camera) = &mut self.camera else { return };
        let obstacles = self.picture.prepared.as_ref().map(|p| &*p.obstacles);
        camera.advance(&wish, obstacles, dt);
        if camera.is_moving() || wish != Wish::default() && wish != (Wish { run: true, ..Wish::default() }) {
            ui.ctx().request_repaint();
        }
        self.state.hint_done |= wish.ahead != 0.0 || wish.right != 0.0;
    }

    /// Lets the exposure follow what is in view.
    fn adapt(&mut self, ui: &egui::Ui) {
        let (Some(prepared), Some(camera)) = (self.picture.prepared.clone(), self.camera()) else { return };
        let even = self.lampless.light().is_some();
        if !self.edits.display.auto_exposure || self.picture.light.radiosity.is_empty() && !even {
            return;
        }
        let from = Some((camera, prepared.mesh_serial));
        let jump = std::mem::take(&mut self.stale.exposure);
        if self.seen.from != from || jump {
            if self.seen.from != from {
                self.seen.patches = prepared.picker.seen_patches(&camera, self.view_size_px, METER_GRID);
                self.seen.from = from;
            }
            let metered = match self.lampless.light() {
                Some(even) => Metered::of(even, &self.seen.patches),
                None => self.picture.metered(&self.seen.patches, self.split().is_some()),
            };
            self.exposure.measure(&metered, jump);
        }
        if self.exposure.is_moving() {
            self.exposure.advance(ui.input(|i| f64::from(i.stable_dt)));
            ui.ctx().request_repaint();
        }
    }

    /// Brings mesh and light to the graphics card where they changed.
    fn upload(&mut self) {
        let display = self.edits.display;
        let Some(prepared) = self.picture.prepared.clone() else { return };
        // The same mesh in more detail comes without further ado.
        if std::mem::take(&mut self.stale.mesh) || self.picture.uploaded.is_some() {
            match (self.picture.uploaded.take(), &self.viewport) {
                (Some(Ok(mesh)), Some(viewport)) => {
                    viewport.upload(|renderer, _, _| renderer.adopt(mesh));
                }
                (Some(Err(error)), _) => self.complain(error.to_string()),
                _ => {}
            }
            self.stale.light = true;
        }
        if let (Some(sky), Some(viewport)) = (self.picture.uploaded_sky.take(), &self.viewport) {
            viewport.upload(|renderer, _, _| renderer.adopt_sky(sky));
        }
        if !std::mem::take(&mut self.stale.light) {
            return;
        }
        self.gains = self.gains();
        self.scale = None;
        self.shown_values.clear();
        let kept = self.picture.kept().filter(|_| self.split().is_some()).map(|kept| &kept.light);
        let lights = [Some(&self.picture.light), kept];
        let quantity = display.quantity;
        let of_patch = quantity.is_row() || quantity.is_defect();
        let factors = self.daylight_factors().cloned();
        // Where microscope or auditor have no answer yet the picture is shown.
        let values = if quantity == Quantity::Error {
            self.auditor.error_percent(&prepared.mesh).map(|values| [Some(values), None])
        } else if quantity == Quantity::DaylightFactor {
            factors.as_ref().map(|factors| [Some(factors.of_patches.clone()), None])
        } else if of_patch {
            let values = self.microscope.scalars(quantity, &prepared, &self.picture.light);
            if quantity.is_row()
                && values.as_ref().is_some_and(|values| values.iter().all(|v| *v <= NO_VALUE))
            {
                // All of it would be grey. What was shown before comes back with the next frame.
                self.leave_row();
                let text =
                    "The patch sees no other one, so there is no row to show: back to what was shown before";
                self.notice = Some(Notice { text: text.to_owned(), is_error: false, since: self.time });
                return;
            }
            values.map(|values| [Some(values), None])
        } else if quantity.is_scalar() {
            Some(lights.map(|l| l.map(|light| self.picture.scalars(quantity, light))))
        } else {
            None
        };
        if let Some(values) = values {
            let areas: Vec<(f32, f64)> =
                values.iter().flatten().flat_map(|values| self.picture.with_areas(values)).collect();
            self.scale = Some(picture::scale(&display, &areas));
            let corners = |k: usize| {
                let values = values[k].as_ref()?;
                if let Some(factors) = factors.as_ref().filter(|_| quantity == Quantity::DaylightFactor) {
                    return Some(factors.at_corners(&prepared, &display));
                }
                Some(self.picture.corner_scalars_of(lights[k], values, &display))
            };
            let (now, kept) = (corners(0), corners(1));
            let [shown, _] = values;
            if let Some(viewport) = &self.viewport {
                viewport.upload(|renderer, _, queue| {
                    now.iter().for_each(|corners| renderer.set_scalars(queue, corners));
                    kept.iter().for_each(|corners| renderer.set_stored_scalars(queue, corners));
                });
            }
            self.shown_values = shown.unwrap_or_default();
        } else {
            let (shading, gains) = (display.shading, self.gains);
            let now = match self.lampless.light() {
                Some(even) => Cow::Owned(self.picture.corner_radiosity_of(even, shading, gains)),
                None => self.picture.corner_radiosity(shading, gains),
            };
            let kept = kept.map(|light| self.picture.corner_radiosity_of(light, shading, gains));
            if let Some(viewport) = &self.viewport {
                viewport.upload(|renderer, _, queue| {
                    renderer.set_light(queue, &now);
                    kept.iter().for_each(|corners| renderer.set_stored_light(queue, corners));
                });
            }
        }
    }

    fn draw(&self, ui: &egui::Ui, rect: Rect) {
        let (Some(viewport), Some(camera)) = (&self.viewport, self.camera()) else {
            ui.painter_at(rect).rect_filled(rect, 0.0, theme::BACKDROP);
            return;
        };
        let display = self.edits.display;
        let source = match (display.quantity, self.scale) {
            (Quantity::PatchIds, _) => ColourSource::PatchIds,
            (Quantity::Normals, _) => ColourSource::Normals,
            (Quantity::Picture, _) | (_, None) => ColourSource::Radiosity,
            (_, Some(scale)) => ColourSource::FalseColour(scale),
        };
        let moving = self.camera.as_ref().is_some_and(|c| c.is_moving())
            || self.exposure.is_moving()
            || self.touring.is_some();
        let sky = |lighting: &Lighting| {
            let outdoors = self.picture.prepared.as_ref()?.scene.outdoors.as_ref()?;
            Some(SkyLight::of(outdoors, lighting).amplified(self.gains))
        };
        let frame = FrameInput {
            sky: self.picture.prepared.as_ref().and_then(|shown| sky(&self.lighting_for(&shown.scene))),
            stored_sky: self.picture.kept().and_then(|kept| sky(&kept.lighting)),
            source,
            exposure: self.exposure_in_force(),
            tone_map: display.tone_map,
            wireframe: display.wireframe,
            // A tint would change the colour that means a value; there the outline alone marks it.
            highlight: self.inspected.filter(|_| !matches!(source, ColourSource::FalseColour(_))),
            show_unlit: display.show_unlit,
            split: self.split(),
            // A software adapter draws single samples while the picture changes, four at rest.
            multisample: !viewport.is_software() || !(moving || self.is_solving()),
            ..FrameInput::new(camera, self.view_size_px)
        };
        viewport.paint(ui, rect, frame);
        if let (Some(patch), Some(prepared)) = (self.inspected, &self.picture.prepared) {
            outline::show(ui, rect, prepared, &camera, patch);
        }
        if let (Some((finding, place)), Some(prepared)) = (self.doctor.shown(), &self.picture.prepared) {
            marks::show(ui, rect, prepared, &camera, finding, place);
        }
        if let Some(prepared) = &self.picture.prepared {
            luminaires::show(ui, rect, &prepared.scene, &camera);
        }
    }

    fn is_solving(&self) -> bool {
        super::panels::solver::is_running(self.snapshot.stage) && !self.snapshot.paused
    }

    fn pick_at(&self, response: &egui::Response) -> Option<Pick> {
        if response.dragged() {
            return None;
        }
        self.pick_at_position(response.hover_pos())
    }

    /// What lies under a place of the window.
    pub(super) fn pick_at_position(&self, position: Option<egui::Pos2>) -> Option<Pick> {
        let (prepared, camera): (_, Camera) = (self.picture.prepared.as_ref()?, self.camera()?);
        let at = (position? - self.view_rect.min) / self.view_rect.size();
        let size = self.view_size_px;
        let pixel = DVec2::new(f64::from(at.x) * f64::from(size[0]), f64::from(at.y) * f64::from(size[1]));
        prepared.picker.pick(&camera.ray(pixel, size))
    }

    fn answer_clicks(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        pick: Option<&Pick>,
        out: &mut Commands,
    ) {
        let patch = pick.and_then(|pick| pick.patch);
        let mesh = self.picture.prepared.as_ref().map(|p| &p.mesh);
        let lamp = patch.and_then(|id| mesh?.patches.get(id as usize)?.luminaire);
        if lamp.is_some() && response.hovered() {
            ui.ctx().set_cursor_icon(CursorIcon::PointingHand);
        }
        if response.clicked() {
            if ui.input(|i| i.modifiers.command || i.modifiers.ctrl) {
                out.push(Command::Inspect(patch));
                if patch.is_some() && !self.state.right_open {
                    out.push(Command::ToggleRight);
                }
            } else if let Some(lamp) = lamp {
                self.state.hint_done = true;
                out.push(Command::ToggleLamp(lamp as usize));
            }
        }
    }

    fn overlays(
        &self,
        ui: &egui::Ui,
        rect: Rect,
        response: &egui::Response,
        pick: Option<&Pick>,
        out: &mut Commands,
    ) {
        let model = self.model();
        let quantity = self.edits.display.quantity;
        match &self.scale {
            Some(scale) => legend::show(ui, rect, quantity, scale),
            None if quantity.is_scalar() && self.picture.prepared.is_some() => {
                let has_sky = model.scene.is_some_and(|scene| scene.outdoors.is_some());
                legend::pending(ui, rect, quantity, has_sky);
            }
            None => {}
        }
        // Messages stand below the banners.
        let below = banners::show(ui, rect, &model, out);
        if self.edits.display.readout
            && response.hovered()
            && let Some(pick) = pick
        {
            let kept = self.picture.kept().map(|kept| &kept.light);
            let on_left =
                |split: f32| response.hover_pos().is_some_and(|at| at.x < rect.left() + split * rect.width());
            let light = kept.filter(|_| self.split().is_some_and(on_left));
            overlay::readout(ui, rect, &model, pick, light);
        }
        let lamps = &self.edits.lighting.lamps;
        let shows_light = quantity == Quantity::Picture || quantity.follows_light();
        let is_dark = !lamps.is_empty()
            && lamps.iter().all(|lamp| !lamp.on)
            && shows_light
            && self.split().is_none()
            && !self.help_open;
        if self.picture.prepared.is_none() {
            let text = match self.snapshot.stage {
                Stage::Idle if !self.picture.is_building() => "Open a scene: Ctrl-O, or drop a model here",
                Stage::Failed => "Nothing could be shown: see the message above",
                _ => "Loading...",
            };
            overlay::waiting(ui, rect, text);
        } else if !self.state.hint_done && !self.help_open && self.notice.is_none() && !is_dark {
            overlay::hint(ui, below);
        }
        if is_dark && self.picture.prepared.is_some() && self.notice.is_none() && self.touring.is_none() {
            overlay::dark(ui, below);
        }
        if self.lampless.light().is_some() && quantity == Quantity::Picture {
            overlay::even_light(ui, rect);
        }
        // A message takes its place for a while.
        if let Some(touring) = self.touring.as_ref().filter(|_| self.notice.is_none()) {
            overlay::tour(ui, below, touring.progress(), touring.barred().as_deref());
        }
        if let Some(notice) = &self.notice {
            overlay::notice(ui, below, notice, out);
        }
        if ui.input(|i| !i.raw.hovered_files.is_empty()) {
            overlay::drop_target(ui, rect);
        }
    }

    /// Opens what was dropped onto the window.
    pub(super) fn dropped_files(&mut self, ui: &egui::Ui, out: &mut Commands) {
        let paths: Vec<_> = ui.input(|i| i.raw.dropped_files.iter().map(|f| f.path().to_owned()).collect());
        let has_ending = |path: &std::path::Path, ending: &str| {
            path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending))
        };
        if let Some(path) = paths.iter().find(|path| is_model_file(path)) {
            out.push(Command::Open(SceneSource::File(path.clone())));
        } else if let Some(path) = paths.iter().find(|path| has_ending(path, "epw")) {
            out.push(Command::SetWeather(path.clone()));
        } else if let Some(path) = paths.first() {
            self.complain(format!("{} is no model that can be read (OBJ, glTF, GLB or PLY)", path.display()));
        }
    }

    /// How one moves at present.
    pub fn motion(&self) -> Motion {
        self.visit.motion
    }
}
