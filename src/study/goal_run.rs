//! The way to a goal as a machine without clocks or threads: told what solves and their audits came to, it
//! says what comes next. The command line and the window walk by the same one.

use super::cost::{CostModel, Fineness, Limits};
use super::goal::{Attempt, Goal};
use super::verdict::{Obstacle, Verdict};
use crate::accuracy::{AuditSettings, ErrorBudget};
use crate::effects::EffectChoices;
use crate::form_factors::{Method, ReceivingPoints};
use crate::mesh::{PatchTarget, Refinement};
use crate::solve::{DirectTarget, SolveSettings};
use crate::transport::TransportKind;
use std::sync::Arc;

/// Patches and half-planes of the first solve, which calibrates the rest on this machine.
const FIRST: (usize, u32) = (800, 48);
/// Solves at most on the way to a goal.
pub const MOST_SOLVES: usize = 6;
/// Aims at this part of the error asked for, since predictions err and an audit is some 10 % uncertain: while
/// it is only assumed how the error falls, and once it is known. With 0.85 and 0.93 a picture whose error was estimated at
/// 1 % wrong was 1.01 % off.
const AIM: [f64; 2] = [0.78, 0.86];
/// Of the seconds left a solve may be predicted to take this part.
const TIME_AIM: f64 = 0.7;
/// Direct light takes this part of the error asked for: it is cheap, and what it is off by no patches mend. Where a check finds
/// it above the second part, and surely above the first, it is laid out more finely, by the factor at most in one step: elements
/// grow with its square where shadows have edges.
const DIRECT: f64 = 0.3;
const DIRECT_MOST: f64 = 0.45;
const FINER_DIRECT: f64 = 0.5;
/// What elements expect to be off by is so many times what they are, or more: 2.2 to 3 in four scenes.
const EXPECTED: f64 = 2.0;
/// Elements at most.
const MOST_ELEMENTS: usize = 1_000_000;
/// Within a time direct light gets so many elements for each second, and is better than this at most.
const ELEMENTS_A_SECOND: f64 = 1000.0;
pub(super) const WORK_A_SECOND: f64 = 4e5;
const BEST_DIRECT: f64 = 2e-3;
/// With time left, another solve is made where it is predicted to leave this part of the error at most.
const GAIN: f64 = 0.8;
/// Noise that the shares of area may have of rays in these audits, which a user waits for.
const QUICK_NOISE: f64 = 0.02;
/// And the whole of a receiver, see [`AuditSettings::noise`]: more receivers tell more than fewer rays take away.
const NOISE: f64 = 3.0;
/// After so many seconds a check that has found too large an error so far leaves it at that, or after as many as the solve
/// took.
const LEAST_CHECK: f64 = 0.7;
/// Where no mesh in memory promises the error, further solves take so many seconds, or as long as was spent on
/// those before.
const CONSOLATION: f64 = 60.0;
/// After solves that did not end in time the next is not made smaller than by this factor.
const SMALLEST_SHARE: f64 = 0.2;

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Another solve: see [`GoalRun::begin`].
    Solve,
    /// Nothing: see [`GoalRun::verdict`].
    End,
}

/// How direct light is laid out that is to be off by so much.
fn elements_for(error: f64) -> DirectTarget {
    DirectTarget { error: EXPECTED * error, most: MOST_ELEMENTS, work: u64::MAX }
}

/// For an error that is asked for: how direct light is laid out at first, and what is aimed at, in all and of direct light.
pub(super) fn direct_target(error: f64) -> (DirectTarget, [f64; 2]) {
    (elements_for(DIRECT * error), [AIM[0] * error, DIRECT * error])
}

/// The way to one goal.
#[derive(Clone, Debug)]
pub struct GoalRun {
    goal: Goal,
    effects: EffectChoices,
    limits: Limits,
    next: Fineness,
    /// Where patches are to be smaller than elsewhere.
    refinement: Option<Arc<Refinement>>,
    /// By how much smaller the next solve is to be than the time would allow.
    share: f64,
    /// What direct light is to be off by, as a share of the error asked for.
    direct: f64,
    /// What the next solve's direct light will be off by, where it is finer than that of the last.
    finer_direct: Option<f64>,
    /// Seconds and error predicted of the solve that was begun last.
    predicted: [Option<f64>; 2],
    attempts: Vec<Attempt>,
    /// Points where errors count; none for the picture.
    places: usize,
    /// Of the best light so far what its audit found.
    best: Option<Option<ErrorBudget>>,
    obstacle: Option<Obstacle>,
}

