//! T̂ = D̃^-1/2 (A + I) D̃^-1/2 with D̃ the row sums of A + I: the renormalised adjacency of Kipf & Welling,
//! "Semi-Supervised Classification with Graph Convolutional Networks", ICLR 2017; source paper, eq. 5.
//!
//! T̂ is symmetric and its spectrum lies in (−1, 1]. An isolated node has T̂_ii = 1: it hears itself. A
//! self-loop of A adds to the one that I brings. Because T̂ᵀ = T̂, the same product serves the backward pass.

use super::rows::{pack, rows_per_lane, unpack};
use crate::graph::SymmetricCsr;
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// The matrix T̂ of a graph, n × n in compressed rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Propagation {
    /// n + 1 entries; row i is `offsets[i]..offsets[i + 1]`.
    offsets: Vec<usize>,
    /// Ascending inside a row; the diagonal is always present.
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Propagation {
    /// T̂ of an undirected graph; O(n + nnz).
    pub fn new(adjacency: &SymmetricCsr) -> Self {
        let mut propagation = Self::add_identity(adjacency);
        propagation.normalize();
        propagation
    }

    /// A + I, rows kept sorted.
    fn add_identity(adjacency: &SymmetricCsr) -> Self {
        let n = adjacency.num_nodes();
        let mut offsets = Vec::with_capacity(n + 1);
        let mut columns = Vec::with_capacity(adjacency.nnz() + n);
        let mut values = Vec::with_capacity(adjacency.nnz() + n);
        offsets.push(0);
        for i in 0..n {
            let (neighbors, weights) = adjacency.row(i);
            let diagonal = neighbors.partition_point(|&j| (j as usize) < i);
            let has_loop = neighbors.get(diagonal) == Some(&(i as u32));
            let rest = diagonal + usize::from(has_loop);
            columns.extend_from_slice(&neighbors[..diagonal]);
            values.extend_from_slice(&weights[..diagonal]);
            columns.push(i as u32);
            values.push(1.0 + if has_loop { weights[diagonal] } else { 0.0 });
            columns.extend_from_slice(&neighbors[rest..]);
            values.extend_from_slice(&weights[rest..]);
            offsets.push(columns.len());
        }
        Self {
            offsets,
            columns,
            values,
        }
    }

    /// D̃^-1/2 on both sides.
    fn normalize(&mut self) {
        let inverse_root: Vec<f64> = self
            .offsets
            .windows(2)
            .map(|row| {
                self.values[row[0]..row[1]]
                    .iter()
                    .sum::<f64>()
                    .sqrt()
                    .recip()
            })
            .collect();
        for (row, &left) in self.offsets.windows(2).zip(&inverse_root) {
            for entry in row[0]..row[1] {
                self.values[entry] *= left * inverse_root[self.columns[entry] as usize];
            }
        }
    }

    /// n, the number of nodes.
    pub fn num_nodes(&self) -> usize {
        self.offsets.len() - 1
    }

    /// T̂ X, n × f; O(nnz · f) and three n × f buffers. Rows run on rayon's threads.
    ///
    /// # Panics
    /// If `x` has not n rows.
    pub fn apply(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let rows = self.apply_packed(x);
        let mut product = Mat::zeros(x.nrows(), x.ncols());
        unpack(&rows, product.as_mut());
        product
    }

    /// T̂ X in row-major order.
    pub(super) fn apply_packed(&self, x: MatRef<'_, f64>) -> Vec<f64> {
        let mut source = vec![0.0; x.nrows() * x.ncols()];
        let mut target = source.clone();
        pack(x, &mut source);
        self.apply_rows(&source, x.ncols(), &mut target);
        target
    }

    /// y ← T̂ x for row-major n × f slices: the allocation-free form of [`Propagation::apply`].
    ///
    /// # Panics
    /// If a slice has not n · `columns` entries.
    pub fn apply_rows(&self, x: &[f64], columns: usize, y: &mut [f64]) {
        let n = self.num_nodes();
        assert_eq!(x.len(), n * columns, "x of the wrong length");
        assert_eq!(y.len(), n * columns, "y of the wrong length");
        if columns == 0 {
            return;
        }
        let lane_rows = rows_per_lane(n);
        if n <= lane_rows {
            return self.apply_lane(0, x, columns, y);
        }
        y.par_chunks_mut(lane_rows * columns)
            .enumerate()
            .for_each(|(lane, y)| self.apply_lane(lane * lane_rows, x, columns, y));
    }

    /// The rows from `first` on that `y` has room for.
    fn apply_lane(&self, first: usize, x: &[f64], columns: usize, y: &mut [f64]) {
        for (i, target) in y.chunks_exact_mut(columns).enumerate() {
            let entries = self.offsets[first + i]..self.offsets[first + i + 1];
            let row = SparseRow {
                columns: &self.columns[entries.clone()],
                values: &self.values[entries],
            };
            row.times(x, columns, target);
        }
    }
}

