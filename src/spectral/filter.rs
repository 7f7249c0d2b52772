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
use super::simd::{self, Panel, PanelKernel};
use pulp::Simd;

/// Highest degree in one go.
const MOST_SOLVES: usize = 12;

/// Largest share of low modes that amplification may give a column: beyond it the columns become too
/// parallel for the Rayleigh–Ritz step to tell them apart (their Gram matrix has the square of it).
const MOST_SPREAD: f64 = 1e6;

/// Amplification of rounding errors along the null space, p(0), from which they are projected out
/// after every solve rather than once at the end, where they would hide the columns.
const NULL_GAIN: f64 = 1e10;

/// A filter of degree d = `solves`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filter {
    /// λ_cut + σ.
    edge: f64,
    sigma: f64,
    solves: usize,
}

impl Filter {
    /// The cheapest filter that amplifies λ = `wanted` by `gain` over
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
            solves: 1,
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
        z.copy_from(x, op.threads());
        for i in 0..degree {
            let angle = (2 * i + 1) as f64 / (2 * degree) as f64;
            let root = (1.0 + (std::f64::consts::PI * angle).cos()) / 2.0;
            solve(op, x, projects);
            combine(x, self.edge, root, z, op.threads());
        }
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

/// x ← edge x − root z and z ← x, in one pass.
fn combine(x: &mut RowBlock, edge: f64, root: f64, z: &mut RowBlock, threads: usize) {
    let width = x.width();
    let (x, z) = (x.as_mut_slice(), z.as_mut_slice());
    simd::for_each_stretch_pair_mut(x, z, width, threads, |x, z| {
        simd::for_each_panel(width, Combine { x, z, edge, root });
    });
}

struct Combine<'a> {
    x: &'a mut [f64],
    z: &'a mut [f64],
    edge: f64,
    root: f64,
}

impl PanelKernel for Combine<'_> {
    #[inline(always)]
    fn run<S: Simd, const NV: usize>(&mut self, simd: S, panel: Panel) {
        let x = S::as_mut_simd_f64s(self.x).0;
        let z = S::as_mut_simd_f64s(self.z).0;
        let (edge, root) = (simd.splat_f64s(self.edge), simd.splat_f64s(self.root));
        for i in 0..x.len() / panel.stride {
            let mut xi: [_; NV] = panel.load(&*x, i);
            let zi: [_; NV] = panel.load(&*z, i);
            for v in 0..NV {
                xi[v] = simd.mul_f64s(edge, xi[v]);
                xi[v] = simd.negate_mul_add_f64s(root, zi[v], xi[v]);
            }
            panel.store(x, i, xi);
            panel.store(z, i, xi);
        }
    }
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
