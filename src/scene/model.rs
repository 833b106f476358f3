//! What is read of a model file, whatever its format, and the one interface of those who read it.

use super::error::SceneError;
use super::finding::Finding;
use super::lookup::Files;
use super::mtl::Materials;
use super::types::{FrameChoice, Texture};
use super::{gltf, ply, wavefront};
use crate::watch::Watch;
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};
use std::hash::Hash;
use std::path::{Path, PathBuf};

/// No building comes near this, and squares of such lengths stay well within range.
pub(super) const LARGEST_COORDINATE: f64 = 1e12;
/// No image is repeated more often across a surface.
pub(super) const LARGEST_UV: f64 = 1e9;

/// Polygons in the order and the unit of their file.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    /// Distinct positions: corners at one place share an index.
    pub(super) positions: Vec<DVec3>,
    /// Distinct normals, as given.
    pub(super) normals: Vec<DVec3>,
    /// Distinct texture coordinates, v upwards.
    pub(super) uvs: Vec<DVec2>,
    pub(super) faces: Vec<Face>,
    /// Names that are shown and that differ from one another.
    pub(super) objects: Vec<String>,
    /// Names as the file gives them, which may be equal.
    pub(super) given_objects: Vec<String>,
}

/// A polygon as the file gives it.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Indices of position, normal and texture coordinates; each of the latter on all corners or on none.
    pub(super) corners: Vec<(u32, Option<u32>, Option<u32>)>,
    pub(super) object: u32,
    pub(super) material: u32,
    /// Line of the file, from one, where it has lines.
    pub(super) line: Option<u32>,
}

/// A light without a surface, in the coordinates and the unit of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BareLight {
    pub(super) name: String,
    pub(super) position: DVec3,
    /// Unit vector along which it shines.
    pub(super) aim: DVec3,
    /// Linear R, G, B, not all 0.
    pub(super) colour: [f64; 3],
    /// Luminous intensity along `aim`, candela; above 0.
    pub(super) candelas: f64,
    /// Half angles of a spot within which it shines fully, and outside of which it does not, radians; `None` of a
    /// light that shines all around.
    pub(super) cone: Option<[f64; 2]>,
}

/// A camera, in the coordinates and the unit of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ModelView {
    pub(super) name: String,
    pub(super) eye: DVec3,
    /// Unit vector.
    pub(super) forward: DVec3,
    /// Vertical field of view, degrees.
    pub(super) fov_y_deg: f64,
}

/// What an importer has read.
#[derive(Debug, Default)]
pub(super) struct Model {
    pub(super) polygons: Polygons,
    pub(super) materials: Materials,
    pub(super) textures: Vec<Texture>,
    /// Objects and materials whose faces glow to both sides.
    pub(super) both_ways: HashSet<(u32, u32)>,
    pub(super) lights: Vec<BareLight>,
    pub(super) views: Vec<ModelView>,
    /// Unit and axis that the format states.
    pub(super) frame: FrameChoice,
    /// Files that it was read from besides the model file and material libraries.
    pub(super) files: Vec<PathBuf>,
    pub(super) findings: Vec<Finding>,
}

/// A model file on its way in.
#[derive(Clone, Copy)]
pub(super) struct Given<'a> {
    /// Its name without the ending.
    pub(super) name: &'a str,
    /// Its name in messages.
    pub(super) file: &'a str,
    pub(super) bytes: &'a [u8],
    /// Those that it may name.
    pub(super) files: Files<'a>,
}

/// Reads models of one format.
pub(super) trait Importer: Sync {
    /// The endings of its files, in small letters.
    fn endings(&self) -> &'static [&'static str];

    /// Whether a file is of this format by what it begins with.
    fn recognises(&self, _bytes: &[u8]) -> bool {
        false
    }

    /// Whether a file seems to be written to its end.
    fn is_whole(&self, bytes: &[u8]) -> bool {
        bytes.ends_with(b"\n")
    }

    /// Reads a model. What can be repaired is, and is told in [`Model::findings`].
    ///
    /// # Errors
    /// Whatever makes the rest of no use, with the file, and the line where it has lines.
    fn read(&self, given: Given<'_>, watch: &mut Watch<'_>) -> Result<Model, SceneError>;
}

const IMPORTERS: [&dyn Importer; 3] = [&wavefront::Wavefront, &gltf::Gltf, &ply::Ply];

/// Endings of the files that can be read, in small letters.
pub const MODEL_ENDINGS: [&str; 4] = ["obj", "gltf", "glb", "ply"];

/// Whether a file is a model by its ending.
pub fn is_model_file(path: &Path) -> bool {
    ending(path).is_some_and(|ending| MODEL_ENDINGS.contains(&ending.as_str()))
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_string_lossy().to_lowercase())
}

/// Who reads a file: by its content, else by its ending, else as OBJ, which has no mark of its own.
pub(super) fn importer(path: &Path, bytes: &[u8]) -> &'static dyn Importer {
    let ending = ending(path).unwrap_or_default();
    let by_content = IMPORTERS.into_iter().find(|importer| importer.recognises(bytes));
    let by_ending = || IMPORTERS.into_iter().find(|importer| importer.endings().contains(&ending.as_str()));
    by_content.or_else(by_ending).unwrap_or(&wavefront::Wavefront)
}

/// Names that differ: those that several objects have are numbered from one.
pub(super) fn told_apart(given: &[String]) -> Vec<String> {
    let mut counts: HashMap<&str, usize> = HashMap::new();
    given.iter().for_each(|name| *counts.entry(name).or_default() += 1);
    let mut next: HashMap<&str, usize> = HashMap::new();
    let shown = given.iter().map(|name| {
        if counts[name.as_str()] == 1 {
            return name.clone();
        }
        let number = next.entry(name).or_default();
        loop {
            *number += 1;
            let numbered = format!("{name} {number}");
            if !counts.contains_key(numbered.as_str()) {
                return numbered;
            }
        }
    });
    shown.collect()
}

/// Distinct values in the order of their first use.
pub(super) struct Pool<const N: usize> {
    pub(super) values: Vec<[f64; N]>,
    numbers: HashMap<[u64; N], u32>,
}

impl<const N: usize> Default for Pool<N>
where
    [u64; N]: Hash + Eq,
{
    fn default() -> Self {
        Self { values: Vec::new(), numbers: HashMap::new() }
    }
}

impl<const N: usize> Pool<N> {
    /// Number of a value.
    pub(super) fn index(&mut self, value: [f64; N]) -> u32 {
        // Adding zero makes -0 equal to 0 bit for bit.
        *self.numbers.entry(value.map(|v| (v + 0.0).to_bits())).or_insert_with(|| {
            self.values.push(value);
            self.values.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_the_format_before_the_ending_does() {
        let endings = |path: &str, bytes: &[u8]| importer(Path::new(path), bytes).endings()[0];
        assert_eq!(endings("a.obj", b"v 0 0 0\n"), "obj");
        assert_eq!(endings("a.obj", b"glTF\x02\0\0\0"), "gltf");
        assert_eq!(endings("a.GLTF", b"{ \"asset\": {} }"), "gltf");
        assert_eq!(endings("a", b"ply\r\nformat ascii 1.0\r\n"), "ply");
        assert_eq!(endings("a.xyz", b"# anything"), "obj");
        let all: Vec<&str> = IMPORTERS.iter().flat_map(|importer| importer.endings()).copied().collect();
        assert_eq!(all, MODEL_ENDINGS);
        assert!(is_model_file(Path::new("a.GLB")) && !is_model_file(Path::new("a.mtl")));
    }
}
