//! The hemicube of 1985: patches projected onto five faces, an item buffer with depth, and a table
//! of delta form factors.

use super::ray_rows::without_dark;
use super::row::RowBuffer;
use crate::geometry::{Frame, Ray};
use crate::mesh::{Backing, NO_PATCH, PatchMesh};
use crate::visibility::{RayScene, THICKNESS, Viewer};
use glam::DVec3;

/// The top and four half faces.
pub(super) const FACES: usize = 5;

/// Stands for a side that no light reaches.
pub(super) const DARK: u32 = NO_PATCH - 1;

/// Delta form factors of a unit hemicube with `resolution` cells along an edge.
#[derive(Clone, Debug)]
pub struct Hemicube {
    resolution: usize,
    /// Top face, row by row; `resolution²` values.
    top: Vec<f64>,
    /// A side face, upper half, from the top edge down; `resolution / 2 * resolution` values.
    side: Vec<f64>,
}

/// Item and depth buffers of one thread.
#[derive(Clone, Debug, Default)]
pub struct HemicubeSampler {
    pub(super) items: Vec<u32>,
    depths: Vec<f64>,
    polygon: Vec<DVec3>,
    clipped: Vec<DVec3>,
}

impl Hemicube {
    /// Tables for an even `resolution` of at least 2 (odd ones are rounded up).
    ///
    /// Each cell is integrated exactly: centre samples of the published delta form factors do not
    /// sum to one. The integral over a rectangle is that of a point to a rectangle.
    pub fn new(resolution: u32) -> Self {
        let n = (resolution.max(2) as usize).next_multiple_of(2);
        let line = |k: usize| 2.0 * k as f64 / n as f64 - 1.0;
        // Integral of 1 / (pi (x² + y² + 1)²) over 0..x, 0..y.
        let top_corner = |x: f64, y: f64| {
            let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
            (x / a * (y / a).atan() + y / b * (x / b).atan()) / std::f64::consts::TAU
        };
        // Integral of z / (pi (y² + z² + 1)²) over 0..y, 0..z.
        let side_corner = |y: f64, z: f64| {
            let a = (1.0 + z * z).sqrt();
            (y.atan() - (y / a).atan() / a) / std::f64::consts::TAU
        };
        let cell = |f: &dyn Fn(f64, f64) -> f64, x: [f64; 2], y: [f64; 2]| {
            f(x[1], y[1]) - f(x[0], y[1]) - f(x[1], y[0]) + f(x[0], y[0])
        };
        let mut top = Vec::with_capacity(n * n);
        let mut side = Vec::with_capacity(n * n / 2);
        for j in 0..n {
            for i in 0..n {
                top.push(cell(&top_corner, [line(i), line(i + 1)], [line(j), line(j + 1)]));
            }
        }
        for j in n / 2..n {
            for i in 0..n {
                side.push(cell(&side_corner, [line(i), line(i + 1)], [line(j), line(j + 1)]));
            }
        }
        Self { resolution: n, top, side }
    }

    /// Cells along an edge of the top face.
    pub fn resolution(&self) -> usize {
        self.resolution
    }

    /// Sums of the top face and of one side face.
    pub fn face_sums(&self) -> (f64, f64) {
        (self.top.iter().sum(), self.side.iter().sum())
    }

    /// Adds the form factors from `point` to every patch to `row`, which is empty; where there is glass, `rays` look for
    /// what it leaves and mirrors. Cells that show a dark
    /// side count for nothing to a lit surface, which sees none.
    pub fn gather(
        &self,
        sampler: &mut HemicubeSampler,
        (mesh, rays): (&PatchMesh, Option<&RayScene>),
        point: DVec3,
        frame: &Frame,
        viewer: Viewer,
        row: &mut RowBuffer,
    ) {
        let mut dark = 0.0;
        for face in 0..FACES {
            self.draw(sampler, mesh, point, frame, face);
            for (cell, (&patch, &delta)) in sampler.items.iter().zip(self.deltas(face)).enumerate() {
                let met = (patch < DARK).then_some(patch);
                if patch == DARK {
                    dark += delta;
                }
                match (rays, met) {
                    (None, Some(patch)) => row.add(patch, delta),
                    (None, None) => {}
                    (Some(rays), met) => {
                        let to = self.towards(face, cell, frame);
                        // A cell that was closed from its neighbour has no depth, and is behind whatever it meets.
                        let distance = to.length() / sampler.depths[cell].max(f64::MIN_POSITIVE);
                        let ray = Ray { origin: point, direction: to.normalize_or_zero() };
                        rays.by_glass(&ray, (met, distance), |patch, share| row.add(patch, delta * share));
                    }
                }
            }
        }
        if viewer == Viewer::LitSurface {
            row.scale(without_dark(dark));
        }
    }

