//! What the effects of a solved scene cost, from its own timings.

use super::{Prepared, Solution, Timings};
use crate::effects::{Effect, EffectPlan};
use crate::form_factors::{RowComputer, RowScratch};
use crate::mesh::{PatchMesh, Side};
use crate::solver::columns_read;
use std::time::{Duration, Instant};

/// Rows that are timed with and without occlusion.
const PROBES: usize = 12;

/// The plan with what each effect that is on took over leaving it out, seconds of the solve that
/// `timings` tells of:
///
/// - visibility: the rows' time, less the share of it that closed forms alone take, from a few rows;
/// - colour bands: the sweeps' time, less that of the passes over the rows that one band needs;
/// - two-sided surfaces: the share of backs in the time of rows and sweeps;
/// - translucency: the share of the patches that pass light in the time of sweeps;
/// - glass and holes: the rows' time, less the share of it that they take without panes, from a few rows; by their counts
///   where there are both.
///
/// Textures and smooth surfaces take nothing from a solve: one is read while meshing, one at display.
pub fn measured(prepared: &Prepared, lamps: usize, timings: &Timings) -> EffectPlan {
    costs((&prepared.plan, &prepared.mesh, &prepared.computer), lamps, timings)
}

fn costs(
    (plan, mesh, computer): (&EffectPlan, &PatchMesh, &RowComputer),
    lamps: usize,
    timings: &Timings,
) -> EffectPlan {
    let mut measured = plan.clone();
    let patches = mesh.patches.len().max(1);
    let without_glass = computer.without_glass();
    for effect in Effect::ALL.into_iter().filter(|&e| plan.is_on(e)) {
        let seconds = match effect {
            Effect::Visibility => {
                timings.rows
                    * share_of(computer, |scratch, patch| {
                        drop(computer.unoccluded_row(patch, scratch));
                    })
            }
            Effect::ColourBands => {
                timings.sweeps * (1.0 - columns_read(lamps) as f64 / columns_read(3 * lamps).max(1) as f64)
            }
            Effect::TwoSided => {
                let backs = mesh.patches.iter().filter(|p| p.side == Side::Back).count();
                (timings.rows + timings.sweeps) * backs as f64 / patches as f64
            }
            Effect::Glass | Effect::Holes => {
                let glass = mesh.panes.glass().count() as f64 / mesh.panes.list.len().max(1) as f64;
                let own = if effect == Effect::Glass { glass } else { 1.0 - glass };
                timings.rows
                    * own
                    * share_of(computer, |scratch, patch| {
                        drop(without_glass.row(patch, scratch));
                    })
            }
            Effect::Translucency => timings.sweeps * mesh.translucence.len() as f64 / patches as f64,
            Effect::Textures | Effect::SmoothSurfaces => 0.0,
        };
        if let Some(decision) = measured.decisions.iter_mut().find(|d| d.effect == effect) {
            decision.measured = Some(Duration::from_secs_f64(seconds.max(0.0)));
        }
    }
    measured
}

/// The plan of a finished solve with the seconds that each effect took over leaving it out; zero where leaving
/// it out would not have been faster.
pub fn effect_costs(solved: &Solution) -> EffectPlan {
    costs((&solved.plan, &solved.mesh, &solved.computer), solved.bases.lamps, &solved.timings)
}

/// The share of a row's time that is saved by gathering it in the other way, 0 to 1.
fn share_of(computer: &RowComputer, other: impl Fn(&mut RowScratch, u32)) -> f64 {
    let n = computer.mesh().patches.len();
    let mut scratch = computer.scratch();
    let [mut with, mut without] = [0.0; 2];
    for k in 0..PROBES.min(n) {
        let patch = (k * n / PROBES.min(n)) as u32;
        let clock = Instant::now();
        drop(computer.row(patch, &mut scratch));
        with += clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        other(&mut scratch, patch);
        without += clock.elapsed().as_secs_f64();
    }
    if with > without { 1.0 - without / with } else { 0.0 }
}
