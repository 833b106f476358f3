//! What is doubtful about a model that could be read: the findings of `lumenwalk check`.

use super::names;
use super::types::{Finding, LengthUnit, Scene, Severity};
use super::views::triangles;
use crate::geometry::{Bvh, Frame, Ray, polygon};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Corners nearer than this share of the scene's diagonal are one.
const WELD: f64 = 1e-6;
/// Rooms and houses are this high, metres; other heights make one doubt the unit.
const BELIEVABLE_HEIGHT: std::ops::RangeInclusive<f64> = 0.3..=60.0;
/// Pairs of coplanar faces looked at before the search for overlaps is given up.
const MOST_PAIRS: usize = 2_000_000;

/// Looks for what the reader cannot repair: open or wrongly turned faces, overlapping ones, missing
/// or dark lamps, a doubtful unit. The reader's own findings are in [`Scene::findings`].
pub fn check(scene: &Scene) -> Vec<Finding> {
    let mut findings = Vec::new();
    let diagonal = scene.bounds().diagonal();
    let tolerance = WELD * diagonal;
    check_edges(scene, &weld(&scene.positions, tolerance), tolerance, &mut findings);
    check_overlaps(scene, diagonal, &mut findings);
    check_lamps(scene, diagonal, &mut findings);
    check_height(scene, &mut findings);
    findings
}

/// For each position the first one at the same place to within `tolerance`.
fn weld(positions: &[DVec3], tolerance: f64) -> Vec<u32> {
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(positions.len());
    let scale = 1.0 / tolerance.max(f64::MIN_POSITIVE);
    let mut welded = Vec::with_capacity(positions.len());
    for (index, position) in positions.iter().enumerate() {
        let [x, y, z] = (*position * scale).floor().to_array().map(|c| c as i64);
        let near = (0..27).find_map(|k| {
            let cell =
                [x.saturating_add(k % 3 - 1), y.saturating_add(k / 3 % 3 - 1), z.saturating_add(k / 9 - 1)];
            let close = |&i: &u32| positions[i as usize].distance(*position) <= tolerance;
            cells.get(&cell).and_then(|list| list.iter().copied().find(close))
        });
        let number = near.unwrap_or(index as u32);
        if near.is_none() {
            cells.entry([x, y, z]).or_default().push(number);
        }
        welded.push(number);
    }
    welded
}

/// How often faces run along an edge, from its lower corner number to the higher and back.
#[derive(Clone, Copy, Debug, Default)]
struct Edge {
    forward: u32,
    backward: u32,
    object: u32,
}

type Edges = HashMap<(u32, u32), Edge>;

fn count_edge(edges: &mut Edges, from: u32, to: u32, object: u32) {
    let edge = edges.entry((from.min(to), from.max(to))).or_default();
    edge.object = object;
    *(if from < to { &mut edge.forward } else { &mut edge.backward }) += 1;
}

fn check_edges(scene: &Scene, welded: &[u32], tolerance: f64, findings: &mut Vec<Finding>) {
    let mut edges = Edges::new();
    for surface in &scene.surfaces {
        let n = surface.corners.len();
        for k in 0..n {
            let a = welded[surface.corners[k].position as usize];
            let b = welded[surface.corners[(k + 1) % n].position as usize];
            if a != b {
                count_edge(&mut edges, a, b, surface.object);
            }
        }
    }
    let mut report = |severity, what: &str, why: &str, objects: Vec<u32>| {
        let (count, mut objects) = (objects.len(), objects);
        if count == 0 {
            return;
        }
        objects.sort_unstable();
        objects.dedup();
        let place = names::list(objects.iter().map(|&o| scene.objects[o as usize].as_str()));
        findings.push(Finding { severity, message: format!("{what} ({count}, in {place}): {why}"), count });
    };
    let objects = |edges: &Edges, chosen: &dyn Fn(&Edge) -> bool| -> Vec<u32> {
        edges.values().filter(|e| chosen(e)).map(|e| e.object).collect()
    };
    let is_open = |e: &Edge| e.forward + e.backward == 1;
    let open: Edges = edges.iter().filter(|(_, e)| is_open(e)).map(|(&k, &e)| (k, e)).collect();
    report(
        Severity::Note,
        "edges without a neighbour",
        "the model is open there, or its parts touch without sharing edges",
        objects(&split_at_corners(&open, &scene.positions, tolerance), &is_open),
    );
    report(
        Severity::Warning,
        "edges that both faces run through in the same direction",
        "one of the two is turned the wrong way, which matters where it emits or has one side",
        objects(&edges, &|e| e.forward + e.backward == 2 && e.forward != e.backward),
    );
    report(
        Severity::Note,
        "edges that more than two faces share",
        "walls that meet there may be given twice",
        objects(&edges, &|e| e.forward + e.backward > 2),
    );
}

