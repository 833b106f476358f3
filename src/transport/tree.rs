//! Rows whose far ends are nodes of a tree over patches: each is collapsed as soon as it has come.

mod judge;
mod nodes;
mod operator;
mod plan;
mod scalings;

pub use judge::{NodeScratch, Sent};
pub use plan::{NodeRow, TreePlan};

use super::{AssembleReport, RowQuality};
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
    rows: Vec<Box<[Entry]>>,
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

/// A patch that others send less than this share of what it should send itself was missed by their samples.
const MISSED: f64 = 0.3;
/// Share of the time by which what samples missed is mended.
const MENDED: f64 = 0.2;
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
        let taken: Vec<Box<[Entry]>> = rows.iter_mut().map(|row| std::mem::take(&mut row.entries)).collect();
        let mut exchange = Rows { tree, rows: taken };
        let before = exchange.mend(&targets);
        let scaled = watch
            .done(MENDED)
            .and_then(|()| scalings::scaled(&exchange, &areas, &targets, &mut watch.part(MENDED, 1.0)));
        let scaled = match scaled {
            Ok(scaled) => scaled,
            Err(Cancelled) => {
                exchange.undo(before);
                rows.iter_mut().zip(exchange.rows).for_each(|(row, entries)| row.entries = entries);
                return Err(Cancelled);
            }
        };
        let mended = before.len();
        let report = report(rows, &scaled, &areas, mended);
        let quality = rows.iter().map(|row| row.quality).collect();
        rows.clear();
        let Scalings { receivers, senders, own, sums, .. } = scaled;
        let entries = exchange.rows.iter().map(|row| row.len()).sum();
        Ok(Self {
            tree: Arc::clone(tree),
            rows: exchange.rows,
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
}

fn report(rows: &[NodeRow], scaled: &Scalings, areas: &[f64], mended: usize) -> AssembleReport {
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
        mended,
    }
}

/// Rows of exchange areas with nodes.
struct Rows<'a> {
    tree: &'a Tree,
    rows: Vec<Box<[Entry]>>,
}

impl Rows<'_> {
    /// Gives patches that samples of others have missed what by reciprocity those see of them, as their own rows tell.
    ///
    /// A small patch falls between the lines of those that look at it from afar; where it is seen by few, all of them may
    /// miss it. Its own row misses nothing. The rows that were changed, as they were before.
    fn mend(&mut self, targets: &[f64]) -> Vec<(u32, Box<[Entry]>)> {
        let columns = self.transposed(&vec![1.0; targets.len()]);
        let mut additions: Vec<(u32, Entry)> = Vec::new();
        for (j, (&column, &target)) in (0_u32..).zip(columns.iter().zip(targets)) {
            if column >= MISSED * target || self.rows[j as usize].is_empty() {
                continue;
            }
            let share = 1.0 - column / target;
            for &(node, value) in &self.rows[j as usize] {
                for &k in self.tree.patches(node) {
                    let back = share * f64::from(value) * self.tree.share(k, node);
                    if k != j && back > 0.0 {
                        additions.push((k, (self.tree.leaf(j), back as f32)));
                    }
                }
            }
        }
        // By row, then by node.
        additions.sort_unstable_by_key(|&(row, (node, _))| (row, node));
        let mut before = Vec::new();
        for added in additions.chunk_by(|a, b| a.0 == b.0) {
            let own = &mut self.rows[added[0].0 as usize];
            let mut entries = own.to_vec();
            entries.extend(added.iter().map(|addition| addition.1));
            entries.sort_by_key(|entry| entry.0);
            entries.dedup_by(|next, entry| {
                let same = next.0 == entry.0;
                if same {
                    entry.1 += next.1;
                }
                same
            });
            before.push((added[0].0, std::mem::replace(own, entries.into())));
        }
        before
    }

    fn undo(&mut self, before: Vec<(u32, Box<[Entry]>)>) {
        for (i, entries) in before {
            self.rows[i as usize] = entries;
        }
    }
}

impl Exchange for Rows<'_> {
    fn forward(&self, senders: &[f64]) -> Vec<f64> {
        let of_nodes = self.tree.means(senders);
        let product = |row: &Box<[Entry]>| {
            row.iter().map(|&(node, s)| f64::from(s) * of_nodes[node as usize]).sum::<f64>()
        };
        self.rows.par_iter().map(product).collect()
    }

    fn transposed(&self, receivers: &[f64]) -> Vec<f64> {
        let size = self.rows.len().div_ceil(RUNS).max(1);
        let runs: Vec<Vec<f64>> = self
            .rows
            .par_chunks(size)
            .zip(receivers.par_chunks(size))
            .map(|(rows, receivers)| {
                let mut sums = vec![0.0; self.tree.len()];
                for (row, &receiver) in rows.iter().zip(receivers).filter(|(_, r)| **r != 0.0) {
                    for &(node, s) in row {
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
