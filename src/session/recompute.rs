//! The one place that decides what a request recomputes: by comparing the old state with the new.

use super::wanted::Wanted;
use super::worker::State;
use crate::mesh::PatchMesh;
use crate::scene::DaylightChoice;

/// What a request calls for, and what it came to in the end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recompute {
    /// The model was read.
    pub scene: bool,
    /// It was cut into patches.
    pub mesh: bool,
    /// Other lamps stand in the model, or there is a sky where there was none.
    pub lamps: bool,
    /// The sky is another one: mesh, rows and transport stay.
    pub daylight: bool,
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
    /// another sky for its direct light and sweeps; reflectances and tolerance for sweeps alone, which every request makes until it converges.
    pub(super) fn between(state: &State, wanted: &Wanted) -> Self {
        let (old, new) = (&state.settings, &wanted.settings);
        let scene = state.opened != wanted.opened || state.scene.is_none();
        let carried = old.transport != new.transport;
        let method = old.sampling() != new.sampling() || old.effects != new.effects || carried;
        let split =
            old.patches != new.patches || old.refinement != new.refinement || old.direct != new.direct;
        let mut lamps = false;
        let mut daylight = false;
        if let (Some(read), Some(present), false) = (&state.read, &state.scene, scene) {
            lamps = wanted.lamps_of(read).is_some_and(|lamps| *lamps != present.placed);
            let now = present.outdoors.as_ref().map(|outdoors| outdoors.choice.without_lamps());
            let then = wanted.daylight_of(read).map(DaylightChoice::without_lamps);
            daylight = now != then;
            // The sky is two lamps, which there are or are not.
            lamps |= now.is_some() != then.is_some();
        }
        let mesh = scene || lamps || method || state.prepared.is_none() || split;
        Self { scene, mesh, lamps, daylight, method, ..Self::default() }
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
