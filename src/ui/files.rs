//! Files that come and go beside the frames: dialogs, saving, and watching for changes. Each runs
//! on a thread of its own and reports by a channel.

use super::command::SaveKind;
use super::path_dialog::Purpose;
use super::prepared::Prepared;
use super::state::Edits;
use crate::display::{Exposure, Shading, SkyView, ToneMap};
use crate::export::{ExportError, write_png};
use crate::navigation::Camera;
use crate::outputs::{
    LitScene, StillKind, StillLight, save_lit_mesh, save_patch_table, save_repaired, save_still,
};
use crate::render::{StillOptions, render_still};
use crate::scene::{
    LengthUnit, Lighting, Scene, SceneError, SceneSource, UpAxis, View, sidecar_path, write_frame,
    write_sidecar,
};
use crate::solver::PatchLight;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant, SystemTime};

/// A dialog that answers "none" faster than this never came up (no portal on this desktop).
const NEVER_SHOWN: Duration = Duration::from_millis(300);
/// How often a file is looked at for changes.
const WATCH_EVERY: Duration = Duration::from_millis(700);
/// Files that have not changed for this long are complete: programs write a model in several goes.
const REST: Duration = Duration::from_millis(500);

/// What a helper thread tells.
#[derive(Debug)]
pub(super) enum FileNews {
    /// A scene was chosen.
    Opened(PathBuf),
    /// A weather file was chosen.
    Weather(PathBuf),
    /// A name to save under was chosen.
    SaveAs(SaveKind, PathBuf),
    /// The dialog was closed without a choice.
    Cancelled,
    /// The desktop has no file dialog: ask inside the window.
    NoDialog(Purpose),
    /// Saved.
    Saved(PathBuf),
    /// A repaired copy was saved, and what was mended.
    Repaired(PathBuf, String),
    /// The sidecar says another unit or up axis.
    Framed(PathBuf),
    /// Not saved, and why.
    SaveFailed(String),
    /// A watched file changed.
    Changed,
}

/// Everything that a save needs, taken at the moment of asking.
pub(super) struct SaveJob {
    pub(super) prepared: Arc<Prepared>,
    pub(super) light: PatchLight,
    pub(super) reflectance: Arc<Vec<[f32; 3]>>,
    pub(super) lighting: Lighting,
    pub(super) camera: Camera,
    pub(super) size_px: [u32; 2],
    pub(super) shading: Shading,
    pub(super) exposure: Exposure,
    pub(super) tone_map: ToneMap,
    /// Factors per band of what is shown.
    pub(super) gains: [f32; 3],
}

/// The helper threads' end of the window.
pub(super) struct Files {
    sender: Sender<FileNews>,
    receiver: Receiver<FileNews>,
    ctx: egui::Context,
    /// Dropping it ends the watcher.
    watcher: Option<Sender<()>>,
}

