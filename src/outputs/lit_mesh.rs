use super::in_detail;
use crate::display::{DisplayMesh, Exposure, Shading, ToneMap, srgb_encode};
use crate::export::{ExportError, LitMesh, write_ply};
use crate::solver::PatchLight;
use glam::DVec3;
use std::path::Path;

/// Writes the lit sides as triangles with radiosity at their corners, W/m² per band, and as colours
/// what that radiosity looks like under `exposure` and `tone_map`. Positions are in metres, in the
/// coordinates of the scene's file, which count from `origin` here ([`crate::scene::Scene::origin`]).
///
/// # Errors
/// A refusal of the system.
pub fn save_lit_mesh(
    path: &Path,
    mesh: &DisplayMesh,
    origin: DVec3,
    light: &PatchLight,
    shading: Shading,
    exposure: Exposure,
    tone_map: ToneMap,
) -> Result<(), ExportError> {
    let lit = &mesh.corners[..mesh.lit_corners];
    let radiosity = match light.detail.as_deref() {
        Some(detail) => {
            mesh.detailed_radiosity(&light.radiosity, &light.irradiance, Some(in_detail(detail)), shading)
        }
        None => mesh.corner_values(&light.radiosity, shading),
    };
    let factor = exposure.factor();
    let colour = |b: &[f32; 3]| {
        let mapped = tone_map.apply(b.map(|value| value * factor));
        mapped.map(|value| (srgb_encode(value) * 255.0).round() as u8)
    };
    let positions: Vec<[f64; 3]> =
        lit.iter().map(|c| (c.position.as_dvec3() + mesh.origin + origin).to_array()).collect();
    let triangles: Vec<[u32; 3]> = mesh
        .batches
        .iter()
        .flat_map(|b| mesh.indices[b.indices.start as usize..b.indices.end as usize].as_chunks::<3>().0)
        .copied()
        .collect();
    let lit_mesh = LitMesh {
        positions: &positions,
        normals: &lit.iter().map(|c| c.normal.to_array()).collect::<Vec<_>>(),
        radiosity: &radiosity,
        colours: &radiosity.iter().map(colour).collect::<Vec<_>>(),
        triangles: &triangles,
    };
    write_ply(path, &lit_mesh)
}
