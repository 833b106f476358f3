//! MTL text to materials.

use super::SceneError;
use super::finding::{Finding, FindingKind, Severity};
use super::glass::Passing;
use super::library::{Block, Index, Library, open};
use super::lookup::Files;
use super::map::{Map, Placement};
use super::names;
use super::obj::{NO_MATERIAL, Scan};
use super::tally::Remarks;
use super::textures::Textures;
use super::types::{MAX_REFLECTANCE, Material, Sides, luminance_weighted};
use crate::glazing::Glazing;
use std::f64::consts::PI;
use std::fmt;

/// Reflectance where a file says nothing: a middling grey.
pub(super) const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Materials with what the MTL says of their own light.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) list: Vec<Material>,
    /// Radiant exitance of each material per band, W/m²; zero where it does not emit.
    pub(super) exitance: Vec<[f64; 3]>,
    /// How the image of each material lies on its surfaces.
    pub(super) placements: Vec<Placement>,
    /// Which of `list` each material of [`Scan::materials`] is.
    pub(super) of_scan: Vec<u32>,
    pub(super) findings: Vec<Finding>,
}

/// Reads the libraries that the OBJ names, adds grey materials for those that are used and not defined,
/// and decodes textures. `stem` is the name of the OBJ file without its ending.
pub(super) fn read(
    scan: &Scan,
    stem: &str,
    obj_file: &str,
    files: Files<'_>,
) -> Result<(Materials, Textures), SceneError> {
    let mut library = Library::default();
    let uses_materials = scan.materials.iter().any(|name| name != NO_MATERIAL);
    let named: Vec<&str> = scan.libraries.iter().map(|(name, _)| name.as_str()).collect();
    let opened = open(&named, stem, uses_materials, files);
    for found in &opened.found {
        library.scan(&found.path, &crate::encoding::decode(&found.bytes))?;
    }
    let mut remarks = std::mem::take(&mut library.remarks);
    for (number, name, reason) in &opened.missing {
        let line = scan.libraries.get(*number).map_or(0, |(_, line)| *line);
        let thing = format!("'{}' ({obj_file}, line {line}: {reason})", names::short(name));
        remarks.add(
            FindingKind::Material,
            Severity::Warning,
            "material libraries that cannot be read, so that their materials are grey 0.5",
            thing,
        );
    }
    let mut blocks = library.blocks;
    let (mut of_scan, mut undefined) = (Vec::new(), Vec::new());
    let index = Index::of(&blocks);
    let mut materials = Materials::default();
    if let Some((namesake, instead)) = &opened.namesake {
        let name = names::short(&namesake.file_name().unwrap_or_default().to_string_lossy());
        let why = match &instead[..] {
            [] => "names none".to_owned(),
            missing => {
                let missing = names::list(missing.iter().map(String::as_str));
                format!("names {missing}, which is not there")
            }
        };
        let message = format!("the material library '{name}' was read for its name, as {obj_file} {why}");
        materials.findings.push(Finding::new(FindingKind::Material, Severity::Note, message));
    }
    for used in &scan.materials {
        let found = index.find(used);
        if let Some((index, true)) = found {
            let thing = format!("'{}' as '{}'", names::short(used), names::short(&blocks[index].name));
            let what = "materials taken from the library although their names differ in capitals";
            remarks.add(FindingKind::Material, Severity::Note, what, thing);
        }
        let index = found.map_or_else(
            || {
                undefined.push(used.as_str());
                blocks.push(Block::grey(used));
                blocks.len() - 1
            },
            |(index, _)| index,
        );
        of_scan.push(index as u32);
    }
    for name in undefined {
        if name == NO_MATERIAL {
            if scan.plain == 0 {
                continue;
            }
            let message = "faces without a material were taken as grey 0.5";
            materials.findings.push(Finding::new(FindingKind::Material, Severity::Warning, message));
        } else if opened.missing.is_empty() {
            // Where a library is missing that goes without saying.
            let what = "materials that no library defines were taken as grey 0.5";
            remarks.add(FindingKind::Material, Severity::Warning, what, format!("'{}'", names::short(name)));
        }
    }
    let all_vanish =
        Passing::all_vanish(blocks.iter().filter(|block| block.defined).map(|block| &block.passing));
    if all_vanish {
        let message = "every material is wholly transparent by its d or Tr, which no program means; all were taken as opaque";
        materials.findings.push(Finding::new(FindingKind::Material, Severity::Warning, message));
        blocks.iter_mut().for_each(|block| block.passing = Passing::default());
    }
    let mut reader = Reader { materials, textures: Textures::default(), remarks, files };
    for block in &blocks {
        reader.add(block);
    }
    let Reader { mut materials, textures, remarks, .. } = reader;
    materials.findings.extend(remarks.findings());
    materials.of_scan = of_scan;
    Ok((materials, textures))
}

