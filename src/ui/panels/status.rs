//! The line at the bottom.

use super::Model;
use crate::ui::camera_control::Motion;
use crate::ui::{theme, units};
use egui::RichText;

/// Shows how one moves, what a frame costs, and what the last change recomputed.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>) {
    ui.horizontal(|ui| {
        let weak = |text: String| RichText::new(text).small().color(theme::TEXT_WEAK);
        ui.label(weak(match model.visit.motion {
            Motion::Walk => format!("walk  {:.2} m", model.state.eye_height),
            Motion::Fly => "fly".to_owned(),
        }));
        ui.separator();
        ui.label(weak(format!("{:.1} ms", model.frame_secs * 1e3))).on_hover_ui(|ui| {
            ui.label("Time of the program and the graphics driver for one frame.");
            let longest = units::duration(model.longest_secs);
            ui.label(format!("Longest work of the program alone for one frame of this scene: {longest}"));
        });
        if let Some(mesh) = model.mesh {
            ui.separator();
            // More than were asked for are explained where the number stands.
            let excess = mesh.statistics.excess();
            let mark = if excess.is_some() { " (why so many?)" } else { "" };
            let told = ui.label(weak(format!("{} patches{mark}", units::count(mesh.patches.len()))));
            let reasons: Vec<String> = excess.into_iter().chain(mesh.statistics.clustering()).collect();
            if !reasons.is_empty() {
                told.on_hover_text(reasons.join("\n"));
            }
        }
        if let Some(memory) = model.memory {
            ui.separator();
            ui.label(weak(units::bytes(memory)));
        }
        if !model.last_change.is_empty() {
            ui.separator();
            ui.add(egui::Label::new(weak(format!("last change: {}", model.last_change))).truncate());
        }
    });
}
