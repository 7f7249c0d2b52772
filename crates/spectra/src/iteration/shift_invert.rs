//! M⁻¹ = (L + σI)⁻¹ off the null space: the operator whose *largest* eigenvalues 1 / (λ + σ) belong
//! to the lowest of L, spread far apart where those of L are crowded together.
//!
//! With the null space projected out σ may be tiny; it only has to keep L + σI positive definite.

use super::null_space::NullSpace;
use crate::block::RowBlock;
use crate::cholesky::{CholeskyFactor, PermutedLaplacian};

/// L, the factor of L + σI and the null space of L, all in elimination order.
#[derive(Debug)]
pub(crate) struct ShiftInvert<'a> {
    pub(crate) laplacian: &'a PermutedLaplacian,
    pub(crate) factor: &'a CholeskyFactor,
    pub(crate) null_space: &'a NullSpace,
    pub(crate) sigma: f64,
    pub(crate) threads: usize,
}

impl ShiftInvert<'_> {
    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// x ← M⁻¹ x.
    pub(crate) fn solve(&self, x: &mut RowBlock) {
        self.factor.solve(x);
    }

    /// x ← x − N Nᵀ x.
    pub(crate) fn project(&self, x: &mut RowBlock) {
        self.null_space.project_out(x, self.threads);
    }
}
