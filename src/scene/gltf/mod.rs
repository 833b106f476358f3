//! Models in glTF 2.0 (ISO/IEC 12113:2022), as JSON with buffers and images beside it or in it, or as one GLB file.
//!
//! Lengths are metres and +y is up, as the format defines. Emission counts in cd/m², lights without a surface
//! (KHR_lights_punctual) in candela.

mod accessor;
mod materials;
mod nodes;
mod sound;

use super::error::SceneError;
use super::lookup::{Files, reason};
use super::model::{Given, Importer, Model};
use super::names;
use super::types::{FrameChoice, LengthUnit, UpAxis};
use crate::watch::Watch;
use ::gltf::{Document, buffer::Source};
use data_url::DataUrl;
use std::path::{Path, PathBuf};

/// Extensions that a file may require: what they say is read, or changes nothing that is.
const KNOWN: [&str; 13] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "EXT_texture_webp",
    "KHR_materials_clearcoat",
];

/// Shares of the time by which buffers are there and images are decoded; the rest makes polygons.
const LOADED: f64 = 0.3;
const PICTURED: f64 = 0.6;

pub(super) struct Gltf;

impl Importer for Gltf {
    fn endings(&self) -> &'static [&'static str] {
        &["gltf", "glb"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(b"glTF")
    }

    fn is_whole(&self, bytes: &[u8]) -> bool {
        match bytes.strip_prefix(b"glTF") {
            // Version and length follow.
            Some([_, _, _, _, a, b, c, d, ..]) => {
                u32::from_le_bytes([*a, *b, *c, *d]) as usize <= bytes.len()
            }
            Some(_) => false,
            None => bytes.trim_ascii_end().ends_with(b"}"),
        }
    }

    fn read(&self, given: Given<'_>, watch: &mut Watch<'_>) -> Result<Model, SceneError> {
        let (document, blob) = parse(given)?;
        watch.done(0.1)?;
        let mut model = Model {
            frame: FrameChoice { unit: Some(LengthUnit::Metre), up: Some(UpAxis::Y) },
            ..Model::default()
        };
        let buffers = load(&document, blob, given, &mut model.files)?;
        watch.done(LOADED)?;
        for image in document.images() {
            if let ::gltf::image::Source::Uri { uri, .. } = image.source()
                && !is_data(uri)
            {
                // Also those that are of no use here are files of the model.
                model.files.extend(given.files.image(uri, Path::new(given.file)));
            }
        }
        let file = File { document: &document, buffers: &buffers, given };
        let painted = materials::read(&file, &mut model, &mut watch.part(LOADED, PICTURED))?;
        nodes::read(&file, painted, &mut model, &mut watch.part(PICTURED, 1.0))?;
        Ok(model)
    }
}

/// A file with all that it names.
struct File<'a> {
    document: &'a Document,
    buffers: &'a [Vec<u8>],
    given: Given<'a>,
}

/// The document, with nothing in it that points nowhere.
fn parse(given: Given<'_>) -> Result<(Document, Option<Vec<u8>>), SceneError> {
    let fail = |message: String| SceneError::file(given.file, message);
    if given.bytes.trim_ascii().is_empty() {
        return Err(SceneError::Empty(given.file.to_owned()));
    }
    let parsed =
        ::gltf::Gltf::from_slice_without_validation(given.bytes).map_err(|error| fault(given, &error))?;
    let mut root = parsed.document.into_json();
    let unknown: Vec<&String> =
        root.extensions_required.iter().filter(|name| !KNOWN.contains(&name.as_str())).collect();
    if !unknown.is_empty() {
        let is_packed = |name: &&String| name.contains("compression");
        let list = names::list(unknown.iter().map(|name| name.as_str()));
        return Err(fail(match unknown.iter().any(is_packed) {
            true => format!(
                "its meshes are compressed ({list}), which is not read; export the model without compression"
            ),
            false => format!("it cannot be read without {list}; export the model without that extension"),
        }));
    }
    // Those that are known here are more than those that the library knows.
    root.extensions_required.clear();
    sound::complete(&mut root).map_err(|what| fail(format!("it is damaged: {what}")))?;
    let document = Document::from_json(root).map_err(|error| fault(given, &error))?;
    Ok((document, parsed.blob))
}

fn fault(given: Given<'_>, error: &::gltf::Error) -> SceneError {
    let fail = |message: String| SceneError::file(given.file, message);
    match error {
        ::gltf::Error::Deserialize(error) => {
            let version = serde_json::from_slice::<serde_json::Value>(given.bytes).ok();
            let version = version.as_ref().and_then(|root| root["asset"]["version"].as_str());
            if version.is_some_and(|version| version.starts_with('1')) {
                return fail("this is glTF 1.0, and 2.0 is read; export the model again".to_owned());
            }
            let text = error.to_string();
            let what = text.split(" at line ").next().unwrap_or_default();
            let message = format!("this is no glTF that can be read ({})", names::short(what));
            match given.bytes.starts_with(b"glTF") {
                true => fail(message),
                false => SceneError::line(given.file, error.line(), message),
            }
        }
        ::gltf::Error::Validation(faults) => {
            let (place, what) =
                faults.first().map(|(path, fault)| (path.to_string(), fault.to_string())).unzip();
            let (place, what) = (place.unwrap_or_default(), what.unwrap_or_default().to_lowercase());
            fail(format!("it is damaged: {} is wrong ({})", names::short(&place), names::short(&what)))
        }
        error => {
            let what = error.to_string();
            fail(format!("the GLB file is damaged or cut off ({})", names::short(&what)))
        }
    }
}

/// The bytes of all buffers.
fn load(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    given: Given<'_>,
    files: &mut Vec<PathBuf>,
) -> Result<Vec<Vec<u8>>, SceneError> {
    let fail = |message: String| SceneError::file(given.file, message);
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let (bytes, name) = match buffer.source() {
            Source::Bin => (blob.take().unwrap_or_default(), "the binary part".to_owned()),
            Source::Uri(address) => {
                let shown = names::short(if is_data(address) { "data in it" } else { address });
                let read = resource(address, given.files, files);
                let read =
                    read.map_err(|why| fail(format!("its buffer '{shown}' cannot be read ({why})")))?;
                (read, format!("its buffer '{shown}'"))
            }
        };
        if bytes.len() < buffer.length() {
            return Err(fail(format!(
                "{name} is cut off: it has {} of {} bytes",
                names::grouped(bytes.len() as i64),
                names::grouped(buffer.length() as i64)
            )));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

/// A name that can stand in a line of text and at its end.
fn plain_name(name: &str) -> String {
    let one_line: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    one_line.trim().trim_end_matches('\\').trim().to_owned()
}

fn is_data(address: &str) -> bool {
    address.starts_with("data:")
}

/// What an address stands for, in the file or beside it; the error is the reason in a few words.
fn resource(address: &str, beside: Files<'_>, read: &mut Vec<PathBuf>) -> Result<Vec<u8>, String> {
    if is_data(address) {
        let url = DataUrl::process(address).map_err(|_| "its data are no data URL".to_owned())?;
        return Ok(url.decode_to_vec().map_err(|_| "its data are no base64".to_owned())?.0);
    }
    let found = beside.companion(address).map_err(|error| reason(&error))?;
    read.push(found.path);
    Ok(found.bytes)
}
