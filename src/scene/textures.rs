//! Images of `map_Kd`, decoded to linear light.

use super::types::{MAX_REFLECTANCE, Texture};
use std::collections::HashMap;

/// Decoded images, each file once.
#[derive(Debug, Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    known: HashMap<String, Result<u32, String>>,
}

impl Textures {
    /// Index of the image `name`, decoded on first use; the error is the reason in a few words.
    pub(super) fn load(
        &mut self,
        name: &str,
        read: &dyn Fn(&str) -> std::io::Result<Vec<u8>>,
    ) -> Result<u32, String> {
        if let Some(known) = self.known.get(name) {
            return known.clone();
        }
        let loaded = read(name).map_err(|error| error.to_string()).and_then(|bytes| decode(name, &bytes));
        let index = loaded.map(|texture| {
            self.list.push(texture);
            self.list.len() as u32 - 1
        });
        self.known.insert(name.to_owned(), index.clone());
        index
    }
}

/// PNG or JPEG bytes to linear reflectances. They are capped at [`MAX_REFLECTANCE`], as those of
/// plain materials are.
fn decode(name: &str, bytes: &[u8]) -> Result<Texture, String> {
    let image = image::load_from_memory(bytes).map_err(|error| {
        // The image crate's messages may run over several lines.
        error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
    })?;
    let image = image.to_rgb8();
    let (width, height) = image.dimensions();
    if width == 0 || height == 0 {
        return Err("it has no pixels".to_owned());
    }
    let mut linear = [0.0_f32; 256];
    for (code, value) in linear.iter_mut().enumerate() {
        *value = srgb_to_linear(code as f64 / 255.0).min(MAX_REFLECTANCE) as f32;
    }
    let pixels = image.pixels().map(|pixel| pixel.0.map(|code| linear[usize::from(code)])).collect();
    Ok(Texture { name: name.to_owned(), width, height, pixels })
}

/// IEC 61966-2-1.
fn srgb_to_linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(pixels: &[[u8; 3]]) -> Vec<u8> {
        let image = image::RgbImage::from_fn(pixels.len() as u32, 1, |x, _| image::Rgb(pixels[x as usize]));
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn codes_become_linear_and_white_stays_below_one() {
        let texture = decode("t.png", &png(&[[0, 128, 255], [10, 10, 10]])).unwrap();
        assert_eq!((texture.width, texture.height), (2, 1));
        let [black, middle, white] = texture.pixels[0];
        assert_eq!(black, 0.0);
        assert!((middle - 0.215_861).abs() < 1e-5, "{middle}");
        assert_eq!(white, MAX_REFLECTANCE as f32);
        assert!((texture.pixels[1][0] - 0.003_035_3).abs() < 1e-6);
    }

    #[test]
    fn each_file_is_read_once_and_damage_is_a_reason_not_a_panic() {
        let whole = png(&[[200, 100, 50]; 64]);
        let reads = std::cell::Cell::new(0);
        let read = |name: &str| {
            reads.set(reads.get() + 1);
            match name {
                "whole.png" => Ok(whole.clone()),
                "cut.png" => Ok(whole[..whole.len() / 2].to_vec()),
                _ => Err(std::io::Error::from(std::io::ErrorKind::NotFound)),
            }
        };
        let mut textures = Textures::default();
        assert_eq!(textures.load("whole.png", &read), Ok(0));
        assert_eq!(textures.load("whole.png", &read), Ok(0));
        assert_eq!(reads.get(), 1);
        assert!(textures.load("cut.png", &read).is_err());
        assert!(textures.load("none.png", &read).is_err());
        assert_eq!(textures.list.len(), 1);
    }
}
