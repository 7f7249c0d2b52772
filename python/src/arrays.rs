//! Arrays for Python: snapshots that nobody can write to.

use eigentrail::faer::MatRef;
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// Array of one dimension.
pub type Vector<'py, T> = Bound<'py, PyArray1<T>>;

/// Array of two dimensions, by rows.
pub type Matrix<'py, T> = Bound<'py, PyArray2<T>>;

/// The numbers as a read-only array, without a copy.
pub fn vector<T: Element>(py: Python<'_>, values: Vec<T>) -> Vector<'_, T> {
    let array = PyArray1::from_vec(py, values);
    drop(array.readwrite().make_nonwriteable());
    array
}

/// Rows one after the other as a read-only matrix, without a copy.
pub fn rows<T: Element>(py: Python<'_>, values: Vec<T>, columns: usize) -> PyResult<Matrix<'_, T>> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    let array = PyArray1::from_vec(py, values).reshape([rows, columns])?;
    drop(array.readwrite().make_nonwriteable());
    Ok(array)
}

/// A read-only copy of the matrix, by rows.
pub fn matrix<'py>(py: Python<'py>, matrix: MatRef<'_, f64>) -> PyResult<Matrix<'py, f64>> {
    let (height, width) = (matrix.nrows(), matrix.ncols());
    let mut values = Vec::with_capacity(height * width);
    for i in 0..height {
        values.extend((0..width).map(|j| matrix[(i, j)]));
    }
    let array = PyArray1::from_vec(py, values).reshape([height, width])?;
    drop(array.readwrite().make_nonwriteable());
    Ok(array)
}