    /// The direction of the middle of a cell of a face, as long as its outward part is 1.
    fn towards(&self, face: usize, cell: usize, frame: &Frame) -> DVec3 {
        let n = self.resolution;
        let (right, rise, out) = axes(face, frame);
        let lowest = if face == 0 { -1.0 } else { 0.0 };
        let scale = 2.0 / n as f64;
        let (x, y) = ((cell % n) as f64 + 0.5, (cell / n) as f64 + 0.5);
        out + right * (scale * x - 1.0) + rise * (scale * y + lowest)
    }

    /// Draws what `point` sees through one face into the sampler's item buffer, row by row.
    ///
    /// Face 0 is the top: columns along the tangent, rows along the bitangent. Faces 1 to 4 stand
    /// upright at its edges along +bitangent, -bitangent, +tangent and -tangent: columns along the
    /// tangent, the tangent, the bitangent and the bitangent, rows from the horizon upwards.
    pub(super) fn draw(
        &self,
        sampler: &mut HemicubeSampler,
        mesh: &PatchMesh,
        point: DVec3,
        frame: &Frame,
        face: usize,
    ) {
        let n = self.resolution;
        let contact = 1e-9 * mesh.size;
        let (right, rise, out) = axes(face, frame);
        let rows = if face == 0 { n } else { n / 2 };
        sampler.items.clear();
        sampler.items.resize(rows * n, NO_PATCH);
        sampler.depths.clear();
        sampler.depths.resize(rows * n, 0.0);
        let lowest = if face == 0 { -1.0 } else { 0.0 };
        for piece in &mesh.pieces {
            let region = &mesh.regions[piece.region as usize];
            if region.has_holes {
                continue;
            }
            let height = region.frame.normal.dot(point - region.origin);
            if height.abs() <= contact {
                continue;
            }
            let side = usize::from(height < 0.0);
            // What lies on its back is seen instead of it, and sees nothing of it.
            let is_on_it =
                height.abs() <= THICKNESS * mesh.size && region.frame.normal.dot(frame.normal) < -0.99;
            if (piece.backed && side == 1) || (region.backing != Backing::None && is_on_it) {
                continue;
            }
            let patch = if region.dark[side] { DARK } else { piece.patches[side] };
            sampler.polygon.clear();
            sampler.polygon.extend(mesh.corners_of(piece).iter().map(|c| {
                let p = mesh.vertices[c.vertex as usize] - point;
                DVec3::new(right.dot(p), rise.dot(p), out.dot(p))
            }));
            // A black side occludes as any other; it is told apart from an empty cell by depth.
            sampler.project(lowest, rows, n, patch);
        }
        sampler.close_seams(n);
    }

    /// Delta form factors of a face's cells, in the order of [`Self::draw`].
    pub(super) fn deltas(&self, face: usize) -> &[f64] {
        if face == 0 { &self.top } else { &self.side }
    }
}

/// Axes of a face: right, down the rows, outwards.
fn axes(face: usize, frame: &Frame) -> (DVec3, DVec3, DVec3) {
    let (t, b, up) = (frame.tangent, frame.bitangent, frame.normal);
    [(t, b, up), (t, up, b), (t, up, -b), (b, up, t), (b, up, -t)][face]
}

