//! A linearly solvable Markov decision problem (Todorov 2006) on the visited graph, solved in the log domain.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,   u_g = e^{−v_g} on goals             linear in u
//! v_i = q_i − ln Σ_j P_ij e^{−v_j},   v = −ln u                      the same: a soft-min Bellman equation
//! ```
//!
//! q_i > 0 is the cost of a step from i. u shrinks by a constant factor per hop and underflows after some hundred
//! hops, so v is what is stored.
//!
//! **Maximum principle**: the sum is an average, hence v_i ≥ q_i + min_j v_j for *every* q, and φ = −v has a larger
//! neighbour wherever there is no goal. A solution with Bellman residual below min q keeps this property, so stopping
//! early does no harm.
//!
//! # The sweep
//! Gauss–Seidel in order of cost-to-go carries values far in one pass, but each state also averages over far
//! neighbours whose value is still the old one. If everything beyond i is too high by δ, i keeps a part of δ, and news
//! from the goal travels only some 14 hops a sweep: hundreds of sweeps in a maze. What is nearly right in the old
//! iterate is not v_j but the *difference* v_j − v_i. With a = Σ_far e^{−q_i} P_ij e^{v_i − v_j} taken from the old
//! iterate (the probability that the optimally controlled walk steps away from the goal),
//!
//! ```text
//! u_i = (e^{−q_i} Σ_near P_ij u_j) / (1 − a),
//! ```
//!
//! which is exact elimination on a path and on a tree, and makes the number of sweeps independent of the path length.
//! It may overshoot where a > ½; there only ½ is carried along and the rest keeps its old value. Should the residual
//! still not fall, the plain sweep takes over, which always converges (u ↦ e^{−q} P u is a contraction).

use super::chain::Chain;
use serde::{Deserialize, Serialize};

/// The largest share of a row's weight that is carried along with it: at ½ the error of a far difference enters with
/// factor a / (1 − a) = 1.
const CARRY: f64 = 0.5;

/// Sweeps between two looks at the residual, which costs about as much as a sweep.
const SWEEPS_PER_CHECK: usize = 3;

/// A residual that fell by less than this between two looks counts as stalled.
const STALLED: f64 = 0.7;

/// What a solve cost and how well it did. Not converging is a result, not an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolveReport {
    /// Sweeps over all states.
    pub sweeps: usize,
    /// max_i |v_i − (q_i − ln Σ_j P_ij e^{−v_j})|, in nats.
    pub residual: f64,
    /// Whether the residual reached the tolerance.
    pub converged: bool,
}

/// The solver: the chain, and how much a sweep may carry along.
#[derive(Clone, Debug)]
pub struct Diffusion<'c> {
    chain: &'c Chain,
    carry: f64,
}

impl<'c> Diffusion<'c> {
    /// A solver on `chain`.
    pub fn new(chain: &'c Chain) -> Self {
        Self { chain, carry: CARRY }
    }

