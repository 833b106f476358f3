//! Which axis of a model points up, as far as it can be told.
//!
//! What speaks for an axis are lamps, which shine down; names of floors and ceilings; level area, in
//! buildings more than upright area in any one direction; and furniture, which stands on one level. None
//! of these is enough alone: the front of a house looks like a floor that lies.

use super::extent::Extent;
use super::types::Scene;
use crate::geometry::{Aabb, polygon};
use glam::DVec3;

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

/// Votes for each axis as the upright one, and what cast them for z.
pub(super) struct UpEvidence {
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
    pub(super) fn proposal(self) -> Option<String> {
        let [x, y, z] = self.votes;
        (z >= ENOUGH && z >= y.max(x) + LEAD).then(|| match &self.reasons[..] {
            [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
            all => all.concat(),
        })
    }
}

/// What speaks for each axis.
pub(super) fn up_evidence(scene: &Scene, extent: &Extent) -> UpEvidence {
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
    let words = [
        (&FLOORS[..], "what is named a floor is perpendicular to z"),
        (&CEILINGS[..], "what is named a ceiling is perpendicular to z"),
    ];
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
            evidence.vote(axis, votes, "most of its area is perpendicular to z");
        }
        if concentrations[axis] > 2.5 * others(&concentrations) {
            evidence.vote(axis, 1.5, "its large areas lie in few levels of z");
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
            evidence.vote(axis, 1.0, "more objects stand on one level of z than of x or y");
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
