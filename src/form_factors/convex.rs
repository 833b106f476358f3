//! Rows of a convex room: closed forms alone, every edge of the mesh computed once for the two patches
//! that share it.

use super::row::RowBuffer;
use crate::mesh::{PatchMesh, Side};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// The edges of a mesh with the patches on both sides of each.
#[derive(Clone, Debug)]
pub(super) struct ConvexRows {
    vertices: Vec<DVec3>,
    edges: Vec<Edge>,
    /// A point and the normal of each patch.
    planes: Vec<(DVec3, DVec3)>,
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    /// The patch that runs along the edge in its direction, and the one that runs against it.
    patches: [u32; 2],
}

const NONE: u32 = u32::MAX;

/// Working memory of one thread.
#[derive(Clone, Debug, Default)]
pub(super) struct ConvexScratch {
    /// Unit vectors to the vertices.
    directions: Vec<DVec3>,
    values: Vec<f64>,
}

impl ConvexRows {
    /// `None` where patches lie on backs: such a scene is not convex.
    pub(super) fn new(mesh: &PatchMesh) -> Option<Self> {
        if mesh.patches.iter().any(|p| p.side == Side::Back) {
            return None;
        }
        let mut index_of: BTreeMap<(u32, [u32; 2]), usize> = BTreeMap::new();
        let mut edges: Vec<Edge> = Vec::new();
        for (index, patch) in (0_u32..).zip(&mesh.patches) {
            for piece in mesh.pieces_of(patch) {
                let corners = mesh.corners_of(piece);
                for k in 0..corners.len() {
                    let (a, b) = (corners[k].vertex, corners[(k + 1) % corners.len()].vertex);
                    let key = (patch.region, [a.min(b), a.max(b)]);
                    let at = *index_of.entry(key).or_insert_with(|| {
                        edges.push(Edge { ends: key.1, patches: [NONE; 2] });
                        edges.len() - 1
                    });
                    let slot = &mut edges[at].patches[usize::from(a > b)];
                    // An edge that two patches run along the same way is counted for each.
                    if *slot == NONE {
                        *slot = index;
                    } else {
                        let mut patches = [NONE; 2];
                        patches[usize::from(a > b)] = index;
                        edges.push(Edge { ends: key.1, patches });
                    }
                }
            }
        }
        edges.retain(|e| e.patches[0] != e.patches[1]);
        let planes = mesh.patches.iter().map(|p| (p.centre, p.normal)).collect();
        Some(Self { vertices: mesh.vertices.clone(), edges, planes })
    }

    /// Adds the form factors from `point` to every patch that faces it by more than `contact`, by
    /// Lambert's sum over edges, F = 1/(2 pi) sum of angle times the normal's share of the edge's plane.
    /// `false`, with nothing added, where something lies below the receiver's horizon and would have to
    /// be clipped.
    pub(super) fn gather(
        &self,
        point: DVec3,
        normal: DVec3,
        contact: f64,
        scratch: &mut ConvexScratch,
        row: &mut RowBuffer,
    ) -> bool {
        scratch.directions.clear();
        for vertex in &self.vertices {
            let to = *vertex - point;
            if normal.dot(to) < -contact {
                return false;
            }
            scratch.directions.push(to.normalize_or_zero());
        }
        scratch.values.clear();
        scratch.values.resize(self.planes.len(), 0.0);
        for edge in &self.edges {
            let [a, b] = edge.ends.map(|v| scratch.directions[v as usize]);
            let cross = a.cross(b);
            let sine = cross.length();
            if sine == 0.0 {
                continue;
            }
            let part = normal.dot(cross) / sine * sine.atan2(a.dot(b)) / TAU;
            let [along, against] = edge.patches;
            if along != NONE {
                scratch.values[along as usize] -= part;
            }
            if against != NONE {
                scratch.values[against as usize] += part;
            }
        }
        for (index, (&value, &(centre, patch_normal))) in scratch.values.iter().zip(&self.planes).enumerate()
        {
            if value > 0.0 && patch_normal.dot(point - centre) > contact {
                row.add(index as u32, value);
            }
        }
        true
    }
}