/// Open edges cut where corners of others lie on them, so that a long edge finds its short
/// neighbours. Models of very many open edges are returned as they are.
fn split_at_corners(open: &Edges, positions: &[DVec3], tolerance: f64) -> Edges {
    const MOST_EDGES: usize = 10_000;
    if open.len() > MOST_EDGES {
        return open.clone();
    }
    let mut corners: Vec<u32> = open.keys().flat_map(|&(a, b)| [a, b]).collect();
    corners.sort_unstable();
    corners.dedup();
    // Sorted along x, only the corners within an edge's extent need a look.
    let x = |&c: &u32| positions[c as usize].x;
    corners.sort_by(|a, b| x(a).total_cmp(&x(b)));
    let mut split = Edges::new();
    for (&(low, high), edge) in open {
        let (from, to) = if edge.forward > 0 { (low, high) } else { (high, low) };
        let (start, end) = (positions[from as usize], positions[to as usize]);
        let along = end - start;
        let length = along.length();
        let first = corners.partition_point(|c| x(c) < start.x.min(end.x) - tolerance);
        let mut stops: Vec<(f64, u32)> = corners[first..]
            .iter()
            .take_while(|c| x(c) <= start.x.max(end.x) + tolerance)
            .filter_map(|&c| {
                let offset = positions[c as usize] - start;
                let distance = offset.dot(along) / length;
                let aside = (offset - along * (distance / length)).length();
                (aside <= tolerance && distance > tolerance && distance < length - tolerance)
                    .then_some((distance, c))
            })
            .collect();
        stops.push((length, to));
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut last = from;
        for (_, stop) in stops {
            if stop != last {
                count_edge(&mut split, last, stop, edge.object);
            }
            last = stop;
        }
    }
    split
}

/// Faces that lie in one plane, look the same way and cover the same place: which one is seen is chance.
fn check_overlaps(scene: &Scene, diagonal: f64, findings: &mut Vec<Finding>) {
    let mut planes: HashMap<([i64; 3], i64), Vec<usize>> = HashMap::new();
    let tolerance = 1e-5 * diagonal;
    let centre = scene.bounds().centre();
    for (index, surface) in scene.surfaces.iter().enumerate() {
        let outline = scene.polygon(surface);
        let normal = polygon::area_vector(&outline).normalize_or_zero();
        let offset = (outline[0] - centre).dot(normal) / tolerance;
        let key = ((normal * 1e3).round().to_array().map(|c| c as i64), offset.round() as i64);
        planes.entry(key).or_default().push(index);
    }
    let mut groups: Vec<Vec<usize>> = planes.into_values().filter(|group| group.len() > 1).collect();
    groups.sort();
    let mut overlapping = Vec::new();
    let mut pairs = 0;
    for group in &groups {
        let outline = scene.polygon(&scene.surfaces[group[0]]);
        let frame = Frame::around(polygon::area_vector(&outline).normalize_or(DVec3::Z));
        let mut shapes: Vec<Flat> = group.iter().map(|&index| Flat::new(scene, index, &frame)).collect();
        shapes.sort_by(|a, b| a.min.x.total_cmp(&b.min.x).then(a.surface.cmp(&b.surface)));
        for (i, a) in shapes.iter().enumerate() {
            for b in shapes[i + 1..].iter().take_while(|b| b.min.x < a.max.x - tolerance) {
                pairs += 1;
                if pairs > MOST_PAIRS {
                    break;
                }
                let apart = b.min.y >= a.max.y - tolerance || a.min.y >= b.max.y - tolerance;
                if !apart && (a.holds_a_sample_of(b) || b.holds_a_sample_of(a)) {
                    overlapping.push(a.surface.max(b.surface));
                }
            }
        }
    }
    overlapping.sort_unstable();
    overlapping.dedup();
    let count = overlapping.len();
    if count > 0 {
        let place = overlapping.iter().map(|&i| scene.objects[scene.surfaces[i].object as usize].as_str());
        let message = format!(
            "faces that lie on others in the same plane ({count}, in {}): it is chance which of them is lit and seen; \
             cut a hole or move one by a millimetre",
            names::list(place)
        );
        findings.push(Finding { severity: Severity::Warning, message, count });
    }
    if pairs > MOST_PAIRS {
        let message = "the model has too many coplanar faces to look for all overlaps".to_owned();
        findings.push(Finding { severity: Severity::Note, message, count: 1 });
    }
}

