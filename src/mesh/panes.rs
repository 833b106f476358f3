//! Panes of glass: surfaces that light passes, and that are no patches.

use super::backing::Sheets;
use super::regions::Outline;
use super::types::{NO_PATCH, PatchMesh, Side};
use crate::geometry::{Aabb, Bvh, Ray, polygon};
use crate::glazing::AngleTable;
use crate::scene::Scene;
use glam::DVec3;

/// A convex flat part of a pane.
#[derive(Clone, Debug)]
pub struct Pane {
    /// Counter-clockwise as seen from its front, metres.
    pub corners: Vec<DVec3>,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// A box around it, metres.
    pub bounds: Aabb,
    /// Index into [`Panes::kinds`] of glass.
    pub kind: u32,
    /// The input surface that it is a part of.
    pub surface: u32,
    /// Index into the scene's materials.
    pub material: u32,
    /// Whether light that arrives at its front, and at its back, is dimmed by it: glass that is modelled with its
    /// thickness dims where light enters it, and not where it leaves.
    pub dims: [bool; 2],
    /// Of a surface with holes what is opaque of it; `None` of glass.
    pub perforated: Option<Perforated>,
}

/// A piece of a surface with holes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perforated {
    /// The patches on its front and back, which light nothing where there are none.
    pub patches: [u32; 2],
    /// Share that is opaque, above 0 to 1; the rest passes light straight.
    pub opacity: f64,
}

/// All panes of a scene.
#[derive(Clone, Debug, Default)]
pub struct Panes {
    /// Their parts.
    pub list: Vec<Pane>,
    /// What each kind of glass passes by angle.
    pub kinds: Vec<AngleTable>,
    /// Area of all parts that dim, m²; of glass with its thickness one side.
    pub area: f64,
}

/// Two faces that are no farther apart are the two surfaces of one pane, metres.
const THIN: f64 = 0.012;
/// So are two of one object that face away from each other and are no farther apart: thick or insulating glass that is
/// modelled as one body.
const THICK: f64 = 0.06;
/// Never more than this share of the model, whose unit may be another than it says.
const SHARE: f64 = 0.02;
/// Faces are parallel whose normals have this cosine.
const PARALLEL: f64 = 0.995;
/// Surfaces lie in one another that are nearer than this share of the model's size.
const COINCIDENT: f64 = 2e-7;

impl Panes {
    /// Takes the panes out of a list of outlines; `size` is what tolerances are shares of, metres.
    pub(super) fn take(scene: &Scene, outlines: &mut Vec<Outline>, size: f64) -> Self {
        let is_pane = |outline: &Outline| {
            outline.luminaire.is_none() && scene.materials[outline.material as usize].glazing.is_some()
        };
        let mut panes = Self::default();
        let mut kind_of = std::collections::HashMap::new();
        let mut objects = Vec::new();
        for outline in outlines.iter().filter(|outline| is_pane(outline)) {
            let Some(glazing) = &scene.materials[outline.material as usize].glazing else { continue };
            let kind = *kind_of.entry(outline.material).or_insert_with(|| {
                panes.kinds.push(AngleTable::new(glazing));
                panes.kinds.len() as u32 - 1
            });
            for part in &outline.parts {
                let corners: Vec<DVec3> = part.corners.iter().map(|&corner| outline.world(corner)).collect();
                if corners.len() < 3 || polygon::area_vector(&corners).length() <= 0.0 {
                    continue;
                }
                objects.push(outline.object);
                panes.list.push(Pane {
                    bounds: Aabb::around(corners.iter().copied()),
                    corners,
                    normal: outline.frame.normal,
                    kind,
                    surface: part.surface,
                    material: outline.material,
                    dims: [true; 2],
                    perforated: None,
                });
            }
        }
        outlines.retain(|outline| !is_pane(outline));
        panes.join_surfaces(&objects, size);
        panes.area = panes.list.iter().map(Pane::dimming_area).sum();
        panes
    }

    /// Those of glass.
    pub fn glass(&self) -> impl Iterator<Item = &Pane> {
        self.list.iter().filter(|pane| pane.perforated.is_none())
    }

