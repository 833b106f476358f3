use crate::memory::Shortage;
use crate::watch::Cancelled;
use std::path::{Path, PathBuf};

/// Why a scene cannot be read or its sidecar cannot be written. Each message is one sentence.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// No file of this name.
    #[error("{}: there is no such file", .0.display())]
    Missing(PathBuf),
    /// A folder stands where a file is wanted.
    #[error("{}: this is a folder; name a model file in it", .0.display())]
    Folder(PathBuf),
    /// The system refuses to read.
    #[error("{}: cannot be read ({reason})", path.display())]
    Unreadable {
        /// What was to be read.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// It would not fit into memory.
    #[error("{} cannot be read: {shortage}", path.display())]
    Memory {
        /// What was to be read.
        path: PathBuf,
        /// How much is missing.
        shortage: Shortage,
    },
    /// Nothing but white space.
    #[error("{0}: the file is empty")]
    Empty(String),
    /// No `f` line at all.
    #[error(
        "{0}: the file holds no faces (no line starts with 'f'), so there is nothing to light; is it an OBJ file?"
    )]
    NoFaces(String),
    /// Faces, but none that can be used.
    #[error("{file}: none of the {faces} faces has an area, so there is nothing to light")]
    NoArea {
        /// The model file.
        file: String,
        /// Faces in it.
        faces: usize,
    },
    /// A line that cannot be understood.
    #[error("{file}, line {line}: {message}")]
    Line {
        /// The file.
        file: String,
        /// Counted from one.
        line: usize,
        /// What is wrong and what to do.
        message: String,
    },
    /// Anything else about a file as a whole.
    #[error("{file}: {message}")]
    File {
        /// The file.
        file: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// No embedded scene of this name.
    #[error("there is no embedded scene '{name}'; there are {known}")]
    UnknownBuiltin {
        /// The name asked for.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The watch ended it.
    #[error("the reading was cancelled")]
    Cancelled,
    /// The sidecar cannot be written; what was there before is untouched.
    #[error("{}: cannot be written ({reason}); nothing was changed", path.display())]
    Unwritable {
        /// What was to be written.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
}

impl From<Cancelled> for SceneError {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl SceneError {
    pub(super) fn line(file: &str, line: usize, message: impl Into<String>) -> Self {
        Self::Line { file: file.to_owned(), line, message: message.into() }
    }

    pub(super) fn file(file: &str, message: impl Into<String>) -> Self {
        Self::File { file: file.to_owned(), message: message.into() }
    }

    pub(super) fn reading(path: &Path, error: &std::io::Error) -> Self {
        match error.kind() {
            std::io::ErrorKind::NotFound => Self::Missing(path.to_owned()),
            std::io::ErrorKind::IsADirectory => Self::Folder(path.to_owned()),
            _ => Self::Unreadable { path: path.to_owned(), reason: error.to_string() },
        }
    }
}
