//! Rows of an n × f block of node values: how they lie in memory, and how they are shared out.
//!
//! Inside this module every block is **row-major**: the f values of a node are neighbours, so that one
//! visit of a sparse entry T̂_ij moves f values through the same cache line. At the border stand faer views,
//! usually column-major.
//!
//! Rows are dealt out in at most [`MAX_LANES`] contiguous *lanes*, each walked in blocks of [`BLOCK_ROWS`].
//! A lane depends on n alone, never on the number of threads, and sums over lanes are taken in lane order:
//! results are equal, bit for bit, at any thread count.

use faer::prelude::ReborrowMut;
use faer::{MatMut, MatRef};

/// Lanes per pass: enough to balance a common machine, few enough that adding them up costs nothing.
pub(super) const MAX_LANES: usize = 16;

/// Rows of a block: 256 × 16 `f64` are 32 KiB, so that a block is still in cache when the next step reads it.
pub(super) const BLOCK_ROWS: usize = 256;

/// Rows below which a second thread costs more to wake than it saves.
const MIN_LANE_ROWS: usize = 2048;

/// Rows of a lane (the last one may have fewer).
pub(super) fn rows_per_lane(num_rows: usize) -> usize {
    num_rows.div_ceil(MAX_LANES).max(MIN_LANE_ROWS)
}

/// Number of lanes, at least 1.
pub(super) fn num_lanes(num_rows: usize) -> usize {
    num_rows.div_ceil(rows_per_lane(num_rows)).max(1)
}

/// The row-major slice `values` as a matrix with `columns` columns.
pub(super) fn view(values: &[f64], columns: usize) -> MatRef<'_, f64> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    MatRef::from_row_major_slice(values, rows, columns)
}

/// Mutable twin of [`view`].
pub(super) fn view_mut(values: &mut [f64], columns: usize) -> MatMut<'_, f64> {
    let rows = values.len().checked_div(columns).unwrap_or(0);
    MatMut::from_row_major_slice_mut(values, rows, columns)
}

/// Copies `x` (any strides) to the row-major `rows`. Block by block unless rows lie ready: a column-major source
/// read in one sweep would touch every cache line of the target once per column.
pub(super) fn pack(x: MatRef<'_, f64>, rows: &mut [f64]) {
    let columns = x.ncols();
    assert_eq!(rows.len(), x.nrows() * columns, "rows of the wrong length");
    if columns == 0 {
        return;
    }
    if let Some(by_rows) = x.transpose().try_as_col_major() {
        for (target, source) in rows.chunks_exact_mut(columns).zip(by_rows.col_iter()) {
            copy_row(target, source.as_slice());
        }
        return;
    }
    for (block, chunk) in rows.chunks_mut(BLOCK_ROWS * columns).enumerate() {
        let count = chunk.len() / columns;
        view_mut(chunk, columns).copy_from(x.subrows(block * BLOCK_ROWS, count));
    }
}

/// A copy of two numbers, as two classes have, is no call.
fn copy_row(target: &mut [f64], source: &[f64]) {
    match (<&mut [f64; 2]>::try_from(&mut *target), source.try_into()) {
        (Ok(target), Ok(source)) => *target = source,
        _ => target.copy_from_slice(source),
    }
}

/// Copies the row-major `rows` to `x` (any strides).
pub(super) fn unpack(rows: &[f64], mut x: MatMut<'_, f64>) {
    let columns = x.ncols();
    assert_eq!(rows.len(), x.nrows() * columns, "rows of the wrong length");
    if columns == 0 {
        return;
    }
    for (block, chunk) in rows.chunks(BLOCK_ROWS * columns).enumerate() {
        let count = chunk.len() / columns;
        x.rb_mut()
            .subrows_mut(block * BLOCK_ROWS, count)
            .copy_from(view(chunk, columns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn packing_and_unpacking_round_trips_across_blocks() {
        for (n, f) in [(0, 3), (3, 0), (1, 1), (BLOCK_ROWS + 7, 5)] {
            let x = Mat::from_fn(n, f, |i, j| (10 * i + j) as f64);
            let mut rows = vec![f64::NAN; n * f];
            pack(x.as_ref(), &mut rows);
            for i in 0..n {
                for j in 0..f {
                    assert_eq!(rows[i * f + j], x[(i, j)]);
                }
            }
            let mut back = Mat::zeros(n, f);
            unpack(&rows, back.as_mut());
            assert_eq!(back, x);
        }
    }

    #[test]
    fn lanes_cover_the_rows_and_stay_few() {
        for n in [0, 1, 2048, 2049, 99_856, 1_000_000] {
            assert!(num_lanes(n) <= MAX_LANES);
            assert!(num_lanes(n) * rows_per_lane(n) >= n);
        }
    }
}
