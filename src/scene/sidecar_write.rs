//! Edited lamps, materials and bookmarks written back to the sidecar.

use super::error::SceneError;
use super::lamp_entry::LampEntry;
use super::luminaires::selectors;
use super::selection::lamps_of_entries;
use super::sidecar::{EmitsKey, LuminaireEntry, MaterialEntry, Sidecar, SidesKey, Source, UpKey, ViewEntry};
use super::types::{LampState, LengthUnit, Lighting, Luminaire, Scene, Sides, UpAxis};
use std::collections::HashSet;
use std::io;
use std::path::Path;
use toml::Spanned;
use toml_edit::{DocumentMut, Item, Table};

/// The text of a sidecar that brings back the scene's views, lamps and edited materials.
///
/// `lighting` holds one state a luminaire; `repainted` are indices of the materials whose present
/// reflectance is to be kept. With the text of the `existing` sidecar, its other entries stay as
/// they are, and its comments with their entries. Lamps whose exitance was not changed keep their lumens and colour
/// temperature.
///
/// # Errors
/// Where `existing` is no sidecar of this scene.
pub fn sidecar_text(
    scene: &Scene,
    lighting: &Lighting,
    repainted: &[u32],
    existing: Option<&str>,
) -> Result<String, SceneError> {
    let file = format!("{}.toml", scene.name);
    let mut sidecar = match existing {
        Some(text) => Source { file: &file, text }.parse()?,
        None => Sidecar::default(),
    };
    let stale = || {
        SceneError::file(&file, "the sidecar has changed since the scene was read; reload the scene first")
    };
    sidecar.unit = Some(scene.unit.into());
    sidecar.up = Some(if scene.up == UpAxis::Z { UpKey::Z } else { UpKey::Y });
    sidecar.patch_size = scene.patch_size.map(unplaced);
    sidecar.start = scene.views.get(scene.start_view).map(|view| unplaced(view.name.clone()));
    sidecar.views = scene
        .views
        .iter()
        .map(|view| ViewEntry {
            name: unplaced(view.name.clone()),
            eye: scene.in_file(view.eye).to_array(),
            target: scene.in_file(view.target).to_array(),
            fov: view.fov_y_deg,
        })
        .collect();

    let own = scene.own_luminaires();
    let made = lamps_of_entries(scene, &sidecar).ok_or_else(stale)?;
    let known = made.last().map_or(0, |last| last.end);
    let old = std::mem::take(&mut sidecar.luminaires);
    let lamps: Vec<(&Luminaire, &LampState)> =
        scene.luminaires.iter().zip(&lighting.lamps).take(own).collect();
    let selectors = selectors(scene);
    for (entry, range) in old.into_iter().zip(made) {
        let Some(group) = lamps.get(range.clone()) else { return Err(stale()) };
        // An entry for several objects of one name stays one as long as their lamps are alike.
        let is_alike = |lamp: &(&Luminaire, &LampState)| {
            let (on, dimmer) = (group[0].1.on, group[0].1.dimmer);
            is_unchanged(*lamp) && lamp.1.on == on && lamp.1.dimmer == dimmer
        };
        if group.len() > 1 && group.iter().all(is_alike) {
            let mut entry = entry;
            set_switch(entry.get_mut(), group[0].1);
            sidecar.luminaires.push(entry);
            continue;
        }
        for (number, lamp) in range.zip(group) {
            let mut entry = entry.clone();
            if group.len() > 1 {
                entry.get_mut().object = selectors[number].0.first().cloned();
            }
            set_lamp(entry.get_mut(), *lamp);
            sidecar.luminaires.push(entry);
        }
    }
    let both: HashSet<u32> =
        scene.surfaces.iter().filter(|s| s.emits_back).filter_map(|surface| surface.luminaire).collect();
    for (number, ((objects, materials), lamp)) in (0_u32..).zip(selectors.into_iter().zip(lamps)).skip(known)
    {
        let mut entry = new_entry(objects, materials);
        // A copy in another format would not know.
        entry.emits = both.contains(&number).then_some(EmitsKey::Both);
        set_lamp(&mut entry, lamp);
        sidecar.luminaires.push(unplaced(entry));
    }

    // The lamps of the sky stand between those of the model and the placed ones.
    let outdoors = scene.outdoors.as_ref();
    sidecar.daylight = outdoors.map(|outdoors| unplaced(outdoors.switched(lighting)));
    let before = own + if outdoors.is_some() { 2 } else { 0 };
    let placed = scene.placed.iter().zip(lighting.lamps.iter().skip(before));
    let placed: Vec<LampEntry> =
        placed.map(|(lamp, state)| LampEntry::of(&lamp.starting_as(state), scene)).collect();
    sidecar.lamps = Some(placed).filter(|placed| !placed.is_empty() || scene.has_lights);

    for material in repainted.iter().filter_map(|&index| scene.own_materials().get(index as usize)) {
        let reflectance = Some(material.reflectance);
        let mut entries = sidecar.materials.iter_mut();
        if let Some(entry) = entries.find(|entry| *entry.name.get_ref() == material.name) {
            entry.reflectance = reflectance;
            continue;
        }
        let sides = match material.sides {
            Sides::Auto => None,
            Sides::Front => Some(SidesKey::Front),
            Sides::Both => Some(SidesKey::Both),
        };
        sidecar.materials.push(MaterialEntry {
            name: unplaced(material.name.clone()),
            reflectance,
            sides,
            transmittance: None,
            panes: None,
            glass: None,
            translucence: None,
        });
    }
    composed(&sidecar, existing, &file)
}

