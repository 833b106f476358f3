//! How wrong the picture is, what less would cost, and the way there.

use super::{Commands, Model, error_chart};
use crate::accuracy::{DARKEST, ErrorBudget, Estimate, LEVELS};
use crate::solve::Stage;
use crate::study::Goal;
use crate::ui::auditor::Ask;
use crate::ui::command::Command;
use crate::ui::state::Quantity;
use crate::ui::{theme, units};
use egui::{Color32, RichText, Sense, Stroke, pos2, vec2};

/// Shows the budget, the chart and the goal.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let auditor = model.auditor;
    if model.scene.is_none() {
        super::no_scene(ui, model, "Open a scene to see how exact its light is.");
        return;
    }
    ui.spacing_mut().item_spacing.y = 3.0;
    headline(ui, model, out);
    spread(ui, auditor.budget.as_ref(), model, out);
    bars(ui, auditor.budget.as_ref(), model);
    goal(ui, model, out);
    error_chart::show(ui, model, out);
    // What comes and goes has its room kept, so that nothing below moves under the cursor.
    let top = ui.cursor().top();
    verdict(ui, model);
    if let Some(told) = auditor.foresight() {
        ui.label(RichText::new(told).small().color(theme::TEXT));
    }
    if let Some(advice) = auditor.advice() {
        let text = format!("Best way to a smaller error: {advice}.");
        ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
    }
    let left = TOLD - (ui.cursor().top() - top);
    ui.add_space(left.max(0.0));
}

/// Height that the verdict, what is foreseen and the advice usually take together, points.
const TOLD: f32 = 2.0 * 17.0;

/// The error in one number, or why there is none yet, and the switch.
fn headline(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let auditor = model.auditor;
    ui.horizontal(|ui| {
        let verdict = super::verdict::of(model);
        let label = if verdict.error.is_empty() {
            let is_unlit = model.snapshot.stage == Stage::Unlit;
            let word = if is_unlit { "No light to check" } else { "Known once the light has settled" };
            ui.label(RichText::new(word).color(theme::TEXT_WEAK))
        } else {
            let mut letters = verdict.error.chars();
            let word: String = letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect();
            ui.label(RichText::new(word).color(verdict.colour))
        };
        if let Some(budget) = &auditor.budget {
            label.on_hover_text(format!(
                "Root mean square over the receiving area of what the illuminance as shown is off by, of the light \
                 there, or of its mean of {} lx where that is more.\n95 %: {} to {}. {} receivers, {} rays, {}.\n\
                 Of the mean everywhere, bright places beside lamps included: {}.",
                units::digits(crate::scene::LUMINOUS_EFFICACY * budget.mean_irradiance),
                percent(budget.total.low),
                percent(budget.total.high),
                units::count(budget.receivers),
                units::count(budget.rays as usize),
                units::duration(budget.seconds),
                percent(budget.of_mean.error),
            ));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let mut on = auditor.on;
            let tip = "Check pictures in the background by independent rays, on one thread";
            if ui.checkbox(&mut on, "check").on_hover_text(tip).changed() {
                out.push(Command::Accuracy(Ask::Switch(on)));
            }
        });
    });
}

/// Colours of the shares of the area, from exact to wrong.
const SHARES: [Color32; LEVELS.len() + 1] = [
    Color32::from_rgb(112, 150, 120),
    Color32::from_rgb(158, 160, 100),
    Color32::from_rgb(214, 160, 74),
    Color32::from_rgb(176, 84, 66),
];

