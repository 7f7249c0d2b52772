//! The Laplacian of a weighted graph, as an operator that never forms the matrix.
//!
//! With the symmetric adjacency W ≥ 0 and degrees d_i = Σ_j W_ij (a self-loop counts once):
//!
//! - normalised (eq. 14 of the source report): L_sym = I − D^-1/2 W D^-1/2, spectrum in \[0, 2\];
//! - combinatorial (eq. 6): L = D − W, spectrum in \[0, 2 max d\].
//!
//! An isolated node, whose D^-1/2 does not exist, has a zero row: eigenvalue 0. Both have exactly
//! one zero eigenvalue per connected component C, with the eigenvector D^1/2 1_C (normalised) or 1_C
//! (Chung, *Spectral Graph Theory*, 1997, section 1.2).

use super::{LaplacianKind, SpectralError, SymmetricOperator};
use crate::graph::Csr;
use faer::{Mat, MatMut, MatRef};

/// A checked adjacency with what its Laplacian needs.
#[derive(Clone, Debug)]
pub struct Laplacian<'a> {
    adjacency: &'a Csr,
    kind: LaplacianKind,
    degrees: Vec<f64>,
    /// d_i^-1/2 (normalised; 0 for an isolated node) or 1.
    inverse_scale: Vec<f64>,
}

impl<'a> Laplacian<'a> {
    /// The Laplacian of `adjacency`, which must be symmetric and hold no explicit zero.
    ///
    /// # Errors
    /// [`SpectralError::Weight`] for a weight that is not finite and positive,
    /// [`SpectralError::Degree`] for a row sum that overflows.
    ///
    /// # Panics
    /// If `adjacency` is not square or not stored by rows.
    ///
    /// Cost: O(n + nnz). Symmetry is not checked: see [`check_symmetric`].
    pub fn new(adjacency: &'a Csr, kind: LaplacianKind) -> Result<Self, SpectralError> {
        assert!(adjacency.is_csr(), "adjacency must be stored by rows");
        assert_eq!(
            adjacency.rows(),
            adjacency.cols(),
            "adjacency must be square"
        );
        let degrees = degrees(adjacency)?;
        let inverse_scale = degrees
            .iter()
            .map(|&d| match kind {
                LaplacianKind::Combinatorial => 1.0,
                LaplacianKind::Normalized if d > 0.0 => d.sqrt().recip(),
                LaplacianKind::Normalized => 0.0,
            })
            .collect();
        Ok(Self {
            adjacency,
            kind,
            degrees,
            inverse_scale,
        })
    }

    /// Undirected edges; a self-loop counts once.
    pub fn num_edges(&self) -> usize {
        let loops = (0..self.dim())
            .filter(|&i| self.row(i).0.binary_search(&(i as u32)).is_ok())
            .count();
        (self.adjacency.nnz() + loops) / 2
    }

    /// Neighbours of node `i`, sorted, and the weights of the edges to them.
    pub(super) fn row(&self, i: usize) -> (&'a [u32], &'a [f64]) {
        let range = self.adjacency.indptr().outer_inds_sz(i);
        (
            &self.adjacency.indices()[range.clone()],
            &self.adjacency.data()[range],
        )
    }

    /// The factor between an eigenvector x and the function on nodes y = x / scale that varies
    /// slowly over the graph: d_i^1/2 (normalised) or 1; 1 for an isolated node.
    pub(super) fn scale(&self, i: usize) -> f64 {
        match self.kind {
            LaplacianKind::Normalized if self.degrees[i] > 0.0 => self.degrees[i].sqrt(),
            _ => 1.0,
        }
    }

    /// L_ij for the edge {i, j}, i ≠ j, of weight `weight`.
    pub(super) fn off_diagonal(&self, i: usize, j: usize, weight: f64) -> f64 {
        -weight * self.inverse_scale[i] * self.inverse_scale[j]
    }

    /// L_ii.
    pub(super) fn diagonal(&self, i: usize) -> f64 {
        let (neighbors, weights) = self.row(i);
        let own = neighbors
            .binary_search(&(i as u32))
            .map_or(0.0, |at| weights[at]);
        (self.degrees[i] - own) * self.inverse_scale[i] * self.inverse_scale[i]
    }

    /// An upper bound of the largest eigenvalue.
    pub(super) fn norm_bound(&self) -> f64 {
        match self.kind {
            LaplacianKind::Normalized => 2.0,
            LaplacianKind::Combinatorial => {
                2.0 * self.degrees.iter().fold(0.0, |a: f64, &d| a.max(d))
            }
        }
    }

    /// The matrix itself, n × n. Cost: O(n²) memory.
    pub fn to_dense(&self) -> Mat<f64> {
        let mut dense = Mat::zeros(self.dim(), self.dim());
        for i in 0..self.dim() {
            let (neighbors, weights) = self.row(i);
            for (&j, &w) in neighbors.iter().zip(weights) {
                dense[(i, j as usize)] = self.off_diagonal(i, j as usize, w);
            }
            dense[(i, i)] = self.diagonal(i);
        }
        dense
    }
}

impl SymmetricOperator for Laplacian<'_> {
    fn dim(&self) -> usize {
        self.adjacency.rows()
    }

    /// Cost: O(nnz) per column.
    fn apply(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        assert_eq!(x.nrows(), self.dim(), "x must have one row per node");
        assert_eq!(
            (x.nrows(), x.ncols()),
            (y.nrows(), y.ncols()),
            "x and y must have one shape"
        );
        for i in 0..self.dim() {
            let (neighbors, weights) = self.row(i);
            let diagonal = self.diagonal(i);
            for c in 0..x.ncols() {
                let mut sum = diagonal * x[(i, c)];
                for (&j, &w) in neighbors.iter().zip(weights) {
                    if j as usize != i {
                        sum += self.off_diagonal(i, j as usize, w) * x[(j as usize, c)];
                    }
                }
                y[(i, c)] = sum;
            }
        }
    }
}

