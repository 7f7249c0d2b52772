//! Errors of a graph that comes from outside.

use thiserror::Error;

/// A rule that a graph from outside breaks. Nodes are numbered from 0 here (files of
/// Matrix Market count from 1).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GraphError {
    /// Every node of an edge exists.
    #[error("node {node} does not exist: there are {nodes} nodes")]
    NodeOutOfRange {
        /// The node asked for.
        node: u32,
        /// How many there are.
        nodes: usize,
    },
    /// Every action is below the number of actions.
    #[error("action {action} does not exist: there are {num_actions} actions")]
    ActionOutOfRange {
        /// The action asked for.
        action: u16,
        /// How many there are.
        num_actions: usize,
    },
    /// Weights are finite and positive.
    #[error("the weight of edge ({row}, {column}) must be finite and positive, it is {weight}")]
    Weight {
        /// Row of the entry.
        row: u32,
        /// Column of the entry.
        column: u32,
        /// Its value.
        weight: f64,
    },
    /// w(i, j) = w(j, i).
    #[error(
        "not symmetric: entry ({row}, {column}) is {weight}, entry ({column}, {row}) is {mirrored}"
    )]
    Asymmetric {
        /// Row of the first offending entry.
        row: u32,
        /// Its column.
        column: u32,
        /// Its value.
        weight: f64,
        /// The value of its mirror image, 0 if that is absent.
        mirrored: f64,
    },
    /// The columns of a row increase strictly.
    #[error("the columns of row {row} must increase strictly")]
    UnsortedRow {
        /// The row.
        row: u32,
    },
    /// Row sums are finite.
    #[error("the weights around node {node} sum to infinity")]
    DegreeOverflow {
        /// The node.
        node: u32,
    },
    /// A saved graph is complete.
    #[error("damaged graph: {found} {what}, expected {expected}")]
    Damaged {
        /// What there is too much or too little of.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A saved transition was taken at least once.
    #[error("damaged graph: transition {from} → {to} was taken 0 times, or twice listed")]
    BadTransition {
        /// Where it starts.
        from: u32,
        /// Where it ends.
        to: u32,
    },
}
