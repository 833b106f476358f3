//! What lies over the picture's corners: the hint, messages, numbers under the cursor.

use super::command::Command;
use super::panels::{Commands, Model};
use super::state::Quantity;
use super::{theme, units};
use crate::display::{NO_VALUE, luminance};
use crate::render::Pick;
use crate::scene::illuminance;
use crate::solver::PatchLight;
use egui::{Align2, Area, Color32, Id, Order, Rect, RichText, Vec2};

/// A message to the user.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notice {
    /// One sentence.
    pub(super) text: String,
    /// A failure stays until it is taken away.
    pub(super) is_error: bool,
    /// When it came, seconds of the window's clock.
    pub(super) since: f64,
}

/// Seconds for which a message that is no error stays.
pub(super) const NOTICE_SECS: f64 = 6.0;

fn corner(ui: &egui::Ui, name: &str, view: Rect, align: Align2, contents: impl FnOnce(&mut egui::Ui)) {
    let inner = view.shrink(12.0);
    Area::new(Id::unique(name))
        .order(Order::Middle)
        .fixed_pos(align.pos_in_rect(&inner))
        .pivot(align)
        .constrain_to(inner)
        .fade_in(false)
        .show(ui.ctx(), |ui| {
            theme::overlay().show(ui, |ui| {
                ui.set_max_width((inner.width() - 24.0).clamp(120.0, 560.0));
                contents(ui);
            });
        });
}

/// One line that tells how to walk and that lamps can be clicked.
pub(super) fn hint(ui: &egui::Ui, view: Rect) {
    corner(ui, "hint", view, Align2::CENTER_TOP, |ui| {
        ui.style_mut().interaction.selectable_labels = false;
        ui.label(
            RichText::new("W A S D and drag to walk  -  click a lamp to switch it  -  hover to read lux  -  F1 for more")
                .color(Color32::from_gray(235)),
        );
    });
}

/// Why nothing is seen where all lamps are off.
pub(super) fn dark(ui: &egui::Ui, view: Rect) {
    corner(ui, "dark", view, Align2::CENTER_TOP, |ui| {
        ui.style_mut().interaction.selectable_labels = false;
        let text = "All lamps are off  -  0 or a click on a lamp switches them on";
        ui.label(RichText::new(text).color(Color32::from_gray(235)));
    });
}

/// What the picture of a scene without lamps is: nobody is to take it for its light.
pub(super) fn even_light(ui: &egui::Ui, view: Rect) {
    corner(ui, "even light", view, Align2::RIGHT_BOTTOM, |ui| {
        ui.style_mut().interaction.selectable_labels = false;
        ui.label(RichText::new("Even light: no lamps").color(Color32::from_gray(235)));
    });
}

/// The present message, with a way to take it away.
pub(super) fn notice(ui: &egui::Ui, view: Rect, notice: &Notice, out: &mut Commands) {
    corner(ui, "notice", view, Align2::CENTER_TOP, |ui| {
        ui.horizontal(|ui| {
            // What went well needs no word in front.
            if notice.is_error {
                ui.label(RichText::new("Error").strong().color(theme::FAILURE));
            }
            ui.scope(|ui| {
                // Room for the button beside it.
                ui.set_max_width((ui.available_width() - 74.0).max(60.0));
                ui.add(egui::Label::new(RichText::new(&notice.text).color(Color32::from_gray(235))).wrap());
            });
            if ui.button("Dismiss").clicked() {
                out.push(Command::DismissMessage);
            }
        });
    });
}

/// Where a file may be dropped, while one is over the window.
pub(super) fn drop_target(ui: &egui::Ui, view: Rect) {
    let painter = ui.painter_at(view);
    painter.rect_filled(view, 0.0, Color32::from_black_alpha(150));
    let font = egui::FontId::proportional(20.0);
    painter.text(view.center(), Align2::CENTER_CENTER, "Drop a model to open it", font, theme::ACCENT);
}

/// What to say while there is no picture yet.
pub(super) fn waiting(ui: &egui::Ui, view: Rect, text: &str) {
    let font = egui::FontId::proportional(15.0);
    ui.painter_at(view).text(view.center(), Align2::CENTER_CENTER, text, font, theme::TEXT_WEAK);
}

/// How far a tour has come, and how it ends; that ways are looked for where it has no length yet, and
/// where none was found.
pub(super) fn tour(ui: &egui::Ui, view: Rect, [seconds, all]: [f64; 2], barred: Option<&str>) {
    corner(ui, "tour", view, Align2::CENTER_TOP, |ui| {
        ui.style_mut().interaction.selectable_labels = false;
        ui.horizontal(|ui| {
            ui.label(RichText::new("Tour").strong().color(theme::ACCENT));
            let wide = view.width() > 520.0;
            let bar = egui::ProgressBar::new((seconds / all.max(1e-9)).clamp(0.0, 1.0) as f32);
            let length = if wide { 150.0 } else { 70.0 };
            ui.add(bar.desired_width(length).desired_height(7.0).fill(theme::ACCENT));
            let how = if wide { "  -  move, click or Esc to stop" } else { "  -  Esc stops" };
            let far =
                if all > 0.0 { format!("{seconds:.0} of {all:.0} s") } else { "finding a way".to_owned() };
            let text = format!("{far}{how}");
            ui.label(RichText::new(text).color(Color32::from_gray(235)));
        });
        if let Some(barred) = barred {
            ui.label(RichText::new(barred).color(theme::WARNING));
        }
    });
}

