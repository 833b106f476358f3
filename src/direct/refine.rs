//! Elements divided where direct light is not linear between their corners.

use super::elements::{Element, ElementCorner, Elements, NO_ELEMENT};
use super::focus::Focus;
use super::layout::Layout;
use super::light::{DirectLight, Scratch, Views};
use crate::emitters::{Share, Source};
use crate::mesh::PatchMesh;
use crate::watch::{Cancelled, Watch};
use glam::DVec3;
use rayon::prelude::*;
use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// How finely direct light is divided.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementSettings {
    /// Division ends once direct light is expected to be off by this, RMS over the area, of the mean and of the light there
    /// (their geometric mean, half the mean added to what is there); above zero.
    pub error: f64,
    /// There are no more elements than this, besides the triangles of the mesh.
    pub most: usize,
    /// Division ends after so much work as well, in obstacles that were looked at: a measure of time that is the same
    /// on any machine.
    pub work: u64,
    /// Exitance of each basis that decides what counts: luminance, W/m².
    pub exitance: Vec<f64>,
    /// Whether normals follow smooth surfaces.
    pub smooth: bool,
    /// Who looks on: what they see counts for more than its area.
    pub focus: Option<Focus>,
    /// Whether errors count against the geometric mean of the light instead of the plain one: beside the ground in the sun
    /// a room would count for nothing.
    pub adapted: bool,
}

/// A corner beside which something may stand is looked at so far inside of an element, of its size: on a line
/// between two planes light has two values.
const INSET: f64 = 1e-3;
/// Where there is less light than this part of the mean, errors count as if there were as much.
const FAINT: f64 = 0.5;
/// Light counts for the geometric mean as if it were at least this part of the plain one, which it is held to as well.
const DIMMEST: f64 = 1e-3;
const LEAST_MEAN: f64 = 0.1;
/// A shadow that may be there counts this part of one that is.
const POSSIBLE: f64 = 0.05;
/// A difference that shows that a shadow was found.
const NOTABLE: f64 = 0.02;
/// Each pass divides the elements that make up so much of the squared error (Dörfler 1996).
const BULK: f64 = 0.6;
/// What hides the lamps from an element is looked for anew once it is so small a part of the one that it was looked
/// for from.
pub(super) const NARROWED: f64 = 0.3;
/// Where division has taken this part of the work that it may take, so many times the error asked for is good enough.
pub const DEAR: u64 = 25;
/// See [`DEAR`].
pub const NEARLY: f64 = 4.0;
/// No edge is divided below this share of the scene's size.
const SHORTEST: f64 = 2e-5;
/// Passes at most.
const MOST_PASSES: usize = 64;

/// Elements on their way.
pub(super) struct Refinement<'a> {
    light: &'a DirectLight,
    settings: &'a ElementSettings,
    pub(super) elements: Elements,
    /// Where only some of the light is looked for, its bases: the rest is linear between the corners that there are.
    only: Option<Range<u32>>,
    /// What each element may see, and how wrong it is expected to be; of leaves alone.
    views: Vec<Arc<Views>>,
    /// Area of the element that these were looked for from, m².
    seen_from: Vec<f64>,
    /// Elements that it began with.
    whole: usize,
    errors: Vec<f64>,
    /// Whether it lies open to the one who looks on; empty where there is nobody.
    open: Vec<bool>,
    /// Corners in the middles of edges, by the corners at their ends; not all of them are in use.
    middles: HashMap<(u32, u32), u32>,
    /// Edges that have an element on one side alone.
    borders: HashSet<(u32, u32)>,
    /// Mean light of all bases together.
    pub(super) mean: f64,
    area: f64,
    /// Obstacles looked at so far.
    work: u64,
    /// Nearer than this to a plane nothing is hidden by it, metres.
    inset: f64,
    shortest: f64,
}

pub(super) type Light = Vec<(u32, f32)>;

