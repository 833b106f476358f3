//! What the window asks of the solver's thread, so that tests can count it.

use crate::direct::Focus;
use crate::scene::{DaylightChoice, PlacedLamp, Scene, SceneSource};
use crate::session::{MaterialEdit, Session, Snapshot};
use crate::solve::SolveSettings;
use std::sync::Arc;

/// The solver as the window sees it: requests in, snapshots out, no call blocks.
pub trait Worker {
    /// The newest snapshot.
    fn latest(&self) -> Arc<Snapshot>;
    /// Opens a scene and solves it.
    fn open(&self, source: SceneSource);
    /// Opens a scene with settings of its own; those of the present scene stay where it is refused.
    fn open_with(&self, source: SceneSource, settings: SolveSettings);
    /// Solves the present scene with other settings.
    fn set_settings(&self, settings: SolveSettings);
    /// The settings asked for last; those in force once some were refused.
    fn settings(&self) -> SolveSettings;
    /// Solves again with these reflectances of `scene`, all that differ from its own.
    fn set_materials(&self, scene: &Arc<Scene>, edits: Vec<MaterialEdit>);
    /// Places these lamps in the scene as it was `read`, instead of those that its file places.
    fn set_lamps(&self, read: &Arc<Scene>, lamps: Vec<PlacedLamp>);
    /// Puts the scene as it was `read` under this sky, instead of that of its file, or under none.
    fn set_daylight(&self, read: &Arc<Scene>, choice: Option<DaylightChoice>);
    /// Lets the solve rest where it is.
    fn pause(&self);
    /// Goes on from there; where nothing is solved for want of lamps, it is after all.
    fn resume(&self);
    /// Ends the solve; the picture so far stays.
    fn stop(&self);
    /// Whether light that has settled becomes finer while nothing else is asked for, first where somebody looks.
    fn refine_at_leisure(&self, on: bool, focus: Option<Focus>);
}

impl Worker for Arc<Session> {
    fn latest(&self) -> Arc<Snapshot> {
        Session::latest(self)
    }

    fn open(&self, source: SceneSource) {
        Session::open(self, source);
    }

    fn open_with(&self, source: SceneSource, settings: SolveSettings) {
        Session::open_with(self, source, settings);
    }

    fn set_settings(&self, settings: SolveSettings) {
        Session::set_settings(self, settings);
    }

    fn settings(&self) -> SolveSettings {
        Session::settings(self)
    }

    fn set_materials(&self, scene: &Arc<Scene>, edits: Vec<MaterialEdit>) {
        Session::set_materials(self, scene, edits);
    }

    fn set_lamps(&self, read: &Arc<Scene>, lamps: Vec<PlacedLamp>) {
        Session::set_lamps(self, read, lamps);
    }

    fn set_daylight(&self, read: &Arc<Scene>, choice: Option<DaylightChoice>) {
        Session::set_daylight(self, read, choice);
    }

    fn pause(&self) {
        Session::pause(self);
    }

    fn resume(&self) {
        Session::resume(self);
    }

    fn stop(&self) {
        Session::stop(self);
    }

    fn refine_at_leisure(&self, on: bool, focus: Option<Focus>) {
        self.look_from(focus);
        Session::refine_at_leisure(self, on);
    }
}
