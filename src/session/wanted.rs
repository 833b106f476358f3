//! What the user has asked of the worker.

use super::pipeline::SolveSettings;
use super::worker::MaterialEdit;
use crate::scene::{PlacedLamp, Scene, SceneSource};
use std::sync::{Arc, Weak};

/// All that the user has asked for; the newest state wins, and what was refused is wanted no more.
#[derive(Clone, Debug, Default)]
pub(super) struct Wanted {
    pub(super) source: Option<SceneSource>,
    /// Counts the requests to open, so that the same file can be read again.
    pub(super) opened: u64,
    pub(super) settings: SolveSettings,
    pub(super) edits: Edits,
    /// Placed lamps, and the scene as read that they are for.
    pub(super) lamps: Option<(Weak<Scene>, Vec<PlacedLamp>)>,
    /// Form factors are wanted even where there is no lamp.
    pub(super) unlit: bool,
    /// Counts all requests.
    pub(super) generation: u64,
}

impl Wanted {
    /// Goes back to the lamps that stand in the present `scene`; so does a newer wish that is no other one.
    pub(super) fn return_to_lamps(&mut self, refused: &mut Self, read: &Arc<Scene>, scene: &Scene) {
        refused.lamps = Some((Arc::downgrade(read), scene.placed.clone()));
        if self.generation == refused.generation {
            self.lamps.clone_from(&refused.lamps);
        }
    }

    /// The lamps that are to stand in this scene, where others than those of its file were asked for.
    pub(super) fn lamps_of(&self, read: &Arc<Scene>) -> Option<&[PlacedLamp]> {
        let own = self.lamps.as_ref().filter(|(of, _)| Weak::as_ptr(of) == Arc::as_ptr(read));
        own.map(|(_, lamps)| lamps.as_slice())
    }
}

/// Reflectances and the scene whose materials they are of: an index means nothing in another.
#[derive(Clone, Debug, Default)]
pub(super) struct Edits {
    scene: Weak<Scene>,
    materials: Vec<MaterialEdit>,
}

impl Edits {
    /// These reflectances of `scene`.
    pub(super) fn new(scene: &Arc<Scene>, materials: Vec<MaterialEdit>) -> Self {
        Self { scene: Arc::downgrade(scene), materials }
    }

    /// Those that are of `scene`.
    pub(super) fn of(&self, scene: &Arc<Scene>) -> &[MaterialEdit] {
        if Weak::as_ptr(&self.scene) == Arc::as_ptr(scene) { &self.materials } else { &[] }
    }
}
