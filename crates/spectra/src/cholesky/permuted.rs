//! The Laplacian written out in elimination order: what products and factorisations read.

use super::elimination::EliminationOrder;
use crate::block::RowBlock;
use crate::block::simd::{self, Panel, PanelKernel};
use crate::{Laplacian, SymmetricOperator};
use pulp::Simd;
use rayon::prelude::*;
use std::ops::Range;

/// L with rows and columns in elimination order, by rows with sorted columns; every diagonal entry
/// is present.
#[derive(Debug, Default)]
pub(crate) struct PermutedLaplacian {
    starts: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
    /// Where in `columns` each row's diagonal entry is.
    diagonals: Vec<u32>,
}

impl PermutedLaplacian {
    /// Writes `laplacian` out in `order`, reusing memory. Cost: O(n + nnz), and the sorting of rows.
    pub(crate) fn assign(
        &mut self,
        laplacian: &Laplacian<'_>,
        order: &EliminationOrder,
        threads: usize,
    ) {
        let n = laplacian.dim();
        self.count(laplacian, order);
        let length = self.starts[n] as usize;
        self.columns.resize(length, 0);
        self.values.resize(length, 0.0);
        self.diagonals.resize(n, 0);
        let stretches = self.stretches();
        let write = |stretch: Stretch<'_>| stretch.write(laplacian, order);
        if threads > 1 {
            stretches.into_par_iter().for_each(write);
        } else {
            stretches.into_iter().for_each(write);
        }
    }

    /// Stretches of rows with their parts of the arrays.
    fn stretches(&mut self) -> Vec<Stretch<'_>> {
        let n = self.diagonals.len();
        let (mut columns, mut values) = (&mut self.columns[..], &mut self.values[..]);
        let diagonals = self.diagonals.chunks_mut(simd::STRETCH).enumerate();
        let stretch = |(s, diagonals)| {
            let first = s * simd::STRETCH;
            let starts = &self.starts[first..n.min(first + simd::STRETCH) + 1];
            let length = (starts[starts.len() - 1] - starts[0]) as usize;
            let (own_columns, after) = std::mem::take(&mut columns).split_at_mut(length);
            columns = after;
            let (own_values, after) = std::mem::take(&mut values).split_at_mut(length);
            values = after;
            Stretch {
                first,
                starts,
                diagonals,
                columns: own_columns,
                values: own_values,
            }
        };
        diagonals.map(stretch).collect()
    }

    fn count(&mut self, laplacian: &Laplacian<'_>, order: &EliminationOrder) {
        self.starts.clear();
        self.starts.push(0);
        let mut end = 0;
        for &u in &order.node {
            let neighbors = laplacian.row(u as usize).0;
            let has_loop = neighbors.binary_search(&u).is_ok();
            end += neighbors.len() as u32 + u32::from(!has_loop);
            self.starts.push(end);
        }
    }

    pub(crate) fn dim(&self) -> usize {
        self.diagonals.len()
    }

    /// Entries stored.
    pub(crate) fn nnz(&self) -> usize {
        self.columns.len()
    }

    /// Bound on the rounding error of an entry of L x, relative to ‖L‖ and a unit vector x.
    pub(crate) fn rounding(&self) -> f64 {
        let longest = (0..self.dim()).map(|i| self.row(i).len()).max();
        f64::EPSILON * (longest.unwrap_or(0) + 4) as f64
    }

    fn row(&self, i: usize) -> Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }

    /// L_jj.
    #[inline(always)]
    pub(crate) fn diagonal(&self, j: usize) -> f64 {
        self.values[self.diagonals[j] as usize]
    }

    /// Rows and values of column j below the diagonal.
    #[inline(always)]
    pub(crate) fn below(&self, j: usize) -> (&[u32], &[f64]) {
        let range = self.diagonals[j] as usize + 1..self.row(j).end;
        (&self.columns[range.clone()], &self.values[range])
    }

    /// sum + (L x)_i
    #[inline(always)]
    pub(crate) fn add_row_product<S: Simd, const NV: usize>(
        &self,
        simd: S,
        panel: Panel,
        x: &[S::f64s],
        i: usize,
        mut sum: [S::f64s; NV],
    ) -> [S::f64s; NV] {
        let range = self.row(i);
        for (&j, &a) in self.columns[range.clone()].iter().zip(&self.values[range]) {
            let a = simd.splat_f64s(a);
            let xj: [_; NV] = panel.load(x, j as usize);
            for v in 0..NV {
                sum[v] = simd.mul_add_f64s(a, xj[v], sum[v]);
            }
        }
        sum
    }

    /// y ← L x.
    pub(crate) fn multiply(&self, x: &RowBlock, y: &mut RowBlock, threads: usize) {
        let width = x.width();
        simd::for_each_stretch_mut(y.as_mut_slice(), width, threads, |rows, y| {
            let product = Product {
                matrix: self,
                x: x.as_slice(),
                y,
                rows,
            };
            simd::for_each_panel(width, product);
        });
    }

    /// Σ_i ((L x)_i − x_i ∘ values)² for each column of x: squared residual norms, in one pass that
    /// stores no product. Rows are taken in fixed stretches, so that the sum is the same however
    /// many threads share them.
    pub(crate) fn squared_residuals(
        &self,
        x: &RowBlock,
        values: &[f64],
        threads: usize,
    ) -> Vec<f64> {
        assert_eq!(values.len(), x.width(), "one value per column");
        let partial = simd::map_stretches(self.dim(), threads, |rows| {
            let mut sums = vec![0.0; x.width()];
            simd::for_each_panel(
                x.width(),
                Residual {
                    matrix: self,
                    x: x.as_slice(),
                    values,
                    rows,
                    sums: &mut sums,
                },
            );
            sums
        });
        simd::add_up(partial, x.width())
    }
}

