//! A linearly solvable Markov decision process (Todorov 2006) on the visited graph, solved in the log domain.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,   u_g = e^{−v_g} on goals              linear in u
//! v_i = q_i + softmin_i(v),   softmin_i = −ln Σ_j P_ij e^{−v_j}       the same for v = −ln u
//! ```
//!
//! q_i > 0 is the cost of a step from i. u shrinks by a constant factor per hop and underflows after some hundred
//! hops, so v is what is stored: a Bellman equation with a soft minimum. With one goal u is, up to a factor, the goal's
//! column of the default representation (diag(e^q) − P)⁻¹ of Piray & Daw 2021.
//!
//! **Maximum principle**: Σ_j P_ij e^{−v_j} is an average, hence v_i ≥ q_i + min_j v_j for *every* q, and φ = −v has a
//! larger neighbour wherever there is no goal. A v with Bellman residual below min q keeps this property.
//!
//! # How it is solved
//! By Newton's method, which here is policy iteration: with r = q + softmin(v) − v and the [controlled walk] W of v,
//!
//! ```text
//! (I − W) δ = r,   v ← v + δ.
//! ```
//!
//! softmin is concave, so with exact steps v falls monotonically to the solution from the second iterate on, wherever
//! it began. Rows of W sum to 1, so nothing under- or overflows, however far the goal. A cold start lets v rise as on a
//! half-line, in one pass. Each linear system is solved to one or two digits by sweeps whose number hardly grows with
//! the length of the way; Gauss–Seidel on the Bellman equation itself needs a sweep per 14 hops at q = 0.7, and per 2
//! hops at q = 0.1.
//!
//! [controlled walk]: super::controlled_walk

use super::absorbing_chain::AbsorbingChain;
use super::controlled_walk::ControlledWalk;
use serde::{Deserialize, Serialize};

/// Relative change of δ at which a Newton step is good enough, and the sweeps it may take for that.
const STEP_TOL: f64 = 0.03;
const SWEEPS_PER_STEP: usize = 40;
/// Nats below the goals from which no further step leads back.
const FAR_BELOW: f64 = 1e6;

/// Cost and accuracy of a solve. Not converging is a result, not an error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SolveStatistics {
    /// Newton steps.
    pub steps: usize,
    /// Sweeps over all states, in all steps together.
    pub sweeps: usize,
    /// max_i |q_i + softmin_i(v) − v_i|, in nats.
    pub residual: f64,
    /// Whether the residual reached the tolerance.
    pub converged: bool,
}

/// A linearly solvable process with its solver: the walk that belongs to the present v, and buffers, all by position.
#[derive(Clone, Debug)]
pub struct LinearlySolvableMdp<'c> {
    walk: ControlledWalk<'c>,
    softmin: Vec<f64>,
    residual: Vec<f64>,
    step: Vec<f64>,
}

impl<'c> LinearlySolvableMdp<'c> {
    /// The process on `chain`.
    pub fn new(chain: &'c AbsorbingChain) -> Self {
        let zeros = vec![0.0; chain.len()];
        Self {
            walk: ControlledWalk::new(chain),
            softmin: zeros.clone(),
            residual: zeros.clone(),
            step: zeros,
        }
    }

