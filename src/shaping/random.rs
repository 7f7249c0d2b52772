//! φ_i = −factor · r̄ · E · x_i with x_i drawn once for each state, uniform on [0, 1): what the scale of φ does by itself.
//!
//! x_i is the number at place i of a random stream of its own, so it depends on the seed and on the state's number, not on how
//! often or on what φ was fitted. r̄ E, the cost of the longest known way, is taken from the first fit that knows a way and
//! kept: each state has one φ all through the run. The range is then that of [`hops`](super::hops) at that moment. φ is 0 at
//! known goals; a goal that is lost gets what it drew.

use super::fit_context::{FitContext, GraphPotential};
use super::{PotentialFit, ShapingError};
use crate::seeds::{Stream, stream};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// The `random` potential.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RandomPotential {
    /// Range of φ ÷ cost of the longest known way.
    pub scale_factor: f64,
    seed: u64,
    /// factor · r̄ · E of the first fit that knew a way.
    range: Option<f64>,
}

impl RandomPotential {
    /// A potential that draws from `seed`.
    pub fn new(scale_factor: f64, seed: u64) -> Self {
        Self {
            scale_factor,
            seed,
            range: None,
        }
    }
}

impl GraphPotential for RandomPotential {
    /// φ is 0 while no way is known.
    fn fit_in(&mut self, context: &FitContext<'_>) -> Result<PotentialFit, ShapingError> {
        let problem = context.problem;
        let now = self.scale_factor * problem.step_reward * problem.eccentricity();
        self.range = self.range.or((now > 0.0).then_some(now));
        let range = self.range.unwrap_or(0.0);
        let mut rng = stream(self.seed, Stream::Potential);
        let draw = |_| 0.0 - range * rng.random::<f64>();
        let mut values: Vec<f64> = (0..context.adjacency.num_nodes()).map(draw).collect();
        for &goal in &problem.chain.order()[..problem.chain.num_goals()] {
            values[goal as usize] = 0.0;
        }
        PotentialFit::checked(values)
    }
}
