//! The entries of placed lamps in a sidecar.

use super::colour::normalised;
use super::error::SceneError;
use super::names;
use super::photometric::{Attitude, PhotometricFiles};
use super::placed::{LampColour, LampKind, LampPhotometry, PlacedLamp, SINGLE};
use super::sidecar::Source;
use super::types::{LengthUnit, Luminaire, Scene, UpAxis};
use crate::photometry::MadeKind;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::sync::Arc;
use toml::Spanned;

/// Edge of a panel that gives no size, metres.
const USUAL_SIZE: f64 = 0.6;
/// Largest edge of a panel, metres.
const LARGEST: f64 = 1000.0;
/// Lamps of an array at most.
const MOST_IN_ARRAY: u32 = 1000;

/// A `[[lamp]]` of the sidecar; lengths in the file's unit.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LampEntry {
    pub(super) name: Spanned<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kind: Option<LampKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    photometry: Option<String>,
    position: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    aim: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    turn: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tilt: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    array: Option<[u32; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spacing: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cone: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lumens: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    colour: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cct: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    on: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dimmer: Option<f64>,
}

impl LampEntry {
    /// The entry that brings a lamp back.
    pub(super) fn of(lamp: &PlacedLamp, scene: &Scene) -> Self {
        let units = 1.0 / scene.unit.metres();
        let (colour, cct) = match lamp.colour {
            LampColour::Kelvin(kelvin) => (None, Some(kelvin)),
            LampColour::Linear(colour) => (Some(colour), None),
        };
        let light = lamp.photometric.as_ref();
        let file = light.and_then(|light| light.file.clone());
        let angle =
            |degrees: fn(&LampPhotometry) -> f64| light.map(degrees).filter(|degrees| *degrees != 0.0);
        let is_array = lamp.array != SINGLE;
        // The file's own stay the file's.
        let of_file = lamp.lumens_of_file(scene.up);
        let is_own = of_file.is_none_or(|own| (lamp.lumens - own).abs() > 1e-9 * own);
        Self {
            name: Spanned::new(0..0, lamp.name.clone()),
            kind: file.is_none().then_some(lamp.kind),
            position: scene.in_file(lamp.position).to_array().map(tidied),
            aim: Some(lamp.aim.to_array().map(tidied)),
            turn: angle(|light| light.turn),
            tilt: angle(|light| light.tilt),
            array: is_array.then_some(lamp.array),
            spacing: is_array.then(|| lamp.spacing.map(|step| tidied(step * units))),
            size: file.is_none().then(|| lamp.size.map(|edge| tidied(edge * units))),
            photometry: file,
            cone: lamp.cone.map(|cone| cone.map(tidied)),
            lumens: is_own.then_some(lamp.lumens),
            colour,
            cct,
            on: (!lamp.on).then_some(false),
            dimmer: (lamp.dimmer != 1.0).then_some(lamp.dimmer),
        }
    }

    /// Its photometry with the size of the opening, metres, or what is wrong with that.
    fn photometric(
        &self,
        metres: f64,
        files: &mut PhotometricFiles<'_>,
    ) -> Result<(Option<LampPhotometry>, [f64; 2]), String> {
        let given = self.size.map(|size| size.map(|edge| edge * metres));
        if given.is_some_and(|size| !size.iter().all(|edge| *edge > 0.0 && *edge <= LARGEST)) {
            return Err(format!("must have a size of two lengths above 0 and up to {LARGEST} m"));
        }
        let turned = |file, photometry| {
            let (turn, tilt) = (self.turn.unwrap_or(0.0), self.tilt.unwrap_or(0.0));
            let fault = Attitude { turn, tilt, aim: None }.fault();
            fault.map_or(Ok(LampPhotometry { file, photometry, turn, tilt }), Err)
        };
        let made = self.kind.and_then(LampKind::made);
        if let Some([inner, outer]) = self.cone {
            if self.kind != Some(LampKind::Spot) {
                return Err("has a cone, which only lamps of kind = \"spot\" have".to_owned());
            }
            if !(0.0 <= inner && inner < outer && outer <= 180.0) {
                let fault =
                    "must have a cone of two rising angles of 0 to 180 degrees, as in cone = [20, 40]";
                return Err(fault.to_owned());
            }
        }
        match (&self.photometry, made) {
            (Some(_), _) if self.kind.is_some() => Err("has both kind and photometry; give one".to_owned()),
            (Some(_), _) if self.size.is_some() => {
                Err("has both size and photometry, which holds the size already; remove size".to_owned())
            }
            (Some(file), _) => {
                let photometry = files.read(file)?;
                let opening = photometry.opening;
                Ok((Some(turned(Some(file.clone()), photometry)?), [opening.along_c0, opening.along_c90]))
            }
            (None, Some(made)) => {
                let size = given.unwrap_or(made.usual_size());
                let photometry = match self.cone {
                    Some(cone) => MadeKind::cone(cone, size),
                    None => made.photometry(size),
                };
                let photometry = photometry.map_err(|invalid| invalid.to_string())?;
                Ok((Some(turned(None, Arc::new(photometry))?), size))
            }
            (None, None) if self.turn.is_some() || self.tilt.is_some() => {
                Err("has a turn or tilt, which panels do not have; give an aim".to_owned())
            }
            (None, None) => Ok((None, given.unwrap_or([USUAL_SIZE; 2]))),
        }
    }

