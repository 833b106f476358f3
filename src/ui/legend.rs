//! The scale of a false-colour picture: a bar with round values and their unit.

use super::state::Quantity;
use super::{theme, units};
use crate::display::FalseColour;
use egui::{Align2, Color32, FontId, Pos2, Rect, Vec2};

const BAR: Vec2 = Vec2::new(14.0, 170.0);
const WIDTH: f32 = 112.0;
/// In a view that is narrower than this the bar is only so high: it must not cover the middle.
const NARROW: f32 = 560.0;
const LOW: f32 = 104.0;
const PAD: f32 = 10.0;
const TITLE: f32 = 20.0;

/// Draws the legend into the lower right corner of `view`.
pub(super) fn show(ui: &egui::Ui, view: Rect, quantity: Quantity, scale: &FalseColour) {
    let height = if view.width() < NARROW { LOW } else { BAR.y };
    let size = Vec2::new(WIDTH, height + 2.0 * PAD + TITLE);
    let ground = Rect::from_min_size(view.max - size - Vec2::splat(12.0), size);
    if !view.contains_rect(ground) {
        return;
    }
    let painter = ui.painter_at(view);
    painter.rect_filled(ground, 5.0, Color32::from_black_alpha(178));
    let title = match quantity.unit() {
        "" => short_name(quantity).to_owned(),
        unit => format!("{} [{unit}]", short_name(quantity)),
    };
    let font = FontId::proportional(11.0);
    painter.text(ground.min + Vec2::splat(PAD), Align2::LEFT_TOP, title, font.clone(), theme::TEXT);
    let bar = Rect::from_min_size(ground.min + Vec2::new(PAD, PAD + TITLE), Vec2::new(BAR.x, height));
    let steps = height as usize;
    for step in 0..steps {
        let position = 1.0 - (step as f64 + 0.5) / steps as f64;
        let [r, g, b] = scale.map.srgb(position).map(|c| (c * 255.0).round() as u8);
        let row = Rect::from_min_size(bar.min + Vec2::new(0.0, step as f32), Vec2::new(BAR.x, 1.5));
        painter.rect_filled(row, 0.0, Color32::from_rgb(r, g, b));
    }
    if quantity == Quantity::Sides {
        for (y, text) in [(bar.top(), "back"), (bar.bottom(), "front")] {
            painter.text(
                Pos2::new(bar.right() + 8.0, y),
                Align2::LEFT_CENTER,
                text,
                font.clone(),
                theme::TEXT,
            );
        }
        return;
    }
    for tick in scale.ticks(if height < BAR.y { 6 } else { 9 }) {
        let y = bar.bottom() - tick.position as f32 * height;
        painter.hline(bar.right()..=bar.right() + 4.0, y, (1.0, theme::TEXT));
        let at = Pos2::new(ground.right() - PAD, y);
        // Thousands apart, as in the panels.
        let label = tick.label.parse().map_or(tick.label, units::grouped);
        painter.text(at, Align2::RIGHT_CENTER, label, font.clone(), theme::TEXT);
    }
}

/// Says into the same corner why a map is not shown yet.
pub(super) fn pending(ui: &egui::Ui, view: Rect, quantity: Quantity, has_sky: bool) {
    let needs = match quantity {
        Quantity::Residual | Quantity::Unshot => "as soon as light arrives",
        Quantity::DaylightFactor if has_sky => "once the light has settled",
        Quantity::DaylightFactor => "under a sky: Daylight > Add daylight",
        Quantity::Error => "once the light has been checked",
        q if q.is_row() => "as soon as a patch is looked into",
        _ => "once all rows are there",
    };
    let painter = ui.painter_at(view);
    let text = format!("{} is shown {needs}", quantity.name());
    let galley = painter.layout_no_wrap(text, FontId::proportional(12.0), theme::TEXT);
    let size = galley.size() + Vec2::new(2.0 * PAD, PAD);
    let ground = Rect::from_min_size(view.max - size - Vec2::splat(12.0), size);
    if view.contains_rect(ground) {
        painter.rect_filled(ground, 5.0, Color32::from_black_alpha(178));
        painter.galley(ground.min + Vec2::new(PAD, 0.5 * PAD), galley, theme::TEXT);
    }
}

fn short_name(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Difference => "Now - A",
        Quantity::Area => "Area",
        Quantity::RowDensity => "F / area",
        Quantity::RowFactor => "Form factor F",
        Quantity::RowLight => "Light",
        Quantity::Escape => "Escapes",
        Quantity::Reciprocity => "Reciprocity",
        Quantity::Unshot => "Unshot",
        Quantity::Error => "Error of mean",
        other => other.name(),
    }
}