/// The text of a sidecar. Comments of the `existing` text stay with their entries.
fn composed(sidecar: &Sidecar, existing: Option<&str>, file: &str) -> Result<String, SceneError> {
    let text = toml::to_string(sidecar)
        .map_err(|error| SceneError::file(file, format!("cannot be composed ({error})")))?;
    let parsed = |text: &str| text.parse::<DocumentMut>().ok();
    let Some((old, mut new)) = existing.and_then(parsed).zip(parsed(&text)) else { return Ok(text) };
    keep_comments(&old, &mut new);
    new.set_trailing(old.trailing().clone());
    Ok(new.to_string())
}

/// Gives the entries of `new` what stands before and behind those of the same name in `old`; comments inside
/// lists are not among that. Tables of an array belong together by their `name`, or by their place where the
/// old one has none.
fn keep_comments(old: &Table, new: &mut Table) {
    for (key, before) in old.iter() {
        match (before, new.get_mut(key)) {
            (Item::Value(before), Some(Item::Value(now))) => {
                *now.decor_mut() = before.decor().clone();
                if let (Some(from), Some(mut to)) = (old.key(key), new.key_mut(key)) {
                    *to.leaf_decor_mut() = from.leaf_decor().clone();
                }
            }
            (Item::Table(before), Some(Item::Table(now))) => {
                *now.decor_mut() = before.decor().clone();
                keep_comments(before, now);
            }
            (Item::ArrayOfTables(before), Some(Item::ArrayOfTables(now))) => {
                for (place, now) in now.iter_mut().enumerate() {
                    let named =
                        before.iter().find(|old| name_of(old).is_some() && name_of(old) == name_of(now));
                    let unnamed = || before.get(place).filter(|old| name_of(old).is_none());
                    if let Some(before) = named.or_else(unnamed) {
                        *now.decor_mut() = before.decor().clone();
                        keep_comments(before, now);
                    }
                }
            }
            _ => {}
        }
    }
}

fn name_of(table: &Table) -> Option<&str> {
    table.get("name")?.as_str()
}

