//! Form factors between two surfaces, and past something that stands between.

use super::scenes::with_two_sided;
use super::{Assembled, Case, CaseError, Group, Model, Way};
use crate::form_factors::closed_form::{
    coaxial_disks, exchange_area, parallel_rectangles, perpendicular_rectangles, point_to_polygon,
};
use crate::geometry::polygon::area_vector;
use crate::mesh::PatchTarget;
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;
use std::sync::Arc;

const HOTTEL: &str = "Hottel 1931 (Howell C-11)";
const HAMILTON: &str = "Hamilton & Morgan 1952 (Howell C-14)";
const DISKS: &str = "Howell C-41";
const QUADRATURE: &str = "double exponential quadrature of Lambert's formula";
const MONTE_CARLO: &str = "quadrature and Monte Carlo";

const CLOSE_PAIR: &str = "one patch each: the contour integral to 2e-4, and rounding to single precision";
const SAMPLED: &str = "patches of a tenth, each by its centre; rays leave noise, 1 / sqrt(hits)";
const POLYGONS: &str = "disks are polygons of 96 corners of the disk's area";
const BLOCKED: &str = "patches of a twelfth: centre points see shadow edges by halves";

pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    cases.extend(parallel());
    cases.extend(perpendicular());
    cases.extend(dihedral());
    cases.extend(others());
    cases.extend(points());
    cases.extend(occluded());
    cases
}

pub(super) fn rectangle(at: DVec3, u: DVec3, v: DVec3) -> Vec<DVec3> {
    vec![at, at + u, at + u + v, at + v]
}

/// Form factor from polygon a to polygon b, which face each other with nothing else about.
fn pair(a: &[DVec3], b: &[DVec3], way: Way, patches: PatchTarget) -> Result<f64, CaseError> {
    if way == Way::Contour {
        return Ok(exchange_area(a, b) / area_vector(a).length());
    }
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    m.object("a").polygon("glow", a).object("b").polygon("paint", b);
    let made = Assembled::new(Arc::new(m.read_one_sided()?), &way.settings(patches))?;
    Ok(made.between(&made.of(|o| o == "a"), &made.of(|o| o == "b")))
}

fn parallel() -> impl Iterator<Item = Case> {
    // Near plates, as their own single patches; the far ones below.
    let near = [
        (1.0, 1.0, 1.0, 0.199_824_895_698_387),
        (1.0, 1.0, 0.5, 0.415_253_283_577_147),
        (1.0, 1.0, 0.1, 0.826_994_522_397_257),
        (1.0, 1.0, 0.01, 0.980_416_602_925_973),
        (1.0, 1.0, 0.001, 0.998_005_631_907_579_7),
        (1.0, 1.0, 1e-6, 0.999_998_000_010_029_5),
        (2.0, 1.0, 1.0, 0.285_875_384_850_715),
        (6.0, 4.0, 3.0, 0.341_693_913_524_762),
    ];
    let far = [(1.0, 1.0, 2.0, 0.068_589_588_818_552_5), (1.0, 1.0, 10.0, 0.003_162_056_838_757_60)];
    let case = |(a, b, c, f): (f64, f64, f64, f64), patches: PatchTarget| {
        let name = format!("parallel {a} x {b}, gap {c}");
        Case::new(Group::ViewFactors, name, HOTTEL, f, move |way| match way {
            Way::Formula => Ok(parallel_rectangles(a, b, c)),
            _ => pair(
                &rectangle(DVec3::ZERO, DVec3::X * a, DVec3::Y * b),
                &rectangle(DVec3::Z * c, DVec3::Y * b, DVec3::X * a),
                way,
                patches,
            ),
        })
    };
    let near = near.map(|v| {
        let digits = if v.2 < 0.01 { 1e-9 } else { 1e-12 };
        let case = case(v, PatchTarget::AsGiven).way(Way::Formula, digits).way(Way::Contour, 2e-4);
        case.lines(3e-4).hemicube(3e-4).rays(3e-4).because(CLOSE_PAIR)
    });
    let far = far.map(|v| {
        let case = case(v, PatchTarget::Size(0.1)).way(Way::Formula, 1e-12).way(Way::Contour, 2e-4);
        case.lines(1e-3).hemicube(3e-3).rays(5e-2).because(SAMPLED)
    });
    near.into_iter().chain(far)
}

