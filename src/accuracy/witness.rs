//! Gathers irradiance by rays of its own against the true polygons.

use super::audit::Answer;
use super::openings::{Openings, Shares};
use super::sobol::Sobol;
use crate::daylight::SUN_DIAMETER;
use crate::direct::{Elements, NO_ELEMENT};
use crate::geometry::{Bvh, Frame, Ray};
use crate::mesh::{NO_PATCH, PatchMesh, Piece};
use crate::scene::{Outdoors, luminance_weighted};
use crate::visibility::Glass;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The irradiance that a picture shows, W/m² per band: a value at each corner of each side of each
/// triangle of [`PatchMesh::triangles`] or of its elements, linear between them.
#[derive(Clone, Debug, Default)]
pub struct Shown {
    /// `faces[2 * triangle + side]`, zero on sides without a patch; where there are elements, one for each of them,
    /// of which the undivided ones count.
    pub faces: Vec<[[f32; 3]; 3]>,
    /// What the triangles are divided into.
    pub elements: Option<Arc<Elements>>,
}

impl Shown {
    /// Which face holds a place of a side of a triangle, and the weights of its corners there; by the weights of the
    /// triangle's corners. `side` is `2 * triangle + side`. `None` on sides without a patch.
    pub fn place(&self, side: usize, weights: [f64; 3]) -> Option<(usize, [f64; 3])> {
        place(self.elements.as_deref(), side, weights)
    }

    /// One value a patch: what a flat-shaded picture shows.
    pub fn flat(mesh: &PatchMesh, irradiance: &[[f32; 3]]) -> Self {
        let (_, pieces) = mesh.triangles();
        let value = |patch: u32| [irradiance.get(patch as usize).copied().unwrap_or_default(); 3];
        let faces = pieces.iter().flat_map(|&piece| mesh.pieces[piece as usize].patches.map(value)).collect();
        Self { faces, elements: None }
    }
}

/// Where irradiance is gathered.
#[derive(Clone, Copy, Debug)]
pub enum Receiver {
    /// At one point, with the unit normal of its facet.
    Point(DVec3, DVec3),
    /// As the mean over the whole patch.
    Whole,
}

/// What the witness gathers, as luminance of irradiance, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// From the radiosities of the patches, one value each.
    pub constant: f64,
    /// From the radiosity as the picture shows it: E + rho s.
    pub shown: f64,
    /// What of both comes from the lamps by itself.
    pub direct: f64,
}

impl Gathered {
    /// Adds what comes from a lamp by itself.
    fn add_direct(&mut self, value: f64) {
        self.constant += value;
        self.shown += value;
        self.direct += value;
    }
}

/// Where a ray ends: luminances of radiosity there, W/m²; dark where the side has no patch.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    patch: u32,
    distance: f64,
    /// Reflected, as one value a patch and as the picture shows it.
    reflected: f64,
    shown: f64,
    exitance: f64,
    /// Between the ray and the normal there.
    cosine: f64,
}

/// Casts rays against the triangles of a mesh under one lighting.
///
/// Apart from the polygons and the ray-triangle test it shares nothing with the ways in which rows
/// are computed: own points, own directions, own shadow rays, no form factor.
#[derive(Clone, Debug)]
pub struct Witness<'a> {
    mesh: &'a PatchMesh,
    bvh: Bvh,
    triangles: Vec<[DVec3; 3]>,
    pieces: Vec<u32>,
    /// For each patch where its triangles start in `patch_triangles`; one more at the end.
    starts: Vec<u32>,
    /// Triangles of each patch with their running share of its area.
    patch_triangles: Vec<(u32, f64)>,
    /// Luminance of exitance and of reflected radiosity of each patch.
    exitance: Vec<f64>,
    reflected: Vec<f64>,
    /// Luminance of irradiance and of reflected radiosity as shown, a face and corner each.
    shown: Vec<[f32; 3]>,
    shown_reflected: Vec<[f32; 3]>,
    /// Luminance of what each face passes on to its far side of what is shown there; empty where nothing passes light.
    shown_passed: Vec<[f32; 3]>,
    elements: Option<Arc<Elements>>,
    /// Unit normals at the corners of each triangle where surfaces count as curved; empty where facets are what they are.
    normals: Vec<[DVec3; 3]>,
    /// What of `shown` is direct light on elements; empty where patches carry all.
    direct: Vec<[f32; 3]>,
    /// Patches that shine, with their power.
    lamps: Vec<(u32, f64)>,
    /// What shines by photometry.
    openings: Openings,
    /// The sky and the sun, and how bright they are switched, over what they come with.
    outdoors: Option<(Arc<Outdoors>, f64, f64)>,
    offset: f64,
    /// Panes of glass, which dim by luminance here.
    glass: Glass,
}

