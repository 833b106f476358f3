//! What every mesh of a scene rests on, whatever the size of its patches.

use super::build::{Backs, MeshError, MeshSettings, PatchTarget};
use super::reach::{LightSearch, Reach, Space};
use super::regions::{self, Outline};
use crate::scene::Scene;
use crate::watch::Watch;

/// Shares of a survey's time by which coplanar neighbours are joined, about; the rest goes into their sides.
const JOINED: f64 = 0.1;

/// Coplanar neighbours of a scene joined, and the sides of them that light can reach: most of the work of
/// meshing, which meshes of other patch sizes need not do again.
pub struct Survey {
    pub(super) outlines: Vec<Outline>,
    /// Surfaces dropped for want of area.
    pub(super) dropped: usize,
    pub(super) space: Space,
    /// How front and back of each outline stand to light.
    pub(super) reached: Vec<[Reach; 2]>,
    /// Diagonal of the box around everything, metres.
    pub(super) size: f64,
    as_given: bool,
    backs: Backs,
}

impl std::fmt::Debug for Survey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Survey").field("regions", &self.outlines.len()).finish_non_exhaustive()
    }
}

impl Survey {
    /// Surveys a scene for meshes with these settings.
    ///
    /// # Errors
    /// No surface has any area, or the watch ended it.
    pub fn new(
        scene: &Scene,
        settings: &MeshSettings,
        search: LightSearch,
        watch: &mut Watch<'_>,
    ) -> Result<Self, MeshError> {
        let size = scene.bounds().diagonal();
        let as_given = settings.target == PatchTarget::AsGiven;
        let (outlines, dropped) = regions::join(scene, size, as_given, &mut watch.part(0.0, JOINED))?;
        if outlines.is_empty() {
            return Err(MeshError::Empty);
        }
        let mut space = Space::new(&outlines, size);
        let reached: Vec<[Reach; 2]> = match settings.backs {
            Backs::Reached => space.sides(scene, &outlines, search, &mut watch.part(JOINED, 1.0))?,
            Backs::None => outlines
                .iter()
                .map(|o| {
                    let shines = o.luminaire.is_some() && o.emits_back;
                    [Reach::Lit, if shines { Reach::Lit } else { Reach::Black }]
                })
                .collect(),
            Backs::All => vec![[Reach::Lit; 2]; outlines.len()],
        };
        Ok(Self { outlines, dropped, space, reached, size, as_given, backs: settings.backs })
    }

    /// Whether a mesh of the same scene with these settings rests on this.
    pub fn serves(&self, settings: &MeshSettings) -> bool {
        self.as_given == (settings.target == PatchTarget::AsGiven) && self.backs == settings.backs
    }

    /// For each outline whether its front and its back are active.
    pub(super) fn sides(&self) -> Vec<[bool; 2]> {
        self.reached.iter().map(|r| r.map(|side| side == Reach::Lit)).collect()
    }
}
