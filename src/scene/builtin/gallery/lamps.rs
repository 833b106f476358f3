//! The gallery's lamps.

use super::works::BAYS;
use super::{AISLE_CEILING, BEAM, FRAME, HALL, LENGTH, NAVE, SPRINGING, STONE};
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{LampId, Model, Output};
use glam::{DVec3, dvec3};

/// Underside and top of the coves along the beams, half their length, metres.
pub(super) const COVE: [f64; 2] = [2.86, 2.94];
pub(super) const COVE_RUN: f64 = LENGTH - 0.5;
/// Distance of the spots from the hall's middle, radius of their housings, metres.
pub(super) const SPOT_AXIS: f64 = 0.5 * (NAVE + BEAM + HALL) + 0.12;
pub(super) const SPOT_RADIUS: f64 = 0.09;
/// The light box on the north wall: half its width, foot and head, metres.
pub(super) const LIGHT_BOX: [f64; 3] = [0.7, 0.25, 2.45];

pub(super) fn lamps(m: &mut Model) {
    // Coves on the nave side of the beams wash the vault from hidden strips.
    let cove = m.lamp("Vault coves", Output::White(9000.0, 5000.0), true);
    for side in [-1.0, 1.0] {
        let inner = side * (NAVE - 0.16);
        m.object("coves").paint(&STONE);
        let (x0, x1) = if side < 0.0 { (-NAVE, inner) } else { (inner, NAVE) };
        let (run, [low, high]) = (COVE_RUN, COVE);
        let to_beam = if side < 0.0 { Faces::LEFT } else { Faces::RIGHT };
        m.block([x0, low, -run], [x1, high, run], Faces::ALL.without(to_beam).without(Faces::TOP));
        // A lip hides the strip from the eye below.
        let (l0, l1) = if side < 0.0 { (inner - 0.02, inner) } else { (inner, inner + 0.02) };
        m.block([l0, high, -run], [l1, 3.02, run], Faces::STANDING);
        let (s0, s1) = if side < 0.0 { (x0, l0) } else { (l1, x1) };
        m.glow(cove, 1.0, [0.6; 3]);
        m.quad(dvec3(s0, high, run), DVec3::X * (s1 - s0), -DVec3::Z * (2.0 * run));
    }

    let spot = |m: &mut Model, lamp: LampId, x: f64, z: f64, ceiling: f64| {
        m.place([x, ceiling, z], 0.0, |m| {
            m.object("spot_housings").paint(&FRAME);
            m.lathe(DVec3::ZERO, &[(SPOT_RADIUS, -0.24), (SPOT_RADIUS, 0.0)], 12);
            m.lathe(DVec3::ZERO, &[(0.085, -0.16), (0.085, -0.24)], 12);
            m.lathe(DVec3::ZERO, &[(0.085, -0.24), (SPOT_RADIUS, -0.24)], 12);
            m.glow(lamp, 1.0, [0.5; 3]).disc(dvec3(0.0, -0.16, 0.0), 0.085, 12, false);
        });
    };
    let west = m.lamp("West picture spots", Output::White(3000.0, 5000.0), true);
    let east = m.lamp("East picture spots", Output::White(3000.0, 5000.0), true);
    for z in BAYS {
        spot(m, west, -SPOT_AXIS, z, AISLE_CEILING);
        spot(m, east, SPOT_AXIS, z, AISLE_CEILING);
    }

    // Pendant discs under the vault, over the works.
    let pendants = m.lamp("Nave pendants", Output::White(5200.0, 5500.0), true);
    for z in [-4.2, -1.25, 1.6] {
        m.place([0.0, 2.95, z], 0.0, |m| {
            m.object("pendant_bodies").paint(&FRAME);
            m.lathe(DVec3::ZERO, &[(0.28, 0.0), (0.28, 0.05)], 16);
            m.disc(dvec3(0.0, 0.05, 0.0), 0.28, 16, true);
            // A rod that ends a millimetre short of the disc and of the vault.
            let top = SPRINGING + NAVE - 2.952;
            m.block([-0.006, 0.051, -0.006], [0.006, top, 0.006], Faces::ALL);
            m.glow(pendants, 1.0, [0.7; 3]).disc(DVec3::ZERO, 0.28, 16, false);
        });
    }

    // An upright light box behind the vase at the end of the nave.
    let screen = m.lamp("Apse light wall", Output::Coloured(1500.0, [1.0, 0.55, 0.28]), true);
    m.object("apse_light_frame").paint(&FRAME);
    let ([w, y0, y1], z) = (LIGHT_BOX, -LENGTH);
    m.block([-w, y0, z], [w, y1, z + 0.08], Faces::AROUND);
    m.panel(
        dvec3(-w, y0, z + 0.08),
        (DVec3::X, 2.0 * w),
        (DVec3::Y, y1 - y0),
        &[[0.04, 2.0 * w - 0.04, 0.04, y1 - y0 - 0.04]],
    );
    m.glow(screen, 1.0, [0.7; 3]);
    m.quad(dvec3(-w + 0.04, y0 + 0.04, z + 0.08), DVec3::X * (2.0 * w - 0.08), DVec3::Y * (y1 - y0 - 0.08));
}
