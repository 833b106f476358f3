//! The stage of a solve that computes rows, and lights the scene on the way.

use super::arriving::Arriving;
use super::element_light::ElementLight;
use super::error::PipelineError;
use super::memory::check_memory;
use super::pipeline::{ELEMENTS, Pictured, Prepared, ROWS, ROWS_OF_LAMPS, Run, Stage};
use super::store::RowStore;
use crate::form_factors::{Row, RowComputer};
use crate::solver::{LightBases, System};
use crate::transport::{NodeScratch, Sent, TransportKind, TreePlan};
use crate::watch::Watch;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Computes those of the rows of some patches that are not known, and keeps them as they are; how many those were.
fn complete(computer: &RowComputer, picked: &[u32], known: &mut RowStore) -> usize {
    let missing: Vec<u32> = picked.iter().copied().filter(|&i| !known.has(i)).collect();
    let fresh: Vec<Row> =
        missing.par_iter().map_init(|| computer.scratch(), |scratch, &i| computer.row(i, scratch)).collect();
    for (&i, row) in missing.iter().zip(fresh) {
        known.keep(i, row);
    }
    missing.len()
}

/// Collapses those rows of some patches that stand as they were sampled.
fn collapse(computer: &RowComputer, picked: &[u32], known: &mut RowStore) {
    let Some(plan) = known.plan().cloned() else { return };
    let rows: Vec<(u32, &Row)> = picked.iter().filter_map(|&i| Some((i, known.raw(i)?))).collect();
    let collapsed: Vec<_> = rows
        .par_iter()
        .map_init(NodeScratch::default, |scratch, &(i, row)| (i, plan.row(computer, i, row, scratch)))
        .collect();
    for (i, row) in collapsed {
        known.keep_collapsed(i, row);
    }
}

/// Lights the scene by the rows of some patches that are known, in this order.
fn pass_on(
    arriving: &mut Arriving,
    (computer, system): (&RowComputer, &System),
    picked: &[u32],
    known: &RowStore,
) {
    for &i in picked {
        if let Some(sum) = known.sum(i) {
            arriving.see(system, i, sum);
        }
        if let Some(row) = known.raw(i) {
            arriving.take(system, i, row);
        } else if let Some(row) = known.expanded(computer, i) {
            arriving.take(system, i, &row);
        }
    }
}

fn lamps(prepared: &Prepared) -> Vec<u32> {
    let mesh = &prepared.mesh;
    // What glows by photometry lights nothing by itself.
    let shines = |&i: &u32| mesh.patches[i as usize].luminaire.is_some_and(|lamp| !mesh.is_photometric(lamp));
    (0..prepared.mesh.patches.len() as u32).filter(shines).collect()
}

