//! The stochastic shortest-path problem of the visited world: moves, step costs, goals, and the scale of the return.
//!
//! ```text
//! c_i = |mean reward of a step from i| / r̄        local cost in typical steps;  r̄ = median of those that are not 0
//! D_g = (R_max − R_g) / r̄                          what ending at goal g forgoes, in typical steps
//! d_i = c_i + min_j d_j,   d_g = D_g              cost-to-go;   E = max_i d_i, the eccentricity
//! φ_i = −factor · r̄ · E · (v_i − min_g v_g) / (max_i v_i − min_g v_g)
//! ```
//!
//! for any v that grows with the distance to the goal. φ is 0 at the best goal, negative elsewhere, and reaches
//! −factor times the cost of the longest known way: range(φ) against the reward of a step is what decides whether
//! shaping does anything at all. Goals of less reward lie below the best one. States that can reach no goal over the
//! moves known so far get the lowest value of those that can.
//!
//! **Worlds without step costs** (r̄ = 0): steps cost 1 each in units of r̄ = max_g |R_g| / E, so that the range of φ
//! is `factor` times the largest goal reward; without any reward, r̄ = 1.

use super::absorbing_chain::AbsorbingChain;
use super::cost_to_go::{CostToGo, cost_to_go};
use super::transition_matrix::TransitionMatrix;
use super::{Goal, PotentialInputs, ShapingError};
use crate::graph::{StateId, TransitionGraph};

/// Lowest and highest local cost in typical steps. The floor keeps the diffusion's cost, and with it the maximum
/// principle, well above the solver's tolerance; the ceiling keeps one dreadful cell from flattening φ elsewhere.
const COST_RANGE: (f64, f64) = (0.05, 20.0);

/// A v that rises by less than this is flat: stretching it to the return would only amplify rounding.
const MIN_RISE: f64 = 1e-9;

/// A shortest-path problem on the visited world. Vectors are by position of the chain.
#[derive(Clone, Debug)]
pub struct ShortestPathProblem {
    /// Moves among the states that can reach a goal.
    pub chain: AbsorbingChain,
    /// c_i, in typical steps; 0.05 to 20.
    pub costs: Vec<f64>,
    /// d_i, in typical steps.
    pub distances: Vec<f64>,
    /// r̄: what a typical step costs, in units of reward; positive.
    pub step_reward: f64,
}

impl ShortestPathProblem {
    /// The problem of a world as far as it was observed. O((n + transitions) log n).
    ///
    /// # Errors
    /// If a mean reward is not finite.
    ///
    /// # Panics
    /// If the adjacency does not belong to the graph, or a goal is out of range.
    pub fn observed(inputs: &PotentialInputs<'_>) -> Result<Self, ShapingError> {
        let transitions = TransitionMatrix::observed(inputs.graph, inputs.adjacency);
        let (costs, typical) = observed_costs(inputs.graph)?;
        if let Some(bad) = inputs.goals.iter().find(|g| !g.reward.is_finite()) {
            return Err(ShapingError::Reward {
                state: bad.state.index(),
                value: bad.reward,
            });
        }
        Ok(Self::assemble(&transitions, &costs, typical, inputs.goals))
    }

    /// The problem of a bare graph: every step costs 1, all goals are worth the same.
    ///
    /// # Panics
    /// If a goal is out of range.
    pub fn uniform(transitions: &TransitionMatrix, goals: &[StateId]) -> Self {
        let goals: Vec<Goal> = goals
            .iter()
            .map(|&state| Goal { state, reward: 0.0 })
            .collect();
        Self::assemble(
            transitions,
            &vec![1.0; transitions.num_states()],
            Some(1.0),
            &goals,
        )
    }

    fn assemble(
        transitions: &TransitionMatrix,
        costs: &[f64],
        typical: Option<f64>,
        goals: &[Goal],
    ) -> Self {
        let states: Vec<u32> = goals.iter().map(|g| g.state.0).collect();
        let reach = |step_reward: f64| {
            let terminal = forgone(goals, step_reward);
            cost_to_go(transitions, costs, &states, &terminal)
        };
        let step_reward = typical.unwrap_or_else(|| {
            let largest = goals.iter().map(|g| g.reward.abs()).fold(0.0, f64::max);
            // Infinite step cost: rewards forgone count nothing, plain distances come out.
            let farthest = farthest(&reach(f64::INFINITY), goals.len());
            if largest > 0.0 {
                largest / farthest.max(1.0)
            } else {
                1.0
            }
        });
        let CostToGo { distance, order } = reach(step_reward);
        let chain = AbsorbingChain::new(transitions, order, goals.len());
        Self {
            costs: chain.gather(costs),
            distances: chain.gather(&distance),
            step_reward,
            chain,
        }
    }

