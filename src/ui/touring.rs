//! A tour through the bookmarks, played in the window.

use super::app::App;
use crate::navigation::{FreeSpace, Tour, person_scale, walking_pace};
use crate::scene::View;
use std::sync::Arc;

/// Longest step of the clock in one frame, seconds: after a stall the tour goes on where it was.
const LONGEST_STEP: f64 = 0.25;

/// What a tour was planned for: the mesh and the bookmarks.
pub(super) type Plan = (u64, Vec<View>);

/// A tour under way.
pub(super) struct Playing {
    plan: Plan,
    /// Where it leads, once its ways are found.
    tour: Option<Arc<Option<Tour>>>,
    seconds: f64,
    /// Gliding to the first bookmark still.
    approaching: bool,
}

impl Playing {
    /// Seconds gone by and seconds in all; zero in all while ways are looked for.
    pub(super) fn progress(&self) -> [f64; 2] {
        let tour = self.tour.as_ref().and_then(|tour| tour.as_ref().as_ref());
        [self.seconds, tour.map_or(0.0, Tour::seconds)]
    }

    /// Says from which bookmarks it goes straight through things, where it does.
    pub(super) fn barred(&self) -> Option<String> {
        let tour = self.tour.as_ref()?.as_ref().as_ref()?;
        let names: Vec<&str> =
            tour.barred().iter().filter_map(|&k| Some(self.plan.1.get(k)?.name.as_str())).collect();
        let from = match names[..] {
            [] => return None,
            [name] => name.to_owned(),
            [name, ..] => format!("{name} and {} more", names.len() - 1),
        };
        Some(format!("No way leads on from {from}: there it goes straight"))
    }
}

impl App {
    /// Whether there are bookmarks enough for a tour.
    pub(super) fn can_tour(&self) -> bool {
        self.views.len() >= 2 && self.camera.is_some()
    }

    /// Starts the tour at the first bookmark, or ends the one that plays. Its ways are looked for on a
    /// helper thread while the camera glides there.
    pub(super) fn toggle_tour(&mut self) {
        if self.touring.take().is_some() || !self.can_tour() {
            return;
        }
        self.move_as_chosen();
        let (Some(prepared), Some(camera)) = (&self.picture.prepared, &mut self.camera) else { return };
        camera.travel_to(camera.pose_of(&self.views[0]));
        self.state.hint_done = true;
        let plan = (prepared.mesh_serial, self.views.clone());
        self.touring = Some(Playing { plan, tour: None, seconds: 0.0, approaching: true });
    }

    /// Goes on by `dt` seconds; the camera is led while a tour plays. Returns whether it does.
    pub(super) fn play_tour(&mut self, ctx: &egui::Context, dt: f64) -> bool {
        self.find_ways(ctx);
        let (Some(playing), Some(camera)) = (&mut self.touring, &mut self.camera) else { return false };
        if playing.approaching {
            playing.approaching = camera.is_travelling();
            return false;
        }
        let Some(tour) = &playing.tour else { return false };
        let Some(tour) = tour.as_ref() else {
            self.touring = None;
            return false;
        };
        playing.seconds += dt.clamp(0.0, LONGEST_STEP);
        let pose = camera.pose_of(&view_of(tour, playing.seconds));
        camera.stand_at(pose);
        if playing.seconds >= tour.seconds() {
            self.touring = None;
            self.view_index = self.views.len().checked_sub(1);
        }
        true
    }

    /// Has the ways of the tour looked for, and takes them over once they are found.
    fn find_ways(&mut self, ctx: &egui::Context) {
        self.tours.listen();
        let Some(playing) = self.touring.as_mut().filter(|playing| playing.tour.is_none()) else { return };
        let found = self.tours.latest().filter(|(plan, _)| **plan == playing.plan);
        if let Some(tour) = found.map(|(_, tour)| Arc::clone(tour)) {
            playing.tour = Some(tour);
            return;
        }
        let Some(prepared) = &self.picture.prepared else { return };
        let (scene, views) = (Arc::clone(&prepared.scene), playing.plan.1.clone());
        let find = move || {
            let (up, extent) = (scene.up.vector(), scene.extent());
            let bounds = extent.main;
            let height = bounds.size().dot(up).abs();
            let eyes: Vec<_> = views.iter().map(|view| view.eye).collect();
            let space = FreeSpace::new(&scene.main_triangles(&extent), &eyes, up, person_scale(height));
            Tour::walk(&views, up, walking_pace(height, extent.scale), &space)
        };
        let wake = ctx.clone();
        self.tours.ask(&playing.plan, find, move || wake.request_repaint());
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
