//! Eliminating the first columns of a dense symmetric matrix, the step of a multifrontal method.
//!
//! ```text
//! ⎡ T  · ⎤   ⎡ C₁ ⎤     ⎡ C₁ᵀ C₂ᵀ ⎤   ⎡ 0  0 ⎤        S = ±1 on the diagonal,
//! ⎣ R  U ⎦ = ⎣ C₂ ⎦  S  ⎣         ⎦ + ⎣ 0  U'⎦        U' = U − C₂ S C₂ᵀ
//! ```
//!
//! With S = I that is Cholesky; a pivot d < 0 gets the sign −1 and the column is scaled by |d|^-1/2,
//! so that both factorisations are one. There is no pivoting: see [`Pivots`] for what that costs.
//! Work is cut into tiles of fixed size, whose results do not depend on the threads that share them.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns eliminated at a time in large fronts.
const PANEL: usize = 64;

/// Columns or rows in a tile.
const TILE: usize = 128;

/// Multiplications of a front that loops without blocks handle best.
const SMALL: usize = 30_000;

/// Multiplications worth sharing among threads: a few milliseconds' worth, since it takes a rendezvous for
/// every panel. Smaller fronts are shared out whole.
const SHARED: usize = 50_000_000;

/// A pivot that vanished, was not finite, or had the wrong sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BadPivot;

/// Facts of the pivots of a factorisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pivots {
    /// Number of negative ones.
    pub(crate) negative: usize,
    /// Largest |C_ij|². Rounding errors of C S Cᵀ are at most about ε times the sums of its products,
    /// so that without pivoting this is what bounds the error of the matrix factored.
    pub(crate) growth: f64,
}

impl Pivots {
    pub(crate) fn join(self, other: Self) -> Self {
        Self {
            negative: self.negative + other.negative,
            growth: self.growth.max(other.growth),
        }
    }
}

/// A dense front: the columns to eliminate, and the lower triangle of the rest.
pub(crate) struct Front<'a> {
    /// Columns to eliminate.
    pub(crate) size: usize,
    /// T over R, column-major: `size` columns of `size + rest` numbers. Above the diagonal of T anything.
    pub(crate) panel: &'a mut [f64],
    /// Rows of R.
    pub(crate) rest: usize,
    /// U, rest × rest, column-major; only the lower triangle is used.
    pub(crate) update: &'a mut [f64],
}

/// Signs that pivots may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Definiteness {
    Positive,
    Any,
}

impl Front<'_> {
    fn height(&self) -> usize {
        self.size + self.rest
    }

    /// Eliminates the columns; leaves 1 / C_jj on the diagonal of C₁. `signs` is scratch.
    #[inline(always)]
    pub(crate) fn eliminate(
        &mut self,
        kind: Definiteness,
        signs: &mut Vec<f64>,
        threads: usize,
    ) -> Result<Pivots, BadPivot> {
        signs.clear();
        let work = self.size * self.height() * self.height();
        if work <= SMALL {
            let height = self.height();
            let pivots = eliminate_columns(self.panel, height, 0..self.size, kind, signs)?;
            self.update_by_columns(signs);
            return Ok(pivots);
        }
        self.eliminate_in_panels(kind, signs, if work > SHARED { threads } else { 1 })
    }

    /// U ← U − C₂ S C₂ᵀ, four columns of C₂ at a time.
    #[inline(always)]
    fn update_by_columns(&mut self, signs: &[f64]) {
        let (size, rest, height) = (self.size, self.rest, self.height());
        for j in 0..rest {
            let target = &mut self.update[j * rest + j..(j + 1) * rest];
            let mut c = 0;
            while c + 4 <= size {
                let mut r: [&[f64]; 4] = [&[]; 4];
                let mut a = [0.0; 4];
                for t in 0..4 {
                    r[t] = &self.panel[(c + t) * height + size + j..][..rest - j];
                    a[t] = signs[c + t] * r[t][0];
                }
                for i in 0..target.len() {
                    target[i] -= a[0] * r[0][i] + a[1] * r[1][i] + a[2] * r[2][i] + a[3] * r[3][i];
                }
                c += 4;
            }
            for (c, sign) in signs.iter().enumerate().skip(c) {
                let r = &self.panel[c * height + size + j..][..rest - j];
                let a = sign * r[0];
                for (t, r) in target.iter_mut().zip(r) {
                    *t -= a * r;
                }
            }
        }
    }

    #[inline(never)]
    fn eliminate_in_panels(
        &mut self,
        kind: Definiteness,
        signs: &mut Vec<f64>,
        threads: usize,
    ) -> Result<Pivots, BadPivot> {
        let (size, height) = (self.size, self.height());
        let mut pivots = Pivots::default();
        for start in (0..size).step_by(PANEL) {
            let end = size.min(start + PANEL);
            let (done, ahead) = self.panel.split_at_mut(end * height);
            pivots = pivots.join(panel(done, height, start..end, kind, signs, threads)?);
            let block =
                MatRef::from_column_major_slice(&done[start * height..], height, end - start);
            subtract_product(ahead, height, end, block, &signs[start..end], threads);
        }
        for c in 0..size {
            let diagonal = &mut self.panel[c * height + c];
            *diagonal = diagonal.recip();
        }
        let factor = MatRef::from_column_major_slice(&*self.panel, height, size);
        let rest = factor.subrows(size, self.rest);
        subtract_product(self.update, self.rest, 0, rest, signs, threads);
        Ok(pivots)
    }
}

