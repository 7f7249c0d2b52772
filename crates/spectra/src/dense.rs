//! Dense symmetric eigenproblems: the small ones inside the solvers, whole spectra of small graphs,
//! and the exact route that everything else is measured against.

use crate::{Laplacian, SpectralError, SymmetricOperator};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatRef, Par};

/// All eigenvalues of a symmetric matrix, ascending, and orthonormal eigenvectors as columns.
///
/// Reads the lower triangle. Runs on one thread, so that results repeat bit for bit.
/// Cost: O(n³).
///
/// # Errors
/// [`SpectralError::NotFinite`] for a matrix with NaN or infinity, [`SpectralError::Dense`] if the
/// iteration does not come to an end.
///
/// # Panics
/// If `matrix` is not square.
pub fn symmetric_eigen(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), SpectralError> {
    let n = matrix.nrows();
    assert_eq!(n, matrix.ncols(), "matrix must be square");
    if n == 0 {
        return Ok((Vec::new(), Mat::new()));
    }
    if !matrix.is_all_finite() {
        return Err(SpectralError::NotFinite);
    }
    let mut values: Diag<f64> = Diag::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let scratch =
        self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Default::default());
    self_adjoint_evd(
        matrix,
        values.as_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map_err(|_| SpectralError::Dense { order: n })?;
    let values = values.column_vector().iter().copied().collect();
    Ok((values, vectors))
}

/// The whole spectrum of a Laplacian: values exactly 0 once per connected component, ascending.
pub(crate) fn laplacian_eigen(
    laplacian: &Laplacian<'_>,
) -> Result<(Vec<f64>, Mat<f64>), SpectralError> {
    let (mut values, vectors) = symmetric_eigen(laplacian.to_dense().as_ref())?;
    // The multiplicity of 0 is known exactly, the computed zeros only to rounding.
    let zeros = num_components(laplacian);
    values[..zeros].fill(0.0);
    Ok((values, vectors))
}

/// Connected components, by union–find. Cost: O(n + nnz) up to a logarithm.
pub(crate) fn num_components(laplacian: &Laplacian<'_>) -> usize {
    let n = laplacian.dim();
    let mut parent: Vec<usize> = (0..n).collect();
    let mut count = n;
    for u in 0..n {
        for &v in laplacian.row(u).0 {
            let (a, b) = (find(&mut parent, u), find(&mut parent, v as usize));
            if a != b {
                parent[a.max(b)] = a.min(b);
                count -= 1;
            }
        }
    }
    count
}

fn find(parent: &mut [usize], mut u: usize) -> usize {
    while parent[u] != u {
        parent[u] = parent[parent[u]];
        u = parent[u];
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LaplacianKind, testing};

    #[test]
    fn decomposition_rebuilds_the_matrix() {
        let graph = testing::random(40, 3.0, 1);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let matrix = laplacian.to_dense();
        let (values, vectors) = symmetric_eigen(matrix.as_ref()).unwrap();
        let scaled = Mat::from_fn(40, 40, |i, j| vectors[(i, j)] * values[j]);
        assert!((scaled * vectors.transpose() - &matrix).norm_max() < 1e-13);
        assert!(values.is_sorted());
    }

    #[test]
    fn zeros_are_exact_and_as_many_as_components() {
        let graph = testing::disjoint(&[testing::cycle(6), testing::path(1), testing::star(4)]);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let (values, _) = laplacian_eigen(&laplacian).unwrap();
        assert_eq!(values[..3], [0.0; 3]);
        assert!(values[3] > 0.1);
    }

    #[test]
    fn not_a_number_is_an_error() {
        let mut matrix = Mat::<f64>::identity(3, 3);
        matrix[(1, 1)] = f64::NAN;
        assert_eq!(
            symmetric_eigen(matrix.as_ref()).err(),
            Some(SpectralError::NotFinite)
        );
    }
}
