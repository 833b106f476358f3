//! The patch looked into: its numbers, its row, what it sees, what lies beside it.

use super::{Commands, Model, empty, hemicube, row};
use crate::display::luminance;
use crate::mesh::{Patch, Side};
use crate::scene::{Scene, illuminance};
use crate::ui::command::Command;
use crate::ui::{theme, units};
use egui::{Button, RichText};

/// Shows the picked patch, or how to pick one, and the list.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let (Some(scene), Some(mesh)) = (model.scene, model.mesh) else {
        super::no_scene(ui, model, "No scene is open.");
        return;
    };
    let Some((id, patch)) = model.inspected.and_then(|id| Some((id, mesh.patches.get(id as usize)?))) else {
        empty(ui, "Ctrl-click a surface to look into its patch.");
        if ui.button("Table of patches").on_hover_text("Those that stand out first (J)").clicked() {
            out.push(Command::ToggleTable);
        }
        return;
    };
    title(ui, model, id, out);
    row::switch(ui, model, out);
    ui.spacing_mut().item_spacing.y = 2.0;
    headline(ui, model, scene, id, patch);
    // The answer for the patch before stays until the new one is there, so that nothing jumps.
    if let Some(inspection) = model.microscope.inspection() {
        group(ui, "Hemicube", |ui| hemicube::show(ui, model, inspection, out));
        group(ui, "Row of form factors", |ui| row::numbers(ui, model, inspection, out));
        group(ui, "Where its light comes from", |ui| row::largest(ui, model, inspection, out));
        group(ui, "Neighbours", |ui| row::neighbours(ui, model, inspection, out));
    }
    group(ui, "More numbers", |ui| numbers(ui, model, scene, id, patch));
}

fn group(ui: &mut egui::Ui, title: &str, contents: impl FnOnce(&mut egui::Ui)) {
    let heading = RichText::new(title).color(theme::TEXT);
    egui::CollapsingHeader::new(heading).id_salt(title).default_open(true).show_unindented(ui, contents);
}

fn title(ui: &mut egui::Ui, model: &Model<'_>, id: u32, out: &mut Commands) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("Patch {}", units::count(id as usize))).strong().color(theme::ACCENT));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Clear").on_hover_text("Look into no patch (Esc)").clicked() {
                out.push(Command::Inspect(None));
            }
            if ui.button("Go there").on_hover_text("Glide to where it is seen well").clicked() {
                out.push(Command::JumpToPatch(id));
            }
            let back = ui.add_enabled(model.can_go_back, Button::new("Back"));
            if back.on_hover_text("To the patch looked into before (Backspace)").clicked() {
                out.push(Command::PickBack);
            }
        });
    });
}

/// How bright it is, and what it is a part of.
fn headline(ui: &mut egui::Ui, model: &Model<'_>, scene: &Scene, id: u32, patch: &Patch) {
    let index = id as usize;
    let irradiance = model.light.irradiance.get(index).copied().unwrap_or_default();
    let radiosity = model.light.radiosity.get(index).copied().unwrap_or_default();
    theme::row(ui, "Illuminance", format!("{} lx", units::light(illuminance(irradiance.map(f64::from)))));
    theme::row(ui, "Luminance", format!("{} cd/m²", units::light(luminance(radiosity))));
    if let Some(factor) = model.daylight_factors.and_then(|factors| factors.get(index)) {
        theme::row(ui, "Daylight factor", format!("{} %", units::digits(f64::from(*factor))));
    }
    let object = model.mesh.and_then(|m| m.regions.get(patch.region as usize)).map(|r| r.object as usize);
    let name = object.and_then(|o| scene.objects.get(o)).map_or("-", String::as_str);
    theme::row(ui, "Object", name);
    theme::row(ui, "Material", scene.materials.get(patch.material as usize).map_or("-", |m| m.name.as_str()));
    if let Some(lamp) = patch.luminaire.and_then(|l| scene.luminaires.get(l as usize)) {
        theme::row(ui, "Lamp", lamp.name.as_str());
    }
}

fn numbers(ui: &mut egui::Ui, model: &Model<'_>, scene: &Scene, id: u32, patch: &Patch) {
    let index = id as usize;
    let irradiance = model.light.irradiance.get(index).copied().unwrap_or_default();
    let radiosity = model.light.radiosity.get(index).copied().unwrap_or_default();
    let rho = model.reflectance.get(index).copied().unwrap_or(patch.reflectance.map(|r| r as f32));
    theme::row(ui, "Reflectance", bands(rho));
    theme::row(ui, "Irradiance H, W/m²", bands(irradiance));
    theme::row(ui, "Radiosity B, W/m²", bands(radiosity));
    theme::row(ui, "Area", format!("{} m²", units::digits(patch.area)));
    if patch.is_cluster {
        theme::row(ui, "Shared by", format!("{} small faces", units::count(patch.pieces.len())));
    }
    let aspect = model.aspect.get(index).copied().unwrap_or_default();
    theme::row(ui, "Aspect", units::digits(f64::from(aspect)));
    theme::row(ui, "Side", if patch.side == Side::Front { "front" } else { "back" });
    let centre = scene.in_file(patch.centre).to_array().map(units::coordinate).join("  ");
    theme::row(ui, &format!("Centre, {}", scene.unit.symbol()), centre);
    theme::row(ui, "Normal", bands(patch.normal.to_array().map(|x| x as f32)));
}

fn bands(values: [f32; 3]) -> String {
    values.map(|v| units::digits(f64::from(v))).join("  ")
}
