//! What a solve will take of the memory, before it begins.

use super::PipelineError;
use super::pipeline::Prepared;
use crate::form_factors::RowComputer;
use crate::memory::{available_bytes, told};
use crate::scene::grouped;
use crate::solver::System;
use crate::transport::TransportKind;
use rayon::prelude::*;

/// Rows that are tried to see what all would take, and form factors of each that are looked at from the other
/// side.
const PROBES: usize = 48;
const MIRRORED: usize = 3;
/// So few rows are enough where they alone tell that a solve would take this many times the memory there is.
const FEW_PROBES: usize = 8;
const HOPELESS: f64 = 1.5;
/// Of the memory that is free a solve may take this part.
const MOST_MEMORY: f64 = 0.9;

/// What other steps take beside form factors, direct light and pictures among them, bytes.
const RESERVED: f64 = 1.2e8;

/// Up to so many patches, and so many bytes while it is built, the matrix is taken where nothing else is asked for: it
/// is made from both samples of each pair, and takes no longer there: house, 22,000 patches, 69 s against 80 s.
const MOST_IN_MATRIX: usize = 40_000;
const MATRIX_BYTES: f64 = 4e9;
/// Bytes of the matrix per form factor while it is built, and of the tree per entry; entries of a row of the tree, which
/// grow little with the patches; and bytes per patch of what its nodes are judged by.
const PER_FACTOR: f64 = 24.0;
const PER_ENTRY: f64 = 9.0;
const ENTRIES: f64 = 800.0;
const PER_JUDGED: f64 = 500.0;

