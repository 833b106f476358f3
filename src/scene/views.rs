//! Places to stand in a scene that comes without bookmarks.

use super::types::{Surface, UpAxis, View};
use crate::geometry::{Aabb, Bvh, Frame, Ray, polygon};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Candidates along each side of the plan.
const GRID: usize = 9;
/// Directions looked into around a candidate.
const AZIMUTHS: usize = 24;
/// From here on a place counts as a room.
const ROOM: f64 = 0.9;
/// From here on it is worth standing in, though light escapes.
const SHELTERED: f64 = 0.6;
/// Scenes with a longer diagonal are entered at once, metres.
const LARGE: f64 = 20.0;

/// Triangles of all surfaces, each with the index of its surface.
pub(super) fn triangles(positions: &[DVec3], surfaces: &[Surface]) -> (Vec<[DVec3; 3]>, Vec<u32>) {
    let (mut list, mut owners) = (Vec::new(), Vec::new());
    for (index, surface) in surfaces.iter().enumerate() {
        let outline: Vec<DVec3> = surface.corners.iter().map(|c| positions[c.position as usize]).collect();
        let mut push = |a: usize, b: usize, c: usize| {
            list.push([outline[a], outline[b], outline[c]]);
            owners.push(index as u32);
        };
        if outline.len() == 3 {
            push(0, 1, 2);
            continue;
        }
        let frame = Frame::around(polygon::area_vector(&outline).normalize_or(DVec3::Z));
        let flat: Vec<DVec2> = outline
            .iter()
            .map(|&p| DVec2::new((p - outline[0]).dot(frame.tangent), (p - outline[0]).dot(frame.bitangent)))
            .collect();
        for [a, b, c] in polygon::triangulate(&flat, &[]) {
            push(a as usize, b as usize, c as usize);
        }
    }
    (list, owners)
}

/// A place at eye height and what can be seen from it.
#[derive(Clone, Copy)]
struct Place {
    eye: DVec3,
    /// Share of all directions in which something stands, 0 to 1.
    enclosure: f64,
    /// The way to look that shows most.
    gaze: DVec3,
    /// How far one sees that way, metres.
    depth: f64,
    /// Mean distance seen around that way, metres.
    openness: f64,
}

struct Surveyor {
    bvh: Bvh,
    bounds: Aabb,
    up: DVec3,
    /// The two horizontal axes.
    sides: [DVec3; 2],
    eye_height: f64,
}

/// Two or three views of the scene and the index of the one to start from.
pub(super) fn default_views(positions: &[DVec3], surfaces: &[Surface], up: UpAxis) -> (Vec<View>, usize) {
    let surveyor = Surveyor::new(positions, surfaces, up);
    let mut places = surveyor.places();
    places.sort_by(|a, b| b.openness.total_cmp(&a.openness));
    places.retain(|p| p.enclosure >= SHELTERED);
    // At the back of a box that is open in front one stands in a room, and yet it is no room.
    let closed = places.iter().filter(|p| p.enclosure >= ROOM).count();
    let is_room = closed >= 2 && 2 * closed > places.len() && surveyor.open_side().is_none();
    places.retain(|p| !is_room || p.enclosure >= ROOM);
    let diagonal = surveyor.bounds.diagonal();
    let mut views = Vec::new();
    if !is_room {
        views.push(surveyor.outside());
    }
    if let Some(first) = places.first() {
        views.push(surveyor.view(if is_room { "Overview" } else { "Inside" }, first));
        let value = |p: &Place| p.openness * p.eye.distance(first.eye) / diagonal;
        let second = places.iter().max_by(|a, b| value(a).total_cmp(&value(b)));
        if let Some(second) = second.filter(|p| p.eye.distance(first.eye) > 0.2 * diagonal) {
            views.push(surveyor.view("Corner", second));
        }
        let centre = surveyor.at_eye_height(surveyor.bounds.centre());
        let off = |p: &Place| p.eye.distance_squared(centre);
        if let Some(middle) = places.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
            && views.len() < 3
            && middle.eye != first.eye
        {
            views.push(surveyor.view("Middle", middle));
        }
    }
    let start = usize::from(!is_room && diagonal > LARGE && views.len() > 1);
    (views, start)
}

