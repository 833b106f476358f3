use super::shown;
use crate::accuracy::{Answer, PointIrradiance, irradiance_at};
use crate::display::DisplayMesh;
use crate::effects::Effect;
use crate::scene::{Lighting, luminance_weighted};
use crate::solve::Solution;
use crate::solver::{PatchLight, patch_emission};
use glam::DVec3;

/// Irradiance at free points (metres, unit normals) under this lighting, each with its estimated error;
/// `light` is that of the patches under it.
///
/// Twice as slow as the points' rows alone or more: independent rays check each. A scene without lamps has no
/// form factors, and is dark everywhere.
pub fn points(
    solved: &Solution,
    lighting: &Lighting,
    light: &PatchLight,
    places: &[(DVec3, DVec3)],
) -> Vec<PointIrradiance> {
    let Some(transport) = solved.transport.as_deref() else {
        return vec![PointIrradiance::default(); places.len()];
    };
    let elements = solved.element_light.as_ref().map(|light| &light.elements);
    let smooth = solved.plan.is_on(Effect::SmoothSurfaces);
    let display = DisplayMesh::build_on(&solved.mesh, &solved.scene, smooth, elements);
    let shown = shown(&solved.mesh, &display, light);
    let exitance: Vec<[f32; 3]> = solved.mesh.patches.iter().map(|p| patch_emission(p, lighting)).collect();
    let answer = Answer {
        mesh: &solved.mesh,
        transport,
        light,
        exitance: &exitance,
        lighting,
        reflectance: &solved.reflectance,
        shown: &shown,
        // The points are those of facets, and so is what they are compared with.
        smooth: false,
        direct: None,
    };
    let direct = solved.direct_at(places, light);
    irradiance_at(answer, &solved.computer, places, direct.as_deref(), 1)
}

/// The errors of a list of points, in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointErrors {
    /// How many points there are; one or more.
    pub points: usize,
    /// Median of the estimated errors, each over the irradiance at its point (a tenth of the mean over
    /// all points at least): 0.01 is 1 %.
    pub median: f64,
    /// The root of their mean square.
    pub rms: f64,
    /// The largest of them.
    pub largest: f64,
    /// Where it is: an index into the list.
    pub worst: usize,
}

impl PointErrors {
    /// `None` without points, or where no light comes to any.
    pub fn of(points: &[PointIrradiance]) -> Option<Self> {
        const DARKEST: f64 = 0.1;
        let light = |p: &PointIrradiance| luminance_weighted(p.irradiance);
        let mean = points.iter().map(light).sum::<f64>() / points.len() as f64;
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        let relative: Vec<f64> = points.iter().map(|p| p.error / light(p).max(DARKEST * mean)).collect();
        let (worst, &largest) = relative.iter().enumerate().rev().max_by(|a, b| a.1.total_cmp(b.1))?;
        let mut sorted = relative.clone();
        sorted.sort_by(f64::total_cmp);
        let median = 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]);
        let squares: f64 = relative.iter().map(|e| e * e).sum();
        let rms = (squares / relative.len() as f64).sqrt();
        Some(Self { points: points.len(), median, rms, largest, worst })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(irradiance: f64, error: f64) -> PointIrradiance {
        PointIrradiance { irradiance: [irradiance; 3], error }
    }

    #[test]
    fn errors_are_told_relative_to_the_light_at_each_point_and_not_to_darkness() {
        let found = PointErrors::of(&[point(10.0, 0.1), point(10.0, 0.3), point(0.0, 0.001)]).unwrap();
        assert_eq!((found.points, found.worst), (3, 1));
        assert!((found.median - 0.01).abs() < 1e-12 && (found.largest - 0.03).abs() < 1e-12, "{found:?}");
        assert!((found.rms - (1.002_25e-3_f64 / 3.0).sqrt()).abs() < 1e-9, "{found:?}");
        assert_eq!(PointErrors::of(&[]), None);
        assert_eq!(PointErrors::of(&[point(0.0, 0.0)]), None);
    }
}
