//! XᵀY and X C for tall thin blocks, at the speed of memory.
//!
//! A tile of the result stays in registers while rows of the block stream by: four of its rows, each
//! of whose factors is spread over a register, by three registers of its columns. That fits the
//! sixteen registers of small machines and keeps the multipliers of large ones busy; a general matrix
//! product repacks such blocks first, which costs more than multiplying them. Every sum runs over its
//! terms in order, whatever the width of the registers.

use super::simd::{Panel, PanelKernel, run_panels};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, Simd, WithSimd};

/// Rows of a tile, and registers of its columns.
const ROWS: usize = 4;
const VECTORS: usize = 3;

/// Widest blocks whose C stays in the nearest cache: beyond, repacking pays.
const WIDEST: usize = 128;

/// Rows of a block that all tiles go over in turn: few enough to stay in the nearest cache.
pub(crate) const CACHED_ROWS: usize = 64;

/// `product` += XᵀY on and above the diagonal, all row-major with `width` columns; below it anything.
pub(crate) fn add_upper_product(x: &[f64], y: &[f64], width: usize, product: &mut [f64]) {
    Arch::new().dispatch(UpperProduct {
        x,
        y,
        width,
        product,
    });
}

/// `new` ← `old` C, all row-major with `width` columns.
pub(crate) fn multiply(old: &[f64], c: &[f64], width: usize, new: &mut [f64]) {
    if width <= WIDEST {
        Arch::new().dispatch(Multiply { old, c, width, new });
        return;
    }
    let rows = old.len() / width;
    matmul(
        MatMut::from_row_major_slice_mut(new, rows, width),
        Accum::Replace,
        MatRef::from_row_major_slice(old, rows, width),
        MatRef::from_row_major_slice(c, width, width),
        1.0,
        Par::Seq,
    );
}

struct UpperProduct<'a> {
    x: &'a [f64],
    y: &'a [f64],
    width: usize,
    product: &'a mut [f64],
}

impl WithSimd for UpperProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for row in (0..self.width).step_by(ROWS) {
            let tile = ProductTile {
                x: self.x,
                y: self.y,
                width: self.width,
                row,
                product: &mut *self.product,
            };
            let panel = Panel {
                stride: self.width / S::F64_LANES,
                first: row / S::F64_LANES,
            };
            run_panels(simd, panel, VECTORS, tile);
        }
    }
}

/// Rows `row..row + ROWS` of XᵀY.
struct ProductTile<'a> {
    x: &'a [f64],
    y: &'a [f64],
    width: usize,
    row: usize,
    product: &'a mut [f64],
}

impl PanelKernel for ProductTile<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let y = S::as_simd_f64s(self.y).0;
        let product = S::as_mut_simd_f64s(self.product).0;
        let mut sums = [[simd.splat_f64s(0.0); NV]; ROWS];
        for (t, sum) in sums.iter_mut().enumerate() {
            *sum = panel.load(&*product, self.row + t);
        }
        let rows = self.x.chunks_exact(self.width);
        for (x, y) in rows.zip(y.chunks_exact(panel.stride)) {
            let x: &[f64; ROWS] = x[self.row..].first_chunk().expect("a tile's rows");
            let y: &[_; NV] = y[panel.first..].first_chunk().expect("a tile's columns");
            for t in 0..ROWS {
                let x = simd.splat_f64s(x[t]);
                for v in 0..NV {
                    sums[t][v] = simd.mul_add_f64s(x, y[v], sums[t][v]);
                }
            }
        }
        for (t, sum) in sums.into_iter().enumerate() {
            panel.store(product, self.row + t, sum);
        }
    }
}

struct Multiply<'a> {
    old: &'a [f64],
    c: &'a [f64],
    width: usize,
    new: &'a mut [f64],
}

impl WithSimd for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let panel = Panel {
            stride: self.width / S::F64_LANES,
            first: 0,
        };
        run_panels(simd, panel, VECTORS, self);
    }
}

impl PanelKernel for Multiply<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let rows = self.old.len() / self.width;
        let tiled = rows - rows % ROWS;
        for i in (0..tiled).step_by(ROWS) {
            self.tile::<S, NV, ROWS>(simd, panel, i);
        }
        for i in tiled..rows {
            self.tile::<S, NV, 1>(simd, panel, i);
        }
    }
}

impl Multiply<'_> {
    /// Rows `i..i + R`.
    #[inline(always)]
    fn tile<S: Simd, const NV: usize, const R: usize>(&mut self, simd: S, panel: Panel, i: usize) {
        let c = S::as_simd_f64s(self.c).0;
        let mut old: [&[f64]; R] = [&[]; R];
        for (t, old) in old.iter_mut().enumerate() {
            *old = &self.old[(i + t) * self.width..][..self.width];
        }
        let mut sums = [[simd.splat_f64s(0.0); NV]; R];
        for (k, c) in c.chunks_exact(panel.stride).enumerate() {
            let c: &[_; NV] = c[panel.first..].first_chunk().expect("NV registers");
            for t in 0..R {
                let x = simd.splat_f64s(old[t][k]);
                for v in 0..NV {
                    sums[t][v] = simd.mul_add_f64s(x, c[v], sums[t][v]);
                }
            }
        }
        let new = S::as_mut_simd_f64s(self.new).0;
        for (t, sum) in sums.into_iter().enumerate() {
            panel.store(new, i + t, sum);
        }
    }
}
