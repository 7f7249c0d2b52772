//! Policy iteration on the approximated MDP, with the shaped reward (contribution 6 of the source paper).
//!
//! On the model of what was seen so far, in turns until the policy stays the same:
//!
//! - evaluate: V(s) ← Q(s, π(s)) for every state, newest first, at most `evaluation_sweeps` times;
//! - improve: π(s) ← argmax_a Q(s, a);
//!
//! Q(s, a) = Σ_s′ P̂(s′|s, a) (r̂ + m·F + γ V(s′)), the initial value where a was never tried, V = 0 at terminal states.
//!
//! Evaluation stops early because with γ = 1 a policy that goes in circles has no finite value (modified policy
//! iteration, Puterman & Shin 1978); it starts from the values before. F is the latest seen on each transition: after
//! a potential was re-fitted, old and new ones may add up to a gain around a circle, which going round it once corrects.
//!
//! It plans at the end of each episode and every `plan_every` steps. In between only the state just left is backed up,
//! so that the agent does not turn in circles among states that it has used up. It acts ε-greedily on Q + advice.

use super::checks::{check_action_values, check_count};
use super::greedy::{action, choose, first_best};
use super::model::EmpiricalModel;
use super::table::largest;
use super::{Agent, Experience, Situation, UpdateInfo};
use crate::env::Action;
use crate::graph::StateId;
use crate::parameter::ParameterError;
use crate::seeds::{Stream, stream};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Evaluation is over when no value changes by more, and nothing better by less is an improvement.
const NEGLIGIBLE: f64 = 1e-6;
/// Improvements of one plan; a handful is usual, circles of gain (see above) would never end.
const MAX_IMPROVEMENTS: usize = 100;

/// Parameters of [`PolicyIteration`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyIterationParams {
    /// Discount factor, 0..=1.
    pub gamma: f64,
    /// Chance of a random action, 0..=1.
    pub epsilon: f64,
    /// Value of an action that was never tried.
    pub initial_value: f64,
    /// Steps between plans, besides those at the end of each episode; 0 = only there.
    pub plan_every: u64,
    /// Sweeps of one evaluation, at least 1.
    pub evaluation_sweeps: usize,
}

impl Default for PolicyIterationParams {
    fn default() -> Self {
        PolicyIterationParams {
            gamma: 1.0,
            epsilon: 0.05,
            initial_value: 0.0,
            plan_every: 100,
            evaluation_sweeps: 20,
        }
    }
}

impl PolicyIterationParams {
    /// Checks the ranges.
    ///
    /// # Errors
    /// The first parameter out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        check_action_values(self.gamma, self.epsilon, self.initial_value)?;
        check_count("evaluation_sweeps", self.evaluation_sweeps)
    }
}

/// Learns a model, and now and then the best policy for it. A plan costs O(states · actions) a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyIteration {
    params: PolicyIterationParams,
    model: EmpiricalModel,
    /// V.
    values: Vec<f64>,
    /// π.
    policy: Vec<u16>,
    steps_since_plan: u64,
    /// Room for one number per action.
    buffer: Vec<f64>,
    rng: ChaCha8Rng,
}

impl PolicyIteration {
    /// An agent that draws from the agent's stream of `seed` and learns from r + `mix` · F.
    ///
    /// # Panics
    /// If there are no actions.
    pub fn new(params: PolicyIterationParams, num_actions: usize, mix: f64, seed: u64) -> Self {
        PolicyIteration {
            params,
            model: EmpiricalModel::new(num_actions, mix),
            values: Vec::new(),
            policy: Vec::new(),
            steps_since_plan: 0,
            buffer: vec![0.0; num_actions],
            rng: stream(seed, Stream::Agent),
        }
    }

    /// V(state) by the latest plan; `None` for states it has not heard of.
    pub fn value(&self, state: StateId) -> Option<f64> {
        self.values.get(state.index()).copied()
    }

    fn grow_to(&mut self, state: StateId) {
        self.model.grow_to(state);
        if state.index() >= self.values.len() {
            self.values
                .resize(state.index() + 1, self.params.initial_value);
            self.policy.resize(state.index() + 1, 0);
        }
    }

    fn action_value(&self, state: StateId, action: Action) -> f64 {
        self.model
            .action_value(state, action, self.params.gamma, |s| self.values[s.index()])
            .unwrap_or(self.params.initial_value)
    }

    /// Writes Q(state, ·) into `buffer`.
    fn action_values(&mut self, state: StateId) {
        let mut buffer = std::mem::take(&mut self.buffer);
        for (a, value) in buffer.iter_mut().enumerate() {
            *value = self.action_value(state, action(a));
        }
        self.buffer = buffer;
    }

    /// Evaluates and improves in turns.
    fn plan(&mut self) {
        self.steps_since_plan = 0;
        for _ in 0..MAX_IMPROVEMENTS {
            self.evaluate();
            if !self.improve() {
                break;
            }
        }
    }

    fn evaluate(&mut self) {
        for _ in 0..self.params.evaluation_sweeps {
            let mut largest_change = 0f64;
            for s in (0..self.values.len()).rev() {
                let value = self.action_value(StateId(s as u32), Action(self.policy[s]));
                let change = value - std::mem::replace(&mut self.values[s], value);
                largest_change = largest_change.max(change.abs());
            }
            if largest_change <= NEGLIGIBLE {
                break;
            }
        }
    }

    /// Makes the policy greedy; true if it changed. An action keeps its place against others that are no better.
    fn improve(&mut self) -> bool {
        let mut changed = false;
        for s in 0..self.values.len() {
            self.action_values(StateId(s as u32));
            let best = largest(&self.buffer);
            if self.buffer[usize::from(self.policy[s])] < best - NEGLIGIBLE {
                self.policy[s] = first_best(&self.buffer)
                    .expect("one value is the largest")
                    .0;
                changed = true;
            }
        }
        changed
    }
}

impl Agent for PolicyIteration {
    fn select_action(&mut self, situation: Situation<'_>) -> Action {
        self.grow_to(situation.state);
        self.action_values(situation.state);
        choose(
            &self.buffer,
            situation.advice,
            self.params.epsilon,
            &mut self.rng,
        )
    }

    fn update(&mut self, experience: &Experience<'_>) -> UpdateInfo {
        let state = experience.state;
        self.grow_to(StateId(state.0.max(experience.next.state.0)));
        self.model.record(experience);
        self.action_values(state);
        let best = largest(&self.buffer);
        let td_error = best - std::mem::replace(&mut self.values[state.index()], best);
        self.steps_since_plan += 1;
        let due = self.params.plan_every > 0 && self.steps_since_plan >= self.params.plan_every;
        if due || experience.status.is_last() {
            self.plan();
        }
        UpdateInfo { td_error }
    }

    fn greedy_action(&self, state: StateId, _advice: &[f64]) -> Option<Action> {
        self.policy.get(state.index()).map(|&a| Action(a))
    }
}
