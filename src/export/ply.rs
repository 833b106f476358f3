use super::{ExportError, atomic};
use std::io::Write as _;
use std::path::Path;

/// A lit mesh: one entry a vertex in the first four.
#[derive(Clone, Copy, Debug)]
pub struct LitMesh<'a> {
    /// Positions, metres.
    pub positions: &'a [[f64; 3]],
    /// Unit normals of the lit side.
    pub normals: &'a [[f32; 3]],
    /// Radiosity, W/m² per band.
    pub radiosity: &'a [[f32; 3]],
    /// Tone-mapped colours, sRGB encoded.
    pub colours: &'a [[u8; 3]],
    /// Vertex indices, counter-clockwise from the lit side.
    pub triangles: &'a [[u32; 3]],
}

/// Positions further out are written as doubles, metres: floats would lose their millimetres.
const MOST_AS_FLOAT: f64 = 8192.0;

/// Writes a binary little-endian PLY file with the vertex properties `x y z nx ny nz radiosity_r
/// radiosity_g radiosity_b red green blue` and the face lists `vertex_indices`. Positions are floats, or
/// doubles where some are kilometres from the origin.
///
/// # Errors
/// Arrays of different lengths, an index past the last vertex, or a refusal of the system.
pub fn write_ply(path: &Path, mesh: &LitMesh<'_>) -> Result<(), ExportError> {
    let count = mesh.positions.len();
    let others = [mesh.normals.len(), mesh.radiosity.len(), mesh.colours.len()];
    if let Some(other) = others.into_iter().find(|&other| other != count) {
        return Err(ExportError::shape(
            path,
            format!("the mesh has {count} positions but {other} of what belongs to them"),
        ));
    }
    if let Some(index) = mesh.triangles.iter().flatten().find(|&&index| index as usize >= count) {
        return Err(ExportError::shape(path, format!("a triangle names vertex {index} of {count}")));
    }
    atomic::write(path, |file| {
        write!(
            file,
            "ply\nformat binary_little_endian 1.0\ncomment Lumenwalk: metres, radiosity in W/m2\n\
             element vertex {count}\n"
        )?;
        let is_far = mesh.positions.as_flattened().iter().any(|x| x.abs() > MOST_AS_FLOAT);
        for name in ["x", "y", "z"] {
            writeln!(file, "property {} {name}", if is_far { "double" } else { "float" })?;
        }
        for name in ["nx", "ny", "nz", "radiosity_r", "radiosity_g", "radiosity_b"] {
            writeln!(file, "property float {name}")?;
        }
        for name in ["red", "green", "blue"] {
            writeln!(file, "property uchar {name}")?;
        }
        let faces = mesh.triangles.len();
        write!(file, "element face {faces}\nproperty list uchar int vertex_indices\nend_header\n")?;
        for vertex in 0..count {
            for value in mesh.positions[vertex] {
                match is_far {
                    true => file.write_all(&value.to_le_bytes())?,
                    false => file.write_all(&(value as f32).to_le_bytes())?,
                }
            }
            for value in [mesh.normals[vertex], mesh.radiosity[vertex]].as_flattened() {
                file.write_all(&value.to_le_bytes())?;
            }
            file.write_all(&mesh.colours[vertex])?;
        }
        for triangle in mesh.triangles {
            file.write_all(&[3])?;
            for index in triangle {
                file.write_all(&index.to_le_bytes())?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];

    fn mesh(triangles: &[[u32; 3]]) -> LitMesh<'_> {
        LitMesh {
            positions: &POSITIONS,
            normals: &[[0.0, 0.0, 1.0]; 4],
            radiosity: &[[2.0, 3.0, 4.0]; 4],
            colours: &[[10, 20, 30]; 4],
            triangles,
        }
    }

    #[test]
    fn the_body_holds_what_the_header_announces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        write_ply(&path, &mesh(&[[0, 1, 2], [0, 2, 3]])).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..start]).unwrap();
        let floats = header.lines().filter(|l| l.starts_with("property float")).count();
        let colours = header.lines().filter(|l| l.starts_with("property uchar")).count();
        assert!(header.contains("element vertex 4\n") && header.contains("element face 2\n"));
        let vertex = 4 * floats + colours;
        assert_eq!(bytes.len() - start, 4 * vertex + 2 * (1 + 3 * 4));
        let last = &bytes[start + 3 * vertex..][..vertex];
        assert_eq!(last[8..12], 0.5_f32.to_le_bytes());
        assert_eq!(last[vertex - 3..], [10, 20, 30]);
        assert_eq!(bytes[bytes.len() - 4..], 3_u32.to_le_bytes());
    }

    #[test]
    fn survey_coordinates_keep_their_millimetres() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("far.ply");
        let positions = POSITIONS.map(|[x, y, z]| [x + 512_345.678, y, z + 5_401_234.567]);
        write_ply(&path, &LitMesh { positions: &positions, ..mesh(&[[0, 1, 2]]) }).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let end = b"end_header\n";
        let start = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..start]).unwrap();
        assert!(header.contains("property double x\n") && header.contains("property float nx\n"));
        assert_eq!(bytes[start..start + 8], 512_345.678_f64.to_le_bytes());
        assert_eq!(bytes.len() - start, 4 * (3 * 8 + 6 * 4 + 3) + 13);
    }

    #[test]
    fn wrong_indices_and_lengths_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        assert!(write_ply(&path, &mesh(&[[0, 1, 4]])).unwrap_err().to_string().contains("vertex 4 of 4"));
        assert!(write_ply(&path, &LitMesh { normals: &[], ..mesh(&[]) }).is_err());
        assert!(!path.exists());
    }
}
