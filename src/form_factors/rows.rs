//! Computes rows by the chosen method.

use super::closed_form::point_to_polygon;
use super::convex::{ConvexRows, ConvexScratch};
use super::receiving::{ReceivingPoints, points_of, points_of_cluster};
use super::{Fan, Hemicube, HemicubeSampler, LineSampler, Method, Row, RowBuffer, Viewpoint, ray_rows};
use crate::effects;
use crate::geometry::Frame;
use crate::mesh::{PatchMesh, Piece, Side};
use crate::visibility::{Occluders, RayScene, Viewer};
use crate::watch::Cancelled;
use glam::DVec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Computes rows of form factors for one mesh, method and resolution.
#[derive(Clone, Debug)]
pub struct RowComputer {
    mesh: Arc<PatchMesh>,
    occluders: Occluders,
    rays: RayScene,
    sampler: Sampler,
    sampling: Sampling,
    points: ReceivingPoints,
    visibility: bool,
    /// Without occlusion, whether nothing can stand between two points inside, so that only points outside
    /// have something hidden from them.
    is_convex: bool,
    /// Without occlusion, where nothing lies behind anything.
    convex: Option<ConvexRows>,
    /// Rows of patches and points computed so far, by all clones together.
    computed: Arc<AtomicU64>,
}

/// The fans of the line method.
#[derive(Clone, Debug)]
struct Fans {
    /// For a patch gathered at its centre.
    full: Fan,
    /// For each of four points of a patch, and of more.
    coarse: Fan,
    coarser: Fan,
    /// For a lamp, whose rows light the first picture.
    fine: Fan,
}

/// What a row is gathered for.
#[derive(Clone, Copy)]
enum Purpose {
    Centre,
    OneOf(ReceivingPoints),
    Lamp,
    FreePoint,
    /// One of so many of a cluster.
    Facet(u32),
}

#[derive(Clone, Debug)]
enum Sampler {
    Lines(Fans),
    /// With whether it is turned from patch to patch.
    Hemicube(Hemicube, bool),
    Rays(u32),
}

/// How rows are gathered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sampling {
    /// By what method.
    pub method: Method,
    /// Half-planes, cells along an edge or rays a row; `None` takes the method's default.
    pub resolution: Option<u32>,
    /// At how many points of a patch.
    pub points: ReceivingPoints,
}

/// Rays that stand in for the usual number of half-planes where facets are many.
const RAYS: u32 = 2048;
/// Points of a cluster that its row is gathered at, by rays and by hemicubes.
const CLUSTER_POINTS: [u32; 2] = [16, 4];

/// Rays that stand in for so many half-planes.
fn rays_for(half_planes: u32) -> u32 {
    let usual = Method::Lines.default_resolution();
    (f64::from(half_planes) / f64::from(usual) * f64::from(RAYS)).ceil() as u32
}

/// How many times as many half-planes a lamp's row has.
const LAMP_FINER: u32 = 4;
/// How many times as many half-planes each of four receiving points has, and of more: their patterns
/// add up.
const COARSE: f64 = 0.67;
const COARSER: f64 = 0.5;
/// A centre that misses more than this of its row may lie under something.
const HIDDEN: f64 = 0.01;

/// Free points are lifted by this share of the scene's size, by these metres if that is more, but never by more than
/// the last share.
const LIFT: f64 = 2e-6;
const ROUNDING: f64 = 1e-5;
const MOST_LIFT: f64 = 1e-5;
/// What is seen by less than this, of a row that sums to one, is seen through the rounding of a seam.
const SEAM: f64 = 1e-12;

/// Working memory of one thread.
#[derive(Clone, Debug)]
pub struct RowScratch {
    lines: LineSampler,
    hemicube: HemicubeSampler,
    convex: ConvexScratch,
    row: RowBuffer,
}

impl RowComputer {
    /// Prepares tables and acceleration structures.
    ///
    /// `visibility` off takes every pair that faces each other as fully visible and uses closed
    /// forms alone: right only where [`crate::effects::Effect::Visibility`] is not called for.
    pub fn new(mesh: Arc<PatchMesh>, sampling: Sampling, visibility: bool) -> Self {
        match Self::new_unless(mesh, sampling, visibility, &|| false) {
            Ok(computer) => computer,
            Err(Cancelled) => unreachable!("nobody ends it"),
        }
    }

