//! The panels. Each shows a [`Model`] and answers with commands; none changes anything itself.

pub(super) mod accuracy;
mod colour_picker;
pub(super) mod daylight;
pub(super) mod display;
pub(super) mod doctor;
mod error_chart;
pub(super) mod help;
mod hemicube;
pub(super) mod inspect;
pub(super) mod lights;
mod list;
pub(super) mod materials;
pub(super) mod menu;
mod polar;
mod row;
pub(super) mod solver;
pub(super) mod status;
pub(super) mod table;
mod verdict;
pub(super) mod views;

use super::auditor::Auditor;
use super::command::Command;
use super::daylight::Day;
use super::doctor::Doctor;
use super::fonts::Unreadable;
use super::microscope::Microscope;
use super::state::{Edits, UiState, Visit};
use crate::display::{Exposure, FalseColour};
use crate::mesh::PatchMesh;
use crate::scene::{Scene, View};
use crate::session::Snapshot;
use crate::solve::{SolveSettings, Stage};
use crate::solver::{PatchLight, Power};

/// Everything that panels show, borrowed for one frame.
pub(super) struct Model<'a> {
    /// What the worker published last.
    pub(super) snapshot: &'a Snapshot,
    /// The settings asked for last.
    pub(super) settings: SolveSettings,
    /// The scene on screen.
    pub(super) scene: Option<&'a Scene>,
    /// Its patches.
    pub(super) mesh: Option<&'a PatchMesh>,
    /// Their light as the lamps stand.
    pub(super) light: &'a PatchLight,
    /// Where its power goes.
    pub(super) power: Power,
    /// Seconds that it took last from the lamps' bases to the corners that are drawn.
    pub(super) display_seconds: f64,
    /// Grows with every change of `light`.
    pub(super) light_version: u64,
    /// Their reflectance as solved for.
    pub(super) reflectance: &'a [[f32; 3]],
    /// Longest extent squared over area, a patch each.
    pub(super) aspect: &'a [f32],
    /// Luminous flux of each lamp at full output as it comes with the file, lm.
    pub(super) full_lumens: &'a [f64],
    /// What the user changed.
    pub(super) edits: &'a Edits,
    /// What the window remembers.
    pub(super) state: &'a UiState,
    /// How the scene is looked at.
    pub(super) visit: &'a Visit,
    /// Characters that no font has.
    pub(super) unreadable: &'a Unreadable,
    /// Bookmarks: of the scene and stored by the user.
    pub(super) views: &'a [View],
    /// The one to start from.
    pub(super) start_view: usize,
    /// The one that the camera stands at.
    pub(super) view_here: Option<usize>,
    /// The false-colour scale in force.
    pub(super) scale: Option<FalseColour>,
    /// The exposure in force, EV at ISO 100.
    pub(super) ev: f64,
    /// Vertical field of view, degrees.
    pub(super) fov_deg: f64,
    /// The patch looked into.
    pub(super) inspected: Option<u32>,
    /// It was picked just now.
    pub(super) inspect_fresh: bool,
    /// Whether another one was looked into before it.
    pub(super) can_go_back: bool,
    /// Its row and hemicube, and the maps of what is wrong.
    pub(super) microscope: &'a Microscope,
    /// The exposure that the picture is drawn with.
    pub(super) exposure: Exposure,
    /// What each band is multiplied with, so that eyes have adapted to the lamps.
    pub(super) gains: [f32; 3],
    /// The numbers that false colours show, one a patch.
    pub(super) shown_values: &'a [f32],
    /// The daylight factors of all patches, per cent, where they are known.
    pub(super) daylight_factors: Option<&'a [f32]>,
    /// The lamp that stands alone.
    pub(super) solo: Option<usize>,
    /// Whether a state A is stored.
    pub(super) has_comparison: bool,
    /// What the daylight that is asked for comes to.
    pub(super) day: Option<&'a Day>,
    /// Whether it plays.
    pub(super) is_day_playing: bool,
    /// Seconds that a tour has played, and will play in all.
    pub(super) tour: Option<[f64; 2]>,
    /// Whether there are bookmarks enough for a tour.
    pub(super) can_tour: bool,
    /// The longest work of the program for one frame of this scene, seconds.
    pub(super) longest_secs: f64,
    /// What the last edit recomputed.
    pub(super) last_change: &'a str,
    /// How wrong the picture is, and what solves cost.
    pub(super) auditor: &'a Auditor,
    /// What is doubtful about the model.
    pub(super) doctor: &'a Doctor,
    /// Places for ceiling lamps are being looked for.
    pub(super) is_adding_lamps: bool,
    /// Undo and redo.
    pub(super) can: [bool; 2],
    /// Seconds that the last frames took on average.
    pub(super) frame_secs: f64,
    /// Memory of the process, bytes, where known.
    pub(super) memory: Option<u64>,
}

/// What a panel answers.
pub(super) type Commands = Vec<Command>;

/// A section with a title that folds.
pub(super) fn section(ui: &mut egui::Ui, title: &str, open: bool, contents: impl FnOnce(&mut egui::Ui)) {
    let heading = egui::RichText::new(title.to_uppercase()).size(11.5).color(super::theme::TEXT);
    egui::CollapsingHeader::new(heading).id_salt(title).default_open(open).show_unindented(ui, |ui| {
        contents(ui);
        ui.add_space(6.0);
    });
    ui.separator();
}

/// What stands in a section without a scene; that one is on its way where it is.
pub(super) fn no_scene(ui: &mut egui::Ui, model: &Model<'_>, text: &str) {
    let is_coming = !matches!(model.snapshot.stage, Stage::Idle | Stage::Failed);
    empty(ui, if is_coming { "Loading..." } else { text });
}

/// A swatch of an sRGB colour that opens `contents` below it; `name` is what it is called where it is not seen.
fn swatch(
    ui: &mut egui::Ui,
    [r, g, b]: [u8; 3],
    name: String,
    tip: &str,
    contents: impl FnOnce(&mut egui::Ui),
) {
    use egui::containers::menu::{MenuButton, MenuConfig};
    let swatch = egui::Button::new("")
        .fill(egui::Color32::from_rgb(r, g, b))
        .stroke(egui::Stroke::new(1.0, egui::Color32::from_gray(84)))
        .small()
        .min_size(egui::Vec2::new(22.0, 18.0));
    let config = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    let (response, opened) = MenuButton::from_button(swatch).config(config).ui(ui, |ui| {
        ui.set_min_width(250.0);
        super::theme::undo_menu_style(ui);
        contents(ui);
    });
    // What it belongs to has been scrolled out of sight.
    if opened.is_some() && !ui.is_rect_visible(response.rect) {
        egui::Popup::close_all(ui.ctx());
    }
    response.on_hover_text(tip).accessible_name(name);
}

/// A line of weak text where a section has nothing to show yet.
pub(super) fn empty(ui: &mut egui::Ui, text: &str) {
    ui.label(egui::RichText::new(text).color(super::theme::TEXT_WEAK));
}
