//! Walking: a person as an upright capsule that slides along walls, climbs steps and falls.
//!
//! The body never moves more than half its radius between two tests, so it cannot pass through a
//! wall however thin, at any speed and any frame rate. Walls push it back at right angles to
//! themselves, which leaves the motion along them: that is the sliding.

use super::person_scale;
use crate::geometry::{Aabb, nearest_in_triangle};
use crate::mesh::PatchMesh;
use crate::scene::Extent;
use glam::{DVec2, DVec3};

/// Acceleration of a falling body, m/s².
const GRAVITY: f64 = 9.81;
/// Cells along the longer side of the ground grid, at most.
const MAX_CELLS: f64 = 256.0;
/// Rounds of pushing out of walls after each partial step: two suffice in a corner.
const PUSH_ROUNDS: usize = 4;
/// Partial steps in one call, at most; a longer way is cut short.
const MAX_SUBSTEPS: f64 = 400.0;

/// Measures of the walking person, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Half the width.
    pub radius: f64,
    /// Eyes above the floor.
    pub eye_height: f64,
    /// Highest step that is climbed without jumping.
    pub step: f64,
    /// Top of the head above the eyes.
    pub headroom: f64,
}

impl Body {
    /// An adult, or one scaled to stand in a model of `room_height` metres that is too low for an
    /// adult (the Cornell box measures 0.55 m).
    pub fn for_room(room_height: f64, eye_height: f64) -> Self {
        let scale = person_scale(room_height);
        Self {
            radius: 0.22 * scale,
            eye_height: eye_height * scale,
            step: 0.35 * scale,
            headroom: 0.1 * scale,
        }
    }

    /// Metres of the model to one metre of an adult.
    pub fn scale(&self) -> f64 {
        self.step / 0.35
    }
}

/// Where a walk ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// The feet, metres.
    pub feet: DVec3,
    /// Speed of falling, m/s; zero on the ground.
    pub fall_speed: f64,
    /// Whether the feet stand on something.
    pub grounded: bool,
}

/// Everything that a walking person can stand on or run into, sorted into columns above the ground.
#[derive(Clone, Debug, Default)]
pub struct Obstacles {
    triangles: Vec<[DVec3; 3]>,
    up: DVec3,
    /// The two level axes.
    level: [DVec3; 2],
    origin: DVec2,
    cell: f64,
    cells: [usize; 2],
    /// Start of each cell in `lists`, one more than there are cells.
    starts: Vec<u32>,
    lists: Vec<u32>,
}

impl Obstacles {
    /// Sorts the triangles of a mesh; `up` is a unit vector along an axis.
    ///
    /// What lies far away from the rest cannot be walked to, and would make the cells too large.
    pub fn of_mesh(mesh: &PatchMesh, up: DVec3, extent: &Extent) -> Self {
        let mut triangles = mesh.triangles().0;
        // Nobody walks through glass.
        triangles.extend(mesh.panes.triangles().0);
        triangles.retain(|triangle| extent.holds(&Aabb::around(*triangle)));
        Self::new(triangles, up)
    }

    /// Sorts `triangles`; those that are not finite are left out. `up` is a unit vector.
    pub fn new(triangles: Vec<[DVec3; 3]>, up: DVec3) -> Self {
        let right = up.any_orthonormal_vector();
        let level = [right, up.cross(right)];
        let flat = |p: DVec3| DVec2::new(p.dot(level[0]), p.dot(level[1]));
        let triangles: Vec<_> = triangles.into_iter().filter(|t| t.iter().all(|p| p.is_finite())).collect();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in triangles.iter().flatten() {
            low = low.min(flat(*point));
            high = high.max(flat(*point));
        }
        if triangles.is_empty() {
            return Self { up, level, cell: 1.0, starts: vec![0], ..Self::default() };
        }
        let extent = high - low;
        let cell = (extent.max_element() / MAX_CELLS).max(1e-6).max(extent.max_element().min(0.5));
        let cells = [0, 1].map(|axis| (extent[axis] / cell) as usize + 1);
        let mut obstacles =
            Self { triangles, up, level, origin: low, cell, cells, starts: Vec::new(), lists: Vec::new() };
        obstacles.fill();
        obstacles
    }

