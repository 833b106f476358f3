//! Half-planes through a receiver's normal, spread over the azimuths of one emitter: on each the visible spans are
//! exact. For what so many things stand before that clipping polygons would cost more.

use crate::emitters::HalfSpace;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Half-planes over the azimuths of an outline.
const HALF_PLANES: u32 = 32;

/// The visible share of a convex outline, between 0 and 1, cosines counted in. `occluders` are the planes through
/// the origin and the edges of each occluder, with normals inwards; a fan has as many as `outline` needs.
#[derive(Clone, Debug, Default)]
pub(super) struct Fan {
    planes: Vec<DVec3>,
    ends: Vec<u32>,
    corners: Vec<DVec3>,
    spans: Vec<[f64; 2]>,
    outline: Vec<DVec3>,
}

impl Fan {
    /// Begins with an outline above the horizon.
    pub(super) fn start(&mut self, outline: &[DVec3]) {
        self.planes.clear();
        self.ends.clear();
        self.outline.clear();
        self.outline.extend_from_slice(outline);
    }

    /// Adds an occluder, as [`super::Clipper::subtract`] takes it.
    pub(super) fn add(&mut self, occluder: &[DVec3], plane: DVec3, limit: HalfSpace, thickness: f64) {
        let height = plane.dot(occluder[0]);
        if height.abs() <= thickness {
            return;
        }
        self.corners.clear();
        super::clip::cut_off(occluder, limit, &mut self.corners);
        if self.corners.len() >= 3 {
            super::clip::edge_planes(&self.corners, height, &mut self.planes);
            self.ends.push(self.planes.len() as u32);
        }
    }

    /// The visible share for a receiver with this unit normal.
    pub(super) fn visible_share(&mut self, normal: DVec3) -> f64 {
        let frame = crate::geometry::Frame::around(normal);
        let mut own = Vec::with_capacity(self.outline.len());
        super::clip::edge_planes(&self.outline, -1.0, &mut own);
        let (from, range) = if own.iter().all(|plane| plane.dot(normal) > 0.0) {
            (0.0, TAU)
        } else {
            azimuths(&self.outline, &frame)
        };
        let (mut whole, mut seen) = (0.0, 0.0);
        for k in 0..HALF_PLANES {
            let (sin, cos) = (from + range * (f64::from(k) + 0.5) / f64::from(HALF_PLANES)).sin_cos();
            let along = frame.tangent * cos + frame.bitangent * sin;
            let Some([low, high]) = span(&own, normal, along) else { continue };
            whole += weight(high) - weight(low);
            self.spans.clear();
            let mut start = 0;
            for &end in &self.ends {
                let planes = &self.planes[start as usize..end as usize];
                start = end;
                if let Some([a, b]) = span(planes, normal, along)
                    && b > low
                    && a < high
                {
                    self.spans.push([a.max(low), b.min(high)]);
                }
            }
            self.spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let mut at = low;
            for &[a, b] in &self.spans {
                if a > at {
                    seen += weight(a) - weight(at);
                }
                at = at.max(b);
            }
            if high > at {
                seen += weight(high) - weight(at);
            }
        }
        if whole > 0.0 { seen / whole } else { 1.0 }
    }
}

/// The tangents of the angles from the normal between which a half-plane lies inside of all planes.
fn span(planes: &[DVec3], normal: DVec3, along: DVec3) -> Option<[f64; 2]> {
    let (mut low, mut high) = (0.0_f64, f64::INFINITY);
    for plane in planes {
        let (constant, slope) = (plane.dot(normal), plane.dot(along));
        if slope > 0.0 {
            low = low.max(-constant / slope);
        } else if slope < 0.0 {
            high = high.min(-constant / slope);
        } else if constant < 0.0 {
            return None;
        }
    }
    (low < high).then_some([low, high])
}

/// Squared sine of the angle of this tangent.
fn weight(tangent: f64) -> f64 {
    if tangent.is_infinite() { 1.0 } else { tangent * tangent / (1.0 + tangent * tangent) }
}

/// First azimuth and range of azimuths of an outline that the normal does not pass through.
fn azimuths(outline: &[DVec3], frame: &crate::geometry::Frame) -> (f64, f64) {
    let azimuth = |c: &DVec3| frame.bitangent.dot(*c).atan2(frame.tangent.dot(*c));
    let middle: DVec3 = outline.iter().map(|c| c.normalize_or_zero()).sum();
    let about = azimuth(&middle);
    let turn = |c: &DVec3| {
        let turn = azimuth(c) - about;
        turn - TAU * ((turn + PI) / TAU).floor()
    };
    let (low, high) = outline
        .iter()
        .map(turn)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    (about + low, high - low)
}
