use super::failure::Failure;
use super::progress::ProgressLine;
use crate::display::{
    DisplayMesh, Exposure, Shading, SkyView, ToneMap, even_light, luminance, meter, openness, white_balance,
};
use crate::effects::Effect;
use crate::export::{ExportError, png_bytes};
use crate::navigation::Camera;
use crate::outputs::{StillKind, StillLight, save_lit_mesh, save_still};
use crate::render::{Picker, Still, StillOptions, render_still};
use crate::scene::{Lighting, View};
use crate::solve::Solution;
use crate::solver::PatchLight;
use glam::DVec2;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Pixels across and down where nothing else is asked for.
pub(super) const DEFAULT_SIZE: [u32; 2] = [1280, 800];

/// Rays across and down with which a view is metered.
const METER_GRID: [u32; 2] = [96, 60];

/// What a picture file of this name holds.
///
/// # Errors
/// Any other extension than `.png` and `.exr`.
pub(super) fn kind_of(path: &Path) -> Result<StillKind, Failure> {
    StillKind::of(path).ok_or_else(|| {
        Failure::input(format!(
            "{}: a picture is written as .png or .exr, by the end of its name",
            path.display()
        ))
    })
}

/// A solution made ready to have its picture taken.
pub(super) struct Studio<'a> {
    solved: &'a Solution,
    /// What was solved.
    light: &'a PatchLight,
    /// What a scene without lamps is shown in instead.
    even: Option<PatchLight>,
    mesh: DisplayMesh,
    picker: Picker,
    corners: StillLight,
    gains: [f32; 3],
    sky: Option<SkyView<'a>>,
}

/// The scene in plain even light.
fn even(solved: &Solution) -> PatchLight {
    let open = openness(&solved.mesh, &|| false);
    let irradiance = even_light(&solved.mesh, solved.scene.up, open.as_deref());
    PatchLight::reflected(irradiance, &solved.reflectance)
}

impl<'a> Studio<'a> {
    pub(super) fn new(solved: &'a Solution, lighting: &Lighting, light: &'a PatchLight) -> Self {
        let smooth = solved.plan.is_on(Effect::SmoothSurfaces);
        let elements = solved.element_light.as_ref().map(|light| &light.elements);
        let mesh = DisplayMesh::build_on(&solved.mesh, &solved.scene, smooth, elements);
        let even = solved.scene.luminaires.is_empty().then(|| even(solved));
        Self {
            corners: StillLight::new(&mesh, even.as_ref().unwrap_or(light), Shading::Gouraud),
            gains: white_balance(&solved.scene, &[lighting]),
            sky: SkyView::of(&solved.scene, lighting),
            picker: Picker::new(&solved.mesh),
            solved,
            light,
            even,
            mesh,
        }
    }

    /// Exposure for these patches, each with the weight that it has in the picture. Lamps are left
    /// out unless nothing else is lit; `None` where nothing is.
    fn exposure(&self, weighted: &[(usize, f64)]) -> Option<Exposure> {
        let light = self.even.as_ref().unwrap_or(self.light);
        let sample = |&(patch, weight): &(usize, f64)| {
            (light.radiosity.get(patch).map_or(0.0, |&b| luminance(b)), weight)
        };
        let shines = |patch: usize| self.solved.mesh.patches[patch].luminaire.is_some();
        meter(weighted.iter().filter(|(patch, _)| !shines(*patch)).map(sample))
            .or_else(|| meter(weighted.iter().map(sample)))
    }

