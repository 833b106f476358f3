//! No bytes bring a reader down.

use super::gltf_file::{textured, with_light};
use super::ply::ply;
use lumenwalk::scene::{self, SceneSource};
use proptest::prelude::*;
use serde_json::{Value, json};

/// Reads a file of any bytes and looks at every number in it.
fn survive(file: &str, bytes: &[u8]) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(file), bytes).unwrap();
    // One that has just been written may be on its way, and is waited for.
    let written = std::fs::File::options().write(true).open(folder.path().join(file)).unwrap();
    written.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(60)).unwrap();
    match scene::load(&SceneSource::File(folder.path().join(file))) {
        Ok(scene) => {
            assert!(scene.positions.iter().all(|p| p.is_finite()));
            assert!(scene.uvs.iter().all(|uv| uv.is_finite()));
            assert!(scene.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
            assert!(scene.materials.iter().flat_map(|m| m.reflectance).all(|r| (0.0..=1.0).contains(&r)));
            let outputs = scene.luminaires.iter().flat_map(|lamp| lamp.initial.output());
            assert!(outputs.into_iter().all(|e| e.is_finite() && e >= 0.0));
            assert!(scene.views.iter().all(|view| view.eye.is_finite() && view.eye != view.target));
        }
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains(file) && !message.contains('\n'), "{message:?}");
        }
    }
}

/// Some bytes overwritten, then perhaps cut.
fn mutated(mut bytes: Vec<u8>, edits: &[(usize, u8)], cut: Option<usize>) -> Vec<u8> {
    for (place, value) in edits {
        let place = place % bytes.len();
        bytes[place] = *value;
    }
    if let Some(cut) = cut {
        bytes.truncate(cut % bytes.len());
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_file_of_any_bytes_brings_a_reader_down(
        edits in prop::collection::vec((any::<usize>(), any::<u8>()), 1..6),
        cut in prop::option::weighted(0.2, any::<usize>()),
        digit in prop::option::weighted(0.5, (any::<usize>(), b'0'..=b'9')),
    ) {
        let lit = with_light(json!({ "type": "spot", "intensity": 9.0, "spot": { "outerConeAngle": 0.5 } }));
        survive("a.glb", &mutated(lit.glb(), &edits, cut));
        // Digits are what a text is most easily wrong in.
        let mut text = textured(|_| json!({ "uri": "data:,x" }), Value::Null).with_data().into_bytes();
        if let Some((place, value)) = digit {
            let digits: Vec<usize> = (0..text.len()).filter(|&k| text[k].is_ascii_digit()).collect();
            text[digits[place % digits.len()]] = value;
            survive("a.gltf", &text);
        } else {
            survive("a.gltf", &mutated(text, &edits, cut));
        }
        survive("a.ply", &mutated(ply("ascii"), &edits, cut));
        survive("b.ply", &mutated(ply("binary_little_endian"), &edits, cut));
    }
}
