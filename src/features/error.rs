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