impl Surveyor {
    fn new(positions: &[DVec3], surfaces: &[Surface], up: UpAxis) -> Self {
        let (triangles, _) = triangles(positions, surfaces);
        let bvh = Bvh::build(&triangles);
        let bounds = bvh.bounds();
        let up_vector = up.vector();
        let sides = match up {
            UpAxis::Y => [DVec3::X, DVec3::Z],
            UpAxis::Z => [DVec3::X, DVec3::Y],
        };
        let height = bounds.size().dot(up_vector);
        let eye_height = if height > 0.0 { (0.4 * height).min(1.6) } else { 0.25 * bounds.diagonal() };
        Self { bvh, bounds, up: up_vector, sides, eye_height }
    }

    fn at_eye_height(&self, point: DVec3) -> DVec3 {
        point + self.up * (self.bounds.min.dot(self.up) + self.eye_height - point.dot(self.up))
    }

    fn distance(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        self.bvh.nearest(&Ray { origin, direction }, 0.0, f64::INFINITY).map(|hit| hit.distance)
    }

    fn places(&self) -> Vec<Place> {
        let size = self.bounds.size();
        let [a, b] = self.sides;
        let step = |k: usize| (k as f64 + 0.5) / GRID as f64;
        let eyes = (0..GRID * GRID).map(|k| {
            let (i, j) = (k / GRID, k % GRID);
            let corner = self.bounds.min + a * (size.dot(a) * step(i)) + b * (size.dot(b) * step(j));
            self.at_eye_height(corner)
        });
        // How far the floor below lifts the eye.
        let lifted: Vec<(DVec3, f64)> = eyes
            .map(|eye| {
                let floor = self.distance(eye + self.up * 0.5 * self.eye_height, -self.up);
                (eye, floor.map_or(0.0, |down| (1.5 * self.eye_height - down).max(0.0)))
            })
            .collect();
        let mut lifts: Vec<f64> = lifted.iter().map(|(_, lift)| *lift).collect();
        lifts.sort_by(f64::total_cmp);
        let ground = lifts[lifts.len() / 2];
        // Steps and platforms are places to stand; nobody stands on a table.
        let standing = lifted.into_iter().filter(|(_, lift)| *lift <= ground + 0.35 * self.eye_height);
        standing.filter_map(|(eye, lift)| self.survey(eye + self.up * lift)).collect()
    }

