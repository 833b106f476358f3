//! The power-balance correction: the small system that the slow errors of Gauss-Seidel obey.
//!
//! Near reflectance 1 the error that sweeps remove last is almost constant over a room. With P the
//! piecewise constant aggregation of patches and A their areas, the correction P e with
//! (Pᵀ A (I - rho F) P) e = Pᵀ A r removes it at once; r is the residual.

use super::System;
use crate::mesh::PatchMesh;
use crate::transport::Transport;
use crate::watch::Cancelled;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Aggregates at least, where there are so many patches, and at most: a sixth of the patches between these.
/// A dense system of 512 is factored in some 50 ms, which a room that is solved in half a second would feel;
/// the house at reflectance 0.99 was 1e-4 off after eight sweeps with 384, and 6e-7 with 512.
const AGGREGATES: [usize; 2] = [384, 512];
/// Up to so many patches each is a part by itself. Joining 2,000 of them took three times as long as all
/// sweeps; blocks of sides need no more sweeps there.
const SINGLE: usize = 1024;
/// At most about this many parts of sides before they are joined.
const MOST_PARTS: usize = 2048;
/// Blocks of a side along each of its axes, at most.
const MOST_BLOCKS: f64 = 12.0;
/// The blocks of all large sides together, about.
const BLOCKS: f64 = 1000.0;
/// Cells of space along each axis that the smallest sides of an object share.
const CELLS: f64 = 6.0;

/// Which aggregate each patch belongs to.
#[derive(Clone, Debug, Default)]
pub(super) struct Aggregates {
    pub(super) of_patch: Vec<u32>,
    pub(super) count: usize,
}

impl Aggregates {
    /// Parts of sides, joined with what they exchange most light with until few enough are left.
    ///
    /// What sees mostly each other holds almost the same error: the inside of a lamp's housing comes
    /// together before it joins the room outside.
    ///
    /// Fails where it was `cancelled`.
    pub(super) fn new(
        mesh: &PatchMesh,
        transport: &dyn Transport,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        let parts = Self::parts(mesh);
        let mut graph = Exchange::between(&parts, transport, cancelled)?;
        let mut part_in: Vec<u32> = (0..parts.count as u32).collect();
        let most = (mesh.patches.len() / 6).clamp(AGGREGATES[0], AGGREGATES[1]);
        while graph.areas.len() > most {
            if cancelled() {
                return Err(Cancelled);
            }
            let Some(joined) = graph.join(most) else { break };
            part_in.iter_mut().for_each(|a| *a = joined.of_patch[*a as usize]);
            graph = graph.coarser(&joined);
        }
        let of_patch = parts.of_patch.iter().map(|&part| part_in[part as usize]).collect();
        Ok(Self { of_patch, count: graph.areas.len() })
    }

    /// Single patches where they are few, else blocks of connected sides, larger sides in more of them, since one floor may run through several
    /// rooms; where there are too many sides, the smaller ones of an object share cells of space.
    fn parts(mesh: &PatchMesh) -> Self {
        if mesh.patches.len() <= SINGLE {
            return Self { of_patch: (0..mesh.patches.len() as u32).collect(), count: mesh.patches.len() };
        }
        let sides = connected_sides(mesh);
        let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
        for (p, &side) in mesh.patches.iter().zip(&sides) {
            *areas.entry(side).or_default() += p.area;
        }
        let total: f64 = areas.values().sum();
        let mut sizes: Vec<f64> = areas.values().copied().collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        let smallest = sizes.get(MOST_PARTS - AGGREGATES[1]).copied().unwrap_or(0.0);
        let bounds = crate::geometry::Aabb::around(mesh.patches.iter().map(|p| p.centre));
        let step = (bounds.size() / CELLS).max(DVec3::splat(f64::MIN_POSITIVE));
        let mut index_of: BTreeMap<[i64; 5], u32> = BTreeMap::new();
        let of_patch: Vec<u32> = mesh
            .patches
            .iter()
            .zip(&sides)
            .map(|(p, side)| {
                let region = &mesh.regions[p.region as usize];
                let area = areas.get(side).copied().unwrap_or(0.0);
                let key = if area > smallest && !p.is_cluster {
                    let blocks = (area / total * BLOCKS).sqrt().ceil().min(MOST_BLOCKS);
                    let local = region.frame.local(p.centre - region.origin).truncate() - region.grid_min;
                    let extent =
                        region.cell_size * DVec2::new(region.cells[0].into(), region.cells[1].into());
                    let block =
                        (local / extent * blocks).floor().clamp(DVec2::ZERO, DVec2::splat(blocks - 1.0));
                    [0, i64::from(*side), 0, block.x as i64, block.y as i64]
                } else {
                    let cell = ((p.centre - bounds.min) / step).floor().min(DVec3::splat(CELLS - 1.0));
                    [1 + i64::from(region.object), p.side as i64, cell.x as i64, cell.y as i64, cell.z as i64]
                };
                let next = index_of.len() as u32;
                *index_of.entry(key).or_insert(next)
            })
            .collect();
        Self { of_patch, count: index_of.len() }
    }
}

