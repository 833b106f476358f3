//! What only the patches tell about a model: parts that no light reaches, and patches that another
//! surface cuts through.

use super::types::{NO_PATCH, PatchMesh};
use crate::geometry::{Aabb, Bvh, polygon};
use crate::scene::{Crossing, Finding, FindingKind, Places, Scene, Severity, name_list};
use glam::DVec2;

/// A part of a patch smaller than this share of it, cut off by another surface, does not count.
const LEAST_PART: f64 = 0.02;
/// Cuts looked at.
const MOST_CUTS: usize = 200_000;

/// Looks at the patches of a scene. `crossings` are the places where its faces cut through each other
/// (see [`crate::scene::examine`]).
pub fn checkup(scene: &Scene, mesh: &PatchMesh, crossings: &[Crossing]) -> Vec<Finding> {
    let mut findings = Vec::new();
    find_leaks(scene, mesh, crossings, &mut findings);
    find_unlit(scene, mesh, &mut findings);
    findings
}

fn find_leaks(scene: &Scene, mesh: &PatchMesh, crossings: &[Crossing], findings: &mut Vec<Finding>) {
    if crossings.is_empty() {
        return;
    }
    let (triangles, pieces) = mesh.triangles();
    let bvh = Bvh::build(&triangles);
    let tolerance = 1e-6 * mesh.size;
    let (mut leaks, mut places) = (Vec::new(), Places::default());
    for crossing in crossings.iter().take(MOST_CUTS) {
        let [a, b] = crossing.segment;
        let mut near = Vec::new();
        bvh.touching(&Aabb::around([a, b]).grown(tolerance), |triangle| near.push(pieces[triangle as usize]));
        near.sort_unstable();
        near.dedup();
        for index in near {
            let piece = &mesh.pieces[index as usize];
            let region = &mesh.regions[piece.region as usize];
            let ends = [a, b].map(|p| region.frame.local(p - region.origin));
            if ends.iter().any(|p| p.z.abs() > 10.0 * tolerance) {
                continue;
            }
            let outline: Vec<DVec2> = mesh.corners_of(piece).iter().map(|c| c.plane).collect();
            if !cuts_in_two(&outline, ends.map(|p| p.truncate())) {
                continue;
            }
            let first = leaks.len();
            leaks.extend(piece.patches.into_iter().filter(|&patch| patch != NO_PATCH));
            if leaks.len() > first {
                if places.edges.last() != Some(&[a, b]) {
                    places.add_edge([a, b]);
                }
                let surface = mesh.patches[leaks[first] as usize].surface;
                if places.faces.len() < crate::scene::MOST_PLACES && !places.faces.contains(&surface) {
                    places.faces.push(surface);
                }
            }
        }
    }
    leaks.sort_unstable();
    leaks.dedup();
    if leaks.is_empty() {
        return;
    }
    let object = |&patch: &u32| {
        let region = mesh.patches[patch as usize].region as usize;
        scene.objects[mesh.regions[region].object as usize].as_str()
    };
    let names = name_list(leaks.iter().map(object));
    let message = format!("patches that another surface cuts through ({}, in {names})", leaks.len());
    findings.push(
        Finding::new(FindingKind::Leak, Severity::Warning, message)
            .counted(leaks.len())
            .with("the light on one side of the cut spreads to the other, up to the border of the patch")
            .at(places),
    );
}

/// Whether a segment cuts a convex outline into two parts that both count.
fn cuts_in_two(outline: &[DVec2], [a, b]: [DVec2; 2]) -> bool {
    let along = b - a;
    let normal = along.perp();
    // The segment must run through the outline, not end before it.
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let sign = polygon::area_2d(outline).signum();
    for k in 0..outline.len() {
        let (p, q) = (outline[k], outline[(k + 1) % outline.len()]);
        let inwards = (q - p).perp() * sign;
        let (start, slope) = (inwards.dot(a - p), inwards.dot(along));
        if slope.abs() <= f64::MIN_POSITIVE {
            if start < 0.0 {
                return false;
            }
        } else if slope > 0.0 {
            from = from.max(-start / slope);
        } else {
            to = to.min(-start / slope);
        }
    }
    let area = polygon::area_2d(outline).abs();
    if (to - from) * along.length() < LEAST_PART * area.sqrt() {
        return false;
    }
    let mut part = Vec::new();
    polygon::clip_2d(outline, normal, -normal.dot(a), &mut part);
    let share = polygon::area_2d(&part).abs() / area;
    (LEAST_PART..=1.0 - LEAST_PART).contains(&share)
}

