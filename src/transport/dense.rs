//! Every pair of patches that see each other: sparse, reciprocal and closed.

mod operator;

use super::balancing::{Balancing, Scaling};
use super::quality::PairGaps;
use super::{AssembleReport, LANES, Lanes, RowQuality, near};
use crate::form_factors::{Row, RowComputer};
use crate::watch::{self, Watch};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// The form factors of all pairs of patches that see each other, as exchange areas S_ij = A_i F_ij, row by
/// row.
///
/// S is symmetric to the last bit, so that what i sends to j is what j would send to i. What
/// single precision rounds off a row's sum, and what no other patch can take up, is kept on the diagonal in
/// double precision.
#[derive(Clone, Debug, Default)]
pub struct DenseTransport {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    exchange: Vec<f32>,
    diagonal: Vec<f64>,
    areas: Vec<f64>,
    quality: Vec<RowQuality>,
    report: AssembleReport,
    passes: Arc<AtomicU64>,
}

/// Shares of the time by which close pairs, rows joined from both sides and the sums of rows are done, about.
const PAIRED: f64 = 0.5;
const JOINED: f64 = 0.7;
const TARGETED: f64 = 0.8;
/// Rows assembled by one task.
const BLOCK: usize = 256;
/// Leaves room for the rounding of single precision below every row sum.
const HEADROOM: f64 = 1.0 - 2e-7;

impl DenseTransport {
    /// Builds the matrix from one sampled row a patch.
    ///
    /// 1. Each pair takes a mean of its two samples, in which the smaller patch counts for more; a lamp's
    ///    takes the receiver's, who sees it better.
    /// 2. Close pairs take closed forms times their visible fraction.
    /// 3. A symmetric scaling gives every row its sum: one where the point saw no opening, else what was
    ///    sampled and then mended for close pairs.
    ///
    /// The rows are emptied once they are not needed any more, to make room for the matrix; before, they are
    /// left as they were.
    ///
    /// # Errors
    /// The watch ended it.
    pub fn assemble(
        computer: &RowComputer,
        rows: &mut Vec<Row>,
        watch: &mut Watch<'_>,
    ) -> Result<Self, watch::Cancelled> {
        let mesh = computer.mesh();
        let n = mesh.patches.len();
        assert_eq!(rows.len(), n, "one row a patch");
        let pairs_of = |i: usize, _: &Row| near::of_row(computer, rows, i as u32);
        let close = watch.part(0.0, PAIRED).map(rows, pairs_of)?;
        let close_pairs = close.iter().map(Vec::len).sum();

        let starts: Vec<usize> = (0..n).step_by(BLOCK).collect();
        let entries = Entries::new(rows, &close, &starts);
        let blocks = watch.part(PAIRED, JOINED).map(&starts, |block, &start| {
            Block::assemble(computer, rows, &close, (&entries, block), start..(start + BLOCK).min(n))
        })?;
        drop(entries);
        let sums: Vec<f64> = rows.par_iter().map(Row::sum).collect();
        let sealed = computer.rays().is_sealed();
        let targets: Vec<f64> = watch.part(JOINED, TARGETED).map(&sums, |i, &sum| {
            let pair = |j: u32| {
                let (low, high) = if (i as u32) < j { (i, j) } else { (j as usize, i as u32) };
                let at = close[low].binary_search_by_key(&high, |pair| pair.0).ok()?;
                Some(close[low][at].1)
            };
            let row = (i as u32, &rows[i], sum);
            mesh.patches[i].area * HEADROOM * near::row_target(computer, row, &pair, sealed)
        })?;
        let several_points = rows.iter().filter(|row| row.points.count() > 1).count();
        drop(std::mem::take(rows));
        let entries = blocks.iter().map(|b| b.columns.len()).sum();
        let mut matrix = Self {
            offsets: Vec::with_capacity(n + 1),
            columns: Vec::with_capacity(entries),
            exchange: Vec::with_capacity(entries),
            diagonal: vec![0.0; n],
            areas: mesh.patches.iter().map(|p| p.area).collect(),
            quality: Vec::with_capacity(n),
            report: AssembleReport::default(),
            passes: Arc::default(),
        };
        matrix.offsets.push(0);
        let (mut gap, mut mean) = (0.0, 0.0);
        for block in blocks {
            for end in &block.ends {
                matrix.offsets.push(matrix.columns.len() + end);
            }
            matrix.columns.extend_from_slice(&block.columns);
            matrix.exchange.extend_from_slice(&block.exchange);
            matrix.quality.extend_from_slice(&block.quality);
            gap += block.gap;
            mean += block.mean;
        }
        let near_one = |s: &&f64| (**s - 1.0).abs() < 0.01;
        let worst_closure = sums.iter().filter(near_one).map(|s| (s - 1.0).abs()).fold(0.0, f64::max);
        let scaling = matrix.balance(&targets, &mut watch.part(TARGETED, 1.0))?;
        matrix.report = AssembleReport {
            worst_closure,
            mean_reciprocity: if mean > 0.0 { gap / mean } else { 0.0 },
            several_points,
            close_pairs,
            passes: scaling.passes,
            imbalance: scaling.imbalance,
            kept: scaling.kept,
            ..AssembleReport::default()
        };
        Ok(matrix)
    }

