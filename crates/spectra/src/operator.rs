//! The one thing an eigensolver needs to know of a matrix: y = A x, for a block of vectors.

use faer::{MatMut, MatRef};

/// A symmetric linear operator on blocks of vectors.
///
/// Symmetry is the implementor's promise: the solvers use it and do not check it.
pub trait SymmetricOperator {
    /// Number of rows and columns.
    fn dim(&self) -> usize;

    /// y ← A x. Both are dim × b, for any b; strides are the caller's.
    ///
    /// # Panics
    /// May panic if the shapes of `x` and `y` differ or have other than `dim` rows.
    fn apply(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>);
}

/// A dense symmetric matrix is the plainest operator. Cost of a product: n² per column.
impl SymmetricOperator for MatRef<'_, f64> {
    fn dim(&self) -> usize {
        self.nrows()
    }

    fn apply(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
        let sequential = faer::Par::Seq;
        faer::linalg::matmul::matmul(y, faer::Accum::Replace, *self, x, 1.0, sequential);
    }
}
