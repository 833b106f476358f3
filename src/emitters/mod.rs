//! What sends light into a scene: the lamps as emitters.
//!
//! A lamp that a user switches has one [`Basis`], or one for each band where its faces differ in colour. Its
//! faces are [`Emitter`]s: what they send out adds up in the bases. A new kind of light is one more
//! implementation of [`Emitter`].

mod body;
mod face;
mod lamps;
mod outdoors;
mod photometric;

pub use body::ConvexBody;
pub use face::Face;
pub use lamps::{Basis, Emitters, Share, Source};
pub use outdoors::{OutdoorEmitter, SkyPart};
pub use photometric::PhotometricEmitter;

use glam::DVec3;

/// A half-space: `normal · x >= offset`, x relative to some point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Of unit length.
    pub normal: DVec3,
    /// Metres.
    pub offset: f64,
}

/// A convex source of light.
pub trait Emitter: std::fmt::Debug + Send + Sync {
    /// Points whose convex hull holds the emitter, metres.
    fn hull(&self) -> &[DVec3];

    /// Whether a region of the mesh is a part of the emitter: such ones never hide it.
    fn is_part(&self, region: u32) -> bool;

    /// Fills `corners` with its convex outline as seen from a point: relative to that, and in such an order that
    /// `(next x corner) · x >= 0` inside of each edge. What lies outside the half-space that is returned cannot
    /// hide it. `None` where it sends no light there.
    fn outline(&self, from: DVec3, corners: &mut Vec<DVec3>) -> Option<HalfSpace>;

    /// Irradiance at a receiver with this unit normal from the part of the outline that it sees: a convex polygon
    /// of corners relative to the receiver, none below its horizon. W/m² per W/m² of exitance. Of
    /// even radiance unless the emitter knows better, and then 0 to 1.
    fn irradiance(&self, normal: DVec3, visible: &[DVec3]) -> f64 {
        lambert(normal, visible)
    }
}

/// Form factor from the origin with a unit normal to a polygon above its horizon (Lambert 1760); 0 to 1 whatever
/// the polygon's winding.
pub fn lambert(normal: DVec3, corners: &[DVec3]) -> f64 {
    let mut sum = 0.0;
    for (i, &p) in corners.iter().enumerate() {
        let q = corners[if i + 1 == corners.len() { 0 } else { i + 1 }];
        let cross = p.cross(q);
        let length = cross.length();
        if length > 0.0 {
            sum += cross.dot(normal) / length * length.atan2(p.dot(q));
        }
    }
    (sum.abs() / std::f64::consts::TAU).min(1.0)
}
