//! Lamps of many kinds; each emits for the [`LampId`] it is given.

use super::palette::{BLACK, BRASS, DARK_FRAME, JOINERY, STEEL};
use crate::scene::builtin::shapes::{Faces, sphere};
use crate::scene::builtin::writer::{LampId, Model, Paint};
use glam::{DVec3, dvec3};

/// Reflectance of opal glass and of lamp shades.
const OPAL: [f64; 3] = [0.78, 0.78, 0.76];

/// A surface-mounted downlight, 1.5 cm deep, under a ceiling at y = 0.
pub(crate) fn downlight(m: &mut Model, lamp: LampId) {
    m.object("downlight_rims").paint(&JOINERY);
    m.lathe(DVec3::ZERO, &[(0.075, -0.015), (0.075, 0.0)], 8);
    m.lathe(DVec3::ZERO, &[(0.06, -0.015), (0.075, -0.015)], 8);
    m.glow(lamp, 1.0, OPAL).disc(dvec3(0.0, -0.015, 0.0), 0.06, 8, false);
}

/// A dome pendant: `drop` from the ceiling at y = 0 to the rim; the light leaves downwards, and a
/// little through the opening at the top.
pub(crate) fn dome_pendant(m: &mut Model, lamp: LampId, drop: f64, shade: &Paint) {
    m.place([0.0, -drop, 0.0], 0.0, |m| {
        m.object("pendant_shades").paint(shade);
        let outer = [(0.19, 0.0), (0.16, 0.09), (0.05, 0.18), (0.035, 0.23), (0.0, 0.23)];
        m.lathe(DVec3::ZERO, &outer, 12);
        m.paint(&JOINERY).lathe(DVec3::ZERO, &[(0.15, 0.05), (0.185, 0.0)], 12);
        m.lathe(DVec3::ZERO, &[(0.185, 0.0), (0.19, 0.0)], 12);
        m.object("pendant_cords").paint(&BLACK);
        m.bar(dvec3(0.0, 0.23, 0.0), dvec3(0.0, drop, 0.0), 0.012);
        m.glow(lamp, 1.0, OPAL).disc(dvec3(0.0, 0.05, 0.0), 0.15, 12, false);
    });
}

/// An opal globe of `radius` whose centre hangs `drop` below the ceiling at y = 0.
pub(crate) fn globe_pendant(m: &mut Model, lamp: LampId, drop: f64, radius: f64) {
    let (centre, sides) = (dvec3(0.0, -drop, 0.0), 14);
    let mut globe = sphere(radius, 8);
    globe.pop();
    m.object("pendant_cords").paint(&BRASS);
    // The cap takes the place of the globe's uppermost band.
    let rim = globe[globe.len() - 1];
    m.lathe(centre, &[rim, (0.3 * radius, 1.2 * radius), (0.0, 1.2 * radius)], sides);
    m.bar(dvec3(0.0, 1.2 * radius - drop, 0.0), DVec3::ZERO, 0.012);
    m.glow(lamp, 1.0, OPAL).lathe(centre, &globe, sides);
}

/// A drum shade around the origin: the fabric glows softly, the openings above and below brightly.
pub(crate) fn drum_shade(m: &mut Model, lamp: LampId, radius: f64, height: f64) {
    let y = 0.5 * height;
    m.glow(lamp, 1.0, OPAL).lathe(DVec3::ZERO, &[(radius, -y), (0.84 * radius, y)], 16);
    m.glow(lamp, 4.0, OPAL);
    m.disc(dvec3(0.0, y, 0.0), 0.84 * radius, 16, true);
    m.disc(dvec3(0.0, -y, 0.0), radius, 16, false);
}

/// A floor lamp of this height on y = 0.
pub(crate) fn floor_lamp(m: &mut Model, lamp: LampId, height: f64) {
    m.object("floor_lamp").paint(&BRASS);
    m.lathe(DVec3::ZERO, &[(0.15, 0.0), (0.15, 0.02), (0.03, 0.03), (0.0, 0.03)], 14);
    let shade = 0.34;
    m.bar(dvec3(0.0, 0.03, 0.0), dvec3(0.0, height - shade, 0.0), 0.022);
    m.place([0.0, height - 0.5 * shade, 0.0], 0.0, |m| drum_shade(m, lamp, 0.23, shade));
}

