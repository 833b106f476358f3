//! What is doubtful about the model on screen: examined in the background, chosen in the panel, shown
//! in the view.

use super::app::App;
use super::background::Background;
use super::banners::Banner;
use super::command::Command;
use super::panels::Model;
use super::panels::menu::frame_name;
use super::prepared::Prepared;
use crate::geometry::{Aabb, Ray, polygon};
use crate::mesh;
use crate::scene::{self, Examination, Finding, FindingKind, Scene, Severity, View};
use glam::DVec3;
use std::sync::Arc;

/// What the panel asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ask {
    /// Show or hide the panel.
    Toggle,
    /// Show where this finding is, while the cursor rests on it.
    Hover(usize),
    /// Look into this finding and go to its first place; once more: leave it.
    Select(usize),
    /// Go to this place of the finding that is looked into.
    Place(usize),
}

/// One place of a finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Spot {
    /// Index into the scene's surfaces.
    Face(u32),
    /// Metres.
    Edge([DVec3; 2]),
    /// Metres.
    Point(DVec3),
}

/// The places of a finding in the order of the panel: those first that say most exactly where it is.
pub(super) fn spot(finding: &Finding, place: usize) -> Option<Spot> {
    use FindingKind::{Crack, Interpenetration, Leak, TVertex};
    let places = &finding.places;
    let (faces, lines) = (places.faces.len(), places.edges.len() + places.points.len());
    // Of a seam the faces beside it tell less than the seam itself.
    let seam = matches!(finding.kind, Crack | Interpenetration | Leak | TVertex);
    let (before, face, line) = match seam {
        true => (lines, place.checked_sub(lines), Some(place)),
        false => (faces, Some(place), place.checked_sub(faces)),
    };
    let line = line.filter(|_| (place < before) == seam).and_then(|k| {
        let edge = places.edges.get(k).map(|&edge| Spot::Edge(edge));
        edge.or_else(|| places.points.get(k - places.edges.len()).map(|&point| Spot::Point(point)))
    });
    let face = face.filter(|_| (place < before) != seam);
    line.or_else(|| places.faces.get(face?).map(|&face| Spot::Face(face)))
}

/// How many places a finding remembers.
pub(super) fn spots(finding: &Finding) -> usize {
    finding.places.faces.len() + finding.places.edges.len() + finding.places.points.len()
}

/// What was found in a scene and its patches, worst first.
pub(super) struct Report {
    scene: Arc<Scene>,
    examination: Examination,
    pub(super) findings: Vec<Finding>,
}

impl Report {
    fn of(scene: Arc<Scene>, mesh: &mesh::PatchMesh, before: Option<Arc<Self>>) -> Self {
        // Another mesh of the same scene: its faces are the same.
        let known = before.filter(|report| Arc::ptr_eq(&report.scene, &scene));
        let examination = known.map_or_else(|| scene::examine(&scene), |report| report.examination.clone());
        let mut findings = scene.findings.clone();
        findings.extend(examination.findings.iter().cloned());
        findings.extend(mesh::checkup(&scene, mesh, &examination.crossings));
        findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        Self { scene, examination, findings }
    }

    /// How many findings matter this much.
    pub(super) fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }
}

/// The doctor of the window.
#[derive(Default)]
pub(super) struct Doctor {
    background: Background<u64, Report>,
    /// The mesh on screen.
    mesh_serial: u64,
    /// The finding looked into.
    pub(super) selected: Option<usize>,
    /// Its place gone to last.
    pub(super) place: usize,
    /// The finding under the cursor.
    pub(super) hovered: Option<usize>,
}

impl Doctor {
    /// Examines what is on screen, once, on a thread of its own. `wake` is called when that is done.
    pub(super) fn follow(&mut self, prepared: &Arc<Prepared>, wake: impl FnOnce() + Send + 'static) {
        self.background.listen();
        if self.mesh_serial != prepared.mesh_serial {
            self.mesh_serial = prepared.mesh_serial;
            (self.selected, self.hovered, self.place) = (None, None, 0);
        }
        if self.background.is_open(&prepared.mesh_serial) {
            let before = self.background.latest().map(|(_, report)| Arc::clone(report));
            let (scene, mesh) = (Arc::clone(&prepared.scene), Arc::clone(&prepared.mesh));
            self.background.ask(&prepared.mesh_serial, move || Report::of(scene, &mesh, before), wake);
        }
    }

