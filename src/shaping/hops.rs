//! The value of the optimal policy of the learnt model: what a planner knows, and the limit of the others as τ falls to 0.
//!
//! ```text
//! V_i = max_c r_c + g Σ_j P_cj V_j,   φ = factor · V
//! ```
//!
//! Where each step costs 1 and has one outcome, −V is the number of hops to the goal, all but for the discount that keeps loops in bounds.

use super::heat::fit_at;
use super::return_context::{ReturnContext, ReturnPotential};
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// The `hops` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HopsPotential {
    /// φ ÷ V.
    pub scale_factor: f64,
}

impl ReturnPotential for HopsPotential {
    fn fit_to_returns(
        &mut self,
        context: &ReturnContext<'_>,
    ) -> Result<PotentialFit, ShapingError> {
        fit_at(0.0, self.scale_factor, context)
    }
}