    /// Scales rows and columns alike until row i of S sums to `targets[i]`.
    fn balance(&mut self, targets: &[f64], watch: &mut Watch<'_>) -> Result<Scaling, watch::Cancelled> {
        let product = |i: usize, vector: &[f64]| self.dot(i, vector);
        let scaling = Balancing::new(&product, &self.areas, targets).solve(watch)?;
        let Scaling { scales: scale, sums, .. } = &scaling;
        let n = self.areas.len();
        // No row may send out more than it has: what still exceeds its target is cut on both sides.
        let cut: Vec<f64> =
            (0..n).map(|i| if sums[i] > targets[i] { targets[i] / sums[i] } else { 1.0 }).collect();
        let offsets = &self.offsets;
        let mut rows = Vec::with_capacity(n);
        let mut rest = self.exchange.as_mut_slice();
        for i in 0..n {
            let (row, tail) = std::mem::take(&mut rest).split_at_mut(offsets[i + 1] - offsets[i]);
            rows.push(row);
            rest = tail;
        }
        let columns = &self.columns;
        let scaled: Vec<f64> = rows
            .into_par_iter()
            .enumerate()
            .map(|(i, row)| {
                let mut sum = 0.0;
                for (value, &j) in row.iter_mut().zip(&columns[offsets[i]..offsets[i + 1]]) {
                    let j = j as usize;
                    // The product in one order for (i, j) and (j, i): symmetric to the last bit.
                    let (a, b) = if i < j { (i, j) } else { (j, i) };
                    *value = (f64::from(*value) * (scale[a] * scale[b]) * cut[a].min(cut[b])) as f32;
                    sum += f64::from(*value);
                }
                sum
            })
            .collect();
        for i in 0..n {
            let target = targets[i] / HEADROOM;
            self.diagonal[i] = if sums[i] > 0.0 { (target - scaled[i]).max(0.0) } else { 0.0 };
        }
        Ok(scaling)
    }

    /// Row i of S times a vector.
    fn dot(&self, i: usize, vector: &[f64]) -> f64 {
        let (columns, values) = self.stored(i);
        columns.iter().zip(values).map(|(&j, &s)| f64::from(s) * vector[j as usize]).sum()
    }

    /// Patches that patch `i` sees and its exchange areas with them, m².
    fn stored(&self, i: usize) -> (&[u32], &[f32]) {
        let range = self.offsets[i]..self.offsets[i + 1];
        (&self.columns[range.clone()], &self.exchange[range])
    }

    /// Irradiance of patch `i`, W/m² per lane.
    #[inline]
    fn arriving(&self, i: usize, radiosity: &[Lanes]) -> Lanes {
        let (columns, values) = self.stored(i);
        let mut sum = [0.0; LANES];
        for (&j, &s) in columns.iter().zip(values) {
            let s = f64::from(s);
            let b = &radiosity[j as usize];
            for lane in 0..LANES {
                sum[lane] += s * b[lane];
            }
        }
        let own = &radiosity[i];
        let (diagonal, area) = (self.diagonal[i], self.areas[i]);
        std::array::from_fn(|lane| (sum[lane] + diagonal * own[lane]) / area)
    }
}

/// Where each row and its close pairs enter each block of rows, and where the last one ends: what a block
/// reads is looked up, so that all blocks together read every pair once.
struct Entries {
    rows: Vec<Vec<u32>>,
    close: Vec<Vec<u32>>,
}

