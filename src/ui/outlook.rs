//! Where to stand to see a patch.

use crate::geometry::Ray;
use crate::mesh::PatchMesh;
use crate::render::Picker;
use glam::DVec3;
use std::f64::consts::TAU;

/// Angles from the normal that are tried, degrees. Looking straight down has no heading.
const SLANTS_DEG: [f64; 5] = [14.0, 35.0, 55.0, 68.0, 78.0];
/// Directions around the normal that are tried.
const AZIMUTHS: u32 = 16;
/// Least distance to stand at, of what is wanted.
const LEAST: f64 = 0.2;

/// Where a patch is seen from best: nearly straight ahead with nothing in between where there is room,
/// aslant where there is not, on the side of `from` where there is a choice. In a gap too narrow for any
/// of that one looks from beyond what covers it. `patch` must be one of the mesh.
pub(super) fn outlook(mesh: &PatchMesh, picker: &Picker, patch: u32, from: DVec3) -> DVec3 {
    let (patch, size) = (&mesh.patches[patch as usize], mesh.size);
    let wanted = (6.0 * patch.radius).clamp(0.02 * size, 0.3 * size);
    let start = patch.centre + patch.normal * (1e-6 * size);
    let free = |origin: DVec3, direction: DVec3| {
        picker.nearest(&Ray { origin, direction }, 2.0 * wanted).map_or(2.0 * wanted, |hit| hit.distance)
    };
    let towards = (from - patch.centre).reject_from_normalized(patch.normal);
    let aside = towards.normalize_or(patch.normal.any_orthonormal_vector());
    let across = patch.normal.cross(aside);
    let slanted = |slant: f64, turn: f64| {
        let ((sin, cos), (y, x)) = (slant.to_radians().sin_cos(), (TAU * turn).sin_cos());
        patch.normal * cos + (aside * x + across * y) * sin
    };
    let mut best = (0.0, start);
    for slant in SLANTS_DEG {
        for turn in 0..AZIMUTHS {
            let direction = slanted(slant, f64::from(turn) / f64::from(AZIMUTHS));
            let distance = wanted.min(0.8 * free(start, direction));
            let worth = distance * (0.3 + direction.dot(patch.normal));
            // What is as good as one before it is no reason to turn away.
            if distance > LEAST * wanted && worth > 1.02 * best.0 {
                best = (worth, patch.centre + direction * distance);
            }
        }
    }
    if best.0 > 0.0 {
        return best.1;
    }
    let outwards = slanted(SLANTS_DEG[0], 0.0);
    let cover = free(start, outwards);
    let beyond = start + outwards * (cover + 1e-4 * size);
    patch.centre + outwards * (cover + wanted.min(0.8 * free(beyond, outwards)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Backs, MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};

    /// A room of 4 m x 3 m x 4 m, with a plate of 3.6 m x 3.6 m so far above its floor.
    fn room(gap: f64) -> PatchMesh {
        let folder = tempfile::tempdir().expect("a folder");
        let obj = format!(
            "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nv 0 3 0\nv 4 3 0\nv 4 3 4\nv 0 3 4
v 0.2 {gap} 0.2\nv 3.8 {gap} 0.2\nv 3.8 {gap} 3.8\nv 0.2 {gap} 3.8
o room\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\no plate\nf 12 11 10 9\n"
        );
        let path = folder.path().join("room.obj");
        std::fs::write(&path, obj).expect("written");
        let scene = load(&SceneSource::File(path)).expect("a scene");
        let settings = MeshSettings {
            target: PatchTarget::Size(0.4),
            backs: Backs::All,
            textures: false,
            ..MeshSettings::default()
        };
        build(&scene, &settings).expect("a mesh")
    }

    /// The patch of the floor nearest to its middle, and where one would stand to see it.
    fn seen(gap: f64) -> (DVec3, DVec3) {
        let mesh = room(gap);
        let picker = Picker::new(&mesh);
        let middle = DVec3::new(2.0, 0.0, 2.0);
        let of_floor = |p: &u32| {
            let patch = &mesh.patches[*p as usize];
            patch.centre.y.abs() < 1e-9 && patch.normal.y > 0.5
        };
        let off = |p: &u32| mesh.patches[*p as usize].centre.distance(middle);
        let floor = (0..mesh.patches.len() as u32).filter(of_floor);
        let patch = floor.min_by(|a, b| off(a).total_cmp(&off(b))).expect("a floor");
        (mesh.patches[patch as usize].centre, outlook(&mesh, &picker, patch, DVec3::new(0.5, 1.6, 0.5)))
    }

    #[test]
    fn with_room_one_stands_nearly_above_on_ones_own_side() {
        let (centre, eye) = seen(2.5);
        let way = eye - centre;
        assert!(way.normalize().y > 0.95 && way.length() > 0.8, "{way}");
        assert!(way.x < 0.0 && way.z < 0.0, "{way}");
    }

    #[test]
    fn in_a_low_space_one_looks_aslant_and_stays_in_it() {
        let (centre, eye) = seen(0.6);
        let way = eye - centre;
        assert!(way.y > 0.0 && way.y < 0.6 && way.length() > 0.5, "{way}");
    }

    #[test]
    fn into_a_gap_of_millimetres_one_looks_from_beyond_its_cover() {
        let (centre, eye) = seen(0.003);
        assert!((0.3..2.9).contains(&(eye.y - centre.y)), "{eye}");
    }
}
