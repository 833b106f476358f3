use super::Finding;
use crate::mesh::PatchMesh;

/// Three bands are called for where a reflectance or a lamp's pattern differs between them. The
/// colour of a lamp as a whole does not count: it scales its basis.
pub(super) fn find(mesh: &PatchMesh) -> Finding {
    let coloured = |c: &[f64; 3]| c[0] != c[1] || c[1] != c[2];
    let surfaces = mesh.patches.iter().filter(|p| coloured(&p.reflectance)).count();
    let lamps = mesh.patches.iter().filter(|p| coloured(&p.emission_weight)).count();
    let tinted = mesh.panes.is_tinted() || mesh.translucence.is_tinted();
    let called_for = surfaces + lamps > 0 || tinted;
    Finding {
        called_for,
        reason: if surfaces + lamps == 0 && tinted {
            "tinted glass or cloth colours the light that passes it".to_owned()
        } else if called_for {
            "colours of surfaces mix into the light that they reflect".to_owned()
        } else {
            "every surface is grey, so one band stands for all three".to_owned()
        },
        evidence: format!(
            "{surfaces} of {} patches have a coloured reflectance, {lamps} a coloured pattern of emission",
            mesh.patches.len()
        ),
        predicted_cost: "three columns a lamp in every sweep in place of one; rows are shared".to_owned(),
    }
}
