//! What the gallery shows: sculptures on plinths, a bench, pictures.

use super::{END_WALL, FRAME, HALL};
use crate::scene::builtin::shapes::{Faces, circle, rectangle, square};
use crate::scene::builtin::writer::{Model, Paint};
use glam::{DVec3, dvec3};

const PLINTH: Paint = Paint::solid("plinth_white", [0.80, 0.80, 0.79]);
const MARBLE: Paint = Paint::solid("marble", [0.82, 0.81, 0.78]);
const BRONZE: Paint = Paint::solid("bronze", [0.33, 0.19, 0.08]);
const VERDIGRIS: Paint = Paint::solid("verdigris", [0.14, 0.40, 0.34]);
const OCHRE: Paint = Paint::solid("ochre", [0.66, 0.42, 0.10]);
const ULTRAMARINE: Paint = Paint::solid("ultramarine", [0.07, 0.11, 0.45]);
const CANVAS: Paint = Paint::solid("canvas", [0.74, 0.70, 0.60]);
const BENCH: Paint = Paint::solid("oak", [0.42, 0.27, 0.15]);

/// Where along the hall pictures hang and spots light them, the height of their middles, width and
/// height of those on either side, metres.
pub(super) const BAYS: [f64; 3] = [-3.2, 0.0, 3.2];
pub(super) const HUNG: f64 = 1.55;
pub(super) const WEST_PICTURE: [f64; 2] = [1.2, 0.9];
pub(super) const EAST_PICTURE: [f64; 2] = [0.9, 1.15];

/// What stands on a plinth.
enum Work {
    Torso,
    Ball,
    Twist,
    Stack,
    Vase,
}

/// Plinths: place x, z (metres), turn (degrees), height (metres), and the work on each.
const PLINTHS: [([f64; 2], f64, f64, Work); 5] = [
    ([-0.35, -1.25], 12.0, 0.85, Work::Torso),
    ([0.9, -3.9], 30.0, 0.7, Work::Ball),
    ([-0.95, 1.9], 0.0, 0.6, Work::Twist),
    ([0.95, 1.2], -18.0, 0.75, Work::Stack),
    ([0.0, -5.3], 0.0, 1.0, Work::Vase),
];

/// Half the edge of a plinth, metres.
const PLINTH_HALF: f64 = 0.3;

/// The bench: its place along the hall, half its length and width, and its legs as x from, x to.
const BENCH_Z: f64 = 3.7;
const BENCH_SIZE: [f64; 2] = [0.7, 0.22];
const LEGS: [[f64; 2]; 2] = [[-0.6, -0.5], [0.5, 0.6]];
const LEG_HALF: f64 = 0.17;

/// Footprints of plinths and bench on the nave's floor.
pub(super) fn feet() -> Vec<Vec<DVec3>> {
    let plinths = PLINTHS.iter().map(|([x, z], turn, ..)| square(dvec3(*x, 0.0, *z), PLINTH_HALF, *turn));
    let legs = LEGS
        .iter()
        .map(|[x0, x1]| rectangle([*x0, BENCH_Z - LEG_HALF], [*x1, BENCH_Z + LEG_HALF], 0.0).to_vec());
    plinths.chain(legs).collect()
}

