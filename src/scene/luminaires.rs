//! Emitting surfaces gathered into lamps that a person recognises.

use super::colour::{black_body, normalised};
use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::names;
use super::photometric::{PhotometricFiles, PhotometricLight};
use super::selection::{Selection, material_names, shown_and_given};
use super::sidecar::{EmitsKey, LuminaireEntry, Sidecar, Source};
use super::types::{
    LUMINOUS_EFFICACY, LampState, Luminaire, Material, Scene, Surface, UpAxis, luminance_weighted,
};
use crate::geometry::{Frame, polygon};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// The parts of a scene that lamps are made of.
pub(super) struct Parts<'a> {
    pub(super) positions: &'a [DVec3],
    pub(super) objects: &'a [String],
    /// Names of `objects` in the file.
    pub(super) given_objects: &'a [String],
    pub(super) materials: &'a [Material],
    /// Exitance of each material by its Ke, W/m² per band.
    pub(super) exitance: &'a [[f64; 3]],
    /// For each surface the one that is written for its other side.
    pub(super) partners: &'a [Option<u32>],
    /// Objects and materials whose faces glow to both sides, unless an entry says otherwise.
    pub(super) both_ways: &'a HashSet<(u32, u32)>,
    pub(super) up: UpAxis,
}

impl Parts<'_> {
    fn partner(&self, surface: usize) -> Option<usize> {
        self.partners[surface].map(|p| p as usize)
    }
}

/// A surface that emits, and the one whose material says how strongly: the same, but where a lamp that
/// emits from both sides has its other side written as a face of its own.
#[derive(Clone, Copy)]
struct Member {
    surface: usize,
    like: usize,
}

/// Above this share of the area that emits by its Ke an exporter has probably written a Ke that is none.
const MOST_EMITTING: f64 = 0.3;

