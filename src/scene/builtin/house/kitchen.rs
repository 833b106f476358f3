//! Dining room and kitchen.

use super::furniture::{bowl, cabinet, chair, fronts, picture, place_setting, table, tap, vase};
use super::lamps::{dome_pendant, globe_pendant, strip};
use super::palette::{
    BLACK, BRASS, CERAMIC, DARK_FRAME, JOINERY, KITCHEN_TILE, MUSTARD, OAK, PINE_GREEN, POT, RUST,
    SAGE_FRONT, STEEL, WALNUT, WORKTOP,
};
use super::plan::SOUTH;
use super::plants::{plant, plant_between};
use super::shell::HEIGHT;
use super::textiles::curtains;
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{Model, Output, Paint};
use glam::{DVec3, dvec3};

/// The enamel of the dining room's pendants: the study's green.
const ENAMEL: Paint = Paint::solid("green_enamel", PINE_GREEN.reflectance);

pub(crate) fn dining_room(m: &mut Model) {
    let pendants = m.lamp("Dining pendants", Output::White(2300.0, 4000.0), true);
    let (x, z) = (6.85, 6.3);
    for dz in [-0.65, 0.0, 0.65] {
        m.place([x, HEIGHT, z + dz], 0.0, |m| dome_pendant(m, pendants, 0.98, &ENAMEL));
    }
    m.place([x, 0.0, z], 0.0, |m| {
        m.object("dining_table");
        table(m, [0.95, 0.75, 1.9], 0.06, &OAK, &OAK);
        m.object("dining_chairs");
        let (side, end) = (0.57, 1.08);
        let places = [
            ([-side, -0.45], 90.0),
            ([-side, 0.45], 90.0),
            ([side, -0.45], -90.0),
            ([side + 0.05, 0.45], -82.0),
            ([0.0, -end], 0.0),
            ([0.02, end + 0.04], 176.0),
        ];
        for ([x, z], turn) in places {
            m.object("dining_chairs").place([x, 0.0, z], turn, |m| chair(m, &WALNUT, &MUSTARD));
        }
        for (x, z, turn) in [(-0.3, -0.45, -90.0), (-0.3, 0.45, -90.0), (0.3, -0.45, 90.0), (0.3, 0.45, 90.0)]
        {
            m.place([x, 0.75, z], turn, place_setting);
        }
        m.place([0.0, 0.75, 0.0], 0.0, |m| bowl(m, &CERAMIC, 0.17));
        m.place([0.02, 0.75, 0.72], 0.0, |m| vase(m, &RUST, 0.8));
    });
    m.place([8.48, 0.0, 7.92], -90.0, |m| {
        m.object("sideboard");
        cabinet(m, [0.86, 0.85, 0.4], 2, &WALNUT, &WALNUT);
        m.place([0.1, 0.85, 0.2], 0.0, |m| {
            plant_between(m, 0.55, 14, 5, &[[[-9.0, 0.0, -9.0], [9.0, 9.0, -0.17]]])
        });
    });
    m.place([8.48, 1.6, 7.92], -90.0, |m| picture(m, [0.6, 0.8], &DARK_FRAME, 2));
    m.place([7.7, 0.0, SOUTH], 180.0, |m| curtains(m, 1.8, 0.03, 2.36, 0.36));
}

/// Depth of the base units to their fronts, height of the worktop, its overhang, metres.
const BASE: f64 = 0.6;
const TOP: f64 = 0.9;
const NOSE: f64 = 0.02;
/// East and west wall of the kitchen; where the east run of units starts.
const EAST: f64 = 11.6;
const WEST: f64 = 8.6;
const RUN_NORTH: f64 = 5.75;
/// From where to where the wall units leave room for the hood.
const HOOD: [f64; 2] = [6.6, 7.2];

