//! One path from model files to a [`Scene`], whatever their format, and for embedded scenes alike.

use super::error::SceneError;
use super::extent::{self, Extent, Footprint};
use super::lookup::{Files, read_complete};
use super::luminaires::{Parts, gather};
use super::model::{self, Face, Given, Importer, Model, Polygons};
use super::photometric::PhotometricFiles;
use super::repair::repair_watched;
use super::sidecar::{Sidecar, Source};
use super::space::Space;
use super::types::{FrameChoice, Scene, SceneSource};
use super::wavefront::Wavefront;
use super::{bare_lights, builtin, frame, lamp_entry, names, outdoors, sides, views};
use crate::geometry::Aabb;
use crate::memory;
use crate::watch::Watch;
use glam::DVec3;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Shares of the time by which the file is read and the polygons are repaired, about; the rest goes into lamps and
/// views.
const READ: f64 = 0.8;
const REPAIRED: f64 = 0.95;

/// Bytes that reading takes for each of the file. Measured: 320 MB for a kitchen of 35 MB.
const BYTES_READING: f64 = 10.0;

/// Where a scene comes from.
struct Input<'a> {
    source: SceneSource,
    /// What was asked for over the sidecar.
    choice: FrameChoice,
    model: Given<'a>,
    importer: &'a dyn Importer,
    sidecar: Option<(String, String)>,
}

/// Reads a scene: a model file (OBJ with its MTL, glTF or GLB, PLY) with the images and the sidecar (`NAME.toml`) beside
/// it, or an embedded scene.
///
/// What can be repaired is, and is told in [`Scene::findings`]; the rest is an error that names file
/// and line.
pub fn load(source: &SceneSource) -> Result<Scene, SceneError> {
    Watch::nobody(|watch| load_watched(source, watch))
}

/// As [`load`], for somebody who watches and may end it.
///
/// # Errors
/// Also [`SceneError::Cancelled`].
pub fn load_watched(source: &SceneSource, watch: &mut Watch<'_>) -> Result<Scene, SceneError> {
    match source {
        SceneSource::File(path) => load_file(path, FrameChoice::default(), watch),
        SceneSource::FileAs(path, choice) => load_file(path, *choice, watch),
        SceneSource::Builtin(name) => {
            let texts = builtin::source(name).ok_or_else(|| SceneError::UnknownBuiltin {
                name: names::short(name),
                known: names::list(builtin::NAMES.iter().copied()),
            })?;
            from_text(name, &texts.obj, &texts.mtl, Some(texts.sidecar.as_str()).filter(|s| !s.is_empty()))
        }
    }
}

/// Makes a scene of texts in memory. Every `mtllib` means `mtl`; images are not found.
pub fn from_text(name: &str, obj: &str, mtl: &str, sidecar_toml: Option<&str>) -> Result<Scene, SceneError> {
    let file = format!("{name}.obj");
    let input = Input {
        source: SceneSource::Builtin(name.to_owned()),
        choice: FrameChoice::default(),
        model: Given { name, file: &file, bytes: obj.as_bytes(), files: Files::Library(mtl) },
        importer: &Wavefront,
        sidecar: sidecar_toml.map(|text| (format!("{name}.toml"), text.to_owned())),
    };
    Watch::nobody(|watch| build(input, watch))
}

/// The sidecar that belongs to a model file: `NAME.toml` beside it.
pub fn sidecar_path(model: &Path) -> PathBuf {
    model.with_extension("toml")
}

