//! What names mean: objects, materials and lamps as a person writes them.

use super::names;
use super::sidecar::{LuminaireEntry, Sidecar};
use super::sides::partners;
use super::text::folded;
use super::types::{Material, Scene, Surface};
use std::collections::{BTreeSet, HashSet};
use std::ops::Range;

/// A name as it is shown, which no other has, and as the file gives it, which several may have.
pub(super) type ShownAndGiven<'a> = (&'a str, &'a str);

/// Which of `names` somebody means by `wanted`.
///
/// The first of these that fits counts: a shown name, a name in the file, and both without regard to
/// capitals, underscores and blanks.
///
/// # Errors
/// Where it could be several names of the file, those.
pub(super) fn meant<'a>(wanted: &str, names: &[ShownAndGiven<'a>]) -> Result<Vec<usize>, Vec<&'a str>> {
    let plain = folded(wanted);
    type Test<'t> = &'t dyn Fn(&str, &str) -> bool;
    let tests: [Test<'_>; 4] = [
        &|shown, _| shown == wanted,
        &|_, given| given == wanted,
        &|shown, _| folded(shown) == plain,
        &|_, given| folded(given) == plain,
    ];
    for test in tests {
        let numbered = names.iter().enumerate();
        let found: Vec<usize> =
            numbered.filter(|(_, (shown, given))| test(shown, given)).map(|(index, _)| index).collect();
        let mut distinct: Vec<&str> = found.iter().map(|&index| names[index].1).collect();
        distinct.sort_unstable();
        distinct.dedup();
        match distinct.len() {
            0 => {}
            1 => return Ok(found),
            _ => return Err(distinct),
        }
    }
    Ok(Vec::new())
}

/// The objects and materials that an entry selects.
pub(super) struct Selection {
    /// Which objects, and whether the entry means each of them by itself.
    objects: Vec<bool>,
    pub(super) each: bool,
    materials: Vec<bool>,
}

impl Selection {
    pub(super) fn of(
        entry: &LuminaireEntry,
        objects: &[ShownAndGiven<'_>],
        materials: &[ShownAndGiven<'_>],
    ) -> Result<Self, String> {
        let pick = |kind: &str, wanted: &mut dyn Iterator<Item = &str>, names: &[ShownAndGiven<'_>]| {
            let mut chosen = None;
            for name in wanted {
                let found = meant(name, names).map_err(|several| {
                    let (name, several) = (names::short(name), names::list(several));
                    format!("asks for the {kind} '{name}', which could be any of {several}; write the name as it is")
                })?;
                if found.is_empty() {
                    let near = names::list(names::nearest(name, names.iter().map(|(shown, _)| *shown)));
                    let name = names::short(name);
                    return Err(format!(
                        "asks for the {kind} '{name}', which is not there; the nearest names are {near}"
                    ));
                }
                let chosen = chosen.get_or_insert_with(|| vec![false; names.len()]);
                found.into_iter().for_each(|index| chosen[index] = true);
            }
            Ok(chosen.unwrap_or_else(|| vec![true; names.len()]))
        };
        Ok(Self {
            objects: pick("object", &mut entry.objects(), objects)?,
            each: entry.object.is_some() && entry.objects.is_empty(),
            materials: pick("material", &mut entry.materials(), materials)?,
        })
    }

    /// Whether a surface is selected.
    pub(super) fn holds(&self, surface: &Surface) -> bool {
        let at = |list: &[bool], index: u32| list.get(index as usize).copied().unwrap_or(false);
        at(&self.objects, surface.object) && at(&self.materials, surface.material)
    }
}

/// Names of objects.
pub(super) fn shown_and_given<'a>(objects: &'a [String], given: &'a [String]) -> Vec<ShownAndGiven<'a>> {
    objects.iter().map(String::as_str).zip(given.iter().map(String::as_str)).collect()
}

/// Names of materials, which are shown as the file gives them.
pub(super) fn material_names(materials: &[Material]) -> Vec<ShownAndGiven<'_>> {
    materials.iter().map(|material| (material.name.as_str(), material.name.as_str())).collect()
}

/// The lamps that the entries of a sidecar have made, as ranges of [`Scene::luminaires`]; `None` where the
/// sidecar is not the one that the scene was read with.
pub(super) fn lamps_of_entries(scene: &Scene, sidecar: &Sidecar) -> Option<Vec<Range<usize>>> {
    let objects = shown_and_given(&scene.objects, &scene.given_objects);
    let materials = material_names(&scene.materials);
    // Each surface with that which is written for its other side.
    let mut of_lamps: Vec<Vec<[Option<&Surface>; 2]>> = vec![Vec::new(); scene.own_luminaires()];
    for (surface, partner) in scene.surfaces.iter().zip(partners(&scene.positions, &scene.surfaces)) {
        if let Some(lamp) = surface.luminaire.filter(|&lamp| (lamp as usize) < scene.own_luminaires()) {
            let other = partner.and_then(|other| scene.surfaces.get(other as usize));
            of_lamps.get_mut(lamp as usize)?.push([Some(surface), other]);
        }
    }
    let mut ranges = Vec::new();
    let mut next = 0;
    for entry in &sidecar.luminaires {
        let selection = Selection::of(entry.get_ref(), &objects, &materials).ok()?;
        let start = next;
        let mut seen = HashSet::new();
        while let Some(surfaces) = of_lamps.get(next) {
            let held = |sides: &[Option<&Surface>; 2]| -> Option<u32> {
                sides.iter().flatten().find(|side| selection.holds(side)).map(|side| side.object)
            };
            let Some(objects) = surfaces.iter().map(held).collect::<Option<Vec<u32>>>() else { break };
            // Of an entry that makes several lamps each is another object.
            if next > start && !(selection.each && objects.iter().all(|object| !seen.contains(object))) {
                break;
            }
            seen.extend(objects);
            next += 1;
        }
        if next == start {
            return None;
        }
        ranges.push(start..next);
    }
    Some(ranges)
}

/// See [`Scene::luminaires_named`].
pub(super) fn named(scene: &Scene, name: &str) -> Vec<usize> {
    let lamps: Vec<ShownAndGiven<'_>> =
        scene.luminaires.iter().map(|lamp| (lamp.name.as_str(), lamp.name.as_str())).collect();
    // Names that could be several are those of all.
    let all = |names: &[ShownAndGiven<'_>]| match meant(name, names) {
        Ok(found) => found,
        Err(several) => (0..names.len()).filter(|&index| several.contains(&names[index].1)).collect(),
    };
    let own = all(&lamps);
    if !own.is_empty() {
        return own;
    }
    let of_surfaces = |chosen: &dyn Fn(&Surface) -> bool| {
        let surfaces = scene.surfaces.iter().filter(|surface| chosen(surface));
        let lamps: BTreeSet<usize> =
            surfaces.filter_map(|surface| surface.luminaire).map(|l| l as usize).collect();
        lamps.into_iter().collect::<Vec<_>>()
    };
    let objects: HashSet<u32> =
        all(&shown_and_given(&scene.objects, &scene.given_objects)).into_iter().map(|o| o as u32).collect();
    let found = of_surfaces(&|surface| objects.contains(&surface.object));
    if !found.is_empty() {
        return found;
    }
    let materials: HashSet<u32> =
        all(&material_names(&scene.materials)).into_iter().map(|m| m as u32).collect();
    of_surfaces(&|surface| materials.contains(&surface.material))
}

#[cfg(test)]
mod tests {
    use super::super::from_text;

