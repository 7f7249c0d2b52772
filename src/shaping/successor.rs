//! Expected discounted visits of the goal, from the successor representation of Dayan 1993.
//!
//! ```text
//! Ψ = (I − γ P)⁻¹                           Ψ_ig: expected discounted visits of g from i, under the uniform policy
//! u_i = Ψ_ig / Ψ_gg = γ Σ_j P_ij u_j,   u_g = 1
//! φ = u − 1,   or that on the scale of the return
//! ```
//!
//! u_i = E γ^{steps from i to g}: a column of Ψ divided by its entry at the goal, whatever row g of P is. Goals absorb, and one
//! that forgoes D_g typical steps has u_g = γ^{D_g}. Step costs do not count. That is the *value* form, V = Ψ r with the
//! goal alone rewarded: φ falls steeply near the goal and is nearly flat far from it, where u is nearly 0. The logarithm of u would
//! be no other potential than [`heat`](super::heat) with `heat_kept` = γ and unit costs.
//!
//! γ is 0.99. Others shape with distances in eigenvectors of Ψ, which are those of the graph's Laplacian
//! (Y. Wu, G. Tucker, O. Nachum, *The Laplacian in RL*, ICLR 2019; M. C. Machado, M. G. Bellemare, M. Bowling, *Count-based
//! exploration with the successor representation*, AAAI 2020, for exploration).

use super::fit_context::{FitContext, GraphPotential};
use super::linearly_solvable::solve_linearly_solvable;
use super::params::ScaleMode;
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// γ: half of u is left after 69 steps. Not the agent's discount, which is 1 by default.
const DISCOUNT: f64 = 0.99;

/// Bellman residual, in nats, at which u is right to 1e-6 of itself: a hundredth of that, 1 − γ.
const TOL: f64 = 1e-8;

/// The `sr` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SuccessorPotential {
    /// Units of φ: `raw` is u − 1.
    pub scale: ScaleMode,
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
}

impl GraphPotential for SuccessorPotential {
    /// Solves for −ln u, which does not underflow.
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let problem = context.problem;
        let per_step = -libm::log(DISCOUNT);
        let q = vec![per_step; problem.chain.len()];
        let ends: Vec<f64> = problem.forgone().iter().map(|d| d * per_step).collect();
        let (v, statistics) = solve_linearly_solvable(&problem.chain, &q, &ends, TOL);
        let missed: Vec<f64> = v.iter().map(|v| -libm::expm1(-v)).collect();
        let values = match self.scale {
            ScaleMode::Return => problem.potential(&missed, self.scale_factor),
            ScaleMode::Raw => problem.falling(&missed, 1.0),
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
    use crate::graph::StateId;
    use crate::graph::SymmetricCsr;
    use crate::shaping::fixtures::{any_graph, on_problem, path};
    use crate::shaping::shortest_path::ShortestPathProblem;
    use crate::shaping::transition_matrix::TransitionMatrix;
    use faer::Mat;
    use faer::prelude::Solve;
    use proptest::prelude::*;

    fn fit(adjacency: &SymmetricCsr, problem: &ShortestPathProblem, scale: ScaleMode) -> Vec<f64> {
        let mut sr = SuccessorPotential {
            scale,
            scale_factor: 3.0,
        };
        on_problem(adjacency, problem, |context| {
            sr.fit_in(context).unwrap().values
        })
    }

    fn problem(adjacency: &SymmetricCsr, goals: &[u32]) -> ShortestPathProblem {
        let goals: Vec<StateId> = goals.iter().map(|&g| StateId(g)).collect();
        ShortestPathProblem::uniform(&TransitionMatrix::undirected(adjacency), &goals)
    }

    /// u_k = cosh((n − 1 − k) θ) / cosh((n − 1) θ) with cosh θ = 1/γ: a walk between a goal and a wall.
    #[test]
    fn a_path_has_its_closed_form() {
        let n = 120;
        let adjacency = path(n);
        let phi = fit(&adjacency, &problem(&adjacency, &[0]), ScaleMode::Raw);
        let theta = (1.0 / DISCOUNT).acosh();
        let u = |k: usize| ((n - 1 - k) as f64 * theta).cosh() / ((n - 1) as f64 * theta).cosh();
        for (k, phi) in phi.iter().enumerate() {
            assert!((phi + 1.0 - u(k)).abs() < 2e-6, "{k}: {phi}");
        }
        let scaled = fit(&adjacency, &problem(&adjacency, &[0]), ScaleMode::Return);
        assert_eq!((scaled[0], scaled[n - 1]), (0.0, -3.0 * (n - 1) as f64));
    }

    #[test]
    fn a_poorer_goal_counts_as_visited_later() {
        let adjacency = path(9);
        let mut problem = problem(&adjacency, &[0, 8]);
        problem.distances[1] = 30.0;
        let phi = fit(&adjacency, &problem, ScaleMode::Raw);
        assert!((phi[8] + 1.0 - DISCOUNT.powi(30)).abs() < 1e-12, "{phi:?}");
        assert_eq!(phi[0], 0.0);
    }

    proptest! {
        /// The goal's column of Ψ by dense LU, relative to its own entry, whether or not the goal can be left.
        #[test]
        fn any_graph_agrees_with_a_dense_solve(adjacency in any_graph()) {
            let problem = problem(&adjacency, &[0]);
            let phi = fit(&adjacency, &problem, ScaleMode::Raw);
            let (n, transitions) = (adjacency.num_nodes(), TransitionMatrix::undirected(&adjacency));
            for first in [0, 1] {
                let mut matrix = Mat::<f64>::identity(n, n);
                for i in first..n {
                    let (targets, probabilities) = transitions.row(i);
                    for (&j, p) in targets.iter().zip(probabilities) {
                        matrix[(i, j as usize)] -= DISCOUNT * p;
                    }
                }
                let visits = matrix.partial_piv_lu().solve(&Mat::<f64>::identity(n, n));
                for &s in problem.chain.order() {
                    let expected = visits[(s as usize, 0)] / visits[(0, 0)] - 1.0;
                    let found = phi[s as usize];
                    prop_assert!((found - expected).abs() < 2e-6, "{}: {} against {}", s, found, expected);
                }
            }
        }
    }
}
