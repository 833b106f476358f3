//! How wrong the picture is, what less would cost, and the way there.

use super::{Commands, Model, empty};
use crate::accuracy::{ErrorBudget, Estimate};
use crate::session::Stage;
use crate::study::Goal;
use crate::ui::auditor::{Ask, Finished, nearest};
use crate::ui::command::Command;
use crate::ui::{theme, units};
use egui::{Color32, RichText, Sense, Stroke, pos2, vec2};
use egui_plot::{HoverPosition, Line, MarkerShape, Plot, PlotPoints, Points, VLine};

/// Shows the budget, the chart and the goal.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let auditor = model.auditor;
    if model.scene.is_none() {
        empty(ui, "Open a scene to see how exact its light is.");
        return;
    }
    ui.horizontal(|ui| {
        let word = match (&auditor.budget, model.snapshot.stage) {
            (Some(budget), _) => format!("Error {}", percent(budget.total.error)),
            (None, Stage::Converged) if !auditor.on => "Not checked".to_owned(),
            (None, Stage::Converged) if auditor.is_dark => "No light to check".to_owned(),
            (None, Stage::Converged) => "Checking by rays".to_owned(),
            (None, _) => "Known once the light has settled".to_owned(),
        };
        let colour = if auditor.budget.is_some() { theme::ACCENT } else { theme::TEXT_WEAK };
        let label = ui.label(RichText::new(word).color(colour));
        if let Some(budget) = &auditor.budget {
            label.on_hover_text(format!(
                "RMS of illuminance as shown, of its mean of {} lx.\n95 %: {} to {}. {} receivers, {} rays, {}.\n\
                 Relative to the light at each bright place: {}.",
                units::digits(crate::scene::LUMINOUS_EFFICACY * budget.mean_irradiance),
                percent(budget.total.low),
                percent(budget.total.high),
                units::count(budget.receivers),
                units::count(budget.rays as usize),
                units::duration(budget.seconds),
                percent(budget.local.error),
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
    bars(ui, auditor.budget.as_ref(), model);
    chart(ui, model, out);
    if let Some(told) = auditor.foresight() {
        ui.label(RichText::new(told).small().color(theme::TEXT));
    }
    if let Some(advice) = auditor.advice() {
        let text = format!("Next seconds are best spent on {advice}.");
        ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
    }
    goal(ui, model, out);
}

/// Three bars with their intervals, on one scale.
fn bars(ui: &mut egui::Ui, budget: Option<&ErrorBudget>, model: &Model<'_>) {
    let none = Estimate::default();
    let t = &model.snapshot.timings;
    let rows = [
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

fn chart(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let auditor = model.auditor;
    let place = |f: &Finished| {
        let error = f.budget.map(|b| b.total.error).filter(|&e| e > 0.0)?;
        (f.seconds > 0.0).then(|| [f.seconds.log10(), (100.0 * error).log10()])
    };
    let known: Vec<[f64; 2]> = auditor.finished.iter().filter_map(place).collect();
    if known.is_empty() {
        return;
    }
    let foreseen: Vec<[f64; 2]> =
        auditor.curve.iter().map(|[s, e]| [s.log10(), (100.0 * e).log10()]).collect();
    let current = auditor.finished.last().and_then(place);
    let t = &model.snapshot.timings;
    let elapsed = t.mesh + t.plan + t.rows + t.balance + t.sweeps;
    let running = super::solver::is_running(model.snapshot.stage) && elapsed > 0.0;
    let decade = |value: f64, unit: &str| {
        let exponent = value.round();
        if (value - exponent).abs() < 1e-6 {
            format!("{:.*} {unit}", (-exponent).max(0.0) as usize, 10.0_f64.powf(exponent))
        } else {
            String::new()
        }
    };
    let response = Plot::new("error against seconds")
        .height(132.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .set_margin_fraction(vec2(0.08, 0.12))
        .x_axis_formatter(move |mark, _| decade(mark.value, "s"))
        .y_axis_formatter(move |mark, _| decade(mark.value, "%"))
        .label_formatter(|hover| match hover {
            HoverPosition::NearDataPoint { position, .. } => {
                let found = nearest(model, [position.x, position.y])?;
                Some(format!("{}\nclick to solve so again", describe(found)))
            }
            HoverPosition::Elsewhere { .. } => None,
        })
        .show(ui, |plot| {
            if foreseen.len() > 1 {
                let line = Line::new("foreseen", PlotPoints::from(foreseen));
                plot.line(
                    line.color(theme::TEXT_WEAK).width(1.2).style(egui_plot::LineStyle::dashed_loose()),
                );
            }
            plot.points(
                Points::new("solves", PlotPoints::from(known))
                    .color(theme::TEXT_WEAK)
                    .radius(3.0)
                    .filled(true),
            );
            if let Some(current) = current {
                let marker = Points::new("on screen", PlotPoints::from(vec![current]));
                plot.points(marker.color(theme::ACCENT).shape(MarkerShape::Diamond).radius(5.5).filled(true));
            }
            if running {
                plot.vline(VLine::new("now", elapsed.log10()).color(theme::ACCENT).width(1.0));
            }
        });
    let clicked = response.response.interact_pointer_pos().filter(|_| response.response.clicked());
    if let Some(at) = clicked {
        let value = response.transform.value_from_position(at);
        if let Some(found) = nearest(model, [value.x, value.y])
            && found.settings != model.snapshot.settings
        {
            out.push(Command::Solve(found.settings.clone()));
        }
    }
}

/// A solve in one line.
fn describe(found: &Finished) -> String {
    let settings = &found.settings;
    let resolution = settings.resolution.unwrap_or_else(|| settings.method.default_resolution());
    let error = found.budget.map_or("-".to_owned(), |b| percent(b.total.error));
    format!(
        "{} patches, {} {resolution}: {error} in {}",
        units::count(found.patches),
        settings.method.name(),
        units::duration(found.seconds)
    )
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
        let ready = auditor.budget.is_some() && !auditor.is_reaching();
        let button = ui.add_enabled(ready, egui::Button::new("Reach it"));
        let tip = "Choose patches and lines, solve, check, and refine until it is reached";
        if button.on_hover_text(tip).clicked() {
            out.push(Command::Accuracy(Ask::Reach));
        }
    });
    let told = match (auditor.is_reaching(), auditor.verdict.as_str()) {
        (true, _) if auditor.is_busy() => "On the way: checking",
        (true, _) => "On the way: solving",
        (false, verdict) => verdict,
    };
    if !told.is_empty() {
        ui.label(RichText::new(told).small().color(theme::TEXT_WEAK));
    }
}

fn percent(share: f64) -> String {
    if !share.is_finite() {
        "unknown".to_owned()
    } else if share > 0.0 && share < 1e-5 {
        "< 0.001 %".to_owned()
    } else {
        format!("{} %", units::digits(100.0 * share))
    }
}
