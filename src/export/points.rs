use super::csv::{number, quoted};
use super::{ExportError, atomic};
use glam::DVec3;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Watts to lux, W/m² per band in.
type Lux = fn([f64; 3]) -> f64;

/// A point on a surface to gather irradiance at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// As the file gives it, in the unit of the scene's file.
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

/// Why a file of points cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PointsError {
    /// The file cannot be read.
    #[error("cannot read the points in {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line that is no point.
    #[error("{name}:{line}: {what}; a line must hold x,y,z,nx,ny,nz")]
    Line {
        /// Name of the file.
        name: String,
        /// Counted from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// No point at all.
    #[error("{name} holds no points; each of its lines must hold x,y,z,nx,ny,nz")]
    Empty {
        /// Name of the file.
        name: String,
    },
}

/// Reads a file of points: see [`parse_points`].
///
/// # Errors
/// A file that cannot be read, or as [`parse_points`].
pub fn read_points(path: &Path) -> Result<Vec<SurfacePoint>, PointsError> {
    let bytes = std::fs::read(path).map_err(|source| PointsError::Read { path: path.to_owned(), source })?;
    parse_points(&path.display().to_string(), &String::from_utf8_lossy(&bytes))
}

/// Reads lines `x,y,z,nx,ny,nz`. Blank lines and lines that begin with `#` are skipped; the first
/// other line may be a header. Normals are brought to unit length.
///
/// # Errors
/// The first line without six finite numbers or with a normal of zero length; a text without points.
pub fn parse_points(name: &str, text: &str) -> Result<Vec<SurfacePoint>, PointsError> {
    let mut points = Vec::new();
    let mut header_may_come = true;
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if std::mem::take(&mut header_may_come) && is_header(line) {
            continue;
        }
        let point = parse_point(line).map_err(|what| PointsError::Line {
            name: name.to_owned(),
            line: index + 1,
            what,
        })?;
        points.push(point);
    }
    if points.is_empty() { Err(PointsError::Empty { name: name.to_owned() }) } else { Ok(points) }
}

/// A line of names: no field of it is a number.
fn is_header(line: &str) -> bool {
    line.split(',').all(|field| field.trim().parse::<f64>().is_err())
}

fn parse_point(line: &str) -> Result<SurfacePoint, String> {
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    if fields.len() != 6 {
        return Err(format!("{} fields were found where six are needed", fields.len()));
    }
    let mut values = [0.0; 6];
    for (value, field) in values.iter_mut().zip(&fields) {
        *value = field
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| format!("{field:?} is not a finite number"))?;
    }
    let [x, y, z, nx, ny, nz] = values;
    let normal = DVec3::new(nx, ny, nz);
    // Scaled first, so that no length overflows or vanishes.
    let normal = (normal / normal.abs().max_element())
        .try_normalize()
        .ok_or_else(|| "the normal has no length".to_owned())?;
    Ok(SurfacePoint { position: DVec3::new(x, y, z), normal })
}

/// Irradiance at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointResult {
    /// W/m² per band.
    pub irradiance: [f64; 3],
    /// Estimated error of its illuminance, lx: the truth lies within this in nine of ten cases.
    pub lux_error: f64,
    /// Its daylight factor and the estimated error of that, per cent; `None` where there is no sky.
    pub daylight_factor: Option<[f64; 2]>,
}

