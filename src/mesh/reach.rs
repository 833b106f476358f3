//! Which sides of which regions light can reach: the outside of a closed shell needs no patches.
//!
//! A side is lit if a diffuse path that starts on it comes to a point from which a lamp is seen, or if
//! light from a lamp comes to it over many bounces: through several rooms with small doors no short
//! path leads back. Paths run through free space only, so that the inside of a box that stands on a lit
//! floor stays dark although it touches the floor.

use super::backing::{Backing, Sheets};
use super::regions::Outline;
use super::shells::{Shells, neighbours};
use super::sources::{OFFSET, Sources};
use super::types::{Patch, Side};
use crate::geometry::{Frame, Ray, polygon};
use crate::scene::{Scene, Sides};
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Paths from each side.
const PATHS: u64 = 32;
/// Paths from a dark side among lit ones: what is taken for dark hides nothing from what is lit.
const PATHS_AMONG_LIT: u64 = 256;
/// Points on a path, its start included.
const BOUNCES: u64 = 4;
/// This many paths must find light: a single one may have slipped through the seam of two faces.
const ENOUGH: u32 = 2;

/// Paths from the lamps, and the points that each has at most.
const LAMP_PATHS: u64 = 2048;
const LAMP_BOUNCES: u64 = 64;
/// This many of them must meet a side: so many rays find seams and corners.
const ENOUGH_LAMP_PATHS: usize = 3;
/// Lit points remembered on each side.
const LIT_POINTS: usize = 4;

/// Lit points that a patch is held against before it counts as buried.
const NEAR_POINTS: usize = 64;

/// How light and a side stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reach {
    /// It takes part.
    Lit,
    /// Black by the material's own word; what is lit may see it.
    Black,
    /// No light reaches it, so nothing lit sees it.
    Dark,
    /// It is the back of a surface on which another one lies, and is never seen.
    Backed,
}

/// A patch whose centre no light reaches.
pub(super) enum Buried {
    /// Nor any other point of it that was tried.
    Whole,
    /// This point of it is lit.
    LitAt(DVec3),
}

/// How many paths are followed from a side before it counts as out of all light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSearch {
    /// So many that hardly any lit side is missed, and two have to find light.
    #[default]
    Full,
    /// An eighth of them, of which one has to find light: where time presses. In rooms that lamps light well
    /// few sides are missed; some that only a seam lights are taken for lit.
    Quick,
}

impl LightSearch {
    /// Paths, and how many must find light.
    fn paths(self) -> (u64, u32) {
        match self {
            Self::Full => (PATHS, ENOUGH),
            Self::Quick => (PATHS / 8, 1),
        }
    }
}

/// Finds what light can reach in a scene.
pub(super) struct Search<'a> {
    scene: &'a Scene,
    outlines: &'a [Outline],
    sheets: &'a Sheets,
    sources: &'a Sources,
}

