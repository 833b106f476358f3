use crate::accuracy::{Answer, Audit, AuditSettings, Findings, Shown};
use crate::display::{DisplayMesh, Shading};
use crate::effects::Effect;
use crate::mesh::PatchMesh;
use crate::outputs::in_detail;
use crate::scene::Lighting;
use crate::solve::Solution;
use crate::solver::{Detail, PatchLight, patch_emission};
use std::sync::Arc;

/// What of it is direct light on elements; `None` where patches carry all.
fn direct_shown(mesh: &PatchMesh, display: &DisplayMesh, light: &PatchLight) -> Option<Shown> {
    let detail = light.detail.as_deref()?;
    display.elements()?;
    let interreflected = vec![[0.0; 3]; detail.interreflected.len()];
    let alone = Detail { interreflected, ..Detail::clone(detail) };
    Some(shown(mesh, display, &PatchLight { detail: Some(Arc::new(alone)), ..light.clone() }))
}

/// The irradiance that the picture shows of this light, interpolated on its triangles, W/m² per band.
pub fn shown(mesh: &PatchMesh, display: &DisplayMesh, light: &PatchLight) -> Shown {
    let detail = light.detail.as_deref().map(in_detail);
    let values = display.detailed_irradiance(&light.irradiance, detail, Shading::Gouraud);
    let faces = display.faces().iter();
    let faces = faces.map(|face| face.map(|c| values.get(c as usize).copied().unwrap_or_default())).collect();
    debug_assert!(display.elements().is_some() || display.faces().len() == 2 * mesh.triangles().0.len());
    Shown { faces, elements: display.elements().cloned() }
}

/// Audits a finished solve under this lighting, as the picture shows it. Where the plan has curved surfaces shaded smoothly
/// the truth is the light on those: at places of the facets, with the normals of the surfaces that they stand for.
///
/// `stop` ends it early; `None` then, and where no light arrives.
pub fn audit(
    solved: &Solution,
    lighting: &Lighting,
    settings: &AuditSettings,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Findings> {
    let elements = solved.element_light.as_ref().map(|light| &light.elements);
    let light = solved.light(lighting);
    let smooth = solved.plan.is_on(Effect::SmoothSurfaces);
    let display = DisplayMesh::build_on(&solved.mesh, &solved.scene, smooth, elements);
    let direct = direct_shown(&solved.mesh, &display, &light);
    let shown = shown(&solved.mesh, &display, &light);
    let exitance: Vec<[f32; 3]> = solved.mesh.patches.iter().map(|p| patch_emission(p, lighting)).collect();
    let answer = Answer {
        mesh: &solved.mesh,
        transport: solved.transport.as_deref()?,
        light: &light,
        exitance: &exitance,
        lighting,
        reflectance: &solved.reflectance,
        shown: &shown,
        smooth,
        direct: direct.as_ref(),
    };
    Audit::new(answer)?.run(settings, stop)
}
