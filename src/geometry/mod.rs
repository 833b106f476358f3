//! Frames, rays, boxes, polygons and the bounding volume hierarchy. Knows nothing of light.

mod aabb;
mod bvh;
mod frame;
pub mod polygon;
mod triangle;

pub use aabb::Aabb;
pub use bvh::{Bvh, Hit, Ray};
pub use frame::Frame;
pub use triangle::nearest_in_triangle;
