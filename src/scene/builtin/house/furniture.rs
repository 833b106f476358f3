//! Furniture that several rooms share. Pieces stand on y = 0 around x = 0; those that belong to
//! a wall have it at z = 0 behind them and face +z.

use super::palette::{
    BLUE_WOOL, BRASS, CERAMIC, CHARCOAL, CREAM, DARK_FRAME, LEAF, LINEN, MUSTARD, PAPER, RUST, SAGE_FRONT,
    SOIL,
};
use crate::scene::builtin::shapes::Faces;
use crate::scene::builtin::writer::{Model, Paint};
use glam::{DVec3, dvec3};

/// A table: size along x, height, size along z; the top overhangs its four legs by `inset`.
pub(crate) fn table(m: &mut Model, [w, h, d]: [f64; 3], inset: f64, top: &Paint, legs: &Paint) {
    let (x, z, board, leg) = (0.5 * w, 0.5 * d, 0.03, 0.05);
    m.paint(top).block([-x, h - board, -z], [x, h, z], Faces::ALL);
    m.paint(legs);
    for (sx, sz) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let (cx, cz) = (sx * (x - inset - 0.5 * leg), sz * (z - inset - 0.5 * leg));
        let half = 0.5 * leg;
        m.block([cx - half, 0.0, cz - half], [cx + half, h - board, cz + half], Faces::UPRIGHT);
    }
}

/// A dining chair that faces +z.
pub(crate) fn chair(m: &mut Model, frame: &Paint, seat: &Paint) {
    let (half, leg, y) = (0.21, 0.035, 0.44);
    m.paint(frame);
    for (x, z) in [(-half, half - leg), (half - leg, half - leg), (-half, -half), (half - leg, -half)] {
        m.block([x, 0.0, z], [x + leg, y, z + leg], Faces::UPRIGHT);
    }
    m.paint(seat).block([-half - 0.01, y, -half - 0.01], [half + 0.01, y + 0.04, half + 0.01], Faces::ALL);
    m.paint(frame);
    for x in [-half, half - leg] {
        m.block([x, y + 0.04, -half], [x + leg, 0.86, -half + leg], Faces::STANDING);
    }
    let (rail, inner) = (Faces::ALL.without(Faces::LEFT).without(Faces::RIGHT), half - leg);
    m.paint(seat).block([-inner, 0.56, -half], [inner, 0.82, -half + 0.025], rail);
}

/// A cabinet with its front divided into `doors` by dark joints, on a recessed plinth.
pub(crate) fn cabinet(m: &mut Model, [w, h, d]: [f64; 3], doors: usize, body: &Paint, top: &Paint) {
    let (x, plinth, joint) = (0.5 * w, 0.08, 0.012);
    m.paint(&DARK_FRAME).block(
        [-x + 0.03, 0.0, 0.0],
        [x - 0.03, plinth, d - 0.05],
        Faces::UPRIGHT.without(Faces::BACK),
    );
    m.paint(body).block(
        [-x, plinth, 0.0],
        [x, h - 0.03, d],
        Faces::LEFT.and(Faces::RIGHT).and(Faces::BOTTOM),
    );
    fronts(m, [-x, plinth, d], [w, h - 0.03 - plinth], doors, joint, body);
    m.paint(top).block([-x, h - 0.03, 0.0], [x, h, d + 0.01], Faces::ALL.without(Faces::BACK));
}

/// A row of door fronts in the plane z = origin z with dark joints between and above them.
pub(crate) fn fronts(
    m: &mut Model,
    origin: [f64; 3],
    [w, h]: [f64; 2],
    doors: usize,
    joint: f64,
    paint: &Paint,
) {
    let origin = DVec3::from(origin);
    let pitch = w / doors as f64;
    let (v0, v1) = (0.0, h - joint);
    let holes: Vec<_> = (0..doors)
        .map(|k| {
            let left = if k == 0 { 0.0 } else { 0.5 * joint };
            let right = if k + 1 == doors { 0.0 } else { 0.5 * joint };
            [pitch * k as f64 + left, pitch * (k + 1) as f64 - right, v0, v1]
        })
        .collect();
    m.paint(&DARK_FRAME).panel(origin, (DVec3::X, w), (DVec3::Y, h), &holes);
    m.paint(paint);
    for [u0, u1, v0, v1] in holes {
        m.quad(origin + dvec3(u0, v0, 0.0), DVec3::X * (u1 - u0), DVec3::Y * (v1 - v0));
    }
}

