//! M⁻¹ = (L + σI)⁻¹ off the null space: the operator whose *largest* eigenvalues 1 / (λ + σ) belong
//! to the lowest of L, spread far apart where those of L are crowded together.
//!
//! With the null space projected out σ may be tiny; it only has to keep L + σI positive definite.

use super::block::RowBlock;
use super::factor::CholeskyFactor;
use super::null_space::NullSpace;
use super::permuted::PermutedLaplacian;

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
}
