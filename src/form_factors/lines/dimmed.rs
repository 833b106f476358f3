//! Spans that are seen through panes of glass.

use super::{Interval, LineSampler, SHORTEST, weight_of};
use crate::scene::luminance_weighted;
use crate::visibility::Glass;

impl LineSampler {
    /// The weight of a part of a visible span less what the panes before it take, each by its own angle.
    pub(super) fn dimmed(
        &self,
        glass: &Glass,
        interval: &Interval,
        [start, end]: [f64; 2],
        weight: f64,
    ) -> f64 {
        if self.before.is_empty() {
            return weight;
        }
        let mut sum = 0.0;
        let mut from = start;
        while from < end {
            // Up to where the next pane begins or ends, or cuts through the surface behind it.
            let mut to = end;
            for pane in &self.before {
                let meet = (pane.w0 - interval.w0) / (interval.w1 - pane.w1);
                for x in [pane.start, pane.end, meet] {
                    if x > from + SHORTEST && x < to {
                        to = x;
                    }
                }
            }
            let middle = 0.5 * (from + to);
            let stands = |pane: &&Interval| {
                pane.start <= middle && middle <= pane.end && pane.w(middle) > interval.w(middle)
            };
            let weight = weight_of(to) - weight_of(from);
            if self.before.iter().any(|pane| stands(&pane)) {
                // The angle changes along it: Gauss's two points.
                let passed: f64 = [0.211_324_865_405_187, 0.788_675_134_594_813]
                    .iter()
                    .map(|share| {
                        let x = from + share * (to - from);
                        // Length of the direction whose depth w measures.
                        let length = (0.5 * (1.0 + x * x)).sqrt();
                        let mut passed = [1.0; 3];
                        for pane in self.before.iter().filter(stands) {
                            let Some((index, to_plane)) = self.seen[pane.seen as usize].pane else { continue };
                            let kind = glass.panes().list[index as usize].kind;
                            let cos = pane.w(x) * to_plane / length;
                            let own = glass.panes().kinds[kind as usize].transmittance(cos);
                            passed.iter_mut().zip(own).for_each(|(passed, own)| *passed *= own);
                        }
                        luminance_weighted(passed)
                    })
                    .sum();
                sum += 0.5 * passed * weight;
            } else {
                sum += weight;
            }
            from = to;
        }
        sum
    }
}