fn load_file(path: &Path, choice: FrameChoice, watch: &mut Watch<'_>) -> Result<Scene, SceneError> {
    let size = std::fs::metadata(path).map_or(0, |file| file.len());
    memory::check(BYTES_READING * size as f64)
        .map_err(|shortage| SceneError::Memory { path: path.to_owned(), shortage })?;
    let mut bytes = read_complete(path).map_err(|error| SceneError::reading(path, &error))?;
    // What seems to end too soon may be what another program is writing, at its leisure.
    while !model::importer(path, &bytes).is_whole(&bytes) && rests_soon(path, watch)? {
        bytes = read_complete(path).map_err(|error| SceneError::reading(path, &error))?;
    }
    let sidecar_path = sidecar_path(path);
    let sidecar = match read_complete(&sidecar_path) {
        Ok(bytes) => Some((display(&sidecar_path), crate::encoding::decode(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(SceneError::reading(&sidecar_path, &error)),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let cancelled = watch.cancelled();
    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    let file = display(path);
    let input = Input {
        source: SceneSource::File(path.to_owned()).framed(choice),
        choice,
        model: Given { name: &name, file: &file, bytes: &bytes, files: Files::Folder { folder, cancelled } },
        importer: model::importer(path, &bytes),
        sidecar,
    };
    build(input, watch)
}

/// Waits until a file has not changed for a moment; whether it has changed meanwhile.
fn rests_soon(path: &Path, watch: &Watch<'_>) -> Result<bool, SceneError> {
    const MOMENT: Duration = Duration::from_millis(700);
    const LOOK: Duration = Duration::from_millis(20);
    let changed = || std::fs::metadata(path).and_then(|file| file.modified()).ok();
    let before = changed();
    while before.is_some_and(|at| at.elapsed().is_ok_and(|age| age < MOMENT)) {
        if watch.cancelled()() {
            return Err(SceneError::Cancelled);
        }
        if changed() != before {
            return Ok(true);
        }
        std::thread::sleep(LOOK);
    }
    Ok(false)
}

/// The file's own name: short enough for a sentence, and unmistakable beside the scene's.
fn display(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn build(input: Input<'_>, watch: &mut Watch<'_>) -> Result<Scene, SceneError> {
    let sidecar_source = input.sidecar.as_ref().map(|(file, text)| Source { file, text });
    let sidecar = sidecar_source.map(|source| source.parse()).transpose()?;
    let Given { name, file, files, .. } = input.model;
    let Model {
        polygons,
        mut materials,
        textures,
        both_ways,
        lights,
        views: cameras,
        frame: own,
        files: named,
        mut findings,
    } = input.importer.read(input.model, &mut watch.part(0.0, READ))?;

    let stated = FrameChoice {
        unit: input.choice.unit.or(sidecar.as_ref().and_then(Sidecar::unit)).or(own.unit),
        up: input.choice.up.or(sidecar.as_ref().and_then(Sidecar::up)).or(own.up),
    };
    let (unit, up) = (stated.unit.unwrap_or_default(), stated.up.unwrap_or_default());
    let mut positions: Vec<DVec3> = polygons.positions.iter().map(|p| *p * unit.metres()).collect();
    if Aabb::around(positions.iter().copied()).diagonal() <= 0.0 {
        let message = "all corners lie in one point, so the model has no size";
        return Err(SceneError::file(file, message));
    }
    let emits: Vec<bool> = materials.exitance.iter().map(|e| e.iter().any(|e| *e > 0.0)).collect();
    let origin = origin(&polygons, &positions, &emits);
    positions.iter_mut().for_each(|p| *p -= origin);
    let mut repaired = repair_watched(&polygons, &positions, &emits, &mut watch.part(READ, REPAIRED))?;
    findings.append(&mut repaired.findings);
    let mut surfaces = repaired.surfaces;
    if surfaces.is_empty() {
        return Err(SceneError::NoArea { file: file.to_owned(), faces: polygons.faces.len() });
    }
    if let (Some(sidecar), Some(source)) = (&sidecar, sidecar_source) {
        sidecar.apply_materials(&mut materials.list, source, &mut findings)?;
    }
    let parts = Parts {
        positions: &positions,
        objects: &polygons.objects,
        given_objects: &polygons.given_objects,
        materials: &materials.list,
        exitance: &materials.exitance,
        partners: &sides::partners(&positions, &surfaces),
        both_ways: &both_ways,
        up,
    };
    let mut normals = repaired.normals;
    let entries = sidecar.as_ref().zip(sidecar_source);
    let mut photometric = PhotometricFiles::new(files);
    let luminaires = gather(&parts, &mut surfaces, &mut normals, entries, &mut photometric, &mut findings)?;

    watch.done(REPAIRED)?;
    let mut placed = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => {
            let entries = sidecar.lamps.as_deref().unwrap_or_default();
            lamp_entry::read(entries, (unit, up, origin), &luminaires, source, &mut photometric)?
        }
        _ => Vec::new(),
    };
    // Lamps that somebody has kept are those of the file as he wants them.
    let keeps_lamps = sidecar.as_ref().is_some_and(|sidecar| sidecar.lamps.is_some());
    if !keeps_lamps {
        placed = bare_lights::lamps(&lights, &luminaires, (unit, origin), &mut findings);
    }
    findings.extend(photometric.findings());

    let mut bookmarks = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => sidecar.views(source, unit, origin)?,
        _ => Vec::new(),
    };
    if bookmarks.is_empty() {
        bookmarks = views::of_cameras(&cameras, unit, origin);
    }
    let mut read_from = photometric.paths();
    read_from.extend(named);
    read_from.sort();
    read_from.dedup();
    let mut scene = Scene {
        name: name.to_owned(),
        source: input.source,
        unit,
        up,
        origin,
        positions,
        normals,
        uvs: polygons.uvs,
        surfaces,
        objects: polygons.objects,
        given_objects: polygons.given_objects,
        materials: materials.list,
        textures,
        luminaires,
        outdoors: None,
        placed: Vec::new(),
        views: bookmarks,
        start_view: 0,
        patch_size: sidecar.as_ref().and_then(|s| s.patch_size.as_ref()).map(|size| *size.get_ref()),
        has_lights: !lights.is_empty(),
        read_from,
        findings,
    };
    if let (Some(sidecar), Some(source)) = (&sidecar, sidecar_source)
        && let Some(choice) = &sidecar.daylight
    {
        let asked = outdoors::read(choice, files, source)?;
        scene.set_outdoors(asked);
    }
    judge(&mut scene, stated, sidecar.is_none());
    scene.place(placed);
    if let (Some(sidecar), Some(source)) = (&sidecar, sidecar_source)
        && let Some(start) = sidecar.start(&scene.views, source)?
    {
        scene.start_view = start;
    }
    Ok(scene)
}

/// Where positions are to count from: near the part that is looked at, where that is far away.
fn origin(polygons: &Polygons, positions: &[DVec3], emits: &[bool]) -> DVec3 {
    let footprint = |face: &Face| {
        let outline: Vec<DVec3> = face.corners.iter().map(|c| positions[c.0 as usize]).collect();
        Footprint::of(&outline, emits.get(face.material as usize).copied().unwrap_or(false))
    };
    Extent::of(&polygons.faces.iter().map(footprint).collect::<Vec<_>>()).origin()
}

/// Says what is doubtful about where and how large the model is, and makes up views where it has none.
fn judge(scene: &mut Scene, stated: FrameChoice, may_be_turned: bool) {
    let extent = scene.extent();
    let mut findings = Vec::new();
    extent::report(scene, &extent, &mut findings);
    let is_known = stated.unit.is_some() && stated.up.is_some() && !frame::is_absurd(&extent);
    if scene.views.is_empty() || !is_known {
        let space = Space::of(scene, &extent);
        let judgement = frame::judge(scene, &extent, &space, stated, may_be_turned);
        scene.up = judgement.up;
        findings.extend(judgement.findings);
        if scene.views.is_empty() {
            (scene.views, scene.start_view) = views::default_views(scene, &space, judgement.scale);
        }
    }
    scene.findings.append(&mut findings);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_request_to_end_is_obeyed_at_the_next_look_wherever_it_comes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("field.obj");
        let mut text = String::new();
        for k in 0..20_000 {
            let _ = writeln!(text, "v {k} 0 0\nv {k} 1 0\nv {k} 0 1\nf -3 -2 -1");
        }
        std::fs::write(&path, text).unwrap();
        let source = SceneSource::File(path);
        let looks = AtomicUsize::new(0);
        let count = || {
            looks.fetch_add(1, Ordering::Relaxed);
            false
        };
        let mut told = Vec::new();
        let mut report = |share| told.push(share);
        let scene = load_watched(&source, &mut Watch::new(&count, &mut report)).unwrap();
        assert_eq!(scene.surfaces.len(), 20_000);
        assert!(told.is_sorted() && told.last() >= Some(&REPAIRED), "shares rise");
        let all = looks.into_inner();
        assert!(all > 150, "looked at every few hundred lines and faces: {all}");
        for end in [0, all / 4, all / 2, 3 * all / 4, all - 1] {
            let looks = AtomicUsize::new(0);
            let cancelled = || looks.fetch_add(1, Ordering::Relaxed) >= end;
            let ended = load_watched(&source, &mut Watch::new(&cancelled, &mut |_| {}));
            assert_eq!(ended.err(), Some(SceneError::Cancelled), "after {end} of {all} looks");
            let further = looks.into_inner() - end;
            assert!(further <= 2, "{further} looks after the request");
        }
    }
}
