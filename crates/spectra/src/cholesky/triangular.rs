//! C Cᵀ x = b for all columns of a block at once, with one part of a sparse Cholesky factor.
//!
//! Forward and backward substitution (Davis, *Direct Methods for Sparse Linear Systems*, 2006,
//! section 3.2) read the factor once for all columns: each entry meets one row of the block, which
//! is a few whole SIMD registers, and within a supernode several rows of the block stay in registers.
//! The factor holds 1 / C_jj on its diagonal, so that nothing divides.
//!
//! A part has a block for its own rows and one for its boundary.

use super::supernodes::{Shape, Supernodes};
use crate::block::simd::{Panel, PanelKernel};
use pulp::Simd;

/// Rows or columns handled together: their sums fit in 32 registers with three per row.
const TILE: usize = 4;

/// own ← C₁⁻¹ own and outside ← outside − C₂ own, C₂ being the rows outside.
pub(crate) struct Forward<'a> {
    pub(crate) supernodes: &'a Supernodes,
    pub(crate) values: &'a [f64],
    pub(crate) own: &'a mut [f64],
    pub(crate) outside: &'a mut [f64],
}

/// own ← C₁⁻ᵀ (own − C₂ᵀ outside).
pub(crate) struct Backward<'a> {
    pub(crate) supernodes: &'a Supernodes,
    pub(crate) values: &'a [f64],
    pub(crate) own: &'a mut [f64],
    pub(crate) outside: &'a [f64],
}

impl PanelKernel for Forward<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let own = S::as_mut_simd_f64s(self.own).0;
        let outside = S::as_mut_simd_f64s(self.outside).0;
        let columns = self.supernodes.columns();
        for s in 0..self.supernodes.len() {
            let node = Node::new(self.supernodes.shape(s), self.values);
            node.forward_triangle::<S, NV>(simd, panel, own);
            let inside = node.rows_below(columns);
            node.forward_rows::<S, NV>(simd, panel, own, None, 0..inside);
            let beyond = inside..node.shape.rows.len();
            node.forward_rows::<S, NV>(simd, panel, own, Some((&mut *outside, columns)), beyond);
        }
    }
}

impl PanelKernel for Backward<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let own = S::as_mut_simd_f64s(self.own).0;
        let outside = S::as_simd_f64s(self.outside).0;
        let columns = self.supernodes.columns();
        for s in (0..self.supernodes.len()).rev() {
            let node = Node::new(self.supernodes.shape(s), self.values);
            let inside = node.rows_below(columns);
            let tiled = node.shape.size - node.shape.size % TILE;
            let split = (inside, columns);
            for c in (tiled..node.shape.size).rev() {
                node.backward_columns::<S, NV, 1>(simd, panel, own, outside, split, c);
            }
            for c in (0..tiled).step_by(TILE).rev() {
                node.backward_columns::<S, NV, TILE>(simd, panel, own, outside, split, c);
            }
        }
    }
}

/// a − l b
#[inline(always)]
fn subtract<S: Simd, const NV: usize>(
    simd: S,
    a: [S::f64s; NV],
    l: S::f64s,
    b: [S::f64s; NV],
) -> [S::f64s; NV] {
    let mut out = a;
    for v in 0..NV {
        out[v] = simd.negate_mul_add_f64s(l, b[v], a[v]);
    }
    out
}

/// s a. A loop, since a closure would not be compiled for the wide registers and be called once per
/// register; so below, too.
#[inline(always)]
fn scaled<S: Simd, const NV: usize>(simd: S, a: [S::f64s; NV], s: S::f64s) -> [S::f64s; NV] {
    let mut out = a;
    for v in 0..NV {
        out[v] = simd.mul_f64s(a[v], s);
    }
    out
}

/// A supernode and its values.
struct Node<'a> {
    shape: Shape<'a>,
    height: usize,
    values: &'a [f64],
}

impl<'a> Node<'a> {
    #[inline(always)]
    fn new(shape: Shape<'a>, values: &'a [f64]) -> Self {
        Self {
            height: shape.height(),
            values: &values[shape.values.clone()],
            shape,
        }
    }

    /// How many of its rows are among the first `columns`.
    #[inline(always)]
    fn rows_below(&self, columns: usize) -> usize {
        match self.shape.rows.last() {
            Some(&last) if last as usize >= columns => {
                self.shape.rows.partition_point(|&r| (r as usize) < columns)
            }
            _ => self.shape.rows.len(),
        }
    }

