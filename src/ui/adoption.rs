//! A mesh that has come to the screen: of another scene, of the same one cut differently, or of a file that
//! was read again, with what the user had done to it.

use super::app::App;
use super::auditor;
use super::camera_control::CameraControl;
use super::lampless::carry_placed;
use super::leaving::Work;
use super::state::{DisplaySettings, Edits, Visit};
use crate::scene::{DaylightChoice, Scene, View};
use std::sync::Arc;

/// What the user has done to a scene whose file has been read again since, without some of the lamps and
/// materials that it was done to: a file that was written in two goes is whole after the second.
pub(super) struct LeftBehind {
    scene: Arc<Scene>,
    edits: Edits,
    views: Vec<View>,
}

impl App {
    /// Takes over the scene of the mesh that has come to the screen.
    pub(super) fn adopt_scene(&mut self) {
        let Some(prepared) = self.picture.prepared.clone() else { return };
        self.stale.mesh = true;
        self.look_into(None);
        self.microscope.forget();
        self.touring = None;
        self.clock.forget();
        self.seen = Default::default();
        let scene = Arc::clone(&prepared.scene);
        let before = self.scene_shown.replace(Arc::clone(&scene));
        if before.as_ref().is_some_and(|before| Arc::ptr_eq(before, &scene)) {
            return;
        }
        let read_before = self.lampless.read().cloned();
        if self.goes_on_as(&scene) {
            return;
        }
        self.files.watch(Some(&scene.source), &scene.read_from);
        (self.saved, self.saving) = (Work::of_file(&scene), None);
        if let Some(path) = scene.source.path() {
            self.state.remember(path);
        }
        let same_file = before.filter(|before| before.source.is_same_model(&scene.source));
        if same_file.is_none() {
            self.visit = Visit::default();
            self.divider = 0.5;
            self.picture.forget_comparison();
            self.auditor.goal = auditor::GOAL;
        }
        // A file that was read again goes on as it is looked at; another scene starts with its picture.
        let display = match &same_file {
            Some(_) => self.edits.display,
            None => DisplaySettings::preferring(self.state.preferences),
        };
        let edits = std::mem::replace(&mut self.edits, Edits::of_scene(&scene, display));
        let views = std::mem::replace(&mut self.views, scene.views.clone());
        (self.start_view, self.view_index) = (scene.start_view, None);
        self.history.clear();
        self.solo = None;
        self.exposure = Default::default();
        let left = self.left_behind.take().filter(|left| left.scene.source.is_same_model(&scene.source));
        if let Some(before) = same_file {
            let before = LeftBehind { scene: before, edits, views };
            let mut any = false;
            for done in left.iter().chain([&before]) {
                carry_lamps(&done.scene, &done.edits, &scene, &mut self.edits);
                any |= carry_materials(&done.scene, &done.edits, &scene, &mut self.edits);
                if is_in_place(&done.scene, &scene) {
                    carry_views(&done.scene, &done.views, &mut self.views);
                }
            }
            carry_daylight(
                read_before.as_ref().unwrap_or(&before.scene),
                &before.edits,
                &scene,
                &mut self.edits,
            );
            if self.edits.daylight != Edits::of_scene(&scene, display).daylight {
                self.send_daylight();
            }
            if any {
                // Those that the worker has are of the scene as it was read before.
                self.worker.set_materials(&scene, self.edits.materials());
            }
            let is_in_place = is_in_place(&before.scene, &scene);
            if is_in_place {
                let read = read_before.as_ref().unwrap_or(&before.scene);
                if carry_placed(read, &before.edits, &scene, &mut self.edits) {
                    self.send_placed();
                }
            }
            self.left_behind = left.into_iter().chain([before]).find(|done| done.lacks_something(&scene));
            if is_in_place && self.camera.is_some() {
                return;
            }
        }
        let up = scene.up.vector();
        let size = prepared.bounds.size();
        let start = scene.views.get(scene.start_view).or(scene.views.first());
        self.camera = start.map(|view| {
            CameraControl::new(
                view,
                up,
                size.dot(up),
                prepared.mesh.size,
                self.visit.motion,
                self.state.eye_height,
            )
        });
        self.inherit();
        self.add_lamps_at_start();
    }
}

impl LeftBehind {
    /// Whether lamps or materials that were changed are not in `now`.
    fn lacks_something(&self, now: &Scene) -> bool {
        let lamps = self.scene.luminaires.iter().zip(&self.edits.lighting.lamps);
        let mut lamps = lamps.filter(|(lamp, state)| lamp.initial != **state).map(|(lamp, _)| &lamp.name);
        let materials = self.scene.materials.iter().zip(&self.edits.reflectance);
        let mut materials =
            materials.filter(|(_, value)| value.is_some()).map(|(material, _)| &material.name);
        lamps.any(|name| now.luminaires.iter().all(|lamp| lamp.name != *name))
            || materials.any(|name| now.materials.iter().all(|material| material.name != *name))
    }
}

