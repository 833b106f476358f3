//! Lamps that no model file holds: placed by the sidecar or by the user, and made surfaces here.

use super::colour::{black_body, normalised};
use super::error::SceneError;
use super::names;
use super::sidecar::Source;
use super::types::{
    Corner, LUMINOUS_EFFICACY, LampState, LengthUnit, Luminaire, Material, Scene, Sides, Surface, UpAxis,
    luminance_weighted,
};
use crate::geometry::Frame;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use toml::Spanned;

/// Name of the material of placed lamps.
const MATERIAL: &str = "Placed lamp";
/// Its reflectance.
const REFLECTANCE: f64 = 0.8;
/// Edge of a panel that gives no size, metres.
const USUAL_SIZE: f64 = 0.6;
/// Largest edge of a panel, metres.
const LARGEST: f64 = 1000.0;

/// The form of a placed lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LampKind {
    /// A flat rectangle that shines evenly to one side; its back is black.
    #[default]
    Panel,
}

/// The colour of a placed lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampColour {
    /// That of a black body at this temperature, kelvin, 1000 to 40,000.
    Kelvin(f64),
    /// Linear R, G, B of any height, 0 or more, not all 0.
    Linear([f64; 3]),
}

impl LampColour {
    /// Linear R, G, B of luminance 1.
    fn of_luminance_one(self) -> [f64; 3] {
        match self {
            Self::Kelvin(kelvin) => black_body(kelvin),
            Self::Linear(colour) => normalised(colour).unwrap_or([1.0; 3]),
        }
    }
}

/// A lamp that stands in no model file.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLamp {
    /// What the user reads; no other luminaire has it.
    pub name: String,
    /// Its form.
    pub kind: LampKind,
    /// Middle of the face that shines, metres.
    pub position: DVec3,
    /// Unit vector along which it shines.
    pub aim: DVec3,
    /// Edges, metres: the level one (along x where it shines straight up or down), then the other.
    pub size: [f64; 2],
    /// Luminous flux at full output, 0 or more.
    pub lumens: f64,
    /// Its colour.
    pub colour: LampColour,
    /// Switched on at first.
    pub on: bool,
    /// 0 to 1, at first.
    pub dimmer: f64,
}

impl PlacedLamp {
    fn area(&self) -> f64 {
        self.size[0] * self.size[1]
    }

    /// How it starts.
    pub fn state(&self) -> LampState {
        let strength = self.lumens / (LUMINOUS_EFFICACY * self.area());
        let exitance = self.colour.of_luminance_one().map(|c| c * strength);
        LampState { on: self.on, dimmer: self.dimmer, exitance }
    }

    /// The same lamp starting as `state` says; lumens and colour stay as given where they mean the same.
    #[must_use]
    pub fn starting_as(&self, state: &LampState) -> Self {
        let mut lamp = Self { on: state.on, dimmer: state.dimmer, ..self.clone() };
        if state.exitance != self.state().exitance {
            let luminance = luminance_weighted(state.exitance);
            lamp.lumens = LUMINOUS_EFFICACY * luminance * self.area();
            if luminance > 0.0 {
                lamp.colour = LampColour::Linear(state.exitance.map(|e| e / luminance));
            }
        }
        lamp
    }

    /// Corners of the face that shines, counter-clockwise from its front.
    fn corners(&self, up: UpAxis) -> [DVec3; 4] {
        let level = up.vector().cross(self.aim);
        let level = if level.length() > 1e-6 { level } else { DVec3::X };
        let frame = Frame::along(self.aim, level);
        let (a, b) = (frame.tangent * (0.5 * self.size[0]), frame.bitangent * (0.5 * self.size[1]));
        [-a - b, a - b, a + b, b - a].map(|corner| self.position + corner)
    }
}

impl Scene {
    /// The scene with these lamps placed in it, instead of those that were. Indices of everything else stay;
    /// the luminaires of placed lamps are the last ones, in the order of `lamps`.
    #[must_use]
    pub fn with_placed(&self, lamps: Vec<PlacedLamp>) -> Self {
        let mut scene = self.clone();
        scene.take_away_placed();
        scene.place(lamps);
        scene
    }

