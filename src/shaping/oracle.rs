//! φ_i = −factor · r̄ · d*_i with the true distance d*, in typical steps: what shaping could do if the map were known.
//!
//! Whoever runs the world tells the distances, state by state as they are discovered, through
//! [`set_true_distance`](OraclePotential::set_true_distance). Only r̄, the cost of a typical step, is observed.

use super::shortest_path::ShortestPathProblem;
use super::told::ToldNumbers;
use super::{PotentialFit, PotentialInputs, ShapingError};
use crate::graph::StateId;
use serde::{Deserialize, Serialize};

/// The `oracle` potential. Needs no goal to have been seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OraclePotential {
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
    /// d*; none where nobody told it, or no goal can be reached.
    distances: ToldNumbers,
}

impl OraclePotential {
    /// An oracle that has not been told anything.
    pub fn new(scale_factor: f64) -> Self {
        Self {
            scale_factor,
            distances: ToldNumbers::default(),
        }
    }

    /// φ of all states. Those without a distance get the lowest φ of those that have one; goals need none, their distance is 0. (A goal is
    /// often discovered by the step that asks for this fit, before anybody could tell.)
    ///
    /// # Errors
    /// If a mean reward or a result is not finite.
    ///
    /// # Panics
    /// As [`AnyPotential::fit`](super::AnyPotential::fit).
    pub fn fit(&self, inputs: &PotentialInputs<'_>) -> Result<PotentialFit, ShapingError> {
        let per_step = -self.scale_factor * ShortestPathProblem::observed(inputs)?.step_reward;
        let n = inputs.adjacency.num_nodes();
        let phi = |i: usize| self.distances.get(i).map(|d| 0.0 + per_step * d);
        let lowest = (0..n).filter_map(phi).fold(0.0, f64::min);
        let mut values: Vec<f64> = (0..n).map(|i| phi(i).unwrap_or(lowest)).collect();
        for goal in inputs.goals {
            values[goal.state.index()] = 0.0;
        }
        PotentialFit::checked(values)
    }

    /// Tells the true distance (in typical steps) from `state` to the goal. One that is not finite means that no goal can be reached.
    ///
    /// # Panics
    /// If `distance` is negative.
    pub fn set_true_distance(&mut self, state: StateId, distance: f64) {
        assert!(
            distance >= 0.0 || distance.is_nan(),
            "distance {distance} of {state:?}"
        );
        self.distances.tell(state, distance);
    }
}
