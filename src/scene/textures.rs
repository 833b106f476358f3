//! Images of `map_` statements, decoded to linear light.

use super::lookup::{Files, read_plain, reason};
use super::map::Map;
use super::types::{MAX_REFLECTANCE, Texture};
use crate::watch::Cancelled;
use image::{ImageFormat, ImageReader};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// An image file and how it is used: whether it is clamped, and the bits of its range.
type Use = (PathBuf, bool, Option<[u64; 2]>);

/// Decoded images, each file once for every way in which it is used.
#[derive(Debug, Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    known: HashMap<Use, Result<u32, String>>,
    means: HashMap<PathBuf, Result<[f64; 3], String>>,
}

impl Textures {
    /// Index of an image of reflectances that a library names, decoded on first use; the error is the
    /// reason in a few words.
    pub(super) fn load(&mut self, map: &Map, library: &Path, files: Files<'_>) -> Result<u32, String> {
        let path = files.image(&map.image, library).map_err(|error| reason(&error))?;
        let key = (path, map.clamped, map.range.map(|range| range.map(f64::to_bits)));
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let index = linear(&key.0, files).map(|image| {
            self.list.push(image.texture(map));
            self.list.len() as u32 - 1
        });
        self.known.insert(key, index.clone());
        index
    }

    /// Mean of an image of emissions per band, 0 or more.
    pub(super) fn mean(&mut self, map: &Map, library: &Path, files: Files<'_>) -> Result<[f64; 3], String> {
        let path = files.image(&map.image, library).map_err(|error| reason(&error))?;
        let mean =
            self.means.entry(path).or_insert_with_key(|path| linear(path, files).map(|image| image.mean()));
        let [base, gain] = map.range.unwrap_or([0.0, 1.0]);
        mean.clone().map(|mean| mean.map(|m| (base + gain * m).max(0.0)))
    }
}

/// A decoded image: linear values in 0..1, row by row from the top.
struct Linear {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

/// Reads an image on a thread of its own: whoever cancels is not to wait for a large one.
fn linear(path: &Path, files: Files<'_>) -> Result<Linear, String> {
    let file = path.to_owned();
    let read = move || decode(&file, &read_plain(&file).map_err(|error| reason(&error))?);
    match files.apart(read) {
        Ok(Some(image)) => image,
        Ok(None) => Err("it cannot be decoded".to_owned()),
        Err(Cancelled) => Err("reading was ended".to_owned()),
    }
}

/// The formats that are read, by the bytes or, as TGA cannot be told by them, by the ending.
fn decode(path: &Path, bytes: &[u8]) -> Result<Linear, String> {
    const FORMATS: &str = "PNG, JPEG, TGA, BMP, TIFF, WebP and GIF are read";
    let guessed = image::guess_format(bytes).ok().filter(ImageFormat::reading_enabled);
    let named = ImageFormat::from_path(path).ok().filter(ImageFormat::reading_enabled);
    let formats = guessed.into_iter().chain(named.filter(|&named| Some(named) != guessed));
    let mut failure = format!("its format is not known; {FORMATS}");
    for format in formats {
        match ImageReader::with_format(Cursor::new(bytes), format).decode() {
            Ok(image) => return Linear::of(&image.to_rgb8()),
            // The image crate's messages may run over several lines.
            Err(error) => {
                failure = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
            }
        }
    }
    Err(failure)
}

impl Linear {
    fn of(image: &image::RgbImage) -> Result<Self, String> {
        let (width, height) = image.dimensions();
        if width == 0 || height == 0 {
            return Err("it has no pixels".to_owned());
        }
        let mut linear = [0.0_f32; 256];
        for (code, value) in linear.iter_mut().enumerate() {
            *value = srgb_to_linear(code as f64 / 255.0) as f32;
        }
        let pixels = image.pixels().map(|pixel| pixel.0.map(|code| linear[usize::from(code)])).collect();
        Ok(Self { width, height, pixels })
    }

    /// An image of reflectances, capped at [`MAX_REFLECTANCE`] as those of plain materials are.
    fn texture(mut self, map: &Map) -> Texture {
        let [base, gain] = map.range.unwrap_or([0.0, 1.0]);
        for value in self.pixels.iter_mut().flatten() {
            *value = (base + gain * f64::from(*value)).clamp(0.0, MAX_REFLECTANCE) as f32;
        }
        Texture {
            mean: self.mean(),
            name: map.image.clone(),
            width: self.width,
            height: self.height,
            clamped: map.clamped,
            pixels: self.pixels,
        }
    }

    fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in &self.pixels {
            for band in 0..3 {
                sum[band] += f64::from(pixel[band]);
            }
        }
        sum.map(|sum| sum / self.pixels.len().max(1) as f64)
    }
}

/// IEC 61966-2-1.
fn srgb_to_linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(pixels: &[[u8; 3]], format: ImageFormat) -> Vec<u8> {
        let image = image::RgbImage::from_fn(pixels.len() as u32, 1, |x, _| image::Rgb(pixels[x as usize]));
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn texture(pixels: &[[u8; 3]], map: &str) -> Texture {
        decode(Path::new("t"), &bytes(pixels, ImageFormat::Png)).unwrap().texture(&Map::parse(map))
    }

    #[test]
    fn codes_become_linear_and_white_stays_below_one() {
        let texture = texture(&[[0, 128, 255], [10, 10, 10]], "t.png");
        assert_eq!((texture.width, texture.height, texture.clamped), (2, 1, false));
        let [black, middle, white] = texture.pixels[0];
        assert_eq!(black, 0.0);
        assert!((middle - 0.215_861).abs() < 1e-5, "{middle}");
        assert_eq!(white, MAX_REFLECTANCE as f32);
        assert!((texture.pixels[1][0] - 0.003_035_3).abs() < 1e-6);
        assert!((texture.mean[1] - (0.215_861 + 0.003_035_3) / 2.0).abs() < 1e-6);
    }

    #[test]
    fn range_and_clamping_are_those_of_the_options() {
        let image = texture(&[[0, 128, 255]], "-mm 0.1 0.5 -clamp on t.png");
        let [black, middle, white] = image.pixels[0];
        assert!((black - 0.1).abs() < 1e-6 && (white - 0.6).abs() < 1e-6, "{:?}", image.pixels);
        assert!((middle - (0.1 + 0.5 * 0.215_861)).abs() < 1e-5 && image.clamped);
        assert_eq!(texture(&[[255; 3]], "-mm 0 -2 t").pixels[0], [0.0; 3]);
    }

    #[test]
    fn formats_are_known_by_their_bytes_or_their_ending() {
        for (format, name) in [
            (ImageFormat::Png, "a.jpg"),
            (ImageFormat::Jpeg, "a"),
            (ImageFormat::Tga, "a.TGA"),
            (ImageFormat::Bmp, "a.bmp"),
            (ImageFormat::Tiff, "a.tif"),
            (ImageFormat::WebP, "a.webp"),
            (ImageFormat::Gif, "a.gif"),
        ] {
            let image = decode(Path::new(name), &bytes(&[[188; 3]; 64], format)).unwrap();
            let grey = image.pixels[30][1];
            assert!((grey - 0.502_886).abs() < 0.01 && image.width == 64, "{name}: {grey}");
        }
        let unknown = decode(Path::new("a.dds"), b"DDS |").err().unwrap();
        assert!(unknown.contains("PNG, JPEG, TGA"), "{unknown}");
    }

    #[test]
    fn each_file_is_decoded_once_and_damage_is_a_reason_not_a_panic() {
        let folder = tempfile::tempdir().unwrap();
        let whole = bytes(&[[200, 100, 50]; 64], ImageFormat::Png);
        std::fs::write(folder.path().join("whole.png"), &whole).unwrap();
        std::fs::write(folder.path().join("cut.png"), &whole[..whole.len() / 2]).unwrap();
        let mut textures = Textures::default();
        let mut load = |map: &str| {
            let library = folder.path().join("a.mtl");
            textures.load(&Map::parse(map), &library, Files::beside(folder.path()))
        };
        assert_eq!(load("whole.png"), Ok(0));
        assert_eq!(load("-s 2 2 WHOLE.png"), Ok(0));
        assert_eq!(load("-clamp on whole.png"), Ok(1));
        assert!(load("cut.png").is_err());
        assert_eq!(load("none.png"), Err("there is no such file".to_owned()));
        assert_eq!(textures.list.len(), 2);
    }
}
