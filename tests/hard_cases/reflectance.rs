//! Reflectances to one, and what that does to sweeps.

use crate::common::{Assembled, assembled, lines};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::validate::scenes;

/// Sweeps that it takes to bring the residual to 1e-6 of the largest radiosity, and the balance then.
fn sweeps(name: &str, made: &Assembled, rho: &dyn Fn(usize) -> f64) -> u32 {
    let lit = |i: usize| made.patches()[i].luminaire.is_some();
    let system = made.grey_system(|i| (rho(i), if lit(i) { 20.0 } else { 0.0 }));
    let mut solver = made.solver(&system);
    loop {
        let report = solver.sweep(made.transport.as_ref(), &system, &|| false).expect("not cancelled");
        assert!(report.residual.is_finite(), "{name}: {report:?}");

        if report.residual <= 1e-6 {
            let seeing: f64 = made.seeing().iter().map(|&i| made.patches()[i].area).sum();
            assert!(seeing > 0.0, "{name}");
            let bases = solver.bases(&system);
            assert!(bases.values.iter().all(|h| h.is_finite() && *h >= 0.0), "{name}");
            return report.sweep;
        }
        assert!(report.sweep < 100, "{name}: {report:?}");
    }
}

#[test]
fn twelve_sweeps_do_at_any_reflectance() {
    for (name, scene) in [
        ("cube", scenes::cube()),
        ("room with blocks", scenes::room_with_blocks(0.5)),
        ("L-shaped room", scenes::l_shaped_room(0.5)),
        ("three rooms", scenes::rooms_in_a_row(3, 0.5)),
    ] {
        let scene = std::sync::Arc::new(scene.read(None).unwrap());
        let made = assembled(&scene, &lines(PatchTarget::Count(600)));
        for rho in [0.0, 0.9, 0.99, 0.999, 0.9999] {
            let taken = sweeps(&format!("{name} at {rho}"), &made, &|_| rho);
            assert!(taken <= 12, "{name} at {rho}: {taken} sweeps");
        }
        let mixed = |i: usize| 0.999 * (0.618_033_988_749_895 * i as f64).fract();
        assert!(sweeps(name, &made, &mixed) <= 12, "{name}, mixed");
        // One white patch in a black room.
        assert!(sweeps(name, &made, &|i| if i == 3 { 0.9999 } else { 0.0 }) <= 12, "{name}, one white");
    }
}

#[test]
fn twelve_sweeps_do_in_four_rooms_with_narrow_doors() {
    let scene = std::sync::Arc::new(scenes::rooms_in_a_row(4, 0.15).read(None).unwrap());
    let made = assembled(&scene, &lines(PatchTarget::Count(600)));
    for rho in [0.9, 0.99, 0.999, 0.9999] {
        let taken = sweeps(&format!("four rooms at {rho}"), &made, &|_| rho);
        assert!(taken <= 12, "at {rho}: {taken} sweeps");
    }
}

#[test]
fn power_balances_at_any_reflectance() {
    let scene = std::sync::Arc::new(scenes::rooms_in_a_row(3, 0.5).read(None).unwrap());
    let made = assembled(&scene, &lines(PatchTarget::Count(500)));
    let lit = |i: usize| made.patches()[i].luminaire.is_some();
    for rho in [0.0, 0.5, 0.99, 0.9999] {
        let system = made.grey_system(|i| (rho, if lit(i) { 20.0 } else { 0.0 }));
        let (_, reports) = made.sweep(&system, 1e-7);
        let last = reports.last().unwrap();
        let gone = last.absorbed + last.escaped;
        assert!((gone - last.emitted).abs() <= 1e-6 * last.emitted, "rho {rho}: {last:?}");
    }
}