    /// What can be seen from `eye`; `None` where one would stand in the furniture.
    fn survey(&self, eye: DVec3) -> Option<Place> {
        const PROBES: usize = 96;
        let diagonal = self.bounds.diagonal();
        let golden = PI * (3.0 - 5.0_f64.sqrt());
        let hits = (0..PROBES)
            .filter(|&k| {
                let z = 1.0 - 2.0 * (k as f64 + 0.5) / PROBES as f64;
                let (sin, cos) = (golden * k as f64).sin_cos();
                let r = (1.0 - z * z).sqrt();
                self.distance(eye, DVec3::new(r * cos, r * sin, z)).is_some()
            })
            .count();
        let gazes: Vec<DVec3> = (0..AZIMUTHS)
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / AZIMUTHS as f64).sin_cos();
                self.sides[0] * cos + self.sides[1] * sin
            })
            .collect();
        let seen: Vec<Option<f64>> = gazes.iter().map(|&gaze| self.distance(eye, gaze)).collect();
        let clearance = seen.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        if clearance < (0.03 * diagonal).min(0.3) {
            return None;
        }
        // Looking into the void shows nothing, so it counts for nothing.
        let reach = |k: usize| seen[k % AZIMUTHS].unwrap_or(0.0);
        let around = |k: usize| (0..9).map(|d| reach(k + AZIMUTHS + d - 4)).sum::<f64>() / 9.0;
        let best = (0..AZIMUTHS).max_by(|&a, &b| around(a).total_cmp(&around(b)))?;
        Some(Place {
            eye,
            enclosure: hits as f64 / PROBES as f64,
            gaze: gazes[best],
            depth: reach(best).max(self.eye_height),
            openness: around(best),
        })
    }

    fn view(&self, name: &str, place: &Place) -> View {
        // A little downwards: floors tell more than ceilings.
        let target = place.eye + (place.gaze - self.up * 0.08) * (0.7 * place.depth);
        View { name: name.to_owned(), eye: place.eye, target, fov_y_deg: 60.0 }
    }

    /// The one horizontal direction in which nothing stands before the centre, where there is just one.
    fn open_side(&self) -> Option<DVec3> {
        let centre = self.bounds.centre();
        let is_open = |axis: DVec3| {
            let frame = Frame::around(axis);
            (0..16).all(|k| {
                let (sin, cos) = (TAU * f64::from(k) / 16.0).sin_cos();
                let tilt = 0.2 + 0.2 * f64::from(k % 2);
                let way = axis + (frame.tangent * cos + frame.bitangent * sin) * tilt;
                self.distance(centre, way).is_none()
            })
        };
        let [a, b] = self.sides;
        let open: Vec<DVec3> = [b, -b, a, -a].into_iter().filter(|&axis| is_open(axis)).collect();
        match open[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// From outside: through the open side where there is one, else from above a corner.
    fn outside(&self) -> View {
        const FOV: f64 = 40.0;
        let slope = (0.5 * FOV.to_radians()).tan();
        let centre = self.bounds.centre();
        let size = self.bounds.size();
        let [a, b] = self.sides;
        let eye = match self.open_side() {
            Some(axis) => {
                let width = size.dot(axis.cross(self.up).abs());
                // The opening should fill a window that is a quarter wider than high.
                let half = 0.55 * (width / 1.25).max(size.dot(self.up));
                centre + axis * (0.5 * size.dot(axis.abs()) + half / slope)
            }
            None => {
                let way = (a * 0.6 + b + self.up * 0.7).normalize();
                centre + way * (0.5 * self.bounds.diagonal() / (0.5 * FOV.to_radians()).sin())
            }
        };
        View { name: "Overview".to_owned(), eye, target: centre, fov_y_deg: FOV }
    }
}

#[cfg(test)]
mod tests {
    use super::super::from_text;
    use super::*;

    const BOX: &str = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 5\nv 4 0 5\nv 4 3 5\nv 0 3 5\n";
    const BACK_AND_SIDES: &str = "f 1 2 3 4\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\n";

    #[test]
    fn a_closed_room_is_seen_from_inside() {
        let scene = from_text("t", &format!("{BOX}{BACK_AND_SIDES}f 5 8 7 6\n"), "", None).unwrap();
        assert!(scene.views.len() >= 2, "{:?}", scene.views);
        let bounds = scene.bounds();
        for view in &scene.views {
            assert!(view.eye.cmpgt(bounds.min).all() && view.eye.cmplt(bounds.max).all(), "{view:?}");
            assert!((view.eye.y - 1.2).abs() < 1e-9, "40 % of the height: {view:?}");
        }
        // The overview looks from near one corner across the room.
        let gaze = scene.views[0].target - scene.views[0].eye;
        assert!(gaze.dot(bounds.centre() - scene.views[0].eye) > 0.0);
        assert_eq!(scene.views[0].name, "Overview");
        assert_eq!(scene.start_view, 0);
    }

    #[test]
    fn an_open_box_is_seen_through_its_open_side() {
        let scene = from_text("t", &format!("{BOX}{BACK_AND_SIDES}"), "", None).unwrap();
        let view = &scene.views[scene.start_view];
        assert_eq!(view.name, "Overview");
        assert!(view.eye.z > 5.0, "the open side is at z = 5: {view:?}");
        assert!(view.eye.distance(DVec3::new(2.0, 1.5, view.eye.z)) < 1e-9);
        // The front edges lie within the field of view.
        let half_angle = (1.5 / (view.eye.z - 5.0)).atan().to_degrees();
        assert!(half_angle < 0.5 * view.fov_y_deg, "{half_angle}");
    }

    #[test]
    fn a_flat_plate_has_a_view_too() {
        let scene = from_text("t", "v 0 0 0\nv 1 0 0\nv 1 0 1\nf 1 3 2\n", "", None).unwrap();
        let view = &scene.views[0];
        assert!(view.eye.y > 0.1 && view.eye.is_finite() && view.target.is_finite(), "{view:?}");
    }
}