    /// Counts, then places: a counting sort of triangles into the cells that their boxes meet.
    fn fill(&mut self) {
        let mut counts = vec![0_u32; self.cells[0] * self.cells[1] + 1];
        for triangle in &self.triangles {
            self.for_cells(self.flat_box(triangle), |c| counts[c + 1] += 1);
        }
        for c in 1..counts.len() {
            counts[c] += counts[c - 1];
        }
        let mut next = counts.clone();
        let mut lists = vec![0_u32; *counts.last().unwrap_or(&0) as usize];
        for (index, triangle) in self.triangles.iter().enumerate() {
            self.for_cells(self.flat_box(triangle), |c| {
                lists[next[c] as usize] = index as u32;
                next[c] += 1;
            });
        }
        (self.starts, self.lists) = (counts, lists);
    }

    fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new(p.dot(self.level[0]), p.dot(self.level[1]))
    }

    fn flat_box(&self, triangle: &[DVec3; 3]) -> [DVec2; 2] {
        let [a, b, c] = triangle.map(|p| self.flat(p));
        [a.min(b).min(c), a.max(b).max(c)]
    }

    fn for_cells(&self, [low, high]: [DVec2; 2], mut found: impl FnMut(usize)) {
        let index = |p: DVec2, axis: usize| ((p[axis] - self.origin[axis]) / self.cell).floor();
        let range = |axis: usize| {
            let last = self.cells[axis] as f64 - 1.0;
            let (from, to) = (index(low, axis), index(high, axis));
            // A box beside the grid meets no cell.
            (to >= 0.0 && from <= last).then(|| from.max(0.0) as usize..=to.min(last) as usize)
        };
        let (Some(columns), Some(rows)) = (range(0), range(1)) else { return };
        for row in rows {
            for column in columns.clone() {
                found(row * self.cells[0] + column);
            }
        }
    }

    fn near(&self, low: DVec2, high: DVec2, mut found: impl FnMut(&[DVec3; 3])) {
        if self.triangles.is_empty() {
            return;
        }
        self.for_cells([low, high], |c| {
            for &t in &self.lists[self.starts[c] as usize..self.starts[c + 1] as usize] {
                found(&self.triangles[t as usize]);
            }
        });
    }

    /// Height (along up, metres) of the highest thing below `point`, itself included.
    pub fn floor_below(&self, point: DVec3) -> Option<f64> {
        let (at, top) = (self.flat(point), point.dot(self.up));
        let mut best: Option<f64> = None;
        self.near(at, at, |triangle| {
            if let Some(height) = self.height_over(triangle, at)
                && height <= top + 1e-9
                && best.is_none_or(|b| height > b)
            {
                best = Some(height);
            }
        });
        best
    }

    /// Height of the lowest thing above `point`.
    fn ceiling_above(&self, point: DVec3) -> Option<f64> {
        let (at, bottom) = (self.flat(point), point.dot(self.up));
        let mut best: Option<f64> = None;
        self.near(at, at, |triangle| {
            if let Some(height) = self.height_over(triangle, at)
                && height > bottom
                && best.is_none_or(|b| height < b)
            {
                best = Some(height);
            }
        });
        best
    }

    /// Height of a triangle over a point of the ground plane; `None` beside it or on its edge.
    fn height_over(&self, triangle: &[DVec3; 3], at: DVec2) -> Option<f64> {
        let [a, b, c] = triangle.map(|p| self.flat(p));
        let area = (b - a).perp_dot(c - a);
        if area.abs() < 1e-12 * self.cell * self.cell {
            return None;
        }
        let v = (at - a).perp_dot(c - a) / area;
        let w = (b - a).perp_dot(at - a) / area;
        let slack = -1e-9;
        (v >= slack && w >= slack && v + w <= 1.0 - slack).then(|| {
            let heights = triangle.map(|p| p.dot(self.up));
            heights[0] + v * (heights[1] - heights[0]) + w * (heights[2] - heights[0])
        })
    }

    /// Moves a person by `way` (its level part, metres) and lets gravity act for `dt` seconds.
    ///
    /// Where nothing lies below at all, the person stays at this height instead of falling for ever.
    pub fn walk(&self, body: &Body, from: Footing, way: DVec3, dt: f64) -> Footing {
        let way = way - self.up * way.dot(self.up);
        let substeps = (way.length() / (0.5 * body.radius)).ceil().clamp(1.0, MAX_SUBSTEPS);
        let part = (way / substeps).clamp_length_max(0.5 * body.radius);
        let mut now = from;
        for _ in 0..substeps as usize {
            let mut feet = self.pushed_out(body, now.feet + part);
            if let Some(ground) = self.ground(body, feet)
                && now.grounded
            {
                let rise = ground - feet.dot(self.up);
                // Up and down steps at once; anything deeper is a fall.
                if rise.abs() <= body.step + 1e-9 {
                    feet += self.up * rise;
                }
            }
            if self.fits(body, feet) || !self.fits(body, now.feet) {
                now.feet = feet;
            } else {
                break;
            }
        }
        self.fall(body, now, dt)
    }

    fn fall(&self, body: &Body, mut now: Footing, dt: f64) -> Footing {
        let height = now.feet.dot(self.up);
        let Some(ground) = self.ground(body, now.feet) else {
            return Footing { fall_speed: 0.0, grounded: false, ..now };
        };
        // The mean of the speeds before and after: exact for a constant acceleration.
        let after = now.fall_speed + GRAVITY * body.scale() * dt;
        let drop = 0.5 * (now.fall_speed + after) * dt;
        if height - drop <= ground + 1e-9 {
            now.feet += self.up * (ground - height);
            return Footing { fall_speed: 0.0, grounded: true, ..now };
        }
        now.feet -= self.up * drop;
        Footing { fall_speed: after, grounded: false, ..now }
    }

    /// The highest support under the soles, no higher than a step.
    fn ground(&self, body: &Body, feet: DVec3) -> Option<f64> {
        let reach = 0.4 * body.radius;
        let [right, ahead] = self.level.map(|axis| axis * reach);
        let from = feet + self.up * body.step;
        [DVec3::ZERO, right, -right, ahead, -ahead]
            .into_iter()
            .filter_map(|offset| self.floor_below(from + offset))
            .max_by(f64::total_cmp)
    }

    /// Whether the head stays below what is above the knees.
    fn fits(&self, body: &Body, feet: DVec3) -> bool {
        let knees = feet + self.up * (body.step + 1e-6);
        let top = feet.dot(self.up) + body.eye_height + body.headroom;
        self.ceiling_above(knees).is_none_or(|ceiling| ceiling >= top)
    }

    /// The nearest place, sideways, where the capsule from knees to head touches nothing.
    fn pushed_out(&self, body: &Body, mut feet: DVec3) -> DVec3 {
        let radius = body.radius;
        let low = body.step + radius;
        let high = (body.eye_height + body.headroom - radius).max(low);
        for _ in 0..PUSH_ROUNDS {
            let at = self.flat(feet);
            let mut deepest = (1e-9, DVec3::ZERO);
            self.near(at - DVec2::splat(radius), at + DVec2::splat(radius), |triangle| {
                let (on_axis, on_triangle) =
                    nearest_points(feet + self.up * low, feet + self.up * high, triangle);
                let apart = on_axis - on_triangle;
                let side = apart - self.up * apart.dot(self.up);
                let depth = radius - apart.length();
                // A floor right below or a ceiling right above pushes nowhere sideways.
                if depth > deepest.0 && side.length() > 1e-9 {
                    // Sideways until the distance is the radius again.
                    let height = apart.dot(self.up);
                    let needed = (radius * radius - height * height).max(0.0).sqrt() - side.length();
                    deepest = (depth, side.normalize() * needed);
                }
            });
            if deepest.1 == DVec3::ZERO {
                break;
            }
            feet += deepest.1;
        }
        feet
    }
}