/// For every patch the lowest one of its region and side that it hangs together with by shared vertices:
/// the discs of two lamps in one plane are two.
fn connected_sides(mesh: &PatchMesh) -> Vec<u32> {
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut parent: Vec<u32> = (0..mesh.patches.len() as u32).collect();
    let mut at_vertex: BTreeMap<(u32, u8, u32), u32> = BTreeMap::new();
    for (i, patch) in (0_u32..).zip(&mesh.patches) {
        for corner in mesh.pieces_of(patch).flat_map(|piece| mesh.corners_of(piece)) {
            let other = *at_vertex.entry((patch.region, patch.side as u8, corner.vertex)).or_insert(i);
            let (a, b) = (root(&mut parent, i), root(&mut parent, other));
            parent[a.max(b) as usize] = a.min(b);
        }
    }
    (0..parent.len() as u32).map(|i| root(&mut parent, i)).collect()
}

/// Exchange areas between aggregates, m², row by row in rising order, without their diagonal.
struct Exchange {
    rows: Vec<Vec<(u32, f64)>>,
    areas: Vec<f64>,
}

impl Exchange {
    fn between(
        parts: &Aggregates,
        transport: &dyn Transport,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); parts.count];
        for (i, &part) in parts.of_patch.iter().enumerate() {
            members[part as usize].push(i);
        }
        let add_row = transport.coarsen(&parts.of_patch);
        let rows = members
            .par_iter()
            .enumerate()
            .map_init(
                || vec![0.0; parts.count],
                |sums, (own, members)| {
                    if cancelled() {
                        return Err(Cancelled);
                    }
                    members.iter().for_each(|&i| add_row(i, sums));
                    Ok(Self::take_row(sums, own))
                },
            )
            .collect::<Result<_, _>>()?;
        let areas = members.iter().map(|m| m.iter().map(|&i| transport.area(i)).sum()).collect();
        Ok(Self { rows, areas })
    }

    /// Moves what a row summed up to out of `sums`, which is left empty.
    fn take_row(sums: &mut [f64], own: usize) -> Vec<(u32, f64)> {
        sums[own] = 0.0;
        let mut row = Vec::with_capacity(sums.iter().filter(|s| **s > 0.0).count());
        row.extend(sums.iter().enumerate().filter(|(_, s)| **s > 0.0).map(|(j, &s)| (j as u32, s)));
        sums.fill(0.0);
        row
    }

    /// Joins pairs in falling order of how fast sweeps even out a difference between the two, which is
    /// what joining them loses: at most a twelfth of all at a time, and no further than to `fewest`.
    /// `None` where nothing is left to join.
    ///
    /// The rate is the Rayleigh quotient of that difference in the network of exchange areas,
    /// (O_a A_b / A_a + O_b A_a / A_b + 2 S_ab) / (A_a + A_b), with O what leaves an aggregate: about 1
    /// for what sees mostly others, small for a cavity, or a room, that sees mostly itself.
    fn join(&self, fewest: usize) -> Option<Aggregates> {
        let n = self.areas.len();
        let leaving: Vec<f64> = self
            .rows
            .iter()
            .zip(&self.areas)
            .map(|(row, area)| row.iter().map(|e| e.1).sum::<f64>() / area)
            .collect();
        let mut pairs: Vec<(f64, u32, u32)> = (0..n)
            .into_par_iter()
            .filter_map(|a| {
                let (area, left) = (self.areas[a], leaving[a]);
                let mut best = (f64::NEG_INFINITY, 0);
                for &(b, s) in &self.rows[a] {
                    let other = self.areas[b as usize];
                    let rate = (left * other + leaving[b as usize] * area + 2.0 * s) / (area + other);
                    // Of equal ones the lowest, which comes first.
                    if rate > best.0 {
                        best = (rate, b);
                    }
                }
                let (rate, b) = best;
                (rate > f64::NEG_INFINITY).then_some((rate, (a as u32).min(b), (a as u32).max(b)))
            })
            .collect();
        pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let most = (n - fewest).min((n / 12).max(1));
        let mut partner: Vec<u32> = (0..n as u32).collect();
        let mut joined = 0;
        for (_, a, b) in pairs {
            if joined == most {
                break;
            }
            if partner[a as usize] == a && partner[b as usize] == b {
                (partner[a as usize], partner[b as usize]) = (b, a);
                joined += 1;
            }
        }
        let mut of_patch = vec![0; n];
        let mut count = 0;
        for a in 0..n {
            let first = (partner[a] as usize).min(a);
            if first == a {
                of_patch[a] = count as u32;
                count += 1;
            } else {
                of_patch[a] = of_patch[first];
            }
        }
        (joined > 0).then_some(Aggregates { of_patch, count })
    }

    fn coarser(&self, joined: &Aggregates) -> Self {
        let mut areas = vec![0.0; joined.count];
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); joined.count];
        for (a, &to) in joined.of_patch.iter().enumerate() {
            areas[to as usize] += self.areas[a];
            members[to as usize].push(a);
        }
        let rows = members
            .par_iter()
            .enumerate()
            .map_init(
                || vec![0.0; joined.count],
                |sums, (own, members)| {
                    for &a in members {
                        for &(b, s) in &self.rows[a] {
                            sums[joined.of_patch[b as usize] as usize] += s;
                        }
                    }
                    Self::take_row(sums, own)
                },
            )
            .collect();
        Self { rows, areas }
    }
}

