//! Small graphs for the tests of this module.

use super::absorbing_chain::AbsorbingChain;
use super::fit_context::FitContext;
use super::shortest_path::ShortestPathProblem;
use super::transition_matrix::TransitionMatrix;
use crate::graph::{StateId, SymmetricCsr};
use faer::Mat;
use proptest::prelude::*;

/// An undirected graph with unit weights; an edge given twice weighs 1 all the same.
pub fn graph(n: usize, edges: &[(usize, usize)]) -> SymmetricCsr {
    let mut directed: Vec<_> = edges.iter().flat_map(|&(i, j)| [(i, j), (j, i)]).collect();
    directed.sort_unstable();
    directed.dedup();
    let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
    directed
        .iter()
        .for_each(|&(i, j)| triplets.add_triplet(i, j, 1.0));
    SymmetricCsr::new(triplets.to_csr()).unwrap()
}

/// The path 0 – 1 – … – (n−1).
pub fn path(n: usize) -> SymmetricCsr {
    graph(n, &(1..n).map(|i| (i - 1, i)).collect::<Vec<_>>())
}

/// The grid of `rows` × `columns` cells, numbered row by row, without the edges that touch `walls`.
pub fn grid(rows: usize, columns: usize, walls: &[usize]) -> SymmetricCsr {
    let mut edges = Vec::new();
    for i in 0..rows * columns {
        if i % columns + 1 < columns {
            edges.push((i, i + 1));
        }
        if i + columns < rows * columns {
            edges.push((i, i + columns));
        }
    }
    edges.retain(|(i, j)| !walls.contains(i) && !walls.contains(j));
    graph(rows * columns, &edges)
}

/// Unit costs and goals of equal worth.
pub fn chain(adjacency: &SymmetricCsr, goals: &[u32]) -> AbsorbingChain {
    AbsorbingChain::by_hops(&TransitionMatrix::undirected(adjacency), goals)
}

/// Graphs of 2 to 24 nodes, any density, connected or not, with self-loops.
pub fn any_graph() -> impl Strategy<Value = SymmetricCsr> {
    (2_usize..24).prop_flat_map(|n| {
        prop::collection::vec((0..n, 0..n), 0..4 * n).prop_map(move |edges| graph(n, &edges))
    })
}

/// Calls `check` with a context on a 9 × 8 grid with two walls, goal in a corner, and `features` columns of features.
pub fn on_grid(features: usize, check: impl FnOnce(&FitContext<'_>)) {
    let adjacency = grid(9, 8, &[17, 18, 19, 44, 45]);
    let problem =
        ShortestPathProblem::uniform(&TransitionMatrix::undirected(&adjacency), &[StateId(0)]);
    let features = Mat::from_fn(72, features, |i, c| {
        ((i * (c + 2) * 37) % 29) as f64 / 14.0 - 1.0
    });
    check(&FitContext {
        problem: &problem,
        adjacency: &adjacency,
        features: features.as_ref(),
        labels: &[],
    });
}

/// Calls `check` with a context of this problem on this graph, without features and labels.
pub fn on_problem<T>(
    adjacency: &SymmetricCsr,
    problem: &ShortestPathProblem,
    check: impl FnOnce(&FitContext<'_>) -> T,
) -> T {
    check(&FitContext {
        problem,
        adjacency,
        features: Mat::zeros(0, 0).as_ref(),
        labels: &[],
    })
}
