//! Faces that are written once per side: over the same corners, in opposite order.
//!
//! Each of them rules the side from which its corners run counter-clockwise, with a material, an image and a
//! lamp of its own.

use super::doctor::WELD;
use super::doctor::topology::weld;
use super::extent::{Extent, Footprint};
use super::types::{Corner, Surface};
use crate::geometry::{Aabb, polygon};
use glam::DVec3;
use std::collections::HashMap;

/// An outline whatever corner it starts from and whichever way it runs, and which way that is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Ring {
    corners: Vec<u32>,
    reversed: bool,
}

impl Ring {
    /// Of a surface with its corners `welded`.
    pub(super) fn of(surface: &Surface, welded: &[u32]) -> Self {
        let raw = || surface.corners.iter().map(|c| c.position);
        let mut corners: Vec<u32> = raw().map(|p| welded[p as usize]).collect();
        let mut sorted = corners.clone();
        sorted.sort_unstable();
        if sorted.windows(2).any(|w| w[0] == w[1]) {
            // Too small to be told from others by corners that are one.
            corners = raw().collect();
        }
        let reversed = ring(&mut corners);
        Self { corners, reversed }
    }

    /// The same outline from its other side.
    pub(super) fn turned(&self) -> Self {
        Self { corners: self.corners.clone(), reversed: !self.reversed }
    }
}

/// Makes an outline start from its lowest corner and run one of its two ways; returns whether it ran the other.
pub(super) fn ring<T: Copy + Ord>(corners: &mut [T]) -> bool {
    let lowest = (0..corners.len()).min_by_key(|&k| corners[k]).unwrap_or(0);
    corners.rotate_left(lowest);
    let reversed = corners.len() > 2 && corners[1] > corners[corners.len() - 1];
    if reversed {
        corners[1..].reverse();
    }
    reversed
}

/// Of two surfaces with equal rings, or with one that is the other turned, whether they lie in one place as
/// measured by their own size: on a large site the tolerance may be more than a small face.
pub(super) fn coincide(positions: &[DVec3], welded: &[u32], first: &Surface, second: &Surface) -> bool {
    const SHARE: f64 = 1e-3;
    let at = |c: &Corner| positions[c.position as usize];
    let size = Aabb::around(first.corners.iter().map(at)).diagonal();
    let places: HashMap<u32, DVec3> =
        first.corners.iter().map(|c| (welded[c.position as usize], at(c))).collect();
    let is_near = |c: &Corner| {
        places.get(&welded[c.position as usize]).is_some_and(|p| p.distance(at(c)) <= SHARE * size)
    };
    second.corners.iter().all(is_near)
}

/// Whether two surfaces, of which one ring is the other turned, are the two sides of one sheet: they
/// [coincide], and do not face each other across a gap, however narrow. `tolerance` is the length within
/// which corners are welded: half of it is left to the rounding of coordinates in files.
pub(super) fn back_to_back(
    positions: &[DVec3],
    welded: &[u32],
    tolerance: f64,
    first: &Surface,
    second: &Surface,
) -> bool {
    const ROUNDING: f64 = 0.5;
    let outline: Vec<DVec3> = first.corners.iter().map(|c| positions[c.position as usize]).collect();
    let normal = polygon::area_vector(&outline).normalize_or_zero();
    let places: HashMap<u32, DVec3> =
        first.corners.iter().map(|c| welded[c.position as usize]).zip(outline).collect();
    let ahead = |c: &Corner| {
        let at = positions[c.position as usize];
        places.get(&welded[c.position as usize]).map_or(0.0, |place| (at - *place).dot(normal))
    };
    let gap = second.corners.iter().map(ahead).sum::<f64>() / second.corners.len().max(1) as f64;
    gap <= ROUNDING * tolerance && coincide(positions, welded, first, second)
}

