use super::vertices::{ShadingVertices, region_normal};
use super::weights::{PARALLEL_FROM, VertexWeights};
use crate::mesh::{NO_PATCH, PatchMesh, Side};
use crate::scene::Scene;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// How patch values spread over the surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shading {
    /// One value a patch: what the solver sees.
    Flat,
    /// Interpolated between vertices (Gouraud 1971).
    #[default]
    Gouraud,
}

/// A corner of a drawn triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayCorner {
    /// Metres, relative to [`DisplayMesh::origin`].
    pub position: Vec3,
    /// Unit normal of the side that it is drawn on.
    pub normal: Vec3,
    /// Texture coordinates, v upwards.
    pub uv: Vec2,
    /// The patch; [`NO_PATCH`] on a side that takes no part.
    pub patch: u32,
    /// Index of the value that [`DisplayMesh::vertex_radiosity`] gives; 0 on a side without a patch.
    pub vertex: u32,
}

/// A range of lit triangles that share a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Index into the scene's textures.
    pub texture: Option<u32>,
    /// Part of [`DisplayMesh::indices`].
    pub indices: Range<u32>,
}

/// A patch whose texture is drawn in detail.
#[derive(Clone, Copy, Debug)]
struct TexturedPatch {
    patch: u32,
    /// Mean of the texture over the patch, per band.
    mean: [f32; 3],
    /// The material's factor, for bands in which the mean is black.
    factor: [f32; 3],
}

/// The patches as triangles to draw, with the weights that make vertex radiosities. Immutable.
///
/// Corner values are what the light becomes: one value for each of the first
/// [`DisplayMesh::lit_corners`] corners.
#[derive(Clone, Debug, Default)]
pub struct DisplayMesh {
    /// Where the corners' positions count from, metres: far coordinates keep their digits.
    pub origin: DVec3,
    /// Diagonal of the box around the part that is looked at, metres.
    pub size: f64,
    /// Corners of the lit sides first, then those of sides without a patch.
    pub corners: Vec<DisplayCorner>,
    /// How many corners are lit.
    pub lit_corners: usize,
    /// Corner indices, three a triangle, counter-clockwise as seen from the drawn side.
    pub indices: Vec<u32>,
    /// The lit triangles, without a texture first.
    pub batches: Vec<Batch>,
    /// The triangles of sides without a patch in `indices`.
    pub unlit: Range<u32>,
    /// Patch borders as pairs of lit corners, each border once a side.
    pub edges: Vec<[u32; 2]>,
    /// `faces[2 * t + side]` are the corners of triangle t of [`PatchMesh::triangles`], in its order.
    faces: Vec<[u32; 3]>,
    /// Texture drawn on each patch; `None` where it is drawn plain.
    patch_textures: Vec<Option<u32>>,
    weights: VertexWeights,
    /// Patch and vertex of each lit corner, close together in memory.
    sources: Vec<[u32; 2]>,
    textured: Vec<TexturedPatch>,
    patches: usize,
}

impl DisplayMesh {
    /// Prepares a mesh for drawing. Takes some milliseconds per ten thousand patches: on a new
    /// mesh, not in a frame.
    ///
    /// With `smooth`, vertices of neighbouring regions of one object and material are joined where
    /// the normals that the model gives agree; otherwise every region is shaded on its own.
    pub fn build(mesh: &PatchMesh, scene: &Scene, smooth: bool) -> Self {
        let bounds = scene.extent().main;
        let mut built = Self {
            origin: bounds.centre(),
            size: bounds.diagonal(),
            patches: mesh.patches.len(),
            ..Self::default()
        };
        built.find_textures(mesh, scene);
        let ShadingVertices { vertices, incidences, of_corner } = ShadingVertices::find(mesh, smooth);
        let centres: Vec<DVec3> = mesh.patches.iter().map(|p| p.centre).collect();
        built.weights = VertexWeights::build(&vertices, incidences, &centres);
        let blocks = built.add_corners(mesh, smooth, &of_corner);
        built.add_triangles(mesh, &blocks);
        built.add_edges(mesh, &blocks);
        let lit = &built.corners[..built.lit_corners];
        built.sources = lit.iter().map(|corner| [corner.patch, corner.vertex]).collect();
        built
    }

