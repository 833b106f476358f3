use crate::display::{Exposure, FalseColour, SkyLight, ToneMap};
use crate::navigation::Camera;

/// What colours the surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ColourSource {
    /// Radiosity of `set_light`, exposed and tone-mapped.
    #[default]
    Radiosity,
    /// The values of `set_scalars` through a colour map.
    FalseColour(FalseColour),
    /// A colour of its own for every patch.
    PatchIds,
    /// The direction of the normal: x, y, z as red, green, blue.
    Normals,
}

/// Everything that one frame depends on besides the uploaded mesh and light: plain values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInput {
    /// From where and whereto.
    pub camera: Camera,
    /// Pixels across and down; at least one each.
    pub size_px: [u32; 2],
    /// What colours the surfaces.
    pub source: ColourSource,
    /// Brightness; acts on [`ColourSource::Radiosity`] alone.
    pub exposure: Exposure,
    /// Acts on [`ColourSource::Radiosity`] alone.
    pub tone_map: ToneMap,
    /// Patch borders over the shaded picture.
    pub wireframe: bool,
    /// A patch to tint.
    pub highlight: Option<u32>,
    /// Draw sides without patches in dark grey; otherwise one looks through them into the rooms.
    pub show_unlit: bool,
    /// Display-linear colour where there is neither a surface nor a sky, 0..1.
    pub background: [f32; 3],
    /// How strongly sky and sun of the scene shine, where there is no surface; acts on
    /// [`ColourSource::Radiosity`] alone. `None`, or a scene without daylight, shows the background.
    pub sky: Option<SkyLight>,
    /// The same left of `split`; `sky` where it is `None`.
    pub stored_sky: Option<SkyLight>,
    /// Where the present light begins, as a share of the width from the left; left of it the stored
    /// light is drawn. `None` draws the present light alone.
    pub split: Option<f32>,
    /// Four samples a pixel. Worth it on any GPU; on a software adapter only at rest.
    pub multisample: bool,
}

impl FrameInput {
    /// A frame of the lit scene with everything else at rest.
    pub fn new(camera: Camera, size_px: [u32; 2]) -> Self {
        Self {
            camera,
            size_px,
            source: ColourSource::Radiosity,
            exposure: Exposure::default(),
            tone_map: ToneMap::default(),
            wireframe: false,
            highlight: None,
            show_unlit: false,
            background: [0.02, 0.02, 0.022],
            sky: None,
            stored_sky: None,
            split: None,
            multisample: true,
        }
    }
}
