//! Where surfaces stand on a region, the stretches of it that their lines separate.

use super::types::PatchMesh;
use glam::DVec2;
use std::collections::{HashMap, HashSet};

/// For each corner that lies on a line where another surface stands, a number above zero that
/// tells apart the stretches around the vertex which that line separates; zero elsewhere.
/// Without it the dark floor under a box would shine through around the box. Empty where there are no such lines.
pub fn stretches(mesh: &PatchMesh) -> Vec<u32> {
    if mesh.contacts.iter().all(Vec::is_empty) {
        return Vec::new();
    }
    let mut parents: Vec<u32> = (0..mesh.corners.len() as u32).collect();
    let mut touching = vec![false; mesh.corners.len()];
    for (region, contacts) in mesh.regions.iter().zip(&mesh.contacts) {
        if contacts.is_empty() {
            continue;
        }
        let slack = 1e-5 * region.cell_size.min_element();
        // An edge that it shares with a neighbour separates nothing on it: facets of a curved surface are one.
        let is_edge = |line: &[DVec2; 2]| {
            region.edges.iter().any(|edge| {
                let ends_meet = |other: [DVec2; 2]| (0..2).all(|k| other[k].distance(line[k]) < slack);
                ends_meet(*edge) || ends_meet([edge[1], edge[0]])
            })
        };
        let contacts: Vec<[DVec2; 2]> = contacts.iter().filter(|line| !is_edge(line)).copied().collect();
        let on_contact = |point: DVec2| contacts.iter().any(|&[p, q]| is_on_segment(point, p, q, slack));
        let pieces = &mesh.pieces[region.pieces.start as usize..region.pieces.end as usize];
        let mut on_line: HashSet<u32> = HashSet::new();
        for piece in pieces {
            for corner in piece.corners.clone() {
                let from = &mesh.corners[corner as usize];
                if on_line.contains(&from.vertex) || on_contact(from.plane) {
                    on_line.insert(from.vertex);
                    touching[corner as usize] = true;
                }
            }
        }
        // Pieces that share an edge off the lines lie on one stretch at both of its ends.
        let mut open: HashMap<(u32, u32), (u32, u32)> = HashMap::new();
        for piece in pieces {
            let count = piece.corners.len() as u32;
            for k in 0..count {
                let (a, b) = (piece.corners.start + k, piece.corners.start + (k + 1) % count);
                let (from, to) = (&mesh.corners[a as usize], &mesh.corners[b as usize]);
                if !touching[a as usize] && !touching[b as usize] || on_contact(0.5 * (from.plane + to.plane))
                {
                    continue;
                }
                if let Some((c, d)) = open.insert((from.vertex, to.vertex), (a, b)) {
                    unite(&mut parents, a, c);
                    unite(&mut parents, b, d);
                }
                if let Some(&(c, d)) = open.get(&(to.vertex, from.vertex)) {
                    unite(&mut parents, a, d);
                    unite(&mut parents, b, c);
                }
            }
        }
    }
    (0..mesh.corners.len() as u32)
        .map(|corner| if touching[corner as usize] { root(&mut parents, corner) + 1 } else { 0 })
        .collect()
}

fn is_on_segment(point: DVec2, p: DVec2, q: DVec2, slack: f64) -> bool {
    if point.cmplt(p.min(q) - slack).any() || point.cmpgt(p.max(q) + slack).any() {
        return false;
    }
    let along = q - p;
    let t = ((point - p).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(p + along * t) < slack
}

fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}

fn unite(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    // The smaller one leads, so that the outcome does not depend on the order of unions.
    parents[a.max(b) as usize] = a.min(b);
}