    /// Decides which patches show their texture: those that were sampled from one and do not shine.
    fn find_textures(&mut self, mesh: &PatchMesh, scene: &Scene) {
        self.patch_textures = vec![None; mesh.patches.len()];
        for (index, patch) in mesh.patches.iter().enumerate() {
            let Some(material) = scene.materials.get(patch.material as usize) else { continue };
            let surface = scene.surfaces.get(patch.surface as usize);
            let has_uvs = surface.is_some_and(|s| s.corners.iter().all(|c| c.uv.is_some()));
            let shines = patch.luminaire.is_some() && patch.emission_weight.iter().any(|&e| e > 0.0);
            let known = material.texture.filter(|&t| (t as usize) < scene.textures.len());
            // An average of one is that of a white spot, or of a mesh made without textures.
            let drawn = known.filter(|_| has_uvs && !shines && patch.texture_average != [1.0; 3]);
            let Some(texture) = drawn else { continue };
            self.patch_textures[index] = Some(texture);
            self.textured.push(TexturedPatch {
                patch: index as u32,
                mean: patch.texture_average.map(|x| x as f32),
                factor: material.reflectance.map(|x| x as f32),
            });
        }
    }

    /// Makes the corners, lit ones first. Returns where those of each piece start: `2 * piece + side`.
    fn add_corners(&mut self, mesh: &PatchMesh, smooth: bool, vertex_of_corner: &[u32]) -> Vec<u32> {
        let mut blocks = vec![0_u32; 2 * mesh.pieces.len()];
        for lit in [true, false] {
            for (index, piece) in mesh.pieces.iter().enumerate() {
                for side in [Side::Front, Side::Back] {
                    let patch = piece.patches[side as usize];
                    if (patch != NO_PATCH) != lit {
                        continue;
                    }
                    blocks[2 * index + side as usize] = self.corners.len() as u32;
                    for corner in piece.corners.start as usize..piece.corners.end as usize {
                        let from = &mesh.corners[corner];
                        let normal = if smooth { from.normal } else { region_normal(mesh, piece) };
                        self.corners.push(DisplayCorner {
                            position: (mesh.vertices[from.vertex as usize] - self.origin).as_vec3(),
                            normal: (normal * side.sign()).as_vec3(),
                            uv: from.uv.as_vec2(),
                            patch,
                            vertex: vertex_of_corner[2 * corner + side as usize],
                        });
                    }
                }
            }
            if lit {
                self.lit_corners = self.corners.len();
            }
        }
        blocks
    }

    fn add_triangles(&mut self, mesh: &PatchMesh, blocks: &[u32]) {
        let (mut by_texture, mut unlit) = (HashMap::<Option<u32>, Vec<u32>>::new(), Vec::new());
        for (index, piece) in mesh.pieces.iter().enumerate() {
            for k in 1..piece.corners.len() as u32 - 1 {
                for side in [Side::Front, Side::Back] {
                    let start = blocks[2 * index + side as usize];
                    let face = [start, start + k, start + k + 1];
                    self.faces.push(face);
                    let drawn = if side == Side::Front { face } else { [face[0], face[2], face[1]] };
                    if side == Side::Back && piece.backed {
                        continue;
                    }
                    let list = match piece.patches[side as usize] {
                        NO_PATCH => &mut unlit,
                        patch => by_texture.entry(self.patch_textures[patch as usize]).or_default(),
                    };
                    list.extend(drawn);
                }
            }
        }
        let mut batches: Vec<_> = by_texture.into_iter().collect();
        batches.sort_by_key(|batch| batch.0);
        for (texture, mut list) in batches {
            let start = self.indices.len() as u32;
            self.indices.append(&mut list);
            self.batches.push(Batch { texture, indices: start..self.indices.len() as u32 });
        }
        let start = self.indices.len() as u32;
        self.indices.append(&mut unlit);
        self.unlit = start..self.indices.len() as u32;
    }

