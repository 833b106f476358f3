//! One path from texts to a [`Scene`], for files and embedded scenes alike.

use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::luminaires::{Parts, gather};
use super::repair::repair_watched;
use super::sidecar::{Sidecar, Source};
use super::types::{Scene, SceneSource};
use super::{builtin, mtl, names, obj, views};
use crate::geometry::Aabb;
use crate::watch::Watch;
use glam::DVec3;
use std::io;
use std::path::{Path, PathBuf};

/// Beyond these extents a wrong unit is likely, metres.
const LARGEST_EXTENT: f64 = 1e5;
const SMALLEST_EXTENT: f64 = 1e-4;

/// Shares of the time by which the text is scanned, images are decoded, the text is parsed and the polygons are
/// repaired, about; the rest goes into lamps and views.
const SCANNED: f64 = 0.35;
const PICTURED: f64 = 0.45;
const PARSED: f64 = 0.8;
const REPAIRED: f64 = 0.95;

/// Where a scene's texts come from.
struct Input<'a> {
    name: &'a str,
    source: SceneSource,
    /// Name of the OBJ in messages.
    obj_file: String,
    obj: &'a str,
    sidecar: Option<(String, String)>,
    /// Bytes of a material library or an image.
    read: &'a dyn Fn(&str) -> io::Result<Vec<u8>>,
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
        SceneSource::File(path) => load_file(path, watch),
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
    let read = |file: &str| {
        let is_image = [".png", ".jpg", ".jpeg"].iter().any(|end| file.to_ascii_lowercase().ends_with(end));
        if is_image { Err(io::ErrorKind::NotFound.into()) } else { Ok(mtl.as_bytes().to_vec()) }
    };
    let input = Input {
        name,
        source: SceneSource::Builtin(name.to_owned()),
        obj_file: format!("{name}.obj"),
        obj,
        sidecar: sidecar_toml.map(|text| (format!("{name}.toml"), text.to_owned())),
        read: &read,
    };
    Watch::nobody(|watch| build(input, watch))
}

/// The sidecar that belongs to an OBJ file: `NAME.toml` beside it.
pub fn sidecar_path(obj: &Path) -> PathBuf {
    obj.with_extension("toml")
}

fn load_file(path: &Path, watch: &mut Watch<'_>) -> Result<Scene, SceneError> {
    let bytes = read_file(path).map_err(|error| SceneError::reading(path, &error))?;
    let sidecar_path = sidecar_path(path);
    let sidecar = match read_file(&sidecar_path) {
        Ok(bytes) => Some((display(&sidecar_path), String::from_utf8_lossy(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(SceneError::reading(&sidecar_path, &error)),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let cancelled = watch.cancelled();
    let read = |file: &str| match cancelled() {
        true => Err(io::ErrorKind::Interrupted.into()),
        false => read_beside(folder, file),
    };
    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    let input = Input {
        name: &name,
        source: SceneSource::File(path.to_owned()),
        obj_file: display(path),
        obj: &String::from_utf8_lossy(&bytes),
        sidecar,
        read: &read,
    };
    build(input, watch)
}

/// The file's own name: short enough for a sentence, and unmistakable beside the scene's.
fn display(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

/// Reads a plain file; devices and pipes could go on for ever.
pub(super) fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a plain file"));
    }
    std::fs::read(path)
}

/// A file named in a model: as given, with `\` for `/`, or by its last part beside the model.
pub(super) fn read_beside(folder: &Path, file: &str) -> io::Result<Vec<u8>> {
    let slashed = file.replace('\\', "/");
    let last = slashed.rsplit('/').next().unwrap_or_default();
    let mut result = read_file(&folder.join(file));
    for other in [slashed.as_str(), last] {
        if result.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::NotFound) && other != file {
            result = read_file(&folder.join(other));
        }
    }
    result
}

fn build(input: Input<'_>, watch: &mut Watch<'_>) -> Result<Scene, SceneError> {
    let sidecar_source = input.sidecar.as_ref().map(|(file, text)| Source { file, text });
    let sidecar = sidecar_source.map(|source| source.parse()).transpose()?;
    let scan = obj::scan(&input.obj_file, input.name, input.obj, &mut watch.part(0.0, SCANNED))?;
    let (mut materials, textures) = mtl::read(&scan, &input.obj_file, input.read)?;
    watch.done(PICTURED)?;
    let mut findings = scan.findings.clone();
    findings.append(&mut materials.findings);
    let obj = match &materials.parsed {
        Some(parsed) => obj::parse(&input.obj_file, scan, parsed, &mut watch.part(PICTURED, PARSED))?,
        None => return Err(SceneError::file(&input.obj_file, "the materials were not parsed")),
    };

    let unit = sidecar.as_ref().map(Sidecar::unit).unwrap_or_default();
    let up = sidecar.as_ref().map(Sidecar::up).unwrap_or_default();
    let positions: Vec<DVec3> = obj.positions.iter().map(|p| *p * unit.metres()).collect();
    if Aabb::around(positions.iter().copied()).diagonal() <= 0.0 {
        let message = "all corners lie in one point, so the model has no size";
        return Err(SceneError::file(&input.obj_file, message));
    }
    let emits: Vec<bool> = materials.exitance.iter().map(|e| e.iter().any(|e| *e > 0.0)).collect();
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
        materials: &materials.list,
        exitance: &materials.exitance,
    };
    let mut normals = repaired.normals;
    let luminaires = gather(&parts, &mut surfaces, &mut normals, sidecar.as_ref().zip(sidecar_source))?;

    watch.done(REPAIRED)?;
    let bookmarks = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => sidecar.views(source)?,
        _ => Vec::new(),
    };
    let (views, first) = match bookmarks.is_empty() {
        true => views::default_views(&positions, &surfaces, up),
        false => (bookmarks, 0),
    };
    let start_view = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => sidecar.start(&views, source)?.unwrap_or(first),
        _ => first,
    };
    let mut scene = Scene {
        name: input.name.to_owned(),
        source: input.source,
        unit,
        up,
        positions,
        normals,
        uvs: obj.uvs,
        surfaces,
        objects: obj.objects,
        materials: materials.list,
        textures: textures.list,
        luminaires,
        views,
        start_view,
        patch_size: sidecar.and_then(|s| s.patch_size).map(|size| size.into_inner()),
        findings,
    };
    scene.findings.extend(absurd_size(&scene));
    Ok(scene)
}

fn absurd_size(scene: &Scene) -> Option<Finding> {
    let extent = scene.bounds().size().max_element();
    let side = if extent > LARGEST_EXTENT {
        "large"
    } else if extent < SMALLEST_EXTENT {
        "small"
    } else {
        return None;
    };
    let message = format!(
        "the model measures {extent:.3e} m, which is very {side} for a building; \
         set its unit (mm, cm, m, in or ft) in {}.toml if metres are wrong",
        scene.name
    );
    Some(Finding::new(FindingKind::Unit, Severity::Warning, message))
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
