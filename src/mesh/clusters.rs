//! Clusters: small facets of a neighbourhood that share one unknown.
//!
//! A plant of 100,000 leaves would need as many patches, and as many rows; what its leaves pass on is nearly the
//! same for all that face one way. So facets of one material within a cell of a grid whose normals have the same
//! dominant axis and sign make one patch: six directions per cell, as in an ambient cube (McTaggart 2004).

use super::patches;
use super::types::{NO_PATCH, Patch, PatchMesh, Side};
use crate::scene::{MAX_REFLECTANCE, Scene};
use glam::{DVec2, DVec3, IVec3};
use std::collections::{BTreeMap, HashSet};

/// The grid's cells grow by this factor until clusters are few enough, at least and at most.
const GROWTH: [f64; 2] = [1.03, 2.0];
/// At most so often: from a patch to the whole of a city.
const MOST_GROWTHS: usize = 200;
/// A direction or a cell that would count less than this is left out.
const FAINT: f64 = 0.02;

/// What facets that share a cluster have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
struct Key {
    material: u32,
    side: Side,
    cell: [i32; 3],
    /// Twice the dominant axis of the side's normal, and one more where it points against that.
    direction: u8,
}

/// A small facet on one of its sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub(super) material: u32,
    pub(super) side: Side,
    /// Its centroid, metres.
    pub(super) centre: DVec3,
    /// Unit normal of the side.
    pub(super) normal: DVec3,
    /// Index of the piece.
    pub(super) piece: u32,
}

/// The clusters of a mesh by their place.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// Edge of a cell, metres; zero without clusters.
    edge: f64,
    of_key: BTreeMap<Key, u32>,
    /// Sides of small facets that share them.
    facets: usize,
}

fn cell_of(point: DVec3, edge: f64) -> IVec3 {
    (point / edge).floor().as_ivec3()
}

/// The dominant axis of a unit normal and its sign.
fn direction_of(normal: DVec3) -> u8 {
    let size = normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    2 * axis as u8 + u8::from(normal[axis] < 0.0)
}

impl Facet {
    fn key(&self, edge: f64) -> Key {
        Key {
            material: self.material,
            side: self.side,
            cell: cell_of(self.centre, edge).to_array(),
            direction: direction_of(self.normal),
        }
    }
}

/// The edge of a cell, at least `least` metres, with which these facets make no more than about `wanted` clusters.
fn edge_for(facets: &[Facet], wanted: f64, least: f64) -> f64 {
    let mut edge = least;
    for _ in 0..MOST_GROWTHS {
        let keys: HashSet<Key> = facets.iter().map(|facet| facet.key(edge)).collect();
        // Facets along a surface: the cells that hold some fall with the square of the edge.
        let excess = keys.len() as f64 / wanted;
        if excess <= 1.0 {
            break;
        }
        edge *= excess.sqrt().clamp(GROWTH[0], GROWTH[1]);
    }
    edge
}

impl Clusters {
    /// Joins facets to about `wanted` clusters, in cells of at least `least` metres, and adds them to the patches of
    /// the mesh.
    pub(super) fn append(
        mesh: &mut PatchMesh,
        scene: &Scene,
        facets: &[Facet],
        (wanted, least): (f64, f64),
        textures: bool,
    ) {
        if facets.is_empty() {
            return;
        }
        let edge = edge_for(facets, wanted, least);
        let mut groups: BTreeMap<Key, Vec<&Facet>> = BTreeMap::new();
        for facet in facets {
            groups.entry(facet.key(edge)).or_default().push(facet);
        }
        let mut clusters = Self { edge, facets: facets.len(), ..Self::default() };
        for (key, group) in groups {
            let pieces: Vec<u32> = group.iter().map(|facet| facet.piece).collect();
            if let Some(index) = append_patch(mesh, scene, (key.material, key.side), &pieces, textures) {
                clusters.of_key.insert(key, index);
            }
        }
        mesh.clusters = clusters;
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.of_key.len()
    }

    /// Whether there are none: every facet has patches of its own.
    pub fn is_empty(&self) -> bool {
        self.of_key.is_empty()
    }

    /// Sides of small facets that share them.
    pub fn facets(&self) -> usize {
        self.facets
    }

