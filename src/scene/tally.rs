//! What happened to several faces or things of a file alike, counted: one finding for all of them.

use super::finding::{Finding, FindingKind, MOST_PLACES, Places, Severity, line_list};
use super::names;
use glam::DVec3;
use std::collections::HashMap;

/// Faces that met the same fate.
#[derive(Default)]
pub(super) struct Tally {
    /// Their object numbers.
    objects: Vec<u32>,
    /// Outlines, as edges, and lines of the file where they have some; the first ones.
    places: Places,
    /// How many there are in `places`.
    shown: usize,
}

impl Tally {
    pub(super) fn add(&mut self, object: u32, line: Option<u32>, outline: impl Iterator<Item = DVec3>) {
        self.objects.push(object);
        if self.shown == MOST_PLACES {
            return;
        }
        self.shown += 1;
        self.places.lines.extend(line);
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

/// Remarks about named things: one finding for all things of which the same is said.
#[derive(Default)]
pub(super) struct Remarks {
    list: Vec<Remark>,
    numbers: HashMap<(Severity, String), usize>,
}

struct Remark {
    kind: FindingKind,
    severity: Severity,
    what: String,
    things: Vec<String>,
}

impl Remarks {
    /// Says `what` (in the plural, without a full stop) of a thing, as it is to be listed.
    pub(super) fn add(&mut self, kind: FindingKind, severity: Severity, what: &str, thing: String) {
        let number = *self.numbers.entry((severity, what.to_owned())).or_insert_with(|| {
            self.list.push(Remark { kind, severity, what: what.to_owned(), things: Vec::new() });
            self.list.len() - 1
        });
        self.list[number].things.push(thing);
    }

    /// The findings, in the order in which their kinds came first.
    pub(super) fn findings(&self) -> impl Iterator<Item = Finding> {
        self.list.iter().map(|Remark { kind, severity, what, things }| {
            let message = format!("{what}: {}", names::joined(things));
            Finding::new(*kind, *severity, message).counted(things.len())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_remarks_are_one_finding() {
        let mut remarks = Remarks::default();
        for k in 0..182 {
            remarks.add(
                FindingKind::Material,
                Severity::Warning,
                "materials without a Kd",
                format!("'m{k}'"),
            );
        }
        remarks.add(FindingKind::Material, Severity::Note, "materials without a Kd", "'x'".to_owned());
        let findings: Vec<Finding> = remarks.findings().collect();
        assert_eq!((findings.len(), findings[0].count), (2, 182));
        assert_eq!(findings[0].message, "materials without a Kd: 'm0', 'm1', 'm2', 'm3' and 178 more");
    }
}