impl Run<'_> {
    /// The first light of a dark scene, a value a patch: the rows of the lamps, kept in `known`; or, where something shines that
    /// is no patch, by few rays. Then it gives what surfaces pass on, about. Where the light of an earlier solve `stands`,
    /// the rows of lamps come with all others.
    ///
    /// # Errors
    /// There is not enough memory for all rows, or the run was ended.
    pub fn first_light(
        &mut self,
        prepared: &Prepared,
        system: &System,
        stands: bool,
        known: &mut RowStore,
    ) -> Result<Option<LightBases>, PipelineError> {
        let n = prepared.mesh.patches.len();
        let computer = &prepared.computer;
        if known.known() == 0 {
            self.choose_transport(prepared, system, known)?;
            (self.timings.first_light, self.timings.rows) = (0.0, 0.0);
        }
        known.resize(n);
        if stands {
            return Ok(None);
        }
        let before = self.timings.rows;
        let clock = self.clock();
        if let Some(passed_on) = self.glimpse(prepared, system, ROWS_OF_LAMPS)? {
            self.timings.first_light = clock.seconds(self);
            return Ok(Some(passed_on));
        }
        let mut arriving = Arriving::new(system, None);
        let lamps = lamps(prepared);
        let (mut done, mut computed) = (0, 0);
        for picked in lamps.chunks(computer.batch().max(1)) {
            computed += complete(computer, picked, known);
            pass_on(&mut arriving, (computer, system), picked, known);
            done += picked.len();
            let is_last = done == lamps.len();
            if computed > 0 {
                self.timings.rows = before + clock.seconds(self);
                self.timings.first_light = self.timings.rows;
            }
            let fraction = ROWS_OF_LAMPS * done as f64 / lamps.len() as f64;
            let picture = Some(Pictured::Arriving(&arriving, system));
            let counts = (known.known(), n);
            self.tell(Stage::FirstLight, counts, (fraction, None), &[], picture, is_last)?;
        }
        Ok(None)
    }

    /// Decides which transport the rows are for, and whether it would fit into the memory.
    fn choose_transport(
        &mut self,
        prepared: &Prepared,
        system: &System,
        known: &mut RowStore,
    ) -> Result<(), PipelineError> {
        let cancel = self.cancel;
        let cancelled = || cancel.load(Ordering::Relaxed);
        let kind = check_memory(&prepared.computer, system, prepared.transport, &cancelled)?;
        known.kind = Some(kind);
        Ok(())
    }

    /// All rows; lights the scene on the way, from its direct light where the system has it, else from what lamps emit,
    /// those with the most unshot power first. Where the light of an earlier solve is `standing` on these patches, it is
    /// refined instead, the brightest patches first.
    ///
    /// They are kept in `known`, each collapsed at once where they are for a tree, and those of the same mesh and computer that
    /// are there already are not computed again. `elements` tell who has to hold which patches by themselves.
    ///
    /// # Errors
    /// The run was ended; what there is then is left in `known`.
    pub fn rows(
        &mut self,
        prepared: &Prepared,
        system: &System,
        elements: Option<&ElementLight>,
        standing: Option<LightBases>,
        known: &mut RowStore,
    ) -> Result<LightBases, PipelineError> {
        let n = prepared.mesh.patches.len();
        let computer = &prepared.computer;
        if known.kind.is_none() {
            self.choose_transport(prepared, system, known)?;
        }
        known.resize(n);
        let mut left_to_compute = n - known.known();
        let before = if left_to_compute < n { self.timings.rows } else { 0.0 };
        let clock = self.clock();
        if known.kind == Some(TransportKind::Tree) && known.plan().is_none() {
            self.plan_tree(prepared, system, elements, known)?;
            left_to_compute = n - known.known();
        }
        let is_dark = standing.is_none();
        let mut arriving = Arriving::new(system, standing);
        for i in 0..n as u32 {
            if let Some(sum) = known.sum(i) {
                arriving.see(system, i, sum);
            }
        }
        if left_to_compute < n && is_dark {
            // Direct light as it has been laid out since the last picture.
            let picture = Some(Pictured::Arriving(&arriving, system));
            self.tell(Stage::Rows, (n - left_to_compute, n), (ELEMENTS, None), &[], picture, true)?;
        }
        let batch = computer.batch();
        let (mut done, mut computed) = (0, 0);
        while done < n {
            let picked = arriving.brightest(system, batch);
            let missing = complete(computer, &picked, known);
            pass_on(&mut arriving, (computer, system), &picked, known);
            collapse(computer, &picked, known);
            done += picked.len();
            computed += missing;
            left_to_compute -= missing;
            let elapsed = clock.seconds(self);
            self.timings.rows = before + elapsed;
            let is_lit = self.timings.first_light > 0.0;
            if matches!(arriving, Arriving::Refined(_)) && done == n && computed > 0 && !is_lit {
                self.timings.first_light = before + elapsed;
            }
            if computed == 0 && done < n && !self.cancel.load(Ordering::Relaxed) {
                // Until it has caught up, the picture would be darker than the one that is there.
                continue;
            }
            let fraction = ELEMENTS + (ROWS - ELEMENTS) * (n - left_to_compute) as f64 / n as f64;
            let left = (computed > 0).then(|| {
                let rows = elapsed * left_to_compute as f64 / computed as f64;
                rows + (before + elapsed + rows) / 9.0
            });
            let picture = Some(Pictured::Arriving(&arriving, system));
            let counts = (n - left_to_compute, n);
            self.tell(Stage::Rows, counts, (fraction, left), &[], picture, false)?;
        }
        Ok(arriving.bases())
    }

    /// Decides how rows are collapsed: by direct light, as the system has it or as the rows of the lamps tell it, and by
    /// some rows that are kept.
    fn plan_tree(
        &mut self,
        prepared: &Prepared,
        system: &System,
        elements: Option<&ElementLight>,
        known: &mut RowStore,
    ) -> Result<(), PipelineError> {
        let n = prepared.mesh.patches.len();
        let computer = &prepared.computer;
        let lamps = if system.direct.is_some() { Vec::new() } else { lamps(prepared) };
        let probes = TreePlan::probes(n);
        for picked in [&lamps, &probes].into_iter().flat_map(|list| list.chunks(computer.batch().max(1))) {
            complete(computer, picked, known);
            self.tell(Stage::Rows, (known.known(), n), (ELEMENTS, None), &[], None, false)?;
        }
        let direct = match &system.direct {
            Some(direct) => Arc::clone(direct),
            None => {
                let mut arriving = Arriving::new(system, None);
                pass_on(&mut arriving, (computer, system), &lamps, known);
                Arc::new(arriving.bases())
            }
        };
        let reach = elements.map_or_else(Vec::new, |elements| elements.reach(prepared));
        let rows = probes.iter().filter_map(|&i| Some((i, known.raw(i)?.clone()))).collect();
        let sent = Sent { direct: &direct.values, lamps: direct.lamps, bands: direct.bands, reach: &reach };
        let cancel = self.cancel;
        let cancelled = || cancel.load(Ordering::Relaxed);
        let mut nobody = |_| {};
        let plan = TreePlan::new(computer, sent, rows, &mut Watch::new(&cancelled, &mut nobody))?;
        known.begin_tree(plan);
        Ok(())
    }
}
