//! Banners: what the user should know about the scene on screen, with buttons for what can be done about it.
//! They stand at the top of the view, one below the other, until what they tell is over or they are dismissed.

use super::command::Command;
use super::panels::{Commands, Model};
use super::{doctor, fonts, lampless, theme};
use egui::{Align2, Area, Button, Color32, Id, Label, Order, Rect, RichText};

/// One banner.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Banner {
    /// Tells it apart from the others; a banner that was dismissed stays away while the scene is open.
    pub(super) key: &'static str,
    /// Whether the picture may not be what was meant; otherwise it is good to know.
    pub(super) is_warning: bool,
    /// One or two sentences.
    pub(super) text: String,
    /// Buttons from left to right: their words, and what they ask for.
    pub(super) actions: Vec<(String, Command)>,
}

/// All banners, from top to bottom; each answers with itself where it has something to tell.
const BANNERS: [fn(&Model<'_>) -> Option<Banner>; 3] =
    [doctor::frame_banner, lampless::banner, fonts::banner];

/// Shows the banners that have something to tell. Returns the part of the view below them.
pub(super) fn show(ui: &egui::Ui, view: Rect, model: &Model<'_>, out: &mut Commands) -> Rect {
    let banners: Vec<Banner> = BANNERS
        .iter()
        .filter_map(|banner| banner(model))
        .filter(|banner| !model.visit.dismissed.contains(banner.key))
        .collect();
    if banners.is_empty() {
        return view;
    }
    let inner = view.shrink(12.0);
    let shown = Area::new(Id::unique("banners"))
        .order(Order::Middle)
        .fixed_pos(Align2::CENTER_TOP.pos_in_rect(&inner))
        .pivot(Align2::CENTER_TOP)
        .constrain_to(inner)
        .fade_in(false)
        .show(ui.ctx(), |ui| {
            for banner in &banners {
                theme::overlay().show(ui, |ui| {
                    ui.set_max_width((inner.width() - 24.0).clamp(120.0, 600.0));
                    contents(ui, banner, out);
                });
            }
        });
    view.with_min_y(shown.response.rect.bottom().min(view.bottom()))
}

fn contents(ui: &mut egui::Ui, banner: &Banner, out: &mut Commands) {
    ui.horizontal_top(|ui| {
        let (word, colour) =
            if banner.is_warning { ("Warning", theme::WARNING) } else { ("Note", theme::ACCENT) };
        ui.label(RichText::new(word).strong().color(colour));
        ui.add(Label::new(RichText::new(&banner.text).color(Color32::from_gray(235))).wrap());
    });
    ui.horizontal_wrapped(|ui| {
        for (text, command) in &banner.actions {
            if ui.button(text).clicked() {
                out.push(command.clone());
            }
        }
        // Several banners have the same button: its name tells them apart where it is not seen.
        let dismiss = ui.add(Button::new("Dismiss").frame_when_inactive(true));
        if dismiss.accessible_name(format!("Dismiss: {}", banner.text)).clicked() {
            out.push(Command::DismissBanner(banner.key));
        }
    });
}
