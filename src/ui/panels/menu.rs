//! The bar at the top: menus, the name of the scene, and the state of the solve.

use super::solver::{fraction_of, is_running};
use super::{Commands, Model};
use crate::scene::{LengthUnit, SceneSource, Severity, UpAxis};
use crate::ui::command::{Command, SaveKind};
use crate::ui::doctor::Ask;
use crate::ui::state::{DisplaySettings, Quantity, ShadingMode};
use crate::ui::{theme, units};
use egui::{Button, RichText};

/// The embedded scenes and what the menu says of them.
const BUILTIN: [(&str, &str); 5] = [
    ("hemicube", "Room of 1985"),
    ("cornell", "Cornell box"),
    ("house", "House in the evening"),
    ("house-by-day", "House by day"),
    ("gallery", "Gallery"),
];

/// Width below which the error is left to the accuracy section, points.
const NARROW: f32 = 250.0;

/// The units that a model can be in.
const UNITS: [(LengthUnit, &str); 5] = [
    (LengthUnit::Millimetre, "Millimetres"),
    (LengthUnit::Centimetre, "Centimetres"),
    (LengthUnit::Metre, "Metres"),
    (LengthUnit::Inch, "Inches"),
    (LengthUnit::Foot, "Feet"),
];

/// Shows the bar.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file(ui, model, out));
        ui.menu_button("Edit", |ui| edit(ui, model, out));
        ui.menu_button("View", |ui| view(ui, model, out));
        ui.menu_button("Mesh", |ui| mesh(ui, model, out));
        ui.menu_button("Help", |ui| item(ui, out, "Keys", "F1", true, Command::ToggleHelp));
        ui.add_space(10.0);
        if let Some(scene) = model.scene {
            let patches = model.mesh.map_or(0, |mesh| mesh.patches.len());
            let text = format!("{}  -  {} patches", scene.name, units::count(patches));
            ui.label(RichText::new(text).color(theme::TEXT));
        }
        badge(ui, model, out);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| solve_state(ui, model));
    });
}

/// How many findings of the doctor deserve a look; nothing where none does.
fn badge(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let Some(report) = model.doctor.report() else { return };
    let (errors, warnings) = (report.count(Severity::Error), report.count(Severity::Warning));
    if errors + warnings == 0 {
        return;
    }
    let told = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
    let (text, colour) = match (errors, warnings) {
        (0, warnings) => (told(warnings, "warning"), theme::WARNING),
        (errors, 0) => (told(errors, "error"), theme::FAILURE),
        (errors, warnings) => {
            (format!("{}, {}", told(errors, "error"), told(warnings, "warning")), theme::FAILURE)
        }
    };
    let button = Button::new(RichText::new(text).small().color(colour)).small();
    if ui.add(button).on_hover_text("What the doctor found doubtful about the model (K)").clicked() {
        out.push(Command::Doctor(Ask::Toggle));
    }
}

fn solve_state(ui: &mut egui::Ui, model: &Model<'_>) {
    let verdict = super::verdict::of(model);
    let mut text = verdict.line();
    if is_running(model.snapshot.stage) {
        text += &format!("  {:.0} %", 100.0 * fraction_of(model.snapshot));
        if let Some(left) = super::solver::time_left(model.snapshot) {
            text += &format!("  {}", units::estimate(left));
        }
    }
    if ui.available_width() < NARROW {
        text = verdict.state;
    }
    ui.add(egui::Label::new(RichText::new(text).color(verdict.colour)).truncate())
        .on_hover_text("Whether the light has settled, and the RMS error of the picture as rays found it");
    let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(10.0), egui::Sense::hover());
    ui.painter().circle_filled(rect.center(), 4.0, verdict.colour);
}

fn item(ui: &mut egui::Ui, out: &mut Commands, text: &str, key: &str, enabled: bool, command: Command) {
    if ui.add_enabled(enabled, Button::new(text).shortcut_text(key)).clicked() {
        out.push(command);
        ui.close();
    }
}

