//! Matrix and tree: two transports for the same light.

mod common;

use common::{Assembled, assembled, builtin, lines, room_with_blocks, solved};
use lumenwalk::form_factors::{Method, ReceivingPoints, Sampling};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, luminance_weighted};
use lumenwalk::solve::{
    Control, DirectTarget, Prepared, Progress, RowStore, Run, Solution, SolveSettings, Stage, Timings,
    patch_reflectance, prepare, system,
};
use lumenwalk::solver::LightBases;
use lumenwalk::transport::{LANES, Lanes, Transport, TransportKind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn by(kind: TransportKind, patches: usize) -> SolveSettings {
    // Direct light is the same to both: a coarse one will do.
    let direct = DirectTarget { most: 2000, work: 2_000_000, ..DirectTarget::default() };
    SolveSettings { transport: kind, resolution: Some(96), direct, ..lines(PatchTarget::Count(patches)) }
}

/// Irradiance of all patches as the lamps come, and the root mean square over the area of how it differs from another,
/// of its mean.
fn difference(one: &Solution, other: &Solution) -> f64 {
    let [a, b] = [one, other].map(|solved| solved.light(&solved.scene.lighting()).irradiance);
    let (mut area, mut sum, mut square) = (0.0, 0.0, 0.0);
    for ((patch, a), b) in one.mesh.patches.iter().zip(a).zip(b) {
        let [a, b] = [a, b].map(|h| luminance_weighted(h.map(f64::from)));
        area += patch.area;
        sum += patch.area * b;
        square += patch.area * (a - b).powi(2);
    }
    (square / area).sqrt() / (sum / area)
}

#[test]
fn both_transports_agree_on_all_embedded_scenes() {
    for (name, patches, within) in
        [("hemicube", 900, 0.004), ("cornell", 900, 0.004), ("gallery", 1500, 0.01), ("house", 1500, 0.02)]
    {
        let scene = builtin(name);
        let [matrix, tree] =
            [TransportKind::Matrix, TransportKind::Tree].map(|k| solved(&scene, &by(k, patches)));
        let [a, b] = [&matrix, &tree].map(|solved| solved.transport.as_ref().expect("whole"));
        assert_eq!([a.kind(), b.kind()], [TransportKind::Matrix, TransportKind::Tree]);
        let off = difference(&tree, &matrix);
        assert!(off < within, "{name}: {off} of the mean");
        let told = b.report();
        assert!(told.joined_error > 0.0 && told.joined_error < 0.004, "{name}: {told:?}");
        assert!(told.imbalance <= 1e-7 && told.kept < 1e-4, "{name}: {told:?}");
        assert!(b.entries() < a.entries(), "{name}: {} and {} entries", b.entries(), a.entries());
        let last = tree.sweeps.last().expect("sweeps");
        let gone = last.absorbed + last.escaped;
        assert!((gone - last.emitted).abs() <= 1e-4 * last.emitted, "{name}: {gone} of {} W", last.emitted);
    }
}

fn closed_room(kind: TransportKind, patches: usize) -> Assembled {
    assembled(&room_with_blocks(0.5).scene(), &by(kind, patches))
}

#[test]
fn a_closed_room_is_a_white_furnace_and_loses_no_power() {
    let made = closed_room(TransportKind::Tree, 900);
    let tree = &made.transport;
    assert_eq!(tree.kind(), TransportKind::Tree);
    let seeing = made.seeing();
    for &i in &seeing {
        let sampled = f64::from(tree.quality(i).sampled_sum);
        assert!((sampled - 1.0).abs() < 1e-4, "row {i} sums to {sampled} as sampled");
        assert!((tree.row_sum(i) - 1.0).abs() < 1e-7, "row {i} sums to {}", tree.row_sum(i));
    }
    let rho = |i: usize| 0.98 * (0.618_033_988_75 * i as f64).fract();
    let b = made.radiosity(&made.grey_system(|i| (rho(i), 1.0 - rho(i))), 1e-8);
    for &i in &seeing {
        assert!((b[i] - 1.0).abs() < 1e-5, "patch {i}: B = {}", b[i]);
    }
    // Brighter than any paint: what is lost in a pass would show fifty times.
    let system = made.system(Some(&vec![[0.98; 3]; made.patches().len()]));
    let (_, sweeps) = made.sweep(&system, 1e-8);
    let last = sweeps.last().expect("sweeps");
    let gone = last.absorbed + last.escaped;
    assert!((gone - last.emitted).abs() < 1e-6 * last.emitted, "{gone} of {} W", last.emitted);
}

#[test]
fn what_is_sent_arrives_patch_by_patch() {
    let made = closed_room(TransportKind::Tree, 500);
    let tree = &made.transport;
    let mut sent = vec![0.0; tree.len()];
    for i in 0..tree.len() {
        let row = tree.row(i);
        assert!(
            row.is_sorted_by_key(|entry| entry.0)
                && row.iter().all(|entry| entry.1 > 0.0 && entry.0 != i as u32)
        );
        let sum: f64 = row.iter().map(|entry| entry.1).sum::<f64>() + tree.own(i);
        assert!((sum / tree.area(i) - tree.row_sum(i)).abs() < 1e-7, "row {i}");
        for (j, value) in row {
            sent[j as usize] += value;
        }
        sent[i] += tree.own(i);
    }
    for (j, sent) in sent.into_iter().enumerate() {
        let share = sent / tree.area(j);
        assert!((share - tree.row_sum(j)).abs() < 1e-7, "{share} of what patch {j} sends arrives");
    }
}

#[test]
fn all_answers_of_a_transport_are_those_of_its_rows() {
    for kind in [TransportKind::Matrix, TransportKind::Tree] {
        let made = closed_room(kind, 300);
        let transport = made.transport.as_ref();
        let n = transport.len();
        let number = |k: usize| (0.618_033_988_75 * (k * k + k) as f64).fract();
        let radiosity: Vec<Lanes> =
            (0..n).map(|i| std::array::from_fn(|lane| number(LANES * i + lane))).collect();
        let mut dense = vec![vec![0.0; n]; n];
        for (i, own) in dense.iter_mut().enumerate() {
            for (j, value) in transport.row(i) {
                own[j as usize] = value;
            }
            for (j, value) in transport.singles(i) {
                assert!((own[j as usize] - value).abs() <= 1e-6 * value, "{kind:?}: {i} to {j}");
            }
            own[i] += transport.own(i);
            for j in [0, i, (7 * i + 3) % n] {
                let factor = own[j] / transport.area(i);
                assert!((transport.get(i, j) - factor).abs() <= 1e-12, "{kind:?}: {i} to {j}");
            }
        }
        let by_rows = |b: &[Lanes], i: usize| -> Lanes {
            std::array::from_fn(|lane| {
                dense[i].iter().zip(b).map(|(s, b)| s * b[lane]).sum::<f64>() / transport.area(i)
            })
        };
        let mut found = vec![[0.0; LANES]; n];
        transport.gather(0..n, &radiosity, &mut found, &|| false);
        for (i, found) in found.iter().enumerate() {
            let expected = by_rows(&radiosity, i);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{kind:?}: row {i}");
        }
        // One pass of Gauss-Seidel: each new value counts for those after it.
        let (mut relaxed, mut expected) = (radiosity.clone(), radiosity);
        transport.relax(&mut relaxed, &|| false, &mut |i, others, own| {
            let arriving = by_rows(&expected, i);
            expected[i] = std::array::from_fn(|lane| {
                let rest = arriving[lane] - own * expected[i][lane];
                assert!((others[lane] - rest).abs() < 1e-9, "{kind:?}: row {i}: {} and {rest}", others[lane]);
                0.5 * rest + 0.1
            });
            expected[i]
        });
        let groups: Vec<u32> = (0..n).map(|i| (i % 7) as u32).collect();
        let coarse = transport.coarsen(&groups);
        for (i, row) in dense.iter().enumerate() {
            let (mut sums, mut expected) = ([0.0; 7], [0.0; 7]);
            coarse(i, &mut sums);
            for (j, value) in row.iter().enumerate().filter(|(j, _)| *j != i) {
                expected[groups[j] as usize] += value;
            }
            assert!(sums.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{kind:?}: row {i}");
        }
    }
}

fn whole(
    run: &mut Run<'_>,
    prepared: &Prepared,
    rows: &mut RowStore,
) -> Option<(Arc<dyn Transport>, LightBases)> {
    let system = system(prepared, &patch_reflectance(&prepared.mesh, &|_| None));
    run.first_light(prepared, &system, false, rows).ok()?;
    run.rows(prepared, &system, None, None, rows).ok()?;
    let transport = run.assemble(prepared, rows).ok()?;
    let bases = run.sweeps(prepared, transport.as_ref(), &system, None, 1e-6).ok()?.0;
    Some((transport, bases))
}

#[test]
fn an_interrupted_solve_keeps_its_rows_and_ends_with_the_same_light() {
    let scene = builtin("cornell");
    let settings = by(TransportKind::Tree, 700);
    let prepared = prepare(scene, &settings).expect("meshed");
    let n = prepared.mesh.patches.len();
    let cancel = AtomicBool::new(false);
    let mut go_on = |_: Progress<'_>| Control::Continue;
    let (_, straight) =
        whole(&mut Run::new(&mut go_on, &cancel, Timings::default()), &prepared, &mut RowStore::default())
            .expect("nothing stands against it");

    let before = prepared.computer.rows_computed();
    let mut rows = RowStore::default();
    // Ended at three places: while rows of lamps come, among all others, and while they are balanced.
    for stage in [Stage::FirstLight, Stage::Rows, Stage::Balancing] {
        let cancel = AtomicBool::new(false);
        let mut observer = |progress: Progress<'_>| {
            if progress.stage == stage {
                cancel.store(true, Ordering::Relaxed);
            }
            Control::Continue
        };
        let mut run = Run::new(&mut observer, &cancel, Timings::default());
        assert!(whole(&mut run, &prepared, &mut rows).is_none(), "{stage:?}");
        assert!(rows.known() > 0, "{stage:?}");
    }
    assert_eq!(rows.known(), n, "all rows are there");
    let (_, resumed) =
        whole(&mut Run::new(&mut go_on, &cancel, Timings::default()), &prepared, &mut rows).expect("whole");
    assert_eq!(prepared.computer.rows_computed() - before, n as u64, "no row was computed twice");
    let largest = straight.values.iter().copied().fold(0.0, f32::max);
    let off = straight.values.iter().zip(&resumed.values).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off <= 1e-4 * largest, "{off} of {largest}");
}

