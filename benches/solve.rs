//! From one row of form factors to the first picture.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use lumenwalk::effects::{Effect, EffectChoices};
use lumenwalk::form_factors::{Method, Row};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, SceneSource, from_text, load};
use lumenwalk::solve::{
    Control, PipelineError, Prepared, SolveSettings, Stage, patch_reflectance, prepare, solve, system,
};
use lumenwalk::solver::{GaussSeidel, LightBases};
use lumenwalk::transport::DenseTransport;
use lumenwalk::watch::Watch;
use rayon::prelude::*;
use std::hint::black_box;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

fn builtin(name: &str) -> Arc<Scene> {
    Arc::new(load(&SceneSource::Builtin(name.to_owned())).expect("an embedded scene"))
}

/// A room of 4 x 3 x 5 m under a ceiling that shines: convex and empty.
fn convex_room() -> Arc<Scene> {
    let obj = "mtllib room.mtl\n\
        v 0 0 0\nv 4 0 0\nv 4 0 5\nv 0 0 5\nv 0 3 0\nv 4 3 0\nv 4 3 5\nv 0 3 5\n\
        usemtl paint\nf 4 3 2 1\nf 8 7 3 4\nf 1 2 6 5\nf 1 5 8 4\nf 2 3 7 6\nusemtl glow\nf 5 6 7 8\n";
    let mtl = "newmtl paint\nKd .5 .5 .5\nnewmtl glow\nKd .5 .5 .5\nKe 5 5 5\n";
    Arc::new(from_text("room", obj, mtl, None).expect("a scene"))
}

fn prepared(scene: &Arc<Scene>, method: Method, resolution: u32) -> Prepared {
    let settings = SolveSettings { method, resolution: Some(resolution), ..SolveSettings::default() };
    prepare(scene.clone(), &settings).expect("a mesh")
}

fn all_rows(prepared: &Prepared) -> Vec<Row> {
    let computer = &prepared.computer;
    (0..prepared.mesh.patches.len() as u32)
        .into_par_iter()
        .map_init(|| computer.scratch(), |scratch, i| computer.row(i, scratch))
        .collect()
}

/// One row on one thread, the mean over rows spread through the scene.
fn one_row(criterion: &mut Criterion) {
    let scene = builtin("hemicube");
    let mut group = criterion.benchmark_group("one row, hemicube");
    group.sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(500));
    for (method, resolution) in [
        (Method::Lines, 64),
        (Method::Lines, 96),
        (Method::Lines, 192),
        (Method::Lines, 384),
        (Method::Hemicube, 64),
        (Method::Hemicube, 256),
        (Method::Hemicube, 1024),
        (Method::Rays, 4096),
    ] {
        let made = prepared(&scene, method, resolution);
        let mut scratch = made.computer.scratch();
        let count = made.mesh.patches.len() as u32;
        let mut next = 0;
        group.bench_function(BenchmarkId::new(method.name(), resolution), |b| {
            b.iter(|| {
                next = (next + 389) % count;
                made.computer.row(black_box(next), &mut scratch)
            });
        });
    }
    group.finish();
}

/// Rows, assembly and a sweep of the default scene on all threads.
fn stages(criterion: &mut Criterion) {
    let scene = builtin("hemicube");
    let made = prepared(&scene, Method::Lines, 192);
    let patches = made.mesh.patches.len();
    let mut group = criterion.benchmark_group(format!("hemicube, {patches} patches"));
    group.sample_size(10).measurement_time(Duration::from_secs(4)).warm_up_time(Duration::from_millis(500));
    group.bench_function("all rows", |b| b.iter(|| all_rows(&made)));
    let mut rows = all_rows(&made);
    group.bench_function("assemble", |b| {
        b.iter(|| Watch::nobody(|watch| DenseTransport::assemble(&made.computer, &mut rows.clone(), watch)));
    });
    let transport = Watch::nobody(|watch| DenseTransport::assemble(&made.computer, &mut rows, watch))
        .expect("not cancelled");
    let system = system(&made, &patch_reflectance(&made.mesh, &|_| None));
    let start = GaussSeidel::new(&made.mesh, &transport, &system, None);
    group.bench_function("one sweep with its correction", |b| {
        b.iter_batched(
            || start.clone(),
            |mut solver| solver.sweep(&transport, &system, &|| false),
            criterion::BatchSize::LargeInput,
        );
    });
    group.bench_function("first picture", |b| {
        b.iter(|| {
            let mut seen = false;
            let result = solve(scene.clone(), &SolveSettings::default(), &AtomicBool::new(false), &mut |p| {
                // What the window would show: direct light of all lamps, copied.
                if matches!(p.stage, Stage::FirstLight | Stage::Rows)
                    && let Some(picture) = p.picture()
                {
                    seen = true;
                    black_box(picture);
                    return Control::Cancel;
                }
                Control::Continue
            });
            assert!(seen && matches!(result, Err(PipelineError::Cancelled)));
        });
    });
    group.finish();
}

/// The sum that a lamp's switch costs.
fn basis_sum(criterion: &mut Criterion) {
    let scene = builtin("house");
    let settings = SolveSettings { patches: PatchTarget::Count(20_000), ..SolveSettings::default() };
    let made = prepare(scene, &settings).expect("a mesh");
    let patches = made.mesh.patches.len();
    let lamps = 15;
    let mut lighting = made.scene.lighting();
    lighting.lamps.resize(lamps, lighting.lamps[0]);
    let values = (0..patches * lamps * 3).map(|i| (i % 97) as f32 * 1e-3).collect();
    let bases = LightBases { patches, lamps, bands: 3, values };
    let reflectance: Vec<[f32; 3]> =
        made.mesh.patches.iter().map(|p| p.reflectance.map(|r| r as f32)).collect();
    let mut group = criterion.benchmark_group("basis sum");
    group.sample_size(20);
    group.bench_function(format!("{patches} patches, {lamps} lamps"), |b| {
        b.iter(|| bases.mix(&made.mesh, black_box(&lighting), &reflectance));
    });
    group.finish();
}

/// An effect that is off costs nothing: all rows of a convex room, and a sweep with one band or three.
fn effects(criterion: &mut Criterion) {
    let scene = convex_room();
    let mut group = criterion.benchmark_group("effects, convex grey room");
    group.sample_size(10).measurement_time(Duration::from_secs(3)).warm_up_time(Duration::from_millis(500));
    for (name, with) in [("as planned", vec![]), ("forced on", vec![Effect::Visibility, Effect::ColourBands])]
    {
        let settings = SolveSettings {
            patches: PatchTarget::Count(1000),
            effects: EffectChoices { with, without: vec![] },
            ..SolveSettings::default()
        };
        let made = prepare(scene.clone(), &settings).expect("a mesh");
        group.bench_function(BenchmarkId::new("all rows (visibility)", name), |b| b.iter(|| all_rows(&made)));
        let transport =
            Watch::nobody(|watch| DenseTransport::assemble(&made.computer, &mut all_rows(&made), watch))
                .expect("not cancelled");
        let system = system(&made, &patch_reflectance(&made.mesh, &|_| None));
        let start = GaussSeidel::new(&made.mesh, &transport, &system, None);
        group.bench_function(BenchmarkId::new("one sweep (bands)", name), |b| {
            b.iter_batched(
                || start.clone(),
                |mut solver| solver.sweep(&transport, &system, &|| false),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, one_row, stages, basis_sum, effects);
criterion_main!(benches);