/// Eliminates some columns, all of whose earlier ones are eliminated and have updated them, column by
/// column; leaves the *inverse* of the diagonal there.
#[inline(always)]
fn eliminate_columns(
    panel: &mut [f64],
    height: usize,
    columns: std::ops::Range<usize>,
    kind: Definiteness,
    signs: &mut Vec<f64>,
) -> Result<Pivots, BadPivot> {
    let mut pivots = Pivots::default();
    for c in columns.clone() {
        let (left, right) = panel.split_at_mut((c + 1) * height);
        let column = &mut left[c * height + c..];
        let pivot = column[0];
        let wrong = kind == Definiteness::Positive && pivot <= 0.0;
        if !pivot.is_finite() || pivot == 0.0 || wrong {
            return Err(BadPivot);
        }
        let inverse = pivot.abs().sqrt().recip();
        let sign = pivot.signum();
        signs.push(sign);
        pivots.negative += usize::from(sign < 0.0);
        column[0] = inverse;
        for v in &mut column[1..] {
            *v *= sign * inverse;
        }
        if kind == Definiteness::Any {
            let largest = column[1..]
                .iter()
                .fold(pivot.abs(), |m: f64, v| m.max(v * v));
            pivots.growth = pivots.growth.max(largest);
        }
        for later in c + 1..columns.end {
            let a = sign * column[later - c];
            let target = &mut right[(later - c - 1) * height + later..(later - c) * height];
            for (t, v) in target.iter_mut().zip(&column[later - c..]) {
                *t -= a * v;
            }
        }
    }
    Ok(pivots)
}

/// Eliminates a panel of a large front: its square by columns, what is below by a triangular solve.
/// Leaves the diagonal itself on the diagonal.
fn panel(
    done: &mut [f64],
    height: usize,
    columns: std::ops::Range<usize>,
    kind: Definiteness,
    signs: &mut Vec<f64>,
    threads: usize,
) -> Result<Pivots, BadPivot> {
    let width = columns.len();
    let mut square = [0.0; PANEL * PANEL];
    let first = columns.start * height;
    let square = &mut square[..width * width];
    for c in 0..width {
        let at = first + c * height + columns.start;
        square[c * width + c..(c + 1) * width].copy_from_slice(&done[at + c..at + width]);
    }
    let mut pivots = small_square(square, width, kind, signs)?;
    for c in 0..width {
        square[c * width + c] = square[c * width + c].recip();
        let at = first + c * height + columns.start;
        done[at + c..at + width].copy_from_slice(&square[c * width + c..(c + 1) * width]);
    }
    let triangle = MatRef::from_column_major_slice(&*square, width, width);
    let below = MatMut::from_column_major_slice_mut(&mut done[first..], height, width)
        .subrows_mut(columns.end, height - columns.end);
    let largest = solve_rows(triangle, below, &signs[columns], kind, threads);
    pivots.growth = pivots.growth.max(largest);
    Ok(pivots)
}

/// [`eliminate_columns`] of a square, with the widest SIMD of the machine.
fn small_square(
    square: &mut [f64],
    width: usize,
    kind: Definiteness,
    signs: &mut Vec<f64>,
) -> Result<Pivots, BadPivot> {
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || eliminate_columns(square, width, 0..width, kind, signs),
    )
}

/// B ← B C₁^-T S, rows in tiles; returns the largest square of an entry where that is of interest.
fn solve_rows(
    triangle: MatRef<'_, f64>,
    mut below: MatMut<'_, f64>,
    signs: &[f64],
    kind: Definiteness,
    threads: usize,
) -> f64 {
    let rows = below.nrows();
    if rows > TILE {
        let middle = (rows / 2).next_multiple_of(TILE).min(rows - 1);
        let (upper, lower) = below.split_at_row_mut(middle);
        let halves = || {
            let half = |part| solve_rows(triangle, part, signs, kind, threads);
            if threads > 1 {
                rayon::join(
                    || half(upper),
                    || solve_rows(triangle, lower, signs, kind, threads),
                )
            } else {
                (
                    half(upper),
                    solve_rows(triangle, lower, signs, kind, threads),
                )
            }
        };
        let (a, b) = halves();
        return a.max(b);
    }
    solve_lower_triangular_in_place(triangle, below.rb_mut().transpose_mut(), Par::Seq);
    let mut largest = 0.0;
    if kind == Definiteness::Any {
        for (c, &sign) in signs.iter().enumerate() {
            for v in below.rb_mut().col_mut(c).iter_mut() {
                *v *= sign;
                largest = f64::max(largest, *v * *v);
            }
        }
    }
    largest
}

