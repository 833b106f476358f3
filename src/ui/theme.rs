//! One visual language: neutral greys that do not bias the eye, one warm accent, one type scale.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Vec2};

/// What is lit or active.
pub(super) const ACCENT: Color32 = Color32::from_rgb(242, 169, 74);
/// The accent behind text.
pub(super) const ACCENT_DIM: Color32 = Color32::from_rgb(98, 70, 34);
/// Warnings; always with a word.
pub(super) const WARNING: Color32 = Color32::from_rgb(232, 190, 88);
/// Failures; always with a word.
pub(super) const FAILURE: Color32 = Color32::from_rgb(232, 104, 92);
/// Finished well.
pub(super) const DONE: Color32 = Color32::from_rgb(140, 190, 140);
/// Text that matters.
pub(super) const TEXT: Color32 = Color32::from_gray(216);
/// Text beside it.
pub(super) const TEXT_WEAK: Color32 = Color32::from_gray(150);
/// Text that stands where something will come.
pub(super) const TEXT_FAINT: Color32 = Color32::from_gray(104);
/// Lines of plots.
pub(super) const GRID: Color32 = Color32::from_gray(78);
/// Panels.
pub(super) const PANEL: Color32 = Color32::from_gray(31);
/// Behind the picture.
pub(super) const BACKDROP: Color32 = Color32::from_gray(20);

/// Width of a side panel, points.
pub(super) const PANEL_WIDTH: f32 = 276.0;

/// Dresses the whole window.
pub(super) fn apply(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional)),
            (TextStyle::Body, FontId::new(13.0, FontFamily::Proportional)),
            (TextStyle::Button, FontId::new(13.0, FontFamily::Proportional)),
            (TextStyle::Small, FontId::new(11.0, FontFamily::Proportional)),
            (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
        ]
        .into();
        let spacing = &mut style.spacing;
        spacing.item_spacing = Vec2::new(6.0, 5.0);
        spacing.button_padding = Vec2::new(7.0, 3.0);
        spacing.interact_size = Vec2::new(28.0, 20.0);
        spacing.slider_width = 110.0;
        spacing.indent = 12.0;
        spacing.menu_margin = Margin::same(6);
        spacing.window_margin = Margin::same(14);
        spacing.tooltip_width = 320.0;

        let visuals = &mut style.visuals;
        *visuals = egui::Visuals::dark();
        visuals.panel_fill = PANEL;
        visuals.window_fill = Color32::from_gray(36);
        visuals.window_stroke = Stroke::new(1.0, Color32::from_gray(62));
        visuals.extreme_bg_color = Color32::from_gray(22);
        visuals.faint_bg_color = Color32::from_gray(35);
        visuals.window_corner_radius = CornerRadius::same(6);
        visuals.menu_corner_radius = CornerRadius::same(5);
        visuals.selection.bg_fill = ACCENT_DIM;
        visuals.selection.stroke = Stroke::new(1.0, ACCENT);
        visuals.hyperlink_color = ACCENT;
        visuals.warn_fg_color = WARNING;
        visuals.error_fg_color = FAILURE;
        visuals.slider_trailing_fill = true;
        visuals.indent_has_left_vline = false;
        visuals.weak_text_color = Some(TEXT_WEAK);
        let widgets = &mut visuals.widgets;
        for (state, fill, text) in [
            (&mut widgets.noninteractive, 31, 205),
            (&mut widgets.inactive, 52, 212),
            (&mut widgets.hovered, 66, 240),
            (&mut widgets.active, 78, 255),
            (&mut widgets.open, 58, 230),
        ] {
            state.bg_fill = Color32::from_gray(fill);
            state.weak_bg_fill = Color32::from_gray(fill);
            state.fg_stroke = Stroke::new(1.0, Color32::from_gray(text));
            state.corner_radius = CornerRadius::same(4);
        }
        widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(48));
        widgets.hovered.bg_stroke = Stroke::new(1.0, Color32::from_gray(96));
        widgets.active.bg_stroke = Stroke::new(1.0, ACCENT);
    });
}

/// Spares panels the fill of their ground, for a window that is cleared to [`PANEL`]: on a software
/// adapter that fill costs more than the scene.
pub(super) fn leave_ground_to_the_clear(ctx: &egui::Context) {
    ctx.all_styles_mut(|style| style.visuals.panel_fill = Color32::TRANSPARENT);
}

/// The ground of what lies over the picture.
pub(super) fn overlay() -> egui::Frame {
    egui::Frame::new()
        .fill(Color32::from_black_alpha(178))
        .corner_radius(CornerRadius::same(5))
        .inner_margin(Margin::symmetric(9, 6))
}

/// Buttons inside a popup that is no list of items look like buttons again.
pub(super) fn undo_menu_style(ui: &mut egui::Ui) {
    let style = ui.ctx().style_of(egui::Theme::Dark);
    ui.visuals_mut().widgets = style.visuals.widgets.clone();
    ui.spacing_mut().button_padding = style.spacing.button_padding;
}

/// Small capitals above a group of controls.
pub(super) fn group_title(ui: &mut egui::Ui, text: &str) {
    ui.add_space(2.0);
    ui.label(egui::RichText::new(text).small().color(TEXT_WEAK));
}

/// A line with a name on the left and a value on the right.
pub(super) fn row(ui: &mut egui::Ui, name: &str, value: impl Into<String>) -> egui::Response {
    ui.horizontal(|ui| {
        ui.label(egui::RichText::new(name).color(TEXT_WEAK));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.add(egui::Label::new(egui::RichText::new(value.into()).color(TEXT)).truncate());
        });
    })
    .response
}

/// A plot to look at, of this height in points: the mouse does not move it.
pub(super) fn plot(name: &str, height: f32) -> egui_plot::Plot<'_> {
    egui_plot::Plot::new(name)
        .height(height)
        .show_crosshair(false)
        .grid_color(GRID)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
}
