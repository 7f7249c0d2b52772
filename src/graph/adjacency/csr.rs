//! Between the adjacency that grows and the compact matrix that numerical code reads.

use super::Adjacency;
use crate::graph::SymmetricCsr;
use crate::graph::slack_rows::SlackRows;
use sprs::CsMatI;

impl Adjacency {
    /// Compact copy, n × n, O(n + nnz).
    ///
    /// # Panics
    /// If there are 2³² entries or more, which the `u32` row offsets of [`SymmetricCsr`] cannot count.
    pub fn to_csr(&self) -> SymmetricCsr {
        self.prefix_csr(self.num_nodes())
    }

    /// The subgraph of the first `m` nodes, as it was when they had been discovered; m × m, O(m log d + nnz).
    ///
    /// # Panics
    /// If `m` exceeds the number of nodes; else as [`Self::to_csr`].
    pub fn prefix_csr(&self, m: usize) -> SymmetricCsr {
        let mut csr = SymmetricCsr::empty();
        self.write_prefix_csr(m, &mut csr);
        csr
    }

    /// As [`Self::to_csr`], into the buffers of `csr`, whatever it held before; they grow only if they are too small.
    ///
    /// # Panics
    /// As [`Self::to_csr`].
    pub fn write_csr(&self, csr: &mut SymmetricCsr) {
        self.write_prefix_csr(self.num_nodes(), csr);
    }

    /// As [`Self::prefix_csr`], into the buffers of `csr`.
    ///
    /// # Panics
    /// As [`Self::prefix_csr`].
    pub fn write_prefix_csr(&self, m: usize, csr: &mut SymmetricCsr) {
        assert!(
            m <= self.num_nodes(),
            "a prefix of {m} nodes of a graph of {}",
            self.num_nodes()
        );
        let (mut offsets, mut columns, mut values) = std::mem::replace(csr, SymmetricCsr::empty())
            .into_csr()
            .into_raw_storage();
        offsets.clear();
        columns.clear();
        values.clear();
        offsets.push(0);
        for row in 0..m {
            let all = self.inner.columns(row);
            let inside = all.partition_point(|&column| (column as usize) < m);
            columns.extend_from_slice(&all[..inside]);
            values.extend_from_slice(&self.inner.values(row)[..inside]);
            offsets.push(u32::try_from(columns.len()).expect("fewer than 2³² entries"));
        }
        // Invariants 1 and 2 of the module, of the first rows and columns.
        *csr = SymmetricCsr::new_unchecked(CsMatI::new((m, m), offsets, columns, values));
    }

    /// The adjacency that `csr` describes, O(n + nnz).
    pub fn from_csr(csr: &SymmetricCsr) -> Self {
        let matrix = csr.as_csr();
        let offsets: Vec<usize> = matrix
            .indptr()
            .raw_storage()
            .iter()
            .map(|&end| end as usize)
            .collect();
        let (columns, weights) = (matrix.indices().to_vec(), matrix.data().to_vec());
        Self::from_symmetric_rows(SlackRows::from_sorted(&offsets, columns, weights))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::triangle_with_tail;
    use super::*;

    #[test]
    fn a_prefix_is_the_graph_as_it_was() {
        let mut graph = triangle_with_tail();
        graph.add_edge(4, 4, 2.0);
        let mut csr = SymmetricCsr::empty();
        for m in [5, 3, 0, 4] {
            graph.write_prefix_csr(m, &mut csr);
            let dense = |matrix: &SymmetricCsr| {
                (0..m)
                    .map(|i| (0..m).map(|j| matrix.as_csr().get(i, j).copied()).collect())
                    .collect()
            };
            let (prefix, whole): (Vec<Vec<_>>, Vec<Vec<_>>) = (dense(&csr), dense(&graph.to_csr()));
            assert_eq!((csr.num_nodes(), prefix), (m, whole));
            Adjacency::from_csr(&csr).assert_consistent();
        }
    }
}
