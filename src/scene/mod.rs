//! What a model holds: surfaces, materials, luminaires and views, in metres.
//!
//! Everything downstream reads a [`Scene`]; [`load`] makes one from an OBJ file with its MTL and
//! sidecar, or from an embedded scene by name.

pub mod builtin;
mod types;

pub use types::{
    Corner, Finding, LampState, LengthUnit, Lighting, Luminaire, Material, Scene, SceneSource, Severity,
    Sides, Surface, Texture, UpAxis, View,
};
pub use types::{LUMINOUS_EFFICACY, MAX_REFLECTANCE, illuminance, luminance_weighted};
