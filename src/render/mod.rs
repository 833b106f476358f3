//! Pixels: the wgpu viewport, picking, and stills on the CPU.
//!
//! Plain values come in (a display mesh, corner values, a camera); nothing here knows the solver,
//! the worker or the window.

mod camera;
mod clearance;
mod frame;
mod free_space;
mod gpu;
mod pick;
mod pipelines;
mod still;
mod target;
mod textures;
mod tour;
mod upload;
#[cfg(test)]
mod tone_test;
mod viewport;

pub use camera::Camera;
pub use frame::{ColourSource, FrameInput};
pub use free_space::FreeSpace;
pub use gpu::{Gpu, GpuError, read_texture};
pub use pick::{Pick, Picker};
pub use still::{Still, StillInput, StillOptions, render_still};
pub use tour::{Tour, WALK_SPEED, person_scale, walking_pace};
pub use upload::{MeshUploader, UploadError, UploadedMesh};
pub use viewport::ViewportRenderer;
