//! Faces cut where others pass through them.

use super::shape::Shape;
use crate::geometry::{Frame, polygon};
use crate::scene::doctor::Crossing;
use crate::scene::types::{Corner, Surface};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Corners nearer to a plane than this share of the scene's diagonal lie in it.
const IN_PLANE: f64 = 1e-7;
/// Of a cut at least this share of the scene's diagonal must run through a part.
const SHORTEST: f64 = 1e-6;

/// A straight cut through a face.
struct Cut {
    /// The plane of the other face.
    normal: DVec3,
    point: DVec3,
    segment: [DVec3; 2],
}

/// Cuts all faces that others pass through, along the whole width of the convex part concerned. Returns
/// how many were cut.
pub(super) fn split(shape: &mut Shape, crossings: &[Crossing], diagonal: f64) -> usize {
    let planes: Vec<(DVec3, DVec3)> = shape
        .scene
        .surfaces
        .iter()
        .map(|s| {
            let outline = shape.scene.polygon(s);
            let middle = outline.iter().sum::<DVec3>() / outline.len() as f64;
            (polygon::area_vector(&outline).normalize_or_zero(), middle)
        })
        .collect();
    let mut cuts: BTreeMap<u32, Vec<Cut>> = BTreeMap::new();
    for crossing in crossings {
        let [a, b] = crossing.faces;
        for (face, other) in [(a, b), (b, a)] {
            let (normal, point) = planes[other as usize];
            cuts.entry(face).or_default().push(Cut { normal, point, segment: crossing.segment });
        }
    }
    let mut parts_of: BTreeMap<u32, Vec<Surface>> = BTreeMap::new();
    for (&face, cuts) in &cuts {
        let surface = shape.scene.surfaces[face as usize].clone();
        let mut parts = convex_parts(shape, &surface, planes[face as usize].0);
        for cut in cuts {
            parts = parts.into_iter().flat_map(|part| cut.apply(shape, part, diagonal)).collect();
        }
        parts_of.insert(face, parts);
    }
    let whole = std::mem::take(&mut shape.scene.surfaces);
    for (face, surface) in whole.into_iter().enumerate() {
        match parts_of.remove(&(face as u32)) {
            Some(parts) => shape.scene.surfaces.extend(parts),
            None => shape.scene.surfaces.push(surface),
        }
    }
    cuts.len()
}

/// The face itself where it is convex, else its triangles.
fn convex_parts(shape: &Shape, surface: &Surface, normal: DVec3) -> Vec<Surface> {
    let outline = shape.scene.polygon(surface);
    let frame = Frame::around(normal);
    let flat: Vec<DVec2> = outline
        .iter()
        .map(|&p| p - outline[0])
        .map(|p| DVec2::new(p.dot(frame.tangent), p.dot(frame.bitangent)))
        .collect();
    if polygon::is_convex(&flat, 1e-9 * polygon::area_2d(&flat)) {
        return vec![surface.clone()];
    }
    polygon::triangulate(&flat, &[])
        .into_iter()
        .map(|triangle| {
            let [a, mut b, mut c] = triangle.map(|i| i as usize);
            if polygon::area_2d(&[flat[a], flat[b], flat[c]]) < 0.0 {
                (b, c) = (c, b);
            }
            Surface { corners: [a, b, c].map(|i| surface.corners[i]).to_vec(), ..surface.clone() }
        })
        .collect()
}

impl Cut {
    /// The part in two, or as it is where the cut does not run through it.
    fn apply(&self, shape: &mut Shape, part: Surface, diagonal: f64) -> Vec<Surface> {
        let tolerance = IN_PLANE * diagonal;
        let outline = shape.scene.polygon(&part);
        let heights: Vec<f64> = outline
            .iter()
            .map(|&p| (p - self.point).dot(self.normal))
            .map(|h| if h.abs() <= tolerance { 0.0 } else { h })
            .collect();
        if !heights.iter().any(|&h| h > 0.0) || !heights.iter().any(|&h| h < 0.0) {
            return vec![part];
        }
        if !self.runs_through(&outline, &heights, SHORTEST * diagonal) {
            return vec![part];
        }
        let (mut above, mut below): (Vec<Corner>, Vec<Corner>) = (Vec::new(), Vec::new());
        let n = part.corners.len();
        for k in 0..n {
            let (corner, next) = (part.corners[k], part.corners[(k + 1) % n]);
            let (h, h_next) = (heights[k], heights[(k + 1) % n]);
            if h >= 0.0 {
                above.push(corner);
            }
            if h <= 0.0 {
                below.push(corner);
            }
            if h * h_next < 0.0 {
                let along = h / (h - h_next);
                let place = outline[k].lerp(outline[(k + 1) % n], along);
                shape.scene.positions.push(place);
                let position = shape.scene.positions.len() as u32 - 1;
                let between = Corner { position, ..shape.between(corner, next, along) };
                above.push(between);
                below.push(between);
            }
        }
        [above, below].map(|corners| Surface { corners, ..part.clone() }).into()
    }

    /// Whether the cut's segment and the part's own line in the plane have a length in common.
    fn runs_through(&self, outline: &[DVec3], heights: &[f64], shortest: f64) -> bool {
        let [a, b] = self.segment;
        let Some(direction) = (b - a).try_normalize() else { return false };
        let n = outline.len();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..n {
            let (h, h_next) = (heights[k], heights[(k + 1) % n]);
            if h == 0.0 || h * h_next < 0.0 {
                let along = if h == 0.0 { 0.0 } else { h / (h - h_next) };
                let place = (outline[k].lerp(outline[(k + 1) % n], along) - a).dot(direction);
                (low, high) = (low.min(place), high.max(place));
            }
        }
        high.min((b - a).length()) - low.max(0.0) > shortest
    }
}