#[test]
fn the_same_bits_whatever_the_thread_count() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let solved = solved(&builtin("cornell"), &by(TransportKind::Tree, 500));
            solved.bases.values.iter().map(|v| v.to_bits()).collect::<Vec<u32>>()
        })
    };
    let one = bits(1);
    assert!(one == bits(3) && one.iter().any(|&bits| bits != 0));
}

#[test]
fn entries_of_a_row_grow_slower_than_patches() {
    let per_row = |kind: TransportKind, patches: usize| {
        let solved = solved(&builtin("hemicube"), &by(kind, patches));
        let transport = solved.transport.as_ref().expect("whole");
        (transport.entries() as f64 / transport.len() as f64, transport.len() as f64)
    };
    let [(few, n), (many, more)] = [800, 3200].map(|patches| per_row(TransportKind::Tree, patches));
    let growth = (many / few).ln() / (more / n).ln();
    assert!(growth < 0.5, "{few} entries a row of {n} patches, {many} of {more}: exponent {growth}");
}

#[test]
fn the_matrix_is_taken_where_it_is_small() {
    let scene: Arc<Scene> = room_with_blocks(0.5).scene();
    assert_eq!(assembled(&scene, &lines(PatchTarget::Count(300))).transport.kind(), TransportKind::Matrix);
    let sampling = Sampling { method: Method::Lines, resolution: None, points: ReceivingPoints::Auto };
    assert_eq!(SolveSettings::default().sampling(), sampling);
    assert_eq!(SolveSettings::default().transport, TransportKind::Auto);
}
