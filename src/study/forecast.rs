//! What solves of a scene will take, told from one small solve and its check.

use super::audited::audit;
use super::cost::{CostModel, Fineness, Limits, Measured};
use super::goal::{Goal, MOST_PATCHES, News, fewest};
use super::goal_run::{GoalRun, WORK_A_SECOND, direct_target};
use super::trial::pace;
use crate::accuracy::AuditSettings;
use crate::direct::{DEAR, NEARLY};
use crate::effects::EffectChoices;
use crate::form_factors::Method;
use crate::scene::{Lighting, Scene};
use crate::solve::{Control, DirectTarget, PipelineError, Solution, solve};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The small solve is made as for this error, and is checked for so many seconds.
const FIRST: f64 = 0.1;
const CHECK: f64 = 4.0;
/// Elements grow with this power of what they are off by: 1.05 to 1.6 in four scenes, more where thin things throw shadows.
const ELEMENTS: f64 = 1.3;
/// Bytes of an element while it is laid out, with its corner, its light and what it may see (gallery, a million: 1.15 GB), and of
/// the program besides.
const ELEMENT_BYTES: f64 = 1150.0;
const PROGRAM_GIGABYTES: f64 = 0.06;

/// What one solve is predicted to take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Patches.
    pub patches: f64,
    /// Elements of direct light, the triangles of the mesh included.
    pub elements: f64,
    /// Seconds on this machine, reading left out.
    pub seconds: f64,
    /// Memory, GB.
    pub gigabytes: f64,
    /// Error as shown, relative.
    pub error: f64,
}

/// What was learnt of a scene by a small solve.
#[derive(Clone, Debug)]
pub struct Outlook {
    model: CostModel,
    limits: Limits,
    /// Elements of that solve, and what they expected to be off by.
    elements: f64,
    expected: f64,
    seconds_of_elements: f64,
    /// Seconds that it took, its check included.
    pub seconds: f64,
    /// What it came to.
    pub measured: Measured,
}

impl Outlook {
    /// Solves a scene coarsely and checks it; `None` where no light arrives. `memory` is what form factors may take, GB.
    ///
    /// # Errors
    /// As [`solve`].
    pub fn of(
        scene: &Arc<Scene>,
        lighting: &Lighting,
        effects: &EffectChoices,
        memory: f64,
        observer: &mut dyn FnMut(News<'_>) -> Control,
    ) -> Result<Option<Self>, PipelineError> {
        let mut model = CostModel::default();
        let mut limits = Limits { fewest: 1.0, most: MOST_PATCHES, gigabytes: memory };
        let mut run = GoalRun::new(Goal::Error(FIRST), effects.clone(), limits);
        let settings = run.begin(&model);
        let cancel = AtomicBool::new(false);
        let solved =
            solve(scene.clone(), &settings, &cancel, &mut |progress| observer(News::Solving(&progress)))?;
        if observer(News::Auditing) == Control::Cancel {
            return Err(PipelineError::Cancelled);
        }
        let check = AuditSettings { seconds: CHECK, precision: 0.1, ..AuditSettings::default() };
        let Some(found) = audit(&solved, lighting, &check, &|| false) else { return Ok(None) };
        let lines = run.next().lines as u32;
        let measured = Measured::of(&solved, lines, pace(&solved, lines), Some(&found.budget));
        model.learn(measured);
        limits.fewest = fewest(&solved.mesh, run.next().patches);
        let [elements, expected] = elements_of(&solved);
        let seconds = solved.timings.solve() + found.budget.seconds;
        let seconds_of_elements = solved.timings.elements;
        Ok(Some(Self { model, limits, elements, expected, seconds_of_elements, seconds, measured }))
    }

    /// What form factors may take, GB.
    pub fn memory(&self) -> f64 {
        self.limits.gigabytes
    }

    /// What a solve of so many patches at default settings takes.
    pub fn by_default(&self, patches: usize) -> Forecast {
        let lines = f64::from(Method::Lines.default_resolution());
        self.forecast(Fineness { patches: patches as f64, lines }, &DirectTarget::default())
    }

    /// What the last solve on the way to this error takes, a share above zero; `None` where no mesh in memory promises it.
    pub fn to(&self, error: f64) -> Option<Forecast> {
        let (target, [aim, direct]) = direct_target(error);
        let fineness = self.model.with_direct(direct).cheapest(aim, self.limits)?;
        Some(self.forecast(fineness, &target))
    }

    fn forecast(&self, wanted: Fineness, target: &DirectTarget) -> Forecast {
        let at = |error: f64| self.elements * (self.expected / error).max(0.0).powf(ELEMENTS);
        let seconds_of = |elements: f64| self.seconds_of_elements * elements / self.elements;
        let dear = target.work as f64 / DEAR as f64 / WORK_A_SECOND;
        let grown = at(target.error);
        let grown = if seconds_of(grown) > dear { at(NEARLY * target.error) } else { grown };
        // Each triangle of the mesh is one at least.
        let triangles = 2.0 * wanted.patches;
        let elements = grown.max(triangles).min(target.most as f64 + triangles);
        // What they are off by themselves falls as they grow.
        let direct = self.measured.direct * (self.elements / elements).powf(1.0 / ELEMENTS);
        let known = self.model.with_direct(direct);
        Forecast {
            patches: wanted.patches,
            elements,
            seconds: (known.seconds(wanted).unwrap_or(0.0) - self.seconds_of_elements).max(0.0)
                + seconds_of(elements),
            gigabytes: known.gigabytes(wanted).unwrap_or(0.0)
                + elements * ELEMENT_BYTES / 1e9
                + PROGRAM_GIGABYTES,
            error: known.error(wanted).unwrap_or(0.0),
        }
    }
}

/// Elements of a solve, and what they expect to be off by.
fn elements_of(solved: &Solution) -> [f64; 2] {
    let Some(light) = &solved.element_light else {
        return [2.0 * solved.mesh.patches.len() as f64, FIRST];
    };
    [light.elements.leaves().count() as f64, light.elements.expected_error.max(1e-6)]
}
