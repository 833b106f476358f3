//! Automatic exposure: what is in view decides, and the lamps half-way.
//!
//! An exposure that followed the lamps wholly would hide that one was switched off; one that did
//! not follow at all would leave a room with one lamp black. Eyes adapt in part, and so does this:
//! the exposure lies midway, in stops, between what the view needs as its lamps stand and what it
//! needs with the lamps as they come with the file.

use crate::display::{Exposure, luminance, meter};
use crate::mesh::PatchMesh;
use crate::solver::PatchLight;

/// Time constant with which the exposure follows the camera, seconds.
const EASE: f64 = 0.15;
/// Closer than this, in stops, the exposure has arrived.
const ARRIVED: f64 = 0.005;
/// Farthest that the lamps may pull the exposure from that of the file, stops.
const REACH: f64 = 8.0;

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
    /// Measures what `seen` (patches under a grid of rays) needs. With `at_once` the exposure
    /// jumps there, as it must when the light changed; otherwise it eases.
    pub(super) fn measure(
        &mut self,
        mesh: &PatchMesh,
        seen: &[u32],
        now: &PatchLight,
        reference: &PatchLight,
        at_once: bool,
    ) {
        let metered = |light: &PatchLight| {
            let samples = seen.iter().filter_map(|&p| {
                let shines = mesh.patches.get(p as usize)?.luminaire.is_some();
                (!shines).then(|| Some((luminance(*light.radiosity.get(p as usize)?), 1.0)))?
            });
            meter(samples).map(|exposure| exposure.ev100)
        };
        let target = match (metered(now), metered(reference)) {
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
    use crate::mesh::{Patch, Side};
    use glam::DVec3;

    fn mesh(patches: usize) -> PatchMesh {
        let patch = Patch {
            region: 0,
            side: Side::Front,
            surface: 0,
            material: 0,
            luminaire: None,
            pieces: 0..0,
            centre: DVec3::ZERO,
            normal: DVec3::Y,
            area: 1.0,
            reflectance: [0.5; 3],
            emission_weight: [0.0; 3],
            radius: 1.0,
        };
        PatchMesh { patches: vec![patch; patches], ..PatchMesh::default() }
    }

    fn light(radiosity: f32) -> PatchLight {
        PatchLight { irradiance: vec![[radiosity; 3]; 4], radiosity: vec![[radiosity; 3]; 4] }
    }

    #[test]
    fn half_of_a_dimming_is_seen_and_at_once() {
        let (mesh, seen) = (mesh(4), [0, 1, 2, 3]);
        let mut auto = AutoExposure::default();
        auto.measure(&mesh, &seen, &light(8.0), &light(8.0), false);
        let before = auto.ev();
        auto.measure(&mesh, &seen, &light(2.0), &light(8.0), true);
        assert!((auto.ev() - (before - 1.0)).abs() < 1e-6, "two stops less light, one stop opened");
        auto.measure(&mesh, &seen, &light(0.0), &light(8.0), true);
        assert!((auto.ev() - before).abs() < 1e-6, "in the dark the usual exposure stays");
    }

    #[test]
    fn a_new_view_is_followed_smoothly_and_to_the_end() {
        let (mesh, seen) = (mesh(4), [0, 1, 2, 3]);
        let mut auto = AutoExposure::default();
        auto.measure(&mesh, &seen, &light(8.0), &light(8.0), false);
        let before = auto.ev();
        auto.measure(&mesh, &seen, &light(16.0), &light(16.0), false);
        assert_eq!(auto.ev(), before);
        let mut frames = 0;
        while auto.is_moving() && frames < 500 {
            auto.advance(1.0 / 60.0);
            frames += 1;
        }
        assert!((auto.ev() - before - 1.0).abs() < 1e-6 && (10..200).contains(&frames), "{frames}");
    }
}
