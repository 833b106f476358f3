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

/// Row sums within this of one count as closed: what rounding leaves of a row.
const CLOSED: f64 = 2e-5;
/// A row that sums to less than this in a sealed scene is that of a patch under something: the rest is sides that
/// no light reaches.
const UNDER: f64 = 0.5;
/// Within this of one a row may owe the rest to seams: closed forms change it only where rays along its
/// surface leave.
const NEARLY_CLOSED: f64 = 2e-3;
/// What closed forms leave open beyond this is no rounding of theirs.
const GAP: f64 = 5e-4;

/// Whether the centre points would misjudge the pair. Facets of clusters are gathered at several points, and have no closed form
/// that would not cost more than those.
pub(super) fn is_close(a: &Patch, b: &Patch) -> bool {
    let reach = CLOSE * (a.radius + b.radius);
    let is_plain = |patch: &Patch| !patch.is_cluster && patch.opacity >= 1.0;
    is_plain(a) && is_plain(b) && a.region != b.region && a.centre.distance_squared(b.centre) < reach * reach
}

/// Within this many times the sum of their radii the two samples of a pair may differ in more than noise.
const NEAR: f64 = 8.0;

/// Whether both samples of a pair count even where rows are those of receivers: near pairs, as the centre of a large patch
/// says little about small ones beside it, and those with a lamp, of which one side alone is trusted.
pub(super) fn is_paired(computer: &RowComputer, a: &Patch, b: &Patch) -> bool {
    let reach = NEAR * (a.radius + b.radius);
    a.centre.distance_squared(b.centre) < reach * reach || trust(computer, a, b).contains(&0.0)
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

/// What row `index` would have sampled of a patch if nothing stood between, from the very points that it was gathered
/// at: an exchange area, m².
fn from_points(computer: &RowComputer, index: u32, row: &Row, other: u32) -> f64 {
    let patch = &computer.mesh().patches[index as usize];
    let points = computer.open_points(index, row.points, row.covered);
    patch.area * points.iter().map(|&(x, w)| w * computer.unoccluded(x, patch.normal, other)).sum::<f64>()
}

/// The visible fraction of a pair times its closed form, m².
fn mended(mesh: &PatchMesh, a: &Patch, b: &Patch, (sampled, from_points): (f64, f64)) -> f64 {
    if from_points <= 0.0 {
        return sampled;
    }
    let visible = sampled / from_points;
    let is_noise = visible >= CLEAR && mesh.panes.is_empty();
    let visible = if is_noise { 1.0 } else { visible };
    visible * exact(mesh, a, b)
}

/// Exchange area A_i F_ij of a close pair, from both sampled rows and closed forms, m².
fn exchange(computer: &RowComputer, rows: &[Row], i: u32, j: u32) -> f64 {
    let mesh = computer.mesh();
    let (a, b) = (&mesh.patches[i as usize], &mesh.patches[j as usize]);
    let [of_a, of_b] = trust(computer, a, b);
    let (out, back) = (a.area * rows[i as usize].get(j), b.area * rows[j as usize].get(i));
    let sampled = of_a * out + of_b * back;
    let mut unhidden = 0.0;
    for (weight, index, other) in [(of_a, i, j), (of_b, j, i)] {
        if weight > 0.0 {
            unhidden += weight * from_points(computer, index, &rows[index as usize], other);
        }
    }
    mended(mesh, a, b, (sampled, unhidden))
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
/// beside it; else `None`. `exchange` tells what a close pair comes to, m².
fn sum_in_closed_form(
    computer: &RowComputer,
    (i, row): (u32, &Row),
    exchange: &dyn Fn(u32) -> f64,
) -> Option<f64> {
    let mesh = computer.mesh();
    let a = &mesh.patches[i as usize];
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
        // From the other side the same closed form may round differently.
        if exchange(j) < whole * (1.0 - 1e-12) {
            return None;
        }
        sum += whole / a.area;
    }
    Some(sum)
}

/// What row i must sum to: 1 less the sky as sampled, where closed forms did not change its share.
///
/// What a close pair gains over its sample the others lose, sky and patches alike. Without sky the
/// sum stays 1; where close pairs are all that is seen, it becomes that of their closed forms, since
/// from one point the gap between two near plates is not seen at all.
///
/// `exchange` tells what a close pair comes to, m², and `None` of others; `sealed` is of the scene.
pub(super) fn row_target(
    computer: &RowComputer,
    (i, row, sum): (u32, &Row, f64),
    exchange: &dyn Fn(u32) -> Option<f64>,
    sealed: bool,
) -> f64 {
    let mesh = computer.mesh();
    if sealed && sum > UNDER {
        // What lines miss of facets thinner than they stand apart is no opening.
        return 1.0;
    }
    let nearly = sum > 1.0 - NEARLY_CLOSED;
    if sum > 1.0 - CLOSED {
        let exact = sum_in_closed_form(computer, (i, row), &|j| exchange(j).unwrap_or(0.0));
        return exact.filter(|&exact| exact < 1.0 - GAP).unwrap_or(1.0);
    }
    let patch = &mesh.patches[i as usize];
    if nearly && !computer.rays().opens_sideways(patch.centre, &Frame::around(patch.normal)) {
        return sum;
    }
    let area = patch.area;
    let (mut exact, mut sampled) = (0.0, 0.0);
    for &j in &row.patches {
        if let Some(value) = exchange(j) {
            exact += value / area;
            sampled += row.get(j);
        }
    }
    let sky = 1.0 - sum;
    let others = sky + (sum - sampled).max(0.0);
    (sum + (exact - sampled) * sky / others).clamp(0.0, 1.0)
}

/// The close pairs of row i in rising order, each with its exchange area, m², as this row alone tells it.
pub(super) fn of_receiver(computer: &RowComputer, (i, row): (u32, &Row)) -> Vec<(u32, f64)> {
    let mesh = computer.mesh();
    let a = &mesh.patches[i as usize];
    let seen = row.patches.iter().zip(&row.values);
    seen.filter(|&(&j, _)| j != i && is_close(a, &mesh.patches[j as usize]))
        .map(|(&j, &value)| {
            let samples = (a.area * f64::from(value), from_points(computer, i, row, j));
            (j, mended(mesh, a, &mesh.patches[j as usize], samples))
        })
        .collect()
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