impl Files {
    pub(super) fn new(ctx: egui::Context) -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver, ctx, watcher: None }
    }

    /// What has happened since the last look.
    pub(super) fn news(&self) -> Vec<FileNews> {
        self.receiver.try_iter().collect()
    }

    fn spawn(&self, name: &str, work: impl FnOnce() -> FileNews + Send + 'static) {
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        let run = move || {
            // Nobody listens any more when the window has closed.
            sender.send(work()).ok();
            ctx.request_repaint();
        };
        if let Err(error) = std::thread::Builder::new().name(name.to_owned()).spawn(run) {
            let text = format!("no thread could be started: {error}");
            self.sender.send(FileNews::SaveFailed(text)).ok();
        }
    }

    /// Asks for a scene to open.
    pub(super) fn open_dialog(&self) {
        self.ask(
            Purpose::Scene,
            ("Models (OBJ, glTF, GLB, PLY)", &["obj", "OBJ", "gltf", "GLTF", "glb", "GLB", "ply", "PLY"]),
            FileNews::Opened,
        );
    }

    /// Asks for a weather file.
    pub(super) fn weather_dialog(&self) {
        self.ask(Purpose::Weather, ("EnergyPlus weather", &["epw", "EPW"]), FileNews::Weather);
    }

    fn ask(&self, purpose: Purpose, (name, endings): (&str, &[&str]), chosen: fn(PathBuf) -> FileNews) {
        let dialog = rfd::AsyncFileDialog::new().set_title(purpose.title()).add_filter(name, endings);
        let choice = dialog.pick_file();
        self.spawn("open dialog", move || {
            let asked = Instant::now();
            match pollster::block_on(choice) {
                Some(file) => chosen(file.path().to_owned()),
                None if asked.elapsed() < NEVER_SHOWN => FileNews::NoDialog(purpose),
                None => FileNews::Cancelled,
            }
        });
    }

    /// Asks for a name to save under.
    pub(super) fn save_dialog(&self, kind: SaveKind, suggestion: &Path) {
        let mut dialog = rfd::AsyncFileDialog::new()
            .set_title(kind.title())
            .add_filter(kind.extension().to_uppercase(), &[kind.extension()]);
        if let Some(folder) = suggestion.parent() {
            dialog = dialog.set_directory(folder);
        }
        if let Some(name) = suggestion.file_name() {
            dialog = dialog.set_file_name(name.to_string_lossy());
        }
        let choice = dialog.save_file();
        self.spawn("save dialog", move || {
            let asked = Instant::now();
            match pollster::block_on(choice) {
                Some(file) => FileNews::SaveAs(kind, file.path().to_owned()),
                None if asked.elapsed() < NEVER_SHOWN => FileNews::NoDialog(Purpose::Save(kind)),
                None => FileNews::Cancelled,
            }
        });
    }

    /// Writes a picture of `pixels`.
    pub(super) fn save_picture(&self, path: PathBuf, pixels: egui::ColorImage) {
        self.spawn("save picture", move || {
            let bytes: Vec<u8> = pixels.pixels.iter().flat_map(|p| p.to_array()).collect();
            let [width, height] = pixels.size.map(|n| n as u32);
            told(write_png(&path, width, height, &bytes), path)
        });
    }

    /// Writes the radiance, the patch table or the lit mesh.
    pub(super) fn save(&self, kind: SaveKind, path: PathBuf, job: SaveJob) {
        self.spawn("save", move || {
            let result = match kind {
                SaveKind::Hdr | SaveKind::Screenshot => save_picture_of(&path, &job),
                SaveKind::PatchTable => save_table(&path, &job),
                SaveKind::LitMesh => save_mesh(&path, &job),
                // They need no light and go their own way.
                SaveKind::RepairedCopy | SaveKind::EditedCopy => return repaired(path, &job.prepared.scene),
            };
            told(result, path)
        });
    }

    /// Writes a mended copy of a model.
    pub(super) fn save_repaired(&self, path: PathBuf, scene: Arc<Scene>) {
        self.spawn("repair", move || repaired(path, &scene));
    }

    /// Writes lamps, daylight, repainted materials and bookmarks to the sidecar of the scene in `path`.
    pub(super) fn save_sidecar(
        &self,
        path: &Path,
        scene: Arc<Scene>,
        edits: Edits,
        bookmarks: (Vec<View>, usize),
    ) {
        let sidecar = sidecar_path(path);
        self.spawn("save sidecar", move || match write_edits(&sidecar, &scene, edits, bookmarks) {
            Ok(()) => FileNews::Saved(sidecar),
            Err(error) => FileNews::SaveFailed(error.to_string()),
        });
    }

    /// Writes a copy of the scene, and what the user has done to it to the copy's sidecar.
    pub(super) fn save_edited(
        &self,
        copy: PathBuf,
        scene: Arc<Scene>,
        edits: Edits,
        bookmarks: (Vec<View>, usize),
    ) {
        self.spawn("save copy", move || {
            if let Err(error) = save_repaired(&copy, &scene) {
                return FileNews::SaveFailed(error.to_string());
            }
            match write_edits(&sidecar_path(&copy), &scene, edits, bookmarks) {
                Ok(()) => FileNews::Saved(copy),
                Err(error) => FileNews::SaveFailed(error.to_string()),
            }
        });
    }

    /// Writes the unit and the up axis of the model in `path` to its sidecar.
    pub(super) fn save_frame(&self, path: &Path, unit: LengthUnit, up: UpAxis) {
        let sidecar = sidecar_path(path);
        self.spawn("save unit", move || match write_frame(&sidecar, unit, up) {
            Ok(()) => FileNews::Framed(sidecar),
            Err(error) => FileNews::SaveFailed(error.to_string()),
        });
    }

    /// Watches the files of a scene and these others from now on, or none.
    pub(super) fn watch(&mut self, source: Option<&SceneSource>, others: &[PathBuf]) {
        self.watcher = None;
        let Some(path) = source.and_then(SceneSource::path) else { return };
        let files = ["obj", "mtl", "toml"].map(|extension| path.with_extension(extension));
        let files: Vec<PathBuf> =
            [path.to_owned()].into_iter().chain(files).chain(others.iter().cloned()).collect();
        let (keep, dropped) = channel::<()>();
        let (sender, ctx) = (self.sender.clone(), self.ctx.clone());
        let watch = move || {
            let mut seen = stamps(&files);
            while dropped.recv_timeout(WATCH_EVERY) == Err(RecvTimeoutError::Timeout) {
                let now = stamps(&files);
                // Half-written files are left alone until they rest for one round.
                if now != seen && now == after_a_moment(&files) {
                    seen = now;
                    if sender.send(FileNews::Changed).is_err() {
                        return;
                    }
                    ctx.request_repaint();
                }
            }
        };
        if std::thread::Builder::new().name("file watcher".to_owned()).spawn(watch).is_ok() {
            self.watcher = Some(keep);
        }
    }
}

fn stamps(files: &[PathBuf]) -> Vec<Option<(SystemTime, u64)>> {
    let stamp = |path: &PathBuf| {
        let meta = std::fs::metadata(path).ok()?;
        Some((meta.modified().ok()?, meta.len()))
    };
    files.iter().map(stamp).collect()
}