/// For each surface the one that is written for its other side, if there is one.
pub(super) fn partners(positions: &[DVec3], surfaces: &[Surface]) -> Vec<Option<u32>> {
    let outline =
        |s: &Surface| -> Vec<DVec3> { s.corners.iter().map(|c| positions[c.position as usize]).collect() };
    let footprints: Vec<Footprint> =
        surfaces.iter().map(|s| Footprint::of(&outline(s), s.luminaire.is_some())).collect();
    let tolerance = WELD * Extent::of(&footprints).scale;
    let welded = weld(positions, tolerance);
    let rings: Vec<Ring> = surfaces.iter().map(|s| Ring::of(s, &welded)).collect();
    let mut numbers: HashMap<&Ring, u32> = HashMap::with_capacity(rings.len());
    for (number, ring) in (0..).zip(&rings) {
        numbers.entry(ring).or_insert(number);
    }
    let partner = |(number, ring): (u32, &Ring)| {
        let is_first = numbers[ring] == number;
        let other = numbers.get(&ring.turned()).copied().filter(|_| is_first)?;
        let [own, others] = [number, other].map(|n| &surfaces[n as usize]);
        back_to_back(positions, &welded, tolerance, own, others).then_some(other)
    };
    (0..).zip(&rings).map(partner).collect()
}

#[cfg(test)]
mod tests {
    use super::super::from_text;
    use super::*;

    fn partners_of(faces: &str) -> Vec<Option<u32>> {
        let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0.0000005\nv 1 0 0.0000005\nv 1 1 0\nv 0 1 0\n\
            v 0 0 0.1\n";
        let scene = from_text("t", &format!("{corners}{faces}"), "", None).unwrap();
        partners(&scene.positions, &scene.surfaces)
    }

    #[test]
    fn floor_and_ceiling_are_no_partners_however_far_the_model_reaches() {
        let far = "v 5000000 0 0\nv 5000000 1 0\nv 5000000 0 1\nf 1 2 3\n";
        let room = "v 0 0 0\nv 20 0 0\nv 20 0 20\nv 0 0 20\nv 0 3 0\nv 20 3 0\nv 20 3 20\nv 0 3 20\n\
            f 7 6 5 4\nf 8 9 10 11\n";
        let scene = from_text("t", &format!("{far}{room}"), "", None).unwrap();
        assert_eq!(partners(&scene.positions, &scene.surfaces), [None; 3]);
        assert_eq!(scene.bounds().size().y, 3.0);
    }

    #[test]
    fn plates_that_face_each_other_across_a_hair_are_two() {
        let plates = |gap: f64| {
            let low = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
            let high = format!("v 0 0 {gap}\nv 1 0 {gap}\nv 1 1 {gap}\nv 0 1 {gap}\n");
            let scene = from_text("t", &format!("{low}{high}f 1 2 3 4\nf 8 7 6 5\n"), "", None).unwrap();
            (partners(&scene.positions, &scene.surfaces), scene.bounds().size().z)
        };
        assert_eq!(plates(1e-6), (vec![None; 2], 1e-6));
        assert_eq!(plates(-1e-6), (vec![Some(1), Some(0)], 0.0), "back to back");
        assert_eq!(plates(1e-8), (vec![Some(1), Some(0)], 0.0), "rounding");
    }

    #[test]
    fn reversed_outlines_are_partners_from_whatever_corner_they_start() {
        for reversed in ["4 3 2 1", "3 2 1 4", "2 1 4 3", "1 4 3 2", "8 7 6 5", "6 5 8 7"] {
            let found = partners_of(&format!("f 1 2 3 4\nf 1 2 9\nf {reversed}\n"));
            assert_eq!(found, [Some(2), None, Some(0)], "{reversed}");
        }
        assert_eq!(partners_of("f 1 2 3 4\nf 1 2 3\n"), [None, None]);
        assert_eq!(partners_of("f 1 2 3\nf 3 4 1\n"), [None, None]);
    }
}
