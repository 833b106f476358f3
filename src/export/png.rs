use super::{ExportError, atomic};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use std::io::Write as _;
use std::path::Path;

/// Writes an opaque picture of 8 bits a channel, sRGB encoded, rows from the top.
///
/// `rgba` holds four bytes a pixel; alpha is left out.
///
/// # Errors
/// A count of pixels that does not fit the size, or a refusal of the system.
pub fn write_png(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), ExportError> {
    write(path, &encoded(path, (width, height), rgba, false)?)
}

/// As [`write_png`], with alpha.
///
/// # Errors
/// As there.
pub fn write_png_with_alpha(path: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<(), ExportError> {
    write(path, &encoded(path, (width, height), rgba, true)?)
}

/// The bytes of the file that [`write_png`] would write.
///
/// # Errors
/// A count of pixels that does not fit the size; `name` is for the message.
pub fn png_bytes(name: &Path, width: u32, height: u32, rgba: &[u8]) -> Result<Vec<u8>, ExportError> {
    encoded(name, (width, height), rgba, false)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    atomic::write(path, |file| file.write_all(bytes))
}

fn encoded(
    path: &Path,
    (width, height): (u32, u32),
    rgba: &[u8],
    with_alpha: bool,
) -> Result<Vec<u8>, ExportError> {
    let (pixels, rest) = rgba.as_chunks::<4>();
    if pixels.len() != width as usize * height as usize || pixels.is_empty() || !rest.is_empty() {
        return Err(ExportError::shape(
            path,
            format!("the picture has {} bytes, which are not {width} x {height} pixels", rgba.len()),
        ));
    }
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new(&mut bytes);
    let result = match with_alpha {
        true => encoder.write_image(rgba, width, height, ExtendedColorType::Rgba8),
        false => {
            let rgb: Vec<u8> = pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
            encoder.write_image(&rgb, width, height, ExtendedColorType::Rgb8)
        }
    };
    result.map_err(|error| ExportError::shape(path, error.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let pixels: Vec<[u8; 4]> = (0..6).map(|i| [i, 100 + i, 255 - i, 255]).collect();
        write_png(&path, 3, 2, pixels.as_flattened()).unwrap();
        let back = image::open(&path).unwrap().to_rgba8();
        assert_eq!(back.dimensions(), (3, 2));
        assert_eq!(back.pixels().map(|p| p.0).collect::<Vec<_>>(), pixels);
    }

    #[test]
    fn a_wrong_count_is_an_error_and_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        assert!(write_png(&path, 3, 3, &[0; 24]).is_err());
        assert!(write_png(&path, 0, 0, &[]).is_err());
        assert!(!path.exists());
    }
}
