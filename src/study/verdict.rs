//! How the way to a goal ended, and what stood in it, in words.

use super::goal::Goal;
use super::goal_run::MOST_SOLVES;
use crate::accuracy::ErrorBudget;
use std::fmt;

/// What stands in the way of a goal.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    /// The next solve would not have ended in time.
    Time,
    /// The last solve was cut short by the time.
    CutShort,
    /// Not even the coarsest solve ended in time.
    Unfinished,
    /// The next solve was refused, for this reason.
    Refused(String),
    /// No light arrives anywhere.
    Dark,
    /// A mesh that promises the error needs more memory or patches than there are.
    TooFine {
        /// Most that form factors may take, and what they take now, GB.
        gigabytes: [f64; 2],
        /// Patches at most.
        most: f64,
    },
}

impl fmt::Display for Obstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time => f.write_str("the next step would not have ended in time"),
            Self::CutShort => f.write_str("the last solve was cut short by the time"),
            Self::Unfinished => f.write_str(
                "not even the coarsest solve ended in time; the light is that of the brightest patches",
            ),
            Self::Refused(reason) => f.write_str(reason),
            Self::Dark => f.write_str("no light arrives anywhere, so that there is no error to speak of"),
            Self::TooFine { gigabytes: [free, now], most } => write!(
                f,
                "a mesh fine enough would need more than the {free:.1} GB that are free for form factors \
                 ({now:.1} GB now), or more than {most} patches"
            ),
        }
    }
}

/// How the way to a goal ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What was asked for.
    pub goal: Goal,
    /// Points where errors count; none for the picture.
    pub places: usize,
    /// What the audit of the best solve found, at the points where there are some; `None` where there was no light or no time.
    pub budget: Option<ErrorBudget>,
    /// The error predicted of the last solve.
    pub predicted_error: Option<f64>,
    /// Seconds of all work.
    pub seconds: f64,
    /// What stood in the way, where something did.
    pub obstacle: Option<Obstacle>,
}

impl Verdict {
    /// Whether the goal was met.
    pub fn met(&self) -> bool {
        match self.goal {
            Goal::Error(asked) => self.budget.is_some_and(|found| found.total.error <= asked),
            Goal::Seconds(asked) => self.obstacle != Some(Obstacle::Unfinished) && self.seconds <= asked,
        }
    }
}

/// One sentence: how far it got, and what stood in the way.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let because = self.obstacle.as_ref().map_or(String::new(), |o| format!(": {o}"));
        let seconds = self.seconds;
        if self.obstacle == Some(Obstacle::Unfinished) {
            return write!(f, "{seconds:.2} s{because}");
        }
        let estimate = self.budget.map(|found| {
            let [error, low, high] = [found.total.error, found.total.low, found.total.high].map(percent);
            match self.places {
                0 => format!("error {error} ({low} to {high})"),
                1 => format!("error {error} at the point"),
                n => format!("error {error} (RMS) at the {n} points"),
            }
        });
        match (self.goal, &self.budget) {
            (Goal::Error(asked), Some(found)) if found.total.error <= asked => {
                // Goals are about the estimate; that it is uncertain is told.
                let unsure = if found.total.high > asked { "; the interval reaches beyond" } else { "" };
                write!(f, "{}, as asked for{unsure}", estimate.unwrap_or_default())
            }
            (Goal::Error(asked), Some(found)) => {
                let over = percent(found.total.error - asked);
                let why = if because.is_empty() {
                    format!(": {MOST_SOLVES} solves did not suffice")
                } else {
                    because
                };
                write!(f, "{}, {over} more than asked for{why}", estimate.unwrap_or_default())
            }
            (Goal::Error(_), None) => write!(f, "the error is not known{because}"),
            (Goal::Seconds(asked), _) => {
                let error = match (estimate, self.predicted_error) {
                    (Some(estimate), _) => estimate,
                    (None, Some(predicted)) => {
                        format!("error predicted to be {}, with no time left to check it", percent(predicted))
                    }
                    (None, None) => "error not known".to_owned(),
                };
                let over = seconds - asked;
                let over =
                    if over <= 0.0 { String::new() } else { format!(", {over:.2} s more than asked for") };
                write!(f, "{seconds:.2} s of {asked} s{over}, {error}{because}")
            }
        }
    }
}
