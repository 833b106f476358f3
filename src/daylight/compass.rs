//! How a model lies under the sky.

use glam::{DMat3, DVec3};

/// The directions of the sky in the axes of a model.
///
/// The frame of the sky is x east, y north, z up. A model has its own up axis, and a north: without a turn,
/// north is -z in a model with y up and +y in a model with z up, so that x is east in both and a plan is
/// drawn with north at its top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compass {
    /// Columns: east, north and up of the sky in the axes of the model.
    model_from_sky: DMat3,
}

impl Compass {
    /// A model with y up whose north is turned by `north` degrees from -z towards +x, clockwise as seen from
    /// above.
    pub fn y_up(north: f64) -> Self {
        Self::turned(DVec3::X, DVec3::NEG_Z, DVec3::Y, north)
    }

    /// A model with z up whose north is turned by `north` degrees from +y towards +x, clockwise as seen from
    /// above.
    pub fn z_up(north: f64) -> Self {
        Self::turned(DVec3::X, DVec3::Y, DVec3::Z, north)
    }

    fn turned(right: DVec3, ahead: DVec3, up: DVec3, north: f64) -> Self {
        let angle = if north.is_finite() { north } else { 0.0 };
        let (sin, cos) = angle.to_radians().sin_cos();
        let north = cos * ahead + sin * right;
        let east = cos * right - sin * ahead;
        Self { model_from_sky: DMat3::from_cols(east, north, up) }
    }

    /// A direction of the sky in the axes of the model.
    pub fn to_model(&self, in_sky: DVec3) -> DVec3 {
        self.model_from_sky * in_sky
    }

    /// A direction of the model in the frame of the sky.
    pub fn to_sky(&self, in_model: DVec3) -> DVec3 {
        // A rotation's inverse is its transpose.
        self.model_from_sky.transpose() * in_model
    }
}
