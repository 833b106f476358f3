use super::backing::Backing;
use super::clusters::Clusters;
use super::convex_parts::ConvexParts;
use super::panes::Panes;
use super::translucence::Translucence;
use crate::geometry::{Aabb, Frame};
use crate::scene::{Outdoors, PhotometricSource, grouped};
use glam::{DVec2, DVec3};
use std::ops::Range;
use std::sync::Arc;

/// Stands for "no patch" in patch indices.
pub const NO_PATCH: u32 = u32::MAX;

/// A side of a surface. The front is the one from which the corners run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Side {
    /// Towards the normal.
    Front = 0,
    /// Against the normal.
    Back = 1,
}

impl Side {
    /// +1 for the front, -1 for the back.
    pub fn sign(self) -> f64 {
        match self {
            Self::Front => 1.0,
            Self::Back => -1.0,
        }
    }
}

/// A planar piece of the scene that occludes as one: one surface, or coplanar neighbours joined.
#[derive(Clone, Debug)]
pub struct Region {
    /// Origin of the plane coordinates (u, v), in metres.
    pub origin: DVec3,
    /// Axes of the plane coordinates: tangent is u, bitangent is v, normal is the front's.
    pub frame: Frame,
    /// Directed edges of the outline in plane coordinates, metres; inside lies left of each.
    /// Holes and several loops need no order: a line's crossings are paired by parity.
    pub edges: Vec<[DVec2; 2]>,
    /// Lower corner of the patch grid in plane coordinates.
    pub grid_min: DVec2,
    /// Edge lengths of a grid cell, metres; above zero.
    pub cell_size: DVec2,
    /// Cells along u and v, at least one each.
    pub cells: [u32; 2],
    /// Where this region's cells start in [`PatchMesh::cell_pieces`]; cell (i, j) is `i + j * cells[0]`.
    pub first_cell: u32,
    /// The pieces of this region in [`PatchMesh::pieces`].
    pub pieces: Range<u32>,
    /// Index into the scene's materials.
    pub material: u32,
    /// Index into the scene's objects.
    pub object: u32,
    /// A box around it, metres.
    pub bounds: Aabb,
    /// Area of one side, m².
    pub area: f64,
    /// For front and back whether no light reaches that side, so that nothing lit ever sees it.
    pub dark: [bool; 2],
    /// The same where it is so of all that hangs together with the region along edges: direct light, which has no sums to
    /// keep, is not let through a side that a few paths of light may have missed.
    pub dark_as_whole: [bool; 2],
    /// How much of its back is covered by others that lie there and face that way.
    pub backing: Backing,
    /// Its image has holes: its pieces stand among the panes, which dim, and hide nothing by themselves.
    pub has_holes: bool,
}

/// A convex part of a surface inside one grid cell: what is drawn, and what a line of sight meets.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The region that it is a part of.
    pub region: u32,
    /// The input surface that it is a part of.
    pub surface: u32,
    /// Its corners in [`PatchMesh::corners`], counter-clockwise from the front; three or more.
    pub corners: Range<u32>,
    /// The patch on its front and on its back; [`NO_PATCH`] where that side takes no part.
    pub patches: [u32; 2],
    /// Another surface lies on its back and faces that way, so that its back is never seen.
    pub backed: bool,
    /// Area of one side, m².
    pub area: f64,
}

/// A corner of a [`Piece`].
#[derive(Clone, Copy, Debug)]
pub struct PieceCorner {
    /// Index into [`PatchMesh::vertices`]; neighbours on one region share it.
    pub vertex: u32,
    /// Plane coordinates in the region, metres.
    pub plane: DVec2,
    /// Unit normal on the front: the region's, or the smooth surface's own here.
    pub normal: DVec3,
    /// Texture coordinates; zero where the surface has none.
    pub uv: DVec2,
}

