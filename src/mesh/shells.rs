//! Faces that hang together along edges: where none of many faces of a shell sees light, none is searched by itself.

use super::reach::Reach;
use super::regions::{Outline, Welder};
use std::collections::HashMap;

/// In models of fewer regions each is searched by itself.
const MANY: usize = 10_000;
/// So are those of shells of no more regions than this.
const FEW: usize = 256;
/// Regions of a shell that stand for it, spread over it.
const SAMPLES: usize = 64;

/// The shells of many regions.
#[derive(Default)]
pub(super) struct Shells {
    /// For each region its shell, where that is large.
    pub(super) of_region: Vec<Option<u32>>,
    /// For each shell the regions that stand for it.
    pub(super) samples: Vec<Vec<u32>>,
}

impl Shells {
    /// Finds the shells of a scene of some `size`, metres: regions whose edges run along each other in opposite
    /// directions, so that their fronts lie on one side.
    pub(super) fn find(outlines: &[Outline], size: f64) -> Self {
        if outlines.len() < MANY {
            return Self { of_region: vec![None; outlines.len()], ..Self::default() };
        }
        // 1. Join regions across edges.
        let mut welder = Welder::new(size * 1e-7);
        let mut parents: Vec<u32> = (0..outlines.len() as u32).collect();
        let mut open: HashMap<(u32, u32), u32> = HashMap::new();
        for (index, outline) in (0_u32..).zip(outlines) {
            for edge in &outline.edges {
                let [a, b] = edge.map(|end| welder.index(outline.world(end)));
                if let Some(&other) = open.get(&(b, a)) {
                    let (one, other) = (root(&mut parents, index), root(&mut parents, other));
                    parents[one.max(other) as usize] = one.min(other);
                }
                open.insert((a, b), index);
            }
        }
        // 2. Those that are large, each with regions evenly out of its list.
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); outlines.len()];
        for index in 0..outlines.len() as u32 {
            members[root(&mut parents, index) as usize].push(index);
        }
        let mut shells = Self { of_region: vec![None; outlines.len()], ..Self::default() };
        for members in members.into_iter().filter(|members| members.len() > FEW) {
            let shell = shells.samples.len() as u32;
            members.iter().for_each(|&region| shells.of_region[region as usize] = Some(shell));
            let sample = |k: usize| members[(2 * k + 1) * members.len() / (2 * SAMPLES)];
            shells.samples.push((0..SAMPLES).map(sample).collect());
        }
        shells
    }
}

/// For each region, those whose edges run along edges of it in the opposite direction, so that both fronts lie on one
/// side: one per edge of it, and those of edges without any left out.
pub(super) fn neighbours(outlines: &[Outline], size: f64) -> Vec<Vec<u32>> {
    let mut welder = Welder::new(size * 1e-7);
    let mut open: HashMap<(u32, u32), u32> = HashMap::new();
    let mut found = vec![Vec::new(); outlines.len()];
    for (index, outline) in (0_u32..).zip(outlines) {
        for edge in &outline.edges {
            let [a, b] = edge.map(|end| welder.index(outline.world(end)));
            if let Some(&other) = open.get(&(b, a)) {
                found[index as usize].push(other);
                found[other as usize].push(index);
            }
            open.insert((a, b), index);
        }
    }
    found
}

/// For each region whether light reaches neither its front nor its back, as [`neighbours`] that hang together have it:
/// where it reaches some of these, it may reach the others as well, however few paths came upon them.
pub(super) fn dark_as_wholes(outlines: &[Outline], size: f64, reached: &[[Reach; 2]]) -> Vec<[bool; 2]> {
    let mut parents: Vec<u32> = (0..outlines.len() as u32).collect();
    for (index, others) in (0_u32..).zip(neighbours(outlines, size)) {
        for other in others {
            let (one, other) = (root(&mut parents, index), root(&mut parents, other));
            parents[one.max(other) as usize] = one.min(other);
        }
    }
    let mut dark = vec![[true; 2]; outlines.len()];
    let roots: Vec<u32> = (0..outlines.len() as u32).map(|index| root(&mut parents, index)).collect();
    for (&root, reached) in roots.iter().zip(reached) {
        for (dark, reach) in dark[root as usize].iter_mut().zip(reached) {
            *dark &= matches!(reach, Reach::Dark | Reach::Backed);
        }
    }
    let is_dark = |(&root, reached): (&u32, &[Reach; 2])| {
        [0, 1].map(|side| dark[root as usize][side] && reached[side] == Reach::Dark)
    };
    roots.iter().zip(reached).map(is_dark).collect()
}

fn root(parents: &mut [u32], mut node: u32) -> u32 {
    while parents[node as usize] != node {
        parents[node as usize] = parents[parents[node as usize] as usize];
        node = parents[node as usize];
    }
    node
}