/// A table lamp on y = 0 with a ceramic body.
pub(crate) fn table_lamp(m: &mut Model, lamp: LampId, body: &Paint) {
    m.object("table_lamps").paint(body);
    let profile = [(0.05, 0.0), (0.075, 0.05), (0.06, 0.12), (0.02, 0.17), (0.015, 0.2)];
    m.lathe(DVec3::ZERO, &profile, 12);
    m.place([0.0, 0.29, 0.0], 0.0, |m| drum_shade(m, lamp, 0.13, 0.18));
}

/// A desk lamp on y = 0 whose arm reaches towards +x.
pub(crate) fn desk_lamp(m: &mut Model, lamp: LampId) {
    m.object("desk_lamp").paint(&BRASS);
    m.lathe(DVec3::ZERO, &[(0.085, 0.0), (0.085, 0.02), (0.0, 0.02)], 12);
    let (elbow, head) = (dvec3(-0.1, 0.32, 0.0), dvec3(0.2, 0.47, 0.0));
    // The arm stands on the base and comes down on the flat top of the shade.
    let cap = 0.012;
    let arm = [dvec3(0.0, 0.02, 0.0), elbow, head + 0.05 * DVec3::Y, head + cap * DVec3::Y];
    m.pipe(&arm, 0.015, [DVec3::Y; 2]);
    m.place(head.to_array(), 0.0, |m| {
        m.object("desk_lamp").paint(&BRASS);
        m.lathe(DVec3::ZERO, &[(0.09, -0.1), (0.045, 0.0), (0.022, cap), (0.0, cap)], 12);
        m.glow(lamp, 1.0, OPAL).disc(dvec3(0.0, -0.1, 0.0), 0.09, 12, false);
    });
}

/// A light strip along x, `length` long, on the underside of something at y = 0; it emits downwards.
pub(crate) fn strip(m: &mut Model, lamp: LampId, length: f64) {
    let x = 0.5 * length;
    m.object("strip_housings").paint(&STEEL);
    m.block([-x, -0.02, -0.02], [x, 0.0, 0.02], Faces::UPRIGHT);
    m.glow(lamp, 1.0, OPAL).quad(dvec3(-x, -0.02, -0.02), DVec3::X * length, DVec3::Z * 0.04);
}

/// A television centred on the origin, mounted on the wall z = 0: the screen, and a coloured
/// strip around its back that lights the wall.
pub(crate) fn television(m: &mut Model, screen: LampId, halo: LampId, [w, h]: [f64; 2]) {
    let (x, y, z0, z1, rim) = (0.5 * w, 0.5 * h, 0.06, 0.09, 0.012);
    m.object("television").paint(&BLACK);
    let (bx, by) = (x - 0.1, y - 0.1);
    m.block([-x, -y, z0], [x, y, z1], Faces::AROUND);
    let mount = [[0.1, w - 0.1, 0.1, h - 0.1]];
    m.panel(dvec3(x, -y, z0), (-DVec3::X, w), (DVec3::Y, h), &mount);
    m.panel(dvec3(-x, -y, z1), (DVec3::X, w), (DVec3::Y, h), &[[rim, w - rim, rim, h - rim]]);
    m.glow(screen, 1.0, [0.04; 3]);
    m.quad(dvec3(rim - x, rim - y, z1), DVec3::X * (w - 2.0 * rim), DVec3::Y * (h - 2.0 * rim));
    m.glow(halo, 1.0, OPAL);
    m.block([-bx, -by, 0.0], [bx, by, z0], Faces::AROUND);
}

/// A horizontal tube on the wall z = 0 over a mirror, `length` along x.
pub(crate) fn wall_tube(m: &mut Model, lamp: LampId, length: f64) {
    let x = 0.5 * length;
    m.object("wall_tube_mounts").paint(&DARK_FRAME);
    m.block([-0.06, -0.02, 0.0], [0.06, 0.02, 0.05], Faces::AROUND);
    m.glow(lamp, 1.0, OPAL);
    m.block([-x, -0.025, 0.05], [x, 0.025, 0.1], Faces::ALL);
}

/// A flat opal disc luminaire under a ceiling at y = 0: light from its rim and underside.
pub(crate) fn ceiling_disc(m: &mut Model, lamp: LampId, radius: f64) {
    m.glow(lamp, 1.0, OPAL);
    m.lathe(DVec3::ZERO, &[(radius, -0.08), (radius, 0.0)], 16);
    m.disc(dvec3(0.0, -0.08, 0.0), radius, 16, false);
}
