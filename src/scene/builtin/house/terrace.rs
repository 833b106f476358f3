//! The terrace in front of the south windows: what there is to see outside at night.

use super::furniture::{plant, table};
use super::palette::{DARK_FRAME, OAK};
use super::{OUTER, SOUTH};
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{LampId, Model, Output, Paint};
use glam::{DVec3, dvec3};

const FACADE: Paint = Paint::solid("facade_render", [0.66, 0.62, 0.54]);
const DECK: Paint = Paint::solid("larch_deck", [0.34, 0.23, 0.15]);
const FENCE: Paint = Paint::solid("larch_fence", [0.40, 0.26, 0.15]);
const GAP: Paint = Paint::solid("fence_gap", [0.05, 0.04, 0.03]);
const HEDGE: Paint = Paint::solid("hedge", [0.07, 0.16, 0.05]);

/// West and east end and south edge of the terrace, its level, metres.
const WEST: f64 = -0.3;
const EAST: f64 = 8.9;
const EDGE: f64 = 11.3;
const LEVEL: f64 = -0.02;

/// `windows` are the openings of the south wall as x from, x to, sill and head.
pub(crate) fn terrace(m: &mut Model, windows: &[[f64; 4]]) {
    let lights = m.lamp("Terrace wall lights", Output::White(1500.0, 3000.0), true);
    let (front, width, eaves) = (SOUTH + OUTER, EAST - WEST, 2.8);

    m.object("facade").paint(&FACADE);
    let holes: Vec<_> =
        windows.iter().map(|[x0, x1, y0, y1]| [x0 - WEST, x1 - WEST, y0 - LEVEL, y1 - LEVEL]).collect();
    m.wall(dvec3(WEST, LEVEL, front), DVec3::X, width, eaves - LEVEL, &holes);
    m.object("eaves");
    m.quad(dvec3(WEST, eaves, front), DVec3::X * width, DVec3::Z * 0.7);
    m.object("deck").paint(&DECK);
    m.quad(dvec3(WEST, LEVEL, EDGE), DVec3::X * width, DVec3::Z * (front - EDGE));

    // A fence of upright boards closes the south, hedges the other two sides.
    let (height, boards) = (1.9, 24);
    let pitch = width / boards as f64;
    let slats: Vec<_> =
        (0..boards).map(|k| [pitch * k as f64 + 0.02, pitch * (k + 1) as f64 - 0.02, 0.06, height]).collect();
    m.object("fence").paint(&GAP);
    m.wall(dvec3(EAST, LEVEL, EDGE), -DVec3::X, width, height, &slats);
    m.paint(&FENCE);
    for [u0, u1, v0, v1] in slats {
        m.wall(dvec3(EAST - u0, LEVEL + v0, EDGE), -DVec3::X, u1 - u0, v1 - v0, &[]);
    }
    m.object("hedges").paint(&HEDGE);
    m.wall(dvec3(WEST, LEVEL, EDGE), -DVec3::Z, EDGE - front, 1.5, &[]);
    m.wall(dvec3(EAST, LEVEL, front), DVec3::Z, EDGE - front, 1.5, &[]);

    for x in [1.1, 2.9, 4.7, 6.5, 8.0] {
        m.place([x, 1.25, EDGE], 180.0, |m| wall_light(m, lights));
    }
    for (x, height, seed) in [(2.0, 1.35, 51), (5.6, 1.1, 52), (7.3, 1.3, 53)] {
        m.place([x, LEVEL, EDGE - 0.42], 0.0, |m| {
            m.object("planters").paint(&DARK_FRAME);
            m.block([-0.25, 0.0, -0.25], [0.25, 0.3, 0.25], Faces::STANDING);
            m.place([0.0, 0.3, 0.0], 0.0, |m| plant(m, height, 18, seed));
        });
    }
    m.object("terrace_bench");
    m.place([3.8, LEVEL, EDGE - 0.45], 0.0, |m| table(m, [1.3, 0.44, 0.42], 0.05, &OAK, &DARK_FRAME));
}

/// A wall light that washes the wall z = 0 upwards and downwards.
fn wall_light(m: &mut Model, lamp: LampId) {
    m.object("wall_lights").paint(&DARK_FRAME);
    m.block([-0.06, -0.08, 0.02], [0.06, 0.08, 0.12], Faces::UPRIGHT);
    m.block([-0.03, -0.03, 0.0], [0.03, 0.03, 0.02], Faces::AROUND);
    m.glow(lamp, 1.0, [0.7; 3]);
    m.block([-0.06, -0.08, 0.02], [0.06, 0.08, 0.12], Faces::TOP.and(Faces::BOTTOM));
}
