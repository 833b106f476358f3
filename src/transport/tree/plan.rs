//! How rows are collapsed, decided before the first is.

use super::Entry;
use super::judge::{Judge, NodeScratch, Sent};
use super::nodes::Tree;
use crate::form_factors::{ReceivingPoints, Row, RowComputer};
use crate::transport::near;
use crate::transport::quality::{PairGaps, RowQuality};
use crate::watch::{Cancelled, Watch};
use std::sync::Arc;

/// What collapsing rows may change about the irradiance that surfaces pass on, root mean square over the area, of the
/// mean irradiance of any luminaire alone, where all reflect everything.
const ERROR: f64 = 3e-3;
/// Rows that are kept as they were sampled, to judge by and to hold others against.
const PROBES: usize = 128;
/// The price of an entry is sought between these, to this many halvings of its logarithm.
const PRICES: [f64; 2] = [1e-14, 1e-2];
const HALVINGS: usize = 14;
/// Shares of the time by which the tree and the judge stand.
const TREE: f64 = 0.2;
const JUDGE: f64 = 0.5;

/// The tree over the patches of a mesh, by what its nodes are judged, and the rows that are held against others.
#[derive(Clone, Debug)]
pub struct TreePlan {
    tree: Arc<Tree>,
    judge: Judge,
    /// By patch, rising.
    probes: Vec<(u32, Row)>,
}

/// A row as nodes, with what is to be known of it once it is gone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeRow {
    /// By node, rising; exchange areas, m².
    pub(super) entries: Box<[Entry]>,
    /// By patch, rising, those of which the row of the other side is heard too; exchange areas, m².
    pub(super) near: Box<[(u32, f32)]>,
    /// What the row is to sum to, 0 to 1.
    pub(super) target: f64,
    pub(super) quality: RowQuality,
    /// Sums over its pairs with probes of |A_i F_ij - A_j F_ji| and of their means, m².
    pub(super) gap: f64,
    pub(super) mean: f64,
    /// Squared error of its nodes, as the judge sees it.
    pub(super) square: f32,
    pub(super) close_pairs: u32,
    pub(super) several_points: bool,
}

impl NodeRow {
    /// Nodes that it holds.
    pub fn entries(&self) -> usize {
        self.entries.len() + self.near.len()
    }

    /// What the row sums to as it was sampled.
    pub fn sampled_sum(&self) -> f64 {
        f64::from(self.quality.sampled_sum)
    }
}

impl TreePlan {
    /// The patches whose rows are to be there before the plan is made, spread over the mesh.
    pub fn probes(patches: usize) -> Vec<u32> {
        let count = PROBES.min(patches);
        (0..count).map(|k| (k * patches / count.max(1)) as u32).collect()
    }

    /// Builds the tree and finds the price of an entry at which the error is as it may be. `probes` are the rows of
    /// [`Self::probes`].
    ///
    /// # Errors
    /// The watch ended it.
    pub fn new(
        computer: &RowComputer,
        sent: Sent<'_>,
        probes: Vec<(u32, Row)>,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let mesh = computer.mesh();
        let tree = Tree::new(mesh, watch.cancelled())?;
        watch.done(TREE)?;
        let judge = Judge::new(mesh, &tree, sent, &mut watch.part(TREE, JUDGE))?;
        watch.done(JUDGE)?;
        let mut plan = Self { tree: Arc::new(tree), judge, probes };
        let mended: Vec<Vec<(u32, f64)>> =
            watch.part(JUDGE, 0.5 * (1.0 + JUDGE)).map(&plan.probes, |_, (i, row)| {
                mended(row, &near::of_receiver(computer, (*i, row)), mesh.patches[*i as usize].area)
            })?;
        let [mut low, mut high] = PRICES.map(f64::ln);
        for step in 0..HALVINGS {
            let price = 0.5 * (low + high);
            let from = 0.5 * (1.0 + JUDGE) + 0.5 * (1.0 - JUDGE) * step as f64 / HALVINGS as f64;
            let squares = watch.part(from, from).map(&mended, |k, row| {
                let i = plan.probes[k].0;
                let seen = row.iter().copied();
                let chosen =
                    plan.judge.choose(mesh, &plan.tree, (i, price.exp()), seen, &mut NodeScratch::default());
                let area = mesh.patches[i as usize].area;
                [area, area * chosen.square]
            })?;
            let [area, square] =
                squares.iter().fold([0.0; 2], |[a, s], [area, square]| [a + area, s + square]);
            if square > ERROR * ERROR * area { high = price } else { low = price }
        }
        plan.judge.price = low.exp();
        Ok(plan)
    }

