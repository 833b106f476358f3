use super::Finding;
use crate::mesh::PatchMesh;
use crate::scene::{Scene, grouped};

/// Holes are called for where a surface's image is transparent in part.
pub(super) fn find(scene: &Scene, mesh: &PatchMesh) -> Finding {
    let has_holes = |material: u32| scene.has_holes(material);
    let surfaces = scene.surfaces.iter().filter(|s| s.luminaire.is_none() && has_holes(s.material)).count();
    let called_for = surfaces > 0;
    let told = |n: usize| grouped(n as i64);
    let perforated: Vec<_> =
        mesh.panes.list.iter().filter_map(|pane| Some((pane.area(), pane.perforated?.opacity))).collect();
    let area: f64 = perforated.iter().map(|(area, _)| area).sum();
    let open: f64 = perforated.iter().map(|(area, opacity)| area * (1.0 - opacity)).sum();
    let evidence = match (perforated.len(), called_for) {
        (_, false) => format!("0 of {} materials have holes", scene.materials.len()),
        (0, true) => format!("{} surfaces with holes, which are opaque", told(surfaces)),
        (pieces, true) => format!(
            "{} pieces with {area:.1} m², {:.0} % of it open",
            told(pieces),
            100.0 * open / area.max(f64::MIN_POSITIVE)
        ),
    };
    Finding {
        called_for,
        reason: match called_for {
            true => "light passes leaves, screens and fabrics where their images are transparent".to_owned(),
            false => "no image is transparent".to_owned(),
        },
        evidence,
        predicted_cost: "a cut with each such piece a row, and parts of direct light behind it".to_owned(),
    }
}
