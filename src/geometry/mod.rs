//! Frames, rays, boxes, polygons, rules for integrals and the bounding volume hierarchy. Knows nothing of light.

mod aabb;
mod bvh;
mod frame;
pub mod polygon;
mod quadrature;
mod triangle;

pub use aabb::Aabb;
pub use bvh::{Bvh, Hit, Ray};
pub use frame::Frame;
pub use quadrature::gauss_legendre;
pub use triangle::nearest_in_triangle;