/// The nearest points of a segment and a triangle (Ericson 2005, section 5.1.10, by cases).
fn nearest_points(start: DVec3, end: DVec3, triangle: &[DVec3; 3]) -> (DVec3, DVec3) {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a);
    let (from, to) = ((start - a).dot(normal), (end - a).dot(normal));
    if from * to <= 0.0 && from != to {
        let through = start.lerp(end, from / (from - to));
        if nearest_in_triangle(through, triangle).distance_squared(through) < 1e-18 {
            return (through, through);
        }
    }
    let ends = [start, end].map(|p| (p, nearest_in_triangle(p, triangle)));
    let edges = [(a, b), (b, c), (c, a)].map(|(p, q)| nearest_of_segments(start, end, p, q));
    let square = |pair: &(DVec3, DVec3)| pair.0.distance_squared(pair.1);
    ends.into_iter().chain(edges).min_by(|p, q| square(p).total_cmp(&square(q))).unwrap_or((start, a))
}

/// Ericson 2005, section 5.1.9.
fn nearest_of_segments(p1: DVec3, q1: DVec3, p2: DVec3, q2: DVec3) -> (DVec3, DVec3) {
    let (d1, d2, r) = (q1 - p1, q2 - p2, p1 - p2);
    let (a, e, f) = (d1.length_squared(), d2.length_squared(), d2.dot(r));
    if a < 1e-24 || e < 1e-24 {
        let t = if e < 1e-24 { 0.0 } else { (f / e).clamp(0.0, 1.0) };
        let on2 = p2 + d2 * t;
        let s = if a < 1e-24 { 0.0 } else { (d1.dot(on2 - p1) / a).clamp(0.0, 1.0) };
        return (p1 + d1 * s, on2);
    }
    let (b, c) = (d1.dot(d2), d1.dot(r));
    let denominator = a * e - b * b;
    let s = if denominator > 1e-12 * a * e { ((b * f - c * e) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let t = (b * s + f) / e;
    let (s, t) = if t < 0.0 {
        ((-c / a).clamp(0.0, 1.0), 0.0)
    } else if t > 1.0 {
        (((b - c) / a).clamp(0.0, 1.0), 1.0)
    } else {
        (s, t)
    };
    (p1 + d1 * s, p2 + d2 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: DVec3 = DVec3::Y;

    fn quad(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> [[DVec3; 3]; 2] {
        let [a, b, c, d] = [a, b, c, d].map(DVec3::from);
        [[a, b, c], [a, c, d]]
    }

    fn floor(height: f64, x: [f64; 2], z: [f64; 2]) -> [[DVec3; 3]; 2] {
        quad([x[0], height, z[0]], [x[0], height, z[1]], [x[1], height, z[1]], [x[1], height, z[0]])
    }

    fn wall_at_x(x: f64, y: [f64; 2]) -> [[DVec3; 3]; 2] {
        quad([x, y[0], -10.0], [x, y[0], 10.0], [x, y[1], 10.0], [x, y[1], -10.0])
    }

    fn standing(x: f64, y: f64, z: f64) -> Footing {
        Footing { feet: DVec3::new(x, y, z), fall_speed: 0.0, grounded: true }
    }

    fn person() -> Body {
        Body::for_room(2.6, 1.6)
    }

    #[test]
    fn no_speed_carries_through_a_wall_and_the_rest_slides_along_it() {
        let world = [floor(0.0, [-10.0, 10.0], [-10.0, 10.0]), wall_at_x(2.0, [0.0, 3.0])].concat();
        let world = Obstacles::new(world, UP);
        for speed in [0.01, 0.5, 5.0, 30.0] {
            let mut now = standing(0.0, 0.0, 0.0);
            for _ in 0..(6.0 / speed) as usize + 2 {
                now = world.walk(&person(), now, DVec3::new(speed, 0.0, 0.1 * speed), 0.016);
            }
            assert!((now.feet.x - (2.0 - person().radius)).abs() < 1e-6, "{speed}: {}", now.feet);
            assert!(now.feet.z > 0.3, "slides: {}", now.feet);
        }
    }

    #[test]
    fn a_corner_holds() {
        let world = [
            floor(0.0, [-10.0, 10.0], [-10.0, 10.0]),
            wall_at_x(2.0, [0.0, 3.0]),
            quad([-10.0, 0.0, 3.0], [10.0, 0.0, 3.0], [10.0, 3.0, 3.0], [-10.0, 3.0, 3.0]),
        ]
        .concat();
        let world = Obstacles::new(world, UP);
        let mut now = standing(0.0, 0.0, 0.0);
        for _ in 0..100 {
            now = world.walk(&person(), now, DVec3::new(0.09, 0.0, 0.11), 0.016);
        }
        let radius = person().radius;
        assert!((now.feet.x - (2.0 - radius)).abs() < 1e-3 && (now.feet.z - (3.0 - radius)).abs() < 1e-3);
    }

    #[test]
    fn a_stair_is_climbed_step_by_step_and_a_high_ledge_is_not() {
        let mut steps = floor(0.0, [-5.0, 1.0], [-2.0, 2.0]).to_vec();
        for k in 0..8 {
            let (x, low, high) = (1.0 + 0.28 * f64::from(k), 0.18 * f64::from(k), 0.18 * f64::from(k + 1));
            steps.extend(quad([x, low, -2.0], [x, low, 2.0], [x, high, 2.0], [x, high, -2.0]));
            steps.extend(floor(high, [x, if k == 7 { 9.0 } else { x + 0.28 }], [-2.0, 2.0]));
        }
        let stair = Obstacles::new(steps, UP);
        let mut now = standing(0.0, 0.0, 0.0);
        for _ in 0..200 {
            now = stair.walk(&person(), now, DVec3::new(0.025, 0.0, 0.0), 0.016);
        }
        assert!((now.feet.y - 8.0 * 0.18).abs() < 1e-9 && now.feet.x > 4.5, "{}", now.feet);
        for _ in 0..200 {
            now = stair.walk(&person(), now, DVec3::new(-0.025, 0.0, 0.0), 0.016);
        }
        assert!(now.feet.y.abs() < 1e-9 && now.feet.x < 1.0, "and down again: {}", now.feet);

        let ledge = [
            floor(0.0, [-5.0, 1.0], [-2.0, 2.0]).to_vec(),
            wall_at_x(1.0, [0.0, 0.6]).to_vec(),
            floor(0.6, [1.0, 5.0], [-2.0, 2.0]).to_vec(),
        ]
        .concat();
        let ledge = Obstacles::new(ledge, UP);
        let mut now = standing(0.0, 0.0, 0.0);
        for _ in 0..200 {
            now = ledge.walk(&person(), now, DVec3::new(0.025, 0.0, 0.0), 0.016);
        }
        assert!(now.feet.x < 1.0 && now.feet.y == 0.0, "{}", now.feet);
    }

    #[test]
    fn a_thin_table_top_and_a_low_beam_stop_the_walk() {
        let ground = floor(0.0, [-5.0, 5.0], [-2.0, 2.0]).to_vec();
        for height in [0.74, 1.2, 1.55] {
            let world = [ground.clone(), floor(height, [1.0, 2.0], [-2.0, 2.0]).to_vec()].concat();
            let world = Obstacles::new(world, UP);
            let mut now = standing(0.0, 0.0, 0.0);
            for _ in 0..100 {
                now = world.walk(&person(), now, DVec3::new(0.03, 0.0, 0.0), 0.016);
            }
            assert!(now.feet.x < 1.01, "at {height}: {}", now.feet);
        }
    }

    #[test]
    fn the_fall_follows_gravity_and_ends_on_the_floor() {
        let world = Obstacles::new(floor(0.0, [-5.0, 5.0], [-5.0, 5.0]).to_vec(), UP);
        let mut now = Footing { feet: DVec3::new(0.0, 2.0, 0.0), fall_speed: 0.0, grounded: false };
        for _ in 0..30 {
            now = world.walk(&person(), now, DVec3::ZERO, 0.01);
        }
        let expected = 2.0 - 0.5 * GRAVITY * 0.3 * 0.3;
        assert!((now.feet.y - expected).abs() < 1e-9, "{} against {expected}", now.feet.y);
        for _ in 0..60 {
            now = world.walk(&person(), now, DVec3::ZERO, 0.01);
        }
        assert_eq!(now, standing(0.0, 0.0, 0.0));
    }

    #[test]
    fn without_a_floor_the_person_stays_level() {
        let world = Obstacles::new(Vec::new(), UP);
        let start = standing(0.0, 1.0, 0.0);
        let now = world.walk(&person(), start, DVec3::X, 0.1);
        assert!(now.feet.distance(DVec3::new(1.0, 1.0, 0.0)) < 1e-12, "{}", now.feet);
    }

    #[test]
    fn nearest_points_agree_with_a_fine_search() {
        let triangle = [DVec3::new(0.0, 0.0, 0.0), DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.1, 0.9, 0.4)];
        for k in 0..40 {
            let angle = f64::from(k) * 0.7;
            let start = DVec3::new(2.0 * angle.cos(), angle.sin() * 1.5, (angle * 1.3).sin());
            let end = start + DVec3::new(0.3, -0.5 * angle.cos(), 0.8);
            let (p, q) = nearest_points(start, end, &triangle);
            let mut brute = f64::INFINITY;
            for i in 0..=60 {
                let on = start.lerp(end, f64::from(i) / 60.0);
                for u in 0..=60 {
                    for v in 0..=(60 - u) {
                        let (u, v) = (f64::from(u) / 60.0, f64::from(v) / 60.0);
                        let on_triangle =
                            triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
                        brute = brute.min(on.distance(on_triangle));
                    }
                }
            }
            let found = p.distance(q);
            assert!(found <= brute + 1e-9 && found > brute - 0.03, "{k}: {found} against {brute}");
        }
    }
}
