use super::budget;
use super::failure::Failure;
use super::lamps::{self, LampOptions};
use super::options::{self, FrameOptions, SolveOptions};
use super::picture::{self, Studio};
use super::points;
use super::progress::ProgressLine;
use super::report::{self, OwnTimings};
use super::text;
use super::tour::{self, FrameFolder};
use super::work_planes::{Grids, LitGrids};
use super::written::Written;
use crate::display::{DisplayMesh, Shading};
use crate::effects::Effect;
use crate::export::{self, atomic, read_points};
use crate::outputs::{LitScene, StillKind, in_detail, is_same_file, save_patch_table};
use crate::scene::{self, FindingKind, Lighting, Scene, Severity, View};
use crate::solve::{self, Control, Overcast, Progress, Solution, SolveSettings};
use crate::solver::PatchLight;
use crate::study::{Goal, Task};
use clap::{ArgGroup, Args};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// How a scene is read, lit and solved.
#[derive(Args, Debug)]
pub(super) struct LitOptions {
    #[command(flatten)]
    frame: FrameOptions,
    #[command(flatten)]
    pub(super) options: SolveOptions,
    #[command(flatten)]
    lamps: LampOptions,
    /// Switch this lamp on (may be repeated)
    #[arg(long, value_name = "NAME")]
    on: Vec<String>,
    /// Switch this lamp off (may be repeated)
    #[arg(long, value_name = "NAME")]
    off: Vec<String>,
    /// Dim this lamp to a share from 0 to 1 of its full output (may be repeated)
    #[arg(long, value_name = "NAME=SHARE", value_parser = options::dimming)]
    dim: Vec<(String, f64)>,
    /// Light it by this sky, or by that of its sidecar with these keys changed: as in "date=2026-06-21 time=14:30"
    #[arg(long, value_name = "KEY=VALUE ...")]
    daylight: Option<String>,
}

impl LitOptions {
    /// The scene of this name, under the sky that is asked for.
    ///
    /// # Errors
    /// As [`load`], and a sky that cannot be.
    pub(super) fn scene(&self, name: &str) -> Result<Arc<Scene>, Failure> {
        let scene = load(name, &self.frame, self.lamps)?;
        match &self.daylight {
            Some(text) => Ok(Arc::new(under_sky(&scene, text)?)),
            None => Ok(scene),
        }
    }

    /// Its lamps as they are switched; says so where none of them gives light.
    ///
    /// # Errors
    /// A name that no lamp has.
    pub(super) fn lighting(&self, scene: &Scene) -> Result<Lighting, Failure> {
        let lighting = lamps::lighting(scene, &self.on, &self.off, &self.dim)?;
        lamps::tell_darkness(scene, &lighting);
        Ok(lighting)
    }
}

