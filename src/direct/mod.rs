//! Direct light: what the lamps give by themselves, with exact visibility.
//!
//! [`DirectLight`] gives it at a point. What can stand between a cell and an emitter is looked for once per cell, in
//! the shaft between the two, and narrowed as the cell is divided; at a point the emitter's outline is clipped by it
//! and what is left is integrated in closed form. Half-planes stand in where that would leave too many fragments,
//! rays where thousands of things may be in the way.

mod behind;
mod clip;
mod elements;
mod first_views;
mod focus;
mod fan;
mod layout;
mod light;
mod mirrors;
mod obstacles;
mod refine;
mod shaft;
mod sky_parts;

pub use clip::Clipper;
pub use elements::{Element, ElementCorner, Elements, NO_ELEMENT, Trees};
pub use focus::Focus;
pub use layout::Layout;
pub use light::{DirectLight, Scratch, Views};
pub use refine::{DEAR, ElementSettings, NEARLY};
