//! Reasons why there are no features.

use crate::parameter::ParameterError;
use crate::spectral::SpectralError;

/// Errors of this module.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FeatureError {
    /// The eigenpairs could not be computed.
    #[error("eigenvectors: {0}")]
    Spectral(#[from] SpectralError),
    /// A parameter outside its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Saved vectors are damaged.
    #[error("the saved state of the random walks is damaged: its parts do not belong together")]
    Saved,
    /// The vectors grew beyond all bounds.
    #[error("the skip-gram vectors diverged; lower deepwalk.learning_rate")]
    Diverged,
}
