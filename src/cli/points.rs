//! Irradiance at the points of a file, and how wrong it is.

use super::text;
use crate::export::{ExportError, PointResult, PointsReport, SurfacePoint, write_irradiance};
use crate::scene::{LUMINOUS_EFFICACY, Lighting, Scene, illuminance};
use crate::solve::{Overcast, Solution, daylight_factor};
use crate::solver::PatchLight;
use crate::study::{self, PointErrors};
use glam::DVec3;
use std::path::Path;

/// Irradiance at all points of a file.
pub(super) struct Gathered {
    pub(super) results: Vec<PointResult>,
    /// `None` where no light comes to any of them.
    errors: Option<PointErrors>,
}

/// Gathers at points in the coordinates of the scene's file; daylight factors too, with the scene under an overcast sky.
pub(super) fn gather(
    points: &[SurfacePoint],
    solved: &Solution,
    lighting: &Lighting,
    light: &PatchLight,
    overcast: Option<&Overcast>,
) -> Gathered {
    let places = places(points, |place| solved.scene.in_scene(place));
    let found = study::points(solved, lighting, light, &places);
    let factors = overcast.map(|overcast| {
        let Overcast { solution, lighting, .. } = overcast;
        let found = study::points(solution, lighting, &solution.light(lighting), &places);
        found.iter().map(|p| [p.irradiance, [p.error; 3]].map(daylight_factor)).collect::<Vec<_>>()
    });
    let results = found
        .iter()
        .enumerate()
        .map(|(k, p)| PointResult {
            irradiance: p.irradiance,
            lux_error: LUMINOUS_EFFICACY * p.error,
            daylight_factor: factors.as_ref().map(|factors| factors[k]),
        })
        .collect();
    Gathered { results, errors: PointErrors::of(&found) }
}

/// Which sky daylight factors are told under, in a line; nothing where the scene has none.
pub(super) fn sky_told(scene: &Scene, overcast: Option<&Overcast>) -> String {
    let how = match overcast {
        None if scene.outdoors.is_none() => return String::new(),
        None => "unknown, since the solve ended before its form factors were complete",
        Some(overcast) if overcast.is_other_sky => {
            "under the traditional overcast sky of the CIE (type 16) instead of the scene's own; lamps and sun off"
        }
        Some(_) => "under the overcast sky of the scene (CIE type 16), lamps off",
    };
    format!("daylight factors: {how}\n")
}

/// Positions, brought to those of the scene by `in_scene`, with their normals.
pub(super) fn places(points: &[SurfacePoint], in_scene: impl Fn(DVec3) -> DVec3) -> Vec<(DVec3, DVec3)> {
    points.iter().map(|point| (in_scene(point.position), point.normal)).collect()
}

impl Gathered {
    /// Writes them beside their points, which stay in the unit of the file.
    ///
    /// # Errors
    /// A refusal of the system.
    pub(super) fn write(&self, path: &Path, points: &[SurfacePoint]) -> Result<(), ExportError> {
        write_irradiance(path, None, points, &self.results, illuminance)
    }

    /// How wrong they are, in a line.
    pub(super) fn told(&self) -> String {
        let count = text::count(self.results.len(), "point");
        let percent = |share: f64| format!("{} %", text::significant(100.0 * share));
        match &self.errors {
            None => format!("illuminance at {count}: no light comes there\n"),
            Some(errors) if errors.points == 1 => {
                format!("illuminance at {count}: estimated error {}\n", percent(errors.median))
            }
            Some(errors) => format!(
                "illuminance at {count}: estimated error median {}, largest {} (point {})\n",
                percent(errors.median),
                percent(errors.largest),
                errors.worst + 1
            ),
        }
    }

    /// The same for the report.
    pub(super) fn report(&self) -> PointsReport {
        PointsReport {
            count: self.results.len(),
            median_error_percent: self.errors.map(|e| 100.0 * e.median),
            largest_error_percent: self.errors.map(|e| 100.0 * e.largest),
            worst_point: self.errors.map(|e| e.worst + 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_gathered_in_metres() {
        let points = [SurfacePoint { position: DVec3::new(1000.0, 0.0, 500.0), normal: DVec3::Z }];
        let [(place, normal)] = places(&points, |place| place * 0.001)[..] else { panic!("one place") };
        assert!((place - DVec3::new(1.0, 0.0, 0.5)).length() < 1e-12 && normal == DVec3::Z);
    }

    #[test]
    fn the_worst_point_is_named_as_its_line_counts() {
        let errors = PointErrors { points: 12, median: 0.003, rms: 0.005, largest: 0.011, worst: 6 };
        let result = PointResult { irradiance: [1.0; 3], lux_error: 0.5, daylight_factor: None };
        let gathered = Gathered { results: vec![result; 12], errors: Some(errors) };
        let told = "illuminance at 12 points: estimated error median 0.300 %, largest 1.10 % (point 7)\n";
        assert_eq!(gathered.told(), told);
        assert_eq!(gathered.report().worst_point, Some(7));
        let dark = Gathered { results: vec![result], errors: None };
        assert_eq!(dark.told(), "illuminance at 1 point: no light comes there\n");
    }
}
