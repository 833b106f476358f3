use super::failure::Failure;
use super::progress::ProgressLine;
use super::text;
use crate::accuracy::{AuditSettings, ErrorBudget, Estimate, LEVELS, Ranged};
use crate::effects::EffectChoices;
use crate::export::{
    AccuracyReport, AreaReport, AttemptReport, DominantReport, ErrorReport, GoalReport, RangeReport,
};
use crate::scene::{LUMINOUS_EFFICACY, Lighting, Scene};
use crate::solve::{Control, Solution, Timings};
use crate::study::{self, Goal, News, Outlook, Reached, Task};
use std::sync::Arc;
use std::time::Instant;

/// Audits a finished solve; `None` where no light arrives.
pub(super) fn audit(solved: &Solution, lighting: &Lighting) -> Option<ErrorBudget> {
    study::audit(solved, lighting, &AuditSettings::default(), &|| false).map(|found| found.budget)
}

/// Tells on standard error where work stands.
fn tell(line: &mut ProgressLine, news: &News<'_>) -> Control {
    match news {
        News::Solving(progress) => line.solve(progress),
        News::Auditing => line.audit(),
    }
    Control::Continue
}

/// Solves to a goal with progress on standard error.
pub(super) fn reach(task: &Task<'_>, started: Instant) -> Result<Reached, Failure> {
    let mut line = ProgressLine::new();
    Ok(study::reach(task, started, study::memory(), &mut |news| tell(&mut line, &news))?)
}

/// What solves of a scene will take, from a small one, with progress on standard error; `None` where no light arrives.
pub(super) fn outlook(scene: &Arc<Scene>, effects: &EffectChoices) -> Result<Option<Outlook>, Failure> {
    let mut line = ProgressLine::new();
    Ok(Outlook::of(scene, &scene.lighting(), effects, study::memory(), &mut |news| tell(&mut line, &news))?)
}

/// The budget in a few lines.
pub(super) fn lines(budget: &ErrorBudget, scene: &Scene) -> String {
    let line = |name: &str, e: Estimate| {
        vec![format!("  {name}"), percent(e.error), format!("({} to {})", percent(e.low), percent(e.high))]
    };
    let rows = [
        line("direct light", budget.direct),
        line("form factors", budget.form_factors),
        line("patches", budget.mesh),
        line("solver", budget.solver.estimate),
        line("in all, as shown", budget.total),
        line("patch averages", budget.averages),
        line("in all, of the mean", budget.of_mean),
    ];
    format!(
        "error of irradiance, RMS, of the light there or of the mean of {} lx where that is more ({}, {} rays, {}):\n{}",
        text::significant(LUMINOUS_EFFICACY * budget.mean_irradiance),
        text::count(budget.receivers, "receiver"),
        text::thousands(budget.rays as usize),
        text::seconds(budget.seconds),
        text::table(&rows)
    ) + &spread_lines(budget, scene)
}

/// How the error is spread over the area, and where most of it sits.
fn spread_lines(budget: &ErrorBudget, scene: &Scene) -> String {
    let spread = &budget.spread;
    let shares = spread
        .within
        .iter()
        .zip(LEVELS)
        .map(|(within, level)| format!("{:.0} % within {:.0} %", 100.0 * within.value, 100.0 * level));
    let mut told = format!(
        "of the light at each place: half of the area is off by less than {}; {}\n",
        percent(spread.median.value),
        shares.collect::<Vec<_>>().join(", ")
    );
    if let Some(most) = spread.dominant {
        let name = scene.objects.get(most.object as usize).map_or("", String::as_str);
        told += &format!(
            "most of the squares: {:.0} % on {name}, {} of the area\n",
            100.0 * most.share,
            percent(most.area)
        );
    }
    told
}

/// The solves on the way to a goal and its verdict.
pub(super) fn verdict_lines(reached: &Reached) -> String {
    let mut rows =
        vec![["  patches", "lines", "seconds", "foreseen", "error", "foreseen"].map(String::from).to_vec()];
    for a in &reached.attempts {
        let unknown = || "-".to_owned();
        rows.push(vec![
            format!("  {}", text::thousands(a.patches)),
            a.lines.to_string(),
            format!("{:.2}", a.seconds),
            a.predicted_seconds.map_or_else(unknown, |s| format!("{s:.2}")),
            a.budget.map_or_else(unknown, |b| percent(b.total.error)),
            a.predicted_error.map_or_else(unknown, percent),
        ]);
    }
    format!("{}{}\n", text::table(&rows), reached.verdict)
}

/// `1.23 %` of a share.
pub(super) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{} %", text::significant(100.0 * share)) } else { "unknown".into() }
}

