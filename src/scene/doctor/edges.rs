//! Where faces do not meet as they should: open edges, holes, cracks, T-vertices, and neighbours that
//! face opposite ways.

use super::orientation::{Orientation, orient};
use super::survey::Survey;
use super::topology::{HalfEdge, bundles, cut, half_edges, missing, stops, weld};
use crate::scene::finding::{Finding, FindingKind, Places, Severity, line_list};
use crate::scene::names;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Corners nearer than this share of the scene's diagonal are one.
pub(in crate::scene) const WELD: f64 = 1e-6;
/// Open edges nearer than this share of the diagonal were meant to meet, unless they are farther apart than a gap that
/// somebody models, metres: in a house with a garden a cushion may lie 2 mm above its seat.
const CRACK: f64 = 1e-4;
const LEAST_GAP: f64 = 1.5e-3;

/// Open edges of a model of this diagonal, metres, that are nearer to each other than this were meant to meet.
pub(in crate::scene) fn crack(diagonal: f64) -> f64 {
    (CRACK * diagonal).min(LEAST_GAP)
}

/// With more open edges T-vertices and cracks are not looked for.
pub(in crate::scene) const MOST_OPEN: usize = 300_000;
/// A hole whose rim is shorter than this, in square roots of the area of its shell, was not meant.
const SMALL_HOLE: f64 = 0.5;

/// How the edges of a model meet.
#[derive(Default)]
struct Seams {
    /// For each face whether it faces both ways.
    both_ways: Vec<bool>,
    /// With a face on one side only.
    open: Vec<HalfEdge>,
    /// Between more than two faces, one of each bundle.
    shared: Vec<HalfEdge>,
    /// Between two faces that run along it in the same direction, one of each bundle.
    opposed: Vec<HalfEdge>,
    /// All edges between two faces, T-vertices being corners of both.
    joined: Vec<HalfEdge>,
    /// Corners in the middle of an edge that goes on beyond it, with the face that lacks the corner.
    t_vertices: Vec<(u32, u32)>,
    /// Edges that nearly meet others.
    cracks: Vec<HalfEdge>,
    /// The widest of these gaps, metres.
    widest: f64,
    /// There are too many open edges to look for their neighbours.
    given_up: bool,
}

impl Seams {
    fn sort_in(&mut self, edges: &[HalfEdge]) -> Vec<HalfEdge> {
        let mut open = Vec::new();
        for bundle in bundles(edges) {
            match bundle {
                [one] => open.push(*one),
                [a, b] if [a, b].iter().any(|e| self.both_ways[e.face as usize]) => {}
                [a, b] => {
                    self.joined.extend(bundle);
                    if a.from == b.from {
                        self.opposed.push(*a);
                    }
                }
                [first, ..] => self.shared.push(*first),
                [] => {}
            }
        }
        open
    }
}

/// Looks at all edges.
pub(super) fn check(survey: &Survey<'_>, findings: &mut Vec<Finding>) {
    let positions = &survey.scene.positions;
    let welded = weld(positions, WELD * survey.diagonal);
    // Two faces that are written for the two sides of one wall count as one, which faces both ways.
    let is_second = |face: usize| survey.partners[face].is_some_and(|p| (p as usize) < face);
    let surfaces = survey.scene.surfaces.iter().enumerate();
    let faces: Vec<Vec<u32>> = surfaces
        .map(|(face, s)| match is_second(face) {
            true => Vec::new(),
            false => s.corners.iter().map(|c| welded[c.position as usize]).collect(),
        })
        .collect();
    let mut seams =
        Seams { both_ways: survey.partners.iter().map(Option::is_some).collect(), ..Seams::default() };
    let open = seams.sort_in(&half_edges(&faces));
    if open.len() > MOST_OPEN {
        seams.given_up = true;
        seams.open = open;
    } else {
        let open = find_t_vertices(&mut seams, &open, positions, WELD * survey.diagonal);
        seams.open = find_cracks(&mut seams, open, positions, crack(survey.diagonal));
    }
    super::topology::sort(&mut seams.joined);
    let weights: Vec<f64> = survey
        .scene
        .surfaces
        .iter()
        .zip(&survey.planes)
        .map(|(s, plane)| if s.luminaire.is_some() { f64::INFINITY } else { plane.area })
        .collect();
    let orientation = orient(&seams.joined, &weights);
    report_winding(survey, &seams, &orientation, findings);
    report_t_vertices(survey, &seams, findings);
    report_cracks(survey, &seams, findings);
    report_open(survey, &seams, &orientation.shell, findings);
    report_shared(survey, &seams, findings);
}

