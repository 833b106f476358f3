//! How the light of a lamp depends on its burning position (LM-63, TILT).

/// How the lamp lies in the luminaire (LM-63, lamp to luminaire geometry).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampPosition {
    /// Upright, base up or down, when the luminaire is level.
    Vertical,
    /// Level, and it stays level when the luminaire is tilted.
    Horizontal,
    /// Level, and it tilts with the luminaire.
    TiltedWithLuminaire,
}

/// Factors on the intensities by the tilt of the luminaire. The intensities of the file do not contain them.
#[derive(Clone, Debug, PartialEq)]
pub struct Tilt {
    /// How the lamp lies in the luminaire.
    pub position: LampPosition,
    /// Tilt of the luminaire from its level position in degrees, strictly ascending.
    pub angles: Vec<f64>,
    /// Factors at these angles, not negative.
    pub factors: Vec<f64>,
}

impl Tilt {
    /// The factor at a tilt in degrees: linear between the angles of the file, the nearest one beyond them.
    pub fn factor(&self, angle: f64) -> f64 {
        let next = self.angles.partition_point(|&a| a <= angle);
        let pair = |at: usize| Some((*self.angles.get(at)?, *self.factors.get(at)?));
        match (next.checked_sub(1).and_then(pair), pair(next)) {
            (Some((a, low)), Some((b, high))) => low + (high - low) * (angle - a) / (b - a),
            (Some((_, factor)), None) | (None, Some((_, factor))) => factor,
            (None, None) => 1.0,
        }
    }
}
