//! The tree over patches: near ones that face alike lie together in every node.

use crate::geometry::Aabb;
use crate::mesh::PatchMesh;
use crate::watch::Cancelled;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::ops::Range;

/// Stands for "no node" and for "patches of several kinds".
pub(super) const NONE: u32 = u32::MAX;
/// A part of the extent of the scene: sides that differ in direction lie this far apart, those that face each
/// other twice, and sides of several materials are told apart once they lie nearer together.
const APART: f64 = 0.05;
/// Nodes made between two looks at whether to stop.
const UNWATCHED: usize = 1024;

/// Patches that lie together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Its patches are `order[first..first + count]`; one at least.
    first: u32,
    count: u32,
    /// The node that it is a half of; [`NONE`] for the root.
    parent: u32,
    /// What all its patches have in common: one material, and where they emit one lamp; else [`NONE`].
    kind: u32,
    /// Area of its patches that are not buried, m².
    area: f64,
}

/// A binary tree over the patches of a mesh, in the order of a walk that visits a node before its halves.
#[derive(Clone, Debug, Default)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    place: Vec<u32>,
    leaf: Vec<u32>,
    /// Share of each patch in its nodes before division by their area, m²: its area, nought where it is buried.
    weight: Vec<f64>,
}

/// A side of a region with its patches, or a cluster.
struct Item {
    patches: Vec<u32>,
    centre: DVec3,
    normal: DVec3,
    material: u32,
}

impl Tree {
    /// Divides the sides of all regions by place and direction, then each along its longer axis, down to patches.
    pub(super) fn new(mesh: &PatchMesh, cancelled: &(dyn Fn() -> bool + Sync)) -> Result<Self, Cancelled> {
        let mut sides: BTreeMap<(bool, u32, u8), Vec<u32>> = BTreeMap::new();
        for (i, patch) in (0_u32..).zip(&mesh.patches) {
            let key = if patch.is_cluster { i } else { patch.region };
            sides.entry((patch.is_cluster, key, patch.side as u8)).or_default().push(i);
        }
        let mut items: Vec<Item> = sides
            .into_values()
            .map(|patches| {
                let mut sums = (f64::MIN_POSITIVE, DVec3::ZERO, DVec3::ZERO);
                for &i in &patches {
                    let p = &mesh.patches[i as usize];
                    sums = (sums.0 + p.area, sums.1 + p.area * p.centre, sums.2 + p.area * p.normal);
                }
                let material = mesh.patches[patches[0] as usize].material;
                Item { patches, centre: sums.1 / sums.0, normal: sums.2.normalize_or_zero(), material }
            })
            .collect();
        let n = mesh.patches.len();
        let bounds = Aabb::around(mesh.patches.iter().map(|p| p.centre));
        let apart = if n > 0 { APART * bounds.size().length() } else { 0.0 };
        let mut tree = Self {
            nodes: Vec::with_capacity((2 * n).saturating_sub(1)),
            order: Vec::with_capacity(n),
            place: vec![0; n],
            leaf: vec![0; n],
            weight: mesh.patches.iter().map(|p| if p.buried { 0.0 } else { p.area }).collect(),
        };
        if n > 0 {
            tree.add_items(mesh, &mut items, apart, NONE, cancelled)?;
        }
        for (place, &patch) in tree.order.iter().enumerate() {
            tree.place[patch as usize] = place as u32;
        }
        tree.sum_up(mesh);
        Ok(tree)
    }

