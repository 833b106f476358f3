//! Where further patches take away most of the error.

use crate::accuracy::ErrorMap;
use crate::mesh::{Patch, PatchMesh, Refinement};

/// A patch is cut into so many at most: what is known of a single one is uncertain.
const MOST_PARTS: f64 = 16.0;

/// How many times as many patches a mesh of the same patch size has after one more check. Where a mesh of
/// some number of patches is asked for, so much of them goes where they are needed most.
///
/// Measured in the embedded house at 0.32 m: 21,160 patches with 29.1 % of audited error become 31,286 with
/// 15.8 %.
const GROWTH: f64 = 1.4;

/// Asks for patches to be cut where the map says that the picture is wrong; `before` is what was asked for
/// of the mesh itself, and still holds.
///
/// A patch of area A with an error e adds A e² to the squares. Cut into n parts it adds A e² / n, as what
/// light does across a patch goes by the patch' edge. For a given number of patches the sum is least where
/// n goes by the root of A e².
pub fn refined(mesh: &PatchMesh, map: &ErrorMap, before: Option<&Refinement>) -> Refinement {
    let root = |(patch, &error): (&Patch, &f32)| {
        let square = patch.area * f64::from(error).powi(2);
        if square.is_finite() { square.sqrt() } else { 0.0 }
    };
    let roots: Vec<f64> = mesh.patches.iter().zip(&map.error).map(root).collect();
    let largest = roots.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Refinement::of(mesh, &[], before);
    }
    let parts = |factor: f64| roots.iter().map(move |root| (factor * root).clamp(1.0, MOST_PARTS));
    let wanted = GROWTH * roots.len() as f64;
    // The sum grows with the factor; at the one end nothing is cut, at the other all that can be.
    let (mut low, mut high) = ((1.0 / largest).ln(), (1e9 * MOST_PARTS / largest).ln());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if parts(middle.exp()).sum::<f64>() < wanted { low = middle } else { high = middle }
    }
    Refinement::of(mesh, &parts(low.exp()).collect::<Vec<f64>>(), before)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};
    use std::sync::Arc;

    #[test]
    fn patches_go_where_the_error_is_and_the_rest_stays() {
        let scene = load(&SceneSource::Builtin("hemicube".to_owned())).unwrap();
        let settings = MeshSettings { target: PatchTarget::Size(0.3), ..MeshSettings::default() };
        let before = build(&scene, &settings).unwrap();
        let spot = before.patches[before.patches.len() / 2].centre;
        let is_near = |patch: &Patch| patch.centre.distance(spot) < 0.6;
        let error = |patch: &Patch| if is_near(patch) { 0.5 } else { 1e-3 };
        let map = ErrorMap { error: before.patches.iter().map(error).collect() };
        let first = refined(&before, &map, None);
        let with = |refinement: Refinement| {
            build(&scene, &MeshSettings { refinement: Some(Arc::new(refinement)), ..settings.clone() })
                .unwrap()
        };
        let after = with(first.clone());
        let count = |patches: &[Patch], far: f64| {
            let from = |p: &&Patch| (p.centre.distance(spot) < 0.6) == (far < 0.6);
            let outside = |p: &&Patch| far < 0.6 || p.centre.distance(spot) > far;
            patches.iter().filter(from).filter(outside).count()
        };
        assert!(count(&after.patches, 0.0) >= 3 * count(&before.patches, 0.0), "they are cut into several");
        // Both sides of a surface share its cells, and cells next to the spot are cut as well.
        assert_eq!(count(&after.patches, 1.2), count(&before.patches, 1.2));
        let area = |patches: &[Patch]| patches.iter().map(|p| p.area).sum::<f64>();
        assert!((area(&after.patches) / area(&before.patches) - 1.0).abs() < 1e-9);
        // What was asked for holds when more is asked for, and in a mesh of other patches.
        let nothing = ErrorMap { error: vec![0.0; after.patches.len()] };
        assert_eq!(refined(&after, &nothing, Some(&first)), first);
        let settings = MeshSettings { target: PatchTarget::Size(0.15), ..settings.clone() };
        let plain = build(&scene, &settings).unwrap();
        let finer = build(&scene, &MeshSettings { refinement: Some(Arc::new(first)), ..settings }).unwrap();
        assert!(count(&finer.patches, 0.0) >= 3 * count(&plain.patches, 0.0));
    }
}
