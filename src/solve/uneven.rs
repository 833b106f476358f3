//! Direct light that leaves near patches unevenly.
//!
//! A row tells how much of what leaves a patch arrives at another, wherever on the patch it leaves. Beside a lamp or
//! across the edge of a shadow most of it leaves from a spot, and what lies near sees that spot under another angle than
//! the rest. Halving patches until that does not matter makes unknowns of what is known beforehand: direct light stands
//! on elements. So each patch whose direct light differs is divided into cells, and those who are near enough to tell
//! them apart get what the cells send instead of what their mean would. Visibility and the amount are those of the row;
//! only the weights within the patch are new.

use crate::direct::Elements;
use crate::emitters::Basis;
use crate::form_factors::{ReceivingPoints, RowComputer};
use crate::mesh::{Patch, PatchMesh};
use crate::solver::System;
use crate::transport::Transport;
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A receiver tells the cells of a patch apart where that changes its light by this share of the mean, about.
const SLIGHT: f64 = 1e-2;
/// Cells along an edge grow with the reach of a patch over its radius, and are so many at most.
const CELLS: f64 = 2.0;
const MOST_CELLS: f64 = 12.0;
/// Nearer than this many times both radii the centre of a receiver does not stand for all of it.
const CLOSE: f64 = 2.0;
/// Whether a cell is seen is looked at where that may change light by more than this share of the mean.
const NOTABLE: f64 = 5e-4;
/// What changes light by less than this share of the mean is not kept.
const NOTHING: f64 = 1e-5;

/// A patch in cells.
#[derive(Clone, Debug)]
struct Divided {
    patch: u32,
    /// Who is farther away than this from its centre cannot tell its cells apart, metres.
    reach: f64,
    cells: Vec<Cell>,
}

/// A part of a patch.
#[derive(Clone, Debug)]
struct Cell {
    /// Centroid, metres.
    centre: DVec3,
    /// m².
    area: f64,
    /// All that its light differs by, over the mean of the scene.
    difference: f64,
    /// Basis and its direct light here less that of the patch in the mean, per unit of exitance.
    deviation: Vec<(u32, f32)>,
}

/// What arrives at a patch from another since light does not leave that evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    from: u32,
    basis: u32,
    /// Irradiance per unit of the basis' exitance and of the reflectance of `from`; of either sign.
    value: f32,
}

/// For each patch what its neighbours send it besides what their means do.
#[derive(Clone, Debug, Default)]
pub struct UnevenLight {
    /// Where the entries of each patch end.
    ends: Vec<u32>,
    entries: Vec<Entry>,
}

impl UnevenLight {
    /// Looks at all pairs of a transport that it holds one by one: a tree holds those so that are [near enough](Self::reach).
    ///
    /// `exitance` tells how much each basis of the elements counts.
    ///
    /// # Errors
    /// The watch ended it.
    pub(super) fn find(
        computer: &RowComputer,
        transport: &dyn Transport,
        elements: &Elements,
        exitance: &[f64],
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let mesh = computer.mesh();
        let (divided, mean) = divided(mesh, elements, exitance);
        let mut index_of = vec![u32::MAX; mesh.patches.len()];
        for (index, own) in divided.iter().enumerate() {
            index_of[own.patch as usize] = index as u32;
        }
        let least = NOTHING * mean;
        let rows = watch.map(&mesh.patches, |i, receiver| {
            let mut found = Vec::new();
            if receiver.buried || !transport.sees(i) {
                return found;
            }
            for (j, exchange) in transport.singles(i) {
                let Some(from) = divided.get(index_of[j as usize] as usize) else { continue };
                let distance = receiver.centre.distance(mesh.patches[j as usize].centre);
                if distance < from.reach {
                    let factor = exchange / receiver.area;
                    let entries = entries(computer, (i as u32, receiver), from, (factor, distance));
                    found.extend(entries.into_iter().filter(|entry| {
                        f64::from(entry.value.abs()) * exitance[entry.basis as usize] > least
                    }));
                }
            }
            found
        })?;
        let mut all = Self::default();
        for row in rows {
            all.entries.extend(row);
            all.ends.push(all.entries.len() as u32);
        }
        Ok(all)
    }

    /// What arrives in each column of a system, `[patch * columns + column]`, W/m² per unit of exitance.
    pub(super) fn arriving(&self, bases: &[Basis], system: &System) -> Vec<f64> {
        let columns = system.columns();
        let mut values = vec![0.0; system.patches() * columns];
        if columns == 0 {
            return values;
        }
        values.par_chunks_exact_mut(columns).zip(0..self.ends.len()).for_each(|(own, i)| {
            let start = if i == 0 { 0 } else { self.ends[i - 1] as usize };
            for entry in &self.entries[start..self.ends[i] as usize] {
                let basis = &bases[entry.basis as usize];
                for band in 0..system.bands {
                    let column = basis.lamp as usize * system.bands + band;
                    let rho = system.rho(entry.from as usize, column);
                    own[column] += basis.weight_of(band, system.bands) * rho * f64::from(entry.value);
                }
            }
        });
        values
    }

