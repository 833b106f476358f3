//! Surfaces whose images have holes: what passes, what is reflected, and what is seen.

mod common;

use common::quads::Quads;
use common::settings;
use glam::DVec3;
use lumenwalk::accuracy::AuditSettings;
use lumenwalk::display::{DisplayMesh, Exposure, Shading, ToneMap};
use lumenwalk::effects::{Effect, EffectChoices};
use lumenwalk::form_factors::Method;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::navigation::Camera;
use lumenwalk::render::{Picker, StillInput, StillOptions, render_still};
use lumenwalk::scene::{Scene, SceneSource, load, luminance_weighted};
use lumenwalk::solve::{self, Control, Solution, SolveSettings, prepare};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

impl Quads {
    /// Reads them with a plate of which 40 % is open, by its own image or by a `map_d`, black or of reflectance 0.5.
    fn scene(&self) -> Arc<Scene> {
        self.scene_with("")
    }

    fn scene_with(&self, more: &str) -> Arc<Scene> {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        // Five stripes of which two are open; a board of 2 x 2 fields.
        let stripes =
            image::GrayImage::from_fn(10, 10, |x, _| image::Luma([if x / 2 % 5 < 3 { 255 } else { 0 }]));
        stripes.save(at("stripes.png")).expect("written");
        let leaf = image::RgbaImage::from_fn(20, 20, |x, y| {
            let is_open = (x < 10) == (y < 10);
            // What is transparent is bright green, and must not count.
            image::Rgba(if is_open { [0, 255, 0, 0] } else { [188, 188, 188, 255] })
        });
        leaf.save(at("leaf.png")).expect("written");
        std::fs::write(at("m.obj"), format!("mtllib m.mtl\n{}", self.text)).expect("written");
        let materials = format!(
            "newmtl grey\nKd .5 .5 .5\nnewmtl black\nKd 0 0 0\nnewmtl lamp\nKd 0 0 0\nKe 10 10 10\n\
             newmtl plate\nKd 0 0 0\nmap_d -s 400 400 stripes.png\nnewmtl pale\nKd .5 .5 .5\nmap_d -s 400 400 stripes.png\n\
             newmtl leaf\nKd 1 1 1\nmap_Kd leaf.png\nnewmtl haze\nKd .5 .5 .5\nmap_Kd -s 400 400 leaf.png\n{more}"
        );
        std::fs::write(at("m.mtl"), materials).expect("written");
        // Sides that no light finds take part as well.
        let both = ["pale", "leaf", "haze"]
            .map(|name| format!("[[material]]\nname = \"{name}\"\nsides = \"both\"\n"));
        std::fs::write(at("m.toml"), format!("up = \"z\"\n{}", both.concat())).expect("written");
        Arc::new(load(&SceneSource::File(at("m.obj"))).expect("a scene"))
    }
}

fn solved(scene: Arc<Scene>, settings: &SolveSettings) -> Solution {
    let never = AtomicBool::new(false);
    solve::solve(scene, settings, &never, &mut |_| Control::Continue).expect("solved")
}

fn usual(patches: usize) -> SolveSettings {
    SolveSettings { patches: PatchTarget::Count(patches), ..SolveSettings::default() }
}

fn at(solution: &Solution, point: [f64; 3], normal: DVec3) -> f64 {
    let light = solution.light(&solution.scene.lighting());
    luminance_weighted(solution.irradiance_at(&[(DVec3::from(point), normal)], &light)[0])
}

