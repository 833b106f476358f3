//! Material libraries: which files they are, the statements in them, and the names of their materials.

use super::SceneError;
use super::finding::{FindingKind, Severity};
use super::glass::Passing;
use super::lookup::{Files, Found, reason};
use super::map::Map;
use super::names;
use super::tally::Remarks;
use super::text::{keyword, listed, logical_lines, lowered, number, uncommented, unquoted, words};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// The libraries of a model.
#[derive(Default)]
pub(super) struct Opened {
    pub(super) found: Vec<Found>,
    /// Those that cannot be read: the number of the statement, the name and the reason.
    pub(super) missing: Vec<(usize, String, String)>,
    /// The one that was taken because it has the name of the OBJ file, and the names of those for which it
    /// stands.
    pub(super) namesake: Option<(PathBuf, Vec<String>)>,
}

/// Reads the libraries that `mtllib` statements name. Where one is missing, or none is named although
/// materials are used, the library that has the OBJ file's own name is taken as well.
pub(super) fn open(statements: &[&str], stem: &str, uses_materials: bool, files: Files<'_>) -> Opened {
    let mut opened = Opened::default();
    for (statement, given) in statements.iter().enumerate() {
        // One name may hold blanks, and one statement may name several files: the whole is tried first.
        let whole = [*given, unquoted(given), uncommented(given)].into_iter();
        if let Some(found) = whole.into_iter().find_map(|name| files.library(name).ok()) {
            opened.found.push(found);
            continue;
        }
        let parts: Vec<_> = listed(given).into_iter().map(|name| (name, files.library(name))).collect();
        if parts.iter().any(|(_, found)| found.is_ok()) {
            for (name, found) in parts {
                match found {
                    Ok(found) => opened.found.push(found),
                    Err(error) => opened.missing.push((statement, name.to_owned(), reason(&error))),
                }
            }
        } else if let Err(error) = files.library(unquoted(given)) {
            opened.missing.push((statement, unquoted(given).to_owned(), reason(&error)));
        }
    }
    if uses_materials
        && (opened.found.is_empty() || !opened.missing.is_empty())
        && let Some(found) = files.namesake(stem)
        && opened.found.iter().all(|other| other.path != found.path)
    {
        let instead = opened.missing.drain(..).map(|(_, name, _)| name).collect();
        opened.namesake = Some((found.path.clone(), instead));
        opened.found.push(found);
    }
    opened
}

/// A material as its statements define it.
#[derive(Debug)]
pub(super) struct Block {
    /// As `newmtl` gives it.
    pub(super) given: String,
    /// Without the quotation marks that a program may have put around it.
    pub(super) name: String,
    pub(super) kd: Option<[f64; 3]>,
    pub(super) ke: Option<[f64; 3]>,
    /// `map_Kd`, and the library that it stands in.
    pub(super) image: Option<(Map, PathBuf)>,
    /// `map_Ke`, likewise.
    pub(super) glow: Option<(Map, PathBuf)>,
    /// `map_d`, likewise: where it is opaque.
    pub(super) holes: Option<(Map, PathBuf)>,
    /// What it says of light that passes.
    pub(super) passing: Passing,
    /// Whether a library defines it.
    pub(super) defined: bool,
}

impl Block {
    /// A material that no library defines.
    pub(super) fn grey(name: &str) -> Self {
        let name = unquoted(name).to_owned();
        Self {
            given: name.clone(),
            name,
            kd: None,
            ke: None,
            image: None,
            glow: None,
            holes: None,
            passing: Passing::default(),
            defined: false,
        }
    }
}

/// Materials by their names; of equal ones the first.
pub(super) struct Index {
    given: HashMap<String, usize>,
    plain: HashMap<String, usize>,
    uncommented: HashMap<String, usize>,
    lower: HashMap<String, usize>,
}