/// The budget as the report holds it, with what each error cost.
pub(super) fn report(
    budget: &ErrorBudget,
    scene: &Scene,
    timings: &Timings,
    goal: Option<(Goal, &Reached)>,
) -> AccuracyReport {
    let error = |e: Estimate, seconds: Option<f64>| ErrorReport {
        percent: 100.0 * e.error,
        low: 100.0 * e.low,
        high: Some(100.0 * e.high).filter(|h| h.is_finite()),
        seconds,
    };
    let range = |r: Ranged| RangeReport { value: 100.0 * r.value, low: 100.0 * r.low, high: 100.0 * r.high };
    AccuracyReport {
        direct_light: error(budget.direct, Some(timings.elements)),
        form_factors: error(budget.form_factors, Some(timings.rows + timings.balance)),
        patches: error(budget.mesh, Some(timings.mesh)),
        solver: error(budget.solver.estimate, Some(timings.sweeps)),
        solver_bound_percent: 100.0 * budget.solver.bound,
        as_shown: error(budget.total, None),
        patch_averages: error(budget.averages, None),
        of_the_mean: error(budget.of_mean, None),
        median_percent: range(budget.spread.median),
        area_within: budget
            .spread
            .within
            .iter()
            .zip(LEVELS)
            .map(|(within, level)| AreaReport { error_percent: 100.0 * level, area_percent: range(*within) })
            .collect(),
        dominant: budget.spread.dominant.map(|most| DominantReport {
            object: scene.objects.get(most.object as usize).cloned().unwrap_or_default(),
            percent_of_squares: 100.0 * most.share,
            percent_of_area: 100.0 * most.area,
            patch: most.patch,
        }),
        mean_illuminance_lx: LUMINOUS_EFFICACY * budget.mean_irradiance,
        receivers: budget.receivers,
        rays: budget.rays,
        audit_seconds: budget.seconds,
        goal: goal.map(|(goal, reached)| goal_report(goal, reached)),
    }
}

fn goal_report(goal: Goal, reached: &Reached) -> GoalReport {
    let (asked_percent, asked_seconds) = match goal {
        Goal::Error(error) => (Some(100.0 * error), None),
        Goal::Seconds(seconds) => (None, Some(seconds)),
    };
    let attempts = reached.attempts.iter().map(|a| AttemptReport {
        patches: a.patches,
        lines: a.lines,
        seconds: a.seconds,
        predicted_seconds: a.predicted_seconds,
        percent: a.budget.map(|b| 100.0 * b.total.error),
        predicted_percent: a.predicted_error.map(|e| 100.0 * e),
    });
    GoalReport {
        asked_percent,
        asked_seconds,
        met: reached.verdict.met(),
        complete: reached.complete,
        verdict: reached.verdict.to_string(),
        seconds: reached.seconds,
        attempts: attempts.collect(),
    }
}

/// `1%` or `0.01`: a share above zero and below one.
pub(super) fn error_goal(text: &str) -> Result<f64, String> {
    let trimmed = text.trim();
    let value = match trimmed.strip_suffix('%') {
        Some(number) => number.trim().parse::<f64>().map(|v| v / 100.0),
        None => trimmed.parse::<f64>(),
    };
    let value = value.ok().filter(|v| v.is_finite()).ok_or("a share is needed, as in 1% or 0.01")?;
    if (1e-5..1.0).contains(&value) { Ok(value) } else { Err("it must lie between 0.001% and 100%".into()) }
}

/// `5s`, `2min`, `500ms` or plain seconds.
pub(super) fn seconds_goal(text: &str) -> Result<f64, String> {
    let trimmed = text.trim();
    let units = [("ms", 1e-3), ("min", 60.0), ("h", 3600.0), ("s", 1.0), ("", 1.0)];
    let (number, unit) = units
        .iter()
        .find_map(|&(suffix, unit)| Some((trimmed.strip_suffix(suffix)?.trim(), unit)))
        .ok_or("a time is needed")?;
    let value =
        number.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or("a time is needed, as in 5s or 2min")?;
    let seconds = value * unit;
    if (0.01..=1e6).contains(&seconds) {
        Ok(seconds)
    } else {
        Err("it must lie between 10 ms and 277 h".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_read_with_their_units() {
        assert_eq!(error_goal("1%"), Ok(0.01));
        assert_eq!(error_goal(" 0.5 % "), Ok(0.005));
        assert_eq!(error_goal("0.02"), Ok(0.02));
        for bad in ["0", "100%", "-1%", "one", "%", "nan"] {
            assert!(error_goal(bad).is_err(), "{bad}");
        }
        for (text, seconds) in [("5s", 5.0), ("5", 5.0), ("2min", 120.0), ("500ms", 0.5), ("1 h", 3600.0)] {
            assert_eq!(seconds_goal(text), Ok(seconds), "{text}");
        }
        for bad in ["0", "s", "-5s", "5 days", "inf"] {
            assert!(seconds_goal(bad).is_err(), "{bad}");
        }
    }
}
