//! The keys, over the picture.

use super::Commands;
use crate::ui::command::Command;
use crate::ui::theme;
use egui::{Align2, Grid, RichText, Vec2};

/// Keys and what they do, by group. The table in the README says the same.
const KEYS: [(&str, &[(&str, &str)]); 4] = [
    (
        "Moving",
        &[
            ("W A S D or arrows", "walk"),
            ("Drag", "look around"),
            ("Q, E", "down and up, while flying"),
            ("Shift", "run"),
            ("Wheel", "a step ahead or back; with Ctrl: zoom"),
            ("Right drag", "orbit around the point under the cursor"),
            ("Middle drag", "move sideways"),
            ("F", "walk or fly"),
            ("Home", "start view"),
            ("[ and ]", "previous and next bookmark"),
            ("B", "store this view as a bookmark"),
            ("T", "tour through the bookmarks"),
        ],
    ),
    (
        "Light",
        &[
            ("Click a lamp", "switch it"),
            ("1 ... 9", "switch lamp 1 ... 9"),
            ("0", "all lamps off, or on again"),
            ("- and +", "darker and brighter picture"),
            ("P", "pause or resume the solve"),
        ],
    ),
    (
        "Looking closer",
        &[
            ("L", "illuminance in false colours"),
            ("C", "keep the light as A, and see it beside now"),
            ("G", "flat or smooth shading"),
            ("M", "patch borders"),
            ("Ctrl-click", "look into a patch"),
            ("R", "its row of form factors on the scene, on or off"),
            ("Backspace", "back to the patch before"),
            ("J", "table of patches, worst first"),
            ("K", "doctor: what is doubtful about the model"),
        ],
    ),
    (
        "Window",
        &[
            ("Tab", "fold the panels away"),
            ("F6", "to the panels by keyboard; Esc leaves"),
            ("Ctrl-O, F5", "open a file, load it again"),
            ("F12, Shift-F12", "save a picture, save radiance (EXR)"),
            ("Ctrl-Z, Ctrl-Y", "undo, redo"),
            ("Esc", "leaves a tour, a patch or this list"),
            ("Ctrl-Q", "quit"),
            ("F1", "this list"),
        ],
    ),
];

/// Width in which no line of either column is cut, points.
const WIDTH: f32 = 736.0;

/// Widths of the longest keys of either column, points.
const KEY_WIDTHS: [f32; 2] = [104.0, 82.0];

/// Shows the list.
pub(in crate::ui) fn show(ui: &egui::Ui, out: &mut Commands) {
    let mut open = true;
    let screen = ui.ctx().content_rect().size();
    egui::Window::new("Keys")
        .open(&mut open)
        .anchor(Align2::CENTER_CENTER, Vec2::ZERO)
        .resizable(false)
        .collapsible(false)
        .vscroll(true)
        .default_height(496.0)
        .max_height(screen.y - 90.0)
        .show(ui.ctx(), |ui| {
            ui.set_width(WIDTH.min(screen.x - 60.0));
            ui.columns(2, |columns| {
                for ((column, groups), width) in
                    columns.iter_mut().zip([&KEYS[..2], &KEYS[2..]]).zip(KEY_WIDTHS)
                {
                    for group in groups {
                        keys_of(column, group, width);
                    }
                }
            });
        });
    if !open {
        out.push(Command::ToggleHelp);
    }
}

fn keys_of(ui: &mut egui::Ui, (title, keys): &(&str, &[(&str, &str)]), width: f32) {
    theme::group_title(ui, title);
    // One width for the keys of all groups, so that their meanings stand in line.
    Grid::new(title).num_columns(2).min_col_width(width).spacing([14.0, 1.0]).show(ui, |ui| {
        for (key, meaning) in *keys {
            ui.label(RichText::new(*key).color(theme::ACCENT));
            ui.label(*meaning);
            ui.end_row();
        }
    });
    ui.add_space(6.0);
}
