//! Regions cut into pieces along their grid and along the lines where other surfaces stand on them.

use super::contacts::{self, Contact};
use super::grading::Grading;
use super::regions::{Outline, Welder};
use super::types::{PatchMesh, Piece, PieceCorner, Region};
use crate::geometry::polygon;
use glam::DVec2;
use std::collections::HashMap;

/// Corners nearer than this of a cell's shorter edge are one vertex.
const WELDED: f64 = 1e-7;

/// A convex polygon on its way to becoming a [`Piece`].
#[derive(Clone)]
pub(super) struct Cut {
    pub(super) part: usize,
    pub(super) cell: u32,
    /// Which part of a cell that is halved; zero in a whole one.
    pub(super) leaf: u32,
    /// Edge lengths of the cell or of that part of it.
    pub(super) extent: DVec2,
    /// Which side of each contact line it lies on, as a hash; cuts that differ are never one patch.
    pub(super) sides: u64,
    pub(super) corners: Vec<DVec2>,
}

/// The grid of a region.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) min: DVec2,
    pub(super) cell: DVec2,
    pub(super) cells: [u32; 2],
}

impl Grid {
    /// Square-like cells with edges of at most `size`.
    pub(super) fn new(outline: &Outline, size: f64) -> Self {
        let extent = outline.max - outline.min;
        let size = size.max(outline.coarsest);
        let count = |length: f64| ((length / size - 1e-6).ceil().max(1.0) as u32).min(4096);
        let cells = [count(extent.x), count(extent.y)];
        let cell = DVec2::new(extent.x / f64::from(cells[0]), extent.y / f64::from(cells[1]));
        Self { min: outline.min, cell: cell.max(DVec2::splat(1e-300)), cells }
    }

    /// Lower corner of a cell.
    pub(super) fn corner(&self, cell: u32) -> DVec2 {
        self.min + DVec2::new(f64::from(cell % self.cells[0]), f64::from(cell / self.cells[0])) * self.cell
    }
}

/// Cuts every part of the region along the grid, finer where `grading` asks for it, and along the contact
/// lines that matter; the others leave the list.
pub(super) fn cut(
    outline: &Outline,
    grid: &Grid,
    contacts: &mut Vec<Contact>,
    grading: &Grading<'_>,
) -> Vec<Cut> {
    let mut cuts = Vec::new();
    let mut strip = Vec::new();
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let tiny = 1e-10 * grid.cell.x * grid.cell.y;
    for (part_index, part) in outline.parts.iter().enumerate() {
        let (min, max) = extent(&part.corners);
        let columns = span(min.x, max.x, grid.min.x, grid.cell.x, grid.cells[0]);
        for i in columns {
            // Both neighbours clip the whole part at the same line, so that their corners agree.
            let low = grid.min.x + f64::from(i) * grid.cell.x;
            let high = grid.min.x + f64::from(i + 1) * grid.cell.x;
            polygon::clip_2d(&part.corners, DVec2::X, if i == 0 { f64::MAX } else { -low }, &mut a);
            let last = i + 1 == grid.cells[0];
            polygon::clip_2d(&a, DVec2::NEG_X, if last { f64::MAX } else { high }, &mut strip);
            if strip.len() < 3 {
                continue;
            }
            let (low_v, high_v) = extent(&strip);
            for j in span(low_v.y, high_v.y, grid.min.y, grid.cell.y, grid.cells[1]) {
                let low = grid.min.y + f64::from(j) * grid.cell.y;
                let high = grid.min.y + f64::from(j + 1) * grid.cell.y;
                polygon::clip_2d(&strip, DVec2::Y, if j == 0 { f64::MAX } else { -low }, &mut a);
                let last = j + 1 == grid.cells[1];
                polygon::clip_2d(&a, DVec2::NEG_Y, if last { f64::MAX } else { high }, &mut b);
                if b.len() < 3 || polygon::area_2d(&b) <= tiny {
                    continue;
                }
                let cell = i + j * grid.cells[0];
                cuts.push(Cut {
                    part: part_index,
                    cell,
                    leaf: 0,
                    extent: grid.cell,
                    sides: 0,
                    corners: b.clone(),
                });
            }
        }
    }
    cuts.sort_by_key(|c| c.cell);
    cuts = grading.halve(cuts, outline, grid);
    if !contacts.is_empty() {
        cuts = contacts::split(cuts, grid, contacts);
    }
    if cuts.iter().any(|cut| cut.leaf != 0) {
        share_corners(&mut cuts, grid);
    }
    let near = 2.0 * WELDED * grid.cell.min_element();
    cuts.retain_mut(|cut| {
        without_twins(&mut cut.corners, near);
        cut.corners.len() >= 3
    });
    cuts
}

