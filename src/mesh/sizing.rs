//! How large patches are: from a number of patches to the edge of one.

use super::build::{MeshError, PATCH_LIMIT, PatchTarget};
use super::grading::{Grading, Lamps};
use super::pieces::Grid;
use super::refinement::Refinement;
use super::regions::Outline;
use crate::scene::Scene;
use rayon::prelude::*;

/// Patches where nobody asks for a number or a size.
const USUAL_COUNT: usize = 3000;
/// Of a number of patches so much may go where a refinement asks for smaller ones.
const MOST_ASKED: f64 = 0.7;
/// Where sides that need a patch each are more than this, and more than all that are asked for, they share clusters.
const MANY: usize = 6000;
/// Shares of a number of patches that large faces and clusters then get. Mouldings and contacts add to the former.
const LARGE_FACES: f64 = 0.7;
const CLUSTERS: f64 = 0.5;
/// A face of several cells is small where it is less than this part of a patch.
const SLIGHT: f64 = 0.5;
/// A refinement is not loosened further than to edges so many times as long.
const MOST_SLACK: f64 = 64.0;
/// A patch is at most so many times as long as one of equal squares that share the whole area. Where mouldings
/// or slats would use up the whole count, walls still get patches that shadows show on.
const LONGEST: f64 = 1.5;

/// What asks for patches that are smaller than elsewhere.
pub(super) struct Finer<'a> {
    lamps: Lamps,
    refinement: Option<&'a Refinement>,
    /// How many times as long as the refinement asks for edges may be.
    slack: f64,
    /// Small faces share clusters, of which nothing is asked.
    clustered: bool,
}

/// How finely surfaces are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sizing {
    /// The edge of a patch, metres.
    pub(super) edge: f64,
    /// About how many clusters [small](is_small) faces share; `None` where each has patches of its own.
    pub(super) clusters: Option<f64>,
}

/// Whether a face has no need of a patch of its own of this edge, where faces share any.
pub(super) fn is_small(outline: &Outline, edge: f64) -> bool {
    let extent = outline.max - outline.min;
    outline.luminaire.is_none()
        && outline.coarsest == 0.0
        && (extent.max_element() <= edge || outline.area <= SLIGHT * edge * edge)
}

/// How many patches of one size the active sides give, where nothing asks for smaller ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Demand {
    /// Those of surfaces that are no larger than a patch, one per side whatever the size, and of surfaces with a
    /// measure of their own.
    whole: f64,
    /// Those of larger surfaces.
    cut: f64,
}

impl Demand {
    fn of(outlines: &[Outline], sides: &[[bool; 2]], size: f64) -> Self {
        outlines.iter().zip(sides).fold(Self::default(), |sum, (outline, sides)| {
            let extent = outline.max - outline.min;
            let size = size.max(outline.coarsest);
            let cells = (extent.x / size).ceil().max(1.0) * (extent.y / size).ceil().max(1.0);
            let patches = (cells * filled(outline)).max(1.0) * active(*sides);
            // What is cut by its own measure has no say in the choice.
            if cells > 1.0 && outline.coarsest == 0.0 {
                Self { cut: sum.cut + patches, ..sum }
            } else {
                Self { whole: sum.whole + patches, ..sum }
            }
        })
    }
}

impl<'a> Finer<'a> {
    pub(super) fn new(lamps: Lamps, refinement: Option<&'a Refinement>) -> Self {
        Self { lamps, refinement, slack: 1.0, clustered: false }
    }

    /// What is asked of one outline in a mesh of patches of edge `size`.
    pub(super) fn on(&self, index: usize, outline: &Outline, sides: [bool; 2], size: f64) -> Grading<'_> {
        let wishes = self.refinement.map(|r| r.wishes(index, outline, self.slack * size)).unwrap_or_default();
        self.lamps.grading(outline, sides, size, wishes)
    }

    /// How many patches more than [`Demand`] says the lit sides have by that.
    fn estimate(&self, outlines: &[Outline], sides: &[[bool; 2]], size: f64) -> f64 {
        let more = |(index, outline): (usize, &Outline)| {
            if self.clustered && is_small(outline, size) {
                return 0.0;
            }
            let grading = self.on(index, outline, sides[index], size);
            if grading.is_empty() {
                return 0.0;
            }
            let grid = Grid::new(outline, size);
            let cells = 0..grid.cells[0] * grid.cells[1];
            let halves = |cell| grading.leaves(outline, grid.corner(cell), grid.cell).len() - 1;
            let leaves: usize = cells.map(halves).sum();
            leaves as f64 * filled(outline) * active(sides[index])
        };
        outlines.par_iter().enumerate().map(more).collect::<Vec<f64>>().iter().sum()
    }
}

/// How much of the rectangle around it an outline fills.
fn filled(outline: &Outline) -> f64 {
    let extent = outline.max - outline.min;
    (outline.area / (extent.x * extent.y).max(f64::MIN_POSITIVE)).min(1.0)
}

/// How many sides are active.
fn active(sides: [bool; 2]) -> f64 {
    f64::from(u8::from(sides[0]) + u8::from(sides[1]))
}

