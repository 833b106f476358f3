//! What panes of glass leave of the light along a line.

use crate::geometry::{Aabb, Bvh, Ray};
use crate::mesh::{NO_PATCH, Pane, Panes, PatchMesh, Perforated};
use crate::scene::luminance_weighted;
use glam::DVec3;
use std::sync::Arc;

/// The panes of a mesh, to look along lines through them. Clones share all of it.
#[derive(Clone, Debug, Default)]
pub struct Glass {
    panes: Arc<Panes>,
    tree: Arc<Bvh>,
    /// The pane of each triangle of the tree.
    owners: Arc<Vec<u32>>,
    /// Over the boxes of panes.
    boxes: Arc<Bvh>,
    /// Whether some are surfaces with holes.
    has_holes: bool,
}

/// A line meets each pane once, even on the diagonal of two triangles, of the first so many.
const MOST_MET: usize = 64;

impl Glass {
    /// Of a mesh.
    pub fn new(mesh: &PatchMesh) -> Self {
        let (triangles, owners) = mesh.panes.triangles();
        // A triangle without area that has the box of a pane.
        let boxes: Vec<[DVec3; 3]> =
            mesh.panes.list.iter().map(|pane| [pane.bounds.min, pane.bounds.max, pane.bounds.max]).collect();
        let has_holes = mesh.panes.list.iter().any(|pane| pane.perforated.is_some());
        Self {
            panes: Arc::clone(&mesh.panes),
            tree: Arc::new(Bvh::build(&triangles)),
            owners: Arc::new(owners),
            boxes: Arc::new(Bvh::build(&boxes)),
            has_holes,
        }
    }

    /// Of a mesh, without surfaces with holes: for eyes, which see these themselves.
    pub fn clear(mesh: &PatchMesh) -> Self {
        let mut panes = Panes::clone(&mesh.panes);
        panes.list.retain(|pane| pane.perforated.is_none());
        Self::new(&PatchMesh { panes: Arc::new(panes), ..PatchMesh::default() })
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.panes.is_empty()
    }

    /// All panes.
    pub fn panes(&self) -> &Panes {
        &self.panes
    }

    /// Adds the panes to `found` whose boxes `enter` takes, in their order.
    pub fn select(&self, enter: impl Fn(&Aabb) -> bool, found: &mut Vec<u32>) {
        if self.is_empty() {
            return;
        }
        self.boxes.select(&enter, |index| {
            if enter(&self.panes.list[index as usize].bounds) {
                found.push(index);
            }
        });
        found.sort_unstable();
    }

    /// What a pane leaves of light in a unit `direction`, or against it, in each band; 1 where it meets the side from
    /// which it does not dim. `direction` is that of a line from a receiver.
    pub fn passed(&self, pane: &Pane, direction: DVec3) -> [f64; 3] {
        let cos = pane.normal.dot(direction);
        if !pane.dims[usize::from(cos > 0.0)] {
            return [1.0; 3];
        }
        self.transmittance(pane, cos)
    }

    /// What a pane leaves of light at a cosine of the angle of incidence, in each band.
    pub fn transmittance(&self, pane: &Pane, cos: f64) -> [f64; 3] {
        match pane.perforated {
            Some(Perforated { opacity, .. }) => [1.0 - opacity; 3],
            None => self.panes.kinds[pane.kind as usize].transmittance(cos),
        }
    }

    /// What a pane mirrors of it.
    pub fn reflectance(&self, pane: &Pane, cos: f64) -> [f64; 3] {
        match pane.perforated {
            Some(_) => [0.0; 3],
            None => self.panes.kinds[pane.kind as usize].reflectance(cos),
        }
    }

