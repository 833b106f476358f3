use super::Finding;
use crate::mesh::PatchMesh;
use crate::scene::{Scene, grouped};

/// Translucency is called for where a material in use passes light diffusely.
pub(super) fn find(scene: &Scene, mesh: &PatchMesh) -> Finding {
    let is_translucent = |material: u32| scene.materials[material as usize].is_translucent();
    let surfaces = scene.surfaces.iter().filter(|surface| is_translucent(surface.material)).count();
    let called_for = surfaces > 0;
    let told = |n: usize| grouped(n as i64);
    let evidence = match (mesh.translucence.len(), called_for) {
        (_, false) => format!("0 of {} materials are translucent", scene.materials.len()),
        (0, true) => format!("{} surfaces of translucent material, which pass nothing", told(surfaces)),
        (patches, true) => format!(
            "{} patches with {:.1} m² pass light{}",
            told(patches),
            mesh.translucence.area(mesh),
            if mesh.translucence.is_tinted() { ", some tinted" } else { "" }
        ),
    };
    Finding {
        called_for,
        reason: match called_for {
            true => {
                "what arrives on one side of cloth, paper or opal glass leaves its other side, too".to_owned()
            }
            false => "no surface passes light diffusely".to_owned(),
        },
        evidence,
        predicted_cost: "a look at the far side of each such patch a sweep; rows are the same".to_owned(),
    }
}
