//! Whether a model lies on its side, and whether it is in the unit that it is read in.
//!
//! OBJ files say neither. What speaks for an axis are lamps, which shine down; names of floors and
//! ceilings; level area, in buildings more than upright area in any one direction; and furniture, which
//! stands on one level. Geometry alone has to be clear, as a front of a house looks like a floor that
//! lies. What speaks for a unit is the height of the rooms.

use super::extent::Extent;
use super::finding::{Finding, FindingKind, Severity};
use super::space::Space;
use super::types::{FrameChoice, LengthUnit, Scene, SceneSource, UpAxis};
use crate::geometry::{Aabb, polygon};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Words for floors and ceilings in names of objects and materials.
const FLOORS: [&str; 8] = ["floor", "boden", "vloer", "plancher", "pavimento", "suelo", "carpet", "parquet"];
const CEILINGS: [&str; 6] = ["ceiling", "decke", "plafond", "soffitto", "techo", "ceil_"];
/// Votes that +z needs to be proposed.
const ENOUGH: f64 = 3.0;
/// Votes that it needs more than +y has.
const LEAD: f64 = 2.0;
/// A face is perpendicular to an axis where its normal is this near to it.
const ALIGNED: f64 = 0.985;
/// Levels are told apart by this share of the height.
const LEVELS: usize = 250;

/// Rooms are this high, metres.
const ROOM_HEIGHT: RangeInclusive<f64> = 2.0..=4.5;
/// Lower and higher ones make one doubt the unit.
const BELIEVABLE_ROOM: RangeInclusive<f64> = 0.3..=6.5;
/// Rooms of this height are halls in metres, or rooms in feet.
const HALL_OR_FEET: RangeInclusive<f64> = 6.5..=14.0;
/// Higher ones are none of either.
const HIGHEST_HALL: f64 = 20.0;
/// Houses are this high, metres.
const HOUSE_HEIGHT: RangeInclusive<f64> = 2.0..=15.0;
/// Heights that models have on purpose, metres.
const BELIEVABLE_HEIGHT: RangeInclusive<f64> = 0.3..=60.0;
/// Beyond these extents a model is no building, metres.
const BELIEVABLE_EXTENT: RangeInclusive<f64> = 1e-4..=1e5;

/// What a model is taken for.
pub(super) struct Judgement {
    /// What to tell, worst first.
    pub(super) findings: Vec<Finding>,
    /// Metres of the model to one of an adult, above zero.
    pub(super) scale: f64,
}

/// Judges a scene whose unit and up axis were `stated` by its sidecar or by the user: what is stated is
/// not doubted, unless it makes a thing of the size of an atom or of a country.
pub(super) fn judge(scene: &Scene, extent: &Extent, space: &Space, stated: FrameChoice) -> Judgement {
    let lies = stated.up.is_none().then(|| up_evidence(scene, extent)).and_then(|e| e.proposal());
    let up = if lies.is_some() { UpAxis::Z } else { scene.up };
    let room = space.headroom(up.vector());
    let height = extent.main.size().dot(up.vector());
    let unit = doubted_unit(scene, extent, space, stated, up, room);

    let mut findings = Vec::new();
    let proposed = unit.as_ref().and_then(|doubt| doubt.proposal);
    if let Some(reasons) = lies {
        let message = format!(
            "the model seems to lie on its side: {reasons}; if so, choose z up: {}",
            how_to(scene, "Z is up", "--up z", "up = \"z\"")
        );
        findings.push(
            Finding::new(FindingKind::UpAxis, Severity::Warning, message)
                .with("light is the same either way; only views and walking take +y for up")
                .remedied(proposed.unwrap_or(scene.unit), UpAxis::Z),
        );
    }
    if let Some(doubt) = unit {
        let finding = Finding::new(FindingKind::Unit, doubt.severity, doubt.message)
            .with("lux stay the same in a model of any size, if lamps are given by Ke; lumens do not");
        findings.push(match doubt.proposal {
            Some(unit) => finding.remedied(unit, up),
            None => finding,
        });
    }
    // 1. In the unit proposed, people are people. 2. In the one that is, unless no room fits them.
    let adult = match proposed {
        Some(unit) => scene.unit.metres() / unit.metres(),
        None => 1.0,
    };
    let here = if up == scene.up { room } else { space.headroom(scene.up.vector()) };
    let tall = here.unwrap_or(if height > 0.0 { height } else { 0.6 * extent.main.diagonal() });
    let scale = if tall > HIGHEST_HALL * adult { 0.25 * tall } else { adult.min(tall / 2.4) };
    Judgement { findings, scale: if scale > 0.0 && scale.is_finite() { scale } else { 1.0 } }
}

