//! Lamps: small, hidden, many, weak and strong.

use super::scenes::{lit_room_with_blocks, room_with_blocks};
use super::{Assembled, Case, CaseError, Group, Model, Way};
use crate::form_factors::closed_form::point_to_polygon;
use crate::mesh::PatchTarget;
use crate::solve::{Control, solve};
use crate::solver::System;
use glam::{DVec3, dvec3};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const LAMBERT: &str = "Lambert 1760 (Howell B-3)";

pub(super) fn cases() -> Vec<Case> {
    let size = 1e-3;
    let height = 10.0;
    let lamp = small_lamp(size, height);
    let below = dvec3(50.0, 0.0, 50.0);
    let aside = dvec3(70.0, 0.0, 45.0);
    let mut cases = Vec::new();
    for (name, point) in [("under it", below), ("20 m aside", aside)] {
        let exact = point_to_polygon(point, DVec3::Y, &lamp) * 1e6;
        cases.push(
            Case::new(
                Group::Lamps,
                format!("1 mm lamp in a 100 m hall: irradiance {name}"),
                LAMBERT,
                exact,
                move |way| hall_point(size, height, point, way),
            )
            .lines(1e-3)
            .because("points are lifted by 1e-5 of the scene, 1.4 mm of 10 m"),
        );
    }
    // Four corner rectangles of 50 x 50 m at 10 m, each by Lambert's formula.
    let corner = [dvec3(0.0, 0.0, 0.0), dvec3(50.0, 0.0, 0.0), dvec3(50.0, 0.0, 50.0), dvec3(0.0, 0.0, 50.0)];
    let floor = 4.0 * point_to_polygon(DVec3::Y * height, DVec3::NEG_Y, &corner);
    cases.push(
        Case::new(
            Group::Lamps,
            "1 mm lamp in a 100 m hall: share of its light on the floor",
            LAMBERT,
            floor,
            move |way| {
                let made = hall(size, height, way)?;
                let lamp: Vec<usize> =
                    (0..made.patches().len()).filter(|&i| made.patches()[i].luminaire.is_some()).collect();
                Ok(made.between(&lamp, &made.of(|o| o == "floor")))
            },
        )
        .lines(1e-3)
        .hemicube(1e-2)
        .rays(1e-2)
        .because("a lamp smaller than any cell is not lost: the lamp's own row counts it"),
    );
    cases.push(
        Case::new(
            Group::Lamps,
            "lamp in a closed box: what the room around it gets, plus one",
            "nothing passes closed walls",
            1.0,
            |way| {
                let mut m = room_with_blocks(0.5);
                m.block("box", "paint", dvec3(3.0, 1.0, 0.5), dvec3(3.5, 1.5, 1.0));
                let inside = Some("bright");
                m.paint("bright", [0.5; 3], [50.0; 3]);
                m.room(
                    dvec3(3.01, 1.01, 0.51),
                    dvec3(3.49, 1.49, 0.99),
                    [None, inside, None, None, None, None],
                );
                let made = Assembled::new(Arc::new(m.read(None)?), &way.settings(PatchTarget::Count(400)))?;
                let bright = made.prepared.scene.luminaires.iter().position(|l| l.area < 0.3).unwrap_or(1);
                let mut lighting = made.lighting();
                lighting.lamps.iter_mut().enumerate().for_each(|(k, lamp)| lamp.on = k == bright);
                let (bases, _) = made.sweep(&made.system(None), 1e-8)?;
                let light = bases.mix(&made.prepared.mesh, &lighting, &[]);
                let walls = made.of(|o| o == "floor" || o == "west");
                Ok(1.0 + made.mean(&walls, |i| f64::from(light.irradiance[i][0])) / 50.0)
            },
        )
        .lines(1e-9)
        .hemicube(1e-9)
        .because("what is not seen is not seen at all"),
    );
    cases.push(
        Case::new(
            Group::Lamps,
            "64 lamps: the worst patch of their sum over a solve with all at once",
            "linearity in emission",
            1.0,
            superposition,
        )
        .lines(1e-6)
        .because("single precision of the bases"),
    );
    for exponent in [-12, 12] {
        let factor = 10.0_f64.powi(exponent);
        cases.push(
            Case::new(
                Group::Lamps,
                format!("lamp of 1e{exponent} of its exitance: the worst patch, scaled back"),
                "linearity in emission",
                1.0,
                move |way| {
                    let light = |exitance: f64| -> Result<Vec<f64>, CaseError> {
                        let scene = Arc::new(lit_room_with_blocks(0.5, exitance).read(None)?);
                        let made = Assembled::new(scene, &way.settings(PatchTarget::Count(300)))?;
                        let irradiance = made.irradiance(&made.system(None), 1e-8)?;
                        Ok(irradiance.iter().map(|h| f64::from(h[0]) / exitance).collect())
                    };
                    super::extremes::worst_ratio(&light(factor)?, &light(1.0)?)
                },
            )
            .lines(1e-5)
            .because("what extremes are held to"),
        );
    }
    cases
}