    /// Rows, columns and their distances in metres, or what is wrong with them.
    fn laid_out(&self, metres: f64) -> Result<([u32; 2], [f64; 2]), String> {
        let (array, spacing) = match (self.array, self.spacing) {
            (Some(array), Some(spacing)) => (array, spacing.map(|step| step * metres)),
            (None, None) => return Ok((SINGLE, [0.0; 2])),
            (Some(_), None) => {
                return Err("is an array without spacing = [between rows, between columns]".to_owned());
            }
            (None, Some(_)) => return Err("has a spacing without array = [rows, columns]".to_owned()),
        };
        let count = array[0].checked_mul(array[1]);
        if !count.is_some_and(|count| (1..=MOST_IN_ARRAY).contains(&count)) {
            return Err(format!("must have 1 to {MOST_IN_ARRAY} lamps in its array"));
        }
        if !spacing.iter().all(|step| step.is_finite() && (0.0..=LARGEST).contains(step)) {
            return Err(format!("must have a spacing of two lengths of 0 to {LARGEST} m"));
        }
        Ok((array, spacing))
    }

    /// The lamp in metres, or what is wrong with the entry.
    fn lamp(
        &self,
        (unit, up, origin): (LengthUnit, UpAxis, DVec3),
        files: &mut PhotometricFiles<'_>,
    ) -> Result<PlacedLamp, String> {
        let metres = unit.metres();
        let aim = self.aim.map_or(-up.vector(), DVec3::from);
        let position = DVec3::from(self.position) * metres - origin;
        if self.name.get_ref().trim().is_empty() {
            return Err("needs a name".to_owned());
        }
        if !position.is_finite() {
            return Err("must have a position of three numbers".to_owned());
        }
        let Some(aim) = aim.try_normalize().filter(|aim| aim.is_finite()) else {
            return Err("must have an aim, as in aim = [0, -1, 0] for one that shines downwards".to_owned());
        };
        let (photometric, size) = self.photometric(metres, files)?;
        let (array, spacing) = self.laid_out(metres)?;
        if self.lumens.is_some_and(|lumens| !(0.0..=1e12).contains(&lumens)) {
            return Err("must have lumens of 0 or more".to_owned());
        }
        if self.dimmer.is_some_and(|dimmer| !(0.0..=1.0).contains(&dimmer)) {
            return Err("must have a dimmer between 0 and 1".to_owned());
        }
        let colour = match (self.colour, self.cct) {
            (Some(_), Some(_)) => return Err("has both colour and cct; give one".to_owned()),
            (_, Some(kelvin)) if !(1000.0..=40_000.0).contains(&kelvin) => {
                return Err("must have a cct between 1000 and 40000 kelvin".to_owned());
            }
            (_, Some(kelvin)) => LampColour::Kelvin(kelvin),
            (Some(colour), None) => {
                let is_one = colour.iter().all(|c| c.is_finite() && (0.0..=1e12).contains(c));
                if !is_one || normalised(colour).is_none() {
                    let fault = "must have a colour of three numbers of 0 or more, not all 0";
                    return Err(fault.to_owned());
                }
                LampColour::Linear(colour)
            }
            (None, None) => LampColour::Linear([1.0; 3]),
        };
        let mut lamp = PlacedLamp {
            name: self.name.get_ref().clone(),
            kind: self.kind.unwrap_or_default(),
            cone: self.cone,
            position,
            aim,
            size,
            lumens: 0.0,
            colour,
            on: self.on.unwrap_or(true),
            dimmer: self.dimmer.unwrap_or(1.0),
            photometric,
            array,
            spacing,
        };
        let of_file = lamp.lumens_of_file(up);
        if of_file.is_none() && lamp.photometric.as_ref().is_some_and(|light| light.file.is_some()) {
            return Err("is dark: all intensities of its photometric file are 0".to_owned());
        }
        lamp.lumens = self.lumens.or(of_file).ok_or("needs its lumens, as in lumens = 3000")?;
        Ok(lamp)
    }
}

/// A number without what changes of unit add in its last digits.
fn tidied(value: f64) -> f64 {
    let rounded = (value * 1e6).round() * 1e-6;
    // Through text: the nearest number to what a person reads.
    format!("{rounded:.6}").parse().unwrap_or(value) + 0.0
}

/// The lamps of a sidecar in metres, for a file of this unit and up axis whose positions count from the third,
/// metres; `others` are the luminaires that the model has without them.
pub(super) fn read(
    entries: &[LampEntry],
    frame: (LengthUnit, UpAxis, DVec3),
    others: &[Luminaire],
    source: Source<'_>,
    files: &mut PhotometricFiles<'_>,
) -> Result<Vec<PlacedLamp>, SceneError> {
    let mut taken: HashSet<&str> = others.iter().map(|lamp| lamp.name.as_str()).collect();
    let mut lamps = Vec::with_capacity(entries.len());
    for entry in entries {
        let name = entry.name.get_ref();
        let fail = |fault: &str| {
            source.error_at(entry.name.span().start, format!("the lamp '{}' {fault}", names::short(name)))
        };
        lamps.push(entry.lamp(frame, files).map_err(|fault| fail(&fault))?);
        if !taken.insert(name) {
            return Err(fail("is there twice; names of lamps must differ"));
        }
    }
    Ok(lamps)
}
