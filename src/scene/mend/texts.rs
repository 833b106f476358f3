//! The texts of a mended copy: its OBJ written anew, its library and sidecar taken over.

use super::library::{self, CopiedImage};
use crate::encoding::decode;
use crate::scene::error::SceneError;
use crate::scene::import::sidecar_path;
use crate::scene::library::{Block, Library, open};
use crate::scene::lookup::{Files, Found, read_plain};
use crate::scene::luminaires::turn;
use crate::scene::map::{Map, Placement, is_map};
use crate::scene::model::importer;
use crate::scene::selection::lamps_of_entries;
use crate::scene::sidecar::{EmitsKey, LuminaireEntry, Source};
use crate::scene::sidecar_write::sidecar_text;
use crate::scene::sides::partners;
use crate::scene::text::{keyword, logical_lines};
use crate::scene::types::{Scene, SceneSource, Surface};
use crate::scene::{builtin, corner_colours};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

/// What a copy takes over from the model.
#[derive(Default)]
pub(super) struct Originals {
    /// All libraries in one.
    pub(super) mtl: String,
    /// Images that the copy needs beside it.
    pub(super) images: Vec<CopiedImage>,
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
            return Ok(Originals { mtl: texts.mtl, sidecar, ..Originals::default() });
        }
    };
    let text = |path: &Path| bytes_of(path).map(|bytes| decode(&bytes).into_owned());
    let bytes = bytes_of(path)?;
    if !importer(path, &bytes).endings().contains(&"obj") {
        return of_others(scene, path, copy);
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let obj = decode(&bytes);
    let mut originals = Originals { sources: vec![path.clone()], ..Originals::default() };
    let lines: Vec<_> = logical_lines(&obj).map(|(_, line)| line).collect();
    let libraries =
        lines.iter().map(|line| keyword(line)).filter(|(word, name)| word == "mtllib" && !name.is_empty());
    let libraries: Vec<&str> = libraries.map(|(_, name)| name).collect();
    let uses_materials = lines.iter().any(|line| keyword(line).0 == "usemtl");
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    // A library that is not there was told by the reader.
    for found in open(&libraries, &stem, uses_materials, Files::beside(folder)).found {
        originals.take_library(&found, scene, folder, copy.parent().unwrap_or(Path::new("")))?;
        originals.sources.push(found.path);
    }
    // What the colours of corners were made into is in no library.
    let (mtl, images) = library::made(scene, copy, |material| material.name == corner_colours::NAME);
    originals.mtl += &mtl;
    originals.images = images;
    let sidecar = sidecar_path(path);
    if sidecar.exists() {
        let given = text(&sidecar)?;
        originals.sidecar =
            Some(originals.take_photometry(given, path, copy.parent().unwrap_or(Path::new(""))));
        originals.sources.push(sidecar);
    }
    Ok(originals)
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, SceneError> {
    read_plain(path).map_err(|error| SceneError::reading(path, &error))
}

/// What a copy of a model takes over that is no OBJ.
fn of_others(scene: &Scene, path: &Path, copy: &Path) -> Result<Originals, SceneError> {
    let (mtl, images) = library::made(scene, copy, |_| true);
    let sidecar = sidecar_path(path);
    let existing = match sidecar.exists() {
        true => Some(decode(&bytes_of(&sidecar)?).into_owned()),
        false => None,
    };
    let mut sources = vec![path.to_owned(), sidecar];
    sources.extend(scene.read_from.iter().cloned());
    let mut originals = Originals { mtl, images, sources, sidecar: None };
    let text = sidecar_text(scene, &scene.lighting(), &[], existing.as_deref())?;
    originals.sidecar = Some(originals.take_photometry(text, path, copy.parent().unwrap_or(Path::new(""))));
    Ok(originals)
}

impl Originals {
    /// The text of a sidecar with photometric files named by the way from the copy's folder.
    fn take_photometry(&mut self, text: String, model: &Path, copy: &Path) -> String {
        // It was read before; one that has been broken since stays as it is.
        let Ok(mut document) = text.parse::<toml_edit::DocumentMut>() else { return text };
        let files = Files::beside(model.parent().unwrap_or(Path::new("")));
        for key in ["luminaire", "lamp"] {
            let Some(entries) = document.get_mut(key).and_then(|item| item.as_array_of_tables_mut()) else {
                continue;
            };
            for entry in entries.iter_mut() {
                let Some(value) = entry.get_mut("photometry").and_then(|item| item.as_value_mut()) else {
                    continue;
                };
                let Some(name) = value.as_str().map(str::to_owned) else { continue };
                let Ok(found) = files.image(&name, model) else { continue };
                let mut moved = toml_edit::Value::from(moved(&name, &found, copy));
                *moved.decor_mut() = value.decor().clone();
                *value = moved;
                self.sources.push(found);
            }
        }
        document.to_string()
    }

    /// Adds a library; images are named by the way from the copy's folder.
    fn take_library(
        &mut self,
        library: &Found,
        scene: &Scene,
        folder: &Path,
        copy: &Path,
    ) -> Result<(), SceneError> {
        let text = decode(&library.bytes);
        let laid = placements(scene, library)?;
        let mut placement = Placement::default();
        for (_, line) in logical_lines(&text) {
            let (word, rest) = keyword(&line);
            if word == "newmtl" {
                placement = laid.get(rest).copied().unwrap_or_default();
            }
            if !is_map(&word) || rest.is_empty() {
                self.mtl += &line;
                self.mtl.push('\n');
                continue;
            }
            let mut map = Map::parse(rest);
            // The copy's texture coordinates are laid already as the image of the material asks for.
            map.placement = map.placement.after(&placement);
            let image = match Files::beside(folder).image(&map.image, &library.path) {
                Ok(found) => {
                    let moved = moved(&map.image, &found, copy);
                    self.sources.push(found);
                    moved
                }
                Err(_) => map.image.clone(),
            };
            let statement = line.split_whitespace().next().unwrap_or_default();
            self.mtl += &format!("{statement} {}\n", map.text(&image));
        }
        Ok(())
    }
}

/// How the images of a library's materials lie on their surfaces, by what `newmtl` says.
fn placements(scene: &Scene, library: &Found) -> Result<HashMap<String, Placement>, SceneError> {
    let mut read = Library::default();
    read.scan(&library.path, &decode(&library.bytes))?;
    let shown = |block: &&Block| {
        scene.materials.iter().any(|material| material.name == block.name && material.texture.is_some())
    };
    let laid = read.blocks.iter().filter(shown).filter_map(|block| {
        let (map, _) = block.image.as_ref()?;
        Some((block.given.clone(), map.placement))
    });
    Ok(laid.collect())
}

/// The name of an image, found at this path, from the folder of the copy.
fn moved(image: &str, found: &Path, copy: &Path) -> String {
    if Path::new(image).is_absolute() {
        return image.to_owned();
    }
    let folder = found.parent().unwrap_or(Path::new(""));
    match (way_between(copy, folder), found.file_name()) {
        (Some(way), Some(name)) => format!("{way}{}", name.to_string_lossy()),
        _ => image.to_owned(),
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
    // Every `o` begins another object, so that the faces of one stand together.
    let mut ordered: Vec<&Surface> = scene.surfaces.iter().collect();
    ordered.sort_by_key(|surface| surface.object);
    let (mut object, mut material) = (u32::MAX, u32::MAX);
    for surface in ordered {
        if surface.object != object {
            object = surface.object;
            line(&mut out, format_args!("o {}", scene.given_objects[object as usize]));
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
    let Some(made) = lamps_of_entries(scene, &sidecar) else { return Vec::new() };
    let is_back = |entry: &LuminaireEntry| entry.emits == Some(EmitsKey::Back);
    let entries = sidecar.luminaires.iter().zip(made).filter(|(entry, _)| is_back(entry.get_ref()));
    entries.flat_map(|(_, lamps)| lamps).map(|lamp| lamp as u32).collect()
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