/// Some rows that are being written.
struct Stretch<'a> {
    first: usize,
    /// Where each row starts, and where the last one ends.
    starts: &'a [u32],
    diagonals: &'a mut [u32],
    columns: &'a mut [u32],
    values: &'a mut [f64],
}

impl Stretch<'_> {
    fn write(self, laplacian: &Laplacian<'_>, order: &EliminationOrder) {
        let mut row: Vec<(u32, f64)> = Vec::new();
        let begin = self.starts[0];
        for (i, diagonal) in self.diagonals.iter_mut().enumerate() {
            let r = (self.first + i) as u32;
            let u = order.node[r as usize];
            row.clear();
            row.push((r, laplacian.diagonal(u as usize)));
            let (neighbors, weights) = laplacian.row(u as usize);
            for (&v, &w) in neighbors.iter().zip(weights).filter(|&(&v, _)| v != u) {
                let value = laplacian.off_diagonal(u as usize, v as usize, w);
                row.push((order.position[v as usize], value));
            }
            row.sort_unstable_by_key(|&(column, _)| column);
            let at = (self.starts[i] - begin) as usize..(self.starts[i + 1] - begin) as usize;
            let columns = self.columns[at.clone()].iter_mut();
            let entries = columns.zip(&mut self.values[at]).zip(&row);
            for (k, ((column, value), &entry)) in entries.enumerate() {
                (*column, *value) = entry;
                if *column == r {
                    *diagonal = self.starts[i] + k as u32;
                }
            }
        }
    }
}

/// y ← L x for a stretch of rows.
struct Product<'a> {
    matrix: &'a PermutedLaplacian,
    x: &'a [f64],
    y: &'a mut [f64],
    rows: Range<usize>,
}

impl PanelKernel for Product<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_simd_f64s(self.x).0;
        let y = S::as_mut_simd_f64s(self.y).0;
        let first = self.rows.start;
        for i in self.rows.clone() {
            let zero = [simd.splat_f64s(0.0); NV];
            let product = self.matrix.add_row_product(simd, panel, x, i, zero);
            panel.store(y, i - first, product);
        }
    }
}

/// sums += Σ_i ((L x)_i − values ∘ x_i)² over a stretch of rows.
struct Residual<'a> {
    matrix: &'a PermutedLaplacian,
    x: &'a [f64],
    values: &'a [f64],
    rows: Range<usize>,
    sums: &'a mut [f64],
}

