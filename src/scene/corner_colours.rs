//! Colours that a file gives to the corners of faces, as an image: light is computed with reflectances that are those
//! of materials and images.
//!
//! Each face has a tile of two by two pixels of its own. Between the middles of its pixels an image is bilinear, so that
//! a triangle is shaded from corner to corner as its file means it.

use super::model::{Face, Polygons};
use super::mtl::Materials;
use super::types::{MAX_REFLECTANCE, Material, Texture, luminance_weighted};
use glam::DVec2;

/// Name of the material of faces that have none but their colours.
pub(super) const NAME: &str = "Colours of corners";

/// Linear reflectances at the corners of a face, by its number.
pub(super) type FaceColours = (usize, Vec<[f32; 3]>);

/// Colours nearer to each other than this, per band, are one.
const SAME: f32 = 1e-3;

/// Gives faces a material like `template` with the colours of their corners, in place of theirs. Those in `colours` have
/// a colour for each of their corners.
pub(super) fn lay(
    mut colours: Vec<FaceColours>,
    template: Material,
    exitance: [f64; 3],
    polygons: &mut Polygons,
    (materials, textures): (&mut Materials, &mut Vec<Texture>),
) {
    let limit = |value: f32| if value.is_finite() { value.clamp(0.0, MAX_REFLECTANCE as f32) } else { 0.0 };
    for colour in colours.iter_mut().flat_map(|(_, corners)| corners) {
        *colour = colour.map(limit);
    }
    let Some(&first) = colours.iter().flat_map(|(_, corners)| corners).next() else { return };
    let number = materials.list.len() as u32;
    let is_same = |colour: &[f32; 3]| (0..3).all(|band| (colour[band] - first[band]).abs() <= SAME);
    let mut material = template;
    if colours.iter().flat_map(|(_, corners)| corners).all(is_same) {
        material.reflectance = first.map(f64::from);
        colours.iter().for_each(|(face, _)| polygons.faces[*face].material = number);
    } else {
        let (width, height) = sheet(colours.len());
        let mut texture = Texture {
            name: material.name.clone(),
            width,
            height,
            clamped: true,
            mean: [0.0; 3],
            pixels: vec![[0.0; 3]; (width * height) as usize],
            opacity: Vec::new(),
        };
        for (tile, (face, corners)) in (0_u32..).zip(&colours) {
            let face = &mut polygons.faces[*face];
            face.material = number;
            let at = [2 * (tile % (width / 2)), 2 * (tile / (width / 2))];
            draw(&mut texture, at, corners);
            place(face, at, (width, height), &mut polygons.uvs);
        }
        texture.mean = mean(&colours);
        material.reflectance = [1.0; 3];
        material.texture = Some(textures.len() as u32);
        textures.push(texture);
    }
    materials.list.push(material);
    materials.exitance.push(exitance);
    materials.placements.push(Default::default());
}

/// Width and height of an image, pixels, with room for so many tiles: about square, and even.
fn sheet(tiles: usize) -> (u32, u32) {
    let columns = (tiles as f64).sqrt().ceil().max(1.0) as u32;
    (2 * columns, 2 * (tiles as u32).div_ceil(columns))
}

/// The pixels of a tile, from its upper left corner at `[x, y]`.
fn draw(texture: &mut Texture, [x, y]: [u32; 2], corners: &[[f32; 3]]) {
    let tile: [[f32; 3]; 4] = match *corners {
        // The fourth pixel makes the tile a plane, as far as a reflectance can be so.
        [a, b, c] => {
            let d = std::array::from_fn(|band| b[band] + c[band] - a[band]);
            [a, b, c, d.map(|value: f32| value.clamp(0.0, MAX_REFLECTANCE as f32))]
        }
        [a, b, c, d] => [a, b, d, c],
        _ => {
            let sum = |band: usize| corners.iter().map(|colour| colour[band]).sum::<f32>();
            [std::array::from_fn(|band| sum(band) / corners.len() as f32); 4]
        }
    };
    for (k, colour) in (0_u32..).zip(tile) {
        texture.pixels[((y + k / 2) * texture.width + x + k % 2) as usize] = colour;
    }
}

