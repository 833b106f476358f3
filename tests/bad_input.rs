//! Bad input: each case gives one clear sentence, nothing panics, and repairs are told.

use lumenwalk::scene::{Finding, Scene, SceneError, SceneSource, Severity, check, from_text, load};
use std::fs;
use std::path::Path;

#[path = "fuzz/readers.rs"]
mod readers;

use readers::{MTL, OBJ, POINTS, SIDECAR};

/// Writes the files of a scene into a folder and reads it.
fn read(folder: &Path, obj: &[u8], mtl: Option<&[u8]>, sidecar: Option<&[u8]>) -> Result<Scene, SceneError> {
    let path = folder.join("room.obj");
    fs::write(&path, obj).unwrap();
    for (name, content) in [("room.mtl", mtl), ("room.toml", sidecar)] {
        match content {
            Some(content) => fs::write(folder.join(name), content).unwrap(),
            None => _ = fs::remove_file(folder.join(name)),
        }
    }
    load(&SceneSource::File(path))
}

fn error(obj: &str, mtl: &str, sidecar: &str) -> String {
    let message = from_text("room", obj, mtl, Some(sidecar)).expect_err("should fail").to_string();
    assert!(!message.contains('\n'), "one sentence, one line: {message}");
    message
}

fn warning<'a>(scene: &'a Scene, words: &str) -> &'a Finding {
    let found = scene.findings.iter().find(|f| f.message.contains(words));
    let found = found.unwrap_or_else(|| panic!("no finding says '{words}': {:?}", scene.findings));
    assert!(!found.message.contains('\n'));
    found
}

fn png() -> Vec<u8> {
    let image = image::RgbImage::from_fn(16, 16, |x, y| image::Rgb([(x * 16) as u8, (y * 16) as u8, 200]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[test]
fn a_good_scene_reads_without_a_finding() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("paper.png"), png()).unwrap();
    let with_uvs = ["5 8 7 6", "1 5 6 2", "4 3 7 8", "1 4 8 5", "2 6 7 3"]
        .iter()
        .fold(OBJ.to_owned(), |obj, face| obj.replace(face, &(face.replace(' ', "/1 ") + "/2")));
    let scene =
        read(folder.path(), with_uvs.as_bytes(), Some(MTL.as_bytes()), Some(SIDECAR.as_bytes())).unwrap();
    assert_eq!(scene.findings, []);
    assert_eq!((scene.surfaces.len(), scene.textures.len(), scene.luminaires.len()), (7, 1, 1));
    assert_eq!(scene.materials[0].texture, Some(0));
    assert_eq!(scene.views[scene.start_view].name, "Door");
    assert_eq!(check(&scene).iter().filter(|f| f.severity > Severity::Note).count(), 0);
}

#[test]
fn files_that_are_missing_empty_or_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let message = |source: &Path| load(&SceneSource::File(source.to_owned())).unwrap_err().to_string();
    assert!(message(&folder.path().join("none.obj")).ends_with("none.obj: there is no such file"));
    assert!(message(folder.path()).contains("this is a folder"));
    for (content, expected) in [
        (&b""[..], "the file is empty"),
        (b" \n\t\r\n", "the file is empty"),
        (b"v 0 0 0\nv 1 0 0\n", "holds no faces"),
        (b"\x89PNG\r\n\x1a\n\0\0\xff\xfe", "holds no faces"),
    ] {
        let error = read(folder.path(), content, None, None).unwrap_err().to_string();
        assert!(error.contains("room.obj") && error.contains(expected), "{error}");
    }
    let unknown = load(&SceneSource::from("builtin:nowhere")).unwrap_err().to_string();
    assert!(unknown.contains("no embedded scene 'nowhere'"), "{unknown}");
}

#[test]
fn models_without_extent_or_area() {
    assert!(error("v 1 1 1\nf 1 1 1\n", "", "").contains("no size"));
    let line = error("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 3 2 1\n", "", "");
    assert!(line.contains("none of the 2 faces has an area"), "{line}");
}

