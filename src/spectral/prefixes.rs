//! Prefixes of a matrix whose row order is the order of discovery: the graph as it was earlier.

use crate::graph::Csr;

/// Nodes at each update: from min(`start`, n), each time a share of `growth` more, at least one node.
pub(super) fn prefix_sizes(n: usize, start: usize, growth: f64) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(start.min(n)), move |&m| {
        let grown = ((m as f64 * (1.0 + growth)).round() as usize).max(m + 1);
        (m < n).then(|| grown.min(n))
    })
}

/// The adjacency among the first m nodes. Cost: O(m + its entries).
pub(super) fn leading_block(graph: &Csr, m: usize) -> Csr {
    let mut starts = Vec::with_capacity(m + 1);
    starts.push(0u32);
    let mut columns = Vec::new();
    let mut weights = Vec::new();
    for i in 0..m {
        let range = graph.indptr().outer_inds_sz(i);
        let row = &graph.indices()[range.clone()];
        let inside = row.partition_point(|&j| (j as usize) < m);
        columns.extend_from_slice(&row[..inside]);
        weights.extend_from_slice(&graph.data()[range][..inside]);
        starts.push(columns.len() as u32);
    }
    Csr::new((m, m), starts, columns, weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectral::testing;

    #[test]
    fn prefixes_grow_by_the_share_asked_for_up_to_the_whole() {
        let sizes = |n, start, growth| prefix_sizes(n, start, growth).collect::<Vec<_>>();
        assert_eq!(sizes(200, 64, 0.5), [64, 96, 144, 200]);
        assert_eq!(sizes(30, 64, 0.5), [30]);
        assert_eq!(sizes(4, 1, 1e-9), [1, 2, 3, 4]);
    }

    #[test]
    fn a_leading_block_is_the_subgraph() {
        let graph = testing::shuffled(&testing::grid(5, 5), 3);
        for m in [1, 7, 25] {
            assert_eq!(leading_block(&graph, m), testing::prefix(&graph, m));
        }
    }
}
