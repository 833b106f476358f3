//! A file is written to a temporary one in the same folder, then renamed, so that it appears whole or not
//! at all.
//!
//! A run that is killed leaves its temporary file behind, and the next run that writes into the folder
//! removes it. Which files nobody is writing any more is told by a lock that the system gives up with the
//! process: it holds for other machines that share the folder as well, where a process number would not.

use super::ExportError;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Files begun and not yet renamed. Held while one is created, renamed or removed, so that
/// [`abandon`] sees each of them either begun or finished.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Tells apart two files of one name that are written at the same time.
static SERIAL: AtomicU32 = AtomicU32::new(0);

/// Folders that were searched for files left by killed runs: once per process.
static SEARCHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// What the name of a temporary file has behind the name of the target: this, PID-SERIAL, and [`ENDING`].
const MARK: &str = ".lumenwalk-";
const ENDING: &str = ".tmp";
/// So often another file is begun where a fresh one was taken for one that was left behind.
const ATTEMPTS: usize = 8;

/// Writes a file by way of `.NAME.lumenwalk-PID-SERIAL.tmp` in the same folder.
///
/// A symbolic link is followed; a device or pipe, which cannot be renamed onto, is written to
/// directly.
///
/// # Errors
/// Where the folder, the file or `fill` refuses; nothing is left behind then, and a file that
/// stood there before stays as it was.
pub fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), ExportError> {
    write_inner(path, fill).map_err(|source| ExportError::Write { path: path.to_owned(), source })
}

/// Finds out whether [`write()`] could succeed, so that an hour's work is not begun in vain.
///
/// # Errors
/// As [`write()`].
pub fn probe(path: &Path) -> Result<(), ExportError> {
    let attempt = || match place(path)? {
        Place::Direct(path) => File::options().write(true).open(path).map(drop),
        Place::Renamed(path) => Unfinished::begin(&path).map(drop),
    };
    attempt().map_err(|source| ExportError::Write { path: path.to_owned(), source })
}

/// Removes all files begun and not finished, and calls `end` before another can begin: for a
/// process that is about to be killed.
pub fn abandon(end: impl FnOnce()) {
    let unfinished = lock();
    for path in unfinished.iter() {
        // Nobody is left to be told if this fails.
        let _ = fs::remove_file(path);
    }
    end();
}

fn write_inner(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    match place(path)? {
        Place::Direct(path) => {
            let mut writer = BufWriter::new(File::options().write(true).open(path)?);
            fill(&mut writer)?;
            writer.flush()
        }
        Place::Renamed(path) => {
            let (unfinished, file) = Unfinished::begin(&path)?;
            let mut writer = BufWriter::new(file);
            fill(&mut writer)?;
            writer.flush()?;
            let file = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.sync_all()?;
            // Still locked: until it has its name nobody may take it for left behind.
            unfinished.finish(&path)
        }
    }
}

enum Place {
    /// A device or pipe.
    Direct(PathBuf),
    /// An ordinary file, there or not.
    Renamed(PathBuf),
}

