//! A long time of random commands against the real worker: memory stays flat, and the picture in the
//! end is that of a fresh solve.

mod common;

use common::{Model, room_with_blocks, solved};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{Scene, SceneSource, load};
use lumenwalk::session::{MaterialEdit, Session};
use lumenwalk::solve::{SolveSettings, Stage};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit.max(1)
    }

    fn share(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }
}

/// Memory held now, MB, where the system tells.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? / 1024.0)
}

fn write(folder: &Path, name: &str, model: &Model) -> SceneSource {
    let (obj, mtl) = model.texts();
    std::fs::write(folder.join(format!("{name}.obj")), format!("mtllib {name}.mtl\n{obj}")).unwrap();
    std::fs::write(folder.join(format!("{name}.mtl")), mtl).unwrap();
    SceneSource::File(folder.join(format!("{name}.obj")))
}

/// Waits for news until the worker has answered all and rests in a stage that ends a request.
fn settle(session: &Session, news: &Receiver<()>, name: &str, settings: &SolveSettings) {
    loop {
        let latest = session.latest();
        let scene = latest.scene().map(|s| s.name.as_str());
        if latest.stage == Stage::Converged && scene == Some(name) && latest.settings == *settings {
            return;
        }
        assert!(latest.stage != Stage::Failed, "{:?}", latest.error);
        assert!(news.recv_timeout(Duration::from_secs(300)).is_ok(), "it stands at {:?}", latest.stage);
    }
}

fn soak(length: Duration, seed: u64) {
    let folder = tempfile::tempdir().unwrap();
    let sources = [
        ("room", write(folder.path(), "room", &room_with_blocks(0.5))),
        (
            "clutter",
            write(folder.path(), "clutter", &lumenwalk::validate::scenes::cluttered_room(5, 3).into()),
        ),
        ("doors", write(folder.path(), "doors", &lumenwalk::validate::scenes::rooms_in_a_row(2, 0.8).into())),
    ];
    let (tell, news) = channel();
    let session = Session::spawn(move || tell.send(()).unwrap_or(())).unwrap();
    let mut random = Random(seed);
    let mut settings =
        SolveSettings { patches: PatchTarget::Count(200), resolution: Some(48), ..SolveSettings::default() };
    session.set_settings(settings.clone());
    session.open(sources[0].1.clone());
    let mut held: Vec<f64> = Vec::new();
    let mut longest = Duration::ZERO;
    let start = Instant::now();
    let mut commands = 0;
    while start.elapsed() < length {
        let before = Instant::now();
        match random.below(12) {
            0 | 1 => session.open(sources[random.below(3)].1.clone()),
            2 | 3 => {
                settings.patches = PatchTarget::Count(100 + 50 * random.below(6));
                settings.tolerance = [1e-3, 1e-4, 1e-6][random.below(3)];
                session.set_settings(settings.clone());
            }
            4..=6 => {
                let edit = MaterialEdit {
                    material: random.below(2) as u32,
                    reflectance: [random.share() * 0.98, random.share() * 0.9, random.share()]
                        .map(|r| r.min(0.98)),
                };
                // At times of a scene that is about to be replaced.
                if let Some(scene) = session.latest().scene() {
                    session.set_materials(scene, vec![edit]);
                }
            }
            7 => session.pause(),
            8 => session.resume(),
            9 => session.stop(),
            // A lamp is switched and dimmed over the latest picture.
            _ => {
                let latest = session.latest();
                if let (Some(scene), Some(mesh), Some(bases)) =
                    (latest.scene(), latest.mesh(), latest.bases())
                    && bases.patches == mesh.patches.len()
                {
                    let mut lighting = scene.lighting();
                    for lamp in &mut lighting.lamps {
                        (lamp.on, lamp.dimmer) = (random.below(3) > 0, random.share());
                    }
                    let light = bases.mix(mesh, &lighting, latest.reflectance().expect("as solved for"));
                    assert!(light.radiosity.iter().flatten().all(|b| b.is_finite() && *b >= 0.0));
                }
            }
        }
        longest = longest.max(before.elapsed());
        commands += 1;
        while news.try_recv().is_ok() {}
        std::thread::sleep(Duration::from_millis(random.below(60) as u64));
        if commands % 10 == 0 {
            held.extend(memory());
        }
    }

    // The last word: one scene, one size, one paint.
    let (name, source) = &sources[1];
    let edit = MaterialEdit { material: 0, reflectance: [0.3, 0.6, 0.8] };
    let last = SolveSettings { patches: PatchTarget::Count(333), tolerance: 1e-6, ..settings };
    session.resume();
    session.open(source.clone());
    session.set_settings(last.clone());
    settle(&session, &news, name, &last);
    session.set_materials(session.latest().scene().expect("settled"), vec![edit]);
    loop {
        let latest = session.latest();
        let painted = latest.reflectance().is_some_and(|all| all.iter().any(|r| (r[2] - 0.8).abs() < 1e-6));
        if latest.stage == Stage::Converged && painted {
            break;
        }
        assert!(news.recv_timeout(Duration::from_secs(300)).is_ok(), "it stands at {:?}", latest.stage);
    }
    let solution = session.latest().solved().expect("it has converged");
    let mut fresh: Scene = load(source).unwrap();
    fresh.materials[0].reflectance = edit.reflectance;
    let fresh = solved(&Arc::new(fresh), &last);
    let lighting = fresh.scene.lighting();
    let (a, b) = (solution.light(&lighting), fresh.light(&lighting));
    let largest = b.irradiance.iter().flatten().copied().fold(0.0, f32::max);
    assert_eq!(a.irradiance.len(), b.irradiance.len());
    for (x, y) in a.irradiance.iter().flatten().zip(b.irradiance.iter().flatten()) {
        assert!((x - y).abs() <= 1e-5 * largest, "{x} after the soak, {y} fresh");
    }

    println!("{commands} commands (seed {seed}); the longest took {longest:?} of this thread's time");
    // Flat: the second half against the part of the first that follows the warming up.
    let quarter = held.len() / 4;
    if quarter >= 4 {
        let median = |part: &[f64]| {
            let mut sorted = part.to_vec();
            sorted.sort_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        };
        let (early, late) = (median(&held[quarter..2 * quarter]), median(&held[3 * quarter..]));
        println!("{early:.1} MB in the second quarter, {late:.1} MB in the last");
        // A few megabytes are the allocator's own.
        assert!(late <= 1.05 * early + 8.0, "memory grows: {held:?}");
    }
}

#[test]
fn twenty_seconds_of_random_commands() {
    soak(Duration::from_secs(20), 7);
}

#[test]
#[ignore = "takes ten minutes, or as many seconds as LUMENWALK_SOAK says; run in CI"]
fn a_long_time_of_random_commands() {
    let seconds = std::env::var("LUMENWALK_SOAK").ok().and_then(|s| s.parse().ok()).unwrap_or(600);
    soak(Duration::from_secs(seconds), 1985);
}
