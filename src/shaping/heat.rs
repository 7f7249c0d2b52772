//! The control without learning: a soft Bellman equation at one fixed temperature.
//!
//! ```text
//! V_i = τ ln mean_c e^{Q(i, c) / τ},   Q(i, c) = r_c + g Σ_j P_cj V_j,   τ = r̄ / (−ln kept),   φ = factor · V
//! ```
//!
//! Where every choice has one outcome and every step costs r̄, u = e^{V/τ} obeys u_i = kept · mean_j u_j: heat that flows from the ends and of which each
//! step keeps a part. τ ln u behaves like a distance (Varadhan), but one that knows of all ways rather than of the shortest
//! alone: between two passages of equal length the wider one looks nearer, and a ledge beside an abyss looks worse than a road.

use super::return_context::{ReturnContext, ReturnPotential};
use super::soft_bellman::SoftBellman;
use super::{PotentialFit, ShapingError};
use serde::{Deserialize, Serialize};

/// The `heat` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatPotential {
    /// The part of the heat that a typical step keeps, between 0 and 1.
    pub kept: f64,
    /// φ ÷ V.
    pub scale_factor: f64,
}

impl ReturnPotential for HeatPotential {
    fn fit_to_returns(
        &mut self,
        context: &ReturnContext<'_>,
    ) -> Result<PotentialFit, ShapingError> {
        fit_at(-1.0 / libm::log(self.kept), self.scale_factor, context)
    }
}

/// φ at a temperature of `tau` typical steps everywhere.
pub(super) fn fit_at(
    tau: f64,
    factor: f64,
    context: &ReturnContext<'_>,
) -> Result<PotentialFit, ShapingError> {
    let model = context.model.settled(tau);
    let mut solver = SoftBellman::new(&model.process);
    let (v, statistics) = solver.solve_cold(&model.temperatures(tau), model.tolerance());
    let phi: Vec<f64> = v.iter().map(|v| factor * v).collect();
    Ok(PotentialFit {
        solve: Some(statistics),
        ..PotentialFit::checked(model.process.scatter(&phi))?
    })
}
