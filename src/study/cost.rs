//! What a solve will cost and how wrong it will be, from solves that were measured.

use crate::accuracy::ErrorBudget;
use crate::session::{Prepared, Solved, Timings};
use rayon::prelude::*;
use std::time::Instant;

/// How fine a solve is: what its cost and its error depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Patches.
    pub patches: f64,
    /// Half-planes a row.
    pub lines: f64,
}

/// A solve that was made by lines, with its cost and, where it was audited, its errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// How fine it was.
    pub fineness: Fineness,
    /// Seconds by stage.
    pub timings: Timings,
    /// Stored form factors.
    pub entries: f64,
    /// Form factors and visibility, relative.
    pub form_factors: f64,
    /// Patches, relative.
    pub mesh: f64,
    /// In all, as shown, relative.
    pub total: f64,
}

/// Extrapolates cost and error from measured solves of one scene on this machine.
///
/// Rows cost by their lines and a little by how many patches a line crosses; the rest of a solve costs
/// by its form factors, which grow with the square of the patches. Errors fall by powers: those of
/// form factors with lines and patches, that of the mesh with patches, its power fitted where two
/// audits tell it.
#[derive(Clone, Debug, Default)]
pub struct CostModel {
    measured: Vec<Measured>,
}

/// What one row costs besides its lines, as lines.
const LINES_OF_A_ROW: f64 = 24.0;
/// Power of the patches in the cost of a row.
const ROW_GROWTH: f64 = 0.25;
/// Powers by which errors fall.
const BY_LINES: f64 = 1.1;
const FORM_FACTORS_BY_PATCHES: f64 = 0.35;
const MESH_BY_PATCHES: f64 = 0.6;

impl Measured {
    /// Of a finished solve by lines with its budget; errors unknown without one.
    pub fn of(solved: &Solved, lines: u32, budget: Option<&ErrorBudget>) -> Self {
        let error = |of: &dyn Fn(&ErrorBudget) -> f64| budget.map_or(f64::NAN, of);
        Self {
            fineness: Fineness { patches: solved.mesh.patches.len() as f64, lines: f64::from(lines) },
            timings: solved.timings,
            entries: solved.form_factors.entries() as f64,
            form_factors: error(&|b| b.form_factors.error),
            mesh: error(&|b| b.mesh.error),
            total: error(&|b| b.total.error),
        }
    }

    fn is_audited(&self) -> bool {
        self.total.is_finite()
    }
}

impl CostModel {
    /// Learns from one more solve; the latest counts.
    pub fn learn(&mut self, measured: Measured) {
        self.measured.push(measured);
    }

    /// All solves so far.
    pub fn measured(&self) -> &[Measured] {
        &self.measured
    }

    /// Seconds that a solve of this fineness takes, loading left out; `None` before the first solve.
    pub fn seconds(&self, wanted: Fineness) -> Option<f64> {
        let base = self.measured.last()?;
        let patches = wanted.patches / base.fineness.patches;
        let lines = (wanted.lines + LINES_OF_A_ROW) / (base.fineness.lines + LINES_OF_A_ROW);
        let t = &base.timings;
        Some(
            (t.mesh + t.plan) * patches
                + t.rows * patches.powf(1.0 + ROW_GROWTH) * lines
                + (t.balance + t.sweeps) * patches * patches,
        )
    }

    /// Seconds of a solve whose rows can be tried: times a few of them, spread over the scene.
    pub fn probe(&self, prepared: &Prepared) -> Option<f64> {
        const TRIED: usize = 48;
        let base = self.measured.last()?;
        let n = prepared.mesh.patches.len();
        let tried: Vec<u32> = (0..TRIED.min(n)).map(|k| (k * n / TRIED.min(n)) as u32).collect();
        let clock = Instant::now();
        let entries: usize = tried
            .par_iter()
            .map_init(
                || prepared.computer.scratch(),
                |scratch, &i| prepared.computer.row(i, scratch).patches.len(),
            )
            .sum();
        let share = n as f64 / tried.len().max(1) as f64;
        let rows = clock.elapsed().as_secs_f64() * share;
        let rest = base.timings.balance + base.timings.sweeps;
        Some(rows + rest * entries as f64 * share / base.entries.max(1.0))
    }

    /// Gigabytes that the form factors need while they are assembled.
    pub fn gigabytes(&self, patches: f64) -> Option<f64> {
        let base = self.measured.last()?;
        Some(base.entries * (patches / base.fineness.patches).powi(2) * 17.0 / 1e9)
    }

    /// Error as shown of a solve of this fineness; `None` before the first audit.
    pub fn error(&self, wanted: Fineness) -> Option<f64> {
        let base = self.measured.iter().rev().find(|m| m.is_audited())?;
        let patches = base.fineness.patches / wanted.patches;
        let lines = base.fineness.lines / wanted.lines;
        let form_factors = base.form_factors * patches.powf(FORM_FACTORS_BY_PATCHES) * lines.powf(BY_LINES);
        let mesh = base.mesh * patches.powf(self.mesh_power());
        // The two are not independent: smoothing takes some of the one for the other.
        let together = base.form_factors.hypot(base.mesh);
        let factor = if together > 0.0 { base.total / together } else { 1.0 };
        Some(form_factors.hypot(mesh) * factor.clamp(0.5, 1.5))
    }

