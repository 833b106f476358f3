//! Places to stand in a scene that comes without bookmarks.

use super::model::ModelView;
use super::names;
use super::space::{Floor, Space};
use super::types::{LengthUnit, Scene, Surface, View};
use crate::geometry::{Aabb, Frame, polygon};
use glam::{DVec2, DVec3};
use std::collections::HashSet;
use std::f64::consts::{PI, TAU};

/// Points on floors that are tried.
const CANDIDATES: usize = 240;
/// Lamps below which one tries to stand.
const LAMPS: usize = 40;
/// Places that are looked around from.
const SURVEYED: usize = 90;
/// Places whose pictures are compared.
const COMPARED: usize = 14;
/// Directions looked into around a place.
const AZIMUTHS: usize = 24;
/// Lines of sight in which a picture is judged, across and down.
const PICTURE: [u32; 2] = [16, 10];
/// From here on a place counts as a room.
const ROOM: f64 = 0.9;
/// From here on it is worth standing in, though light escapes.
const SHELTERED: f64 = 0.6;
/// Scenes with a longer diagonal are entered at once, metres for an adult.
const LARGE: f64 = 20.0;
/// Eyes above the floor, metres for an adult.
const EYES: f64 = 1.6;
/// Room that an adult stands in, metres.
const STANDING: f64 = 1.9;

/// How far ahead of a camera the point is that its view looks at, metres.
const AHEAD: f64 = 2.0;
/// Vertical fields of view that a view can have, degrees.
const FIELDS: [f64; 2] = [5.0, 150.0];

/// The views of cameras that come with a model file, in metres from where the scene counts from.
pub(super) fn of_cameras(cameras: &[ModelView], unit: LengthUnit, origin: DVec3) -> Vec<View> {
    let mut taken = HashSet::new();
    let mut view = |camera: &ModelView| {
        let eye = camera.eye * unit.metres() - origin;
        let [least, most] = FIELDS;
        let fov_y_deg = if camera.fov_y_deg.is_finite() { camera.fov_y_deg.clamp(least, most) } else { 60.0 };
        let name = names::unique(&camera.name, &mut taken);
        eye.is_finite().then(|| View { name, eye, target: eye + AHEAD * camera.forward, fov_y_deg })
    };
    cameras.iter().filter_map(&mut view).collect()
}

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
#[derive(Clone, Copy, Debug)]
struct Place {
    eye: DVec3,
    /// Share of all directions in which something stands, 0 to 1.
    enclosure: f64,
    /// Whether something that shines can be seen.
    sees_lamp: bool,
    /// The way to look in which one sees farthest.
    gaze: DVec3,
    /// How far one sees that way, metres.
    depth: f64,
    /// Mean distance seen around that way, metres.
    openness: f64,
    /// How far one sees in each of the directions around, metres; zero into the void.
    around: [f64; AZIMUTHS],
}

struct Surveyor<'a> {
    scene: &'a Scene,
    space: &'a Space,
    bounds: Aabb,
    up: DVec3,
    /// The two horizontal axes.
    sides: [DVec3; 2],
    /// Metres of the model to one of an adult.
    scale: f64,
    /// Places right below lamps.
    below_lamps: Vec<DVec3>,
}