#[test]
fn broken_lines_name_file_and_line() {
    for (from, to, expected) in [
        ("v 4 3 0\n", "v 4 3\n", "room.obj, line 4: 'v' needs 3 numbers"),
        ("v 4 3 0\n", "v 4 3 0x\n", "room.obj, line 4: '0x' is not a number"),
        ("v 4 3 0\n", "v 4 NaN 0\n", "room.obj, line 4: a coordinate is not a finite number"),
        ("v 4 3 0\n", "v 4 -inf 0\n", "room.obj, line 4: a coordinate is not a finite number"),
        ("f 5 8 7 6", "f 5 8 7 60", "room.obj, line 21: the face asks for vertex 60, and 12 of them"),
        ("f 5 8 7 6", "f 5 8 7 0", "room.obj, line 21: the face asks for vertex 0"),
        ("f 5 8 7 6", "f 5 8 7 -60", "asks for vertex -60"),
        ("f 5 8 7 6", "f 5 8 7 6.5", "is not made of whole numbers"),
        ("f 5 8 7 6", "f 5 8 7 99999999999999999999999", "is not made of whole numbers"),
    ] {
        let message = error(&OBJ.replacen(from, to, 1), MTL, SIDECAR);
        assert!(message.contains(expected), "{to}: {message}");
    }
    for (from, to, expected) in [
        ("Kd 0.7 0.7 0.7", "Kd 0.7 0.7", "room.mtl, line 2: 'Kd' needs three numbers and has 2"),
        ("Kd 0.7 0.7 0.7", "Kd 0.7 zero 0.7", "room.mtl, line 2: 'zero' is not a number"),
        (
            "Kd 0.7 0.7 0.7",
            "Kd 0,7 0,7 0,7",
            "room.mtl, line 2: '0,7' is not a number: it has a decimal comma",
        ),
    ] {
        let message = error(OBJ, &MTL.replacen(from, to, 1), SIDECAR);
        assert!(message.contains(expected), "{to}: {message}");
    }
}

#[test]
fn sidecar_mistakes_name_key_and_line() {
    for (from, to, expected) in [
        ("unit = \"m\"", "unt = \"m\"", "room.toml, line 1: unknown key 'unt'"),
        ("unit = \"m\"", "unit = \"km\"", "room.toml, line 1: unknown variant 'km'"),
        ("fov = 70", "fow = 70", "room.toml, line 9: unknown key 'fow'"),
        ("fov = 70", "fov = 170", "the fov of view 'Door' must lie between 5 and 150"),
        ("fov = 70", "fov = nan", "must lie between 5 and 150"),
        ("eye = [1, 1.6, 4]", "eye = [1, 1.6]", "room.toml, line 7"),
        ("eye = [1, 1.6, 4]", "eye = [inf, 1.6, 4]", "must look from one point to another"),
        ("target = [2, 1, 0]", "target = [1, 1.6, 4]", "must look from one point to another"),
        (
            "start = \"Door\"",
            "start = \"Window\"",
            "line 3: start names the view 'Window', and there are 'Door'",
        ),
        ("patch_size = 0.2", "patch_size = 0", "line 4: patch_size must be a length"),
        ("patch_size = 0.2", "patch_size = -inf", "line 4: patch_size must be a length"),
        (
            "object = \"lamp\"",
            "object = \"lmap\"",
            "line 10: the luminaire 'Ceiling lamp' asks for the object 'lmap', which is not there; the nearest names are 'lamp'",
        ),
        (
            "name = \"white\"",
            "name = \"whit\"",
            "line 16: there is no material 'whit'; the nearest names are 'white'",
        ),
        ("reflectance = [0.8, 0.8, 0.8]", "reflectance = [-1, 0, 0]", "must lie between 0 and 1"),
        ("sides = \"auto\"", "sides = \"left\"", "unknown variant 'left'"),
        ("lumens = 800", "lumens = \"800\"", "line 13"),
        ("[[view]]", "[[view", "line 5"),
    ] {
        let message = error(OBJ, MTL, &SIDECAR.replacen(from, to, 1));
        assert!(message.contains(expected), "{to}: {message}");
    }
}

#[test]
fn doubtful_materials_are_repaired_and_named() {
    let scene = |mtl: &str| from_text("room", OBJ, mtl, None).unwrap();
    let white = |kd: &str| scene(&MTL.replace("Kd 0.7 0.7 0.7\nmap_Kd paper.png", kd));
    for (kd, words, expected) in [
        (
            "Kd 1.2 1 0.5",
            "above 0.98, more than any paint reflects, were lowered to it: 'white' (1.2)",
            [0.98, 0.98, 0.5],
        ),
        ("Kd 1.0004 0 0", "above 0.98", [0.98, 0.0, 0.0]),
        ("Kd -0.1 0.5 0.5", "Kd below 0 were raised to it: 'white'", [0.0, 0.5, 0.5]),
        ("Kd nan nan nan", "Kd that is not a number were taken as grey 0.5: 'white'", [0.5; 3]),
        ("Ks 1 1 1", "without a Kd were taken as grey 0.5: 'white'", [0.5; 3]),
    ] {
        let scene = white(kd);
        assert_eq!(warning(&scene, words).severity, Severity::Warning, "{kd}");
        assert_eq!(scene.materials[0].reflectance, expected, "{kd}");
    }
    // Glass needs none.
    let glass = white("Tf 0.9 0.9 0.9\nillum 6");
    assert!(glass.materials[0].glazing.is_some());
    let messages: Vec<&str> = glass.findings.iter().map(|finding| finding.message.as_str()).collect();
    assert!(!messages.iter().any(|message| message.contains("without a Kd")), "{messages:?}");
    for (ke, words, lamps) in [
        ("Ke -5 5 5", "a Ke below 0 were raised to it: 'light'", 1),
        ("Ke -5 -5 -5", "a Ke below 0 were raised to it: 'light'", 0),
        ("Ke nan 5 5", "a Ke that is no usable number emit nothing: 'light'", 0),
        ("Ke inf 5 5", "a Ke that is no usable number emit nothing: 'light'", 0),
    ] {
        let scene = scene(&MTL.replace("Ke 5 5 5", ke));
        warning(&scene, words);
        assert_eq!(scene.luminaires.len(), lamps, "{ke}");
        let finite =
            |l: &lumenwalk::scene::Luminaire| l.initial.exitance.iter().all(|e| e.is_finite() && *e >= 0.0);
        assert!(scene.luminaires.iter().all(finite));
    }
}