/// Unit normals of the front at the corners of the triangles of [`PatchMesh::triangles`].
fn corner_normals(mesh: &PatchMesh) -> Vec<[DVec3; 3]> {
    let of_piece = |piece: &Piece| {
        let corners = mesh.corners_of(piece);
        (1..corners.len() - 1).map(|k| [0, k, k + 1].map(|k| corners[k].normal)).collect::<Vec<_>>()
    };
    mesh.pieces.iter().flat_map(of_piece).collect()
}

/// Luminance of what the corners of faces have.
fn luminances(faces: &[[[f32; 3]; 3]]) -> Vec<[f32; 3]> {
    faces.iter().map(|face| face.map(|h| luminance_weighted(h.map(f64::from)) as f32)).collect()
}

/// Of what the lamps are drawn by, this share heeds their power alone: none is left out.
const BY_POWER: f64 = 0.1;

/// For one patch the probability of each lamp, to be drawn from.
#[derive(Clone, Debug, Default)]
pub struct LampChoice {
    /// Probability of the lamp in [`Witness::lamps`] and the running sum.
    list: Vec<(f64, f64)>,
    openings: Shares,
}

impl<'a> Witness<'a> {
    /// Of a solved scene.
    pub fn new(answer: &Answer<'a>) -> Self {
        let Answer { mesh, light, exitance, lighting, reflectance, shown, smooth, direct, .. } = *answer;
        let (triangles, pieces) = mesh.triangles();
        let mut of_patch: Vec<Vec<(u32, f64)>> = vec![Vec::new(); mesh.patches.len()];
        for (index, (triangle, &piece)) in triangles.iter().zip(&pieces).enumerate() {
            let area = 0.5 * (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).length();
            for patch in mesh.pieces[piece as usize].patches.into_iter().filter(|&p| p != NO_PATCH) {
                let list = &mut of_patch[patch as usize];
                let before = list.last().map_or(0.0, |entry| entry.1);
                list.push((index as u32, before + area));
            }
        }
        let mut starts = vec![0];
        for list in &mut of_patch {
            let total = list.last().map_or(1.0, |entry| entry.1).max(f64::MIN_POSITIVE);
            list.iter_mut().for_each(|entry| entry.1 /= total);
            starts.push(starts[starts.len() - 1] + list.len() as u32);
        }
        let wide = |v: [f32; 3]| v.map(f64::from);
        let at = |list: &[[f32; 3]], i: usize| list.get(i).copied().map_or([0.0; 3], wide);
        let emitted = |i: usize| luminance_weighted(at(exitance, i));
        let mut shown_lum = Vec::with_capacity(shown.faces.len());
        let mut shown_reflected = Vec::with_capacity(shown.faces.len());
        let mut shown_passed = Vec::new();
        for (index, face) in shown.faces.iter().enumerate() {
            let patch = match &shown.elements {
                Some(elements) => elements.elements[index].patch,
                None => mesh.pieces[pieces[index / 2] as usize].patches[index % 2],
            };
            let rho = if patch == NO_PATCH { [0.0; 3] } else { at(reflectance, patch as usize) };
            shown_lum.push(face.map(|h| luminance_weighted(wide(h)) as f32));
            shown_reflected.push(face.map(|h| {
                let h = wide(h);
                luminance_weighted(std::array::from_fn(|b| rho[b] * h[b])) as f32
            }));
            if !mesh.translucence.is_empty() {
                let tau = mesh.translucence.at(patch as usize).map_or([0.0; 3], |passing| passing.share);
                shown_passed.push(face.map(|h| {
                    let h = wide(h);
                    luminance_weighted(std::array::from_fn(|b| tau[b] * h[b])) as f32
                }));
            }
        }
        let n = mesh.patches.len();
        // What glows for the picture alone lights nothing.
        let is_photometric =
            |i: usize| mesh.patches[i].luminaire.is_some_and(|lamp| mesh.is_photometric(lamp));
        let sent = |i: usize| if is_photometric(i) { 0.0 } else { emitted(i) };
        let of_lamp = |lamp: u32| {
            lighting.lamps.get(lamp as usize).map_or(0.0, |state| luminance_weighted(state.output()))
        };
        Self {
            mesh,
            bvh: Bvh::build(&triangles),
            triangles,
            pieces,
            starts,
            patch_triangles: of_patch.concat(),
            exitance: (0..n).map(sent).collect(),
            reflected: (0..n).map(|i| luminance_weighted(at(&light.radiosity, i)) - emitted(i)).collect(),
            shown: shown_lum,
            shown_reflected,
            shown_passed,
            elements: shown.elements.clone(),
            normals: if smooth { corner_normals(mesh) } else { Vec::new() },
            direct: direct.map_or_else(Vec::new, |direct| luminances(&direct.faces)),
            lamps: (0..n)
                .filter(|&i| sent(i) > 0.0)
                .map(|i| (i as u32, sent(i) * mesh.patches[i].area))
                .collect(),
            openings: Openings::new(&mesh.photometric, of_lamp),
            outdoors: mesh.outdoors.as_ref().map(|outdoors| {
                let over = |lamp: u32, unit: f64| if unit > 0.0 { of_lamp(lamp) / unit } else { 0.0 };
                let of_sky = over(outdoors.sky, outdoors.sky_exitance());
                (Arc::clone(outdoors), of_sky, over(outdoors.sun, outdoors.sun_exitance()))
            }),
            offset: 1e-7 * mesh.size,
            glass: Glass::new(mesh),
        }
    }