#[test]
fn a_plate_that_is_40_per_cent_open_lets_40_per_cent_pass_and_reflects_60_of_its_paint() {
    let floor = [-1.0, -1.0, 1.0, 1.0];
    let wide = [-30.0, -30.0, 30.0, 30.0];
    let lamp = [-0.3, -0.3, 0.3, 0.3];
    let open = Quads::default().level("black", floor, 0.0, true).level("lamp", lamp, 4.0, false);
    let unhindered = at(&solved(open.scene(), &usual(100)), [0.2, 0.1, 0.0], DVec3::Z);
    let behind = Quads::default()
        .level("black", floor, 0.0, true)
        .level("plate", wide, 2.0, true)
        .level("lamp", lamp, 4.0, false);
    let solution = solved(behind.scene(), &usual(400));
    assert!(solution.plan.is_on(Effect::Holes) && !solution.plan.is_on(Effect::Glass));
    let passed = at(&solution, [0.2, 0.1, 0.0], DVec3::Z) / unhindered;
    assert!((passed - 0.4).abs() < 2e-3, "{passed}");
    // Opaque when it is switched off.
    let effects = EffectChoices { without: vec![Effect::Holes], ..EffectChoices::default() };
    let without = solved(behind.scene(), &SolveSettings { effects, ..usual(400) });
    assert_eq!(at(&without, [0.2, 0.1, 0.0], DVec3::Z), 0.0);

    // The paint: what a point beside the lamp sees of a wide plate of reflectance 0.5 against a closed board of it.
    let lit = |material: &str| {
        let quads = Quads::default()
            .level(material, [-4.0, -4.0, 4.0, 4.0], 2.0, true)
            .level("lamp", lamp, 4.0, false);
        at(&solved(quads.scene(), &usual(1500)), [1.0, 0.0, 4.0], DVec3::NEG_Z)
    };
    let reflected = lit("pale") / lit("grey");
    assert!((reflected - 0.6).abs() < 5e-3, "{reflected}");
}

#[test]
fn raw_rows_see_holes_and_paint_by_every_method() {
    let far = [-400.0, -400.0, 400.0, 400.0];
    let quads = Quads::default()
        .level("grey", [-0.1, -0.1, 0.1, 0.1], 0.0, true)
        .level("pale", far, 0.3, true)
        .level("haze", far, 0.6, false)
        .level("lamp", far, 1.0, false);
    let scene = quads.scene();
    for (method, resolution) in common::METHODS {
        let prepared =
            prepare(scene.clone(), &settings(PatchTarget::Count(60), method, resolution)).expect("a mesh");
        let of = |material: &str| {
            let is_it = |patch: u32| {
                let patch = &prepared.mesh.patches[patch as usize];
                scene.materials[patch.material as usize].name == material
            };
            let floor = prepared.mesh.patches.iter().position(|p| p.radius < 1.0).expect("a floor");
            let row = prepared.computer.row(floor as u32, &mut prepared.computer.scratch());
            let seen = row.patches.iter().zip(&row.values).filter(|entry| is_it(*entry.0));
            seen.map(|entry| f64::from(*entry.1)).sum::<f64>()
        };
        let slack = if method == Method::Lines { 2e-3 } else { 1.2e-2 };
        // 60 % of the first; of the 40 % that pass half by the second; the rest behind.
        for (material, wanted) in [("pale", 0.6), ("haze", 0.2), ("lamp", 0.2)] {
            let found = of(material);
            assert!((found - wanted).abs() < slack, "{material} by {method:?}: {found}");
        }
    }
}

