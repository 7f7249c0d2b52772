//! The control without learning: heat that flows from the goals and is lost at a fixed rate.
//!
//! ```text
//! u_i = e^{−q_i} Σ_j P_ij u_j,  u_g = 1 on the best goals,     q_i = c_i · (−ln kept),     φ ∝ ln u
//! ```
//!
//! With `kept` = 0.9 and unit costs this is u = 0.9 P u away from the goals, a random walk with restart seen from the
//! other end. −ln u behaves like a distance (Varadhan), but one that knows of all ways rather than of the shortest
//! alone: between two passages of equal length the wider one looks nearer.

use super::fit_context::{FitContext, GraphPotential};
use super::grounded::GroundedSolution;
use super::linearly_solvable::LinearlySolvableMdp;
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// The `heat` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatPotential {
    /// The part of the heat that a typical step keeps, between 0 and 1.
    pub kept: f64,
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
}

impl GraphPotential for HeatPotential {
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let per_step = -libm::log(self.kept);
        let q: Vec<f64> = context.problem.costs.iter().map(|c| c * per_step).collect();
        let mut mdp = LinearlySolvableMdp::new(&context.problem.chain);
        let solution = GroundedSolution::new(context.problem, &mut mdp, &q, None);
        let fit = PotentialFit::checked(context.problem.potential(&solution.v, self.scale_factor))?;
        Ok(PotentialFit {
            solve: Some(solution.statistics),
            ..fit
        })
    }
}