impl Sources {
    /// For every region how its front and its back stand to light; remembers points that are lit.
    ///
    /// # Errors
    /// The watch ended it.
    pub(super) fn sides(
        &mut self,
        scene: &Scene,
        outlines: &[Outline],
        sheets: &Sheets,
        how: LightSearch,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<[Reach; 2]>, Cancelled> {
        let first = Search { scene, outlines, sheets, sources: self };
        let shells = Shells::find(outlines, self.offset / OFFSET);
        let dark = first.dark_shells(&shells, None, how, &mut watch.part(0.0, 0.1))?;
        let both = |index: usize, _: &Outline| {
            let shell = shells.of_region[index].map(|shell| dark[shell as usize]);
            [Side::Front, Side::Back].map(|side| match shell {
                Some(dark) if dark[side as usize] => first.side_in_the_dark(index, side),
                _ => first.side(index, side, how.paths()),
            })
        };
        let mut reached: Vec<[Reach; 2]> = watch.part(0.1, 0.6).map(outlines, both)?;
        if self.is_dark() || !reached.iter().flatten().any(|&r| r == Reach::Dark) {
            return Ok(reached);
        }
        // A side that the light of lamps meets over many bounces is lit, too.
        let lit = Search { scene, outlines, sheets, sources: self }.lit_by_lamps(&mut reached);
        self.lit_points.extend(lit);
        // With so many lit points to look for, those that few paths led to are found as well: many small
        // facets around a place that is lit through a gap.
        let search = Search { scene, outlines, sheets, sources: self };
        let dark = search.dark_shells(&shells, Some(&reached), how, &mut watch.part(0.6, 0.7))?;
        let mut reached = watch.part(0.7, 0.95).map(&reached, |index, both| {
            let shell = shells.of_region[index].map_or([false; 2], |shell| dark[shell as usize]);
            [Side::Front, Side::Back].map(|side| match both[side as usize] {
                Reach::Dark if !shell[side as usize] => search.side(index, side, how.paths()),
                known => known,
            })
        })?;
        if how == LightSearch::Full {
            search.look_again_among_lit(&mut reached, &mut watch.part(0.95, 1.0))?;
        }
        if !reached.iter().flatten().any(|&reach| reach == Reach::Lit) {
            // What shines meets nothing: every side is kept, as where nothing shines.
            let dark = reached.iter_mut().flatten().filter(|reach| **reach == Reach::Dark);
            dark.for_each(|reach| *reach = Reach::Lit);
        }
        Ok(reached)
    }
}

impl<'a> Search<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        outlines: &'a [Outline],
        sheets: &'a Sheets,
        sources: &'a Sources,
    ) -> Self {
        Self { scene, outlines, sheets, sources }
    }

    /// Marks the sides that the light of lamps meets over many bounces, and finds points there with the
    /// direction that they face.
    fn lit_by_lamps(&self, reached: &mut [[Reach; 2]]) -> Vec<(DVec3, DVec3)> {
        let mut points = Vec::new();
        for (side, hits) in self.met_by_lamps().into_iter().enumerate() {
            let reach = &mut reached[side / 2][side % 2];
            if hits.len() >= ENOUGH_LAMP_PATHS {
                if *reach == Reach::Dark {
                    *reach = if self.is_black(side) { Reach::Black } else { Reach::Lit };
                }
                let normal = self.frame(side).normal;
                points.extend(spread(&hits).into_iter().map(|at| (at, normal)));
            }
        }
        points
    }

    /// For every side (2 x region + side) where the paths of lamps meet it, one point a path.
    fn met_by_lamps(&self) -> Vec<Vec<DVec3>> {
        let paths: Vec<Vec<(usize, DVec3)>> =
            (0..LAMP_PATHS).into_par_iter().map(|path| self.path_of_lamp(path)).collect();
        let mut met = vec![Vec::new(); 2 * self.outlines.len()];
        for (side, at) in paths.into_iter().flatten() {
            met[side].push(at);
        }
        met
    }

    /// The sides that light from a lamp meets on one path, each with the first point there.
    fn path_of_lamp(&self, path: u64) -> Vec<(usize, DVec3)> {
        let mut met: Vec<(usize, DVec3)> = Vec::new();
        let lamps = &self.sources.lamps;
        // With daylight every other path comes from outside.
        let is_outdoors = self.sources.has_sky && (path % 2 == 1 || lamps.is_empty());
        let (mut point, mut frame) = if is_outdoors {
            let Some((side, point)) = self.lit_from_outside(path) else { return met };
            met.push((side, point));
            if self.is_black(side) {
                return met;
            }
            (point, self.frame(side))
        } else {
            let at = path as usize % lamps.len().max(1);
            let Some(&(point, normal)) = lamps.get(at) else { return met };
            (point, Frame::along(normal, self.sources.lamp_tangents[at]))
        };
        for bounce in 0..LAMP_BOUNCES {
            let key = (1 << 50) + LAMP_BOUNCES * path + bounce;
            let direction = frame.world(cosine_from(unit(key, 1), unit(key, 2)));
            let origin = point + frame.normal * self.sources.offset;
            let Some(hit) = self.sheets.nearest(&Ray { origin, direction }) else { break };
            let side = self.side_met(hit.triangle, direction);
            point = origin + direction * hit.distance;
            let both = [side, side ^ 1];
            for side in both.into_iter().take(if self.is_translucent(side) { 2 } else { 1 }) {
                if !met.iter().any(|m| m.0 == side) {
                    met.push((side, point));
                }
            }
            if self.is_black(side) {
                break;
            }
            frame = self.frame(self.onward(side, key));
        }
        met
    }

    /// A place that light from outside meets, and the side that it is on, where the one that the path tries is such.
    fn lit_from_outside(&self, path: u64) -> Option<(usize, DVec3)> {
        let key = (1 << 51) + path;
        let index = ((unit(key, 0) * self.outlines.len() as f64) as usize).min(self.outlines.len() - 1);
        let outline = &self.outlines[index];
        let points = sample_points(outline, 4);
        let point = *points.get((unit(key, 3) * points.len() as f64) as usize)?;
        let back = unit(key, 4) < 0.5;
        if back && (self.sheets.backing[index] == Backing::Whole || self.sheets.covers_back(index, point)) {
            return None;
        }
        let (side, point) = (2 * index + usize::from(back), outline.world(point));
        let frame = self.frame(side);
        let direction = frame.world(cosine_from(unit(key, 1), unit(key, 2)));
        let origin = point + frame.normal * self.sources.offset;
        let is_lit = self.sources.has_sky && self.sheets.nearest(&Ray { origin, direction }).is_none();
        is_lit.then_some((side, point))
    }

    /// The side (2 x region + side) of a triangle that a ray in this direction meets.
    fn side_met(&self, triangle: u32, direction: DVec3) -> usize {
        let back = self.sheets.meets_back(triangle, direction);
        2 * self.sheets.owners[triangle as usize] as usize + usize::from(back)
    }

    /// Whether a side reflects nothing by its material's own word.
    fn is_black(&self, side: usize) -> bool {
        let outline = &self.outlines[side / 2];
        side % 2 == 1 && self.scene.materials[outline.material as usize].sides == Sides::Front
    }

    /// Whether light passes a side (2 x region + side) diffusely.
    fn is_translucent(&self, side: usize) -> bool {
        self.scene.materials[self.outlines[side / 2].material as usize].is_translucent()
    }

    /// The side (2 x region + side) from which a path goes on that meets one: of what passes light, as often the other.
    fn onward(&self, side: usize, key: u64) -> usize {
        if self.is_translucent(side) && unit(key, 5) < 0.5 { side ^ 1 } else { side }
    }

    /// The frame of a side (2 x region + side), which turns with it.
    fn frame(&self, side: usize) -> Frame {
        let frame = &self.outlines[side / 2].frame;
        Frame::along(frame.normal * if side % 2 == 1 { -1.0 } else { 1.0 }, frame.tangent)
    }

    /// For each shell whether its fronts and its backs are dark: what stands for it is, all of it. With what is
    /// `known` of each region, also all of it that is known.
    fn dark_shells(
        &self,
        shells: &Shells,
        known: Option<&[[Reach; 2]]>,
        how: LightSearch,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<[bool; 2]>, Cancelled> {
        let mut may_be_dark = vec![[true; 2]; shells.samples.len()];
        for (shell, known) in shells.of_region.iter().zip(known.unwrap_or_default()) {
            if let Some(shell) = shell {
                for (dark, reach) in may_be_dark[*shell as usize].iter_mut().zip(known) {
                    *dark &= !matches!(reach, Reach::Lit | Reach::Black);
                }
            }
        }
        let is_dark = |region: u32, side: Side| {
            matches!(self.side(region as usize, side, how.paths()), Reach::Dark | Reach::Backed)
        };
        watch.map(&shells.samples, |shell, samples| {
            [Side::Front, Side::Back].map(|side| {
                may_be_dark[shell][side as usize] && samples.iter().all(|&region| is_dark(region, side))
            })
        })
    }

    /// Follows more paths from dark sides that have lit ones along half of their edges or more: a facet of a ball just
    /// above the floor sees little of any light.
    fn look_again_among_lit(
        &self,
        reached: &mut [[Reach; 2]],
        watch: &mut Watch<'_>,
    ) -> Result<(), Cancelled> {
        let around = neighbours(self.outlines, self.sources.offset / OFFSET);
        let is_lit = |place: usize| matches!(reached[place / 2][place % 2], Reach::Lit | Reach::Black);
        let is_doubtful = |&place: &usize| {
            let lit =
                around[place / 2].iter().filter(|&&other| is_lit(2 * other as usize + place % 2)).count();
            let edges = self.outlines[place / 2].edges.len();
            reached[place / 2][place % 2] == Reach::Dark && lit > 0 && 2 * lit >= edges
        };
        let doubtful: Vec<usize> = (0..2 * reached.len()).filter(is_doubtful).collect();
        let sides = [Side::Front, Side::Back];
        let look = |_, &place: &usize| self.side(place / 2, sides[place % 2], (PATHS_AMONG_LIT, 1));
        for (&place, reach) in doubtful.iter().zip(watch.map(&doubtful, look)?) {
            reached[place / 2][place % 2] = reach;
        }
        Ok(())
    }

    /// How a side stands to light that is known to see none by its neighbours.
    fn side_in_the_dark(&self, index: usize, side: Side) -> Reach {
        let outline = &self.outlines[index];
        let emits = outline.luminaire.is_some() && (side == Side::Front || outline.emits_back);
        let sides = self.scene.materials[outline.material as usize].sides;
        if side == Side::Back && self.sheets.backing[index] == Backing::Whole {
            Reach::Backed
        } else if emits || sides == Sides::Both || (sides == Sides::Front && side == Side::Front) {
            Reach::Lit
        } else {
            Reach::Dark
        }
    }

    fn side(&self, index: usize, side: Side, (paths, enough): (u64, u32)) -> Reach {
        let outline = &self.outlines[index];
        if side == Side::Back && self.sheets.backing[index] == Backing::Whole {
            return Reach::Backed;
        }
        let emits = outline.luminaire.is_some() && (side == Side::Front || outline.emits_back);
        let sides = self.scene.materials[outline.material as usize].sides;
        if emits || sides == Sides::Both || (sides == Sides::Front && side == Side::Front) {
            return Reach::Lit;
        }
        if self.sources.is_dark() {
            // Nothing is lit; every side is kept, so that the model is seen whole, however it is turned.
            let is_black = side == Side::Back && sides == Sides::Front;
            return if is_black { Reach::Black } else { Reach::Lit };
        }
        let mut starts = sample_points(outline, 12);
        starts.retain(|&at| side == Side::Front || !self.sheets.covers_back(index, at));
        let starts: Vec<DVec3> = starts.into_iter().map(|p| outline.world(p)).collect();
        let seed = 2 * index as u64 + side as u64;
        let place = 2 * index + side as usize;
        let is_lit = |place: usize| self.is_lit(&starts, self.frame(place), seed, paths, enough);
        // What passes light sends some out where its other side is lit.
        match is_lit(place) || self.is_translucent(place) && is_lit(place ^ 1) {
            false => Reach::Dark,
            true if sides == Sides::Front => Reach::Black,
            true => Reach::Lit,
        }
    }

    /// For each patch whether its centre lies under something, out of all light, although its side is
    /// lit elsewhere; then a point of it that is lit, if any of `points` is. A lamp's counts as buried where
    /// it shines on sides that are dark by what has been `reached`.
    ///
    /// # Errors
    /// The watch ended it.
    pub(super) fn buried(
        &self,
        reached: &[[Reach; 2]],
        patches: &[Patch],
        points: impl Fn(&Patch) -> Vec<DVec3> + Sync,
        watch: &mut Watch<'_>,
    ) -> Result<Vec<Option<Buried>>, Cancelled> {
        watch.map(patches, |index, patch| {
            // Each facet of a cluster has its own plane, and its side is lit as a whole or not at all; what passes light
            // may have it from its other side.
            let place = 2 * patch.region as usize + patch.side as usize;
            if patch.is_cluster || self.is_translucent(place) {
                return None;
            }
            let by_reach = self.scene.materials[patch.material as usize].sides != Sides::Both;
            let seed = (1 << 40) + 64 * index as u64;
            let frame = self.frame(place);
            if patch.luminaire.is_some() {
                let covered = |point: &DVec3| self.looks_into_dark(reached, *point, frame);
                if !covered(&patch.centre) {
                    return None;
                }
                let open = points(patch).into_iter().take(40).find(|point| !covered(point));
                return Some(open.map_or(Buried::Whole, Buried::LitAt));
            }
            if !by_reach || self.sources.is_dark() || self.is_lit(&[patch.centre], frame, seed, PATHS / 3, 1)
            {
                return None;
            }
            // In a house of many rooms few of so short paths come upon one of the lamps of this room.
            let near = self.lit_points_near(patch.centre, frame.normal);
            if self.sees(patch.centre, frame.normal, &near) {
                return None;
            }
            let lit = (1..).zip(points(patch).into_iter().take(40)).find(|&(k, point)| {
                self.is_lit(&[point], frame, seed + k, PATHS / 8, 1) || self.sees(point, frame.normal, &near)
            });
            Some(lit.map_or(Buried::Whole, |(_, point)| Buried::LitAt(point)))
        })
    }

    /// Whether more than half of what is seen from a point is sides that no light reaches: nothing that is
    /// lit sees any, but for seams.
    fn looks_into_dark(&self, reached: &[[Reach; 2]], point: DVec3, frame: Frame) -> bool {
        const RAYS: u32 = 16;
        let origin = point + frame.normal * self.sources.offset;
        let meets_dark = |k: &u32| {
            let direction = frame.world(cosine_direction(*k, RAYS, 0.1));
            self.sheets.nearest(&Ray { origin, direction }).is_some_and(|hit| {
                let side = self.side_met(hit.triangle, direction);
                reached[side / 2][side % 2] == Reach::Dark
            })
        };
        (0..RAYS).filter(meets_dark).count() as u32 > RAYS / 2
    }

    /// The points nearest to a patch, of those that are known to be lit, that lie in front of it and
    /// face it.
    fn lit_points_near(&self, centre: DVec3, normal: DVec3) -> Vec<(DVec3, DVec3)> {
        let mut near: Vec<(f64, (DVec3, DVec3))> = self
            .sources
            .lit_points
            .iter()
            .map(|&lit| (lit.0 - centre, lit))
            .filter(|(to, (_, towards))| to.dot(normal) > 0.0 && to.dot(*towards) < 0.0)
            .map(|(to, lit)| (to.length_squared(), lit))
            .collect();
        if near.len() > NEAR_POINTS {
            near.select_nth_unstable_by(NEAR_POINTS, |a, b| a.0.total_cmp(&b.0));
            near.truncate(NEAR_POINTS);
        }
        near.into_iter().map(|(_, lit)| lit).collect()
    }

    /// Whether one of these points, each with the direction that it faces, is seen from a point.
    fn sees(&self, from: DVec3, normal: DVec3, points: &[(DVec3, DVec3)]) -> bool {
        let origin = from + normal * self.sources.offset;
        points.iter().any(|&(at, towards)| {
            let direction = at + towards * self.sources.offset - origin;
            let faces = direction.dot(normal) > 0.0 && direction.dot(towards) < 0.0;
            faces && !self.sheets.occluded(&Ray { origin, direction }, 1.0)
        })
    }

    /// Whether `enough` of `paths` paths from the points in turn find light.
    fn is_lit(&self, starts: &[DVec3], frame: Frame, seed: u64, paths: u64, enough: u32) -> bool {
        let mut found = 0;
        for path in 0..paths {
            let Some(&start) = starts.get(path as usize % starts.len().max(1)) else { return false };
            if self.path_finds_light(start, frame, seed.wrapping_mul(PATHS) + path) {
                found += 1;
                if found == enough {
                    return true;
                }
            }
        }
        false
    }

    fn path_finds_light(&self, mut point: DVec3, mut frame: Frame, seed: u64) -> bool {
        for bounce in 0..BOUNCES {
            point += frame.normal * self.sources.offset;
            let key = seed.wrapping_mul(BOUNCES) + bounce;
            // A lamp, or as often a point that is known to be lit.
            let targets = if key % 2 == 1 && !self.sources.lit_points.is_empty() {
                &self.sources.lit_points
            } else {
                &self.sources.lamps
            };
            let target = (unit(key, 0) * targets.len() as f64) as usize;
            if let Some(&(at, towards)) = targets.get(target.min(targets.len().saturating_sub(1))) {
                let at = at + towards * self.sources.offset;
                let to_target = at - point;
                if to_target.dot(frame.normal) > 0.0
                    && to_target.dot(towards) < 0.0
                    && !self.sheets.occluded(&Ray { origin: point, direction: to_target }, 1.0)
                {
                    return true;
                }
            }
            let direction = frame.world(cosine_from(unit(key, 1), unit(key, 2)));
            let Some(hit) = self.sheets.nearest(&Ray { origin: point, direction }) else {
                return self.sources.has_sky;
            };
            point += direction * hit.distance;
            frame = self.frame(self.onward(self.side_met(hit.triangle, direction), key));
        }
        false
    }
}

