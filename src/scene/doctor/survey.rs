//! The faces of a scene made ready to be looked at: planes, triangles and a hierarchy over these.

use crate::geometry::{Bvh, polygon};
use crate::scene::sides::partners;
use crate::scene::types::Scene;
use crate::scene::views::triangles;
use glam::DVec3;
use std::ops::Range;

/// The plane that a face lies in.
pub(super) struct Plane {
    /// The mean of its corners.
    pub(super) point: DVec3,
    /// Unit normal on the front; zero where the face has no area.
    pub(super) normal: DVec3,
    /// Area, m².
    pub(super) area: f64,
    /// How far corners lie off the plane at most, metres.
    pub(super) bend: f64,
}

impl Plane {
    fn of(outline: &[DVec3]) -> Self {
        let area = polygon::area_vector(outline);
        let point = outline.iter().sum::<DVec3>() / outline.len().max(1) as f64;
        let plane = Self { point, normal: area.normalize_or_zero(), area: area.length(), bend: 0.0 };
        let bend = outline.iter().map(|&p| plane.height(p).abs()).fold(0.0, f64::max);
        Self { bend, ..plane }
    }

    /// Signed distance of a point, metres.
    pub(super) fn height(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.normal)
    }
}

/// A scene with what all searches need of it.
pub(super) struct Survey<'a> {
    pub(super) scene: &'a Scene,
    /// What tolerances are shares of, metres: the diagonal of the part that is looked at, or less.
    pub(super) diagonal: f64,
    pub(super) planes: Vec<Plane>,
    pub(super) bvh: Bvh,
    /// The face that each triangle is a part of.
    pub(super) owners: Vec<u32>,
    outlines: Vec<Vec<DVec3>>,
    /// For each face the one that is written for its other side.
    pub(super) partners: Vec<Option<u32>>,
    triangles: Vec<[DVec3; 3]>,
    ranges: Vec<Range<usize>>,
}

impl<'a> Survey<'a> {
    pub(super) fn of(scene: &'a Scene) -> Self {
        let (triangles, owners) = triangles(&scene.positions, &scene.surfaces);
        let outlines: Vec<Vec<DVec3>> = scene.surfaces.iter().map(|s| scene.polygon(s)).collect();
        let mut ranges = Vec::with_capacity(outlines.len());
        let mut start = 0;
        for face in 0..outlines.len() as u32 {
            let end = start + owners[start..].iter().take_while(|&&owner| owner == face).count();
            ranges.push(start..end);
            start = end;
        }
        Self {
            scene,
            diagonal: scene.extent().scale,
            planes: outlines.iter().map(|outline| Plane::of(outline)).collect(),
            bvh: Bvh::build(&triangles),
            owners,
            partners: partners(&scene.positions, &scene.surfaces),
            outlines,
            triangles,
            ranges,
        }
    }

    /// Corner positions of a face, metres.
    pub(super) fn outline(&self, face: u32) -> &[DVec3] {
        &self.outlines[face as usize]
    }

    /// The triangles of a face.
    pub(super) fn triangles_of(&self, face: u32) -> &[[DVec3; 3]] {
        &self.triangles[self.ranges[face as usize].clone()]
    }

    /// Whether a point lies on a face other than `face`, and than that which is written for its other side, to
    /// within `tolerance`.
    pub(super) fn lies_on_another(&self, point: DVec3, face: u32, tolerance: f64) -> bool {
        let mut on_one = false;
        self.bvh.touching(&crate::geometry::Aabb::around([point]).grown(tolerance), |triangle| {
            let near = || distance_to(point, &self.triangles[triangle as usize]) <= tolerance;
            let owner = self.owners[triangle as usize];
            let is_other = owner != face && self.partners[face as usize] != Some(owner);
            on_one = on_one || (is_other && near());
        });
        on_one
    }

    /// Unit normal on the front of the face that a triangle is a part of.
    pub(super) fn normal_of(&self, triangle: u32) -> DVec3 {
        self.planes[self.owners[triangle as usize] as usize].normal
    }

    /// Name of the object that a face belongs to.
    pub(super) fn object_of(&self, face: u32) -> &'a str {
        &self.scene.objects[self.scene.surfaces[face as usize].object as usize]
    }
}

/// Distance of a point from a triangle (Ericson 2005, *Real-Time Collision Detection*, 5.1.5).
fn distance_to(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].iter().all(|&(s, e)| (e - s).cross(p - s).dot(normal) >= 0.0);
    if inside && normal != DVec3::ZERO {
        return (p - a).dot(normal.normalize()).abs();
    }
    let to_segment = |s: DVec3, e: DVec3| {
        let along = e - s;
        let t = ((p - s).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        p.distance(s + along * t)
    };
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}
