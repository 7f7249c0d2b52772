//! Smoothness of node values on a graph: tr(VᵀLV) / |E| = Σ_{{i,j} ∈ E} w_ij ‖V_i − V_j‖² / |E|, L = D − A.
//!
//! It takes A rather than L: differences V_i − V_j need no subtraction of large terms, the energy cannot come
//! out negative, and self-loops drop out by themselves. |E| counts undirected edges without self-loops.

use super::rows::{MAX_LANES, num_lanes, rows_per_lane};
use crate::graph::SymmetricCsr;
use rayon::prelude::*;

/// The quadratic form V ↦ tr(VᵀLV) / |E| of one graph.
#[derive(Clone, Copy, Debug)]
pub struct Smoothness<'a> {
    adjacency: &'a SymmetricCsr,
    /// Undirected, self-loops not counted.
    num_edges: usize,
}

impl<'a> Smoothness<'a> {
    /// Counts the edges; O(nnz).
    pub fn new(adjacency: &'a SymmetricCsr) -> Self {
        let above = |i: usize| {
            let neighbors = adjacency.row(i).0.iter();
            neighbors.filter(|&&j| j as usize > i).count()
        };
        Self {
            adjacency,
            num_edges: (0..adjacency.num_nodes()).map(above).sum(),
        }
    }

    /// tr(VᵀLV) / |E| for the row-major n × `columns` slice `values`; sets `gradient` to (2 / |E|) L V.
    /// Both are 0 on a graph without edges. O(nnz · columns), no allocation.
    ///
    /// # Panics
    /// If a slice has not n · `columns` entries.
    pub fn evaluate(&self, values: &[f64], columns: usize, gradient: &mut [f64]) -> f64 {
        let n = self.adjacency.num_nodes();
        assert_eq!(values.len(), n * columns, "values of the wrong length");
        assert_eq!(gradient.len(), n * columns, "gradient of the wrong length");
        if self.num_edges == 0 || columns == 0 {
            gradient.fill(0.0);
            return 0.0;
        }
        let rows = rows_per_lane(n);
        let mut energies = [0.0; MAX_LANES];
        if n <= rows {
            energies[0] = self.evaluate_lane(0, values, columns, gradient);
        } else {
            energies[..num_lanes(n)]
                .par_iter_mut()
                .zip(gradient.par_chunks_mut(rows * columns))
                .enumerate()
                .for_each(|(lane, (energy, gradient))| {
                    *energy = self.evaluate_lane(lane * rows, values, columns, gradient);
                });
        }
        // Every edge was met from both of its ends.
        energies.iter().sum::<f64>() / (2.0 * self.num_edges as f64)
    }

    /// Σ_ij w_ij ‖V_i − V_j‖² over the rows from `first` on that `gradient` has room for.
    fn evaluate_lane(
        &self,
        first: usize,
        values: &[f64],
        columns: usize,
        gradient: &mut [f64],
    ) -> f64 {
        let scale = 2.0 / self.num_edges as f64;
        let mut energy = 0.0;
        for (local, target) in gradient.chunks_exact_mut(columns).enumerate() {
            let i = first + local;
            let (neighbors, weights) = self.adjacency.row(i);
            let row = Row { neighbors, weights };
            energy += row.evaluate(i, values, columns, target);
            target.iter_mut().for_each(|value| *value *= scale);
        }
        energy
    }
}

/// One row of the adjacency.
#[derive(Clone, Copy)]
struct Row<'a> {
    neighbors: &'a [u32],
    weights: &'a [f64],
}

impl Row<'_> {
    /// Σ_j w_ij ‖V_i − V_j‖²; `target` ← Σ_j w_ij (V_i − V_j). Two columns at a time, then one.
    #[inline]
    fn evaluate(self, i: usize, values: &[f64], width: usize, target: &mut [f64]) -> f64 {
        let (mut energy, mut first) = (0.0, 0);
        while first + 2 <= width {
            energy += self.evaluate_group::<2>(i, values, width, first, target);
            first += 2;
        }
        if first < width {
            energy += self.evaluate_group::<1>(i, values, width, first, target);
        }
        energy
    }

    #[inline]
    fn evaluate_group<const W: usize>(
        self,
        i: usize,
        values: &[f64],
        width: usize,
        first: usize,
        target: &mut [f64],
    ) -> f64 {
        let at = |node: usize| -> &[f64; W] {
            let start = node * width + first;
            values[start..start + W].try_into().expect("W entries")
        };
        let own = at(i);
        let (mut sums, mut energies) = ([0.0; W], [0.0; W]);
        for (&j, &weight) in self.neighbors.iter().zip(self.weights) {
            let other = at(j as usize);
            for k in 0..W {
                let difference = own[k] - other[k];
                sums[k] += weight * difference;
                energies[k] += weight * difference * difference;
            }
        }
        target[first..first + W].copy_from_slice(&sums);
        energies.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn energy_and_gradient_equal_those_of_the_dense_laplacian() {
        // Weighted triangle with a pendant, a self-loop on node 1 and an isolated node 4.
        let edges = [(0, 1, 2.0), (1, 2, 0.5), (0, 2, 1.0), (2, 3, 3.0)];
        let mut triplets = sprs::TriMatI::<f64, u32>::new((5, 5));
        let mut laplacian = Mat::<f64>::zeros(5, 5);
        triplets.add_triplet(1, 1, 7.0);
        for (i, j, w) in edges {
            for (i, j) in [(i, j), (j, i)] {
                triplets.add_triplet(i, j, w);
                laplacian[(i, j)] -= w;
                laplacian[(i, i)] += w;
            }
        }
        let adjacency = SymmetricCsr::new(triplets.to_csr()).unwrap();
        let smoothness = Smoothness::new(&adjacency);
        assert_eq!(smoothness.num_edges, 4);
        for c in [1, 2, 3, 5] {
            let values: Vec<f64> = (0..5 * c).map(|i| ((7 * i) % 11) as f64 - 4.0).collect();
            let mut gradient = vec![f64::NAN; 5 * c];
            let energy = smoothness.evaluate(&values, c, &mut gradient);
            let v = Mat::from_fn(5, c, |i, j| values[i * c + j]);
            let lv = &laplacian * &v;
            let trace: f64 = (0..c).map(|j| v.col(j).transpose() * lv.col(j)).sum();
            assert!((energy - trace / 4.0).abs() < 1e-13 * trace);
            for i in 0..5 {
                for j in 0..c {
                    assert!((gradient[i * c + j] - 0.5 * lv[(i, j)]).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn a_graph_without_edges_is_perfectly_smooth() {
        let mut triplets = sprs::TriMatI::<f64, u32>::new((2, 2));
        triplets.add_triplet(0, 0, 1.0);
        let adjacency = SymmetricCsr::new(triplets.to_csr()).unwrap();
        let mut gradient = [f64::NAN; 2];
        let energy = Smoothness::new(&adjacency).evaluate(&[1.0, -1.0], 1, &mut gradient);
        assert_eq!((energy, gradient), (0.0, [0.0, 0.0]));
    }
}
