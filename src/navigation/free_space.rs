//! Ways through a model that pass through nothing: along walls, through doors and around furniture.

use super::clearance::Clearance;
use crate::geometry::{Bvh, Ray};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A metre up or down counts as so many level ones: who walks keeps the height of the eyes.
const CLIMB: f64 = 3.0;
/// How far around a place one looks for a cell to start from, metres for an adult.
const STARTS_WITHIN: f64 = 1.0;
/// A straight line is taken where it costs at most so many times as much as the steps of the grid,
/// which run in 26 directions and are longer than need be.
const STRAIGHTER: f64 = 1.12;
/// Distance of the points of a bent way, metres for an adult.
const SPACING: f64 = 0.3;
/// Rounds in which bends are eased.
const EASE_ROUNDS: usize = 40;
/// Bends are not eased to where a metre costs more than this.
const EASED_PRICE: f64 = 1.9;

/// The free space of a model: finds ways between places.
///
/// The way on a grid of cells (A*; Hart, Nilsson & Raphael 1968), with prices that keep it clear of
/// things, is pulled straight as far as that costs no more, and its bends are eased; each of its
/// segments is tried against all triangles.
#[derive(Clone, Debug)]
pub struct FreeSpace {
    bvh: Bvh,
    clearance: Clearance,
    up: DVec3,
    scale: f64,
}

impl FreeSpace {
    /// Of these triangles, for ways between `places`, metres. `up` is a unit vector along an axis;
    /// `scale` the metres of the model to one of an adult, above zero ([`super::person_scale`]). Takes
    /// some tenths of a second for a house.
    pub fn new(triangles: &[[DVec3; 3]], places: &[DVec3], up: DVec3, scale: f64) -> Self {
        let clearance = Clearance::new(triangles, places, up, scale);
        Self { bvh: Bvh::build(triangles), clearance, up, scale }
    }

    /// Whether nothing stands between two places.
    pub fn sees(&self, from: DVec3, to: DVec3) -> bool {
        from == to || !self.bvh.occluded(&Ray { origin: from, direction: to - from }, 0.0, 1.0)
    }

    /// Points between `from` and `to`, so that straight lines from one to the next pass through
    /// nothing; none where the straight way is free and good. `None` where there is no way.
    pub fn way(&self, from: DVec3, to: DVec3) -> Option<Vec<DVec3>> {
        let steps = self.steps(self.start(from)?, self.start(to)?)?;
        let points: Vec<DVec3> = [from].into_iter().chain(steps).chain([to]).collect();
        let pulled = self.pulled(&points);
        if pulled.len() == 2 {
            return Some(Vec::new());
        }
        let mut eased = self.eased(&pulled);
        eased.pop();
        eased.remove(0);
        Some(eased)
    }