#[test]
fn missing_libraries_materials_and_images_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = read(folder.path(), OBJ.as_bytes(), None, None).unwrap();
    warning(
        &scene,
        "cannot be read, so that their materials are grey 0.5: 'room.mtl' (room.obj, line 1: there is no such file)",
    );
    assert_eq!(scene.materials.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["white", "light"]);
    assert!(scene.materials.iter().all(|m| m.reflectance == [0.5; 3]));
    assert!(check(&scene).iter().any(|f| f.message.contains("this scene has no lamp")));

    let scene = read(
        folder.path(),
        OBJ.replace("usemtl white", "usemtl wihte").as_bytes(),
        Some(MTL.as_bytes()),
        None,
    )
    .unwrap();
    warning(&scene, "no library defines were taken as grey 0.5: 'wihte'");

    warning(&scene, "'paper.png' of material 'white' (");
    let whole = png();
    for damaged in [&whole[..whole.len() / 2], &whole[..20], b"", b"no image at all"] {
        fs::write(folder.path().join("paper.png"), damaged).unwrap();
        let scene = read(folder.path(), OBJ.as_bytes(), Some(MTL.as_bytes()), None).unwrap();
        warning(&scene, "'paper.png' of material 'white' (");
        assert_eq!(scene.materials[0].reflectance, [0.7; 3]);
        assert_eq!(scene.materials[0].texture, None);
    }
}

#[test]
fn faces_are_dropped_and_repaired_with_count_and_object() {
    let room = format!("{OBJ}o junk\nusemtl white\n");
    for (faces, words, count) in [
        ("f 1 2\nf 3\n", "fewer than three corners", 2),
        ("f 1 2 2\nf 1 1 1\n", "faces without an area were dropped (2, in 'junk', line", 2),
        ("f 2 3 4 1\nf 5 8 7 6\n", "there twice were dropped (2, in 'junk', line", 2),
        ("f 6 7 8 5\n", "written once more for their other side", 1),
        ("f 1 2 2 7\n", "repeated corners were cleaned", 1),
        ("f 1 2 7 4\n", "not planar were split into triangles (1, in 'junk', line", 1),
        ("f 1 3 2 4\n", "crosses itself", 1),
    ] {
        let scene = from_text("room", &format!("{room}{faces}"), MTL, None).unwrap();
        assert_eq!(warning(&scene, words).count, count, "{faces}");
    }
}

#[test]
fn absurd_sizes_raise_doubt_about_the_unit() {
    for (factor, words) in [("e6", "very large"), ("e-6", "very small")] {
        let obj = format!("v 0 0 0\nv 1{factor} 0 0\nv 0 1{factor} 0\nf 1 2 3\n");
        let scene = from_text("room", &obj, "", None).unwrap();
        assert!(warning(&scene, words).message.contains("room.toml"));
    }
    assert!(error("v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n", "", "").contains("larger than any building"));
    assert!(error("v 0 0 0\nv 1e-200 0 0\nv 0 1e-200 0\nf 1 2 3\n", "", "").contains("room.obj"));
}

#[test]
fn text_quirks_do_not_matter() {
    let plain = from_text("room", OBJ, MTL, Some(SIDECAR)).unwrap();
    let crlf = |text: &str| text.replace('\n', "\r\n");
    let quirky =
        format!("\u{feff}# a comment\r\n{}", crlf(OBJ).replace("f 5 8 7 6", "  f 5 8 \\\r\n  7 6 # tail"));
    let scene = from_text("room", &quirky, &crlf(MTL), Some(&crlf(SIDECAR))).unwrap();
    assert_eq!(scene.positions, plain.positions);
    assert_eq!(scene.surfaces.len(), plain.surfaces.len());
    assert_eq!(scene.lighting(), plain.lighting());

    let folder = tempfile::tempdir().unwrap();
    let latin = OBJ.replace("o room", "o r?um").into_bytes();
    let latin: Vec<u8> = latin.into_iter().map(|b| if b == b'?' { 0xe4 } else { b }).collect();
    assert!(read(folder.path(), &latin, Some(MTL.as_bytes()), None).is_ok());
}

