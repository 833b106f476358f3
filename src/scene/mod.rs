//! What a model holds: surfaces, materials, luminaires and views, in metres.
//!
//! Everything downstream reads a [`Scene`]; [`load`] makes one from a model file (OBJ with its MTL, glTF or GLB, PLY) and
//! its sidecar, or from an embedded scene by name.
//!
//! The sidecar is a TOML file of the model's name beside it. Every key may be left out, and an unknown
//! one is an error:
//!
//! ```toml
#![doc = include_str!("sidecar_example.toml")]
//! ```
//!
//! A luminaire is made of the surfaces that it selects and that have an emission Ke; where none of
//! them has one, all of them emit. Surfaces with Ke that no entry selects make one luminaire for
//! each object and material.

mod add_lamps;
mod bare_lights;
pub mod builtin;
mod colour;
mod corner_colours;
mod doctor;
mod error;
mod extent;
mod finding;
mod frame;
mod glass;
mod gltf;
mod import;
mod lamp_entry;
mod library;
mod lookup;
mod luminaires;
mod map;
mod mend;
mod model;
mod mtl;
mod names;
mod obj;
mod outdoors;
mod outlines;
mod photometric;
mod placed;
mod ply;
mod polygons;
mod repair;
mod selection;
mod sidecar;
mod sidecar_write;
mod sides;
mod space;
mod summary;
mod tally;
mod text;
mod textures;
mod translucent;
mod types;
mod up_axis;
mod views;
mod wavefront;

pub use add_lamps::{USUAL_WORK_PLANE, WorkPlane, ceiling_lamps, work_planes};
pub use colour::black_body;
pub use doctor::{Crossing, Examination, check, examine};
pub use error::SceneError;
pub use extent::Extent;
pub use finding::{Finding, FindingKind, MOST_PLACES, Places, Severity};
pub use import::{from_text, load, load_watched, sidecar_path};
pub use luminaires::lumens;
pub use mend::{CopiedImage, Mended, mend};
pub use model::{MODEL_ENDINGS, is_model_file};
pub use names::nearest as nearest_names;
pub(crate) use names::{grouped, list as name_list};
pub use outdoors::{DaylightChoice, OutdoorSwitch, Outdoors, SKY, SUN};
pub use photometric::{Attitude, PhotometricLight, PhotometricPlace, PhotometricSource};
pub use placed::{LampColour, LampKind, LampPhotometry, PlacedLamp};
pub use sidecar_write::{sidecar_text, write_frame, write_sidecar};
pub use summary::{LuminaireSummary, MaterialSummary, Summary};
pub use types::{
    Corner, FrameChoice, LampState, LengthUnit, Lighting, Luminaire, Material, Scene, SceneSource, Sides,
    Surface, Texture, UpAxis, View,
};
pub use types::{LUMINOUS_EFFICACY, MAX_REFLECTANCE, illuminance, luminance_weighted};
