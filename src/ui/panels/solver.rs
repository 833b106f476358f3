//! How far the light has settled, and with what it is computed.

use super::{Commands, Model, empty};
use crate::form_factors::{Method, ReceivingPoints};
use crate::mesh::PatchTarget;
use crate::session::Snapshot;
use crate::solve::{SolveSettings, Stage};
use crate::solver::{Power, SweepReport};
use crate::ui::command::Command;
use crate::ui::{theme, units};
use egui::{Color32, ComboBox, ProgressBar, RichText};

/// The state of the solve in one word, with its colour.
pub(in crate::ui) fn state_of(snapshot: &Snapshot) -> (&'static str, Color32) {
    if snapshot.paused && is_running(snapshot.stage) {
        return ("Paused", theme::WARNING);
    }
    match snapshot.stage {
        Stage::Idle => ("Idle", theme::TEXT_WEAK),
        Stage::Loading => ("Loading", theme::ACCENT),
        Stage::Meshing => ("Meshing", theme::ACCENT),
        Stage::FirstLight => ("First light", theme::ACCENT),
        Stage::Elements => ("Direct light", theme::ACCENT),
        Stage::Rows => ("Solving", theme::ACCENT),
        Stage::Balancing => ("Balancing", theme::ACCENT),
        Stage::Sweeping => ("Settling", theme::ACCENT),
        Stage::Converged => ("Settled", theme::TEXT),
        Stage::Unlit => ("No lamps", theme::WARNING),
        Stage::Stopped => ("Stopped: light out of date", theme::WARNING),
        Stage::Failed => ("Failed", theme::FAILURE),
    }
}

/// Whether the worker still has something to do.
pub(in crate::ui) fn is_running(stage: Stage) -> bool {
    !matches!(stage, Stage::Idle | Stage::Converged | Stage::Unlit | Stage::Stopped | Stage::Failed)
}

/// What the button for a rest is called, what it tells, and what it asks for, where it asks for anything; a
/// solve that was stopped is taken up again.
pub(in crate::ui) fn pause(snapshot: &Snapshot) -> (&'static str, &'static str, Option<Command>) {
    let is_live = is_running(snapshot.stage) || matches!(snapshot.stage, Stage::Stopped | Stage::Unlit);
    let (name, tip, rest) = if snapshot.stage == Stage::Unlit {
        ("Solve anyway", "Compute form factors, though there is no light to spread", false)
    } else if snapshot.stage == Stage::Stopped {
        ("Solve", "Solve with the settings chosen (P)", false)
    } else if snapshot.paused {
        ("Resume", "Go on (P)", false)
    } else {
        ("Pause", "Let the solve rest (P)", true)
    };
    (name, tip, is_live.then_some(Command::Pause(rest)))
}

/// How far the solve has come, 0 to 1, or the reading and meshing before it, or what refines its light.
pub(in crate::ui) fn fraction_of(snapshot: &Snapshot) -> f64 {
    snapshot.refining.unwrap_or(snapshot.fraction).clamp(0.0, 1.0)
}

/// Seconds that the solve will still take, where it runs and they are worth a number.
pub(in crate::ui) fn time_left(snapshot: &Snapshot) -> Option<f64> {
    snapshot.seconds_left.filter(|&seconds| seconds >= 0.5 && !snapshot.paused)
}

