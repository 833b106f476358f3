//! What the matrix answers to those who ask the operator.

use super::DenseTransport;
use crate::transport::{AssembleReport, Cancelled, Coarsened, Lanes, RowQuality, Transport, TransportKind};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// Rows gathered between two looks at whether to stop.
const UNWATCHED: usize = 256;

impl Transport for DenseTransport {
    fn areas(&self) -> &[f64] {
        &self.areas
    }

    fn gather(
        &self,
        rows: Range<usize>,
        radiosity: &[Lanes],
        irradiance: &mut [Lanes],
        cancelled: Cancelled,
    ) {
        self.passes.fetch_add(1, Ordering::Relaxed);
        let first = rows.start;
        irradiance[..rows.len()].par_iter_mut().enumerate().with_min_len(UNWATCHED).for_each(
            |(k, arriving)| {
                if k % UNWATCHED == 0 && cancelled() {
                    return;
                }
                *arriving = self.arriving(first + k, radiosity);
            },
        );
    }

    fn relax(
        &self,
        radiosity: &mut [Lanes],
        cancelled: Cancelled,
        update: &mut dyn FnMut(usize, Lanes, f64) -> Lanes,
    ) {
        self.passes.fetch_add(1, Ordering::Relaxed);
        for i in 0..self.areas.len() {
            if i % UNWATCHED == 0 && cancelled() {
                return;
            }
            let arriving = self.arriving(i, radiosity);
            let own = self.diagonal[i] / self.areas[i];
            let others = std::array::from_fn(|lane| arriving[lane] - own * radiosity[i][lane]);
            radiosity[i] = update(i, others, own);
        }
    }

    fn coarsen<'a>(&'a self, part_of: &'a [u32]) -> Coarsened<'a> {
        Box::new(move |i, sums| {
            let (columns, values) = self.stored(i);
            for (&j, &s) in columns.iter().zip(values) {
                sums[part_of[j as usize] as usize] += f64::from(s);
            }
        })
    }

    fn row(&self, i: usize) -> Vec<(u32, f64)> {
        let (columns, values) = self.stored(i);
        columns.iter().zip(values).map(|(&j, &s)| (j, f64::from(s))).collect()
    }

    fn row_entries(&self, i: usize) -> usize {
        self.stored(i).0.len()
    }

    fn kind(&self) -> TransportKind {
        TransportKind::Matrix
    }

    fn own(&self, i: usize) -> f64 {
        self.diagonal[i]
    }

    fn row_sum(&self, i: usize) -> f64 {
        let (_, values) = self.stored(i);
        (values.iter().map(|&v| f64::from(v)).sum::<f64>() + self.diagonal[i]) / self.areas[i]
    }

    fn sees(&self, i: usize) -> bool {
        let (_, values) = self.stored(i);
        self.diagonal[i] > 0.0 || values.iter().any(|&s| s > 0.0)
    }

    fn quality(&self, i: usize) -> RowQuality {
        self.quality[i]
    }

    fn report(&self) -> &AssembleReport {
        &self.report
    }

    fn passes(&self) -> u64 {
        self.passes.load(Ordering::Relaxed)
    }

    fn entries(&self) -> usize {
        self.columns.len()
    }

    fn bytes(&self) -> usize {
        self.columns.len() * 8 + self.areas.len() * 44
    }

    fn get(&self, i: usize, j: usize) -> f64 {
        let (columns, values) = self.stored(i);
        let stored = columns.binary_search(&(j as u32)).map_or(0.0, |k| f64::from(values[k]));
        (stored + if i == j { self.diagonal[i] } else { 0.0 }) / self.areas[i]
    }
}
