//! The study.

use super::furniture::{book_stack, bookshelf, chair, picture, table};
use super::lamps::{desk_lamp, dome_pendant};
use super::palette::{BLACK, BRASS, CHARCOAL, DARK_FRAME, MUSTARD, OAK, PAPER, RUST, SAGE_FRONT, WALNUT};
use super::plants::plant_between;
use super::shell::HEIGHT;
use super::textiles::{armchair, throw_cushion};
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{Model, Output};
use glam::dvec3;

pub(crate) fn study(m: &mut Model) {
    let desk = m.lamp("Desk lamp", Output::White(650.0, 5500.0), true);
    let pendant = m.lamp("Study pendant", Output::White(1600.0, 4400.0), true);
    m.place([1.55, HEIGHT, 1.6], 0.0, |m| dome_pendant(m, pendant, 0.7, &BRASS));

    // The desk stands under the west window.
    m.place([0.39, 0.0, 1.4], 90.0, |m| {
        m.object("desk");
        table(m, [1.6, 0.74, 0.7], 0.04, &WALNUT, &BLACK);
        m.place([0.58, 0.74, -0.16], -35.0, |m| desk_lamp(m, desk));
        m.object("monitor").paint(&BLACK);
        m.block([-0.31, 0.86, -0.2], [0.31, 1.22, -0.175], Faces::ALL);
        m.block([-0.03, 0.75, -0.225], [0.03, 1.0, -0.205], Faces::STANDING);
        m.block([-0.12, 0.74, -0.26], [0.12, 0.75, -0.08], Faces::STANDING);
        m.paint(&CHARCOAL).block([-0.2, 0.74, 0.05], [0.2, 0.755, 0.18], Faces::STANDING);
        m.paint(&PAPER);
        m.place([0.42, 0.74, 0.12], 14.0, |m| {
            m.block([-0.105, 0.0, -0.15], [0.105, 0.012, 0.15], Faces::STANDING)
        });
        m.place([-0.58, 0.74, 0.0], 80.0, |m| book_stack(m, 0.0));
    });
    m.object("desk_chair");
    m.place([1.12, 0.0, 1.42], -76.0, |m| chair(m, &BLACK, &RUST));
    m.place([1.85, 0.0, 0.0], 0.0, |m| {
        m.object("shelves");
        bookshelf(m, [1.25, 2.15, 0.28], 6, &OAK, 5);
    });
    m.place([2.6, 0.0, 0.0], 0.0, low_shelf);
    // In the corner beside the desk: two walls, the desk's top and leg, the shelves.
    let taken = [
        [[-9.0, 0.0, -9.0], [-0.62, 9.0, 9.0]],
        [[-9.0, 0.0, -9.0], [9.0, 9.0, -0.42]],
        [[-0.58, 0.71, 0.18], [0.12, 0.74, 1.0]],
        [[0.03, 0.0, 0.22], [0.08, 0.71, 0.27]],
        [[0.605, 0.0, -9.0], [9.0, 9.0, -0.14]],
    ];
    m.place([0.62, 0.0, 0.42], 0.0, |m| plant_between(m, 1.25, 15, 17, &taken));
    m.place([0.42, 0.0, 3.02], 135.0, |m| {
        m.place([0.0, 0.0, 0.28], 0.0, |m| {
            armchair(m, &SAGE_FRONT, &WALNUT);
            m.place([0.02, 0.44, 0.17], 5.0, |m| throw_cushion(m, &MUSTARD));
        });
    });
    m.place([3.2, 1.5, 1.3], -90.0, |m| picture(m, [0.9, 0.7], &DARK_FRAME, 1));
}

/// A waist-high cupboard beside the tall shelves, with a globe on it.
fn low_shelf(m: &mut Model) {
    m.object("study_cupboard");
    super::furniture::cabinet(m, [0.24, 0.8, 0.28], 1, &OAK, &OAK);
    m.object("study_globe").paint(&BRASS);
    m.bar(dvec3(0.0, 0.8, 0.14), dvec3(0.0, 0.86, 0.14), 0.03);
    m.paint(&SAGE_FRONT).ball(dvec3(0.0, 0.96, 0.14), 0.1, 6, 12);
}
