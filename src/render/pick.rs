use crate::geometry::{Bvh, Ray};
use crate::mesh::{NO_PATCH, PatchMesh, Side};
use crate::navigation::Camera;
use crate::visibility::Glass;
use glam::{DVec2, DVec3};

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The patch on the side that was met; `None` where that side takes no part.
    pub patch: Option<u32>,
    /// Index into [`PatchMesh::pieces`].
    pub piece: u32,
    /// Index into the triangles of [`PatchMesh::triangles`].
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentric: [f64; 2],
    /// The side that was met.
    pub side: Side,
    /// Where, metres.
    pub position: DVec3,
    /// In multiples of the ray's direction: metres where that is of unit length.
    pub distance: f64,
    /// Unit normal of the region, towards the ray's origin.
    pub normal: DVec3,
}

/// Finds what lies under a pixel or before a walker's feet, on the CPU.
#[derive(Clone, Debug, Default)]
pub struct Picker {
    bvh: Bvh,
    /// The piece of each triangle.
    pieces: Vec<u32>,
    /// Patches on the front and back of each piece, and its front's normal.
    sides: Vec<([u32; 2], DVec3)>,
    /// Panes, which are looked through.
    glass: Glass,
}

impl Picker {
    /// Builds the search structure; takes some tens of milliseconds per 100,000 triangles.
    pub fn new(mesh: &PatchMesh) -> Self {
        let (triangles, pieces) = mesh.triangles();
        let normal = |region: u32| mesh.regions[region as usize].frame.normal;
        Self {
            bvh: Bvh::build(&triangles),
            pieces,
            sides: mesh.pieces.iter().map(|p| (p.patches, normal(p.region))).collect(),
            glass: Glass::clear(mesh),
        }
    }

    /// What a person sees along the ray: the nearest side that has a patch. Sides without one are
    /// looked through, as the viewport does by default.
    pub fn pick(&self, ray: &Ray) -> Option<Pick> {
        self.pick_beyond(ray, 0.0)
    }

    /// The same of what lies farther along the ray than this, in multiples of its direction.
    pub fn pick_beyond(&self, ray: &Ray, from: f64) -> Option<Pick> {
        let accept = |triangle: u32| {
            let (patches, normal) = self.sides[self.pieces[triangle as usize] as usize];
            patches[side_towards(normal, ray.direction) as usize] != NO_PATCH
        };
        self.bvh.nearest_where(ray, from, f64::INFINITY, accept).map(|hit| self.describe(ray, hit))
    }

    /// The panes of glass of the mesh.
    pub fn glass(&self) -> &Glass {
        &self.glass
    }

    /// The nearest surface within `max` multiples of the direction, whether or not it has a patch:
    /// what a walker bumps into.
    pub fn nearest(&self, ray: &Ray, max: f64) -> Option<Pick> {
        self.bvh.nearest(ray, 0.0, max).map(|hit| self.describe(ray, hit))
    }

    /// The patches that the camera sees, one for each ray of a grid of `grid` (across, down) over
    /// the picture. Rays that meet nothing are left out: the list serves to meter a view.
    pub fn seen_patches(&self, camera: &Camera, size_px: [u32; 2], grid: [u32; 2]) -> Vec<u32> {
        let size = DVec2::new(f64::from(size_px[0]), f64::from(size_px[1]));
        let cells = DVec2::new(f64::from(grid[0]), f64::from(grid[1]));
        (0..grid[0] * grid[1])
            .filter_map(|cell| {
                let at = DVec2::new(f64::from(cell % grid[0]), f64::from(cell / grid[0])) + 0.5;
                self.pick(&camera.ray(at / cells * size, size_px))?.patch
            })
            .collect()
    }

    fn describe(&self, ray: &Ray, hit: crate::geometry::Hit) -> Pick {
        let piece = self.pieces[hit.triangle as usize];
        let (patches, normal) = self.sides[piece as usize];
        let side = side_towards(normal, ray.direction);
        let patch = patches[side as usize];
        Pick {
            patch: (patch != NO_PATCH).then_some(patch),
            piece,
            triangle: hit.triangle,
            barycentric: [hit.u, hit.v],
            side,
            position: ray.origin + ray.direction * hit.distance,
            distance: hit.distance,
            normal: normal * side.sign(),
        }
    }
}

/// The side of a plane that a ray in this direction meets.
fn side_towards(normal: DVec3, direction: DVec3) -> Side {
    if normal.dot(direction) <= 0.0 { Side::Front } else { Side::Back }
}