    /// The free cell nearest to a place that can be seen from there.
    fn start(&self, place: DVec3) -> Option<usize> {
        let grid = &self.clearance;
        let reach = (STARTS_WITHIN * self.scale / grid.cell()).ceil() as usize;
        let (at, counts) = (grid.cell_at(place), grid.counts());
        let range = |axis: usize| at[axis].saturating_sub(reach)..(at[axis] + reach + 1).min(counts[axis]);
        let mut cells: Vec<(f64, usize)> = Vec::new();
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let index = grid.index([x, y, z]);
                    if !grid.is_blocked(index) {
                        cells.push((self.length(grid.centre(index) - place), index));
                    }
                }
            }
        }
        cells.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        cells.into_iter().map(|(_, index)| index).find(|&index| self.sees(place, grid.centre(index)))
    }

    /// Length of a way with what it climbs weighed, metres.
    fn length(&self, way: DVec3) -> f64 {
        let climb = way.dot(self.up);
        (way.length_squared() + (CLIMB * CLIMB - 1.0) * climb * climb).sqrt()
    }

    /// Centres of the cells on the cheapest way between two cells, both included.
    fn steps(&self, start: usize, goal: usize) -> Option<Vec<DVec3>> {
        let grid = &self.clearance;
        let counts = grid.counts();
        let goal_at = grid.centre(goal);
        let mut costs = vec![f64::INFINITY; counts.iter().product()];
        let mut from = vec![u32::MAX; costs.len()];
        // Costs are not negative: their bits are in their order.
        let mut open = BinaryHeap::from([Reverse((0_u64, start))]);
        costs[start] = 0.0;
        let neighbours = self.neighbours();
        while let Some(Reverse((bits, cell))) = open.pop() {
            if cell == goal {
                return Some(self.traced(&from, goal));
            }
            let here = grid.centre(cell);
            // A cheaper way here was found since.
            if f64::from_bits(bits) > costs[cell] + self.length(goal_at - here) + 1e-9 {
                continue;
            }
            let at = grid.coordinates(cell);
            for (step, length) in &neighbours {
                let to: [Option<usize>; 3] = std::array::from_fn(|axis| {
                    at[axis].checked_add_signed(step[axis]).filter(|&n| n < counts[axis])
                });
                let [Some(x), Some(y), Some(z)] = to else { continue };
                let next = grid.index([x, y, z]);
                if grid.is_blocked(next) {
                    continue;
                }
                let cost = costs[cell] + length * 0.5 * (grid.price(cell) + grid.price(next));
                if cost < costs[next] {
                    (costs[next], from[next]) = (cost, cell as u32);
                    let whole = cost + self.length(goal_at - grid.centre(next));
                    open.push(Reverse((whole.to_bits(), next)));
                }
            }
        }
        None
    }

    /// Steps to the 26 cells around one, with their lengths.
    fn neighbours(&self) -> Vec<([isize; 3], f64)> {
        let each = |k: isize| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
        (0..27)
            .filter(|&k| k != 13)
            .map(|k| {
                let [x, y, z] = each(k).map(|n| n as f64);
                (each(k), self.length(DVec3::new(x, y, z) * self.clearance.cell()))
            })
            .collect()
    }

    fn traced(&self, from: &[u32], goal: usize) -> Vec<DVec3> {
        let mut cells = vec![goal];
        while let Some(&before) = from.get(cells[cells.len() - 1]).filter(|&&before| before != u32::MAX) {
            cells.push(before as usize);
        }
        cells.iter().rev().map(|&cell| self.clearance.centre(cell)).collect()
    }

    /// What a straight line costs.
    fn cost(&self, from: DVec3, to: DVec3) -> f64 {
        let way = to - from;
        let samples = (2.0 * way.length() / self.clearance.cell()).ceil().max(1.0) as usize;
        let price = |k: usize| self.clearance.price_at(from + way * ((k as f64 + 0.5) / samples as f64));
        self.length(way) / samples as f64 * (0..samples).map(price).sum::<f64>()
    }

    /// The corners that are left when straight lines replace what costs as much.
    fn pulled(&self, points: &[DVec3]) -> Vec<DVec3> {
        let mut costs = vec![0.0];
        for pair in points.windows(2) {
            costs.push(costs[costs.len() - 1] + self.cost(pair[0], pair[1]));
        }
        let mut corners = vec![points[0]];
        let mut at = 0;
        while at + 1 < points.len() {
            let is_good = |&next: &usize| {
                self.cost(points[at], points[next]) <= STRAIGHTER * (costs[next] - costs[at])
                    && self.sees(points[at], points[next])
            };
            at = (at + 2..points.len()).rev().find(is_good).unwrap_or(at + 1);
            corners.push(points[at]);
        }
        corners
    }

    /// Evenly spaced points along the corners, drawn towards the middle of their neighbours where that
    /// keeps clear of things.
    fn eased(&self, corners: &[DVec3]) -> Vec<DVec3> {
        let mut points = vec![corners[0]];
        for pair in corners.windows(2) {
            let parts = (pair[0].distance(pair[1]) / (SPACING * self.scale)).ceil().max(1.0) as usize;
            points.extend((1..=parts).map(|k| pair[0].lerp(pair[1], k as f64 / parts as f64)));
        }
        for _ in 0..EASE_ROUNDS {
            for k in 1..points.len() - 1 {
                let (before, here, after) = (points[k - 1], points[k], points[k + 1]);
                let to = here.lerp(0.5 * (before + after), 0.5);
                let most = self.clearance.price_at(here).max(EASED_PRICE);
                if self.clearance.price_at(to) <= most && self.sees(before, to) && self.sees(to, after) {
                    points[k] = to;
                }
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(corners: [[f64; 3]; 4]) -> [[DVec3; 3]; 2] {
        let [a, b, c, d] = corners.map(DVec3::from);
        [[a, b, c], [a, c, d]]
    }

    /// A room of 8 m x 3 m x 6 m with a wall across its middle at x = 4 and a door of 0.9 m in it, from
    /// z = `door`.
    fn two_rooms(door: f64) -> Vec<[DVec3; 3]> {
        let wall = |x: f64, z: [f64; 2], y: [f64; 2]| {
            quad([[x, y[0], z[0]], [x, y[0], z[1]], [x, y[1], z[1]], [x, y[1], z[0]]])
        };
        let level = |y: f64| quad([[0.0, y, 0.0], [8.0, y, 0.0], [8.0, y, 6.0], [0.0, y, 6.0]]);
        let across = |z: f64| quad([[0.0, 0.0, z], [8.0, 0.0, z], [8.0, 3.0, z], [0.0, 3.0, z]]);
        let all = [0.0, 3.0];
        [
            level(0.0),
            level(3.0),
            across(0.0),
            across(6.0),
            wall(0.0, [0.0, 6.0], all),
            wall(8.0, [0.0, 6.0], all),
            wall(4.0, [0.0, door], all),
            wall(4.0, [door + 0.9, 6.0], all),
            wall(4.0, [door, door + 0.9], [2.1, 3.0]),
        ]
        .concat()
    }

    const FROM: DVec3 = DVec3::new(1.0, 1.6, 1.0);
    const TO: DVec3 = DVec3::new(7.0, 1.6, 1.0);

    fn whole(space: &FreeSpace, from: DVec3, to: DVec3) -> Vec<DVec3> {
        let between = space.way(from, to).expect("a way");
        [from].into_iter().chain(between).chain([to]).collect()
    }

    #[test]
    fn a_way_leads_through_the_door_and_is_hardly_longer_than_it_must_be() {
        let triangles = two_rooms(4.0);
        let space = FreeSpace::new(&triangles, &[FROM, TO], DVec3::Y, 1.0);
        assert!(!space.sees(FROM, TO));
        let way = whole(&space, FROM, TO);
        assert!(way.windows(2).all(|p| space.sees(p[0], p[1])), "{way:?}");
        let through: Vec<f64> = way
            .windows(2)
            .filter(|p| p[0].x <= 4.0 && p[1].x > 4.0)
            .map(|p| p[0].lerp(p[1], (4.0 - p[0].x) / (p[1].x - p[0].x)).z)
            .collect();
        assert!(through.len() == 1 && (4.15..4.75).contains(&through[0]), "through the door: {through:?}");
        let length: f64 = way.windows(2).map(|p| p[0].distance(p[1])).sum();
        let least = 2.0 * 3.0_f64.hypot(3.0);
        assert!(length < 1.12 * least, "{length} m, {least} m at least");
        assert!(way.iter().all(|p| (p.y - 1.6).abs() < 0.15), "at the height of the eyes: {way:?}");
    }

    #[test]
    fn the_straight_way_is_taken_where_it_is_free() {
        let space = FreeSpace::new(&two_rooms(4.0), &[FROM, TO], DVec3::Y, 1.0);
        assert_eq!(space.way(FROM, DVec3::new(3.2, 1.5, 5.0)), Some(Vec::new()));
        assert_eq!(space.way(FROM, FROM), Some(Vec::new()));
    }

    #[test]
    fn there_is_no_way_into_a_closed_room() {
        let mut triangles = two_rooms(4.0);
        triangles.extend(quad([[4.0, 0.0, 4.0], [4.0, 0.0, 4.9], [4.0, 2.1, 4.9], [4.0, 2.1, 4.0]]));
        let space = FreeSpace::new(&triangles, &[FROM, TO], DVec3::Y, 1.0);
        assert_eq!(space.way(FROM, TO), None);
        assert_eq!(space.way(FROM, DVec3::new(4.0, 9.0, 3.0)), None);
    }

    #[test]
    fn furniture_is_walked_around() {
        let mut triangles = two_rooms(4.0);
        // A table in the way; the eyes could pass above it.
        triangles.extend(quad([[1.4, 0.75, 2.2], [2.6, 0.75, 2.2], [2.6, 0.75, 3.4], [1.4, 0.75, 3.4]]));
        let (from, to) = (DVec3::new(2.0, 1.6, 1.0), DVec3::new(2.0, 1.6, 5.0));
        let space = FreeSpace::new(&triangles, &[from, to], DVec3::Y, 1.0);
        let way = whole(&space, from, to);
        let beside = |p: &DVec3| !(1.4..2.6).contains(&p.x) || !(2.2..3.4).contains(&p.z);
        assert!(way.len() > 4 && way.iter().all(beside), "{way:?}");
    }

    #[test]
    fn a_place_in_a_corner_is_left_and_the_same_way_is_found_again() {
        let corner = DVec3::new(0.03, 1.6, 0.03);
        let find = || {
            let space = FreeSpace::new(&two_rooms(2.0), &[corner, TO], DVec3::Y, 1.0);
            let way = whole(&space, corner, TO);
            assert!(way.windows(2).all(|p| space.sees(p[0], p[1])), "{way:?}");
            way
        };
        assert_eq!(find(), find());
    }
}
