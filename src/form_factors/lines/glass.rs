//! Spans that are seen through panes of glass, and mirrored by them.

use super::{Fan, Interval, LineSampler, SHORTEST, Viewpoint, weight_of};
use crate::form_factors::RowBuffer;
use crate::geometry::Frame;
use crate::mesh::{NO_PATCH, Perforated};
use crate::scene::luminance_weighted;
use crate::visibility::{Glass, Occluders};
use glam::DVec3;

/// Spans are cut into parts of so much x, of 2 over the whole hemisphere: what passes then is right to 3e-4 (tested).
const LONGEST: f64 = 0.25;
/// Among more panes than this on a half-plane the order in the middle between two edges stands for all.
const MANY: usize = 8;
/// What a pane of a smaller form factor mirrors is left out.
const LEAST_MIRROR: f64 = 5e-4;

impl LineSampler {
    /// Forgets what was seen; there are so many half-planes.
    pub(super) fn clear(&mut self, half_planes: usize) {
        self.seen.clear();
        self.missed.clear();
        self.pieces.clear();
        self.open.clear();
        for lines in [&mut self.lines, &mut self.panes] {
            lines.resize_with(half_planes, Vec::new);
            lines.iter_mut().for_each(Vec::clear);
        }
        if self.counts.len() < half_planes {
            self.counts.resize(half_planes, 0);
        }
    }

    /// The weight of a part of a visible span less what the panes before it take, each by its own angle.
    pub(super) fn dimmed(
        &self,
        glass: &Glass,
        interval: &Interval,
        [start, end]: [f64; 2],
        weight: f64,
    ) -> f64 {
        if self.before.is_empty() {
            return weight;
        }
        if !self.profile.is_empty() {
            return self.profile.dimmed(interval, [start, end], weight);
        }
        let mut sum = 0.0;
        let mut from = start;
        while from < end {
            // Up to where the next pane begins or ends, or cuts through the surface behind it, and no longer than
            // two points of its angle tell.
            let mut to = end.min(from + LONGEST);
            for pane in &self.before {
                let meet = (pane.w0 - interval.w0) / (interval.w1 - pane.w1);
                for x in [pane.start, pane.end, meet] {
                    if x > from + SHORTEST && x < to {
                        to = x;
                    }
                }
            }
            let middle = 0.5 * (from + to);
            let stands = |pane: &&Interval| {
                pane.start <= middle && middle <= pane.end && pane.w(middle) > interval.w(middle)
            };
            let weight = weight_of(to) - weight_of(from);
            if self.before.iter().any(|pane| stands(&pane)) {
                // The angle changes along it: Gauss's two points.
                let passed: f64 = [0.211_324_865_405_187, 0.788_675_134_594_813]
                    .iter()
                    .map(|share| {
                        // Evenly by weight, of which this is the inverse.
                        let at = weight_of(from) + share * weight;
                        let x = 2.0 * at / (1.0 + (1.0 - 4.0 * at * at).max(0.0).sqrt());
                        // Length of the direction whose depth w measures.
                        let length = (0.5 * (1.0 + x * x)).sqrt();
                        let mut passed = [1.0; 3];
                        for pane in self.before.iter().filter(stands) {
                            let Some((index, to_plane)) = self.seen[pane.seen as usize].pane else {
                                continue;
                            };
                            let cos = pane.w(x) * to_plane / length;
                            let pane = &glass.panes().list[index as usize];
                            let own = match self.is_mirror {
                                true => glass.reflectance(pane, cos),
                                false => glass.transmittance(pane, cos),
                            };
                            passed.iter_mut().zip(own).for_each(|(passed, own)| *passed *= own);
                        }
                        luminance_weighted(passed)
                    })
                    .sum();
                sum += 0.5 * passed * weight;
            } else {
                sum += weight;
            }
            from = to;
        }
        sum
    }

    /// Notes which parts of the panes on the half-plane at hand are seen: nothing solid stands before them.
    pub(super) fn note_open_panes(&mut self, glass: &Glass, line: u32) {
        for pane in &self.before {
            // Among many only glass is looked at, which mirrors.
            if !self.profile.is_empty() && self.perforated(glass, pane.seen).is_some() {
                continue;
            }
            let mut from = pane.start;
            while from < pane.end {
                let mut to = pane.end;
                for solid in &self.solid {
                    let meet = (pane.w0 - solid.w0) / (solid.w1 - pane.w1);
                    for x in [solid.start, solid.end, meet] {
                        if x > from + SHORTEST && x < to {
                            to = x;
                        }
                    }
                }
                let middle = 0.5 * (from + to);
                let hides = |solid: &Interval| {
                    solid.start <= middle && middle <= solid.end && solid.w(middle) >= pane.w(middle)
                };
                if to - from > SHORTEST && !self.solid.iter().any(hides) {
                    self.open.push((line, Interval { start: from, end: to, ..*pane }));
                }
                from = to;
            }
        }
    }

    /// Hands the visible parts of surfaces with holes on a half-plane to their patches: their opaque share, less what panes
    /// before them take.
    pub(super) fn add_perforated(&mut self, glass: &Glass, line: u32) {
        let has_patch = |&(patch, _): &(u32, f64)| patch != NO_PATCH;
        let mut pieces = std::mem::take(&mut self.pieces);
        if self.profile.is_empty() {
            let first = self.open.partition_point(|open| open.0 < line);
            for (_, part) in &self.open[first..] {
                if let Some((patch, opacity)) = self.perforated(glass, part.seen).filter(has_patch) {
                    let weight = weight_of(part.end) - weight_of(part.start);
                    let share = self.dimmed(glass, part, [part.start, part.end], weight);
                    pieces.push((patch, opacity * share, part.seen));
                }
            }
        } else {
            self.profile.each_open(&self.solid, |open| {
                if let Some((patch, opacity)) = self.perforated(glass, open.seen).filter(has_patch) {
                    pieces.push((patch, opacity * open.weight, open.seen));
                }
            });
        }
        self.pieces = pieces;
    }