/// Compute the light of a scene without a window, and write pictures and tables
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("pictures").args(["image", "tour"]).multiple(true))]
pub(super) struct Arguments {
    /// A model (OBJ, glTF, GLB, PLY), or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    lit: LitOptions,
    /// Look from this bookmark [default: the scene's start view]
    #[arg(long, value_name = "NAME", requires = "image", conflicts_with = "eye")]
    view: Option<String>,
    /// Look from this place, in the unit of the scene's file
    #[arg(long, value_name = "X,Y,Z", value_parser = options::place, allow_hyphen_values = true,
          requires_all = ["target", "image"])]
    eye: Option<DVec3>,
    /// Look at this place, in the unit of the scene's file
    #[arg(long, value_name = "X,Y,Z", value_parser = options::place, allow_hyphen_values = true,
          requires = "eye")]
    target: Option<DVec3>,
    /// Vertical field of view, degrees [default: that of the view; 60 with --eye]
    #[arg(long, value_name = "DEG", value_parser = options::field_of_view, requires = "image")]
    fov: Option<f64>,
    /// Pixels across and down [default: 1280x800]
    #[arg(long, value_name = "WxH", value_parser = options::size, requires = "pictures")]
    size: Option<[u32; 2]>,
    /// Write a picture: tone-mapped as .png, or radiance with its layers as .exr
    #[arg(long, value_name = "OUT.png|OUT.exr")]
    image: Option<PathBuf>,
    /// Walk through all bookmarks and write each frame into this folder, numbered, as .png
    #[arg(long, value_name = "DIR")]
    tour: Option<PathBuf>,
    /// Frames a second of the tour [default: 30]
    #[arg(long, value_name = "N", value_parser = options::frame_rate, requires = "tour")]
    fps: Option<f64>,
    /// Write a table of all patches
    #[arg(long, value_name = "OUT.csv")]
    patch_table: Option<PathBuf>,
    /// Write the lit mesh
    #[arg(long, value_name = "OUT.ply")]
    mesh: Option<PathBuf>,
    /// Gather irradiance at the points x,y,z,nx,ny,nz in this file, in the unit of the scene's file
    #[arg(long, value_name = "IN.csv", requires = "irradiance")]
    points: Option<PathBuf>,
    /// Write irradiance and illuminance at the points, and daylight factors where the scene has a sky
    #[arg(long, value_name = "OUT.csv", requires = "points")]
    irradiance: Option<PathBuf>,
    /// Tell illuminance, and daylight factors where the scene has a sky, over a grid in each room this high above its floor,
    /// in the unit of the scene's file [default: 0.8 m]
    #[arg(long, value_name = "HEIGHT", num_args = 0..=1, value_parser = options::positive)]
    work_plane: Option<Option<f64>>,
    /// Write what is found at all points of these grids
    #[arg(long, value_name = "OUT.csv", requires = "work_plane")]
    work_plane_table: Option<PathBuf>,
    /// Check the answer by independent rays and tell how wrong it is
    #[arg(long)]
    audit: bool,
    /// Go on until the irradiance as shown is within this of the truth (RMS, of the light there): chooses
    /// patches, lines and tolerance
    #[arg(long, value_name = "SHARE", value_parser = budget::error_goal, conflicts_with_all = BY_GOAL)]
    error: Option<f64>,
    /// Get as near to the truth as this much time allows, as in 5s: chooses patches and lines
    #[arg(long, value_name = "TIME", value_parser = budget::seconds_goal, conflicts_with_all = BY_GOAL,
          conflicts_with = "error")]
    budget: Option<f64>,
    /// Write counts, settings, timings, sweeps and the power balance
    #[arg(long, value_name = "OUT.json")]
    report: Option<PathBuf>,
}

/// What a goal chooses by itself.
const BY_GOAL: [&str; 8] = [
    "patch_size",
    "patches",
    "patches_as_given",
    "method",
    "resolution",
    "receiving_points",
    "transport",
    "tolerance",
];

impl Arguments {
    fn goal(&self) -> Option<Goal> {
        self.error.map(Goal::Error).or(self.budget.map(Goal::Seconds))
    }

    /// Whether points are all that is to be known of the light.
    fn wants_points_alone(&self) -> bool {
        let rest = [&self.image, &self.tour, &self.patch_table, &self.mesh];
        (self.points.is_some() || self.work_plane.is_some()) && rest.iter().all(|output| output.is_none())
    }

    fn outputs(&self) -> impl Iterator<Item = &Path> {
        let tables = [&self.patch_table, &self.irradiance, &self.work_plane_table];
        let all = [&self.image, &self.mesh, &self.report].into_iter().chain(tables);
        all.filter_map(|output| output.as_deref())
    }

    /// Refuses early what would fail after the solve.
    fn check_outputs(&self, scene: &Scene) -> Result<(), Failure> {
        let outputs: Vec<&Path> = self.outputs().collect();
        let model = scene.source.path();
        let own = model.iter().flat_map(|path| ["obj", "mtl", "toml"].map(|kind| path.with_extension(kind)));
        let given = model.map(Path::to_owned).into_iter().chain(self.points.clone());
        let inputs: Vec<PathBuf> = own.chain(given).chain(scene.read_from.iter().cloned()).collect();
        // No output is a model or its materials, whatever their name.
        let is_model = |path: &Path| {
            let kind = path.extension().unwrap_or_default().to_ascii_lowercase();
            (kind == "obj" || kind == "mtl") && path.exists()
        };
        for (index, output) in outputs.iter().enumerate() {
            if is_model(output) || inputs.iter().any(|input| is_same_file(input, output)) {
                let path = output.display();
                let told = format!(
                    "{path} would be overwritten and is an input; choose another name for what is written"
                );
                return Err(Failure::input(told));
            }
            if outputs[..index].contains(output) && !Path::new(output).starts_with("/dev") {
                let path = output.display();
                return Err(Failure::input(format!("two outputs would be written to {path}")));
            }
            atomic::probe(output)?;
        }
        Ok(())
    }

