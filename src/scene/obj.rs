//! OBJ text to polygons. `tobj` parses; the scan before it finds what `tobj` cannot tell: line
//! numbers, which indices and numbers are wrong, objects apart from groups, unknown materials.
//!
//! The scan writes a clean text for `tobj`: continuation lines joined, comments cut, faces with
//! fewer than three corners and all lines but `v`, `vt`, `vn`, `f` left out, and `o N` with the
//! number of an entry in [`Obj::objects`] before the faces that belong to it.

use super::error::SceneError;
use super::finding::{Finding, FindingKind, MOST_PLACES, Places, Severity};
use super::names;
use crate::watch::Watch;
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::hash::Hash;
use std::io::{self, BufRead, Read};

/// Name of the material of faces that name none.
pub(super) const NO_MATERIAL: &str = "default";

/// No building comes near this, and squares of such lengths stay well within range.
const LARGEST_COORDINATE: f64 = 1e12;

/// Lines scanned and bytes parsed between two looks at whether to go on.
const WATCHED_LINES: usize = 1024;
const WATCHED_BYTES: usize = 1 << 16;
/// Share of the time that `tobj` takes of parsing, about.
const PARSED: f64 = 0.7;

/// The polygons of a file, in its own unit and in its order.
#[derive(Clone, Debug, Default)]
pub(super) struct Obj {
    /// Distinct positions: corners at one place share an index.
    pub(super) positions: Vec<DVec3>,
    /// Distinct normals, as given.
    pub(super) normals: Vec<DVec3>,
    pub(super) uvs: Vec<DVec2>,
    pub(super) faces: Vec<Face>,
    pub(super) objects: Vec<String>,
}

/// A polygon as the file gives it.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Indices of position, normal and texture coordinates; the latter on all corners or on none.
    pub(super) corners: Vec<(u32, Option<u32>, Option<u32>)>,
    pub(super) object: u32,
    pub(super) material: u32,
    /// Line of the file, from one.
    pub(super) line: u32,
}

/// What the scan of the text found.
#[derive(Debug, Default)]
pub(super) struct Scan {
    clean: String,
    marks: Vec<Mark>,
    objects: Vec<String>,
    /// Material libraries with their lines.
    pub(super) libraries: Vec<(String, usize)>,
    /// Materials that faces use, each once, in order.
    pub(super) materials: Vec<String>,
    pub(super) findings: Vec<Finding>,
}

/// What is known of a face besides what `tobj` tells.
#[derive(Clone, Copy, Debug)]
struct Mark {
    line: u32,
    corners: u32,
    has_uvs: bool,
    has_normals: bool,
}

/// Splits text into logical lines: continuations joined, each with its (first) number from one.
pub(super) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, std::borrow::Cow<'_, str>)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut line = std::borrow::Cow::Borrowed(first.trim());
        while line.ends_with('\\') {
            let joined = line.to_mut();
            joined.pop();
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(_, next)| next.trim()));
        }
        Some((index + 1, line))
    })
}

/// The first word of a line and the trimmed rest.
pub(super) fn keyword(line: &str) -> (&str, &str) {
    match line.split_once(char::is_whitespace) {
        Some((word, rest)) => (word, rest.trim()),
        None => (line, ""),
    }
}

/// The words of a line up to a comment.
pub(super) fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// Reads the text once, checks every line that matters and writes a clean one.
pub(super) fn scan(
    file: &str,
    default_object: &str,
    text: &str,
    watch: &mut Watch<'_>,
) -> Result<Scan, SceneError> {
    Scanner { file, default_object, ..Scanner::default() }.run(text, watch)
}

#[derive(Default)]
struct Scanner<'a> {
    file: &'a str,
    default_object: &'a str,
    scan: Scan,
    positions: usize,
    uvs: usize,
    normals: usize,
    object: String,
    group: String,
    object_numbers: HashMap<String, usize>,
    known_materials: HashSet<String>,
    /// Number of the object that the clean text is in, and its material.
    current_object: Option<usize>,
    current_material: Option<String>,
    names_changed: bool,
    material_changed: bool,
    any_face: bool,
    /// Their lines.
    short_faces: Vec<u32>,
    unread: Vec<String>,
    broken_normals: usize,
}

