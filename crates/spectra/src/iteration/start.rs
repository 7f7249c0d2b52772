//! The start block of an update: the vectors kept from the last one, on a graph that has grown.

use super::extend::extend;
use super::null_space::NullSpace;
use super::subspace::noise;
use super::warm_start::WarmStart;
use crate::block::{LANES, RowBlock, gram, simd};
use crate::cholesky::EliminationOrder;
use crate::{Laplacian, SymmetricOperator};
use rand_chacha::ChaCha8Rng;

/// What is left of a unit column after projection on a space that does not contain it.
const INDEPENDENT: f64 = 1e-6;

/// The graph that has grown.
#[derive(Clone, Copy)]
pub(crate) struct Grown<'a> {
    pub(crate) laplacian: &'a Laplacian<'a>,
    pub(crate) order: &'a EliminationOrder,
    pub(crate) null_space: &'a NullSpace,
    pub(crate) threads: usize,
}

/// Fills `x` (n × width, elimination order) with the kept vectors, extended to new nodes, off the null
/// space, and at least one random column: what finds an eigenvector that growth brought in.
///
/// Old null vectors are candidates if there were several: where components have joined all but one
/// of theirs are no longer null. A single one is the same closed form on the next graph.
pub(crate) fn start_block(
    kept: &WarmStart,
    grown: Grown<'_>,
    width: usize,
    x: &mut RowBlock,
    rng: &mut ChaCha8Rng,
) {
    let nulls = kept.null_space.dim();
    let count = nulls + kept.ritz_vectors();
    let mut columns: Vec<usize> = (0..count).collect();
    if nulls == 1 {
        columns.remove(0);
    } else {
        x.reshape(grown.laplacian.dim(), count.next_multiple_of(LANES));
        gather(kept, grown, &columns, &[], x);
        grown.null_space.project_out(x, grown.threads);
        columns = independent_columns(x, count, grown.threads);
    }
    columns.truncate(width - 1);
    x.reshape(grown.laplacian.dim(), width);
    let noise = noise(grown.laplacian.dim(), width - columns.len(), rng);
    gather(kept, grown, &columns, &noise, x);
    grown.null_space.project_out(x, grown.threads);
}

/// The chosen columns (null vectors first, then Ritz vectors) as functions on nodes, scaled for the
/// new degrees; behind them `noise`, row by row, or zeros.
fn gather(kept: &WarmStart, grown: Grown<'_>, columns: &[usize], noise: &[f64], x: &mut RowBlock) {
    let source = Source::new(kept, columns);
    let scales = grown.null_space.scales();
    let width = x.width();
    let fresh = noise.len() / x.rows();
    simd::for_each_stretch_mut(x.as_mut_slice(), width, grown.threads, |rows, x| {
        for (row, i) in x.chunks_exact_mut(width).zip(rows) {
            let (own, rest) = row.split_at_mut(columns.len());
            if fresh > 0 {
                rest.copy_from_slice(&noise[i * fresh..(i + 1) * fresh]);
            } else {
                rest.fill(0.0);
            }
            if let Some(&from) = kept.position.get(grown.order.node[i] as usize) {
                source.copy(from as usize, scales[i], own);
            }
        }
    });
    extend(
        grown.laplacian,
        grown.order,
        (kept.nodes(), columns.len()),
        x,
    );
}

/// The chosen columns of what was kept.
struct Source<'a> {
    kept: &'a WarmStart,
    scales: Vec<f64>,
    /// Component of each row; empty if no null vector was chosen.
    owners: Vec<u32>,
    nulls: &'a [usize],
    ritz: Vec<usize>,
}

impl<'a> Source<'a> {
    fn new(kept: &'a WarmStart, columns: &'a [usize]) -> Self {
        let nulls = kept.null_space.dim();
        let (null_columns, ritz) = columns.split_at(columns.partition_point(|&c| c < nulls));
        let owners = (!null_columns.is_empty()).then(|| kept.null_space.owners());
        Self {
            kept,
            scales: kept.null_space.scales(),
            owners: owners.unwrap_or_default(),
            nulls: null_columns,
            ritz: ritz.iter().map(|c| c - nulls).collect(),
        }
    }

    /// Overwrites `row` by kept row `from`, for a node whose scale is now `scale`.
    fn copy(&self, from: usize, scale: f64, row: &mut [f64]) {
        let factor = scale / self.scales[from];
        let (null, ritz) = row.split_at_mut(self.nulls.len());
        for (v, &c) in null.iter_mut().zip(self.nulls) {
            let is_own = self.owners[from] as usize == c;
            *v = f64::from(is_own) * factor * self.kept.null_space.entries()[from];
        }
        let (Some(&first), Some(&last)) = (self.ritz.first(), self.ritz.last()) else {
            return;
        };
        let old = &self.kept.block.row(from)[first..=last];
        if old.len() == ritz.len() {
            // Columns side by side, as they nearly always are: whole registers at a time.
            for (v, old) in ritz.iter_mut().zip(old) {
                *v = factor * old;
            }
        } else {
            for (v, &c) in ritz.iter_mut().zip(&self.ritz) {
                *v = factor * old[c - first];
            }
        }
    }
}

/// Which of the first `count` columns, of about unit norm before projection, still add something to
/// those before them: Cholesky of the Gram matrix in order, skipping small pivots. Null vectors of
/// components that have not changed vanish in the projection; of those that joined all but one stay.
fn independent_columns(x: &RowBlock, count: usize, threads: usize) -> Vec<usize> {
    let gram = gram(x, threads);
    let mut kept: Vec<usize> = Vec::new();
    let mut factor: Vec<Vec<f64>> = Vec::new();
    for j in 0..count {
        let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
        for (&i, above) in kept.iter().zip(&factor) {
            let dot: f64 = row.iter().zip(above).map(|(a, b)| a * b).sum();
            row.push((gram[(j, i)] - dot) / above[row.len()]);
        }
        let pivot = gram[(j, j)] - row.iter().map(|v| v * v).sum::<f64>();
        if pivot > INDEPENDENT {
            row.push(pivot.sqrt());
            kept.push(j);
            factor.push(row);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_and_vanished_columns_are_left_out() {
        let mut x = RowBlock::zeros(4, 8);
        for (i, row) in [
            [1.0, 0.0, 2.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [1.0, 1e-9, 2.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]
        .iter()
        .enumerate()
        {
            x.row_mut(i)[..4].copy_from_slice(row);
        }
        assert_eq!(independent_columns(&x, 4, 1), [0, 3]);
    }
}
