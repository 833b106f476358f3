//! The lamps: a switch, a dimmer, solo and a colour each.

use super::{Commands, Model, colour_picker, empty};
use crate::scene::{LUMINOUS_EFFICACY, LampState, Luminaire, black_body, luminance_weighted};
use crate::ui::colour::{self, MAX_KELVIN, MIN_KELVIN};
use crate::ui::command::Command;
use crate::ui::{luminaires, theme, units};
use egui::{Align, Button, Layout, RichText, Slider, Vec2};

/// Shows all lamps of the scene.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let Some(scene) = model.scene else {
        super::no_scene(ui, model, "No scene is open.");
        return;
    };
    if scene.luminaires.is_empty() {
        empty(
            ui,
            "No material of this scene emits light (Ke). Edit > Add ceiling lamps hangs some in its rooms.",
        );
        return;
    }
    ui.horizontal(|ui| {
        if ui.button("All on").on_hover_text("Switch every lamp on").clicked() {
            out.push(Command::AllLamps(true));
        }
        if ui.button("All off").on_hover_text("Switch every lamp off (0)").clicked() {
            out.push(Command::AllLamps(false));
        }
        if ui.button("Reset lamps").on_hover_text("As the file has them").clicked() {
            out.push(Command::ResetLamps);
        }
    });
    ui.add_space(2.0);
    for (index, (luminaire, &state)) in scene.luminaires.iter().zip(&model.edits.lighting.lamps).enumerate() {
        let full_lumens = model.full_lumens.get(index).copied().unwrap_or(0.0);
        let outdoors = scene.outdoors.as_ref();
        let measure = match outdoors.map(|out| [out.sky, out.sun].map(|lamp| lamp as usize == index)) {
            Some([true, _]) => Measure::Outside,
            Some([_, true]) => Measure::FacingIt,
            _ => Measure::Flux,
        };
        let lamp = Lamp { index, luminaire, full_lumens, measure };
        ui.push_id(index, |ui| lamp_row(ui, model, lamp, state, out));
    }
}

fn lamp_row(ui: &mut egui::Ui, model: &Model<'_>, lamp: Lamp<'_>, state: LampState, out: &mut Commands) {
    let (index, name) = (lamp.index, &lamp.luminaire.name);
    let mut new = state;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        // The controls on the right keep their width; the name takes what is left.
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            colour_button(ui, lamp, state, &mut new);
            let solo = Button::new("S").selected(model.solo == Some(index)).min_size(Vec2::new(20.0, 18.0));
            if ui
                .add(solo)
                .on_hover_text("Solo: this lamp alone; once more brings the others back")
                .accessible_name(format!("Solo {name}"))
                .clicked()
            {
                out.push(Command::SoloLamp(index));
            }
            ui.spacing_mut().slider_width = 46.0;
            let mut percent = state.dimmer * 100.0;
            let slider = Slider::new(&mut percent, 0.0..=100.0).show_value(false);
            let dimmer = ui.add_enabled(state.on, slider).accessible_name(format!("Dim {name}"));
            let (amount, unit) = (units::digits(lamp.amount(state)), lamp.measure.unit());
            let dimmer = dimmer.on_hover_text(format!("{percent:.0} %  -  {amount} {unit}"));
            if dimmer.changed() {
                new.dimmer = (percent / 100.0).clamp(0.0, 1.0);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(ui.available_width());
                let text = RichText::new(name).color(if state.on { theme::TEXT } else { theme::TEXT_WEAK });
                let key = if index < 9 { format!("{name}  (key {})", index + 1) } else { name.clone() };
                ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Truncate);
                // The tick is what is lit.
                ui.visuals_mut().widgets.inactive.fg_stroke.color = theme::ACCENT;
                ui.visuals_mut().widgets.hovered.fg_stroke.color = theme::ACCENT;
                ui.checkbox(&mut new.on, text).on_hover_text(key);
            });
        });
    });
    if new != state {
        out.push(Command::SetLamp(index, new));
    }
}

/// How the light of a lamp is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Measure {
    /// Lumens.
    Flux,
    /// Of the sky: lux on an unobstructed horizontal surface.
    Outside,
    /// Of the sun: lux on a surface that faces it.
    FacingIt,
}

impl Measure {
    fn unit(self) -> &'static str {
        match self {
            Self::Flux => "lm",
            Self::Outside => "lx outside",
            Self::FacingIt => "lx facing it",
        }
    }

    /// What a screen reader calls the amount.
    fn name(self) -> &'static str {
        if self == Self::Flux { "Lumens" } else { "Lux" }
    }
}

/// A lamp of the scene and its luminous flux at full output as it comes with the file, lm.
#[derive(Clone, Copy)]
struct Lamp<'a> {
    /// Index into the scene's luminaires.
    index: usize,
    luminaire: &'a Luminaire,
    full_lumens: f64,
    measure: Measure,
}

