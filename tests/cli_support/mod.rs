//! Runs the real program in a folder of its own.
#![allow(dead_code, reason = "each test program uses a part of this")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A room of 2 x 2 x 2 m with a lamp of 0.5 x 0.5 m half a metre under its ceiling, in millimetres.
const ROOM_OBJ: &str = "\
mtllib room.mtl
v 0 0 0\nv 2000 0 0\nv 2000 0 2000\nv 0 0 2000
v 0 2000 0\nv 2000 2000 0\nv 2000 2000 2000\nv 0 2000 2000
v 750 1500 750\nv 1250 1500 750\nv 1250 1500 1250\nv 750 1500 1250
o floor\nusemtl paint\nf 4 3 2 1
o ceiling\nusemtl paint\nf 5 6 7 8
o wall_south\nusemtl paint\nf 8 7 3 4
o wall_north\nusemtl paint\nf 1 2 6 5
o wall_west\nusemtl paint\nf 1 5 8 4
o wall_east\nusemtl paint\nf 2 3 7 6
o desk_lamp\nusemtl glow\nf 9 10 11 12
";

const ROOM_TOML: &str = "\
unit = \"mm\"

[[view]]
name = \"Entrance\"
eye = [1000, 1000, 1900]
target = [1000, 900, 0]
fov = 70

[[luminaire]]
object = \"desk_lamp\"
name = \"Desk lamp\"
exitance = [10, 20, 30]
";

/// A temporary folder with `room.obj`; gone when dropped.
pub(crate) struct Workplace {
    folder: tempfile::TempDir,
}

impl Workplace {
    /// With walls of this grey.
    pub(crate) fn with_room(reflectance: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let place = Self { folder };
        place.put("room.obj", ROOM_OBJ);
        place.put("room.toml", ROOM_TOML);
        let r = reflectance;
        let mtl = format!("newmtl paint\nKd {r} {r} {r}\nnewmtl glow\nKd 0 0 0\nKe 1 1 1\n");
        place.put("room.mtl", &mtl);
        place
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn put(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of all files, hidden ones too.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program in this folder, without a display.
    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = program(self.folder.path());
        command.args(arguments);
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).stdin(Stdio::null()).output().unwrap()
    }

    /// Runs it and demands success; gives its standard output.
    pub(crate) fn succeed(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {complaint}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs it, demands this exit code, one sentence under the program's name, and no new file;
    /// gives the sentence.
    pub(crate) fn fail(&self, code: i32, arguments: &[&str]) -> String {
        let before = self.files();
        let output = self.run(arguments);
        let complaint = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {complaint}");
        assert!(!complaint.contains("panicked"), "{complaint}");
        assert_eq!(self.files(), before, "{arguments:?} left something behind");
        let lines: Vec<&str> = complaint.lines().collect();
        let [line] = lines[..] else { panic!("{arguments:?}: one sentence was expected:\n{complaint}") };
        line.strip_prefix("lumenwalk: ").unwrap_or_else(|| panic!("{line}")).to_owned()
    }
}

/// The program, to be run in this folder and without a display.
fn program(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumenwalk"));
    command.current_dir(folder).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command.env_remove("WAYLAND_SOCKET");
    command
}
