//! Walking, flying and orbiting: from what the user asks for to where the camera stands.
//!
//! Pure arithmetic with the time step as an argument. Velocities follow the wish exponentially and
//! are integrated in closed form, so that the way covered does not depend on the frame rate.

use crate::navigation::{Body, Footing, Obstacles, walking_pace};
use crate::scene::View;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Time constant of speeding up and slowing down, seconds: 95 % within 100 ms.
const EASE_MOVE: f64 = 0.033;
/// Time constant of turning, seconds.
const EASE_TURN: f64 = 0.018;
/// Time constant of the eyes' height on steps, seconds.
const EASE_STEP: f64 = 0.06;
/// Duration of a flight to a bookmark, seconds.
const TRAVEL_SECS: f64 = 0.45;
/// Steepest look up or down, radians.
const MAX_PITCH: f64 = 1.55;
/// Running is this much faster.
const RUN_FACTOR: f64 = 2.8;

/// How the camera moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Motion {
    /// On the floor, at eye height, stopped by walls.
    #[default]
    Walk,
    /// Freely, through everything.
    Fly,
}

/// What the user asks for in this frame: each from -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wish {
    /// Ahead.
    pub(super) ahead: f64,
    /// To the right.
    pub(super) right: f64,
    /// Upwards; flying alone.
    pub(super) up: f64,
    /// Faster.
    pub(super) run: bool,
}

/// Where the camera stands and looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pose {
    /// Metres.
    pub(super) eye: DVec3,
    /// Heading about the up axis, radians, counter-clockwise from above.
    pub(super) yaw: f64,
    /// Above the horizon, radians.
    pub(super) pitch: f64,
    /// Vertical field of view, degrees.
    pub(super) fov_y_deg: f64,
}

#[derive(Clone, Copy, Debug)]
struct Travel {
    from: Pose,
    to: Pose,
    seconds: f64,
}

/// The camera and its motion.
#[derive(Clone, Debug)]
pub(super) struct CameraControl {
    up: DVec3,
    /// Level axes from which the yaw counts.
    axes: [DVec3; 2],
    pose: Pose,
    /// Where yaw and pitch are heading.
    turn_to: [f64; 2],
    velocity: DVec3,
    motion: Motion,
    body: Body,
    footing: Footing,
    /// Eyes above the feet at present, while they follow a step.
    eyes: f64,
    /// Metres per second of a walk, in this model.
    pace: f64,
    travel: Option<Travel>,
    /// At a bookmark nobody falls: the person takes to the floor with the first step.
    at_bookmark: bool,
    /// Take to the floor without waiting for a step.
    land: bool,
    settled: bool,
}

impl CameraControl {
    /// A camera at `view`. `height` and `size` are the height and diagonal of the model, metres.
    pub(super) fn new(
        view: &View,
        up: DVec3,
        height: f64,
        size: f64,
        motion: Motion,
        eye_height: f64,
    ) -> Self {
        let body = Body::for_room(height, eye_height);
        let right = up.any_orthonormal_vector();
        let mut control = Self {
            up,
            axes: [right, up.cross(right)],
            pose: Pose { eye: view.eye, yaw: 0.0, pitch: 0.0, fov_y_deg: view.fov_y_deg },
            turn_to: [0.0; 2],
            velocity: DVec3::ZERO,
            motion,
            body,
            footing: Footing { feet: view.eye, fall_speed: 0.0, grounded: false },
            eyes: body.eye_height,
            pace: walking_pace(height, size),
            travel: None,
            at_bookmark: true,
            land: false,
            settled: false,
        };
        control.stand_at(control.pose_of(view));
        control
    }

    /// The pose from which a bookmark looks.
    pub(super) fn pose_of(&self, view: &View) -> Pose {
        let ahead = (view.target - view.eye).normalize_or(self.axes[0]);
        Pose {
            eye: view.eye,
            yaw: ahead.dot(self.axes[1]).atan2(ahead.dot(self.axes[0])),
            pitch: ahead.dot(self.up).clamp(-1.0, 1.0).asin().clamp(-MAX_PITCH, MAX_PITCH),
            fov_y_deg: view.fov_y_deg.clamp(5.0, 150.0),
        }
    }

