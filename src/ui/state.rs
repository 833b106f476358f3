//! What the window remembers between starts, what it remembers of a scene while that is open, and what one
//! can undo: plain values, no behaviour.

use super::camera_control::Motion;
use crate::display::ToneMap;
use crate::scene::{DaylightChoice, Lighting, PlacedLamp, Scene};
use crate::session::MaterialEdit;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Files that the menu offers to open again.
const RECENT: usize = 8;

/// How surfaces are shaded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadingMode {
    /// Radiosity interpolated between vertices (Gouraud), never across creases.
    #[default]
    Smooth,
    /// One radiosity a patch, as the solver sees it.
    Flat,
}

/// What the picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// The lit scene.
    #[default]
    Picture,
    /// Illuminance in lux.
    Illuminance,
    /// Luminance in cd/m².
    Luminance,
    /// Illuminance under the traditional overcast sky of the CIE over that of the open horizontal, %; whatever the present
    /// sky and lamps.
    DaylightFactor,
    /// Illuminance now less that of the stored state A, lux.
    Difference,
    /// Reflectance of the patches, 0 to 1.
    Reflectance,
    /// A colour for every patch.
    PatchIds,
    /// Direction of the normals.
    Normals,
    /// Front sides against back sides.
    Sides,
    /// Longest extent squared over area.
    Aspect,
    /// Patch area in m².
    Area,
    /// Form factors from the patch looked into, each over the area of the patch it goes to, 1/m²:
    /// what does not depend on how finely the others are cut.
    RowDensity,
    /// Form factors from the patch looked into.
    RowFactor,
    /// Illuminance that the patch looked into has from each other, over that one's area, lx/m².
    RowLight,
    /// What of a patch's power leaves through openings, %.
    Escape,
    /// Row sums as sampled less those after balancing, %.
    Closure,
    /// Largest gap between A_i F_ij and A_j F_ji of a patch as sampled over A_i, %.
    Reciprocity,
    /// Luminance that one more sweep would add, cd/m².
    Residual,
    /// Luminous flux that has not been passed on yet, lm.
    Unshot,
    /// Estimated error of the irradiance as shown, % of the light there (its mean at least).
    Error,
}

impl Quantity {
    /// All of them, in the order of the menu.
    pub const ALL: [Self; 20] = [
        Self::Picture,
        Self::Illuminance,
        Self::Luminance,
        Self::DaylightFactor,
        Self::Difference,
        Self::Reflectance,
        Self::PatchIds,
        Self::Normals,
        Self::Sides,
        Self::Aspect,
        Self::Area,
        Self::RowDensity,
        Self::RowFactor,
        Self::RowLight,
        Self::Escape,
        Self::Closure,
        Self::Reciprocity,
        Self::Residual,
        Self::Unshot,
        Self::Error,
    ];

    /// What a row of form factors can be shown as.
    pub const ROW: [Self; 3] = [Self::RowDensity, Self::RowFactor, Self::RowLight];