    fn open(
        &mut self,
        count: usize,
        parent: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, Cancelled> {
        let node = self.nodes.len();
        if node.is_multiple_of(UNWATCHED) && cancelled() {
            return Err(Cancelled);
        }
        let first = self.order.len() as u32;
        self.nodes.push(Node { first, count: count as u32, parent, kind: NONE, area: 0.0 });
        Ok(node as u32)
    }

    fn add_items(
        &mut self,
        mesh: &PatchMesh,
        items: &mut [Item],
        apart: f64,
        parent: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), Cancelled> {
        if let [one] = items {
            let region = &mesh.regions[mesh.patches[one.patches[0] as usize].region as usize];
            let local =
                |i: u32| region.frame.local(mesh.patches[i as usize].centre - region.origin).truncate();
            let mut patches: Vec<(DVec2, u32)> = one.patches.iter().map(|&i| (local(i), i)).collect();
            return self.add_patches(&mut patches, parent, cancelled);
        }
        let node = self.open(items.iter().map(|item| item.patches.len()).sum(), parent, cancelled)?;
        let (low, high) = halved(items, apart);
        self.add_items(mesh, low, apart, node, cancelled)?;
        self.add_items(mesh, high, apart, node, cancelled)
    }

    fn add_patches(
        &mut self,
        patches: &mut [(DVec2, u32)],
        parent: u32,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), Cancelled> {
        let node = self.open(patches.len(), parent, cancelled)?;
        if let [(_, patch)] = patches {
            self.leaf[*patch as usize] = node;
            self.order.push(*patch);
            return Ok(());
        }
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for (at, _) in patches.iter() {
            (min, max) = (min.min(*at), max.max(*at));
        }
        let axis = usize::from(max.y - min.y > max.x - min.x);
        let (low, high) = split(patches, |patch| patch.0[axis], [min[axis], max[axis]]);
        self.add_patches(low, node, cancelled)?;
        self.add_patches(high, node, cancelled)
    }

    /// Areas and kinds of all nodes.
    fn sum_up(&mut self, mesh: &PatchMesh) {
        let mut kinds: BTreeMap<(u32, Option<u32>, [u64; 3]), u32> = BTreeMap::new();
        for (i, patch) in mesh.patches.iter().enumerate() {
            let lamp = patch.luminaire.map_or([0; 3], |_| patch.emission_weight.map(f64::to_bits));
            let next = kinds.len() as u32;
            let kind = *kinds.entry((patch.material, patch.luminaire, lamp)).or_insert(next);
            let leaf = &mut self.nodes[self.leaf[i] as usize];
            (leaf.kind, leaf.area) = (kind, self.weight[i]);
        }
        for k in (0..self.nodes.len()).rev() {
            if let Some([a, b]) = self.halves(k as u32) {
                let [a, b] = [a, b].map(|half| self.nodes[half as usize]);
                self.nodes[k].area = a.area + b.area;
                self.nodes[k].kind = if a.kind == b.kind { a.kind } else { NONE };
            }
        }
    }

    /// Nodes in all: leaves and what they are joined to.
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The two halves of a node; `None` where it is a patch.
    #[inline]
    pub(super) fn halves(&self, node: u32) -> Option<[u32; 2]> {
        if self.nodes[node as usize].count == 1 {
            return None;
        }
        Some([node + 1, node + 2 * self.nodes[node as usize + 1].count])
    }

    /// The node that a node is a half of.
    #[inline]
    pub(super) fn parent(&self, node: u32) -> Option<u32> {
        let parent = self.nodes[node as usize].parent;
        (parent != NONE).then_some(parent)
    }

    /// The places of its patches.
    #[inline]
    pub(super) fn places(&self, node: u32) -> Range<u32> {
        let Node { first, count, .. } = self.nodes[node as usize];
        first..first + count
    }

    /// Its patches.
    pub(super) fn patches(&self, node: u32) -> &[u32] {
        let places = self.places(node);
        &self.order[places.start as usize..places.end as usize]
    }

    /// Where a patch stands among all.
    #[inline]
    pub(super) fn place(&self, patch: u32) -> u32 {
        self.place[patch as usize]
    }

    /// The node that is this patch alone.
    #[inline]
    pub(super) fn leaf(&self, patch: u32) -> u32 {
        self.leaf[patch as usize]
    }

    /// Whether a node is one patch, which it is.
    #[inline]
    pub(super) fn single(&self, node: u32) -> Option<u32> {
        let Node { first, count, .. } = self.nodes[node as usize];
        (count == 1).then(|| self.order[first as usize])
    }

    /// Whether all its patches are of one material and, where they emit, of one lamp.
    #[inline]
    pub(super) fn is_uniform(&self, node: u32) -> bool {
        self.nodes[node as usize].kind != NONE
    }

    /// Area of a patch in its nodes, m²: nought where it is buried.
    #[inline]
    pub(super) fn weight(&self, patch: u32) -> f64 {
        self.weight[patch as usize]
    }

    /// Share of a patch in a node that holds it: its weight over that of all.
    #[inline]
    pub(super) fn share(&self, patch: u32, node: u32) -> f64 {
        let area = self.nodes[node as usize].area;
        if area > 0.0 { self.weight[patch as usize] / area } else { 0.0 }
    }

    /// For every node the mean over its patches of a value per patch, by their areas.
    pub(super) fn means(&self, values: &[f64]) -> Vec<f64> {
        let mut means = vec![0.0; self.nodes.len()];
        for (patch, &value) in values.iter().enumerate() {
            means[self.leaf[patch] as usize] = value * self.weight[patch];
        }
        for k in (0..self.nodes.len()).rev() {
            let Node { parent, area, .. } = self.nodes[k];
            if parent != NONE {
                means[parent as usize] += means[k];
            }
            means[k] = if area > 0.0 { means[k] / area } else { 0.0 };
        }
        means
    }

    /// The transpose of [`Self::means`]: what each patch gets where every node divides its value among its patches by
    /// their areas.
    pub(super) fn spread(&self, mut values: Vec<f64>) -> Vec<f64> {
        for k in 0..self.nodes.len() {
            let Node { parent, area, .. } = self.nodes[k];
            let above = if parent == NONE { 0.0 } else { values[parent as usize] };
            // From here on a value is per area.
            values[k] = above + if area > 0.0 { values[k] / area } else { 0.0 };
        }
        self.leaf.iter().zip(&self.weight).map(|(&leaf, weight)| values[leaf as usize] * weight).collect()
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.order.len() * 20
    }

    /// Area of its patches that are not buried, m².
    #[inline]
    pub(super) fn area(&self, node: u32) -> f64 {
        self.nodes[node as usize].area
    }
}

/// Sides by place and direction in two halves, neither empty.
fn halved(items: &mut [Item], apart: f64) -> (&mut [Item], &mut [Item]) {
    let at = |item: &Item, axis: usize| {
        if axis < 3 { item.centre[axis] } else { apart * item.normal[axis - 3] }
    };
    let ranges: [[f64; 2]; 6] = std::array::from_fn(|axis| {
        items.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], item| {
            [low.min(at(item, axis)), high.max(at(item, axis))]
        })
    });
    let extent = |axis: usize| ranges[axis][1] - ranges[axis][0];
    let materials = items.iter().map(|item| item.material);
    let [first, last] = [materials.clone().min(), materials.max()].map(|m| m.map_or(0.0, f64::from));
    if first < last && (0..3).all(|axis| extent(axis) < apart) {
        return split(items, |item| f64::from(item.material), [first, last]);
    }
    let widest = (1..6).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best });
    split(items, |item| at(item, widest), ranges[widest])
}

