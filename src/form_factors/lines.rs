//! Line sampling: visible spans found exactly along half-planes through the normal.
//!
//! The hemicube of 1985 samples visibility at cell centres. Here it is sampled along lines: each
//! half-plane that the receiver's normal bounds is cut with every region, the cuts are intervals,
//! and one sweep over them finds the visible spans exactly. With theta the angle from the normal, a
//! span seen in a half-plane contributes, as dF = cos(theta) sin(theta) dtheta dphi / pi,
//!
//!   (sin²(theta_1) - sin²(theta_0)) / N
//!
//! where N half-planes stand for 2 pi of azimuth. Only the azimuth is sampled. Against the
//! scanlines of a cube this needs neither five faces nor an arctangent, and spaces its lines more
//! closely towards the normal, where the weight is.
//!
//! Along a half-plane, radius R and height H over the receiver, a direction is named by
//! x = (R - H) / (R + H): -1 along the normal, +1 on the horizon. Then
//! sin²(theta) = 1/2 + x / (1 + x²), and the reciprocal 1 / (R + H) of a plane's depth and all plane
//! coordinates times it are linear in x. An edge seen from the receiver has cot(theta) =
//! p cos(phi) + q sin(phi), with p and q from the cross product of its ends: no division a crossing.

mod fan;
mod glass;
mod profile;

pub use fan::Fan;

use self::profile::Profile;
use super::row::RowBuffer;
use crate::geometry::Frame;
use crate::mesh::{NO_PATCH, Side};
use crate::visibility::{Cell, Glass, Occluders, Viewer};
use glam::DVec3;
use std::f64::consts::TAU;

/// One region's cut with one half-plane: x from `start` to `end`, 1/depth = w0 + w1 x.
#[derive(Clone, Copy, Debug)]
struct Interval {
    start: f64,
    end: f64,
    w0: f64,
    w1: f64,
    /// Index into [`LineSampler::seen`].
    seen: u32,
}

impl Interval {
    fn w(&self, x: f64) -> f64 {
        self.w0 + self.w1 * x
    }

    /// Whether this one stands before `other` from `x` to the other's end: depths are linear, so both
    /// ends tell.
    fn hides(&self, other: &Self, x: f64) -> bool {
        self.end >= other.end && self.w(x) >= other.w(x) && self.w(other.end) >= other.w(other.end)
    }
}

/// A region above the horizon, in the receiver's frame.
#[derive(Clone, Copy, Debug)]
struct Seen {
    region: u32,
    side: Side,
    /// Grid axes, and the grid coordinates of the receiver itself (negated).
    u: [f64; 3],
    v: [f64; 3],
    u_offset: f64,
    v_offset: f64,
    /// What its spans are scaled by: the closed form over `total`.
    ratio: f64,
    /// The hidden fraction of what it covers; none where it emits or is not seen.
    doubt: Option<f64>,
    /// Half-planes that met it.
    met: u32,
    /// Sums of its intervals and of the visible ones among them.
    total: f64,
    visible: f64,
    /// Of a pane its index, and the receiver's height below its plane, metres.
    pane: Option<(u32, f64)>,
}

/// Where a row is gathered.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// The receiving point, metres.
    pub point: DVec3,
    /// Its normal is the receiver's.
    pub frame: Frame,
    /// Shifts the half-planes by this fraction of their spacing, 0 to 1.
    pub turn: f64,
    /// Decides what hides.
    pub viewer: Viewer,
}