    /// What the menu calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "Picture",
            Self::Illuminance => "Illuminance",
            Self::Luminance => "Luminance",
            Self::DaylightFactor => "Daylight factor",
            Self::Difference => "Difference to A",
            Self::Reflectance => "Reflectance",
            Self::PatchIds => "Patch ids",
            Self::Normals => "Normals",
            Self::Sides => "Front and back",
            Self::Aspect => "Aspect of patches",
            Self::Area => "Area of patches",
            Self::RowDensity => "Row: F per area",
            Self::RowFactor => "Row: form factor F",
            Self::RowLight => "Row: light per area",
            Self::Escape => "Escaping share",
            Self::Closure => "Row sum error",
            Self::Reciprocity => "Worst reciprocity",
            Self::Residual => "Residual",
            Self::Unshot => "Unshot power",
            Self::Error => "Estimated error",
        }
    }

    /// The unit of its legend; empty for a plain number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Illuminance | Self::Difference => "lx",
            Self::Luminance | Self::Residual => "cd/m²",
            Self::Area => "m²",
            Self::RowDensity => "1/m²",
            Self::RowLight => "lx/m²",
            Self::DaylightFactor | Self::Escape | Self::Closure | Self::Reciprocity | Self::Error => "%",
            Self::Unshot => "lm",
            _ => "",
        }
    }

    /// Whether it is a number a patch, drawn through a colour map with a legend.
    pub fn is_scalar(self) -> bool {
        !matches!(self, Self::Picture | Self::PatchIds | Self::Normals)
    }

    /// What it means, where the name alone does not say it.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::RowDensity => {
                "Form factors from the picked patch, each over the area of the patch that it goes to: \
                 even where patches differ in size. Grey is not seen"
            }
            Self::RowFactor => {
                "Form factors from the picked patch, as the matrix holds them. Grey is not seen"
            }
            Self::RowLight => {
                "Illuminance that the picked patch has from every other, over that one's area: where its \
                 light comes from. Grey is not seen"
            }
            Self::Escape => {
                "1 less the sum of a patch's form factors: what leaves through openings. Grey sees nothing"
            }
            Self::Closure => "Row sum as sampled less the sum after balancing: what balancing mended",
            Self::Reciprocity => {
                "Largest gap between the two samples A_i F_ij and A_j F_ji of a patch's pairs over A_i: how far \
                 one of its form factors is in dispute"
            }
            Self::Residual => "E + rho F B - B as luminance: what one more sweep would add",
            Self::Unshot => {
                "Flux that has arrived and not been passed on; once all rows are there, that of the residual"
            }
            Self::Error => {
                "How far the illuminance as shown is from the truth on each patch, RMS, of the light there (the mean at least): \
                 what rays found at some patches, spread to the others by what the picture shows there"
            }
            Self::Aspect => "Longest extent squared over area: 1 for a square",
            Self::DaylightFactor => {
                "Illuminance under the CIE's traditional overcast sky over that of the open horizontal outside, whatever \
                 sky is chosen; lamps and sun off"
            }
            Self::Difference => "Illuminance now less that of the stored state A",
            _ => "",
        }
    }

    /// Whether it shows the row of the patch looked into.
    pub fn is_row(self) -> bool {
        Self::ROW.contains(&self)
    }

    /// Whether it is a map of what sampling and solver got wrong, a value a patch.
    pub fn is_defect(self) -> bool {
        matches!(self, Self::Escape | Self::Closure | Self::Reciprocity | Self::Residual | Self::Unshot)
    }

    /// Whether its values span decades, so that even factors show more of it than even steps.
    pub fn spans_decades(self) -> bool {
        self.is_row() || self == Self::Error
    }

    /// Whether it has both signs, so that its colours part at zero.
    pub fn is_signed(self) -> bool {
        matches!(self, Self::Difference | Self::Sides | Self::Closure | Self::Residual)
    }

    /// Whether it can be shown for A and for now, side by side.
    pub fn can_split(self) -> bool {
        matches!(self, Self::Picture | Self::Illuminance | Self::Luminance)
    }

    /// Whether its values change with the lamps.
    pub fn follows_light(self) -> bool {
        matches!(self, Self::Illuminance | Self::Luminance | Self::Difference)
    }
}

/// How the picture is made from the light. Part of what undo covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplaySettings {
    /// Flat or smooth.
    pub shading: ShadingMode,
    /// What is shown.
    pub quantity: Quantity,
    /// Exposure follows what is in view.
    pub auto_exposure: bool,
    /// Exposure value (ISO 100) where set by hand; a correction in stops where automatic.
    pub ev: f64,
    /// Correction of the automatic exposure, stops; positive is brighter.
    pub compensation: f64,
    /// Colours as eyes see them that have adapted to the lamps.
    pub white_balance: bool,
    /// From exposed light to the display.
    pub tone_map: ToneMap,
    /// Ends of the false-colour range where pinned.
    pub range: Option<[f64; 2]>,
    /// The range that was pinned last and the quantity that it is of, while another one is shown.
    pub left_range: Option<(Quantity, [f64; 2])>,
    /// Even steps are factors, not differences.
    pub logarithmic: bool,
    /// Borders of patches over the picture.
    pub wireframe: bool,
    /// The light kept as A beside the present one, with a divider; where A is kept.
    pub split: bool,
    /// Sides that take no part, in dark grey.
    pub show_unlit: bool,
    /// Numbers under the cursor.
    pub readout: bool,
}

