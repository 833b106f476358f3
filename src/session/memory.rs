//! What a solve will take of the memory, before it begins.

use super::PipelineError;
use crate::form_factors::RowComputer;
use crate::solver::System;
use rayon::prelude::*;

/// Rows that are tried to see what all would take, and form factors of each that are looked at from the other
/// side.
const PROBES: usize = 48;
const MIRRORED: usize = 3;
/// Of the memory that is free a solve may take this part.
const MOST_MEMORY: f64 = 0.9;

/// Refuses beforehand what would not fit: extrapolates from a few rows.
///
/// A row takes 8 bytes a form factor, and so do the blocks made of the rows and the matrix made of those, as
/// what is freed in between is not handed back. They hold each pair on both sides even where only one of them
/// has found the other: with few half-planes and many patches that is almost twice what the rows hold.
/// Measured: house, 65,536 patches by 48 half-planes, 163 million form factors, 3.3 GB.
pub(super) fn check_memory(computer: &RowComputer, system: &System) -> Result<(), PipelineError> {
    let n = computer.mesh().patches.len();
    let Some(available) = available_bytes() else { return Ok(()) };
    let columns = system.columns() as f64 * 60.0 + 400.0;
    let all_pairs = n as f64 * (n as f64 * 8.0 * 3.0 + columns);
    if all_pairs <= MOST_MEMORY * available {
        return Ok(());
    }
    let probes: Vec<u32> = (0..PROBES.min(n)).map(|k| (k * n / PROBES.min(n)) as u32).collect();
    let tried: Vec<[usize; 3]> = probes
        .par_iter()
        .map_init(
            || computer.scratch(),
            |scratch, &i| {
                let row = computer.row(i, scratch);
                let count = row.patches.len();
                let others =
                    (0..MIRRORED.min(count)).map(|k| row.patches[(2 * k + 1) * count / (2 * MIRRORED)]);
                let others: Vec<u32> = others.collect();
                let mutual = others.iter().filter(|&&j| computer.row(j, scratch).get(i) > 0.0).count();
                [count, others.len(), mutual]
            },
        )
        .collect();
    let sum = |what: usize| tried.iter().map(|t| t[what]).sum::<usize>() as f64;
    let per_row = sum(0) / probes.len().max(1) as f64;
    let both = 2.0 - sum(2) / sum(1).max(1.0);
    let needed = n as f64 * (per_row * 8.0 * (1.0 + 2.0 * both) + columns);
    if needed <= MOST_MEMORY * available {
        return Ok(());
    }
    // Entries grow with the square of the patches.
    let fitting = n as f64 * (MOST_MEMORY * available / needed).sqrt();
    Err(PipelineError::Memory {
        patches: n,
        needed_gb: needed / 1e9,
        available_gb: available / 1e9,
        fitting: (fitting / 100.0).floor() as usize * 100,
    })
}

/// Memory that can be had without swapping, bytes, where the system tells (Linux).
pub fn available_bytes() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok().map(|kb| kb * 1024.0)
}