    /// E: the largest cost-to-go of a state that is no goal, in typical steps; 0 if there is none.
    pub fn eccentricity(&self) -> f64 {
        self.past_goals(&self.distances)
            .iter()
            .copied()
            .fold(0.0, f64::max)
    }

    /// D_g, in typical steps: 0 for the best goal.
    pub fn forgone(&self) -> &[f64] {
        &self.distances[..self.chain.num_goals()]
    }

    /// The entries of states that are no goals.
    pub fn past_goals<'v>(&self, by_position: &'v [f64]) -> &'v [f64] {
        &by_position[self.chain.num_goals()..]
    }

    /// How much `v` rises from the best goal to the state with the largest v.
    pub fn rise(&self, v: &[f64]) -> f64 {
        let (goals, others) = v.split_at(self.chain.num_goals());
        let best = goals.iter().copied().fold(f64::INFINITY, f64::min);
        others.iter().copied().fold(best, f64::max) - best
    }

    /// φ by state number, from `v` by position: shifted to 0 at the best goal, scaled to `factor` times the cost of
    /// the longest known way. Without goals, 0 everywhere.
    ///
    /// # Panics
    /// If `v` has not one entry per position.
    pub fn potential(&self, v: &[f64], factor: f64) -> Vec<f64> {
        assert_eq!(v.len(), self.chain.len(), "one value per position");
        let rise = self.rise(v);
        let scale = factor * self.step_reward * self.eccentricity();
        let per_unit = if rise > MIN_RISE { scale / rise } else { 0.0 };
        self.falling(v, per_unit)
    }

    /// φ by state number that falls by `per_unit` for each unit of `v`, from 0 at the best goal. States that reach no goal get
    /// the lowest φ of those that do.
    ///
    /// # Panics
    /// If `v` has not one entry per position.
    pub(crate) fn falling(&self, v: &[f64], per_unit: f64) -> Vec<f64> {
        assert_eq!(v.len(), self.chain.len(), "one value per position");
        let best = v[..self.chain.num_goals()]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        // `best − v` rather than `−(v − best)`: the best goal gets 0.0, not −0.0.
        let phi: Vec<f64> = v.iter().map(|&v| per_unit * (best - v)).collect();
        let lowest = self.past_goals(&phi).iter().copied().fold(0.0, f64::min);
        self.chain.scatter(&phi, lowest)
    }
}

fn forgone(goals: &[Goal], step_reward: f64) -> Vec<f64> {
    let best = goals
        .iter()
        .map(|g| g.reward)
        .fold(f64::NEG_INFINITY, f64::max);
    goals
        .iter()
        .map(|g| (best - g.reward) / step_reward)
        .collect()
}

fn farthest(reach: &CostToGo, num_goals: usize) -> f64 {
    let others = reach.order[num_goals..]
        .iter()
        .map(|&s| reach.distance[s as usize]);
    others.fold(0.0, f64::max)
}

/// c by state, and r̄ if steps cost anything. Steps that ended an episode are left out, because their reward
/// belongs to the goal; so are self-transitions, as in P.
fn observed_costs(graph: &TransitionGraph) -> Result<(Vec<f64>, Option<f64>), ShapingError> {
    let mut seen = Vec::new();
    let mut costs = vec![f64::NAN; graph.num_states()];
    for (i, cost) in costs.iter_mut().enumerate() {
        let state = StateId(i as u32);
        let steps = graph
            .outcomes(state)
            .filter(|o| !o.terminal && o.next != state);
        let (sum, count) = steps.fold((0.0, 0.0), |(sum, count), o| {
            (sum + o.reward_sum, count + f64::from(o.count))
        });
        if count > 0.0 {
            let value = sum / count;
            if !value.is_finite() {
                return Err(ShapingError::Reward { state: i, value });
            }
            *cost = value.abs();
            if value != 0.0 {
                seen.push(value.abs());
            }
        }
    }
    let typical = median(&mut seen);
    for cost in &mut costs {
        let relative = typical.map_or(1.0, |typical| *cost / typical);
        let known = if relative.is_nan() { 1.0 } else { relative };
        *cost = known.clamp(COST_RANGE.0, COST_RANGE.1);
    }
    Ok((costs, typical))
}

/// The lower median.
pub(super) fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = (values.len() - 1) / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