/// Writes the sidecar at `path`, keeping what [`sidecar_text`] keeps of the one that is there.
///
/// The text is written beside it and then renamed: a failure leaves the old file as it was.
pub fn write_sidecar(
    path: &Path,
    scene: &Scene,
    lighting: &Lighting,
    repainted: &[u32],
) -> Result<(), SceneError> {
    let before = existing(path)?;
    replace(path, &sidecar_text(scene, lighting, repainted, before.as_deref())?)
}

/// Writes the unit and the up axis of a model to the sidecar at `path`; all else in it stays. The model has to be read again for it to take effect.
///
/// # Errors
/// Where the sidecar that is there cannot be read, or the new one cannot be written.
pub fn write_frame(path: &Path, unit: LengthUnit, up: UpAxis) -> Result<(), SceneError> {
    let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let before = existing(path)?;
    let mut sidecar = match &before {
        Some(text) => Source { file: &file, text }.parse()?,
        None => Sidecar::default(),
    };
    sidecar.unit = Some(unit.into());
    sidecar.up = Some(if up == UpAxis::Z { UpKey::Z } else { UpKey::Y });
    replace(path, &composed(&sidecar, before.as_deref(), &file)?)
}

/// The text of a file where there is one.
fn existing(path: &Path) -> Result<Option<String>, SceneError> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Some(crate::encoding::decode(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(SceneError::reading(path, &error)),
    }
}

/// Writes a text beside `path` and then renames it: a failure leaves the old file as it was.
fn replace(path: &Path, text: &str) -> Result<(), SceneError> {
    let unwritable =
        |error: io::Error| SceneError::Unwritable { path: path.to_owned(), reason: error.to_string() };
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = Path::new(&beside);
    std::fs::write(beside, text).and_then(|()| std::fs::rename(beside, path)).map_err(|error| {
        // What is left of the attempt is of no use to anyone; the error above is the one that counts.
        let _ = std::fs::remove_file(beside);
        unwritable(error)
    })
}

/// A value that has no place in a text yet.
fn unplaced<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

fn is_unchanged((lamp, state): (&Luminaire, &LampState)) -> bool {
    state.exitance == lamp.initial.exitance
}

fn set_switch(entry: &mut LuminaireEntry, state: &LampState) {
    entry.on = (!state.on).then_some(false);
    entry.dimmer = (state.dimmer != 1.0).then_some(state.dimmer);
}

fn set_lamp(entry: &mut LuminaireEntry, (lamp, state): (&Luminaire, &LampState)) {
    entry.name = Some(lamp.name.clone());
    set_switch(entry, state);
    if !is_unchanged((lamp, state)) {
        (entry.lumens, entry.colour, entry.cct) = (None, None, None);
        entry.exitance = Some(state.exitance);
    }
}

fn new_entry(mut objects: Vec<String>, mut materials: Vec<String>) -> LuminaireEntry {
    let mut entry = LuminaireEntry::default();
    if objects.len() == 1 {
        entry.object = objects.pop();
    }
    if materials.len() == 1 {
        entry.material = materials.pop();
    }
    LuminaireEntry { objects, materials, ..entry }
}

#[cfg(test)]
mod tests {
    use super::super::{View, from_text};
    use super::*;
    use glam::DVec3;

    const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n\
        v 0 3 0\nv 1 3 0\nv 1 3 1\nv 0 3 1\no floor\nusemtl white\nf 4 3 2 1\no hall_lamp\nusemtl bright\n\
        f 5 6 7 8\no desk\nusemtl bright\nf 9 10 11 12\n";
    const MTL: &str = "newmtl white\nKd 0.8 0.8 0.8\nnewmtl bright\nKd 0 0 0\nKe 4 2 1\n";
    const SIDECAR: &str = "unit = \"in\"\nup = \"z\"\npatch_size = 0.05\n[[luminaire]]\nobject = \"desk\"\n\
        name = \"Desk lamp\"\nlumens = 450\ncct = 2700\nemits = \"back\"\n[[material]]\nname = \"white\"\nsides = \"both\"\n";

