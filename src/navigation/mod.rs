//! Moving through a model: the camera, walking without passing through walls, and tours.
//!
//! Plain geometry comes in; nothing here knows the window or what draws the picture.

mod camera;
mod clearance;
mod collision;
mod free_space;
mod tour;

pub use camera::Camera;
pub use collision::{Body, Footing, Obstacles};
pub use free_space::FreeSpace;
pub use tour::{Tour, WALK_SPEED, person_scale, walking_pace};
