//! Methods, resolutions and patch sizes against each other.

use super::audited::audit;
use super::table::Row;
use crate::accuracy::AuditSettings;
use crate::form_factors::{Method, ReceivingPoints};
use crate::mesh::PatchTarget;
use crate::scene::{Lighting, Scene};
use crate::solve::{Control, PipelineError, Progress, SolveSettings, solve};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// One point of the sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// How form factors are computed.
    pub method: Method,
    /// Half-planes, cells along an edge or rays.
    pub resolution: u32,
    /// At how many points of a patch its row is gathered.
    pub points: ReceivingPoints,
    /// Patches asked for.
    pub patches: usize,
}

impl Entry {
    /// Expected milliseconds of its rows on one thread: by benches of the default scene, good for
    /// bringing entries into order and for little else before it is scaled.
    pub fn nominal(&self) -> f64 {
        let n = f64::from(self.resolution);
        let row = match self.method {
            Method::Lines => 0.011 + 0.000_47 * n,
            Method::Hemicube | Method::AlignedHemicube => 0.6 + 2.0e-5 * n * n,
            Method::Rays => 0.000_5 * n,
        };
        let several = match self.points {
            ReceivingPoints::Auto | ReceivingPoints::One => 1.0,
            ReceivingPoints::Four => 4.0,
            ReceivingPoints::Sixteen => 16.0,
        };
        self.patches as f64 * row * several + 2e-5 * (self.patches as f64).powi(2)
    }
}

const LINES: [u32; 7] = [16, 32, 64, 128, 256, 512, 1024];
const HEMICUBE: [u32; 6] = [32, 64, 128, 256, 512, 1024];
const RAYS: [u32; 5] = [256, 1024, 4096, 16_384, 65_536];

/// Receiving points other than those that are chosen by themselves, at the usual number of patches: one,
/// as in 1985, and so many that nothing but the resolution is left.
const FIXED_POINTS: [(Method, ReceivingPoints, &[u32]); 5] = [
    (Method::Lines, ReceivingPoints::One, &[32, 64, 128, 256, 512]),
    (Method::Lines, ReceivingPoints::Sixteen, &[32, 64, 128, 256, 512, 1024]),
    (Method::Hemicube, ReceivingPoints::Sixteen, &[32, 64, 128, 256]),
    (Method::AlignedHemicube, ReceivingPoints::One, &HEMICUBE),
    (Method::AlignedHemicube, ReceivingPoints::Sixteen, &[64, 128, 256]),
];

/// So many points of every curve of the chart come before all others, but for the dear ones.
const FIRST_OF_EACH: usize = 2;

/// All points for a scene that has `usual` patches by itself: at that many all resolutions and numbers
/// of receiving points, at fewer and at more those that suit.
///
/// First comes the cheapest point at `usual` patches of each method and number of receiving points, then
/// the second cheapest of each, then all others; each time by rising [`Entry::nominal`]. So a sweep that
/// ends early has every curve of the chart begun, but those of sixteen points, which cost so many times as
/// much and wait for their turn.
pub fn entries(usual: usize) -> Vec<Entry> {
    let methods: [(Method, &[u32]); 3] =
        [(Method::Lines, &LINES), (Method::Hemicube, &HEMICUBE), (Method::Rays, &RAYS)];
    let usual = usual.max(1);
    let mut all: Vec<Entry> = Vec::new();
    for (patches, skip_fine) in [(usual, 0), (usual / 4, 2), (3 * usual, 1), (8 * usual, 3)] {
        for (method, resolutions) in methods {
            for &resolution in &resolutions[..resolutions.len() - skip_fine] {
                all.push(Entry { method, resolution, points: ReceivingPoints::Auto, patches });
            }
        }
    }
    for (method, points, resolutions) in FIXED_POINTS {
        let entry = |&resolution: &u32| Entry { method, resolution, points, patches: usual };
        all.extend(resolutions.iter().map(entry));
    }
    all.retain(|entry| entry.patches > 0);
    all.sort_by(|a, b| a.nominal().total_cmp(&b.nominal()));
    let mut begun: Vec<(Method, ReceivingPoints)> = Vec::new();
    all.sort_by_cached_key(|entry| {
        if entry.patches != usual || entry.points == ReceivingPoints::Sixteen {
            return FIRST_OF_EACH;
        }
        let curve = (entry.method, entry.points);
        begun.push(curve);
        (begun.iter().filter(|&&c| c == curve).count() - 1).min(FIRST_OF_EACH)
    });
    all
}

