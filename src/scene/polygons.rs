//! The polygons of an OBJ file, from what its scan has left.

use super::error::SceneError;
use super::model::{Face, Polygons, Pool, told_apart};
use super::obj::Scan;
use super::text::WatchedBytes;
use crate::watch::Watch;
use glam::{DVec2, DVec3};

/// Share of the time that `tobj` takes of parsing, about.
const PARSED: f64 = 0.7;

/// Lets `tobj` parse the clean text and gathers its models into one list of polygons.
///
/// # Errors
/// Text that `tobj` cannot parse, or the watch ended it.
pub(super) fn parse(file: &str, scan: Scan, watch: &mut Watch<'_>) -> Result<Polygons, SceneError> {
    let numbered: String = (0..scan.materials.len()).map(|number| format!("newmtl {number}\n")).collect();
    let materials = tobj::load_mtl_buf(&mut numbered.as_bytes());
    let options = tobj::LoadOptions { triangulate: false, single_index: false, ..Default::default() };
    let whole = scan.clean.as_bytes();
    let mut reader = WatchedBytes::new(whole, watch.part(0.0, PARSED));
    let parsed = tobj::load_obj_buf(&mut reader, &options, |_| materials.clone());
    watch.done(PARSED)?;
    let (models, _) =
        parsed.map_err(|error| SceneError::file(file, format!("the OBJ text cannot be parsed ({error})")))?;
    let objects = told_apart(&scan.objects);
    let mut obj = Polygons { objects, given_objects: scan.objects, ..Polygons::default() };
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
            obj.faces.push(Face { corners, object, material, line: Some(mark.line) });
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
