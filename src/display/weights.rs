use crate::mesh::PatchMesh;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Below this many vertices a loop is not spread over threads: it takes some milliseconds, and where
/// the processors are busy with a solve, waiting for another thread can take many more.
pub(super) const PARALLEL_FROM: usize = 50_000;

/// The angles around a vertex must reach this much of a full turn for it to lie inside a surface.
const CLOSED_TURN: f64 = 0.98 * TAU;

/// Extrapolation may weigh patches with this much in all (sum of magnitudes); the corner of an
/// even grid needs 3.
const LARGEST_GAIN: f64 = 3.5;

/// A place at which patch values are interpolated: a mesh vertex of one smooth surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadingVertex {
    /// Metres.
    pub(super) position: DVec3,
    /// Unit normal of the side.
    pub(super) normal: DVec3,
    /// Sum of the corner angles that meet here, radians.
    pub(super) angle: f64,
}

/// Sparse weights that turn patch values into vertex values.
///
/// Inside a surface a vertex takes the mean of the patches around it. At a border the plane
/// through their values and those of the next ring is extrapolated (Cohen & Greenberg 1985,
/// figure 9, by least squares so that any outline will do). The outcome is held as near to the
/// patches that touch the vertex as the middle one of the next ring is to their mean: a shadow
/// that begins in the ring is not drawn to the border, and nothing turns negative.
#[derive(Clone, Debug, Default)]
pub(super) struct VertexWeights {
    /// For each vertex where its entries start; one more at the end.
    starts: Vec<u32>,
    /// Patches and their weights, those that touch the vertex first; those of a vertex sum to one.
    entries: Vec<(u32, f32)>,
    /// How many patches touch each vertex.
    touching: Vec<u32>,
}

impl VertexWeights {
    /// Finds the weights. `incidences` pairs vertices with the patches that touch them, in any
    /// order; every vertex has one at least. On clusters light depends on place and normal alone, whatever patches
    /// meet.
    pub(super) fn build(
        vertices: &[ShadingVertex],
        mut incidences: Vec<(u32, u32)>,
        mesh: &PatchMesh,
    ) -> Self {
        let patch = |p: u32| &mesh.patches[p as usize];
        let around_vertex = Table::new(vertices.len(), &mut incidences);
        let mut turned: Vec<(u32, u32)> = incidences.iter().map(|&(vertex, patch)| (patch, vertex)).collect();
        turned.retain(|&(p, _)| !patch(p).is_cluster);
        let around_patch = Table::new(mesh.patches.len(), &mut turned);
        let lists: Vec<Vec<(u32, f32)>> = vertices
            .par_iter()
            .enumerate()
            .with_min_len(256)
            .map(|(index, vertex)| {
                let mut patches = around_vertex.row(index).to_vec();
                if let Some(&cluster) = patches.iter().find(|&&p| patch(p).is_cluster) {
                    return mesh.clusters.around((cluster, patch(cluster)), vertex.position, vertex.normal);
                }
                if vertex.angle < CLOSED_TURN {
                    let near = around_vertex.row(index).iter();
                    let next = near.flat_map(|&p| around_patch.row(p as usize));
                    let mut ring: Vec<u32> =
                        next.flat_map(|&v| around_vertex.row(v as usize)).copied().collect();
                    ring.sort_unstable();
                    ring.dedup();
                    ring.retain(|p| !patches.contains(p));
                    patches.extend(ring);
                }
                let offsets = patches.iter().map(|&p| patch(p).centre - vertex.position);
                let weights = plane_weights(&tangential(vertex.normal, offsets));
                patches.into_iter().zip(weights.into_iter().map(|w| w as f32)).collect()
            })
            .collect();
        let mut starts = Vec::with_capacity(lists.len() + 1);
        let mut sum = 0;
        starts.push(0);
        starts.extend(lists.iter().map(|list| {
            sum += list.len() as u32;
            sum
        }));
        let touching = |v: usize| {
            let touching = around_vertex.row(v);
            let is_shared = touching.iter().any(|&p| patch(p).is_cluster);
            if is_shared { lists[v].len() as u32 } else { touching.len() as u32 }
        };
        let touching = (0..vertices.len()).map(touching).collect();
        Self { starts, entries: lists.concat(), touching }
    }