    /// Goes there at once.
    pub(super) fn stand_at(&mut self, pose: Pose) {
        self.pose = pose;
        self.turn_to = [pose.yaw, pose.pitch];
        self.velocity = DVec3::ZERO;
        self.eyes = self.body.eye_height;
        let feet = pose.eye - self.up * self.eyes;
        self.footing = Footing { feet, fall_speed: 0.0, grounded: false };
        self.travel = None;
        (self.at_bookmark, self.land) = (true, false);
        self.settled = false;
    }

    /// Puts the feet onto the floor below the eye; the eyes then sink or rise to their height.
    fn step_down(&mut self, obstacles: &Obstacles) {
        (self.at_bookmark, self.land) = (false, false);
        if let Some(ground) = obstacles.floor_below(self.pose.eye) {
            self.eyes = self.pose.eye.dot(self.up) - ground;
            let feet = self.pose.eye - self.up * self.eyes;
            self.footing = Footing { feet, fall_speed: 0.0, grounded: true };
        } else {
            // Over nothing one walks on at this height.
            self.eyes = self.body.eye_height;
            let feet = self.pose.eye - self.up * self.eyes;
            self.footing = Footing { feet, fall_speed: 0.0, grounded: false };
        }
    }

    /// Glides there.
    pub(super) fn travel_to(&mut self, pose: Pose) {
        // The shorter way round.
        let turn = (pose.yaw - self.pose.yaw + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
            - std::f64::consts::PI;
        let to = Pose { yaw: self.pose.yaw + turn, ..pose };
        self.travel = Some(Travel { from: self.pose, to, seconds: 0.0 });
        self.velocity = DVec3::ZERO;
        self.settled = false;
    }

    /// Whether it glides to a bookmark.
    pub(super) fn is_travelling(&self) -> bool {
        self.travel.is_some()
    }

    /// Where the camera stands.
    pub(super) fn pose(&self) -> Pose {
        self.pose
    }

    /// The upwards unit vector.
    pub(super) fn up(&self) -> DVec3 {
        self.up
    }

    /// The unit vector ahead.
    pub(super) fn forward(&self) -> DVec3 {
        let (sin, cos) = self.pose.pitch.sin_cos();
        self.level_ahead() * cos + self.up * sin
    }

    fn level_ahead(&self) -> DVec3 {
        let (sin, cos) = self.pose.yaw.sin_cos();
        self.axes[0] * cos + self.axes[1] * sin
    }

    fn right(&self) -> DVec3 {
        self.level_ahead().cross(self.up)
    }

    /// How the camera moves.
    pub(super) fn motion(&self) -> Motion {
        self.motion
    }

    /// Changes how the camera moves; the person lands on the floor below the eye.
    pub(super) fn set_motion(&mut self, motion: Motion) {
        if motion != self.motion {
            self.motion = motion;
            self.velocity = DVec3::ZERO;
            self.at_bookmark = motion == Motion::Walk;
            self.settled = false;
        }
    }

    /// Takes to the floor without waiting for a step, as whoever asks for walking expects.
    pub(super) fn land(&mut self) {
        self.land = self.motion == Motion::Walk;
        self.settled = false;
    }

    /// Sets the height of the eyes above the floor for an adult, metres.
    pub(super) fn set_eye_height(&mut self, metres: f64) {
        let eye_height = metres.clamp(0.5, 3.0) * self.body.scale();
        if eye_height != self.body.eye_height {
            self.land = true;
            self.body.eye_height = eye_height;
            self.settled = false;
        }
    }

    /// Sets the vertical field of view, degrees.
    pub(super) fn set_fov(&mut self, degrees: f64) {
        self.pose.fov_y_deg = degrees.clamp(20.0, 110.0);
        self.settled = false;
    }

    /// Turns by radians to the right and upwards.
    pub(super) fn look(&mut self, right: f64, up: f64) {
        self.travel = None;
        self.turn_to[0] -= right;
        self.turn_to[1] = (self.turn_to[1] + up).clamp(-MAX_PITCH, MAX_PITCH);
        self.settled = false;
    }

    /// Turns about `pivot` by radians; the camera keeps its distance and leaves the floor.
    pub(super) fn orbit(&mut self, pivot: DVec3, right: f64, up: f64) {
        self.travel = None;
        self.set_motion(Motion::Fly);
        let pitch = (self.pose.pitch + up).clamp(-MAX_PITCH, MAX_PITCH);
        let tilt = DQuat::from_axis_angle(self.right(), pitch - self.pose.pitch);
        let turn = DQuat::from_axis_angle(self.up, -right);
        self.pose.eye = pivot + turn * (tilt * (self.pose.eye - pivot));
        self.pose.yaw -= right;
        self.pose.pitch = pitch;
        self.turn_to = [self.pose.yaw, pitch];
        self.settled = false;
    }

    /// Moves sideways and upwards in the picture's plane by metres; the camera leaves the floor.
    pub(super) fn pan(&mut self, right: f64, up: f64) {
        self.travel = None;
        self.set_motion(Motion::Fly);
        let upwards = self.right().cross(self.forward());
        self.pose.eye += self.right() * right + upwards * up;
        self.settled = false;
    }

    /// Gives a push ahead, as of a wheel: `strokes` of about half a pace each.
    pub(super) fn nudge(&mut self, strokes: f64, obstacles: Option<&Obstacles>) {
        self.travel = None;
        let ahead = if self.motion == Motion::Walk { self.level_ahead() } else { self.forward() };
        self.displace(ahead * (0.35 * self.pace * strokes), obstacles, 0.0);
        self.settled = false;
    }

    /// Whether the camera still moves by itself.
    pub(super) fn is_moving(&self) -> bool {
        !self.settled
    }

    /// Moves on by `dt` seconds. Returns whether anything moved.
    pub(super) fn advance(&mut self, wish: &Wish, obstacles: Option<&Obstacles>, dt: f64) -> bool {
        let dt = if dt.is_finite() { dt.clamp(0.0, 0.25) } else { 0.0 };
        let before = self.pose;
        let wants = wish.ahead != 0.0 || wish.right != 0.0 || wish.up != 0.0;
        if wants {
            self.travel = None;
        }
        if let Some(mut travel) = self.travel.take() {
            travel.seconds += dt;
            self.glide(travel);
            return true;
        }
        let share = 1.0 - (-dt / EASE_TURN).exp();
        self.pose.yaw += (self.turn_to[0] - self.pose.yaw) * share;
        self.pose.pitch += (self.turn_to[1] - self.pose.pitch) * share;

        let target = self.wished_velocity(wish);
        // Integral of v(t) = target + (v0 - target) exp(-t / tau) over the step.
        let fade = (-dt / EASE_MOVE).exp();
        let way = target * dt + (self.velocity - target) * (EASE_MOVE * (1.0 - fade));
        self.velocity = target + (self.velocity - target) * fade;
        self.displace(way, obstacles, dt);

        let turning =
            (self.turn_to[0] - self.pose.yaw).abs() + (self.turn_to[1] - self.pose.pitch).abs() > 1e-4;
        if !turning {
            [self.pose.yaw, self.pose.pitch] = self.turn_to;
        }
        if !wants && self.velocity.length() < 1e-3 * self.pace {
            self.velocity = DVec3::ZERO;
        }
        let moved = before != self.pose;
        self.settled = !moved && !turning && !wants && self.velocity == DVec3::ZERO;
        moved
    }

    fn wished_velocity(&self, wish: &Wish) -> DVec3 {
        let walking = self.motion == Motion::Walk;
        let ahead = if walking { self.level_ahead() } else { self.forward() };
        let up = if walking { 0.0 } else { wish.up };
        let direction = ahead * wish.ahead + self.right() * wish.right + self.up * up;
        let speed = self.pace * if wish.run { RUN_FACTOR } else { 1.0 };
        direction.clamp_length_max(1.0) * speed
    }

    fn displace(&mut self, way: DVec3, obstacles: Option<&Obstacles>, dt: f64) {
        let Some(world) = obstacles.filter(|_| self.motion == Motion::Walk) else {
            self.pose.eye += way;
            return;
        };
        if self.at_bookmark {
            if way == DVec3::ZERO && !self.land {
                return;
            }
            self.step_down(world);
        }
        let before = self.footing;
        self.footing = world.walk(&self.body, before, way, dt);
        let rise = (self.footing.feet - before.feet).dot(self.up);
        if before.grounded && self.footing.grounded {
            // The eyes stay where they were and follow the step.
            self.eyes -= rise;
        }
        self.eyes += (self.body.eye_height - self.eyes) * (1.0 - (-dt / EASE_STEP).exp());
        if (self.eyes - self.body.eye_height).abs() < 1e-4 * self.body.eye_height {
            self.eyes = self.body.eye_height;
        }
        self.pose.eye = self.footing.feet + self.up * self.eyes;
    }

    fn glide(&mut self, travel: Travel) {
        let t = (travel.seconds / TRAVEL_SECS).min(1.0);
        if t >= 1.0 {
            self.stand_at(travel.to);
            return;
        }
        let s = t * t * (3.0 - 2.0 * t);
        let mix = |a: f64, b: f64| a + (b - a) * s;
        self.pose = Pose {
            eye: travel.from.eye.lerp(travel.to.eye, s),
            yaw: mix(travel.from.yaw, travel.to.yaw),
            pitch: mix(travel.from.pitch, travel.to.pitch),
            fov_y_deg: mix(travel.from.fov_y_deg, travel.to.fov_y_deg),
        };
        self.turn_to = [self.pose.yaw, self.pose.pitch];
        self.travel = Some(travel);
        self.settled = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::navigation::WALK_SPEED;

    fn view() -> View {
        View {
            name: "v".into(),
            eye: DVec3::new(0.0, 1.6, 0.0),
            target: DVec3::new(0.0, 1.6, -1.0),
            fov_y_deg: 60.0,
        }
    }

    fn camera(motion: Motion) -> CameraControl {
        CameraControl::new(&view(), DVec3::Y, 2.6, 10.0, motion, 1.6)
    }

    fn after(frames: usize, seconds: f64, wish: Wish) -> Pose {
        let mut control = camera(Motion::Fly);
        for _ in 0..frames {
            control.advance(&wish, None, seconds / frames as f64);
        }
        control.pose()
    }

    #[test]
    fn a_bookmark_is_looked_from_exactly() {
        let control = camera(Motion::Fly);
        assert!((control.forward() - DVec3::NEG_Z).length() < 1e-12, "{}", control.forward());
        assert_eq!(control.pose().eye, view().eye);
        let down = View { target: DVec3::new(1.0, 0.6, 0.0), ..view() };
        let pose = control.pose_of(&down);
        assert!((pose.pitch + std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    }

    #[test]
    fn the_way_does_not_depend_on_the_frame_rate() {
        let wish = Wish { ahead: 1.0, right: 0.5, ..Wish::default() };
        let (slow, fast) = (after(10, 1.0, wish), after(240, 1.0, wish));
        assert!((slow.eye - fast.eye).length() < 1e-9, "{} against {}", slow.eye, fast.eye);
        // One second at the pace, less the time constant of getting going.
        let way = (fast.eye - view().eye).length();
        assert!((way - WALK_SPEED * (1.0 - EASE_MOVE)).abs() < 1e-6, "{way}");
    }

    #[test]
    fn speeds_settle_within_a_tenth_of_a_second() {
        let mut control = camera(Motion::Fly);
        let wish = Wish { ahead: 1.0, ..Wish::default() };
        control.advance(&wish, None, 0.1);
        assert!(control.velocity.length() > 0.95 * WALK_SPEED);
        for _ in 0..60 {
            control.advance(&Wish::default(), None, 1.0 / 60.0);
        }
        assert!(!control.is_moving(), "at rest nothing is drawn again");
        assert!(!control.advance(&Wish::default(), None, 1.0 / 60.0));
    }

    #[test]
    fn keys_move_where_they_say() {
        let right = after(60, 0.5, Wish { right: 1.0, ..Wish::default() });
        assert!(right.eye.x > 0.5 && right.eye.z.abs() < 1e-12);
        let up = after(60, 0.5, Wish { up: 1.0, ..Wish::default() });
        assert!(up.eye.y > 2.0);
        let run = after(60, 0.5, Wish { ahead: 1.0, run: true, ..Wish::default() });
        let walk = after(60, 0.5, Wish { ahead: 1.0, ..Wish::default() });
        assert!((run.eye.z / walk.eye.z - RUN_FACTOR).abs() < 1e-9);
        let mut turned = camera(Motion::Fly);
        turned.look(std::f64::consts::FRAC_PI_2, 0.0);
        for _ in 0..60 {
            turned.advance(&Wish::default(), None, 1.0 / 60.0);
        }
        assert!((turned.forward() - DVec3::X).length() < 1e-3, "right is right: {}", turned.forward());
    }

    #[test]
    fn orbiting_keeps_distance_and_aim() {
        let mut control = camera(Motion::Fly);
        let pivot = DVec3::new(0.0, 1.6, -3.0);
        control.orbit(pivot, 0.7, -0.3);
        let to_pivot = pivot - control.pose().eye;
        assert!((to_pivot.length() - 3.0).abs() < 1e-12);
        assert!((to_pivot.normalize() - control.forward()).length() < 1e-9);
    }

    #[test]
    fn walking_lands_at_eye_height_and_stops_at_a_wall() {
        let corners =
            [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]].map(DVec3::from);
        let wall =
            [[-9.0, 0.0, -2.0], [9.0, 0.0, -2.0], [9.0, 3.0, -2.0], [-9.0, 3.0, -2.0]].map(DVec3::from);
        let triangles =
            [corners, wall].iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        let world = Obstacles::new(triangles, DVec3::Y);
        let high = View { eye: DVec3::new(0.0, 2.3, 0.0), target: DVec3::new(0.0, 2.3, -1.0), ..view() };
        let mut control = CameraControl::new(&high, DVec3::Y, 2.6, 10.0, Motion::Walk, 1.6);
        let wish = Wish { ahead: 1.0, ..Wish::default() };
        for _ in 0..300 {
            control.advance(&wish, Some(&world), 1.0 / 60.0);
        }
        assert_eq!(
            CameraControl::new(&high, DVec3::Y, 2.6, 10.0, Motion::Walk, 1.6).pose().eye.y,
            2.3,
            "a bookmark is kept"
        );
        let eye = control.pose().eye;
        assert!((eye.y - 1.6).abs() < 1e-3, "{eye}");
        assert!((eye.z - (-2.0 + control.body.radius)).abs() < 1e-6, "{eye}");
    }

    #[test]
    fn who_asks_for_walking_lands_at_once_and_over_nothing_goes_on_from_there() {
        let floor = [[-9.0, 0.0, -9.0], [-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0]].map(DVec3::from);
        let triangles = vec![[floor[0], floor[1], floor[2]], [floor[0], floor[2], floor[3]]];
        let world = Obstacles::new(triangles, DVec3::Y);
        let mut control = camera(Motion::Fly);
        control.pan(0.0, 3.0);
        control.set_motion(Motion::Walk);
        control.land();
        for _ in 0..60 {
            control.advance(&Wish::default(), Some(&world), 1.0 / 60.0);
        }
        assert!((control.pose().eye.y - 1.6).abs() < 1e-3, "{}", control.pose().eye);
        // Beside the floor there is nothing to stand on: the first step starts where the camera is.
        control.pan(20.0, 0.0);
        let before = control.pose().eye;
        control.set_motion(Motion::Walk);
        control.advance(&Wish { ahead: 1.0, ..Wish::default() }, Some(&world), 1.0 / 60.0);
        assert!(control.pose().eye.distance(before) < 0.1, "{} from {before}", control.pose().eye);
    }

    #[test]
    fn a_journey_ends_at_the_bookmark_the_short_way_round() {
        let mut control = camera(Motion::Fly);
        let to = View { eye: DVec3::new(3.0, 1.0, 2.0), target: DVec3::new(2.0, 1.0, 2.1), ..view() };
        let pose = control.pose_of(&to);
        control.travel_to(pose);
        for _ in 0..60 {
            control.advance(&Wish::default(), None, 1.0 / 60.0);
        }
        assert!((control.pose().eye - to.eye).length() < 1e-12);
        assert!((control.forward() - (to.target - to.eye).normalize()).length() < 1e-9);
    }
}
