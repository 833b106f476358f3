//! Outputs one after the other: one that fails does not take the others with it.

use super::failure::Failure;
use std::path::Path;

/// What was written, and whether anything was not.
#[derive(Default)]
pub(super) struct Written {
    /// Each with a line that says so.
    done: Vec<String>,
    failed: bool,
}

impl Written {
    /// Takes note of one output; a failure is told at once.
    pub(super) fn note(&mut self, path: &Path, result: Result<(), impl Into<Failure>>) {
        if self.check(result).is_some() {
            self.done.push(path.display().to_string());
        }
    }

    /// The value of what is no file by itself; a failure is told at once.
    pub(super) fn check<T>(&mut self, result: Result<T, impl Into<Failure>>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(failure) => {
                failure.into().report();
                self.failed = true;
                None
            }
        }
    }

    /// Files written so far.
    pub(super) fn files(&self) -> &[String] {
        &self.done
    }

    /// The end of the command, all being said.
    ///
    /// # Errors
    /// [`Failure::Told`] where an output failed.
    pub(super) fn end(&self) -> Result<(), Failure> {
        if self.failed { Err(Failure::Told) } else { Ok(()) }
    }
}
