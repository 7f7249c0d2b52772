//! The gradient of a function of v with respect to q, by one linear solve instead of one per state.
//!
//! ```text
//! dv = dq + W dv     ⟹     dℓ/dq = λ   with   λ = g + Wᵀ λ,   g = dℓ/dv
//! ```
//!
//! W is the transition matrix of the optimally controlled walk ([`Diffusion::controlled_walk`]), so λ_i is the
//! gradient that flows through i on its way to the goals, where it leaves.
//!
//! The iteration is the transpose of the forward one. With t_i the part of row i's far weight that the sweep carries
//! along, I − W = M − N, M = diag(1 − t) − W_near, N = W_far − diag(t), and a sweep is Mᵀ λ_new = g + Nᵀ λ_old, run
//! from the farthest state inwards. It inherits the forward sweep's rate: also here the number of sweeps does not grow
//! with the path length.

use super::chain::Chain;
use super::diffusion::Diffusion;

/// Buffers of the adjoint solve, and λ: kept from one solve to the next as the start of the following one.
#[derive(Clone, Debug, Default)]
pub struct Adjoint {
    /// λ by position; 0 on goals.
    lambda: Vec<f64>,
    /// g plus what has flowed in so far.
    inflow: Vec<f64>,
    /// W, in the layout of the chain's columns.
    weights: Vec<f64>,
    /// t by position.
    carried: Vec<f64>,
}

impl Adjoint {
    /// Starts anew: λ = 0.
    pub fn reset(&mut self) {
        self.lambda.clear();
    }

    /// dℓ/dq by position, from dℓ/dv = `gradient` at the v that `diffusion` solved last: at most `max_sweeps` sweeps,
    /// until λ changes by no more than `tol` times its largest entry. Returns λ and the sweeps it took. O(nnz) a sweep.
    ///
    /// # Panics
    /// If `gradient` has not one entry per position, or nothing was solved yet.
    pub fn solve(
        &mut self,
        diffusion: &Diffusion<'_>,
        gradient: &[f64],
        tol: f64,
        max_sweeps: usize,
    ) -> (&[f64], usize) {
        let chain = diffusion.chain();
        assert_eq!(gradient.len(), chain.len(), "one entry per position");
        diffusion.controlled_walk(&mut self.weights);
        self.lambda.resize(chain.len(), 0.0);
        let mut carry = diffusion.carry();
        self.set_carried(chain, carry);
        let (mut sweeps, mut last_change) = (0, f64::INFINITY);
        while sweeps < max_sweeps {
            let change = self.sweep(chain, gradient);
            sweeps += 1;
            if change <= tol {
                break;
            }
            // Overshooting: towards the plain sweep, a regular splitting of an M-matrix, which converges.
            if change > 2.0 * last_change {
                carry *= 0.5;
                self.set_carried(chain, carry);
            }
            last_change = last_change.min(change);
        }
        (&self.lambda, sweeps)
    }

    fn set_carried(&mut self, chain: &Chain, carry: f64) {
        let far_weight = |i| self.weights[chain.far_range(i)].iter().sum::<f64>();
        self.carried.clear();
        self.carried.extend((0..chain.len()).map(|i| {
            if i < chain.num_goals() {
                0.0
            } else {
                far_weight(i).min(carry)
            }
        }));
    }