    /// Draws a point of a patch for two numbers in 0..1: place, unit normal (that of a curved surface where it counts as
    /// one), and what the picture shows there
    /// (luminance of irradiance, W/m²).
    pub fn point_on(&self, patch: u32, r: f64, s: f64) -> (DVec3, DVec3, f64) {
        let Some((triangle, [a, b, c])) = self.place_on(patch, r, s) else {
            let patch = &self.mesh.patches[patch as usize];
            return (patch.centre, patch.normal, 0.0);
        };
        let [p, q, t] = self.triangles[triangle as usize];
        let side = self.mesh.patches[patch as usize].side;
        let piece = &self.mesh.pieces[self.pieces[triangle as usize] as usize];
        let shown = self.interpolated(&self.shown, 2 * triangle as usize + side as usize, [a, b, c]);
        let facet = self.mesh.normal_of(piece, side);
        let normal = self
            .normals
            .get(triangle as usize)
            .map_or(facet, |[m, n, o]| ((*m * a + *n * b + *o * c) * side.sign()).normalize_or(facet));
        (p * a + q * b + t * c, normal, shown)
    }

    /// What of the irradiance shown at the point of [`Witness::point_on`] is direct light on elements, W/m² of luminance;
    /// `None` where patches carry all.
    pub fn direct_on(&self, patch: u32, r: f64, s: f64) -> Option<f64> {
        let (triangle, weights) = self.place_on(patch, r, s).filter(|_| !self.direct.is_empty())?;
        let side = 2 * triangle as usize + self.mesh.patches[patch as usize].side as usize;
        Some(self.interpolated(&self.direct, side, weights))
    }

