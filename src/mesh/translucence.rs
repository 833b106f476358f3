//! Surfaces that pass light diffusely from one side to the other: paper, cloth, opal glass.

use super::backing::Sheets;
use super::types::{NO_PATCH, Patch, PatchMesh, Side};
use crate::geometry::polygon;
use crate::scene::{Scene, luminance_weighted};
use std::collections::BTreeMap;

/// What of the light that arrives on its far side leaves a patch.
#[derive(Clone, Debug, PartialEq)]
pub struct Passing {
    /// Diffuse transmittance per band, 0 to below 1 less the reflectance.
    pub share: [f64; 3],
    /// Patches on the far side, in rising order, each with the share of the area that it is behind, 0 to 1; together 1, or
    /// less where a part of the far side has no patch.
    pub behind: Vec<(u32, f64)>,
}

/// The patches of a mesh that light passes, and what is on their far sides.
///
/// A patch i that reflects `rho` and passes `tau` sends out rho H_i + tau H_f with H_f the mean irradiance of its far
/// side. The passed power is symmetric, since both sides share area and transmittance; form factors know nothing of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Translucence {
    list: Vec<Passing>,
    /// Index into `list` for each patch; empty where nothing passes light.
    of_patch: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Translucence {
    /// Of a whole mesh, whose regions are those of `sheets`.
    pub(super) fn find(mesh: &PatchMesh, scene: &Scene, sheets: &Sheets) -> Self {
        if scene.materials.iter().all(|material| !material.is_translucent()) {
            return Self::default();
        }
        let (mut list, mut of_patch) = (Vec::new(), vec![NONE; mesh.patches.len()]);
        for (patch, place) in mesh.patches.iter().zip(&mut of_patch) {
            let share = scene.materials[patch.material as usize].translucence;
            if share == [0.0; 3] {
                continue;
            }
            let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
            for &piece in &mesh.patch_pieces[patch.pieces.start as usize..patch.pieces.end as usize] {
                far_side(mesh, scene, sheets, patch, piece, |far, area| {
                    *areas.entry(far).or_default() += area
                });
            }
            if !areas.is_empty() {
                *place = list.len() as u32;
                let behind =
                    areas.into_iter().map(|(far, area)| (far, area / patch.outline_area())).collect();
                list.push(Passing { share, behind });
            }
        }
        if list.is_empty() { Self::default() } else { Self { list, of_patch } }
    }

    /// Whether no patch passes light.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many patches pass light.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// What a patch passes from its far side; `None` where that is nothing.
    pub fn at(&self, patch: usize) -> Option<&Passing> {
        self.list.get(*self.of_patch.get(patch)? as usize)
    }

    /// What a patch of reflectance `rho` sends out of what arrives on its two sides, per band; `arriving` gives the
    /// irradiance of each patch.
    pub fn leaving(&self, patch: usize, rho: [f64; 3], arriving: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let own = arriving(patch);
        let mut leaving = std::array::from_fn(|band| rho[band] * own[band]);
        if let Some(passing) = self.at(patch) {
            let far = passing.far(arriving);
            (0..3).for_each(|band| leaving[band] += passing.share[band] * far[band]);
        }
        leaving
    }

    /// The same where one band, by luminance, stands for all.
    #[must_use]
    pub fn grey(&self) -> Self {
        let mut grey = self.clone();
        grey.list.iter_mut().for_each(|passing| passing.share = [luminance_weighted(passing.share); 3]);
        grey
    }

    /// Whether what passes has another colour than what arrives.
    pub fn is_tinted(&self) -> bool {
        self.list.iter().any(|passing| passing.share.iter().any(|&share| share != passing.share[0]))
    }

    /// Area of one side of all that passes light, m².
    pub fn area(&self, mesh: &PatchMesh) -> f64 {
        let lit = mesh.patches.iter().enumerate().filter(|(patch, _)| self.at(*patch).is_some());
        0.5 * lit.map(|(_, patch)| patch.area).sum::<f64>()
    }
}

impl Passing {
    /// The mean of what arrives on the far side, per band, by what arrives at each patch.
    pub fn far(&self, arriving: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let mut far = [0.0; 3];
        for &(patch, share) in &self.behind {
            let there = arriving(patch as usize);
            (0..3).for_each(|band| far[band] += share * there[band]);
        }
        far
    }
}

/// Calls `found` with each patch on the far side of a piece of a patch, and the area that it covers there, m²: that on
/// the other side of the piece, or those of what lies back to back with it, as some programs write each sheet.
fn far_side(
    mesh: &PatchMesh,
    scene: &Scene,
    sheets: &Sheets,
    patch: &Patch,
    piece: u32,
    mut found: impl FnMut(u32, f64),
) {
    let own = &mesh.pieces[piece as usize];
    let other = own.patches[1 - patch.side as usize];
    if other != NO_PATCH {
        return found(other, own.area);
    }
    if patch.side == Side::Back || !own.backed {
        return;
    }
    // The middle, and points towards each corner.
    let corners: Vec<_> = mesh.corners_of(own).iter().map(|corner| corner.plane).collect();
    let middle = polygon::centroid_2d(&corners);
    let points: Vec<_> =
        std::iter::once(middle).chain(corners.iter().map(|corner| middle.lerp(*corner, 0.6))).collect();
    let region = &mesh.regions[own.region as usize];
    for &at in &points {
        let world = region.origin + region.frame.tangent * at.x + region.frame.bitangent * at.y;
        let far = sheets.backers[own.region as usize].iter().find_map(|&backer| {
            let is_translucent =
                scene.materials[mesh.regions[backer as usize].material as usize].is_translucent();
            mesh.patch_at(backer, Side::Front, world).filter(|_| is_translucent)
        });
        if let Some(far) = far {
            found(far, own.area / points.len() as f64);
        }
    }
}
