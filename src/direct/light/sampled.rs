//! Direct light by few rays, where what hides it is too much to be cut out.

use super::{DirectLight, FEW_RAYS, Scratch, along_for};
use crate::direct::Clipper;
use crate::direct::behind::Behind;
use crate::emitters::{Emitter, HalfSpace, Source};
use glam::DVec3;

/// Among more panes than this, leaves and fabrics with holes, what they leave is looked at by rays.
const MOST_PANES: usize = 8;
/// One ray to each visible fragment, and so many where it gives more than this of a unit of exitance.
const RAYS_AMONG_PANES: f64 = 4.0;
const MUCH_AMONG_PANES: f64 = 2e-2;

impl DirectLight {
    /// As [`Self::gather`], of all emitters and by few rays: more to those that would give the more.
    pub(super) fn sample(
        &self,
        point: DVec3,
        normal: DVec3,
        scratch: &mut Scratch,
        mut add: impl FnMut(&Source, [f64; 3]),
    ) {
        let Scratch { clipper, outline, found, relative, shares, .. } = scratch;
        // 1. What each would give unhindered.
        found.clear();
        shares.clear();
        relative.clear();
        for (index, source) in (0_u32..).zip(&self.emitters.sources) {
            if source.emitter.outline(point, outline).is_none() {
                continue;
            }
            clipper.start(outline, normal);
            let start = relative.len();
            relative.extend(clipper.fragments().flatten());
            let value: f64 = clipper.fragments().map(|f| source.emitter.irradiance(normal, f)).sum();
            if value > 0.0 {
                found.push(index);
                shares.push((value, start, relative.len()));
            }
        }
        // Parts of the sky count by how bright they are.
        let counted = |index: u32, value: f64| {
            let shares = self.emitters.sources[index as usize].shares.iter();
            value * shares.map(|share| share.factor).fold(0.0, f64::max)
        };
        let whole: f64 = found.iter().zip(shares.iter()).map(|(&index, share)| counted(index, share.0)).sum();
        // 2. What of it is seen.
        for (&index, &(value, start, end)) in found.iter().zip(shares.iter()) {
            let own = counted(index, value);
            let rays = FEW_RAYS.iter().find(|(least, _)| own >= least * whole).map_or(1.0, |few| few.1);
            let along = |share| along_for(share * rays);
            let share = match self.visibility {
                true => self.share_by_rays(
                    &self.emitters.sources[index as usize],
                    point,
                    &relative[start..end],
                    along,
                ),
                false => [1.0; 3],
            };
            add(&self.emitters.sources[index as usize], share.map(|share| share * value));
        }
    }

    /// Irradiance from the visible fragments of an emitter, in each band what the panes before it leave.
    pub(super) fn through(
        &self,
        panes: &[u32],
        emitter: &dyn Emitter,
        (point, normal): (DVec3, DVec3),
        limit: HalfSpace,
        (clipper, behind): (&Clipper, &mut Behind),
    ) -> [f64; 3] {
        if panes.is_empty() {
            return [clipper.fragments().map(|f| emitter.irradiance(normal, f)).sum(); 3];
        }
        if panes.len() <= MOST_PANES {
            behind.start(clipper.fragments());
            behind.divide(&self.glass, panes, point, (limit, self.thickness));
            return behind.irradiance(&self.glass, emitter, normal);
        }
        // Among the leaves of a tree by rays.
        let mut sum = [0.0; 3];
        for fragment in clipper.fragments() {
            let value = emitter.irradiance(normal, fragment);
            let along = |to: DVec3| {
                let length = to.length();
                self.glass.along(point, to / length, [self.thickness, length - self.thickness])
            };
            let left = match value > MUCH_AMONG_PANES {
                true => mean_over_outline(fragment, RAYS_AMONG_PANES, along),
                false => along(fragment.iter().sum::<DVec3>() / fragment.len() as f64),
            };
            sum.iter_mut().zip(left).for_each(|(sum, left)| *sum += value * left);
        }
        sum
    }

    /// The share of an outline that is seen from a point, in each band what glass leaves of it, by rays.
    pub(super) fn share_by_rays(
        &self,
        source: &Source,
        point: DVec3,
        corners: &[DVec3],
        along: impl Fn(f64) -> u32,
    ) -> [f64; 3] {
        over_outline(corners, along, |to| self.passed_between(source, point, point + to))
    }
}

/// The mean over a convex outline of what `passed` gives, by about so many rays in all.
pub(in crate::direct) fn mean_over_outline(
    corners: &[DVec3],
    rays: f64,
    passed: impl FnMut(DVec3) -> [f64; 3],
) -> [f64; 3] {
    over_outline(corners, |share| along_for(share * rays), passed)
}

/// The mean over a convex outline of what `passed` gives, by rays to grids over its triangles: so many `along` their
/// edges, by their share of its area.
fn over_outline(
    corners: &[DVec3],
    along: impl Fn(f64) -> u32,
    mut passed: impl FnMut(DVec3) -> [f64; 3],
) -> [f64; 3] {
    let triangles = || (1..corners.len().saturating_sub(1)).map(|k| [corners[0], corners[k], corners[k + 1]]);
    let area_of = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
    let whole: f64 = triangles().map(area_of).sum();
    let mut seen = [0.0; 3];
    for triangle in triangles() {
        let area = area_of(triangle);
        let [a, b, c] = triangle;
        let along = along(area / whole.max(f64::MIN_POSITIVE));
        let each = area / f64::from(along * along);
        for i in 0..along * along {
            // Square to triangle, evenly (Turk 1990).
            let (u, v) = ((f64::from(i % along) + 0.5) / f64::from(along), f64::from(i / along) + 0.5);
            let (root, v) = (u.sqrt(), v / f64::from(along));
            let to = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
            seen.iter_mut().zip(passed(to)).for_each(|(seen, passed)| *seen += each * passed);
        }
    }
    if whole > 0.0 { seen.map(|seen| seen / whole) } else { [0.0; 3] }
}