/// Writes `x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b,lux,lux_error`, one line per point, with
/// irradiance in W/m² per band and `lux` of it; `daylight_factor,daylight_factor_error`, in per cent, follow where
/// they are known of all points. With `groups`, the names of these come first, as `room`.
///
/// # Errors
/// Counts that differ, or a refusal of the system.
pub fn write_irradiance(
    path: &Path,
    groups: Option<&[&str]>,
    points: &[SurfacePoint],
    results: &[PointResult],
    lux: Lux,
) -> Result<(), ExportError> {
    let counts = [points.len(), groups.map_or(points.len(), <[&str]>::len)];
    if counts.iter().any(|&count| count != results.len()) {
        return Err(ExportError::shape(
            path,
            format!("there are {} points and {} results", counts[0], results.len()),
        ));
    }
    let has_factors = results.iter().all(|result| result.daylight_factor.is_some());
    atomic::write(path, |file| {
        write!(file, "{}", if groups.is_some() { "room," } else { "" })?;
        write!(file, "x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b,lux,lux_error")?;
        writeln!(file, "{}", if has_factors { ",daylight_factor,daylight_factor_error" } else { "" })?;
        for (index, (point, result)) in points.iter().zip(results).enumerate() {
            if let Some(groups) = groups {
                write!(file, "{},", quoted(groups[index]))?;
            }
            let place = [point.position, point.normal].into_iter().flat_map(|v| v.to_array());
            let told = [lux(result.irradiance), result.lux_error];
            let factors = result.daylight_factor.filter(|_| has_factors).into_iter().flatten();
            let values = place.chain(result.irradiance).chain(told).chain(factors);
            writeln!(file, "{}", values.map(number).collect::<Vec<String>>().join(","))?;
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_comments_and_blank_lines_are_skipped() {
        let text =
            "\u{feff}# probe\r\n\r\n x, y, z, nx, ny, nz \r\n1, 2 ,3,0,0,5\r\n#end\r\n-1e-3,0,0,0,-2,0";
        let points = parse_points("p.csv", text).unwrap();
        assert_eq!(
            points,
            [
                SurfacePoint { position: DVec3::new(1.0, 2.0, 3.0), normal: DVec3::Z },
                SurfacePoint { position: DVec3::new(-0.001, 0.0, 0.0), normal: DVec3::NEG_Y },
            ]
        );
    }

    #[test]
    fn bad_lines_are_named_with_their_number() {
        let complaint = |text: &str| parse_points("p.csv", text).unwrap_err().to_string();
        assert!(complaint("0,0,0,0,0,1\n0,0,0,0,1").starts_with("p.csv:2: 5 fields"));
        assert!(complaint("x,y,z,nx,ny,nz\n1,2,3,0,0,up").contains("p.csv:2: \"up\""));
        assert!(complaint("1,2,3,0,0,oops").contains("p.csv:1: \"oops\""));
        assert!(complaint("1,2,NaN,0,0,1").contains("not a finite number"));
        assert!(complaint("1,2,inf,0,0,1").contains("not a finite number"));
        assert!(complaint("1,2,3,0,0,0").contains("normal has no length"));
        assert!(complaint("x,y,z\nx,y,z").starts_with("p.csv:2:"), "one header, not two");
        assert!(complaint("# nothing\n").contains("holds no points"));
    }

    #[test]
    fn normals_of_any_size_come_to_unit_length() {
        for text in ["0,0,0,3e200,4e200,0", "0,0,0,3e-200,4e-200,0"] {
            let normal = parse_points("p.csv", text).unwrap()[0].normal;
            assert!((normal - DVec3::new(0.6, 0.8, 0.0)).length() < 1e-15);
        }
    }

    #[test]
    fn results_stand_beside_their_points() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("irradiance.csv");
        let points = parse_points("p.csv", "1,2,3,0,0,2").unwrap();
        let result = PointResult { irradiance: [1.0, 2.0, 4.0], lux_error: 0.25, daylight_factor: None };
        let write = |groups: Option<&[&str]>, result| {
            write_irradiance(&path, groups, &points, &[result], |h| h.iter().sum()).unwrap();
            std::fs::read_to_string(&path).unwrap()
        };
        let header = "x,y,z,nx,ny,nz,irradiance_r,irradiance_g,irradiance_b,lux,lux_error";
        assert_eq!(write(None, result), format!("{header}\n1,2,3,0,0,1,1,2,4,7,0.25\n"));
        let daylit = PointResult { daylight_factor: Some([2.5, 0.125]), ..result };
        assert_eq!(
            write(Some(&["Room, left"]), daylit),
            format!(
                "room,{header},daylight_factor,daylight_factor_error\n\"Room, left\",1,2,3,0,0,1,1,2,4,7,0.25,2.5,0.125\n"
            )
        );
        assert!(write_irradiance(&path, None, &points, &[], |_| 0.0).is_err());
        assert!(write_irradiance(&path, Some(&[]), &points, &[result], |_| 0.0).is_err());
    }
}
