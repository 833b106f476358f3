//! The polygons of an OBJ file, from what its scan has left.

use super::error::SceneError;
use super::obj::{Face, Obj, Scan};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::hash::Hash;

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
pub(super) fn parse(file: &str, scan: Scan) -> Result<Obj, SceneError> {
    let numbered: String = (0..scan.materials.len()).map(|number| format!("newmtl {number}\n")).collect();
    let materials = tobj::load_mtl_buf(&mut numbered.as_bytes());
    let options = tobj::LoadOptions { triangulate: false, single_index: false, ..Default::default() };
    let (models, _) = tobj::load_obj_buf(&mut scan.clean.as_bytes(), &options, |_| materials.clone())
        .map_err(|error| SceneError::file(file, format!("the OBJ text cannot be parsed ({error})")))?;
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
