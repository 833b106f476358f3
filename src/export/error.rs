use std::io;
use std::path::{Path, PathBuf};

/// Why a file was not written. The file that stood there before, if any, is untouched.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The system refused.
    #[error("cannot write {}: {}", path.display(), reason(source))]
    Write {
        /// The file asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A picture or mesh whose parts do not fit each other.
    #[error("cannot write {}: {what}", path.display())]
    Shape {
        /// The file asked for.
        path: PathBuf,
        /// Which parts, and how they differ.
        what: String,
    },
}

impl ExportError {
    pub(super) fn shape(path: &Path, what: impl Into<String>) -> Self {
        Self::Shape { path: path.to_owned(), what: what.into() }
    }
}

fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "its folder does not exist".into(),
        io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder".into(),
        io::ErrorKind::PermissionDenied => "you have no permission to write there".into(),
        io::ErrorKind::ReadOnlyFilesystem => "the file system is read-only".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        io::ErrorKind::IsADirectory => "a folder has that name".into(),
        _ => error.to_string(),
    }
}