/// An item of what is in force or not; in the accent where it is.
fn choice(ui: &mut egui::Ui, out: &mut Commands, text: &str, key: &str, on: bool, command: Command) {
    if ui.add(Button::new(text).selected(on).shortcut_text(key)).clicked() {
        out.push(command);
        ui.close();
    }
}

fn file(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    item(ui, out, "Open...", "Ctrl-O", true, Command::OpenDialog);
    ui.menu_button("Open recent", |ui| {
        if model.state.recent.is_empty() {
            ui.label(RichText::new("No file yet").color(theme::TEXT_WEAK));
        }
        for path in &model.state.recent {
            let name = path
                .file_name()
                .map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned());
            let button = ui.button(name).on_hover_text(path.display().to_string());
            if button.clicked() {
                out.push(Command::Open(SceneSource::File(path.clone())));
                ui.close();
            }
        }
    });
    ui.menu_button("Embedded scenes", |ui| {
        for (name, title) in BUILTIN {
            item(ui, out, title, "", true, Command::Open(SceneSource::Builtin(name.to_owned())));
        }
    });
    item(ui, out, "Reload", "F5", model.scene.is_some(), Command::Reload);
    let mut reload = model.state.reload_on_change;
    if ui.checkbox(&mut reload, "Reload when the file changes").changed() {
        out.push(Command::ReloadOnChange(reload));
    }
    let frame = ui.menu_button("Unit and up axis", |ui| frame_of(ui, model, out));
    frame.response.on_hover_text("Of the model; kept in NAME.toml beside it");
    ui.separator();
    let lit = !model.light.radiosity.is_empty();
    for kind in [SaveKind::Screenshot, SaveKind::Hdr, SaveKind::PatchTable, SaveKind::LitMesh] {
        let key = match kind {
            SaveKind::Screenshot => "F12",
            SaveKind::Hdr => "Shift-F12",
            _ => "",
        };
        item(ui, out, kind.title(), key, lit, Command::Save(kind));
    }
    let has_file = model.scene.is_some_and(|scene| scene.source.path().is_some());
    item(
        ui,
        out,
        SaveKind::RepairedCopy.title(),
        "",
        model.scene.is_some(),
        Command::Save(SaveKind::RepairedCopy),
    );
    if model.scene.is_some() && !has_file {
        let copy = SaveKind::EditedCopy;
        item(ui, out, copy.title(), "", true, Command::Save(copy));
    } else {
        item(ui, out, "Save lamps, materials and bookmarks", "", has_file, Command::SaveSidecar);
    }
    ui.separator();
    item(ui, out, "Quit", "Ctrl-Q", true, Command::Quit);
}

/// A unit and an up axis in words: "feet, z up".
pub(in crate::ui) fn frame_name(unit: LengthUnit, up: UpAxis) -> String {
    format!("{}, {} up", unit.name(), if up == UpAxis::Z { "z" } else { "y" })
}

/// In which unit the model is, and which of its axes points up.
fn frame_of(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let Some(scene) = model.scene.filter(|scene| scene.source.path().is_some()) else {
        ui.label(RichText::new("Embedded scenes know theirs").color(theme::TEXT_WEAK));
        return;
    };
    for (unit, name) in UNITS {
        choice(ui, out, name, unit.symbol(), scene.unit == unit, Command::SetFrame(unit, scene.up));
    }
    ui.separator();
    for (up, name) in [(UpAxis::Y, "Y is up"), (UpAxis::Z, "Z is up")] {
        choice(ui, out, name, "", scene.up == up, Command::SetFrame(scene.unit, up));
    }
}

