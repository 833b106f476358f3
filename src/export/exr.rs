use super::{ExportError, atomic};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder, SmallVec,
    WritableImage as _,
};
use std::io::{self, Cursor, Write as _};
use std::path::Path;

/// The layers of a still picture, rows from the top, `width * height` values each.
#[derive(Clone, Copy, Debug)]
pub struct StillLayers<'a> {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Linear R, G, B, W/(m² sr): the picture itself, a sky where no surface is seen included.
    pub radiance: &'a [[f32; 3]],
    /// Irradiance of the surface seen, W/m² per band; zero where nothing is seen.
    pub irradiance: &'a [[f32; 3]],
    /// Patch seen; `u32::MAX` where none is.
    pub patch: &'a [u32],
    /// Unit normal towards the eye; zero where nothing is seen.
    pub normal: &'a [[f32; 3]],
    /// Distance from the eye, metres; zero where nothing is seen.
    pub depth: &'a [f32],
}

/// Writes an OpenEXR picture: radiance as `R G B`, the others as `irradiance.R/G/B`, `patch.id`
/// (unsigned), `normal.X/Y/Z` and `Z`, in one part, so that plain viewers show the radiance.
///
/// # Errors
/// Layers that do not fit the size, or a refusal of the system.
pub fn write_exr(path: &Path, still: &StillLayers<'_>) -> Result<(), ExportError> {
    let pixels = still.width as usize * still.height as usize;
    let layers = [
        ("radiance", still.radiance.len()),
        ("irradiance", still.irradiance.len()),
        ("patch", still.patch.len()),
        ("normal", still.normal.len()),
        ("depth", still.depth.len()),
    ];
    if let Some((name, count)) = layers.into_iter().find(|&(_, count)| count != pixels || count == 0) {
        let size = format!("{} x {}", still.width, still.height);
        return Err(ExportError::shape(path, format!("its layer {name} has {count} pixels and not {size}")));
    }
    let mut channels = SmallVec::new();
    let mut triple = |names: [&str; 3], values: &[[f32; 3]]| {
        for (axis, name) in names.into_iter().enumerate() {
            let samples = values.iter().map(|v| v[axis]).collect();
            channels.push(AnyChannel::new(name, FlatSamples::F32(samples)));
        }
    };
    triple(["R", "G", "B"], still.radiance);
    triple(["irradiance.R", "irradiance.G", "irradiance.B"], still.irradiance);
    triple(["normal.X", "normal.Y", "normal.Z"], still.normal);
    channels.push(AnyChannel::new("patch.id", FlatSamples::U32(still.patch.to_vec())));
    channels.push(AnyChannel::new("Z", FlatSamples::F32(still.depth.to_vec())));
    let image = Image::from_layer(Layer::new(
        (still.width as usize, still.height as usize),
        LayerAttributes { software_name: Some("Lumenwalk".into()), ..LayerAttributes::default() },
        // Lines in their order and not in that in which threads are done: the same bytes every time.
        Encoding { line_order: LineOrder::Increasing, ..Encoding::SMALL_FAST_LOSSLESS },
        AnyChannels::sort(channels),
    ));
    // The encoder seeks, which a pipe cannot; so it writes to memory.
    let mut bytes = Cursor::new(Vec::new());
    let encoded = image.write().to_buffered(&mut bytes);
    atomic::write(path, |file| {
        encoded.map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            other => io::Error::other(other.to_string()),
        })?;
        file.write_all(bytes.get_ref())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::read_first_flat_layer_from_file;

    #[test]
    fn every_layer_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let radiance: Vec<[f32; 3]> = (0..6).map(|i| [i as f32, 0.5 + i as f32, 1e3 * i as f32]).collect();
        let irradiance: Vec<[f32; 3]> = radiance.iter().map(|r| r.map(|v| v * 3.0)).collect();
        let normal = [[0.0, 0.6, -0.8]; 6];
        let patch = [0, 1, 2, 70_000_000, u32::MAX, 5];
        let depth = [0.0, 1.0, 2.0, 3.5, 4.0, 5.0];
        let still = StillLayers {
            width: 3,
            height: 2,
            radiance: &radiance,
            irradiance: &irradiance,
            patch: &patch,
            normal: &normal,
            depth: &depth,
        };
        write_exr(&path, &still).unwrap();
        let image = read_first_flat_layer_from_file(&path).unwrap();
        let layer = &image.layer_data;
        assert_eq!((layer.size.0, layer.size.1), (3, 2));
        let channel = |name: &str| {
            let found = layer.channel_data.list.iter().find(|c| c.name.eq(name));
            &found.unwrap_or_else(|| panic!("no channel {name}")).sample_data
        };
        let floats = |name: &str| match channel(name) {
            FlatSamples::F32(values) => values.clone(),
            other => panic!("{name}: {other:?}"),
        };
        for (axis, band) in ["R", "G", "B"].into_iter().enumerate() {
            assert_eq!(floats(band), radiance.iter().map(|v| v[axis]).collect::<Vec<_>>());
            let expected: Vec<f32> = irradiance.iter().map(|v| v[axis]).collect();
            assert_eq!(floats(&format!("irradiance.{band}")), expected);
        }
        assert_eq!(floats("normal.Z"), [-0.8; 6]);
        assert_eq!(floats("Z"), depth);
        assert_eq!(*channel("patch.id"), FlatSamples::U32(patch.to_vec()));
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (width, height) = (320, 400);
        let count = (width * height) as usize;
        let rgb: Vec<[f32; 3]> = (0..count).map(|i| [(i as f32 * 0.37).sin(), 1.0, i as f32]).collect();
        let patch: Vec<u32> = (0..count as u32).collect();
        let depth = vec![1.0; count];
        let still = StillLayers {
            width,
            height,
            radiance: &rgb,
            irradiance: &rgb,
            patch: &patch,
            normal: &rgb,
            depth: &depth,
        };
        let mut written = (0..12).map(|_| {
            write_exr(&path, &still).unwrap();
            std::fs::read(&path).unwrap()
        });
        let first = written.next().unwrap();
        assert!(written.all(|bytes| bytes == first));
    }

    #[test]
    fn a_missing_layer_is_an_error_and_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let rgb = [[1.0; 3]; 2];
        let still = StillLayers {
            width: 2,
            height: 1,
            radiance: &rgb,
            irradiance: &rgb,
            patch: &[0, 1],
            normal: &rgb,
            depth: &[1.0],
        };
        let error = write_exr(&path, &still).unwrap_err().to_string();
        assert!(error.contains("depth has 1 pixels"), "{error}");
        assert!(!path.exists());
    }
}
