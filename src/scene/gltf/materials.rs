//! Materials of glTF (section 3.9, and the extensions of Khronos) as diffuse ones, panes, holes and emission.
//!
//! What a surface reflects in all is its base colour, whether it is a metal or not. Emission counts in cd/m², as
//! KHR_materials_emissive_strength says.

use super::{File, accessor, is_data, plain_name, resource};
use crate::glazing::{Glazing, WINDOW_GLASS, greatest_transmittance};
use crate::scene::error::SceneError;
use crate::scene::finding::{Finding, FindingKind, Severity};
use crate::scene::glass::Passing;
use crate::scene::map::Map;
use crate::scene::model::Model;
use crate::scene::mtl::{DEFAULT_REFLECTANCE, repair_reflectance};
use crate::scene::names;
use crate::scene::obj::NO_MATERIAL;
use crate::scene::tally::Remarks;
use crate::scene::textures::{Linear, embedded};
use crate::scene::types::{LUMINOUS_EFFICACY, MAX_REFLECTANCE, Material, Texture, luminance_weighted};
use crate::watch::Watch;
use ::gltf::image::Source;
use ::gltf::material::{AlphaMode, Material as Given};
use ::gltf::texture::{Info, Texture as Laid, WrappingMode};
use glam::DVec2;
use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;

/// A lamp that glows less brightly than this, cd/m², is none: its file means other units.
const FAINT: f64 = 50.0;
/// No lamp is brighter than this, W/m².
const BRIGHTEST: f64 = 1e12;

/// How an image lies on a surface (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    /// Which texture coordinates count.
    pub(super) set: u32,
    offset: DVec2,
    /// Radians.
    rotation: f64,
    scale: DVec2,
}

impl Placement {
    fn of(info: &Info<'_>) -> Self {
        let set = info.tex_coord();
        let plain = Self { set, offset: DVec2::ZERO, rotation: 0.0, scale: DVec2::ONE };
        info.texture_transform().map_or(plain, |transform| Self {
            set: transform.tex_coord().unwrap_or(set),
            offset: DVec2::from(transform.offset().map(f64::from)),
            rotation: f64::from(transform.rotation()),
            scale: DVec2::from(transform.scale().map(f64::from)),
        })
    }

    /// Texture coordinates with v upwards of those in the file, whose v is downwards.
    pub(super) fn apply(&self, given: DVec2) -> DVec2 {
        let scaled = given * self.scale;
        let (sin, cos) = self.rotation.sin_cos();
        let turned = DVec2::new(cos * scaled.x + sin * scaled.y, cos * scaled.y - sin * scaled.x);
        let laid = turned + self.offset;
        DVec2::new(laid.x, 1.0 - laid.y)
    }
}

/// What of the materials the polygons need.
pub(super) struct Painted {
    /// For each material of the file, how its image lies.
    pub(super) placements: Vec<Option<Placement>>,
    /// For each, whether it glows and is double-sided.
    pub(super) double_sided: Vec<bool>,
}

/// Reads all materials, and one more for faces without: the last.
pub(super) fn read(file: &File<'_>, model: &mut Model, watch: &mut Watch<'_>) -> Result<Painted, SceneError> {
    let mut reader = Reader {
        file,
        textures: Vec::new(),
        known: HashMap::new(),
        files: Vec::new(),
        remarks: Remarks::default(),
        taken: HashSet::new(),
        brightest: 0.0,
    };
    let mut painted = Painted { placements: Vec::new(), double_sided: Vec::new() };
    let count = file.document.materials().count();
    for (k, given) in file.document.materials().enumerate() {
        watch.done(k as f64 / count as f64)?;
        let (material, exitance, placement) = reader.read(&given, k);
        model.materials.list.push(material);
        model.materials.exitance.push(exitance);
        painted.placements.push(placement);
        painted.double_sided.push(given.double_sided() && exitance != [0.0; 3]);
    }
    watch.done(1.0)?;
    model.materials.list.push(Material::plain(NO_MATERIAL, DEFAULT_REFLECTANCE));
    model.materials.exitance.push([0.0; 3]);
    painted.placements.push(None);
    painted.double_sided.push(false);
    if reader.brightest > 0.0 && reader.brightest < FAINT {
        let message = format!(
            "what glows in the model is as bright as {:.3} cd/m² at most, fainter than any lamp; glTF counts emission in \
             cd/m², which not all programs heed: give the lamps their lumens in the window or the sidecar",
            reader.brightest
        );
        model.findings.push(Finding::new(FindingKind::Lamp, Severity::Warning, message));
    }
    model.findings.extend(reader.remarks.findings());
    model.textures.append(&mut reader.textures);
    model.files.append(&mut reader.files);
    Ok(painted)
}

/// What an image is used for: its number, whether it is clamped, and how its opacity counts.
type Use = (usize, bool, Opacity);

/// How the opacity of an image counts.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Opacity {
    Ignored,
    /// All or nothing: opaque at or above this, after the factor; bits of both.
    Cut([u32; 2]),
    /// By this factor; its bits.
    Blended(u32),
}

