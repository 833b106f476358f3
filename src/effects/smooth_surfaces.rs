use super::Finding;
use crate::mesh::PatchMesh;

/// Smooth shading is called for where the model gives normals that differ from those of its facets.
pub(super) fn find(mesh: &PatchMesh) -> Finding {
    let curved = mesh
        .pieces
        .iter()
        .filter(|piece| {
            let flat = mesh.regions[piece.region as usize].frame.normal;
            mesh.corners_of(piece).iter().any(|c| c.normal.dot(flat) < 0.9999)
        })
        .count();
    let called_for = curved > 0;
    Finding {
        called_for,
        reason: if called_for {
            "the model gives curved surfaces smooth normals, so shading runs across their facets".to_owned()
        } else {
            "every surface is flat".to_owned()
        },
        evidence: format!("{curved} of {} pieces have normals off their plane", mesh.pieces.len()),
        predicted_cost: "shared vertices at display; nothing in rows or sweeps".to_owned(),
    }
}