    /// The chain it solves on.
    pub fn chain(&self) -> &'c Chain {
        self.chain
    }

    /// The share of a row's weight that sweeps carry along at present: 0 after a fall-back to plain sweeps.
    pub(crate) fn carry(&self) -> f64 {
        self.carry
    }

    /// v for "nothing known yet": `terminal` on goals, ∞ elsewhere.
    ///
    /// # Panics
    /// If `terminal` has not one entry per goal.
    pub fn cold_start(&self, terminal: &[f64]) -> Vec<f64> {
        assert_eq!(terminal.len(), self.chain.num_goals(), "one terminal cost per goal");
        let mut v = terminal.to_vec();
        v.resize(self.chain.len(), f64::INFINITY);
        v
    }

    /// Sweeps until the Bellman residual is ≤ `tol`. `q` and `v` are by position; `v` is the start (see
    /// [`cold_start`](Self::cold_start); or the solution for a similar q) and the result, its goal entries are kept.
    /// O(nnz) a sweep, some ten sweeps for q around 0.7; at most 100 + 4 × (number of positions)^½ + hops-like
    /// many, see [`max_sweeps`](Self::max_sweeps).
    ///
    /// # Panics
    /// If `q` or `v` has not one entry per position.
    pub fn solve(&mut self, q: &[f64], v: &mut [f64], tol: f64) -> SolveReport {
        let mut report = SolveReport { residual: f64::INFINITY, ..Default::default() };
        while report.sweeps < self.max_sweeps() {
            for _ in 0..SWEEPS_PER_CHECK {
                self.sweep(q, v);
            }
            report.sweeps += SWEEPS_PER_CHECK;
            let residual = self.residual(q, v);
            // `!(<)` also catches a NaN, which would otherwise look like progress.
            if !(residual < STALLED * report.residual) && residual > tol {
                self.carry = 0.0;
            }
            report.residual = residual;
            if residual <= tol {
                report.converged = true;
                break;
            }
        }
        report
    }

    /// When [`solve`](Self::solve) gives up: plain sweeps need about one per 14 hops, and no chain has more hops than
    /// states.
    pub fn max_sweeps(&self) -> usize {
        300 + self.chain.len() / 8
    }

    /// One sweep, from the goals outwards.
    ///
    /// # Panics
    /// If `q` or `v` has not one entry per position.
    pub fn sweep(&self, q: &[f64], v: &mut [f64]) {
        assert_eq!((q.len(), v.len()), (self.chain.len(), self.chain.len()), "by position");
        for i in self.chain.num_goals()..v.len() {
            v[i] = self.updated(i, q[i], v);
        }
    }

    /// The new v_i. Sums are taken relative to the lowest neighbour, so that nothing under- or overflows.
    fn updated(&self, i: usize, q: f64, v: &[f64]) -> f64 {
        let row = self.chain.row(i);
        let lowest = lowest(row.near, v).min(lowest(row.far, v));
        let near = average(row.near, row.near_probabilities, v, lowest);
        let far = average(row.far, row.far_probabilities, v, lowest);
        if far == 0.0 {
            return q + lowest - near.ln();
        }
        // a, with u_i = e^{−v_i} the old one; v_i = ∞ gives a = ∞ and nothing is carried along.
        let away = far * (v[i] - lowest - q).exp();
        let carried = away.min(self.carry);
        q + lowest - (near + far * (1.0 - carried / away)).ln() + (-carried).ln_1p()
    }

    /// The Bellman residual max_i |v_i − (q_i − ln Σ_j P_ij e^{−v_j})|. O(nnz).
    pub fn residual(&self, q: &[f64], v: &[f64]) -> f64 {
        (self.chain.num_goals()..v.len())
            .map(|i| (v[i] - self.bellman(i, q[i], v)).abs())
            .fold(0.0, |worst, r| if r > worst || r.is_nan() { r } else { worst })
    }

    fn bellman(&self, i: usize, q: f64, v: &[f64]) -> f64 {
        let row = self.chain.row(i);
        let lowest = lowest(row.near, v).min(lowest(row.far, v));
        let near = average(row.near, row.near_probabilities, v, lowest);
        let far = average(row.far, row.far_probabilities, v, lowest);
        q + lowest - (near + far).ln()
    }

    /// W_ij = ∂v_i/∂v_j = P_ij e^{−v_j} / Σ_k P_ik e^{−v_k}, in the layout of the chain's columns: the transition
    /// matrix of the optimally controlled walk. Rows sum to 1. O(nnz).
    pub fn controlled_walk(&self, v: &[f64], weights: &mut Vec<f64>) {
        weights.clear();
        for i in self.chain.num_goals()..v.len() {
            let row = self.chain.row(i);
            let lowest = lowest(row.near, v).min(lowest(row.far, v));
            let start = weights.len();
            let pairs = [(row.near, row.near_probabilities), (row.far, row.far_probabilities)];
            for (columns, probabilities) in pairs {
                let terms = columns.iter().zip(probabilities);
                weights.extend(terms.map(|(&j, &p)| p * (lowest - v[j as usize]).exp()));
            }
            let total: f64 = weights[start..].iter().sum();
            weights[start..].iter_mut().for_each(|w| *w /= total);
        }
    }
}

fn lowest(columns: &[u32], v: &[f64]) -> f64 {
    columns.iter().map(|&j| v[j as usize]).fold(f64::INFINITY, f64::min)
}

/// Σ_j P_ij e^{reference − v_j}.
fn average(columns: &[u32], probabilities: &[f64], v: &[f64], reference: f64) -> f64 {
    let terms = columns.iter().zip(probabilities);
    terms.map(|(&j, &p)| p * (reference - v[j as usize]).exp()).sum()
}
