use super::failure::Failure;
use super::lamps::{self, LampOptions};
use super::options::{FrameOptions, SolveOptions};
use super::picture::{self, Studio};
use super::{solve, text};
use crate::export::atomic;
use crate::outputs::StillKind;
use crate::scene::{self, LengthUnit, SceneError, SceneSource, builtin};
use crate::ui::{UiError, run as open_window};
use clap::Args;
use std::path::PathBuf;
use std::time::Instant;

const DEFAULT_SCENE: &str = "builtin:hemicube";

#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// A model (OBJ, glTF, GLB, PLY), or builtin:NAME [default: builtin:hemicube]
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    #[command(flatten)]
    frame: FrameOptions,
    #[command(flatten)]
    options: SolveOptions,
    #[command(flatten)]
    lamps: LampOptions,
}

/// Opens the window; where there can be none, solves and writes a picture instead.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = arguments.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    let source = arguments.frame.source(name)?;
    refuse_what_is_not_there(&source)?;
    arguments.options.set_threads()?;
    // The window reads the scene itself; here it is wanted for its unit alone.
    let unit = match arguments.options.patches.patch_size {
        Some(_) => scene::load(&source)?.unit,
        None => LengthUnit::Metre,
    };
    match open_window(source, arguments.options.settings(unit)?, arguments.lamps.ceiling_lamps) {
        Ok(()) => Ok(()),
        Err(UiError::NoDisplay(reason)) => {
            text::complain(&format!(
                "no window can be opened here ({}), so the scene is solved without one",
                plain(&reason)
            ));
            headless(name, arguments)
        }
        Err(other) => Err(Failure::work(other)),
    }
}

/// A slip of the pen on the command line is told there and not in a window.
fn refuse_what_is_not_there(source: &SceneSource) -> Result<(), Failure> {
    match source {
        SceneSource::File(path) | SceneSource::FileAs(path, _) if !path.exists() => {
            Err(SceneError::Missing(path.clone()).into())
        }
        SceneSource::Builtin(name) if !builtin::NAMES.contains(&name.as_str()) => {
            // Reading it fails, and says what names there are.
            scene::load(source).map(drop).map_err(Failure::from)
        }
        _ => Ok(()),
    }
}

fn headless(name: &str, arguments: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    let scene = solve::load(name, &arguments.frame, arguments.lamps)?;
    let settings = arguments.options.settings(scene.unit)?;
    let view = solve::start_view(&scene)?;
    let path = picture_path(&scene.name);
    atomic::probe(&path)?;
    let lighting = scene.lighting();
    lamps::tell_darkness(&scene, &lighting);
    let (solved, light) = solve::solve(scene, &settings, &lighting)?;
    let studio = Studio::new(&solved, &lighting, &light);
    studio.write_view(&path, StillKind::Png, &view, picture::DEFAULT_SIZE)?;
    let summary = solve::summary(&solved, start.elapsed().as_secs_f64());
    text::print(&format!("{summary}wrote {}\n", path.display()))
}

/// A reason without the place in the windowing library's source that stands before it.
fn plain(reason: &str) -> &str {
    let at_fault = |at: usize| reason[at..].find(": ").map_or(0, |end| at + end + 2);
    let start = reason.rfind(".rs:").map_or(0, at_fault);
    reason[start..].trim_end_matches('.')
}

/// `lumenwalk-NAME.png` in the current folder, whatever the name holds.
fn picture_path(name: &str) -> PathBuf {
    let safe: String = name
        .chars()
        .take(100)
        .map(|c| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' })
        .collect();
    PathBuf::from(format!("lumenwalk-{safe}.png"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_told_without_places_in_sources() {
        let told = "winit EventLoopError: os error at /a/b: c/mod.rs:765: DISPLAY is not set.";
        assert_eq!(plain(told), "DISPLAY is not set");
        assert_eq!(plain("no adapter: none found"), "no adapter: none found");
        assert_eq!(plain("x.rs:7"), "x.rs:7");
    }

    #[test]
    fn the_picture_stays_in_the_current_folder() {
        assert_eq!(picture_path("hemicube"), PathBuf::from("lumenwalk-hemicube.png"));
        assert_eq!(picture_path("../../a b"), PathBuf::from("lumenwalk-.._.._a_b.png"));
    }
}
