//! How much room there is around each place of a model, on a grid of cells.

use crate::geometry::{Aabb, nearest_in_triangle};
use glam::DVec3;

/// Edge of a cell in the measure of an adult, metres; larger in large models.
const CELL: f64 = 0.11;
/// Cells in all, at most about.
const MOST_CELLS: f64 = 700_000.0;
/// With cells so many times as large no door is seen: then only what is around the places gets some.
const COARSEST: f64 = 4.0;
/// Around the places, besides half the box around them, metres for an adult.
const AROUND: f64 = 6.0;
/// Half a diagonal of a cell, in cells.
const HALF_DIAGONAL: f64 = 0.866_025_403_8;
/// One keeps so far from things where there is room, metres for an adult.
const BERTH: f64 = 0.45;
/// From the eyes down to the knees, metres for an adult.
const EYES_TO_KNEES: f64 = 1.15;
/// Room that is left around the model for ways outside, metres for an adult.
const MARGIN: f64 = 1.2;
/// Price of a metre right beside things, above that in the open.
const PRICE_BESIDE: f64 = 2.0;
/// Price of a metre above furniture, which a walker would bump into.
const PRICE_ABOVE: f64 = 1.5;
/// Price of a metre through a cell that something is in.
const PRICE_BLOCKED: f32 = 30.0;

/// A price for each cell: 1 a metre in the open, more beside things and above furniture, most where
/// something is in the cell.
///
/// The centre of a cell that is not blocked keeps half a diagonal clear of everything, so that the
/// straight way to a neighbour that is not blocked either, across a corner too, meets nothing.
#[derive(Clone, Debug)]
pub(super) struct Clearance {
    origin: DVec3,
    cell: f64,
    counts: [usize; 3],
    prices: Vec<f32>,
}

impl Clearance {
    /// For these triangles and all of `places`. `up` is a unit vector along an axis, `scale` the metres
    /// of the model to one of an adult.
    pub(super) fn new(triangles: &[[DVec3; 3]], places: &[DVec3], up: DVec3, scale: f64) -> Self {
        let corners = triangles.iter().flatten().chain(places).copied().filter(|p| p.is_finite());
        let bounds = Aabb::around(corners);
        let bounds = if bounds.is_empty() { Aabb::around([DVec3::ZERO]) } else { bounds };
        let bounds = bounds.grown(MARGIN * scale);
        let cell_for =
            |bounds: &Aabb| (bounds.size().element_product() / MOST_CELLS).cbrt().max(CELL * scale);
        let visited = Aabb::around(places.iter().copied().filter(|p| p.is_finite()));
        // On a site of kilometres one walks through a house.
        let bounds = if cell_for(&bounds) > COARSEST * CELL * scale && !visited.is_empty() {
            let around = visited.grown(0.5 * visited.diagonal() + AROUND * scale);
            Aabb { min: around.min.max(bounds.min), max: around.max.min(bounds.max) }
        } else {
            bounds
        };
        let (origin, size, cell) = (bounds.min, bounds.size(), cell_for(&bounds));
        let counts = size.to_array().map(|length| (length / cell) as usize + 1);
        let mut grid = Self { origin, cell, counts, prices: Vec::new() };
        let occupied = grid.occupied(triangles);
        let reach = ((BERTH * scale / cell).ceil() as usize).max(1);
        let distances = grid.distances(&occupied, reach);
        let above = grid.above(&occupied, up, (EYES_TO_KNEES * scale / cell) as usize);
        let berth = BERTH * scale / cell;
        let price = |k: usize| {
            if occupied[k] {
                return PRICE_BLOCKED;
            }
            let beside = (1.0 - f64::from(distances[k]).sqrt() / berth).max(0.0);
            (1.0 + PRICE_BESIDE * beside + if above[k] { PRICE_ABOVE } else { 0.0 }) as f32
        };
        grid.prices = (0..occupied.len()).map(price).collect();
        grid
    }

    /// Cells across, up and along.
    pub(super) fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// Edge of a cell, metres.
    pub(super) fn cell(&self) -> f64 {
        self.cell
    }