/// Cuts open edges at the corners of others on them; returns those that are open even so.
fn find_t_vertices(
    seams: &mut Seams,
    open: &[HalfEdge],
    positions: &[DVec3],
    tolerance: f64,
) -> Vec<HalfEdge> {
    let stops = stops(open, positions, tolerance);
    let pieces = cut(open, &stops);
    let lacking = missing(open, &stops, &pieces);
    seams.t_vertices = lacking.map(|s| (s.corner, open[s.edge as usize].face)).collect();
    seams.t_vertices.sort_unstable();
    seams.t_vertices.dedup();
    seams.sort_in(&pieces)
}

/// Joins open edges that nearly meet; returns those that are open even so.
fn find_cracks(seams: &mut Seams, open: Vec<HalfEdge>, positions: &[DVec3], tolerance: f64) -> Vec<HalfEdge> {
    let mut corners: Vec<u32> = open.iter().flat_map(|e| [e.from, e.to]).collect();
    corners.sort_unstable();
    corners.dedup();
    let places: Vec<DVec3> = corners.iter().map(|&c| positions[c as usize]).collect();
    let first = weld(&places, tolerance);
    let joined: HashMap<u32, u32> =
        corners.iter().zip(&first).map(|(&c, &f)| (c, corners[f as usize])).collect();
    // What is shorter than the gap vanishes.
    let mut moved = Vec::new();
    for edge in &open {
        let (from, to) = (joined[&edge.from], joined[&edge.to]);
        if from != to {
            moved.push(HalfEdge { from, to, ..*edge });
        }
    }
    let stops = stops(&moved, positions, tolerance);
    let pieces = cut(&moved, &stops);
    let gap = |c: u32| positions[c as usize].distance(positions[joined[&c] as usize]);
    let mut closed: HashSet<(u32, u32)> = HashSet::new();
    let mut left = Vec::new();
    for bundle in bundles(&pieces) {
        match bundle {
            [one] => left.push(*one),
            all => closed.extend(all.iter().map(|p| (p.face, p.side))),
        }
    }
    for edge in open.iter().filter(|e| closed.contains(&(e.face, e.side))) {
        seams.cracks.push(*edge);
        seams.widest = seams.widest.max(gap(edge.from)).max(gap(edge.to));
    }
    for stop in &stops {
        let edge = &moved[stop.edge as usize];
        if closed.contains(&(edge.face, edge.side)) {
            seams.widest = seams.widest.max(stop.aside);
        }
    }
    left
}

/// Names of the objects of faces, and lines of the file.
fn naming(survey: &Survey<'_>, faces: &[u32]) -> String {
    let mut sorted = faces.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let lines: Vec<u32> = sorted.iter().filter_map(|&f| survey.scene.surfaces[f as usize].line).collect();
    let objects = names::list(sorted.iter().map(|&f| survey.object_of(f)));
    format!("{objects}{}", line_list(&lines, sorted.len()))
}

