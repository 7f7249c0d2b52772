//! Between the adjacency that grows and the compact matrix that numerical code reads.

use super::{Adjacency, Csr};
use crate::graph::GraphError;
use crate::graph::slack_rows::SlackRows;

impl Adjacency {
    /// Compact copy, n × n, O(n + nnz).
    ///
    /// # Panics
    /// If there are 2³² entries or more, which the `u32` row offsets of [`Csr`] cannot count.
    pub fn to_csr(&self) -> Csr {
        self.prefix_csr(self.num_nodes())
    }

    /// The subgraph of the first `m` nodes, as it was when they had been discovered; m × m, O(m log d + nnz).
    ///
    /// # Panics
    /// If `m` exceeds the number of nodes; else as [`Self::to_csr`].
    pub fn prefix_csr(&self, m: usize) -> Csr {
        let mut csr = Csr::zero((0, 0));
        self.write_prefix_csr(m, &mut csr);
        csr
    }

    /// As [`Self::to_csr`], into the buffers of `csr`, whatever it held before; they grow only if they are too small.
    ///
    /// # Panics
    /// As [`Self::to_csr`].
    pub fn write_csr(&self, csr: &mut Csr) {
        self.write_prefix_csr(self.num_nodes(), csr);
    }

    /// As [`Self::prefix_csr`], into the buffers of `csr`.
    ///
    /// # Panics
    /// As [`Self::prefix_csr`].
    pub fn write_prefix_csr(&self, m: usize, csr: &mut Csr) {
        assert!(
            m <= self.num_nodes(),
            "a prefix of {m} nodes of a graph of {}",
            self.num_nodes()
        );
        let (mut offsets, mut columns, mut values) =
            std::mem::replace(csr, Csr::zero((0, 0))).into_raw_storage();
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
        *csr = Csr::new((m, m), offsets, columns, values);
    }

    /// The adjacency that `csr` describes, O(n + nnz log(nnz / n)).
    ///
    /// # Panics
    /// If it is not square, symmetric, sorted, finite and positive; [`Self::try_from_csr`] returns these as errors.
    pub fn from_csr(csr: &Csr) -> Self {
        match Self::try_from_csr(csr) {
            Ok(adjacency) => adjacency,
            Err(error) => panic!("{error}"),
        }
    }

    /// As [`Self::from_csr`], for a matrix from outside.
    ///
    /// # Errors
    /// The first broken rule in row-major order: [`GraphError::NotSquare`], [`GraphError::Weight`],
    /// [`GraphError::Asymmetric`], [`GraphError::DegreeOverflow`].
    pub fn try_from_csr(csr: &Csr) -> Result<Self, GraphError> {
        if csr.rows() != csr.cols() {
            return Err(GraphError::NotSquare {
                rows: csr.rows(),
                columns: csr.cols(),
            });
        }
        let offsets: Vec<usize> = csr
            .indptr()
            .raw_storage()
            .iter()
            .map(|&end| end as usize)
            .collect();
        let inner = SlackRows::from_sorted(&offsets, csr.indices().to_vec(), csr.data().to_vec());
        Self::from_rows(inner)
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
        let mut csr = Csr::zero((0, 0));
        for m in [5, 3, 0, 4] {
            graph.write_prefix_csr(m, &mut csr);
            let dense = |matrix: &Csr| {
                (0..m)
                    .map(|i| (0..m).map(|j| matrix.get(i, j).copied()).collect())
                    .collect()
            };
            let (prefix, whole): (Vec<Vec<_>>, Vec<Vec<_>>) = (dense(&csr), dense(&graph.to_csr()));
            assert_eq!((csr.shape(), prefix), ((m, m), whole));
            Adjacency::from_csr(&csr).assert_consistent();
        }
    }

    #[test]
    fn a_matrix_from_outside_is_checked() {
        let check = |n, offsets: &[u32], columns: &[u32], values: &[f64]| {
            Adjacency::try_from_csr(&Csr::new(
                n,
                offsets.to_vec(),
                columns.to_vec(),
                values.to_vec(),
            ))
            .unwrap_err()
        };
        assert!(matches!(
            check((1, 2), &[0, 0], &[], &[]),
            GraphError::NotSquare {
                rows: 1,
                columns: 2
            }
        ));
        assert!(matches!(
            check((2, 2), &[0, 1, 1], &[1], &[3.0]),
            GraphError::Asymmetric {
                row: 0,
                column: 1,
                mirrored: 0.0,
                ..
            }
        ));
        assert!(matches!(
            check((2, 2), &[0, 1, 2], &[1, 0], &[1.0, 2.0]),
            GraphError::Asymmetric { .. }
        ));
        assert!(matches!(
            check((1, 1), &[0, 1], &[0], &[f64::NAN]),
            GraphError::Weight { .. }
        ));
    }
}
