use super::PatchMesh;
use crate::scene::Scene;

/// How finely surfaces are split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PatchTarget {
    /// What the scene's sidecar asks for; else a size that gives about 3,000 patches or more.
    #[default]
    Auto,
    /// Longest edge of a patch, metres; above zero.
    Size(f64),
    /// About this many patches in all; at least one a side.
    Count(usize),
    /// Every input polygon is one patch.
    AsGiven,
}

/// Everything that the mesh depends on besides the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshSettings {
    /// How finely surfaces are split.
    pub target: PatchTarget,
}

/// Why a scene cannot be cut into patches.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No surface has any area.
    #[error("the scene holds no surface with an area, so there is nothing to light")]
    Empty,
}

/// Splits the surfaces of a scene into patches.
pub fn build(_scene: &Scene, _settings: &MeshSettings) -> Result<PatchMesh, MeshError> {
    Err(MeshError::Empty)
}
