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
