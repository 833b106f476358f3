use super::System;
use crate::mesh::{NO_PATCH, PatchMesh};
use crate::scene::Lighting;
use crate::transport::{self, LANES, Lanes, Transport};
use crate::watch::Cancelled;
use std::sync::Arc;

/// Irradiance of every patch for every luminaire alone, at unit white exitance.
///
/// The solution is linear in emission: any mix of switched, dimmed and coloured lamps is one sum
/// over these. Values are in W/m² of irradiance per W/m² of exitance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBases {
    /// Patches.
    pub patches: usize,
    /// Luminaires.
    pub lamps: usize,
    /// 1 in a grey scene, 3 otherwise.
    pub bands: usize,
    /// `values[(patch * lamps + lamp) * bands + band]`.
    pub values: Vec<f32>,
}

/// Irradiance and radiosity of every patch under one lighting, W/m² per band.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchLight {
    /// Arriving: H.
    pub irradiance: Vec<[f32; 3]>,
    /// Leaving: B = E + rho H.
    pub radiosity: Vec<[f32; 3]>,
    /// The same light in more detail than a value per patch, where there is some.
    pub detail: Option<Arc<Detail>>,
}

/// Irradiance in two parts, W/m² per band: what comes from the lamps by itself, at the corners of elements, and what
/// surfaces pass on, per patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detail {
    /// A value per corner of the elements.
    pub direct: Vec<[f32; 3]>,
    /// A value per patch.
    pub interreflected: Vec<[f32; 3]>,
    /// What of the light of each patch comes from the lamps by itself.
    pub of_patches: Vec<[f32; 3]>,
    /// What arrives at each patch besides what passes between patches evenly: `of_patches`, and what leaves near patches
    /// from a spot.
    pub given: Vec<[f32; 3]>,
    /// Exitance of each basis of the direct light as the lamps stand, W/m² per band.
    pub outputs: Vec<[f32; 3]>,
    /// Reflectance of each patch per band.
    pub reflectance: Arc<Vec<[f32; 3]>>,
    /// What arrives from the sky and the sun, W over all bands.
    pub outdoors: f64,
}

impl LightBases {
    /// The light of every patch under `lighting`: one sum, no solve.
    ///
    /// `reflectance` holds the present reflectance of each patch per band, as solved for.
    pub fn mix(&self, mesh: &PatchMesh, lighting: &Lighting, reflectance: &[[f32; 3]]) -> PatchLight {
        let mut light = PatchLight {
            irradiance: self.sum(lighting, mesh.patches.len()),
            radiosity: Vec::with_capacity(self.patches),
            detail: None,
        };
        for (index, patch) in mesh.patches.iter().enumerate() {
            let irradiance = light.irradiance[index];
            let emission = patch_emission(patch, lighting);
            let rho = reflectance.get(index).copied().unwrap_or_default();
            light.radiosity.push(std::array::from_fn(|b| emission[b] + rho[b] * irradiance[b]));
        }
        for (index, radiosity) in light.radiosity.iter_mut().enumerate() {
            if let Some(passing) = mesh.translucence.at(index) {
                let far = passing.far(|j| light.irradiance[j].map(f64::from));
                for band in 0..3 {
                    radiosity[band] += (passing.share[band] * far[band]) as f32;
                }
            }
        }
        light
    }

    /// The same light on another mesh of the same scene: each patch takes what the patch of `mesh`
    /// at its centre has, or nothing where there is none. `None` where the meshes are of different
    /// scenes, or this light is not that of `mesh`.
    pub fn carried(&self, mesh: &PatchMesh, to: &PatchMesh) -> Option<Self> {
        let stride = self.lamps * self.bands;
        if self.patches != mesh.patches.len() || self.values.len() != self.patches * stride {
            return None;
        }
        let places = to.places_on(mesh)?;
        let mut values = vec![0.0; places.len() * stride];
        if stride > 0 {
            for (own, &place) in values.chunks_exact_mut(stride).zip(&places) {
                if place != NO_PATCH {
                    let at = place as usize * stride;
                    own.copy_from_slice(&self.values[at..at + stride]);
                }
            }
        }
        Some(Self { patches: places.len(), values, ..*self })
    }

    /// The values of the first `patches` patches under `lighting`: the sum over the lamps, each times
    /// its output. Zero where there are none.
    pub fn sum(&self, lighting: &Lighting, patches: usize) -> Vec<[f32; 3]> {
        let outputs: Vec<[f32; 3]> =
            lighting.lamps.iter().map(|lamp| lamp.output().map(|e| e as f32)).collect();
        let stride = (self.lamps * self.bands).max(1);
        (0..patches)
            .map(|index| {
                let values = self.values.get(index * stride..(index + 1) * stride).unwrap_or(&[]);
                let mut sum = [0.0_f32; 3];
                if self.bands == 3 {
                    for (value, output) in values.as_chunks::<3>().0.iter().zip(&outputs) {
                        for band in 0..3 {
                            sum[band] += value[band] * output[band];
                        }
                    }
                } else {
                    for (value, output) in values.iter().zip(&outputs) {
                        for band in 0..3 {
                            sum[band] += value * output[band];
                        }
                    }
                }
                sum
            })
            .collect()
    }
}