/// One unknown of the system: a part of one side of a region, of one reflectance and radiosity; or a cluster, small
/// facets of many regions that share these.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The region that it lies on; of a cluster that of the facet which stands for it.
    pub region: u32,
    /// The side that it lies on; all facets of a cluster have that in common.
    pub side: Side,
    /// The input surface that most of it belongs to; of a cluster the facet which stands for it.
    pub surface: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// Index into the scene's luminaires where it emits.
    pub luminaire: Option<u32>,
    /// Its pieces in [`PatchMesh::patch_pieces`].
    pub pieces: Range<u32>,
    /// Where rows are gathered, metres: the centroid, or another point of the patch where the centroid
    /// lies outside of it or under something.
    pub centre: DVec3,
    /// Unit normal of its side at `centre`.
    pub normal: DVec3,
    /// Area of what is opaque of it, m².
    pub area: f64,
    /// Share of it that is opaque, above 0 to 1: below 1 only on surfaces with holes.
    pub opacity: f64,
    /// Reflectance per band, averaged over the patch where textured; 0 to `MAX_REFLECTANCE`.
    pub reflectance: [f64; 3],
    /// Mean of the texture over the patch per band, 0 to 1; 1 without a texture. The material's
    /// reflectance is a factor to it.
    pub texture_average: [f64; 3],
    /// Exitance per band relative to that of its luminaire; zero where it does not emit.
    pub emission_weight: [f64; 3],
    /// It lies under something that stands on its surface, out of all light; what a lamp sends out there
    /// counts as escaped.
    pub buried: bool,
    /// Many small facets share it, each with a plane of its own.
    pub is_cluster: bool,
    /// Radius of the smallest sphere around `centre` that holds the patch, metres.
    pub radius: f64,
}

impl Patch {
    /// Area within its outline, holes included, m².
    pub fn outline_area(&self) -> f64 {
        self.area / self.opacity
    }
}

/// The scene cut into patches.
#[derive(Clone, Debug, Default)]
pub struct PatchMesh {
    /// Positions, metres.
    pub vertices: Vec<DVec3>,
    /// Corners of all pieces.
    pub corners: Vec<PieceCorner>,
    /// All pieces, ordered by region and cell.
    pub pieces: Vec<Piece>,
    /// All regions.
    pub regions: Vec<Region>,
    /// All patches.
    pub patches: Vec<Patch>,
    /// Piece indices of each patch, one range a patch.
    pub patch_pieces: Vec<u32>,
    /// For each cell of each region its range in [`PatchMesh::piece_lists`].
    pub cell_pieces: Vec<Range<u32>>,
    /// Indices of the pieces that overlap a cell.
    pub piece_lists: Vec<u32>,
    /// Large convex parts of surfaces by falling area: what hides most of a scene. Corners, metres.
    pub blockers: Vec<Vec<DVec3>>,
    /// All surfaces as convex polygons.
    pub convex: ConvexParts,
    /// For each region the segments, in its plane coordinates, along which other surfaces stand on
    /// it: the light may jump there. Empty where regions were not cut along them.
    pub contacts: Vec<Vec<[DVec2; 2]>>,
    /// What small facets share, where there are too many for a patch each.
    pub clusters: Clusters,
    /// Luminaires that shine by their photometry, lamp by lamp: the patches of these lamps glow in the picture and
    /// light nothing.
    pub photometric: Vec<PhotometricSource>,
    /// Surfaces of glass, which are no regions.
    pub panes: Arc<Panes>,
    /// Which patches pass light diffusely from one side to the other.
    pub translucence: Arc<Translucence>,
    /// The sky over the scene and the sun in it, where there is daylight.
    pub outdoors: Option<Arc<Outdoors>>,
    /// The middle of the main part of the scene, metres.
    pub middle: DVec3,
    /// The length that tolerances are shares of, metres: [`crate::scene::Extent::scale`].
    pub size: f64,
    /// Counts and shapes.
    pub statistics: MeshStatistics,
}

impl PatchMesh {
    /// Whether the light of a luminaire is that of its photometry, not of its patches.
    pub fn is_photometric(&self, luminaire: u32) -> bool {
        self.photometric.binary_search_by_key(&luminaire, |source| source.luminaire).is_ok()
    }

    /// Whether a luminaire is the sky or the sun.
    pub fn is_outdoors(&self, luminaire: u32) -> bool {
        self.outdoors.as_ref().is_some_and(|out| luminaire == out.sky || luminaire == out.sun)
    }

