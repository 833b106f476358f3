//! Bookmarks and how one moves.

use super::{Commands, Model, empty};
use crate::ui::camera_control::Motion;
use crate::ui::command::Command;
use crate::ui::theme;
use egui::{Button, DragValue, Slider};

/// Shows bookmarks and the way of moving.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    ui.horizontal(|ui| {
        for (motion, label, tip) in [
            (Motion::Walk, "Walk", "On the floor, stopped by walls (F)"),
            (Motion::Fly, "Fly", "Freely, through everything (F)"),
        ] {
            if ui.add(Button::selectable(model.visit.motion == motion, label)).on_hover_text(tip).clicked() {
                out.push(Command::SetMotion(motion));
            }
        }
        let mut height = model.state.eye_height;
        let drag = DragValue::new(&mut height).range(0.5..=3.0).speed(0.01).fixed_decimals(2).suffix(" m");
        let drag = ui.add(drag).accessible_name("Eye height");
        if drag.on_hover_text("Eyes above the floor while walking").changed() {
            out.push(Command::SetEyeHeight(height));
        }
    });
    ui.horizontal(|ui| {
        let label = ui.label("Field of view");
        let shown = model.fov_deg.round();
        let mut fov = shown;
        let slider = Slider::new(&mut fov, 20.0..=110.0).suffix("°").fixed_decimals(0);
        if ui.add(slider).labelled_by(label.id).changed() && fov != shown {
            out.push(Command::SetFov(fov));
        }
    });
    theme::group_title(ui, "Bookmarks");
    if model.views.is_empty() {
        empty(ui, "None yet.");
    }
    for (index, view) in model.views.iter().enumerate() {
        ui.push_id(index, |ui| {
            let is_here = model.view_here == Some(index);
            let button = Button::selectable(is_here, &view.name).truncate();
            let shown = ui.add(button).on_hover_text("Go there; right click to rename or remove it");
            if shown.clicked() {
                out.push(Command::GoToView(index));
            }
            let draft = shown.id.with("name");
            let menu = egui::Popup::context_menu(&shown)
                .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside)
                .show(|ui| edit(ui, model, index, draft, out));
            if menu.is_none() {
                // What was typed and not wished for is forgotten.
                ui.data_mut(|d| d.remove::<String>(draft));
            }
        });
    }
    ui.horizontal(|ui| {
        if ui.button("Store view").on_hover_text("Keep this view as a bookmark (B)").clicked() {
            out.push(Command::StoreView);
        }
        let (text, tip) = match model.tour {
            Some(_) => ("Stop tour", "Stay here (T or Esc)"),
            None => ("Play tour", "Walk through all bookmarks (T)"),
        };
        let play = ui.add_enabled(model.can_tour, Button::new(text)).on_hover_text(tip);
        if play.on_disabled_hover_text("A tour needs two bookmarks at least").clicked() {
            out.push(Command::ToggleTour);
        }
        if ui.button("Start view").on_hover_text("Back to where one starts (Home)").clicked() {
            out.push(Command::Home);
        }
    });
}

/// The name of a bookmark to be changed, of which `id` keeps the draft, and its end.
fn edit(ui: &mut egui::Ui, model: &Model<'_>, index: usize, id: egui::Id, out: &mut Commands) {
    let Some(view) = model.views.get(index) else { return };
    theme::undo_menu_style(ui);
    ui.set_width(210.0);
    let begun = ui.data(|d| d.get_temp::<String>(id));
    let has_opened = begun.is_none();
    let mut name = begun.unwrap_or_else(|| view.name.clone());
    let field = ui.text_edit_singleline(&mut name).accessible_name("Name of the bookmark");
    if has_opened {
        field.request_focus();
    }
    let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
    let wanted = name.trim();
    let is_free = model.views.iter().enumerate().all(|(k, other)| k == index || other.name != wanted);
    let fits = !wanted.is_empty() && is_free;
    let (mut renamed, mut removed) = (false, false);
    ui.horizontal(|ui| {
        let rename = ui.add_enabled(fits && wanted != view.name, Button::new("Rename"));
        renamed = rename.on_disabled_hover_text("A name of its own, that no other bookmark has").clicked();
        let remove = ui.add_enabled(index != model.start_view, Button::new("Remove"));
        removed = remove.on_disabled_hover_text("The start view stays").clicked();
    });
    if (renamed || entered) && fits {
        out.push(Command::RenameView(index, wanted.to_owned()));
    }
    if removed {
        out.push(Command::RemoveView(index));
    }
    if renamed || entered || removed {
        ui.close();
    } else {
        ui.data_mut(|d| d.insert_temp(id, name));
    }
}
