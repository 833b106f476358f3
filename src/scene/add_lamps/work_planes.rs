//! Work planes: level grids of points over the floors of rooms.

use super::is_in_a_room;
use super::plan::{Kind, Plan};
use super::rooms::{self, Room};
use crate::geometry::Ray;
use crate::scene::Scene;
use glam::{DVec2, DVec3};
use std::collections::HashSet;
use std::f64::consts::TAU;

/// Height above the floor that work planes usually have, metres.
pub const USUAL_WORK_PLANE: f64 = 0.8;
/// So far from the walls no point is evaluated, metres; in narrow rooms a quarter of the width.
const BORDER: f64 = 0.5;
const NARROW: f64 = 0.25;
/// Grid points are no farther apart, metres (EN 12464-1:2021).
const WIDEST: f64 = 10.0;
/// From this ratio of its sides on, the spacing follows the shorter side of a plane.
const LONG: f64 = 2.0;
/// What is this much lower than the ceiling and this much higher than the floor is the niche of a window, metres.
const LINTEL: f64 = 0.15;
const SILL: f64 = 0.1;
/// A wall is looked for so far below the ceiling, metres: above most furniture.
const BELOW_CEILING: f64 = 0.25;
/// A room has walls along this share of its outline at least.
const WALLED: f64 = 0.6;
/// Directions in which a point has to keep its distance from walls.
const AROUND: usize = 8;

/// A level grid of points in a room.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkPlane {
    /// `Room 1`, `Room 2`, ...: from the lowest storey up, on each from the largest room down.
    pub name: String,
    /// Length and width of the rectangle around the room along the level axes of the model, metres.
    pub size: [f64; 2],
    /// Height of the plane above the floor, metres.
    pub height: f64,
    /// Distances between neighbouring points along both axes, metres.
    pub spacing: [f64; 2],
    /// Points of the grid, metres; those inside furniture, in walls and too near to walls are left out.
    pub points: Vec<DVec3>,
}

/// Work planes in all rooms of a scene, `height` metres above their floors; rooms in which no point is left have none.
///
/// A room has a floor, a ceiling and walls; a solid block that stands on the ground has them as well, and is known by the
/// dark inside. The grid is that of EN 12464-1:2021 (p = 0.2 * 5^log10(d), with d the longer
/// side of the plane in metres, or the shorter one if the longer is twice as long or more), its points in the middles of
/// the cells; within half a metre of the walls there are none.
pub fn work_planes(scene: &Scene, height: f64) -> Vec<WorkPlane> {
    let Some(plan) = Plan::of(scene) else { return Vec::new() };
    let mut found = of_kind(&plan, Kind::Roofed, height);
    if found.is_empty() {
        // A room whose faces were drawn from outside looks like the inside of a solid body.
        found = of_kind(&plan, Kind::InsideOut, height);
    }
    found.sort_by(|(a, _), (b, _)| {
        let storey = |room: &Room| (room.floor / (0.5 * plan.scale)).round();
        storey(a).total_cmp(&storey(b)).then(b.area.total_cmp(&a.area))
    });
    let named = |(k, (_, plane))| WorkPlane { name: format!("Room {}", k + 1), ..plane };
    found.into_iter().enumerate().map(named).collect()
}

fn of_kind(plan: &Plan, kind: Kind, height: f64) -> Vec<(Room, WorkPlane)> {
    let rooms = rooms::find(plan, kind).into_iter().filter(|room| has_walls(plan, room));
    rooms.filter_map(|room| plane(plan, &room, height).map(|plane| (room, plane))).collect()
}

/// Whether walls stand around a room, seen from its middle and along its outline: below an overhang there are none.
fn has_walls(plan: &Plan, room: &Room) -> bool {
    let [mut outline, mut walled] = [0, 0];
    for &k in &room.spaces {
        let space = &plan.spaces[k as usize];
        let (place, height) = (plan.level(space.cell as usize), space.ceiling - space.floor);
        for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let mut next = place;
            next[axis] += sign * plan.cell;
            let next = plan.cell_at(next).map(|cell| cell as u32);
            if plan.links[k as usize].iter().any(|&other| Some(plan.spaces[other as usize].cell) == next) {
                continue;
            }
            outline += 1;
            let direction = plan.axes[axis] * (sign * 1.5 * plan.cell);
            // Beside an opening there is wall above it, or below.
            walled += usize::from([0.1, 0.5, 0.9].into_iter().any(|share| {
                let origin = plan.point(place, space.floor + share * height);
                plan.bvh.occluded(&Ray { origin, direction }, 0.0, 1.0)
            }));
        }
    }
    if (walled as f64) < WALLED * outline as f64 {
        return false;
    }
    let middle = (0..room.spaces.len()).rev().max_by(|&a, &b| room.depths[a].total_cmp(&room.depths[b]));
    middle.is_some_and(|k| {
        let space = &plan.spaces[room.spaces[k] as usize];
        let height = space.ceiling - space.floor;
        is_in_a_room(plan, plan.at(space.cell as usize, space.floor + (0.7 * height).min(1.5 * plan.scale)))
    })
}

