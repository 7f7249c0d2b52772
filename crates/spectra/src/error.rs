//! Errors of the input of an eigensolve.

/// A parameter out of its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name} = {value}: must be {rule}")]
pub struct ParameterError {
    /// Its name.
    pub name: &'static str,
    /// The value given.
    pub value: String,
    /// The values it may have.
    pub rule: &'static str,
}

/// Error of a graph or of the parameters of an eigensolve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectralError {
    /// An edge weight is zero, negative, infinite or not a number.
    #[error(
        "edge weight at row {row}, column {column} is {value}: weights must be finite and positive"
    )]
    Weight {
        /// Row of the entry, from 0.
        row: usize,
        /// Column of the entry, from 0.
        column: usize,
        /// The weight found there.
        value: f64,
    },
    /// The weights of a row add up to more than a double can hold.
    #[error("edge weights of row {row} add up to {value}: the sum must be finite")]
    Degree {
        /// The row, from 0.
        row: usize,
        /// Its sum.
        value: f64,
    },
    /// An adjacency must have one row and one column per node.
    #[error("matrix is {rows} × {columns}: an adjacency matrix must be square")]
    NotSquare {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
    },
    /// The matrix differs from its transpose.
    #[error(
        "matrix is not symmetric: entry at row {row}, column {column} has no equal at row {column}, column {row}"
    )]
    Asymmetric {
        /// Row of the entry without a partner, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
    },
    /// A solver that was written down is damaged: its parts do not belong together.
    #[error("the saved state of the eigensolver is damaged: its parts do not belong together")]
    Checkpoint,
    /// A parameter is out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// More pairs were asked for than the matrix has.
    #[error("k = {k} eigenpairs asked of a graph of {n} nodes: k can be at most {n}")]
    TooManyPairs {
        /// Pairs asked for.
        k: usize,
        /// Order of the matrix.
        n: usize,
    },
    /// The operator returned an infinite value or one that is not a number.
    #[error("the operator gave a value that is not finite")]
    NotFinite,
    /// A dense decomposition inside the solver did not come to an end.
    #[error("dense decomposition of order {order} did not converge")]
    Dense {
        /// Order of the small matrix.
        order: usize,
    },
}
