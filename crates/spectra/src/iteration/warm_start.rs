//! The warm start that an update keeps for the next one, and for whoever asks for its vectors.
//!
//! The block of Ritz vectors stays as the search left it, rows in elimination order, guards included:
//! nothing is copied until somebody needs it.

use super::gain_history::GainHistory;
use super::null_space::NullSpace;
use super::subspace::Plan;
use crate::block::{LANES, RowBlock};
use crate::cholesky::EliminationOrder;
use faer::{Mat, MatRef};

/// Eigenvalues closer than this, relative to their size, count as equal.
const ONE_CLUSTER: f64 = 1e-3;

/// The vectors of an update, for the next one to start from.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct WarmStart {
    /// Ritz vectors, rows in elimination order; further columns hold nothing.
    pub(crate) block: RowBlock,
    /// One per Ritz vector, ascending.
    #[cfg_attr(feature = "serde", serde(with = "crate::plain::numbers"))]
    values: Vec<f64>,
    pub(crate) null_space: NullSpace,
    /// Row of each node.
    pub(crate) position: Vec<u32>,
    /// What the last updates have needed.
    pub(crate) gains: GainHistory,
}

#[cfg(feature = "serde")]
impl WarmStart {
    /// Whether it is one of a graph that was eliminated in `order`.
    pub(crate) fn is_consistent(&self, order: &EliminationOrder) -> bool {
        self.block.rows() == order.node.len()
            && self.values.len() <= self.block.width()
            && self.position == order.position
            && self.null_space.is_consistent(order)
    }

    /// Whether there are vectors for as many pairs.
    pub(crate) fn can_give(&self, pairs: usize) -> bool {
        pairs <= self.null_space.dim() + self.block.width()
    }
}

impl WarmStart {
    /// `block` holds a Ritz vector for each of `values`, rows in `order`.
    pub(crate) fn new(
        block: RowBlock,
        values: Vec<f64>,
        null_space: NullSpace,
        order: &EliminationOrder,
        gains: GainHistory,
    ) -> Self {
        Self {
            block,
            values,
            null_space,
            position: order.position.clone(),
            gains,
        }
    }

    /// As [`WarmStart::new`], from vectors in the user's numbering.
    pub(crate) fn from_vectors(
        vectors: MatRef<'_, f64>,
        values: Vec<f64>,
        null_space: NullSpace,
        order: &EliminationOrder,
        gains: GainHistory,
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
        Self::new(block, values, null_space, order, gains)
    }

    /// Nodes of the graph it belongs to.
    pub(crate) fn nodes(&self) -> usize {
        self.position.len()
    }

    /// Columns besides null vectors.
    pub(crate) fn ritz_vectors(&self) -> usize {
        self.values.len()
    }

    /// Columns for `wanted` pairs: `usual`, or as many as were found necessary last time because more
    /// equal eigenvalues than that follow the last one wanted.
    pub(crate) fn width(&self, wanted: usize, usual: usize) -> usize {
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
    pub(crate) fn plan(&self, nodes: usize, wanted: usize, width: usize) -> Plan {
        let shrink = self.nodes() as f64 / nodes as f64;
        let at = |j: usize| shrink * self.values[j.min(self.values.len() - 1)];
        let several = self.null_space.dim() > 1;
        Plan {
            cut: at(width - 3).max(1.02 * at(wanted - 1)),
            wanted: at(wanted - 1),
            lowest: if several { 0.0 } else { at(0) },
            gains: self.gains.clone(),
        }
    }

    /// The null vectors, then Ritz vectors: n × k in the user's numbering.
    pub(crate) fn vectors(&self, k: usize) -> Mat<f64> {
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
