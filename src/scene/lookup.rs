//! Where the files that a model names are looked for.

use super::text::lowered;
use crate::watch::{self, Cancelled};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// A file that has not changed for this long is taken as complete.
const REST: Duration = Duration::from_millis(100);
/// A file that is still growing after this many rests is refused.
const MOST_RESTS: usize = 300;

/// The files that belong to a model.
#[derive(Clone, Copy)]
pub(super) enum Files<'a> {
    /// Those beside an OBJ file in this folder; none any more once the reader has been `cancelled`.
    Folder { folder: &'a Path, cancelled: &'a (dyn Fn() -> bool + Sync) },
    /// One library in memory, whatever its name, and no images.
    Library(&'a str),
}

/// A file that was found.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
}

impl<'a> Files<'a> {
    /// Those beside an OBJ file in this folder, for somebody who reads them to the end.
    pub(super) fn beside(folder: &'a Path) -> Self {
        Self::Folder { folder, cancelled: &|| false }
    }

    /// A material library: as named, with `\` for `/`, by its last part; then so in any case.
    pub(super) fn library(&self, name: &str) -> io::Result<Found> {
        match self {
            Self::Folder { folder, .. } => {
                let path = locate(name, &[folder])?;
                Ok(Found { bytes: read_complete(&path)?, path })
            }
            Self::Library(text) => Ok(Found { path: PathBuf::from(name), bytes: text.as_bytes().to_vec() }),
        }
    }

    /// Any file that a model or its sidecar names, beside the model: as named, with `\` for `/`, by its last part; then so
    /// in any case.
    pub(super) fn companion(&self, name: &str) -> io::Result<Found> {
        match self {
            Self::Folder { .. } => self.library(name),
            Self::Library(_) => Err(io::ErrorKind::NotFound.into()),
        }
    }

    /// Where an image is that a library names: beside that library first, then beside the OBJ file.
    pub(super) fn image(&self, name: &str, library: &Path) -> io::Result<PathBuf> {
        match self {
            Self::Folder { cancelled, .. } if cancelled() => Err(io::ErrorKind::Interrupted.into()),
            Self::Folder { folder, .. } => locate(name, &[library.parent().unwrap_or(folder), folder]),
            Self::Library(_) => Err(io::ErrorKind::NotFound.into()),
        }
    }

    /// Does work that cannot be asked to end, as [`watch::apart`].
    pub(super) fn apart<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<Option<T>, Cancelled> {
        match self {
            Self::Folder { cancelled, .. } => watch::apart(cancelled, work),
            Self::Library(_) => watch::apart(&|| false, work),
        }
    }

    /// The library beside the OBJ file that has its name, in any case.
    pub(super) fn namesake(&self, stem: &str) -> Option<Found> {
        let Self::Folder { folder, .. } = self else { return None };
        let path = locate(&format!("{stem}.mtl"), &[folder]).ok()?;
        let bytes = read_complete(&path).ok()?;
        Some(Found { path, bytes })
    }
}

/// Looks for a file in folders, the earlier ones first; where there is none, by the name that an address on the web with
/// `%20` and the like stands for.
fn locate(name: &str, folders: &[&Path]) -> io::Result<PathBuf> {
    let decoded =
        || percent_encoding::percent_decode_str(name).decode_utf8().ok().filter(|plain| plain != name);
    locate_as_named(name, folders).or_else(|error| match decoded() {
        Some(plain) => locate_as_named(&plain, folders).map_err(|_| error),
        None => Err(error),
    })
}

fn locate_as_named(name: &str, folders: &[&Path]) -> io::Result<PathBuf> {
    let slashed = name.replace('\\', "/");
    let last = slashed.rsplit('/').next().unwrap_or_default();
    for form in [name, slashed.as_str(), last].into_iter().filter(|form| !form.is_empty()) {
        for path in folders.iter().map(|folder| folder.join(form)) {
            // Devices and pipes count as found, and say what they are when they are read.
            if std::fs::metadata(&path).is_ok_and(|found| !found.is_dir()) {
                return Ok(path);
            }
        }
    }
    for form in [slashed.as_str(), last] {
        if let Some(path) = folders.iter().find_map(|folder| in_any_case(folder, form)) {
            return Ok(path);
        }
    }
    Err(io::ErrorKind::NotFound.into())
}