    pub(super) fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }

    /// Collapses the row of patch `i`.
    pub fn row(&self, computer: &RowComputer, i: u32, row: &Row, scratch: &mut NodeScratch) -> NodeRow {
        let mesh = computer.mesh();
        let patch = &mesh.patches[i as usize];
        let mut gaps = PairGaps::new(row, patch.area);
        for (j, probe) in &self.probes {
            let out = patch.area * row.get(*j);
            let back = mesh.patches[*j as usize].area * probe.get(i);
            if *j != i && (out > 0.0 || back > 0.0) {
                gaps.add(*j, out, back);
            }
        }
        let (gap, mean, quality) = gaps.finish();
        let close = near::of_receiver(computer, (i, row));
        let exchange = |j: u32| close.binary_search_by_key(&j, |pair| pair.0).ok().map(|at| close[at].1);
        let sealed = computer.rays().is_sealed();
        let target = near::row_target(computer, (i, row, row.sum()), &exchange, sealed);
        let seen = mended(row, &close, patch.area);
        let (mut near, mut far) = (Vec::new(), Vec::with_capacity(seen.len()));
        for (j, value) in seen.into_iter().filter(|&(j, value)| j != i && value > 0.0) {
            if near::is_paired(computer, patch, &mesh.patches[j as usize]) {
                near.push((j, (patch.area * value) as f32));
            } else {
                far.push((j, patch.area * value));
            }
        }
        let (entries, square) = self.joined(computer, i, &far, scratch);
        NodeRow {
            entries,
            near: near.into(),
            target,
            quality,
            gap,
            mean,
            square,
            close_pairs: close.len() as u32,
            several_points: row.points.count() > 1,
        }
    }

    /// The nodes that stand for some patches seen from patch `i`, with exchange areas, m², and the square of what that
    /// changes.
    pub(super) fn joined(
        &self,
        computer: &RowComputer,
        i: u32,
        seen: &[(u32, f64)],
        scratch: &mut NodeScratch,
    ) -> (Box<[Entry]>, f32) {
        let mesh = computer.mesh();
        let area = mesh.patches[i as usize].area;
        let seen = seen.iter().map(|&(j, value)| (j, value / area));
        let chosen = self.judge.choose(mesh, &self.tree, (i, self.judge.price), seen, scratch);
        let in_area = |(node, factor): Entry| (node, (area * f64::from(factor)) as f32);
        (
            chosen.entries.into_iter().map(in_area).filter(|entry| entry.1 > 0.0).collect(),
            chosen.square as f32,
        )
    }

    /// The row of patch `i` as patches again, each node divided by area: what is left to light a picture by.
    pub fn expanded(&self, computer: &RowComputer, i: u32, row: &NodeRow) -> Row {
        let area = computer.mesh().patches[i as usize].area;
        let divided = |&(node, value): &Entry| {
            let patches = self.tree.patches(node).iter();
            patches.map(move |&j| (j, (f64::from(value) / area * self.tree.share(j, node)) as f32))
        };
        let near = row.near.iter().map(|&(j, value)| (j, (f64::from(value) / area) as f32));
        let far = row.entries.iter().flat_map(divided).filter(|seen| seen.1 > 0.0);
        let mut seen: Vec<(u32, f32)> = far.chain(near).collect();
        seen.sort_unstable_by_key(|seen| seen.0);
        let (patches, values) = seen.into_iter().unzip();
        Row { patches, values, points: ReceivingPoints::One, covered: 0, open: row.quality.open }
    }
}

/// The form factors of a row with those of its close pairs, which are exchange areas, in their place.
fn mended(row: &Row, close: &[(u32, f64)], area: f64) -> Vec<(u32, f64)> {
    let mut close = close.iter().peekable();
    row.patches
        .iter()
        .zip(&row.values)
        .map(|(&j, &value)| match close.next_if(|pair| pair.0 == j) {
            Some(pair) => (j, pair.1 / area),
            None => (j, f64::from(value)),
        })
        .collect()
}