    /// Column `c`: 1 / C_cc is its entry c, what is above has no meaning.
    #[inline(always)]
    fn column(&self, c: usize) -> &'a [f64] {
        &self.values[c * self.height..(c + 1) * self.height]
    }

    /// The triangle's part of the forward substitution.
    #[inline(always)]
    fn forward_triangle<S: Simd, const NV: usize>(&self, simd: S, panel: Panel, x: &mut [S::f64s]) {
        let tiled = self.shape.size - self.shape.size % TILE;
        for r in (0..tiled).step_by(TILE) {
            self.forward_square::<S, NV, TILE>(simd, panel, x, r);
        }
        for r in tiled..self.shape.size {
            self.forward_square::<S, NV, 1>(simd, panel, x, r);
        }
    }

    /// Rows `r..r + R` of the triangle.
    #[inline(always)]
    fn forward_square<S: Simd, const NV: usize, const R: usize>(
        &self,
        simd: S,
        panel: Panel,
        x: &mut [S::f64s],
        r: usize,
    ) {
        let first = self.shape.first;
        let mut sums = [[simd.splat_f64s(0.0); NV]; R];
        for (t, sum) in sums.iter_mut().enumerate() {
            *sum = panel.load(&*x, first + r + t);
        }
        for c in 0..r {
            let l: &[f64; R] = self.column(c)[r..].first_chunk().expect("R values");
            let xc: [_; NV] = panel.load(&*x, first + c);
            for t in 0..R {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(l[t]), xc);
            }
        }
        for c in 0..R {
            let l: &[f64; R] = self.column(r + c)[r..].first_chunk().expect("R values");
            sums[c] = scaled(simd, sums[c], simd.splat_f64s(l[c]));
            for t in c + 1..R {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(l[t]), sums[c]);
            }
        }
        for (t, sum) in sums.into_iter().enumerate() {
            panel.store(x, first + r + t, sum);
        }
    }

    /// The rectangle's part of the forward substitution for some of its rows, which are rows of `own`
    /// or, counted from `columns` on, of a block `outside`.
    #[inline(always)]
    fn forward_rows<S: Simd, const NV: usize>(
        &self,
        simd: S,
        panel: Panel,
        own: &mut [S::f64s],
        mut outside: Option<(&mut [S::f64s], usize)>,
        rows: std::ops::Range<usize>,
    ) {
        let tiled = rows.end - rows.len() % TILE;
        for r in (rows.start..tiled).step_by(TILE) {
            let outside = outside.as_mut().map(|(x, columns)| (&mut **x, *columns));
            self.forward_tile::<S, NV, TILE>(simd, panel, own, outside, r);
        }
        for r in tiled..rows.end {
            let outside = outside.as_mut().map(|(x, columns)| (&mut **x, *columns));
            self.forward_tile::<S, NV, 1>(simd, panel, own, outside, r);
        }
    }

    #[inline(always)]
    fn forward_tile<S: Simd, const NV: usize, const R: usize>(
        &self,
        simd: S,
        panel: Panel,
        own: &mut [S::f64s],
        outside: Option<(&mut [S::f64s], usize)>,
        r: usize,
    ) {
        let rows: &[u32; R] = self.shape.rows[r..r + R].first_chunk().expect("R rows");
        let mut sums = [[simd.splat_f64s(0.0); NV]; R];
        for t in 0..R {
            sums[t] = match &outside {
                None => panel.load(&*own, rows[t] as usize),
                Some((x, columns)) => panel.load(x, rows[t] as usize - columns),
            };
        }
        for c in 0..self.shape.size {
            let at = c * self.height + self.shape.size + r;
            let l: &[f64; R] = self.values[at..at + R].first_chunk().expect("R values");
            let xc: [_; NV] = panel.load(&*own, self.shape.first + c);
            for t in 0..R {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(l[t]), xc);
            }
        }
        match outside {
            None => {
                for t in 0..R {
                    panel.store(own, rows[t] as usize, sums[t]);
                }
            }
            Some((x, columns)) => {
                for t in 0..R {
                    panel.store(x, rows[t] as usize - columns, sums[t]);
                }
            }
        }
    }

    /// The backward substitution for `C` columns from `c` on, those after them being done; of the
    /// rectangle's rows the first `inside` are in `own`, the others, counted from `columns` on, in
    /// `outside`.
    #[inline(always)]
    fn backward_columns<S: Simd, const NV: usize, const C: usize>(
        &self,
        simd: S,
        panel: Panel,
        own: &mut [S::f64s],
        outside: &[S::f64s],
        (inside, columns): (usize, usize),
        c: usize,
    ) {
        let (first, size) = (self.shape.first, self.shape.size);
        let mut sums = [[simd.splat_f64s(0.0); NV]; C];
        let mut triangle: [&[f64]; C] = [&[]; C];
        let mut rectangle: [&[f64]; C] = [&[]; C];
        for t in 0..C {
            sums[t] = panel.load(&*own, first + c + t);
            (triangle[t], rectangle[t]) = self.column(c + t).split_at(size);
        }
        let (near, far) = self.shape.rows.split_at(inside);
        for (r, &i) in near.iter().enumerate() {
            let xi: [_; NV] = panel.load(&*own, i as usize);
            for t in 0..C {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(rectangle[t][r]), xi);
            }
        }
        for (r, &i) in far.iter().enumerate() {
            let xi: [_; NV] = panel.load(outside, i as usize - columns);
            for t in 0..C {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(rectangle[t][inside + r]), xi);
            }
        }
        for below in 0..size - (c + C) {
            let r = c + C + below;
            let xi: [_; NV] = panel.load(&*own, first + r);
            for t in 0..C {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(triangle[t][r]), xi);
            }
        }
        for t in (0..C).rev() {
            for u in t + 1..C {
                let l = simd.splat_f64s(triangle[t][c + u]);
                sums[t] = subtract(simd, sums[t], l, sums[u]);
            }
            sums[t] = scaled(simd, sums[t], simd.splat_f64s(triangle[t][c + t]));
        }
        for (t, sum) in sums.into_iter().enumerate() {
            panel.store(own, first + c + t, sum);
        }
    }
}
