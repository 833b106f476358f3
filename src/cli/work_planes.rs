//! Illuminance and daylight factor over the work planes of rooms.

use super::failure::Failure;
use super::points;
use super::text;
use crate::export::{ExportError, GridReport, PointResult, SurfacePoint, WorkPlaneReport, write_irradiance};
use crate::outputs::LitPlane;
use crate::scene::{Lighting, Scene, USUAL_WORK_PLANE, WorkPlane, illuminance, work_planes};
use crate::solve::{Overcast, Solution};
use crate::solver::PatchLight;
use std::path::Path;

/// The grids of a scene, in the unit of its file.
pub(super) struct Grids {
    planes: Vec<WorkPlane>,
    pub(super) points: Vec<SurfacePoint>,
}

impl Grids {
    /// Grids at this height above the floor of each room, in the unit of the scene's file, or at the usual one.
    ///
    /// # Errors
    /// There is no room.
    pub(super) fn new(scene: &Scene, height: Option<f64>) -> Result<Self, Failure> {
        Self::in_rooms(scene, height).ok_or_else(|| {
            Failure::input(format!(
                "no room was found in {} with space {:.2} m above its floor for a work plane; a room has a floor, \
                 a ceiling and walls",
                scene.name,
                metres(scene, height)
            ))
        })
    }

    /// The same; `None` where there is no room.
    pub(super) fn in_rooms(scene: &Scene, height: Option<f64>) -> Option<Self> {
        let planes = work_planes(scene, metres(scene, height));
        if planes.is_empty() {
            return None;
        }
        let normal = scene.up.vector();
        let place = |&place| SurfacePoint { position: scene.in_file(place), normal };
        let points = planes.iter().flat_map(|plane| &plane.points).map(place).collect();
        Some(Self { planes, points })
    }

    /// What arrives at all points.
    pub(super) fn gather(
        self,
        solved: &Solution,
        lighting: &Lighting,
        light: &PatchLight,
        overcast: Option<&Overcast>,
    ) -> LitGrids {
        let found = points::gather(&self.points, solved, lighting, light, overcast).results;
        let lux_of = |result: &PointResult| illuminance(result.irradiance);
        let factor_of = |result: &PointResult| result.daylight_factor.map(|[factor, _]| factor);
        let brightest = |results: &[PointResult]| {
            let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
            [most(&mut results.iter().map(lux_of)), most(&mut results.iter().filter_map(factor_of))]
        };
        let overall = brightest(&found);
        let mut lit = LitGrids { points: Vec::new(), results: Vec::new(), reports: Vec::new(), dark: 0 };
        let mut first = 0;
        for plane in self.planes {
            let range = first..first + plane.points.len();
            first = range.end;
            let own = &found[range.clone()];
            let is_reached = brightest(own).into_iter().zip(overall).any(|(own, all)| own > DARK * all);
            if !is_reached && overall != [0.0; 2] {
                lit.dark += 1;
                continue;
            }
            let lux: Vec<f64> = own.iter().map(lux_of).collect();
            let factors: Option<Vec<f64>> = own.iter().map(factor_of).collect();
            let name = format!("Room {}", lit.reports.len() + 1);
            lit.reports.extend(report(WorkPlane { name, ..plane }, &lux, factors.as_deref()));
            lit.points.extend(&self.points[range]);
            lit.results.extend(own);
        }
        lit
    }
}

/// The height of work planes, metres.
fn metres(scene: &Scene, height: Option<f64>) -> f64 {
    height.map_or(USUAL_WORK_PLANE, |height| height * scene.unit.metres())
}

/// No light comes to a room that has less than this share of the brightest place.
const DARK: f64 = 1e-6;

fn report(plane: WorkPlane, lux: &[f64], factors: Option<&[f64]>) -> Option<WorkPlaneReport> {
    let illuminance_lx = GridReport::of(lux)?;
    Some(WorkPlaneReport {
        name: plane.name,
        size_m: plane.size,
        height_m: plane.height,
        spacing_m: plane.spacing,
        points: lux.len(),
        uniformity: (illuminance_lx.mean > 0.0).then(|| illuminance_lx.minimum / illuminance_lx.mean),
        illuminance_lx,
        daylight_factor_percent: factors.and_then(GridReport::of),
    })
}

