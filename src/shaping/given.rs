//! φ_i as somebody gave it, in units of return: 0 where nothing was given, and at known goals.
//!
//! Whoever runs the world tells φ, state by state as they are discovered, through
//! [`set_value`](GivenPotential::set_value). Nothing is shifted or scaled.

use super::told::ToldNumbers;
use super::{PotentialFit, PotentialInputs, ShapingError};
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// The `file` potential. Needs no goal to have been seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GivenPotential {
    told: ToldNumbers,
}

impl GivenPotential {
    /// φ of all states.
    ///
    /// # Errors
    /// None: what is not finite is not taken down.
    ///
    /// # Panics
    /// If a goal is out of range.
    pub fn fit(&self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError> {
        let states = 0..inputs.adjacency.num_nodes();
        let mut values: Vec<f64> = states.map(|i| self.told.get(i).unwrap_or(0.0)).collect();
        for goal in inputs.goals {
            values[goal.state.index()] = 0.0;
        }
        PotentialFit::checked(values)
    }

    /// Tells φ of `state`. One that is not finite says that none was given.
    pub fn set_value(&mut self, state: StateId, phi: f64) {
        self.told.tell(state, phi);
    }
}
