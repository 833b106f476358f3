//! The doctor under the view: what is doubtful about the model, what the solver makes of it, and where
//! it is.

use super::list::{Cell, LINE, line};
use super::{Commands, Model};
use crate::scene::{Finding, Scene, Severity};
use crate::ui::command::{Command, SaveKind};
use crate::ui::doctor::{Ask, Report, Spot, spot, spots};
use crate::ui::{theme, units};
use egui::{Align, Color32, Layout, RichText, ScrollArea, Ui, UiBuilder};
use glam::DVec3;

/// Width of the column of severities, points.
const SEVERITY: f32 = 56.0;
/// Width of the column of counts, points.
const COUNT: f32 = 44.0;
/// Width of the list of findings, points; the rest tells of one of them.
const LIST: f32 = 318.0;

/// Shows what was found. A click on a line goes to the first place, one on a place goes there.
pub(in crate::ui) fn show(ui: &mut Ui, model: &Model<'_>, out: &mut Commands) {
    let report = model.doctor.report();
    ui.horizontal(|ui| {
        ui.label(RichText::new("DOCTOR").size(11.5).color(theme::TEXT));
        let text = report.map_or_else(|| "examining the model...".to_owned(), summary);
        ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.small_button("Close").on_hover_text("Hide the doctor (K)").clicked() {
                out.push(Command::Doctor(Ask::Toggle));
            }
            let save = egui::Button::new("Save repaired copy...").small();
            let tip = "A copy with welded corners, without duplicates, cut where faces pass through each other, \
                       and with neighbours that face one way. The model itself stays as it is.";
            if ui.add_enabled(model.scene.is_some(), save).on_hover_text(tip).clicked() {
                out.push(Command::Save(SaveKind::RepairedCopy));
            }
        });
    });
    ui.separator();
    let Some((report, scene)) = report.zip(model.scene) else { return };
    if report.findings.is_empty() {
        super::empty(ui, "Nothing doubtful was found in this model.");
        return;
    }
    let asked = out.len();
    let all = ui.available_rect_before_wrap();
    // The panel keeps the height that it was drawn to, however little there is to tell.
    ui.expand_to_include_rect(all);
    let (list, rest) = all.split_left_right_at_x(all.left() + LIST.min(0.6 * all.width()));
    ui.scope_builder(UiBuilder::new().max_rect(list), |ui| {
        ScrollArea::vertical().id_salt("findings").auto_shrink(false).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 0.0;
            for (number, finding) in report.findings.iter().enumerate() {
                finding_line(ui, model, number, finding, out);
            }
        });
    });
    // What is under the cursor is told from the next frame on.
    let hovered = out[asked..].iter().rev().find_map(|command| match command {
        Command::Doctor(Ask::Hover(number)) => Some(*number),
        _ => None,
    });
    if hovered != model.doctor.hovered {
        ui.ctx().request_repaint();
    }
    ui.painter().vline(rest.left() + 6.0, rest.y_range(), ui.visuals().widgets.noninteractive.bg_stroke);
    let rest = rest.with_min_x(rest.left() + 14.0);
    ui.scope_builder(UiBuilder::new().max_rect(rest), |ui| {
        match model.doctor.hovered.or(model.doctor.selected) {
            Some(number) => {
                if let Some(finding) = report.findings.get(number) {
                    let chosen = (model.doctor.selected == Some(number)).then_some(model.doctor.place);
                    details(ui, scene, finding, chosen, out);
                }
            }
            None => super::empty(ui, "Click a finding to see where it is, and what the solver makes of it."),
        }
    });
}

/// "2 warnings, 5 notes".
fn summary(report: &Report) -> String {
    let counted = [(Severity::Error, "error"), (Severity::Warning, "warning"), (Severity::Note, "note")];
    let told: Vec<String> = counted
        .into_iter()
        .map(|(severity, word)| (report.count(severity), word))
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| plural(count, word))
        .collect();
    if told.is_empty() { "nothing doubtful".to_owned() } else { told.join(", ") }
}

fn plural(count: usize, word: &str) -> String {
    format!("{} {word}{}", units::count(count), if count == 1 { "" } else { "s" })
}

/// What says how much a finding matters, and its colour.
fn severity_of(finding: &Finding) -> (&'static str, Color32) {
    match finding.severity {
        Severity::Error => ("error", theme::FAILURE),
        Severity::Warning => ("warning", theme::WARNING),
        Severity::Note => ("note", theme::TEXT_WEAK),
    }
}

