//! The value of the linearly solvable process, from the default representation of Piray & Daw 2021.
//!
//! ```text
//! M = (diag(e^{−r/λ}) − T)⁻¹                   T: moves of the uniform policy among states that are no goals;  r: reward of a step
//! z = M P e^{−D/λ},   V = λ ln z               P: moves into goals;  D_g: what ending at g forgoes
//! φ = V − max_g V_g,   or that on the scale of the return
//! ```
//!
//! V is the optimal value where leaving the uniform policy costs λ nats times its relative entropy. With r_i = −c_i and λ in
//! typical steps, e^{r_i/λ} = e^{−q_i} for q_i = c_i / λ, and row i of (diag(e^q) − T) z = P e^{−D/λ} is
//! z_i = e^{−q_i} (Σ_j T_ij z_j + Σ_g P_ig e^{−D_g/λ}), the equation of [`heat`](super::heat):
//!
//! - with one goal g, z is column g of the default representation of all states divided by its entry at g, whatever row g of
//!   T is: no other equation contains it;
//! - where nothing slips and all steps cost the same, V is `heat`'s but for a constant, at `heat_kept` = e^{−1/λ};
//! - where moves slip, T takes each outcome for a choice of its own, as if chance could be steered, and `heat` does not.
//!
//! λ is `shaping.temperature`. Rewards of steps count by their size, within 0.05 to 20 typical steps; one never taken
//! counts as typical. M is never formed: z underflows some hundred hops from the goal, and −ln z is what is solved for.
//!
//! Others shape with the principal eigenvector of M (H. T. Tse, S. Chandrasekar, M. C. Machado, *Reward-aware
//! proto-representations in reinforcement learning*, arXiv 2505.16217; *DROGO*, arXiv 2602.00403). Which column is wanted is
//! known here, since there is no φ before the first goal.

use super::fit_context::{FitContext, GraphPotential};
use super::linearly_solvable::solve_linearly_solvable;
use super::params::ScaleMode;
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// Bellman residual at which V is final: in nats, and as a share of the smallest cost of a step, which is what V is wrong by, as a share of itself, at most.
const FINAL_TOL: f64 = 1e-5;
const FINAL_SHARE: f64 = 1e-4;

fn final_tolerance(past_goals: &[f64]) -> f64 {
    let cheapest = past_goals.iter().copied().fold(1.0, f64::min);
    FINAL_TOL.min(FINAL_SHARE * cheapest)
}

/// The `dr` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefaultRepresentationPotential {
    /// λ, in typical steps.
    pub temperature: f64,
    /// Units of φ: `raw` is V itself, 0 at the best goal.
    pub scale: ScaleMode,
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
}