/// What is found at a point.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    /// Basis and irradiance, bases in rising order.
    pub(super) light: Light,
    /// What is seen of parts of the sky, by [`super::sky_parts::SkyParts`].
    pub(super) parts: Vec<(u16, f32)>,
}

impl Found {
    pub(super) fn add(&mut self, basis: u32, value: f32) {
        match self.light.binary_search_by_key(&basis, |entry| entry.0) {
            Ok(at) => self.light[at].1 += value,
            Err(at) => self.light.insert(at, (basis, value)),
        }
    }
}

impl Elements {
    /// The direct light of a mesh on elements.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn build(
        mesh: &PatchMesh,
        light: &DirectLight,
        settings: &ElementSettings,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let layout = Layout::build(mesh, light, settings, &mut watch.part(0.0, 0.9))?;
        layout.lit(mesh, light, settings, &mut watch.part(0.9, 1.0))
    }
}

/// Nearer than this to a plane nothing is hidden by it, metres.
pub(super) fn inset(light: &DirectLight) -> f64 {
    3.0 * light.thickness()
}

/// Edges with an element on one side alone.
fn borders(elements: &Elements) -> HashSet<(u32, u32)> {
    let mut once = HashSet::new();
    for key in elements.leaves().flat_map(|element| (0..3).map(|k| edge_key(element, k))) {
        if !once.remove(&key) {
            once.insert(key);
        }
    }
    once
}

/// Where the light of each corner is looked for: in the open near it, and an element that holds that point.
pub(super) fn places(elements: &Elements, inset: f64) -> Vec<Option<(u32, DVec3)>> {
    let mut sums = vec![(DVec3::ZERO, 0.0, NO_ELEMENT); elements.corners.len()];
    for (index, element) in elements.leaves_with_index() {
        let [a, b, c] = elements.positions(element);
        for &corner in &element.corners {
            let sum = &mut sums[corner as usize];
            sum.0 += (a + b + c) / 3.0;
            sum.1 += 1.0;
            sum.2 = index;
        }
    }
    let place = |(corner, (sum, count, element)): (&ElementCorner, (DVec3, f64, u32))| {
        (element != NO_ELEMENT).then(|| (element, inside(corner.position, sum / count, inset)))
    };
    elements.corners.iter().zip(sums).map(place).collect()
}

