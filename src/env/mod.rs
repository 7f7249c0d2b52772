//! Worlds: what an agent acts in.
//!
//! The contract is that of dm_env and Gymnasium: [`Environment::reset`] begins an episode, each
//! [`Environment::step`] answers with the next state, the reward and how the episode stands. An episode ends in
//! one of two ways that must never be confused: **terminated** (the task is over, nothing can follow: value and
//! potential of what follows are 0) and **truncated** (the clock ran out: the state still has its value).

use std::fmt::Debug;
use std::hash::Hash;

/// The number of an action, `0..num_actions`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Action(pub u16);

impl Action {
    /// The action as an array index.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// How an episode stands after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepStatus {
    /// The episode goes on.
    Running,
    /// The task is over: bootstrap from 0, φ(s′) = 0.
    Terminated,
    /// The step limit was reached: bootstrap from the value of s′, keep φ(s′).
    Truncated,
}

impl StepStatus {
    /// Whether the episode is over, either way.
    pub fn is_last(self) -> bool {
        self != StepStatus::Running
    }
}

/// What an environment answers to an action.
#[derive(Clone, Debug, PartialEq)]
pub struct Step<S> {
    /// The state s′ that was reached.
    pub state: S,
    /// The reward R(s, a, s′).
    pub reward: f64,
    /// How the episode stands.
    pub status: StepStatus,
}

/// An episodic world with finitely many actions over any hashable state.
pub trait Environment {
    /// What identifies a state.
    type State: Clone + Eq + Hash + Debug;

    /// Number of actions, the same in every state; at least 1.
    fn num_actions(&self) -> usize;

    /// Begins an episode and returns its start state. May be called at any time.
    fn reset(&mut self) -> Self::State;

    /// Takes one action.
    ///
    /// # Panics
    /// If the episode is over (or none was begun), or if `action` is out of range.
    fn step(&mut self, action: Action) -> Step<Self::State>;
}