    #[test]
    fn what_is_written_is_read_back_the_same() {
        for sidecar in [None, Some(SIDECAR)] {
            let mut scene = from_text("t", OBJ, MTL, sidecar).unwrap();
            let mut lighting = scene.lighting();
            lighting.lamps[1].on = false;
            lighting.lamps[0].dimmer = 0.3;
            lighting.lamps[1].exitance = [1.0, 0.1 + 0.2, 3.0];
            scene.materials[0].reflectance = [0.1, 0.2, 0.3];
            scene.views.push(View {
                name: "A \"special\" corner".to_owned(),
                eye: DVec3::new(0.1, 0.2, 0.3),
                target: DVec3::X,
                fov_y_deg: 75.0,
            });
            scene.start_view = scene.views.len() - 1;
            let text = sidecar_text(&scene, &lighting, &[0], sidecar).unwrap();
            let again = from_text("t", OBJ, MTL, Some(&text)).unwrap_or_else(|e| panic!("{e}\n{text}"));
            for (lamp, wanted) in again.lighting().lamps.iter().zip(&lighting.lamps) {
                assert_eq!((lamp.on, lamp.dimmer), (wanted.on, wanted.dimmer));
                for band in 0..3 {
                    assert!(
                        (lamp.exitance[band] - wanted.exitance[band]).abs() <= 1e-12 * wanted.exitance[band]
                    );
                }
            }
            let names = |scene: &Scene| scene.luminaires.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
            assert_eq!(names(&again), names(&scene));
            assert_eq!(again.materials[0].reflectance, [0.1, 0.2, 0.3]);
            assert_eq!(again.materials[0].sides, scene.materials[0].sides);
            assert_eq!((again.unit, again.up, again.patch_size), (scene.unit, scene.up, scene.patch_size));
            assert_eq!((again.views.len(), again.start_view), (scene.views.len(), scene.start_view));
            for (view, wanted) in again.views.iter().zip(&scene.views) {
                assert_eq!((&view.name, view.fov_y_deg), (&wanted.name, wanted.fov_y_deg));
                assert!(
                    view.eye.abs_diff_eq(wanted.eye, 1e-12) && view.target.abs_diff_eq(wanted.target, 1e-12)
                );
            }
            assert_eq!(again.surfaces[2].corners, scene.surfaces[2].corners, "the emitting side");
            // Writing once more changes nothing.
            assert_eq!(sidecar_text(&again, &again.lighting(), &[], Some(&text)).unwrap(), text);
        }
    }

    #[test]
    fn unchanged_lamps_keep_lumens_and_colour_temperature() {
        let scene = from_text("t", OBJ, MTL, Some(SIDECAR)).unwrap();
        let text = sidecar_text(&scene, &scene.lighting(), &[], Some(SIDECAR)).unwrap();
        assert!(text.contains("lumens = 450") && text.contains("cct = 2700"), "{text}");
        assert!(!text.contains("exitance"), "{text}");
    }

    #[test]
    fn an_entry_for_several_lamps_is_one_until_one_of_them_differs() {
        let obj = OBJ.replace("o hall_lamp", "o spot").replace("o desk", "o spot");
        let sidecar = "[[luminaire]]\n# As bought.\nobject = \"spot\"\nlumens = 800\n";
        let scene = from_text("t", &obj, MTL, Some(sidecar)).unwrap();
        assert_eq!(scene.luminaires.len(), 2);
        let mut lighting = scene.lighting();
        let read_back = |lighting: &Lighting| {
            let text = sidecar_text(&scene, lighting, &[], Some(sidecar)).unwrap();
            let again = from_text("t", &obj, MTL, Some(&text)).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let names = |scene: &Scene| scene.luminaires.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
            assert_eq!(names(&again), names(&scene), "{text}");
            assert_eq!(again.lighting(), *lighting, "{text}");
            (text.matches("lumens = 800").count(), text.matches("exitance").count())
        };
        lighting.lamps.iter_mut().for_each(|lamp| lamp.dimmer = 0.5);
        assert_eq!(read_back(&lighting), (1, 0));
        lighting.lamps[1].on = false;
        assert_eq!(read_back(&lighting), (2, 0));
        lighting.lamps[0].exitance = [1.0, 2.0, 3.0];
        assert_eq!(read_back(&lighting), (1, 1));
    }

