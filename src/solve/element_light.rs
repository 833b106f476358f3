use super::pipeline::{DirectTarget, Prepared};
use super::uneven::UnevenLight;
use crate::direct::{DirectLight, ElementSettings, Elements, Focus, Layout};
use crate::effects::Effect;
use crate::emitters::Basis;
use crate::mesh::PatchMesh;
use crate::scene::{Lighting, Scene, luminance_weighted};
use crate::solver::{Detail, LightBases, PatchLight, System, direct_bases};
use crate::transport::{LANES, Lanes, Transport};
use crate::watch::{Cancelled, Watch};
use std::sync::Arc;

/// The direct light of a scene on elements, for every state of the lamps.
#[derive(Clone, Debug)]
pub struct ElementLight {
    /// How finely it was laid out.
    pub target: DirectTarget,
    /// What it is lit from at other hours.
    pub layout: Arc<Layout>,
    /// Whether it was laid out under the sky that it is lit by.
    pub is_of_hour: bool,
    /// Whether the sun was looked for by a few rays alone, so far.
    pub is_glimpsed: bool,
    /// Whether the patches have what the transport makes of it.
    pub is_settled: bool,
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
    /// What of each luminaire and band arrives at all patches, W for a unit of its exitance, m².
    pub arriving: Arc<[f64]>,
    /// Luminaires that are the sky and the sun.
    pub outdoors: Vec<u32>,
    /// What it brings to near patches since it does not leave patches evenly; nothing until the transport stands.
    pub uneven: Arc<UnevenLight>,
    /// What arrives at the patches besides what passes between them evenly, per luminaire: their direct light and what
    /// [`Self::uneven`] comes to with the present reflectances.
    pub given: Arc<LightBases>,
}

impl ElementLight {
    /// Divides the patches of a scene by its direct light, most finely where somebody looks.
    pub(super) fn compute(
        prepared: &Prepared,
        target: DirectTarget,
        focus: Option<Focus>,
        system: &System,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let Prepared { mesh, plan, .. } = prepared;
        let light = DirectLight::new(mesh, plan.is_on(Effect::Visibility))
            .with_mirrors(&mut watch.part(0.0, 0.02))?;
        let settings = settings(prepared, target, focus, &light);
        let layout = Layout::build(mesh, &light, &settings, &mut watch.part(0.02, 0.85))?;
        let elements = layout.lit(mesh, &light, &settings, &mut watch.part(0.85, 1.0))?;
        Ok(Self::new(target, (layout, elements), light, mesh, system))
    }