fn edit(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    item(ui, out, "Undo", "Ctrl-Z", model.can[0], Command::Undo);
    item(ui, out, "Redo", "Ctrl-Shift-Z", model.can[1], Command::Redo);
    ui.separator();
    item(ui, out, "All lamps on", "", true, Command::AllLamps(true));
    item(ui, out, "All lamps off", "0", true, Command::AllLamps(false));
    item(ui, out, "Reset all lamps", "", true, Command::ResetLamps);
    let can_add = model.scene.is_some() && !model.is_adding_lamps;
    item(ui, out, "Add ceiling lamps", "", can_add, Command::AddCeilingLamps);
    item(ui, out, "Reset all materials", "", true, Command::ResetMaterials);
}

fn view(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    item(ui, out, "To the start view", "Home", true, Command::Home);
    item(ui, out, "Store this view", "B", true, Command::StoreView);
    let tour = if model.tour.is_some() { "Stop the tour" } else { "Tour through the bookmarks" };
    item(ui, out, tour, "T", model.can_tour, Command::ToggleTour);
    item(ui, out, "Light A beside now", "C", !model.light.radiosity.is_empty(), Command::ToggleSplit);
    ui.separator();
    let display = model.edits.display;
    for quantity in [Quantity::Picture, Quantity::Illuminance, Quantity::Luminance, Quantity::DaylightFactor]
    {
        let new = display.showing(quantity);
        let key = if quantity == Quantity::Illuminance { "L" } else { "" };
        choice(ui, out, quantity.name(), key, display.quantity == quantity, Command::SetDisplay(new));
    }
    ui.separator();
    let state = model.state;
    choice(ui, out, "Left panel", "", state.left_open, Command::ToggleLeft);
    choice(ui, out, "Right panel", "", state.right_open, Command::ToggleRight);
    item(ui, out, "Fold or unfold both", "Tab", true, Command::TogglePanels);
    choice(ui, out, "Status line", "", state.show_status, Command::ToggleStatus);
}

fn mesh(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let display = model.edits.display;
    let borders = DisplaySettings { wireframe: !display.wireframe, ..display };
    choice(ui, out, "Patch borders", "M", display.wireframe, Command::SetDisplay(borders));
    let flat = display.shading == ShadingMode::Flat;
    let shading = if flat { ShadingMode::Smooth } else { ShadingMode::Flat };
    let other = DisplaySettings { shading, ..display };
    choice(ui, out, "Flat shading", "G", flat, Command::SetDisplay(other));
    ui.separator();
    const OF_THE_MESH: [Quantity; 6] = [
        Quantity::PatchIds,
        Quantity::Normals,
        Quantity::Sides,
        Quantity::Aspect,
        Quantity::Area,
        Quantity::Reflectance,
    ];
    const OF_ITS_FAULTS: [Quantity; 6] = [
        Quantity::Error,
        Quantity::Escape,
        Quantity::Closure,
        Quantity::Reciprocity,
        Quantity::Residual,
        Quantity::Unshot,
    ];
    for quantities in [OF_THE_MESH, OF_ITS_FAULTS] {
        for quantity in quantities {
            let command = Command::SetDisplay(display.showing(quantity));
            choice(ui, out, quantity.name(), "", display.quantity == quantity, command);
        }
        ui.separator();
    }
    // Without a patch there is no row to show; it is looked into first, under the cursor (R).
    let row = Button::new("Row on the scene").selected(display.quantity.is_row()).shortcut_text("R");
    if ui.add_enabled(model.inspected.is_some(), row).clicked() {
        out.push(Command::ToggleRow);
        ui.close();
    }
    item(ui, out, "Back to the patch before", "Backspace", model.can_go_back, Command::PickBack);
    choice(ui, out, "Table of patches", "J", model.visit.table_open, Command::ToggleTable);
    choice(ui, out, "Doctor", "K", model.visit.doctor_open, Command::Doctor(Ask::Toggle));
    item(ui, out, "Look into no patch", "Esc", model.inspected.is_some(), Command::Inspect(None));
}
