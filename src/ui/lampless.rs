//! A scene without lamps: shown in plain even light, so that nobody waits before a black picture, and offered
//! some.

use super::app::App;
use super::background::Background;
use super::banners::Banner;
use super::command::{Command, EditKey};
use super::overlay::Notice;
use super::panels::Model;
use super::prepared::Prepared;
use super::state::Edits;
use crate::display::{even_light, openness};
use crate::scene::{PlacedLamp, Scene, ceiling_lamps};
use crate::session::Snapshot;
use crate::solve::Stage;
use crate::solver::PatchLight;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What the window keeps for scenes without lamps, and of lamps that it has added.
#[derive(Default)]
pub(super) struct Lampless {
    /// The light that such a scene is shown in.
    even: EvenView,
    /// The present scene as it was read, without lamps that were added since.
    read: Option<Arc<Scene>>,
    /// The scene that ceiling lamps are looked for in, and the number of the search.
    wanted: Option<(Arc<Scene>, u64)>,
    searches: u64,
    search: Background<u64, Vec<PlacedLamp>>,
    /// The first scene gets ceiling lamps unasked.
    at_start: bool,
}

impl Lampless {
    /// Plain even light, where the scene on screen has no lamps.
    pub(super) fn light(&self) -> Option<&PatchLight> {
        self.even.light.as_ref()
    }

    /// The present scene as it was read.
    pub(super) fn read(&self) -> Option<&Arc<Scene>> {
        self.read.as_ref()
    }

    /// Whether places for lamps are being looked for.
    pub(super) fn is_searching(&self) -> bool {
        self.wanted.is_some()
    }
}

/// The mesh and the reflectances that even light is made of, and whether corners are darker in it.
type MadeOf = (u64, Arc<Vec<[f32; 3]>>, bool);

/// Even light for the scene on screen: by direction at once, with its corners once these are known.
#[derive(Default)]
struct EvenView {
    /// The mesh that the corners are looked for on, and what ends the search.
    looked_for: Option<(u64, Arc<AtomicBool>)>,
    openness: Background<u64, Option<Vec<f32>>>,
    of: Option<MadeOf>,
    light: Option<PatchLight>,
}

impl EvenView {
    /// Follows the scene on screen. Returns whether the light is another one. `wake` is called once there is
    /// more to show.
    fn follow(
        &mut self,
        prepared: Option<&Arc<Prepared>>,
        snapshot: &Snapshot,
        wake: impl FnOnce() + Send + 'static,
    ) -> bool {
        let Some(prepared) = prepared.filter(|p| p.scene.luminaires.is_empty()) else {
            self.give_up();
            self.of = None;
            return self.light.take().is_some();
        };
        let serial = prepared.mesh_serial;
        if self.looked_for.as_ref().is_none_or(|(of, _)| *of != serial) {
            self.give_up();
            self.looked_for = Some((serial, Arc::default()));
        }
        self.openness.listen();
        if let Some((_, cancel)) = &self.looked_for
            && self.openness.is_open(&serial)
        {
            let (prepared, cancel) = (Arc::clone(prepared), Arc::clone(cancel));
            let look = move || openness(&prepared.mesh, &|| cancel.load(Ordering::Relaxed));
            self.openness.ask(&serial, look, wake);
        }
        // Reflectances of another mesh are no use.
        let is_current = snapshot.mesh_serial == serial;
        let known = self.of.as_ref().filter(|of| of.0 == serial).map(|of| &of.1);
        let Some(reflectance) = snapshot.reflectance().filter(|_| is_current).or(known) else {
            return false;
        };
        let open = self.openness.latest().filter(|(of, _)| **of == serial);
        let open = open.and_then(|(_, open)| open.as_ref().as_deref());
        let of = (serial, Arc::clone(reflectance), open.is_some());
        let same =
            |b: &(u64, Arc<Vec<[f32; 3]>>, bool)| (b.0, b.2) == (of.0, of.2) && Arc::ptr_eq(&b.1, &of.1);
        if self.of.as_ref().is_some_and(same) {
            return false;
        }
        let irradiance = even_light(&prepared.mesh, prepared.scene.up, open);
        self.light = Some(PatchLight::reflected(irradiance, reflectance));
        self.of = Some(of);
        true
    }

    fn give_up(&mut self) {
        if let Some((_, cancel)) = self.looked_for.take() {
            cancel.store(true, Ordering::Relaxed);
        }
    }
}

impl Drop for EvenView {
    fn drop(&mut self) {
        self.give_up();
    }
}

impl App {
    /// Adds ceiling lamps to the first scene that comes.
    #[must_use]
    pub(super) fn with_ceiling_lamps(mut self, wanted: bool) -> Self {
        self.lampless.at_start = wanted;
        self
    }

