use super::text;
use crate::daylight::{DaylightError, WeatherError};
use crate::export::{ExportError, PointsError};
use crate::mesh::MeshError;
use crate::outputs::RepairError;
use crate::scene::SceneError;
use crate::solve::PipelineError;
use std::process::ExitCode;

/// Why a command ends early.
#[derive(Debug)]
pub(super) enum Failure {
    /// What the user gave cannot be used: exit code 2.
    Input(anyhow::Error),
    /// The command failed at its work: exit code 1.
    Work(anyhow::Error),
    /// As `Work`, with everything said already.
    Told,
    /// The reader of standard output went away: not an error.
    Unread,
}

impl Failure {
    pub(super) fn input(message: impl Into<String>) -> Self {
        Self::Input(anyhow::Error::msg(message.into()))
    }

    pub(super) fn work(error: impl Into<anyhow::Error>) -> Self {
        Self::Work(error.into())
    }

    /// Says it on standard error, where there is something to say.
    pub(super) fn report(&self) -> ExitCode {
        match self {
            Self::Input(error) => {
                text::complain(&format!("{error:#}"));
                ExitCode::from(2)
            }
            Self::Work(error) => {
                text::complain(&format!("{error:#}"));
                ExitCode::FAILURE
            }
            Self::Told => ExitCode::FAILURE,
            Self::Unread => ExitCode::SUCCESS,
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Input(error.into())
    }
}

impl From<PointsError> for Failure {
    fn from(error: PointsError) -> Self {
        Self::Input(error.into())
    }
}

impl From<DaylightError> for Failure {
    fn from(error: DaylightError) -> Self {
        Self::Input(error.into())
    }
}

impl From<WeatherError> for Failure {
    fn from(error: WeatherError) -> Self {
        Self::Input(error.into())
    }
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Self {
        Self::Input(error.into())
    }
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        Self::Work(error.into())
    }
}

impl From<RepairError> for Failure {
    fn from(error: RepairError) -> Self {
        match error {
            RepairError::Scene(error) => error.into(),
            RepairError::Export(error) => error.into(),
            // The name was the user's choice.
            RepairError::Original(_) | RepairError::ForeignSidecar(_) | RepairError::ForeignImage(_) => {
                Self::Input(error.into())
            }
        }
    }
}

impl From<PipelineError> for Failure {
    fn from(error: PipelineError) -> Self {
        match error {
            PipelineError::Mesh(error) => error.into(),
            other => Self::Work(other.into()),
        }
    }
}