/// The number of patches that a target asks for, if it is a number.
pub(super) fn count_asked(scene: &Scene, target: PatchTarget) -> Option<usize> {
    match target {
        PatchTarget::Count(count) => Some(count.max(1)),
        PatchTarget::Auto if scene.patch_size.is_none() => Some(USUAL_COUNT),
        PatchTarget::Auto | PatchTarget::Size(_) | PatchTarget::AsGiven => None,
    }
}

/// The edge of a patch that `target` means for these outlines, whose `sides` (front, back) are active or not.
pub(super) fn patch_size(
    scene: &Scene,
    target: PatchTarget,
    outlines: &[Outline],
    sides: &[[bool; 2]],
    finer: &mut Finer<'_>,
) -> Result<Sizing, MeshError> {
    let asked = count_asked(scene, target);
    let mut size = match (asked, target) {
        (Some(count), _) => for_count(count as f64, outlines, sides, finer),
        (None, PatchTarget::Size(size)) if size > 0.0 && size.is_finite() => size,
        (None, PatchTarget::Size(size)) => return Err(MeshError::Size(size)),
        (None, PatchTarget::AsGiven) => f64::INFINITY,
        (None, PatchTarget::Auto | PatchTarget::Count(_)) => scene.patch_size.unwrap_or(f64::INFINITY),
    };
    let mut clusters = None;
    if target != PatchTarget::AsGiven && small_sides(outlines, sides, size) > asked.unwrap_or(0).max(MANY) {
        let count = asked.map_or(f64::INFINITY, |count| count as f64);
        finer.clustered = true;
        if count.is_finite() {
            size = for_count(LARGE_FACES * count, outlines, sides, finer);
        }
        clusters = Some(CLUSTERS * count);
    }
    let demand = Demand::of(outlines, sides, size.max(f64::MIN_POSITIVE));
    let mut patches = demand.cut + if clusters.is_some() { 0.0 } else { demand.whole };
    if patches <= PATCH_LIMIT as f64 && target != PatchTarget::AsGiven {
        patches += finer.estimate(outlines, sides, size);
    }
    if patches > PATCH_LIMIT as f64 {
        let (patches, whole) = (patches as usize, demand.whole as usize);
        return Err(MeshError::TooMany { size, patches, whole, limit: PATCH_LIMIT });
    }
    Ok(Sizing { edge: size, clusters })
}

/// Active sides of small faces.
fn small_sides(outlines: &[Outline], sides: &[[bool; 2]], edge: f64) -> usize {
    let small = outlines.iter().zip(sides).filter(|(outline, _)| is_small(outline, edge));
    small.map(|(_, sides)| sides.iter().filter(|active| **active).count()).sum()
}

