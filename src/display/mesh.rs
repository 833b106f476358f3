use super::behind;
use super::detail::{Detail, ElementCorners};
use super::vertices::{ShadingVertices, region_normal};
use super::weights::{PARALLEL_FROM, VertexWeights};
use crate::direct::Elements;
use crate::mesh::{NO_PATCH, PatchMesh, Side, Translucence};
use crate::scene::Scene;
use glam::{DVec3, Vec2, Vec3};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

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
}

/// Where the light of a lit corner comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Source {
    pub(super) patch: u32,
    /// Values that [`DisplayMesh::vertex_radiosity`] gives, and how much each counts.
    pub(super) vertices: [u32; 3],
    pub(super) weights: [f32; 3],
    /// The corner of the elements that it is; zero without elements.
    pub(super) element: u32,
}

/// A corner of a pane of glass, which is drawn over what lies behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaneCorner {
    /// Metres, relative to [`DisplayMesh::origin`].
    pub position: Vec3,
    /// Unit normal of its front.
    pub normal: Vec3,
    /// What passes along the normal, a band each.
    pub tint: [f32; 3],
    /// Whether it is drawn as seen from its front (bit 0) and from its back (bit 1): glass with a thickness once.
    pub sides: u32,
}

/// A range of lit triangles that share a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Index into the scene's textures.
    pub texture: Option<u32>,
    /// Whether nothing is drawn where the texture is transparent.
    pub has_holes: bool,
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
    /// Triangles of the panes of glass, three corners each.
    pub panes: Vec<PaneCorner>,
    /// Patch borders as pairs of lit corners, each border once a side.
    pub edges: Vec<[u32; 2]>,
    /// The corners of triangles, in their order: without elements of triangle t of [`PatchMesh::triangles`] at
    /// `2 * t + side`, else of each element.
    faces: Vec<[u32; 3]>,
    elements: Option<Arc<Elements>>,
    /// Texture drawn on each patch; `None` where it is drawn plain.
    patch_textures: Vec<Option<u32>>,
    weights: VertexWeights,
    /// One per lit corner.
    sources: Vec<Source>,
    textured: Vec<TexturedPatch>,
    /// Patches with holes, in rising order, and the texture that tells where.
    perforated: Vec<(u32, u32)>,
    /// What patches pass from their far sides.
    translucence: Arc<Translucence>,
    /// Lit corners of translucent surfaces, in rising order, and the places on the far side that lie behind them.
    behind: Vec<Behind>,
    patches: usize,
}

/// What lies on the far side of a lit corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Behind {
    pub(super) corner: u32,
    /// Lit corners there, and how much each counts.
    pub(super) corners: [u32; 3],
    pub(super) weights: [f32; 3],
}

impl DisplayMesh {
    /// Prepares a mesh for drawing. Takes some milliseconds per ten thousand patches: on a new
    /// mesh, not in a frame.
    ///
    /// With `smooth`, vertices of neighbouring regions of one object and material are joined where
    /// the normals that the model gives agree; otherwise every region is shaded on its own.
    pub fn build(mesh: &PatchMesh, scene: &Scene, smooth: bool) -> Self {
        Self::build_on(mesh, scene, smooth, None)
    }

