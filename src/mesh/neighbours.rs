//! Which patches lie beside a patch, and where its border runs.

use super::{NO_PATCH, Patch, PatchMesh, Piece};
use crate::geometry::Aabb;
use glam::DVec3;
use std::collections::HashMap;

/// How two patches touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Contact {
    /// On one region, at a point.
    Vertex,
    /// On one region, along a stretch of their borders.
    Edge,
    /// On two regions, along a stretch of their borders: in a corner of a room, over the edge of a box.
    Crease,
}

/// Distances below this share of a grid cell count as touching.
const TOUCHING: f64 = 1e-6;

impl PatchMesh {
    /// The patches that touch `patch`, in rising order: on its own side of its own region at edges and
    /// points, on others along edges, on the sides that look into the same space.
    ///
    /// # Panics
    /// If there is no such patch.
    pub fn neighbours(&self, patch: u32) -> Vec<(u32, Contact)> {
        let own = &self.patches[patch as usize];
        let near = TOUCHING * self.regions[own.region as usize].cell_size.min_element();
        let outline = |piece: &Piece| -> Vec<DVec3> {
            self.corners_of(piece).iter().map(|c| self.vertices[c.vertex as usize]).collect()
        };
        let own_outlines: Vec<Vec<DVec3>> = self.pieces_of(own).map(outline).collect();
        let bounds = Aabb::around(own_outlines.iter().flatten().copied());
        let apart = |other: &Aabb| {
            let gap = (other.min - bounds.max).max(bounds.min - other.max);
            gap.max_element() > near
        };
        let mut found: HashMap<u32, Contact> = HashMap::new();
        for (index, region) in self.regions.iter().enumerate().filter(|(_, region)| !apart(&region.bounds)) {
            let same = index == own.region as usize;
            for piece in &self.pieces[region.pieces.start as usize..region.pieces.end as usize] {
                let corners = outline(piece);
                if apart(&Aabb::around(corners.iter().copied())) {
                    continue;
                }
                let beside = |other: u32| {
                    let there = &self.patches[other as usize];
                    if same { there.side == own.side } else { look_into_one_space(own, there) }
                };
                let others = piece.patches.into_iter().filter(|&p| p != NO_PATCH && p != patch);
                for other in others.filter(|&p| beside(p)) {
                    let touch = own_outlines.iter().filter_map(|o| contact(o, &corners, near)).max();
                    let touch = match touch {
                        Some(Contact::Edge) if !same => Some(Contact::Crease),
                        touch => touch.filter(|_| same),
                    };
                    if let Some(touch) = touch {
                        let kept = found.entry(other).or_insert(touch);
                        *kept = (*kept).max(touch);
                    }
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

/// Whether two patches that share an edge bound the same space: both face each other, both turn away
/// from each other, or both go on in one plane.
fn look_into_one_space(a: &Patch, b: &Patch) -> bool {
    let way = b.centre - a.centre;
    let slack = 1e-6 * way.length();
    let (ahead, back) = (a.normal.dot(way), -b.normal.dot(way));
    if ahead.abs() <= slack && back.abs() <= slack {
        a.normal.dot(b.normal) > 0.0
    } else {
        ahead * back > 0.0
    }
}

/// How two outlines touch, if they do: along an edge or at a vertex.
fn contact(a: &[DVec3], b: &[DVec3], near: f64) -> Option<Contact> {
    let edges = |outline: &[DVec3]| -> Vec<[DVec3; 2]> {
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
            let aside = |x: DVec3| along.cross(x - p).length();
            if aside(r) > near || aside(s) > near {
                continue;
            }
            let (from, to) = (along.dot(r - p), along.dot(s - p));
            if from.max(to).min(length) - from.min(to).max(0.0) > near {
                return Some(Contact::Edge);
            }
        }
    }
    let on_border = |x: DVec3, edges: &[[DVec3; 2]]| {
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
                .map(|[a, b]| DVec3::new(x + size * a, 2.0, y + size * b))
        };
        let one = square(0.0, 0.0, 1.0);
        assert_eq!(contact(&one, &square(1.0, 0.0, 1.0), 1e-6), Some(Contact::Edge));
        assert_eq!(contact(&one, &square(1.0, 0.25, 0.5), 1e-6), Some(Contact::Edge), "half an edge is one");
        assert_eq!(contact(&one, &square(1.0, 1.0, 1.0), 1e-6), Some(Contact::Vertex));
        assert_eq!(contact(&one, &square(1.0, 0.5, 0.5), 1e-6), Some(Contact::Edge));
        assert_eq!(contact(&one, &square(1.1, 0.0, 1.0), 1e-6), None);
    }

    #[test]
    fn neighbours_are_mutual_and_lie_where_they_are_said_to() {
        let mesh = mesh();
        let (mut inner, mut creases) = (0, 0);
        for index in 0..mesh.patches.len() as u32 {
            let patch = &mesh.patches[index as usize];
            let around = mesh.neighbours(index);
            for &(other, contact) in &around {
                let there = &mesh.patches[other as usize];
                let same = (there.region, there.side) == (patch.region, patch.side);
                assert_eq!(same, contact != Contact::Crease, "{index} and {other}");
                assert!(mesh.neighbours(other).contains(&(index, contact)), "{index} and {other}");
                creases += usize::from(!same);
            }
            let edges = around.iter().filter(|n| n.1 == Contact::Edge).count();
            inner += usize::from(around.len() == 8 && edges == 4);
        }
        assert!(inner > 100, "in a grid a patch has four neighbours at edges and four at corners: {inner}");
        assert!(creases > 50, "walls meet: {creases}");
    }

    #[test]
    fn patches_of_two_walls_look_into_one_space_from_their_inner_sides() {
        let mesh = mesh();
        let floor = mesh.patches.iter().position(|p| p.normal.y > 0.99).expect("a floor") as u32;
        let (ahead, turned) = (&mesh.patches[floor as usize], &mut mesh.patches[floor as usize].clone());
        for &(other, _) in mesh.neighbours(floor).iter().filter(|n| n.1 == Contact::Crease) {
            let there = &mesh.patches[other as usize];
            assert!(look_into_one_space(ahead, there) && look_into_one_space(there, ahead));
            turned.normal = -ahead.normal;
            assert!(!look_into_one_space(turned, there), "from below the floor it is another space");
        }
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