/// A surface laid into the plane.
struct Flat {
    surface: usize,
    outline: Vec<DVec2>,
    /// Centroids of its triangles.
    samples: Vec<DVec2>,
    min: DVec2,
    max: DVec2,
}

impl Flat {
    fn new(scene: &Scene, surface: usize, frame: &Frame) -> Self {
        let outline: Vec<DVec2> = scene
            .polygon(&scene.surfaces[surface])
            .iter()
            .map(|p| DVec2::new(p.dot(frame.tangent), p.dot(frame.bitangent)))
            .collect();
        let samples = polygon::triangulate(&outline, &[])
            .iter()
            .map(|t| t.iter().map(|&i| outline[i as usize]).sum::<DVec2>() / 3.0)
            .collect();
        let min = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let max = outline.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { surface, outline, samples, min, max }
    }

    fn holds_a_sample_of(&self, other: &Self) -> bool {
        other.samples.iter().any(|&sample| {
            let n = self.outline.len();
            // Parity of the edges to the right of the sample.
            (0..n).fold(false, |inside, k| {
                let (a, b) = (self.outline[k], self.outline[(k + 1) % n]);
                let crosses = (a.y > sample.y) != (b.y > sample.y)
                    && sample.x < a.x + (sample.y - a.y) / (b.y - a.y) * (b.x - a.x);
                inside != crosses
            })
        })
    }
}

fn check_lamps(scene: &Scene, diagonal: f64, findings: &mut Vec<Finding>) {
    let mut warn = |message: String, count| {
        findings.push(Finding { severity: Severity::Warning, message, count });
    };
    if scene.luminaires.is_empty() {
        let message = format!(
            "this scene has no lamp: give a material an emission Ke, or name an object of {}.toml as a \
             [[luminaire]] with its lumens",
            scene.name
        );
        warn(message, 1);
        return;
    }
    if scene.luminaires.iter().all(|l| l.initial.output().iter().all(|e| *e <= 0.0)) {
        warn("all lamps are off, so the scene starts dark".to_owned(), scene.luminaires.len());
    }
    let (list, owners) = triangles(&scene.positions, &scene.surfaces);
    let bvh = Bvh::build(&list);
    let mut covered = Vec::new();
    for ([a, b, c], &owner) in list.iter().zip(&owners) {
        let surface = &scene.surfaces[owner as usize];
        let Some(number) = surface.luminaire.filter(|_| !surface.emits_back) else { continue };
        let Some(direction) = (*b - *a).cross(*c - *a).try_normalize() else { continue };
        let ray = Ray { origin: (*a + *b + *c) / 3.0, direction };
        if bvh.occluded(&ray, 1e-9 * diagonal, 1e-4 * diagonal) {
            covered.push(number);
        }
    }
    let count = covered.len();
    if count > 0 {
        let lamps = names::list(covered.iter().map(|&n| scene.luminaires[n as usize].name.as_str()));
        let message = format!(
            "the light of {lamps} meets a surface right in front of it; turn its faces or set emits = \"back\""
        );
        warn(message, count);
    }
}

fn check_height(scene: &Scene, findings: &mut Vec<Finding>) {
    let height = scene.bounds().size().dot(scene.up.vector());
    if BELIEVABLE_HEIGHT.contains(&height) || height <= 0.0 {
        return;
    }
    use LengthUnit::{Centimetre, Foot, Inch, Metre, Millimetre};
    let in_units = height / scene.unit.metres();
    let better = [Millimetre, Centimetre, Metre, Foot, Inch]
        .into_iter()
        .find(|unit| (2.0..=15.0).contains(&(in_units * unit.metres())));
    if let Some(unit) = better {
        let message = format!(
            "the model is {height:.3} m high; if that is wrong, try unit = \"{}\" in {}.toml, which makes it {:.2} m",
            unit.symbol(),
            scene.name,
            in_units * unit.metres()
        );
        findings.push(Finding { severity: Severity::Warning, message, count: 1 });
    }
}

#[cfg(test)]
mod tests {
    use super::super::from_text;
    use super::*;

    const CORNERS: &str = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 5\nv 4 0 5\nv 4 3 5\nv 0 3 5\n";
    const INWARD: [&str; 6] = ["1 2 3 4", "5 8 7 6", "1 5 6 2", "4 3 7 8", "1 4 8 5", "2 6 7 3"];