    fn tour(&self, scene: &Scene) -> Result<Option<FrameFolder>, Failure> {
        let fps = self.fps.unwrap_or(tour::DEFAULT_FPS);
        self.tour.as_deref().map(|folder| FrameFolder::ready(folder, scene, fps)).transpose()
    }

    /// Whether the tour was written.
    fn write_pictures(
        &self,
        studio: &Studio<'_>,
        kind: Option<StillKind>,
        view: &View,
        tour: Option<&FrameFolder>,
        written: &mut Written,
    ) -> bool {
        let size = self.size.unwrap_or(picture::DEFAULT_SIZE);
        if let (Some(path), Some(kind)) = (&self.image, kind) {
            written.note(path, studio.write_view(path, kind, view, size));
        }
        if let Some(path) = &self.mesh {
            written.note(path, studio.write_mesh(path));
        }
        tour.is_some_and(|tour| written.check(tour.write(studio, size)).is_some())
    }

    fn view(&self, scene: &Scene) -> Result<View, Failure> {
        let mut view = match (self.eye, self.target, &self.view) {
            (Some(eye), Some(target), _) => {
                let [eye, target] = [eye, target].map(|place| scene.in_scene(place));
                if eye.distance_squared(target) < 1e-18 {
                    return Err(Failure::input("--eye and --target are the same place"));
                }
                View { name: "as given".into(), eye, target, fov_y_deg: 60.0 }
            }
            (_, _, Some(name)) => scene.views[lamps::view(scene, name)?].clone(),
            _ => start_view(scene)?,
        };
        view.fov_y_deg = self.fov.unwrap_or(view.fov_y_deg);
        Ok(view)
    }
}

