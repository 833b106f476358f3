//! Reads the sources: which room may use which, which may know the screen, and how long a file may be.

use std::fs;
use std::path::{Path, PathBuf};

/// Every room in the order of the walk, with the rooms that it may use.
const ROOMS: &[(&str, &str)] = &[
    ("watch", ""),
    ("memory", ""),
    ("geometry", "watch"),
    ("encoding", ""),
    ("photometry", "encoding"),
    ("glazing", "geometry"),
    ("daylight", "glazing encoding geometry"),
    ("scene", "daylight glazing photometry encoding geometry memory watch"),
    ("mesh", "scene glazing photometry geometry watch"),
    ("effects", "mesh scene geometry"),
    ("visibility", "mesh scene geometry watch"),
    ("emitters", "visibility mesh scene daylight photometry geometry"),
    ("direct", "emitters visibility mesh scene geometry watch"),
    ("form_factors", "visibility effects mesh scene geometry watch"),
    ("transport", "form_factors mesh scene geometry watch"),
    ("solver", "transport form_factors effects mesh scene geometry watch"),
    ("accuracy", "solver transport direct form_factors visibility effects mesh scene daylight geometry"),
    (
        "solve",
        "accuracy solver transport direct emitters form_factors effects mesh scene geometry memory watch",
    ),
    (
        "session",
        "solve accuracy solver transport direct emitters form_factors effects mesh scene geometry watch",
    ),
    ("validate", "solve accuracy solver transport direct emitters form_factors effects mesh scene geometry"),
    ("display", "direct emitters mesh scene geometry"),
    ("navigation", "mesh scene geometry"),
    ("render", "navigation display direct visibility mesh scene geometry"),
    ("export", ""),
    (
        "outputs",
        "export render navigation display solver direct emitters form_factors effects mesh scene geometry",
    ),
    (
        "study",
        "outputs export display solve accuracy solver transport direct emitters form_factors effects mesh scene geometry memory watch",
    ),
    (
        "ui",
        "study outputs export render navigation display session daylight solve accuracy solver transport direct emitters form_factors \
         effects mesh scene photometry geometry",
    ),
    (
        "cli",
        "daylight photometry ui study outputs export render navigation display validate solve accuracy solver transport direct emitters form_factors \
         effects mesh scene geometry",
    ),
];

/// Libraries that only some rooms may know.
const CRATES: &[(&str, &[&str])] = &[
    ("wgpu", &["render", "ui"]),
    ("pollster", &["render", "ui"]),
    ("egui", &["ui"]),
    ("eframe", &["ui"]),
    ("egui_plot", &["ui"]),
    ("egui_system_font_provider", &["ui"]),
    ("rfd", &["ui"]),
    ("clap", &["cli"]),
    ("anyhow", &["cli"]),
    ("signal_hook", &["cli"]),
    ("exr", &["export"]),
    ("resvg", &["export"]),
    ("tobj", &["scene"]),
    ("solar_positioning", &["daylight"]),
    ("sysinfo", &["memory"]),
];

/// All that the command line takes from the window.
const UI_FOR_CLI: &[&str] = &["run", "UiError"];

const LONGEST_FILE: usize = 600;

const TOP_LEVEL: &[&str] = &[
    "Cargo.toml",
    "Cargo.lock",
    "README.md",
    "LICENSE-MIT",
    "LICENSE-APACHE",
    "src",
    "assets",
    "tests",
    "benches",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// A source without comments and without what stands in double quotes, so that words there are not
/// mistaken for code. Line breaks stay.
fn code_of(source: &str) -> String {
    let mut code = String::with_capacity(source.len());
    let mut rest = source;
    while let Some(first) = rest.chars().next() {
        if rest.starts_with("//") {
            rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
        } else if let Some(body) = rest.strip_prefix("r#\"") {
            rest = &body[body.find("\"#").map_or(body.len(), |end| end + 2)..];
        } else if let Some(body) = rest.strip_prefix('"') {
            let mut escaped = false;
            let end = body.find(|c| {
                let ends = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                ends
            });
            rest = &body[end.map_or(body.len(), |end| end + 1)..];
        } else if let Some(after) = rest.strip_prefix("'\"'") {
            rest = after;
        } else {
            code.push(first);
            rest = &rest[first.len_utf8()..];
        }
    }
    code
}

/// Paths that follow `prefix` (such as `crate::`), with the names of a group `{a, b}` taken apart at
/// its first level.
fn paths_after<'a>(code: &'a str, prefix: &str) -> Vec<&'a str> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices(prefix) {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        // `$crate::` and `other_crate::` are other things.
        if code[..at].ends_with(|c: char| is_word(c) || c == '$') {
            continue;
        }
        let rest = code[at + prefix.len()..].trim_start();
        match rest.strip_prefix('{') {
            None => found.push(&rest[..rest.find(|c| !is_word(c)).unwrap_or(rest.len())]),
            Some(group) => {
                let (mut depth, mut start, mut end) = (0, 0, group.len());
                for (i, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => {
                            end = i;
                            break;
                        }
                        '}' => depth -= 1,
                        ',' if depth == 0 => {
                            found.push(first_word(&group[start..i]));
                            start = i + 1;
                        }
                        _ => {}
                    }
                }
                found.push(first_word(&group[start..end]));
            }
        }
    }
    found.retain(|name| !name.is_empty());
    found
}

fn first_word(text: &str) -> &str {
    let text = text.trim();
    &text[..text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len())]
}

