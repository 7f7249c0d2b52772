//! Dyna-Q with prioritised sweeping (Sutton 1990; Moore & Atkeson 1993).
//!
//! A backup sets Q(s, a) ← Q(s, a) + α [Σ_s′ P̂(s′|s, a) (r̂ + m·F + γ max_b Q(s′, b)) − Q(s, a)] over everything seen to
//! follow from (s, a). After each step the pair just taken is backed up first, then the pairs whose value is most out of
//! date: if max_b Q(s, b) moved by Δ, a pair that leads to s with probability P̂ waits with priority γ P̂ |Δ|.

use super::checks::{check_action_values, check_count, check_rate};
use super::greedy::{action, advised, choose, first_best};
use super::model::EmpiricalModel;
use super::sweep::SweepQueue;
use super::table::ActionTable;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Changes below this are not passed on (relative to rewards of order 1).
const NEGLIGIBLE: f64 = 1e-9;

/// Parameters of [`DynaQ`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DynaQParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// α in (0, 1].
    pub learning_rate: f64,
    /// Chance of a random action, 0..=1.
    pub epsilon: f64,
    /// Q of what was never tried.
    pub initial_value: f64,
    /// Backups after each step, the step's own included; at least 1.
    pub planning_steps: usize,
}

impl Default for DynaQParams {
    fn default() -> Self {
        DynaQParams {
            gamma: 1.0,
            learning_rate: 1.0,
            epsilon: 0.0,
            initial_value: 0.0,
            planning_steps: 50,
        }
    }
}

impl DynaQParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_rate(self.learning_rate)?;
        check_action_values(self.gamma, self.epsilon, self.initial_value)?;
        check_count("planning_steps", self.planning_steps)
    }
}

/// Q-learning that replays what it knows. A step costs at most `planning_steps` backups, each
/// O(outcomes · actions + ways into the state · log of what waits).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DynaQ {
    params: DynaQParams,
    values: ActionTable,
    model: EmpiricalModel,
    /// (state, action) pairs, numbered row by row.
    queue: SweepQueue,
    rng: ChaCha8Rng,
}

impl DynaQ {
    /// An agent that draws from the agent's stream of `seed` and learns from r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: DynaQParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        DynaQ {
            values: ActionTable::new(num_actions, params.initial_value),
            model: EmpiricalModel::new(num_actions, mix),
            queue: SweepQueue::default(),
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

    /// One backup; returns what the pair's value was off by.
    fn back_up(&mut self, state: StateId, action: Action) -> f64 {
        let target = self
            .model
            .action_value(state, action, self.params.gamma, |s| self.values.max(s))
            .expect("only pairs that were tried are backed up");
        let before = self.values.max(state);
        let value = &mut self.values.row_mut(state)[action.index()];
        let td_error = target - *value;
        *value += self.params.learning_rate * td_error;
        let change = (self.values.max(state) - before).abs();
        if change > NEGLIGIBLE && !self.model.is_terminal(state) {
            self.pass_on(state, change);
        }
        td_error
    }

    /// Queues every pair that leads to `state`, whose value has changed.
    fn pass_on(&mut self, state: StateId, change: f64) {
        for way in self.model.ways_into(state) {
            let pair = way.state.index() * self.model.num_actions() + way.action.index();
            self.queue
                .push(pair, self.params.gamma * way.probability * change);
        }
    }
}

impl Agent for DynaQ {
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
        if self.model.record(experience) {
            // The task ends here now, or no longer does: everything that leads here is worth something else.
            self.pass_on(next, self.values.max(next).abs().max(1.0));
        }
        let td_error = self.back_up(experience.state, experience.action);
        for _ in 1..self.params.planning_steps {
            let Some(pair) = self.queue.pop() else { break };
            let num_actions = self.model.num_actions();
            self.back_up(
                StateId((pair / num_actions) as u32),
                action(pair % num_actions),
            );
        }
        UpdateInfo { td_error }
    }

    fn greedy_action(&self, state: StateId, advice: &[f64]) -> Option<Action> {
        let values = self.values.get_row(state)?;
        first_best(&advised(values, advice))
    }
}
