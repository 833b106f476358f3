//! Elements: the triangles of a mesh divided further, which carry direct light at their corners.
//!
//! Every lit side of every triangle of [`PatchMesh::triangles`] is the root of a binary tree. A triangle is divided
//! across one of its edges, and so is its neighbour there: no corner ever lies within an edge, and colours that are
//! linear between corners have no seams (longest-edge bisection, Rivara 1984).

use super::sky_parts::SkyParts;
use crate::mesh::{self, NO_PATCH, PatchMesh, Side};
use glam::DVec3;
use std::collections::HashMap;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// Stands for "no element".
pub const NO_ELEMENT: u32 = u32::MAX;

/// A triangle of a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Indices of its corners, in the order of its root's: counter-clockwise from the front.
    pub corners: [u32; 3],
    /// The patch that it is a part of.
    pub patch: u32,
    /// The first of its two children; [`NO_ELEMENT`] on a leaf.
    pub children: u32,
    /// Where it is divided: across the edge from this corner to the next.
    pub edge: u8,
}

/// A corner of elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementCorner {
    /// Metres.
    pub position: DVec3,
    /// Unit normal of the surface there, smooth where the model is.
    pub normal: DVec3,
}

/// The trees, without light.
#[derive(Clone, Debug, Default)]
pub struct Trees {
    /// All corners; those of the roots come first.
    pub corners: Vec<ElementCorner>,
    /// All triangles, roots first.
    pub elements: Vec<Element>,
    /// For each triangle of [`PatchMesh::triangles`] and each side, at `2 * triangle + side`, its root; [`NO_ELEMENT`]
    /// where the side has no patch.
    pub roots: Vec<u32>,
    /// For each root the region that it lies on.
    pub(super) regions: Vec<u32>,
}

/// The trees, and the direct light at their corners.
#[derive(Clone, Debug, Default)]
pub struct Elements {
    trees: Arc<Trees>,
    /// Where the values of each corner end in `values`.
    ends: Vec<u32>,
    /// Basis and irradiance per unit of its exitance.
    values: Vec<(u32, f32)>,
    /// What each corner sees of the parts of the sky; empty where the light is that of one hour alone.
    pub(super) parts: SkyParts,
    /// What the direct light is expected to be off by, RMS over the area: see [`super::ElementSettings::error`].
    pub expected_error: f64,
}

impl Deref for Elements {
    type Target = Trees;

    fn deref(&self) -> &Trees {
        &self.trees
    }
}

impl DerefMut for Elements {
    /// Trees that others have as well are copied first.
    fn deref_mut(&mut self) -> &mut Trees {
        Arc::make_mut(&mut self.trees)
    }
}

