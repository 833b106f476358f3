//! The row of form factors of the patch looked into: its sums, its largest entries, its neighbours.

use super::list::{Cell, line};
use super::{Commands, Model, empty};
use crate::mesh::{Contact, NO_PATCH};
use crate::scene::illuminance;
use crate::ui::command::Command;
use crate::ui::microscope::Inspection;
use crate::ui::state::Quantity;
use crate::ui::{theme, units};
use egui::{Align, Button, Layout};

/// The switch that puts the row onto the scene, and as what it is shown there.
pub(super) fn switch(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let display = model.edits.display;
    let shown = display.quantity.is_row();
    ui.horizontal(|ui| {
        let button = Button::selectable(shown, "Row on the scene").frame_when_inactive(true);
        let tip = "Form factors from this patch to all others as false colours (R)";
        if ui.add(button).on_hover_text(tip).clicked() {
            out.push(Command::ToggleRow);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            for (quantity, label) in Quantity::ROW.into_iter().zip(["F/area", "F", "light"]).rev() {
                let button = Button::selectable(display.quantity == quantity, label);
                let choice = ui.add_enabled(shown, button).on_hover_text(quantity.explanation());
                if choice.accessible_name(quantity.name()).clicked() {
                    out.push(Command::SetDisplay(display.showing(quantity)));
                }
            }
        });
    });
}

/// Sums of the row and how well it was sampled.
pub(super) fn numbers(ui: &mut egui::Ui, model: &Model<'_>, inspection: &Inspection, out: &mut Commands) {
    let percent = |share: f64| format!("{} %", units::digits(100.0 * share));
    // Rounding of single precision is no sky.
    let escapes = if (1.0 - inspection.row_sum).abs() < 1e-6 { 0.0 } else { 1.0 - inspection.row_sum };
    let source = if inspection.balanced { "balanced" } else { "as sampled" };
    theme::row(ui, &format!("Row sum, {source}"), format!("{:.6}", inspection.row_sum));
    theme::row(
        ui,
        "Escapes",
        if inspection.row.is_empty() { "- (sees nothing)".to_owned() } else { percent(escapes.max(0.0)) },
    );
    theme::row(ui, "Patches seen", units::count(inspection.row.len()));
    if let Some(quality) = inspection.quality {
        theme::row(ui, "Row sum as sampled", format!("{:.6}", quality.sampled_sum.max(0.0)));
        theme::row(ui, "Reciprocity, all pairs", percent(f64::from(quality.mean_reciprocity))).on_hover_text(
            "Sum of |A_i F_ij - A_j F_ji| as sampled over the sum of their means, before balancing",
        );
        let gap = percent(f64::from(quality.worst_reciprocity));
        let pair = units::digits(100.0 * f64::from(quality.worst_pair_gap));
        theme::row(ui, "F in dispute at most", gap).on_hover_text(format!(
            "The largest |A_i F_ij - A_j F_ji| of the row over A_i; the two samples differ by {pair} % of their mean",
        ));
        if quality.worst_partner != NO_PATCH {
            entry(ui, model, quality.worst_partner, "the other of that pair", &[], out);
        }
    }
    let at = |quantity| {
        let values = model.microscope.maps().map(|maps| maps.of(quantity));
        values.and_then(|v| v.get(inspection.patch as usize)).map(|&v| f64::from(v))
    };
    if let Some(residual) = at(Quantity::Residual) {
        theme::row(ui, "Residual", format!("{} cd/m²", units::digits(residual)))
            .on_hover_text(Quantity::Residual.explanation());
    }
    if let Some(unshot) = at(Quantity::Unshot) {
        theme::row(ui, "Unshot power", format!("{} lm", units::digits(unshot)))
            .on_hover_text(Quantity::Unshot.explanation());
    }
}

/// The entries of the row that matter most to the patch.
pub(super) fn largest(ui: &mut egui::Ui, model: &Model<'_>, inspection: &Inspection, out: &mut Commands) {
    let entries = inspection.largest(model.light);
    if entries.is_empty() {
        empty(ui, "It sees no patch.");
        return;
    }
    heads(ui, &["F", "of its light"]);
    for (patch, f, share) in entries {
        let cells = [units::digits(f), format!("{} %", units::digits(100.0 * share))];
        entry(ui, model, patch, "", &cells, out);
    }
}

/// The patches around it.
pub(super) fn neighbours(ui: &mut egui::Ui, model: &Model<'_>, inspection: &Inspection, out: &mut Commands) {
    if inspection.neighbours.is_empty() {
        empty(ui, "None: it touches no other patch.");
        return;
    }
    heads(ui, &["lx", "F"]);
    for &(patch, contact, f) in &inspection.neighbours {
        let h = model.light.irradiance.get(patch as usize).copied().unwrap_or_default();
        let cells = [units::digits(illuminance(h.map(f64::from))), units::digits(f)];
        let touches = match contact {
            Contact::Vertex => "corner",
            Contact::Edge => "edge",
            Contact::Crease => "over crease",
        };
        entry(ui, model, patch, touches, &cells, out);
    }
}

/// Width of a column of numbers, points.
const NUMBER: f32 = 66.0;

fn heads(ui: &mut egui::Ui, titles: &[&str]) {
    let left = ui.available_width() - NUMBER * titles.len() as f32;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.add_space(left);
        for title in titles {
            let (rect, _) = ui.allocate_exact_size(egui::Vec2::new(NUMBER, 14.0), egui::Sense::hover());
            let at = rect.right_center() - egui::Vec2::new(4.0, 0.0);
            let font = egui::FontId::proportional(11.0);
            ui.painter().text(at, egui::Align2::RIGHT_CENTER, title, font, theme::TEXT_WEAK);
        }
    });
}

/// A patch with its material and some numbers; a click looks into it.
fn entry(
    ui: &mut egui::Ui,
    model: &Model<'_>,
    patch: u32,
    note: &str,
    numbers: &[String],
    out: &mut Commands,
) {
    let material = model
        .mesh
        .and_then(|mesh| mesh.patches.get(patch as usize))
        .and_then(|p| model.scene?.materials.get(p.material as usize))
        .map_or("", |m| m.name.as_str());
    let beside = if note.is_empty() { material } else { note };
    let id = units::count(patch as usize);
    let left = ui.available_width() - NUMBER * numbers.len() as f32;
    let mut cells = vec![Cell::number(52.0, id), Cell::name((left - 52.0).max(0.0), beside).weak()];
    cells.extend(numbers.iter().map(|text| Cell::number(NUMBER, text.as_str())));
    let shown = line(ui, &format!("Look into patch {patch}"), false, &cells);
    if shown.on_hover_text(format!("Look into patch {patch} ({material})")).clicked() {
        out.push(Command::PickNext(patch));
    }
}