impl DisplaySettings {
    /// The plain lit picture that a scene starts with.
    pub fn preferring(preferences: Preferences) -> Self {
        let Preferences { tone_map, white_balance, readout } = preferences;
        Self { tone_map, white_balance, readout, ..Self::default() }
    }

    /// What of it holds for other scenes, too.
    pub fn preferences(&self) -> Preferences {
        Preferences { tone_map: self.tone_map, white_balance: self.white_balance, readout: self.readout }
    }

    /// The same with another quantity. Its range is free, for one pinned in lux means nothing in cd/m²,
    /// unless the one pinned last was its own; what spans decades is shown in even factors.
    #[must_use]
    pub fn showing(self, quantity: Quantity) -> Self {
        let logarithmic = match (self.quantity.spans_decades(), quantity.spans_decades()) {
            (false, true) => true,
            (true, false) => false,
            _ => self.logarithmic,
        };
        let left_range = match self.range {
            Some(range) => Some((self.quantity, range)),
            None => self.left_range.filter(|left| left.0 != self.quantity),
        };
        let range = left_range.filter(|left| left.0 == quantity).map(|left| left.1);
        Self { quantity, range, left_range, logarithmic, ..self }
    }
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            shading: ShadingMode::Smooth,
            quantity: Quantity::Picture,
            auto_exposure: true,
            ev: 6.0,
            compensation: 0.0,
            white_balance: true,
            tone_map: ToneMap::default(),
            range: None,
            left_range: None,
            logarithmic: false,
            wireframe: false,
            split: false,
            show_unlit: false,
            readout: true,
        }
    }
}

/// What the window remembers between starts: the person's, whatever scene is open. What belongs to a scene is
/// in [`Visit`] and [`Edits`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct UiState {
    /// Lights, materials and views.
    pub left_open: bool,
    /// Solver, display and inspection.
    pub right_open: bool,
    /// The line at the bottom with frame time, patches and memory.
    pub show_status: bool,
    /// Eyes above the floor, metres.
    pub eye_height: f64,
    /// Opened last, newest first.
    pub recent: Vec<PathBuf>,
    /// The line that explains walking and clicking has done its work.
    pub hint_done: bool,
    /// Load a file again when it changes on disk.
    pub reload_on_change: bool,
    /// Make light that has settled finer while nothing else is to be done.
    pub refine_at_leisure: bool,
    /// How every scene is shown at first.
    pub preferences: Preferences,
}

impl Default for UiState {
    fn default() -> Self {
        Self {
            left_open: true,
            right_open: true,
            show_status: true,
            eye_height: 1.6,
            recent: Vec::new(),
            hint_done: false,
            reload_on_change: true,
            refine_at_leisure: true,
            preferences: Preferences::default(),
        }
    }
}

/// The part of [`DisplaySettings`] that is a matter of taste and not of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// From exposed light to the display.
    #[serde(with = "tone_by_name")]
    pub tone_map: ToneMap,
    /// Colours as eyes see them that have adapted to the lamps.
    pub white_balance: bool,
    /// Numbers under the cursor.
    pub readout: bool,
}

impl Default for Preferences {
    fn default() -> Self {
        let DisplaySettings { tone_map, white_balance, readout, .. } = DisplaySettings::default();
        Self { tone_map, white_balance, readout }
    }
}

/// How a scene is looked at while it is open, besides the edits. Each scene starts from the default, and
/// nothing of it outlives the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Visit {
    /// Walking or flying.
    pub motion: Motion,
    /// How the user has chosen to move: an orbit and a jump leave the ground for this once.
    pub chosen_motion: Motion,
    /// The table of patches under the view.
    pub table_open: bool,
    /// What is doubtful about the model, under the view.
    pub doctor_open: bool,
    /// Banners that were dismissed, by their keys.
    pub dismissed: BTreeSet<&'static str>,
}

impl UiState {
    /// Puts `path` first among the recent files.
    pub fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.recent.retain(|p| *p != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }
}

