//! The window: walking, lamps, materials, false colours and patches, in egui.
//!
//! Panels, menus, keys and clicks make commands; one function carries them out. The solver is
//! behind [`Worker`]: nothing here waits for it.

mod app;
mod auditor;
mod background;
mod camera_control;
mod collision;
mod colour;
mod command;
mod comparison;
mod doctor;
mod execute;
mod exposure;
mod files;
mod frame_clock;
mod history;
mod input;
mod legend;
mod marks;
mod microscope;
mod outline;
mod outlook;
mod overlay;
mod panels;
mod path_dialog;
mod picture;
mod reclaim;
mod runs;
mod state;
mod theme;
mod touring;
mod units;
mod view;
mod viewport;
mod worker;

pub use app::App;
pub use camera_control::Motion;
pub use state::{DisplaySettings, Edits, Quantity, ShadingMode, UiState};
pub use worker::Worker;

use crate::scene::SceneSource;
use crate::session::{Session, SolveSettings};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum UiError {
    /// No display to open a window on, or no graphics adapter to draw with; the reason in words.
    #[error("no window can be opened: {0}")]
    NoDisplay(String),
    /// The window was open and failed.
    #[error("the window failed: {0}")]
    Failed(String),
}

/// Opens the window on a scene and returns when it is closed.
///
/// # Errors
/// [`UiError::NoDisplay`] where no window can be opened at all; [`UiError::Failed`] where it ends
/// otherwise than by being closed.
pub fn run(source: SceneSource, settings: SolveSettings) -> Result<(), UiError> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("lumenwalk")
            .with_title("Lumenwalk")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([800.0, 480.0]),
        renderer: eframe::Renderer::Wgpu,
        persist_window: true,
        ..Default::default()
    };
    // The solver is at work before there is a window; it wakes the window once there is one.
    let wake = Arc::new(OnceLock::<egui::Context>::new());
    let woken = Arc::clone(&wake);
    let session = Session::spawn(move || {
        if let Some(ctx) = woken.get() {
            ctx.request_repaint();
        }
    });
    let session = session.map_err(|error| UiError::Failed(error.to_string()))?;
    session.set_settings(settings);
    session.open(source.clone());
    let opened = Arc::new(AtomicBool::new(false));
    let has_opened = Arc::clone(&opened);
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        wake.set(cc.egui_ctx.clone()).ok();
        let mut state = App::stored_state(cc.storage);
        if let SceneSource::File(path) = &source {
            state.remember(path);
        }
        has_opened.store(true, Ordering::Relaxed);
        let app = App::new(cc, Box::new(session), state);
        theme::leave_ground_to_the_clear(&cc.egui_ctx);
        Ok(Box::new(app))
    });
    eframe::run_native("Lumenwalk", options, create).map_err(|error| {
        let text = error.to_string();
        if opened.load(Ordering::Relaxed) { UiError::Failed(text) } else { UiError::NoDisplay(text) }
    })
}
