//! What the worker does while nothing is asked for: light that has settled becomes finer.

use super::failure::Failure;
use super::handle::locked;
use super::worker::Worker;
use crate::solve::{
    Control, DirectTarget, ElementLight, PipelineError, Progress, Run, Stage, patch_reflectance, system,
};
use crate::solver::LightBases;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Each step halves the error of direct light, and may do so many times the work.
const STEP: u64 = 4;
/// Finer than this nobody sees, as [`DirectTarget::error`] has it.
const FINEST: f64 = 0.00125;

/// The step after a target; `None` after the last.
fn after(target: &DirectTarget) -> Option<DirectTarget> {
    (target.error > FINEST * 1.5).then(|| DirectTarget {
        error: 0.5 * target.error,
        most: target.most.saturating_mul(STEP as usize),
        work: target.work.saturating_mul(STEP),
    })
}

impl Worker<'_> {
    /// What there is to refine, where somebody wants that and nothing else is to be done.
    pub(super) fn at_leisure(&self) -> Option<DirectTarget> {
        let shared = &self.shared;
        let wanted = shared.leisure.load(Ordering::Acquire)
            && !shared.paused.load(Ordering::Acquire)
            && !self.broken_off
            && self.settled == Some(Stage::Converged);
        let light = self.element_light().filter(|_| wanted)?;
        if light.is_of_hour { after(&light.target) } else { Some(light.target) }
    }

    /// Lays out direct light anew, as finely as the target says, and lights all from it; shows it once it is whole, and
    /// only if it is better.
    pub(super) fn refine(&mut self, target: DirectTarget) {
        let pool = self.pool;
        let refined = catch_unwind(AssertUnwindSafe(|| pool.install(|| self.refined(target))));
        self.snapshot.refining = None;
        match refined {
            Ok(Ok((elements, bases))) => {
                let bases = Arc::new(bases);
                self.state.bases = Some(Arc::clone(&bases));
                let timings = self.snapshot.timings;
                if let Some(solution) = self.snapshot.solution_mut() {
                    (solution.element_light, solution.bases) = (Some(Arc::new(elements)), bases);
                    solution.timings = timings;
                }
                self.publish(Stage::Converged);
            }
            Ok(Err(failure)) => {
                // What a request has ended begins anew after that.
                let is_over = !matches!(failure, Failure::Cancelled);
                self.broken_off = is_over || self.shared.stopped.load(Ordering::Acquire);
                self.publish(Stage::Converged);
            }
            Err(panic) => self.fail(panic.as_ref()),
        }
    }

    fn refined(&mut self, target: DirectTarget) -> Result<(ElementLight, LightBases), Failure> {
        let prepared = self.state.prepared.clone().ok_or(Failure::Cancelled)?;
        let transport = self.state.transport.clone().ok_or(Failure::Cancelled)?;
        let present = self.element_light().cloned().ok_or(Failure::Cancelled)?;
        let reflectance = patch_reflectance(&prepared.mesh, &|material| self.reflectance_of(material));
        let system = system(&prepared, &reflectance);
        let focus = *locked(&self.shared.focus);
        let laid_out = self.quietly(|run| run.finer_elements(&prepared, target, focus, &system))?;
        if present.is_of_hour && laid_out.elements.expected_error >= present.elements.expected_error {
            let bases = self.state.bases.as_deref().cloned().ok_or(Failure::Cancelled)?;
            return Ok((ElementLight { target, ..ElementLight::clone(&present) }, bases));
        }
        let settled = self.quietly(|run| run.settle(&prepared, laid_out, transport.as_ref(), &system))?;
        let lit = system.with_direct(Some(&settled.given));
        let (start, tolerance) = (self.state.bases.clone(), self.state.settings.tolerance);
        let (bases, sweeps) =
            self.quietly(|run| run.sweeps(&prepared, transport.as_ref(), &lit, start.as_deref(), tolerance))?;
        if let Some(solution) = self.snapshot.solution_mut() {
            solution.sweeps = sweeps;
        }
        Ok((settled, bases))
    }

    /// Runs a part of the pipeline while the light that stands stays on screen; ends when somebody asks for something.
    fn quietly<T>(
        &mut self,
        part: impl FnOnce(&mut Run<'_>) -> Result<T, PipelineError>,
    ) -> Result<T, Failure> {
        let shared = Arc::clone(&self.shared);
        let timings = self.snapshot.timings;
        let mut observer = |progress: Progress<'_>| {
            if !shared.leisure.load(Ordering::Acquire) {
                return Control::Cancel;
            }
            self.snapshot.refining = Some(progress.fraction);
            self.publish(Stage::Converged);
            Control::Rested(self.rest_while_paused(Stage::Converged))
        };
        let mut run = Run::new(&mut observer, &shared.cancel, timings);
        let result = part(&mut run);
        self.snapshot.timings = run.timings;
        result.map_err(Failure::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refinement_at_leisure_has_an_end_and_each_step_is_finer_than_the_last() {
        let mut target = DirectTarget::default();
        let mut steps = 0;
        while let Some(next) = after(&target) {
            assert!(next.serves(&target) && !target.serves(&next));
            (target, steps) = (next, steps + 1);
        }
        assert!((1..=4).contains(&steps) && target.error >= FINEST, "{steps} steps, {target:?}");
    }
}
