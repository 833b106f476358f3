//! Where patches are to be smaller than elsewhere because a picture was found to be wrong there.

use super::regions::Outline;
use super::types::{Patch, PatchMesh};
use glam::DVec2;

/// By how much smaller than elsewhere the patches of a scene are to be, place by place.
///
/// It is told in shares of the patch size, and so holds for coarser and finer meshes of the same scene. A
/// surface that has changed since counts as one that nothing is asked of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refinement {
    /// By region.
    regions: Vec<Asked>,
}

/// What is asked of a region.
#[derive(Clone, Debug, Default, PartialEq)]
struct Asked {
    /// The region's area and grid origin: those of another are no concern of this.
    area: f64,
    min: DVec2,
    places: Vec<Place>,
}

/// A rectangle in plane coordinates, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    min: DVec2,
    max: DVec2,
    /// Longest edge: in a [`Refinement`] over the patch size, in [`Wishes`] in metres.
    edge: f64,
}

/// What is asked of the cells of one region, longest edges in metres.
#[derive(Default)]
pub(super) struct Wishes {
    places: Vec<Place>,
}

/// Patches whose squares fall short of being cut in two stay as they are: this many parts.
const WORTH: f64 = 1.5;

impl Refinement {
    /// Asks for patches of `mesh` to be cut, each into so many `parts`; what was asked `before` of the mesh
    /// still holds.
    pub fn of(mesh: &PatchMesh, parts: &[f64], before: Option<&Self>) -> Self {
        let size = typical_edge(mesh);
        let known = |index: usize, area: f64, min: DVec2| {
            let old = before.and_then(|b| b.regions.get(index))?;
            (old.area == area && old.min == min).then(|| old.places.clone())
        };
        let regions = mesh.regions.iter().enumerate();
        let mut asked: Vec<Asked> = regions
            .map(|(k, r)| Asked {
                area: r.area,
                min: r.grid_min,
                places: known(k, r.area, r.grid_min).unwrap_or_default(),
            })
            .collect();
        for (patch, &parts) in mesh.patches.iter().zip(parts) {
            if parts >= WORTH && size.is_finite() && !patch.is_cluster {
                let (min, max) = extent(mesh, patch);
                // Of square parts: long patches are cut across first.
                let edge = (patch.area / parts).sqrt() / size;
                asked[patch.region as usize].places.push(Place { min, max, edge });
            }
        }
        Self { regions: asked }
    }

    /// What is asked of an outline, in a mesh of patches of edge `size`.
    pub(super) fn wishes(&self, index: usize, outline: &Outline, size: f64) -> Wishes {
        let same = |asked: &&Asked| asked.area == outline.area && asked.min == outline.min;
        let places = self.regions.get(index).filter(same).map(|asked| asked.places.as_slice());
        let of_size = |place: &Place| Place { edge: place.edge * size, ..*place };
        Wishes { places: places.unwrap_or_default().iter().map(of_size).collect() }
    }
}

impl Wishes {
    pub(super) fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Those that concern a rectangle.
    pub(super) fn within(&self, min: DVec2, max: DVec2) -> Self {
        let meets = |place: &&Place| place.overlap(min, max).min_element() > 0.0;
        Self { places: self.places.iter().filter(meets).copied().collect() }
    }

    /// The longest edge that a part of a rectangle is asked to have, metres. A place counts where it covers
    /// much of the rectangle, or the rectangle much of it.
    pub(super) fn edge(&self, min: DVec2, max: DVec2) -> f64 {
        let counts = |place: &&Place| {
            let common = place.overlap(min, max);
            let area = |extent: DVec2| extent.x * extent.y;
            common.min_element() > 0.0
                && area(common) > 0.3 * area(max - min).min(area(place.max - place.min))
        };
        self.places.iter().filter(counts).map(|place| place.edge).fold(f64::INFINITY, f64::min)
    }
}

impl Place {
    /// Edges of what it has in common with a rectangle; below zero where that is nothing.
    fn overlap(&self, min: DVec2, max: DVec2) -> DVec2 {
        self.max.min(max) - self.min.max(min)
    }
}

/// The patch size of a mesh, or what comes to the same where that is larger than most surfaces, metres.
fn typical_edge(mesh: &PatchMesh) -> f64 {
    /// A patch size over the root of the mean area, at most. Chosen, not measured: it only has to keep the
    /// patch size of a mesh of small surfaces, which may be the scene's tenfold, from counting.
    const OVER_MEAN: f64 = 1.5;
    let statistics = &mesh.statistics;
    statistics.patch_size.min(OVER_MEAN * (statistics.area / statistics.patches.max(1) as f64).sqrt())
}

/// The rectangle around a patch, plane coordinates.
fn extent(mesh: &PatchMesh, patch: &Patch) -> (DVec2, DVec2) {
    let corners = mesh.pieces_of(patch).flat_map(|piece| mesh.corners_of(piece));
    corners
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), c| (low.min(c.plane), high.max(c.plane)))
}