    /// Calls `found` with each patch on a surface with holes that such a line meets, and what of its light, by luminance,
    /// arrives: its opaque share of what the panes before it leave.
    pub fn each_perforated(
        &self,
        origin: DVec3,
        direction: DVec3,
        [from, to]: [f64; 2],
        mut found: impl FnMut(u32, f64),
    ) {
        if !self.has_holes {
            return;
        }
        let mut met: Vec<(f64, u32)> = Vec::new();
        self.tree.each(&Ray { origin, direction }, from, to, |hit| {
            let pane = self.owners[hit.triangle as usize];
            if met.len() < MOST_MET && met.iter().all(|known| known.1 != pane) {
                met.push((hit.distance, pane));
            }
        });
        met.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut left = 1.0;
        for (_, index) in met {
            let pane = &self.panes.list[index as usize];
            if let Some(Perforated { patches, opacity }) = pane.perforated {
                let patch = patches[usize::from(pane.normal.dot(direction) > 0.0)];
                if patch != NO_PATCH {
                    found(patch, left * opacity);
                }
            }
            left *= luminance_weighted(self.passed(pane, direction));
        }
    }

    /// What is left in each band of light along a line from a point in a unit direction, of what comes from `from` to
    /// `to` metres away.
    pub fn along(&self, origin: DVec3, direction: DVec3, [from, to]: [f64; 2]) -> [f64; 3] {
        let mut left = [1.0; 3];
        if self.is_empty() {
            return left;
        }
        let mut met = [u32::MAX; MOST_MET];
        let mut count = 0;
        self.tree.each(&Ray { origin, direction }, from, to, |hit| {
            let pane = self.owners[hit.triangle as usize];
            if met[..count].contains(&pane) {
                return;
            }
            if count < MOST_MET {
                met[count] = pane;
                count += 1;
            }
        });
        // In a fixed order, so that rounding is the same whatever the tree.
        met[..count].sort_unstable();
        for &pane in &met[..count] {
            let passed = self.passed(&self.panes.list[pane as usize], direction);
            for band in 0..3 {
                left[band] *= passed[band];
            }
        }
        left
    }

    /// Calls `found` with each place on such a line at which a pane mirrors, the direction that is mirrored there, and
    /// the share of its light, by luminance, that arrives: what the pane mirrors and those before it leave.
    pub fn each_mirror(
        &self,
        origin: DVec3,
        direction: DVec3,
        [from, to]: [f64; 2],
        mut found: impl FnMut(DVec3, DVec3, f64),
    ) {
        let dims = |triangle: u32| {
            let pane = &self.panes.list[self.owners[triangle as usize] as usize];
            pane.perforated.is_none() && pane.dims[usize::from(pane.normal.dot(direction) > 0.0)]
        };
        let (mut left, mut from) = (1.0, from);
        for _ in 0..MOST_MET {
            let Some(hit) = self.tree.nearest_where(&Ray { origin, direction }, from, to, dims) else {
                return;
            };
            let pane = &self.panes.list[self.owners[hit.triangle as usize] as usize];
            let cos = pane.normal.dot(direction);
            let kind = &self.panes.kinds[pane.kind as usize];
            let mirrored = direction - 2.0 * cos * pane.normal;
            found(
                origin + hit.distance * direction,
                mirrored,
                left * luminance_weighted(kind.reflectance(cos)),
            );
            left *= luminance_weighted(kind.transmittance(cos));
            // The next one is another pane, not the other triangle of this.
            from = hit.distance * (1.0 + 1e-9) + 1e-9;
        }
    }

    /// The share that the nearest pane on such a line mirrors, by luminance; nothing without a pane.
    pub fn mirrored(&self, origin: DVec3, direction: DVec3, [from, to]: [f64; 2]) -> f64 {
        let dims = |triangle: u32| {
            let pane = &self.panes.list[self.owners[triangle as usize] as usize];
            pane.perforated.is_none() && pane.dims[usize::from(pane.normal.dot(direction) > 0.0)]
        };
        let hit = self.tree.nearest_where(&Ray { origin, direction }, from, to, dims);
        hit.map_or(0.0, |hit| {
            let pane = &self.panes.list[self.owners[hit.triangle as usize] as usize];
            luminance_weighted(self.panes.kinds[pane.kind as usize].reflectance(pane.normal.dot(direction)))
        })
    }

