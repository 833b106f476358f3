//! Polygons of a file made fit for light: each planar, simple and of some area, and there once.
//! Whatever is dropped or changed is counted and named by object.

use super::doctor::WELD;
use super::doctor::topology::weld;
use super::extent::{Extent, Footprint};
use super::finding::{Finding, FindingKind, Severity};
use super::model::{Face, Polygons};
use super::outlines::{Indices, in_plane, is_simple, plane, widest_plane, without_repetitions};
use super::sides::{self, Ring};
use super::tally::Tally;
use super::types::{Corner, Surface};
use crate::geometry::{Frame, polygon};
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// How far corners may lie apart along the normal, relative to the polygon's size.
const FLATNESS: f64 = 1e-3;
/// Normals within this cosine (0.1 degrees) of the polygon's own add nothing.
const SAME_NORMAL: f64 = 1.0 - 1.5e-6;

/// Faces admitted between two looks at whether to go on.
const WATCHED_FACES: usize = 256;

/// Surfaces, the normals that they point to, and what was repaired.
#[derive(Debug, Default)]
pub(super) struct Repaired {
    pub(super) surfaces: Vec<Surface>,
    pub(super) normals: Vec<DVec3>,
    pub(super) findings: Vec<Finding>,
}

/// Makes surfaces of faces. `positions` are in metres; `emits` tells which materials emit.
pub(super) fn repair(polygons: &Polygons, positions: &[DVec3], emits: &[bool]) -> Repaired {
    Watch::nobody(|watch| repair_watched(polygons, positions, emits, watch)).unwrap_or_default()
}

/// As [`repair`], for somebody who watches and may end it.
pub(super) fn repair_watched(
    polygons: &Polygons,
    positions: &[DVec3],
    emits: &[bool],
    watch: &mut Watch<'_>,
) -> Result<Repaired, Cancelled> {
    let mut shop = Workshop::new(positions, polygons, emits);
    for (index, face) in polygons.faces.iter().enumerate() {
        if index % WATCHED_FACES == 0 {
            watch.done(index as f64 / polygons.faces.len() as f64)?;
        }
        shop.admit(face);
    }
    shop.drop_duplicates(emits);
    Ok(shop.finish())
}

/// A position by its bits.
type Place = [u64; 3];

struct Workshop<'a> {
    positions: &'a [DVec3],
    polygons: &'a Polygons,
    surfaces: Vec<Surface>,
    normals: Vec<DVec3>,
    /// Number in `normals` of a normal of the file, and whether it was turned round.
    normal_numbers: HashMap<(u32, bool), u32>,
    /// Corners nearer than this are one, metres.
    tolerance: f64,
    /// Triangles that outlines were split into, by their rings.
    splits: HashMap<Vec<Place>, Vec<[Place; 3]>>,
    repeated: Tally,
    flat: Tally,
    bent: Tally,
    crossed: Tally,
    mangled: Tally,
    bad_normals: Tally,
    turned_normals: Tally,
    twice: Tally,
    both_sides: Tally,
    contested: Tally,
}

impl<'a> Workshop<'a> {
    fn new(positions: &'a [DVec3], polygons: &'a Polygons, emits: &[bool]) -> Self {
        let footprint = |face: &Face| {
            let outline: Vec<DVec3> = face.corners.iter().map(|c| positions[c.0 as usize]).collect();
            Footprint::of(&outline, emits[face.material as usize])
        };
        let footprints: Vec<Footprint> = polygons.faces.iter().map(footprint).collect();
        Self {
            positions,
            polygons,
            surfaces: Vec::with_capacity(polygons.faces.len()),
            normals: Vec::new(),
            normal_numbers: HashMap::new(),
            tolerance: WELD * Extent::of(&footprints).scale,
            splits: HashMap::new(),
            repeated: Tally::default(),
            flat: Tally::default(),
            bent: Tally::default(),
            crossed: Tally::default(),
            mangled: Tally::default(),
            bad_normals: Tally::default(),
            turned_normals: Tally::default(),
            twice: Tally::default(),
            both_sides: Tally::default(),
            contested: Tally::default(),
        }
    }

