//! From a lamp's switch to the values that the graphics adapter draws, and a still.

use criterion::{Criterion, criterion_group, criterion_main};
use lumenwalk::display::{DisplayMesh, Exposure, Shading, ToneMap};
use lumenwalk::mesh::{MeshSettings, PatchMesh, PatchTarget, build};
use lumenwalk::render::{Camera, Picker, StillInput, StillOptions, render_still};
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

criterion_group!(benches, display);
criterion_main!(benches);
