//! Files for other programs: pictures, tables, meshes and reports, each whole or not there at all.
//!
//! Takes plain values: who has a solved scene turns it into them.

pub mod atomic;
mod chart;
mod csv;
mod error;
mod exr;
mod ply;
mod png;
mod points;
mod report;

pub use chart::{Chart, ChartPoint, Panel, Series};
pub use csv::{PatchRow, write_patch_table};
pub use error::ExportError;
pub use exr::{StillLayers, write_exr};
pub use ply::{LitMesh, write_ply};
pub use png::{png_bytes, write_png, write_png_with_alpha};
pub use points::{PointResult, PointsError, SurfacePoint, parse_points, read_points, write_irradiance};
pub use report::{
    AccuracyReport, AreaReport, AttemptReport, DominantReport, EffectReport, ElementReport, ErrorReport,
    FindingReport, FormFactorReport, GoalReport, GridReport, LampReport, MaterialReport, MeshReport,
    PointsReport, PowerReport, RangeReport, Report, SceneReport, SettingsReport, SweepLine, TimingReport,
    WorkPlaneReport, peak_memory_bytes, write_report,
};
