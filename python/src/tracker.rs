//! The growing eigensolver.

use crate::arrays::{self, Matrix, Vector};
use crate::calls::{interruptible, unlocked};
use crate::container::{Kind, packed, unpacked};
use crate::errors::raised;
use eigentrail::spectral::{
    self, GrowingEigensolver, LaplacianKind, Method, SpectralParams, SpectrumRefresh, SymmetricCsr,
    TrackParams, with_fixed_signs,
};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde::de::DeserializeOwned;
use sprs::CsMatI;

const KIND: Kind = Kind {
    letters: b"TRCK",
    version: 1,
};

/// The solver, and the size of its graph.
#[pyclass(module = "eigentrail._eigentrail")]
pub struct EigenTracker {
    solver: GrowingEigensolver,
    nodes: usize,
}

#[pymethods]
impl EigenTracker {
    #[new]
    fn new(
        k: i64,
        tol: f64,
        laplacian: &str,
        method: &str,
        certify: bool,
        threads: usize,
        seed: u64,
    ) -> PyResult<Self> {
        let params = SpectralParams {
            num_eigenpairs: pairs(k)?,
            tol,
            laplacian: kind(laplacian)?,
            method: named(method)?,
            threads,
            certify,
            ..SpectralParams::default()
        };
        params.validate().map_err(spectral_error)?;
        Ok(Self {
            solver: GrowingEigensolver::new(params, seed),
            nodes: 0,
        })
    }

    /// Follows the graph to its present size: the eigenvalues, and the facts of the refresh.
    fn update<'py>(
        &mut self,
        py: Python<'py>,
        offsets: PyReadonlyArray1<'py, i32>,
        columns: PyReadonlyArray1<'py, i32>,
        weights: PyReadonlyArray1<'py, f64>,
        nodes: usize,
    ) -> PyResult<(Vector<'py, f64>, Bound<'py, PyDict>)> {
        let entries = Entries::new(&offsets, &columns, &weights, nodes)?;
        if nodes < self.nodes {
            return Err(PyValueError::new_err(format!(
                "the graph has {nodes} nodes and had {} at the last update: a tracked graph only grows; \
                 take a new EigenTracker for another graph",
                self.nodes
            )));
        }
        let graph = unlocked(py, || entries.symmetric())??;
        // After an interruption the solver is as it was before. A copy has no scratch memory, which the one that works keeps.
        let before = self.solver.clone();
        let mut solver = std::mem::replace(&mut self.solver, before);
        let (solver, refresh) = interruptible(py, move || {
            let refresh = solver.refresh(&graph);
            (solver, refresh)
        })?;
        self.solver = solver;
        let refresh = refresh.map_err(spectral_error)?;
        self.nodes = nodes;
        let facts = facts(py, &refresh)?;
        Ok((arrays::vector(py, refresh.eigenvalues), facts))
    }

    /// Unit eigenvectors, n × k, each with its entry of largest magnitude positive.
    fn eigenvectors<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py, f64>> {
        match self.solver.eigenpairs() {
            Some(pairs) => arrays::matrix(py, with_fixed_signs(pairs.vectors.as_ref()).as_ref()),
            None => arrays::rows(py, Vec::new(), 0),
        }
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(
            py,
            &packed(KIND, &(&self.solver, self.nodes))?,
        ))
    }

    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        let (solver, nodes) = unpacked(KIND, bytes)?;
        Ok(Self { solver, nodes })
    }
}

/// Follows a whole graph from a few nodes to all of them: eigenvalues, eigenvectors, and the record as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the parameters of `eigentrail track`
pub fn track<'py>(
    py: Python<'py>,
    offsets: PyReadonlyArray1<'py, i32>,
    columns: PyReadonlyArray1<'py, i32>,
    weights: PyReadonlyArray1<'py, f64>,
    nodes: usize,
    k: i64,
    tol: f64,
    growth: f64,
    start_nodes: usize,
    laplacian: &str,
    method: &str,
    certify: bool,
    threads: usize,
    seed: u64,
) -> PyResult<(Vector<'py, f64>, Matrix<'py, f64>, String)> {
    let params = TrackParams {
        k: pairs(k)?,
        growth,
        start_nodes,
        tol,
        laplacian: kind(laplacian)?,
        method: named(method)?,
        threads,
        seed,
        certify,
    };
    let entries = Entries::new(&offsets, &columns, &weights, nodes)?;
    let graph = unlocked(py, || entries.symmetric())??;
    let tracked = interruptible(py, move || spectral::track(&graph, &params, |_| ()))?;
    let tracked = tracked.map_err(spectral_error)?;
    let record = serde_json::to_string(&tracked.statistics)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let vectors = with_fixed_signs(tracked.eigenpairs.vectors.as_ref());
    Ok((
        arrays::vector(py, tracked.eigenpairs.values),
        arrays::matrix(py, vectors.as_ref())?,
        record,
    ))
}

/// The arrays of a sparse matrix by rows, as they came.
struct Entries<'a> {
    offsets: &'a [i32],
    columns: &'a [i32],
    weights: &'a [f64],
    nodes: usize,
}