impl Index {
    pub(super) fn of(blocks: &[Block]) -> Self {
        let by = |name: &dyn Fn(&Block) -> String| {
            let mut numbers = HashMap::with_capacity(blocks.len());
            for (number, block) in blocks.iter().enumerate() {
                numbers.entry(name(block)).or_insert(number);
            }
            numbers
        };
        Self {
            given: by(&|block| block.given.clone()),
            plain: by(&|block| block.name.clone()),
            uncommented: by(&|block| unquoted(uncommented(&block.given)).to_owned()),
            lower: by(&|block| lowered(&block.name)),
        }
    }

    /// The material that a name of the OBJ file means, and whether it differs in capitals.
    ///
    /// An exact name comes first, then one without quotation marks or without a comment behind it.
    pub(super) fn find(&self, used: &str) -> Option<(usize, bool)> {
        let plain = unquoted(used);
        let same = self
            .given
            .get(used)
            .or_else(|| self.plain.get(plain))
            .or_else(|| self.plain.get(unquoted(uncommented(used))))
            .or_else(|| self.uncommented.get(plain));
        let alike = || self.lower.get(&lowered(plain)).map(|&number| (number, true));
        same.map(|&number| (number, false)).or_else(alike)
    }
}

/// Statements of all libraries, later definitions replacing earlier ones.
#[derive(Default)]
pub(super) struct Library {
    pub(super) blocks: Vec<Block>,
    numbers: HashMap<String, usize>,
    taken: HashSet<String>,
    pub(super) remarks: Remarks,
}

impl Library {
    fn note(&mut self, what: &str, thing: String) {
        self.remarks.add(FindingKind::Material, Severity::Note, what, thing);
    }

    /// Adds the statements of a library.
    ///
    /// # Errors
    /// A reflectance or an emission that is not made of numbers.
    pub(super) fn scan(&mut self, path: &Path, text: &str) -> Result<(), SceneError> {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let mut current: Option<usize> = None;
        for (line, content) in logical_lines(text) {
            let (word, rest) = keyword(&content);
            let place = || format!("'{}' ({file}, line {line})", names::short(&content));
            if word == "newmtl" {
                if rest.is_empty() {
                    let what = "materials without a name were left out";
                    self.remarks.add(FindingKind::Material, Severity::Warning, what, place());
                    current = None;
                } else {
                    current = Some(self.open(rest));
                }
                continue;
            }
            let Some(block) = current else { continue };
            match &*word {
                "kd" | "ke" if words(rest).next().is_none() => {
                    self.note("statements without a value were left out", place());
                }
                "kd" | "ke" => {
                    let fail = |message: String| SceneError::line(&file, line, message);
                    if let Some(colour) = self.colour(block, &word, rest).map_err(fail)? {
                        let block = &mut self.blocks[block];
                        *(if word == "kd" { &mut block.kd } else { &mut block.ke }) = Some(colour);
                    }
                }
                "map_kd" | "map_ke" | "map_d" => {
                    let map = Map::parse(rest);
                    if map.image.is_empty() {
                        self.note("statements that name no image were left out", place());
                        continue;
                    }
                    let block = &mut self.blocks[block];
                    let slot = match &*word {
                        "map_kd" => &mut block.image,
                        "map_ke" => &mut block.glow,
                        _ => &mut block.holes,
                    };
                    *slot = Some((map, path.to_owned()));
                }
                "d" | "tr" | "ni" | "illum" => {
                    let passing = &mut self.blocks[block].passing;
                    let slot = match &*word {
                        "d" => &mut passing.d,
                        "tr" => &mut passing.tr,
                        "ni" => &mut passing.index,
                        _ => &mut passing.model,
                    };
                    // `d -halo 0.5` has a word before the number.
                    let value = words(rest).find_map(|word| word.parse::<f64>().ok());
                    *slot = value.filter(|value| value.is_finite());
                }
                // What no program writes otherwise is left out, as it is no reason to refuse a model.
                "tf" => self.blocks[block].passing.filter = self.colour(block, "Tf", rest).ok().flatten(),
                _ => {}
            }
        }
        Ok(())
    }

