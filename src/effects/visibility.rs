use super::Finding;
use crate::mesh::{PatchMesh, Side};

/// Occlusion can be left out only where no surface can stand between two others: a convex room
/// without inner surfaces, every surface of it on the rim.
pub(super) fn find(mesh: &PatchMesh) -> Finding {
    let regions = mesh.regions.len();
    let backs = mesh.patches.iter().filter(|p| p.side == Side::Back).count();
    // The first surface that has something behind its plane proves that the room is not convex.
    let blocker = first_blocker(mesh);
    let predicted_cost = if mesh.clusters.is_empty() {
        format!("one sweep over the {regions} regions a row, most of the time of a solve")
    } else {
        format!("rays in place of lines, each through a tree over the {regions} regions")
    };
    if !mesh.panes.is_empty() {
        return Finding {
            called_for: true,
            reason: "panes of glass stand between surfaces".to_owned(),
            evidence: format!("{} faces of glass", mesh.panes.list.len()),
            predicted_cost,
        };
    }
    match (backs, blocker) {
        (0, None) => Finding {
            called_for: false,
            reason: "the scene is convex without inner surfaces, so every patch sees every other whole"
                .to_owned(),
            evidence: format!(
                "all {} vertices lie on or before the planes of all {regions} regions",
                mesh.vertices.len()
            ),
            predicted_cost,
        },
        (0, Some(_)) => Finding {
            called_for: true,
            reason: "surfaces stand before others and can cast shadows".to_owned(),
            evidence: format!("{regions} regions, at least one with something behind its plane"),
            predicted_cost,
        },
        (backs, _) => Finding {
            called_for: true,
            reason: "light reaches surfaces from both sides, so they stand inside the scene".to_owned(),
            evidence: format!("{backs} patches on backs of {regions} regions"),
            predicted_cost,
        },
    }
}

/// Whether nothing lies behind the front of any surface: from inside nothing is hidden.
pub(super) fn is_convex(mesh: &PatchMesh) -> bool {
    first_blocker(mesh).is_none()
}

/// The first region that has a vertex of the scene behind its plane.
fn first_blocker(mesh: &PatchMesh) -> Option<usize> {
    let slack = 1e-6 * mesh.size;
    mesh.regions
        .iter()
        .position(|region| mesh.vertices.iter().any(|v| region.frame.normal.dot(*v - region.origin) < -slack))
}
