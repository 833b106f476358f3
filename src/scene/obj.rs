//! The lines of an OBJ file. `tobj` parses them; the scan before it finds what `tobj` cannot tell: line
//! numbers, which indices and numbers are wrong, objects apart from groups, unknown materials.
//!
//! The scan writes a clean text for `tobj`: continuation lines joined, comments cut, faces with
//! fewer than three corners and all lines but `v`, `vt`, `vn`, `f` left out, and `o N` and `usemtl N`
//! with numbers of entries in [`Polygons::objects`](super::model::Polygons::objects) and [`Scan::materials`] before the faces that belong to
//! them.

use super::corner_colours::{FaceColours, say_something};
use super::error::SceneError;
use super::finding::{Finding, FindingKind, MOST_PLACES, Places, Severity, line_list};
use super::model::{LARGEST_COORDINATE, LARGEST_UV};
use super::names;
use super::text::{keyword, logical_lines, number, words};
use super::textures::srgb_to_linear;
use crate::watch::Watch;
use std::collections::HashMap;
use std::fmt::Write as _;

/// Name of the material of faces that name none.
pub(super) const NO_MATERIAL: &str = "default";

/// Lines scanned between two looks at whether to go on.
const WATCHED_LINES: usize = 1024;

/// What the scan of the text found.
#[derive(Debug, Default)]
pub(super) struct Scan {
    /// The text for `tobj`.
    pub(super) clean: String,
    /// One for each face of the clean text.
    pub(super) marks: Vec<Mark>,
    /// Names of objects as the file gives them.
    pub(super) objects: Vec<String>,
    /// Material libraries with their lines.
    pub(super) libraries: Vec<(String, usize)>,
    /// Materials that faces use, each once, in order; [`Face::material`](super::model::Face::material) points here.
    pub(super) materials: Vec<String>,
    /// Faces without a material whose corners have colours: the number of each, and those colours, linear.
    pub(super) coloured: Vec<FaceColours>,
    /// Faces that have neither.
    pub(super) plain: usize,
    pub(super) findings: Vec<Finding>,
}

