//! The window: walking, lamps, materials, false colours and patches, in egui.
//!
//! Panels, menus, keys and clicks make commands; one function carries them out. The solver is
//! behind [`Worker`]: nothing here waits for it.

mod app;
mod auditor;
mod camera_control;
mod collision;
mod colour;
mod command;
mod execute;
mod exposure;
mod files;
mod history;
mod input;
mod legend;
mod overlay;
mod panels;
mod path_dialog;
mod picture;
mod state;
mod theme;
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
            .with_min_inner_size([900.0, 560.0]),
        renderer: eframe::Renderer::Wgpu,
        persist_window: true,
        ..Default::default()
    };
    let opened = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    let has_opened = std::sync::Arc::clone(&opened);
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        let ctx = cc.egui_ctx.clone();
        let session = Session::spawn(move || ctx.request_repaint())?;
        session.set_settings(settings);
        session.open(source.clone());
        let mut state = App::stored_state(cc.storage);
        if let SceneSource::File(path) = &source {
            state.remember(path);
        }
        has_opened.store(true, std::sync::atomic::Ordering::Relaxed);
        Ok(Box::new(App::new(cc, Box::new(session), state)))
    });
    eframe::run_native("Lumenwalk", options, create).map_err(|error| {
        let text = error.to_string();
        if opened.load(std::sync::atomic::Ordering::Relaxed) {
            UiError::Failed(text)
        } else {
            UiError::NoDisplay(text)
        }
    })
}