/// Where the power of a light goes, W over all bands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Power {
    /// By all lamps as they stand.
    pub emitted: f64,
    /// By all surfaces; the rest of a converged light leaves through openings.
    pub absorbed: f64,
}

impl PatchLight {
    /// What patches of these reflectances make of an irradiance, none of them emitting.
    pub fn reflected(irradiance: Vec<[f32; 3]>, reflectance: &[[f32; 3]]) -> Self {
        let lit = irradiance.iter().zip(reflectance);
        let radiosity = lit.map(|(h, rho)| std::array::from_fn(|band| rho[band] * h[band])).collect();
        Self { irradiance, radiosity, detail: None }
    }

    /// The same light on another mesh of the same scene, as [`LightBases::carried`] has it.
    pub fn carried(&self, mesh: &PatchMesh, to: &PatchMesh) -> Option<Self> {
        let places = to.places_on(mesh)?;
        let carry = |values: &[[f32; 3]]| {
            places.iter().map(|&place| values.get(place as usize).copied().unwrap_or_default()).collect()
        };
        let (irradiance, radiosity) = (carry(&self.irradiance), carry(&self.radiosity));
        Some(Self { irradiance, radiosity, detail: None })
    }

    /// The power of this light under `lighting`. With R what surfaces send out of what arrives, rho H for most, the lamps
    /// emit the sum of A (B - R) and the surfaces absorb that of A (H - R). Lamps that shine by their photometry emit their
    /// flux, the sky and the sun what of them arrives.
    pub fn power(&self, mesh: &PatchMesh, reflectance: &[[f32; 3]], lighting: &Lighting) -> Power {
        let lit = self.irradiance.iter().zip(&self.radiosity).zip(reflectance);
        let outdoors = self.detail.as_ref().map_or(0.0, |detail| detail.outdoors);
        let mut power = Power { emitted: photometric_power(mesh, lighting) + outdoors, absorbed: 0.0 };
        let arriving = |j: usize| self.irradiance.get(j).copied().unwrap_or_default().map(f64::from);
        for (index, (patch, ((h, b), rho))) in mesh.patches.iter().zip(lit).enumerate() {
            let is_photometric = patch.luminaire.is_some_and(|lamp| mesh.is_photometric(lamp));
            let sent = mesh.translucence.leaving(index, rho.map(f64::from), arriving);
            for band in 0..3 {
                let [h, b] = [h[band], b[band]].map(f64::from);
                if !is_photometric {
                    power.emitted += patch.area * (b - sent[band]);
                }
                power.absorbed += patch.area * (h - sent[band]);
            }
        }
        power
    }
}

/// What lamps emit that shine by their photometry, W over all bands.
pub fn photometric_power(mesh: &PatchMesh, lighting: &Lighting) -> f64 {
    let of = |source: &crate::scene::PhotometricSource| {
        let lamp = lighting.lamps.get(source.luminaire as usize);
        lamp.map_or(0.0, |lamp| source.area * lamp.output().iter().sum::<f64>())
    };
    mesh.photometric.iter().map(of).sum()
}

/// Exitance of a patch as its lamp is switched, dimmed and coloured, W/m² per band.
pub fn patch_emission(patch: &crate::mesh::Patch, lighting: &Lighting) -> [f32; 3] {
    let Some(lamp) = patch.luminaire.and_then(|l| lighting.lamps.get(l as usize)) else {
        return [0.0; 3];
    };
    let output = lamp.output();
    std::array::from_fn(|b| (output[b] * patch.emission_weight[b]) as f32)
}

/// What the lamps give by themselves, per patch and luminaire: gathered once from their exitance alone.
///
/// # Errors
/// It was `cancelled`.
pub fn direct_bases(
    transport: &dyn Transport,
    system: &System,
    cancelled: transport::Cancelled<'_>,
) -> Result<LightBases, Cancelled> {
    let (patches, columns) = (system.patches(), system.columns());
    let mut values = vec![0.0_f32; patches * columns];
    let mut irradiance = vec![[0.0; LANES]; patches];
    for first in (0..columns).step_by(LANES) {
        let exitance: Vec<Lanes> = (0..patches)
            .map(|i| {
                std::array::from_fn(|lane| {
                    if first + lane < columns { system.exitance(i, first + lane) } else { 0.0 }
                })
            })
            .collect();
        transport.gather(0..patches, &exitance, &mut irradiance, cancelled);
        if cancelled() {
            return Err(Cancelled);
        }
        for (own, found) in values.chunks_exact_mut(columns).zip(&irradiance) {
            for (lane, &value) in found.iter().enumerate().take(columns - first) {
                own[first + lane] = value as f32;
            }
        }
    }
    Ok(LightBases { patches, lamps: system.lamps, bands: system.bands, values })
}
