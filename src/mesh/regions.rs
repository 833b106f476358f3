//! Coplanar neighbours of one object and material joined into regions.

use crate::geometry::{Aabb, Frame, polygon};
use crate::scene::{Corner, Scene, Surface};
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use std::collections::{HashMap, VecDeque};

/// Normals within this cosine (0.26 degrees) are one.
const SAME_NORMAL: f64 = 0.99999;

/// A region before it is cut: its plane, its convex parts and its outline.
pub(super) struct Outline {
    pub(super) origin: DVec3,
    pub(super) frame: Frame,
    pub(super) edges: Vec<[DVec2; 2]>,
    pub(super) parts: Vec<Part>,
    pub(super) material: u32,
    pub(super) object: u32,
    pub(super) area: f64,
    pub(super) bounds: Aabb,
    /// Extent in plane coordinates.
    pub(super) min: DVec2,
    pub(super) max: DVec2,
    pub(super) luminaire: Option<u32>,
    pub(super) emission_weight: [f64; 3],
    pub(super) emits_back: bool,
    /// Its image has holes that light passes.
    pub(super) has_holes: bool,
    /// Patches are no smaller than this, metres, whatever is asked for: what is far away, or much larger than
    /// the rest, must not use up the patches of the rooms. Zero where nothing holds them up.
    pub(super) coarsest: f64,
}

/// A convex counter-clockwise polygon of an outline, cut from one input surface.
pub(super) struct Part {
    pub(super) surface: u32,
    pub(super) corners: Vec<DVec2>,
    /// Affine maps from plane coordinates to normal and texture coordinates, where given.
    pub(super) attributes: Attributes,
}

/// Corner attributes of the triangle or polygon that a part was cut from.
#[derive(Clone, Default)]
pub(super) struct Attributes {
    /// Plane position, smooth normal and texture coordinate of each source corner; empty where the
    /// surface is flat and plain.
    pub(super) corners: Vec<(DVec2, DVec3, DVec2)>,
}

impl Outline {
    /// World position of plane coordinates.
    pub(super) fn world(&self, plane: DVec2) -> DVec3 {
        self.origin + self.frame.tangent * plane.x + self.frame.bitangent * plane.y
    }
}

/// How far apart two planes may be and still count as one, as a fraction of the scene's size.
const COPLANAR: f64 = 1e-7;

/// Joins surfaces; returns the outlines and how many surfaces were dropped for want of area.
///
/// With `keep_surfaces` the parts of a region stay the input surfaces; otherwise a region whose
/// outline is one convex loop becomes one part.
///
/// # Errors
/// The watch ended it.
pub(super) fn join(
    scene: &Scene,
    size: f64,
    keep_surfaces: bool,
    watch: &mut Watch<'_>,
) -> Result<(Vec<Outline>, usize), Cancelled> {
    let welded = weld(&scene.positions, size * 1e-7);
    let planes: Vec<Plane> = scene.surfaces.iter().map(|s| Plane::of(scene, s)).collect();
    let smallest = (size * 1e-9).powi(2);

    let mut edge_owners: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    for (index, surface) in scene.surfaces.iter().enumerate() {
        for (a, b) in welded_edges(surface, &welded) {
            edge_owners.entry((a, b)).or_default().push(index as u32);
        }
    }

    let mut region_of = vec![u32::MAX; scene.surfaces.len()];
    let mut outlines = Vec::new();
    let mut dropped = 0;
    for seed in 0..scene.surfaces.len() {
        if region_of[seed] != u32::MAX {
            continue;
        }
        watch.done(seed as f64 / scene.surfaces.len() as f64)?;
        if planes[seed].area <= smallest {
            dropped += 1;
            continue;
        }
        let region = outlines.len() as u32;
        region_of[seed] = region;
        let mut members = vec![seed as u32];
        let mut queue = VecDeque::from([seed as u32]);
        while let Some(current) = queue.pop_front() {
            for (a, b) in welded_edges(&scene.surfaces[current as usize], &welded) {
                for &neighbour in edge_owners.get(&(b, a)).map_or(&[][..], Vec::as_slice) {
                    let n = neighbour as usize;
                    if region_of[n] == u32::MAX
                        && planes[n].area > smallest
                        && alike(&scene.surfaces[seed], &scene.surfaces[n])
                        && planes[seed].holds(scene, &scene.surfaces[n], &planes[n], size)
                    {
                        region_of[n] = region;
                        members.push(neighbour);
                        queue.push_back(neighbour);
                    }
                }
            }
        }
        members.sort_unstable();
        outlines.push(outline(scene, &planes, &members, &welded, keep_surfaces));
    }
    Ok((outlines, dropped))
}

