//! Dyna-Q+: Dyna-Q that is drawn to what it has not tried for long (Sutton 1990; Sutton & Barto 2018, section 8.3).
//!
//! After each step Q(s, a) ← Q(s, a) + α [r + γ max_b Q(s′, b) − Q(s, a)], and then `planning_steps` times, for a state in
//! which the agent has acted and an action, both drawn uniformly,
//!
//! Q(s, a) ← Q(s, a) + α [r̃ + κ√τ + γ max_b Q(s̃, b) − Q(s, a)],
//!
//! r̃ and s̃ being what followed when a was last taken in s, and τ the steps since. An action that was never tried in s counts
//! as leading back to s with reward 0 (the book's footnote), since the first step. The model believes the latest it has
//! seen, as the book's does: so it follows a world that changes, and is of little use in one that is left to chance.
//!
//! The book discounts. With γ = 1 bonuses add up for as long as an untried action waits, until it is tried.
//!
//! It is a yardstick: it heeds neither shaping nor advice.

use super::checks::{check_action_values, check_bonus, check_count, check_rate};
use super::greedy::{action, choose, first_best};
use super::table::ActionTable;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::{Action, StepStatus};
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Parameters of [`DynaQPlus`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DynaQPlusParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// α in (0, 1].
    pub learning_rate: f64,
    /// Chance of a random action, 0..=1.
    pub epsilon: f64,
    /// Q of what was never tried, before the first plan.
    pub initial_value: f64,
    /// Backups from the model after each step; at least 1.
    pub planning_steps: usize,
    /// κ, in units of reward; at least 0.
    pub time_bonus: f64,
}

impl Default for DynaQPlusParams {
    fn default() -> Self {
        DynaQPlusParams {
            gamma: 1.0,
            learning_rate: 1.0,
            epsilon: 0.0,
            initial_value: 0.0,
            planning_steps: 50,
            time_bonus: 1e-4,
        }
    }
}

impl DynaQPlusParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_rate(self.learning_rate)?;
        check_action_values(self.gamma, self.epsilon, self.initial_value)?;
        check_count("planning_steps", self.planning_steps)?;
        check_bonus("time_bonus", self.time_bonus)
    }
}

/// What the model knows of one (state, action).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Memory {
    reward: f64,
    next: u32,
    ended: bool,
    /// The step at which it was tried; 0 before.
    tried_at: u64,
}

/// Q-learning that replays what it remembers, the more gladly the longer ago it was. O(planning steps · actions) a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DynaQPlus {
    params: DynaQPlusParams,
    values: ActionTable,
    /// By pair, numbered row by row.
    memories: Vec<Memory>,
    /// States in which the agent has acted, in that order.
    acted_in: Vec<u32>,
    /// By state: whether it is one of those.
    has_acted: Vec<bool>,
    /// Steps so far.
    now: u64,
    no_advice: Vec<f64>,
    rng: ChaCha8Rng,
}

impl DynaQPlus {
    /// An agent that draws from the agent's stream of `seed`.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: DynaQPlusParams, num_actions: usize, seed: u64) -> Self {
        assert!(num_actions > 0, "an agent needs at least one action");
        DynaQPlus {
            values: ActionTable::new(num_actions, params.initial_value),
            memories: Vec::new(),
            acted_in: Vec::new(),
            has_acted: Vec::new(),
            now: 0,
            no_advice: vec![0.0; num_actions],
            rng: stream(seed, Stream::Agent),
            params,
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

    fn num_actions(&self) -> usize {
        self.no_advice.len()
    }

    fn grow_to(&mut self, state: StateId) {
        self.values.grow_to(state);
        for s in self.has_acted.len()..self.values.num_states() {
            let back_to_itself = Memory {
                reward: 0.0,
                next: s as u32,
                ended: false,
                tried_at: 0,
            };
            self.has_acted.push(false);
            self.memories
                .extend(std::iter::repeat_n(back_to_itself, self.no_advice.len()));
        }
    }

    /// Remembers a step. An action out of range panics here.
    fn remember(&mut self, experience: &Experience<'_>) {
        let (state, action) = (experience.state, experience.action.index());
        assert!(action < self.num_actions(), "action out of range");
        self.now += 1;
        let pair = state.index() * self.num_actions() + action;
        self.memories[pair] = Memory {
            reward: experience.reward,
            next: experience.next.state.0,
            ended: experience.status == StepStatus::Terminated,
            tried_at: self.now,
        };
        if !std::mem::replace(&mut self.has_acted[state.index()], true) {
            self.acted_in.push(state.0);
        }
    }

    /// One backup by what is remembered of the pair, with `bonus` on top; returns what its value was off by.
    fn back_up(&mut self, state: StateId, action: Action, bonus: f64) -> f64 {
        let memory = self.memories[state.index() * self.num_actions() + action.index()];
        let ahead = match memory.ended {
            true => 0.0,
            false => self.params.gamma * self.values.max(StateId(memory.next)),
        };
        let value = &mut self.values.row_mut(state)[action.index()];
        let td_error = memory.reward + bonus + ahead - *value;
        *value += self.params.learning_rate * td_error;
        td_error
    }

    /// κ√τ.
    fn bonus(&self, state: StateId, action: Action) -> f64 {
        let memory = self.memories[state.index() * self.num_actions() + action.index()];
        self.params.time_bonus * ((self.now - memory.tried_at) as f64).sqrt()
    }
}

impl Agent for DynaQPlus {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.grow_to(situation.state);
        choose(
            self.values.row(situation.state),
            &self.no_advice,
            self.params.epsilon,
            &mut self.rng,
        )
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        self.grow_to(StateId(experience.next.state.0.max(experience.state.0)));
        self.remember(experience);
        let td_error = self.back_up(experience.state, experience.action, 0.0);
        for _ in 0..self.params.planning_steps {
            let place = self.rng.random_range(0..self.acted_in.len());
            let state = StateId(self.acted_in[place]);
            let action = action(self.rng.random_range(0..self.num_actions()));
            let bonus = self.bonus(state, action);
            self.back_up(state, action, bonus);
        }
        UpdateInfo { td_error }
    }

    fn greedy_action(&self, state: StateId, _advice: &[f64]) -> Option<Action> {
        first_best(self.values.get_row(state)?)
    }
}
