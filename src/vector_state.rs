//! Leaving the processor as it was found after AVX kernels that do not.
//!
//! faer's AVX kernels return with the upper halves of the vector registers marked as in use. On x86-64 every SSE
//! instruction then pays for merging them, until something clears the mark: libm's `exp` took 170 to 250 ns instead
//! of 8 after a single product (Xeon with AVX-512, faer 0.24.4). Clearing costs four cycles.

/// Clears the upper halves of the vector registers of the calling thread; nothing on other processors.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "an instruction that only some processors have")]
pub(crate) fn clear_upper_halves() {
    #[target_feature(enable = "avx")]
    fn zero_upper() {
        std::arch::x86_64::_mm256_zeroupper();
    }
    if std::arch::is_x86_feature_detected!("avx") {
        // SAFETY: the processor has AVX.
        unsafe { zero_upper() }
    }
}

/// Nothing to do here.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn clear_upper_halves() {}
