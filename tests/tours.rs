//! The tours of the embedded scenes pass through nothing.

use glam::DVec3;
use lumenwalk::geometry::{Bvh, Ray};
use lumenwalk::navigation::{FreeSpace, Tour, person_scale, walking_pace};
use lumenwalk::scene::{self, Scene, SceneSource, View};

fn planned(scene: &Scene) -> Tour {
    let (up, bounds) = (scene.up.vector(), scene.bounds());
    let height = bounds.size().dot(up);
    let eyes: Vec<DVec3> = scene.views.iter().map(|view| view.eye).collect();
    let space = FreeSpace::new(&scene.triangles(), &eyes, up, person_scale(height));
    Tour::walk(&scene.views, up, walking_pace(height, bounds.diagonal()), &space).expect("a tour")
}

/// Eyes along the tour, some millimetres to a centimetre apart.
fn eyes(tour: &Tour) -> Vec<DVec3> {
    let count = (tour.seconds() * 200.0) as usize;
    (0..=count).map(|k| tour.camera(tour.seconds() * k as f64 / count as f64).eye).collect()
}

fn collisions(scene: &Scene, eyes: &[DVec3]) -> usize {
    let bvh = Bvh::build(&scene.triangles());
    let meets =
        |p: &&[DVec3]| p[0] != p[1] && bvh.occluded(&Ray { origin: p[0], direction: p[1] - p[0] }, 0.0, 1.0);
    eyes.windows(2).filter(meets).count()
}

#[test]
fn no_tour_passes_through_a_wall() {
    for name in ["hemicube", "cornell", "gallery", "house"] {
        let scene = scene::load(&SceneSource::Builtin(name.to_owned())).expect("embedded");
        let tour = planned(&scene);
        let eyes = eyes(&tour);
        assert_eq!(tour.barred(), [0_usize; 0], "{name}");
        assert_eq!(collisions(&scene, &eyes), 0, "{name}");
        for view in &scene.views {
            let nearest = eyes.iter().map(|eye| eye.distance(view.eye)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.05, "{name}: {} is missed by {nearest} m", view.name);
        }
        if name == "house" {
            let up = scene.up.vector();
            let heights = eyes.iter().map(|eye| eye.dot(up));
            let (low, high) = heights.fold((f64::MAX, f64::MIN), |(a, b), h| (a.min(h), b.max(h)));
            assert!(low > 1.2 && high < 1.9, "eyes from {low} to {high} m");
        }
    }
}

#[test]
fn the_straight_tour_of_the_house_would_pass_through_walls() {
    let scene = scene::load(&SceneSource::Builtin("house".to_owned())).expect("embedded");
    let straight = Tour::through(&scene.views, scene.up.vector(), 1.6).expect("a tour");
    assert!(collisions(&scene, &eyes(&straight)) > 3);
}

#[test]
fn where_no_way_leads_the_tour_goes_straight_and_tells() {
    let eye = |x: f64| DVec3::new(x, 1.6, 0.0);
    let view = |x: f64| View { name: String::new(), eye: eye(x), target: eye(x + 1.0), fov_y_deg: 60.0 };
    // A closed box of 2 m around the second view.
    let corner =
        |k: usize| eye(5.0) + DVec3::new([-1.0, 1.0][k & 1], [-1.0, 1.0][k >> 1 & 1], [-1.0, 1.0][k >> 2]);
    let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<[DVec3; 3]> =
        sides.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).map(|t| t.map(corner)).collect();
    let views = [view(0.0), view(5.0), view(5.5)];
    let eyes = views.clone().map(|view| view.eye);
    let tour = Tour::walk(&views, DVec3::Y, 1.6, &FreeSpace::new(&triangles, &eyes, DVec3::Y, 1.0));
    let tour = tour.expect("a tour");
    assert_eq!(tour.barred(), [0]);
    let ends = [0.0, tour.seconds()].map(|seconds| tour.camera(seconds).eye);
    assert!(ends[0].distance(eye(0.0)) < 1e-9 && ends[1].distance(eye(5.5)) < 1e-9, "{ends:?}");
}