    fn open(&mut self, given: &str) -> usize {
        if let Some(&index) = self.numbers.get(given) {
            let name = self.blocks[index].name.clone();
            let thing = format!("'{}'", names::short(&name));
            self.note("materials that are defined twice are as the later one says", thing);
            self.blocks[index] = Block { given: given.to_owned(), defined: true, ..Block::grey(&name) };
            return index;
        }
        let name = names::unique(unquoted(given), &mut self.taken);
        self.numbers.insert(given.to_owned(), self.blocks.len());
        self.blocks.push(Block { given: given.to_owned(), defined: true, ..Block::grey(&name) });
        self.blocks.len() - 1
    }

    /// The value of a `Kd` or `Ke`: one number stands for three. NaN passes: it is repaired later.
    fn colour(&mut self, block: usize, kind: &str, rest: &str) -> Result<Option<[f64; 3]>, String> {
        let kind = match kind {
            "kd" => "Kd",
            "ke" => "Ke",
            other => other,
        };
        let mut values = words(rest).peekable();
        let is_xyz = values.next_if(|first| first.eq_ignore_ascii_case("xyz")).is_some();
        if values.peek().is_some_and(|first| first.eq_ignore_ascii_case("spectral")) {
            let thing = format!("{kind} of material '{}'", names::short(&self.blocks[block].name));
            let what = "spectral values are not read; give red, green and blue";
            self.remarks.add(FindingKind::Material, Severity::Warning, what, thing);
            return Ok(None);
        }
        let numbers = values.take(3).map(number).collect::<Result<Vec<f64>, String>>()?;
        let colour = match numbers[..] {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => {
                let count = numbers.len();
                return Err(format!("'{kind}' needs three numbers and has {count}; the line seems cut off"));
            }
        };
        Ok(Some(if is_xyz { rgb_of_xyz(colour) } else { colour }))
    }
}

/// Linear Rec. 709 of CIE XYZ, white point D65 (IEC 61966-2-1). What a screen cannot show is cut off.
fn rgb_of_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_625_5 * x - 1.537_208 * y - 0.498_628_6 * z,
        -0.968_930_7 * x + 1.875_756_1 * y + 0.041_517_5 * z,
        0.055_710_1 * x - 0.204_021_1 * y + 1.056_995_9 * z,
    ]
    .map(|band| if band.is_nan() { band } else { band.max(0.0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_are_found_by_exact_names_first() {
        let mut library = Library::default();
        let text = "newmtl wall\nKd .1\nnewmtl Wall\nKD .2 .2 .2\nNEWMTL \"oak tree\"\nnewmtl oak # light\nnewmtl M #25\n";
        library.scan(Path::new("t.mtl"), text).unwrap();
        let name = |used: &str| {
            let found = Index::of(&library.blocks).find(used);
            found.map(|(index, differs)| (library.blocks[index].name.clone(), differs))
        };
        for (used, expected) in [
            ("Wall", Some(("Wall", false))),
            ("WALL", Some(("wall", true))),
            ("oak tree", Some(("oak tree", false))),
            ("\"wall\"", Some(("wall", false))),
            ("wall   # plaster", Some(("wall", false))),
            ("oak", Some(("oak # light", false))),
            ("M #25", Some(("M #25", false))),
            ("M #26", None),
            ("roof", None),
        ] {
            assert_eq!(name(used), expected.map(|(name, differs)| (name.to_owned(), differs)), "{used}");
        }
        assert_eq!(library.blocks[1].kd, Some([0.2; 3]));
    }

    #[test]
    fn xyz_of_a_grey_is_that_grey() {
        let rgb = rgb_of_xyz([0.95047 * 0.3, 0.3, 1.08883 * 0.3]);
        assert!(rgb.iter().all(|band| (band - 0.3).abs() < 1e-4), "{rgb:?}");
    }
}
