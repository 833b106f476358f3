//! One path from texts to a [`Scene`], for files and embedded scenes alike.

use super::error::SceneError;
use super::extent::{self, Extent, Footprint};
use super::finding::{Finding, FindingKind, Severity};
use super::lookup::{Files, read_complete};
use super::luminaires::{Parts, gather};
use super::mtl::Materials;
use super::obj::{Face, Obj};
use super::photometric::PhotometricFiles;
use super::repair::repair_watched;
use super::sidecar::{Sidecar, Source};
use super::space::Space;
use super::types::{FrameChoice, Scene, SceneSource};
use super::{builtin, frame, lamp_entry, mtl, names, obj, outdoors, polygons, sides, views};
use crate::geometry::Aabb;
use crate::memory;
use crate::watch::Watch;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Shares of the time by which the text is scanned, images are decoded, the text is parsed and the polygons are
/// repaired, about; the rest goes into lamps and views.
const SCANNED: f64 = 0.35;
const PICTURED: f64 = 0.45;
const PARSED: f64 = 0.8;
const REPAIRED: f64 = 0.95;

/// Bytes that reading takes for each of the file. Measured: 320 MB for a kitchen of 35 MB.
const BYTES_READING: f64 = 10.0;

/// Where a scene's texts come from.
struct Input<'a> {
    name: &'a str,
    source: SceneSource,
    /// What was asked for over the sidecar.
    choice: FrameChoice,
    /// Name of the OBJ in messages.
    obj_file: String,
    obj: &'a str,
    sidecar: Option<(String, String)>,
    /// Where material libraries and images are.
    files: Files<'a>,
}

/// Reads a scene: an OBJ file with the MTL, images and sidecar (`NAME.toml`) beside it, or an
/// embedded scene.
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
    let input = Input {
        name,
        source: SceneSource::Builtin(name.to_owned()),
        choice: FrameChoice::default(),
        obj_file: format!("{name}.obj"),
        obj,
        sidecar: sidecar_toml.map(|text| (format!("{name}.toml"), text.to_owned())),
        files: Files::Library(mtl),
    };
    Watch::nobody(|watch| build(input, watch))
}

/// The sidecar that belongs to an OBJ file: `NAME.toml` beside it.
pub fn sidecar_path(obj: &Path) -> PathBuf {
    obj.with_extension("toml")
}

fn load_file(path: &Path, choice: FrameChoice, watch: &mut Watch<'_>) -> Result<Scene, SceneError> {
    let size = std::fs::metadata(path).map_or(0, |file| file.len());
    memory::check(BYTES_READING * size as f64)
        .map_err(|shortage| SceneError::Memory { path: path.to_owned(), shortage })?;
    let mut bytes = read_complete(path).map_err(|error| SceneError::reading(path, &error))?;
    // A line that ends nowhere may be one that another program is writing, at its leisure.
    while !bytes.ends_with(b"\n") && rests_soon(path, watch)? {
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
    let input = Input {
        name: &name,
        source: SceneSource::File(path.to_owned()).framed(choice),
        choice,
        obj_file: display(path),
        obj: &crate::encoding::decode(&bytes),
        sidecar,
        files: Files::Folder { folder, cancelled },
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
    let scan = obj::scan(&input.obj_file, input.name, input.obj, &mut watch.part(0.0, SCANNED))?;
    let (mut materials, textures) = mtl::read(&scan, input.name, &input.obj_file, input.files)?;
    watch.done(PICTURED)?;
    let mut findings = scan.findings.clone();
    findings.append(&mut materials.findings);
    let mut obj = polygons::parse(&input.obj_file, scan, &mut watch.part(PICTURED, PARSED))?;
    assign_materials(&mut obj, &materials);
    findings.extend(images_without_coordinates(&obj, &materials));

    let stated = FrameChoice {
        unit: input.choice.unit.or(sidecar.as_ref().and_then(Sidecar::unit)),
        up: input.choice.up.or(sidecar.as_ref().and_then(Sidecar::up)),
    };
    let (unit, up) = (stated.unit.unwrap_or_default(), stated.up.unwrap_or_default());
    let mut positions: Vec<DVec3> = obj.positions.iter().map(|p| *p * unit.metres()).collect();
    if Aabb::around(positions.iter().copied()).diagonal() <= 0.0 {
        let message = "all corners lie in one point, so the model has no size";
        return Err(SceneError::file(&input.obj_file, message));
    }
    let emits: Vec<bool> = materials.exitance.iter().map(|e| e.iter().any(|e| *e > 0.0)).collect();
    let origin = origin(&obj, &positions, &emits);
    positions.iter_mut().for_each(|p| *p -= origin);
    let mut repaired = repair_watched(&obj, &positions, &emits, &mut watch.part(PARSED, REPAIRED))?;
    findings.append(&mut repaired.findings);
    let mut surfaces = repaired.surfaces;
    if surfaces.is_empty() {
        return Err(SceneError::NoArea { file: input.obj_file, faces: obj.faces.len() });
    }
    if let (Some(sidecar), Some(source)) = (&sidecar, sidecar_source) {
        sidecar.apply_materials(&mut materials.list, source, &mut findings)?;
    }
    let parts = Parts {
        positions: &positions,
        objects: &obj.objects,
        given_objects: &obj.given_objects,
        materials: &materials.list,
        exitance: &materials.exitance,
        partners: &sides::partners(&positions, &surfaces),
        up,
    };
    let mut normals = repaired.normals;
    let entries = sidecar.as_ref().zip(sidecar_source);
    let mut photometric = PhotometricFiles::new(input.files);
    let luminaires = gather(&parts, &mut surfaces, &mut normals, entries, &mut photometric, &mut findings)?;

    watch.done(REPAIRED)?;
    let placed = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => {
            lamp_entry::read(&sidecar.lamps, (unit, up, origin), &luminaires, source, &mut photometric)?
        }
        _ => Vec::new(),
    };
    findings.extend(photometric.findings());

    let bookmarks = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => sidecar.views(source, unit, origin)?,
        _ => Vec::new(),
    };
    let mut scene = Scene {
        name: input.name.to_owned(),
        source: input.source,
        unit,
        up,
        origin,
        positions,
        normals,
        uvs: obj.uvs,
        surfaces,
        objects: obj.objects,
        given_objects: obj.given_objects,
        materials: materials.list,
        textures: textures.list,
        luminaires,
        outdoors: None,
        placed: Vec::new(),
        views: bookmarks,
        start_view: 0,
        patch_size: sidecar.as_ref().and_then(|s| s.patch_size.as_ref()).map(|size| *size.get_ref()),
        photometric_files: photometric.paths(),
        findings,
    };
    if let (Some(sidecar), Some(source)) = (&sidecar, sidecar_source)
        && let Some(choice) = &sidecar.daylight
    {
        let asked = outdoors::read(choice, input.files, source)?;
        scene.set_outdoors(asked);
    }
    judge(&mut scene, stated);
    scene.place(placed);
    if let (Some(sidecar), Some(source)) = (&sidecar, sidecar_source)
        && let Some(start) = sidecar.start(&scene.views, source)?
    {
        scene.start_view = start;
    }
    Ok(scene)
}

