//! A closed sculpture gallery: a barrel-vaulted nave between two colonnades and flat aisles.

use super::shapes::Faces;
use super::writer::{LampId, Model, Output, Paint};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

const STONE: Paint = Paint::solid("limestone", [0.70, 0.64, 0.54]);
const WALL: Paint = Paint::solid("lime_plaster", [0.78, 0.75, 0.70]);
const END_WALL: Paint = Paint::solid("pompeian_red", [0.46, 0.12, 0.08]);
const VAULT: Paint = Paint::solid("vault_plaster", [0.80, 0.79, 0.76]);
const FLOOR: Paint = Paint::solid("terrazzo", [0.44, 0.40, 0.36]);
const INLAY: Paint = Paint::solid("dark_marble", [0.13, 0.14, 0.14]);
const PLINTH: Paint = Paint::solid("plinth_white", [0.80, 0.80, 0.79]);
const MARBLE: Paint = Paint::solid("marble", [0.82, 0.81, 0.78]);
const BRONZE: Paint = Paint::solid("bronze", [0.33, 0.19, 0.08]);
const VERDIGRIS: Paint = Paint::solid("verdigris", [0.14, 0.40, 0.34]);
const OCHRE: Paint = Paint::solid("ochre", [0.66, 0.42, 0.10]);
const ULTRAMARINE: Paint = Paint::solid("ultramarine", [0.07, 0.11, 0.45]);
const CANVAS: Paint = Paint::solid("canvas", [0.74, 0.70, 0.60]);
const FRAME: Paint = Paint::solid("black_frame", [0.05, 0.045, 0.04]);
const BENCH: Paint = Paint::solid("oak", [0.42, 0.27, 0.15]);

/// Half the clear width of the nave, of the whole hall, and half the hall's length, metres.
const NAVE: f64 = 1.9;
const HALL: f64 = 3.5;
const LENGTH: f64 = 6.5;
/// Underside of the architrave, springing of the vault, ceiling of the aisles, metres.
const ARCHITRAVE: f64 = 2.75;
const SPRINGING: f64 = 3.1;
const AISLE_CEILING: f64 = 3.0;
/// Width of the architrave, metres: from the nave's edge outwards.
const BEAM: f64 = 0.36;
/// Facets of the half circle of the vault.
const FACETS: usize = 24;
/// Column axes along the hall, metres.
const COLUMNS: [f64; 4] = [-4.8, -1.6, 1.6, 4.8];

pub(crate) fn model() -> Model {
    let mut m = Model::new(("m", 1.0), 0.42);
    m.view("Nave", [0.35, 1.6, 6.1], [-0.1, 1.85, -2.0], 62.0);
    m.view("Colonnade", [-2.75, 1.6, 5.9], [-1.2, 1.35, -1.2], 62.0);
    m.view("Torso", [1.55, 1.5, 0.3], [-0.55, 1.35, -1.7], 60.0);
    m.view("Vault", [0.0, 1.5, 4.6], [0.0, 3.7, -2.5], 72.0);
    m.view("East aisle", [2.75, 1.6, -5.9], [2.5, 1.4, 0.5], 60.0);

    shell(&mut m);
    colonnades(&mut m);
    sculptures(&mut m);
    pictures(&mut m);
    lamps(&mut m);
    m
}

