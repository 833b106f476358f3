use super::text;
use crate::accuracy::{AuditSettings, ErrorBudget, Estimate};
use crate::scene::{LUMINOUS_EFFICACY, Lighting};
use crate::session::Solved;
use crate::study;

/// Audits a finished solve; `None` where no light arrives.
pub(super) fn audit(solved: &Solved, lighting: &Lighting) -> Option<ErrorBudget> {
    study::audit(solved, lighting, &AuditSettings::default(), &|| false).map(|found| found.budget)
}

/// The budget in a few lines.
pub(super) fn budget_lines(budget: &ErrorBudget) -> String {
    let line = |name: &str, e: Estimate| {
        vec![format!("  {name}"), percent(e.error), format!("({} to {})", percent(e.low), percent(e.high))]
    };
    let rows = [
        line("form factors", budget.form_factors),
        line("patches", budget.mesh),
        line("solver", budget.solver.estimate),
        line("in all, as shown", budget.total),
        line("patch averages", budget.averages),
    ];
    format!(
        "error of irradiance, RMS of the mean of {} lx ({} receivers, {} rays, {}):\n{}",
        text::significant(LUMINOUS_EFFICACY * budget.mean_irradiance),
        text::thousands(budget.receivers),
        text::thousands(budget.rays as usize),
        text::seconds(budget.seconds),
        text::table(&rows)
    )
}

/// `1.23 %` of a share.
pub(super) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{} %", text::significant(100.0 * share)) } else { "unknown".into() }
}
