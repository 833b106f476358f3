//! The terrace in front of the south windows: what there is to see outside at night.

use super::furniture::table;
use super::palette::{DARK_FRAME, OAK, PLASTER};
use super::plan::{OUTER, SOUTH, TERRACE_WINDOWS};
use super::plants::plant_between;
use super::shell::HEIGHT;
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{LampId, Model, Output, Paint};
use glam::{DVec3, dvec3};

pub(crate) const DECK: Paint = Paint::solid("larch_deck", [0.34, 0.23, 0.15]);
pub(crate) const BOARD: Paint = Paint::solid("larch_board", [0.40, 0.26, 0.15]);
pub(crate) const WEATHERED: Paint = Paint::solid("larch_weathered", [0.33, 0.24, 0.17]);

/// West and east end and south edge of the terrace, its level, metres.
const WEST: f64 = -0.4;
const EAST: f64 = 8.8;
const EDGE: f64 = 10.5;
const LEVEL: f64 = -0.02;

pub(crate) fn terrace(m: &mut Model) {
    let lights = m.lamp("Terrace wall lights", Output::White(1500.0, 3000.0), true);
    let (front, width) = (SOUTH + OUTER, EAST - WEST);
    m.object("deck").paint(&DECK);
    m.quad(dvec3(WEST, LEVEL, EDGE), DVec3::X * width, DVec3::Z * (front - EDGE));

    // The outside of the house, as far as the terrace goes.
    let holes = TERRACE_WINDOWS.map(|w| {
        let [from, to] = w.along.map(|x| x - WEST);
        let [sill, head] = w.height.map(|y| y - LEVEL);
        [from, to, sill, head]
    });
    m.object("facade").paint(&PLASTER);
    m.wall(dvec3(WEST, LEVEL, front), DVec3::X, width, HEIGHT + 0.2 - LEVEL, &holes);

    // A fence of broad upright boards of two tones closes the south.
    let (height, boards) = (1.8, 16);
    let pitch = width / f64::from(boards);
    m.object("fence");
    for k in 0..boards {
        m.paint(if k % 2 == 0 { &BOARD } else { &WEATHERED });
        m.wall(dvec3(EAST - pitch * f64::from(k), LEVEL, EDGE), -DVec3::X, pitch, height, &[]);
    }
    for x in [1.1, 2.9, 4.7, 6.5, 8.0] {
        m.place([x, 1.25, EDGE], 180.0, |m| wall_light(m, lights));
    }
    for (x, height, seed) in [(2.0, 1.35, 51), (5.6, 1.1, 52), (7.3, 1.3, 53)] {
        m.place([x, LEVEL, EDGE - 0.42], 0.0, |m| {
            m.object("planters").paint(&DARK_FRAME);
            m.block([-0.25, 0.0, -0.25], [0.25, 0.3, 0.25], Faces::STANDING);
            m.place([0.0, 0.3, 0.0], 0.0, |m| {
                plant_between(m, height, 12, seed, &[[[-9.0, 0.0, 0.42], [9.0; 3]]])
            });
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
