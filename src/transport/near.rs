//! Close pairs: what one receiving point gets wrong, mended by the exact value.
//!
//! One centre point stands for a whole patch, which no resolution cures: between adjacent
//! perpendicular squares it costs 5 %. The sampled value over the closed form from the same point
//! is the visible fraction; times the closed form between the polygons it is the form factor.

use crate::form_factors::closed_form::exchange_area;
use crate::form_factors::{Row, RowComputer};
use crate::geometry::Frame;
use crate::mesh::{Patch, PatchMesh};

/// Pairs whose centres are nearer than this many times the sum of their radii are close.
const CLOSE: f64 = 2.0;
/// A pair seen to this fraction or more is taken as fully visible: sampling noise, not a shadow.
const CLEAR: f64 = 0.9;

/// Whether the centre points would misjudge the pair. Facets of clusters are gathered at several points, and have no closed form
/// that would not cost more than those.
pub(super) fn is_close(a: &Patch, b: &Patch) -> bool {
    let reach = CLOSE * (a.radius + b.radius);
    !a.is_cluster
        && !b.is_cluster
        && a.region != b.region
        && a.centre.distance_squared(b.centre) < reach * reach
}

/// A lamp of less than this fraction of a receiver's radius judges the pair better than the receiver.
const SMALL_LAMP: f64 = 0.25;

/// Shares of the two samples of a pair in what is made of them.
///
/// Between a lamp and a receiver the sample of one side is taken: the receiver's, who sees the shape
/// of the lamp; the lamp's where it is small against the receiver, or could fall between samples. Of two
/// others the smaller counts for more, by their areas: what its point sees all of it sees, and it finds
/// the larger one with more of its samples. Under a table lamp whose shade was one patch of 13 cm the means
/// of both had left a lamp's neck with an eighth of its light.
pub(super) fn trust(computer: &RowComputer, a: &Patch, b: &Patch) -> [f64; 2] {
    let small = if computer.misses_nothing() { SMALL_LAMP } else { 1.0 };
    match (a.luminaire.is_some(), b.luminaire.is_some()) {
        (false, true) if b.radius < small * a.radius => [0.0, 1.0],
        (false, true) => [1.0, 0.0],
        (true, false) if a.radius < small * b.radius => [1.0, 0.0],
        (true, false) => [0.0, 1.0],
        _ => [b.area / (a.area + b.area), a.area / (a.area + b.area)],
    }
}

/// Exchange area A_i F_ij of a close pair, from both sampled rows and closed forms, m².
fn exchange(computer: &RowComputer, rows: &[Row], i: u32, j: u32) -> f64 {
    let mesh = computer.mesh();
    let (a, b) = (&mesh.patches[i as usize], &mesh.patches[j as usize]);
    let [of_a, of_b] = trust(computer, a, b);
    let (out, back) = (a.area * rows[i as usize].get(j), b.area * rows[j as usize].get(i));
    let sampled = of_a * out + of_b * back;
    // The closed form from the very points that the rows were gathered at.
    let from = |patch: &Patch, index: u32, other: u32| -> f64 {
        let row = &rows[index as usize];
        let points = computer.open_points(index, row.points, row.covered);
        patch.area * points.iter().map(|&(x, w)| w * computer.unoccluded(x, patch.normal, other)).sum::<f64>()
    };
    let mut from_points = 0.0;
    for (weight, patch, index, other) in [(of_a, a, i, j), (of_b, b, j, i)] {
        if weight > 0.0 {
            from_points += weight * from(patch, index, other);
        }
    }
    if from_points <= 0.0 {
        return sampled;
    }
    let visible = sampled / from_points;
    let visible = if visible >= CLEAR { 1.0 } else { visible };
    visible * exact(mesh, a, b)
}

fn exact(mesh: &PatchMesh, a: &Patch, b: &Patch) -> f64 {
    mesh.pieces_of(a)
        .map(|p| {
            let first = mesh.polygon(p, a.side);
            mesh.pieces_of(b).map(|q| exchange_area(&first, &mesh.polygon(q, b.side))).sum::<f64>()
        })
        .sum()
}

/// Sum of row i by closed forms, if all that it sees is close and fully visible, and the scene is open
/// beside it; else `None`.
pub(super) fn sum_in_closed_form(computer: &RowComputer, rows: &[Row], i: u32) -> Option<f64> {
    let mesh = computer.mesh();
    let (a, row) = (&mesh.patches[i as usize], &rows[i as usize]);
    // What the centre does not see of a closed scene, other points of the patch do.
    if !computer.rays().opens_sideways(a.centre, &Frame::around(a.normal)) {
        return None;
    }
    let mut sum = 0.0;
    for &j in &row.patches {
        let b = &mesh.patches[j as usize];
        if !is_close(a, b) {
            return None;
        }
        let whole = exact(mesh, a, b);
        if exchange(computer, rows, i, j) < whole {
            return None;
        }
        sum += whole / a.area;
    }
    Some(sum)
}

/// The close pairs of row i with j > i, each with its exchange area.
pub(super) fn of_row(computer: &RowComputer, rows: &[Row], i: u32) -> Vec<(u32, f64)> {
    let mesh = computer.mesh();
    let a = &mesh.patches[i as usize];
    let row = &rows[i as usize];
    row.patches
        .iter()
        .filter(|&&j| j > i && is_close(a, &mesh.patches[j as usize]))
        .map(|&j| (j, exchange(computer, rows, i, j)))
        .collect()
}