/// The numbers of what lies under the cursor, in the lower left corner: of the light `kept` as A where
/// the cursor is on its side, else of the present one.
pub(super) fn readout(ui: &egui::Ui, view: Rect, model: &Model<'_>, pick: &Pick, kept: Option<&PatchLight>) {
    let light = kept.unwrap_or(model.light);
    let (Some(scene), Some(mesh)) = (model.scene, model.mesh) else { return };
    let Some((id, patch)) = pick.patch.and_then(|id| Some((id as usize, mesh.patches.get(id as usize)?)))
    else {
        return;
    };
    let (Some(irradiance), Some(radiosity)) = (light.irradiance.get(id), light.radiosity.get(id)) else {
        return;
    };
    let lux = units::light(illuminance(irradiance.map(f64::from)));
    let cd = units::light(luminance(*radiosity));
    // Materials of A may be others.
    let factor = model.daylight_factors.filter(|_| kept.is_none()).and_then(|factors| factors.get(id));
    let factor =
        factor.map_or_else(String::new, |factor| format!("     D {} %", units::digits(f64::from(*factor))));
    let rho = model.reflectance.get(id).copied().unwrap_or_default().map(f64::from);
    let material = scene.materials.get(patch.material as usize).map_or("", |m| m.name.as_str());
    let lamp = patch.luminaire.and_then(|l| scene.luminaires.get(l as usize));
    let what = match lamp {
        Some(lamp) => format!("{}  -  click to switch", shortened(&lamp.name, 36)),
        None => {
            let rho = crate::scene::luminance_weighted(rho);
            let passed = mesh.translucence.at(id).map_or_else(String::new, |passing| {
                format!("  -  passes {:.2}", crate::scene::luminance_weighted(passing.share))
            });
            format!("{}  -  reflectance {rho:.2}{passed}", shortened(material, 30))
        }
    };
    let distance = units::digits(pick.distance / scene.unit.metres());
    let b = radiosity.map(|x| units::digits(f64::from(x))).join(" ");
    let patch = format!("patch {}  -  B {b} W/m²  -  {distance} {}", units::count(id), scene.unit.symbol());
    let mut lines = vec![
        (
            format!("{}{lux} lx     {cd} cd/m²{factor}", if kept.is_some() { "A:  " } else { "" }),
            17.0,
            theme::TEXT,
        ),
        (what, 11.5, theme::TEXT),
        (patch, 11.5, theme::TEXT_WEAK),
    ];
    if let Some(text) = shown_value(model, id) {
        lines.insert(1, (text, 13.0, theme::ACCENT));
    }
    let painter = ui.painter_at(view);
    let galleys: Vec<_> = lines
        .into_iter()
        .map(|(text, size, colour)| {
            (painter.layout_no_wrap(text, egui::FontId::proportional(size), colour), colour)
        })
        .collect();
    let width = galleys.iter().map(|(galley, _)| galley.size().x).fold(0.0, f32::max);
    let height: f32 = galleys.iter().map(|(galley, _)| galley.size().y).sum();
    // A steady width: the ground must not jump with every number.
    let size = Vec2::new(width.max(290.0) + 20.0, height + 14.0);
    let ground = Rect::from_min_size(egui::pos2(view.left() + 12.0, view.bottom() - 12.0 - size.y), size);
    if !view.contains_rect(ground) {
        return;
    }
    painter.rect_filled(ground, 5.0, Color32::from_black_alpha(178));
    let mut at = ground.min + Vec2::new(10.0, 7.0);
    for (galley, colour) in galleys {
        let down = galley.size().y;
        painter.galley(at, galley, colour);
        at.y += down;
    }
}

/// The number behind the false colour of a patch, where it is none of those that are told anyway.
fn shown_value(model: &Model<'_>, patch: usize) -> Option<String> {
    let quantity = model.edits.display.quantity;
    let told = [Quantity::Illuminance, Quantity::Luminance, Quantity::DaylightFactor, Quantity::Sides];
    if told.contains(&quantity) {
        return None;
    }
    let value = *model.shown_values.get(patch)?;
    if quantity == Quantity::Error {
        return Some(estimated_error(model, patch, f64::from(value)));
    }
    if value <= NO_VALUE {
        return Some(format!("{}: not seen", quantity.name()));
    }
    Some(format!("{}: {} {}", quantity.name(), units::digits(f64::from(value)), quantity.unit()))
}

/// The estimated error of a patch in lux and in percent of the mean, and what rays found there.
fn estimated_error(model: &Model<'_>, patch: usize, percent: f64) -> String {
    let auditor = model.auditor;
    let Some(budget) = auditor.budget.filter(|_| percent > f64::from(NO_VALUE)) else {
        return "No error: it shines or lies under something".to_owned();
    };
    let lux = 0.01 * percent * crate::scene::LUMINOUS_EFFICACY * budget.mean_irradiance;
    let told =
        format!("Estimated error here {} lx ({} % of the mean)", units::digits(lux), units::digits(percent));
    match auditor.measured_lux(patch as u32) {
        Some(found) => {
            let sign = if found > 0.0 { "+" } else { "" };
            format!("{told}, by rays {sign}{} lx", units::digits(found))
        }
        None => told,
    }
}

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 3).chain("...".chars()).collect()
}
