//! Why the worker does not answer a request in full.

use crate::scene::SceneError;
use crate::solve::{PipelineError, Stage};

/// Why the worker does not answer a request in full.
pub(super) enum Failure {
    Cancelled,
    Said(String),
    /// The present scene stands whole, at this stage.
    Refused(Stage),
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        match error {
            SceneError::Cancelled => Self::Cancelled,
            other => Self::Said(other.to_string()),
        }
    }
}

impl From<PipelineError> for Failure {
    fn from(error: PipelineError) -> Self {
        match error {
            PipelineError::Cancelled => Self::Cancelled,
            other => Self::Said(other.to_string()),
        }
    }
}
