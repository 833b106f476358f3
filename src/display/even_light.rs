//! A model without light, shown so that its form can be read: an even sky above, its reflection from below,
//! a little from one side, less in corners. A picture alone: nothing of it is a solution.

use crate::geometry::{Bvh, Frame, Ray};
use crate::mesh::{Patch, PatchMesh};
use crate::scene::{LUMINOUS_EFFICACY, UpAxis};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Illuminance of an upright face in the open, lux.
const ILLUMINANCE: f64 = 300.0;
/// What a face turned up or down has more or less, as a share of that.
const FROM_ABOVE: f64 = 0.45;
/// What a face turned to the side light or away from it has more or less: walls of a room are told apart.
const FROM_ASIDE: f64 = 0.25;
/// What is left in the deepest corner.
const IN_CORNERS: f64 = 0.35;
/// Rays from a patch.
const RAYS: u32 = 32;
/// What stands farther away than this does not count as a corner, metres; nor does what is farther than this
/// share of the model's diagonal.
const REACH: f64 = 1.5;
const REACH_SHARE: f64 = 0.12;
/// Patches of one task: short, so that a frame does not wait long behind one.
const BLOCK: usize = 64;

/// Irradiance of every patch in plain even light, W/m² per band, alike in all three: by the way that it faces
/// and, where it is known, by its [`openness`].
pub fn even_light(mesh: &PatchMesh, up: UpAxis, openness: Option<&[f32]>) -> Vec<[f32; 3]> {
    let aside = match up {
        UpAxis::Y => DVec3::new(0.55, 0.0, 0.835),
        UpAxis::Z => DVec3::new(0.55, -0.835, 0.0),
    };
    let upright = ILLUMINANCE / LUMINOUS_EFFICACY;
    let shade = |(index, patch): (usize, &Patch)| {
        let open = openness.and_then(|all| all.get(index)).map_or(1.0, |&open| f64::from(open));
        let facing = 1.0 + FROM_ABOVE * patch.normal.dot(up.vector()) + FROM_ASIDE * patch.normal.dot(aside);
        [(upright * facing * (IN_CORNERS + (1.0 - IN_CORNERS) * open)) as f32; 3]
    };
    mesh.patches.iter().enumerate().map(shade).collect()
}

/// For every patch how open the space before it is, 0 to 1: the mean distance that cosine-distributed rays go,
/// up to a metre and a half or an eighth of the model. `None` where `cancelled` says so.
pub fn openness(mesh: &PatchMesh, cancelled: &(dyn Fn() -> bool + Sync)) -> Option<Vec<f32>> {
    let (triangles, _) = mesh.triangles();
    if cancelled() {
        return None;
    }
    let bvh = Bvh::build(&triangles);
    let reach = REACH.min(REACH_SHARE * mesh.size);
    let one = |(index, patch): (usize, &Patch)| open_before(mesh, &bvh, reach, index as u32, patch);
    let blocks: Vec<Vec<f32>> = mesh
        .patches
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, patches)| {
            if cancelled() {
                return Vec::new();
            }
            patches.iter().enumerate().map(|(k, patch)| one((BLOCK * block + k, patch))).collect()
        })
        .collect();
    (!cancelled()).then(|| blocks.concat())
}

fn open_before(mesh: &PatchMesh, bvh: &Bvh, reach: f64, index: u32, patch: &Patch) -> f32 {
    let pieces: Vec<_> = mesh.pieces_of(patch).collect();
    // Patches turn their rays unlike their neighbours, so that no pattern shows.
    let turn = TAU * f64::from(index.wrapping_mul(2_654_435_769) >> 8) / f64::from(1 << 24);
    let lift = (1e-5 * mesh.size).min(0.01 * reach);
    let mut sum = 0.0;
    for k in 0..RAYS {
        // Spread over the patch: half-way from the middle of a piece to one of its corners.
        let n = pieces.len();
        let spread = if n > RAYS as usize { k as usize * n / RAYS as usize } else { k as usize % n.max(1) };
        let mut normal = patch.normal;
        let from = match pieces.get(spread) {
            Some(piece) => {
                normal = mesh.normal_of(piece, patch.side);
                let corners = mesh.corners_of(piece);
                let at = |k: usize| mesh.vertices[corners[k % corners.len()].vertex as usize];
                let middle = (0..corners.len()).map(at).sum::<DVec3>() / corners.len() as f64;
                0.5 * (middle + at(k as usize / pieces.len()))
            }
            None => patch.centre,
        };
        // A spiral of equal shares of the cosine (Vogel 1979).
        let share = (f64::from(k) + 0.5) / f64::from(RAYS);
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(k)).sin_cos();
        let local = DVec3::new(share.sqrt() * cos, share.sqrt() * sin, (1.0 - share).sqrt());
        let frame = Frame::around(normal).turned(turn);
        let ray = Ray { origin: from + normal * lift, direction: frame.world(local) };
        let met = bvh.nearest(&ray, 0.0, reach);
        sum += met.map_or(1.0, |hit| hit.distance / reach);
    }
    (sum / f64::from(RAYS)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::from_text;

    /// The inside of a box of 4 m x 3 m x 2.5 m.
    const ROOM: &str = "v 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3\nv 0 2.5 0\nv 4 2.5 0\nv 4 2.5 3\nv 0 2.5 3\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 4 8 7 3\nf 1 5 8 4\n";

    #[test]
    fn faces_of_other_directions_differ_and_corners_are_darker() {
        let scene = from_text("t", ROOM, "", None).unwrap();
        let settings = MeshSettings { target: PatchTarget::Count(2000), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).unwrap();
        let open = openness(&mesh, &|| false).unwrap();
        assert!(open.iter().all(|o| (0.0..=1.0).contains(o)));
        let lit = even_light(&mesh, scene.up, Some(&open));
        let inside = |patch: &Patch| patch.normal.dot(DVec3::new(2.0, 1.25, 1.5) - patch.centre) > 0.0;
        // The patch nearest to the middle of each wall, and the one nearest to a corner of it.
        let of = |normal: DVec3, towards: DVec3| {
            let on = mesh.patches.iter().enumerate();
            let on = on.filter(|(_, p)| p.normal.dot(normal) > 0.99 && inside(p));
            let near =
                on.min_by(|a, b| a.1.centre.distance(towards).total_cmp(&b.1.centre.distance(towards)));
            lit[near.expect("a patch").0][0]
        };
        let walls = [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];
        let middle = DVec3::new(2.0, 1.25, 1.5);
        let middles = walls.map(|normal| of(normal, middle - normal));
        for (k, a) in middles.iter().enumerate() {
            for b in &middles[..k] {
                assert!((a - b).abs() > 0.05 * a.max(*b), "{middles:?}");
            }
            assert!(*a > 0.3, "legible: {middles:?}");
        }
        let corner = of(DVec3::Y, DVec3::ZERO);
        assert!(
            corner < 0.8 * middles[0],
            "{corner} in the corner of the floor, {} in the middle",
            middles[0]
        );
        assert!(openness(&mesh, &|| true).is_none());
    }
}
