use super::{Camera, FreeSpace};
use crate::scene::View;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Speed of a walking adult, m/s.
pub const WALK_SPEED: f64 = 1.6;
/// Steepest look up or down, radians.
const MAX_PITCH: f64 = 1.55;
/// Fastest that a tour turns on average over a leg, radians a second.
const TURN_RATE: f64 = 0.7;
/// Shortest time between two bookmarks, seconds.
const SHORTEST_LEG: f64 = 0.25;
/// Time in which a tour sets out and in which it comes to rest, seconds.
const EASE: f64 = 1.2;
/// Samples of arc length between two bookmarks.
const SAMPLES: usize = 256;
/// Samples of arc length from one trial for collisions to the next.
const TRIED_EVERY: usize = 16;
/// Rounds in which a curve that swings into something is held to its straight way.
const HOLD_ROUNDS: usize = 6;
/// A way so many times as long as the straight one counts as bent: there the tour looks where it goes.
const BENT: f64 = 1.05;
/// Time from one place where a tour turns to its way to the next, seconds of walking.
const LOOK_AHEAD: f64 = 0.7;

/// Metres of the model to one metre of an adult: below one where a room of `height` metres is too low
/// to stand in (the Cornell box measures 0.55 m).
pub fn person_scale(height: f64) -> f64 {
    if height < 2.2 && height > 0.0 { height / 2.6 } else { 1.0 }
}

/// Metres a second at which one walks through a model of this height and scale (the diagonal of its main
/// part, or less on a site), metres. Large models are crossed in about half a minute, whatever their unit.
pub fn walking_pace(height: f64, diagonal: f64) -> f64 {
    let large = if diagonal > 60.0 { diagonal / 40.0 } else { 0.0 };
    (WALK_SPEED * person_scale(height)).max(large)
}

/// A walk through bookmarks: a smooth way at an even pace, turning evenly, setting out and arriving
/// softly. Where the straight way from one to the next is barred it leads around, looking ahead.
///
/// The eye follows a centripetal Catmull-Rom curve (Barry & Goldman 1988; Yuksel, Schaefer & Keyser
/// 2011), measured by arc length. Way, heading, pitch and field of view are monotone cubics over time
/// (Fritsch & Butland 1984): without a jump in speed, and without swinging past a bookmark.
#[derive(Clone, Debug, PartialEq)]
pub struct Tour {
    up: DVec3,
    axes: [DVec3; 2],
    /// Bookmarks that differ in place and what lies between them, with one beyond each end.
    points: Vec<DVec3>,
    /// Way covered at each sample of the curve, metres.
    lengths: Vec<f64>,
    /// When each bookmark, and each place where the tour turns to its way, is passed, seconds of an even
    /// walk.
    times: Vec<f64>,
    /// Way, heading, pitch and field of view at each of them, each with its slope a second.
    tracks: [Track; 4],
    ease: f64,
    barred: Vec<usize>,
}

