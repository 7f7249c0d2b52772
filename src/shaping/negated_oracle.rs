//! φ_i = −φ*_i with the [oracle](super::oracle)'s φ*: a hostile potential, which grows with the true distance to the goal.
//!
//! Shaping keeps the optimal policy whatever φ says (Ng, Harada & Russell 1999), so an agent led away from the goal must find
//! there in the end; this potential, on the oracle's own scale, shows how long that takes. φ is 0 at the goals and positive
//! elsewhere.

use super::oracle::OraclePotential;
use super::{PotentialFit, PotentialInputs, ShapingError};
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// The `negated-oracle` potential. Needs no goal to have been seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NegatedOraclePotential {
    oracle: OraclePotential,
}

impl NegatedOraclePotential {
    /// The opposite of an oracle that has not been told anything.
    pub fn new(scale_factor: f64) -> Self {
        Self {
            oracle: OraclePotential::new(scale_factor),
        }
    }

    /// φ of all states: those without a distance get the highest.
    ///
    /// # Errors
    /// As [`OraclePotential::fit`].
    ///
    /// # Panics
    /// As [`OraclePotential::fit`].
    pub fn fit(&self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError> {
        let mut fit = self.oracle.fit(inputs)?;
        // `0 − φ` rather than `−φ`: goals keep 0.0 instead of −0.0.
        fit.values.iter_mut().for_each(|phi| *phi = 0.0 - *phi);
        Ok(fit)
    }

    /// As [`OraclePotential::set_true_distance`].
    ///
    /// # Panics
    /// If `distance` is negative.
    pub fn set_true_distance(&mut self, state: StateId, distance: f64) {
        self.oracle.set_true_distance(state, distance);
    }
}