impl GoalRun {
    /// Sets out to a goal within these limits.
    pub fn new(goal: Goal, effects: EffectChoices, limits: Limits) -> Self {
        Self {
            goal,
            effects,
            limits,
            next: Fineness { patches: FIRST.0 as f64, lines: f64::from(FIRST.1) },
            refinement: None,
            share: 1.0,
            direct: DIRECT,
            finer_direct: None,
            predicted: [None; 2],
            attempts: Vec::new(),
            places: 0,
            best: None,
            obstacle: None,
        }
    }

    /// Errors count at so many points, and not over the picture; none stands for the picture.
    pub fn count_at(&mut self, places: usize) {
        self.places = places;
    }

    /// What it goes to.
    pub fn goal(&self) -> Goal {
        self.goal
    }

    /// How fine the next solve is to be.
    pub fn next(&self) -> Fineness {
        self.next
    }

    /// All solves so far.
    pub fn attempts(&self) -> &[Attempt] {
        &self.attempts
    }

    /// The fewest patches that any mesh of the scene has.
    pub fn set_fewest(&mut self, patches: f64) {
        self.limits.fewest = patches;
    }

    /// The next solve has smaller patches there, as an audit would have it.
    pub fn refine(&mut self, refinement: Option<Arc<Refinement>>) {
        self.refinement = refinement;
    }

    /// There is a light already, of which an audit found this.
    pub fn stands(&mut self, budget: ErrorBudget) {
        self.best = Some(Some(budget));
    }

    /// The next solve is begun, with these settings; what `model` predicts of it is kept.
    pub fn begin(&mut self, model: &CostModel) -> SolveSettings {
        let error = match self.finer_direct {
            Some(direct) => model.with_direct(direct).error(self.next),
            None => model.error(self.next),
        };
        self.predicted = [model.seconds(self.next), error];
        let tolerance = match self.goal {
            // The bound is of the largest error of any patch; a fiftieth of the mean one is never felt.
            Goal::Error(error) => (0.02 * error).clamp(1e-7, 1e-2),
            Goal::Seconds(_) => 1e-3,
        };
        SolveSettings {
            patches: PatchTarget::Count(model.count(self.next)),
            refinement: self.refinement.clone(),
            method: Method::Lines,
            resolution: Some(self.next.lines as u32),
            points: ReceivingPoints::Auto,
            direct: match self.goal {
                Goal::Error(error) => elements_for(self.direct * error),
                Goal::Seconds(seconds) => DirectTarget {
                    error: BEST_DIRECT,
                    work: (seconds * WORK_A_SECOND) as u64,
                    most: (seconds * ELEMENTS_A_SECOND).clamp(1e3, MOST_ELEMENTS as f64) as usize,
                },
            },
            transport: TransportKind::Auto,
            // The sweeps add nothing to its error that counts.
            tolerance,
            effects: self.effects.clone(),
        }
    }

    /// How a solve that took so many seconds is audited, `elapsed` seconds after the goal was set: for a time
    /// in proportion.
    pub fn audit_settings(&self, seconds: f64, elapsed: f64) -> AuditSettings {
        match self.goal {
            // Far from the goal it is decided at once; only near it so much precision and time are taken.
            Goal::Error(error) => AuditSettings {
                precision: 0.05,
                resolve: 0.2 * error,
                local_noise: QUICK_NOISE,
                noise: NOISE,
                seconds: (2.0 * seconds).clamp(3.0, 60.0),
                hurry: seconds.max(LEAST_CHECK),
                decide: Some(error),
                ..AuditSettings::default()
            },
            Goal::Seconds(_) => AuditSettings {
                precision: 0.15,
                resolve: 2e-3,
                local_noise: QUICK_NOISE,
                noise: NOISE,
                seconds: (0.3 * seconds).max(0.15).min(0.4 * self.left(elapsed)),
                ..AuditSettings::default()
            },
        }
    }

    /// Seconds left of those that were asked for.
    fn left(&self, elapsed: f64) -> f64 {
        match self.goal {
            Goal::Seconds(seconds) => (seconds - elapsed).max(0.0),
            Goal::Error(_) => f64::INFINITY,
        }
    }

