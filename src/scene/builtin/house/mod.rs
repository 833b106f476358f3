//! An evening in a small house: seven rooms around a sunken living room, and a terrace.
//!
//! Plan, x to the east, z to the south, metres; the living room lies 0.36 lower than the rest.
//!
//! ```text
//!      0          3.2 3.32       6.92 7.04    9.24 9.36     11.6
//!    0 +-----------+ +------------+ +----------+ +-----------+
//!      |  study    | |  bedroom   | | bathroom | | entrance  |
//!      |           | |            | |          | | hall      |
//!  3.2 +------d----+ +--d---------+ +--d-------+ |           |
//! 3.32 |  gallery                                =           |
//!  4.4 |- - - - - - - - - - -         +----------+-----------+
//!  4.6 +----------------+                      +-------------+
//!      |  living room    steps    dining       =  kitchen    |
//!      |  (sunken)      |         room         |             |
//!  8.4 +----------------+----------------------+-------------+
//!      0               5.2                 8.48 8.6         11.6
//! ```

mod bath;
mod bedroom;
mod entrance;
mod furniture;
mod kitchen;
mod lamps;
mod living;
mod palette;
mod shell;
mod study;
mod terrace;
mod textiles;

use super::writer::Model;
use glam::{DVec3, dvec3};
use palette::{
    BATH_TILE, CLAY, DUSK_BLUE, JOINERY, OAK_FLOOR, PINE_GREEN, PLASTER, SAGE, SLATE_FLOOR, STONE_FLOOR,
    TERRACOTTA, WALNUT,
};
use shell::{Across, HEIGHT, Opening, Room};

/// Level of the sunken living room's floor, metres; two risers of 0.18 m lead down.
pub(crate) const PIT: f64 = -0.36;
/// East and north edge of the sunken floor, metres.
pub(crate) const PIT_EAST: f64 = 5.2;
pub(crate) const PIT_NORTH: f64 = 4.6;
/// Where the steps run along the pit's east edge (z from, z to), and the depth of their tread.
const STEPS: [f64; 2] = [5.3, 6.9];
const TREAD: f64 = 0.32;
/// South face of the outer wall's inside, metres.
const SOUTH: f64 = 8.4;
/// Thickness of the outer walls, metres.
const OUTER: f64 = 0.3;

pub(crate) fn model() -> Model {
    let mut m = Model::new(("m", 1.0), 0.18);
    views(&mut m);
    let south = shell(&mut m);
    living::living_room(&mut m);
    living::gallery(&mut m);
    kitchen::dining_room(&mut m);
    kitchen::kitchen(&mut m);
    entrance::hall(&mut m);
    bedroom::bedroom(&mut m);
    study::study(&mut m);
    bath::bathroom(&mut m);
    terrace::terrace(&mut m, &south);
    m
}

fn views(m: &mut Model) {
    m.view("Living room", [5.0, 1.5, 3.75], [1.9, 0.05, 7.6], 62.0);
    m.view("Gallery", [8.35, 1.6, 4.05], [1.5, 0.75, 5.0], 62.0);
    m.view("Entrance", [9.85, 1.6, 0.25], [10.5, 1.0, 3.6], 70.0);
    m.view("Dining table", [5.35, 1.55, 3.6], [7.3, 0.75, 7.0], 62.0);
    m.view("Kitchen", [8.3, 1.6, 5.55], [11.3, 1.05, 7.05], 62.0);
    m.view("Bedroom", [3.98, 1.55, 3.08], [6.3, 0.65, 1.1], 64.0);
    m.view("Bathroom", [7.7, 1.6, 3.08], [8.3, 0.85, 0.5], 72.0);
    m.view("Study", [2.4, 1.6, 3.08], [0.9, 0.8, 0.5], 66.0);
    m.view("Across the house", [0.42, 1.45, 7.2], [7.0, 0.6, 5.0], 60.0);
    m.view("Terrace", [7.9, 1.6, 10.6], [3.2, 1.0, 7.4], 64.0);
}

