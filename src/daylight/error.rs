//! What can be wrong with a place, a time, a sky or a weather file.

/// Why a place, a date or a sky cannot be, in one sentence without a full stop: what is wrong and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DaylightError(pub(super) String);

impl DaylightError {
    /// Of one sentence without a full stop.
    pub fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

/// Why a weather file cannot be used, in one sentence: the file, its line, what is wrong and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}: {message}", line.map_or(String::new(), |line| format!(", line {line}")))]
pub struct WeatherError {
    /// The name that the caller gave the file.
    pub file: String,
    /// The line, counted from one; none where the fault concerns the whole file.
    pub line: Option<usize>,
    /// What is wrong and what to do.
    pub message: String,
}

/// A fault before the name of the file is known.
#[derive(Debug)]
pub(super) struct Fault {
    line: Option<usize>,
    message: String,
}

impl Fault {
    pub(super) fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }

    pub(super) fn whole(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into() }
    }

    pub(super) fn in_file(self, file: &str) -> WeatherError {
        WeatherError { file: file.to_owned(), line: self.line, message: self.message }
    }
}
