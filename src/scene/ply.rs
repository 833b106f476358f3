//! Models in PLY (Turk 1994, "The PLY polygon file format"), in text or binary, with the colours, the normals and the
//! image that scanning programs write.

use super::corner_colours::{self, FaceColours};
use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::lookup::Files;
use super::model::{Face, Given, Importer, LARGEST_COORDINATE, LARGEST_UV, Model, Pool};
use super::mtl::DEFAULT_REFLECTANCE;
use super::names;
use super::text::WatchedBytes;
use super::textures::{Textures, srgb_to_linear};
use super::types::Material;
use crate::watch::Watch;
use glam::{DVec2, DVec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Header, Property, PropertyAccess, PropertyAccessResult};
use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::Path;

/// Share of the time by which the file is read; the rest makes polygons.
const READ: f64 = 0.8;
/// Faces made between two looks at whether to go on.
const WATCHED_FACES: usize = 4096;

pub(super) struct Ply;

impl Importer for Ply {
    fn endings(&self) -> &'static [&'static str] {
        &["ply"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
    }

    fn read(&self, given: Given<'_>, watch: &mut Watch<'_>) -> Result<Model, SceneError> {
        let (header, contents) = Contents::read(given, watch)?;
        Builder::new(given, contents).build(&header, watch)
    }
}

/// A vertex, as far as it is of use; what is not there is not a number.
#[derive(Clone, Copy)]
struct Vertex {
    position: DVec3,
    normal: DVec3,
    uv: DVec2,
    /// Codes from 0 to 1.
    colour: [f64; 3],
}

/// A face, or a strip of triangles.
#[derive(Default)]
struct Ring {
    corners: Vec<i64>,
    /// Two numbers for each corner.
    uvs: Vec<f64>,
    /// Codes from 0 to 1, where there are some.
    colour: Option<[f64; 3]>,
}

/// What is of no use here.
struct Other;