/// Scratch space for rows; one a thread.
#[derive(Clone, Debug, Default)]
pub struct LineSampler {
    local: Vec<DVec3>,
    azimuth: Vec<f64>,
    seen: Vec<Seen>,
    lines: Vec<Vec<Interval>>,
    /// Cuts with panes of glass, which hide nothing.
    panes: Vec<Vec<Interval>>,
    /// Crossings of the present region, `stride` slots a half-plane.
    crossings: Vec<f64>,
    counts: Vec<u32>,
    touched: Vec<u32>,
    active: Vec<Interval>,
    /// Those of the half-plane at hand.
    before: Vec<Interval>,
    /// What they leave along it, where they are many.
    profile: Profile,
    /// What is seen on it behind them: solid spans.
    solid: Vec<Interval>,
    /// Visible parts of panes, each with its half-plane.
    open: Vec<(u32, Interval)>,
    /// What panes mirror is looked for by another one, whose spans count by what `before` mirrors.
    mirror: Option<Box<Self>>,
    is_mirror: bool,
    /// Patch, weight and region of every visible part.
    pieces: Vec<(u32, f64, u32)>,
    /// Regions that may be seen from the present point.
    candidates: Vec<u32>,
    /// Lamps above the horizon that no half-plane met.
    missed: Vec<u32>,
}

/// Regions met by fewer half-planes are not scaled to their closed form.
const FEWEST: u32 = 3;
/// Intervals shorter than this in x carry nothing.
const SHORTEST: f64 = 1e-13;

impl LineSampler {
    /// Adds the form factors from a point to every patch to `row`.
    ///
    /// Lamps above the horizon that fell between two half-planes are handed to `add_missed`, by region:
    /// it adds the form factors to their patches to the row and returns their sum.
    pub fn gather(
        &mut self,
        (scene, glass): (&Occluders, &Glass),
        fan: &Fan,
        from: &Viewpoint,
        row: &mut RowBuffer,
        mut add_missed: impl FnMut(u32, &mut RowBuffer) -> f64,
    ) {
        let n = fan.directions.len();
        let &Viewpoint { point, turn, viewer, .. } = from;
        let frame = from.frame.turned(turn * TAU / n as f64);
        self.clear(n);
        let mut candidates = std::mem::take(&mut self.candidates);
        let near = [scene.contact(), scene.thickness()];
        scene.culling.candidates(point, frame.normal, near, &mut candidates);
        for &index in &candidates {
            self.cut_region((scene, glass), fan, index as usize, (point, viewer), &frame);
        }
        self.candidates = candidates;
        let per_line = 1.0 / n as f64;
        for k in 0..n {
            let mut line = std::mem::take(&mut self.lines[k]);
            std::mem::swap(&mut self.before, &mut self.panes[k]);
            self.solid.clear();
            self.profile_panes(glass);
            self.sweep((scene, glass), &mut line, fan.directions[k]);
            self.note_open_panes(glass, k as u32);
            self.add_perforated(glass, k as u32);
            std::mem::swap(&mut self.before, &mut self.panes[k]);
            self.lines[k] = line;
        }
        // The lines' own error on a whole region is known, and is taken out of its visible part.
        let (mut sky, mut others, mut doubtful) = (1.0, 0.0, 0.0);
        let mut lamps: f64 = self.missed.iter().map(|&region| add_missed(region, row)).sum();
        for seen in self.seen.iter_mut().filter(|seen| seen.visible > 0.0) {
            let region = &scene.regions[seen.region as usize];
            let emits = region.emits[seen.side as usize];
            // What so few half-planes meet is right in the mean as it was met: the closed form where it
            // was met, and nothing where it was missed, would take light from it. Lamps that are missed
            // have theirs by rays, so that each lamp counts by its closed form, met or missed: a globe
            // of thousands of facets is the sum of what these send.
            let often = seen.met >= FEWEST || emits;
            if let Some(exact) = often.then(|| scene.unoccluded(region, point, &frame)).flatten() {
                let ratio = exact / (seen.total.max(seen.visible) * per_line);
                seen.ratio = if emits { ratio } else { ratio.clamp(0.25, 4.0) };
            }
            let amount = seen.visible * per_line * seen.ratio;
            sky -= seen.visible * per_line;
            if emits {
                // A lamp's light is not shifted by what is missing elsewhere.
                seen.doubt = None;
                lamps += amount;
            } else {
                let hidden = 1.0 - seen.visible / seen.total;
                seen.doubt = Some(hidden);
                others += amount;
                doubtful += amount * hidden;
            }
        }
        // All that is seen and the sky make up one: what is left is shared by the sky and by what is
        // hidden in part, for which the closed form is but an estimate; what that cannot take, by all.
        let left = 1.0 - sky - lamps - others;
        let share = (left / (doubtful + sky).max(f64::MIN_POSITIVE)).clamp(-0.25, 0.25);
        let rest = (1.0 - lamps - sky * (1.0 + share)) / (others + share * doubtful).max(f64::MIN_POSITIVE);
        for seen in &mut self.seen {
            if let Some(doubt) = seen.doubt {
                seen.ratio *= (1.0 + share * doubt) * rest.clamp(0.5, 2.0);
            }
        }
        for &(patch, amount, seen) in &self.pieces {
            row.add(patch, amount * per_line * self.seen[seen as usize].ratio);
        }
        if !self.open.is_empty() {
            self.add_mirrored((scene, glass), fan, (from, &frame), row);
        }
    }