fn perpendicular() -> impl Iterator<Item = Case> {
    [
        (1.0, 1.0, 1.0, 0.200_043_776_075_403),
        (1.0, 2.0, 1.0, 0.116_426_301_397_681),
        (2.0, 1.0, 1.0, 0.232_852_602_795_362),
        (0.1, 0.1, 1.0, 0.281_887_806_787_901),
        (10.0, 10.0, 1.0, 0.055_023_979_528_410_6),
        (1.0, 0.001, 1.0, 0.498_592_023_105_068),
        (1.0, 0.0001, 1.0, 0.499_822_555_528_782),
        (0.01, 1.0, 1.0, 0.004_895_849_268_506_68),
        (3.0, 6.0, 4.0, 0.129_616_009_955_217),
    ]
    .into_iter()
    .map(|(h, w, l, f)| {
        let name = format!("perpendicular, {w} x {l} to {h} x {l}");
        let case = Case::new(Group::ViewFactors, name, HAMILTON, f, move |way| match way {
            Way::Formula => Ok(perpendicular_rectangles(h, w, l)),
            _ => pair(
                &rectangle(DVec3::ZERO, DVec3::X * w, DVec3::Y * l),
                &rectangle(DVec3::ZERO, DVec3::Y * l, DVec3::Z * h),
                way,
                PatchTarget::AsGiven,
            ),
        });
        case.way(Way::Formula, 1e-8).way(Way::Contour, 2e-4).all_methods(3e-4).because(CLOSE_PAIR)
    })
}

fn dihedral() -> impl Iterator<Item = Case> {
    [
        (60.0, 0.370_905_321_150_04),
        (30.0, 0.619_028_323_090_78),
        (5.0, 0.920_261_908_111_2),
        (1.0, 0.982_997_178_574_6),
    ]
    .into_iter()
    .map(|(degrees, f): (f64, f64)| {
        let name = format!("unit squares at {degrees} degrees, common edge");
        Case::new(Group::ViewFactors, name, QUADRATURE, f, move |way| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            pair(
                &rectangle(DVec3::ZERO, DVec3::X, DVec3::Y),
                &rectangle(DVec3::ZERO, DVec3::Y, dvec3(cos, 0.0, sin)),
                way,
                PatchTarget::AsGiven,
            )
        })
        .way(Way::Contour, 2e-4)
        .all_methods(3e-4)
        .because(CLOSE_PAIR)
    })
}

/// A regular polygon of 96 corners with the area of a disk of radius `r` at height z, facing up or down.
fn disk(r: f64, z: f64, up: bool) -> Vec<DVec3> {
    const CORNERS: u32 = 96;
    let step = TAU / f64::from(CORNERS);
    let radius = r * (step / step.sin()).sqrt();
    let at = |k: u32| {
        let angle = step * f64::from(k) * if up { 1.0 } else { -1.0 };
        dvec3(radius * angle.cos(), radius * angle.sin(), z)
    };
    (0..CORNERS).map(at).collect()
}

fn others() -> impl Iterator<Item = Case> {
    let disks = [
        (1.0, 1.0, 1.0, 0.381_966_011_250_105),
        (1.0, 1.0, 3.0, 0.091_673_086_804_016_1),
        (1.0, 2.0, 1.0, 0.763_932_022_500_210),
        (0.5, 1.0, 2.0, 0.192_235_935_955_849),
    ]
    .map(|(r1, r2, h, f)| {
        let name = format!("coaxial disks, radii {r1} and {r2}, gap {h}");
        let case = Case::new(Group::ViewFactors, name, DISKS, f, move |way| match way {
            Way::Formula => Ok(coaxial_disks(r1, r2, h)),
            _ => pair(&disk(r1, 0.0, true), &disk(r2, h, false), way, PatchTarget::AsGiven),
        });
        case.way(Way::Formula, 1e-12).way(Way::Contour, 1e-3).lines(1e-3).because(POLYGONS)
    });
    let pentagon =
        Case::new(Group::ViewFactors, "pentagon to a square beside it", MONTE_CARLO, 0.154_124_32, |way| {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 2.0), (0.0, 1.0)];
            pair(
                &corners.map(|(x, y)| dvec3(x, y, 0.0)),
                &rectangle(DVec3::ZERO, DVec3::Y, DVec3::Z),
                way,
                PatchTarget::AsGiven,
            )
        });
    let pentagon = pentagon.way(Way::Contour, 2e-4).all_methods(3e-4).because(CLOSE_PAIR);
    disks.into_iter().chain([pentagon])
}

