//! The learnt model that potentials are returns on: frequencies and mean rewards of all that was seen.
//!
//! ```text
//! Q(s, a) = r̂(s, a) + g Σ_s′ P̂(s′|s, a) V(s′),   V = 0 after an end, whatever it paid,   g = γ (1 − 1 / 10 n)
//! ```
//!
//! The choices of a state are its tried actions, and what may be hoped of the others:
//!
//! - **An action that may stay** counts as taken until it leaves: (r̂ + g Σ_{s′≠s} P̂ V) / (1 − g P̂(s|s, a)). Waiting costs what it costs. One that
//!   only ever stayed tells that it is useless, not that the place is dear, and is left out, unless it pays or nothing else is known.
//! - **Untried actions**, once a goal is known, may take every step back by which the state was entered, at the reward of that step.
//!   While none is known, they lead to something that is worth 0, as much as not to have lost anything: with bad ends alone on the map φ keeps away
//!   from them and rises to where there is something left to try.
//!
//! **Loops that pay for ever** have a return all the same: episodes are taken to end by themselves, after 10 n steps on average, ten times as long
//! as any way among the n states that crosses itself nowhere.
//!
//! **r̄, the unit of step costs**, is the median size of the rewards, other than 0, of choices that end nothing; where steps are free, the largest reward of an
//! end, spread over the longest way to one.

use super::ShapingError;
use super::decision_process::{Choices, DecisionProcess};
use super::label_setting::settling_order;
use super::shortest_path::median;
use super::soft_bellman::SoftBellman;
use crate::graph::{ObservedOutcome, StateId, SymmetricCsr, TransitionGraph};

/// Episodes are reckoned so many times as long as the states are many.
const LONG_EPISODES: f64 = 10.0;

/// A decision process on the visited world, and the unit of its rewards.
#[derive(Clone, Debug)]
pub struct LearntModel {
    /// Choices of the states in which no episode ends.
    pub process: DecisionProcess,
    /// r̄ > 0.
    pub step_reward: f64,
}

impl LearntModel {
    /// The model of a world as far as it was observed: episodes end in the states that `ends` says (shorter if the last ones are none), and
    /// a goal is known or not. O((n + transitions) log n).
    ///
    /// # Errors
    /// If a mean reward is not finite.
    pub fn observed(
        graph: &TransitionGraph,
        ends: &[bool],
        goal_known: bool,
        gamma: f64,
    ) -> Result<Self, ShapingError> {
        let n = graph.num_states();
        let is_end = |state: StateId| ends.get(state.index()).copied().unwrap_or(false);
        let ways_in = mean_rewards_into(graph);
        let mut model = Writer {
            g: discount(gamma, n),
            ..Writer::default()
        };
        let mut seen = Vec::new();
        for state in (0..n as u32).map(StateId) {
            if !is_end(state) {
                seen.clear();
                seen.extend(graph.outcomes(state));
                let best_stay = model.write_tried(state, &mut seen, &is_end)?;
                if graph.untried_actions(state) > 0 && goal_known {
                    let tried = |next: StateId| seen.iter().any(|outcome| outcome.next == next);
                    let neighbors = graph.adjacency().neighbors(state.0).iter();
                    let back = neighbors.filter(|&&j| !is_end(StateId(j)) && !tried(StateId(j)));
                    model.write_ways_back(back.copied(), ways_in[state.index()]);
                }
                if graph.untried_actions(state) > 0 && !goal_known {
                    model.choices.push(0.0, 1.0, true, []);
                }
                model.write_staying(best_stay);
                if model.choices.pending() == 0 {
                    model.choices.push(0.0, 1.0, true, []);
                }
            }
            model.choices.end_state();
        }
        Ok(model.finish())
    }

    /// The model of a bare graph: each step costs 1, goals end episodes. An edge is a choice, a priori as likely as it weighs. Nodes that lead
    /// to no goal can only stay. O((n + nnz) log n).
    ///
    /// # Panics
    /// If a goal is out of range.
    pub fn uniform(adjacency: &SymmetricCsr, goals: &[StateId]) -> Self {
        let n = adjacency.num_nodes();
        let mut ends = vec![false; n];
        goals.iter().for_each(|goal| ends[goal.index()] = true);
        let mut model = Writer {
            g: discount(1.0, n),
            costs: vec![1.0],
            ..Writer::default()
        };
        for i in 0..n {
            if !ends[i] {
                let (columns, weights) = adjacency.row(i);
                let edges = columns
                    .iter()
                    .zip(weights)
                    .filter(|(j, _)| **j as usize != i);
                for (&j, &weight) in edges {
                    let end = ends[j as usize];
                    let on = (!end).then_some((j, model.g));
                    model.choices.push(-1.0, weight, end, on);
                }
                if model.choices.pending() == 0 {
                    model.choices.push(-1.0 / (1.0 - model.g), 1.0, false, []);
                }
            }
            model.choices.end_state();
        }
        model.finish()
    }

    /// Returns-to-go of the best policy, of the states from which an end can be reached, ascending by state. A solve at temperature 0.
    pub fn optimal_returns(&self) -> Vec<(StateId, f64)> {
        let model = self.settled(0.0);
        let mut solver = SoftBellman::new(&model.process);
        let (v, _) = solver.solve_cold(&model.temperatures(0.0), model.tolerance());
        let reached = model.process.order()[..model.process.num_reached()].iter();
        let mut returns: Vec<_> = reached.map(|&state| StateId(state)).zip(v).collect();
        returns.sort_unstable_by_key(|&(state, _)| state);
        returns
    }