#[derive(Clone, Debug, Default, PartialEq)]
struct Track {
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Tour {
    /// The tour through `views` in their order, straight through whatever stands between them; `up` is a
    /// unit vector, `pace` the speed of walking in metres a second, above zero. `None` for fewer than two
    /// views, or any that is not finite.
    pub fn through(views: &[View], up: DVec3, pace: f64) -> Option<Self> {
        Self::planned(views, up, pace, None)
    }

    /// As [`Tour::through`], on ways through `space` that pass through nothing. Where there is none the
    /// tour goes straight: see [`Tour::barred`].
    pub fn walk(views: &[View], up: DVec3, pace: f64, space: &FreeSpace) -> Option<Self> {
        Self::planned(views, up, pace, Some(space))
    }

    fn planned(views: &[View], up: DVec3, pace: f64, space: Option<&FreeSpace>) -> Option<Self> {
        let is_finite = |v: &View| v.eye.is_finite() && v.target.is_finite() && v.fov_y_deg.is_finite();
        if views.len() < 2 || !(pace > 0.0 && pace.is_finite()) || !views.iter().all(is_finite) {
            return None;
        }
        let mut route = Route::new(views, pace, space);
        if let Some(space) = space {
            route.hold(space);
        }
        let Route { stops, mut points, mut place_of, barred } = route;
        let right = up.any_orthonormal_vector();
        let axes = [right, up.cross(right)];
        let lengths = with_ends(&mut points);
        let way_to = |place: usize| lengths[place * SAMPLES];
        let stations = looking_ahead(&stops, &mut place_of, &points, &lengths, LOOK_AHEAD * pace, up);
        let way: Vec<f64> = place_of.iter().map(|&place| way_to(place)).collect();
        let (headings, pitches) = directions(&stations, up, axes);
        let fovs: Vec<f64> = stations.iter().map(|v| v.fov_y_deg.clamp(5.0, 150.0)).collect();
        let mut times = vec![0.0];
        for k in 1..stations.len() {
            let turn = (headings[k] - headings[k - 1]).abs().max((pitches[k] - pitches[k - 1]).abs());
            let seconds = ((way[k] - way[k - 1]) / pace).max(turn / TURN_RATE).max(SHORTEST_LEG);
            times.push(times[k - 1] + seconds);
        }
        let ease = EASE.min(0.5 * times[times.len() - 1]);
        let tracks = [way, headings, pitches, fovs].map(|values| Track::new(&times, values));
        Some(Self { up, axes, points, lengths, times, tracks, ease, barred })
    }

    /// Views from which no free way to the next was found: there the tour goes straight.
    pub fn barred(&self) -> &[usize] {
        &self.barred
    }

    /// How long it takes, seconds.
    pub fn seconds(&self) -> f64 {
        self.times[self.times.len() - 1] + self.ease
    }

    /// Where the camera is after so many seconds; before the start and past the end it rests there.
    pub fn camera(&self, seconds: f64) -> Camera {
        let time = self.walked(seconds);
        let leg = self.times.partition_point(|&t| t <= time).clamp(1, self.times.len() - 1) - 1;
        let [way, heading, pitch, fov_y_deg] =
            [0, 1, 2, 3].map(|track| self.tracks[track].at(&self.times, leg, time));
        let ((sin, cos), (rise, level)) = (heading.sin_cos(), pitch.sin_cos());
        Camera {
            eye: self.place(way),
            forward: (self.axes[0] * cos + self.axes[1] * sin) * level + self.up * rise,
            up: self.up,
            fov_y_deg,
        }
    }

    /// How many frames the tour makes at `fps` frames a second: the first at its start and the last
    /// at its end.
    pub fn frames(&self, fps: f64) -> usize {
        (self.seconds() * fps).ceil().max(1.0) as usize + 1
    }

    /// When frame `index` of `frames` is taken, seconds.
    pub fn frame_time(&self, index: usize, frames: usize) -> f64 {
        self.seconds() * index as f64 / (frames.max(2) - 1) as f64
    }

    /// From the clock to the time of an even walk: slower at both ends.
    fn walked(&self, seconds: f64) -> f64 {
        let (total, ease) = (self.seconds(), self.ease);
        let t = if seconds.is_finite() { seconds.clamp(0.0, total) } else { 0.0 };
        if t < ease {
            t * t / (2.0 * ease)
        } else if t <= total - ease {
            t - 0.5 * ease
        } else {
            let left = total - t;
            total - ease - left * left / (2.0 * ease)
        }
    }

    /// The place so many metres along the way.
    fn place(&self, way: f64) -> DVec3 {
        let last = self.lengths.len() - 1;
        if last == 0 {
            return self.points[1];
        }
        let k = self.lengths.partition_point(|&l| l <= way).clamp(1, last) - 1;
        let step = self.lengths[k + 1] - self.lengths[k];
        let share = if step > 0.0 { ((way - self.lengths[k]) / step).clamp(0.0, 1.0) } else { 0.0 };
        let along = (k % SAMPLES) as f64 + share;
        catmull_rom(&self.points[k / SAMPLES..], along / SAMPLES as f64)
    }
}

impl Track {
    fn new(times: &[f64], values: Vec<f64>) -> Self {
        let steps: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
        let secants: Vec<f64> = values.windows(2).zip(&steps).map(|(v, h)| (v[1] - v[0]) / h).collect();
        let last = values.len() - 1;
        let slope = |k: usize| {
            if k == 0 || k == last {
                return secants[k.min(last - 1)];
            }
            let (before, after) = (secants[k - 1], secants[k]);
            if before * after <= 0.0 {
                return 0.0;
            }
            // The weighted harmonic mean lies between both, so nothing is passed.
            let (a, b) = (2.0 * steps[k] + steps[k - 1], steps[k] + 2.0 * steps[k - 1]);
            (a + b) / (a / before + b / after)
        };
        let slopes = (0..=last).map(slope).collect();
        Self { values, slopes }
    }