/// A ← A − C S Cᵀ for the lower triangle of a column-major matrix whose first column is number `first`
/// of the rows of C; A has `height` rows, as many as C, and only those from its diagonal on count.
fn subtract_product(
    a: &mut [f64],
    height: usize,
    first: usize,
    c: MatRef<'_, f64>,
    signs: &[f64],
    threads: usize,
) {
    if a.is_empty() || height == 0 {
        return;
    }
    let signed = signs
        .contains(&-1.0)
        .then(|| faer::Mat::from_fn(c.nrows(), c.ncols(), |i, j| c[(i, j)] * signs[j]));
    let right = signed.as_ref().map_or(c, |m| m.as_ref());
    let tile = |(t, columns): (usize, &mut [f64])| {
        let start = first + t * TILE;
        let width = columns.len() / height;
        let whole = MatMut::from_column_major_slice_mut(columns, height, width);
        let (square, below) = whole.split_at_row_mut(start).1.split_at_row_mut(width);
        let right = right.subrows(start, width).transpose();
        triangular::matmul(
            square,
            BlockStructure::TriangularLower,
            Accum::Add,
            c.subrows(start, width),
            BlockStructure::Rectangular,
            right,
            BlockStructure::Rectangular,
            -1.0,
            Par::Seq,
        );
        let left = c.subrows(start + width, height - start - width);
        matmul(below, Accum::Add, left, right, -1.0, Par::Seq);
    };
    if threads > 1 {
        a.par_chunks_mut(TILE * height).enumerate().for_each(tile);
    } else {
        a.chunks_mut(TILE * height).enumerate().for_each(tile);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// A diagonally dominant matrix; some diagonal entries are negative if it may be indefinite.
    fn matrix(n: usize, kind: Definiteness) -> Mat<f64> {
        let entry = |i: usize, j: usize| ((i * 37 + j * 61) % 97) as f64 / 97.0 - 0.5;
        Mat::from_fn(n, n, |i, j| {
            let negative = kind == Definiteness::Any && i % 7 == 3;
            match i == j {
                true if negative => -(n as f64),
                true => n as f64,
                false => entry(i.max(j), i.min(j)),
            }
        })
    }

    /// Eliminates `size` of n columns and multiplies out: the largest difference from the matrix.
    fn error(n: usize, size: usize, kind: Definiteness, threads: usize) -> (f64, Pivots) {
        let (a, rest) = (matrix(n, kind), n - size);
        let mut panel: Vec<f64> = (0..size * n).map(|at| a[(at % n, at / n)]).collect();
        let entry = |at: usize| a[(size + at % rest.max(1), size + at / rest.max(1))];
        let mut update: Vec<f64> = (0..rest * rest).map(entry).collect();
        let mut front = Front {
            size,
            panel: &mut panel,
            rest,
            update: &mut update,
        };
        let mut signs = Vec::new();
        let pivots = front.eliminate(kind, &mut signs, threads).unwrap();
        let c = Mat::from_fn(n, size, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => panel[j * n + i].recip(),
            std::cmp::Ordering::Greater => panel[j * n + i],
        });
        // Columns below a negative pivot may carry either sign: only products of two count.
        let scaled = Mat::from_fn(n, size, |i, j| c[(i, j)] * signs[j]);
        let product = &c * scaled.transpose();
        let mut worst = 0.0;
        for j in 0..n {
            for i in j..n {
                let left = if j >= size {
                    update[(j - size) * rest + i - size]
                } else {
                    0.0
                };
                worst = f64::max(worst, (product[(i, j)] + left - a[(i, j)]).abs());
            }
        }
        (worst, pivots)
    }

    #[test]
    fn eliminating_and_multiplying_out_gives_the_matrix() {
        for (n, size) in [
            (1, 1),
            (9, 4),
            (20, 20),
            (60, 7),
            (200, 130),
            (300, 64),
            (450, 300),
        ] {
            for threads in [1, 2] {
                let (error, pivots) = error(n, size, Definiteness::Positive, threads);
                assert!(error < 1e-12 * n as f64, "{size} of {n}: {error}");
                assert_eq!(pivots.negative, 0);
            }
            let (error, pivots) = error(n, size, Definiteness::Any, 1);
            assert!(
                error < 1e-12 * n as f64,
                "{size} of {n}, indefinite: {error}"
            );
            assert_eq!(pivots.negative, (0..size).filter(|i| i % 7 == 3).count());
        }
    }

    #[test]
    fn a_pivot_of_the_wrong_sign_is_refused() {
        for mut panel in [[0.0], [-1.0], [f64::NAN], [f64::INFINITY]] {
            let mut front = Front {
                size: 1,
                panel: &mut panel,
                rest: 0,
                update: &mut [],
            };
            let result = front.eliminate(Definiteness::Positive, &mut Vec::new(), 1);
            assert_eq!(result, Err(BadPivot));
        }
    }
}
