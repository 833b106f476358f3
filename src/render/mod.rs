//! Pixels: the wgpu viewport, picking, and stills on the CPU.
//!
//! Plain values come in (a display mesh, corner values, a camera); nothing here knows the solver,
//! the worker or the window.

mod frame;
mod gpu;
mod pick;
mod pipelines;
mod sky;
mod still;
mod target;
mod textures;
mod upload;
#[cfg(test)]
mod tone_test;
mod viewport;

pub use frame::{ColourSource, FrameInput};
pub use gpu::{Gpu, GpuError, read_texture};
pub use pick::{Pick, Picker};
pub use sky::UploadedSky;
pub use still::{Still, StillInput, StillOptions, render_still};
pub use upload::{MeshUploader, UploadError, UploadedMesh};
pub use viewport::ViewportRenderer;