/// Builds rooms, openings and levels; returns the windows of the south wall between the terrace's ends
/// as x from, x to, sill and head.
fn shell(m: &mut Model) -> Vec<[f64; 4]> {
    let inner = |across, along, through, head, floor| Opening::door(across, along, through, head, floor);
    let doors = [
        inner(Across::Z, [2.1, 2.9], [3.2, 3.32], 2.05, &OAK_FLOOR),
        inner(Across::Z, [3.6, 4.4], [3.2, 3.32], 2.05, &OAK_FLOOR),
        inner(Across::Z, [7.3, 8.1], [3.2, 3.32], 2.05, &SLATE_FLOOR),
        inner(Across::X, [3.45, 4.3], [9.24, 9.36], 2.2, &STONE_FLOOR),
        inner(Across::X, [5.2, 7.4], [8.48, 8.6], 2.25, &STONE_FLOOR),
    ];
    let windows = [
        (Opening::window(Across::Z, [0.8, 4.4], SOUTH, SOUTH + OUTER, [0.05, 2.25]), 4, None),
        (Opening::window(Across::Z, [5.9, 7.7], SOUTH, SOUTH + OUTER, [0.05, 2.25]), 2, Some(1.75)),
        (Opening::window(Across::Z, [9.3, 10.9], SOUTH, SOUTH + OUTER, [1.2, 2.1]), 2, None),
        (Opening::window(Across::Z, [4.2, 6.0], 0.0, -OUTER, [0.9, 2.2]), 3, None),
        (Opening::window(Across::X, [0.7, 2.1], 0.0, -OUTER, [0.95, 2.2]), 2, Some(1.8)),
        (Opening::window(Across::Z, [7.6, 8.4], 0.0, -OUTER, [1.45, 2.1]), 1, None),
        (Opening::window(Across::Z, [11.0, 11.3], 0.0, -OUTER, [0.3, 2.05]), 1, None),
    ];
    // The gallery runs on to the entrance: no wall there.
    let join = inner(Across::X, [3.32, 4.4], [8.48, 8.48], HEIGHT, &OAK_FLOOR);
    let mut openings = doors.to_vec();
    openings.extend(windows.iter().map(|w| w.0));
    for opening in &openings {
        opening.reveal(m);
    }
    for (window, panes, transom) in &windows {
        window.frame(m, *panes, *transom);
    }
    openings.push(join);

    let plain = [&PLASTER; 4];
    let rooms = [
        Room {
            name: "study",
            x: [0.0, 3.2],
            z: [0.0, 3.2],
            walls: [&PLASTER, &PLASTER, &PINE_GREEN, &PLASTER],
            floor: Some(&OAK_FLOOR),
        },
        Room {
            name: "bedroom",
            x: [3.32, 6.92],
            z: [0.0, 3.2],
            walls: [&PLASTER, &DUSK_BLUE, &PLASTER, &PLASTER],
            floor: Some(&OAK_FLOOR),
        },
        Room {
            name: "bathroom",
            x: [7.04, 9.24],
            z: [0.0, 3.2],
            walls: [&PLASTER, &PLASTER, &BATH_TILE, &PLASTER],
            floor: Some(&SLATE_FLOOR),
        },
        Room {
            name: "hall",
            x: [9.36, 11.6],
            z: [0.0, 4.4],
            walls: [&PLASTER, &PLASTER, &PLASTER, &TERRACOTTA],
            floor: Some(&STONE_FLOOR),
        },
        Room { name: "passage", x: [8.48, 9.24], z: [3.32, 4.4], walls: plain, floor: Some(&OAK_FLOOR) },
        Room {
            name: "kitchen",
            x: [8.6, 11.6],
            z: [4.52, SOUTH],
            walls: [&PLASTER, &PLASTER, &SAGE, &PLASTER],
            floor: Some(&STONE_FLOOR),
        },
        Room {
            name: "living",
            x: [0.0, 8.48],
            z: [3.32, SOUTH],
            walls: [&CLAY, &PLASTER, &PLASTER, &PLASTER],
            floor: None,
        },
    ];
    for room in &rooms {
        room.build(m, &openings);
    }
    levels(m);
    leaves(m);
    let south = windows.iter().map(|w| w.0).filter(|w| w.through[0] == SOUTH && w.along[1] < 8.6);
    south.map(|w| [w.along[0], w.along[1], w.height[0], w.height[1]]).collect()
}

