//! Why there are no features.

use crate::brief::brief;
use crate::spectral::SpectralError;

/// Errors of this module.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FeatureError {
    /// The eigenpairs could not be computed.
    #[error("eigenvectors: {0}")]
    Spectral(#[from] SpectralError),
    /// An edge weight that is no probability of being walked.
    #[error(
        "edge weight at row {row}, column {column} is {value}: random walks need finite and positive weights"
    )]
    Weight {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// The weight it has.
        value: f64,
    },
    /// A parameter outside its range.
    #[error("deepwalk.{key} is {}: it must be {rule}", brief(*.value))]
    Parameter {
        /// Key inside `[deepwalk]`.
        key: &'static str,
        /// The value given.
        value: f64,
        /// What it must satisfy.
        rule: &'static str,
    },
    /// The vectors grew beyond all bounds.
    #[error("the skip-gram vectors diverged; lower deepwalk.learning_rate")]
    Diverged,
}