struct Plane {
    point: DVec3,
    normal: DVec3,
    area: f64,
}

impl Plane {
    fn of(scene: &Scene, surface: &Surface) -> Self {
        let corners = scene.polygon(surface);
        let area_vector = polygon::area_vector(&corners);
        let mean = corners.iter().sum::<DVec3>() / corners.len().max(1) as f64;
        Self { point: mean, normal: area_vector.normalize_or_zero(), area: area_vector.length() }
    }

    /// Whether `surface`, which lies in `other`, lies in this plane too and faces the same way.
    fn holds(&self, scene: &Scene, surface: &Surface, other: &Self, size: f64) -> bool {
        self.normal.dot(other.normal) > 0.999
            && scene
                .polygon(surface)
                .iter()
                .all(|p| (*p - self.point).dot(self.normal).abs() <= COPLANAR * size)
    }
}

fn alike(a: &Surface, b: &Surface) -> bool {
    a.material == b.material
        && a.object == b.object
        && a.luminaire == b.luminaire
        && a.emission_weight == b.emission_weight
        && a.emits_back == b.emits_back
}

fn welded_edges(surface: &Surface, welded: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    let ids: Vec<u32> = surface.corners.iter().map(|c| welded[c.position as usize]).collect();
    (0..ids.len()).map(move |i| (ids[i], ids[(i + 1) % ids.len()])).filter(|(a, b)| a != b)
}

/// For each position the index of the first position that is equal to within `tolerance`.
fn weld(positions: &[DVec3], tolerance: f64) -> Vec<u32> {
    let mut welder = Welder::new(tolerance);
    positions.iter().map(|p| welder.index(*p)).collect()
}

/// Gives points that are equal to within a tolerance the same index, counted from zero.
pub(super) struct Welder {
    tolerance: f64,
    cells: HashMap<[i64; 3], u32>,
    /// The distinct points.
    pub(super) points: Vec<DVec3>,
}

impl Welder {
    pub(super) fn new(tolerance: f64) -> Self {
        Self { tolerance: tolerance.max(f64::MIN_POSITIVE), cells: HashMap::new(), points: Vec::new() }
    }

    pub(super) fn index(&mut self, point: DVec3) -> u32 {
        // A point within half a cell of a border is looked for on both sides of it.
        let scaled = point / (4.0 * self.tolerance);
        for corner in 0..8 {
            let nudge = DVec3::new(
                if corner & 1 == 0 { -0.25 } else { 0.25 },
                if corner & 2 == 0 { -0.25 } else { 0.25 },
                if corner & 4 == 0 { -0.25 } else { 0.25 },
            );
            let key = (scaled + nudge).floor().to_array().map(|c| c as i64);
            if let Some(&index) = self.cells.get(&key)
                && self.points[index as usize].distance(point) <= self.tolerance
            {
                return index;
            }
        }
        let index = self.points.len() as u32;
        self.points.push(point);
        self.cells.entry(scaled.floor().to_array().map(|c| c as i64)).or_insert(index);
        index
    }
}