struct Reader<'a> {
    materials: Materials,
    textures: Textures,
    remarks: Remarks,
    files: Files<'a>,
}

impl Reader<'_> {
    fn warn(&mut self, what: &str, thing: String) {
        self.remarks.add(FindingKind::Material, Severity::Warning, what, thing);
    }

    fn note(&mut self, what: &str, thing: String) {
        self.remarks.add(FindingKind::Material, Severity::Note, what, thing);
    }

    fn add(&mut self, block: &Block) {
        let name = names::short(&block.name);
        let mut texture = None;
        if let Some((map, library)) = &block.image {
            self.name_options(map, &name);
            match self.textures.load(map, library, self.files) {
                Ok(index) => texture = Some(index),
                Err(reason) => self.warn(
                    "images that cannot be used, so that Kd counts instead, or grey 0.5 where Kd is white, black or missing",
                    format!("'{}' of material '{name}' ({reason})", names::short(&map.image)),
                ),
            }
        }
        let exitance = self.exitance(block, &name);
        let reflectance = self.reflectance(block, &name, texture.is_some(), exitance != [0.0; 3]);
        let mut placement = block.image.as_ref().filter(|_| texture.is_some()).map(|(map, _)| map.placement);
        self.perforate(block, &name, &mut texture, &mut placement);
        self.materials.placements.push(placement.unwrap_or_default());
        self.materials.exitance.push(exitance);
        let has_holes = texture.is_some_and(|t| self.textures.list[t as usize].has_holes());
        let is_glass = exitance == [0.0; 3] && !has_holes;
        let glazing = if is_glass { self.glazing(block, &name) } else { None };
        self.materials.list.push(Material {
            name: block.name.clone(),
            reflectance,
            texture,
            sides: Sides::Auto,
            glazing,
            translucence: [0.0; 3],
        });
    }

    /// Gives the image of a material, or plain white, the holes of its `map_d`, and says how open it is by that or by the
    /// image's own transparent parts.
    fn perforate(
        &mut self,
        block: &Block,
        name: &str,
        texture: &mut Option<u32>,
        placement: &mut Option<Placement>,
    ) {
        if let Some((map, library)) = &block.holes {
            let image = names::short(&map.image);
            match self.textures.perforated(*texture, map, library, self.files) {
                Ok(found) => {
                    if placement.is_some_and(|placement| placement != map.placement) {
                        let what = "images of opacity (map_d) that lie otherwise than the material's map_Kd are laid as that";
                        self.note(what, format!("'{image}' of material '{name}'"));
                    }
                    if found.is_some() {
                        placement.get_or_insert(map.placement);
                        *texture = found;
                    }
                }
                Err(reason) => self.warn(
                    "images of opacity (map_d) that cannot be used, so that the material has no holes",
                    format!("'{image}' of material '{name}' ({reason})"),
                ),
            }
        }
        let used = texture.map(|t| &self.textures.list[t as usize]).filter(|used| used.has_holes());
        if let Some(opacity) = used.map(|used| &used.opacity) {
            let open = 1.0 - opacity.iter().map(|&o| f64::from(o)).sum::<f64>() / opacity.len() as f64;
            let what = "materials with holes by their images (map_d, or the alpha of map_Kd): light passes by their mean";
            self.note(what, format!("'{name}' ({:.0} % of the image is open)", 100.0 * open));
        }
    }

    /// What light passes it, and a word on how that was understood.
    fn glazing(&mut self, block: &Block, name: &str) -> Option<Glazing> {
        let (glazing, understood) = block.passing.glazing()?;
        let share = luminance_weighted(glazing.transmittance(1.0));
        self.note(understood.told(), format!("'{name}' (passes {:.0} %)", 100.0 * share));
        Some(glazing)
    }

    /// Options of an image that have no effect here.
    fn name_options(&mut self, map: &Map, name: &str) {
        for option in map.unheeded() {
            let thing = format!("'{}' of material '{name}'", names::short(option));
            self.note("options of images that have no effect on reflectances here", thing);
        }
    }

    fn reflectance(&mut self, block: &Block, name: &str, textured: bool, emits: bool) -> [f64; 3] {
        let Some(given) = block.kd else {
            if textured {
                return [1.0; 3];
            }
            // An emitter without Kd is common and means a black lamp, as does every other reader.
            if emits {
                return [0.0; 3];
            }
            // Glass reflects nothing evenly; the grey is what it has where glass is not simulated.
            if block.defined && block.image.is_none() && block.passing.glazing().is_none() {
                self.warn("materials without a Kd were taken as grey 0.5", format!("'{name}'"));
            }
            return [DEFAULT_REFLECTANCE; 3];
        };
        if textured && given == [0.0; 3] {
            let what = "materials with an image and a black Kd (0 0 0) show the image, as in most programs";
            self.note(what, format!("'{name}'"));
            return [1.0; 3];
        }
        // White is the factor of an image that shows as it is, and says nothing where it is gone.
        let says_nothing = (given == [0.0; 3] && !emits) || given.iter().all(|k| *k > MAX_REFLECTANCE);
        if block.image.is_some() && !textured && says_nothing {
            return [DEFAULT_REFLECTANCE; 3];
        }
        // The image holds reflectances already; Kd is a factor on it and may be one.
        let largest = if textured { 1.0 } else { MAX_REFLECTANCE };
        let (repaired, repair) = repair_reflectance(given, largest);
        match repair {
            Some(Repair::NotANumber) => {
                let what = "materials with a Kd that is not a number were taken as grey 0.5";
                self.warn(what, format!("'{name}'"));
            }
            Some(Repair::Lowered { from, to }) => {
                let what = format!(
                    "materials with a Kd above {to}, more than any paint reflects, were lowered to it"
                );
                self.warn(&what, format!("'{name}' ({from})"));
            }
            Some(Repair::Raised) => {
                self.warn("materials with a Kd below 0 were raised to it", format!("'{name}'"));
            }
            None => {}
        }
        repaired
    }

    /// Ke is radiance; a diffuse emitter of radiance L has the exitance pi L. An image is a factor on it.
    fn exitance(&mut self, block: &Block, name: &str) -> [f64; 3] {
        const LARGEST: f64 = 1e12;
        let mut given = block.ke.unwrap_or([0.0; 3]);
        if given.iter().any(|e| !e.is_finite() || *e > LARGEST) {
            self.warn("materials with a Ke that is no usable number emit nothing", format!("'{name}'"));
            return [0.0; 3];
        }
        if given.iter().any(|e| *e < 0.0) {
            self.warn("materials with a Ke below 0 were raised to it", format!("'{name}'"));
            given = given.map(|e| e.max(0.0));
        }
        if let Some((map, library)) = &block.glow {
            self.name_options(map, name);
            let image = names::short(&map.image);
            let mean = self.textures.mean(map, library, self.files);
            match (mean, block.ke) {
                (_, Some(ke)) if ke == [0.0; 3] => {
                    let what =
                        "images of emission without effect, as Ke is 0; a Ke of 1 1 1 shows them as they are";
                    self.note(what, format!("'{image}' of material '{name}'"));
                }
                (Ok(mean), Some(_)) => {
                    let what = "images of emission count as their mean times Ke";
                    self.note(what, format!("'{image}' of material '{name}'"));
                    given = std::array::from_fn(|band| given[band] * mean[band]);
                }
                (Ok(mean), None) => {
                    let what = "images of emission count as their mean times a Ke of 1 1 1, as none is given";
                    self.note(what, format!("'{image}' of material '{name}'"));
                    given = mean.map(|m| m.min(LARGEST));
                }
                (Err(reason), _) => {
                    let what = "images of emission that cannot be used, so that Ke alone counts";
                    self.warn(what, format!("'{image}' of material '{name}' ({reason})"));
                }
            }
        }
        given.map(|e| PI * e)
    }
}

