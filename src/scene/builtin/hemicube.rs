//! A closed room after the picture of Cohen and Greenberg 1985: one red wall, one blue, two boxes.

use super::shapes::Faces;
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

pub(crate) fn model() -> Model {
    let mut m = Model::new(("m", 1.0), 0.18);
    m.view("Room", [1.6, 1.42, 3.96], [1.6, 1.22, 0.0], 64.0);
    m.view("Red wall", [2.75, 1.5, 3.4], [0.6, 0.55, 1.0], 55.0);
    m.view("Blue wall", [0.35, 1.5, 3.6], [2.6, 0.6, 1.6], 55.0);
    let lamp = m.lamp("Ceiling lamp", Output::Coloured(4200.0, [1.0, 0.93, 0.82]), true);

    let DVec3 { x, y, z } = ROOM;
    m.object("floor").paint(&WHITE);
    m.quad(dvec3(0.0, 0.0, z), dvec3(x, 0.0, 0.0), dvec3(0.0, 0.0, -z));
    m.object("ceiling");
    m.panel(dvec3(0.0, y, 0.0), (DVec3::X, x), (DVec3::Z, z), &[LAMP]);
    m.glow(lamp, 1.0, [0.75, 0.75, 0.74]);
    let [x0, x1, z0, z1] = LAMP;
    m.quad(dvec3(x0, y, z0), dvec3(x1 - x0, 0.0, 0.0), dvec3(0.0, 0.0, z1 - z0));

    m.object("back_wall").paint(&WHITE).wall(DVec3::ZERO, DVec3::X, x, y, &[]);
    m.object("front_wall").wall(dvec3(x, 0.0, z), -DVec3::X, x, y, &[]);
    m.object("red_wall").paint(&RED).wall(dvec3(0.0, 0.0, z), -DVec3::Z, z, y, &[]);
    m.object("blue_wall").paint(&BLUE).wall(dvec3(x, 0.0, 0.0), DVec3::Z, z, y, &[]);

    m.object("white_box").paint(&WHITE);
    m.place([0.95, 0.0, 1.05], 33.0, |m| {
        m.block([-0.4, 0.0, -0.4], [0.4, 1.5, 0.4], Faces::STANDING);
    });
    m.object("yellow_box").paint(&YELLOW);
    m.place([2.2, 0.0, 1.65], -36.0, |m| {
        m.block([-0.36, 0.0, -0.36], [0.36, 0.72, 0.36], Faces::STANDING);
    });
    m
}
