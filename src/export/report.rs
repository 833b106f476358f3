use super::{ExportError, atomic};
use serde::Serialize;
use std::io::{self, Write as _};
use std::path::Path;

/// All that a headless solve tells about itself. Serialised as JSON under these names.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: &'static str,
    /// What was solved.
    pub scene: SceneReport,
    /// How it was to be solved.
    pub settings: SettingsReport,
    /// The patches.
    pub mesh: MeshReport,
    /// The rows.
    pub form_factors: FormFactorReport,
    /// Direct light on elements; `null` where the rows carry it.
    pub elements: Option<ElementReport>,
    /// The effect plan.
    pub effects: Vec<EffectReport>,
    /// Seconds by stage.
    pub timings: TimingReport,
    /// One entry a sweep.
    pub sweeps: Vec<SweepLine>,
    /// Residual after the last sweep, relative to the largest radiosity that is reflected; `null` without sweeps.
    pub residual: Option<f64>,
    /// Guaranteed bound on the relative error; `null` without sweeps.
    pub error_bound: Option<f64>,
    /// Power balance with the lamps as they come with the scene; `null` without sweeps.
    pub power: Option<PowerReport>,
    /// Power emitted and absorbed with the lamps as switched on the command line, W.
    pub power_as_switched: PowerReport,
    /// How wrong the answer is; `null` where it was not audited.
    pub accuracy: Option<AccuracyReport>,
    /// How wrong the illuminance at free points is; `null` where none was asked for.
    pub points: Option<PointsReport>,
    /// The work planes that were asked for.
    pub work_planes: Vec<WorkPlaneReport>,
    /// The most memory that the process ever held, bytes; `null` where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Files written besides this one.
    pub outputs: Vec<String>,
}

/// The scene in counts and names.
#[derive(Clone, Debug, Serialize)]
pub struct SceneReport {
    /// Its name.
    pub name: String,
    /// A path, or `builtin:NAME`.
    pub source: String,
    /// Unit of the file.
    pub unit: &'static str,
    /// Extent along x, y and z, metres.
    pub extent_m: [f64; 3],
    /// Input polygons.
    pub surfaces: usize,
    /// Objects and groups.
    pub objects: usize,
    /// Images.
    pub textures: usize,
    /// All materials.
    pub materials: Vec<MaterialReport>,
    /// All luminaires, as switched.
    pub luminaires: Vec<LampReport>,
    /// What the reader noticed.
    pub findings: Vec<FindingReport>,
}

/// Free points; errors are over the illuminance at each point, and hold in nine of ten cases.
#[derive(Clone, Debug, Serialize)]
pub struct PointsReport {
    /// How many.
    pub count: usize,
    /// Median of their estimated errors; `null` where no light comes to any.
    pub median_error_percent: Option<f64>,
    /// The largest of them.
    pub largest_error_percent: Option<f64>,
    /// Which point that is, counted from 1.
    pub worst_point: Option<usize>,
}

/// Illuminance and daylight factor over the work plane of a room.
#[derive(Clone, Debug, Serialize)]
pub struct WorkPlaneReport {
    /// Of the room.
    pub name: String,
    /// Length and width of the room, m.
    pub size_m: [f64; 2],
    /// Of the plane above the floor, m.
    pub height_m: f64,
    /// Between neighbouring points, m.
    pub spacing_m: [f64; 2],
    /// Points evaluated.
    pub points: usize,
    /// Under the lamps and the sky as switched.
    pub illuminance_lx: GridReport,
    /// Least over mean illuminance, U0; `null` in the dark.
    pub uniformity: Option<f64>,
    /// Under the traditional overcast sky of the CIE; `null` where there is no sky.
    pub daylight_factor_percent: Option<GridReport>,
}

/// Values at the points of a grid in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GridReport {
    /// Arithmetic mean.
    pub mean: f64,
    /// Half of the points have less, half have more.
    pub median: f64,
    /// Smallest.
    pub minimum: f64,
    /// Largest.
    pub maximum: f64,
}

impl GridReport {
    /// Of finite values; `None` where there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (&minimum, &maximum) = (sorted.first()?, sorted.last()?);
        let median = 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]);
        Some(Self { mean: sorted.iter().sum::<f64>() / sorted.len() as f64, median, minimum, maximum })
    }
}

/// One material.
#[derive(Clone, Debug, Serialize)]
pub struct MaterialReport {
    /// Its name.
    pub name: String,
    /// Reflectance per band.
    pub reflectance: [f64; 3],
}

/// One luminaire, as switched.
#[derive(Clone, Debug, Serialize)]
pub struct LampReport {
    /// Its name.
    pub name: String,
    /// Emitting area, m².
    pub area_m2: f64,
    /// Switched on.
    pub on: bool,
    /// 0 to 1.
    pub dimmer: f64,
    /// Exitance at full output, W/m² per band.
    pub exitance: [f64; 3],
}

