//! The effect plan: what scenes call for, why, and that leaving the rest out changes nothing.

mod common;

use common::{Model, builtin, lines, room_with_blocks, solved, with_effects};
use glam::{DVec3, dvec3};
use lumenwalk::accuracy::{Answer, Audit, AuditSettings};
use lumenwalk::display::DisplayMesh;
use lumenwalk::effects::{Effect, EffectChoices, EffectState, plan};
use lumenwalk::mesh::{MeshSettings, PatchTarget, build};
use lumenwalk::scene::Scene;
use lumenwalk::solve::{Solution, SolveSettings, prepare};
use lumenwalk::solver::patch_emission;
use lumenwalk::study;
use std::sync::Arc;

fn forced(with: &[Effect], without: &[Effect]) -> EffectChoices {
    EffectChoices { with: with.to_vec(), without: without.to_vec() }
}

fn convex_room(glow: [f64; 3], paint: [f64; 3]) -> Arc<Scene> {
    let mut m = Model::new();
    m.paint("paint", paint, [0.0; 3]).paint("glow", [0.5; 3], glow);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [all, Some("glow"), all, all, all, all]);
    m.scene()
}

/// Largest difference of irradiance over the largest irradiance.
fn difference(a: &Solution, b: &Solution) -> f32 {
    let lighting = a.scene.lighting();
    let (x, y) = (a.light(&lighting), b.light(&lighting));
    let pairs = x.irradiance.iter().flatten().zip(y.irradiance.iter().flatten());
    let largest = x.irradiance.iter().flatten().copied().fold(0.0, f32::max);
    pairs.map(|(p, q)| (p - q).abs()).fold(0.0, f32::max) / largest
}

#[test]
fn each_scene_gets_what_it_calls_for() {
    use Effect::{ColourBands, SmoothSurfaces, TwoSided, Visibility};
    let grey_room = convex_room([1.0; 3], [0.5; 3]);
    let blocks = room_with_blocks(0.5).scene();
    let cases: [(&str, Arc<Scene>, &[Effect]); 6] = [
        ("hemicube", builtin("hemicube"), &[Visibility, ColourBands]),
        ("cornell", builtin("cornell"), &[Visibility, ColourBands]),
        ("gallery", builtin("gallery"), &[Visibility, ColourBands, SmoothSurfaces]),
        ("house", builtin("house"), &[Visibility, ColourBands, TwoSided, SmoothSurfaces]),
        ("empty grey room", grey_room, &[]),
        ("grey room with blocks", blocks, &[Visibility]),
    ];
    for (name, scene, expected) in cases {
        let mesh =
            build(&scene, &MeshSettings { target: PatchTarget::Count(300), ..MeshSettings::default() })
                .unwrap();
        let decided = plan(&scene, &mesh, &EffectChoices::default());
        let order: Vec<Effect> = decided.decisions.iter().map(|d| d.effect).collect();
        assert_eq!(order, Effect::ALL, "{name}");
        for decision in &decided.decisions {
            let state =
                if expected.contains(&decision.effect) { EffectState::On } else { EffectState::NotCalledFor };
            assert_eq!(decision.state, state, "{name}: {decision:?}");
            assert!(decision.reason.split(' ').count() >= 4, "{name}: {:?} is no reason", decision.reason);
            assert!(
                decision.evidence.contains(|c: char| c.is_ascii_digit()),
                "{name}: {:?}",
                decision.evidence
            );
            assert!(!decision.predicted_cost.is_empty());
        }
    }
}

#[test]
fn choices_are_obeyed_and_named() {
    let scene = convex_room([1.0; 3], [0.5; 3]);
    let mesh = build(&scene, &MeshSettings::default()).unwrap();
    let decided = plan(&scene, &mesh, &forced(&[Effect::Visibility], &[Effect::SmoothSurfaces]));
    let of = |effect| decided.decisions.iter().find(|d| d.effect == effect).unwrap();
    assert_eq!(of(Effect::Visibility).state, EffectState::OnByChoice);
    assert_eq!(of(Effect::SmoothSurfaces).state, EffectState::OffByChoice);
    assert!(of(Effect::Visibility).reason.contains("by choice"));
    assert!(decided.is_on(Effect::Visibility) && !decided.is_on(Effect::SmoothSurfaces));
}

#[test]
fn one_block_calls_for_visibility_and_leaving_it_out_by_force_shows() {
    let scene = room_with_blocks(0.5).scene();
    let patches = PatchTarget::Count(500);
    let right = solved(&scene, &lines(patches));
    let wrong = solved(&scene, &with_effects(patches, forced(&[], &[Effect::Visibility])));
    let error = difference(&right, &wrong);
    assert!(error > 0.1, "without shadows the room differs by {error} alone");
}

#[test]
fn an_empty_convex_room_is_the_same_with_visibility_forced_on() {
    let scene = convex_room([10.0, 8.0, 5.0], [0.7, 0.5, 0.3]);
    let patches = PatchTarget::Count(600);
    let without = solved(&scene, &lines(patches));
    assert!(!without.plan.is_on(Effect::Visibility));
    // Finely, so that what is left is not the sampling of the lines.
    let by_lines =
        SolveSettings { resolution: Some(1024), ..with_effects(patches, forced(&[Effect::Visibility], &[])) };
    let with = solved(&scene, &by_lines);
    assert!(with.plan.is_on(Effect::Visibility));
    let error = difference(&without, &with);
    assert!(error < 1e-3, "visibility in a room where all is visible changes {error}");
}

