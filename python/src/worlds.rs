//! The engines of a wrapper, by layout, in one container.

use crate::container::{Kind, packed, unpacked};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};

const KIND: Kind = Kind {
    letters: b"WRLD",
    version: 1,
};

/// Name of a layout, if there is one, and the bytes of its engine.
type World = (Option<Vec<u8>>, Vec<u8>);

/// What a wrapper writes down: how it was made, as JSON, and its engines, the latest last.
#[derive(Serialize, Deserialize)]
struct Worlds {
    settings: String,
    engines: Vec<World>,
}

/// A container with all of it.
#[pyfunction]
pub fn pack_worlds<'py>(
    py: Python<'py>,
    settings: String,
    engines: Vec<World>,
) -> PyResult<Bound<'py, PyBytes>> {
    let bytes = packed(KIND, &Worlds { settings, engines })?;
    Ok(PyBytes::new(py, &bytes))
}

/// What is in a container: settings, and layouts with their engines.
#[pyfunction]
#[allow(clippy::type_complexity)] // what a wrapper takes up again
pub fn unpack_worlds<'py>(
    py: Python<'py>,
    bytes: &[u8],
) -> PyResult<(
    String,
    Vec<(Option<Bound<'py, PyBytes>>, Bound<'py, PyBytes>)>,
)> {
    let Worlds { settings, engines } = unpacked(KIND, bytes)?;
    let engines = engines.iter().map(|(layout, engine)| {
        let layout = layout.as_ref().map(|layout| PyBytes::new(py, layout));
        (layout, PyBytes::new(py, engine))
    });
    Ok((settings, engines.collect()))
}
