use super::{LightBases, System};
use crate::form_factors::Row;

/// Lights the scene row by row while form factors arrive (progressive refinement, Cohen et al.
/// 1988): each row shoots its patch's unshot radiosity by reciprocity. Every state on the way is a
/// picture, with what has not been shot spread evenly.
#[derive(Clone, Debug)]
pub struct Shooter {
    /// Irradiance so far, `[patch * columns + column]`.
    irradiance: Vec<f32>,
    /// Radiosity not yet passed on.
    unshot: Vec<f32>,
    done: Vec<bool>,
    /// Areas of the patches whose rows have been seen, each times the sum of its row, and by themselves.
    seen: [f64; 2],
    columns: usize,
    bands: usize,
    lamps: usize,
}

impl Shooter {
    /// Nothing shot yet: what surfaces reflect of the direct light is unshot, where the system has that; else all
    /// emission.
    pub fn new(system: &System) -> Self {
        let columns = system.columns();
        let irradiance = match &system.direct {
            Some(direct) => direct.values.clone(),
            None => vec![0.0; system.patches() * columns],
        };
        let unshot = (0..system.patches() * columns)
            .map(|at| {
                let (i, c) = (at / columns, at % columns);
                match &system.direct {
                    Some(direct) => {
                        system.leaving(i, c, |j| f64::from(direct.values[j * columns + c])) as f32
                    }
                    None => system.exitance(i, c) as f32,
                }
            })
            .collect();
        Self {
            irradiance,
            unshot,
            done: vec![false; system.patches()],
            seen: [0.0; 2],
            columns,
            bands: system.bands,
            lamps: system.lamps,
        }
    }

    /// The patches with the most unshot power whose rows have not arrived, brightest first.
    pub fn brightest(&self, system: &System, count: usize) -> Vec<u32> {
        let power = |i: usize| -> f64 {
            let unshot = &self.unshot[i * self.columns..(i + 1) * self.columns];
            system.areas[i] * unshot.iter().zip(&system.output).map(|(&b, &o)| f64::from(b) * o).sum::<f64>()
        };
        let mut waiting: Vec<(f64, u32)> =
            (0..self.done.len()).filter(|&i| !self.done[i]).map(|i| (power(i), i as u32)).collect();
        let order = |a: &(f64, u32), b: &(f64, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if waiting.len() > count {
            waiting.select_nth_unstable_by(count, order);
            waiting.truncate(count);
        }
        waiting.sort_unstable_by(order);
        waiting.into_iter().map(|(_, i)| i).collect()
    }

    /// Learns from the sum of a row how much of what is passed on stays in the scene.
    pub fn see(&mut self, system: &System, patch: u32, row_sum: f64) {
        let area = system.areas[patch as usize];
        self.seen[0] += area * row_sum.min(1.0);
        self.seen[1] += area;
    }

    /// Passes the unshot radiosity of `patch` on to all that its row sees.
    pub fn shoot(&mut self, system: &System, patch: u32, row: &Row) {
        let (i, n) = (patch as usize, self.columns);
        self.done[i] = true;
        let sent: Vec<f32> = self.unshot[i * n..(i + 1) * n].to_vec();
        self.unshot[i * n..(i + 1) * n].fill(0.0);
        if sent.iter().all(|&s| s == 0.0) {
            return;
        }
        for (&j, &f) in row.patches.iter().zip(&row.values) {
            let j = j as usize;
            let share = (f64::from(f) * system.areas[i] / system.areas[j]) as f32;
            let range = j * n..(j + 1) * n;
            let arriving = self.irradiance[range.clone()].iter_mut().zip(&mut self.unshot[range]);
            for (c, ((h, unshot), &b)) in arriving.zip(&sent).enumerate() {
                let dh = share * b;
                *h += dh;
                *unshot += system.rho(j, c) as f32 * dh;
            }
            // What arrives here leaves the far side as well: it has as much of this one behind it.
            for &(far, behind) in system.translucence.at(j).iter().flat_map(|passing| &passing.behind) {
                let passed = share * (behind * system.areas[j] / system.areas[far as usize]) as f32;
                for (c, &b) in sent.iter().enumerate() {
                    let tau = system.translucence.at(far as usize).map_or(0.0, |p| p.share[c % self.bands]);
                    self.unshot[far as usize * n + c] += tau as f32 * passed * b;
                }
            }
        }
    }

    /// What has arrived so far.
    pub fn bases(&self) -> LightBases {
        self.with_values(self.irradiance.clone())
    }

    /// The picture so far: what has arrived, and what is unshot as if it came evenly from everywhere, reflected on for
    /// ever (the ambient term of Cohen et al. 1988). In the mean it is as bright as the light will be.
    pub fn picture(&self, system: &System) -> LightBases {
        let stays = if self.seen[1] > 0.0 { self.seen[0] / self.seen[1] } else { 1.0 };
        let area: f64 = system.areas.iter().sum();
        let ambient: Vec<f32> = (0..self.columns)
            .map(|c| {
                let over_area = |value: &dyn Fn(usize) -> f64| {
                    (0..self.done.len()).map(|i| system.areas[i] * value(i)).sum::<f64>() / area
                };
                let rho = over_area(&|i| system.leaving(i, c, |_| 1.0));
                let unshot = over_area(&|i| f64::from(self.unshot[i * self.columns + c]));
                let ambient = stays * unshot / (1.0 - stays * rho);
                if ambient.is_finite() { ambient as f32 } else { 0.0 }
            })
            .collect();
        let mut values = self.irradiance.clone();
        if self.columns > 0 {
            for own in values.chunks_exact_mut(self.columns) {
                own.iter_mut().zip(&ambient).for_each(|(h, ambient)| *h += ambient);
            }
        }
        self.with_values(values)
    }

    /// Radiosity that has not been passed on, a luminaire each at unit white exitance: what is missing
    /// in the picture so far, before it is reflected further.
    pub fn unshot(&self) -> LightBases {
        self.with_values(self.unshot.clone())
    }

    fn with_values(&self, values: Vec<f32>) -> LightBases {
        LightBases { patches: self.done.len(), lamps: self.lamps, bands: self.bands, values }
    }
}