    /// Fitted to the two audited solves that differ most in patches, within what is plausible.
    fn mesh_power(&self) -> f64 {
        let audited = || self.measured.iter().filter(|m| m.is_audited() && m.mesh > 0.0);
        let order = |a: &&Measured, b: &&Measured| a.fineness.patches.total_cmp(&b.fineness.patches);
        let (Some(coarse), Some(fine)) = (audited().min_by(order), audited().max_by(order)) else {
            return MESH_BY_PATCHES;
        };
        let ratio = fine.fineness.patches / coarse.fineness.patches;
        if ratio < 2.5 {
            return MESH_BY_PATCHES;
        }
        ((coarse.mesh / fine.mesh).ln() / ratio.ln()).clamp(0.45, 1.0)
    }

    /// The cheapest fineness whose error stays below `error`, within `gigabytes` and above the patches
    /// that the scene has at least; `None` before the first audit, or where none does.
    pub fn cheapest(&self, error: f64, limits: Limits) -> Option<Fineness> {
        let fits = |f: &Fineness| self.error(*f).is_some_and(|e| e <= error);
        let cost = |f: &Fineness| self.seconds(*f).unwrap_or(f64::INFINITY);
        self.candidates(limits).into_iter().filter(fits).min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// The most accurate fineness that takes at most `seconds`.
    pub fn best_within(&self, seconds: f64, limits: Limits) -> Option<Fineness> {
        let fits = |f: &Fineness| self.seconds(*f).is_some_and(|s| s <= seconds);
        let error = |f: &Fineness| self.error(*f).unwrap_or(1.0 / (f.patches * f.lines));
        self.candidates(limits).into_iter().filter(fits).min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    fn candidates(&self, limits: Limits) -> Vec<Fineness> {
        let Some(base) = self.measured.last() else { return Vec::new() };
        let steps = -12..=30;
        let counts = steps.map(|k| base.fineness.patches * 2.0_f64.powf(f64::from(k) / 5.0));
        let counts = counts.filter(|&n| {
            (limits.fewest..=limits.most).contains(&n)
                && self.gigabytes(n).is_some_and(|gb| gb <= limits.gigabytes)
        });
        counts.flat_map(|patches| LINES.map(|lines| Fineness { patches, lines: f64::from(lines) })).collect()
    }
}

/// Half-planes to choose from.
const LINES: [u32; 12] = [24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];

/// What choices keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Patches at least: surfaces are not joined.
    pub fewest: f64,
    /// Patches at most.
    pub most: f64,
    /// Memory for form factors at most, GB.
    pub gigabytes: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(patches: f64, lines: f64, [form_factors, mesh]: [f64; 2]) -> Measured {
        Measured {
            fineness: Fineness { patches, lines },
            timings: Timings { rows: 1.0, balance: 0.5, sweeps: 0.5, ..Timings::default() },
            entries: 1e6,
            form_factors,
            mesh,
            total: form_factors.hypot(mesh),
        }
    }

    const LIMITS: Limits = Limits { fewest: 100.0, most: 1e6, gigabytes: 8.0 };

    #[test]
    fn choices_meet_the_target_and_none_cheaper_does() {
        let mut model = CostModel::default();
        assert!(model.cheapest(0.01, LIMITS).is_none());
        model.learn(measured(1000.0, 64.0, [0.02, 0.05]));
        let found = model.cheapest(0.02, LIMITS).unwrap();
        assert!(model.error(found).unwrap() <= 0.02);
        assert!(found.patches > 1000.0 && found.lines > 64.0, "both errors are too large: {found:?}");
        let seconds = model.seconds(found).unwrap();
        let best = model.best_within(seconds, LIMITS).unwrap();
        assert!(model.error(best).unwrap() <= model.error(found).unwrap());
        assert!(model.best_within(1e-3, LIMITS).is_none());
    }

    #[test]
    fn memory_bounds_the_patches() {
        let mut model = CostModel::default();
        model.learn(measured(1000.0, 64.0, [0.02, 0.5]));
        let tight = Limits { gigabytes: 0.1, ..LIMITS };
        let best = model.best_within(1e9, tight).unwrap();
        assert!(model.gigabytes(best.patches).unwrap() <= 0.1);
        assert!(model.cheapest(0.001, tight).is_none());
    }

    #[test]
    fn the_power_of_the_mesh_is_learnt() {
        let mut model = CostModel::default();
        model.learn(measured(1000.0, 64.0, [0.001, 0.08]));
        model.learn(measured(4000.0, 64.0, [0.001, 0.02]));
        // Mesh error as 1 / n: a quarter of the error at four times the patches.
        let at = model.error(Fineness { patches: 16_000.0, lines: 64.0 }).unwrap();
        assert!((at / 0.005 - 1.0).abs() < 0.05, "{at}");
    }
}
