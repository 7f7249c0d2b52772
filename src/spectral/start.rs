//! What an update keeps for the next one, and the start block made from it.

use super::block::{LANES, RowBlock};
use super::elimination::EliminationOrder;
use super::extend::extend;
use super::null_space::NullSpace;
use super::rayleigh_ritz::inner_products;
use super::subspace::{Plan, randomize};
use super::{Laplacian, SymmetricOperator};
use rand_chacha::ChaCha8Rng;

/// What is left of a unit column after projection on a space that does not contain it.
const INDEPENDENT: f64 = 1e-6;

/// Reduction of residuals expected of a first update: what a growth of some per cent needs.
const FIRST_GAIN: f64 = 30.0;

/// The vectors of the last update, in the user's numbering, as functions y = x / scale on nodes.
#[derive(Clone, Debug)]
pub(super) struct Remembered {
    /// Null vectors (only if there are several), then Ritz vectors; zero columns up to the width.
    block: RowBlock,
    /// One per column in use, ascending; 0 for the null vectors.
    values: Vec<f64>,
    nulls: usize,
    /// Reduction of residuals that updates have needed.
    pub(super) gain: f64,
}

impl Remembered {
    /// Remembers `values.len()` columns of which the first `nulls` are null vectors; `entry(i, j)` is
    /// entry i of eigenvector j in the user's numbering. A single null vector is not kept: it is
    /// the same closed form on the next graph.
    pub(super) fn new(
        laplacian: &Laplacian<'_>,
        values: &[f64],
        nulls: usize,
        gain: Option<f64>,
        entry: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let skipped = usize::from(nulls == 1);
        let values = values[skipped..].to_vec();
        let width = values.len().next_multiple_of(LANES);
        let mut block = RowBlock::zeros(laplacian.dim(), width);
        for i in 0..laplacian.dim() {
            let scale = laplacian.scale(i).recip();
            for (j, y) in block.row_mut(i)[..values.len()].iter_mut().enumerate() {
                *y = scale * entry(i, skipped + j);
            }
        }
        Self {
            block,
            values,
            nulls: nulls - skipped,
            gain: gain.unwrap_or(FIRST_GAIN),
        }
    }

    /// Nodes of the graph it belongs to.
    pub(super) fn nodes(&self) -> usize {
        self.block.rows()
    }

    /// Columns besides null vectors.
    pub(super) fn ritz_vectors(&self) -> usize {
        self.values.len() - self.nulls
    }

    /// Guesses for a graph that has grown to `nodes`: low eigenvalues fall about as 1 / n.
    pub(super) fn plan(&self, nodes: usize, wanted: usize, width: usize) -> Plan {
        let shrink = self.nodes() as f64 / nodes as f64;
        let ritz = &self.values[self.nulls..];
        let at = |j: usize| shrink * ritz[j.min(ritz.len() - 1)];
        Plan {
            cut: at(width - 2).max(1.02 * at(wanted - 1)),
            wanted: at(wanted - 1),
            lowest: if self.nulls > 0 { 0.0 } else { at(0) },
            gain: self.gain,
        }
    }

    /// Fills `x` (n × width, elimination order) with the remembered vectors, extended to new nodes,
    /// off the null space, and at least one random column.
    pub(super) fn start_block(
        &self,
        laplacian: &Laplacian<'_>,
        order: &EliminationOrder,
        null_space: &NullSpace,
        x: &mut RowBlock,
        (width, threads): (usize, usize),
        rng: &mut ChaCha8Rng,
    ) {
        let fresh = extend(laplacian, &self.block);
        let taken = if self.nulls == 0 {
            let taken: Vec<usize> = (0..self.values.len().min(width - 1)).collect();
            self.gather(laplacian, order, &fresh, &taken, x, width);
            taken
        } else {
            let all: Vec<usize> = (0..self.values.len()).collect();
            self.gather(laplacian, order, &fresh, &all, x, self.block.width());
            null_space.project_out(x, threads);
            let mut independent = independent_columns(x, all.len(), threads);
            independent.truncate(width - 1);
            self.gather(laplacian, order, &fresh, &independent, x, width);
            independent
        };
        randomize(x, taken.len(), rng);
        null_space.project_out(x, threads);
    }

    fn gather(
        &self,
        laplacian: &Laplacian<'_>,
        order: &EliminationOrder,
        fresh: &RowBlock,
        columns: &[usize],
        x: &mut RowBlock,
        width: usize,
    ) {
        x.reset(laplacian.dim(), width);
        let old = self.nodes();
        for (i, &u) in order.node.iter().enumerate() {
            let u = u as usize;
            let row = if u < old {
                self.block.row(u)
            } else {
                fresh.row(u - old)
            };
            let scale = laplacian.scale(u);
            for (x, &j) in x.row_mut(i).iter_mut().zip(columns) {
                *x = scale * row[j];
            }
        }
    }
}

/// Which of the first `count` columns, of about unit norm before projection, still add something to
/// those before them: Cholesky of the Gram matrix in order, skipping small pivots. Null vectors of
/// components that have not changed vanish in the projection; of those that joined all but one stay.
fn independent_columns(x: &RowBlock, count: usize, threads: usize) -> Vec<usize> {
    let gram = inner_products(x, x, threads);
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
