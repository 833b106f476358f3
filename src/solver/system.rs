use super::LightBases;
use crate::mesh::{PatchMesh, Translucence};
use crate::scene::Lighting;
use std::sync::Arc;

/// The right-hand sides of all bases: reflectance, emission and direct light per patch.
///
/// A column is one band of one luminaire; columns run lamp by lamp, band by band. Where the scene
/// is grey, one band stands for all three.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// Luminaires.
    pub lamps: usize,
    /// 1 or 3.
    pub bands: usize,
    /// Reflectance of each patch a band, 0 to below 1.
    pub reflectance: Vec<[f64; 3]>,
    /// The luminaire of each patch and its relative exitance a band; `None` where it does not emit.
    pub emission: Vec<Option<(u32, [f64; 3])>>,
    /// Area of each patch, m².
    pub areas: Vec<f64>,
    /// Exitance a column for the lamps as they come with the scene, W/m².
    pub output: Vec<f64>,
    /// What each lamp sends out that is no exitance of its patches, W for a unit of its exitance: of those that shine
    /// by their photometry all, m². A lamp beyond the list has none.
    pub photometric: Vec<f64>,
    /// Which lamps are the sky or the sun: what they send out is what arrives. A lamp beyond the list is neither.
    pub outdoors: Vec<bool>,
    /// Which patches pass what arrives on their far sides.
    pub translucence: Arc<Translucence>,
    /// Irradiance of each patch straight from the lamps, at unit exitance, where it is known better than by
    /// gathering their emission.
    pub direct: Option<Arc<LightBases>>,
}

impl System {
    /// Reads a mesh. With `colour` off, reflectances and emission must be grey: the first band stands
    /// for all (see [`crate::effects::Effect::ColourBands`]).
    pub fn new(mesh: &PatchMesh, reflectance: &[[f64; 3]], lighting: &Lighting, colour: bool) -> Self {
        let bands = if colour { 3 } else { 1 };
        // Lamps may be coloured where all surfaces are grey; the one band then carries their mean.
        let mut output: Vec<f64> = lighting
            .lamps
            .iter()
            .flat_map(|lamp| {
                let output = lamp.output();
                if colour { output.to_vec() } else { vec![output.iter().sum::<f64>() / 3.0] }
            })
            .collect();
        if output.iter().all(|&o| o <= 0.0) {
            output.fill(1.0);
        }
        Self {
            lamps: lighting.lamps.len(),
            bands,
            reflectance: reflectance.to_vec(),
            emission: mesh
                .patches
                .iter()
                .map(|p| Some((p.luminaire.filter(|&lamp| !mesh.is_photometric(lamp))?, p.emission_weight)))
                .collect(),
            photometric: {
                let mut areas = vec![0.0; lighting.lamps.len()];
                for source in &mesh.photometric {
                    if let Some(area) = areas.get_mut(source.luminaire as usize) {
                        *area += source.area;
                    }
                }
                areas
            },
            outdoors: (0..lighting.lamps.len() as u32).map(|lamp| mesh.is_outdoors(lamp)).collect(),
            areas: mesh.patches.iter().map(|p| p.area).collect(),
            output,
            translucence: match colour || !mesh.translucence.is_tinted() {
                true => Arc::clone(&mesh.translucence),
                false => Arc::new(mesh.translucence.grey()),
            },
            direct: None,
        }
    }

    /// The same with this direct light, if it has as many patches and columns.
    #[must_use]
    pub fn with_direct(self, direct: Option<&Arc<LightBases>>) -> Self {
        let fits = |light: &&Arc<LightBases>| light.values.len() == self.patches() * self.columns();
        Self { direct: direct.filter(fits).cloned(), ..self }
    }

    /// Columns in all.
    pub fn columns(&self) -> usize {
        self.lamps * self.bands
    }

    /// Patches.
    pub fn patches(&self) -> usize {
        self.areas.len()
    }

    /// Exitance of a patch in a column at unit output.
    pub fn exitance(&self, patch: usize, column: usize) -> f64 {
        match self.emission[patch] {
            Some((lamp, weight)) if lamp as usize == column / self.bands => weight[column % self.bands],
            _ => 0.0,
        }
    }

    /// What the lamp of a column sends out by its photometry for a unit of its exitance, m².
    pub fn photometric_area(&self, column: usize) -> f64 {
        self.photometric.get(column / self.bands).copied().unwrap_or(0.0)
    }

    /// Whether the lamp of a column is the sky or the sun.
    pub fn is_outdoors(&self, column: usize) -> bool {
        self.outdoors.get(column / self.bands).copied().unwrap_or(false)
    }

    /// Reflectance of a patch in a column.
    pub fn rho(&self, patch: usize, column: usize) -> f64 {
        self.reflectance[patch][column % self.bands]
    }

    /// What a patch sends out in a column of what arrives on its two sides; `arriving` gives the irradiance of each patch.
    pub fn leaving(&self, patch: usize, column: usize, arriving: impl Fn(usize) -> f64) -> f64 {
        self.rho(patch, column) * arriving(patch) + self.passed(patch, column, arriving)
    }

    /// What of this comes from its far side.
    pub fn passed(&self, patch: usize, column: usize, arriving: impl Fn(usize) -> f64) -> f64 {
        self.translucence.at(patch).map_or(0.0, |passing| {
            let far: f64 = passing.behind.iter().map(|&(far, share)| share * arriving(far as usize)).sum();
            passing.share[column % self.bands] * far
        })
    }

    /// The greatest share of what arrives on both sides of a patch that it sends out in any band.
    pub fn greatest_share(&self, patch: usize) -> f64 {
        let share = |band: usize| self.translucence.at(patch).map_or(0.0, |passing| passing.share[band]);
        (0..self.bands).map(|band| self.reflectance[patch][band] + share(band)).fold(0.0, f64::max)
    }
}
