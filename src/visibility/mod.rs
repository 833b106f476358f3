//! What hides what: the surfaces of a mesh as a receiving point meets them, which of them it may see at
//! all, and rays against the true polygons.
//!
//! Whoever samples light asks here: the rows of form factors as well as the audit.

mod culling;
mod occluders;
mod panes;
mod rays;

#[cfg(test)]
pub(crate) use culling::Culling;
#[cfg(test)]
pub(crate) use occluders::Occluder;
pub(crate) use occluders::{Cell, THICKNESS};
pub use occluders::{Occluders, Viewer};
pub use panes::Glass;
pub use rays::RayScene;
