//! Computes rows by the chosen method.

use super::closed_form::point_to_polygon;
use super::convex::{ConvexRows, ConvexScratch};
use super::{Fan, Hemicube, HemicubeSampler, LineSampler, Method, Occluders, RayScene, Row, RowBuffer};
use crate::geometry::Frame;
use crate::mesh::{Patch, PatchMesh, Side};
use glam::DVec3;
use std::sync::Arc;

/// Computes rows of form factors for one mesh, method and resolution.
#[derive(Clone, Debug)]
pub struct RowComputer {
    mesh: Arc<PatchMesh>,
    occluders: Occluders,
    rays: RayScene,
    sampler: Sampler,
    visibility: bool,
    /// Without occlusion, where nothing lies behind anything.
    convex: Option<ConvexRows>,
    /// One patch of each lamp's regions, to aim shadow rays at.
    lamps: Vec<u32>,
}

/// The fans of the line method.
#[derive(Clone, Debug)]
struct Fans {
    /// For a patch gathered at its centre.
    full: Fan,
    /// For each of the points of a patch gathered at several.
    coarse: Fan,
    /// For a lamp, whose rows light the first picture.
    fine: Fan,
}

/// What a row is gathered for.
#[derive(Clone, Copy)]
enum Purpose {
    Centre,
    OneOfSeveral,
    Lamp,
}

#[derive(Clone, Debug)]
enum Sampler {
    Lines(Fans),
    Hemicube(Hemicube),
    Rays(u32),
}

