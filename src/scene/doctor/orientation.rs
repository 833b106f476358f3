//! Which faces are turned against their neighbours.

use super::topology::{HalfEdge, bundles};

/// Faces joined over the edges that two of them share, each with whether it faces as its root does.
struct Shells {
    parent: Vec<u32>,
    turned: Vec<bool>,
}

impl Shells {
    fn root(&mut self, face: u32) -> (u32, bool) {
        let (mut root, mut turned) = (face, false);
        while self.parent[root as usize] != root {
            turned ^= self.turned[root as usize];
            root = self.parent[root as usize];
        }
        // Every face on the way now hangs from the root itself.
        let (mut at, mut left) = (face, turned);
        while at != root {
            let (next, own) = (self.parent[at as usize], self.turned[at as usize]);
            (self.parent[at as usize], self.turned[at as usize]) = (root, left);
            (at, left) = (next, left ^ own);
        }
        (root, turned)
    }

    /// Joins two faces, of which one must be turned to face as the other does, or not. Returns whether
    /// that can be.
    fn join(&mut self, a: u32, b: u32, opposed: bool) -> bool {
        let ((a, a_turned), (b, b_turned)) = (self.root(a), self.root(b));
        if a == b {
            return a_turned ^ b_turned == opposed;
        }
        self.parent[b as usize] = a;
        self.turned[b as usize] = a_turned ^ b_turned ^ opposed;
        true
    }
}

/// Who faces which way.
pub(in crate::scene) struct Orientation {
    /// For each face whether turning it makes its shell face one way. The part of a shell that weighs
    /// most stays; one that cannot face one way, such as a Möbius strip, stays as a whole.
    pub(in crate::scene) turn: Vec<bool>,
    /// For each face the number of the shell that it is a part of: its lowest face.
    pub(in crate::scene) shell: Vec<u32>,
    /// Whether the shell of each face cannot face one way.
    pub(in crate::scene) twisted: Vec<bool>,
}

/// Finds the faces to turn. `edges` are sorted (see [`super::topology::sort`]); those between exactly
/// two faces bind these. `weights` say how much each face counts, one a face; infinite for one that is
/// never to be turned, even against its neighbours.
pub(in crate::scene) fn orient(edges: &[HalfEdge], weights: &[f64]) -> Orientation {
    let count = weights.len();
    let mut shells = Shells { parent: (0..count as u32).collect(), turned: vec![false; count] };
    let mut torn = Vec::new();
    for bundle in bundles(edges) {
        if let [a, b] = bundle
            && !shells.join(a.face, b.face, a.from == b.from)
        {
            torn.push(a.face);
        }
    }
    let mut sums = vec![[0.0_f64; 2]; count];
    let mut fixed = vec![[0_u32; 2]; count];
    let placed: Vec<(u32, bool)> = (0..count as u32).map(|face| shells.root(face)).collect();
    let mut is_twisted = vec![false; count];
    torn.iter().for_each(|&face| is_twisted[placed[face as usize].0 as usize] = true);
    let twisted: Vec<bool> = placed.iter().map(|&(root, _)| is_twisted[root as usize]).collect();
    for (&(root, turned), &weight) in placed.iter().zip(weights) {
        match weight.is_finite() {
            true => sums[root as usize][usize::from(turned)] += weight,
            false => fixed[root as usize][usize::from(turned)] += 1,
        }
    }
    let turn = placed.iter().zip(weights).map(|(&(root, turned), weight)| {
        let (sums, fixed) = (sums[root as usize], fixed[root as usize]);
        let kept = if fixed[0] == fixed[1] { sums[1] > sums[0] } else { fixed[1] > fixed[0] };
        weight.is_finite() && turned != kept && !is_twisted[root as usize]
    });
    let turn = turn.collect();
    let mut lowest = vec![u32::MAX; count];
    let shell = placed
        .iter()
        .enumerate()
        .map(|(face, &(root, _))| {
            let slot = &mut lowest[root as usize];
            *slot = (*slot).min(face as u32);
            *slot
        })
        .collect();
    Orientation { turn, shell, twisted }
}

#[cfg(test)]
mod tests {
    use super::super::topology::half_edges;
    use super::*;

    /// A cube whose faces all look out.
    const CUBE: [[u32; 4]; 6] =
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

    fn cube(turned: &[usize]) -> Vec<Vec<u32>> {
        let face = |(k, corners): (usize, &[u32; 4])| {
            let mut corners = corners.to_vec();
            if turned.contains(&k) {
                corners.reverse();
            }
            corners
        };
        CUBE.iter().enumerate().map(face).collect()
    }

    #[test]
    fn the_minority_is_turned_whichever_way_the_rest_faces() {
        for turned in [&[][..], &[2], &[0, 5], &[0, 1, 2, 4]] {
            let found = orient(&half_edges(&cube(turned)), &[1.0; 6]).turn;
            let minority: Vec<bool> =
                (0..6).map(|k| turned.contains(&k) == (turned.len() <= 3) && !turned.is_empty()).collect();
            assert_eq!(found, minority, "{turned:?}");
        }
        let all = orient(&half_edges(&cube(&[0, 1, 2, 3, 4, 5])), &[1.0; 6]).turn;
        assert_eq!(all, [false; 6], "a room seen from inside is as good as a box");
    }

    #[test]
    fn a_moebius_strip_is_left_alone() {
        let strip = |twist: bool| -> Vec<Vec<u32>> {
            (0..5_u32)
                .map(|k| {
                    let (a, b) = (2 * k, 2 * k + 1);
                    let (c, d) = if k < 4 {
                        (2 * k + 2, 2 * k + 3)
                    } else if twist {
                        (1, 0)
                    } else {
                        (0, 1)
                    };
                    vec![a, c, d, b]
                })
                .collect()
        };
        let found = orient(&half_edges(&strip(true)), &[1.0; 5]);
        assert_eq!((found.twisted, found.turn), (vec![true; 5], vec![false; 5]));
        assert_eq!(orient(&half_edges(&strip(false)), &[1.0; 5]).twisted, [false; 5]);
    }

    #[test]
    fn what_must_not_be_turned_decides_against_any_weight() {
        let weights = [f64::INFINITY, 1e9, 1e9, 1e9, 1e9, 1e9];
        assert_eq!(orient(&half_edges(&cube(&[0])), &weights).turn, [false, true, true, true, true, true]);
        let weights = [f64::INFINITY, f64::INFINITY, 1.0, 1.0, 1.0, 1.0];
        let found = orient(&half_edges(&cube(&[0])), &weights).turn;
        assert_eq!(found[..2], [false, false], "two lamps that disagree stay as they are");
        assert!(found[2..].iter().all(|&t| t == found[2]), "and the rest agrees: {found:?}");
    }
}
