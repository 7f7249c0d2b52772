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
//! - with goals of equal worth, V is `heat`'s φ but for a positive factor, at `heat_kept` = e^{−1/λ}. Scaled to the return the
//!   two are the same;
//! - where goals differ, `heat` makes a goal that forgoes D steps count as much as a way that is D steps longer, and V takes D at
//!   its face value, although a step costs more than its reward: there is the price of steering.
//!
//! λ is 1 / `shaping.temperature`. Rewards of steps count by their size, within 0.05 to 20 typical steps; one never taken
//! counts as typical. M is never formed: z underflows some hundred hops from the goal, and −ln z is what is solved for.
//!
//! Others shape with the principal eigenvector of M (H. T. Tse, S. Chandrasekar, M. C. Machado, *Reward-aware
//! proto-representations in reinforcement learning*, arXiv 2505.16217; *DROGO*, arXiv 2602.00403). Which column is wanted is
//! known here, since there is no φ before the first goal.

use super::fit_context::{FitContext, GraphPotential};
use super::grounded::final_tolerance;
use super::linearly_solvable::LinearlySolvableMdp;
use super::params::ScaleMode;
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// The `dr` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefaultRepresentationPotential {
    /// 1/λ: nats for each typical step.
    pub temperature: f64,
    /// Units of φ: `raw` is V itself, 0 at the best goal.
    pub scale: ScaleMode,
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
}

impl GraphPotential for DefaultRepresentationPotential {
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let problem = context.problem;
        let nats = |steps: &f64| steps * self.temperature;
        let q: Vec<f64> = problem.costs.iter().map(nats).collect();
        let mut v: Vec<f64> = problem.forgone().iter().map(nats).collect();
        let tol = final_tolerance(problem.past_goals(&q));
        let statistics = LinearlySolvableMdp::new(&problem.chain).solve_cold(&q, &mut v, tol);
        let values = match self.scale {
            ScaleMode::Return => problem.potential(&v, self.scale_factor),
            ScaleMode::Raw => problem.falling(&v, problem.step_reward / self.temperature),
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
        let mut heat = HeatPotential {
            kept: 0.5,
            scale_factor: FACTOR,
        };
        let scaled = fit(&mut dr(2_f64.ln(), ScaleMode::Return), &path(30), &problem);
        let heat = fit(&mut heat, &path(30), &problem);
        assert!(
            scaled[29] > 0.9 * heat[29],
            "{} against {}",
            scaled[29],
            heat[29]
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// V is λ times the log of the goal's column of M, relative to the goal's own entry, whether or not the goal can be left;
        /// and so is heat, but for its scale.
        #[test]
        fn one_goal_is_a_column(
            adjacency in any_graph(),
            costs in prop::collection::vec(0.05_f64..4.0, 24),
            temperature in 0.05_f64..2.0,
        ) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let problem = problem(&transitions, &[(0, 0.0)], &costs);
            let raw = fit(&mut dr(temperature, ScaleMode::Raw), &adjacency, &problem);
            let q: Vec<f64> = costs.iter().map(|c| c * temperature).collect();
            let reached = problem.chain.order();
            for without in [&[][..], &[0]] {
                let m = representation(&transitions, &q, without);
                let value = |s: usize| 0.5 / temperature * (m[(s, 0)] / m[(0, 0)]).ln();
                assert_close(&raw, value, reached);
            }
            let mut heat = HeatPotential { kept: (-temperature).exp(), scale_factor: FACTOR };
            let heat = fit(&mut heat, &adjacency, &problem);
            let lowest = |phi: &[f64]| phi.iter().copied().fold(0.0, f64::min);
            let factor = if reached.len() > 1 { lowest(&heat) / lowest(&raw) } else { 1.0 };
            assert_close(&heat, |s| factor * raw[s], reached);
            let scaled = fit(&mut dr(temperature, ScaleMode::Return), &adjacency, &problem);
            assert_close(&scaled, |s| heat[s], reached);
        }

        /// z = M P e^{−D/λ} with M of the states that are no goals; and Bellman's equation of the value.
        #[test]
        fn several_goals_are_the_product(
            adjacency in any_graph().prop_filter("two goals and a state", |a| a.num_nodes() > 2),
            costs in prop::collection::vec(0.05_f64..4.0, 24),
            temperature in 0.05_f64..2.0,
            forgone in 0.0_f64..9.0,
        ) {
            let transitions = TransitionMatrix::undirected(&adjacency);
            let problem = problem(&transitions, &[(0, 0.0), (1, forgone)], &costs);
            let raw = fit(&mut dr(temperature, ScaleMode::Raw), &adjacency, &problem);
            let q: Vec<f64> = costs.iter().map(|c| c * temperature).collect();
            let n = adjacency.num_nodes();
            let m = representation(&transitions, &q, &[0, 1]);
            let lambda = 0.5 / temperature;
            let ends = [0.0, forgone].map(|d| (-d * temperature).exp());
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
        let phi = fit(&mut dr(0.7, ScaleMode::Raw), &adjacency, &problem);
        // On a line z = x^hops with x + 1/x = 2 e^q.
        let e = 0.7_f64.exp();
        let slope = (e + (e * e - 1.0).sqrt()).ln() * 0.5 / 0.7;
        for hops in [1, 700, 2900] {
            assert!(
                (phi[hops] / (slope * hops as f64) + 1.0).abs() < 1e-4,
                "{hops}: {}",
                phi[hops]
            );
        }
    }
}