/// How many times as many half-planes a lamp's row has.
const LAMP_FINER: u32 = 4;
/// How many times as many half-planes each of several receiving points has: their patterns add up.
const SEVERAL_COARSER: f64 = 0.67;

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
    pub fn new(mesh: Arc<PatchMesh>, method: Method, resolution: Option<u32>, visibility: bool) -> Self {
        let resolution = resolution.unwrap_or(method.default_resolution());
        let sampler = match method {
            Method::Lines => Sampler::Lines(Fans {
                full: Fan::new(resolution),
                coarse: Fan::new((resolution as f64 * SEVERAL_COARSER).ceil() as u32),
                fine: Fan::new(resolution.saturating_mul(LAMP_FINER)),
            }),
            Method::Hemicube => Sampler::Hemicube(Hemicube::new(resolution)),
            Method::Rays => Sampler::Rays(resolution.max(1)),
        };
        let mut lamps: Vec<u32> = Vec::new();
        for (index, patch) in mesh.patches.iter().enumerate() {
            let last = lamps.last().map(|&l| &mesh.patches[l as usize]);
            if patch.luminaire.is_some()
                && last.is_none_or(|l| (l.region, l.side) != (patch.region, patch.side))
            {
                lamps.push(index as u32);
            }
        }
        Self {
            occluders: Occluders::new(&mesh),
            rays: RayScene::new(&mesh),
            convex: if visibility { None } else { ConvexRows::new(&mesh) },
            mesh,
            sampler,
            visibility,
            lamps,
        }
    }

    /// The mesh that rows are computed for.
    pub fn mesh(&self) -> &Arc<PatchMesh> {
        &self.mesh
    }

    /// Whether a row misses nothing that lies between two samples: lines find what is small.
    pub(super) fn misses_nothing(&self) -> bool {
        matches!(self.sampler, Sampler::Lines(..))
    }

    /// How many rows make a batch of a few milliseconds a thread: a matter of method, resolution and
    /// scene alone, so that the order of work never depends on the clock.
    pub fn batch(&self) -> usize {
        let cost: f64 = match &self.sampler {
            Sampler::Lines(fans) => {
                fans.full.len() as f64 / 192.0 * (1.0 + self.occluders.regions.len() as f64 / 1000.0)
            }
            Sampler::Hemicube(cube) => 8.0 * (cube.resolution() as f64 / 256.0).powi(2),
            Sampler::Rays(count) => 4.0 * f64::from(*count) / 4096.0,
        };
        (96.0 / cost).clamp(2.0, 256.0) as usize
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

    /// The row of a patch: gathered at its centre, or at several points where a shadow's edge may
    /// cross it.
    pub fn row(&self, patch: u32, scratch: &mut RowScratch) -> Row {
        let p = &self.mesh.patches[patch as usize];
        if p.buried {
            return Row::default();
        }
        if !self.visibility {
            return self.unoccluded_row(patch, scratch);
        }
        let frame = self.frame(patch);
        let purpose = if p.luminaire.is_some() { Purpose::Lamp } else { Purpose::Centre };
        self.gather(p.centre, frame, turn_of(patch), purpose, scratch);
        if !self.crosses_shadow(patch, scratch) {
            return scratch.row.take();
        }
        scratch.row.drain(|_, _| {});
        let covered = (0_u8..)
            .zip(self.receiving_points(patch))
            .filter(|(_, (point, _))| self.rays.covered(*point, &frame))
            .fold(0, |bits, (k, _)| bits | 1 << k);
        let points = self.open_points(patch, covered);
        if points.is_empty() {
            self.gather(p.centre, frame, turn_of(patch), purpose, scratch);
            return scratch.row.take();
        }
        for (k, (point, weight)) in points.into_iter().enumerate() {
            scratch.row.set_weight(weight);
            // The patterns of the points interleave.
            self.gather(point, frame, turn_of(patch) + 0.25 * k as f64, Purpose::OneOfSeveral, scratch);
        }
        scratch.row.set_weight(1.0);
        Row { spread: true, covered, ..scratch.row.take() }
    }

    /// The row of a patch as if nothing hid anything: closed forms from its centre.
    pub fn unoccluded_row(&self, patch: u32, scratch: &mut RowScratch) -> Row {
        let p = &self.mesh.patches[patch as usize];
        self.gather_unoccluded(p.centre, p.normal, scratch);
        scratch.row.take()
    }

    /// Whether some lamp is seen in part from the centre, or from some corners and not from others.
    fn crosses_shadow(&self, patch: u32, scratch: &RowScratch) -> bool {
        let Sampler::Lines(..) = self.sampler else { return false };
        let p = &self.mesh.patches[patch as usize];
        if p.luminaire.is_some() {
            return false;
        }
        if scratch.lines.in_penumbra(&self.occluders) {
            return true;
        }
        let share = |lamp: &Patch, x: DVec3| {
            let to_lamp = lamp.centre - x;
            // In each other's plane they see nothing, whatever rounding says.
            let clear = |height: f64| if height > 1e-7 * to_lamp.length() { height } else { 0.0 };
            let cosines = clear(p.normal.dot(to_lamp)) * clear(-lamp.normal.dot(to_lamp));
            lamp.area * cosines / to_lamp.length_squared().powi(2).max(f64::MIN_POSITIVE)
        };
        let lamps = self.lamps.iter().map(|&l| &self.mesh.patches[l as usize]);
        let shares: Vec<(f64, &Patch)> = lamps.map(|lamp| (share(lamp, p.centre), lamp)).collect();
        let largest = shares.iter().map(|s| s.0).fold(0.0, f64::max);
        let corners: Vec<DVec3> = self
            .mesh
            .pieces_of(p)
            .flat_map(|piece| self.mesh.corners_of(piece))
            .map(|c| p.centre + (self.mesh.vertices[c.vertex as usize] - p.centre) * 0.9)
            .collect();
        shares.iter().filter(|s| s.0 > 0.1 * largest).any(|(_, lamp)| {
            let mut seen = corners.iter().map(|&c| share(lamp, c) > 0.0 && self.rays.visible(c, lamp.centre));
            let first = seen.next();
            seen.any(|s| Some(s) != first)
        })
    }

    /// The receiving points of a patch without those that are `covered` (a bit each), with their shares
    /// of what is left; empty if none is.
    pub(super) fn open_points(&self, patch: u32, covered: u8) -> Vec<(DVec3, f64)> {
        let mut points = self.receiving_points(patch);
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

    /// Points that stand for a patch with their shares of it: 2 x 2 Gauss points of a quadrilateral,
    /// else the middles of the triangles that its pieces fan into, at most 8.
    pub fn receiving_points(&self, patch: u32) -> Vec<(DVec3, f64)> {
        let p = &self.mesh.patches[patch as usize];
        let polygons: Vec<Vec<DVec3>> =
            self.mesh.pieces_of(p).map(|piece| self.mesh.polygon(piece, p.side)).collect();
        if let [quad] = polygons.as_slice()
            && let &[a, b, c, d] = quad.as_slice()
        {
            const NEAR: f64 = 0.211_324_865_405_187_13;
            let at = |s: f64, t: f64| {
                a * (1.0 - s) * (1.0 - t) + b * s * (1.0 - t) + c * s * t + d * (1.0 - s) * t
            };
            return [(NEAR, NEAR), (1.0 - NEAR, NEAR), (1.0 - NEAR, 1.0 - NEAR), (NEAR, 1.0 - NEAR)]
                .map(|(s, t)| (at(s, t), 0.25))
                .to_vec();
        }
        let mut points: Vec<(DVec3, f64)> = Vec::new();
        for polygon in &polygons {
            for k in 1..polygon.len() - 1 {
                let triangle = [polygon[0], polygon[k], polygon[k + 1]];
                let area = crate::geometry::polygon::area_vector(&triangle).length();
                points.push(((triangle[0] + triangle[1] + triangle[2]) / 3.0, area));
            }
        }
        if points.len() > 8 {
            // The largest, where areas that differ by rounding alone count as equal.
            let unit = 1e-9 * p.area;
            points.sort_by_key(|point| std::cmp::Reverse((point.1 / unit) as u64));
            points.truncate(8);
        }
        let total: f64 = points.iter().map(|p| p.1).sum();
        if total <= 0.0 {
            return vec![(p.centre, 1.0)];
        }
        points.iter().map(|&(x, area)| (x, area / total)).collect()
    }

    /// Form factors from a free point with a unit normal to every patch, in rising order of patches.
    ///
    /// The point is lifted along its normal by 1e-5 of the scene's size: files give points to a few
    /// digits, and one that lies on a surface must not fall behind it.
    pub fn point(&self, point: DVec3, normal: DVec3, scratch: &mut RowScratch, visit: impl FnMut(u32, f64)) {
        let point = point + normal * (1e-5 * self.mesh.size);
        if self.visibility {
            self.gather(point, Frame::around(normal), 0.618_033_989, Purpose::Centre, scratch);
        } else {
            self.gather_unoccluded(point, normal, scratch);
        }
        scratch.row.drain(visit);
    }

    fn gather(&self, point: DVec3, frame: Frame, turn: f64, purpose: Purpose, scratch: &mut RowScratch) {
        match &self.sampler {
            Sampler::Lines(fans) => {
                let fan = match purpose {
                    Purpose::Centre => &fans.full,
                    Purpose::OneOfSeveral => &fans.coarse,
                    Purpose::Lamp => &fans.fine,
                };
                scratch.lines.gather(&self.occluders, fan, point, &frame, turn, &mut scratch.row);
                for &region in scratch.lines.missed() {
                    self.add_by_rays(region, point, frame.normal, &mut scratch.row);
                }
            }
            Sampler::Hemicube(cube) => {
                // Turned, so that edges do not run along rows of cells.
                let turned = frame.turned(turn * std::f64::consts::TAU);
                cube.gather(&mut scratch.hemicube, &self.mesh, point, &turned, &mut scratch.row);
            }
            Sampler::Rays(count) => self.rays.gather(*count, point, &frame, turn, &mut scratch.row),
        }
    }

    /// A lamp so small that it fell between two lines: its patches by closed form and one ray each.
    fn add_by_rays(&self, region: u32, point: DVec3, normal: DVec3, row: &mut RowBuffer) {
        for index in self.patches_of(region) {
            let patch = &self.mesh.patches[index as usize];
            if patch.luminaire.is_some()
                && patch.normal.dot(point - patch.centre) > 0.0
                && self.rays.visible(point, patch.centre)
            {
                row.add(index, self.unoccluded(point, normal, index));
            }
        }
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
            if patch.normal.dot(point - patch.centre) > contact {
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
        self.mesh
            .pieces_of(patch)
            .map(|piece| point_to_polygon(point, normal, &self.mesh.polygon(piece, Side::Front)))
            .sum()
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
