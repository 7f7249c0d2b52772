//! faer's dense product, on the calling thread, leaving the vector registers as they were found.

use crate::vector_state::clear_upper_halves;
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
