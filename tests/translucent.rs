//! Surfaces that pass light diffusely: exact solutions, reference points, and what the picture and its error tell.

use glam::DVec3;
use lumenwalk::accuracy::AuditSettings;
use lumenwalk::display::{DisplayMesh, Shading};
use lumenwalk::effects::{Effect, EffectChoices};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, SceneSource, load, luminance_weighted};
use lumenwalk::solve::{self, Control, Solution, SolveSettings};
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Polygons with materials, y up.
#[derive(Default)]
struct Model {
    text: String,
    count: usize,
}

impl Model {
    fn face(mut self, material: &str, corners: &[[f64; 3]]) -> Self {
        writeln!(self.text, "o {material} {}\nusemtl {material}", self.count).expect("a string");
        for [x, y, z] in corners {
            writeln!(self.text, "v {x} {y} {z}").expect("a string");
        }
        self.text += "f";
        for k in (1..=corners.len()).rev() {
            write!(self.text, " -{k}").expect("a string");
        }
        self.text += "\n";
        self.count += 1;
        self
    }

    /// The inside of a box without the walls that `open` names by their places in -x, +x, floor, ceiling, -z, +z.
    fn room(
        mut self,
        material: &str,
        [x0, y0, z0]: [f64; 3],
        [x1, y1, z1]: [f64; 3],
        open: &[usize],
    ) -> Self {
        let walls = [
            [[x0, y0, z0], [x0, y1, z0], [x0, y1, z1], [x0, y0, z1]],
            [[x1, y0, z0], [x1, y0, z1], [x1, y1, z1], [x1, y1, z0]],
            [[x0, y0, z0], [x0, y0, z1], [x1, y0, z1], [x1, y0, z0]],
            [[x0, y1, z0], [x1, y1, z0], [x1, y1, z1], [x0, y1, z1]],
            [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]],
            [[x0, y0, z1], [x0, y1, z1], [x1, y1, z1], [x1, y0, z1]],
        ];
        for (_, wall) in walls.iter().enumerate().filter(|(k, _)| !open.contains(k)) {
            self = self.face(material, wall);
        }
        self
    }

    fn scene(&self, mtl: &str, sidecar: &str) -> Arc<Scene> {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("written");
        };
        write("m.obj", &format!("mtllib m.mtl\n{}", self.text));
        write("m.mtl", mtl);
        write("m.toml", sidecar);
        Arc::new(load(&SceneSource::File(folder.path().join("m.obj"))).expect("a scene"))
    }
}

fn solved(scene: Arc<Scene>, settings: &SolveSettings) -> Solution {
    let never = AtomicBool::new(false);
    solve::solve(scene, settings, &never, &mut |_| Control::Continue).expect("solved")
}

fn usual(patches: usize) -> SolveSettings {
    SolveSettings { patches: PatchTarget::Count(patches), tolerance: 1e-6, ..SolveSettings::default() }
}

/// A sphere of radius 1 cut in half by a disc, seen from inside, of facets: `across` around, half as many along.
fn halved_sphere(across: usize) -> Model {
    let at = |k: usize, j: usize| {
        let phi = std::f64::consts::TAU * k as f64 / across as f64;
        let theta = std::f64::consts::PI * j as f64 / (across / 2) as f64;
        [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()]
    };
    let mut model = Model::default();
    for j in 0..across / 2 {
        let material = if j < across / 4 { "upper" } else { "lower" };
        for k in 0..across {
            let corners = [at(k, j), at(k + 1, j), at(k + 1, j + 1), at(k, j + 1)];
            let mut corners: Vec<[f64; 3]> = match j {
                0 => vec![corners[0], corners[2], corners[3]],
                j if j + 1 == across / 2 => vec![corners[0], corners[1], corners[2]],
                _ => corners.to_vec(),
            };
            corners.reverse();
            model = model.face(material, &corners);
        }
    }
    let rim: Vec<[f64; 3]> = (0..across).rev().map(|k| at(k, across / 4)).collect();
    model.face("disc", &rim)
}