fn find_unlit(scene: &Scene, mesh: &PatchMesh, findings: &mut Vec<Finding>) {
    let hidden: Vec<_> = mesh.regions.iter().filter(|region| region.dark == [true; 2]).collect();
    if hidden.is_empty() {
        return;
    }
    let area: f64 = hidden.iter().map(|region| region.area).sum();
    let names = name_list(hidden.iter().map(|region| scene.objects[region.object as usize].as_str()));
    let pieces = hidden.iter().flat_map(|r| &mesh.pieces[r.pieces.start as usize..r.pieces.end as usize]);
    let mut faces: Vec<u32> = pieces.map(|piece| piece.surface).collect();
    faces.sort_unstable();
    faces.dedup();
    let message = format!("parts that no light reaches ({}, in {names}, {area:.3} m2)", hidden.len());
    findings.push(
        Finding::new(FindingKind::Unlit, Severity::Note, message)
            .counted(hidden.len())
            .with("they are black, and nothing that is lit sees them")
            .at(Places::of_faces(faces)),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{examine, from_text};

    const MTL: &str = "newmtl white\nKd 0.5 0.5 0.5\nnewmtl lamp\nKe 9 9 9\n";
    const ROOM: &str = "mtllib m\nv 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 5\nv 4 0 5\nv 4 3 5\nv 0 3 5\n\
        o room\nusemtl white\nf 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\n\
        v 1 2.9 1\nv 2 2.9 1\nv 2 2.9 2\nv 1 2.9 2\no lamp\nusemtl lamp\nf 9 10 11 12\nusemtl white\n";

    fn found(more: &str, kind: FindingKind) -> Option<Finding> {
        found_in(PatchTarget::Size(0.5), more, kind)
    }

    fn found_in(target: PatchTarget, more: &str, kind: FindingKind) -> Option<Finding> {
        let scene = from_text("t", &format!("{ROOM}{more}"), MTL, None).unwrap();
        let settings = MeshSettings { target, ..MeshSettings::default() };
        let mesh = build(&scene, &settings).unwrap();
        let findings = checkup(&scene, &mesh, &examine(&scene).crossings);
        findings.into_iter().rfind(|f| f.kind == kind)
    }

    #[test]
    fn a_wall_through_the_floor_cuts_patches_as_given_and_one_on_it_does_not() {
        let wall = "v 0.9 -0.5 2.3\nv 3.1 -0.5 2.3\nv 3.1 1 2.3\nv 0.9 1 2.3\no wall\nf 13 14 15 16\n";
        let leak = found_in(PatchTarget::AsGiven, wall, FindingKind::Leak).expect("the floor is cut");
        assert!(leak.count >= 1, "{leak:?}");
        assert!(leak.places.edges.iter().flatten().all(|p| p.y.abs() < 1e-9 && (p.z - 2.3).abs() < 1e-9));
        assert!(leak.message.contains("in 'room' and 'wall'"), "{leak:?}");
        let standing = wall.replace("-0.5", "0");
        assert!(found_in(PatchTarget::AsGiven, &standing, FindingKind::Leak).is_none());
        // Patches of a mesh of the program's own end at the wall.
        assert!(found(wall, FindingKind::Leak).is_none());
    }

    #[test]
    fn what_lies_in_a_closed_box_is_unlit() {
        let cube = "v 1 1 1\nv 2 1 1\nv 2 2 1\nv 1 2 1\nv 1 1 2\nv 2 1 2\nv 2 2 2\nv 1 2 2\no box\n\
            f 16 15 14 13\nf 18 19 20 17\nf 14 18 17 13\nf 16 20 19 15\nf 17 20 16 13\nf 15 19 18 14\n";
        assert!(found(cube, FindingKind::Unlit).is_none(), "its outside is lit");
        let inner = format!("{cube}v 1.2 1.5 1.2\nv 1.8 1.5 1.2\nv 1.8 1.5 1.8\no secret\nf 21 22 23\n");
        let unlit = found(&inner, FindingKind::Unlit).expect("a secret");
        assert!(unlit.message.contains("'secret'") && unlit.severity == Severity::Note, "{unlit:?}");
        assert_eq!(unlit.places.faces, [13]);
    }
}
