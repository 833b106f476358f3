//! Which triangles a picture is drawn by: light at their corners fits these and no others.

use super::prepared::Prepared;
use crate::direct::Elements;
use crate::session::Snapshot;
use std::sync::Arc;

/// What is drawn: the mesh of a snapshot, and the elements that it is divided into.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    mesh_serial: u64,
    /// None where the mesh is drawn undivided.
    pub(super) elements: Option<Arc<Elements>>,
}

impl Drawn {
    /// What a snapshot is to be drawn by.
    pub(super) fn by(snapshot: &Snapshot) -> Self {
        let elements = snapshot.element_light().map(|light| Arc::clone(&light.elements));
        Self { mesh_serial: snapshot.mesh_serial, elements }
    }

    /// What a mesh draws that is made ready for the screen.
    pub(super) fn of(prepared: &Prepared) -> Self {
        Self { mesh_serial: prepared.mesh_serial, elements: prepared.display.elements().cloned() }
    }

    /// Whether both are drawn by the same triangles.
    pub(super) fn is(&self, other: &Self) -> bool {
        self.mesh_serial == other.mesh_serial
            && match (&self.elements, &other.elements) {
                (Some(one), Some(another)) => one.are_same_trees(another),
                (one, another) => one.is_none() && another.is_none(),
            }
    }
}
