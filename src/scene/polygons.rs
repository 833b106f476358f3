//! The polygons of an OBJ file, from what its scan has left.

use super::error::SceneError;
use super::obj::{Face, Obj, Scan};
use crate::watch::Watch;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::hash::Hash;
use std::io::{self, BufRead, Read};

/// Bytes parsed between two looks at whether to go on.
const WATCHED_BYTES: usize = 1 << 16;
/// Share of the time that `tobj` takes of parsing, about.
const PARSED: f64 = 0.7;

/// Names that differ: those that several objects have are numbered from one.
fn told_apart(given: &[String]) -> Vec<String> {
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

/// Lets `tobj` parse the clean text and gathers its models into one list of polygons.
///
/// # Errors
/// Text that `tobj` cannot parse, or the watch ended it.
pub(super) fn parse(file: &str, scan: Scan, watch: &mut Watch<'_>) -> Result<Obj, SceneError> {
    let numbered: String = (0..scan.materials.len()).map(|number| format!("newmtl {number}\n")).collect();
    let materials = tobj::load_mtl_buf(&mut numbered.as_bytes());
    let options = tobj::LoadOptions { triangulate: false, single_index: false, ..Default::default() };
    let whole = scan.clean.as_bytes();
    let mut reader = WatchedText { whole, read: 0, watch: watch.part(0.0, PARSED) };
    let parsed = tobj::load_obj_buf(&mut reader, &options, |_| materials.clone());
    watch.done(PARSED)?;
    let (models, _) =
        parsed.map_err(|error| SceneError::file(file, format!("the OBJ text cannot be parsed ({error})")))?;
    let objects = told_apart(&scan.objects);
    let mut obj = Obj { objects, given_objects: scan.objects, ..Obj::default() };
    let (mut positions, mut normals, mut uvs) = (Pool::default(), Pool::default(), Pool::default());
    let mut marks = scan.marks.iter();
    let unexpected = || SceneError::file(file, "the parsed faces do not match those in the text");
    for model in &models {
        let mesh = &model.mesh;
        if mesh.indices.is_empty() {
            continue;
        }
        let object: u32 = model.name.parse().map_err(|_| unexpected())?;
        let material = mesh.material_id.ok_or_else(unexpected)? as u32;
        let place: Vec<u32> = triples(&mesh.positions).map(|p| positions.index(p)).collect();
        let normal: Vec<u32> = triples(&mesh.normals).map(|n| normals.index(n)).collect();
        let uv: Vec<u32> = mesh.texcoords.as_chunks::<2>().0.iter().map(|&t| uvs.index(t)).collect();
        watch.done(PARSED + (1.0 - PARSED) * obj.faces.len() as f64 / scan.marks.len() as f64)?;
        let mut start = 0;
        while start < mesh.indices.len() {
            let mark = *marks.next().ok_or_else(unexpected)?;
            let range = start..start + mark.corners as usize;
            start = range.end;
            let look_up = |list: &[u32], indices: &[u32], k: usize| -> Option<u32> {
                indices.get(k).and_then(|&i| list.get(i as usize)).copied()
            };
            let corners: Option<Vec<_>> = range
                .map(|k| {
                    let normal =
                        mark.has_normals.then(|| look_up(&normal, &mesh.normal_indices, k)).flatten();
                    let uv = mark.has_uvs.then(|| look_up(&uv, &mesh.texcoord_indices, k)).flatten();
                    Some((look_up(&place, &mesh.indices, k)?, normal, uv))
                })
                .collect();
            let corners = corners.ok_or_else(unexpected)?;
            obj.faces.push(Face { corners, object, material, line: mark.line });
        }
    }
    obj.positions = positions.values.into_iter().map(DVec3::from).collect();
    obj.normals = normals.values.into_iter().map(DVec3::from).collect();
    obj.uvs = uvs.values.into_iter().map(DVec2::from).collect();
    Ok(obj)
}

/// A text that is watched while it is read.
struct WatchedText<'a, 'w> {
    whole: &'a [u8],
    read: usize,
    watch: Watch<'w>,
}

impl BufRead for WatchedText<'_, '_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        let left = &self.whole[self.read..];
        let share = self.read as f64 / self.whole.len().max(1) as f64;
        self.watch.done(share).map_err(|_| io::Error::other("cancelled"))?;
        Ok(&left[..left.len().min(WATCHED_BYTES)])
    }

    fn consume(&mut self, amount: usize) {
        self.read = (self.read + amount).min(self.whole.len());
    }
}

impl Read for WatchedText<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

fn triples(flat: &[f64]) -> impl Iterator<Item = [f64; 3]> {
    flat.as_chunks::<3>().0.iter().copied()
}

/// Distinct values in the order of their first use.
struct Pool<const N: usize> {
    values: Vec<[f64; N]>,
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
    fn index(&mut self, value: [f64; N]) -> u32 {
        // Adding zero makes -0 equal to 0 bit for bit.
        *self.numbers.entry(value.map(|v| (v + 0.0).to_bits())).or_insert_with(|| {
            self.values.push(value);
            self.values.len() as u32 - 1
        })
    }
}