fn finding_line(ui: &mut Ui, model: &Model<'_>, number: usize, finding: &Finding, out: &mut Commands) {
    let (word, colour) = severity_of(finding);
    let rest = (ui.available_width() - SEVERITY - COUNT - 12.0).max(0.0);
    let cells = [
        Cell { colour, ..Cell::name(SEVERITY, word) },
        Cell::number(COUNT, units::count(finding.count)),
        Cell::name(rest, finding.kind.name()),
    ];
    let name = format!("{word}: {} ({})", finding.kind.name(), finding.count);
    let response = line(ui, &name, model.doctor.selected == Some(number), &cells);
    if response.hovered() {
        out.push(Command::Doctor(Ask::Hover(number)));
    }
    if response.clicked() {
        out.push(Command::Doctor(Ask::Select(number)));
    }
}

fn details(ui: &mut Ui, scene: &Scene, finding: &Finding, chosen: Option<usize>, out: &mut Commands) {
    let (word, colour) = severity_of(finding);
    ScrollArea::vertical().id_salt("finding").auto_shrink(false).show(ui, |ui| {
        ui.set_max_width(ui.available_width() - 8.0);
        ui.horizontal(|ui| {
            ui.label(RichText::new(finding.kind.name()).strong());
            ui.label(RichText::new(word).color(colour));
            if finding.kind.is_mended() {
                let note = RichText::new("fixed in a repaired copy").small().color(theme::TEXT_WEAK);
                ui.label(note);
            }
        });
        ui.label(capitalised(&finding.message));
        if !finding.consequence.is_empty() {
            let text = format!("Solver: {}.", finding.consequence);
            ui.label(RichText::new(text).color(theme::TEXT_WEAK));
        }
        if let Some((unit, up)) = finding.remedy.filter(|_| scene.source.path().is_some()) {
            let tip = "Writes the sidecar beside the model and reads the model again";
            let text = format!("Set {}", super::menu::frame_name(unit, up));
            if ui.button(text).on_hover_text(tip).clicked() {
                out.push(Command::SetFrame(unit, up));
            }
        }
        let count = spots(finding);
        if count == 0 {
            return;
        }
        ui.horizontal(|ui| {
            let at = chosen.unwrap_or(0);
            let cap =
                if finding.places.edges.len().max(finding.places.faces.len()) >= crate::scene::MOST_PLACES {
                    " (the first ones)"
                } else {
                    ""
                };
            if let Some(chosen) = chosen {
                let step = |ui: &mut Ui, text: &str, to: usize| {
                    ui.small_button(text).clicked().then_some(Command::Doctor(Ask::Place(to)))
                };
                out.extend(step(ui, "Previous place", (chosen + count - 1) % count));
                out.extend(step(ui, "Next place", (chosen + 1) % count));
            }
            let text = format!("place {} of {}{cap}", units::count(at + 1), units::count(count));
            ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
        });
        let Some(chosen) = chosen else { return };
        ui.spacing_mut().item_spacing.y = 0.0;
        // A window of lines around the chosen one: there may be hundreds.
        const SHOWN: usize = 40;
        let first = chosen.saturating_sub(SHOWN / 2).min(count.saturating_sub(SHOWN));
        for place in first..(first + SHOWN).min(count) {
            let Some(spot) = spot(finding, place) else { continue };
            let text = described(scene, spot);
            let width = ui.available_width() - COUNT;
            let cells = [Cell::number(COUNT, units::count(place + 1)).weak(), Cell::name(width, &text)];
            let response = line(ui, &format!("Place {}: {text}", place + 1), place == chosen, &cells);
            if response.clicked() {
                out.push(Command::Doctor(Ask::Place(place)));
            }
        }
        ui.add_space(LINE);
    });
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).chain(['.']).collect())
}

/// A place in words: names and the line of the file, or coordinates in the unit of the scene.
fn described(scene: &Scene, spot: Spot) -> String {
    let unit = scene.unit;
    let at = |p: DVec3| scene.in_file(p).to_array().map(units::coordinate).join(", ");
    match spot {
        Spot::Face(face) => {
            let Some(surface) = scene.surfaces.get(face as usize) else { return String::new() };
            let object = scene.objects.get(surface.object as usize).map_or("", String::as_str);
            let material = scene.materials.get(surface.material as usize).map_or("", |m| m.name.as_str());
            let line = surface.line.map_or_else(String::new, |line| format!(", line {line}"));
            format!("face of {object}, {material}{line}")
        }
        Spot::Edge([a, b]) => {
            let length = units::digits(a.distance(b) / unit.metres());
            format!("edge of {length} {} at {}", unit.symbol(), at(0.5 * (a + b)))
        }
        Spot::Point(point) => format!("corner at {} {}", at(point), unit.symbol()),
    }
}
