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

    /// dℓ/dq by position, from dℓ/dv = `gradient` at the solution `v`: at most `max_sweeps` sweeps, until λ changes
    /// by no more than `tol` times its largest entry. Returns λ and the sweeps it took. O(nnz) a sweep.
    ///
    /// # Panics
    /// If `v` or `gradient` has not one entry per position.
    pub fn solve(
        &mut self,
        diffusion: &Diffusion<'_>,
        v: &[f64],
        gradient: &[f64],
        tol: f64,
        max_sweeps: usize,
    ) -> (&[f64], usize) {
        let chain = diffusion.chain();
        assert_eq!((v.len(), gradient.len()), (chain.len(), chain.len()), "by position");
        diffusion.controlled_walk(v, &mut self.weights);
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
            // Overshooting: fall back to the plain sweep, a regular splitting of an M-matrix, which converges.
            if change > 2.0 * last_change && carry > 0.0 {
                carry = 0.0;
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
            if i < chain.num_goals() { 0.0 } else { far_weight(i).min(carry) }
        }));
    }

    /// One sweep; returns the largest change of λ relative to its largest entry.
    fn sweep(&mut self, chain: &Chain, gradient: &[f64]) -> f64 {
        let Self { lambda, inflow, weights, carried } = self;
        let push = |inflow: &mut [f64], range: std::ops::Range<usize>, amount: f64| {
            for (&j, &w) in chain.columns()[range.clone()].iter().zip(&weights[range]) {
                inflow[j as usize] += w * amount;
            }
        };
        inflow.clear();
        inflow.extend_from_slice(gradient);
        for i in chain.num_goals()..chain.len() {
            push(inflow, chain.far_range(i), lambda[i]);
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
