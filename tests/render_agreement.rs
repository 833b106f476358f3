//! The wgpu view and the CPU still show the same.

mod render_room;

use lumenwalk::display::{
    ColourMap, DisplayMesh, Exposure, FalseColour, Shading, ToneMap, luminance, meter, srgb_encode,
};
use lumenwalk::mesh::{MeshSettings, PatchMesh, PatchTarget, build};
use lumenwalk::navigation::Camera;
use lumenwalk::render::{
    ColourSource, FrameInput, Gpu, Picker, StillInput, StillOptions, ViewportRenderer, render_still,
};
use lumenwalk::scene::{Scene, SceneSource, load};
use render_room::{Room, camera, light};

const SIZE: [u32; 2] = [320, 200];

/// A device, or a note that the test was skipped. Skipping fails where `LUMENWALK_REQUIRE_GPU` is set.
fn gpu() -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(
                std::env::var_os("LUMENWALK_REQUIRE_GPU").is_none(),
                "a graphics adapter is required here: {error}"
            );
            eprintln!("skipped: {error}");
            None
        }
    }
}

struct Lit {
    scene: Scene,
    mesh: PatchMesh,
    display: DisplayMesh,
    radiosity: Vec<[f32; 3]>,
    irradiance: Vec<[f32; 3]>,
    exposure: Exposure,
}

impl Lit {
    fn room(shading: Shading) -> Self {
        let (scene, mesh) = Room::furnished().finish(0.3);
        Self::new(scene, mesh, shading)
    }

    fn new(scene: Scene, mesh: PatchMesh, shading: Shading) -> Self {
        let display = DisplayMesh::build(&mesh, &scene, true);
        let (h, b) = light(&mesh);
        let samples = mesh.patches.iter().zip(&b).filter(|(p, _)| p.luminaire.is_none());
        let exposure = meter(samples.map(|(p, &b)| (luminance(b), p.area))).expect("lit");
        Self {
            radiosity: display.corner_radiosity(&b, &h, shading),
            irradiance: display.corner_values(&h, shading),
            scene,
            mesh,
            display,
            exposure,
        }
    }

    fn renderer(&self, gpu: &Gpu) -> ViewportRenderer {
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let mut renderer = ViewportRenderer::new(&gpu.device, &gpu.queue, format);
        renderer
            .set_mesh(&gpu.device, &gpu.queue, &self.display, &self.scene.textures)
            .expect("a small mesh fits");
        renderer.set_light(&gpu.queue, &self.radiosity);
        renderer
    }

    fn frame(&self, camera: Camera, tone_map: ToneMap) -> FrameInput {
        FrameInput { exposure: self.exposure, tone_map, ..FrameInput::new(camera, SIZE) }
    }

    fn still(&self, frame: &FrameInput) -> Vec<u8> {
        let picker = Picker::new(&self.mesh);
        let input = StillInput {
            mesh: &self.display,
            picker: &picker,
            textures: &self.scene.textures,
            corner_radiosity: &self.radiosity,
            corner_irradiance: &self.irradiance,
        };
        let mut options = StillOptions::new(frame.size_px, frame.exposure, frame.tone_map);
        options.background = frame.background;
        render_still(&input, &frame.camera, &options, &|_| true).expect("not cancelled").to_rgba8()
    }
}

/// Mean absolute difference of the colour codes, as a fraction of the full range.
fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let codes =
        a.chunks_exact(4).zip(b.chunks_exact(4)).flat_map(|(a, b)| (0..3).map(|k| a[k].abs_diff(b[k])));
    codes.map(f64::from).sum::<f64>() / (a.len() / 4 * 3) as f64 / 255.0
}

/// Writes both pictures where `LUMENWALK_KEEP_PICTURES` names a folder, to be looked at.
fn keep(name: &str, pixels: &[u8]) {
    if let Some(folder) = std::env::var_os("LUMENWALK_KEEP_PICTURES") {
        let path = std::path::Path::new(&folder).join(name);
        image::save_buffer(path, pixels, SIZE[0], SIZE[1], image::ColorType::Rgba8).expect("writable folder");
    }
}