/// Shows progress, residual and settings.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let snapshot = model.snapshot;
    let (word, colour) = state_of(snapshot);
    let running = is_running(snapshot.stage);
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.horizontal(|ui| {
        let state = ui.label(RichText::new(word).color(colour));
        if snapshot.stage == Stage::Converged {
            state.on_hover_text(
                "Further sweeps would change less than the tolerance. How far the picture is from the truth stands \
                 under Accuracy",
            );
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            if ui
                .add_enabled(running || snapshot.refining.is_some(), egui::Button::new("Stop"))
                .on_hover_text("End the solve or the refinement; the light so far stays")
                .clicked()
            {
                out.push(Command::Stop);
            }
            let (text, tip, command) = pause(snapshot);
            let button = ui.add_enabled(command.is_some(), egui::Button::new(text)).on_hover_text(tip);
            out.extend(command.filter(|_| button.clicked()));
            if snapshot.refining.is_some() {
                ui.add_space(4.0);
                ui.label(RichText::new("refining shadows").color(theme::TEXT_WEAK));
            }
            if let Some(left) = time_left(snapshot).filter(|_| running) {
                ui.add_space(4.0);
                ui.label(RichText::new(format!("{} left", units::estimate(left))).color(theme::TEXT_WEAK));
            }
        });
    });
    let bar = ProgressBar::new(fraction_of(snapshot) as f32).desired_height(8.0);
    ui.add(bar.fill(if running { theme::ACCENT } else { Color32::from_gray(80) }));
    numbers(ui, snapshot, model.power);
    residual_plot(ui, snapshot.sweeps());
    // One line, kept while there is nothing to say.
    let change = if model.last_change.is_empty() { " " } else { model.last_change };
    ui.add_space(2.0);
    ui.add(egui::Label::new(RichText::new(change).small().color(theme::TEXT_WEAK)).truncate());
    ui.collapsing("Method and quality", |ui| {
        settings(ui, &model.settings, out);
        let mut refine = model.state.refine_at_leisure;
        let tip = "While nothing else is to be done, shadows become finer, first where you look";
        if ui.checkbox(&mut refine, "Refine while idle").on_hover_text(tip).changed() {
            out.push(Command::RefineAtLeisure(refine));
        }
    });
    ui.collapsing("What it cost", |ui| costs(ui, model));
}

/// Seconds by stage and by effect.
fn costs(ui: &mut egui::Ui, model: &Model<'_>) {
    let snapshot = model.snapshot;
    let t = &snapshot.timings;
    for (name, seconds, tip) in [
        ("Meshing", t.mesh + t.plan, "Cutting surfaces into patches, and deciding effects"),
        ("Rows", t.rows, "Form factors: what each patch sees of all others"),
        ("Balancing", t.balance, "Making the rows reciprocal and closed"),
        ("Sweeping", t.sweeps, "Gauss-Seidel, with the power balance before each sweep"),
        ("Display", model.display_seconds, "From the lamps to the corners that are drawn, once"),
    ] {
        let told = if seconds > 0.0 { units::duration(seconds) } else { "-".to_owned() };
        theme::row(ui, name, told).on_hover_text(tip);
    }
    let Some(plan) = snapshot.plan().filter(|plan| !plan.decisions.is_empty()) else { return };
    theme::group_title(ui, "Effects of this scene");
    for decision in &plan.decisions {
        let on = plan.is_on(decision.effect);
        let mut why = format!("{}\n{}\n{}", decision.reason, decision.evidence, decision.predicted_cost);
        let mut state = if on { "on" } else { "off" }.to_owned();
        match decision.measured.filter(|_| on) {
            Some(cost) if cost.is_zero() => why += "\nwithout it this solve would not have been faster",
            Some(cost) => {
                let took = units::duration(cost.as_secs_f64());
                why += &format!("\nit took {took} of this solve");
                state += &format!(", {took}");
            }
            None => {}
        }
        theme::row(ui, decision.effect.name(), state).on_hover_text(why);
    }
}

/// Four lines that are there from the start, so that nothing below them moves when they fill.
fn numbers(ui: &mut egui::Ui, snapshot: &Snapshot, power: Power) {
    let none = || "-".to_owned();
    let (done, all) = snapshot.rows;
    let rows = if all > 0 { format!("{} of {}", units::count(done), units::count(all)) } else { none() };
    theme::row(ui, "Form-factor rows", rows);
    let last = snapshot.sweeps().last();
    let sweeps = last.map_or_else(none, |s| format!("{}, residual {:.1e}", s.sweep, s.residual));
    theme::row(ui, "Sweeps", sweeps)
        .on_hover_text("The residual is what the last sweep still changed, of all");
    let bound = last.map_or_else(none, |s| super::accuracy::percent(s.error_bound));
    theme::row(ui, "Left to settle, at most", bound).on_hover_text(
        "What all further sweeps could still change, of the largest reflected radiosity: a guaranteed bound. The \
         errors of patches and form factors are not part of it",
    );
    let escaped = (power.emitted - power.absorbed).max(0.0);
    // Less is what single precision and the last sweep leave.
    let escaped = if escaped > 1e-4 * power.emitted { units::digits(escaped) } else { "0".to_owned() };
    let [emitted, absorbed] = [power.emitted, power.absorbed].map(units::digits);
    let told = last.map_or_else(none, |_| format!("{emitted} W, {escaped} W escapes"));
    let told = theme::row(ui, "Power", told);
    if last.is_some() {
        told.on_hover_text(format!(
            "{emitted} W of light emitted by the lamps as they stand, {absorbed} W absorbed by surfaces, {escaped} W \
             leaves through openings"
        ));
    }
}