pub(super) fn start_view(scene: &Scene) -> Result<View, Failure> {
    let view = scene.views.get(scene.start_view).or(scene.views.first());
    view.cloned().ok_or_else(|| Failure::input(format!("{} has no view to look from", scene.name)))
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    let kind = arguments.image.as_deref().map(picture::kind_of).transpose()?;
    arguments.lit.options.set_threads()?;
    let scene = arguments.lit.scene(&arguments.scene)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let settings = arguments.lit.options.settings(scene.unit)?;
    let lighting = arguments.lit.lighting(&scene)?;
    let view = arguments.view(&scene)?;
    let points = arguments.points.as_deref().map(read_points).transpose()?;
    let grids = arguments.work_plane.map(|height| Grids::new(&scene, height)).transpose()?;
    arguments.check_outputs(&scene)?;
    let tour = arguments.tour(&scene)?;

    // Without a lamp there is no light that could be right or wrong.
    let is_unlit = scene.luminaires.is_empty();
    let goal = arguments.goal().filter(|_| !is_unlit);
    // Without pictures or tables it is the points whose error counts.
    let all = [points.as_ref(), grids.as_ref().map(|grids| &grids.points)];
    let all = all.into_iter().flatten().filter(|_| arguments.wants_points_alone());
    let places: Vec<_> = all.flat_map(|all| points::places(all, |place| scene.in_scene(place))).collect();
    let (lit, effects) = (&lighting, &settings.effects);
    let task = |goal| Task { scene: &scene, lighting: lit, goal, effects, places: &places };
    let reached = goal.map(|goal| budget::reach(&task(goal), start)).transpose()?;
    let (solved, light) = match &reached {
        Some(reached) => (reached.solved.clone(), reached.solved.light(&lighting)),
        None => solve(scene, &settings, &lighting)?,
    };
    let solve_seconds = start.elapsed().as_secs_f64();
    let audited = match &reached {
        Some(reached) => reached.solved.budget,
        None => (arguments.audit && !is_unlit).then(|| budget::audit(&solved, &lighting)).flatten(),
    };
    let outputs_start = Instant::now();
    let mut written = Written::default();
    let mut has_toured = false;
    let pictures = arguments.image.is_some() || arguments.tour.is_some() || arguments.mesh.is_some();
    if pictures {
        let studio = Studio::new(&solved, &lighting, &light);
        has_toured = arguments.write_pictures(&studio, kind, &view, tour.as_ref(), &mut written);
    }
    if let Some(path) = &arguments.patch_table {
        let lit = LitScene {
            scene: &solved.scene,
            mesh: &solved.mesh,
            lighting: &lighting,
            light: &light,
            reflectance: &solved.reflectance,
        };
        written.note(path, save_patch_table(path, &lit));
    }
    let overcast = match points.is_some() || grids.is_some() {
        true => Overcast::of(&solved, &AtomicBool::new(false))?,
        false => None,
    };
    let gather = |points: &Vec<_>| points::gather(points, &solved, &lighting, &light, overcast.as_ref());
    let gathered = points.as_ref().map(gather);
    if let (Some(points), Some(gathered), Some(path)) = (&points, &gathered, &arguments.irradiance) {
        written.note(path, gathered.write(path, points));
    }
    let grids = grids.map(|grids| grids.gather(&solved, &lighting, &light, overcast.as_ref()));
    if let (Some(grids), Some(path)) = (&grids, &arguments.work_plane_table) {
        written.note(path, grids.write(path));
    }
    if let Some(path) = &arguments.report {
        let [outputs, total] = [outputs_start, start].map(|since| since.elapsed().as_secs_f64());
        // What is only done to be timed belongs to neither.
        let display = display_seconds(&solved, &lighting);
        let own = OwnTimings { load: load_seconds, display, outputs, total };
        let accuracy = audited
            .map(|found| budget::report(&found, &solved.scene, &solved.timings, goal.zip(reached.as_ref())));
        let mut report = report::report(&solved, &lighting, &light, own, written.files().to_vec());
        report.accuracy = accuracy;
        report.points = gathered.as_ref().map(points::Gathered::report);
        report.work_planes = grids.as_ref().map_or_else(Vec::new, |grids| grids.reports.clone());
        written.note(path, export::write_report(path, &report));
    }
    let mut told = summary(&solved, solve_seconds);
    if let Some(found) = &audited {
        told += &budget::lines(found, &solved.scene);
    }
    if let Some(reached) = &reached {
        told += &budget::verdict_lines(reached);
    }
    if let Some(gathered) = &gathered {
        told += &gathered.told();
    }
    told += &grids.as_ref().map_or_else(String::new, LitGrids::told);
    if gathered.is_some() || grids.is_some() {
        told += &points::sky_told(&solved.scene, overcast.as_ref());
    }
    for output in written.files() {
        told += &format!("wrote {output}\n");
    }
    if let Some(tour) = tour.filter(|_| has_toured) {
        told += &tour.told();
    }
    text::print(&told)?;
    written.end()
}

/// The scene under the sky of its sidecar with what the text says changed.
fn under_sky(scene: &Scene, text: &str) -> Result<Scene, Failure> {
    let own = scene.outdoors.as_ref().map(|outdoors| outdoors.choice.clone()).unwrap_or_default();
    let choice = own.changed(text).map_err(|error| Failure::input(format!("--daylight: {error}")))?;
    Ok(scene.with_daylight(Some(&choice))?)
}

