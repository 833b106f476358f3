//! What is doubtful about a model that could be read: the findings of `lumenwalk check`.
//!
//! All tolerances are shares of [`super::Extent::scale`]. Long searches end at a bound and say so.

mod edges;
mod lamps;
pub(super) mod orientation;
mod overlaps;
mod pairs;
mod survey;
pub(super) mod topology;

pub(super) use edges::{MOST_OPEN, WELD, crack};
pub use pairs::Crossing;

use super::finding::Finding;
use super::types::Scene;

/// What [`examine`] found out about a scene.
#[derive(Clone, Debug, Default)]
pub struct Examination {
    /// What the reader cannot repair; the reader's own findings are in [`Scene::findings`].
    pub findings: Vec<Finding>,
    /// All places where two faces cut through each other.
    pub crossings: Vec<Crossing>,
}

/// Looks for what the reader cannot repair: open, cracked or wrongly turned faces, overlapping and
/// interpenetrating ones, missing or dark lamps.
pub fn examine(scene: &Scene) -> Examination {
    let survey = survey::Survey::of(scene);
    let mut findings = Vec::new();
    edges::check(&survey, &mut findings);
    let pairs = pairs::search(&survey);
    overlaps::report(&survey, &pairs, &mut findings);
    lamps::check(&survey, &mut findings);
    Examination { findings, crossings: pairs.crossings }
}

/// The places where faces cut through each other, as [`examine`] finds them.
pub(super) fn crossings(scene: &Scene) -> Vec<Crossing> {
    pairs::search(&survey::Survey::of(scene)).crossings
}

/// The findings of [`examine`].
pub fn check(scene: &Scene) -> Vec<Finding> {
    examine(scene).findings
}

#[cfg(test)]
mod tests {
    use super::super::finding::{FindingKind, Severity};
    use super::super::from_text;
    use super::*;

    const CORNERS: &str = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 5\nv 4 0 5\nv 4 3 5\nv 0 3 5\n";
    const INWARD: [&str; 6] = ["1 2 3 4", "5 8 7 6", "1 5 6 2", "4 3 7 8", "1 4 8 5", "2 6 7 3"];

    fn scene(faces: &[&str], more: &str, sidecar: &str) -> Scene {
        let faces: String = faces.iter().map(|f| format!("f {f}\n")).collect();
        let mtl = "newmtl white\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 1 1 1\n";
        let obj = format!("mtllib m.mtl\n{CORNERS}o room\nusemtl white\n{faces}{more}");
        from_text("t", &obj, mtl, Some(sidecar)).unwrap()
    }

    fn messages(faces: &[&str], more: &str, sidecar: &str) -> Vec<String> {
        check(&scene(faces, more, sidecar)).into_iter().map(|f| f.message).collect()
    }

    fn of_kind(faces: &[&str], more: &str, kind: FindingKind) -> Option<Finding> {
        let found = check(&scene(faces, more, ""));
        assert!(found.iter().filter(|f| f.kind == kind).count() <= 1, "{found:?}");
        found.into_iter().find(|f| f.kind == kind)
    }

    const LAMP: &str = "v 1 2.9 1\nv 2 2.9 1\nv 2 2.9 2\nv 1 2.9 2\no lamp\nusemtl lamp\nf 9 10 11 12\n";

    fn has(messages: &[String], words: &str) -> bool {
        messages.iter().any(|m| m.contains(words))
    }

