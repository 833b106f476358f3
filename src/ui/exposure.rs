//! Automatic exposure: what is in view decides, and the lamps half-way.
//!
//! An exposure that followed the lamps wholly would hide that one was switched off; one that did
//! not follow at all would leave a room with one lamp black. Eyes adapt in part, and so does this:
//! the exposure lies midway, in stops, between what the view needs as its lamps stand and what it
//! needs with the lamps as they come with the file.

use crate::display::{Exposure, luminance, meter};
use crate::solver::PatchLight;

/// Time constant with which the exposure follows the camera, seconds.
const EASE: f64 = 0.15;
/// Closer than this, in stops, the exposure has arrived.
const ARRIVED: f64 = 0.005;
/// Farthest that the lamps may pull the exposure from that of the file, stops.
const REACH: f64 = 8.0;

/// Luminances in cd/m² under a grid of rays over the view.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Metered {
    /// Of each state that is on screen: now, and A where it stands beside it.
    pub(super) shown: Vec<Vec<f64>>,
    /// With the lamps as they come with the file.
    pub(super) usual: Vec<f64>,
}

impl Metered {
    /// What is seen of one light alone.
    pub(super) fn of(light: &PatchLight, seen: &[u32]) -> Self {
        let seen = seen.iter().filter_map(|&patch| Some(luminance(*light.radiosity.get(patch as usize)?)));
        Self { shown: vec![seen.collect()], usual: Vec::new() }
    }
}

/// The automatic exposure and where it is heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AutoExposure {
    ev: f64,
    target: f64,
    fresh: bool,
}

impl Default for AutoExposure {
    fn default() -> Self {
        let ev = Exposure::default().ev100;
        Self { ev, target: ev, fresh: true }
    }
}

impl AutoExposure {
    /// Measures what a view needs. Two states side by side share one exposure, midway between what
    /// each needs, so that their brightness can be compared. With `at_once` the exposure jumps there,
    /// as it must when the light changed; otherwise it eases.
    pub(super) fn measure(&mut self, metered: &Metered, at_once: bool) {
        let needed = |values: &Vec<f64>| meter(values.iter().map(|&v| (v, 1.0))).map(|e| e.ev100);
        let shown: Vec<f64> = metered.shown.iter().filter_map(needed).collect();
        let now = (!shown.is_empty()).then(|| shown.iter().sum::<f64>() / shown.len() as f64);
        let target = match (now, needed(&metered.usual)) {
            (Some(now), Some(usual)) => usual + 0.5 * (now - usual).clamp(-REACH, REACH),
            (Some(ev), None) | (None, Some(ev)) => ev,
            (None, None) => return,
        };
        self.target = target;
        if at_once || self.fresh {
            self.ev = target;
            self.fresh = false;
        }
    }

    /// Moves on by `dt` seconds.
    pub(super) fn advance(&mut self, dt: f64) {
        self.ev += (self.target - self.ev) * (1.0 - (-dt / EASE).exp());
        if (self.target - self.ev).abs() < ARRIVED {
            self.ev = self.target;
        }
    }

    /// Whether it is still on its way.
    pub(super) fn is_moving(&self) -> bool {
        self.ev != self.target
    }

    /// EV at ISO 100.
    pub(super) fn ev(&self) -> f64 {
        self.ev
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Luminances of a view in which everything is this bright, now and usually.
    fn view(now: f64, usual: f64) -> Metered {
        Metered { shown: vec![vec![now; 4]], usual: vec![usual; 4] }
    }

    #[test]
    fn two_states_side_by_side_meet_midway() {
        let mut auto = AutoExposure::default();
        auto.measure(&view(8.0, 8.0), true);
        let before = auto.ev();
        let both = Metered { shown: vec![vec![8.0; 4], vec![2.0; 4]], usual: vec![8.0; 4] };
        auto.measure(&both, true);
        assert!((auto.ev() - (before - 0.5)).abs() < 1e-6, "a quarter of two stops: {}", auto.ev());
    }

    #[test]
    fn half_of_a_dimming_is_seen_and_at_once() {
        let mut auto = AutoExposure::default();
        auto.measure(&view(8.0, 8.0), false);
        let before = auto.ev();
        auto.measure(&view(2.0, 8.0), true);
        assert!((auto.ev() - (before - 1.0)).abs() < 1e-6, "two stops less light, one stop opened");
        auto.measure(&view(0.0, 8.0), true);
        assert!((auto.ev() - before).abs() < 1e-6, "in the dark the usual exposure stays");
    }

    #[test]
    fn a_new_view_is_followed_smoothly_and_to_the_end() {
        let mut auto = AutoExposure::default();
        auto.measure(&view(8.0, 8.0), false);
        let before = auto.ev();
        auto.measure(&view(16.0, 16.0), false);
        assert_eq!(auto.ev(), before);
        let mut frames = 0;
        while auto.is_moving() && frames < 500 {
            auto.advance(1.0 / 60.0);
            frames += 1;
        }
        assert!((auto.ev() - before - 1.0).abs() < 1e-6 && (10..200).contains(&frames), "{frames}");
    }
}