    /// Index of the cell at these coordinates.
    pub(super) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// Coordinates of a cell.
    pub(super) fn coordinates(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// Centre of a cell.
    pub(super) fn centre(&self, index: usize) -> DVec3 {
        let [x, y, z] = self.coordinates(index).map(|n| n as f64 + 0.5);
        self.origin + DVec3::new(x, y, z) * self.cell
    }

    /// The cell that a point is in, or the nearest one.
    pub(super) fn cell_at(&self, point: DVec3) -> [usize; 3] {
        let local = ((point - self.origin) / self.cell).to_array();
        // What is below zero or no number becomes zero.
        std::array::from_fn(|axis| (local[axis] as usize).min(self.counts[axis] - 1))
    }

    /// Price of a metre in a cell.
    pub(super) fn price(&self, index: usize) -> f64 {
        f64::from(self.prices[index])
    }

    /// Whether something is in a cell.
    pub(super) fn is_blocked(&self, index: usize) -> bool {
        self.prices[index] >= PRICE_BLOCKED
    }

    /// Price of a metre at a point.
    pub(super) fn price_at(&self, point: DVec3) -> f64 {
        self.price(self.index(self.cell_at(point)))
    }

    /// Cells whose centre is within half a diagonal of a triangle.
    fn occupied(&self, triangles: &[[DVec3; 3]]) -> Vec<bool> {
        let mut occupied = vec![false; self.counts.iter().product()];
        let reach = HALF_DIAGONAL * self.cell * (1.0 + 1e-9);
        for triangle in triangles.iter().filter(|t| t.iter().all(|p| p.is_finite())) {
            let bounds = Aabb::around(*triangle);
            let (low, high) = (self.cell_at(bounds.min - reach), self.cell_at(bounds.max + reach));
            let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalize_or_zero();
            for z in low[2]..=high[2] {
                for y in low[1]..=high[1] {
                    for x in low[0]..=high[0] {
                        let index = self.index([x, y, z]);
                        let centre = self.centre(index);
                        // Off its plane it is off the triangle.
                        if !occupied[index] && (centre - triangle[0]).dot(normal).abs() <= reach {
                            let apart = nearest_in_triangle(centre, triangle).distance_squared(centre);
                            occupied[index] = apart <= reach * reach;
                        }
                    }
                }
            }
        }
        occupied
    }

    /// Squares of the distances to the nearest occupied cell, in cells and up to `reach` of them: one
    /// axis after another (Saito & Toriwaki 1994).
    fn distances(&self, occupied: &[bool], reach: usize) -> Vec<f32> {
        let far = (reach * reach) as f32;
        let mut squares: Vec<f32> = occupied.iter().map(|&o| if o { 0.0 } else { far }).collect();
        let mut line = Vec::new();
        for axis in 0..3 {
            let stride: usize = self.counts[..axis].iter().product();
            let length = self.counts[axis];
            for start in 0..squares.len() {
                if !(start / stride).is_multiple_of(length) {
                    continue;
                }
                line.clear();
                line.extend((0..length).map(|k| squares[start + k * stride]));
                if line.iter().all(|&square| square >= far) {
                    continue;
                }
                for k in 0..length {
                    let near = k.saturating_sub(reach)..(k + reach + 1).min(length);
                    let square = |j: usize| line[j] + (k.abs_diff(j) * k.abs_diff(j)) as f32;
                    squares[start + k * stride] = near.map(square).fold(far, f32::min);
                }
            }
        }
        squares
    }

    /// Whether something is in the column of `depth` cells below each cell.
    fn above(&self, occupied: &[bool], up: DVec3, depth: usize) -> Vec<bool> {
        let axis = up.abs().max_position();
        let (stride, length): (usize, usize) = (self.counts[..axis].iter().product(), self.counts[axis]);
        let mut above = vec![false; occupied.len()];
        for start in (0..occupied.len()).filter(|start| (start / stride).is_multiple_of(length)) {
            let mut since = usize::MAX;
            for k in 0..length {
                let level = if up[axis] > 0.0 { k } else { length - 1 - k };
                let index = start + level * stride;
                since = if occupied[index] { 0 } else { since.saturating_add(1) };
                above[index] = since <= depth;
            }
        }
        above
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level square of 4 m x 4 m at this height.
    fn level(height: f64) -> Vec<[DVec3; 3]> {
        let corners = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]];
        let [a, b, c, d] = corners.map(|[x, z]| DVec3::new(x, height, z));
        vec![[a, b, c], [a, c, d]]
    }

    #[test]
    fn cells_that_are_not_blocked_keep_clear_and_none_is_blocked_for_nothing() {
        let slanted = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(3.0, 1.7, 0.9), DVec3::new(0.9, 2.2, 2.8)];
        let grid = Clearance::new(&[slanted], &[], DVec3::Y, 1.0);
        let reach = 0.5 * 3.0_f64.sqrt() * grid.cell();
        let mut blocked = 0;
        for index in 0..grid.prices.len() {
            let centre = grid.centre(index);
            assert_eq!(grid.index(grid.cell_at(centre)), index);
            let apart = nearest_in_triangle(centre, &slanted).distance(centre);
            assert_eq!(grid.is_blocked(index), apart <= reach, "{centre} is {apart} away");
            blocked += usize::from(grid.is_blocked(index));
        }
        assert!(blocked > 100, "{blocked}");
    }

    #[test]
    fn the_open_is_cheapest_and_the_price_falls_with_the_distance() {
        let grid = Clearance::new(&level(0.0), &[DVec3::new(2.0, 3.0, 2.0)], DVec3::Y, 1.0);
        let at = |height: f64| grid.price_at(DVec3::new(2.0, height, 2.0));
        assert!(at(0.0) > 10.0, "in the floor: {}", at(0.0));
        assert_eq!(at(1.7), 1.0, "eyes of somebody who stands on it");
        assert!(at(0.2) > at(0.4) && at(0.4) > at(1.7), "{} {}", at(0.2), at(0.4));
        let low = |height: f64| at(height) - 1.0;
        // Between 0.45 m and the knees there is furniture below and nothing beside.
        assert!((low(0.8) - PRICE_ABOVE).abs() < 1e-6, "above a table: {}", low(0.8));
    }

    #[test]
    fn large_models_get_larger_cells_unless_only_a_part_is_walked_through() {
        let far = DVec3::new(400.0, 30.0, 250.0);
        let grid = Clearance::new(&level(0.0), &[DVec3::ZERO, far], DVec3::Y, 1.0);
        let cells: usize = grid.counts().iter().product();
        assert!(cells < 900_000 && grid.cell() > 1.0, "{cells} cells of {} m", grid.cell());
        assert_eq!(grid.price_at(far), 1.0);
        // Two kilometres of terrain around a walk of three metres.
        let site: Vec<_> = level(0.0).into_iter().map(|t| t.map(|p| (p - 2.0) * 500.0)).collect();
        let walk = [DVec3::new(3.0, -999.4, 4.0), DVec3::new(6.0, -999.4, 4.0)];
        let grid = Clearance::new(&site, &walk, DVec3::Y, 1.0);
        assert!(grid.cell() < 0.2, "cells of {} m", grid.cell());
        assert_eq!(grid.cell_at(walk[0]).map(|n| n > 0), [true; 3]);
    }
}
