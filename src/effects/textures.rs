use super::Finding;
use crate::mesh::PatchMesh;
use crate::scene::Scene;

/// Textures are called for where a lit surface has an image for its reflectance.
pub(super) fn find(scene: &Scene, mesh: &PatchMesh) -> Finding {
    let textured =
        mesh.patches.iter().filter(|p| scene.materials[p.material as usize].texture.is_some()).count();
    let called_for = textured > 0;
    Finding {
        called_for,
        reason: if called_for {
            "images give some surfaces their reflectance, averaged a patch for the solution".to_owned()
        } else {
            "no lit surface has an image".to_owned()
        },
        evidence: format!("{textured} of {} patches, {} images", mesh.patches.len(), scene.textures.len()),
        predicted_cost: "64 samples of an image a patch triangle once; nothing in rows or sweeps".to_owned(),
    }
}
