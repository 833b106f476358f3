//! One path from texts to a [`Scene`], for files and embedded scenes alike.

use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::lookup::{Files, read_complete};
use super::luminaires::{Parts, gather};
use super::mtl::Materials;
use super::obj::Obj;
use super::repair::repair;
use super::sidecar::{Sidecar, Source};
use super::types::{Scene, SceneSource};
use super::{builtin, mtl, names, obj, polygons, text, views};
use crate::geometry::Aabb;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
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
    /// Where material libraries and images are.
    files: Files<'a>,
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
    build(Input {
        name,
        source: SceneSource::Builtin(name.to_owned()),
        obj_file: format!("{name}.obj"),
        obj,
        sidecar: sidecar_toml.map(|text| (format!("{name}.toml"), text.to_owned())),
        files: Files::Library(mtl),
    })
}

/// The sidecar that belongs to an OBJ file: `NAME.toml` beside it.
pub fn sidecar_path(obj: &Path) -> PathBuf {
    obj.with_extension("toml")
}

fn load_file(path: &Path) -> Result<Scene, SceneError> {
    let bytes = read_complete(path).map_err(|error| SceneError::reading(path, &error))?;
    let sidecar_path = sidecar_path(path);
    let sidecar = match read_complete(&sidecar_path) {
        Ok(bytes) => Some((display(&sidecar_path), text::decode(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(SceneError::reading(&sidecar_path, &error)),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy());
    build(Input {
        name: &name,
        source: SceneSource::File(path.to_owned()),
        obj_file: display(path),
        obj: &text::decode(&bytes),
        sidecar,
        files: Files::Folder(folder),
    })
}

/// The file's own name: short enough for a sentence, and unmistakable beside the scene's.
fn display(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn build(input: Input<'_>) -> Result<Scene, SceneError> {
    let sidecar_source = input.sidecar.as_ref().map(|(file, text)| Source { file, text });
    let sidecar = sidecar_source.map(|source| source.parse()).transpose()?;
    let scan = obj::scan(&input.obj_file, input.name, input.obj)?;
    let (mut materials, textures) = mtl::read(&scan, input.name, &input.obj_file, input.files)?;
    let mut findings = scan.findings.clone();
    findings.append(&mut materials.findings);
    let mut obj = polygons::parse(&input.obj_file, scan)?;
    assign_materials(&mut obj, &materials);
    findings.extend(images_without_coordinates(&obj, &materials));

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
        given_objects: &obj.given_objects,
        materials: &materials.list,
        exitance: &materials.exitance,
    };
    let mut normals = repaired.normals;
    let entries = sidecar.as_ref().zip(sidecar_source);
    let luminaires = gather(&parts, &mut surfaces, &mut normals, entries, &mut findings)?;

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
        given_objects: obj.given_objects,
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
    let bare = |face: &&obj::Face| face.corners.iter().any(|(_, _, uv)| uv.is_none());
    let faces: Vec<&obj::Face> = obj.faces.iter().filter(|f| has_image(f.material)).filter(bare).collect();
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