/// Open shelves with books: width, height, depth; `rows` compartments, `seed` varies the books.
pub(crate) fn bookshelf(m: &mut Model, [w, h, d]: [f64; 3], rows: usize, paint: &Paint, seed: u32) {
    let (x, board) = (0.5 * w, 0.025);
    m.paint(paint);
    for left in [-x, x - board] {
        m.block([left, 0.0, 0.0], [left + board, h, d], Faces::STANDING.without(Faces::BACK));
    }
    let (inner, pitch) = (x - board, (h - board) / rows as f64);
    m.wall(dvec3(-inner, board, 0.01), DVec3::X, 2.0 * inner, h - 2.0 * board, &[]);
    let level = Faces::TOP.and(Faces::BOTTOM).and(Faces::FRONT);
    let mut random = Random(seed);
    for row in 0..=rows {
        let y = pitch * row as f64;
        m.object("shelves").paint(paint);
        m.block(
            [-inner, y, if row == rows { 0.0 } else { 0.01 }],
            [inner, y + board, d],
            if row == 0 { Faces::TOP.and(Faces::FRONT) } else { level },
        );
        if row < rows {
            let run = (0.55 + 0.4 * random.next()) * 2.0 * inner;
            let start = if row % 2 == 0 { -inner + 0.01 } else { inner - run - 0.01 };
            books(m, [start, y + board, 0.04], run, pitch - board - 0.03, &mut random);
        }
    }
}

/// A row of books from `origin` along x, their spines towards +z, as one stepped body.
pub(crate) fn books(m: &mut Model, origin: [f64; 3], run: f64, tallest: f64, random: &mut Random) {
    let spines = [&RUST, &CREAM, &BLUE_WOOL, &CHARCOAL, &MUSTARD, &SAGE_FRONT, &PAPER, &CREAM];
    let [start, y, back] = origin;
    let front = back + 0.16;
    m.object("books");
    let (mut x, mut height) = (start, 0.0);
    let side = |m: &mut Model, x: f64, from: f64, to: f64| {
        // The step between neighbours faces the lower one.
        if to > from {
            m.wall(dvec3(x, from, back), DVec3::Z, front - back, to - from, &[]);
        } else {
            m.wall(dvec3(x, to, front), -DVec3::Z, front - back, from - to, &[]);
        }
    };
    while x < start + run - 0.08 {
        let thickness = (0.05 + 0.05 * random.next()).min(start + run - x);
        let next = tallest * (0.68 + 0.32 * random.next());
        m.paint(spines[(random.next() * spines.len() as f64) as usize]);
        side(m, x, y + height, y + next);
        m.wall(dvec3(x, y, front), DVec3::X, thickness, next, &[]);
        m.quad(dvec3(x, y + next, front), DVec3::X * thickness, DVec3::Z * (back - front));
        x += thickness;
        height = next;
    }
    side(m, x, y + height, y);
}

/// Small reproducible random numbers (a linear congruential generator after Knuth).
pub(crate) struct Random(pub(crate) u32);

impl Random {
    /// The next number in 0..1.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }
}

/// A framed picture around the origin, 2.5 cm in front of the wall; `kind` chooses the motif.
pub(crate) fn picture(m: &mut Model, [w, h]: [f64; 2], frame: &Paint, kind: usize) {
    let (x, y, d, rim) = (0.5 * w, 0.5 * h, 0.025, 0.03);
    m.object("pictures").paint(frame);
    m.block([-x, -y, 0.0], [x, y, d], Faces::AROUND);
    m.panel(dvec3(-x, -y, d), (DVec3::X, w), (DVec3::Y, h), &[[rim, w - rim, rim, h - rim]]);
    let (iw, ih) = (w - 2.0 * rim, h - 2.0 * rim);
    let motif: &[(&Paint, [f64; 4])] = match kind {
        0 => &[
            (&RUST, [0.14, 0.86, 0.14, 0.42]),
            (&MUSTARD, [0.14, 0.86, 0.42, 0.58]),
            (&BLUE_WOOL, [0.14, 0.86, 0.58, 0.86]),
        ],
        1 => &[
            (&CHARCOAL, [0.2, 0.42, 0.15, 0.85]),
            (&RUST, [0.5, 0.8, 0.5, 0.85]),
            (&MUSTARD, [0.5, 0.8, 0.15, 0.38]),
        ],
        2 => &[
            (&SAGE_FRONT, [0.12, 0.88, 0.12, 0.4]),
            (&BLUE_WOOL, [0.12, 0.5, 0.48, 0.88]),
            (&CREAM, [0.58, 0.88, 0.48, 0.88]),
        ],
        _ => &[(&LEAF, [0.3, 0.45, 0.2, 0.8]), (&SAGE_FRONT, [0.55, 0.7, 0.2, 0.65])],
    };
    let holes: Vec<_> = motif.iter().map(|(_, [a, b, c, e])| [a * iw, b * iw, c * ih, e * ih]).collect();
    let corner = dvec3(rim - x, rim - y, d);
    m.paint(&PAPER).panel(corner, (DVec3::X, iw), (DVec3::Y, ih), &holes);
    for ((paint, _), [u0, u1, v0, v1]) in motif.iter().zip(holes) {
        m.paint(paint).quad(corner + dvec3(u0, v0, 0.0), DVec3::X * (u1 - u0), DVec3::Y * (v1 - v0));
    }
}

