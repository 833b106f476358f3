use std::f64::consts::TAU;

/// Azimuths of the half-planes: cosine and sine in the receiver's turned frame.
#[derive(Clone, Debug)]
pub struct Fan {
    pub(super) directions: Vec<[f64; 2]>,
}

impl Fan {
    /// `half_planes` azimuths, at least 8, evenly spaced.
    pub fn new(half_planes: u32) -> Self {
        let n = half_planes.max(8);
        let angle = |k: u32| TAU * (f64::from(k) + 0.5) / f64::from(n);
        Self { directions: (0..n).map(|k| [angle(k).cos(), angle(k).sin()]).collect() }
    }

    /// How many half-planes there are.
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    /// Never: there are at least 8.
    pub fn is_empty(&self) -> bool {
        self.directions.is_empty()
    }
}