    fn at(&self, corner: &Indices) -> DVec3 {
        self.positions[corner.0 as usize]
    }

    fn admit(&mut self, face: &Face) {
        let (corners, positions) = (without_repetitions(&face.corners), self.positions);
        if corners.len() < face.corners.len() {
            self.repeated.add(face.object, face.line, face.corners.iter().map(|c| positions[c.0 as usize]));
        }
        let outline: Vec<DVec3> = corners.iter().map(|c| self.at(c)).collect();
        let Some((normal, size)) = plane(&outline) else {
            // A figure of eight has no area in sum and may have some in its halves.
            self.admit_crossed(face, &corners, &outline);
            return;
        };
        let frame = Frame::around(normal);
        let flat: Vec<DVec2> = outline.iter().map(|&p| in_plane(&frame, p - outline[0])).collect();
        let heights = outline.iter().map(|&p| (p - outline[0]).dot(normal));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
        let is_bent = high - low > FLATNESS * size;
        let is_crossed = !is_bent && !is_simple(&corners, &flat, self.tolerance);
        if !is_bent && !is_crossed {
            self.push(face, &corners, normal);
            return;
        }
        let filled = self.push_triangles(face, &corners, &outline, &flat, normal);
        let area = polygon::area_vector(&outline).length();
        let tally = match is_bent {
            true => &mut self.bent,
            false if (filled - area).abs() > 1e-3 * area => &mut self.mangled,
            false => &mut self.crossed,
        };
        tally.add(face.object, face.line, outline.iter().copied());
    }

    /// Splits an outline whose signed areas cancel, along the plane that its corners span best.
    fn admit_crossed(&mut self, face: &Face, corners: &[Indices], outline: &[DVec3]) {
        let spanned = (corners.len() > 3).then(|| widest_plane(outline)).flatten();
        let Some(normal) = spanned else {
            self.flat.add(face.object, face.line, outline.iter().copied());
            return;
        };
        let frame = Frame::around(normal);
        let flat: Vec<DVec2> = outline.iter().map(|&p| in_plane(&frame, p - outline[0])).collect();
        let filled = self.push_triangles(face, corners, outline, &flat, normal);
        let tally = if filled > 0.0 { &mut self.mangled } else { &mut self.flat };
        tally.add(face.object, face.line, outline.iter().copied());
    }

    /// Pushes the triangles of an outline and returns their area.
    fn push_triangles(
        &mut self,
        face: &Face,
        corners: &[Indices],
        outline: &[DVec3],
        flat: &[DVec2],
        normal: DVec3,
    ) -> f64 {
        let mut filled = 0.0;
        for [a, mut b, mut c] in self.split(outline, flat) {
            let area = polygon::area_vector(&[outline[a], outline[b], outline[c]]);
            if area.dot(normal) < 0.0 {
                (b, c) = (c, b);
            }
            if let Some((own_normal, _)) = plane(&[outline[a], outline[b], outline[c]]) {
                self.push(face, &[corners[a], corners[b], corners[c]], own_normal);
                filled += area.length();
            }
        }
        filled
    }

    /// The triangles of an outline. One that is written once more for its other side is split as at first, so
    /// that the two sides lie in one place.
    fn split(&mut self, outline: &[DVec3], flat: &[DVec2]) -> Vec<[usize; 3]> {
        let places: Vec<Place> = outline.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        let numbers: HashMap<Place, usize> = places.iter().copied().zip(0..).collect();
        let mut key = places.clone();
        sides::ring(&mut key);
        if let Some(known) = self.splits.get(&key) {
            return known.iter().map(|t| t.map(|place| numbers[&place])).collect();
        }
        let triangles: Vec<[usize; 3]> =
            polygon::triangulate(flat, &[]).into_iter().map(|t| t.map(|i| i as usize)).collect();
        if numbers.len() == places.len() {
            self.splits.insert(key, triangles.iter().map(|t| t.map(|i| places[i])).collect());
        }
        triangles
    }

