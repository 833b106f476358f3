//! Lamps that are missing, dark or covered.

use super::WELD;
use super::survey::Survey;
use crate::geometry::Ray;
use crate::scene::finding::{Finding, FindingKind, Places, Severity};
use crate::scene::names;
use glam::DVec3;

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
    let (mut covered, mut taken) = (Vec::new(), Vec::new());
    for (face, surface) in scene.surfaces.iter().enumerate() {
        let Some(number) = surface.luminaire else { continue };
        let front = survey.planes[face].normal;
        let thickness = WELD * diagonal;
        let middles = survey.triangles_of(face as u32).iter().map(|&[a, b, c]| (a + b + c) / 3.0);
        // What lies on its back is not in front of it.
        let is_covered = |origin: DVec3| {
            survey.bvh.occluded(&Ray { origin, direction: front }, thickness, 1e-4 * diagonal)
        };
        let is_opposite = |t: u32| survey.normal_of(t).dot(front) < -0.99;
        let is_taken = |origin: DVec3| {
            let ray = Ray { origin: origin + front * thickness, direction: -front };
            survey.bvh.occluded_where(&ray, 0.0, 2.0 * thickness, is_opposite)
        };
        if !surface.emits_back {
            covered.extend(middles.into_iter().any(is_covered).then_some((number, face as u32)));
        } else {
            taken.extend(middles.into_iter().any(is_taken).then_some((number, face as u32)));
        }
    }
    for (found, what, consequence) in [
        (
            covered,
            "meets a surface right in front of it; turn its faces or set emits = \"back\"",
            "what it emits there lights nothing else",
        ),
        (
            taken,
            "that leaves from its back does so where other faces look the same way; remove these",
            "it is chance which of them is lit and seen",
        ),
    ] {
        if found.is_empty() {
            continue;
        }
        let lamps = names::list(found.iter().map(|&(n, _)| scene.luminaires[n as usize].name.as_str()));
        let finding = warning(format!("the light of {lamps} {what}")).counted(found.len()).with(consequence);
        findings.push(finding.at(Places::of_faces(found.iter().map(|&(_, face)| face))));
    }
}