/// Makes the lamps: first those of the sidecar, in its order, then one for each object and emitting
/// material that no entry takes. Marks the surfaces that belong to them.
pub(super) fn gather(
    parts: &Parts<'_>,
    surfaces: &mut [Surface],
    normals: &mut Vec<DVec3>,
    sidecar: Option<(&Sidecar, Source<'_>)>,
    files: &mut PhotometricFiles<'_>,
    findings: &mut Vec<Finding>,
) -> Result<Vec<Luminaire>, SceneError> {
    let mut luminaires = Vec::new();
    let mut taken = HashSet::new();
    if let Some((sidecar, source)) = sidecar {
        for entry in &sidecar.luminaires {
            let at = entry.span().start;
            let entry = entry.get_ref();
            let entry_name = entry.display_name();
            let fail = |fault: String| {
                source.error_at(at, format!("the luminaire '{}' {fault}", names::short(&entry_name)))
            };
            if let Some(fault) = entry.fault() {
                return Err(fail(fault));
            }
            let mut lamps = lamps_of(entry, parts, surfaces).map_err(fail)?;
            if entry.emits == Some(EmitsKey::Both) {
                add_other_sides(&mut lamps, parts, surfaces);
            }
            if lamps.len() > 1 {
                let object = names::short(entry.object.as_deref().unwrap_or_default());
                let message = format!(
                    "{} objects are named '{object}', and each is a lamp of its own; objects = [\"{object}\"] makes one lamp of all",
                    lamps.len()
                );
                let finding = Finding::new(FindingKind::Lamp, Severity::Note, message);
                findings.push(finding.counted(lamps.len()));
            }
            let is_one = lamps.len() == 1;
            for (k, members) in lamps.into_iter().enumerate() {
                let object = &parts.objects[surfaces[members[0].surface].object as usize];
                let name = match (&entry.name, is_one) {
                    (Some(_), true) if !taken.insert(entry_name.clone()) => {
                        return Err(fail("is there twice; names must differ".to_owned()));
                    }
                    (Some(_), true) => entry_name.clone(),
                    (Some(_), false) => names::unique(&format!("{entry_name} {}", k + 1), &mut taken),
                    (None, true) => names::unique(&entry_name, &mut taken),
                    (None, false) => names::unique(&names::pretty(object), &mut taken),
                };
                let number = luminaires.len() as u32;
                if entry.emits == Some(EmitsKey::Back) {
                    // What is written for the other side changes places with it.
                    let both = |m: &Member| [Some(m.surface), parts.partner(m.surface)];
                    let mut turned: Vec<usize> = members.iter().flat_map(both).flatten().collect();
                    turned.sort_unstable();
                    turned.dedup();
                    turned.into_iter().for_each(|m| turn(&mut surfaces[m], normals));
                }
                let photometric = photometric(entry, parts, surfaces, &members, files).map_err(fail)?.unzip();
                let initial =
                    light(entry, parts, surfaces, &members, (number, photometric.1)).map_err(fail)?;
                let area = area(parts, surfaces, &members);
                luminaires.push(Luminaire { name, area, initial, photometric: photometric.0 });
            }
        }
    }
    let free = unclaimed(parts, surfaces);
    findings.extend(emission_everywhere(parts, surfaces, &free));
    let mut materials_of: HashMap<u32, u32> = HashMap::new();
    free.iter().for_each(|((object, _), _)| *materials_of.entry(*object).or_default() += 1);
    for ((object, material), members) in free {
        let several = materials_of[&object] > 1;
        let name =
            default_name(&parts.objects[object as usize], several, &parts.materials[material as usize].name);
        let exitance = parts.exitance[material as usize];
        let members: Vec<Member> = members.into_iter().map(|m| Member { surface: m, like: m }).collect();
        for member in &members {
            surfaces[member.surface].emission_weight = [1.0; 3];
            surfaces[member.surface].emits_back =
                parts.both_ways.contains(&(object, material)) && parts.partner(member.surface).is_none();
        }
        let initial = LampState { on: true, dimmer: 1.0, exitance };
        luminaires.push(Luminaire {
            name: names::unique(&name, &mut taken),
            area: area(parts, surfaces, &members),
            initial,
            photometric: None,
        });
        for member in members {
            surfaces[member.surface].luminaire = Some(luminaires.len() as u32 - 1);
        }
    }
    Ok(luminaires)
}

fn default_name(object: &str, several: bool, material: &str) -> String {
    if several { format!("{} ({})", names::pretty(object), material) } else { names::pretty(object) }
}

/// Emitting surfaces that no lamp has yet, by object and material in order of first use.
fn unclaimed(parts: &Parts<'_>, surfaces: &[Surface]) -> Vec<((u32, u32), Vec<usize>)> {
    let mut order: Vec<((u32, u32), Vec<usize>)> = Vec::new();
    let mut numbers: HashMap<(u32, u32), usize> = HashMap::new();
    for (index, surface) in surfaces.iter().enumerate() {
        if surface.luminaire.is_none() && emits(parts, surface) {
            let key = (surface.object, surface.material);
            let number = *numbers.entry(key).or_insert_with(|| {
                order.push((key, Vec::new()));
                order.len() - 1
            });
            order[number].1.push(index);
        }
    }
    order
}

fn emits(parts: &Parts<'_>, surface: &Surface) -> bool {
    parts.exitance[surface.material as usize].iter().any(|e| *e > 0.0)
}

fn surface_area(positions: &[DVec3], surface: &Surface) -> f64 {
    let outline: Vec<DVec3> = surface.corners.iter().map(|c| positions[c.position as usize]).collect();
    polygon::area_vector(&outline).length()
}

/// Emitting area: both sides count where both emit.
fn area(parts: &Parts<'_>, surfaces: &[Surface], members: &[Member]) -> f64 {
    let of = |surface: &Surface| {
        surface_area(parts.positions, surface) * if surface.emits_back { 2.0 } else { 1.0 }
    };
    members.iter().map(|m| of(&surfaces[m.surface])).sum()
}

/// A warning where much of the model emits, and no sidecar says that it is to.
fn emission_everywhere(
    parts: &Parts<'_>,
    surfaces: &[Surface],
    free: &[((u32, u32), Vec<usize>)],
) -> Option<Finding> {
    let area = |surface: &Surface| surface_area(parts.positions, surface);
    let emitting: f64 = free.iter().flat_map(|(_, members)| members).map(|&m| area(&surfaces[m])).sum();
    let share = emitting / surfaces.iter().map(area).sum::<f64>();
    if share.is_nan() || share <= MOST_EMITTING {
        return None;
    }
    let materials = names::list(free.iter().map(|((_, m), _)| parts.materials[*m as usize].name.as_str()));
    let message = format!(
        "{:.0} % of the area emits light, by the Ke of {materials}; if these are no lamps, an exporter has \
         written a Ke for them: remove it",
        100.0 * share
    );
    Some(Finding::new(FindingKind::Lamp, Severity::Warning, message).counted(free.len()))
}

/// The lamps of an entry by their surfaces: of those selected and free the ones that emit, or all if none
/// does. An entry for one `object` makes a lamp of each that has this name in the file.
fn lamps_of(
    entry: &LuminaireEntry,
    parts: &Parts<'_>,
    surfaces: &[Surface],
) -> Result<Vec<Vec<Member>>, String> {
    let objects = shown_and_given(parts.objects, parts.given_objects);
    let selection = Selection::of(entry, &objects, &material_names(parts.materials))?;
    let mut members: Vec<usize> = (0..surfaces.len()).filter(|&i| selection.holds(&surfaces[i])).collect();
    if members.is_empty() {
        return Err("selects no surface: no face of that object has that material".to_owned());
    }
    members.retain(|&i| surfaces[i].luminaire.is_none());
    if members.is_empty() {
        return Err("selects only surfaces that an entry above it has taken".to_owned());
    }
    if members.iter().any(|&i| emits(parts, &surfaces[i])) {
        members.retain(|&i| emits(parts, &surfaces[i]));
    }
    let mut by_object: BTreeMap<u32, Vec<Member>> = BTreeMap::new();
    for member in members {
        let object = if selection.each { surfaces[member].object } else { 0 };
        by_object.entry(object).or_default().push(Member { surface: member, like: member });
    }
    Ok(by_object.into_values().collect())
}

/// Adds the faces that are written for the other sides of these, but for those that emit by themselves.
fn add_other_sides(lamps: &mut [Vec<Member>], parts: &Parts<'_>, surfaces: &[Surface]) {
    let own: HashSet<usize> = lamps.iter().flatten().map(|m| m.surface).collect();
    let is_free = |&other: &usize| {
        !own.contains(&other) && surfaces[other].luminaire.is_none() && !emits(parts, &surfaces[other])
    };
    let other_side =
        |like: usize| parts.partner(like).filter(is_free).map(|surface| Member { surface, like });
    for members in lamps {
        let others: Vec<Member> = members.iter().filter_map(|m| other_side(m.surface)).collect();
        members.extend(others);
    }
}

/// The photometric light of a lamp and its lumens, where its entry names a file: a luminaire on each of its objects.
fn photometric(
    entry: &LuminaireEntry,
    parts: &Parts<'_>,
    surfaces: &[Surface],
    members: &[Member],
    files: &mut PhotometricFiles<'_>,
) -> Result<Option<(PhotometricLight, f64)>, String> {
    let Some(file) = &entry.photometry else { return Ok(None) };
    let photometry = files.read(file)?;
    let mut by_object: BTreeMap<u32, Vec<Vec<DVec3>>> = BTreeMap::new();
    for member in members {
        let surface = &surfaces[member.surface];
        let corners = surface.corners.iter().map(|corner| parts.positions[corner.position as usize]);
        by_object.entry(surface.object).or_default().push(corners.collect());
    }
    let hung: Vec<(DVec3, Frame)> = by_object
        .values()
        .map(|faces| {
            let attitude = entry.attitude(mean_normal(faces));
            let frame = attitude.frame(parts.up);
            (photometric_centre(faces, -frame.normal), frame)
        })
        .collect();
    let light = PhotometricLight::new(photometry, &hung, parts.up);
    let Some((light, lumens)) = light else {
        return Err(format!("is dark: all intensities of '{}' are 0", names::short(file)));
    };
    Ok(Some((light, lumens)))
}

/// The mean unit normal of faces by their areas; `None` of closed bodies.
fn mean_normal(faces: &[Vec<DVec3>]) -> Option<DVec3> {
    let sum: DVec3 = faces.iter().map(|face| polygon::area_vector(face)).sum();
    let area: f64 = faces.iter().map(|face| polygon::area_vector(face).length()).sum();
    (sum.length() > 1e-3 * area).then(|| sum.normalize())
}

/// The centroid of the faces that look where a luminaire shines, the more the straighter; of all where none does.
fn photometric_centre(faces: &[Vec<DVec3>], aim: DVec3) -> DVec3 {
    let (mut sums, mut weights) = ([DVec3::ZERO; 2], [0.0; 2]);
    for face in faces {
        let whole = polygon::area_vector(face);
        let facing = whole.dot(aim).max(0.0);
        for triangle in face[1..].windows(2) {
            let [a, b, c] = [face[0], triangle[0], triangle[1]];
            let area = (b - a).cross(c - a).dot(whole.normalize_or_zero());
            for (k, share) in [facing / whole.length().max(f64::MIN_POSITIVE), 1.0].into_iter().enumerate() {
                sums[k] += (a + b + c) * (area * share / 3.0);
                weights[k] += area * share;
            }
        }
    }
    let k = usize::from(weights[0] <= 1e-6 * weights[1]);
    if weights[k] > 0.0 { sums[k] / weights[k] } else { faces[0][0] }
}

/// Sets the emission of a lamp's surfaces and returns its state; `lumens` are those of its photometry.
///
/// The exitance is the largest of its surfaces per band, so that all weights lie in 0..1.
fn light(
    entry: &LuminaireEntry,
    parts: &Parts<'_>,
    surfaces: &mut [Surface],
    members: &[Member],
    (number, lumens): (u32, Option<f64>),
) -> Result<LampState, String> {
    let is_photometric = lumens.is_some();
    let lumens = entry.lumens.or(lumens);
    let given: Vec<[f64; 3]> =
        members.iter().map(|m| parts.exitance[surfaces[m.like].material as usize]).collect();
    let mut largest = [0.0_f64; 3];
    for exitance in &given {
        for band in 0..3 {
            largest[band] = largest[band].max(exitance[band]);
        }
    }
    let dark = largest == [0.0; 3];
    for (member, exitance) in members.iter().zip(&given) {
        let surface = &mut surfaces[member.surface];
        surface.luminaire = Some(number);
        let is_both =
            entry.emits.map_or(parts.both_ways.contains(&(surface.object, surface.material)), |emits| {
                emits == EmitsKey::Both
            });
        surface.emits_back = is_both && parts.partner(member.surface).is_none();
        for band in 0..3 {
            // A band that no surface emits by itself is the same for all when the entry gives it one.
            let is_even = is_photometric || largest[band] <= 0.0;
            surface.emission_weight[band] = if is_even { 1.0 } else { exitance[band] / largest[band] };
        }
    }
    let state =
        |exitance| LampState { on: entry.on.unwrap_or(true), dimmer: entry.dimmer.unwrap_or(1.0), exitance };
    if let Some(exitance) = entry.exitance {
        return Ok(state(exitance));
    }
    if dark && lumens.is_none() {
        return Err("gives no strength, and its surfaces have no Ke; add lumens or exitance".to_owned());
    }
    let colour = match (entry.cct, entry.colour) {
        (Some(kelvin), _) => normalised(black_body(kelvin)),
        (_, Some(colour)) => normalised(colour),
        _ => normalised(if dark { [1.0; 3] } else { largest }),
    };
    let Some(colour) = colour else { return Err("must have a colour".to_owned()) };
    let Some(lumens) = lumens else {
        if entry.cct.is_none() && entry.colour.is_none() {
            return Ok(state(largest));
        }
        let strength = luminance_weighted(largest);
        return Ok(state(colour.map(|c| c * strength)));
    };
    let per_unit: f64 = members.iter().map(|m| flux(parts.positions, &surfaces[m.surface], colour)).sum();
    let factor = lumens / per_unit;
    if !factor.is_finite() {
        return Err("cannot give that many lumens: its surfaces emit nothing in that colour".to_owned());
    }
    Ok(state(colour.map(|c| c * factor)))
}

/// Lumens that a surface emits when its lamp has this exitance.
fn flux(positions: &[DVec3], surface: &Surface, exitance: [f64; 3]) -> f64 {
    let weight = surface.emission_weight;
    let own = [exitance[0] * weight[0], exitance[1] * weight[1], exitance[2] * weight[2]];
    let sides = if surface.emits_back { 2.0 } else { 1.0 };
    LUMINOUS_EFFICACY * luminance_weighted(own) * surface_area(positions, surface) * sides
}

/// Makes the back of a surface its front.
pub(super) fn turn(surface: &mut Surface, normals: &mut Vec<DVec3>) {
    surface.corners.reverse();
    for corner in &mut surface.corners {
        if let Some(normal) = corner.normal {
            normals.push(-normals[normal as usize]);
            corner.normal = Some(normals.len() as u32 - 1);
        }
    }
}

/// Luminous flux of every lamp at full output and as it comes with the file, lumens.
pub fn lumens(scene: &Scene) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]; scene.luminaires.len()];
    for surface in &scene.surfaces {
        if let Some(number) = surface.luminaire {
            let initial = &scene.luminaires[number as usize].initial;
            sums[number as usize][0] += flux(&scene.positions, surface, initial.exitance);
            sums[number as usize][1] += flux(&scene.positions, surface, initial.output());
        }
    }
    for (sum, lamp) in sums.iter_mut().zip(&scene.luminaires).filter(|(_, lamp)| lamp.photometric.is_some()) {
        let full = |exitance| LUMINOUS_EFFICACY * luminance_weighted(exitance) * lamp.area;
        *sum = [full(lamp.initial.exitance), full(lamp.initial.output())];
    }
    sums
}

