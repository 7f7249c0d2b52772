//! The k lowest eigenpairs of a graph's Laplacian, and how they are kept up to date. (interface sketch)

use crate::graph::Csr;
use faer::{Mat, MatMut, MatRef};

/// A symmetric linear operator on blocks of vectors.
pub trait SymmetricOperator {
    /// Number of rows and columns.
    fn dim(&self) -> usize;
    /// y ← A x, both dim × b, column-major.
    fn apply(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>);
}

/// Which Laplacian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LaplacianKind {
    /// L_sym = I − D^-1/2 A D^-1/2; the row of an isolated node is 0.
    #[default]
    Normalized,
    /// L = D − A.
    Combinatorial,
}

/// How a refresh finds the pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// From the previous vectors, extended to the new nodes.
    #[default]
    Warm,
    /// From random vectors every time.
    Cold,
    /// Dense, all n pairs, k kept.
    Full,
}

/// The k lowest eigenpairs, values ascending.
#[derive(Clone, Debug)]
pub struct Eigenpairs {
    pub values: Vec<f64>,
    /// n × k, orthonormal columns.
    pub vectors: Mat<f64>,
    pub convergence: Convergence,
}

/// What an eigensolve cost and how well it did. Not converging is a result, not an error.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Convergence {
    /// Leading pairs with ‖Lv − λv‖ ≤ tol · max(λ_k, floor).
    pub converged: usize,
    pub residual_norms: Vec<f64>,
    /// max residual norm ÷ max(λ_k, floor).
    pub max_relative_residual: f64,
    pub restarts: usize,
    /// Columns multiplied by L.
    pub applications: usize,
    /// Columns solved with the factor of L + σI.
    pub solves: usize,
    /// λ_k and λ_{k+1} belong to one cluster: the k-space is ill-posed at its edge.
    pub cluster_cut: bool,
}

#[derive(Clone, Debug)]
pub struct SpectralParams {
    pub num_eigenpairs: usize,
    pub tol: f64,
    pub laplacian: LaplacianKind,
    pub method: Method,
}

/// What a refresh did.
#[derive(Clone, Debug)]
pub struct SpectrumRefresh {
    pub nodes: usize,
    pub edges: usize,
    pub cold_start: bool,
    pub eigenvalues: Vec<f64>,
    pub convergence: Convergence,
}

#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SpectralError {
    #[error(
        "edge weight at row {row}, column {column} is {value}: weights must be finite and positive"
    )]
    Weight {
        row: usize,
        column: usize,
        value: f64,
    },
}

/// The features of a growing graph: lowest eigenvectors, aligned from one refresh to the next.
#[derive(Clone, Debug)]
pub struct ProtoValueFunctions {}

#[allow(unused_variables)]
impl ProtoValueFunctions {
    pub fn new(params: SpectralParams, seed: u64) -> Self {
        todo!()
    }
    /// Brings the pairs up to date with a graph that has grown since the last call (rows only appended).
    /// Keeps min(k, n) pairs. On not converging keeps the best found and says so.
    pub fn refresh(&mut self, adjacency: &Csr) -> Result<SpectrumRefresh, SpectralError> {
        todo!()
    }
    /// The current pairs, aligned to the previous basis (so NOT in eigenvalue order column by column: see `values` of SpectrumRefresh),
    /// scaled by √n: n × k. None before the first refresh.
    pub fn features(&self) -> Option<MatRef<'_, f64>> {
        todo!()
    }
    /// Sorted true eigenpairs (before alignment).
    pub fn eigenpairs(&self) -> Option<&Eigenpairs> {
        todo!()
    }
}