impl Entries {
    fn new(rows: &[Row], close: &[Vec<(u32, f64)>], starts: &[usize]) -> Self {
        // A row is searched as a whole, while it is at hand.
        let of_row = |row: &Row| {
            let first = |&start: &usize| row.patches.partition_point(|&p| (p as usize) < start) as u32;
            starts.iter().map(first).chain([row.patches.len() as u32]).collect()
        };
        let of_pairs = |pairs: &Vec<(u32, f64)>| {
            let first = |&start: &usize| pairs.partition_point(|pair| (pair.0 as usize) < start) as u32;
            starts.iter().map(first).chain([pairs.len() as u32]).collect()
        };
        Self { rows: rows.par_iter().map(of_row).collect(), close: close.par_iter().map(of_pairs).collect() }
    }

    /// The part of row `j` in a block.
    fn of_row(&self, j: usize, block: usize) -> Range<usize> {
        self.rows[j][block] as usize..self.rows[j][block + 1] as usize
    }

    /// The part of the close pairs of row `j` in a block.
    fn of_close(&self, j: usize, block: usize) -> Range<usize> {
        self.close[j][block] as usize..self.close[j][block + 1] as usize
    }
}

/// A run of assembled rows.
#[derive(Debug, PartialEq)]
struct Block {
    ends: Vec<usize>,
    columns: Vec<u32>,
    exchange: Vec<f32>,
    quality: Vec<RowQuality>,
    gap: f64,
    mean: f64,
}

impl Block {
    /// The rows in `range`, which are those of one block of `entries`.
    fn assemble(
        computer: &RowComputer,
        rows: &[Row],
        close: &[Vec<(u32, f64)>],
        (entries, block): (&Entries, usize),
        range: Range<usize>,
    ) -> Self {
        let mesh = computer.mesh();
        // What other rows say of the patches in this range, in rising order of those rows.
        let mut columns: Vec<Vec<(u32, f32)>> = vec![Vec::new(); range.len()];
        let mut mirrored: Vec<Vec<(u32, f64)>> = vec![Vec::new(); range.len()];
        for (j, row) in rows.iter().enumerate() {
            let part = entries.of_row(j, block);
            for (&i, &value) in row.patches[part.clone()].iter().zip(&row.values[part]) {
                columns[i as usize - range.start].push((j as u32, value));
            }
            for &(i, value) in &close[j][entries.of_close(j, block)] {
                mirrored[i as usize - range.start].push((j as u32, value));
            }
        }
        let mut block = Self {
            ends: Vec::new(),
            columns: Vec::new(),
            exchange: Vec::new(),
            quality: Vec::with_capacity(range.len()),
            gap: 0.0,
            mean: 0.0,
        };
        for (k, column) in columns.iter().enumerate() {
            let i = range.start + k;
            let row = &rows[i];
            let a_i = mesh.patches[i].area;
            // Close pairs in rising order: those of lower rows, then this row's own.
            let mut exact = mirrored[k].iter().chain(&close[i]).peekable();
            let mut pairs = PairGaps::new(row, a_i);
            let (mut r, mut c) = (0, 0);
            while r < row.patches.len() || c < column.len() {
                let from_row = row.patches.get(r).copied().unwrap_or(u32::MAX);
                let from_column = column.get(c).map_or(u32::MAX, |e| e.0);
                let j = from_row.min(from_column);
                let mut out = 0.0;
                let mut back = 0.0;
                if from_row == j {
                    out = a_i * f64::from(row.values[r]);
                    r += 1;
                }
                if from_column == j {
                    back = mesh.patches[j as usize].area * f64::from(column[c].1);
                    c += 1;
                }
                pairs.add(j, out, back);
                while exact.next_if(|e| e.0 < j).is_some() {}
                let value = match exact.peek() {
                    Some(&&(at, value)) if at == j => value,
                    _ => pair_value(computer, i as u32, j, out, back),
                };
                if j as usize != i && value as f32 > 0.0 {
                    block.columns.push(j);
                    block.exchange.push(value as f32);
                }
            }
            block.ends.push(block.columns.len());
            let (gap, mean, quality) = pairs.finish();
            block.gap += gap;
            block.mean += mean;
            block.quality.push(quality);
        }
        // Blocks stand beside the rows: room for more would be memory that others need.
        block.columns.shrink_to_fit();
        block.exchange.shrink_to_fit();
        block
    }
}

