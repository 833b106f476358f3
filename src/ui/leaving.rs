//! Lamps, materials and bookmarks that are not in the scene's sidecar yet: asked about before the scene is left.

use super::app::App;
use super::command::SaveKind;
use super::state::Edits;
use super::theme;
use crate::scene::{DaylightChoice, LampState, OutdoorSwitch, Scene, SceneSource, View, sidecar_path};
use egui::{Button, Id, Key, Modal, RichText};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Numbers nearer than this are the same: a sidecar keeps a few digits.
const SAME: f64 = 1e-3;

/// What a sidecar can keep of what the user has done.
#[derive(Clone, Debug, Default)]
pub(super) struct Work {
    lamps: Vec<LampState>,
    /// The sky over the model, its lamps left out.
    daylight: Option<DaylightChoice>,
    /// Of each material, as edited or as the file has it.
    reflectance: Vec<[f64; 3]>,
    views: Vec<View>,
    start_view: usize,
}

impl Work {
    /// The scene as it was read.
    pub(super) fn of_file(scene: &Scene) -> Self {
        let edits = Edits::of_scene(scene, Default::default());
        Self::new(scene, &edits, &scene.views, scene.start_view)
    }

    fn new(scene: &Scene, edits: &Edits, views: &[View], start_view: usize) -> Self {
        let edited = |k: usize| edits.reflectance.get(k).copied().flatten();
        let materials = scene.own_materials().iter().enumerate();
        Self {
            lamps: plain_lamps(scene, edits),
            daylight: edits.daylight.as_ref().map(DaylightChoice::without_lamps),
            reflectance: materials.map(|(k, material)| edited(k).unwrap_or(material.reflectance)).collect(),
            views: views.to_vec(),
            start_view,
        }
    }

    /// The same with lamps switched and dimmed and the sky as `saved`: of an embedded scene, which is there to be tried,
    /// these are no work that would be missed.
    fn without_switches(mut self, saved: &Self) -> Self {
        for (lamp, saved) in self.lamps.iter_mut().zip(&saved.lamps) {
            (lamp.on, lamp.dimmer) = (saved.on, saved.dimmer);
        }
        self.daylight.clone_from(&saved.daylight);
        self
    }

    /// What differs from what was `saved`, in words: "2 lamps, 1 bookmark"; `None` where nothing does.
    fn changes(&self, saved: &Self) -> Option<String> {
        let lamps = changed(&self.lamps, &saved.lamps, is_same_lamp);
        let materials = changed(&self.reflectance, &saved.reflectance, |a, b| are_same(a, b));
        let views = changed(&self.views, &saved.views, is_same_view)
            .max(usize::from(self.start_view != saved.start_view));
        let daylight = usize::from(self.daylight != saved.daylight);
        let counted = [(lamps, "lamp"), (materials, "material"), (views, "bookmark")];
        let told: Vec<String> = counted
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, word)| format!("{count} {word}{}", if count == 1 { "" } else { "s" }))
            .chain((daylight > 0).then(|| "daylight".to_owned()))
            .collect();
        (!told.is_empty()).then(|| told.join(", "))
    }
}

/// The lamps as they stand, with sky and sun for a unit of what they are at the hour: another hour switches no lamp.
fn plain_lamps(scene: &Scene, edits: &Edits) -> Vec<LampState> {
    let mut lamps = edits.lighting.lamps.clone();
    let Some(choice) = &edits.daylight else { return lamps };
    if let Ok(outdoors) = scene.outdoors_for(&choice.without_lamps(), None)
        && let Some(states) = lamps.get_mut(outdoors.sky as usize..=outdoors.sun as usize)
    {
        let hour = [outdoors.sky_exitance(), outdoors.sun_exitance()];
        for ((state, exitance), known) in states.iter_mut().zip(hour).zip([choice.sky_lamp, choice.sun_lamp])
        {
            *state = OutdoorSwitch::of(state, exitance, known).state(1.0);
        }
    }
    lamps
}

/// How many of two lists differ, those that only one of them has included.
fn changed<T>(now: &[T], before: &[T], is_same: impl Fn(&T, &T) -> bool) -> usize {
    let differ = now.iter().zip(before).filter(|(a, b)| !is_same(a, b)).count();
    differ + now.len().abs_diff(before.len())
}

fn are_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME * a.abs().max(b.abs()).max(SAME))
}

