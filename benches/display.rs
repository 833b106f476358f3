//! From a lamp's switch to the values that the graphics adapter draws, and a still.

use criterion::{Criterion, criterion_group, criterion_main};
use lumenwalk::display::{DisplayMesh, Exposure, Shading, ToneMap};
use lumenwalk::mesh::{MeshSettings, PatchMesh, PatchTarget, build};
use lumenwalk::navigation::Camera;
use lumenwalk::render::{
    ColourSource, FrameInput, Gpu, Picker, StillInput, StillOptions, ViewportRenderer, render_still,
};
use lumenwalk::scene::{Scene, SceneSource, UpAxis, load};
use lumenwalk::solver::LightBases;
use std::hint::black_box;

const PATCHES: usize = 50_000;
const LAMPS: usize = 12;

fn scene() -> (Scene, PatchMesh) {
    let scene = load(&SceneSource::from("builtin:house")).expect("an embedded scene");
    let settings = MeshSettings { target: PatchTarget::Count(PATCHES), ..MeshSettings::default() };
    let mesh = build(&scene, &settings).expect("it has surfaces");
    (scene, mesh)
}

fn display(criterion: &mut Criterion) {
    let (scene, mesh) = scene();
    let patches = mesh.patches.len();
    let mut lighting = scene.lighting();
    lighting.lamps.resize(LAMPS, lighting.lamps[0]);
    let bases = LightBases {
        patches,
        lamps: LAMPS,
        bands: 3,
        values: (0..patches * LAMPS * 3).map(|i| (i % 97) as f32 * 1e-3).collect(),
    };
    let reflectance: Vec<[f32; 3]> = mesh.patches.iter().map(|p| p.reflectance.map(|x| x as f32)).collect();

    let mut group = criterion.benchmark_group("display");
    group.sample_size(20);
    group.bench_function(format!("basis sum, {patches} patches, {LAMPS} lamps"), |b| {
        b.iter(|| bases.mix(&mesh, black_box(&lighting), &reflectance));
    });
    let light = bases.mix(&mesh, &lighting, &reflectance);
    group.bench_function(format!("display mesh, {patches} patches"), |b| {
        b.iter(|| DisplayMesh::build(&mesh, &scene, true));
    });
    let display = DisplayMesh::build(&mesh, &scene, true);
    group.bench_function(format!("vertex radiosity, {patches} patches"), |b| {
        b.iter(|| display.vertex_radiosity(black_box(&light.radiosity)));
    });
    group.bench_function(format!("corner radiosity, {patches} patches"), |b| {
        b.iter(|| display.corner_radiosity(black_box(&light.radiosity), &light.irradiance, Shading::Gouraud));
    });
    let gains = [0.9_f32, 1.0, 1.2];
    group.bench_function(format!("lamp switch to upload, {patches} patches, {LAMPS} lamps"), |b| {
        b.iter(|| {
            let light = bases.mix(&mesh, black_box(&lighting), &reflectance);
            let mut corners = display.corner_radiosity(&light.radiosity, &light.irradiance, Shading::Gouraud);
            for corner in &mut corners {
                *corner = std::array::from_fn(|band| corner[band] * gains[band]);
            }
            bytemuck::cast_slice::<_, u8>(&corners).to_vec()
        });
    });
    group.bench_function(format!("picker, {patches} patches"), |b| b.iter(|| Picker::new(&mesh)));

    let picker = Picker::new(&mesh);
    let corner_radiosity = display.corner_radiosity(&light.radiosity, &light.irradiance, Shading::Gouraud);
    let corner_irradiance = display.corner_values(&light.irradiance, Shading::Gouraud);
    let input = StillInput {
        mesh: &display,
        picker: &picker,
        textures: &scene.textures,
        corner_radiosity: &corner_radiosity,
        corner_irradiance: &corner_irradiance,
        sky: None,
    };
    let camera = Camera::from_view(&scene.views[scene.start_view], UpAxis::vector(scene.up));
    group.bench_function("view metering, 24 x 15 rays", |b| {
        b.iter(|| picker.seen_patches(black_box(&camera), [1280, 800], [24, 15]));
    });
    let options = StillOptions::new([640, 400], Exposure::default(), ToneMap::default());
    group.sample_size(10);
    group.bench_function("still, 640 x 400, 4 rays a pixel", |b| {
        b.iter(|| render_still(&input, black_box(&camera), &options, &|_| true));
    });
    group.finish();
}

/// Frames at 1280 x 800 on whatever adapter there is, waited for; light uploaded before each.
fn frames(criterion: &mut Criterion) {
    let Ok(gpu) = Gpu::headless() else {
        eprintln!("no graphics adapter: frames are not measured");
        return;
    };
    let Gpu { device, queue, info } = &gpu;
    let mut group = criterion.benchmark_group(format!("frame on {}", info.name));
    let window = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("window"),
        size: wgpu::Extent3d { width: 1280, height: 800, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let window = window.create_view(&wgpu::TextureViewDescriptor::default());
    group.sample_size(20);
    for name in ["builtin:hemicube", "builtin:house"] {
        let scene = load(&SceneSource::from(name)).expect("an embedded scene");
        let mesh = build(&scene, &MeshSettings::default()).expect("it has surfaces");
        let display = DisplayMesh::build(&mesh, &scene, true);
        let grey = vec![[1.0; 3]; mesh.patches.len()];
        let light = display.corner_radiosity(&grey, &grey, Shading::Gouraud);
        let mut renderer = ViewportRenderer::new(device, queue, wgpu::TextureFormat::Rgba8Unorm);
        renderer.set_mesh(device, queue, &display, &scene.textures, None).expect("it fits");
        let camera = Camera::from_view(&scene.views[scene.start_view], scene.up.vector());
        let plain = FrameInput { multisample: false, ..FrameInput::new(camera, [1280, 800]) };
        for (mode, frame) in [
            ("plain", plain),
            ("four samples", FrameInput { multisample: true, ..plain }),
            ("wireframe", FrameInput { wireframe: true, ..plain }),
            ("normals", FrameInput { source: ColourSource::Normals, ..plain }),
        ] {
            group.bench_function(format!("{name}, {} patches, {mode}", mesh.patches.len()), |b| {
                b.iter(|| {
                    renderer.set_light(queue, &light);
                    let commands = renderer.prepare(device, queue, &frame);
                    let mut encoder =
                        device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                    let attachment = wgpu::RenderPassColorAttachment {
                        view: &window,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations::default(),
                    };
                    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                        color_attachments: &[Some(attachment)],
                        ..Default::default()
                    });
                    renderer.paint(&mut pass);
                    drop(pass);
                    queue.submit([commands, encoder.finish()]);
                    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device answers");
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, display, frames);
criterion_main!(benches);
