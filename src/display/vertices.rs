use super::weights::ShadingVertex;
use crate::mesh::{self, NO_PATCH, PatchMesh, Piece, Side};
use glam::DVec3;
use std::collections::HashMap;

/// Smooth normals within this cosine (1.8 degrees) belong to one smooth surface.
const SAME_NORMAL: f64 = 0.9995;

/// Mesh vertices told apart by the smooth surface that they belong to.
#[derive(Default)]
pub(super) struct ShadingVertices {
    pub(super) vertices: Vec<ShadingVertex>,
    /// Pairs of a vertex and a patch that touches it.
    pub(super) incidences: Vec<(u32, u32)>,
    /// The vertex of each corner of the patch mesh and side, at `2 * corner + side`; zero where
    /// that side has no patch.
    pub(super) of_corner: Vec<u32>,
}

impl ShadingVertices {
    /// One vertex for each mesh vertex, side and stretch between contact lines; with `smooth`,
    /// joined across regions where the normals of the model agree.
    pub(super) fn find(mesh: &PatchMesh, smooth: bool) -> Self {
        let stretches = mesh::stretches(mesh);
        let mut known: HashMap<[u32; 3], u32> = HashMap::new();
        let mut found = Self { of_corner: vec![0; 2 * mesh.corners.len()], ..Self::default() };
        let mut kinds: Vec<Option<[u32; 3]>> = Vec::new();
        for piece in &mesh.pieces {
            for side in [Side::Front, Side::Back] {
                let patch = piece.patches[side as usize];
                if patch == NO_PATCH {
                    continue;
                }
                for k in 0..piece.corners.len() {
                    let corner = piece.corners.start as usize + k;
                    let stretch = stretches.get(corner).copied().unwrap_or(0);
                    let from = &mesh.corners[corner];
                    let key = [from.vertex, piece.region, 2 * stretch + side as u32];
                    let vertex = *known.entry(key).or_insert_with(|| {
                        let region = &mesh.regions[piece.region as usize];
                        let normal = if smooth { from.normal } else { region.frame.normal };
                        found.vertices.push(ShadingVertex {
                            position: mesh.vertices[from.vertex as usize],
                            normal: normal * side.sign(),
                            angle: 0.0,
                        });
                        let luminaire = mesh.patches[patch as usize].luminaire.map_or(0, |l| l + 1);
                        kinds.push((stretch == 0).then_some([region.object, region.material, luminaire]));
                        found.vertices.len() as u32 - 1
                    });
                    found.vertices[vertex as usize].angle += corner_angle(mesh, piece, k);
                    found.of_corner[2 * corner + side as usize] = vertex;
                    found.incidences.push((vertex, patch));
                }
            }
        }
        found.leave_out_buried(mesh);
        let is_curved = |piece: &Piece| {
            let flat = region_normal(mesh, piece);
            mesh.corners_of(piece).iter().any(|c| c.normal.dot(flat) < 1.0 - 1e-9)
        };
        if smooth && mesh.pieces.iter().any(is_curved) {
            found.join(&kinds, mesh.size);
        }
        found
    }

    /// A patch under something that stands on it tells nothing of the light around it.
    fn leave_out_buried(&mut self, mesh: &PatchMesh) {
        let is_buried = |patch: u32| mesh.patches[patch as usize].buried;
        let mut in_the_open = vec![false; self.vertices.len()];
        for &(vertex, patch) in &self.incidences {
            in_the_open[vertex as usize] |= !is_buried(patch);
        }
        self.incidences.retain(|&(vertex, patch)| !(in_the_open[vertex as usize] && is_buried(patch)));
    }

    /// Joins vertices of one kind that share position and normal; those without a kind stay alone.
    fn join(&mut self, kinds: &[Option<[u32; 3]>], size: f64) {
        // Not a multiple of anything that coordinates tend to be multiples of.
        let cell = (size * 1.378_1e-6).max(1e-12);
        let mut at_place: HashMap<([i64; 3], [u32; 3]), Vec<u32>> = HashMap::new();
        let mut kept: Vec<ShadingVertex> = Vec::new();
        let mut joined = Vec::with_capacity(self.vertices.len());
        for (vertex, kind) in self.vertices.drain(..).zip(kinds) {
            if let &Some(kind) = kind {
                let place = (vertex.position / cell + 0.373_71).floor().as_i64vec3().to_array();
                let here = at_place.entry((place, kind)).or_default();
                let is_same = |v: &u32| kept[*v as usize].normal.dot(vertex.normal) > SAME_NORMAL;
                if let Some(index) = here.iter().copied().find(is_same) {
                    kept[index as usize].angle += vertex.angle;
                    joined.push(index);
                    continue;
                }
                here.push(kept.len() as u32);
            }
            joined.push(kept.len() as u32);
            kept.push(vertex);
        }
        self.vertices = kept;
        self.incidences.iter_mut().for_each(|pair| pair.0 = joined[pair.0 as usize]);
        for vertex in &mut self.of_corner {
            *vertex = joined.get(*vertex as usize).copied().unwrap_or(0);
        }
    }
}

/// The front normal of the region of a piece.
pub(super) fn region_normal(mesh: &PatchMesh, piece: &Piece) -> DVec3 {
    mesh.regions[piece.region as usize].frame.normal
}

/// The angle at corner `k` of a piece, radians; zero where an edge has no length.
fn corner_angle(mesh: &PatchMesh, piece: &Piece, k: usize) -> f64 {
    let corners = mesh.corners_of(piece);
    let at = |i: usize| corners[i % corners.len()].plane;
    let (back, ahead) = (at(k + corners.len() - 1) - at(k), at(k + 1) - at(k));
    let angle = ahead.angle_to(back).abs();
    if angle.is_finite() { angle } else { 0.0 }
}
