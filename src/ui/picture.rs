//! From snapshots and lamps to what the graphics card draws.
//!
//! A new mesh and its light are prepared on helper threads; until both are ready the old scene stays on
//! screen, whole. Light is one sum over light bases: on a helper thread where the solver brings new ones,
//! at once where a lamp is switched.

use super::comparison::Kept;
use super::drawn::Drawn;
use super::exposure::Metered;
use super::lit::{LightMaker, Lit, Source};
use super::panels::solver::is_running;
use super::prepared::Prepared;
use super::reclaim::Reclaim;
use super::state::{DisplaySettings, Quantity, ShadingMode};
use crate::direct::Elements;
use crate::display::{
    ColourMap, FalseColour, Shading, luminance, patch_illuminance, patch_luminance, usual_lighting,
};
use crate::effects::Effect;
use crate::mesh::{PatchMesh, Side};
use crate::outputs::in_detail;
use crate::render::{MeshUploader, UploadError, UploadedMesh, UploadedSky};
use crate::scene::{Lighting, Scene, luminance_weighted};
use crate::session::Snapshot;
use crate::solve::ElementLight;
use crate::solver::{LightBases, PatchLight, Power};
use std::borrow::Cow;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// How long light of a mesh that is on screen may wait for the next frame, seconds. While the solver is at
/// work it tells of itself more often than that, and every further frame that a software driver draws is
/// taken from it.
const PATIENCE: f32 = 0.1;

/// What the helper thread makes of a mesh.
struct Built {
    prepared: Arc<Prepared>,
    uploaded: Option<Result<UploadedMesh, UploadError>>,
}

impl Built {
    fn new(
        serial: u64,
        scene: Arc<Scene>,
        mesh: Arc<PatchMesh>,
        smooth: bool,
        (elements, before): (Option<&Arc<Elements>>, Option<&Arc<Prepared>>),
        uploader: Option<&MeshUploader>,
    ) -> Self {
        let prepared = Arc::new(Prepared::build(serial, scene, mesh, smooth, elements, before));
        let Prepared { display, scene, .. } = &*prepared;
        let uploaded = uploader.map(|u| u.upload(display, &scene.textures, scene.outdoors.as_ref()));
        Self { prepared, uploaded }
    }
}

/// What changed since the last look, for the caller to act on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct News {
    /// Another mesh is on screen.
    pub(super) mesh: bool,
    /// Other bases or reflectances are in force.
    pub(super) bases: bool,
}

/// The scene on screen and its light.
#[derive(Default)]
pub(super) struct Picture {
    pub(super) prepared: Option<Arc<Prepared>>,
    building: Option<(Drawn, Receiver<Built>)>,
    /// A mesh that waits for its light.
    arriving: Option<Built>,
    /// Where there is a graphics card.
    uploader: Option<MeshUploader>,
    /// The mesh that came to the screen last, on its way to the renderer.
    pub(super) uploaded: Option<Result<UploadedMesh, UploadError>>,
    /// The sky of another hour, on its way there.
    pub(super) uploaded_sky: Option<UploadedSky>,
    maker: LightMaker,
    pub(super) bases: Option<Arc<LightBases>>,
    element_light: Option<Arc<ElementLight>>,
    pub(super) reflectance: Arc<Vec<[f32; 3]>>,
    /// That `light` is of.
    lighting: Lighting,
    /// As the lamps stand.
    pub(super) light: PatchLight,
    /// Its radiosities at the corners that are drawn, where the helper thread has spread them.
    corners: Option<(ShadingMode, Vec<[f32; 3]>)>,
    /// Where its power goes.
    pub(super) power: Power,
    /// Seconds that light took last from its bases to the corners that are drawn.
    pub(super) display_seconds: f64,
    /// Grows with every change of `light`.
    pub(super) light_version: u64,
    /// State A.
    pub(super) comparison: Option<Kept>,
}

impl Picture {
    /// Nothing yet; meshes go to the graphics card through `uploader`.
    pub(super) fn new(uploader: Option<MeshUploader>) -> Self {
        Self { uploader, ..Self::default() }
    }

