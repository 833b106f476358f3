//! Images of `map_` statements, decoded to linear light.

use super::lookup::{Files, read_plain, reason};
use super::map::Map;
use super::types::{MAX_REFLECTANCE, Texture, luminance_weighted};
use crate::watch::Cancelled;
use glam::DVec2;
use image::{ImageFormat, ImageReader};
use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// An image file and how it is used: whether it is clamped, and the bits of its range.
type Use = (PathBuf, bool, Option<[u64; 2]>);

/// The image that gets holes, how the image that tells them is used, and by which channel.
type Perforation = (Option<u32>, Use, Channel);

/// Decoded images, each file once for every way in which it is used.
#[derive(Debug, Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    known: HashMap<Use, Result<u32, String>>,
    means: HashMap<PathBuf, Result<[f64; 3], String>>,
    perforated: HashMap<Perforation, Result<Option<u32>, String>>,
}

/// Which channel of an image tells how opaque it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Channel {
    /// Its alpha where that varies, else its brightness.
    Whichever,
    Alpha,
    Brightness,
}

/// An image that is more opaque than this in the mean has no holes.
const SOLID: f64 = 0.995;

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

    /// Index of `image`, or of plain white, with the holes of an image of opacities; `None` where that has none. The error
    /// is the reason in a few words.
    pub(super) fn perforated(
        &mut self,
        image: Option<u32>,
        holes: &Map,
        library: &Path,
        files: Files<'_>,
    ) -> Result<Option<u32>, String> {
        let path = files.image(&holes.image, library).map_err(|error| reason(&error))?;
        let channel = match holes.others.iter().find_map(|option| option.strip_prefix("-imfchan ")) {
            Some("m") => Channel::Alpha,
            Some("l" | "r" | "g" | "b") => Channel::Brightness,
            _ => Channel::Whichever,
        };
        let range = holes.range.map(|range| range.map(f64::to_bits));
        let key = (image, (path, holes.clamped, range), channel);
        if let Some(known) = self.perforated.get(&key) {
            return known.clone();
        }
        let found = linear(&key.1.0, files).map(|read| {
            let opacity = read.opacities(channel, holes.range);
            let base = image.and_then(|index| self.list.get(index as usize));
            let texture = perforated(base, (holes, read.width, read.height), opacity)?;
            self.list.push(texture);
            Some(self.list.len() as u32 - 1)
        });
        self.perforated.insert(key, found.clone());
        found
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
pub(super) struct Linear {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    /// Empty where it is opaque everywhere, or says to be invisible.
    alpha: Vec<f32>,
}

/// An image, or white of the size of the opacities, with these; `None` where they leave it whole.
fn perforated(
    base: Option<&Texture>,
    (map, width, height): (&Map, u32, u32),
    opacity: Vec<f32>,
) -> Option<Texture> {
    let holes = Texture {
        name: map.image.clone(),
        width,
        height,
        clamped: map.clamped,
        mean: [1.0; 3],
        pixels: vec![[1.0; 3]; opacity.len()],
        opacity,
    };
    let mut texture = match base {
        None => holes,
        Some(base) => {
            let (w, h) = (base.width, base.height);
            let at = |index: u32| {
                let (x, y) = (f64::from(index % w) + 0.5, f64::from(index / w) + 0.5);
                holes.opacity_at(DVec2::new(x / f64::from(w), 1.0 - y / f64::from(h)))
            };
            Texture { opacity: (0..w * h).map(at).collect(), ..base.clone() }
        }
    };
    texture.mean = mean(&texture.pixels, &texture.opacity);
    let whole =
        texture.opacity.iter().map(|&o| f64::from(o)).sum::<f64>() / texture.opacity.len().max(1) as f64;
    (whole < SOLID).then_some(texture)
}

/// Mean of pixels per band, each by its opacity, where there are any.
fn mean(pixels: &[[f32; 3]], opacity: &[f32]) -> [f64; 3] {
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for (index, pixel) in pixels.iter().enumerate() {
        let weight = opacity.get(index).map_or(1.0, |&o| f64::from(o));
        weights += weight;
        for band in 0..3 {
            sum[band] += weight * f64::from(pixel[band]);
        }
    }
    if weights > 0.0 { sum.map(|sum| sum / weights) } else { [0.0; 3] }
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

/// An image that stands within a model file, as [`linear`] has those in files of their own; `name` is for messages.
pub(super) fn embedded(name: &str, bytes: Vec<u8>, files: Files<'_>) -> Result<Linear, String> {
    let name = PathBuf::from(name);
    match files.apart(move || decode(&name, &bytes)) {
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
            Ok(image) => return Linear::of(&image.to_rgba8()),
            // The image crate's messages may run over several lines.
            Err(error) => {
                failure = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
            }
        }
    }
    Err(failure)
}

impl Linear {
    fn of(image: &image::RgbaImage) -> Result<Self, String> {
        let (width, height) = image.dimensions();
        if width == 0 || height == 0 {
            return Err("it has no pixels".to_owned());
        }
        let mut linear = [0.0_f32; 256];
        for (code, value) in linear.iter_mut().enumerate() {
            *value = srgb_to_linear(code as f64 / 255.0) as f32;
        }
        let colour = |pixel: &image::Rgba<u8>| {
            let [r, g, b, _] = pixel.0;
            [r, g, b].map(|code| linear[usize::from(code)])
        };
        let pixels = image.pixels().map(colour).collect();
        let alphas = || image.pixels().map(|pixel| pixel.0[3]);
        // Some programs write an alpha of zero everywhere and do not mean it.
        let says_something = alphas().any(|alpha| alpha < u8::MAX) && alphas().any(|alpha| alpha > 0);
        let alpha = match says_something {
            true => alphas().map(|alpha| f32::from(alpha) / 255.0).collect(),
            false => Vec::new(),
        };
        Ok(Self { width, height, pixels, alpha })
    }

    /// An image of reflectances, capped at [`MAX_REFLECTANCE`] as those of plain materials are.
    pub(super) fn texture(mut self, map: &Map) -> Texture {
        let [base, gain] = map.range.unwrap_or([0.0, 1.0]);
        for value in self.pixels.iter_mut().flatten() {
            *value = (base + gain * f64::from(*value)).clamp(0.0, MAX_REFLECTANCE) as f32;
        }
        let mean_alpha =
            self.alpha.iter().map(|&a| f64::from(a)).sum::<f64>() / self.alpha.len().max(1) as f64;
        let opacity = if mean_alpha < SOLID { self.alpha } else { Vec::new() };
        Texture {
            mean: mean(&self.pixels, &opacity),
            name: map.image.clone(),
            width: self.width,
            height: self.height,
            clamped: map.clamped,
            pixels: self.pixels,
            opacity,
        }
    }

    /// How opaque each pixel is. Brightness counts by the code as it is written, which is how programs mean it.
    fn opacities(&self, channel: Channel, range: Option<[f64; 2]>) -> Vec<f32> {
        let by_alpha = channel == Channel::Alpha || channel == Channel::Whichever && !self.alpha.is_empty();
        let [base, gain] = range.unwrap_or([0.0, 1.0]);
        let within = |value: f32| (base + gain * f64::from(value)).clamp(0.0, 1.0) as f32;
        match by_alpha {
            true if self.alpha.is_empty() => vec![1.0; self.pixels.len()],
            true => self.alpha.iter().map(|&alpha| within(alpha)).collect(),
            false => {
                let brightness = |p: &[f32; 3]| luminance_weighted(p.map(f64::from));
                self.pixels.iter().map(|p| within(linear_to_srgb(brightness(p)) as f32)).collect()
            }
        }
    }

    /// Whether it says of any pixel that it is not opaque.
    pub(super) fn has_alpha(&self) -> bool {
        !self.alpha.is_empty()
    }

    /// The same with other opacities, 0 to 1, for those that it has.
    pub(super) fn with_opacities(mut self, of: impl Fn(f32) -> f32) -> Self {
        self.alpha.iter_mut().for_each(|alpha| *alpha = of(*alpha));
        self
    }

    /// The same, opaque everywhere.
    pub(super) fn opaque(mut self) -> Self {
        self.alpha = Vec::new();
        self
    }

    pub(super) fn mean(&self) -> [f64; 3] {
        mean(&self.pixels, &[])
    }
}

/// IEC 61966-2-1, the other way.
pub(super) fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// IEC 61966-2-1: linear light of a code from 0 to 1.
pub(super) fn srgb_to_linear(code: f64) -> f64 {
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