struct Reader<'a> {
    file: &'a File<'a>,
    textures: Vec<Texture>,
    known: HashMap<Use, Result<u32, String>>,
    files: Vec<std::path::PathBuf>,
    remarks: Remarks,
    /// Names of materials, which are to differ.
    taken: HashSet<String>,
    /// Luminance of what glows most brightly, cd/m².
    brightest: f64,
}

impl Reader<'_> {
    fn read(&mut self, given: &Given<'_>, number: usize) -> (Material, [f64; 3], Option<Placement>) {
        let name = match given.name().map(plain_name).filter(|name| !name.is_empty()) {
            Some(name) => names::unique(&name, &mut self.taken),
            None => names::unique(&format!("material {}", number + 1), &mut self.taken),
        };
        let mut material = Material::plain(&name, DEFAULT_REFLECTANCE);
        let (factor, image) = base(given);
        let opacity = match given.alpha_mode() {
            AlphaMode::Opaque => Opacity::Ignored,
            AlphaMode::Mask => {
                Opacity::Cut([given.alpha_cutoff().unwrap_or(0.5).to_bits(), factor[3].to_bits()])
            }
            AlphaMode::Blend => Opacity::Blended(factor[3].to_bits()),
        };
        let mut placement = None;
        if let Some(info) = &image {
            match self.image(&info.texture(), opacity) {
                Ok(index) => {
                    material.texture = Some(index);
                    placement = Some(Placement::of(info));
                }
                Err(reason) => {
                    let what = "images that cannot be used, so that the base colour counts instead, or grey 0.5 where that is white";
                    self.remark(
                        Severity::Warning,
                        what,
                        format!("of material '{}' ({reason})", names::short(&name)),
                    );
                }
            }
        }
        material.reflectance = self.reflectance(factor, image.is_some(), material.texture.is_some(), &name);
        let exitance = self.exitance(given, &name);
        let has_holes = material.texture.is_some_and(|t| self.textures[t as usize].has_holes());
        if exitance == [0.0; 3] && !has_holes {
            material.glazing = self.glazing(given, factor, &name);
        }
        (material, exitance, placement)
    }

    fn remark(&mut self, severity: Severity, what: &str, thing: String) {
        self.remarks.add(FindingKind::Material, severity, what, thing);
    }

    fn reflectance(&mut self, factor: [f32; 4], has_image: bool, textured: bool, name: &str) -> [f64; 3] {
        let [r, g, b, _] = factor.map(f64::from);
        let given = [r, g, b];
        // White is the factor of an image that shows as it is, and says nothing where it is gone.
        if has_image && !textured && given.iter().all(|k| *k > MAX_REFLECTANCE) {
            return [DEFAULT_REFLECTANCE; 3];
        }
        let (repaired, repair) = repair_reflectance(given, if textured { 1.0 } else { MAX_REFLECTANCE });
        // White is the base colour that a file leaves out, and needs no word; what is beyond it does.
        if let Some(repair) = repair.filter(|_| given.iter().any(|k| !(0.0..=1.0).contains(k))) {
            let what = "materials with a base colour that no surface has";
            self.remark(Severity::Warning, what, format!("'{}' ({repair})", names::short(name)));
        }
        repaired
    }

    /// Exitance, W/m² per band, of what glows with a luminance.
    fn exitance(&mut self, given: &Given<'_>, name: &str) -> [f64; 3] {
        let strength = f64::from(given.emissive_strength().unwrap_or(1.0));
        let mut glow = given.emissive_factor().map(|factor| f64::from(factor) * strength);
        if glow == [0.0; 3] {
            return [0.0; 3];
        }
        if glow.iter().any(|value| !(0.0..=BRIGHTEST).contains(value)) {
            let what = "materials with an emission that is no usable number emit nothing";
            self.remark(Severity::Warning, what, format!("'{}'", names::short(name)));
            return [0.0; 3];
        }
        if let Some(info) = given.emissive_texture() {
            let what = match self.decoded(&info.texture()) {
                Ok(image) => {
                    let mean = image.mean();
                    glow = std::array::from_fn(|band| glow[band] * mean[band]);
                    "images of emission count as their mean times the factor"
                }
                Err(_) => "images of emission that cannot be used, so that the factor alone counts",
            };
            self.remark(Severity::Note, what, format!("of material '{}'", names::short(name)));
        }
        self.brightest = self.brightest.max(luminance_weighted(glow));
        glow.map(|luminance| PI * luminance / LUMINOUS_EFFICACY)
    }

    /// The pane that a material is by KHR_materials_transmission, or by an opacity below 1.
    fn glazing(&mut self, given: &Given<'_>, factor: [f32; 4], name: &str) -> Option<Glazing> {
        let index = given.ior().map_or(WINDOW_GLASS, f64::from);
        let index = if (1.1..=4.0).contains(&index) { index } else { WINDOW_GLASS };
        let transmission =
            given.transmission().map_or(0.0, |transmission| transmission.transmission_factor());
        let [r, g, b, alpha] = factor.map(f64::from);
        let pane = if transmission > 0.0 {
            let most = greatest_transmittance(index);
            let share = [r, g, b].map(|tint| (tint * f64::from(transmission)).clamp(0.0, most));
            Glazing::of_unit(1, index, share).ok()?
        } else {
            let is_blended = given.alpha_mode() == AlphaMode::Blend;
            let d = is_blended.then_some(alpha).filter(|alpha| alpha.is_finite());
            Passing { d, index: Some(index), ..Passing::default() }.glazing()?.0
        };
        let share = luminance_weighted(pane.transmittance(1.0));
        let what =
            "see-through materials (by transmission, or blended with an opacity below 1) are glass here";
        self.remark(
            Severity::Note,
            what,
            format!("'{}' (passes {:.0} %)", names::short(name), 100.0 * share),
        );
        Some(pane)
    }

    /// Index of an image as it is used here, decoded on first use; the error is the reason in a few words.
    fn image(&mut self, texture: &Laid<'_>, opacity: Opacity) -> Result<u32, String> {
        let sampler = texture.sampler();
        let wraps = [sampler.wrap_s(), sampler.wrap_t()];
        let clamped = wraps == [WrappingMode::ClampToEdge; 2];
        if !clamped && wraps != [WrappingMode::Repeat; 2] {
            let what = "images that are to be mirrored, or clamped along one axis alone, are repeated beyond their edges";
            self.remark(Severity::Note, what, format!("'{}'", names::short(&self.name_of(source(texture)?))));
        }
        let key = (source(texture)?, clamped, opacity);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let read = self.decoded(texture).map(|image| {
            let image = match opacity {
                Opacity::Ignored => image.opaque(),
                Opacity::Cut(bits) => {
                    let [limit, factor] = bits.map(f32::from_bits);
                    image.with_opacities(|alpha| f32::from(u8::from(alpha * factor >= limit)))
                }
                Opacity::Blended(bits) if image.has_alpha() => {
                    // In whole steps, as in a file: none of them is just half, by which pictures decide.
                    let steps = f32::from(u8::MAX);
                    image.with_opacities(|alpha| {
                        (steps * (alpha * f32::from_bits(bits)).clamp(0.0, 1.0)).round() / steps
                    })
                }
                Opacity::Blended(_) => image,
            };
            let map = Map { image: self.name_of(key.0), clamped, ..Map::default() };
            self.textures.push(image.texture(&map));
            self.textures.len() as u32 - 1
        });
        self.known.insert(key, read.clone());
        read
    }

    fn name_of(&self, image: usize) -> String {
        let given = self.file.document.images().nth(image);
        let named = given.as_ref().and_then(|image| match image.source() {
            Source::Uri { uri, .. } if !is_data(uri) => Some(uri.to_owned()),
            _ => image.name().map(str::to_owned),
        });
        named.unwrap_or_else(|| format!("image {}", image + 1))
    }

    fn decoded(&mut self, texture: &Laid<'_>) -> Result<Linear, String> {
        let number = source(texture)?;
        let image = self.file.document.images().nth(number).ok_or("it is not in the file")?;
        let bytes = match image.source() {
            Source::View { view, .. } => accessor::bytes(&view, self.file.buffers)?.to_vec(),
            Source::Uri { uri, .. } => resource(uri, self.file.given.files, &mut self.files)?,
        };
        embedded(&self.name_of(number), bytes, self.file.given.files)
    }
}

