//! Surfaces split into patches, the unknowns of the system.
//!
//! Coplanar neighbours of one object and material are joined into a [`Region`], the unit of
//! occlusion. A region carries a grid; every cell of it, clipped to the region's outline, makes one
//! [`Piece`] or several, and pieces are grouped into [`Patch`]es, at most one a side. Beside lamps cells
//! are halved until none of them is too large for the light that falls on it, and so they are where a
//! [`Refinement`] asks for it. Where a model has a great many facets smaller than a patch, those of a neighbourhood share
//! patches: see [`Clusters`].

mod backing;
mod build;
mod checkup;
mod clusters;
mod contacts;
mod convex_parts;
mod correspondence;
mod grading;
mod neighbours;
mod panes;
mod patches;
mod pieces;
mod reach;
mod refinement;
mod regions;
mod shells;
mod sizing;
mod sources;
mod stretches;
mod survey;
mod translucence;
mod types;

pub use backing::Backing;
pub use build::{Backs, MeshError, MeshSettings, PatchTarget, build, build_on, build_watched};
pub use checkup::checkup;
pub use clusters::Clusters;
pub use convex_parts::{ConvexPart, ConvexParts};
pub use neighbours::Contact;
pub use panes::{Pane, Panes, Perforated};
pub use reach::LightSearch;
pub(crate) use reach::cosine_direction;
pub use refinement::Refinement;
pub use stretches::stretches;
pub use survey::Survey;
pub use translucence::{Passing, Translucence};
pub use types::{MeshStatistics, NO_PATCH, Patch, PatchMesh, Piece, PieceCorner, Region, Side};
