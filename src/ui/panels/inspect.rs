//! A patch and its numbers, and the list of those that stand out.

use super::{Commands, Model, empty};
use crate::display::luminance;
use crate::mesh::{Patch, Side};
use crate::scene::{Scene, illuminance};
use crate::ui::command::Command;
use crate::ui::{theme, units};
use egui::{Button, RichText};

/// Lines in the list of patches that stand out.
const LISTED: usize = 12;

/// By what the list is sorted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum SortBy {
    #[default]
    Aspect,
    Area,
    Illuminance,
    Luminance,
}

impl SortBy {
    const ALL: [(Self, &str, &str); 4] = [
        (Self::Aspect, "Aspect", "Longest extent squared over area"),
        (Self::Area, "Area", "Largest first"),
        (Self::Illuminance, "lx", "Brightest lit first"),
        (Self::Luminance, "cd/m²", "Brightest first"),
    ];
}

/// Shows the picked patch, or how to pick one, and the list.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let (Some(scene), Some(mesh)) = (model.scene, model.mesh) else {
        empty(ui, "No scene is open.");
        return;
    };
    if model.inspect_fresh {
        ui.scroll_to_cursor(Some(egui::Align::TOP));
    }
    match model.inspected.and_then(|id| Some((id, mesh.patches.get(id as usize)?))) {
        Some((id, patch)) => numbers(ui, model, scene, id, patch, out),
        None => empty(ui, "Ctrl-click a surface to look into its patch."),
    }
    theme::group_title(ui, "Patches that stand out");
    let id = ui.scope_id().with("sorted by");
    let mut sort: SortBy = ui.data(|d| d.get_temp(id)).unwrap_or_default();
    ui.horizontal(|ui| {
        for (by, label, tip) in SortBy::ALL {
            let button = Button::selectable(sort == by, label);
            if ui.add(button).on_hover_text(tip).accessible_name(format!("Sort by {label}")).clicked() {
                sort = by;
            }
        }
    });
    ui.data_mut(|d| d.insert_temp(id, sort));
    for (patch, value) in listed(ui, model, sort) {
        let text = format!("{:>7}   {}", units::count(patch as usize), units::digits(value));
        let button = Button::selectable(model.inspected == Some(patch), RichText::new(text).monospace());
        if ui
            .add(button)
            .on_hover_text("Go there and look into it")
            .accessible_name(format!("Patch {patch}"))
            .clicked()
        {
            out.push(Command::JumpToPatch(patch));
        }
    }
}

/// The list as it was, or made anew where the sorting or the light has changed.
fn listed(ui: &egui::Ui, model: &Model<'_>, sort: SortBy) -> Vec<(u32, f64)> {
    type Kept = ((SortBy, u64), std::sync::Arc<Vec<(u32, f64)>>);
    let (id, key) = (ui.scope_id().with("listed"), (sort, model.light_version));
    if let Some((kept, list)) = ui.data(|d| d.get_temp::<Kept>(id))
        && kept == key
    {
        return list.to_vec();
    }
    let list = worst(model, sort);
    ui.data_mut(|d| d.insert_temp::<Kept>(id, (key, std::sync::Arc::new(list.clone()))));
    list
}

fn worst(model: &Model<'_>, sort: SortBy) -> Vec<(u32, f64)> {
    let Some(mesh) = model.mesh else { return Vec::new() };
    let value = |index: usize| match sort {
        SortBy::Aspect => model.aspect.get(index).copied().map_or(0.0, f64::from),
        SortBy::Area => mesh.patches[index].area,
        SortBy::Illuminance => {
            model.light.irradiance.get(index).map_or(0.0, |h| illuminance(h.map(f64::from)))
        }
        SortBy::Luminance => model.light.radiosity.get(index).map_or(0.0, |b| luminance(*b)),
    };
    let mut all: Vec<(u32, f64)> = (0..mesh.patches.len()).map(|i| (i as u32, value(i))).collect();
    let descending = |a: &(u32, f64), b: &(u32, f64)| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0));
    if all.len() > LISTED {
        all.select_nth_unstable_by(LISTED, descending);
        all.truncate(LISTED);
    }
    all.sort_by(descending);
    all
}

fn numbers(ui: &mut egui::Ui, model: &Model<'_>, scene: &Scene, id: u32, patch: &Patch, out: &mut Commands) {
    let index = id as usize;
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("Patch {}", units::count(index))).strong().color(theme::ACCENT));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Clear").on_hover_text("Look into no patch (Esc)").clicked() {
                out.push(Command::Inspect(None));
            }
            if ui.button("Go there").clicked() {
                out.push(Command::JumpToPatch(id));
            }
        });
    });
    let irradiance = model.light.irradiance.get(index).copied().unwrap_or_default();
    let radiosity = model.light.radiosity.get(index).copied().unwrap_or_default();
    theme::row(ui, "Illuminance", format!("{} lx", units::digits(illuminance(irradiance.map(f64::from)))));
    theme::row(ui, "Luminance", format!("{} cd/m²", units::digits(luminance(radiosity))));
    let object = model.mesh.and_then(|m| m.regions.get(patch.region as usize)).map(|r| r.object as usize);
    let name = object.and_then(|o| scene.objects.get(o)).map_or("-", String::as_str);
    theme::row(ui, "Object", name);
    theme::row(ui, "Material", scene.materials.get(patch.material as usize).map_or("-", |m| m.name.as_str()));
    if let Some(lamp) = patch.luminaire.and_then(|l| scene.luminaires.get(l as usize)) {
        theme::row(ui, "Lamp", lamp.name.as_str());
    }
    let rho = model.reflectance.get(index).copied().unwrap_or(patch.reflectance.map(|r| r as f32));
    theme::row(ui, "Reflectance", bands(rho));
    theme::row(ui, "Irradiance H, W/m²", bands(irradiance));
    theme::row(ui, "Radiosity B, W/m²", bands(radiosity));
    theme::row(ui, "Area", format!("{} m²", units::digits(patch.area)));
    let aspect = model.aspect.get(index).copied().unwrap_or_default();
    theme::row(ui, "Aspect", units::digits(f64::from(aspect)));
    theme::row(ui, "Side", if patch.side == Side::Front { "front" } else { "back" });
    let unit = scene.unit.metres();
    let centre = (patch.centre / unit).to_array().map(|x| x as f32);
    theme::row(ui, &format!("Centre, {}", scene.unit.symbol()), bands(centre));
    theme::row(ui, "Normal", bands(patch.normal.to_array().map(|x| x as f32)));
}

fn bands(values: [f32; 3]) -> String {
    values.map(|v| units::digits(f64::from(v))).join("  ")
}