/// The factorised aggregated systems, one a band.
#[derive(Clone, Debug, Default)]
pub(super) struct PowerBalance {
    factors: Vec<Lu>,
}

impl PowerBalance {
    /// Fails where it was `cancelled`.
    pub(super) fn new(
        transport: &dyn Transport,
        system: &System,
        aggregates: &Aggregates,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, Cancelled> {
        const CHUNKS: usize = 8;
        let (n, k) = (system.patches(), aggregates.count);
        let size = n.div_ceil(CHUNKS).max(1);
        let add_row = transport.coarsen(&aggregates.of_patch);
        // Chunks of fixed borders, added in order: the same bits whatever the thread count.
        let partial: Vec<Vec<Vec<f64>>> = (0..n.div_ceil(size))
            .into_par_iter()
            .map(|chunk| {
                let mut sums = vec![vec![0.0; k * k]; system.bands];
                let mut seen = vec![0.0; k];
                for i in chunk * size..((chunk + 1) * size).min(n) {
                    if cancelled() {
                        return Err(Cancelled);
                    }
                    seen.fill(0.0);
                    // What sees nothing keeps B = E, and must not soak up the correction.
                    if !transport.sees(i) {
                        continue;
                    }
                    add_row(i, &mut seen);
                    let own = aggregates.of_patch[i] as usize;
                    seen[own] += transport.own(i);
                    for (band, sum) in sums.iter_mut().enumerate() {
                        let rho = system.reflectance[i][band];
                        let row = &mut sum[own * k..(own + 1) * k];
                        for (entry, &s) in row.iter_mut().zip(&seen) {
                            *entry -= rho * s;
                        }
                        row[own] += system.areas[i];
                    }
                    // What arrives on the far side is sent out here: its row in this one's place.
                    for &(far, share) in system.translucence.at(i).iter().flat_map(|p| &p.behind) {
                        seen.fill(0.0);
                        add_row(far as usize, &mut seen);
                        seen[aggregates.of_patch[far as usize] as usize] += transport.own(far as usize);
                        let share = share * system.areas[i] / system.areas[far as usize];
                        for (band, sum) in sums.iter_mut().enumerate() {
                            let tau = system.translucence.at(i).map_or(0.0, |p| p.share[band]);
                            let row = &mut sum[own * k..(own + 1) * k];
                            row.iter_mut().zip(&seen).for_each(|(entry, &s)| *entry -= tau * share * s);
                        }
                    }
                }
                Ok(sums)
            })
            .collect::<Result<_, _>>()?;
        let factors = (0..system.bands)
            .into_par_iter()
            .map(|band| {
                let mut matrix = vec![0.0; k * k];
                for chunk in &partial {
                    for (sum, part) in matrix.iter_mut().zip(&chunk[band]) {
                        *sum += part;
                    }
                }
                // An aggregate of what sees nothing has an empty row: its correction is nought.
                for own in 0..k {
                    if matrix[own * k + own] == 0.0 {
                        matrix[own * k + own] = 1.0;
                    }
                }
                Lu::new(matrix, k, cancelled)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { factors })
    }

    /// Turns the aggregated residual power of one column, W, into the correction of each aggregate.
    pub(super) fn correct(&self, band: usize, power: &mut [f64]) {
        self.factors[band].solve(power);
    }
}

/// LU factors of a dense matrix with partial pivoting.
#[derive(Clone, Debug)]
struct Lu {
    size: usize,
    values: Vec<f64>,
    pivots: Vec<usize>,
}

impl Lu {
    /// The matrix is diagonally dominant and has no empty row: no pivot vanishes.
    fn new(mut a: Vec<f64>, n: usize, cancelled: &dyn Fn() -> bool) -> Result<Self, Cancelled> {
        let mut pivots = Vec::with_capacity(n);
        for c in 0..n {
            if cancelled() {
                return Err(Cancelled);
            }
            let pivot =
                (c..n).max_by(|&x, &y| a[x * n + c].abs().total_cmp(&a[y * n + c].abs())).unwrap_or(c);
            pivots.push(pivot);
            if pivot != c {
                for k in 0..n {
                    a.swap(c * n + k, pivot * n + k);
                }
            }
            let (upper, lower) = a.split_at_mut((c + 1) * n);
            let top = &upper[c * n..];
            if top[c] == 0.0 {
                continue;
            }
            for row in lower.chunks_exact_mut(n) {
                let factor = row[c] / top[c];
                row[c] = factor;
                if factor != 0.0 {
                    for k in c + 1..n {
                        row[k] -= factor * top[k];
                    }
                }
            }
        }
        Ok(Self { size: n, values: a, pivots })
    }

    fn solve(&self, b: &mut [f64]) {
        let n = self.size;
        for (c, &pivot) in self.pivots.iter().enumerate() {
            b.swap(c, pivot);
        }
        for r in 1..n {
            b[r] -= (0..r).map(|k| self.values[r * n + k] * b[k]).sum::<f64>();
        }
        for r in (0..n).rev() {
            let sum: f64 = (r + 1..n).map(|k| self.values[r * n + k] * b[k]).sum();
            let pivot = self.values[r * n + r];
            b[r] = if pivot == 0.0 { 0.0 } else { (b[r] - sum) / pivot };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lu_solves_a_system_that_needs_pivoting() {
        // [[0, 2], [3, 1]] x = (4, 5) has x = (1, 2).
        let mut b = [4.0, 5.0];
        Lu::new(vec![0.0, 2.0, 3.0, 1.0], 2, &|| false).expect("whole").solve(&mut b);
        assert!((b[0] - 1.0).abs() < 1e-15 && (b[1] - 2.0).abs() < 1e-15);
    }
}
