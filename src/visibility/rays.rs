//! Rays against the true polygons of a mesh.

use super::panes::Glass;
use crate::geometry::{Bvh, Frame, Ray};
use crate::mesh::{NO_PATCH, PatchMesh, cosine_direction};
use crate::watch::Cancelled;
use glam::DVec3;
use rayon::prelude::*;

/// What rays are cast against: the true polygons, as triangles.
#[derive(Clone, Debug)]
pub struct RayScene {
    bvh: Bvh,
    /// For each triangle the patches on its front and back, whether these sides are dark, and its
    /// front normal.
    patches: Vec<[u32; 2]>,
    dark: Vec<[bool; 2]>,
    /// For each triangle whether another surface lies on its back, so that this is never seen.
    backed: Vec<bool>,
    /// For each triangle whether it has holes: it stands among the panes.
    perforated: Vec<bool>,
    normals: Vec<DVec3>,
    /// Rays start this far off the surface, metres.
    offset: f64,
    /// Whether no ray leaves it.
    sealed: bool,
    glass: Glass,
}

impl RayScene {
    /// Triangulates the pieces of a mesh.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn new(mesh: &PatchMesh, cancelled: &(dyn Fn() -> bool + Sync)) -> Result<Self, Cancelled> {
        let (triangles, pieces) = mesh.triangles();
        let mut scene = Self {
            bvh: Bvh::build_unless(&triangles, cancelled)?,
            patches: pieces.iter().map(|&p| mesh.pieces[p as usize].patches).collect(),
            dark: pieces
                .iter()
                .map(|&p| mesh.regions[mesh.pieces[p as usize].region as usize].dark)
                .collect(),
            backed: pieces.iter().map(|&p| mesh.pieces[p as usize].backed).collect(),
            perforated: pieces
                .iter()
                .map(|&p| mesh.regions[mesh.pieces[p as usize].region as usize].has_holes)
                .collect(),
            normals: pieces
                .iter()
                .map(|&p| mesh.regions[mesh.pieces[p as usize].region as usize].frame.normal)
                .collect(),
            offset: 1e-7 * mesh.size,
            sealed: false,
            glass: Glass::new(mesh),
        };
        scene.sealed = scene.looks_sealed(mesh, cancelled);
        if cancelled() { Err(Cancelled) } else { Ok(scene) }
    }

    /// The patch that a ray from `point` meets first; `None` where it escapes or meets a dark side.
    pub fn patch_seen(&self, point: DVec3, direction: DVec3) -> Option<u32> {
        self.seen(point, direction).map(|seen| seen.0).filter(|&patch| patch != NO_PATCH)
    }

    /// The patch that a ray meets first, or [`NO_PATCH`], and whether no light reaches that side; `None`
    /// where the ray escapes.
    pub(crate) fn seen(&self, point: DVec3, direction: DVec3) -> Option<(u32, bool)> {
        self.hit(point, direction).map(|(patch, dark, _)| (patch, dark))
    }

    /// The same with the distance, metres for a unit `direction`.
    fn hit(&self, point: DVec3, direction: DVec3) -> Option<(u32, bool, f64)> {
        let ray = Ray { origin: point, direction };
        let is_shown = |triangle: u32| self.is_shown(triangle, direction);
        let hit = self.bvh.nearest_where(&ray, self.offset, f64::INFINITY, is_shown)?;
        let triangle = hit.triangle as usize;
        let side = usize::from(self.normals[triangle].dot(direction) > 0.0);
        Some((self.patches[triangle][side], self.dark[triangle][side], hit.distance))
    }

    /// As [`Self::seen`]; `add` is called with the patch and what panes leave of its light on the way, by luminance, and
    /// with each patch that one of them mirrors, by what it mirrors.
    pub(crate) fn seen_by_glass(
        &self,
        point: DVec3,
        direction: DVec3,
        mut add: impl FnMut(u32, f64),
    ) -> Option<(u32, bool)> {
        let met = self.hit(point, direction);
        let distance = met.map_or(f64::INFINITY, |(_, _, distance)| distance);
        let patch = met.map(|met| met.0).filter(|&patch| patch != NO_PATCH);
        self.by_glass(&Ray { origin: point, direction }, (patch, distance), &mut add);
        met.map(|(patch, dark, _)| (patch, dark))
    }

    /// The same where it is known what a ray meets, and in which distance, metres for a unit direction.
    pub(crate) fn by_glass(
        &self,
        ray: &Ray,
        (met, distance): (Option<u32>, f64),
        mut add: impl FnMut(u32, f64),
    ) {
        let range = [self.offset, distance - self.offset];
        if let Some(patch) = met {
            add(patch, self.glass.luminous(ray.origin, ray.direction, range));
        }
        self.glass.each_perforated(ray.origin, ray.direction, range, &mut add);
        self.glass.each_mirror(ray.origin, ray.direction, range, |from, mirrored, share| {
            if let Some((patch, _, distance)) = self.hit(from, mirrored).filter(|met| met.0 != NO_PATCH) {
                let way = [self.offset, distance - self.offset];
                add(patch, share * self.glass.luminous(from, mirrored, way));
            }
        });
    }

    /// Forgets the panes.
    pub(crate) fn leave_out_panes(&mut self) {
        self.glass = Glass::default();
    }

    /// The panes on the way.
    pub(crate) fn glass(&self) -> &Glass {
        &self.glass
    }

    /// What panes leave of the light between two points, by luminance.
    pub(crate) fn passed(&self, from: DVec3, to: DVec3) -> f64 {
        self.glass.between(from, to, self.offset)
    }

    /// Whether all light that leaves patches arrives at others: no ray leaves the scene, of 8 spread over the hemisphere and 16 along the surface from each
    /// of some thousands of patches that light reaches.
    pub(crate) fn is_sealed(&self) -> bool {
        self.sealed && self.glass.is_empty()
    }

    fn looks_sealed(&self, mesh: &PatchMesh, cancelled: &(dyn Fn() -> bool + Sync)) -> bool {
        const RAYS: u32 = 8;
        const PATCHES: usize = 4096;
        let step = mesh.patches.len().div_ceil(PATCHES).max(1);
        mesh.patches.par_iter().enumerate().step_by(step).filter(|(_, p)| !p.buried).all(|(i, p)| {
            let frame = Frame::around(p.normal);
            let turn = (i as f64 * 0.618_033_988_749_894_9).fract();
            !cancelled()
                && (0..RAYS)
                    .all(|k| self.seen(p.centre, frame.world(cosine_direction(k, RAYS, turn))).is_some())
                && !self.opens_sideways(p.centre, &frame)
        })
    }

    /// Whether a ray along a surface from one of its points, a hair above it, escapes from the scene:
    /// looked for in 16 directions.
    pub(crate) fn opens_sideways(&self, point: DVec3, frame: &Frame) -> bool {
        const RAYS: u32 = 16;
        const RISE: f64 = 1e-5;
        (0..RAYS).any(|k| {
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(k) + 0.3) / f64::from(RAYS)).sin_cos();
            self.seen(point, frame.world(DVec3::new(cos, sin, RISE))).is_none()
        })
    }

    /// Whether a point on a surface lies inside a body, under one, or outside a closed scene that its
    /// surface sticks out of: what is lit never sees a side that no light reaches, and one of 8 rays
    /// would meet one or leave.
    pub(crate) fn covered(&self, point: DVec3, frame: &Frame) -> bool {
        const RAYS: u32 = 8;
        (0..RAYS).any(|k| {
            let direction = frame.world(cosine_direction(k, RAYS, 0.1));
            self.seen(point, direction).map_or(self.sealed, |(_, dark)| dark)
        })
    }

    /// Whether nothing stands between two points.
    pub fn visible(&self, from: DVec3, to: DVec3) -> bool {
        let direction = to - from;
        let length = direction.length();
        if length <= 2.0 * self.offset {
            return true;
        }
        let ray = Ray { origin: from, direction: direction / length };
        let is_shown = |triangle: u32| self.is_shown(triangle, direction);
        !self.bvh.occluded_where(&ray, self.offset, length - self.offset, is_shown)
    }

    /// Whether the side of a triangle that a ray in this direction meets can be seen.
    fn is_shown(&self, triangle: u32, direction: DVec3) -> bool {
        let t = triangle as usize;
        let is_back = self.backed[t] && self.normals[t].dot(direction) > 0.0;
        !(self.perforated[t] || is_back)
    }
}
