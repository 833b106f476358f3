//! The entrance hall.

use super::furniture::{bowl, cabinet, picture, table, vase};
use super::lamps::downlight;
use super::palette::{BRASS, CERAMIC, CHARCOAL, DARK_FRAME, MIRROR, MUSTARD, OAK, RUST, SAGE_FRONT, WALNUT};
use super::plants::plant_between;
use super::shell::HEIGHT;
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{Model, Output, Paint};
use glam::{DVec3, dvec3};

pub(crate) fn hall(m: &mut Model) {
    let lights = m.lamp("Entrance downlights", Output::White(2000.0, 4800.0), true);
    for z in [0.8, 2.2, 3.6] {
        m.place([10.5, HEIGHT, z], 0.0, |m| downlight(m, lights));
    }
    // The focal wall opposite the front door.
    m.place([10.75, 0.0, 4.21], 0.0, |m| {
        m.object("hall_console");
        table(m, [1.15, 0.82, 0.36], 0.03, &WALNUT, &BRASS);
        m.place([-0.35, 0.82, 0.0], 0.0, |m| vase(m, &CERAMIC, 1.25));
        m.place([0.32, 0.82, 0.0], 0.0, |m| bowl(m, &BRASS, 0.14));
    });
    m.place([10.75, 1.6, 4.4], 180.0, |m| mirror(m, [0.8, 1.0], &BRASS));
    m.place([9.36, 1.55, 1.9], 90.0, |m| picture(m, [0.9, 0.65], &OAK, 2));
    m.place([9.68, 0.0, 2.95], 0.0, |m| {
        plant_between(m, 1.15, 15, 21, &[[[-9.0, 0.0, -9.0], [-0.32, 9.0, 9.0]]])
    });

    m.place([11.6, 0.0, 1.2], -90.0, |m| {
        m.object("hall_bench");
        cabinet(m, [1.3, 0.46, 0.38], 3, &OAK, &OAK);
        m.paint(&MUSTARD).cushion([-0.62, 0.46, 0.03], [0.1, 0.51, 0.36], 0.02);
        m.object("coat_rack").paint(&OAK);
        m.block([-0.65, 1.62, 0.0], [0.65, 1.74, 0.02], Faces::ALL.without(Faces::BACK));
        for (x, paint) in [(-0.46, &CHARCOAL), (-0.08, &RUST), (0.34, &SAGE_FRONT)] {
            m.object("coat_rack").paint(&DARK_FRAME);
            m.block([x - 0.012, 1.66, 0.02], [x + 0.012, 1.685, 0.1], Faces::ALL.without(Faces::BACK));
            coat(m, x, paint);
        }
    });
}

/// A coat on a hook of the rack: a shoulder line that widens towards the hem.
fn coat(m: &mut Model, x: f64, paint: &Paint) {
    m.object("coats").paint(paint);
    let ring = |y: f64, half: f64, z0: f64, z1: f64| {
        [dvec3(x - half, y, z1), dvec3(x + half, y, z1), dvec3(x + half, y, z0), dvec3(x - half, y, z0)]
    };
    let rings = [
        ring(0.78, 0.17, 0.035, 0.2),
        ring(1.35, 0.145, 0.03, 0.17),
        ring(1.54, 0.12, 0.025, 0.13),
        ring(1.655, 0.04, 0.03, 0.09),
    ];
    for pair in rings.windows(2) {
        for k in 0..4 {
            let next = (k + 1) % 4;
            m.polygon(&[pair[0][k], pair[0][next], pair[1][next], pair[1][k]]);
        }
    }
    let hem = rings[0];
    m.polygon(&[hem[3], hem[2], hem[1], hem[0]]);
    m.polygon(&rings[3]);
}

/// A framed looking glass around the origin, on the wall z = 0: bright and diffuse.
pub(crate) fn mirror(m: &mut Model, [w, h]: [f64; 2], frame: &Paint) {
    let (x, y, d, rim) = (0.5 * w, 0.5 * h, 0.025, 0.025);
    m.object("mirrors").paint(frame);
    m.block([-x, -y, 0.0], [x, y, d], Faces::AROUND);
    m.panel(dvec3(-x, -y, d), (DVec3::X, w), (DVec3::Y, h), &[[rim, w - rim, rim, h - rim]]);
    m.paint(&MIRROR);
    m.quad(dvec3(rim - x, rim - y, d), DVec3::X * (w - 2.0 * rim), DVec3::Y * (h - 2.0 * rim));
}
