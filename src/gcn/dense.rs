//! faer's dense product, leaving the processor as it was found.
//!
//! The AVX kernels behind it return with the upper halves of the vector registers marked as in use. On x86-64
//! every SSE instruction then pays for merging them, until something clears the mark: libm's `exp` took
//! 170 to 250 ns instead of 8 after a single product (Xeon with AVX-512, faer 0.24.4). Clearing costs four cycles.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// `target` ← or += `left` · `right`, on the calling thread.
pub(super) fn multiply(
    target: MatMut<'_, f64>,
    accum: Accum,
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
) {
    matmul(target, accum, left, right, 1.0, Par::Seq);
    clear_upper_halves();
}

#[cfg(target_arch = "x86_64")]
fn clear_upper_halves() {
    #[target_feature(enable = "avx")]
    fn zero_upper() {
        std::arch::x86_64::_mm256_zeroupper();
    }
    if std::arch::is_x86_feature_detected!("avx") {
        // SAFETY: the processor has AVX.
        unsafe { zero_upper() }
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn clear_upper_halves() {}