    /// Lets even light follow the scene on screen, and takes over lamps that were found.
    pub(super) fn follow_lampless(&mut self, ctx: &egui::Context) {
        let waker = || {
            let wake = ctx.clone();
            move || wake.request_repaint()
        };
        let prepared = self.picture.prepared.as_ref();
        if self.lampless.even.follow(prepared, &self.snapshot, waker()) {
            (self.stale.light, self.stale.exposure) = (true, true);
        }
        let Some((scene, number)) = self.lampless.wanted.clone() else { return };
        if self.scene_shown.as_ref().is_none_or(|shown| !Arc::ptr_eq(shown, &scene)) {
            self.lampless.wanted = None;
            return;
        }
        self.lampless.search.listen();
        let found = self.lampless.search.latest().filter(|(of, _)| **of == number);
        if let Some(lamps) = found.map(|(_, lamps)| Arc::clone(lamps)) {
            self.lampless.wanted = None;
            self.add_lamps(&lamps, ctx.input(|i| i.time));
        } else {
            self.lampless.search.ask(&number, move || ceiling_lamps(&scene), waker());
        }
    }

    /// Begins to look for places for ceiling lamps; they come to the scene once they are found.
    pub(super) fn look_for_lamps(&mut self) {
        if let Some(scene) = self.scene_shown.as_ref().filter(|_| self.lampless.wanted.is_none()) {
            self.lampless.searches += 1;
            self.lampless.wanted = Some((Arc::clone(scene), self.lampless.searches));
        }
    }

    fn add_lamps(&mut self, lamps: &[PlacedLamp], time: f64) {
        if lamps.is_empty() {
            self.complain("No floor was found that a lamp could hang over".to_owned());
            return;
        }
        let mut edits = self.edits.clone();
        edits.lighting.lamps.extend(lamps.iter().map(PlacedLamp::state));
        edits.placed.extend_from_slice(lamps);
        self.apply(EditKey::PlacedLamps, edits);
        self.history.seal();
        let what = match lamps {
            [lamp] => format!("{} added", lamp.name),
            more => format!("{} lamps added", more.len()),
        };
        let text = format!("{what}. Ctrl-Z takes that back, File > Save lamps keeps it beside the model");
        self.notice = Some(Notice { text, is_error: false, since: time });
    }

    /// Has the scene solved with the lamps that are placed in it now.
    pub(super) fn send_placed(&mut self) {
        if let Some(read) = self.lampless.read() {
            self.worker.set_lamps(read, self.edits.placed.clone());
            self.solo = None;
        }
    }

    /// Whether the scene that has come is the one before with other lamps placed in it: all that was done to
    /// it still holds.
    pub(super) fn goes_on_as(&mut self, scene: &Arc<Scene>) -> bool {
        let read = self.snapshot.read.as_ref().unwrap_or(scene);
        let before = self.lampless.read.replace(Arc::clone(read));
        if before.is_none_or(|before| !Arc::ptr_eq(&before, read)) {
            return false;
        }
        let materials = self.edits.materials();
        if !materials.is_empty() {
            // Those that the worker has are of the scene before.
            self.worker.set_materials(scene, materials);
        }
        true
    }

    /// Adds what was asked for on the command line, once.
    pub(super) fn add_lamps_at_start(&mut self) {
        if std::mem::take(&mut self.lampless.at_start) {
            self.look_for_lamps();
        }
    }
}

/// Keeps the lamps that were added to a scene when its file is read again, unless the file has them now;
/// whether there are any. `read` is what was read before.
pub(super) fn carry_placed(read: &Scene, edits: &Edits, now: &Scene, new: &mut Edits) -> bool {
    let own = edits.lighting.lamps.len().saturating_sub(edits.placed.len());
    let states = edits.lighting.lamps.iter().skip(own);
    for (lamp, &state) in edits.placed.iter().zip(states) {
        let is_added = read.placed.iter().all(|old| old.name != lamp.name);
        if is_added && now.luminaires.iter().all(|known| known.name != lamp.name) {
            new.placed.push(lamp.clone());
            new.lighting.lamps.push(state);
        }
    }
    new.placed.len() > now.placed.len()
}

/// What a scene without lamps says in the view, and the offer to add some.
pub(super) fn banner(model: &Model<'_>) -> Option<Banner> {
    let scene = model.scene.filter(|scene| scene.luminaires.is_empty())?;
    let banner = |text: &str, actions| {
        Some(Banner { key: "no lamps", is_warning: true, text: text.to_owned(), actions })
    };
    let is_waiting = model.edits.placed.len() > scene.placed.len();
    if is_waiting && model.snapshot.stage == Stage::Unlit && model.snapshot.error.is_some() {
        return banner(
            "No lamps: those that were added could not be solved for. Undo takes them back.",
            Vec::new(),
        );
    }
    if model.is_adding_lamps || is_waiting {
        return banner("No lamps yet: shown in even light. Ceiling lamps are being added.", Vec::new());
    }
    let add = ("Add ceiling lamps".to_owned(), Command::AddCeilingLamps);
    banner("No lamps: shown in even light, and no light is computed.", vec![add])
}