impl Scanner<'_> {
    fn run(mut self, text: &str, watch: &mut Watch<'_>) -> Result<Scan, SceneError> {
        (self.names_changed, self.material_changed) = (true, true);
        self.scan.clean.reserve(text.len() + text.len() / 16);
        self.scan.clean.push_str("mtllib materials\n");
        let mut anything = false;
        for (line, content) in logical_lines(text) {
            if line % WATCHED_LINES == 0 {
                // The clean text is about as long.
                watch.done((self.scan.clean.len() as f64 / text.len() as f64).min(1.0))?;
            }
            let (word, rest) = keyword(&content);
            anything |= !word.is_empty();
            match word {
                "v" => self.vector::<3>(line, "v", rest)?,
                "vn" => self.vector::<3>(line, "vn", rest)?,
                "vt" => self.vector::<2>(line, "vt", rest)?,
                "f" | "fo" => self.face(line, rest)?,
                "o" => {
                    self.object = rest.split_whitespace().collect::<Vec<_>>().join(" ");
                    self.group.clear();
                    self.names_changed = true;
                }
                "g" => {
                    self.group = rest.split_whitespace().collect::<Vec<_>>().join(" ");
                    self.names_changed = true;
                }
                "usemtl" => {
                    self.current_material = Some(rest.to_owned()).filter(|name| !name.is_empty());
                    self.material_changed = true;
                }
                "mtllib" if rest.is_empty() => {
                    let message = "'mtllib' names no file; name an MTL file or remove the line";
                    return Err(SceneError::line(self.file, line, message));
                }
                "mtllib" => self.scan.libraries.push((rest.to_owned(), line)),
                // Lines, points and smoothing groups carry no area; comments are skipped.
                "" | "s" | "l" | "p" | "lod" | "vp" => {}
                _ if word.starts_with('#') => {}
                _ => self.unread.push(word.to_owned()),
            }
        }
        if !anything {
            return Err(SceneError::Empty(self.file.to_owned()));
        }
        if !self.any_face {
            return Err(SceneError::NoFaces(self.file.to_owned()));
        }
        self.report();
        Ok(self.scan)
    }

    fn report(&mut self) {
        let short = self.short_faces.len();
        if let Some(first) = self.short_faces.first() {
            let message =
                format!("faces with fewer than three corners were dropped ({short}, first in line {first})");
            let lines = self.short_faces.iter().copied().take(MOST_PLACES).collect();
            self.scan.findings.push(
                Finding::new(FindingKind::Degenerate, Severity::Warning, message)
                    .counted(short)
                    .with("they have no area to carry light")
                    .at(Places { lines, ..Places::default() }),
            );
        }
        if self.broken_normals > 0 {
            let message =
                format!("vertex normals that are no numbers were ignored ({})", self.broken_normals);
            self.scan.findings.push(
                Finding::new(FindingKind::Normals, Severity::Warning, message)
                    .counted(self.broken_normals)
                    .with("their faces are shaded flat"),
            );
        }
        if !self.unread.is_empty() {
            let count = self.unread.len();
            let kinds = names::list(self.unread.iter().map(String::as_str));
            let message =
                format!("lines that start with {kinds} are not polygons and were skipped ({count})");
            self.scan.findings.push(Finding::new(FindingKind::File, Severity::Note, message).counted(count));
        }
    }

    /// A `v`, `vt` or `vn` line; what follows the first N numbers (w, vertex colours) has no use here.
    fn vector<const N: usize>(&mut self, line: usize, kind: &str, rest: &str) -> Result<(), SceneError> {
        let mut values = [0.0_f64; N];
        let mut count = 0;
        for (value, word) in values.iter_mut().zip(words(rest)) {
            *value = word.parse().map_err(|_| {
                let message = format!("'{}' is not a number", names::short(word));
                SceneError::line(self.file, line, message)
            })?;
            count += 1;
        }
        // A texture coordinate may come without its second number.
        let needed = if kind == "vt" { 1 } else { N };
        if count < needed {
            let message = format!("'{kind}' needs {needed} numbers and has {count}; the line seems cut off");
            return Err(SceneError::line(self.file, line, message));
        }
        if values.iter().any(|v| !v.is_finite()) {
            if kind == "v" {
                let message = "a coordinate is not a finite number; export the model again";
                return Err(SceneError::line(self.file, line, message));
            }
            self.broken_normals += usize::from(kind == "vn");
            values = [0.0; N];
        }
        if kind == "v"
            && let Some(large) = values.iter().find(|v| v.abs() > LARGEST_COORDINATE)
        {
            let message = format!("the coordinate {large:e} is larger than any building");
            return Err(SceneError::line(self.file, line, message));
        }
        match kind {
            "v" => self.positions += 1,
            "vt" => self.uvs += 1,
            _ => self.normals += 1,
        }
        self.scan.clean.push_str(kind);
        for value in values {
            let _ = write!(self.scan.clean, " {value:e}");
        }
        self.scan.clean.push('\n');
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &str) -> Result<(), SceneError> {
        self.any_face = true;
        let mut corners = Vec::with_capacity(4);
        for word in words(rest) {
            corners.push(self.corner(line, word)?);
        }
        if corners.len() < 3 {
            self.short_faces.push(line as u32);
            return Ok(());
        }
        self.open_object();
        let has_uvs = corners.iter().all(|c| c[1].is_some());
        let has_normals = corners.iter().all(|c| c[2].is_some());
        self.scan.marks.push(Mark { line: line as u32, corners: corners.len() as u32, has_uvs, has_normals });
        self.scan.clean.push('f');
        for [position, uv, normal] in corners {
            let _ = write!(self.scan.clean, " {}", position.unwrap_or(0) + 1);
            match (uv.filter(|_| has_uvs), normal.filter(|_| has_normals)) {
                (Some(uv), Some(normal)) => _ = write!(self.scan.clean, "/{}/{}", uv + 1, normal + 1),
                (Some(uv), None) => _ = write!(self.scan.clean, "/{}", uv + 1),
                (None, Some(normal)) => _ = write!(self.scan.clean, "//{}", normal + 1),
                (None, None) => {}
            }
        }
        self.scan.clean.push('\n');
        Ok(())
    }

    /// Indices from zero of `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, line: usize, word: &str) -> Result<[Option<usize>; 3], SceneError> {
        let kinds = [("vertex", self.positions), ("texture coordinate", self.uvs), ("normal", self.normals)];
        let mut corner = [None; 3];
        for (k, part) in word.split('/').enumerate() {
            let Some((kind, count)) = kinds.get(k) else {
                let message = format!("the corner '{}' has more than three indices", names::short(word));
                return Err(SceneError::line(self.file, line, message));
            };
            if part.is_empty() && k > 0 {
                continue;
            }
            let index: i64 = part.parse().map_err(|_| {
                let message = format!("the corner '{}' is not made of whole numbers", names::short(word));
                SceneError::line(self.file, line, message)
            })?;
            let resolved = match index {
                1.. => usize::try_from(index - 1).ok(),
                0 => None,
                _ => usize::try_from(index.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
            };
            corner[k] = resolved.filter(|i| i < count);
            if corner[k].is_none() {
                let message = format!(
                    "the face asks for {kind} {index}, and {count} of them stand above it; the file is cut off or damaged"
                );
                return Err(SceneError::line(self.file, line, message));
            }
        }
        Ok(corner)
    }

    /// Writes the object and material of the next face where they changed.
    fn open_object(&mut self) {
        if self.names_changed {
            self.names_changed = false;
            let name = match (self.object.as_str(), self.group.as_str()) {
                ("", "") => self.default_object.to_owned(),
                ("", group) => group.to_owned(),
                (object, group) if group.is_empty() || group == object => object.to_owned(),
                (object, group) => format!("{object}/{group}"),
            };
            let objects = &mut self.scan.objects;
            let number = *self.object_numbers.entry(name).or_insert_with_key(|name| {
                objects.push(name.clone());
                objects.len() - 1
            });
            if self.current_object != Some(number) {
                self.current_object = Some(number);
                let _ = writeln!(self.scan.clean, "o {number}");
            }
        }
        if self.material_changed {
            self.material_changed = false;
            let name = self.current_material.as_deref().unwrap_or(NO_MATERIAL);
            if self.known_materials.insert(name.to_owned()) {
                self.scan.materials.push(name.to_owned());
            }
            let _ = writeln!(self.scan.clean, "usemtl {name}");
        }
    }
}