fn degrees(adjacency: &Csr) -> Result<Vec<f64>, SpectralError> {
    let mut degrees = Vec::with_capacity(adjacency.rows());
    for row in 0..adjacency.rows() {
        let range = adjacency.indptr().outer_inds_sz(row);
        let weights = &adjacency.data()[range.clone()];
        if let Some(at) = weights.iter().position(|&w| !(w.is_finite() && w > 0.0)) {
            return Err(SpectralError::Weight {
                row,
                column: adjacency.indices()[range.start + at] as usize,
                value: weights[at],
            });
        }
        let value = weights.iter().sum::<f64>();
        if !value.is_finite() {
            return Err(SpectralError::Degree { row, value });
        }
        degrees.push(value);
    }
    Ok(degrees)
}

/// Checks that `matrix` equals its transpose, entry by entry.
///
/// Walks the rows once with a cursor in every row: in a symmetric matrix with sorted columns the
/// entries (j, i) of row j turn up in the very order in which rows i mention column j.
///
/// # Errors
/// [`SpectralError::Asymmetric`] with the first entry that has no equal partner.
///
/// # Panics
/// If `matrix` is not square or not stored by rows.
///
/// Cost: O(n + nnz) time, O(n) memory.
pub fn check_symmetric(matrix: &Csr) -> Result<(), SpectralError> {
    assert!(
        matrix.is_csr() && matrix.rows() == matrix.cols(),
        "matrix must be square and stored by rows"
    );
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
    use sprs::TriMatI;

    fn graph(n: usize, edges: &[(usize, usize, f64)]) -> Csr {
        let mut triplets: TriMatI<f64, u32> = TriMatI::new((n, n));
        for &(u, v, w) in edges {
            triplets.add_triplet(u, v, w);
            if u != v {
                triplets.add_triplet(v, u, w);
            }
        }
        triplets.to_csr()
    }

    #[test]
    fn rows_of_isolated_nodes_and_lone_loops_are_zero() {
        let g = graph(4, &[(0, 1, 2.0), (2, 2, 5.0)]);
        for kind in [LaplacianKind::Normalized, LaplacianKind::Combinatorial] {
            let dense = Laplacian::new(&g, kind).unwrap().to_dense();
            for j in 0..4 {
                assert_eq!(dense[(2, j)], 0.0);
                assert_eq!(dense[(3, j)], 0.0);
            }
        }
    }

    #[test]
    fn a_loop_counts_once_in_the_degree() {
        let g = graph(2, &[(0, 1, 1.0), (0, 0, 3.0)]);
        let l = Laplacian::new(&g, LaplacianKind::Normalized).unwrap();
        let dense = l.to_dense();
        assert!((dense[(0, 0)] - 0.25).abs() < 1e-15, "1 − 3/4");
        assert!((dense[(0, 1)] + 0.5).abs() < 1e-15, "−1/√4");
        assert_eq!(l.num_edges(), 2);
    }

    #[test]
    fn operator_equals_its_dense_matrix() {
        let g = graph(
            5,
            &[
                (0, 1, 1.0),
                (1, 2, 0.5),
                (2, 0, 2.0),
                (3, 3, 1.5),
                (1, 3, 0.25),
            ],
        );
        for kind in [LaplacianKind::Normalized, LaplacianKind::Combinatorial] {
            let l = Laplacian::new(&g, kind).unwrap();
            let x = Mat::from_fn(5, 3, |i, j| (i * 3 + j) as f64 - 6.5);
            let mut y = Mat::zeros(5, 3);
            l.apply(x.as_ref(), y.as_mut());
            let difference = y - l.to_dense() * x;
            assert!(difference.norm_max() < 1e-13);
        }
    }

    #[test]
    fn bad_weights_are_named_with_their_place() {
        for value in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
            let g = graph(3, &[(0, 1, 1.0), (1, 2, value)]);
            match Laplacian::new(&g, LaplacianKind::Normalized) {
                Err(SpectralError::Weight { row, column, .. }) => assert_eq!((row, column), (1, 2)),
                other => panic!("{value}: {other:?}"),
            }
        }
        let huge = graph(3, &[(0, 1, 1e308), (1, 2, 1e308)]);
        assert!(matches!(
            Laplacian::new(&huge, LaplacianKind::Normalized),
            Err(SpectralError::Degree { row: 1, .. })
        ));
    }

    #[test]
    fn asymmetry_of_pattern_or_value_is_found() {
        assert_eq!(
            check_symmetric(&graph(3, &[(0, 1, 1.0), (2, 2, 1.0)])),
            Ok(())
        );
        let lopsided = |entries: &[(usize, usize, f64)]| {
            let mut t: TriMatI<f64, u32> = TriMatI::new((3, 3));
            for &(i, j, w) in entries {
                t.add_triplet(i, j, w);
            }
            check_symmetric(&t.to_csr())
        };
        assert!(lopsided(&[(0, 1, 1.0)]).is_err());
        assert!(lopsided(&[(1, 0, 1.0)]).is_err());
        assert!(lopsided(&[(0, 1, 1.0), (1, 0, 2.0)]).is_err());
        assert!(lopsided(&[(0, 1, 1.0), (1, 0, 1.0), (2, 0, 1.0)]).is_err());
    }
}
