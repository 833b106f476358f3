//! Files that are dragged over the window and dropped on it.

use crate::support::{Counting, solved, window};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::ui::App;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug)]
pub(crate) struct Dropped(pub(crate) PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("the program reads files itself".to_owned())
    }
}

pub(crate) fn drop_on(harness: &mut Harness<'_, App>, paths: &[&str]) {
    for path in paths {
        harness.input_mut().dropped_files.push(Arc::new(Dropped(PathBuf::from(path))));
    }
    harness.run_steps(2);
}

#[test]
fn the_first_model_that_is_dropped_is_opened() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    drop_on(&mut harness, &["/models/notes.txt", "/models/Room.OBJ", "/models/other.obj"]);
    let opened: Vec<String> = worker.requests().into_iter().filter(|r| r.starts_with("open ")).collect();
    assert_eq!(opened, ["open /models/Room.OBJ"]);
    // One that has not come yet, and may never, is none of the files opened last.
    assert!(!harness.state().state().recent.contains(&PathBuf::from("/models/Room.OBJ")));
    assert_eq!(harness.state().state().recent.len(), 1, "the scene that is shown is one");
}

#[test]
fn what_is_no_model_is_refused_in_words() {
    let worker = Counting::showing(solved());
    let mut harness = window(&worker, false);
    drop_on(&mut harness, &["/models/notes.txt"]);
    assert!(worker.requests().iter().all(|request| !request.starts_with("open ")));
    assert!(
        harness
            .query_by_label("/models/notes.txt is no model that can be read (OBJ, glTF, GLB or PLY)")
            .is_some()
    );
    assert!(harness.state().camera().is_some(), "the present scene is left alone");
}