fn report_winding(survey: &Survey<'_>, seams: &Seams, found: &Orientation, findings: &mut Vec<Finding>) {
    let turned: Vec<u32> = (0..found.turn.len() as u32).filter(|&f| found.turn[f as usize]).collect();
    let positions = &survey.scene.positions;
    let (torn, plain): (Vec<&HalfEdge>, Vec<&HalfEdge>) =
        seams.opposed.iter().partition(|e| found.twisted[e.face as usize]);
    let consequence = "it matters where they emit, have one side, or are shaded smoothly";
    if !turned.is_empty() {
        let mut places = Places::of_faces(turned.iter().copied());
        plain.iter().for_each(|e| places.add_edge(e.ends(positions)));
        let message = format!(
            "faces that are turned against their neighbours ({}, in {})",
            turned.len(),
            naming(survey, &turned)
        );
        findings.push(
            Finding::new(FindingKind::Winding, Severity::Warning, message)
                .counted(turned.len())
                .with(consequence)
                .at(places),
        );
    } else if !plain.is_empty() {
        findings.push(opposed(
            survey,
            &plain,
            Severity::Warning,
            "where lamps face against their neighbours",
        ));
    }
    if !torn.is_empty() {
        findings.push(opposed(survey, &torn, Severity::Note, "in parts that cannot face one way as a whole"));
    }
}

/// Edges that cannot be mended by turning faces.
fn opposed(survey: &Survey<'_>, edges: &[&HalfEdge], severity: Severity, why: &str) -> Finding {
    let faces: Vec<u32> = edges.iter().map(|e| e.face).collect();
    let mut places = Places::default();
    edges.iter().for_each(|e| places.add_edge(e.ends(&survey.scene.positions)));
    let (count, naming) = (edges.len(), naming(survey, &faces));
    let message = format!("edges that both faces run through in one direction, {why} ({count}, in {naming})");
    Finding::new(FindingKind::Winding, severity, message)
        .counted(count)
        .with("each face is lit and emits as it stands")
        .at(places)
}

fn report_t_vertices(survey: &Survey<'_>, seams: &Seams, findings: &mut Vec<Finding>) {
    let count = seams.t_vertices.len();
    if count == 0 {
        return;
    }
    let faces: Vec<u32> = seams.t_vertices.iter().map(|t| t.1).collect();
    let mut places = Places::of_faces(faces.iter().copied());
    seams.t_vertices.iter().for_each(|t| places.add_point(survey.scene.positions[t.0 as usize]));
    let message = format!(
        "T-vertices: corners in the middle of a neighbour's edge ({count}, in {})",
        naming(survey, &faces)
    );
    findings.push(
        Finding::new(FindingKind::TVertex, Severity::Note, message)
            .counted(count)
            .with("nothing gets through; smooth shading may show a seam")
            .at(places),
    );
}

fn report_cracks(survey: &Survey<'_>, seams: &Seams, findings: &mut Vec<Finding>) {
    let count = seams.cracks.len();
    if count == 0 {
        return;
    }
    let faces: Vec<u32> = seams.cracks.iter().map(|e| e.face).collect();
    let mut places = Places::of_faces(faces.iter().copied());
    seams.cracks.iter().for_each(|e| places.add_edge(e.ends(&survey.scene.positions)));
    let millimetres = 1e3 * seams.widest;
    let message = format!(
        "cracks: edges that nearly meet ({count}, in {}), {millimetres:.2} mm apart at most",
        naming(survey, &faces)
    );
    findings.push(
        Finding::new(FindingKind::Crack, Severity::Warning, message)
            .counted(count)
            .with("light gets through as it would through a gap of that width")
            .at(places),
    );
}

