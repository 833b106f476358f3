//! Error against seconds, drawn as the solve runs, beside all solves of this session.

use super::accuracy::percent;
use super::{Commands, Model};
use crate::form_factors::ReceivingPoints;
use crate::ui::command::Command;
use crate::ui::runs::{Finished, nearest};
use crate::ui::{theme, units};
use egui::{Align2, Color32, RichText, vec2};
use egui_plot::{
    AxisHints, GridMark, HoverPosition, Line, LineStyle, MarkerShape, PlotPoint, PlotPoints, Points, Text,
};
use std::ops::RangeInclusive;

/// Solves of other scenes.
const ELSEWHERE: Color32 = Color32::from_gray(96);
/// Where a solve on its way stands before there is a curve of two points.
const DOT: f32 = 3.5;
/// Height of the chart, and of the place kept for it, points.
const HEIGHT: f32 = 118.0;

/// Shows the chart, once there is anything to show.
pub(super) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let auditor = model.auditor;
    let runs = &auditor.runs;
    let logarithms = |points: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let valid = points.iter().filter(|p| p[0] > 0.0 && p[1] > 0.0);
        valid.map(|[s, e]| [s.log10(), (100.0 * e).log10()]).collect()
    };
    let place = |f: &Finished| {
        let error = f.budget.map(|b| b.total.error)?;
        logarithms(&[[f.seconds, error]]).pop()
    };
    let here = |f: &&Finished| f.is_here;
    let known: Vec<[f64; 2]> = runs.finished.iter().filter(here).filter_map(place).collect();
    let running = super::solver::is_running(model.snapshot.stage);
    let rest = auditor.rest_foreseen(model.snapshot);
    let live = match runs.last() {
        // Until it has been checked a solve that has ended stands where it was foreseen to.
        Some(last) if !running && last.budget.is_none() => logarithms(&last.curve(rest)),
        _ if running => logarithms(&runs.live(rest)),
        _ => Vec::new(),
    };
    let elsewhere: Vec<&Finished> =
        runs.finished.iter().filter(|f| !f.is_here && f.budget.is_some()).collect();
    ui.add_space(2.0);
    if known.is_empty() && live.is_empty() && elsewhere.is_empty() {
        // Its place is kept, so that nothing moves when it comes.
        let (place, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), egui::Sense::hover());
        ui.painter().rect_filled(place, 2.0, ui.visuals().extreme_bg_color);
        let font = egui::TextStyle::Small.resolve(ui.style());
        ui.painter().text(
            place.center(),
            Align2::CENTER_CENTER,
            "Error against seconds",
            font,
            theme::TEXT_FAINT,
        );
        return;
    }
    let foreseen = logarithms(&auditor.curve);
    let middle = middle(
        [&known, &live, &foreseen]
            .into_iter()
            .flatten()
            .copied()
            .chain(runs.finished.iter().flat_map(|run| logarithms(&run.curve(0.0)))),
    );
    let current = runs.last().and_then(place);
    let response = theme::plot("error against seconds", HEIGHT)
        .allow_double_click_reset(false)
        .set_margin_fraction(vec2(0.08, 0.12))
        .x_grid_spacer(|axis| marks(axis.bounds))
        .y_grid_spacer(|axis| marks(axis.bounds))
        .custom_x_axes(vec![axis(AxisHints::new_x(), 34.0, "s")])
        .custom_y_axes(vec![axis(AxisHints::new_y(), 14.0, "%").min_thickness(38.0)])
        .label_formatter(|hover| match hover {
            HoverPosition::NearDataPoint { position, .. } => {
                let found = nearest(runs, [position.x, position.y])?;
                let what = if found.is_here { "click to solve so again" } else { "another scene" };
                Some(format!("{}\n{what}", describe(found)))
            }
            HoverPosition::Elsewhere { .. } => None,
        })
        .show(ui, |plot| {
            let thin = |name: &str, points: Vec<[f64; 2]>, colour: Color32| {
                Line::new(name.to_owned(), PlotPoints::from(points))
                    .color(colour)
                    .width(1.0)
                    .allow_hover(false)
            };
            for (k, run) in elsewhere.iter().enumerate() {
                plot.line(thin("elsewhere", logarithms(&run.curve(0.0)), ELSEWHERE.gamma_multiply(0.6)));
                let Some(at) = place(run) else { continue };
                plot.points(
                    Points::new("elsewhere", PlotPoints::from(vec![at])).color(ELSEWHERE).radius(2.5),
                );
                // One label a scene, at its latest solve.
                if elsewhere[k + 1..].iter().all(|later| later.scene != run.scene) {
                    let name = RichText::new(&run.scene).size(10.0);
                    let (aside, anchor) = beside(at, middle, k);
                    let text =
                        Text::new("elsewhere", PlotPoint::new(at[0] + aside, at[1]), name).anchor(anchor);
                    plot.text(text.color(ELSEWHERE).allow_hover(false));
                }
            }
            for run in runs.finished.iter().filter(here).filter(|f| f.budget.is_some()) {
                plot.line(thin("fall", logarithms(&run.curve(0.0)), theme::TEXT_WEAK.gamma_multiply(0.7)));
            }
            if foreseen.len() > 1 {
                let line = thin("foreseen", foreseen, theme::TEXT_WEAK);
                plot.line(line.style(LineStyle::dashed_loose()));
            }
            plot.points(
                Points::new("solves", PlotPoints::from(known))
                    .color(theme::TEXT_WEAK)
                    .radius(3.0)
                    .filled(true),
            );
            if let Some(&now) = live.last() {
                plot.line(thin("this solve", live, theme::ACCENT).width(1.8));
                let now = Points::new("now", PlotPoints::from(vec![now]));
                plot.points(now.color(theme::ACCENT).radius(DOT).filled(true).allow_hover(false));
            } else if let Some(current) = current.filter(|_| !running) {
                let marker = Points::new("on screen", PlotPoints::from(vec![current]));
                plot.points(marker.color(theme::ACCENT).shape(MarkerShape::Diamond).radius(5.5).filled(true));
            }
        });
    if running && rest == 0.0 {
        let text =
            "Of this solve so far: what sweeps still change. Patches and form factors are checked after it.";
        ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
    }
    let clicked = response.response.interact_pointer_pos().filter(|_| response.response.clicked());
    if let Some(at) = clicked {
        let value = response.transform.value_from_position(at);
        if let Some(found) = nearest(runs, [value.x, value.y])
            && found.is_here
            && found.settings != model.snapshot.settings
        {
            out.push(Command::Solve(found.settings.clone()));
        }
    }
}

