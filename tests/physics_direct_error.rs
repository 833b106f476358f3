//! The part of the error budget that direct light on elements has, against closed forms.

mod common;

use common::{Model, builtin, ceiling_with_lamp, settings, solved};
use glam::DVec3;
use lumenwalk::accuracy::{Answer, AuditSettings, Sobol, Witness};
use lumenwalk::display::DisplayMesh;
use lumenwalk::form_factors::{Method, closed_form::point_to_polygon};
use lumenwalk::mesh::{PatchTarget, Side};
use lumenwalk::scene::luminance_weighted;
use lumenwalk::solve::{DirectTarget, SolveSettings};
use lumenwalk::solver::patch_emission;
use lumenwalk::study;

#[test]
fn where_nothing_reflects_all_error_is_that_of_direct_light_and_the_true_one() {
    let mut m = Model::new();
    m.grey("black", 0.0).paint("glow", [0.0; 3], [30.0, 20.0, 10.0]);
    let (size, wall) = ([3.0, 2.6, 4.0], Some("black"));
    m.room(DVec3::ZERO, DVec3::from(size), [wall, None, wall, wall, wall, wall]);
    ceiling_with_lamp(&mut m, "black", size, [0.3, 1.2, 0.5, 1.5]);
    let scene = m.scene();
    let lighting = scene.lighting();
    // So coarse that there is something to measure.
    let direct = DirectTarget { error: 0.05, ..DirectTarget::default() };
    let how = SolveSettings { direct, ..settings(PatchTarget::Count(60), Method::Lines, 48) };
    let solution = solved(&scene, &how);
    let asked = AuditSettings { seconds: 1e9, precision: 0.1, receivers: 512, ..AuditSettings::default() };
    let budget = study::audit(&solution, &lighting, &asked, &|| false).expect("light").budget;

    let (mesh, light) = (&*solution.mesh, solution.light(&lighting));
    let elements = solution.element_light.as_ref().map(|light| &light.elements);
    let display = DisplayMesh::build_on(mesh, &scene, true, elements);
    let exitance: Vec<[f32; 3]> = mesh.patches.iter().map(|p| patch_emission(p, &lighting)).collect();
    let shown = study::shown(mesh, &display, &light);
    let witness = Witness::new(&Answer {
        mesh,
        transport: solution.transport.as_deref().expect("whole"),
        light: &light,
        exitance: &exitance,
        lighting: &lighting,
        reflectance: &solution.reflectance,
        shown: &shown,
        smooth: false,
        direct: None,
    });
    let exact = |point: DVec3, normal: DVec3| -> f64 {
        let lamps = mesh.patches.iter().zip(&exitance).filter(|(patch, _)| patch.luminaire.is_some());
        let sent = lamps.map(|(lamp, exitance)| {
            let of = |piece| point_to_polygon(point, normal, &mesh.polygon(piece, Side::Front));
            luminance_weighted(exitance.map(f64::from)) * mesh.pieces_of(lamp).map(of).sum::<f64>()
        });
        sent.sum()
    };
    let (mut squares, mut area) = (0.0, 0.0);
    for (i, patch) in mesh.patches.iter().enumerate().filter(|(_, p)| p.luminaire.is_none() && !p.buried) {
        for k in 0..48 {
            let [r, s, ..] = Sobol::new(i as u64 + 7).point(k);
            let (point, normal, shown) = witness.point_on(i as u32, r, s);
            let truth = exact(point, normal);
            squares += patch.area * ((shown - truth) / truth.max(budget.mean_irradiance)).powi(2);
            area += patch.area;
        }
    }
    let truth = (squares / area).sqrt();
    println!("true {truth:.5}, direct {:?}, total {:?}, mesh {:?}", budget.direct, budget.total, budget.mesh);
    assert!(truth > 2e-3, "{truth}");
    assert!(budget.direct.low < 1.02 * truth && budget.direct.high > 0.98 * truth, "{:?}", budget.direct);
    assert!((budget.total.error / budget.direct.error - 1.0).abs() < 0.02, "{:?}", budget.total);
    assert!(budget.mesh.error.max(budget.form_factors.error) < 0.1 * truth, "{budget:?}");
}

#[test]
fn coarser_direct_light_is_told_as_such_and_the_rest_stays() {
    let scene = builtin("hemicube");
    let lighting = scene.lighting();
    let asked = AuditSettings { seconds: 1e9, precision: 0.08, receivers: 640, ..AuditSettings::default() };
    let [coarse, fine] = [0.05, 0.004].map(|error| {
        let direct = DirectTarget { error, ..DirectTarget::default() };
        let how = SolveSettings { direct, ..settings(PatchTarget::Count(900), Method::Lines, 96) };
        study::audit(&solved(&scene, &how), &lighting, &asked, &|| false).expect("light").budget
    });
    println!("{:?} {:?}; {:?} {:?}", coarse.direct, coarse.mesh, fine.direct, fine.mesh);
    assert!(coarse.direct.error > 2.0 * fine.direct.error, "{:?} {:?}", coarse.direct, fine.direct);
    assert!(coarse.mesh.low < fine.mesh.high && fine.mesh.low < coarse.mesh.high);
}