fn report_open(survey: &Survey<'_>, seams: &Seams, shells: &[u32], findings: &mut Vec<Finding>) {
    let positions = &survey.scene.positions;
    // An edge that ends on another face is sealed, however that face goes on.
    let tolerance = 2.0 * WELD * survey.diagonal;
    let is_sealed = |edge: &&HalfEdge| {
        let [a, b] = edge.ends(positions);
        [0.15, 0.5, 0.85].iter().all(|&t| survey.lies_on_another(a.lerp(b, t), edge.face, tolerance))
    };
    let (sealed, open): (Vec<&HalfEdge>, Vec<&HalfEdge>) = seams.open.iter().partition(is_sealed);
    if open.is_empty() {
        return;
    }
    let holes = small_holes(survey, &open, shells);
    let (rims, rest): (Vec<&HalfEdge>, Vec<&HalfEdge>) =
        open.iter().partition(|e| holes.contains_key(&(e.face, e.side, e.from)));
    let told = |edges: &[&HalfEdge]| {
        let mut places = Places::default();
        edges.iter().for_each(|e| places.add_edge(e.ends(positions)));
        let faces: Vec<u32> = edges.iter().map(|e| e.face).collect();
        (naming(survey, &faces), places)
    };
    if !rims.is_empty() {
        let count = holes.values().collect::<HashSet<_>>().len();
        let (naming, places) = told(&rims);
        let message = format!("holes in shells that are closed otherwise ({count}, in {naming})");
        findings.push(
            Finding::new(FindingKind::OpenEdge, Severity::Warning, message)
                .counted(count)
                .with("light leaves and enters there; a face may be missing")
                .at(places),
        );
    }
    if !rest.is_empty() {
        let (naming, places) = told(&rest);
        let more = match sealed.len() {
            0 => String::new(),
            n => format!("; {n} more end in the middle of another face, where nothing gets through"),
        };
        let message = format!("edges without a neighbour ({}, in {naming}){more}", rest.len());
        findings.push(
            Finding::new(FindingKind::OpenEdge, Severity::Note, message)
                .counted(rest.len())
                .with("the model is open there, and light may pass")
                .at(places),
        );
    }
    if seams.given_up {
        let message = format!(
            "the model has {} open edges, too many to look for T-vertices and cracks among them",
            seams.open.len()
        );
        findings.push(Finding::new(FindingKind::Unsearched, Severity::Note, message));
    }
}

/// The open edges around small holes, by face, side and first corner, with the number of their hole.
fn small_holes(survey: &Survey<'_>, open: &[&HalfEdge], shells: &[u32]) -> HashMap<(u32, u32, u32), u32> {
    let mut area: HashMap<u32, f64> = HashMap::new();
    for (face, plane) in survey.planes.iter().enumerate() {
        *area.entry(shells[face]).or_default() += plane.area;
    }
    // Rims are what hangs together over corners.
    let mut parent: HashMap<u32, u32> = HashMap::new();
    fn root(parent: &mut HashMap<u32, u32>, mut corner: u32) -> u32 {
        while let Some(&next) = parent.get(&corner)
            && next != corner
        {
            corner = next;
        }
        corner
    }
    for edge in open {
        let (a, b) = (root(&mut parent, edge.from), root(&mut parent, edge.to));
        parent.insert(a.max(b), a.min(b));
    }
    #[derive(Default)]
    struct Rim {
        length: f64,
        shell_area: f64,
        ends: HashMap<u32, u32>,
    }
    let mut rims: HashMap<u32, Rim> = HashMap::new();
    for edge in open {
        let [a, b] = edge.ends(&survey.scene.positions);
        let rim = rims.entry(root(&mut parent, edge.from)).or_default();
        rim.length += a.distance(b);
        rim.shell_area = rim.shell_area.max(area[&shells[edge.face as usize]]);
        *rim.ends.entry(edge.from).or_default() += 1;
        *rim.ends.entry(edge.to).or_default() += 1;
    }
    let is_hole = |rim: &Rim| {
        rim.ends.values().all(|&edges| edges == 2) && rim.length < SMALL_HOLE * rim.shell_area.sqrt()
    };
    open.iter()
        .filter_map(|edge| {
            let number = root(&mut parent, edge.from);
            is_hole(&rims[&number]).then_some(((edge.face, edge.side, edge.from), number))
        })
        .collect()
}

fn report_shared(survey: &Survey<'_>, seams: &Seams, findings: &mut Vec<Finding>) {
    let count = seams.shared.len();
    if count == 0 {
        return;
    }
    let faces: Vec<u32> = seams.shared.iter().map(|e| e.face).collect();
    let mut places = Places::default();
    seams.shared.iter().for_each(|e| places.add_edge(e.ends(&survey.scene.positions)));
    let message = format!("edges that more than two faces share ({count}, in {})", naming(survey, &faces));
    findings.push(
        Finding::new(FindingKind::SharedEdge, Severity::Note, message)
            .counted(count)
            .with("nothing is wrong with that, unless walls that meet there are given twice")
            .at(places),
    );
}
