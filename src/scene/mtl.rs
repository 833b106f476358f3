//! MTL text to materials. As for OBJ, a scan checks each line before `tobj` parses it.

use super::error::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::names;
use super::obj::{NO_MATERIAL, Scan, keyword, logical_lines, words};
use super::textures::Textures;
use super::types::{MAX_REFLECTANCE, Material, Sides};
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Reflectance where a file says nothing: a middling grey.
const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Materials with what the MTL says of their own light.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    /// Radiant exitance of each material per band, W/m²; zero where it does not emit.
    pub(super) exitance: Vec<[f64; 3]>,
    pub(super) findings: Vec<Finding>,
    /// What `tobj` made of the libraries, to look names up while it parses the OBJ.
    pub(super) parsed: Option<tobj::MTLLoadResult>,
}

/// Cleaned statements of each material, later definitions replacing earlier ones.
#[derive(Default)]
struct Library {
    blocks: Vec<Block>,
    findings: Vec<Finding>,
}

struct Block {
    name: String,
    clean: String,
    /// The image of `map_Kd` without its options; `tobj` keeps them in the name.
    image: Option<String>,
    missing: bool,
}

/// Reads the libraries that the OBJ names through `read` (file name to bytes), adds grey materials
/// for those that are used and not defined, and decodes textures.
pub(super) fn read(
    scan: &Scan,
    obj_file: &str,
    read: &dyn Fn(&str) -> std::io::Result<Vec<u8>>,
) -> Result<(Materials, Textures), SceneError> {
    let mut library = Library::default();
    let mut unread_libraries = 0;
    for (given, line) in &scan.libraries {
        for (file, content) in library_files(given, read) {
            match content {
                Ok(bytes) => library.scan(&file, &String::from_utf8_lossy(&bytes))?,
                Err(error) => {
                    unread_libraries += 1;
                    library.warn(format!(
                        "the material library '{}' ({obj_file}, line {line}) cannot be read ({error}); its materials are grey 0.5",
                        names::short(&file)
                    ));
                }
            }
        }
    }
    let missing: Vec<&String> =
        scan.materials.iter().filter(|name| !library.blocks.iter().any(|b| b.name == **name)).collect();
    let named: Vec<&str> = missing.iter().map(|n| n.as_str()).filter(|n| *n != NO_MATERIAL).collect();
    if !named.is_empty() && unread_libraries == 0 {
        let list = names::list(named.iter().copied());
        library.warn(format!("materials that no library defines were taken as grey 0.5: {list}"));
    }
    if missing.iter().any(|n| *n == NO_MATERIAL) {
        library.warn("faces without a material were taken as grey 0.5".to_owned());
    }
    for name in missing {
        library.blocks.push(Block { name: name.clone(), clean: String::new(), image: None, missing: true });
    }
    library.finish(obj_file, read)
}

/// `mtllib` may list several files, and one name may hold spaces: the whole is tried first.
pub(super) fn library_files(
    given: &str,
    read: &dyn Fn(&str) -> std::io::Result<Vec<u8>>,
) -> Vec<(String, std::io::Result<Vec<u8>>)> {
    let whole = read(given);
    if whole.is_ok() || given.split_whitespace().nth(1).is_none() {
        return vec![(given.to_owned(), whole)];
    }
    let parts: Vec<_> = given.split_whitespace().map(|file| (file.to_owned(), read(file))).collect();
    if parts.iter().any(|(_, content)| content.is_ok()) { parts } else { vec![(given.to_owned(), whole)] }
}

impl Library {
    fn warn(&mut self, message: String) {
        self.findings.push(Finding::new(FindingKind::Material, Severity::Warning, message));
    }

    fn note(&mut self, message: String) {
        self.findings.push(Finding::new(FindingKind::Material, Severity::Note, message));
    }

