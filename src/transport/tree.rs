//! Rows whose far ends are nodes of a tree over patches: each is collapsed as soon as it has come.

mod bounce;
mod judge;
mod nodes;
mod operator;
mod plan;
mod scalings;

pub use judge::{NodeScratch, Sent};
pub use plan::{NodeRow, TreePlan};

use super::{AssembleReport, RowQuality, near};
use crate::form_factors::RowComputer;
use crate::watch::{Cancelled, Watch};
use nodes::Tree;
use rayon::prelude::*;
use scalings::{Exchange, Scalings};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// A node and the exchange area with it as sampled and mended, m².
type Entry = (u32, f32);

/// The form factors from patches to nodes of a tree, as exchange areas.
///
/// Between patches i and j it is S_ij = r_i s_iN c_j A_j / A_N for the node N of row i that holds j. The rows s are those
/// of the receivers alone, with closed forms for close pairs. The scales r and c give rows and columns their sums, so that what
/// is sent arrives; they stand apart from the rows.
#[derive(Clone, Debug, Default)]
pub struct TreeTransport {
    tree: Arc<Tree>,
    /// What each patch sees from afar, as its own row tells, and near it, as both rows of a pair tell.
    far: Vec<Box<[Entry]>>,
    near: Vec<Box<[Entry]>>,
    /// r.
    receivers: Vec<f64>,
    /// c.
    senders: Vec<f64>,
    /// S_ii, m².
    own: Vec<f64>,
    /// Sum of S_ij over j, m².
    sums: Vec<f64>,
    areas: Vec<f64>,
    quality: Vec<RowQuality>,
    report: AssembleReport,
    entries: usize,
    passes: Arc<AtomicU64>,
}

/// Entries of each row, and the square of what taking both samples changes of it.
type Paired = (Vec<Box<[Entry]>>, Vec<f32>);

/// A patch that others send less than this share of what it should send itself was missed by their samples.
const MISSED: f64 = 0.3;
/// Shares of the time by which near pairs are done, and what samples missed.
const PAIRED: f64 = 0.2;
const MENDED: f64 = 0.3;
/// Transposed products add up in so many runs of rows, in order: the same bits whatever the thread count.
const RUNS: usize = 8;

impl TreeTransport {
    /// Builds the operator from the collapsed rows of a plan, one per patch. These are emptied once nothing can end it any
    /// more; before, they are left as they were.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn assemble(
        computer: &RowComputer,
        plan: &TreePlan,
        rows: &mut Vec<NodeRow>,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let patches = &computer.mesh().patches;
        assert_eq!(rows.len(), patches.len(), "one row a patch");
        let areas: Vec<f64> = patches.iter().map(|p| p.area).collect();
        let targets: Vec<f64> = rows.iter().zip(&areas).map(|(row, area)| area * row.target).collect();
        let tree = plan.tree();
        let (near, squares) = paired(computer, plan, rows, &mut watch.part(0.0, PAIRED))?;
        let taken: Vec<Box<[Entry]>> = rows.iter_mut().map(|row| std::mem::take(&mut row.entries)).collect();
        let mut exchange = Rows { tree, far: taken, near };
        let mended = exchange.mend(&targets);
        let scaled = watch
            .done(MENDED)
            .and_then(|()| scalings::scaled(&exchange, &areas, &targets, &mut watch.part(MENDED, 1.0)));
        let scaled = match scaled {
            Ok(scaled) => scaled,
            Err(Cancelled) => {
                rows.iter_mut().zip(exchange.far).for_each(|(row, entries)| row.entries = entries);
                return Err(Cancelled);
            }
        };
        let mut report = report(rows, &scaled, &areas);
        let of_near: f64 = squares.iter().zip(&areas).map(|(&square, area)| area * f64::from(square)).sum();
        let of_near = of_near / areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        report.joined_error = (report.joined_error.powi(2) + of_near).sqrt();
        report.mended = mended;
        let quality = rows.iter().map(|row| row.quality).collect();
        rows.clear();
        let Scalings { receivers, senders, own, sums, .. } = scaled;
        let Rows { far, near, .. } = exchange;
        let entries = far.iter().chain(&near).map(|row| row.len()).sum();
        Ok(Self {
            tree: Arc::clone(tree),
            far,
            near,
            receivers,
            senders,
            own,
            sums,
            areas,
            quality,
            report,
            entries,
            passes: Arc::default(),
        })
    }

    /// What row `i` holds.
    fn stored(&self, i: usize) -> impl Iterator<Item = Entry> + '_ {
        self.far[i].iter().chain(&self.near[i]).copied()
    }
}

