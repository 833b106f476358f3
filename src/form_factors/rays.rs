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
            offset: 1e-7 * mesh.size,
        }
    }

    /// The patch that a ray from `point` meets first; `None` where it escapes or meets a dark side.
    pub fn patch_seen(&self, point: DVec3, direction: DVec3) -> Option<u32> {
        let hit = self.bvh.nearest(&Ray { origin: point, direction }, self.offset, f64::INFINITY)?;
        let triangle = hit.triangle as usize;
        let side = usize::from(self.normals[triangle].dot(direction) > 0.0);
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
