//! L Lᵀ x = b for all columns of a block at once, with a sparse Cholesky factor.
//!
//! Forward and backward substitution (Davis, *Direct Methods for Sparse Linear Systems*, 2006,
//! section 3.2) read the factor once for all columns: each entry meets one row of the block, which
//! is a few whole SIMD registers. The factor holds 1 / L_jj on its diagonal, so that nothing divides.
//!
//! Two forms, as the factorisation chose: column by column (*simplicial*: trees, mazes), or dense
//! blocks of columns with a common pattern (*supernodal*: grids), where several rows of the block
//! stay in registers.

use super::simd::{Panel, PanelKernel};
use pulp::Simd;

/// A factor by columns; each column begins with its diagonal.
#[derive(Clone, Copy)]
pub(super) struct ColumnFactor<'a> {
    pub(super) column_starts: &'a [u32],
    pub(super) rows: &'a [u32],
    pub(super) values: &'a [f64],
}

/// Overwrites a block b by the solution of L Lᵀ x = b.
pub(super) struct ColumnSolve<'a> {
    pub(super) factor: ColumnFactor<'a>,
    pub(super) x: &'a mut [f64],
}

impl<'a> ColumnFactor<'a> {
    /// 1 / L_jj, and the rows and values below the diagonal of column j.
    #[inline(always)]
    fn column(&self, j: usize) -> (f64, &'a [u32], &'a [f64]) {
        let (start, end) = (
            self.column_starts[j] as usize,
            self.column_starts[j + 1] as usize,
        );
        (
            self.values[start],
            &self.rows[start + 1..end],
            &self.values[start + 1..end],
        )
    }
}

impl PanelKernel for ColumnSolve<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_mut_simd_f64s(self.x).0;
        let n = self.factor.column_starts.len() - 1;
        for j in 0..n {
            let (inverse, rows, values) = self.factor.column(j);
            let inverse = simd.splat_f64s(inverse);
            let xj: [_; NV] = panel.load(&*x, j);
            let xj = scaled(simd, xj, inverse);
            panel.store(x, j, xj);
            for (&i, &l) in rows.iter().zip(values) {
                let l = simd.splat_f64s(l);
                let xi: [_; NV] = panel.load(&*x, i as usize);
                panel.store(x, i as usize, subtract(simd, xi, l, xj));
            }
        }
        for j in (0..n).rev() {
            let (inverse, rows, values) = self.factor.column(j);
            let mut sum: [_; NV] = panel.load(&*x, j);
            for (&i, &l) in rows.iter().zip(values) {
                let l = simd.splat_f64s(l);
                sum = subtract(simd, sum, l, panel.load(&*x, i as usize));
            }
            let inverse = simd.splat_f64s(inverse);
            panel.store(x, j, scaled(simd, sum, inverse));
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
/// register.
#[inline(always)]
fn scaled<S: Simd, const NV: usize>(simd: S, a: [S::f64s; NV], s: S::f64s) -> [S::f64s; NV] {
    let mut out = a;
    for v in 0..NV {
        out[v] = simd.mul_f64s(a[v], s);
    }
    out
}

/// A factor by supernodes.
#[derive(Clone, Copy)]
pub(super) struct SupernodalFactor<'a> {
    /// First column of each supernode.
    pub(super) begins: &'a [u32],
    /// One past the last column of each.
    pub(super) ends: &'a [u32],
    /// Where each supernode's row pattern starts in `rows`.
    pub(super) row_starts: &'a [u32],
    /// Length of each pattern.
    pub(super) row_counts: &'a [u32],
    /// Rows below the dense triangle.
    pub(super) rows: &'a [u32],
    /// Where each supernode's values start.
    pub(super) value_starts: &'a [u32],
    /// Per supernode: dense triangle over dense rectangle, column-major.
    pub(super) values: &'a [f64],
}

/// One supernode: columns `first..first + size`, dense triangle above `rows.len()` further rows.
#[derive(Clone, Copy)]
struct Supernode<'a> {
    first: usize,
    size: usize,
    rows: &'a [u32],
    values: &'a [f64],
}

impl<'a> SupernodalFactor<'a> {
    #[inline(always)]
    fn supernode(&self, s: usize) -> Supernode<'a> {
        let first = self.begins[s] as usize;
        let start = self.row_starts[s] as usize;
        Supernode {
            first,
            size: self.ends[s] as usize - first,
            rows: &self.rows[start..start + self.row_counts[s] as usize],
            values: &self.values[self.value_starts[s] as usize..self.value_starts[s + 1] as usize],
        }
    }
}

impl<'a> Supernode<'a> {
    /// Column `c` from its diagonal down: 1 / L_cc, the rest of the triangle, the rectangle.
    #[inline(always)]
    fn column(&self, c: usize) -> (f64, &'a [f64], &'a [f64]) {
        let height = self.size + self.rows.len();
        let column = &self.values[c * height..(c + 1) * height];
        let (triangle, rectangle) = column.split_at(self.size);
        (triangle[c], &triangle[c + 1..], rectangle)
    }

