//! The model while it is mended.

use crate::geometry::polygon;
use crate::scene::doctor::orientation::orient;
use crate::scene::doctor::topology::{HalfEdge, bundles, cut, half_edges, missing, stops, weld};
use crate::scene::doctor::{MOST_OPEN, WELD, crack};
use crate::scene::luminaires::turn;
use crate::scene::model::{Face, Polygons};
use crate::scene::repair::repair;
use crate::scene::sides::partners;
use crate::scene::types::{Corner, Scene, Surface};
use glam::DVec3;
use std::collections::HashMap;

/// A scene whose faces may be changed.
pub(super) struct Shape {
    pub(super) scene: Scene,
    /// A surface that stands for each object and material: its lamp and how it emits.
    kinds: HashMap<(u32, u32), Surface>,
    /// Which materials emit.
    emits: Vec<bool>,
}

impl Shape {
    pub(super) fn of(scene: &Scene) -> Self {
        let kind = |s: &Surface| ((s.object, s.material), Surface { corners: Vec::new(), ..s.clone() });
        let emits =
            |m: usize| scene.surfaces.iter().any(|s| s.material as usize == m && s.luminaire.is_some());
        Self {
            kinds: scene.surfaces.iter().map(kind).collect(),
            emits: (0..scene.materials.len()).map(emits).collect(),
            scene: Scene { findings: Vec::new(), textures: Vec::new(), ..scene.clone() },
        }
    }

    /// Makes corners at one place one. Returns how many went.
    pub(super) fn weld(&mut self, diagonal: f64) -> usize {
        let welded = weld(&self.scene.positions, WELD * diagonal);
        self.rename(&welded)
    }

    /// Makes corners of open edges that nearly meet one. Returns how many went.
    pub(super) fn close_cracks(&mut self, diagonal: f64) -> usize {
        let mut gone = 0;
        let open = self.open_edges();
        if open.len() <= MOST_OPEN {
            let mut corners: Vec<u32> = open.iter().flat_map(|e| [e.from, e.to]).collect();
            corners.sort_unstable();
            corners.dedup();
            let places: Vec<DVec3> = corners.iter().map(|&c| self.scene.positions[c as usize]).collect();
            let mut names: Vec<u32> = (0..self.scene.positions.len() as u32).collect();
            for (&corner, first) in corners.iter().zip(weld(&places, crack(diagonal))) {
                names[corner as usize] = corners[first as usize];
            }
            gone += self.rename(&names);
        }
        gone
    }

    /// Gives corners other positions. Returns how many positions went.
    fn rename(&mut self, names: &[u32]) -> usize {
        let mut gone = vec![false; names.len()];
        for corner in self.scene.surfaces.iter_mut().flat_map(|s| &mut s.corners) {
            let name = names[corner.position as usize];
            gone[corner.position as usize] |= name != corner.position;
            corner.position = name;
        }
        gone.into_iter().filter(|&g| g).count()
    }

    /// Leaves out what has no area or is there twice, and splits what is not planar any more: what the
    /// reader does with a file.
    pub(super) fn tidy(&mut self) {
        let scene = &mut self.scene;
        let face = |s: &Surface| Face {
            corners: s.corners.iter().map(|c| (c.position, c.normal, c.uv)).collect(),
            object: s.object,
            material: s.material,
            line: s.line,
        };
        let obj = Polygons {
            normals: std::mem::take(&mut scene.normals),
            faces: scene.surfaces.iter().map(face).collect(),
            objects: scene.objects.clone(),
            ..Polygons::default()
        };
        let repaired = repair(&obj, &scene.positions, &self.emits);
        scene.normals = repaired.normals;
        scene.surfaces = repaired.surfaces;
        for surface in &mut scene.surfaces {
            if let Some(kind) = self.kinds.get(&(surface.object, surface.material)) {
                surface.luminaire = kind.luminaire;
                surface.emission_weight = kind.emission_weight;
                surface.emits_back = kind.emits_back;
            }
        }
    }

    /// Corner numbers of every face.
    fn corners(&self) -> Vec<Vec<u32>> {
        self.scene.surfaces.iter().map(|s| s.corners.iter().map(|c| c.position).collect()).collect()
    }

