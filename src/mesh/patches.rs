//! Pieces grouped into patches: one a cell where it can be, slivers joined to a neighbour.

use super::pieces::{Cut, Grid};
use super::regions::Outline;
use super::types::{Patch, PatchMesh, Piece, Side};
use crate::geometry::polygon;
use crate::scene::{MAX_REFLECTANCE, Scene, Texture};
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

/// A patch smaller than this fraction of its full cell joins a neighbour, if there is one.
const SLIVER: f64 = 0.25;
/// What is less opaque is not there.
pub(super) const TRANSPARENT: f64 = 0.004;
/// No patch grows beyond this fraction of its full cell by taking slivers in.
const LARGEST: f64 = 1.7;

/// Piece indices that make one patch.
pub(super) type Group = Vec<u32>;

/// One group an input surface.
pub(super) fn group_by_surface(mesh: &PatchMesh, pieces: Range<u32>) -> Vec<Group> {
    let mut groups: BTreeMap<u32, Group> = BTreeMap::new();
    for p in pieces {
        groups.entry(mesh.pieces[p as usize].surface).or_default().push(p);
    }
    groups.into_values().collect()
}

/// One group a cell and side of contact lines; slivers join the neighbour with the longest border.
pub(super) fn group_by_cell(
    mesh: &PatchMesh,
    pieces: Range<u32>,
    grid: &Grid,
    cuts: &[Cut],
    contacts: &[[DVec2; 2]],
) -> Vec<Group> {
    let mut index_of: BTreeMap<(u32, u32, u64), usize> = BTreeMap::new();
    let mut groups: Vec<Group> = Vec::new();
    // Area that each would have if its surface filled its cell.
    let mut full: Vec<f64> = Vec::new();
    for (p, cut) in pieces.clone().zip(cuts) {
        let next = groups.len();
        let index = *index_of.entry((cut.cell, cut.leaf, cut.sides)).or_insert(next);
        if index == next {
            groups.push(Vec::new());
            full.push(cut.extent.x * cut.extent.y);
        }
        groups[index].push(p);
    }
    let area = |group: &Group| group.iter().map(|&p| mesh.pieces[p as usize].area).sum::<f64>();
    let mut areas: Vec<f64> = groups.iter().map(area).collect();
    if areas.iter().zip(&full).all(|(a, full)| *a >= SLIVER * full) {
        return groups;
    }

    // Borders between groups: edges that two pieces share.
    let mut group_of: HashMap<u32, usize> = HashMap::new();
    for (index, group) in groups.iter().enumerate() {
        group_of.extend(group.iter().map(|&p| (p, index)));
    }
    let mut open: HashMap<(u32, u32), usize> = HashMap::new();
    let mut borders: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); groups.len()];
    for p in pieces {
        let corners = mesh.corners_of(&mesh.pieces[p as usize]);
        for i in 0..corners.len() {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            let here = group_of[&p];
            if let Some(there) = open.remove(&(b.vertex, a.vertex)) {
                if here != there && !on_contact(contacts, 0.5 * (a.plane + b.plane), grid) {
                    let length = a.plane.distance(b.plane);
                    *borders[here].entry(there).or_default() += length;
                    *borders[there].entry(here).or_default() += length;
                }
            } else {
                open.insert((a.vertex, b.vertex), here);
            }
        }
    }
    let mut order: Vec<usize> = (0..groups.len()).filter(|&g| areas[g] < SLIVER * full[g]).collect();
    order.sort_by(|&a, &b| areas[a].total_cmp(&areas[b]).then(a.cmp(&b)));
    for sliver in order {
        if groups[sliver].is_empty() || areas[sliver] >= SLIVER * full[sliver] {
            continue;
        }
        let host = borders[sliver]
            .iter()
            .filter(|&(&h, _)| {
                h != sliver && !groups[h].is_empty() && areas[h] + areas[sliver] <= LARGEST * full[h]
            })
            .max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)))
            .map(|(&h, _)| h);
        if let Some(host) = host {
            let moved = std::mem::take(&mut groups[sliver]);
            groups[host].extend(moved);
            areas[host] += areas[sliver];
            for (neighbour, length) in std::mem::take(&mut borders[sliver]) {
                if neighbour != host {
                    *borders[host].entry(neighbour).or_default() += length;
                    *borders[neighbour].entry(host).or_default() += length;
                }
            }
        }
    }
    groups.retain(|g| !g.is_empty());
    groups
}