/// How the error is spread over the area, where most of it sits, and the map. Without a check as high as
/// with one, so that nothing moves when it comes.
fn spread(ui: &mut egui::Ui, budget: Option<&ErrorBudget>, model: &Model<'_>, out: &mut Commands) {
    let spread = budget.map(|budget| &budget.spread);
    let told = spread.map_or("-".to_owned(), |s| percent(s.median.value));
    let (colour, weak) = if spread.is_some() {
        (theme::TEXT, theme::TEXT_WEAK)
    } else {
        (theme::TEXT_FAINT, theme::TEXT_FAINT)
    };
    let label = ui.label(RichText::new(format!("Half the area is off by less than {told}")).color(colour));
    if let Some(spread) = spread {
        label.on_hover_text(format!(
            "Median over the area of what the illuminance as shown is off by, of the illuminance at each place itself \
             (at least {:.0} % of the mean).\n95 %: {} to {}. The noise of the rays counts as error here.",
            100.0 * DARKEST,
            percent(spread.median.low),
            percent(spread.median.high)
        ));
    }

    let (bar, response) = ui.allocate_exact_size(vec2(ui.available_width(), 8.0), Sense::hover());
    ui.painter().rect_filled(bar, 0.0, Color32::from_gray(44));
    let share = |s: f64| format!("{:.0} %", 100.0 * s);
    let mut shares = LEVELS.map(|_| "-".to_owned());
    if let Some(spread) = spread {
        let ends = spread.within.map(|w| w.value).into_iter().chain([1.0]);
        let mut from = 0.0;
        for (to, colour) in ends.zip(SHARES) {
            let x = |share: f64| bar.left() + bar.width() * share as f32;
            let part = egui::Rect::from_x_y_ranges(x(from)..=x(to), bar.y_range());
            ui.painter().rect_filled(part, 0.0, colour);
            from = to;
        }
        let lines = spread.within.iter().zip(LEVELS).map(|(w, level)| {
            let [value, low, high] = [w.value, w.low, w.high].map(share);
            format!("{value} of the area within {} of its light (95 %: {low} to {high})", share(level))
        });
        response.on_hover_text(lines.collect::<Vec<_>>().join("\n"));
        shares = spread.within.map(|w| share(w.value));
    }
    let [one, five, ten] = shares;
    let text = format!("area within 1 %: {one}, 5 %: {five}, 10 %: {ten}");
    ui.label(RichText::new(text).small().color(weak));

    ui.horizontal(|ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let display = model.edits.display;
            let shown = display.quantity == Quantity::Error;
            let button = egui::Button::selectable(shown, RichText::new("Map").small());
            let button = ui.add(button).on_hover_text(Quantity::Error.explanation());
            if button.accessible_name("Map of the error").clicked() {
                let quantity = if shown { Quantity::Picture } else { Quantity::Error };
                out.push(Command::SetDisplay(display.showing(quantity)));
            }
            let dominant = spread.and_then(|spread| spread.dominant);
            let Some(most) = dominant.filter(|d| d.share > 0.3 && d.share > 3.0 * d.area) else {
                return;
            };
            let button = ui.small_button("Go").on_hover_text("Go to the patch that adds most to the error");
            if button.accessible_name("Go to the largest error").clicked() {
                out.push(Command::JumpToPatch(most.patch));
            }
            let name = model.scene.and_then(|s| s.objects.get(most.object as usize));
            let name = name.map_or("one object", String::as_str);
            let text = format!("{} of squared error: {name}", share(most.share));
            let tip = format!(
                "{name} has {} of the area and {} of the squared error.",
                percent(most.area),
                share(most.share)
            );
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let label = egui::Label::new(RichText::new(text).small().color(theme::TEXT_WEAK));
                ui.add(label.truncate()).on_hover_text(tip);
            });
        });
    });
}