    /// These, and the pieces of a whole mesh that have holes; its regions are those of `sheets`.
    pub(super) fn with_perforated(&self, mesh: &PatchMesh, sheets: &Sheets) -> Self {
        let mut all = self.clone();
        for piece in mesh.pieces.iter().filter(|piece| mesh.regions[piece.region as usize].has_holes) {
            let region = &mesh.regions[piece.region as usize];
            let corners = mesh.polygon(piece, Side::Front);
            let mut patches = piece.patches;
            if piece.backed {
                // Two sheets back to back are one: that of the first region.
                let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
                let others = sheets.backers[piece.region as usize].iter().copied();
                let mut others = others.filter(|&other| mesh.regions[other as usize].has_holes);
                if others.clone().any(|other| other < piece.region) {
                    continue;
                }
                let behind = others.find_map(|other| mesh.patch_at(other, Side::Front, middle));
                patches[1] = behind.unwrap_or(NO_PATCH);
            }
            let Some(&patch) = patches.iter().find(|&&patch| patch != NO_PATCH) else { continue };
            all.list.push(Pane {
                bounds: Aabb::around(corners.iter().copied()),
                corners,
                normal: region.frame.normal,
                kind: u32::MAX,
                surface: piece.surface,
                material: region.material,
                dims: [true; 2],
                perforated: Some(Perforated { patches, opacity: mesh.patches[patch as usize].opacity }),
            });
        }
        all
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Whether some pass bands differently.
    pub fn is_tinted(&self) -> bool {
        self.kinds.iter().any(AngleTable::is_tinted)
    }

    /// All parts as triangles, each with the index of its part.
    pub fn triangles(&self) -> (Vec<[DVec3; 3]>, Vec<u32>) {
        let fans = self.list.iter().enumerate().flat_map(|(index, pane)| {
            (1..pane.corners.len() - 1)
                .map(move |k| ([pane.corners[0], pane.corners[k], pane.corners[k + 1]], index as u32))
        });
        fans.unzip()
    }

    /// Finds the faces that are two surfaces of one pane, and those that stand twice in the model.
    fn join_surfaces(&mut self, objects: &[u32], size: f64) {
        let (triangles, owners) = self.triangles();
        let tree = Bvh::build(&triangles);
        let (near, reach) = (COINCIDENT * size, THICK.min(SHARE * size));
        let middles: Vec<DVec3> = self
            .list
            .iter()
            .map(|pane| pane.corners.iter().sum::<DVec3>() / pane.corners.len() as f64)
            .collect();
        // 1. What lies in another one counts once: as the first.
        let mut is_twin = vec![false; self.list.len()];
        for (index, pane) in self.list.iter().enumerate() {
            let ray = Ray { origin: middles[index] - near * pane.normal, direction: pane.normal };
            let is_first = |triangle: u32| {
                let other = owners[triangle as usize] as usize;
                other < index && self.list[other].normal.dot(pane.normal).abs() > PARALLEL
            };
            is_twin[index] = tree.occluded_where(&ray, 0.0, 2.0 * near, is_first);
        }
        // 2. The nearest face before and behind each.
        let nearest = |index: usize, side: usize| {
            let pane = &self.list[index];
            let direction = if side == 0 { pane.normal } else { -pane.normal };
            let accept = |triangle: u32| {
                let other = owners[triangle as usize] as usize;
                other != index && !is_twin[other] && self.list[other].normal.dot(pane.normal).abs() > PARALLEL
            };
            let hit = tree.nearest_where(&Ray { origin: middles[index], direction }, near, reach, accept)?;
            Some((owners[hit.triangle as usize] as usize, hit.distance))
        };
        let neighbours: Vec<[Option<(usize, f64)>; 2]> = (0..self.list.len())
            .map(|index| if is_twin[index] { [None; 2] } else { [nearest(index, 0), nearest(index, 1)] })
            .collect();
        let closer = |index: usize| {
            let [before, behind] = neighbours[index];
            match (before, behind) {
                (Some(a), Some(b)) => Some(if a.1 <= b.1 { (0, a) } else { (1, b) }),
                (a, b) => a.map(|a| (0, a)).or(b.map(|b| (1, b))),
            }
        };
        let mut inner: Vec<Option<usize>> = vec![None; self.list.len()];
        for index in 0..self.list.len() {
            let Some((side, (other, distance))) = closer(index) else { continue };
            // Between two panes of a unit the nearer surface is the other one of the same pane.
            let is_closest =
                closer(other).is_none_or(|(_, (_, least))| distance <= least * (1.0 + 1e-6) + near);
            let (one, two) = (&self.list[index], &self.list[other]);
            let is_body = objects[index] == objects[other] && one.normal.dot(two.normal) < 0.0 && side == 1;
            if is_closest && (distance <= THIN || is_body) {
                inner[index] = Some(side);
            }
        }
        for (pane, side) in self.list.iter_mut().zip(&inner) {
            if let Some(side) = side {
                pane.dims[*side] = false;
            }
        }
        let mut twins = is_twin.iter();
        self.list.retain(|_| twins.next() == Some(&false));
    }
}

impl Pane {
    /// Area of one side, m².
    pub fn area(&self) -> f64 {
        polygon::area_vector(&self.corners).length()
    }

