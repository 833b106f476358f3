//! What panes of glass mirror of the emitters.
//!
//! A receiver sees in a pane what its mirror image sees through the pane: each emitter's outline is clipped by the pane
//! as by a window, and what is left is integrated in closed form (the extended form factors of Rushmeier & Torrance
//! 1990). What stands before the pane or behind it in the mirror is looked at by rays. One reflection counts. The sun is left out.

use super::behind::each_part_even_on;
use super::clip::{cut_off, edge_planes, split};
use super::light::{DirectLight, Scratch, Views, mean_over_outline};
use crate::emitters::{HalfSpace, Source};
use crate::geometry::Aabb;
use crate::watch::{Cancelled, Watch};
use glam::DVec3;
use std::sync::Arc;

/// For each pane and each of its sides the emitters that some of it sees, by [`Source::id`] in rising order.
#[derive(Clone, Debug, Default)]
pub(super) struct Mirrors {
    sides: Arc<Vec<[Vec<u32>; 2]>>,
}

/// Panes that fill a smaller share of what a cell sees mirror nothing that counts there, about.
const LEAST_PANE: f64 = 5e-4;
/// What a pane mirrors at a point counts from this share of a unit of exitance.
const LEAST: f64 = 1e-5;
/// Each part of it is looked at by so many rays, and by the second number where it is more than this.
const RAYS: (f64, f64) = (2.0, 8.0);
const MUCH: f64 = 2e-3;
/// Among more panes than this each looks for emitters from its middle alone.
const MANY: usize = 512;
/// How far towards its corners a pane looks for emitters.
const OUTWARDS: [f64; 2] = [0.5, 0.92];
/// Corners nearer than this share of the farthest one's distance to a plane through the receiver lie on it.
const ON_PLANE: f64 = 1e-12;
/// What a pane in view costs a gathering, in obstacles that are looked at.
pub(super) const WORK: u64 = 60;

impl Mirrors {
    /// Looks for the emitters of each pane.
    pub(super) fn find(light: &DirectLight, watch: &mut Watch<'_>) -> Result<Self, Cancelled> {
        let panes = &light.glass().panes().list;
        let outwards = if panes.len() > MANY { &[][..] } else { &OUTWARDS[..] };
        let sides = watch.map(panes, |_, pane| {
            let middle = pane.corners.iter().sum::<DVec3>() / pane.corners.len() as f64;
            let points: Vec<DVec3> = outwards
                .iter()
                .flat_map(|&out| pane.corners.iter().map(move |corner| middle.lerp(*corner, out)))
                .chain([middle])
                .collect();
            [0, 1].map(|side| {
                if !pane.dims[side] || pane.perforated.is_some() {
                    return Vec::new();
                }
                let normal = if side == 0 { pane.normal } else { -pane.normal };
                let is_seen = |source: &Source| points.iter().any(|&p| light.may_see(source, p, normal));
                let sources = light.emitters().sources.iter().filter(|source| !source.is_sun());
                let mut seen: Vec<u32> = sources.filter(|s| is_seen(s)).map(|source| source.id).collect();
                seen.sort_unstable();
                seen
            })
        })?;
        Ok(Self { sides: Arc::new(sides) })
    }

    /// Adds the panes to `views` that may mirror an emitter towards a cell with a unit normal.
    pub(super) fn look(&self, light: &DirectLight, cell: &[DVec3], normal: DVec3, views: &mut Views) {
        if self.sides.iter().all(|sides| sides.iter().all(Vec::is_empty)) {
            return;
        }
        let own = Aabb::around(cell.iter().copied());
        let is_large = |bounds: &Aabb| {
            let apart = (bounds.min - own.max).max(own.min - bounds.max).max(DVec3::ZERO);
            0.25 * bounds.size().length_squared() >= LEAST_PANE * apart.length_squared()
        };
        let mut found = Vec::new();
        light.glass().select(is_large, &mut found);
        for index in found {
            let pane = &light.glass().panes().list[index as usize];
            let is_above = |from: &DVec3| pane.corners.iter().any(|to| normal.dot(*to - *from) > 0.0);
            let sees = |side: usize| {
                let sign = if side == 0 { 1.0 } else { -1.0 };
                !self.sides[index as usize][side].is_empty()
                    && cell.iter().any(|p| sign * pane.normal.dot(*p - pane.corners[0]) > light.thickness())
            };
            if cell.iter().any(is_above) && (sees(0) || sees(1)) {
                views.add_mirror(index);
            }
        }
    }