    /// The same under the sky of another hour, that of `prepared`: lamps stay, and so does all that was laid out for
    /// them and for the sky.
    ///
    /// Patches take it over at once; what leaves near patches unevenly of it is known once it is [settled](Self::settled).
    /// `at_once` the edges of the sun's shadows are not looked for.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn at_hour(
        &self,
        prepared: &Prepared,
        system: &System,
        at_once: bool,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let mesh = &prepared.mesh;
        let light = self.direct.at_hour_of(mesh);
        let elements = match at_once {
            true => self.layout.glimpsed(mesh, &light, watch)?,
            false => {
                let settings = settings(prepared, self.target, None, &light);
                self.layout.lit(mesh, &light, &settings, watch)?
            }
        };
        let columns = system.columns();
        let means = means(&elements, &self.bases, mesh, (system.lamps, system.bands));
        let mut of_patches = LightBases::clone(&self.of_patches);
        let mut given = LightBases::clone(&self.given);
        let mut arriving = self.arriving.to_vec();
        for column in (0..columns).filter(|&column| system.is_outdoors(column)) {
            let mut sum = 0.0;
            for i in 0..system.patches() {
                let (at, value) = (i * columns + column, means.values[i * columns + column]);
                (of_patches.values[at], given.values[at]) = (value, value);
                sum += system.areas[i] * f64::from(value);
            }
            arriving[column] = sum;
        }
        let is_outdoors = |basis: u32| self.outdoors.contains(&self.bases[basis as usize].lamp);
        Ok(Self {
            elements: Arc::new(elements),
            direct: Arc::new(light),
            is_of_hour: false,
            is_glimpsed: at_once,
            is_settled: false,
            of_patches: Arc::new(of_patches),
            given: Arc::new(given),
            arriving: arriving.into(),
            uneven: Arc::new(self.uneven.without(is_outdoors)),
            ..self.clone()
        })
    }

    /// The light of patches at this hour, about, by that of the hour before: what surfaces pass on goes with what arrives.
    pub fn guess(&self, before: &Self, light: &LightBases) -> LightBases {
        let columns = light.lamps * light.bands;
        let fits = |other: &LightBases| other.values.len() == light.values.len();
        if columns == 0 || !fits(&self.given) || !fits(&before.given) {
            return light.clone();
        }
        let ratio = |column: usize| {
            let [now, then] = [self, before].map(|light| light.arriving.get(column).copied().unwrap_or(0.0));
            if then > 0.0 { (now / then) as f32 } else { 0.0 }
        };
        let is_outdoors = |column: &usize| self.outdoors.contains(&((column / light.bands) as u32));
        let mut guess = light.clone();
        for column in (0..columns).filter(is_outdoors) {
            let ratio = ratio(column);
            for at in (column..light.values.len()).step_by(columns) {
                let passed_on = (light.values[at] - before.given.values[at]).max(0.0);
                guess.values[at] = self.given.values[at] + ratio * passed_on;
            }
        }
        guess
    }

    /// The same once the transport stands: where patches lie under something they
    /// have the direct light that the transport carries, and what each lamp sends to other surfaces arrives there as a whole.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn settled(
        self,
        prepared: &Prepared,
        transport: &dyn Transport,
        system: &System,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        let Prepared { mesh, scene, computer, .. } = prepared;
        let means = means(&self.elements, &self.bases, mesh, (system.lamps, system.bands));
        let carried = direct_bases(transport, system, cancelled)?;
        let columns = system.columns();
        let mut values = Vec::with_capacity(carried.values.len());
        let (mut sent, mut arriving) = (vec![0.0_f64; columns], vec![0.0_f64; columns]);
        let mut escaping = 0.0;
        for i in 0..system.patches() {
            let row_sum = transport.row_sum(i);
            if transport.sees(i) {
                escaping += system.areas[i] * (1.0 - row_sum).max(0.0);
            }
            let share = if transport.sees(i) { transport.quality(i).open } else { 0.0 };
            for column in 0..columns {
                let at = i * columns + column;
                let (own, carried) = (means.values[at], carried.values[at]);
                // What no patch sends out is carried by none.
                let is_sent = !system.is_outdoors(column) && system.photometric_area(column) <= 0.0;
                let value = if is_sent { carried + share * (own - carried) } else { own };
                values.push(value);
                sent[column] += system.areas[i] * row_sum * system.exitance(i, column);
                arriving[column] += system.areas[i] * f64::from(value);
            }
        }
        // What shines by photometry is known to arrive where nothing escapes, but for what its own housing swallows.
        let is_sealed = escaping <= SEALED * system.areas.iter().sum::<f64>();
        let scale = |(column, (&sent, &arriving)): (usize, (&f64, &f64))| {
            let area = system.photometric_area(column);
            if arriving <= 0.0 || system.is_outdoors(column) {
                1.0
            } else if area <= 0.0 {
                (sent / arriving) as f32
            } else if is_sealed && (arriving / area - 1.0).abs() < NEARLY_ALL {
                (area / arriving) as f32
            } else {
                1.0
            }
        };
        let scaling: Arc<[f32]> = sent.iter().zip(&arriving).enumerate().map(scale).collect();
        if columns > 0 {
            for own in values.chunks_exact_mut(columns) {
                own.iter_mut().zip(scaling.iter()).for_each(|(value, scale)| *value *= scale);
            }
        }
        let exitance = exitances(scene, &self.bases);
        let mut nobody = |_| {};
        let mut watch = Watch::new(cancelled, &mut nobody);
        let uneven = UnevenLight::find(computer, transport, &self.elements, &exitance, &mut watch)?;
        let of_patches = Arc::new(LightBases { values, ..carried });
        let arriving = arriving.iter().zip(&*scaling).map(|(sum, &scale)| sum * f64::from(scale)).collect();
        Self { of_patches, scaling, arriving, uneven: Arc::new(uneven), is_settled: true, ..self }
            .with_reflectance(transport, system, cancelled)
    }

    /// The same with the reflectances of this system: what leaves near patches unevenly goes with them.
    ///
    /// Each lamp's first reflection is scaled to what it is when it leaves patches evenly, so that no power is lost.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn with_reflectance(
        self,
        transport: &dyn Transport,
        system: &System,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        if self.uneven.entries() == 0 {
            return Ok(Self { given: Arc::clone(&self.of_patches), ..self });
        }
        let columns = system.columns();
        let shift = self.uneven.arriving(&self.bases, system);
        let mut given = LightBases::clone(&self.of_patches);
        let mut even = vec![[0.0; LANES]; system.patches()];
        for first in (0..columns).step_by(LANES) {
            let sent: Vec<Lanes> = (0..system.patches())
                .map(|i| {
                    std::array::from_fn(|lane| match first + lane {
                        column if column < columns => {
                            let light = &self.of_patches.values;
                            system.leaving(i, column, |j| f64::from(light[j * columns + column]))
                        }
                        _ => 0.0,
                    })
                })
                .collect();
            transport.gather(0..system.patches(), &sent, &mut even, cancelled);
            if cancelled() {
                return Err(Cancelled);
            }
            for column in first..(first + LANES).min(columns) {
                let (mut evenly, mut shifted) = (0.0, 0.0);
                for (i, even) in even.iter().enumerate() {
                    evenly += system.areas[i] * even[column - first];
                    shifted += system.areas[i] * shift[i * columns + column];
                }
                let scale = if evenly + shifted > 0.0 { evenly / (evenly + shifted) } else { 1.0 };
                for (i, even) in even.iter().enumerate() {
                    let even = even[column - first];
                    given.values[i * columns + column] +=
                        (scale * (even + shift[i * columns + column]) - even) as f32;
                }
            }
        }
        Ok(Self { given: Arc::new(given), ..self })
    }

    /// Within what distance receivers tell parts of each patch apart, metres.
    pub(super) fn reach(&self, prepared: &Prepared) -> Vec<f32> {
        UnevenLight::reach(&prepared.mesh, &self.elements, &exitances(&prepared.scene, &self.bases))
    }

    /// Elements of a mesh; the patches are taken to have the mean of what is on them.
    fn new(
        target: DirectTarget,
        (layout, elements): (Layout, Elements),
        direct: DirectLight,
        mesh: &PatchMesh,
        system: &System,
    ) -> Self {
        let bases = direct.emitters().bases.clone();
        let of_patches = Arc::new(means(&elements, &bases, mesh, (system.lamps, system.bands)));
        Self {
            target,
            layout: Arc::new(layout),
            is_of_hour: true,
            is_glimpsed: false,
            is_settled: false,
            elements: Arc::new(elements),
            direct: Arc::new(direct),
            bases,
            given: Arc::clone(&of_patches),
            scaling: vec![1.0; system.columns()].into(),
            arriving: arriving(&of_patches, system).into(),
            of_patches,
            outdoors: (0..system.lamps as u32).filter(|&lamp| mesh.is_outdoors(lamp)).collect(),
            uneven: Arc::default(),
        }
    }

    /// All light of the patches, by what surfaces pass on.
    pub(crate) fn with_passed_on(&self, mut passed_on: LightBases) -> LightBases {
        let given = self.given.values.iter();
        passed_on.values.iter_mut().zip(given).for_each(|(value, given)| *value += given);
        passed_on
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
        let given = self.given.sum(lighting, light.irradiance.len());
        let bands = self.of_patches.bands.max(1);
        let arriving = |lamp: u32| -> f64 {
            let output = lighting.lamps.get(lamp as usize).map_or([0.0; 3], |lamp| lamp.output());
            let at = |band: usize| lamp as usize * bands + band.min(bands - 1);
            (0..3).map(|band| output[band] * self.arriving.get(at(band)).copied().unwrap_or(0.0)).sum()
        };
        let outdoors = self.outdoors.iter().map(|&lamp| arriving(lamp)).sum();
        let reflectance = Arc::clone(reflectance);
        Detail { direct, interreflected, of_patches, given, outputs, reflectance, outdoors }
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

/// A scene is sealed where a smaller part of what leaves its patches escapes.
const SEALED: f64 = 1e-4;
/// Where so much of a lamp's flux or more is off, something else than the mesh is the reason.
const NEARLY_ALL: f64 = 0.02;

/// How finely direct light is laid out for a target.
fn settings(
    prepared: &Prepared,
    target: DirectTarget,
    focus: Option<Focus>,
    light: &DirectLight,
) -> ElementSettings {
    let Prepared { scene, mesh, plan, .. } = prepared;
    ElementSettings {
        error: target.error,
        most: target.most,
        work: target.work,
        exitance: exitances(scene, &light.emitters().bases),
        smooth: plan.is_on(Effect::SmoothSurfaces),
        focus,
        adapted: mesh.outdoors.is_some(),
    }
}

/// What counts of each basis: luminance of its exitance at full output, W/m².
fn exitances(scene: &Scene, bases: &[Basis]) -> Vec<f64> {
    let of = |basis: &Basis| {
        let full = scene.luminaires[basis.lamp as usize].initial.exitance;
        luminance_weighted(std::array::from_fn(|band| full[band] * basis.weight[band]))
    };
    bases.iter().map(of).collect()
}

/// What of each column arrives at all patches, m².
fn arriving(light: &LightBases, system: &System) -> Vec<f64> {
    let columns = system.columns();
    let of = |column: usize| {
        let at = light.values.iter().skip(column).step_by(columns);
        at.zip(&system.areas).map(|(&value, area)| area * f64::from(value)).sum()
    };
    (0..columns).map(of).collect()
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
                for band in 0..bands {
                    own[basis.lamp as usize * bands + band] += basis.weight_of(band, bands) as f32 * mean;
                }
            }
        }
    }
    LightBases { patches, lamps, bands, values }
}
