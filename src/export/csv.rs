use super::{ExportError, atomic};
use glam::DVec3;
use std::borrow::Cow;
use std::fmt::{Display, LowerExp};
use std::io::Write as _;
use std::path::Path;

/// One patch as the table shows it.
#[derive(Clone, Copy, Debug)]
pub struct PatchRow<'a> {
    /// Index of the patch.
    pub id: usize,
    /// Name of the object that it belongs to.
    pub surface: &'a str,
    /// Name of its material.
    pub material: &'a str,
    /// Centroid, in the unit of the scene's file, so that it can serve as a point to gather at.
    pub centre: DVec3,
    /// Unit normal of its side.
    pub normal: DVec3,
    /// Area, m².
    pub area: f64,
    /// B, W/m² per band.
    pub radiosity: [f32; 3],
    /// E, W/m² per band.
    pub exitance: [f32; 3],
    /// H, W/m² per band.
    pub irradiance: [f32; 3],
    /// rho per band.
    pub reflectance: [f32; 3],
}

/// After `centre_x_mm` and the like.
const HEADER: &str = "normal_x,normal_y,normal_z,area_m2,\
    radiosity_r,radiosity_g,radiosity_b,exitance_r,exitance_g,exitance_b,\
    irradiance_r,irradiance_g,irradiance_b,reflectance_r,reflectance_g,reflectance_b";

/// Writes one line a patch under a header line, names quoted where they need it (RFC 4180). `unit` is the
/// symbol of that of the centres, told in the names of their columns; radiometric columns are in W/m².
///
/// # Errors
/// A refusal of the system.
pub fn write_patch_table<'a>(
    path: &Path,
    unit: &str,
    rows: impl IntoIterator<Item = PatchRow<'a>>,
) -> Result<(), ExportError> {
    atomic::write(path, |file| {
        write!(file, "id,surface,material,")?;
        for axis in ["x", "y", "z"] {
            write!(file, "centre_{axis}_{unit},")?;
        }
        writeln!(file, "{HEADER}")?;
        for row in rows {
            write!(file, "{},{},{}", row.id, quoted(row.surface), quoted(row.material))?;
            let lengths = [row.centre, row.normal].into_iter().flat_map(|v| v.to_array());
            for value in lengths.chain([row.area]) {
                write!(file, ",{}", number(value))?;
            }
            for band in [row.radiosity, row.exitance, row.irradiance, row.reflectance].into_iter().flatten() {
                write!(file, ",{}", number(band))?;
            }
            writeln!(file)?;
        }
        Ok(())
    })
}

/// A field as RFC 4180 wants it: quoted where it holds a comma, a quote or a line break.
pub(super) fn quoted(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r']) || text.trim() != text {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// The shortest text that reads back as the same number.
pub(super) fn number<T: Copy + Display + LowerExp + Into<f64>>(value: T) -> String {
    let size = value.into().abs();
    if size == 0.0 {
        "0".into()
    } else if (1e-4..1e9).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(surface: &'static str) -> PatchRow<'static> {
        PatchRow {
            id: 7,
            surface,
            material: "red",
            centre: DVec3::new(0.1, -2.0, 1e-7),
            normal: DVec3::NEG_Y,
            area: 0.0625,
            radiosity: [1.0, 0.1, 0.0],
            exitance: [0.0; 3],
            irradiance: [2.0, 3.0, 4.5e12],
            reflectance: [0.5, 0.25, 0.125],
        }
    }

    #[test]
    fn one_line_a_patch_with_as_many_fields_as_the_header() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("patches.csv");
        write_patch_table(&path, "mm", [row("wall")]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "7,wall,red,0.1,-2,1e-7,0,-1,0,0.0625,1,0.1,0,0,0,0,2,3,4.5e12,0.5,0.25,0.125");
        assert!(lines[0].contains(",centre_x_mm,centre_y_mm,centre_z_mm,normal_x,"), "{}", lines[0]);
        assert_eq!(lines[0].split(',').count(), lines[1].split(',').count());
        assert_eq!(lines.len(), 2);
    }

    #[test]
    fn names_with_commas_and_quotes_are_quoted() {
        assert_eq!(quoted("plain name"), "plain name");
        assert_eq!(quoted("desk, left"), "\"desk, left\"");
        assert_eq!(quoted("17\" screen"), "\"17\"\" screen\"");
        assert_eq!(quoted("two\nlines"), "\"two\nlines\"");
    }

    #[test]
    fn numbers_read_back_exactly() {
        for value in [1.0 / 3.0, 1e-300, -2.5e-5, 6.02e23, f64::MIN_POSITIVE, -0.0] {
            assert_eq!(number(value).parse::<f64>().unwrap(), value);
        }
        for value in [0.1_f32, 16_777_217.0, 1e-38] {
            assert_eq!(number(value).parse::<f32>().unwrap(), value);
        }
    }
}
