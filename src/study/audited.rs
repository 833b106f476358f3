use crate::accuracy::{Answer, Audit, AuditSettings, Findings, Shown};
use crate::display::{DisplayMesh, Shading};
use crate::effects::Effect;
use crate::mesh::PatchMesh;
use crate::outputs::in_detail;
use crate::scene::Lighting;
use crate::solve::Solution;
use crate::solver::{PatchLight, patch_emission};

/// The irradiance that the picture shows of this light, interpolated on its triangles, W/m² per band.
pub fn shown(mesh: &PatchMesh, display: &DisplayMesh, light: &PatchLight) -> Shown {
    let detail = light.detail.as_deref().map(in_detail);
    let values = display.detailed_irradiance(&light.irradiance, detail, Shading::Gouraud);
    let faces = display.faces().iter();
    let faces = faces.map(|face| face.map(|c| values.get(c as usize).copied().unwrap_or_default())).collect();
    debug_assert!(display.elements().is_some() || display.faces().len() == 2 * mesh.triangles().0.len());
    Shown { faces, elements: display.elements().cloned() }
}

/// Audits a finished solve under this lighting, as the picture shows it on each facet. Where the plan has curved surfaces
/// shaded smoothly, what that changes is told beside the errors: the light is that of the facets.
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
    let picture = |smooth: bool| {
        shown(&solved.mesh, &DisplayMesh::build_on(&solved.mesh, &solved.scene, smooth, elements), &light)
    };
    let facets = picture(false);
    let smoothed = solved.plan.is_on(Effect::SmoothSurfaces).then(|| picture(true));
    let exitance: Vec<[f32; 3]> = solved.mesh.patches.iter().map(|p| patch_emission(p, lighting)).collect();
    let answer = Answer {
        mesh: &solved.mesh,
        transport: solved.transport.as_deref()?,
        light: &light,
        exitance: &exitance,
        lighting,
        reflectance: &solved.reflectance,
        shown: &facets,
        smoothed: smoothed.as_ref(),
    };
    Audit::new(answer)?.run(settings, stop)
}
