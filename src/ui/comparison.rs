//! The light kept as state A, and the divider between it and the present light.

use super::app::App;
use super::theme;
use crate::scene::Lighting;
use crate::solver::{LightBases, PatchLight};
use egui::{Align2, Color32, CursorIcon, FontId, Key, Pos2, Rect, Sense, Vec2};
use std::sync::Arc;

/// How near the divider comes to the edges of the view, as a share of its width.
const MARGIN: f32 = 0.04;
/// How far the arrow keys move it, as a share of the width.
const KEY_STEP: f32 = 0.02;
/// Width in which the divider is caught, points.
const CATCH: f32 = 14.0;

/// A state of the lamps to compare with.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// Of the mesh that it belongs to.
    pub(super) mesh_serial: u64,
    pub(super) lighting: Lighting,
    reflectance: Arc<Vec<[f32; 3]>>,
    pub(super) light: PatchLight,
}

impl Kept {
    pub(super) fn new(
        mesh_serial: u64,
        lighting: Lighting,
        reflectance: Arc<Vec<[f32; 3]>>,
        light: PatchLight,
    ) -> Self {
        Self { mesh_serial, lighting, reflectance, light }
    }

    /// Takes over a solution that has gone on since, so that what differs is the lamps alone. A light
    /// under other reflectances stays as it was.
    pub(super) fn settle(
        &mut self,
        bases: &LightBases,
        mesh: &crate::mesh::PatchMesh,
        reflectance: &Arc<Vec<[f32; 3]>>,
    ) {
        if Arc::ptr_eq(&self.reflectance, reflectance) || self.reflectance == *reflectance {
            self.light = bases.mix(mesh, &self.lighting, reflectance);
        }
    }
}

impl App {
    /// Where the present light begins, as a share of the view's width; `None` unless A is shown beside
    /// it.
    pub(super) fn split(&self) -> Option<f32> {
        let display = &self.edits.display;
        (display.split && display.quantity.can_split() && self.picture.has_comparison())
            .then_some(self.divider)
    }

    /// Draws the divider with the names of both sides, and moves it.
    pub(super) fn show_divider(&mut self, ui: &egui::Ui, view: Rect) {
        let Some(split) = self.split() else { return };
        let x = view.left() + split * view.width();
        let catch = Rect::from_center_size(Pos2::new(x, view.center().y), Vec2::new(CATCH, view.height()));
        let response = ui
            .interact(catch, ui.scope_id().with("divider"), Sense::click_and_drag())
            .on_hover_cursor(CursorIcon::ResizeHorizontal);
        let label = "Divider between A and now";
        response.widget_info(|| egui::WidgetInfo::slider(true, f64::from(100.0 * split), label));
        let mut to = split;
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            to = (pointer.x - view.left()) / view.width().max(1.0);
        }
        if response.has_focus() {
            let pressed = |key| f32::from(u8::from(ui.input(|i| i.key_pressed(key))));
            to += KEY_STEP * (pressed(Key::ArrowRight) - pressed(Key::ArrowLeft));
        }
        let to = to.clamp(MARGIN, 1.0 - MARGIN);
        if to != self.divider {
            self.divider = to;
            ui.ctx().request_repaint();
        }
        let active = response.hovered() || response.dragged() || response.has_focus();
        paint(ui, view, x, active);
    }
}

fn paint(ui: &egui::Ui, view: Rect, x: f32, active: bool) {
    let painter = ui.painter_at(view);
    let colour = if active { theme::ACCENT } else { Color32::from_gray(235) };
    painter.vline(x, view.y_range(), (3.0, Color32::from_black_alpha(120)));
    painter.vline(x, view.y_range(), (1.5, colour));
    let grip = Rect::from_center_size(Pos2::new(x, view.center().y), Vec2::new(9.0, 34.0));
    painter.rect_filled(grip, 4.5, colour);
    for y in [-5.0, 0.0, 5.0] {
        let at = grip.center().y + y;
        painter.hline(x - 2.0..=x + 2.0, at, (1.0, Color32::from_gray(40)));
    }
    let font = FontId::proportional(13.0);
    for (text, align, at) in [("A", Align2::RIGHT_BOTTOM, -10.0), ("Now", Align2::LEFT_BOTTOM, 10.0)] {
        let galley = painter.layout_no_wrap(text.to_owned(), font.clone(), theme::TEXT);
        let size = galley.size() + Vec2::new(14.0, 6.0);
        let ground = align.anchor_size(Pos2::new(x + at, view.bottom() - 14.0), size);
        painter.rect_filled(ground, 4.0, Color32::from_black_alpha(178));
        painter.galley(ground.min + Vec2::new(7.0, 3.0), galley, theme::TEXT);
    }
}