/// How many points a plane of these sides has along each, by EN 12464-1.
fn counts(sides: DVec2) -> [usize; 2] {
    let (long, short) = (sides.max_element(), sides.min_element());
    let relevant = if long >= LONG * short { short } else { long };
    let widest = (0.2 * 5.0_f64.powf(relevant.log10())).min(WIDEST);
    // What is a whole number up to rounding is that number.
    let spacing = relevant / (relevant / widest - 1e-9).ceil().max(1.0);
    [sides.x, sides.y].map(|side| ((side / spacing).round() as usize).max(1))
}

fn plane(plan: &Plan, room: &Room, height: f64) -> Option<WorkPlane> {
    let [low, high] = rectangle(plan, room)?;
    let size = high - low;
    let border = (BORDER * plan.scale).min(NARROW * size.min_element());
    let (first, sides) = (low + border, size - 2.0 * border);
    let counts = counts(sides);
    let step = sides / DVec2::new(counts[0] as f64, counts[1] as f64);
    let at = |k: usize| DVec2::new((k % counts[0]) as f64 + 0.5, (k / counts[0]) as f64 + 0.5);
    let level = room.floor + height;
    let floor = Floor::new(plan, room, level);
    let points = (0..counts[0] * counts[1])
        .map(|k| first + step * at(k))
        .filter(|&place| floor.is_free(place, border))
        .map(|place| plan.point(place, level))
        .collect::<Vec<_>>();
    let plane = WorkPlane { name: String::new(), size: size.into(), height, spacing: step.into(), points };
    (!plane.points.is_empty()).then_some(plane)
}

/// Where a room reaches to, level coordinates: as far as its walls, without the niches of windows.
fn rectangle(plan: &Plan, room: &Room) -> Option<[DVec2; 2]> {
    let is_niche = |space: &super::plan::Space| {
        space.ceiling < room.ceiling - LINTEL * plan.scale && space.floor > room.floor + SILL * plan.scale
    };
    let spaces: Vec<_> =
        room.spaces.iter().map(|&k| &plan.spaces[k as usize]).filter(|s| !is_niche(s)).collect();
    let places: Vec<DVec2> = spaces.iter().map(|space| plan.level(space.cell as usize)).collect();
    let first = *places.first()?;
    let ends = [
        places.iter().fold(first, |low, place| low.min(*place)),
        places.iter().fold(first, |high, place| high.max(*place)),
    ];
    // The wall that is seen from most of the last row of columns.
    let wall = |axis: usize, end: usize| {
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let row = spaces
            .iter()
            .zip(&places)
            .filter(|(_, place)| (place[axis] - ends[end][axis]).abs() < 0.5 * plan.cell);
        let mut seen: Vec<f64> = row
            .filter_map(|(space, place)| {
                let below = (BELOW_CEILING * plan.scale).min(0.2 * (space.ceiling - space.floor));
                let origin = plan.point(*place, space.ceiling - below);
                let hit = plan.bvh.nearest(
                    &Ray { origin, direction: plan.axes[axis] * sign },
                    0.0,
                    f64::INFINITY,
                )?;
                Some(hit.distance)
            })
            .collect();
        seen.sort_by(f64::total_cmp);
        // Beyond the next column it is no wall of this room.
        let distance = seen.get(seen.len() / 2).copied().filter(|&distance| distance < 1.5 * plan.cell);
        ends[end][axis] + sign * distance.unwrap_or(0.5 * plan.cell)
    };
    let [low, high] = [0, 1].map(|end| DVec2::new(wall(0, end), wall(1, end)));
    (low.x < high.x && low.y < high.y).then_some([low, high])
}

/// Where points may be in a room at some height.
struct Floor<'a> {
    plan: &'a Plan,
    room: &'a Room,
    level: f64,
    /// Columns in which the room has a space.
    cells: HashSet<u32>,
    /// Those in which it has one at this height.
    at_level: HashSet<u32>,
}

impl<'a> Floor<'a> {
    fn new(plan: &'a Plan, room: &'a Room, level: f64) -> Self {
        let spaces = || room.spaces.iter().map(|&k| &plan.spaces[k as usize]);
        let at_level = spaces().filter(|s| s.floor < level && level < s.ceiling).map(|s| s.cell).collect();
        Self { plan, room, level, cells: spaces().map(|s| s.cell).collect(), at_level }
    }