fn is_same_lamp(a: &LampState, b: &LampState) -> bool {
    a.on == b.on && are_same(&[a.dimmer], &[b.dimmer]) && are_same(&a.exitance, &b.exitance)
}

fn is_same_view(a: &View, b: &View) -> bool {
    let ahead = |view: &View| (view.target - view.eye).normalize_or_zero();
    a.name == b.name
        && a.eye.distance(b.eye) <= SAME
        && ahead(a).distance(ahead(b)) <= SAME
        && (a.fov_y_deg - b.fov_y_deg).abs() <= 0.1
}

/// Where the user is going.
#[derive(Clone, Debug, PartialEq)]
enum To {
    /// Out of the program.
    Out,
    /// To another scene.
    Scene(SceneSource),
}

/// The question that is open, or how far the answer has come.
#[derive(Debug)]
pub(super) struct Leaving {
    to: To,
    /// The answer was to save; it goes on once that is done.
    is_saving: bool,
    /// It was shown before: the keyboard has its place.
    is_shown: bool,
}

impl Leaving {
    fn new(to: To) -> Self {
        Self { to, is_saving: false, is_shown: false }
    }
}

impl App {
    /// What is not saved yet, in words.
    fn unsaved(&self) -> Option<String> {
        let scene = self.scene_shown.as_ref()?;
        let work = self.work(scene);
        let work = if scene.source.path().is_some() { work } else { work.without_switches(&self.saved) };
        work.changes(&self.saved)
    }

    fn work(&self, scene: &Scene) -> Work {
        Work::new(scene, &self.edits, &self.views, self.start_view)
    }

    /// Opens a scene, once the user has decided about what is not saved of the present one.
    pub(super) fn leave_for(&mut self, source: SceneSource) {
        let is_other = self.scene_shown.as_ref().is_some_and(|scene| scene.source != source);
        if is_other && self.unsaved().is_some() {
            self.leaving = Some(Leaving::new(To::Scene(source)));
        } else {
            self.open(source);
        }
    }

    /// Keeps the window open, where it is about to be closed and something is not saved.
    pub(super) fn guard_the_exit(&mut self, ctx: &egui::Context) {
        if self.may_close || !ctx.input(|i| i.viewport().close_requested()) {
            return;
        }
        if self.unsaved().is_some() {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            ctx.send_viewport_cmd(egui::ViewportCommand::Focus);
            if self.leaving.as_ref().is_none_or(|leaving| leaving.to != To::Out) {
                self.leaving = Some(Leaving::new(To::Out));
            }
            ctx.request_repaint();
        }
    }

    /// Remembers what goes to the sidecar now.
    pub(super) fn begin_saving(&mut self) {
        self.saving = self.scene_shown.as_ref().map(|scene| self.work(scene));
    }

    /// Writes what was edited beside the scene's file.
    pub(super) fn save_sidecar(&mut self) {
        self.begin_saving();
        let Some(scene) = &self.scene_shown else { return };
        let Some(path) = scene.source.path() else { return };
        let bookmarks = (self.views.clone(), self.start_view);
        self.files.save_sidecar(path, Arc::clone(scene), self.edits.clone(), bookmarks);
    }

    /// Writes a copy of the scene with what was edited.
    pub(super) fn save_edited(&mut self, copy: PathBuf) {
        self.begin_saving();
        let Some(scene) = &self.scene_shown else { return };
        let bookmarks = (self.views.clone(), self.start_view);
        self.files.save_edited(copy, Arc::clone(scene), self.edits.clone(), bookmarks);
    }

    /// A file has been written: where it is the sidecar, or the copy of a scene without a file, what was edited is saved,
    /// and who wanted to leave does.
    pub(super) fn has_saved(&mut self, ctx: &egui::Context, path: &Path) {
        let Some(scene) = &self.scene_shown else { return };
        let is_of_the_scene = match scene.source.path() {
            Some(model) => *path == sidecar_path(model),
            None => path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")),
        };
        if !is_of_the_scene {
            return;
        }
        if let Some(saved) = self.saving.take() {
            self.saved = saved;
        }
        if let Some(leaving) = self.leaving.take_if(|leaving| leaving.is_saving) {
            self.leave(ctx, leaving.to);
        }
    }

    /// A file could not be written, or the user has given up naming it: the user stays.
    pub(super) fn has_failed_to_save(&mut self) {
        self.saving = None;
        self.leaving.take_if(|leaving| leaving.is_saving);
    }

