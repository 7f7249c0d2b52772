//! Objects in the [container](eigentrail::archive::container) that all files of eigentrail share, with Python's exceptions.

pub use eigentrail::archive::container::Kind;

use eigentrail::archive::container::{pack, unpack};
use pyo3::PyErr;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The object in its container.
pub fn packed(kind: Kind, object: &impl Serialize) -> Result<Vec<u8>, PyErr> {
    pack(kind, object).map_err(PyRuntimeError::new_err)
}

/// The object that was packed as `kind`.
///
/// # Errors
/// `ValueError` that says what is wrong with the bytes.
pub fn unpacked<T: DeserializeOwned>(kind: Kind, bytes: &[u8]) -> Result<T, PyErr> {
    unpack(kind, bytes).map_err(PyValueError::new_err)
}
