//! Lamps for a model that has none: one below the ceiling of each room, several in a large one; where there
//! is no ceiling, hanging over the largest floor. Work planes are laid out in the same rooms.

mod plan;
mod rooms;
mod work_planes;

pub use work_planes::{USUAL_WORK_PLANE, WorkPlane, work_planes};

use super::placed::{LampColour, LampKind, PlacedLamp, SINGLE};
use super::types::Scene;
use crate::geometry::Ray;
use glam::{DVec2, DVec3};
use plan::{Kind, Plan};
use rooms::Room;
use std::collections::HashSet;
use std::f64::consts::PI;

/// Mean illuminance aimed at on the floor, lux: that of a room one lives in rather than works in.
const ILLUMINANCE: f64 = 250.0;
/// Share of a lamp's light that arrives on the floor, reflections counted (a usual utilisation factor).
const UTILISATION: f64 = 0.6;
/// Floor area for which there is one lamp, m², in rooms of usual height.
const AREA_PER_LAMP: f64 = 16.0;
/// In higher ones lamps are so many times their height above the floor apart, as is usual.
const SPACING: f64 = 1.3;
/// The most lamps in one room, and in the whole model.
const MOST_PER_ROOM: usize = 36;
const MOST_LAMPS: usize = 120;
/// Edge of a panel, metres.
const PANEL: f64 = 0.6;
/// Gap between the panel and the ceiling, metres.
const GAP: f64 = 0.025;
/// Height of a lamp over a floor without a ceiling, metres.
const HANGING: f64 = 2.7;
/// Colour temperature, kelvin.
const KELVIN: f64 = 3000.0;
/// A place is in a room if this share of the horizontal directions ends at a wall.
const ENCLOSED: f64 = 0.5;
/// Least width of a room, metres.
const WIDTH: f64 = 0.85;
/// A court gets lamps if its floor is more than this share of the largest room's.
const COURT: f64 = 0.25;
/// Places tried for one lamp before it is left out.
const TRIES: usize = 40;

/// Ceiling lamps for the rooms of a scene, in metres, in a stable order; empty where there is no floor to
/// hang one over. Names differ from those of the scene's luminaires and objects.
///
/// Rooms are found on a grid of columns: free height above a floor, joined to neighbours that no wall divides
/// near the ceiling, split at narrow passages. A place without walls around it (a roof, a terrain) is no room.
pub fn ceiling_lamps(scene: &Scene) -> Vec<PlacedLamp> {
    let Some(plan) = Plan::of(scene) else { return Vec::new() };
    let mut places = lamps_in(&plan, Kind::Roofed);
    if places.is_empty() {
        // A room whose faces were drawn from outside looks like the inside of a solid body.
        places = lamps_in(&plan, Kind::InsideOut);
    }
    // A court that is large beside the rooms gets its own lamps.
    let court = lamps_in(&plan, Kind::Open).into_iter().max_by(|a, b| a.area.total_cmp(&b.area));
    let largest = places.iter().map(|room| room.area).fold(0.0, f64::max);
    places.extend(court.filter(|court| court.area > COURT * largest));
    if places.is_empty() {
        places.extend(over_the_largest_floor(&plan));
    }
    places.sort_by(|a, b| {
        let key = |lit: &Lit| (lit.floor / (0.5 * plan.scale)).round();
        key(a).total_cmp(&key(b)).then(b.area.total_cmp(&a.area)).then(order(&a.at[0], &b.at[0]))
    });
    named(scene, places)
}

fn order(a: &(DVec3, f64), b: &(DVec3, f64)) -> std::cmp::Ordering {
    let [a, b] = [a.0, b.0];
    a.x.total_cmp(&b.x).then(a.z.total_cmp(&b.z)).then(a.y.total_cmp(&b.y))
}

/// The lamps of one room.
struct Lit {
    /// Height of the floor along the up axis, metres.
    floor: f64,
    /// m².
    area: f64,
    hangs: bool,
    /// Where the middle of each panel is, and its edge, metres.
    at: Vec<(DVec3, f64)>,
}

/// Lamps for all rooms of a kind.
fn lamps_in(plan: &Plan, kind: Kind) -> Vec<Lit> {
    let rooms = rooms::find(plan, kind);
    rooms.iter().filter_map(|room| lit(plan, room, true)).collect()
}

/// Lamps over the largest level floor under the open sky, whatever is around it.
fn over_the_largest_floor(plan: &Plan) -> Option<Lit> {
    let mut rooms = rooms::find(plan, Kind::Open);
    rooms.sort_by(|a, b| b.area.total_cmp(&a.area));
    rooms.iter().find_map(|room| lit(plan, room, false))
}

