//! Everything that the window can be asked to do. Panels, menus, keys and clicks only make
//! commands; one function carries them out.

use super::auditor::Ask;
use super::camera_control::Motion;
use super::doctor;
use super::state::DisplaySettings;
use crate::scene::{DaylightChoice, LampState, LengthUnit, SceneSource, UpAxis};
use crate::solve::SolveSettings;
use std::path::PathBuf;

/// What is saved to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SaveKind {
    /// The view as shown, PNG.
    Screenshot,
    /// The view as radiance with further layers, OpenEXR.
    Hdr,
    /// Patches with their numbers, CSV.
    PatchTable,
    /// Triangles with vertex radiosity, PLY.
    LitMesh,
    /// The model mended, OBJ with MTL and sidecar.
    RepairedCopy,
    /// The scene with what the user has done to lamps, materials and bookmarks, OBJ with MTL and sidecar.
    EditedCopy,
}

impl SaveKind {
    /// What the menu says.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Screenshot => "Save picture (PNG)",
            Self::Hdr => "Save radiance (EXR)",
            Self::PatchTable => "Save patch table (CSV)",
            Self::LitMesh => "Save lit mesh (PLY)",
            Self::RepairedCopy => "Save repaired copy (OBJ)",
            Self::EditedCopy => "Save a copy with these lamps (OBJ)",
        }
    }

    /// File name extension without the dot.
    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::Screenshot => "png",
            Self::Hdr => "exr",
            Self::PatchTable => "csv",
            Self::LitMesh => "ply",
            Self::RepairedCopy | Self::EditedCopy => "obj",
        }
    }
}

/// One thing that the user asks for.
#[derive(Clone, Debug, PartialEq)]
#[must_use = "a command does nothing until it is carried out"]
pub(super) enum Command {
    /// Open this scene.
    Open(SceneSource),
    /// Choose a file and open it.
    OpenDialog,
    /// Read the present scene again.
    Reload,
    /// Ask for a file name, then save.
    Save(SaveKind),
    /// Save under a free name without asking: pictures in their folder, the rest beside the scene.
    QuickSave(SaveKind),
    /// Put a lamp into this state.
    SetLamp(usize, LampState),
    /// Switch a lamp over.
    ToggleLamp(usize),
    /// All on or all off.
    AllLamps(bool),
    /// This one on, all others off; once more: as before.
    SoloLamp(usize),
    /// As the file has them.
    ResetLamps,
    /// Another sky over the model, or none.
    SetDaylight(Option<Box<DaylightChoice>>),
    /// Choose a weather file for the sky over the model.
    WeatherDialog,
    /// Take place and sky from this weather file.
    SetWeather(PathBuf),
    /// Play the day, or end that.
    ToggleDay,
    /// A new reflectance; `None` restores that of the file.
    SetReflectance(usize, Option<[f64; 3]>),
    /// Place lamps below the ceilings of all rooms, once they are found.
    AddCeilingLamps,
    /// All as the file has them.
    ResetMaterials,
    /// How the picture is made.
    SetDisplay(DisplaySettings),
    /// Back by one edit.
    Undo,
    /// Forward by one edit.
    Redo,
    /// Keep the present light as state A of the comparison.
    StoreComparison,
    /// Show state A beside the present light, or not; where there is none yet, keep one.
    ToggleSplit,
    /// Play the tour through the bookmarks, or end it.
    ToggleTour,
    /// Glide to a bookmark.
    GoToView(usize),
    /// To the next (1) or previous (-1) bookmark.
    StepView(i32),
    /// To the start view.
    Home,
    /// Keep the present view as a bookmark until the scene is closed.
    StoreView,
    /// Give a bookmark another name.
    RenameView(usize, String),
    /// Forget a bookmark that is not the start view.
    RemoveView(usize),
    /// The model is in this unit, with this axis upwards: say so in its sidecar and read it again.
    SetFrame(LengthUnit, UpAxis),
    /// Write lamps, materials and bookmarks as they are to the scene's sidecar.
    SaveSidecar,
    /// Walk or fly.
    SetMotion(Motion),
    /// Eyes above the floor, metres.
    SetEyeHeight(f64),
    /// Vertical field of view, degrees.
    SetFov(f64),
    /// Let the solve rest, or go on.
    Pause(bool),
    /// End the solve.
    Stop,
    /// Solve with other settings.
    Solve(SolveSettings),
    /// How exact the light is, or is to become.
    Accuracy(Ask),
    /// What is doubtful about the model.
    Doctor(doctor::Ask),
    /// Look into this patch, or into none; its numbers come into view.
    Inspect(Option<u32>),
    /// Look into this patch; the panel stays where it is.
    PickNext(u32),
    /// Back to the patch looked into before.
    PickBack,
    /// The row of the patch looked into as a heat map on the scene, or what was shown before.
    ToggleRow,
    /// Show or hide the table of patches.
    ToggleTable,
    /// Glide to where this patch is seen well, and look into it.
    JumpToPatch(u32),
    /// Show or hide both side panels.
    TogglePanels,
    /// Show or hide the left panel.
    ToggleLeft,
    /// Show or hide the right panel.
    ToggleRight,
    /// Show or hide the line at the bottom.
    ToggleStatus,
    /// Show or hide the keys.
    ToggleHelp,
    /// Load files again when they change.
    ReloadOnChange(bool),
    /// Whether light that has settled is made finer.
    RefineAtLeisure(bool),
    /// Take the banner of this key away until another scene is open.
    DismissBanner(&'static str),
    /// Take the message away.
    DismissMessage,
    /// Close the window.
    Quit,
}

/// What an edit touches: edits of one thing in one gesture make one step of undo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EditKey {
    /// One lamp.
    Lamp(usize),
    /// All lamps at once.
    Lamps,
    /// Which lamps are placed in the model.
    PlacedLamps,
    /// The sky over the model.
    Daylight,
    /// One material.
    Material(usize),
    /// All materials at once.
    Materials,
    /// The display.
    Display,
}

impl Command {
    /// What undo covers and whether successive ones melt into one step; `None` for other commands.
    pub(super) fn edit_key(&self) -> Option<EditKey> {
        match self {
            Self::SetLamp(lamp, _) => Some(EditKey::Lamp(*lamp)),
            Self::ToggleLamp(_) | Self::AllLamps(_) | Self::SoloLamp(_) | Self::ResetLamps => {
                Some(EditKey::Lamps)
            }
            Self::SetReflectance(material, _) => Some(EditKey::Material(*material)),
            Self::SetDaylight(_) => Some(EditKey::Daylight),
            Self::ResetMaterials => Some(EditKey::Materials),
            Self::SetDisplay(_) => Some(EditKey::Display),
            _ => None,
        }
    }
}
