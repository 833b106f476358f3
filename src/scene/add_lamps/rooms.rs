//! Rooms: spaces joined to each other, split where only a narrow passage joins them.

use super::plan::{Kind, Plan};
use glam::DVec2;
use std::collections::VecDeque;

/// Passages narrower than twice this divide rooms, metres.
const PASSAGE: f64 = 0.65;
/// Less is a gap in a wall or a shaft: floor area in m², and metres from its middle to its side.
const SMALLEST: f64 = 1.2;
const NARROWEST: f64 = 0.35;
/// A room that fills so much of the rectangle around it gets its lamps in rows.
const RECTANGULAR: f64 = 0.85;
/// Rounds in which lamps settle in a room of another shape.
const ROUNDS: usize = 12;

/// A room, or a court.
pub(super) struct Room {
    /// Indices of its spaces, rising.
    pub(super) spaces: Vec<u32>,
    /// Of each space, metres to the nearest side.
    pub(super) depths: Vec<f64>,
    /// m².
    pub(super) area: f64,
    /// Median heights along the up axis, metres.
    pub(super) floor: f64,
    pub(super) ceiling: f64,
}

/// The rooms of a kind, in a stable order.
pub(super) fn find(plan: &Plan, kind: Kind) -> Vec<Room> {
    let mut rooms = Vec::new();
    let mut seen = vec![false; plan.spaces.len()];
    let depths = depths(plan);
    let mut scratch = (vec![false; plan.spaces.len()], vec![u32::MAX; plan.spaces.len()]);
    for start in 0..plan.spaces.len() as u32 {
        if seen[start as usize] || plan.spaces[start as usize].kind != kind {
            continue;
        }
        let whole = flood(start, &mut seen, |space| plan.links[space as usize].iter().copied());
        let parts = split(plan, &whole, &depths, (&mut scratch.0, &mut scratch.1));
        rooms.extend(parts.into_iter().filter_map(|spaces| {
            let room = Room::new(plan, spaces, &depths);
            let deepest = room.depths.iter().copied().fold(0.0, f64::max);
            let smallest = SMALLEST * plan.scale * plan.scale;
            let is_high = room.ceiling - room.floor >= plan.headroom;
            (room.area >= smallest && deepest >= NARROWEST * plan.scale && is_high).then_some(room)
        }));
    }
    rooms
}

/// All that is joined to `start`.
fn flood<I: Iterator<Item = u32>>(start: u32, seen: &mut [bool], beside: impl Fn(u32) -> I) -> Vec<u32> {
    let mut found = vec![start];
    seen[start as usize] = true;
    let mut next = 0;
    while next < found.len() {
        for other in beside(found[next]) {
            if !std::mem::replace(&mut seen[other as usize], true) {
                found.push(other);
            }
        }
        next += 1;
    }
    found
}

/// Metres from each space to the nearest side of what it is joined to.
fn depths(plan: &Plan) -> Vec<f64> {
    let mut steps = vec![u32::MAX; plan.spaces.len()];
    let mut waiting: VecDeque<u32> = VecDeque::new();
    for (space, links) in plan.links.iter().enumerate() {
        if links.len() < 4 {
            steps[space] = 0;
            waiting.push_back(space as u32);
        }
    }
    while let Some(space) = waiting.pop_front() {
        for &other in &plan.links[space as usize] {
            if steps[other as usize] == u32::MAX {
                steps[other as usize] = steps[space as usize] + 1;
                waiting.push_back(other);
            }
        }
    }
    steps.into_iter().map(|n| (f64::from(n) + 0.5) * plan.cell).collect()
}

