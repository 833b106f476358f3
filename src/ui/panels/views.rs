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
            if ui.add(Button::selectable(model.state.motion == motion, label)).on_hover_text(tip).clicked() {
                out.push(Command::SetMotion(motion));
            }
        }
        let mut height = model.state.eye_height;
        let drag = DragValue::new(&mut height).range(0.5..=3.0).speed(0.01).fixed_decimals(2).suffix(" m");
        let drag = ui.name_inputs("Eye height", |ui| ui.add(drag));
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
            let button = Button::new(&view.name).frame_when_inactive(false).truncate();
            if ui.add(button).on_hover_text("Go there").clicked() {
                out.push(Command::GoToView(index));
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
