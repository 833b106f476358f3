use super::in_detail;
use crate::display::{DisplayMesh, Shading, SkyView};
use crate::export::{ExportError, StillLayers, write_exr, write_png};
use crate::render::{Picker, Still, StillInput};
use crate::scene::Texture;
use crate::solver::PatchLight;
use std::path::Path;

/// The light of a scene at the corners that a still interpolates between.
#[derive(Clone, Debug)]
pub struct StillLight {
    corner_radiosity: Vec<[f32; 3]>,
    corner_irradiance: Vec<[f32; 3]>,
}

impl StillLight {
    /// Spreads the light of the patches to the corners of `mesh`.
    pub fn new(mesh: &DisplayMesh, light: &PatchLight, shading: Shading) -> Self {
        let detail = light.detail.as_deref().map(in_detail);
        Self {
            corner_radiosity: mesh.detailed_radiosity(&light.radiosity, &light.irradiance, detail, shading),
            corner_irradiance: mesh.detailed_irradiance(&light.irradiance, detail, shading),
        }
    }

    /// What a still is rendered from; `mesh` is the one that the light was spread to, `picker` of
    /// the same patches, `sky` of the same scene.
    pub fn input<'a>(
        &'a self,
        mesh: &'a DisplayMesh,
        picker: &'a Picker,
        textures: &'a [Texture],
        sky: Option<SkyView<'a>>,
    ) -> StillInput<'a> {
        StillInput {
            mesh,
            picker,
            textures,
            corner_radiosity: &self.corner_radiosity,
            corner_irradiance: &self.corner_irradiance,
            sky,
        }
    }
}

/// What a picture file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StillKind {
    /// Exposed, tone-mapped, 8 bits.
    Png,
    /// Radiance and further layers.
    Exr,
}

impl StillKind {
    /// By the extension of the file, in any case of letters; `None` for any but `.png` and `.exr`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_ascii_lowercase().to_str()? {
            "png" => Some(Self::Png),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }
}

/// Writes a still: its display layer as PNG, or its other layers as OpenEXR.
///
/// # Errors
/// A refusal of the system.
pub fn save_still(path: &Path, kind: StillKind, still: &Still) -> Result<(), ExportError> {
    match kind {
        StillKind::Png => write_png(path, still.width, still.height, &still.to_rgba8()),
        StillKind::Exr => {
            let layers = StillLayers {
                width: still.width,
                height: still.height,
                radiance: &still.radiance,
                irradiance: &still.irradiance,
                patch: &still.patch_id,
                normal: &still.normal,
                depth: &still.depth,
            };
            write_exr(path, &layers)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_the_name_decides() {
        assert_eq!(StillKind::of(Path::new("a/b.PNG")), Some(StillKind::Png));
        assert_eq!(StillKind::of(Path::new("a.b.exr")), Some(StillKind::Exr));
        for other in ["a.jpg", "png", ".png", "a.png.txt"] {
            assert_eq!(StillKind::of(Path::new(other)), None, "{other}");
        }
    }
}
