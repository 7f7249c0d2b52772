//! The low eigenvectors of the Laplacian of the visited states, kept up to date while the graph grows.
//!
//! The eigensolver is a crate of its own, [`eigentrail_spectra`], whose names stand here too. What makes features of
//! its eigenvectors is [`ProtoValueFunctions`].

mod proto_value;

pub(crate) use eigentrail_spectra::plain;
pub use eigentrail_spectra::{
    Convergence, Eigenpairs, GrowingEigensolver, LAMBDA_FLOOR, Laplacian, LaplacianKind, Method,
    Route, SpectralError, SpectralParams, SpectrumRefresh, SymmetricCsr, SymmetricOperator,
    TrackParams, TrackStatistics, TrackUpdate, TrackedSpectrum, procrustes, smallest_eigenpairs,
    symmetric_eigen, track, with_fixed_signs,
};
pub use proto_value::ProtoValueFunctions;

use crate::parameter::ParameterError;

impl From<eigentrail_spectra::ParameterError> for ParameterError {
    fn from(error: eigentrail_spectra::ParameterError) -> Self {
        ParameterError {
            section: "spectral",
            key: error.name,
            value: error.value,
            rule: error.rule.into(),
        }
    }
}