    /// The exposure that suits a view; `None` where it shows nothing lit.
    pub(super) fn metered(&self, camera: &Camera, size: [u32; 2]) -> Option<Exposure> {
        let mut seen = vec![0_u32; self.solved.mesh.patches.len()];
        for (x, y) in (0..METER_GRID[1]).flat_map(|y| (0..METER_GRID[0]).map(move |x| (x, y))) {
            let pixel =
                DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / DVec2::from(METER_GRID.map(f64::from));
            let ray = camera.ray(pixel * DVec2::from(size.map(f64::from)), size);
            if let Some(patch) = self.picker.pick(&ray).and_then(|pick| pick.patch) {
                seen[patch as usize] += 1;
            }
        }
        let weighted: Vec<(usize, f64)> =
            seen.into_iter().enumerate().filter(|s| s.1 > 0).map(|(p, n)| (p, f64::from(n))).collect();
        self.exposure(&weighted)
    }

    /// Takes a still; `progress` is told the share done, 0 to 1.
    ///
    /// # Errors
    /// None in practice: nothing gives a still up but an interrupt, which ends the process.
    pub(super) fn still(
        &self,
        camera: &Camera,
        size: [u32; 2],
        exposure: Exposure,
        progress: impl FnMut(f64) + Send,
    ) -> Result<Still, Failure> {
        self.still_of(&self.corners, camera, size, exposure, progress)
    }

    fn still_of(
        &self,
        corners: &StillLight,
        camera: &Camera,
        size: [u32; 2],
        exposure: Exposure,
        progress: impl FnMut(f64) + Send,
    ) -> Result<Still, Failure> {
        let input = corners.input(&self.mesh, &self.picker, &self.solved.scene.textures, self.sky);
        let options =
            StillOptions { gains: self.gains, ..StillOptions::new(size, exposure, ToneMap::default()) };
        let progress = Mutex::new(progress);
        let still = render_still(&input, camera, &options, &|share| {
            progress.lock().unwrap_or_else(PoisonError::into_inner)(f64::from(share));
            true
        });
        still.ok_or_else(|| Failure::work(anyhow::anyhow!("the picture was given up")))
    }

    /// Renders a view with the exposure that suits it, and writes it.
    ///
    /// # Errors
    /// A refusal of the system to write.
    pub(super) fn write_view(
        &self,
        path: &Path,
        kind: StillKind,
        view: &View,
        size: [u32; 2],
    ) -> Result<(), Failure> {
        let camera = Camera::from_view(view, self.solved.scene.up.vector());
        let exposure = self.metered(&camera, size).unwrap_or_default();
        let mut line = ProgressLine::new();
        // An EXR holds what was solved, and nothing that is only shown.
        let solved = (kind == StillKind::Exr && self.even.is_some())
            .then(|| StillLight::new(&self.mesh, self.light, Shading::Gouraud));
        let corners = solved.as_ref().unwrap_or(&self.corners);
        let still = self.still_of(corners, &camera, size, exposure, |share| line.picture(share))?;
        drop(line);
        Ok(save_still(path, kind, &still)?)
    }

    /// A view with the exposure that suits it, as the bytes of a PNG file.
    ///
    /// # Errors
    /// As [`Self::still`].
    pub(super) fn png(&self, view: &View, size: [u32; 2]) -> Result<Vec<u8>, Failure> {
        let camera = Camera::from_view(view, self.solved.scene.up.vector());
        let exposure = self.metered(&camera, size).unwrap_or_default();
        let mut line = ProgressLine::new();
        let still = self.still(&camera, size, exposure, |share| line.picture(share))?;
        Ok(png_bytes(Path::new(&view.name), still.width, still.height, &still.to_rgba8())?)
    }

    /// Writes the lit sides with vertex radiosity, exposed for the scene as a whole.
    ///
    /// # Errors
    /// A refusal of the system to write.
    pub(super) fn write_mesh(&self, path: &Path) -> Result<(), ExportError> {
        let areas: Vec<(usize, f64)> =
            self.solved.mesh.patches.iter().map(|patch| patch.area).enumerate().collect();
        let exposure = self.exposure(&areas).unwrap_or_default();
        let origin = self.solved.scene.origin;
        save_lit_mesh(path, &self.mesh, origin, self.light, Shading::Gouraud, exposure, ToneMap::default())
    }
}