/// Floor with two inlaid bands, aisle walls and ceilings, vault and end walls.
fn shell(m: &mut Model) {
    m.object("floor").paint(&FLOOR);
    let bands = [[1.45, 1.6], [5.4, 5.55]];
    let strips = bands.map(|[u0, u1]| [u0, u1, 0.0, 2.0 * LENGTH]);
    m.panel(dvec3(-HALL, 0.0, LENGTH), (DVec3::X, 2.0 * HALL), (-DVec3::Z, 2.0 * LENGTH), &strips);
    m.paint(&INLAY);
    for [u0, u1] in bands {
        m.quad(dvec3(u0 - HALL, 0.0, LENGTH), DVec3::X * (u1 - u0), -DVec3::Z * (2.0 * LENGTH));
    }

    let outer = NAVE + BEAM;
    m.object("aisle_walls").paint(&WALL);
    m.wall(dvec3(-HALL, 0.0, LENGTH), -DVec3::Z, 2.0 * LENGTH, AISLE_CEILING, &[]);
    m.wall(dvec3(HALL, 0.0, -LENGTH), DVec3::Z, 2.0 * LENGTH, AISLE_CEILING, &[]);
    m.object("aisle_ceilings");
    for x in [-HALL, outer] {
        m.quad(dvec3(x, AISLE_CEILING, -LENGTH), DVec3::X * (HALL - outer), DVec3::Z * (2.0 * LENGTH));
    }

    m.object("vault").paint(&VAULT);
    let arc = |k: usize| {
        let angle = PI * k as f64 / FACETS as f64;
        // The ends are exact, so that the vault springs from the beams without a crack.
        let x = if k == 0 {
            NAVE
        } else if k == FACETS {
            -NAVE
        } else {
            NAVE * angle.cos()
        };
        let y = if k == 0 || k == FACETS { 0.0 } else { NAVE * angle.sin() };
        (dvec3(x, SPRINGING + y, 0.0), -dvec3(angle.cos(), angle.sin(), 0.0))
    };
    let (near, far) = (DVec3::Z * LENGTH, -DVec3::Z * LENGTH);
    for k in 0..FACETS {
        let ((p, n), (q, o)) = (arc(k), arc(k + 1));
        m.smooth_polygon(&[(p + far, n), (p + near, n), (q + near, o), (q + far, o)]);
    }

    // The end walls follow the section: aisles, beams' ends, nave and lunette.
    m.object("end_walls").paint(&END_WALL);
    for side in [1.0, -1.0] {
        let z = -LENGTH * side;
        let mut outline =
            vec![dvec3(-NAVE * side, 0.0, z), dvec3(NAVE * side, 0.0, z), dvec3(NAVE * side, ARCHITRAVE, z)];
        outline.extend((0..=FACETS).map(|k| {
            let (p, _) = arc(k);
            dvec3(p.x * side, p.y, z)
        }));
        outline.push(dvec3(-NAVE * side, ARCHITRAVE, z));
        m.polygon(&outline);
        // Beside the nave the wall is notched where the architrave runs into it.
        let width = HALL - NAVE;
        let west = [width - BEAM, width, ARCHITRAVE, AISLE_CEILING];
        let east = [0.0, BEAM, ARCHITRAVE, AISLE_CEILING];
        m.wall(dvec3(-HALL * side, 0.0, z), DVec3::X * side, width, AISLE_CEILING, &[west]);
        m.wall(dvec3(NAVE * side, 0.0, z), DVec3::X * side, width, AISLE_CEILING, &[east]);
    }
}

/// Columns with bases and capitals, and the beams on them.
fn colonnades(m: &mut Model) {
    let axis = NAVE + 0.5 * BEAM;
    for x in [-axis, axis] {
        for z in COLUMNS {
            m.object("columns").paint(&STONE);
            m.place([x, 0.0, z], 0.0, |m| {
                m.block([-0.2, 0.0, -0.2], [0.2, 0.12, 0.2], Faces::UPRIGHT);
                m.collar(dvec3(0.0, 0.12, 0.0), 0.2, 0.172, 16, true);
                let shaft = [(0.172, 0.12), (0.148, 0.2), (0.141, 1.35), (0.128, 2.5), (0.172, 2.63)];
                m.lathe(DVec3::ZERO, &shaft, 16);
                m.collar(dvec3(0.0, 2.63, 0.0), 0.19, 0.172, 16, false);
                m.block([-0.19, 2.63, -0.19], [0.19, ARCHITRAVE, 0.19], Faces::UPRIGHT);
            });
        }
        m.object("architraves");
        let (x0, x1) = (x - 0.5 * BEAM, x + 0.5 * BEAM);
        let run = 2.0 * LENGTH;
        m.quad(dvec3(x0, ARCHITRAVE, -LENGTH), DVec3::X * BEAM, DVec3::Z * run);
        let (nave, aisle) = if x < 0.0 { (x1, x0) } else { (x0, x1) };
        face_along(m, nave, -x.signum(), ARCHITRAVE, SPRINGING);
        face_along(m, aisle, x.signum(), ARCHITRAVE, AISLE_CEILING);
    }
}

