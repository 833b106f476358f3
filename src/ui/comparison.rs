//! The light kept as state A, and the divider between it and the present light.

use super::app::App;
use super::overlay::Notice;
use super::picture::Picture;
use super::prepared::Prepared;
use super::reclaim::Reclaim;
use super::state::{DisplaySettings, Edits, Quantity};
use super::theme;
use crate::scene::{Lighting, Scene};
use crate::solve::patch_reflectance;
use crate::solver::{LightBases, PatchLight};
use egui::{Align2, Color32, CursorIcon, FontId, Key, Pos2, Rect, Sense, Vec2};
use std::sync::Arc;

/// How near the divider comes to the edges of the view, as a share of its width.
const MARGIN: f32 = 0.04;
/// How far the arrow keys move it, as a share of the width.
const KEY_STEP: f32 = 0.02;
/// Width in which the divider is caught, points.
const CATCH: f32 = 14.0;

/// A state of lamps and materials to compare with.
#[derive(Clone)]
pub(super) struct Kept {
    /// The mesh that `light` is of.
    prepared: Arc<Prepared>,
    pub(super) lighting: Lighting,
    /// Of each material, as edited or as the file has it.
    materials: Vec<[f64; 3]>,
    /// Of each patch.
    reflectance: Arc<Vec<[f32; 3]>>,
    pub(super) light: PatchLight,
}

impl Kept {
    /// The light of `prepared` as it is, under `edits`.
    pub(super) fn new(
        prepared: Arc<Prepared>,
        edits: &Edits,
        reflectance: Arc<Vec<[f32; 3]>>,
        light: PatchLight,
    ) -> Self {
        let edited = |k: usize| edits.reflectance.get(k).copied().flatten();
        let materials = prepared.scene.materials.iter().enumerate();
        let materials = materials.map(|(k, material)| edited(k).unwrap_or(material.reflectance)).collect();
        Self { prepared, lighting: edits.lighting.clone(), materials, reflectance, light }
    }

    /// Whether it is of this mesh.
    pub(super) fn is_of(&self, prepared: &Prepared) -> bool {
        self.prepared.mesh_serial == prepared.mesh_serial
    }

    /// Takes over a solution that has gone on since, so that what differs is the lamps alone. A light
    /// under other reflectances stays as it was.
    fn settle(&mut self, bases: &LightBases, reflectance: &Arc<Vec<[f32; 3]>>) {
        if Arc::ptr_eq(&self.reflectance, reflectance) || self.reflectance == *reflectance {
            self.light = bases.mix(&self.prepared.mesh, &self.lighting, reflectance);
        }
    }

    /// The same state on another mesh: lit anew by `bases` where the reflectances are those of the state, else
    /// each patch with the light of the place that it covers. `None` where neither can be.
    fn carried(
        &self,
        to: &Arc<Prepared>,
        bases: &LightBases,
        reflectance: &Arc<Vec<[f32; 3]>>,
    ) -> Option<Self> {
        // Lamps and materials are known by their places in these lists.
        let (before, now) = (&self.prepared.scene, &to.scene);
        let names = |scene: &Scene| {
            let lamps = scene.luminaires.iter().map(|lamp| lamp.name.clone());
            lamps.chain(scene.materials.iter().map(|material| material.name.clone())).collect::<Vec<_>>()
        };
        if !Arc::ptr_eq(before, now) && (before.source != now.source || names(before) != names(now)) {
            return None;
        }
        let of_material = |material: u32| {
            let edit = self.materials.get(material as usize).copied();
            edit.filter(|edit| now.materials.get(material as usize).is_some_and(|m| m.reflectance != *edit))
        };
        let own = patch_reflectance(&to.mesh, &of_material);
        let own: Vec<[f32; 3]> = own.iter().map(|rho| rho.map(|b| b as f32)).collect();
        let light = if own == **reflectance {
            bases.mix(&to.mesh, &self.lighting, reflectance)
        } else {
            self.light.carried(&self.prepared.mesh, &to.mesh)?
        };
        Some(Self { prepared: Arc::clone(to), reflectance: Arc::new(own), light, ..self.clone() })
    }
}

impl Picture {
    /// Keeps the present light as state A.
    pub(super) fn store_comparison(&mut self, edits: &Edits) {
        if let Some(prepared) = self.prepared.as_ref().filter(|_| !self.light.radiosity.is_empty()) {
            let reflectance = Arc::clone(&self.reflectance);
            self.comparison = Some(Kept::new(Arc::clone(prepared), edits, reflectance, self.light.clone()));
        }
    }

    /// Lets state A follow a solution that has gone on, and to another mesh. Answers with false where it had to
    /// be given up: the model is another one.
    pub(super) fn settle_comparison(&mut self, reclaim: &Reclaim) -> bool {
        let (Some(prepared), Some(bases)) = (&self.prepared, &self.bases) else { return true };
        match &mut self.comparison {
            Some(kept) if kept.is_of(prepared) => kept.settle(bases, &self.reflectance),
            Some(kept) => {
                let carried = kept.carried(prepared, bases, &self.reflectance);
                reclaim.later(std::mem::replace(&mut self.comparison, carried));
                return self.comparison.is_some();
            }
            None => {}
        }
        true
    }

    /// Forgets state A.
    pub(super) fn forget_comparison(&mut self) {
        self.comparison = None;
    }

    /// Whether a state A of this mesh is stored.
    pub(super) fn has_comparison(&self) -> bool {
        self.kept().is_some()
    }

    /// State A, where it is of this mesh.
    pub(super) fn kept(&self) -> Option<&Kept> {
        let prepared = self.prepared.as_ref()?;
        self.comparison.as_ref().filter(|kept| kept.is_of(prepared))
    }
}

impl App {
    /// Lets state A follow the light and the mesh, and says so where it cannot.
    pub(super) fn follow_with_comparison(&mut self, time: f64) {
        if self.picture.settle_comparison(&self.reclaim) {
            return;
        }
        let display = DisplaySettings { split: false, ..self.edits.display };
        self.edits.display = match display.quantity {
            Quantity::Difference => display.showing(Quantity::Picture),
            _ => display,
        };
        let text =
            "Light A was dropped: the model that was read has other lamps, materials or surfaces. C keeps a \
                    new one"
                .to_owned();
        self.notice = Some(Notice { text, is_error: false, since: time });
    }

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