/// A vase or bowl on y = 0.
pub(crate) fn vase(m: &mut Model, paint: &Paint, scale: f64) {
    let profile = [(0.05, 0.0), (0.095, 0.1), (0.05, 0.22), (0.035, 0.27), (0.05, 0.3)];
    let profile = profile.map(|(r, y)| (r * scale, y * scale));
    m.object("vases").paint(paint).lathe(DVec3::ZERO, &profile, 10);
    m.paint(&SOIL).disc(dvec3(0.0, 0.3 * scale, 0.0), 0.05 * scale, 10, true);
}

/// A shallow bowl on y = 0, seen into from above.
pub(crate) fn bowl(m: &mut Model, paint: &Paint, radius: f64) {
    m.object("bowls").paint(paint);
    m.lathe(DVec3::ZERO, &[(0.45 * radius, 0.0), (radius, 0.4 * radius)], 10);
    m.lathe(DVec3::ZERO, &[(0.94 * radius, 0.4 * radius), (0.4 * radius, 0.06 * radius)], 10);
    m.lathe(DVec3::ZERO, &[(radius, 0.4 * radius), (0.94 * radius, 0.4 * radius)], 10);
    m.disc(dvec3(0.0, 0.06 * radius, 0.0), 0.4 * radius, 10, true);
}

/// A tap on y = 0: its spout reaches over +z at this height, and its mouth faces down.
pub(crate) fn tap(m: &mut Model, height: f64, reach: f64) {
    let line =
        [DVec3::ZERO, dvec3(0.0, height, 0.0), dvec3(0.0, height, reach), dvec3(0.0, height - 0.035, reach)];
    let mouth = m.pipe(&line, 0.022, [DVec3::Y; 2]);
    m.polygon(&mouth);
}

/// A stack of books lying on y = 0.
pub(crate) fn book_stack(m: &mut Model, turn: f64) {
    m.object("books");
    let covers = [(&RUST, 0.3, 0.22, 0.035), (&PAPER, 0.26, 0.19, 0.03), (&BLUE_WOOL, 0.22, 0.16, 0.025)];
    let mut y = 0.0;
    for (k, (paint, w, d, h)) in covers.into_iter().enumerate() {
        m.place([0.0, y, 0.0], turn + 9.0 * k as f64, |m| {
            m.paint(paint).block([-0.5 * w, 0.0, -0.5 * d], [0.5 * w, h, 0.5 * d], Faces::STANDING);
        });
        y += h;
    }
}

/// A plate with a glass beside it, for one place at a table.
pub(crate) fn place_setting(m: &mut Model) {
    m.object("tableware").paint(&CERAMIC);
    m.lathe(DVec3::ZERO, &[(0.07, 0.0), (0.13, 0.018)], 10);
    m.lathe(DVec3::ZERO, &[(0.13, 0.018), (0.075, 0.006)], 10);
    m.disc(dvec3(0.0, 0.006, 0.0), 0.075, 10, true);
    m.paint(&BRASS).lathe(dvec3(0.17, 0.0, -0.1), &[(0.03, 0.0), (0.036, 0.09)], 8);
    m.disc(dvec3(0.17, 0.09, -0.1), 0.036, 8, true);
}

/// A bed with its head at z = 0: width and length.
pub(crate) fn bed(m: &mut Model, [w, l]: [f64; 2], frame: &Paint, cover: &Paint) {
    let x = 0.5 * w;
    m.object("bed").paint(frame);
    m.block([-x - 0.05, 0.0, 0.0], [x + 0.05, 1.05, 0.06], Faces::STANDING.without(Faces::BACK));
    m.block([-x, 0.12, 0.06], [x, 0.28, l], Faces::ALL.without(Faces::BACK));
    for (lx, lz) in [(-x + 0.06, 0.12), (x - 0.14, 0.12), (-x + 0.06, l - 0.2), (x - 0.14, l - 0.2)] {
        m.block([lx, 0.0, lz], [lx + 0.08, 0.12, lz + 0.08], Faces::UPRIGHT);
    }
    m.paint(&LINEN).cushion([-x + 0.02, 0.28, 0.08], [x - 0.02, 0.48, l - 0.02], 0.04);
    // The cover lies over the foot half and hangs down on three sides.
    let (top, from) = (0.50, 0.36 * l);
    m.paint(cover);
    m.cushion([-x + 0.06, 0.48, from], [x - 0.06, top + 0.03, l - 0.06], 0.025);
    m.paint(&CREAM).cushion([-x + 0.06, 0.48, from - 0.22], [x - 0.06, top + 0.045, from - 0.005], 0.02);
    m.paint(&LINEN);
    for cx in [-0.5 * x, 0.5 * x] {
        m.cushion([cx - 0.32, 0.48, 0.1], [cx + 0.32, 0.62, 0.45], 0.06);
    }
}
