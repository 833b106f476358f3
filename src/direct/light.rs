//! Direct irradiance at a point, exactly: each emitter's outline less what hides it.

mod sampled;

pub(super) use sampled::mean_over_outline;

use super::Clipper;
use super::behind::Behind;
use super::fan::Fan;
use super::mirrors::{self, Mirrors};
use super::obstacles::{Obstacle, Obstacles};
use super::shaft::Shaft;
use crate::emitters::{Emitters, Source};
use crate::mesh::PatchMesh;
use crate::visibility::{Glass, THICKNESS};
use crate::watch::{Cancelled, Watch};
use glam::DVec3;
use std::sync::Arc;

/// The emitters of a scene and all that stands before them.
#[derive(Clone, Debug)]
pub struct DirectLight {
    emitters: Emitters,
    obstacles: Arc<Obstacles>,
    glass: Glass,
    /// What panes mirror; nothing until it has been [looked for](Self::with_mirrors).
    mirrors: Mirrors,
    /// Whether they hide anything from surfaces.
    visibility: bool,
    /// What is nearer to a plane counts as in it, metres.
    thickness: f64,
    /// Whether facets are a great many, so that most of a surface is behind too many obstacles for more than few rays.
    among_many: bool,
}

/// What may hide each emitter from a cell; emitters that give it nothing are left out.
#[derive(Clone, Debug, Default)]
pub struct Views {
    /// Emitter, and where its obstacles end in `obstacles` and its panes in `panes`.
    sources: Vec<(u32, u32, u32)>,
    obstacles: Vec<u32>,
    /// Panes of glass that may stand before it.
    panes: Vec<u32>,
    /// Panes that may mirror some of them.
    mirrors: Vec<u32>,
    /// Of a place that light may not reach, which sees sides that it does not reach either.
    anywhere: bool,
    /// Of a facet so small that rays tell all that matters: emitters are looked for at each point.
    is_sampled: bool,
}

/// Working memory of one thread.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    clipper: Clipper,
    fan: Fan,
    shaft: Shaft,
    pub(super) outline: Vec<DVec3>,
    pub(super) relative: Vec<DVec3>,
    found: Vec<u32>,
    panes: Vec<u32>,
    behind: Behind,
    pub(super) edges: Vec<DVec3>,
    /// What emitters give, and where their outlines lie in `relative`.
    shares: Vec<(f64, usize, usize)>,
    /// Half-spaces that hold all that is between a point and an outline: normals and offsets.
    beams: Vec<(DVec3, f64)>,
}

/// What is left of an outline in more fragments is looked at by half-planes.
const MOST_FRAGMENTS: usize = 40;
/// What passes beside an outline is left out by so many of its edges at most.
const MOST_BEAMS: usize = 8;
/// Of so few obstacles it costs more to find those that enter a smaller shaft than to look at all of them there.
const FEW: usize = 12;
/// So many of the largest obstacles are tried by themselves first.
const MOST_LARGE: u32 = 24;
/// What so many obstacles may hide is looked at by rays, so many along each edge of its outline.
const MOST_OBSTACLES: usize = 512;
const RAYS: u32 = 16;
/// In models of a great many facets, where most of a surface is behind so many, this many in all.
const RAYS_AMONG_MANY: f64 = 100.0;
/// On small facets fewer, by what part of all light an emitter may give at least.
const FEW_RAYS: [(f64, f64); 3] = [(0.2, 16.0), (0.05, 8.0), (0.005, 4.0)];

/// Where few rays are enough, so many go to the rim of an emitter.
const RIM_RAYS: usize = 2;

/// What an emitter costs by itself, in obstacles.
const EMITTER_WORK: usize = 4;

/// Points along the edges of a grid of about so many.
fn along_for(rays: f64) -> u32 {
    rays.sqrt().round().max(1.0) as u32
}

