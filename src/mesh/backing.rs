//! Which surfaces lie back to back: each is seen from its own front alone.
//!
//! Modelling programs write a wall of two materials as two faces in one place, one for each side. From
//! either side both are met at the same distance; the one that shows its front there is meant. So the back
//! of a surface on which another one lies is never seen, and no patch lies on it.

use super::regions::Outline;
use crate::geometry::{Aabb, Bvh, Hit, Ray, polygon};
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Surfaces nearer to each other than this share of the scene's diagonal lie in one place: half of what rays
/// start off a surface.
const TOGETHER: f64 = 5e-8;
/// Small surfaces must lie nearer to each other: within this share of their size.
const TOGETHER_OF_SIZE: f64 = 1e-3;
/// Cosine between the normals of surfaces that lie back to back.
const OPPOSITE: f64 = -0.999;
/// What is covered to all but this share is covered as a whole, and what is covered by no more than this
/// share of the smaller surface is not covered.
const SLIVER: f64 = 1e-6;

/// How much of the back of a surface is covered by the fronts of others that lie there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backing {
    /// Nothing.
    #[default]
    None,
    /// A part.
    Partial,
    /// All of it: the back is never seen.
    Whole,
}

/// The outlines of a scene as triangles, and which of them lie back to back.
pub(super) struct Sheets {
    outlines: Arc<[Outline]>,
    pub(super) bvh: Bvh,
    /// The outline that each triangle is a part of.
    pub(super) owners: Vec<u32>,
    /// For each outline how much of its back is covered.
    pub(super) backing: Vec<Backing>,
    /// For each outline those that lie on its back and face that way.
    pub(super) backers: Vec<Vec<u32>>,
    /// Distances below this count as none, metres.
    tolerance: f64,
}

