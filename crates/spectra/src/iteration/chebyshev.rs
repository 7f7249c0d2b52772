//! A polynomial filter in L itself that keeps the low end of its spectrum: no factor, only products.
//!
//!   p_d(λ) = T_d((λ − c) / e),   [c − e, c + e] = [λ_cut, ‖L‖],
//!
//! T the Chebyshev polynomial: at most 1 in magnitude beyond the cut, and below it as large as any
//! polynomial of its degree (Zhou, Saad, Tiago & Chelikowsky 2006). A degree costs one product with L
//! and its three-term recurrence runs within it:
//!
//!   y_{i+1} = 2 (L − c) y_i / e − y_{i−1}.

use crate::block::RowBlock;
use crate::block::simd::{self, Panel, PanelKernel};
use crate::cholesky::PermutedLaplacian;
use pulp::Simd;
use std::ops::Range;

/// Highest degree in one go.
const MOST_PRODUCTS: usize = 400;

/// Largest amplification of low modes and of rounding errors along the null space, from which the columns
/// are projected afterwards: beyond it they become too parallel for the Rayleigh–Ritz step to tell apart.
const MOST_SPREAD: f64 = 1e7;

/// A filter of degree d = `products`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChebyshevFilter {
    center: f64,
    half_width: f64,
    products: usize,
}

impl ChebyshevFilter {
    /// The cheapest filter that amplifies λ = `wanted` by `gain` over everything in [`cut`, `norm`], as far
    /// as low modes do not take over all columns.
    pub(crate) fn with_gain((gain, wanted): (f64, f64), cut: f64, norm: f64) -> Self {
        let mut filter = Self {
            center: 0.5 * (norm + cut),
            half_width: 0.5 * (norm - cut),
            products: 1,
        };
        let growth =
            |filter: &Self, lambda: f64| libm::acosh(filter.argument(lambda).abs().max(1.0));
        let degree =
            |gain: f64, lambda: f64| (libm::acosh(gain) / growth(&filter, lambda)).max(1.0);
        let most = degree(MOST_SPREAD, 0.0).min(MOST_PRODUCTS as f64);
        filter.products = degree(gain.max(1.0), wanted).ceil().min(most.floor()) as usize;
        filter
    }

    fn argument(&self, lambda: f64) -> f64 {
        (lambda - self.center) / self.half_width
    }

    /// λ from which on it damps.
    pub(crate) fn cut(&self) -> f64 {
        self.center - self.half_width
    }

    /// Products with L that it takes.
    pub(crate) fn products(&self) -> usize {
        self.products
    }

    /// |p(λ)|.
    pub(crate) fn gain(&self, lambda: f64) -> f64 {
        let t = self.argument(lambda).abs();
        let degree = self.products as f64;
        if t > 1.0 {
            libm::cosh(degree * libm::acosh(t))
        } else {
            libm::cos(degree * libm::acos(t)).abs()
        }
    }

    /// x ← p(L) x up to its sign. `z` is overwritten.
    pub(crate) fn apply(
        &self,
        laplacian: &PermutedLaplacian,
        x: &mut RowBlock,
        z: &mut RowBlock,
        threads: usize,
    ) {
        let (c, e) = (self.center, self.half_width);
        z.reset(x.rows(), x.width());
        recur(laplacian, x, z, (1.0 / e, c), threads);
        for _ in 1..self.products {
            recur(laplacian, z, x, (2.0 / e, c), threads);
            std::mem::swap(x, z);
        }
        std::mem::swap(x, z);
    }
}

/// y ← scale (L − center) x − y.
fn recur(
    laplacian: &PermutedLaplacian,
    x: &RowBlock,
    y: &mut RowBlock,
    (scale, center): (f64, f64),
    threads: usize,
) {
    let width = y.width();
    simd::for_each_stretch_mut(y.as_mut_slice(), width, threads, |rows, y| {
        let step = Recurrence {
            laplacian,
            x: x.as_slice(),
            y,
            rows,
            scale,
            center,
        };
        simd::for_each_panel(width, step);
    });
}

