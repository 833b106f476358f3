use super::budget;
use super::failure::Failure;
use super::options;
use super::picture::{self, Studio};
use super::solve::{self, LitOptions};
use super::text;
use super::work_planes::Grids;
use super::written::Written;
use crate::accuracy::ErrorBudget;
use crate::export::atomic;
use crate::outputs::{Page, TARGETS, Target, is_same_file, page_html};
use crate::scene::{Severity, USUAL_WORK_PLANE, sidecar_path};
use crate::solve::{Overcast, Solution};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Compute the light of a scene and write it up: one page of HTML with plans, lux, pictures, lamps, materials and how
/// sure all of it is, and a table of all points
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// A model (OBJ, glTF, GLB, PLY), or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    /// Folder for the page, NAME.html, and the table, NAME-grid.csv; made where there is none
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What the rooms are for: their lux are held against EN 12464-1
    #[arg(long = "use", value_name = "USE", value_parser = uses())]
    target: Option<Target>,
    /// Height of the work planes above the floor, in the unit of the scene's file [default: 0.8 m]
    #[arg(long, value_name = "HEIGHT", value_parser = options::positive)]
    height: Option<f64>,
    /// Pixels of each picture across and down [default: 1280x800]
    #[arg(long, value_name = "WxH", value_parser = options::size)]
    size: Option<[u32; 2]>,
    #[command(flatten)]
    lit: LitOptions,
}

fn uses() -> impl clap::builder::TypedValueParser<Value = Target> {
    let values = TARGETS.map(|target| {
        let wants = format!("{}: {} lx, U0 {:.2}", target.name, target.lux, target.uniformity);
        PossibleValue::new(target.key).help(wants)
    });
    PossibleValuesParser::new(values).try_map(|key| Target::of(&key).ok_or("an unknown use"))
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    arguments.lit.options.set_threads()?;
    let scene = arguments.lit.scene(&arguments.scene)?;
    if scene.luminaires.is_empty() {
        return Err(Failure::input(format!(
            "{} has no lamps and no sky, so there is no light to write up; add --ceiling-lamps or --daylight",
            scene.name
        )));
    }
    let settings = arguments.lit.options.settings(scene.unit)?;
    let lighting = arguments.lit.lighting(&scene)?;
    let folder = &arguments.out;
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::input(format!("{}: {error}", folder.display())))?;
    let page_path = folder.join(format!("{}.html", scene.name));
    let table_path = folder.join(format!("{}-grid.csv", scene.name));
    let model = scene.source.path();
    let own =
        model.iter().flat_map(|path| [path.to_path_buf(), sidecar_path(path), path.with_extension("mtl")]);
    let inputs: Vec<PathBuf> = own.chain(scene.read_from.iter().cloned()).collect();
    for path in [&page_path, &table_path] {
        if inputs.iter().any(|input| is_same_file(input, path)) {
            return Err(Failure::input(format!(
                "{} would be overwritten and is an input; choose another folder for what is written",
                path.display()
            )));
        }
        atomic::probe(path)?;
    }
    // A scene without rooms, such as a court, has a page without plans, unless somebody asks for them.
    let grids = match (arguments.height, arguments.target) {
        (None, None) => Grids::in_rooms(&scene, None),
        (height, _) => Some(Grids::new(&scene, height)?),
    };

    let (solved, light) = solve::solve(scene, &settings, &lighting)?;
    let scene = Arc::clone(&solved.scene);
    let solve_seconds = start.elapsed().as_secs_f64();
    let found = budget::audit(&solved, &lighting);
    let overcast = match grids.is_some() {
        true => Overcast::of(&solved, &AtomicBool::new(false))?,
        false => None,
    };
    let grids = grids.map(|grids| grids.gather(&solved, &lighting, &light, overcast.as_ref()));
    let studio = Studio::new(&solved, &lighting, &light);
    let size = arguments.size.unwrap_or(picture::DEFAULT_SIZE);
    let mut pictures = Vec::new();
    for view in &scene.views {
        pictures.push((view.name.clone(), studio.png(view, size)?));
    }
    let doubts = scene.findings.iter().filter(|finding| finding.severity >= Severity::Warning);
    let page = Page {
        scene: &scene,
        lighting: &lighting,
        pictures,
        planes: grids.as_ref().map_or_else(Vec::new, |grids| grids.planes(&scene)),
        target: arguments.target,
        accuracy: accuracy(found.as_ref()),
        settings: told_settings(&solved, solve_seconds),
        doubts: doubts.map(|finding| finding.message.clone()).collect(),
    };
    let mut written = Written::default();
    let text = page_html(&page);
    written.note(&page_path, write(&page_path, &text));
    if let Some(grids) = &grids {
        written.note(&table_path, grids.write(&table_path));
    }
    let mut told = solve::summary(&solved, solve_seconds);
    if let Some(grids) = &grids {
        told += &grids.told();
        told += &arguments.target.map_or_else(String::new, |target| verdicts(&page, &target));
    }
    for output in written.files() {
        told += &format!("wrote {output}\n");
    }
    text::print(&told)?;
    written.end()
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(atomic::write(path, |file| file.write_all(text.as_bytes()))?)
}

/// Which rooms have what their use asks for, a line each.
fn verdicts(page: &Page<'_>, target: &Target) -> String {
    let line = |plane: &crate::outputs::LitPlane| {
        let verdict = target.verdict(&plane.report);
        format!(
            "{}: {verdict} for EN 12464-1:2011, {} ({} lx, U0 {:.2})\n",
            plane.report.name, target.clause, target.lux, target.uniformity
        )
    };
    page.planes.iter().map(line).collect()
}

/// How wrong what is shown may be, in sentences.
fn accuracy(found: Option<&ErrorBudget>) -> Vec<String> {
    let Some(found) = found else { return Vec::new() };
    let percent = |share: f64| format!("{} %", text::significant(100.0 * share));
    let part = |name: &str, error: f64| format!("{name} {}", percent(error));
    vec![
        format!(
            "Irradiance is off by {} (RMS, of the light there; between {} and {} in nine of ten cases). It was compared at {} \
             with an independent calculation by rays.",
            percent(found.total.error),
            percent(found.total.low),
            percent(found.total.high),
            text::count(found.receivers, "place"),
        ),
        format!(
            "By its causes: {}.",
            [
                part("direct light", found.direct.error),
                part("form factors", found.form_factors.error),
                part("patches", found.mesh.error),
                part("solver", found.solver.estimate.error),
            ]
            .join(", ")
        ),
        "Reflection is diffuse. Maintenance, furniture that is not in the model and tolerances of lamps are not in these \
         numbers."
            .to_owned(),
    ]
}

fn told_settings(solved: &Solution, seconds: f64) -> Vec<(String, String)> {
    let settings = &solved.settings;
    let effects: Vec<&str> = solved
        .plan
        .decisions
        .iter()
        .filter(|decision| solved.plan.is_on(decision.effect))
        .map(|decision| decision.effect.name())
        .collect();
    let elements = solved.element_light.as_ref().map_or(0, |light| light.elements.leaves().count());
    let resolution = settings.resolution.unwrap_or_else(|| settings.method.default_resolution());
    [
        ("Patches", text::thousands(solved.mesh.patches.len())),
        ("Elements for direct light", text::thousands(elements)),
        ("Form factors", format!("{} {resolution}", settings.method.name())),
        ("Effects", effects.join(", ")),
        (
            "Work planes",
            format!("{USUAL_WORK_PLANE} m above the floor where nothing else is given; grid of EN 12464-1"),
        ),
        ("Time", text::seconds(seconds)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}