/// Whether a place of one is that place of the other.
fn is_in_place(before: &Scene, now: &Scene) -> bool {
    before.up == now.up && before.unit == now.unit && before.origin == now.origin
}

/// Brings what the user has changed about a lamp into the state that it had, by name, where the name is one
/// lamp's alone. Exitance means other lumens in another unit, and stays that of the file there.
fn carry_lamps(before: &Scene, edits: &Edits, now: &Scene, new: &mut Edits) {
    for (old, &state) in before.luminaires.iter().zip(&edits.lighting.lamps) {
        let same = |scene: &Scene| {
            let mut named = scene.luminaires.iter().enumerate().filter(|(_, lamp)| lamp.name == old.name);
            named.next().filter(|_| named.next().is_none()).map(|(index, _)| index)
        };
        if let (Some(_), Some(index)) = (same(before), same(now))
            && let Some(lamp) = new.lighting.lamps.get_mut(index)
        {
            if state.on != old.initial.on {
                lamp.on = state.on;
            }
            if state.dimmer != old.initial.dimmer {
                lamp.dimmer = state.dimmer;
            }
            if state.exitance != old.initial.exitance && before.unit == now.unit {
                lamp.exitance = state.exitance;
            }
        }
    }
}

/// Keeps the daylight that the user has asked for when the file is read again, unless the file has another one now.
fn carry_daylight(read: &Scene, edits: &Edits, now: &Scene, new: &mut Edits) {
    let of = |scene: &Scene| scene.outdoors.as_ref().map(|outdoors| outdoors.choice.without_lamps());
    let wanted = edits.daylight.as_ref().map(DaylightChoice::without_lamps);
    // Where a sky has come or gone the lamps are others: there the file rules.
    let is_alike = wanted.is_some() && now.outdoors.is_some() && read.outdoors.is_some();
    if !is_alike || of(read) != of(now) || wanted == of(read) {
        return;
    }
    if let (Some(choice), Some(Ok(outdoors)), Some(before)) =
        (&wanted, wanted.as_ref().map(|choice| now.outdoors_for(choice, None)), &now.outdoors)
    {
        let states = new.lighting.lamps.get_mut(before.sky as usize..=before.sun as usize);
        for (state, initial) in states.into_iter().flatten().zip(outdoors.states()) {
            state.exitance = initial.exitance;
        }
        new.daylight = Some(choice.clone());
    }
}

/// Gives materials that the user has changed the reflectance that they had, by name; whether there were any.
fn carry_materials(before: &Scene, edits: &Edits, now: &Scene, new: &mut Edits) -> bool {
    let mut any = false;
    for (old, value) in before.materials.iter().zip(&edits.reflectance) {
        let Some(value) = value else { continue };
        let index = now.materials.iter().position(|material| material.name == old.name);
        if let Some(slot) = index.and_then(|index| new.reflectance.get_mut(index)) {
            *slot = Some(*value);
            any = true;
        }
    }
    any
}