/// Splits what is joined at narrow passages: what is left of it away from its sides falls apart there, and
/// each part takes what is nearest to it.
fn split(
    plan: &Plan,
    whole: &[u32],
    depths: &[f64],
    (seen, part): (&mut [bool], &mut [u32]),
) -> Vec<Vec<u32>> {
    let is_core = |space: &u32| depths[*space as usize] > PASSAGE * plan.scale;
    let mut waiting = VecDeque::new();
    let mut parts: Vec<Vec<u32>> = Vec::new();
    for &start in whole.iter().filter(|space| is_core(space)) {
        if seen[start as usize] {
            continue;
        }
        let core = flood(start, seen, |space| plan.links[space as usize].iter().copied().filter(is_core));
        for &space in &core {
            part[space as usize] = parts.len() as u32;
        }
        waiting.extend(core.iter().copied());
        parts.push(core);
    }
    if parts.len() < 2 {
        return vec![whole.to_vec()];
    }
    while let Some(space) = waiting.pop_front() {
        for &other in &plan.links[space as usize] {
            if part[other as usize] == u32::MAX {
                part[other as usize] = part[space as usize];
                parts[part[space as usize] as usize].push(other);
                waiting.push_back(other);
            }
        }
    }
    parts
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

impl Room {
    fn new(plan: &Plan, mut spaces: Vec<u32>, depths: &[f64]) -> Self {
        spaces.sort_unstable();
        let of = |value: fn(&super::plan::Space) -> f64| {
            median(spaces.iter().map(|&s| value(&plan.spaces[s as usize])).collect())
        };
        Self {
            area: spaces.len() as f64 * plan.cell * plan.cell,
            floor: of(|space| space.floor),
            ceiling: of(|space| space.ceiling),
            depths: spaces.iter().map(|&s| depths[s as usize]).collect(),
            spaces,
        }
    }

    fn level(&self, plan: &Plan, index: usize) -> DVec2 {
        plan.level(plan.spaces[self.spaces[index] as usize].cell as usize)
    }

    /// Where `wanted` lamps would light it evenly: level coordinates, not all of them inside.
    pub(super) fn targets(&self, plan: &Plan, wanted: usize) -> Vec<DVec2> {
        let places: Vec<DVec2> = (0..self.spaces.len()).map(|k| self.level(plan, k)).collect();
        let half = DVec2::splat(0.5 * plan.cell);
        let low = places.iter().fold(DVec2::INFINITY, |low, &at| low.min(at)) - half;
        let high = places.iter().fold(DVec2::NEG_INFINITY, |high, &at| high.max(at)) + half;
        let size = high - low;
        if self.area >= RECTANGULAR * size.x * size.y {
            let across = ((wanted as f64 * size.x / size.y).sqrt().round() as usize).clamp(1, wanted);
            let along = wanted.div_ceil(across);
            let at = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
            return (0..across * along)
                .map(|k| low + size * DVec2::new(at(k % across, across), at(k / across, along)))
                .collect();
        }
        settled(&places, wanted)
    }

    /// Its spaces well away from the sides and below the usual ceiling, the nearest to `target` first.
    pub(super) fn nearest(&self, plan: &Plan, target: DVec2) -> impl Iterator<Item = usize> + use<> {
        let deepest = self.depths.iter().copied().fold(0.0, f64::max);
        let deep = (0.6 * deepest).min(0.6 * plan.scale);
        let usual = 0.15 * plan.scale;
        let mut found: Vec<(f64, usize)> = (0..self.spaces.len())
            .filter(|&k| self.depths[k] >= deep)
            // Not above a cupboard.
            .filter(|&k| plan.spaces[self.spaces[k] as usize].floor <= self.floor + plan.scale)
            .map(|k| {
                let space = self.spaces[k] as usize;
                let ceiling = plan.spaces[space].ceiling;
                // Under a beam or a lowered part only where nothing else is left.
                let odd = self.ceiling.is_finite() && ceiling < self.ceiling - usual;
                let apart = self.level(plan, k).distance(target);
                (if odd { 1e6 + apart } else { apart }, space)
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, space)| space)
    }
}

/// Middles of `wanted` parts of about equal area (Lloyd 1982), begun with the farthest points.
fn settled(places: &[DVec2], wanted: usize) -> Vec<DVec2> {
    let mean = |of: &[DVec2]| of.iter().sum::<DVec2>() / of.len().max(1) as f64;
    let mut middles = vec![mean(places)];
    while middles.len() < wanted {
        let apart =
            |at: &DVec2| middles.iter().map(|m| m.distance_squared(*at)).fold(f64::INFINITY, f64::min);
        let Some(farthest) = places.iter().max_by(|a, b| apart(a).total_cmp(&apart(b))) else { break };
        middles.push(*farthest);
    }
    for _ in 0..ROUNDS {
        let mut sums = vec![(DVec2::ZERO, 0.0_f64); middles.len()];
        for &at in places {
            let nearest = (0..middles.len())
                .min_by(|&a, &b| middles[a].distance_squared(at).total_cmp(&middles[b].distance_squared(at)));
            if let Some(k) = nearest {
                (sums[k].0, sums[k].1) = (sums[k].0 + at, sums[k].1 + 1.0);
            }
        }
        for (middle, (sum, count)) in middles.iter_mut().zip(sums) {
            if count > 0.0 {
                *middle = sum / count;
            }
        }
    }
    middles
}