impl Sheets {
    /// Looks for surfaces that lie back to back in a scene whose box has the diagonal `size`.
    ///
    /// # Errors
    /// The watch ended it.
    pub(super) fn new(outlines: Arc<[Outline]>, size: f64, watch: &mut Watch<'_>) -> Result<Self, Cancelled> {
        let (mut triangles, mut owners, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        for (owner, outline) in outlines.iter().enumerate() {
            for (number, part) in outline.parts.iter().enumerate() {
                for k in 1..part.corners.len() - 1 {
                    let triangle = [part.corners[0], part.corners[k], part.corners[k + 1]];
                    triangles.push(triangle.map(|c| outline.world(c)));
                    owners.push(owner as u32);
                    parts.push(number as u32);
                }
            }
        }
        let mut sheets = Self {
            outlines,
            bvh: Bvh::build_unless(&triangles, watch.cancelled())?,
            owners,
            backing: Vec::new(),
            backers: Vec::new(),
            tolerance: TOGETHER * size,
        };
        let found = watch.map(&sheets.outlines, |index, _| sheets.behind(index, &parts))?;
        (sheets.backing, sheets.backers) = found.into_iter().unzip();
        Ok(sheets)
    }

    /// How much of the back of an outline is covered, and by which others. `parts` are the numbers of the
    /// triangles' parts within their outlines.
    fn behind(&self, index: usize, parts: &[u32]) -> (Backing, Vec<u32>) {
        let outline = &self.outlines[index];
        if outline.emits_back {
            return (Backing::None, Vec::new());
        }
        let (mut covered, mut backers) = (0.0, Vec::new());
        for part in &outline.parts {
            let bounds = Aabb::around(part.corners.iter().map(|&c| outline.world(c))).grown(self.tolerance);
            let mut near: Vec<(u32, u32)> = Vec::new();
            self.bvh.touching(&bounds, |triangle| {
                let owner = self.owners[triangle as usize];
                let normal = self.outlines[owner as usize].frame.normal;
                if normal.dot(outline.frame.normal) < OPPOSITE {
                    near.push((owner, parts[triangle as usize]));
                }
            });
            near.sort_unstable();
            near.dedup();
            for (owner, number) in near {
                let other = &self.outlines[owner as usize].parts[number as usize].corners;
                let common = self.common_area(outline, &part.corners, &self.outlines[owner as usize], other);
                if common > 0.0 {
                    covered += common;
                    backers.push(owner);
                }
            }
        }
        backers.sort_unstable();
        backers.dedup();
        let backing = match covered {
            0.0 => Backing::None,
            area if area < (1.0 - SLIVER) * outline.area => Backing::Partial,
            _ => Backing::Whole,
        };
        (backing, backers)
    }

    /// The area that a part of an outline has in common with one of another that faces the other way; zero
    /// unless they lie in one plane.
    fn common_area(&self, outline: &Outline, part: &[DVec2], other: &Outline, others: &[DVec2]) -> f64 {
        let smaller = polygon::area_2d(part).abs().min(polygon::area_2d(others).abs());
        let tolerance = self.tolerance.min(TOGETHER_OF_SIZE * smaller.sqrt());
        let mut shape = Vec::with_capacity(others.len());
        for &corner in others.iter().rev() {
            let local = outline.frame.local(other.world(corner) - outline.origin);
            if local.z.abs() > tolerance {
                return 0.0;
            }
            shape.push(local.truncate());
        }
        let mut clipped = Vec::new();
        for k in 0..part.len() {
            let (a, b) = (part[k], part[(k + 1) % part.len()]);
            let inward = (b - a).perp();
            polygon::clip_2d(&shape, inward, -inward.dot(a), &mut clipped);
            std::mem::swap(&mut shape, &mut clipped);
            if shape.len() < 3 {
                return 0.0;
            }
        }
        let common = polygon::area_2d(&shape).abs();
        if common > SLIVER * smaller { common } else { 0.0 }
    }

    /// Whether another surface lies on the back of an outline at a point of its plane.
    pub(super) fn covers_back(&self, index: usize, at: DVec2) -> bool {
        match self.backing[index] {
            Backing::None => return false,
            Backing::Whole => return true,
            Backing::Partial => {}
        }
        let outline = &self.outlines[index];
        let point = outline.world(at);
        let reach = 4.0 * self.tolerance;
        let ray = Ray { origin: point + outline.frame.normal * reach, direction: -outline.frame.normal };
        let backers = &self.backers[index];
        let is_backer = |t: u32| backers.binary_search(&self.owners[t as usize]).is_ok();
        self.bvh.nearest_where(&ray, 0.0, 2.0 * reach, is_backer).is_some()
    }

    /// Whether a ray in this direction meets a triangle from behind.
    pub(super) fn meets_back(&self, triangle: u32, direction: DVec3) -> bool {
        self.outlines[self.owners[triangle as usize] as usize].frame.normal.dot(direction) > 0.0
    }

    fn is_shown(&self, triangle: u32, direction: DVec3) -> bool {
        // Light passes its holes, here as if it were not there.
        if self.outlines[self.owners[triangle as usize] as usize].has_holes {
            return false;
        }
        let is_backed = self.backing[self.owners[triangle as usize] as usize] == Backing::Whole;
        !(is_backed && self.meets_back(triangle, direction))
    }

    /// The nearest triangle that a ray, whose direction is of unit length, meets on a side that can be seen.
    pub(super) fn nearest(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.bvh.nearest_where(ray, 0.0, f64::INFINITY, |t| self.is_shown(t, ray.direction))?;
        let owner = self.owners[hit.triangle as usize] as usize;
        if self.backing[owner] != Backing::Partial || !self.meets_back(hit.triangle, ray.direction) {
            return Some(hit);
        }
        // A front that lies in the same place goes before the back.
        let slope = self.outlines[owner].frame.normal.dot(ray.direction);
        let reach = 2.0 * self.tolerance / slope.max(1e-3);
        let backers = &self.backers[owner];
        let is_backer = |t: u32| backers.binary_search(&self.owners[t as usize]).is_ok();
        let (from, to) = (hit.distance - reach, hit.distance + reach);
        self.bvh.nearest_where(ray, from.max(0.0), to, is_backer).or(Some(hit))
    }

    /// Whether anything stands on the ray before `max` multiples of its direction.
    pub(super) fn occluded(&self, ray: &Ray, max: f64) -> bool {
        self.bvh.occluded_where(ray, 0.0, max, |t| self.is_shown(t, ray.direction))
    }
}