pub(crate) fn kitchen(m: &mut Model) {
    let pendant = m.lamp("Kitchen pendant", Output::White(2200.0, 5000.0), true);
    let under = m.lamp("Under-cabinet strip", Output::White(1200.0, 5500.0), true);
    m.place([9.75, HEIGHT, 6.2], 0.0, |m| globe_pendant(m, pendant, 0.6, 0.17));

    base_units(m);
    worktops(m);
    wall_units(m);
    for (z, length) in [(6.17, 0.74), (7.75, 1.0)] {
        m.place([EAST - 0.2, 1.5, z], 90.0, |m| strip(m, under, length));
    }
    on_the_worktop(m);

    // A small table against the north wall, and boards with jars over it.
    m.place([9.6, 0.0, 4.84], 0.0, |m| {
        m.object("kitchen_table");
        table(m, [0.8, 0.74, 0.6], 0.04, &OAK, &OAK);
        m.place([0.1, 0.74, 0.0], 0.0, |m| bowl(m, &RUST_GLAZE, 0.13));
    });
    for (x, turn) in [(-0.6, 90.0), (0.62, -84.0)] {
        m.object("kitchen_chairs");
        m.place([9.6 + x, 0.0, 4.86], turn, |m| chair(m, &WALNUT, &SAGE_FRONT));
    }
    for y in [1.35, 1.7] {
        m.object("kitchen_boards").paint(&OAK);
        m.block([8.9, y, 4.52], [10.3, y + 0.025, 4.7], Faces::ALL.without(Faces::BACK));
        for k in 0..5 {
            let paint = [&CERAMIC, &BRASS, &POT, &STEEL, &CERAMIC, &RUST_GLAZE][(k + (y > 1.5) as usize) % 6];
            let (radius, height) = (0.045 + 0.008 * (k % 3) as f64, 0.12 + 0.03 * (k % 2) as f64);
            m.object("jars").paint(paint);
            let at = dvec3(9.02 + 0.28 * k as f64, y + 0.025, 4.61);
            m.lathe(at, &[(radius, 0.0), (radius, height), (0.0, height + 0.025)], 8);
        }
    }
}

const RUST_GLAZE: Paint = Paint::solid("rust_glaze", [0.45, 0.16, 0.08]);

/// Cupboards below the worktops, and the tall ones at the east run's north end.
fn base_units(m: &mut Model) {
    let (plinth, toe) = (0.1, 0.06);
    // East run, along local x from its north end; it stops where the south run's fronts begin.
    let length = SOUTH - BASE - RUN_NORTH;
    // The plinths, set back, run on to where they meet in the corner.
    let run = |m: &mut Model, width: f64, doors: usize, [from, to]: [f64; 2]| {
        m.object("kitchen_units");
        fronts(m, [0.0, plinth, BASE], [width, TOP - 0.03 - plinth], doors, 0.012, &SAGE_FRONT);
        m.quad(dvec3(0.0, plinth, BASE - toe), DVec3::X * to, DVec3::Z * toe);
        m.paint(&DARK_FRAME).wall(dvec3(from, 0.0, BASE - toe), DVec3::X, to - from, plinth, &[]);
        m.paint(&BRASS);
        for k in 0..doors {
            let x = width * (k as f64 + 0.5) / doors as f64;
            m.block([x - 0.07, 0.76, BASE], [x + 0.07, 0.775, BASE + 0.02], Faces::ALL.without(Faces::BACK));
        }
    };
    m.place([EAST, 0.0, RUN_NORTH], -90.0, |m| run(m, length, 4, [0.0, length + toe]));
    let length = EAST - BASE - WEST;
    m.place([EAST - BASE, 0.0, SOUTH], 180.0, |m| run(m, length, 4, [-toe, length]));

    let (tall, depth, width) = (2.25, 0.64, RUN_NORTH - 4.56);
    m.object("tall_units");
    m.place([EAST, 0.0, 4.56], -90.0, |m| {
        m.paint(&SAGE_FRONT);
        m.block([0.0, 0.0, 0.0], [width, tall, depth], Faces::LEFT.and(Faces::RIGHT).and(Faces::TOP));
        fronts(m, [0.0, 0.0, depth], [width, tall], 2, 0.014, &SAGE_FRONT);
        m.paint(&BRASS);
        for x in [0.5 * width - 0.06, 0.5 * width + 0.04] {
            m.block([x, 0.95, depth], [x + 0.02, 1.35, depth + 0.025], Faces::ALL.without(Faces::BACK));
        }
    });
}

