//! First light of what no patch sends out: sky, sun, and lamps that shine by their photometry.

use super::arriving::Arriving;
use super::error::PipelineError;
use super::pipeline::{Pictured, Prepared, Run, Stage};
use crate::direct::{DirectLight, Scratch};
use crate::effects::Effect;
use crate::solver::{LightBases, System};
use rayon::prelude::*;

/// Patches between two looks at whether somebody waits.
const BATCH: usize = 256;

impl Run<'_> {
    /// Lights each patch at its centre by a few rays to every such source, so that nobody looks at a dark picture until
    /// direct light has been laid out. Of the whole solve `share` is done then; whether there was something to light.
    pub(super) fn glimpse(
        &mut self,
        prepared: &Prepared,
        system: &System,
        arriving: &mut Arriving,
        share: f64,
    ) -> Result<bool, PipelineError> {
        let Prepared { mesh, plan, .. } = prepared;
        if mesh.photometric.is_empty() && mesh.outdoors.is_none() {
            return Ok(false);
        }
        let light = DirectLight::new(mesh, plan.is_on(Effect::Visibility)).without_patches(mesh);
        let bases = &light.emitters().bases;
        let (n, columns, bands) = (mesh.patches.len(), system.columns(), system.bands);
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
        let mut values = Vec::with_capacity(n * columns);
        for first in (0..n).step_by(BATCH) {
            let batch = first..(first + BATCH).min(n);
            let seen: Vec<Vec<f32>> =
                batch.clone().into_par_iter().map_init(Scratch::default, at_patch).collect();
            seen.iter().for_each(|seen| values.extend_from_slice(seen));
            let fraction = share * batch.end as f64 / n as f64;
            self.tell(Stage::FirstLight, (0, n), (fraction, None), &[], None, false)?;
        }
        arriving.light(system, &LightBases { patches: n, lamps: system.lamps, bands, values });
        let picture = Some(Pictured::Arriving(arriving, system));
        self.tell(Stage::FirstLight, (0, n), (share, None), &[], picture, true)?;
        Ok(true)
    }
}