/// Deterministic damage to a text: bytes replaced, swapped, doubled and cut out; lines repeated, moved
/// and joined; numbers made wild; files cut short.
struct Damage {
    state: u64,
}

impl Damage {
    fn below(&mut self, limit: usize) -> usize {
        self.state =
            self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 33) as usize % limit.max(1)
    }

    fn hurt(&mut self, text: &mut Vec<u8>) {
        const WILD: &[u8] = b"0129-.e/ \n\r\t#\\\"[]=nafvotsu\xff\0";
        const NUMBERS: [&str; 12] = [
            "0",
            "-0",
            "1e308",
            "-1e308",
            "1e-308",
            "nan",
            "inf",
            "-1",
            "4294967296",
            "18446744073709551616",
            "0.1e",
            "9007199254740993",
        ];
        for _ in 0..=self.below(3) {
            if text.len() < 2 {
                return;
            }
            let at = self.below(text.len());
            match self.below(9) {
                0 => text[at] = WILD[self.below(WILD.len())],
                1 => text.insert(at, WILD[self.below(WILD.len())]),
                2 => _ = text.remove(at),
                3 => {
                    let other = self.below(text.len());
                    text.swap(at, other);
                }
                4 => text.truncate(at.max(1)),
                5 => {
                    // A line again, elsewhere.
                    let from = text[..at].iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
                    let to = text[at..].iter().position(|&b| b == b'\n').map_or(text.len(), |k| at + k + 1);
                    let line = text[from..to].to_vec();
                    let place = self.below(text.len());
                    text.splice(place..place, line);
                }
                6 => {
                    // A number made wild.
                    let is_number = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
                    let Some(from) = text[at..].iter().position(is_number).map(|k| at + k) else { continue };
                    let to = text[from..].iter().position(|b| !is_number(b)).map_or(text.len(), |k| from + k);
                    text.splice(from..to, NUMBERS[self.below(NUMBERS.len())].bytes());
                }
                7 => {
                    // A stretch many times over.
                    let to = (at + 1 + self.below(40)).min(text.len());
                    let stretch = text[at..to].repeat(1 + self.below(60));
                    text.splice(at..at, stretch);
                }
                _ => text[at] = self.below(256) as u8,
            }
        }
    }
}

/// The most memory that this process has held, bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[test]
fn ten_thousand_damaged_files_never_panic_and_never_let_a_wrong_number_through() {
    let mut damage = Damage { state: 0x9e37_79b9_7f4a_7c15 };
    let (mut accepted, mut refused) = (0, 0);
    for round in 0..10_000 {
        let mut texts = [OBJ, MTL, SIDECAR, POINTS].map(|t| t.as_bytes().to_vec());
        // The model itself is the richest.
        let chosen = [0, 1, 2, 3, 0, 2][round % 6];
        damage.hurt(&mut texts[chosen]);
        let good = if chosen == 3 {
            readers::points(&texts[3])
        } else {
            let [obj, mtl, sidecar, _] = texts.map(|t| String::from_utf8_lossy(&t).into_owned());
            readers::scene(&obj, &mtl, Some(&sidecar))
        };
        *if good { &mut accepted } else { &mut refused } += 1;
    }
    assert!(
        accepted > 1000 && refused > 1000,
        "the damage must be neither harmless nor total: {accepted}, {refused}"
    );
    assert!(peak_memory().is_none_or(|peak| peak < 1 << 30), "{:?} bytes", peak_memory());
}

#[test]
fn the_corpus_of_the_fuzzer_is_read_without_a_panic() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
    type Reader = fn(&[u8]) -> bool;
    let readers: [(&str, Reader); 4] = [
        ("obj", readers::obj),
        ("mtl", readers::mtl),
        ("sidecar", readers::sidecar),
        ("points", readers::points),
    ];
    for (name, read) in readers {
        let files: Vec<_> = fs::read_dir(corpus.join(name)).unwrap().flatten().map(|e| e.path()).collect();
        assert!(files.len() >= 3, "{name}: {} files", files.len());
        let accepted = files.iter().filter(|file| read(&fs::read(file).unwrap())).count();
        assert!(accepted > 0, "{name}: a good one is among them");
    }
}