/// The middle of some corners, one or more, and places towards some of them, halfway by area.
fn few_places(corners: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let step = corners.len().div_ceil(RIM_RAYS).max(1);
    let rim = corners.iter().step_by(step).map(move |&corner| middle.lerp(corner, 0.7));
    std::iter::once(middle).chain(rim)
}

impl Views {
    /// Of a small facet, which is looked at by rays and not divided.
    pub(super) fn sampled() -> Self {
        Self { is_sampled: true, ..Self::default() }
    }

    /// Whether each point looks for itself, by rays.
    pub(super) fn is_sampled(&self) -> bool {
        self.is_sampled
    }

    /// Whether nothing shines there.
    pub fn is_dark(&self) -> bool {
        self.sources.is_empty() && self.mirrors.is_empty() && !self.is_sampled
    }

    /// How many emitters may be seen.
    pub fn emitters(&self) -> usize {
        self.sources.len()
    }

    /// Whether all of them are seen wholly, and neither through glass nor in it.
    pub fn is_clear(&self) -> bool {
        self.obstacles.is_empty() && self.panes.is_empty() && self.mirrors.is_empty()
    }

    /// What a gathering there costs, in obstacles that are looked at.
    pub(super) fn work(&self) -> u64 {
        (EMITTER_WORK * self.sources.len() + self.obstacles.len() + self.panes.len()) as u64
            + mirrors::WORK * self.mirrors.len() as u64
    }

    /// Each emitter with what may hide it, and the panes that may stand before it.
    fn iter(&self) -> impl Iterator<Item = (u32, [&[u32]; 2])> {
        let mut starts = (0, 0);
        self.sources.iter().map(move |&(source, obstacles, panes)| {
            let ends = (obstacles as usize, panes as usize);
            let (first, pane) = std::mem::replace(&mut starts, ends);
            (source, [&self.obstacles[first..ends.0], &self.panes[pane..ends.1]])
        })
    }

    pub(super) fn add_mirror(&mut self, pane: u32) {
        self.mirrors.push(pane);
    }

    fn push(&mut self, source: u32) {
        self.sources.push((source, self.obstacles.len() as u32, self.panes.len() as u32));
    }
}

impl DirectLight {
    /// The lamps of a mesh and its surfaces; without `visibility` surfaces see each other whatever stands between.
    pub fn new(mesh: &PatchMesh, visibility: bool) -> Self {
        Self {
            emitters: Emitters::new(mesh),
            obstacles: Arc::new(Obstacles::new(mesh)),
            glass: Glass::new(mesh),
            mirrors: Mirrors::default(),
            visibility,
            thickness: THICKNESS * mesh.size,
            among_many: !mesh.clusters.is_empty(),
        }
    }

