//! Which patches lie beside a patch on its own surface, and where its border runs.

use super::{NO_PATCH, PatchMesh, Piece};
use crate::geometry::Aabb;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// How two patches of one region touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Contact {
    /// At a point.
    Vertex,
    /// Along a stretch of their borders.
    Edge,
}

/// Distances below this share of a grid cell count as touching.
const TOUCHING: f64 = 1e-6;

impl PatchMesh {
    /// The patches on the same side of the same region that touch `patch`, in rising order.
    ///
    /// # Panics
    /// If there is no such patch.
    pub fn neighbours(&self, patch: u32) -> Vec<(u32, Contact)> {
        let own = &self.patches[patch as usize];
        let region = &self.regions[own.region as usize];
        let near = TOUCHING * region.cell_size.min_element();
        let outline =
            |piece: &Piece| -> Vec<DVec2> { self.corners_of(piece).iter().map(|c| c.plane).collect() };
        let own_outlines: Vec<Vec<DVec2>> = self.pieces_of(own).map(outline).collect();
        let all_corners = own_outlines.iter().flatten().map(|p| p.extend(0.0));
        let bounds = Aabb::around(all_corners);
        let mut found: HashMap<u32, Contact> = HashMap::new();
        for piece in &self.pieces[region.pieces.start as usize..region.pieces.end as usize] {
            let other = piece.patches[own.side as usize];
            if other == NO_PATCH || other == patch {
                continue;
            }
            let corners = outline(piece);
            let box_of = Aabb::around(corners.iter().map(|p| p.extend(0.0)));
            let gap = (box_of.min - bounds.max).max(bounds.min - box_of.max);
            if gap.x > near || gap.y > near {
                continue;
            }
            for own_outline in &own_outlines {
                if let Some(contact) = contact(own_outline, &corners, near) {
                    let kept = found.entry(other).or_insert(contact);
                    *kept = (*kept).max(contact);
                }
            }
        }
        let mut list: Vec<(u32, Contact)> = found.into_iter().collect();
        list.sort_unstable();
        list
    }

    /// The border of a patch as segments in space, metres: edges of its pieces that no two of them share.
    ///
    /// # Panics
    /// If there is no such patch.
    pub fn outline(&self, patch: u32) -> Vec<[DVec3; 2]> {
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for piece in self.pieces_of(&self.patches[patch as usize]) {
            let corners = self.corners_of(piece);
            edges.extend((0..corners.len()).map(|k| {
                let (a, b) = (corners[k].vertex, corners[(k + 1) % corners.len()].vertex);
                [a.min(b), a.max(b)]
            }));
        }
        edges.sort_unstable();
        edges
            .chunk_by(|a, b| a == b)
            .filter(|same| same.len() == 1)
            .map(|same| same[0].map(|v| self.vertices[v as usize]))
            .collect()
    }
}

/// How two outlines of one plane touch, if they do.
fn contact(a: &[DVec2], b: &[DVec2], near: f64) -> Option<Contact> {
    let edges = |outline: &[DVec2]| -> Vec<[DVec2; 2]> {
        (0..outline.len()).map(|k| [outline[k], outline[(k + 1) % outline.len()]]).collect()
    };
    let (a_edges, b_edges) = (edges(a), edges(b));
    for &[p, q] in &a_edges {
        let length = p.distance(q);
        if length <= near {
            continue;
        }
        let along = (q - p) / length;
        for &[r, s] in &b_edges {
            let aside = |x: DVec2| along.perp_dot(x - p).abs();
            if aside(r) > near || aside(s) > near {
                continue;
            }
            let (from, to) = (along.dot(r - p), along.dot(s - p));
            if from.max(to).min(length) - from.min(to).max(0.0) > near {
                return Some(Contact::Edge);
            }
        }
    }
    let on_border = |x: DVec2, edges: &[[DVec2; 2]]| {
        edges.iter().any(|&[p, q]| {
            let way = q - p;
            let t = ((x - p).dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (p + way * t).distance(x) <= near
        })
    };
    let touches = a.iter().any(|&x| on_border(x, &b_edges)) || b.iter().any(|&x| on_border(x, &a_edges));
    touches.then_some(Contact::Vertex)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};

    fn mesh() -> PatchMesh {
        let scene = load(&SceneSource::Builtin("cornell".to_owned())).expect("embedded");
        let settings = MeshSettings { target: PatchTarget::Count(400), ..MeshSettings::default() };
        build(&scene, &settings).expect("meshed")
    }

    #[test]
    fn squares_touch_along_edges_at_corners_or_not_at_all() {
        let square = |x: f64, y: f64, size: f64| {
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
                .map(|[a, b]| DVec2::new(x + size * a, y + size * b))
        };
        let one = square(0.0, 0.0, 1.0);
        assert_eq!(contact(&one, &square(1.0, 0.0, 1.0), 1e-6), Some(Contact::Edge));
        assert_eq!(contact(&one, &square(1.0, 0.25, 0.5), 1e-6), Some(Contact::Edge), "half an edge is one");
        assert_eq!(contact(&one, &square(1.0, 1.0, 1.0), 1e-6), Some(Contact::Vertex));
        assert_eq!(contact(&one, &square(1.0, 0.5, 0.5), 1e-6), Some(Contact::Edge));
        assert_eq!(contact(&one, &square(1.1, 0.0, 1.0), 1e-6), None);
    }

    #[test]
    fn neighbours_are_mutual_and_on_one_surface() {
        let mesh = mesh();
        let (mut edges, mut inner) = (0, 0);
        for index in 0..mesh.patches.len() as u32 {
            let patch = &mesh.patches[index as usize];
            let around = mesh.neighbours(index);
            edges += around.iter().filter(|n| n.1 == Contact::Edge).count();
            for &(other, contact) in &around {
                let there = &mesh.patches[other as usize];
                assert_eq!((there.region, there.side), (patch.region, patch.side));
                assert!(mesh.neighbours(other).contains(&(index, contact)), "{index} and {other}");
            }
            inner += usize::from(around.len() == 8);
        }
        assert!(inner > 100, "in a grid a patch has eight neighbours: {inner}");
        assert!(edges > 3 * inner, "{edges}");
    }

    #[test]
    fn outlines_are_closed_and_enclose_the_centre() {
        let mesh = mesh();
        for index in 0..mesh.patches.len() as u32 {
            let patch = &mesh.patches[index as usize];
            let outline = mesh.outline(index);
            assert!(outline.len() >= 3);
            // The area by Green's theorem, each segment turned so that the centre lies on its left.
            let twice: f64 = outline
                .iter()
                .map(|[a, b]| (*a - patch.centre).cross(*b - patch.centre).dot(patch.normal).abs())
                .sum();
            assert!(
                (0.5 * twice / patch.area - 1.0).abs() < 0.02,
                "{index}: {} of {}",
                0.5 * twice,
                patch.area
            );
        }
    }
}
