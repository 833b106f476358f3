//! A tour through the bookmarks, played in the window.

use super::app::App;
use crate::render::{Tour, walking_pace};
use crate::scene::View;

/// Longest step of the clock in one frame, seconds: after a stall the tour goes on where it was.
const LONGEST_STEP: f64 = 0.25;

/// A tour under way.
pub(super) struct Playing {
    tour: Tour,
    seconds: f64,
    /// Gliding to the first bookmark still.
    approaching: bool,
}

impl Playing {
    /// Seconds gone by and seconds in all.
    pub(super) fn progress(&self) -> [f64; 2] {
        [self.seconds, self.tour.seconds()]
    }
}

impl App {
    /// Whether there are bookmarks enough for a tour.
    pub(super) fn can_tour(&self) -> bool {
        self.views.len() >= 2 && self.camera.is_some()
    }

    /// Starts the tour at the first bookmark, or ends the one that plays.
    pub(super) fn toggle_tour(&mut self) {
        if self.touring.take().is_some() {
            return;
        }
        let (Some(prepared), Some(camera)) = (&self.picture.prepared, &mut self.camera) else { return };
        let (up, bounds) = (camera.up(), prepared.bounds);
        let pace = walking_pace(bounds.size().dot(up), bounds.diagonal());
        let Some(tour) = Tour::through(&self.views, up, pace) else { return };
        let pose = camera.pose_of(&view_of(&tour, 0.0));
        camera.travel_to(pose);
        self.state.hint_done = true;
        self.touring = Some(Playing { tour, seconds: 0.0, approaching: true });
    }

    /// Goes on by `dt` seconds; the camera is led while a tour plays. Returns whether it does.
    pub(super) fn play_tour(&mut self, dt: f64) -> bool {
        let (Some(playing), Some(camera)) = (&mut self.touring, &mut self.camera) else { return false };
        if playing.approaching {
            playing.approaching = camera.is_travelling();
            return false;
        }
        playing.seconds += dt.clamp(0.0, LONGEST_STEP);
        let pose = camera.pose_of(&view_of(&playing.tour, playing.seconds));
        camera.stand_at(pose);
        if playing.seconds >= playing.tour.seconds() {
            self.touring = None;
            self.view_index = self.views.len().checked_sub(1);
        }
        true
    }
}

fn view_of(tour: &Tour, seconds: f64) -> View {
    let camera = tour.camera(seconds);
    View {
        name: String::new(),
        eye: camera.eye,
        target: camera.eye + camera.forward,
        fov_y_deg: camera.fov_y_deg,
    }
}