    /// Vertices.
    pub(super) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Vertex values; a patch value that is missing or not finite counts as zero.
    pub(super) fn gather<const N: usize>(&self, patch_values: &[[f32; N]]) -> Vec<[f32; N]> {
        let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
        let values: Vec<[f32; N]> = patch_values.iter().map(|v| v.map(finite)).collect();
        let value_of = |patch: u32| values.get(patch as usize).copied().unwrap_or([0.0; N]);
        let one = |vertex: usize| {
            let entries = &self.entries[self.starts[vertex] as usize..self.starts[vertex + 1] as usize];
            let (near, far) = entries.split_at(self.touching[vertex] as usize);
            let (mut sum, mut mean) = ([0.0_f32; N], [0.0_f32; N]);
            let (mut low, mut high) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
            // Every value is fetched once for all bands: this loop bounds how fast a lamp switches.
            for &(patch, weight) in near {
                let value = value_of(patch);
                for band in 0..N {
                    sum[band] += weight * value[band];
                    mean[band] += value[band];
                    low[band] = low[band].min(value[band]);
                    high[band] = high[band].max(value[band]);
                }
            }
            for &(patch, weight) in far {
                let value = value_of(patch);
                for band in 0..N {
                    sum[band] += weight * value[band];
                }
            }
            std::array::from_fn(|band| {
                if sum[band] >= low[band] && sum[band] <= high[band] {
                    return sum[band];
                }
                let mean = mean[band] / near.len().max(1) as f32;
                let margin = middle_distance(far.iter().map(|e| value_of(e.0)[band]), mean);
                let low = low[band];
                let floor = if low >= 0.0 { (low - margin).max(0.5 * low) } else { low - margin };
                finite(sum[band].max(floor).min(high[band] + margin))
            })
        };
        if self.len() > PARALLEL_FROM {
            (0..self.len()).into_par_iter().with_min_len(1024).map(one).collect()
        } else {
            (0..self.len()).map(one).collect()
        }
    }
}

/// The middle one of the distances of `values` from `mean`; of a great many the first 16 count.
fn middle_distance(values: impl Iterator<Item = f32>, mean: f32) -> f32 {
    let mut distances = [0.0_f32; 16];
    let mut count = 0;
    for (slot, value) in distances.iter_mut().zip(values) {
        *slot = (value - mean).abs();
        count += 1;
    }
    distances[..count].sort_unstable_by(f32::total_cmp);
    if count == 0 { 0.0 } else { distances[count / 2] }
}

/// Rows of numbers of different length, one after another.
struct Table {
    starts: Vec<u32>,
    values: Vec<u32>,
}

impl Table {
    /// Sorts `pairs` of (row, value), drops repetitions and stores them.
    fn new(rows: usize, pairs: &mut Vec<(u32, u32)>) -> Self {
        pairs.par_sort_unstable();
        pairs.dedup();
        let mut starts = vec![0_u32; rows + 1];
        for &(row, _) in pairs.iter() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        Self { starts, values: pairs.iter().map(|&(_, value)| value).collect() }
    }

