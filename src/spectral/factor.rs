//! M = L + σI = C Cᵀ by sparse Cholesky, and the inertia of L − μI by sparse L D Lᵀ.
//!
//! faer finds the structure of the factor and its values. Sylvester's law of inertia: L − μI has as
//! many negative pivots in D as L has eigenvalues below μ.

use super::block::RowBlock;
use super::permuted::{PermutedLaplacian, Triangle, TriangleMatrix};
use super::simd::for_each_panel;
use super::triangular::{ColumnFactor, ColumnSolve, SupernodalFactor, SupernodalSolve};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};

/// A Cholesky factor of L + σI, or the pattern of one not yet computed.
#[derive(Debug)]
pub(super) struct CholeskyFactor {
    symbolic: SymbolicCholesky<u32>,
    values: Vec<f64>,
    triangle: TriangleMatrix,
}

/// The matrix is not numerically positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NotPositiveDefinite;

/// Memory whose contents a factorisation no longer needs, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct FactorBuffers {
    values: Vec<f64>,
    triangle: TriangleMatrix,
}

impl CholeskyFactor {
    /// Structure of the factor of a matrix with the pattern of `laplacian`; `None` if the factor
    /// does not fit in memory or in 32-bit indices.
    pub(super) fn analyze(laplacian: &PermutedLaplacian, buffers: FactorBuffers) -> Option<Self> {
        let FactorBuffers {
            values,
            mut triangle,
        } = buffers;
        laplacian.triangle(Triangle::Upper, 0.0, &mut triangle);
        let symbolic = factorize_symbolic_cholesky(
            triangle.pattern(),
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams::default(),
        )
        .ok()?;
        Some(Self {
            symbolic,
            values,
            triangle,
        })
    }

    /// Gives the memory back for another factor.
    pub(super) fn into_buffers(self) -> FactorBuffers {
        FactorBuffers {
            values: self.values,
            triangle: self.triangle,
        }
    }

    /// Which triangle the numerical factorisation of this structure reads without a copy.
    fn side(&self) -> (Side, Triangle) {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => (Side::Upper, Triangle::Upper),
            SymbolicCholeskyRaw::Supernodal(_) => (Side::Lower, Triangle::Lower),
        }
    }

    /// Computes the factor of L + σI.
    pub(super) fn factorize(
        &mut self,
        laplacian: &PermutedLaplacian,
        sigma: f64,
    ) -> Result<(), NotPositiveDefinite> {
        let (side, which) = self.side();
        laplacian.triangle(which, sigma, &mut self.triangle);
        self.values.resize(self.symbolic.len_val(), 0.0);
        let scratch = self
            .symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        self.symbolic
            .factorize_numeric_llt(
                &mut self.values,
                self.triangle.as_faer(),
                side,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|_| NotPositiveDefinite)?;
        self.for_each_pivot(|pivot| *pivot = pivot.recip());
        Ok(())
    }

    /// Eigenvalues of L below `mu`; `None` if a pivot vanished, which another `mu` avoids.
    /// Overwrites the factor.
    pub(super) fn count_below(&mut self, laplacian: &PermutedLaplacian, mu: f64) -> Option<usize> {
        let (side, which) = self.side();
        laplacian.triangle(which, -mu, &mut self.triangle);
        self.values.resize(self.symbolic.len_val(), 0.0);
        let scratch = self
            .symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.values,
                self.triangle.as_faer(),
                side,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .ok()?;
        let (mut negative, mut sound) = (0, true);
        self.for_each_pivot(|pivot| {
            negative += usize::from(*pivot < 0.0);
            sound &= pivot.is_finite() && *pivot != 0.0;
        });
        sound.then_some(negative)
    }

    /// Visits the diagonal of the factor.
    fn for_each_pivot(&mut self, mut visit: impl FnMut(&mut f64)) {
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(factor) => {
                for &start in &factor.col_ptr()[..factor.ncols()] {
                    visit(&mut self.values[start as usize]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(factor) => {
                for s in 0..factor.n_supernodes() {
                    let size = (factor.supernode_end()[s] - factor.supernode_begin()[s]) as usize;
                    let height = size + factor.nnz_per_super()[s] as usize;
                    let start = factor.col_ptr_for_val()[s] as usize;
                    for c in 0..size {
                        visit(&mut self.values[start + c * height + c]);
                    }
                }
            }
        }
    }

    /// x ← (L + σI)⁻¹ x.
    pub(super) fn solve(&self, x: &mut RowBlock) {
        let width = x.width();
        let x = x.as_mut_slice();
        match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(factor) => {
                let factor = ColumnFactor {
                    column_starts: factor.col_ptr(),
                    rows: factor.row_idx(),
                    values: &self.values,
                };
                for_each_panel(width, ColumnSolve { factor, x });
            }
            SymbolicCholeskyRaw::Supernodal(factor) => {
                let factor = SupernodalFactor {
                    begins: factor.supernode_begin(),
                    ends: factor.supernode_end(),
                    row_starts: factor.col_ptr_for_row_idx(),
                    row_counts: factor.nnz_per_super(),
                    rows: factor.row_idx(),
                    value_starts: factor.col_ptr_for_val(),
                    values: &self.values,
                };
                for_each_panel(width, SupernodalSolve { factor, x });
            }
        }
    }
}