    /// The walk at the v of the last call, for gradients.
    pub fn walk_mut(&mut self) -> &mut ControlledWalk<'c> {
        &mut self.walk
    }

    /// Solves from nothing: `v` holds the terminal costs of the goals and is extended to all positions. See
    /// [`solve`](Self::solve).
    ///
    /// # Panics
    /// If `q` has not one entry per position, or `v` not one per goal.
    pub fn solve_cold(&mut self, q: &[f64], v: &mut Vec<f64>, tol: f64) -> SolveStatistics {
        let chain = self.walk.chain();
        assert_eq!(v.len(), chain.num_goals(), "one terminal cost per goal");
        assert_eq!(q.len(), chain.len(), "one cost per position");
        for (i, cost) in q.iter().enumerate().skip(chain.num_goals()) {
            v.push(chain.lowest_near(i, v) + half_line_slope(*cost));
        }
        self.solve(q, v, tol)
    }

    /// Solves from a guess, as left by an earlier solve on a smaller graph: `v` holds the terminal costs of the goals and
    /// is extended to all positions. `guess` is by position, ∞ where there is none; goals' entries are not looked at.
    ///
    /// No solution exceeds v_i ≤ q_i + v_j − ln P_ij for any j, so a guess above that, for the j with the lowest v, is cut
    /// down to it: that is how a short cut found since is taken up, and how new states get a value at all. See
    /// [`solve`](Self::solve). From a guess too low in the wrong places, Newton steps that are not exact may stray; then
    /// the guess is dropped and the solve begun anew, from nothing.
    ///
    /// # Panics
    /// If `q` or `guess` has not one entry per position, or `v` not one per goal.
    pub fn solve_near(
        &mut self,
        guess: &[f64],
        q: &[f64],
        v: &mut Vec<f64>,
        tol: f64,
    ) -> SolveStatistics {
        let chain = self.walk.chain();
        assert_eq!(v.len(), chain.num_goals(), "one terminal cost per goal");
        assert_eq!(
            (q.len(), guess.len()),
            (chain.len(), chain.len()),
            "one entry per position"
        );
        for i in chain.num_goals()..chain.len() {
            v.push(guess[i].min(q[i] + chain.lowest_way(i, v)));
        }
        let near = self.solve(q, v, tol);
        if near.converged {
            return near;
        }
        v.truncate(self.walk.chain().num_goals());
        let cold = self.solve_cold(q, v, tol);
        SolveStatistics {
            steps: near.steps + cold.steps,
            sweeps: near.sweeps + cold.sweeps,
            ..cold
        }
    }

    /// Newton steps from `v` until the Bellman residual is ≤ `tol`. `q` and `v` are by position; the goals' entries of v
    /// are kept. What lies below all goals is no solution, by the maximum principle, and may have a residual of 0 where it
    /// is too large for the costs to count. Gives up after [`max_sweeps`](Self::max_sweeps), or when v has strayed far
    /// below the goals or is no longer finite. A cold solve takes 3 to 7
    /// steps and 20 to 50 sweeps at q = 0.7, O(nnz) each; grids of 10⁵ states and more take some hundred at q = 0.1.
    ///
    /// # Panics
    /// If `q` or `v` has not one entry per position.
    pub fn solve(&mut self, q: &[f64], v: &mut [f64], tol: f64) -> SolveStatistics {
        let mut statistics = SolveStatistics::default();
        loop {
            self.walk.update(v, &mut self.softmin);
            statistics.residual = self.set_residual(q, v);
            let drop = self.drop_below_goals(v);
            statistics.converged = statistics.residual <= tol && drop <= 0.0;
            let has_strayed = drop > FAR_BELOW || !statistics.residual.is_finite();
            let hopeless = has_strayed || statistics.sweeps >= self.max_sweeps();
            if statistics.converged || hopeless {
                return statistics;
            }
            statistics.sweeps += self.newton_step(v, SWEEPS_PER_STEP);
            statistics.steps += 1;
        }
    }

    /// When [`solve`](Self::solve) gives up: far beyond what any graph needed at costs from 1e-3 on.
    pub fn max_sweeps(&self) -> usize {
        2000 + self.softmin.len() / 32
    }

    /// One Newton step of `sweeps` sweeps for costs `q` that have changed since the last call, from the v it left.
    ///
    /// # Panics
    /// If `q` or `v` has not one entry per position.
    pub fn follow(&mut self, q: &[f64], v: &mut [f64], sweeps: usize) {
        self.set_residual(q, v);
        self.newton_step(v, sweeps);
        self.walk.update(v, &mut self.softmin);
    }

    /// How far the lowest v lies below that of every goal; 0 or less at a solution.
    fn drop_below_goals(&self, v: &[f64]) -> f64 {
        let (goals, others) = v.split_at(self.walk.chain().num_goals());
        let lowest = |v: &[f64]| v.iter().copied().fold(f64::INFINITY, f64::min);
        if others.is_empty() {
            return 0.0;
        }
        lowest(goals) - lowest(others)
    }

    /// r by position, 0 on goals; returns max |r|, or NaN if there is one.
    fn set_residual(&mut self, q: &[f64], v: &[f64]) -> f64 {
        let n = self.residual.len();
        assert_eq!((q.len(), v.len()), (n, n), "one entry per position");
        let mut largest = 0.0;
        for i in self.walk.chain().num_goals()..n {
            let residual = q[i] + self.softmin[i] - v[i];
            self.residual[i] = residual;
            // Unlike f64::max this keeps a NaN.
            if residual.is_nan() || residual.abs() > largest {
                largest = residual.abs();
            }
        }
        largest
    }

    fn newton_step(&mut self, v: &mut [f64], max_sweeps: usize) -> usize {
        self.step.fill(0.0);
        let sweeps = self
            .walk
            .solve(&self.residual, &mut self.step, STEP_TOL, max_sweeps);
        v.iter_mut()
            .zip(&self.step)
            .for_each(|(v, step)| *v += step);
        sweeps
    }
}

