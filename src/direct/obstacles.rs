//! What stands between receivers and emitters: the convex parts of all surfaces, under one tree of boxes.

use crate::geometry::{Aabb, Bvh, Ray};
use crate::mesh::PatchMesh;
use glam::DVec3;

/// A convex flat obstacle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Obstacle<'a> {
    /// Counter-clockwise as seen from where `plane` points.
    pub(super) corners: &'a [DVec3],
    /// Unit normal.
    pub(super) plane: DVec3,
    pub(super) region: u32,
    /// Whether no light reaches its front and its back.
    pub(super) dark: [bool; 2],
}

impl Obstacle<'_> {
    /// Whether whatever it hides is hidden by others as well from where its plane is so far below: who is in the light
    /// sees a side that light never reaches through others alone.
    pub(super) fn is_needless(&self, heights: [f64; 2], thickness: f64) -> bool {
        let [low, high] = heights;
        self.dark[0] && low >= -thickness || self.dark[1] && high <= thickness
    }
}

/// All obstacles, the largest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Obstacles {
    corners: Vec<DVec3>,
    /// Where each one's corners start; one more at the end.
    starts: Vec<u32>,
    planes: Vec<DVec3>,
    regions: Vec<u32>,
    dark: Vec<[bool; 2]>,
    bounds: Vec<Aabb>,
    extents: Vec<(f64, f64)>,
    spheres: Vec<(DVec3, f64)>,
    tree: Bvh,
    /// Over the obstacles as triangles, with the obstacle that each is a part of.
    triangles: Bvh,
    owners: Vec<u32>,
}

impl Obstacles {
    pub(super) fn new(mesh: &PatchMesh) -> Self {
        let convex = &mesh.convex;
        let mut ranked: Vec<(f64, usize)> = (0..convex.parts.len())
            .map(|k| (crate::geometry::polygon::area_vector(convex.polygon(k)).length(), k))
            .filter(|(area, _)| *area > 0.0)
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut all = Self { starts: vec![0], ..Self::default() };
        let mut triangles = Vec::new();
        for (index, (area, part)) in ranked.into_iter().enumerate() {
            let region = convex.parts[part].region;
            let polygon = convex.polygon(part);
            all.corners.extend_from_slice(polygon);
            all.starts.push(all.corners.len() as u32);
            all.planes.push(mesh.regions[region as usize].frame.normal);
            all.regions.push(region);
            all.dark.push(mesh.regions[region as usize].dark_as_whole);
            all.bounds.push(Aabb::around(polygon.iter().copied()));
            let longest = (0..polygon.len())
                .map(|k| polygon[k].distance(polygon[(k + 1) % polygon.len()]))
                .fold(f64::MIN_POSITIVE, f64::max);
            let middle = all.bounds[index].centre();
            let radius = polygon.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
            all.spheres.push((middle, radius));
            all.extents.push((area / longest, longest));
            for k in 1..polygon.len() - 1 {
                triangles.push([polygon[0], polygon[k], polygon[k + 1]]);
                all.owners.push(index as u32);
            }
        }
        // A triangle without area that has the box of the polygon.
        let boxes: Vec<[DVec3; 3]> = all.bounds.iter().map(|b| [b.min, b.max, b.max]).collect();
        all.tree = Bvh::build(&boxes);
        all.triangles = Bvh::build(&triangles);
        all
    }

    /// How many there are.
    pub(super) fn count(&self) -> u32 {
        self.planes.len() as u32
    }

    pub(super) fn get(&self, index: u32) -> Obstacle<'_> {
        let k = index as usize;
        Obstacle {
            corners: &self.corners[self.starts[k] as usize..self.starts[k + 1] as usize],
            plane: self.planes[k],
            region: self.regions[k],
            dark: self.dark[k],
        }
    }

    /// Width and length of one, metres: its area over its longest side, and that.
    pub(super) fn extent(&self, index: u32) -> (f64, f64) {
        self.extents[index as usize]
    }

    /// A sphere around one: its middle and radius, metres.
    pub(super) fn sphere(&self, index: u32) -> (DVec3, f64) {
        self.spheres[index as usize]
    }

    /// Fills `found` with those whose boxes `enter` takes, the largest first.
    pub(super) fn select(&self, enter: impl Fn(&Aabb) -> bool, found: &mut Vec<u32>) {
        found.clear();
        self.tree.select(&enter, |index| {
            if enter(&self.bounds[index as usize]) {
                found.push(index);
            }
        });
        found.sort_unstable();
    }

    /// Whether one that `counts` stands between two points, each end left out by `margin`, metres.
    pub(super) fn hides(
        &self,
        from: DVec3,
        to: DVec3,
        margin: f64,
        counts: impl Fn(Obstacle<'_>) -> bool,
    ) -> bool {
        let direction = to - from;
        let length = direction.length();
        if length <= 2.0 * margin {
            return false;
        }
        let ray = Ray { origin: from, direction: direction / length };
        let accept = |triangle: u32| counts(self.get(self.owners[triangle as usize]));
        self.triangles.occluded_where(&ray, margin, length - margin, accept)
    }
}