    fn messages(faces: &[&str], more: &str, sidecar: &str) -> Vec<String> {
        let faces: String = faces.iter().map(|f| format!("f {f}\n")).collect();
        let mtl = "newmtl white\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n";
        let obj = format!("mtllib m.mtl\n{CORNERS}o room\nusemtl white\n{faces}{more}");
        let scene = from_text("t", &obj, mtl, Some(sidecar)).unwrap();
        check(&scene).into_iter().map(|f| f.message).collect()
    }

    const LAMP: &str = "v 1 2.9 1\nv 2 2.9 1\nv 2 2.9 2\nv 1 2.9 2\no lamp\nusemtl lamp\nf 9 10 11 12\n";

    fn has(messages: &[String], words: &str) -> bool {
        messages.iter().any(|m| m.contains(words))
    }

    #[test]
    fn a_closed_room_has_no_open_edge_and_an_open_one_has_four() {
        let closed = messages(&INWARD, "", "");
        assert!(!has(&closed, "without a neighbour") && !has(&closed, "same direction"), "{closed:?}");
        let open = messages(&INWARD[1..], "", "");
        assert!(has(&open, "without a neighbour (4, in 'room')"), "{open:?}");
        let mut turned = INWARD;
        turned[0] = "4 3 2 1";
        assert!(has(&messages(&turned, "", ""), "same direction (4, in 'room')"));
    }

    #[test]
    fn corners_that_almost_meet_are_welded() {
        // The last face has corners of its own, a tenth of a micrometre off.
        let more = "v 4.0000001 0 0\nv 4 0 5\nv 4 3 5.0000001\nv 4 3 0\nf 9 10 11 12\n";
        assert!(!has(&messages(&INWARD[..5], more, ""), "without a neighbour"));
        let more = more.replace("4.0000001", "4.001");
        assert!(has(&messages(&INWARD[..5], &more, ""), "without a neighbour"));
    }

    #[test]
    fn a_wall_of_two_parts_beside_one_of_three_is_closed() {
        let room = ["5 8 7 6", "1 5 6 2", "1 4 8 5", "2 6 7 3"];
        let upper = "v 0 2 0\nv 4 2 0\nv 2 3 0\nf 1 2 10 9\nf 9 10 3 11 4\nf 4 3 7 8\n";
        let closed = messages(&room, upper, "");
        assert!(!has(&closed, "without a neighbour"), "{closed:?}");
        assert!(has(&messages(&room, &upper.replace("f 4 3 7 8", ""), ""), "without a neighbour (5"));
    }

    #[test]
    fn a_face_on_a_face_is_found_and_neighbours_are_not() {
        let on_floor = "v 1 0 1\nv 2 0 1\nv 2 0 2\nv 1 0 2\no rug\nf 9 12 11 10\n";
        assert!(has(&messages(&INWARD, on_floor, ""), "same plane (1, in 'rug')"));
        // From below it is the bottom of a box that stands there.
        let bottom = on_floor.replace("9 12 11 10", "9 10 11 12");
        assert!(!has(&messages(&INWARD, &bottom, ""), "same plane"));
        let halves = ["1 2 3", "1 3 4", "5 8 7 6", "1 5 6 2", "4 3 7 8", "1 4 8 5", "2 6 7 3"];
        assert!(!has(&messages(&halves, "", ""), "same plane"));
    }

    #[test]
    fn missing_dark_and_covered_lamps_are_told() {
        assert!(has(&messages(&INWARD, "", ""), "no lamp"));
        let lit = messages(&INWARD, LAMP, "");
        assert!(!has(&lit, "no lamp") && !has(&lit, "lamps are") && !has(&lit, "light"), "{lit:?}");
        let off = "[[luminaire]]\nobject = \"lamp\"\non = false\n";
        assert!(has(&messages(&INWARD, LAMP, off), "all lamps are off"));
        let covered = LAMP.replace("2.9", "2.9999").replace("9 10 11 12", "12 11 10 9");
        assert!(has(&messages(&INWARD, &covered, ""), "right in front of it"));
    }

    #[test]
    fn a_room_of_three_kilometres_is_likely_one_in_millimetres() {
        let big = |sidecar: &str| {
            let obj = "v 0 0 0\nv 4000 0 0\nv 4000 3000 0\nf 1 2 3\n";
            check(&from_text("t", obj, "", Some(sidecar)).unwrap())
        };
        assert!(big("").iter().any(|f| f.message.contains("unit = \"mm\"") && f.message.contains("3.00 m")));
        assert!(!big("unit = \"mm\"").iter().any(|f| f.message.contains("high")));
    }
}
