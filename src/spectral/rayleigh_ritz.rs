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
use faer::{Accum, Mat, MatMut, MatRef, Par};
use std::ops::Range;

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

/// XᵀX, summed over stretches of rows in fixed order.
pub(super) fn gram(x: &RowBlock, threads: usize) -> Mat<f64> {
    summed(x, threads, |rows| stretch_product(x, x, rows))
}

/// XᵀX and XᵀY side by side (width × 2 width), while a stretch of X is in cache.
pub(super) fn gram_and_product(x: &RowBlock, y: &RowBlock, threads: usize) -> (Mat<f64>, Mat<f64>) {
    let width = x.width();
    let both = summed(x, threads, |rows| {
        let mut both = Mat::zeros(width, 2 * width);
        both.subcols_mut(0, width)
            .copy_from(stretch_product(x, x, rows.clone()));
        both.subcols_mut(width, width)
            .copy_from(stretch_product(x, y, rows));
        both
    });
    let part = |first| both.subcols(first, width).to_owned();
    (part(0), part(width))
}

fn summed(
    x: &RowBlock,
    threads: usize,
    part: impl Fn(Range<usize>) -> Mat<f64> + Sync,
) -> Mat<f64> {
    let parts = simd::map_stretches(x.rows(), threads, part);
    let sum = parts.into_iter().reduce(|sum, part| sum + part);
    sum.expect("a block has rows")
}

/// The part of XᵀY that some rows contribute.
fn stretch_product(x: &RowBlock, y: &RowBlock, rows: Range<usize>) -> Mat<f64> {
    let width = x.width();
    let range = rows.start * width..rows.end * width;
    let x = MatRef::from_column_major_slice(&x.as_slice()[range.clone()], width, rows.len());
    let y = MatRef::from_row_major_slice(&y.as_slice()[range], rows.len(), width);
    let mut product = Mat::zeros(width, width);
    matmul(product.as_mut(), Accum::Replace, x, y, 1.0, Par::Seq);
    product
}

/// X ← X C, with zero columns where C has fewer columns than X; columns of X beyond the rows of C do
/// not count. `scratch` is overwritten.
pub(super) fn rotate(
    x: &mut RowBlock,
    coefficients: &Mat<f64>,
    scratch: &mut RowBlock,
    threads: usize,
) {
    let width = x.width();
    let mut square = Mat::zeros(width, width);
    square
        .submatrix_mut(0, 0, coefficients.nrows(), coefficients.ncols())
        .copy_from(coefficients);
    scratch.reshape(x.rows(), width);
    simd::for_each_stretch_mut(scratch.as_mut_slice(), width, threads, |rows, new| {
        let old = &x.as_slice()[rows.start * width..rows.end * width];
        let old = MatRef::from_column_major_slice(old, width, rows.len());
        let new = MatMut::from_column_major_slice_mut(new, width, rows.len());
        matmul(new, Accum::Replace, square.transpose(), old, 1.0, Par::Seq);
    });
    std::mem::swap(x, scratch);
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
            let (gram, product) = gram_and_product(&x, &y, threads);
            assert!((product - &expected).norm_max() < 1e-9);
            assert!((&gram - x.as_mat().transpose() * x.as_mat()).norm_max() < 1e-9);
            assert_eq!(gram, super::gram(&x, threads));
        }
        let c = Mat::from_fn(8, 5, |i, j| (i + 2 * j) as f64);
        let expected = x.as_mat() * &c;
        rotate(&mut x, &c, &mut y, 1);
        assert!((x.as_mat().subcols(0, 5) - expected).norm_max() < 1e-10);
        assert_eq!(x.as_mat().subcols(5, 3).norm_max(), 0.0);
    }
}