    fn scan(&mut self, file: &str, text: &str) -> Result<(), SceneError> {
        let mut current: Option<usize> = None;
        for (line, content) in logical_lines(text) {
            let (word, rest) = keyword(&content);
            if word == "newmtl" {
                if rest.is_empty() {
                    let message = "'newmtl' has no name; give the material one";
                    return Err(SceneError::line(file, line, message));
                }
                current = Some(self.open(rest));
                continue;
            }
            let Some(block) = current else { continue };
            match word {
                "Kd" | "Ke" => self.colour(block, file, line, word, rest)?,
                "map_Kd" => {
                    let image = image_name(rest);
                    if image.is_empty() {
                        let message = "'map_Kd' names no image; name one or remove the line";
                        return Err(SceneError::line(file, line, message));
                    }
                    self.blocks[block].image = Some(image);
                }
                "map_Ke" => {
                    let name = names::short(&self.blocks[block].name);
                    self.note(format!("the emission image of material '{name}' is not read; its Ke is"));
                }
                "d" => {
                    let opacity = words(rest).find_map(|w| w.parse::<f64>().ok());
                    if opacity.is_some_and(|d| d < 0.999) {
                        let name = names::short(&self.blocks[block].name);
                        self.note(format!("material '{name}' is see-through in the file and opaque here"));
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn open(&mut self, name: &str) -> usize {
        let fresh = Block { name: name.to_owned(), clean: String::new(), image: None, missing: false };
        if let Some(index) = self.blocks.iter().position(|b| b.name == name) {
            self.note(format!("material '{}' is defined twice; the later one counts", names::short(name)));
            self.blocks[index] = fresh;
            return index;
        }
        self.blocks.push(fresh);
        self.blocks.len() - 1
    }

    /// A `Kd` or `Ke` line: one number stands for three. NaN passes: it is repaired by name later.
    fn colour(
        &mut self,
        block: usize,
        file: &str,
        line: usize,
        kind: &str,
        rest: &str,
    ) -> Result<(), SceneError> {
        let first = words(rest).next().unwrap_or_default();
        if first == "spectral" || first == "xyz" {
            let name = names::short(&self.blocks[block].name);
            self.warn(format!(
                "material '{name}' gives {kind} as {first}, which is not read; give red, green and blue"
            ));
            return Ok(());
        }
        let mut values = Vec::with_capacity(3);
        for word in words(rest).take(3) {
            let value: f64 = word.parse().map_err(|_| {
                SceneError::line(file, line, format!("'{}' is not a number", names::short(word)))
            })?;
            values.push(value);
        }
        let [r, g, b] = match values[..] {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => {
                let count = values.len();
                let message = format!("'{kind}' needs three numbers and has {count}; the line seems cut off");
                return Err(SceneError::line(file, line, message));
            }
        };
        let _ = writeln!(self.blocks[block].clean, "{kind} {r:e} {g:e} {b:e}");
        Ok(())
    }

    fn finish(
        mut self,
        obj_file: &str,
        read: &dyn Fn(&str) -> std::io::Result<Vec<u8>>,
    ) -> Result<(Materials, Textures), SceneError> {
        let mut text = String::new();
        for block in &self.blocks {
            let _ = writeln!(text, "newmtl {}\n{}", block.name, block.clean);
        }
        let parsed = tobj::load_mtl_buf(&mut text.as_bytes());
        let raw = match &parsed {
            Ok((raw, _)) if raw.len() == self.blocks.len() => raw.clone(),
            Ok(_) => {
                return Err(SceneError::file(obj_file, "two materials have names that cannot be told apart"));
            }
            Err(error) => {
                return Err(SceneError::file(obj_file, format!("the materials cannot be parsed ({error})")));
            }
        };
        let mut materials = Materials::default();
        let mut textures = Textures::default();
        let blocks = std::mem::take(&mut self.blocks);
        for (raw, block) in raw.iter().zip(&blocks) {
            let texture = block.image.as_ref().and_then(|image| match textures.load(image, read) {
                Ok(index) => Some(index),
                Err(reason) => {
                    let (name, image) = (names::short(&block.name), names::short(image));
                    self.warn(format!(
                        "the image '{image}' of material '{name}' cannot be used ({reason}); its Kd counts"
                    ));
                    None
                }
            });
            let reflectance = self.reflectance(raw, texture.is_some(), block.missing);
            materials.exitance.push(self.exitance(raw));
            materials.list.push(Material {
                name: block.name.clone(),
                reflectance,
                texture,
                sides: Sides::Auto,
            });
        }
        materials.findings = self.findings;
        materials.parsed = Some(parsed);
        Ok((materials, textures))
    }

    fn reflectance(&mut self, raw: &tobj::Material, textured: bool, missing: bool) -> [f64; 3] {
        let Some(given) = raw.diffuse else {
            if textured {
                return [1.0; 3];
            }
            // An emitter without Kd is common and means a black lamp, as does every other reader.
            if raw.emissive.is_some_and(|e| e != [0.0; 3]) {
                return [0.0; 3];
            }
            if !missing {
                let name = names::short(&raw.name);
                self.warn(format!("material '{name}' has no Kd; it was taken as grey 0.5"));
            }
            return [DEFAULT_REFLECTANCE; 3];
        };
        // The image holds reflectances already; Kd is a factor on it and may be one.
        let (repaired, change) = repair_reflectance(given, if textured { 1.0 } else { MAX_REFLECTANCE });
        if let Some(change) = change {
            self.warn(format!("material '{}' has Kd {change}", names::short(&raw.name)));
        }
        repaired
    }

    /// Ke is radiance; a diffuse emitter of radiance L has the exitance pi L.
    fn exitance(&mut self, raw: &tobj::Material) -> [f64; 3] {
        const LARGEST: f64 = 1e12;
        let given = raw.emissive.unwrap_or([0.0; 3]);
        let name = names::short(&raw.name);
        if given.iter().any(|e| !e.is_finite() || *e > LARGEST) {
            self.warn(format!(
                "material '{name}' has an emission Ke that is no usable number; it was taken as 0"
            ));
            return [0.0; 3];
        }
        if given.iter().any(|e| *e < 0.0) {
            self.warn(format!("material '{name}' has a negative emission Ke; it was raised to 0"));
        }
        given.map(|e| PI * e.max(0.0))
    }
}

/// Brings reflectances into 0..`largest`; the second value says what was done, if anything.
pub(super) fn repair_reflectance(given: [f64; 3], largest: f64) -> ([f64; 3], Option<String>) {
    if given.iter().any(|k| k.is_nan()) {
        return ([DEFAULT_REFLECTANCE; 3], Some("that is not a number; it was taken as grey 0.5".to_owned()));
    }
    let clamped = given.map(|k| k.clamp(0.0, largest));
    if clamped == given {
        return (given, None);
    }
    let top = given.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let change = if top > largest {
        format!("up to {top}, more than any paint reflects; it was lowered to {largest}")
    } else {
        "below 0; it was raised to 0".to_owned()
    };
    (clamped, Some(change))
}

/// The file name after the options of a `map_` statement (`-s 1 1 1`, `-clamp on`...).
pub(super) fn image_name(rest: &str) -> String {
    let mut rest = rest.trim();
    while let Some(option) = rest.strip_prefix('-') {
        let (name, mut tail) = keyword(option);
        let numbers = match name {
            "o" | "s" | "t" => 3,
            "mm" => 2,
            "blendu" | "blendv" | "bm" | "boost" | "cc" | "clamp" | "imfchan" | "texres" | "type" => 1,
            // Not an option: a file name that starts with a dash.
            _ => break,
        };
        for k in 0..numbers {
            let (value, after) = keyword(tail);
            // -o, -s and -t take one to three numbers.
            if k > 0 && value.parse::<f64>().is_err() {
                break;
            }
            tail = after;
        }
        rest = tail.trim();
    }
    rest.trim_matches('"').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_an_image_are_skipped() {
        for (given, expected) in [
            ("wall.png", "wall.png"),
            ("-s 2 2 1 my wall.png", "my wall.png"),
            ("-s 2 -clamp on wall.png", "wall.png"),
            ("-mm 0 1 \"a b.jpg\"", "a b.jpg"),
            ("-odd.png", "-odd.png"),
            ("-clamp on", ""),
        ] {
            assert_eq!(image_name(given), expected, "{given}");
        }
    }

    #[test]
    fn reflectances_are_brought_into_range_with_a_reason() {
        assert_eq!(repair_reflectance([0.2, 0.5, 0.9], 0.98), ([0.2, 0.5, 0.9], None));
        let (k, why) = repair_reflectance([1.5, 0.5, 0.1], 0.98);
        assert_eq!(k, [0.98, 0.5, 0.1]);
        assert!(why.unwrap().contains("1.5"));
        assert_eq!(repair_reflectance([-0.5, 0.5, 0.1], 0.98).0, [0.0, 0.5, 0.1]);
        assert_eq!(repair_reflectance([f64::NAN, 0.5, 0.1], 0.98).0, [0.5; 3]);
        assert_eq!(repair_reflectance([f64::INFINITY, 0.5, 0.1], 0.98).0, [0.98, 0.5, 0.1]);
    }
}
