//! The corners of elements as corners to draw.

use super::mesh::{DisplayCorner, Source};
use crate::direct::{Elements, NO_ELEMENT};
use crate::mesh::{PatchMesh, Side};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Irradiance in two parts, W/m² per band.
#[derive(Clone, Copy, Debug)]
pub struct Detail<'a> {
    /// From the lamps by itself, a value per corner of the elements.
    pub direct: &'a [[f32; 3]],
    /// What surfaces pass on, a value per patch.
    pub interreflected: &'a [[f32; 3]],
    /// Reflectance of each patch per band.
    pub reflectance: &'a [[f32; 3]],
}

/// One corner to draw for each corner of elements, patch there and place in its image: neighbours of one patch may lie in
/// different parts of that.
#[derive(Default)]
pub(super) struct ElementCorners {
    pub(super) corners: Vec<DisplayCorner>,
    pub(super) sources: Vec<Source>,
    /// The corners of each undivided element.
    pub(super) faces: Vec<[u32; 3]>,
    /// Which one each corner of a piece is, on each side: `2 * corner + side`.
    pub(super) places: Vec<u32>,
}

/// The triangle of a piece that elements are parts of.
struct Root {
    patch: u32,
    vertices: [u32; 3],
    uvs: [DVec2; 3],
}

/// Texture coordinates as far as they tell corners apart.
fn rounded(uv: DVec2) -> [i64; 2] {
    const STEPS: f64 = 1e6;
    uv.to_array().map(|value| (STEPS * value).round() as i64)
}

impl ElementCorners {
    pub(super) fn new(
        mesh: &PatchMesh,
        elements: &Elements,
        vertex_of_corner: &[u32],
        origin: DVec3,
    ) -> Self {
        let mut all = Self {
            faces: vec![[0; 3]; elements.elements.len()],
            places: vec![0; 2 * mesh.corners.len()],
            ..Self::default()
        };
        let mut known: HashMap<(u32, u32, [i64; 2]), u32> = HashMap::new();
        let mut triangle = 0;
        for piece in &mesh.pieces {
            let first = piece.corners.start as usize;
            for k in 1..piece.corners.len() - 1 {
                for side in [Side::Front, Side::Back] {
                    let index = elements.roots[2 * triangle + side as usize];
                    if index == NO_ELEMENT {
                        continue;
                    }
                    let own = [first, first + k, first + k + 1];
                    let root = Root {
                        patch: piece.patches[side as usize],
                        vertices: own.map(|c| vertex_of_corner[2 * c + side as usize]),
                        uvs: own.map(|c| mesh.corners[c].uv),
                    };
                    elements.each_leaf(2 * triangle + side as usize, |leaf, weights| {
                        for (k, weights) in weights.into_iter().enumerate() {
                            let corner = elements.elements[leaf as usize].corners[k];
                            let next = all.corners.len() as u32;
                            let uv: DVec2 = root.uvs.iter().zip(weights).map(|(&uv, w)| uv * w).sum();
                            let place = *known.entry((root.patch, corner, rounded(uv))).or_insert(next);
                            all.faces[leaf as usize][k] = place;
                            if place == next {
                                all.add(&root, elements, (corner, uv), weights, origin);
                            }
                        }
                    });
                    for (c, corner) in own.into_iter().zip(elements.elements[index as usize].corners) {
                        all.places[2 * c + side as usize] = known
                            .get(&(root.patch, corner, rounded(mesh.corners[c].uv)))
                            .copied()
                            .unwrap_or(0);
                    }
                }
                triangle += 1;
            }
        }
        all
    }

    fn add(
        &mut self,
        root: &Root,
        elements: &Elements,
        (corner, uv): (u32, DVec2),
        weights: [f64; 3],
        origin: DVec3,
    ) {
        let from = &elements.corners[corner as usize];
        self.corners.push(DisplayCorner {
            position: (from.position - origin).as_vec3(),
            normal: from.normal.as_vec3(),
            uv: uv.as_vec2(),
            patch: root.patch,
        });
        // Whole values stay whole, wherever the vertex stands among the root's.
        let mut vertices = root.vertices;
        let mut weights = weights.map(|w| w as f32);
        if let Some(whole) = weights.iter().position(|&w| w == 1.0) {
            vertices.swap(0, whole);
            weights.swap(0, whole);
        }
        self.sources.push(Source { patch: root.patch, vertices, weights, element: corner });
    }
}