    /// Within what distance receivers tell parts of each patch apart, metres; nought where none does.
    pub(super) fn reach(mesh: &PatchMesh, elements: &Elements, exitance: &[f64]) -> Vec<f32> {
        let mut reach = vec![0.0; mesh.patches.len()];
        for own in divided(mesh, elements, exitance).0 {
            reach[own.patch as usize] = own.reach as f32;
        }
        reach
    }

    /// All but what bases send that are `left_out`.
    pub(super) fn without(&self, left_out: impl Fn(u32) -> bool) -> Self {
        let mut kept = Self::default();
        let mut start = 0;
        for &end in &self.ends {
            let own = &self.entries[start..end as usize];
            kept.entries.extend(own.iter().filter(|entry| !left_out(entry.basis)));
            kept.ends.push(kept.entries.len() as u32);
            start = end as usize;
        }
        kept
    }

    /// How many pairs of a patch and a basis of another are kept.
    pub fn entries(&self) -> usize {
        self.entries.len()
    }
}

/// The patches within which direct light differs, in cells; and the mean of all direct light, W/m².
fn divided(mesh: &PatchMesh, elements: &Elements, exitance: &[f64]) -> (Vec<Divided>, f64) {
    let mut leaves: Vec<(u32, u32)> = elements.leaves_with_index().map(|(leaf, e)| (e.patch, leaf)).collect();
    leaves.sort_unstable();
    // 1. How much light differs within each patch.
    let spreads: Vec<(f64, f64, f64)> = leaves
        .chunk_by(|a, b| a.0 == b.0)
        .map(|own| {
            let (mut area, mut sum, mut square) = (0.0, 0.0, 0.0);
            for &(_, leaf) in own {
                let element = &elements.elements[leaf as usize];
                let size = elements.area(element);
                let at = element.corners.map(|corner| elements.watts_at(corner, exitance));
                let whole: f64 = at.iter().sum();
                area += size;
                sum += size * whole / 3.0;
                square += size / 12.0 * (whole * whole + at.iter().map(|x| x * x).sum::<f64>());
            }
            (area, sum, square)
        })
        .collect();
    let area: f64 = spreads.iter().map(|s| s.0).sum();
    let mean = spreads.iter().map(|s| s.1).sum::<f64>() / area.max(f64::MIN_POSITIVE);
    if mean <= 0.0 {
        return (Vec::new(), 0.0);
    }
    // 2. Those whose neighbours can tell.
    let lists: Vec<&[(u32, u32)]> = leaves.chunk_by(|a, b| a.0 == b.0).collect();
    let divided = lists
        .par_iter()
        .zip(&spreads)
        .filter_map(|(own, &(area, sum, square))| {
            let index = own[0].0;
            let patch = &mesh.patches[index as usize];
            if patch.is_cluster || patch.buried || area <= 0.0 {
                return None;
            }
            let deviation = (square / area - (sum / area).powi(2)).max(0.0).sqrt();
            // Seen from d, a patch of radius r fills (r / d)² of the sky, and its near parts count r / d more.
            let reach = (deviation / (SLIGHT * mean)).cbrt();
            if reach <= 1.0 {
                return None;
            }
            let along = (CELLS * reach).powf(0.75).clamp(2.0, MOST_CELLS);
            let mut cells = cells(mesh, elements, patch, own, along);
            cells.iter_mut().for_each(|cell| {
                let watts = cell.deviation.iter().map(|&(basis, v)| f64::from(v) * exitance[basis as usize]);
                cell.difference = (watts.sum::<f64>() / mean).abs();
            });
            let reach = (1.0 + reach) * patch.radius;
            (cells.len() > 1).then_some(Divided { patch: index, reach, cells })
        })
        .collect();
    (divided, mean)
}