fn on_contact(contacts: &[[DVec2; 2]], point: DVec2, grid: &Grid) -> bool {
    let slack = 1e-5 * grid.cell.min_element();
    contacts.iter().any(|&[p, q]| {
        let along = q - p;
        let t = ((point - p).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        point.distance(p + along * t) < slack
    })
}

/// Appends the patch on `side` of the pieces in `group`.
pub(super) fn append(
    mesh: &mut PatchMesh,
    scene: &Scene,
    outline: &Outline,
    side: Side,
    group: &Group,
    textures: bool,
) {
    let index = mesh.patches.len() as u32;
    let mut area = 0.0;
    let mut moment = DVec2::ZERO;
    let mut largest: Option<&Piece> = None;
    for &p in group {
        let piece = &mesh.pieces[p as usize];
        let plane: Vec<DVec2> = mesh.corners_of(piece).iter().map(|c| c.plane).collect();
        moment += polygon::centroid_2d(&plane) * piece.area;
        area += piece.area;
        if largest.is_none_or(|l| piece.area > l.area) {
            largest = Some(piece);
        }
    }
    let Some(largest) = largest else { return };
    let mut centre = moment / area.max(f64::MIN_POSITIVE);
    if !group.iter().any(|&p| holds(mesh, &mesh.pieces[p as usize], centre)) {
        let plane: Vec<DVec2> = mesh.corners_of(largest).iter().map(|c| c.plane).collect();
        centre = polygon::centroid_2d(&plane);
    }
    let surface = largest.surface;
    let corners = group.iter().flat_map(|&p| mesh.corners_of(&mesh.pieces[p as usize]));
    let radius = corners.map(|c| c.plane.distance(centre)).fold(0.0, f64::max);
    let material = &scene.materials[outline.material as usize];
    let texture = material.texture.filter(|_| textures).map(|t| &scene.textures[t as usize]);
    let Averages { colour: average, opacity } =
        texture_averages(mesh, scene, group, texture, outline.has_holes);
    if opacity < TRANSPARENT {
        return;
    }
    let emits = side == Side::Front || outline.emits_back;

    let start = mesh.patch_pieces.len() as u32;
    mesh.patch_pieces.extend(group);
    for &p in group {
        mesh.pieces[p as usize].patches[side as usize] = index;
    }
    mesh.patches.push(Patch {
        region: mesh.regions.len() as u32 - 1,
        side,
        surface,
        material: outline.material,
        luminaire: outline.luminaire.filter(|_| emits),
        pieces: start..mesh.patch_pieces.len() as u32,
        centre: outline.world(centre),
        normal: outline.frame.normal * side.sign(),
        area: area * opacity,
        opacity,
        reflectance: std::array::from_fn(|b| {
            (material.reflectance[b] * average[b]).clamp(0.0, MAX_REFLECTANCE - material.translucence[b])
        }),
        texture_average: average,
        emission_weight: if emits { outline.emission_weight } else { [0.0; 3] },
        buried: false,
        is_cluster: false,
        radius,
    });
}

/// Makes another point of a patch stand for it.
pub(super) fn move_centre(mesh: &mut PatchMesh, index: usize, centre: DVec3) {
    let patch = &mesh.patches[index];
    let corners = mesh.pieces_of(patch).flat_map(|piece| mesh.corners_of(piece));
    let distances = corners.map(|c| mesh.vertices[c.vertex as usize].distance(centre));
    let radius = distances.fold(0.0, f64::max);
    let patch = &mut mesh.patches[index];
    (patch.centre, patch.radius) = (centre, radius);
}

/// Points spread over a patch: near the corners of its pieces and in their middles.
pub(super) fn inner_points(mesh: &PatchMesh, patch: &Patch) -> Vec<DVec3> {
    let mut points = Vec::new();
    for piece in mesh.pieces_of(patch) {
        let corners = mesh.polygon(piece, patch.side);
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        points.push(middle);
        points.extend(corners.iter().map(|&c| middle + (c - middle) * 0.93));
        points.extend((0..corners.len()).map(|i| {
            let edge = 0.5 * (corners[i] + corners[(i + 1) % corners.len()]);
            middle + (edge - middle) * 0.93
        }));
    }
    points
}

fn holds(mesh: &PatchMesh, piece: &Piece, point: DVec2) -> bool {
    let corners = mesh.corners_of(piece);
    (0..corners.len()).all(|i| {
        let (a, b) = (corners[i].plane, corners[(i + 1) % corners.len()].plane);
        (b - a).perp_dot(point - a) >= -1e-9 * (b - a).length_squared()
    })
}

/// Means of a texture over a patch.
pub(super) struct Averages {
    /// Per band, of what is opaque.
    pub(super) colour: [f64; 3],
    /// Share that is opaque, 0 to 1.
    pub(super) opacity: f64,
}

/// Area-weighted means of a texture over the pieces of a patch: 8 x 8 points per triangle, or those of the whole
/// image where a surface has no texture coordinates. Without `holes` all of it is opaque.
pub(super) fn texture_averages(
    mesh: &PatchMesh,
    scene: &Scene,
    group: &[u32],
    texture: Option<&Texture>,
    holes: bool,
) -> Averages {
    let Some(texture) = texture else { return Averages { colour: [1.0; 3], opacity: 1.0 } };
    let whole = || texture.opacity.iter().map(|&o| f64::from(o)).sum::<f64>() / texture.opacity.len() as f64;
    let all = if holes { whole() } else { 1.0 };
    const POINTS: usize = 8;
    const REPEATS: f64 = 4.0;
    let mut sum = [0.0; 3];
    let (mut opaque, mut total) = (0.0, 0.0);
    for &p in group {
        let piece = &mesh.pieces[p as usize];
        let surface = &scene.surfaces[piece.surface as usize];
        if surface.corners.iter().any(|corner| corner.uv.is_none()) {
            (0..3).for_each(|band| sum[band] += piece.area * all * texture.mean[band]);
            opaque += piece.area * all;
            total += piece.area;
            continue;
        }
        let corners = mesh.corners_of(piece);
        for k in 1..corners.len() - 1 {
            let [a, b, c] = [corners[0], corners[k], corners[k + 1]];
            let own = polygon::area_2d(&[a.plane, b.plane, c.plane]);
            // Where it is repeated more often than points can tell, that of the whole image.
            let span = a.uv.max(b.uv).max(c.uv) - a.uv.min(b.uv).min(c.uv);
            if span.max_element() > REPEATS && !texture.clamped {
                (0..3).for_each(|band| sum[band] += own * all * texture.mean[band]);
                opaque += own * all;
                total += own;
                continue;
            }
            let weight = own / (POINTS * POINTS) as f64;
            for i in 0..POINTS * POINTS {
                let mut s = ((i % POINTS) as f64 + 0.5) / POINTS as f64;
                let mut t = ((i / POINTS) as f64 + 0.5) / POINTS as f64;
                if s + t > 1.0 {
                    (s, t) = (1.0 - s, 1.0 - t);
                }
                let uv = a.uv + (b.uv - a.uv) * s + (c.uv - a.uv) * t;
                let (texel, opacity) = (texture.sample(uv), if holes { texture.opacity_at(uv) } else { 1.0 });
                let own = weight * f64::from(opacity);
                for band in 0..3 {
                    sum[band] += own * f64::from(texel[band]);
                }
                opaque += own;
                total += weight;
            }
        }
    }
    Averages {
        colour: sum.map(|s| if opaque > 0.0 { s / opaque } else { 1.0 }),
        opacity: if total > 0.0 { opaque / total } else { 1.0 },
    }
}

/// (Longest extent)² over area on the region's axes; 1 for a square.
pub(super) fn aspect(mesh: &PatchMesh, patch: &Patch) -> f64 {
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in mesh.pieces_of(patch).flat_map(|piece| mesh.corners_of(piece)) {
        min = min.min(corner.plane);
        max = max.max(corner.plane);
    }
    (max - min).max_element().powi(2) / patch.outline_area().max(f64::MIN_POSITIVE)
}