fn after_a_moment(files: &[PathBuf]) -> Vec<Option<(SystemTime, u64)>> {
    std::thread::sleep(REST);
    stamps(files)
}

/// Writes what the user has done to a scene to the sidecar at `path`.
fn write_edits(
    path: &Path,
    scene: &Scene,
    edits: Edits,
    (views, start_view): (Vec<View>, usize),
) -> Result<(), SceneError> {
    // Lamps that were added may not have come to the screen yet.
    let mut scene = scene.with_placed(edits.placed).with_daylight(edits.daylight.as_ref())?;
    (scene.views, scene.start_view) = (views, start_view);
    let mut repainted = Vec::new();
    for (index, value) in edits.reflectance.iter().enumerate() {
        if let (Some(reflectance), Some(material)) = (value, scene.materials.get_mut(index)) {
            material.reflectance = *reflectance;
            repainted.push(index as u32);
        }
    }
    write_sidecar(path, &scene, &edits.lighting, &repainted)
}

fn repaired(path: PathBuf, scene: &Scene) -> FileNews {
    match save_repaired(&path, scene) {
        Ok(mended) if mended.done.is_empty() => {
            FileNews::Repaired(path, "nothing had to be mended".to_owned())
        }
        Ok(mended) => FileNews::Repaired(path, mended.done.join(", ")),
        Err(error) => FileNews::SaveFailed(error.to_string()),
    }
}

fn told(result: Result<(), ExportError>, path: PathBuf) -> FileNews {
    match result {
        Ok(()) => FileNews::Saved(path),
        Err(error) => FileNews::SaveFailed(error.to_string()),
    }
}

/// A free name `NAME.png`, `NAME-2.png`, ... in the folder for pictures, or in the current one.
pub(super) fn free_name(folder: &Path, stem: &str, extension: &str) -> PathBuf {
    let stem: String =
        stem.chars().map(|c| if c.is_alphanumeric() || "-_. ".contains(c) { c } else { '_' }).collect();
    let named = |k: u32| match k {
        1 => folder.join(format!("{stem}.{extension}")),
        _ => folder.join(format!("{stem}-{k}.{extension}")),
    };
    (1..10_000).map(named).find(|path| !path.exists()).unwrap_or_else(|| named(10_000))
}

/// The user's folder for pictures where there is one, else home, else the current folder.
pub(super) fn pictures_folder() -> PathBuf {
    let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE")).map(PathBuf::from);
    let pictures = home.as_ref().map(|h| h.join("Pictures")).filter(|p| p.is_dir());
    pictures.or(home.filter(|h| h.is_dir())).unwrap_or_else(|| PathBuf::from("."))
}

fn save_picture_of(path: &Path, job: &SaveJob) -> Result<(), ExportError> {
    let (prepared, kind) = (&job.prepared, StillKind::of(path).unwrap_or(StillKind::Exr));
    let light = StillLight::new(&prepared.display, &job.light, job.shading);
    let sky = SkyView::of(&prepared.scene, &job.lighting);
    let input = light.input(&prepared.display, &prepared.picker, &prepared.scene.textures, sky);
    let options =
        StillOptions { gains: job.gains, ..StillOptions::new(job.size_px, job.exposure, job.tone_map) };
    match render_still(&input, &job.camera, &options, &|_| true) {
        Some(still) => save_still(path, kind, &still),
        None => Ok(()),
    }
}

fn save_table(path: &Path, job: &SaveJob) -> Result<(), ExportError> {
    let lit = LitScene {
        scene: &job.prepared.scene,
        mesh: &job.prepared.mesh,
        lighting: &job.lighting,
        light: &job.light,
        reflectance: &job.reflectance,
    };
    save_patch_table(path, &lit)
}

fn save_mesh(path: &Path, job: &SaveJob) -> Result<(), ExportError> {
    let (display, origin) = (&job.prepared.display, job.prepared.scene.origin);
    save_lit_mesh(path, display, origin, &job.light, job.shading, job.exposure, job.tone_map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taken_name_is_not_taken_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = free_name(folder.path(), "house: a/b", "png");
        assert_eq!(first, folder.path().join("house_ a_b.png"));
        std::fs::write(&first, "x").expect("written");
        assert_eq!(free_name(folder.path(), "house: a/b", "png"), folder.path().join("house_ a_b-2.png"));
    }

    #[test]
    fn a_change_of_a_sidecar_is_noticed() {
        let folder = tempfile::tempdir().expect("a folder");
        let model = folder.path().join("a.obj");
        std::fs::write(&model, "v 0 0 0").expect("written");
        let mut files = Files::new(egui::Context::default());
        files.watch(Some(&SceneSource::File(model.clone())), &[]);
        std::thread::sleep(Duration::from_millis(100));
        std::fs::write(model.with_extension("toml"), "unit = \"m\"").expect("written");
        let news = files.receiver.recv_timeout(Duration::from_secs(20));
        assert!(matches!(news, Ok(FileNews::Changed)), "{news:?}");
    }
}
