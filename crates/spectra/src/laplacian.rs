//! The Laplacian of a weighted graph, as an operator that never forms the matrix.
//!
//! With the symmetric adjacency W ≥ 0 and degrees d_i = Σ_j W_ij (a self-loop counts once):
//!
//! - normalised: L_sym = I − D^-1/2 W D^-1/2, spectrum in \[0, 2\];
//! - combinatorial: L = D − W, spectrum in \[0, 2 max d\].
//!
//! An isolated node, whose D^-1/2 does not exist, has a zero row: eigenvalue 0. Both have exactly
//! one zero eigenvalue per connected component C, with the eigenvector D^1/2 1_C (normalised) or 1_C
//! (Chung, *Spectral Graph Theory*, 1997, section 1.2).

use crate::{LaplacianKind, SymmetricCsr, SymmetricOperator};
use faer::{Mat, MatMut, MatRef};

/// The Laplacian of an undirected graph, with what its entries need.
#[derive(Clone, Debug)]
pub struct Laplacian<'a> {
    adjacency: &'a SymmetricCsr,
    kind: LaplacianKind,
    degrees: Vec<f64>,
    /// d_i^-1/2 (normalised; 0 for an isolated node) or 1.
    inverse_scale: Vec<f64>,
}

impl<'a> Laplacian<'a> {
    /// The Laplacian of `adjacency`. Cost: O(n + nnz).
    pub fn new(adjacency: &'a SymmetricCsr, kind: LaplacianKind) -> Self {
        let degree = |i: usize| adjacency.row(i).1.iter().sum();
        let degrees: Vec<f64> = (0..adjacency.num_nodes()).map(degree).collect();
        let inverse_scale = degrees
            .iter()
            .map(|&d| match kind {
                LaplacianKind::Combinatorial => 1.0,
                LaplacianKind::Normalized if d > 0.0 => d.sqrt().recip(),
                LaplacianKind::Normalized => 0.0,
            })
            .collect();
        Self {
            adjacency,
            kind,
            degrees,
            inverse_scale,
        }
    }

    /// Neighbours of node `i`, sorted, and the weights of the edges to them.
    pub(crate) fn row(&self, i: usize) -> (&'a [u32], &'a [f64]) {
        self.adjacency.row(i)
    }

    /// The factor between an eigenvector x and the function on nodes y = x / scale that varies
    /// slowly over the graph: d_i^1/2 (normalised) or 1; 1 for an isolated node.
    pub(crate) fn scale(&self, i: usize) -> f64 {
        match self.kind {
            LaplacianKind::Normalized if self.degrees[i] > 0.0 => self.degrees[i].sqrt(),
            _ => 1.0,
        }
    }

    /// L_ij for the edge {i, j}, i ≠ j, of weight `weight`.
    pub(crate) fn off_diagonal(&self, i: usize, j: usize, weight: f64) -> f64 {
        -weight * self.inverse_scale[i] * self.inverse_scale[j]
    }

    /// L_ii.
    pub(crate) fn diagonal(&self, i: usize) -> f64 {
        let (neighbors, weights) = self.row(i);
        let own = neighbors
            .binary_search(&(i as u32))
            .map_or(0.0, |at| weights[at]);
        (self.degrees[i] - own) * self.inverse_scale[i] * self.inverse_scale[i]
    }

    /// An upper bound of the largest eigenvalue.
    pub(crate) fn norm_bound(&self) -> f64 {
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
        self.adjacency.num_nodes()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::from_weighted_edges as graph;

    #[test]
    fn rows_of_isolated_nodes_and_lone_loops_are_zero() {
        let g = graph(4, &[(0, 1, 2.0), (2, 2, 5.0)]);
        for kind in [LaplacianKind::Normalized, LaplacianKind::Combinatorial] {
            let dense = Laplacian::new(&g, kind).to_dense();
            for j in 0..4 {
                assert_eq!(dense[(2, j)], 0.0);
                assert_eq!(dense[(3, j)], 0.0);
            }
        }
    }

    #[test]
    fn a_loop_counts_once_in_the_degree() {
        let g = graph(2, &[(0, 1, 1.0), (0, 0, 3.0)]);
        let l = Laplacian::new(&g, LaplacianKind::Normalized);
        let dense = l.to_dense();
        assert!((dense[(0, 0)] - 0.25).abs() < 1e-15, "1 − 3/4");
        assert!((dense[(0, 1)] + 0.5).abs() < 1e-15, "−1/√4");
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
            let l = Laplacian::new(&g, kind);
            let x = Mat::from_fn(5, 3, |i, j| (i * 3 + j) as f64 - 6.5);
            let mut y = Mat::zeros(5, 3);
            l.apply(x.as_ref(), y.as_mut());
            let difference = y - l.to_dense() * x;
            assert!(difference.norm_max() < 1e-13);
        }
    }
}