    /// Whether a point is in the free space of the room, at least the border away from where that ends.
    fn is_free(&self, place: DVec2, border: f64) -> bool {
        let has =
            |cells: &HashSet<u32>, at| self.plan.cell_at(at).filter(|&cell| cells.contains(&(cell as u32)));
        let Some(cell) = has(&self.at_level, place) else { return false };
        // Columns know walls to half of their width.
        let away = (border - 0.5 * self.plan.cell).max(0.0);
        let keeps_away = (0..AROUND).all(|k| {
            let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
            has(&self.cells, place + away * DVec2::new(cos, sin)).is_some()
        });
        // A piece of furniture may end within the column.
        let kind = self.plan.spaces[self.room.spaces[0] as usize].kind;
        keeps_away
            && self
                .plan
                .column(cell, place)
                .iter()
                .any(|space| space.kind == kind && space.floor < self.level && self.level < space.ceiling)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_text;
    use std::fmt::Write as _;

    /// Boxes as OBJ with z up: those that are rooms face inwards.
    fn boxes(all: &[([f64; 6], bool)]) -> String {
        let mut obj = String::new();
        for (k, ([x0, x1, y0, y1, z0, z1], inwards)) in all.iter().enumerate() {
            for [x, y, z] in [
                [x0, y0, z0],
                [x1, y0, z0],
                [x1, y1, z0],
                [x0, y1, z0],
                [x0, y0, z1],
                [x1, y0, z1],
                [x1, y1, z1],
                [x0, y1, z1],
            ] {
                writeln!(obj, "v {x} {y} {z}").expect("a string");
            }
            for mut face in
                [[1, 2, 3, 4], [8, 7, 6, 5], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 8, 4], [4, 8, 5, 1]]
            {
                if !inwards {
                    face.reverse();
                }
                let [a, b, c, d] = face.map(|corner| corner + 8 * k);
                writeln!(obj, "f {a} {b} {c} {d}").expect("a string");
            }
        }
        obj
    }

    fn planes(all: &[([f64; 6], bool)], height: f64) -> Vec<WorkPlane> {
        let scene = from_text("t", &boxes(all), "", Some("up = \"z\"")).expect("a scene");
        let mut planes = work_planes(&scene, height);
        // In the coordinates of the file.
        planes.iter_mut().flat_map(|plane| &mut plane.points).for_each(|p| *p = scene.in_file(*p));
        planes
    }

    const ROOM: ([f64; 6], bool) = ([0.07, 6.07, 0.0, 4.0, 0.0, 3.0], true);

    #[test]
    fn a_room_of_6_by_4_metres_has_9_by_5_points() {
        // 5 x 3 m without the border: p = 0.2 * 5^log10(5) = 0.616 m, so 9 points 0.556 m apart and 5 across.
        let [plane] = &planes(&[ROOM], 0.8)[..] else { panic!("one room") };
        assert_eq!((plane.name.as_str(), plane.points.len()), ("Room 1", 45));
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        assert!(near(plane.size[0], 6.0) && near(plane.size[1], 4.0), "{:?}", plane.size);
        assert!(near(plane.spacing[0], 5.0 / 9.0) && near(plane.spacing[1], 0.6), "{:?}", plane.spacing);
        assert!(plane.points.iter().all(|p| near(p.z, 0.8)));
        let first = plane.points[0];
        assert!(near(first.x, 0.07 + 0.5 + 2.5 / 9.0) && near(first.y, 0.8), "{first}");
    }

    #[test]
    fn spacings_are_those_of_the_standard() {
        // Longer side 10 m: 1 m apart. A corridor of 20 x 2 m: by its width, p = 0.325 m, so 7 across and 70 along.
        assert_eq!(counts(DVec2::new(10.0, 6.0)), [10, 6]);
        assert_eq!(counts(DVec2::new(20.0, 2.0)), [70, 7]);
    }

    #[test]
    fn points_in_furniture_are_left_out_and_those_over_a_table_stay() {
        let cupboard = ([3.2, 4.0, 0.0, 4.0, 0.0, 2.0], false);
        let table = ([1.0, 2.5, 1.0, 3.0, 0.0, 0.75], false);
        let [plane] = &planes(&[ROOM, cupboard, table], 0.8)[..] else { panic!("one room") };
        assert!(!plane.points.iter().any(|p| (3.2..4.0).contains(&p.x)), "{:?}", plane.points);
        let over = |p: &&DVec3| (1.0..2.5).contains(&p.x) && (1.0..3.0).contains(&p.y);
        assert_eq!(plane.points.iter().filter(over).count(), 6);
        assert_eq!(plane.points.len(), 40);
    }

    #[test]
    fn below_an_overhang_is_no_room() {
        let ground = ([-5.0, 11.0, -9.0, 9.0, -0.4, -0.1], false);
        let overhang = ([-0.1, 6.2, -1.5, -0.1, 2.7, 2.9], false);
        let garden_wall = ([-5.0, 11.0, -8.0, -7.9, -0.1, 9.0], false);
        let found = planes(&[ROOM, ground, overhang, garden_wall], 0.8);
        assert_eq!(found.iter().map(|plane| plane.points.len()).collect::<Vec<_>>(), [45]);
    }

    #[test]
    fn storeys_have_planes_of_their_own_and_a_solid_block_has_none() {
        let above = ([0.0, 5.0, 0.0, 4.0, 3.3, 6.0], true);
        let block = ([10.0, 16.0, 0.0, 5.0, 0.0, 9.0], false);
        let found = planes(&[above, ROOM, block], 0.85);
        let heights: Vec<f64> = found.iter().map(|plane| plane.points[0].z).collect();
        assert_eq!(found.len(), 2, "{heights:?}");
        assert!((heights[0] - 0.85).abs() < 1e-6 && (heights[1] - 4.15).abs() < 1e-6, "{heights:?}");
        assert!(planes(&[ROOM], 3.1).is_empty(), "above the ceiling there is no room");
    }
}
