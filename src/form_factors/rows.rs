//! Computes rows by the chosen method.

use super::closed_form::point_to_polygon;
use super::{Fan, Hemicube, HemicubeSampler, LineSampler, Method, Occluders, RayScene, Row, RowBuffer};
use crate::geometry::Frame;
use crate::mesh::{PatchMesh, Side};
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
}

#[derive(Clone, Debug)]
enum Sampler {
    /// The fan for all patches and a finer one for those of lamps, whose rows light the first picture.
    Lines(Fan, Fan),
    Hemicube(Hemicube),
    Rays(u32),
}

/// How many times as many half-planes a lamp's row has.
const LAMP_FINER: u32 = 4;

/// Working memory of one thread.
#[derive(Clone, Debug)]
pub struct RowScratch {
    lines: LineSampler,
    hemicube: HemicubeSampler,
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
            Method::Lines => {
                Sampler::Lines(Fan::new(resolution), Fan::new(resolution.saturating_mul(LAMP_FINER)))
            }
            Method::Hemicube => Sampler::Hemicube(Hemicube::new(resolution)),
            Method::Rays => Sampler::Rays(resolution.max(1)),
        };
        Self { occluders: Occluders::new(&mesh), rays: RayScene::new(&mesh), mesh, sampler, visibility }
    }

    /// The mesh that rows are computed for.
    pub fn mesh(&self) -> &Arc<PatchMesh> {
        &self.mesh
    }

    /// How many rows make a batch of a few milliseconds a thread: a matter of method, resolution and
    /// scene alone, so that the order of work never depends on the clock.
    pub fn batch(&self) -> usize {
        let cost = match &self.sampler {
            Sampler::Lines(fan, _) => {
                fan.len() as f64 / 192.0 * (1.0 + self.occluders.regions.len() as f64 / 1000.0)
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
            row: RowBuffer::new(self.mesh.patches.len()),
        }
    }

    /// The row of a patch, gathered at its centre.
    pub fn row(&self, patch: u32, scratch: &mut RowScratch) -> Row {
        let p = &self.mesh.patches[patch as usize];
        if self.visibility {
            self.gather(p.centre, self.frame(patch), turn_of(patch), p.luminaire.is_some(), scratch);
        } else {
            self.gather_unoccluded(p.centre, p.normal, scratch);
        }
        scratch.row.take()
    }

    /// Form factors from a free point with a unit normal to every patch, in rising order of patches.
    pub fn point(&self, point: DVec3, normal: DVec3, scratch: &mut RowScratch, visit: impl FnMut(u32, f64)) {
        if self.visibility {
            self.gather(point, Frame::around(normal), 0.5, false, scratch);
        } else {
            self.gather_unoccluded(point, normal, scratch);
        }
        scratch.row.drain(visit);
    }

    fn gather(&self, point: DVec3, frame: Frame, turn: f64, lamp: bool, scratch: &mut RowScratch) {
        match &self.sampler {
            Sampler::Lines(fan, finer) => {
                let fan = if lamp { finer } else { fan };
                scratch.lines.gather(&self.occluders, fan, point, &frame, turn, &mut scratch.row);
                for &region in scratch.lines.missed() {
                    self.add_by_rays(region, point, frame.normal, &mut scratch.row);
                }
            }
            Sampler::Hemicube(cube) => {
                cube.gather(&mut scratch.hemicube, &self.mesh, point, &frame, &mut scratch.row);
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

/// A turn of the sampling pattern that differs from patch to patch: the golden ratio's multiples.
fn turn_of(patch: u32) -> f64 {
    (0.5 + 0.618_033_988_749_894_9 * f64::from(patch)).fract()
}
