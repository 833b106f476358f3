//! Where somebody looks: errors that they see count for more.

use super::elements::{Element, Elements};
use super::light::DirectLight;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Somebody who looks at a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Metres.
    pub eye: DVec3,
    /// Unit vector.
    pub forward: DVec3,
    /// Half of the angle that the picture spans, corner to corner: radians, above 0, below half of pi.
    pub half_angle: f64,
}

/// Corners of a triangle are looked at so far inside of it.
const INSET: f64 = 0.1;

impl Focus {
    /// What lies in a picture counts by its pixels for this part, and by its area for the rest.
    pub(super) const OF_PIXELS: f64 = 0.5;

    /// Which of the elements lie open to the eye, wholly or in part.
    pub(super) fn open(&self, elements: &Elements, light: &DirectLight) -> Vec<bool> {
        let is_open = |element: &Element| {
            let corners = elements.positions(element);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let inside = corners.map(|corner| corner.lerp(middle, INSET));
            self.solid_angle(elements, element) > 0.0
                && [middle].iter().chain(&inside).any(|&point| light.is_open(self.eye, point))
        };
        elements.elements.par_iter().map(is_open).collect()
    }

    /// Solid angle of an element that faces the eye, with its middle or a corner in the picture; steradians.
    fn solid_angle(&self, elements: &Elements, element: &Element) -> f64 {
        let corners = elements.positions(element);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let least = self.half_angle.cos();
        let is_in = |point: &DVec3| (*point - self.eye).normalize_or_zero().dot(self.forward) > least;
        if ![middle].iter().chain(&corners).any(is_in) {
            return 0.0;
        }
        let way = self.eye - middle;
        let area = elements.area(element);
        let normal = elements.corners[element.corners[0] as usize].normal;
        let cosine = normal.dot(way.normalize_or_zero());
        // What is as near as it is large fills half of all directions, about.
        cosine.max(0.0) * area / (way.length_squared() + area / TAU).max(f64::MIN_POSITIVE)
    }

    /// What the squared error of an element counts, over what it does by its share of all area.
    pub(super) fn weight(&self, elements: &Elements, element: &Element, whole: f64) -> f64 {
        let area = elements.area(element);
        if area <= 0.0 {
            return 1.0;
        }
        let picture = TAU * (1.0 - self.half_angle.cos());
        let of_pixels = self.solid_angle(elements, element) / picture;
        1.0 - Self::OF_PIXELS + Self::OF_PIXELS * of_pixels * whole / area
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct::ElementSettings;
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};
    use crate::watch::Watch;

    #[test]
    fn what_is_looked_at_gets_more_elements_and_nothing_behind_a_wall_or_the_eye_does() {
        let scene = load(&SceneSource::Builtin("cornell".to_owned())).expect("embedded");
        let settings = MeshSettings { target: PatchTarget::Count(600), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).expect("a mesh");
        let light = DirectLight::new(&mesh, true);
        let exitance = vec![1.0; light.emitters().bases.len()];
        let view = &scene.views[0];
        let eye = view.eye;
        let forward = (view.target - eye).normalize();
        let laid_out = |focus: Option<Focus>| {
            let settings = ElementSettings {
                error: 1e-9,
                most: 6_000,
                work: u64::MAX,
                exitance: exitance.clone(),
                smooth: true,
                focus,
                adapted: false,
            };
            Watch::nobody(|watch| Elements::build(&mesh, &light, &settings, watch)).expect("nobody ends it")
        };
        let ahead = Focus { eye, forward, half_angle: 0.12 };
        let behind = Focus { forward: -forward, ..ahead };
        let in_sight =
            |elements: &Elements| elements.leaves().filter(|e| ahead.solid_angle(elements, e) > 0.0).count();
        let (none, seen) = (laid_out(None), laid_out(Some(ahead)));
        assert_eq!(laid_out(Some(behind)).elements, none.elements, "errors count by area alone there");
        let (before, after) = (in_sight(&none), in_sight(&seen));
        assert!(after as f64 > 1.3 * before as f64, "{before} elements in sight, then {after}");
        // From below the floor nothing is open to the eye, so that all counts alike.
        let buried = Focus { eye: DVec3::new(eye.x, -50.0, eye.z), forward: DVec3::Y, half_angle: 0.12 };
        assert_eq!(laid_out(Some(buried)).elements, none.elements);
    }
}
