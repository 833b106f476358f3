//! The sidecar `NAME.toml` beside `NAME.obj`: what an OBJ file cannot say.

use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::glass::Asked;
use super::lamp_entry::LampEntry;
use super::mtl::repair_reflectance;
use super::names;
use super::outdoors::DaylightChoice;
use super::photometric::Attitude;
use super::selection::{material_names, meant};
use super::text::folded;
use super::translucent;
use super::types::{LengthUnit, MAX_REFLECTANCE, Material, Sides, UpAxis, View};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use toml::Spanned;

/// The file as it is written. Every key is optional; unknown keys are errors.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sidecar {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) unit: Option<UnitKey>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) up: Option<UpKey>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) start: Option<Spanned<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) patch_size: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) daylight: Option<Spanned<DaylightChoice>>,
    #[serde(default, rename = "view", skip_serializing_if = "Vec::is_empty")]
    pub(super) views: Vec<ViewEntry>,
    #[serde(default, rename = "luminaire", skip_serializing_if = "Vec::is_empty")]
    pub(super) luminaires: Vec<Spanned<LuminaireEntry>>,
    /// All lamps that are to be placed, if it says so: `lamp = []` keeps away those that come with the model file.
    #[serde(default, rename = "lamp", skip_serializing_if = "Option::is_none")]
    pub(super) lamps: Option<Vec<LampEntry>>,
    #[serde(default, rename = "material", skip_serializing_if = "Vec::is_empty")]
    pub(super) materials: Vec<MaterialEntry>,
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(super) enum UnitKey {
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "m")]
    Metre,
    #[serde(rename = "in")]
    Inch,
    #[serde(rename = "ft")]
    Foot,
}

impl From<UnitKey> for LengthUnit {
    fn from(key: UnitKey) -> Self {
        match key {
            UnitKey::Millimetre => Self::Millimetre,
            UnitKey::Centimetre => Self::Centimetre,
            UnitKey::Metre => Self::Metre,
            UnitKey::Inch => Self::Inch,
            UnitKey::Foot => Self::Foot,
        }
    }
}

impl From<LengthUnit> for UnitKey {
    fn from(unit: LengthUnit) -> Self {
        match unit {
            LengthUnit::Millimetre => Self::Millimetre,
            LengthUnit::Centimetre => Self::Centimetre,
            LengthUnit::Metre => Self::Metre,
            LengthUnit::Inch => Self::Inch,
            LengthUnit::Foot => Self::Foot,
        }
    }
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum UpKey {
    Y,
    Z,
}

/// A bookmark; lengths in the file's unit.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ViewEntry {
    pub(super) name: Spanned<String>,
    pub(super) eye: [f64; 3],
    pub(super) target: [f64; 3],
    #[serde(default = "default_fov")]
    pub(super) fov: f64,
}

fn default_fov() -> f64 {
    60.0
}

/// A lamp: which surfaces it is made of, how strong it is, how it is switched at first.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LuminaireEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) object: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) objects: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) material: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) materials: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) lumens: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exitance: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) colour: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cct: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) on: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) dimmer: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) emits: Option<EmitsKey>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) photometry: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) aim: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) turn: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) tilt: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum EmitsKey {
    #[default]
    Front,
    Back,
    Both,
}

/// What a material is besides what the MTL says.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialEntry {
    pub(super) name: Spanned<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reflectance: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sides: Option<SidesKey>,
    /// Of glass: what passes along the normal, 0 to 1, in all bands or in each; of a unit of several panes of the whole unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) transmittance: Option<SharesKey>,
    /// How many panes the glass is, one behind the other; one otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) panes: Option<u32>,
    /// Whether it is glass: `false` makes opaque what the MTL has as glass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) glass: Option<bool>,
    /// What passes diffusely from one side to the other: of cloth, paper, opal glass.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) translucence: Option<SharesKey>,
}