    /// Finds the intervals of one region on all half-planes.
    fn cut_region(
        &mut self,
        (scene, glass): (&Occluders, &Glass),
        fan: &Fan,
        index: usize,
        (point, viewer): (DVec3, Viewer),
        frame: &Frame,
    ) {
        let region = &scene.regions[index];
        let contact = scene.contact();
        // 1. Skip what lies below the horizon or edge-on.
        let middle = region.middle - point;
        if frame.normal.dot(middle) + frame.normal.abs().dot(region.half) <= contact {
            return;
        }
        let to_plane = region.normal.dot(region.origin - point);
        let side = if to_plane < 0.0 { Side::Front } else { Side::Back };
        let passed_over = viewer == Viewer::LitSurface && region.dark[side as usize];
        let is_edge_on = to_plane.is_nan() || to_plane.abs() <= contact;
        // What panes leave of the light between a receiver and what lies behind them.
        let is_clear = |pane: u32| !glass.panes().list[pane as usize].dims[side as usize];
        let is_covered = || scene.is_covered(region, to_plane, frame.normal);
        if is_edge_on || passed_over || region.pane.is_some_and(is_clear) || is_covered() {
            return;
        }
        // 2. Corners in the receiver's frame, with their azimuth counted in half-planes.
        let n = fan.directions.len();
        let corners = region.vertices[0] as usize..region.vertices[1] as usize;
        self.local.clear();
        let mut highest = f64::NEG_INFINITY;
        for vertex in &scene.vertices[corners] {
            let p = frame.local(*vertex - point);
            highest = highest.max(p.z);
            self.local.push(p);
        }
        if highest <= contact {
            return;
        }
        self.azimuth.clear();
        let per_turn = n as f64 / TAU;
        self.azimuth.extend(self.local.iter().map(|p| p.y.atan2(p.x) * per_turn - 0.5));

        // 3. Where each edge crosses which half-planes.
        let edges = &scene.edges[region.edges[0] as usize..region.edges[1] as usize];
        let stride = edges.len();
        if self.crossings.len() < n * stride {
            self.crossings.resize(n * stride, 0.0);
        }
        self.touched.clear();
        let half_turn = 0.5 * n as f64;
        for &[a, b] in edges {
            let (p, q) = (self.local[a as usize], self.local[b as usize]);
            let m = p.cross(q);
            let (from, mut to) = (self.azimuth[a as usize], self.azimuth[b as usize]);
            // The short way round.
            if to - from > half_turn {
                to -= n as f64;
            } else if from - to > half_turn {
                to += n as f64;
            }
            let (first, end) = (from.min(to).ceil(), from.max(to).ceil());
            if first >= end {
                continue;
            }
            let scale = -1.0 / m.z;
            let (slope_x, slope_y) = (m.x * scale, m.y * scale);
            // A slope that is rounding error alone: the edge goes through the axis or ends on it, and is
            // met there, or points along the half-planes, and its crossing is held between its ends.
            let radial = m.z.abs() <= 1e-9 * (m.x.abs() + m.y.abs());
            let (mut on_axis, mut limits) = (None, [0.0; 2]);
            if radial {
                let (p_reach, q_reach) = (p.x.hypot(p.y), q.x.hypot(q.y));
                let (short, long) = (p_reach.min(q_reach), p_reach.max(q_reach));
                if p.x * q.x + p.y * q.y < 0.0 || short <= 1e-9 * long {
                    on_axis = Some(if p.z * q_reach + q.z * p_reach > 0.0 { -1.0 } else { 1.0 });
                }
                let (a, b) = (p.z / p_reach.max(f64::MIN_POSITIVE), q.z / q_reach.max(f64::MIN_POSITIVE));
                limits = [a.min(b), a.max(b)];
            }
            let mut k = (first as i64).rem_euclid(n as i64) as usize;
            for _ in 0..(end - first) as usize {
                let [cos, sin] = fan.directions[k];
                let mut cot = slope_x * cos + slope_y * sin;
                if radial {
                    cot = cot.max(limits[0]).min(limits[1]);
                }
                // NaN falls to the horizon.
                let x = on_axis.unwrap_or(if cot > 0.0 { (1.0 - cot) / (1.0 + cot) } else { 1.0 });
                let count = self.counts[k];
                if count == 0 {
                    self.touched.push(k as u32);
                }
                self.crossings[k * stride + count as usize] = if x.is_nan() { -1.0 } else { x };
                self.counts[k] = count + 1;
                k += 1;
                if k == n {
                    k = 0;
                }
            }
        }

        // 4. Pair the crossings of each half-plane.
        let normal = frame.local(region.normal);
        let axis_end = if to_plane * normal.z > 0.0 { -1.0 } else { 1.0 };
        // What lies on a part of its back stands before it.
        let behind = if region.is_set_back(side) { scene.thickness() } else { 0.0 };
        let inverse = 0.5 / (to_plane + behind);
        let seen = self.seen.len() as u32;
        let mut total = 0.0;
        for &k in &self.touched {
            let k = k as usize;
            let count = self.counts[k] as usize;
            self.counts[k] = 0;
            let slots = &mut self.crossings[k * stride..(k + 1) * stride];
            let [cos, sin] = fan.directions[k];
            let radial = normal.x * cos + normal.y * sin;
            let (w0, w1) = ((radial + normal.z) * inverse, (radial - normal.z) * inverse);
            let line = if region.pane.is_some() { &mut self.panes[k] } else { &mut self.lines[k] };
            let mut push = |start: f64, end: f64| {
                if end - start > SHORTEST {
                    total += weight_of(end) - weight_of(start);
                    line.push(Interval { start, end, w0, w1, seen });
                }
            };
            match count {
                1 => push(slots[0].min(axis_end), slots[0].max(axis_end)),
                2 => push(slots[0].min(slots[1]), slots[0].max(slots[1])),
                _ => {
                    let slots = &mut slots[..count];
                    slots.sort_unstable_by(f64::total_cmp);
                    if count.is_multiple_of(2) {
                        slots.chunks_exact(2).for_each(|c| push(c[0], c[1]));
                    } else if axis_end < 0.0 {
                        push(-1.0, slots[0]);
                        slots[1..].chunks_exact(2).for_each(|c| push(c[0], c[1]));
                    } else {
                        slots[..count - 1].chunks_exact(2).for_each(|c| push(c[0], c[1]));
                        push(slots[count - 1], 1.0);
                    }
                }
            }
        }
        // So little that it rounds to nothing, or no interval at all: it is not seen, and none of its
        // intervals may stay behind without it.
        let is_seen = total > 0.0;
        if !is_seen {
            let lines = if region.pane.is_some() { &mut self.panes } else { &mut self.lines };
            for &k in &self.touched {
                let line = &mut lines[k as usize];
                while line.last().is_some_and(|interval| interval.seen == seen) {
                    line.pop();
                }
            }
            if region.emits[side as usize] {
                self.missed.push(index as u32);
            }
            return;
        }
        let u = frame.local(region.u_axis);
        let v = frame.local(region.v_axis);
        let from_origin = point - region.origin;
        self.seen.push(Seen {
            region: index as u32,
            side,
            u: u.to_array(),
            v: v.to_array(),
            u_offset: region.u_axis.dot(from_origin),
            v_offset: region.v_axis.dot(from_origin),
            ratio: 1.0,
            doubt: None,
            met: self.touched.len() as u32,
            total,
            visible: 0.0,
            pane: region.pane.map(|pane| (pane, to_plane)),
        });
    }

