//! What the tree answers to those who ask the operator.

use super::{Entry, TreeTransport};
use crate::transport::{
    AssembleReport, Cancelled, Coarsened, LANES, Lanes, RowQuality, Transport, TransportKind,
};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Rows gathered between two looks at whether to stop.
const UNWATCHED: usize = 256;

impl TreeTransport {
    /// For every node the mean of what its patches send with their scales, W/m².
    fn sent(&self, radiosity: &[Lanes]) -> Vec<Lanes> {
        let tree = &self.tree;
        let mut sent = vec![[0.0; LANES]; tree.len()];
        for (patch, b) in (0_u32..).zip(radiosity) {
            let scale = self.senders[patch as usize] * tree.weight(patch);
            sent[tree.leaf(patch) as usize] = b.map(|b| scale * b);
        }
        for node in (0..tree.len() as u32).rev() {
            let own = sent[node as usize];
            if let Some(parent) = tree.parent(node) {
                sent[parent as usize].iter_mut().zip(own).for_each(|(sum, value)| *sum += value);
            }
            let area = tree.area(node);
            sent[node as usize] = own.map(|value| if area > 0.0 { value / area } else { 0.0 });
        }
        sent
    }

    /// Irradiance of patch `i` from others, W/m² per lane, where nodes send this.
    #[inline]
    fn arriving(&self, i: usize, sent: &[Lanes]) -> Lanes {
        let mut sum = [0.0; LANES];
        for row in [&self.far[i], &self.near[i]] {
            for &(node, s) in row {
                let (s, b) = (f64::from(s), &sent[node as usize]);
                for lane in 0..LANES {
                    sum[lane] += s * b[lane];
                }
            }
        }
        let scale = self.receivers[i] / self.areas[i];
        sum.map(|sum| scale * sum)
    }

    /// What patch `i` has of each of its entries: node and exchange area with its patches before they are scaled, m².
    fn scaled(&self, i: usize) -> impl Iterator<Item = Entry> + '_ {
        self.stored(i).filter(move |_| self.receivers[i] > 0.0)
    }

    /// S_ij by the entry of row i with a node that holds j, m².
    fn share(&self, i: usize, (node, s): Entry, j: u32) -> f64 {
        self.receivers[i] * f64::from(s) * self.tree.share(j, node) * self.senders[j as usize]
    }
}

/// Sorts values by what they are of and adds up those of one: near and far parts of a row may hold the same.
fn in_order(values: &mut Vec<(u32, f64)>) {
    values.sort_by_key(|value| value.0);
    values.dedup_by(|next, value| {
        let same = next.0 == value.0;
        if same {
            value.1 += next.1;
        }
        same
    });
}

impl Transport for TreeTransport {
    fn areas(&self) -> &[f64] {
        &self.areas
    }

    fn gather(
        &self,
        rows: Range<usize>,
        radiosity: &[Lanes],
        irradiance: &mut [Lanes],
        cancelled: Cancelled,
    ) {
        self.passes.fetch_add(1, Ordering::Relaxed);
        let sent = self.sent(radiosity);
        let first = rows.start;
        irradiance[..rows.len()].par_iter_mut().enumerate().with_min_len(UNWATCHED).for_each(
            |(k, arriving)| {
                if k % UNWATCHED == 0 && cancelled() {
                    return;
                }
                let i = first + k;
                let own = self.own[i] / self.areas[i];
                let others = self.arriving(i, &sent);
                *arriving = std::array::from_fn(|lane| others[lane] + own * radiosity[i][lane]);
            },
        );
    }