#[test]
fn a_sphere_halved_by_a_diffusing_disc_has_its_exact_solution() {
    // Exitance 1 of the upper half; radiosities of both halves and of the disc's two sides. With the form factors 1/2 of
    // a hemisphere to itself and to the disc, and 1 of the disc, four equations in closed form.
    #[rustfmt::skip]
    let rows = [
        ([0.5, 0.5, 0.3, 0.5], [1.534_090_91, 0.284_090_91, 0.602_272_73, 0.852_272_73]),
        ([0.8, 0.4, 0.2, 0.6], [2.074_235_81, 0.327_510_92, 0.611_353_71, 1.310_043_67]),
        ([0.7, 0.7, 0.38, 0.6], [f64::NAN; 4]),
    ];
    for ([rho1, rho2, rho_p, tau_p], wanted) in rows {
        let wanted = if wanted[0].is_nan() { exact([rho1, rho2, rho_p, tau_p]) } else { wanted };
        let known = exact([rho1, rho2, rho_p, tau_p]);
        assert!(wanted.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-8), "{known:?}");
        let glow = 1.0 / std::f64::consts::PI;
        let mtl = format!(
            "newmtl upper\nKd {rho1} {rho1} {rho1}\nKe {glow} {glow} {glow}\nnewmtl lower\nKd {rho2} {rho2} {rho2}\n\
             newmtl disc\nKd {rho_p} {rho_p} {rho_p}\n"
        );
        let sidecar = format!("[[material]]\nname = \"disc\"\ntranslucence = {tau_p}\n");
        let scene = halved_sphere(32).scene(&mtl, &sidecar);
        let solution = solved(scene.clone(), &usual(1500));
        assert!(solution.plan.is_on(Effect::Translucency) && !solution.plan.is_on(Effect::Glass));
        let light = solution.light(&scene.lighting());
        let mean = |material: &str, normal: DVec3| {
            let (mut sum, mut area) = (0.0, 0.0);
            for (patch, b) in solution.mesh.patches.iter().zip(&light.radiosity) {
                let is_it = scene.materials[patch.material as usize].name == material;
                if is_it && (material != "disc" || patch.normal.dot(normal) > 0.0) {
                    sum += patch.area * f64::from(b[0]);
                    area += patch.area;
                }
            }
            sum / area
        };
        // Of the sphere's facets the outsides take no part; the disc's front looks down or up as its corners run.
        let found = [
            mean("upper", DVec3::ZERO),
            mean("lower", DVec3::ZERO),
            mean("disc", DVec3::Y),
            mean("disc", DVec3::NEG_Y),
        ];
        // D1 is the disc's side towards the upper half.
        println!("{found:?} for {wanted:?}");
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 2e-3, "{found} is not {wanted}");
        }
        let power = light.power(&solution.mesh, &solution.reflectance, &scene.lighting());
        assert!((power.absorbed / power.emitted - 1.0).abs() < 1e-4, "{power:?}");
    }
}

/// Radiosities of the halves and of the disc's sides: B = E + rho H, with H of a hemisphere (its own B + the disc's) / 2
/// and of a side of the disc that of its hemisphere.
fn exact([rho1, rho2, rho_p, tau_p]: [f64; 4]) -> [f64; 4] {
    let [mut b1, mut b2, mut d1, mut d2] = [0.0; 4];
    for _ in 0..10_000 {
        (d1, d2) = (rho_p * b1 + tau_p * b2, rho_p * b2 + tau_p * b1);
        (b1, b2) = (1.0 + rho1 * 0.5 * (b1 + d1), rho2 * 0.5 * (b2 + d2));
    }
    [b1, b2, d1, d2]
}