    /// Pieces of a patch.
    pub fn pieces_of<'a>(&'a self, patch: &Patch) -> impl Iterator<Item = &'a Piece> + use<'a> {
        let range = patch.pieces.start as usize..patch.pieces.end as usize;
        self.patch_pieces[range].iter().map(|&p| &self.pieces[p as usize])
    }

    /// Corners of a piece.
    pub fn corners_of(&self, piece: &Piece) -> &[PieceCorner] {
        &self.corners[piece.corners.start as usize..piece.corners.end as usize]
    }

    /// Unit normal of a piece on `side`.
    pub fn normal_of(&self, piece: &Piece, side: Side) -> DVec3 {
        self.regions[piece.region as usize].frame.normal * side.sign()
    }

    /// Corner positions of a piece, counter-clockwise as seen from `side`, metres.
    pub fn polygon(&self, piece: &Piece, side: Side) -> Vec<DVec3> {
        let front = self.corners_of(piece).iter().map(|c| self.vertices[c.vertex as usize]);
        match side {
            Side::Front => front.collect(),
            Side::Back => front.rev().collect(),
        }
    }

    /// All pieces as triangles (fans), each with the index of its piece.
    pub fn triangles(&self) -> (Vec<[DVec3; 3]>, Vec<u32>) {
        let (mut triangles, mut pieces) = (Vec::new(), Vec::new());
        for (index, piece) in self.pieces.iter().enumerate() {
            let corners = self.corners_of(piece);
            let at = |k: usize| self.vertices[corners[k].vertex as usize];
            for k in 1..corners.len() - 1 {
                triangles.push([at(0), at(k), at(k + 1)]);
                pieces.push(index as u32);
            }
        }
        (triangles, pieces)
    }
}

/// Counts and shapes of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshStatistics {
    /// Patches in all.
    pub patches: usize,
    /// Patches that emit.
    pub emitters: usize,
    /// Joined planar regions.
    pub regions: usize,
    /// Input surfaces.
    pub surfaces: usize,
    /// Sides that take no part because no light can reach them.
    pub dark_sides: usize,
    /// Surfaces dropped for want of area.
    pub dropped: usize,
    /// Total area of all patches, m².
    pub area: f64,
    /// Smallest patch, m².
    pub smallest_area: f64,
    /// Largest patch, m².
    pub largest_area: f64,
    /// Median over patches of (longest extent)² / area; 1 for a square, counted on its own axes.
    pub median_aspect: f64,
    /// Largest of these.
    pub worst_aspect: f64,
    /// The edge length that was aimed at, metres.
    pub patch_size: f64,
    /// The number of patches that was asked for, where it was a number.
    pub asked: Option<usize>,
    /// Sides of surfaces no larger than a patch of that edge that have a patch of their own each.
    pub whole_sides: usize,
    /// Patches that sides of small surfaces share, and how many sides share them.
    pub clusters: usize,
    /// Sides of small surfaces that share those.
    pub clustered_sides: usize,
}

impl MeshStatistics {
    /// Where small faces share patches, one sentence that says so.
    pub fn clustering(&self) -> Option<String> {
        let told = |n: usize| grouped(n as i64);
        (self.clusters > 0).then(|| {
            format!(
                "{} sides of small faces share {} patches (clusters of one material, place and direction); \
                 interreflected light is gathered by rays, which cost less than lines among so many faces",
                told(self.clustered_sides),
                told(self.clusters)
            )
        })
    }

    /// Where the mesh has far more patches than were asked for, one sentence that says why.
    pub fn excess(&self) -> Option<String> {
        /// Numbers are only about met: a mesh of so many times as many is explained, and so is what takes so
        /// large a share of the number.
        const MUCH: f64 = 1.25;
        const SHARE: f64 = 0.125;
        let asked = self.asked.filter(|&asked| self.patches as f64 > MUCH * asked as f64)?;
        let more = self.patches.saturating_sub(asked + self.whole_sides);
        let counts = |n: usize| n as f64 > SHARE * asked as f64;
        let told = |n: usize| grouped(n as i64);
        let whole = format!("{} sides of small faces need one each", told(self.whole_sides));
        let others = format!("narrow faces and faces that others touch take {} more", told(more));
        let reasons: Vec<String> = [(self.whole_sides, whole), (more, others)]
            .into_iter()
            .filter(|(n, _)| counts(*n))
            .map(|(_, reason)| reason)
            .collect();
        Some(format!(
            "{} patches were asked for; {}, so the mesh has {}",
            told(asked),
            reasons.join(" and "),
            told(self.patches)
        ))
    }
}