/// Leaves out corners that lie on the one before: they would become one vertex, and a triangle without area.
fn without_twins(corners: &mut Vec<DVec2>, near: f64) {
    corners.dedup_by(|corner, before| corner.distance(*before) < near);
    while corners.len() > 1 && corners[0].distance(corners[corners.len() - 1]) < near {
        corners.pop();
    }
}

/// Gives every cut the corners of its neighbours that lie on its edges, so that colours which are
/// interpolated between corners agree along both sides of an edge.
fn share_corners(cuts: &mut [Cut], grid: &Grid) {
    let near = 1e-7 * grid.cell.min_element();
    // A corner on a grid line counts to both cells.
    let wide = 1e-6 * grid.cell;
    let columns =
        |low: f64, high: f64| span(low - wide.x, high + wide.x, grid.min.x, grid.cell.x, grid.cells[0]);
    let rows =
        |low: f64, high: f64| span(low - wide.y, high + wide.y, grid.min.y, grid.cell.y, grid.cells[1]);
    let mut in_cell: HashMap<[u32; 2], Vec<DVec2>> = HashMap::new();
    for &corner in cuts.iter().flat_map(|cut| &cut.corners) {
        for j in rows(corner.y, corner.y) {
            for i in columns(corner.x, corner.x) {
                in_cell.entry([i, j]).or_default().push(corner);
            }
        }
    }
    for cut in cuts {
        let mut corners = Vec::with_capacity(cut.corners.len() + 4);
        for (k, &a) in cut.corners.iter().enumerate() {
            let b = cut.corners[(k + 1) % cut.corners.len()];
            let (min, max) = extent(&[a, b]);
            let length = a.distance(b);
            let along = (b - a) / length.max(f64::MIN_POSITIVE);
            let mut between: Vec<(f64, DVec2)> = rows(min.y, max.y)
                .flat_map(|j| columns(min.x, max.x).map(move |i| [i, j]))
                .filter_map(|cell| in_cell.get(&cell))
                .flatten()
                .map(|&corner| (along.dot(corner - a), corner))
                .filter(|&(t, corner)| {
                    t > near && t < length - near && along.perp_dot(corner - a).abs() < near
                })
                .collect();
            between.sort_by(|p, q| p.0.total_cmp(&q.0));
            between.dedup_by(|p, q| p.0 - q.0 < near);
            corners.push(a);
            corners.extend(between.into_iter().map(|(_, corner)| corner));
        }
        cut.corners = with_whole_fan(corners);
    }
}

/// The corners of a convex polygon turned so that no triangle of the fan from the first is flat, where
/// that can be: corners may lie within edges.
fn with_whole_fan(mut corners: Vec<DVec2>) -> Vec<DVec2> {
    let n = corners.len();
    let flattest = |first: usize| {
        let at = |k: usize| corners[(first + k) % n];
        (1..n - 1).map(|k| (at(k) - at(0)).perp_dot(at(k + 1) - at(0))).fold(f64::INFINITY, f64::min)
    };
    let best = (0..n).rev().max_by(|&a, &b| flattest(a).total_cmp(&flattest(b))).unwrap_or(0);
    corners.rotate_left(best);
    corners
}

pub(super) fn extent(corners: &[DVec2]) -> (DVec2, DVec2) {
    corners.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), &c| (min.min(c), max.max(c)))
}

/// Indices of the grid cells that an interval overlaps by more than a sliver.
pub(super) fn span(low: f64, high: f64, min: f64, cell: f64, count: u32) -> std::ops::Range<u32> {
    let last = f64::from(count - 1);
    let first = ((low - min) / cell + 1e-7).floor().clamp(0.0, last) as u32;
    let end = ((high - min) / cell - 1e-7).floor().clamp(0.0, last) as u32;
    first..end.max(first) + 1
}