/// How the user may follow an advice.
fn how_to(scene: &Scene, entry: &str, option: &str, key: &str) -> String {
    match &scene.source {
        SceneSource::Builtin(_) => format!("{key} in {}.toml", scene.name),
        _ => format!(
            "File > Unit and up axis > {entry}, {option} on the command line, or {key} in {}.toml",
            scene.name
        ),
    }
}

struct Doubt {
    proposal: Option<LengthUnit>,
    severity: Severity,
    message: String,
}

fn doubted_unit(
    scene: &Scene,
    extent: &Extent,
    space: &Space,
    stated: FrameChoice,
    up: UpAxis,
    room: Option<f64>,
) -> Option<Doubt> {
    use LengthUnit::{Centimetre, Foot, Inch, Metre, Millimetre};
    let longest = extent.main.size().max_element();
    let absurd = !BELIEVABLE_EXTENT.contains(&longest);
    if stated.unit.is_some() && !absurd {
        return None;
    }
    let height = extent.main.size().dot(up.vector());
    // Rooms tell more than the whole, which may be a tower.
    let (what, size, wanted) = match room {
        Some(room) => ("its rooms are", room, ROOM_HEIGHT),
        None => ("the model is", height, HOUSE_HEIGHT),
    };
    let in_unit = |unit: LengthUnit| size / scene.unit.metres() * unit.metres();
    let all = [Millimetre, Centimetre, Metre, Foot, Inch].into_iter().filter(|&unit| unit != scene.unit);
    let fitting: Vec<LengthUnit> = all.filter(|&unit| wanted.contains(&in_unit(unit))).collect();
    let (doubted, severity) = match room {
        _ if absurd => (true, Severity::Warning),
        Some(room) if BELIEVABLE_ROOM.contains(&room) => (false, Severity::Note),
        // Furniture decides between a hall in metres and a room in feet; an empty one may be either.
        Some(room) if HALL_OR_FEET.contains(&room) => match furniture(space, up.vector()) {
            Furniture::InMetres => (false, Severity::Note),
            Furniture::InFeet => (true, Severity::Warning),
            Furniture::None => (fitting.contains(&Foot), Severity::Note),
        },
        Some(room) if room > HIGHEST_HALL => {
            (true, if fitting.is_empty() { Severity::Note } else { Severity::Warning })
        }
        Some(room) if room > *BELIEVABLE_ROOM.end() => (!fitting.is_empty(), Severity::Note),
        _ => (height > 0.0 && !BELIEVABLE_HEIGHT.contains(&height) && !fitting.is_empty(), Severity::Warning),
    };
    if !doubted {
        return None;
    }
    let proposal = fitting.first().copied();
    let message = match proposal {
        Some(unit) => {
            let symbol = unit.symbol();
            format!(
                "{what} {} m high; in {} {} be {:.2} m: {}",
                rounded(size),
                name(unit),
                if room.is_some() { "they would" } else { "it would" },
                in_unit(unit),
                how_to(
                    scene,
                    capitalised(name(unit)).as_str(),
                    &format!("--unit {symbol}"),
                    &format!("unit = \"{symbol}\"")
                ),
            )
        }
        None if absurd => format!(
            "the model measures {longest:.3e} m, which is no size for a building; choose its unit: {}",
            how_to(scene, "...", "--unit mm, cm, m, in or ft", "unit = \"...\"")
        ),
        None => format!(
            "{what} {} m high, and in no unit of mm, cm, m, in or ft that of a room; scale the model where it was made",
            rounded(size)
        ),
    };
    Some(Doubt { proposal, severity, message })
}

fn rounded(metres: f64) -> String {
    if metres >= 100.0 {
        format!("{metres:.0}")
    } else if metres >= 0.1 {
        format!("{metres:.2}")
    } else {
        format!("{metres:.2e}")
    }
}

fn name(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Millimetre => "millimetres",
        LengthUnit::Centimetre => "centimetres",
        LengthUnit::Metre => "metres",
        LengthUnit::Inch => "inches",
        LengthUnit::Foot => "feet",
    }
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// In which unit seats and tables are as high as seats and tables are.
enum Furniture {
    InMetres,
    InFeet,
    None,
}