    /// The solve that was begun came to so many patches in so many seconds, and its audit to this. Whether it
    /// is the best so far.
    pub fn note(&mut self, patches: usize, seconds: f64, budget: Option<ErrorBudget>) -> bool {
        self.record(patches, seconds, budget);
        let is_best = self.best.as_ref().is_none_or(|old| !is_worse(budget.as_ref(), old.as_ref()));
        if is_best {
            self.best = Some(budget);
        }
        is_best
    }

    /// The solve that was begun was cut short by the time, with the light of so many patches. The way ends.
    pub fn cut_short(&mut self, patches: usize, seconds: f64) -> Step {
        self.record(patches, seconds, None);
        self.stop(if self.best.is_some() { Obstacle::CutShort } else { Obstacle::Unfinished })
    }

    fn record(&mut self, patches: usize, seconds: f64, budget: Option<ErrorBudget>) {
        let [predicted_seconds, predicted_error] = self.predicted;
        let lines = self.next.lines as u32;
        self.attempts.push(Attempt { patches, lines, seconds, predicted_seconds, predicted_error, budget });
    }

    /// What comes after a light of which an audit found `budget`, where `model` knows all solves, `elapsed`
    /// seconds after the goal was set.
    pub fn step(&mut self, model: &CostModel, budget: Option<&ErrorBudget>, elapsed: f64) -> Step {
        let next = match self.goal {
            Goal::Error(error) => {
                let Some(budget) = budget else { return self.stop(Obstacle::Dark) };
                if budget.total.error <= error {
                    return Step::End;
                }
                // After a miss the aim is closer: what was predicted proved too bright a view.
                let shortfall = self.predicted[1].map_or(1.0, |p| (p / budget.total.error).clamp(0.9, 1.0));
                if model.measured().is_empty() {
                    // Nothing is known of the scene yet; the first solve calibrates the rest.
                    return Step::Solve;
                }
                let aim = AIM[usize::from(model.knows_its_power())] * error * shortfall;
                let found = budget.direct.error;
                let is_coarse = found > DIRECT_MOST * error && budget.direct.low > DIRECT * error;
                self.finer_direct = is_coarse.then(|| {
                    let finer = (DIRECT * error / found).max(FINER_DIRECT);
                    self.direct *= finer;
                    finer * found
                });
                let with_finer = self.finer_direct.map(|direct| model.with_direct(direct));
                let model = with_finer.as_ref().unwrap_or(model);
                match model.cheapest(aim, self.limits) {
                    // Finer direct light alone may do.
                    Some(fineness) if with_finer.is_some() || is_finer_than_last(model, fineness) => {
                        Some(model.towards(at_least_as_fine(model, fineness)))
                    }
                    // Out of reach as far as is known; then as near as memory allows, by steps that take no
                    // more than a moderate time, or than what has been spent.
                    _ => {
                        self.obstacle = Some(self.too_fine(model));
                        // On the way there a step in between tells where patches are needed.
                        better_within(model, CONSOLATION.max(elapsed), self.limits)
                            .map(|fineness| model.towards(fineness))
                    }
                }
            }
            Goal::Seconds(_) if model.measured().is_empty() => return Step::Solve,
            Goal::Seconds(_) => better_within(model, TIME_AIM * self.share * self.left(elapsed), self.limits),
        };
        match next {
            Some(next) if self.attempts.len() < MOST_SOLVES => {
                self.next = next;
                Step::Solve
            }
            _ => Step::End,
        }
    }

    /// The solve that was begun is given up, since it would not end in time.
    pub fn too_long(&mut self, model: &CostModel, elapsed: f64) -> Step {
        self.share *= 0.5;
        let smaller = better_within(model, TIME_AIM * self.share * self.left(elapsed), self.limits);
        match smaller.filter(|_| self.share > SMALLEST_SHARE) {
            Some(fineness) => {
                self.next = fineness;
                Step::Solve
            }
            None => self.stop(Obstacle::Time),
        }
    }

    /// The way ends here.
    pub fn stop(&mut self, obstacle: Obstacle) -> Step {
        self.obstacle = Some(obstacle);
        Step::End
    }

    /// How it ended, after so many seconds.
    pub fn verdict(&self, model: &CostModel, seconds: f64) -> Verdict {
        Verdict {
            goal: self.goal,
            places: self.places,
            budget: self.best.flatten(),
            // Said only of a solve without a budget, and that is the last one.
            predicted_error: model.measured().last().and_then(|m| model.error(m.fineness)),
            seconds,
            obstacle: self.obstacle.clone(),
        }
    }

