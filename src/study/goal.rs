//! Solving to an error or within a time that the user names: each solve has smaller patches where the check
//! of the one before found the picture wrong.

use super::audited::audit;
use super::cost::{CostModel, Fineness, Limits, Measured};
use super::refine::refined;
use super::trial::pace;
use super::until::{Known, Outcome, solve_until};
use crate::accuracy::{AuditSettings, ErrorBudget};
use crate::effects::EffectChoices;
use crate::form_factors::{Method, ReceivingPoints};
use crate::mesh::{PatchMesh, PatchTarget, Refinement};
use crate::scene::{Lighting, Scene};
use crate::solve::{
    Control, PipelineError, Progress, Solution, SolveSettings, available_bytes, effect_costs,
};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a solve is to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// An error of irradiance as shown, relative to its mean; above zero.
    Error(f64),
    /// Seconds of work in all; above zero.
    Seconds(f64),
}

/// One solve on the way, with what was predicted of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attempt {
    /// Patches.
    pub patches: usize,
    /// Half-planes a row.
    pub lines: u32,
    /// Seconds that it took, meshing included.
    pub seconds: f64,
    /// Seconds foreseen before it began; `None` for the first.
    pub predicted_seconds: Option<f64>,
    /// Error foreseen before it began.
    pub predicted_error: Option<f64>,
    /// What the audit after it found.
    pub budget: Option<ErrorBudget>,
}

/// How a search ended.
#[derive(Debug)]
pub struct Reached {
    /// The best solve; without a budget where there was no light or no time for an audit.
    pub solved: Arc<Solution>,
    /// Whether the goal was met.
    pub met: bool,
    /// Whether all rows and sweeps were made; else the light is that of the rows that there was time for.
    pub complete: bool,
    /// One sentence: how far it got and what stood in the way.
    pub verdict: String,
    /// All solves.
    pub attempts: Vec<Attempt>,
    /// What was learnt of the scene, for further predictions.
    pub model: CostModel,
    /// Seconds of all work, audits included.
    pub seconds: f64,
}

/// What an observer of a search is told.
pub enum News<'a> {
    /// A solve goes on.
    Solving(&'a Progress<'a>),
    /// The light is being checked.
    Auditing,
}

/// Patches and half-planes of the first solve, which calibrates the rest on this machine.
const FIRST: (usize, u32) = (800, 48);
/// Solves at most on the way to an error.
const MOST_SOLVES: usize = 6;
/// Aims at this part of the error asked for, since predictions err and an audit is some 10 % uncertain: while
/// it is only assumed how the error falls, and once it is known. With 0.85 and 0.93 a picture that was told as
/// 1 % wrong was 1.01 % off.
const AIM: [f64; 2] = [0.78, 0.86];
/// Of the seconds left a solve may be foreseen to take this part.
pub const TIME_AIM: f64 = 0.7;
/// With time left, another solve is made where it is foreseen to leave this part of the error at most.
const GAIN: f64 = 0.8;
/// Noise that the shares of area may have of rays in these audits, which a user waits for.
const QUICK_NOISE: f64 = 0.02;
/// Where no mesh in memory promises the error, further solves take so many seconds, or as long as was spent on
/// those before.
pub const CONSOLATION: f64 = 60.0;
/// Patches never exceed this.
pub const MOST_PATCHES: f64 = 400_000.0;
/// A mesh that has so many times the patches asked for, besides small faces, has as few as the scene allows.
const COARSEST: f64 = 1.5;
/// Of the memory that is free form factors may take this part.
const MEMORY_SHARE: f64 = 0.7;
/// Where the system does not tell how much is free, GB.
const MEMORY_GUESS: f64 = 4.0;

/// What form factors may take of the memory that is free now, GB.
pub fn memory() -> f64 {
    available_bytes().map_or(MEMORY_GUESS, |bytes| MEMORY_SHARE * bytes / 1e9)
}