fn furniture(space: &Space, up: DVec3) -> Furniture {
    const SAMPLES: usize = 600;
    let (mut in_metres, mut in_feet) = (0, 0);
    for top in space.floors(up, SAMPLES) {
        // With room to sit or to work above it, and beside it a drop to the floor.
        let drop = [0.6, 1.8].map(|aside| drop_beside(space, top.place, aside, up));
        let has_room = |least: f64| top.headroom.is_none_or(|room| room > least);
        in_metres += usize::from(has_room(0.9) && drop.iter().flatten().any(|d| (0.35..=1.0).contains(d)));
        in_feet += usize::from(has_room(2.9) && drop.iter().flatten().any(|d| (1.2..=3.2).contains(d)));
    }
    if in_metres.max(in_feet) < SAMPLES / 100 {
        Furniture::None
    } else if in_feet > 2 * in_metres {
        Furniture::InFeet
    } else {
        Furniture::InMetres
    }
}

/// How far the floor is below a place on a piece of furniture, seen from right beside it.
fn drop_beside(space: &Space, place: DVec3, aside: f64, up: DVec3) -> Option<f64> {
    let level = up.any_orthonormal_vector();
    let sides = [level, -level, up.cross(level), -up.cross(level)];
    let from = place + up * 1e-3;
    let drops = sides.iter().filter(|&&side| space.distance(from, side).is_none_or(|free| free > aside));
    drops.filter_map(|&side| space.distance(from + side * aside, -up)).max_by(f64::total_cmp)
}

/// Votes for each axis as the upright one, and what cast them for z.
struct UpEvidence {
    votes: [f64; 3],
    reasons: Vec<&'static str>,
}

impl UpEvidence {
    fn vote(&mut self, axis: usize, votes: f64, reason: &'static str) {
        self.votes[axis] += votes;
        if axis == 2 {
            self.reasons.push(reason);
        }
    }