/// How much v rises per hop on a half-line of constant cost: −ln x with x = e^{−q} (1 + x²) / 2, that is arcosh e^q.
fn half_line_slope(q: f64) -> f64 {
    // acosh(e^q), from e^q − 1 so that small costs keep their digits.
    let excess = libm::expm1(q);
    libm::log1p(excess + (excess * (excess + 2.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shaping::fixtures::{any_graph, chain, graph, grid, path};
    use faer::Mat;
    use faer::prelude::Solve;
    use proptest::prelude::*;

    const TOL: f64 = 1e-10;

    fn solve(chain: &AbsorbingChain, q: &[f64], terminal: &[f64]) -> (Vec<f64>, SolveStatistics) {
        let mut v = terminal.to_vec();
        let statistics = LinearlySolvableMdp::new(chain).solve_cold(q, &mut v, TOL);
        (v, statistics)
    }

    /// −ln of the solution of (I − e^{−q} P) u = e^{−q} P u_goals by dense LU.
    fn dense(chain: &AbsorbingChain, q: &[f64], terminal: &[f64]) -> Vec<f64> {
        let m = chain.len();
        let mut matrix = Mat::<f64>::identity(m, m);
        let mut right = Mat::<f64>::zeros(m, 1);
        for (g, t) in terminal.iter().enumerate() {
            right[(g, 0)] = (-t).exp();
        }
        for i in chain.num_goals()..m {
            for (&j, p) in chain.columns_of(i).iter().zip(chain.probabilities_of(i)) {
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
        let (v, statistics) = solve(&chain, &vec![0.7; chain.len()], &[0.0]);
        assert!(
            statistics.converged && statistics.sweeps <= 24,
            "{statistics:?}"
        );
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
            let (v, statistics) = solve(&chain, &q, &terminal);
            assert!(statistics.converged);
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
                let (v, statistics) = solve(&chain, &q, &[0.0]);
                assert!(statistics.converged, "cost {cost}: {statistics:?}");
                assert_close(&v, &dense(&chain, &q, &[0.0]), 1e-6);
            }
        }
    }

    /// A guess is a matter of time, never of the result.
    #[test]
    fn any_guess_ends_at_the_same_place() {
        let chain = chain(&grid(30, 30, &[]), &[0]);
        let q = vec![0.2; chain.len()];
        let (exact, _) = solve(&chain, &q, &[0.0]);
        let misleading: [&dyn Fn(usize) -> f64; 5] = [
            &|_| 0.0,
            &|i| -1e9 * (i % 2) as f64,
            &|i| 1e3 - i as f64,
            &|i| {
                if i % 7 == 0 {
                    f64::INFINITY
                } else {
                    (i as f64 * 0.9).sin() * 50.0
                }
            },
            &|i| if i % 3 == 0 { f64::MAX } else { -1e300 },
        ];
        for guess in misleading {
            let guess: Vec<f64> = (0..chain.len()).map(guess).collect();
            let mut v = vec![0.0];
            let statistics = LinearlySolvableMdp::new(&chain).solve_near(&guess, &q, &mut v, TOL);
            assert!(statistics.converged, "{statistics:?}");
            assert_close(&v, &exact, 1e-6);
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
        let warm = LinearlySolvableMdp::new(&chain).solve(&nearby, &mut v, TOL);
        let (fresh, _) = solve(&chain, &nearby, &[0.0]);
        assert!(
            warm.converged && warm.sweeps < cold.sweeps,
            "{warm:?} after {cold:?}"
        );
        assert_close(&v, &fresh, 1e-7);
    }

    /// With exact steps v only falls from the second iterate on, whatever the start.
    #[test]
    fn newton_is_monotone() {
        let chain = chain(&grid(12, 12, &[]), &[0]);
        let q = vec![0.3; chain.len()];
        let mut v: Vec<f64> = (0..chain.len()).map(|i| (i as f64).sin()).collect();
        v[0] = 0.0;
        let mut mdp = LinearlySolvableMdp::new(&chain);
        let mut exact_step = |v: &mut Vec<f64>| {
            mdp.walk.update(v, &mut mdp.softmin);
            let residual = mdp.set_residual(&q, v);
            mdp.walk.solve(&mdp.residual, &mut mdp.step, 1e-14, 1000);
            v.iter_mut().zip(&mdp.step).for_each(|(v, step)| *v += step);
            residual
        };
        exact_step(&mut v);
        for _ in 0..12 {
            let before = v.clone();
            exact_step(&mut v);
            let rounding = 1e-10 * before.iter().fold(1.0_f64, |m, v| m.max(v.abs()));
            assert!(
                v.iter()
                    .zip(&before)
                    .all(|(new, old)| *new <= old + rounding)
            );
        }
        assert!(exact_step(&mut v) < TOL);
    }

    #[test]
    fn nan_is_a_result_that_has_not_converged() {
        let chain = chain(&path(5), &[0]);
        let (v, statistics) = solve(&chain, &[0.7, 0.7, f64::NAN, 0.7, 0.7], &[0.0]);
        assert!(
            !statistics.converged && statistics.residual.is_nan(),
            "{statistics:?}"
        );
        assert!(!v[4].is_finite());
    }

    proptest! {
        #[test]
        fn any_graph_and_cost_agrees_with_a_dense_solve(
            adjacency in any_graph(),
            costs in prop::collection::vec(0.02_f64..4.0, 24),
        ) {
            let chain = chain(&adjacency, &[0]);
            let q = &costs[..chain.len()];
            let (v, statistics) = solve(&chain, q, &[0.0]);
            prop_assert!(statistics.converged, "{:?}", statistics);
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
