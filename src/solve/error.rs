//! Why a solve ends early.

use super::memory::too_large;
use crate::memory::Shortage;
use crate::mesh;
use crate::scene::{SceneError, grouped};
use crate::watch::Cancelled;

/// Why a solve ended without a solution.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// The observer or the token cancelled.
    #[error("the solve was cancelled")]
    Cancelled,
    /// The scene could not be cut into patches.
    #[error(transparent)]
    Mesh(mesh::MeshError),
    /// The scene cannot be put under another sky.
    #[error(transparent)]
    Sky(#[from] SceneError),
    /// The rows would not fit into memory.
    #[error("{}", too_large(*patches, *whole, [*needed_gb, *available_gb], *fitting))]
    Memory {
        /// Patches asked for.
        patches: usize,
        /// Of these, sides of faces smaller than a patch, which need one each.
        whole: usize,
        /// Estimate of the memory needed, GB.
        needed_gb: f64,
        /// Memory free now, GB.
        available_gb: f64,
        /// How many patches would fit.
        fitting: usize,
    },
    /// Not even cutting the scene into patches would fit into memory.
    #[error("the light of {} triangles cannot be computed: {shortage}", grouped(*triangles as i64))]
    Shortage {
        /// Triangles of the scene.
        triangles: usize,
        /// How much is missing.
        shortage: Shortage,
    },
    /// Some of what was computed is no number.
    #[error(
        "the light of {0} patches came out as no number, which is a fault of this program: another number of patches \
         (--patches) may help; please report it with the model"
    )]
    NotFinite(usize),
}

impl From<mesh::MeshError> for PipelineError {
    fn from(error: mesh::MeshError) -> Self {
        match error {
            mesh::MeshError::Cancelled => Self::Cancelled,
            other => Self::Mesh(other),
        }
    }
}

impl From<Cancelled> for PipelineError {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}