/// Whether the code names a path that begins with this crate.
fn uses_crate(code: &str, name: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(name).any(|(at, _)| {
        let before = &code[..at];
        let after = &code[at + name.len()..];
        let path = after.starts_with("::") || (before.ends_with("use ") && after.starts_with([';', ' ']));
        path && !before.ends_with(|c: char| is_word(c) || c == ':')
    })
}

/// What one file of a room does that it may not.
fn offences(room: &str, source: &str) -> Vec<String> {
    let code = code_of(source);
    let Some((_, allowed)) = ROOMS.iter().find(|(name, _)| *name == room) else {
        return vec![format!("the room {room} is not on the list")];
    };
    let allowed: Vec<&str> = allowed.split_whitespace().collect();
    let mut offences = Vec::new();
    for prefix in ["crate::", "lumenwalk::"] {
        for used in paths_after(&code, prefix) {
            let known = ROOMS.iter().any(|(name, _)| *name == used);
            if known && used != room && !allowed.contains(&used) {
                offences.push(format!("{room} uses {used}"));
            }
        }
    }
    if room == "cli" {
        let taken = paths_after(&code, "ui::");
        offences
            .extend(taken.iter().filter(|t| !UI_FOR_CLI.contains(t)).map(|t| format!("cli uses ui::{t}")));
    }
    for (name, rooms) in CRATES {
        if !rooms.contains(&room) && uses_crate(&code, name) {
            offences.push(format!("{room} knows {name}"));
        }
    }
    offences
}

#[test]
fn the_rooms_use_each_other_one_way() {
    let mut found = Vec::new();
    for (room, _) in ROOMS {
        let mut files = Vec::new();
        rust_files(&root().join("src").join(room), &mut files);
        let single = root().join("src").join(format!("{room}.rs"));
        files.extend(single.exists().then_some(single));
        for file in files {
            let source = fs::read_to_string(&file).unwrap();
            let name = file.strip_prefix(root()).unwrap().display().to_string();
            found.extend(offences(room, &source).into_iter().map(|what| format!("{name}: {what}")));
        }
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn every_room_is_on_the_list_and_the_library_names_them_in_its_order() {
    let lib = code_of(&fs::read_to_string(root().join("src/lib.rs")).unwrap());
    let declared = paths_after(&lib, "pub mod ");
    let order = |name: &str| ROOMS.iter().position(|(room, _)| *room == name);
    let places: Vec<usize> = declared
        .iter()
        .map(|name| order(name).unwrap_or_else(|| panic!("the room {name} is not on the list")))
        .collect();
    assert!(places.is_sorted(), "src/lib.rs names the rooms out of order: {declared:?}");
    for (place, (room, uses)) in ROOMS.iter().enumerate() {
        for used in uses.split_whitespace() {
            assert!(order(used).is_some_and(|p| p < place), "{room} may not use the later {used}");
        }
    }
    for entry in fs::read_dir(root().join("src")).unwrap().flatten() {
        let path = entry.path();
        let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(
            declared.contains(&stem.as_str()) || ["lib", "main"].contains(&stem.as_str()),
            "src/{stem} is no room of the library"
        );
    }
}

#[test]
fn no_file_is_longer_than_it_should_be() {
    let mut files = Vec::new();
    for folder in ["src", "tests", "benches"] {
        rust_files(&root().join(folder), &mut files);
    }
    assert!(files.len() > 20, "the sources were not found: {} files", files.len());
    let long: Vec<String> = files
        .iter()
        .map(|file| (file, fs::read_to_string(file).unwrap().lines().count()))
        .filter(|&(_, lines)| lines > LONGEST_FILE)
        .map(|(file, lines)| format!("{} has {lines} lines", file.display()))
        .collect();
    assert!(long.is_empty(), "\n{}", long.join("\n"));
}

#[test]
fn the_top_level_holds_what_was_agreed() {
    // Build outputs may lie about; what counts is what is under version control, which a published
    // package does not have.
    let Ok(listing) = std::process::Command::new("git").args(["ls-files"]).current_dir(root()).output()
    else {
        return;
    };
    let listing = String::from_utf8_lossy(&listing.stdout);
    for path in listing.lines() {
        let top = path.split('/').next().unwrap_or(path);
        assert!(top.starts_with('.') || TOP_LEVEL.contains(&top), "{path} is not among {TOP_LEVEL:?}");
    }
}

#[test]
fn offences_are_seen_in_every_way_of_writing_them() {
    let clean =
        "use crate::geometry::{Aabb, Frame};\n//! crate::ui::run egui::Context\nlet s = \"crate::cli::x\";";
    assert_eq!(offences("scene", clean), Vec::<String>::new());
    let offend = |room: &str, source: &str| offences(room, source).join("; ");
    assert_eq!(offend("scene", "use crate::mesh::Patch;"), "scene uses mesh");
    assert_eq!(
        offend("render", "use crate::{\n    display::{tone, solver},\n    session::Session,\n};"),
        "render uses session"
    );
    assert_eq!(offend("mesh", "fn f() { crate::solver::go(); }"), "mesh uses solver");
    assert_eq!(offend("display", "use wgpu::util;"), "display knows wgpu");
    assert_eq!(offend("render", "fn f(ui: &mut egui::Ui) {}"), "render knows egui");
    assert_eq!(offend("session", "use eframe as e;"), "session knows eframe");
    assert_eq!(offend("cli", "crate::ui::run(a); use crate::ui::{UiError, App};"), "cli uses ui::App");
    assert_eq!(offend("scene", "let q = '\"'; crate::cli::run();"), "scene uses cli");
    assert_eq!(offend("ui", "use egui_wgpu::wgpu; crate::solve::solve();"), "");
}
