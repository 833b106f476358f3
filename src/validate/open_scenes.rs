//! Scenes from which light escapes: what leaves is reported, never taken back.

use super::{Assembled, Case, CaseError, Group, Model, Way};
use crate::form_factors::closed_form::parallel_rectangles;
use crate::mesh::PatchTarget;
use crate::scene::{SceneSource, load};
use glam::DVec3;
use std::sync::Arc;

const CAP: &str = "sphere: F = area / area of the whole";
const FACETS: &str = "facets have less area than the round cap, by 0.7 %";
const BALANCE: &str = "emitted = absorbed + escaped";

pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    cases.push(
        Case::new(
            Group::OpenScenes,
            "open unit box: what escapes is its opening",
            "reciprocity",
            1.0,
            |way| {
                let made = open_box(way)?;
                let all = made.of(|_| true);
                Ok(made.escaping(&all) * made.area(&all))
            },
        )
        .lines(3e-3)
        .hemicube(3e-3)
        .because("openings are sampled, from one point a patch"),
    );
    cases.push(
        Case::new(
            Group::OpenScenes,
            "open unit box: what escapes from its floor",
            "Hottel 1931 (Howell C-11)",
            0.199_824_895_698_387,
            |way| {
                let made = open_box(way)?;
                Ok(made.escaping(&made.of(|o| o == "floor")))
            },
        )
        .lines(5e-3)
        .hemicube(5e-3)
        .because("openings are sampled, from one point a patch"),
    );
    for (degrees, kept) in [(60.0_f64, 0.25), (90.0, 0.5), (120.0, 0.75)] {
        let name = format!("spherical cap of {degrees} degrees: what stays in it");
        cases.push(
            Case::new(Group::OpenScenes, name, CAP, kept, move |way| {
                let made = cap(degrees, way)?;
                Ok(1.0 - made.escaping(&made.of(|_| true)))
            })
            .lines(0.015)
            .because(FACETS),
        );
    }
    for (degrees, b) in [(90.0_f64, 5.0 / 3.0), (120.0, 2.5)] {
        let name = format!("spherical cap of {degrees} degrees at rho 0.8: B");
        cases.push(
            Case::new(Group::OpenScenes, name, "B = E / (1 - rho (1 - cos t) / 2)", b, move |way| {
                let made = cap(degrees, way)?;
                let b = made.radiosity(&made.grey_system(|_| (0.8, 1.0)), 1e-8)?;
                Ok(made.mean(&made.of(|_| true), |i| b[i]))
            })
            .lines(0.02)
            .because(FACETS),
        );
    }
    let (e, rho, gap) = ([3.0, 1.0], [0.6, 0.8], 0.1);
    let f = parallel_rectangles(1.0, 1.0, gap);
    cases.push(
        Case::new(
            Group::OpenScenes,
            "two plates at a tenth of their width: B",
            "B1 = (E1 + rho1 F E2) / (1 - rho1 rho2 F²)",
            (e[0] + rho[0] * f * e[1]) / (1.0 - rho[0] * rho[1] * f * f),
            move |way| Ok(plates(gap, e, rho, way)?[0]),
        )
        .all_methods(3e-4)
        .because("one patch each: the contour integral"),
    );
    cases.push(
        Case::new(
            Group::OpenScenes,
            "two plates at a millionth of their width: B",
            "infinite plates: B1 = (E1 + rho1 E2) / (1 - rho1 rho2)",
            (e[0] + rho[0] * e[1]) / (1.0 - rho[0] * rho[1]),
            move |way| Ok(plates(1e-6, e, rho, way)?[0]),
        )
        .all_methods(3e-4)
        .because("one patch each: the contour integral"),
    );
    cases.push(
        Case::new(Group::OpenScenes, "measured Cornell box, open in front: power", BALANCE, 1.0, |way| {
            let scene = Arc::new(load(&SceneSource::Builtin("cornell".to_owned()))?);
            let made = Assembled::new(scene, &way.settings(PatchTarget::Count(400)))?;
            balance(&made)
        })
        .lines(1e-6)
        .hemicube(1e-6)
        .because("swept until the error bound is 1e-8"),
    );
    cases
}

/// (Absorbed + escaped) / emitted, with the lamps as they come.
pub(super) fn balance(made: &Assembled) -> Result<f64, CaseError> {
    let (_, reports) = made.sweep(&made.system(None), 1e-8)?;
    let last = reports.last().copied().unwrap_or_default();
    Ok((last.absorbed + last.escaped) / last.emitted)
}

fn open_box(way: Way) -> Result<Assembled, CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, DVec3::ONE, [Some("glow"), None, paint, paint, paint, paint]);
    Assembled::new(Arc::new(m.read_one_sided()?), &way.settings(PatchTarget::Size(0.126)))
}

fn cap(degrees: f64, way: Way) -> Result<Assembled, CaseError> {
    let mut m = Model::new();
    m.paint("glow", [0.8; 3], [1.0; 3]);
    m.sphere([degrees.to_radians().cos(), 1.0], [14, 32], &|_| "glow");
    Assembled::new(Arc::new(m.read_one_sided()?), &way.settings(PatchTarget::AsGiven))
}

fn plates(gap: f64, e: [f64; 2], rho: [f64; 2], way: Way) -> Result<Vec<f64>, CaseError> {
    let mut m = Model::new();
    m.paint("one", [rho[0]; 3], [e[0]; 3]).paint("two", [rho[1]; 3], [e[1]; 3]);
    m.object("one").quad("one", DVec3::ZERO, DVec3::X, DVec3::Y);
    m.object("two").quad("two", DVec3::Z * gap, DVec3::Y, DVec3::X);
    let made = Assembled::new(Arc::new(m.read_one_sided()?), &way.settings(PatchTarget::AsGiven))?;
    made.radiosity(&made.grey_system(|i| (rho[i], e[i])), 1e-9)
}
