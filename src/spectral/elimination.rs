//! In which order to eliminate the nodes: approximate minimum degree, then a postorder.
//!
//! The factor's fill depends on the order; so does speed, since the factor, the products and the
//! blocks are all kept in it: nodes that meet in a product should be near in memory. Three steps:
//!
//! 1. *relabel*: take the previous order, each new node placed behind an old neighbour (breadth
//!    first where there is no previous order). Minimum degree runs on this numbering, which costs
//!    it far fewer cache misses than the order of discovery;
//! 2. *AMD* (Amestoy, Davis & Duff 1996), from faer;
//! 3. *postorder* of the elimination tree, which leaves the fill as it is, makes each subtree and
//!    so each connected component a contiguous range, and lets supernodes form.

use super::Laplacian;
use super::SymmetricOperator;
use super::etree::{elimination_tree, postorder, renumbered};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use std::ops::Range;

/// An order of elimination.
#[derive(Clone, Debug, Default)]
pub(super) struct EliminationOrder {
    /// Node eliminated i-th.
    pub(super) node: Vec<u32>,
    /// When each node is eliminated: the inverse of `node`.
    pub(super) position: Vec<u32>,
    /// Ranges of positions, one per connected component.
    pub(super) components: Vec<Range<usize>>,
    /// The elimination tree, by positions: a postorder.
    pub(super) parent: Vec<u32>,
    /// Entries of the factor, estimated by the ordering.
    pub(super) fill: f64,
}

impl EliminationOrder {
    /// A fill-reducing order for `laplacian`; `previous` is that of the graph before it grew.
    pub(super) fn new(laplacian: &Laplacian<'_>, previous: Option<&EliminationOrder>) -> Self {
        let start = match previous {
            Some(order) if !order.node.is_empty() && order.node.len() <= laplacian.dim() => {
                appended(laplacian, order)
            }
            _ => breadth_first(laplacian),
        };
        let (node, fill) = minimum_degree(laplacian, &start);
        let upper = UpperPattern::new(laplacian, &node, &inverse(&node));
        let parent = elimination_tree(&upper.column_starts, &upper.rows);
        let (order, components) = postorder(&parent);
        let node: Vec<u32> = order.iter().map(|&i| node[i as usize]).collect();
        let parent = renumbered(&parent, &order);
        Self {
            parent,
            position: inverse(&node),
            node,
            components,
            fill,
        }
    }
}

/// Pattern of the strict upper triangle, by columns with sorted rows, under a numbering.
pub(super) struct UpperPattern {
    pub(super) column_starts: Vec<u32>,
    pub(super) rows: Vec<u32>,
}

impl UpperPattern {
    pub(super) fn new(laplacian: &Laplacian<'_>, node: &[u32], position: &[u32]) -> Self {
        let n = node.len();
        let mut column_starts = vec![0u32; n + 1];
        for (i, &u) in node.iter().enumerate() {
            let earlier = |&&v: &&u32| (position[v as usize] as usize) < i;
            column_starts[i + 1] = column_starts[i]
                + laplacian.row(u as usize).0.iter().filter(earlier).count() as u32;
        }
        let mut cursor = column_starts.clone();
        let mut rows = vec![0u32; column_starts[n] as usize];
        for (i, &u) in node.iter().enumerate() {
            for &v in laplacian.row(u as usize).0 {
                let j = position[v as usize] as usize;
                if j > i {
                    rows[cursor[j] as usize] = i as u32;
                    cursor[j] += 1;
                }
            }
        }
        Self {
            column_starts,
            rows,
        }
    }
}

fn inverse(permutation: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; permutation.len()];
    for (i, &p) in permutation.iter().enumerate() {
        inverse[p as usize] = i as u32;
    }
    inverse
}

/// The previous order with each new node behind one of its neighbours.
fn appended(laplacian: &Laplacian<'_>, previous: &EliminationOrder) -> Vec<u32> {
    let old = previous.node.len();
    let mut anchor = previous.position.clone();
    for i in old..laplacian.dim() {
        let known = laplacian.row(i).0.iter().filter(|&&j| (j as usize) < i);
        anchor.push(
            known
                .map(|&j| anchor[j as usize])
                .min()
                .unwrap_or(old as u32),
        );
    }
    // Counting sort by anchor, which keeps old nodes in their order and new ones behind them.
    let mut starts = vec![0u32; old + 2];
    for &a in &anchor {
        starts[a as usize + 1] += 1;
    }
    for a in 0..=old {
        starts[a + 1] += starts[a];
    }
    let mut order = vec![0u32; anchor.len()];
    for (i, &a) in anchor.iter().enumerate() {
        order[starts[a as usize] as usize] = i as u32;
        starts[a as usize] += 1;
    }
    order
}

/// Breadth first from the earliest node of each component.
fn breadth_first(laplacian: &Laplacian<'_>) -> Vec<u32> {
    let n = laplacian.dim();
    let mut seen = vec![false; n];
    let mut order: Vec<u32> = Vec::with_capacity(n);
    for root in 0..n {
        if seen[root] {
            continue;
        }
        seen[root] = true;
        let mut next = order.len();
        order.push(root as u32);
        while next < order.len() {
            for &v in laplacian.row(order[next] as usize).0 {
                if !seen[v as usize] {
                    seen[v as usize] = true;
                    order.push(v);
                }
            }
            next += 1;
        }
    }
    order
}

/// Approximate minimum degree, started from the numbering `start`; and the fill it expects.
fn minimum_degree(laplacian: &Laplacian<'_>, start: &[u32]) -> (Vec<u32>, f64) {
    let n = start.len();
    let upper = UpperPattern::new(laplacian, start, &inverse(start));
    let pattern =
        SymbolicSparseColMatRef::new_checked(n, n, &upper.column_starts, None, &upper.rows);
    let mut permutation = vec![0u32; n];
    let mut permutation_inverse = vec![0u32; n];
    let mut memory = MemBuffer::new(amd::order_scratch::<u32>(n, upper.rows.len()));
    let counts = amd::order(
        &mut permutation,
        &mut permutation_inverse,
        pattern,
        amd::Control::default(),
        MemStack::new(&mut memory),
    )
    .expect("indices fit in 32 bits, which the caller has checked");
    let node = permutation.iter().map(|&p| start[p as usize]).collect();
    (node, counts.n_div + n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::{LaplacianKind, testing};

    fn assert_is_order(order: &EliminationOrder, n: usize) {
        let mut seen = vec![false; n];
        for (i, &u) in order.node.iter().enumerate() {
            assert_eq!(order.position[u as usize], i as u32);
            seen[u as usize] = true;
        }
        assert!(seen.iter().all(|&s| s));
    }

    #[test]
    fn growing_orders_are_permutations_with_one_range_per_component() {
        let whole = testing::disjoint(&[testing::grid(9, 7), testing::path(5), testing::path(1)]);
        let mut previous = None;
        for n in [10, 40, 63, 66, 69] {
            let graph = testing::prefix(&whole, n);
            let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized).unwrap();
            let order = EliminationOrder::new(&laplacian, previous.as_ref());
            assert_is_order(&order, n);
            let expected = 1 + usize::from(n > 63) + usize::from(n > 68);
            assert_eq!(order.components.len(), expected, "n = {n}");
            assert_eq!(order.components.last().map(|c| c.end), Some(n));
            previous = Some(order);
        }
    }

    #[test]
    fn a_tree_fills_nothing() {
        let graph = testing::path(1000);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized).unwrap();
        let order = EliminationOrder::new(&laplacian, None);
        assert_eq!(order.fill, 1000.0 + 999.0);
    }
}
