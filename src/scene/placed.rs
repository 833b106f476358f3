//! Lamps that no model file holds: placed by the sidecar or by the user, and made surfaces here.

use super::colour::{black_body, normalised};
use super::names;
use super::photometric::{Attitude, PhotometricLight};
use super::types::{
    Corner, LUMINOUS_EFFICACY, LampState, Luminaire, Material, Scene, Sides, Surface, UpAxis,
    luminance_weighted,
};
use crate::geometry::Frame;
use crate::photometry::{MadeKind, Photometry};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::sync::Arc;

/// Name of the material of placed lamps.
const MATERIAL: &str = "Placed lamp";
/// Its reflectance.
const REFLECTANCE: f64 = 0.8;
/// An opening without area counts as so large, m²: the lamp's exitance has to be some number.
const NOMINAL_AREA: f64 = 1e-4;
/// An array of one lamp.
pub(super) const SINGLE: [u32; 2] = [1, 1];

/// The form of a placed lamp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LampKind {
    /// A flat rectangle that shines evenly to one side; its back is black.
    #[default]
    Panel,
    /// As [`MadeKind::Downlight`].
    Downlight,
    /// As [`MadeKind::Pendant`].
    Pendant,
    /// As [`MadeKind::Spot`].
    Spot,
    /// As [`MadeKind::Bulb`].
    Bulb,
    /// As [`MadeKind::WallWasher`].
    WallWasher,
}

impl LampKind {
    /// The distribution that the program has of it; a panel shines by Lambert's law.
    pub(super) fn made(self) -> Option<MadeKind> {
        match self {
            Self::Panel => None,
            Self::Downlight => Some(MadeKind::Downlight),
            Self::Pendant => Some(MadeKind::Pendant),
            Self::Spot => Some(MadeKind::Spot),
            Self::Bulb => Some(MadeKind::Bulb),
            Self::WallWasher => Some(MadeKind::WallWasher),
        }
    }
}

/// The photometry of a placed lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct LampPhotometry {
    /// The file beside the model; `None` where its kind makes it.
    pub file: Option<String>,
    /// What is in it.
    pub photometry: Arc<Photometry>,
    /// Degrees about its axis, as [`Attitude::turn`].
    pub turn: f64,
    /// Degrees, as [`Attitude::tilt`].
    pub tilt: f64,
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
    /// Edges, metres: the level one (along x where it shines straight up or down), then the other. Where it has
    /// photometry, extents of the opening along C0 and C90.
    pub size: [f64; 2],
    /// Luminous flux at full output, 0 or more; of each where there is an array of them.
    pub lumens: f64,
    /// Its colour.
    pub colour: LampColour,
    /// Switched on at first.
    pub on: bool,
    /// 0 to 1, at first.
    pub dimmer: f64,
    /// Where its light is that of photometry: it has no face then.
    pub photometric: Option<LampPhotometry>,
    /// Rows and columns of a level array of such lamps around its position; all switch as one.
    pub array: [u32; 2],
    /// From row to row and from column (along x) to column, metres.
    pub spacing: [f64; 2],
    /// Of a spot, where it has a cone of its own: the angles of [`MadeKind::cone`].
    pub cone: Option<[f64; 2]>,
}

impl PlacedLamp {
    /// Area of all of the array, m².
    fn area(&self) -> f64 {
        let single = match &self.photometric {
            None => self.size[0] * self.size[1],
            Some(light) => light.photometry.opening.level_area().max(NOMINAL_AREA),
        };
        single * self.count()
    }

    /// Lamps in its array.
    fn count(&self) -> f64 {
        f64::from(self.array[0]) * f64::from(self.array[1])
    }

    /// Middles of the lamps of its array, row by row, metres.
    fn middles(&self, up: UpAxis) -> Vec<DVec3> {
        let frame = Frame::along(up.vector(), DVec3::X);
        let [rows, columns] = self.array;
        let along = |k: u32, of: u32, step: f64| (f64::from(k) - 0.5 * (f64::from(of) - 1.0)) * step;
        let middle = |row, column| {
            let across = frame.tangent * along(column, columns, self.spacing[1]);
            self.position + across - frame.bitangent * along(row, rows, self.spacing[0])
        };
        (0..rows).flat_map(|row| (0..columns).map(move |column| middle(row, column))).collect()
    }