/// Stone tops with a sink under the window, and tiles behind.
fn worktops(m: &mut Model) {
    let (x, z, low) = (EAST - BASE - NOSE, SOUTH - BASE - NOSE, TOP - 0.03);
    let sink = [9.75, 10.35, 7.92, 8.26];
    m.object("worktops").paint(&WORKTOP);
    m.quad(dvec3(x, TOP, SOUTH), DVec3::X * (EAST - x), DVec3::Z * (RUN_NORTH - SOUTH));
    let hole = [sink[0] - WEST, sink[1] - WEST, SOUTH - sink[3], SOUTH - sink[2]];
    m.panel(dvec3(WEST, TOP, SOUTH), (DVec3::X, x - WEST), (-DVec3::Z, SOUTH - z), &[hole]);
    m.wall(dvec3(x, low, RUN_NORTH), DVec3::Z, z - RUN_NORTH, TOP - low, &[]);
    m.wall(dvec3(x, low, z), -DVec3::X, x - WEST, TOP - low, &[]);
    m.quad(dvec3(x, low, RUN_NORTH), DVec3::X * NOSE, DVec3::Z * (z + NOSE - RUN_NORTH));
    m.quad(dvec3(WEST, low, z), DVec3::X * (x - WEST), DVec3::Z * NOSE);
    m.object("sink").paint(&STEEL).basin([sink[0], TOP - 0.18, sink[2]], [sink[1], TOP, sink[3]], 0.01);
    m.place([10.05, TOP, 8.32], 180.0, |m| tap(m, 0.25, 0.19));

    let (tile, head, sill) = (0.008, 1.5, 1.2);
    m.object("tiles").paint(&KITCHEN_TILE);
    let length = SOUTH - RUN_NORTH;
    let behind = [length - tile, length, 0.0, sill - TOP];
    m.wall(dvec3(EAST - tile, TOP, RUN_NORTH), DVec3::Z, length, head - TOP, &[behind]);
    m.wall(dvec3(EAST - tile, TOP, SOUTH - tile), -DVec3::X, EAST - tile - WEST, sill - TOP, &[]);
    m.quad(dvec3(WEST, sill, SOUTH), DVec3::X * (EAST - tile - WEST), DVec3::Z * -tile);
    let [from, to] = HOOD;
    m.quad(dvec3(EAST - tile, head, to), DVec3::X * tile, DVec3::Z * (from - to));
}

/// Cupboards on the east wall and the hood between them.
fn wall_units(m: &mut Model) {
    let (low, high, depth) = (1.5, 2.25, 0.34);
    for (z0, z1, doors, touching) in [(RUN_NORTH, HOOD[0], 2, Faces::LEFT), (HOOD[1], SOUTH, 3, Faces::RIGHT)]
    {
        m.object("wall_units");
        m.place([EAST, low, z0], -90.0, |m| {
            let (w, h) = (z1 - z0, high - low);
            m.paint(&JOINERY).block([0.0, 0.0, 0.0], [w, h, depth], Faces::AROUND.without(touching));
            fronts(m, [0.0, 0.0, depth], [w, h], doors, 0.01, &JOINERY);
        });
    }
    m.object("hood").paint(&STEEL);
    m.place([EAST, 1.62, 6.62], -90.0, |m| {
        m.block([0.0, 0.0, 0.0], [0.56, 0.1, 0.46], Faces::ALL.without(Faces::BACK));
        m.block([0.16, 0.1, 0.0], [0.4, HEIGHT - 1.62, 0.24], Faces::UPRIGHT.without(Faces::BACK));
    });
}

fn on_the_worktop(m: &mut Model) {
    m.object("hob").paint(&BLACK);
    m.block([11.08, TOP, 6.6], [11.52, TOP + 0.008, 7.2], Faces::STANDING);
    m.object("pots").paint(&RUST_GLAZE);
    m.lathe(dvec3(11.3, TOP + 0.008, 6.78), &[(0.11, 0.0), (0.11, 0.12), (0.02, 0.14), (0.0, 0.16)], 14);
    m.object("kettle").paint(&STEEL);
    m.lathe(dvec3(11.32, TOP, 5.98), &[(0.09, 0.0), (0.085, 0.12), (0.05, 0.2), (0.0, 0.22)], 12);
    m.object("chopping_board").paint(&OAK);
    m.place([11.25, TOP, 7.6], 8.0, |m| m.block([-0.14, 0.0, -0.2], [0.14, 0.02, 0.2], Faces::STANDING));
    m.place([10.75, TOP, 8.15], 0.0, |m| plant(m, 0.4, 12, 9));
    m.place([9.15, TOP, 8.08], 0.0, |m| bowl(m, &BRASS, 0.16));
    m.object("bottles").paint(&ENAMEL);
    for (x, z) in [(8.8, 8.22), (8.93, 8.28)] {
        m.lathe(
            dvec3(x, TOP, z),
            &[(0.036, 0.0), (0.036, 0.18), (0.013, 0.24), (0.013, 0.3), (0.0, 0.3)],
            10,
        );
    }
}