/// The near pairs of all rows from both samples, as nodes again; and for each row the square of what that changes.
fn paired(
    computer: &RowComputer,
    plan: &TreePlan,
    rows: &[NodeRow],
    watch: &mut Watch<'_>,
) -> Result<Paired, Cancelled> {
    let patches = &computer.mesh().patches;
    // What others say of each patch, in rising order of those.
    let mut said: Vec<Vec<(u32, f32)>> = vec![Vec::new(); rows.len()];
    for (j, row) in (0_u32..).zip(rows) {
        for &(i, value) in &row.near {
            said[i as usize].push((j, value));
        }
    }
    watch.done(0.1)?;
    let found = watch.part(0.1, 1.0).map(&said, |i, said| {
        let own = &rows[i].near;
        let (mut a, mut b) = (0, 0);
        let mut seen: Vec<(u32, f64)> = Vec::with_capacity(own.len());
        while a < own.len() || b < said.len() {
            let from_own = own.get(a).map_or(u32::MAX, |pair| pair.0);
            let from_other = said.get(b).map_or(u32::MAX, |pair| pair.0);
            let j = from_own.min(from_other);
            let [of_own, of_other] = near::trust(computer, &patches[i], &patches[j as usize]);
            let mut value = 0.0;
            if from_own == j {
                value += of_own * f64::from(own[a].1);
                a += 1;
            }
            if from_other == j {
                value += of_other * f64::from(said[b].1);
                b += 1;
            }
            if value > 0.0 {
                seen.push((j, value));
            }
        }
        plan.joined(computer, i as u32, &seen, &mut NodeScratch::default())
    })?;
    Ok(found.into_iter().unzip())
}

fn report(rows: &[NodeRow], scaled: &Scalings, areas: &[f64]) -> AssembleReport {
    let near_one = |s: &f64| (s - 1.0).abs() < 0.01;
    let sums = rows.iter().map(|row| f64::from(row.quality.sampled_sum)).filter(near_one);
    let (gap, mean) = rows.iter().fold((0.0, 0.0), |(gap, mean), row| (gap + row.gap, mean + row.mean));
    let squares: f64 = rows.iter().zip(areas).map(|(row, area)| area * f64::from(row.square)).sum();
    AssembleReport {
        worst_closure: sums.map(|s| (s - 1.0).abs()).fold(0.0, f64::max),
        mean_reciprocity: if mean > 0.0 { gap / mean } else { 0.0 },
        several_points: rows.iter().filter(|row| row.several_points).count(),
        close_pairs: rows.iter().map(|row| row.close_pairs as usize).sum(),
        passes: scaled.passes,
        imbalance: scaled.imbalance,
        kept: scaled.kept,
        joined_error: (squares / areas.iter().sum::<f64>().max(f64::MIN_POSITIVE)).sqrt(),
        mended: 0,
    }
}

/// Rows of exchange areas with nodes.
struct Rows<'a> {
    tree: &'a Tree,
    far: Vec<Box<[Entry]>>,
    near: Vec<Box<[Entry]>>,
}

impl Rows<'_> {
    /// Gives patches that samples of others have missed what by reciprocity those see of them, as their own rows tell; how
    /// many rows get something.
    ///
    /// A small patch falls between the lines of those that look at it from afar; where it is seen by few, all of them may
    /// miss it. Its own row misses nothing.
    fn mend(&mut self, targets: &[f64]) -> usize {
        let columns = self.transposed(&vec![1.0; targets.len()]);
        let mut additions: Vec<(u32, Entry)> = Vec::new();
        for (j, (&column, &target)) in columns.iter().zip(targets).enumerate() {
            if column >= MISSED * target {
                continue;
            }
            let share = 1.0 - column / target;
            for &(node, value) in self.far[j].iter().chain(&self.near[j]) {
                for &k in self.tree.patches(node) {
                    let back = share * f64::from(value) * self.tree.share(k, node);
                    if k as usize != j && back > 0.0 {
                        additions.push((k, (self.tree.leaf(j as u32), back as f32)));
                    }
                }
            }
        }
        // By row, then by node.
        additions.sort_unstable_by_key(|&(row, (node, _))| (row, node));
        let mut mended = 0;
        for added in additions.chunk_by(|a, b| a.0 == b.0) {
            let own = &mut self.near[added[0].0 as usize];
            *own = own.iter().copied().chain(added.iter().map(|addition| addition.1)).collect();
            mended += 1;
        }
        mended
    }
}

impl Exchange for Rows<'_> {
    fn forward(&self, senders: &[f64]) -> Vec<f64> {
        let of_nodes = self.tree.means(senders);
        let product =
            |row: &[Entry]| row.iter().map(|&(node, s)| f64::from(s) * of_nodes[node as usize]).sum::<f64>();
        self.far.par_iter().zip(&self.near).map(|(far, near)| product(far) + product(near)).collect()
    }

    fn transposed(&self, receivers: &[f64]) -> Vec<f64> {
        let size = self.far.len().div_ceil(RUNS).max(1);
        let runs: Vec<Vec<f64>> = self
            .far
            .par_chunks(size)
            .zip(self.near.par_chunks(size))
            .zip(receivers.par_chunks(size))
            .map(|((far, near), receivers)| {
                let mut sums = vec![0.0; self.tree.len()];
                for ((far, near), &receiver) in far.iter().zip(near).zip(receivers) {
                    for &(node, s) in far.iter().chain(near) {
                        sums[node as usize] += f64::from(s) * receiver;
                    }
                }
                sums
            })
            .collect();
        let mut sums = vec![0.0; self.tree.len()];
        for run in runs {
            sums.iter_mut().zip(run).for_each(|(sum, value)| *sum += value);
        }
        self.tree.spread(sums)
    }
}
