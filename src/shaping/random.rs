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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::StateId;
    use crate::shaping::fixtures::{on_problem, path};
    use crate::shaping::shortest_path::ShortestPathProblem;
    use crate::shaping::transition_matrix::TransitionMatrix;

    fn fit(potential: &mut RandomPotential, n: usize, goal: u32) -> Vec<f64> {
        let adjacency = path(n);
        let transitions = TransitionMatrix::undirected(&adjacency);
        let problem = ShortestPathProblem::uniform(&transitions, &[StateId(goal)]);
        on_problem(&adjacency, &problem, |context| {
            potential.fit_in(context).unwrap().values
        })
    }

    #[test]
    fn a_state_keeps_its_number_however_often_and_on_what_it_is_fitted() {
        let mut grown = RandomPotential::new(2.0, 7);
        assert_eq!(fit(&mut grown, 1, 0), [0.0], "no way yet, hence no scale");
        let first = fit(&mut grown, 40, 0);
        let grown_on = fit(&mut grown, 90, 0);
        assert_eq!(first[..], grown_on[..40]);
        assert!(grown_on.iter().all(|phi| (-2.0 * 39.0..=0.0).contains(phi)));
        let moved = fit(&mut grown, 90, 5);
        assert_eq!((moved[5], &moved[6..]), (0.0, &grown_on[6..]));
        let lost = moved[0];
        assert!(lost < 0.0 && moved[1..5] == grown_on[1..5]);
        let mut other = RandomPotential::new(2.0, 8);
        assert_ne!(fit(&mut other, 40, 0), first);
        let mut again = RandomPotential::new(2.0, 7);
        assert_eq!(fit(&mut again, 40, 0), first);
    }

    /// The distance of Kolmogorov and Smirnov from the uniform distribution; beyond 1.95/√n once in a thousand seeds.
    #[test]
    fn numbers_are_uniform_on_the_range_of_hops() {
        let n = 4000;
        let mut phi = fit(&mut RandomPotential::new(0.5, 3), n, 0).split_off(1);
        phi.sort_by(f64::total_cmp);
        let range = 0.5 * (n - 1) as f64;
        let count = phi.len() as f64;
        let off = phi
            .iter()
            .zip(1..)
            .map(|(phi, rank)| (1.0 + phi / range - f64::from(rank) / count).abs());
        assert!(off.fold(0.0, f64::max) < 1.95 / count.sqrt());
    }
}