/// A file below a folder by a name whose letters may be capitals or not, and whose bytes on disk may be in
/// another encoding.
fn in_any_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut path = folder.to_owned();
    for part in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
        let next = path.join(part);
        if part == ".." || next.exists() {
            path = next;
            continue;
        }
        let entries = std::fs::read_dir(if path.as_os_str().is_empty() { Path::new(".") } else { &path });
        let wanted = lowered(part);
        let alike = |entry: &std::ffi::OsString| {
            lowered(&crate::encoding::decode(entry.as_encoded_bytes())) == wanted
        };
        // The first by name, for the same answer on every system.
        path.push(entries.ok()?.flatten().map(|entry| entry.file_name()).filter(alike).min()?);
    }
    path.is_file().then_some(path)
}

/// Reads a plain file; devices and pipes could go on for ever.
pub(super) fn read_plain(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a plain file"));
    }
    std::fs::read(path)
}

/// Reads a plain file that another program may still be writing: waits until it has rested for a moment.
pub(super) fn read_complete(path: &Path) -> io::Result<Vec<u8>> {
    let stamp = || {
        let metadata = std::fs::metadata(path)?;
        Ok((metadata.len(), metadata.modified().ok()))
    };
    at_rest(stamp, || std::thread::sleep(REST), || read_plain(path))
}

/// Size and time of the last change.
type Stamp = (u64, Option<SystemTime>);

/// Reads what stays the same for a `rest` before, if it changed just now, and while it is read.
fn at_rest<T>(
    mut stamp: impl FnMut() -> io::Result<Stamp>,
    mut rest: impl FnMut(),
    mut read: impl FnMut() -> io::Result<T>,
) -> io::Result<T> {
    for _ in 0..MOST_RESTS {
        let before = stamp()?;
        let age = before.1.and_then(|changed| changed.elapsed().ok());
        if age.is_some_and(|age| age < REST) {
            rest();
            if stamp()? != before {
                continue;
            }
        }
        let content = read()?;
        if stamp()? == before {
            return Ok(content);
        }
    }
    Err(io::Error::other("it is still being written; try again when it is complete"))
}

/// What is wrong with a file that a model names, in a few words.
pub(super) fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_are_looked_for_in_a_fixed_order() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir_all(at("Lib/Tex")).unwrap();
        for name in ["a.png", "Lib/a.png", "Lib/Tex/b.png", "c.png", "HAUS.MTL", "oak floor.png", "50%25.png"]
        {
            fs::write(at(name), name).unwrap();
        }
        let files = Files::beside(folder.path());
        let library = at("Lib/room.mtl");
        for (name, expected) in [
            ("a.png", Some("Lib/a.png")),
            ("Tex\\b.png", Some("Lib/Tex/b.png")),
            ("tex/B.PNG", Some("Lib/Tex/b.png")),
            ("C:\\work\\textures\\c.png", Some("c.png")),
            ("../c.png", Some("Lib/../c.png")),
            ("oak%20floor.png", Some("oak floor.png")),
            ("tex%2Fb.png", Some("Lib/Tex/b.png")),
            ("50%25.png", Some("50%25.png")),
            ("%ff.png", None),
            ("d.png", None),
            ("", None),
            ("Tex", None),
        ] {
            assert_eq!(files.image(name, &library).ok(), expected.map(at), "{name}");
        }
        assert_eq!(files.namesake("Haus").map(|found| found.path), Some(at("HAUS.MTL")));
        assert!(files.namesake("house").is_none());
    }

    #[test]
    fn a_file_that_is_being_written_is_read_when_it_is_complete() {
        let size = std::cell::Cell::new(0);
        let grow = |most: u64| size.set((size.get() + 1).min(most));
        let stamp = || Ok((size.get(), Some(SystemTime::now())));
        // Times of a file at rest do not move on.
        let now = SystemTime::now();
        let resting = || Ok((size.get(), Some(now)));
        assert_eq!(at_rest(resting, || grow(7), || Ok(size.get())).unwrap(), 7);
        // It grows while it is read.
        size.set(0);
        let old = Some(SystemTime::UNIX_EPOCH);
        let read = || {
            let seen = size.get();
            grow(3);
            Ok(seen)
        };
        assert_eq!(at_rest(|| Ok((size.get(), old)), || (), read).unwrap(), 3);
        let error = at_rest(stamp, || grow(u64::MAX), || Ok(())).unwrap_err().to_string();
        assert!(error.contains("still being written"), "{error}");
    }
}
