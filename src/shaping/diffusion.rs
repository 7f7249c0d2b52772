//! A linearly solvable Markov decision problem (Todorov 2006) on the visited graph, solved in the log domain.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,   u_g = e^{−v_g} on goals             linear in u
//! v_i = q_i − ln Σ_j P_ij e^{−v_j},   v = −ln u                      the same: a soft-min Bellman equation
//! ```
//!
//! q_i > 0 is the cost of a step from i. u shrinks by a constant factor per hop and underflows after some hundred
//! hops, so v is what is handed out, and inside u carries an exponent of its own.
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
//! It overshoots where a is large, so at most 0.4 is carried along and the rest keeps its old value. Should the
//! residual still not fall, that share is halved, down to the plain sweep, which always converges (u ↦ e^{−q} P u is a
//! contraction).

use super::chain::Chain;
use super::desirability::Desirability;
use serde::{Deserialize, Serialize};

/// The largest share of a row's weight that is carried along with it. The error of a far difference enters with
/// factor a / (1 − a), below 1 up to ½. Sweeps needed at q = 0.7 (0.2) with shares 0, 0.33, 0.4 and 0.5: path of 3 000
/// nodes 309, 9, 9, 9 (> 675, 18, 15, 15); random graph of 3 000 nodes 18, 27, 42, > 300 (45, 24, 36, 162).
const CARRY: f64 = 0.4;

/// Sweeps between two looks at the residual, which costs about as much as a sweep.
const SWEEPS_PER_CHECK: usize = 3;

/// Looks in a row without a new lowest residual after which sweeps carry less. In the first sweeps a residual may rise
/// before it falls for good.
const PATIENCE: usize = 8;

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

/// The solver: the chain, how much a sweep may carry along, and the buffers, reused from call to call.
#[derive(Clone, Debug)]
pub struct Diffusion<'c> {
    chain: &'c Chain,
    carry: f64,
    /// e^{−q} by position.
    kept: Vec<f64>,
    /// e^{−v} by position.
    u: Vec<Desirability>,
}

impl<'c> Diffusion<'c> {
    /// A solver on `chain`.
    pub fn new(chain: &'c Chain) -> Self {
        Self {
            chain,
            carry: CARRY,
            kept: Vec::new(),
            u: Vec::new(),
        }
    }