    /// Takes over what the worker published; what it replaces goes to `reclaim`. A new mesh comes to the
    /// screen together with its light. Light is made for the lamps that `lighting` tells of a scene; where
    /// they have changed meanwhile the caller has it [settled](Self::settle). `wake` is called from helper
    /// threads once there is something to look for, with the seconds that it may wait.
    pub(super) fn follow(
        &mut self,
        snapshot: &Snapshot,
        lighting: impl FnOnce(&Arc<Scene>) -> Lighting,
        shading: ShadingMode,
        reclaim: &Reclaim,
        wake: impl Fn(f32) + Clone + Send + 'static,
    ) -> News {
        let serial = snapshot.mesh_serial;
        let soon = wake.clone();
        self.start_building(snapshot, move || soon(0.0));
        if let Some((_, receiver)) = &self.building {
            match receiver.try_recv() {
                Ok(built) => {
                    reclaim.later(self.arriving.replace(built));
                    self.building = None;
                }
                Err(TryRecvError::Disconnected) => self.building = None,
                Err(TryRecvError::Empty) => {}
            }
        }
        // A mesh that is out of date already is not worth showing.
        reclaim.later(self.arriving.take_if(|built| built.prepared.mesh_serial != serial));
        let mut news = News::default();
        match self.maker.take() {
            // Light of the mesh that waits brings that; light of another than what is or comes on screen is of no use.
            Some(lit) if self.is_arriving(&lit.source.prepared) => {
                news.mesh = self.bring_mesh(reclaim);
                self.take_light(lit, reclaim);
                news.bases = true;
            }
            Some(lit) if self.is_present(&lit.source.prepared, serial) => {
                self.take_light(lit, reclaim);
                news.bases = true;
            }
            stale => reclaim.later(stale),
        }
        let arriving = self.arriving.as_ref().map(|built| &built.prepared);
        // With other elements the light would not fit the mesh: one that has them is on its way.
        let wanted = Drawn::by(snapshot);
        let Some(prepared) = arriving.or(self.prepared.as_ref()).filter(|p| Drawn::of(p).is(&wanted)) else {
            return news;
        };
        match snapshot.bases().zip(snapshot.reflectance()) {
            Some((bases, reflectance)) if arriving.is_some() || !self.is_lit_by(bases, reflectance) => {
                let prepared = Prepared::under_sky_of(prepared, snapshot);
                let is_other_sky =
                    self.prepared.as_ref().is_none_or(|own| !Arc::ptr_eq(&own.scene, &prepared.scene));
                let uploader = self.uploader.clone().filter(|_| is_other_sky);
                let source = || Source {
                    prepared: Arc::clone(&prepared),
                    uploader,
                    bases: Arc::clone(bases),
                    element_light: snapshot.element_light().cloned(),
                    reflectance: Arc::clone(reflectance),
                    lighting: lighting(&prepared.scene),
                    shading,
                };
                let patience = if arriving.is_some() { 0.0 } else { PATIENCE };
                self.maker.ask(source, move || wake(patience));
            }
            // Light is on its way, or there will be none.
            None if snapshot.paused || !is_running(snapshot.stage) => news.mesh |= self.bring_mesh(reclaim),
            _ => {}
        }
        news
    }

    /// Whether this is the mesh that waits for its light.
    fn is_arriving(&self, prepared: &Arc<Prepared>) -> bool {
        self.arriving.as_ref().is_some_and(|built| Arc::ptr_eq(&built.prepared.display, &prepared.display))
    }

    /// Whether this is the mesh on screen, and still the newest.
    fn is_present(&self, prepared: &Arc<Prepared>, serial: u64) -> bool {
        let is =
            |own: &Arc<Prepared>| Arc::ptr_eq(&own.display, &prepared.display) && own.mesh_serial == serial;
        self.prepared.as_ref().is_some_and(is)
    }

    fn is_lit_by(&self, bases: &Arc<LightBases>, reflectance: &Arc<Vec<[f32; 3]>>) -> bool {
        self.bases.as_ref().is_some_and(|own| Arc::ptr_eq(own, bases))
            && Arc::ptr_eq(&self.reflectance, reflectance)
    }