    fn relax(
        &self,
        radiosity: &mut [Lanes],
        cancelled: Cancelled,
        update: &mut dyn FnMut(usize, Lanes, f64) -> Lanes,
    ) {
        self.passes.fetch_add(1, Ordering::Relaxed);
        let tree = &self.tree;
        let mut sent = self.sent(radiosity);
        for i in 0..self.areas.len() {
            if i % UNWATCHED == 0 && cancelled() {
                return;
            }
            let new = update(i, self.arriving(i, &sent), self.own[i] / self.areas[i]);
            // The new value counts at once in all nodes that hold the patch.
            let scale = self.senders[i] * tree.weight(i as u32);
            let change: Lanes = std::array::from_fn(|lane| scale * (new[lane] - radiosity[i][lane]));
            radiosity[i] = new;
            let mut at = Some(tree.leaf(i as u32));
            while let Some(node) = at {
                let area = tree.area(node);
                if area > 0.0 {
                    sent[node as usize].iter_mut().zip(change).for_each(|(sum, value)| *sum += value / area);
                }
                at = tree.parent(node);
            }
        }
    }

    fn coarsen<'a>(&'a self, part_of: &'a [u32]) -> Coarsened<'a> {
        // What each node sends by way of each group; most nodes lie in one.
        let tree = &self.tree;
        let mut shares: Vec<Vec<(u32, f64)>> = vec![Vec::new(); tree.len()];
        for node in (0..tree.len() as u32).rev() {
            shares[node as usize] = match (tree.single(node), tree.halves(node)) {
                (Some(patch), _) => {
                    let i = patch as usize;
                    vec![(part_of[i], self.senders[i] * tree.share(patch, node))]
                }
                (None, Some(halves)) => {
                    let whole = tree.area(node).max(f64::MIN_POSITIVE);
                    let mut joined: Vec<(u32, f64)> = Vec::new();
                    for half in halves {
                        let share = tree.area(half) / whole;
                        joined
                            .extend(shares[half as usize].iter().map(|&(part, value)| (part, share * value)));
                    }
                    in_order(&mut joined);
                    joined
                }
                (None, None) => Vec::new(),
            };
        }
        Box::new(move |i, sums| {
            for (node, s) in self.scaled(i) {
                for &(part, share) in &shares[node as usize] {
                    sums[part as usize] += self.receivers[i] * f64::from(s) * share;
                }
            }
        })
    }

    fn row(&self, i: usize) -> Vec<(u32, f64)> {
        let mut row: Vec<(u32, f64)> = self
            .scaled(i)
            .flat_map(|entry| self.tree.patches(entry.0).iter().map(move |&j| (j, self.share(i, entry, j))))
            .filter(|entry| entry.1 > 0.0)
            .collect();
        in_order(&mut row);
        row
    }

    fn singles(&self, i: usize) -> Vec<(u32, f64)> {
        let single = |entry: Entry| self.tree.single(entry.0).map(|j| (j, self.share(i, entry, j)));
        let mut row: Vec<(u32, f64)> = self.scaled(i).filter_map(single).collect();
        in_order(&mut row);
        row
    }

    fn row_entries(&self, i: usize) -> usize {
        self.far[i].len() + self.near[i].len()
    }

    fn kind(&self) -> TransportKind {
        TransportKind::Tree
    }

    fn own(&self, i: usize) -> f64 {
        self.own[i]
    }

    fn row_sum(&self, i: usize) -> f64 {
        self.sums[i] / self.areas[i]
    }

    fn sees(&self, i: usize) -> bool {
        self.sums[i] > 0.0
    }

    fn quality(&self, i: usize) -> RowQuality {
        self.quality[i]
    }

    fn report(&self) -> &AssembleReport {
        &self.report
    }

    fn passes(&self) -> u64 {
        self.passes.load(Ordering::Relaxed)
    }

    fn entries(&self) -> usize {
        self.entries
    }

    fn bytes(&self) -> usize {
        let per_patch = 5 * size_of::<f64>() + size_of::<RowQuality>() + 2 * size_of::<Box<[Entry]>>();
        self.entries * size_of::<Entry>() + self.areas.len() * per_patch + self.tree.bytes()
    }

    fn get(&self, i: usize, j: usize) -> f64 {
        let place = self.tree.place(j as u32);
        let holds = |entry: &Entry| self.tree.places(entry.0).contains(&place);
        let stored: f64 = self.scaled(i).filter(holds).map(|entry| self.share(i, entry, j as u32)).sum();
        (stored + if i == j { self.own[i] } else { 0.0 }) / self.areas[i]
    }
}