/// Lays the corners of a face on the middles of the pixels of its tile.
fn place(face: &mut Face, [x, y]: [u32; 2], (width, height): (u32, u32), uvs: &mut Vec<DVec2>) {
    let ring: &[[f64; 2]] = match face.corners.len() {
        3 => &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        4 => &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        _ => &[[0.5, 0.5]],
    };
    for (corner, [right, down]) in face.corners.iter_mut().zip(ring.iter().cycle()) {
        let u = (f64::from(x) + 0.5 + right) / f64::from(width);
        let v = 1.0 - (f64::from(y) + 0.5 + down) / f64::from(height);
        corner.2 = Some(uvs.len() as u32);
        uvs.push(DVec2::new(u, v));
    }
}

/// The mean of all corners. Those who know where on a face they are look into the image.
fn mean(colours: &[FaceColours]) -> [f64; 3] {
    let all = || colours.iter().flat_map(|(_, corners)| corners);
    let count = all().count().max(1) as f64;
    std::array::from_fn(|band| all().map(|colour| f64::from(colour[band])).sum::<f64>() / count)
}

/// Whether colours say something: white ones are what exporters write where there is none.
pub(super) fn say_something(colours: &[FaceColours]) -> bool {
    let is_white = |colour: &[f32; 3]| luminance_weighted(colour.map(f64::from)) > 1.0 - f64::from(SAME);
    !colours.iter().flat_map(|(_, corners)| corners).all(is_white)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygons(rings: &[usize]) -> Polygons {
        let face = |count: &usize| Face {
            corners: (0..*count as u32).map(|k| (k, None, None)).collect(),
            object: 0,
            material: 0,
            line: None,
        };
        Polygons { faces: rings.iter().map(face).collect(), ..Polygons::default() }
    }

    fn laid(colours: Vec<FaceColours>, polygons: &mut Polygons) -> (Materials, Vec<Texture>) {
        let (mut materials, mut textures) = (Materials::default(), Vec::new());
        lay(colours, Material::plain("colours", 0.5), [0.0; 3], polygons, (&mut materials, &mut textures));
        (materials, textures)
    }

    #[test]
    fn a_triangle_and_a_square_are_shaded_from_corner_to_corner_and_others_are_even() {
        let [r, g, b, w] = [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.6], [0.7; 3]];
        let mut polygons = polygons(&[3, 4, 5, 3, 3]);
        let colours = vec![
            (0, vec![r, g, b]),
            (1, vec![w, r, g, b]),
            (2, vec![r, g, b, w, w]),
            (3, vec![b; 3]),
            (4, vec![g, g, r]),
        ];
        let (materials, textures) = laid(colours.clone(), &mut polygons);
        assert_eq!(materials.list[0].reflectance, [1.0; 3]);
        for (face, corners) in &colours {
            let uvs: Vec<DVec2> =
                polygons.faces[*face].corners.iter().map(|c| polygons.uvs[c.2.unwrap() as usize]).collect();
            let at = |weights: &[f64]| {
                textures[0].sample(uvs.iter().zip(weights).map(|(uv, weight)| *uv * *weight).sum())
            };
            for k in 0..corners.len() {
                let mut weights = vec![0.0; corners.len()];
                weights[k] = 1.0;
                let mean = |band: usize| corners.iter().map(|c| c[band]).sum::<f32>() / corners.len() as f32;
                let expected = if corners.len() == 5 { [0, 1, 2].map(mean) } else { corners[k] };
                let found = at(&weights);
                assert!(
                    (0..3).all(|band| (found[band] - expected[band]).abs() < 1e-5),
                    "face {face} corner {k}"
                );
            }
            if corners.len() == 3 {
                let middle = at(&[1.0 / 3.0; 3]);
                let mean = |band: usize| corners.iter().map(|c| c[band]).sum::<f32>() / 3.0;
                assert!(
                    (0..3).all(|band| (middle[band] - mean(band)).abs() < 0.07),
                    "face {face}: {middle:?}"
                );
            }
        }
    }

    #[test]
    fn one_colour_is_a_plain_material_and_white_says_nothing() {
        let mut polygons = polygons(&[3]);
        let (materials, textures) = laid(vec![(0, vec![[0.25, 0.5, 2.0]; 3])], &mut polygons);
        assert!(textures.is_empty() && polygons.uvs.is_empty());
        assert_eq!(materials.list[0].reflectance, [0.25, 0.5, f64::from(MAX_REFLECTANCE as f32)]);
        assert!(!say_something(&[(0, vec![[1.0; 3]; 3])]) && say_something(&[(0, vec![[1.0, 1.0, 0.9]; 3])]));
        assert!(!say_something(&[]));
    }
}