fn place(path: &Path) -> io::Result<Place> {
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Ok(found) if found.is_file() => Ok(Place::Renamed(fs::canonicalize(path)?)),
        Ok(_) => Ok(Place::Direct(path.to_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => match path.file_name() {
            Some(_) => Ok(Place::Renamed(path.to_owned())),
            None => Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file")),
        },
        Err(error) => Err(error),
    }
}

/// A file being written; removed when dropped without [`Unfinished::finish`].
struct Unfinished {
    path: PathBuf,
    finished: bool,
}

impl Unfinished {
    fn begin(target: &Path) -> io::Result<(Self, File)> {
        for _ in 0..ATTEMPTS {
            let mut name = OsString::from(".");
            name.push(target.file_name().unwrap_or_default());
            let serial = SERIAL.fetch_add(1, Ordering::Relaxed);
            name.push(format!("{MARK}{}-{serial}{ENDING}", std::process::id()));
            let path = target.with_file_name(name);
            let mut unfinished = lock();
            let file = File::create(&path)?;
            unfinished.insert(path.clone());
            drop(unfinished);
            let begun = Self { path, finished: false };
            // Where the system knows no locks nothing is ever removed.
            let _ = file.lock();
            if fs::symlink_metadata(&begun.path).is_ok() {
                remove_abandoned(&begun.path, &file);
                return Ok((begun, file));
            }
        }
        Err(io::Error::other("temporary files there are removed as fast as they are made"))
    }

    fn finish(mut self, target: &Path) -> io::Result<()> {
        let mut unfinished = lock();
        fs::rename(&self.path, target)?;
        unfinished.remove(&self.path);
        self.finished = true;
        Ok(())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if !self.finished {
            let mut unfinished = lock();
            // The error that brought us here is the one to report.
            let _ = fs::remove_file(&self.path);
            unfinished.remove(&self.path);
        }
    }
}

/// Removes what killed runs left in the folder of `own`, an open temporary file of this run; only files of
/// the same user that bear the name of a temporary file of this program and that no process holds locked.
fn remove_abandoned(own: &Path, file: &File) {
    let Some(folder) = own.parent() else { return };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut searched = SEARCHED.lock().unwrap_or_else(PoisonError::into_inner);
    if !searched.insert(folder.to_owned()) {
        return;
    }
    drop(searched);
    // What cannot be read or removed stays: it is in nobody's way.
    let (Ok(entries), Ok(ours)) = (fs::read_dir(folder), file.metadata()) else { return };
    for entry in entries.flatten() {
        let is_temporary = is_temporary(&entry.file_name().to_string_lossy());
        if !is_temporary || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let path = entry.path();
        let Ok(left) = File::options().write(true).open(&path) else { continue };
        let is_ours = left.metadata().is_ok_and(|theirs| same_owner(&ours, &theirs));
        if is_ours && left.try_lock().is_ok() {
            let _ = fs::remove_file(&path);
        }
    }
}

/// Whether a file's name is that of a temporary file of this program.
fn is_temporary(name: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let numbers = name
        .strip_prefix('.')
        .and_then(|name| name.strip_suffix(ENDING))
        .and_then(|name| name.rsplit_once(MARK))
        .and_then(|(target, numbers)| numbers.split_once('-').filter(|_| !target.is_empty()));
    numbers.is_some_and(|(process, serial)| is_number(process) && is_number(serial))
}

#[cfg(unix)]
fn same_owner(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    a.uid() == b.uid()
}

/// Elsewhere what may be opened for writing counts.
#[cfg(not(unix))]
fn same_owner(_: &fs::Metadata, _: &fs::Metadata) -> bool {
    true
}

fn lock() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_replaces_the_old_one_when_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write(&path, |w| w.write_all(b"old")).unwrap();
        write(&path, |w| {
            w.write_all(b"new")?;
            w.flush()?;
            assert_eq!(fs::read(&path)?, b"old");
            assert_eq!(names(folder.path()).len(), 2, "the new one stands beside it");
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write(&path, |w| w.write_all(b"old")).unwrap();
        let error = write(&path, |w| {
            w.write_all(b"half")?;
            Err(io::ErrorKind::StorageFull.into())
        })
        .unwrap_err();
        assert!(error.to_string().ends_with("a.txt: the disk is full"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn missing_folders_and_folders_in_the_way_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let error = probe(&folder.path().join("no/a.txt")).unwrap_err().to_string();
        assert!(error.ends_with("its folder does not exist"), "{error}");
        let error = write(folder.path(), |_| Ok(())).unwrap_err().to_string();
        assert!(error.ends_with("a folder has that name"), "{error}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn probing_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        probe(&folder.path().join("a.txt")).unwrap();
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str| fs::write(folder.path().join(name), "half").unwrap();
        let left = [".a.txt.lumenwalk-1-0.tmp", ".other.png.lumenwalk-99999999-12.tmp"];
        let foreign = [
            ".a.txt.lumenwalk-1-0.tmp~",
            ".a.txt.lumenwalk-1-x.tmp",
            ".a.txt.lumenwalk-.tmp",
            ".a.txt.tmp",
            ".lumenwalk-1-0.tmp",
            "a.txt.lumenwalk-1-0.tmp",
            "notes.tmp",
        ];
        left.iter().chain(&foreign).for_each(|name| put(name));
        fs::create_dir(folder.path().join(".d.lumenwalk-1-0.tmp")).unwrap();
        // One that a run is writing.
        let alive = ".b.txt.lumenwalk-1-0.tmp";
        put(alive);
        let held = File::open(folder.path().join(alive)).unwrap();
        held.lock().unwrap();
        write(&folder.path().join("a.txt"), |w| w.write_all(b"new")).unwrap();
        let mut expected: Vec<String> = foreign
            .iter()
            .chain(&["a.txt", alive, ".d.lumenwalk-1-0.tmp"])
            .map(|n| (*n).to_owned())
            .collect();
        expected.sort();
        assert_eq!(names(folder.path()), expected);
        assert_eq!(fs::read(folder.path().join("a.txt")).unwrap(), b"new");
    }

    #[test]
    fn a_file_being_written_is_never_taken_for_one_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write(&path, |w| {
            w.write_all(b"whole")?;
            // As another run would: the search itself, whoever has searched here before.
            let (other, file) = Unfinished::begin(&folder.path().join("b.txt"))?;
            SEARCHED.lock().unwrap().clear();
            remove_abandoned(&other.path, &file);
            assert_eq!(names(folder.path()).len(), 2, "{:?}", names(folder.path()));
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_are_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink("real", &link).unwrap();
        write(&link, |w| w.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write(Path::new("/dev/null"), |w| w.write_all(b"gone")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