impl<'a> Entries<'a> {
    /// Checks that they are one matrix of `nodes` rows and columns.
    fn new(
        offsets: &'a PyReadonlyArray1<'_, i32>,
        columns: &'a PyReadonlyArray1<'_, i32>,
        weights: &'a PyReadonlyArray1<'_, f64>,
        nodes: usize,
    ) -> PyResult<Self> {
        let entries = Self {
            offsets: offsets.as_slice()?,
            columns: columns.as_slice()?,
            weights: weights.as_slice()?,
            nodes,
        };
        entries.check().map_err(PyValueError::new_err)?;
        Ok(entries)
    }

    fn check(&self) -> Result<(), String> {
        let (rows, entries) = (self.nodes, self.columns.len());
        if self.offsets.len() != rows + 1 {
            let found = self.offsets.len();
            return Err(format!(
                "indptr has {found} entries: a matrix of {rows} rows needs {}",
                rows + 1
            ));
        }
        if self.weights.len() != entries {
            let found = self.weights.len();
            return Err(format!(
                "data has {found} entries and indices {entries}: they must be as many"
            ));
        }
        if self.offsets[0] != 0
            || !self.offsets.is_sorted()
            || self.offsets[rows] as usize != entries
        {
            return Err(format!(
                "indptr must rise from 0 to {entries}, the number of entries"
            ));
        }
        let outside =
            |&&column: &&i32| usize::try_from(column).map_or(true, |column| column >= rows);
        match self.columns.iter().find(outside) {
            Some(column) => Err(format!(
                "indices holds {column}: columns are 0 to {}",
                rows as i64 - 1
            )),
            None => Ok(()),
        }
    }

    /// The matrix with its rows in order, entries given twice added up, and zeros left out.
    fn symmetric(&self) -> PyResult<SymmetricCsr> {
        let mut offsets = Vec::with_capacity(self.nodes + 1);
        let mut columns: Vec<u32> = Vec::with_capacity(self.columns.len());
        let mut weights: Vec<f64> = Vec::with_capacity(self.weights.len());
        offsets.push(0);
        for bounds in self.offsets.windows(2) {
            let range = bounds[0] as usize..bounds[1] as usize;
            let row = self.columns[range.clone()].iter().zip(&self.weights[range]);
            let row = row.filter(|(_, weight)| **weight != 0.0);
            let mut row: Vec<(u32, f64)> = row
                .map(|(&column, &weight)| (column as u32, weight))
                .collect();
            if !row.is_sorted_by_key(|(column, _)| *column) {
                row.sort_by_key(|(column, _)| *column);
            }
            let begin = columns.len();
            for (column, weight) in row {
                if columns.len() > begin && columns.last() == Some(&column) {
                    let last = weights.len() - 1;
                    weights[last] += weight;
                } else {
                    columns.push(column);
                    weights.push(weight);
                }
            }
            offsets.push(columns.len() as u32);
        }
        let matrix = CsMatI::new((self.nodes, self.nodes), offsets, columns, weights);
        SymmetricCsr::new(matrix).map_err(spectral_error)
    }
}

fn facts<'py>(py: Python<'py>, refresh: &SpectrumRefresh) -> PyResult<Bound<'py, PyDict>> {
    let convergence = &refresh.convergence;
    let facts = PyDict::new(py);
    facts.set_item("nodes", refresh.nodes)?;
    facts.set_item("edges", refresh.edges)?;
    facts.set_item("route", refresh.route.reason())?;
    facts.set_item("cold_start", refresh.cold_start)?;
    facts.set_item("applications", convergence.applications)?;
    facts.set_item("solves", convergence.solves)?;
    facts.set_item("max_relative_residual", convergence.max_relative_residual)?;
    facts.set_item(
        "converged",
        convergence.converged == refresh.eigenvalues.len(),
    )?;
    facts.set_item("certified", convergence.certified == Some(true))?;
    facts.set_item("tolerance_floor", convergence.tolerance_floor)?;
    Ok(facts)
}

fn pairs(k: i64) -> PyResult<usize> {
    match usize::try_from(k) {
        Ok(pairs @ 1..) => Ok(pairs),
        _ => Err(PyValueError::new_err(format!(
            "k = {k}: must be at least 1"
        ))),
    }
}

fn kind(laplacian: &str) -> PyResult<LaplacianKind> {
    match laplacian {
        "sym" => Ok(LaplacianKind::Normalized),
        "unnormalised" => Ok(LaplacianKind::Combinatorial),
        other => Err(PyValueError::new_err(format!(
            "laplacian = {other:?}: must be \"sym\" or \"unnormalised\""
        ))),
    }
}

fn named(method: &str) -> PyResult<Method> {
    fn read<T: DeserializeOwned>(name: &str) -> Option<T> {
        serde_json::from_value(name.into()).ok()
    }
    read(method).ok_or_else(|| {
        PyValueError::new_err(format!(
            "method = {method:?}: must be \"warm\", \"cold\" or \"full\""
        ))
    })
}

fn spectral_error(error: impl Into<spectral::SpectralError>) -> PyErr {
    raised(error.into())
}
