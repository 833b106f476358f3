//! How the picture is made from the light.

use super::solver::combo;
use super::{Commands, Model};
use crate::display::ToneMap;
use crate::ui::command::Command;
use crate::ui::state::{Quantity, ShadingMode};
use crate::ui::{theme, units};
use egui::{Button, DragValue, RichText, Slider};

/// Shows the choices.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let now = model.edits.display;
    let mut new = now;
    combo(ui, "Show", now.quantity.name(), |ui| {
        for quantity in Quantity::ALL {
            let enabled = (quantity != Quantity::Difference || model.has_comparison)
                && (!quantity.is_row() || model.inspected.is_some());
            let choice = Button::selectable(now.quantity == quantity, quantity.name());
            let mut shown = ui.add_enabled(enabled, choice);
            if !quantity.explanation().is_empty() {
                shown = shown.on_hover_text(quantity.explanation());
            }
            if shown.clicked() {
                new = new.showing(quantity);
            }
        }
    });
    ui.horizontal(|ui| {
        ui.label(RichText::new("Shading").color(theme::TEXT_WEAK));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (mode, label, tip) in [
                (ShadingMode::Flat, "Flat", "One radiosity per patch (G)"),
                (ShadingMode::Smooth, "Smooth", "Interpolated between vertices, never across creases (G)"),
            ] {
                if ui.add(Button::selectable(now.shading == mode, label)).on_hover_text(tip).clicked() {
                    new.shading = mode;
                }
            }
        });
    });
    if now.quantity == Quantity::Picture {
        exposure(ui, model, &mut new);
    } else if now.quantity.is_scalar() {
        range(ui, model, &mut new);
    }
    ui.checkbox(&mut new.wireframe, "Patch borders").on_hover_text("Lines around patches (M)");
    ui.checkbox(&mut new.show_unlit, "Sides without patches").on_hover_text(
        "Draw the sides that light cannot reach, in dark grey; otherwise one looks through them",
    );
    ui.checkbox(&mut new.readout, "Numbers under the cursor");
    theme::group_title(ui, "Comparison");
    ui.horizontal(|ui| {
        if ui.button("Store as A").on_hover_text("Keep the present light to compare with").clicked() {
            out.push(Command::StoreComparison);
        }
        let split = Button::selectable(now.split && model.has_comparison, "A | Now");
        if ui
            .add_enabled(model.has_comparison, split)
            .on_hover_text("A on the left of a divider, the light now on the right (C)")
            .accessible_name("Show A beside now")
            .clicked()
        {
            new.split = !now.split;
            if new.split && !now.quantity.can_split() {
                new = new.showing(Quantity::Picture);
            }
        }
        let difference = now.quantity == Quantity::Difference;
        let button = Button::selectable(difference, "Now - A");
        if ui
            .add_enabled(model.has_comparison, button)
            .on_hover_text("Illuminance now less that of A, in lux")
            .accessible_name("Show difference to A")
            .clicked()
        {
            new = new.showing(if difference { Quantity::Picture } else { Quantity::Difference });
        }
    });
    if new != now {
        out.push(Command::SetDisplay(new));
    }
}

fn exposure(ui: &mut egui::Ui, model: &Model<'_>, new: &mut crate::ui::state::DisplaySettings) {
    ui.horizontal(|ui| {
        let before = new.auto_exposure;
        ui.checkbox(&mut new.auto_exposure, "Automatic exposure")
            .on_hover_text("Follows what is in view, and half-way the lamps, as eyes do");
        if before && !new.auto_exposure {
            // By hand starts from what is seen.
            new.ev = (model.ev * 10.0).round() / 10.0;
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.label(RichText::new(format!("{:.1} EV", model.ev)).color(theme::TEXT_WEAK));
        });
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = 96.0;
        if new.auto_exposure {
            let label = ui.label(RichText::new("Brighter by").color(theme::TEXT_WEAK));
            let slider = Slider::new(&mut new.compensation, -4.0..=4.0).suffix(" stops").fixed_decimals(1);
            ui.add(slider).labelled_by(label.id);
        } else {
            let label = ui.label(RichText::new("Exposure").color(theme::TEXT_WEAK));
            let slider = Slider::new(&mut new.ev, -6.0..=18.0).suffix(" EV").fixed_decimals(1);
            ui.add(slider)
                .labelled_by(label.id)
                .on_hover_text("Exposure value at ISO 100; lower is brighter");
        }
    });
    ui.checkbox(&mut new.white_balance, "Adapt to the lamps' colour").on_hover_text(
        "As eyes do: warm lamps look less orange. Numbers and saved radiance stay as they are",
    );
    combo(ui, "Tone map", new.tone_map.name(), |ui| {
        for map in ToneMap::ALL {
            ui.selectable_value(&mut new.tone_map, map, map.name());
        }
    });
}

fn range(ui: &mut egui::Ui, model: &Model<'_>, new: &mut crate::ui::state::DisplaySettings) {
    let in_force = model.scale.map_or([0.0, 1.0], |scale| scale.effective_range());
    let unit = new.quantity.unit();
    let mut pinned = new.range.is_some();
    ui.horizontal(|ui| {
        if ui
            .checkbox(&mut pinned, "Pin range")
            .on_hover_text("Keep these ends while the light changes")
            .changed()
        {
            new.range = pinned.then_some(in_force);
        }
        if !new.quantity.is_signed() {
            ui.checkbox(&mut new.logarithmic, "Logarithmic");
        }
    });
    ui.horizontal(|ui| {
        let mut ends = in_force;
        let speed = ((ends[1] - ends[0]).abs() * 0.005).max(1e-6);
        let formatted = |value: f64, _: std::ops::RangeInclusive<usize>| units::digits(value);
        for (end, name) in ends.iter_mut().zip(["Lower end", "Upper end"]) {
            let drag =
                DragValue::new(end).speed(speed).custom_formatter(formatted).suffix(format!(" {unit}"));
            // egui would call it after its unit.
            ui.add(drag).on_hover_text("Drag or type: this pins the range").accessible_name(name);
        }
        // Whoever sets an end wants it to stay.
        if ends != in_force && ends[0] < ends[1] {
            new.range = Some(ends);
        }
    });
}