#[test]
fn view_and_still_agree_within_one_per_cent() {
    let Some(gpu) = gpu() else { return };
    for (shading, name) in [(Shading::Gouraud, "gouraud"), (Shading::Flat, "flat")] {
        let room = Lit::room(shading);
        let mut renderer = room.renderer(&gpu);
        let outside = Camera::looking_at(
            glam::DVec3::new(-3.0, 5.0, 9.0),
            glam::DVec3::new(2.0, 1.0, 2.0),
            glam::DVec3::Y,
            50.0,
        );
        for (camera, view) in [(camera(&room.scene), "inside"), (outside, "outside")] {
            for tone_map in ToneMap::ALL {
                let frame = room.frame(camera, tone_map);
                let shown = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
                let still = room.still(&frame);
                let difference = mean_difference(&shown, &still);
                println!("{name} {view} {tone_map:?}: {:.3} %", 100.0 * difference);
                keep(&format!("{name}-{view}-{}-gpu.png", tone_map.name()), &shown);
                keep(&format!("{name}-{view}-{}-cpu.png", tone_map.name()), &still);
                assert!(difference < 0.01, "{name} {view} {tone_map:?}: {difference}");
                // The picture must show something: neither black nor white.
                let mean = still.iter().map(|&x| f64::from(x)).sum::<f64>() / still.len() as f64;
                assert!((90.0..220.0).contains(&mean), "mean code {mean}");
            }
        }
    }
}

#[test]
fn view_and_still_agree_on_the_embedded_scenes() {
    let Some(gpu) = gpu() else { return };
    for name in ["cornell", "hemicube", "gallery", "house"] {
        let scene = load(&SceneSource::Builtin(name.to_owned())).expect("an embedded scene");
        let settings = MeshSettings { target: PatchTarget::Count(2000), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).expect("it has surfaces");
        let room = Lit::new(scene, mesh, Shading::Gouraud);
        let mut renderer = room.renderer(&gpu);
        for view in room.scene.views.iter().take(3) {
            let camera = Camera::from_view(view, room.scene.up.vector());
            let frame = room.frame(camera, ToneMap::Neutral);
            let shown = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
            let still = room.still(&frame);
            let difference = mean_difference(&shown, &still);
            println!("{name}, {}: {:.3} %", view.name, 100.0 * difference);
            keep(&format!("{name}-{}-gpu.png", view.name), &shown);
            keep(&format!("{name}-{}-cpu.png", view.name), &still);
            assert!(difference < 0.01, "{name}, {}: {difference}", view.name);
        }
    }
}

#[test]
fn a_change_of_light_changes_the_view() {
    let Some(gpu) = gpu() else { return };
    let room = Lit::room(Shading::Gouraud);
    let mut renderer = room.renderer(&gpu);
    let frame = room.frame(camera(&room.scene), ToneMap::Neutral);
    let lit = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
    let dim: Vec<[f32; 3]> = room.radiosity.iter().map(|b| b.map(|x| 0.25 * x)).collect();
    renderer.set_light(&gpu.queue, &dim);
    let brighter = FrameInput { exposure: frame.exposure.brighter(2.0), ..frame };
    let compensated = renderer.capture(&gpu.device, &gpu.queue, &brighter).expect("readback");
    assert!(mean_difference(&lit, &compensated) < 1e-3, "two stops make up for a quarter of the light");
    let darker = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
    assert!(mean_difference(&lit, &darker) > 0.1);
}

