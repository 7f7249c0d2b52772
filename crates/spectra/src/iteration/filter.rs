//! A polynomial filter in M⁻¹ = (L + σI)⁻¹ that keeps the low end of L's spectrum.
//!
//! With t = (λ_cut + σ) / (λ + σ), which is above 1 below the cut and in (0, 1) above it,
//!
//!   p_d(λ) = tᵐ · T_{d−m}(2t − 1),  m ≥ 1,
//!
//! T the Chebyshev polynomial: at most 1 beyond the cut, and below it as large as any polynomial of
//! its degree (Zhou, Saad, Tiago & Chelikowsky 2006, for the idea with L in place of M⁻¹). The extra
//! factor t damps each mode in proportion to 1/λ, which is how much it would weigh in a residual. A
//! second one (m = 2) is worth its loss of gain on vectors extended to new nodes, which are full of
//! modes far beyond the cut: without it mazes take a third more solves, and more than one round.
//! Written as a product over its roots a filter of degree d costs d block solves and one vector
//! update each, and no inner product: one Rayleigh–Ritz step serves d solves.

use super::shift_invert::ShiftInvert;
use crate::block::RowBlock;
use crate::block::simd::{self, Panel, PanelKernel};
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
pub(crate) struct Filter {
    /// λ_cut + σ.
    edge: f64,
    sigma: f64,
    solves: usize,
    /// m.
    damping: usize,
}

impl Filter {
    /// The filters of degree 1, 2, … for a cut, as far as they do not let low modes take over all
    /// columns. `admixtures` lists low modes with the share that they have in columns not their own;
    /// `damping` is m, at least 1.
    pub(crate) fn family(
        admixtures: &[(f64, f64)],
        cut: f64,
        sigma: f64,
        damping: usize,
    ) -> Vec<Self> {
        let of_degree = |solves| Self {
            edge: cut + sigma,
            sigma,
            solves,
            damping: damping.min(solves),
        };
        let is_safe = |filter: &Self| {
            let spread = |&(lambda, share): &(f64, f64)| share * filter.gain(lambda);
            filter.solves == 1 || admixtures.iter().map(spread).fold(0.0, f64::max) <= MOST_SPREAD
        };
        (1..=MOST_SOLVES)
            .map(of_degree)
            .take_while(is_safe)
            .collect()
    }

    /// The cheapest filter that amplifies λ = `wanted` by `gain` over everything beyond `cut`; or the
    /// strongest of its family.
    pub(crate) fn with_gain(
        (gain, wanted): (f64, f64),
        admixtures: &[(f64, f64)],
        cut: f64,
        sigma: f64,
    ) -> Self {
        let family = Self::family(admixtures, cut, sigma, 1);
        let enough = family.iter().find(|f| f.gain(wanted) >= gain);
        *enough
            .or(family.last())
            .expect("a family has a first member")
    }

    /// Block solves it takes.
    pub(crate) fn solves(&self) -> usize {
        self.solves
    }

    /// |p(λ)|.
    pub(crate) fn gain(&self, lambda: f64) -> f64 {
        let t = self.edge / (lambda + self.sigma);
        (t.powi(self.damping as i32) * chebyshev(self.solves - self.damping, 2.0 * t - 1.0)).abs()
    }

    /// x ← p(L) x up to a factor, and z with x = M⁻¹ z.
    pub(crate) fn apply(&self, op: &ShiftInvert<'_>, x: &mut RowBlock, z: &mut RowBlock) {
        let degree = self.solves - self.damping;
        let projects = self.gain(0.0) > NULL_GAIN;
        for _ in 1..self.damping {
            solve(op, x, projects);
        }
        z.copy_from(x, op.threads());
        for i in 0..degree {
            let angle = (2 * i + 1) as f64 / (2 * degree) as f64;
            let root = (1.0 + libm::cos(std::f64::consts::PI * angle)) / 2.0;
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