/// Loads a scene and says on standard error what is doubtful about it.
///
/// # Errors
/// What cannot be read, and lamps asked for that there is no place for.
pub(super) fn load(name: &str, frame: &FrameOptions, lamps: LampOptions) -> Result<Arc<Scene>, Failure> {
    const SHOWN: usize = 12;
    let scene = scene::load(&frame.source(name)?)?;
    // A guess at the way up changes all pictures, however good it is.
    let is_told = |f: &&scene::Finding| f.severity >= Severity::Warning || f.kind == FindingKind::UpAxis;
    let doubts: Vec<_> = scene.findings.iter().filter(is_told).collect();
    for finding in doubts.iter().take(SHOWN) {
        text::complain(&format!("{}: {}", report::severity_name(finding.severity), finding.message));
    }
    if doubts.len() > SHOWN {
        text::complain(&format!("{} more; lumenwalk check tells them all", doubts.len() - SHOWN));
    }
    Ok(Arc::new(lamps.add_to(scene)?))
}

/// Solves with progress on standard error, and mixes the lamps. Nothing is solved where there is none.
pub(super) fn solve(
    scene: Arc<Scene>,
    settings: &SolveSettings,
    lighting: &Lighting,
) -> Result<(Arc<Solution>, PatchLight), Failure> {
    if scene.luminaires.is_empty() {
        let solved = Arc::new(solve::without_light(scene, settings)?);
        let light = solved.light(lighting);
        return Ok((solved, light));
    }
    let mut line = ProgressLine::new();
    let observe = &mut |progress: Progress<'_>| {
        line.solve(&progress);
        Control::Continue
    };
    // An interrupt ends the process itself; nothing else cancels.
    let solved = Arc::new(solve::solve(scene, settings, &AtomicBool::new(false), observe)?);
    let light = solved.light(lighting);
    Ok((solved, light))
}

/// What was solved, how well and how fast, in a few lines.
pub(super) fn summary(solved: &Solution, seconds: f64) -> String {
    let settings = &solved.settings;
    if solved.scene.luminaires.is_empty() {
        let patches = text::patches(solved.mesh.patches.len());
        let seconds = text::seconds(seconds);
        return format!(
            "{}: {patches}, no lamps, so nothing was solved\ndone in {seconds}\n",
            solved.scene.name
        );
    }
    let mut told = format!(
        "{}: {}, {}, {} {}\n",
        solved.scene.name,
        text::patches(solved.mesh.patches.len()),
        text::count(solved.scene.luminaires.len(), "lamp"),
        settings.method.name(),
        settings.resolution.unwrap_or_else(|| settings.method.default_resolution()),
    );
    let statistics = &solved.mesh.statistics;
    for sentence in [statistics.excess(), statistics.clustering()].into_iter().flatten() {
        told += &format!("{sentence}\n");
    }
    if let Some(transport) = &solved.transport {
        told += &text::transport(transport.as_ref());
    }
    match solved.sweeps.last() {
        Some(last) => {
            told += &format!(
                "solved in {}: {}, residual {}, error at most {}\n",
                text::seconds(seconds),
                text::count(last.sweep as usize, "sweep"),
                text::significant(last.residual),
                text::significant(last.error_bound),
            );
            if last.error_bound > settings.tolerance {
                told += &format!(
                    "the tolerance of {} was not reached: what is left is the error above\n",
                    text::significant(settings.tolerance)
                );
            }
            told += &format!(
                "power as the lamps come: {} W emitted, {} W absorbed, {} W escaped\n",
                text::significant(last.emitted),
                text::significant(last.absorbed),
                text::significant(last.escaped),
            );
        }
        None => told += &format!("done in {}\n", text::seconds(seconds)),
    }
    told
}

/// Seconds that it takes from the lamps' bases to the smoothly shaded corners.
fn display_seconds(solved: &Solution, lighting: &Lighting) -> f64 {
    let elements = solved.element_light.as_ref().map(|light| &light.elements);
    let smooth = solved.plan.is_on(Effect::SmoothSurfaces);
    let display = DisplayMesh::build_on(&solved.mesh, &solved.scene, smooth, elements);
    let clock = Instant::now();
    let light = solved.light(lighting);
    std::hint::black_box(light.power(&solved.mesh, &solved.reflectance, lighting));
    let detail = light.detail.as_deref().map(in_detail);
    let corners = display.detailed_radiosity(&light.radiosity, &light.irradiance, detail, Shading::Gouraud);
    std::hint::black_box(corners);
    clock.elapsed().as_secs_f64()
}
