//! The house's plan: rooms, openings, levels, doors and rugs.

use super::palette::{
    BATH_TILE, BLUE_WOOL, CEILING, CHARCOAL, CLAY, CREAM, DUSK_BLUE, JOINERY, OAK_FLOOR, PINE_GREEN, PLASTER,
    RUST, SAGE, SLATE_FLOOR, STONE_FLOOR, TERRACOTTA, WALNUT,
};
use super::shell::{self, Across, Filled, HEIGHT, Opening, Room, Rug, floor};
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::Model;
use glam::{DVec3, dvec3};

/// Level of the sunken living room's floor, metres; two risers of 0.18 m lead down.
pub(crate) const PIT: f64 = -0.36;
/// East and north edge of the sunken floor, metres.
pub(crate) const PIT_EAST: f64 = 5.2;
pub(crate) const PIT_NORTH: f64 = 4.6;
/// Where the steps run along the pit's east edge (z from, z to), and the depth of their tread.
const STEPS: [f64; 2] = [5.3, 6.9];
const TREAD: f64 = 0.32;
/// South face of the outer wall's inside, metres.
pub(crate) const SOUTH: f64 = 8.4;
/// Thickness of the outer walls, metres.
pub(crate) const OUTER: f64 = 0.2;

/// The windows of the living and the dining room: the only ones that something is seen through.
pub(crate) const TERRACE_WINDOWS: [Opening; 2] = [
    Opening::window(Across::Z, [0.8, 4.4], SOUTH, SOUTH + OUTER, [0.05, 2.25]),
    Opening::window(Across::Z, [5.9, 7.7], SOUTH, SOUTH + OUTER, [0.05, 2.25]),
];

/// All windows, those to the terrace first, with how many panes they have side by side and where a crossbar.
pub(crate) const WINDOWS: [(Opening, usize, Option<f64>); 7] = [
    (TERRACE_WINDOWS[0], 4, None),
    (TERRACE_WINDOWS[1], 2, Some(1.75)),
    (Opening::window(Across::Z, [9.3, 10.9], SOUTH, SOUTH + OUTER, [1.2, 2.1]), 2, None),
    (Opening::window(Across::Z, [4.2, 6.0], 0.0, -OUTER, [0.9, 2.2]), 3, None),
    (Opening::window(Across::X, [0.7, 2.1], 0.0, -OUTER, [0.95, 2.2]), 2, Some(1.8)),
    (Opening::window(Across::Z, [7.6, 8.4], 0.0, -OUTER, [1.45, 2.1]), 1, None),
    (Opening::window(Across::Z, [11.0, 11.3], 0.0, -OUTER, [0.3, 2.05]), 1, None),
];

/// The rugs: they are let into the floors, so that no patches lie unseen beneath them.
const RUGS: &[Rug] = &[
    Rug { room: "living", x: [0.95, 3.95], z: [5.4, 7.5], border: 0.12, field: &CREAM, edge: &CHARCOAL },
    Rug { room: "living", x: [5.65, 8.05], z: [4.8, 7.8], border: 0.1, field: &RUST, edge: &CHARCOAL },
    Rug { room: "bathroom", x: [7.48, 8.43], z: [0.85, 1.45], border: 0.05, field: &CREAM, edge: &RUST },
    Rug { room: "bedroom", x: [4.0, 4.8], z: [0.6, 2.6], border: 0.06, field: &CREAM, edge: &RUST },
    Rug { room: "hall", x: [9.83, 10.78], z: [0.75, 3.45], border: 0.08, field: &BLUE_WOOL, edge: &CREAM },
    Rug { room: "study", x: [1.15, 2.35], z: [0.9, 2.6], border: 0.08, field: &CREAM, edge: &CHARCOAL },
];

/// Rooms with their openings, floor levels and doors.
pub(crate) fn shell(m: &mut Model, by_day: bool) {
    let inner = |across, along, through, head, floor| Opening::door(across, along, through, head, floor);
    let doors = [
        inner(Across::Z, [2.1, 2.9], [3.2, 3.32], 2.05, &OAK_FLOOR),
        inner(Across::Z, [3.6, 4.4], [3.2, 3.32], 2.05, &OAK_FLOOR),
        inner(Across::Z, [7.3, 8.1], [3.2, 3.32], 2.05, &SLATE_FLOOR),
        inner(Across::X, [3.45, 4.3], [9.24, 9.36], 2.2, &STONE_FLOOR),
        inner(Across::X, [5.2, 7.4], [8.48, 8.6], 2.25, &STONE_FLOOR),
    ];
    // The gallery runs on to the entrance: no wall there.
    let join = inner(Across::X, [3.32, 4.4], [8.48, 8.48], HEIGHT, &OAK_FLOOR);
    let mut openings = doors.to_vec();
    for opening in &openings {
        opening.reveal(m);
    }
    for (k, (window, panes, transom)) in WINDOWS.iter().enumerate() {
        let inside = if window.through[0] == SOUTH { Faces::BACK } else { Faces::FRONT };
        let filled = match by_day {
            true => Filled::Glass,
            false if k < TERRACE_WINDOWS.len() => Filled::Nothing,
            false => Filled::Night,
        };
        window.frame(m, *panes, *transom, inside, filled);
    }
    openings.extend(WINDOWS.iter().map(|w| w.0));
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
        Room { name: "living", x: [8.48, 9.24], z: [3.32, 4.4], walls: plain, floor: None },
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
        room.build(m, &openings, RUGS);
    }
    levels(m);
    leaves(m);
}

/// The two floor levels of the living space, the walls' feet in the pit, risers and steps.
fn levels(m: &mut Model) {
    let down = -PIT;
    // Upper floor and ceiling are one surface each, so that no seam shows in the light.
    let east = [[8.48, SOUTH], [8.48, 4.4], [9.24, 4.4], [9.24, 3.32]];
    let upper: Vec<_> = [[0.0, 3.32], [0.0, PIT_NORTH], [PIT_EAST, PIT_NORTH], [PIT_EAST, SOUTH]]
        .iter()
        .chain(&east)
        .map(|&[x, z]| dvec3(x, 0.0, z))
        .collect();
    let dining_rug = RUGS.iter().find(|r| r.room == "living" && r.x[0] > PIT_EAST);
    m.object("living_floor").paint(&OAK_FLOOR);
    m.pierced(&upper, dining_rug.map(|r| r.cut(0.0)).as_slice());
    dining_rug.iter().for_each(|r| r.build(m, 0.0));
    let mut ceiling: Vec<_> =
        [[0.0, 3.32], [0.0, SOUTH]].iter().chain(&east).map(|&[x, z]| dvec3(x, HEIGHT, z)).collect();
    ceiling.reverse();
    m.object("living_ceiling").paint(&CEILING).pierced(&ceiling, &[]);
    floor(m, "living", ([0.0, PIT_EAST], [PIT_NORTH, SOUTH]), PIT, &OAK_FLOOR, RUGS);
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