    /// How luminaires of its photometry hang.
    fn hung(&self, light: &LampPhotometry, up: UpAxis) -> Vec<(DVec3, Frame)> {
        let attitude = Attitude { turn: light.turn, tilt: light.tilt, aim: Some(self.aim) };
        let frame = attitude.frame(up);
        self.middles(up).into_iter().map(|middle| (middle, frame)).collect()
    }

    /// The lumens of each that its file gives, where it has one.
    pub(super) fn lumens_of_file(&self, up: UpAxis) -> Option<f64> {
        let light = self.photometric.as_ref().filter(|light| light.file.is_some())?;
        let (_, lumens) = PhotometricLight::new(Arc::clone(&light.photometry), &self.hung(light, up), up)?;
        Some(lumens / self.count())
    }

    /// How many faces it has.
    fn faces(&self) -> usize {
        if self.photometric.is_some() { 0 } else { self.count() as usize }
    }

    /// How it starts.
    pub fn state(&self) -> LampState {
        let strength = self.lumens * self.count() / (LUMINOUS_EFFICACY * self.area());
        let exitance = self.colour.of_luminance_one().map(|c| c * strength);
        LampState { on: self.on, dimmer: self.dimmer, exitance }
    }

    /// The same lamp starting as `state` says; lumens and colour stay as given where they mean the same.
    #[must_use]
    pub fn starting_as(&self, state: &LampState) -> Self {
        let mut lamp = Self { on: state.on, dimmer: state.dimmer, ..self.clone() };
        if state.exitance != self.state().exitance {
            let luminance = luminance_weighted(state.exitance);
            lamp.lumens = LUMINOUS_EFFICACY * luminance * self.area() / self.count();
            if luminance > 0.0 {
                lamp.colour = LampColour::Linear(state.exitance.map(|e| e / luminance));
            }
        }
        lamp
    }

    /// Corners of the face that shines around a middle, counter-clockwise from its front.
    fn corners(&self, middle: DVec3, up: UpAxis) -> [DVec3; 4] {
        let level = up.vector().cross(self.aim);
        let level = if level.length() > 1e-6 { level } else { DVec3::X };
        let frame = Frame::along(self.aim, level);
        let (a, b) = (frame.tangent * (0.5 * self.size[0]), frame.bitangent * (0.5 * self.size[1]));
        [-a - b, a - b, a + b, b - a].map(|corner| middle + corner)
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
        self.luminaires.len() - self.placed.len() - if self.outdoors.is_some() { 2 } else { 0 }
    }

    /// Materials that the model itself has: all but that of placed lamps, the last one.
    pub fn own_materials(&self) -> &[Material] {
        &self.materials[..self.materials.len() - usize::from(!self.placed.is_empty())]
    }

    /// Undoes [`Self::place`]: everything of it stands at the ends of the lists.
    pub(super) fn take_away_placed(&mut self) {
        let lamps = std::mem::take(&mut self.placed);
        if !lamps.is_empty() {
            let faces: usize = lamps.iter().map(PlacedLamp::faces).sum();
            let objects = lamps.iter().filter(|lamp| lamp.faces() > 0).count();
            self.surfaces.truncate(self.surfaces.len() - faces);
            self.positions.truncate(self.positions.len() - 4 * faces);
            self.objects.truncate(self.objects.len() - objects);
            self.given_objects.truncate(self.given_objects.len() - objects);
            self.luminaires.truncate(self.luminaires.len() - lamps.len());
            self.materials.pop();
        }
    }

    /// Adds lamps to a scene that has none placed yet: one luminaire each, and one object of one surface for each
    /// lamp of its array unless it shines by photometry.
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
            glazing: None,
            translucence: [0.0; 3],
        });
        for lamp in &lamps {
            let middles = if lamp.faces() > 0 { lamp.middles(self.up) } else { Vec::new() };
            if lamp.faces() > 0 {
                self.objects.push(lamp.name.clone());
                self.given_objects.push(lamp.name.clone());
            }
            for middle in middles {
                let first = self.positions.len() as u32;
                self.positions.extend(lamp.corners(middle, self.up));
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
            }
            let light = lamp.photometric.as_ref().and_then(|light| {
                let hung = lamp.hung(light, self.up);
                PhotometricLight::new(Arc::clone(&light.photometry), &hung, self.up)
            });
            self.luminaires.push(Luminaire {
                name: lamp.name.clone(),
                area: lamp.area(),
                initial: lamp.state(),
                photometric: light.map(|(light, _)| light),
            });
        }
        self.placed = lamps;
    }
}

#[cfg(test)]
mod tests {
    use super::super::error::SceneError;
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
