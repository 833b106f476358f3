//! The texts of a mended copy: its OBJ written anew, its library and sidecar taken over.

use crate::scene::builtin;
use crate::scene::error::SceneError;
use crate::scene::import::{read_beside, read_file, sidecar_path};
use crate::scene::luminaires::turn;
use crate::scene::mtl::{image_name, library_files};
use crate::scene::obj::{keyword, logical_lines};
use crate::scene::sidecar::{EmitsKey, Source};
use crate::scene::sides::partners;
use crate::scene::types::{Scene, SceneSource};
use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

/// What a copy takes over from the model.
pub(super) struct Originals {
    /// All libraries in one.
    pub(super) mtl: String,
    pub(super) sidecar: Option<String>,
    /// Files that were read, and images that the library names.
    pub(super) sources: Vec<PathBuf>,
}

/// Reads what a copy takes over.
pub(super) fn originals(scene: &Scene, copy: &Path) -> Result<Originals, SceneError> {
    let path = match &scene.source {
        SceneSource::File(path) | SceneSource::FileAs(path, _) => path,
        SceneSource::Builtin(name) => {
            let texts = builtin::source(name).ok_or_else(|| SceneError::UnknownBuiltin {
                name: name.clone(),
                known: builtin::NAMES.join(", "),
            })?;
            let sidecar = Some(texts.sidecar).filter(|text| !text.is_empty());
            return Ok(Originals { mtl: texts.mtl, sidecar, sources: Vec::new() });
        }
    };
    let text = |path: &Path| match read_file(path) {
        Ok(bytes) => Ok(String::from_utf8_lossy(&bytes).into_owned()),
        Err(error) => Err(SceneError::reading(path, &error)),
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let obj = text(path)?;
    let mut originals = Originals { mtl: String::new(), sidecar: None, sources: vec![path.clone()] };
    let way = way_between(copy.parent().unwrap_or(Path::new("")), folder);
    for (_, line) in logical_lines(&obj) {
        let ("mtllib", given) = keyword(&line) else { continue };
        for (file, content) in library_files(given, &|file| read_beside(folder, file)) {
            // A library that is not there was told by the reader.
            let Ok(bytes) = content else { continue };
            originals.sources.push(folder.join(&file));
            originals.take_library(&String::from_utf8_lossy(&bytes), folder, way.as_deref());
        }
    }
    let sidecar = sidecar_path(path);
    if sidecar.exists() {
        originals.sidecar = Some(text(&sidecar)?);
        originals.sources.push(sidecar);
    }
    Ok(originals)
}

impl Originals {
    /// Adds a library; images are named by the way from the copy's folder.
    fn take_library(&mut self, text: &str, folder: &Path, way: Option<&str>) {
        for (_, line) in logical_lines(text) {
            let (word, rest) = keyword(&line);
            if !word.starts_with("map_") && !matches!(word, "bump" | "disp" | "refl" | "norm") {
                self.mtl += &line;
                self.mtl.push('\n');
                continue;
            }
            let image = image_name(rest);
            let slashed = image.replace('\\', "/");
            let last = slashed.rsplit('/').next().unwrap_or_default();
            // The same order in which the reader looks for it.
            let found =
                [image.as_str(), slashed.as_str(), last].into_iter().find(|f| folder.join(f).is_file());
            self.sources.extend(found.map(|file| folder.join(file)));
            let bare = rest.trim_end_matches('"');
            let options = bare.strip_suffix(image.as_str()).unwrap_or_default().trim_end_matches('"');
            let moved = match (found, way) {
                (Some(file), Some(way)) if !Path::new(file).is_absolute() => format!("{way}{file}"),
                _ => image,
            };
            self.mtl += &format!("{word} {options}{moved}\n");
        }
    }
}

/// The way from one folder to another as it stands before a file name: empty for the same folder, else
/// with a slash at its end. `None` where a folder cannot be found.
fn way_between(from: &Path, to: &Path) -> Option<String> {
    let whole = |folder: &Path| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folder.canonicalize().ok()
    };
    let (from, to) = (whole(from)?, whole(to)?);
    let (from, to): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (from.components().collect(), to.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let mut way = "../".repeat(from.len() - common);
    for part in &to[common..] {
        way += &format!("{}/", part.as_os_str().to_string_lossy());
    }
    Some(way)
}

/// The OBJ text of a scene, in the unit of its file.
pub(super) fn obj(scene: &Scene, originals: &Originals, copy: &Path) -> String {
    // Surfaces that emit from the back were turned when they were read, and will be again.
    let mut scene = scene.clone();
    let from_the_back = back_emitters(&scene, originals);
    let partners = partners(&scene.positions, &scene.surfaces);
    let lamps: Vec<Option<u32>> = scene.surfaces.iter().map(|s| s.luminaire).collect();
    let is_turned = |lamp: Option<u32>| lamp.is_some_and(|lamp| from_the_back.contains(&lamp));
    for ((surface, &lamp), partner) in scene.surfaces.iter_mut().zip(&lamps).zip(&partners) {
        if is_turned(lamp) || partner.is_some_and(|other| is_turned(lamps[other as usize])) {
            turn(surface, &mut scene.normals);
        }
    }
    let library = copy.with_extension("mtl");
    let library = library.file_name().unwrap_or_default().to_string_lossy();
    let mut out = format!("# A repaired copy of {}\nmtllib {library}\n", scene.name);
    let mut numbers =
        [vec![0_u32; scene.positions.len()], vec![0_u32; scene.uvs.len()], vec![0_u32; scene.normals.len()]];
    let mut counts = [0_u32; 3];
    for corner in scene.surfaces.iter().flat_map(|s| &s.corners) {
        let indices = [Some(corner.position), corner.uv, corner.normal];
        for (kind, index) in indices.into_iter().enumerate() {
            let Some(index) = index.map(|i| i as usize).filter(|&i| numbers[kind][i] == 0) else { continue };
            counts[kind] += 1;
            numbers[kind][index] = counts[kind];
            let values = match kind {
                0 => scene.in_file(scene.positions[index]).to_array().map(number).join(" "),
                1 => scene.uvs[index].to_array().map(number).join(" "),
                _ => scene.normals[index].to_array().map(number).join(" "),
            };
            line(&mut out, format_args!("{} {values}", ["v", "vt", "vn"][kind]));
        }
    }
    let (mut object, mut material) = (u32::MAX, u32::MAX);
    for surface in &scene.surfaces {
        if surface.object != object {
            object = surface.object;
            line(&mut out, format_args!("o {}", scene.objects[object as usize]));
        }
        if surface.material != material {
            material = surface.material;
            line(&mut out, format_args!("usemtl {}", scene.materials[material as usize].name));
        }
        out.push('f');
        for corner in &surface.corners {
            let position = numbers[0][corner.position as usize];
            let uv = corner.uv.map(|i| numbers[1][i as usize]);
            let normal = corner.normal.map(|i| numbers[2][i as usize]);
            out += &match (uv, normal) {
                (None, None) => format!(" {position}"),
                (Some(uv), None) => format!(" {position}/{uv}"),
                (None, Some(normal)) => format!(" {position}//{normal}"),
                (Some(uv), Some(normal)) => format!(" {position}/{uv}/{normal}"),
            };
        }
        out.push('\n');
    }
    out
}

/// Lamps that the sidecar has emit from the back.
fn back_emitters(scene: &Scene, originals: &Originals) -> Vec<u32> {
    let Some(text) = &originals.sidecar else { return Vec::new() };
    let file = format!("{}.toml", scene.name);
    // It was read before; one that has been broken since turns nothing.
    let Ok(sidecar) = Source { file: &file, text }.parse() else { return Vec::new() };
    let is_back = |entry: &toml::Spanned<_>| {
        let entry: &crate::scene::sidecar::LuminaireEntry = entry.get_ref();
        entry.emits == Some(EmitsKey::Back)
    };
    let numbered = (0_u32..).zip(&sidecar.luminaires);
    numbered.filter(|(_, entry)| is_back(entry)).map(|(number, _)| number).collect()
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = out.write_fmt(text);
    out.push('\n');
}

/// Fifteen digits at most: what a change of unit adds beyond them is rounding.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.14e}").parse().unwrap_or(value);
    // Adding zero makes -0 a plain one.
    format!("{}", rounded + 0.0)
}
