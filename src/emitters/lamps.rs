//! The lamps of a scene as emitters.

use super::outdoors::SkyPart;
use super::{ConvexBody, Emitter, Face, OutdoorEmitter, PhotometricEmitter};
use crate::mesh::{NO_PATCH, PatchMesh, Side};
use crate::scene::{PhotometricSource, luminance_weighted};
use crate::visibility::THICKNESS;
use glam::DVec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Direct light that is kept by itself: it switches and dims as one, and takes one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Index into the scene's luminaires.
    pub lamp: u32,
    /// What the lamp's output counts in each band, 0 to 1.
    pub weight: [f64; 3],
}

impl Basis {
    /// What the lamp's output counts in a band of so many: 3, or 1 that stands for all.
    pub fn weight_of(&self, band: usize, bands: usize) -> f64 {
        if bands == 1 { self.weight.iter().sum::<f64>() / 3.0 } else { self.weight[band] }
    }
}

/// What an emitter adds to a basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Index into [`Emitters::bases`].
    pub basis: u32,
    /// Its exitance for a unit of the basis.
    pub factor: f64,
    /// The band by which tinted glass dims it; all bands, weighed by luminance, where glass has no tint.
    pub band: Option<u8>,
}

impl Share {
    /// What it brings of light of which glass leaves so much in each band.
    pub fn of(&self, left: [f64; 3]) -> f64 {
        let [red, green, blue] = left;
        let value = match self.band {
            Some(band) => left[usize::from(band)],
            None if red == green && green == blue => red,
            None => luminance_weighted(left),
        };
        self.factor * value
    }
}

/// An emitter and where its light is kept.
#[derive(Clone, Debug)]
pub struct Source {
    /// What it is.
    pub emitter: Arc<dyn Emitter>,
    /// One share, or one for each band.
    pub shares: Vec<Share>,
    /// The same for the same source at any hour, and among others that are left out.
    pub id: u32,
    /// The part of the sky that it belongs to: what is seen of that at one hour tells its light at all others.
    pub part: Option<u16>,
}

/// Parts of the sky and the ground are numbered from here, the sun thus, and the others from 0.
const OUTDOORS: u32 = 1 << 31;
const SUN: u32 = u32::MAX;

impl Source {
    /// Whether it is the disc of the sun.
    pub fn is_sun(&self) -> bool {
        self.id == SUN
    }

    /// The number of what is seen of a part of the sky by one of its shares: glass leaves each band something else.
    pub fn key(&self, share: usize) -> Option<u16> {
        Some(self.part? * self.shares.len() as u16 + share as u16)
    }
}

/// All that sends out light.
#[derive(Clone, Debug, Default)]
pub struct Emitters {
    /// What is kept of it; those of a lamp stand together, and lamps in their order.
    pub bases: Vec<Basis>,
    /// What sends it out.
    pub sources: Vec<Source>,
    /// Tinted glass colours it, so that each band is kept by itself.
    by_band: bool,
}

/// The faces of one lamp that send out light of one colour.
type Coloured = Vec<([f64; 3], Vec<(Vec<DVec3>, u32)>)>;

