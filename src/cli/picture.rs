use super::failure::Failure;
use super::progress::ProgressLine;
use crate::display::{DisplayMesh, Exposure, Shading, ToneMap, luminance, meter, srgb_encode};
use crate::export::{ExportError, LitMesh, StillLayers, write_exr, write_ply, write_png};
use crate::render::{Camera, Picker, StillInput, StillOptions, render_still};
use crate::scene::View;
use crate::session::Solved;
use crate::solver::PatchLight;
use glam::DVec2;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Pixels across and down where nothing else is asked for.
pub(super) const DEFAULT_SIZE: [u32; 2] = [1280, 800];

/// Rays across and down with which a view is metered.
const METER_GRID: [u32; 2] = [96, 60];

/// What a picture file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PictureKind {
    /// Exposed, tone-mapped, 8 bits.
    Png,
    /// Radiance and further layers.
    Exr,
}

impl PictureKind {
    /// By the extension of the file.
    ///
    /// # Errors
    /// Any other than `.png` and `.exr`.
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        match extension.to_str() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Failure::input(format!(
                "{}: a picture is written as .png or .exr, by the end of its name",
                path.display()
            ))),
        }
    }
}

/// A solution made ready to be looked at.
struct Shown<'a> {
    solved: &'a Solved,
    mesh: DisplayMesh,
    radiosity: &'a [[f32; 3]],
    irradiance: &'a [[f32; 3]],
}

impl<'a> Shown<'a> {
    fn new(solved: &'a Solved, light: &'a PatchLight) -> Self {
        let smooth = solved.plan.is_on(crate::effects::Effect::SmoothSurfaces);
        let mesh = DisplayMesh::build(&solved.mesh, &solved.scene, smooth);
        Self { solved, mesh, radiosity: &light.radiosity, irradiance: &light.irradiance }
    }

    /// Exposure for these patches, each with the weight that it has in the picture. Lamps are left
    /// out unless nothing else is lit.
    fn exposure(&self, weighted: &[(usize, f64)]) -> Exposure {
        let sample = |&(patch, weight): &(usize, f64)| {
            (self.radiosity.get(patch).map_or(0.0, |&b| luminance(b)), weight)
        };
        let shines = |patch: usize| self.solved.mesh.patches[patch].luminaire.is_some();
        meter(weighted.iter().filter(|(patch, _)| !shines(*patch)).map(sample))
            .or_else(|| meter(weighted.iter().map(sample)))
            .unwrap_or_default()
    }
}

/// Renders the view and writes it.
///
/// # Errors
/// A refusal of the system to write.
pub(super) fn write(
    path: &Path,
    kind: PictureKind,
    solved: &Solved,
    light: &PatchLight,
    view: &View,
    size: [u32; 2],
) -> Result<(), Failure> {
    let shown = Shown::new(solved, light);
    let camera = Camera::from_view(view, solved.scene.up.vector());
    let picker = Picker::new(&solved.mesh);
    let mut seen = vec![0_u32; solved.mesh.patches.len()];
    for (x, y) in (0..METER_GRID[1]).flat_map(|y| (0..METER_GRID[0]).map(move |x| (x, y))) {
        let pixel =
            DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / DVec2::from(METER_GRID.map(f64::from));
        let ray = camera.ray(pixel * DVec2::from(size.map(f64::from)), size);
        if let Some(patch) = picker.pick(&ray).and_then(|pick| pick.patch) {
            seen[patch as usize] += 1;
        }
    }
    let weighted: Vec<(usize, f64)> =
        seen.into_iter().enumerate().filter(|s| s.1 > 0).map(|(p, n)| (p, f64::from(n))).collect();
    let input = StillInput {
        mesh: &shown.mesh,
        picker: &picker,
        textures: &solved.scene.textures,
        corner_radiosity: &shown.mesh.corner_radiosity(shown.radiosity, shown.irradiance, Shading::Gouraud),
        corner_irradiance: &shown.mesh.corner_values(shown.irradiance, Shading::Gouraud),
    };
    let options = StillOptions::new(size, shown.exposure(&weighted), ToneMap::default());
    let line = Mutex::new(ProgressLine::new());
    let still = render_still(&input, &camera, &options, &|share| {
        line.lock().unwrap_or_else(PoisonError::into_inner).picture(f64::from(share));
        true
    });
    drop(line);
    let still = still.ok_or_else(|| Failure::work(anyhow::anyhow!("the picture was given up")))?;
    match kind {
        PictureKind::Png => write_png(path, still.width, still.height, &still.to_rgba8())?,
        PictureKind::Exr => write_exr(
            path,
            &StillLayers {
                width: still.width,
                height: still.height,
                radiance: &still.radiance,
                irradiance: &still.irradiance,
                patch: &still.patch_id,
                normal: &still.normal,
                depth: &still.depth,
            },
        )?,
    }
    Ok(())
}

/// Writes the lit sides with vertex radiosity, exposed for the scene as a whole.
///
/// # Errors
/// A refusal of the system to write.
pub(super) fn write_mesh(path: &Path, solved: &Solved, light: &PatchLight) -> Result<(), ExportError> {
    let shown = Shown::new(solved, light);
    let areas: Vec<(usize, f64)> = solved.mesh.patches.iter().map(|patch| patch.area).enumerate().collect();
    let factor = shown.exposure(&areas).factor();
    let radiosity = shown.mesh.corner_values(shown.radiosity, Shading::Gouraud);
    let colour = |b: &[f32; 3]| {
        let mapped = ToneMap::default().apply(b.map(|value| value * factor));
        mapped.map(|value| (srgb_encode(value) * 255.0).round() as u8)
    };
    let lit = &shown.mesh.corners[..shown.mesh.lit_corners];
    let origin = shown.mesh.origin;
    let triangles: Vec<[u32; 3]> = shown
        .mesh
        .batches
        .iter()
        .flat_map(|batch| &shown.mesh.indices[batch.indices.start as usize..batch.indices.end as usize])
        .copied()
        .collect::<Vec<_>>()
        .as_chunks::<3>()
        .0
        .to_vec();
    write_ply(
        path,
        &LitMesh {
            positions: &lit
                .iter()
                .map(|c| (c.position.as_dvec3() + origin).as_vec3().to_array())
                .collect::<Vec<_>>(),
            normals: &lit.iter().map(|c| c.normal.to_array()).collect::<Vec<_>>(),
            radiosity: &radiosity,
            colours: &radiosity.iter().map(colour).collect::<Vec<_>>(),
            triangles: &triangles,
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_the_name_decides() {
        assert_eq!(PictureKind::of(Path::new("a/b.PNG")).unwrap(), PictureKind::Png);
        assert_eq!(PictureKind::of(Path::new("a.b.exr")).unwrap(), PictureKind::Exr);
        for other in ["a.jpg", "png", ".png", "a.png.txt"] {
            assert!(PictureKind::of(Path::new(other)).is_err(), "{other}");
        }
    }
}