    fn push(&mut self, face: &Face, corners: &[Indices], normal: DVec3) {
        let smooth = self.smooth_normals(face, corners, normal);
        let corners = corners.iter().zip(smooth).map(|(c, n)| Corner { position: c.0, normal: n, uv: c.2 });
        self.surfaces.push(Surface {
            corners: corners.collect(),
            object: face.object,
            material: face.material,
            luminaire: None,
            emission_weight: [0.0; 3],
            emits_back: false,
            line: face.line,
        });
    }

    /// Indices of the unit normals of a smooth surface, on its front; `None` where it is flat.
    fn smooth_normals(&mut self, face: &Face, corners: &[Indices], normal: DVec3) -> Vec<Option<u32>> {
        let given: Option<Vec<(u32, DVec3)>> = corners
            .iter()
            .map(|c| c.1.map(|i| (i, self.polygons.normals[i as usize].normalize_or_zero())))
            .collect();
        let Some(given) = given else { return vec![None; corners.len()] };
        if given.iter().any(|(_, n)| *n == DVec3::ZERO) {
            self.bad_normals.add(face.object, face.line, std::iter::empty());
            return vec![None; corners.len()];
        }
        let against = given.iter().filter(|(_, n)| n.dot(normal) < 0.0).count();
        let turn = against == given.len();
        if turn {
            self.turned_normals.add(face.object, face.line, std::iter::empty());
        } else if against > 0 {
            self.bad_normals.add(face.object, face.line, std::iter::empty());
            return vec![None; corners.len()];
        }
        if given.iter().all(|(_, n)| n.dot(normal).abs() > SAME_NORMAL) {
            return vec![None; corners.len()];
        }
        let normals = &mut self.normals;
        given
            .into_iter()
            .map(|(i, n)| {
                Some(*self.normal_numbers.entry((i, turn)).or_insert_with(|| {
                    normals.push(if turn { -n } else { n });
                    normals.len() as u32 - 1
                }))
            })
            .collect()
    }

    /// Of surfaces over the same corners that face the same way one is kept.
    fn drop_duplicates(&mut self, emits: &[bool]) {
        let welded = weld(self.positions, self.tolerance);
        let mut first_on: HashMap<Ring, usize> = HashMap::with_capacity(self.surfaces.len());
        let mut keep = vec![true; self.surfaces.len()];
        let positions = self.positions;
        let coincide = |surfaces: &[Surface], first: usize, second: usize| {
            sides::coincide(positions, &welded, &surfaces[first], &surfaces[second])
        };
        let tolerance = self.tolerance;
        let is_pair = |surfaces: &[Surface], first: usize, second: usize| {
            sides::back_to_back(positions, &welded, tolerance, &surfaces[first], &surfaces[second])
        };
        for index in 0..self.surfaces.len() {
            let ring = Ring::of(&self.surfaces[index], &welded);
            let other = first_on.get(&ring.turned()).copied();
            let first = *first_on.entry(ring).or_insert(index);
            if let Some(other) = other.filter(|&o| first == index && is_pair(&self.surfaces, o, index)) {
                self.share_corners(other, index, &welded);
                let surface = &self.surfaces[index];
                let outline = outline_of(self.positions, surface);
                self.both_sides.add(surface.object, surface.line, outline);
            }
            if first == index || !coincide(&self.surfaces, first, index) {
                continue;
            }
            let surface = &self.surfaces[index];
            let kept = &self.surfaces[first];
            let is_same = kept.material == surface.material;
            // Two materials on one side cannot both be seen: the lamp wins, else the first.
            let lamp_is_later = emits[surface.material as usize] && !emits[kept.material as usize];
            let dropped = if lamp_is_later { first } else { index };
            keep[dropped] = false;
            if lamp_is_later {
                first_on.insert(Ring::of(surface, &welded), index);
            }
            let surface = &self.surfaces[dropped];
            let tally = if is_same { &mut self.twice } else { &mut self.contested };
            tally.add(surface.object, surface.line, outline_of(self.positions, surface));
        }
        let mut keep = keep.into_iter();
        self.surfaces.retain(|_| keep.next().unwrap_or(true));
    }

