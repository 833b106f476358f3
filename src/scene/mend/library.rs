//! A material library for a copy of a model that came without one: OBJ is written, whatever was read.

use crate::scene::textures::linear_to_srgb;
use crate::scene::types::{Material, Scene, Texture};
use std::collections::HashSet;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

/// An image that a copy needs.
#[derive(Clone, Debug)]
pub struct CopiedImage {
    /// Its name beside the copy.
    pub name: String,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// R, G, B (sRGB) and opacity of each pixel, row by row from the top.
    pub rgba: Vec<u8>,
}

/// The library of those of a scene's own materials that are asked for, and the images that they name, for a copy at this path.
pub(super) fn made(
    scene: &Scene,
    copy: &Path,
    wanted: impl Fn(&Material) -> bool,
) -> (String, Vec<CopiedImage>) {
    let stem = copy.file_stem().unwrap_or_default().to_string_lossy();
    // A blank at the beginning would be none in a statement.
    let stem = stem.trim();
    let mut used: HashSet<u32> = HashSet::new();
    let name_of = |texture: u32| format!("{stem}-{}.png", texture + 1);
    let mut text = String::new();
    for (number, material) in (0_u32..).zip(scene.own_materials()).filter(|(_, material)| wanted(material)) {
        used.extend(material.texture);
        let _ = writeln!(text, "newmtl {}", material.name);
        let mut line = |statement: &str, values: [f64; 3]| {
            let _ = writeln!(text, "{statement} {} {} {}", values[0], values[1], values[2]);
        };
        line("Kd", material.reflectance);
        if let Some(radiance) = radiance(scene, number) {
            line("Ke", radiance);
        }
        if let Some(glazing) = &material.glazing {
            line("Tf", glazing.transmittance(1.0));
            let index = glazing.panes().first().map_or(1.5, |pane| pane.index());
            let _ = writeln!(text, "illum 4\nNi {index}");
        }
        if let Some(texture) = material.texture {
            let clamped = if scene.textures[texture as usize].clamped { "-clamp on " } else { "" };
            let _ = writeln!(text, "map_Kd {clamped}{}", name_of(texture));
        }
    }
    let image = |(number, texture): (u32, &Texture)| CopiedImage {
        name: name_of(number),
        size: [texture.width, texture.height],
        rgba: rgba(texture),
    };
    let images = (0..).zip(&scene.textures).filter(|(number, _)| used.contains(number)).map(image).collect();
    (text, images)
}

/// The radiance of a material, W/(m² sr) per band, where all its surfaces emit.
fn radiance(scene: &Scene, material: u32) -> Option<[f64; 3]> {
    let mut surfaces = scene.surfaces.iter().filter(|surface| surface.material == material).peekable();
    let first = *surfaces.peek()?;
    if !surfaces.all(|surface| surface.luminaire.is_some()) {
        return None;
    }
    let exitance = scene.luminaires.get(first.luminaire? as usize)?.initial.exitance;
    Some(std::array::from_fn(|band| exitance[band] * first.emission_weight[band] / PI))
}

fn rgba(texture: &Texture) -> Vec<u8> {
    let byte = |share: f64| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let pixel = |(index, pixel): (usize, &[f32; 3])| {
        let [r, g, b] = pixel.map(|value| byte(linear_to_srgb(f64::from(value))));
        let opacity = texture.opacity.get(index).map_or(1.0, |&opacity| f64::from(opacity));
        [r, g, b, byte(opacity)]
    };
    texture.pixels.iter().enumerate().flat_map(pixel).collect()
}