    /// What was found in what is on screen; `None` until it is known.
    pub(super) fn report(&self) -> Option<&Report> {
        let (serial, report) = self.background.latest()?;
        (*serial == self.mesh_serial).then_some(&**report)
    }

    /// The finding to show in the view, and which of its places stands out.
    pub(super) fn shown(&self) -> Option<(&Finding, Option<usize>)> {
        let report = self.report()?;
        let number = self.hovered.or(self.selected)?;
        let place = (self.selected == Some(number)).then_some(self.place);
        report.findings.get(number).map(|finding| (finding, place))
    }
}

/// That the model seems to lie on its side or to be in another unit, with a button that sets it right.
pub(super) fn frame_banner(model: &Model<'_>) -> Option<Banner> {
    let scene = model.scene.filter(|scene| scene.source.path().is_some())?;
    let mut doubts = scene.findings.iter().filter(|finding| finding.severity >= Severity::Warning);
    let Some((unit, up)) = doubts.find_map(|finding| finding.remedy) else {
        return turned_banner(scene);
    };
    let mut seems = Vec::new();
    if up != scene.up {
        seems.push("to lie on its side".to_owned());
    }
    if unit != scene.unit {
        seems.push(format!("to be in {} rather than {}", unit.name(), scene.unit.name()));
    }
    Some(Banner {
        key: "frame",
        is_warning: true,
        text: format!("This model seems {}. The doctor (K) says why.", seems.join(", and ")),
        actions: vec![(format!("Set {}", frame_name(unit, up)), Command::SetFrame(unit, up))],
    })
}

/// That z was taken for up, with buttons for either answer.
fn turned_banner(scene: &Scene) -> Option<Banner> {
    let told = scene.findings.iter().find(|finding| finding.kind == FindingKind::UpAxis)?;
    let (unit, up) = told.remedy.filter(|(_, up)| *up != scene.up)?;
    Some(Banner {
        key: "turned",
        is_warning: false,
        text: "Z was taken for up in this model. The doctor (K) says why.".to_owned(),
        actions: vec![
            ("Keep z up".to_owned(), Command::SetFrame(unit, scene.up)),
            (format!("Set {}", frame_name(unit, up)), Command::SetFrame(unit, up)),
        ],
    })
}

impl App {
    /// Does what the panel asks for.
    pub(super) fn ask_doctor(&mut self, ask: Ask) {
        match ask {
            Ask::Toggle => {
                self.visit.doctor_open = !self.visit.doctor_open;
                // There is room for one of them under the view.
                self.visit.table_open &= !self.visit.doctor_open;
                self.doctor.selected = None;
            }
            Ask::Hover(finding) => self.doctor.hovered = Some(finding),
            Ask::Select(finding) if self.doctor.selected == Some(finding) => self.doctor.selected = None,
            Ask::Select(finding) => {
                self.doctor.selected = Some(finding);
                self.go_to_place(0);
            }
            Ask::Place(place) => self.go_to_place(place),
        }
    }

    fn go_to_place(&mut self, place: usize) {
        self.doctor.place = place;
        let finding = self.doctor.selected.zip(self.doctor.report()).and_then(|(k, r)| r.findings.get(k));
        let Some(spot) = finding.and_then(|finding| spot(finding, place)) else { return };
        let Some(prepared) = self.picture.prepared.clone() else { return };
        let (bounds, normal) = match spot {
            Spot::Face(face) => {
                let Some(surface) = prepared.scene.surfaces.get(face as usize) else { return };
                let outline = prepared.scene.polygon(surface);
                (Aabb::around(outline.iter().copied()), polygon::area_vector(&outline).normalize_or_zero())
            }
            Spot::Edge(edge) => (Aabb::around(edge), DVec3::ZERO),
            Spot::Point(point) => (Aabb::around([point]), DVec3::ZERO),
        };
        self.look_at(&prepared, &bounds, normal);
    }

