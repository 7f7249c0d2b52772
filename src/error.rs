//! Everything that can go wrong, and whose fault it is.

#[cfg(feature = "runner")]
use crate::archive::ArchiveError;
use crate::engine::PipelineError;
#[cfg(feature = "cli")]
use crate::export::ExportError;
#[cfg(feature = "matrix-market")]
use crate::graph::MatrixMarketError;
use crate::parameter::ParameterError;
#[cfg(feature = "runner")]
use crate::runner::RunnerError;
#[cfg(feature = "runner")]
use crate::scenario::ScenarioError;
use crate::shaping::ShapingError;
use crate::spectral::SpectralError;

/// An error of any part of the library.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A scenario was not accepted.
    #[cfg(feature = "runner")]
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A graph file was not accepted.
    #[cfg(feature = "matrix-market")]
    #[error(transparent)]
    MatrixMarket(#[from] MatrixMarketError),
    /// A file or folder of a run could not be used.
    #[cfg(feature = "runner")]
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// What was asked of the runner cannot be.
    #[cfg(feature = "runner")]
    #[error(transparent)]
    Runner(RunnerError),
    /// A run could not be exported.
    #[cfg(feature = "cli")]
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
#[cfg(feature = "runner")]
impl From<RunnerError> for Error {
    fn from(error: RunnerError) -> Self {
        match error {
            RunnerError::Parameter(error) => error.into(),
            RunnerError::Archive(error) => error.into(),
            RunnerError::Scenario(error) => error.into(),
            RunnerError::Pipeline(error) => error.into(),
            RunnerError::Spectral(error) => error.into(),
            RunnerError::Shaping(error) => error.into(),
            RunnerError::UnknownArms(_)
            | RunnerError::Grid(_)
            | RunnerError::StrangeShard { .. }
            | RunnerError::TooMuchMemory { .. } => Error::Runner(error),
        }
    }
}

impl Error {
    /// Whose fault it is.
    pub fn kind(&self) -> ErrorKind {
        let bad_input = match self {
            Error::Parameter(_) => true,
            #[cfg(feature = "runner")]
            Error::Scenario(_) | Error::Runner(_) => true,
            #[cfg(feature = "matrix-market")]
            Error::MatrixMarket(_) => true,
            #[cfg(feature = "runner")]
            Error::Archive(error) => error.is_bad_input(),
            #[cfg(feature = "cli")]
            Error::Export(error) => error.is_bad_input(),
            Error::Spectral(error) => is_about_the_graph(error),
            Error::Shaping(error) => matches!(
                error,
                ShapingError::NoGoal
                    | ShapingError::GoalRange { .. }
                    | ShapingError::KindNeedsWorld { .. }
                    | ShapingError::Parameter(_)
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
            | SpectralError::Parameter(_)
            | SpectralError::TooManyPairs { .. }
    )
}