    fn row(&self, row: usize) -> &[u32] {
        &self.values[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}

/// Offsets in the plane perpendicular to `normal`.
fn tangential(normal: DVec3, offsets: impl Iterator<Item = DVec3>) -> Vec<DVec2> {
    let frame = crate::geometry::Frame::around(normal);
    offsets.map(|d| DVec2::new(frame.tangent.dot(d), frame.bitangent.dot(d))).collect()
}

/// Weights that give at the origin the value of the plane fitted to values at `offsets`, nearer
/// ones counting more (by inverse squared distance). They sum to one.
fn plane_weights(offsets: &[DVec2]) -> Vec<f64> {
    let largest = offsets.iter().map(|d| d.length_squared()).fold(0.0, f64::max);
    if offsets.len() < 2 || largest <= 0.0 {
        return vec![1.0 / offsets.len().max(1) as f64; offsets.len()];
    }
    let mut base: Vec<f64> = offsets.iter().map(|d| 1.0 / (d.length_squared() + 1e-4 * largest)).collect();
    let sum: f64 = base.iter().sum();
    base.iter_mut().for_each(|b| *b /= sum);
    let mean: DVec2 = base.iter().zip(offsets).map(|(&b, &d)| d * b).sum();
    // Normal equations of the slope; the ridge leaves directions without spread at slope zero.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (&b, &d) in base.iter().zip(offsets) {
        let e = d - mean;
        xx += b * e.x * e.x;
        xy += b * e.x * e.y;
        yy += b * e.y * e.y;
    }
    let ridge = 1e-4 * (xx + yy) + 1e-12 * largest;
    (xx, yy) = (xx + ridge, yy + ridge);
    let determinant = xx * yy - xy * xy;
    let slope = DVec2::new(yy * mean.x - xy * mean.y, xx * mean.y - xy * mean.x) / determinant;
    let fitted: Vec<f64> = base.iter().zip(offsets).map(|(&b, &d)| b * (1.0 - slope.dot(d - mean))).collect();
    let gain: f64 = fitted.iter().map(|w| w.abs()).sum();
    if !gain.is_finite() {
        return base;
    }
    // Where the fit extrapolates too boldly, draw it back towards the mean.
    let share = if gain > LARGEST_GAIN { (LARGEST_GAIN - 1.0) / (gain - 1.0) } else { 1.0 };
    base.iter().zip(&fitted).map(|(b, f)| b + share * (f - b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value_at_origin(offsets: &[DVec2], value: impl Fn(DVec2) -> f64) -> f64 {
        plane_weights(offsets).iter().zip(offsets).map(|(w, &d)| w * value(d)).sum()
    }

    #[test]
    fn a_plane_is_met_at_the_corner_of_a_grid() {
        let grid = [(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5)].map(DVec2::from);
        let at_origin = value_at_origin(&grid, |d| 10.0 + 2.0 * d.x - d.y);
        assert!((at_origin - 10.0).abs() < 1e-2, "{at_origin}");
        // Along a border: 1.5 near - 0.5 far.
        let border = [(-0.5, 0.5), (0.5, 0.5), (-0.5, 1.5), (0.5, 1.5)].map(DVec2::from);
        let at_origin = value_at_origin(&border, |d| d.y);
        assert!(at_origin.abs() < 1e-2, "{at_origin}");
    }

    #[test]
    fn patches_in_a_row_do_not_explode() {
        // Nearly no spread across the row, where the fit could take any slope.
        let row = [(0.5, 0.5), (1.5, 0.500_01), (2.5, 0.499_99), (3.5, 0.5)].map(DVec2::from);
        let weights = plane_weights(&row);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(weights.iter().map(|w| w.abs()).sum::<f64>() < LARGEST_GAIN + 1e-9, "{weights:?}");
        assert_eq!(plane_weights(&[DVec2::ONE]), [1.0]);
        assert_eq!(plane_weights(&[DVec2::ZERO, DVec2::ZERO]), [0.5, 0.5]);
    }

    #[test]
    fn extrapolation_is_held_and_broken_values_are_dropped() {
        let weights =
            VertexWeights { starts: vec![0, 2], entries: vec![(0, 1.5), (1, -0.5)], touching: vec![1] };
        assert_eq!(weights.gather(&[[10.0], [1000.0]]), [[5.0]]);
        assert_eq!(weights.gather(&[[1000.0], [10.0]]), [[1495.0]]);
        // One dark patch in a bright ring is not drawn out to the border.
        let entries = vec![(0, 1.5), (1, 0.0), (2, 0.0), (3, -0.5)];
        let weights = VertexWeights { starts: vec![0, 4], entries, touching: vec![1] };
        assert_eq!(weights.gather(&[[10.0], [10.0], [10.0], [1.0]]), [[10.0]]);
        assert_eq!(weights.gather(&[[f32::NAN], [f32::INFINITY]]), [[0.0]]);
        assert_eq!(weights.gather::<1>(&[]), [[0.0]]);
    }
}
