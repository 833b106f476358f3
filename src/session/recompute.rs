//! The one place that decides what a request recomputes: by comparing the old state with the new.

use super::wanted::Wanted;
use super::worker::State;
use crate::mesh::PatchMesh;

/// What a request calls for, and what it came to in the end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recompute {
    /// The model was read.
    pub scene: bool,
    /// It was cut into patches.
    pub mesh: bool,
    /// Other lamps stand in the model.
    pub lamps: bool,
    /// There is no lamp, so nothing was solved.
    pub unlit: bool,
    /// Rows are computed differently, so that stored ones are of no use.
    pub method: bool,
    /// Geometry came out the same, and the rows were kept.
    pub kept_rows: bool,
    /// Rows computed.
    pub rows: usize,
    /// Sweeps made.
    pub sweeps: usize,
    /// Seconds that all of it took.
    pub seconds: f64,
}

impl Recompute {
    /// Geometry, patch size and the fineness of direct light ask for a mesh (and rows, if it differs); method and effects for rows;
    /// reflectances and tolerance for sweeps alone, which every request makes until it converges.
    pub(super) fn between(state: &State, wanted: &Wanted) -> Self {
        let (old, new) = (&state.settings, &wanted.settings);
        let scene = state.opened != wanted.opened || state.scene.is_none();
        let carried = old.transport != new.transport;
        let method = old.sampling() != new.sampling() || old.effects != new.effects || carried;
        let split =
            old.patches != new.patches || old.refinement != new.refinement || old.direct != new.direct;
        let lamps = match (&state.read, &state.scene) {
            (Some(read), Some(present)) if !scene => {
                wanted.lamps_of(read).is_some_and(|lamps| *lamps != present.placed)
            }
            _ => false,
        };
        let mesh = scene || lamps || method || state.prepared.is_none() || split;
        Self { scene, mesh, lamps, method, ..Self::default() }
    }
}

/// Whether two meshes have the same patches in the same places, whatever their materials.
///
/// Every row depends on all geometry, since anything may shadow anything: a mesh that differs
/// anywhere gets all its rows anew.
pub(super) fn same_geometry(a: &PatchMesh, b: &PatchMesh) -> bool {
    a.vertices == b.vertices
        && a.patches.len() == b.patches.len()
        && a.patch_pieces == b.patch_pieces
        && a.pieces.len() == b.pieces.len()
        && a.pieces.iter().zip(&b.pieces).all(|(p, q)| p.patches == q.patches && p.corners == q.corners)
        && a.corners.iter().zip(&b.corners).all(|(p, q)| p.vertex == q.vertex)
        && a.patches
            .iter()
            .zip(&b.patches)
            .all(|(p, q)| p.region == q.region && p.side == q.side && p.centre == q.centre)
}
