//! SARSA and expected SARSA (Sutton & Barto 2018, sections 6.4 and 6.6).
//!
//! Q(s, a) ← Q(s, a) + α [R′ + γ Q(s′, a′) − Q(s, a)] with a′ drawn from the ε-greedy policy at s′ and taken next, or
//! with Σ_b π(b|s′) Q(s′, b) in its place. Advice bends π in both.

use super::checks::{check_action_values, check_rate};
use super::choices::Bootstrap;
use super::greedy::{advised, choose, expectation, first_best};
use super::table::ActionTable;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Parameters of [`Sarsa`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SarsaParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// α in (0, 1].
    pub learning_rate: f64,
    /// Chance of a random action, 0..=1.
    pub epsilon: f64,
    /// Q of what was never tried.
    pub initial_value: f64,
    /// How the value of s′ is estimated.
    pub bootstrap: Bootstrap,
}

impl Default for SarsaParams {
    fn default() -> Self {
        SarsaParams {
            gamma: 1.0,
            learning_rate: 0.5,
            epsilon: 0.05,
            initial_value: 0.0,
            bootstrap: Bootstrap::Expected,
        }
    }
}

impl SarsaParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_rate(self.learning_rate)?;
        check_action_values(self.gamma, self.epsilon, self.initial_value)
    }
}

/// Tabular SARSA. O(actions) a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sarsa {
    params: SarsaParams,
    mix: f64,
    values: ActionTable,
    /// (s′, a′): the action already drawn, and the state for which it was.
    drawn: Option<(u32, u16)>,
    rng: ChaCha8Rng,
}

impl Sarsa {
    /// An agent that draws from the agent's stream of `seed` and learns from r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: SarsaParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        let values = ActionTable::new(num_actions, params.initial_value);
        Sarsa {
            params,
            mix,
            values,
            drawn: None,
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

    /// The estimate of the value of s′; draws a′ if that is how it is estimated.
    fn look_ahead(&mut self, next: Situation<'_>) -> f64 {
        let row = self.values.row(next.state);
        match self.params.bootstrap {
            Bootstrap::Sampled => {
                let next_action = choose(row, next.advice, self.params.epsilon, &mut self.rng);
                self.drawn = Some((next.state.0, next_action.0));
                row[next_action.index()]
            }
            Bootstrap::Expected => expectation(row, next.advice, self.params.epsilon),
        }
    }
}

impl Agent for Sarsa {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        match self.drawn.take() {
            Some((state, action)) if state == situation.state.0 => Action(action),
            _ => {
                self.values.grow_to(situation.state);
                choose(
                    self.values.row(situation.state),
                    situation.advice,
                    self.params.epsilon,
                    &mut self.rng,
                )
            }
        }
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let next = experience.next;
        self.values
            .grow_to(StateId(next.state.0.max(experience.state.0)));
        let ahead = if experience.continuation() > 0.0 {
            self.look_ahead(next)
        } else {
            0.0
        };
        if experience.status.is_last() {
            self.drawn = None;
        }
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