/// Up to [`LIT_POINTS`] of these points, each as far from those before as can be: a floor may run
/// through several rooms.
fn spread(points: &[DVec3]) -> Vec<DVec3> {
    let mut chosen: Vec<DVec3> = points.first().copied().into_iter().collect();
    while chosen.len() < LIT_POINTS.min(points.len()) {
        let lonely = |p: &DVec3| chosen.iter().map(|c| c.distance_squared(*p)).fold(f64::INFINITY, f64::min);
        let Some(&next) = points.iter().max_by(|a, b| lonely(a).total_cmp(&lonely(b))) else { break };
        chosen.push(next);
    }
    chosen
}

/// A number in 0..1 for a key and a dimension (the finaliser of SplitMix64, Steele et al. 2014).
fn unit(key: u64, dimension: u64) -> f64 {
    let mut z = (key.wrapping_mul(3).wrapping_add(dimension + 1)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Points inside the outline: in the triangles of its parts, spread by area.
pub(super) fn sample_points(outline: &Outline, count: usize) -> Vec<DVec2> {
    let mut points = Vec::with_capacity(count);
    let step = outline.area / count as f64;
    let mut due = 0.5 * step;
    let mut sum = 0.0;
    for part in &outline.parts {
        for k in 1..part.corners.len() - 1 {
            let [a, b, c] = [part.corners[0], part.corners[k], part.corners[k + 1]];
            let area = polygon::area_2d(&[a, b, c]);
            while due < sum + area && points.len() < count {
                let n = points.len() as f64;
                // An R2 sequence folded into the triangle.
                let (mut s, mut t) = ((0.5 + 0.754_877_67 * n).fract(), (0.5 + 0.569_840_29 * n).fract());
                if s + t > 1.0 {
                    (s, t) = (1.0 - s, 1.0 - t);
                }
                // Off the rim, from which a path could leave a closed body.
                let middle = (a + b + c) / 3.0;
                points.push(middle + (a + (b - a) * s + (c - a) * t - middle) * 0.98);
                due += step;
            }
            sum += area;
        }
    }
    points
}

/// The direction with a cosine distribution about +z for two numbers in 0..1.
fn cosine_from(along: f64, around: f64) -> DVec3 {
    let phi = std::f64::consts::TAU * around;
    let radius = along.sqrt();
    DVec3::new(radius * phi.cos(), radius * phi.sin(), (1.0 - along).max(0.0).sqrt())
}

/// The i-th of n directions with a cosine distribution about +z (Fibonacci spiral, turned).
pub(crate) fn cosine_direction(i: u32, n: u32, turn: f64) -> DVec3 {
    cosine_from((f64::from(i) + 0.5) / f64::from(n), (f64::from(i) * 0.618_033_988_749_894_9 + turn).fract())
}