/// The edge that gives about `count` patches on the surfaces that are larger than a patch.
///
/// Were the others counted too, a model of more facets than `count` would leave no patch for its walls.
fn for_count(count: f64, outlines: &[Outline], sides: &[[bool; 2]], finer: &mut Finer<'_>) -> f64 {
    let longest = outlines.iter().map(|o| (o.max - o.min).max_element()).fold(0.0, f64::max);
    let near = outlines.iter().zip(sides).filter(|(outline, _)| outline.coarsest == 0.0);
    let area: f64 = near.map(|(o, sides)| o.area * active(*sides)).sum();
    let plain = |count: f64| {
        let (mut low, mut high) = (1e-6_f64, 10.0);
        for _ in 0..60 {
            let middle = (low * high).sqrt();
            if Demand::of(outlines, sides, middle * longest).cut > count {
                low = middle;
            } else {
                high = middle;
            }
        }
        (high * longest).min(if area > 0.0 { LONGEST * (area / count).sqrt() } else { f64::INFINITY })
    };
    loop {
        // What is asked for in places comes out of the same number; the rest makes do with larger patches.
        let mut rest = count;
        for _ in 0..6 {
            let more = finer.estimate(outlines, sides, plain(rest));
            rest = (0.5 * (rest + count - more)).max(0.25 * count);
        }
        let size = plain(rest);
        let more = finer.estimate(outlines, sides, size);
        if finer.refinement.is_none() || more <= MOST_ASKED * count || finer.slack > MOST_SLACK {
            return size;
        }
        // Where surfaces are many and small, the rest cannot make do.
        finer.slack *= (more / (MOST_ASKED * count)).sqrt().clamp(1.1, 4.0);
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::{MeshSettings, PatchMesh, PatchTarget, build};
    use crate::scene::from_text;
    use std::fmt::Write as _;

    /// Facets of a chair: a ball of bands and segments, and its caps.
    const FACETS: usize = 252;

    /// A closed room of 6 m x 3 m x 5 m with a ceiling lamp and so many chairs.
    fn room(chairs: usize, target: PatchTarget) -> PatchMesh {
        const SEGMENTS: usize = 25;
        const BANDS: usize = 10;
        let mut obj = "mtllib m.mtl\nusemtl paint\no room\nv 0 0 0\nv 6 0 0\nv 6 0 5\nv 0 0 5\nv 0 3 0\nv 6 3 0\n\
                       v 6 3 5\nv 0 3 5\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
                       usemtl glow\no lamp\nv 2.5 2.99 2\nv 3.5 2.99 2\nv 3.5 2.99 3\nv 2.5 2.99 3\nf 9 10 11 12\n\
                       usemtl paint\n"
            .to_owned();
        let mut first = 13;
        for chair in 0..chairs {
            let (x, z) = (0.5 + 0.9 * (chair % 6) as f64, 0.5 + (chair / 6) as f64);
            let _ = writeln!(obj, "o chair{chair}");
            for band in 0..=BANDS {
                for segment in 0..SEGMENTS {
                    let (tilt, turn) = (
                        (0.05 + 0.9 * band as f64 / BANDS as f64) * std::f64::consts::PI,
                        segment as f64 / SEGMENTS as f64 * std::f64::consts::TAU,
                    );
                    let (ring, height) = (0.3 * tilt.sin(), 0.4 - 0.3 * tilt.cos());
                    let _ = writeln!(obj, "v {} {height} {}", x + ring * turn.cos(), z + ring * turn.sin());
                }
            }
            for band in 0..BANDS {
                for segment in 0..SEGMENTS {
                    let at = |b: usize, s: usize| first + b * SEGMENTS + s % SEGMENTS;
                    let [a, b] = [at(band, segment), at(band, segment + 1)];
                    let [c, d] = [at(band + 1, segment + 1), at(band + 1, segment)];
                    let _ = writeln!(obj, "f {a} {d} {c} {b}");
                }
            }
            for (band, rising) in [(0, true), (BANDS, false)] {
                let ring = (0..SEGMENTS).map(|s| if rising { s } else { SEGMENTS - 1 - s });
                let corners: String = ring.map(|s| format!(" {}", first + band * SEGMENTS + s)).collect();
                let _ = writeln!(obj, "f{corners}");
            }
            first += (BANDS + 1) * SEGMENTS;
        }
        let mtl = "newmtl paint\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 0 0 0\nKe 9 9 9\n";
        let scene = from_text("room", &obj, mtl, None).expect("a scene");
        build(&scene, &MeshSettings { target, ..MeshSettings::default() }).expect("a mesh")
    }

    /// Patches on walls, floor and ceiling, and the longest edge of one, metres.
    fn walls(mesh: &PatchMesh) -> (usize, f64) {
        let of_room = |region: u32| mesh.regions[region as usize].object == 0;
        let edge = mesh.regions.iter().filter(|r| r.object == 0).map(|r| r.cell_size.max_element());
        (mesh.patches.iter().filter(|p| of_room(p.region)).count(), edge.fold(0.0, f64::max))
    }

    #[test]
    fn walls_are_cut_as_finely_whatever_stands_in_the_room() {
        let empty = room(0, PatchTarget::Count(800));
        let full = room(20, PatchTarget::Count(800));
        assert_eq!(full.statistics.whole_sides, 20 * FACETS, "the outsides of all facets, one patch each");
        let ((few, short), (many, long)) = (walls(&empty), walls(&full));
        assert!(long < 1.05 * short && short < 0.6, "{long} m beside {short} m");
        assert!(many >= few, "{many} patches on the walls, {few} in the empty room");
        let patches = full.statistics.patches;
        assert!((5700..6100).contains(&patches), "800 besides one per facet: {patches}");
    }

    #[test]
    fn a_number_that_cannot_be_kept_is_explained() {
        let empty = room(0, PatchTarget::Count(800));
        assert_eq!(empty.statistics.excess(), None);
        let full = room(8, PatchTarget::Count(800));
        let told = full.statistics.excess().expect("more than twice as many");
        let expected =
            "800 patches were asked for; 2,016 sides of small faces need one each, so the mesh has 2,";
        assert!(told.starts_with(expected), "{told}");
        // A size is no number, and neither is what the polygons of the file come to.
        assert_eq!(room(8, PatchTarget::Size(0.3)).statistics.excess(), None);
    }

    #[test]
    fn narrow_faces_leave_walls_their_patches() {
        // Slats of 6 m x 2 cm: cutting each of 1,000 in two would be more than is asked for.
        let mut obj = "o room\nv 0 0 0\nv 6 0 0\nv 6 0 5\nv 0 0 5\nf 4 3 2 1\no slats\n".to_owned();
        for k in 0..1000 {
            let (low, first) = (0.1 + 0.002 * f64::from(k), 5 + 4 * k);
            let _ = writeln!(obj, "v 0 {low} 1\nv 6 {low} 1\nv 6 {low} 1.02\nv 0 {low} 1.02");
            let _ = writeln!(obj, "f {} {} {} {first}", first + 3, first + 2, first + 1);
        }
        let scene = from_text("slats", &obj, "", None).expect("a scene");
        let settings = MeshSettings { target: PatchTarget::Count(800), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).expect("a mesh");
        let fair = (mesh.statistics.area / 800.0).sqrt();
        assert!(walls(&mesh).1 <= 1.5 * fair, "{} m, {fair} m would be fair", walls(&mesh).1);
    }
}
