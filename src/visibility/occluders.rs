//! The regions of a mesh in the compact form that all row methods read.

use super::culling::Culling;
use crate::geometry::Frame;
use crate::mesh::{Backing, NO_PATCH, Panes, PatchMesh, Side};
use crate::watch::Cancelled;
use glam::DVec3;
use std::f64::consts::TAU;

/// Who looks at the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewer {
    /// A point of a surface that light reaches. It never sees a side that no light reaches, so such
    /// sides are passed over.
    LitSurface,
    /// A point anywhere. Sides that no light reaches hide from it what lies behind them.
    Anywhere,
}

/// Surfaces that lie back to back are nearer to each other than this share of the scene's diagonal.
pub(crate) const THICKNESS: f64 = 2e-7;

/// Edges of pieces that are shorter than this many cells bound nothing.
const SHORTEST_EDGE: f64 = 1e-9;

/// Everything that a receiving point can see, laid out for one pass per row.
#[derive(Clone, Debug, Default)]
pub struct Occluders {
    pub(crate) regions: Vec<Occluder>,
    /// Corner positions of all outlines.
    pub(crate) vertices: Vec<DVec3>,
    /// Outline edges as indices into the vertices of their region; inside lies left of each.
    pub(crate) edges: Vec<[u32; 2]>,
    /// For each cell of each region its patches or its pieces.
    pub(crate) cells: Vec<Cell>,
    /// Convex pieces of cells that hold more than one.
    pub(crate) pieces: Vec<CellPiece>,
    /// Edges of those pieces: inside where `a u + b v + c >= 0`, plane coordinates in cells.
    pub(crate) piece_edges: Vec<[f64; 3]>,
    /// What tolerances are shares of, metres.
    pub(crate) size: f64,
    /// Patches in the mesh.
    pub(crate) patches: usize,
    pub(crate) culling: Culling,
}

/// One region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Occluder {
    /// Origin of the grid.
    pub(crate) origin: DVec3,
    /// Axes of the grid, divided by the edge length of a cell.
    pub(crate) u_axis: DVec3,
    pub(crate) v_axis: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) cells: [u32; 2],
    pub(crate) first_cell: u32,
    pub(crate) vertices: [u32; 2],
    pub(crate) edges: [u32; 2],
    /// Middle and half size of the box around it.
    pub(crate) middle: DVec3,
    pub(crate) half: DVec3,
    /// For front and back whether a patch on that side emits.
    pub(crate) emits: [bool; 2],
    /// Sides that nothing lit can see.
    pub(crate) dark: [bool; 2],
    /// How much of its back others lie on.
    pub(crate) backing: Backing,
    /// Of a pane its index in [`crate::mesh::Panes::list`]: it hides nothing, and dims what lies behind it.
    pub(crate) pane: Option<u32>,
}

impl Occluder {
    /// Whether others lie on a part of this side, and are seen there instead.
    pub(crate) fn is_set_back(&self, side: Side) -> bool {
        side == Side::Back && self.backing == Backing::Partial
    }
}

/// What lies in a grid cell.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Cell {
    /// One piece, or pieces of one patch: the patches on its front and back.
    Whole([u32; 2]),
    /// A range of [`Occluders::pieces`].
    Split([u32; 2]),
}

/// A convex piece in a split cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellPiece {
    pub(crate) patches: [u32; 2],
    /// A range of [`Occluders::piece_edges`].
    pub(crate) edges: [u32; 2],
}

impl Occluders {
    /// Reads the regions of a mesh.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn new(mesh: &PatchMesh, cancelled: &dyn Fn() -> bool) -> Result<Self, Cancelled> {
        let mut all = Self { size: mesh.size, patches: mesh.patches.len(), ..Self::default() };
        for region in &mesh.regions {
            if cancelled() {
                return Err(Cancelled);
            }
            let u_axis = region.frame.tangent / region.cell_size.x;
            let v_axis = region.frame.bitangent / region.cell_size.y;
            let origin = region.origin
                + region.frame.tangent * region.grid_min.x
                + region.frame.bitangent * region.grid_min.y;

            let first_vertex = all.vertices.len() as u32;
            let first_edge = all.edges.len() as u32;
            let mut index_of = std::collections::HashMap::new();
            // Without an edge nothing meets it: what it hides, its panes hide in part.
            for edge in region.edges.iter().filter(|_| !region.has_holes) {
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
            let mut emits = [false; 2];
            for cell in region.first_cell..region.first_cell + count {
                let list = mesh.cell_pieces[cell as usize].clone();
                let ids = &mesh.piece_lists[list.start as usize..list.end as usize];
                let patches = |p: u32| mesh.pieces[p as usize].patches;
                for side in [Side::Front, Side::Back] {
                    let on_side = ids.iter().map(|&p| patches(p)[side as usize]);
                    emits[side as usize] |= on_side
                        .filter(|&p| p != NO_PATCH)
                        .any(|p| mesh.patches[p as usize].luminaire.is_some());
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
                                // Between two corners that are one but for rounding it points anywhere.
                                if inward.length_squared() < SHORTEST_EDGE * SHORTEST_EDGE {
                                    continue;
                                }
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
                pane: None,
            });
        }
        all.add_panes(&mesh.panes);
        let boxes: Vec<(DVec3, DVec3)> = all.regions.iter().map(|r| (r.middle, r.half)).collect();
        all.culling = Culling::new(&boxes, &mesh.blockers);
        Ok(all)
    }