fn outline(scene: &Scene, planes: &[Plane], members: &[u32], welded: &[u32], keep_surfaces: bool) -> Outline {
    let seed = &scene.surfaces[members[0] as usize];
    let normal = members
        .iter()
        .map(|&m| planes[m as usize].normal * planes[m as usize].area)
        .sum::<DVec3>()
        .normalize_or(planes[members[0] as usize].normal);
    let origin = planes[members[0] as usize].point;

    // An edge that two members run along in opposite directions is inside.
    let mut directed: HashMap<(u32, u32), i32> = HashMap::new();
    let mut ordered = Vec::new();
    for &m in members {
        for ((a, b), (pa, pb)) in welded_edges(&scene.surfaces[m as usize], welded).zip(position_edges(
            scene,
            &scene.surfaces[m as usize],
            welded,
        )) {
            *directed.entry((a, b)).or_default() += 1;
            ordered.push((a, b, pa, pb));
        }
    }
    let rim: Vec<(u32, u32, DVec3, DVec3)> =
        ordered.into_iter().filter(|&(a, b, ..)| !directed.contains_key(&(b, a))).collect();
    let longest = rim.iter().map(|&(.., a, b)| b - a).fold(DVec3::ZERO, |best, e| {
        if e.length_squared() > best.length_squared() * (1.0 + 1e-9) { e } else { best }
    });
    let frame = Frame::along(normal, longest);
    let plane = |p: DVec3| {
        let local = frame.local(p - origin);
        DVec2::new(local.x, local.y)
    };
    let edges: Vec<[DVec2; 2]> = rim.iter().map(|&(.., a, b)| [plane(a), plane(b)]).collect();

    let mut parts = Vec::new();
    let plain = scene.materials[seed.material as usize].texture.is_none();
    let loop_corners = (members.len() > 1 && !keep_surfaces && plain)
        .then(|| single_loop(&rim))
        .flatten()
        .map(|corners| without_collinear(corners.into_iter().map(plane).collect()));
    let joined = loop_corners.filter(|corners| is_convex(corners)).and_then(|corners| {
        let attributes = joined_attributes(scene, members, normal, &plane, &corners)?;
        Some(Part { surface: members[0], corners, attributes })
    });
    match joined {
        Some(part) => parts.push(part),
        None => {
            for &m in members {
                add_parts(scene, m, normal, &plane, plain, &mut parts);
            }
        }
    }
    let (min, max) = parts
        .iter()
        .flat_map(|p| &p.corners)
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), &c| (min.min(c), max.max(c)));
    Outline {
        area: parts.iter().map(|p| polygon::area_2d(&p.corners)).sum(),
        bounds: Aabb::around(members.iter().flat_map(|&m| scene.polygon(&scene.surfaces[m as usize]))),
        origin,
        frame,
        edges,
        parts,
        material: seed.material,
        object: seed.object,
        min,
        max,
        luminaire: seed.luminaire,
        emission_weight: seed.emission_weight,
        emits_back: seed.emits_back,
        has_holes: false,
        coarsest: 0.0,
    }
}

fn position_edges<'a>(
    scene: &'a Scene,
    surface: &'a Surface,
    welded: &'a [u32],
) -> impl Iterator<Item = (DVec3, DVec3)> + 'a {
    let n = surface.corners.len();
    (0..n)
        .map(move |i| (surface.corners[i].position, surface.corners[(i + 1) % n].position))
        .filter(|&(a, b)| welded[a as usize] != welded[b as usize])
        .map(|(a, b)| (scene.positions[a as usize], scene.positions[b as usize]))
}

/// The corners of the rim in order, if it is one closed loop without branches.
fn single_loop(rim: &[(u32, u32, DVec3, DVec3)]) -> Option<Vec<DVec3>> {
    let mut next: HashMap<u32, (u32, DVec3)> = HashMap::new();
    for &(a, b, pa, _) in rim {
        if next.insert(a, (b, pa)).is_some() {
            return None;
        }
    }
    let start = rim.first()?.0;
    let mut corners = Vec::with_capacity(rim.len());
    let mut at = start;
    loop {
        let &(to, position) = next.get(&at)?;
        corners.push(position);
        at = to;
        if at == start {
            break;
        }
        if corners.len() > rim.len() {
            return None;
        }
    }
    (corners.len() == rim.len()).then_some(corners)
}

fn without_collinear(corners: Vec<DVec2>) -> Vec<DVec2> {
    let n = corners.len();
    let kept: Vec<DVec2> = (0..n)
        .filter(|&i| {
            let (a, b, c) = (corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]);
            (b - a).perp_dot(c - b).abs() > 1e-7 * (b - a).length() * (c - b).length()
        })
        .map(|i| corners[i])
        .collect();
    if kept.len() >= 3 { kept } else { corners }
}

fn is_convex(corners: &[DVec2]) -> bool {
    polygon::is_convex(corners, 1e-12 * polygon::area_2d(corners).abs())
}

/// Whether the model gives a surface of this plane other normals at its corners.
fn is_curved(scene: &Scene, surface: &Surface, normal: DVec3) -> bool {
    let leans = |&n: &u32| scene.normals[n as usize].dot(normal).abs() < SAME_NORMAL;
    surface.corners.iter().filter_map(|corner| corner.normal.as_ref()).any(leans)
}

/// The normal of a corner, on the side of `normal`: files disagree on the side that it stands on.
fn corner_normal(scene: &Scene, corner: &Corner, normal: DVec3) -> DVec3 {
    let given = corner.normal.map_or(normal, |n| scene.normals[n as usize]);
    if given.dot(normal) < 0.0 { -given } else { given }
}

