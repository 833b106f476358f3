//! Where light comes from when the sides are looked for that it reaches.

use super::reach::sample_points;
use super::regions::Outline;
use crate::geometry::polygon;
use crate::scene::{PhotometricSource, Scene};
use glam::DVec3;

/// Points on all lamps together, about, and on one of them at least and at most: of a lamp that is half built in,
/// some must lie outside.
const LAMP_POINTS: usize = 512;
const POINTS_PER_LAMP: [usize; 2] = [3, 24];
/// Paths and rays start so far before a surface, as a share of the scene's size.
pub(super) const OFFSET: f64 = 1e-7;

/// Where light is known to come from.
pub(super) struct Sources {
    /// Points on lamps with the direction that they shine to.
    pub(super) lamps: Vec<(DVec3, DVec3)>,
    pub(super) lamp_tangents: Vec<DVec3>,
    /// Whether there is a sky, whatever shines in it at this hour: what escapes finds light.
    pub(super) has_sky: bool,
    /// Points on lit sides with the direction that they face, where the search had to find them.
    pub(super) lit_points: Vec<(DVec3, DVec3)>,
    /// Paths and rays start so far before a surface, metres.
    pub(super) offset: f64,
}

impl Sources {
    /// The lamps of a scene of some `size`, metres; no other side is known to be lit.
    pub(super) fn new(scene: &Scene, outlines: &[Outline], size: f64) -> Self {
        let (mut lamps, mut lamp_tangents) = (Vec::new(), Vec::new());
        let shining = || outlines.iter().filter(|outline| outline.luminaire.is_some());
        let [least, most] = POINTS_PER_LAMP;
        let per_lamp = (LAMP_POINTS / shining().count().max(1)).clamp(least, most);
        for outline in shining() {
            let points: Vec<DVec3> =
                sample_points(outline, per_lamp).into_iter().map(|point| outline.world(point)).collect();
            for sign in [1.0, -1.0].into_iter().take(if outline.emits_back { 2 } else { 1 }) {
                lamp_tangents.extend(points.iter().map(|_| outline.frame.tangent));
                lamps.extend(points.iter().map(|&point| (point, outline.frame.normal * sign)));
            }
        }
        for source in scene.photometric_sources() {
            for (point, towards) in openings(&source, outlines) {
                lamp_tangents.push(source.place.frame.tangent);
                lamps.push((point, towards));
            }
        }
        // Of every hour alike, so that one mesh serves them all.
        let has_sky = scene.outdoors.is_some();
        Self { lamps, lamp_tangents, has_sky, lit_points: Vec::new(), offset: size * OFFSET }
    }

    /// Whether nothing shines.
    pub(super) fn is_dark(&self) -> bool {
        self.lamps.is_empty() && !self.has_sky
    }
}

/// Points of the opening of a luminaire that shines by its photometry, with the directions that they face: none
/// where its surfaces face all that it lights.
fn openings(source: &PhotometricSource, outlines: &[Outline]) -> Vec<(DVec3, DVec3)> {
    /// Less of the flux on a side lights nothing there.
    const LEAST: f64 = 1e-3;
    let own = || outlines.iter().filter(|outline| outline.luminaire == Some(source.luminaire));
    let down = -source.place.frame.normal;
    let share = source.downward_share;
    let faces = source.opening();
    if own().next().is_some() {
        // Behind a flat face that is none of them; inside of a closed body nothing is lit.
        let is_flat = own().all(|outline| outline.frame.normal.dot(down) > 0.99 && !outline.emits_back);
        let is_behind = is_flat && 1.0 - share > LEAST;
        return if is_behind { vec![(source.place.centre, -down)] } else { Vec::new() };
    }
    if faces.len() > 1 {
        let middle = |face: &Vec<DVec3>| face.iter().sum::<DVec3>() / face.len() as f64;
        return faces
            .iter()
            .map(|face| (middle(face), polygon::area_vector(face).normalize_or(down)))
            .collect();
    }
    let mut points = vec![source.place.centre];
    points.extend(faces.iter().flatten().map(|corner| 0.5 * (*corner + source.place.centre)));
    let sides = [(down, share), (-down, 1.0 - share)].into_iter().filter(|side| side.1 > LEAST);
    sides.flat_map(|(towards, _)| points.iter().map(move |&point| (point, towards))).collect()
}
