//! Whole solutions with a published or closed-form answer.

use super::scenes::cube;
use super::{Assembled, Case, CaseError, Group, Model, Way};
use crate::mesh::PatchTarget;
use crate::scene::illuminance;
use glam::{DVec3, dvec3};
use std::sync::Arc;

const SIX: &str = "six patches, solved exactly with Hottel's and Hamilton's form factors";
const THREE: &str = "three zones, solved exactly with closed-form factors";
const SPHERE: &str = "sphere: F = area / area of the whole";
const CIE: &str = "CIE 171:2006, 5.8: flux / (area (1 - rho))";

pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    for (rho, expected) in [
        (0.5, [1.090_909_098_107_695, 0.181_745_826_107_788_5, 0.181_836_268_946_129]),
        (0.9, [2.372_881_374_825_758, 1.525_310_551_124_541, 1.525_452_018_512_426]),
    ] {
        for (object, b) in ["ceiling", "floor", "west"].into_iter().zip(expected) {
            let name = format!("cube of six patches at rho {rho}, lit by its ceiling: B of the {object}");
            cases.push(
                Case::new(Group::Solutions, name, SIX, b, move |way| {
                    let made =
                        Assembled::new(Arc::new(cube().read(None)?), &way.settings(PatchTarget::AsGiven))?;
                    let lit = made.of(|o| o == "ceiling");
                    let exitance = |i: usize| if lit.contains(&i) { 1.0 } else { 0.0 };
                    let b = made.radiosity(&made.grey_system(|i| (rho, exitance(i))), 1e-9)?;
                    Ok(made.mean(&made.of(|o| o == object), |i| b[i]))
                })
                .all_methods(2e-5)
                .because("one patch a face: contour integrals"),
            );
        }
    }
    for (zone, name, b) in
        [(0, "ceiling", 112.255_084_44), (1, "walls", 21.166_116_42), (2, "floor", 10.458_132_48)]
    {
        let name = format!("room 6 x 4 x 3 m of three zones: B of the {name}");
        cases.push(
            Case::new(Group::Solutions, name, THREE, b, move |way| Ok(three_zones(way)?[zone]))
                .lines(1e-3)
                .hemicube(3e-3)
                .because("zones of 0.8 m patches, their form factors summed"),
        );
    }
    for (emits, b) in [(true, 1.347_826_086_956_5), (false, 0.130_434_782_608_7)] {
        let name = format!("sphere of two zones: B of the {}", if emits { "lit one" } else { "other" });
        cases.push(
            Case::new(Group::Solutions, name, SPHERE, b, move |way| sphere(emits, way))
                .lines(0.01)
                .because("facets: a zone has not quite its share, and no facet sees itself"),
        );
    }
    for (rho, lux) in
        [(0.0, 104.166_666_7), (0.5, 208.333_333_3), (0.8, 520.833_333_3), (0.95, 2_083.333_333_3)]
    {
        cases.push(
            Case::new(
                Group::Solutions,
                format!("sealed 4 m cube, 10,000 lm, rho {rho}: mean lux"),
                CIE,
                lux,
                move |way| cie_5_8(rho, way),
            )
            .lines(1e-3)
            .hemicube(1e-3)
            .because("a lamp of 0.1 m in place of a point takes 0.06 % of the area"),
        );
    }
    cases
}

/// The radiosities of ceiling, walls and floor, each taken as constant, by form factors between them.
fn three_zones(way: Way) -> Result<[f64; 3], CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.7; 3], [100.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, dvec3(6.0, 3.0, 4.0), [paint, Some("glow"), paint, paint, paint, paint]);
    let made = Assembled::new(Arc::new(m.read(None)?), &way.settings(PatchTarget::Size(0.81)))?;
    let zones =
        [made.of(|o| o == "ceiling"), made.of(|o| o != "ceiling" && o != "floor"), made.of(|o| o == "floor")];
    let (rho, e) = ([0.7, 0.5, 0.2], [100.0, 0.0, 0.0]);
    let f: Vec<Vec<f64>> =
        zones.iter().map(|from| zones.iter().map(|to| made.between(from, to)).collect()).collect();
    let mut b = e;
    for _ in 0..200 {
        for i in 0..3 {
            b[i] = e[i] + rho[i] * (0..3).map(|j| f[i][j] * b[j]).sum::<f64>();
        }
    }
    Ok(b)
}

/// Mean radiosity of the emitting quarter of a sphere (rho 0.8) or of the rest (rho 0.3).
fn sphere(emits: bool, way: Way) -> Result<f64, CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.3).paint("glow", [0.8; 3], [1.0; 3]);
    m.sphere([-1.0, 1.0], [16, 24], &|ring| if ring >= 12 { "glow" } else { "paint" });
    let made = Assembled::new(Arc::new(m.read_one_sided()?), &way.settings(PatchTarget::AsGiven))?;
    let lit = |i: usize| made.patches()[i].luminaire.is_some();
    let b = made.radiosity(&made.grey_system(|i| if lit(i) { (0.8, 1.0) } else { (0.3, 0.0) }), 1e-8)?;
    let zone: Vec<usize> = (0..b.len()).filter(|&i| lit(i) == emits).collect();
    Ok(made.mean(&zone, |i| b[i]))
}

/// Mean illuminance on the walls of a sealed cube with a small lamp in its middle, lux.
fn cie_5_8(rho: f64, way: Way) -> Result<f64, CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.98; 3], [1.0; 3]);
    m.room(DVec3::ZERO, DVec3::splat(4.0), [Some("paint"); 6]);
    m.block("lamp", "glow", DVec3::splat(1.95), DVec3::splat(2.05));
    let sidecar = "[[luminaire]]\nobject = \"lamp\"\nname = \"Lamp\"\nlumens = 10000\n";
    let made = Assembled::new(Arc::new(m.read(Some(sidecar))?), &way.settings(PatchTarget::Size(0.5)))?;
    let reflectance: Vec<[f64; 3]> =
        made.patches().iter().map(|p| [if p.luminaire.is_some() { 0.98 } else { rho }; 3]).collect();
    let irradiance = made.irradiance(&made.system(Some(&reflectance)), 1e-7)?;
    Ok(made.mean(&made.of(|o| o != "lamp"), |i| illuminance(irradiance[i].map(f64::from))))
}
