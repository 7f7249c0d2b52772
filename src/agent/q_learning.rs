//! Q-learning (Watkins & Dayan 1992).
//!
//! Q(s, a) ← Q(s, a) + α [R′ + γ max_b Q(s′, b) − Q(s, a)], the max being 0 after termination; behaviour ε-greedy.
//!
//! With reward −1 a step the initial value 0 is optimistic: whatever was tried looks worse than what was not, and the
//! greedy policy explores on its own (Koenig & Simmons 1996: then no more than O(states³) steps to the first goal).
//! With α = 1 it is real-time search on what was seen, and the yardstick to beat in deterministic worlds; under slip
//! choose α below 1.

use super::checks::{check_action_values, check_rate};
use super::greedy::{advised, choose, first_best};
use super::table::ActionTable;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Parameters of [`QLearning`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QLearningParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// α in (0, 1].
    pub learning_rate: f64,
    /// Chance of a random action, 0..=1.
    pub epsilon: f64,
    /// Q of what was never tried.
    pub initial_value: f64,
}

impl Default for QLearningParams {
    fn default() -> Self {
        QLearningParams {
            gamma: 1.0,
            learning_rate: 1.0,
            epsilon: 0.0,
            initial_value: 0.0,
        }
    }
}

impl QLearningParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_rate(self.learning_rate)?;
        check_action_values(self.gamma, self.epsilon, self.initial_value)
    }
}

/// Tabular Q-learning. O(actions) a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QLearning {
    params: QLearningParams,
    mix: f64,
    values: ActionTable,
    rng: ChaCha8Rng,
}

impl QLearning {
    /// An agent that draws from the agent's stream of `seed` and learns from r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: QLearningParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        let values = ActionTable::new(num_actions, params.initial_value);
        QLearning {
            params,
            mix,
            values,
            rng: stream(seed, Stream::Agent),
        }
    }

    /// Q(state, action); the initial value where nothing is known.
    ///
    /// # Panics
    /// If `action` is out of range and the state is known.
    pub fn action_value(&self, state: StateId, action: Action) -> f64 {
        self.values
            .get_row(state)
            .map_or(self.params.initial_value, |row| row[action.index()])
    }
}

impl Agent for QLearning {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.values.grow_to(situation.state);
        choose(
            self.values.row(situation.state),
            situation.advice,
            self.params.epsilon,
            &mut self.rng,
        )
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let next = experience.next.state;
        self.values.grow_to(StateId(next.0.max(experience.state.0)));
        let ahead = experience.continuation() * self.values.max(next);
        let value = &mut self.values.row_mut(experience.state)[experience.action.index()];
        let td_error = experience.shaped_reward(self.mix) + self.params.gamma * ahead - *value;
        *value += self.params.learning_rate * td_error;
        UpdateInfo { td_error }
    }

    fn greedy_action(&self, state: StateId, advice: &[f64]) -> Option<Action> {
        let values = self.values.get_row(state)?;
        first_best(&advised(values, advice))
    }
}