    /// Finds the visible spans of one half-plane and hands them to their patches.
    fn sweep(&mut self, scene: (&Occluders, &Glass), line: &mut [Interval], direction: [f64; 2]) {
        line.sort_unstable_by(|a, b| a.start.total_cmp(&b.start).then(a.seen.cmp(&b.seen)));
        self.active.clear();
        let mut next = 0;
        let mut x = -1.0;
        let mut run: Option<(Interval, f64, f64)> = None;
        while next < line.len() || !self.active.is_empty() {
            if self.active.is_empty() {
                x = line[next].start;
            }
            while next < line.len() && line[next].start <= x {
                let new = line[next];
                next += 1;
                if !self.active.iter().any(|old| old.hides(&new, x)) {
                    self.active.retain(|old| !new.hides(old, x));
                    self.active.push(new);
                }
            }
            let mut end = f64::INFINITY;
            for interval in &self.active {
                if interval.end < end {
                    end = interval.end;
                }
            }
            // What begins behind another and stays behind it is no event.
            while next < line.len() && line[next].start < end {
                let start = line[next].start;
                if self.active.iter().any(|old| old.hides(&line[next], start)) {
                    next += 1;
                } else {
                    end = start;
                }
            }
            if end - x > SHORTEST {
                let (mut from, mut rounds) = (x, 0);
                while from < end {
                    // Slightly inside, so that surfaces that meet at an end do not tie.
                    let inset = 1e-3 * (end - from);
                    let near = nearest(&self.active, from + inset);
                    let far = if self.active.len() == 1 { near } else { nearest(&self.active, end - inset) };
                    let (first, last) = (self.active[near], self.active[far]);
                    let mut to = end;
                    if near != far && rounds < 8 {
                        // Two surfaces cut through each other: the span ends where they are equally near.
                        let meet = (last.w0 - first.w0) / (first.w1 - last.w1);
                        if meet > from && meet < end {
                            to = meet;
                        }
                    }
                    rounds += 1;
                    match &mut run {
                        Some((interval, _, run_end)) if interval.seen == first.seen && *run_end == from => {
                            *run_end = to;
                        }
                        _ => {
                            if let Some((interval, a, b)) = run.replace((first, from, to)) {
                                self.resolve(scene, &interval, a, b, direction);
                            }
                        }
                    }
                    from = to;
                }
            }
            x = end;
            self.active.retain(|interval| interval.end > end);
        }
        if let Some((interval, a, b)) = run {
            self.resolve(scene, &interval, a, b, direction);
        }
    }

