//! What an update keeps for the next one, and for whoever asks for its vectors.
//!
//! The block of Ritz vectors stays as the search left it, rows in elimination order, guards included:
//! nothing is copied until somebody needs it.

use super::block::{LANES, RowBlock};
use super::effort::Needs;
use super::elimination::EliminationOrder;
use super::null_space::NullSpace;
use super::subspace::Plan;
use faer::{Mat, MatRef};

/// Eigenvalues closer than this, relative to their size, count as equal.
const ONE_CLUSTER: f64 = 1e-3;

/// The vectors of an update.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    /// Ritz vectors, rows in elimination order; further columns hold nothing.
    pub(super) block: RowBlock,
    /// One per Ritz vector, ascending.
    values: Vec<f64>,
    pub(super) null_space: NullSpace,
    /// Row of each node.
    pub(super) position: Vec<u32>,
    /// What the last updates have needed.
    pub(super) needs: Needs,
}

impl Kept {
    /// `block` holds a Ritz vector for each of `values`, rows in `order`.
    pub(super) fn new(
        block: RowBlock,
        values: Vec<f64>,
        null_space: NullSpace,
        order: &EliminationOrder,
        needs: Needs,
    ) -> Self {
        Self {
            block,
            values,
            null_space,
            position: order.position.clone(),
            needs,
        }
    }

    /// As [`Kept::new`], from vectors in the user's numbering.
    pub(super) fn from_vectors(
        vectors: MatRef<'_, f64>,
        values: Vec<f64>,
        null_space: NullSpace,
        order: &EliminationOrder,
        needs: Needs,
    ) -> Self {
        let width = values.len().next_multiple_of(LANES);
        let mut block = RowBlock::zeros(vectors.nrows(), width);
        for (u, &row) in order.position.iter().enumerate() {
            for (j, v) in block.row_mut(row as usize)[..values.len()]
                .iter_mut()
                .enumerate()
            {
                *v = vectors[(u, j)];
            }
        }
        Self::new(block, values, null_space, order, needs)
    }

    /// Nodes of the graph it belongs to.
    pub(super) fn nodes(&self) -> usize {
        self.position.len()
    }

    /// Columns besides null vectors.
    pub(super) fn ritz_vectors(&self) -> usize {
        self.values.len()
    }

    /// Columns for `wanted` pairs: `usual`, or as many as were found necessary last time because more
    /// equal eigenvalues than that follow the last one wanted.
    pub(super) fn width(&self, wanted: usize, usual: usize) -> usize {
        let first_missed = self.values.get(usual.max(wanted) - 1);
        let last = self.values[wanted - 1];
        let is_one_cluster = first_missed.is_some_and(|v| v - last <= ONE_CLUSTER * last);
        if is_one_cluster {
            self.block.width().max(usual)
        } else {
            usual
        }
    }

    /// Guesses for a graph that has grown to `nodes`: low eigenvalues fall about as 1 / n. The last
    /// columns of the block, one of them random, are not counted upon.
    pub(super) fn plan(&self, nodes: usize, wanted: usize, width: usize) -> Plan {
        let shrink = self.nodes() as f64 / nodes as f64;
        let at = |j: usize| shrink * self.values[j.min(self.values.len() - 1)];
        let several = self.null_space.dim() > 1;
        Plan {
            cut: at(width - 3).max(1.02 * at(wanted - 1)),
            wanted: at(wanted - 1),
            lowest: if several { 0.0 } else { at(0) },
            needs: self.needs.clone(),
        }
    }

    /// The null vectors, then Ritz vectors: n × k in the user's numbering.
    pub(super) fn vectors(&self, k: usize) -> Mat<f64> {
        let nulls = self.null_space.dim().min(k);
        let mut vectors = self.null_space.vectors(&self.position, nulls);
        vectors.resize_with(self.nodes(), k, |_, _| 0.0);
        for (u, &row) in self.position.iter().enumerate() {
            if k > nulls {
                for (j, &v) in self.block.row(row as usize)[..k - nulls].iter().enumerate() {
                    vectors[(u, nulls + j)] = v;
                }
            }
        }
        vectors
    }
}