    /// Calls `add` with what some panes mirror towards a point with a unit normal, pane by pane and emitter by emitter:
    /// irradiance for a unit of what that sends, in each band.
    pub(super) fn gather(
        &self,
        (light, panes): (&DirectLight, &[u32]),
        point: DVec3,
        normal: DVec3,
        scratch: &mut Scratch,
        mut add: impl FnMut(&Source, [f64; 3]),
    ) {
        let glass = light.glass();
        let thickness = light.thickness();
        let Scratch { outline, relative, edges, .. } = scratch;
        let (mut left, mut other) = (Vec::new(), Vec::new());
        for &index in panes {
            let pane = &glass.panes().list[index as usize];
            let height = pane.normal.dot(point - pane.corners[0]);
            let side = usize::from(height < 0.0);
            let known = &self.sides[index as usize][side];
            if height.abs() <= thickness || known.is_empty() {
                continue;
            }
            // 1. The mirror image of the receiver, and the pane as it sees that.
            let image = point - 2.0 * height * pane.normal;
            let mirrored = |v: DVec3| v - 2.0 * pane.normal.dot(v) * pane.normal;
            let horizon = mirrored(normal);
            relative.clear();
            relative.extend(pane.corners.iter().map(|corner| *corner - image));
            edges.clear();
            edges.push(horizon);
            edge_planes(relative, height, edges);
            let beyond = HalfSpace {
                normal: if side == 0 { pane.normal } else { -pane.normal },
                offset: height.abs() + thickness,
            };
            for source in light.emitters().sources.iter().filter(|s| known.binary_search(&s.id).is_ok()) {
                // 2. What of the emitter is beyond the pane and seen through it.
                if source.emitter.outline(image, outline).is_none()
                    || edges.iter().any(|plane| outline.iter().all(|c| plane.dot(*c) <= 0.0))
                {
                    continue;
                }
                left.clear();
                cut_off(outline, beyond, &mut left);
                let reach = left.iter().map(|c: &DVec3| c.length_squared()).fold(0.0, f64::max);
                for &plane in edges.iter() {
                    other.clear();
                    split(&left, plane, ON_PLANE * reach.sqrt(), &mut other, None);
                    std::mem::swap(&mut left, &mut other);
                }
                if left.len() < 3 {
                    continue;
                }
                if source.emitter.irradiance(horizon, &left) <= LEAST {
                    continue;
                }
                // 3. What glass mirrors and things let by.
                let mut sum = [0.0; 3];
                each_part_even_on(pane.normal, &left, |part, direction| {
                    let value = source.emitter.irradiance(horizon, part);
                    let rays = if value > MUCH { RAYS.1 } else { RAYS.0 };
                    let passed = mean_over_outline(part, rays, |to| {
                        let hit = image + to * (height.abs() / beyond.normal.dot(to));
                        let [before, behind] = [(point, hit), (hit, image + to)]
                            .map(|(from, to)| light.passed_between(source, from, to));
                        std::array::from_fn(|band| before[band] * behind[band])
                    });
                    let mirrored = glass.reflectance(pane, pane.normal.dot(direction));
                    for band in 0..3 {
                        sum[band] += value * mirrored[band] * passed[band];
                    }
                });
                if sum.iter().any(|&value| value > 0.0) {
                    add(source, sum);
                }
            }
        }
    }
}