    #[test]
    fn comments_stay_with_their_entries() {
        let noted = SIDECAR
            .replace("up = ", "# Lies on its back.\nup = ")
            .replace("[[material]]", "# After the survey.\n[[material]]")
            .replace("lumens = 450", "lumens = 450 # as measured")
            + "# The end.\n";
        let noted = format!("# Ms Meyer's house.\n{noted}");
        let scene = from_text("t", OBJ, MTL, Some(&noted)).unwrap();
        let mut lighting = scene.lighting();
        lighting.lamps[0].dimmer = 0.3;
        let text = sidecar_text(&scene, &lighting, &[], Some(&noted)).unwrap();
        for kept in [
            "# Ms Meyer's house.\nunit = ",
            "# Lies on its back.\nup = ",
            "# After the survey.\n[[material]]",
            "lumens = 450.0 # as measured\n",
            "# The end.\n",
        ] {
            assert!(text.contains(kept), "{kept:?} is gone from\n{text}");
        }
        assert!(text.contains("dimmer = 0.3"), "{text}");
        let again = from_text("t", OBJ, MTL, Some(&text)).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(
            sidecar_text(&again, &lighting, &[], Some(&text)).unwrap(),
            text,
            "written twice, it is the same"
        );
    }

    #[test]
    fn a_bookmark_keeps_its_comment_when_one_before_it_goes() {
        let view = |name: &str| {
            format!("# Of {name}.\n[[view]]\nname = \"{name}\"\neye = [1, 1, 1]\ntarget = [0, 0, 0]\n")
        };
        let noted = format!("{}{}", view("first"), view("second"));
        let mut scene = from_text("t", OBJ, MTL, Some(&noted)).unwrap();
        scene.views.remove(0);
        let text = sidecar_text(&scene, &scene.lighting(), &[], Some(&noted)).unwrap();
        assert!(text.contains("# Of second.\n[[view]]\nname = \"second\""), "{text}");
        assert!(!text.contains("# Of first."), "{text}");
        // Written as a list it becomes tables, and is read back.
        let list = "# Views.\nview = [{ name = \"a\", eye = [1, 1, 1], target = [0, 0, 0] }]\n";
        let scene = from_text("t", OBJ, MTL, Some(list)).unwrap();
        let text = sidecar_text(&scene, &scene.lighting(), &[], Some(list)).unwrap();
        assert!(from_text("t", OBJ, MTL, Some(&text)).is_ok_and(|s| s.views[0].name == "a"), "{text}");
    }

    #[test]
    fn unit_and_axis_are_written_and_all_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.toml");
        write_frame(&path, LengthUnit::Centimetre, UpAxis::Z).unwrap();
        let scene = from_text("t", OBJ, MTL, Some(&std::fs::read_to_string(&path).unwrap())).unwrap();
        assert_eq!((scene.unit, scene.up), (LengthUnit::Centimetre, UpAxis::Z));

