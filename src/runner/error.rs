//! Errors around a run.

use crate::archive::ArchiveError;
use crate::engine::PipelineError;
use crate::parameter::ParameterError;
use crate::scenario::{Choices, GridError, ScenarioError};
use crate::shaping::ShapingError;
use crate::spectral::SpectralError;

/// Reason why a run or a comparison did not begin, or did not end.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunnerError {
    /// Arms that are neither built in nor defined by the scenario: what was asked for, and the arms there are.
    #[error("{}", unknown_arms(.0))]
    UnknownArms(Vec<(String, Choices)>),
    /// A grid that is none.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A shard that was computed elsewhere is not one of this sweep.
    #[error(
        "a shard of another sweep, or from another version of the program: it has no point {hash}"
    )]
    StrangeShard {
        /// The hash of its trials.
        hash: String,
    },
    /// It cannot fit.
    #[error(
        "{what} would take about {} of memory, and this machine has {}: {advice}",
        gigabytes(*needed),
        gigabytes(*there_is)
    )]
    TooMuchMemory {
        /// What is asked for.
        what: String,
        /// How many bytes it would take, roughly.
        needed: u64,
        /// How many bytes there are.
        there_is: u64,
        /// What to ask for instead.
        advice: &'static str,
    },
    /// A file or folder cannot be used.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A scenario, or an arm laid over it, was not accepted.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The run could not go on.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// Eigenpairs could not be computed.
    #[error(transparent)]
    Spectral(#[from] SpectralError),
    /// A potential could not be computed.
    #[error(transparent)]
    Shaping(#[from] ShapingError),
}

fn unknown_arms(arms: &[(String, Choices)]) -> String {
    let lines = arms
        .iter()
        .map(|(name, right)| format!("--arms: there is no arm `{name}`{right}"));
    lines.collect::<Vec<_>>().join("\n")
}

/// To a tenth.
fn gigabytes(bytes: u64) -> String {
    format!("{:.1} GB", bytes as f64 / 1e9)
}