    /// Brings the mesh that waits to the screen, dark. Returns whether it is another one than was there, and not the
    /// same in more detail.
    fn bring_mesh(&mut self, reclaim: &Reclaim) -> bool {
        let Some(Built { prepared, uploaded }) = self.arriving.take() else { return false };
        self.uploaded = uploaded;
        let is_new = self.prepared.as_ref().is_none_or(|old| old.mesh_serial != prepared.mesh_serial);
        reclaim.later(self.prepared.replace(prepared));
        (self.bases, self.corners) = (None, None);
        self.light = PatchLight::default();
        self.light_version += 1;
        is_new
    }

    fn take_light(&mut self, lit: Lit, reclaim: &Reclaim) {
        let Source { prepared, bases, element_light, reflectance, lighting, shading, .. } = lit.source;
        // Of the same mesh, under the sky that this light is of.
        reclaim.later(self.prepared.replace(prepared));
        if lit.sky.is_some() {
            self.uploaded_sky = lit.sky;
        }
        reclaim.later(self.bases.replace(bases));
        self.element_light = element_light;
        (self.reflectance, self.lighting) = (reflectance, lighting);
        (self.light, self.power, self.display_seconds) = (lit.light, lit.power, lit.seconds);
        self.corners = Some((shading, lit.corners));
        self.light_version += 1;
    }

    fn start_building(&mut self, snapshot: &Snapshot, wake: impl FnOnce() + Send + 'static) {
        let serial = snapshot.mesh_serial;
        let (Some(scene), Some(mesh)) = (snapshot.scene(), snapshot.mesh()) else { return };
        let wanted = Drawn::by(snapshot);
        let elements = wanted.elements.clone();
        let shown = self.prepared.as_ref().map(|p| Drawn::of(p));
        let arriving = self.arriving.as_ref().map(|built| Drawn::of(&built.prepared));
        let underway = self.building.as_ref().map(|b| b.0.clone());
        if [shown, arriving, underway].iter().flatten().any(|drawn| drawn.is(&wanted)) {
            return;
        }
        let (scene, mesh) = (Arc::clone(scene), Arc::clone(mesh));
        let smooth = snapshot.plan().is_none_or(|plan| plan.is_on(Effect::SmoothSurfaces));
        let (uploader, before) = (self.uploader.clone(), self.prepared.clone());
        let (sender, receiver) = channel();
        let build = move || {
            // Nobody listens any more when the window has closed.
            let parts = (elements.as_ref(), before.as_ref());
            sender.send(Built::new(serial, scene, mesh, smooth, parts, uploader.as_ref())).ok();
            wake();
        };
        if std::thread::Builder::new().name("mesh for display".to_owned()).spawn(build).is_ok() {
            self.building = Some((wanted, receiver));
        }
    }

    /// Whether a mesh is on its way to the screen.
    pub(super) fn is_building(&self) -> bool {
        self.building.is_some() || self.arriving.is_some()
    }

    /// The light of all patches as the lamps stand: one sum, no solve. Where it is of these lamps already nothing is done.
    pub(super) fn settle(&mut self, lighting: &Lighting) {
        if let (Some(prepared), Some(bases)) = (&self.prepared, &self.bases)
            && self.lighting != *lighting
            // Else a mesh with other lamps is on its way.
            && lighting.lamps.len() == prepared.scene.luminaires.len()
        {
            let light = bases.mix(&prepared.mesh, lighting, &self.reflectance);
            self.light = match &self.element_light {
                Some(elements) => elements.detailed(light, lighting, &self.reflectance),
                None => light,
            };
            self.power = self.light.power(&prepared.mesh, &self.reflectance, lighting);
            self.lighting.clone_from(lighting);
            self.corners = None;
            self.light_version += 1;
        }
    }

