//! One solve on the way to a goal, given up in time for a deadline.

use super::cost::CostModel;
use super::goal::News;
use super::trial::trial;
use crate::mesh::{LightSearch, Survey};
use crate::scene::Scene;
use crate::solve::{
    Control, PipelineError, Prepared, Progress, Run, Solution, SolveSettings, Stage, Timings,
    patch_reflectance, system,
};
use crate::solver::LightBases;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// What earlier solves of the scene left.
pub(super) struct Known<'a> {
    /// The best of them, to fall back on; its light is refined.
    pub(super) before: Option<&'a Solution>,
    /// What meshes rest on.
    pub(super) survey: Option<Arc<Survey>>,
    /// What they tell of further ones.
    pub(super) model: &'a CostModel,
}

pub(super) enum Outcome {
    /// All of it.
    Whole(Box<Solution>),
    /// The light of the rows that there was time for; no form factors.
    Part(Box<Solution>),
    /// Given up, since it would not end in time.
    TooLong,
}

/// How a run ended that was not cancelled.
enum Ended {
    Whole(Box<Solution>),
    TooLong,
}

/// Of the time left a full survey may take this part, and the patches that it is followed by.
const SURVEY_SHARE: f64 = 0.25;
/// A full survey takes so many times as long as a quick one, about.
const FULL_OVER_QUICK: f64 = 8.0;

/// Solves, and gives up in time for `deadline`, at whatever stage. With a solve to fall back on it does not even
/// begin its rows where a trial of some says that they would take too long; without one the first picture is
/// waited for. Leaves the `survey` of the scene for the next.
pub(super) fn solve_until(
    scene: Arc<Scene>,
    settings: &SolveSettings,
    deadline: Option<Instant>,
    known: Known<'_>,
    survey: &mut Option<Arc<Survey>>,
    observer: &mut dyn FnMut(News<'_>) -> Control,
) -> Result<Outcome, PipelineError> {
    let has_another = known.before.is_some();
    let cancel = AtomicBool::new(false);
    // Whatever the time: the first picture is waited for.
    let has_picture = AtomicBool::new(has_another);
    let mut so_far: Option<LightBases> = None;
    let mut cancelled_by_observer = false;
    let mut keep = |progress: Progress<'_>| {
        let early = matches!(progress.stage, Stage::FirstLight | Stage::Rows);
        if deadline.is_some()
            && early
            && !has_another
            && let Some(picture) = progress.picture()
        {
            so_far = Some(picture);
            has_picture.store(true, Ordering::Relaxed);
        }
        let answer = observer(News::Solving(&progress));
        cancelled_by_observer |= answer == Control::Cancel;
        answer
    };
    let mut prepared = None;
    let (ended, timings) = std::thread::scope(|scope| {
        // The thread ends when its sender is dropped, or at the deadline.
        let (alive, ended) = channel::<()>();
        if let Some(deadline) = deadline {
            let (cancel, has_picture) = (&cancel, &has_picture);
            scope.spawn(move || {
                let wait = deadline.saturating_duration_since(Instant::now());
                let mut waited = ended.recv_timeout(wait);
                while waited == Err(RecvTimeoutError::Timeout) && !has_picture.load(Ordering::Relaxed) {
                    waited = ended.recv_timeout(Duration::from_millis(2));
                }
                if waited == Err(RecvTimeoutError::Timeout) {
                    cancel.store(true, Ordering::Relaxed);
                }
            });
        }
        let mut run = Run::new(&mut keep, &cancel, Timings::default());
        let ended = (|| {
            let made = mesh(&mut run, scene, settings, deadline, known.survey)?;
            *survey = Some(made.survey.clone());
            let made = prepared.insert(made);
            solve(&mut run, made, settings, deadline, (known.before, known.model))
        })();
        let timings = run.timings;
        drop(alive);
        (ended, timings)
    });
    let given_up = cancel.load(Ordering::Relaxed) && !cancelled_by_observer;
    let Some(prepared) = prepared else {
        return match ended {
            Err(PipelineError::Cancelled) if given_up && has_another => Ok(Outcome::TooLong),
            Err(error) => Err(error),
            Ok(_) => Ok(Outcome::TooLong),
        };
    };
    match ended {
        Ok(Ended::Whole(solution)) => Ok(Outcome::Whole(solution)),
        Ok(Ended::TooLong) => Ok(Outcome::TooLong),
        Err(PipelineError::Cancelled) if given_up && has_another => Ok(Outcome::TooLong),
        Err(PipelineError::Cancelled) if given_up => {
            let system = system(&prepared, &patch_reflectance(&prepared.mesh, &|_| None));
            let bases = so_far.unwrap_or(LightBases {
                patches: system.patches(),
                lamps: system.lamps,
                bands: system.bands,
                values: vec![0.0; system.patches() * system.columns()],
            });
            let part = Solution { bases: Arc::new(bases), timings, ..Solution::new(&prepared, settings) };
            Ok(Outcome::Part(Box::new(part)))
        }
        Err(error) => Err(error),
    }
}

/// Cuts the scene into patches. Where there is no survey yet and time presses, a quick one is made, and a full
/// one only where it takes little of the time that is left.
fn mesh(
    run: &mut Run<'_>,
    scene: Arc<Scene>,
    settings: &SolveSettings,
    deadline: Option<Instant>,
    survey: Option<Arc<Survey>>,
) -> Result<Prepared, PipelineError> {
    let Some(deadline) = deadline.filter(|_| survey.is_none()) else {
        return run.prepare(scene, settings, (survey, LightSearch::Full));
    };
    let quick = run.prepare(scene.clone(), settings, (None, LightSearch::Quick))?;
    if FULL_OVER_QUICK * quick.timings.survey > SURVEY_SHARE * seconds_until(deadline) {
        return Ok(quick);
    }
    run.prepare(scene, settings, (None, LightSearch::Full))
}

fn seconds_until(deadline: Instant) -> f64 {
    deadline.saturating_duration_since(Instant::now()).as_secs_f64()
}

/// Rows, balance and sweeps, from the light of the solve before where there is one.
fn solve(
    run: &mut Run<'_>,
    prepared: &Prepared,
    settings: &SolveSettings,
    deadline: Option<Instant>,
    (before, model): (Option<&Solution>, &CostModel),
) -> Result<Ended, PipelineError> {
    let lines = settings.resolution.unwrap_or(settings.method.default_resolution());
    let meshed = prepared.timings.mesh + prepared.timings.plan;
    if let Some(deadline) = deadline
        && before.is_some()
        && model
            .seconds_of(prepared, &trial(prepared, lines))
            .is_some_and(|s| s - meshed > 0.95 * seconds_until(deadline))
    {
        return Ok(Ended::TooLong);
    }
    let standing = before.and_then(|b| b.bases.carried(&b.mesh, &prepared.mesh));
    Ok(Ended::Whole(Box::new(run.finish(prepared, settings, standing)?)))
}