    /// The cubic (Hermite) over one leg.
    fn at(&self, times: &[f64], leg: usize, time: f64) -> f64 {
        let step = times[leg + 1] - times[leg];
        let u = ((time - times[leg]) / step).clamp(0.0, 1.0);
        let (v, m) = (&self.values, &self.slopes);
        let (rise, rest) = (u * u * (3.0 - 2.0 * u), 1.0 - u);
        v[leg] + (v[leg + 1] - v[leg]) * rise + step * u * rest * (m[leg] * rest - m[leg + 1] * u)
    }
}

/// The points that a tour passes.
struct Route {
    stops: Vec<View>,
    /// Those that differ.
    points: Vec<DVec3>,
    /// The point of each stop.
    place_of: Vec<usize>,
    barred: Vec<usize>,
}

impl Route {
    fn new(views: &[View], pace: f64, space: Option<&FreeSpace>) -> Self {
        let (mut points, mut place_of, mut barred): (Vec<DVec3>, _, _) = (Vec::new(), Vec::new(), Vec::new());
        let apart = 1e-6 * pace;
        for (index, view) in views.iter().enumerate() {
            if let (Some(&last), Some(space)) = (points.last(), space) {
                match space.way(last, view.eye) {
                    Some(between) => between.into_iter().for_each(|point| {
                        if points.last().is_some_and(|last| last.distance(point) > apart) {
                            points.push(point);
                        }
                    }),
                    None => barred.extend(index.checked_sub(1)),
                }
            }
            if points.last().is_none_or(|last| last.distance(view.eye) > apart) {
                points.push(view.eye);
            }
            place_of.push(points.len() - 1);
        }
        Self { stops: views.to_vec(), points, place_of, barred }
    }

