//! The stage of a solve that computes rows, and lights the scene on the way.

use super::arriving::Arriving;
use super::error::PipelineError;
use super::memory::check_memory;
use super::pipeline::{ELEMENTS, Pictured, Prepared, ROWS, ROWS_OF_LAMPS, Run, Stage};
use crate::form_factors::{Row, RowComputer};
use crate::solver::{LightBases, System};
use rayon::prelude::*;
use std::sync::atomic::Ordering;

/// Computes those of the rows of some patches that are not known, and keeps them; how many those were.
fn complete(computer: &RowComputer, picked: &[u32], known: &mut [Option<Row>]) -> usize {
    let missing: Vec<u32> = picked.iter().copied().filter(|&i| known[i as usize].is_none()).collect();
    let fresh: Vec<Row> =
        missing.par_iter().map_init(|| computer.scratch(), |scratch, &i| computer.row(i, scratch)).collect();
    for (&i, row) in missing.iter().zip(fresh) {
        known[i as usize] = Some(row);
    }
    missing.len()
}

impl Run<'_> {
    /// The rows of the lamps, kept in `known`: the first light of a dark scene, a value a patch. Where the light of an
    /// earlier solve `stands`, they come with all others.
    ///
    /// # Errors
    /// There is not enough memory for all rows, or the run was ended.
    pub fn first_light(
        &mut self,
        prepared: &Prepared,
        system: &System,
        stands: bool,
        known: &mut Vec<Option<Row>>,
    ) -> Result<(), PipelineError> {
        let n = prepared.mesh.patches.len();
        let computer = &prepared.computer;
        if known.iter().flatten().next().is_none() {
            let cancel = self.cancel;
            check_memory(computer, system, &|| cancel.load(Ordering::Relaxed))?;
            (self.timings.first_light, self.timings.rows) = (0.0, 0.0);
        }
        known.resize(n, None);
        if stands {
            return Ok(());
        }
        let before = self.timings.rows;
        let clock = self.clock();
        let mut arriving = Arriving::new(system, None);
        let shines = |&i: &u32| prepared.mesh.patches[i as usize].luminaire.is_some();
        let lamps: Vec<u32> = (0..n as u32).filter(shines).collect();
        let (mut done, mut computed) = (0, 0);
        for picked in lamps.chunks(computer.batch().max(1)) {
            computed += complete(computer, picked, known);
            for &i in picked {
                if let Some(row) = &known[i as usize] {
                    arriving.see(system, i, row);
                    arriving.take(system, i, row);
                }
            }
            done += picked.len();
            let is_last = done == lamps.len();
            if computed > 0 {
                self.timings.rows = before + clock.seconds(self);
                self.timings.first_light = self.timings.rows;
            }
            let fraction = ROWS_OF_LAMPS * done as f64 / lamps.len() as f64;
            let picture = Some(Pictured::Arriving(&arriving, system));
            let counts = (known.iter().flatten().count(), n);
            self.tell(Stage::FirstLight, counts, (fraction, None), &[], picture, is_last)?;
        }
        Ok(())
    }

    /// All rows; lights the scene on the way, from its direct light where the system has it, else from what lamps emit,
    /// those with the most unshot power first. Where the light of an earlier solve is `standing` on these patches, it is
    /// refined instead, the brightest patches first.
    ///
    /// Rows of the same mesh and computer that are `known` are not computed again; what there is when the
    /// run is cancelled is left there, and nothing else.
    ///
    /// # Errors
    /// The run was ended.
    pub fn rows(
        &mut self,
        prepared: &Prepared,
        system: &System,
        standing: Option<LightBases>,
        known: &mut Vec<Option<Row>>,
    ) -> Result<(Vec<Row>, LightBases), PipelineError> {
        let n = prepared.mesh.patches.len();
        let computer = &prepared.computer;
        known.resize(n, None);
        let mut left_to_compute = n - known.iter().flatten().count();
        let before = if left_to_compute < n { self.timings.rows } else { 0.0 };
        let clock = self.clock();
        let is_dark = standing.is_none();
        let mut arriving = Arriving::new(system, standing);
        for (i, row) in (0..).zip(&*known) {
            if let Some(row) = row {
                arriving.see(system, i, row);
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
            for &i in &picked {
                if let Some(row) = &known[i as usize] {
                    arriving.see(system, i, row);
                    arriving.take(system, i, row);
                }
            }
            done += picked.len();
            computed += missing;
            left_to_compute -= missing;
            let elapsed = clock.seconds(self);
            self.timings.rows = before + elapsed;
            if matches!(arriving, Arriving::Refined(_)) && done == n && computed > 0 {
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
        let rows = std::mem::take(known).into_iter().map(Option::unwrap_or_default).collect();
        Ok((rows, arriving.bases()))
    }
}