/// A patch in cells of its plane, so many along its longer side.
fn cells(
    mesh: &PatchMesh,
    elements: &Elements,
    patch: &Patch,
    leaves: &[(u32, u32)],
    along: f64,
) -> Vec<Cell> {
    // 1. A grid over its pieces.
    let region = &mesh.regions[patch.region as usize];
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for corner in mesh.pieces_of(patch).flat_map(|piece| mesh.corners_of(piece)) {
        (min, max) = (min.min(corner.plane), max.max(corner.plane));
    }
    let extent = (max - min).max(DVec2::splat(f64::MIN_POSITIVE));
    let edge = extent.max_element() / along;
    let count = (extent / edge).ceil().max(DVec2::ONE).as_uvec2();
    let cell = extent / count.as_dvec2();
    let mut bases: Vec<u32> = Vec::new();
    for &(_, leaf) in leaves {
        for corner in elements.elements[leaf as usize].corners {
            bases.extend(elements.light_at(corner).iter().map(|light| light.0));
        }
        bases.sort_unstable();
        bases.dedup();
    }
    // 2. Small parts of the elements, each to the cell that it lies in.
    let n = bases.len();
    let mut sums = vec![(0.0_f64, DVec3::ZERO); (count.x * count.y) as usize];
    let mut light = vec![0.0_f64; sums.len() * n];
    let mut at = vec![[0.0_f64; 3]; n];
    for &(_, leaf) in leaves {
        let element = &elements.elements[leaf as usize];
        let [a, b, c] = elements.positions(element);
        at.fill([0.0; 3]);
        for (k, &corner) in element.corners.iter().enumerate() {
            for &(basis, value) in elements.light_at(corner) {
                if let Ok(place) = bases.binary_search(&basis) {
                    at[place][k] = f64::from(value);
                }
            }
        }
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let parts = (2.0 * longest / cell.min_element()).ceil().clamp(1.0, 24.0);
        let area = elements.area(element) / (parts * parts);
        let parts = parts as u32;
        let mut add = |i: f64, j: f64| {
            let (s, t) = (i / f64::from(parts), j / f64::from(parts));
            let point = a * (1.0 - s - t) + b * s + c * t;
            let from_origin = point - region.origin;
            let plane =
                DVec2::new(region.frame.tangent.dot(from_origin), region.frame.bitangent.dot(from_origin));
            let place = ((plane - min) / cell).max(DVec2::ZERO).as_uvec2().min(count - 1);
            let place = (place.x + place.y * count.x) as usize;
            sums[place].0 += area;
            sums[place].1 += area * point;
            for (sum, [p, q, r]) in light[place * n..][..n].iter_mut().zip(&at) {
                *sum += area * (p * (1.0 - s - t) + q * s + r * t);
            }
        };
        const THIRD: f64 = 1.0 / 3.0;
        for i in 0..parts {
            for j in 0..parts - i {
                add(f64::from(i) + THIRD, f64::from(j) + THIRD);
                if i + j + 1 < parts {
                    add(f64::from(i) + 2.0 * THIRD, f64::from(j) + 2.0 * THIRD);
                }
            }
        }
    }
    // 3. What they differ by from the mean.
    let whole: f64 = sums.iter().map(|sum| sum.0).sum();
    let means: Vec<f64> =
        (0..n).map(|k| light.iter().skip(k).step_by(n).sum::<f64>() / whole.max(f64::MIN_POSITIVE)).collect();
    sums.iter()
        .enumerate()
        .filter(|(_, sum)| sum.0 > 0.0)
        .map(|(place, &(area, sum))| Cell {
            centre: sum / area,
            area,
            difference: 0.0,
            deviation: bases
                .iter()
                .zip(&light[place * n..][..n])
                .zip(&means)
                .map(|((&basis, &value), mean)| (basis, (value / area - mean) as f32))
                .collect(),
        })
        .collect()
}

/// What a receiver gets from the cells of a patch at this distance besides what it would from their mean, given its
/// form factor to the patch.
fn entries(
    computer: &RowComputer,
    (index, receiver): (u32, &Patch),
    from: &Divided,
    (factor, distance): (f64, f64),
) -> Vec<Entry> {
    let sender = &computer.mesh().patches[from.patch as usize];
    let is_close = distance < CLOSE * (receiver.radius + sender.radius) && !receiver.is_cluster;
    // What a cell sends to a close receiver is in closed form from the cell; from afar one point stands for it.
    let (points, mut weights): (Vec<(DVec3, f64)>, Vec<f64>) = if is_close {
        let weight = |cell: &Cell| cell.area * computer.unoccluded(cell.centre, sender.normal, index);
        let points = computer.open_points(index, ReceivingPoints::Four, 0);
        (points, from.cells.iter().map(weight).collect())
    } else {
        let weight = |cell: &Cell| kernel(receiver, cell, sender);
        (vec![(receiver.centre, 1.0)], from.cells.iter().map(weight).collect())
    };
    let unhidden: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    for (weight, cell) in weights.iter_mut().zip(&from.cells) {
        if factor * *weight / unhidden * cell.difference > NOTABLE {
            let seen = points.iter().filter(|point| computer.rays().visible(point.0, cell.centre));
            *weight *= seen.map(|point| point.1).sum::<f64>();
        }
    }
    let whole: f64 = weights.iter().sum();
    let mut entries: Vec<Entry> = Vec::new();
    if !(whole > 0.0 && whole.is_finite()) {
        return entries;
    }
    for (weight, cell) in weights.iter().zip(&from.cells) {
        for &(basis, deviation) in &cell.deviation {
            let value = (factor * weight / whole * f64::from(deviation)) as f32;
            match entries.binary_search_by_key(&basis, |entry| entry.basis) {
                Ok(at) => entries[at].value += value,
                Err(at) => entries.insert(at, Entry { from: from.patch, basis, value }),
            }
        }
    }
    entries
}

/// What arrives at the centre of a patch from a small part of another, as a share of the radiosity there, without occlusion.
fn kernel(receiver: &Patch, cell: &Cell, sender: &Patch) -> f64 {
    let way = cell.centre - receiver.centre;
    let square = way.length_squared();
    // Facets of a cluster face this way and that.
    let towards = if receiver.is_cluster { square.sqrt() } else { receiver.normal.dot(way).max(0.0) };
    let cosines = towards * (-sender.normal.dot(way)).max(0.0);
    let value = cell.area * cosines / (std::f64::consts::PI * square * square);
    if value.is_finite() { value } else { 0.0 }
}