/// Something that the reader noticed.
#[derive(Clone, Debug, Serialize)]
pub struct FindingReport {
    /// note, warning or error.
    pub severity: &'static str,
    /// One sentence.
    pub message: String,
    /// How many faces or materials.
    pub count: usize,
}

/// What was asked for.
#[derive(Clone, Debug, Serialize)]
pub struct SettingsReport {
    /// In words: "auto", "0.1 m", "2000 patches".
    pub patches: String,
    /// Whether patches are smaller where a check found errors.
    pub finer_where_wrong: bool,
    /// lines, hemicube, hemicube-aligned or rays.
    pub method: &'static str,
    /// Half-planes, cells along an edge of the cube, or rays.
    pub resolution: u32,
    /// Points of a patch at which its row is gathered: auto, 1, 4 or 16.
    pub receiving_points: &'static str,
    /// The solve stops at this error bound.
    pub tolerance: f64,
    /// Threads at work.
    pub threads: usize,
}

/// The patches in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct MeshReport {
    /// Patches in all: unknowns a band and lamp, and rows.
    pub patches: usize,
    /// Patches that emit.
    pub emitters: usize,
    /// Planar regions.
    pub regions: usize,
    /// Sides that no light can reach.
    pub dark_sides: usize,
    /// Surfaces dropped for want of area.
    pub dropped: usize,
    /// Total area, m².
    pub area_m2: f64,
    /// Smallest patch, m².
    pub smallest_area_m2: f64,
    /// Largest patch, m².
    pub largest_area_m2: f64,
    /// Median aspect; 1 for squares.
    pub median_aspect: f64,
    /// Worst aspect.
    pub worst_aspect: f64,
    /// Edge length aimed at, metres.
    pub patch_size_m: f64,
}

/// The form factors in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct FormFactorReport {
    /// What carries the light between patches: `matrix`, of all pairs, or `tree`, whose rows end at nodes; `none` without
    /// lamps.
    pub transport: &'static str,
    /// Stored factors.
    pub entries: usize,
    /// Memory that they take.
    pub bytes: usize,
    /// Pairs computed in closed form for being close.
    pub close_pairs: usize,
    /// Largest |row sum - 1| as sampled, among rows that see no opening.
    pub worst_closure: f64,
    /// Mean relative |A_i F_ij - A_j F_ji| as sampled, weighted by area.
    pub mean_reciprocity: f64,
    /// Scaling passes until the power balance closed.
    pub balance_passes: usize,
    /// Largest relative deviation of a row sum from its target after them.
    pub imbalance: f64,
    /// Share of the balanced exchange that patches keep to themselves, since those that they see cannot take
    /// it up.
    pub kept: f64,
    /// What nodes of a tree that stand for their patches change about what surfaces pass on, at most: root mean square
    /// of the mean irradiance of any lamp alone, with a reflectance of one; 0 of a matrix.
    pub joined_error: f64,
    /// Rows of a tree that were given what their samples had missed of small patches.
    pub mended_rows: usize,
}

/// Direct light on elements.
#[derive(Clone, Debug, Serialize)]
pub struct ElementReport {
    /// Triangles that carry it.
    pub count: usize,
    /// Their corners.
    pub corners: usize,
    /// What part of the light there it is expected to be off by, RMS over the area.
    pub expected_error: f64,
    /// By what each lamp's light on the patches was scaled so that what it emits arrives: the least and the largest factor.
    pub scaling: [f64; 2],
}

/// One line of the effect plan.
#[derive(Clone, Debug, Serialize)]
pub struct EffectReport {
    /// Its name, as `--with` takes it.
    pub effect: &'static str,
    /// on, not called for, on by choice, off by choice.
    pub state: &'static str,
    /// Why.
    pub reason: String,
    /// The counts behind it.
    pub evidence: String,
    /// What it was expected to cost.
    pub predicted_cost: String,
    /// What it took, where that was measured; zero where leaving it out would not have been faster.
    pub measured_seconds: Option<f64>,
}

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TimingReport {
    /// Reading and checking the model.
    pub load: f64,
    /// Splitting into patches.
    pub mesh: f64,
    /// Deciding effects.
    pub plan: f64,
    /// Until direct light was everywhere, from the start of the rows.
    pub first_light: f64,
    /// Direct light on elements.
    pub elements: f64,
    /// All rows, first light included.
    pub rows: f64,
    /// Making rows reciprocal and closed.
    pub balance: f64,
    /// Sweeps.
    pub sweeps: f64,
    /// From the lamps' bases to the corners that are drawn, once: what a switched lamp costs.
    pub display: f64,
    /// Pictures, tables and points.
    pub outputs: f64,
    /// From the start of the command.
    pub total: f64,
}

/// One sweep.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SweepLine {
    /// Counted from 1.
    pub sweep: u32,
    /// Relative to the largest radiosity that is reflected.
    pub residual: f64,
    /// Guaranteed bound on the relative error.
    pub error_bound: f64,
    /// Seconds since the solve began.
    pub seconds: f64,
}

