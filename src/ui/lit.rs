//! What the solver has found, made ready for the screen on a helper thread: summing light bases and
//! spreading it to the corners would take the window's own thread milliseconds, many times a solve.

use super::picture::shading_of;
use super::prepared::Prepared;
use super::state::ShadingMode;
use crate::outputs::in_detail;
use crate::render::{MeshUploader, UploadedSky};
use crate::scene::Lighting;
use crate::solve::ElementLight;
use crate::solver::{LightBases, PatchLight, Power};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Instant;

/// What light is made from.
#[derive(Clone)]
pub(super) struct Source {
    pub(super) prepared: Arc<Prepared>,
    /// Where the sky is another one than on screen, what brings it to the graphics card.
    pub(super) uploader: Option<MeshUploader>,
    pub(super) bases: Arc<LightBases>,
    pub(super) element_light: Option<Arc<ElementLight>>,
    pub(super) reflectance: Arc<Vec<[f32; 3]>>,
    pub(super) lighting: Lighting,
    pub(super) shading: ShadingMode,
}

/// Light for the screen.
pub(super) struct Lit {
    pub(super) source: Source,
    pub(super) light: PatchLight,
    /// Where its power goes.
    pub(super) power: Power,
    /// Its radiosities at the corners that are drawn.
    pub(super) corners: Vec<[f32; 3]>,
    /// The sky that it is of, where that was asked for.
    pub(super) sky: Option<UploadedSky>,
    /// How long this took.
    pub(super) seconds: f64,
}

impl Lit {
    fn new(source: Source) -> Self {
        let Source { prepared, uploader, bases, element_light, reflectance, lighting, shading } = &source;
        let clock = Instant::now();
        let light = bases.mix(&prepared.mesh, lighting, reflectance);
        let light = match element_light {
            Some(elements) => elements.detailed(light, lighting, reflectance),
            None => light,
        };
        let power = light.power(&prepared.mesh, reflectance, lighting);
        let shading = shading_of(*shading);
        let detail = light.detail.as_deref().map(in_detail);
        let corners =
            prepared.display.detailed_radiosity(&light.radiosity, &light.irradiance, detail, shading);
        let sky = uploader.as_ref().zip(prepared.scene.outdoors.as_ref());
        let sky = sky.map(|(uploader, outdoors)| uploader.sky(outdoors));
        let seconds = clock.elapsed().as_secs_f64();
        Self { light, power, corners, sky, seconds, source }
    }
}

/// Makes light, one at a time.
#[derive(Default)]
pub(super) struct LightMaker {
    underway: Option<(Source, Receiver<Lit>)>,
}

impl LightMaker {
    /// Begins to make light, unless some is being made. `wake` is called from the helper thread once it is there.
    pub(super) fn ask(&mut self, source: impl FnOnce() -> Source, wake: impl FnOnce() + Send + 'static) {
        if self.underway.is_some() {
            return;
        }
        let source = source();
        let (sender, receiver) = channel();
        let of = source.clone();
        let work = move || {
            // Nobody listens any more when the window has closed.
            sender.send(Lit::new(of)).ok();
            wake();
        };
        // Where no thread can be had the sender is gone, and `take` makes the light itself.
        std::thread::Builder::new().name("light for display".to_owned()).spawn(work).ok();
        self.underway = Some((source, receiver));
    }

    /// Light that is ready.
    pub(super) fn take(&mut self) -> Option<Lit> {
        let (source, receiver) = self.underway.take()?;
        match receiver.try_recv() {
            Ok(lit) => Some(lit),
            Err(TryRecvError::Empty) => {
                self.underway = Some((source, receiver));
                None
            }
            Err(TryRecvError::Disconnected) => Some(Lit::new(source)),
        }
    }
}
