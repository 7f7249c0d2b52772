//! A block of vectors stored node by node: n rows of `width` consecutive numbers.
//!
//! A sparse product or triangular solve visits nodes in irregular order; stored this way each visit
//! touches one stretch of memory and serves all vectors at once. The width is a multiple of
//! [`LANES`] and rows start on cache lines, so that rows are whole SIMD registers.

use super::simd::{self, LANES};

/// Alignment of the first row in bytes.
const CACHE_LINE: usize = 64;

/// Room kept beyond what is needed, as a share: a growing block then moves once in several updates.
/// Memory that is never touched costs nothing.
const HEADROOM: f64 = 0.25;

/// n × width numbers, row-major, rows aligned to cache lines.
#[derive(Debug, Default)]
pub(crate) struct RowBlock {
    storage: Vec<f64>,
    /// Numbers skipped so that the first row is aligned.
    offset: usize,
    rows: usize,
    width: usize,
}

impl RowBlock {
    pub(crate) fn zeros(rows: usize, width: usize) -> Self {
        let mut block = Self::default();
        block.reset(rows, width);
        block
    }

    /// Gives the block a new shape and sets it to zero, reusing its memory where that suffices.
    pub(crate) fn reset(&mut self, rows: usize, width: usize) {
        self.reshape(rows, width);
        self.as_mut_slice().fill(0.0);
    }

    /// Gives the block a new shape and whatever contents, reusing its memory where that suffices.
    pub(crate) fn reshape(&mut self, rows: usize, width: usize) {
        assert_eq!(width % LANES, 0, "width must be a multiple of {LANES}");
        let needed = rows * width + LANES;
        if self.storage.len() < needed {
            let grows = !self.storage.is_empty();
            self.storage = Vec::new();
            let spare = if grows { HEADROOM * needed as f64 } else { 0.0 };
            self.storage = vec![0.0; needed + spare as usize];
        }
        self.offset = self.storage.as_ptr().align_offset(CACHE_LINE).min(LANES);
        (self.rows, self.width) = (rows, width);
    }

    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }

    pub(crate) fn as_slice(&self) -> &[f64] {
        &self.storage[self.offset..self.offset + self.rows * self.width]
    }

    pub(crate) fn as_mut_slice(&mut self) -> &mut [f64] {
        &mut self.storage[self.offset..self.offset + self.rows * self.width]
    }

    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.as_slice()[i * self.width..(i + 1) * self.width]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        let width = self.width;
        &mut self.as_mut_slice()[i * width..(i + 1) * width]
    }

    /// self ← other, shape and all.
    pub(crate) fn copy_from(&mut self, other: &RowBlock, threads: usize) {
        self.reshape(other.rows, other.width);
        simd::for_each_stretch_mut(self.as_mut_slice(), other.width, threads, |rows, own| {
            own.copy_from_slice(
                &other.as_slice()[rows.start * other.width..rows.end * other.width],
            );
        });
    }
}

impl Clone for RowBlock {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.copy_from(self, 1);
        copy
    }
}

#[cfg(test)]
impl RowBlock {
    /// The block as an n × width matrix.
    pub(crate) fn as_mat(&self) -> faer::MatRef<'_, f64> {
        faer::MatRef::from_row_major_slice(self.as_slice(), self.rows, self.width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_aligned_also_after_reuse_and_clone() {
        let mut block = RowBlock::zeros(10, 24);
        for (rows, width) in [(10, 24), (3, 8), (100, 16)] {
            block.reset(rows, width);
            block.row_mut(rows - 1)[width - 1] = 1.0;
            for b in [&block, &block.clone()] {
                assert_eq!(b.as_slice().as_ptr() as usize % CACHE_LINE, 0);
                assert_eq!(b.as_slice().len(), rows * width);
                assert_eq!(b.as_mat()[(rows - 1, width - 1)], 1.0);
            }
        }
    }
}