/// What is known of a face besides what `tobj` tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    pub(super) line: u32,
    pub(super) corners: u32,
    pub(super) has_uvs: bool,
    pub(super) has_normals: bool,
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
    /// Counts `o` statements.
    serial: usize,
    /// Numbers of objects by the `o` statement and the name.
    object_numbers: HashMap<(usize, String), usize>,
    material_numbers: HashMap<String, usize>,
    /// Number of the object that the clean text is in, and its material.
    current_object: Option<usize>,
    current_material: Option<String>,
    names_changed: bool,
    material_changed: bool,
    any_face: bool,
    /// Lines of what was dropped.
    short_faces: Vec<u32>,
    lost_uvs: Vec<u32>,
    lost_normals: Vec<u32>,
    broken_normals: Vec<u32>,
    broken_uvs: Vec<u32>,
    empty: Vec<u32>,
    /// Which of the texture coordinates can be used.
    usable_uvs: Vec<bool>,
    unread: Vec<String>,
    /// Corners with a colour, and the colour of each corner once there is one, as it is written.
    coloured: usize,
    colours: Vec<Option<[f64; 3]>>,
    /// Faces without a material whose corners have colours.
    written: Vec<(usize, Vec<[f64; 3]>)>,
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
            match &*word {
                "v" => self.position(line, rest)?,
                "vn" => self.attribute::<3>(line, "vn", rest),
                "vt" => self.attribute::<2>(line, "vt", rest),
                "f" | "fo" => self.face(line, rest)?,
                "o" => {
                    self.object = rest.to_owned();
                    self.serial += 1;
                    self.group.clear();
                    self.names_changed = true;
                }
                "g" => {
                    self.group = rest.to_owned();
                    self.names_changed = true;
                }
                "usemtl" => {
                    self.current_material = Some(rest.to_owned()).filter(|name| !name.is_empty());
                    self.material_changed = true;
                }
                "mtllib" if rest.is_empty() => self.empty.push(line as u32),
                "mtllib" => self.scan.libraries.push((rest.to_owned(), line)),
                // Lines, points and smoothing groups carry no area; comments are skipped.
                "" | "s" | "l" | "p" | "lod" | "vp" => {}
                _ if word.starts_with('#') => {}
                _ => self.unread.push(word.into_owned()),
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
        use {FindingKind as Kind, Severity as Level};
        let tallies = [
            (
                &self.short_faces,
                Kind::Degenerate,
                Level::Warning,
                "faces with fewer than three corners were dropped",
                "they have no area to carry light",
            ),
            (
                &self.lost_uvs,
                Kind::Material,
                Level::Warning,
                "faces that ask for texture coordinates that are not there have none",
                "where they have an image its mean counts",
            ),
            (
                &self.lost_normals,
                Kind::Normals,
                Level::Warning,
                "faces that ask for vertex normals that are not there have none",
                "they are shaded flat",
            ),
            (
                &self.broken_normals,
                Kind::Normals,
                Level::Warning,
                "vertex normals that are no numbers were ignored",
                "their faces are shaded flat",
            ),
            (
                &self.broken_uvs,
                Kind::Material,
                Level::Warning,
                "texture coordinates that are no usable numbers were ignored",
                "where their faces have an image its mean counts",
            ),
            (&self.empty, Kind::File, Level::Note, "statements that name no file were left out", ""),
        ];
        for (lines, kind, severity, what, consequence) in tallies {
            if lines.is_empty() {
                continue;
            }
            let message = format!("{what} ({}{})", lines.len(), line_list(lines, lines.len()));
            let lines_shown = lines.iter().copied().take(MOST_PLACES).collect();
            self.scan.findings.push(
                Finding::new(kind, severity, message)
                    .counted(lines.len())
                    .with(consequence)
                    .at(Places { lines: lines_shown, ..Places::default() }),
            );
        }
        // Codes are from 0 to 1, or from 0 to 255 as some programs write them: a file has one or the other.
        let all = self.colours.iter().flatten().flatten();
        let top = if all.copied().any(|value| value > 1.0) { 255.0 } else { 1.0 };
        let linear = |colours: Vec<[f64; 3]>| colours.into_iter().map(|code| linear(code, top)).collect();
        let written = std::mem::take(&mut self.written);
        self.scan.coloured = written.into_iter().map(|(face, colours)| (face, linear(colours))).collect();
        if !say_something(&self.scan.coloured) {
            self.scan.plain += std::mem::take(&mut self.scan.coloured).len();
        }
        if !self.scan.coloured.is_empty() {
            let message = format!(
                "faces without a material reflect by the colours of their corners, taken as sRGB ({})",
                names::grouped(self.scan.coloured.len() as i64)
            );
            let finding = Finding::new(FindingKind::Material, Severity::Note, message);
            self.scan.findings.push(finding.counted(self.scan.coloured.len()));
        }
        if self.coloured > 0 && self.scan.materials.iter().any(|name| name != NO_MATERIAL) {
            let message = format!(
                "colours of corners are not read where faces have a material, which says what reflects ({} in the file)",
                names::grouped(self.coloured as i64)
            );
            let finding = Finding::new(FindingKind::Material, Severity::Note, message);
            self.scan.findings.push(finding.counted(self.coloured));
        }
        if !self.unread.is_empty() {
            let count = self.unread.len();
            let kinds = names::list(self.unread.iter().map(String::as_str));
            let message =
                format!("lines that start with {kinds} are not polygons and were skipped ({count})");
            self.scan.findings.push(Finding::new(FindingKind::File, Severity::Note, message).counted(count));
        }
    }

    /// A `v` line. Colours may follow the three numbers, or a weight, which has no use here.
    fn position(&mut self, line: usize, rest: &str) -> Result<(), SceneError> {
        let fail = |message: String| SceneError::line(self.file, line, message);
        let mut words = words(rest);
        let (values, count) = numbers::<3>(&mut words).map_err(fail)?;
        if count < 3 {
            return Err(fail(format!("'v' needs 3 numbers and has {count}; the line seems cut off")));
        }
        if values.iter().any(|v| !v.is_finite()) {
            let message = "a coordinate is not a finite number; export the model again";
            return Err(fail(message.to_owned()));
        }
        if let Some(large) = values.iter().find(|v| v.abs() > LARGEST_COORDINATE) {
            return Err(fail(format!("the coordinate {large:e} is larger than any building")));
        }
        let colour = numbers::<3>(&mut words).ok().filter(|(_, count)| *count == 3).map(|(code, _)| code);
        if colour.is_some() && self.coloured == 0 {
            self.colours.resize(self.positions, None);
        }
        self.coloured += usize::from(colour.is_some());
        if self.coloured > 0 {
            self.colours.push(colour);
        }
        self.positions += 1;
        self.write("v", values);
        Ok(())
    }

    /// A `vt` or `vn` line. Light can do without it, so that one that is damaged is no reason to refuse.
    fn attribute<const N: usize>(&mut self, line: usize, kind: &str, rest: &str) {
        // A texture coordinate may come without its second number.
        let (is_uv, needed) = (kind == "vt", if kind == "vt" { 1 } else { N });
        let largest = if is_uv { LARGEST_UV } else { f64::MAX };
        let read = numbers::<N>(&mut words(rest)).ok().filter(|(values, count)| {
            *count >= needed && values.iter().all(|v| v.is_finite() && v.abs() <= largest)
        });
        let is_usable = read.is_some();
        match is_uv {
            true => {
                self.uvs += 1;
                self.usable_uvs.push(is_usable);
                self.broken_uvs.extend((!is_usable).then_some(line as u32));
            }
            false => {
                self.normals += 1;
                self.broken_normals.extend((!is_usable).then_some(line as u32));
            }
        }
        self.write(kind, read.map_or([0.0; N], |(values, _)| values));
    }

    fn write<const N: usize>(&mut self, kind: &str, values: [f64; N]) {
        self.scan.clean.push_str(kind);
        for value in values {
            let _ = write!(self.scan.clean, " {value:e}");
        }
        self.scan.clean.push('\n');
    }

    fn face(&mut self, line: usize, rest: &str) -> Result<(), SceneError> {
        self.any_face = true;
        let mut corners = Vec::with_capacity(4);
        let mut lost = [false; 3];
        for word in words(rest) {
            corners.push(self.corner(line, word, &mut lost)?);
        }
        self.lost_uvs.extend(lost[1].then_some(line as u32));
        self.lost_normals.extend(lost[2].then_some(line as u32));
        if corners.len() < 3 {
            self.short_faces.push(line as u32);
            return Ok(());
        }
        self.open_object();
        let is_usable = |uv: usize| self.usable_uvs.get(uv).is_some_and(|usable| *usable);
        let has_uvs = corners.iter().all(|c| c[1].is_some_and(is_usable));
        let has_normals = corners.iter().all(|c| c[2].is_some());
        if self.current_material.is_none() {
            self.note_colours(&corners);
        }
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

    /// Keeps the colours of a face without a material where all of its corners have one.
    fn note_colours(&mut self, corners: &[[Option<usize>; 3]]) {
        let colour = |corner: &[Option<usize>; 3]| *self.colours.get(corner[0]?)?;
        match corners.iter().map(colour).collect() {
            Some(colours) => self.written.push((self.scan.marks.len(), colours)),
            None => self.scan.plain += 1,
        }
    }

    /// Indices from zero of `v`, `v/vt`, `v//vn` or `v/vt/vn`. Those of texture coordinates and normals
    /// that are not there are left out and marked as `lost`: the face can do without.
    fn corner(
        &self,
        line: usize,
        word: &str,
        lost: &mut [bool; 3],
    ) -> Result<[Option<usize>; 3], SceneError> {
        let counts = [self.positions, self.uvs, self.normals];
        let mut corner = [None; 3];
        for (k, part) in word.split('/').enumerate() {
            let Some(&count) = counts.get(k) else {
                let message = format!("the corner '{}' has more than three indices", names::short(word));
                return Err(SceneError::line(self.file, line, message));
            };
            if part.is_empty() && k > 0 {
                continue;
            }
            let index: Option<i64> = part.parse().ok();
            corner[k] = index.and_then(|index| match index {
                1.. => usize::try_from(index - 1).ok().filter(|i| *i < count),
                0 => None,
                _ => usize::try_from(index.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
            });
            lost[k] |= corner[k].is_none();
            let message = match (k, corner[k], index) {
                (0, None, None) => {
                    format!("the corner '{}' is not made of whole numbers", names::short(word))
                }
                (0, None, Some(index)) => format!(
                    "the face asks for vertex {index}, and {count} of them stand above it; the file is cut off or damaged"
                ),
                _ => continue,
            };
            return Err(SceneError::line(self.file, line, message));
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
            let number = *self.object_numbers.entry((self.serial, name)).or_insert_with_key(|(_, name)| {
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
            let materials = &mut self.scan.materials;
            let number = match self.material_numbers.get(name) {
                Some(&number) => number,
                None => {
                    self.material_numbers.insert(name.to_owned(), materials.len());
                    materials.push(name.to_owned());
                    materials.len() - 1
                }
            };
            let _ = writeln!(self.scan.clean, "usemtl {number}");
        }
    }
}

/// A colour of codes from 0 to `top` in linear light; white where it is no number.
fn linear(code: [f64; 3], top: f64) -> [f32; 3] {
    let of = |value: f64| if value.is_finite() { srgb_to_linear((value / top).clamp(0.0, 1.0)) } else { 1.0 };
    code.map(|value| of(value) as f32)
}

/// At most `N` numbers of a line, and how many there are.
fn numbers<'a, const N: usize>(
    words: &mut impl Iterator<Item = &'a str>,
) -> Result<([f64; N], usize), String> {
    let mut values = [0.0_f64; N];
    let mut count = 0;
    for (value, word) in values.iter_mut().zip(words) {
        *value = number(word)?;
        count += 1;
    }
    Ok((values, count))
}

#[cfg(test)]
mod tests {
    use super::super::model::Polygons;
    use super::super::polygons;
    use super::*;
    use glam::{DVec2, DVec3};

    fn scanned(text: &str) -> Result<Scan, SceneError> {
        Watch::nobody(|watch| scan("t.obj", "t", text, watch))
    }

    fn read(text: &str) -> Result<(Polygons, Vec<String>), SceneError> {
        let scan = scanned(text)?;
        let names = scan.materials.clone();
        Watch::nobody(|watch| polygons::parse("t.obj", scan, watch)).map(|obj| (obj, names))
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
            ("v 0 0 0\nf 99999999999999999999 1 1", "is not made of whole numbers"),
            ("v 0 0 0\nf -9223372036854775808 1 1", "asks for vertex -9223372036854775808"),
            ("v 0 0 0\nf 1/1/1/1 1 1", "has more than three indices"),
            ("v 0 0,5 0\nf 1 1 1", "'0,5' is not a number: it has a decimal comma"),
            ("v 0 0 0\nvt 0\nvn 0 0 1\nf 1/1/1/1 1 1", "has more than three indices"),
            (" \n\n", "t.obj: the file is empty"),
            ("v 0 0 0\n", "t.obj: the file holds no faces"),
        ] {
            let message = read(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{text:?}: {message}");
        }
    }

    #[test]
    fn what_light_can_do_without_is_left_out_and_told() {
        let lines = "vt 0 0\nvt nan 0\nvt\nvt 2e9 0\nvn 0 zero 1\nvn 0 0 1\nMTLLIB\n";
        let faces = "f 1/1 2/1 3/9\nf 1//2 2//2 3//-7\nf 1/1/2 2/1/2 3/x/2\nf 1/2 2/1 3/1\nF 1/1 2/1 3/1\n";
        let text = format!("{SQUARE}{lines}{faces}");
        let found = scanned(&text).unwrap().findings;
        for (message, count) in [
            ("texture coordinates that are not there have none (2, lines 12, 14)", 2),
            ("vertex normals that are not there have none (1, line 13)", 1),
            ("vertex normals that are no numbers were ignored (1, line 9)", 1),
            ("texture coordinates that are no usable numbers were ignored (3, lines 6, 7, 8)", 3),
            ("statements that name no file were left out (1, line 11)", 1),
        ] {
            assert!(found.iter().any(|f| f.message.contains(message) && f.count == count), "{found:?}");
        }
        let (obj, _) = read(&text).unwrap();
        let has =
            |face: usize| (obj.faces[face].corners[2].2.is_some(), obj.faces[face].corners[2].1.is_some());
        assert_eq!(
            (0..5).map(has).collect::<Vec<_>>(),
            [(false, false), (false, false), (false, true), (false, false), (true, false)]
        );
    }

    #[test]
    fn each_object_statement_begins_an_object_and_groups_of_one_name_are_one() {
        let text = format!(
            "{SQUARE}o lamp\nf 1 2 3\no lamp\nf 1 2 4\no lamp 1\nf 2 3 4\no box\ng a\nf 1 2 3\ng b\nf 1 2 3\ng a\nf 2 3 4\no lamp\nf 1 3 4\n"
        );
        let (obj, _) = read(&text).unwrap();
        assert_eq!(obj.objects, ["lamp 2", "lamp 3", "lamp 1", "box/a", "box/b", "lamp 4"]);
        assert_eq!(obj.given_objects, ["lamp", "lamp", "lamp 1", "box/a", "box/b", "lamp"]);
        assert_eq!(obj.faces.iter().map(|f| f.object).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 3, 5]);
    }

    #[test]
    fn colours_of_corners_count_where_a_face_has_no_material() {
        let coloured = "v 0 0 0\nv 0 0 0 1 0 0.5\nv 1 0 0 0 1 0\nv 1 1 0 1 0 0.2\nf 2 3 4\nf 1 2 3\n";
        let told =
            |scan: &Scan| scan.findings.iter().map(|f| f.message.clone()).collect::<Vec<_>>().join("; ");
        let scan = scanned(coloured).unwrap();
        assert_eq!((scan.coloured.len(), scan.coloured[0].0, scan.plain), (1, 0, 1));
        let middle = srgb_to_linear(0.5) as f32;
        let [a, b, c] = [[1.0, 0.0, middle], [0.0, 1.0, 0.0], [1.0, 0.0, srgb_to_linear(0.2) as f32]];
        assert_eq!(scan.coloured[0].1, [a, b, c]);
        assert!(
            told(&scan).contains("by the colours of their corners, taken as sRGB (1)"),
            "{}",
            told(&scan)
        );
        let scan = scanned(&format!("usemtl a\n{coloured}")).unwrap();
        assert!(scan.coloured.is_empty() && told(&scan).contains("not read where faces have a material"));
        // Of a file that counts to 255 a one is nearly black.
        let scan = scanned(&coloured.replace("1 0 0.2", "255 0 51")).unwrap();
        assert_eq!(scan.coloured[0].1[2], c);
        assert!(scan.coloured[0].1[0][0] < 1e-3, "{:?}", scan.coloured[0].1);
        // A weight is no colour, and white says nothing.
        for text in ["v 0 0 0 1\nv 1 0 0 1 # red\nv 0 1 0\nf 1 2 3\n", "v 0 0 0 1 1 1\nf 1 1 1\n"] {
            let scan = scanned(text).unwrap();
            assert!(scan.coloured.is_empty() && scan.plain == 1 && told(&scan).is_empty(), "{text}");
        }
    }

    #[test]
    fn short_faces_and_unknown_words_are_counted() {
        let text = format!("{SQUARE}f 1 2\nf 1\nf 1 2 3\ncurv2 1 2 3\n");
        let scan = scanned(&text).unwrap();
        assert_eq!(scan.marks.len(), 1);
        assert_eq!(scan.findings[0].count, 2);
        assert!(scan.findings[0].message.contains("(2, lines 5, 6)"), "{}", scan.findings[0].message);
        assert!(scan.findings[1].message.contains("'curv2'"));
    }
}
