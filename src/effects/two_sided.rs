use super::Finding;
use crate::mesh::{PatchMesh, Side};

/// Patches on backs are called for where light reaches both sides of a surface.
pub(super) fn find(mesh: &PatchMesh) -> Finding {
    let backs = mesh.patches.iter().filter(|p| p.side == Side::Back).count();
    let called_for = backs > 0;
    Finding {
        called_for,
        reason: if called_for {
            "light reaches the backs of some surfaces".to_owned()
        } else {
            "no light reaches the back of any surface".to_owned()
        },
        evidence: format!("{backs} of {} patches lie on backs", mesh.patches.len()),
        predicted_cost: format!("{backs} rows and unknowns"),
    }
}
