//! A closed room after the picture of Cohen and Greenberg 1985: one red wall, one blue, two boxes.

use super::shapes::{Faces, rectangle, square};
use super::writer::{Model, Output, Paint};
use glam::{DVec3, dvec3};

const WHITE: Paint = Paint::solid("white", [0.75, 0.75, 0.74]);
const RED: Paint = Paint::solid("red", [0.63, 0.06, 0.05]);
const BLUE: Paint = Paint::solid("blue", [0.10, 0.16, 0.60]);
const YELLOW: Paint = Paint::solid("yellow", [0.75, 0.60, 0.10]);

/// Clear width (x), height (y) and depth (z), metres.
const ROOM: DVec3 = dvec3(3.2, 2.6, 4.0);

/// The ceiling lamp, x from, x to, z from, z to; flush with the ceiling.
const LAMP: [f64; 4] = [1.1, 2.1, 1.2, 2.2];

/// A box on the floor; metres and degrees.
struct Block {
    x: f64,
    z: f64,
    half: f64,
    height: f64,
    turn_deg: f64,
}

const WHITE_BOX: Block = Block { x: 0.95, z: 1.05, half: 0.4, height: 1.5, turn_deg: 33.0 };
const YELLOW_BOX: Block = Block { x: 2.2, z: 1.65, half: 0.36, height: 0.72, turn_deg: -36.0 };

pub(crate) fn model() -> Model {
    let mut m = Model::new(("m", 1.0), 0.1785);
    m.view("Room", [1.6, 1.42, 3.96], [1.6, 1.22, 0.0], 64.0);
    m.view("Red wall", [2.75, 1.5, 3.4], [0.6, 0.55, 1.0], 55.0);
    m.view("Blue wall", [0.35, 1.5, 3.6], [2.6, 0.6, 1.6], 55.0);
    let lamp = m.lamp("Ceiling lamp", Output::Coloured(4200.0, [1.0, 0.93, 0.82]), true);

    let DVec3 { x, y, z } = ROOM;
    m.object("floor").paint(&WHITE);
    let feet = [WHITE_BOX, YELLOW_BOX].map(|b| square(dvec3(b.x, 0.0, b.z), b.half, b.turn_deg));
    m.pierced(&rectangle([0.0, 0.0], [x, z], 0.0), &feet);
    m.object("ceiling");
    m.panel(dvec3(0.0, y, 0.0), (DVec3::X, x), (DVec3::Z, z), &[LAMP]);
    m.glow(lamp, 1.0, [0.75, 0.75, 0.74]);
    let [x0, x1, z0, z1] = LAMP;
    m.quad(dvec3(x0, y, z0), dvec3(x1 - x0, 0.0, 0.0), dvec3(0.0, 0.0, z1 - z0));

    m.object("back_wall").paint(&WHITE).wall(DVec3::ZERO, DVec3::X, x, y, &[]);
    m.object("front_wall").wall(dvec3(x, 0.0, z), -DVec3::X, x, y, &[]);
    m.object("red_wall").paint(&RED).wall(dvec3(0.0, 0.0, z), -DVec3::Z, z, y, &[]);
    m.object("blue_wall").paint(&BLUE).wall(dvec3(x, 0.0, 0.0), DVec3::Z, z, y, &[]);

    for (name, b, paint) in [("white_box", WHITE_BOX, &WHITE), ("yellow_box", YELLOW_BOX, &YELLOW)] {
        m.object(name).paint(paint);
        m.place([b.x, 0.0, b.z], b.turn_deg, |m| {
            m.block([-b.half, 0.0, -b.half], [b.half, b.height, b.half], Faces::STANDING);
        });
    }
    m
}
