//! What there is of the rows of a mesh while they are computed, and what an interrupted solve keeps of them.

use crate::form_factors::{Row, RowComputer};
use crate::transport::{NodeRow, TransportKind, TreePlan};
use std::sync::Arc;

/// Rows of a mesh, each as it was sampled or, for a tree, collapsed; empty to begin with.
#[derive(Clone, Debug, Default)]
pub struct RowStore {
    raw: Vec<Option<Row>>,
    /// Which transport they are for, once that has been decided; never [`TransportKind::Auto`].
    pub(super) kind: Option<TransportKind>,
    tree: Option<InTree>,
}

#[derive(Clone, Debug)]
struct InTree {
    plan: Arc<TreePlan>,
    rows: Vec<Option<NodeRow>>,
}

impl RowStore {
    /// Makes room for the rows of so many patches.
    pub(super) fn resize(&mut self, patches: usize) {
        self.raw.resize(patches, None);
    }

    /// How many rows there are.
    pub fn known(&self) -> usize {
        let collapsed = self.tree.as_ref().map_or(0, |tree| tree.rows.iter().flatten().count());
        collapsed + self.raw.iter().flatten().count()
    }

    pub(super) fn has(&self, i: u32) -> bool {
        let of_tree = |tree: &InTree| tree.rows.get(i as usize).is_some_and(Option::is_some);
        self.raw.get(i as usize).is_some_and(Option::is_some) || self.tree.as_ref().is_some_and(of_tree)
    }

    /// Row `i` as it was sampled, if it is kept so.
    pub(super) fn raw(&self, i: u32) -> Option<&Row> {
        self.raw.get(i as usize)?.as_ref()
    }

    /// Row `i` if it was collapsed, as patches again.
    pub(super) fn expanded(&self, computer: &RowComputer, i: u32) -> Option<Row> {
        let tree = self.tree.as_ref()?;
        Some(tree.plan.expanded(computer, i, tree.rows.get(i as usize)?.as_ref()?))
    }

    /// What row `i` sums to as it was sampled, if it is there.
    pub(super) fn sum(&self, i: u32) -> Option<f64> {
        let collapsed = || Some(self.tree.as_ref()?.rows.get(i as usize)?.as_ref()?.sampled_sum());
        self.raw(i).map(Row::sum).or_else(collapsed)
    }

    pub(super) fn keep(&mut self, i: u32, row: Row) {
        self.raw[i as usize] = Some(row);
    }

    pub(super) fn keep_collapsed(&mut self, i: u32, row: NodeRow) {
        if let Some(tree) = &mut self.tree {
            tree.rows[i as usize] = Some(row);
            self.raw[i as usize] = None;
        }
    }

    /// By what rows are collapsed, once that stands.
    pub(super) fn plan(&self) -> Option<&Arc<TreePlan>> {
        self.tree.as_ref().map(|tree| &tree.plan)
    }

    /// From here on rows are collapsed so.
    pub(super) fn begin_tree(&mut self, plan: TreePlan) {
        self.tree = Some(InTree { plan: Arc::new(plan), rows: vec![None; self.raw.len()] });
    }

    /// All rows as they were sampled; those that are missing are empty.
    pub(super) fn take_raw(&mut self) -> Vec<Row> {
        std::mem::take(&mut self.raw).into_iter().map(Option::unwrap_or_default).collect()
    }

    pub(super) fn put_back_raw(&mut self, rows: Vec<Row>) {
        self.raw = rows.into_iter().map(Some).collect();
    }

    /// All collapsed rows and the plan; `None` where there is none.
    pub(super) fn take_collapsed(&mut self) -> Option<(Arc<TreePlan>, Vec<NodeRow>)> {
        let tree = self.tree.as_mut()?;
        let rows = std::mem::take(&mut tree.rows).into_iter().map(Option::unwrap_or_default).collect();
        Some((Arc::clone(&tree.plan), rows))
    }

    pub(super) fn put_back_collapsed(&mut self, rows: Vec<NodeRow>) {
        if let Some(tree) = &mut self.tree {
            tree.rows = rows.into_iter().map(Some).collect();
        }
    }
}