    /// One sweep; returns the largest change of λ relative to its largest entry.
    fn sweep(&mut self, chain: &Chain, gradient: &[f64]) -> f64 {
        let Self {
            lambda,
            inflow,
            weights,
            carried,
        } = self;
        let push = |inflow: &mut [f64], range: std::ops::Range<usize>, amount: f64| {
            for (&j, &w) in chain.columns()[range.clone()].iter().zip(&weights[range]) {
                inflow[j as usize] += w * amount;
            }
        };
        inflow.clear();
        inflow.extend_from_slice(gradient);
        for (i, &old) in lambda.iter().enumerate().skip(chain.num_goals()) {
            push(inflow, chain.far_range(i), old);
        }
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for i in (chain.num_goals()..chain.len()).rev() {
            let new = (inflow[i] - carried[i] * lambda[i]) / (1.0 - carried[i]);
            change = change.max((new - lambda[i]).abs());
            largest = largest.max(new.abs());
            lambda[i] = new;
            push(inflow, chain.near_range(i), new);
        }
        if change == 0.0 { 0.0 } else { change / largest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{any_graph, chain, graph, grid, path};
    use proptest::prelude::*;

    const STEP: f64 = 1e-5;

    fn solve<'c>(chain: &'c Chain, q: &[f64]) -> (Diffusion<'c>, Vec<f64>) {
        let mut diffusion = Diffusion::new(chain);
        let mut v = diffusion.cold_start(&vec![0.0; chain.num_goals()]);
        assert!(diffusion.solve(q, &mut v, 1e-12).residual < 1e-11);
        (diffusion, v)
    }

    /// ℓ = Σ g_i v_i, so that dℓ/dv = g, by central differences.
    fn finite_difference(chain: &Chain, q: &[f64], g: &[f64], i: usize) -> f64 {
        let loss = |step: f64| -> f64 {
            let mut q = q.to_vec();
            q[i] += step;
            solve(chain, &q).1.iter().zip(g).map(|(v, g)| v * g).sum()
        };
        (loss(STEP) - loss(-STEP)) / (2.0 * STEP)
    }

    fn assert_gradient_is_right(chain: &Chain, q: &[f64], g: &[f64]) {
        let (diffusion, _) = solve(chain, q);
        let mut adjoint = Adjoint::default();
        let (lambda, _) = adjoint.solve(&diffusion, g, 1e-14, 10_000);
        let largest = lambda.iter().fold(0.0_f64, |m, l| m.max(l.abs()));
        for (i, found) in lambda.iter().enumerate().skip(chain.num_goals()) {
            let expected = finite_difference(chain, q, g, i);
            let error = (found - expected).abs() / largest.max(1e-3);
            assert!(error < 1e-6, "position {i}: {found} against {expected}");
        }
    }

    #[test]
    fn gradients_agree_with_finite_differences() {
        for adjacency in [
            grid(6, 5, &[7, 12]),
            path(30),
            graph(8, &[(0, 1), (1, 2), (1, 3), (1, 4), (1, 5), (1, 6), (6, 7)]),
        ] {
            let chain = chain(&adjacency, &[0]);
            let q: Vec<f64> = (0..chain.len())
                .map(|i| 0.2 + 0.2 * (i % 4) as f64)
                .collect();
            let g: Vec<f64> = (0..chain.len()).map(|i| (i % 3) as f64 - 0.7).collect();
            assert_gradient_is_right(&chain, &q, &g);
        }
    }

    /// All that flows in must flow out: with g = 1 at the far end of a path, λ is the expected number of visits,
    /// and the first state past the goal is left for good with probability W_1,goal.
    #[test]
    fn a_long_path_takes_few_sweeps() {
        let chain = chain(&path(5_000), &[0]);
        let q = vec![0.7; chain.len()];
        let (diffusion, _) = solve(&chain, &q);
        let mut g = vec![0.0; chain.len()];
        g[4_999] = 1.0;
        let mut adjoint = Adjoint::default();
        let (lambda, sweeps) = adjoint.solve(&diffusion, &g, 1e-12, 100);
        assert!(sweeps < 40, "{sweeps} sweeps");
        let mut weights = Vec::new();
        diffusion.controlled_walk(&mut weights);
        let leaves = weights[chain.near_range(1).start];
        assert!(
            (lambda[1] * leaves - 1.0).abs() < 1e-9,
            "{} · {leaves}",
            lambda[1]
        );
    }

    #[test]
    fn a_warm_start_needs_no_further_sweeps() {
        let chain = chain(&grid(20, 20, &[]), &[0]);
        let (diffusion, _) = solve(&chain, &vec![0.7; chain.len()]);
        let g = vec![1.0; chain.len()];
        let mut adjoint = Adjoint::default();
        assert!(adjoint.solve(&diffusion, &g, 1e-9, 1000).1 > 3);
        assert_eq!(adjoint.solve(&diffusion, &g, 1e-8, 1000).1, 1);
        adjoint.reset();
        assert!(adjoint.solve(&diffusion, &g, 1e-9, 1000).1 > 3);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn any_graph_has_the_right_gradient(
            adjacency in any_graph(),
            q in prop::collection::vec(0.1_f64..3.0, 24),
            g in prop::collection::vec(-1.0_f64..1.0, 24),
        ) {
            let chain = chain(&adjacency, &[0]);
            assert_gradient_is_right(&chain, &q[..chain.len()], &g[..chain.len()]);
        }
    }
}