    /// The chain it solves on.
    pub fn chain(&self) -> &'c Chain {
        self.chain
    }

    /// The largest share of a row's weight that sweeps carry along at present.
    pub(crate) fn carry(&self) -> f64 {
        self.carry
    }

    /// v for "nothing known yet": `terminal` on goals, ∞ elsewhere.
    ///
    /// # Panics
    /// If `terminal` has not one entry per goal.
    pub fn cold_start(&self, terminal: &[f64]) -> Vec<f64> {
        assert_eq!(
            terminal.len(),
            self.chain.num_goals(),
            "one terminal cost per goal"
        );
        let mut v = terminal.to_vec();
        v.resize(self.chain.len(), f64::INFINITY);
        v
    }

    /// Sweeps until the Bellman residual is ≤ `tol`. `q` and `v` are by position; `v` is the start (see
    /// [`cold_start`](Self::cold_start); or the solution for a similar q) and the result, its goal entries are kept.
    /// O(nnz) a sweep, some ten to forty sweeps for q around 0.7, at most [`max_sweeps`](Self::max_sweeps).
    ///
    /// # Panics
    /// If `q` or `v` has not one entry per position.
    pub fn solve(&mut self, q: &[f64], v: &mut [f64], tol: f64) -> SolveReport {
        self.load(q, v);
        let mut report = SolveReport {
            residual: f64::INFINITY,
            ..Default::default()
        };
        let (mut best, mut stalls) = (f64::INFINITY, 0);
        while report.sweeps < self.max_sweeps() {
            (0..SWEEPS_PER_CHECK).for_each(|_| self.sweep());
            report.sweeps += SWEEPS_PER_CHECK;
            report.residual = self.residual();
            if report.residual <= tol {
                report.converged = true;
                break;
            }
            stalls = if report.residual < best {
                0
            } else {
                stalls + 1
            };
            best = best.min(report.residual);
            if stalls == PATIENCE {
                (self.carry, stalls) = (0.5 * self.carry, 0);
            }
        }
        self.store(v);
        report
    }

    /// When [`solve`](Self::solve) gives up. Plain sweeps need about one per 14 hops at q = 0.7, and no chain has more
    /// hops than states.
    pub fn max_sweeps(&self) -> usize {
        1000 + self.chain.len() / 32
    }

    /// `count` sweeps from `v`, from the goals outwards, without a look at the residual.
    ///
    /// # Panics
    /// If `q` or `v` has not one entry per position.
    pub fn sweeps(&mut self, q: &[f64], v: &mut [f64], count: usize) {
        self.load(q, v);
        (0..count).for_each(|_| self.sweep());
        self.store(v);
    }

    fn load(&mut self, q: &[f64], v: &[f64]) {
        assert_eq!(
            (q.len(), v.len()),
            (self.chain.len(), self.chain.len()),
            "by position"
        );
        self.kept.clear();
        self.kept.extend(q.iter().map(|q| (-q).exp()));
        self.u.clear();
        self.u.extend(v.iter().map(|&v| Desirability::from_cost(v)));
    }

    /// Goals keep what the caller wrote, to the bit.
    fn store(&self, v: &mut [f64]) {
        for (v, u) in v.iter_mut().zip(&self.u).skip(self.chain.num_goals()) {
            *v = u.cost();
        }
    }

    fn sweep(&mut self) {
        for i in self.chain.num_goals()..self.u.len() {
            let (near, far) = self.row_sums(i);
            // a, from the old u_i; ∞ while that is 0, and then nothing is carried along.
            let away = if far.is_zero() {
                0.0
            } else {
                self.kept[i] * far.over(self.u[i])
            };
            let carried = away.min(self.carry);
            let sum = if away > carried {
                near.plus(far.times(1.0 - carried / away))
            } else {
                near
            };
            self.u[i] = sum.times(self.kept[i] / (1.0 - carried));
        }
    }

    /// The Bellman residual max_i |v_i − (q_i − ln Σ_j P_ij e^{−v_j})| of what is loaded.
    fn residual(&self) -> f64 {
        // The extremes of u_i over its update need only one logarithm each.
        let mut extremes = (1.0_f64, 1.0_f64);
        for i in self.chain.num_goals()..self.u.len() {
            let (near, far) = self.row_sums(i);
            let ratio = self.u[i].over(near.plus(far).times(self.kept[i]));
            if ratio.is_nan() {
                return f64::NAN;
            }
            extremes = (extremes.0.min(ratio), extremes.1.max(ratio));
        }
        (-extremes.0.ln()).max(extremes.1.ln())
    }

    /// Σ_near P_ij u_j and Σ_far P_ij u_j. Apart, because in the middle of a sweep near values are new and far ones
    /// old, and the two may lie hundreds of orders of magnitude from each other.
    fn row_sums(&self, i: usize) -> (Desirability, Desirability) {
        let row = self.chain.row(i);
        let near = Desirability::weighted_sum(row.near, row.near_probabilities, &self.u);
        (
            near,
            Desirability::weighted_sum(row.far, row.far_probabilities, &self.u),
        )
    }

    /// W_ij = ∂v_i/∂v_j = P_ij u_j / Σ_k P_ik u_k at the v of the last [`solve`](Self::solve) or
    /// [`sweeps`](Self::sweeps), in the layout of the chain's columns: the transition matrix of the optimally
    /// controlled walk. Rows sum to 1. O(nnz).
    ///
    /// # Panics
    /// If nothing was solved yet.
    pub fn controlled_walk(&self, weights: &mut Vec<f64>) {
        assert_eq!(self.u.len(), self.chain.len(), "nothing was solved yet");
        weights.clear();
        for i in self.chain.num_goals()..self.u.len() {
            let (near, far) = self.row_sums(i);
            let total = near.plus(far);
            let row = self.chain.row(i);
            let pairs = [
                (row.near, row.near_probabilities),
                (row.far, row.far_probabilities),
            ];
            for (columns, probabilities) in pairs {
                let terms = columns.iter().zip(probabilities);
                weights.extend(terms.map(|(&j, p)| p * self.u[j as usize].over(total)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{any_graph, chain, graph, grid, path};
    use faer::Mat;
    use faer::prelude::Solve;
    use proptest::prelude::*;

    const TOL: f64 = 1e-10;

    fn solve(chain: &Chain, q: &[f64], terminal: &[f64]) -> (Vec<f64>, SolveReport) {
        let mut diffusion = Diffusion::new(chain);
        let mut v = diffusion.cold_start(terminal);
        let report = diffusion.solve(q, &mut v, TOL);
        (v, report)
    }

    /// −ln of the solution of (I − e^{−q} P) u = e^{−q} P u_goals by dense LU.
    fn dense(chain: &Chain, q: &[f64], terminal: &[f64]) -> Vec<f64> {
        let m = chain.len();
        let mut matrix = Mat::<f64>::identity(m, m);
        let mut right = Mat::<f64>::zeros(m, 1);
        for (g, t) in terminal.iter().enumerate() {
            right[(g, 0)] = (-t).exp();
        }
        for i in chain.num_goals()..m {
            let row = chain.row(i);
            let near = row.near.iter().zip(row.near_probabilities);
            for (&j, p) in near.chain(row.far.iter().zip(row.far_probabilities)) {
                matrix[(i, j as usize)] -= (-q[i]).exp() * p;
            }
        }
        let u = matrix.partial_piv_lu().solve(&right);
        (0..m).map(|i| -u[(i, 0)].ln()).collect()
    }

    fn assert_close(v: &[f64], expected: &[f64], tol: f64) {
        for (i, (a, b)) in v.iter().zip(expected).enumerate() {
            assert!((a - b).abs() <= tol, "position {i}: {a} against {b}");
        }
    }

    /// On the half-line u_i = r^i with r = ρ/2 (1 + r²): a rise of −ln r per hop, however far.
    #[test]
    fn a_long_path_rises_as_the_closed_form_says() {
        let chain = chain(&path(20_000), &[0]);
        let rho = (-0.7_f64).exp();
        let r = (1.0 - (1.0 - rho * rho).sqrt()) / rho;
        let (v, report) = solve(&chain, &vec![0.7; chain.len()], &[0.0]);
        assert!(report.converged && report.sweeps <= 24, "{report:?}");
        for hops in [1, 10, 700, 15_000] {
            let expected = -r.ln() * hops as f64;
            assert!(
                (v[hops] / expected - 1.0).abs() < 1e-9,
                "{} against {expected}",
                v[hops]
            );
        }
    }

    #[test]
    fn grids_agree_with_a_dense_solve() {
        for (cells, goals) in [
            (grid(8, 7, &[9, 16, 23]), vec![0]),
            (grid(6, 6, &[]), vec![14, 35]),
        ] {
            let chain = chain(&cells, &goals);
            let q: Vec<f64> = (0..chain.len())
                .map(|i| 0.1 + 0.3 * (i % 5) as f64)
                .collect();
            let terminal: Vec<f64> = (0..goals.len()).map(|g| 2.5 * g as f64).collect();
            let (v, report) = solve(&chain, &q, &terminal);
            assert!(report.converged);
            assert_close(&v, &dense(&chain, &q, &terminal), 1e-9);
        }
    }

    /// Where nearly all neighbours are far, carrying everything along would overshoot without end.
    #[test]
    fn complete_and_bipartite_graphs_converge_at_low_cost() {
        let all_pairs = |n: usize, keep: fn(usize, usize) -> bool| -> Vec<(usize, usize)> {
            let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (j, i)));
            pairs.filter(|&(j, i)| keep(j, i)).collect()
        };
        let complete = graph(40, &all_pairs(40, |_, _| true));
        // 0 – {1, 2, 3} – {4 … 39}
        let layers = graph(
            40,
            &all_pairs(40, |j, i| {
                (j == 0 && i < 4) || (1..4).contains(&j) && i >= 4
            }),
        );
        let star = graph(40, &all_pairs(40, |j, i| j == 0 && i == 1 || j == 1));
        for adjacency in [complete, layers, star] {
            let chain = chain(&adjacency, &[0]);
            for cost in [1e-3, 0.1, 3.0] {
                let q = vec![cost; chain.len()];
                let (v, report) = solve(&chain, &q, &[0.0]);
                assert!(report.converged, "cost {cost}: {report:?}");
                assert_close(&v, &dense(&chain, &q, &[0.0]), 1e-6);
            }
        }
    }

    #[test]
    fn a_warm_start_ends_at_the_same_place_sooner() {
        let chain = chain(&grid(40, 40, &[]), &[0]);
        let q = vec![0.7; chain.len()];
        let (mut v, cold) = solve(&chain, &q, &[0.0]);
        let nearby: Vec<f64> = q
            .iter()
            .enumerate()
            .map(|(i, q)| q + 1e-4 * (i % 3) as f64)
            .collect();
        let warm = Diffusion::new(&chain).solve(&nearby, &mut v, TOL);
        let (fresh, _) = solve(&chain, &nearby, &[0.0]);
        assert!(
            warm.converged && warm.sweeps < cold.sweeps,
            "{warm:?} after {cold:?}"
        );
        assert_close(&v, &fresh, 1e-7);
    }

    #[test]
    fn rows_of_the_controlled_walk_sum_to_one() {
        let chain = chain(&grid(9, 9, &[]), &[40]);
        let mut diffusion = Diffusion::new(&chain);
        let mut v = diffusion.cold_start(&[0.0]);
        diffusion.solve(&vec![0.7; chain.len()], &mut v, TOL);
        let mut weights = Vec::new();
        diffusion.controlled_walk(&mut weights);
        for i in chain.num_goals()..chain.len() {
            let row = chain.near_range(i).start..chain.far_range(i).end;
            let total: f64 = weights[row].iter().sum();
            assert!((total - 1.0).abs() < 1e-14);
        }
    }

    proptest! {
        #[test]
        fn any_graph_and_cost_agrees_with_a_dense_solve(
            adjacency in any_graph(),
            costs in prop::collection::vec(0.02_f64..4.0, 24),
        ) {
            let chain = chain(&adjacency, &[0]);
            let q = &costs[..chain.len()];
            let (v, report) = solve(&chain, q, &[0.0]);
            prop_assert!(report.converged, "{:?}", report);
            for (a, b) in v.iter().zip(dense(&chain, q, &[0.0])) {
                prop_assert!((a - b).abs() < 1e-7, "{} against {}", a, b);
            }
        }

        /// The maximum principle, and at any early stop within the residual.
        #[test]
        fn no_cost_makes_a_false_maximum(
            adjacency in any_graph(),
            costs in prop::collection::vec(1e-3_f64..8.0, 24),
        ) {
            let chain = chain(&adjacency, &[0, 1]);
            let (v, _) = solve(&chain, &costs[..chain.len()], &[0.0, 1.0]);
            let phi = chain.scatter(&v.iter().map(|v| -v).collect::<Vec<_>>(), f64::NEG_INFINITY);
            prop_assert_eq!(chain.spurious_maxima(&phi), vec![]);
        }
    }
}