impl Emitters {
    /// The lamps of a mesh.
    pub fn new(mesh: &PatchMesh) -> Self {
        let mut lamps: BTreeMap<u32, Coloured> = BTreeMap::new();
        let mut photometric: BTreeMap<u32, (Vec<&PhotometricSource>, Vec<u32>)> = BTreeMap::new();
        for source in &mesh.photometric {
            photometric.entry(source.luminaire).or_default().0.push(source);
            lamps.entry(source.luminaire).or_default();
        }
        if let Some(outdoors) = &mesh.outdoors {
            for lamp in [outdoors.sky, outdoors.sun] {
                lamps.entry(lamp).or_default();
            }
        }
        let mut parts = mesh.convex.parts.iter().enumerate().peekable();
        for (index, region) in mesh.regions.iter().enumerate() {
            let mut own = Vec::new();
            while let Some((part, _)) = parts.next_if(|(_, part)| part.region as usize == index) {
                own.push(part);
            }
            for side in [Side::Front, Side::Back] {
                let pieces = || mesh.pieces[region.pieces.start as usize..region.pieces.end as usize].iter();
                let shining = |patch: u32| {
                    let patch = mesh.patches.get(patch as usize)?;
                    Some((patch.luminaire?, patch.emission_weight))
                };
                let Some((lamp, weight)) = pieces().find_map(|p| shining(p.patches[side as usize])) else {
                    continue;
                };
                if let Some((_, regions)) = photometric.get_mut(&lamp) {
                    regions.push(index as u32);
                    continue;
                }
                let is_whole = pieces().all(|p| p.patches[side as usize] != NO_PATCH);
                let mut polygons: Vec<Vec<DVec3>> = if is_whole {
                    own.iter().map(|&part| mesh.convex.polygon(part).to_vec()).collect()
                } else {
                    let lit = pieces().filter(|p| p.patches[side as usize] != NO_PATCH);
                    lit.map(|p| mesh.polygon(p, Side::Front)).collect()
                };
                if side == Side::Back {
                    polygons.iter_mut().for_each(|polygon| polygon.reverse());
                }
                let colours = lamps.entry(lamp).or_default();
                let at = colours.iter().position(|known| known.0 == weight).unwrap_or_else(|| {
                    colours.push((weight, Vec::new()));
                    colours.len() - 1
                });
                colours[at].1.extend(polygons.into_iter().map(|polygon| (polygon, index as u32)));
            }
        }
        let mut all = Self { by_band: mesh.panes.is_tinted(), ..Self::default() };
        for (lamp, colours) in lamps {
            match photometric.remove(&lamp) {
                _ if mesh.is_outdoors(lamp) => all.add_outdoors(lamp, mesh),
                Some((sources, regions)) => all.add_photometric(lamp, &sources, &regions, mesh.size),
                None => all.add(lamp, colours, THICKNESS * mesh.size),
            }
        }
        let sun = mesh.outdoors.as_ref().map(|outdoors| outdoors.sun);
        let (mut parts, mut others) = (OUTDOORS, 0);
        for source in &mut all.sources {
            let lamp = source.shares.first().map(|share| all.bases[share.basis as usize].lamp);
            let next = match source.part {
                Some(_) => &mut parts,
                None if lamp.is_some() && lamp == sun => {
                    source.id = SUN;
                    continue;
                }
                None => &mut others,
            };
            source.id = std::mem::replace(next, *next + 1);
        }
        all
    }

    fn add_outdoors(&mut self, lamp: u32, mesh: &PatchMesh) {
        let Some(outdoors) = &mesh.outdoors else { return };
        let shares = self.one_or_each_band(lamp);
        if lamp == outdoors.sky {
            let parts = OutdoorEmitter::sky(outdoors, mesh.middle, mesh.size).into_iter();
            self.sources.extend(parts.map(|SkyPart { emitter, part, factor }| Source {
                emitter: Arc::new(emitter),
                shares: shares.iter().map(|share| Share { factor, ..*share }).collect(),
                id: 0,
                part: Some(part),
            }));
        } else if let Some(sun) = OutdoorEmitter::sun(outdoors, mesh.middle, mesh.size) {
            self.sources.push(Source { emitter: Arc::new(sun), shares, id: 0, part: None });
        }
    }

    /// What each part of the sky, share by share, counts at the hour: by [`Source::key`]. Empty without a sky.
    pub fn parts(&self) -> Vec<Option<Share>> {
        let mut parts: Vec<Option<Share>> = Vec::new();
        for source in &self.sources {
            for (k, share) in source.shares.iter().enumerate() {
                let Some(key) = source.key(k).map(usize::from) else { continue };
                if parts.len() <= key {
                    parts.resize(key + 1, None);
                }
                parts[key] = Some(*share);
            }
        }
        parts
    }

