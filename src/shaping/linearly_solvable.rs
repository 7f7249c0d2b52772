//! Linearly solvable decision processes (Todorov 2006) on the visited graph, in the log domain.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,   u_g = e^{−v_g} on goals              linear in u
//! v_i = q_i − ln Σ_j P_ij e^{−v_j}                                    the same for v = −ln u
//! ```
//!
//! q_i > 0 is the cost of a step from i, in nats. u shrinks by a constant factor per hop and underflows after some hundred
//! hops, so v is what is solved for: −v is the soft Bellman value at temperature 1 of a process in which every move is a choice, a priori as likely as the
//! walk takes it. With one goal u is, up to a factor, the goal's column of the default representation (diag(e^q) − P)⁻¹ of Piray & Daw 2021.

use super::absorbing_chain::AbsorbingChain;
use super::decision_process::{Choices, DecisionProcess};
use super::soft_bellman::{SoftBellman, SolveStatistics};

/// v by position of the chain for costs `q` by position and terminal costs of the goals, to a residual of `tol` nats.
///
/// # Panics
/// If `q` has not one entry per position, or `terminal` not one per goal.
pub(super) fn solve_linearly_solvable(
    chain: &AbsorbingChain,
    q: &[f64],
    terminal: &[f64],
    tol: f64,
) -> (Vec<f64>, SolveStatistics) {
    let goals = chain.num_goals();
    assert_eq!(terminal.len(), goals, "one terminal cost per goal");
    assert_eq!(q.len(), chain.len(), "one cost per position");
    // By position of the chain, which takes the place of state numbers.
    let mut choices = Choices::default();
    for (i, cost) in q.iter().enumerate() {
        let probabilities = chain.probabilities_of(i);
        // Below 1 where a move leads out of reach of the goals.
        let within = libm::log(probabilities.iter().sum());
        for (&j, &probability) in chain.columns_of(i).iter().zip(probabilities) {
            match terminal.get(j as usize) {
                Some(end) => choices.push(within - cost - end, probability, true, []),
                None => choices.push(within - cost, probability, false, [(j, 1.0)]),
            }
        }
        choices.end_state();
    }
    let typical = q[goals..].iter().sum::<f64>() / q.len().saturating_sub(goals).max(1) as f64;
    let process = DecisionProcess::new(&choices, typical);
    let tau = vec![1.0; process.len()];
    let (v, statistics) = SoftBellman::new(&process).solve_cold(&tau, tol);
    let mut by_position: Vec<f64> = process.scatter(&v).iter().map(|v| 0.0 - v).collect();
    by_position[..goals].copy_from_slice(terminal);
    (by_position, statistics)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::Action;
    use crate::graph::StateId;
    use crate::graph::TransitionGraph;
    use crate::shaping::fixtures::{any_graph, chain, far_reaching_graphs, grid, path};
    use crate::shaping::spurious_maxima;
    use crate::shaping::transition_matrix::TransitionMatrix;
    use faer::Mat;
    use faer::prelude::Solve;
    use proptest::prelude::*;

    const TOL: f64 = 1e-10;

    fn solve(chain: &AbsorbingChain, q: &[f64], terminal: &[f64]) -> (Vec<f64>, SolveStatistics) {
        solve_linearly_solvable(chain, q, terminal, TOL)
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
        for adjacency in far_reaching_graphs() {
            let chain = chain(&adjacency, &[0]);
            for cost in [1e-3, 0.1, 3.0] {
                let q = vec![cost; chain.len()];
                let (v, statistics) = solve(&chain, &q, &[0.0]);
                assert!(statistics.converged, "cost {cost}: {statistics:?}");
                assert_close(&v, &dense(&chain, &q, &[0.0]), 1e-6);
            }
        }
    }

    /// What leads out of reach of the goals is lost: the chances of the rest do not add up to 1.
    #[test]
    fn moves_out_of_reach_count_as_lost() {
        // 0 ← 1 → 2, of which 2 leads nowhere.
        let mut graph = TransitionGraph::new(2);
        let states = [(); 3].map(|()| graph.add_state());
        for (from, action, to) in [(1, 0, 0), (1, 1, 2), (2, 0, 2), (2, 1, 2)] {
            graph.record(states[from], Action(action), -1.0, states[to], false);
        }
        let transitions = TransitionMatrix::observed(&graph, &graph.adjacency().to_csr());
        let chain = AbsorbingChain::by_hops(&transitions, &[0]);
        let (v, statistics) = solve(&chain, &[0.3, 0.3], &[1.5]);
        assert!(statistics.converged && chain.order() == [0, 1]);
        assert_close(&v, &[1.5, 0.3 + 1.5 + 2_f64.ln()], 1e-12);
    }

    #[test]
    fn nan_is_a_result_that_has_not_converged() {
        let chain = chain(&path(5), &[0]);
        let (v, statistics) = solve(&chain, &[0.7, 0.7, f64::NAN, 0.7, 0.7], &[0.0]);
        assert!(
            !statistics.converged && !statistics.residual.is_finite(),
            "{statistics:?}"
        );
        assert!(v.iter().any(|v| !v.is_finite()), "{v:?}");
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
            prop_assert_eq!(spurious_maxima(&phi, &adjacency, &[StateId(0), StateId(1)]), vec![]);
        }
    }
}
