use super::failure::Failure;
use super::progress::ProgressLine;
use super::text;
use crate::validate::{self, Case, Outcome};
use clap::Args;
use std::time::Instant;

/// Compare this machine's results with closed forms and published solutions
///
/// Prints each case with its source, the expected and the computed value, and the verdict. Exits
/// with 1 where a case is off by more than it may be.
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// Run only cases whose name holds this text, whatever its case (may be repeated)
    #[arg(long = "case", value_name = "NAME")]
    cases: Vec<String>,
    /// Print a table for a report in Markdown, with the reasons of the tolerances
    #[arg(long)]
    markdown: bool,
}

/// A case and what came of it, a way each.
struct Judged {
    case: Case,
    outcomes: Vec<Outcome>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let wanted: Vec<String> = arguments.cases.iter().map(|c| c.to_lowercase()).collect();
    let mut cases = validate::cases();
    if !wanted.is_empty() {
        cases.retain(|case| wanted.iter().any(|w| case.name.to_lowercase().contains(w)));
    }
    if cases.is_empty() {
        return Err(Failure::input(format!(
            "no case's name holds '{}'; lumenwalk validate without --case lists them all",
            arguments.cases.join("' or '")
        )));
    }
    let clock = Instant::now();
    let mut line = ProgressLine::new();
    let all = cases.len();
    let mut judged = Vec::with_capacity(all);
    for (index, case) in cases.into_iter().enumerate() {
        line.part("validating", index, all, &case.name);
        let outcomes = case.ways.iter().map(|&(way, _)| case.run(way)).collect();
        judged.push(Judged { case, outcomes });
    }
    drop(line);
    let table = if arguments.markdown { markdown(&judged) } else { plain(&judged) };
    text::print(&format!("{table}\n{}", conclusion(&judged, clock.elapsed().as_secs_f64())))?;
    if judged.iter().flat_map(|j| &j.outcomes).any(|o| !o.passed) { Err(Failure::Told) } else { Ok(()) }
}

/// Expected values are known to as many digits as are shown.
fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.9}")
    } else {
        format!("{value:.8e}")
    }
}

/// Way, computed value, relative error, allowed error, verdict.
fn cells(outcome: &Outcome) -> [String; 5] {
    let (computed, error) = match (&outcome.computed, outcome.error) {
        (Ok(value), Some(error)) => (number(*value), format!("{error:+.1e}")),
        (Ok(value), None) => (number(*value), "-".into()),
        (Err(error), _) => (error.to_string(), "-".into()),
    };
    let verdict = if outcome.passed { "ok" } else { "FAILED" };
    [outcome.way.name().into(), computed, error, format!("{:.0e}", outcome.tolerance), verdict.into()]
}

/// Group by group: a line a case, and under it a line a way.
fn plain(judged: &[Judged]) -> String {
    let mut out = String::new();
    let mut group = None;
    for Judged { case, outcomes } in judged {
        if group != Some(case.group) {
            out +=
                &format!("{}{}\n", if group.is_some() { "\n" } else { "" }, case.group.name().to_uppercase());
            group = Some(case.group);
        }
        out += &format!("{}\n    {}: {}\n", case.name, case.source, number(case.expected));
        for outcome in outcomes {
            let [way, computed, error, allowed, verdict] = cells(outcome);
            out += &format!("      {way:9} {computed:>16}  {error:>8}  of {allowed:>5}  {verdict}\n");
        }
    }
    out
}

/// One row a case and way.
fn markdown(judged: &[Judged]) -> String {
    let mut out = String::from(
        "| case | source | expected | by | computed | relative error | allowed | verdict |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let mut reasons: Vec<(&str, &str)> = Vec::new();
    for Judged { case, outcomes } in judged {
        for outcome in outcomes {
            let head = [case.name.clone(), case.source.to_owned(), number(case.expected)];
            let row: Vec<String> = head.into_iter().chain(cells(outcome)).collect();
            out += &format!("| {} |\n", row.join(" | "));
        }
        if !reasons.iter().any(|r| r.1 == case.reason) {
            reasons.push((&case.name, case.reason));
        }
    }
    out += "\nTolerances, by the first case that has each:\n\n";
    for (name, reason) in reasons {
        out += &format!("- {name}: {reason}\n");
    }
    out
}

fn conclusion(judged: &[Judged], seconds: f64) -> String {
    let outcomes = || judged.iter().flat_map(|j| &j.outcomes);
    let failed: Vec<&str> = judged
        .iter()
        .filter(|j| j.outcomes.iter().any(|o| !o.passed))
        .map(|j| j.case.name.as_str())
        .collect();
    let mut out = format!(
        "{} by {}: {} ok, {} failed, in {}\n",
        text::count(judged.len(), "case"),
        text::count(outcomes().count(), "computation"),
        outcomes().filter(|o| o.passed).count(),
        outcomes().filter(|o| !o.passed).count(),
        text::seconds(seconds),
    );
    for name in failed {
        out += &format!("failed: {name}\n");
    }
    out
}
