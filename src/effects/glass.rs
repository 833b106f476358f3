use super::Finding;
use crate::mesh::PatchMesh;
use crate::scene::{Scene, grouped};

/// Glass is called for where surfaces of it stand in the scene.
pub(super) fn find(scene: &Scene, mesh: &PatchMesh) -> Finding {
    let panes = mesh.panes.glass().count();
    // Where it is switched off no pane was made.
    let surfaces = scene
        .surfaces
        .iter()
        .filter(|s| s.luminaire.is_none() && scene.materials[s.material as usize].glazing.is_some())
        .count();
    let called_for = surfaces > 0;
    let told = |n: usize| grouped(n as i64);
    let evidence = match (panes, called_for) {
        (_, false) => format!("0 of {} materials are glass", scene.materials.len()),
        (0, true) => format!("{} surfaces of glass, which are opaque", told(surfaces)),
        (_, true) => format!(
            "{} {} of glass with {:.1} m²{}",
            told(panes),
            if panes == 1 { "face" } else { "faces" },
            mesh.panes.area,
            if mesh.panes.is_tinted() { ", some tinted" } else { "" }
        ),
    };
    Finding {
        called_for,
        reason: match called_for {
            true => "light passes the panes of the scene, less of it the more it slants".to_owned(),
            false => "no surface is glass".to_owned(),
        },
        evidence,
        predicted_cost: match mesh.panes.is_tinted() {
            true => "a cut with each pane a row, and direct light of each lamp in three bands".to_owned(),
            false => {
                "a cut with each pane a row; direct light in as many parts more as panes stand before a lamp"
                    .to_owned()
            }
        },
    }
}
