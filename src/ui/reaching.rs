//! The way to an error or a time that the user named, through the session: see [`GoalRun`].

use super::auditor::Auditor;
use crate::accuracy::ErrorBudget;
use crate::effects::EffectChoices;
use crate::solve::SolveSettings;
use crate::study::{self, Goal, GoalRun, Limits, MOST_SOLVES, Obstacle, Step, Verdict};
use std::time::Instant;

/// The way to a goal.
pub(super) struct Way {
    /// When the user asked for it.
    since: Instant,
    pub(super) run: GoalRun,
    /// The solve that was asked of the session and has not been checked yet.
    asked: Option<SolveSettings>,
    /// How the best light so far was solved.
    best: Option<SolveSettings>,
}

impl Way {
    pub(super) fn new(goal: Goal, effects: EffectChoices, limits: Limits) -> Self {
        Self { since: Instant::now(), run: GoalRun::new(goal, effects, limits), asked: None, best: None }
    }

    /// Seconds since the user asked for it.
    pub(super) fn elapsed(&self) -> f64 {
        self.since.elapsed().as_secs_f64()
    }
}

impl Auditor {
    /// The next solve towards the goal, if one is asked for and the last was not enough: of so many patches,
    /// in so many seconds.
    pub(super) fn step(
        &mut self,
        budget: &ErrorBudget,
        now: &SolveSettings,
        (patches, seconds): (usize, f64),
    ) -> Option<SolveSettings> {
        let way = self.way.as_mut()?;
        let elapsed = way.elapsed();
        way.run.set_fewest(self.limits.fewest);
        way.run.refine(self.refinement.clone());
        let is_best = match way.asked.take() {
            Some(asked) if asked == *now => way.run.note(patches, seconds, Some(*budget)),
            // A light that the user had before, or under other lamps.
            _ => {
                way.run.stands(*budget);
                true
            }
        };
        if is_best {
            way.best = Some(now.clone());
        }
        let step = way.run.step(&self.model, Some(budget), elapsed);
        if step == Step::Solve {
            let settings = way.run.begin(&self.model);
            if settings != *now {
                way.asked = Some(settings.clone());
                return Some(settings);
            }
        }
        // What is on screen stays, or the best light comes back.
        let back = way.best.take().filter(|_| !is_best);
        let verdict = way.run.verdict(&self.model, elapsed);
        let words = match step {
            Step::Solve => "This is the best choice already".to_owned(),
            Step::End => words(&verdict, way.run.attempts().len()),
        };
        self.end(words);
        back
    }

    /// The way to the goal ends, with these words.
    pub(super) fn end(&mut self, verdict: String) {
        (self.way, self.verdict) = (None, verdict);
    }

    /// Seconds since the user asked for the goal.
    pub(super) fn elapsed(&self) -> f64 {
        self.way.as_ref().map_or(0.0, Way::elapsed)
    }

    /// Begins to solve towards the goal: settings for the first step, where the light is known.
    pub(super) fn reach(&mut self, now: &SolveSettings) -> Option<SolveSettings> {
        self.verdict.clear();
        self.on = true;
        self.limits.gigabytes = study::memory();
        self.way = Some(Way::new(self.goal, now.effects.clone(), self.limits));
        let budget = self.budget?;
        self.step(&budget, now, (0, 0.0))
    }
}

/// How the way to a goal ended after so many solves, for a narrow panel.
fn words(verdict: &Verdict, solves: usize) -> String {
    let error = verdict.budget.map_or("unknown".to_owned(), |b| format!("{:.2} %", 100.0 * b.total.error));
    match (verdict.goal, &verdict.obstacle) {
        (Goal::Error(_), _) if verdict.met() => format!("Reached: {error}"),
        (Goal::Error(_), Some(Obstacle::TooFine { .. })) => {
            "Out of reach: no mesh that fits into memory promises it".to_owned()
        }
        (Goal::Error(_), Some(obstacle)) => format!("Not reached: {obstacle}"),
        (Goal::Error(_), None) => format!("Not reached in {MOST_SOLVES} solves; it may be in more"),
        (Goal::Seconds(asked), _) if solves == 0 => {
            format!("{error} already; nothing better fits into {asked:.1} s")
        }
        (Goal::Seconds(asked), _) => {
            let over = verdict.seconds - asked;
            let over = if over > 0.0 { format!(", {over:.1} s too many") } else { String::new() };
            format!("{error} in {:.1} of {asked:.1} s{over}", verdict.seconds)
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
        assert_eq!(auditor.step(&budget(0.002, 0.005), &first, (3000, 1.0)), None);
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
            next = auditor.step(&budget(0.3 * error, error), &settings, (patches as usize, 1.0));
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
        let run = &mut auditor.way.as_mut().unwrap().run;
        (1..MOST_SOLVES).for_each(|_| {
            run.note(1000, 1.0, None);
        });
        assert_eq!(auditor.step(&budget(0.01, 0.04), &first, (1000, 1.0)), None);
        assert!(!auditor.is_reaching() && auditor.verdict.starts_with("Not reached"), "{}", auditor.verdict);
    }

    #[test]
    fn a_solve_that_came_out_worse_gives_way_to_the_best_one() {
        let mut auditor = auditor(0.01, 0.04);
        auditor.goal = Goal::Error(0.001);
        let good = SolveSettings::default();
        let mut next = auditor.reach(&good).unwrap();
        // Every further solve is worse than the light that stood there.
        for _ in 0..MOST_SOLVES {
            match auditor.step(&budget(0.02, 0.05), &next, (2000, 1.0)) {
                Some(settings) if auditor.is_reaching() => next = settings,
                back => {
                    assert_eq!(back, Some(good), "{}", auditor.verdict);
                    return;
                }
            }
        }
        panic!("the way has no end");
    }
}