#[test]
fn a_grey_scene_solves_one_band_that_stands_for_three() {
    // The lamp is coloured: it scales its basis, and is no reason for bands.
    let scene = convex_room([10.0, 8.0, 5.0], [0.5; 3]);
    let patches = PatchTarget::Count(500);
    let one = solved(&scene, &lines(patches));
    let three = solved(&scene, &with_effects(patches, forced(&[Effect::ColourBands], &[])));
    assert_eq!((one.bases.bands, three.bases.bands), (1, 3));
    assert_eq!(one.bases.values.len() * 3, three.bases.values.len());
    let error = difference(&one, &three);
    assert!(error < 1e-6, "one band and three differ by {error}");
    let (a, b) = (one.sweeps.last().unwrap(), three.sweeps.last().unwrap());
    common::close("emitted", a.emitted, b.emitted, 1e-9);
}

#[test]
fn two_sided_surfaces_can_be_left_out_by_choice() {
    let scene = builtin("house");
    let mesh = |choices: &EffectChoices| {
        let settings = MeshSettings {
            target: PatchTarget::Count(300),
            backs: lumenwalk::effects::backs(choices),
            ..MeshSettings::default()
        };
        let mesh = build(&scene, &settings).unwrap();
        plan(&scene, &mesh, choices).decisions.into_iter().find(|d| d.effect == Effect::TwoSided).unwrap()
    };
    assert_eq!(mesh(&EffectChoices::default()).state, EffectState::On);
    let off = mesh(&forced(&[], &[Effect::TwoSided]));
    assert_eq!(off.state, EffectState::OffByChoice);
    assert!(off.evidence.starts_with("0 of"), "no patch is left on a back: {}", off.evidence);
}

#[test]
fn rows_of_a_convex_room_are_the_closed_forms() {
    let scene = convex_room([1.0; 3], [0.5; 3]);
    let made = prepare(scene, &lines(PatchTarget::Count(150))).unwrap();
    let mut scratch = made.computer.scratch();
    for (i, patch) in (0_u32..).zip(&made.mesh.patches) {
        let row = made.computer.row(i, &mut scratch);
        for j in 0..made.mesh.patches.len() as u32 {
            let other = &made.mesh.patches[j as usize];
            let faces = other.normal.dot(patch.centre - other.centre) > 1e-6;
            let expected = if faces { made.computer.unoccluded(patch.centre, patch.normal, j) } else { 0.0 };
            assert!((row.get(j) - expected).abs() < 1e-6, "{i} to {j}: {} for {expected}", row.get(j));
        }
        assert!((row.sum() - 1.0).abs() < 1e-6, "row {i} sums to {}", row.sum());
    }
}

#[test]
fn what_an_effect_costs_is_measured_where_it_is_on() {
    let with = solved(&room_with_blocks(0.5).scene(), &lines(PatchTarget::Count(600)));
    let cost =
        |of: &Solution, effect| of.plan.decisions.iter().find(|d| d.effect == effect).unwrap().measured;
    let visibility = cost(&with, Effect::Visibility).expect("measured").as_secs_f64();
    // How much it is depends on the clock.
    assert!((0.0..=with.timings.rows).contains(&visibility), "{visibility} of {}", with.timings.rows);
    let without = solved(&convex_room([1.0; 3], [0.5; 3]), &lines(PatchTarget::Count(300)));
    assert_eq!(cost(&without, Effect::Visibility), None, "what is off takes nothing");
}

#[test]
fn the_audit_checks_curved_surfaces_as_they_are_shown_and_facets_where_they_are_asked_for() {
    let scene = builtin("gallery");
    let settings = |without: &[Effect]| with_effects(PatchTarget::Count(900), forced(&[], without));
    let asked = AuditSettings {
        seconds: f64::INFINITY,
        receivers: 128,
        resolve: 0.02,
        local_noise: 1.0,
        ..AuditSettings::default()
    };
    let lighting = scene.lighting();
    let by_plan = |solved: &Solution| study::audit(solved, &lighting, &asked, &|| false).expect("lit").budget;
    let by_hand = |solved: &Solution, smooth: bool| {
        let mesh = &solved.mesh;
        let light = solved.light(&lighting);
        let elements = solved.element_light.as_ref().map(|light| &light.elements);
        let display = DisplayMesh::build_on(mesh, &solved.scene, smooth, elements);
        let exitance: Vec<[f32; 3]> = mesh.patches.iter().map(|p| patch_emission(p, &lighting)).collect();
        let answer = Answer {
            mesh,
            transport: solved.transport.as_deref().expect("whole"),
            light: &light,
            exitance: &exitance,
            lighting: &lighting,
            reflectance: &solved.reflectance,
            shown: &study::shown(mesh, &display, &light),
            smooth,
            direct: None,
        };
        Audit::new(answer).expect("lit").run(&asked, &|| false).expect("lit").budget
    };
    let (smooth, faceted) =
        (solved(&scene, &settings(&[])), solved(&scene, &settings(&[Effect::SmoothSurfaces])));
    assert_eq!(by_plan(&smooth).total, by_hand(&smooth, true).total);
    assert_eq!(by_plan(&faceted).total, by_hand(&faceted, false).total);
    // The gallery has a vault of 24 facets, washed by hidden lamps: its light is not that of a smooth one.
    let [as_shown, as_facets] = [true, false].map(|as_shown| by_hand(&smooth, as_shown).total.error);
    assert_ne!(as_facets, as_shown);
}
