use super::budget::percent;
use super::failure::Failure;
use super::lamps::LampOptions;
use super::options::{EffectOptions, FrameOptions};
use super::progress::ProgressLine;
use super::{budget, solve, text};
use crate::form_factors::ReceivingPoints;
use crate::mesh::{self, MeshSettings};
use crate::scene::Scene;
use crate::solve::{Control, PipelineError};
use crate::study::{self, table};
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Measure what accuracy costs in a scene: methods, resolutions, receiving points and patch sizes
///
/// Writes accuracy.csv, accuracy.svg and accuracy.png. What stands in accuracy.csv for the same scene
/// already is not measured again, so that an interrupted run goes on where it ended.
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// A model (OBJ, glTF, GLB, PLY), or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    frame: FrameOptions,
    /// Folder for the table and the charts; made where it is missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Begin nothing that would not end within this time; a number of seconds, or as in 10min
    #[arg(long, value_name = "TIME", value_parser = budget::seconds_goal, default_value = "10min")]
    max_seconds: f64,
    #[command(flatten)]
    lamps: LampOptions,
    /// Threads at work [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let started = Instant::now();
    super::options::set_threads(arguments.threads)?;
    let scene = solve::load(&arguments.scene, &arguments.frame, arguments.lamps)?;
    if scene.luminaires.is_empty() {
        return Err(Failure::input(format!(
            "{} has no lamps, so there is no light whose error could be measured; --ceiling-lamps adds a lamp to \
             each room",
            scene.name
        )));
    }
    let lighting = scene.lighting();
    std::fs::create_dir_all(&arguments.out).map_err(|error| {
        Failure::work(anyhow::Error::new(error).context(format!("cannot make {}", arguments.out.display())))
    })?;
    let csv = arguments.out.join("accuracy.csv");
    let mut rows = match std::fs::read_to_string(&csv) {
        Ok(text) => table::parse(&text),
        Err(_) => Vec::new(),
    };
    table::write(&csv, &rows)?;

    let hash = study::scene_hash(&scene);
    let threads = rayon::current_num_threads();
    let usual = usual_patches(&scene)?;
    let all = study::entries(usual);
    let is_own = |row: &table::Row| row.hash == hash && row.threads == threads;
    // Wherever in the table a point stands, and whatever order it was measured in.
    let is_known = |entry: &study::Entry| rows.iter().any(|r| is_own(r) && r.entry == *entry);
    let missing: Vec<_> = all.iter().copied().filter(|entry| !is_known(entry)).collect();
    let known = all.len() - missing.len();
    let mut line = ProgressLine::new();
    let mut left_out = 0;
    for (done, entry) in missing.into_iter().enumerate() {
        let own: Vec<_> = rows.iter().filter(|r| is_own(r)).cloned().collect();
        let foreseen = study::foreseen(entry, &own).unwrap_or(0.0);
        if started.elapsed().as_secs_f64() + foreseen > arguments.max_seconds {
            left_out += 1;
            continue;
        }
        let points = match entry.points {
            ReceivingPoints::Auto => String::new(),
            fixed => format!(", receiving points {}", fixed.name()),
        };
        let what = format!("{} {}{points}, {} patches", entry.method.name(), entry.resolution, entry.patches);
        let share = (known + done) as f64 / all.len() as f64;
        let measured = study::measure(&scene, &lighting, entry, &mut |progress| {
            line.sweep(share, &what, progress);
            Control::Continue
        });
        match measured {
            Ok(row) => rows.push(row),
            // Too large for this machine: so are finer ones, which will say so as soon.
            Err(PipelineError::Memory { .. }) => left_out += 1,
            Err(error) => return Err(error.into()),
        }
        table::write(&csv, &rows)?;
    }
    drop(line);

    rows.retain(is_own);
    let chart = study::chart(&rows);
    let (svg, png) = (arguments.out.join("accuracy.svg"), arguments.out.join("accuracy.png"));
    chart.write_svg(&svg)?;
    chart.write_png(&png)?;
    let mut told = front(&rows);
    if left_out > 0 {
        told += &format!(
            "{} of {} points left out for want of time or memory; run again to go on\n",
            left_out,
            all.len()
        );
    }
    for path in [&csv, &svg, &png] {
        told += &format!("wrote {}\n", Path::new(path).display());
    }
    text::print(&told)
}

/// How many patches the scene has when nobody asks for a number.
fn usual_patches(scene: &Scene) -> Result<usize, Failure> {
    let settings = MeshSettings {
        backs: crate::effects::backs(&EffectOptions::default().choices()?),
        ..MeshSettings::default()
    };
    Ok(mesh::build(scene, &settings)?.patches.len())
}

/// The points that no other beats, as a table.
fn front(rows: &[table::Row]) -> String {
    let places: Vec<[f64; 2]> = rows.iter().map(|r| [r.total_seconds, r.budget.total.error]).collect();
    let names = [
        "method",
        "resolution",
        "points",
        "patches",
        "seconds",
        "form factors",
        "patches",
        "as shown",
        "95 %",
        "memory",
    ];
    let mut lines = vec![names.map(String::from).to_vec()];
    for i in study::pareto(&places) {
        let (r, b) = (&rows[i], &rows[i].budget);
        lines.push(vec![
            r.entry.method.name().into(),
            r.entry.resolution.to_string(),
            r.entry.points.name().into(),
            text::thousands(r.patches),
            format!("{:.2}", r.total_seconds),
            percent(b.form_factors.error),
            percent(b.mesh.error),
            percent(b.total.error),
            format!("{} to {}", percent(b.total.low), percent(b.total.high)),
            r.peak_memory.map_or("-".into(), |bytes| format!("{} MB", bytes / 1_000_000)),
        ]);
    }
    text::table(&lines)
}