/// The two floor levels of the living space, the walls' feet in the pit, risers and steps.
fn levels(m: &mut Model) {
    let down = -PIT;
    m.object("living_floor").paint(&OAK_FLOOR);
    m.quad(dvec3(0.0, 0.0, PIT_NORTH), DVec3::X * 8.48, DVec3::Z * (3.32 - PIT_NORTH));
    m.quad(dvec3(PIT_EAST, 0.0, SOUTH), DVec3::X * (8.48 - PIT_EAST), DVec3::Z * (PIT_NORTH - SOUTH));
    m.quad(dvec3(0.0, PIT, SOUTH), DVec3::X * PIT_EAST, DVec3::Z * (PIT_NORTH - SOUTH));
    m.object("living_walls").paint(&CLAY);
    m.wall(dvec3(0.0, PIT, SOUTH), -DVec3::Z, SOUTH - PIT_NORTH, down, &[]);
    m.paint(&PLASTER);
    m.wall(dvec3(PIT_EAST, PIT, SOUTH), -DVec3::X, PIT_EAST, down, &[]);
    m.object("risers").paint(&WALNUT);
    m.wall(dvec3(0.0, PIT, PIT_NORTH), DVec3::X, PIT_EAST, down, &[]);
    let step = [STEPS[0] - PIT_NORTH, STEPS[1] - PIT_NORTH, 0.0, 0.5 * down];
    m.wall(dvec3(PIT_EAST, PIT, PIT_NORTH), DVec3::Z, SOUTH - PIT_NORTH, down, &[step]);

    m.object("steps").paint(&WALNUT);
    let (x, y) = (PIT_EAST - TREAD, PIT + 0.5 * down);
    m.wall(dvec3(x, PIT, STEPS[0]), DVec3::Z, STEPS[1] - STEPS[0], 0.5 * down, &[]);
    m.wall(dvec3(PIT_EAST, PIT, STEPS[0]), -DVec3::X, TREAD, 0.5 * down, &[]);
    m.wall(dvec3(x, PIT, STEPS[1]), DVec3::X, TREAD, 0.5 * down, &[]);
    m.paint(&OAK_FLOOR);
    m.quad(dvec3(x, y, STEPS[1]), DVec3::X * TREAD, DVec3::Z * (STEPS[0] - STEPS[1]));
}

/// Door leaves, standing open into the rooms, and the closed front door.
fn leaves(m: &mut Model) {
    for (hinge, turn) in [([2.88, 0.0, 3.19], 96.0), ([3.62, 0.0, 3.19], 84.0), ([7.32, 0.0, 3.19], 80.0)] {
        m.place(hinge, turn, |m| shell::leaf(m, 0.76, 2.03, &JOINERY));
    }
    // The front door stands 3 cm proud of the wall, with its casing.
    m.object("front_door").paint(&WALNUT);
    m.wall(dvec3(9.85, 0.0, 0.03), DVec3::X, 0.9, 2.1, &[]);
    m.quad(dvec3(9.85, 2.1, 0.03), DVec3::X * 0.9, DVec3::Z * -0.03);
    m.wall(dvec3(9.85, 0.0, 0.0), DVec3::Z, 0.03, 2.1, &[]);
    m.wall(dvec3(10.75, 0.0, 0.03), -DVec3::Z, 0.03, 2.1, &[]);
}