/// Objects and materials of each lamp's surfaces, as names.
pub(super) fn selectors(scene: &Scene) -> Vec<(Vec<String>, Vec<String>)> {
    let mut found = vec![(BTreeMap::new(), BTreeMap::new()); scene.luminaires.len()];
    for surface in &scene.surfaces {
        if let Some(number) = surface.luminaire {
            let (objects, materials) = &mut found[number as usize];
            objects.insert(surface.object, scene.objects[surface.object as usize].clone());
            materials.insert(surface.material, scene.materials[surface.material as usize].name.clone());
        }
    }
    found.into_iter().map(|(o, m)| (o.into_values().collect(), m.into_values().collect())).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Scene, SceneError, from_text};
    use super::*;
    use std::f64::consts::PI;

    /// Two lamps of 1 m² with different Ke, a third with the material of the first, and a floor.
    const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n\
        v 0 3 0\nv 1 3 0\nv 1 3 1\nv 0 3 1\nv 0 4 0\nv 2 4 0\nv 2 4 1\nv 0 4 1\n\
        o floor\nusemtl white\nf 4 3 2 1\no hall_lamp\nusemtl bright\nf 5 6 7 8\nusemtl dim\nf 9 10 11 12\n\
        o desk\nusemtl bright\nf 13 14 15 16\n";
    const MTL: &str =
        "newmtl white\nKd 0.8 0.8 0.8\nnewmtl bright\nKd 0 0 0\nKe 4 2 1\nnewmtl dim\nKd 0 0 0\nKe 1 1 2\n";

    fn scene(sidecar: &str) -> Result<Scene, SceneError> {
        from_text("t", OBJ, MTL, Some(sidecar))
    }

    fn one(entry: &str) -> Scene {
        scene(&format!("[[luminaire]]\n{entry}")).unwrap()
    }

    #[test]
    fn each_object_and_emitting_material_is_a_lamp_and_radiance_becomes_exitance() {
        let scene = from_text("t", OBJ, MTL, None).unwrap();
        let names: Vec<&str> = scene.luminaires.iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["Hall lamp (bright)", "Hall lamp (dim)", "Desk"]);
        assert_eq!(scene.luminaires[0].initial.exitance, [4.0 * PI, 2.0 * PI, PI]);
        assert_eq!(scene.luminaires[2].area, 2.0);
        assert_eq!(scene.surfaces[0].luminaire, None);
        assert_eq!(scene.surfaces[0].emission_weight, [0.0; 3]);
        assert!(scene.surfaces[1..].iter().all(|s| s.emission_weight == [1.0; 3]));
    }

    #[test]
    fn a_lamp_of_unlike_surfaces_keeps_their_exitances() {
        let scene = one("object = \"hall_lamp\"\nname = \"Hall\"");
        assert_eq!(scene.luminaires.len(), 2);
        let exitance = scene.luminaires[0].initial.exitance;
        for (surface, ke) in scene.surfaces[1..3].iter().zip([[4.0, 2.0, 1.0], [1.0, 1.0, 2.0]]) {
            for band in 0..3 {
                let own = exitance[band] * surface.emission_weight[band];
                assert!((own - PI * ke[band]).abs() < 1e-12);
                assert!((0.0..=1.0).contains(&surface.emission_weight[band]));
            }
        }
    }

    #[test]
    fn lumens_are_the_flux_over_all_surfaces_and_both_sides() {
        // 179 lm/W of luminance-weighted exitance: 800 lm over 2 m² of white is 2.2346 W/m² a band.
        let scene = one("object = \"desk\"\nlumens = 800\ncolour = [3, 3, 3]");
        let exitance = scene.luminaires[0].initial.exitance;
        assert!(
            (exitance[0] - 800.0 / 179.0 / 2.0).abs() < 1e-12 && exitance[0] == exitance[2],
            "{exitance:?}"
        );
        for entry in [
            "object = \"desk\"\nlumens = 800",
            "object = \"desk\"\nlumens = 800\ncct = 2700\nemits = \"both\"",
            "objects = [\"desk\", \"hall_lamp\"]\nlumens = 800\ncolour = [0, 1, 0.5]",
            "material = \"white\"\nlumens = 800\ndimmer = 0.25",
        ] {
            let scene = one(entry);
            let [full, initial] = lumens(&scene)[0];
            assert!((full - 800.0).abs() < 1e-9, "{entry}: {full}");
            assert!((initial - full * scene.luminaires[0].initial.dimmer).abs() < 1e-9);
        }
    }

    #[test]
    fn colour_alone_keeps_the_luminance_and_lumens_alone_keep_the_colour() {
        let given = luminance_weighted([4.0 * PI, 2.0 * PI, PI]);
        let scene = one("object = \"desk\"\ncolour = [0, 0, 7]");
        let blue = scene.luminaires[0].initial.exitance;
        assert!((luminance_weighted(blue) - given).abs() < 1e-9 && blue[0] == 0.0);
        let scene = one("object = \"desk\"\nlumens = 100");
        let warm = scene.luminaires[0].initial.exitance;
        assert!((warm[0] / warm[1] - 2.0).abs() < 1e-12 && (warm[1] / warm[2] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn back_emitters_are_turned_and_states_are_kept() {
        let front = one("object = \"desk\"");
        let back = one("object = \"desk\"\nemits = \"back\"\non = false\ndimmer = 0.5\nexitance = [1, 2, 3]");
        let normal = |scene: &Scene| polygon::area_vector(&scene.polygon(&scene.surfaces[3]));
        assert_eq!(normal(&front), -normal(&back));
        assert_eq!(
            back.luminaires[0].initial,
            LampState { on: false, dimmer: 0.5, exitance: [1.0, 2.0, 3.0] }
        );
        assert!(!back.surfaces[3].emits_back);
    }

    /// Two downlights of one name, the second with two faces, and a third whose name differs in capitals.
    const SAME: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n\
        o floor\nusemtl white\nf 4 3 2 1\no spot\nusemtl bright\nf 5 6 7\no spot\nf 5 7 8\no Desk_Lamp\nusemtl dim\nf 1 2 6 5\n";

    #[test]
    fn objects_of_one_name_are_lamps_of_their_own() {
        let read = |entry: &str| from_text("t", SAME, MTL, Some(&format!("[[luminaire]]\n{entry}"))).unwrap();
        let names = |scene: &Scene| scene.luminaires.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
        let plain = from_text("t", SAME, MTL, None).unwrap();
        assert_eq!(names(&plain), ["Spot 1", "Spot 2", "Desk Lamp"]);
        let each = read("object = \"spot\"\nlumens = 800");
        assert_eq!(names(&each), ["Spot 1", "Spot 2", "Desk Lamp"]);
        assert!(lumens(&each)[..2].iter().all(|[full, _]| (full - 800.0).abs() < 1e-9));
        assert!(each.findings.iter().any(|f| f.message.starts_with("2 objects are named 'spot'")));
        assert_eq!(names(&read("object = \"spot\"\nname = \"Hall\"")), ["Hall 1", "Hall 2", "Desk Lamp"]);
        let one = read("objects = [\"spot\"]\nlumens = 800");
        assert_eq!(names(&one), ["Spot", "Desk Lamp"]);
        assert!((lumens(&one)[0][0] - 800.0).abs() < 1e-9);
        assert_eq!(names(&read("object = \"SPOT 2\"")), ["SPOT 2", "Spot 1", "Desk Lamp"]);
        assert_eq!(names(&read("object = \"desk lamp\"\nname = \"D\"")), ["D", "Spot 1", "Spot 2"]);
    }

    #[test]
    fn emission_on_everything_is_told_with_its_share() {
        let told =
            |scene: &Scene| scene.findings.iter().find(|f| f.message.contains("of the area emits")).cloned();
        let all =
            from_text("t", SAME, &MTL.replace("Kd 0.8 0.8 0.8", "Kd 0.8 0.8 0.8\nKe 1 1 1"), None).unwrap();
        let finding = told(&all).unwrap();
        assert!(finding.message.starts_with("100 % of the area") && finding.severity == Severity::Warning);
        let sidecar = "[[luminaire]]\nmaterials = [\"bright\", \"dim\"]";
        assert_eq!(told(&from_text("t", SAME, MTL, Some(sidecar)).unwrap()), None);
    }

    #[test]
    fn a_lamp_that_matches_nothing_names_its_line_and_the_nearest_names() {
        for (entry, expected) in [
            (
                "object = \"dsk\"",
                "t.toml, line 2: the luminaire 'Dsk' asks for the object 'dsk', which is not there; the nearest names are 'desk'",
            ),
            ("material = \"brigt\"", "the nearest names are 'bright'"),
            ("object = \"floor\"\nmaterial = \"dim\"", "selects no surface"),
            ("object = \"floor\"", "add lumens or exitance"),
            (
                "object = \"desk\"\n[[luminaire]]\nmaterials = [\"bright\"]\nobject = \"desk\"",
                "line 4: the luminaire 'Desk' selects only surfaces",
            ),
            (
                "object = \"desk\"\nname = \"a\"\n[[luminaire]]\nobject = \"hall_lamp\"\nname = \"a\"",
                "is there twice",
            ),
            ("name = \"a\"", "must name an object or a material"),
            ("object = \"desk\"\nlumens = 1\nexitance = [1, 1, 1]", "both lumens and exitance"),
            ("object = \"desk\"\ncct = 500", "between 1000 and 40000"),
            ("object = \"desk\"\ncct = nan", "between 1000 and 40000"),
            ("object = \"desk\"\nlumens = -1", "lumens of 0 or more"),
            ("object = \"desk\"\nlumens = inf", "lumens of 0 or more"),
            ("object = \"desk\"\ndimmer = 1.5", "dimmer between 0 and 1"),
            ("object = \"desk\"\ncolour = [0, 0, 0]", "not all 0"),
        ] {
            let message = scene(&format!("\n[[luminaire]]\n{entry}")).expect_err(entry).to_string();
            assert!(message.contains(expected), "{entry}: {message}");
        }
    }
}