/// Lets `tobj` parse the clean text and gathers its models into one list of polygons.
///
/// `materials` holds every material that the scan found in use.
pub(super) fn parse(
    file: &str,
    scan: Scan,
    materials: &tobj::MTLLoadResult,
    watch: &mut Watch<'_>,
) -> Result<Obj, SceneError> {
    let options = tobj::LoadOptions { triangulate: false, single_index: false, ..Default::default() };
    let whole = scan.clean.as_bytes();
    let mut reader = WatchedText { whole, read: 0, watch: watch.part(0.0, PARSED) };
    let parsed = tobj::load_obj_buf(&mut reader, &options, |_| materials.clone());
    watch.done(PARSED)?;
    let (models, _) =
        parsed.map_err(|error| SceneError::file(file, format!("the OBJ text cannot be parsed ({error})")))?;
    let mut obj = Obj { objects: scan.objects, ..Obj::default() };
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<(Obj, Vec<String>), SceneError> {
        let scan = Watch::nobody(|watch| scan("t.obj", "t", text, watch))?;
        let names = scan.materials.clone();
        let mtl: String = names.iter().map(|n| format!("newmtl {n}\n")).collect();
        let materials = tobj::load_mtl_buf(&mut mtl.as_bytes());
        Watch::nobody(|watch| parse("t.obj", scan, &materials, watch)).map(|obj| (obj, names))
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn objects_groups_and_materials_keep_their_names() {
        let text = format!(
            "{SQUARE}usemtl a b\nf 1 2 3\no house\ng kitchen\nf 1 2 3 4\nusemtl c\nf 1 3 4\ng hall\nf 2 3 4\n"
        );
        let (obj, materials) = read(&text).unwrap();
        assert_eq!(obj.objects, ["t", "house/kitchen", "house/hall"]);
        assert_eq!(materials, ["a b", "c"]);
        let found: Vec<(u32, u32, usize)> =
            obj.faces.iter().map(|f| (f.object, f.material, f.corners.len())).collect();
        assert_eq!(found, [(0, 0, 3), (1, 0, 4), (1, 1, 3), (2, 1, 3)]);
    }

    #[test]
    fn negative_indices_continuations_comments_and_crlf_are_understood() {
        let text = "v 0 0 0 # a corner\r\nv 1 0 \\\r\n 0\r\nv 1 1 0 0.5 0.5 0.5\r\nvn 0 0 1\r\nf -3//-1 -2//-1 -1//1 # first\r\n";
        let (obj, materials) = read(text).unwrap();
        assert_eq!(obj.positions, [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)]);
        assert_eq!(obj.faces[0].corners, [(0, Some(0), None), (1, Some(0), None), (2, Some(0), None)]);
        assert_eq!(materials, [NO_MATERIAL]);
    }

    #[test]
    fn corners_at_one_place_share_an_index_and_half_given_normals_are_left_out() {
        let text = format!("{SQUARE}v 1 1 -0\nvn 0 0 1\nvt 0.5\nf 1/1 2/1 5/1\nf 1//1 3 4\n");
        let (obj, _) = read(&text).unwrap();
        assert_eq!(obj.positions.len(), 4);
        assert_eq!(obj.faces[0].corners[2].0, obj.faces[1].corners[1].0);
        assert!(obj.faces[1].corners.iter().all(|c| c.1.is_none()));
        assert_eq!(obj.uvs, [DVec2::new(0.5, 0.0)]);
        assert_eq!(obj.faces[0].corners[0].2, Some(0));
    }

    #[test]
    fn errors_name_file_and_line() {
        for (text, expected) in [
            ("v 0 0\nf 1 1 1", "t.obj, line 1: 'v' needs 3 numbers and has 2"),
            ("v 0 zero 0\nf 1 1 1", "t.obj, line 1: 'zero' is not a number"),
            ("\nv 0 nan 0\nf 1 1 1", "t.obj, line 2: a coordinate is not a finite number"),
            ("v 0 1e999 0\nf 1 1 1", "t.obj, line 1: a coordinate is not a finite number"),
            ("v 0 1e300 0\nf 1 1 1", "line 1: the coordinate 1e300 is larger than any building"),
            ("v 0 0 0\nf 1 2 3", "t.obj, line 2: the face asks for vertex 2, and 1 of them"),
            ("v 0 0 0\nf 0 1 1", "t.obj, line 2: the face asks for vertex 0"),
            ("v 0 0 0\nf -2 1 1", "asks for vertex -2"),
            ("v 0 0 0\nf 1//1 1//1 1//1", "asks for normal 1, and 0 of them"),
            ("v 0 0 0\nf 99999999999999999999 1 1", "is not made of whole numbers"),
            ("v 0 0 0\nf -9223372036854775808 1 1", "asks for vertex -9223372036854775808"),
            ("v 0 0 0\nf 1/1/1/1 1 1", "asks for texture coordinate 1"),
            ("v 0 0 0\nvt 0\nvn 0 0 1\nf 1/1/1/1 1 1", "has more than three indices"),
            (" \n\n", "t.obj: the file is empty"),
            ("v 0 0 0\n", "t.obj: the file holds no faces"),
        ] {
            let message = read(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{text:?}: {message}");
        }
    }

    #[test]
    fn short_faces_and_unknown_words_are_counted() {
        let text = format!("{SQUARE}f 1 2\nf 1\nf 1 2 3\ncurv2 1 2 3\n");
        let scan = Watch::nobody(|watch| scan("t.obj", "t", &text, watch)).unwrap();
        assert_eq!(scan.marks.len(), 1);
        assert_eq!(scan.findings[0].count, 2);
        assert!(scan.findings[0].message.contains("line 5"), "{}", scan.findings[0].message);
        assert!(scan.findings[1].message.contains("'curv2'"));
    }
}