    /// Gives a surface the positions of another over the same corners, once these are `welded`.
    fn share_corners(&mut self, first: usize, second: usize, welded: &[u32]) {
        let shared: HashMap<u32, u32> =
            self.surfaces[first].corners.iter().map(|c| (welded[c.position as usize], c.position)).collect();
        for corner in &mut self.surfaces[second].corners {
            if let Some(&position) = shared.get(&welded[corner.position as usize]) {
                corner.position = position;
            }
        }
    }

    fn finish(mut self) -> Repaired {
        use FindingKind::{Degenerate, Duplicate, Material, NonPlanar, Normals, SelfCrossing};
        use Severity::{Note, Warning};
        let (mut findings, objects) = (Vec::new(), &self.polygons.objects);
        let normals_note = "light does not ask for them, only the shading of the picture";
        for (tally, kind, what, consequence) in [
            (
                &mut self.flat,
                (Degenerate, Warning),
                "faces without an area were dropped",
                "they have none to carry light",
            ),
            (
                &mut self.twice,
                (Duplicate, Warning),
                "faces that are there twice were dropped",
                "one of each is lit",
            ),
            (
                &mut self.both_sides,
                (Material, Note),
                "faces are written once more for their other side",
                "each side has the material, image and lamp of its own face",
            ),
            (
                &mut self.contested,
                (Duplicate, Warning),
                "faces that lie exactly on a face of another material were dropped",
                "the lamp is lit and seen, else the first of them",
            ),
            (
                &mut self.bent,
                (NonPlanar, Note),
                "faces that are not planar were split into triangles",
                "each triangle is lit by itself",
            ),
            (
                &mut self.crossed,
                (SelfCrossing, Note),
                "faces whose outline touches itself were split into triangles",
                "they keep their area",
            ),
            (
                &mut self.mangled,
                (SelfCrossing, Warning),
                "faces whose outline crosses itself were filled as well as it can be done",
                "their area may differ from what was meant",
            ),
            (
                &mut self.repeated,
                (Degenerate, Note),
                "faces with repeated corners were cleaned of them",
                "their shape is the same",
            ),
            (
                &mut self.bad_normals,
                (Normals, Note),
                "faces with zero or contradicting vertex normals are shaded flat",
                normals_note,
            ),
            (
                &mut self.turned_normals,
                (Normals, Note),
                "faces whose vertex normals oppose their corner order had the normals turned; \
                 the corner order decides which side is the front",
                "",
            ),
        ] {
            tally.report(objects, kind, what, consequence, &mut findings);
        }
        Repaired { surfaces: self.surfaces, normals: self.normals, findings }
    }
}

