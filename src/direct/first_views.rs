//! What the triangles of a mesh may see of the emitters: looked for once for those of a surface that lie side by side, and
//! narrowed for each.

use super::elements::Elements;
use super::light::{DirectLight, Scratch, Views};
use crate::mesh::PatchMesh;
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Triangles of a group at most.
const MOST: usize = 16;
/// A facet of a cluster is looked at by rays where its edge is less than this part of a patch's.
const SLIGHT: f64 = 0.25;

/// For each root what it may see; nothing for what they are divided into.
pub(super) fn first_views(
    elements: &Elements,
    mesh: &PatchMesh,
    light: &DirectLight,
    watch: &mut Watch<'_>,
) -> Result<Vec<Arc<Views>>, Cancelled> {
    let groups = groups(elements, mesh);
    let seen = watch.map(&groups, |_, group| {
        let mut scratch = Scratch::default();
        let first = &elements.elements[group[0] as usize];
        let normal = elements.normal(first, mesh);
        if is_slight(elements, group[0], mesh) {
            return group.iter().map(|_| Views::sampled()).collect();
        }
        let positions = |root: u32| elements.positions(&elements.elements[root as usize]);
        if let [root] = group[..] {
            return vec![light.views(&positions(root), normal, false, &mut scratch)];
        }
        let corners = group.iter().flat_map(|&root| positions(root));
        let all = light.views(&rectangle(elements, mesh, group[0], corners), normal, false, &mut scratch);
        group.iter().map(|&root| light.narrowed(&all, &positions(root), normal, &mut scratch)).collect()
    })?;
    let mut views = vec![Arc::default(); elements.elements.len()];
    for (group, seen) in groups.into_iter().zip(seen) {
        for (root, seen) in group.into_iter().zip(seen) {
            views[root as usize] = Arc::new(seen);
        }
    }
    Ok(views)
}

/// Whether an element is a facet of a cluster so much smaller than a patch that shadows within it do not matter.
fn is_slight(elements: &Elements, root: u32, mesh: &PatchMesh) -> bool {
    let patch = &mesh.patches[elements.elements[root as usize].patch as usize];
    let slight = SLIGHT * mesh.statistics.patch_size;
    patch.is_cluster && mesh.regions[elements.regions[root as usize] as usize].area < slight * slight
}

/// The roots of each side of each region, halved along their longer axis until they are few. Those of buried patches
/// are left out.
fn groups(elements: &Elements, mesh: &PatchMesh) -> Vec<Vec<u32>> {
    let mut of_side: BTreeMap<(u32, u8), Vec<u32>> = BTreeMap::new();
    // The roots come first.
    for (root, element) in (0_u32..).zip(&elements.elements[..elements.regions.len()]) {
        let patch = &mesh.patches[element.patch as usize];
        if !patch.buried {
            of_side.entry((elements.regions[root as usize], patch.side as u8)).or_default().push(root);
        }
    }
    let mut groups = Vec::new();
    for ((region, _), roots) in of_side {
        let frame = mesh.regions[region as usize].frame;
        let mut waiting: Vec<Vec<(DVec2, u32)>> = vec![
            roots
                .into_iter()
                .map(|root| {
                    let [a, b, c] = elements.positions(&elements.elements[root as usize]);
                    (frame.local((a + b + c) / 3.0).truncate(), root)
                })
                .collect(),
        ];
        while let Some(mut roots) = waiting.pop() {
            if roots.len() <= MOST {
                groups.push(roots.into_iter().map(|root| root.1).collect());
                continue;
            }
            let (low, high) = extent(roots.iter().map(|root| root.0));
            let axis = if (high - low).x >= (high - low).y { DVec2::X } else { DVec2::Y };
            roots.sort_by(|a, b| axis.dot(a.0).total_cmp(&axis.dot(b.0)).then(a.1.cmp(&b.1)));
            let rest = roots.split_off(roots.len() / 2);
            waiting.extend([rest, roots]);
        }
    }
    groups
}

/// The rectangle along the axes of a root's region that holds these points of its plane.
fn rectangle(
    elements: &Elements,
    mesh: &PatchMesh,
    root: u32,
    corners: impl Iterator<Item = DVec3>,
) -> [DVec3; 4] {
    let region = &mesh.regions[elements.regions[root as usize] as usize];
    let local = corners.map(|corner| region.frame.local(corner - region.origin).truncate());
    let (low, high) = extent(local);
    [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)]
        .map(|p| region.origin + region.frame.tangent * p.x + region.frame.bitangent * p.y)
}

fn extent(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}