    /// Least and greatest irradiance that the picture shows on a patch, W/m² of luminance.
    pub fn shown_range(&self, patch: u32) -> [f64; 2] {
        let side = self.mesh.patches[patch as usize].side as usize;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for &(t, _) in self.triangles_of(patch) {
            self.faces_of(2 * t as usize + side, |face, _| {
                for x in self.shown[face].map(f64::from) {
                    range = [range[0].min(x), range[1].max(x)];
                }
            });
        }
        range
    }

    /// Mean irradiance that the picture shows over a patch, W/m² of luminance; zero without triangles.
    pub fn shown_mean(&self, patch: u32) -> f64 {
        self.shown_mean_of(&self.shown, patch)
    }

    /// The mean of corner values over a patch.
    fn shown_mean_of(&self, values: &[[f32; 3]], patch: u32) -> f64 {
        let side = self.mesh.patches[patch as usize].side as usize;
        let mut before = 0.0;
        let mut sum = 0.0;
        for &(t, share) in self.triangles_of(patch) {
            let part = share - std::mem::replace(&mut before, share);
            self.faces_of(2 * t as usize + side, |face, own| {
                sum += part * own * values[face].iter().map(|&h| f64::from(h)).sum::<f64>() / 3.0;
            });
        }
        sum
    }

    /// Calls `found` with each face of a side of a triangle, and what share of it that is.
    fn faces_of(&self, side: usize, mut found: impl FnMut(usize, f64)) {
        let Some(elements) = &self.elements else { return found(side, 1.0) };
        let Some(&root) = elements.roots.get(side).filter(|&&root| root != NO_ELEMENT) else { return };
        let whole = elements.area(&elements.elements[root as usize]).max(f64::MIN_POSITIVE);
        elements.leaves_of(root, |leaf| {
            found(leaf as usize, elements.area(&elements.elements[leaf as usize]) / whole);
        });
    }

    /// What corner values come to at a place of a side of a triangle, by the weights of its corners.
    fn interpolated(&self, values: &[[f32; 3]], side: usize, weights: [f64; 3]) -> f64 {
        let Some((face, weights)) = place(self.elements.as_deref(), side, weights) else { return 0.0 };
        let corners = values.get(face).copied().unwrap_or_default();
        corners.iter().zip(weights).map(|(&value, weight)| f64::from(value) * weight).sum()
    }

    /// Whether the side of a triangle that a ray in this direction meets can be seen.
    fn is_shown(&self, triangle: u32, direction: DVec3) -> bool {
        let piece = &self.mesh.pieces[self.pieces[triangle as usize] as usize];
        let region = &self.mesh.regions[piece.region as usize];
        // What has holes stands among the panes.
        !(region.has_holes || piece.backed && region.frame.normal.dot(direction) > 0.0)
    }

    fn triangles_of(&self, patch: u32) -> &[(u32, f64)] {
        let p = patch as usize;
        &self.patch_triangles[self.starts[p] as usize..self.starts[p + 1] as usize]
    }