/// Two rooms of 2 m, the wall between them a diffusing pane; `sheets` of it back to back, each seen from one room.
fn two_rooms(sheets: bool) -> Model {
    let own = [[2.0, 0.0, 0.0], [2.0, 0.0, 2.0], [2.0, 2.0, 2.0], [2.0, 2.0, 0.0]];
    let model = Model::default()
        .room("first", [0.0; 3], [2.0; 3], &[1])
        .room("second", [2.0, 0.0, 0.0], [4.0, 2.0, 2.0], &[0])
        .face("lamp", &[[0.8, 1.999, 0.8], [1.2, 1.999, 0.8], [1.2, 1.999, 1.2], [0.8, 1.999, 1.2]])
        .face("pane", &own);
    let mut back = own;
    back.reverse();
    if sheets { model.face("pane", &back) } else { model }
}

const ROOMS: &str = "newmtl first\nKd .5 .5 .5\nnewmtl second\nKd .7 .7 .7\nnewmtl lamp\nKd 0 0 0\nKe 5 5 5\n\
    newmtl pane\nKd .3 .3 .3\n";
const PANE: &str = "[[material]]\nname = \"pane\"\ntranslucence = 0.5\n";

/// Irradiance at these points by path tracing, standard error 1e-4.
const POINTS: [([f64; 3], [f64; 3], f64); 8] = [
    ([1.0, 0.0, 1.0], [0.0, 1.0, 0.0], 0.2917),
    ([1.5, 0.0, 1.0], [0.0, 1.0, 0.0], 0.2656),
    ([2.0, 1.0, 1.0], [-1.0, 0.0, 0.0], 0.3020),
    ([2.0, 1.0, 1.0], [1.0, 0.0, 0.0], 0.0388),
    ([2.5, 0.0, 1.0], [0.0, 1.0, 0.0], 0.0661),
    ([3.0, 0.0, 1.0], [0.0, 1.0, 0.0], 0.0553),
    ([4.0, 1.0, 1.0], [-1.0, 0.0, 0.0], 0.0584),
    ([3.0, 2.0, 1.0], [0.0, -1.0, 0.0], 0.0565),
];

#[test]
fn two_rooms_joined_by_a_diffusing_pane_are_as_path_tracing_has_them() {
    for sheets in [false, true] {
        let scene = two_rooms(sheets).scene(ROOMS, PANE);
        let solution = solved(scene.clone(), &usual(3000));
        let light = solution.light(&scene.lighting());
        let points: Vec<_> = POINTS.iter().map(|p| (DVec3::from(p.0), DVec3::from(p.1))).collect();
        let found: Vec<f64> =
            solution.irradiance_at(&points, &light).into_iter().map(luminance_weighted).collect();
        println!("{found:?}");
        for (found, (place, normal, wanted)) in found.iter().zip(POINTS) {
            let off = found / wanted - 1.0;
            assert!(off.abs() < 5e-3, "{place:?} {normal:?}: {found} is not {wanted} (sheets: {sheets})");
        }
    }
}

#[test]
fn what_is_shown_on_a_pane_is_audited_and_follows_the_light_behind_it() {
    let scene = two_rooms(false).scene(ROOMS, PANE);
    let solution = solved(scene.clone(), &usual(2000));
    let audit = AuditSettings::default();
    let findings = lumenwalk::study::audit(&solution, &scene.lighting(), &audit, &|| false).expect("light");
    let error = findings.budget.total.error;
    // Nearly all of it lies on the ceiling around the lamp, a millimetre below.
    assert!(error < 0.03, "{:?}", findings.budget);
    // On the dark side of the pane there stands the shadow that its bright side has: the lamp's light falls off from top to
    // bottom there, and so does what passes.
    let light = solution.light(&scene.lighting());
    let drawn = DisplayMesh::build_on(
        &solution.mesh,
        &scene,
        true,
        solution.element_light.as_ref().map(|light| &light.elements),
    );
    let detail = light.detail.as_deref().map(lumenwalk::outputs::in_detail);
    let values = drawn.detailed_radiosity(&light.radiosity, &light.irradiance, detail, Shading::Gouraud);
    let mut checked = 0;
    for (corner, value) in drawn.corners.iter().zip(&values) {
        let patch = &solution.mesh.patches[corner.patch as usize];
        if scene.materials[patch.material as usize].name != "pane" || patch.normal.x < 0.5 {
            continue;
        }
        let at = corner.position.as_dvec3() + drawn.origin;
        let behind = solution.irradiance_at(&[(at, DVec3::NEG_X), (at, DVec3::X)], &light);
        let inside = |c: f64| (0.15..1.85).contains(&c);
        if inside(at.y) && inside(at.z) {
            let wanted = 0.5 * behind[0][0] + 0.3 * behind[1][0];
            assert!((f64::from(value[0]) / wanted - 1.0).abs() < 0.03, "{at}: {} is not {wanted}", value[0]);
            checked += 1;
        }
    }
    assert!(checked > 10, "{checked}");
}