    /// The same, halved where another surface of the glass has the other half.
    fn dimming_area(&self) -> f64 {
        let sides = self.dims.iter().filter(|dims| **dims).count();
        0.5 * sides as f64 * self.area()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, build};
    use crate::scene::{SceneSource, load};

    /// The panes of a model of glass quads in the planes z = so much, each with the direction that it faces, beside a floor.
    fn panes(quads: &[(f64, bool)], is_one_object: bool) -> Panes {
        let folder = tempfile::tempdir().expect("a folder");
        let mut text = String::from(
            "mtllib m.mtl\nv 0 0 0\nv 5 0 0\nv 5 0 5\nv 0 0 5\nusemtl floor\no floor\nf 4 3 2 1\nusemtl glass\n",
        );
        for (k, (z, faces_up_z)) in quads.iter().enumerate() {
            if k == 0 || !is_one_object {
                text += &format!("o pane{k}\n");
            }
            for (x, y) in [(1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)] {
                text += &format!("v {x} {y} {z}\n");
            }
            text += if *faces_up_z { "f -4 -3 -2 -1\n" } else { "f -1 -2 -3 -4\n" };
        }
        std::fs::write(folder.path().join("m.obj"), text).expect("written");
        std::fs::write(
            folder.path().join("m.mtl"),
            "newmtl floor\nKd .5 .5 .5\nnewmtl glass\nKd 0 0 0\nd .2\nNi 1.5\n",
        )
        .expect("written");
        let scene = load(&SceneSource::File(folder.path().join("m.obj"))).expect("a scene");
        let mesh = build(&scene, &MeshSettings::default()).expect("a mesh");
        assert_eq!(mesh.regions.len(), 1, "glass is no region");
        Panes::clone(&mesh.panes)
    }

    fn dims(quads: &[(f64, bool)], is_one_object: bool) -> Vec<[bool; 2]> {
        panes(quads, is_one_object).list.iter().map(|pane| pane.dims).collect()
    }

    #[test]
    fn glass_counts_once_however_it_is_modelled() {
        assert_eq!(dims(&[(1.0, true)], true), [[true, true]], "a sheet from both sides");
        assert_eq!(dims(&[(1.0, true), (1.0, false)], true), [[true, true]], "a sheet once per side");
        assert_eq!(
            dims(&[(1.0, true), (1.0, true)], false),
            [[true, true]],
            "a sheet that stands there twice"
        );
        let both = dims(&[(1.0, false), (1.006, true)], false);
        assert_eq!(both, [[true, false]; 2], "a pane of 6 mm where light enters it");
        let both = dims(&[(1.0, true), (1.006, false)], false);
        assert_eq!(both, [[false, true]; 2], "the same turned inside out");
        assert_eq!(dims(&[(1.0, false), (1.024, true)], true), [[true, false]; 2], "a unit as one body");
        assert_eq!(dims(&[(1.0, true), (1.024, true)], true), [[true, true]; 2], "two sheets are two panes");
        assert_eq!(dims(&[(1.0, false), (1.2, true)], true), [[true, true]; 2], "two windows are two panes");
        // Double glazing in full: each pane of it by its own two surfaces.
        let unit = dims(&[(1.0, false), (1.004, true), (1.02, false), (1.024, true)], true);
        assert_eq!(unit, [[true, false]; 4]);
    }

    #[test]
    fn the_area_is_that_of_the_glass_and_not_of_its_surfaces() {
        assert!((panes(&[(1.0, false), (1.006, true)], true).area - 1.0).abs() < 1e-9);
        assert!((panes(&[(1.0, false), (2.0, true)], true).area - 2.0).abs() < 1e-9);
        assert!(!panes(&[(1.0, false)], true).is_tinted());
    }
}
