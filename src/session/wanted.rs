//! What the user has asked of the worker.

use super::handle::MaterialEdit;
use crate::scene::{DaylightChoice, PlacedLamp, Scene, SceneSource};
use crate::solve::SolveSettings;
use std::sync::{Arc, Weak};

/// All that the user has asked for; the newest state wins, and what was refused is wanted no more.
#[derive(Clone, Debug, Default)]
pub(super) struct Wanted {
    pub(super) source: Option<SceneSource>,
    /// Counts the requests to open, so that the same file can be read again.
    pub(super) opened: u64,
    pub(super) settings: SolveSettings,
    /// While another scene is on its way: the source before it and its settings, in case that scene is
    /// refused.
    held: Option<(Option<SceneSource>, SolveSettings)>,
    pub(super) edits: Edits,
    /// Placed lamps, and the scene as read that they are for.
    pub(super) lamps: Option<(Weak<Scene>, Vec<PlacedLamp>)>,
    /// Daylight other than that of the file, and the scene as read that it is for.
    pub(super) daylight: Option<(Weak<Scene>, Option<DaylightChoice>)>,
    /// Form factors are wanted even where there is no lamp.
    pub(super) unlit: bool,
    /// Counts all requests.
    pub(super) generation: u64,
}

impl Wanted {
    /// Asks for a scene under the settings as they are, or for the one again that another was to replace.
    pub(super) fn open(&mut self, source: SceneSource) {
        let source = Some(source);
        if self.held.as_ref().is_some_and(|(before, _)| *before == source) {
            self.return_to(source);
        } else {
            self.source = source;
        }
        self.opened += 1;
        self.unlit = false;
    }

    /// Asks for a scene with settings of its own.
    pub(super) fn open_with(&mut self, source: SceneSource, settings: SolveSettings) {
        let before = (self.source.replace(source), std::mem::replace(&mut self.settings, settings));
        self.held.get_or_insert(before);
        self.opened += 1;
        self.unlit = false;
    }

    /// The request to open of this number has been answered.
    pub(super) fn has_come(&mut self, opened: u64) {
        if self.opened == opened {
            self.held = None;
        }
    }

    /// Goes back to the scene before the one that was refused, with the settings that it had.
    pub(super) fn return_to(&mut self, source: Option<SceneSource>) {
        self.source = source;
        if let Some((_, settings)) = self.held.take() {
            self.settings = settings;
        }
    }

    /// Goes back to the lamps that stand in the present `scene`; so does a newer wish that is no other one.
    pub(super) fn return_to_lamps(&mut self, refused: &mut Self, read: &Arc<Scene>, scene: &Scene) {
        refused.lamps = Some((Arc::downgrade(read), scene.placed.clone()));
        if self.generation == refused.generation {
            self.lamps.clone_from(&refused.lamps);
        }
    }

    /// The daylight that is to be in this scene: that of its file unless another was asked for.
    pub(super) fn daylight_of<'a>(&'a self, read: &'a Arc<Scene>) -> Option<&'a DaylightChoice> {
        match self.daylight.as_ref().filter(|(of, _)| Weak::as_ptr(of) == Arc::as_ptr(read)) {
            Some((_, choice)) => choice.as_ref(),
            None => read.outdoors.as_ref().map(|outdoors| &outdoors.choice),
        }
    }

    /// Goes back to the daylight of the present `scene`; so does a newer wish that is no other one.
    pub(super) fn return_to_daylight(&mut self, refused: &mut Self, read: &Arc<Scene>, scene: &Scene) {
        let present = scene.outdoors.as_ref().map(|outdoors| outdoors.choice.clone());
        refused.daylight = Some((Arc::downgrade(read), present));
        if self.generation == refused.generation {
            self.daylight.clone_from(&refused.daylight);
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

    /// Those that are of one of these scenes.
    pub(super) fn of(&self, scenes: &[Weak<Scene>]) -> &[MaterialEdit] {
        if scenes.iter().any(|scene| scene.ptr_eq(&self.scene)) { &self.materials } else { &[] }
    }
}
