//! What drawing, picking and walking need of a mesh.

use crate::direct::Elements;
use crate::display::DisplayMesh;
use crate::geometry::Aabb;
use crate::mesh::{Patch, PatchMesh};
use crate::navigation::Obstacles;
use crate::render::Picker;
use crate::scene::Scene;
use crate::session::Snapshot;
use std::sync::Arc;

/// A mesh with everything that drawing, picking and walking need of it.
#[derive(Clone)]
pub(super) struct Prepared {
    /// Of the snapshot that it was made from.
    pub(super) mesh_serial: u64,
    pub(super) scene: Arc<Scene>,
    pub(super) mesh: Arc<PatchMesh>,
    pub(super) display: Arc<DisplayMesh>,
    pub(super) picker: Arc<Picker>,
    pub(super) obstacles: Arc<Obstacles>,
    /// Longest extent squared over area, a patch each.
    pub(super) aspect: Arc<[f32]>,
    /// Around the part that is looked at.
    pub(super) bounds: Aabb,
    /// Luminous flux of each lamp at full output as it comes with the file, lm.
    pub(super) full_lumens: Vec<f64>,
}

impl Prepared {
    pub(super) fn build(
        mesh_serial: u64,
        scene: Arc<Scene>,
        mesh: Arc<PatchMesh>,
        smooth: bool,
        elements: Option<&Arc<Elements>>,
        before: Option<&Arc<Self>>,
    ) -> Self {
        let display = Arc::new(DisplayMesh::build_on(&mesh, &scene, smooth, elements));
        // Elements and the sky come and go; the mesh below them is looked at once.
        if let Some(before) = before.filter(|before| before.mesh_serial == mesh_serial) {
            return Self { display, scene, mesh, ..Self::clone(before) };
        }
        let extent = scene.extent();
        Self {
            mesh_serial,
            display,
            picker: Arc::new(Picker::new(&mesh)),
            obstacles: Arc::new(Obstacles::of_mesh(&mesh, scene.up.vector(), &extent)),
            aspect: mesh.patches.iter().map(|p| aspect(&mesh, p)).collect(),
            full_lumens: crate::scene::lumens(&scene).into_iter().map(|[full, _]| full).collect(),
            bounds: extent.main,
            scene,
            mesh,
        }
    }

    /// The same under the sky that a snapshot of its mesh has, which may be another one.
    pub(super) fn under_sky_of(prepared: &Arc<Self>, snapshot: &Snapshot) -> Arc<Self> {
        match (snapshot.scene(), snapshot.mesh()) {
            (Some(scene), Some(mesh)) if !Arc::ptr_eq(scene, &prepared.scene) => {
                Arc::new(Self { scene: Arc::clone(scene), mesh: Arc::clone(mesh), ..Self::clone(prepared) })
            }
            _ => Arc::clone(prepared),
        }
    }
}

/// (Longest extent)² over area: one for a square counted along its sides, about 1 for a disc; one for a cluster, which
/// has no outline.
fn aspect(mesh: &PatchMesh, patch: &Patch) -> f32 {
    if patch.is_cluster {
        return 1.0;
    }
    let frame = mesh.regions[patch.region as usize].frame;
    let corners = mesh
        .pieces_of(patch)
        .flat_map(|piece| mesh.corners_of(piece))
        .map(|c| frame.local(mesh.vertices[c.vertex as usize]));
    let size = Aabb::around(corners).size();
    let longest = size.x.max(size.y);
    if patch.area > 0.0 { (longest * longest / patch.area) as f32 } else { 0.0 }
}
