//! Lamps that are missing, dark or covered.

use super::survey::Survey;
use crate::geometry::Ray;
use crate::scene::finding::{Finding, FindingKind, Places, Severity};
use crate::scene::names;

/// Looks at the lamps.
pub(super) fn check(survey: &Survey<'_>, findings: &mut Vec<Finding>) {
    let (scene, diagonal) = (survey.scene, survey.diagonal);
    let warning = |message: String| Finding::new(FindingKind::Lamp, Severity::Warning, message);
    if scene.luminaires.is_empty() {
        let message = format!(
            "this scene has no lamp: add ceiling lamps (Edit in the window, --ceiling-lamps on the command line), \
             give a material an emission Ke, or name an object in {}.toml as a [[luminaire]] with its lumens",
            scene.name
        );
        findings.push(warning(message).with("nothing is solved; pictures show it in plain even light"));
        return;
    }
    if scene.luminaires.iter().all(|l| l.initial.output().iter().all(|e| *e <= 0.0)) {
        let is_strong = |e: [f64; 3]| e.iter().any(|e| *e > 0.0);
        let what = match scene.luminaires.iter().any(|l| is_strong(l.initial.exitance)) {
            true => "all lamps are off, so the scene starts dark",
            false => "no lamp gives any light, so everything is black",
        };
        let finding = warning(what.to_owned());
        findings.push(finding.counted(scene.luminaires.len()));
    }
    let mut covered = Vec::new();
    for (face, surface) in scene.surfaces.iter().enumerate() {
        let Some(number) = surface.luminaire.filter(|_| !surface.emits_back) else { continue };
        for &[a, b, c] in survey.triangles_of(face as u32) {
            let Some(direction) = (b - a).cross(c - a).try_normalize() else { continue };
            let ray = Ray { origin: (a + b + c) / 3.0, direction };
            if survey.bvh.occluded(&ray, 1e-9 * diagonal, 1e-4 * diagonal) {
                covered.push((number, face as u32));
                break;
            }
        }
    }
    if !covered.is_empty() {
        let lamps = names::list(covered.iter().map(|&(n, _)| scene.luminaires[n as usize].name.as_str()));
        let message = format!(
            "the light of {lamps} meets a surface right in front of it; turn its faces or set emits = \"back\""
        );
        findings.push(
            warning(message)
                .counted(covered.len())
                .with("what it emits there lights nothing else")
                .at(Places::of_faces(covered.iter().map(|&(_, face)| face))),
        );
    }
}