    /// The same by luminance.
    pub fn luminous(&self, origin: DVec3, direction: DVec3, range: [f64; 2]) -> f64 {
        if self.is_empty() { 1.0 } else { luminance_weighted(self.along(origin, direction, range)) }
    }

    /// The same between two points, the ends left out by `margin`, metres.
    pub fn between(&self, from: DVec3, to: DVec3, margin: f64) -> f64 {
        let way = to - from;
        let length = way.length();
        if self.is_empty() || length <= 2.0 * margin {
            return 1.0;
        }
        self.luminous(from, way / length, [margin, length - margin])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, build};
    use crate::scene::{SceneSource, load};

    /// A floor under a sheet of glass at z = 1 and a pane with its thickness at z = 2, x and y from 0 to 2.
    fn glass() -> Glass {
        let folder = tempfile::tempdir().expect("a folder");
        let mut text = String::from("mtllib m.mtl\nusemtl floor\n");
        for (z, name, up) in
            [(0.0, "floor", true), (1.0, "glass", true), (2.0, "glass", false), (2.01, "glass", true)]
        {
            text += &format!("usemtl {name}\n");
            for (x, y) in [(0, 0), (2, 0), (2, 2), (0, 2)] {
                text += &format!("v {x} {y} {z}\n");
            }
            text += if up { "f -4 -3 -2 -1\n" } else { "f -1 -2 -3 -4\n" };
        }
        std::fs::write(folder.path().join("m.obj"), text).expect("written");
        let materials = "newmtl floor\nKd .5 .5 .5\nnewmtl glass\nTf .2 .5 .88\nillum 6\n";
        std::fs::write(folder.path().join("m.mtl"), materials).expect("written");
        let scene = load(&SceneSource::File(folder.path().join("m.obj"))).expect("a scene");
        Glass::new(&build(&scene, &MeshSettings::default()).expect("a mesh"))
    }

    #[test]
    fn a_line_is_dimmed_by_each_pane_once_and_by_its_angle() {
        let glass = glass();
        let from = DVec3::new(0.9, 1.2, 0.1);
        let close = |found: [f64; 3], wanted: [f64; 3]| (0..3).all(|b| (found[b] - wanted[b]).abs() < 1e-5);
        let up = |range| glass.along(from, DVec3::Z, range);
        assert_eq!(up([0.0, 0.5]), [1.0; 3]);
        assert!(close(up([0.0, 1.5]), [0.2, 0.5, 0.88]), "{:?}", up([0.0, 1.5]));
        assert!(close(up([0.0, f64::INFINITY]), [0.04, 0.25, 0.7744]), "{:?}", up([0.0, f64::INFINITY]));
        let down = glass.along(DVec3::new(0.7, 1.2, 3.0), DVec3::NEG_Z, [0.0, f64::INFINITY]);
        assert!(close(down, [0.04, 0.25, 0.7744]), "{down:?}");
        // The table of effects: 0.88 along the normal is 0.799868 at 60 degrees.
        let aside = DVec3::new(0.2, 1.2, 0.1);
        let slanted = glass.along(aside, DVec3::new(0.5 * 3_f64.sqrt(), 0.0, 0.5), [0.0, 1.9]);
        assert!((slanted[2] - 0.799_868).abs() < 1e-5, "{slanted:?}");
        assert_eq!(glass.along(from, DVec3::X, [0.0, f64::INFINITY]), [1.0; 3]);
        let between = glass.between(from, DVec3::new(0.9, 1.2, 1.5), 1e-6);
        assert!((between - luminance_weighted([0.2, 0.5, 0.88])).abs() < 1e-5);
    }
}