/// Exchange area of a pair from the two samples `out` = A_i F_ij and `back` = A_j F_ji, m².
fn pair_value(computer: &RowComputer, i: u32, j: u32, out: f64, back: f64) -> f64 {
    // In one order for (i, j) and (j, i), so that both round alike.
    let ((a, x), (b, y)) = if i < j { ((i, out), (j, back)) } else { ((j, back), (i, out)) };
    let patches = &computer.mesh().patches;
    let [of_a, of_b] = near::trust(computer, &patches[a as usize], &patches[b as usize]);
    of_a * x + of_b * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form_factors::{Method, ReceivingPoints, Sampling};
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::{SceneSource, load};
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn sampled() -> (RowComputer, Vec<Row>) {
        let scene = load(&SceneSource::Builtin("cornell".to_owned())).expect("embedded");
        let settings = MeshSettings { target: PatchTarget::Count(700), ..MeshSettings::default() };
        let mesh = Arc::new(build(&scene, &settings).expect("a mesh"));
        let sampling = Sampling { method: Method::Lines, resolution: Some(24), points: ReceivingPoints::One };
        let computer = RowComputer::new(mesh, sampling, true);
        let mut scratch = computer.scratch();
        let rows = (0..computer.mesh().patches.len() as u32).map(|i| computer.row(i, &mut scratch)).collect();
        (computer, rows)
    }

    #[test]
    fn blocks_of_any_size_hold_the_same_rows_and_read_each_pair_once() {
        let (computer, rows) = sampled();
        let n = rows.len();
        let close: Vec<_> = (0..n as u32).map(|i| near::of_row(&computer, &rows, i)).collect();
        assert!(close.iter().map(Vec::len).sum::<usize>() > n, "there are close pairs");
        let assembled = |size: usize| -> Vec<Block> {
            let starts: Vec<usize> = (0..n).step_by(size).collect();
            let entries = Entries::new(&rows, &close, &starts);
            let read = |j: usize| {
                let parts =
                    (0..starts.len()).map(|b| entries.of_row(j, b).len() + entries.of_close(j, b).len());
                parts.sum::<usize>()
            };
            for j in 0..n {
                assert_eq!(read(j), rows[j].patches.len() + close[j].len(), "row {j} in blocks of {size}");
            }
            let block = |(b, &start): (usize, &usize)| {
                Block::assemble(&computer, &rows, &close, (&entries, b), start..(start + size).min(n))
            };
            starts.iter().enumerate().map(block).collect()
        };
        let whole = &assembled(n)[0];
        for size in [1, 7, 256] {
            let blocks = assembled(size);
            let columns: Vec<u32> = blocks.iter().flat_map(|b| b.columns.clone()).collect();
            let exchange: Vec<f32> = blocks.iter().flat_map(|b| b.exchange.clone()).collect();
            assert_eq!((&columns, &exchange), (&whole.columns, &whole.exchange), "blocks of {size}");
        }
        // And these are what each pair comes to by itself.
        let (mut at, mut start) = (0, 0);
        for (i, &end) in whole.ends.iter().enumerate() {
            let area = |k: usize| computer.mesh().patches[k].area;
            for j in 0..n {
                let (low, high) = (i.min(j), i.max(j));
                let sampled = [area(i) * rows[i].get(j as u32), area(j) * rows[j].get(i as u32)];
                let seen = sampled.iter().any(|&s| s > 0.0);
                let exact = close[low].iter().find(|pair| pair.0 as usize == high).map(|pair| pair.1);
                let [out, back] = sampled;
                let value =
                    exact.unwrap_or_else(|| pair_value(&computer, i as u32, j as u32, out, back)) as f32;
                if seen && i != j && value > 0.0 {
                    assert_eq!((whole.columns[at], whole.exchange[at]), (j as u32, value), "{i} to {j}");
                    at += 1;
                }
            }
            assert!(at == end && end >= start, "row {i}");
            start = end;
        }
    }

    #[test]
    fn a_request_to_end_leaves_the_rows_whole() {
        let (computer, rows) = sampled();
        let looks = AtomicUsize::new(0);
        let count = || {
            looks.fetch_add(1, Ordering::Relaxed);
            false
        };
        let mut told = Vec::new();
        let mut report = |share| told.push(share);
        let done =
            DenseTransport::assemble(&computer, &mut rows.clone(), &mut Watch::new(&count, &mut report));
        assert!(done.is_ok() && told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
        let all = looks.into_inner();
        for end in [0, all / 10, rows.len() + 3, all / 2, all - 1] {
            let looks = AtomicUsize::new(0);
            let cancelled = || looks.fetch_add(1, Ordering::Relaxed) >= end;
            let mut left = rows.clone();
            let ended =
                DenseTransport::assemble(&computer, &mut left, &mut Watch::new(&cancelled, &mut |_| {}));
            assert!(ended.is_err() && (left.is_empty() || left == rows), "after {end} of {all} looks");
            let further = looks.into_inner() - end;
            assert!(further <= rayon::current_num_threads() + 2, "{further} looks after the request");
        }
    }
}