    /// Luminances in cd/m² of `seen` patches that are no lamps: as the lamps stand, under state A
    /// where `with_kept`, and as they come with the file (all of them on, where none is).
    pub(super) fn metered(&self, seen: &[u32], with_kept: bool) -> Metered {
        let (Some(prepared), Some(bases)) = (&self.prepared, &self.bases) else { return Metered::default() };
        let usual = usual_lighting(&prepared.scene);
        let outputs: Vec<[f64; 3]> = usual.lamps.iter().map(|lamp| lamp.output()).collect();
        let lit = |&p: &u32| prepared.mesh.patches.get(p as usize).is_some_and(|p| p.luminaire.is_none());
        let patches = || seen.iter().filter(|p| lit(p)).map(|&p| p as usize);
        let under = |light: &PatchLight| {
            patches().filter_map(|p| Some(luminance(*light.radiosity.get(p)?))).collect::<Vec<f64>>()
        };
        let kept = self.kept().filter(|_| with_kept).map(|kept| under(&kept.light));
        let usual = patches().filter_map(|p| {
            let stride = bases.lamps * bases.bands;
            let values = bases.values.get(p * stride..(p + 1) * stride)?;
            let rho = self.reflectance.get(p)?;
            let mut radiosity = [0.0_f32; 3];
            for (factors, output) in values.chunks_exact(bases.bands.max(1)).zip(&outputs) {
                for band in 0..3 {
                    radiosity[band] += rho[band] * factors[band.min(bases.bands - 1)] * output[band] as f32;
                }
            }
            Some(luminance(radiosity))
        });
        Metered { shown: [under(&self.light)].into_iter().chain(kept).collect(), usual: usual.collect() }
    }

    /// The values of a false-colour quantity under this light, one a patch.
    pub(super) fn scalars(&self, quantity: Quantity, light: &PatchLight) -> Vec<f32> {
        let Some(prepared) = &self.prepared else { return Vec::new() };
        let patches = &prepared.mesh.patches;
        match quantity {
            Quantity::Illuminance => patch_illuminance(&light.irradiance),
            Quantity::Luminance => patch_luminance(&light.radiosity),
            Quantity::Difference => {
                let stored = self.kept().map_or(Vec::new(), |kept| patch_illuminance(&kept.light.irradiance));
                let now = patch_illuminance(&light.irradiance);
                now.iter().zip(&stored).map(|(now, stored)| now - stored).collect()
            }
            Quantity::Reflectance => {
                let rho = |r: &[f32; 3]| luminance_weighted(r.map(f64::from)) as f32;
                self.reflectance.iter().map(rho).collect()
            }
            Quantity::Sides => {
                patches.iter().map(|p| if p.side == Side::Front { -1.0 } else { 1.0 }).collect()
            }
            Quantity::Aspect => prepared.aspect.to_vec(),
            Quantity::Area => patches.iter().map(|p| p.area as f32).collect(),
            // What is no number, and what the microscope sees.
            _ => Vec::new(),
        }
    }

    /// Radiosities of the light on screen at the corners that are drawn, each band times its gain.
    pub(super) fn corner_radiosity(&self, shading: ShadingMode, gains: [f32; 3]) -> Cow<'_, [[f32; 3]]> {
        match &self.corners {
            Some((of, corners)) if *of == shading && gains == [1.0; 3] => Cow::Borrowed(corners),
            Some((of, corners)) if *of == shading => Cow::Owned(amplified(corners.clone(), gains)),
            _ => Cow::Owned(self.corner_radiosity_of(&self.light, shading, gains)),
        }
    }

    /// Radiosities of a light at the corners that are drawn, each band times its gain.
    pub(super) fn corner_radiosity_of(
        &self,
        light: &PatchLight,
        shading: ShadingMode,
        gains: [f32; 3],
    ) -> Vec<[f32; 3]> {
        let Some(prepared) = &self.prepared else { return Vec::new() };
        let (radiosity, irradiance) = (&light.radiosity, &light.irradiance);
        let detail = light.detail.as_deref().map(in_detail);
        let corners = prepared.display.detailed_radiosity(radiosity, irradiance, detail, shading_of(shading));
        amplified(corners, gains)
    }

    /// Values of patches with the areas that have them, m².
    pub(super) fn with_areas<'a>(&'a self, values: &'a [f32]) -> impl Iterator<Item = (f32, f64)> + 'a {
        let patches = self.prepared.iter().flat_map(|p| &p.mesh.patches);
        values.iter().copied().zip(patches.map(|p| p.area))
    }

    /// False-colour values of a light at the corners that are drawn; `values` are those of its patches.
    pub(super) fn corner_scalars_of(
        &self,
        light: Option<&PatchLight>,
        values: &[f32],
        display: &DisplaySettings,
    ) -> Vec<f32> {
        match (&self.prepared, light) {
            (Some(prepared), Some(light)) if display.quantity == Quantity::Illuminance => {
                let detail = light.detail.as_deref().map(in_detail);
                let shading = shading_of(display.shading);
                patch_illuminance(&prepared.display.detailed_irradiance(&light.irradiance, detail, shading))
            }
            _ => self.corner_scalars(values, display),
        }
    }

    /// False-colour values at the corners that are drawn.
    pub(super) fn corner_scalars(&self, values: &[f32], display: &DisplaySettings) -> Vec<f32> {
        // What belongs to a patch as a whole is not spread between patches.
        let shading =
            if display.quantity.follows_light() { shading_of(display.shading) } else { Shading::Flat };
        self.prepared.as_ref().map_or_else(Vec::new, |p| p.display.corner_scalars(values, shading))
    }
}

