//! One path from texts to a [`Scene`], for files and embedded scenes alike.

use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::luminaires::{Parts, gather};
use super::repair::repair;
use super::sidecar::{Sidecar, Source};
use super::types::{Scene, SceneSource};
use super::{builtin, mtl, names, obj, placed, views};
use crate::geometry::Aabb;
use glam::DVec3;
use std::io;
use std::path::{Path, PathBuf};

/// Beyond these extents a wrong unit is likely, metres.
const LARGEST_EXTENT: f64 = 1e5;
const SMALLEST_EXTENT: f64 = 1e-4;

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
    match source {
        SceneSource::File(path) => load_file(path),
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
    build(Input {
        name,
        source: SceneSource::Builtin(name.to_owned()),
        obj_file: format!("{name}.obj"),
        obj,
        sidecar: sidecar_toml.map(|text| (format!("{name}.toml"), text.to_owned())),
        read: &read,
    })
}

/// The sidecar that belongs to an OBJ file: `NAME.toml` beside it.
pub fn sidecar_path(obj: &Path) -> PathBuf {
    obj.with_extension("toml")
}

fn load_file(path: &Path) -> Result<Scene, SceneError> {
    let bytes = read_file(path).map_err(|error| SceneError::reading(path, &error))?;
    let sidecar_path = sidecar_path(path);
    let sidecar = match read_file(&sidecar_path) {
        Ok(bytes) => Some((display(&sidecar_path), String::from_utf8_lossy(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(SceneError::reading(&sidecar_path, &error)),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let read = |file: &str| read_beside(folder, file);
    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    build(Input {
        name: &name,
        source: SceneSource::File(path.to_owned()),
        obj_file: display(path),
        obj: &String::from_utf8_lossy(&bytes),
        sidecar,
        read: &read,
    })
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

fn build(input: Input<'_>) -> Result<Scene, SceneError> {
    let sidecar_source = input.sidecar.as_ref().map(|(file, text)| Source { file, text });
    let sidecar = sidecar_source.map(|source| source.parse()).transpose()?;
    let scan = obj::scan(&input.obj_file, input.name, input.obj)?;
    let (mut materials, textures) = mtl::read(&scan, &input.obj_file, input.read)?;
    let mut findings = scan.findings.clone();
    findings.append(&mut materials.findings);
    let obj = match &materials.parsed {
        Some(parsed) => obj::parse(&input.obj_file, scan, parsed)?,
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
    let mut repaired = repair(&obj, &positions, &emits);
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

    let placed = match (&sidecar, sidecar_source) {
        (Some(sidecar), Some(source)) => placed::read(&sidecar.lamps, (unit, up), &luminaires, source)?,
        _ => Vec::new(),
    };

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
        placed: Vec::new(),
        views,
        start_view,
        patch_size: sidecar.and_then(|s| s.patch_size).map(|size| size.into_inner()),
        findings,
    };
    scene.findings.extend(absurd_size(&scene));
    scene.place(placed);
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