    /// Glides to where something is seen well.
    fn look_at(&mut self, prepared: &Prepared, what: &Aabb, normal: DVec3) {
        self.touring = None;
        // A row of form factors is grey nearly everywhere, and a finding is no part of it.
        self.leave_row();
        let Some(camera) = &mut self.camera else { return };
        let eye = standpoint(prepared, what, normal, camera.pose().eye);
        let (target, fov_y_deg) = (what.centre(), camera.pose().fov_y_deg);
        self.fly_to(&View { name: String::new(), eye, target, fov_y_deg });
    }
}

/// Where something is seen well from: from that side, of several, from which it can be looked at from furthest
/// away, a side that is drawn, its front and the side of `from` being preferred. From below the floor, or with something in between,
/// only where there is no other place.
fn standpoint(prepared: &Prepared, what: &Aabb, normal: DVec3, from: DVec3) -> DVec3 {
    let (size, centre, up) = (prepared.mesh.size, what.centre(), prepared.scene.up.vector());
    let wanted = (2.2 * what.diagonal()).clamp(0.06 * size, 0.6 * size);
    let here = (from - centre).normalize_or(up);
    let mut ways = vec![here];
    for x in [-1.0, 0.0, 1.0] {
        for y in [-0.6, 0.0, 0.6] {
            ways.extend(
                [-1.0, 0.0, 1.0].map(|z| DVec3::new(x, y, z)).into_iter().filter_map(DVec3::try_normalize),
            );
        }
    }
    let first_hit = |origin: DVec3, way: DVec3, reach: f64| {
        prepared.picker.nearest(&Ray { origin, direction: way }, reach).map(|hit| hit.distance)
    };
    let free = |way: DVec3| {
        first_hit(centre + way * (1e-3 * size), way, wanted).map_or(wanted, |distance| 0.85 * distance)
    };
    let eye = |way: DVec3| centre + way * free(way).max(0.01 * size);
    // A side that no light reaches is not drawn: one looks through it.
    let is_drawn = |eye: DVec3| {
        let distance = eye.distance(centre);
        let ray = Ray { origin: eye, direction: (centre - eye) / distance };
        prepared.picker.pick(&ray).is_some_and(|hit| (hit.distance - distance).abs() < 3e-3 * size)
    };
    let is_seen = |eye: DVec3| {
        let distance = eye.distance(centre);
        let reach = distance - 3e-3 * size;
        reach <= 0.0 || first_hit(eye, (centre - eye) / distance, reach).is_none()
    };
    let lowest = prepared.bounds.min.dot(up);
    let is_above_a_floor = |eye: DVec3| eye.dot(up) > lowest && prepared.obstacles.floor_below(eye).is_some();
    let worth = |way: DVec3| {
        let front =
            if normal == DVec3::ZERO { 0.3 } else { 0.8 * way.dot(normal).abs() + 0.1 * way.dot(normal) };
        let eye = eye(way);
        let hidden = if is_seen(eye) { 0.0 } else { 4.0 };
        let outside = if is_above_a_floor(eye) { 0.0 } else { 2.0 };
        let drawn = if is_drawn(eye) { 1.5 } else { 0.0 };
        free(way) / wanted + front + 0.6 * way.dot(here) + drawn - hidden - outside
    };
    let best = ways.into_iter().map(|way| (worth(way), way)).max_by(|a, b| a.0.total_cmp(&b.0));
    eye(best.map_or(here, |(_, way)| way))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_there_once_and_seams_come_before_faces() {
        let far = DVec3::splat(9.0);
        for kind in [FindingKind::Crack, FindingKind::Winding] {
            let mut finding = Finding::new(kind, Severity::Note, "");
            finding.places.faces = vec![7, 8];
            finding.places.edges = vec![[DVec3::ZERO, DVec3::X], [DVec3::ZERO, DVec3::Y]];
            finding.places.points = vec![far];
            let all: Vec<Spot> = (0..spots(&finding)).filter_map(|place| spot(&finding, place)).collect();
            let (x, y) = (Spot::Edge([DVec3::ZERO, DVec3::X]), Spot::Edge([DVec3::ZERO, DVec3::Y]));
            let expected = match kind {
                FindingKind::Crack => [x, y, Spot::Point(far), Spot::Face(7), Spot::Face(8)],
                _ => [Spot::Face(7), Spot::Face(8), x, y, Spot::Point(far)],
            };
            assert_eq!(all, expected);
            assert_eq!(spot(&finding, 5), None);
        }
    }
}