/// Base colour with its opacity, and its image.
fn base<'a>(given: &Given<'a>) -> ([f32; 4], Option<Info<'a>>) {
    if let Some(older) = given.pbr_specular_glossiness() {
        // What is not reflected diffusely is reflected by the surface.
        let [r, g, b, alpha] = older.diffuse_factor();
        let specular = older.specular_factor();
        // The specular factor is white where it is left out, which says nothing of a paint.
        let is_said = specular != [1.0; 3];
        let sum = |diffuse: f32, band: usize| match is_said {
            true => (diffuse + specular[band] * (1.0 - diffuse)).min(1.0),
            false => diffuse,
        };
        return ([sum(r, 0), sum(g, 1), sum(b, 2), alpha], older.diffuse_texture());
    }
    let metallic = given.pbr_metallic_roughness();
    (metallic.base_color_factor(), metallic.base_color_texture())
}

/// Number of the image of a texture; that in WebP where there is one.
fn source(texture: &Laid<'_>) -> Result<usize, String> {
    let webp = texture.extension_value("EXT_texture_webp").and_then(|own| own["source"].as_u64());
    let plain = texture.source().map(|image| image.index());
    let found = plain.or(webp.and_then(|index| usize::try_from(index).ok()));
    found.ok_or_else(|| match texture.extension_value("KHR_texture_basisu") {
        Some(_) => "its format is KTX2; PNG, JPEG and WebP are read".to_owned(),
        None => "it names no image".to_owned(),
    })
}