/// A point near another, a little towards a third.
fn inside(point: DVec3, towards: DVec3, least: f64) -> DVec3 {
    let way = towards - point;
    let length = way.length();
    if length <= 2.0 * least { point + 0.5 * way } else { point + way * INSET.max(least / length) }
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Does something with the working memory of this thread.
pub(super) fn with_scratch<T>(work: impl FnOnce(&mut Scratch) -> T) -> T {
    SCRATCH.with_borrow_mut(work)
}

fn edge_key(element: &Element, k: usize) -> (u32, u32) {
    let (a, b) = (element.corners[k], element.corners[(k + 1) % 3]);
    (a.min(b), a.max(b))
}

pub(super) fn gathered(light: &DirectLight, point: DVec3, normal: DVec3, views: &Views) -> Found {
    let mut found = Found::default();
    let mut add = |source: &Source, value: [f64; 3]| {
        for (k, share) in source.shares.iter().enumerate() {
            let own = share.of(value);
            if own > 0.0 {
                found.add(share.basis, own as f32);
            }
            let Some(key) = source.key(k) else { continue };
            let whole = Share { factor: 1.0, ..*share }.of(value) as f32;
            match found.parts.iter_mut().find(|part| part.0 == key) {
                Some(part) => part.1 += whole,
                None => found.parts.push((key, whole)),
            }
        }
    };
    with_scratch(|scratch| light.gather_sources(point, normal, views, scratch, &mut add));
    found
}

impl<'a> Refinement<'a> {
    /// Begins with elements that have their light. `views` tell what each may see, looked for from so large an area;
    /// where there are no others than those of the bases `only`, the rest of the light is not looked for again.
    pub(super) fn new(
        (mesh, light): (&PatchMesh, &'a DirectLight),
        settings: &'a ElementSettings,
        elements: Elements,
        (views, seen_from): (Vec<Arc<Views>>, Vec<f64>),
        only: Option<Range<u32>>,
    ) -> Self {
        let open = settings.focus.map(|focus| focus.open(&elements, light)).unwrap_or_default();
        Self {
            open,
            light,
            settings,
            only,
            errors: vec![0.0; elements.elements.len()],
            seen_from,
            whole: elements.elements.len(),
            borders: borders(&elements),
            elements,
            views,
            middles: HashMap::new(),
            mean: 0.0,
            area: 0.0,
            work: 0,
            inset: inset(light),
            shortest: SHORTEST * mesh.size,
        }
    }

    /// Divides those that are worst, pass by pass; then leaves out corners that nothing has.
    pub(super) fn run(mut self, mesh: &PatchMesh, watch: &mut Watch<'_>) -> Result<Elements, Cancelled> {
        let leaves = self.elements.leaves_with_index();
        let mut fresh: Vec<u32> = leaves.map(|leaf| leaf.0).collect();
        for pass in 0..MOST_PASSES {
            let share = pass as f64 / (pass as f64 + 8.0);
            let next = (pass + 1) as f64 / (pass as f64 + 9.0);
            self.examine(&fresh, &mut watch.part(share, next))?;
            let marked = self.worst();
            if marked.is_empty() {
                break;
            }
            fresh = self.divide(&marked, mesh);
        }
        let mut elements = self.elements;
        elements.compact();
        Ok(elements)
    }

    /// What is found at a point beside the middle of an edge between two corners.
    fn look(&self, (corner, point): (&ElementCorner, DVec3), views: &Views, ends: [u32; 2]) -> Found {
        let mut found = gathered(self.light, point, corner.normal, views);
        if let Some(only) = &self.only {
            for &(basis, value) in ends.iter().flat_map(|&end| self.elements.light_at(end)) {
                if !only.contains(&basis) {
                    found.add(basis, 0.5 * value);
                }
            }
        }
        found
    }

    fn keep(&mut self, corner: ElementCorner, found: &Found) {
        self.elements.corners.push(corner);
        self.elements.push_light(&found.light);
        if self.only.is_none() {
            self.elements.parts.push(&found.parts);
        }
    }
}

impl Refinement<'_> {
    /// Mean light of all bases together, and what corners have `besides`, W/m², where there is some.
    pub(super) fn measure_mean(&mut self, besides: &[f64]) {
        let exitance = &self.settings.exitance;
        let at = |elements: &Elements, corner: u32| {
            let besides = besides.get(corner as usize).copied().unwrap_or(0.0);
            elements.watts_at(corner, exitance) + besides
        };
        let mut sum = 0.0;
        for element in self.elements.leaves() {
            let area = self.elements.area(element);
            self.area += area;
            sum += area / 3.0 * element.corners.iter().map(|&c| at(&self.elements, c)).sum::<f64>();
        }
        self.mean = sum / self.area.max(f64::MIN_POSITIVE);
        if self.settings.adapted && self.mean > 0.0 {
            let mut logarithms = 0.0;
            for element in self.elements.leaves() {
                let corners = element.corners.iter();
                let light = corners.map(|&c| at(&self.elements, c)).sum::<f64>();
                logarithms += self.elements.area(element) * (light / 3.0).max(DIMMEST * self.mean).ln();
            }
            let geometric = (logarithms / self.area.max(f64::MIN_POSITIVE)).exp();
            self.mean = geometric.max(LEAST_MEAN * self.mean);
        }
    }

    /// Looks at the middles of the edges of some leaves.
    fn examine(&mut self, fresh: &[u32], watch: &mut Watch<'_>) -> Result<(), Cancelled> {
        // 1. Middles that nobody has looked at yet, each from one of its elements.
        let mut wanted: Vec<(u32, usize)> = Vec::new();
        let first = self.elements.corners.len() as u32;
        for &index in fresh {
            let views = &self.views[index as usize];
            if views.is_dark() || views.is_sampled() {
                continue;
            }
            let element = self.elements.elements[index as usize];
            // On those that it began with, with something before a lamp all three; else the one that would become a corner.
            let longest = self.longest_edge(index).0;
            let all = (index as usize) < self.whole && !self.views[index as usize].is_clear();
            for k in (0..3).filter(|&k| all || k == longest) {
                let next = first + wanted.len() as u32;
                if *self.middles.entry(edge_key(&element, k)).or_insert(next) == next {
                    wanted.push((index, k));
                }
            }
        }
        self.work += wanted.iter().map(|&(index, _)| self.views[index as usize].work()).sum::<u64>();
        let lights = watch.map(&wanted, |_, &(index, k)| {
            let (corner, point) = self.middle(index, k);
            let (low, high) = edge_key(&self.elements.elements[index as usize], k);
            (corner, self.look((&corner, point), &self.views[index as usize], [low, high]))
        })?;
        for (corner, found) in lights {
            self.keep(corner, &found);
        }
        debug_assert_eq!(self.elements.lit(), self.elements.corners.len());
        // 2. How far from linear they are.
        let errors: Vec<f64> = fresh.par_iter().map(|&index| self.error_of(index)).collect();
        for (&index, error) in fresh.iter().zip(errors) {
            self.errors[index as usize] = error;
        }
        Ok(())
    }

    /// The corner in the middle of an edge of an element, and where its light is looked for.
    fn middle(&self, index: u32, k: usize) -> (ElementCorner, DVec3) {
        let element = &self.elements.elements[index as usize];
        let [a, b, c] =
            [k, (k + 1) % 3, (k + 2) % 3].map(|k| self.elements.corners[element.corners[k] as usize]);
        let position = 0.5 * (a.position + b.position);
        let corner = ElementCorner { position, normal: (a.normal + b.normal).normalize_or(a.normal) };
        let is_border = self.borders.contains(&edge_key(element, k));
        let point = if is_border {
            inside(position, (a.position + b.position + c.position) / 3.0, self.inset)
        } else {
            position
        };
        (corner, point)
    }

    /// The squared error of a leaf, relative to the mean and to the light there alike, times its share of the area.
    fn error_of(&self, index: u32) -> f64 {
        let views = &self.views[index as usize];
        let element = &self.elements.elements[index as usize];
        if views.is_dark() || views.is_sampled() || self.mean <= 0.0 {
            return 0.0;
        }
        let (mut square, mut count) = (0.0, 0.0);
        let mut differs = false;
        for k in 0..3 {
            let Some(&middle) = self.middles.get(&edge_key(element, k)) else { continue };
            let ends = [element.corners[k], element.corners[(k + 1) % 3]];
            let (off, here) = self.difference(middle, ends);
            square += off * off / self.scale(here);
            count += 1.0;
            differs |= off > NOTABLE * (here + FAINT * self.mean);
        }
        let area = self.elements.area(element);
        let mut error = square / f64::max(count, 1.0) * area;
        if !differs && !views.is_clear() {
            let cell = self.elements.positions(element);
            let normal = self.elements.corners[element.corners[0] as usize].normal;
            let exitance = &self.settings.exitance;
            let corners = element.corners.iter();
            let here = corners.map(|&corner| self.elements.watts_at(corner, exitance)).sum::<f64>() / 3.0;
            let shadow =
                with_scratch(|scratch| self.light.possible_shadow(cell, normal, views, exitance, scratch));
            // Nothing can be darker than dark.
            error += shadow.min(here * here * area) * POSSIBLE / self.scale(here);
        }
        error / self.area.max(f64::MIN_POSITIVE)
    }

    /// What a squared error is divided by where there is so much light: a spot beside a lamp is neither to take all
    /// elements, as by its absolute error it would, nor none, being small.
    fn scale(&self, here: f64) -> f64 {
        (here + FAINT * self.mean) * self.mean
    }

    /// By how much the light in the middle of an edge differs from the mean of that at its ends, and how much there is.
    fn difference(&self, middle: u32, ends: [u32; 2]) -> (f64, f64) {
        let mut differences: Light = self.elements.light_at(middle).to_vec();
        let watts = |basis: u32, value: f32| f64::from(value) * self.settings.exitance[basis as usize];
        let here: f64 = differences.iter().map(|&(basis, value)| watts(basis, value)).sum();
        for end in ends {
            for &(basis, value) in self.elements.light_at(end) {
                match differences.binary_search_by_key(&basis, |entry| entry.0) {
                    Ok(at) => differences[at].1 -= 0.5 * value,
                    Err(at) => differences.insert(at, (basis, -0.5 * value)),
                }
            }
        }
        (differences.iter().map(|&(basis, difference)| watts(basis, difference).abs()).sum(), here)
    }

    /// What the squared error of a leaf counts, for those who look on.
    fn weight(&self, index: usize) -> f64 {
        let Some(focus) = &self.settings.focus else { return 1.0 };
        match self.open[index] {
            true => focus.weight(&self.elements, &self.elements.elements[index], self.area),
            false => 1.0 - Focus::OF_PIXELS,
        }
    }

    /// The leaves that make up most of the squared error; none once that is small enough.
    fn worst(&mut self) -> Vec<u32> {
        let elements = &self.elements.elements;
        let mut ranked: Vec<(f64, u32)> = (0..elements.len())
            .filter(|&index| elements[index].children == NO_ELEMENT && self.errors[index] > 0.0)
            .map(|index| (self.errors[index] * self.weight(index), index as u32))
            .collect();
        ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let whole: f64 = ranked.iter().map(|entry| entry.0).sum();
        let by_area: f64 = ranked.iter().map(|entry| self.errors[entry.1 as usize]).sum();
        // Each division adds one; what neighbours need comes on top.
        let added = (elements.len() - self.whole) / 2;
        self.elements.expected_error = by_area.sqrt();
        let room = self.settings.most.saturating_sub(added) / 3;
        let most = self.settings.error * self.settings.error;
        let is_good =
            whole <= most || whole <= most * NEARLY * NEARLY && self.work >= self.settings.work / DEAR;
        if is_good || room == 0 || self.work >= self.settings.work {
            return Vec::new();
        }
        let mut sum = 0.0;
        let mut marked = Vec::new();
        for (error, index) in ranked {
            if sum >= BULK * whole || marked.len() >= room {
                break;
            }
            sum += error;
            if self.longest_edge(index).1 > self.shortest {
                marked.push(index);
            }
        }
        marked
    }

    /// The longest edge of an element and its length, metres; of equal ones always the same, from both sides.
    fn longest_edge(&self, index: u32) -> (usize, f64) {
        let element = &self.elements.elements[index as usize];
        let length = |k: usize| {
            let (a, b) = edge_key(element, k);
            self.elements.corners[a as usize].position.distance(self.elements.corners[b as usize].position)
        };
        let mut best = (0, length(0));
        for k in 1..3 {
            let new = length(k);
            let is_equal = (new - best.1).abs() <= 1e-9 * best.1;
            if !is_equal && new > best.1 || is_equal && edge_key(element, k) > edge_key(element, best.0) {
                best = (k, new);
            }
        }
        best
    }

    /// Divides these leaves and what else must be so that no corner lies within an edge. Returns the new leaves.
    fn divide(&mut self, marked: &[u32], mesh: &PatchMesh) -> Vec<u32> {
        // 1. Edges to divide: the longest of each leaf, and of each leaf that has one of them.
        let mut owners: HashMap<(u32, u32), [u32; 2]> = HashMap::new();
        for (index, element) in self.elements.elements.iter().enumerate() {
            // Small facets have no neighbours of their plane that are not small.
            if element.children != NO_ELEMENT || self.views[index].is_sampled() {
                continue;
            }
            for k in 0..3 {
                let owners = owners.entry(edge_key(element, k)).or_insert([NO_ELEMENT; 2]);
                owners[usize::from(owners[0] != NO_ELEMENT)] = index as u32;
            }
        }
        let mut to_divide: HashSet<(u32, u32)> = HashSet::new();
        let mut touched: Vec<u32> = Vec::new();
        let mut is_touched: HashSet<u32> = HashSet::new();
        let mut waiting: Vec<u32> = marked.to_vec();
        while let Some(index) = waiting.pop() {
            if is_touched.insert(index) {
                touched.push(index);
            }
            let (k, _) = self.longest_edge(index);
            let key = edge_key(&self.elements.elements[index as usize], k);
            if to_divide.insert(key) {
                waiting.extend(
                    owners.get(&key).into_iter().flatten().filter(|&&o| o != NO_ELEMENT && o != index),
                );
            }
        }
        touched.sort_unstable();
        // 2. Middles that nobody has looked at: of leaves that are dark or are divided for a neighbour's sake.
        for &index in &touched {
            let element = self.elements.elements[index as usize];
            for k in 0..3 {
                let key = edge_key(&element, k);
                if to_divide.contains(&key) && !self.middles.contains_key(&key) {
                    let (corner, point) = self.middle(index, k);
                    let views = self.views[index as usize].clone();
                    let found = self.look((&corner, point), &views, [key.0, key.1]);
                    self.middles.insert(key, self.elements.corners.len() as u32);
                    self.keep(corner, &found);
                }
            }
        }
        // 3. Across the longest edge first, then across what is left to divide.
        let first = self.elements.elements.len();
        let mut parents: Vec<u32> = vec![NO_ELEMENT; 0];
        let mut queue: Vec<(u32, u32)> = touched.iter().map(|&index| (index, index)).collect();
        let mut fresh = Vec::new();
        let mut at = 0;
        while at < queue.len() {
            let (index, parent) = queue[at];
            at += 1;
            let element = self.elements.elements[index as usize];
            let (longest, _) = self.longest_edge(index);
            let order = [longest, (longest + 1) % 3, (longest + 2) % 3];
            let Some(edge) = order.into_iter().find(|&k| to_divide.contains(&edge_key(&element, k))) else {
                if index as usize >= first {
                    fresh.push(index);
                }
                continue;
            };
            let key = edge_key(&element, edge);
            let middle = self.middles[&key];
            if self.borders.contains(&key) {
                self.borders.insert((key.0.min(middle), key.0.max(middle)));
                self.borders.insert((key.1.min(middle), key.1.max(middle)));
            }
            let children = self.elements.elements.len() as u32;
            self.elements.divide(index, edge, middle);
            parents.extend([parent; 2]);
            queue.extend([(children, parent), (children + 1, parent)]);
        }
        // 4. What the new ones may see: looked for anew in a quarter of the area.
        let narrowed: Vec<(Arc<Views>, f64)> = self.elements.elements[first..]
            .par_iter()
            .zip(&parents)
            .map(|(element, &parent)| {
                let (views, seen_from) = (&self.views[parent as usize], self.seen_from[parent as usize]);
                let area = self.elements.area(element);
                if element.children != NO_ELEMENT || views.is_clear() || area > NARROWED * seen_from {
                    return (views.clone(), seen_from);
                }
                let normal = self.elements.normal(element, mesh);
                let cell = self.elements.positions(element);
                let narrowed = with_scratch(|scratch| self.light.narrowed(views, &cell, normal, scratch));
                (Arc::new(narrowed), area)
            })
            .collect();
        for (views, seen_from) in narrowed {
            self.views.push(views);
            self.seen_from.push(seen_from);
        }
        if !self.open.is_empty() {
            self.open.extend(parents.iter().map(|&parent| self.open[parent as usize]).collect::<Vec<_>>());
        }
        self.errors.resize(self.elements.elements.len(), 0.0);
        fresh
    }
}
