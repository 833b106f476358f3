//! Solving to an error or within a time that the user names: each solve has smaller patches where the check
//! of the one before found the picture wrong.

use super::audited::audit;
use super::cost::{CostModel, Limits, Measured};
use super::goal_run::{GoalRun, Step};
use super::points::{PointErrors, points};
use super::refine::refined;
use super::trial::pace;
use super::until::{Known, Outcome, solve_until};
use super::verdict::{Obstacle, Verdict};
use crate::accuracy::{ErrorBudget, Estimate};
use crate::effects::EffectChoices;
use crate::memory::available_bytes;
use crate::mesh::{PatchMesh, Refinement};
use crate::scene::{Lighting, Scene};
use crate::solve::{Control, PipelineError, Progress, Solution, effect_costs};
use glam::DVec3;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a solve is to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// An error of irradiance as shown, relative to the light there, or at points; above zero.
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
    /// Whether all rows and sweeps were made; else the light is that of the rows that there was time for.
    pub complete: bool,
    /// How far it got, and what stood in the way.
    pub verdict: Verdict,
    /// All solves.
    pub attempts: Vec<Attempt>,
    /// What was learnt of the scene, for further predictions.
    pub model: CostModel,
    /// Seconds of all work, audits included.
    pub seconds: f64,
}

/// What is to be reached, and where.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// What is solved.
    pub scene: &'a Arc<Scene>,
    /// The lamps whose light is judged.
    pub lighting: &'a Lighting,
    /// How far to go.
    pub goal: Goal,
    /// Effects forced on or off.
    pub effects: &'a EffectChoices,
    /// Where an error counts: points in metres with unit normals; all over the picture where there are none.
    pub places: &'a [(DVec3, DVec3)],
}

/// What an observer of a search is told.
pub enum News<'a> {
    /// A solve goes on.
    Solving(&'a Progress<'a>),
    /// The light is being checked.
    Auditing,
}

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
    task: &Task<'_>,
    started: Instant,
    memory: f64,
    observer: &mut dyn FnMut(News<'_>) -> Control,
) -> Result<Reached, PipelineError> {
    let &Task { scene, lighting, goal, effects, places } = task;
    let deadline = match goal {
        Goal::Seconds(seconds) => Some(started + Duration::from_secs_f64(seconds.min(1e7))),
        Goal::Error(_) => None,
    };
    let elapsed = || started.elapsed().as_secs_f64();
    let mut model = CostModel::default();
    let limits = Limits { fewest: 1.0, most: MOST_PATCHES, gigabytes: memory };
    let mut run = GoalRun::new(goal, effects.clone(), limits);
    run.count_at(places.len());
    let mut best: Option<Solution> = None;
    let mut complete = true;
    let mut refinement: Option<Arc<Refinement>> = None;
    let mut survey = None;

    let mut step = Step::Solve;
    while step == Step::Solve {
        let settings = run.begin(&model);
        let clock = Instant::now();
        let known = Known { before: best.as_ref(), survey: survey.take(), model: &model };
        let solve = solve_until(scene.clone(), &settings, deadline, known, &mut survey, observer);
        let seconds = clock.elapsed().as_secs_f64();
        let mut solved = match solve {
            Ok(Outcome::Whole(solved)) => *solved,
            Ok(Outcome::Part(solved)) => {
                run.cut_short(solved.mesh.patches.len(), seconds);
                if best.is_none() {
                    (best, complete) = (Some(*solved), false);
                }
                break;
            }
            Ok(Outcome::TooLong) => {
                step = run.too_long(&model, elapsed());
                continue;
            }
            Err(error @ PipelineError::Memory { .. }) if best.is_some() => {
                run.stop(Obstacle::Refused(error.to_string()));
                break;
            }
            Err(error) => return Err(error),
        };

        // Check it, for a time in proportion.
        if observer(News::Auditing) == Control::Cancel {
            return Err(PipelineError::Cancelled);
        }
        let found = audit(&solved, lighting, &run.audit_settings(seconds, elapsed()), &|| false);
        solved.budget = found.as_ref().map(|found| found.budget);
        let budget = solved.budget.map(|budget| counted(budget, &solved, task));
        if let Some(found) = found {
            refinement = Some(Arc::new(refined(&solved.mesh, &found.map_of_patches, refinement.as_deref())));
            run.refine(refinement.clone());
        }
        let patches = solved.mesh.patches.len();
        let lines = run.next().lines as u32;
        let known = model.measured().last().map(|m| m.pace);
        let pace = known.unwrap_or_else(|| pace(&solved, lines));
        model.learn(Measured::of(&solved, lines, pace, budget.as_ref()));
        if run.attempts().is_empty() {
            run.set_fewest(fewest(&solved.mesh, run.next().patches));
        }
        if run.note(patches, seconds, budget) {
            best = Some(solved);
        }

        // Is it enough, and if not, what next?
        step = run.step(&model, budget.as_ref(), elapsed());
    }
    let Some(mut solved) = best else { return Err(PipelineError::Cancelled) };
    let seconds = elapsed();
    let verdict = run.verdict(&model, seconds);
    if complete {
        solved.plan = Arc::new(effect_costs(&solved));
    }
    let attempts = run.attempts().to_vec();
    Ok(Reached { solved: Arc::new(solved), complete, verdict, attempts, model, seconds })
}

/// The budget of a solve as it counts for the task. At points its parts are scaled to what the points' errors
/// come to, so that further ones are predicted by the same laws.
fn counted(budget: ErrorBudget, solved: &Solution, task: &Task<'_>) -> ErrorBudget {
    if task.places.is_empty() {
        return budget;
    }
    let light = solved.light(task.lighting);
    let there = points(solved, task.lighting, &light, task.places);
    let Some(error) = PointErrors::of(&there).map(|errors| errors.rms) else { return budget };
    let share = error / budget.total.error.max(f64::MIN_POSITIVE);
    let scaled = |e: Estimate| Estimate { error: share * e.error, low: share * e.low, high: share * e.high };
    ErrorBudget {
        form_factors: scaled(budget.form_factors),
        mesh: scaled(budget.mesh),
        direct: scaled(budget.direct),
        total: Estimate { error, low: error, high: error },
        ..budget
    }
}

/// The fewest patches that any mesh of a scene has, as this one tells, for which `asked` were asked for.
pub fn fewest(mesh: &PatchMesh, asked: f64) -> f64 {
    let (patches, whole) = (mesh.patches.len() as f64, mesh.statistics.whole_sides as f64);
    if patches - whole > COARSEST * asked { patches } else { whole.max(1.0) }
}
