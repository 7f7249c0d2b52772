//! Rust's errors as Python's exceptions, with the same text.

use eigentrail::PipelineError;
use eigentrail::error::{Error, ErrorKind};
use eigentrail::spectral::SpectralError;
use pyo3::PyErr;
use pyo3::exceptions::{PyRuntimeError, PyValueError};

/// `ValueError` for what the caller can put right, else `RuntimeError`.
pub fn raised(error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let text = error.to_string();
    match is_about_input(&error) {
        true => PyValueError::new_err(text),
        false => PyRuntimeError::new_err(text),
    }
}

fn is_about_input(error: &Error) -> bool {
    error.kind() == ErrorKind::BadInput
        || matches!(
            error,
            Error::Pipeline(PipelineError::Reward { .. } | PipelineError::Action { .. })
                | Error::Spectral(SpectralError::NotSquare { .. } | SpectralError::Checkpoint)
        )
}