    fn leave(&mut self, ctx: &egui::Context, to: To) {
        match to {
            To::Out => {
                self.may_close = true;
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            To::Scene(source) => self.open(source),
        }
    }

    /// Shows the open question, and acts on the answer.
    pub(super) fn ask_before_leaving(&mut self, ui: &egui::Ui) {
        let Some(mut leaving) = self.leaving.take_if(|leaving| !leaving.is_saving) else { return };
        let (Some(changes), Some(scene)) = (self.unsaved(), self.scene_shown.clone()) else {
            // Undone meanwhile, or the scene is another one.
            self.leave(ui.ctx(), leaving.to);
            return;
        };
        let (to_where, save) = match scene.source.path().map(sidecar_path) {
            Some(sidecar) => {
                let name = sidecar.file_name().map(|name| name.to_string_lossy().into_owned());
                (format!("Saving writes {} beside the model.", name.unwrap_or_default()), "Save")
            }
            None => ("The scene is embedded: saving writes a copy of it.".to_owned(), "Save a copy..."),
        };
        let mut answer = None;
        let shown = Modal::new(Id::unique("unsaved changes")).show(ui.ctx(), |ui| {
            ui.set_max_width(400.0);
            ui.label(RichText::new(format!("Save the changes to {}?", scene.name)).heading());
            ui.label(RichText::new(format!("Changed: {changes}. {to_where}")).color(theme::TEXT_WEAK));
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                let save = ui.add(Button::new(save));
                if !leaving.is_shown {
                    save.request_focus();
                }
                for (button, choice) in [
                    (save, Choice::Save),
                    (ui.button("Don't save"), Choice::Drop),
                    (ui.button("Cancel"), Choice::Stay),
                ] {
                    if button.clicked() {
                        answer = Some(choice);
                    }
                }
            });
        });
        leaving.is_shown = true;
        if ui.input(|i| i.key_pressed(Key::Escape)) || shown.should_close() {
            answer = Some(Choice::Stay);
        }
        match answer {
            None => self.leaving = Some(leaving),
            Some(Choice::Stay) => {}
            Some(Choice::Drop) => self.leave(ui.ctx(), leaving.to),
            Some(Choice::Save) => {
                leaving.is_saving = true;
                self.leaving = Some(leaving);
                if scene.source.path().is_some() {
                    self.save_sidecar();
                } else {
                    self.files.save_dialog(SaveKind::EditedCopy, &self.suggested_path(SaveKind::EditedCopy));
                }
            }
        }
    }
}

enum Choice {
    Save,
    Drop,
    Stay,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn what_was_changed_is_counted_and_rounding_is_no_change() {
        let obj = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n\
                   o floor\nusemtl wall\nf 4 3 2 1\no lamp\nusemtl glow\nf 5 6 7 8\n";
        let mtl = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 0.8 0.8 0.8\nKe 3 3 3\n";
        let scene = scene::from_text("t", obj, mtl, None).expect("a scene");
        let saved = Work::of_file(&scene);
        assert_eq!(saved.changes(&saved), None);
        let mut edits = Edits::of_scene(&scene, Default::default());
        edits.lighting.lamps[0].exitance = edits.lighting.lamps[0].exitance.map(|e| e * 1.0001);
        let wall = scene.materials.iter().position(|m| m.name == "wall").expect("there");
        edits.reflectance[wall] = Some([0.5, 0.5, 0.50001]);
        let work = |edits: &Edits, views: &[View]| Work::new(&scene, edits, views, scene.start_view);
        assert_eq!(work(&edits, &scene.views).changes(&saved), None, "rounding");
        edits.lighting.lamps[0].on = false;
        edits.reflectance[wall] = Some([0.5, 0.5, 0.1]);
        let mut views = scene.views.clone();
        for name in ["One", "Two"] {
            views.push(View { name: name.to_owned(), ..scene.views[0].clone() });
        }
        let told = work(&edits, &views).changes(&saved);
        assert_eq!(told.as_deref(), Some("1 lamp, 1 material, 2 bookmarks"));
        // Of an embedded scene a colour is work and a switch is none.
        let told = work(&edits, &views).without_switches(&saved).changes(&saved);
        assert_eq!(told.as_deref(), Some("1 material, 2 bookmarks"));
        edits.lighting.lamps[0].exitance[2] *= 0.5;
        let told = work(&edits, &scene.views).without_switches(&saved).changes(&saved);
        assert_eq!(told.as_deref(), Some("1 lamp, 1 material"));
    }
}
