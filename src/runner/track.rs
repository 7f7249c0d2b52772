//! Proto-value functions of any growing graph, no learning involved.
//!
//! The rows of a symmetric matrix are taken as the order of discovery: the graph grows as its leading principal
//! submatrices, from 64 nodes (or all, if there are fewer) by a share of its nodes each time, to the whole.

use crate::graph::Csr;
use crate::spectral::{
    Eigenpairs, ProtoValueFunctions, SpectralError, SpectralParams, SpectrumRefresh,
};
use serde::Serialize;
use std::time::Instant;

/// Nodes of the first graph.
const FIRST: usize = 64;

/// One update.
#[derive(Clone, Debug, Serialize)]
pub struct TrackUpdate {
    /// Nodes of the graph.
    pub nodes: usize,
    /// Its undirected edges; a loop is one.
    pub edges: usize,
    /// Wall seconds of the update.
    pub seconds: f64,
    /// Columns multiplied by the Laplacian.
    pub applications: usize,
    /// Columns solved with a factor of the shifted Laplacian.
    pub solves: usize,
    /// The largest residual, relative to the largest eigenvalue kept.
    pub max_relative_residual: f64,
    /// Whether every pair kept to the tolerance.
    pub converged: bool,
    /// Whether it began from random vectors.
    pub cold_start: bool,
    /// The eigenvalues, ascending; as many as there are nodes while those are fewer than asked for.
    pub eigenvalues: Vec<f64>,
}

/// All updates of a graph.
#[derive(Clone, Debug)]
pub struct TrackReport {
    /// The updates, in order.
    pub updates: Vec<TrackUpdate>,
    /// Wall seconds of all of them.
    pub total_seconds: f64,
    /// The pairs of the whole graph; none for a graph without nodes.
    pub eigenpairs: Option<Eigenpairs>,
}

/// Follows the graph as it grows by `growth` of its nodes at a time. `on_update` is told of each update.
///
/// # Errors
/// If more pairs are asked for than the whole graph has nodes, or the graph is not a graph.
///
/// # Panics
/// If `growth` is not positive.
pub fn track(
    adjacency: &Csr,
    params: &SpectralParams,
    growth: f64,
    seed: u64,
    mut on_update: impl FnMut(&TrackUpdate),
) -> Result<TrackReport, SpectralError> {
    assert!(growth > 0.0, "growth = {growth}");
    let (n, k) = (adjacency.rows(), params.num_eigenpairs);
    if k > n {
        return Err(SpectralError::TooManyPairs { k, n });
    }
    let mut functions = ProtoValueFunctions::new(params.clone(), seed);
    let mut updates = Vec::new();
    let mut total_seconds = 0.0;
    for nodes in track_sizes(n, growth) {
        let graph = prefix(adjacency, nodes);
        let begun = Instant::now();
        let refresh = functions.refresh(&graph)?;
        let seconds = begun.elapsed().as_secs_f64();
        total_seconds += seconds;
        let update = summarise(refresh, seconds);
        on_update(&update);
        updates.push(update);
    }
    Ok(TrackReport {
        updates,
        total_seconds,
        eigenpairs: functions.eigenpairs().cloned(),
    })
}

fn summarise(refresh: SpectrumRefresh, seconds: f64) -> TrackUpdate {
    let convergence = refresh.convergence;
    TrackUpdate {
        nodes: refresh.nodes,
        edges: refresh.edges,
        seconds,
        applications: convergence.applications,
        solves: convergence.solves,
        max_relative_residual: convergence.max_relative_residual,
        converged: convergence.converged >= refresh.eigenvalues.len(),
        cold_start: refresh.cold_start,
        eigenvalues: refresh.eigenvalues,
    }
}

/// How many nodes the graph of n nodes has at each update: 64, then `growth` more each time (at least one), then n.
pub fn track_sizes(n: usize, growth: f64) -> Vec<usize> {
    let mut sizes = Vec::new();
    let mut nodes = FIRST.min(n);
    while nodes < n {
        sizes.push(nodes);
        let more = (nodes as f64 * growth).round() as usize;
        nodes = nodes.saturating_add(more.max(1));
    }
    if n > 0 {
        sizes.push(n);
    }
    sizes
}

/// The graph of the first `nodes` nodes.
fn prefix(adjacency: &Csr, nodes: usize) -> Csr {
    if nodes == adjacency.rows() {
        return adjacency.clone();
    }
    let mut offsets = Vec::with_capacity(nodes + 1);
    let (mut columns, mut weights) = (Vec::new(), Vec::new());
    offsets.push(0);
    for row in adjacency.outer_iterator().take(nodes) {
        let kept = row
            .indices()
            .partition_point(|&column| (column as usize) < nodes);
        columns.extend_from_slice(&row.indices()[..kept]);
        weights.extend_from_slice(&row.data()[..kept]);
        offsets.push(columns.len() as u32);
    }
    Csr::new((nodes, nodes), offsets, columns, weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Adjacency;
    use std::f64::consts::PI;

    fn cycle(n: u32) -> Csr {
        let mut graph = Adjacency::default();
        (0..n).for_each(|_| {
            graph.add_node();
        });
        for i in 0..n {
            graph.add_edge(i, (i + 1) % n, 1.0);
        }
        graph.to_csr()
    }

    #[test]
    fn sizes_grow_from_64_to_the_whole() {
        assert_eq!(track_sizes(5, 0.05), [5]);
        assert_eq!(track_sizes(64, 0.05), [64]);
        assert_eq!(track_sizes(75, 0.05), [64, 67, 70, 74, 75]);
        assert_eq!(track_sizes(66, 1e-9), [64, 65, 66]);
        assert_eq!(track_sizes(0, 0.5), [0; 0]);
    }

    #[test]
    fn prefixes_are_the_leading_submatrices() {
        let whole = cycle(10);
        let part = prefix(&whole, 4);
        assert_eq!((part.rows(), part.nnz()), (4, 6));
        for (weight, (i, j)) in part.iter() {
            assert_eq!(whole.get(i as usize, j as usize), Some(weight));
        }
    }

    #[test]
    fn a_cycle_ends_with_its_closed_form() {
        let params = SpectralParams {
            num_eigenpairs: 5,
            tol: 1e-4,
            ..SpectralParams::default()
        };
        let mut seen = 0;
        let report = track(&cycle(90), &params, 0.2, 0, |_| seen += 1).unwrap();
        assert_eq!(report.updates.len(), seen);
        let last = report.updates.last().unwrap();
        assert_eq!((last.nodes, last.edges, last.converged), (90, 90, true));
        for (j, value) in [0, 1, 1, 2, 2].into_iter().zip(&last.eigenvalues) {
            let exact = 1.0 - (2.0 * PI * f64::from(j) / 90.0).cos();
            assert!((value - exact).abs() < 1e-7, "{value} against {exact}");
        }
    }

    #[test]
    fn more_pairs_than_nodes_are_refused() {
        let params = SpectralParams {
            num_eigenpairs: 11,
            ..SpectralParams::default()
        };
        let error = track(&cycle(10), &params, 0.2, 0, |_| ()).unwrap_err();
        assert!(error.to_string().contains("11"), "{error}");
    }
}
