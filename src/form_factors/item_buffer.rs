//! What a hemicube sees, cell by cell, unfolded into a cross to be looked at.

use super::hemicube::{DARK, FACES, Hemicube, HemicubeSampler};
use crate::geometry::Frame;
use crate::mesh::{NO_PATCH, PatchMesh};
use glam::DVec3;

/// The item buffers of all five faces with their delta form factors.
///
/// Unfolded, the faces make a cross in a square of twice the resolution: the top in the middle, the
/// four half faces around it, their upper edges towards it. Columns run along the frame's tangent
/// and rows along its bitangent: what one sees looking out along the normal with the tangent to the
/// right.
#[derive(Clone, Debug)]
pub struct ItemBuffer {
    hemicube: Hemicube,
    /// Face by face in the order of [`Hemicube`].
    items: [Vec<u32>; FACES],
}

/// A cell of a hemicube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ItemCell {
    /// The patch that it sees; `None` for the open, and for a side that takes no part.
    pub patch: Option<u32>,
    /// Its delta form factor: the fraction of a diffuse patch's power that leaves through it.
    pub delta: f64,
}

impl ItemBuffer {
    /// Draws what `point` sees. `resolution` as in [`Hemicube::new`].
    pub fn draw(mesh: &PatchMesh, point: DVec3, frame: &Frame, resolution: u32) -> Self {
        let hemicube = Hemicube::new(resolution);
        let mut sampler = HemicubeSampler::default();
        let items = std::array::from_fn(|face| {
            hemicube.draw(&mut sampler, mesh, point, frame, face);
            let mut items = std::mem::take(&mut sampler.items);
            items.iter_mut().filter(|item| **item == DARK).for_each(|item| *item = NO_PATCH);
            items
        });
        Self { hemicube, items }
    }

    /// The frame in which a patch's hemicube reads best: the scene's up is up in the picture where the
    /// patch stands upright.
    pub fn upright_frame(normal: DVec3, up: DVec3) -> Frame {
        Frame::along(normal, normal.cross(up))
    }

    /// Cells along an edge of the unfolded cross.
    pub fn size(&self) -> usize {
        2 * self.hemicube.resolution()
    }

    /// The cell in column `x` and row `y` of the unfolded cross; `None` in its four empty corners
    /// and outside.
    pub fn cell(&self, x: usize, y: usize) -> Option<ItemCell> {
        let n = self.hemicube.resolution();
        let half = n / 2;
        if x.max(y) >= 2 * n {
            return None;
        }
        // From the outer edge: 0 at the horizon.
        let band = |k: usize| match k {
            k if k < half => Some((false, k)),
            k if k < half + n => None,
            k => Some((true, 2 * n - 1 - k)),
        };
        let (face, column, row) = match (band(x), band(y)) {
            (None, None) => (0, x - half, y - half),
            (None, Some((positive, rise))) => (if positive { 1 } else { 2 }, x - half, rise),
            (Some((positive, rise)), None) => (if positive { 3 } else { 4 }, y - half, rise),
            _ => return None,
        };
        let at = row * n + column;
        let patch = self.items[face][at];
        Some(ItemCell { patch: (patch != NO_PATCH).then_some(patch), delta: self.hemicube.deltas(face)[at] })
    }

    /// Form factor to `patch`: the sum of the cells that see it.
    pub fn form_factor(&self, patch: u32) -> f64 {
        self.items
            .iter()
            .enumerate()
            .flat_map(|(face, items)| items.iter().zip(self.hemicube.deltas(face)))
            .filter(|(item, _)| **item == patch)
            .map(|(_, delta)| delta)
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form_factors::RowBuffer;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};
    use crate::visibility::Viewer;

    fn mesh() -> PatchMesh {
        let scene = load(&SceneSource::Builtin("cornell".to_owned())).expect("embedded");
        let settings = MeshSettings { target: PatchTarget::Count(300), ..MeshSettings::default() };
        build(&scene, &settings).expect("meshed")
    }

    #[test]
    fn the_cells_of_the_cross_sum_to_one_and_to_the_row() {
        let mesh = mesh();
        let patch = &mesh.patches[mesh.patches.len() / 2];
        let frame = ItemBuffer::upright_frame(patch.normal, DVec3::Y);
        let buffer = ItemBuffer::draw(&mesh, patch.centre, &frame, 64);
        assert_eq!(buffer.size(), 128);
        let mut row = vec![0.0; mesh.patches.len()];
        let (mut sum, mut cells) = (0.0, 0);
        for y in 0..buffer.size() + 3 {
            for x in 0..buffer.size() + 3 {
                let Some(cell) = buffer.cell(x, y) else { continue };
                cells += 1;
                sum += cell.delta;
                if let Some(patch) = cell.patch {
                    row[patch as usize] += cell.delta;
                }
            }
        }
        assert_eq!(cells, 64 * 64 + 4 * 64 * 32);
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        let mut gathered = RowBuffer::new(mesh.patches.len());
        let mut sampler = HemicubeSampler::default();
        Hemicube::new(64).gather(
            &mut sampler,
            (&mesh, None),
            patch.centre,
            &frame,
            Viewer::LitSurface,
            &mut gathered,
        );
        let mut seen = 0;
        gathered.drain(|j, f| {
            seen += 1;
            assert!((row[j as usize] - f).abs() < 1e-12, "{j}: {} against {f}", row[j as usize]);
            assert!((buffer.form_factor(j) - f).abs() < 1e-12);
        });
        assert!(seen > 50, "{seen}");
    }

    #[test]
    fn the_cross_shows_each_face_where_one_looks_for_it() {
        let mesh = mesh();
        // A patch of the back wall, at z = 0.5592 or so, looking out into the room.
        let wall = mesh.patches.iter().max_by(|a, b| a.centre.z.total_cmp(&b.centre.z)).expect("patches");
        let frame = ItemBuffer::upright_frame(wall.normal, DVec3::Y);
        let buffer = ItemBuffer::draw(&mesh, wall.centre, &frame, 32);
        let middle = buffer.size() / 2;
        let normal_at = |x: usize, y: usize| {
            let seen = buffer.cell(x, y).expect("in the cross").patch.expect("a surface");
            mesh.patches[seen as usize].normal
        };
        assert!(normal_at(middle, 0).y < -0.9, "the ceiling is above");
        assert!(normal_at(middle, buffer.size() - 1).y > 0.9, "the floor is below");
        let right = wall.normal.cross(DVec3::Y);
        assert!(normal_at(buffer.size() - 1, middle).dot(right) < -0.9, "the wall on the right faces left");
        assert!(normal_at(0, middle).dot(right) > 0.9, "the wall on the left faces right");
    }

    #[test]
    fn neighbouring_cells_across_a_fold_see_alike() {
        let mesh = mesh();
        let patch = &mesh.patches[7];
        let frame = ItemBuffer::upright_frame(patch.normal, DVec3::Y);
        let buffer = ItemBuffer::draw(&mesh, patch.centre, &frame, 128);
        let (fold, n) = (64, 128);
        let mut same = 0;
        for k in fold..fold + n {
            for (a, b) in [
                ([fold - 1, k], [fold, k]),
                ([fold + n - 1, k], [fold + n, k]),
                ([k, fold - 1], [k, fold]),
                ([k, fold + n - 1], [k, fold + n]),
            ] {
                let seen = |[x, y]: [usize; 2]| buffer.cell(x, y).expect("in the cross").patch;
                same += usize::from(seen(a) == seen(b));
            }
        }
        assert!(same > 4 * n * 8 / 10, "{same} of {}", 4 * n);
    }
}