    fn too_fine(&self, model: &CostModel) -> Obstacle {
        let now = model.measured().last().and_then(|m| model.gigabytes(m.fineness)).unwrap_or(0.0);
        Obstacle::TooFine { gigabytes: [self.limits.gigabytes, now], most: self.limits.most }
    }
}

/// Whether this is finer than the last solve was. What that had asked for does not matter: a mesh may be
/// much finer than that.
fn is_finer_than_last(model: &CostModel, new: Fineness) -> bool {
    let last = model.measured().last().map(|m| m.fineness);
    last.is_none_or(|old| new.patches > 1.02 * old.patches || new.lines > old.lines)
}

/// No fewer patches and half-planes than the last solve had: what they bring is known.
fn at_least_as_fine(model: &CostModel, new: Fineness) -> Fineness {
    let last = model.measured().last().map_or(new, |m| m.fineness);
    Fineness { patches: new.patches.max(last.patches), lines: new.lines.max(last.lines) }
}

/// The most accurate fineness within `seconds` where it promises a gain that is worth another solve.
fn better_within(model: &CostModel, seconds: f64, limits: Limits) -> Option<Fineness> {
    let last = model.measured().last().and_then(|m| model.error(m.fineness));
    let gains = |f: &Fineness| model.error(*f).zip(last).is_none_or(|(new, old)| new < GAIN * old);
    let best = model.best_within(seconds, limits)?;
    (gains(&best) && is_finer_than_last(model, best)).then_some(best)
}