/// Where the name of a solve stands: to the side of its mark that faces the middle of the chart, where it is
/// not cut; above and below in turn, since solves of small scenes lie close together.
fn beside(at: [f64; 2], middle: f64, index: usize) -> (f64, Align2) {
    match (at[0] < middle, index.is_multiple_of(2)) {
        (true, true) => (0.05, Align2::LEFT_BOTTOM),
        (true, false) => (0.05, Align2::LEFT_TOP),
        (false, true) => (-0.05, Align2::RIGHT_BOTTOM),
        (false, false) => (-0.05, Align2::RIGHT_TOP),
    }
}

/// Half-way between the first and the last of the points that a chart shows.
fn middle(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let [low, high] = points.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p[0]), h.max(p[0])]);
    0.5 * (low + high)
}

/// Marks at 1, 2 and 5 of each decade of the part of a logarithmic axis that is shown.
fn marks((low, high): (f64, f64)) -> Vec<GridMark> {
    if !(low.is_finite() && high.is_finite() && high - low < 40.0) {
        return Vec::new();
    }
    let decades = low.floor() as i32..=high.ceil() as i32;
    decades
        .flat_map(|decade| {
            [(1.0_f64, 1.0), (2.0, 0.3), (5.0, 0.3)].map(|(multiple, step_size)| GridMark {
                value: f64::from(decade) + multiple.log10(),
                step_size,
            })
        })
        .filter(|mark| (low..=high).contains(&mark.value))
        .collect()
}

/// An axis whose labels are there or not, never half: from `apart` points of a decade on.
fn axis(hints: AxisHints<'static>, apart: f32, unit: &'static str) -> AxisHints<'static> {
    hints
        .label_spacing(egui::Rangef::new(apart, apart + 0.5))
        .tick_label_color(theme::TEXT_WEAK)
        .tick_label_font(egui::FontId::proportional(11.0))
        .formatter(move |mark, shown| label(&mark, shown, unit))
}

/// The number at a mark; between decades only where there is room.
fn label(mark: &GridMark, shown: &RangeInclusive<f64>, unit: &str) -> String {
    let decades = shown.end() - shown.start();
    // A long label close to the end of the lower axis would run out of the panel.
    let runs_out = unit == "s" && mark.value > 3.5 && shown.end() - mark.value < 0.06 * decades;
    if mark.step_size < 1.0 && decades > 1.2 || runs_out {
        return String::new();
    }
    let value = 10.0_f64.powf(mark.value);
    // 1, 2 or 5 of a decade: one digit.
    let digits = (-(mark.value + 1e-9).floor()).max(0.0) as usize;
    format!("{value:.digits$} {unit}")
}

/// A solve in one line.
fn describe(found: &Finished) -> String {
    let settings = &found.settings;
    let resolution = settings.resolution.unwrap_or_else(|| settings.method.default_resolution());
    let error = found.budget.map_or("-".to_owned(), |b| percent(b.total.error));
    let points = match settings.points {
        ReceivingPoints::Auto => String::new(),
        fixed => format!(" at {} points", fixed.name()),
    };
    let refined = if settings.refinement.is_some() { ", finer where it was wrong" } else { "" };
    format!(
        "{}: {} patches{refined}, {} {resolution}{points}, tolerance {:e}: {error} in {}",
        found.scene,
        units::count(found.patches),
        settings.method.name(),
        settings.tolerance,
        units::duration(found.seconds)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_on_the_inner_side_of_their_marks() {
        let middle = middle([[0.0, 1.0], [-1.0, 2.0], [3.0, 0.0]].into_iter());
        assert_eq!(middle, 1.0);
        assert!(beside([-1.0, 0.0], middle, 0).0 > 0.0, "to the right of the leftmost");
        assert!(beside([3.0, 0.0], middle, 1).0 < 0.0, "to the left of the rightmost");
        assert_ne!(beside([0.0, 0.0], middle, 0).1, beside([0.0, 0.0], middle, 1).1);
    }

    #[test]
    fn marks_are_labelled_where_there_is_room() {
        let told = |low: f64, high: f64| -> Vec<String> {
            marks((low, high))
                .into_iter()
                .map(|m| label(&m, &(low..=high), "s"))
                .filter(|text| !text.is_empty())
                .collect()
        };
        assert_eq!(told(0.2, 1.1), ["2 s", "5 s", "10 s"]);
        assert_eq!(told(-2.0, 1.0), ["0.01 s", "0.1 s", "1 s", "10 s"]);
        assert_eq!(told(-0.75, 0.0), ["0.2 s", "0.5 s", "1 s"]);
        assert!(marks((f64::NEG_INFINITY, 0.0)).is_empty() && marks((0.0, f64::NAN)).is_empty());
    }
}