        std::fs::write(&path, SIDECAR).unwrap();
        let before = from_text("t", OBJ, MTL, Some(SIDECAR)).unwrap();
        write_frame(&path, before.unit, UpAxis::Z).unwrap();
        let after = from_text("t", OBJ, MTL, Some(&std::fs::read_to_string(&path).unwrap())).unwrap();
        assert_eq!((after.up, after.unit), (UpAxis::Z, before.unit));
        assert_eq!(after.lighting(), before.lighting());
        let names = |scene: &Scene| scene.views.iter().map(|v| v.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&after), names(&before));

        std::fs::write(&path, "unit = 7").unwrap();
        assert!(write_frame(&path, LengthUnit::Metre, UpAxis::Y).is_err(), "a damaged one is left alone");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "unit = 7");
    }

    #[test]
    fn a_sidecar_of_another_scene_is_refused_and_a_failure_changes_nothing() {
        let scene = from_text("t", OBJ, MTL, Some(SIDECAR)).unwrap();
        let other = SIDECAR.replace("desk", "hall_lamp");
        let message = sidecar_text(&scene, &scene.lighting(), &[], Some(&other)).unwrap_err().to_string();
        assert!(message.contains("reload"), "{message}");

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.toml");
        write_sidecar(&path, &scene, &scene.lighting(), &[]).unwrap();
        std::fs::write(&path, SIDECAR).unwrap();
        write_sidecar(&path, &scene, &scene.lighting(), &[]).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().contains("cct = 2700"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left behind");
        let nowhere = folder.path().join("none").join("t.toml");
        let message = write_sidecar(&nowhere, &scene, &scene.lighting(), &[]).unwrap_err().to_string();
        assert!(
            message.contains("cannot be written") && message.contains("nothing was changed"),
            "{message}"
        );
    }

    #[test]
    fn daylight_is_written_and_read_back_with_its_lamps_and_lamps_after_it_keep_theirs() {
        let sidecar = "# Berlin.\n[daylight]\nlatitude = 52.52 # north\nlongitude = 13.41\nzone = 2\n\
            date = \"2026-06-21\"\ntime = \"15:30\"\n[[lamp]]\nname = \"Panel\"\nposition = [0.5, 1.5, 0.5]\n\
            size = [0.2, 0.2]\nlumens = 800\n";
        let scene = from_text("t", OBJ, MTL, Some(sidecar)).unwrap();
        let same = sidecar_text(&scene, &scene.lighting(), &[], Some(sidecar)).unwrap();
        assert!(same.contains("# Berlin.") && same.contains("# north"), "{same}");
        assert!(!same.contains("sky_lamp"), "nothing was switched: {same}");
        // Another hour, a tinted sky, no sun; by night the tint is kept.
        for time in ["09:15", "23:45"] {
            let mut choice = scene.outdoors.as_ref().unwrap().choice.clone();
            (choice.time, choice.north) = (Some(time.to_owned()), Some(30.0));
            choice.sky_lamp =
                Some(super::super::OutdoorSwitch { on: true, dimmer: 0.5, factor: [0.5, 1.0, 2.0] });
            let later = scene.with_daylight(Some(&choice)).unwrap();
            let mut lighting = later.lighting();
            let outdoors = later.outdoors.as_ref().unwrap();
            lighting.lamps[outdoors.sun as usize].on = false;
            lighting.lamps.last_mut().unwrap().dimmer = 0.25;
            let text = sidecar_text(&later, &lighting, &[], Some(sidecar)).unwrap();
            let again = from_text("t", OBJ, MTL, Some(&text)).unwrap_or_else(|e| panic!("{e}\n{text}"));
            assert_eq!(again.lighting(), lighting, "{text}");
            let read = again.outdoors.as_ref().unwrap();
            assert_eq!((read.choice.time.as_deref(), read.choice.north), (Some(time), Some(30.0)));
            assert_eq!(read.daylight, outdoors.daylight);
            assert_eq!(sidecar_text(&again, &again.lighting(), &[], Some(&text)).unwrap(), text);
            // Without a sky there is none in the file.
            let none = again.with_daylight(None).unwrap();
            let text = sidecar_text(&none, &none.lighting(), &[], Some(&text)).unwrap();
            assert!(!text.contains("daylight"), "{text}");
            let names = |scene: &Scene| scene.luminaires.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
            let bare = from_text("t", OBJ, MTL, Some(&text)).unwrap_or_else(|e| panic!("{e}\n{text}"));
            assert_eq!(names(&bare), names(&none));
        }
    }
}