/// What was wrong with a reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Repair {
    NotANumber,
    Lowered { from: f64, to: f64 },
    Raised,
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotANumber => f.write_str("that is not a number; it was taken as grey 0.5"),
            Self::Lowered { from, to } => {
                write!(f, "up to {from}, more than any paint reflects; it was lowered to {to}")
            }
            Self::Raised => f.write_str("below 0; it was raised to 0"),
        }
    }
}

/// Brings reflectances into 0..`largest`; the second value says what was done, if anything.
pub(super) fn repair_reflectance(given: [f64; 3], largest: f64) -> ([f64; 3], Option<Repair>) {
    if given.iter().any(|k| k.is_nan()) {
        return ([DEFAULT_REFLECTANCE; 3], Some(Repair::NotANumber));
    }
    let clamped = given.map(|k| k.clamp(0.0, largest));
    if clamped == given {
        return (given, None);
    }
    let top = given.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let repair = if top > largest { Repair::Lowered { from: top, to: largest } } else { Repair::Raised };
    (clamped, Some(repair))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectances_are_brought_into_range_with_a_reason() {
        assert_eq!(repair_reflectance([0.2, 0.5, 0.9], 0.98), ([0.2, 0.5, 0.9], None));
        let (k, why) = repair_reflectance([1.5, 0.5, 0.1], 0.98);
        assert_eq!(k, [0.98, 0.5, 0.1]);
        assert!(why.unwrap().to_string().contains("1.5"));
        assert_eq!(repair_reflectance([-0.5, 0.5, 0.1], 0.98).0, [0.0, 0.5, 0.1]);
        assert_eq!(repair_reflectance([f64::NAN, 0.5, 0.1], 0.98).0, [0.5; 3]);
        assert_eq!(repair_reflectance([f64::INFINITY, 0.5, 0.1], 0.98).0, [0.98, 0.5, 0.1]);
    }
}