fn points() -> impl Iterator<Item = Case> {
    [
        ("point to a unit square above it", DVec3::X, DVec3::Y, DVec3::Z, 0.138_531_605_994_893),
        ("point to a unit square beside it", DVec3::X, DVec3::Z, DVec3::Y, 0.055_734_197_002_553_5),
    ]
    .into_iter()
    .map(|(name, u, v, at, f)| {
        Case::new(Group::ViewFactors, name, "Lambert 1760 (Howell B-3, B-4)", f, move |_| {
            Ok(point_to_polygon(DVec3::ZERO, DVec3::Z, &rectangle(at, u, v)))
        })
        .way(Way::Formula, 1e-12)
        .because("the same closed form to rounding")
    })
}

/// Unit squares a and b at z = 0 and 1 with a rectangle between them at z = 0.5.
fn blocked(low: [f64; 2], high: [f64; 2], way: Way) -> Result<f64, CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.5).grey("screen", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    m.object("a").quad("glow", DVec3::ZERO, DVec3::X, DVec3::Y);
    m.object("b").quad("paint", DVec3::Z, DVec3::Y, DVec3::X);
    let at = dvec3(low[0], low[1], 0.5);
    m.object("blocker").quad("screen", at, DVec3::X * (high[0] - low[0]), DVec3::Y * (high[1] - low[1]));
    let scene = with_two_sided(m.read(None)?, &["screen"]);
    let made = Assembled::new(Arc::new(scene), &way.settings(PatchTarget::Size(0.0834)))?;
    Ok(made.between(&made.of(|o| o == "a"), &made.of(|o| o == "b")))
}

fn occluded() -> impl Iterator<Item = Case> {
    let screens = [
        ("squares with a square between", [0.25, 0.25], [0.75, 0.75], MONTE_CARLO, 0.099_506_294_598_984_8),
        (
            "squares with half a plane between",
            [0.5, -0.2],
            [1.2, 1.2],
            "half of Hottel 1931, by symmetry",
            0.099_912_447_849_193_1,
        ),
    ]
    .map(|(name, low, high, source, f)| {
        Case::new(Group::Occlusion, name, source, f, move |way| blocked(low, high, way))
            .lines(0.01)
            .hemicube(0.01)
            .because(BLOCKED)
    });
    let inside = |outwards: bool| {
        move |way: Way| {
            let mut m = Model::new();
            m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
            let paint = Some("paint");
            m.room(DVec3::ZERO, DVec3::splat(3.0), [paint, Some("glow"), paint, paint, paint, paint]);
            m.block("body", "paint", DVec3::splat(1.0), DVec3::splat(2.0));
            let made = Assembled::new(Arc::new(m.read(None)?), &way.settings(PatchTarget::Size(0.51)))?;
            let (inner, outer) = (made.of(|o| o == "body"), made.of(|o| o != "body"));
            Ok(if outwards { made.between(&inner, &outer) } else { made.between(&outer, &inner) })
        }
    };
    let law = "convex body in an enclosure: all it sees is the enclosure";
    let bodies = [
        Case::new(Group::Occlusion, "cube in a cube, from inside out", law, 1.0, inside(true)),
        Case::new(Group::Occlusion, "cube in a cube, from outside in", law, 6.0 / 54.0, inside(false)),
    ]
    .map(|case| case.lines(1e-6).hemicube(1e-6).because("rows are closed to 1e-7"));
    screens.into_iter().chain(bodies)
}