/// Where the power goes, W, summed over bands.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PowerReport {
    /// By lamps.
    pub emitted: f64,
    /// By surfaces.
    pub absorbed: f64,
    /// Through openings; `null` where it was not counted by itself.
    pub escaped: Option<f64>,
}

/// An error as root mean square over the receiving area, percent of the light there, or of the mean irradiance where that
/// is more.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ErrorReport {
    /// The estimate.
    pub percent: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end; `null` where too little is known.
    pub high: Option<f64>,
    /// Seconds spent on keeping it down; `null` for sums of errors.
    pub seconds: Option<f64>,
}

/// The error budget.
#[derive(Clone, Debug, Serialize)]
pub struct AccuracyReport {
    /// Form factors and visibility.
    pub form_factors: ErrorReport,
    /// Direct light, interpolated on its elements; zero where patches carry all.
    pub direct_light: ErrorReport,
    /// Patches: discretisation.
    pub patches: ErrorReport,
    /// Sweeps that are missing.
    pub solver: ErrorReport,
    /// Guaranteed bound on the latter at any patch, percent of the mean irradiance.
    pub solver_bound_percent: f64,
    /// All together, of the irradiance as shown.
    pub as_shown: ErrorReport,
    /// Form factors and patches together, of the irradiance of a patch as a whole.
    pub patch_averages: ErrorReport,
    /// The same relative to the mean irradiance everywhere.
    pub of_the_mean: ErrorReport,
    /// Half of the area is off by less, percent of the light at each place.
    pub median_percent: RangeReport,
    /// Shares of the area that are off by less, of the light at each place.
    pub area_within: Vec<AreaReport>,
    /// The object that most of the mean square sits on; `null` where there is none.
    pub dominant: Option<DominantReport>,
    /// What percents are of, lx.
    pub mean_illuminance_lx: f64,
    /// Receivers asked.
    pub receivers: usize,
    /// Rays cast.
    pub rays: u64,
    /// Seconds that this took.
    pub audit_seconds: f64,
    /// The goal of the solve; `null` where none was named.
    pub goal: Option<GoalReport>,
}

/// A percentage with its 95 % interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RangeReport {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// How much of the area is off by less than an error.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AreaReport {
    /// The error, percent of the light at each place.
    pub error_percent: f64,
    /// The share of the receiving area, percent.
    pub area_percent: RangeReport,
}

/// Where most of the error sits.
#[derive(Clone, Debug, Serialize)]
pub struct DominantReport {
    /// Name of the object.
    pub object: String,
    /// Its share of the mean square of the error as shown.
    pub percent_of_squares: f64,
    /// Its share of the receiving area.
    pub percent_of_area: f64,
    /// The patch of it that weighs most among those asked.
    pub patch: u32,
}

/// What the user asked for and what came of it.
#[derive(Clone, Debug, Serialize)]
pub struct GoalReport {
    /// Error asked for; `null` where a time was.
    pub asked_percent: Option<f64>,
    /// Seconds asked for; `null` where an error was.
    pub asked_seconds: Option<f64>,
    /// Whether it was met.
    pub met: bool,
    /// Whether all rows and sweeps of the answer were made.
    pub complete: bool,
    /// One sentence.
    pub verdict: String,
    /// Seconds in all, audits included.
    pub seconds: f64,
    /// The solves on the way.
    pub attempts: Vec<AttemptReport>,
}

/// One solve on the way to a goal.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AttemptReport {
    /// Patches.
    pub patches: usize,
    /// Half-planes a row.
    pub lines: u32,
    /// Seconds that it took.
    pub seconds: f64,
    /// Seconds foreseen; `null` for the first.
    pub predicted_seconds: Option<f64>,
    /// Error as shown; `null` where it was not audited.
    pub percent: Option<f64>,
    /// Error foreseen; `null` for the first.
    pub predicted_percent: Option<f64>,
}

/// Writes the report as indented JSON.
///
/// # Errors
/// A refusal of the system.
pub fn write_report(path: &Path, report: &Report) -> Result<(), ExportError> {
    atomic::write(path, |file| {
        serde_json::to_writer_pretty(&mut *file, report).map_err(io::Error::from)?;
        writeln!(file)
    })
}

/// The most memory that this process ever held, bytes: `VmHWM` of Linux; `None` elsewhere.
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    high_water_mark(&status)
}

fn high_water_mark(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_read_in_bytes() {
        assert_eq!(high_water_mark("VmPeak:\t 9 kB\nVmHWM:\t    5124 kB\nVmRSS: 1 kB"), Some(5124 * 1024));
        assert_eq!(high_water_mark("VmRSS: 1 kB"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_grows_with_what_is_touched() {
        let before = peak_memory_bytes().unwrap();
        let block = vec![1_u8; 256 << 20];
        let after = peak_memory_bytes().unwrap();
        assert!(after >= 256 << 20 && after >= before, "{before} {after} {}", block[7]);
    }
}
