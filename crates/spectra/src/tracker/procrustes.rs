//! Aligning one orthonormal basis with another.
//!
//! Eigenvectors have no fixed sign, order or basis within an eigenspace. The orthogonal Procrustes
//! problem (Schönemann 1966): the orthogonal Q nearest to mapping V onto a reference B,
//!
//!   min ‖V Q − B‖_F,   Q = U Wᵀ for VᵀB = U Σ Wᵀ.
//!
//! With fewer reference columns than columns of V the rest of Q completes it to an orthogonal matrix.

use crate::SpectralError;
use faer::{Mat, MatRef};

/// The k × k orthogonal Q whose first columns bring V (n × k) nearest to `reference` (r × b,
/// b ≤ k), where r ≤ n rows of V are compared.
///
/// Columns of the reference that V does not contain at all are matched arbitrarily, but always the
/// same way. Cost: 2 r k b flops and an SVD of order k.
///
/// # Errors
/// [`SpectralError::Dense`] if the singular value decomposition does not converge,
/// [`SpectralError::NotFinite`] for NaN or infinity in the input.
///
/// # Panics
/// If the reference has more rows or more columns than `vectors`.
pub fn procrustes(
    vectors: MatRef<'_, f64>,
    reference: MatRef<'_, f64>,
) -> Result<Mat<f64>, SpectralError> {
    let (k, b) = (vectors.ncols(), reference.ncols());
    assert!(
        reference.nrows() <= vectors.nrows() && b <= k,
        "reference must not be larger than the basis"
    );
    if b == 0 {
        return Ok(Mat::identity(k, k));
    }
    let common = vectors.subrows(0, reference.nrows());
    let cross = common.transpose() * reference;
    if !cross.is_all_finite() {
        return Err(SpectralError::NotFinite);
    }
    let (u, w) = singular_vectors(&cross)?;
    // U is k × k: its first b columns pair with W, the rest span what the reference lacks.
    let mut q = Mat::zeros(k, k);
    let aligned = u.subcols(0, b) * w.transpose();
    q.subcols_mut(0, b).copy_from(&aligned);
    let rest = u.subcols(b, k - b);
    for j in 0..k - b {
        let sign = sign_of_largest(rest.col(j).iter().copied());
        for i in 0..k {
            q[(i, b + j)] = sign * rest[(i, j)];
        }
    }
    Ok(q)
}

/// U (k × k) and W (b × b) of the singular value decomposition.
fn singular_vectors(matrix: &Mat<f64>) -> Result<(Mat<f64>, Mat<f64>), SpectralError> {
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
    let (k, b) = (matrix.nrows(), matrix.ncols());
    let full = ComputeSvdVectors::Full;
    let sequential = faer::Par::Seq;
    let scratch = svd_scratch::<f64>(k, b, full, full, sequential, Default::default());
    let (mut u, mut w) = (Mat::zeros(k, k), Mat::zeros(b, b));
    let mut s = faer::diag::Diag::<f64>::zeros(k.min(b));
    svd(
        matrix.as_ref(),
        s.as_mut(),
        Some(u.as_mut()),
        Some(w.as_mut()),
        sequential,
        MemStack::new(&mut MemBuffer::new(scratch)),
        Default::default(),
    )
    .map_err(|_| SpectralError::Dense { order: k })?;
    Ok((u, w))
}

/// The columns of `vectors`, each with its entry of largest magnitude positive: a convention for a first basis, which
/// has nothing to be aligned with.
pub fn with_fixed_signs(vectors: MatRef<'_, f64>) -> Mat<f64> {
    let signs: Vec<f64> = vectors
        .col_iter()
        .map(|column| sign_of_largest(column.iter().copied()))
        .collect();
    Mat::from_fn(vectors.nrows(), vectors.ncols(), |i, j| {
        signs[j] * vectors[(i, j)]
    })
}

/// The sign that makes the entry of largest magnitude (the first of equals) positive.
fn sign_of_largest(entries: impl Iterator<Item = f64>) -> f64 {
    let largest = entries.fold(0.0, |a: f64, e| if e.abs() > a.abs() { e } else { a });
    if largest < 0.0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::iteration::orthonormalize;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random_orthonormal(n: usize, k: usize, seed: u64) -> Mat<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut m = Mat::from_fn(n, k, |_, _| rng.random::<f64>() - 0.5);
        orthonormalize(Mat::zeros(n, 0).as_ref(), m.as_mut(), &mut rng);
        m
    }

    #[test]
    fn a_rotation_is_undone() {
        let v = random_orthonormal(50, 6, 1);
        let rotation = random_orthonormal(6, 6, 2);
        let q = procrustes(v.as_ref(), (&v * &rotation).as_ref()).unwrap();
        assert!((q - rotation).norm_max() < 1e-13);
    }

    #[test]
    fn a_smaller_reference_is_matched_and_completed() {
        let v = random_orthonormal(50, 6, 1);
        let reference = &v * random_orthonormal(6, 4, 3);
        let q = procrustes(v.as_ref(), reference.as_ref()).unwrap();
        assert!((q.transpose() * &q - Mat::<f64>::identity(6, 6)).norm_max() < 1e-13);
        assert!(((&v * &q).subcols(0, 4) - reference).norm_max() < 1e-13);
    }

    #[test]
    fn no_other_rotation_comes_nearer() {
        let v = random_orthonormal(30, 4, 5);
        let reference = random_orthonormal(25, 4, 6);
        let distance = |q: &Mat<f64>| ((&v * q).subrows(0, 25) - &reference).norm_l2();
        let best = distance(&procrustes(v.as_ref(), reference.as_ref()).unwrap());
        for seed in 10..60 {
            assert!(best <= distance(&random_orthonormal(4, 4, seed)) + 1e-12);
        }
    }
}
