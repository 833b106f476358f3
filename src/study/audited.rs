use crate::accuracy::{Answer, Audit, AuditSettings, Findings, Shown};
use crate::display::{DisplayMesh, Shading};
use crate::effects::Effect;
use crate::mesh::{PatchMesh, Side};
use crate::scene::Lighting;
use crate::solve::Solution;
use crate::solver::patch_emission;

/// The irradiance that the smoothly shaded picture shows, from one value a patch, W/m² per band.
pub fn shown(mesh: &PatchMesh, display: &DisplayMesh, irradiance: &[[f32; 3]]) -> Shown {
    let values = display.corner_values(irradiance, Shading::Gouraud);
    let triangles = mesh.triangles().0.len() as u32;
    let faces = (0..triangles)
        .flat_map(|triangle| [Side::Front, Side::Back].map(|side| display.face(triangle, side).0))
        .map(|corners| corners.map(|c| values.get(c as usize).copied().unwrap_or_default()))
        .collect();
    Shown { faces }
}

/// Audits a finished solve under this lighting, as the picture shows it: smooth over facets where that is
/// on in the solve's plan.
///
/// `stop` ends it early; `None` then, and where no light arrives.
pub fn audit(
    solved: &Solution,
    lighting: &Lighting,
    settings: &AuditSettings,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Findings> {
    let smooth = solved.plan.is_on(Effect::SmoothSurfaces);
    let display = DisplayMesh::build(&solved.mesh, &solved.scene, smooth);
    let light = solved.light(lighting);
    let shown = shown(&solved.mesh, &display, &light.irradiance);
    let exitance: Vec<[f32; 3]> = solved.mesh.patches.iter().map(|p| patch_emission(p, lighting)).collect();
    let answer = Answer {
        mesh: &solved.mesh,
        transport: solved.transport.as_deref()?,
        light: &light,
        exitance: &exitance,
        reflectance: &solved.reflectance,
        shown: &shown,
    };
    Audit::new(answer)?.run(settings, stop)
}
