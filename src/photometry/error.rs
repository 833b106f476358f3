//! What can be wrong with a photometric file.

/// Why a photometric file cannot be used, in one sentence: the file, its line, what is wrong and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}", line.map_or(String::new(), |line| format!(", line {line}")))]
pub struct ReadError {
    /// The name that the caller gave the file.
    pub file: String,
    /// The line, counted from one; none where the fault concerns the whole file.
    pub line: Option<usize>,
    /// What is wrong and what to do.
    pub message: String,
}

/// Why a table of intensities is no distribution, in one sentence without a full stop.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct InvalidDistribution(pub(super) String);

/// A fault before the name of the file is known.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) line: Option<usize>,
    pub(super) message: String,
}

impl Fault {
    pub(super) fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }

    pub(super) fn whole(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into() }
    }

    pub(super) fn in_file(self, file: &str) -> ReadError {
        ReadError { file: file.to_owned(), line: self.line, message: self.message }
    }
}

impl From<InvalidDistribution> for Fault {
    fn from(invalid: InvalidDistribution) -> Self {
        Self::whole(invalid.0)
    }
}
