//! A first picture where something shines that is no patch: sky, sun, lamps of a photometric file.
//!
//! Their light is known once direct light has been laid out, which may take a minute. Until then each patch is lit at its
//! centre by a few rays to every emitter, and passes that on by coarse rows: a picture that is rough and nowhere wrong,
//! instead of a dark one.

use super::error::PipelineError;
use super::pipeline::{Pictured, Prepared, Run, Stage};
use crate::direct::{DirectLight, Scratch};
use crate::effects::Effect;
use crate::form_factors::Row;
use crate::solver::{LightBases, System};
use rayon::prelude::*;

/// Patches between two looks at whether somebody waits.
const BATCH: usize = 256;
/// Rays of a coarse row; fewer among many patches.
const RAYS: u32 = 64;
const FEW_RAYS: u32 = 24;
const MANY: usize = 30_000;
/// With more values than this, patches times columns, it would take too much memory for what it is.
const MOST_VALUES: usize = 20_000_000;
/// How often surfaces pass light on.
const BOUNCES: usize = 6;
/// What the first picture by direct light alone and the coarse rows take of this.
const DIRECT: f64 = 0.4;

impl Run<'_> {
    /// What surfaces pass on, about; of the whole solve `share` is done then. `None` where only patches shine, whose rows
    /// are there as soon, and in scenes too large for it.
    pub(super) fn glimpse(
        &mut self,
        prepared: &Prepared,
        system: &System,
        share: f64,
    ) -> Result<Option<LightBases>, PipelineError> {
        let Prepared { mesh, plan, computer, .. } = prepared;
        let is_of_patches = mesh.photometric.is_empty() && mesh.outdoors.is_none();
        if is_of_patches || mesh.patches.len() * system.columns() > MOST_VALUES {
            return Ok(None);
        }
        let light = DirectLight::new(mesh, plan.is_on(Effect::Visibility));
        let bases = &light.emitters().bases;
        let (n, columns, bands) = (mesh.patches.len(), system.columns(), system.bands);
        let with_values = |values| LightBases { patches: n, lamps: system.lamps, bands, values };
        // 1. Straight from all emitters.
        let at_patch = |scratch: &mut Scratch, i: usize| {
            let mut values = vec![0.0_f32; columns];
            let patch = &mesh.patches[i];
            if !patch.buried {
                light.glimpse(patch.centre, patch.normal, scratch, |basis, value| {
                    let basis = &bases[basis as usize];
                    for band in 0..bands {
                        let weight = basis.weight_of(band, bands);
                        values[basis.lamp as usize * bands + band] += (weight * value) as f32;
                    }
                });
            }
            values
        };
        let mut direct = Vec::with_capacity(n * columns);
        for first in (0..n).step_by(BATCH) {
            let batch = first..(first + BATCH).min(n);
            let seen: Vec<Vec<f32>> =
                batch.clone().into_par_iter().map_init(Scratch::default, at_patch).collect();
            seen.iter().for_each(|seen| direct.extend_from_slice(seen));
            let fraction = share * DIRECT * batch.end as f64 / n as f64;
            self.tell(Stage::FirstLight, (0, n), (fraction, None), &[], None, false)?;
        }
        let mut all = with_values(direct.clone());
        let fraction = (share * DIRECT, None);
        self.tell(Stage::FirstLight, (0, n), fraction, &[], Some(Pictured::Whole(&all)), true)?;
        // 2. From patch to patch.
        let rays = if n > MANY { FEW_RAYS } else { RAYS };
        let mut rows: Vec<Row> = Vec::with_capacity(n);
        for first in (0..n).step_by(BATCH) {
            let batch = first as u32..(first + BATCH).min(n) as u32;
            let row = |scratch: &mut _, i: u32| match mesh.patches[i as usize].buried {
                true => Row::default(),
                false => computer.coarse_row(i, rays, scratch),
            };
            rows.par_extend(batch.into_par_iter().map_init(|| computer.scratch(), row));
            let fraction = share * (DIRECT + (1.0 - DIRECT) * rows.len() as f64 / n as f64);
            self.tell(Stage::FirstLight, (0, n), (fraction, None), &[], None, false)?;
        }
        let mut passed_on = vec![0.0_f32; n * columns];
        for _ in 0..BOUNCES {
            passed_on.par_chunks_exact_mut(columns.max(1)).zip(&rows).for_each(|(own, row)| {
                own.fill(0.0);
                for (&j, &f) in row.patches.iter().zip(&row.values) {
                    let there = &all.values[j as usize * columns..][..columns];
                    for (c, (own, &light)) in own.iter_mut().zip(there).enumerate() {
                        *own += f * system.rho(j as usize, c) as f32 * light;
                    }
                    if !system.translucence.is_empty() {
                        for (c, own) in own.iter_mut().enumerate() {
                            let arriving = |far: usize| f64::from(all.values[far * columns + c]);
                            *own += f * system.passed(j as usize, c, arriving) as f32;
                        }
                    }
                }
            });
            let both = direct.iter().zip(&passed_on);
            all.values.iter_mut().zip(both).for_each(|(all, (direct, passed_on))| *all = direct + passed_on);
        }
        self.tell(Stage::FirstLight, (0, n), (share, None), &[], Some(Pictured::Whole(&all)), true)?;
        Ok(Some(with_values(passed_on)))
    }
}
