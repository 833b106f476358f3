//! Upholstery and curtains.

use super::palette::{CURTAIN, DARK_FRAME};
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{Model, Paint};
use glam::{DVec3, dvec3};

/// A sofa of `width` with its back at z = 0, `seats` seat cushions, and arms.
pub(crate) fn sofa(m: &mut Model, width: f64, seats: usize, depth: f64, paint: &Paint) {
    let (x, arm) = (0.5 * width, 0.16);
    let inner = x - arm;
    m.object("sofas").paint(paint);
    for left in [-x, inner] {
        m.cushion([left, 0.05, 0.0], [left + arm, 0.56, depth], 0.03);
    }
    // A hair's breadth off the arms, above which it rises.
    m.cushion([0.002 - inner, 0.05, 0.0], [inner - 0.002, 0.74, 0.18], 0.04);
    m.block([-inner, 0.05, 0.18], [inner, 0.25, depth], Faces::FRONT.and(Faces::TOP));
    let pitch = 2.0 * inner / seats as f64;
    for k in 0..seats {
        let (x0, x1) = (-inner + pitch * k as f64 + 0.008, -inner + pitch * (k + 1) as f64 - 0.008);
        m.cushion([x0, 0.25, 0.20], [x1, 0.43, depth - 0.01], 0.035);
        m.cushion([x0, 0.43, 0.20], [x1, 0.80, 0.36], 0.05);
    }
    m.paint(&DARK_FRAME).block([-x + 0.08, 0.0, 0.08], [x - 0.08, 0.05, depth - 0.1], Faces::UPRIGHT);
    // The undersides of the body beyond the plinth.
    let underside = [[0.08, width - 0.08, 0.08, depth - 0.1]];
    m.panel(dvec3(-x, 0.05, 0.0), (DVec3::X, width), (DVec3::Z, depth), &underside);
}

/// A loose cushion that stands on y = 0 and leans on what is behind it at z = 0.
pub(crate) fn throw_cushion(m: &mut Model, paint: &Paint) {
    m.object("throw_cushions").paint(paint);
    let (size, lean, thick): (f64, f64, f64) = (0.4, 0.1, 0.07);
    let up = dvec3(0.0, (size * size - lean * lean).sqrt(), -lean);
    let out = dvec3(0.0, lean, up.y).normalize();
    let corner = |u: f64, v: f64, w: f64| dvec3(u * size, 0.0, lean + 0.01) + up * v + out * (w * thick);
    // A pillow: a rim between two domes of four triangles each.
    let rim = [corner(-0.5, 0.0, 0.5), corner(0.5, 0.0, 0.5), corner(0.5, 1.0, 0.5), corner(-0.5, 1.0, 0.5)];
    let (front, back) = (corner(0.0, 0.5, 1.6), corner(0.0, 0.5, 0.0));
    for k in 0..4 {
        let (a, b) = (rim[k], rim[(k + 1) % 4]);
        m.polygon(&[a, b, front]);
        m.polygon(&[b, a, back]);
    }
}

/// A curtain in folds: from x = 0 to `width`, hanging from `top` to `foot` around z = 0.
pub(crate) fn curtain(m: &mut Model, width: f64, foot: f64, top: f64, folds: usize) {
    m.object("curtains").paint(&CURTAIN);
    let at = |k: usize| {
        let z = if k.is_multiple_of(2) { -0.035 } else { 0.035 };
        dvec3(width * k as f64 / (2 * folds) as f64, foot, z)
    };
    for k in 0..2 * folds {
        let (a, b) = (at(k), at(k + 1));
        m.quad(a, b - a, DVec3::Y * (top - foot));
    }
}

/// A curtain rail with a pair of drawn curtains for a window of `width` whose left edge is at
/// x = 0, on the wall z = 0 and facing +z.
pub(crate) fn curtains(m: &mut Model, width: f64, foot: f64, top: f64, drawn: f64) {
    let (z, over) = (0.09, 0.25);
    m.place([-over, 0.0, z], 0.0, |m| curtain(m, drawn, foot, top - 0.02, 3));
    m.place([width + over - drawn, 0.0, z], 0.0, |m| curtain(m, drawn, foot, top - 0.02, 3));
    m.object("curtain_rails").paint(&DARK_FRAME);
    m.block(
        [-over - 0.08, top + 0.03, z - 0.012],
        [width + over + 0.08, top + 0.054, z + 0.012],
        Faces::ALL.without(Faces::BACK),
    );
}

/// An armchair with its back at z = 0.
pub(crate) fn armchair(m: &mut Model, body: &Paint, legs: &Paint) {
    m.object("armchair").paint(body);
    for left in [-0.38, 0.26] {
        m.cushion([left, 0.14, 0.0], [left + 0.12, 0.58, 0.78], 0.03);
    }
    m.cushion([-0.258, 0.14, 0.0], [0.258, 0.86, 0.16], 0.05);
    m.block([-0.26, 0.14, 0.16], [0.26, 0.27, 0.78], Faces::FRONT.and(Faces::TOP));
    m.cushion([-0.25, 0.27, 0.17], [0.25, 0.44, 0.77], 0.04);
    m.quad(dvec3(-0.38, 0.14, 0.0), DVec3::X * 0.76, DVec3::Z * 0.78);
    m.paint(legs);
    for (x, z) in [(-0.34, 0.04), (0.30, 0.04), (-0.34, 0.70), (0.30, 0.70)] {
        m.block([x, 0.0, z], [x + 0.04, 0.14, z + 0.04], Faces::UPRIGHT);
    }
}
