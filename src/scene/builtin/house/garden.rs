//! What is around the house by day: its outer walls and roof, a terrace, and a garden.

use super::furniture::table;
use super::palette::{DARK_FRAME, OAK, PLASTER};
use super::plan::{OUTER, SOUTH, WINDOWS};
use super::plants::plant;
use super::shell::{Across, HEIGHT, Opening};
use super::terrace::{BOARD, DECK, WEATHERED};
use crate::scene::builtin::shapes::{Faces, Hole, rectangle};
use crate::scene::builtin::writer::{Model, Paint};
use glam::{DVec3, dvec3};

const GRASS: Paint = Paint::solid("grass", [0.10, 0.17, 0.05]);
const HEDGE: Paint = Paint::solid("hedge", [0.05, 0.11, 0.03]);
const CROWN: Paint = Paint::solid("tree_crown", [0.07, 0.15, 0.04]);
const BARK: Paint = Paint::solid("bark", [0.16, 0.12, 0.09]);
const ROOF: Paint = Paint::solid("roof_fascia", [0.34, 0.33, 0.31]);

/// Outer faces of the outer walls, metres.
const WEST: f64 = -OUTER;
const EAST: f64 = 11.6 + OUTER;
const NORTH: f64 = -OUTER;
const FRONT: f64 = SOUTH + OUTER;
/// Level of the lawn, and of the terrace before the south windows; where that ends.
const LAWN: f64 = -0.06;
const LEVEL: f64 = -0.02;
const EDGE: f64 = 11.2;
const DECK_EAST: f64 = 8.8;
/// How far the roof stands out, and how thick it is.
const EAVES: f64 = 0.35;
const ROOF_FROM: f64 = HEIGHT + 0.2;
const ROOF_TO: f64 = HEIGHT + 0.4;
/// Ends of the lawn.
const LAWN_X: [f64; 2] = [-8.0, 19.0];
const LAWN_Z: [f64; 2] = [-6.0, 24.0];

pub(crate) fn garden(m: &mut Model) {
    outer_walls(m);
    // The lawn, around the house and its terrace.
    let lawn = rectangle([LAWN_X[0], LAWN_Z[0]], [LAWN_X[1], LAWN_Z[1]], LAWN);
    let terrace = [[WEST, FRONT], [WEST, EDGE], [DECK_EAST, EDGE], [DECK_EAST, FRONT]];
    let footprint: Vec<DVec3> = [[WEST, NORTH]]
        .iter()
        .chain(&terrace)
        .chain(&[[EAST, FRONT], [EAST, NORTH]])
        .map(|&[x, z]| dvec3(x, LAWN, z))
        .collect();
    m.object("lawn").paint(&GRASS).pierced(&lawn, &[footprint]);
    m.object("deck").paint(&DECK);
    m.quad(dvec3(WEST, LEVEL, EDGE), DVec3::X * (DECK_EAST - WEST), DVec3::Z * (FRONT - EDGE));
    m.wall(dvec3(WEST, LAWN, EDGE), DVec3::X, DECK_EAST - WEST, LEVEL - LAWN, &[]);
    m.wall(dvec3(WEST, LAWN, FRONT), DVec3::Z, EDGE - FRONT, LEVEL - LAWN, &[]);
    m.wall(dvec3(DECK_EAST, LAWN, EDGE), -DVec3::Z, EDGE - FRONT, LEVEL - LAWN, &[]);

    m.object("terrace_bench");
    m.place([2.2, LEVEL, EDGE - 0.5], 0.0, |m| table(m, [1.6, 0.44, 0.42], 0.05, &OAK, &DARK_FRAME));
    for (x, height, seed) in [(0.3, 1.2, 51), (5.1, 1.0, 52), (8.3, 1.3, 53)] {
        m.place([x, LEVEL, EDGE - 0.45], 0.0, |m| plant(m, height, 12, seed));
    }
    // A hedge to the street, a fence of two tones to the neighbours.
    m.object("hedge").paint(&HEDGE);
    let [west, east] = [LAWN_X[0] + 0.2, LAWN_X[1] - 0.2];
    m.block([west, LAWN, LAWN_Z[1] - 1.2], [east, 1.5, LAWN_Z[1] - 0.2], Faces::STANDING);
    m.object("fence");
    let boards = 12;
    let pitch = 12.4 / f64::from(boards);
    for k in 0..boards {
        m.paint(if k % 2 == 0 { &BOARD } else { &WEATHERED });
        let z = 10.0 + pitch * f64::from(k);
        // Neighbours share their narrow sides.
        let mut faces = Faces::LEFT.and(Faces::RIGHT).and(Faces::TOP);
        if k == 0 {
            faces = faces.and(Faces::BACK);
        }
        if k + 1 == boards {
            faces = faces.and(Faces::FRONT);
        }
        m.block([-6.05, LAWN, z], [-6.0, 1.7, z + pitch], faces);
    }
    for (x, z, height, radius) in [(-2.5, 17.0, 3.4, 1.7), (5.6, 21.5, 4.2, 2.2), (13.5, 16.0, 3.2, 1.6)] {
        m.object("trees").paint(&BARK);
        let trunk = 0.14;
        // Up to the foot of the crown, so that no faces cut through each other.
        m.block([x - trunk, LAWN, z - trunk], [x + trunk, height - radius, z + trunk], Faces::STANDING);
        m.paint(&CROWN).ball(dvec3(x, height, z), radius, 5, 10);
    }
}

/// The outer walls with their windows, and the flat roof over them.
fn outer_walls(m: &mut Model) {
    let height = ROOF_FROM - LAWN;
    m.object("facade").paint(&PLASTER);
    let holes = |across: Across, outer: f64, start: f64, sign: f64| -> Vec<Hole> {
        let of_wall = |o: &&Opening| o.across == across && o.through.iter().any(|t| (t - outer).abs() < 1e-9);
        let hole = |o: &Opening| {
            let ends = o.along.map(|a| (a - start) * sign);
            let [sill, head] = o.height.map(|y| y - LAWN);
            [ends[0].min(ends[1]), ends[0].max(ends[1]), sill, head]
        };
        WINDOWS.iter().map(|window| &window.0).filter(of_wall).map(hole).collect()
    };
    let (width, depth) = (EAST - WEST, FRONT - NORTH);
    m.wall(dvec3(WEST, LAWN, FRONT), DVec3::X, width, height, &holes(Across::Z, FRONT, WEST, 1.0));
    m.wall(dvec3(EAST, LAWN, NORTH), -DVec3::X, width, height, &holes(Across::Z, NORTH, EAST, -1.0));
    m.wall(dvec3(WEST, LAWN, NORTH), DVec3::Z, depth, height, &holes(Across::X, WEST, NORTH, 1.0));
    m.wall(dvec3(EAST, LAWN, FRONT), -DVec3::Z, depth, height, &[]);
    m.object("roof").paint(&ROOF);
    let (low, high) = ([WEST - EAVES, ROOF_FROM, NORTH - EAVES], [EAST + EAVES, ROOF_TO, FRONT + EAVES]);
    m.block(low, high, Faces::UPRIGHT.and(Faces::TOP));
    // Its soffit, around the walls.
    let outline: Vec<DVec3> =
        rectangle([low[0], low[2]], [high[0], high[2]], ROOF_FROM).into_iter().rev().collect();
    m.pierced(&outline, &[rectangle([WEST, NORTH], [EAST, FRONT], ROOF_FROM).to_vec()]);
}
