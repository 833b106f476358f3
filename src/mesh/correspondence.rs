//! Which patches of two meshes of one scene lie in the same place.

use super::{NO_PATCH, Patch, PatchMesh, Region, Side};
use glam::{DVec2, DVec3};

impl PatchMesh {
    /// For every patch the one of `other` on which its centre lies, on the same side of the same region;
    /// [`NO_PATCH`] where that region and side has none. Within a region the nearest stands in where
    /// the centre falls between patches.
    ///
    /// `None` unless both meshes were cut from the same regions: those of one scene, however finely.
    pub fn places_on(&self, other: &Self) -> Option<Vec<u32>> {
        let same = |a: &Region, b: &Region| {
            (a.object, a.material, a.origin, a.frame) == (b.object, b.material, b.origin, b.frame)
        };
        let alike = self.regions.len() == other.regions.len()
            && self.regions.iter().zip(&other.regions).all(|(a, b)| same(a, b));
        alike.then(|| self.patches.iter().map(|patch| other.patch_under(patch)).collect())
    }

    /// The patch here on which the centre of a patch of another mesh of the same regions lies.
    fn patch_under(&self, patch: &Patch) -> u32 {
        let region = &self.regions[patch.region as usize];
        let at = region.frame.local(patch.centre - region.origin).truncate();
        let found = self
            .pieces_around(region, at)
            .map(|piece| (self.depth(piece, at), self.pieces[piece as usize].patches[patch.side as usize]))
            .filter(|&(depth, own)| own != NO_PATCH && depth > -1e-6 * region.cell_size.max_element())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, own)) = found {
            return own;
        }
        let all = region.pieces.clone();
        let others = all.map(|p| self.pieces[p as usize].patches[patch.side as usize]);
        let distance = |own: &u32| self.patches[*own as usize].centre.distance_squared(patch.centre);
        let nearest = others.filter(|&own| own != NO_PATCH);
        nearest.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(NO_PATCH)
    }

    /// The patch on a side of a region on which a point of its plane lies.
    pub(super) fn patch_at(&self, region: u32, side: Side, at: DVec3) -> Option<u32> {
        let region = &self.regions[region as usize];
        let at = region.frame.local(at - region.origin).truncate();
        let slack = 1e-6 * region.cell_size.max_element();
        let here = self.pieces_around(region, at).filter(|&piece| self.depth(piece, at) > -slack);
        here.map(|piece| self.pieces[piece as usize].patches[side as usize]).find(|&patch| patch != NO_PATCH)
    }

    /// The pieces of a region that overlap the cell around a point of its plane.
    fn pieces_around(&self, region: &Region, at: DVec2) -> impl Iterator<Item = u32> {
        let most = DVec2::new(f64::from(region.cells[0] - 1), f64::from(region.cells[1] - 1));
        let cell = ((at - region.grid_min) / region.cell_size).floor().clamp(DVec2::ZERO, most);
        let cell = region.first_cell as usize + cell.x as usize + cell.y as usize * region.cells[0] as usize;
        let list = self.cell_pieces[cell].clone();
        self.piece_lists[list.start as usize..list.end as usize].iter().copied()
    }

    /// How far inside the convex outline of a piece a point of its plane lies; negative outside.
    fn depth(&self, piece: u32, at: DVec2) -> f64 {
        let corners = self.corners_of(&self.pieces[piece as usize]);
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        ends.map(|(a, b)| (b.plane - a.plane).normalize_or_zero().perp_dot(at - a.plane))
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::{MeshSettings, NO_PATCH, Patch, PatchMesh, PatchTarget, build};
    use crate::scene::{self, SceneSource};
    use glam::DVec3;

    fn mesh(scene: &scene::Scene, count: usize) -> PatchMesh {
        let settings = MeshSettings { target: PatchTarget::Count(count), ..MeshSettings::default() };
        build(scene, &settings).unwrap()
    }

    /// Whether a point of its plane lies on a patch: to the left of all edges of one of its pieces.
    fn covers(mesh: &PatchMesh, patch: &Patch, at: DVec3) -> bool {
        let pieces = &mesh.patch_pieces[patch.pieces.start as usize..patch.pieces.end as usize];
        pieces.iter().any(|&piece| {
            let outline = mesh.polygon(&mesh.pieces[piece as usize], patch.side);
            let mut edges = outline.iter().zip(outline.iter().cycle().skip(1));
            edges.all(|(&a, &b)| (b - a).cross(at - a).dot(patch.normal) > -1e-6 * patch.area)
        })
    }

    #[test]
    fn every_patch_finds_the_one_around_its_centre() {
        for name in ["hemicube", "gallery"] {
            let scene = scene::load(&SceneSource::Builtin(name.to_owned())).unwrap();
            let (coarse, fine) = (mesh(&scene, 700), mesh(&scene, 3000));
            for (from, to) in [(&fine, &coarse), (&coarse, &fine), (&fine, &fine)] {
                let places = from.places_on(to).unwrap();
                let mut beyond = 0;
                for (index, (patch, &place)) in from.patches.iter().zip(&places).enumerate() {
                    assert_ne!(place, NO_PATCH);
                    let there = &to.patches[place as usize];
                    assert_eq!((patch.region, patch.side), (there.region, there.side));
                    if !covers(to, there, patch.centre) {
                        beyond += 1;
                        let here = |p: &&Patch| (p.region, p.side) == (patch.region, patch.side);
                        let mut others = to.patches.iter().filter(here);
                        assert!(!others.any(|other| covers(to, other, patch.centre)), "{name}: {index}");
                    }
                    assert!(!std::ptr::eq(from, to) || place as usize == index);
                }
                // A centre may lie where the other mesh has cut a corner of the floor away.
                assert!(beyond * 100 <= from.patches.len(), "{beyond} of {}", from.patches.len());
            }
        }
    }

    #[test]
    fn meshes_of_different_scenes_have_no_places_in_common() {
        let of = |name: &str| scene::load(&SceneSource::Builtin(name.to_owned())).unwrap();
        assert_eq!(mesh(&of("hemicube"), 500).places_on(&mesh(&of("cornell"), 500)), None);
    }
}