/// The lamps of a room; `None` where no place for one was found, or where it is no room.
fn lit(plan: &Plan, room: &Room, must_be_room: bool) -> Option<Lit> {
    let height = if room.ceiling.is_finite() { room.ceiling - room.floor } else { HANGING * plan.scale };
    let share = (AREA_PER_LAMP * plan.scale * plan.scale).max((SPACING * height).powi(2));
    let wanted = (room.area / share).ceil();
    let wanted = (wanted as usize).clamp(1, MOST_PER_ROOM);
    let mut at: Vec<(DVec3, f64)> = Vec::new();
    for target in room.targets(plan, wanted) {
        let spaces: Vec<usize> = room.nearest(plan, target).take(TRIES).collect();
        // A small panel in the shaft of a skylight is worse than a usual one beside it.
        let place = [PANEL, 0.5 * PANEL].into_iter().find_map(|edge| {
            spaces.iter().find_map(|&space| {
                // Rows are even where nothing is in the way.
                let near = plan.level(plan.spaces[space].cell as usize);
                let exact = near.distance(target) < plan.cell;
                let at_target = exact.then(|| panel(plan, space, target, edge)).flatten();
                at_target.or_else(|| panel(plan, space, near, edge))
            })
        });
        let place =
            place.filter(|(middle, edge)| at.iter().all(|(other, _)| other.distance(*middle) > *edge));
        at.extend(place);
    }
    let first = at.first()?;
    // Fences make no room of a garden.
    let height = first.0.dot(plan.up) - room.floor;
    let eyes = match room.ceiling.is_finite() {
        true => (0.7 * height).min(1.5 * plan.scale),
        false => 0.85 * height,
    };
    if must_be_room && !is_in_a_room(plan, first.0 - plan.up * (height - eyes)) {
        return None;
    }
    Some(Lit { floor: room.floor, area: room.area, hangs: room.ceiling.is_infinite(), at })
}

/// The middle and the edge of a panel at the top of a space, at these level coordinates in it or beside it;
/// `None` where something is in its way. `edge` is that of a panel in a building.
fn panel(plan: &Plan, space: usize, at: DVec2, edge: f64) -> Option<(DVec3, f64)> {
    let space = &plan.spaces[space];
    let scale = plan.scale;
    let half = 0.5 * edge * scale;
    let [a, b] = plan.axes;
    let corners = [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let corners = corners.map(|(i, j)| a * (i * half) + b * (j * half));
    let is_roofed = space.ceiling.is_finite();
    let below = space.floor + 0.6 * plan.headroom;
    let mut height = if is_roofed { space.ceiling - GAP * scale } else { space.floor + HANGING * scale };
    // What is above each corner, as seen from where people are.
    for corner in corners {
        let origin = plan.point(at, below) + corner;
        let above = plan.bvh.nearest(&Ray { origin, direction: plan.up }, 0.0, f64::INFINITY);
        let above = above.map_or(f64::INFINITY, |hit| below + hit.distance);
        if is_roofed {
            // More than a step below the ceiling is no ceiling.
            if above < space.ceiling - 0.3 * scale || above.is_infinite() {
                return None;
            }
            height = height.min(above - GAP * scale);
        } else if above < height {
            return None;
        }
    }
    let middle = plan.point(at, height);
    let is_free = corners[1..].iter().all(|&corner| {
        [0.0, 2.0 * GAP * scale].into_iter().all(|lower| {
            let ray = Ray { origin: middle - plan.up * lower, direction: corner * 1.2 };
            !plan.bvh.occluded(&ray, 0.0, 1.0)
        })
    });
    is_free.then_some((middle, 2.0 * half))
}

/// Whether walls stand around a place, and leave room for a person: between the leaves of a wall hangs no lamp.
fn is_in_a_room(plan: &Plan, eyes: DVec3) -> bool {
    const HALF: usize = 12;
    let [a, b] = plan.axes;
    let to_wall = |k: usize| {
        let (sin, cos) = (PI * (k as f64 + 0.3) / HALF as f64).sin_cos();
        let ray = Ray { origin: eyes, direction: a * cos + b * sin };
        plan.bvh.nearest(&ray, 0.0, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance)
    };
    let distances: Vec<f64> = (0..2 * HALF).map(to_wall).collect();
    let walls = distances.iter().filter(|distance| distance.is_finite()).count();
    let narrowest = (0..HALF).map(|k| distances[k] + distances[k + HALF]).fold(f64::INFINITY, f64::min);
    walls as f64 >= ENCLOSED * (2 * HALF) as f64 && narrowest >= WIDTH * plan.scale
}

/// Lumens with two digits that matter.
fn rounded(lumens: f64) -> f64 {
    let step = 10_f64.powf(lumens.max(1e-6).log10().floor() - 1.0);
    (lumens / step).round() * step
}

fn named(scene: &Scene, rooms: Vec<Lit>) -> Vec<PlacedLamp> {
    let mut taken: HashSet<String> = scene.luminaires.iter().map(|lamp| lamp.name.clone()).collect();
    taken.extend(scene.objects.iter().cloned());
    let mut lamps: Vec<PlacedLamp> = Vec::new();
    let mut number = 0;
    let count: usize = rooms.iter().map(|room| room.at.len()).sum();
    for room in rooms {
        let lumens = rounded(ILLUMINANCE * room.area / UTILISATION / room.at.len() as f64);
        for (middle, edge) in room.at {
            if lamps.len() == MOST_LAMPS {
                return lamps;
            }
            let kind = if room.hangs { "Hanging lamp" } else { "Ceiling lamp" };
            let mut name = kind.to_owned();
            while count > 1 && number == lamps.len() || taken.contains(&name) {
                number += 1;
                name = format!("{kind} {number}");
            }
            taken.insert(name.clone());
            lamps.push(PlacedLamp {
                name,
                kind: LampKind::Panel,
                position: middle,
                aim: -scene.up.vector(),
                size: [edge, edge],
                lumens,
                colour: LampColour::Kelvin(KELVIN),
                on: true,
                dimmer: 1.0,
                photometric: None,
                array: SINGLE,
                spacing: [0.0; 2],
                cone: None,
            });
        }
    }
    lamps
}