/// Two or three views of the scene and the index of the one to start from. `scale` are the metres of the
/// model to one of an adult, above zero.
pub(super) fn default_views(scene: &Scene, space: &Space, scale: f64) -> (Vec<View>, usize) {
    let surveyor = Surveyor::new(scene, space, scale);
    let mut places = surveyor.places();
    places.sort_by(|a, b| b.openness.total_cmp(&a.openness));
    places.retain(|p| p.enclosure >= SHELTERED);
    // At the back of a box that is open in front one stands in a room, and yet it is no room. Nor is the
    // inside of a solid that stands in the open, unless there is light in it.
    let is_closed = |p: &Place| p.enclosure >= ROOM;
    let is_lit = |p: &Place| is_closed(p) && p.sees_lamp;
    let count = |test: &dyn Fn(&Place) -> bool| places.iter().filter(|p| test(p)).count();
    let (closed, lit) = (count(&is_closed), count(&is_lit));
    let is_building = lit >= 2 || closed >= 2 && 2 * closed > places.len();
    let is_room = is_building && surveyor.open_side().is_none();
    if is_room {
        places.retain(|p| if lit >= 2 { is_lit(p) } else { is_closed(p) });
    }
    let diagonal = surveyor.bounds.diagonal();
    let mut views = Vec::new();
    if !is_room {
        views.push(surveyor.outside());
    }
    if let Some(first) = surveyor.most_telling(&places) {
        views.push(surveyor.view(if is_room { "Overview" } else { "Inside" }, &first));
        let value = |p: &Place| p.openness * p.eye.distance(first.eye) / diagonal;
        let second = places.iter().max_by(|a, b| value(a).total_cmp(&value(b)));
        if let Some(second) = second.filter(|p| p.eye.distance(first.eye) > 0.2 * diagonal) {
            views.push(surveyor.view("Corner", second));
        }
        let centre = surveyor.bounds.centre();
        let off = |p: &Place| (p.eye - centre).reject_from(surveyor.up).length_squared();
        if let Some(middle) = places.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
            && views.len() < 3
            && middle.eye != first.eye
        {
            views.push(surveyor.view("Middle", middle));
        }
    }
    let start = usize::from(!is_room && diagonal > LARGE * scale && views.len() > 1);
    (views, start)
}

/// Mean distance seen around a direction, metres: over 60 degrees to either side.
fn openness(around: &[f64; AZIMUTHS], azimuth: usize) -> f64 {
    (0..9).map(|d| around[(azimuth + AZIMUTHS + d - 4) % AZIMUTHS]).sum::<f64>() / 9.0
}

/// Places right below lamps, evenly chosen where they are many.
fn below_lamps(scene: &Scene, scale: f64) -> Vec<DVec3> {
    let faces: Vec<&Surface> = scene.surfaces.iter().filter(|s| s.luminaire.is_some()).collect();
    let step = faces.len().div_ceil(LAMPS).max(1);
    let below = |surface: &Surface| {
        let outline = scene.polygon(surface);
        let centre = outline.iter().sum::<DVec3>() / outline.len().max(1) as f64;
        centre - scene.up.vector() * (0.02 * scale)
    };
    faces.into_iter().step_by(step).map(below).collect()
}

impl<'a> Surveyor<'a> {
    fn new(scene: &'a Scene, space: &'a Space, scale: f64) -> Self {
        let up = scene.up.vector();
        let sides = [DVec3::X, if up == DVec3::Y { DVec3::Z } else { DVec3::Y }];
        Self { scene, space, bounds: space.main, up, sides, scale, below_lamps: below_lamps(scene, scale) }
    }

    /// Where one can stand, and what one sees there.
    fn places(&self) -> Vec<Place> {
        let mut floors: Vec<Floor> = self.space.floors(self.up, CANDIDATES);
        for &lamp in &self.below_lamps {
            floors.extend(self.space.floor_below(lamp, self.up));
            // Beside it as well: right below there is often a table.
            for angle in [0.0, 0.25, 0.5, 0.75].map(|turn| TAU * turn) {
                let (way, aside) = (self.level(angle), 1.3 * self.scale);
                if self.space.distance(lamp, way).is_none_or(|free| free > aside) {
                    floors.extend(self.space.floor_below(lamp + way * aside, self.up));
                }
            }
        }
        let standing: Vec<DVec3> = floors.iter().filter_map(|floor| self.stand_on(floor)).collect();
        let step = standing.len().div_ceil(SURVEYED).max(1);
        standing.iter().step_by(step).filter_map(|&eye| self.survey(eye)).collect()
    }

    /// Where the eyes are of somebody who stands here; `None` where nobody could or would.
    fn stand_on(&self, floor: &Floor) -> Option<DVec3> {
        if floor.headroom.is_some_and(|room| room < STANDING * self.scale) {
            return None;
        }
        let eye = floor.place + self.up * (EYES * self.scale);
        // Nobody stands on a table or on a wall: the floor goes on around the feet.
        const AROUND: usize = 8;
        let reach = 0.7 * self.scale;
        let goes_on = |k: &usize| {
            let at = eye + self.level(TAU * *k as f64 / AROUND as f64) * reach;
            let down = self.space.distance(at, -self.up);
            down.is_some_and(|down| (down - EYES * self.scale).abs() < 0.35 * self.scale)
        };
        ((0..AROUND).filter(goes_on).count() >= 5).then_some(eye)
    }

