//! From patch values to what is shown: vertex radiosity, the sky, exposure, tone maps and false colours.
//!
//! Nothing here flows back: exposure and tone maps are applied to what is drawn and never to a
//! stored radiosity.

mod adaptation;
mod behind;
mod colour_map;
mod detail;
mod even_light;
mod false_colour;
mod mesh;
mod sky_view;
mod tone;
mod vertices;
mod weights;

pub use adaptation::{usual_lighting, white_balance};
pub use colour_map::{ColourMap, patch_colour};
pub use detail::Detail;
pub use even_light::{even_light, openness};
pub use false_colour::{FalseColour, NO_VALUE, Tick, patch_illuminance, patch_luminance};
pub use mesh::{Batch, DisplayCorner, DisplayMesh, PaneCorner, Shading};
pub use sky_view::{Panorama, SkyLight, SkyView};
pub(crate) use tone::MIDDLE_GREY;
pub use tone::{Exposure, ToneMap, luminance, meter, srgb_decode, srgb_encode};