/// What the user has changed about a scene, and what undo covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edits {
    /// The lamps: those of the model, then those placed in it.
    pub lighting: Lighting,
    /// Lamps placed in the model, by its sidecar or in the window.
    pub placed: Vec<PlacedLamp>,
    /// The sky over the model; what it comes to is in `lighting` as well.
    pub daylight: Option<DaylightChoice>,
    /// New reflectance by material; `None` where it is that of the file.
    pub reflectance: Vec<Option<[f64; 3]>>,
    /// How the picture is made.
    pub display: DisplaySettings,
}

impl Edits {
    /// The scene as it comes.
    pub fn of_scene(scene: &Scene, display: DisplaySettings) -> Self {
        Self {
            lighting: scene.lighting(),
            placed: scene.placed.clone(),
            daylight: scene.outdoors.as_ref().map(|outdoors| outdoors.choice.clone()),
            reflectance: vec![None; scene.materials.len()],
            display,
        }
    }

    /// What the solver has to know of the materials.
    pub(super) fn materials(&self) -> Vec<MaterialEdit> {
        let edits = self.reflectance.iter().enumerate();
        let edits = edits.filter_map(|(material, value)| {
            value.map(|reflectance| MaterialEdit { material: material as u32, reflectance })
        });
        edits.collect()
    }
}

mod tone_by_name {
    use crate::display::ToneMap;
    use serde::{Deserialize as _, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(map: &ToneMap, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(map.name())
    }

    /// A name that a later version dropped falls back to the default.
    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ToneMap, D::Error> {
        let name = String::deserialize(deserializer)?;
        Ok(ToneMap::ALL.into_iter().find(|map| map.name() == name).unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_survives_being_stored_and_missing_fields_take_defaults() {
        let mut state = UiState { eye_height: 1.2, hint_done: true, ..UiState::default() };
        state.preferences.tone_map = ToneMap::Filmic;
        state.remember(Path::new("/models/house.obj"));
        let text = serde_json::to_string(&state).expect("plain values");
        assert_eq!(serde_json::from_str::<UiState>(&text).expect("just written"), state);
        assert_eq!(serde_json::from_str::<UiState>("{}").expect("all optional"), UiState::default());
        // What an earlier version stored of a scene is left alone.
        let old = r#"{ "motion": "Fly", "doctor_open": true, "display": { "wireframe": true, "quantity": "Normals" } }"#;
        assert_eq!(serde_json::from_str::<UiState>(old).expect("unknown fields"), UiState::default());
    }

    #[test]
    fn a_scene_starts_with_a_lit_picture_whatever_was_shown_before() {
        let before = DisplaySettings {
            shading: ShadingMode::Flat,
            quantity: Quantity::Illuminance,
            auto_exposure: false,
            compensation: 2.0,
            tone_map: ToneMap::Filmic,
            range: Some([0.0, 300.0]),
            wireframe: true,
            show_unlit: true,
            readout: false,
            ..DisplaySettings::default()
        };
        let next = DisplaySettings::preferring(before.preferences());
        let expected =
            DisplaySettings { tone_map: ToneMap::Filmic, readout: false, ..DisplaySettings::default() };
        assert_eq!(next, expected);
    }

    #[test]
    fn a_pinned_range_comes_back_with_its_quantity() {
        let lux = DisplaySettings::default().showing(Quantity::Illuminance);
        let pinned = DisplaySettings { range: Some([0.0, 300.0]), ..lux };
        let luminance = pinned.showing(Quantity::Luminance);
        assert_eq!(luminance.range, None, "lux are no cd/m2");
        let picture = luminance.showing(Quantity::Picture);
        assert_eq!(picture.showing(Quantity::Illuminance).range, Some([0.0, 300.0]));
        // One that was set free stays so.
        let free = DisplaySettings { range: None, ..picture.showing(Quantity::Illuminance) };
        assert_eq!(free.showing(Quantity::Picture).showing(Quantity::Illuminance).range, None);
    }

    #[test]
    fn recent_files_are_few_and_unlike() {
        let mut state = UiState::default();
        for k in 0..20 {
            state.remember(Path::new(&format!("/m/{k}.obj")));
        }
        state.remember(Path::new("/m/15.obj"));
        assert_eq!(state.recent.len(), RECENT);
        assert_eq!(state.recent[0], Path::new("/m/15.obj"));
        assert_eq!(state.recent.iter().filter(|p| p.ends_with("15.obj")).count(), 1);
    }
}