    /// As [`Self::new`]; asks every few milliseconds whether to end.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn new_unless(
        mesh: Arc<PatchMesh>,
        sampling: Sampling,
        visibility: bool,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        let Sampling { method, resolution, points } = sampling;
        let resolution = resolution.unwrap_or(method.default_resolution());
        let sampler = match method {
            // Lines pay for every region before a point, rays for the depth of a tree.
            Method::Lines if !mesh.clusters.is_empty() => Sampler::Rays(rays_for(resolution)),
            Method::Lines => Sampler::Lines(Fans {
                full: Fan::new(resolution),
                coarse: Fan::new((f64::from(resolution) * COARSE).ceil() as u32),
                coarser: Fan::new((f64::from(resolution) * COARSER).ceil() as u32),
                fine: Fan::new(resolution.saturating_mul(LAMP_FINER)),
            }),
            Method::Hemicube => Sampler::Hemicube(Hemicube::new(resolution), true),
            Method::AlignedHemicube => Sampler::Hemicube(Hemicube::new(resolution), false),
            Method::Rays => Sampler::Rays(resolution.max(1)),
        };
        Ok(Self {
            occluders: Occluders::new(&mesh, cancelled)?,
            rays: RayScene::new(&mesh, cancelled)?,
            convex: if visibility { None } else { ConvexRows::new(&mesh) },
            is_convex: !visibility && effects::is_convex(&mesh),
            mesh,
            sampler,
            sampling,
            points,
            visibility,
            computed: Arc::default(),
        })
    }

    /// The same as if there were no panes of glass: light passes where they are as through a hole.
    pub fn without_glass(&self) -> Self {
        let mut without = self.clone();
        without.occluders.leave_out_panes();
        without.rays.leave_out_panes();
        without
    }

    /// How many rows it has computed so far, at patches and at free points.
    pub fn rows_computed(&self) -> u64 {
        self.computed.load(Ordering::Relaxed)
    }

    /// The mesh that rows are computed for.
    pub fn mesh(&self) -> &Arc<PatchMesh> {
        &self.mesh
    }

    /// Whether a row misses nothing that lies between two samples: lines find what is small.
    pub(crate) fn misses_nothing(&self) -> bool {
        matches!(self.sampler, Sampler::Lines(..))
    }

    /// How many rows make a batch of a few milliseconds a thread: a matter of method, resolution and
    /// scene alone, so that the order of work never depends on the clock.
    pub fn batch(&self) -> usize {
        let cost: f64 = match &self.sampler {
            Sampler::Lines(fans) => {
                fans.full.len() as f64 / 192.0 * (1.0 + self.occluders.regions.len() as f64 / 1000.0)
            }
            Sampler::Hemicube(cube, _) => 8.0 * (cube.resolution() as f64 / 256.0).powi(2),
            Sampler::Rays(count) => 4.0 * f64::from(*count) / 4096.0,
        };
        let points = match (&self.sampler, self.points) {
            (Sampler::Rays(_), _) => 1.0,
            (_, points) => f64::from(points.count()),
        };
        (96.0 / (cost * points)).clamp(2.0, 256.0) as usize
    }

    /// How rows are gathered.
    pub fn sampling(&self) -> Sampling {
        self.sampling
    }

    /// Rays against the true polygons of the mesh.
    pub fn rays(&self) -> &RayScene {
        &self.rays
    }

    /// Working memory for one thread.
    pub fn scratch(&self) -> RowScratch {
        RowScratch {
            lines: LineSampler::default(),
            hemicube: HemicubeSampler::default(),
            convex: ConvexScratch::default(),
            row: RowBuffer::new(self.mesh.patches.len()),
        }
    }

    /// The row of a patch: gathered at its centre, or at several points where something may stand on that.
    pub fn row(&self, patch: u32, scratch: &mut RowScratch) -> Row {
        self.computed.fetch_add(1, Ordering::Relaxed);
        let p = &self.mesh.patches[patch as usize];
        if p.buried {
            return Row::default();
        }
        if !self.visibility {
            return self.unoccluded_row(patch, scratch);
        }
        if p.is_cluster {
            return self.cluster_row(patch, scratch);
        }
        let frame = self.frame(patch);
        let purpose = if p.luminaire.is_some() { Purpose::Lamp } else { Purpose::Centre };
        let wanted = match self.points {
            ReceivingPoints::One => ReceivingPoints::One,
            // A lamp's own row lights the first picture, and is fine enough for that.
            ReceivingPoints::Four | ReceivingPoints::Sixteen if p.luminaire.is_some() => ReceivingPoints::One,
            ReceivingPoints::Auto => {
                self.gather(p.centre, frame, turn_of(patch), purpose, scratch);
                let row = scratch.row.take();
                // A centre under something that stands on the patch sees but its dark inside.
                let hidden = row.sum() < 1.0 - HIDDEN && self.rays.covered(p.centre, &frame);
                if !hidden {
                    return row;
                }
                ReceivingPoints::Four
            }
            wanted => wanted,
        };
        if wanted == ReceivingPoints::One {
            self.gather(p.centre, frame, turn_of(patch), purpose, scratch);
            return scratch.row.take();
        }
        let mut at = wanted;
        let mut covered = self.covered(patch, at, &frame);
        if self.points == ReceivingPoints::Auto && covered != 0 {
            // Something stands on it: how much of it, and where its shadow begins, takes more points.
            at = ReceivingPoints::Sixteen;
            covered = self.covered(patch, at, &frame);
        }
        let points = self.open_points(patch, at, covered);
        if points.is_empty() {
            // All of it looks at sides that no light reaches, and sees what little is lit beside them alone.
            self.gather(p.centre, frame, turn_of(patch), Purpose::FreePoint, scratch);
            return Row { open: 0.0, ..scratch.row.take() };
        }
        let count = points.len() as f64;
        let open = 1.0 - covered.count_ones() as f32 / at.count() as f32;
        for (k, (point, weight)) in points.into_iter().enumerate() {
            scratch.row.set_weight(weight);
            // The patterns of the points interleave.
            self.gather(point, frame, turn_of(patch) + k as f64 / count, Purpose::OneOf(at), scratch);
        }
        scratch.row.set_weight(1.0);
        Row { points: at, covered, open, ..scratch.row.take() }
    }

    /// The row of a cluster: the mean of those of points of its facets.
    fn cluster_row(&self, patch: u32, scratch: &mut RowScratch) -> Row {
        let count = match self.sampler {
            Sampler::Rays(_) => CLUSTER_POINTS[0],
            Sampler::Lines(_) | Sampler::Hemicube(..) => CLUSTER_POINTS[1],
        };
        let points = points_of_cluster(&self.mesh, &self.mesh.patches[patch as usize], count);
        let is_open = |(point, frame): &&(DVec3, Frame)| !self.rays.covered(*point, frame);
        let open: Vec<(DVec3, Frame)> = points.iter().filter(is_open).copied().collect();
        // Where all lie under something, the little that they see counts, as on other patches.
        let (seen, share) =
            if open.is_empty() { (&points, 0.0) } else { (&open, open.len() as f32 / points.len() as f32) };
        for (k, &(point, frame)) in seen.iter().enumerate() {
            scratch.row.set_weight(1.0 / seen.len() as f64);
            let turn = turn_of(patch) + k as f64 / seen.len() as f64;
            self.gather(point, frame, turn, Purpose::Facet(seen.len() as u32), scratch);
        }
        scratch.row.set_weight(1.0);
        Row { open: share, ..scratch.row.take() }
    }

    /// What a patch sees, coarsely: by so many rays from its centre, whatever the method.
    pub fn coarse_row(&self, patch: u32, rays: u32, scratch: &mut RowScratch) -> Row {
        let own = &self.mesh.patches[patch as usize];
        let pattern = (&Frame::around(own.normal), turn_of(patch));
        ray_rows::gather(&self.rays, rays, own.centre, pattern, Viewer::LitSurface, &mut scratch.row);
        scratch.row.take()
    }

    /// Which of a patch's receiving points lie under something: one bit each.
    fn covered(&self, patch: u32, at: ReceivingPoints, frame: &Frame) -> u32 {
        (0_u32..)
            .zip(points_of(&self.mesh, &self.mesh.patches[patch as usize], at))
            .filter(|(_, (point, _))| self.rays.covered(*point, frame))
            .fold(0, |bits, (k, _)| bits | 1 << k)
    }

    /// The row of a patch as if nothing hid anything: closed forms from its centre.
    pub fn unoccluded_row(&self, patch: u32, scratch: &mut RowScratch) -> Row {
        let p = &self.mesh.patches[patch as usize];
        self.gather_unoccluded(p.centre, p.normal, scratch);
        scratch.row.take()
    }

    /// The receiving points of a patch without those that are `covered` (a bit each), with their shares
    /// of what is left; empty if none is.
    pub(crate) fn open_points(&self, patch: u32, at: ReceivingPoints, covered: u32) -> Vec<(DVec3, f64)> {
        let mut points = points_of(&self.mesh, &self.mesh.patches[patch as usize], at);
        if covered != 0 {
            let mut bits = covered;
            points.retain(|_| {
                let open = bits & 1 == 0;
                bits >>= 1;
                open
            });
            let rest: f64 = points.iter().map(|p| p.1).sum();
            points.iter_mut().for_each(|p| p.1 /= rest);
        }
        points
    }

    /// Form factors from a free point with a unit normal to every patch, in rising order of patches.
    ///
    /// The point is lifted along its normal by 1e-5 of the scene's size: files give points to a few
    /// digits, and one that lies on a surface must not fall behind it.
    pub fn point(&self, point: DVec3, normal: DVec3, scratch: &mut RowScratch, visit: impl FnMut(u32, f64)) {
        self.point_turned(point, normal, 0.0, scratch, visit);
    }

    /// As [`Self::point`], with the pattern of half-planes, cells or rays turned by a share of its period,
    /// 0 to 1: what that changes is an error of sampling.
    pub fn point_turned(
        &self,
        point: DVec3,
        normal: DVec3,
        share: f64,
        scratch: &mut RowScratch,
        mut visit: impl FnMut(u32, f64),
    ) {
        self.computed.fetch_add(1, Ordering::Relaxed);
        let point = self.lifted(point, normal);
        if self.is_hidden_from(point) {
            let turn = (0.618_033_989 + share).fract();
            self.gather(point, Frame::around(normal), turn, Purpose::FreePoint, scratch);
        } else {
            self.gather_unoccluded(point, normal, scratch);
        }
        scratch.row.drain(|patch, factor| {
            if factor > SEAM {
                visit(patch, factor);
            }
        });
    }

    /// Where a free point is gathered: see [`Self::point`].
    pub fn lifted(&self, point: DVec3, normal: DVec3) -> DVec3 {
        // Off the surface that a list with five decimals puts it on or just below, and no farther: near the frame of a
        // window the edge of the sun is half a millimetre wide.
        let size = self.mesh.size;
        point + normal * (LIFT * size).max(ROUNDING).min(MOST_LIFT * size)
    }

    /// Whether something may be hidden from a free point: everywhere where occlusion is simulated, else outside of a
    /// convex room.
    pub fn is_hidden_from(&self, point: DVec3) -> bool {
        self.visibility || self.is_convex && self.lies_outside(point)
    }

    /// Whether a point lies behind a surface of a convex room.
    fn lies_outside(&self, point: DVec3) -> bool {
        let slack = 1e-6 * self.mesh.size;
        self.mesh.regions.iter().any(|region| region.frame.normal.dot(point - region.origin) < -slack)
    }

    fn gather(&self, point: DVec3, frame: Frame, turn: f64, purpose: Purpose, scratch: &mut RowScratch) {
        let viewer = match purpose {
            Purpose::FreePoint => Viewer::Anywhere,
            Purpose::Centre | Purpose::OneOf(_) | Purpose::Facet(_) | Purpose::Lamp => Viewer::LitSurface,
        };
        match &self.sampler {
            Sampler::Lines(fans) => {
                let fan = match purpose {
                    Purpose::Centre | Purpose::FreePoint => &fans.full,
                    Purpose::OneOf(ReceivingPoints::Sixteen) => &fans.coarser,
                    Purpose::OneOf(_) | Purpose::Facet(_) => &fans.coarse,
                    Purpose::Lamp => &fans.fine,
                };
                let from = Viewpoint { point, frame, turn, viewer };
                let scene = (&self.occluders, self.rays.glass());
                scratch.lines.gather(scene, fan, &from, &mut scratch.row, |region, row| {
                    self.add_by_rays(region, point, frame.normal, row)
                });
            }
            Sampler::Hemicube(cube, turned) => {
                // Turned, edges do not run along rows of cells.
                let frame = if *turned { frame.turned(turn * std::f64::consts::TAU) } else { frame };
                let scene = (&*self.mesh, Some(&self.rays).filter(|rays| !rays.glass().is_empty()));
                cube.gather(&mut scratch.hemicube, scene, point, &frame, viewer, &mut scratch.row);
            }
            Sampler::Rays(count) => {
                let count = match purpose {
                    Purpose::OneOf(points) => count.div_ceil(points.count()),
                    Purpose::Facet(points) => count.div_ceil(points),
                    Purpose::Centre | Purpose::Lamp | Purpose::FreePoint => *count,
                };
                ray_rows::gather(&self.rays, count, point, (&frame, turn), viewer, &mut scratch.row);
            }
        }
    }

    /// A lamp so small that it fell between two lines: its patches by closed form and one ray each.
    /// Returns the sum of their form factors.
    fn add_by_rays(&self, region: u32, point: DVec3, normal: DVec3, row: &mut RowBuffer) -> f64 {
        let mut sum = 0.0;
        for index in self.patches_of(region) {
            let patch = &self.mesh.patches[index as usize];
            if patch.luminaire.is_some()
                && patch.normal.dot(point - patch.centre) > 0.0
                && self.rays.visible(point, patch.centre)
            {
                let value = self.unoccluded(point, normal, index);
                row.add(index, value * self.rays.passed(point, patch.centre));
                sum += value;
            }
        }
        sum
    }

    fn patches_of(&self, region: u32) -> Vec<u32> {
        let pieces = self.mesh.regions[region as usize].pieces.clone();
        let mut patches: Vec<u32> = pieces
            .flat_map(|p| self.mesh.pieces[p as usize].patches)
            .filter(|&p| p != crate::mesh::NO_PATCH)
            .collect();
        patches.sort_unstable();
        patches.dedup();
        patches
    }

    fn gather_unoccluded(&self, point: DVec3, normal: DVec3, scratch: &mut RowScratch) {
        let contact = self.occluders.contact();
        if let Some(convex) = &self.convex
            && convex.gather(point, normal, contact, &mut scratch.convex, &mut scratch.row)
        {
            return;
        }
        for (index, patch) in self.mesh.patches.iter().enumerate() {
            if patch.is_cluster || patch.normal.dot(point - patch.centre) > contact {
                let value = self.unoccluded(point, normal, index as u32);
                if value > 0.0 {
                    scratch.row.add(index as u32, value);
                }
            }
        }
    }

    /// Closed form from a point to a whole patch.
    pub fn unoccluded(&self, point: DVec3, normal: DVec3, patch: u32) -> f64 {
        let patch = &self.mesh.patches[patch as usize];
        // Facets of a cluster face this way and that.
        let faces = |piece: &&Piece| {
            !patch.is_cluster || {
                let region = &self.mesh.regions[piece.region as usize];
                self.mesh.normal_of(piece, patch.side).dot(point - region.origin) > self.occluders.contact()
            }
        };
        let whole: f64 = self
            .mesh
            .pieces_of(patch)
            .filter(faces)
            .map(|piece| point_to_polygon(point, normal, &self.mesh.polygon(piece, Side::Front)))
            .sum();
        patch.opacity * whole
    }

    /// A frame that turns with the patch's own surface.
    fn frame(&self, patch: u32) -> Frame {
        let p = &self.mesh.patches[patch as usize];
        let region = &self.mesh.regions[p.region as usize];
        Frame::along(p.normal, region.frame.tangent)
    }
}

/// A turn of the sampling pattern that differs from patch to patch: the golden ratio's multiples, from
/// a start that sets no pattern along the axes of a surface.
fn turn_of(patch: u32) -> f64 {
    (0.513_170_912_5 + 0.618_033_988_749_894_9 * f64::from(patch)).fract()
}
