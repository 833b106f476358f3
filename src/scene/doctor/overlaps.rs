//! The findings between pairs of faces.

use super::pairs::Pairs;
use super::survey::Survey;
use crate::scene::finding::{Finding, FindingKind, Places, Severity};
use crate::scene::names;

/// Tells of overlaps and of faces that cut through each other.
pub(super) fn report(survey: &Survey<'_>, pairs: &Pairs, findings: &mut Vec<Finding>) {
    let mut covering: Vec<u32> = pairs.overlaps.iter().map(|pair| pair[1]).collect();
    covering.sort_unstable();
    covering.dedup();
    if !covering.is_empty() {
        let message = format!(
            "faces that lie on others in the same plane ({}, in {}); cut a hole or move one by a millimetre",
            covering.len(),
            names::list(covering.iter().map(|&face| survey.object_of(face)))
        );
        findings.push(
            Finding::new(FindingKind::Overlap, Severity::Warning, message)
                .counted(covering.len())
                .with("it is chance which of them is lit and seen")
                .at(Places::of_faces(covering)),
        );
    }
    if !pairs.crossings.is_empty() {
        let mut couples: Vec<[u32; 2]> = pairs.crossings.iter().map(|c| c.faces).collect();
        couples.dedup();
        let mut faces: Vec<u32> = couples.iter().flatten().copied().collect();
        faces.sort_unstable();
        faces.dedup();
        let message = format!(
            "pairs of faces that cut through each other ({}, in {})",
            couples.len(),
            names::list(faces.iter().map(|&face| survey.object_of(face)))
        );
        let mut places = Places::of_faces(faces);
        pairs.crossings.iter().for_each(|c| places.add_edge(c.segment));
        findings.push(
            Finding::new(FindingKind::Interpenetration, Severity::Note, message)
                .counted(couples.len())
                .with("visibility follows them exactly, and patches end there, except along short cuts")
                .at(places),
        );
    }
    if let Some(looked_at) = pairs.ended_at {
        let message = format!(
            "the model has too many faces that touch; overlaps and cuts were looked for among the first \
             {looked_at} of {} faces",
            survey.planes.len()
        );
        findings.push(Finding::new(FindingKind::Unsearched, Severity::Note, message));
    }
}