fn outline_of<'a>(positions: &'a [DVec3], surface: &'a Surface) -> impl Iterator<Item = DVec3> + use<'a> {
    surface.corners.iter().map(|c| positions[c.position as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces(positions: &[[f64; 3]], faces: &[(&[u32], u32)]) -> Repaired {
        let positions: Vec<DVec3> = positions.iter().copied().map(DVec3::from).collect();
        let polygons = Polygons {
            positions: positions.clone(),
            faces: faces
                .iter()
                .map(|(corners, material)| Face {
                    corners: corners.iter().map(|&c| (c, None, None)).collect(),
                    object: 0,
                    material: *material,
                    line: Some(1),
                })
                .collect(),
            objects: vec!["thing".to_owned()],
            ..Polygons::default()
        };
        repair(&polygons, &positions, &[false, true])
    }

    fn area(positions: &[[f64; 3]], repaired: &Repaired) -> f64 {
        let outline = |s: &Surface| -> Vec<DVec3> {
            s.corners.iter().map(|c| DVec3::from(positions[c.position as usize])).collect()
        };
        repaired.surfaces.iter().map(|s| polygon::area_vector(&outline(s)).length()).sum()
    }

    fn only_finding<'a>(repaired: &'a Repaired, words: &str) -> &'a Finding {
        assert_eq!(repaired.findings.len(), 1, "{:?}", repaired.findings);
        let finding = &repaired.findings[0];
        assert!(
            finding.message.contains(words) && finding.message.contains("'thing'"),
            "{}",
            finding.message
        );
        finding
    }

    const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn the_measured_left_wall_is_split_and_a_planar_one_is_not() {
        // Cornell box measurements, millimetres: 3.2 mm out of plane.
        let wall = [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]];
        let repaired = faces(&wall, &[(&[0, 1, 2, 3], 0)]);
        assert_eq!(repaired.surfaces.len(), 2);
        only_finding(&repaired, "not planar");
        let mut almost = SQUARE;
        almost[2][2] = 5e-4;
        let repaired = faces(&almost, &[(&[0, 1, 2, 3], 0)]);
        assert_eq!((repaired.surfaces.len(), repaired.findings.len()), (1, 0));
    }

    #[test]
    fn lines_and_points_are_dropped_and_counted() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1e-12, 0.0]];
        let repaired = faces(&corners, &[(&[0, 1, 2], 0), (&[0, 2, 3], 0), (&[0, 1, 0, 1], 0)]);
        assert!(repaired.surfaces.is_empty());
        assert_eq!(repaired.findings[0].count, 3, "{:?}", repaired.findings);
    }

    #[test]
    fn repeated_corners_and_spikes_vanish_across_the_seam_too() {
        for corners in [
            &[0, 0, 1, 2, 3][..],
            &[0, 1, 2, 3, 0],
            &[0, 1, 2, 1, 2, 3],
            &[3, 0, 1, 2, 1, 2],
            &[2, 1, 2, 3, 0, 1],
        ] {
            let repaired = faces(&SQUARE, &[(corners, 0)]);
            assert_eq!(repaired.surfaces.len(), 1, "{corners:?}");
            assert_eq!(repaired.surfaces[0].corners.len(), 4, "{corners:?}");
            assert_eq!(area(&SQUARE, &repaired), 1.0);
            only_finding(&repaired, "repeated corners");
        }
    }

    #[test]
    fn of_duplicates_on_one_side_one_stays() {
        let same = faces(&SQUARE, &[(&[0, 1, 2, 3], 0), (&[1, 2, 3, 0], 0)]);
        assert_eq!((same.surfaces.len(), only_finding(&same, "twice").count), (1, 1));
        // Corners of its own, nearer than a millionth of the diagonal.
        let mut apart = SQUARE.to_vec();
        apart.extend(SQUARE.map(|[x, y, z]| [x + 1e-6, y, z - 5e-7]));
        let near = faces(&apart, &[(&[0, 1, 2, 3], 0), (&[5, 6, 7, 4], 0)]);
        assert_eq!((near.surfaces.len(), only_finding(&near, "twice").count), (1, 1));
        apart[6][2] = 1e-5;
        assert_eq!(faces(&apart, &[(&[0, 1, 2, 3], 0), (&[5, 6, 7, 4], 0)]).surfaces.len(), 2);
    }

    #[test]
    fn a_face_for_each_side_stays_whatever_its_material() {
        for material in [0, 1] {
            let sides = faces(&SQUARE, &[(&[3, 2, 1, 0], material), (&[0, 1, 2, 3], 1)]);
            assert_eq!((sides.surfaces.len(), only_finding(&sides, "other side").count), (2, 1));
        }
        let thrice = faces(&SQUARE, &[(&[3, 2, 1, 0], 1), (&[0, 1, 2, 3], 1), (&[1, 2, 3, 0], 1)]);
        assert_eq!((thrice.surfaces.len(), thrice.findings.len()), (2, 2), "{:?}", thrice.findings);
    }

    #[test]
    fn a_lamp_wins_over_the_ceiling_that_it_lies_in() {
        let repaired = faces(&SQUARE, &[(&[0, 1, 2, 3], 0), (&[0, 1, 2, 3], 1)]);
        assert_eq!(repaired.surfaces.len(), 1);
        assert_eq!(repaired.surfaces[0].material, 1);
        only_finding(&repaired, "another material");
    }

    #[test]
    fn a_planar_concave_polygon_stays_whole_and_a_bent_one_is_split_right() {
        let mut arrow = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [2.0, 2.0, 0.0], [0.0, 4.0, 0.0]];
        let whole = faces(&arrow, &[(&[0, 1, 2, 3, 4], 0)]);
        assert_eq!((whole.surfaces.len(), whole.findings.len()), (1, 0));
        assert_eq!(area(&arrow, &whole), 12.0);
        arrow[3][2] = 0.01;
        let split = faces(&arrow, &[(&[0, 1, 2, 3, 4], 0)]);
        assert_eq!(split.surfaces.len(), 3);
        // A fan from the first corner would cover 20 with overlaps instead of 12.
        assert!((area(&arrow, &split) - 12.0).abs() < 1e-3, "{}", area(&arrow, &split));
    }

    #[test]
    fn a_figure_of_eight_is_split() {
        let bow = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
        let repaired = faces(&bow, &[(&[0, 1, 2, 3], 0)]);
        assert!(!repaired.surfaces.is_empty());
        assert!(repaired.surfaces.iter().all(|s| s.corners.len() == 3));
        only_finding(&repaired, "crosses itself");
    }

    #[test]
    fn a_hole_joined_to_the_outline_by_a_seam_keeps_its_area() {
        let frame = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [4.0, 4.0, 0.0],
            [0.0, 4.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 3.0, 0.0],
            [3.0, 3.0, 0.0],
            [3.0, 1.0, 0.0],
        ];
        let repaired = faces(&frame, &[(&[0, 1, 2, 3, 0, 4, 5, 6, 7, 4], 0)]);
        only_finding(&repaired, "touches itself");
        assert!((area(&frame, &repaired) - 12.0).abs() < 1e-12);
    }

    #[test]
    fn normals_follow_the_front_and_flat_ones_are_not_kept() {
        let positions: Vec<DVec3> = SQUARE.iter().copied().map(DVec3::from).collect();
        let smooth = [DVec3::new(0.1, 0.0, -2.0), DVec3::new(-0.1, 0.0, -2.0), DVec3::NEG_Z * 3.0];
        let face = |normals: [u32; 3]| Face {
            corners: (0..3).map(|k| (k as u32, Some(normals[k]), None)).collect(),
            object: 0,
            material: 0,
            line: Some(1),
        };
        let polygons = Polygons {
            positions: positions.clone(),
            normals: smooth.to_vec(),
            faces: vec![face([0, 1, 2]), face([2, 2, 2])],
            objects: vec!["thing".to_owned()],
            ..Polygons::default()
        };
        let repaired = repair(&polygons, &positions, &[false]);
        let first = repaired.surfaces[0].corners[0].normal.expect("smooth");
        assert!(repaired.normals[first as usize].abs_diff_eq(DVec3::new(-0.1, 0.0, 2.0).normalize(), 1e-12));
        assert!(repaired.findings.iter().any(|f| f.message.contains("oppose") && f.count == 2));
        assert_eq!(repaired.surfaces.len(), 1, "the second lies on the first");
    }
}
