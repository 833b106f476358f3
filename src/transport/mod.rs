//! How light passes between patches: one operator that is asked, whatever stands behind it.
//!
//! Whoever solves, audits or inspects asks a [`Transport`]; nobody else holds rows. [`DenseTransport`]
//! stores every pair of patches that see each other; [`TreeTransport`] has rows whose far ends are nodes of a tree over
//! patches, and needs no more than a few hundred of them per row.

mod balancing;
mod dense;
mod gradients;
mod near;
mod quality;
mod tree;

pub use dense::DenseTransport;
pub use quality::RowQuality;
pub use tree::{NodeRow, NodeScratch, Sent, TreePlan, TreeTransport};

use std::ops::Range;

/// Columns gathered together: what is stored is read once for all of them.
pub const LANES: usize = 4;

/// A value of each of some columns that are gathered together.
pub type Lanes = [f64; LANES];

/// Asked every few rows whether to stop.
pub type Cancelled<'a> = &'a (dyn Fn() -> bool + Sync);

/// For a patch, adds its exchange areas with each of the parts that patches were grouped into.
pub type Coarsened<'a> = Box<dyn Fn(usize, &mut [f64]) + Sync + 'a>;

/// Which transport is to carry the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TransportKind {
    /// The matrix where it is small, else the tree.
    #[default]
    Auto,
    /// [`DenseTransport`].
    Matrix,
    /// [`TreeTransport`].
    Tree,
}

impl TransportKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Matrix, Self::Tree];

    /// As it is written on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Matrix => "matrix",
            Self::Tree => "tree",
        }
    }
}

/// What sampling and balancing found over all rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AssembleReport {
    /// Largest |row sum - 1| of a row as sampled, among rows that see no opening to within 1 %.
    pub worst_closure: f64,
    /// Area-weighted mean over pairs of |A_i F_ij - A_j F_ji| over their mean, as sampled; of a tree over the pairs with
    /// some rows that are kept for that.
    pub mean_reciprocity: f64,
    /// Rows that were gathered at several points of their patch.
    pub several_points: usize,
    /// Close pairs replaced by closed forms.
    pub close_pairs: usize,
    /// Scaling passes until the power balance closed.
    pub passes: usize,
    /// Largest deviation of a row sum from its target after them; at most 1e-7.
    pub imbalance: f64,
    /// Share of the balanced exchange that patches keep to themselves, since those that they see cannot take
    /// it up: 1e-8 where none has to, more where rows contradict each other.
    pub kept: f64,
    /// What nodes that stand for their patches change about the irradiance that surfaces pass on, root mean square over
    /// the area, of the mean irradiance of any lamp alone and with a reflectance of one; 0 of a matrix.
    pub joined_error: f64,
    /// Rows of a tree that were given what their samples had missed of small patches.
    pub mended: usize,
}

/// The discrete transport operator: F_ij, the share of what leaves patch i that arrives at patch j, as
/// exchange areas S_ij = A_i F_ij, balanced so that what is sent arrives.
///
/// Calls are made per pass or per row, never per entry.
pub trait Transport: std::fmt::Debug + Send + Sync {
    /// Area of each patch, m².
    fn areas(&self) -> &[f64];

    /// The irradiance, W/m², of the patches `rows` from the radiosities of all patches, W/m². Where it is
    /// cancelled, some are left as they were.
    fn gather(&self, rows: Range<usize>, radiosity: &[Lanes], irradiance: &mut [Lanes], cancelled: Cancelled);

    /// One Gauss-Seidel pass: for each patch in order, `update` makes its new radiosity from what arrives
    /// from all others, W/m², and from the share of its own radiosity that arrives at itself. The new value
    /// counts for the patches after it.
    fn relax(
        &self,
        radiosity: &mut [Lanes],
        cancelled: Cancelled,
        update: &mut dyn FnMut(usize, Lanes, f64) -> Lanes,
    );

    /// The operator between groups of patches, patch `i` being in group `part_of[i]`: for patch i the sums
    /// over each group of S_ij, j other than i, m².
    fn coarsen<'a>(&'a self, part_of: &'a [u32]) -> Coarsened<'a>;

    /// Row `i` for whoever wants to look at it: the patches that it sees in rising order and its exchange
    /// areas with them, m², without itself ([`Self::own`]).
    fn row(&self, i: usize) -> Vec<(u32, f64)>;

    /// Of row `i` the patches that it holds one by one, with its exchange areas, m², in rising order: all that it sees, or
    /// those among them that do not stand in groups.
    fn singles(&self, i: usize) -> Vec<(u32, f64)> {
        self.row(i)
    }

    /// Values stored of row `i`.
    fn row_entries(&self, i: usize) -> usize;

    /// Which it is.
    fn kind(&self) -> TransportKind;

    /// Exchange area of patch `i` with itself, m²: what rounding leaves of its row.
    fn own(&self, i: usize) -> f64;

    /// Sum of the form factors of row `i`: 1 in a closed scene, less where light escapes.
    fn row_sum(&self, i: usize) -> f64;

    /// Whether patch `i` sees anything: what lies under a box does not.
    fn sees(&self, i: usize) -> bool;

    /// Row `i` as it was sampled, before balancing: its sum and how far it was from reciprocal.
    fn quality(&self, i: usize) -> RowQuality;

    /// What sampling and balancing found over all rows.
    fn report(&self) -> &AssembleReport;

    /// How often it was asked to gather or to relax so far: what is free of charge does neither.
    fn passes(&self) -> u64;

    /// Values stored.
    fn entries(&self) -> usize;

    /// Bytes held.
    fn bytes(&self) -> usize;

    /// Number of patches.
    fn len(&self) -> usize {
        self.areas().len()
    }

    /// Whether there is no patch.
    fn is_empty(&self) -> bool {
        self.areas().is_empty()
    }

    /// Area of patch `i`, m².
    fn area(&self, i: usize) -> f64 {
        self.areas()[i]
    }

    /// Form factor from patch `i` to patch `j`.
    fn get(&self, i: usize, j: usize) -> f64 {
        let row = self.row(i);
        let stored = row.binary_search_by_key(&(j as u32), |entry| entry.0).map_or(0.0, |at| row[at].1);
        (stored + if i == j { self.own(i) } else { 0.0 }) / self.area(i)
    }

    /// The irradiance of every patch, W/m² per band, from radiosities of three bands.
    fn gather_bands(&self, radiosity: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let lanes: Vec<Lanes> = radiosity.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
        let mut irradiance = vec![[0.0; LANES]; self.len()];
        self.gather(0..self.len(), &lanes, &mut irradiance, &|| false);
        irradiance.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
    }
}
