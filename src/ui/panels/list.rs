//! Lines of a list that are clicked as a whole, with cells that stand in columns.

use crate::ui::theme;
use egui::text::{LayoutJob, TextWrapping};
use egui::{Align, Align2, Color32, FontId, Rect, Response, Sense, Ui, Vec2};

/// Height of a line, points.
pub(super) const LINE: f32 = 18.0;

/// What stands in a column.
pub(super) struct Cell {
    /// Its width, points.
    pub(super) width: f32,
    /// The text; what does not fit ends in dots.
    pub(super) text: String,
    /// To which edge it keeps.
    pub(super) align: Align,
    /// Its colour.
    pub(super) colour: Color32,
}

impl Cell {
    /// A number: at the right edge.
    pub(super) fn number(width: f32, text: impl Into<String>) -> Self {
        Self { width, text: text.into(), align: Align::Max, colour: theme::TEXT }
    }

    /// A name: at the left edge.
    pub(super) fn name(width: f32, text: impl Into<String>) -> Self {
        Self { width, text: text.into(), align: Align::Min, colour: theme::TEXT }
    }

    /// The same, less prominent.
    pub(super) fn weak(self) -> Self {
        Self { colour: theme::TEXT_WEAK, ..self }
    }
}

/// Shows a line. `name` is what it is called where it cannot be seen.
pub(super) fn line(ui: &mut Ui, name: &str, selected: bool, cells: &[Cell]) -> Response {
    let width = cells.iter().map(|cell| cell.width).sum::<f32>().max(ui.available_width());
    let (rect, response) = ui.allocate_exact_size(Vec2::new(width, LINE), Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::accesskit::Role::Button, true, selected, name));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let visuals = ui.style().interact_selectable(&response, selected);
    if selected {
        ui.painter().rect_filled(rect, 3.0, theme::ACCENT_DIM);
    } else if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 3.0, visuals.weak_bg_fill);
    }
    paint_cells(ui, rect, cells);
    response
}

/// Draws cells from the left edge of `rect` on.
fn paint_cells(ui: &Ui, rect: Rect, cells: &[Cell]) {
    let mut left = rect.left();
    for cell in cells {
        let inner = Rect::from_x_y_ranges(left + 2.0..=left + cell.width - 4.0, rect.y_range());
        // What is too long ends in dots.
        let font = FontId::proportional(12.0);
        let mut job = LayoutJob::simple_singleline(cell.text.clone(), font, cell.colour);
        job.wrap = TextWrapping::truncate_at_width(inner.width());
        let galley = ui.painter().layout_job(job);
        let (anchor, at) = match cell.align {
            Align::Max => (Align2::RIGHT_CENTER, inner.right_center()),
            _ => (Align2::LEFT_CENTER, inner.left_center()),
        };
        let corner = anchor.anchor_size(at, galley.size()).min;
        ui.painter().galley(corner, galley, cell.colour);
        left += cell.width;
    }
}

/// The head of a column that sorts by it when clicked; an arrow tells by which one is sorted.
pub(super) fn head(ui: &mut Ui, width: f32, title: &str, sorted: Option<bool>) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::new(width, LINE), Sense::click());
    let name = format!("Sort by {title}");
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::accesskit::Role::Button, true, sorted.is_some(), &name)
    });
    if response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 3.0, ui.visuals().widgets.hovered.weak_bg_fill);
    }
    let colour = if sorted.is_some() { theme::ACCENT } else { theme::TEXT_WEAK };
    let text = ui.painter().text(
        rect.right_center() - Vec2::new(4.0, 0.0),
        Align2::RIGHT_CENTER,
        title,
        FontId::proportional(11.5),
        colour,
    );
    if let Some(falling) = sorted {
        let (x, y) = (text.left() - 7.0, rect.center().y);
        let tip = if falling { 2.5 } else { -2.5 };
        let points = [egui::pos2(x - 3.0, y - tip), egui::pos2(x + 3.0, y - tip), egui::pos2(x, y + tip)];
        ui.painter().add(egui::Shape::convex_polygon(points.to_vec(), colour, egui::Stroke::NONE));
    }
    response
}
