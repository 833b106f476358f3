use super::*;
use crate::visibility::{Culling, Occluder};

/// Quadrilaterals of one patch each, on their fronts, in a scene of 1 m.
fn occluders(quads: &[[DVec3; 4]]) -> Occluders {
    let mut all = Occluders { size: 1.0, patches: quads.len(), ..Occluders::default() };
    for (patch, quad) in (0_u32..).zip(quads) {
        let frame = Frame::along((quad[1] - quad[0]).cross(quad[3] - quad[0]).normalize(), quad[1] - quad[0]);
        let bounds = crate::geometry::Aabb::around(*quad);
        let first = all.vertices.len() as u32;
        all.vertices.extend(quad);
        all.edges.extend((0..4).map(|k| [k, (k + 1) % 4]));
        all.cells.push(Cell::Whole([patch, NO_PATCH]));
        all.regions.push(Occluder {
            origin: quad[0],
            u_axis: frame.tangent,
            v_axis: frame.bitangent,
            normal: frame.normal,
            cells: [1, 1],
            first_cell: patch,
            vertices: [first, first + 4],
            edges: [first, first + 4],
            middle: bounds.centre(),
            half: 0.5 * bounds.size(),
            emits: [false; 2],
            dark: [false; 2],
            backing: crate::mesh::Backing::None,
            pane: None,
        });
    }
    let boxes: Vec<(DVec3, DVec3)> = all.regions.iter().map(|r| (r.middle, r.half)).collect();
    all.culling = Culling::new(&boxes, &[]);
    all
}

/// The row of a point at the origin that looks along +z.
fn row(quads: &[[DVec3; 4]]) -> Vec<(u32, f64)> {
    let mut sampler = LineSampler::default();
    let mut row = RowBuffer::new(quads.len());
    let frame = Frame::along(DVec3::Z, DVec3::X);
    let from = Viewpoint { point: DVec3::ZERO, frame, turn: 0.3, viewer: Viewer::LitSurface };
    let scene = occluders(quads);
    sampler.gather((&scene, &Glass::default()), &Fan::new(64), &from, &mut row, |_, _| 0.0);
    let known = sampler.seen.len() as u32;
    assert!(sampler.lines.iter().flatten().all(|interval| interval.seen < known), "a dangling interval");
    let mut found = Vec::new();
    row.drain(|patch, value| found.push((patch, value)));
    assert!(found.iter().all(|f| f.1.is_finite()), "{found:?}");
    found
}

/// Upright, facing the origin from x = 0.5 m, up to this height.
fn wall(height: f64) -> [DVec3; 4] {
    [[-0.3, -1.0], [-0.3, height], [0.3, height], [0.3, -1.0]].map(|[y, z]| DVec3::new(0.5, y, z))
}

#[test]
fn what_rounds_to_nothing_leaves_no_interval_behind() {
    // It rises by so little above the horizon that sin² along each half-plane rounds to nothing, although
    // the half-planes meet it over more than the shortest interval.
    let sliver = wall(1.2e-9);
    let lid = [[-0.2, -0.2], [-0.2, 0.2], [0.2, 0.2], [0.2, -0.2]].map(|[x, y]| DVec3::new(x, y, 0.4));
    assert!(row(&[sliver]).is_empty());
    let alone = row(&[lid]);
    assert!(alone.len() == 1 && alone[0].1 > 0.1, "{alone:?}");
    assert_eq!(row(&[lid, sliver]), alone);
    assert_eq!(row(&[sliver, lid]), [(1, alone[0].1)]);
    assert_eq!(row(&[sliver, sliver, lid, sliver]), [(2, alone[0].1)]);
    // One that does count.
    assert_eq!(row(&[wall(0.01)]).len(), 1);
}

#[test]
fn a_corner_that_is_no_number_spoils_no_other_entry() {
    let lid = [[-0.2, -0.2], [-0.2, 0.2], [0.2, 0.2], [0.2, -0.2]].map(|[x, y]| DVec3::new(x, y, 0.4));
    for corner in 0..4 {
        let mut broken = wall(0.3);
        broken[corner] = DVec3::NAN;
        for (patch, value) in row(&[lid, broken]) {
            assert!((0.0..=1.0).contains(&value), "{patch}: {value}");
        }
    }
}