    /// Luminaires that the model itself has: those before the placed ones.
    pub fn own_luminaires(&self) -> usize {
        self.luminaires.len() - self.placed.len()
    }

    /// Materials that the model itself has: all but that of placed lamps, the last one.
    pub fn own_materials(&self) -> &[Material] {
        &self.materials[..self.materials.len() - usize::from(!self.placed.is_empty())]
    }

    /// Undoes [`Self::place`]: everything of it stands at the ends of the lists.
    fn take_away_placed(&mut self) {
        let count = std::mem::take(&mut self.placed).len();
        if count > 0 {
            self.surfaces.truncate(self.surfaces.len() - count);
            self.positions.truncate(self.positions.len() - 4 * count);
            self.objects.truncate(self.objects.len() - count);
            self.given_objects.truncate(self.given_objects.len() - count);
            self.luminaires.truncate(self.luminaires.len() - count);
            self.materials.pop();
        }
    }

    /// Adds lamps to a scene that has none placed yet: one object, surface and luminaire each.
    pub(super) fn place(&mut self, lamps: Vec<PlacedLamp>) {
        if lamps.is_empty() {
            return;
        }
        let mut taken: HashSet<String> = self.materials.iter().map(|m| m.name.clone()).collect();
        self.materials.push(Material {
            name: names::unique(MATERIAL, &mut taken),
            reflectance: [REFLECTANCE; 3],
            texture: None,
            sides: Sides::Front,
        });
        for lamp in &lamps {
            let first = self.positions.len() as u32;
            self.positions.extend(lamp.corners(self.up));
            self.objects.push(lamp.name.clone());
            self.given_objects.push(lamp.name.clone());
            self.surfaces.push(Surface {
                corners: (first..first + 4)
                    .map(|position| Corner { position, normal: None, uv: None })
                    .collect(),
                object: self.objects.len() as u32 - 1,
                material: self.materials.len() as u32 - 1,
                luminaire: Some(self.luminaires.len() as u32),
                emission_weight: [1.0; 3],
                emits_back: false,
                line: None,
            });
            self.luminaires.push(Luminaire {
                name: lamp.name.clone(),
                area: lamp.area(),
                initial: lamp.state(),
            });
        }
        self.placed = lamps;
    }
}

