//! Lights without a surface that come with a model file, as placed lamps: they are edited and kept as those.

use super::finding::{Finding, FindingKind, Severity};
use super::model::BareLight;
use super::names;
use super::placed::{LampColour, LampKind, LampPhotometry, PlacedLamp, SINGLE};
use super::types::{LengthUnit, Luminaire, luminance_weighted};
use crate::photometry::{InvalidDistribution, MadeKind};
use glam::DVec3;
use std::collections::HashSet;
use std::sync::Arc;

/// Where the file is in the scene: its unit, and where the scene counts from, metres.
type Frame = (LengthUnit, DVec3);

/// The lamps that the lights of a file are, besides its luminaires.
pub(super) fn lamps(
    lights: &[BareLight],
    luminaires: &[Luminaire],
    frame: Frame,
    findings: &mut Vec<Finding>,
) -> Vec<PlacedLamp> {
    let mut taken: HashSet<String> = luminaires.iter().map(|lamp| lamp.name.clone()).collect();
    let (mut lamps, mut unread) = (Vec::new(), Vec::new());
    for light in lights {
        match lamp(light, frame) {
            Ok(mut lamp) => {
                lamp.name = names::unique(&names::pretty(&light.name), &mut taken);
                lamps.push(lamp);
            }
            Err(_) => unread.push(light.name.as_str()),
        }
    }
    if !lamps.is_empty() {
        let message = format!(
            "lights without a surface became lamps, bulbs and spots ({}: {}); those that a sidecar holds replace them",
            lamps.len(),
            names::list(lamps.iter().map(|lamp| lamp.name.as_str()))
        );
        findings.push(Finding::new(FindingKind::Lamp, Severity::Note, message).counted(lamps.len()));
    }
    if !unread.is_empty() {
        let message = format!("lights that cannot be used were left out ({})", names::list(unread));
        findings.push(Finding::new(FindingKind::Lamp, Severity::Warning, message));
    }
    lamps
}

fn lamp(light: &BareLight, (unit, origin): Frame) -> Result<PlacedLamp, InvalidDistribution> {
    let (kind, made) = match light.cone {
        Some(_) => (LampKind::Spot, MadeKind::Spot),
        None => (LampKind::Bulb, MadeKind::Bulb),
    };
    let size = made.usual_size();
    let cone = light.cone.map(|half| half.map(|angle| 2.0 * angle.to_degrees()));
    let photometry = match cone {
        Some(cone) => MadeKind::cone(cone, size)?,
        None => made.photometry(size)?,
    };
    // The colour says how strongly each band shines, and with that how strongly all do.
    let candelas = light.candelas * luminance_weighted(light.colour);
    let lumens = candelas * photometry.flux() / photometry.distribution.maximum().candela;
    Ok(PlacedLamp {
        name: light.name.clone(),
        kind,
        position: light.position * unit.metres() - origin,
        aim: light.aim,
        size,
        lumens,
        colour: LampColour::Linear(light.colour),
        on: true,
        dimmer: 1.0,
        photometric: Some(LampPhotometry {
            file: None,
            photometry: Arc::new(photometry),
            turn: 0.0,
            tilt: 0.0,
        }),
        array: SINGLE,
        spacing: [0.0; 2],
        cone,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn light(cone: Option<[f64; 2]>) -> BareLight {
        BareLight {
            name: "light_a".to_owned(),
            position: DVec3::new(1.0, 2.0, 3.0),
            aim: DVec3::NEG_Y,
            colour: [1.0; 3],
            candelas: 50.0,
            cone,
        }
    }

    #[test]
    fn a_point_sends_its_candelas_all_around_and_a_spot_into_its_cone() {
        let mut findings = Vec::new();
        let lights = [light(None), light(Some([20.0_f64.to_radians(), 20.01_f64.to_radians()]))];
        let made = lamps(&lights, &[], (LengthUnit::Metre, DVec3::ZERO), &mut findings);
        assert_eq!((made[0].name.as_str(), made[1].name.as_str()), ("Light a", "Light a 2"));
        assert!((made[0].lumens - 50.0 * 4.0 * PI).abs() < 1e-6, "{}", made[0].lumens);
        // The solid angle of a cone.
        let cone = 50.0 * 2.0 * PI * (1.0 - 20.0_f64.to_radians().cos());
        assert!((made[1].lumens / cone - 1.0).abs() < 5e-3, "{} and {cone}", made[1].lumens);
        let spot = made[1].photometric.as_ref().map(|light| light.photometry.clone()).unwrap();
        let at = |degrees: f64| {
            spot.intensity(DVec3::new(degrees.to_radians().sin(), 0.0, -degrees.to_radians().cos()))
        };
        assert!((at(19.0) / at(0.0) - 1.0).abs() < 1e-9 && at(20.5) == 0.0, "{} {}", at(19.0), at(20.5));
        assert_eq!(findings.len(), 1);
    }

    #[test]
    fn a_colour_counts_by_its_luminance() {
        let red = BareLight { colour: [2.0, 0.0, 0.0], ..light(None) };
        let made = lamps(&[red], &[], (LengthUnit::Centimetre, DVec3::X), &mut Vec::new());
        assert!((made[0].lumens - 50.0 * 4.0 * PI * 2.0 * 0.2126).abs() < 1e-6);
        assert!(made[0].position.abs_diff_eq(DVec3::new(-0.99, 0.02, 0.03), 1e-12));
    }
}
