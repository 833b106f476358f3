//! The bedroom.

use super::furniture::{bed, book_stack, cabinet, picture, vase};
use super::lamps::{ceiling_disc, table_lamp};
use super::palette::{BLUE_WOOL, BRASS, CERAMIC, DARK_FRAME, JOINERY, MUSTARD, OAK, WALNUT};
use super::plants::plant_between;
use super::shell::HEIGHT;
use super::textiles::curtains;
use crate::scene::builtin::writer::{Model, Output, Paint};

pub(crate) fn bedroom(m: &mut Model) {
    let left = m.lamp("Bedside lamp left", Output::White(750.0, 3400.0), true);
    let right = m.lamp("Bedside lamp right", Output::White(750.0, 3400.0), true);
    let ceiling = m.lamp("Bedroom ceiling lamp", Output::White(1800.0, 5000.0), false);
    m.place([4.9, HEIGHT, 1.6], 0.0, |m| ceiling_disc(m, ceiling, 0.24));

    let east = 6.92;
    m.place([east, 0.0, 1.6], -90.0, |m| bed(m, [1.6, 2.05], &WALNUT, &BLUE_WOOL));
    m.place([east, 1.62, 1.6], -90.0, |m| picture(m, [1.2, 0.62], &DARK_FRAME, 0));
    for (z, lamp) in [(0.45, left), (2.76, right)] {
        m.place([east, 0.0, z], -90.0, |m| {
            m.object("nightstands");
            cabinet(m, [0.44, 0.48, 0.38], 1, &WALNUT, &WALNUT);
            m.place([0.0, 0.48, 0.16], 0.0, |m| table_lamp(m, lamp, &CERAMIC));
        });
    }
    m.place([3.32, 0.0, 1.15], 90.0, |m| {
        m.object("wardrobe");
        cabinet(m, [2.0, 2.2, 0.58], 4, &JOINERY, &JOINERY);
    });
    m.place([5.55, 0.0, 3.2], 180.0, |m| {
        m.object("chest_of_drawers");
        cabinet(m, [1.2, 0.8, 0.44], 3, &OAK, &OAK);
        m.place([-0.35, 0.8, 0.2], 0.0, |m| {
            plant_between(m, 0.6, 14, 31, &[[[-9.0, 0.0, -9.0], [9.0, 9.0, -0.17]]])
        });
        m.place([0.1, 0.8, 0.22], 10.0, |m| book_stack(m, 0.0));
        m.place([0.42, 0.8, 0.2], 0.0, |m| vase(m, &MUSTARD_GLAZE, 0.8));
    });
    m.place([5.55, 1.5, 3.2], 180.0, |m| super::entrance::mirror(m, [0.6, 0.75], &BRASS));
    m.place([4.2, 0.0, 0.0], 0.0, |m| curtains(m, 1.8, 0.03, 2.32, 0.42));
}

const MUSTARD_GLAZE: Paint = Paint::solid("mustard_glaze", MUSTARD.reflectance);
