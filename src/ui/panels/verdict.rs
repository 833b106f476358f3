//! One verdict on the light: whether it has settled, and how near the picture is to the truth. The menu bar, the
//! solver and the accuracy section say it in the same words and colours.

use super::Model;
use super::accuracy::percent;
use super::solver::state_of;
use crate::accuracy::{ErrorBudget, LEVELS};
use crate::solve::Stage;
use crate::ui::theme;
use egui::Color32;

/// Largest error of a picture that is called accurate.
const ACCURATE: f64 = 0.02;
/// Largest error of one that is called good.
const GOOD: f64 = 0.05;
/// Largest error of one that is called fair; above it is rough.
const FAIR: f64 = 0.1;
/// Share of the area within 5 % of its light from which a large error is one of a few places.
const MOST_OF_IT: f64 = 0.8;

/// What is known of the light.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::ui) struct Verdict {
    /// Whether the light moves still.
    pub(in crate::ui) state: String,
    /// The error of the picture; empty while the light moves.
    pub(in crate::ui) error: String,
    pub(in crate::ui) colour: Color32,
}

impl Verdict {
    /// Both in one line.
    pub(in crate::ui) fn line(&self) -> String {
        if self.error.is_empty() { self.state.clone() } else { format!("{} · {}", self.state, self.error) }
    }
}

/// Judges the light on screen.
pub(in crate::ui) fn of(model: &Model<'_>) -> Verdict {
    let (snapshot, auditor) = (model.snapshot, model.auditor);
    let (state, colour) = state_of(snapshot);
    let is_settled = snapshot.stage == Stage::Converged;
    let has_no_lamps = model.scene.is_some_and(|scene| scene.luminaires.is_empty());
    let (error, colour) = match &auditor.budget {
        _ if !is_settled => (String::new(), colour),
        Some(budget) => {
            let (word, colour) = grade(budget);
            (format!("error {} ({word})", percent(budget.total.error)), colour)
        }
        None if !auditor.on => ("error not checked".to_owned(), theme::TEXT),
        None if auditor.is_dark || has_no_lamps => ("no light".to_owned(), theme::TEXT),
        None => ("checking the error".to_owned(), theme::TEXT),
    };
    Verdict { state: state.to_owned(), error, colour }
}

/// How good a picture of this error is.
fn grade(budget: &ErrorBudget) -> (&'static str, Color32) {
    let error = budget.total.error;
    let within = LEVELS.iter().zip(&budget.spread.within).find(|(level, _)| **level >= GOOD);
    let is_local = within.is_some_and(|(_, share)| share.value >= MOST_OF_IT);
    match error {
        e if e <= ACCURATE => ("accurate", theme::DONE),
        e if e <= GOOD => ("good", theme::DONE),
        e if e <= FAIR => ("fair", theme::TEXT),
        _ if is_local => ("rough in places", theme::WARNING),
        _ => ("rough", theme::WARNING),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ui::auditor::tests::budget;

    #[test]
    fn a_large_error_is_never_called_good() {
        let words: Vec<&str> =
            [0.01, 0.04, 0.08, 0.31].into_iter().map(|error| grade(&budget(0.0, error)).0).collect();
        assert_eq!(words, ["accurate", "good", "fair", "rough"]);
        let mut local = budget(0.0, 0.31);
        local.spread.within[1].value = 0.97;
        assert_eq!(grade(&local), ("rough in places", theme::WARNING));
    }
}