    /// The level direction at this angle.
    fn level(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.sides[0] * cos + self.sides[1] * sin
    }

    /// What can be seen from `eye`; `None` where one would stand in the furniture.
    fn survey(&self, eye: DVec3) -> Option<Place> {
        const PROBES: usize = 96;
        let golden = PI * (3.0 - 5.0_f64.sqrt());
        let probes = (0..PROBES).map(|k| {
            let z = 1.0 - 2.0 * (k as f64 + 0.5) / PROBES as f64;
            let (sin, cos) = (golden * k as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            self.space.seen(eye, DVec3::new(r * cos, r * sin, z))
        });
        let (mut hits, mut sees_lamp) = (0, false);
        for (_, surface) in probes.flatten() {
            hits += 1;
            sees_lamp |= self.shines(surface);
        }
        let gazes: Vec<DVec3> = (0..AZIMUTHS).map(|k| self.level(TAU * k as f64 / AZIMUTHS as f64)).collect();
        let seen: Vec<Option<f64>> = gazes.iter().map(|&gaze| self.space.distance(eye, gaze)).collect();
        let clearance = seen.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        if clearance < (0.03 * self.bounds.diagonal()).min(0.3 * self.scale) {
            return None;
        }
        let sees_lamp = sees_lamp
            || self.below_lamps.iter().any(|&lamp| {
                let way = (lamp - eye).normalize_or(self.up);
                self.space.seen(eye, way).is_some_and(|(_, surface)| self.shines(surface))
            });
        // Looking into the void shows nothing, so it counts for nothing.
        let around = std::array::from_fn(|k| seen[k].unwrap_or(0.0));
        let best = (0..AZIMUTHS).max_by(|&a, &b| openness(&around, a).total_cmp(&openness(&around, b)))?;
        let enclosure = f64::from(hits) / PROBES as f64;
        let blind = Place { eye, enclosure, sees_lamp, gaze: gazes[best], depth: 0.0, openness: 0.0, around };
        Some(self.looking(&blind, best))
    }

    /// The same place, looking that way.
    fn looking(&self, place: &Place, azimuth: usize) -> Place {
        Place {
            gaze: self.level(TAU * azimuth as f64 / AZIMUTHS as f64),
            depth: place.around[azimuth].max(EYES * self.scale),
            openness: openness(&place.around, azimuth),
            ..*place
        }
    }

    fn shines(&self, surface: u32) -> bool {
        self.scene.surfaces[surface as usize].luminaire.is_some()
    }

    /// Of these places, sorted by how far one sees, the one and the way to look whose picture tells most.
    fn most_telling(&self, places: &[Place]) -> Option<Place> {
        let ways = places.iter().take(COMPARED).flat_map(|place| {
            let all = (0..AZIMUTHS).step_by(2).map(move |azimuth| self.looking(place, azimuth));
            all.filter(move |looking| looking.openness > 0.6 * place.openness).chain([*place])
        });
        let rated = ways.map(|place| (self.worth(&place), place));
        rated.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, place)| place)
    }

    /// How much the picture from a place tells: depth, and how many different things are in it.
    fn worth(&self, place: &Place) -> f64 {
        let view = self.view("", place);
        let forward = (view.target - view.eye).normalize_or(place.gaze);
        let right = forward.cross(self.up).normalize_or(self.sides[0]);
        let above = right.cross(forward);
        let half = (0.5 * view.fov_y_deg.to_radians()).tan();
        let mut things = HashSet::new();
        let (mut depth, mut blocked) = (0.0, 0.0);
        for (i, j) in (0..PICTURE[0]).flat_map(|i| (0..PICTURE[1]).map(move |j| (i, j))) {
            let x = half * (f64::from(2 * i + 1) / f64::from(PICTURE[1]) - 1.6);
            let y = half * (f64::from(2 * j + 1) / f64::from(PICTURE[1]) - 1.0);
            let way = (forward + right * x + above * y).normalize();
            let Some((distance, surface)) = self.space.seen(view.eye, way) else { continue };
            let surface = &self.scene.surfaces[surface as usize];
            things.insert((surface.object, surface.material));
            depth += (1.0 + distance / self.scale).ln();
            // What stands right ahead is in the way long before it is near.
            let near = if (5..11).contains(&i) { 2.0 } else { 1.0 };
            blocked += f64::from(u8::from(distance < near * self.scale));
        }
        let rays = f64::from(PICTURE[0] * PICTURE[1]);
        depth / rays - 2.0 * blocked / rays + 0.3 * (1.0 + things.len() as f64).ln()
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
                self.space.distance(centre, way).is_none()
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
            assert!((view.eye.y - EYES).abs() < 1e-9, "the eyes of an adult: {view:?}");
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

    /// A block as six outward faces, appended with its corners.
    fn block(text: &mut String, corners: &mut usize, low: [f64; 3], high: [f64; 3]) {
        for k in 0..8 {
            let at = |axis: usize, bit: usize| if k >> bit & 1 == 1 { high[axis] } else { low[axis] };
            *text += &format!("v {} {} {}\n", at(0, 0), at(1, 1), at(2, 2));
        }
        for face in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
            let [a, b, c, d] = face.map(|k| *corners + k);
            *text += &format!("f {a} {b} {c} {d}\n");
        }
        *corners += 8;
    }

    /// A house of two storeys of 2.6 m with a table in each, at x = z = 900.
    fn house(text: &mut String, corners: &mut usize) {
        for floor in [0.0, 2.8] {
            block(text, corners, [900.0, floor, 900.0], [910.0, floor + 2.6, 908.0]);
            block(text, corners, [903.0, floor, 903.0], [905.0, floor + 0.75, 904.0]);
        }
    }

    fn looks_into_a_room(scene: &Scene) {
        let view = &scene.views[scene.start_view];
        let height = view.eye[scene.up.vector().max_position()];
        let on_a_floor = [0.0, 2.8].iter().any(|floor| (height - floor - EYES).abs() < 1e-6);
        assert!(on_a_floor, "eyes above a floor, not above a table: {view:?}");
        let inside =
            view.eye.cmpgt(DVec3::new(900.0, 0.0, 900.0)) & view.eye.cmplt(DVec3::new(910.0, 5.4, 908.0));
        assert!(inside.all(), "{view:?}");
        let space = Space::of(scene, &scene.extent());
        let ahead = space.distance(view.eye, (view.target - view.eye).normalize());
        assert!(ahead.is_some_and(|free| free > 3.0), "{ahead:?} m ahead of {view:?}");
    }

    #[test]
    fn a_house_is_entered_on_a_floor_whatever_lies_around_it() {
        let (mut text, mut corners) = (String::new(), 0);
        house(&mut text, &mut corners);
        looks_into_a_room(&from_text("t", &text, "", None).unwrap());
        // On two kilometres of terrain in 800 faces, with a lamp upstairs.
        let mtl = "newmtl lamp\nKd 0 0 0\nKe 9 9 9\nnewmtl grey\nKd 0.5 0.5 0.5\n";
        let lamp = "v 905 5.3 905\nv 906 5.3 905\nv 906 5.3 906\nv 905 5.3 906\nusemtl lamp\n";
        text += &format!(
            "{lamp}f {} {} {} {}\nusemtl grey\n",
            corners + 1,
            corners + 2,
            corners + 3,
            corners + 4
        );
        corners += 4;
        for k in 0..441 {
            let (x, z) = (f64::from(k % 21) * 100.0, f64::from(k / 21) * 100.0);
            text += &format!("v {x} {} {z}\n", -1.0 - 0.5 * f64::from((k * 7) % 11));
        }
        for k in 0..400 {
            let a = corners + k / 20 * 21 + k % 20 + 1;
            text += &format!("f {a} {} {}\nf {} {} {}\n", a + 21, a + 1, a + 1, a + 21, a + 22);
        }
        let scene = from_text("t", &format!("mtllib m.mtl\n{text}"), mtl, None).unwrap();
        assert!(scene.extent().main.diagonal() > 2800.0 && scene.extent().stray.is_empty());
        looks_into_a_room(&scene);
        assert!(scene.views[scene.start_view].eye.y > 2.8, "where the light is");
    }

    #[test]
    fn a_room_in_millimetres_is_seen_at_the_height_of_its_eyes() {
        let (mut text, mut corners) = (String::new(), 0);
        block(&mut text, &mut corners, [0.0; 3], [5000.0, 2600.0, 4000.0]);
        let scene = from_text("t", &text, "", None).unwrap();
        assert!((scene.views[0].eye.y - 1600.0).abs() < 1.0, "{:?}", scene.views[0]);
    }
}
