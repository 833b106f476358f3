//! The places of a finding drawn over the picture: where something hides them, thinner.

use super::doctor::{Spot, spot, spots};
use super::prepared::Prepared;
use super::theme;
use crate::geometry::{Frame, Ray, polygon};
use crate::navigation::Camera;
use crate::scene::{Finding, Severity};
use egui::{Color32, Painter, Pos2, Rect, Stroke};
use glam::{DVec2, DVec3};

/// Questions whether something hides a part, a frame.
const MOST_RAYS: usize = 1500;
/// Parts of an edge that are hidden or not as a whole.
const PARTS: usize = 4;

/// Draws where a finding is into `view`; the place numbered `chosen` stands out.
pub(super) fn show(
    ui: &egui::Ui,
    view: Rect,
    prepared: &Prepared,
    camera: &Camera,
    finding: &Finding,
    chosen: Option<usize>,
) {
    let colour = match finding.severity {
        Severity::Error => theme::FAILURE,
        Severity::Warning => theme::WARNING,
        Severity::Note => Color32::from_rgb(150, 200, 235),
    };
    let size_px = [view.width(), view.height()].map(|n| n.round().max(1.0) as u32);
    let mut brush = Brush {
        painter: ui.painter_at(view),
        view,
        prepared,
        camera,
        size_px,
        colour,
        rays: MOST_RAYS,
        lines: Vec::new(),
    };
    let count = spots(finding);
    // What stands out is drawn last, and looked for first.
    if let Some(place) = chosen.and_then(|place| spot(finding, place)) {
        brush.mark(place, true);
    }
    for place in (0..count).filter(|place| Some(*place) != chosen).filter_map(|place| spot(finding, place)) {
        brush.mark(place, false);
    }
    brush.finish();
}

/// A stroke that is kept until all fills are drawn.
struct Line {
    ends: [Pos2; 2],
    seen: bool,
    bold: bool,
}

struct Brush<'a> {
    painter: Painter,
    view: Rect,
    prepared: &'a Prepared,
    camera: &'a Camera,
    size_px: [u32; 2],
    colour: Color32,
    /// Questions left.
    rays: usize,
    lines: Vec<Line>,
}

impl Brush<'_> {
    fn mark(&mut self, place: Spot, bold: bool) {
        match place {
            Spot::Face(face) => self.face(face, bold),
            Spot::Edge([a, b]) => self.edge(a, b, DVec3::ZERO, bold),
            Spot::Point(point) => self.point(point, bold),
        }
    }

    fn on_screen(&self, point: DVec3) -> Option<Pos2> {
        let at = self.camera.project(point, self.size_px)?;
        Some(self.view.min + egui::vec2(at.x as f32, at.y as f32))
    }

    /// Whether nothing stands between the eye and a point, but for what it lies on.
    fn is_seen(&mut self, point: DVec3) -> bool {
        if self.rays == 0 {
            return true;
        }
        self.rays -= 1;
        let ray = Ray { origin: self.camera.eye, direction: point - self.camera.eye };
        self.prepared.picker.pick(&ray).is_none_or(|pick| pick.distance > 0.995)
    }

    fn face(&mut self, face: u32, bold: bool) {
        let scene = &self.prepared.scene;
        let Some(surface) = scene.surfaces.get(face as usize) else { return };
        let outline = scene.polygon(surface);
        let normal = polygon::area_vector(&outline).normalize_or(DVec3::Z);
        let frame = Frame::around(normal);
        let flat: Vec<DVec2> =
            outline.iter().map(|p| frame.local(*p - outline[0])).map(|p| p.truncate()).collect();
        let strength = if bold { 0.34 } else { 0.2 };
        for triangle in polygon::triangulate(&flat, &[]) {
            let corners = triangle.map(|i| outline[i as usize]);
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let share = if self.is_seen(middle) { strength } else { 0.3 * strength };
            let shape: Vec<Pos2> =
                self.before_the_eye(&corners).into_iter().filter_map(|p| self.on_screen(p)).collect();
            if shape.len() > 2 {
                let fill = self.colour.gamma_multiply(share);
                self.painter.add(egui::Shape::convex_polygon(shape, fill, Stroke::NONE));
            }
        }
        for k in 0..outline.len() {
            self.edge(outline[k], outline[(k + 1) % outline.len()], normal, bold);
        }
    }

    /// The part of a triangle in front of the camera.
    fn before_the_eye(&self, corners: &[DVec3; 3]) -> Vec<DVec3> {
        let depth = |p: DVec3| (p - self.camera.eye).dot(self.camera.forward) - self.near();
        let mut kept = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (da, db) = (depth(a), depth(b));
            if da >= 0.0 {
                kept.push(a);
            }
            if da * db < 0.0 {
                kept.push(a.lerp(b, da / (da - db)));
            }
        }
        kept
    }

    fn near(&self) -> f64 {
        1e-3 * self.prepared.mesh.size
    }

    /// An edge, of a face with this normal or of none.
    fn edge(&mut self, a: DVec3, b: DVec3, normal: DVec3, bold: bool) {
        let depth = |p: DVec3| (p - self.camera.eye).dot(self.camera.forward) - self.near();
        let (da, db) = (depth(a), depth(b));
        let (a, b) = match (da > 0.0, db > 0.0) {
            (false, false) => return,
            (true, true) => (a, b),
            (true, false) => (a, a.lerp(b, da / (da - db))),
            (false, true) => (a.lerp(b, da / (da - db)), b),
        };
        let parts = if self.rays > MOST_RAYS / 2 { PARTS } else { 1 };
        let towards = if normal.dot(self.camera.eye - a) < 0.0 { -normal } else { normal };
        let at = |k: usize| a.lerp(b, k as f64 / parts as f64);
        for part in 0..parts {
            let (p, q) = (at(part), at(part + 1));
            let seen = self.is_seen(0.5 * (p + q) + towards * (1e-4 * self.prepared.mesh.size));
            if let (Some(from), Some(to)) = (self.on_screen(p), self.on_screen(q)) {
                self.lines.push(Line { ends: [from, to], seen, bold });
            }
        }
    }

    fn point(&mut self, point: DVec3, bold: bool) {
        let seen = self.is_seen(point);
        let Some(at) = self.on_screen(point) else { return };
        let radius = if bold { 6.5 } else { 4.0 };
        let strength = if seen { 1.0 } else { 0.45 };
        self.painter.circle_stroke(
            at,
            radius,
            Stroke::new(4.0, Color32::from_black_alpha((170.0 * strength) as u8)),
        );
        self.painter.circle_stroke(at, radius, Stroke::new(2.0, self.colour.gamma_multiply(strength)));
    }

    fn finish(self) {
        for line in self.lines.iter().filter(|line| !line.seen) {
            self.painter.line_segment(line.ends, Stroke::new(1.0, self.colour.gamma_multiply(0.5)));
        }
        let width = |line: &Line| if line.bold { 3.0 } else { 1.6 };
        for line in self.lines.iter().filter(|line| line.seen) {
            self.painter
                .line_segment(line.ends, Stroke::new(width(line) + 2.0, Color32::from_black_alpha(170)));
        }
        for line in self.lines.iter().filter(|line| line.seen) {
            self.painter.line_segment(line.ends, Stroke::new(width(line), self.colour));
        }
    }
}
