//! Asking for a path inside the window, where the desktop offers no file dialog.

use super::command::SaveKind;
use super::theme;
use egui::{Align2, Key, RichText, TextEdit, Vec2};
use std::path::PathBuf;

/// The open question.
#[derive(Clone, Debug)]
pub(super) struct PathDialog {
    /// What is saved; `None` to open a scene.
    pub(super) kind: Option<SaveKind>,
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
    pub(super) fn new(kind: Option<SaveKind>, suggestion: PathBuf) -> Self {
        Self { kind, text: suggestion.display().to_string(), focused: false }
    }

    /// Shows the question in the middle of the window.
    pub(super) fn show(&mut self, ui: &egui::Ui) -> Answer {
        let mut answer = Answer::Waiting;
        let title = self.kind.map_or("Open a scene", SaveKind::title);
        egui::Window::new(title)
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
                    let word = if self.kind.is_some() { "Save file" } else { "Open file" };
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