/// Values of three bands, each band times its gain.
fn amplified(mut values: Vec<[f32; 3]>, gains: [f32; 3]) -> Vec<[f32; 3]> {
    if gains != [1.0; 3] {
        for value in &mut values {
            *value = std::array::from_fn(|b| value[b] * gains[b]);
        }
    }
    values
}

/// Least value that the scale of what spans decades tells apart, of its largest.
const ROW_DECADES: f64 = 1e-3;

/// The scale of a quantity for these values, each with the area that has it: its pinned range, or one
/// that fits.
pub(super) fn scale(display: &DisplaySettings, values: &[(f32, f64)]) -> FalseColour {
    let map = if display.quantity.is_signed() { ColourMap::BlueRed } else { ColourMap::Viridis };
    let mut scale = match display.quantity {
        Quantity::Reflectance => FalseColour { map, range: [0.0, 1.0], logarithmic: false },
        // Usual rooms lie within it, and pictures of two designs compare.
        Quantity::DaylightFactor => {
            let range = if display.logarithmic { [0.1, 10.0] } else { [0.0, 10.0] };
            FalseColour { map, range, logarithmic: display.logarithmic }
        }
        Quantity::Sides => FalseColour { map, range: [-1.0, 1.0], logarithmic: false },
        _ => FalseColour::fitted_by_area(map, display.logarithmic, values),
    };
    if display.quantity.spans_decades() && scale.logarithmic {
        // Slivers of what is hardly seen must not take the colours of what is.
        scale.range[0] = scale.range[0].max(ROW_DECADES * scale.range[1]);
    }
    if let Some(range) = display.range {
        scale.range = range;
    }
    scale
}

