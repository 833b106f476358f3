//! What the patch looked into sees: its hemicube, unfolded into a cross.

use super::{Commands, Model};
use crate::display::{ToneMap, patch_colour, srgb_encode};
use crate::form_factors::ItemBuffer;
use crate::ui::command::Command;
use crate::ui::microscope::Inspection;
use crate::ui::{theme, units};
use egui::{Button, Color32, ColorImage, Pos2, Rect, RichText, Sense, Stroke, TextureHandle, Vec2};

/// By what the cells are coloured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Colours {
    /// The light of the patches as the view shows it.
    #[default]
    Light,
    /// A colour for every patch.
    Ids,
}

/// Everything that the picture depends on.
#[derive(Clone, PartialEq)]
struct Key {
    patch: u32,
    colours: Colours,
    microscope: u64,
    light: u64,
    factor: f32,
    gains: [f32; 3],
    tone_map: ToneMap,
}

/// Shows the cross; hovering tells what a cell sees, a click looks into it.
pub(super) fn show(ui: &mut egui::Ui, model: &Model<'_>, inspection: &Inspection, out: &mut Commands) {
    let id = ui.scope_id().with("hemicube colours");
    let mut colours: Colours = ui.data(|d| d.get_temp(id)).unwrap_or_default();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Colours").color(theme::TEXT_WEAK));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (choice, label, name) in [
                (Colours::Ids, "Patch ids", "Hemicube by patch ids"),
                (Colours::Light, "Light", "Hemicube by light"),
            ] {
                let button = Button::selectable(colours == choice, label);
                if ui.add(button).accessible_name(name).clicked() {
                    colours = choice;
                }
            }
        });
    });
    ui.data_mut(|d| d.insert_temp(id, colours));
    let texture = texture(ui, model, inspection, colours);
    let side = ui.available_width().min(inspection.hemicube.size() as f32);
    let (place, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), side), Sense::hover());
    let rect = Rect::from_center_size(place.center(), Vec2::splat(side));
    let response = ui.interact(rect, ui.scope_id().with("hemicube"), Sense::click());
    let name = format!("Hemicube of patch {}", inspection.patch);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Button, true, &name));
    let uv = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    ui.painter().image(texture.id(), rect, uv, Color32::WHITE);
    let top = Rect::from_center_size(rect.center(), 0.5 * rect.size());
    let line = Stroke::new(1.0, Color32::from_white_alpha(46));
    ui.painter().rect_stroke(top, 0.0, line, egui::StrokeKind::Middle);
    if response.has_focus() {
        ui.painter().rect_stroke(rect, 0.0, Stroke::new(1.0, theme::ACCENT), egui::StrokeKind::Inside);
    }
    let Some(at) = response.hover_pos() else { return };
    let cells = inspection.hemicube.size() as f32;
    let [x, y] = [at.x - rect.left(), at.y - rect.top()].map(|p| (p / side * cells).max(0.0) as usize);
    let Some(cell) = inspection.hemicube.cell(x, y) else { return };
    let seen = cell.patch.and_then(|j| Some((j, model.mesh?.patches.get(j as usize)?)));
    if seen.is_some() {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
    }
    let clicked = response.clicked();
    response.on_hover_ui_at_pointer(|ui| {
        match seen {
            Some((j, patch)) => {
                let material = model.scene.and_then(|s| s.materials.get(patch.material as usize));
                let name = material.map_or("", |m| m.name.as_str());
                ui.label(format!("patch {}  -  {name}", units::count(j as usize)));
                let sum = units::digits(inspection.hemicube.form_factor(j));
                ui.label(format!("F {} in the row, {sum} by these cells", units::digits(inspection.get(j))));
            }
            None => _ = ui.label("nothing that takes part: the open, or a side without light"),
        }
        ui.label(RichText::new(format!("delta form factor {}", units::digits(cell.delta))).small());
    });
    if let Some((j, _)) = seen.filter(|_| clicked) {
        out.push(Command::PickNext(j));
    }
}

/// The picture as it was, or drawn anew where something has changed.
fn texture(ui: &egui::Ui, model: &Model<'_>, inspection: &Inspection, colours: Colours) -> TextureHandle {
    let tone_map = model.edits.display.tone_map;
    let key = Key {
        patch: inspection.patch,
        colours,
        microscope: model.microscope.version,
        light: model.light_version,
        factor: model.exposure.factor(),
        gains: model.gains,
        tone_map,
    };
    let id = ui.scope_id().with("hemicube picture");
    if let Some((known, texture)) = ui.data(|d| d.get_temp::<(Key, TextureHandle)>(id))
        && known == key
    {
        return texture;
    }
    let colour = |patch: u32| match colours {
        Colours::Ids => patch_colour(patch),
        Colours::Light => {
            let b = model.light.radiosity.get(patch as usize).copied().unwrap_or_default();
            tone_map.apply(std::array::from_fn(|band| b[band] * key.gains[band] * key.factor))
        }
    };
    let image = picture(&inspection.hemicube, colour);
    let texture = ui.ctx().load_texture("hemicube", image, egui::TextureOptions::NEAREST);
    ui.data_mut(|d| d.insert_temp(id, (key, texture.clone())));
    texture
}

/// The cross as an image; `colour` gives the display-linear colour of a patch.
fn picture(buffer: &ItemBuffer, colour: impl Fn(u32) -> [f32; 3]) -> ColorImage {
    let size = buffer.size();
    let mut pixels = Vec::with_capacity(size * size);
    // Cells side by side mostly see the same patch.
    let mut last = (u32::MAX, Color32::BLACK);
    for y in 0..size {
        for x in 0..size {
            pixels.push(match buffer.cell(x, y) {
                None => Color32::TRANSPARENT,
                Some(cell) => match cell.patch {
                    None => theme::BACKDROP,
                    Some(patch) => {
                        if last.0 != patch {
                            let [r, g, b] =
                                colour(patch).map(|c| (255.0 * srgb_encode(c.clamp(0.0, 1.0))).round() as u8);
                            last = (patch, Color32::from_rgb(r, g, b));
                        }
                        last.1
                    }
                },
            });
        }
    }
    ColorImage::new([size, size], pixels)
}
