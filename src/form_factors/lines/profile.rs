//! What many panes leave along one half-plane: leaves, fabrics and screens with holes, of which one stands behind the
//! other.

use super::{Interval, SHORTEST, weight_of};

/// Between neighbouring edges the same panes stand before each other, the nearest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Profile {
    /// Where panes begin and end, in rising order.
    edges: Vec<f64>,
    /// Where the layers before each edge end.
    ends: Vec<u32>,
    layers: Vec<Layer>,
    order: Vec<u32>,
    active: Vec<u32>,
}

/// A pane between two edges.
#[derive(Clone, Copy, Debug)]
struct Layer {
    pane: Interval,
    /// What it and those before it leave.
    left: f64,
}

/// A part of a pane that light may come from.
#[derive(Clone, Copy, Debug)]
pub(super) struct OpenLayer {
    /// [`Interval::seen`] of the pane.
    pub(super) seen: u32,
    /// Its weight, less what panes before it take.
    pub(super) weight: f64,
}

impl Profile {
    pub(super) fn clear(&mut self) {
        self.edges.clear();
        self.ends.clear();
        self.layers.clear();
    }

    pub(super) fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }

    /// Of these panes; `passed` tells what one leaves at an x. Where two of them cross between edges the order in the
    /// middle stands for all.
    pub(super) fn build(&mut self, panes: &[Interval], passed: impl Fn(&Interval, f64) -> f64) {
        self.clear();
        self.edges.extend(panes.iter().flat_map(|pane| [pane.start, pane.end]));
        self.edges.sort_unstable_by(f64::total_cmp);
        self.edges.dedup_by(|b, a| *b - *a <= SHORTEST);
        self.order.clear();
        self.order.extend(0..panes.len() as u32);
        let start = |&k: &u32| panes[k as usize].start;
        self.order.sort_unstable_by(|a, b| start(a).total_cmp(&start(b)).then(a.cmp(b)));
        self.active.clear();
        self.ends.push(0);
        let mut next = 0;
        for pair in self.edges.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            while next < self.order.len() && panes[self.order[next] as usize].start <= middle {
                self.active.push(self.order[next]);
                next += 1;
            }
            self.active.retain(|&k| panes[k as usize].end >= middle);
            let depth = |&k: &u32| panes[k as usize].w(middle);
            self.active.sort_unstable_by(|a, b| depth(b).total_cmp(&depth(a)).then(a.cmp(b)));
            let mut left = 1.0;
            for &k in &self.active {
                let pane = panes[k as usize];
                left *= passed(&pane, middle);
                self.layers.push(Layer { pane, left });
            }
            self.ends.push(self.layers.len() as u32);
        }
    }

    /// Of a span of this `weight` what all panes before it leave.
    pub(super) fn dimmed(&self, span: &Interval, [start, end]: [f64; 2], weight: f64) -> f64 {
        let mut sum = 0.0;
        let mut covered = 0.0;
        let first = self.edges.partition_point(|&edge| edge <= start).max(1);
        for k in first..self.edges.len() {
            let (from, to) = (self.edges[k - 1].max(start), self.edges[k].min(end));
            if self.edges[k - 1] >= end {
                break;
            }
            if to - from <= SHORTEST {
                continue;
            }
            let (own, middle) = (weight_of(to) - weight_of(from), 0.5 * (from + to));
            let layers = self.layers(k);
            let before = layers.partition_point(|layer| layer.pane.w(middle) > span.w(middle));
            covered += own;
            sum += own * if before > 0 { layers[before - 1].left } else { 1.0 };
        }
        sum + (weight - covered).max(0.0)
    }

    /// Calls `found` with the parts of panes that none of the `solid` spans hides, which are in rising order and do not
    /// overlap.
    pub(super) fn each_open(&self, solid: &[Interval], mut found: impl FnMut(OpenLayer)) {
        let mut at = 0;
        for k in 1..self.edges.len() {
            let layers = self.layers(k);
            if layers.is_empty() {
                continue;
            }
            let (mut from, end) = (self.edges[k - 1], self.edges[k]);
            while from < end {
                while at < solid.len() && solid[at].end <= from {
                    at += 1;
                }
                let (to, behind) = match solid.get(at) {
                    Some(span) if span.start <= from => (span.end.min(end), Some(span)),
                    Some(span) => (span.start.min(end), None),
                    None => (end, None),
                };
                if to - from > SHORTEST {
                    let (weight, middle) = (weight_of(to) - weight_of(from), 0.5 * (from + to));
                    let mut left = 1.0;
                    for layer in layers {
                        if behind.is_some_and(|span| span.w(middle) >= layer.pane.w(middle)) {
                            break;
                        }
                        found(OpenLayer { seen: layer.pane.seen, weight: weight * left });
                        left = layer.left;
                    }
                }
                from = to;
            }
        }
    }

    /// Between an edge and the one before it.
    fn layers(&self, edge: usize) -> &[Layer] {
        &self.layers[self.ends[edge - 1] as usize..self.ends[edge] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pane or surface of constant depth from `start` to `end`.
    fn level(start: f64, end: f64, w: f64, seen: u32) -> Interval {
        Interval { start, end, w0: w, w1: 0.0, seen }
    }

    #[test]
    fn spans_are_dimmed_by_what_stands_before_them_and_panes_by_nearer_ones() {
        // Near: half open from -0.5 to 0.5; farther: a quarter of it taken, from 0 to 1.
        let panes = [level(-0.5, 0.5, 3.0, 0), level(0.0, 1.0, 2.0, 1)];
        let passed = |pane: &Interval, _: f64| if pane.seen == 0 { 0.5 } else { 0.75 };
        let mut profile = Profile::default();
        profile.build(&panes, passed);
        let weight = |a: f64, b: f64| weight_of(b) - weight_of(a);
        let close =
            |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found} is not {wanted}");
        let dimmed = |w: f64, a: f64, b: f64| profile.dimmed(&level(a, b, w, 9), [a, b], weight(a, b));
        let behind = 0.5 * weight(-0.5, 0.0) + 0.375 * weight(0.0, 0.5) + 0.75 * weight(0.5, 1.0);
        close(dimmed(1.0, -1.0, 1.0), weight(-1.0, -0.5) + behind);
        close(dimmed(2.5, -1.0, 1.0), weight(-1.0, -0.5) + 0.5 * weight(-0.5, 0.5) + weight(0.5, 1.0));
        close(dimmed(4.0, -0.7, 0.9), weight(-0.7, 0.9));
        close(dimmed(1.0, 0.1, 0.2), 0.375 * weight(0.1, 0.2));
        close(dimmed(1.0, -0.9, -0.8), weight(-0.9, -0.8));
        // Of the panes themselves, where a wall stands before the farther one and nothing before the nearer.
        let open = |solid: &[Interval]| {
            let mut sums = [0.0; 2];
            profile.each_open(solid, |open| sums[open.seen as usize] += open.weight);
            sums
        };
        let [near, far] = open(&[]);
        close(near, weight(-0.5, 0.5));
        close(far, 0.5 * weight(0.0, 0.5) + weight(0.5, 1.0));
        let [near, far] = open(&[level(-1.0, 0.25, 1.0, 5), level(0.25, 0.75, 2.5, 6)]);
        close(near, weight(-0.5, 0.5));
        close(far, 0.5 * weight(0.0, 0.25) + weight(0.75, 1.0));
    }
}
