//! The symmetric adjacency W as a CSR that grows in place.
//!
//! W = Wᵀ, w(i, j) > 0 for every stored entry, and d_i = Σ_j w(i, j) is the degree (a self-loop is stored once and
//! counted once, as in a row sum). These hold between any two calls:
//!
//! 1. entry (i, j) is stored if and only if (j, i) is, with the same weight, finite and positive;
//! 2. the columns of a row increase strictly;
//! 3. `degree(i)` is the sum of row i, up to the rounding of a different order of addition (exact for weights 1).
//!
//! The only doors are [`Adjacency::add_node`] and [`Adjacency::add_edge`], which cannot break them.
//! [`Adjacency::assert_consistent`] checks them in O(n + nnz log(nnz / n)).
//!
//! **Cost.** The rows lie in one array with slack: a full row moves to the end of the array with twice the room, and
//! the array is compacted when abandoned slots exceed half of the owned ones (the argument stands in
//! `src/graph/slack_rows.rs`). Hence an edge costs amortised O(1) plus the search and the shift inside its two rows; the shift is empty when
//! neighbours arrive in order of discovery, as they mostly do. Nothing is ever rebuilt: a growth of m edges costs
//! O(m), where a rebuild costs O(n + nnz) each time.

mod csr;
mod saved;

use super::GraphError;
use super::slack_rows::SlackRows;
use saved::Saved;
use serde::{Deserialize, Serialize};

/// Symmetric weighted adjacency that grows by nodes and edges; see the [module](self) for what it guarantees.
///
/// ```
/// use eigentrail::graph::Adjacency;
///
/// let mut path = Adjacency::with_nodes(3);
/// assert!(path.add_edge(0, 1, 1.0) && path.add_edge(2, 1, 0.5));
/// assert!(!path.add_edge(1, 0, 9.0)); // known: left as it is
/// assert_eq!(path.neighbors(1), [0, 2]);
/// assert_eq!(path.degree(1), 1.5);
/// ```
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct Adjacency {
    inner: SlackRows,
    degrees: Vec<f64>,
    num_loops: usize,
}

impl Adjacency {
    /// No nodes, no edges.
    pub fn new() -> Self {
        Self::default()
    }

    /// `n` isolated nodes.
    ///
    /// # Panics
    /// If `n` exceeds 2³² − 1.
    pub fn with_nodes(n: usize) -> Self {
        let mut adjacency = Self::new();
        (0..n).for_each(|_| {
            adjacency.add_node();
        });
        adjacency
    }

    /// Number of nodes n.
    pub fn num_nodes(&self) -> usize {
        self.inner.num_rows()
    }

    /// Undirected edges; a self-loop counts once.
    pub fn num_edges(&self) -> usize {
        (self.inner.num_entries() + self.num_loops) / 2
    }

    /// Stored entries of the matrix: two for an edge, one for a self-loop.
    pub fn nnz(&self) -> usize {
        self.inner.num_entries()
    }

    /// Adds an isolated node, returns its number. Amortised O(1).
    ///
    /// # Panics
    /// If there are 2³² − 1 nodes already.
    pub fn add_node(&mut self) -> u32 {
        let node = u32::try_from(self.num_nodes())
            .ok()
            .filter(|&node| node < u32::MAX);
        self.inner.push_row();
        self.degrees.push(0.0);
        node.expect("a graph has at most 2³² − 1 nodes")
    }

    /// Adds {u, v}; true if it is new (an existing edge is left as it is). `u == v` is a self-loop, stored once.
    /// Amortised O(1) plus the shift inside the two rows.
    ///
    /// # Panics
    /// If a node does not exist, the weight is not finite and positive, or a degree would overflow;
    /// [`Self::try_add_edge`] returns these as errors.
    pub fn add_edge(&mut self, u: u32, v: u32, weight: f64) -> bool {
        match self.try_add_edge(u, v, weight) {
            Ok(is_new) => is_new,
            Err(error) => panic!("{error}"),
        }
    }

    /// As [`Self::add_edge`], for data from outside.
    ///
    /// # Errors
    /// [`GraphError::NodeOutOfRange`], [`GraphError::Weight`] or [`GraphError::DegreeOverflow`]; the graph is then
    /// unchanged.
    pub fn try_add_edge(&mut self, u: u32, v: u32, weight: f64) -> Result<bool, GraphError> {
        let nodes = self.num_nodes();
        if let Some(node) = [u, v].into_iter().find(|&node| node as usize >= nodes) {
            return Err(GraphError::NodeOutOfRange { node, nodes });
        }
        check_weight(u, v, weight)?;
        let (row, column) = (u as usize, v as usize);
        let Err(at) = self.inner.position(row, v) else {
            return Ok(false);
        };
        if let Some(node) = [u, v]
            .into_iter()
            .find(|&node| (self.degree(node) + weight).is_infinite())
        {
            return Err(GraphError::DegreeOverflow { node });
        }
        self.inner.insert(row, at, v, weight);
        self.degrees[row] += weight;
        if u == v {
            self.num_loops += 1;
        } else {
            let mirrored = self
                .inner
                .position(column, u)
                .expect_err("the two halves of an edge come together");
            self.inner.insert(column, mirrored, u, weight);
            self.degrees[column] += weight;
        }
        Ok(true)
    }

    /// Whether {u, v} is an edge. O(log degree).
    ///
    /// # Panics
    /// If `u` does not exist.
    pub fn contains_edge(&self, u: u32, v: u32) -> bool {
        self.inner.position(u as usize, v).is_ok()
    }

    /// Sorted neighbours of `u` (itself if it has a loop).
    ///
    /// # Panics
    /// If `u` does not exist.
    pub fn neighbors(&self, u: u32) -> &[u32] {
        self.inner.columns(u as usize)
    }