impl PanelKernel for Residual<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_simd_f64s(self.x).0;
        let theta: [_; NV] = panel.load(S::as_simd_f64s(self.values).0, 0);
        let sums = S::as_mut_simd_f64s(self.sums).0;
        let mut total: [_; NV] = panel.load(sums, 0);
        for i in self.rows.clone() {
            let xi: [_; NV] = panel.load(x, i);
            let mut r = [simd.splat_f64s(0.0); NV];
            for v in 0..NV {
                r[v] = simd.negate_mul_add_f64s(theta[v], xi[v], r[v]);
            }
            let r = self.matrix.add_row_product(simd, panel, x, i, r);
            for v in 0..NV {
                total[v] = simd.mul_add_f64s(r[v], r[v], total[v]);
            }
        }
        panel.store(sums, 0, total);
    }
}

#[cfg(test)]
impl PermutedLaplacian {
    /// Largest entry of (L + σI) x − b in magnitude.
    pub(crate) fn product_error(&self, x: &RowBlock, sigma: f64, b: &RowBlock) -> f64 {
        let mut product = RowBlock::zeros(x.rows(), x.width());
        self.multiply(x, &mut product, 1);
        let entries = product
            .as_slice()
            .iter()
            .zip(x.as_slice())
            .zip(b.as_slice());
        entries.fold(0.0, |worst: f64, ((p, x), b)| {
            worst.max((p + sigma * x - b).abs())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LaplacianKind, testing};
    use faer::Mat;

    #[test]
    fn columns_and_residuals_agree_with_the_dense_matrix() {
        let graph = testing::grid(6, 5);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let order = EliminationOrder::new(&laplacian, None);
        let mut permuted = PermutedLaplacian::default();
        permuted.assign(&laplacian, &order, 1);
        let dense = laplacian.to_dense();
        let expected = |i: usize, j: usize| {
            dense[(order.node[i] as usize, order.node[j] as usize)] + if i == j { 0.5 } else { 0.0 }
        };
        let mut rebuilt = Mat::<f64>::zeros(30, 30);
        for j in 0..30 {
            rebuilt[(j, j)] = permuted.diagonal(j) + 0.5;
            let (rows, values) = permuted.below(j);
            for (&i, &v) in rows.iter().zip(values) {
                assert!(i as usize > j);
                rebuilt[(i as usize, j)] = v;
                rebuilt[(j, i as usize)] = v;
            }
        }
        let error = Mat::from_fn(30, 30, |i, j| rebuilt[(i, j)] - expected(i, j));
        assert!(error.norm_max() < 1e-15);

        let mut x = RowBlock::zeros(30, 8);
        for (i, v) in x.as_mut_slice().iter_mut().enumerate() {
            *v = (i as f64 * 0.7).sin();
        }
        let values = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7];
        let found = permuted.squared_residuals(&x, &values, 1);
        for c in 0..8 {
            let sum: f64 = (0..30)
                .map(|i| {
                    let product: f64 = (0..30)
                        .map(|j| (expected(i, j) - if i == j { 0.5 } else { 0.0 }) * x.row(j)[c])
                        .sum();
                    (product - values[c] * x.row(i)[c]).powi(2)
                })
                .sum();
            assert!((found[c] - sum).abs() < 1e-12 * sum);
        }
    }

    #[test]
    fn stretches_are_written_alike_by_any_number_of_threads() {
        let graph = testing::disjoint(&[testing::grid(60, 80), testing::star(40)]);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let order = EliminationOrder::new(&laplacian, None);
        let assigned = |threads| {
            let mut permuted = PermutedLaplacian::default();
            permuted.assign(&laplacian, &order, threads);
            permuted
        };
        let (one, several) = (assigned(1), assigned(3));
        assert_eq!(one.columns, several.columns);
        assert_eq!(one.values, several.values);
        assert_eq!(one.diagonals, several.diagonals);
        for r in 0..one.dim() {
            let columns = &one.columns[one.row(r)];
            assert!(columns.is_sorted());
            assert_eq!(one.columns[one.diagonals[r] as usize] as usize, r);
            let degree = laplacian.row(order.node[r] as usize).0.len();
            assert_eq!(columns.len(), degree + 1);
        }
    }
}