/// Solves until the goal is met, choosing patches, half-planes and tolerance by audits of what it has.
///
/// `started` is when the user began to wait. `memory` is what form factors may take, GB. The
/// observer may cancel.
///
/// # Errors
/// As the pipeline; not where a time runs out: the picture so far is the answer then.
pub fn reach(
    scene: &Arc<Scene>,
    lighting: &Lighting,
    goal: Goal,
    effects: &EffectChoices,
    started: Instant,
    memory: f64,
    observer: &mut dyn FnMut(News<'_>) -> Control,
) -> Result<Reached, PipelineError> {
    let deadline = match goal {
        Goal::Seconds(seconds) => Some(started + Duration::from_secs_f64(seconds.min(1e7))),
        Goal::Error(_) => None,
    };
    let left =
        || deadline.map_or(f64::INFINITY, |d| d.saturating_duration_since(Instant::now()).as_secs_f64());
    let mut model = CostModel::default();
    let mut attempts: Vec<Attempt> = Vec::new();
    let mut best: Option<Solution> = None;
    let mut limits = Limits { fewest: 1.0, most: MOST_PATCHES, gigabytes: memory };
    let mut next = Fineness { patches: FIRST.0 as f64, lines: f64::from(FIRST.1) };
    let mut refinement: Option<Arc<Refinement>> = None;
    // By how much smaller the next solve is to be than the time would allow.
    let mut share = 1.0;
    let mut obstacle = None;
    let mut survey = None;

    while attempts.len() < MOST_SOLVES {
        let settings = settings_of(&model, next, goal, effects, refinement.clone());
        let clock = Instant::now();
        let foreseen = model.seconds(next);
        let foreseen_error = model.error(next);
        let known = Known { before: best.as_ref(), survey: survey.take(), model: &model };
        let solve = solve_until(scene.clone(), &settings, deadline, known, &mut survey, observer);
        let (mut solved, complete) = match solve {
            Ok(Outcome::Whole(solved)) => (*solved, true),
            Ok(Outcome::Part(solved)) => (*solved, false),
            Ok(Outcome::TooLong) => {
                share *= 0.5;
                let smaller = better_within(&model, TIME_AIM * share * left(), limits);
                if let Some(fineness) = smaller.filter(|_| share > 0.2) {
                    next = fineness;
                    continue;
                }
                obstacle = Some("the next step would not have ended in time".to_owned());
                break;
            }
            Err(error @ PipelineError::Memory { .. }) if best.is_some() => {
                obstacle = Some(error.to_string());
                break;
            }
            Err(error) => return Err(error),
        };
        let lines = next.lines as u32;
        let seconds = clock.elapsed().as_secs_f64();
        if !complete {
            attempts.push(Attempt {
                patches: solved.mesh.patches.len(),
                lines,
                seconds,
                predicted_seconds: foreseen,
                predicted_error: foreseen_error,
                budget: None,
            });
            if best.is_none() {
                return Ok(unfinished(solved, attempts, model, started));
            }
            obstacle = Some("the last solve was cut short by the time".to_owned());
            break;
        }

        // Check it, for a time in proportion.
        if observer(News::Auditing) == Control::Cancel {
            return Err(PipelineError::Cancelled);
        }
        let audit_settings = match goal {
            // Far from the goal it is decided at once; only near it so much precision and time are taken.
            Goal::Error(error) => AuditSettings {
                precision: 0.05,
                resolve: 0.2 * error,
                local_noise: QUICK_NOISE,
                seconds: (2.0 * seconds).clamp(6.0, 60.0),
                decide: Some(error),
                ..AuditSettings::default()
            },
            Goal::Seconds(_) => AuditSettings {
                precision: 0.15,
                resolve: 2e-3,
                local_noise: QUICK_NOISE,
                seconds: (0.3 * seconds).max(0.15).min(0.4 * left()),
                ..AuditSettings::default()
            },
        };
        let found = audit(&solved, lighting, &audit_settings, &|| false);
        let budget = found.as_ref().map(|found| found.budget);
        if let Some(found) = found {
            refinement = Some(Arc::new(refined(&solved.mesh, &found.map, refinement.as_deref())));
        }
        attempts.push(Attempt {
            patches: solved.mesh.patches.len(),
            lines,
            seconds,
            predicted_seconds: foreseen,
            predicted_error: foreseen_error,
            budget,
        });
        let known = model.measured().last().map(|m| m.pace);
        let pace = known.unwrap_or_else(|| pace(&solved, lines));
        model.learn(Measured::of(&solved, lines, pace, budget.as_ref()));
        if attempts.len() == 1 {
            limits.fewest = fewest(&solved.mesh, next.patches);
        }
        solved.budget = budget;
        if best.as_ref().is_none_or(|old| !is_worse(budget.as_ref(), old.budget.as_ref())) {
            best = Some(solved);
        }

        // Is it enough, and if not, what next?
        match goal {
            Goal::Error(error) => {
                let Some(budget) = budget else {
                    obstacle =
                        Some("no light arrives anywhere, so that there is no error to speak of".to_owned());
                    break;
                };
                if budget.total.error <= error {
                    break;
                }
                // After a miss the aim is closer: what was foreseen proved too bright a view.
                let shortfall = foreseen_error.map_or(1.0, |f| (f / budget.total.error).clamp(0.9, 1.0));
                match model.cheapest(aim(&model) * error * shortfall, limits) {
                    Some(fineness) if is_finer_than_last(&model, fineness) => next = model.towards(fineness),
                    // Out of reach as far as is known; then as near as memory allows, by steps that take no
                    // more than a moderate time, or than what has been spent.
                    _ => {
                        obstacle = Some(too_fine(&model, limits));
                        let moderate = CONSOLATION.max(started.elapsed().as_secs_f64());
                        let Some(fineness) = better_within(&model, moderate, limits) else { break };
                        // On the way there a step in between tells where patches are needed.
                        next = model.towards(fineness);
                    }
                }
            }
            Goal::Seconds(_) => {
                let Some(fineness) = better_within(&model, TIME_AIM * share * left(), limits) else { break };
                next = fineness;
            }
        }
    }
    let Some(mut solved) = best else { return Err(PipelineError::Cancelled) };
    let seconds = started.elapsed().as_secs_f64();
    // Said only of a solve without a budget, and that is the last one.
    let foreseen = model.measured().last().and_then(|m| model.error(m.fineness));
    let (met, verdict) = verdict(goal, solved.budget.as_ref(), foreseen, seconds, obstacle);
    solved.plan = Arc::new(effect_costs(&solved));
    let solved = Arc::new(solved);
    Ok(Reached { solved, met, complete: true, verdict, attempts, model, seconds })
}

/// The part of the error asked for that the next solve is to aim at.
pub fn aim(model: &CostModel) -> f64 {
    AIM[usize::from(model.knows_its_power())]
}

/// The fewest patches that any mesh of a scene has, as this one tells, for which `asked` were asked for.
pub fn fewest(mesh: &PatchMesh, asked: f64) -> f64 {
    let (patches, whole) = (mesh.patches.len() as f64, mesh.statistics.whole_sides as f64);
    if patches - whole > COARSEST * asked { patches } else { whole.max(1.0) }
}

/// Whether this is finer than the last solve was. What that had asked for does not matter: a mesh may be
/// much finer than that.
fn is_finer_than_last(model: &CostModel, new: Fineness) -> bool {
    let last = model.measured().last().map(|m| m.fineness);
    last.is_none_or(|old| new.patches > 1.02 * old.patches || new.lines > old.lines)
}

/// The most accurate fineness within `seconds` where it promises a gain that is worth another solve.
pub fn better_within(model: &CostModel, seconds: f64, limits: Limits) -> Option<Fineness> {
    let last = model.measured().last().and_then(|m| model.error(m.fineness));
    let gains = |f: &Fineness| model.error(*f).zip(last).is_none_or(|(new, old)| new < GAIN * old);
    let best = model.best_within(seconds, limits)?;
    (gains(&best) && is_finer_than_last(model, best)).then_some(best)
}

/// Whether a new solve is known to be worse than the one before.
fn is_worse(new: Option<&ErrorBudget>, old: Option<&ErrorBudget>) -> bool {
    new.zip(old).is_some_and(|(new, old)| new.total.error > old.total.error)
}

fn too_fine(model: &CostModel, limits: Limits) -> String {
    let gigabytes = model.measured().last().and_then(|m| model.gigabytes(m.fineness)).unwrap_or(0.0);
    format!(
        "a mesh fine enough would need more than the {:.1} GB that are free for form factors ({gigabytes:.1} GB now), \
         or more than {} patches",
        limits.gigabytes, limits.most
    )
}

/// Settings of a solve of this fineness on the way to a goal: the sweeps add nothing to its error that counts.
///
/// `refinement` says where patches are to be smaller than elsewhere.
pub fn settings_of(
    model: &CostModel,
    fineness: Fineness,
    goal: Goal,
    effects: &EffectChoices,
    refinement: Option<Arc<Refinement>>,
) -> SolveSettings {
    let tolerance = match goal {
        // The bound is of the largest error of any patch; a fiftieth of the mean one is never felt.
        Goal::Error(error) => (0.02 * error).clamp(1e-7, 1e-2),
        Goal::Seconds(_) => 1e-3,
    };
    SolveSettings {
        patches: PatchTarget::Count(model.count(fineness)),
        refinement,
        method: Method::Lines,
        resolution: Some(fineness.lines as u32),
        points: ReceivingPoints::Auto,
        tolerance,
        effects: effects.clone(),
    }
}

fn verdict(
    goal: Goal,
    budget: Option<&ErrorBudget>,
    foreseen: Option<f64>,
    seconds: f64,
    obstacle: Option<String>,
) -> (bool, String) {
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let because = obstacle.map_or(String::new(), |o| format!(": {o}"));
    match (goal, budget) {
        (Goal::Error(asked), Some(found)) => {
            let error = found.total.error;
            let range =
                format!("{} ({} to {})", percent(error), percent(found.total.low), percent(found.total.high));
            if error <= asked {
                // Goals are about the estimate; that it is uncertain is told.
                let unsure = if found.total.high > asked { "; the interval reaches beyond" } else { "" };
                (true, format!("error {range}, as asked for{unsure}"))
            } else {
                let over = percent(error - asked);
                let why = if because.is_empty() {
                    format!(": {MOST_SOLVES} solves did not suffice")
                } else {
                    because
                };
                (false, format!("error {range}, {over} more than asked for{why}"))
            }
        }
        (Goal::Error(_), None) => (false, format!("the error is not known{because}")),
        (Goal::Seconds(asked), found) => {
            let error = match (found, foreseen) {
                (Some(f), _) => format!(
                    "error {} ({} to {})",
                    percent(f.total.error),
                    percent(f.total.low),
                    percent(f.total.high)
                ),
                (None, Some(foreseen)) => {
                    format!("error foreseen at {}, with no time left to check it", percent(foreseen))
                }
                (None, None) => "error not known".to_owned(),
            };
            let met = seconds <= asked;
            let over =
                if met { String::new() } else { format!(", {:.2} s more than asked for", seconds - asked) };
            (met, format!("{seconds:.2} s of {asked} s{over}, {error}{because}"))
        }
    }
}

fn unfinished(solved: Solution, attempts: Vec<Attempt>, model: CostModel, started: Instant) -> Reached {
    let seconds = started.elapsed().as_secs_f64();
    Reached {
        solved: Arc::new(solved),
        met: false,
        complete: false,
        verdict: format!(
            "{seconds:.2} s: not even the coarsest solve ended in time; the light is that of the brightest patches"
        ),
        attempts,
        model,
        seconds,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::Estimate;
    use crate::solve::Timings;

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
        // Finer ones that there was no time to check are taken to be better, as foreseen.
        assert!(!is_worse(None, Some(&good)) && !is_worse(Some(&bad), None));
    }
}
