//! Everything that can go wrong, and whose fault it is.

use crate::archive::ArchiveError;
use crate::engine::PipelineError;
use crate::export::ExportError;
use crate::graph::MatrixMarketError;
use crate::runner::RunnerError;
use crate::scenario::ScenarioError;
use crate::shaping::ShapingError;
use crate::spectral::SpectralError;

/// An error of any part of the library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scenario was not accepted.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A graph file was not accepted.
    #[error(transparent)]
    MatrixMarket(#[from] MatrixMarketError),
    /// A file or folder of a run could not be used.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// What was asked of the runner cannot be.
    #[error(transparent)]
    Runner(RunnerError),
    /// A run could not be exported.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A run could not go on.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// Eigenpairs could not be computed.
    #[error(transparent)]
    Spectral(#[from] SpectralError),
    /// A potential could not be computed.
    #[error(transparent)]
    Shaping(#[from] ShapingError),
}

/// The library's result.
pub type Result<T> = std::result::Result<T, Error>;

/// Whose fault an error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The caller asked for something that cannot be: another input will do.
    BadInput,
    /// Something failed on the way.
    Failed,
}

/// An error of another part that only passed through the runner is that part's own.
impl From<RunnerError> for Error {
    fn from(error: RunnerError) -> Self {
        match error {
            RunnerError::Archive(error) => error.into(),
            RunnerError::Scenario(error) => error.into(),
            RunnerError::Pipeline(error) => error.into(),
            RunnerError::Spectral(error) => error.into(),
            RunnerError::Shaping(error) => error.into(),
            RunnerError::UnknownArm { .. } | RunnerError::TooMuchMemory { .. } => {
                Error::Runner(error)
            }
        }
    }
}

impl Error {
    /// Whose fault it is.
    pub fn kind(&self) -> ErrorKind {
        let bad_input = match self {
            Error::Scenario(_) | Error::MatrixMarket(_) | Error::Runner(_) => true,
            Error::Archive(error) => error.is_bad_input(),
            Error::Export(error) => error.is_bad_input(),
            Error::Spectral(error) => is_about_the_graph(error),
            Error::Shaping(error) => matches!(
                error,
                ShapingError::NoGoal
                    | ShapingError::GoalRange { .. }
                    | ShapingError::KindNeedsWorld { .. }
                    | ShapingError::Parameter { .. }
            ),
            Error::Pipeline(_) => false,
        };
        if bad_input {
            ErrorKind::BadInput
        } else {
            ErrorKind::Failed
        }
    }
}

fn is_about_the_graph(error: &SpectralError) -> bool {
    matches!(
        error,
        SpectralError::Weight { .. }
            | SpectralError::Degree { .. }
            | SpectralError::Asymmetric { .. }
            | SpectralError::Parameter { .. }
            | SpectralError::TooManyPairs { .. }
    )
}