/// A `[[lamp]]` of the sidecar; lengths in the file's unit.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LampEntry {
    pub(super) name: Spanned<String>,
    #[serde(default)]
    kind: LampKind,
    position: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    aim: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<[f64; 2]>,
    lumens: f64,
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
        Self {
            name: Spanned::new(0..0, lamp.name.clone()),
            kind: lamp.kind,
            position: scene.in_file(lamp.position).to_array().map(tidied),
            aim: Some(lamp.aim.to_array().map(tidied)),
            size: Some(lamp.size.map(|edge| tidied(edge * units))),
            lumens: lamp.lumens,
            colour,
            cct,
            on: (!lamp.on).then_some(false),
            dimmer: (lamp.dimmer != 1.0).then_some(lamp.dimmer),
        }
    }

    /// The lamp in metres, or what is wrong with the entry.
    fn lamp(&self, (unit, up, origin): (LengthUnit, UpAxis, DVec3)) -> Result<PlacedLamp, String> {
        let metres = unit.metres();
        let aim = self.aim.map_or(-up.vector(), DVec3::from);
        let position = DVec3::from(self.position) * metres - origin;
        let size = self.size.map_or([USUAL_SIZE; 2], |size| size.map(|edge| edge * metres));
        if self.name.get_ref().trim().is_empty() {
            return Err("needs a name".to_owned());
        }
        if !position.is_finite() {
            return Err("must have a position of three numbers".to_owned());
        }
        let Some(aim) = aim.try_normalize().filter(|aim| aim.is_finite()) else {
            return Err("must have an aim, as in aim = [0, -1, 0] for one that shines downwards".to_owned());
        };
        if !size.iter().all(|edge| edge.is_finite() && *edge > 0.0 && *edge <= LARGEST) {
            return Err(format!("must have a size of two lengths above 0 and up to {LARGEST} m"));
        }
        if !(self.lumens.is_finite() && (0.0..=1e12).contains(&self.lumens)) {
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
        Ok(PlacedLamp {
            name: self.name.get_ref().clone(),
            kind: self.kind,
            position,
            aim,
            size,
            lumens: self.lumens,
            colour,
            on: self.on.unwrap_or(true),
            dimmer: self.dimmer.unwrap_or(1.0),
        })
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
) -> Result<Vec<PlacedLamp>, SceneError> {
    let mut taken: HashSet<&str> = others.iter().map(|lamp| lamp.name.as_str()).collect();
    let mut lamps = Vec::with_capacity(entries.len());
    for entry in entries {
        let name = entry.name.get_ref();
        let fail = |fault: &str| {
            source.error_at(entry.name.span().start, format!("the lamp '{}' {fault}", names::short(name)))
        };
        lamps.push(entry.lamp(frame).map_err(|fault| fail(&fault))?);
        if !taken.insert(name) {
            return Err(fail("is there twice; names of lamps must differ"));
        }
    }
    Ok(lamps)
}

#[cfg(test)]
mod tests {
    use super::super::{from_text, lumens, sidecar_text};
    use super::*;

    const OBJ: &str = "mtllib m.mtl\nusemtl white\nv 0 0 0\nv 400 0 0\nv 400 0 500\nv 0 0 500\nf 4 3 2 1\n";
    const MTL: &str = "newmtl white\nKd 0.8 0.8 0.8\n";
    const LAMP: &str = "# For the model.\nunit = \"cm\"\n\n# Over the table.\n[[lamp]]\nname = \"Panel\" # ours\n\
        position = [200, 250, 250]\nsize = [120, 30]\nlumens = 3600\ncct = 4000\n";

    fn scene(sidecar: &str) -> Result<Scene, SceneError> {
        from_text("t", OBJ, MTL, Some(sidecar))
    }

    #[test]
    fn a_placed_lamp_is_a_surface_that_shines_downwards() {
        let scene = scene(LAMP).unwrap();
        let surface = scene.surfaces.last().unwrap();
        assert_eq!((scene.surfaces.len(), surface.luminaire, scene.luminaires.len()), (2, Some(0), 1));
        assert_eq!(scene.objects[surface.object as usize], "Panel");
        let corners = scene.polygon(surface);
        let area = crate::geometry::polygon::area_vector(&corners);
        assert!(area.abs_diff_eq(DVec3::NEG_Y * 0.36, 1e-12), "{area}");
        let size = crate::geometry::Aabb::around(corners).size();
        assert!(size.abs_diff_eq(DVec3::new(1.2, 0.0, 0.3), 1e-12), "{size}");
        assert!((lumens(&scene)[0][0] - 3600.0).abs() < 1e-6);
        let none = scene.with_placed(Vec::new());
        assert_eq!((none.surfaces.len(), none.positions.len(), none.materials.len()), (1, 4, 1));
        assert!(none.luminaires.is_empty() && none.placed.is_empty());
        assert_eq!(none.with_placed(scene.placed.clone()).surfaces[1].corners, surface.corners);
    }

    #[test]
    fn lamps_aim_anywhere_with_a_level_edge() {
        let tilted = LAMP.replace("size =", "aim = [1, -1, 0]\nsize =");
        let scene = scene(&tilted).unwrap();
        let corners = scene.polygon(scene.surfaces.last().unwrap());
        let area = crate::geometry::polygon::area_vector(&corners).normalize();
        assert!(area.abs_diff_eq(DVec3::new(1.0, -1.0, 0.0).normalize(), 1e-12), "{area}");
        assert!((corners[1] - corners[0]).y.abs() < 1e-12, "the long edge is level");
        assert!(((corners[1] - corners[0]).length() - 1.2).abs() < 1e-12);
    }

    #[test]
    fn lamps_are_written_and_read_back_the_same_and_comments_stay() {
        let first = scene(LAMP).unwrap();
        let mut lighting = first.lighting();
        lighting.lamps[0].dimmer = 0.25;
        let text = sidecar_text(&first, &lighting, &[], Some(LAMP)).unwrap();
        for kept in
            ["# For the model.", "# Over the table.\n[[lamp]]", "# ours", "lumens = 3600", "cct = 4000"]
        {
            assert!(text.contains(kept), "{kept:?} is gone from\n{text}");
        }
        assert!(text.contains("position = [200.0, 250.0, 250.0]"), "{text}");
        let again = scene(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(again.placed, [PlacedLamp { dimmer: 0.25, ..first.placed[0].clone() }]);
        assert_eq!(sidecar_text(&again, &again.lighting(), &[], Some(&text)).unwrap(), text);

        // Recoloured it has lumens and a colour of its own; taken away it is gone.
        lighting.lamps[0].exitance = [10.0, 5.0, 1.0];
        let text = sidecar_text(&first, &lighting, &[], Some(LAMP)).unwrap();
        let again = scene(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        for (found, wanted) in again.luminaires[0].initial.exitance.iter().zip([10.0, 5.0, 1.0]) {
            assert!((found - wanted).abs() < 1e-9, "{text}");
        }
        let none = first.with_placed(Vec::new());
        let text = sidecar_text(&none, &none.lighting(), &[], Some(LAMP)).unwrap();
        assert!(!text.contains("[[lamp]]") && text.contains("# For the model."), "{text}");
    }

    #[test]
    fn lamps_stand_beside_those_of_the_model_in_the_sidecar() {
        let obj = format!("{OBJ}o glow\nusemtl glow\nv 0 200 0\nv 100 200 0\nv 100 200 100\nf 5 6 7\n");
        let mtl = format!("{MTL}newmtl glow\nKd 0 0 0\nKe 1 1 1\n");
        let first = from_text("t", &obj, &mtl, Some(LAMP)).unwrap();
        let names: Vec<&str> = first.luminaires.iter().map(|l| l.name.as_str()).collect();
        assert_eq!((names.as_slice(), first.own_luminaires()), (["Glow", "Panel"].as_slice(), 1));
        let mut lighting = first.lighting();
        lighting.lamps[0].on = false;
        let text = sidecar_text(&first, &lighting, &[], Some(LAMP)).unwrap();
        let again = from_text("t", &obj, &mtl, Some(&text)).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(again.lighting(), lighting);
        assert_eq!(text.matches("[[luminaire]]").count(), 1, "{text}");
        let clash = LAMP.replace("\"Panel\"", "\"Glow\"");
        let message = from_text("t", &obj, &mtl, Some(&clash)).unwrap_err().to_string();
        assert!(message.contains("t.toml, line 6") && message.contains("there twice"), "{message}");
    }

    #[test]
    fn faults_name_the_line_and_the_key() {
        for (from, to, what) in [
            ("size = [120, 30]", "size = [0, 30]", "size"),
            ("lumens = 3600", "lumens = -1", "lumens"),
            ("cct = 4000", "cct = 4000\ncolour = [1, 1, 1]", "colour and cct"),
            ("cct = 4000", "cct = 12", "cct"),
            ("cct = 4000", "dimmer = 2", "dimmer"),
            ("size = [120, 30]", "aim = [0, 0, 0]", "aim"),
            ("position = [200, 250, 250]", "position = [nan, 0, 0]", "position"),
        ] {
            let message = scene(&LAMP.replace(from, to)).unwrap_err().to_string();
            assert!(message.contains("t.toml, line 6") && message.contains(what), "{to}: {message}");
        }
        let message = scene(&LAMP.replace("cct", "kelvins")).unwrap_err().to_string();
        assert!(
            message.contains("unknown key 'kelvins'") && message.contains("t.toml, line 10"),
            "{message}"
        );
        let message = scene(&LAMP.replace("lumens = 3600\n", "")).unwrap_err().to_string();
        assert!(message.contains("lumens"), "{message}");
    }
}