    /// Panes come after the regions of the mesh; they have no cells.
    fn add_panes(&mut self, panes: &Panes) {
        for (index, pane) in (0_u32..).zip(&panes.list) {
            let (vertex, edge, count) =
                (self.vertices.len() as u32, self.edges.len() as u32, pane.corners.len() as u32);
            self.vertices.extend_from_slice(&pane.corners);
            self.edges.extend((0..count).map(|k| [k, (k + 1) % count]));
            self.regions.push(Occluder {
                origin: pane.corners[0],
                u_axis: DVec3::ZERO,
                v_axis: DVec3::ZERO,
                normal: pane.normal,
                cells: [0; 2],
                first_cell: 0,
                vertices: [vertex, vertex + count],
                edges: [edge, edge + count],
                middle: pane.bounds.centre(),
                half: 0.5 * pane.bounds.size(),
                emits: [false; 2],
                // From its other side it dims nothing.
                dark: [false; 2],
                backing: Backing::None,
                pane: Some(index),
            });
        }
    }

    /// Forgets the panes.
    pub(crate) fn leave_out_panes(&mut self) {
        self.regions.iter_mut().filter(|region| region.pane.is_some()).for_each(|region| {
            // Without an edge nothing meets it.
            (region.edges[1], region.pane) = (region.edges[0], None);
        });
    }

    /// Patches in the mesh that this was read from: the length of a dense row.
    pub fn patch_count(&self) -> usize {
        self.patches
    }

    /// Form factor from the point to a whole region without occlusion, what lies below the horizon cut
    /// off; `None` where the horizon cuts it into several parts.
    pub(crate) fn unoccluded(&self, region: &Occluder, point: DVec3, frame: &Frame) -> Option<f64> {
        let vertices = &self.vertices[region.vertices[0] as usize..region.vertices[1] as usize];
        let mut sum = 0.0;
        let (mut enter, mut leave, mut rims) = (0.0, 0.0, 0);
        for &[a, b] in &self.edges[region.edges[0] as usize..region.edges[1] as usize] {
            let p = frame.local(vertices[a as usize] - point);
            let q = frame.local(vertices[b as usize] - point);
            if p.z <= 0.0 && q.z <= 0.0 {
                continue;
            }
            let (mut from, mut to) = (p, q);
            if p.z <= 0.0 {
                from = p + (q - p) * (p.z / (p.z - q.z));
                enter = from.y.atan2(from.x);
                rims += 1;
            } else if q.z <= 0.0 {
                to = p + (q - p) * (p.z / (p.z - q.z));
                leave = to.y.atan2(to.x);
                rims += 1;
            }
            let cross = from.cross(to);
            let length = cross.length();
            if length > 0.0 {
                sum += cross.z / length * length.atan2(from.dot(to));
            }
        }
        match rims {
            0 => {}
            // The polygon is closed along the horizon.
            2 => {
                let turn: f64 = enter - leave;
                sum += turn - TAU * (turn / TAU).round();
            }
            _ => return None,
        }
        let factor = sum.abs() / TAU;
        (factor > 0.0).then_some(factor)
    }

    /// Whether others lie between a region and a point whose plane is so far away along the region's normal:
    /// on its back, where they are seen instead, or where the point is on one of them itself.
    pub(crate) fn is_covered(&self, region: &Occluder, to_plane: f64, normal: DVec3) -> bool {
        let is_on_it = || to_plane.abs() <= self.thickness() && region.normal.dot(normal) < -0.99;
        match region.backing {
            Backing::None => false,
            Backing::Partial => is_on_it(),
            Backing::Whole => to_plane > 0.0 || is_on_it(),
        }
    }

    /// Distances below this count as contact, metres.
    pub(crate) fn contact(&self) -> f64 {
        1e-9 * self.size
    }

    /// Surfaces that lie back to back are nearer to each other than this, metres.
    pub(crate) fn thickness(&self) -> f64 {
        THICKNESS * self.size
    }
}
