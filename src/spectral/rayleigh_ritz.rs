//! The Rayleigh–Ritz step: the best approximate eigenpairs that a subspace holds.
//!
//! For a basis X (n × m, not orthonormal) with G = XᵀX and H = XᵀLX solve H c = θ G c; the Ritz
//! vectors are X c (Parlett, *The Symmetric Eigenvalue Problem*, chapter 11). G is scaled to unit
//! diagonal and diagonalised, directions that it holds only to rounding are dropped.

use super::SpectralError;
use super::block::RowBlock;
use super::dense::symmetric_eigen;
use super::simd;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// Eigenvalues of the scaled Gram matrix below this are noise.
const RANK_TOLERANCE: f64 = 1e-13;

/// Coefficients of Ritz vectors in a basis.
#[derive(Debug)]
pub(super) struct Ritz {
    /// θ ascending, one per direction kept.
    pub(super) values: Vec<f64>,
    /// m × rank.
    pub(super) coefficients: Mat<f64>,
    /// Smallest eigenvalue kept of the scaled Gram matrix; the Ritz vectors are orthonormal to
    /// about machine precision ÷ this.
    pub(super) independence: f64,
}

/// Solves H c = θ G c.
pub(super) fn ritz(gram: &Mat<f64>, projected: &Mat<f64>) -> Result<Ritz, SpectralError> {
    let (whitening, independence) = whitening(gram)?;
    let symmetric = Mat::from_fn(gram.nrows(), gram.nrows(), |i, j| {
        0.5 * (projected[(i, j)] + projected[(j, i)])
    });
    let small = whitening.transpose() * &symmetric * &whitening;
    let (values, vectors) = symmetric_eigen(small.as_ref())?;
    Ok(Ritz {
        values,
        coefficients: whitening * vectors,
        independence,
    })
}

/// W with Wᵀ G W = I, m × rank, and the smallest eigenvalue kept.
fn whitening(gram: &Mat<f64>) -> Result<(Mat<f64>, f64), SpectralError> {
    let m = gram.nrows();
    let scale: Vec<f64> = (0..m)
        .map(|i| {
            let norm = gram[(i, i)].sqrt();
            if norm > 0.0 { norm.recip() } else { 0.0 }
        })
        .collect();
    let scaled = Mat::from_fn(m, m, |i, j| gram[(i, j)] * scale[i] * scale[j]);
    let (values, vectors) = symmetric_eigen(scaled.as_ref())?;
    let dropped = values.partition_point(|&s| s < RANK_TOLERANCE);
    let whitening = Mat::from_fn(m, m - dropped, |i, j| {
        scale[i] * vectors[(i, dropped + j)] / values[dropped + j].sqrt()
    });
    Ok((whitening, values.get(dropped).copied().unwrap_or(1.0)))
}

/// XᵀY, summed over stretches of rows in fixed order.
pub(super) fn inner_products(x: &RowBlock, y: &RowBlock, threads: usize) -> Mat<f64> {
    let width = x.width();
    let partial = simd::map_stretches(x.rows(), threads, |rows| {
        let range = rows.start * width..rows.end * width;
        let x = MatRef::from_column_major_slice(&x.as_slice()[range.clone()], width, rows.len());
        let y = MatRef::from_row_major_slice(&y.as_slice()[range], rows.len(), width);
        let mut product = Mat::zeros(width, width);
        matmul(product.as_mut(), Accum::Replace, x, y, 1.0, Par::Seq);
        product
    });
    let mut sum = Mat::zeros(width, width);
    for part in partial {
        sum += part;
    }
    sum
}

/// X ← X C, with zero columns where C has fewer columns than X.
pub(super) fn rotate(x: &mut RowBlock, coefficients: &Mat<f64>, threads: usize) {
    let width = x.width();
    let mut square = Mat::zeros(width, width);
    square
        .subcols_mut(0, coefficients.ncols())
        .copy_from(coefficients);
    simd::for_each_stretch_mut(x.as_mut_slice(), width, threads, |rows, x| {
        let old = x.to_vec();
        let old = MatRef::from_column_major_slice(&old, width, rows.len());
        let new = faer::MatMut::from_column_major_slice_mut(x, width, rows.len());
        matmul(new, Accum::Replace, square.transpose(), old, 1.0, Par::Seq);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generalised_problem_is_solved_and_dependent_columns_dropped() {
        // Three columns spanning a plane of R⁴; L = diag(1, 2, 3, 4).
        let basis = Mat::from_fn(4, 3, |i, j| match (i, j) {
            (0, 0) | (1, 1) => 1e-6,
            (0, 2) | (1, 2) => 1e3,
            _ => 0.0,
        });
        let l = Mat::from_fn(4, 4, |i, j| if i == j { i as f64 + 1.0 } else { 0.0 });
        let gram = basis.transpose() * &basis;
        let projected = basis.transpose() * &l * &basis;
        let ritz = ritz(&gram, &projected).unwrap();
        assert_eq!(ritz.coefficients.ncols(), 2);
        assert!((ritz.values[0] - 1.0).abs() < 1e-12 && (ritz.values[1] - 2.0).abs() < 1e-12);
        let vectors = &basis * &ritz.coefficients;
        let error = vectors.transpose() * &vectors - Mat::<f64>::identity(2, 2);
        assert!(error.norm_max() < 1e-12);
    }

    #[test]
    fn products_and_rotations_of_blocks_equal_those_of_matrices() {
        let mut x = RowBlock::zeros(5000, 8);
        let mut y = RowBlock::zeros(5000, 8);
        for (i, (a, b)) in x
            .as_mut_slice()
            .iter_mut()
            .zip(y.as_mut_slice())
            .enumerate()
        {
            (*a, *b) = ((i as f64).sin(), (i as f64 * 0.3).cos());
        }
        let expected = x.as_mat().transpose() * y.as_mat();
        for threads in [1, 4] {
            assert!((inner_products(&x, &y, threads) - &expected).norm_max() < 1e-9);
        }
        let c = Mat::from_fn(8, 5, |i, j| (i + 2 * j) as f64);
        let expected = x.as_mat() * &c;
        rotate(&mut x, &c, 1);
        assert!((x.as_mat().subcols(0, 5) - expected).norm_max() < 1e-10);
        assert_eq!(x.as_mat().subcols(5, 3).norm_max(), 0.0);
    }
}