/// An upright face along the whole hall at x, towards +x or -x.
fn face_along(m: &mut Model, x: f64, towards: f64, y0: f64, y1: f64) {
    let (z, along) = if towards > 0.0 { (LENGTH, -DVec3::Z) } else { (-LENGTH, DVec3::Z) };
    m.wall(dvec3(x, y0, z), along, 2.0 * LENGTH, y1 - y0, &[]);
}

/// Five works on plinths, and a bench.
fn sculptures(m: &mut Model) {
    let plinth = |m: &mut Model, x: f64, z: f64, turn: f64, height: f64, build: &dyn Fn(&mut Model)| {
        m.place([x, 0.0, z], turn, |m| {
            m.object("plinths").paint(&PLINTH);
            m.block([-0.3, 0.0, -0.3], [0.3, height, 0.3], Faces::STANDING);
            m.object("sculptures");
            m.place([0.0, height, 0.0], 0.0, |m| build(m));
        });
    };
    plinth(m, -0.35, -1.25, 12.0, 0.85, &|m| {
        m.paint(&MARBLE);
        let torso = [
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
        m.lathe(DVec3::ZERO, &torso, 18);
    });
    plinth(m, 0.9, -3.9, 30.0, 0.7, &|m| {
        m.paint(&BRONZE);
        m.ball(dvec3(0.0, 0.27, 0.0), 0.27, 10, 18);
    });
    plinth(m, -0.95, 1.9, 0.0, 0.6, &|m| {
        m.paint(&VERDIGRIS);
        twisted(m, 0.26, 1.1, 9, 110.0);
    });
    plinth(m, 0.95, 1.2, -18.0, 0.75, &|m| {
        for (k, paint) in [OCHRE, ULTRAMARINE, OCHRE].iter().enumerate() {
            m.paint(paint);
            let (half, y) = (0.2 - 0.045 * k as f64, [0.0, 0.4, 0.71][k]);
            m.place([0.0, y, 0.0], 24.0 * k as f64, |m| {
                m.block([-half, 0.0, -half], [half, 2.0 * half, half], Faces::STANDING);
            });
        }
    });
    plinth(m, 0.0, -5.3, 0.0, 1.0, &|m| {
        m.paint(&MARBLE);
        let vase = [
            (0.12, 0.0),
            (0.09, 0.06),
            (0.21, 0.3),
            (0.25, 0.45),
            (0.22, 0.6),
            (0.1, 0.74),
            (0.09, 0.82),
            (0.15, 0.9),
        ];
        m.lathe(DVec3::ZERO, &vase, 18);
        m.disc(dvec3(0.0, 0.9, 0.0), 0.15, 18, true);
    });

    m.object("bench").paint(&BENCH);
    m.place([0.0, 0.0, 3.7], 0.0, |m| {
        m.block([-0.7, 0.38, -0.22], [0.7, 0.45, 0.22], Faces::ALL);
        for x in [-0.6, 0.5] {
            m.block([x, 0.0, -0.17], [x + 0.1, 0.38, 0.17], Faces::UPRIGHT);
        }
    });
}

/// A square prism that turns by `turn_deg` on its way up, with a flat top.
fn twisted(m: &mut Model, half: f64, height: f64, steps: usize, turn_deg: f64) {
    let corner = |level: usize, k: usize| {
        let t = level as f64 / steps as f64;
        let angle = (turn_deg * t + 45.0 + 90.0 * k as f64).to_radians();
        let radius = half * (1.25 - 0.6 * t);
        dvec3(radius * angle.cos(), height * t, radius * angle.sin())
    };
    for level in 0..steps {
        for k in 0..4 {
            let (a, b) = (corner(level, k + 1), corner(level, k));
            let (c, d) = (corner(level + 1, k), corner(level + 1, k + 1));
            m.polygon(&[a, b, c]);
            m.polygon(&[a, c, d]);
        }
    }
    m.polygon(&[corner(steps, 3), corner(steps, 2), corner(steps, 1), corner(steps, 0)]);
}

/// Framed abstract pictures on the aisle walls, two centimetres in front of them.
fn pictures(m: &mut Model) {
    let bays = [-3.2, 0.0, 3.2];
    for (k, z) in bays.into_iter().enumerate() {
        m.place([-HALL, 1.55, z], 90.0, |m| picture(m, 1.2, 0.9, k));
        m.place([HALL, 1.55, z], -90.0, |m| picture(m, 0.9, 1.15, k + 4));
    }
}

/// A picture centred on the origin that faces +z and hangs on the plane z = 0.
fn picture(m: &mut Model, width: f64, height: f64, kind: usize) {
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

fn lamps(m: &mut Model) {
    // Coves on the nave side of the beams wash the vault from hidden strips.
    let cove = m.lamp("Vault coves", Output::White(9000.0, 5000.0), true);
    for side in [-1.0, 1.0] {
        let inner = side * (NAVE - 0.16);
        m.object("coves").paint(&STONE);
        let (x0, x1) = if side < 0.0 { (-NAVE, inner) } else { (inner, NAVE) };
        let run = LENGTH - 0.5;
        let to_beam = if side < 0.0 { Faces::LEFT } else { Faces::RIGHT };
        m.block([x0, 2.86, -run], [x1, 2.94, run], Faces::ALL.without(to_beam).without(Faces::TOP));
        // A lip hides the strip from the eye below.
        let (l0, l1) = if side < 0.0 { (inner - 0.02, inner) } else { (inner, inner + 0.02) };
        m.block([l0, 2.94, -run], [l1, 3.02, run], Faces::STANDING);
        let (s0, s1) = if side < 0.0 { (x0, l0) } else { (l1, x1) };
        m.glow(cove, 1.0, [0.6; 3]);
        m.quad(dvec3(s0, 2.94, run), DVec3::X * (s1 - s0), -DVec3::Z * (2.0 * run));
    }

    let spot = |m: &mut Model, lamp: LampId, x: f64, z: f64, ceiling: f64| {
        m.place([x, ceiling, z], 0.0, |m| {
            m.object("spot_housings").paint(&FRAME);
            m.lathe(DVec3::ZERO, &[(0.09, -0.24), (0.09, 0.0)], 12);
            m.lathe(DVec3::ZERO, &[(0.085, -0.16), (0.085, -0.24)], 12);
            ring(m, 0.085, 0.09, -0.24);
            m.glow(lamp, 1.0, [0.5; 3]).disc(dvec3(0.0, -0.16, 0.0), 0.085, 12, false);
        });
    };
    let aisle = 0.5 * (NAVE + BEAM + HALL) + 0.12;
    let west = m.lamp("West picture spots", Output::White(3000.0, 5000.0), true);
    let east = m.lamp("East picture spots", Output::White(3000.0, 5000.0), true);
    for z in [-3.2, 0.0, 3.2] {
        spot(m, west, -aisle, z, AISLE_CEILING);
        spot(m, east, aisle, z, AISLE_CEILING);
    }

    // Pendant discs under the vault, over the works.
    let pendants = m.lamp("Nave pendants", Output::White(5200.0, 5500.0), true);
    for z in [-4.2, -1.25, 1.6] {
        m.place([0.0, 2.95, z], 0.0, |m| {
            m.object("pendant_bodies").paint(&FRAME);
            m.lathe(DVec3::ZERO, &[(0.28, 0.0), (0.28, 0.05)], 16);
            m.disc(dvec3(0.0, 0.05, 0.0), 0.28, 16, true);
            m.bar(dvec3(0.0, 0.05, 0.0), dvec3(0.0, SPRINGING + NAVE - 2.952, 0.0), 0.012);
            m.glow(pendants, 1.0, [0.7; 3]).disc(DVec3::ZERO, 0.28, 16, false);
        });
    }

    // An upright light box behind the vase at the end of the nave.
    let screen = m.lamp("Apse light wall", Output::Coloured(1500.0, [1.0, 0.55, 0.28]), true);
    m.object("apse_light_frame").paint(&FRAME);
    let (w, y0, y1, z) = (0.7, 0.25, 2.45, -LENGTH);
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

/// A flat ring about the vertical axis that faces down.
fn ring(m: &mut Model, inner: f64, outer: f64, y: f64) {
    m.lathe(DVec3::ZERO, &[(inner, y), (outer, y)], 12);
}