#[test]
fn a_screen_of_holes_lights_a_room_as_one_that_is_cut_out() {
    // A partition, half of it open: fields of a board that are there or not, and a leaf that is as open.
    let room =
        || Quads::default().room("grey", [4.0, 3.0, 2.5]).level("lamp", [0.8, 1.2, 1.4, 1.8], 2.45, false);
    let mut cut = room();
    let (across, up) = (24, 20);
    for i in 0..across {
        for j in (0..up).filter(|j| (i + j) % 2 == 0) {
            let [y0, y1] = [i, i + 1].map(|i| 3.0 * f64::from(i) / f64::from(across));
            let [z0, z1] = [j, j + 1].map(|j| 2.5 * f64::from(j) / f64::from(up));
            cut = cut.quad("half", [[2.0, y0, z0], [2.0, y1, z0], [2.0, y1, z1], [2.0, y0, z1]]);
        }
    }
    let leaf = room().quad("leaf", [[2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [2.0, 3.0, 2.5], [2.0, 0.0, 2.5]]);
    // 188 of sRGB is 0.5029 in linear light.
    let half = "newmtl half\nKd .5029 .5029 .5029\n";
    let [cut, leaf] = [cut, leaf].map(|quads| solved(quads.scene_with(half), &usual(2000)));
    let mean = |solution: &Solution, beyond: bool| {
        let light = solution.light(&solution.scene.lighting());
        let (mut sum, mut area) = (0.0, 0.0);
        for (patch, h) in solution.mesh.patches.iter().zip(&light.irradiance) {
            let is_wall = solution.scene.materials[patch.material as usize].name == "grey";
            if is_wall && (patch.centre.x > 2.0) == beyond {
                sum += patch.area * luminance_weighted(h.map(f64::from));
                area += patch.area;
            }
        }
        sum / area
    };
    for beyond in [false, true] {
        let [found, wanted] = [&leaf, &cut].map(|solution| mean(solution, beyond));
        println!("beyond: {beyond}: {found} for {wanted}");
        assert!((found / wanted - 1.0).abs() < 0.02, "{found} is not {wanted} (beyond: {beyond})");
    }
    // Power, and rays of their own.
    let lighting = leaf.scene.lighting();
    let power = leaf.light(&lighting).power(&leaf.mesh, &leaf.reflectance, &lighting);
    assert!((power.absorbed / power.emitted - 1.0).abs() < 1e-3, "{power:?}");
    let findings = lumenwalk::study::audit(&leaf, &lighting, &AuditSettings::default(), &|| false);
    let total = findings.expect("lit").budget.total;
    println!("{total:?}");
    assert!(total.error < 0.04, "{total:?}");
}

#[test]
fn what_an_image_says_is_read_and_told() {
    let quads = |material: &str| {
        Quads::default().level("grey", [0.0, 0.0, 1.0, 1.0], 0.0, true).level(
            material,
            [0.0, 0.0, 1.0, 1.0],
            1.0,
            true,
        )
    };
    let told =
        |scene: &Scene| scene.findings.iter().map(|f| f.message.clone()).collect::<Vec<_>>().join("; ");
    let scene = quads("plate").scene();
    assert!(told(&scene).contains("'plate' (40 % of the image is open)"), "{}", told(&scene));
    let leaf = quads("leaf").scene();
    assert!(told(&leaf).contains("'leaf' (50 % of the image is open)"), "{}", told(&leaf));
    // The colour is that of what is there.
    let texture = leaf.materials.iter().find(|m| m.name == "leaf").and_then(|m| m.texture).expect("an image");
    let mean = leaf.textures[texture as usize].mean;
    assert!(mean.iter().all(|m| (m - 0.5029).abs() < 1e-3), "{mean:?}");
    // Both: the image's own alpha gives way to map_d. An alpha that is asked for and not there leaves it whole.
    let more = "newmtl both\nKd 1 1 1\nmap_Kd leaf.png\nmap_d stripes.png\nnewmtl whole\nKd .5 .5 .5\n\
        map_d -imfchan m stripes.png\nnewmtl gone\nKd .5 .5 .5\nmap_d nothing.png\n";
    let of = |name: &str| quads(name).scene_with(more);
    assert!(told(&of("both")).contains("'both' (40 % of the image is open)"));
    let whole = of("whole");
    let index = whole.materials.iter().position(|m| m.name == "whole").expect("it is there") as u32;
    assert!(!whole.has_holes(index));
    assert!(told(&of("gone")).contains("so that the material has no holes"), "{}", told(&of("gone")));
}

#[test]
fn the_picture_shows_what_is_behind_a_hole() {
    // A board of two by two fields before a wall that shines.
    let quads = Quads::default()
        .quad("lamp", [[-5.0, 2.0, -5.0], [5.0, 2.0, -5.0], [5.0, 2.0, 5.0], [-5.0, 2.0, 5.0]])
        .quad("leaf", [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]]);
    let scene = quads.scene();
    let solution = solved(scene.clone(), &usual(50));
    let light = solution.light(&scene.lighting());
    let drawn = DisplayMesh::build(&solution.mesh, &scene, true);
    let values = drawn.corner_radiosity(&light.radiosity, &light.irradiance, Shading::Gouraud);
    let picker = Picker::new(&solution.mesh);
    let input = StillInput {
        mesh: &drawn,
        picker: &picker,
        textures: &scene.textures,
        corner_radiosity: &values,
        corner_irradiance: &values,
        sky: None,
    };
    let camera = Camera::looking_at(DVec3::new(0.0, -3.0, 0.0), DVec3::ZERO, DVec3::Z, 30.0);
    let options = StillOptions::new([40, 40], Exposure { ev100: 8.0 }, ToneMap::Linear);
    let still = render_still(&input, &camera, &options, &|_| true).expect("whole");
    let shines = |x: usize, y: usize| {
        let patch = &solution.mesh.patches[still.patch_id[y * 40 + x] as usize];
        patch.luminaire.is_some()
    };
    // The image's first row is its top: open where it is left and upper, or right and lower.
    for (x, y, wanted) in [(10, 10, true), (30, 10, false), (10, 30, false), (30, 30, true)] {
        assert_eq!(shines(x, y), wanted, "{x} {y}");
    }
}
