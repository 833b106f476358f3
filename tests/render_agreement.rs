//! The wgpu view and the CPU still show the same.

mod render_room;

use glam::{DVec2, DVec3};
use lumenwalk::display::{
    ColourMap, DisplayMesh, Exposure, FalseColour, Shading, SkyLight, SkyView, ToneMap, luminance, meter,
    srgb_encode,
};
use lumenwalk::mesh::{MeshSettings, PatchMesh, PatchTarget, build};
use lumenwalk::navigation::Camera;
use lumenwalk::render::{
    ColourSource, FrameInput, Gpu, Picker, Still, StillInput, StillOptions, ViewportRenderer, render_still,
};
use lumenwalk::scene::{Lighting, Scene, SceneSource, from_text, load};
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
    lighting: Lighting,
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
            lighting: scene.lighting(),
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
            .set_mesh(
                &gpu.device,
                &gpu.queue,
                &self.display,
                &self.scene.textures,
                self.scene.outdoors.as_ref(),
            )
            .expect("a small mesh fits");
        renderer.set_light(&gpu.queue, &self.radiosity);
        renderer
    }

    fn frame(&self, camera: Camera, tone_map: ToneMap) -> FrameInput {
        let sky = self.scene.outdoors.as_ref().map(|outdoors| SkyLight::of(outdoors, &self.lighting));
        FrameInput { exposure: self.exposure, tone_map, sky, ..FrameInput::new(camera, SIZE) }
    }

    /// A floor and a slab that stands on it, under a clear sky with the sun in the south-east.
    fn under_the_sky() -> Self {
        let obj = "mtllib a.mtl\nusemtl white\nv 0 0 0\nv 6 0 0\nv 6 0 -6\nv 0 0 -6\nf 1 2 3 4\n\
            v 1 0 -2\nv 2 0 -2\nv 2 3 -2\nv 1 3 -2\nf 5 6 7 8\n";
        let sidecar = "unit = \"m\"\n[daylight]\nsun = [35, 150]\nsky = \"clear\"\n[[material]]\n\
            name = \"white\"\nsides = \"both\"\n";
        let mtl = "newmtl white\nKd .5 .5 .5\n";
        let scene = from_text("floor", obj, mtl, Some(sidecar)).expect("a good model");
        let settings = MeshSettings { target: PatchTarget::Count(200), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).expect("it has surfaces");
        let mut lit = Self::new(scene, mesh, Shading::Gouraud);
        // Surfaces as bright as under a sky.
        for value in lit.radiosity.iter_mut().flatten() {
            *value *= 60.0;
        }
        lit.exposure = Exposure { ev100: 13.0 };
        lit
    }

    fn still(&self, frame: &FrameInput) -> Vec<u8> {
        self.still_layers(frame).to_rgba8()
    }

    fn still_layers(&self, frame: &FrameInput) -> Still {
        let picker = Picker::new(&self.mesh);
        let input = StillInput {
            mesh: &self.display,
            picker: &picker,
            textures: &self.scene.textures,
            corner_radiosity: &self.radiosity,
            corner_irradiance: &self.irradiance,
            sky: SkyView::of(&self.scene, &self.lighting),
        };
        let mut options = StillOptions::new(frame.size_px, frame.exposure, frame.tone_map);
        options.background = frame.background;
        render_still(&input, &frame.camera, &options, &|_| true).expect("not cancelled")
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
        let outside =
            Camera::looking_at(DVec3::new(-3.0, 5.0, 9.0), DVec3::new(2.0, 1.0, 2.0), DVec3::Y, 50.0);
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

/// A camera in the model under the sky that looks in a direction.
fn towards(forward: DVec3) -> Camera {
    Camera { eye: DVec3::new(3.0, 1.6, -1.0), forward: forward.normalize(), up: DVec3::Y, fov_y_deg: 70.0 }
}

#[test]
fn view_and_still_agree_on_the_sky() {
    let Some(gpu) = gpu() else { return };
    let room = Lit::under_the_sky();
    let mut renderer = room.renderer(&gpu);
    let to_sun = room.scene.outdoors.as_ref().expect("a sky").to_sun();
    let views = [
        // Across the edge of the map, with the horizon, a slab and the floor before it.
        ("north", DVec3::new(-0.3, -0.05, -1.0)),
        ("sun", to_sun),
        ("zenith", DVec3::new(0.001, 1.0, 0.0)),
        ("ground", DVec3::new(0.4, -0.5, 1.0)),
    ];
    for (name, forward) in views {
        for multisample in [true, false] {
            let tone_map = if multisample { ToneMap::Neutral } else { ToneMap::Filmic };
            let frame = FrameInput { multisample, ..room.frame(towards(forward), tone_map) };
            let shown = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
            let still = room.still_layers(&frame);
            let coded = still.to_rgba8();
            keep(&format!("sky-{name}-{multisample}-gpu.png"), &shown);
            keep(&format!("sky-{name}-{multisample}-cpu.png"), &coded);
            let difference = mean_difference(&shown, &coded);
            println!("{name}, {multisample}: {:.3} %", 100.0 * difference);
            assert!(difference < 0.005, "{name}: {difference}");
            // Every pixel of the sky, but for the edges of horizon and sun.
            let pixels = shown.chunks_exact(4).zip(coded.chunks_exact(4)).zip(&still.coverage);
            let off = pixels.filter(|((a, b), covered)| **covered == 0.0 && a[1].abs_diff(b[1]) > 2).count();
            let most = still.coverage.len() / 100;
            assert!(off < most, "{name}: {off} pixels of the sky differ");
        }
    }
    // The disc stands out of the bright sky around it, where the sun is.
    let mut frame = room.frame(towards(to_sun + DVec3::new(0.2, 0.1, 0.0)), ToneMap::Linear);
    frame.exposure = frame.exposure.brighter(-6.0);
    let shown = renderer.capture(&gpu.device, &gpu.queue, &frame).expect("readback");
    let at = frame.camera.project(frame.camera.eye + to_sun, SIZE).expect("in front");
    let white: Vec<DVec2> = (0..SIZE[0] * SIZE[1])
        .filter(|&i| shown[4 * i as usize] > 128)
        .map(|i| DVec2::new(f64::from(i % SIZE[0]), f64::from(i / SIZE[0])) + 0.5)
        .collect();
    let middle = white.iter().sum::<DVec2>() / white.len() as f64;
    assert!((2..12).contains(&white.len()), "{} pixels of the disc", white.len());
    assert!(middle.distance(at) < 0.7, "{middle} and {at}");
}

#[test]
fn the_sky_of_a_still_is_the_radiance_outdoors() {
    let mut room = Lit::under_the_sky();
    let frame = room.frame(towards(DVec3::new(0.6, 0.2, 0.8)), ToneMap::Linear);
    let outdoors = room.scene.outdoors.clone().expect("a sky");
    let still = room.still_layers(&frame);
    let mut compared = 0;
    for index in (0..still.radiance.len()).step_by(97) {
        let pixel = DVec2::new((index % SIZE[0] as usize) as f64, (index / SIZE[0] as usize) as f64) + 0.5;
        let direction = frame.camera.ray(pixel, SIZE).direction;
        let edge = direction.y.abs() < 0.02 || direction.distance(outdoors.to_sun()) < 0.03;
        if still.coverage[index] > 0.0 || edge {
            continue;
        }
        let expected = outdoors.radiance(direction);
        for seen in still.radiance[index] {
            assert!((f64::from(seen) / expected - 1.0).abs() < 5e-3, "{seen} and {expected} at {direction}");
        }
        assert_eq!((still.patch_id[index], still.depth[index]), (lumenwalk::mesh::NO_PATCH, 0.0));
        compared += 1;
    }
    assert!(compared > 200, "{compared}");
    room.lighting.lamps.iter_mut().for_each(|lamp| lamp.on = false);
    let dark = room.still_layers(&frame);
    let sky = |still: &Still| {
        let pixels = still.radiance.iter().zip(&still.display).zip(&still.coverage);
        pixels.filter(|(_, covered)| **covered == 0.0).map(|((l, d), _)| l[1] + d[1]).sum::<f32>()
    };
    assert!(sky(&still) > 1000.0 && sky(&dark) == 0.0, "{} and {}", sky(&still), sky(&dark));
}

#[test]
fn the_sky_follows_its_lamps_and_stays_out_of_false_colours() {
    let Some(gpu) = gpu() else { return };
    let room = Lit::under_the_sky();
    let mut renderer = room.renderer(&gpu);
    let lit = room.frame(towards(DVec3::new(0.6, 1.2, 0.8)), ToneMap::Linear);
    let mean = |renderer: &mut ViewportRenderer, frame: &FrameInput, columns: std::ops::Range<usize>| {
        let shown = renderer.capture(&gpu.device, &gpu.queue, frame).expect("readback");
        let row = &shown[4 * 20 * SIZE[0] as usize..][..4 * SIZE[0] as usize];
        let count = columns.len() as f64;
        columns.map(|x| f64::from(row[4 * x + 1])).sum::<f64>() / count
    };
    let (all, left, right) = (0..SIZE[0] as usize, 0..150, 170..SIZE[0] as usize);
    assert!(mean(&mut renderer, &lit, all.clone()) > 60.0);
    let off = FrameInput { sky: Some(SkyLight::default()), ..lit };
    assert!(mean(&mut renderer, &off, all.clone()) < 1.0, "switched off");
    let background = FrameInput { sky: None, ..lit };
    let expected = f64::from(srgb_encode(lit.background[1]) * 255.0);
    assert!((mean(&mut renderer, &background, all.clone()) - expected).abs() < 1.0);
    let normals = FrameInput { source: ColourSource::Normals, ..lit };
    assert!((mean(&mut renderer, &normals, all) - expected).abs() < 1.0, "no sky beside normals");
    // A stored light has its own sky.
    let split = FrameInput { split: Some(0.5), stored_sky: Some(SkyLight::default()), ..lit };
    assert!(mean(&mut renderer, &split, left) < 1.0);
    assert!(mean(&mut renderer, &split, right) > 60.0);
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
                        let pixel = DVec2::new(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
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
    let outside = Camera::looking_at(DVec3::new(-3.0, 5.0, 9.0), DVec3::new(2.0, 1.0, 2.0), DVec3::Y, 50.0);
    let patch = Picker::new(&room.mesh)
        .pick(&plain.camera.ray(DVec2::new(160.0, 100.0), SIZE))
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
        sky: None,
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
                let at = DVec2::new((index % 64) as f64, (index / 64) as f64)
                    + DVec2::new((k % 2) as f64, (k / 2) as f64);
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