    /// A triangle of a patch and weights of its corners, uniform over the area.
    fn place_on(&self, patch: u32, r: f64, s: f64) -> Option<(u32, [f64; 3])> {
        let list = self.triangles_of(patch);
        let at = list.partition_point(|entry| entry.1 <= r).min(list.len().checked_sub(1)?);
        let before = if at > 0 { list[at - 1].1 } else { 0.0 };
        let r = ((r - before) / (list[at].1 - before).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let root = r.sqrt();
        Some((list[at].0, [1.0 - root, root * (1.0 - s), root * s]))
    }

    /// How likely each lamp is to be looked at from a patch: by what it would give unhindered.
    pub fn lamp_choice(&self, patch: u32) -> LampChoice {
        let receiver = &self.mesh.patches[patch as usize];
        self.lamp_choice_at(receiver.centre, receiver.normal, receiver.radius)
    }

    /// As [`Self::lamp_choice`], from anywhere within `radius` of a point with a unit normal, metres.
    pub fn lamp_choice_at(&self, centre: DVec3, normal: DVec3, radius: f64) -> LampChoice {
        let share = |&(lamp, power): &(u32, f64)| {
            let lamp = &self.mesh.patches[lamp as usize];
            let way = lamp.centre - centre;
            let reach = radius + lamp.radius;
            let distance2 = way.length_squared().max(reach * reach).max(f64::MIN_POSITIVE);
            let slack = reach / distance2.sqrt();
            let way = way / distance2.sqrt();
            power * (normal.dot(way) + slack).max(0.0) * (slack - lamp.normal.dot(way)).max(0.0) / distance2
        };
        let shares: Vec<f64> = self.lamps.iter().map(share).collect();
        let all = shares.iter().sum::<f64>();
        let power = self.lamps.iter().map(|l| l.1).sum::<f64>().max(f64::MIN_POSITIVE);
        let by_power = if all > 0.0 { BY_POWER } else { 1.0 };
        let mut sum = 0.0;
        let list = shares
            .iter()
            .zip(&self.lamps)
            .map(|(share, lamp)| {
                let p = by_power * lamp.1 / power + (1.0 - by_power) * share / all.max(f64::MIN_POSITIVE);
                sum += p;
                (p, sum)
            })
            .collect();
        LampChoice { list, openings: self.openings.shares(centre, normal, radius) }
    }

    /// Luminance of the irradiance on `patch`, gathered by `rays` rays along the cosine and a quarter
    /// as many towards the lamps; `seed` names the randomisation.
    pub fn gather(
        &self,
        patch: u32,
        receiver: Receiver,
        choice: &LampChoice,
        rays: u32,
        seed: u64,
    ) -> Gathered {
        match receiver {
            Receiver::Point(point, normal) => self.gather_at(point, normal, choice, rays, seed),
            Receiver::Whole => {
                let start = |u: [f64; 4]| {
                    let (point, normal, _) = self.point_on(patch, u[2], u[3]);
                    (point, normal)
                };
                self.gather_from(start, choice, rays, seed)
            }
        }
    }

    /// As [`Self::gather`], at a point with a unit normal; metres.
    pub fn gather_at(
        &self,
        point: DVec3,
        normal: DVec3,
        choice: &LampChoice,
        rays: u32,
        seed: u64,
    ) -> Gathered {
        self.gather_from(|_| (point, normal), choice, rays, seed)
    }

    /// Each ray starts where `start` says for its four numbers in 0..1, above the surface with that unit normal.
    fn gather_from(
        &self,
        start: impl Fn([f64; 4]) -> (DVec3, DVec3),
        choice: &LampChoice,
        rays: u32,
        seed: u64,
    ) -> Gathered {
        let to_lamps = if self.lamps.is_empty() { 0 } else { (rays / 4).max(16) };
        let density = |lamp: u32, g: f64| {
            // Both ways of sampling share what a lamp gives, in proportion to their densities.
            let area = self.mesh.patches[lamp as usize].area;
            let at = self.lamps.binary_search_by_key(&lamp, |l| l.0).map_or(0.0, |k| choice.list[k].0);
            f64::from(rays) * g + f64::from(to_lamps) * at / area
        };
        let mut found = Gathered::default();

        // 1. Along the cosine.
        let sequence = Sobol::new(seed);
        let each = 1.0 / f64::from(rays.max(1));
        for k in 0..rays {
            let u = sequence.point(k);
            let (origin, normal) = start(u);
            let frame = Frame::around(normal);
            let (radius, phi) = (u[0].sqrt(), TAU * u[1]);
            let cosine = (1.0 - u[0]).sqrt();
            let direction = frame.world(DVec3::new(radius * phi.cos(), radius * phi.sin(), cosine));
            let ray = Ray { origin, direction };
            let distance = match self.meet(&ray) {
                None => {
                    let passed = self.glass.luminous(origin, direction, [self.offset, f64::INFINITY]);
                    found.add_direct(each * passed * self.sky_towards(direction));
                    f64::INFINITY
                }
                Some(met) => {
                    let passed =
                        self.glass.luminous(origin, direction, [self.offset, met.distance - self.offset]);
                    found.constant += each * passed * met.reflected;
                    found.shown += each * passed * met.shown;
                    if met.exitance > 0.0 {
                        let g = cosine * met.cosine / (PI * met.distance * met.distance);
                        found.add_direct(passed * met.exitance * g / density(met.patch, g));
                    }
                    met.distance
                }
            };
            let range = [self.offset, distance - self.offset];
            self.glass.each_perforated(origin, direction, range, |patch, share| {
                found.constant += each * share * self.reflected[patch as usize];
                found.shown += each * share * self.reflected[patch as usize];
            });
            // What panes mirror on the way, looked for by this way of sampling alone.
            self.glass.each_mirror(origin, direction, [self.offset, distance], |from, mirrored, share| {
                let share = each * share;
                let met = self.meet(&Ray { origin: from, direction: mirrored });
                let end = met.as_ref().map_or(f64::INFINITY, |met| met.distance - self.offset);
                let share = share * self.glass.luminous(from, mirrored, [self.offset, end]);
                match met {
                    None => found.add_direct(share * self.sky_towards(mirrored)),
                    Some(met) => {
                        found.constant += share * met.reflected;
                        found.shown += share * met.shown;
                        found.add_direct(share * met.exitance);
                    }
                }
            });
        }

        // 2. Towards the lamps.
        let sequence = Sobol::new(seed ^ 0x5851_F42D_4C95_7F2D);
        for k in 0..to_lamps {
            let u = sequence.point(k);
            let (origin, normal) = start(u);
            let at = choice.list.partition_point(|l| l.1 <= u[0]).min(choice.list.len() - 1);
            let (share, end) = choice.list[at];
            let r = ((u[0] - (end - share)) / share).clamp(0.0, 1.0 - 1e-12);
            let lamp = self.lamps[at].0;
            let (target, ..) = self.point_on(lamp, r, u[1]);
            let way = target - origin;
            let distance2 = way.length_squared();
            let cosines =
                normal.dot(way).max(0.0) * -self.mesh.patches[lamp as usize].normal.dot(way).min(0.0);
            if cosines <= 0.0 || distance2 <= 4.0 * self.offset * self.offset {
                continue;
            }
            let distance = distance2.sqrt();
            let ray = Ray { origin, direction: way / distance };
            let is_shown = |triangle: u32| self.is_shown(triangle, ray.direction);
            if self.bvh.occluded_where(&ray, self.offset, distance - self.offset, is_shown) {
                continue;
            }
            let g = cosines / (PI * distance2 * distance2);
            let passed = self.glass.between(origin, target, self.offset);
            let direct = passed * self.exitance[lamp as usize] * g / density(lamp, g);
            found.add_direct(direct);
        }

        // 3. Towards the disc of the sun, each ray to a point of its own.
        if let Some((outdoors, _, sun)) = self.outdoors.as_ref().filter(|outdoors| outdoors.2 > 0.0) {
            let sequence = Sobol::new(seed ^ 0x9E6C_63D0_876A_3F35);
            let to_sun = (rays / 4).max(16);
            let disc = Frame::around(outdoors.to_sun());
            let radius = (0.5 * SUN_DIAMETER).to_radians().tan();
            let mut direct = 0.0;
            for k in 0..to_sun {
                let u = sequence.point(k);
                let (origin, normal) = start(u);
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let out = radius * u[0].sqrt();
                let direction = disc.world(DVec3::new(out * cos, out * sin, 1.0)).normalize();
                let cosine = normal.dot(direction);
                let is_shown = |triangle: u32| self.is_shown(triangle, direction);
                if cosine > 0.0
                    && !self.bvh.occluded_where(
                        &Ray { origin, direction },
                        self.offset,
                        f64::INFINITY,
                        is_shown,
                    )
                {
                    let passed = self.glass.luminous(origin, direction, [self.offset, f64::INFINITY]);
                    direct += passed * sun * outdoors.sun_exitance() * cosine / f64::from(to_sun);
                }
            }
            found.add_direct(direct);
        }

        // 4. Towards what shines by photometry.
        if !self.openings.is_empty() {
            let passes = |lamp: u32, origin: DVec3, direction: DVec3, end: f64| {
                let stands =
                    |triangle: u32| self.is_shown(triangle, direction) && !self.is_of(triangle, lamp);
                match self.bvh.occluded_where(&Ray { origin, direction }, self.offset, end, stands) {
                    true => 0.0,
                    false => self.glass.luminous(origin, direction, [self.offset, end]),
                }
            };
            let (samples, seed) = ((rays / 4).max(16), seed ^ 0x2545_F491_4F6C_DD1D);
            let direct = self.openings.gather(start, &choice.openings, samples, seed, passes);
            found.add_direct(direct);
        }
        found
    }

    /// What a ray meets; `None` where it escapes.
    fn meet(&self, ray: &Ray) -> Option<Met> {
        let is_shown = |triangle: u32| self.is_shown(triangle, ray.direction);
        let hit = self.bvh.nearest_where(ray, self.offset, f64::INFINITY, is_shown)?;
        let piece = &self.mesh.pieces[self.pieces[hit.triangle as usize] as usize];
        let front = self.mesh.regions[piece.region as usize].frame.normal;
        let back = usize::from(front.dot(ray.direction) > 0.0);
        let patch = piece.patches[back];
        let met = Met { patch, distance: hit.distance, ..Met::default() };
        if patch == NO_PATCH {
            return Some(met);
        }
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        Some(Met {
            reflected: self.reflected[patch as usize],
            shown: self.interpolated(&self.shown_reflected, 2 * hit.triangle as usize + back, weights)
                + self.passed(hit.triangle, back, weights),
            exitance: self.exitance[patch as usize],
            cosine: front.dot(ray.direction).abs(),
            ..met
        })
    }

    /// What a place of a side of a triangle sends out of what is shown on its far side.
    fn passed(&self, triangle: u32, side: usize, weights: [f64; 3]) -> f64 {
        let patches = self.mesh.pieces[self.pieces[triangle as usize] as usize].patches;
        let Some(passing) = self.mesh.translucence.at(patches[side] as usize) else { return 0.0 };
        if patches[1 - side] != NO_PATCH {
            return self.interpolated(&self.shown_passed, 2 * triangle as usize + 1 - side, weights);
        }
        let of = |&(far, share): &(u32, f64)| share * self.shown_mean_of(&self.shown_passed, far);
        passing.behind.iter().map(of).sum()
    }

    /// Pi times the luminance of the radiance of sky or ground in a direction.
    fn sky_towards(&self, direction: DVec3) -> f64 {
        self.outdoors.as_ref().map_or(0.0, |(outdoors, sky, _)| PI * sky * outdoors.radiance(direction))
    }

    /// Whether a triangle is a surface of a lamp.
    fn is_of(&self, triangle: u32, lamp: u32) -> bool {
        let piece = &self.mesh.pieces[self.pieces[triangle as usize] as usize];
        let of =
            |&patch: &u32| patch != NO_PATCH && self.mesh.patches[patch as usize].luminaire == Some(lamp);
        piece.patches.iter().any(of)
    }
}

fn place(elements: Option<&Elements>, side: usize, weights: [f64; 3]) -> Option<(usize, [f64; 3])> {
    let Some(elements) = elements else { return Some((side, weights)) };
    elements.place(side, weights).map(|(leaf, weights)| (leaf as usize, weights))
}
