//! What becomes of the window when the graphics device is lost: it is opened anew on the same session,
//! with lamps, materials and bookmarks as they were.

use super::app::App;
use super::camera_control::Pose;
use super::leaving::Work;
use super::overlay::Notice;
use super::state::{Edits, Visit};
use crate::scene::{Scene, View};
use std::sync::{Arc, Mutex, PoisonError};

/// What one window leaves to the next.
pub(super) struct Handover {
    scene: Option<Arc<Scene>>,
    edits: Edits,
    visit: Visit,
    saved: Work,
    views: (Vec<View>, usize),
    pose: Option<Pose>,
    /// Why there is a next one.
    reason: String,
}

/// Where a window leaves it; empty after one that was closed.
pub(super) type Legacy = Arc<Mutex<Option<Handover>>>;

/// What the graphics driver complained of.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Trouble {
    /// The device is gone, and all that was on it.
    Lost(String),
    /// A call failed: memory ran out, or a fault of the program.
    Failed(String),
}

/// The first trouble with a device; the device's own threads write it down.
#[derive(Clone, Default)]
pub(super) struct Troubles(Arc<Mutex<Option<Trouble>>>);

impl Troubles {
    /// Listens to a device from now on. Without this, errors would end the program.
    pub(super) fn of(device: &wgpu::Device, ctx: &egui::Context) -> Self {
        let troubles = Self::default();
        let (lost, wake) = (troubles.clone(), ctx.clone());
        device.set_device_lost_callback(move |_, message| {
            lost.note(Trouble::Lost(first_line(&message)));
            wake.request_repaint();
        });
        let (failed, wake) = (troubles.clone(), ctx.clone());
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            failed.note(Trouble::Failed(first_line(&error.to_string())));
            wake.request_repaint();
        }));
        troubles
    }

    /// A loss outweighs the failures that follow it or tell of it first.
    fn note(&self, trouble: Trouble) {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if slot.is_none() || matches!(trouble, Trouble::Lost(_)) {
            *slot = Some(trouble);
        }
    }

    /// What there was since the last look.
    pub(super) fn take(&self) -> Option<Trouble> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

fn first_line(text: &str) -> String {
    let line = text.lines().map(str::trim).find(|line| !line.is_empty());
    line.unwrap_or("no reason given").trim_end_matches('.').to_owned()
}

impl App {
    /// A window that leaves its state in `legacy` if it has to be opened anew, and begins with what
    /// another one left there.
    #[must_use]
    pub(super) fn with_legacy(mut self, legacy: Legacy) -> Self {
        self.inherited = legacy.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(handover) = &self.inherited {
            let text = format!(
                "The window was lost ({}) and opened anew; the scene, its lamps and bookmarks are as they were",
                handover.reason
            );
            self.notice = Some(Notice { text, is_error: true, since: 0.0 });
        }
        self.legacy = Some(legacy);
        self
    }

    /// Asks the driver whether all is well; without a device the window closes to be opened anew.
    pub(super) fn look_after_device(&mut self, ctx: &egui::Context, time: f64) {
        match self.viewport.as_ref().and_then(|viewport| viewport.trouble()) {
            None => {}
            Some(Trouble::Failed(reason)) => {
                let text = format!("The graphics driver failed ({reason}); the picture may be incomplete");
                self.notice = Some(Notice { text, is_error: true, since: time });
            }
            Some(Trouble::Lost(reason)) => {
                // Nothing more can be drawn; what the user has done is kept.
                self.viewport = None;
                self.hand_over(&reason);
                self.may_close = true;
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
        }
    }

    /// Leaves to the next window what the user has done, unless that was done already.
    fn hand_over(&self, reason: &str) {
        let Some(legacy) = &self.legacy else { return };
        legacy.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| Handover {
            scene: self.scene_shown.clone(),
            edits: self.edits.clone(),
            visit: self.visit.clone(),
            saved: self.saved.clone(),
            views: (self.views.clone(), self.start_view),
            pose: self.camera.as_ref().map(|camera| camera.pose()),
            reason: reason.to_owned(),
        });
    }

    /// Takes up what the window before left, once the same scene is on screen.
    pub(super) fn inherit(&mut self) {
        let Some(handover) = self.inherited.take() else { return };
        let same = match (&handover.scene, &self.scene_shown) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        if !same {
            return;
        }
        (self.edits, self.visit, self.saved) = (handover.edits, handover.visit, handover.saved);
        (self.views, self.start_view) = handover.views;
        if let (Some(camera), Some(pose)) = (&mut self.camera, handover.pose) {
            camera.set_motion(self.visit.motion);
            camera.stand_at(pose);
        }
    }
}

impl Drop for App {
    /// Where the device goes in the middle of a frame, the interface that is drawn with it panics before
    /// the loss can be told.
    fn drop(&mut self) {
        if std::thread::panicking() {
            let trouble = self.viewport.as_ref().and_then(|viewport| viewport.trouble());
            match trouble {
                Some(Trouble::Lost(reason) | Trouble::Failed(reason)) => self.hand_over(&reason),
                None => self.hand_over("the window failed while it was drawn"),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loss_outweighs_failures_whichever_comes_first() {
        let troubles = Troubles::default();
        assert_eq!(troubles.take(), None);
        troubles.note(Trouble::Failed("out of memory".to_owned()));
        troubles.note(Trouble::Lost("gone".to_owned()));
        troubles.note(Trouble::Failed("no device".to_owned()));
        assert_eq!(troubles.take(), Some(Trouble::Lost("gone".to_owned())));
        assert_eq!(troubles.take(), None);
    }

    #[test]
    fn reasons_are_one_line() {
        assert_eq!(first_line("\n  Validation Error.\n\nCaused by: x"), "Validation Error");
        assert_eq!(first_line(""), "no reason given");
    }
}
