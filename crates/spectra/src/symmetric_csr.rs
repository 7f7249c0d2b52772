//! The matrix of an undirected graph, with its guarantee in the type.

use crate::SpectralError;
use sprs::CsMatI;

/// A symmetric matrix with positive weights, by rows: the adjacency of an undirected graph.
///
/// 1. It is square, and entry (i, j) is stored if and only if (j, i) is, with the same weight;
/// 2. weights are finite and positive, and so are their sums by rows;
/// 3. the columns of a row increase strictly.
///
/// [`SymmetricCsr::new`] checks that of a matrix from outside; what holds one need not check it again.
///
/// ```
/// use eigentrail_spectra::{SpectralError, SymmetricCsr, sprs::TriMatI};
///
/// let mut edge = TriMatI::<f64, u32>::new((2, 2));
/// edge.add_triplet(0, 1, 0.5);
/// let one_way = SymmetricCsr::new(edge.to_csr());
/// assert_eq!(one_way, Err(SpectralError::Asymmetric { row: 0, column: 1 }));
/// edge.add_triplet(1, 0, 0.5);
/// let graph = SymmetricCsr::new(edge.to_csr())?;
/// assert_eq!((graph.num_nodes(), graph.row(1)), (2, (&[0][..], &[0.5][..])));
/// # Ok::<(), SpectralError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricCsr(CsMatI<f64, u32>);

impl SymmetricCsr {
    /// A matrix from outside, checked. One stored by columns is turned first. Cost: O(n + nnz).
    ///
    /// # Errors
    /// [`SpectralError::NotSquare`]; [`SpectralError::Weight`] for a weight that is not finite and positive, an
    /// explicit zero included; [`SpectralError::Degree`] for a row sum that overflows;
    /// [`SpectralError::Asymmetric`] with the first entry that has no equal partner.
    pub fn new(matrix: CsMatI<f64, u32>) -> Result<Self, SpectralError> {
        let matrix = match matrix.is_csr() {
            true => matrix,
            false => matrix.to_csr(),
        };
        check(&matrix)?;
        Ok(Self(matrix))
    }

    /// A matrix of which the caller guarantees all that [`SymmetricCsr::new`] checks. That is checked in
    /// debug builds only; with a matrix that breaks it results mean nothing, and later calls may panic.
    pub fn new_unchecked(matrix: CsMatI<f64, u32>) -> Self {
        debug_assert!(matrix.is_csr(), "stored by rows");
        debug_assert_eq!(check(&matrix), Ok(()));
        Self(matrix)
    }

    /// The graph without nodes.
    pub fn empty() -> Self {
        Self(CsMatI::zero((0, 0)))
    }

    /// Number of nodes n.
    pub fn num_nodes(&self) -> usize {
        self.0.rows()
    }

    /// Stored entries: two for an edge, one for a self-loop.
    pub fn nnz(&self) -> usize {
        self.0.nnz()
    }

    /// Undirected edges; a self-loop counts once. Cost: O(n log degree).
    pub fn num_edges(&self) -> usize {
        let is_loop = |&i: &usize| self.row(i).0.binary_search(&(i as u32)).is_ok();
        let loops = (0..self.num_nodes()).filter(is_loop).count();
        (self.nnz() + loops) / 2
    }

    /// Neighbours of node `i`, ascending (itself if it has a loop), and the weights of the edges to them.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn row(&self, i: usize) -> (&[u32], &[f64]) {
        let range = self.0.indptr().outer_inds_sz(i);
        (&self.0.indices()[range.clone()], &self.0.data()[range])
    }

    /// The subgraph of the first `m` nodes: where rows are in order of discovery, the graph as it was then.
    /// Cost: O(m + its entries).
    ///
    /// # Panics
    /// If there are fewer than `m` nodes.
    pub fn leading_block(&self, m: usize) -> Self {
        let mut starts = Vec::with_capacity(m + 1);
        starts.push(0u32);
        let mut columns = Vec::new();
        let mut weights = Vec::new();
        for i in 0..m {
            let (neighbors, all) = self.row(i);
            let inside = neighbors.partition_point(|&j| (j as usize) < m);
            columns.extend_from_slice(&neighbors[..inside]);
            weights.extend_from_slice(&all[..inside]);
            starts.push(columns.len() as u32);
        }
        Self(CsMatI::new((m, m), starts, columns, weights))
    }

    /// The plain matrix, to look at.
    pub fn as_csr(&self) -> &CsMatI<f64, u32> {
        &self.0
    }

    /// The plain matrix.
    pub fn into_csr(self) -> CsMatI<f64, u32> {
        self.0
    }
}

fn check(matrix: &CsMatI<f64, u32>) -> Result<(), SpectralError> {
    let (rows, columns) = matrix.shape();
    if rows != columns {
        return Err(SpectralError::NotSquare { rows, columns });
    }
    check_weights(matrix)?;
    check_symmetric(matrix)
}

