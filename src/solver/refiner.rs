use super::{LightBases, System};
use crate::form_factors::Row;

/// Refines a light that is there already, row by row while form factors arrive: each row gathers its
/// patch's irradiance from the radiosities as they stand, as a sweep of Gauss-Seidel would. Every state
/// on the way is a whole picture, coarse where no row has come yet.
#[derive(Clone, Debug)]
pub struct Refiner {
    light: LightBases,
    /// The patches whose rows have not arrived, brightest last.
    waiting: Vec<u32>,
}

impl Refiner {
    /// Begins with `light`; `None` unless it has the system's patches, lamps and bands.
    pub fn new(system: &System, light: LightBases) -> Option<Self> {
        let fits = light.patches == system.patches()
            && (light.lamps, light.bands) == (system.lamps, system.bands)
            && light.values.len() == system.patches() * system.columns();
        fits.then(|| {
            let n = system.columns();
            let flux = |i: u32| -> f64 {
                let arriving = &light.values[i as usize * n..(i as usize + 1) * n];
                let sum = arriving.iter().zip(&system.output).map(|(&h, &o)| f64::from(h) * o).sum::<f64>();
                system.areas[i as usize] * sum
            };
            let mut waiting: Vec<(f64, u32)> = (0..light.patches as u32).map(|i| (flux(i), i)).collect();
            waiting.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            Self { light, waiting: waiting.into_iter().map(|w| w.1).collect() }
        })
    }

    /// Takes the next patches out of those whose rows have not arrived: those on which most light falls.
    pub fn brightest(&mut self, count: usize) -> Vec<u32> {
        let rest = self.waiting.len().saturating_sub(count);
        let mut next = self.waiting.split_off(rest);
        next.reverse();
        next
    }

    /// Gathers the irradiance of `patch`.
    pub fn gather(&mut self, system: &System, patch: u32, row: &Row) {
        let n = system.columns();
        let at = patch as usize * n;
        let mut arriving = match &system.direct {
            Some(direct) => direct.values[at..at + n].iter().map(|&d| f64::from(d)).collect(),
            None => vec![0.0; n],
        };
        for (&j, &f) in row.patches.iter().zip(&row.values) {
            let (j, f) = (j as usize, f64::from(f));
            let there = self.light.values[j * n..(j + 1) * n].chunks_exact(system.bands);
            for (sums, values) in arriving.chunks_exact_mut(system.bands).zip(there) {
                for ((sum, &h), rho) in sums.iter_mut().zip(values).zip(&system.reflectance[j]) {
                    *sum += f * rho * f64::from(h);
                }
            }
            if !system.translucence.is_empty() {
                let light = &self.light.values;
                for (c, sum) in arriving.iter_mut().enumerate() {
                    *sum += f * system.passed(j, c, |far| f64::from(light[far * n + c]));
                }
            }
            if let (None, Some((lamp, weight))) = (&system.direct, &system.emission[j]) {
                let own = &mut arriving[*lamp as usize * system.bands..][..system.bands];
                own.iter_mut().zip(weight).for_each(|(sum, w)| *sum += f * w);
            }
        }
        let own = &mut self.light.values[at..at + n];
        for (h, sum) in own.iter_mut().zip(arriving) {
            *h = sum as f32;
        }
    }

    /// The picture so far.
    pub fn bases(&self) -> &LightBases {
        &self.light
    }
}