/// Keeps the bookmarks that the user has stored and that the file does not have; both scenes are in place.
fn carry_views(before: &Scene, views: &[View], new: &mut Vec<View>) {
    for view in views {
        let is_stored = before.views.iter().all(|old| old.name != view.name);
        if is_stored && new.iter().all(|known| known.name != view.name) {
            new.push(view.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    const OBJ: &str =
        "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n";
    const MTL: &str = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 0.8 0.8 0.8\nKe 3 3 3\n";

    fn read(faces: &str, sidecar: &str) -> Scene {
        painted(faces, MTL, sidecar)
    }

    fn painted(faces: &str, mtl: &str, sidecar: &str) -> Scene {
        scene::from_text("t", &format!("{OBJ}{faces}"), mtl, Some(sidecar)).expect("a scene")
    }

    #[test]
    fn a_file_read_again_keeps_what_was_done_by_name() {
        let floor = "o floor\nusemtl wall\nf 4 3 2 1\n";
        let lamp = "o lamp\nusemtl glow\nf 5 6 7 8\n";
        let before = read(&format!("{floor}{lamp}"), "[[luminaire]]\nobject = \"lamp\"\nname = \"Lamp\"\n");
        // The other way round, with a lamp and a material more, and with a bookmark.
        let more = "o second\nusemtl glow\nf 1 2 6 5\n";
        let sidecar = "[[luminaire]]\nobject = \"second\"\nname = \"Second\"\n\
                       [[luminaire]]\nobject = \"lamp\"\nname = \"Lamp\"\n\
                       [[view]]\nname = \"Door\"\neye = [0.5, 1, 0.5]\ntarget = [1, 1, 1]\n";
        let mtl = format!("newmtl tile\nKd 0.4 0.4 0.4\n{MTL}");
        let tiled = "o tiles\nusemtl tile\nf 2 3 7 6\n";
        let now = painted(&format!("{tiled}{more}{lamp}{floor}"), &mtl, sidecar);
        let mut edits = Edits::of_scene(&before, DisplaySettings::default());
        edits.lighting.lamps[0].dimmer = 0.25;
        let wall = before.materials.iter().position(|m| m.name == "wall").expect("there");
        edits.reflectance[wall] = Some([0.1, 0.2, 0.3]);
        let mut new = Edits::of_scene(&now, DisplaySettings::default());
        let second = new.lighting.lamps[0];
        carry_lamps(&before, &edits, &now, &mut new);
        assert!(carry_materials(&before, &edits, &now, &mut new));
        assert_eq!((new.lighting.lamps[1].dimmer, new.lighting.lamps[0]), (0.25, second));
        let here = now.materials.iter().position(|m| m.name == "wall").expect("there");
        assert_ne!(here, wall);
        assert_eq!(new.reflectance[here], Some([0.1, 0.2, 0.3]));

        let stored = View { name: "View 4".to_owned(), ..now.views[0].clone() };
        let mut views = now.views.clone();
        carry_views(&before, &[stored.clone(), now.views[0].clone()], &mut views);
        assert_eq!(views.len(), now.views.len() + 1);
        assert_eq!(views.last(), Some(&stored));
    }

    #[test]
    fn what_half_a_file_lacks_is_remembered_for_the_whole() {
        let floor = "o floor\nusemtl wall\nf 4 3 2 1\n";
        let whole = read(&format!("{floor}o lamp\nusemtl glow\nf 5 6 7 8\n"), "");
        let half = read(floor, "");
        let edits = Edits::of_scene(&whole, DisplaySettings::default());
        let done = |edits: &Edits| LeftBehind {
            scene: Arc::new(whole.clone()),
            edits: edits.clone(),
            views: whole.views.clone(),
        };
        assert!(!done(&edits).lacks_something(&half), "nothing was done to what is gone");
        let mut dimmed = edits.clone();
        dimmed.lighting.lamps[0].dimmer = 0.25;
        assert!(done(&dimmed).lacks_something(&half) && !done(&dimmed).lacks_something(&whole));
        let mut painted = edits;
        let glow = whole.materials.iter().position(|m| m.name == "glow").expect("there");
        painted.reflectance[glow] = Some([0.1; 3]);
        assert!(!done(&painted).lacks_something(&half), "the library defines it still");
    }

    #[test]
    fn what_was_not_touched_of_a_lamp_follows_the_file() {
        let scene = |lumens: f64, unit: &str| {
            let sidecar = format!(
                "unit = \"{unit}\"\n[[luminaire]]\nobject = \"lamp\"\nname = \"Lamp\"\nlumens = {lumens}\n"
            );
            read("o lamp\nusemtl glow\nf 5 6 7 8\no floor\nusemtl wall\nf 4 3 2 1\n", &sidecar)
        };
        let carried = |before: &Scene, edits: &Edits, now: &Scene| {
            let mut new = Edits::of_scene(now, DisplaySettings::default());
            carry_lamps(before, edits, now, &mut new);
            new.lighting.lamps[0]
        };
        let before = scene(800.0, "m");
        let mut edits = Edits::of_scene(&before, DisplaySettings::default());
        edits.lighting.lamps[0].dimmer = 0.25;
        // Brighter in the file, or the same lumens from a thousandth of the width.
        for (now, factor) in [(scene(1600.0, "m"), 2.0), (scene(800.0, "mm"), 1e6)] {
            let lamp = carried(&before, &edits, &now);
            let was = before.luminaires[0].initial.exitance;
            assert_eq!((lamp.dimmer, lamp.on), (0.25, true));
            assert!(lamp.exitance.iter().zip(was).all(|(e, was)| (e / was / factor - 1.0).abs() < 1e-9));
        }
        // A lamp that was recoloured stays so, in the unit that it was recoloured in.
        edits.lighting.lamps[0].exitance = [1.0, 2.0, 3.0];
        assert_eq!(carried(&before, &edits, &scene(1600.0, "m")).exitance, [1.0, 2.0, 3.0]);
        let other = scene(800.0, "mm");
        assert_eq!(carried(&before, &edits, &other).exitance, other.luminaires[0].initial.exitance);
    }

    #[test]
    fn lamps_that_nobody_touched_follow_the_file() {
        let scene = |dimmer: f64| {
            let sidecar = format!("[[luminaire]]\nobject = \"lamp\"\nname = \"Lamp\"\ndimmer = {dimmer}\n");
            read("o lamp\nusemtl glow\nf 5 6 7 8\no floor\nusemtl wall\nf 4 3 2 1\n", &sidecar)
        };
        let (before, now) = (scene(1.0), scene(0.5));
        let mut new = Edits::of_scene(&now, DisplaySettings::default());
        carry_lamps(&before, &Edits::of_scene(&before, DisplaySettings::default()), &now, &mut new);
        assert_eq!(new.lighting.lamps[0].dimmer, 0.5);
    }
}
