//! What any scene obeys.

use crate::common::{Assembled, Model, assembled, settings};
use lumenwalk::effects::Effect;
use lumenwalk::form_factors::Method;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::Scene;
use lumenwalk::solve::SolveSettings;
use lumenwalk::solver::{LightBases, SweepReport, System};
use lumenwalk::transport::TransportKind;
use std::sync::Arc;

/// What a scene is beyond the laws that hold for all.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// No light escapes from any patch that sees something.
    Closed,
    /// As that, with bodies that stand in each other and in the walls: patches at their seams may lie a little within
    /// another body.
    Cluttered,
    /// Light escapes, or some side is black.
    Open,
}

/// Methods, resolutions and patches: usual ones for small scenes, and high ones.
const QUALITIES: [(Method, u32, usize); 4] = [
    (Method::Lines, 192, 160),
    (Method::Lines, 768, 420),
    (Method::Hemicube, 128, 160),
    (Method::Rays, 1024, 160),
];

#[track_caller]
pub(crate) fn hold(name: &str, scene: &Arc<Scene>, kind: Kind) {
    for (method, resolution, patches) in QUALITIES {
        let settings = settings(PatchTarget::Count(patches), method, resolution);
        hold_with(&format!("{name}, {} {resolution}", method.name()), scene, kind, &settings);
    }
    let (method, resolution, patches) = QUALITIES[0];
    let matrix = settings(PatchTarget::Count(patches), method, resolution);
    let settings = SolveSettings { transport: TransportKind::Tree, ..matrix };
    hold_with(&format!("{name}, by a tree"), scene, kind, &settings);
}

#[track_caller]
pub(crate) fn hold_model(name: &str, model: &Model, kind: Kind) {
    hold(name, &model.scene(), kind);
}

/// Asserts the laws; gives the assembled scene for more.
#[track_caller]
pub(crate) fn hold_with(name: &str, scene: &Arc<Scene>, kind: Kind, settings: &SolveSettings) -> Assembled {
    let made = assembled(scene, settings);
    form_factors_hold(name, &made, kind);
    if kind != Kind::Open {
        furnace_is_white(name, &made);
    }
    light_holds(name, &made);
    made
}

#[track_caller]
fn form_factors_hold(name: &str, made: &Assembled, kind: Kind) {
    let f = &made.transport;
    let mut unseeing = 0.0;
    for i in 0..f.len() {
        let p = &made.patches()[i];
        let place = || format!("{name}: patch {i} of {} at {} facing {}", f.len(), p.centre, p.normal);
        assert!(p.centre.is_finite() && p.area > 0.0 && p.area.is_finite(), "{}", place());
        for (j, s) in f.row(i) {
            assert!(s >= 0.0 && s.is_finite(), "{}: S = {s}", place());
            if f.kind() == TransportKind::Tree {
                // Rows of receivers: sums of rows and columns are held to instead.
                continue;
            }
            let back = f.row(j as usize);
            let at = back
                .binary_search_by_key(&(i as u32), |entry| entry.0)
                .unwrap_or_else(|_| panic!("{}: {j} unseeing", place()));
            assert_eq!(s.to_bits(), back[at].1.to_bits(), "{}: not reciprocal with {j}", place());
        }
        let sum = f.row_sum(i);
        assert!((0.0..=1.0 + 1e-9).contains(&sum), "{}: the row sums to {sum}", place());
        if sum == 0.0 {
            unseeing += p.area;
        } else if kind != Kind::Open {
            assert!((sum - 1.0).abs() < 1e-6, "{}: the row sums to {sum}", place());
            // Before it was balanced, nothing was lost; closed forms alone count both of two faces in one place.
            let sampled = f64::from(f.quality(i).sampled_sum);
            let lost = if kind == Kind::Cluttered { 0.02 } else { 1e-4 };
            let counted_twice = if made.prepared.plan.is_on(Effect::Visibility) { 0.0 } else { 0.3 };
            assert!(
                (1.0 - lost..1.0 + 1e-4 + counted_twice).contains(&sampled),
                "{}: the row as sampled sums to {sampled}",
                place()
            );
        }
    }
    let told = made.transport.report();
    assert!(told.imbalance <= 1e-7, "{name}: {told:?}");
    // What a patch sees and is not seen by finds no partner: lines miss nothing, samples do.
    let kept = if made.prepared.computer.sampling().method == Method::Lines { 1e-6 } else { 1e-2 };
    assert!(kind == Kind::Open || told.kept < kept, "{name}: rows contradict each other: {told:?}");
    let all = made.area(&made.of(|_| true));
    // What lies under something or within it, or in a room without a lamp.
    assert!(kind == Kind::Open || unseeing < 0.5 * all, "{name}: {unseeing} of {all} m2 see nothing");
}

#[track_caller]
fn furnace_is_white(name: &str, made: &Assembled) {
    let rho = |i: usize| 0.98 * (0.618_033_988_749_895 * i as f64).fract();
    let b = made.radiosity(&made.grey_system(|i| (rho(i), 1.0 - rho(i))), 1e-7);
    for i in made.seeing() {
        let p = &made.patches()[i];
        assert!(
            (b[i] - 1.0).abs() < 1e-3,
            "{name}: B = {} in a white furnace at {} facing {}",
            b[i],
            p.centre,
            p.normal
        );
    }
}

/// With the lamps as they come: finite, not negative, and no power is lost.
#[track_caller]
fn light_holds(name: &str, made: &Assembled) {
    let system = made.system(None);
    if system.lamps == 0 {
        return;
    }
    let (bases, last) = swept(made, &system, 1e-7);
    assert!(bases.values.iter().all(|h| h.is_finite() && *h >= 0.0), "{name}: irradiance");
    let gone = last.absorbed + last.escaped;
    assert!((gone - last.emitted).abs() <= 1e-6 * last.emitted, "{name}: {gone} of {} W", last.emitted);
    let light = bases.mix(&made.prepared.mesh, &made.lighting(), &[]);
    assert!(light.radiosity.iter().flatten().all(|b| b.is_finite() && *b >= 0.0), "{name}: B");
}

/// Sweeps until so small a share of the power is missing, 40 times at most. The solver's own bound is
/// relative to the brightest patch, which for a small lamp is the lamp itself.
pub(crate) fn swept(made: &Assembled, system: &System, share: f64) -> (LightBases, SweepReport) {
    let mut solver = made.solver(system);
    let mut report = solver.report(system);
    for _ in 0..40 {
        report = solver.sweep(made.transport.as_ref(), system, &|| false).expect("not cancelled");
        let missing = (report.absorbed + report.escaped - report.emitted).abs();
        if missing <= share * report.emitted && report.error_bound <= 1e-7 {
            break;
        }
    }
    (solver.bases(system), report)
}