/// One row of T̂.
#[derive(Clone, Copy)]
struct SparseRow<'a> {
    columns: &'a [u32],
    values: &'a [f64],
}

impl SparseRow<'_> {
    /// `target` ← this row times x. Groups of 16, 8, 4, 2 and 1 columns, whose sums stay in registers.
    #[inline]
    fn times(self, x: &[f64], width: usize, target: &mut [f64]) {
        let mut first = 0;
        while first < width {
            first += match width - first {
                16.. => self.times_group::<16>(x, width, first, target),
                8.. => self.times_group::<8>(x, width, first, target),
                4.. => self.times_group::<4>(x, width, first, target),
                2.. => self.times_group::<2>(x, width, first, target),
                _ => self.times_group::<1>(x, width, first, target),
            };
        }
    }

    /// Columns `first..first + W`; returns W.
    #[inline]
    fn times_group<const W: usize>(
        self,
        x: &[f64],
        width: usize,
        first: usize,
        target: &mut [f64],
    ) -> usize {
        let mut sums = [0.0; W];
        for (&j, &value) in self.columns.iter().zip(self.values) {
            let start = j as usize * width + first;
            let source: &[f64; W] = x[start..start + W].try_into().expect("W entries");
            for (sum, &x) in sums.iter_mut().zip(source) {
                *sum += value * x;
            }
        }
        target[first..first + W].copy_from_slice(&sums);
        W
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dense twin, written from the definition.
    fn dense(adjacency: &SymmetricCsr) -> Mat<f64> {
        let n = adjacency.num_nodes();
        let tilde = Mat::from_fn(n, n, |i, j| {
            adjacency.as_csr().get(i, j).copied().unwrap_or(0.0) + f64::from(i == j)
        });
        let degree = |i: usize| (0..n).map(|j| tilde[(i, j)]).sum::<f64>();
        Mat::from_fn(n, n, |i, j| tilde[(i, j)] / (degree(i) * degree(j)).sqrt())
    }

    fn weighted(n: usize, edges: &[(usize, usize, f64)]) -> SymmetricCsr {
        let mut triplets = sprs::TriMatI::<f64, u32>::new((n, n));
        for &(i, j, w) in edges {
            triplets.add_triplet(i, j, w);
            if i != j {
                triplets.add_triplet(j, i, w);
            }
        }
        SymmetricCsr::new(triplets.to_csr()).unwrap()
    }

    #[test]
    fn product_equals_the_dense_one_for_every_width() {
        // Weights, a self-loop (1, 1) and an isolated node 4.
        let adjacency = weighted(5, &[(0, 1, 2.0), (1, 1, 0.5), (1, 2, 1.0), (0, 3, 1.5)]);
        let (propagation, oracle) = (Propagation::new(&adjacency), dense(&adjacency));
        for f in [0, 1, 2, 3, 5, 16, 31] {
            let x = Mat::from_fn(5, f, |i, j| ((7 * i + 3 * j) % 11) as f64 - 5.0);
            let error = (propagation.apply(x.as_ref()) - &oracle * &x).norm_max();
            assert!(error < 1e-14, "width {f}: {error}");
        }
    }

    #[test]
    fn isolated_node_keeps_its_value() {
        let propagation = Propagation::new(&weighted(3, &[(0, 1, 1.0)]));
        let x = Mat::from_fn(3, 1, |i, _| i as f64 + 1.0);
        assert_eq!(propagation.apply(x.as_ref())[(2, 0)], 3.0);
    }

    #[test]
    fn no_nodes_are_legal() {
        let propagation = Propagation::new(&weighted(0, &[]));
        assert_eq!(propagation.num_nodes(), 0);
        assert_eq!(propagation.apply(Mat::zeros(0, 4).as_ref()).ncols(), 4);
    }

    #[test]
    fn long_graphs_give_the_same_bits_on_one_thread_and_on_many() {
        let n = 10_000;
        let path: Vec<_> = (1..n).map(|i| (i - 1, i, 1.0)).collect();
        let propagation = Propagation::new(&weighted(n, &path));
        let x = Mat::from_fn(n, 3, |i, j| ((i * 31 + j * 17) % 101) as f64);
        let on = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads")
                .install(|| propagation.apply(x.as_ref()))
        };
        assert_eq!(on(1), on(4));
    }
}
