//! Asking for a path inside the window, where the desktop offers no file dialog.

use super::command::SaveKind;
use super::theme;
use egui::{Align2, Key, RichText, TextEdit, Vec2};
use std::path::PathBuf;

/// What a path is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// A scene to open.
    Scene,
    /// A weather file to read.
    Weather,
    /// A file to save.
    Save(SaveKind),
}

impl Purpose {
    /// What the dialog is called.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Scene => "Open a scene",
            Self::Weather => "Open a weather file (EPW)",
            Self::Save(kind) => kind.title(),
        }
    }
}

/// The open question.
#[derive(Clone, Debug)]
pub(super) struct PathDialog {
    pub(super) purpose: Purpose,
    text: String,
    focused: bool,
}

/// What came of it.
pub(super) enum Answer {
    /// Still being typed.
    Waiting,
    /// Given up.
    Cancelled,
    /// This path.
    Path(PathBuf),
}

impl PathDialog {
    /// Asks for a path, beginning with a suggestion.
    pub(super) fn new(purpose: Purpose, suggestion: PathBuf) -> Self {
        Self { purpose, text: suggestion.display().to_string(), focused: false }
    }

    /// Shows the question in the middle of the window.
    pub(super) fn show(&mut self, ui: &egui::Ui) -> Answer {
        let mut answer = Answer::Waiting;
        egui::Window::new(self.purpose.title())
            .anchor(Align2::CENTER_CENTER, Vec2::ZERO)
            .collapsible(false)
            .resizable(false)
            .show(ui.ctx(), |ui| {
                let label = ui.label(RichText::new("Path of the file").color(theme::TEXT_WEAK));
                let field =
                    ui.add(TextEdit::singleline(&mut self.text).desired_width(460.0)).labelled_by(label.id);
                if !self.focused {
                    field.request_focus();
                    self.focused = true;
                }
                let entered = field.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
                ui.horizontal(|ui| {
                    let word =
                        if matches!(self.purpose, Purpose::Save(_)) { "Save file" } else { "Open file" };
                    let ready = !self.text.trim().is_empty();
                    if (ui.add_enabled(ready, egui::Button::new(word)).clicked() || entered) && ready {
                        answer = Answer::Path(PathBuf::from(self.text.trim()));
                    }
                    if ui.button("Cancel").clicked() || ui.input(|i| i.key_pressed(Key::Escape)) {
                        answer = Answer::Cancelled;
                    }
                });
            });
        answer
    }
}