/// Turns the numbers that materials have in the scan into those that they have in the list, and lays images
/// as their materials say.
fn assign_materials(obj: &mut Obj, materials: &Materials) {
    let mut laid: HashMap<(u32, u32), u32> = HashMap::new();
    for face in &mut obj.faces {
        face.material = materials.of_scan.get(face.material as usize).copied().unwrap_or(0);
        let placement = materials.placements.get(face.material as usize).copied().unwrap_or_default();
        if placement == Default::default() {
            continue;
        }
        for uv in face.corners.iter_mut().filter_map(|(_, _, uv)| uv.as_mut()) {
            *uv = *laid.entry((*uv, face.material)).or_insert_with(|| {
                let given = obj.uvs.get(*uv as usize).copied().unwrap_or(DVec2::ZERO);
                obj.uvs.push(placement.apply(given));
                obj.uvs.len() as u32 - 1
            });
        }
    }
}

/// Faces with an image and no texture coordinates: nothing says which part of it they show.
fn images_without_coordinates(obj: &Obj, materials: &Materials) -> Option<Finding> {
    let has_image = |material: u32| materials.list[material as usize].texture.is_some();
    let bare = |face: &&Face| face.corners.iter().any(|(_, _, uv)| uv.is_none());
    let faces: Vec<&Face> = obj.faces.iter().filter(|f| has_image(f.material)).filter(bare).collect();
    let first = faces.first()?;
    let names = names::list(faces.iter().map(|face| materials.list[face.material as usize].name.as_str()));
    let message = format!(
        "faces with an image have no texture coordinates ({}, first in line {}, of {names})",
        faces.len(),
        first.line
    );
    let finding = Finding::new(FindingKind::Material, Severity::Warning, message);
    Some(finding.counted(faces.len()).with("the mean of the image counts there"))
}

/// Where positions are to count from: near the part that is looked at, where that is far away.
fn origin(obj: &Obj, positions: &[DVec3], emits: &[bool]) -> DVec3 {
    let footprint = |face: &Face| {
        let outline: Vec<DVec3> = face.corners.iter().map(|c| positions[c.0 as usize]).collect();
        Footprint::of(&outline, emits.get(face.material as usize).copied().unwrap_or(false))
    };
    Extent::of(&obj.faces.iter().map(footprint).collect::<Vec<_>>()).origin()
}

/// Says what is doubtful about where and how large the model is, and makes up views where it has none.
fn judge(scene: &mut Scene, stated: FrameChoice) {
    let extent = scene.extent();
    let mut findings = Vec::new();
    extent::report(scene, &extent, &mut findings);
    let is_known = stated.unit.is_some() && stated.up.is_some() && !frame::is_absurd(&extent);
    if scene.views.is_empty() || !is_known {
        let space = Space::of(scene, &extent);
        let judgement = frame::judge(scene, &extent, &space, stated);
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