impl TriangleMatrix {
    fn pattern(&self) -> SymbolicSparseColMatRef<'_, u32> {
        let n = self.column_starts.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.column_starts, None, &self.rows)
    }

    fn as_faer(&self) -> SparseColMatRef<'_, u32, f64> {
        SparseColMatRef::new(self.pattern(), &self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Csr;
    use crate::spectral::elimination::EliminationOrder;
    use crate::spectral::{Laplacian, LaplacianKind, testing};

    fn permuted(graph: &Csr) -> PermutedLaplacian {
        let laplacian = Laplacian::new(graph, LaplacianKind::Normalized).unwrap();
        let mut permuted = PermutedLaplacian::default();
        permuted.assign(&laplacian, &EliminationOrder::new(&laplacian, None));
        permuted
    }

    #[test]
    fn solving_undoes_multiplying_in_both_forms() {
        for (graph, supernodal) in [(testing::path(400), false), (testing::complete(150), true)] {
            let l = permuted(&graph);
            let mut factor = CholeskyFactor::analyze(&l, FactorBuffers::default()).unwrap();
            let form = matches!(factor.symbolic.raw(), SymbolicCholeskyRaw::Supernodal(_));
            assert_eq!(form, supernodal, "the two graphs cover the two forms");
            let sigma = 0.3;
            factor.factorize(&l, sigma).unwrap();
            for width in [8, 24, 56] {
                let mut b = RowBlock::zeros(l.dim(), width);
                for (i, v) in b.as_mut_slice().iter_mut().enumerate() {
                    *v = ((i * 7919) % 1000) as f64 / 500.0 - 1.0;
                }
                let mut x = b.clone();
                factor.solve(&mut x);
                let error = l.product_error(&x, sigma, &b);
                assert!(error < 1e-12, "width {width}: {error}");
            }
        }
    }

    #[test]
    fn inertia_counts_the_eigenvalues_of_a_path() {
        let n = 400;
        let l = permuted(&testing::path(n));
        let mut factor = CholeskyFactor::analyze(&l, FactorBuffers::default()).unwrap();
        let value = |j: usize| 1.0 - (std::f64::consts::PI * j as f64 / (n - 1) as f64).cos();
        for j in [0, 1, 17, 200] {
            let mu = (value(j) + value(j + 1)) / 2.0;
            assert_eq!(factor.count_below(&l, mu), Some(j + 1));
        }
        assert_eq!(factor.count_below(&l, -0.1), Some(0));
        assert_eq!(factor.count_below(&l, 2.1), Some(n));
    }

    #[test]
    fn a_negative_shift_is_not_positive_definite() {
        let l = permuted(&testing::grid(20, 20));
        let mut factor = CholeskyFactor::analyze(&l, FactorBuffers::default()).unwrap();
        assert_eq!(factor.factorize(&l, -0.5), Err(NotPositiveDefinite));
    }
}