/// Whether a new solve is known to be worse than the one before.
fn is_worse(new: Option<&ErrorBudget>, old: Option<&ErrorBudget>) -> bool {
    new.zip(old).is_some_and(|(new, old)| new.total.error > old.total.error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::Estimate;
    use crate::solve::Timings;
    use crate::study::Measured;

    const LIMITS: Limits = Limits { fewest: 9000.0, most: 1e6, gigabytes: 8.0 };

    /// After the first solve, which asked for [`FIRST`], of a scene that has 9000 patches by itself.
    fn after_the_first(errors: [f64; 2]) -> CostModel {
        let mut model = CostModel::default();
        model.learn(Measured {
            timings: Timings { rows: 4.0, balance: 1.0, sweeps: 1.0, ..Timings::default() },
            entries: 2e7,
            ..Measured::example(9000.0, f64::from(FIRST.1), errors)
        });
        model
    }

    #[test]
    fn another_solve_is_finer_than_the_last_really_was() {
        // Time for less than the same once more: whatever it is, it is no better.
        let model = after_the_first([0.02, 0.05]);
        let coarser = model.best_within(5.5, LIMITS).unwrap();
        assert!(coarser.lines < f64::from(FIRST.1) && coarser.patches == 9000.0, "{coarser:?}");
        assert_eq!(better_within(&model, 5.5, LIMITS), None);
        assert_eq!(better_within(&model, 6.1, LIMITS), None, "the same again");
        let better = better_within(&model, 60.0, LIMITS).unwrap();
        assert!(model.error(better).unwrap() <= GAIN * model.measured()[0].total, "{better:?}");
        // Finer, but hardly better.
        let smooth = after_the_first([1e-4, 0.05]);
        let best = smooth.best_within(6.3, LIMITS).unwrap();
        assert!(is_finer_than_last(&smooth, best) && better_within(&smooth, 6.3, LIMITS).is_none());
        assert!(!is_finer_than_last(&model, Fineness { patches: 9100.0, lines: 48.0 }));
        assert!(is_finer_than_last(&model, Fineness { patches: 9000.0, lines: 64.0 }));
    }

    #[test]
    fn a_worse_solve_does_not_take_the_place_of_a_better_one() {
        let of = |error: f64| ErrorBudget {
            total: Estimate { error, low: error, high: error },
            ..ErrorBudget::default()
        };
        let (good, bad) = (of(0.02), of(0.04));
        assert!(is_worse(Some(&bad), Some(&good)));
        assert!(!is_worse(Some(&good), Some(&bad)) && !is_worse(Some(&good), Some(&good)));
        // Finer ones that there was no time to check are taken to be better, as predicted.
        assert!(!is_worse(None, Some(&good)) && !is_worse(Some(&bad), None));
    }

    fn found(error: f64) -> ErrorBudget {
        ErrorBudget {
            total: Estimate { error, low: 0.9 * error, high: 1.1 * error },
            ..ErrorBudget::default()
        }
    }

    #[test]
    fn after_a_miss_the_aim_is_closer_and_the_best_light_is_kept() {
        let model = after_the_first([0.02, 0.05]);
        let limits = Limits { gigabytes: 1e3, ..LIMITS };
        let next_after = |predicted: Option<f64>| {
            let mut run = GoalRun::new(Goal::Error(0.03), EffectChoices::default(), limits);
            run.predicted[1] = predicted;
            assert_eq!(run.step(&model, Some(&found(0.05)), 10.0), Step::Solve);
            run.next()
        };
        let (trusting, warned) = (next_after(None), next_after(Some(0.04)));
        assert_eq!(trusting, next_after(Some(0.06)), "better than predicted is no miss");
        let work = |f: Fineness| model.seconds(f).unwrap();
        assert!(work(warned) > work(trusting), "{warned:?} after {trusting:?}");

        let mut run = GoalRun::new(Goal::Error(0.01), EffectChoices::default(), LIMITS);
        run.stands(found(0.04));
        assert!(run.note(9000, 1.0, Some(found(0.03))) && !run.note(12_000, 2.0, Some(found(0.035))));
        assert_eq!(run.verdict(&model, 9.0).budget, Some(found(0.03)));
    }

    #[test]
    fn direct_light_that_is_off_by_too_much_is_made_finer_and_other_light_is_not() {
        let model = after_the_first([0.02, 0.05]);
        let target_after = |direct: Estimate| {
            let mut run = GoalRun::new(
                Goal::Error(0.03),
                EffectChoices::default(),
                Limits { gigabytes: 1e3, ..LIMITS },
            );
            let budget = ErrorBudget { direct, ..found(0.06) };
            assert_eq!(run.step(&model, Some(&budget), 10.0), Step::Solve);
            let settings = run.begin(&model);
            (settings.direct.error / (EXPECTED * DIRECT * 0.03), run.predicted[1])
        };
        let of = |error: f64, low: f64| Estimate { error, low, high: 2.0 * error };
        let (usual, predicted) = target_after(of(0.01, 0.009));
        assert!((usual - 1.0).abs() < 1e-9 && predicted.is_some_and(|error| error < 0.03));
        assert_eq!(target_after(of(0.04, 0.03)).0, FINER_DIRECT);
        let (little, _) = target_after(of(0.015, 0.012));
        assert!((little - 0.6).abs() < 1e-9, "{little}");
        assert_eq!(target_after(of(0.04, 0.0)).0, usual, "it may be noise");
    }

    #[test]
    fn the_way_ends_with_what_stood_in_it() {
        let model = after_the_first([0.02, 0.05]);
        let run = |goal: Goal| GoalRun::new(goal, EffectChoices::default(), LIMITS);
        let mut met = run(Goal::Error(0.06));
        met.note(9000, 1.0, Some(found(0.05)));
        assert_eq!(met.step(&model, Some(&found(0.05)), 5.0), Step::End);
        let verdict = met.verdict(&model, 5.0);
        assert!(verdict.met() && verdict.obstacle.is_none(), "{verdict}");
        assert_eq!(verdict.to_string(), "error 5.00 % (4.50 % to 5.50 %), as asked for");

        let mut dark = run(Goal::Error(0.06));
        assert_eq!(dark.step(&model, None, 5.0), Step::End);
        let verdict = dark.verdict(&model, 5.0);
        assert!(!verdict.met() && verdict.obstacle == Some(Obstacle::Dark), "{verdict}");

        let mut timed = run(Goal::Seconds(60.0));
        assert_eq!(timed.step(&model, Some(&found(0.05)), 5.0), Step::Solve);
        let mut shares = 0;
        while timed.too_long(&model, 5.0) == Step::Solve {
            shares += 1;
        }
        assert!(shares <= 2, "{shares} smaller ones");
        assert_eq!(timed.verdict(&model, 20.0).obstacle, Some(Obstacle::Time));

        let mut long = run(Goal::Error(0.01));
        for _ in 0..MOST_SOLVES {
            long.note(9000, 1.0, Some(found(0.05)));
        }
        assert_eq!(long.step(&model, Some(&found(0.05)), 5.0), Step::End);
    }
}
