//! Form factors by rays with a cosine distribution: every ray carries the same weight.

use super::row::RowBuffer;
use crate::geometry::Frame;
use crate::mesh::{NO_PATCH, cosine_direction};
use crate::visibility::{RayScene, Viewer};
use glam::DVec3;

/// Adds the form factors from `point` to every patch to `row`, which is empty; `turn` in 0..1 turns
/// the pattern of `count` rays. Rays that meet a dark side count for nothing to a lit surface, which
/// sees none.
pub(super) fn gather(
    scene: &RayScene,
    count: u32,
    point: DVec3,
    (frame, turn): (&Frame, f64),
    viewer: Viewer,
    row: &mut RowBuffer,
) {
    let each = 1.0 / f64::from(count.max(1));
    let mut dark = 0.0;
    for k in 0..count {
        let direction = frame.world(cosine_direction(k, count, turn));
        let met = scene.seen_by_glass(point, direction, |patch, share| row.add(patch, each * share));
        if let Some((NO_PATCH, true)) = met {
            dark += each;
        }
    }
    if viewer == Viewer::LitSurface {
        row.scale(without_dark(dark));
    }
}

/// What a row is scaled by of which this share met dark sides. A point that sees little else lies
/// under something, and its row stays as it is.
pub(crate) fn without_dark(share: f64) -> f64 {
    if share < 0.5 { 1.0 / (1.0 - share) } else { 1.0 }
}