/// Grids with what arrives at them.
pub(super) struct LitGrids {
    points: Vec<SurfacePoint>,
    results: Vec<PointResult>,
    pub(super) reports: Vec<WorkPlaneReport>,
    /// Spaces that no light reaches where others have some.
    dark: usize,
}

impl LitGrids {
    /// Writes all points, each with its room.
    ///
    /// # Errors
    /// A refusal of the system.
    pub(super) fn write(&self, path: &Path) -> Result<(), ExportError> {
        let name = |plane: &'_ WorkPlaneReport| std::iter::repeat_n(plane.name.clone(), plane.points);
        let names: Vec<String> = self.reports.iter().flat_map(name).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        write_irradiance(path, Some(&names), &self.points, &self.results, illuminance)
    }

    /// Room by room, with its points in the scene, metres.
    pub(super) fn planes(&self, scene: &Scene) -> Vec<LitPlane> {
        let mut all = self.points.iter().zip(&self.results);
        let lit = |(point, result): (&SurfacePoint, &PointResult)| {
            (scene.in_scene(point.position), illuminance(result.irradiance))
        };
        let plane = |report: &WorkPlaneReport| LitPlane {
            report: report.clone(),
            points: all.by_ref().take(report.points).map(lit).collect(),
        };
        self.reports.iter().map(plane).collect()
    }

    /// A few lines for each room.
    pub(super) fn told(&self) -> String {
        let mut lines: String = self.reports.iter().map(told).collect();
        if self.dark > 0 {
            let spaces = text::count(self.dark, "closed space");
            lines +=
                &format!("{spaces} that no light reaches left out, such as the inside of solid blocks\n");
        }
        lines
    }
}

fn told(plane: &WorkPlaneReport) -> String {
    let WorkPlaneReport { size_m: [x, y], spacing_m: [dx, dy], illuminance_lx: lux, .. } = plane;
    let uniformity = plane.uniformity.map_or_else(|| "none".to_owned(), |u0| format!("{u0:.2}"));
    let mut told = format!(
        "{}, {x:.2} x {y:.2} m: work plane {:.2} m above the floor, {} {dx:.2} x {dy:.2} m apart\n  \
         illuminance: mean {} lx, minimum {}, maximum {}, uniformity {uniformity}\n",
        plane.name,
        plane.height_m,
        text::count(plane.points, "point"),
        text::significant(lux.mean),
        text::significant(lux.minimum),
        text::significant(lux.maximum),
    );
    if let Some(factor) = plane.daylight_factor_percent {
        told += &format!(
            "  daylight factor: mean {} %, median {} %, minimum {} %\n",
            text::significant(factor.mean),
            text::significant(factor.median),
            text::significant(factor.minimum)
        );
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_told_in_the_numbers_of_the_standard() {
        let plane = WorkPlane {
            name: "Room 1".to_owned(),
            size: [6.0, 4.0],
            height: 0.8,
            spacing: [0.5556, 0.6],
            points: vec![glam::DVec3::ZERO; 4],
        };
        let lux = [100.0, 200.0, 300.0, 600.0];
        let report = report(plane.clone(), &lux, Some(&[0.5, 1.0, 2.0, 8.5])).expect("points");
        assert_eq!(report.uniformity, Some(100.0 / 300.0));
        let expected = "Room 1, 6.00 x 4.00 m: work plane 0.80 m above the floor, 4 points 0.56 x 0.60 m apart\n  \
            illuminance: mean 300 lx, minimum 100, maximum 600, uniformity 0.33\n  \
            daylight factor: mean 3.00 %, median 1.50 %, minimum 0.500 %\n";
        assert_eq!(told(&report), expected);
        let dark = super::report(plane, &[0.0; 4], None).expect("points");
        assert_eq!((dark.uniformity, dark.daylight_factor_percent), (None, None));
    }
}
