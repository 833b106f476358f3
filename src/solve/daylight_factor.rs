//! Daylight factors: a solved scene under the overcast sky alone.

use super::error::PipelineError;
use super::pipeline::{Control, Prepared, Run, system};
use super::solution::Solution;
use crate::scene::{Lighting, luminance_weighted};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The daylight factor in per cent of a place with this irradiance, W/m² per band, in the light of an [`Overcast`].
///
/// D = 100 E / E_out with E the illuminance of the place and E_out that of the unobstructed horizontal, both under the
/// traditional overcast sky of the CIE (EN 17037:2018, 3.6), reflections included.
pub fn daylight_factor(irradiance: [f64; 3]) -> f64 {
    // Outside there is 1 W/m² in every band.
    100.0 * luminance_weighted(irradiance)
}

/// A solved scene under the traditional overcast sky of the CIE, with its own ground and glass. All lamps and the sun are
/// off; the sky gives the unobstructed horizontal 1 W/m² in every band, however it is switched or dimmed in the scene.
#[derive(Clone, Debug)]
pub struct Overcast {
    /// The scene under that sky.
    pub solution: Solution,
    /// The sky alone.
    pub lighting: Lighting,
    /// Whether the scene itself has another sky.
    pub is_other_sky: bool,
}

impl Overcast {
    /// Puts a solved scene under the overcast sky: mesh, rows and transport stay; direct light of the sky and what
    /// surfaces reflect of it are computed anew unless the scene's own sky is overcast. `None` for a scene without daylight
    /// and for one that is not solved.
    ///
    /// # Errors
    /// It was cancelled.
    pub fn of(solved: &Solution, cancel: &AtomicBool) -> Result<Option<Self>, PipelineError> {
        let (Some(outdoors), Some(_)) = (&solved.scene.outdoors, &solved.transport) else { return Ok(None) };
        let mut lighting = solved.scene.lighting();
        lighting.lamps.iter_mut().for_each(|lamp| lamp.on = false);
        if let Some(sky) = lighting.lamps.get_mut(outdoors.sky as usize) {
            (sky.on, sky.dimmer, sky.exitance) = (true, 1.0, [1.0; 3]);
        }
        let is_other_sky = !outdoors.is_reference();
        let solution = if is_other_sky { under_reference(solved, cancel)? } else { Some(solved.clone()) };
        Ok(solution.map(|solution| Self { solution, lighting, is_other_sky }))
    }
}

/// The same scene under the overcast sky. `None` where its light is not known in the detail that this takes.
fn under_reference(solved: &Solution, cancel: &AtomicBool) -> Result<Option<Solution>, PipelineError> {
    let (Some(outdoors), Some(standing), Some(transport)) =
        (&solved.scene.outdoors, &solved.element_light, &solved.transport)
    else {
        return Ok(None);
    };
    // 1. The same mesh under the other sky.
    let prepared = Prepared {
        scene: Arc::clone(&solved.scene),
        survey: Arc::clone(&solved.survey),
        mesh: Arc::clone(&solved.mesh),
        plan: Arc::clone(&solved.plan),
        computer: Arc::clone(&solved.computer),
        direct: solved.settings.direct,
        transport: solved.settings.transport,
        timings: solved.timings,
    }
    .under(&outdoors.choice.reference())?;
    let reflectance: Vec<[f64; 3]> = solved.reflectance.iter().map(|rho| rho.map(f64::from)).collect();
    let system = system(&prepared, &reflectance);
    if !standing.serves(&system) || solved.bases.values.len() != system.patches() * system.columns() {
        return Ok(None);
    }
    // 2. Its direct light, and what surfaces make of it: the light of all other lamps stays.
    let mut nobody = |_: super::Progress<'_>| Control::Continue;
    let mut run = Run::new(&mut nobody, cancel, solved.timings);
    let lit = run.shadows(&prepared, standing, &system)?;
    let guess = lit.guess(standing, &solved.bases);
    let lit = run.settle(&prepared, lit, transport.as_ref(), &system)?;
    let columns: Vec<usize> = (0..system.columns()).filter(|&column| system.is_outdoors(column)).collect();
    let system = system.with_direct(Some(&lit.given));
    let start = (Some(&guess), Some(columns.as_slice()));
    let (bases, sweeps) =
        run.sweeps_of(&prepared, transport.as_ref(), &system, start, solved.settings.tolerance)?;
    Ok(Some(Solution {
        scene: prepared.scene,
        mesh: prepared.mesh,
        element_light: Some(Arc::new(lit)),
        bases: Arc::new(bases),
        sweeps,
        budget: None,
        ..solved.clone()
    }))
}