/// Height of the plot of the residual, and of the place kept for it, points.
const PLOT_HEIGHT: f32 = 54.0;

fn residual_plot(ui: &mut egui::Ui, sweeps: &[SweepReport]) {
    if sweeps.len() < 2 {
        let (place, _) =
            ui.allocate_exact_size(egui::vec2(ui.available_width(), PLOT_HEIGHT), egui::Sense::hover());
        ui.painter().rect_filled(place, 2.0, ui.visuals().extreme_bg_color);
        let (text, font) = ("Residual by sweep", egui::TextStyle::Small.resolve(ui.style()));
        ui.painter().text(place.center(), egui::Align2::CENTER_CENTER, text, font, theme::TEXT_FAINT);
        return;
    }
    let logs: Vec<[f64; 2]> = sweeps
        .iter()
        .filter(|s| s.residual > 0.0)
        .map(|s| [f64::from(s.sweep), s.residual.log10()])
        .collect();
    let [low, high] = decades(logs.iter().map(|point| point[1]));
    let points = egui_plot::PlotPoints::from(logs);
    theme::plot("residual by sweep", PLOT_HEIGHT)
        .show_x(false)
        .show_y(false)
        // Its labels come and go with the number of sweeps, which stands above.
        .show_axes([false, true])
        .custom_y_axes(vec![
            egui_plot::AxisHints::new_y()
                // Wide enough for every label from the first frame on.
                .min_thickness(38.0)
                .label_spacing(egui::Rangef::new(9.0, 9.5))
                .tick_label_color(theme::TEXT_WEAK)
                .tick_label_font(egui::FontId::proportional(11.0))
                .formatter(|mark, _| format!("1e{:.0}", mark.value)),
        ])
        .include_y(low)
        .include_y(high)
        .y_grid_spacer(move |_| {
            // Whole decades alone, few enough for their labels to stand apart.
            let step = ((high - low) / 3.0).ceil().max(1.0);
            let count = ((high - low) / step) as usize;
            let mark = |k: usize| egui_plot::GridMark { value: low + k as f64 * step, step_size: step };
            (0..=count).map(mark).collect()
        })
        .show(ui, |plot| {
            plot.line(egui_plot::Line::new("residual", points).color(theme::ACCENT).width(1.5));
        });
}

/// Whole decades below and above all of these logarithms, at least one apart.
fn decades(logs: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
    if low > high { [-1.0, 0.0] } else { [low.floor(), high.ceil().max(low.floor() + 1.0)] }
}

/// Factors on the default resolution, with their names.
const QUALITIES: [(&str, f64); 4] = [("Draft", 0.5), ("Normal", 1.0), ("Fine", 2.0), ("Very fine", 4.0)];
/// Patch counts offered besides the scene's own.
const COUNTS: [usize; 6] = [1_000, 2_500, 5_000, 10_000, 20_000, 50_000];