/// Four bars with their intervals, on one scale.
fn bars(ui: &mut egui::Ui, budget: Option<&ErrorBudget>, model: &Model<'_>) {
    let none = Estimate::default();
    let t = &model.snapshot.timings;
    let rows = [
        ("direct light", budget.map_or(none, |b| b.direct), t.elements),
        ("form factors", budget.map_or(none, |b| b.form_factors), t.rows + t.balance),
        ("patches", budget.map_or(none, |b| b.mesh), t.mesh),
        ("solver", budget.map_or(none, |b| b.solver.estimate), t.sweeps),
    ];
    let top = rows.iter().map(|r| r.1.high).filter(|h| h.is_finite()).fold(1e-6, f64::max);
    for (name, estimate, seconds) in rows {
        ui.horizontal(|ui| {
            let (name_rect, _) = ui.allocate_exact_size(vec2(78.0, 16.0), Sense::hover());
            let painter = ui.painter().clone();
            let font = egui::TextStyle::Body.resolve(ui.style());
            let (left, middle) = (egui::Align2::LEFT_CENTER, name_rect.left_center());
            painter.text(middle, left, name, font, theme::TEXT_WEAK);
            let width = (ui.available_width() - 62.0).max(40.0);
            let (bar, response) = ui.allocate_exact_size(vec2(width, 10.0), Sense::hover());
            let at = |share: f64| bar.left() + bar.width() * (share / top).clamp(0.0, 1.0) as f32;
            painter.rect_filled(bar, 2.0, Color32::from_gray(44));
            if budget.is_some() {
                let full = egui::Rect::from_min_max(bar.min, pos2(at(estimate.error), bar.bottom()));
                painter.rect_filled(full, 2.0, theme::ACCENT);
                let stroke = Stroke::new(1.5, theme::TEXT);
                let (low, high, y) = (at(estimate.low), at(estimate.high), bar.center().y);
                painter.line_segment([pos2(low, y), pos2(high, y)], stroke);
                for x in [low, high] {
                    painter.line_segment([pos2(x, y - 3.0), pos2(x, y + 3.0)], stroke);
                }
                response.on_hover_text(format!(
                    "95 %: {} to {}; {} spent",
                    percent(estimate.low),
                    percent(estimate.high),
                    units::duration(seconds)
                ));
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let text = if budget.is_some() { percent(estimate.error) } else { "-".to_owned() };
                ui.label(RichText::new(text).color(theme::TEXT));
            });
        });
    }
}

/// The error or the time that the user names, and the button that goes for it.
fn goal(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let auditor = model.auditor;
    let (by_time, value) = match auditor.goal {
        Goal::Error(error) => (false, 100.0 * error),
        Goal::Seconds(seconds) => (true, seconds),
    };
    ui.horizontal(|ui| {
        for (time, label, start) in
            [(false, "To error", Goal::Error(0.01)), (true, "In time", Goal::Seconds(5.0))]
        {
            if ui.selectable_label(by_time == time, label).clicked() && by_time != time {
                out.push(Command::Accuracy(Ask::SetGoal(start)));
            }
        }
    });
    ui.horizontal(|ui| {
        let mut new = value;
        let (range, suffix, name) = if by_time {
            (0.5..=600.0, " s", "Time to solve in")
        } else {
            (0.1..=20.0, " %", "Error to reach")
        };
        ui.spacing_mut().slider_width = (ui.available_width() - 150.0).max(60.0);
        let slider = egui::Slider::new(&mut new, range)
            .logarithmic(true)
            .suffix(suffix)
            .custom_formatter(|v, _| units::digits(v));
        if ui.add(slider).accessible_name(name).changed() && new != value {
            let goal = if by_time { Goal::Seconds(new) } else { Goal::Error(new / 100.0) };
            out.push(Command::Accuracy(Ask::SetGoal(goal)));
        }
        let is_settled = model.snapshot.stage == Stage::Converged;
        let ready = auditor.budget.is_some() && !auditor.is_reaching() && is_settled;
        let button = ui.add_enabled(ready, egui::Button::new("Reach it"));
        let tip = "Choose patches and lines, solve, check, and refine until it is reached; \
                   every step refines the light of the last";
        if button.on_hover_text(tip).clicked() {
            out.push(Command::Accuracy(Ask::Reach));
        }
    });
}

/// How far the way to the goal has come, or how it ended.
fn verdict(ui: &mut egui::Ui, model: &Model<'_>) {
    let auditor = model.auditor;
    let told = match (auditor.is_reaching(), auditor.verdict.as_str()) {
        (true, _) if auditor.is_busy() => "On the way: checking",
        (true, _) => "On the way: solving",
        (false, verdict) => verdict,
    };
    if !told.is_empty() {
        ui.label(RichText::new(told).small().color(theme::TEXT_WEAK));
    }
}

/// A share in percent.
pub(super) fn percent(share: f64) -> String {
    if !share.is_finite() {
        "unknown".to_owned()
    } else if share > 0.0 && share < 1e-5 {
        "< 0.001 %".to_owned()
    } else {
        format!("{} %", units::digits(100.0 * share))
    }
}