    fn add_edges(&mut self, mesh: &PatchMesh, blocks: &[u32]) {
        // Both vertices and the side, then the patch, then the corners that draw it.
        let mut edges: Vec<([u32; 4], u32, [u32; 2])> = Vec::new();
        for (index, piece) in mesh.pieces.iter().enumerate() {
            let corners = mesh.corners_of(piece);
            for side in [Side::Front, Side::Back] {
                let patch = piece.patches[side as usize];
                if patch == NO_PATCH {
                    continue;
                }
                let start = blocks[2 * index + side as usize];
                for k in 0..corners.len() {
                    let next = (k + 1) % corners.len();
                    let (a, b) = (corners[k].vertex, corners[next].vertex);
                    let key = [a.min(b), a.max(b), piece.region, side as u32];
                    edges.push((key, patch, [start + k as u32, start + next as u32]));
                }
            }
        }
        edges.par_sort_unstable();
        self.edges = edges
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|same| same.len() == 1 || same.iter().any(|edge| edge.1 != same[0].1))
            .map(|same| same[0].2)
            .collect();
    }

    /// How many patches the values must be for.
    pub fn patch_count(&self) -> usize {
        self.patches
    }

    /// How many values [`DisplayMesh::vertex_radiosity`] gives.
    pub fn vertex_count(&self) -> usize {
        self.weights.len()
    }

    /// Corners of triangle `triangle` of [`PatchMesh::triangles`] on `side`, in that triangle's
    /// order, and the texture that is drawn there.
    ///
    /// Panics if there is no such triangle.
    pub fn face(&self, triangle: u32, side: Side) -> ([u32; 3], Option<u32>) {
        let corners = self.faces[2 * triangle as usize + side as usize];
        let patch = self.corners[corners[0] as usize].patch;
        (corners, self.patch_textures.get(patch as usize).copied().flatten())
    }

    /// Patch values interpolated to the shading vertices: the mean of the patches around, linear
    /// extrapolation at borders, never across a crease. Never NaN; non-negative for such input.
    pub fn vertex_radiosity(&self, patch_values: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.weights.gather(patch_values)
    }

    /// What is drawn at the lit corners for this light, W/m² per band: radiosity on plain
    /// patches; on textured ones what a texel is multiplied with to give its radiosity.
    ///
    /// Both slices have one value a patch, in W/m² per band; missing ones count as dark.
    pub fn corner_radiosity(
        &self,
        radiosity: &[[f32; 3]],
        irradiance: &[[f32; 3]],
        shading: Shading,
    ) -> Vec<[f32; 3]> {
        if self.textured.is_empty() {
            return self.corner_values(radiosity, shading);
        }
        let mut values = radiosity.to_vec();
        values.resize(self.patches, [0.0; 3]);
        for textured in &self.textured {
            let value = &mut values[textured.patch as usize];
            let arriving = irradiance.get(textured.patch as usize).copied().unwrap_or_default();
            // Through B rather than H where it can be, so that an edited factor counts.
            *value = std::array::from_fn(|b| match textured.mean[b] {
                mean if mean > 1e-3 => value[b] / mean,
                _ => textured.factor[b] * arriving[b],
            });
        }
        self.corner_values(&values, shading)
    }

    /// Values per patch spread to the lit corners: three bands.
    pub fn corner_values(&self, patch_values: &[[f32; 3]], shading: Shading) -> Vec<[f32; 3]> {
        self.spread(patch_values, shading)
    }

    /// Values per patch spread to the lit corners: one number, for false colours. May be negative.
    pub fn corner_scalars(&self, patch_values: &[f32], shading: Shading) -> Vec<f32> {
        let values: &[[f32; 1]] = bytemuck::cast_slice(patch_values);
        bytemuck::cast_vec(self.spread(values, shading))
    }

    fn spread<const N: usize>(&self, patch_values: &[[f32; N]], shading: Shading) -> Vec<[f32; N]> {
        let vertex_values = match shading {
            Shading::Flat => Vec::new(),
            Shading::Gouraud => self.weights.gather(patch_values),
        };
        let one = |&[patch, vertex]: &[u32; 2]| match shading {
            Shading::Flat => {
                let value = patch_values.get(patch as usize).copied().unwrap_or([0.0; N]);
                value.map(|x| if x.is_finite() { x } else { 0.0 })
            }
            Shading::Gouraud => vertex_values[vertex as usize],
        };
        let lit = &self.sources;
        if lit.len() > 8 * PARALLEL_FROM {
            lit.par_iter().with_min_len(4096).map(one).collect()
        } else {
            lit.iter().map(one).collect()
        }
    }
}
