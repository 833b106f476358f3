//! Direct light: at a point, from a cell's shafts, and on all elements of a scene.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use lumenwalk::direct::{DirectLight, ElementSettings, Elements, Scratch};
use lumenwalk::effects::Effect;
use lumenwalk::scene::{SceneSource, load};
use lumenwalk::solve::{Prepared, SolveSettings, prepare};
use lumenwalk::watch::Watch;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

const SCENES: [&str; 3] = ["hemicube", "gallery", "house"];

fn prepared(name: &str) -> Prepared {
    let scene = load(&SceneSource::Builtin(name.to_owned())).expect("an embedded scene");
    prepare(Arc::new(scene), &SolveSettings::default()).expect("a mesh")
}

fn light_of(prepared: &Prepared) -> DirectLight {
    DirectLight::new(&prepared.mesh, prepared.plan.is_on(Effect::Visibility))
}

fn settings(light: &DirectLight) -> ElementSettings {
    ElementSettings {
        error: 0.02,
        most: 60_000,
        work: u64::MAX,
        exitance: vec![1.0; light.emitters().bases.len()],
        smooth: true,
        focus: None,
    }
}

/// What one patch in fifty may see, and its light at the centre of it; on one thread.
fn cells(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("direct light of a cell");
    group.sample_size(10).measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(300));
    for name in SCENES {
        let prepared = prepared(name);
        let (mesh, light) = (&prepared.mesh, light_of(&prepared));
        let cells: Vec<_> = mesh
            .patches
            .iter()
            .filter(|patch| !patch.buried)
            .step_by(50)
            .map(|patch| {
                let piece = mesh.pieces_of(patch).next().expect("a piece");
                (mesh.polygon(piece, patch.side), patch.centre, patch.normal)
            })
            .collect();
        let mut scratch = Scratch::default();
        group.throughput(Throughput::Elements(cells.len() as u64));
        group.bench_function(format!("shafts, {name}"), |bench| {
            bench.iter(|| {
                for (cell, _, normal) in &cells {
                    black_box(light.views(cell, *normal, false, &mut scratch));
                }
            });
        });
        let views: Vec<_> =
            cells.iter().map(|(cell, _, normal)| light.views(cell, *normal, false, &mut scratch)).collect();
        group.bench_function(format!("light at its middle, {name}"), |bench| {
            bench.iter(|| {
                for ((_, centre, normal), views) in cells.iter().zip(&views) {
                    light.gather(*centre, *normal, views, &mut scratch, |_, value| {
                        black_box(value);
                    });
                }
            });
        });
    }
}

/// All elements at default settings, with all threads.
fn elements(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("elements");
    group.sample_size(10).measurement_time(Duration::from_secs(5)).warm_up_time(Duration::from_millis(300));
    for name in SCENES {
        let prepared = prepared(name);
        let (mesh, light) = (&prepared.mesh, light_of(&prepared));
        let settings = settings(&light);
        let build =
            || Watch::nobody(|watch| Elements::build(mesh, &light, &settings, watch)).expect("elements");
        group.throughput(Throughput::Elements(build().leaves().count() as u64));
        group.bench_function(name, |bench| bench.iter(build));
    }
}

criterion_group!(benches, cells, elements);
criterion_main!(benches);
