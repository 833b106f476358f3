//! The way to an error or a time that the user named: solve after solve, each from the check of the last.

use super::auditor::Auditor;
use crate::accuracy::ErrorBudget;
use crate::solve::SolveSettings;
use crate::study::{self, Goal};
use std::time::Instant;

/// Solves that are made to come nearer to a goal before it is given up.
const MOST_STEPS: u32 = 5;
/// The way to a goal.
pub(super) struct Way {
    /// When the user asked for it.
    pub(super) since: Instant,
    /// Solves asked for.
    pub(super) steps: u32,
}

impl Way {
    pub(super) fn new() -> Self {
        Self { since: Instant::now(), steps: 0 }
    }
}

impl Auditor {
    /// The next solve towards the goal, if one is asked for and the last was not enough.
    pub(super) fn step(&mut self, budget: &ErrorBudget, now: &SolveSettings) -> Option<SolveSettings> {
        let steps = self.way.as_ref().map(|way| way.steps)?;
        let error = format!("{:.2} %", 100.0 * budget.total.error);
        let wanted = match self.goal {
            Goal::Error(asked) => {
                if budget.total.error <= asked {
                    self.end(format!("Reached: {error}"));
                    return None;
                }
                let promised = self.model.cheapest(study::aim(&self.model) * asked, self.limits);
                // Out of reach as far as is known; then as near as memory allows, by steps of moderate time.
                let moderate = study::CONSOLATION.max(self.elapsed());
                let near = || study::better_within(&self.model, moderate, self.limits);
                promised.or_else(near).map(|f| self.model.towards(f))
            }
            Goal::Seconds(seconds) => {
                let elapsed = self.elapsed();
                let left = study::TIME_AIM * (seconds - elapsed);
                if steps == 0 {
                    self.model.best_within(left, self.limits)
                } else {
                    let better = study::better_within(&self.model, left, self.limits);
                    if better.is_none() || steps >= MOST_STEPS {
                        let over = elapsed - seconds;
                        let over = if over > 0.0 { format!(", {over:.1} s too many") } else { String::new() };
                        self.end(format!("{error} in {elapsed:.1} of {seconds:.1} s{over}"));
                        return None;
                    }
                    better
                }
            }
        };
        let Some(fineness) = wanted.filter(|_| steps < MOST_STEPS) else {
            self.end(match self.goal {
                _ if wanted.is_some() => format!("Not reached in {MOST_STEPS} solves; it may be in more"),
                Goal::Error(_) => "Out of reach: no mesh that fits into memory promises it".to_owned(),
                Goal::Seconds(_) => "No solve of this scene is so short".to_owned(),
            });
            return None;
        };
        let settings =
            study::settings_of(&self.model, fineness, self.goal, &now.effects, self.refinement.clone());
        if settings == *now {
            self.end("This is the best choice already".to_owned());
            return None;
        }
        if let Some(way) = &mut self.way {
            way.steps = steps + 1;
        }
        Some(settings)
    }

    /// The way to the goal ends, with these words.
    pub(super) fn end(&mut self, verdict: String) {
        (self.way, self.verdict) = (None, verdict);
    }

    /// Seconds since the user asked for the goal.
    pub(super) fn elapsed(&self) -> f64 {
        self.way.as_ref().map_or(0.0, |way| way.since.elapsed().as_secs_f64())
    }

    /// Begins to solve towards the goal: settings for the first step, where the light is known.
    pub(super) fn reach(&mut self, now: &SolveSettings) -> Option<SolveSettings> {
        self.verdict.clear();
        self.on = true;
        self.way = Some(Way::new());
        self.limits.gigabytes = study::memory();
        match self.budget {
            Some(budget) => self.step(&budget, now),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::auditor::tests::{auditor, budget};
    use super::*;
    use crate::form_factors::ReceivingPoints;
    use crate::mesh::PatchTarget;
    use crate::solve::Timings;
    use crate::study::Measured;

    #[test]
    fn a_goal_is_walked_to_and_ends_when_it_is_reached() {
        let mut auditor = auditor(0.01, 0.04);
        let now = SolveSettings::default();
        let first = auditor.reach(&now).unwrap();
        assert!(auditor.is_reaching());
        let PatchTarget::Count(patches) = first.patches else { panic!("{first:?}") };
        assert!(patches > 1000);
        assert_eq!(auditor.step(&budget(0.002, 0.005), &first), None);
        assert!(!auditor.is_reaching() && auditor.verdict.starts_with("Reached"), "{}", auditor.verdict);
    }

    #[test]
    fn what_is_out_of_reach_is_tried_once() {
        let mut auditor = auditor(0.3, 0.8);
        auditor.limits.gigabytes = 4.0;
        let mut next = auditor.reach(&SolveSettings::default());
        auditor.limits.gigabytes = 4.0;
        let (mut steps, mut error) = (0, 0.8);
        while let Some(settings) = next {
            let PatchTarget::Count(patches) = settings.patches else { panic!("{settings:?}") };
            let (patches, lines) = (patches as f64, f64::from(settings.resolution.unwrap()));
            let pairs = (patches / 1000.0).powi(2);
            error *= 0.6;
            auditor.model.learn(Measured {
                timings: Timings { rows: 0.3 * pairs, sweeps: 0.1 * pairs, ..Timings::default() },
                entries: 3e5 * pairs,
                ..Measured::example(patches, lines, [0.3 * error, error])
            });
            steps += 1;
            next = auditor.step(&budget(0.3 * error, error), &settings);
        }
        assert!((1..=3).contains(&steps), "{steps} solves for what is out of reach");
        assert!(!auditor.is_reaching() && auditor.verdict.starts_with("Out of reach"), "{}", auditor.verdict);
    }

    #[test]
    fn steps_that_ran_out_are_no_lack_of_memory_and_sweeps_never_hold_a_goal_up() {
        let mut auditor = auditor(0.01, 0.04);
        auditor.goal = Goal::Error(0.01);
        let coarse =
            SolveSettings { tolerance: 1e-2, points: ReceivingPoints::Four, ..SolveSettings::default() };
        let first = auditor.reach(&coarse).unwrap();
        assert!(first.tolerance <= 0.1 * 0.01 && first.points == ReceivingPoints::Auto, "{first:?}");
        auditor.way = Some(Way { steps: MOST_STEPS, ..Way::new() });
        assert_eq!(auditor.step(&budget(0.01, 0.04), &first), None);
        assert!(!auditor.is_reaching() && auditor.verdict.starts_with("Not reached"), "{}", auditor.verdict);
    }
}