    /// The triangle's part of the forward substitution.
    #[inline(always)]
    fn forward_triangle<S: Simd, const NV: usize>(&self, simd: S, panel: Panel, x: &mut [S::f64s]) {
        for c in 0..self.size {
            let (inverse, below, _) = self.column(c);
            let inverse = simd.splat_f64s(inverse);
            let xc: [_; NV] = panel.load(&*x, self.first + c);
            let xc = scaled(simd, xc, inverse);
            panel.store(x, self.first + c, xc);
            for (i, &l) in below.iter().enumerate() {
                let i = self.first + c + 1 + i;
                let xi: [_; NV] = panel.load(&*x, i);
                panel.store(x, i, subtract(simd, xi, simd.splat_f64s(l), xc));
            }
        }
    }

    /// The rectangle's part of the forward substitution, for `R` pattern rows from `r` on.
    #[inline(always)]
    fn forward_rows<S: Simd, const NV: usize, const R: usize>(
        &self,
        simd: S,
        panel: Panel,
        x: &mut [S::f64s],
        r: usize,
    ) {
        let rows: &[u32; R] = self.rows[r..r + R].first_chunk().expect("R rows");
        let mut sums: [[_; NV]; R] = rows.map(|i| panel.load(&*x, i as usize));
        let height = self.size + self.rows.len();
        for c in 0..self.size {
            let at = c * height + self.size + r;
            let l: &[f64; R] = self.values[at..at + R].first_chunk().expect("R values");
            let xc: [_; NV] = panel.load(&*x, self.first + c);
            for t in 0..R {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(l[t]), xc);
            }
        }
        for t in 0..R {
            panel.store(x, rows[t] as usize, sums[t]);
        }
    }

    /// The rectangle's part of the backward substitution, for `C` columns from `c` on.
    #[inline(always)]
    fn backward_columns<S: Simd, const NV: usize, const C: usize>(
        &self,
        simd: S,
        panel: Panel,
        x: &mut [S::f64s],
        c: usize,
    ) {
        let mut sums: [[_; NV]; C] = std::array::from_fn(|t| panel.load(&*x, self.first + c + t));
        let columns: [&[f64]; C] = std::array::from_fn(|t| self.column(c + t).2);
        for (r, &i) in self.rows.iter().enumerate() {
            let xi: [_; NV] = panel.load(&*x, i as usize);
            for t in 0..C {
                sums[t] = subtract(simd, sums[t], simd.splat_f64s(columns[t][r]), xi);
            }
        }
        for (t, sum) in sums.into_iter().enumerate() {
            panel.store(x, self.first + c + t, sum);
        }
    }

    /// The triangle's part of the backward substitution.
    #[inline(always)]
    fn backward_triangle<S: Simd, const NV: usize>(
        &self,
        simd: S,
        panel: Panel,
        x: &mut [S::f64s],
    ) {
        for c in (0..self.size).rev() {
            let (inverse, below, _) = self.column(c);
            let mut sum: [_; NV] = panel.load(&*x, self.first + c);
            for (i, &l) in below.iter().enumerate() {
                let xi = panel.load(&*x, self.first + c + 1 + i);
                sum = subtract(simd, sum, simd.splat_f64s(l), xi);
            }
            let inverse = simd.splat_f64s(inverse);
            panel.store(x, self.first + c, scaled(simd, sum, inverse));
        }
    }
}

/// Overwrites a block b by the solution of L Lᵀ x = b.
pub(super) struct SupernodalSolve<'a> {
    pub(super) factor: SupernodalFactor<'a>,
    pub(super) x: &'a mut [f64],
}

/// Rows or columns handled together: their sums fit in 32 registers with three per row.
const TILE: usize = 4;

impl PanelKernel for SupernodalSolve<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_mut_simd_f64s(self.x).0;
        let supernodes = self.factor.begins.len();
        for s in 0..supernodes {
            let node = self.factor.supernode(s);
            node.forward_triangle::<S, NV>(simd, panel, x);
            let tiled = node.rows.len() - node.rows.len() % TILE;
            for r in (0..tiled).step_by(TILE) {
                node.forward_rows::<S, NV, TILE>(simd, panel, x, r);
            }
            for r in tiled..node.rows.len() {
                node.forward_rows::<S, NV, 1>(simd, panel, x, r);
            }
        }
        for s in (0..supernodes).rev() {
            let node = self.factor.supernode(s);
            let tiled = node.size - node.size % TILE;
            for c in (0..tiled).step_by(TILE) {
                node.backward_columns::<S, NV, TILE>(simd, panel, x, c);
            }
            for c in tiled..node.size {
                node.backward_columns::<S, NV, 1>(simd, panel, x, c);
            }
            node.backward_triangle::<S, NV>(simd, panel, x);
        }
    }
}
