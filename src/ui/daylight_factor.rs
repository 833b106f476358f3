//! Daylight factors of the scene on screen, computed on a helper thread once its light has settled.
//!
//! They depend on neither the hour nor the lamps, so that they are computed once for each solve.

use super::app::App;
use super::picture::shading_of;
use super::prepared::Prepared;
use super::state::{DisplaySettings, Quantity};
use crate::direct::Elements;
use crate::display::Detail;
use crate::scene::DaylightChoice;
use crate::session::Snapshot;
use crate::solve::{Overcast, Solution, daylight_factor};
use crate::solver::PatchLight;
use crate::transport::Transport;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What daylight factors depend on.
#[derive(Clone)]
pub(super) struct Of {
    mesh_serial: u64,
    transport: Arc<dyn Transport>,
    reflectance: Arc<Vec<[f32; 3]>>,
    /// The overcast sky over the ground of the scene.
    sky: DaylightChoice,
}

impl PartialEq for Of {
    fn eq(&self, other: &Self) -> bool {
        self.mesh_serial == other.mesh_serial
            && Arc::ptr_eq(&self.transport, &other.transport)
            && Arc::ptr_eq(&self.reflectance, &other.reflectance)
            && self.sky == other.sky
    }
}

impl Of {
    /// `None` where the scene has no sky or is not solved yet.
    fn new(solution: &Solution, mesh_serial: u64) -> Option<Self> {
        Some(Self {
            mesh_serial,
            transport: Arc::clone(solution.transport.as_ref()?),
            reflectance: Arc::clone(&solution.reflectance),
            sky: solution.scene.outdoors.as_ref()?.choice.reference(),
        })
    }
}

/// The daylight factors of all patches.
pub(super) struct Factors {
    /// Per cent.
    pub(super) of_patches: Vec<f32>,
    /// Under a sky of 1 W/m² in every band.
    light: PatchLight,
    /// That its direct light is at the corners of.
    elements: Option<Arc<Elements>>,
}

impl Factors {
    fn new(solution: &Solution) -> Option<Self> {
        let never = AtomicBool::new(false);
        let overcast = Overcast::of(solution, &never).ok().flatten()?;
        let light = overcast.solution.light(&overcast.lighting);
        let of_patches = percent(&light.irradiance);
        let elements = overcast.solution.element_light.map(|light| Arc::clone(&light.elements));
        Some(Self { of_patches, light, elements })
    }

    /// Those at the corners that are drawn, per cent.
    pub(super) fn at_corners(&self, prepared: &Prepared, display: &DisplaySettings) -> Vec<f32> {
        // Under a sky with sun elements are divided along its shadows as well.
        let detail = self.light.detail.as_deref();
        let direct = detail.zip(self.elements.as_ref()).zip(prepared.display.elements());
        let direct = direct.and_then(|((detail, own), drawn)| own.carried(&detail.direct, drawn));
        let detail = detail.zip(direct.as_ref()).map(|(detail, direct)| Detail {
            direct,
            interreflected: &detail.interreflected,
            reflectance: &detail.reflectance,
        });
        let shading = shading_of(display.shading);
        percent(&prepared.display.detailed_irradiance(&self.light.irradiance, detail, shading))
    }
}

fn percent(irradiance: &[[f32; 3]]) -> Vec<f32> {
    irradiance.iter().map(|h| daylight_factor(h.map(f64::from)) as f32).collect()
}

impl App {
    /// Has daylight factors computed where they are not known yet.
    pub(super) fn follow_daylight_factors(&mut self, ctx: &egui::Context) {
        if self.factors.listen() && self.edits.display.quantity == Quantity::DaylightFactor {
            self.stale.light = true;
        }
        let Some(solved) = self.snapshot.solved() else { return };
        let Some(of) = Of::new(&solved, self.snapshot.mesh_serial) else { return };
        let wake = ctx.clone();
        self.factors.ask(&of, move || Factors::new(&solved).map(Arc::new), move || wake.request_repaint());
    }

    /// The daylight factors of the scene on screen, where they are known.
    pub(super) fn daylight_factors(&self) -> Option<&Arc<Factors>> {
        let Snapshot { solution, mesh_serial, .. } = &*self.snapshot;
        let of = Of::new(solution.as_deref()?, *mesh_serial)?;
        let is_shown = self.picture.prepared.as_ref().is_some_and(|shown| shown.mesh_serial == *mesh_serial);
        let (_, found) = self.factors.latest().filter(|(known, _)| is_shown && **known == of)?;
        found.as_ref().as_ref()
    }
}
