//! Form factors by rays with a cosine distribution: every ray carries the same weight.

use super::row::RowBuffer;
use crate::geometry::{Bvh, Frame, Ray};
use crate::mesh::{NO_PATCH, PatchMesh, cosine_direction};
use glam::DVec3;

/// What rays are cast against: the true polygons, as triangles.
#[derive(Clone, Debug)]
pub struct RayScene {
    bvh: Bvh,
    /// For each triangle the patches on its front and back, and its front normal.
    patches: Vec<[u32; 2]>,
    normals: Vec<DVec3>,
    /// For each triangle whether no light reaches its front, its back: rays pass through such a side.
    dark: Vec<[bool; 2]>,
    /// Rays start this far off the surface, metres.
    offset: f64,
}

impl RayScene {
    /// Triangulates the pieces of a mesh.
    pub fn new(mesh: &PatchMesh) -> Self {
        let (triangles, pieces) = mesh.triangles();
        Self {
            bvh: Bvh::build(&triangles),
            patches: pieces.iter().map(|&p| mesh.pieces[p as usize].patches).collect(),
            normals: pieces
                .iter()
                .map(|&p| mesh.regions[mesh.pieces[p as usize].region as usize].frame.normal)
                .collect(),
            dark: pieces
                .iter()
                .map(|&p| mesh.regions[mesh.pieces[p as usize].region as usize].dark)
                .collect(),
            offset: 1e-7 * mesh.size,
        }
    }

    /// The patch that a ray from `point` meets first; `None` where it escapes or meets a black side.
    ///
    /// A ray that meets a side which no light reaches has slipped through a seam and goes on.
    pub fn patch_seen(&self, point: DVec3, direction: DVec3) -> Option<u32> {
        let side_of = |triangle: usize| usize::from(self.normals[triangle].dot(direction) > 0.0);
        let ray = Ray { origin: point, direction };
        let lit = |t: u32| !self.dark[t as usize][side_of(t as usize)];
        let hit = self.bvh.nearest_where(&ray, self.offset, f64::INFINITY, lit)?;
        let triangle = hit.triangle as usize;
        let side = side_of(triangle);
        let patch = self.patches[triangle][side];
        (patch != NO_PATCH).then_some(patch)
    }

    /// Whether nothing stands between two points.
    pub fn visible(&self, from: DVec3, to: DVec3) -> bool {
        let direction = to - from;
        let length = direction.length();
        if length <= 2.0 * self.offset {
            return true;
        }
        let ray = Ray { origin: from, direction: direction / length };
        !self.bvh.occluded(&ray, self.offset, length - self.offset)
    }

    /// Adds the form factors from `point` to every patch to `row`; `turn` in 0..1 turns the pattern of `count` rays.
    pub fn gather(&self, count: u32, point: DVec3, frame: &Frame, turn: f64, row: &mut RowBuffer) {
        let each = 1.0 / f64::from(count.max(1));
        for k in 0..count {
            let direction = frame.world(cosine_direction(k, count, turn));
            if let Some(patch) = self.patch_seen(point, direction) {
                row.add(patch, each);
            }
        }
    }
}