    /// Of a surface with holes the patch that is seen, [`NO_PATCH`] where there is none, and the share that is opaque.
    fn perforated(&self, glass: &Glass, seen: u32) -> Option<(u32, f64)> {
        let seen = &self.seen[seen as usize];
        let Perforated { patches, opacity } = glass.panes().list[seen.pane?.0 as usize].perforated?;
        Some((patches[seen.side as usize], opacity))
    }

    /// Readies what the panes on the half-plane at hand leave, where they are many.
    pub(super) fn profile_panes(&mut self, glass: &Glass) {
        let mut profile = std::mem::take(&mut self.profile);
        profile.clear();
        if self.before.len() > MANY {
            profile.build(&self.before, |pane, x| {
                let Some((index, to_plane)) = self.seen[pane.seen as usize].pane else { return 1.0 };
                let cos = pane.w(x) * to_plane / (0.5 * (1.0 + x * x)).sqrt();
                luminance_weighted(glass.transmittance(&glass.panes().list[index as usize], cos))
            });
        }
        self.profile = profile;
    }

    /// Adds what panes mirror to the row, each by its own angle: the spans that a receiver behind the pane would see
    /// through it, in half-planes that are the mirrored ones (extended form factors: Wallace, Cohen & Greenberg 1987;
    /// Sillion & Puech 1989). What is mirrored twice, and what other panes take on the way, is left out.
    pub(super) fn add_mirrored(
        &mut self,
        (scene, glass): (&Occluders, &Glass),
        fan: &Fan,
        (from, frame): (&Viewpoint, &Frame),
        row: &mut RowBuffer,
    ) {
        let per_line = 1.0 / fan.len() as f64;
        let mut open = std::mem::take(&mut self.open);
        let mut mirror = self.mirror.take().unwrap_or_default();
        mirror.is_mirror = true;
        // In the order of half-planes within each pane, as they were found.
        open.sort_by_key(|(_, part)| part.seen);
        for parts in open.chunk_by(|a, b| a.1.seen == b.1.seen) {
            let weight: f64 = parts.iter().map(|(_, part)| weight_of(part.end) - weight_of(part.start)).sum();
            let seen = self.seen[parts[0].1.seen as usize];
            let Some((pane, to_plane)) = seen.pane.filter(|_| weight * per_line >= LEAST_MIRROR) else {
                continue;
            };
            let pane = &glass.panes().list[pane as usize];
            if pane.perforated.is_some() {
                continue;
            }
            let mirrored = |v: DVec3| v - 2.0 * pane.normal.dot(v) * pane.normal;
            let point = from.point + 2.0 * to_plane * pane.normal;
            let [tangent, bitangent, normal] = [frame.tangent, frame.bitangent, frame.normal].map(mirrored);
            let frame = Frame { tangent, bitangent, normal };
            // 1. What may be seen through the pane from behind it, on the receiver's side.
            let middle = pane.corners.iter().sum::<DVec3>() / pane.corners.len() as f64;
            let before = -to_plane.signum() * pane.normal;
            let mut planes = vec![(before, before.dot(middle)), (normal, normal.dot(point))];
            for (k, &a) in pane.corners.iter().enumerate() {
                let b = pane.corners[if k + 1 == pane.corners.len() { 0 } else { k + 1 }];
                let edge = (a - point).cross(b - point).normalize_or_zero();
                let edge = if edge.dot(middle - point) < 0.0 { -edge } else { edge };
                planes.push((edge, edge.dot(point)));
            }
            mirror.clear(fan.len());
            let mut candidates = std::mem::take(&mut mirror.candidates);
            scene.culling.within(&planes, &mut candidates);
            for &index in candidates.iter().filter(|&&index| scene.regions[index as usize].pane.is_none()) {
                mirror.cut_region((scene, glass), fan, index as usize, (point, from.viewer), &frame);
            }
            mirror.candidates = candidates;
            // 2. Spans within the visible parts of the pane and beyond it. The pane is its own image.
            let own = mirror.seen.len() as u32;
            mirror.seen.push(seen);
            for parts in parts.chunk_by(|a, b| a.0 == b.0) {
                let k = parts[0].0 as usize;
                let line = std::mem::take(&mut mirror.lines[k]);
                for (_, part) in parts {
                    let part = Interval { seen: own, ..*part };
                    let mut within: Vec<Interval> =
                        line.iter().filter_map(|interval| beyond(&part, interval)).collect();
                    mirror.before.clear();
                    mirror.before.push(part);
                    mirror.sweep((scene, glass), &mut within, fan.directions[k]);
                }
                mirror.lines[k] = line;
            }
            mirror.before.clear();
            for &(patch, amount, _) in &mirror.pieces {
                row.add(patch, amount * per_line);
            }
        }
        self.mirror = Some(mirror);
        self.open = open;
    }
}

/// The part of an interval within a part of a pane, and farther away.
fn beyond(pane: &Interval, interval: &Interval) -> Option<Interval> {
    let (mut start, mut end) = (interval.start.max(pane.start), interval.end.min(pane.end));
    // Depths are linear: it is nearer than the pane on one side of where they meet.
    let (f0, f1) = (pane.w0 - interval.w0, pane.w1 - interval.w1);
    let meet = -f0 / f1;
    if f1 > 0.0 {
        start = start.max(meet);
    } else if f1 < 0.0 {
        end = end.min(meet);
    } else if f0 <= 0.0 {
        return None;
    }
    (end - start > SHORTEST).then_some(Interval { start, end, ..*interval })
}