impl Lamp<'_> {
    /// Light as switched and dimmed: luminous flux in lm, or lux for sky and sun.
    fn amount(&self, state: LampState) -> f64 {
        let initial = luminance_weighted(self.luminaire.initial.exitance);
        let now = luminance_weighted(state.output());
        match self.measure {
            Measure::Flux if initial > 0.0 => self.full_lumens * now / initial,
            Measure::Flux => LUMINOUS_EFFICACY * now * self.luminaire.area,
            Measure::Outside | Measure::FacingIt => LUMINOUS_EFFICACY * now,
        }
    }
}

fn colour_button(ui: &mut egui::Ui, lamp: Lamp<'_>, state: LampState, new: &mut LampState) {
    let (_, hue) = colour::split(state.exitance);
    let name = format!("Colour of {}", lamp.luminaire.name);
    let tip = if lamp.luminaire.photometric.is_some() {
        "Colour, output and distribution"
    } else {
        "Colour and output"
    };
    super::swatch(ui, colour::to_bytes(hue), name, tip, |ui| {
        colour_menu(ui, lamp, state, new);
        if let Some(light) = &lamp.luminaire.photometric {
            super::polar::show(ui, &lamp.luminaire.name, light);
            luminaires::look_at(ui.ctx(), lamp.index);
        }
    });
}

fn colour_menu(ui: &mut egui::Ui, lamp: Lamp<'_>, state: LampState, new: &mut LampState) {
    let name = &lamp.luminaire.name;
    ui.label(RichText::new(name).strong());
    let kelvin = colour::nearest_kelvin(state.exitance);
    // Rounded as shown: the slider must not take its own rounding for a wish.
    let shown = kelvin.unwrap_or(4000.0).round();
    let mut chosen = shown;
    ui.horizontal(|ui| {
        ui.label("Temperature");
        let slider = Slider::new(&mut chosen, MIN_KELVIN..=MAX_KELVIN)
            .logarithmic(true)
            // A colour that is no white has no temperature to show.
            .custom_formatter(|value, _| match kelvin {
                None if value == shown => "-".to_owned(),
                _ => format!("{value:.0} K"),
            })
            .custom_parser(|text| text.trim_end_matches(['K', 'k', ' ']).trim().parse().ok())
            .fixed_decimals(0);
        if ui.name_inputs(format!("Colour temperature of {name}"), |ui| ui.add(slider)).changed()
            && chosen != shown
        {
            new.exitance = colour::recoloured(state.exitance, black_body(chosen));
        }
    });
    ui.horizontal(|ui| {
        for (label, kelvin) in [("Candle", 1900.0), ("Warm", 2700.0), ("Neutral", 4000.0), ("Day", 6500.0)] {
            if ui.button(label).on_hover_text(format!("{kelvin:.0} K")).clicked() {
                new.exitance = colour::recoloured(state.exitance, black_body(kelvin));
            }
        }
    });
    if let Some(chosen) = colour_picker::show(ui, name, state.exitance) {
        new.exitance = colour::recoloured(state.exitance, chosen);
    }
    // Kept in its place, so that nothing moves under the cursor.
    let told = if kelvin.is_none() { "Not on the scale of white light" } else { " " };
    ui.label(RichText::new(told).small().color(theme::TEXT_WEAK));
    ui.horizontal(|ui| {
        ui.label("Full output");
        let full = LampState { on: true, dimmer: 1.0, ..state };
        let before = lamp.amount(full);
        let shown = before.round();
        let mut wanted = shown;
        let drag = egui::DragValue::new(&mut wanted)
            .range(0.0..=1e7)
            .speed((before * 0.01).max(0.1))
            .suffix(format!(" {}", lamp.measure.unit()))
            .max_decimals(0);
        let drag = ui.add(drag).accessible_name(format!("{} of {name}", lamp.measure.name()));
        if drag.changed() && wanted != shown {
            new.exitance = if before > 0.0 {
                state.exitance.map(|e| e * (wanted / before).max(1e-6))
            } else {
                // A square metre for sky and sun, so that this is lux.
                [wanted / (LUMINOUS_EFFICACY * lamp.luminaire.area.max(1e-9)); 3]
            };
        }
    });
    ui.horizontal(|ui| {
        if ui.button("As the file has it").clicked() {
            new.exitance = lamp.luminaire.initial.exitance;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_text;

    #[test]
    fn sky_and_sun_are_told_in_lux() {
        let obj = "v 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nf 1 2 3 4\n";
        let sidecar = "[daylight]\nsun = [35, 150]\nlux = [75000, 12000]\n";
        let scene = from_text("floor", obj, "", Some(sidecar)).unwrap();
        let told = |index: usize, measure: Measure| {
            let luminaire = &scene.luminaires[index];
            let lamp = Lamp { index: 0, luminaire, full_lumens: 0.0, measure };
            let dimmed = LampState { dimmer: 0.5, ..luminaire.initial };
            [luminaire.initial, dimmed]
                .map(|state| format!("{} {}", units::digits(lamp.amount(state)), measure.unit()))
        };
        assert_eq!(told(0, Measure::Outside), ["12,000 lx outside", "6,000 lx outside"]);
        assert_eq!(told(1, Measure::FacingIt), ["75,000 lx facing it", "37,500 lx facing it"]);
    }
}
