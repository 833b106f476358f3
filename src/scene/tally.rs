//! Faces of a file that met the same fate, counted with their places.

use super::finding::{Finding, FindingKind, MOST_PLACES, Places, Severity, line_list};
use super::names;
use glam::DVec3;

/// Faces that met the same fate.
#[derive(Default)]
pub(super) struct Tally {
    /// Their object numbers.
    objects: Vec<u32>,
    /// Outlines, as edges, and lines of the file; the first ones.
    places: Places,
}

impl Tally {
    pub(super) fn add(&mut self, object: u32, line: u32, outline: impl Iterator<Item = DVec3>) {
        self.objects.push(object);
        if self.places.lines.len() == MOST_PLACES {
            return;
        }
        self.places.lines.push(line);
        let outline: Vec<DVec3> = outline.collect();
        for k in 0..outline.len() {
            self.places.add_edge([outline[k], outline[(k + 1) % outline.len()]]);
        }
    }

    pub(super) fn report(
        &mut self,
        objects: &[String],
        (kind, severity): (FindingKind, Severity),
        what: &str,
        consequence: &'static str,
        findings: &mut Vec<Finding>,
    ) {
        let count = self.objects.len();
        if count == 0 {
            return;
        }
        let place = names::list(self.objects.iter().map(|&o| objects[o as usize].as_str()));
        let lines = line_list(&self.places.lines, count);
        let finding = Finding::new(kind, severity, format!("{what} ({count}, in {place}{lines})"));
        findings.push(finding.counted(count).with(consequence).at(std::mem::take(&mut self.places)));
    }
}