    /// As [`Self::build`], with the elements of the mesh as triangles, where there are some.
    pub fn build_on(mesh: &PatchMesh, scene: &Scene, smooth: bool, elements: Option<&Arc<Elements>>) -> Self {
        let bounds = scene.extent().main;
        let mut built = Self {
            origin: bounds.centre(),
            size: bounds.diagonal(),
            patches: mesh.patches.len(),
            translucence: Arc::clone(&mesh.translucence),
            ..Self::default()
        };
        built.find_textures(mesh, scene);
        let ShadingVertices { vertices, incidences, of_corner } = ShadingVertices::find(mesh, smooth);
        built.weights = VertexWeights::build(&vertices, incidences, mesh);
        let places = match elements {
            Some(elements) => {
                built.elements = Some(Arc::clone(elements));
                built.add_elements(mesh, elements, &of_corner)
            }
            None => built.add_corners(mesh, smooth, &of_corner),
        };
        if !mesh.translucence.is_empty() {
            built.behind = behind::find(mesh, &built, &places);
        }
        built.add_triangles(mesh, &places);
        built.add_edges(mesh, &places);
        built.add_panes(mesh);
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
            let has_holes = mesh.regions[patch.region as usize].has_holes;
            let is_plain = patch.texture_average == [1.0; 3] && !has_holes;
            let drawn = known.filter(|_| has_uvs && !shines && !is_plain);
            if let Some(texture) = drawn.filter(|_| has_holes) {
                self.perforated.push((index as u32, texture));
            }
            let Some(texture) = drawn else { continue };
            self.patch_textures[index] = Some(texture);
            self.textured.push(TexturedPatch {
                patch: index as u32,
                mean: patch.texture_average.map(|x| x as f32),
                factor: material.reflectance.map(|x| x as f32),
            });
        }
    }

    /// Makes the corners, lit ones first. Returns which one each corner of a piece is, on each side: `2 * corner + side`.
    fn add_corners(&mut self, mesh: &PatchMesh, smooth: bool, vertex_of_corner: &[u32]) -> Vec<u32> {
        let mut places = vec![0_u32; 2 * mesh.corners.len()];
        self.add_sides(mesh, smooth, true, &mut places);
        self.lit_corners = self.corners.len();
        self.sources = vec![
            Source { patch: 0, vertices: [0; 3], weights: [1.0, 0.0, 0.0], element: 0 };
            self.lit_corners
        ];
        for piece in &mesh.pieces {
            for side in [Side::Front, Side::Back] {
                let patch = piece.patches[side as usize];
                for corner in piece.corners.clone().filter(|_| patch != NO_PATCH) {
                    let at = 2 * corner as usize + side as usize;
                    let source = &mut self.sources[places[at] as usize];
                    (source.patch, source.vertices) = (patch, [vertex_of_corner[at]; 3]);
                }
            }
        }
        self.add_sides(mesh, smooth, false, &mut places);
        places
    }

    /// Makes the corners of all sides that are lit, or of all that are not.
    fn add_sides(&mut self, mesh: &PatchMesh, smooth: bool, lit: bool, places: &mut [u32]) {
        for piece in &mesh.pieces {
            for side in [Side::Front, Side::Back] {
                let patch = piece.patches[side as usize];
                if (patch != NO_PATCH) != lit {
                    continue;
                }
                for corner in piece.corners.start as usize..piece.corners.end as usize {
                    let from = &mesh.corners[corner];
                    let normal = if smooth { from.normal } else { region_normal(mesh, piece) };
                    places[2 * corner + side as usize] = self.corners.len() as u32;
                    self.corners.push(DisplayCorner {
                        position: (mesh.vertices[from.vertex as usize] - self.origin).as_vec3(),
                        normal: (normal * side.sign()).as_vec3(),
                        uv: from.uv.as_vec2(),
                        patch,
                    });
                }
            }
        }
    }

    /// As [`Self::add_corners`], with those of elements on the lit sides.
    fn add_elements(&mut self, mesh: &PatchMesh, elements: &Elements, vertex_of_corner: &[u32]) -> Vec<u32> {
        let ElementCorners { corners, sources, faces, mut places } =
            ElementCorners::new(mesh, elements, vertex_of_corner, self.origin);
        (self.corners, self.sources, self.faces) = (corners, sources, faces);
        self.lit_corners = self.corners.len();
        self.add_sides(mesh, true, false, &mut places);
        places
    }

    fn add_panes(&mut self, mesh: &PatchMesh) {
        let (triangles, owners) = mesh.panes.triangles();
        for (triangle, owner) in triangles.iter().zip(owners) {
            let pane = &mesh.panes.list[owner as usize];
            if pane.perforated.is_some() {
                continue;
            }
            let tint = mesh.panes.kinds[pane.kind as usize].transmittance(1.0).map(|share| share as f32);
            let sides = u32::from(pane.dims[0]) | u32::from(pane.dims[1]) << 1;
            self.panes.extend(triangle.map(|corner| PaneCorner {
                position: (corner - self.origin).as_vec3(),
                normal: pane.normal.as_vec3(),
                tint,
                sides,
            }));
        }
    }

    fn add_triangles(&mut self, mesh: &PatchMesh, places: &[u32]) {
        let (mut by_texture, mut unlit) = (HashMap::<(Option<u32>, bool), Vec<u32>>::new(), Vec::new());
        let elements = self.elements.clone();
        let mut roots = elements.iter().flat_map(|elements| elements.roots.iter().copied());
        for piece in &mesh.pieces {
            let first = piece.corners.start as usize;
            let has_holes = mesh.regions[piece.region as usize].has_holes;
            for k in 1..piece.corners.len() - 1 {
                for side in [Side::Front, Side::Back] {
                    let patch = piece.patches[side as usize];
                    let root = roots.next();
                    let face = [first, first + k, first + k + 1].map(|c| places[2 * c + side as usize]);
                    let turned =
                        |[a, b, c]: [u32; 3]| if side == Side::Front { [a, b, c] } else { [a, c, b] };
                    if elements.is_none() {
                        self.faces.push(face);
                    }
                    if side == Side::Back && piece.backed {
                        continue;
                    }
                    let list = match patch {
                        // A side without a patch shows no holes, and is better not seen at all.
                        NO_PATCH if has_holes => continue,
                        NO_PATCH => &mut unlit,
                        patch => {
                            by_texture.entry((self.patch_textures[patch as usize], has_holes)).or_default()
                        }
                    };
                    match (&elements, root) {
                        (Some(elements), Some(root)) if patch != NO_PATCH => {
                            elements.leaves_of(root, |leaf| list.extend(turned(self.faces[leaf as usize])));
                        }
                        _ => list.extend(turned(face)),
                    }
                }
            }
        }
        let mut batches: Vec<_> = by_texture.into_iter().collect();
        batches.sort_by_key(|batch| batch.0);
        for ((texture, has_holes), mut list) in batches {
            let start = self.indices.len() as u32;
            self.indices.append(&mut list);
            self.batches.push(Batch { texture, has_holes, indices: start..self.indices.len() as u32 });
        }
        let start = self.indices.len() as u32;
        self.indices.append(&mut unlit);
        self.unlit = start..self.indices.len() as u32;
    }

    fn add_edges(&mut self, mesh: &PatchMesh, places: &[u32]) {
        // Both vertices and the side, then the patch, then the corners that draw it.
        let mut edges: Vec<([u32; 4], u32, [u32; 2])> = Vec::new();
        for piece in &mesh.pieces {
            let corners = mesh.corners_of(piece);
            for side in [Side::Front, Side::Back] {
                let patch = piece.patches[side as usize];
                if patch == NO_PATCH {
                    continue;
                }
                let place = |k: usize| places[2 * (piece.corners.start as usize + k) + side as usize];
                for k in 0..corners.len() {
                    let next = (k + 1) % corners.len();
                    let (a, b) = (corners[k].vertex, corners[next].vertex);
                    let key = [a.min(b), a.max(b), piece.region, side as u32];
                    edges.push((key, patch, [place(k), place(next)]));
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

    /// The texture that tells where a patch has holes, if it has any.
    pub fn holes_of(&self, patch: u32) -> Option<u32> {
        let at = self.perforated.binary_search_by_key(&patch, |entry| entry.0).ok()?;
        Some(self.perforated[at].1)
    }

    /// How many patches the values must be for.
    pub fn patch_count(&self) -> usize {
        self.patches
    }

    /// How many values [`DisplayMesh::vertex_radiosity`] gives.
    pub fn vertex_count(&self) -> usize {
        self.weights.len()
    }

    /// The corners between which colours are interpolated at a place of triangle `triangle` of
    /// [`PatchMesh::triangles`] on `side`, how much each counts there, and the texture that is drawn. `weights` are
    /// those of the triangle's corners.
    ///
    /// Panics if there is no such triangle.
    pub fn place(&self, triangle: u32, side: Side, weights: [f64; 3]) -> ([u32; 3], [f32; 3], Option<u32>) {
        let at = 2 * triangle as usize + side as usize;
        let (face, weights) = match &self.elements {
            None => (self.faces[at], weights),
            Some(elements) => match elements.place(at, weights) {
                Some((leaf, weights)) => (self.faces[leaf as usize], weights),
                None => return ([u32::MAX; 3], weights.map(|w| w as f32), None),
            },
        };
        let patch = self.corners[face[0] as usize].patch;
        (face, weights.map(|w| w as f32), self.patch_textures.get(patch as usize).copied().flatten())
    }

    /// The corners of all triangles, in their order: `2 * t + side` for triangle t of [`PatchMesh::triangles`], or, where
    /// it draws elements, one for each of them, of which the undivided ones count.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The elements that it draws.
    pub fn elements(&self) -> Option<&Arc<Elements>> {
        self.elements.as_ref()
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

    /// What is drawn at the lit corners for light in two parts; see [`Self::corner_radiosity`]. Where this draws no
    /// such elements, or `shading` is flat, that of the patches.
    pub fn detailed_radiosity(
        &self,
        radiosity: &[[f32; 3]],
        irradiance: &[[f32; 3]],
        detail: Option<Detail<'_>>,
        shading: Shading,
    ) -> Vec<[f32; 3]> {
        let Some(detail) = detail.filter(|detail| self.shows(detail, shading)) else {
            return self.corner_radiosity(radiosity, irradiance, shading);
        };
        // 1. What a corner emits, what its irradiance is multiplied with, and what passes from behind it.
        let band = |values: &[[f32; 3]], patch: usize, b: usize| values.get(patch).map_or(0.0, |v| v[b]);
        let mut factors: Vec<[[f32; 3]; 3]> = (0..self.patches)
            .map(|patch| {
                let rho = std::array::from_fn(|b| band(detail.reflectance, patch, b));
                let arriving = |j: usize| irradiance.get(j).copied().unwrap_or_default().map(f64::from);
                let sent = self.translucence.leaving(patch, rho.map(f64::from), arriving);
                let emitted = |b| (band(radiosity, patch, b) - sent[b] as f32).max(0.0);
                [std::array::from_fn(emitted), rho, [1.0; 3]]
            })
            .collect();
        for textured in &self.textured {
            let [emitted, rho, passed] = &mut factors[textured.patch as usize];
            *emitted = [0.0; 3];
            for (b, &mean) in textured.mean.iter().enumerate() {
                let is_drawn = mean > 1e-3;
                rho[b] = if is_drawn { rho[b] / mean } else { textured.factor[b] };
                passed[b] = if is_drawn { 1.0 / mean } else { 0.0 };
            }
        }
        // 2. Both parts of the light at each corner.
        let mut values = self.detailed_irradiance(irradiance, Some(detail), shading);
        let passed = self.passed(&values, irradiance);
        for (value, source) in values.iter_mut().zip(&self.sources) {
            let [emitted, rho, _] = &factors[source.patch as usize];
            *value = std::array::from_fn(|b| emitted[b] + rho[b] * value[b]);
        }
        for (corner, passed) in passed {
            let factor = factors[self.sources[corner as usize].patch as usize][2];
            let value = &mut values[corner as usize];
            (0..3).for_each(|b| value[b] += factor[b] * passed[b]);
        }
        values
    }

    /// What leaves each lit corner of a translucent surface of what arrives on its far side, by what arrives at all
    /// corners: that of the place behind it, or of the patch behind where there is no such place.
    fn passed(&self, arriving: &[[f32; 3]], of_patches: &[[f32; 3]]) -> Vec<(u32, [f32; 3])> {
        let far_of = |patch: usize| of_patches.get(patch).copied().unwrap_or_default().map(f64::from);
        let mut behind = self.behind.iter().peekable();
        let mut passed = Vec::new();
        if self.translucence.is_empty() {
            return passed;
        }
        for (corner, source) in (0_u32..).zip(&self.sources) {
            let Some(passing) = self.translucence.at(source.patch as usize) else { continue };
            while behind.peek().is_some_and(|b| b.corner < corner) {
                behind.next();
            }
            let far = match behind.peek().filter(|b| b.corner == corner) {
                Some(place) => {
                    let mut sum = [0.0; 3];
                    for (&at, weight) in place.corners.iter().zip(place.weights) {
                        let there = arriving[at as usize];
                        sum.iter_mut().zip(there).for_each(|(sum, h)| *sum += f64::from(weight * h));
                    }
                    sum
                }
                None => passing.far(far_of),
            };
            passed.push((corner, std::array::from_fn(|b| (passing.share[b] * far[b]) as f32)));
        }
        passed
    }

    /// The irradiance at the lit corners, as [`Self::detailed_radiosity`] shows it.
    pub fn detailed_irradiance(
        &self,
        irradiance: &[[f32; 3]],
        detail: Option<Detail<'_>>,
        shading: Shading,
    ) -> Vec<[f32; 3]> {
        let Some(detail) = detail.filter(|detail| self.shows(detail, shading)) else {
            return self.corner_values(irradiance, shading);
        };
        let mut values = self.spread(detail.interreflected, shading);
        for (value, source) in values.iter_mut().zip(&self.sources) {
            let direct = detail.direct[source.element as usize];
            value.iter_mut().zip(direct).for_each(|(value, direct)| *value += direct);
        }
        values
    }

    fn shows(&self, detail: &Detail<'_>, shading: Shading) -> bool {
        let corners = self.elements.as_ref().map(|elements| elements.corners.len());
        shading == Shading::Gouraud && corners == Some(detail.direct.len())
    }

    fn spread<const N: usize>(&self, patch_values: &[[f32; N]], shading: Shading) -> Vec<[f32; N]> {
        let vertex_values = match shading {
            Shading::Flat => Vec::new(),
            Shading::Gouraud => self.weights.gather(patch_values),
        };
        let one = |source: &Source| match shading {
            Shading::Flat => {
                let value = patch_values.get(source.patch as usize).copied().unwrap_or([0.0; N]);
                value.map(|x| if x.is_finite() { x } else { 0.0 })
            }
            Shading::Gouraud if source.weights[0] == 1.0 => vertex_values[source.vertices[0] as usize],
            Shading::Gouraud => {
                let mut sum = [0.0; N];
                for (&vertex, weight) in source.vertices.iter().zip(source.weights) {
                    for (sum, value) in sum.iter_mut().zip(vertex_values[vertex as usize]) {
                        *sum += weight * value;
                    }
                }
                sum
            }
        };
        let lit = &self.sources;
        if lit.len() > 8 * PARALLEL_FROM {
            lit.par_iter().with_min_len(4096).map(one).collect()
        } else {
            lit.iter().map(one).collect()
        }
    }
}