    /// The clusters whose light tells that of a facet of `own` at a point where its surface has this unit normal, and
    /// how much each counts; the weights sum to one. Linear between the cells, by the squares of the normal's
    /// components between the directions.
    pub fn around(&self, own: (u32, &Patch), point: DVec3, normal: DVec3) -> Vec<(u32, f32)> {
        let (index, patch) = own;
        let at = point / self.edge - 0.5;
        let low = at.floor();
        let share = at - low;
        let mut found: Vec<(u32, f64)> = Vec::new();
        for corner in 0..8 {
            let offset = IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
            let weight: f64 =
                (0..3).map(|axis| if offset[axis] == 1 { share[axis] } else { 1.0 - share[axis] }).product();
            let cell = (low.as_ivec3() + offset).to_array();
            for axis in 0..3 {
                let weight = weight * normal[axis] * normal[axis];
                if weight < FAINT {
                    continue;
                }
                let direction = 2 * axis as u8 + u8::from(normal[axis] < 0.0);
                let key = Key { material: patch.material, side: patch.side, cell, direction };
                if let Some(&cluster) = self.of_key.get(&key) {
                    found.push((cluster, weight));
                }
            }
        }
        // A facet counts on its own cluster where it stands alone.
        let sum: f64 = found.iter().map(|entry| entry.1).sum();
        if sum < 0.25 {
            found.push((index, 0.25 - sum));
        }
        found.sort_unstable_by_key(|entry| entry.0);
        let total: f64 = found.iter().map(|entry| entry.1).sum();
        let mut merged: Vec<(u32, f32)> = Vec::with_capacity(found.len());
        for (cluster, weight) in found {
            let weight = (weight / total) as f32;
            match merged.last_mut() {
                Some(last) if last.0 == cluster => last.1 += weight,
                _ => merged.push((cluster, weight)),
            }
        }
        merged
    }
}

/// Adds the patch that these pieces share, if there are any.
fn append_patch(
    mesh: &mut PatchMesh,
    scene: &Scene,
    (material_index, side): (u32, Side),
    pieces: &[u32],
    textures: bool,
) -> Option<u32> {
    // 1. The means of its facets.
    let normal_of = |mesh: &PatchMesh, p: u32| {
        mesh.regions[mesh.pieces[p as usize].region as usize].frame.normal * side.sign()
    };
    let middles: Vec<DVec3> = pieces.iter().map(|&p| middle(mesh, p)).collect();
    let (mut area, mut centre, mut normal) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for (&p, &at) in pieces.iter().zip(&middles) {
        let own = mesh.pieces[p as usize].area;
        area += own;
        centre += at * own;
        normal += normal_of(mesh, p) * own;
    }
    if area <= 0.0 {
        return None;
    }
    (centre, normal) = (centre / area, normal.normalize_or_zero());
    // 2. The facet that stands for it: near the middle, and facing the mean way.
    let reach = middles.iter().map(|at| at.distance_squared(centre)).fold(f64::MIN_POSITIVE, f64::max);
    let oddness = |k: usize| {
        middles[k].distance_squared(centre) / reach + 2.0 * (1.0 - normal_of(mesh, pieces[k]).dot(normal))
    };
    let chosen = (0..pieces.len()).min_by(|&a, &b| oddness(a).total_cmp(&oddness(b)))?;
    let (region, surface) = {
        let piece = &mesh.pieces[pieces[chosen] as usize];
        (piece.region, piece.surface)
    };
    let centre = middles[chosen];
    let corners = pieces.iter().flat_map(|&p| mesh.corners_of(&mesh.pieces[p as usize]));
    let radius = corners.map(|c| mesh.vertices[c.vertex as usize].distance(centre)).fold(0.0, f64::max);

    // 3. The patch.
    let material = &scene.materials[material_index as usize];
    let texture = material.texture.filter(|_| textures).map(|t| &scene.textures[t as usize]);
    let has_holes = mesh.regions[region as usize].has_holes;
    let averages = patches::texture_averages(mesh, scene, pieces, texture, has_holes);
    let patches::Averages { colour: average, opacity } = averages;
    if opacity < patches::TRANSPARENT {
        return None;
    }
    let normal = normal_of(mesh, pieces[chosen]);
    let index = mesh.patches.len() as u32;
    let start = mesh.patch_pieces.len() as u32;
    mesh.patch_pieces.extend(pieces);
    for &p in pieces {
        debug_assert_eq!(mesh.pieces[p as usize].patches[side as usize], NO_PATCH);
        mesh.pieces[p as usize].patches[side as usize] = index;
    }
    mesh.patches.push(Patch {
        region,
        side,
        surface,
        material: material_index,
        luminaire: None,
        pieces: start..mesh.patch_pieces.len() as u32,
        centre,
        normal,
        area: area * opacity,
        opacity,
        reflectance: std::array::from_fn(|b| {
            (material.reflectance[b] * average[b]).clamp(0.0, MAX_REFLECTANCE - material.translucence[b])
        }),
        texture_average: average,
        emission_weight: [0.0; 3],
        buried: false,
        is_cluster: true,
        radius,
    });
    Some(index)
}

/// The centroid of a piece, metres.
pub(super) fn middle(mesh: &PatchMesh, piece: u32) -> DVec3 {
    let piece = &mesh.pieces[piece as usize];
    let region = &mesh.regions[piece.region as usize];
    let plane: Vec<DVec2> = mesh.corners_of(piece).iter().map(|c| c.plane).collect();
    let at = crate::geometry::polygon::centroid_2d(&plane);
    region.origin + region.frame.tangent * at.x + region.frame.bitangent * at.y
}
