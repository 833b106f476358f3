//! A picture of the sky as a file.

use super::failure::Failure;
use crate::daylight::{Daylight, LUMINOUS_EFFICACY, Projection};
use crate::display::{Exposure, ToneMap, meter, srgb_encode};
use crate::export::{StillLayers, write_exr, write_png};
use crate::outputs::StillKind;
use std::f32::consts::PI;
use std::path::Path;

/// Directions across and down with which a picture is metered.
const METER_GRID: u32 = 96;

/// Writes the sky with its sun, in white light: exposed for the sky and tone-mapped, or as radiance.
///
/// # Errors
/// A refusal of the system to write.
pub(super) fn write(
    path: &Path,
    kind: StillKind,
    daylight: &Daylight,
    projection: Projection,
    size: [u32; 2],
) -> Result<(), Failure> {
    let white = |luminance: f32| [luminance / LUMINOUS_EFFICACY as f32; 3];
    let radiance: Vec<[f32; 3]> = daylight.picture(projection, size).into_iter().map(white).collect();
    let [width, height] = size;
    match kind {
        StillKind::Png => {
            write_png(path, width, height, &tone_mapped(&radiance, metered(daylight, projection)))?
        }
        StillKind::Exr => {
            // There is no surface anywhere.
            let nothing = vec![[0.0; 3]; radiance.len()];
            let still = StillLayers {
                width,
                height,
                radiance: &radiance,
                irradiance: &nothing,
                patch: &vec![u32::MAX; radiance.len()],
                normal: &nothing,
                depth: &vec![0.0; radiance.len()],
            };
            write_exr(path, &still)?;
        }
    }
    Ok(())
}

/// The exposure that suits sky and ground; the sun's disc may dazzle.
fn metered(daylight: &Daylight, projection: Projection) -> Exposure {
    let grid = [METER_GRID; 2];
    let places = (0..METER_GRID * METER_GRID).map(|cell| (cell % METER_GRID, cell / METER_GRID));
    let seen = places.filter_map(|(x, y)| {
        let e = projection.direction(f64::from(x) + 0.5, f64::from(y) + 0.5, grid)?;
        Some((daylight.luminance(e), 1.0))
    });
    meter(seen).unwrap_or_default()
}

fn tone_mapped(radiance: &[[f32; 3]], exposure: Exposure) -> Vec<u8> {
    // Pi, since exposures are for radiosities.
    let factor = exposure.factor() * PI;
    let code = |linear: f32| (255.0 * srgb_encode(linear)).round() as u8;
    radiance
        .iter()
        .flat_map(|rgb| {
            let [r, g, b] = ToneMap::default().apply(rgb.map(|value| value * factor)).map(code);
            [r, g, b, 255]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::daylight::{CieType, Pattern, SunPosition};

    #[test]
    fn both_kinds_of_file_are_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let sun = SunPosition::new(30.0, 90.0).expect("a sun");
        let daylight = Daylight::new(Pattern::Cie(CieType::CLEAR), sun, 1e4, 8e4, 0.2).expect("a sky");
        let path = folder.path().join("sky.png");
        write(&path, StillKind::Png, &daylight, Projection::Fisheye, [64, 48]).expect("a picture");
        let picture = image::open(&path).expect("a picture").to_rgb8();
        assert_eq!(picture.dimensions(), (64, 48));
        let value = |x, y| picture.get_pixel(x, y).0[0];
        assert_eq!((value(0, 0), value(63, 47)), (0, 0), "outside the disc");
        // 30 degrees is two thirds of the way to the rim, in the east.
        assert!(value(48, 24) > 240 && value(48, 24) > value(16, 24) && value(16, 24) > 30);
        let path = folder.path().join("sky.exr");
        write(&path, StillKind::Exr, &daylight, Projection::LatitudeLongitude, [64, 32]).expect("a picture");
        assert!(std::fs::metadata(&path).expect("a file").len() > 1000);
        let night = Daylight::new(Pattern::Dark, sun, 0.0, 0.0, 0.2).expect("a sky");
        let path = folder.path().join("night.png");
        write(&path, StillKind::Png, &night, Projection::Fisheye, [8, 8]).expect("a picture");
        assert!(image::open(&path).expect("a picture").to_rgb8().iter().all(|&byte| byte == 0));
    }
}