/// What the corners of one polygon around plain surfaces have of these; `None` where they disagree on a normal.
fn joined_attributes(
    scene: &Scene,
    members: &[u32],
    normal: DVec3,
    plane: &impl Fn(DVec3) -> DVec2,
    corners: &[DVec2],
) -> Option<Attributes> {
    let surfaces = || members.iter().map(|&m| &scene.surfaces[m as usize]);
    if !surfaces().any(|surface| is_curved(scene, surface, normal)) {
        return Some(Attributes::default());
    }
    let key = |at: DVec2| at.to_array().map(f64::to_bits);
    let mut known: HashMap<[u64; 2], Option<DVec3>> = HashMap::new();
    for corner in surfaces().flat_map(|surface| &surface.corners) {
        let given = corner_normal(scene, corner, normal);
        let here = known.entry(key(plane(scene.positions[corner.position as usize]))).or_insert(Some(given));
        *here = here.filter(|first| first.dot(given) > SAME_NORMAL);
    }
    let of = |&at: &DVec2| Some((at, known.get(&key(at)).copied().flatten()?, DVec2::ZERO));
    Some(Attributes { corners: corners.iter().map(of).collect::<Option<_>>()? })
}

/// The surface as convex parts: itself, or triangles.
fn add_parts(
    scene: &Scene,
    index: u32,
    normal: DVec3,
    plane: &impl Fn(DVec3) -> DVec2,
    plain: bool,
    parts: &mut Vec<Part>,
) {
    let surface = &scene.surfaces[index as usize];
    let corners: Vec<DVec2> =
        surface.corners.iter().map(|c| plane(scene.positions[c.position as usize])).collect();
    let smooth = is_curved(scene, surface, normal);
    let attributes = |chosen: &[usize]| {
        if plain && !smooth {
            return Attributes::default();
        }
        let of = |&i: &usize| {
            let corner = surface.corners[i];
            let given = corner_normal(scene, &corner, normal);
            (corners[i], given, corner.uv.map_or(DVec2::ZERO, |uv| scene.uvs[uv as usize]))
        };
        Attributes { corners: chosen.iter().map(of).collect() }
    };
    if is_convex(&corners) {
        let all: Vec<usize> = (0..corners.len()).collect();
        parts.push(Part { surface: index, attributes: attributes(&all), corners });
        return;
    }
    for triangle in polygon::triangulate(&corners, &[]) {
        let mut chosen = triangle.map(|i| i as usize);
        if polygon::area_2d(&chosen.map(|i| corners[i])) < 0.0 {
            chosen.swap(1, 2);
        }
        let cut = chosen.map(|i| corners[i]).to_vec();
        if polygon::area_2d(&cut) > 0.0 {
            parts.push(Part { surface: index, corners: cut, attributes: attributes(&chosen) });
        }
    }
}

impl Attributes {
    /// Normal and texture coordinates at a point: barycentric in a triangle, inverse-bilinear-like
    /// (mean value coordinates, Floater 2003) in a larger polygon.
    pub(super) fn at(&self, point: DVec2, flat: DVec3) -> (DVec3, DVec2) {
        if self.corners.is_empty() {
            return (flat, DVec2::ZERO);
        }
        let n = self.corners.len();
        let offsets: Vec<DVec2> = self.corners.iter().map(|c| c.0 - point).collect();
        let (mut normal, mut uv, mut total) = (DVec3::ZERO, DVec2::ZERO, 0.0);
        for i in 0..n {
            let length = offsets[i].length();
            let next = offsets[(i + 1) % n];
            let edge = next - offsets[i];
            let tiny = 1e-12 * edge.length_squared();
            if length * length <= tiny {
                return (self.corners[i].1, self.corners[i].2);
            }
            // On the edge to the next corner: linear along it.
            if offsets[i].perp_dot(next).abs() <= tiny && offsets[i].dot(next) <= 0.0 {
                let t = length / (length + next.length());
                let (a, b) = (&self.corners[i], &self.corners[(i + 1) % n]);
                return (a.1.lerp(b.1, t).normalize_or(flat), a.2.lerp(b.2, t));
            }
            let previous = offsets[(i + n - 1) % n];
            let weight = (tan_half(previous, offsets[i]) + tan_half(offsets[i], next)) / length;
            normal += self.corners[i].1 * weight;
            uv += self.corners[i].2 * weight;
            total += weight;
        }
        if total.abs() < f64::MIN_POSITIVE || !total.is_finite() {
            return (flat, self.corners[0].2);
        }
        (normal.normalize_or(flat), uv / total)
    }
}

/// Tangent of half the angle from `a` to `b`.
fn tan_half(a: DVec2, b: DVec2) -> f64 {
    let cross = a.perp_dot(b);
    let dot = a.dot(b);
    let length = a.length() * b.length();
    cross / (length + dot).max(f64::MIN_POSITIVE)
}