    /// Cuts a visible span where it crosses grid lines, and gives each part to its patch.
    fn resolve(
        &mut self,
        (scene, glass): (&Occluders, &Glass),
        interval: &Interval,
        start: f64,
        end: f64,
        [cos, sin]: [f64; 2],
    ) {
        if !self.before.is_empty() && !self.is_mirror {
            self.solid.push(Interval { start, end, ..*interval });
        }
        let seen = &mut self.seen[interval.seen as usize];
        let region = &scene.regions[seen.region as usize];
        let start_weight = weight_of(start);
        let end_weight = weight_of(end);
        seen.visible += end_weight - start_weight;
        let side = seen.side as usize;
        let (w0, w1) = (interval.w0, interval.w1);
        let (nu, nv) = (region.cells[0] as i64, region.cells[1] as i64);
        // Numerators of u and v over w: linear in x.
        let numerator = |axis: &[f64; 3], offset: f64| {
            let radial = axis[0] * cos + axis[1] * sin;
            let (a0, a1) = (0.5 * (radial + axis[2]), 0.5 * (radial - axis[2]));
            (a0 + offset * w0, a1 + offset * w1)
        };
        let (u0, u1) = numerator(&seen.u, seen.u_offset);
        let (v0, v1) = numerator(&seen.v, seen.v_offset);
        let cell_at = |x: f64, a0: f64, a1: f64, count: i64| -> i64 {
            let value = (a0 + a1 * x) / (w0 + w1 * x);
            (value as i64).clamp(0, count - 1)
        };
        // A hair inside the span, so that ends on a grid line fall on the right side of it.
        let inset = 1e-9 * (end - start);
        let (xa, xb) = (start + inset, end - inset);
        let (mut iu, iu_end) =
            if nu == 1 { (0, 0) } else { (cell_at(xa, u0, u1, nu), cell_at(xb, u0, u1, nu)) };
        let (mut iv, iv_end) =
            if nv == 1 { (0, 0) } else { (cell_at(xa, v0, v1, nv), cell_at(xb, v0, v1, nv)) };
        let u_step = (iu_end - iu).signum();
        let v_step = (iv_end - iv).signum();
        // x at which u (or v) reaches the grid line behind cell i.
        let crossing = |i: i64, step: i64, last: i64, a0: f64, a1: f64| -> f64 {
            if i == last {
                return f64::INFINITY;
            }
            let line = (i + i64::from(step > 0)) as f64;
            (line * w0 - a0) / (a1 - line * w1)
        };
        let mut x_u = crossing(iu, u_step, iu_end, u0, u1);
        let mut x_v = crossing(iv, v_step, iv_end, v0, v1);
        let mut x = start;
        let mut weight = start_weight;
        loop {
            let to = x_u.min(x_v).min(end);
            let last = iu == iu_end && iv == iv_end;
            let (to, to_weight) =
                if last || to >= end { (end, end_weight) } else { (to.max(x), weight_of(to.max(x))) };
            match scene.cells[(region.first_cell as i64 + iu + iv * nu) as usize] {
                Cell::Whole(patches) => {
                    let patch = patches[side];
                    if patch != NO_PATCH {
                        let share = self.dimmed(glass, interval, [x, to], to_weight - weight);
                        self.pieces.push((patch, share, interval.seen));
                    }
                }
                Cell::Split([first, end_piece]) => {
                    for piece in &scene.pieces[first as usize..end_piece as usize] {
                        let patch = piece.patches[side];
                        if patch == NO_PATCH {
                            continue;
                        }
                        let (mut low, mut high) = (x, to);
                        for &[a, b, c] in &scene.piece_edges[piece.edges[0] as usize..piece.edges[1] as usize]
                        {
                            // a u + b v + c >= 0, times w > 0: linear in x.
                            let (f0, f1) = (a * u0 + b * v0 + c * w0, a * u1 + b * v1 + c * w1);
                            let root = -f0 / f1;
                            if f1 > 0.0 {
                                low = low.max(root);
                            } else if f1 < 0.0 {
                                high = high.min(root);
                            } else if f0 < 0.0 {
                                high = f64::NEG_INFINITY;
                            }
                        }
                        if high > low {
                            let weight = weight_of(high) - weight_of(low);
                            let share = self.dimmed(glass, interval, [low, high], weight);
                            self.pieces.push((patch, share, interval.seen));
                        }
                    }
                }
            }
            if last || to >= end {
                break;
            }
            x = to;
            weight = to_weight;
            if x_u <= x_v {
                iu += u_step;
                x_u = crossing(iu, u_step, iu_end, u0, u1);
            } else {
                iv += v_step;
                x_v = crossing(iv, v_step, iv_end, v0, v1);
            }
        }
    }
}

/// sin² of the angle from the normal, less 1/2.
#[inline]
fn weight_of(x: f64) -> f64 {
    x / (1.0 + x * x)
}

fn nearest(active: &[Interval], x: f64) -> usize {
    let mut best = (f64::NEG_INFINITY, 0);
    for (index, interval) in active.iter().enumerate() {
        let w = interval.w(x);
        if w > best.0 {
            best = (w, index);
        }
    }
    best.1
}

#[cfg(test)]
#[path = "lines_test.rs"]
mod tests;
