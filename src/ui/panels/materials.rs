//! Reflectance and colour of every material; each edit solves again over the stored rows.

use super::{Commands, Model, colour_picker, empty};
use crate::scene::{MAX_REFLECTANCE, luminance_weighted};
use crate::ui::colour;
use crate::ui::command::Command;
use crate::ui::theme;
use egui::{Align, DragValue, Layout, RichText, Slider};

/// Shows all materials of the scene.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let Some(scene) = model.scene else {
        empty(ui, "No scene is open.");
        return;
    };
    let edited = model.edits.reflectance.iter().any(Option::is_some);
    if ui
        .add_enabled(edited, egui::Button::new("Reset materials"))
        .on_hover_text("As the file has them")
        .clicked()
    {
        out.push(Command::ResetMaterials);
    }
    for (index, material) in scene.materials.iter().enumerate() {
        let edit = model.edits.reflectance.get(index).copied().flatten();
        let now = edit.unwrap_or(material.reflectance);
        ui.push_id(index, |ui| {
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 5.0;
                let mut new = None;
                let name = &material.name;
                let label = format!("Colour of {name}");
                super::swatch(ui, colour::to_bytes(now), label, "Colour of the reflectance", |ui| {
                    new = colour_menu(ui, name, now, material.reflectance);
                });
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    // Rounded as shown: the slider must not take its own rounding for a wish.
                    let shown = (luminance_weighted(now) * 100.0).round() / 100.0;
                    let mut rho = shown;
                    let slider = Slider::new(&mut rho, 0.0..=MAX_REFLECTANCE).fixed_decimals(2);
                    let size = egui::vec2(116.0, ui.spacing().interact_size.y);
                    let left_to_right = Layout::left_to_right(Align::Center);
                    let slider = ui.allocate_ui_with_layout(size, left_to_right, |ui| {
                        ui.spacing_mut().slider_width = 66.0;
                        ui.name_inputs(format!("Reflectance of {name}"), |ui| ui.add(slider))
                    });
                    if slider.inner.changed() && rho != shown {
                        new = Some(scaled(now, rho));
                    }
                    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                        let text = RichText::new(name).color(if edit.is_some() {
                            theme::ACCENT
                        } else {
                            theme::TEXT
                        });
                        let label = ui.add(egui::Label::new(text).truncate());
                        label.on_hover_text(
                            match material.texture.and_then(|t| scene.textures.get(t as usize)) {
                                Some(texture) => format!("{name}: factor of the texture {}", texture.name),
                                None => format!(
                                    "{name}: diffuse reflectance {:.2} {:.2} {:.2}",
                                    now[0], now[1], now[2]
                                ),
                            },
                        );
                    });
                });
                if let Some(new) = new {
                    let new = new.map(|c| c.clamp(0.0, MAX_REFLECTANCE));
                    let is_edited = new != material.reflectance;
                    out.push(Command::SetReflectance(index, is_edited.then_some(new)));
                }
            });
        });
    }
}

/// Hue, saturation and the bands of a reflectance; the one that is chosen, if it is another.
fn colour_menu(ui: &mut egui::Ui, name: &str, now: [f64; 3], of_the_file: [f64; 3]) -> Option<[f64; 3]> {
    ui.label(RichText::new(name).strong());
    // Another colour is as bright as the one before it.
    let picked = colour_picker::show(ui, name, now);
    let mut new = picked.map(|picked| scaled(picked, luminance_weighted(now)));
    ui.horizontal(|ui| {
        ui.label("Reflectance");
        for (band, letter) in ["R", "G", "B"].into_iter().enumerate() {
            // Rounded as shown, as below.
            let shown = (now[band] * 1000.0).round() / 1000.0;
            let mut wanted = shown;
            let drag = DragValue::new(&mut wanted)
                .range(0.0..=MAX_REFLECTANCE)
                .speed(0.002)
                .fixed_decimals(3)
                .prefix(format!("{letter} "));
            let drag = ui.add(drag).accessible_name(format!("{letter} of {name}"));
            if drag.on_hover_text("Share of the light that is reflected in this band").changed()
                && wanted != shown
            {
                let mut edited = now;
                edited[band] = wanted;
                new = Some(edited);
            }
        }
    });
    ui.horizontal(|ui| {
        if ui.button("As the file has it").clicked() {
            new = Some(of_the_file);
        }
    });
    new
}

/// `reflectance` in the same hue with the luminance `rho`, as far as no band passes the maximum.
fn scaled(reflectance: [f64; 3], rho: f64) -> [f64; 3] {
    let before = luminance_weighted(reflectance);
    if before <= 1e-6 {
        return [rho; 3];
    }
    let peak = reflectance.into_iter().fold(0.0, f64::max);
    let factor = (rho / before).min(MAX_REFLECTANCE / peak);
    // Black must remember its hue, or the slider could not bring the colour back.
    reflectance.map(|c| c * factor.max(1e-4))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaling_keeps_the_hue_and_the_limit() {
        let half = scaled([0.8, 0.4, 0.2], 0.5 * luminance_weighted([0.8, 0.4, 0.2]));
        assert!((half[0] - 0.4).abs() < 1e-12 && (half[2] - 0.1).abs() < 1e-12);
        let most = scaled([0.8, 0.4, 0.2], 0.98);
        assert!((most[0] - MAX_REFLECTANCE).abs() < 1e-12 && (most[1] / most[0] - 0.5).abs() < 1e-12);
        assert_eq!(scaled([0.0; 3], 0.3), [0.3; 3]);
    }
}
