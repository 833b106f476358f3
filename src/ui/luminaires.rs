//! How the luminaires of a lamp hang, drawn over the picture: their openings, where they shine, and C0.

use super::theme;
use crate::navigation::Camera;
use crate::scene::Scene;
use egui::{Align2, Color32, FontId, Id, Painter, Pos2, Rect, Stroke};
use glam::DVec3;

/// Luminaires of a lamp that are drawn at most.
const MOST: usize = 64;
/// Length of an axis, as a share of the distance from the eye.
const AXIS: f64 = 0.08;
const NADIR: Color32 = Color32::from_gray(235);

fn key() -> Id {
    Id::unique("lamp whose luminaires are looked at")
}

/// Has the luminaires of a lamp drawn in this frame and the next.
pub(super) fn look_at(ctx: &egui::Context, lamp: usize) {
    let frame = ctx.cumulative_pass_nr();
    ctx.data_mut(|data| data.insert_temp(key(), (lamp, frame)));
}

/// Draws those of the lamp that is looked at into `view`, whatever stands before them.
pub(super) fn show(ui: &egui::Ui, view: Rect, scene: &Scene, camera: &Camera) {
    let Some((lamp, frame)) = ui.data(|data| data.get_temp::<(usize, u64)>(key())) else { return };
    if frame + 1 < ui.ctx().cumulative_pass_nr() {
        return;
    }
    let size_px = [view.width(), view.height()].map(|n| n.round().max(1.0) as u32);
    let at = |point: DVec3| -> Option<Pos2> {
        let at = camera.project(point, size_px)?;
        Some(view.min + egui::vec2(at.x as f32, at.y as f32))
    };
    let painter = ui.painter_at(view);
    let sources = scene.photometric_sources();
    for source in sources.iter().filter(|source| source.luminaire as usize == lamp).take(MOST) {
        let (centre, frame) = (source.place.centre, source.place.frame);
        let length = AXIS * centre.distance(camera.eye);
        axis(&painter, [at(centre), at(centre - frame.normal * length)], NADIR, "");
        axis(&painter, [at(centre), at(centre + frame.tangent * length)], theme::ACCENT, "C0");
        for face in source.opening() {
            let outline: Option<Vec<Pos2>> = face.iter().map(|&corner| at(corner)).collect();
            if let Some(outline) = outline {
                painter.add(egui::Shape::closed_line(outline, Stroke::new(1.0, theme::ACCENT)));
            }
        }
    }
}

/// A line with a word at its end.
fn axis(painter: &Painter, ends: [Option<Pos2>; 2], colour: Color32, word: &str) {
    let [Some(from), Some(to)] = ends else { return };
    painter.line_segment([from, to], Stroke::new(3.0, Color32::from_black_alpha(150)));
    painter.line_segment([from, to], Stroke::new(1.5, colour));
    if !word.is_empty() {
        painter.text(to, Align2::CENTER_BOTTOM, word, FontId::proportional(11.0), colour);
    }
}
