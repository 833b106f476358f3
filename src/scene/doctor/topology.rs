//! Which faces meet at which edges, once corners at one place count as one.

use crate::geometry::{Aabb, Bvh};
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// For each position the first one at the same place to within `tolerance`, metres.
pub(in crate::scene) fn weld(positions: &[DVec3], tolerance: f64) -> Vec<u32> {
    /// Edge of a cell in tolerances: most points lie far from the borders of theirs.
    const CELL: f64 = 16.0;
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(positions.len());
    let scale = 1.0 / (CELL * tolerance.max(f64::MIN_POSITIVE));
    let cell_of = |point: DVec3| (point * scale).floor().to_array().map(|c| c as i64);
    let mut welded = Vec::with_capacity(positions.len());
    for (index, &position) in positions.iter().enumerate() {
        let (low, high) = (cell_of(position - tolerance), cell_of(position + tolerance));
        let between = |axis: usize| low[axis]..=high[axis];
        let close = |&i: &u32| positions[i as usize].distance(position) <= tolerance;
        let near = between(0)
            .flat_map(|x| between(1).flat_map(move |y| between(2).map(move |z| [x, y, z])))
            .filter_map(|cell| cells.get(&cell)?.iter().copied().find(close))
            .min();
        let number = near.unwrap_or(index as u32);
        if near.is_none() {
            cells.entry(cell_of(position)).or_default().push(number);
        }
        welded.push(number);
    }
    welded
}

/// An edge of a face, in the direction in which the face runs along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) struct HalfEdge {
    /// Corner numbers.
    pub(in crate::scene) from: u32,
    pub(in crate::scene) to: u32,
    /// The face.
    pub(in crate::scene) face: u32,
    /// Which of the face's edges it is a part of: that after this corner.
    pub(in crate::scene) side: u32,
}

impl HalfEdge {
    /// The same for both directions.
    pub(in crate::scene) fn key(&self) -> (u32, u32) {
        (self.from.min(self.to), self.from.max(self.to))
    }

    pub(in crate::scene) fn ends(&self, positions: &[DVec3]) -> [DVec3; 2] {
        [positions[self.from as usize], positions[self.to as usize]]
    }
}

/// All edges of faces given by their corner numbers, those between the same corners side by side.
pub(in crate::scene) fn half_edges(faces: &[Vec<u32>]) -> Vec<HalfEdge> {
    let mut edges = Vec::with_capacity(4 * faces.len());
    for (face, corners) in faces.iter().enumerate() {
        for side in 0..corners.len() {
            let (from, to) = (corners[side], corners[(side + 1) % corners.len()]);
            if from != to {
                edges.push(HalfEdge { from, to, face: face as u32, side: side as u32 });
            }
        }
    }
    sort(&mut edges);
    edges
}

/// Brings edges between the same corners together.
pub(in crate::scene) fn sort(edges: &mut [HalfEdge]) {
    edges.sort_unstable_by_key(|e| (e.key(), e.face, e.side));
}

/// Runs of edges between the same corners.
pub(in crate::scene) fn bundles(sorted: &[HalfEdge]) -> impl Iterator<Item = &[HalfEdge]> {
    sorted.chunk_by(|a, b| a.key() == b.key())
}

/// A corner of another face in the middle of an edge.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Stop {
    /// Index of the edge in the list that was searched.
    pub(in crate::scene) edge: u32,
    /// Where it lies on the edge, 0 to 1.
    pub(in crate::scene) along: f64,
    /// The corner.
    pub(in crate::scene) corner: u32,
    /// How far beside the edge it lies, metres.
    pub(in crate::scene) aside: f64,
}

/// Corners of these edges that lie on others of them to within `tolerance`, by edge and place on it.
pub(in crate::scene) fn stops(edges: &[HalfEdge], positions: &[DVec3], tolerance: f64) -> Vec<Stop> {
    let mut corners: Vec<u32> = edges.iter().flat_map(|e| [e.from, e.to]).collect();
    corners.sort_unstable();
    corners.dedup();
    let points: Vec<[DVec3; 3]> = corners.iter().map(|&c| [positions[c as usize]; 3]).collect();
    let bvh = Bvh::build(&points);
    let mut found = Vec::new();
    for (index, edge) in edges.iter().enumerate() {
        let [start, end] = edge.ends(positions);
        let along = end - start;
        let length = along.length();
        let first = found.len();
        bvh.touching(&Aabb::around([start, end]).grown(tolerance), |k| {
            let corner = corners[k as usize];
            let offset = positions[corner as usize] - start;
            let distance = offset.dot(along) / length;
            let aside = (offset - along * (distance / length)).length();
            if aside <= tolerance && distance > tolerance && distance < length - tolerance {
                found.push(Stop { edge: index as u32, along: distance / length, corner, aside });
            }
        });
        found[first..].sort_by(|a: &Stop, b| a.along.total_cmp(&b.along).then(a.corner.cmp(&b.corner)));
    }
    found
}

/// Those stops at which an edge cut there meets another: the corners that it lacks. At the others a
/// corner only happens to lie on an edge. `pieces` are the edges [`cut`] at all stops.
pub(in crate::scene) fn missing<'a>(
    edges: &'a [HalfEdge],
    stops: &'a [Stop],
    pieces: &[HalfEdge],
) -> impl Iterator<Item = &'a Stop> + use<'a> {
    let met: HashSet<(u32, u32, u32)> = bundles(pieces)
        .filter(|bundle| bundle.len() > 1)
        .flatten()
        .flat_map(|p| [(p.face, p.side, p.from), (p.face, p.side, p.to)])
        .collect();
    stops.iter().filter(move |stop| {
        let edge = &edges[stop.edge as usize];
        met.contains(&(edge.face, edge.side, stop.corner))
    })
}

/// The edges cut at their stops.
pub(in crate::scene) fn cut(edges: &[HalfEdge], stops: &[Stop]) -> Vec<HalfEdge> {
    let mut pieces = Vec::with_capacity(edges.len() + stops.len());
    let mut stops = stops.iter().peekable();
    for (index, edge) in edges.iter().enumerate() {
        let mut from = edge.from;
        while let Some(stop) = stops.next_if(|s| s.edge == index as u32) {
            if stop.corner != from && stop.corner != edge.to {
                pieces.push(HalfEdge { from, to: stop.corner, ..*edge });
                from = stop.corner;
            }
        }
        pieces.push(HalfEdge { from, ..*edge });
    }
    sort(&mut pieces);
    pieces
}
