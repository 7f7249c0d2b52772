//! M⁻¹ = (L + σI)⁻¹ off the null space: the operator whose *largest* eigenvalues 1 / (λ + σ) belong
//! to the lowest of L, spread far apart where those of L are crowded together.
//!
//! With the null space projected out σ may be tiny; it only has to keep L + σI positive definite.

use super::SymmetricOperator;
use super::block::{LANES, RowBlock};
use super::factor::CholeskyFactor;
use super::null_space::NullSpace;
use super::permuted::PermutedLaplacian;
use faer::{MatMut, MatRef};

/// L, the factor of L + σI and the null space of L, all in elimination order.
#[derive(Debug)]
pub(super) struct ShiftInvert<'a> {
    pub(super) laplacian: &'a PermutedLaplacian,
    pub(super) factor: &'a CholeskyFactor,
    pub(super) null_space: &'a NullSpace,
    pub(super) sigma: f64,
    pub(super) threads: usize,
}

impl ShiftInvert<'_> {
    pub(super) fn threads(&self) -> usize {
        self.threads
    }

    /// x ← M⁻¹ x.
    pub(super) fn solve(&self, x: &mut RowBlock) {
        self.factor.solve(x);
    }

    /// x ← x − N Nᵀ x.
    pub(super) fn project(&self, x: &mut RowBlock) {
        self.null_space.project_out(x, self.threads);
    }

    /// The columns of `x` off the null space, widened to a block by zero columns.
    fn projected_block(&self, x: MatRef<'_, f64>) -> RowBlock {
        let mut block = RowBlock::zeros(x.nrows(), x.ncols().next_multiple_of(LANES));
        block.as_mat_mut().subcols_mut(0, x.ncols()).copy_from(x);
        self.project(&mut block);
        block
    }
}

impl SymmetricOperator for ShiftInvert<'_> {
    fn dim(&self) -> usize {
        self.laplacian.dim()
    }

    /// y ← P M⁻¹ P x, P the projection off the null space.
    fn apply(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        let mut block = self.projected_block(x);
        self.solve(&mut block);
        self.project(&mut block);
        y.copy_from(block.as_mat().subcols(0, x.ncols()));
    }
}
