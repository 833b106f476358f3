//! What surfaces pass on, about: the light that patches reflect once, gathered from nodes as if nothing stood between.
//!
//! It is to tell where that light is strong and where it changes, as in the gap between a lamp and what it stands before;
//! how much arrives where is for the rows to say.

use super::judge::LAMPS;
use super::nodes::Tree;
use crate::mesh::PatchMesh;
use crate::watch::{Cancelled, Watch};
use glam::DVec3;
use std::f64::consts::PI;

/// A node is taken as one where it is farther away than this many times its radius, and where its patches face one way
/// to this share.
const AFAR: f64 = 2.5;
const ALIKE: f64 = 0.9;

/// A node as one sees it from afar.
#[derive(Clone, Copy, Default)]
struct Shape {
    centre: DVec3,
    /// Sum over its patches of area and normal, m².
    facing: DVec3,
    area: f64,
    radius: f64,
}

/// For each patch the irradiance by what others send evenly, per field; `sent` is theirs, W/m².
///
/// # Errors
/// The watch ended it.
pub(super) fn passed_on(
    mesh: &PatchMesh,
    tree: &Tree,
    sent: &[[f64; LAMPS]],
    watch: &mut Watch<'_>,
) -> Result<Vec<[f64; LAMPS]>, Cancelled> {
    let mut shapes = vec![Shape::default(); tree.len()];
    let mut of_nodes = vec![[0.0_f32; LAMPS]; tree.len()];
    for node in (0..tree.len() as u32).rev() {
        let at = node as usize;
        if let Some(patch) = tree.single(node) {
            let (p, area) = (&mesh.patches[patch as usize], tree.weight(patch));
            shapes[at] = Shape { centre: p.centre, facing: area * p.normal, area, radius: p.radius };
            of_nodes[at] = sent[patch as usize].map(|value| value as f32);
        } else if let Some(halves) = tree.halves(node) {
            let [a, b] = halves.map(|half| shapes[half as usize]);
            let area = a.area + b.area;
            let share = if area > 0.0 { a.area / area } else { 0.5 };
            let centre = b.centre + share * (a.centre - b.centre);
            let reach = |half: Shape| half.centre.distance(centre) + half.radius;
            let facing = a.facing + b.facing;
            shapes[at] = Shape { centre, facing, area, radius: reach(a).max(reach(b)) };
            let [a, b] = halves.map(|half| of_nodes[half as usize]);
            of_nodes[at] = std::array::from_fn(|f| b[f] + share as f32 * (a[f] - b[f]));
        }
    }
    watch.map(&mesh.patches, |_, receiver| {
        let mut sum = [0.0_f64; LAMPS];
        let mut seen = 0.0;
        let mut open = vec![0_u32];
        while let Some(node) = open.pop() {
            let shape = &shapes[node as usize];
            let way = shape.centre - receiver.centre;
            let distance = way.length();
            let halves = tree.halves(node);
            let is_one = distance > AFAR * shape.radius && shape.facing.length() >= ALIKE * shape.area
                || halves.is_none();
            if !is_one {
                // What lies behind its plane as a whole sends nothing.
                if receiver.normal.dot(way) > -shape.radius || receiver.is_cluster {
                    open.extend(halves.into_iter().flatten());
                }
                continue;
            }
            let square = way.length_squared();
            // Facets of a cluster face this way and that.
            let towards = if receiver.is_cluster { 0.5 * distance } else { receiver.normal.dot(way) };
            let cosines = towards * -shape.facing.dot(way);
            if towards > 0.0 && cosines > 0.0 {
                // A disc of this area, seen along its axis.
                let factor = cosines / (square * (PI * square + shape.area)).max(f64::MIN_POSITIVE);
                seen += factor;
                let values = &of_nodes[node as usize];
                sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * f64::from(*value));
            }
        }
        // Where things hide each other, more than a hemisphere is counted.
        sum.map(|sum| sum / seen.max(1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::super::nodes::tests::mesh;
    use super::*;

    #[test]
    fn what_all_send_alike_arrives_in_a_closed_room() {
        let mesh = mesh("hemicube", 900);
        let tree = Tree::new(&mesh, &|| false).expect("whole");
        let sent = vec![[1.0; LAMPS]; mesh.patches.len()];
        let arriving = Watch::nobody(|watch| passed_on(&mesh, &tree, &sent, watch)).expect("whole");
        let (mut area, mut sum) = (0.0, 0.0);
        for (patch, light) in mesh.patches.iter().zip(&arriving).filter(|(patch, _)| !patch.buried) {
            assert!(light.iter().all(|value| (0.0..=1.0 + 1e-9).contains(value)), "{light:?}");
            area += patch.area;
            sum += patch.area * light[0];
        }
        assert!(sum > 0.8 * area, "{} in the mean", sum / area);
    }
}
