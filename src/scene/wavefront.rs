//! Models in Wavefront OBJ with the MTL and the images beside them.

use super::corner_colours;
use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::model::{Face, Given, Importer, Model, Polygons};
use super::mtl::{self, DEFAULT_REFLECTANCE, Materials};
use super::types::Material;
use super::{names, obj, polygons};
use crate::watch::Watch;
use glam::DVec2;
use std::collections::HashMap;

/// Shares of the time by which the text is scanned and images are decoded; the rest parses it.
const SCANNED: f64 = 0.44;
const PICTURED: f64 = 0.56;

pub(super) struct Wavefront;

impl Importer for Wavefront {
    fn endings(&self) -> &'static [&'static str] {
        &["obj"]
    }

    fn read(&self, given: Given<'_>, watch: &mut Watch<'_>) -> Result<Model, SceneError> {
        let text = crate::encoding::decode(given.bytes);
        let scan = obj::scan(given.file, given.name, &text, &mut watch.part(0.0, SCANNED))?;
        let (mut materials, textures) = mtl::read(&scan, given.name, given.file, given.files)?;
        watch.done(PICTURED)?;
        let mut findings = scan.findings.clone();
        findings.append(&mut materials.findings);
        let mut textures = textures.list;
        let mut scan = scan;
        let coloured = std::mem::take(&mut scan.coloured);
        let mut polygons = polygons::parse(given.file, scan, &mut watch.part(PICTURED, 1.0))?;
        assign_materials(&mut polygons, &materials);
        let made = (&mut materials, &mut textures);
        corner_colours::lay(
            coloured,
            Material::plain(corner_colours::NAME, DEFAULT_REFLECTANCE),
            [0.0; 3],
            &mut polygons,
            made,
        );
        findings.extend(images_without_coordinates(&polygons, &materials));
        Ok(Model { polygons, materials, textures, findings, ..Model::default() })
    }
}

/// Turns the numbers that materials have in the scan into those that they have in the list, and lays images
/// as their materials say.
fn assign_materials(polygons: &mut Polygons, materials: &Materials) {
    let mut laid: HashMap<(u32, u32), u32> = HashMap::new();
    for face in &mut polygons.faces {
        face.material = materials.of_scan.get(face.material as usize).copied().unwrap_or(0);
        let placement = materials.placements.get(face.material as usize).copied().unwrap_or_default();
        if placement == Default::default() {
            continue;
        }
        for uv in face.corners.iter_mut().filter_map(|(_, _, uv)| uv.as_mut()) {
            *uv = *laid.entry((*uv, face.material)).or_insert_with(|| {
                let given = polygons.uvs.get(*uv as usize).copied().unwrap_or(DVec2::ZERO);
                polygons.uvs.push(placement.apply(given));
                polygons.uvs.len() as u32 - 1
            });
        }
    }
}

/// Faces with an image and no texture coordinates: nothing says which part of it they show.
fn images_without_coordinates(polygons: &Polygons, materials: &Materials) -> Option<Finding> {
    let has_image = |material: u32| materials.list[material as usize].texture.is_some();
    let bare = |face: &&Face| face.corners.iter().any(|(_, _, uv)| uv.is_none());
    let faces: Vec<&Face> = polygons.faces.iter().filter(|f| has_image(f.material)).filter(bare).collect();
    let first = faces.first()?.line.map_or_else(String::new, |line| format!(", first in line {line}"));
    let names = names::list(faces.iter().map(|face| materials.list[face.material as usize].name.as_str()));
    let message =
        format!("faces with an image have no texture coordinates ({}{first}, of {names})", faces.len());
    let finding = Finding::new(FindingKind::Material, Severity::Warning, message);
    Some(finding.counted(faces.len()).with("the mean of the image counts there"))
}
