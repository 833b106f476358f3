use super::pipeline::Prepared;
use crate::direct::{DirectLight, ElementSettings, Elements};
use crate::effects::Effect;
use crate::emitters::Basis;
use crate::mesh::PatchMesh;
use crate::scene::{Lighting, luminance_weighted};
use crate::solver::{Detail, LightBases, PatchLight, System, direct_bases};
use crate::transport::Transport;
use crate::watch::{Cancelled, Watch};
use std::sync::Arc;

/// The direct light of a scene on elements, for every state of the lamps.
#[derive(Clone, Debug)]
pub struct ElementLight {
    /// Where it is kept.
    pub elements: Arc<Elements>,
    /// Gives the same at any point.
    pub direct: Arc<DirectLight>,
    /// What the values at their corners are of.
    pub bases: Vec<Basis>,
    /// The direct light that is in the light of the patches, per luminaire: the means of their elements, each lamp's
    /// scaled so that what it emits arrives.
    pub of_patches: Arc<LightBases>,
    /// What it was scaled by, per luminaire and band; 1 until the transport stands.
    pub scaling: Arc<[f32]>,
}

/// Division ends once direct light is expected to be off by this share of itself, RMS.
const ERROR: f64 = 0.005;
/// Elements at most, besides the triangles of the mesh.
const MOST: usize = 24_000;
/// Where faces are a great many, so are the shadows that they throw.
const MOST_AMONG_MANY: usize = 60_000;

impl ElementLight {
    /// Divides the patches of a scene by its direct light.
    pub(super) fn compute(
        prepared: &Prepared,
        system: &System,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let Prepared { scene, mesh, plan, .. } = prepared;
        let light = DirectLight::new(mesh, plan.is_on(Effect::Visibility));
        let bases = light.emitters().bases.clone();
        let exitance = |basis: &Basis| {
            let full = scene.luminaires[basis.lamp as usize].initial.exitance;
            luminance_weighted(std::array::from_fn(|band| full[band] * basis.weight[band]))
        };
        let settings = ElementSettings {
            error: ERROR,
            most: if mesh.clusters.is_empty() { MOST } else { MOST_AMONG_MANY },
            exitance: bases.iter().map(exitance).collect(),
            smooth: plan.is_on(Effect::SmoothSurfaces),
        };
        let elements = Elements::build(mesh, &light, &settings, watch)?;
        Ok(Self::new(elements, light, mesh, system))
    }

    /// The same once the transport stands: where elements are too coarse to be trusted, or lie under something, patches
    /// have the direct light that the transport carries, and what each lamp sends to other surfaces arrives there as a whole.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn settled(
        self,
        mesh: &PatchMesh,
        transport: &dyn Transport,
        system: &System,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        let means = means(&self.elements, &self.bases, mesh, (system.lamps, system.bands));
        let carried = direct_bases(transport, system, cancelled)?;
        let columns = system.columns();
        let trust = self.elements.trust_in_patches(system.patches());
        let mut values = Vec::with_capacity(carried.values.len());
        let (mut sent, mut arriving) = (vec![0.0_f64; columns], vec![0.0_f64; columns]);
        for (i, &trust) in trust.iter().enumerate() {
            let row_sum = transport.row_sum(i);
            let share = if transport.sees(i) { trust * transport.quality(i).open } else { 0.0 };
            for column in 0..columns {
                let at = i * columns + column;
                let (own, carried) = (means.values[at], carried.values[at]);
                let value = carried + share * (own - carried);
                values.push(value);
                sent[column] += system.areas[i] * row_sum * system.exitance(i, column);
                arriving[column] += system.areas[i] * f64::from(value);
            }
        }
        let scaling: Arc<[f32]> = sent
            .iter()
            .zip(&arriving)
            .map(|(sent, arriving)| if *arriving > 0.0 { (sent / arriving) as f32 } else { 1.0 })
            .collect();
        if columns > 0 {
            for own in values.chunks_exact_mut(columns) {
                own.iter_mut().zip(scaling.iter()).for_each(|(value, scale)| *value *= scale);
            }
        }
        Ok(Self { of_patches: Arc::new(LightBases { values, ..carried }), scaling, ..self })
    }

    /// Elements of a mesh; the patches are taken to have the mean of what is on them.
    fn new(elements: Elements, direct: DirectLight, mesh: &PatchMesh, system: &System) -> Self {
        let bases = direct.emitters().bases.clone();
        let of_patches = means(&elements, &bases, mesh, (system.lamps, system.bands));
        Self {
            elements: Arc::new(elements),
            direct: Arc::new(direct),
            bases,
            of_patches: Arc::new(of_patches),
            scaling: vec![1.0; system.columns()].into(),
        }
    }

    /// Whether the patches have their direct light for the columns of this system.
    pub fn serves(&self, system: &System) -> bool {
        self.of_patches.values.len() == system.patches() * system.columns()
    }

    /// The light of the patches under `lighting` in two parts.
    fn detail(&self, light: &PatchLight, lighting: &Lighting, reflectance: &Arc<Vec<[f32; 3]>>) -> Detail {
        let outputs: Vec<[f32; 3]> = self
            .bases
            .iter()
            .map(|basis| {
                let output = lighting.lamps.get(basis.lamp as usize).map_or([0.0; 3], |lamp| lamp.output());
                std::array::from_fn(|band| (output[band] * basis.weight[band]) as f32)
            })
            .collect();
        let direct = (0..self.elements.corners.len() as u32)
            .map(|corner| {
                let mut sum = [0.0_f32; 3];
                for &(basis, value) in self.elements.light_at(corner) {
                    let output = outputs[basis as usize];
                    for band in 0..3 {
                        sum[band] += value * output[band];
                    }
                }
                sum
            })
            .collect();
        let of_patches = self.of_patches.sum(lighting, light.irradiance.len());
        let interreflected = light
            .irradiance
            .iter()
            .zip(&of_patches)
            .map(|(whole, direct)| std::array::from_fn(|band| (whole[band] - direct[band]).max(0.0)))
            .collect();
        Detail { direct, interreflected, of_patches, outputs, reflectance: Arc::clone(reflectance) }
    }

    /// `light` of these lamps with its detail; patches have these reflectances.
    pub fn detailed(
        &self,
        light: PatchLight,
        lighting: &Lighting,
        reflectance: &Arc<Vec<[f32; 3]>>,
    ) -> PatchLight {
        PatchLight { detail: Some(Arc::new(self.detail(&light, lighting, reflectance))), ..light }
    }
}

/// The means over the patches of the light on their elements, per luminaire and band.
fn means(
    elements: &Elements,
    bases: &[Basis],
    mesh: &PatchMesh,
    (lamps, bands): (usize, usize),
) -> LightBases {
    let means = elements.patch_means(mesh, bases.len());
    let patches = mesh.patches.len();
    let mut values = vec![0.0_f32; patches * lamps * bands];
    if !bases.is_empty() {
        for (own, means) in values.chunks_exact_mut(lamps * bands).zip(means.chunks_exact(bases.len())) {
            for (basis, &mean) in bases.iter().zip(means) {
                let grey = basis.weight.iter().sum::<f64>() / 3.0;
                for band in 0..bands {
                    let weight = if bands == 1 { grey } else { basis.weight[band] };
                    own[basis.lamp as usize * bands + band] += weight as f32 * mean;
                }
            }
        }
    }
    LightBases { patches, lamps, bands, values }
}
