//! The bathroom.

use super::furniture::{cabinet, tap};
use super::lamps::{downlight, wall_tube};
use super::palette::{BRASS, CERAMIC, DARK_FRAME, LINEN, OAK, RUST, STEEL};
use super::plants::plant_between;
use super::shell::HEIGHT;
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{Model, Output};
use glam::{DVec3, dvec3};

pub(crate) fn bathroom(m: &mut Model) {
    let downlights = m.lamp("Bathroom downlights", Output::White(1700.0, 5000.0), true);
    let tube = m.lamp("Bathroom mirror light", Output::White(900.0, 6500.0), true);
    for [x, z] in [[7.9, 0.95], [7.9, 2.2]] {
        m.place([x, HEIGHT, z], 0.0, |m| downlight(m, downlights));
    }
    tub(m);
    // In the corner, with the bath on its other side.
    let taken = [
        [[0.26, 0.0, -9.0], [9.0; 3]],
        [[-9.0, 0.0, -9.0], [9.0, 9.0, -0.4]],
        [[-9.0, 0.0, -9.0], [-0.26, 0.56, 0.35]],
    ];
    m.place([8.98, 0.0, 0.4], 0.0, |m| plant_between(m, 0.95, 14, 41, &taken));

    let east = 9.24;
    m.place([east, 0.0, 1.85], -90.0, |m| {
        m.object("vanity");
        cabinet(m, [1.15, 0.78, 0.46], 2, &OAK, &CERAMIC);
        let (x, z0, z1, y) = (0.24, 0.08, 0.4, 0.78);
        m.object("washbasin").paint(&CERAMIC);
        m.block([-x, y, z0], [x, y + 0.13, z1], Faces::UPRIGHT);
        let rim = 0.015;
        m.panel(
            dvec3(-x, y + 0.13, z1),
            (DVec3::X, 2.0 * x),
            (-DVec3::Z, z1 - z0),
            &[[rim, 2.0 * x - rim, rim, z1 - z0 - rim]],
        );
        m.basin([rim - x, y + 0.02, z0 + rim], [x - rim, y + 0.13, z1 - rim], 0.04);
        m.object("taps").paint(&BRASS);
        m.place([0.0, y, 0.045], 0.0, |m| tap(m, 0.23, 0.135));
    });
    m.place([east, 1.5, 1.85], -90.0, |m| super::entrance::mirror(m, [1.0, 0.8], &DARK_FRAME));
    m.place([east, 2.02, 1.85], -90.0, |m| wall_tube(m, tube, 0.8));

    m.place([7.04, 0.0, 1.75], 90.0, toilet);
    // Towels over a rail on the south wall, beside the door.
    m.place([8.72, 0.0, 3.2], 180.0, |m| {
        m.object("towel_rail").paint(&STEEL);
        for y in [0.98, 1.45] {
            m.block([-0.36, y, 0.07], [0.36, y + 0.02, 0.09], Faces::ALL);
        }
        for (x0, x1, y, paint) in [(-0.3, 0.05, 1.45, &RUST), (-0.05, 0.3, 0.98, &LINEN)] {
            m.object("towels").paint(paint);
            m.block([x0, y - 0.42, 0.095], [x1, y + 0.035, 0.115], Faces::ALL);
        }
    });
}

/// A bath between the west wall and a low shelf, against the north wall.
fn tub(m: &mut Model) {
    let (x0, x1, z1, y) = (7.04, 8.72, 0.75, 0.56);
    m.object("bath_tub").paint(&CERAMIC);
    m.wall(dvec3(x0, 0.0, z1), DVec3::X, x1 - x0, y, &[]);
    m.wall(dvec3(x1, 0.0, z1), -DVec3::Z, z1, y, &[]);
    let rim = 0.07;
    m.panel(dvec3(x0, y, z1), (DVec3::X, x1 - x0), (-DVec3::Z, z1), &[[rim, x1 - x0 - rim, rim, z1 - rim]]);
    m.basin([x0 + rim, 0.14, rim], [x1 - rim, y, z1 - rim], 0.09);
    m.object("taps").paint(&BRASS);
    let spout = [dvec3(7.9, 0.82, 0.0), dvec3(7.9, 0.82, 0.15), dvec3(7.9, 0.77, 0.15)];
    let end = m.pipe(&spout, 0.03, [DVec3::Z, DVec3::Y]);
    m.polygon(&end);
}

/// A toilet with its cistern against the wall z = 0.
fn toilet(m: &mut Model) {
    m.object("toilet").paint(&CERAMIC);
    m.block([-0.19, 0.38, 0.0], [0.19, 0.8, 0.16], Faces::ALL.without(Faces::BACK));
    m.block([-0.12, 0.0, 0.0], [0.12, 0.38, 0.16], Faces::UPRIGHT.without(Faces::BACK));
    m.lathe(dvec3(0.0, 0.0, 0.41), &[(0.13, 0.0), (0.13, 0.12), (0.2, 0.36), (0.2, 0.41)], 14);
    m.disc(dvec3(0.0, 0.41, 0.41), 0.2, 14, true);
}