/// Appends a region, its pieces and its cell lists to the mesh; patches are not assigned yet.
pub(super) fn append(mesh: &mut PatchMesh, outline: &Outline, grid: &Grid, cuts: &[Cut]) {
    let region = mesh.regions.len() as u32;
    let first_piece = mesh.pieces.len() as u32;
    let mut welder = Welder::new(WELDED * grid.cell.min_element());
    let mut vertex_of: Vec<u32> = Vec::new();
    for cut in cuts {
        let part = &outline.parts[cut.part];
        let first_corner = mesh.corners.len() as u32;
        for &plane in &cut.corners {
            let local = welder.index(plane.extend(0.0)) as usize;
            if local == vertex_of.len() {
                vertex_of.push(mesh.vertices.len() as u32);
                mesh.vertices.push(outline.world(plane));
            }
            let (normal, uv) = part.attributes.at(plane, outline.frame.normal);
            mesh.corners.push(PieceCorner { vertex: vertex_of[local], plane, normal, uv });
        }
        mesh.pieces.push(Piece {
            region,
            surface: part.surface,
            corners: first_corner..mesh.corners.len() as u32,
            patches: [super::NO_PATCH; 2],
            backed: false,
            area: polygon::area_2d(&cut.corners),
        });
    }
    let first_cell = mesh.cell_pieces.len() as u32;
    let mut cursor = 0;
    for cell in 0..grid.cells[0] * grid.cells[1] {
        let start = mesh.piece_lists.len() as u32;
        while cursor < cuts.len() && cuts[cursor].cell == cell {
            mesh.piece_lists.push(first_piece + cursor as u32);
            cursor += 1;
        }
        mesh.cell_pieces.push(start..mesh.piece_lists.len() as u32);
    }
    mesh.regions.push(Region {
        origin: outline.origin,
        frame: outline.frame,
        edges: outline.edges.clone(),
        grid_min: grid.min,
        cell_size: grid.cell,
        cells: grid.cells,
        first_cell,
        pieces: first_piece..mesh.pieces.len() as u32,
        material: outline.material,
        object: outline.object,
        bounds: outline.bounds,
        area: outline.area,
        dark: [false; 2],
        dark_as_whole: [false; 2],
        backing: super::Backing::None,
        has_holes: outline.has_holes,
    });
}

/// As [`append`], for parts that stay whole whatever the grid: every cell lists all parts that overlap it.
pub(super) fn append_as_given(mesh: &mut PatchMesh, outline: &Outline) {
    let average = (outline.area / outline.parts.len() as f64).sqrt();
    let mut grid = Grid::new(outline, average);
    let cuts: Vec<Cut> = (0..outline.parts.len())
        .map(|part| Cut {
            part,
            cell: 0,
            leaf: 0,
            extent: grid.cell,
            sides: 0,
            corners: outline.parts[part].corners.clone(),
        })
        .collect();
    let whole = Grid { cells: [1, 1], ..grid };
    append(mesh, outline, &whole, &cuts);
    let Some(region) = mesh.regions.last_mut() else { return };

    // Replace the single cell by the grid.
    mesh.cell_pieces.truncate(region.first_cell as usize);
    mesh.piece_lists.truncate(mesh.piece_lists.len() - cuts.len());
    if cuts.len() == 1 {
        grid.cells = [1, 1];
        grid.cell = outline.max - outline.min;
    }
    let mut lists = vec![Vec::new(); (grid.cells[0] * grid.cells[1]) as usize];
    for (k, part) in outline.parts.iter().enumerate() {
        let (min, max) = extent(&part.corners);
        for j in span(min.y, max.y, grid.min.y, grid.cell.y, grid.cells[1]) {
            for i in span(min.x, max.x, grid.min.x, grid.cell.x, grid.cells[0]) {
                lists[(i + j * grid.cells[0]) as usize].push(region.pieces.start + k as u32);
            }
        }
    }
    for list in lists {
        let start = mesh.piece_lists.len() as u32;
        mesh.piece_lists.extend(list);
        mesh.cell_pieces.push(start..mesh.piece_lists.len() as u32);
    }
    region.cell_size = grid.cell.max(DVec2::splat(1e-300));
    region.cells = grid.cells;
}
