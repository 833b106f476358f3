//! Some rows tried out, spread over the scene: what all of them will cost.

use crate::effects::Effect;
use crate::form_factors::{Method, ReceivingPoints, RowComputer, Sampling};
use crate::solve::{Prepared, Solution};
use crate::transport::{LANES, Transport};
use rayon::prelude::*;
use std::time::Instant;

/// What the rows of a mesh will come to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trial {
    /// Half-planes a row.
    pub lines: u32,
    /// Seconds of all rows.
    pub rows: f64,
    /// Form factors that they will hold.
    pub entries: f64,
}

/// Rows that are tried.
const TRIED: usize = 96;
/// Rows that are tried to learn what lines cost, how often, by how many times as many lines, and at least
/// and at most by how many.
const COMPARED: usize = 24;
const REPEATS: usize = 2;
const TIMES: u32 = 4;
const FEWEST: u32 = 24;
const MOST: u32 = 64;
/// How often, and over how many form factors about, gathering is tried.
const GATHERINGS: usize = 5;
const GATHERED: usize = 1_000_000;
/// What a row costs besides its lines lies between these, as lines.
const OVERHEAD: [f64; 2] = [8.0, 400.0];

/// Rows spread over a mesh, at a stride that no grid of patches shares.
fn spread(computer: &RowComputer, most: usize) -> Vec<u32> {
    let n = computer.mesh().patches.len();
    (0..most.min(n)).map(|k| ((k as f64 * 0.618_033_988_75).fract() * n as f64) as u32).collect()
}

/// Tries some rows, of so many half-planes, of a mesh by all threads of the pool.
pub fn trial(prepared: &Prepared, lines: u32) -> Trial {
    let computer = &prepared.computer;
    let rows = spread(computer, TRIED);
    let n = computer.mesh().patches.len() as f64;
    let clock = Instant::now();
    let entries: usize = rows
        .par_iter()
        .map_init(|| computer.scratch(), |scratch, &i| computer.row(i, scratch).patches.len())
        .sum();
    let share = n / rows.len().max(1) as f64;
    Trial { lines, rows: clock.elapsed().as_secs_f64() * share, entries: entries as f64 * share }
}

/// What work costs on this machine, besides what the solves themselves tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// What one row costs besides its lines, as lines.
    pub overhead: f64,
    /// Seconds of gathering all lanes once over one stored form factor, by all threads of the pool.
    pub gathering: f64,
}

/// Measures the pace of a scene that was solved by so many lines, in some tens of milliseconds.
pub fn pace(solved: &Solution, lines: u32) -> Pace {
    Pace {
        overhead: row_overhead(solved, lines),
        gathering: solved.transport.as_deref().map_or(0.0, gathering),
    }
}

/// The shortest of some gatherings over the first rows.
fn gathering(transport: &dyn Transport) -> f64 {
    let light = vec![[1.0; LANES]; transport.len()];
    let mut arriving = light.clone();
    let (mut rows, mut entries) = (0, 0);
    while rows < transport.len() && entries < GATHERED {
        entries += transport.row_entries(rows);
        rows += 1;
    }
    let mut once = || {
        let clock = Instant::now();
        transport.gather(0..rows, &light, &mut arriving, &|| false);
        std::hint::black_box(&arriving);
        clock.elapsed().as_secs_f64()
    };
    (0..GATHERINGS).map(|_| once()).fold(f64::INFINITY, f64::min) / entries.max(1) as f64
}

/// What one row of a solved scene costs besides its lines, as lines: with t and T the times of some rows
/// by n and by 4 n lines, (4 n + x) / (n + x) = T / t. Takes `lines` as 4 n, where those are not too few, nor so many that
/// receiving points are chosen otherwise. Runs on the calling thread, for some fifty rows.
fn row_overhead(solved: &Solution, lines: u32) -> f64 {
    let visibility = solved.plan.is_on(Effect::Visibility);
    let few = if lines >= TIMES * FEWEST { (lines / TIMES).min(MOST) } else { lines };
    let computers = [few, TIMES * few].map(|lines| {
        let points = ReceivingPoints::Auto;
        let sampling = Sampling { method: Method::Lines, resolution: Some(lines), points };
        RowComputer::new(solved.mesh.clone(), sampling, visibility)
    });
    let mut scratches = computers.each_ref().map(RowComputer::scratch);
    let mut seconds = [0.0; 2];
    for i in spread(&computers[0], COMPARED) {
        for (k, computer) in computers.iter().enumerate() {
            // The shortest counts: what else the machine does is none of the row's cost.
            let once = |scratch: &mut _| {
                let clock = Instant::now();
                std::hint::black_box(computer.row(i, scratch));
                clock.elapsed().as_secs_f64()
            };
            let times = (0..REPEATS).map(|_| once(&mut scratches[k]));
            seconds[k] += times.fold(f64::INFINITY, f64::min);
        }
    }
    let (ratio, times) = (seconds[1] / seconds[0], f64::from(TIMES));
    let overhead = f64::from(few) * (times - ratio) / (ratio - 1.0).max(1e-3);
    if overhead.is_finite() { overhead.clamp(OVERHEAD[0], OVERHEAD[1]) } else { OVERHEAD[0] }
}