/// A lamp that looks down from the middle of the hall.
fn small_lamp(size: f64, height: f64) -> [DVec3; 4] {
    let at = dvec3(50.0 - 0.5 * size, height, 50.0 - 0.5 * size);
    [at, at + DVec3::X * size, at + dvec3(size, 0.0, size), at + DVec3::Z * size]
}

/// A black hall of 100 x 20 x 100 m with a lamp of edge `size` and exitance 1e6 W/m².
fn hall_model(size: f64, height: f64) -> Model {
    let mut m = Model::new();
    m.grey("black", 0.0).paint("glow", [0.0; 3], [1e6; 3]);
    m.room(DVec3::ZERO, dvec3(100.0, 20.0, 100.0), [Some("black"); 6]);
    m.object("lamp").polygon("glow", &small_lamp(size, height));
    m
}

fn hall(size: f64, height: f64, way: Way) -> Result<Assembled, CaseError> {
    Assembled::new(Arc::new(hall_model(size, height).read(None)?), &way.settings(PatchTarget::Size(10.1)))
}

/// Irradiance at a free point of the hall's floor, W/m².
fn hall_point(size: f64, height: f64, point: DVec3, way: Way) -> Result<f64, CaseError> {
    let scene = Arc::new(hall_model(size, height).read(None)?);
    let settings = way.settings(PatchTarget::Size(10.1));
    let solved = solve(scene.clone(), &settings, &AtomicBool::new(false), &mut |_| Control::Continue)?;
    let light = solved.light(&scene.lighting());
    Ok(solved.irradiance_at(&[(point, DVec3::Y)], &light)[0][0])
}

/// Sums 64 bases, and solves once with all lamps as one; the ratio that is furthest from one.
fn superposition(way: Way) -> Result<f64, CaseError> {
    let mut m = Model::new();
    m.grey("paint", 0.6);
    m.room(DVec3::ZERO, dvec3(8.0, 3.0, 8.0), [Some("paint"); 6]);
    for k in 0..64_u32 {
        let (i, j) = (f64::from(k % 8), f64::from(k / 8));
        let name = format!("glow_{k}");
        m.paint(&name, [0.3; 3], [1.0 + 0.3 * f64::from(k); 3]);
        m.object(&format!("lamp_{k}"));
        m.quad(&name, dvec3(i + 0.4, 2.5, j + 0.4), DVec3::X * 0.2, DVec3::Z * 0.2);
    }
    let made = Assembled::new(Arc::new(m.read(None)?), &way.settings(PatchTarget::Count(300)))?;
    let system = made.system(None);
    let mixed = made.irradiance(&system, 1e-8)?;
    let lighting = made.lighting();
    let all = System {
        lamps: 1,
        emission: made
            .patches()
            .iter()
            .map(|p| p.luminaire.map(|l| (0, lighting.lamps[l as usize].output())))
            .collect(),
        output: vec![1.0; system.bands],
        direct: None,
        ..system
    };
    let (bases, _) = made.sweep(&all, 1e-8)?;
    let direct: Vec<f64> = bases.values.iter().step_by(all.bands).map(|&h| f64::from(h)).collect();
    let mixed: Vec<f64> = mixed.iter().map(|h| f64::from(h[0])).collect();
    super::extremes::worst_ratio(&mixed, &direct)
}