pub(super) fn shading_of(mode: ShadingMode) -> Shading {
    match mode {
        ShadingMode::Smooth => Shading::Gouraud,
        ShadingMode::Flat => Shading::Flat,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::DisplayMesh;
    use crate::effects::EffectChoices;
    use crate::scene::{SceneSource, from_text, load};
    use crate::solve::{Control, Solution, SolveSettings, Stage, prepare, solve};
    use std::sync::atomic::AtomicBool;
    use std::time::{Duration, Instant};

    /// A light that has converged.
    fn converged() -> Snapshot {
        let scene = load(&SceneSource::Builtin("cornell".to_owned())).unwrap();
        let settings = SolveSettings {
            patches: crate::mesh::PatchTarget::Count(60),
            resolution: Some(16),
            ..SolveSettings::default()
        };
        let never = AtomicBool::new(false);
        let solved = solve(Arc::new(scene), &settings, &never, &mut |_| Control::Continue).unwrap();
        Snapshot { mesh_serial: 1, ..Snapshot::of(solved) }
    }

    /// The same before its first light.
    fn dark(mut snapshot: Snapshot, stage: Stage) -> Snapshot {
        snapshot.stage = stage;
        snapshot.solution_mut().unwrap().bases = Arc::default();
        snapshot
    }

    fn news_of(picture: &mut Picture, snapshot: &Snapshot) -> News {
        let lighting = |scene: &Arc<Scene>| scene.lighting();
        picture.follow(snapshot, lighting, ShadingMode::Smooth, &Reclaim::default(), |_| {})
    }

    /// Follows until there is news.
    fn wait(picture: &mut Picture, snapshot: &Snapshot) -> News {
        let deadline = Instant::now() + Duration::from_secs(60);
        while Instant::now() < deadline {
            let news = news_of(picture, snapshot);
            if news.mesh || news.bases {
                return news;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("nothing came to the screen");
    }

    #[test]
    fn a_mesh_comes_to_the_screen_with_its_light() {
        let lit = converged();
        let mut picture = Picture::default();
        let dark = dark(lit.clone(), Stage::Rows);
        while picture.arriving.is_none() {
            let news = news_of(&mut picture, &dark);
            assert!(!news.mesh && picture.prepared.is_none(), "a mesh that has no light yet is not shown");
            std::thread::sleep(Duration::from_millis(1));
        }
        let news = wait(&mut picture, &lit);
        assert!(news.mesh && news.bases);
        assert!(picture.light.radiosity.iter().any(|b| b[1] > 0.0));
        let spread = picture.corner_radiosity_of(&picture.light, ShadingMode::Smooth, [2.0; 3]);
        assert_eq!(*picture.corner_radiosity(ShadingMode::Smooth, [2.0; 3]), *spread);
        let flat = picture.corner_radiosity_of(&picture.light, ShadingMode::Flat, [1.0; 3]);
        assert_eq!(*picture.corner_radiosity(ShadingMode::Flat, [1.0; 3]), *flat);
    }

    #[test]
    fn smooth_surfaces_that_are_switched_off_are_not_drawn_smooth() {
        // A fold of two rectangles whose normals along it agree.
        let obj = "mtllib fold.mtl\nv 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 1.9 0.3 0\nv 1.9 0.3 1\n\
            vn 0 1 0\nvn -0.2 1 0\nvn -0.4 1 0\nusemtl glow\n\
            f 4//1 3//2 2//2 1//1\nf 3//2 6//3 5//3 2//2\n";
        let scene = from_text("fold", obj, "newmtl glow\nKd .5 .5 .5\nKe 1 1 1\n", None).unwrap();
        let scene = Arc::new(scene);
        for (without, is_smooth) in [(vec![], true), (vec![Effect::SmoothSurfaces], false)] {
            let effects = EffectChoices { with: vec![], without };
            let settings = SolveSettings { effects, ..SolveSettings::default() };
            let prepared = prepare(Arc::clone(&scene), &settings).unwrap();
            let snapshot = Snapshot {
                mesh_serial: 1,
                stage: Stage::Stopped,
                solution: Some(Arc::new(Solution::new(&prepared, &settings))),
                ..Snapshot::default()
            };
            let mut picture = Picture::default();
            wait(&mut picture, &snapshot);
            let drawn = &picture.prepared.as_ref().unwrap().display;
            let expected = DisplayMesh::build(&prepared.mesh, &scene, is_smooth);
            let normals = |mesh: &DisplayMesh| mesh.corners.iter().map(|c| c.normal).collect::<Vec<_>>();
            assert_eq!(normals(drawn), normals(&expected));
            let other = DisplayMesh::build(&prepared.mesh, &scene, !is_smooth);
            assert_ne!(normals(drawn), normals(&other));
        }
    }

    #[test]
    fn a_mesh_that_will_have_no_light_is_shown_dark() {
        let snapshot = dark(converged(), Stage::Stopped);
        let mut picture = Picture::default();
        let news = wait(&mut picture, &snapshot);
        assert!(news.mesh && !news.bases && picture.light.radiosity.is_empty());
    }

    #[test]
    fn a_lamp_that_was_switched_while_its_light_was_made_is_out() {
        let snapshot = converged();
        let mut picture = Picture::default();
        wait(&mut picture, &snapshot);
        let mut lighting = snapshot.scene().unwrap().lighting();
        lighting.lamps.iter_mut().for_each(|lamp| lamp.on = false);
        let version = picture.light_version;
        picture.settle(&lighting);
        assert!(picture.light_version > version);
        assert!(picture.light.radiosity.iter().all(|b| *b == [0.0; 3]));
        assert!(picture.corner_radiosity(ShadingMode::Smooth, [1.0; 3]).iter().all(|b| *b == [0.0; 3]));
    }
}
