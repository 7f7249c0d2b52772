//! The block Lanczos recurrence, A V = V T + Q R Eᵀ.
//!
//! V (n × p) has orthonormal columns, T = VᵀAV, Q (n × b, orthonormal, orthogonal to V) is the next
//! block, R its b × b coupling and Eᵀ picks the last b rows (Golub & Van Loan, *Matrix
//! Computations*, 4th ed., section 10.3.6). Blocks find repeated eigenvalues that single vectors
//! miss. The new block is orthogonalised against all of V, so that T is exact to rounding also after
//! a restart, where it is an arrowhead rather than a band.

use super::orthonormal::{orthogonalize, orthonormalize};
use crate::dense::symmetric_eigen;
use crate::{SpectralError, SymmetricOperator};
use faer::{Mat, MatRef};
use rand_chacha::ChaCha8Rng;

/// A block Lanczos factorisation that can grow and be restarted.
pub(crate) struct BlockLanczos<'a, A> {
    operator: &'a A,
    /// V, then Q: n × capacity, p + b columns in use.
    basis: Mat<f64>,
    /// p.
    len: usize,
    /// b.
    block: usize,
    /// T in its leading p × p part.
    projected: Mat<f64>,
    /// R.
    coupling: Mat<f64>,
    rng: ChaCha8Rng,
}

/// Ritz pairs of a factorisation, wanted end first.
#[derive(Debug)]
pub(crate) struct RitzPairs {
    pub(crate) values: Vec<f64>,
    /// p × p; Ritz vectors are V times these.
    pub(crate) coefficients: Mat<f64>,
    pub(crate) residuals: Vec<f64>,
}

impl<'a, A: SymmetricOperator> BlockLanczos<'a, A> {
    /// Starts from `start` (n × b), room for `capacity` columns.
    ///
    /// # Panics
    /// If `capacity` exceeds n or holds less than two blocks.
    pub(crate) fn initialize(
        operator: &'a A,
        start: MatRef<'_, f64>,
        capacity: usize,
        mut rng: ChaCha8Rng,
    ) -> Self {
        let (n, block) = (operator.dim(), start.ncols());
        assert!(
            2 * block <= capacity && capacity <= n,
            "no room for the basis"
        );
        let mut basis = Mat::zeros(n, capacity);
        basis.subcols_mut(0, block).copy_from(start);
        let (none, rest) = basis.as_mut().split_at_col_mut(0);
        orthonormalize(none.as_ref(), rest.subcols_mut(0, block), &mut rng);
        Self {
            operator,
            basis,
            len: 0,
            block,
            projected: Mat::zeros(capacity, capacity),
            coupling: Mat::zeros(block, block),
            rng,
        }
    }

    /// p.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Whether another block fits.
    pub(crate) fn can_expand(&self) -> bool {
        self.len + 2 * self.block <= self.basis.ncols()
    }

    /// Takes Q into V: one product with b columns.
    pub(crate) fn expand(&mut self) {
        let (start, end) = (self.len, self.len + self.block);
        let (old, fresh) = self.basis.as_mut().split_at_col_mut(end);
        let mut next = fresh.subcols_mut(0, self.block);
        self.operator
            .apply(old.as_ref().subcols(start, self.block), next.as_mut());
        let h = orthogonalize(old.as_ref(), next.as_mut());
        for j in 0..self.block {
            for i in 0..end {
                self.projected[(i, start + j)] = h[(i, j)];
                self.projected[(start + j, i)] = h[(i, j)];
            }
        }
        self.coupling = orthonormalize(old.as_ref(), next, &mut self.rng);
        self.len = end;
    }

    /// The pairs of T, ascending, with residual norms ‖R Eᵀ y‖.
    pub(crate) fn ritz_pairs(&self) -> Result<RitzPairs, SpectralError> {
        let p = self.len;
        let (values, coefficients) =
            symmetric_eigen(self.projected.as_ref().submatrix(0, 0, p, p))?;
        let edge = &self.coupling * coefficients.subrows(p - self.block, self.block);
        let residuals = (0..p).map(|j| edge.col(j).norm_l2()).collect();
        Ok(RitzPairs {
            values,
            coefficients,
            residuals,
        })
    }

    /// V times the first `count` coefficient columns.
    pub(crate) fn ritz_vectors(&self, pairs: &RitzPairs, count: usize) -> Mat<f64> {
        self.basis.subcols(0, self.len) * pairs.coefficients.subcols(0, count)
    }

    /// Thick restart (Wu & Simon 2000): keeps `count` Ritz vectors and the block Q. Since Q still
    /// continues them, the relation A V = V T + Q R Eᵀ holds again after the next [`Self::expand`].
    pub(crate) fn restart(&mut self, pairs: &RitzPairs, count: usize) {
        let kept = self.ritz_vectors(pairs, count);
        let next = self.basis.subcols(self.len, self.block).to_owned();
        self.basis.subcols_mut(0, count).copy_from(&kept);
        self.basis.subcols_mut(count, self.block).copy_from(&next);
        self.projected.fill(0.0);
        for (j, &value) in pairs.values[..count].iter().enumerate() {
            self.projected[(j, j)] = value;
        }
        self.len = count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Laplacian, LaplacianKind, testing};
    use rand::{RngExt, SeedableRng};

    /// ‖A V − V T − Q R Eᵀ‖ with T and R as stored.
    fn relation_error<A: SymmetricOperator>(l: &BlockLanczos<'_, A>) -> f64 {
        let v = l.basis.subcols(0, l.len);
        let mut av = Mat::zeros(v.nrows(), v.ncols());
        l.operator.apply(v, av.as_mut());
        av -= v * l.projected.submatrix(0, 0, l.len, l.len);
        let mut edge = av.as_mut().subcols_mut(l.len - l.block, l.block);
        edge -= l.basis.subcols(l.len, l.block) * &l.coupling;
        av.norm_max()
    }

    #[test]
    fn the_recurrence_holds_before_and_after_a_restart() {
        let graph = testing::grid(12, 10);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let start = Mat::from_fn(120, 3, |_, _| rng.random::<f64>() - 0.5);
        let mut lanczos = BlockLanczos::initialize(&laplacian, start.as_ref(), 30, rng);
        while lanczos.can_expand() {
            lanczos.expand();
            assert!(relation_error(&lanczos) < 1e-13);
        }
        let pairs = lanczos.ritz_pairs().unwrap();
        lanczos.restart(&pairs, 10);
        lanczos.expand();
        assert!(relation_error(&lanczos) < 1e-13);
        let v = lanczos.basis.subcols(0, lanczos.len + 3);
        let gram = v.transpose() * v - Mat::<f64>::identity(v.ncols(), v.ncols());
        assert!(gram.norm_max() < 1e-13);
    }

    #[test]
    fn an_invariant_start_does_not_break_the_basis() {
        // The all-ones vector of D − W spans an invariant subspace.
        let graph = testing::cycle(40);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Combinatorial);
        let start = Mat::from_fn(40, 2, |_, j| if j == 0 { 1.0 } else { 2.0 });
        let rng = ChaCha8Rng::seed_from_u64(0);
        let mut lanczos = BlockLanczos::initialize(&laplacian, start.as_ref(), 24, rng);
        while lanczos.can_expand() {
            lanczos.expand();
        }
        assert!(relation_error(&lanczos) < 1e-12);
        let pairs = lanczos.ritz_pairs().unwrap();
        assert!(pairs.values[0].abs() < 1e-12 && pairs.values[1] > 1e-4);
    }
}
