//! Running one kernel with the widest SIMD registers of the machine, on panels of a block.
//!
//! Lanes are columns of a block, so that a wider register changes how many columns advance at once
//! and never the order of any column's sums. Threads share the rows in stretches of fixed length,
//! whose partial sums are added in order: results do not depend on the number of threads.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// Numbers in a cache line, and in the widest SIMD register in use.
pub(crate) const LANES: usize = 8;

/// Rows in a stretch: the unit that threads share.
pub(crate) const STRETCH: usize = 2048;

/// Most registers that a kernel keeps per row: more would spill on 16-register machines.
const MOST_VECTORS: usize = 6;

/// A range of a block's columns, counted in registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Panel {
    /// Registers in a row of the block.
    pub(crate) stride: usize,
    /// First register of the panel within the row.
    pub(crate) first: usize,
}

impl Panel {
    /// The panel's part of row `i`.
    #[inline(always)]
    pub(crate) fn load<V: Copy, const NV: usize>(self, block: &[V], i: usize) -> [V; NV] {
        let at = i * self.stride + self.first;
        *block[at..at + NV]
            .first_chunk()
            .expect("the range has NV elements")
    }

    /// Overwrites the panel's part of row `i`.
    #[inline(always)]
    pub(crate) fn store<V: Copy, const NV: usize>(self, block: &mut [V], i: usize, row: [V; NV]) {
        let at = i * self.stride + self.first;
        block[at..at + NV].copy_from_slice(&row);
    }
}

/// Work on one panel of `NV` registers per row.
pub(crate) trait PanelKernel {
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel);
}

/// Runs `kernel` on every panel of a block of `width` columns.
pub(crate) fn for_each_panel<K: PanelKernel>(width: usize, kernel: K) {
    assert_eq!(width % LANES, 0, "width must be a multiple of {LANES}");
    Arch::new().dispatch(Panels { width, kernel });
}

struct Panels<K> {
    width: usize,
    kernel: K,
}

impl<K: PanelKernel> WithSimd for Panels<K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let stride = self.width / S::F64_LANES;
        run_panels(simd, Panel { stride, first: 0 }, MOST_VECTORS, self.kernel);
    }
}

/// Runs `kernel` on panels of at most `most` (≤ 6) registers, from `panel` to the end of the rows.
#[inline(always)]
pub(crate) fn run_panels<S: Simd, K: PanelKernel>(
    simd: S,
    mut panel: Panel,
    most: usize,
    mut kernel: K,
) {
    while panel.first < panel.stride {
        let left = panel.stride - panel.first;
        // Even shares: 7 registers are 4 + 3 rather than 6 + 1.
        let vectors = left.div_ceil(left.div_ceil(most));
        match vectors {
            1 => kernel.run::<S, 1>(simd, panel),
            2 => kernel.run::<S, 2>(simd, panel),
            3 => kernel.run::<S, 3>(simd, panel),
            4 => kernel.run::<S, 4>(simd, panel),
            5 => kernel.run::<S, 5>(simd, panel),
            _ => kernel.run::<S, 6>(simd, panel),
        }
        panel.first += vectors;
    }
}

/// `f` of every stretch of `0..rows`, in order.
pub(crate) fn map_stretches<R: Send>(
    rows: usize,
    threads: usize,
    f: impl Fn(Range<usize>) -> R + Sync,
) -> Vec<R> {
    let stretch = |s: usize| f(s * STRETCH..rows.min((s + 1) * STRETCH));
    let count = rows.div_ceil(STRETCH);
    if threads > 1 {
        (0..count).into_par_iter().map(stretch).collect()
    } else {
        (0..count).map(stretch).collect()
    }
}

/// Applies `f` to every stretch of rows of a row-major block and its row range.
pub(crate) fn for_each_stretch_mut(
    block: &mut [f64],
    width: usize,
    threads: usize,
    f: impl Fn(Range<usize>, &mut [f64]) + Sync,
) {
    let stretch = |(s, rows): (usize, &mut [f64])| {
        let first = s * STRETCH;
        f(first..first + rows.len() / width, rows);
    };
    if threads > 1 {
        block
            .par_chunks_mut(STRETCH * width)
            .enumerate()
            .for_each(stretch);
    } else {
        block
            .chunks_mut(STRETCH * width)
            .enumerate()
            .for_each(stretch);
    }
}

/// Applies `f` to the same stretch of two row-major blocks of one shape.
pub(crate) fn for_each_stretch_pair_mut(
    a: &mut [f64],
    b: &mut [f64],
    width: usize,
    threads: usize,
    f: impl Fn(&mut [f64], &mut [f64]) + Sync,
) {
    assert_eq!(a.len(), b.len(), "blocks must have one shape");
    let length = STRETCH * width;
    if threads > 1 {
        a.par_chunks_mut(length)
            .zip(b.par_chunks_mut(length))
            .for_each(|(a, b)| f(a, b));
    } else {
        for (a, b) in a.chunks_mut(length).zip(b.chunks_mut(length)) {
            f(a, b);
        }
    }
}

/// Sums vectors of length `len`, first to last.
pub(crate) fn add_up(partial: Vec<Vec<f64>>, len: usize) -> Vec<f64> {
    let mut sum = vec![0.0; len];
    for part in partial {
        for (s, p) in sum.iter_mut().zip(part) {
            *s += p;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Double<'a>(&'a mut [f64], usize);

    impl PanelKernel for Double<'_> {
        #[inline(always)]
        fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
            let block = S::as_mut_simd_f64s(self.0).0;
            for i in 0..self.1 {
                let row: [_; NV] = panel.load(&*block, i);
                panel.store(block, i, row.map(|v| simd.add_f64s(v, v)));
            }
        }
    }

    #[test]
    fn panels_cover_every_column_once() {
        for width in [8, 16, 24, 40, 56, 104] {
            let mut block = vec![1.0; 3 * width];
            for_each_panel(width, Double(&mut block, 3));
            assert!(block.iter().all(|&v| v == 2.0), "width {width}");
        }
    }

    #[test]
    fn stretches_cover_every_row_once_at_any_thread_count() {
        for rows in [0, 1, STRETCH, 3 * STRETCH + 5] {
            for threads in [1, 4] {
                let ranges = map_stretches(rows, threads, |r| r);
                let flat: Vec<usize> = ranges.into_iter().flatten().collect();
                assert_eq!(flat, (0..rows).collect::<Vec<_>>());
            }
        }
    }
}
