//! The Rayleigh–Ritz step: the best approximate eigenpairs that a subspace holds.
//!
//! For a basis X (n × m, not orthonormal) with G = XᵀX and H = XᵀLX solve H c = θ G c; the Ritz
//! vectors are X c (Parlett, *The Symmetric Eigenvalue Problem*, chapter 11). G is scaled to unit
//! diagonal and diagonalised, directions that it holds only to rounding are dropped.

use super::row_block::RowBlock;
use super::simd;
use super::tiles::{CACHED_ROWS, add_upper_product, multiply};
use crate::SpectralError;
use crate::dense::symmetric_eigen;
use faer::Mat;

/// Eigenvalues of the scaled Gram matrix below this are noise.
const RANK_TOLERANCE: f64 = 1e-13;

/// Coefficients of Ritz vectors in a basis.
#[derive(Debug)]
pub(crate) struct Ritz {
    /// θ ascending, one per direction kept.
    pub(crate) values: Vec<f64>,
    /// m × rank.
    pub(crate) coefficients: Mat<f64>,
    /// Smallest eigenvalue kept of the scaled Gram matrix; the Ritz vectors are orthonormal to
    /// about machine precision ÷ this.
    pub(crate) independence: f64,
}

/// Solves H c = θ G c.
pub(crate) fn ritz(gram: &Mat<f64>, projected: &Mat<f64>) -> Result<Ritz, SpectralError> {
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
pub(crate) fn gram(x: &RowBlock, threads: usize) -> Mat<f64> {
    let [gram] = upper_products(x, [x], threads);
    gram
}

/// XᵀX and the symmetric part on and above the diagonal of XᵀY, for a Y = M X with symmetric M, while
/// rows of X are in cache.
pub(crate) fn gram_and_product(x: &RowBlock, y: &RowBlock, threads: usize) -> (Mat<f64>, Mat<f64>) {
    let [gram, product] = upper_products(x, [x, y], threads);
    (gram, product)
}

/// The symmetric matrices that agree with XᵀY on and above the diagonal.
fn upper_products<const N: usize>(
    x: &RowBlock,
    others: [&RowBlock; N],
    threads: usize,
) -> [Mat<f64>; N] {
    let width = x.width();
    let parts = simd::map_stretches(x.rows(), threads, |stretch| {
        let mut sums = vec![0.0; N * width * width];
        for start in stretch.clone().step_by(CACHED_ROWS) {
            let range = start * width..stretch.end.min(start + CACHED_ROWS) * width;
            for (y, sums) in others.iter().zip(sums.chunks_exact_mut(width * width)) {
                let (x, y) = (&x.as_slice()[range.clone()], &y.as_slice()[range.clone()]);
                add_upper_product(x, y, width, sums);
            }
        }
        sums
    });
    let sums = simd::add_up(parts, N * width * width);
    std::array::from_fn(|n| {
        let sums = &sums[n * width * width..];
        Mat::from_fn(width, width, |i, j| sums[i.min(j) * width + i.max(j)])
    })
}

/// X ← X C, with zero columns where C has fewer columns than X; columns of X beyond the rows of C do
/// not count.
pub(crate) fn rotate(x: &mut RowBlock, coefficients: &Mat<f64>, threads: usize) {
    let width = x.width();
    let mut square = vec![0.0; width * width];
    for (i, row) in square
        .chunks_exact_mut(width)
        .take(coefficients.nrows())
        .enumerate()
    {
        for (j, c) in row.iter_mut().take(coefficients.ncols()).enumerate() {
            *c = coefficients[(i, j)];
        }
    }
    simd::for_each_stretch_mut(x.as_mut_slice(), width, threads, |_, rows| {
        let mut old = Vec::with_capacity(CACHED_ROWS * width);
        for rows in rows.chunks_mut(CACHED_ROWS * width) {
            old.clear();
            old.extend_from_slice(rows);
            multiply(&old, &square, width, rows);
        }
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
        let n = 2 * simd::STRETCH + 77;
        for width in [8, 24, 40, 136] {
            let (mut x, mut y) = (RowBlock::zeros(n, width), RowBlock::zeros(n, width));
            for i in 0..n {
                for j in 0..width {
                    x.row_mut(i)[j] = (((i * 131 + j * 7919) % 1009) as f64 / 1009.0 - 0.5) / 64.0;
                    y.row_mut(i)[j] = (i % 5) as f64 * x.row(i)[j];
                }
            }
            let expected = x.as_mat().transpose() * y.as_mat();
            for threads in [1, 4] {
                let (gram, product) = gram_and_product(&x, &y, threads);
                assert!((product - &expected).norm_max() < 1e-13);
                assert!((&gram - x.as_mat().transpose() * x.as_mat()).norm_max() < 1e-13);
                assert_eq!(gram, super::gram(&x, threads));
            }
            let c = Mat::from_fn(width, width - 3, |i, j| ((i + 2 * j) % 9) as f64);
            let expected = x.as_mat() * &c;
            rotate(&mut x, &c, 1);
            assert!((x.as_mat().subcols(0, width - 3) - expected).norm_max() < 1e-13);
            assert_eq!(x.as_mat().subcols(width - 3, 3).norm_max(), 0.0);
        }
    }
}