pub(super) fn sculptures(m: &mut Model) {
    for ([x, z], turn, height, work) in &PLINTHS {
        m.place([*x, 0.0, *z], *turn, |m| {
            let half = PLINTH_HALF;
            m.object("plinths").paint(&PLINTH);
            m.block([-half, 0.0, -half], [half, *height, half], Faces::UPRIGHT);
            m.place([0.0, *height, 0.0], 0.0, |m| {
                let foot = match work {
                    Work::Torso => vec![circle(DVec3::ZERO, TORSO[0].0, ROUND)],
                    Work::Vase => vec![circle(DVec3::ZERO, VASE[0].0, ROUND)],
                    // It touches in a point.
                    Work::Ball => Vec::new(),
                    Work::Twist => vec![(0..4).map(|k| twist_corner(0, k)).collect()],
                    Work::Stack => vec![square(DVec3::ZERO, STACK[0].0, 0.0)],
                };
                m.pierced(&rectangle([-half, -half], [half, half], 0.0), &foot);
                m.object("sculptures");
                match work {
                    Work::Torso => m.paint(&MARBLE).lathe(DVec3::ZERO, &TORSO, ROUND),
                    Work::Ball => m.paint(&BRONZE).ball(dvec3(0.0, 0.27, 0.0), 0.27, 10, ROUND),
                    Work::Twist => twist(m),
                    Work::Stack => stack(m),
                    Work::Vase => {
                        m.paint(&MARBLE).lathe(DVec3::ZERO, &VASE, ROUND);
                        let (radius, rim) = VASE[VASE.len() - 1];
                        m.disc(dvec3(0.0, rim, 0.0), radius, ROUND, true);
                    }
                }
            });
        });
    }
}

/// Facets around turned works.
const ROUND: usize = 16;

/// Profiles of turned works: radius and height, metres.
const TORSO: [(f64, f64); 13] = [
    (0.15, 0.0),
    (0.17, 0.1),
    (0.13, 0.3),
    (0.11, 0.42),
    (0.16, 0.62),
    (0.2, 0.75),
    (0.17, 0.86),
    (0.07, 0.93),
    (0.055, 1.02),
    (0.1, 1.1),
    (0.115, 1.19),
    (0.09, 1.29),
    (0.0, 1.34),
];
const VASE: [(f64, f64); 8] = [
    (0.12, 0.0),
    (0.09, 0.06),
    (0.21, 0.3),
    (0.25, 0.45),
    (0.22, 0.6),
    (0.1, 0.74),
    (0.09, 0.82),
    (0.15, 0.9),
];

/// The stacked cubes: half edge and paint, each turned against the one below.
const STACK: [(f64, &Paint); 3] = [(0.2, &OCHRE), (0.14, &ULTRAMARINE), (0.1, &OCHRE)];
const STACK_TURN: f64 = 24.0;

fn stack(m: &mut Model) {
    let mut y = 0.0;
    for (k, &(half, paint)) in STACK.iter().enumerate() {
        m.paint(paint).place([0.0, y, 0.0], STACK_TURN * k as f64, |m| {
            m.block([-half, 0.0, -half], [half, 2.0 * half, half], Faces::UPRIGHT);
            let next = STACK.get(k + 1).map(|n| square(dvec3(0.0, 2.0 * half, 0.0), n.0, STACK_TURN));
            m.pierced(&rectangle([-half, -half], [half, half], 2.0 * half), next.as_slice());
        });
        y += 2.0 * half;
    }
}

/// Levels of the twisted prism, its height, its turn and half its edge at the foot.
const TWIST_LEVELS: usize = 9;
const TWIST: [f64; 3] = [1.1, 110.0, 0.26];

/// A corner of the twisted prism: it turns and tapers on its way up.
fn twist_corner(level: usize, k: usize) -> DVec3 {
    let [height, turn_deg, half] = TWIST;
    let t = level as f64 / TWIST_LEVELS as f64;
    let angle = (turn_deg * t + 45.0 + 90.0 * k as f64).to_radians();
    let radius = half * (1.25 - 0.6 * t);
    dvec3(radius * angle.cos(), height * t, radius * angle.sin())
}

fn twist(m: &mut Model) {
    m.paint(&VERDIGRIS);
    for level in 0..TWIST_LEVELS {
        for k in 0..4 {
            let next = (k + 1) % 4;
            let (a, b) = (twist_corner(level, next), twist_corner(level, k));
            let (c, d) = (twist_corner(level + 1, k), twist_corner(level + 1, next));
            m.polygon(&[a, b, c]);
            m.polygon(&[a, c, d]);
        }
    }
    m.polygon(&[3, 2, 1, 0].map(|k| twist_corner(TWIST_LEVELS, k)));
}

