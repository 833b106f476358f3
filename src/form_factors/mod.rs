//! Rows of form factors: which fraction of the power that leaves patch i arrives at patch j.
//!
//! A row is gathered at a patch's centre or at several of its points by one of three methods (`lines`,
//! `hemicube`, `ray_rows`). Rows are as sampled; [`crate::transport`] makes a balanced operator of them.

pub mod closed_form;
mod convex;
mod hemicube;
mod item_buffer;
mod lines;
mod ray_rows;
mod receiving;
mod row;
mod rows;

pub use hemicube::{Hemicube, HemicubeSampler};
pub use item_buffer::{ItemBuffer, ItemCell};
pub use lines::{Fan, LineSampler, Viewpoint};
pub use receiving::ReceivingPoints;
pub use row::{Row, RowBuffer};
pub use rows::{RowComputer, RowScratch, Sampling};

/// How a row is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Visible spans found exactly along half-planes through the normal, integrated in closed form.
    #[default]
    Lines,
    /// The hemicube: visibility sampled at the centres of cells. Turned from patch to patch, so that what
    /// it gets wrong about edges along its cells does not add up.
    Hemicube,
    /// The hemicube of 1985, in line with the edges of the surface that it stands on.
    AlignedHemicube,
    /// Low-discrepancy rays with a cosine distribution.
    Rays,
}

impl Method {
    /// All methods, the default first.
    pub const ALL: [Self; 4] = [Self::Lines, Self::Hemicube, Self::AlignedHemicube, Self::Rays];

    /// The name that `--method` takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lines => "lines",
            Self::Hemicube => "hemicube",
            Self::AlignedHemicube => "hemicube-aligned",
            Self::Rays => "rays",
        }
    }

    /// The resolution used where none is named: half-planes, cells along an edge of the cube, rays.
    pub fn default_resolution(self) -> u32 {
        match self {
            Self::Lines => 192,
            Self::Hemicube | Self::AlignedHemicube => 256,
            Self::Rays => 4096,
        }
    }
}