    /// The same model, its process rearranged so that sweeps at temperatures `tau` (by position) carry news as far as they can. O((n + outcomes) log n).
    ///
    /// # Panics
    /// If `tau` has not one entry per position.
    pub fn settled_at(&self, tau: &[f64]) -> Self {
        Self {
            process: self.process.rearranged(&settling_order(&self.process, tau)),
            ..*self
        }
    }

    /// The same at `tau` typical steps everywhere.
    pub fn settled(&self, tau: f64) -> Self {
        self.settled_at(&self.temperatures(tau))
    }

    /// Temperatures by position: `tau` typical steps everywhere.
    pub fn temperatures(&self, tau: f64) -> Vec<f64> {
        vec![tau * self.step_reward; self.process.len()]
    }

    /// Residual at which a V is final, in units of return: next to nothing beside a step.
    pub fn tolerance(&self) -> f64 {
        1e-5 * self.step_reward
    }
}

/// g.
fn discount(gamma: f64, states: usize) -> f64 {
    gamma * (1.0 - 1.0 / (LONG_EPISODES * states.max(1) as f64))
}

/// Choices while they are written down.
#[derive(Default)]
struct Writer {
    choices: Choices,
    g: f64,
    /// Sizes, other than 0, of rewards of choices that end nothing.
    costs: Vec<f64>,
    largest_end: f64,
}

impl Writer {
    /// Adds the tried actions of `state`, `seen` of them, that may leave it. Returns what the best of the others pays for ever, −∞ without one.
    fn write_tried(
        &mut self,
        state: StateId,
        seen: &mut [ObservedOutcome],
        is_end: &impl Fn(StateId) -> bool,
    ) -> Result<f64, ShapingError> {
        seen.sort_by_key(|outcome| (outcome.action, outcome.next));
        let mut best_stay = f64::NEG_INFINITY;
        for outcomes in seen.chunk_by(|a, b| a.action == b.action) {
            let tries: f64 = outcomes.iter().map(|o| f64::from(o.count)).sum();
            let reward = outcomes.iter().map(|o| o.reward_sum).sum::<f64>() / tries;
            if !reward.is_finite() {
                let (state, value) = (state.index(), reward);
                return Err(ShapingError::Reward { state, value });
            }
            let chance = |o: &ObservedOutcome| f64::from(o.count) / tries;
            let stays: f64 = outcomes
                .iter()
                .filter(|o| o.next == state)
                .map(chance)
                .sum();
            if stays == 1.0 {
                best_stay = best_stay.max(reward / (1.0 - self.g));
                continue;
            }
            let goes_on = 1.0 - self.g * stays;
            let may_end = outcomes.iter().any(|o| is_end(o.next));
            self.note(reward, may_end);
            let g = self.g;
            let on = outcomes
                .iter()
                .filter(|o| o.next != state && !is_end(o.next));
            let on = on.map(|o| (o.next.0, g * chance(o) / goes_on));
            self.choices.push(reward / goes_on, 1.0, may_end, on);
        }
        Ok(best_stay)
    }

    /// Adds staying for ever, if that pays or is the only choice.
    fn write_staying(&mut self, worth: f64) {
        if worth > 0.0 || (worth.is_finite() && self.choices.pending() == 0) {
            self.choices.push(worth, 1.0, worth > 0.0, []);
        }
    }

    fn write_ways_back(&mut self, back: impl Iterator<Item = u32>, reward: f64) {
        for j in back {
            self.choices.push(reward, 1.0, false, [(j, self.g)]);
        }
    }

    fn note(&mut self, reward: f64, may_end: bool) {
        if may_end {
            self.largest_end = self.largest_end.max(reward.abs());
        } else if reward != 0.0 {
            self.costs.push(reward.abs());
        }
    }

    fn finish(mut self) -> LearntModel {
        if let Some(step_reward) = median(&mut self.costs) {
            let process = DecisionProcess::new(&self.choices, step_reward);
            return LearntModel {
                process,
                step_reward,
            };
        }
        let process = DecisionProcess::new(&self.choices, f64::INFINITY);
        let longest = process.distances().last().copied().unwrap_or(1.0);
        let step_reward = match self.largest_end > 0.0 {
            true => self.largest_end / longest,
            false => 1.0,
        };
        LearntModel {
            process,
            step_reward,
        }
    }
}

/// By state: the mean of what the steps paid that led into it from elsewhere; 0 if there were none.
fn mean_rewards_into(graph: &TransitionGraph) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); graph.num_states()];
    for state in (0..graph.num_states() as u32).map(StateId) {
        for outcome in graph.outcomes(state).filter(|o| o.next != state) {
            let (reward, count) = &mut sums[outcome.next.index()];
            *reward += outcome.reward_sum;
            *count += f64::from(outcome.count);
        }
    }
    let mean = |(reward, count): (f64, f64)| if count > 0.0 { reward / count } else { 0.0 };
    sums.into_iter().map(mean).collect()
}

#[cfg(test)]
mod tests;
