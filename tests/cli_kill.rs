//! The program killed at any moment: every output is the old file or the new one, whole.

mod cli_support;

use cli_support::Workplace;
use std::process::Stdio;
use std::time::{Duration, Instant};

const OUTPUTS: [&str; 6] = ["table.csv", "mesh.ply", "picture.png", "radiance.exr", "out.csv", "report.json"];

fn arguments(image: &'static str) -> Vec<&'static str> {
    let mut arguments = vec!["solve", "room.obj", "--patches", "300", "--resolution", "48"];
    arguments.extend(["--patch-table", "table.csv", "--mesh", "mesh.ply", "--report", "report.json"]);
    arguments.extend(["--points", "p.csv", "--irradiance", "out.csv", "--image", image, "--size", "320x200"]);
    arguments
}

/// Whether this is a whole report; its timings differ from run to run.
fn is_report(text: &[u8]) -> bool {
    serde_json::from_slice::<serde_json::Value>(text).is_ok_and(|value| value.is_object())
}

#[test]
fn a_killed_process_leaves_old_files_or_new_ones_and_no_halves() {
    let place = Workplace::with_room(0.5);
    place.put("p.csv", "1000,0,1000,0,1,0\n750,500,750,0,3,0\n");
    let read = |name: &str| std::fs::read(place.path(name)).unwrap();
    // What a run that is left alone writes, and how long it takes.
    let clock = Instant::now();
    place.succeed(&arguments("picture.png"));
    let taken = clock.elapsed();
    place.succeed(&arguments("radiance.exr"));
    let whole: Vec<Vec<u8>> = OUTPUTS.iter().map(|name| read(name)).collect();
    let old = b"what stood here before";

    let mut state = 42_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    let (mut killed, mut replaced) = (0, 0);
    for round in 0..40 {
        for name in OUTPUTS {
            std::fs::write(place.path(name), old).unwrap();
        }
        let image = if round % 2 == 0 { "picture.png" } else { "radiance.exr" };
        let mut child = place
            .command(&arguments(image))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Sooner or later, mostly towards the end, where files are written.
        let share = 1.2 * random().sqrt();
        std::thread::sleep(Duration::from_secs_f64(taken.as_secs_f64() * share));
        killed += i32::from(child.try_wait().unwrap().is_none());
        child.kill().ok();
        child.wait().unwrap();
        for (name, new) in OUTPUTS.iter().zip(&whole) {
            let found = read(name);
            let is_new = found == *new || (*name == "report.json" && is_report(&found));
            assert!(
                is_new || found == old,
                "round {round}: {name} is neither old nor new: {} bytes",
                found.len()
            );
            replaced += i32::from(is_new);
        }
    }
    // The next run clears what those left behind.
    place.succeed(&arguments("picture.png"));
    let left: Vec<String> = place.files().into_iter().filter(|name| name.starts_with('.')).collect();
    assert!(left.is_empty(), "{left:?}");
    assert!(killed >= 5, "{killed} of 40 were still running when they were killed");
    assert!(replaced >= 1, "no run came as far as its files");
}
