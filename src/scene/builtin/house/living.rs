//! The sunken living room and the gallery along it.

use super::furniture::{book_stack, bookshelf, bowl, cabinet, picture, table, vase};
use super::lamps::{downlight, floor_lamp, television};
use super::palette::{BLUE_WOOL, BRASS, CERAMIC, DARK_FRAME, MUSTARD, OAK, POT, RUST, SOFA, WALNUT};
use super::plan::{PIT, SOUTH};
use super::plants::{plant, plant_between};
use super::shell::HEIGHT;
use super::textiles::{armchair, curtains, sofa, throw_cushion};
use crate::scene::builtin::writer::{Model, Output};
use glam::{DVec3, dvec3};

pub(crate) fn living_room(m: &mut Model) {
    let floor_light = m.lamp("Living room floor lamp", Output::White(2000.0, 4000.0), true);
    let screen = m.lamp("Television", Output::Coloured(150.0, [0.35, 0.58, 1.0]), true);
    let halo = m.lamp("Television accent strip", Output::Coloured(420.0, [0.42, 0.16, 1.0]), true);

    m.place([2.5, PIT, SOUTH - 0.24], 180.0, |m| {
        sofa(m, 2.5, 3, 0.92, &SOFA);
        for (x, turn, paint) in [(-0.86, 6.0, &MUSTARD), (-0.39, -5.0, &RUST), (0.88, -7.0, &MUSTARD)] {
            m.place([x, 0.43, 0.375], turn, |m| throw_cushion(m, paint));
        }
    });
    m.place([0.95, PIT, 5.55], 52.0, |m| armchair(m, &RUST, &WALNUT));
    m.place([2.55, PIT, 6.5], 0.0, |m| {
        m.object("coffee_table");
        table(m, [1.1, 0.38, 0.6], 0.04, &WALNUT, &DARK_FRAME);
        m.place([-0.25, 0.38, 0.03], 12.0, |m| book_stack(m, 0.0));
        m.place([0.28, 0.38, -0.05], 0.0, |m| bowl(m, &CERAMIC, 0.15));
    });
    m.place([0.5, PIT, 7.85], 0.0, |m| floor_lamp(m, floor_light, 1.62));
    // Between the curtain and the edge of the upper floor.
    let taken = [[[-9.0, 0.0, 0.5], [9.0, 9.0, 9.0]], [[0.58, 0.0, -9.0], [9.0, -PIT, 9.0]]];
    m.place([4.62, PIT, 7.75], 0.0, |m| plant_between(m, 1.5, 18, 7, &taken));
    m.place([0.0, PIT, 6.6], 90.0, |m| {
        m.object("media_board");
        cabinet(m, [1.9, 0.42, 0.4], 3, &OAK, &OAK);
        m.place([0.78, 0.42, 0.2], 0.0, |m| vase(m, &RUST, 0.9));
    });
    m.place([0.0, 0.68, 6.6], 90.0, |m| television(m, screen, halo, [1.5, 0.86]));
    m.place([4.4, 0.0, SOUTH], 180.0, |m| curtains(m, 3.6, PIT + 0.03, 2.36, 0.75));
}

pub(crate) fn gallery(m: &mut Model) {
    let lights = m.lamp("Gallery downlights", Output::White(2500.0, 5000.0), true);
    for x in [1.2, 3.3, 5.4, 7.5] {
        m.place([x, HEIGHT, 3.86], 0.0, |m| downlight(m, lights));
    }
    // Low shelves guard the edge of the sunken floor; their back closes them towards it.
    m.place([1.75, 0.0, 4.57], 180.0, |m| {
        let (w, h) = (2.5, 0.76);
        m.object("shelves");
        bookshelf(m, [w, h, 0.3], 2, &OAK, 11);
        m.object("shelves").paint(&OAK).wall(dvec3(0.5 * w, 0.0, 0.0), -DVec3::X, w, h, &[]);
        m.place([-0.95, h, 0.15], 0.0, |m| plant(m, 0.5, 12, 3));
        m.place([0.2, h, 0.15], 0.0, |m| vase(m, &CERAMIC, 1.1));
        m.place([0.62, h, 0.15], 30.0, |m| book_stack(m, 5.0));
    });
    for (k, x) in [5.15, 5.87, 6.59].into_iter().enumerate() {
        m.place([x, 1.52, 3.32], 0.0, |m| picture(m, [0.56, 0.76], &DARK_FRAME, k));
    }
    m.place([5.87, 0.0, 3.32], 0.0, |m| {
        m.object("gallery_console");
        cabinet(m, [1.5, 0.72, 0.34], 4, &WALNUT, &WALNUT);
        m.place([-0.5, 0.72, 0.17], 0.0, |m| vase(m, &POT, 1.0));
        m.place([0.35, 0.72, 0.17], 0.0, |m| bowl(m, &BRASS, 0.13));
    });
    m.place([1.05, 1.5, 3.32], 0.0, |m| picture(m, [1.2, 0.8], &OAK, 1));
    m.place([3.25, 1.55, 3.32], 0.0, |m| picture(m, [0.42, 0.56], &OAK, 3));
    m.place([1.05, 0.0, 3.53], 0.0, |m| {
        m.object("gallery_bench");
        table(m, [1.1, 0.44, 0.36], 0.03, &WALNUT, &DARK_FRAME);
        m.object("throw_cushions").paint(&BLUE_WOOL);
        m.cushion([-0.5, 0.44, -0.16], [0.0, 0.5, 0.16], 0.025);
    });
}
