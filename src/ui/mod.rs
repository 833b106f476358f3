//! The window: walking, lamps, materials, false colours and patches, in egui.
//!
//! Panels, menus, keys and clicks make commands; one function carries them out. The solver is
//! behind [`Worker`]: nothing here waits for it.

mod adoption;
mod app;
mod auditor;
mod background;
mod banners;
mod camera_control;
mod change;
mod colour;
mod command;
mod comparison;
mod daylight;
mod daylight_factor;
mod doctor;
mod drawn;
mod execute;
mod exposure;
mod files;
mod fonts;
mod frame_clock;
mod history;
mod input;
mod lampless;
mod leaving;
mod legend;
mod lit;
mod luminaires;
mod marks;
mod microscope;
mod news;
mod outline;
mod outlook;
mod overlay;
mod panels;
mod path_dialog;
mod picture;
mod prepared;
mod reaching;
mod reclaim;
mod recovery;
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
pub use state::{DisplaySettings, Edits, Preferences, Quantity, ShadingMode, UiState, Visit};
pub use worker::Worker;

use crate::scene::SceneSource;
use crate::session::Session;
use crate::solve::SolveSettings;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

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

/// Opens the window on a scene and returns when it is closed. With `ceiling_lamps`, adds some to that scene.
///
/// # Errors
/// [`UiError::NoDisplay`] where no window can be opened at all; [`UiError::Failed`] where it ends
/// otherwise than by being closed.
pub fn run(source: SceneSource, settings: SolveSettings, ceiling_lamps: bool) -> Result<(), UiError> {
    // The solver is at work before there is a window; it wakes the window that there is.
    let window = Arc::new(Mutex::new(None::<egui::Context>));
    let woken = Arc::clone(&window);
    let session = Session::spawn(move || {
        if let Some(ctx) = &*woken.lock().unwrap_or_else(PoisonError::into_inner) {
            ctx.request_repaint();
        }
    });
    let session = Arc::new(session.map_err(|error| UiError::Failed(error.to_string()))?);
    session.set_settings(settings);
    session.open(source.clone());
    let legacy = recovery::Legacy::default();
    let mut openings = 0;
    loop {
        openings += 1;
        let shown = show_window(&session, &window, &legacy, (&source, ceiling_lamps && openings == 1));
        let is_left = legacy.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if !is_left {
            return shown;
        }
        if openings == MOST_OPENINGS {
            let text = "the graphics device was lost again and again";
            return Err(UiError::Failed(text.to_owned()));
        }
    }
}

/// Windows opened one after the other on graphics devices that are lost.
const MOST_OPENINGS: u32 = 4;

/// One window on the session, from its opening to its end.
fn show_window(
    session: &Arc<Session>,
    window: &Arc<Mutex<Option<egui::Context>>>,
    legacy: &recovery::Legacy,
    (source, ceiling_lamps): (&SceneSource, bool),
) -> Result<(), UiError> {
    let source = source.clone();
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("lumenwalk")
            .with_title("Lumenwalk")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([800.0, 480.0]),
        renderer: eframe::Renderer::Wgpu,
        persist_window: true,
        // The window looks for fonts itself: see `fonts`.
        system_font_fallback: false,
        ..Default::default()
    };
    let opened = Arc::new(AtomicBool::new(false));
    let has_opened = Arc::clone(&opened);
    let create: eframe::AppCreator<'_> = Box::new(move |cc| {
        *window.lock().unwrap_or_else(PoisonError::into_inner) = Some(cc.egui_ctx.clone());
        let state = App::stored_state(cc.storage);
        has_opened.store(true, Ordering::Relaxed);
        let app = App::new(cc, Box::new(Arc::clone(session)), state).asking_for(source);
        theme::leave_ground_to_the_clear(&cc.egui_ctx);
        fonts::use_those_of_the_system(&cc.egui_ctx);
        Ok(Box::new(app.with_legacy(Arc::clone(legacy)).with_ceiling_lamps(ceiling_lamps)))
    });
    // Without a device the interface panics as soon as it is drawn; what was done is left in `legacy`.
    let ran = catch_unwind(AssertUnwindSafe(|| eframe::run_native("Lumenwalk", options, create)));
    ran.unwrap_or_else(|_| Ok(())).map_err(|error| {
        let text = error.to_string();
        if opened.load(Ordering::Relaxed) { UiError::Failed(text) } else { UiError::NoDisplay(text) }
    })
}
