//! A closed sculpture gallery: a barrel-vaulted nave between two colonnades and flat aisles.
//!
//! Whatever stands, hangs or leans on something has its footprint cut out there, so that the whole
//! is one closed surface.

mod lamps;
mod works;

use super::shapes::{Faces, Hole, circle, rectangle, square};
use super::writer::{Model, Paint};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

const STONE: Paint = Paint::solid("limestone", [0.70, 0.64, 0.54]);
const WALL: Paint = Paint::solid("lime_plaster", [0.78, 0.75, 0.70]);
const END_WALL: Paint = Paint::solid("pompeian_red", [0.46, 0.12, 0.08]);
const VAULT: Paint = Paint::solid("vault_plaster", [0.80, 0.79, 0.76]);
const FLOOR: Paint = Paint::solid("terrazzo", [0.44, 0.40, 0.36]);
const INLAY: Paint = Paint::solid("dark_marble", [0.13, 0.14, 0.14]);
const FRAME: Paint = Paint::solid("black_frame", [0.05, 0.045, 0.04]);

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
/// Distance of the columns from the hall's middle, half the edge of their bases, metres.
const COLUMN_AXIS: f64 = NAVE + 0.5 * BEAM;
const COLUMN_BASE: f64 = 0.2;
/// Where the columns stand along the hall, metres.
const COLUMNS: [f64; 4] = [-4.8, -1.6, 1.6, 4.8];

pub(crate) fn model() -> Model {
    let mut m = Model::new(("m", 1.0), 0.42);
    m.view("Nave", [0.35, 1.6, 6.1], [-0.1, 1.85, -2.0], 62.0);
    m.view("Colonnade", [-2.75, 1.6, 4.1], [-1.1, 1.4, -2.0], 62.0);
    m.view("Torso", [1.55, 1.5, 0.3], [-0.55, 1.35, -1.7], 60.0);
    m.view("Vault", [0.0, 1.5, 4.6], [0.0, 3.7, -2.5], 72.0);
    m.view("East aisle", [2.75, 1.6, -4.1], [1.9, 1.35, 1.5], 60.0);

    shell(&mut m);
    colonnades(&mut m);
    works::sculptures(&mut m);
    works::bench(&mut m);
    works::pictures(&mut m);
    lamps::lamps(&mut m);
    m
}

/// Floor with two inlaid bands, aisle walls and ceilings, vault and end walls.
fn shell(m: &mut Model) {
    m.object("floor");
    let (inner, outer) = (1.55, 1.7);
    let columns = |side: f64| COLUMNS.map(|z| square(dvec3(side * COLUMN_AXIS, 0.0, z), COLUMN_BASE, 0.0));
    for (x0, x1, feet) in [
        (-HALL, -outer, columns(-1.0).to_vec()),
        (-inner, inner, works::feet()),
        (outer, HALL, columns(1.0).to_vec()),
    ] {
        m.paint(&FLOOR).pierced(&rectangle([x0, -LENGTH], [x1, LENGTH], 0.0), &feet);
    }
    m.paint(&INLAY);
    for x in [-outer, inner] {
        m.quad(dvec3(x, 0.0, LENGTH), DVec3::X * (outer - inner), -DVec3::Z * (2.0 * LENGTH));
    }

    m.object("aisle_walls").paint(&WALL);
    for (side, [w, h]) in [(-1.0, works::WEST_PICTURE), (1.0, works::EAST_PICTURE)] {
        let hung = works::BAYS.map(|z| {
            let u = LENGTH + side * z;
            [u - 0.5 * w, u + 0.5 * w, works::HUNG - 0.5 * h, works::HUNG + 0.5 * h]
        });
        m.wall(dvec3(side * HALL, 0.0, -side * LENGTH), side * DVec3::Z, 2.0 * LENGTH, AISLE_CEILING, &hung);
    }
    m.object("aisle_ceilings");
    for side in [-1.0, 1.0] {
        let spots = works::BAYS
            .map(|z| circle(dvec3(side * lamps::SPOT_AXIS, AISLE_CEILING, z), lamps::SPOT_RADIUS, 12));
        let (x0, x1) = if side < 0.0 { (-HALL, -NAVE - BEAM) } else { (NAVE + BEAM, HALL) };
        let mut outline = rectangle([x0, -LENGTH], [x1, LENGTH], AISLE_CEILING);
        outline.reverse();
        m.pierced(&outline, &spots);
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
        // The light box hangs on the north wall.
        let [w, y0, y1] = lamps::LIGHT_BOX;
        let cut = vec![dvec3(-w, y0, z), dvec3(w, y0, z), dvec3(w, y1, z), dvec3(-w, y1, z)];
        m.pierced(&outline, if side > 0.0 { std::slice::from_ref(&cut) } else { &[] });
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
    for side in [-1.0, 1.0] {
        let x = side * COLUMN_AXIS;
        for z in COLUMNS {
            m.object("columns").paint(&STONE);
            m.place([x, 0.0, z], 0.0, |m| {
                let (base, abacus, rim) = (COLUMN_BASE, 0.5 * BEAM, 0.172);
                m.block([-base, 0.0, -base], [base, 0.12, base], Faces::UPRIGHT);
                m.collar(dvec3(0.0, 0.12, 0.0), base, rim, 16, true);
                m.lathe(
                    DVec3::ZERO,
                    &[(rim, 0.12), (0.148, 0.2), (0.141, 1.35), (0.128, 2.5), (rim, 2.63)],
                    16,
                );
                m.collar(dvec3(0.0, 2.63, 0.0), abacus, rim, 16, false);
                m.block([-abacus, 2.63, -abacus], [abacus, ARCHITRAVE, abacus], Faces::UPRIGHT);
            });
        }
        m.object("architraves").paint(&STONE);
        let abaci = COLUMNS.map(|z| [0.0, BEAM, z + LENGTH - 0.5 * BEAM, z + LENGTH + 0.5 * BEAM]);
        let underside = dvec3(x - 0.5 * BEAM, ARCHITRAVE, -LENGTH);
        m.panel(underside, (DVec3::X, BEAM), (DVec3::Z, 2.0 * LENGTH), &abaci);
        let [low, high] = lamps::COVE.map(|y| y - ARCHITRAVE);
        let cove = [LENGTH - lamps::COVE_RUN, LENGTH + lamps::COVE_RUN, low, high];
        face_along(m, side * NAVE, -side, SPRINGING, &[cove]);
        face_along(m, side * (NAVE + BEAM), side, AISLE_CEILING, &[]);
    }
}

/// An upright face along the whole hall at x, from the beams' underside to `top`, towards +x or -x.
fn face_along(m: &mut Model, x: f64, towards: f64, top: f64, holes: &[Hole]) {
    let origin = dvec3(x, ARCHITRAVE, towards * LENGTH);
    m.wall(origin, -towards * DVec3::Z, 2.0 * LENGTH, top - ARCHITRAVE, holes);
}