/// Those whose key lies below the middle of the range of all, and the others; where all have one, halves of the list.
fn split<T>(items: &mut [T], key: impl Fn(&T) -> f64, [low, high]: [f64; 2]) -> (&mut [T], &mut [T]) {
    let middle = 0.5 * (low + high);
    // A sort that keeps the order of equals: the same tree on every run.
    items.sort_by_key(|item| key(item) >= middle);
    let at = items.partition_point(|item| key(item) < middle);
    let at = if (1..items.len()).contains(&at) { at } else { items.len() / 2 };
    items.split_at_mut(at)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};

    pub(in crate::transport::tree) fn mesh(name: &str, patches: usize) -> PatchMesh {
        let scene = load(&SceneSource::Builtin(name.to_owned())).expect("embedded");
        let settings = MeshSettings { target: PatchTarget::Count(patches), ..MeshSettings::default() };
        build(&scene, &settings).expect("a mesh")
    }

    #[test]
    fn every_patch_is_in_one_leaf_and_nodes_are_the_sum_of_their_halves() {
        let mesh = mesh("gallery", 900);
        let tree = Tree::new(&mesh, &|| false).expect("whole");
        let n = mesh.patches.len();
        assert_eq!(tree.len(), 2 * n - 1);
        let mut seen = vec![false; n];
        for node in 0..tree.len() as u32 {
            let area: f64 = tree.patches(node).iter().map(|&p| tree.weight(p)).sum();
            assert!((tree.area(node) - area).abs() < 1e-9 * area.max(1.0), "node {node}");
            let own = tree.places(node);
            if let Some([a, b]) = tree.halves(node) {
                let ([a_places, b_places], [a_parent, b_parent]) =
                    ([a, b].map(|half| tree.places(half)), [a, b].map(|half| tree.parent(half)));
                assert_eq!(
                    (a_places.start, a_places.end, b_places.end),
                    (own.start, b_places.start, own.end)
                );
                assert!(a_parent == Some(node) && b_parent == Some(node));
            } else {
                let patch = tree.single(node).expect("a leaf");
                assert!(tree.leaf(patch) == node && tree.place(patch) == own.start);
                assert!(!std::mem::replace(&mut seen[patch as usize], true), "patch {patch} twice");
            }
            let first = &mesh.patches[tree.patches(node)[0] as usize];
            let alike = |&p: &u32| {
                let p = &mesh.patches[p as usize];
                (p.material, p.luminaire) == (first.material, first.luminaire)
            };
            assert!(!tree.is_uniform(node) || tree.patches(node).iter().all(alike), "node {node}");
        }
        assert!(seen.iter().all(|&seen| seen));
    }

    #[test]
    fn means_and_spread_are_transposes() {
        let mesh = mesh("cornell", 200);
        let tree = Tree::new(&mesh, &|| false).expect("whole");
        let number = |k: usize| (0.618_033_988_75 * k as f64).fract();
        let x: Vec<f64> = (0..mesh.patches.len()).map(number).collect();
        let y: Vec<f64> = (0..tree.len()).map(|k| number(7 * k + 3)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (one, other) = (dot(&tree.means(&x), &y), dot(&x, &tree.spread(y.clone())));
        assert!((one - other).abs() < 1e-10 * one, "{one} and {other}");
        for (node, mean) in (0..).zip(tree.means(&vec![1.0; x.len()])) {
            // Nodes of nothing but buried patches send nothing.
            let expected = f64::from(u8::from(tree.area(node) > 0.0));
            assert!((mean - expected).abs() < 1e-12, "node {node}: {mean}");
        }
    }

    #[test]
    fn a_tree_can_be_ended() {
        let mesh = mesh("cornell", 900);
        assert!(Tree::new(&mesh, &|| true).is_err());
    }
}