#[test]
fn colours_pass_by_their_shares_and_nothing_passes_when_it_is_switched_off() {
    let tinted = "[[material]]\nname = \"pane\"\ntranslucence = [0.6, 0.3, 0.0]\n";
    let scene = two_rooms(false).scene(ROOMS, tinted);
    let points = [(DVec3::new(3.0, 0.0, 1.0), DVec3::Y)];
    let solution = solved(scene.clone(), &usual(600));
    assert!(solution.plan.is_on(Effect::ColourBands), "the pane has a colour");
    let [r, g, b] = solution.irradiance_at(&points, &solution.light(&scene.lighting()))[0];
    assert!(r > 1.9 * g && r < 2.3 * g && g > 0.0 && b == 0.0, "{r} {g} {b}");

    let effects = EffectChoices { without: vec![Effect::Translucency], ..EffectChoices::default() };
    let without = solved(scene.clone(), &SolveSettings { effects, ..usual(600) });
    assert!(!without.plan.is_on(Effect::Translucency) && without.mesh.translucence.is_empty());
    let dark = without.irradiance_at(&points, &without.light(&scene.lighting()))[0];
    assert_eq!(dark, [0.0; 3]);
}

#[test]
fn a_shade_around_a_lamp_lights_what_no_lamp_sees() {
    // A closed paper box around a small lamp in a room: everything outside of it lives of what passes.
    let model = Model::default()
        .room("first", [0.0; 3], [3.0; 3], &[])
        .face("lamp", &[[1.45, 1.5, 1.45], [1.55, 1.5, 1.45], [1.55, 1.5, 1.55], [1.45, 1.5, 1.55]])
        .room("pane", [1.2; 3], [1.8; 3], &[]);
    let scene = model.scene(ROOMS, PANE);
    let solution = solved(scene.clone(), &usual(1500));
    let light = solution.light(&scene.lighting());
    // The paper's inside is a cavity of nearly even light: flux / (area (1 - rho - tau)) if nothing came back; with what the
    // room sends back as a second cavity: two balances.
    let flux = 5.0 * std::f64::consts::PI * 0.01;
    let (inner, outer) = (6.0 * 0.36, 6.0 * 9.0);
    // H1 A1 = flux + A1 (rho H1 + tau H2);  H2 A1 + Hw Aw = A1 (rho H2 + tau H1) + rho_w Hw Aw.  The shade's outside sees the
    // walls alone: H2 = rho_w Hw.
    let (rho, tau, walls) = (0.3, 0.5, 0.5);
    let h1_of = |h2: f64| (flux / inner + tau * h2) / (1.0 - rho);
    let mut hw = 0.0;
    for _ in 0..1000 {
        let h2 = walls * hw;
        hw = (inner * (rho * h2 + tau * h1_of(h2) - h2) + walls * hw * outer) / outer;
    }
    let (mut sum, mut area) = (0.0, 0.0);
    for (patch, h) in solution.mesh.patches.iter().zip(&light.irradiance) {
        if scene.materials[patch.material as usize].name == "first" {
            sum += patch.area * f64::from(h[0]);
            area += patch.area;
        }
    }
    let found = sum / area;
    println!("walls {found} for {hw}");
    // The lamp itself is black and hides little; the room is even to a few per cent.
    assert!((found / hw - 1.0).abs() < 0.04, "{found} is not {hw}");
}
