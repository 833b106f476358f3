//! Rows of form factors: which fraction of the power that leaves patch i arrives at patch j.

/// How a row is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Visible spans found exactly along half-planes through the normal, integrated in closed form.
    #[default]
    Lines,
    /// The hemicube of 1985: visibility sampled at the centres of cells.
    Hemicube,
    /// Low-discrepancy rays with a cosine distribution.
    Rays,
}

impl Method {
    /// The name that `--method` takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lines => "lines",
            Self::Hemicube => "hemicube",
            Self::Rays => "rays",
        }
    }

    /// The resolution used where none is named: half-planes, cells along an edge of the cube, rays.
    pub fn default_resolution(self) -> u32 {
        match self {
            Self::Lines => 192,
            Self::Hemicube => 256,
            Self::Rays => 4096,
        }
    }
}
