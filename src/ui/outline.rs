//! The border of the patch looked into, drawn over the picture: where something hides it, thinner.

use super::prepared::Prepared;
use super::theme;
use crate::geometry::Ray;
use crate::navigation::Camera;
use egui::{Color32, Pos2, Rect, Stroke};
use glam::DVec3;

/// Parts of each edge that are hidden or not as a whole.
const PARTS: usize = 4;

/// Draws the border of `patch` into `view`.
pub(super) fn show(ui: &egui::Ui, view: Rect, prepared: &Prepared, camera: &Camera, patch: u32) {
    let Some(own) = prepared.mesh.patches.get(patch as usize) else { return };
    let size_px = [view.width(), view.height()].map(|n| n.round().max(1.0) as u32);
    let on_screen = |point: DVec3| -> Option<Pos2> {
        let at = camera.project(point, size_px)?;
        Some(view.min + egui::vec2(at.x as f32, at.y as f32))
    };
    // Looked for a little inside of the border and off the surface, not where two walls meet.
    let lift = own.normal * (1e-4 * prepared.mesh.size);
    let seen = |point: DVec3| {
        let probe = point + (own.centre - point) * 0.02 + lift;
        let way = probe - camera.eye;
        let ray = Ray { origin: camera.eye, direction: way };
        own.normal.dot(way) < 0.0 && prepared.picker.pick(&ray).is_none_or(|pick| pick.distance > 0.999)
    };
    let (mut near, mut hidden) = (Vec::new(), Vec::new());
    for [a, b] in prepared.mesh.outline(patch) {
        for part in 0..PARTS {
            let at = |k: usize| a + (b - a) * (k as f64 / PARTS as f64);
            if let (Some(p), Some(q)) = (on_screen(at(part)), on_screen(at(part + 1))) {
                let list = if seen(0.5 * (at(part) + at(part + 1))) { &mut near } else { &mut hidden };
                list.push([p, q]);
            }
        }
    }
    let painter = ui.painter_at(view);
    for segment in hidden {
        painter.line_segment(segment, Stroke::new(1.0, theme::ACCENT.gamma_multiply(0.45)));
    }
    for (width, colour) in [(4.0, Color32::from_black_alpha(170)), (2.0, theme::ACCENT)] {
        for &segment in &near {
            painter.line_segment(segment, Stroke::new(width, colour));
        }
    }
}
