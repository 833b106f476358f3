//! The regions of a mesh in the compact form that all row methods read.

use super::culling::Culling;
use crate::mesh::{Backing, NO_PATCH, PatchMesh};
use glam::DVec3;

/// Surfaces that lie back to back are nearer to each other than this share of the scene's diagonal.
pub(super) const THICKNESS: f64 = 2e-7;

/// Everything that a receiving point can see, laid out for one pass per row.
#[derive(Clone, Debug, Default)]
pub struct Occluders {
    pub(super) regions: Vec<Occluder>,
    /// Corner positions of all outlines.
    pub(super) vertices: Vec<DVec3>,
    /// Outline edges as indices into the vertices of their region; inside lies left of each.
    pub(super) edges: Vec<[u32; 2]>,
    /// For each cell of each region its patches or its pieces.
    pub(super) cells: Vec<Cell>,
    /// Convex pieces of cells that hold more than one.
    pub(super) pieces: Vec<CellPiece>,
    /// Edges of those pieces: inside where `a u + b v + c >= 0`, plane coordinates in cells.
    pub(super) piece_edges: Vec<[f64; 3]>,
    /// Diagonal of the box around everything, metres.
    pub(super) size: f64,
    /// Patches in the mesh.
    pub(super) patches: usize,
    pub(super) culling: Culling,
}

/// One region.
#[derive(Clone, Copy, Debug)]
pub(super) struct Occluder {
    /// Origin of the grid.
    pub(super) origin: DVec3,
    /// Axes of the grid, divided by the edge length of a cell.
    pub(super) u_axis: DVec3,
    pub(super) v_axis: DVec3,
    pub(super) normal: DVec3,
    pub(super) cells: [u32; 2],
    pub(super) first_cell: u32,
    pub(super) vertices: [u32; 2],
    pub(super) edges: [u32; 2],
    /// Middle and half size of the box around it.
    pub(super) middle: DVec3,
    pub(super) half: DVec3,
    /// Whether a patch of it emits.
    pub(super) emits: bool,
    /// Sides that nothing lit can see.
    pub(super) dark: [bool; 2],
    /// How much of its back others lie on.
    pub(super) backing: Backing,
}

/// What lies in a grid cell.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cell {
    /// One piece, or pieces of one patch: the patches on its front and back.
    Whole([u32; 2]),
    /// A range of [`Occluders::pieces`].
    Split([u32; 2]),
}

/// A convex piece in a split cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPiece {
    pub(super) patches: [u32; 2],
    /// A range of [`Occluders::piece_edges`].
    pub(super) edges: [u32; 2],
}

impl Occluders {
    /// Reads the regions of a mesh.
    pub fn new(mesh: &PatchMesh) -> Self {
        let mut all = Self { size: mesh.size, patches: mesh.patches.len(), ..Self::default() };
        for region in &mesh.regions {
            let u_axis = region.frame.tangent / region.cell_size.x;
            let v_axis = region.frame.bitangent / region.cell_size.y;
            let origin = region.origin
                + region.frame.tangent * region.grid_min.x
                + region.frame.bitangent * region.grid_min.y;

            let first_vertex = all.vertices.len() as u32;
            let first_edge = all.edges.len() as u32;
            let mut index_of = std::collections::HashMap::new();
            for edge in &region.edges {
                let ends = edge.map(|p| {
                    *index_of.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
                        let at = region.origin + region.frame.tangent * p.x + region.frame.bitangent * p.y;
                        all.vertices.push(at);
                        all.vertices.len() as u32 - 1 - first_vertex
                    })
                });
                all.edges.push(ends);
            }

            let first_cell = all.cells.len() as u32;
            let count = region.cells[0] * region.cells[1];
            let mut emits = false;
            for cell in region.first_cell..region.first_cell + count {
                let list = mesh.cell_pieces[cell as usize].clone();
                let ids = &mesh.piece_lists[list.start as usize..list.end as usize];
                let patches = |p: u32| mesh.pieces[p as usize].patches;
                for side in ids.iter().flat_map(|&p| patches(p)).filter(|&p| p != NO_PATCH) {
                    emits |= mesh.patches[side as usize].luminaire.is_some();
                }
                let cell = match ids {
                    [] => Cell::Whole([NO_PATCH; 2]),
                    [first, rest @ ..] if rest.iter().all(|&p| patches(p) == patches(*first)) => {
                        Cell::Whole(patches(*first))
                    }
                    _ => {
                        let start = all.pieces.len() as u32;
                        for &p in ids {
                            let piece = &mesh.pieces[p as usize];
                            let edge_start = all.piece_edges.len() as u32;
                            let corners = mesh.corners_of(piece);
                            for i in 0..corners.len() {
                                let a = (corners[i].plane - region.grid_min) / region.cell_size;
                                let b = (corners[(i + 1) % corners.len()].plane - region.grid_min)
                                    / region.cell_size;
                                let inward = (b - a).perp();
                                all.piece_edges.push([inward.x, inward.y, -inward.dot(a)]);
                            }
                            all.pieces.push(CellPiece {
                                patches: piece.patches,
                                edges: [edge_start, all.piece_edges.len() as u32],
                            });
                        }
                        Cell::Split([start, all.pieces.len() as u32])
                    }
                };
                all.cells.push(cell);
            }
            all.regions.push(Occluder {
                origin,
                u_axis,
                v_axis,
                normal: region.frame.normal,
                cells: region.cells,
                first_cell,
                vertices: [first_vertex, all.vertices.len() as u32],
                edges: [first_edge, all.edges.len() as u32],
                middle: region.bounds.centre(),
                half: 0.5 * region.bounds.size(),
                emits,
                dark: region.dark,
                backing: region.backing,
            });
        }
        let boxes: Vec<(DVec3, DVec3)> = all.regions.iter().map(|r| (r.middle, r.half)).collect();
        all.culling = Culling::new(&boxes, &mesh.blockers);
        all
    }

    /// Patches in the mesh that this was read from: the length of a dense row.
    pub fn patch_count(&self) -> usize {
        self.patches
    }

    /// Distances below this count as contact, metres.
    pub(super) fn contact(&self) -> f64 {
        1e-9 * self.size
    }

    /// Surfaces that lie back to back are nearer to each other than this, metres.
    pub(super) fn thickness(&self) -> f64 {
        THICKNESS * self.size
    }
}