impl Elements {
    /// Whether both are the very same trees, whatever their light.
    pub fn are_same_trees(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.trees, &other.trees)
    }

    /// The triangles of a mesh, undivided and dark.
    pub(super) fn roots_of(mesh: &PatchMesh, smooth: bool) -> Self {
        let stretches = mesh::stretches(mesh);
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        let mut all = Trees::default();
        for piece in &mesh.pieces {
            let flat = mesh.regions[piece.region as usize].frame.normal;
            let mut corner_on = |all: &mut Trees, side: Side, k: usize| {
                let corner = piece.corners.start as usize + k;
                let from = &mesh.corners[corner];
                let stretch = stretches.get(corner).copied().unwrap_or(0);
                *known.entry([from.vertex, piece.region, 2 * stretch + side as u32]).or_insert_with(|| {
                    let normal = if smooth { from.normal } else { flat };
                    all.corners.push(ElementCorner {
                        position: mesh.vertices[from.vertex as usize],
                        normal: normal * side.sign(),
                    });
                    all.corners.len() as u32 - 1
                })
            };
            for k in 1..piece.corners.len() - 1 {
                for side in [Side::Front, Side::Back] {
                    let patch = piece.patches[side as usize];
                    if patch == NO_PATCH {
                        all.roots.push(NO_ELEMENT);
                        continue;
                    }
                    let corners = [0, k, k + 1].map(|k| corner_on(&mut all, side, k));
                    all.roots.push(all.elements.len() as u32);
                    all.elements.push(Element { corners, patch, children: NO_ELEMENT, edge: 0 });
                    all.regions.push(piece.region);
                }
            }
        }
        Self { trees: Arc::new(all), ..Self::default() }
    }

    /// The undivided triangles.
    pub fn leaves(&self) -> impl Iterator<Item = &Element> {
        self.leaves_with_index().map(|leaf| leaf.1)
    }

    /// The undivided triangles, each with its index.
    pub fn leaves_with_index(&self) -> impl Iterator<Item = (u32, &Element)> {
        (0_u32..).zip(&self.elements).filter(|(_, element)| element.children == NO_ELEMENT)
    }

    /// Calls `found` with the undivided parts of an element.
    pub fn leaves_of(&self, element: u32, mut found: impl FnMut(u32)) {
        let mut stack = vec![element];
        while let Some(at) = stack.pop() {
            match self.elements[at as usize].children {
                NO_ELEMENT => found(at),
                children => stack.extend([children + 1, children]),
            }
        }
    }

    /// Positions of the corners of an element, metres.
    pub fn positions(&self, element: &Element) -> [DVec3; 3] {
        element.corners.map(|corner| self.corners[corner as usize].position)
    }

    /// Unit normal of the plane of an element, on its side: a patch may be a cluster of facets of many planes.
    pub(super) fn normal(&self, element: &Element, mesh: &PatchMesh) -> DVec3 {
        let patch = &mesh.patches[element.patch as usize];
        if !patch.is_cluster {
            return patch.normal;
        }
        let [a, b, c] = self.positions(element);
        ((b - a).cross(c - a) * patch.side.sign()).normalize_or(patch.normal)
    }

    /// Area of an element, m².
    pub fn area(&self, element: &Element) -> f64 {
        let [a, b, c] = self.positions(element);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Direct light at a corner: basis and irradiance per unit of its exitance, bases in rising order.
    pub fn light_at(&self, corner: u32) -> &[(u32, f32)] {
        let c = corner as usize;
        let start = if c == 0 { 0 } else { self.ends.get(c - 1).copied().unwrap_or(0) };
        let end = self.ends.get(c).copied().unwrap_or(start);
        &self.values[start as usize..end as usize]
    }

    /// All direct light at a corner for these exitances of the bases, in units of theirs.
    pub fn watts_at(&self, corner: u32, exitance: &[f64]) -> f64 {
        let light = self.light_at(corner).iter();
        light.map(|&(basis, value)| f64::from(value) * exitance[basis as usize]).sum()
    }

    /// Adds the light of the next corner, bases in rising order.
    pub(super) fn push_light(&mut self, light: &[(u32, f32)]) {
        self.values.extend_from_slice(light);
        self.ends.push(self.values.len() as u32);
    }

    /// The same elements without any light.
    pub(super) fn unlit(&self) -> Self {
        Self { trees: Arc::clone(&self.trees), expected_error: self.expected_error, ..Self::default() }
    }

    /// How many corners have been given light.
    pub(super) fn lit(&self) -> usize {
        self.ends.len()
    }

    /// The leaf that holds a point of a root, by the weights of the root's corners, and the weights of its own
    /// corners there.
    pub fn locate(&self, root: u32, mut weights: [f64; 3]) -> (u32, [f64; 3]) {
        let mut at = root;
        loop {
            let element = &self.elements[at as usize];
            if element.children == NO_ELEMENT {
                return (at, weights);
            }
            let e = usize::from(element.edge);
            let [a, b, c] = [e, (e + 1) % 3, (e + 2) % 3].map(|k| weights[k]);
            // The children run from the far corner to an end of the edge to its middle.
            if a >= b {
                (at, weights) = (element.children, [c, a - b, 2.0 * b]);
            } else {
                (at, weights) = (element.children + 1, [b - a, c, 2.0 * a]);
            }
        }
    }

    /// The leaf that holds a place of a side of a triangle of [`PatchMesh::triangles`], `2 * triangle + side`, by the
    /// weights of its corners, and the weights of the leaf's own corners there. `None` on sides without a patch.
    pub fn place(&self, side: usize, weights: [f64; 3]) -> Option<(u32, [f64; 3])> {
        let root = *self.roots.get(side).filter(|&&root| root != NO_ELEMENT)?;
        Some(self.locate(root, weights))
    }

    /// Calls `found` with each undivided part of a side of a triangle of [`PatchMesh::triangles`], `2 * triangle + side`, and
    /// the weights of the triangle's corners at each of its own.
    pub fn each_leaf(&self, side: usize, mut found: impl FnMut(u32, [[f64; 3]; 3])) {
        let Some(&root) = self.roots.get(side).filter(|&&root| root != NO_ELEMENT) else { return };
        let mut stack = vec![(root, [DVec3::X, DVec3::Y, DVec3::Z])];
        while let Some((at, weights)) = stack.pop() {
            let element = &self.elements[at as usize];
            if element.children == NO_ELEMENT {
                found(at, weights.map(|weights| weights.to_array()));
                continue;
            }
            let e = usize::from(element.edge);
            let [a, b, c] = [e, (e + 1) % 3, (e + 2) % 3].map(|k| weights[k]);
            let middle = 0.5 * (a + b);
            stack.push((element.children, [c, a, middle]));
            stack.push((element.children + 1, [b, c, middle]));
        }
    }

    /// Divides an element across an edge whose middle is the corner `middle`.
    pub(super) fn divide(&mut self, index: u32, edge: usize, middle: u32) {
        let children = self.elements.len() as u32;
        let element = &mut self.elements[index as usize];
        let [a, b, c] = [edge, (edge + 1) % 3, (edge + 2) % 3].map(|k| element.corners[k]);
        let patch = element.patch;
        (element.edge, element.children) = (edge as u8, children);
        for corners in [[c, a, middle], [b, c, middle]] {
            self.elements.push(Element { corners, patch, children: NO_ELEMENT, edge: 0 });
        }
    }

    /// Values at the corners of these elements, brought to the corners of others over the same mesh: those that these do
    /// not have lie in the middle of an edge and get the mean of its ends. `None` where they are over another mesh, or
    /// there is not one value per corner.
    pub fn carried(&self, values: &[[f32; 3]], to: &Self) -> Option<Vec<[f32; 3]>> {
        if values.len() != self.corners.len() || self.roots != to.roots {
            return None;
        }
        let mut carried = vec![[0.0; 3]; to.corners.len()];
        let mut stack: Vec<(Option<u32>, u32, [[f32; 3]; 3])> = Vec::new();
        for &root in self.roots.iter().filter(|&&root| root != NO_ELEMENT) {
            let corners = self.elements[root as usize].corners;
            stack.push((Some(root), root, corners.map(|corner| values[corner as usize])));
            while let Some((own, at, here)) = stack.pop() {
                let element = &to.elements[at as usize];
                for (&corner, value) in element.corners.iter().zip(here) {
                    carried[corner as usize] = value;
                }
                if element.children == NO_ELEMENT {
                    continue;
                }
                let e = usize::from(element.edge);
                let [a, b, c] = [e, (e + 1) % 3, (e + 2) % 3].map(|k| here[k]);
                let own = own.map(|own| &self.elements[own as usize]);
                let own = own.filter(|own| own.children != NO_ELEMENT && own.edge == element.edge);
                let children = own.map(|own| own.children);
                let middle = match children {
                    Some(first) => values[self.elements[first as usize].corners[2] as usize],
                    None => std::array::from_fn(|band| 0.5 * (a[band] + b[band])),
                };
                stack.push((children, element.children, [c, a, middle]));
                stack.push((children.map(|first| first + 1), element.children + 1, [b, c, middle]));
            }
        }
        Some(carried)
    }

    /// Mean direct light of each patch, a value per basis: `values[patch * bases + basis]`.
    pub fn patch_means(&self, mesh: &PatchMesh, bases: usize) -> Vec<f32> {
        let mut sums = vec![0.0_f64; mesh.patches.len() * bases];
        for element in self.leaves() {
            let third = self.area(element) / 3.0;
            let own = &mut sums[element.patch as usize * bases..][..bases];
            for &(basis, value) in element.corners.iter().flat_map(|&corner| self.light_at(corner)) {
                own[basis as usize] += third * f64::from(value);
            }
        }
        let patches = mesh.patches.iter().flat_map(|p| std::iter::repeat_n(p.outline_area(), bases));
        sums.iter()
            .zip(patches)
            .map(|(sum, area)| if area > 0.0 { (sum / area) as f32 } else { 0.0 })
            .collect()
    }

    /// Leaves out corners that no element has, and their light.
    pub(super) fn compact(&mut self) {
        let mut used = vec![false; self.corners.len()];
        for element in &self.trees.elements {
            element.corners.iter().for_each(|&corner| used[corner as usize] = true);
        }
        let mut kept = Self::default();
        let mut trees =
            Trees { roots: self.roots.clone(), regions: self.regions.clone(), ..Trees::default() };
        let mut new = vec![0_u32; self.corners.len()];
        for (index, corner) in self.trees.corners.iter().enumerate() {
            if used[index] {
                new[index] = trees.corners.len() as u32;
                trees.corners.push(*corner);
                kept.push_light(self.light_at(index as u32));
                kept.parts.push_from(&self.parts, index);
            }
        }
        trees.elements.clone_from(&self.trees.elements);
        for element in &mut trees.elements {
            element.corners = element.corners.map(|corner| new[corner as usize]);
        }
        kept.trees = Arc::new(trees);
        kept.expected_error = self.expected_error;
        *self = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle, undivided.
    fn triangle() -> Elements {
        let corner = |x: f64, y: f64| ElementCorner { position: DVec3::new(x, y, 0.0), normal: DVec3::Z };
        let trees = Trees {
            corners: vec![corner(0.0, 0.0), corner(4.0, 0.0), corner(0.0, 4.0)],
            elements: vec![Element { corners: [0, 1, 2], patch: 0, children: NO_ELEMENT, edge: 0 }],
            roots: vec![0, NO_ELEMENT],
            regions: vec![0],
        };
        Elements { trees: Arc::new(trees), ..Elements::default() }
    }

    fn divided(elements: &Elements, index: u32, edge: usize) -> Elements {
        let mut divided = elements.clone();
        let element = elements.elements[index as usize];
        let [a, b] = [edge, (edge + 1) % 3].map(|k| elements.corners[element.corners[k] as usize]);
        let middle = divided.corners.len() as u32;
        let position = 0.5 * (a.position + b.position);
        divided.corners.push(ElementCorner { position, normal: DVec3::Z });
        divided.divide(index, edge, middle);
        divided
    }

    #[test]
    fn values_are_carried_to_finer_and_to_coarser_elements() {
        let coarse = divided(&triangle(), 0, 1);
        let fine = divided(&divided(&coarse, 1, 0), 2, 0);
        // Not linear over the whole triangle: the middle of its edge stands for itself.
        let values = [[0.0, 1.0, 2.0], [4.0; 3], [8.0; 3], [1.0; 3]];
        let carried = coarse.carried(&values, &fine).expect("the same mesh");
        assert_eq!(carried[..4], values);
        for (corner, value) in fine.corners.iter().zip(&carried).skip(4) {
            let ends: Vec<[f32; 3]> = match corner.position {
                p if p == DVec3::new(2.0, 0.0, 0.0) => vec![values[0], values[1]],
                p if p == DVec3::new(0.0, 2.0, 0.0) => vec![values[2], values[0]],
                other => panic!("{other}"),
            };
            for band in 0..3 {
                assert_eq!(value[band], 0.5 * (ends[0][band] + ends[1][band]), "{}", corner.position);
            }
        }
        assert_eq!(fine.carried(&carried, &coarse).expect("the same mesh"), values);
        // Divided otherwise, and of another mesh.
        let other = divided(&triangle(), 0, 0);
        assert_eq!(coarse.carried(&values, &other).expect("the same mesh")[3], [2.0, 2.5, 3.0]);
        assert_eq!(coarse.carried(&values[..3], &fine), None);
        assert_eq!(Elements::default().carried(&[], &fine), None);
    }
}