    /// Two downlights of one name, the second with two faces, and a third whose name differs in capitals.
    const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n\
        o floor\nusemtl white\nf 4 3 2 1\no spot\nusemtl bright\nf 5 6 7\no spot\nf 5 7 8\no Desk_Lamp\nusemtl dim\nf 1 2 6 5\n";

    const MTL: &str =
        "newmtl white\nKd 0.8 0.8 0.8\nnewmtl bright\nKd 0 0 0\nKe 4 2 1\nnewmtl dim\nKd 0 0 0\nKe 1 1 2\n";

    #[test]
    fn lamps_are_found_by_their_names_or_those_of_objects_and_materials() {
        let scene =
            from_text("t", OBJ, MTL, Some("[[luminaire]]\nobject = \"Desk_Lamp\"\nname = \"Reader\""))
                .unwrap();
        for (name, expected) in [
            ("Reader", vec![0]),
            ("reader", vec![0]),
            ("desk lamp", vec![0]),
            ("spot_2", vec![2]),
            ("Spot", vec![1, 2]),
            ("BRIGHT", vec![1, 2]),
            ("dim", vec![0]),
            ("floor", vec![]),
            ("nothing", vec![]),
        ] {
            assert_eq!(scene.luminaires_named(name), expected, "{name}");
        }
    }

    #[test]
    fn a_name_means_what_fits_best() {
        let names =
            [("lamp 1", "lamp"), ("lamp 2", "lamp"), ("Desk_lamp", "Desk_lamp"), ("desk lamp", "desk lamp")];
        let meant = |wanted| super::meant(wanted, &names);
        assert_eq!(meant("lamp"), Ok(vec![0, 1]));
        assert_eq!(meant("LAMP_2"), Ok(vec![1]));
        assert_eq!(meant("Lamp"), Ok(vec![0, 1]));
        assert_eq!(meant("desk lamp"), Ok(vec![3]));
        assert_eq!(meant("DESK LAMP"), Err(vec!["Desk_lamp", "desk lamp"]));
        assert_eq!(meant("roof"), Ok(vec![]));
    }
}