    /// The same with what panes of glass mirror of its sources.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn with_mirrors(mut self, watch: &mut Watch<'_>) -> Result<Self, Cancelled> {
        self.mirrors = Mirrors::find(&self, watch)?;
        Ok(self)
    }

    /// The same among the same surfaces under the sky of another hour: that of this mesh, which is the same otherwise.
    #[must_use]
    pub fn at_hour_of(&self, mesh: &PatchMesh) -> Self {
        Self { emitters: Emitters::new(mesh), ..self.clone() }
    }

    /// The same with those of its sources alone that are `kept`.
    pub(super) fn keeping(&self, kept: impl Fn(&Source) -> bool) -> Self {
        Self { emitters: self.emitters.keeping(kept), ..self.clone() }
    }

    /// What sends out light.
    pub fn emitters(&self) -> &Emitters {
        &self.emitters
    }

    /// What is nearer to a plane than this counts as in it, metres.
    pub(super) fn thickness(&self) -> f64 {
        self.thickness
    }

    pub(super) fn glass(&self) -> &Glass {
        &self.glass
    }

    /// What is left in each band of light of a source that passes from one point to another.
    pub(super) fn passed_between(&self, source: &Source, from: DVec3, to: DVec3) -> [f64; 3] {
        let (way, margin) = (to - from, 5.0 * self.thickness);
        let length = way.length();
        let is_foreign = |region: u32| !source.emitter.is_part(region);
        let hides = |obstacle: Obstacle<'_>| is_foreign(obstacle.region);
        if self.visibility && self.obstacles.hides(from, to, margin, hides) {
            return [0.0; 3];
        }
        if length <= 2.0 * margin {
            [1.0; 3]
        } else {
            self.glass.along(from, way / length, [margin, length - margin])
        }
    }

    /// Whether a point with a unit normal sees something of a source, by rays to its middle and to some of its rim.
    pub(super) fn may_see(&self, source: &Source, point: DVec3, normal: DVec3) -> bool {
        let mut outline = Vec::new();
        if source.emitter.outline(point, &mut outline).is_none() {
            return false;
        }
        few_places(&outline).any(|to| {
            normal.dot(to) > 0.0
                && self.passed_between(source, point, point + to).iter().any(|&passed| passed > 0.0)
        })
    }

    /// Whether nothing stands between two points.
    pub(super) fn is_open(&self, from: DVec3, to: DVec3) -> bool {
        !self.obstacles.hides(from, to, 5.0 * self.thickness, |_| true)
    }

    /// Irradiance of a point with a unit normal by a source for a unit of what it sends, in each band what glass leaves of
    /// it, by few rays: to its middle and halfway to its rim.
    pub(super) fn by_few_rays(
        &self,
        source: &Source,
        (point, normal): (DVec3, DVec3),
        scratch: &mut Scratch,
    ) -> [f64; 3] {
        let Scratch { clipper, outline, relative, .. } = scratch;
        if source.emitter.outline(point, outline).is_none() {
            return [0.0; 3];
        }
        clipper.start(outline, normal);
        relative.clear();
        relative.extend(clipper.fragments().flatten());
        if relative.is_empty() {
            return [0.0; 3];
        }
        let value: f64 = clipper.fragments().map(|f| source.emitter.irradiance(normal, f)).sum();
        if !self.visibility {
            return [value; 3];
        }
        let passed = |to: DVec3| self.passed_between(source, point, point + to);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for to in few_places(relative) {
            sum.iter_mut().zip(passed(to)).for_each(|(sum, passed)| *sum += passed);
            count += 1.0;
        }
        sum.map(|sum| value * sum / count)
    }

    /// The squared irradiance, times its area in m², of the shadows that obstacles may throw on a triangle with a unit
    /// normal between the places where it was looked at: of those that are narrower than the triangle's edges, by how much
    /// of an emitter they can hide. `exitance` is that of each basis.
    pub(super) fn possible_shadow(
        &self,
        cell: [DVec3; 3],
        normal: DVec3,
        views: &Views,
        exitance: &[f64],
        scratch: &mut Scratch,
    ) -> f64 {
        let middle = (cell[0] + cell[1] + cell[2]) / 3.0;
        let area = 0.5 * (cell[1] - cell[0]).cross(cell[2] - cell[0]).length();
        let edge = area.sqrt();
        let mut sum = 0.0;
        for (source, [obstacles, _]) in views.iter().filter(|view| !view.1[0].is_empty()) {
            let source = &self.emitters.sources[source as usize];
            let emitter = &source.emitter;
            let hull = emitter.hull();
            let target = hull.iter().sum::<DVec3>() / hull.len() as f64;
            let to = target - middle;
            let reach = hull.iter().map(|c| c.distance(target)).fold(0.0, f64::max);
            let spread = reach * reach / to.length_squared().max(f64::MIN_POSITIVE);
            let mut shadow = 0.0;
            for &index in obstacles {
                let (width, length) = self.obstacles.extent(index);
                let distance = self.obstacles.get(index).corners[0].distance(middle);
                // As large as its shadow, or as what blurs that.
                let behind = (to.length() - distance).max(1e-3 * to.length());
                let larger = to.length() / behind;
                if (width * larger).max(reach * distance / behind) > edge {
                    continue;
                }
                let seen = width * length / (distance * distance).max(f64::MIN_POSITIVE);
                let hidden = (seen / spread.max(f64::MIN_POSITIVE)).min(1.0);
                shadow += hidden * hidden * (width * length * larger * larger).min(area);
            }
            if shadow > 0.0 {
                let Scratch { clipper, outline, .. } = scratch;
                if emitter.outline(middle, outline).is_none() {
                    continue;
                }
                clipper.start(outline, normal);
                let value: f64 = clipper.fragments().map(|f| emitter.irradiance(normal, f)).sum();
                let shares = source.shares.iter();
                let watts: f64 = shares.map(|s| value * s.factor * exitance[s.basis as usize]).sum();
                sum += watts * watts * shadow.min(area);
            }
        }
        sum
    }

    /// What a convex cell with a unit normal, metres, may see of the emitters. A cell of a surface that light reaches
    /// sees no side that it does not reach: such sides are left out. One that is `anywhere` may.
    pub fn views(&self, cell: &[DVec3], normal: DVec3, anywhere: bool, scratch: &mut Scratch) -> Views {
        self.views_past(cell, normal, [anywhere, self.visibility], scratch)
    }

    fn views_past(
        &self,
        cell: &[DVec3],
        normal: DVec3,
        [anywhere, visibility]: [bool; 2],
        scratch: &mut Scratch,
    ) -> Views {
        let mut views = Views { anywhere, ..Views::default() };
        for source in 0..self.emitters.sources.len() as u32 {
            if !self.aim(source, cell, normal, scratch) {
                continue;
            }
            if visibility && self.is_behind_a_large_one(source, anywhere, &scratch.shaft) {
                continue;
            }
            scratch.shaft.bound(normal);
            let Scratch { shaft, found, panes, .. } = scratch;
            found.clear();
            panes.clear();
            if visibility {
                self.obstacles.select(|bounds| shaft.meets(bounds), found);
                self.glass.select(|bounds| shaft.meets(bounds), panes);
            }
            self.keep(source, scratch, &mut views);
        }
        self.mirrors.look(self, cell, normal, &mut views);
        views
    }

    /// What a part of a cell may see, by what the whole may.
    pub fn narrowed(&self, views: &Views, cell: &[DVec3], normal: DVec3, scratch: &mut Scratch) -> Views {
        let mirrors = views.mirrors.clone();
        let mut narrowed = Views { anywhere: views.anywhere, mirrors, ..Views::default() };
        for (source, [obstacles, panes]) in views.iter() {
            if obstacles.is_empty() && panes.is_empty() {
                narrowed.push(source);
                continue;
            }
            if !self.aim(source, cell, normal, scratch) {
                continue;
            }
            if obstacles.len() + panes.len() <= FEW {
                let fills = |&index: &u32| self.fills(&scratch.shaft, index, views.anywhere);
                if !obstacles.iter().any(fills) {
                    narrowed.obstacles.extend_from_slice(obstacles);
                    narrowed.panes.extend_from_slice(panes);
                    narrowed.push(source);
                }
                continue;
            }
            scratch.shaft.bound(normal);
            scratch.found.clear();
            scratch.found.extend_from_slice(obstacles);
            scratch.panes.clear();
            scratch.panes.extend_from_slice(panes);
            self.keep(source, scratch, &mut narrowed);
        }
        narrowed
    }

    /// Whether some of an emitter may shine on a cell, and the shaft between them.
    fn aim(&self, source: u32, cell: &[DVec3], normal: DVec3, scratch: &mut Scratch) -> bool {
        let Scratch { shaft, outline, .. } = scratch;
        let emitter = &self.emitters.sources[source as usize].emitter;
        let hull = emitter.hull();
        let is_above = |from: &DVec3| hull.iter().any(|to| normal.dot(*to - *from) > self.thickness);
        if !cell.iter().any(is_above) {
            return false;
        }
        if !cell.iter().any(|&from| emitter.outline(from, outline).is_some()) {
            return false;
        }
        shaft.aim(cell, hull);
        true
    }

    /// Whether one of the largest obstacles hides all of an emitter from all of a cell. Most of a sky is hidden from most
    /// of a house by a ceiling or a wall: then nothing else needs to be looked for.
    fn is_behind_a_large_one(&self, source: u32, anywhere: bool, shaft: &Shaft) -> bool {
        let emitter = &self.emitters.sources[source as usize].emitter;
        (0..self.obstacles.count().min(MOST_LARGE)).any(|index| {
            self.fills(shaft, index, anywhere) && !emitter.is_part(self.obstacles.get(index).region)
        })
    }

    /// Whether an obstacle hides all of what the shaft is aimed at from all of its cell.
    fn fills(&self, shaft: &Shaft, index: u32, anywhere: bool) -> bool {
        let obstacle = self.obstacles.get(index);
        shaft.is_filled_by(&obstacle, self.thickness)
            && (anywhere || !shaft.needs_not(&obstacle, self.thickness))
    }

    /// Adds an emitter with those of the obstacles found that enter the shaft, unless one of them fills it.
    fn keep(&self, source: u32, scratch: &Scratch, views: &mut Views) {
        let emitter = &self.emitters.sources[source as usize].emitter;
        let start = views.obstacles.len();
        for &index in &scratch.found {
            let obstacle = self.obstacles.get(index);
            if emitter.is_part(obstacle.region)
                || !scratch.shaft.holds(&obstacle, self.thickness, views.anywhere)
            {
                continue;
            }
            if scratch.shaft.is_filled_by(&obstacle, self.thickness) {
                views.obstacles.truncate(start);
                return;
            }
            views.obstacles.push(index);
        }
        let enters = |&&pane: &&u32| scratch.shaft.meets(&self.glass.panes().list[pane as usize].bounds);
        views.panes.extend(scratch.panes.iter().filter(enters));
        views.push(source);
    }

    /// Calls `add` with each basis and the irradiance that it gives at a point of the cell that `views` is of, W/m²
    /// per W/m² of the lamp's exitance. The point's unit normal may differ from the cell's.
    pub fn gather(
        &self,
        point: DVec3,
        normal: DVec3,
        views: &Views,
        scratch: &mut Scratch,
        mut add: impl FnMut(u32, f64),
    ) {
        self.gather_sources(point, normal, views, scratch, |source, value| {
            for share in &source.shares {
                let value = share.of(value);
                if value > 0.0 {
                    add(share.basis, value);
                }
            }
        });
    }

    /// Calls `add` with each basis and about what it gives at a point in the open with a unit normal, by few rays.
    pub fn glimpse(&self, point: DVec3, normal: DVec3, scratch: &mut Scratch, mut add: impl FnMut(u32, f64)) {
        self.sample(point, normal, scratch, |source, value| {
            source.shares.iter().for_each(|share| add(share.basis, share.of(value)));
        });
    }

    /// As [`Self::gather`], source by source: irradiance for a unit of what each sends, in each band what glass leaves of it.
    pub(super) fn gather_sources(
        &self,
        point: DVec3,
        normal: DVec3,
        views: &Views,
        scratch: &mut Scratch,
        mut add: impl FnMut(&Source, [f64; 3]),
    ) {
        if views.is_sampled {
            return self.sample(point, normal, scratch, add);
        }
        for (source, before) in views.iter() {
            let value = self.irradiance(source, (point, normal), before, views.anywhere, scratch);
            if value.iter().any(|&value| value > 0.0) {
                add(&self.emitters.sources[source as usize], value);
            }
        }
        self.mirrors.gather((self, &views.mirrors), point, normal, scratch, add);
    }

    fn irradiance(
        &self,
        source: u32,
        (point, normal): (DVec3, DVec3),
        [obstacles, panes]: [&[u32]; 2],
        anywhere: bool,
        scratch: &mut Scratch,
    ) -> [f64; 3] {
        let emitter = &self.emitters.sources[source as usize].emitter;
        let Scratch { clipper, fan, outline, relative, edges, beams, behind, .. } = scratch;
        edges.clear();
        let Some(limit) = emitter.outline(point, outline) else { return [0.0; 3] };
        clipper.start(outline, normal);
        if clipper.is_empty() {
            return [0.0; 3];
        }
        beams.clear();
        beams.push((normal, 0.0));
        beams.push((limit.normal, limit.offset));
        super::clip::edge_planes(outline, -1.0, edges);
        let step = edges.len().div_ceil(MOST_BEAMS).max(1);
        beams.extend(edges.iter().step_by(step).map(|plane| (*plane, 0.0)));
        if obstacles.len() > MOST_OBSTACLES {
            let outline: Vec<DVec3> = clipper.fragments().flatten().copied().collect();
            let along = |share| if self.among_many { along_for(share * RAYS_AMONG_MANY) } else { RAYS };
            let source = &self.emitters.sources[source as usize];
            let share = self.share_by_rays(source, point, &outline, along);
            let whole = clipper.fragments().map(|f| emitter.irradiance(normal, f)).sum::<f64>();
            return share.map(|share| share * whole);
        }
        for &index in obstacles {
            if self.is_beside(index, point, beams) {
                continue;
            }
            let obstacle = self.obstacles.get(index);
            let height = obstacle.plane.dot(point - obstacle.corners[0]);
            if !anywhere && obstacle.is_needless([height; 2], self.thickness) {
                continue;
            }
            relative.clear();
            relative.extend(obstacle.corners.iter().map(|c| *c - point));
            clipper.subtract(relative, obstacle.plane, limit, self.thickness);
            if clipper.is_empty() {
                return [0.0; 3];
            }
            if clipper.count() > MOST_FRAGMENTS {
                clipper.start(outline, normal);
                let whole: Vec<DVec3> = clipper.fragments().flatten().copied().collect();
                fan.start(&whole);
                for &index in obstacles {
                    if self.is_beside(index, point, beams) {
                        continue;
                    }
                    let obstacle = self.obstacles.get(index);
                    relative.clear();
                    relative.extend(obstacle.corners.iter().map(|c| *c - point));
                    fan.add(relative, obstacle.plane, limit, self.thickness);
                }
                let share = fan.visible_share(normal);
                let value = self.through(panes, &**emitter, (point, normal), limit, (clipper, behind));
                return value.map(|value| share * value);
            }
        }
        self.through(panes, &**emitter, (point, normal), limit, (clipper, behind))
    }

    /// Whether an obstacle lies outside of one of the half-spaces that hold all between a point and an outline.
    fn is_beside(&self, index: u32, point: DVec3, beams: &[(DVec3, f64)]) -> bool {
        let (middle, radius) = self.obstacles.sphere(index);
        let middle = middle - point;
        beams.iter().any(|(plane, offset)| plane.dot(middle) <= offset - radius)
    }

    /// Irradiance at a free point from everything, as [`Self::gather`] gives it; where `is_hidden`, of what surfaces
    /// leave visible.
    pub fn at(
        &self,
        point: DVec3,
        normal: DVec3,
        is_hidden: bool,
        scratch: &mut Scratch,
        add: impl FnMut(u32, f64),
    ) {
        // A cell of no size: its shaft is the pyramid from the point.
        let cell = [point; 3];
        let views = self.views_past(&cell, normal, [true, is_hidden], scratch);
        self.gather(point, normal, &views, scratch, add);
    }
}
