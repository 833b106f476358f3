use crate::mesh::PatchMesh;
use crate::scene::Lighting;

/// Irradiance of every patch for every luminaire alone, at unit white exitance.
///
/// The solution is linear in emission: any mix of switched, dimmed and coloured lamps is one sum
/// over these. Values are in W/m² of irradiance per W/m² of exitance.
#[derive(Clone, Debug, Default)]
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
}

impl LightBases {
    /// The light of every patch under `lighting`: one sum, no solve.
    ///
    /// `reflectance` holds the present reflectance of each patch per band, as solved for.
    pub fn mix(&self, mesh: &PatchMesh, lighting: &Lighting, reflectance: &[[f32; 3]]) -> PatchLight {
        let outputs: Vec<[f32; 3]> =
            lighting.lamps.iter().map(|lamp| lamp.output().map(|e| e as f32)).collect();
        let mut light = PatchLight {
            irradiance: Vec::with_capacity(self.patches),
            radiosity: Vec::with_capacity(self.patches),
        };
        let stride = (self.lamps * self.bands).max(1);
        for (index, patch) in mesh.patches.iter().enumerate() {
            let values = self.values.get(index * stride..(index + 1) * stride).unwrap_or(&[]);
            let mut irradiance = [0.0_f32; 3];
            if self.bands == 3 {
                for (value, output) in values.as_chunks::<3>().0.iter().zip(&outputs) {
                    for band in 0..3 {
                        irradiance[band] += value[band] * output[band];
                    }
                }
            } else {
                for (value, output) in values.iter().zip(&outputs) {
                    for band in 0..3 {
                        irradiance[band] += value * output[band];
                    }
                }
            }
            let emission = patch_emission(patch, lighting);
            let rho = reflectance.get(index).copied().unwrap_or_default();
            light.irradiance.push(irradiance);
            light.radiosity.push(std::array::from_fn(|b| emission[b] + rho[b] * irradiance[b]));
        }
        light
    }
}

/// Exitance of a patch as its lamp is switched, dimmed and coloured, W/m² per band.
pub fn patch_emission(patch: &crate::mesh::Patch, lighting: &Lighting) -> [f32; 3] {
    let Some(lamp) = patch.luminaire.and_then(|l| lighting.lamps.get(l as usize)) else {
        return [0.0; 3];
    };
    let output = lamp.output();
    std::array::from_fn(|b| (output[b] * patch.emission_weight[b]) as f32)
}