    /// Why z seems to be up, where it does.
    fn proposal(self) -> Option<String> {
        let [x, y, z] = self.votes;
        (z >= ENOUGH && z >= y.max(x) + LEAD).then(|| match &self.reasons[..] {
            [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
            all => all.concat(),
        })
    }
}

fn up_evidence(scene: &Scene, extent: &Extent) -> UpEvidence {
    let mut evidence = UpEvidence { votes: [0.0; 3], reasons: Vec::new() };
    let faces: Vec<Face> = (0_u32..)
        .zip(&scene.surfaces)
        .filter(|(index, _)| extent.stray.binary_search(index).is_err())
        .map(|(index, surface)| {
            let outline = scene.polygon(surface);
            Face { index, area: polygon::area_vector(&outline), bounds: Aabb::around(outline) }
        })
        .collect();
    lamps(scene, &faces, &mut evidence);
    let words = [(&FLOORS[..], "floors are level in z"), (&CEILINGS[..], "ceilings are level in z")];
    for (words, reason) in words {
        named(scene, &faces, words, reason, &mut evidence);
    }
    level_areas(&faces, &extent.main, &mut evidence);
    standing(scene, &faces, extent, &mut evidence);
    evidence
}

struct Face {
    /// Into the scene's surfaces.
    index: u32,
    /// Normal times area.
    area: DVec3,
    bounds: Aabb,
}

/// Lamps shine down.
fn lamps(scene: &Scene, faces: &[Face], evidence: &mut UpEvidence) {
    let lit = faces.iter().filter(|face| scene.surfaces[face.index as usize].luminaire.is_some());
    let (mut sum, mut total) = (DVec3::ZERO, 0.0);
    for face in lit {
        sum += face.area;
        total += face.area.length();
    }
    let share = sum / f64::max(total, f64::MIN_POSITIVE);
    let axis = share.abs().max_position();
    if share[axis].abs() > 0.5 && share.length() - share[axis].abs() < 0.1 {
        let votes = if share[axis] < 0.0 { 2.0 } else { 1.0 };
        evidence.vote(axis, votes, "its lamps shine along z");
    }
}

/// What is called a floor or a ceiling is level.
fn named(scene: &Scene, faces: &[Face], words: &[&str], reason: &'static str, evidence: &mut UpEvidence) {
    let has_word = |name: &str| {
        let name = name.to_lowercase();
        words.iter().any(|word| name.contains(word))
    };
    let objects: Vec<bool> = scene.objects.iter().map(|name| has_word(name)).collect();
    let materials: Vec<bool> = scene.materials.iter().map(|material| has_word(&material.name)).collect();
    let (mut sum, mut named, mut all) = (DVec3::ZERO, 0.0, 0.0);
    for face in faces {
        let surface = &scene.surfaces[face.index as usize];
        all += face.area.length();
        if objects[surface.object as usize] || materials[surface.material as usize] {
            named += face.area.length();
            sum += face.area.abs();
        }
    }
    let axis = sum.max_position();
    if named > 0.01 * all && sum[axis] > 0.75 * named {
        evidence.vote(axis, 1.5, reason);
    }
}

/// Floors and ceilings are the largest parallel areas of most buildings, and lie in few levels.
fn level_areas(faces: &[Face], main: &Aabb, evidence: &mut UpEvidence) {
    let size = main.size();
    let mut areas = [0.0; 3];
    let mut concentrations = [0.0; 3];
    let mut is_storeyed = [false; 3];
    for axis in 0..3 {
        let mut levels = vec![0.0; LEVELS + 1];
        for face in faces.iter().filter(|face| face.area[axis].abs() > ALIGNED * face.area.length()) {
            let height = (face.bounds.centre()[axis] - main.min[axis]) / size[axis].max(f64::MIN_POSITIVE);
            levels[((height * LEVELS as f64) as usize).min(LEVELS)] += face.area.length();
        }
        areas[axis] = levels.iter().sum::<f64>();
        let squares: f64 = levels.iter().map(|area| area * area).sum();
        concentrations[axis] = squares / (areas[axis] * areas[axis]).max(f64::MIN_POSITIVE);
        // A floor and something above it; the front of a house has only itself.
        let across = size.element_product() / size[axis].max(f64::MIN_POSITIVE);
        is_storeyed[axis] = levels.iter().filter(|&&area| area > 0.35 * across).count() >= 2;
    }
    for axis in (0..3).filter(|&axis| is_storeyed[axis]) {
        let others = |of: &[f64; 3]| (0..3).filter(|&k| k != axis).map(|k| of[k]).fold(0.0, f64::max);
        let ratio = areas[axis] / others(&areas).max(f64::MIN_POSITIVE);
        if ratio > 1.15 {
            let votes = if ratio > 1.5 { 2.0 } else { 1.0 };
            evidence.vote(axis, votes, "most of its area is level in z");
        }
        if concentrations[axis] > 2.5 * others(&concentrations) {
            evidence.vote(axis, 1.5, "its area lies in few levels of z");
        }
    }
}

/// Furniture stands on one level, and at all places of it.
fn standing(scene: &Scene, faces: &[Face], extent: &Extent, evidence: &mut UpEvidence) {
    const FEWEST: usize = 8;
    let things: Vec<Aabb> = joined(scene, faces)
        .into_iter()
        .filter(|thing| thing.diagonal() < 0.4 * extent.main.diagonal())
        .collect();
    if things.len() < FEWEST {
        return;
    }
    let share = |axis: usize| {
        let step = 0.003 * extent.main.size().max_element();
        let mut feet: Vec<i64> =
            things.iter().map(|t| ((t.min[axis] - extent.main.min[axis]) / step).round() as i64).collect();
        feet.sort_unstable();
        let most = feet.chunk_by(|a, b| a == b).map(<[i64]>::len).max().unwrap_or(0);
        most as f64 / things.len() as f64
    };
    let shares = [share(0), share(1), share(2)];
    for axis in 0..3 {
        let others = (0..3).filter(|&k| k != axis).map(|k| shares[k]).fold(0.0, f64::max);
        if shares[axis] > 1.5 * others {
            evidence.vote(axis, 1.0, "most things stand on one level of z");
        }
    }
}

/// Boxes around all that hangs together by shared corners.
fn joined(scene: &Scene, faces: &[Face]) -> Vec<Aabb> {
    let mut parent: Vec<u32> = (0..scene.positions.len() as u32).collect();
    fn root(parent: &mut [u32], mut corner: u32) -> u32 {
        while parent[corner as usize] != corner {
            parent[corner as usize] = parent[parent[corner as usize] as usize];
            corner = parent[corner as usize];
        }
        corner
    }
    for face in faces {
        let corners = &scene.surfaces[face.index as usize].corners;
        for pair in corners.windows(2) {
            let (a, b) = (root(&mut parent, pair[0].position), root(&mut parent, pair[1].position));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    let mut boxes = vec![Aabb::EMPTY; scene.positions.len()];
    for face in faces {
        if let Some(corner) = scene.surfaces[face.index as usize].corners.first() {
            let place = root(&mut parent, corner.position) as usize;
            boxes[place] = boxes[place].union(face.bounds);
        }
    }
    boxes.retain(|bounds| !bounds.is_empty());
    boxes
}