    fn open_edges(&self) -> Vec<HalfEdge> {
        let edges = half_edges(&self.corners());
        bundles(&edges).filter(|bundle| bundle.len() == 1).flatten().copied().collect()
    }

    /// Gives open edges the corners of their neighbours that lie on them to within `tolerance`, metres.
    /// Returns how many.
    pub(super) fn add_missing_corners(&mut self, tolerance: f64) -> usize {
        let open = self.open_edges();
        if open.len() > MOST_OPEN {
            return 0;
        }
        let stops = stops(&open, &self.scene.positions, tolerance);
        let pieces = cut(&open, &stops);
        // From the last corner of a face to the first, so that the numbers of its sides stay right.
        let mut wanted: Vec<(u32, u32, f64, u32)> = missing(&open, &stops, &pieces)
            .map(|stop| {
                let edge = &open[stop.edge as usize];
                (edge.face, edge.side, stop.along, stop.corner)
            })
            .collect();
        wanted.sort_by(|a, b| (b.0, b.1).cmp(&(a.0, a.1)).then(b.2.total_cmp(&a.2)));
        let before: Vec<Vec<Corner>> = self.scene.surfaces.iter().map(|s| s.corners.clone()).collect();
        for &(face, side, along, position) in &wanted {
            let corners = &before[face as usize];
            let (from, to) = (corners[side as usize], corners[(side as usize + 1) % corners.len()]);
            let corner = Corner { position, ..self.between(from, to, along) };
            self.scene.surfaces[face as usize].corners.insert(side as usize + 1, corner);
        }
        wanted.len()
    }

    /// Normal and texture coordinate between two corners; the position is that of the first.
    pub(super) fn between(&mut self, from: Corner, to: Corner, along: f64) -> Corner {
        let scene = &mut self.scene;
        let normal = from.normal.zip(to.normal).map(|(a, b)| {
            let (a, b) = (scene.normals[a as usize], scene.normals[b as usize]);
            scene.normals.push(a.lerp(b, along).normalize_or(a));
            scene.normals.len() as u32 - 1
        });
        let uv = from.uv.zip(to.uv).map(|(a, b)| {
            scene.uvs.push(scene.uvs[a as usize].lerp(scene.uvs[b as usize], along));
            scene.uvs.len() as u32 - 1
        });
        Corner { position: from.position, normal, uv }
    }

    /// Turns faces so that the shells that they are part of face one way; those that emit stay. Returns
    /// how many were turned, and how many that emit still face against a neighbour.
    pub(super) fn turn_minorities(&mut self) -> (usize, usize) {
        let partners = partners(&self.scene.positions, &self.scene.surfaces);
        let faces_both_ways = |e: &HalfEdge| partners[e.face as usize].is_some();
        let one_way = |edges: Vec<HalfEdge>| -> Vec<HalfEdge> {
            bundles(&edges).filter(|bundle| !bundle.iter().any(faces_both_ways)).flatten().copied().collect()
        };
        let edges = one_way(half_edges(&self.corners()));
        let weights: Vec<f64> = self
            .scene
            .surfaces
            .iter()
            .map(|s| match s.luminaire {
                Some(_) => f64::INFINITY,
                None => polygon::area_vector(&self.scene.polygon(s)).length(),
            })
            .collect();
        let to_turn = orient(&edges, &weights).turn;
        for (surface, _) in self.scene.surfaces.iter_mut().zip(&to_turn).filter(|(_, turn)| **turn) {
            turn(surface, &mut self.scene.normals);
        }
        let edges = one_way(half_edges(&self.corners()));
        let mut opposed: Vec<u32> = bundles(&edges)
            .filter_map(|bundle| match bundle {
                [a, b] if a.from == b.from => Some([a.face, b.face]),
                _ => None,
            })
            .flatten()
            .filter(|&face| self.scene.surfaces[face as usize].luminaire.is_some())
            .collect();
        opposed.sort_unstable();
        opposed.dedup();
        (to_turn.iter().filter(|turn| **turn).count(), opposed.len())
    }
}
