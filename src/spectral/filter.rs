//! A polynomial filter in M⁻¹ = (L + σI)⁻¹ that keeps the low end of L's spectrum.
//!
//! With t = (λ_cut + σ) / (λ + σ), which is above 1 below the cut and in (0, 1) above it,
//!
//!   p_d(λ) = t · T_{d−1}(2t − 1),
//!
//! T the Chebyshev polynomial: at most 1 beyond the cut, and below it as large as any polynomial of
//! its degree (Zhou, Saad, Tiago & Chelikowsky 2006, for the idea with L in place of M⁻¹). The extra
//! factor t damps each mode in proportion to 1/λ, which is how much it would weigh in a residual.
//! Written as a product over its roots a filter of degree d costs d block solves and one vector
//! update each, and no inner product: one Rayleigh–Ritz step serves d solves.

use super::block::RowBlock;
use super::shift_invert::ShiftInvert;
use super::simd;

/// Highest degree in one go.
const MOST_SOLVES: usize = 12;

/// Largest share of low modes that amplification may give a column: beyond it the columns become too
/// parallel for the Rayleigh–Ritz step to tell them apart (their Gram matrix has the square of it).
const MOST_SPREAD: f64 = 1e6;

/// Amplification of rounding errors along the null space, p(0), from which they are projected out
/// after every solve rather than once at the end, where they would hide the columns.
const NULL_GAIN: f64 = 1e6;

/// A filter of degree d = `solves`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filter {
    /// λ_cut + σ.
    edge: f64,
    sigma: f64,
    solves: usize,
}

impl Filter {
    /// The cheapest filter, of at least two solves, that amplifies λ = `wanted` by `gain` over
    /// everything beyond `cut`; or the strongest that does not let low modes take over all columns.
    /// `admixtures` lists low modes with the share that they have in columns not their own.
    pub(super) fn with_gain(
        (gain, wanted): (f64, f64),
        admixtures: &[(f64, f64)],
        cut: f64,
        sigma: f64,
    ) -> Self {
        let mut filter = Self {
            edge: cut + sigma,
            sigma,
            solves: 2,
        };
        while filter.solves < MOST_SOLVES && filter.gain(wanted) < gain {
            let next = Self {
                solves: filter.solves + 1,
                ..filter
            };
            let spread = |&(lambda, share): &(f64, f64)| share * next.gain(lambda);
            if admixtures.iter().map(spread).fold(0.0, f64::max) > MOST_SPREAD {
                break;
            }
            filter = next;
        }
        filter
    }

    /// Block solves it takes.
    pub(super) fn solves(&self) -> usize {
        self.solves
    }

    /// |p(λ)|.
    pub(super) fn gain(&self, lambda: f64) -> f64 {
        let t = self.edge / (lambda + self.sigma);
        (t * chebyshev(self.solves - 1, 2.0 * t - 1.0)).abs()
    }

    /// x ← p(L) x up to a factor, and z with x = M⁻¹ z.
    pub(super) fn apply(&self, op: &ShiftInvert<'_>, x: &mut RowBlock, z: &mut RowBlock) {
        let degree = self.solves - 1;
        let projects = self.gain(0.0) > NULL_GAIN;
        for i in 0..degree {
            let angle = (2 * i + 1) as f64 / (2 * degree) as f64;
            let root = (1.0 + (std::f64::consts::PI * angle).cos()) / 2.0;
            z.copy_from(x);
            solve(op, x, projects);
            subtract(x, self.edge, root, z, op.threads());
        }
        z.copy_from(x);
        solve(op, x, projects);
    }
}

/// x ← M⁻¹ x, off the null space if it `projects`.
fn solve(op: &ShiftInvert<'_>, x: &mut RowBlock, projects: bool) {
    op.solve(x);
    if projects {
        op.project(x);
    }
}

/// x ← scale x − root z
fn subtract(x: &mut RowBlock, scale: f64, root: f64, z: &RowBlock, threads: usize) {
    let width = x.width();
    simd::for_each_stretch_mut(x.as_mut_slice(), width, threads, |rows, x| {
        let z = &z.as_slice()[rows.start * width..rows.end * width];
        for (x, z) in x.iter_mut().zip(z) {
            *x = scale * *x - root * z;
        }
    });
}

/// T_d(x).
fn chebyshev(degree: usize, x: f64) -> f64 {
    let (mut current, mut next) = (1.0, x);
    for _ in 0..degree {
        (current, next) = (next, 2.0 * x * next - current);
    }
    current
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_is_at_most_one_beyond_the_cut_and_grows_below() {
        let filter = Filter::with_gain((100.0, 1.0), &[(0.1, 0.1)], 1.5, 1.0);
        for i in 0..1000 {
            let beyond = 1.5 + 0.01 * f64::from(i).powi(2);
            assert!(filter.gain(beyond) <= 1.0 + 1e-12);
        }
        assert!(filter.gain(1.0) >= 100.0);
        assert!(filter.gain(0.1) > filter.gain(0.5) && filter.gain(0.5) > filter.gain(1.0));
    }

    #[test]
    fn the_spread_limits_the_degree() {
        let with = |share| Filter::with_gain((1e3, 1.0), &[(1e-6, share)], 1.5, 0.1);
        assert!(with(1.0).gain(1e-6) <= MOST_SPREAD);
        assert!(with(1.0).gain(1.0) < 1e3);
        assert!(with(1e-9).gain(1.0) >= 1e3);
    }
}