pub(super) fn bench(m: &mut Model) {
    m.object("bench").paint(&BENCH);
    m.place([0.0, 0.0, BENCH_Z], 0.0, |m| {
        let ([x, z], under, over) = (BENCH_SIZE, 0.38, 0.45);
        m.block([-x, under, -z], [x, over, z], Faces::STANDING);
        let tops = LEGS.map(|[x0, x1]| [x0 + x, x1 + x, z - LEG_HALF, z + LEG_HALF]);
        m.panel(dvec3(-x, under, -z), (DVec3::X, 2.0 * x), (DVec3::Z, 2.0 * z), &tops);
        for [x0, x1] in LEGS {
            m.block([x0, 0.0, -LEG_HALF], [x1, under, LEG_HALF], Faces::UPRIGHT);
        }
    });
}

/// Framed abstract pictures on the aisle walls.
pub(super) fn pictures(m: &mut Model) {
    for (k, z) in BAYS.into_iter().enumerate() {
        m.place([-HALL, HUNG, z], 90.0, |m| picture(m, WEST_PICTURE, k));
        m.place([HALL, HUNG, z], -90.0, |m| picture(m, EAST_PICTURE, k + 4));
    }
}

/// A picture centred on the origin that faces +z and hangs on the plane z = 0.
fn picture(m: &mut Model, [width, height]: [f64; 2], kind: usize) {
    let (w, h, d, rim) = (0.5 * width, 0.5 * height, 0.03, 0.05);
    m.object("pictures").paint(&FRAME);
    m.block([-w, -h, 0.0], [w, h, d], Faces::AROUND);
    let inner = [rim, width - rim, rim, height - rim];
    m.panel(dvec3(-w, -h, d), (DVec3::X, width), (DVec3::Y, height), &[inner]);
    let (iw, ih) = (width - 2.0 * rim, height - 2.0 * rim);
    let at = |u: f64, v: f64| dvec3(-w + rim + u * iw, -h + rim + v * ih, d);
    let shapes: [(&Paint, [f64; 4]); 3] = match kind % 4 {
        0 => [
            (&ULTRAMARINE, [0.1, 0.45, 0.15, 0.85]),
            (&OCHRE, [0.55, 0.9, 0.5, 0.85]),
            (&FRAME, [0.55, 0.9, 0.15, 0.25]),
        ],
        1 => [
            (&END_WALL, [0.0, 1.0, 0.0, 0.35]),
            (&OCHRE, [0.0, 1.0, 0.42, 0.6]),
            (&BRONZE, [0.2, 0.8, 0.68, 0.78]),
        ],
        2 => [
            (&VERDIGRIS, [0.08, 0.62, 0.1, 0.55]),
            (&FRAME, [0.3, 0.92, 0.62, 0.72]),
            (&OCHRE, [0.7, 0.92, 0.2, 0.5]),
        ],
        _ => [
            (&ULTRAMARINE, [0.0, 0.3, 0.0, 1.0]),
            (&VERDIGRIS, [0.36, 0.62, 0.0, 1.0]),
            (&END_WALL, [0.68, 0.8, 0.0, 1.0]),
        ],
    };
    m.paint(&CANVAS);
    let holes = shapes.map(|(_, [u0, u1, v0, v1])| [u0 * iw, u1 * iw, v0 * ih, v1 * ih]);
    m.panel(at(0.0, 0.0), (DVec3::X, iw), (DVec3::Y, ih), &holes);
    for (paint, [u0, u1, v0, v1]) in shapes {
        m.paint(paint);
        m.quad(at(u0, v0), DVec3::X * ((u1 - u0) * iw), DVec3::Y * ((v1 - v0) * ih));
    }
}