/// Seconds that solving and auditing `entry` will take, by what the dearest of the `measured` rows of its
/// method took, or where there is none, the dearest of all. `None` where nothing was measured.
pub fn foreseen(entry: Entry, measured: &[Row]) -> Option<f64> {
    let order = |row: &&Row| (row.entry.method == entry.method, row.entry.nominal());
    let like = measured.iter().max_by(|a, b| {
        let (a, b) = (order(a), order(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    })?;
    let solve = like.total_seconds / like.entry.nominal() * entry.nominal();
    let of_its_time = like.budget.seconds / audit_seconds(like.total_seconds);
    Some(solve + of_its_time * audit_seconds(solve))
}

/// How long the audit of a solve that took `solve` seconds may last.
fn audit_seconds(solve: f64) -> f64 {
    (2.0 * solve).clamp(8.0, 40.0)
}

/// Solves and audits one point.
///
/// # Errors
/// As the pipeline.
pub fn measure(
    scene: &Arc<Scene>,
    lighting: &Lighting,
    entry: Entry,
    observer: &mut dyn FnMut(Option<&Progress<'_>>) -> Control,
) -> Result<Row, PipelineError> {
    let settings = SolveSettings {
        patches: PatchTarget::Count(entry.patches),
        method: entry.method,
        resolution: Some(entry.resolution),
        points: entry.points,
        ..SolveSettings::default()
    };
    forget_peak_memory();
    let clock = Instant::now();
    let solved =
        solve(scene.clone(), &settings, &AtomicBool::new(false), &mut |progress| observer(Some(&progress)))?;
    let seconds = clock.elapsed().as_secs_f64();
    let peak_memory = crate::export::peak_memory_bytes();
    if observer(None) == Control::Cancel {
        return Err(PipelineError::Cancelled);
    }
    let thorough = AuditSettings {
        precision: 0.08,
        parts: true,
        resolve: 4e-4,
        local_noise: 0.02,
        receivers: 12_288,
        seconds: audit_seconds(seconds),
        ..AuditSettings::default()
    };
    let budget = audit(&solved, lighting, &thorough, &|| false).map(|found| found.budget);
    let t = &solved.timings;
    Ok(Row {
        scene: scene.name.clone(),
        hash: super::scene_hash(scene),
        threads: rayon::current_num_threads(),
        entry,
        patches: solved.mesh.patches.len(),
        seconds: [t.mesh + t.plan, t.rows, t.balance, t.sweeps],
        total_seconds: seconds,
        peak_memory,
        budget: budget.unwrap_or_default(),
    })
}

/// Lets the high-water mark of this process begin anew, where the system can (Linux).
fn forget_peak_memory() {
    // Where it cannot, the peak is that of all solves so far.
    std::fs::write("/proc/self/clear_refs", "5").ok();
}

/// Indices of the points `[cost, error]` that no other beats in both, by rising cost; points that are
/// not above zero take no part.
pub fn pareto(points: &[[f64; 2]]) -> Vec<usize> {
    let valid = |p: &[f64; 2]| p.iter().all(|v| v.is_finite() && *v > 0.0);
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| valid(&points[i])).collect();
    order.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]).then(points[a][1].total_cmp(&points[b][1])));
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i][1] < best;
        best = best.min(points[i][1]);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::super::chart::CURVES;
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points =
            [[1.0, 5.0], [2.0, 6.0], [2.0, 3.0], [3.0, 3.0], [4.0, 1.0], [0.5, 0.0], [9.0, f64::NAN]];
        assert_eq!(pareto(&points), [0, 2, 4]);
        assert!(pareto(&[]).is_empty());
    }

    #[test]
    fn every_curve_of_the_chart_is_begun_first_and_the_rest_comes_cheapest_first_and_once() {
        for usual in [0, 1, 3, 60, 2000, 9000, 100_000] {
            let all = entries(usual);
            let usual = usual.max(1);
            for (i, entry) in all.iter().enumerate() {
                assert!(!all[..i].contains(entry), "{entry:?} twice");
                let curves = CURVES.iter().filter(|c| (c.0, c.1) == (entry.method, entry.points));
                assert_eq!(curves.count(), 1, "{entry:?} is on no curve");
            }
            let early = || CURVES.iter().filter(|curve| curve.1 != ReceivingPoints::Sixteen);
            let count = early().count();
            for (turn, first) in all.chunks(count).take(FIRST_OF_EACH).enumerate() {
                for &(method, points, name, _) in early() {
                    let of_curve = |e: &&Entry| (e.method, e.points, e.patches) == (method, points, usual);
                    let own: Vec<&Entry> = first.iter().filter(of_curve).collect();
                    assert_eq!(own.len(), 1, "{usual} patches: {name} in {first:?}");
                    let mut costs: Vec<f64> = all.iter().filter(of_curve).map(Entry::nominal).collect();
                    costs.sort_by(f64::total_cmp);
                    assert_eq!(own[0].nominal(), costs[turn], "{name}: not its cheapest");
                }
            }
            let dozen = &all[..12.min(all.len())];
            assert!(Method::ALL.into_iter().all(|m| dozen.iter().any(|e| e.method == m)), "{dozen:?}");
            let rest = &all[FIRST_OF_EACH * count..];
            assert!(rest.is_sorted_by(|a, b| a.nominal() <= b.nominal()));
            for method in [Method::Lines, Method::Hemicube, Method::Rays] {
                assert!(all.iter().filter(|e| e.method == method && e.patches == usual).count() >= 5);
            }
        }
    }

    #[test]
    fn what_an_entry_will_take_is_foreseen_by_the_dearest_of_its_method() {
        let entry = |method: Method, resolution: u32| Entry {
            method,
            resolution,
            points: ReceivingPoints::Auto,
            patches: 2000,
        };
        let row = |entry: Entry, times: f64, audit: f64| Row {
            entry,
            total_seconds: times * entry.nominal() / 1000.0,
            budget: crate::accuracy::ErrorBudget { seconds: audit, ..Default::default() },
            ..Row::default()
        };
        let (cheap, dear) = (entry(Method::Hemicube, 64), entry(Method::Hemicube, 1024));
        assert_eq!(foreseen(dear, &[]), None);
        // A small solve that was mostly overhead foretells nothing dear once another is known.
        let rows = [row(cheap, 2.0, 4.0), row(entry(Method::Hemicube, 512), 1.0, 1.0)];
        let limit = audit_seconds(rows[1].total_seconds);
        let (solve, told) = (dear.nominal() / 1000.0, foreseen(dear, &rows).unwrap());
        assert!((told / (solve + 40.0 / limit) - 1.0).abs() < 1e-9, "{told}: its audit is as thorough");
        // Nor does what another method took, once its own is known.
        let (rays, lines) = (entry(Method::Rays, 65_536), entry(Method::Lines, 16));
        let told = foreseen(rays, &rows).unwrap();
        assert!((told / (rays.nominal() / 1000.0 + 40.0 / limit) - 1.0).abs() < 1e-9, "{told}");
        let own = [rows.to_vec(), vec![row(lines, 3.0, 0.0)]].concat();
        let told = foreseen(lines, &own).unwrap();
        assert!((told / (3.0 * lines.nominal() / 1000.0) - 1.0).abs() < 1e-9, "{told}");
    }
}