fn check_weights(matrix: &CsMatI<f64, u32>) -> Result<(), SpectralError> {
    for row in 0..matrix.rows() {
        let range = matrix.indptr().outer_inds_sz(row);
        let weights = &matrix.data()[range.clone()];
        if let Some(at) = weights.iter().position(|&w| !(w.is_finite() && w > 0.0)) {
            return Err(SpectralError::Weight {
                row,
                column: matrix.indices()[range.start + at] as usize,
                value: weights[at],
            });
        }
        let value = weights.iter().sum::<f64>();
        if !value.is_finite() {
            return Err(SpectralError::Degree { row, value });
        }
    }
    Ok(())
}

/// Walks the rows once with a cursor in every row: in a symmetric matrix with sorted columns the
/// entries (j, i) of row j turn up in the very order in which rows i mention column j.
///
/// Cost: O(n + nnz) time, O(n) memory.
fn check_symmetric(matrix: &CsMatI<f64, u32>) -> Result<(), SpectralError> {
    let starts = matrix.indptr();
    let mut cursor: Vec<usize> = (0..matrix.rows())
        .map(|i| starts.outer_inds_sz(i).start)
        .collect();
    for row in 0..matrix.rows() {
        for at in starts.outer_inds_sz(row) {
            let column = matrix.indices()[at] as usize;
            let partner = cursor[column];
            let found = partner < starts.outer_inds_sz(column).end
                && matrix.indices()[partner] as usize == row
                && matrix.data()[partner] == matrix.data()[at];
            if !found {
                return Err(SpectralError::Asymmetric { row, column });
            }
            cursor[column] += 1;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use sprs::TriMatI;

    fn matrix(shape: (usize, usize), entries: &[(usize, usize, f64)]) -> CsMatI<f64, u32> {
        let mut triplets: TriMatI<f64, u32> = TriMatI::new(shape);
        for &(i, j, w) in entries {
            triplets.add_triplet(i, j, w);
        }
        triplets.to_csr()
    }

    fn path(first: f64, second: f64) -> CsMatI<f64, u32> {
        let edges = [(0, 1, first), (1, 0, first), (1, 2, second), (2, 1, second)];
        matrix((3, 3), &edges)
    }

    #[test]
    fn bad_weights_are_named_with_their_place() {
        for value in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
            match SymmetricCsr::new(path(1.0, value)) {
                Err(SpectralError::Weight { row, column, .. }) => assert_eq!((row, column), (1, 2)),
                other => panic!("{value}: {other:?}"),
            }
        }
        assert!(matches!(
            SymmetricCsr::new(path(1e308, 1e308)),
            Err(SpectralError::Degree { row: 1, .. })
        ));
    }

    #[test]
    fn asymmetry_of_pattern_or_value_is_found() {
        assert!(SymmetricCsr::new(path(1.0, 2.0)).is_ok());
        for (entries, row, column) in [
            (&[(0, 1, 1.0)][..], 0, 1),
            (&[(1, 0, 1.0)], 1, 0),
            (&[(0, 1, 1.0), (1, 0, 2.0)], 0, 1),
            (&[(0, 1, 1.0), (1, 0, 1.0), (2, 0, 1.0)], 2, 0),
        ] {
            assert_eq!(
                SymmetricCsr::new(matrix((3, 3), entries)),
                Err(SpectralError::Asymmetric { row, column })
            );
        }
    }

    #[test]
    fn the_shape_is_checked_and_the_storage_does_not_matter() {
        assert_eq!(
            SymmetricCsr::new(matrix((2, 3), &[(0, 1, 1.0), (1, 0, 1.0)])),
            Err(SpectralError::NotSquare {
                rows: 2,
                columns: 3
            })
        );
        let by_columns = path(1.0, 2.0).to_csc();
        assert_eq!(
            SymmetricCsr::new(by_columns),
            SymmetricCsr::new(path(1.0, 2.0))
        );
        assert_eq!(SymmetricCsr::empty().num_nodes(), 0);
    }

    #[test]
    #[should_panic(expected = "Asymmetric")]
    #[cfg(debug_assertions)]
    fn a_broken_guarantee_is_noticed_in_debug_builds() {
        SymmetricCsr::new_unchecked(matrix((2, 2), &[(0, 1, 1.0)]));
    }

    #[test]
    fn a_loop_is_one_edge() {
        let graph = matrix((2, 2), &[(0, 0, 3.0), (0, 1, 1.0), (1, 0, 1.0)]);
        let graph = SymmetricCsr::new(graph).unwrap();
        assert_eq!((graph.num_edges(), graph.nnz()), (2, 3));
    }

    #[test]
    fn a_leading_block_is_the_subgraph() {
        let graph = testing::shuffled(&testing::grid(5, 5), 3);
        for m in [0, 1, 7, 25] {
            assert_eq!(graph.leading_block(m), testing::prefix(&graph, m));
        }
    }
}