impl PropertyAccess for Vertex {
    fn new() -> Self {
        let nan = f64::NAN;
        Self { position: DVec3::NAN, normal: DVec3::NAN, uv: DVec2::NAN, colour: [nan; 3] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(value) = scalar(&property) else { return PropertyAccessResult::Ignored };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value,
            "ny" => self.normal.y = value,
            "nz" => self.normal.z = value,
            "u" | "s" | "texture_u" => self.uv.x = value,
            "v" | "t" | "texture_v" => self.uv.y = value,
            "red" | "r" | "diffuse_red" => self.colour[0] = code(&property),
            "green" | "g" | "diffuse_green" => self.colour[1] = code(&property),
            "blue" | "b" | "diffuse_blue" => self.colour[2] = code(&property),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Ring {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let band = match name {
            "vertex_indices" | "vertex_index" => {
                self.corners = list(&property).into_iter().map(|value| value as i64).collect();
                return PropertyAccessResult::Set;
            }
            "texcoord" => {
                self.uvs = list(&property);
                return PropertyAccessResult::Set;
            }
            "red" | "diffuse_red" => 0,
            "green" | "diffuse_green" => 1,
            "blue" | "diffuse_blue" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.colour.get_or_insert([1.0; 3])[band] = code(&property);
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Other {
    fn new() -> Self {
        Self
    }
}

fn scalar(property: &Property) -> Option<f64> {
    Some(match property {
        Property::Char(value) => f64::from(*value),
        Property::UChar(value) => f64::from(*value),
        Property::Short(value) => f64::from(*value),
        Property::UShort(value) => f64::from(*value),
        Property::Int(value) => f64::from(*value),
        Property::UInt(value) => f64::from(*value),
        Property::Float(value) => f64::from(*value),
        Property::Double(value) => *value,
        _ => return None,
    })
}

/// A part of a colour as a code from 0 to 1: whole numbers count up to the largest of their type.
fn code(property: &Property) -> f64 {
    let top = match property {
        Property::Char(_) | Property::UChar(_) => f64::from(u8::MAX),
        Property::Short(_) | Property::UShort(_) => f64::from(u16::MAX),
        Property::Int(_) | Property::UInt(_) => f64::from(u8::MAX),
        _ => 1.0,
    };
    scalar(property).map_or(f64::NAN, |value| value / top)
}

fn list(property: &Property) -> Vec<f64> {
    fn of<T: Copy + Into<f64>>(values: &[T]) -> Vec<f64> {
        values.iter().map(|value| (*value).into()).collect()
    }
    match property {
        Property::ListChar(values) => of(values),
        Property::ListUChar(values) => of(values),
        Property::ListShort(values) => of(values),
        Property::ListUShort(values) => of(values),
        Property::ListInt(values) => of(values),
        Property::ListUInt(values) => of(values),
        Property::ListFloat(values) => of(values),
        Property::ListDouble(values) => of(values),
        _ => Vec::new(),
    }
}

/// What stands in a file.
#[derive(Default)]
struct Contents {
    vertices: Vec<Vertex>,
    rings: Vec<Ring>,
}

impl Contents {
    fn read(given: Given<'_>, watch: &mut Watch<'_>) -> Result<(Header, Self), SceneError> {
        let fault = |error: &ParseError, watch: &mut Watch<'_>| match watch.done(0.0) {
            Err(cancelled) => cancelled.into(),
            Ok(()) => told(given.file, error),
        };
        let mut contents = Self::default();
        let ended = line_feeds(given.bytes);
        let bytes = WatchedBytes::new(&ended, watch.part(0.0, READ));
        let result = contents.read_all(&mut Reader::new(bytes));
        let header = result.map_err(|error| fault(&error, watch))?;
        Ok((header, contents))
    }

    fn read_all(&mut self, reader: &mut Reader<WatchedBytes<'_, '_>>) -> Result<Header, ParseError> {
        let header = Parser::<Other>::new().read_header(reader)?;
        for (name, element) in &header.elements {
            match name.as_str() {
                "vertex" => {
                    self.vertices = Parser::new().read_payload_for_element(reader, element, &header)?;
                }
                "face" => {
                    let faces = Parser::new().read_payload_for_element(reader, element, &header)?;
                    self.rings.extend::<Vec<Ring>>(faces);
                }
                "tristrips" => {
                    let strips = Parser::new().read_payload_for_element(reader, element, &header)?;
                    self.rings.extend::<Vec<Ring>>(strips.iter().flat_map(triangles).collect());
                }
                _ => drop(Parser::<Other>::new().read_payload_for_element(reader, element, &header)?),
            }
        }
        Ok(header)
    }
}

/// A file whose lines, or those of its head before binary numbers, end in a carriage return alone, as on old systems, with
/// line feeds instead.
fn line_feeds(bytes: &[u8]) -> Cow<'_, [u8]> {
    const END: &[u8] = b"end_header\r";
    let head = bytes.windows(END.len()).position(|window| window == END).map(|at| at + END.len());
    let Some(head) = head.filter(|&head| bytes.get(head) != Some(&b'\n')) else {
        return Cow::Borrowed(bytes);
    };
    let is_text = bytes[..head].windows(6).any(|window| window == b" ascii");
    let mut ended = bytes.to_vec();
    let part = if is_text { bytes.len() } else { head };
    ended[..part].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
    Cow::Owned(ended)
}

/// A fault of the parser in one sentence.
fn told(file: &str, error: &ParseError) -> SceneError {
    let text = error.to_string();
    let first = text.lines().next().unwrap_or_default();
    let message =
        first.strip_prefix("Line ").and_then(|rest| rest.split_once(": ")).map_or(first, |(_, rest)| rest);
    let message = match error.kind() {
        ErrorKind::UnexpectedEof => {
            "the file ends before all that its head announces; it is cut off".to_owned()
        }
        _ => format!("the PLY file cannot be parsed ({})", names::short(message.trim_end_matches('.'))),
    };
    match error.line() {
        Some(line) => SceneError::line(file, line, message),
        None => SceneError::file(file, message),
    }
}

/// The triangles of a strip, in which -1 begins another one.
fn triangles(strip: &Ring) -> Vec<Ring> {
    let mut rings = Vec::new();
    for part in strip.corners.split(|corner| *corner == -1) {
        for (k, corners) in part.windows(3).enumerate() {
            let mut corners = corners.to_vec();
            if k % 2 == 1 {
                corners.swap(0, 1);
            }
            rings.push(Ring { corners, ..Ring::default() });
        }
    }
    rings
}

/// Makes a model of what stands in a file.
struct Builder<'a> {
    given: Given<'a>,
    contents: Contents,
    model: Model,
    coloured: Vec<FaceColours>,
    short: usize,
    uncoloured: usize,
}

impl<'a> Builder<'a> {
    fn new(given: Given<'a>, contents: Contents) -> Self {
        Self { given, contents, model: Model::default(), coloured: Vec::new(), short: 0, uncoloured: 0 }
    }

    fn build(mut self, header: &Header, watch: &mut Watch<'_>) -> Result<Model, SceneError> {
        self.check(header)?;
        let name = self.given.name.to_owned();
        self.model.polygons.objects = vec![name.clone()];
        self.model.polygons.given_objects = vec![name];
        let texture = self.texture(header);
        self.add_plain(texture);
        let mut pools = (Pool::default(), Pool::default());
        let positions: Vec<u32> =
            self.contents.vertices.iter().map(|v| pools.0.index(v.position.to_array())).collect();
        let normals: Vec<Option<u32>> = self
            .contents
            .vertices
            .iter()
            .map(|v| v.normal.is_finite().then(|| pools.1.index(v.normal.to_array())))
            .collect();
        let rings = std::mem::take(&mut self.contents.rings);
        for (k, ring) in rings.iter().enumerate() {
            if k % WATCHED_FACES == 0 {
                watch.done(READ + (1.0 - READ) * k as f64 / rings.len() as f64)?;
            }
            self.add(k, ring, (&positions, &normals), texture.is_some())?;
        }
        let (positions, normals) = pools;
        self.model.polygons.positions = positions.values.into_iter().map(DVec3::from).collect();
        self.model.polygons.normals = normals.values.into_iter().map(DVec3::from).collect();
        self.finish(texture.is_some());
        Ok(self.model)
    }

    /// Whether there is anything to light, at places that can be.
    fn check(&self, header: &Header) -> Result<(), SceneError> {
        let file = self.given.file;
        if self.contents.rings.is_empty() {
            let what = match header.elements.get("vertex").map_or(0, |element| element.count) {
                0 => "the file holds no faces, so there is nothing to light",
                _ => {
                    "the file holds points and no faces, so there is nothing to light; make a mesh of the point cloud first"
                }
            };
            return Err(SceneError::file(file, what));
        }
        let is_place =
            |v: &Vertex| v.position.is_finite() && v.position.abs().max_element() <= LARGEST_COORDINATE;
        match self.contents.vertices.iter().position(|vertex| !is_place(vertex)) {
            Some(number) => {
                let message = format!("vertex {number} has no usable x, y and z; export the model again");
                Err(SceneError::file(file, message))
            }
            None => Ok(()),
        }
    }

    /// The image that MeshLab and photogrammetry programs name in a comment.
    fn texture(&mut self, header: &Header) -> Option<u32> {
        let name =
            header.comments.iter().find_map(|comment| comment.trim().strip_prefix("TextureFile "))?.trim();
        let more =
            header.comments.iter().filter(|comment| comment.trim().starts_with("TextureFile ")).count() - 1;
        if more > 0 {
            let message = format!(
                "of the images that the file names only the first is read ({more} more); faces with another one show parts of that"
            );
            self.model
                .findings
                .push(Finding::new(FindingKind::Material, Severity::Warning, message).counted(more));
        }
        let mut textures = Textures::default();
        let map = super::map::Map { image: name.to_owned(), ..Default::default() };
        let beside = match self.given.files {
            Files::Folder { folder, .. } => folder.join(self.given.file),
            Files::Library(_) => Path::new(self.given.file).to_owned(),
        };
        match textures.load(&map, &beside, self.given.files) {
            Ok(index) => {
                self.model.textures = textures.list;
                self.model.files.extend(self.given.files.image(name, &beside));
                Some(index)
            }
            Err(reason) => {
                let message = format!(
                    "the image '{}' cannot be used ({reason}), so that it does not count",
                    names::short(name)
                );
                self.model.findings.push(Finding::new(FindingKind::Material, Severity::Warning, message));
                None
            }
        }
    }

    fn add_plain(&mut self, texture: Option<u32>) {
        let plain = Material::plain(super::obj::NO_MATERIAL, DEFAULT_REFLECTANCE);
        let reflectance = if texture.is_some() { [1.0; 3] } else { plain.reflectance };
        self.model.materials.list.push(Material { texture, reflectance, ..plain });
        self.model.materials.exitance.push([0.0; 3]);
        self.model.materials.placements.push(Default::default());
    }

    fn add(
        &mut self,
        number: usize,
        ring: &Ring,
        (positions, normals): (&[u32], &[Option<u32>]),
        has_image: bool,
    ) -> Result<(), SceneError> {
        if ring.corners.len() < 3 {
            self.short += 1;
            return Ok(());
        }
        let vertices = &self.contents.vertices;
        let known = |corner: i64| usize::try_from(corner).ok().filter(|&corner| corner < vertices.len());
        let corners: Option<Vec<usize>> = ring.corners.iter().map(|&corner| known(corner)).collect();
        let Some(corners) = corners else {
            let message = format!(
                "face {number} asks for a vertex that is not among the {} of the file; it is damaged",
                vertices.len()
            );
            return Err(SceneError::file(self.given.file, message));
        };
        let smooth = corners.iter().all(|&corner| normals[corner].is_some());
        let of_ring = ring.uvs.len() == 2 * corners.len();
        let uv = |k: usize, corner: usize| match of_ring {
            true => DVec2::new(ring.uvs[2 * k], ring.uvs[2 * k + 1]),
            false => vertices[corner].uv,
        };
        let uvs: Vec<DVec2> = corners.iter().enumerate().map(|(k, &corner)| uv(k, corner)).collect();
        let is_laid =
            has_image && uvs.iter().all(|uv| uv.is_finite() && uv.abs().max_element() <= LARGEST_UV);
        let polygons = &mut self.model.polygons;
        let first_uv = polygons.uvs.len() as u32;
        if is_laid {
            polygons.uvs.extend(uvs);
        }
        let colours: Vec<[f64; 3]> =
            corners.iter().map(|&corner| ring.colour.unwrap_or(vertices[corner].colour)).collect();
        if !has_image && colours.iter().flatten().all(|code| code.is_finite()) {
            let linear = |code: &[f64; 3]| code.map(|code| srgb_to_linear(code.clamp(0.0, 1.0)) as f32);
            self.coloured.push((polygons.faces.len(), colours.iter().map(linear).collect()));
        } else {
            self.uncoloured += 1;
        }
        let corners = corners.iter().zip(0_u32..).map(|(&corner, k)| {
            (positions[corner], normals[corner].filter(|_| smooth), is_laid.then_some(first_uv + k))
        });
        polygons.faces.push(Face { corners: corners.collect(), object: 0, material: 0, line: None });
        Ok(())
    }

    fn finish(&mut self, has_image: bool) {
        let Self { model, coloured, short, uncoloured, .. } = self;
        let mut tell = |kind, severity, message: String, count: usize| {
            model.findings.push(Finding::new(kind, severity, message).counted(count));
        };
        if *short > 0 {
            let message = format!("faces with fewer than three corners were dropped ({short})");
            tell(FindingKind::Degenerate, Severity::Warning, message, *short);
        }
        if corner_colours::say_something(coloured) {
            let message = format!(
                "faces reflect by the colours of their corners, taken as sRGB ({})",
                names::grouped(coloured.len() as i64)
            );
            tell(FindingKind::Material, Severity::Note, message, coloured.len());
            let laid = std::mem::take(coloured);
            let material = Material::plain(corner_colours::NAME, DEFAULT_REFLECTANCE);
            let made = (&mut model.materials, &mut model.textures);
            corner_colours::lay(laid, material, [0.0; 3], &mut model.polygons, made);
        } else if !has_image {
            *uncoloured += coloured.len();
        }
        if *uncoloured > 0 && !has_image {
            let message = format!(
                "faces without a colour were taken as grey {DEFAULT_REFLECTANCE} ({})",
                names::grouped(*uncoloured as i64)
            );
            model
                .findings
                .push(Finding::new(FindingKind::Material, Severity::Warning, message).counted(*uncoloured));
        }
    }
}
