use super::failure::Failure;
use super::text;
use crate::export::atomic;
use crate::scene::{self, SceneSource, builtin};
use anyhow::Context as _;
use clap::Args;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// List the embedded scenes, or write them out as files
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// Write each as NAME.obj, NAME.mtl and NAME.toml into this folder
    #[arg(long, value_name = "DIR")]
    export: Option<PathBuf>,
    /// Replace files of these names that are there already
    #[arg(long, requires = "export")]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.export {
        Some(folder) => export(folder, arguments.force),
        None => list(),
    }
}

fn list() -> Result<(), Failure> {
    let mut rows = Vec::new();
    for name in builtin::NAMES {
        let scene = scene::load(&SceneSource::Builtin((*name).to_owned()))?;
        let size = scene.bounds().size();
        rows.push(vec![
            format!("builtin:{name}"),
            text::count(scene.surfaces.len(), "surface"),
            text::count(scene.luminaires.len(), "lamp"),
            text::count(scene.views.len(), "view"),
            format!("{:.2} x {:.2} x {:.2} m", size.x, size.y, size.z),
        ]);
    }
    text::print(&text::table(&rows))
}

fn export(folder: &Path, force: bool) -> Result<(), Failure> {
    let mut files = Vec::new();
    for name in builtin::NAMES {
        let Some(source) = builtin::source(name) else { continue };
        for (extension, text) in [("obj", source.obj), ("mtl", source.mtl), ("toml", source.sidecar)] {
            files.push((folder.join(format!("{name}.{extension}")), text));
        }
    }
    // Edited copies may stand there: all is looked at before anything is written.
    let stands = |(path, text): &&(PathBuf, String)| {
        std::fs::read(path).is_ok_and(|there| there != text.as_bytes()) || path.is_dir()
    };
    if let Some((path, _)) = files.iter().find(stands).filter(|_| !force) {
        return Err(Failure::work(anyhow::anyhow!(
            "{} is there already and differs; nothing was written (--force replaces it)",
            path.display()
        )));
    }
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))
        .map_err(Failure::Work)?;
    let mut told = String::new();
    for (path, text) in &files {
        atomic::write(path, |file| file.write_all(text.as_bytes()))?;
        told += &format!("{}\n", path.display());
    }
    text::print(&told)
}