/// A share of light, in all bands or in each.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged, expecting = "a number from 0 to 1, or three of them in brackets")]
pub(super) enum SharesKey {
    All(f64),
    Each([f64; 3]),
}

impl SharesKey {
    pub(super) fn bands(self) -> [f64; 3] {
        match self {
            Self::All(share) => [share; 3],
            Self::Each(shares) => shares,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum SidesKey {
    Auto,
    Front,
    Both,
}

impl From<SidesKey> for Sides {
    fn from(key: SidesKey) -> Self {
        match key {
            SidesKey::Auto => Self::Auto,
            SidesKey::Front => Self::Front,
            SidesKey::Both => Self::Both,
        }
    }
}

/// A sidecar text with the name that messages use.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// An error at a byte offset of the text.
    pub(super) fn error_at(&self, offset: usize, message: impl Into<String>) -> SceneError {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        SceneError::line(self.file, before.iter().filter(|b| **b == b'\n').count() + 1, message)
    }

    /// Parses the text and checks every number that does not need the model.
    pub(super) fn parse(&self) -> Result<Sidecar, SceneError> {
        let text = self.text.strip_prefix('\u{feff}').unwrap_or(self.text);
        let skipped = self.text.len() - text.len();
        let sidecar: Sidecar = toml::from_str(text).map_err(|error| {
            let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
            let message = message.replacen("unknown field", "unknown key", 1).replace('`', "'");
            self.error_at(skipped + error.span().map_or(0, |span| span.start), message)
        })?;
        if let Some(size) = &sidecar.patch_size
            && !(size.get_ref().is_finite() && *size.get_ref() > 0.0)
        {
            return Err(self.error_at(size.span().start, "patch_size must be a length in metres above 0"));
        }
        Ok(sidecar)
    }
}

impl Sidecar {
    /// The unit, where it is stated.
    pub(super) fn unit(&self) -> Option<LengthUnit> {
        self.unit.map(Into::into)
    }

    /// The up axis, where it is stated.
    pub(super) fn up(&self) -> Option<UpAxis> {
        self.up.map(|up| match up {
            UpKey::Y => UpAxis::Y,
            UpKey::Z => UpAxis::Z,
        })
    }

    /// The bookmarks in metres from `origin`, of a file in this unit; empty where there are none.
    pub(super) fn views(
        &self,
        source: Source<'_>,
        unit: LengthUnit,
        origin: DVec3,
    ) -> Result<Vec<View>, SceneError> {
        let metres = unit.metres();
        let mut taken = HashSet::new();
        let mut views = Vec::with_capacity(self.views.len());
        for entry in &self.views {
            let name = entry.name.get_ref();
            let fail = |message: String| Err(source.error_at(entry.name.span().start, message));
            if name.trim().is_empty() {
                return fail("a view needs a name".to_owned());
            }
            if !taken.insert(name.clone()) {
                return fail(format!("two views are named '{}'; names must differ", names::short(name)));
            }
            let (eye, target) =
                (DVec3::from(entry.eye) * metres - origin, DVec3::from(entry.target) * metres - origin);
            if !(eye.is_finite() && target.is_finite() && eye.distance(target) > 1e-9) {
                return fail(format!(
                    "the view '{}' must look from one point to another",
                    names::short(name)
                ));
            }
            if !(5.0..=150.0).contains(&entry.fov) {
                let name = names::short(name);
                return fail(format!(
                    "the fov of view '{name}' must lie between 5 and 150 degrees, not {}",
                    entry.fov
                ));
            }
            views.push(View { name: name.clone(), eye, target, fov_y_deg: entry.fov });
        }
        Ok(views)
    }

    /// Index of the view that `start` names, if it names one.
    pub(super) fn start(&self, views: &[View], source: Source<'_>) -> Result<Option<usize>, SceneError> {
        let Some(start) = &self.start else { return Ok(None) };
        let wanted = start.get_ref();
        let found = views.iter().position(|v| v.name == *wanted);
        found
            .or_else(|| views.iter().position(|v| folded(&v.name) == folded(wanted)))
            .ok_or_else(|| {
                let known = names::list(views.iter().map(|v| v.name.as_str()));
                let message =
                    format!("start names the view '{}', and there are {known}", names::short(wanted));
                source.error_at(start.span().start, message)
            })
            .map(Some)
    }

    /// Applies the material entries.
    pub(super) fn apply_materials(
        &self,
        materials: &mut [Material],
        source: Source<'_>,
        findings: &mut Vec<Finding>,
    ) -> Result<(), SceneError> {
        for entry in &self.materials {
            let name = entry.name.get_ref();
            let index = meant(name, &material_names(materials)).map_err(|several| {
                let (name, several) = (names::short(name), names::list(several));
                let message =
                    format!("'{name}' could be any of the materials {several}; write the name as it is");
                source.error_at(entry.name.span().start, message)
            })?;
            let Some(&index) = index.first() else {
                let near = names::nearest(name, materials.iter().map(|m| m.name.as_str()));
                let (name, near) = (names::short(name), names::list(near));
                let message = format!("there is no material '{name}'; the nearest names are {near}");
                return Err(source.error_at(entry.name.span().start, message));
            };
            let material = &mut materials[index];
            if let Some(reflectance) = entry.reflectance {
                if reflectance.iter().any(|r| !r.is_finite() || *r < 0.0) {
                    let message =
                        format!("the reflectance of '{}' must lie between 0 and 1", names::short(name));
                    return Err(source.error_at(entry.name.span().start, message));
                }
                let largest = if material.texture.is_some() { 1.0 } else { MAX_REFLECTANCE };
                let (repaired, change) = repair_reflectance(reflectance, largest);
                material.reflectance = repaired;
                if let Some(change) = change {
                    let message = format!(
                        "material '{}' has in {} a reflectance {change}",
                        names::short(name),
                        source.file
                    );
                    findings.push(Finding::new(FindingKind::Material, Severity::Warning, message));
                }
            }
            if let Some(sides) = entry.sides {
                material.sides = sides.into();
            }
            let (at, short) = (entry.name.span().start, names::short(name));
            let fault = |fault: String| source.error_at(at, format!("'{short}' {fault}"));
            let asked = Asked { transmittance: entry.transmittance, panes: entry.panes, glass: entry.glass };
            if let Some(translucence) = entry.translucence {
                if asked.is_glass() {
                    let message = "is glass (transmittance, panes or glass), which takes no translucence";
                    return Err(fault(message.to_owned()));
                }
                let lowered = translucent::apply(translucence.bands(), material).map_err(fault)?;
                if let Some(change) = lowered {
                    let message = format!("material '{short}' {change} ({})", source.file);
                    findings.push(Finding::new(FindingKind::Material, Severity::Warning, message));
                }
            }
            asked.apply(material).map_err(fault)?;
        }
        Ok(())
    }
}

impl LuminaireEntry {
    /// The objects selected by name; empty selects all.
    pub(super) fn objects(&self) -> impl Iterator<Item = &str> {
        self.object.iter().chain(&self.objects).map(String::as_str)
    }

    /// The materials selected by name; empty selects all.
    pub(super) fn materials(&self) -> impl Iterator<Item = &str> {
        self.material.iter().chain(&self.materials).map(String::as_str)
    }

    /// The name that a user reads.
    pub(super) fn display_name(&self) -> String {
        match &self.name {
            Some(name) => name.clone(),
            None => names::pretty(self.objects().chain(self.materials()).next().unwrap_or_default()),
        }
    }

    /// How luminaires of its photometry hang whose faces look this way.
    pub(super) fn attitude(&self, normal: Option<DVec3>) -> Attitude {
        let given = self.aim.and_then(|aim| DVec3::from(aim).try_normalize());
        Attitude { turn: self.turn.unwrap_or(0.0), tilt: self.tilt.unwrap_or(0.0), aim: given.or(normal) }
    }

    /// What is wrong with the entry by itself.
    pub(super) fn fault(&self) -> Option<String> {
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite() && *v >= 0.0 && *v <= 1e12);
        let positive = |values: &[f64]| values.iter().any(|v| *v > 0.0);
        if self.objects().next().is_none() && self.materials().next().is_none() {
            return Some("must name an object or a material".to_owned());
        }
        if self.name.as_ref().is_some_and(|name| name.trim().is_empty()) {
            return Some("has an empty name".to_owned());
        }
        if self.lumens.is_some() && self.exitance.is_some() {
            return Some("has both lumens and exitance; give one".to_owned());
        }
        if self.colour.is_some() && self.cct.is_some() {
            return Some("has both colour and cct; give one".to_owned());
        }
        if self.exitance.is_some() && (self.colour.is_some() || self.cct.is_some()) {
            return Some("has an exitance, which holds the colour already; remove colour and cct".to_owned());
        }
        if self.lumens.is_some_and(|lumens| !finite(&[lumens])) {
            return Some("must have lumens of 0 or more".to_owned());
        }
        if self.exitance.is_some_and(|exitance| !finite(&exitance)) {
            return Some("must have an exitance of three numbers of 0 or more, in W/m2".to_owned());
        }
        if self.colour.is_some_and(|colour| !finite(&colour) || !positive(&colour)) {
            return Some("must have a colour of three numbers of 0 or more, not all 0".to_owned());
        }
        if self.cct.is_some_and(|kelvin| !(1000.0..=40_000.0).contains(&kelvin)) {
            return Some("must have a cct between 1000 and 40000 kelvin".to_owned());
        }
        if self.dimmer.is_some_and(|dimmer| !(0.0..=1.0).contains(&dimmer)) {
            return Some("must have a dimmer between 0 and 1".to_owned());
        }
        if self.photometry.is_none() && (self.aim.is_some() || self.turn.is_some() || self.tilt.is_some()) {
            return Some("has an aim, turn or tilt, which only lamps with photometry have".to_owned());
        }
        if self.aim.is_some_and(|aim| DVec3::from(aim).try_normalize().is_none()) {
            return Some("must have an aim, as in aim = [0, -1, 0] for one that shines downwards".to_owned());
        }
        self.attitude(None).fault()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LampState, Sides, from_text};
    use glam::DVec3;

    #[test]
    fn the_example_of_the_documentation_does_what_it_says() {
        let obj = "mtllib m.mtl\nv 0 0 0\nv 400 0 0\nv 400 0 500\nv 0 250 0\nv 50 250 0\nv 50 250 50\n\
            usemtl plaster\nf 3 2 1\no pendant\nusemtl shade\nf 4 5 6\n";
        let mtl = "newmtl plaster\nKd 0.5 0.5 0.5\nnewmtl shade\nKd 0.5 0.5 0.5\n";
        let scene = from_text("t", obj, mtl, Some(include_str!("sidecar_example.toml"))).unwrap();
        assert_eq!(scene.positions[1], DVec3::new(4.0, 0.0, 0.0));
        let view = &scene.views[scene.start_view];
        assert_eq!(
            (view.name.as_str(), view.eye, view.fov_y_deg),
            ("From the door", DVec3::new(3.5, 1.6, 4.5), 65.0)
        );
        assert_eq!(scene.patch_size, Some(0.15));
        assert_eq!(scene.luminaires[0].name, "Kitchen pendant");
        let LampState { on, dimmer, exitance } = scene.luminaires[0].initial;
        assert!(on && dimmer == 0.8 && exitance[0] > exitance[1] && exitance[1] > exitance[2]);
        assert_eq!(scene.materials[0].reflectance, [0.82, 0.81, 0.78]);
        assert_eq!(scene.materials[0].sides, Sides::Auto);
        assert_eq!(scene.findings, []);
    }
}