/// Which transport is taken where this one is asked for; a few rows tell where numbers alone do not. `None` where it was
/// cancelled.
fn chosen(
    computer: &RowComputer,
    wanted: TransportKind,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<TransportKind> {
    let n = computer.mesh().patches.len();
    let all = (n as f64).powi(2) * PER_FACTOR;
    Some(match wanted {
        TransportKind::Matrix | TransportKind::Tree => wanted,
        TransportKind::Auto if n > MOST_IN_MATRIX => TransportKind::Tree,
        TransportKind::Auto if all <= MATRIX_BYTES => TransportKind::Matrix,
        TransportKind::Auto => {
            let probes = spread(n, FEW_PROBES);
            let [entries, ..] = tried(computer, &probes, 0, cancelled)?;
            let bytes = n as f64 * entries / probes.len().max(1) as f64 * PER_FACTOR;
            if bytes <= MATRIX_BYTES { TransportKind::Matrix } else { TransportKind::Tree }
        }
    })
}

/// So many patches spread over all.
fn spread(patches: usize, count: usize) -> Vec<u32> {
    let count = count.min(patches);
    (0..count).map(|k| (k * patches / count) as u32).collect()
}

/// Decides which transport the rows are for, and refuses beforehand what would not fit: extrapolates from a few rows.
///
/// Of the matrix a row takes 8 bytes a form factor, and so do the blocks made of the rows and the matrix made of those, as
/// what is freed in between is not handed back. They hold each pair on both sides even where only one of them
/// has found the other: with few half-planes and many patches that is almost twice what the rows hold.
/// Measured: house, 65,536 patches by 48 half-planes, 163 million form factors, 3.3 GB.
///
/// Polls `cancelled` between rows. What is out of the question is refused after a handful of them: in a model
/// of so many faces a single one may take a second.
pub(super) fn check_memory(
    computer: &RowComputer,
    system: &System,
    wanted: TransportKind,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<TransportKind, PipelineError> {
    let n = computer.mesh().patches.len();
    let kind = chosen(computer, wanted, cancelled).ok_or(PipelineError::Cancelled)?;
    let Some(available) = available_bytes().map(|free| (free - RESERVED).max(0.0)) else { return Ok(kind) };
    let columns = system.columns() as f64 * 60.0 + 400.0;
    let refused = |needed: f64, fitting: f64| PipelineError::Memory {
        patches: n,
        whole: computer.mesh().statistics.whole_sides,
        needed_gb: needed / 1e9,
        available_gb: available / 1e9,
        fitting: (fitting / 100.0).floor() as usize * 100,
    };
    if kind == TransportKind::Tree {
        let needed = n as f64 * (ENTRIES.min(n as f64) * PER_ENTRY + PER_JUDGED + columns);
        let most = MOST_MEMORY * available;
        return if needed <= most { Ok(kind) } else { Err(refused(needed, n as f64 * most / needed)) };
    }
    let all_pairs = n as f64 * (n as f64 * PER_FACTOR + columns);
    if all_pairs <= MOST_MEMORY * available {
        return Ok(kind);
    }
    let probes = spread(n, PROBES);
    let bytes = |per_row: f64, sides: f64| n as f64 * (per_row * 8.0 * (1.0 + 2.0 * sides) + columns);
    let hopeless = || {
        // Spread over the scene, as the others are.
        let few =
            probes.iter().copied().step_by(probes.len().div_ceil(FEW_PROBES).max(1)).collect::<Vec<u32>>();
        let [entries, ..] = tried(computer, &few, 0, cancelled)?;
        let least = bytes(entries / few.len() as f64, 1.0);
        Some(least).filter(|&least| least > HOPELESS * available)
    };
    let needed = match hopeless() {
        Some(least) => least,
        None => {
            let [entries, others, mutual] =
                tried(computer, &probes, MIRRORED, cancelled).ok_or(PipelineError::Cancelled)?;
            bytes(entries / probes.len().max(1) as f64, 2.0 - mutual / others.max(1.0))
        }
    };
    if needed <= MOST_MEMORY * available {
        return Ok(kind);
    }
    // Entries grow with the square of the patches.
    Err(refused(needed, n as f64 * (MOST_MEMORY * available / needed).sqrt()))
}

/// What a transport will come to, as a few rows tell it beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Which is taken; never [`TransportKind::Auto`].
    pub kind: TransportKind,
    /// Values that it will store, about.
    pub entries: f64,
    /// Bytes that these will take once it stands, about.
    pub bytes: f64,
}

/// Tells beforehand which transport a solve of this scene takes and how large it will be, from a few rows.
pub fn predicted(prepared: &Prepared) -> Predicted {
    let computer = &prepared.computer;
    let n = computer.mesh().patches.len() as f64;
    let never = || false;
    let kind = chosen(computer, prepared.transport, &never).unwrap_or(TransportKind::Matrix);
    let probes = spread(computer.mesh().patches.len(), PROBES);
    let [entries, others, mutual] = tried(computer, &probes, MIRRORED, &never).unwrap_or_default();
    let per_row = entries / probes.len().max(1) as f64;
    let per_row = match kind {
        TransportKind::Tree => per_row.min(ENTRIES),
        _ => per_row * (2.0 - mutual / others.max(1.0)),
    };
    Predicted { kind, entries: n * per_row, bytes: n * per_row * 8.0 }
}

/// Form factors of these rows; of `mirrored` of each how many were looked at from the other side, and how many
/// of those are seen from there as well. `None` where it was cancelled.
fn tried(
    computer: &RowComputer,
    rows: &[u32],
    mirrored: usize,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<[f64; 3]> {
    let found: Option<Vec<[usize; 3]>> = rows
        .par_iter()
        .map_init(
            || computer.scratch(),
            |scratch, &i| {
                if cancelled() {
                    return None;
                }
                let row = computer.row(i, scratch);
                let count = row.patches.len();
                let others =
                    (0..mirrored.min(count)).map(|k| row.patches[(2 * k + 1) * count / (2 * mirrored)]);
                let others: Vec<u32> = others.collect();
                let mutual = others.iter().filter(|&&j| computer.row(j, scratch).get(i) > 0.0).count();
                Some([count, others.len(), mutual])
            },
        )
        .collect();
    let found = found?;
    Some([0, 1, 2].map(|what| found.iter().map(|t| t[what]).sum::<usize>() as f64))
}

/// Why the form factors of so many patches cannot be held, and what helps.
pub(super) fn too_large(
    patches: usize,
    whole: usize,
    [needed_gb, available_gb]: [f64; 2],
    fitting: usize,
) -> String {
    let [patches_told, whole_told, fitting_told] = [patches, whole, fitting].map(|n| grouped(n as i64));
    let refused = format!(
        "{patches_told} patches need about {} for their form factors and this process can have {}; about {fitting_told} \
         patches would fit",
        told(1e9 * needed_gb),
        told(1e9 * available_gb)
    );
    if fitting == 0 {
        format!(
            "{patches_told} patches need about {} for their form factors and other steps leave this process none: close other \
             programs, or raise its limit (ulimit -v, that of a container)",
            told(1e9 * needed_gb)
        )
    } else if fitting > whole {
        let count = grouped(fitting.saturating_sub(whole) as i64);
        let besides = if whole > 0 { format!(" (about {count} besides small faces)") } else { String::new() };
        format!("{refused}: ask for fewer patches{besides} or larger ones")
    } else {
        format!(
            "{refused}, and {whole_told} sides of small faces need one each, whatever number or size is asked for: \
             simplify or remove what has so many faces (leaves, mouldings, screws)"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_is_what_helps() {
        let told = too_large(60_000, 0, [30.0, 10.0], 34_600);
        assert!(
            told.contains("about 34,600 patches would fit: ask for fewer patches or larger ones"),
            "{told}"
        );
        let told = too_large(60_000, 20_000, [30.0, 10.0], 34_600);
        assert!(told.contains("fewer patches (about 14,600 besides small faces)"), "{told}");
        let told = too_large(193_099, 190_000, [120.0, 20.0], 78_800);
        assert!(told.contains("190,000 sides of small faces") && !told.contains("ask for fewer"), "{told}");
    }
}