    #[test]
    fn a_closed_room_has_no_open_edge_and_an_open_one_has_four() {
        let closed = messages(&INWARD, "", "");
        assert!(!has(&closed, "without a neighbour") && !has(&closed, "turned against"), "{closed:?}");
        let open = messages(&INWARD[1..], "", "");
        assert!(has(&open, "without a neighbour (4, in 'room', lines 13, 14, 15, 16)"), "{open:?}");
        let mut turned = INWARD;
        turned[3] = "8 7 3 4";
        let finding = of_kind(&turned, "", FindingKind::Winding).expect("a turned face");
        assert_eq!((finding.count, &finding.places.faces[..]), (1, &[3_u32][..]), "{finding:?}");
        assert!(finding.message.contains("(1, in 'room', line 15)"), "{finding:?}");
        assert_eq!(finding.places.edges.len(), 4);
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
    fn a_small_hole_is_told_apart_from_an_open_side() {
        // A floor of four parts around a hole of 0.5 m.
        let floor = "v 1 0 1\nv 1.5 0 1\nv 1.5 0 1.5\nv 1 0 1.5\n\
            f 1 9 10 2\nf 2 10 11 6\nf 6 11 12 5\nf 5 12 9 1\n";
        let rest = ["1 2 3 4", "5 8 7 6", "4 3 7 8", "1 4 8 5", "2 6 7 3"];
        let turned: String = floor.replace("f 1 9 10 2", "f 2 10 9 1").replace("f 2 10 11 6", "f 6 11 10 2");
        let turned = turned.replace("f 6 11 12 5", "f 5 12 11 6").replace("f 5 12 9 1", "f 1 9 12 5");
        let hole = of_kind(&rest, &turned, FindingKind::OpenEdge).expect("a hole");
        assert!(hole.message.contains("holes in shells") && hole.severity == Severity::Warning, "{hole:?}");
        assert_eq!((hole.count, hole.places.edges.len()), (1, 4));
        assert!(hole.places.edges.iter().flatten().all(|p| p.y == 0.0 && p.x <= 1.5 && p.z <= 1.5));
        assert!(of_kind(&rest, &format!("{turned}f 9 10 11 12\n"), FindingKind::OpenEdge).is_none());
    }

    #[test]
    fn a_crack_is_told_with_its_width_and_a_gap_is_none() {
        // The lid has corners of its own, up to a tenth of a millimetre off (diagonal 7 m).
        let lid = "v 4.0001 0 0\nv 4 0 5\nv 4 3 5.0001\nv 4 3 0\nf 9 10 11 12\n";
        let crack = of_kind(&INWARD[..5], lid, FindingKind::Crack).expect("a crack");
        assert!(crack.message.contains("0.10 mm apart"), "{crack:?}");
        assert!(of_kind(&INWARD[..5], lid, FindingKind::OpenEdge).is_none());
        let gap = lid.replace("4.0001", "4.01");
        let open = of_kind(&INWARD[..5], &gap, FindingKind::OpenEdge).expect("a gap");
        assert!(open.count >= 2, "{open:?}");
    }

    #[test]
    fn t_vertices_are_told_with_their_place() {
        let room = ["5 8 7 6", "1 5 6 2", "1 4 8 5", "4 3 7 8"];
        // The wall at z = 0 in two halves, beside a wall at x = 4 in one.
        let halves = "v 0 1 0\nv 4 1 0\nf 1 2 10 9\nf 9 10 3 4\nf 2 6 7 3\n";
        let found = of_kind(&room, halves, FindingKind::TVertex).expect("two of them");
        assert_eq!(found.count, 2);
        assert_eq!(found.places.points, [glam::DVec3::new(4.0, 1.0, 0.0), glam::DVec3::new(0.0, 1.0, 0.0)]);
        assert!(of_kind(&room, halves, FindingKind::OpenEdge).is_none());
        assert!(of_kind(&INWARD, "", FindingKind::TVertex).is_none());
    }

    #[test]
    fn faces_that_cut_through_each_other_are_told_apart_from_those_that_touch() {
        // A box of 1 m whose lower half is under the floor.
        let cube = |y: f64| {
            let at = |x: f64, up: f64, z: f64| format!("v {x} {} {z}\n", y + up);
            let corners: String =
                [(1, 0, 1), (2, 0, 1), (2, 1, 1), (1, 1, 1), (1, 0, 2), (2, 0, 2), (2, 1, 2), (1, 1, 2)]
                    .map(|(x, up, z)| at(f64::from(x), f64::from(up), f64::from(z)))
                    .concat();
            format!(
                "{corners}o box\nf 12 11 10 9\nf 14 15 16 13\nf 10 14 13 9\nf 12 16 15 11\nf 13 16 12 9\nf 11 15 14 10\n"
            )
        };
        let found = of_kind(&INWARD, &cube(-0.5), FindingKind::Interpenetration).expect("four cuts");
        assert_eq!((found.count, found.places.edges.len()), (4, 4), "{found:?}");
        for [a, b] in &found.places.edges {
            assert!(a.y.abs() < 1e-12 && b.y.abs() < 1e-12 && (a.distance(*b) - 1.0).abs() < 1e-9);
        }
        assert!(
            of_kind(&INWARD, &cube(0.0), FindingKind::Interpenetration).is_none(),
            "it stands on the floor"
        );
        assert!(of_kind(&INWARD, &cube(0.5), FindingKind::Interpenetration).is_none(), "it floats");
    }

    #[test]
    fn a_partly_covered_face_is_found_although_no_middle_lies_in_the_other() {
        let strips = "o a\nv 1 0 1\nv 3 0 1\nv 3 0 1.2\nv 1 0 1.2\nf 9 12 11 10\n\
            o b\nv 2.9 0 0.5\nv 3.1 0 0.5\nv 3.1 0 2\nv 2.9 0 2\nf 13 16 15 14\n";
        let found = of_kind(&INWARD[..1], strips, FindingKind::Overlap).expect("they cover each other");
        assert_eq!(found.places.faces, [2]);
    }
}