impl GraphPotential for DefaultRepresentationPotential {
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let problem = context.problem;
        let nats = |steps: &f64| steps / self.temperature;
        let q: Vec<f64> = problem.costs.iter().map(nats).collect();
        let ends: Vec<f64> = problem.forgone().iter().map(nats).collect();
        let tol = final_tolerance(problem.past_goals(&q));
        let (v, statistics) = solve_linearly_solvable(&problem.chain, &q, &ends, tol);
        let values = match self.scale {
            ScaleMode::Return => problem.potential(&v, self.scale_factor),
            ScaleMode::Raw => problem.falling(&v, problem.step_reward * self.temperature),
        };
        Ok(PotentialFit {
            solve: Some(statistics),
            ..PotentialFit::checked(values)?
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{StateId, SymmetricCsr};
    use crate::shaping::fixtures::{any_graph, grid, on_problem, path};
    use crate::shaping::heat::HeatPotential;
    use crate::shaping::learnt_model::LearntModel;
    use crate::shaping::return_context::{ReturnContext, ReturnPotential};
    use crate::shaping::shortest_path::ShortestPathProblem;
    use crate::shaping::transition_matrix::TransitionMatrix;
    use faer::Mat;
    use faer::prelude::Solve;
    use proptest::prelude::*;

    const FACTOR: f64 = 3.0;

    fn dr(temperature: f64, scale: ScaleMode) -> DefaultRepresentationPotential {
        DefaultRepresentationPotential {
            temperature,
            scale,
            scale_factor: FACTOR,
        }
    }

    /// Goals that forgo these typical steps, steps that cost these typical steps, each of which costs half a unit.
    fn problem(
        transitions: &TransitionMatrix,
        forgone: &[(u32, f64)],
        costs: &[f64],
    ) -> ShortestPathProblem {
        let goals: Vec<StateId> = forgone.iter().map(|&(g, _)| StateId(g)).collect();
        let mut problem = ShortestPathProblem::uniform(transitions, &goals);
        problem.step_reward = 0.5;
        problem.costs = problem.chain.gather(costs);
        for (distance, &(_, forgone)) in problem.distances.iter_mut().zip(forgone) {
            *distance = forgone;
        }
        problem
    }

    fn fit(
        potential: &mut impl GraphPotential,
        adjacency: &SymmetricCsr,
        problem: &ShortestPathProblem,
    ) -> Vec<f64> {
        on_problem(adjacency, problem, |context| {
            potential.fit_in(context).unwrap().values
        })
    }

    /// M by dense LU, over all states; the rows of `without` are those of states that nothing leaves.
    fn representation(transitions: &TransitionMatrix, q: &[f64], without: &[u32]) -> Mat<f64> {
        let n = transitions.num_states();
        let mut matrix = Mat::from_fn(n, n, |i, j| if i == j { q[i].exp() } else { 0.0 });
        for i in (0..n).filter(|i| !without.contains(&(*i as u32))) {
            let (targets, probabilities) = transitions.row(i);
            for (&j, p) in targets.iter().zip(probabilities) {
                matrix[(i, j as usize)] -= p;
            }
        }
        matrix.partial_piv_lu().solve(&Mat::<f64>::identity(n, n))
    }

    fn assert_close(found: &[f64], expected: impl Fn(usize) -> f64, reached: &[u32]) {
        for &s in reached {
            let (found, expected) = (found[s as usize], expected(s as usize));
            let tol = 1e-4 * (1.0 + expected.abs());
            assert!(
                (found - expected).abs() < tol,
                "state {s}: {found} against {expected}"
            );
        }
    }

    #[test]
    fn steps_of_a_goal_count_at_face_value() {
        let transitions = TransitionMatrix::undirected(&path(30));
        let problem = problem(&transitions, &[(0, 0.0), (29, 12.0)], &[1.0; 30]);
        let phi = fit(&mut dr(0.7, ScaleMode::Raw), &path(30), &problem);
        assert!(phi[0] == 0.0 && (phi[29] + 6.0).abs() < 1e-12, "{phi:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// V is λ times the log of the goal's column of M, relative to the goal's own entry, whether or not the goal can be left.
        #[test]
        fn one_goal_is_a_column(
            adjacency in any_graph(),
            costs in prop::collection::vec(0.05_f64..4.0, 24),
            temperature in 0.5_f64..20.0,
        ) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let problem = problem(&transitions, &[(0, 0.0)], &costs);
            let raw = fit(&mut dr(temperature, ScaleMode::Raw), &adjacency, &problem);
            let q: Vec<f64> = costs.iter().map(|c| c / temperature).collect();
            let reached = problem.chain.order();
            for without in [&[][..], &[0]] {
                let m = representation(&transitions, &q, without);
                let value = |s: usize| 0.5 * temperature * (m[(s, 0)] / m[(0, 0)]).ln();
                assert_close(&raw, value, reached);
            }
            let lowest = |phi: &[f64]| phi.iter().copied().fold(0.0, f64::min);
            let scaled = fit(&mut dr(temperature, ScaleMode::Return), &adjacency, &problem);
            let factor = if reached.len() > 1 { lowest(&scaled) / lowest(&raw) } else { 1.0 };
            assert_close(&scaled, |s| factor * raw[s], reached);
            let stretched = -FACTOR * 0.5 * problem.eccentricity();
            prop_assert!((lowest(&scaled) - stretched).abs() < 1e-9 || reached.len() == 1);
        }

        /// With unit costs `heat` is the same but for its discount g: 0 ≤ V_g − V_1 ≤ (1 − g) max V_1², in typical steps. For V_1 leaves
        /// a residual of (1 − g) |V_1| at most in the equation of V_g, and no walk that is worth V takes more than |V| steps.
        #[test]
        fn heat_is_the_same_but_for_its_discount(adjacency in any_graph(), temperature in 0.2_f64..10.0) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let problem = ShortestPathProblem::uniform(&transitions, &[StateId(0)]);
            let raw = fit(&mut dr(temperature, ScaleMode::Raw), &adjacency, &problem);
            let kept = (-1.0 / temperature).exp();
            let model = LearntModel::uniform(&adjacency, &[StateId(0)]);
            let heat = HeatPotential { kept, scale_factor: 1.0 }.fit_to_returns(&ReturnContext {
                model: &model,
                adjacency: &adjacency,
                features: Mat::zeros(0, 0).as_ref(),
                returns: &[],
            });
            let heat = heat.unwrap().values;
            let reached = problem.chain.order();
            let lowest = reached.iter().map(|&s| raw[s as usize]).fold(0.0, f64::min);
            let most = lowest * lowest / (10.0 * adjacency.num_nodes() as f64);
            for &s in reached {
                let gain = heat[s as usize] - raw[s as usize];
                prop_assert!(-1e-3 < gain && gain < most + 1e-3, "state {}: {}, at most {}", s, gain, most);
            }
        }

        /// z = M P e^{−D/λ} with M of the states that are no goals; and Bellman's equation of the value.
        #[test]
        fn several_goals_are_the_product(
            adjacency in any_graph().prop_filter("two goals and a state", |a| a.num_nodes() > 2),
            costs in prop::collection::vec(0.05_f64..4.0, 24),
            temperature in 0.5_f64..20.0,
            forgone in 0.0_f64..9.0,
        ) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let problem = problem(&transitions, &[(0, 0.0), (1, forgone)], &costs);
            let raw = fit(&mut dr(temperature, ScaleMode::Raw), &adjacency, &problem);
            let q: Vec<f64> = costs.iter().map(|c| c / temperature).collect();
            let n = adjacency.num_nodes();
            let m = representation(&transitions, &q, &[0, 1]);
            let lambda = 0.5 * temperature;
            let ends = [0.0, forgone].map(|d| (-d / temperature).exp());
            let arriving = |i: usize| -> f64 {
                let (targets, probabilities) = transitions.row(i);
                let into = targets.iter().zip(probabilities).filter(|(j, _)| **j < 2);
                into.map(|(&j, p)| p * ends[j as usize]).sum()
            };
            let value = |s: usize| match s {
                0 | 1 => lambda * ends[s].ln(),
                // Columns of goals in M stand for arriving at them; the others are those of T alone.
                _ => lambda * (2..n).map(|j| m[(s, j)] * arriving(j)).sum::<f64>().ln(),
            };
            let reached = problem.chain.order();
            assert_close(&raw, value, reached);
            let bellman = |s: usize| {
                let (targets, probabilities) = transitions.row(s);
                let next = targets.iter().zip(probabilities);
                let sum: f64 = next.map(|(&j, p)| p * (raw[j as usize] / lambda).exp()).sum();
                -0.5 * costs[s] + lambda * sum.ln()
            };
            assert_close(&raw, bellman, &reached[2..]);
        }
    }

    #[test]
    fn values_go_on_falling_where_z_underflows() {
        let adjacency = grid(1, 3000, &[]);
        let transitions = TransitionMatrix::undirected(&adjacency);
        let problem = problem(&transitions, &[(0, 0.0)], &[1.0; 3000]);
        let phi = fit(&mut dr(1.4, ScaleMode::Raw), &adjacency, &problem);
        // On a line z = x^hops with x + 1/x = 2 e^q.
        let e = (1.0 / 1.4_f64).exp();
        let slope = (e + (e * e - 1.0).sqrt()).ln() * 0.5 * 1.4;
        for hops in [1, 700, 2900] {
            assert!(
                (phi[hops] / (slope * hops as f64) + 1.0).abs() < 1e-4,
                "{hops}: {}",
                phi[hops]
            );
        }
    }
}
