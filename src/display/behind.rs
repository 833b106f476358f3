//! What lies on the far sides of the lit corners of translucent surfaces.

use super::mesh::{Behind, DisplayMesh};
use crate::mesh::{NO_PATCH, PatchMesh, Side};

/// The place on the other side of its piece for each lit corner of a translucent patch that has one, in rising order.
/// `places` tells which corner to draw each corner of a piece is, on each side: `2 * corner + side`.
pub(super) fn find(mesh: &PatchMesh, drawn: &DisplayMesh, places: &[u32]) -> Vec<Behind> {
    let mut found = Vec::new();
    let mut triangle = 0;
    for piece in &mesh.pieces {
        let first = piece.corners.start as usize;
        let is_translucent = |patch: u32| patch != NO_PATCH && mesh.translucence.at(patch as usize).is_some();
        for k in 1..piece.corners.len() - 1 {
            let at = 2 * triangle;
            triangle += 1;
            if !piece.patches.into_iter().all(is_translucent) {
                continue;
            }
            for side in [Side::Front, Side::Back] {
                let (own, far) = (at + side as usize, at + 1 - side as usize);
                match drawn.elements() {
                    None => {
                        for corner in [first, first + k, first + k + 1] {
                            let [corner, far] =
                                [side as usize, 1 - side as usize].map(|side| places[2 * corner + side]);
                            found.push(Behind { corner, corners: [far; 3], weights: [1.0, 0.0, 0.0] });
                        }
                    }
                    Some(elements) => elements.each_leaf(own, |leaf, corners| {
                        for (weights, corner) in corners.into_iter().zip(drawn.faces()[leaf as usize]) {
                            let Some((leaf, weights)) = elements.place(far, weights) else { continue };
                            found.push(Behind {
                                corner,
                                corners: drawn.faces()[leaf as usize],
                                weights: weights.map(|weight| weight as f32),
                            });
                        }
                    }),
                }
            }
        }
    }
    found.sort_by_key(|behind| behind.corner);
    found.dedup_by_key(|behind| behind.corner);
    found
}