    /// The weights that go with [`Self::neighbors`].
    ///
    /// # Panics
    /// If `u` does not exist.
    pub fn weights(&self, u: u32) -> &[f64] {
        self.inner.values(u as usize)
    }

    /// The degree d_u: row sum, a self-loop counted once. O(1).
    ///
    /// # Panics
    /// If `u` does not exist.
    pub fn degree(&self, u: u32) -> f64 {
        self.degrees[u as usize]
    }

    /// All degrees, n values.
    pub fn degrees(&self) -> &[f64] {
        &self.degrees
    }

    /// Checks rows whose columns are in range, and sums them up.
    pub(super) fn from_rows(inner: SlackRows) -> Result<Self, GraphError> {
        let adjacency = Self::from_symmetric_rows(inner);
        for (row, degree) in (0..).zip(&adjacency.degrees) {
            adjacency.check_row(row)?;
            if degree.is_infinite() {
                return Err(GraphError::DegreeOverflow { node: row });
            }
        }
        Ok(adjacency)
    }

    /// Sums up rows for which invariants 1 and 2 hold, and whose sums are finite.
    fn from_symmetric_rows(inner: SlackRows) -> Self {
        let rows = 0..inner.num_rows();
        let has_loop = |&row: &usize| inner.position(row, row as u32).is_ok();
        Self {
            degrees: rows
                .clone()
                .map(|row| inner.values(row).iter().sum())
                .collect(),
            num_loops: rows.filter(has_loop).count(),
            inner,
        }
    }

    /// Invariants 1 and 2 for one row.
    fn check_row(&self, row: u32) -> Result<(), GraphError> {
        if !self.neighbors(row).is_sorted_by(|a, b| a < b) {
            return Err(GraphError::UnsortedRow { row });
        }
        for (&column, &weight) in self.neighbors(row).iter().zip(self.weights(row)) {
            check_weight(row, column, weight)?;
            let mirrored = self
                .inner
                .position(column as usize, row)
                .map_or(0.0, |at| self.weights(column)[at]);
            if mirrored != weight {
                return Err(GraphError::Asymmetric {
                    row,
                    column,
                    weight,
                    mirrored,
                });
            }
        }
        Ok(())
    }

    /// Checks every invariant of the [module](self); meant for tests, after each mutation.
    ///
    /// # Panics
    /// If one does not hold.
    #[doc(hidden)]
    pub fn assert_consistent(&self) {
        self.inner.assert_consistent();
        assert_eq!(self.degrees.len(), self.num_nodes());
        let mut loops = 0;
        for row in 0..self.num_nodes() as u32 {
            self.check_row(row)
                .unwrap_or_else(|error| panic!("{error}"));
            let sum: f64 = self.weights(row).iter().sum();
            // The degree was added up in order of arrival: each addition may round once, either way.
            let slack = 2.0 * f64::EPSILON * sum * self.weights(row).len() as f64;
            assert!(
                (self.degree(row) - sum).abs() <= slack,
                "degree of {row}: {} ≠ {sum}",
                self.degree(row)
            );
            loops += usize::from(self.contains_edge(row, row));
        }
        assert_eq!(loops, self.num_loops);
    }
}

fn check_weight(row: u32, column: u32, weight: f64) -> Result<(), GraphError> {
    if weight.is_finite() && weight > 0.0 {
        Ok(())
    } else {
        Err(GraphError::Weight {
            row,
            column,
            weight,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn triangle_with_tail() -> Adjacency {
        let mut graph = Adjacency::with_nodes(5);
        for (u, v) in [(2, 1), (0, 1), (2, 0), (3, 2)] {
            assert!(graph.add_edge(u, v, 1.0));
            graph.assert_consistent();
        }
        graph
    }

    #[test]
    fn a_hub_whose_neighbours_arrive_in_order_never_shifts() {
        let mut star = Adjacency::with_nodes(100_001);
        for leaf in 1..100_001 {
            star.add_edge(0, leaf, 1.0);
        }
        star.assert_consistent();
        assert_eq!(
            (star.num_edges(), star.degree(0), star.degree(1)),
            (100_000, 100_000.0, 1.0)
        );
    }

    #[test]
    fn a_loop_is_stored_and_counted_once() {
        let mut graph = triangle_with_tail();
        assert!(graph.add_edge(2, 2, 0.25) && !graph.add_edge(2, 2, 1.0));
        graph.assert_consistent();
        assert_eq!(
            (graph.num_edges(), graph.nnz(), graph.degree(2)),
            (5, 9, 3.25)
        );
        assert_eq!(graph.neighbors(2), [0, 1, 2, 3]);
    }

    #[test]
    fn bad_edges_are_refused_and_change_nothing() {
        let mut graph = triangle_with_tail();
        let before = graph.to_csr();
        for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(
                graph.try_add_edge(0, 3, weight),
                Err(GraphError::Weight {
                    row: 0,
                    column: 3,
                    ..
                })
            ));
        }
        assert!(matches!(
            graph.try_add_edge(0, 5, 1.0),
            Err(GraphError::NodeOutOfRange { node: 5, nodes: 5 })
        ));
        graph.add_edge(4, 4, f64::MAX);
        assert!(matches!(
            graph.try_add_edge(0, 4, f64::MAX),
            Err(GraphError::DegreeOverflow { node: 4 })
        ));
        graph.assert_consistent();
        assert_eq!(
            graph.prefix_csr(4),
            Adjacency::from_csr(&before).prefix_csr(4)
        );
    }

    #[test]
    #[should_panic(expected = "node 5 does not exist")]
    fn an_edge_to_nowhere_panics() {
        triangle_with_tail().add_edge(5, 0, 1.0);
    }
}
