//! Orthonormal bases: block Gram–Schmidt with reorthogonalisation, and what to do about rank.
//!
//! W ← W − V (VᵀW) twice makes W orthogonal to V to machine precision unless W lies in V to begin
//! with ("twice is enough": Daniel, Gragg, Kaufman & Stewart 1976). A column of which nothing is left
//! is replaced by a random one, with a zero in R, so that the basis never loses rank.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A column is dependent when less than this part of its norm is left.
const DEPENDENT: f64 = 1e-10;

/// W ← W − V (VᵀW), twice; returns the accumulated VᵀW, p × b. Cost: 8 n p b flops.
pub(crate) fn orthogonalize(basis: MatRef<'_, f64>, mut w: MatMut<'_, f64>) -> Mat<f64> {
    let mut total = Mat::zeros(basis.ncols(), w.ncols());
    for _ in 0..2 {
        let mut h = Mat::zeros(basis.ncols(), w.ncols());
        matmul(
            h.as_mut(),
            Accum::Replace,
            basis.transpose(),
            w.as_ref(),
            1.0,
            Par::Seq,
        );
        matmul(w.as_mut(), Accum::Add, basis, h.as_ref(), -1.0, Par::Seq);
        total += h;
    }
    total
}

/// Makes the columns of `w`, already orthogonal to `basis`, orthonormal: W = Q R, R upper triangular
/// (returned), Q in place. `basis` and `w` together must have fewer columns than rows.
pub(crate) fn orthonormalize(
    basis: MatRef<'_, f64>,
    mut w: MatMut<'_, f64>,
    rng: &mut ChaCha8Rng,
) -> Mat<f64> {
    let b = w.ncols();
    let mut r = Mat::zeros(b, b);
    for j in 0..b {
        let (done, mut rest) = w.as_mut().split_at_col_mut(j);
        let mut column = rest.as_mut().subcols_mut(0, 1);
        let before = column.norm_l2();
        let h = orthogonalize(done.as_ref(), column.as_mut());
        r.as_mut().submatrix_mut(0, j, j, 1).copy_from(&h);
        let after = column.norm_l2();
        if after > DEPENDENT * before && after > 0.0 {
            r[(j, j)] = after;
            column *= faer::Scale(after.recip());
        } else {
            replace_by_random(basis, done.as_ref(), column, rng);
        }
    }
    r
}

fn replace_by_random(
    basis: MatRef<'_, f64>,
    done: MatRef<'_, f64>,
    mut column: MatMut<'_, f64>,
    rng: &mut ChaCha8Rng,
) {
    for i in 0..column.nrows() {
        column[(i, 0)] = 2.0 * rng.random::<f64>() - 1.0;
    }
    orthogonalize(basis, column.as_mut());
    orthogonalize(done, column.as_mut());
    orthogonalize(basis, column.as_mut());
    let norm = column.norm_l2();
    column *= faer::Scale(norm.recip());
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn dependent_columns_are_replaced_and_the_factors_multiply_back() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut all = Mat::from_fn(50, 8, |_, _| rng.random::<f64>() - 0.5);
        orthonormalize(
            MatRef::from_column_major_slice(&[], 50, 0),
            all.as_mut().subcols_mut(0, 4),
            &mut rng,
        );
        let (basis, mut w) = all.as_mut().split_at_col_mut(4);
        orthogonalize(basis.as_ref(), w.as_mut());
        for i in 0..50 {
            w[(i, 2)] = w[(i, 0)] - 2.0 * w[(i, 1)];
        }
        let before = w.as_ref().to_owned();
        let r = orthonormalize(basis.as_ref(), w.as_mut(), &mut rng);
        assert_eq!(r[(2, 2)], 0.0);
        assert!((w.as_ref() * &r - before).norm_max() < 1e-13);
        let gram = all.transpose() * &all - Mat::<f64>::identity(8, 8);
        assert!(gram.norm_max() < 1e-14);
    }
}