    /// Sets points on the straight ways that the curve leaves for a collision.
    fn hold(&mut self, space: &FreeSpace) {
        for _ in 0..HOLD_ROUNDS {
            let mut ended = self.points.clone();
            add_ends(&mut ended);
            let collides = |leg: usize| {
                let place = |k: usize| catmull_rom(&ended[leg..], k as f64 / SAMPLES as f64);
                let steps = (0..SAMPLES).step_by(TRIED_EVERY);
                steps.into_iter().any(|k| !space.sees(place(k), place(k + TRIED_EVERY)))
            };
            let is_held = |leg: usize| space.sees(self.points[leg], self.points[leg + 1]) && collides(leg);
            let held: Vec<usize> = (0..self.points.len() - 1).filter(|&leg| is_held(leg)).collect();
            if held.is_empty() {
                return;
            }
            for &leg in held.iter().rev() {
                self.points.insert(leg + 1, 0.5 * (self.points[leg] + self.points[leg + 1]));
                self.place_of.iter_mut().filter(|place| **place > leg).for_each(|place| *place += 1);
            }
        }
    }
}

/// The stops, and between those whose way is bent views along it, as far apart as `spacing`, metres.
/// `place_of` tells the point of each and `points` has one beyond each end.
fn looking_ahead(
    stops: &[View],
    place_of: &mut Vec<usize>,
    points: &[DVec3],
    lengths: &[f64],
    spacing: f64,
    up: DVec3,
) -> Vec<View> {
    let mut stations = vec![stops[0].clone()];
    let mut places = vec![place_of[0]];
    for (ends, stop) in place_of.windows(2).zip(stops.windows(2)) {
        let way_to = |place: usize| lengths[place * SAMPLES];
        let [start, end] = [ends[0], ends[1]].map(way_to);
        let is_bent = end - start > BENT * stop[0].eye.distance(stop[1].eye);
        let mut last = start;
        for place in (ends[0] + 1..ends[1]).filter(|_| is_bent) {
            let here = way_to(place);
            let level = points[place + 2] - points[place];
            let ahead = level - up * level.dot(up);
            if here - last < spacing || end - here < spacing || ahead.length() < 1e-6 * spacing {
                continue;
            }
            last = here;
            let (eye, share) = (points[place + 1], (here - start) / (end - start));
            let fov_y_deg = stop[0].fov_y_deg + (stop[1].fov_y_deg - stop[0].fov_y_deg) * share;
            stations.push(View { name: String::new(), eye, target: eye + ahead, fov_y_deg });
            places.push(place);
        }
        stations.push(stop[1].clone());
        places.push(ends[1]);
    }
    *place_of = places;
    stations
}

/// Heading about `up`, unwrapped the short way round, and pitch of each view, radians.
fn directions(views: &[View], up: DVec3, axes: [DVec3; 2]) -> (Vec<f64>, Vec<f64>) {
    let (mut headings, mut pitches): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    for view in views {
        let ahead = (view.target - view.eye).normalize_or(axes[0]);
        let before = headings.last().copied();
        let level = [ahead.dot(axes[0]), ahead.dot(axes[1])];
        // Straight up or down there is no heading: the one before stays.
        let heading =
            if level[0].hypot(level[1]) < 1e-9 { before.unwrap_or(0.0) } else { level[1].atan2(level[0]) };
        headings.push(before.map_or(heading, |b| b + (heading - b + PI).rem_euclid(TAU) - PI));
        pitches.push(ahead.dot(up).clamp(-1.0, 1.0).asin().clamp(-MAX_PITCH, MAX_PITCH));
    }
    (headings, pitches)
}

/// Sets a point beyond each end.
fn add_ends(points: &mut Vec<DVec3>) {
    let count = points.len();
    let mirrored = |end: DVec3, next: DVec3| 2.0 * end - next;
    let (first, last) = (points[0], points[count - 1]);
    let (before, after) = match count {
        1 => (first, last),
        _ => (mirrored(first, points[1]), mirrored(last, points[count - 2])),
    };
    points.insert(0, before);
    points.push(after);
}

/// Sets a point beyond each end, and gives the way covered at each sample of the curve.
fn with_ends(points: &mut Vec<DVec3>) -> Vec<f64> {
    let (count, first) = (points.len(), points[0]);
    add_ends(points);
    let mut lengths = vec![0.0];
    let mut from = first;
    for leg in 0..count - 1 {
        for sample in 1..=SAMPLES {
            let to = catmull_rom(&points[leg..], sample as f64 / SAMPLES as f64);
            lengths.push(lengths[lengths.len() - 1] + from.distance(to));
            from = to;
        }
    }
    lengths
}

/// The centripetal Catmull-Rom curve between the second and the third of the points, which differ;
/// `share` runs from 0 to 1 between the two.
fn catmull_rom(points: &[DVec3], share: f64) -> DVec3 {
    let [a, b, c, d] = [points[0], points[1], points[2], points[3]];
    let step = |from: DVec3, to: DVec3| from.distance(to).sqrt();
    let t1 = step(a, b);
    let t2 = t1 + step(b, c);
    let t3 = t2 + step(c, d);
    let t = t1 + (t2 - t1) * share;
    let mix = |from: DVec3, to: DVec3, start: f64, end: f64| from.lerp(to, (t - start) / (end - start));
    let (ab, bc, cd) = (mix(a, b, 0.0, t1), mix(b, c, t1, t2), mix(c, d, t2, t3));
    mix(mix(ab, bc, 0.0, t2), mix(bc, cd, t1, t3), t1, t2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(eye: [f64; 3], target: [f64; 3], fov_y_deg: f64) -> View {
        View { name: String::new(), eye: eye.into(), target: target.into(), fov_y_deg }
    }

    fn views() -> Vec<View> {
        vec![
            view([0.0, 1.6, 0.0], [1.0, 1.6, 0.0], 60.0),
            view([6.0, 1.6, 1.0], [6.0, 1.4, 9.0], 70.0),
            // The same place, seen the other way.
            view([6.0, 1.6, 1.0], [5.9, 1.4, -9.0], 70.0),
            view([6.5, 1.6, 5.0], [-9.0, 1.0, 5.1], 50.0),
            view([-2.0, 4.0, 5.0], [-9.0, 1.0, 4.9], 50.0),
        ]
    }

    fn tour() -> Tour {
        Tour::through(&views(), DVec3::Y, WALK_SPEED).expect("five views")
    }

    #[test]
    fn every_bookmark_is_passed_and_looked_from() {
        let tour = tour();
        let cameras: Vec<Camera> =
            (0..=40_000).map(|k| tour.camera(tour.seconds() * f64::from(k) / 40_000.0)).collect();
        for view in views() {
            let ahead = (view.target - view.eye).normalize();
            let off = |c: &Camera| {
                c.eye.distance(view.eye) + c.forward.distance(ahead) + (c.fov_y_deg - view.fov_y_deg).abs()
            };
            let nearest = cameras.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.03, "{view:?} is missed by {nearest}");
        }
        let ends = [cameras[0], cameras[40_000]].map(|c| c.eye);
        assert!(ends[0].distance(views()[0].eye) < 1e-9 && ends[1].distance(views()[4].eye) < 1e-9);
    }

    #[test]
    fn the_pace_is_even_and_nothing_jumps() {
        let tour = tour();
        let dt = 1e-3;
        let count = (tour.seconds() / dt) as usize;
        let cameras: Vec<Camera> = (0..=count).map(|k| tour.camera(k as f64 * dt)).collect();
        let velocities: Vec<DVec3> = cameras.windows(2).map(|c| (c[1].eye - c[0].eye) / dt).collect();
        let turns: Vec<DVec3> = cameras.windows(2).map(|c| (c[1].forward - c[0].forward) / dt).collect();
        let fastest = velocities.iter().map(|v| v.length()).fold(0.0, f64::max);
        assert!(fastest < 1.4 * WALK_SPEED && fastest > 0.9 * WALK_SPEED, "{fastest} m/s");
        let turning = turns.iter().map(|v| v.length()).fold(0.0, f64::max);
        assert!(turning < 1.4 * TURN_RATE, "{turning} rad/s");
        // Velocities are continuous: in a thousandth of a second they change by little.
        for (what, speeds, most) in [("walking", &velocities, 0.03), ("turning", &turns, 0.02)] {
            let jump = speeds.windows(2).map(|v| v[0].distance(v[1])).fold(0.0, f64::max);
            assert!(jump < most, "{what} jumps by {jump} at once");
        }
        assert!(velocities[0].length() < 0.01 && velocities[count - 1].length() < 0.01, "soft ends");
        assert!(cameras.iter().all(|c| (c.forward.length() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn the_short_way_round_is_taken_without_swinging_past() {
        let views = [
            view([0.0; 3], [-1.0, 0.0, 0.1], 60.0),
            view([1.0, 0.0, 0.0], [0.0, 0.0, -0.1], 60.0),
            view([2.0, 0.0, 0.0], [1.0, 0.0, -0.1], 60.0),
        ];
        let tour = Tour::through(&views, DVec3::Y, 1.0).expect("three views");
        for k in 0..=1000 {
            let forward = tour.camera(tour.seconds() * f64::from(k) / 1000.0).forward;
            assert!(forward.x < -0.99, "{forward}");
            assert!(forward.z.abs() < 0.0996, "not past what a bookmark shows: {forward}");
        }
    }

    #[test]
    fn frames_run_from_the_first_moment_to_the_last() {
        let tour = tour();
        for fps in [1.0, 24.0, 29.97] {
            let frames = tour.frames(fps);
            assert!(((frames - 1) as f64 - tour.seconds() * fps).abs() <= 1.0, "{frames} at {fps}");
            assert_eq!(tour.frame_time(0, frames), 0.0);
            assert!((tour.frame_time(frames - 1, frames) - tour.seconds()).abs() < 1e-12);
        }
        assert_eq!(tour.camera(-1.0), tour.camera(0.0));
        assert_eq!(tour.camera(f64::NAN), tour.camera(0.0));
        assert_eq!(tour.camera(1e9), tour.camera(tour.seconds()));
    }

    #[test]
    fn what_is_no_tour_is_refused_and_a_turn_on_the_spot_is_one() {
        assert!(Tour::through(&views()[..1], DVec3::Y, 1.0).is_none());
        assert!(Tour::through(&views(), DVec3::Y, 0.0).is_none());
        let mut broken = views();
        broken[1].eye.x = f64::NAN;
        assert!(Tour::through(&broken, DVec3::Y, 1.0).is_none());
        let spot = Tour::through(&views()[1..3], DVec3::Y, 1.0).expect("two views");
        let half = spot.camera(0.5 * spot.seconds());
        assert_eq!(half.eye, views()[1].eye);
        assert!(half.forward.z.abs() < 0.2, "half-way round: {}", half.forward);
        let twice = Tour::through(&[views()[0].clone(), views()[0].clone()], DVec3::Y, 1.0);
        assert!(twice.expect("two views").seconds() < 1.0);
    }

    #[test]
    fn low_rooms_are_walked_as_if_by_someone_small() {
        assert!((walking_pace(2.6, 12.0) - WALK_SPEED).abs() < 1e-12);
        assert!((walking_pace(0.52, 1.0) - 0.2 * WALK_SPEED).abs() < 1e-12);
        assert!(walking_pace(30.0, 400.0) > 5.0);
    }
}
