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
use super::grounded::final_tolerance;
use super::linearly_solvable::LinearlySolvableMdp;
use super::params::ScaleMode;
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// γ: half of u is left after 69 steps. Not the agent's discount, which is 1 by default.
const DISCOUNT: f64 = 0.99;

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
        let mut v: Vec<f64> = problem.forgone().iter().map(|d| d * per_step).collect();
        let tol = final_tolerance(problem.past_goals(&q));
        let statistics = LinearlySolvableMdp::new(&problem.chain).solve_cold(&q, &mut v, tol);
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