    /// The same bases with those of the sources alone that are `kept`.
    #[must_use]
    pub fn keeping(&self, kept: impl Fn(&Source) -> bool) -> Self {
        let sources = self.sources.iter().filter(|source| kept(source)).cloned().collect();
        Self { sources, ..self.clone() }
    }

    fn add_photometric(&mut self, lamp: u32, sources: &[&PhotometricSource], regions: &[u32], size: f64) {
        let shares = self.one_or_each_band(lamp);
        self.sources.extend(sources.iter().map(|&source| {
            let emitter = PhotometricEmitter::new(source.clone(), regions.to_vec(), THICKNESS * size, size);
            Source { emitter: Arc::new(emitter), shares: shares.clone(), id: 0, part: None }
        }));
    }

    /// Bases of a lamp of one colour: one, or one for each band.
    fn one_or_each_band(&mut self, lamp: u32) -> Vec<Share> {
        let first = self.bases.len() as u32;
        if !self.by_band {
            self.bases.push(Basis { lamp, weight: [1.0; 3] });
            return vec![Share { basis: first, factor: 1.0, band: None }];
        }
        self.bases.extend((0..3).map(|b| Basis { lamp, weight: band(b) }));
        (0..3).map(|b| Share { basis: first + b, factor: 1.0, band: Some(b as u8) }).collect()
    }

    fn add(&mut self, lamp: u32, colours: Coloured, thickness: f64) {
        let first = self.bases.len() as u32;
        let is_one = colours.len() == 1 && !self.by_band;
        match is_one {
            true => self.bases.push(Basis { lamp, weight: colours[0].0 }),
            false => self.bases.extend((0..3).map(|b| Basis { lamp, weight: band(b) })),
        }
        for (weight, faces) in colours {
            let shares: Vec<Share> = match is_one {
                true => vec![Share { basis: first, factor: 1.0, band: None }],
                false => (0..3)
                    .map(|b| Share { basis: first + b as u32, factor: weight[b], band: Some(b as u8) })
                    .filter(|share| share.factor > 0.0)
                    .collect(),
            };
            for group in joined(faces, thickness) {
                match ConvexBody::new(&group) {
                    Some(body) => {
                        let (emitter, shares) = (Arc::new(body), shares.clone());
                        self.sources.push(Source { emitter, shares, id: 0, part: None });
                    }
                    None => self.sources.extend(group.into_iter().map(|(corners, region)| Source {
                        emitter: Arc::new(Face::new(corners, region, thickness)),
                        shares: shares.clone(),
                        id: 0,
                        part: None,
                    })),
                }
            }
        }
    }
}

/// One in a band, 0 in the others.
fn band(index: u32) -> [f64; 3] {
    std::array::from_fn(|k| f64::from(u8::from(k as u32 == index)))
}

/// Faces that are joined by corners, group by group in the order of their first faces.
fn joined(faces: Vec<(Vec<DVec3>, u32)>, tolerance: f64) -> Vec<Vec<(Vec<DVec3>, u32)>> {
    let mut leader: Vec<usize> = (0..faces.len()).collect();
    fn root(leader: &mut [usize], mut k: usize) -> usize {
        while leader[k] != k {
            leader[k] = leader[leader[k]];
            k = leader[k];
        }
        k
    }
    let mut owner: HashMap<[i64; 3], usize> = HashMap::new();
    for (f, (corners, _)) in faces.iter().enumerate() {
        for corner in corners {
            let key = (*corner / (10.0 * tolerance)).round().to_array().map(|x| x as i64);
            let other = *owner.entry(key).or_insert(f);
            let (a, b) = (root(&mut leader, f), root(&mut leader, other));
            leader[a.max(b)] = a.min(b);
        }
    }
    let mut groups: BTreeMap<usize, Vec<(Vec<DVec3>, u32)>> = BTreeMap::new();
    for (f, face) in faces.into_iter().enumerate() {
        groups.entry(root(&mut leader, f)).or_default().push(face);
    }
    groups.into_values().collect()
}
