use crate::export::{ExportError, PatchRow, write_patch_table};
use crate::mesh::PatchMesh;
use crate::scene::{Lighting, Scene};
use crate::solver::{PatchLight, patch_emission};
use std::path::Path;

/// A scene under one lighting.
#[derive(Clone, Copy, Debug)]
pub struct LitScene<'a> {
    /// Names and the unit of the file.
    pub scene: &'a Scene,
    /// Its patches.
    pub mesh: &'a PatchMesh,
    /// The lamps as switched.
    pub lighting: &'a Lighting,
    /// Light of every patch under these lamps.
    pub light: &'a PatchLight,
    /// Reflectance of every patch per band, as solved for.
    pub reflectance: &'a [[f32; 3]],
}

/// Writes one line a patch, centres in the unit of the scene's file. Patches without light count
/// as dark.
///
/// # Errors
/// A refusal of the system.
pub fn save_patch_table(path: &Path, lit: &LitScene<'_>) -> Result<(), ExportError> {
    let scene = lit.scene;
    let rows = lit.mesh.patches.iter().enumerate().map(|(id, patch)| {
        let object = scene.surfaces.get(patch.surface as usize).map(|surface| surface.object as usize);
        PatchRow {
            id,
            surface: object.and_then(|o| scene.objects.get(o)).map_or("", String::as_str),
            material: scene.materials.get(patch.material as usize).map_or("", |m| m.name.as_str()),
            centre: scene.in_file(patch.centre),
            normal: patch.normal,
            area: patch.area,
            radiosity: lit.light.radiosity.get(id).copied().unwrap_or_default(),
            exitance: patch_emission(patch, lit.lighting),
            irradiance: lit.light.irradiance.get(id).copied().unwrap_or_default(),
            reflectance: lit.reflectance.get(id).copied().unwrap_or_default(),
        }
    });
    write_patch_table(path, scene.unit.symbol(), rows)
}