fn settings(ui: &mut egui::Ui, now: &SolveSettings, out: &mut Commands) {
    let mut new = now.clone();
    combo(ui, "Form factors", method_name(now.method), |ui| {
        for method in Method::ALL {
            if ui.selectable_label(now.method == method, method_name(method)).clicked() {
                new.method = method;
                new.resolution = None;
            }
        }
    });
    let default = f64::from(now.method.default_resolution());
    let factor = now.resolution.map_or(1.0, |r| f64::from(r) / default);
    let quality = QUALITIES.iter().find(|(_, f)| (f - factor).abs() < 0.01);
    let resolution = now.resolution.unwrap_or(now.method.default_resolution());
    let text = quality.map_or_else(|| resolution.to_string(), |(name, _)| (*name).to_owned());
    combo(ui, "Quality", &text, |ui| {
        for (name, f) in QUALITIES {
            let resolution = (default * f) as u32;
            let label = format!("{name} ({resolution})");
            if ui.selectable_label((f - factor).abs() < 0.01, label).clicked() {
                new.resolution = if f == 1.0 { None } else { Some(resolution) };
            }
        }
    });
    combo(ui, "Points", points_name(now.points), |ui| {
        for points in ReceivingPoints::ALL {
            if ui.selectable_label(now.points == points, points_name(points)).clicked() {
                new.points = points;
            }
        }
    });
    let text = match now.patches {
        PatchTarget::Auto => "Chosen for the scene".to_owned(),
        PatchTarget::Size(metres) => format!("{} m each", units::digits(metres)),
        PatchTarget::Count(n) => format!("about {}", units::count(n)),
        PatchTarget::AsGiven => "One per polygon".to_owned(),
    };
    combo(ui, "Patches", &text, |ui| {
        let auto = (PatchTarget::Auto, "Chosen for the scene".to_owned());
        let given = (PatchTarget::AsGiven, "One per polygon".to_owned());
        let counts = COUNTS.map(|n| (PatchTarget::Count(n), format!("about {}", units::count(n))));
        for (target, label) in [auto, given].into_iter().chain(counts) {
            if ui.selectable_label(now.patches == target, label).clicked() {
                new.patches = target;
            }
        }
    });
    if now.refinement.is_some() {
        let tip =
            "Smaller patches where checks on the way to a goal found errors; unticked all are alike again";
        let ticked = ui.checkbox(&mut true, "Finer where the picture was wrong").on_hover_text(tip);
        if ticked.clicked() {
            new.refinement = None;
        }
    }
    combo(ui, "Tolerance", &format!("{:.0e}", now.tolerance), |ui| {
        for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            if ui.selectable_label(now.tolerance == tolerance, format!("{tolerance:.0e}")).clicked() {
                new.tolerance = tolerance;
            }
        }
    });
    if new != *now {
        out.push(Command::Solve(new));
    }
}

fn method_name(method: Method) -> &'static str {
    match method {
        Method::Lines => "Lines",
        Method::Hemicube => "Hemicube",
        Method::AlignedHemicube => "Hemicube (1985)",
        Method::Rays => "Rays",
    }
}

fn points_name(points: ReceivingPoints) -> &'static str {
    match points {
        ReceivingPoints::Auto => "Chosen for each patch",
        ReceivingPoints::One => "1 per patch",
        ReceivingPoints::Four => "4 per patch",
        ReceivingPoints::Sixteen => "16 per patch",
    }
}

/// A named choice whose box stands at the right edge.
pub(in crate::ui) fn combo(ui: &mut egui::Ui, name: &str, text: &str, contents: impl FnOnce(&mut egui::Ui)) {
    ui.horizontal(|ui| {
        let label = ui.label(RichText::new(name).color(theme::TEXT_WEAK));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let shown = ComboBox::from_id_salt(name).selected_text(text).width(138.0).show_ui(ui, contents);
            shown.response.labelled_by(label.id);
        });
    });
}

/// A sentence for an empty solver section.
pub(in crate::ui) fn show_or_hint(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    if model.snapshot.stage == Stage::Idle && model.scene.is_none() {
        empty(ui, "Open a scene to see its light settle.");
    } else {
        show(ui, model, out);
    }
}

#[cfg(test)]
mod tests {
    use super::decades;

    #[test]
    fn a_plot_spans_whole_decades() {
        assert_eq!(decades([-1.3, -4.7].into_iter()), [-5.0, -1.0]);
        assert_eq!(decades([-2.6, -2.4].into_iter()), [-3.0, -2.0]);
        assert_eq!(decades([-3.0].into_iter()), [-3.0, -2.0]);
        assert_eq!(decades(std::iter::empty()), [-1.0, 0.0]);
    }
}