impl HemicubeSampler {
    /// Gives cells that fell through the seam of two surfaces to a neighbour: those which nothing met
    /// although something stands on both sides of them. A gap so narrow is beneath the resolution.
    fn close_seams(&mut self, n: usize) {
        let rows = self.depths.len() / n;
        let empty = |cell: usize| self.depths[cell] == 0.0;
        let mended: Vec<(usize, u32)> = (0..self.depths.len())
            .filter(|&cell| empty(cell))
            .filter_map(|cell| {
                let (j, i) = (cell / n, cell % n);
                // Past the rim of the face something stands too, as far as this face can tell.
                let stands = |at: Option<usize>| at.is_none_or(|at| !empty(at));
                let pairs = [
                    [(i > 0).then(|| cell - 1), (i + 1 < n).then_some(cell + 1)],
                    [(j > 0).then(|| cell - n), (j + 1 < rows).then_some(cell + n)],
                ];
                let [one, other] = pairs.into_iter().find(|&[a, b]| stands(a) && stands(b))?;
                let one = one.or(other)?;
                Some((cell, self.items[one]))
            })
            .collect();
        for (cell, item) in mended {
            self.items[cell] = item;
        }
    }

    /// Clips the polygon to the face's pyramid and enters it where a cell's centre lies in it and
    /// nothing nearer stands.
    fn project(&mut self, lowest: f64, rows: usize, n: usize, patch: u32) {
        if self.polygon.iter().all(|p| p.z <= 0.0) {
            return;
        }
        let planes = [
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(-1.0, 0.0, 1.0),
            DVec3::new(0.0, 1.0, -lowest),
            DVec3::new(0.0, -1.0, 1.0),
        ];
        for plane in planes {
            let inside = |p: &DVec3| plane.dot(*p);
            if self.polygon.iter().all(|p| inside(p) < 0.0) {
                return;
            }
            self.clipped.clear();
            let count = self.polygon.len();
            for i in 0..count {
                let (p, q) = (self.polygon[i], self.polygon[(i + 1) % count]);
                let (fp, fq) = (inside(&p), inside(&q));
                if fp >= 0.0 {
                    self.clipped.push(p);
                }
                if (fp > 0.0 && fq < 0.0) || (fp < 0.0 && fq > 0.0) {
                    self.clipped.push(p + (q - p) * (fp / (fp - fq)));
                }
            }
            std::mem::swap(&mut self.polygon, &mut self.clipped);
        }
        if self.polygon.len() < 3 || self.polygon.iter().any(|p| p.z <= 0.0) {
            return;
        }
        // Cells per unit of x / z, and the plane's 1 / z, linear on the face.
        let scale = 0.5 * n as f64;
        let normal = crate::geometry::polygon::area_vector(&self.polygon);
        let offset = normal.dot(self.polygon[0]);
        if offset == 0.0 {
            return;
        }
        let to_cells = |p: &DVec3| (scale * (p.x / p.z + 1.0), scale * (p.y / p.z - lowest));
        let points: Vec<(f64, f64)> = self.polygon.iter().map(to_cells).collect();
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.1), h.max(p.1)));
        let first = (low - 0.5).ceil().max(0.0) as usize;
        let end = ((high - 0.5).ceil().max(0.0) as usize).min(rows);
        for j in first..end {
            let y = j as f64 + 0.5;
            let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..points.len() {
                let (p, q) = (points[i], points[(i + 1) % points.len()]);
                if (p.1 <= y) != (q.1 <= y) {
                    let x = p.0 + (q.0 - p.0) * ((y - p.1) / (q.1 - p.1));
                    from = from.min(x);
                    to = to.max(x);
                }
            }
            let columns = (from - 0.5).ceil().max(0.0) as usize..((to - 0.5).ceil().max(0.0) as usize).min(n);
            for i in columns {
                let x = (i as f64 + 0.5) / scale - 1.0;
                let depth = (normal.x * x + normal.y * (y / scale + lowest) + normal.z) / offset;
                let cell = j * n + i;
                if depth > self.depths[cell] {
                    self.depths[cell] = depth;
                    self.items[cell] = patch;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_faces_sum_to_one_at_every_resolution() {
        for resolution in [2, 32, 50, 256] {
            let (top, side) = Hemicube::new(resolution).face_sums();
            assert!((top - 0.554126423979572).abs() < 1e-12, "{top}");
            assert!((side - 0.111468394005107).abs() < 1e-12, "{side}");
        }
    }
}