/// y ← scale (L − center) x − y for a stretch of rows.
struct Recurrence<'a> {
    laplacian: &'a PermutedLaplacian,
    x: &'a [f64],
    y: &'a mut [f64],
    rows: Range<usize>,
    scale: f64,
    center: f64,
}

impl PanelKernel for Recurrence<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_simd_f64s(self.x).0;
        let y = S::as_mut_simd_f64s(self.y).0;
        let (scale, center) = (simd.splat_f64s(self.scale), simd.splat_f64s(self.center));
        let first = self.rows.start;
        for i in self.rows.clone() {
            let xi: [_; NV] = panel.load(x, i);
            let mut sum = [simd.splat_f64s(0.0); NV];
            for v in 0..NV {
                sum[v] = simd.negate_mul_add_f64s(center, xi[v], sum[v]);
            }
            let sum = self.laplacian.add_row_product(simd, panel, x, i, sum);
            let mut yi: [_; NV] = panel.load(&*y, i - first);
            for v in 0..NV {
                yi[v] = simd.mul_add_f64s(scale, sum[v], simd.neg_f64s(yi[v]));
            }
            panel.store(y, i - first, yi);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cholesky::EliminationOrder;
    use crate::dense::laplacian_eigen;
    use crate::{Laplacian, LaplacianKind, testing};

    #[test]
    fn gain_is_at_most_one_beyond_the_cut_and_enough_below() {
        let filter = ChebyshevFilter::with_gain((50.0, 0.01), 0.012, 2.0);
        for i in 0..=1000 {
            let beyond = 0.012 + (2.0 - 0.012) * f64::from(i) / 1000.0;
            assert!(filter.gain(beyond) <= 1.0 + 1e-9);
        }
        assert!(filter.gain(0.01) >= 50.0 && filter.gain(0.001) > filter.gain(0.01));
        let weaker = ChebyshevFilter {
            products: filter.products - 1,
            ..filter
        };
        assert!(weaker.gain(0.01) < 50.0);
    }

    #[test]
    fn low_modes_are_not_amplified_beyond_measure() {
        let filter = ChebyshevFilter::with_gain((1e6, 0.1), 0.101, 2.0);
        assert!(filter.gain(0.0) <= MOST_SPREAD * (1.0 + 1e-9));
        assert!(ChebyshevFilter::with_gain((1e6, 1e-8), 2e-8, 2.0).products <= MOST_PRODUCTS);
    }

    #[test]
    fn eigenvectors_are_multiplied_by_the_polynomial_at_their_eigenvalues() {
        let graph = testing::random(60, 4.0, 1);
        let laplacian = Laplacian::new(&graph, LaplacianKind::Normalized);
        let (values, vectors) = laplacian_eigen(&laplacian).unwrap();
        let order = EliminationOrder::new(&laplacian, None);
        let mut permuted = PermutedLaplacian::default();
        permuted.assign(&laplacian, &order, 1);
        let (mut x, mut z) = (RowBlock::zeros(60, 8), RowBlock::zeros(60, 8));
        let columns = [0, 1, 2, 5, 20, 40, 50, 59];
        for (i, &u) in order.node.iter().enumerate() {
            for (v, &j) in x.row_mut(i).iter_mut().zip(&columns) {
                *v = vectors[(u as usize, j)];
            }
        }
        let filter = ChebyshevFilter::with_gain((10.0, values[2]), values[5], 2.0);
        assert!(filter.products > 2);
        filter.apply(&permuted, &mut x, &mut z, 1);
        for (i, &u) in order.node.iter().enumerate() {
            for (v, &j) in x.row(i).iter().zip(&columns) {
                let (gain, entry) = (filter.gain(values[j]), vectors[(u as usize, j)]);
                assert!((v.abs() - gain * entry.abs()).abs() < 1e-9 * gain.max(1.0));
            }
        }
    }
}