#[test]
fn false_colours_are_those_of_the_legend() {
    let Some(gpu) = gpu() else { return };
    let room = Lit::room(Shading::Flat);
    let mut renderer = room.renderer(&gpu);
    let values: Vec<f32> = (0..room.mesh.patches.len()).map(|i| 1.0 + (i * 37 % 900) as f32).collect();
    renderer.set_scalars(&gpu.queue, &room.display.corner_scalars(&values, Shading::Flat));
    let picker = Picker::new(&room.mesh);
    for map in ColourMap::ALL {
        for logarithmic in [false, true] {
            let scale = FalseColour { map, range: [5.0, 800.0], logarithmic };
            let mut frame = room.frame(camera(&room.scene), ToneMap::Neutral);
            frame.source = ColourSource::FalseColour(scale);
            frame.multisample = false;
            let shown = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
            keep(&format!("false-{}-{logarithmic}.png", map.name()), &shown);
            let mut compared = 0;
            for y in (0..SIZE[1]).step_by(7) {
                for x in (0..SIZE[0]).step_by(7) {
                    // Only where the neighbourhood is one patch: edges may fall to either side.
                    let patch_at = |dx: f64, dy: f64| {
                        let pixel = glam::DVec2::new(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
                        picker.pick(&frame.camera.ray(pixel, SIZE)).and_then(|p| p.patch)
                    };
                    let around = [(0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
                    let Some(patch) = patch_at(0.0, 0.0) else { continue };
                    if around.iter().any(|&(dx, dy)| patch_at(dx, dy) != Some(patch)) {
                        continue;
                    }
                    let expected =
                        scale.colour(values[patch as usize].into()).map(|c| srgb_encode(c) * 255.0);
                    let at = 4 * (y * SIZE[0] + x) as usize;
                    for band in 0..3 {
                        let code = f32::from(shown[at + band]);
                        assert!((code - expected[band]).abs() < 3.0, "{code} for {}", expected[band]);
                    }
                    compared += 1;
                }
            }
            assert!(compared > 300, "{compared}");
        }
    }
}

#[test]
fn every_mode_draws_something_of_its_own() {
    let Some(gpu) = gpu() else { return };
    let room = Lit::room(Shading::Gouraud);
    let mut renderer = room.renderer(&gpu);
    let plain = room.frame(camera(&room.scene), ToneMap::Neutral);
    let outside = Camera::looking_at(
        glam::DVec3::new(-3.0, 5.0, 9.0),
        glam::DVec3::new(2.0, 1.0, 2.0),
        glam::DVec3::Y,
        50.0,
    );
    let patch = Picker::new(&room.mesh)
        .pick(&plain.camera.ray(glam::DVec2::new(160.0, 100.0), SIZE))
        .and_then(|pick| pick.patch);
    assert!(patch.is_some());
    let frames = [
        ("plain", plain),
        ("wireframe", FrameInput { wireframe: true, ..plain }),
        ("ids", FrameInput { source: ColourSource::PatchIds, ..plain }),
        ("ids-wireframe", FrameInput { source: ColourSource::PatchIds, wireframe: true, ..plain }),
        ("normals", FrameInput { source: ColourSource::Normals, ..plain }),
        ("highlight", FrameInput { highlight: patch, ..plain }),
        ("outside", FrameInput { camera: outside, ..plain }),
        ("outside-wireframe", FrameInput { camera: outside, wireframe: true, ..plain }),
        ("outside-unlit", FrameInput { camera: outside, show_unlit: true, ..plain }),
    ];
    let mut pictures: Vec<(&str, Vec<u8>)> = Vec::new();
    for (name, frame) in frames {
        let shown = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
        keep(&format!("mode-{name}.png"), &shown);
        for (other, picture) in &pictures {
            let difference = mean_difference(&shown, picture);
            assert!(difference > 1e-4, "{name} looks like {other}: {difference}");
        }
        pictures.push((name, shown));
    }
}

#[test]
fn stills_have_all_layers_and_can_be_given_up() {
    let room = Lit::room(Shading::Gouraud);
    let picker = Picker::new(&room.mesh);
    let input = StillInput {
        mesh: &room.display,
        picker: &picker,
        textures: &room.scene.textures,
        corner_radiosity: &room.radiosity,
        corner_irradiance: &room.irradiance,
    };
    let camera = camera(&room.scene);
    let options = StillOptions::new([64, 40], room.exposure, ToneMap::Linear);
    let still = render_still(&input, &camera, &options, &|_| true).expect("not cancelled");
    assert_eq!(render_still(&input, &camera, &options, &|_| false), None);
    let pixels = 64 * 40;
    assert_eq!(
        [still.radiance.len(), still.patch_id.len(), still.depth.len(), still.to_rgba8().len() / 4],
        [pixels; 4]
    );
    for index in 0..pixels {
        let patch = &room.mesh.patches[still.patch_id[index] as usize];
        let normal = glam::Vec3::from(still.normal[index]).as_dvec3();
        assert!((normal.length() - 1.0).abs() < 1e-5 && normal.dot(patch.normal) > 0.9);
        assert!(still.depth[index] > 0.0 && still.depth[index] < 7.0);
        assert!((still.coverage[index] - 1.0).abs() < 1e-5);
        // An untextured reflector shows L = rho H / pi, to the smoothness of the light.
        if patch.material == render_room::WHITE {
            let expected = patch.reflectance[0] as f32 * still.irradiance[index][0] / std::f32::consts::PI;
            let same_patch = (0..4).all(|k| {
                let at = glam::DVec2::new((index % 64) as f64, (index / 64) as f64)
                    + glam::DVec2::new((k % 2) as f64, (k / 2) as f64);
                let pick = picker.pick(&camera.ray(at, options.size_px));
                pick.and_then(|p| p.patch) == Some(still.patch_id[index])
            });
            if same_patch {
                let shown = still.radiance[index][0];
                assert!((shown - expected).abs() < 0.02 * expected, "{shown} and {expected}");
            }
        }
    }
}
